"""The oracle for plans and separation decides hand-made cases as the paper does, to the last lattice unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from tests.dmpc_swarm.planner.oracle import (
    AXES,
    Array,
    Flown,
    Limits,
    State,
    TooClose,
    Vector,
    Weights,
    broken_constraints,
    closest,
    plan_cost,
    planned,
    reference_qp,
    rested,
    separation_violations,
    squared_distance,
    vector,
)

F = Fraction
PUBLISHED = Limits()
#: m/s³ and m; the units of jerk and position on a lattice with steps of T_c.
JERK = F(1, 2**26)
UNIT = JERK * PUBLISHED.T_c**3 / 6
#: A scaling that mixes the axes; symmetric positive definite.
TILTED = (vector(1, "0.3", 0), vector("0.3", "0.8", "-0.2"), vector(0, "-0.2", "0.5"))
#: s; when the plan of round 0 begins.
BEGIN = PUBLISHED.T


def _still(x: Fraction | int | str, y: Fraction | int | str, z: Fraction | int | str) -> State:
    a, b, c = (vector(value, 0, 0) for value in (x, y, z))
    return a, b, c


def _hover(x: Fraction | int | str, y: Fraction | int | str, z: Fraction | int | str) -> Flown:
    return Flown(F(0), _still(x, y, z), [])


def _on(axis: int, value: Fraction) -> Vector:
    x, y, z = (value if c == axis else F(0) for c in range(3))
    return x, y, z


OLD = _hover(0, 0, 1)


def _plan(jerks: Sequence[Vector], old: Flown = OLD, k: int = 0) -> Flown:
    """Return the plan of round k that continues `old` with these jerks, then with none."""
    begin = (k + 1) * PUBLISHED.T
    rest = [vector(0, 0, 0)] * (PUBLISHED.H - len(jerks))
    return Flown(begin, old.at(begin), [*jerks, *rest])


def _move(axis: int, by: Fraction) -> list[Vector]:
    """Return three jerks that move a UAV at rest by so much, and leave it at rest.

    Of the jerks -j/2, j, -j/2, the position is -jT³/12, -5jT³/12 and -jT³/2 after the first, second and third,
    the velocity -jT²/4 twice and then 0, the acceleration -jT/2, jT/2 and 0.
    """
    j = -2 * by / PUBLISHED.T**3
    return [_on(axis, -j / 2), _on(axis, j), _on(axis, -j / 2)]


def _swing(axis: int, by: Fraction) -> list[Vector]:
    """Return six jerks that move a UAV there and back; at a sample, it is so far away at h = 6 (κ = 3) only."""
    return _move(axis, by) + _move(axis, -by)


def _broken(
    new: Flown,
    neighbours: Mapping[int, Sequence[Flown]] | None = None,
    selected: Sequence[int] = (),
    limits: Limits = PUBLISHED,
    old: Flown = OLD,
    k: int = 0,
) -> list[str]:
    return broken_constraints(new, old, neighbours or {}, set(selected), limits, k)


def _random_flown(random: np.random.Generator, start: Fraction, size: int = 1000) -> Flown:
    """Return a trajectory of random decimals: about 1 m, 1 m/s, 1 m/s² and 5 m/s³."""

    def some(bound: int) -> Vector:
        return vector(*(F(int(n), 1000) for n in random.integers(-bound, bound + 1, 3)))

    position, velocity, acceleration = some(size), some(1000), some(1000)
    x, y, z = zip(position, velocity, acceleration, strict=True)
    return Flown(start, (x, y, z), [some(5000) for _ in range(15)])


# Trajectories


def test_a_trajectory_is_the_integral_of_its_jerks() -> None:
    """Before, at and after its knots and its end, a state is what truncated powers of each jerk add up to."""
    random = np.random.default_rng(1)
    flown = _random_flown(random, F(3, 5))
    for n in [*range(0, 40), 150, 155]:
        s = F(n, 10) / 4 * 3
        state = flown.at(F(3, 5) + s)
        for axis, (p, v, a) in enumerate(flown.state):
            ages = [(max(s - F(i, 5), F(0)), max(s - F(i + 1, 5), F(0))) for i in range(15)]
            on = [(x, y, jerk[axis]) for (x, y), jerk in zip(ages, flown.jerks, strict=True)]
            expected = (
                p + v * s + a * s**2 / 2 + sum(u * (x**3 - y**3) / 6 for x, y, u in on),
                v + a * s + sum(u * (x**2 - y**2) / 2 for x, y, u in on),
                a + sum(u * (x - y) for x, y, u in on),
            )
            assert state[axis] == expected


def test_a_trajectory_steps_in_integers_on_the_lattice() -> None:
    """In units of the lattice, a step of T_c is p + 3v + 3a + u, v + 2a + u, a + u, in integers."""
    random = np.random.default_rng(2)
    h = PUBLISHED.T_c
    units = (UNIT, JERK * h**2 / 2, JERK * h)
    p, v, a, u = (int(n) for n in random.integers(-(2**30), 2**30, 4))
    axis = vector(p * units[0], v * units[1], a * units[2])
    flown = Flown(F(0), (axis, axis, axis), [vector(u * JERK, u * JERK, u * JERK)])
    for step in range(1, 3):
        p, v, a = p + 3 * v + 3 * a + u, v + 2 * a + u, a + u
        assert flown.at(step * h)[0] == (p * units[0], v * units[1], a * units[2])


def test_after_its_end_a_trajectory_goes_on_without_jerk() -> None:
    """One that ends at rest stays there, another one goes on accelerating; there is nothing before the start."""
    assert _plan(_move(0, F(1, 100))).at(F(100)) == _still("0.01", 0, 1)
    moving = Flown(F(1), (vector(0, 0, 2),) * 3, [])
    assert moving.at(F(4))[2] == vector(9, 6, 2)
    with pytest.raises(ValueError, match="starts at 1 s"):
        moving.at(F(1) - JERK)


def test_rest_is_made_exact() -> None:
    """Changed in its last two jerks only, any plan ends exactly at rest; one that does is not changed."""
    plan = _random_flown(np.random.default_rng(3), BEGIN)
    made = rested(plan)
    assert made.jerks[:-2] == plan.jerks[:-2]
    assert all(v and a for _, v, a in plan.at(BEGIN + 3))
    assert not any(v or a for _, v, a in made.at(BEGIN + 3))
    assert rested(made) == made


# (12) to (13e)


@pytest.mark.parametrize("selected", [(), (1,)])
@pytest.mark.parametrize("offset", [vector("1/4", 0, 0), vector("-3/20", "1/5", 0), vector(0, 0, "3/2")])
def test_a_hovering_pair_is_feasible_from_the_minimum_distance_on(offset: Vector, selected: tuple[int, ...]) -> None:
    """Hovering is feasible at the scaled distance d̂_min, and at no sample if it is one lattice unit less."""
    x, y, z = offset
    assert _broken(_plan([]), {1: [_hover(x, y, 1 + z)]}, selected) == []
    closer = _hover(x - UNIT if x > 0 else x, y - UNIT if y else y, 1 + (z - UNIT if z else z))
    assert _broken(_plan([]), {1: [closer]}, selected) == [f"(15) j=1 h={h}" for h in range(31)]


@pytest.mark.parametrize(
    "change",
    [
        {"start": BEGIN + JERK},
        {"start": F(0)},
        {"period": F(1, 10)},
        {"jerks": [vector(0, 0, 0)] * 14},
        {"jerks": [vector(0, 0, 0)] * 16},
    ],
)
def test_what_is_no_plan_of_the_round_is_refused(change: dict[str, Any]) -> None:
    """A plan has H inputs of one period each, from the start of the next round on (12)."""
    assert _broken(_plan([])) == []
    assert _broken(replace(_plan([]), **change)) == ["(12)"]
    assert _broken(_plan([]), k=1) == ["(12)"]


@pytest.mark.parametrize("axis", range(3))
def test_a_plan_continues_the_old_trajectory(axis: int) -> None:
    """A position, velocity or acceleration other than the old one by one lattice unit breaks (13b), on its axis."""
    old = replace(_plan(_move(axis, F(1, 100))), start=F(0))
    k = 1
    plan = _plan(old.jerks[2:], old, k)
    assert _broken(plan, old=old, k=k) == []
    for quantity, unit in enumerate((UNIT, JERK * PUBLISHED.T_c**2 / 2, JERK * PUBLISHED.T_c)):
        state = [list(entry) for entry in plan.state]
        state[axis][quantity] += unit
        x, y, z = (vector(*entry) for entry in state)
        moved = rested(replace(plan, state=(x, y, z)))
        assert _broken(moved, old=old, k=k) == [f"(13b) {AXES[axis]}"]


def test_the_round_decides_where_a_plan_begins() -> None:
    """A plan of round k begins with the old state at (k+1)T, not that of the round before or after."""
    old = replace(_plan(_swing(1, F(1, 50))), start=F(0))
    for k in range(5):
        assert _broken(_plan(old.jerks[k + 1 :], old, k), old=old, k=k) == []
        for other in (k - 1, k + 1):
            wrong = replace(_plan(old.jerks[other + 1 :], old, other), start=(k + 1) * BEGIN)
            assert _broken(wrong, old=old, k=k) == ["(13b) y"]


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [-1, 1])
def test_bounds_are_closed(axis: int, sign: int) -> None:
    """A jerk, position, speed or acceleration at its bound is accepted; a bound one lattice unit lower is broken."""
    name = AXES[axis]
    move, swing = _plan(_move(axis, F(sign, 100))), _plan(_swing(axis, F(sign, 100)))

    def bounded(which: str, value: Fraction) -> Limits:
        if which != "box":
            bounds = list(getattr(PUBLISHED, which))
            bounds[axis] = value
            changed: dict[str, Any] = {which: vector(*bounds)}
            return replace(PUBLISHED, **changed)
        box = list(PUBLISHED.box)
        low, high = box[axis]
        # the UAV starts at height 1
        edge = sign * value + (1 if axis == 2 else 0)
        box[axis] = (low, edge) if sign > 0 else (edge, high)
        return replace(PUBLISHED, box=(box[0], box[1], box[2]))

    cases: list[tuple[Flown, str, Fraction, Fraction, list[str]]] = [
        # j = 2.5 m/s³ in the second period only
        (move, "j_max", F(5, 2), JERK, [f"(13c) κ=1 {name}"]),
        (swing, "box", F(1, 100), UNIT, [f"(13d) κ=3 {name} box"]),
        # between κ = 1 and 2 it is faster than jT²/4, which is allowed: X binds at multiples of T_b
        (move, "v_max", F(1, 40), JERK * F(1, 200), [f"(13d) κ={n} {name} speed" for n in (1, 2)]),
        (move, "a_max", F(1, 4), JERK * F(1, 10), [f"(13d) κ={n} {name} acceleration" for n in (1, 2)]),
    ]
    for plan, which, value, unit, expected in cases:
        assert _broken(plan, limits=bounded(which, value)) == []
        assert _broken(plan, limits=bounded(which, value - unit)) == expected
    assert abs(move.at(BEGIN + F(3, 10))[axis][1]) > F(1, 40)


def test_the_state_is_bounded_from_the_begin_to_the_end() -> None:
    """Hovering on the edge of the box is accepted; one unit outside, every state of κ = 0 … H is reported."""
    for edge, outwards in ((F(-37, 10), -1), (F(37, 10), 1)):
        inside, outside = _hover(0, edge, 1), _hover(0, edge + outwards * UNIT, 1)
        assert _broken(_plan([], inside), old=inside) == []
        assert _broken(_plan([], outside), old=outside) == [f"(13d) κ={n} y box" for n in range(16)]


@pytest.mark.parametrize("last", [(0, 1), (1, -1), (1, -3)])
@pytest.mark.parametrize("axis", range(3))
def test_a_plan_ends_at_rest(axis: int, last: tuple[int, int]) -> None:
    """One unit of jerk too much leaves a velocity, an acceleration or both, which breaks (13e)."""
    plan = _plan([])
    jerks = [*plan.jerks[:-2], *(_on(axis, n * JERK) for n in last)]
    assert _broken(replace(plan, jerks=jerks)) == [f"(13e) {AXES[axis]}"]
    _, v, a = replace(plan, jerks=jerks).at(BEGIN + 3)[axis]
    assert (v != 0, a != 0) == {(0, 1): (True, True), (1, -1): (True, False), (1, -3): (False, True)}[last]


# (15)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [-1, 1])
def test_the_plane_is_where_the_paper_puts_it(axis: int, sign: int) -> None:
    """A swing of s towards UAV j needs d̂ + s between the UAVs, d̂ + 2s if j is planned, too, and no unit less."""
    swing = F(sign, 100)
    plan = _plan(_swing(axis, swing))
    wide = sign * (6 if axis == 2 else 1) * PUBLISHED.d_hat_min

    def at(distance: Fraction) -> Flown:
        offset = _on(axis, distance)
        return _hover(offset[0], offset[1], 1 + offset[2])

    one, both = wide + swing, wide + 2 * swing
    assert _broken(plan, {1: [at(one)]}) == []
    assert _broken(plan, {1: [at(one - sign * UNIT)]}) == ["(15) j=1 h=6"]
    assert _broken(plan, {1: [at(both)]}, [1]) == []
    assert _broken(plan, {1: [at(both - sign * UNIT)]}, [1]) == ["(15) j=1 h=6"]
    # that of another UAV, or the other direction, is not in the way
    assert _broken(plan, {1: [at(one)]}, [2]) == []
    assert _broken(plan, {1: [at(-wide)]}) == []


def test_every_trajectory_of_a_tracker_counts() -> None:
    """Of two trajectories of one UAV, the one that is too close is named, with its sample; so is its UAV."""
    plan = _plan(_swing(0, F(1, 100)))
    near, far = _hover(F(26, 100) - UNIT, 0, 1), _hover("0.26", 0, 1)
    assert _broken(plan, {4: [far, near], 2: [far]}) == ["(15) j=4 h=6 c=1"]
    assert _broken(plan, {4: [far], 2: [near, near]}) == ["(15) j=2 h=6 c=0", "(15) j=2 h=6 c=1"]


@pytest.mark.parametrize("selected", [(), (1,)])
def test_beyond_the_plane_is_broken(selected: tuple[int, ...]) -> None:
    """A UAV far behind the other one is on the wrong side, although the square of a negative number is large."""
    fast = replace(PUBLISHED, j_max=vector(10**4, 5, 5), v_max=vector(100, 2, 2), a_max=vector(10**3, 5, 5))
    broken = _broken(_plan(_swing(0, F(6, 5))), {1: [_hover("0.3", 0, 1)]}, selected, fast)
    assert "(15) j=1 h=6" in broken
    assert all(text.startswith("(15)") for text in broken)


def test_planes_stand_where_the_old_trajectory_is() -> None:
    """A UAV that keeps its distance, but leaves the half-space seen from its old trajectory, breaks (15)."""
    fast = replace(PUBLISHED, j_max=vector(10**4, 10**4, 5), v_max=vector(100, 100, 2), a_max=vector(10**3, 10**3, 5))
    sideways = _swing(0, F(1))
    both = [vector(side[0], up[1], 0) for side, up in zip(sideways, _swing(1, F(1, 10)), strict=True)]
    other = _hover(0, "0.3", 1)
    assert _broken(_plan(sideways), {1: [other]}, limits=fast) == []
    assert "(15) j=1 h=6" in _broken(_plan(both), {1: [other]}, limits=fast)
    assert squared_distance(_plan(both), other, BEGIN + 6 * PUBLISHED.T_c, PUBLISHED) > 1


@pytest.mark.parametrize("selected", [(), (1,)])
def test_without_a_plane_nothing_is_feasible(selected: tuple[int, ...]) -> None:
    """Where two old trajectories meet, n = 0 has no direction: (15) is broken, not 0 ≥ 0."""
    assert _broken(_plan([]), {1: [OLD]}, selected) == [f"(15) j=1 h={h}" for h in range(31)]


def _printed(
    new: Flown, old: Flown, neighbours: Mapping[int, Sequence[Flown]], selected: int, limits: Limits, k: int
) -> list[str]:
    """Return the broken rows by eq. (15) as printed, with roots, in decimals of 60 digits."""
    theta_inverse = [[Decimal(x.numerator) / x.denominator for x in row] for row in limits.theta_inverse]

    def scaled(a: list[Decimal], b: list[Decimal]) -> list[Decimal]:
        return [sum((m * (x - y) for m, x, y in zip(row, a, b, strict=True)), Decimal(0)) for row in theta_inverse]

    broken = []
    d = Decimal("0.25")
    for j, trajectories in neighbours.items():
        for c, other in enumerate(trajectories):
            for h in range(31):
                t = (k + 1) * F(1, 5) + h * F(1, 10)
                p_i, p_old, p_j = (
                    [Decimal(x.numerator) / x.denominator for x in flown.position(t)] for flown in (new, old, other)
                )
                n, e = scaled(p_j, p_old), scaled(p_j, p_i)
                norm = sum((x * x for x in n), Decimal(0)).sqrt()
                left = sum((x / norm * y for x, y in zip(n, e, strict=True)), Decimal(0))
                right = (d + norm) / 2 if j == selected else d
                # Positions are below 10² and norms above 10⁻⁵ here, so rounding errors are below 10⁻⁴⁰: a difference of
                # more has its sign right.
                assert norm > Decimal("1e-5")
                assert abs(left - right) > Decimal("1e-30")
                if left < right:
                    broken.append(f"(15) j={j} h={h} c={c}")
    return broken


@pytest.mark.parametrize("limits", [PUBLISHED, replace(PUBLISHED, theta_inverse=TILTED)])
def test_random_planes_agree_with_the_printed_formula(limits: Limits) -> None:
    """With moving UAVs of different starts, the exact decision is that of eq. (15) evaluated with 60 digits."""
    random = np.random.default_rng(4)
    kept = lost = 0
    with localcontext() as context:
        context.prec = 60
        for k in range(12):
            old = _random_flown(random, k * BEGIN - F(1, 7), size=600)
            begin = (k + 1) * BEGIN
            new = replace(_random_flown(random, begin), state=old.at(begin))
            neighbours = {j: [_random_flown(random, begin - F(j + c, 9)) for c in range(2)] for j in (1, 2)}
            rows = [text for text in _broken(new, neighbours, [2], limits, old, k) if text.startswith("(15)")]
            assert rows == _printed(new, old, neighbours, 2, limits, k)
            kept, lost = kept + 4 * 31 - len(rows), lost + len(rows)
    # both answers occur often
    assert min(kept, lost) > 100


# (20) and (21)


def test_separation_is_checked_for_every_pair_of_candidates() -> None:
    """Any candidates of two different UAVs must be d̂_min apart; d̂_min itself is, one lattice unit less is not."""
    two = [_hover(0, 0, 1), _hover(0, "0.1", 1)]
    times = [BEGIN, 2 * BEGIN]
    fine = {0: two, 3: [_hover("0.25", 0, 1), _hover("0.15", "-0.2", 1)], 1: [_hover(0, 0, "-0.5")]}
    assert separation_violations(fine, times, PUBLISHED) == []
    x = F(1, 4) - UNIT
    near = {**fine, 3: [_hover(2, 0, 1), _hover(x, 0, 1)]}
    assert separation_violations(near, times, PUBLISHED) == [TooClose(0, 0, 3, 1, t, x**2) for t in times]


def test_separation_is_checked_at_the_given_times() -> None:
    """A swing is too close at the sample where it is widest, which a list without this sample does not show."""
    swing, other = _plan(_swing(0, F(1, 100))), _hover("0.26", 0, 1)
    times = [BEGIN + h * PUBLISHED.T_c for h in range(31)]
    assert separation_violations({0: [swing], 1: [other]}, times, PUBLISHED) == []
    nearer = {0: [swing], 1: [_hover(F(26, 100) - UNIT, 0, 1)]}
    (found,) = separation_violations(nearer, times, PUBLISHED)
    assert found.time == times[6]
    assert separation_violations(nearer, times[:6] + times[7:], PUBLISHED) == []


def test_the_closest_approach_is_that_of_a_passage() -> None:
    """A UAV that passes another one is closest abeam, in the scaled norm; without that instant the bound is larger."""
    passing = Flown(F(0), (vector(-1, 1, 0), vector("0.3", 0, 0), vector("2.4", 0, 0)), [])
    least = F(9, 100) + F(4, 10) ** 2
    zero = _hover(0, 0, 0)
    assert closest(passing, zero, F(0), F(2), PUBLISHED) == least
    assert closest(zero, passing, F(0), F(1), PUBLISHED, steps=1) == least
    assert closest(passing, zero, F(0), F(2), PUBLISHED, steps=3) == least + F(1, 9)
    assert closest(passing, zero, F(3, 2), F(2), PUBLISHED) == least + F(1, 4)


# The reference solution


START = _hover("-0.6", 0, 1)
#: One UAV in the way, one beside it with two candidates, one planned at the same time.
NEIGHBOURS = {
    1: [_hover(0, "0.05", 1)],
    2: [_hover("0.2", "-0.5", 1), _hover("0.2", "-0.6", "1.3")],
    5: [_hover(-1, 1, 1)],
}
SELECTED = (5,)
TARGET = (0.8, 0.0, 1.2)
W_J = {1: 60.0, 2: 1.0}
WEIGHTS = Weights()


def _tightened(limits: Limits, by: Fraction) -> Limits:
    """Return limits whose every inequality is stricter by `by`, in its unit (those of (15) by half of it or more)."""

    def less(bounds: Vector) -> Vector:
        return vector(*(bound - by for bound in bounds))

    x, y, z = ((low + by, high - by) for low, high in limits.box)
    d_hat_min, v_max, a_max, j_max = limits.d_hat_min + by, less(limits.v_max), less(limits.a_max), less(limits.j_max)
    return replace(limits, d_hat_min=d_hat_min, v_max=v_max, a_max=a_max, j_max=j_max, box=(x, y, z))


def _reference(
    old: Flown = START,
    neighbours: Mapping[int, Sequence[Flown]] = NEIGHBOURS,
    selected: Sequence[int] = SELECTED,
    target: Sequence[float] = TARGET,
    limits: Limits = PUBLISHED,
    weights: Weights = WEIGHTS,
    w_j: Mapping[int, float] = W_J,
    k: int = 0,
) -> Flown:
    """Return the answer as a plan that ends exactly at rest."""
    pytest.importorskip("clarabel")
    answer = reference_qp(old, neighbours, selected, target, limits, weights, w_j, k)
    assert answer is not None
    return rested(planned(old, answer[0], limits, k))


def _cost(plan: Flown, w_j: Mapping[int, float] = W_J) -> float:
    return plan_cost(plan, START, NEIGHBOURS, SELECTED, TARGET, PUBLISHED, WEIGHTS, w_j, 0)


@pytest.mark.parametrize("limits", [PUBLISHED, replace(PUBLISHED, theta_inverse=TILTED)])
def test_the_reference_is_feasible_to_its_tolerance(limits: Limits) -> None:
    """The answer misses no bound by 1e-6, and that to limits stricter by 1e-6 breaks no constraint at all."""
    by = F(1, 10**6)
    plan = _reference(limits=limits)
    assert _broken(plan, NEIGHBOURS, SELECTED, _tightened(limits, -by), START) == []
    strict = _tightened(limits, by)
    assert _broken(_reference(limits=strict), NEIGHBOURS, SELECTED, limits, START) == []
    # its last two jerks were changed by less than this, too
    answer = reference_qp(START, NEIGHBOURS, SELECTED, TARGET, limits, WEIGHTS, W_J, 0)
    assert answer is not None
    assert np.max(np.abs(answer[0] - np.array(plan.jerks, dtype=float))) < 1e-6
    # constraints matter here: without UAV 1, its row would be broken
    alone = _reference(neighbours={}, selected=(), limits=limits)
    assert any(text.startswith("(15) j=1") for text in _broken(alone, NEIGHBOURS, SELECTED, limits, START))


def _feasible_plans(count: int) -> list[Flown]:
    """Return answers to random targets and jerk weights, 1e-4 within all limits: extreme feasible plans."""
    random = np.random.default_rng(5)
    strict = _tightened(PUBLISHED, F(1, 10**4))
    plans = []
    for _ in range(count):
        target = [float(x) for x in random.uniform([-1.4, -3.7, 0.4], [1.4, 3.7, 1.8])]
        plans.append(_reference(target=target, limits=strict, weights=Weights(jerk=10 ** random.uniform(-3, 0))))
    return plans


def _between(a: Flown, b: Flown, part: Fraction) -> Flown:
    """Return the plan whose jerks are those of `a` and, by `part` of the way, those of `b`."""
    pairs = zip(a.jerks, b.jerks, strict=True)
    jerks = [vector(*(x + part * (y - x) for x, y in zip(*pair, strict=True))) for pair in pairs]
    return replace(a, jerks=jerks)


def _jerk_distance(a: Flown, b: Flown) -> float:
    return float(np.linalg.norm(np.array(a.jerks, dtype=float) - np.array(b.jerks, dtype=float)))


def test_the_reference_is_cheaper_than_feasible_perturbations() -> None:
    """50 feasible plans near and far from the answer cost more; answers to other problems are found not to be best."""
    others = _feasible_plans(25)

    def perturbed(plan: Flown) -> list[Flown]:
        parts = [(F(1, 2 ** (n % 4)), F(1, 2 ** (n % 4 + 4))) for n in range(25)]
        return [_between(plan, other, part) for other, both in zip(others, parts, strict=True) for part in both]

    best = _reference()
    least = _cost(best)
    assert least < 100
    for plan in perturbed(best):
        assert _broken(plan, NEIGHBOURS, SELECTED, old=START) == []
        # The cost of a feasible plan exceeds the optimum by 0.001 |Δu|², the jerk's part of the strong convexity: by
        # 1e-6 here. Clarabel's gap is 1e-9 of a cost below 100, so the comparison needs no tolerance.
        assert _jerk_distance(plan, best) > 0.04
        assert _cost(plan) > least
    # the weight of jerk, the band, and who is planned at the same time
    for wrong in (_reference(weights=Weights(jerk=0.1)), _reference(w_j={}), _reference(selected=(1, 5))):
        claimed = _cost(wrong)
        assert any(_cost(plan) < claimed for plan in perturbed(wrong))


def test_the_cost_is_that_of_the_formula() -> None:
    """Hovering and a short move cost what (13a) and Appendix B say by hand, with ε_j the slack that is left."""
    weights = Weights(position=2.0, speed=3.0, acceleration=5.0, jerk=7.0, width=0.3)

    def cost(plan: Flown, neighbours: Mapping[int, Sequence[Flown]], selected: Sequence[int] = ()) -> float:
        return plan_cost(plan, OLD, neighbours, selected, (0.1, 0.0, 1.0), PUBLISHED, weights, {1: 4.0, 2: 1.0}, 0)

    # 16 states at a distance of 0.1 m: 2 · 16 · 0.01
    assert cost(_plan([]), {}) == pytest.approx(0.32, abs=1e-12)
    # j = -2.5: positions .01/6, .05/6, .01 and then at .01; velocities .025 twice, accelerations ±.25
    positions = 0.1**2 + (0.1 - 0.01 / 6) ** 2 + (0.1 - 0.05 / 6) ** 2 + 13 * 0.09**2
    expected = 2 * positions + 3 * 2 * 0.025**2 + 5 * 2 * 0.25**2 + 7 * (2.5**2 + 2 * 1.25**2)
    assert cost(_plan(_move(0, F(1, 100))), {}) == pytest.approx(expected, abs=1e-12)
    # slack 0.1 of 0.3: ½ · 4 · 0.2²; the nearer candidate counts; half the slack if j is planned, too
    near, far = _hover(0, "0.35", 1), _hover(0, -3, 1)
    assert cost(_plan([]), {1: [near]}) == pytest.approx(0.32 + 0.08, abs=1e-12)
    assert cost(_plan([]), {1: [near, far]}) == cost(_plan([]), {1: [far, near]})
    assert cost(_plan([]), {1: [far, near]}) == pytest.approx(0.32 + 0.08, abs=1e-12)
    assert cost(_plan([]), {1: [near]}, [1]) == pytest.approx(0.32 + 2 * 0.25**2, abs=1e-12)
    # one that is too close has ε_j = 0
    assert cost(_plan([]), {1: [_hover(0, "0.2", 1)]}) == pytest.approx(0.32 + 2 * 0.3**2, abs=1e-12)
    assert cost(_plan([]), {1: [far], 2: [near], 3: [near]}) == pytest.approx(0.32 + 0.02, abs=1e-12)


def test_the_reported_cost_is_that_of_the_answer() -> None:
    """The cost that comes with the jerks is theirs."""
    pytest.importorskip("clarabel")
    answer = reference_qp(START, NEIGHBOURS, SELECTED, TARGET, PUBLISHED, WEIGHTS, W_J, 0)
    assert answer is not None
    assert answer[1] == _cost(planned(START, answer[0], PUBLISHED, 0))


def test_the_band_pushes_away_from_its_uav() -> None:
    """With a large w_j the plan ends farther from the plane of j, up to the width and no farther, at a smaller cost."""

    def slack(plan: Flown) -> float:
        """UAV 1 is at a distance √(0.6² + 0.05²) from the start; its plane is d̂_min nearer."""
        n = np.array([0.6, 0.05, 0.0]) / np.hypot(0.6, 0.05)
        there = np.array([0.0, 0.05, 1.0])
        return float(n @ (there - np.array(plan.position(BEGIN + 3), dtype=float))) - 0.25

    without, pushed, more = (_reference(w_j=w_j) for w_j in ({}, {1: 100.0}, {1: 1e5}))
    # the target is behind UAV 1: the row is active without ε, and the width is not exceeded for nothing
    assert abs(slack(without)) < 1e-6
    assert 0.1 < slack(pushed) < slack(more) < WEIGHTS.width + 1e-6
    assert _cost(pushed, {1: 100.0}) < _cost(without, {1: 100.0})
    assert _cost(without, {}) < _cost(pushed, {})


def test_the_band_never_loosens_a_plane() -> None:
    """With a UAV that approaches until the last sample, a small w_j does not buy a place beyond that sample's plane."""
    approaching = Flown(F(0), (vector("-0.03", "-0.1", 0), vector(0, 0, 0), vector(1, 0, 0)), [])
    # at h = 30 it is d̂_min from the start, to which the plan has to return
    by = F(1, 10**6)
    plan = _reference(neighbours={1: [approaching]}, selected=(), w_j={1: 0.5})
    assert _broken(plan, {1: [approaching]}, (), _tightened(PUBLISHED, -by), START) == []
    assert abs(plan.position(BEGIN + 3)[0] + F(3, 5)) < by
    assert plan.position(BEGIN + 1)[0] > F(-11, 20)


