"""An exact checker of margin certificates. It follows docs/margin.md, which has the argument, section by section.

It imports nothing of this project but its own parts, the modules `check_*` beside it, so that no error in what computes
a margin can make a wrong certificate pass.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import gcd, lcm
from typing import Any

from swarmproof.margin.check_motions import Problem, check_witness, parameters_of, problem_of
from swarmproof.margin.check_numbers import (
    Rejected,
    Vector,
    digest,
    integer,
    list_of,
    located,
    need,
    number_of,
    numbers_of,
    object_of,
    read,
    scaled,
    square,
)
from swarmproof.margin.check_planes import Corner, Polygon, clip, edges_of, form_of, largest, polygon_of

__all__ = ["Rejected", "Verified", "check", "read"]

SCHEMA = "swarmproof.margin-certificate/1"
EXTENDED = "swarmproof.margin-certificate/2"  #: with bounds of the norm, open sides, and other parameters of ours
READINGS = ("initial-state", "whole-motion", "as-sampled")
DEEPEST_TREE = 200


@dataclass(frozen=True)
class Verified:
    """What a certificate proves, in units of ‖Θ⁻¹(p̂_i − p̂_j)‖, and how many leaves, cells and windows that took."""

    lower: Fraction
    upper: Fraction
    leaves: int
    cells: int
    windows: int


# ---- Cells, trees and leaves: polygons are those of x, y, z ----
@dataclass(frozen=True)
class _Cell:
    problem: Problem
    start: Fraction  #: of its window
    ends: tuple[Fraction, Fraction]  #: τ₁ and τ₂
    rho: Fraction  #: the distance to be kept
    raw: dict[str, Any]
    extended: bool  #: whether the schema is /2

    def kappa(self, t: Fraction) -> Fraction:
        """Return the largest μ₀μ₁ in the cell."""
        low, high = (end / self.problem.span + t for end in self.ends)
        half = Fraction(1, 2)
        need(0 <= low <= high <= 1, "a weight is not in [0, 1]")
        return half * half if low <= half <= high else max(low * (1 - low), high * (1 - high))


def _polygons(cell: _Cell) -> list[Polygon]:
    """Return the polygons that hold in all of a cell."""
    problem, raw, lists = cell.problem, cell.raw, []
    lowest = 1 if problem.workspace is None else 0
    for i in range(len(list_of(raw, "edges"))):
        edges = list_of(raw["edges"], i)
        with located(f"list {i} of edges"):
            lists.append(edges_of(problem, lowest, cell.start, cell.ends, edges))
    polygons, known = [], dict[tuple[int, Vector], Polygon]()  # axes with equal bounds share polygons
    for k, bounds in enumerate(problem.bounds):
        i = integer(list_of(raw, "axes", 3), k, 0, len(lists) - 1)
        if problem.workspace is not None and None in problem.workspace[k]:
            bounded = not any(edge.uses_positions for edge in lists[i])
            need(bounded, f"list {i} of edges uses positions, which are not bounded along axis {k}")
        if (i, bounds) not in known:
            length = cell.ends[1] - cell.ends[0]
            known[i, bounds] = polygon_of({edge.way: edge.offset(problem, length, bounds) for edge in lists[i]})
        half = clip(known[i, bounds], Fraction(-1), Fraction(0), Fraction(0))
        polygons.append(half if k == 0 or problem.decoupled else known[i, bounds])
    return polygons


def _balls(cell: _Cell) -> list[tuple[Vector, Fraction]]:
    """Return the ball edges as directions (α, β) and bounds c of ‖αδ + βg‖; the schema /1 has none."""
    if not cell.extended:
        return []
    problem, length = cell.problem, cell.ends[1] - cell.ends[0]
    with located("ball"):
        edges = edges_of(problem, 1, cell.start, cell.ends, list_of(cell.raw, "ball"))
    return [(edge.way, edge.offset(problem, length, problem.ball)) for edge in edges]


def _check_tree(
    cell: _Cell, balls: list[tuple[Vector, Fraction]], tree: Any, polygons: list[Polygon], depth: int
) -> int:
    """Check that the distance ρ is kept; return the number of leaves, those in empty parts left out."""
    if not all(polygons):
        return 0
    need(depth <= DEEPEST_TREE, "the tree is too deep")
    if isinstance(tree, dict) and "t" in tree:
        if cell.extended and "share" in tree:
            _check_ball_leaf(cell, balls, object_of(tree, "t share weights"), polygons)
        else:
            _check_leaf(cell, number_of(object_of(tree, "t"), "t"), polygons)
        return 1
    raw, leaves = object_of(tree, "axis normal at below above"), 0
    k, (a, b), c = integer(raw, "axis", 0, 2), numbers_of(raw, "normal", 2), number_of(raw, "at")
    need(bool(a or b), "the normal is (0, 0)")
    for side, part in (("below", clip(polygons[k], a, b, c)), ("above", clip(polygons[k], -a, -b, -c))):
        with located(side):
            leaves += _check_tree(cell, balls, raw[side], [*polygons[:k], part, *polygons[k + 1 :]], depth + 1)
    return leaves


def _check_leaf(cell: _Cell, t: Fraction, polygons: list[Polygon]) -> None:
    """Check (*) ≥ ρ at all corners, without roots."""
    problem, rho, kappa = cell.problem, cell.rho, cell.kappa(t)
    # In integers, for speed: lengths, here of pairs (δ, g + tδ), in 1/`unit`; U, κ‖Aδ‖², d² and ρ² in 1/(unit²·whole).
    p, q = t.numerator, t.denominator
    unit = q * lcm(*(w for polygon in polygons for _, _, w in polygon))
    axes = [[(x * (unit // w), (y * q + x * p) * (unit // (w * q))) for x, y, w in polygon] for polygon in polygons]
    axes = [_foremost(pairs) if problem.decoupled else pairs for pairs in axes]
    common = gcd(unit, *(length for pairs in axes for pair in pairs for length in pair))
    unit //= common
    corners = product(*([(x // common, y // common) for x, y in pairs] for pairs in axes))
    gram, stretched = problem.gram, tuple(kappa * g for g in problem.gram)
    whole = lcm(*(number.denominator for number in (*gram, *stretched, problem.distance**2, rho**2)))
    of_u, of_delta = ([scaled(g, whole) for g in numbers] for numbers in (gram, stretched))
    d_squared, rho_squared = (scaled(x**2, whole) * unit**2 for x in (problem.distance, rho))
    for (x0, y0), (x1, y1), (x2, y2) in corners:
        u = square(of_u, y0, y1, y2)
        left = d_squared - square(of_delta, x0, x1, x2) - u - rho_squared
        need(left >= 0 and 4 * rho_squared * u <= left**2, "a pair of motions may come closer than upper claims")


def _foremost(pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Drop pairs that another one exceeds in both: if Θ⁻¹ is diagonal, |δ_k| and |g_k + tδ_k| only make (*) smaller."""
    kept: list[tuple[int, int]] = []
    for x, y in sorted(((abs(x), abs(y)) for x, y in pairs), reverse=True):
        if not kept or y > kept[-1][1]:
            kept.append((x, y))
    return kept


