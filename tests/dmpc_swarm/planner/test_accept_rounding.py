"""Where float64 and integers disagree about a plane: acceptance goes by the integers, and is fooled by no rounding."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product
from math import ceil, gcd, isqrt

import numpy as np
import pytest
from tests.dmpc_swarm.flight.settings import a_task, broken, hover, lattice, samples
from tests.dmpc_swarm.planner.test_accept import PLAIN, placed, sides, with_product

from swarmproof.dmpc_swarm.planner import accept
from swarmproof.dmpc_swarm.planner.accept import Planes, asked, old_satisfies, right_side, wrong_sides
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.motion.lattice import Lattice
from swarmproof.scenario.scenario import EXACT, Tolerance

F = Fraction


def beside_the_plane(random: np.random.Generator, selected: bool, over: int) -> tuple[Plan, Task]:
    """Return a plan that misses a plane by `over` integers (negative or 0: on its wrong side), far along the plane.

    n·Δ is then the difference of products that are some 10⁵ times as large as it is. So is the error of these in
    float64, which says nothing of the side any more, while the error of the right side is far smaller.
    """
    while True:
        x, y, z = (int(n) for n in random.integers(-(2**36), 2**36, 3))
        if abs(y) > 1 and gcd(x, y) == 1:
            break
    square = x * x + y * y + z * z
    d_hat = int(PLAIN.parameters.d_hat_min / PLAIN.position_unit)
    needed = isqrt(d_hat**2 * square)
    if selected:
        needed = (needed + square) // 2
    a, b, c = with_product((x, y, z), needed + over)
    along = int(random.integers(2**12, 2**13)) * (1 if random.random() < 0.5 else -1)
    return placed((x, y, z), (a - along * y, b + along * x, c), selected)


@pytest.mark.parametrize("selected", [False, True])
def test_products_that_cancel_do_not_let_a_plan_out(selected: bool) -> None:
    """A plan far along a plane, by less than an integer on its wrong side, is refused, whatever the products round to.

    Without the bound on the rounding of the products, about half of them would be accepted.
    """
    random = np.random.default_rng(11)
    fooled = 0
    for n in range(60):
        over = (0, -1, 1)[n % 3]
        plan, task = beside_the_plane(random, selected, over)
        normal, apart = task.planes.normals[0, 0], task.planes.apart(plan)[0, 0]
        fooled += over <= 0 and bool(normal @ apart > sum(int(a) * int(b) for a, b in zip(normal, apart, strict=True)))
        found = sides(plan, task)
        assert len(found) == (3 if over <= 0 else 0)
        assert found == [text for text in broken(plan, task) if text.startswith("(15)")]
    assert fooled > 5


# What floats may decide, and what not


class Counted:
    """Counts how often acceptance asks one of its own functions."""

    def __init__(self, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
        self.calls = 0
        self._function = getattr(accept, name)
        monkeypatch.setattr(accept, name, self)

    def __call__(self, *arguments: object) -> object:
        """Count a call, and pass it on."""
        self.calls += 1
        return self._function(*arguments)


def apart_by(distance: float, units: Lattice, selected: bool) -> Task:
    """Return the task of a UAV at rest beside another one, so many m away along x."""
    own, other = hover(units, (0, 0, 1)), hover(units, (distance, 0, 1))
    return a_task(own, {1: [other, other]}, selected={0, 1} if selected else ())


@pytest.mark.parametrize("selected", [False, True])
def test_clear_cases_need_no_integers(monkeypatch: pytest.MonkeyPatch, selected: bool) -> None:
    """At 1 m or 0.26 m with d̂_min = 0.25 m, floats decide every plane, and the candidate without looking at planes."""
    planes, constraints = Counted("right_side", monkeypatch), Counted("broken_constraint", monkeypatch)
    for changes, distance in product(((), (samples(3),), ("theta_inverse=1",)), (1.0, 0.26)):
        task = apart_by(distance, lattice(*changes, horizon=5), selected)
        assert wrong_sides(task.own.shifted(1), task.planes).shape == (0, 2)
        assert old_satisfies(task.own, 1, task.planes)
        assert wrong_sides(task.own.shifted(1), a_task(task.own, {}).planes).shape == (0, 2)
    assert (planes.calls, constraints.calls) == (0, 0)
    # a row that is not clear is decided in integers, and only that one
    near = a_task(task.own, {1: [hover(task.own.lattice, (0.2, 0, 1))], 2: [hover(task.own.lattice, (1, 0, 1))]})
    rows = near.planes.others.shape[1]
    assert wrong_sides(near.own.shifted(1), near.planes).tolist() == [[0, h] for h in range(rows)]
    assert planes.calls == rows
    assert not old_satisfies(near.own, 1, near.planes)
    assert constraints.calls == 1


def just_short(square: int) -> tuple[int, int, int]:
    """Return three integers with a sum of squares a little below `square`: by some hundreds, of 10²²."""
    x = isqrt(square - 1)
    y = isqrt(square - 1 - x * x)
    return x, y, isqrt(square - 1 - x * x - y * y)


def test_a_candidate_that_is_too_near_by_nothing_is_refused() -> None:
    """Theorem 1's candidate, nearer than d̂_min by less than any float can tell, does not satisfy its planes."""
    d_hat = int(PLAIN.parameters.d_hat_min / PLAIN.position_unit)
    short = just_short(d_hat**2)
    square = sum(n * n for n in short)
    assert square < d_hat**2
    assert float(square) == float(d_hat**2)
    own = hover(PLAIN, (0, 0, 1))

    def satisfies(*normals: tuple[int, int, int]) -> bool:
        others = [Plan.hovering(PLAIN, own.state[0] + np.array(normal, float)) for normal in normals]
        return old_satisfies(own, 1, a_task(own, {1: others}).planes)

    assert not satisfies(short)
    assert satisfies((d_hat, 0, 0))
    assert satisfies((0, 0, -d_hat - 1))
    # one trajectory that is too near is enough, be it the first one or the last
    assert not satisfies((3 * d_hat, 0, 0), short)
    assert not satisfies(short, (3 * d_hat, 0, 0))
    assert satisfies((3 * d_hat, 0, 0), (3 * d_hat, 0, 0))


