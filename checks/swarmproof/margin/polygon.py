"""Outer polygons of the pairs (δ, g) that one axis can reach, refined where it matters (the sandwich method)."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot

import numpy as np

from swarmproof.margin.extremes import Extremes
from swarmproof.margin.functional import Density, Moment, Multiplier, Term, offset
from swarmproof.margin.problem import AxisBounds, Floats

Corners = Floats  # shape (n, 2), counter-clockwise


@dataclass(frozen=True)
class Edge:
    """αδ + βg ≤ `offset` for both ends of a cell of τ, with the multipliers that prove it at each end.

    `touched` is the attained pair (δ, g) that is largest in this direction.
    """

    direction: tuple[float, float]
    proofs: tuple[tuple[Multiplier, ...], tuple[Multiplier, ...]]
    offset: float
    touched: tuple[float, float]


class Outline:
    """The pairs (δ, g) that one axis reaches for some τ of a cell, from outside.

    An outline is symmetric: every edge counts for its direction and for the opposite one.
    """

    def __init__(
        self,
        extremes: Extremes,
        bounds: AxisBounds,
        order: int,
        cell: tuple[Moment, Moment],
        bending: float,
        whole: float,
    ) -> None:
        self._extremes, self._bounds, self._order, self._whole = extremes, bounds, order, whole
        self._cell = cell
        #: How far g may lie off its chord between the two ends (m).
        self.widening = bending * (cell[1].tau - cell[0].tau) ** 2 / 8
        self._edges: dict[float, Edge] = {}
        self._corners: Corners = np.zeros((0, 2))
        self.add((1.0, 0.0))
        self.add((0.0, 1.0))

    @property
    def edges(self) -> list[Edge]:
        """Return the edges that bound the polygon, and the first two, by the angle of their direction."""
        return [self._edges[angle] for angle in sorted(self._edges) if self._bounds_polygon(self._edges[angle])]

    def thinned(self, tolerance: float) -> list[tuple[float, float]]:
        """Return directions of edges that enclose the same polygon up to corners of `tolerance` (m in (δ, g))."""
        kept = self.edges
        if len(kept) <= 4:
            return [edge.direction for edge in kept]
        for edge in kept[:]:
            index = kept.index(edge)
            if 0.0 not in edge.direction and _depth(kept[index - 1], edge, kept[(index + 1) % len(kept)]) < tolerance:
                kept.remove(edge)
        return [edge.direction for edge in kept]

    def _bounds_polygon(self, edge: Edge) -> bool:
        (alpha, beta), far = edge.direction, edge.offset
        reach = float(np.abs(self._corners @ np.array([alpha, beta])).max(initial=0.0))
        return 0.0 in (alpha, beta) or reach >= far * (1 - 1e-9)

    def add(self, direction: tuple[float, float]) -> bool:
        """Add the supporting half-plane of a direction; say whether it is new."""
        alpha, beta = _short(direction)
        angle = _angle(alpha, beta)
        if angle in self._edges:
            return False
        if angle != atan2(beta, alpha):
            alpha, beta = -alpha, -beta
        proofs, offsets, points = [], [], []
        for moment in self._cell:
            extreme = self._extremes.at(moment, alpha, beta)
            proofs.append(tuple(_rounded(term) for term in extreme.multipliers))
            offsets.append(offset(moment, alpha, beta, proofs[-1], self._bounds, self._order, self._whole))
            points.append(moment.point(extreme.motion))
        best = max(range(2), key=lambda end: offsets[end])
        edge = Edge((alpha, beta), (proofs[0], proofs[1]), offsets[best] + abs(beta) * self.widening, points[best])
        self._edges[angle] = edge
        self._cut_by(edge)
        return True

    @property
    def corners(self) -> Corners:
        """Return the corners, shape (n, 2), counter-clockwise."""
        return self._corners

    def _cut_by(self, edge: Edge) -> None:
        if len(self._edges) == 2 and len(self._corners) == 0:
            wide, high = (self._edges[angle].offset for angle in sorted(self._edges))
            self._corners = np.array([(wide, high), (-wide, high), (-wide, -high), (wide, -high)])
        elif len(self._corners):
            alpha, beta = edge.direction
            for sign in (1.0, -1.0):
                self._corners = clip(self._corners, (sign * alpha, sign * beta), edge.offset)

    def beside(self, corner: tuple[float, float]) -> list[tuple[tuple[float, float], tuple[float, float]]]:
        """Return the directions (outward) of the two edges at a corner, with the pair that each one touches.

        A point inside an edge, where a cut meets it, stands for the corner at which that edge leaves what is attained.
        """
        first, second = self._nearest(corner)
        if second[0] > 1e-9 * hypot(*corner):
            _, (alpha, beta), touched = first
            values, ahead = self._corners @ np.array([alpha, beta]), np.array(corner) - np.array(touched)
            on_edge = values >= float(values.max()) - 1e-9 * hypot(*corner)
            beyond = (self._corners - np.array(touched)) @ ahead > 0
            for end in self._corners[on_edge & beyond][:1]:
                first, second = self._nearest((float(end[0]), float(end[1])))
        return [first[1:], second[1:]]

    def _nearest(self, point: tuple[float, float]) -> list[tuple[float, tuple[float, float], tuple[float, float]]]:
        """Return the two edges nearest to a point: distance, outward direction, touched pair."""
        near: list[tuple[float, tuple[float, float], tuple[float, float]]] = []
        for edge in self._edges.values():
            (alpha, beta), (delta, sagitta) = edge.direction, edge.touched
            for sign in (1.0, -1.0):
                left = edge.offset - sign * (alpha * point[0] + beta * point[1])
                near.append((left / hypot(alpha, beta), (sign * alpha, sign * beta), (sign * delta, sign * sagitta)))
        return sorted(near)[:2]

    def refine(self, corner: tuple[float, float], tolerance: float) -> bool:
        """Cut off what lies between `corner` and the segment of the two attained pairs beside it.

        Say whether the new edge moves the outline there by more than `tolerance` (a length in the (δ, g) plane, m).
        """
        (_, first), (_, second) = self.beside(corner)
        along = second[0] - first[0], second[1] - first[1]
        if max(abs(along[0]), abs(along[1])) < 1e-13:
            return False
        normal = along[1], -along[0]
        alpha, beta = _short(normal)
        if not self.add(normal):
            return False
        edge = self._edges[_angle(alpha, beta)]
        return abs(alpha * corner[0] + beta * corner[1]) - edge.offset > tolerance * hypot(alpha, beta)


def _depth(before: Edge, edge: Edge, after: Edge) -> float:
    """Return how far the crossing of its neighbours lies outside an edge; neighbours may count with the other sign."""
    ahead = np.array(edge.direction)
    rows, levels = [], []
    for other in (before, after):
        sign = 1.0 if float(ahead @ np.array(other.direction)) >= 0 else -1.0
        rows.append(sign * np.array(other.direction))
        levels.append(other.offset)
    if abs(np.linalg.det(np.array(rows))) < 1e-14:
        return float("inf")
    corner = np.linalg.solve(np.array(rows), np.array(levels))
    return float(ahead @ corner - edge.offset) / hypot(*edge.direction)


def _angle(alpha: float, beta: float) -> float:
    """Return the angle of a direction or of its opposite, whichever is in [0, π)."""
    return atan2(-beta, -alpha) if beta < 0 or (beta == 0 and alpha < 0) else atan2(beta, alpha)


def _short(direction: tuple[float, float]) -> tuple[float, float]:
    """Return nearly the same direction with a largest entry of 1 and few digits."""
    size = max(abs(direction[0]), abs(direction[1]))
    return round(direction[0] / size, 7), round(direction[1] / size, 7)


def _rounded(used: Multiplier) -> Multiplier:
    """Return the multiplier with few digits; any multipliers prove a bound."""
    if isinstance(used, Density):
        start, end, first, last = (round(value, 12) for value in (used.start, used.end, used.first, used.last))
        return Density(start, end, used.derivative, first, last)
    return Term(round(used.time, 12), used.derivative, round(used.weight, 12))


def clip(corners: Corners, normal: tuple[float, float], level: float) -> Corners:
    """Return the part of a convex polygon with normal·corner ≤ level, shape (m, 2); m may be 0."""
    values = corners @ np.array(normal) - level
    kept = []
    for i, value in enumerate(values):
        j = (i + 1) % len(values)
        if value <= 0:
            kept.append(corners[i])
        if (value < 0 < values[j]) or (values[j] < 0 < value):
            kept.append(corners[i] + (corners[j] - corners[i]) * (value / (value - values[j])))
    return np.array(kept).reshape(-1, 2)