def _check_ball_leaf(
    cell: _Cell, balls: list[tuple[Vector, Fraction]], raw: dict[str, Any], polygons: list[Polygon]
) -> None:
    """Check (**), where ball edges count with weights; δ ≥ 0 keeps the origin out of the polygons' interiors."""
    t, share, weights = number_of(raw, "t"), number_of(raw, "share"), numbers_of(raw, "weights", len(balls))
    need(cell.problem.decoupled, "a share needs a diagonal theta_inverse")
    need(0 < share < 1 or (share == 1 and cell.rho == 0), "the share is not in (0, 1), nor 1 where upper is d_hat_min")
    need(min(weights, default=0) >= 0, "a weight of a ball edge is negative")
    kappa = cell.kappa(t)
    spent, most = [Fraction(0)] * 3, Fraction(0)
    for weight, ((a, b), c) in zip(weights, balls, strict=True):
        spent = [x + weight * y for x, y in zip(spent, (a * a, a * b, b * b), strict=True)]
        most += weight * c * c
    found = dict[tuple[Fraction, tuple[Corner, ...]], Fraction]()  # axes that are alike share what is largest
    for factor, polygon in zip((cell.problem.gram[i] for i in (0, 3, 5)), polygons, strict=True):
        key = factor, tuple(polygon)
        if key not in found:
            found[key] = largest(form_of(factor, kappa, t, share, spent), polygon)
        most += found[key]
    left = cell.problem.distance**2 - (cell.rho**2 / (1 - share) if cell.rho else 0)
    need(most <= left, "a pair of motions may come closer than upper claims")


