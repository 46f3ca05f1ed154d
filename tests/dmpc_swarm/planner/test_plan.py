"""A plan is the oracle's trajectory exactly: at samples, shifted by any number of rounds, at rest after its end."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dmpc_swarm.flight.settings import flown, hover, lattice, planner, resting, samples, wander
from tests.dmpc_swarm.planner.oracle import Flown
from tests.margin.settings import TILTED, examples

from swarmproof.dmpc_swarm.planner.accept import Planes, broken_constraint
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.planner import Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.motion.integrator import AxisMotion
from swarmproof.motion.lattice import Floats, Lattice

F = Fraction
SEEDS = st.integers(0, 2**32)
UNITS = [(samples(1),), (samples(2),), (samples(3), TILTED), (samples(4), TILTED)]
EVERY = pytest.mark.parametrize("changes", UNITS)
NOBODY: dict[int, tuple[Plan, ...]] = {}


def some_plan(random: np.random.Generator, units: Lattice, start: int, replanned: int = 2) -> Plan:
    """Return what a UAV follows that was replanned so often, once in a few rounds, at random; it ends at rest."""
    plan = hover(units, random.uniform(-1, 1, 3).tolist())
    for n in range(replanned):
        plan = wander(random, plan, start - 3 * (replanned - n))
    return wander(random, plan, start)


def si(units: Lattice, rows: Floats, unit: Fraction) -> list[tuple[Fraction, ...]]:
    """Return rows of lattice units in SI units."""
    assert (rows == np.rint(rows)).all()
    return [tuple(int(n) * unit for n in row) for row in rows]


def times(units: Lattice, k: int) -> list[Fraction]:
    """Return the times of the samples h = 0 … H·m from the start of round k on."""
    given_ = units.parameters
    return [k * given_.T_s + h * given_.T_c for h in range(units.horizon * units.steps + 1)]


def scaled(units: Lattice, point: tuple[Fraction, ...]) -> tuple[Fraction, ...]:
    """Return Θ⁻¹p."""
    return tuple(sum((a * x for a, x in zip(row, point, strict=True)), F(0)) for row in units.parameters.theta_inverse)


@given(SEEDS)
@EVERY
@examples(8)
def test_a_plan_is_the_integral_of_its_jerks(changes: tuple[str, ...], seed: int) -> None:
    """Samples, velocities and accelerations are those of the oracle and of the older exact integrator, to the bit."""
    random = np.random.default_rng(seed)
    units = lattice(*changes)
    plan = some_plan(random, units, 9)
    truth = flown(plan)
    at = times(units, 9)
    assert si(units, plan.positions, units.position_unit) == [truth.position(t) for t in at]
    states = [truth.at(t) for t in at[:: units.steps]]
    for rows, unit, which in (
        (plan.velocities, units.velocity_unit, 1),
        (plan.accelerations, units.acceleration_unit, 2),
    ):
        assert si(units, rows, unit) == [tuple(axis[which] for axis in state) for state in states]
    period = units.parameters.T_s
    for axis in range(3):
        motion = AxisMotion(tuple(truth.state[axis]), (*((period, jerk[axis]) for jerk in truth.jerks), (period, F(0))))
        for t, position in zip(at, plan.positions, strict=True):
            assert int(position[axis]) * units.position_unit == motion.position(t - at[0])


@given(SEEDS, st.integers(0, 40))
@EVERY
@examples(8)
def test_later_samples_are_those_of_the_same_trajectory(changes: tuple[str, ...], seed: int, later: int) -> None:
    """From any round on, within the horizon or beyond it, samples, scaled ones, state and jerk are the oracle's."""
    units = lattice(*changes)
    plan = some_plan(np.random.default_rng(seed), units, 9)
    truth = flown(plan)
    k = plan.start + later
    at = times(units, k)
    points = [truth.position(t) for t in at]
    assert si(units, plan.sampled_from(k), units.position_unit) == points
    assert si(units, plan.scaled_from(k), units.pairs.unit) == [scaled(units, point) for point in points]
    p, v, a = plan.state_at(k)
    assert list(
        zip(
            *si(units, np.array([p]), units.position_unit),
            *si(units, np.array([v]), units.velocity_unit),
            *si(units, np.array([a]), units.acceleration_unit),
            strict=True,
        )
    ) == list(truth.at(at[0]))
    jerk = truth.jerks[later] if later < units.horizon else (F(0),) * 3
    assert si(units, plan.jerk_in(k)[None], units.jerk_unit) == [jerk]


