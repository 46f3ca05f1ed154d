"""The checker's leaves, motions and numbers, part by part: each bound just met, and just missed."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product
from math import isqrt, sqrt
from random import Random
from typing import Any

import pytest
from tests.margin.hand_made import made
from tests.margin.test_check_planes import highest, points, random_polygon

from swarmproof.margin.check import _balls, _Cell, _check_ball_leaf, _check_leaf
from swarmproof.margin.check_motions import Problem, parameters_of, problem_of
from swarmproof.margin.check_numbers import Rejected, Vector
from swarmproof.margin.check_planes import Polygon, largest

F = Fraction
IDENTITY: Vector = (F(1), F(0), F(0), F(1), F(0), F(1))


def a_cell(distance: Fraction, gram: Vector, rho: Fraction, ends: tuple[Fraction, Fraction], **raw: Any) -> _Cell:
    """Return a cell of a problem with this d̂_min and this A², where ρ is what is to be kept."""
    problem = problem_of(parameters_of(made("initial-state", 2)["parameters"], False), "initial-state", False)
    decoupled = gram[1] == gram[2] == gram[4] == 0
    problem = replace(problem, distance=distance, gram=gram, decoupled=decoupled)
    return _Cell(problem, F(0), ends, rho, raw, True)


def root(square: Fraction, up: bool) -> Fraction:
    """Return a multiple of 10⁻¹⁵ just above (`up`) or below the root of a number."""
    return F(isqrt(square.numerator * 10**30 // square.denominator) + up, 10**15)


@pytest.mark.parametrize(
    ("ends", "t", "kappa"),
    [
        (("0", "1"), "0", F(1, 4)),
        (("0", "1/4"), "0", F(3, 16)),
        (("3/4", "1"), "0", F(3, 16)),
        (("1/8", "1/4"), "0", F(3, 16)),
        (("3/4", "7/8"), "0", F(3, 16)),
        (("0", "1/2"), "0", F(1, 4)),
        (("1/2", "1"), "0", F(1, 4)),
        (("1/8", "1/4"), "1/8", F(15, 64)),
        (("1/8", "1/4"), "-1/8", F(7, 64)),
        (("1/8", "1/4"), "1/4", F(1, 4)),
        (("1/8", "1/4"), "5/8", F(3, 16)),
        (("0", "1/8"), "7/8", F(7, 64)),
    ],
)
def test_kappa_is_the_largest_product_of_weights(ends: tuple[str, str], t: str, kappa: Fraction) -> None:
    """κ is the largest μ(1 − μ) for μ from τ₁ + t to τ₂ + t: at 1/2 if that is in between, else at the nearer end."""
    first, last = (F(end) for end in ends)
    assert a_cell(F(1), IDENTITY, F(0), (first, last)).kappa(F(t)) == kappa
    for outside in (-first - F(1, 10**6), 1 - last + F(1, 10**6)):
        with pytest.raises(Rejected, match="a weight is not in"):
            a_cell(F(1), IDENTITY, F(0), (first, last)).kappa(outside)


def three_polygons(random: Random) -> list[Polygon]:
    """Return three polygons with corners, none of them with the origin in its interior."""
    found: list[Polygon] = []
    while len(found) < 3:
        polygon, corners = random_polygon(random)
        if corners and min(x for x, _ in corners) >= 0:
            found.append(polygon)
        elif corners:
            right = [(x, y, w) for x, y, w in polygon if x >= 0]
            found += [right] if right else []
    return found


@pytest.mark.parametrize("coupled", [False, True])
def test_a_leaf_is_kept_by_its_worst_corner(coupled: bool) -> None:
    """With d̂_min just as large as the worst corner of the three polygons needs, a leaf passes; with less it does not.

    A corner needs √(d² − κ‖Aδ‖²) ≥ ρ + ‖A(g + tδ)‖, here computed in floats.
    """
    random, decided = Random(7 + coupled), 0
    for _ in range(25):
        polygons = three_polygons(random)
        rho, t = F(random.randint(0, 5), 3), F(random.randint(-1, 2), 8)
        off = [F(random.randint(-3, 3), 10) * coupled for _ in range(3)]
        gram = (F(1), off[0], off[1], F(random.randint(1, 5), 2), off[2], F(3, 2))
        rows = ((0, 1, 2), (1, 3, 4), (2, 4, 5))

        def length(vector: tuple[Fraction, ...], gram: Vector = gram, rows: Any = rows) -> float:
            return sqrt(sum(gram[rows[i][k]] * vector[i] * vector[k] for i, k in product(range(3), range(3))))

        ends = (F(1, 8), F(3, 4)) if random.random() < 0.5 else (F(1, 8), F(1, 4))
        kappa = float(a_cell(F(1), gram, rho, ends).kappa(t))
        needed = 0.0
        for corners in product(*map(points, polygons)):
            delta = tuple(x for x, _ in corners)
            moved = tuple(y + t * x for x, y in corners)
            needed = max(needed, sqrt(kappa * length(delta) ** 2 + (float(rho) + length(moved)) ** 2))
        enough, less = F(needed * (1 + 1e-9)), F(needed * (1 - 1e-9))
        _check_leaf(a_cell(enough, gram, rho, ends), t, polygons)
        if needed:
            decided += 1
            with pytest.raises(Rejected, match="closer than upper"):
                _check_leaf(a_cell(less, gram, rho, ends), t, polygons)
    assert decided > 20


def test_a_leaf_may_be_met_exactly() -> None:
    """A corner for which (*) is an equality passes: √(d² − δ²/4) = ρ + |g| with 5² − 8²/4 = 3² and 3 = 2 + 1."""
    corner: Polygon = [(8, 1, 1)]
    still: Polygon = [(0, 0, 1)]
    ends = (F(0), F(1))
    for polygons in ([corner, still, still], [still, still, corner]):
        _check_leaf(a_cell(F(5), IDENTITY, F(2), ends), F(0), polygons)
        for distance, rho in ((F(5), F(2) + F(1, 10**9)), (F(5) - F(1, 10**9), F(2)), (F(4), F(0)), (F(1), F(1))):
            with pytest.raises(Rejected, match="closer than upper"):
                _check_leaf(a_cell(distance, IDENTITY, rho, ends), F(0), polygons)
    _check_leaf(a_cell(F(5), IDENTITY, F(3), ends), F(0), [[(8, 0, 1)], still, still])  # touched, in the middle
    # d² − δ²/4 − g² − ρ² below 0 has a square, too
    with pytest.raises(Rejected, match="closer than upper"):
        _check_leaf(a_cell(F(1), IDENTITY, F(1, 8), ends), F(0), [[(8, 0, 1)], still, still])


def test_a_ball_leaf_is_kept_by_its_forms() -> None:
    """With d̂_min just as large as (**) needs, a leaf with ball edges passes; with a bit less it does not."""
    random = Random(9)
    for _ in range(25):
        polygons = three_polygons(random)
        rho, t, share = F(random.randint(0, 3), 2), F(random.randint(0, 2), 8), F(random.randint(1, 4), 5)
        gram = (F(1), F(0), F(0), F(random.randint(1, 5), 2), F(0), F(random.randint(1, 5), 3))
        balls: list[tuple[Vector, Fraction]] = [
            ((F(random.randint(-2, 2)), F(random.randint(-2, 2))), F(random.randint(0, 4), 3))
            for _ in range(random.randrange(3))
        ]
        weights = [F(random.randint(0, 4), 7) for _ in balls]
        ends = (F(1, 8), F(1, 4))
        kappa = a_cell(F(1), gram, rho, ends).kappa(t)
        most = sum((w * c * c for w, (_, c) in zip(weights, balls, strict=True)), rho**2 / (1 - share))
        for factor, polygon in zip((gram[0], gram[3], gram[5]), polygons, strict=True):
            # factor·(κδ² + (g + tδ)²/θ) − Σ λ(αδ + βg)², as coefficients of δ², 2δg and g²
            form = [factor * (kappa + t * t / share), factor * t / share, factor / share]
            for weight, ((a, b), _) in zip(weights, balls, strict=True):
                form = [x - weight * y for x, y in zip(form, (a * a, a * b, b * b), strict=True)]
            most += highest(tuple(form), points(polygon))
        if most <= 0:
            continue
        leaf = {"t": str(t), "share": str(share), "weights": [str(weight) for weight in weights]}
        _check_ball_leaf(a_cell(root(most, True), gram, rho, ends), balls, leaf, polygons)
        with pytest.raises(Rejected, match="closer than upper"):
            _check_ball_leaf(a_cell(root(most, False) - F(1, 10**15), gram, rho, ends), balls, leaf, polygons)


def test_ball_edges_are_those_of_their_cell() -> None:
    """Ball edges are proved at the cell's two ends, and their bound grows with its length; /1 has none."""
    ball = [{"direction": ["0", "2"], "proofs": [[], []]}]
    cell = a_cell(F(1), IDENTITY, F(0), (F(1, 4), F(3, 4)), ball=ball)
    problem: Problem = cell.problem
    ((way, offset),) = _balls(cell)
    # |g(τ)| has the kernel of a tent from 0 over τ(1 − τ) to 1; at both ends its integral is 3/32
    accelerates = problem.ball[2]
    assert way == (F(0), F(2))
    assert offset == 2 * (F(3, 32) * accelerates + accelerates * F(1, 4) / 8)
    assert _balls(replace(cell, extended=False)) == []


def test_the_largest_value_may_be_within_a_side() -> None:
    """The turn of −δ² − g² on the side from (−1, 0) to (0, 1) is found, where all numbers are as small as they get."""
    assert largest((F(-1), F(0), F(-1)), [(-1, 0, 1), (0, 1, 1), (-1, 1, 1)]) == F(-1, 2)
