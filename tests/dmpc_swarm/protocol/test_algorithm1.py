"""Algorithm 1 line by line: the state machine, what it transmits, and the switches that concern it."""

from __future__ import annotations

import pytest
from tests.dmpc_swarm.bruteforce import all_events

from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit, CuState, Decision, Inbox
from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker
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
from swarmproof.dmpc_swarm.protocol.swarm import all_decisions, compute, forbidden, initial_swarm, step
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.errors import BadInput

PRINTED, PROSE, GUARDED = (Semantics.parse(preset) for preset in ("printed", "prose", "guarded"))
KNOWN = Semantics.parse("prose", ["initial=known"])
A, B = (Trajectory(Metadata(k, 0)) for k in (3, 4))
RUN, WAIT, REQUEST, WAIT_FOR_UPDATE = CuState
QUIET: dict[int, CuMessage] = {0: EmptyMessage(), 1: EmptyMessage()}
STATES = pytest.mark.parametrize("state", list(CuState))


def unit(state: CuState, *trackers: tuple[tuple[Trajectory, ...], bool], next_request: int = 0) -> ComputeUnit:
    """Return CU 0 with trackers given as (entries, deprecated)."""
    return ComputeUnit(0, state, tuple(InformationTracker(*tracker) for tracker in trackers), next_request)


UP_TO_DATE = (((A,), False), ((B,), False))
ONE_DEPRECATED = (((A,), False), ((B,), True))


def after(cu: ComputeUnit, semantics: Semantics = PROSE, slots: dict[int, CuMessage] | None = None) -> CuState:
    """Return the state after lines 8-11, with every CU message and no UAV message received."""
    return algorithm1.update(cu, Inbox({}, QUIET if slots is None else slots), 2, semantics).state


# --- lines 1-5 -----------------------------------------------------------------------------------------------------


def test_a_cu_begins_by_requesting() -> None:
    """Lines 1-5: the trackers are empty and deprecated, the state is REQUEST_TRAJECTORY."""
    cu = algorithm1.initial(1, 3, 2, PRINTED)
    assert (cu.w, cu.state) == (1, REQUEST)
    assert cu.trackers == (InformationTracker((), deprecated=True),) * 3


def test_a_cu_that_knows_everything_begins_by_running() -> None:
    """initial=known: every tracker holds the hovering trajectory, nothing is deprecated, the CU runs."""
    cu = algorithm1.initial(0, 2, 2, KNOWN)
    assert cu.state is RUN
    assert cu.trackers == (InformationTracker((HOVERING,), deprecated=False),) * 2


def test_algorithm_2_does_not_run_before_the_first_computation_phase() -> None:
    """In round 0 nothing has been received yet, and nothing is deprecated for that reason."""
    for semantics, state in ((PRINTED, REQUEST), (KNOWN, RUN)):
        swarm = initial_swarm(2, 2, semantics)
        assert swarm.k == 0
        assert all(cu.state is state for cu in swarm.cus)
        assert all(uav.followed == HOVERING and not uav.asked_by for uav in swarm.uavs)


def test_the_older_dmpc_must_begin_with_knowledge() -> None:
    """loss_handling=ignore with initial=unknown is refused."""
    with pytest.raises(BadInput, match="initial=known"):
        Semantics.parse("printed", ["loss_handling=ignore"])


# --- lines 8-11 ----------------------------------------------------------------------------------------------------


@STATES
def test_a_cu_whose_trackers_are_up_to_date_runs(state: CuState) -> None:
    """Line 9 as printed: from any state, the CU runs once nothing is deprecated."""
    assert after(unit(state, *UP_TO_DATE), PROSE) is RUN
    assert after(unit(state, *UP_TO_DATE), PRINTED) is RUN


def test_a_cu_that_donated_its_slot_does_not_run_in_that_round() -> None:
    """rejoin=after-reply: line 9 is skipped in WAIT_FOR_UPDATE, and in no other state."""
    for state in (RUN, WAIT, REQUEST):
        assert after(unit(state, *UP_TO_DATE), GUARDED) is RUN
    assert after(unit(WAIT_FOR_UPDATE, *UP_TO_DATE), GUARDED) is WAIT_FOR_UPDATE


@pytest.mark.parametrize(
    ("state", "expected"),
    [(RUN, WAIT), (WAIT, WAIT), (REQUEST, REQUEST), (WAIT_FOR_UPDATE, WAIT_FOR_UPDATE)],
)
def test_one_deprecated_tracker_keeps_a_cu_from_running(state: CuState, expected: CuState) -> None:
    """Lines 9-10: a CU that ran waits; one that recovers goes on with it."""
    for semantics in (PRINTED, PROSE, GUARDED):
        assert after(unit(state, *ONE_DEPRECATED), semantics) is expected


def test_a_lost_message_ends_running() -> None:
    """Lines 8 and 10: a CU that misses a message of another CU leaves RUN_DMPC."""
    assert after(unit(RUN, *UP_TO_DATE), PROSE, {0: EmptyMessage()}) is WAIT


