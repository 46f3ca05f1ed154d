"""What is seen of a round agrees exactly with the oracle: which trajectories, which pairs, which samples, how close."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from math import isqrt, sqrt

import numpy as np
import pytest
from tests.dmpc_swarm.flight.flights import Recording, record, recorded, scenario
from tests.dmpc_swarm.flight.settings import flown, hover, lattice, limits, setting
from tests.dmpc_swarm.planner import oracle
from tests.scenario.points import points

from swarmproof.dmpc_swarm.claims.flight import Approach, ObservedRound, PlannedBy
from swarmproof.dmpc_swarm.flight.observing import View, observe_round
from swarmproof.dmpc_swarm.flight.separation_at_samples import Candidates, closest_at_samples, tracked
from swarmproof.dmpc_swarm.flight.state import FlightState, Name, Round
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.protocol.messages import HOVERING, Metadata
from swarmproof.motion.lattice import Lattice

F = Fraction
#: A d̂_min with which the oracle lists every pair at every sample, m.
ALL = F(1000)

#: What is compared: scenario, CUs, loss, rounds, seed, semantics, UAVs.
FLIGHTS = [
    ("circle", 2, "iid:0.15", 2, 1, "guarded", 6),
    ("crossing", 1, "iid:0.3", 12, 3, "guarded", None),
    ("crossing", 2, "iid:0.3", 12, 1, "ignore-loss", None),
    ("random", 2, "iid:0.1", 4, 2, "guarded", 4),
    ("circle", 2, "iid:0.3", 5, 0, "ignore-loss", 3),
]


# The oracle's answers


@cache
def _as_flown(plan: Plan) -> oracle.Flown:
    return flown(plan)


def samples(units: Lattice, k: int, first: int, last: int) -> list[Fraction]:
    """Return the times (s) of samples `first` … `last` from the start of round k on."""
    return [k * units.parameters.T_s + h * units.parameters.T_c for h in range(first, last + 1)]


def least(
    pairs: Iterable[tuple[tuple[int, Plan], tuple[int, Plan]]], times: Sequence[Fraction], units: Lattice
) -> Fraction | None:
    """Return the least squared distance (m²) of pairs of (UAV, trajectory); of one UAV they do not count."""
    everything = replace(limits(units), d_hat_min=ALL)
    squares = [
        close.squared
        for (i, mine), (j, other) in pairs
        if i != j
        for close in oracle.separation_violations({i: [_as_flown(mine)], j: [_as_flown(other)]}, times, everything)
    ]
    return min(squares, default=None)


def held(state: FlightState) -> list[tuple[int, Plan]]:
    """Return all (UAV, trajectory) that some CU's tracker without a deprecated flag holds, each once."""
    found: dict[Name, Plan] = {}
    for cu in state.swarm.cus:
        for i, tracker in enumerate(cu.trackers):
            for trajectory in () if tracker.deprecated else tracker.trajectories:
                found[i, trajectory.metadata] = state.plans[i, trajectory.metadata]
    return [(i, plan) for (i, _), plan in found.items()]


def all_pairs(some: Sequence[tuple[int, Plan]]) -> list[tuple[tuple[int, Plan], tuple[int, Plan]]]:
    """Return every pair once."""
    return [(one, other) for n, one in enumerate(some) for other in some[:n]]


def expected(units: Lattice, seen: Round) -> dict[str, Fraction | None]:
    """Return what the oracle makes of a round, by the names of :class:`ObservedRound`."""
    k, h_c = seen.before.k, limits(units).h_c
    new: list[tuple[int, Plan, frozenset[int]]] = [
        (attempt.task.i, attempt.planned.plan, attempt.task.selected)
        for attempt in seen.computed.attempts
        if attempt is not None and attempt.planned.plan is not None
    ]
    planned = {i for i, _, _ in new}
    before, after = held(seen.before), held(seen.after)
    others = [(j, plan) for j, plan in after if j not in planned]
    both = [
        ((i, mine), (j, other))
        for n, (i, mine, selected) in enumerate(new)
        for j, other, also in new[:n]
        if {i, j} <= selected and {i, j} <= also
    ]
    now, next_, later = samples(units, k, 0, h_c), samples(units, k + 1, 0, h_c), samples(units, k + 1, 1, h_c)
    followed = [(i, seen.before.followed(i)) for i in range(len(seen.before.swarm.uavs))]
    return {
        "known": least(all_pairs(before), now, units),
        "learned": least(all_pairs(after), next_, units),
        "both_new": least(both, later, units),
        "one_new": least([((i, plan), other) for i, plan, _ in new for other in others], later, units),
        "none_new_before": least(all_pairs([(j, p) for j, p in before if j not in planned]), now[1:], units),
        "none_new_after": least(all_pairs(others), later, units),
        "flown": least(all_pairs(followed), now[: units.steps], units),
    }


