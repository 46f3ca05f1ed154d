"""Algorithm 2 line by line: information trackers, their flags, and the switches `deprecation` and `loss_handling`."""

from __future__ import annotations

import pytest

from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker, update_information_trackers
from swarmproof.dmpc_swarm.protocol.messages import (
    HOVERING,
    CuMessage,
    EmptyMessage,
    Metadata,
    Trajectory,
    TrajectoryMessage,
    TrajectoryRequestMessage,
    UavMessage,
)
from swarmproof.dmpc_swarm.semantics import Semantics

PRINTED = Semantics.parse("printed")
PROSE = Semantics.parse("prose")
IGNORE = Semantics.parse("ignore-loss")
A, B, C = (Trajectory(Metadata(k, cu)) for k, cu in ((3, 0), (4, 0), (4, 1)))
EMPTY = EmptyMessage()
#: What two CUs send when they have nothing to say.
QUIET: dict[int, CuMessage] = {0: EMPTY, 1: EMPTY}


def valid(*trajectories: Trajectory) -> InformationTracker:
    """Return a tracker that is up to date."""
    return InformationTracker(trajectories, deprecated=False)


def stale(*trajectories: Trajectory) -> InformationTracker:
    """Return a deprecated tracker."""
    return InformationTracker(trajectories, deprecated=True)


def updated(
    trackers: list[InformationTracker],
    heard: dict[int, Trajectory],
    cu_messages: dict[int, CuMessage] | None = None,
    semantics: Semantics = PRINTED,
) -> list[InformationTracker]:
    """Run Algorithm 2 of two CUs; `heard` is the trajectory of which each UAV's metadata was received."""
    messages = {i: UavMessage(trajectory.metadata) for i, trajectory in heard.items()}
    slots = QUIET if cu_messages is None else cu_messages
    return list(update_information_trackers(messages, slots, trackers, 2, semantics).trackers)


def test_a_match_reduces_the_tracker_to_the_matching_trajectory() -> None:
    """Lines 5-6: of several entries, the one whose metadata the UAV sent remains."""
    assert updated([valid(A, B)], {0: B}) == [valid(B)]
    assert updated([valid(A, B)], {0: A}) == [valid(A)]


def test_a_match_clears_the_flag_of_that_uav_only() -> None:
    """Line 7: the tracker of the UAV that was heard is up to date, others stay deprecated."""
    assert updated([stale(A), stale(B)], {0: A}) == [valid(A), stale(B)]


def test_a_message_that_matches_nothing_changes_nothing() -> None:
    """Lines 4-10: metadata that no entry has neither remove an entry nor clear the flag."""
    assert updated([stale(A), valid(A)], {0: B, 1: B}) == [stale(A), valid(A)]
    assert updated([stale()], {0: HOVERING}) == [stale()]


@pytest.mark.parametrize("other", [Trajectory(Metadata(3, 1)), Trajectory(Metadata(4, 0))])
def test_metadata_are_the_round_and_the_cu(other: Trajectory) -> None:
    """Line 5: the same round of another CU, or the same CU in another round, is no match."""
    assert updated([stale(A)], {0: other}) == [stale(A)]


def test_an_unheard_uav_keeps_its_tracker() -> None:
    """Line 2: without a message of the UAV, a tracker with one entry stays as it was."""
    assert updated([valid(A), stale(B)], {}) == [valid(A), stale(B)]


def test_line_13_as_printed_marks_every_tracker() -> None:
    """deprecation=all: one tracker that still holds two entries deprecates all of them."""
    assert updated([valid(A, B), valid(C)], {1: C}) == [stale(A, B), stale(C)]


def test_line_13_as_in_the_prose_marks_exactly_the_trackers_with_several_entries() -> None:
    """deprecation=one: the tracker with two entries is deprecated, another one is not."""
    assert updated([valid(A, B), valid(C)], {1: C}, semantics=PROSE) == [stale(A, B), valid(C)]


@pytest.mark.parametrize("semantics", [PRINTED, PROSE], ids=Semantics.name)
def test_line_13_marks_a_uav_whose_message_matches_nothing(semantics: Semantics) -> None:
    """Several entries deprecate a tracker whether a message of that UAV was received or not."""
    assert updated([valid(A, B)], {0: C}, semantics=semantics) == [stale(A, B)]


@pytest.mark.parametrize("semantics", [PRINTED, PROSE], ids=Semantics.name)
def test_one_entry_or_none_is_no_reason_to_deprecate(semantics: Semantics) -> None:
    """Line 12 asks for more than one entry, counted after the reduction of line 6."""
    trackers = [valid(A), valid(), valid(A, B)]
    assert updated(trackers, {2: B}, semantics=semantics) == [valid(A), valid(), valid(B)]