def test_a_candidate_that_breaks_another_constraint_is_refused() -> None:
    """However far everybody is, an old trajectory that does not end at rest is no candidate."""
    own = hover(PLAIN, (0, 0, 1))
    jerks = own.jerks.copy()
    jerks[-1, 0] += 1
    moving = Plan(PLAIN, 0, own.state, jerks)
    assert moving.fault is not None
    away = {1: [hover(PLAIN, (1, 0, 1))]}
    assert not old_satisfies(moving, 0, a_task(moving, away).planes)
    assert old_satisfies(own, 0, a_task(own, away).planes)


#: Tolerances that use up all of d̂_min.
NOTHING = Tolerance(F(1, 4), F(1, 8))
TIGHT_UNITS = (F(1, 3), F(7, 5), F(1))


@pytest.mark.parametrize("halfway", [False, True])
@pytest.mark.parametrize("tolerance", [EXACT, Tolerance(F(1, 50), F(1, 100))])
def test_rows_in_units_of_their_own_are_decided_exactly(halfway: bool, tolerance: Tolerance) -> None:
    """With a unit for each trajectory, a row is judged by the distance in that unit, at a hair on either side of it."""
    base = PLAIN.pairs.unit
    units = tuple(base * factor for factor in TIGHT_UNITS)
    needed = [tolerance.asked(PLAIN.pairs.distance, halfway) / unit for unit in units]
    for over in (-1, 0, 1):
        # along x, ‖n‖ = n and the row is nΔ ≥ d̂n, or nΔ ≥ n(d̂ + n)/2: so Δ ≥ d̂, or (d̂ + n)/2
        normal = [3 * ceil(d) + ceil(d) % 2 for d in needed]
        least = [ceil((d + n) / 2 if halfway else d) for d, n in zip(needed, normal, strict=True)]
        others, normals = np.zeros((3, 3, 3)), np.zeros((3, 3, 3))
        others[..., 0], normals[..., 0] = np.array(least)[:, None] + over, np.array(normal)[:, None]
        planes = Planes(others, normals, np.full(3, halfway), (1, 2, 3), tolerance, units=units)
        plan = Plan.hovering(PLAIN, np.zeros(3))
        assert wrong_sides(plan, planes).tolist() == ([[n, h] for n in range(3) for h in range(3)] if over < 0 else [])
        assert [
            right_side((float(n), 0.0, 0.0), (x, 0.0, 0.0), halfway, PLAIN, tolerance, unit)
            for n, x, unit in zip(normal, others[:, 0, 0].tolist(), units, strict=True)
        ] == [over >= 0] * 3


