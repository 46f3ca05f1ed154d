"""Proofs with bounds of the norm: branch over τ, and one leaf with θ and λ for each cell (docs/margin.md, (**))."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heapify, heappop, heappush
from math import hypot

import numpy as np

from swarmproof.margin.ball import Balance, BallLeaf, BallValues
from swarmproof.margin.extremes import Extremes, extremes
from swarmproof.margin.functional import Moment
from swarmproof.margin.polygon import Corners, Edge, Outline, clip
from swarmproof.margin.problem import Floats, Problem
from swarmproof.margin.prove import Blocked, Budget, Cell, WindowProver

#: Directions of the (δ, g) plane, scaled to its size, with which every outline begins.
FIRST = 8
#: Refinements of one cell, ball edges and edges that one of them may add.
MOST_REFINEMENTS, MOST_ADDED = 20, 3
#: Directions among which a new ball edge is looked for.
ANGLES = 90
#: A ball edge is new only if it cuts off this much of the Gram matrix, relatively.
CUT = 1e-5
#: How far below the limit the left side of (**) must be, relative to d̂_min², so that the exact check agrees.
SLACK = 2e-11
#: Halvings of [0, T_c], and the share of what is missing to which a cell's width must add for a halving to help.
MOST_HALVINGS, HELPS = 14, 0.02
#: Values of t after the first.
MOST_SHIFTS = 3

Direction = tuple[float, float]
Directions = tuple[Direction, ...]
#: How urgent a cell is (least first), its ends, and directions for the axes' outlines and for the ball's.
_Waiting = tuple[float, Fraction, Fraction, tuple[Directions, ...], Directions]


@dataclass(frozen=True)
class _Tried:
    """A leaf, or None where (**) does not hold: then `excess` (m) is about how much is missing."""

    leaf: BallLeaf | None
    ball: tuple[Edge, ...]
    excess: float


class BallProver(WindowProver):
    """Proves lower bounds of the distance in one window, from bounds of the norm; it asks for a diagonal Θ⁻¹."""

    def __init__(self, problem: Problem, by_kind: list[Extremes], kinds: tuple[int, ...], window: int) -> None:
        super().__init__(problem, by_kind, kinds, window)
        self._ball = extremes(problem, problem.ball)
        self._scales = np.diagonal(problem.scaling)

    def prove(
        self,
        closest: float,
        spare: float,
        budget: Budget,
        refuted: Callable[[Blocked], bool],
        start: Sequence[Cell] = (),
    ) -> list[Cell] | Blocked:
        """Return cells that prove that ‖x‖ ≥ `closest` (m, scaled), or where it got stuck, as the method it replaces.

        `spare` and `refuted` are not used: witnesses are searched elsewhere.
        """
        proved: list[Cell] = []
        waiting: list[_Waiting] = [
            (
                0.0,
                cell.early,
                cell.late,
                tuple(tuple(edge.direction for edge in edges) for edges in cell.edges),
                tuple(edge.direction for edge in cell.ball),
            )
            for cell in start
        ] or [(0.0, Fraction(0), Fraction(1), ((),) * (max(self._kinds) + 1), ())]
        heapify(waiting)
        while waiting:
            _, early, late, directions, ball_directions = heappop(waiting)
            budget.cells -= 1
            outlines = [self._started(self._outline(k, early, late, known)) for k, known in enumerate(directions)]
            ball = self._ball_outline(early, late, ball_directions)
            tried = self._tried(outlines, ball, float(early), float(late), closest)
            if tried.leaf is not None:
                edges = tuple(tuple(outline.edges) for outline in outlines)
                proved.append(Cell(early, late, edges, self._kinds, tried.leaf, tried.ball))
                continue
            width = late - early
            widening = max(outline.widening for outline in (*outlines, ball)) * self._reach
            hopeless = width <= Fraction(1, 64) and widening < HELPS * tried.excess
            if width <= Fraction(1, 2**MOST_HALVINGS) or budget.spent or hopeless:
                return Blocked(float(early + late) / 2, (), excess=tried.excess)
            middle = (early + late) / 2
            hints = tuple(tuple(edge.direction for edge in outline.edges) for outline in outlines)
            kept = tuple(edge.direction for edge in ball.edges)
            heappush(waiting, (-tried.excess, early, middle, hints, kept))
            heappush(waiting, (-tried.excess, middle, late, hints, kept))
        return proved

    def _started(self, outline: Outline) -> Outline:
        """Return the outline with edges in :data:`FIRST` directions of its own scale."""
        wide, high = np.abs(outline.corners).max(axis=0)
        if wide > 0 and high > 0:
            for step in range(1, FIRST):
                angle = np.pi * step / FIRST
                outline.add((float(np.cos(angle) * high / wide), float(np.sin(angle))))
        return outline

    def _ball_outline(self, early: Fraction, late: Fraction, directions: Collection[Direction]) -> Outline:
        problem = self._problem
        start, length = problem.start_of(self._window), problem.window_length
        first, second = (Moment(start, float(share) * length, length) for share in (early, late))
        bending = problem.bending(problem.ball)
        outline = self._started(Outline(self._ball, problem.ball, problem.order, (first, second), bending, self._whole))
        middle = float(early + late) / 2
        # constant velocity is best up to these two, where the way before τ, or that after it, ceases to count
        for direction in sorted({*directions, (1 - middle, 1.0), (middle, -1.0)}):
            outline.add(direction)
        return outline

    def _tried(self, outlines: list[Outline], ball: Outline, early: float, late: float, closest: float) -> _Tried:
        """Return a leaf for the cell, with refined outlines where that is needed and helps."""
        before, widening = np.inf, max(outline.widening for outline in (*outlines, ball)) * self._reach
        for _ in range(MOST_REFINEMENTS):
            polygons = [clip(outlines[kind].corners, (-1.0, 0.0), 0.0) for kind in self._kinds]
            leaves = _Leaves(ball.edges, self._scales, self._problem.distance, (early, late), closest)
            balance, t = leaves.balanced(polygons)
            missing = leaves.missing(balance)
            if missing <= 0:
                return self._kept(t, balance, ball)
            excess = missing / (2 * (balance.off + closest) + 1e-12 * self._problem.distance)
            # what a halving takes away needs no refinement
            if (
                widening > 0.3 * excess
                or missing > 0.995 * before
                or not self._refined(outlines, ball, polygons, balance)
            ):
                break
            before = missing
        return _Tried(None, (), excess)

    @staticmethod
    def _kept(t: float, balance: Balance, ball: Outline) -> _Tried:
        """Return the leaf with the ball edges that have a weight."""
        edges = ball.edges
        used = [i for i, weight in enumerate(balance.weights) if weight > 0]
        weights = tuple(balance.weights[i] for i in used)
        return _Tried(BallLeaf(t, balance.share, weights), tuple(edges[i] for i in used), 0.0)

    def _refined(self, outlines: list[Outline], ball: Outline, polygons: list[Corners], balance: Balance) -> bool:
        """Add ball edges that the Gram matrix of the worst pair exceeds, and edges at the corners it is mixed of."""
        changed = False
        for direction in _exceeded(ball, balance.gram):
            changed |= ball.add(direction)
        for weight, axis, delta, sagitta in balance.points:
            corner = np.array([delta, sagitta])
            off = np.abs(polygons[axis] - corner).max(axis=1)
            if weight > 1e-6 and len(off) and float(off.min()) <= 1e-9 * hypot(delta, sagitta):
                changed |= outlines[self._kinds[axis]].refine((delta, sagitta), CUT * hypot(delta, sagitta))
        return changed


def _exceeded(ball: Outline, gram: Floats) -> list[Direction]:
    """Return where the Gram matrix exceeds by most what scalar motions are known to reach, per range of angles.

    Candidates are all angles, and across the segments between pairs that are attained: the set may have edges there.
    """
    wide, high = np.abs(ball.corners).max(axis=0)
    if not (wide > 0 and high > 0):
        return []
    scale = np.array([1 / wide, 1 / high])
    touched = np.array([edge.touched for edge in ball.edges]) * scale
    touched = np.vstack([touched, -touched])
    touched = touched[np.argsort(np.arctan2(touched[:, 1], touched[:, 0]))]
    angles = np.pi * np.arange(ANGLES) / ANGLES
    ways = np.roll(touched, -1, axis=0) - touched
    across = np.stack([ways[:, 1], -ways[:, 0]], axis=1)[np.abs(ways).max(axis=1) > 1e-9]
    some = np.vstack([np.stack([np.cos(angles), np.sin(angles)], axis=1), across])
    some[some[:, 1] < 0] *= -1
    some = some[np.argsort(np.arctan2(some[:, 1], some[:, 0]))]
    reached = np.abs(some @ touched.T).max(axis=1) ** 2
    ratio = np.einsum("ij,jk,ik->i", some, gram * np.outer(scale, scale), some) / np.maximum(reached, 1e-300)
    peaks = (ratio >= np.roll(ratio, 1)) & (ratio >= np.roll(ratio, -1)) & (ratio > 1 + CUT)
    best = sorted(np.flatnonzero(peaks), key=lambda index: -float(ratio[index]))[:MOST_ADDED]
    return [(float(some[index][0] * scale[0]), float(some[index][1] * scale[1])) for index in best]


class _Leaves:
    """Looks for t, θ and λ for the polygons of one cell."""

    def __init__(
        self, edges: list[Edge], scales: Floats, distance: float, cell: tuple[float, float], closest: float
    ) -> None:
        self._edges, self._scales, self._distance = edges, scales, distance
        self._cell, self._closest = cell, closest
        self._limit = distance**2 * (1 - SLACK)

    def missing(self, balance: Balance) -> float:
        """Return by how much (m²) the left side of (**) is above the right side."""
        closest = self._closest
        return balance.left + (closest**2 / (1 - balance.share) if closest else 0.0) - self._limit

    def balanced(self, polygons: list[Corners]) -> tuple[Balance, float]:
        """Return the best balance found and its t: 0 first, then the one that suits the worst pair there."""
        early, late = self._cell
        values = BallValues(polygons, self._edges, self._scales, self._distance, early, late)
        found, t = values.best(self._closest, self._limit), 0.0
        for _ in range(MOST_SHIFTS):
            if self.missing(found) <= 0 or not found.points:
                break
            along = sum(w * self._scales[k] ** 2 * x * x for w, k, x, _ in found.points)
            across = sum(w * self._scales[k] ** 2 * x * y for w, k, x, y in found.points)
            wanted = min(max(round(-across / max(along, 1e-300), 9), -early), 1 - late)
            if abs(wanted - t) < 1e-6:
                break
            moved = values.best(self._closest, self._limit, wanted)
            if self.missing(moved) >= self.missing(found):
                break
            found, t = moved, wanted
        return found, t