def _by_elimination(old: State, target: Sequence[float], weights: Weights) -> Array:
    """Return the jerks that minimise (13a) subject to (13e) alone, by the matrix exponential and the KKT system."""
    generator = np.zeros((4, 4))
    generator[0, 1] = generator[1, 2] = generator[2, 3] = 1.0
    step = expm(generator * 0.2)
    states, slopes = [np.array(old, dtype=float).T], [np.zeros((3, 15))]
    for n in range(15):
        states.append(step[:3, :3] @ states[-1])
        slopes.append(step[:3, :3] @ slopes[-1] + np.outer(step[:3, 3], np.eye(15)[n]))
    weight = np.diag([weights.position, weights.speed, weights.acceleration])
    aim = np.array([target, np.zeros(3), np.zeros(3)])
    system, right = np.zeros((17, 17)), np.zeros((17, 3))
    system[:15, :15] = weights.jerk * np.eye(15) + sum(s.T @ weight @ s for s in slopes)
    right[:15] = sum(s.T @ weight @ (aim - x) for s, x in zip(slopes, states, strict=True))
    system[15:, :15], system[:15, 15:], right[15:] = slopes[-1][1:], slopes[-1][1:].T, -states[-1][1:]
    return np.asarray(np.linalg.solve(system, right)[:15])


