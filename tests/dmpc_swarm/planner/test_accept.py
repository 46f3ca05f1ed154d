"""The acceptance test decides every constraint of (13) as the oracle does: exactly, to the last lattice unit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import product
from math import gcd, isqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dmpc_swarm.flight.settings import (
    a_task,
    beside,
    broken,
    hover,
    lattice,
    random_task,
    resting,
    samples,
    wander,
)
from tests.margin.settings import TILTED, examples

from swarmproof.dmpc_swarm.planner import accept
from swarmproof.dmpc_swarm.planner.accept import broken_constraint, right_side, wrong_sides
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.motion.lattice import Floats, Lattice

F = Fraction
SEEDS = st.integers(0, 2**32)
#: Shorter than published, as the oracle takes its time.
UNITS = lattice(horizon=8)
#: The scaled distance d̂_min on the x axis; a whole number of units.
D_HAT = int(UNITS.parameters.d_hat_min / UNITS.position_unit)
#: What the oracle's texts contain where this module names a constraint.
IN_ORACLE = {
    "(13c)": "(13c)",
    "(13b)": "(13b)",
    "(13d): a velocity": "speed",
    "(13d): an acceleration": "acceleration",
    "(13d): a position": "box",
    "(13e)": "(13e)",
    "(13f)": "(15)",
}
ALONE = a_task(hover(UNITS, (0, 0, 1)), {})


def verdict(plan: Plan, task: Task) -> str | None:
    """Return the first constraint that `plan` breaks as a plan for the task."""
    return broken_constraint(plan, task.own, task.planes)


def sides(plan: Plan, task: Task) -> list[str]:
    """Return on whose wrong side the plan is, in the oracle's words."""
    owners = task.planes.owners
    found = []
    for trajectory, h in wrong_sides(plan, task.planes):
        j = owners[trajectory]
        several = f" c={trajectory - owners.index(j)}" if len(task.others[j]) > 1 else ""
        found.append(f"(15) j={j} h={h}{several}")
    return found


def agree(plan: Plan, task: Task) -> str | None:
    """Return the verdict, having compared it and all wrong sides with the oracle's."""
    found, truth = verdict(plan, task), broken(plan, task)
    if found is None:
        assert truth == []
    else:
        (name,) = (text for text in IN_ORACLE if found.startswith(text))
        assert any(IN_ORACLE[name] in text for text in truth), (found, truth)
    assert sorted(sides(plan, task)) == sorted(text for text in truth if text.startswith("(15)"))
    return found


# Random plans


def random_case(random: np.random.Generator, units: Lattice) -> tuple[Plan, Task]:
    """Return a random plan for a random task: it may break any constraint, by much or by little, or none."""
    task = random_task(random, units)
    plan = wander(random, task.own, task.start, float(random.choice([0.01, 0.3, 0.6, 1.0])))
    state, jerks = plan.state.copy(), plan.jerks.copy()
    if random.random() < 0.2:
        jerks[random.integers(units.horizon), random.integers(3)] += random.integers(-2, 3)
    if random.random() < 0.1:
        state[random.integers(3), random.integers(3)] += random.integers(-1, 2)
    return Plan(units, task.start, state, jerks), task


#: Horizon and changes: tight bounds, so that random plans break them now and then.
SHORT = [
    (5, (samples(2), "v_max=0.12")),
    (5, (samples(1), "a_max=0.6", "j_max=7", TILTED)),
    (5, (samples(3), TILTED, "v_max=0.1,2,2", "a_max=5,0.7,5")),
    (4, (samples(4), "j_max=20")),
]


@given(SEEDS)
@pytest.mark.parametrize(("horizon", "changes"), SHORT)
@examples(60)
def test_random_plans_are_judged_as_by_the_oracle(horizon: int, changes: tuple[str, ...], seed: int) -> None:
    """Accepted are the plans for which the oracle finds nothing; the wrong sides of planes are the same, one by one."""
    agree(*random_case(np.random.default_rng(seed), lattice(*changes, horizon=horizon)))


