"""The high-level planner of Appendix B.1: who makes room for whom, where to, for how long; and that it helps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dmpc_swarm.flight.settings import lattice, setting
from tests.margin.settings import examples
from tests.scenario.points import points

from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.flight.judge import Flown
from swarmproof.dmpc_swarm.flight.run import fly
from swarmproof.dmpc_swarm.flight.state import Round
from swarmproof.dmpc_swarm.planner.detour import (
    CLOSE,
    SLOW,
    Detour,
    current,
    makes_room,
    plan_detours,
    swarm_deadlocked,
)
from swarmproof.dmpc_swarm.planner.outlook import ARRIVED, Outlook
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import Floats
from swarmproof.scenario.scenario import USUAL, Choices, Scenario, TargetChange, Weights

Point = tuple[float, float, float]
STEP, LONGEST = USUAL.detour_step, USUAL.detour_rounds
#: Detours without noise.
QUIET = Choices(detour_noise=0.0)
BOX: Floats = np.array([[-1.7, -1.7, 0.4], [1.7, 1.7, 3.0]])
COORDINATES = st.floats(-1.5, 1.5)
POINTS = st.tuples(COORDINATES, COORDINATES, COORDINATES)
#: UAV i, on its way to +x, and UAV j before it, on its way to −x.
HERE, AHEAD = (0.0, 0.0, 1.0), (0.5, 0.0, 1.0)
AIM, OTHER_AIM = (1.0, 0.0, 1.0), (-0.5, 0.0, 1.0)


def seen(
    positions: Sequence[Point], targets: Sequence[Point], speed: float = 0.0, deadlocked: Sequence[bool] | None = None
) -> Outlook:
    """Return an outlook in which UAV 0 has this speed (m/s) in y, the others none."""
    here, aims = np.array(positions, float), np.array(targets, float)
    velocities = np.zeros_like(here)
    velocities[0, 1] = speed
    blocked = np.ones(len(here), np.bool_) if deadlocked is None else np.array(deadlocked, np.bool_)
    return Outlook(here, velocities, aims, np.sqrt(((aims - here) ** 2).sum(axis=1)), blocked)


def room(i: Point = HERE, j: Point = AHEAD, to_i: Point = AIM, to_j: Point = OTHER_AIM) -> bool:
    """Say whether UAV i makes room for UAV j."""
    return makes_room(seen([i, j], [to_i, to_j]), 0, 1)


# When


def test_a_swarm_is_deadlocked_if_nobody_can_go_on() -> None:
    """All stand, somebody is away, and whoever is away is deadlocked; each of these counts."""
    there = (0.0, 1.0, 1.0)
    assert swarm_deadlocked(seen([HERE, AHEAD], [AIM, OTHER_AIM]))
    assert swarm_deadlocked(seen([HERE, there], [AIM, there], deadlocked=[True, False]))
    assert not swarm_deadlocked(seen([HERE, AHEAD], [AIM, OTHER_AIM], deadlocked=[True, False]))
    assert not swarm_deadlocked(seen([HERE, AHEAD], [HERE, AHEAD]))
    assert swarm_deadlocked(seen([HERE, AHEAD], [AIM, OTHER_AIM], speed=-0.99 * SLOW))
    assert not swarm_deadlocked(seen([HERE, AHEAD], [AIM, OTHER_AIM], speed=-1.01 * SLOW))
    assert not swarm_deadlocked(seen([HERE, there], [AIM, there], speed=SLOW, deadlocked=[True, False]))


# Who


def test_uavs_that_meet_head_on_make_room_for_each_other() -> None:
    """All conditions hold for both."""
    assert room()
    assert room(AHEAD, HERE, OTHER_AIM, AIM)


def test_only_near_uavs_make_room() -> None:
    """The first condition: within a certain distance, a metre; that is included."""
    to_j = (-2.0, 0.0, 1.0)
    assert room(j=(CLOSE, 0, 1), to_j=to_j)
    assert not room(j=(CLOSE * (1 + 1e-12), 0, 1), to_j=to_j)
    assert not room(j=(0.8, 0.7, 1), to_j=to_j)


def test_nobody_makes_room_for_a_uav_that_is_closer_to_its_target() -> None:
    """The second condition: UAV j is not closer to its target than UAV i; equally close is enough."""
    assert room(to_j=(-0.5, 0, 1))
    assert room(to_j=(-0.6, 0, 1))
    assert not room(to_j=(-0.49, 0, 1))


def test_nobody_makes_room_for_a_uav_that_has_arrived() -> None:
    """A UAV at its target needs no room, even if UAV i is at its own."""
    assert not room(to_i=HERE, to_j=AHEAD)
    assert not room(to_i=HERE, to_j=(0.5 - 0.99 * ARRIVED, 0, 1))


def test_a_uav_in_the_way_makes_room() -> None:
    """The third condition: UAV i moves towards UAV j, or is between it and its target. Either is enough."""
    aside = (0.0, 0.9, 1.0)
    # towards j, though j goes elsewhere
    assert room(to_i=(0.4, 0, 1), to_j=(0.5, 1.5, 1))
    assert room(to_i=(0.1, 0.3, 1), to_j=(0.5, 1.5, 1))
    # not towards j, but between: on its way elsewhere, or arrived
    assert room(to_i=aside, to_j=(-0.9, 0, 1))
    assert room(to_i=HERE)
    # neither: i is behind j, beyond its target, or beside its way
    assert not room(to_i=aside, to_j=(1.5, 0, 1))
    assert not room(i=(-0.5, 0, 1), to_i=(-0.5, 0, 1), j=(0.3, 0, 1), to_j=(-0.4, 0, 1))
    assert room(i=(0, 0.49 * STEP, 1), to_i=(0, 0.49 * STEP, 1))
    assert not room(i=(0, 0.51 * STEP, 1), to_i=(0, 0.51 * STEP, 1))


@given(POINTS, POINTS, POINTS, POINTS)
@examples(300)
def test_the_conditions_are_those_of_the_appendix(i: Point, j: Point, to_i: Point, to_j: Point) -> None:
    """For any positions and targets, the verdict is what angles and the nearest point of j's way say."""
    a, b, u, v = (np.array(point) for point in (i, j, to_i, to_j))
    near = np.linalg.norm(b - a) <= CLOSE
    left_i, left_j = np.linalg.norm(u - a), np.linalg.norm(v - b)
    cosine = (u - a) @ (b - a)
    # the nearest of many points of j's way, without its ends
    shares = np.linspace(0, 1, 20001)[1:-1, None]
    nearest = np.linalg.norm(b + shares * (v - b) - a, axis=1)
    least = int(nearest.argmin())
    within = 0 < least < len(nearest) - 1
    between = within and nearest[least] < STEP / 2
    # what is too near to a threshold to be told by this is left out
    doubtful = abs(nearest[least] - STEP / 2) < 1e-3 or (not within and nearest[least] < STEP / 2)
    close = min(abs(left_i - left_j), abs(left_j - ARRIVED), abs(left_i - ARRIVED), abs(cosine)) < 1e-9
    if doubtful or close:
        return
    expected = near and left_j > ARRIVED and left_j >= left_i and ((cosine > 0 and left_i > ARRIVED) or between)
    assert room(i, j, to_i, to_j) == expected


