"""Priorities are 8 bits, in the order of Appendix A; a CU that does not run has no opinion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dmpc_swarm.flight.settings import GARBAGE, hover, lattice, setting, wander
from tests.margin.settings import examples

from swarmproof.dmpc_swarm.flight.state import Round
from swarmproof.dmpc_swarm.planner.outlook import ARRIVED, NEIGHBOURHOOD, STILL, Outlook, look
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.planner import Planner
from swarmproof.dmpc_swarm.planner.trigger import DEADLOCKED, LARGEST, LONGEST, OLDEST, SHORTEST, priorities
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.dmpc_swarm.protocol.event_trigger import JUST_RECALCULATED, NO_OPINION, top_priorities
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import Floats
from swarmproof.scenario.scenario import USUAL, Choices

EVERY = pytest.mark.parametrize("trigger", list(Trigger))
DISTANCES = st.one_of(st.just(0.0), st.floats(1e-6, 1e6))
AGES = st.one_of(st.integers(0, 400), st.integers(0, 10**9))
UNITS = lattice()


def seen(distances: Sequence[float], deadlocked: Sequence[bool] | None = None) -> Outlook:
    """Return an outlook of UAVs that are so far (m) from their targets."""
    n = len(distances)
    blocked = np.zeros(n, np.bool_) if deadlocked is None else np.array(deadlocked, np.bool_)
    still = np.zeros((n, 3))
    return Outlook(still, still, still, np.array(distances, float), blocked)


def announced(
    trigger: Trigger,
    distances: Sequence[float],
    ages: Sequence[int],
    deadlocked: Sequence[bool] | None = None,
    planned: int | None = None,
    choices: Choices = USUAL,
) -> tuple[int, ...]:
    """Return the priorities of UAVs with these distances (m) and ages (rounds)."""
    return priorities(trigger, seen(distances, deadlocked), np.array(ages, np.int64), planned, choices)


@given(st.lists(st.tuples(DISTANCES, AGES, st.booleans()), min_size=1, max_size=8), st.data())
@EVERY
@examples(100)
def test_priorities_are_eight_bits(trigger: Trigger, uavs: list[tuple[float, int, bool]], data: st.DataObject) -> None:
    """Whatever distances and ages are, a priority is 0 to 255, 0 for the planned UAV and for no other."""
    distances, ages, deadlocked = zip(*uavs, strict=True)
    planned = data.draw(st.one_of(st.none(), st.integers(0, len(uavs) - 1)))
    found = announced(trigger, distances, ages, deadlocked, planned)
    assert len(found) == len(uavs)
    for i, priority in enumerate(found):
        assert type(priority) is int
        assert priority <= LARGEST < 2**8
        assert (priority == JUST_RECALCULATED) == (i == planned)
        assert priority >= (0 if i == planned else DEADLOCKED)
        if deadlocked[i] and ages[i] <= USUAL.retry and i != planned:
            assert priority == DEADLOCKED == 1


@given(DISTANCES, DISTANCES, AGES, AGES)
@EVERY
@examples(200)
def test_priorities_keep_the_order(trigger: Trigger, near: float, far: float, young: int, old: int) -> None:
    """Further away, or older, or both, is never less urgent; (A1) looks at the age only, (A2) at the distance only."""
    (near, far), (young, old) = sorted((near, far)), sorted((young, old))
    low, further, older, high = announced(trigger, (near, far, near, far), (young, young, old, old))
    assert low <= min(further, older)
    assert max(further, older) <= high
    if trigger is Trigger.RR:
        assert (low, older) == (further, high)
    if trigger is Trigger.DT:
        assert (low, further) == (older, high)


@given(st.floats(SHORTEST, LONGEST / 1.3), st.floats(1.0, 1.2))
@pytest.mark.parametrize(("trigger", "told"), [(Trigger.DT, 1.03), (Trigger.HT, 1.05)])
@examples(100)
def test_priorities_tell_distances_apart(trigger: Trigger, told: float, distance: float, factor: float) -> None:
    """On the scale, a distance that is 3 % larger (DT; of distance times age 5 %, HT) is more urgent.

    255 steps on a logarithmic scale of three (five) decades are factors of 10^(3/254) < 1.028 (10^(5/254) < 1.047).
    """
    low, high = announced(trigger, (distance, distance * told * factor), (1, 1))
    assert low < high


def test_a_coarser_scale_would_not_tell_them_apart() -> None:
    """The test before can fail: HT's five decades do not tell a factor of 1.03 apart everywhere, as DT's three do."""
    distances = np.geomspace(0.02, 5, 400).tolist()
    for trigger, told in ((Trigger.DT, True), (Trigger.HT, False)):
        low = announced(trigger, distances, [1] * 400)
        high = announced(trigger, [1.03 * distance for distance in distances], [1] * 400)
        assert all(more > less for less, more in zip(low, high, strict=True)) == told


def test_the_scale_ends_where_it_says() -> None:
    """The ends of the scale are 1 and 255, for DT, and for HT in metres times rounds."""
    assert announced(Trigger.DT, (0, SHORTEST, LONGEST, 99), (5,) * 4) == (1, 1, 255, 255)
    assert announced(Trigger.HT, (0, SHORTEST, LONGEST, LONGEST), (1, 1, OLDEST, 2 * OLDEST)) == (1, 1, 255, 255)
    assert announced(Trigger.HT, (1.0, 0.1), (10, 100))[0] == announced(Trigger.HT, (1.0, 0.1), (10, 100))[1]


def test_round_robin_announces_ages() -> None:
    """(A1): the priority is the age in rounds, up to 255, whatever the distance; the oldest is planned next."""
    ages = (1, 2, 254, 255, 256, 10_000)
    found = announced(Trigger.RR, (9, 0, 1, 2, 3, 4), ages)
    assert found == (1, 2, 254, 255, 255, 255)
    assert top_priorities(found, 6, 2) == (3, 4)


@EVERY
def test_equals_tie(trigger: Trigger) -> None:
    """UAVs with equal distance and age have equal priorities, and the lowest index comes first."""
    found = announced(trigger, (0.7,) * 4, (3,) * 4)
    assert len(set(found)) == 1
    assert top_priorities(found, 4, 2) == (0, 1)


@EVERY
def test_a_deadlocked_uav_is_tried_again_after_a_while(trigger: Trigger) -> None:
    """It has priority 1 for 20 rounds, less than any UAV that is away, then its own again; never if it is planned."""
    for age in (1, USUAL.retry):
        blocked, free = announced(trigger, (1.0, 0.2), (age, max(age, 2)), (True, False))
        assert blocked == DEADLOCKED < free
    blocked, free = announced(trigger, (1.0, 1.0), (USUAL.retry + 1,) * 2, (True, False))
    assert blocked == free
    assert announced(trigger, (1.0, 1.0), (5, 5), (True, False), planned=0)[0] == JUST_RECALCULATED


@EVERY
def test_a_deadlocked_uav_can_be_given_up(trigger: Trigger) -> None:
    """Another number of rounds can be chosen; with 0, the UAV has priority 1 for as long as it is deadlocked."""
    for retry, age, tried in ((3, 3, False), (3, 4, True), (0, 1, False), (0, 10**9, False), (20, 21, True)):
        blocked, free = announced(trigger, (1.0, 1.0), (age, age), (True, False), choices=Choices(retry=retry))
        assert blocked == (free if tried else DEADLOCKED)
        assert free >= DEADLOCKED


def test_the_usual_priorities_are_as_documented() -> None:
    """Unless a scenario chooses otherwise, the scale is logarithmic from 0.01 m to 10 m, and 20 rounds are waited."""
    assert announced(Trigger.DT, (0.01, 0.1, 1.0, 10.0), (1,) * 4) == (1, 86, 170, 255)
    assert announced(Trigger.HT, (0.1, 1.0, 10.0, 10.0), (1, 1, 1, 100)) == (52, 103, 153, 255)
    assert announced(Trigger.DT, (1.0, 1.0), (20, 21), (True, True)) == (1, 170)


LINEAR = Choices(priority_scale="linear")


@given(st.lists(st.tuples(DISTANCES, AGES), min_size=1, max_size=8))
@pytest.mark.parametrize(("trigger", "largest"), [(Trigger.DT, LONGEST), (Trigger.HT, LONGEST * OLDEST)])
@examples(100)
def test_the_scale_can_be_linear(trigger: Trigger, largest: float, uavs: list[tuple[float, int]]) -> None:
    """On the linear scale, a priority is within half a step of its share of the upper end, and at least 1."""
    distances, ages = zip(*uavs, strict=True)
    found = announced(trigger, distances, ages, choices=LINEAR)
    for priority, distance, age in zip(found, distances, ages, strict=True):
        value = distance * (max(age, 1) if trigger is Trigger.HT else 1)
        assert DEADLOCKED <= priority <= LARGEST
        assert abs(priority - 1 - 254 * min(value / largest, 1)) <= 0.5 + 1e-9


def test_a_linear_scale_tells_small_distances_apart_no_more() -> None:
    """Half a metre and its hundredth differ on the logarithmic scale, hardly on the linear one; ages never change."""
    assert announced(Trigger.HT, (0.5, 0.005), (2, 2), choices=LINEAR) == (1, 1)
    assert announced(Trigger.HT, (0.5, 0.005), (2, 2)) == (103, 1)
    assert announced(Trigger.DT, (5, 10, 99), (1,) * 3, choices=LINEAR) == (128, 255, 255)
    assert announced(Trigger.RR, (5, 5), (3, 300), choices=LINEAR) == announced(Trigger.RR, (5, 5), (3, 300))


# The deadlock test


def blocked(
    plans: Sequence[Plan], targets: Sequence[Sequence[float]], planned_for: Sequence[bool], k: int
) -> list[bool]:
    """Return which UAVs count as deadlocked."""
    found = look(UNITS, k, plans, np.array(targets, float), np.array(planned_for, np.bool_))
    return [bool(value) for value in found.deadlocked]


def test_a_uav_that_cannot_go_on_is_deadlocked() -> None:
    """It stands, was planned for its present target, is not there, and nobody near it moves; each of these counts."""
    here, near, far = hover(UNITS, (0, 0, 1)), (0.5, 0, 1), (1.5, 0, 1)
    moving = wander(np.random.default_rng(1), hover(UNITS, near), 0, 0.3)
    away = (1.0, 0.0, 1.0)
    assert blocked([here, hover(UNITS, near)], [away, near], [True, True], 0) == [True, False]
    # a new target: it was not planned for it yet
    assert blocked([here, hover(UNITS, near)], [away, near], [False, True], 0) == [False, False]
    # it has arrived
    assert blocked([here, hover(UNITS, near)], [(0.04, 0, 1), near], [True, True], 0) == [False, False]
    # another one moves nearby, or far away
    assert blocked([here, moving], [away, near], [True, True], 0) == [False, False]
    further = wander(np.random.default_rng(1), hover(UNITS, far), 0, 0.3)
    assert blocked([here, further], [away, far], [True, True], 0) == [True, False]
    # it moves itself, and once it is at rest, it does not
    assert blocked([moving, here], [away, (0, 0, 1)], [True, True], 0) == [False, False]
    assert blocked([moving, here], [away, (0, 0, 1)], [True, True], UNITS.horizon) == [True, False]


def test_the_deadlock_tests_distances_are_those_it_says() -> None:
    """Just within and just beyond each threshold: 5 cm to the target, 1 cm of motion, three times d̂_min of distance."""
    here = hover(UNITS, (0, 0, 1))
    for distance, expected in ((ARRIVED * 0.99, False), (ARRIVED * 1.01, True)):
        assert blocked([here, hover(UNITS, (1, 0, 1))], [(distance, 0, 1), (1, 0, 1)], [True] * 2, 0)[0] is expected
    other = wander(np.random.default_rng(1), here, 0, 0.3)
    way = np.linalg.norm((other.positions - other.positions[0]) @ UNITS.pairs.first.T, axis=1).max()
    size = STILL / (way * float(UNITS.pairs.unit))
    for share, expected in ((0.99, True), (1.01, False)):
        small = Plan(UNITS, 0, other.state, np.rint(other.jerks * size * share))
        assert blocked([small, hover(UNITS, (1, 0, 1))], [(1, 1, 1), (1, 0, 1)], [True] * 2, 0)[0] is expected
    reach = NEIGHBOURHOOD * float(UNITS.parameters.d_hat_min)
    for share, expected in ((0.99, False), (1.01, True)):
        mover = wander(np.random.default_rng(1), hover(UNITS, (reach * share, 0, 1)), 0, 0.3)
        assert blocked([here, mover], [(1, 1, 1), (1, 0, 1)], [True] * 2, 0)[0] is expected


def test_an_outlook_is_where_the_uavs_are() -> None:
    """Positions, velocities and distances are those of the trajectories in the round, in m and m/s."""
    plan = wander(np.random.default_rng(2), hover(UNITS, (0.2, 0.1, 1)), 3, 0.5)
    target: Floats = np.array([[1.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    found = look(UNITS, 6, [plan, hover(UNITS, (0, 0, 1.5))], target, np.array([True, True]))
    position, velocity, _ = plan.state_at(6)
    assert found.positions[0].tolist() == (position * float(UNITS.position_unit)).tolist()
    assert found.velocities[0].tolist() == (velocity * float(UNITS.velocity_unit)).tolist()
    assert found.distances[0] == pytest.approx(np.linalg.norm(target[0] - found.positions[0]), rel=1e-12)
    assert found.distances[1] == pytest.approx(0.5, abs=1e-9)
    assert not found.velocities[1].any()


# In flight


def rounds_of(trigger: Trigger, loss: str, rounds: int, cus: int = 2, garbage: str | None = None) -> list[Round]:
    """Return the rounds of a flight of five UAVs on a circle."""
    what = setting("circle", cus, 0, ("uavs=5",), trigger)
    plans = None if garbage is None else Planner(what.flight().lattice, what.scenario.weights, GARBAGE[garbage]())
    flight = what.flight(plans)
    return list(flight.rounds(flight.initial(), parse(loss, 5, cus, 0), rounds))


@EVERY
def test_a_cu_that_does_not_run_has_no_opinion(trigger: Trigger) -> None:
    """Through a jam, CUs outside RUN_DMPC announce 1 for every UAV, or are silent; those that run announce more."""
    opinions = {True: 0, False: 0}
    for flown in rounds_of(trigger, "jam:3,4", 16):
        for cu, slot in zip(flown.before.swarm.cus, flown.computed.air.slots, strict=True):
            running = cu.state is CuState.RUN_DMPC
            message = slot.cu_message
            if message is None:
                assert not running
                continue
            assert message.priorities is not None
            assert (message.priorities == (NO_OPINION,) * 5) == (not running)
            opinions[running] += 1
    assert min(opinions.values()) >= 6


@EVERY
def test_only_the_planned_uav_is_announced_with_zero(trigger: Trigger) -> None:
    """A running CU announces zero for the UAV whose new trajectory the message carries; without one, for nobody."""
    for garbage in (None, "infeasible"):
        zeros = 0
        for flown in rounds_of(trigger, "iid:0.1", 12, garbage=garbage):
            for decision, slot in zip(flown.computed.decided, flown.computed.air.slots, strict=True):
                message = slot.cu_message
                if message is None or message.priorities is None or message.priorities == (NO_OPINION,) * 5:
                    continue
                zero = [i for i, priority in enumerate(message.priorities) if priority == JUST_RECALCULATED]
                assert zero == ([] if decision is None else [decision])
                zeros += len(zero)
        assert (zeros > 5) == (garbage is None)


def test_round_robin_flies_by_ages() -> None:
    """Under RR, a running CU announces for each UAV how long ago its trajectory was calculated, or that it stands."""
    ages_seen = set()
    for flown in rounds_of(Trigger.RR, "none", 20):
        for cu, decision, slot in zip(
            flown.before.swarm.cus, flown.computed.decided, flown.computed.air.slots, strict=True
        ):
            assert slot.cu_message is not None
            assert slot.cu_message.priorities is not None
            for i, (tracker, priority) in enumerate(zip(cu.trackers, slot.cu_message.priorities, strict=True)):
                age = flown.before.k - tracker.trajectories[0].metadata.round
                assert priority in ({0} if i == decision else {age, DEADLOCKED})
                ages_seen.add(priority)
    # five UAVs, two in each round, of which the new ones count two rounds later
    assert {0, 1, 2, 3} <= ages_seen


def test_all_running_cus_select_alike() -> None:
    """All CUs that hear everything have the same A_ET(k), and plan different UAVs of it."""
    for trigger in Trigger:
        for flown in rounds_of(trigger, "none", 20, cus=3):
            selected = {cu.a_et for cu in flown.before.swarm.cus}
            assert len(selected) == 1
            planned = [i for i in flown.computed.decided if i is not None]
            assert len(set(planned)) == len(planned)