def test_line_8_comes_before_line_9() -> None:
    """The flags that line 9 reads are those after Algorithm 2 of the same computation phase."""
    cu = unit(REQUEST, ((A,), False), ((B,), True))
    inbox = Inbox({1: UavMessage(B.metadata)}, QUIET)
    assert algorithm1.update(cu, inbox, 2, PROSE).state is RUN


# --- lines 13-20 ---------------------------------------------------------------------------------------------------


def test_only_a_uav_with_one_entry_may_be_planned() -> None:
    """Line 17: a UAV with no entry or with two entries is not planned."""
    cu = unit(RUN, ((A,), False), ((A, B), False), ((), False))
    assert algorithm1.may_plan(cu, 5, 2) == (0,)
    assert algorithm1.decisions(cu, 5, 2, PROSE) == (None, 0)


@pytest.mark.parametrize("state", [WAIT, REQUEST, WAIT_FOR_UPDATE])
def test_only_a_running_cu_plans(state: CuState) -> None:
    """Line 13: outside of RUN_DMPC no UAV may be planned, whatever is known of it."""
    assert algorithm1.may_plan(unit(state, *UP_TO_DATE), 5, 2) == ()


def test_a_free_trigger_may_choose_any_uav_or_none() -> None:
    """event_trigger=any: a running CU plans any UAV with one entry, or none."""
    assert algorithm1.decisions(unit(RUN, *UP_TO_DATE), 5, 2, PROSE) == (None, 0, 1)


def test_under_a_free_trigger_cus_plan_different_uavs() -> None:
    """event_trigger=any: of all combinations, only those in which two CUs plan one UAV are excluded."""
    swarm = initial_swarm(2, 2, KNOWN)
    assert set(all_decisions(swarm, KNOWN)) == {
        (None, None),
        (None, 0),
        (None, 1),
        (0, None),
        (1, None),
        (0, 1),
        (1, 0),
    }
    assert forbidden(swarm, (0, 0), KNOWN) == "two CUs plan UAV 0"
    assert forbidden(swarm, (0, 1), KNOWN) is None


@pytest.mark.parametrize(("entries", "expected"), [((A,), 1), ((A, B), None), ((), None)])
def test_the_round_robin_trigger_leaves_no_choice(entries: tuple[Trajectory, ...], expected: Decision) -> None:
    """event_trigger=round-robin: the selected UAV is planned if it has one entry, else no UAV is."""
    semantics = Semantics.parse("prose", ["event_trigger=round-robin"])
    trackers = (InformationTracker((A,), deprecated=False), InformationTracker(entries, deprecated=False))
    cu = ComputeUnit(0, RUN, trackers, a_et=(1, 0))
    assert algorithm1.decisions(cu, 4, 2, semantics) == (expected,)


def test_two_cus_may_plan_one_uav_under_round_robin() -> None:
    """Under event_trigger=round-robin nothing but the trigger itself keeps two CUs from planning one UAV."""
    semantics = Semantics.parse("prose", ["event_trigger=round-robin"])
    cu = unit(RUN, *UP_TO_DATE)
    assert not algorithm1.is_exclusive(cu, 0, semantics)
    assert algorithm1.is_exclusive(cu, 0, PROSE)


def test_a_planned_trajectory_is_named_after_round_and_cu() -> None:
    """Lines 18-19: the message carries a trajectory with the metadata (k, w), and the CU goes on running."""
    cu = ComputeUnit(1, RUN, (InformationTracker((A,), deprecated=False),))
    assert algorithm1.transmit(cu, 8, 0, PROSE) == (cu, TrajectoryMessage(0, Trajectory(Metadata(8, 1))))


def test_a_cu_that_plans_nothing_sends_an_empty_message() -> None:
    """Line 16: a running CU always transmits."""
    cu = unit(RUN, ((A, B), False))
    assert algorithm1.transmit(cu, 8, None, PROSE) == (cu, EmptyMessage())


# --- lines 22-32 ---------------------------------------------------------------------------------------------------


def test_waiting_lasts_one_round() -> None:
    """Lines 23-24: in WAIT a CU sends an empty message, and requests in the next round."""
    cu, message = algorithm1.transmit(unit(WAIT, *ONE_DEPRECATED), 5, None, PROSE)
    assert (cu.state, message) == (REQUEST, EmptyMessage())


def test_a_request_is_for_a_deprecated_uav() -> None:
    """Lines 26-28: a CU asks for a UAV whose tracker is deprecated, then waits for the update."""
    cu, message = algorithm1.transmit(unit(REQUEST, *ONE_DEPRECATED), 5, 1, PROSE)
    assert (cu.state, message) == (WAIT_FOR_UPDATE, TrajectoryRequestMessage(1))