def test_random_plans_break_everything_now_and_then() -> None:
    """The random plans above are no easy ones: each constraint is broken by some, and some break none."""
    found = set()
    for n in range(200):
        horizon, changes = SHORT[n % len(SHORT)]
        text = verdict(*random_case(np.random.default_rng([n, 1]), lattice(*changes, horizon=horizon)))
        found.add(None if text is None else next(name for name in IN_ORACLE if text.startswith(name)))
    assert found == {None, *IN_ORACLE}


@pytest.mark.deep
@pytest.mark.parametrize(("horizon", "changes"), [*SHORT, (15, ()), (15, (TILTED, samples(3)))])
def test_thousands_of_random_plans_are_judged_as_by_the_oracle(horizon: int, changes: tuple[str, ...]) -> None:
    """The same for thousands of plans, with the published horizon, too."""
    units = lattice(*changes, horizon=horizon)
    for n in range(3000 if horizon < 15 else 700):
        agree(*random_case(np.random.default_rng([n, 2]), units))


# Exact boundaries


def swing(units: Lattice, own: Plan, axis: int, times: int) -> Plan:
    """Return a plan, from round 1 on, that moves there in three periods and back in three, exactly.

    How far is a multiple of `times`; only after the third period it is so far.
    """
    jerks = np.zeros((units.horizon, 3))
    jerks[:6, axis] = np.array([1, -2, 1, -1, 2, -1]) * times
    return Plan(units, 1, own.state_at(1), jerks)


def far(plan: Plan) -> Floats:
    """Return how far a plan is from its start after the third period, per axis."""
    distance: Floats = plan.positions[3 * plan.lattice.steps] - plan.positions[0]
    return distance