@given(SEEDS, st.integers(0, 40), st.integers(0, 40))
@EVERY
@examples(8)
def test_a_shifted_plan_is_the_same_trajectory(changes: tuple[str, ...], seed: int, first: int, second: int) -> None:
    """Shifted once or twice, by any number of rounds, it has equal samples, states, velocities and accelerations."""
    units = lattice(*changes)
    plan = some_plan(np.random.default_rng(seed), units, 9)
    once = plan.shifted(plan.start + first)
    twice = once.shifted(once.start + second)
    for moved in (once, twice):
        for k in (moved.start, moved.start + 1, moved.start + units.horizon, moved.start + 50):
            assert np.array_equal(moved.state_at(k), plan.state_at(k))
            assert np.array_equal(moved.jerk_in(k), plan.jerk_in(k))
            assert np.array_equal(moved.sampled_from(k), plan.sampled_from(k))
            assert np.array_equal(moved.scaled_from(k), plan.scaled_from(k))
        rounds = moved.start - plan.start
        passed = min(rounds, units.horizon)
        assert np.array_equal(moved.velocities[: units.horizon + 1 - passed], plan.velocities[passed:])
        assert np.array_equal(moved.accelerations[: units.horizon + 1 - passed], plan.accelerations[passed:])
        assert moved.at_rest
    directly = plan.shifted(twice.start)
    assert twice.digest == directly.digest


@given(SEEDS)
@EVERY
@examples(8)
def test_after_its_end_a_plan_is_at_rest_exactly(changes: tuple[str, ...], seed: int) -> None:
    """Beyond the horizon nothing moves any more, by not a single unit, a thousand rounds later, too."""
    units = lattice(*changes)
    plan = some_plan(np.random.default_rng(seed), units, 9)
    assert plan.at_rest
    assert flown(plan).at(1000 * units.parameters.T_s) == flown(plan).at((9 + units.horizon) * units.parameters.T_s)
    for k in (9 + units.horizon, 25 + units.horizon, 1000):
        assert (plan.sampled_from(k) == plan.positions[-1]).all()
        assert not plan.state_at(k)[1:].any()
        assert not plan.jerk_in(k).any()
        assert not plan.shifted(k).jerks.any()


@given(SEEDS, st.integers(0, 2), st.sampled_from([-1, 1]), st.integers(0, 14))
@examples(30)
def test_one_unit_of_jerk_more_is_no_rest(seed: int, axis: int, by: int, period: int) -> None:
    """A plan that is at rest at its end is not if one of its jerks is changed by one unit."""
    units = lattice()
    plan = some_plan(np.random.default_rng(seed), units, 9)
    jerks = plan.jerks.copy()
    jerks[period, axis] += by
    assert plan.at_rest
    assert not Plan(units, 9, plan.state, jerks).at_rest


def test_rest_needs_velocity_and_acceleration_to_be_zero() -> None:
    """A plan that ends with a velocity only, or with an acceleration only, is not at rest; one with neither is."""
    units = lattice(horizon=4)
    hovering = hover(units, (0, 0, 1))

    def ends(*jerks: int) -> tuple[float, float, bool]:
        changed = np.zeros((4, 3))
        changed[:, 1] = jerks
        plan = Plan(units, 1, hovering.state_at(1), changed)
        return plan.velocities[-1, 1], plan.accelerations[-1, 1], plan.at_rest

    velocity, acceleration, rests = ends(1, -1, 0, 0)
    assert (velocity != 0, acceleration, rests) == (True, 0, False)
    velocity, acceleration, rests = ends(1, 0, -2, -1)
    assert (velocity, acceleration != 0, rests) == (0, True, False)
    assert ends(1, -2, 1, 0) == (0, 0, True)


