"""Branch and bound: no pair of one window comes closer than ρ (docs/margin.md). An exact check follows."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from heapq import heapify, heappop, heappush

import numpy as np

from swarmproof.margin.ball import BallLeaf
from swarmproof.margin.corners import CornerValues
from swarmproof.margin.extremes import Extremes
from swarmproof.margin.functional import Moment
from swarmproof.margin.polygon import Corners, Edge, Outline, clip
from swarmproof.margin.problem import Problem
from swarmproof.theorem3.parameters import Reading

#: Parts into which the polygons of one cell may be cut, refinements of one cell, and halvings of [0, T_c].
MOST_PARTS, MOST_REFINEMENTS, MOST_HALVINGS = 400, 60, 20
#: Lengths of cells (relative to T_c) at which a blocked proof asks whether what it proves is false.
ASK_AT = tuple(Fraction(1, 2**halvings) for halvings in (4, 7, 10, 14, 18))
#: What an outline may lose when a cell is halved, relative to how exact the proof need be.
THINNING = 0.1
#: How far below −ρ the floating-point values must be, relative to d̂_min, so that the exact check agrees.
SLACK = 1e-11


@dataclass(frozen=True)
class Leaf:
    """One t suffices for all corners."""

    t: float


@dataclass(frozen=True)
class Cut:
    """The polygon of `axis` is cut by normal·(δ, g) = at."""

    axis: int
    normal: tuple[float, float]
    at: float
    below: Tree | None
    above: Tree | None


Tree = Leaf | Cut | BallLeaf


@dataclass(frozen=True)
class Cell:
    """τ/T_c between `early` and `late`: the edges of each kind of axis, which kind each axis is of, and the tree.

    Or a leaf that takes bounds of the norm, with its ball edges.
    """

    early: Fraction
    late: Fraction
    edges: tuple[tuple[Edge, ...], ...]
    kinds: tuple[int, ...]
    tree: Tree
    ball: tuple[Edge, ...] = ()


@dataclass(frozen=True)
class Blocked:
    """Where no proof was found: about this τ/T_c, with these (δ, g) of the three axes."""

    fraction: float
    corner: tuple[tuple[float, float], ...]
    #: Per axis the directions of the edges that meet there.
    directions: tuple[tuple[tuple[float, float], ...], ...] = ()
    #: By how much (m) the corner comes closer than is to be proved, under any t; 0 if only t is in the way.
    excess: float = 0.0


#: How urgent a cell of τ/T_c is (least first), the cell, and directions for the outlines of each kind of axis.
_Waiting = tuple[float, Fraction, Fraction, Sequence[Collection[tuple[float, float]]]]


class Budget:
    """How many cells and parts of cells may still be tried; shared by the windows of one attempt."""

    def __init__(self, cells: int, parts: int) -> None:
        self.cells, self.parts = cells, parts

    @property
    def spent(self) -> bool:
        """Say whether nothing is left."""
        return self.cells <= 0 or self.parts <= 0


class WindowProver:
    """Proves lower bounds of the distance in one window."""

    def __init__(self, problem: Problem, by_kind: list[Extremes], kinds: tuple[int, ...], window: int) -> None:
        self._problem, self._extremes, self._kinds, self._window = problem, by_kind, kinds, window
        self._whole = problem.period if problem.reading is Reading.AS_SAMPLED else 0.0
        self._reach = float(np.linalg.norm(problem.scaling, 2))

    def prove(
        self,
        closest: float,
        spare: float,
        budget: Budget,
        refuted: Callable[[Blocked], bool],
        start: Sequence[Cell] = (),
    ) -> list[Cell] | Blocked:
        """Return cells that prove that ‖x‖ ≥ `closest` (m, scaled), or where it got stuck.

        `spare` (m) is by how much the closest pair that is known stays above `closest`: how exact a proof need be.
        `refuted` is asked now and then whether a pair comes closer there, which ends the attempt. `start` are the cells
        that proved a weaker bound; the search goes on from them.
        """
        proved: list[Cell] = []
        tolerance = THINNING * spare / self._reach
        waiting: list[_Waiting] = [
            (0.0, cell.early, cell.late, [[edge.direction for edge in edges] for edges in cell.edges]) for cell in start
        ] or [(0.0, Fraction(0), Fraction(1), [() for _ in range(max(self._kinds) + 1)])]
        # where most is missing comes first: if the bound is false, that is where a pair refutes it
        heapify(waiting)
        while waiting:
            _, early, late, directions = heappop(waiting)
            budget.cells -= 1
            outlines = [self._outline(kind, early, late, directions[kind]) for kind in range(len(directions))]
            tree = self._cell(outlines, float(early), float(late), closest, budget)
            if not isinstance(tree, Blocked):
                edges = tuple(tuple(outline.edges) for outline in outlines)
                proved.append(Cell(early, late, edges, self._kinds, tree))
                continue
            if late - early <= Fraction(1, 2**MOST_HALVINGS) or budget.spent:
                return tree
            if tree.excess > 0 and late - early in ASK_AT and refuted(tree):
                return tree
            middle = (early + late) / 2
            hints = [outline.thinned(tolerance) for outline in outlines]
            heappush(waiting, (-tree.excess, early, middle, hints))
            heappush(waiting, (-tree.excess, middle, late, hints))
        return proved

    def _outline(
        self, kind: int, early: Fraction, late: Fraction, directions: Collection[tuple[float, float]]
    ) -> Outline:
        problem, axis = self._problem, self._kinds.index(kind)
        start, length = problem.start_of(self._window), problem.window_length
        first, second = (Moment(start, float(share) * length, length) for share in (early, late))
        outline = Outline(
            self._extremes[kind],
            problem.axes[axis],
            problem.order,
            (first, second),
            problem.bending(problem.axes[axis]),
            self._whole,
        )
        for direction in sorted(directions):
            outline.add(direction)
        return outline

    def _cell(
        self, outlines: list[Outline], early: float, late: float, closest: float, budget: Budget
    ) -> Tree | Blocked:
        blocked = Blocked((early + late) / 2, ())
        for _ in range(MOST_REFINEMENTS):
            polygons = []
            for axis, kind in enumerate(self._kinds):
                corners = outlines[kind].corners
                mirrored = self._problem.diagonal or axis == 0
                polygons.append(clip(corners, (-1.0, 0.0), 0.0) if mirrored else corners)
            parts = _Parts(self._problem, early, late, closest, budget)
            tree = parts.prove(polygons)
            if not isinstance(tree, Blocked):
                return tree
            blocked = tree
            widening = max(outline.widening for outline in outlines) * self._reach
            if tree.excess <= 0 or widening > 0.3 * tree.excess:
                break
            tolerance = 0.02 * tree.excess / self._reach
            moved = [outlines[kind].refine(blocked.corner[axis], tolerance) for axis, kind in enumerate(self._kinds)]
            if not any(moved):
                break
        if not blocked.corner:
            return blocked
        beside = [outlines[kind].beside(corner) for kind, corner in zip(self._kinds, blocked.corner, strict=True)]
        return replace(blocked, directions=tuple(tuple(direction for direction, _ in edges) for edges in beside))


class _Parts:
    """Cuts the polygons of one cell until every part has a t of its own."""

    def __init__(self, problem: Problem, early: float, late: float, closest: float, budget: Budget) -> None:
        self._problem, self._early, self._late = problem, early, late
        self._goal = -closest - SLACK * problem.distance
        self._left, self._budget = MOST_PARTS, budget

    def prove(self, polygons: list[Corners]) -> Tree | Blocked:
        """Return a tree that proves the goal at all corners, or the corner that blocks."""
        self._left -= 1
        self._budget.parts -= 1
        values = CornerValues(polygons, self._problem.scaling, self._problem.distance, self._early, self._late)
        worst = values.worst(self._goal)
        if worst.closeness <= self._goal:
            return Leaf(worst.t)
        corner = tuple((float(p[i][0]), float(p[i][1])) for p, i in zip(polygons, worst.here, strict=True))
        blocked = Blocked((self._early + self._late) / 2, corner)
        if worst.at_best > self._goal:
            return replace(blocked, excess=worst.at_best - self._goal)
        if worst.rival is None or self._left <= 0 or self._budget.spent:
            return blocked
        axis, normal, level = self._between(polygons, worst.here, worst.rival)
        parts: list[Tree | None] = []
        for sign in (1, -1):
            part = clip(polygons[axis], (sign * normal[0], sign * normal[1]), sign * level)
            if len(part) == 0:
                parts.append(None)
                continue
            tree = self.prove([*polygons[:axis], part, *polygons[axis + 1 :]])
            if isinstance(tree, Blocked):
                return tree
            parts.append(tree)
        return Cut(axis, normal, level, parts[0], parts[1])

    def _between(
        self, polygons: list[Corners], here: tuple[int, ...], rival: tuple[int, ...]
    ) -> tuple[int, tuple[float, float], float]:
        """Return the cut parallel to δ or g that separates the two corners where they differ most (scaled)."""
        best, choice = -1.0, (0, 0)
        for axis, (i, j) in enumerate(zip(here, rival, strict=True)):
            size = float(np.linalg.norm(self._problem.scaling[:, axis]))
            for column in range(2):
                apart = abs(float(polygons[axis][i][column] - polygons[axis][j][column])) * size
                if apart > best:
                    best, choice = apart, (axis, column)
        axis, column = choice
        first, second = (float(polygons[axis][index[axis]][column]) for index in (here, rival))
        # t has the sign opposite to that of g, so zero separates better than the middle
        level = 0.0 if column == 1 and first * second < 0 else (first + second) / 2
        return axis, (1.0, 0.0) if column == 0 else (0.0, 1.0), round(level, 12)