@pytest.mark.parametrize("selected", [(), (0, 1)])
@pytest.mark.parametrize(
    "direction",
    [(1.0, 0, 0), (0, -1.0, 0), (0, 0, 6.0), (0.6, 0.8, 0), (-0.8, 0, 3.6), (0.48, -0.64, 3.6), (0.36, 0.48, -4.8)],
)
def test_hovering_exactly_at_the_distance_is_accepted(
    direction: tuple[float, float, float], selected: tuple[int, ...]
) -> None:
    """Two UAVs at rest with the scaled distance d̂_min exactly are accepted; one unit less, on any axis, is refused."""
    offset = np.rint(np.array(direction) * 100) * (D_HAT // 100)
    assert sum(F(int(x), scale) ** 2 for x, scale in zip(offset, (1, 1, 6), strict=True)) == D_HAT**2
    own = hover(UNITS, (0, 0, 1))
    (there,) = own.positions[:1] + offset

    def judged(other: Floats) -> str | None:
        task = a_task(own, {1: [Plan.hovering(UNITS, other)]}, selected=selected)
        return agree(own.shifted(1), task)

    assert D_HAT % 100 == 0
    assert judged(there) is None
    for axis in np.flatnonzero(offset):
        nearer = there.copy()
        nearer[axis] -= np.sign(offset[axis])
        assert judged(nearer) == "(13f): it is on the wrong side of UAV 1's plane at sample 0"
        further = there.copy()
        further[axis] += np.sign(offset[axis])
        assert judged(further) is None


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("selected", [(), (0, 1)])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_plan_may_touch_the_plane_but_not_by_a_unit_more(axis: int, selected: tuple[int, ...], sign: int) -> None:
    """A plan that comes exactly as near as (15) allows, at one sample, is accepted; with the other one unit nearer,
    the plan is refused at this sample.

    Along an axis, (15) is: where it is to go is at least d̂_min from the other, and, if the other is planned, too,
    no further than half of what is left of their distance.
    """
    own = hover(UNITS, (0, 0, 1))
    plan = swing(UNITS, own, axis, sign * 1_000_001)
    least = D_HAT * (6 if axis == 2 else 1)
    apart = least + (2 if selected else 1) * abs(int(far(plan)[axis]))
    other = own.state[0].copy()
    other[axis] += np.sign(far(plan)[axis]) * apart
    task = a_task(own, {1: [Plan.hovering(UNITS, other)]}, selected=selected)
    assert agree(plan, task) is None
    other[axis] -= np.sign(far(plan)[axis])
    task = a_task(own, {1: [Plan.hovering(UNITS, other)]}, selected=selected)
    assert agree(plan, task) == "(13f): it is on the wrong side of UAV 1's plane at sample 6"


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_plan_may_touch_the_wall_but_not_by_a_unit_more(axis: int, sign: int) -> None:
    """A plan that reaches the last lattice position in the space is accepted, one that goes one unit on is refused."""
    wall = UNITS.high if sign > 0 else UNITS.low
    start = ALONE.own.state[0].copy()
    start[axis] = wall[axis] - far(swing(UNITS, ALONE.own, axis, sign * 999_999))[axis]
    own = Plan.hovering(UNITS, start)
    plan = swing(UNITS, own, axis, sign * 999_999)
    assert plan.positions[3 * UNITS.steps][axis] == wall[axis] != start[axis]
    assert agree(plan, a_task(own, {})) is None
    start[axis] += sign
    own = Plan.hovering(UNITS, start)
    beyond = Plan(UNITS, 1, own.state_at(1), plan.jerks)
    assert agree(beyond, a_task(own, {})) == "(13d): a position is outside the flying space"


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [-1, 1])
def test_the_largest_jerk_is_accepted_and_one_unit_more_is_not(axis: int, sign: int) -> None:
    """A jerk of exactly ±j_max passes, one of a unit more does not, though the plan ends at rest all the same."""
    bound = int(UNITS.j_max[axis])
    assert bound * UNITS.jerk_unit == UNITS.parameters.j_max[axis]
    plan = swing(UNITS, ALONE.own, axis, sign * bound // 2)
    assert np.abs(plan.jerks).max() == bound
    assert agree(plan, ALONE) is None
    jerks = plan.jerks.copy()
    jerks[1, axis] -= sign
    more = resting(Plan(UNITS, 1, plan.state, jerks))
    assert np.abs(more.jerks).max() == bound + 1
    assert agree(more, ALONE) == "(13c): a jerk is out of bounds"


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize(("what", "word"), [("v_max", "a velocity"), ("a_max", "an acceleration")])
def test_the_largest_speed_and_acceleration_are_accepted_and_less_is_not(axis: int, what: str, word: str) -> None:
    """A plan passes under a bound that is exactly its largest speed or acceleration, not under one a bit smaller."""

    def under(less: Fraction) -> str | None:
        plain = swing(UNITS, ALONE.own, axis, 12_345)
        reached, unit = {
            "v_max": (plain.velocities, UNITS.velocity_unit),
            "a_max": (plain.accelerations, UNITS.acceleration_unit),
        }[what]
        units = lattice(f"{what}={(int(np.abs(reached).max()) - less) * unit}", horizon=UNITS.horizon)
        own = hover(units, (0, 0, 1))
        return agree(Plan(units, 1, own.state_at(1), plain.jerks), a_task(own, {}))

    assert under(F(0)) is None
    for less in (F(1), F(1, 1000)):
        assert under(less) == f"(13d): {word} is out of bounds"


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("by", [-1, 1])
def test_rest_is_missed_by_one_unit(axis: int, by: int) -> None:
    """A plan whose last jerk is one unit off does not end at rest, and is refused."""
    plan = swing(UNITS, ALONE.own, axis, 1000)
    jerks = plan.jerks.copy()
    jerks[-1, axis] += by
    assert agree(Plan(UNITS, 1, plan.state, jerks), ALONE) == "(13e): it does not end at rest"


@pytest.mark.parametrize("by", [-1, 1])
@pytest.mark.parametrize(("row", "axis"), list(product(range(3), range(3))))
def test_the_initial_state_is_that_of_the_old_trajectory(row: int, axis: int, by: int) -> None:
    """A plan whose position, velocity or acceleration begins one unit off is refused for it (13b)."""
    own = wander(np.random.default_rng(3), hover(UNITS, (0, 0, 1)), 0, 0.03)
    assert own.state_at(1).all()
    task = a_task(own, {})
    assert agree(own.shifted(1), task) is None
    state = own.state_at(1).copy()
    state[row, axis] += by
    moved = resting(Plan(UNITS, 1, state, own.shifted(1).jerks)) if row == 0 else Plan(UNITS, 1, state, own.jerks)
    assert agree(moved, task) == "(13b): it does not begin in the state of the old trajectory"


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 0.5, 2.0**-30, 1e300])
@pytest.mark.parametrize("where", [(0, 0), (5, 1), (7, 2)])
def test_what_is_no_jerk_of_the_lattice_is_refused(value: float, where: tuple[int, int]) -> None:
    """NaN, infinity, fractions and huge numbers are refused wherever they stand, without an error and with a reason."""
    jerks = np.zeros((UNITS.horizon, 3))
    jerks[where] = value
    with np.errstate(invalid="ignore", over="ignore"):
        found = verdict(Plan(UNITS, 1, ALONE.own.state_at(1), jerks), ALONE)
    assert found == (
        "(13c): a jerk is out of bounds" if value == 1e300 else "(12): the jerks are not numbers of the lattice"
    )


