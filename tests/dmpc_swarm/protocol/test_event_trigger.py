"""The round-robin trigger: priorities of Appendix A, the consensus of eq. 11, the selection of Section 4.2.2."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit, CuState, Inbox
from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker
from swarmproof.dmpc_swarm.protocol.event_trigger import calc_priorities, prio_consensus, select_uav, top_priorities
from swarmproof.dmpc_swarm.protocol.messages import (
    HOVERING,
    CuMessage,
    EmptyMessage,
    Metadata,
    Trajectory,
    TrajectoryMessage,
    TrajectoryRequestMessage,
)
from swarmproof.dmpc_swarm.semantics import Semantics

ROUND_ROBIN = Semantics.parse("prose", ["event_trigger=round-robin", "initial=known"])


def tracker(*rounds: int) -> InformationTracker:
    """Return a tracker that is up to date, with entries calculated in these rounds."""
    return InformationTracker(tuple(Trajectory(Metadata(k, 0)) for k in rounds), deprecated=False)


def test_a_priority_is_the_age_of_the_first_entry() -> None:
    """J = k - k_calc of the entry that has been longest in the tracker, whatever came after it."""
    assert calc_priorities(7, [tracker(3), tracker(5, 6), tracker(6, 2)], running=True, planned=None) == (4, 2, 1)


def test_hovering_counts_as_calculated_in_round_minus_one() -> None:
    """In round k, a UAV that has never been planned has priority k + 1."""
    known = InformationTracker((HOVERING,), deprecated=False)
    assert calc_priorities(0, [known], running=True, planned=None) == (1,)
    assert calc_priorities(6, [known], running=True, planned=None) == (7,)


def test_zero_is_announced_for_the_planned_uav_only() -> None:
    """The UAV whose new trajectory the message carries has priority zero, the others their ages."""
    assert calc_priorities(7, [tracker(3), tracker(5)], running=True, planned=1) == (4, 0)


def test_a_cu_that_does_not_run_announces_one() -> None:
    """Outside of RUN_DMPC, a CU announces 1 for every UAV, also of empty trackers."""
    empty = InformationTracker((), deprecated=True)
    assert calc_priorities(9, [tracker(3), empty], running=False, planned=None) == (1, 1)


@pytest.mark.parametrize("state", [CuState.WAIT, CuState.REQUEST_TRAJECTORY])
def test_every_cu_message_carries_priorities(state: CuState) -> None:
    """Empty messages and requests carry priorities, too."""
    cu = ComputeUnit(0, state, (InformationTracker((), deprecated=True),) * 2)
    decision = algorithm1.decisions(cu, 5, 2, ROUND_ROBIN)[0]
    _, message = algorithm1.transmit(cu, 5, decision, ROUND_ROBIN)
    assert message is not None
    assert message.priorities == (1, 1)


def test_messages_of_a_running_cu_carry_ages() -> None:
    """A running CU announces zero for the UAV that it plans, and only ages where it plans none."""
    running = ComputeUnit(0, CuState.RUN_DMPC, (tracker(2), tracker(1)), a_et=(1, 0))
    _, planned = algorithm1.transmit(running, 5, 1, ROUND_ROBIN)
    assert planned == TrajectoryMessage(1, Trajectory(Metadata(5, 0)), (3, 0))
    _, empty = algorithm1.transmit(running, 5, None, ROUND_ROBIN)
    assert empty == EmptyMessage((3, 4))


def test_without_the_trigger_messages_carry_no_priorities() -> None:
    """Under event_trigger=any, no message carries priorities, and no A_ET(k) is computed."""
    semantics = Semantics.parse("prose", ["initial=known"])
    cu = algorithm1.initial(0, 2, 1, semantics)
    assert cu.a_et is None
    assert algorithm1.transmit(cu, 0, None, semantics)[1] == EmptyMessage(None)


def test_the_consensus_is_the_maximum() -> None:
    """Eq. 11: of different positive priorities, the greatest counts."""
    assert prio_consensus([EmptyMessage((3, 1)), TrajectoryRequestMessage(0, (1, 2))]) == (3, 2)


def test_a_zero_wins() -> None:
    """Appendix A: a zero from anyone makes the consensus zero, for that UAV only."""
    assert prio_consensus([EmptyMessage((9, 4)), EmptyMessage((0, 1))]) == (0, 4)
    assert prio_consensus([EmptyMessage((0, 1)), EmptyMessage((9, 4))]) == (0, 4)


def test_replies_have_no_say() -> None:
    """A message without priorities does not take part in the consensus."""
    assert prio_consensus([TrajectoryMessage(0, HOVERING), EmptyMessage((3, 1))]) == (3, 1)
    assert prio_consensus([TrajectoryMessage(0, HOVERING)]) is None
    assert prio_consensus([]) is None


def test_without_priorities_all_uavs_tie() -> None:
    """UAVs without a received priority tie, and the lowest indices are selected."""
    assert top_priorities(None, 4, 2) == (0, 1)
    assert algorithm1.initial(1, 3, 2, ROUND_ROBIN).a_et == (0, 1)


def test_a_et_holds_the_highest_priorities_first() -> None:
    """A_ET(k) is the top M of the UAVs, highest priority first, ties to the lowest index."""
    assert top_priorities((1, 5, 3, 5), 4, 3) == (1, 3, 2)
    assert top_priorities((2, 2, 2, 2), 4, 2) == (0, 1)
    assert top_priorities((0, 0, 1), 3, 2) == (2, 0)


def test_a_et_holds_all_uavs_where_there_are_fewer_than_cus() -> None:
    """A_ET(k) holds min(M, N) UAVs."""
    assert top_priorities((1, 2), 2, 3) == (1, 0)


@pytest.mark.parametrize(
    ("k", "w", "selected"), [(0, 0, 7), (0, 1, 8), (0, 2, 9), (1, 0, 8), (1, 2, 7), (3, 0, 7), (5, 1, 7)]
)
def test_the_position_rotates(k: int, w: int, selected: int) -> None:
    """CU w takes the UAV at position (k + w) mod M of A_ET(k)."""
    assert select_uav((7, 8, 9), k, w, 3) == selected


def test_a_position_beyond_the_uavs_selects_nothing() -> None:
    """With fewer UAVs than CUs, position N and above selects no UAV."""
    assert [select_uav((1, 0), 0, w, 3) for w in range(3)] == [1, 0, None]
    assert [select_uav((1, 0), 1, w, 3) for w in range(3)] == [0, None, 1]


@given(st.lists(st.integers(0, 9), min_size=1, max_size=6), st.integers(1, 5), st.integers(0, 20))
def test_cus_that_agree_select_different_uavs(priorities: list[int], cus: int, k: int) -> None:
    """CUs with the same A_ET(k) select pairwise different UAVs, min(M, N) in all."""
    a_et = top_priorities(tuple(priorities), len(priorities), cus)
    selected = [uav for w in range(cus) if (uav := select_uav(a_et, k, w, cus)) is not None]
    assert len(set(selected)) == len(selected) == min(cus, len(priorities))


def test_a_cu_selects_with_the_priorities_received() -> None:
    """Line 14: A_ET(k) comes from the priorities of the messages of the round before, the CU's own included."""
    cu = ComputeUnit(0, CuState.RUN_DMPC, (tracker(2),) * 3, a_et=(0, 1))
    slots: dict[int, CuMessage] = {0: EmptyMessage((3, 3, 3)), 1: EmptyMessage((0, 3, 4))}
    after = algorithm1.update(cu, Inbox({}, slots), 2, ROUND_ROBIN)
    assert after.state is CuState.RUN_DMPC
    assert after.a_et == (2, 1)
    assert algorithm1.may_plan(after, 4, 2) == (2,)
    assert algorithm1.may_plan(after, 5, 2) == (1,)


def test_a_cu_that_does_not_run_selects_nothing() -> None:
    """Only a CU in RUN_DMPC computes A_ET(k)."""
    cu = ComputeUnit(0, CuState.RUN_DMPC, (tracker(2),) * 2, a_et=(0, 1))
    after = algorithm1.update(cu, Inbox({}, {0: EmptyMessage((3, 3))}), 2, ROUND_ROBIN)
    assert after.state is CuState.WAIT
    assert after.a_et is None
    assert algorithm1.may_plan(after, 4, 2) == ()