# Where to


def test_a_detour_leads_away_from_the_other_uav() -> None:
    """Without noise, the intermediate target is a step further away from the other UAV, on the line through both."""
    (found,) = plan_detours(seen([HERE, AHEAD], [AIM, OTHER_AIM]), 7, [0], BOX, (1,), QUIET)
    assert (found.uav, found.other, found.since) == (0, 1, 7)
    assert found.point == pytest.approx((-STEP, 0, 1), abs=1e-12)


def test_a_detour_is_for_the_nearest_rival() -> None:
    """Of several UAVs that it is to make room for, UAV i makes room for the closest."""
    others = [(0.5, 0.0, 1.0), (0.0, 0.3, 1.0), (0.6, 0.0, 1.0)]
    outlook = seen([HERE, *others], [(1, 1, 1), (-2, 0, 1), (0, -2, 1), (-2, 0, 1)])
    assert all(makes_room(outlook, 0, j) for j in (1, 2, 3))
    (found,) = plan_detours(outlook, 0, [0], BOX, (1,), QUIET)
    assert found.other == 2
    assert found.point == pytest.approx((0, -STEP, 1), abs=1e-12)


def test_the_step_can_be_chosen() -> None:
    """Another step leads so much further away, and widens the way beside which another UAV lies."""
    far = Choices(detour_step=1.2, detour_noise=0.0)
    (found,) = plan_detours(seen([HERE, AHEAD], [AIM, OTHER_AIM]), 7, [0], BOX, (1,), far)
    assert found.point == pytest.approx((-1.2, 0, 1), abs=1e-12)
    beside = seen([(0, 0.51 * STEP, 1), AHEAD], [(0, 0.51 * STEP, 1), OTHER_AIM])
    assert makes_room(beside, 0, 1, far)
    assert not makes_room(beside, 0, 1)