def test_the_reference_without_active_bounds_solves_the_kkt_system() -> None:
    """Near its target and alone, a moving UAV's best jerks are those of a linear system, written down otherwise."""
    pytest.importorskip("clarabel")
    state = (vector("0.1", "-0.03", "0.02"), vector("0.05", 0, 0), vector(1, "0.02", 0))
    old = Flown(F(-1), state, [vector("0.02", 0, 0)])
    target = (0.6, -0.5, 1.4)
    k = 2
    # large enough that it does not arrive: the last state counts, too
    weights = Weights(position=1.0, speed=0.01, acceleration=0.05, jerk=0.1)
    answer = reference_qp(old, {}, (), target, PUBLISHED, weights, {}, k)
    assert answer is not None
    jerks = _by_elimination(old.at(3 * BEGIN), target, weights)
    assert np.max(np.abs(jerks)) < 5.0

    def cost(jerks: Array) -> float:
        plan = rested(planned(old, jerks, PUBLISHED, k))
        assert _broken(plan, old=old, k=k) == []
        return plan_cost(plan, old, {}, (), target, PUBLISHED, weights, {}, k)

    # Clarabel's gap and what rest costs are below 1e-7 for a cost below 10; the jerks differ by √(1e-7 / 0.1) then
    assert answer[1] < 10
    assert abs(cost(answer[0]) - cost(jerks)) < 1e-7
    assert np.linalg.norm(answer[0] - jerks) < 0.001
    other = _by_elimination(old.at(3 * BEGIN), target, replace(weights, speed=0.02))
    assert cost(other) > cost(jerks) + 1e-7