def test_line_13_overrules_line_7() -> None:
    """deprecation=all: a flag that a match has just cleared is set again if another tracker holds two entries."""
    assert updated([stale(A), stale(B, C)], {0: A}) == [stale(A), stale(B, C)]
    assert updated([stale(A), stale(B, C)], {0: A}, semantics=PROSE) == [valid(A), stale(B, C)]


@pytest.mark.parametrize("semantics", [PRINTED, PROSE], ids=Semantics.name)
@pytest.mark.parametrize("slots", [{}, {0: EMPTY}, {1: TrajectoryRequestMessage(0)}])
def test_a_missing_cu_message_marks_every_tracker(semantics: Semantics, slots: dict[int, CuMessage]) -> None:
    """Lines 17-18: fewer than M messages deprecate all trackers, also one that has just matched."""
    assert updated([valid(A), stale(B)], {1: B}, slots, semantics) == [stale(A), stale(B)]


@pytest.mark.parametrize(
    "message", [EMPTY, TrajectoryRequestMessage(0), TrajectoryMessage(1, B), TrajectoryMessage(1, A)]
)
def test_every_kind_of_message_counts(message: CuMessage) -> None:
    """Line 17: empty messages, requests, new trajectories and replies count alike."""
    assert updated([valid(A), valid(A)], {}, {0: EMPTY, 1: message})[0] == valid(A)


def test_a_new_trajectory_is_added_to_the_tracker_of_its_uav() -> None:
    """Line 22: the tracker of the UAV that the message is for holds the old and the new trajectory."""
    assert updated([valid(A), valid(A)], {}, {0: TrajectoryMessage(1, B), 1: EMPTY}) == [valid(A), valid(A, B)]


def test_the_union_comes_after_the_comparison() -> None:
    """Lines 20-24 follow lines 3-14: what is received in this round is neither compared nor counted."""
    slots: dict[int, CuMessage] = {0: TrajectoryMessage(0, B), 1: EMPTY}
    assert updated([valid(A)], {0: B}, slots) == [valid(A, B)]
    assert updated([valid(A)], {0: A}, slots) == [valid(A, B)]
    assert updated([stale()], {0: B}, slots) == [stale(B)]


def test_trajectories_of_two_cus_for_one_uav_are_both_kept() -> None:
    """Line 22 adds every trajectory, in the order of the slots."""
    slots: dict[int, CuMessage] = {1: TrajectoryMessage(0, C), 0: TrajectoryMessage(0, B)}
    assert updated([valid(A)], {0: A}, slots) == [valid(A, B, C)]


def test_a_union_has_no_duplicates() -> None:
    """Line 22: a reply with a trajectory that the tracker holds adds nothing."""
    slots: dict[int, CuMessage] = {0: TrajectoryMessage(0, A), 1: TrajectoryMessage(0, A)}
    assert updated([stale(A, B), stale()], {}, slots) == [stale(A, B), stale()]
    assert updated([stale(), stale()], {}, slots) == [stale(A), stale()]


def test_an_added_trajectory_clears_no_flag() -> None:
    """Lines 20-24 leave the flags alone: a reply helps only with the next metadata message of the UAV."""
    slots: dict[int, CuMessage] = {0: EMPTY, 1: TrajectoryMessage(0, A)}
    received = updated([stale()], {0: A}, slots)
    assert received == [stale(A)]
    assert updated(received, {0: A}) == [valid(A)]


def test_requests_and_empty_messages_change_no_tracker() -> None:
    """Line 21: only trajectory messages are added."""
    slots: dict[int, CuMessage] = {0: TrajectoryRequestMessage(0), 1: EMPTY}
    assert updated([valid(A), stale(B)], {}, slots) == [valid(A), stale(B)]


def test_the_older_dmpc_believes_what_it_receives() -> None:
    """loss_handling=ignore: a received trajectory replaces the tracker's content."""
    slots: dict[int, CuMessage] = {0: TrajectoryMessage(1, B), 1: EMPTY}
    assert updated([valid(A), valid(A)], {}, slots, IGNORE) == [valid(A), valid(B)]


def test_the_older_dmpc_deprecates_nothing() -> None:
    """loss_handling=ignore: neither missing messages nor strange metadata change a tracker."""
    assert updated([valid(A), valid(B)], {0: C, 1: A}, {}, IGNORE) == [valid(A), valid(B)]