def test_the_noise_can_be_chosen() -> None:
    """The noise is the same draw, as many times larger as is chosen."""

    def offset(noise: float) -> Floats:
        outlook = seen([HERE, AHEAD], [AIM, OTHER_AIM])
        (found,) = plan_detours(outlook, 7, [0], 100 * BOX - 80, (1,), Choices(detour_noise=noise))
        return np.array(found.point) - (-STEP, 0, 1)

    assert np.abs(offset(0.3)).min() > 1e-3
    assert offset(0.6) == pytest.approx(2 * offset(0.3))
    assert offset(USUAL.detour_noise) == pytest.approx(offset(0.3), abs=0)


def test_the_usual_detour_is_as_documented() -> None:
    """Unless a scenario chooses otherwise, the step is 0.6 m, the noise 0.3 m, and the end comes after 15 rounds."""
    outlook = seen([HERE, AHEAD], [AIM, OTHER_AIM])
    (found,) = plan_detours(outlook, 7, [0], BOX, (1,))
    noise = np.random.default_rng([1, 7, 0]).normal(0.0, 0.3, 3)
    expected = np.array([0.0, 0.0, 1.0]) + 0.6 * np.array([-1.0, 0.0, 0.0]) + noise
    assert found.point == tuple(np.clip(expected, BOX[0], BOX[1]).tolist())
    assert [k for k in range(7, 40) if current([found], outlook, k)] == list(range(7, 22))


def test_only_assigned_uavs_get_detours() -> None:
    """A CU plans detours for its own UAVs; one with nobody to make room for gets none."""
    outlook = seen([HERE, AHEAD, (-1.5, 0, 1)], [AIM, OTHER_AIM, (-1.5, 1, 1)])
    assert [found.uav for found in plan_detours(outlook, 0, [0, 1, 2], BOX, (1,))] == [0, 1]
    assert [found.uav for found in plan_detours(outlook, 0, [1], BOX, (1,))] == [1]
    assert plan_detours(outlook, 0, [2], BOX, (1,)) == []
    assert plan_detours(outlook, 0, [], BOX, (1,)) == []


@given(st.lists(POINTS, min_size=2, max_size=5), st.integers(0, 2**31), st.integers(0, 1000), st.data())
@examples(100)
def test_detours_stay_in_the_space(positions: list[Point], seed: int, k: int, data: st.DataObject) -> None:
    """Wherever the UAVs are, even at one point, an intermediate target is a point of the flying space."""
    if data.draw(st.booleans()):
        positions[1] = positions[0]
    here = [(x, y, 1.7 + z / 1.5 * 1.2) for x, y, z in positions]
    targets = [data.draw(POINTS) for _ in positions]
    for found in plan_detours(seen(here, targets), k, range(len(here)), BOX, (seed,)):
        assert (np.array(found.point) >= BOX[0]).all()
        assert (np.array(found.point) <= BOX[1]).all()
        assert found.other != found.uav


def test_the_noise_depends_on_seed_round_and_uav_only() -> None:
    """The same seed, round and UAV give the same point, whoever else is assigned; other ones give other noise."""
    outlook = seen([HERE, AHEAD], [AIM, OTHER_AIM])

    def point(seed: int, k: int, assigned: Sequence[int]) -> Point:
        return plan_detours(outlook, k, assigned, BOX, (seed,))[-1].point

    assert point(1, 5, [1]) == point(1, 5, [0, 1]) == point(1, 5, [1])
    heights = {point(seed, k, [i])[2] for seed in range(5) for k in range(5) for i in (0, 1)}
    # all UAVs are at one height, so that the noise alone decides theirs; some are at the floor
    assert len(heights - {0.4}) > 45


# How long


def test_a_detour_ends() -> None:
    """It goes on for 15 rounds at most, and no longer than its UAV has a reason to make room."""
    outlook = seen([HERE, AHEAD], [AIM, OTHER_AIM])
    found = Detour(0, 1, (0, 0, 1), 10)
    assert current([found], outlook, 10 + LONGEST - 1) == [found]
    assert current([found], outlook, 10 + LONGEST) == []
    assert current([found], outlook, 10 + LONGEST, Choices(detour_rounds=LONGEST + 1)) == [found]
    assert current([found], outlook, 12, Choices(detour_rounds=2)) == []
    gone = seen([HERE, AHEAD], [AIM, (0.5, 0.1, 1)])
    assert not makes_room(gone, 0, 1)
    assert current([found, Detour(1, 0, (0, 0, 1), 10)], gone, 11) == [Detour(1, 0, (0, 0, 1), 10)]


# In flight


@dataclass(frozen=True)
class Seen:
    """A flight: its result, and by round what CUs knew and announced of detours, and where the UAVs were."""

    flown: Flown
    known: list[list[tuple[Detour, ...]]]
    announced: list[tuple[tuple[Detour, ...] | None, ...]]
    paths: list[bytes]

    @property
    def first(self) -> int:
        """The first round in which a detour was known."""
        return next(k for k, known in enumerate(self.known) if any(known))