def test_an_infeasible_problem_has_no_answer() -> None:
    """No plan exists within d̂_min, where there is no plane, outside of the box, or too fast to stop in it."""
    pytest.importorskip("clarabel")

    def solve(old: Flown, neighbours: Mapping[int, Sequence[Flown]]) -> object:
        return reference_qp(old, neighbours, (), TARGET, PUBLISHED, WEIGHTS, {}, 0)

    assert solve(START, {1: [_hover("-0.35", 0, 1)]}) is not None
    assert solve(START, {1: [_hover(F("-0.35") - UNIT, 0, 1)]}) is None
    # they are apart now, but in one place at h = 5
    crossing = Flown(F(0), (vector("-1.3", 1, 0), vector(0, 0, 0), vector(1, 0, 0)), [])
    assert solve(START, {1: [crossing]}) is None
    assert solve(_hover("1.4", 0, 1), {}) is not None
    assert solve(_hover(F("1.4") + UNIT, 0, 1), {}) is None
    for speed, possible in (("0.3", True), ("1.9", False)):
        moving = Flown(F(0), (vector(1, speed, 0), vector(0, 0, 0), vector(1, 0, 0)), [])
        assert (solve(moving, {}) is not None) == possible


# What Theorem 1 and Corollary 1 say of it


@pytest.mark.parametrize("selected", [(), (1, 2)])
def test_the_old_trajectory_stays_feasible(selected: tuple[int, ...]) -> None:
    """Shifted by a round, a feasible plan is feasible again if the others keep theirs (proof of Theorem 1)."""
    plan = _reference(limits=_tightened(PUBLISHED, F(1, 10**6)))
    for k in (1, 4):
        shifted = _plan([*plan.jerks[k:]], plan, k)
        assert _broken(shifted, NEIGHBOURS, selected, old=plan, k=k) == []
    # shifted without the time having passed, it continues nothing
    assert "(13b) x" in _broken(replace(_plan([*plan.jerks[1:]]), start=2 * BEGIN), NEIGHBOURS, old=plan, k=1)


def test_two_plans_of_one_round_stay_apart() -> None:
    """UAVs that change places keep d̂_min at the samples if (15) knows that both are planned, and only then."""
    places = {0: _hover("-0.2", 0, 1), 1: _hover("0.2", 0, 1)}
    targets = {0: (0.2, 0.0, 1.0), 1: (-0.2, 0.0, 1.0)}
    times = [BEGIN + h * PUBLISHED.T_c for h in range(31)]
    strict = _tightened(PUBLISHED, F(1, 10**6))

    def plans(known: bool) -> dict[int, list[Flown]]:
        made = {}
        for i, j in ((0, 1), (1, 0)):
            selected = (j,) if known else ()
            plan = _reference(places[i], {j: [places[j]]}, selected, targets[i], strict, w_j={})
            assert _broken(plan, {j: [places[j]]}, selected, old=places[i]) == []
            made[i] = [plan]
        return made

    assert separation_violations(plans(known=True), times, PUBLISHED) == []
    assert separation_violations(plans(known=False), times, PUBLISHED) != []