def test_candidates_in_units_of_their_own_are_decided_exactly() -> None:
    """With a unit for each trajectory, the candidate needs d̂_min in that unit, by a unit more or less."""
    base, d_hat = PLAIN.pairs.unit, PLAIN.pairs.distance
    own = hover(PLAIN, (0, 0, 1))
    for factor in TIGHT_UNITS:
        least = ceil(d_hat / (base * factor))
        for over, kept in ((-1, False), (0, True), (1, True)):
            normals = np.zeros((1, 3, 3))
            normals[..., 0] = least + over
            planes = Planes(own.state[0] + normals, normals, np.array([False]), (1,), units=(base * factor,))
            assert old_satisfies(own, 0, planes) is kept


@pytest.mark.parametrize(
    ("tolerance", "selected", "kept"),
    [
        (Tolerance(F(1, 50), F(1, 25)), False, False),  # 0.23 m asked for, 0.17 m if midway
        (Tolerance(F(1, 50), F(1, 25)), True, True),
        (Tolerance(F(1, 10), F(1, 50)), False, True),  # 0.15 m, and 0.21 m
        (Tolerance(F(1, 10), F(1, 50)), True, False),
    ],
)
def test_the_larger_distance_is_enough_for_a_candidate(tolerance: Tolerance, selected: bool, kept: bool) -> None:
    """At 0.2 m, between what the two tolerances ask for, the candidate is judged by the planes that there are."""
    task = replace(apart_by(0.2, PLAIN, selected), tolerance=tolerance)
    assert task.planes.halfway.tolist() == [selected] * 2
    assert old_satisfies(task.own, 1, task.planes) is kept


def test_what_planes_ask_for_is_told_apart() -> None:
    """With two tolerances, planes midway ask for less than the others, in metres or in the scaled unit."""
    tolerance, unit = Tolerance(F(1, 50), F(1, 25)), PLAIN.pairs.unit
    half, full = (tolerance.asked(PLAIN.pairs.distance, halfway) for halfway in (True, False))
    assert half != full
    assert asked(PLAIN, tolerance, False) == (float(half), float(full))
    assert asked(PLAIN, tolerance, True) == (float(half / unit), float(full / unit))


@pytest.mark.parametrize("halfway", [False, True])
def test_a_plane_needs_a_normal_and_the_right_sign(halfway: bool) -> None:
    """Without a normal no side is right; nor is the far side, however far; the smallest normal has two sides, too."""
    d_hat = int(PLAIN.parameters.d_hat_min / PLAIN.position_unit)
    assert not right_side((0, 0, 0), (0, 0, 0), halfway, PLAIN)
    assert right_side((2, 0, 0), (1 if halfway else 0, 5, 0), halfway, PLAIN, NOTHING)  # touched, if nothing is kept
    assert not right_side((2, 0, 0), (0 if halfway else -1, 5, 0), halfway, PLAIN, NOTHING)
    assert not right_side((0, 0, 0), (0, 5, 0), halfway, PLAIN, NOTHING)
    assert not right_side((1, 0, 0), (-2 * d_hat, 0, 0), halfway, PLAIN)
    assert right_side((1, 0, 0), (d_hat + 1, 0, 0), halfway, PLAIN)
    assert right_side((0, -1, 0), (5, -d_hat - 1, -7), halfway, PLAIN)
    assert not right_side((1, 0, 0), (d_hat - 1 if not halfway else d_hat // 2, 0, 0), halfway, PLAIN)