def check(certificate: object, progress: Callable[[int, int], None] | None = None) -> Verified:
    """Check a certificate, decoded from JSON; return what it proves, or raise `Rejected` if it claims something else.

    `progress` is called after every cell, with the number of cells checked and that of all cells.
    """
    raw = object_of(certificate, "schema parameters reading dip witness windows digest")
    need(raw["schema"] in (SCHEMA, EXTENDED), f"schema: expected {SCHEMA} or {EXTENDED}")
    extended = raw["schema"] == EXTENDED
    need(raw["digest"] == digest(raw), "digest: it is not that of the certificate's content")
    need(raw["reading"] in READINGS, f"reading: expected one of {', '.join(READINGS)}")
    with located("parameters"):
        problem = problem_of(parameters_of(raw["parameters"], extended), raw["reading"], extended)
    with located("dip"):
        lower, upper = (number_of(object_of(raw["dip"], "lower upper"), key) for key in ("lower", "upper"))
        need(0 <= lower <= upper <= problem.distance, "0 <= lower <= upper <= d_hat_min does not hold")
    with located("witness"):
        if raw["witness"] is not None:
            check_witness(raw["witness"], problem, lower)
        need(raw["witness"] is not None or lower == 0, "there is none, but lower is above 0")
    if raw["windows"] is None:
        need(upper == problem.distance, "windows: there are none, but upper is below d_hat_min")
        return Verified(lower, upper, 0, 0, 0)

    windows = [object_of(one, "window cells") for one in list_of(raw, "windows")]
    present = {integer(one, "window", 0, problem.windows - 1) for one in windows}
    need(len(present) == len(windows), "windows: one of them is there twice")
    for m in range(problem.windows):
        need(m in present or problem.windows - 1 - m in present, f"windows: {m} or its mirror image is missing")
    leaves, done, total = 0, 0, sum(len(list_of(one, "cells")) for one in windows)
    keys = "from to edges axes ball tree" if extended else "from to edges axes tree"
    for m, cells in ((one["window"], one["cells"]) for one in windows):
        reached = Fraction(0)
        for number, one in enumerate(cells):
            with located(f"window {m}, cell {number} from {reached}"):
                first, last = (number_of(object_of(one, keys), key) for key in ("from", "to"))
                need(first == reached, "it does not start where the cell before it ends")
                need(first < last <= problem.span, "it ends before it starts, or after the window")
                cell = _Cell(problem, m * problem.span, (first, last), problem.distance - upper, one, extended)
                polygons, balls = _polygons(cell), _balls(cell)
                with located("tree"):
                    leaves += _check_tree(cell, balls, one["tree"], polygons, 0)
            reached, done = last, done + 1
            if progress is not None:
                progress(done, total)
        need(reached == problem.span, f"window {m}: its cells do not reach the window's end")
    return Verified(lower, upper, leaves, total, len(windows))