def test_a_cu_is_silent_while_it_waits_for_the_update() -> None:
    """Lines 30-31: the slot belongs to the UAV, and in the next round the CU requests again."""
    cu, message = algorithm1.transmit(unit(WAIT_FOR_UPDATE, *ONE_DEPRECATED), 5, None, PROSE)
    assert (cu.state, message) == (REQUEST, None)


@pytest.mark.parametrize(("order", "expected"), [("lowest-index", (1,)), ("any", (1, 2)), ("round-robin", (2,))])
def test_request_orders(order: str, expected: tuple[int, ...]) -> None:
    """request_order decides which deprecated UAV is asked: the lowest, any, or the next from the pointer on."""
    cu = unit(REQUEST, ((A,), False), ((A,), True), ((A,), True), ((A,), False), next_request=2)
    semantics = Semantics.parse("prose", [f"request_order={order}"])
    assert algorithm1.decisions(cu, 5, 2, semantics) == expected


def test_the_request_pointer_goes_round() -> None:
    """request_order=round-robin: from the pointer on, the search goes round past the last UAV."""
    semantics = Semantics.parse("prose", ["request_order=round-robin"])
    cu = unit(REQUEST, ((A,), True), ((A,), True), ((A,), False), next_request=2)
    assert algorithm1.decisions(cu, 5, 2, semantics) == (0,)
    cu, _ = algorithm1.transmit(cu, 5, 0, semantics)
    assert cu.next_request == 1


def test_the_request_pointer_starts_at_uav_0() -> None:
    """request_order=round-robin: the first request is for the lowest deprecated UAV."""
    semantics = Semantics.parse("prose", ["request_order=round-robin"])
    assert algorithm1.decisions(algorithm1.initial(0, 3, 2, semantics), 0, 2, semantics) == (0,)


@pytest.mark.parametrize("asked", [0, 1, 2])
def test_the_request_pointer_follows_the_last_request(asked: int) -> None:
    """request_order=round-robin: the pointer goes to the UAV after the one asked, from the last one to the first."""
    semantics = Semantics.parse("prose", ["request_order=round-robin"])
    cu, _ = algorithm1.transmit(unit(REQUEST, *[((A,), True)] * 3), 5, asked, semantics)
    assert cu.next_request == (asked + 1) % 3


@pytest.mark.parametrize("state", [RUN, WAIT, WAIT_FOR_UPDATE])
def test_the_request_pointer_moves_only_on_a_request(state: CuState) -> None:
    """request_order=round-robin: neither other messages nor updates nor recovery move the pointer."""
    semantics = Semantics.parse("prose", ["request_order=round-robin"])
    cu, _ = algorithm1.transmit(unit(state, *UP_TO_DATE, next_request=1), 5, None, semantics)
    assert cu.next_request == 1
    assert algorithm1.update(cu, Inbox({}, QUIET), 2, semantics).next_request == 1


def test_other_orders_have_no_pointer() -> None:
    """Without request_order=round-robin the pointer stays at UAV 0 and distinguishes no swarms."""
    for order in ("lowest-index", "any"):
        cu, _ = algorithm1.transmit(
            unit(REQUEST, *[((A,), True)] * 3), 5, 1, Semantics.parse("prose", [f"request_order={order}"])
        )
        assert cu.next_request == 0


# --- a whole round -------------------------------------------------------------------------------------------------


def test_a_swarm_that_knows_nothing_recovers_without_losses() -> None:
    """Without losses, both CUs of a fresh swarm ask for UAV 0 and 1 in turn, and run in round 7."""
    swarm = initial_swarm(2, 2, PRINTED)
    states = []
    for _ in range(8):
        states.append({cu.state for cu in swarm.cus})
        swarm = step(swarm, next(e for e in all_events(swarm, PRINTED) if e.lost == 0), PRINTED)
    # for UAV 0: request, silence, request again, silence with the metadata that clears the flag; then for UAV 1
    assert states == [{REQUEST}, {WAIT_FOR_UPDATE}] * 3 + [{REQUEST}, {RUN}]


def test_what_a_round_transmits_depends_on_its_decisions() -> None:
    """The computation phase turns the decisions into one message per CU slot, and metadata of every UAV."""
    computed, air = compute(initial_swarm(2, 2, KNOWN), (1, None), KNOWN)
    assert [cu.state for cu in computed] == [RUN, RUN]
    assert [slot.cu_message for slot in air.slots] == [
        TrajectoryMessage(1, Trajectory(Metadata(0, 0))),
        EmptyMessage(),
    ]
    assert air.uav_messages == (UavMessage(HOVERING.metadata),) * 2


def test_decisions_that_cannot_be_taken_are_named() -> None:
    """A decision that a CU cannot take is refused with the CU, its state and its options."""
    reason = forbidden(initial_swarm(2, 2, PRINTED), (0, 1), PRINTED)
    assert reason == "CU 1 in REQUEST_TRAJECTORY decides 1, but can only decide one of [0]"