def head_on(
    seed: int = 0,
    trigger: Trigger = Trigger.HT,
    cus: int = 2,
    loss: str = "none",
    rounds: int = 60,
    height: float = 1.0,
    choices: Choices = USUAL,
) -> Seen:
    """Fly two UAVs head on, exactly: everything is symmetric but their numbers."""
    units = lattice()
    starts = points((-0.6, 0.0, 1.0), (0.6, 0.0, height))
    targets = (TargetChange(0, starts[::-1]),)
    scenario = Scenario("head on", units.parameters, units.horizon, Weights(), starts, targets, rounds, choices=choices)
    what = setting(scenario, cus, seed, trigger=trigger)
    known, announced, paths = [], [], []

    def watch(flown: Round) -> None:
        known.append([one.detours for one in flown.before.knowledge])
        announced.append(flown.computed.announced)
        paths.append(b"".join(flown.before.followed(i).state_at(flown.before.k).tobytes() for i in (0, 1)))

    result, _ = fly(what, parse(loss, 2, cus, seed), rounds, watch)
    return Seen(result, known, announced, paths)


def violated(result: Flown) -> list[str]:
    """Return the violated claims."""
    return [judged.claim.id for judged in result.claims if judged.verdict is Verdict.VIOLATED]


@pytest.mark.parametrize("seed", range(4))
def test_a_symmetric_deadlock_is_resolved(seed: int) -> None:
    """Two UAVs that meet head on, exactly, block each other, make detours and arrive; all claims hold on the way."""
    found = head_on(seed)
    assert any(any(known) for known in found.known)
    assert violated(found.flown) == []
    assert found.flown.arrived
    assert found.flown.qps.rejected == found.flown.qps.infeasible == 0


@pytest.mark.parametrize("trigger", [Trigger.RR, Trigger.DT])
@pytest.mark.parametrize(("cus", "loss"), [(1, "none"), (3, "iid:0.1"), (2, "burst:0.05,0.4")])
def test_a_symmetric_deadlock_is_resolved_whatever_the_rest(trigger: Trigger, cus: int, loss: str) -> None:
    """So it is with other triggers, numbers of CUs, and losses."""
    found = head_on(1, trigger, cus, loss, 120)
    assert violated(found.flown) == []
    assert found.flown.arrived


def test_without_detours_it_is_not() -> None:
    """The tests before can fail: without the high-level planner, the two stand before each other for ever."""
    found = head_on(rounds=120, choices=Choices(detours="off"))
    assert not any(any(known) for known in found.known)
    assert not found.flown.arrived


def test_uavs_that_do_not_meet_make_no_detours() -> None:
    """Two UAVs that pass at different heights arrive without any."""
    found = head_on(height=2.9)
    assert found.flown.arrived
    assert not any(any(known) for known in found.known)


@pytest.mark.parametrize("loss", ["none", "iid:0.1", "jam:12,10"])
def test_detours_end_and_stay_in_the_space(loss: str) -> None:
    """CU w announces detours of UAVs i with i mod M = w only, younger than 15 rounds, to points of the space.

    Without loss, nobody knows an older one. At the end nobody knows any.
    """
    count = 0
    for seed in range(3):
        found = head_on(seed, loss=loss)
        for k, by_cu in enumerate(found.announced):
            for w, detours in enumerate(by_cu):
                for one in detours or ():
                    count += 1
                    assert one.uav % 2 == w
                    assert 0 <= k - one.since < LONGEST
                    assert (np.array(one.point) >= BOX[0]).all()
                    assert (np.array(one.point) <= BOX[1]).all()
        if loss == "none":
            ages = [k - one.since for k, known in enumerate(found.known) for detours in known for one in detours]
            assert 0 < min(ages) <= max(ages) <= LONGEST
        assert not any(found.known[-1])
    assert count >= 3


def test_a_detour_is_known_to_all_a_round_later() -> None:
    """What a CU announces in a round, all CUs know in the next one, if nothing is lost."""
    found = head_on(2)
    for k, by_cu in enumerate(found.announced[:-1]):
        assert None not in by_cu
        together = tuple(sorted(one for detours in by_cu for one in detours or ()))
        assert all(known == together for known in found.known[k + 1])
    assert found.known[found.first][0][0].since == found.first - 1


def test_detours_are_repeatable_by_seed() -> None:
    """A flight with detours is the same to the bit with the same seed; with another seed, only up to the first one."""
    one, again, other = head_on(5), head_on(5), head_on(6)
    assert one.known == again.known
    assert one.paths == again.paths
    assert one.paths != other.paths
    assert one.paths[: one.first] == other.paths[: one.first]