def observed(recording: Recording) -> list[ObservedRound]:
    """Return what is seen of the rounds of a flight."""
    units = recording.flight.lattice
    view = View.of(units, recording.rounds[0].before)
    seen = []
    for round_ in recording.rounds:
        one, view = observe_round(units, view, round_)
        seen.append(one)
    return seen


def square(approach: Approach | None) -> Fraction | None:
    """Return the squared distance of an approach, if there is one."""
    return None if approach is None else approach.square


def assert_seen(recording: Recording) -> None:
    """Assert that in every round all seven approaches are the oracle's, and none is missing."""
    units = recording.flight.lattice
    for round_, seen in zip(recording.rounds, observed(recording), strict=True):
        for name, distance in expected(units, round_).items():
            assert square(getattr(seen, name)) == distance, (round_.before.k, name)


@pytest.mark.parametrize("what", FLIGHTS, ids=lambda what: f"{what[0]}-{what[5]}")
def test_every_distance_is_the_oracles(what: tuple[str, int, str, int, int, str, int | None]) -> None:
    """In every round, all seven closest approaches are those of the oracle, exactly, and none is missing."""
    assert_seen(recorded(*what))


def test_the_first_sample_is_seen_in_flights() -> None:
    """Of UAVs that part, the first sample is the closest one: it counts in trackers, and is seen."""
    near, far = (points((-x, 0.0, 1.0), (x, 0.0, 1.0)) for x in (0.14, 1.0))
    parting = record(setting(scenario(near, {0: far}), 2), "none", 5)
    assert_seen(parting)
    assert any(seen.known and seen.known.time == F(seen.k, 5) for seen in observed(parting)[1:])


def test_the_flights_above_are_no_easy_ones() -> None:
    """Among them there are trackers with two entries, deprecated ones, every kind of approach, and ones too close."""
    rounds = [round_ for what in FLIGHTS for round_ in recorded(*what).rounds]
    trackers = [tracker for round_ in rounds for cu in round_.after.swarm.cus for tracker in cu.trackers]
    assert any(len(tracker.trajectories) == 2 and not tracker.deprecated for tracker in trackers)
    assert any(tracker.deprecated for tracker in trackers)
    seen = [one for what in FLIGHTS for one in observed(recorded(*what))]
    for name in ("known", "learned", "both_new", "one_new", "none_new_before", "none_new_after", "flown"):
        assert sum(getattr(one, name) is not None for one in seen) >= 5, name
    assert any(one.learned and one.learned.square < one.d_hat_min**2 for one in seen)
    # CUs that plan in one round and disagree on whom they plan: Corollary 1 says nothing of these
    attempts = [[one for one in round_.computed.attempts if one is not None] for round_ in rounds]
    disagree = [both for both in attempts if len(both) == 2 and both[0].task.i != both[1].task.i]
    unions = [both[0].task.selected | both[1].task.selected for both in disagree]
    assert any(
        {both[0].task.i, both[1].task.i} <= either and not {both[0].task.i, both[1].task.i} <= both[n].task.selected
        for both, either in zip(disagree, unions, strict=True)
        for n in (0, 1)
    )


@pytest.mark.parametrize("what", FLIGHTS, ids=lambda what: f"{what[0]}-{what[5]}")
def test_an_approach_says_where_it_is(what: tuple[str, int, str, int, int, str, int | None]) -> None:
    """The trajectories that an approach names are so far apart at its time, says the oracle."""
    recording = recorded(*what)
    bounds = limits(recording.flight.lattice)
    for round_, seen in zip(recording.rounds, observed(recording), strict=True):
        known = {**round_.before.plans, **round_.after.plans}
        for w, attempt in enumerate(round_.computed.attempts):
            if attempt is not None and attempt.planned.plan is not None:
                known[attempt.task.i, Metadata(round_.before.k, w)] = attempt.planned.plan
        for approach in (seen.known, seen.learned, seen.both_new, seen.one_new, seen.none_new_after, seen.flown):
            if approach is not None:
                one, other = (
                    _as_flown(known[i, Metadata(*planned)])
                    for i, planned in zip(approach.uavs, approach.planned, strict=True)
                )
                assert oracle.squared_distance(one, other, approach.time, bounds) == approach.square