@given(SEEDS, st.integers(0, 200))
@EVERY
@examples(8)
def test_positions_between_samples_are_near_the_truth(changes: tuple[str, ...], seed: int, eighths: int) -> None:
    """At any time, the rounded position is within four units of the exact one.

    Its four terms are below 2⁵⁰ and the roundings in each fewer than five, so all are off by less than
    4 · 5 · 2⁵⁰⁻⁵³ = 2.5 units, and the sums by 3 · 2⁻² more; the oracle has no roundings.
    """
    units = lattice(*changes)
    plan = some_plan(np.random.default_rng(seed), units, 9)
    t = plan.start * units.parameters.T_s + F(eighths, 8) * units.parameters.T_c
    for found, true in zip(plan.position(eighths / 8), flown(plan).position(t), strict=True):
        assert abs(F(found) - true / units.position_unit) < 4


def test_plans_are_read_only() -> None:
    """Nobody can change what others hold: all arrays of a plan refuse to be written."""
    plan = some_plan(np.random.default_rng(1), lattice(), 9)
    for array in (plan.state, plan.jerks, plan.positions, plan.velocities, plan.accelerations):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_a_hover_stays_where_it_is() -> None:
    """A hovering UAV (Remark 2) is at rest at its position in every round."""
    units = lattice()
    plan = hover(units, (0.3, -0.7, 1.1))
    assert plan.at_rest
    assert (plan.sampled_from(7) == units.positions([(0.3, -0.7, 1.1)])).all()


def test_digests_tell_trajectories_apart() -> None:
    """A digest is equal for equal start, state and jerks, also where a zero has a sign, and for nothing else."""
    units = lattice()
    plan = some_plan(np.random.default_rng(1), units, 9)
    same = Plan(units, 9, plan.state.copy(order="F"), plan.jerks.copy(order="F"))
    assert same.digest == plan.digest
    changed = [Plan(units, 10, plan.state, plan.jerks)]
    for row, axis in product(range(3), range(3)):
        state = plan.state.copy()
        state[row, axis] += 1
        changed.append(Plan(units, 9, state, plan.jerks))
    for row, axis in product(range(units.horizon), range(3)):
        jerks = plan.jerks.copy()
        jerks[row, axis] -= 1
        changed.append(Plan(units, 9, plan.state, jerks))
    assert len({plan.digest, *(one.digest for one in changed)}) == len(changed) + 1
    still = hover(units, (0, 0, 1))
    assert Plan(units, 0, still.state, -still.jerks).digest == still.digest


@given(SEEDS)
@EVERY
@examples(8)
def test_parity_holds_on_every_trajectory_from_a_hover(changes: tuple[str, ...], seed: int) -> None:
    """v/m² + a/m is an even integer at the start of every round, however often and when the UAV was replanned."""
    random = np.random.default_rng(seed)
    units = lattice(*changes)
    m = units.steps
    plan = hover(units, random.uniform(-1, 1, 3).tolist())
    for k in np.cumsum(random.integers(1, 20, 12)).tolist():
        plan = wander(random, plan, k)
        for later in range(units.horizon + 1):
            _, v, a = plan.state_at(k + later)
            for x, y in zip(v, a, strict=True):
                assert (F(int(x), m**2) + F(int(y), m)) % 2 == 0


def rounded(own: Plan, jerks: Floats) -> Plan:
    """Return what the planner makes of `jerks` (m/s³, (H, 3)) for a UAV that has followed `own` for two rounds."""
    task = Task(own.start + 1, 0, own, NOBODY, frozenset(), np.zeros(3))
    return planner(own.lattice).rounded(task, jerks.T.ravel())


@given(SEEDS)
@EVERY
@examples(20)
def test_rounding_restores_rest_on_the_lattice(changes: tuple[str, ...], seed: int) -> None:
    """Whatever jerks it rounds, the plan is on the lattice and at rest; the others are the nearest integers.

    The last two are those that the oracle finds for rest.
    """
    random = np.random.default_rng(seed)
    units = lattice(*changes)
    own = some_plan(random, units, 9)
    wishes = random.normal(0, 5, (units.horizon, 3))
    plan = rounded(own, wishes)
    assert plan.at_rest
    assert (plan.jerks == np.rint(plan.jerks)).all()
    assert np.array_equal(plan.state, own.state_at(11))
    unit = float(units.jerk_unit)
    assert (np.abs(plan.jerks[:-2] * unit - wishes[:-2]) <= unit / 2).all()
    assert np.array_equal(resting(plan).jerks, plan.jerks)