def test_a_state_of_nan_is_refused() -> None:
    """An initial state of NaN equals no state."""
    state = ALONE.own.state_at(1).copy()
    state[0, 0] = np.nan
    assert str(verdict(Plan(UNITS, 1, state, np.zeros((UNITS.horizon, 3))), ALONE)).startswith("(13b)")


def test_the_nan_rule_matters(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its test for whole numbers, acceptance would let a jerk of half a unit pass."""
    jerks = np.zeros((UNITS.horizon, 3))
    jerks[:3, 0] = (0.5, -1, 0.5)
    plan = Plan(UNITS, 1, ALONE.own.state_at(1), jerks)
    assert verdict(plan, ALONE) == "(12): the jerks are not numbers of the lattice"
    monkeypatch.setattr(np, "rint", lambda array: array)
    assert verdict(Plan(UNITS, 1, ALONE.own.state_at(1), jerks), ALONE) is None


@pytest.mark.parametrize("selected", [(), (0, 1)])
def test_where_there_is_no_plane_nothing_is_accepted(selected: tuple[int, ...]) -> None:
    """If old trajectory and neighbour meet at a sample, (14) is no normal: no plan is on the right side of it."""
    own = hover(UNITS, (0, 0, 1))
    task = a_task(own, {1: [hover(UNITS, (0, 0, 1))]}, selected=selected)
    assert not right_side((0.0, 0.0, 0.0), (5.0, 0.0, 0.0), bool(selected), UNITS)
    assert str(agree(own.shifted(1), task)).startswith("(13f)")


def test_each_trajectory_of_a_neighbour_counts() -> None:
    """A plan is refused for the second trajectory of a UAV, and for that of the last one of several UAVs."""
    own, away, near = (hover(UNITS, (x, 0, 1)) for x in (0.0, 1.0, 0.2))
    plan = own.shifted(1)
    assert agree(plan, a_task(own, {1: [away, away], 2: [away]})) is None
    assert str(agree(plan, a_task(own, {1: [away, near], 2: [away]}))).endswith("UAV 1's plane at sample 0")
    assert str(agree(plan, a_task(own, {1: [away, away], 5: [away], 2: [near]}))).endswith("UAV 2's plane at sample 0")


def test_only_the_samples_count() -> None:
    """Between the samples a plan may be on the wrong side: (13f) does not see it, nor does the oracle (that gap is
    what Theorem 3 is about)."""
    units = lattice(samples(1))
    own = hover(units, (0, 0, 1))
    # symmetric about the middle of the third period
    jerks = np.zeros((units.horizon, 3))
    jerks[:5, 0] = np.array([1, -2, 0, 2, -1]) * (int(units.j_max[0]) // 2)
    plan = Plan(units, 1, own.state, jerks)
    sampled, crest = plan.positions[2, 0], plan.position(2.5)[0]
    assert abs(crest) > abs(sampled) == np.abs(plan.positions[:, 0]).max()
    towards = np.sign(sampled - plan.positions[0, 0])
    d_hat = -(-units.parameters.d_hat_min // units.position_unit)
    other = own.state[0].copy()
    other[0] = sampled + towards * d_hat
    task = a_task(own, {1: [Plan.hovering(units, other)]})
    assert abs(other[0] - crest) < d_hat
    assert agree(plan, task) is None


# Where float64 cannot decide

#: With Θ = 1, L = 1 and hence q = p: any integers can be coordinates.
PLAIN = lattice(samples(1), "theta_inverse=1", horizon=2)


def still(point: Sequence[int]) -> Plan:
    """Return a hover at a lattice position."""
    return Plan.hovering(PLAIN, np.array(point, float))


def placed(normal: Sequence[int], apart: Sequence[int], selected: bool) -> tuple[Plan, Task]:
    """Return hovers of which n_ij and Δ are the given integers: a new trajectory, and the task with old and other."""
    task = a_task(still([0, 0, 0]), {1: [still(normal)]}, selected={0, 1} if selected else ())
    new = still([n - d for n, d in zip(normal, apart, strict=True)])
    return Plan(PLAIN, 1, new.state, new.jerks), task


def with_product(normal: tuple[int, int, int], value: int) -> tuple[int, int, int]:
    """Return integers Δ of about the length |value| / ‖n‖ and along n with n·Δ = value; n_x and n_y are coprime."""
    square = sum(n * n for n in normal)
    x, y, z = (value * n // square for n in normal)
    rest = value - sum(n * d for n, d in zip(normal, (x, y, z), strict=True))
    dx = rest * pow(normal[0], -1, abs(normal[1])) % abs(normal[1])
    return x + dx, y + (rest - normal[0] * dx) // normal[1], z


def tight(random: np.random.Generator, selected: bool, over: int) -> tuple[Plan, Task]:
    """Return a plane and a plan that misses it by as little as integers can, `over` integers above (negative: below).

    The two sides of (15), times ‖n‖, are about 2⁷⁰ and differ by less than |over| + 1, or |over| + ½.
    """
    while True:
        x, y, z = (int(n) for n in random.integers(-(2**37), 2**37, 3))
        if abs(y) > 1 and gcd(x, y) == 1:
            break
    square = x * x + y * y + z * z
    d_hat = PLAIN.parameters.d_hat_min / PLAIN.position_unit
    needed = isqrt(int(d_hat**2 * square))
    assert d_hat.denominator == 1
    if selected:
        needed = (needed + square) // 2
    return placed((x, y, z), with_product((x, y, z), needed + over), selected)


def count_calls(monkeypatch: pytest.MonkeyPatch) -> Callable[[], int]:
    """Return what says how often the exact test was asked."""
    calls = []

    def counted(*asked: Any) -> bool:
        calls.append(1)
        return right_side(*asked)

    monkeypatch.setattr(accept, "right_side", counted)
    return lambda: len(calls)


@pytest.mark.parametrize("selected", [False, True])
def test_planes_that_float64_cannot_tell_are_decided_exactly(monkeypatch: pytest.MonkeyPatch, selected: bool) -> None:
    """A plan one integer above or below a plane, where the integers have 22 digits, is judged as by the oracle.

    Each time, and whatever float64 says, the exact test is asked.
    """
    calls = count_calls(monkeypatch)
    random = np.random.default_rng(7)
    for n in range(150):
        over = (0, 1, 2, -1)[n % 4]
        plan, task = tight(random, selected, over)
        before = calls()
        found = sides(plan, task)
        assert calls() == before + 3
        assert found == [text for text in broken(plan, task) if text.startswith("(15)")]
        # isqrt rounds down: `over` integers above are right if positive, and wrong if not (no square root is whole)
        assert len(found) == (0 if over > 0 else 3)


@pytest.mark.parametrize("selected", [False, True])
def test_float64_alone_would_be_wrong(monkeypatch: pytest.MonkeyPatch, selected: bool) -> None:
    """Without the bound on its rounding, the float test lets plans out that break (13f), and refuses some that do not:
    the cases of the test before catch it."""
    monkeypatch.setattr(accept, "ROUNDOFF", 0.0)
    monkeypatch.setattr(accept, "right_side", lambda *_: False)
    random = np.random.default_rng(7)
    wrongly_out, wrongly_in = 0, 0
    for n in range(200):
        right = n % 2 == 1
        plan, task = tight(random, selected, int(right))
        found = sides(plan, task)
        wrongly_out += bool(found) and right
        wrongly_in += not found and not right
    assert wrongly_in > 10
    assert wrongly_out > 10


@given(
    st.tuples(*[st.integers(-(2**50), 2**50)] * 3),
    st.tuples(*[st.integers(-(2**50), 2**50)] * 3),
    st.booleans(),
)
@examples(300)
def test_the_sign_of_any_plane_is_exact(
    normal: tuple[int, int, int], apart: tuple[int, int, int], selected: bool
) -> None:
    """For whatever integers up to 2⁵⁰, small, huge or zero, the verdict is the oracle's."""
    plan, task = placed(normal, apart, selected)
    assert sides(plan, task) == [text for text in broken(plan, task) if text.startswith("(15)")]


@given(SEEDS)
@pytest.mark.parametrize("changes", [(), (samples(3), TILTED)])
@examples(40)
def test_distances_near_the_bound_are_judged_as_by_the_oracle(changes: tuple[str, ...], seed: int) -> None:
    """The old trajectory is a candidate exactly if nobody is nearer than d̂_min at any sample, by a single unit, too.

    The neighbour is put beside a moving UAV at a random sample in a random direction, d̂_min away up to some units.
    """
    random = np.random.default_rng(seed)
    units = lattice(*changes, horizon=6)
    own = wander(random, hover(units, (0, 0, 1)), 0, 0.3)
    theta = np.array(units.parameters.theta_inverse, float)
    direction = random.normal(size=3)
    h = random.integers(1, 6 * units.steps + 1)
    d_hat = float(units.parameters.d_hat_min / units.position_unit)
    offset = np.linalg.solve(theta, d_hat * direction / np.linalg.norm(direction))
    place = np.rint(own.sampled_from(1)[h] + offset) + random.integers(-2, 3, 3)
    # one that stands, and one that flies the same way beside it: the distance is then the same at all samples
    flying = beside(own, np.rint(offset) + random.integers(-2, 3, 3))
    selected = {0, 1} if random.random() < 0.5 else ()
    for other in (Plan.hovering(units, place), flying):
        agree(own.shifted(1), a_task(own, {1: [other]}, selected=selected))


def test_distances_near_the_bound_are_on_both_sides_of_it() -> None:
    """The cases of the test before are no easy ones: UAVs side by side are refused by a unit, or accepted by one."""
    own = wander(np.random.default_rng(1), hover(UNITS, (0, 0, 1)), 0, 0.3)
    found = []
    for n in range(40):
        random = np.random.default_rng(n)
        angle = random.uniform(0, 2 * np.pi)
        offset = np.rint(D_HAT * np.array([np.cos(angle), np.sin(angle), 0]))
        found.append(verdict(own.shifted(1), a_task(own, {1: [beside(own, offset)]})) is None)
    assert 5 < sum(found) < 35