def test_attempts_are_seen_as_they_are() -> None:
    """Every attempt is seen, with its CU and UAV, and with a plan exactly if there is one."""
    recording = recorded("crossing", 2, "iid:0.3", 12, 1, "ignore-loss")
    for round_, seen in zip(recording.rounds, observed(recording), strict=True):
        there = [(w, attempt) for w, attempt in enumerate(round_.computed.attempts) if attempt is not None]
        assert [(one.cu, one.uav) for one in seen.attempts] == [(w, attempt.task.i) for w, attempt in there]
        assert [one.solved for one in seen.attempts] == [attempt.planned.plan is not None for _, attempt in there]
        assert [one.candidate for one in seen.attempts] == [attempt.planned.feasible for _, attempt in there]


# By hand: what a lattice unit decides

#: A quarter of a metre in three directions, m, scaled as published: z counts a sixth.
QUARTERS = {"x": (F(1, 4), F(0), F(0)), "xy": (F(-3, 20), F(1, 5), F(0)), "z": (F(0), F(0), F(3, 2))}


def named(plans: Sequence[Plan]) -> list[tuple[Name, Plan]]:
    """Return hovering trajectories, one for each UAV, with their names."""
    return [((i, HOVERING.metadata), plan) for i, plan in enumerate(plans)]


def ways_to_see(units: Lattice, plans: Sequence[Plan]) -> list[Approach]:
    """Return the closest approach of hovering UAVs: as candidates, with and without sample 0, and as references."""
    names = [name for name, _ in named(plans)]
    candidates = Candidates(units, 0, named(plans))
    positions = np.array([plan.scaled_from(0)[: units.steps] for plan in plans]).transpose(1, 0, 2)
    seen = [
        candidates.among(names, names, first=0),
        candidates.among(names, names, first=1),
        closest_at_samples(units, 0, names, positions),
    ]
    return [approach for approach in seen if approach is not None]


@pytest.mark.parametrize("direction", QUARTERS)
def test_the_minimum_distance_is_far_enough(direction: str) -> None:
    """Two hovering UAVs at exactly d̂_min are at d̂_min, and one lattice unit closer they are not."""
    units = lattice()
    counts = [part / units.position_unit for part in QUARTERS[direction]]
    away = [int(count) for count in counts]
    assert all(count == number for count, number in zip(counts, away, strict=True))
    closer = [count - (count > 0) + (count < 0) for count in away]
    at = (0.0, 0.0, 1.0)
    for moved, is_closer in ((away, False), (closer, True)):
        approaches = ways_to_see(units, [hover(units, at), hover(units, at, moved)])
        assert len(approaches) == 3
        for approach in approaches:
            assert (approach.square < F(1, 16)) == is_closer
            assert (approach.square == F(1, 16)) != is_closer


def test_whoever_is_nearest_by_a_unit_is_found() -> None:
    """Of pairs that no float tells from d̂_min, nor from each other, it is exact which is closest, and how close."""
    units = lattice("theta_inverse=1")
    random = np.random.default_rng(0)
    limit = int(F(1, 16) / units.pairs.unit**2)
    below = misled = 0
    for _ in range(60):
        # pairs of hovering UAVs, a metre from one pair to the next
        plans = []
        for row in range(3):
            at = (0.0, row - 1.0, 1.0)
            x = int(random.uniform(0.4, 0.9) * isqrt(limit))
            y = isqrt(limit - x**2)
            z = isqrt(limit - x**2 - y**2) + int(random.integers(2))
            plans += [hover(units, at), hover(units, at, random.permutation([x, y, z]).tolist())]
        pairs = [
            [int(part) for part in other.scaled_from(0)[0] - one.scaled_from(0)[0]]
            for n, one in enumerate(plans)
            for other in plans[:n]
        ]
        exact = min(sum(part**2 for part in pair) for pair in pairs)
        assert abs(F(exact, limit) - 1) < F(1, 2**50)
        below += exact < limit
        x, y, z = np.array(pairs, float).T
        misled += sum(int(n) ** 2 for n in pairs[int((x * x + y * y + z * z).argmin())]) != exact
        for approach in ways_to_see(units, plans):
            assert approach.square == exact * units.pairs.unit**2
    assert 10 < below < 60
    # floats alone would have been wrong
    assert misled > 10


#: Two pairs of UAVs on a lattice with Θ⁻¹ = 1, in lattice units: the first pair is a little further apart than d̂_min,
#: by less than float64 can see, the second 2⁻⁴⁸ nearer.
FAR_ENOUGH, TOO_CLOSE = (70704331461, 362616, 71651913262), (65853381872, 76134297511, 332654)