@given(SEEDS)
@EVERY
@examples(20)
def test_rounding_moves_a_plan_by_little(changes: tuple[str, ...], seed: int) -> None:
    """Jerks that end at rest up to 1e-9 are changed by so little that no sample moves by more than a micrometre."""
    random = np.random.default_rng(seed)
    units = lattice(*changes)
    own = some_plan(random, units, 9)
    wanted = wander(random, own, 11, 0.5)
    wishes = wanted.jerks * float(units.jerk_unit) + random.uniform(-1e-9, 1e-9, (units.horizon, 3))
    plan = rounded(own, wishes)
    assert np.abs(plan.positions - wanted.positions).max() * float(units.position_unit) < 1e-6


def test_without_parity_there_is_no_rest_on_the_lattice() -> None:
    """From a state that no trajectory from a hover reaches, rounding ends between integers; the plan is refused."""
    units = lattice()
    state = hover(units, (0, 0, 1)).state.copy()
    state[1, 0] = units.steps**2
    own = Plan(units, 1, state, np.zeros((units.horizon, 3)))
    plan = rounded(own, np.zeros((units.horizon, 3)))
    planes = Planes(np.empty((0, 31, 3)), np.empty((0, 31, 3)), np.empty(0, np.bool_), ())
    assert "(12)" in str(broken_constraint(plan, own, planes))


def _crowd(random: np.random.Generator, units: Lattice, k: int) -> dict[int, tuple[Plan, ...]]:
    """Return other UAVs' trajectories in round k: up to three UAVs, with one or two trajectories each."""
    return {
        j: tuple(
            wander(random, hover(units, random.uniform(-1.5, 1.5, 3).tolist()), max(k - 5, 0), 0.5)
            for _ in range(random.integers(1, 3))
        )
        for j in range(1, random.integers(2, 5))
    }


def _followed_for(rounds: int, plans: Planner) -> None:
    """Replan a UAV every round among random neighbours; compare what it follows with one long exact integration.

    Another UAV hovers all the time, shifted every round.
    """
    random = np.random.default_rng(5)
    units = plans.models[0].lattice
    plan, still = hover(units, (0, 0, 1)), hover(units, (1.0, 1.0, 1.0))
    first_still = still
    T = units.parameters.T_s
    truth = flown(plan).state
    target = np.zeros(3)
    replanned = 0
    for k in range(rounds):
        # what is flown in this round is integrated by the oracle; nothing of the plan's own state is used again
        jerk = [int(u) * units.jerk_unit for u in plan.jerk_in(k)]
        truth = Flown(F(0), truth, [(jerk[0], jerk[1], jerk[2])], T).at(T)
        still = still.shifted(k + 1)
        if k % 7 == 0:
            target = random.uniform((-1.5, -1.5, 0.5), (1.5, 1.5, 2.5))
        task = Task(k, 0, plan, _crowd(random, units, k), frozenset({0, 1}), target)
        new = plans.plan(task).plan
        replanned += new is not None
        plan = plan if new is None else new
        p, v, a = plan.state_at(k + 1)
        assert [int(x) * units.position_unit for x in p] == [axis[0] for axis in truth]
        assert [int(x) * units.velocity_unit for x in v] == [axis[1] for axis in truth]
        assert [int(x) * units.acceleration_unit for x in a] == [axis[2] for axis in truth]
    assert np.array_equal(still.state, first_still.state)
    assert np.array_equal(still.positions, first_still.positions)
    # the comparison is of a UAV that did move on new plans all the time
    assert replanned > rounds // 3
    for _ in range(units.horizon):
        plan = plan.shifted(plan.start + 1)
    assert not plan.state[1:].any()


def test_nothing_drifts() -> None:
    """After 300 rounds of new plans, a UAV is where one exact integration of all its jerks says, to the unit."""
    _followed_for(300, planner(lattice()))


@pytest.mark.deep
def test_nothing_drifts_over_ten_thousand_rounds() -> None:
    """After 10,000 rounds of new plans, and after 10,000 rounds of hovering, the drift is exactly zero."""
    _followed_for(10_000, planner(lattice()))