def test_a_pair_that_is_too_close_is_not_hidden_by_one_that_is_not() -> None:
    """References closer than d̂_min are seen, though others, a hair further apart, come first."""
    units = lattice("theta_inverse=1")
    square_of_d_hat = units.pairs.square(units.parameters.d_hat_min)
    assert sum(n * n for n in TOO_CLOSE) < square_of_d_hat <= sum(n * n for n in FAR_ENOUGH)
    here, there = (-1.0, -1.0, 1.0), (1.0, -1.0, 1.0)
    plans = [hover(units, here), hover(units, here, FAR_ENOUGH), hover(units, there), hover(units, there, TOO_CLOSE)]
    for approach in ways_to_see(units, plans):
        assert approach.uavs == (2, 3)
        assert approach.square < F(1, 16)


def _passing(units: Lattice) -> list[Plan]:
    """Return two plans that are a unit closer than d̂_min at their start, and move apart."""
    away = int(F(1, 4) / units.position_unit)
    still = hover(units, (0.0, 0.0, 1.0))
    other = hover(units, (0.0, 0.0, 1.0), (away - 1, 0, 0))
    jerks = other.jerks.copy()
    # a move by 12·j in x, at rest again after three periods
    jerks[:3, 0] = np.array([1, -2, 1]) * 2.0**20
    return [still, Plan(units, 0, other.state, jerks)]


def test_the_first_sample_counts_where_it_must() -> None:
    """A new trajectory starts where the old one is: its first sample counts for trackers, not for (16) to (19)."""
    units = lattice()
    plans = _passing(units)
    names = [name for name, _ in named(plans)]
    candidates = Candidates(units, 0, named(plans))
    at_start, later = candidates.among(names, names, first=0), candidates.among(names, names, first=1)
    assert at_start is not None
    assert later is not None
    assert at_start.square < F(1, 16) < later.square
    assert (at_start.time, later.time) == (F(0), units.parameters.T_c)


def test_trajectories_of_one_uav_are_not_compared() -> None:
    """Two candidates of one UAV may be in one place; without another UAV there is no approach at all."""
    units = lattice()
    plan = hover(units, (0.0, 0.0, 1.0))
    names: list[Name] = [(0, HOVERING.metadata), (0, Metadata(0, 0))]
    candidates = Candidates(units, 1, [(name, plan) for name in names])
    assert candidates.among(names, names) is None
    assert closest_at_samples(units, 1, names[:1], plan.scaled_from(1)[None, : units.steps].transpose(1, 0, 2)) is None


def test_only_the_asked_pairs_are_compared() -> None:
    """Of three UAVs in a row, the approach is that of the pairs between the two sets, whichever is given first."""
    units = lattice()
    plans = [hover(units, (x, 0.0, 1.0)) for x in (0.0, 0.5, 1.5)]
    a, b, c = (name for name, _ in named(plans))
    candidates = Candidates(units, 0, named(plans))

    def distance(some: list[Name], others: list[Name]) -> float:
        approach = candidates.among(some, others)
        assert approach is not None
        assert approach.planned == (PlannedBy(-1, -1), PlannedBy(-1, -1))
        return sqrt(approach.square)

    assert distance([a, b, c], [a, b, c]) == pytest.approx(0.5)
    assert distance([a], [c]) == distance([c], [a]) == pytest.approx(1.5)
    assert distance([c], [a, b]) == pytest.approx(1.0)
    assert candidates.among([a], [a]) is None
    assert candidates.among([], [a, b]) is None


# By hand: which trajectories count


def test_deprecated_trackers_do_not_count() -> None:
    """A trajectory is known if some CU has it in a tracker that is not deprecated; with no such tracker, none is."""
    flight = setting("crossing").flight()
    start = flight.initial()
    names = {(0, HOVERING.metadata), (1, HOVERING.metadata)}

    def deprecated(*where: tuple[int, int]) -> FlightState:
        cus = tuple(
            replace(
                cu,
                trackers=tuple(
                    tracker._replace(deprecated=(cu.w, i) in where) for i, tracker in enumerate(cu.trackers)
                ),
            )
            for cu in start.swarm.cus
        )
        return replace(start, swarm=replace(start.swarm, cus=cus))

    assert tracked(start) == tracked(deprecated((0, 0), (1, 1))) == names
    assert tracked(deprecated((0, 0), (1, 0))) == {(1, HOVERING.metadata)}
    nothing = deprecated((0, 0), (0, 1), (1, 0), (1, 1))
    assert tracked(nothing) == set()
    for state, there in ((start, True), (deprecated((0, 1), (1, 1)), False), (nothing, False)):
        view = View.of(flight.lattice, state)
        assert (view.closest(view.known, view.known, first=0) is not None) == there
        assert (view.unplanned(set()) is not None) == there
    assert View.of(flight.lattice, start).unplanned({0}) is None
