"""Inequality (**) of docs/margin.md: bounds of the norm couple the axes. The search for θ and λ, in floating point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmproof.margin.corners import largest_product
from swarmproof.margin.polygon import Corners, Edge
from swarmproof.margin.problem import Floats

#: Points added to each edge of a polygon before the first linear program, and how often worse ones are added.
SPREAD, MOST_PROGRAMS = 4, 12
#: By how much (relative to d̂_min²) the linear program may be too low before points are added.
GAIN = 1e-10
#: Values of θ that are tried after the first, and the smallest one.
SHARES, SMALLEST_SHARE = 6, 1e-9
#: Ball edges with a smaller offset (relative to d̂_min) have no weight: nothing moves that far.
NOTHING = 1e-12


@dataclass(frozen=True)
class BallLeaf:
    """One t, one θ and a weight λ for each ball edge of the cell suffice for all motions."""

    t: float
    share: float
    weights: tuple[float, ...]


@dataclass(frozen=True)
class Balance:
    """What the best λ for one (t, θ) yields.

    `left` is the left side of (**), m²; `gram` the Gram matrix of (δ, g) at which that is reached, as a mixture of
    points (weight, axis, δ, g); `off` is √U there, m.
    """

    left: float
    share: float
    weights: tuple[float, ...]
    points: tuple[tuple[float, int, float, float], ...]
    off: float

    @property
    def gram(self) -> Floats:
        """Return the Gram matrix of δ and g, 2 × 2, m²."""
        total = np.zeros((2, 2))
        for weight, _, delta, sagitta in self.points:
            total += weight * np.outer((delta, sagitta), (delta, sagitta))
        return total


class BallValues:
    """(**) for the polygons of the three axes and some ball edges; `early` and `late` are τ/T at the cell's ends."""

    def __init__(
        self,
        polygons: Sequence[Corners],
        edges: Sequence[Edge],
        scales: Floats,
        distance: float,
        early: float,
        late: float,
    ) -> None:
        self._polygons, self._scales, self._distance = polygons, scales**2, distance
        self._early, self._late = early, late
        self._offsets = np.array([edge.offset for edge in edges])
        directions = np.array([edge.direction for edge in edges]).reshape(-1, 2)
        self._used = self._offsets > NOTHING * distance
        #: Per edge that is used (α², αβ, β²)/c², so that λc² is the unknown.
        some = directions[self._used] / self._offsets[self._used, None]
        self._forms = np.stack([some[:, 0] ** 2, some[:, 0] * some[:, 1], some[:, 1] ** 2], axis=1)
        self._points = [_spread(polygon) for polygon in polygons]

    def best(self, closest: float, goal: float, t: float = 0.0) -> Balance:
        """Return the best θ and λ for ρ = `closest`; it stops when (**) holds with `goal` (m²) on the right.

        The left side, plus ρ²/(1 − θ), is convex in θ; at its least θ is √U/(√U + ρ) for the worst pair's U.
        """
        low, high = SMALLEST_SHARE, 1.0 if closest == 0 else 1 - SMALLEST_SHARE
        share = min(max(self._first_share(closest, t), low), high)
        best: tuple[float, Balance] | None = None
        for _ in range(1 + SHARES):
            found = self._weights(t, share)
            total = found.left + (closest**2 / (1 - share) if closest else 0.0)
            if best is None or total < best[0]:
                best = total, found
            if best[0] <= goal:
                break
            own = min(max(round(found.off / max(found.off + closest, 1e-300), 12), SMALLEST_SHARE), high)
            # the saddle lies between a θ and what the worst pair at that θ asks for
            low, high = (share, high) if own > share else (low, share)
            following = own if low < own < high else round((low + high) / 2, 12)
            if abs(following - share) < 1e-7 * min(share, 1.0):
                break
            share = following
        assert best is not None
        return best[1]

    def _first_share(self, closest: float, t: float) -> float:
        tops = [float(np.abs(polygon[:, 1] + t * polygon[:, 0]).max(initial=0.0)) for polygon in self._polygons]
        off = float(np.sqrt(self._scales @ np.array(tops) ** 2))
        return round(off / max(off + closest, 1e-300), 12)

    def _weights(self, t: float, share: float) -> Balance:
        """Return the λ with the smallest left side: cutting planes, since every maximum is one of linear functions."""
        from scipy.optimize import linprog  # half a second to import

        solver: Any = linprog
        kappa, square = largest_product(self._early + t, self._late + t), self._distance**2
        targets = np.array([kappa + t * t / share, t / share, 1 / share])
        count = len(self._forms)
        cost = np.concatenate([np.ones(3), np.ones(count)])
        weights, best = np.zeros(count), np.inf
        answer: Balance | None = None
        points = [list(map(tuple, some)) for some in self._points]
        for _ in range(MOST_PROGRAMS):
            rows, levels, owners = [], [], []
            for axis, some in enumerate(points):
                products = _products(np.array(some))
                rows.append(np.hstack([-np.eye(3)[[axis] * len(some)], -products @ self._forms.T]))
                levels.append(-(products @ targets) * self._scales[axis] / square)
                owners += [(axis, *point) for point in some]
            result = solver(cost, A_ub=np.vstack(rows), b_ub=np.concatenate(levels), bounds=(0, None), method="highs")
            if result.x is None:
                break
            weights = np.asarray(result.x[3:])
            tops, worst = self._tops(targets, weights)
            total = float(tops.sum() + weights.sum())
            shares = -np.asarray(result.ineqlin.marginals)
            if total < best:
                best = total
                mixture = tuple(
                    (float(s), axis, x, y) for s, (axis, x, y) in zip(shares, owners, strict=True) if s > 1e-9
                )
                off = sum(s * self._scales[axis] * (y + t * x) ** 2 for s, axis, x, y in mixture)
                answer = Balance(square * total, share, self._full(weights), mixture, float(off) ** 0.5)
            added = False
            for axis in range(3):
                if tops[axis] > result.x[axis] + GAIN / 3 and worst[axis] not in points[axis]:
                    points[axis].append(worst[axis])
                    added = True
            if not added or total <= float(result.fun) + GAIN:
                break
        self._points = [np.array(some) for some in points]
        if answer is None:
            return Balance(float("inf"), share, self._full(weights), (), 0.0)
        return answer

    def _tops(self, targets: Floats, weights: Floats) -> tuple[Floats, list[tuple[float, float]]]:
        """Return per axis the maximum of its form (in d̂_min²), and where it is."""
        drawn = weights @ self._forms if len(weights) else np.zeros(3)
        tops, places = [], []
        for scale, polygon in zip(self._scales, self._polygons, strict=True):
            top, place = largest(scale * targets / self._distance**2 - drawn, polygon)
            tops.append(top)
            places.append(place)
        return np.array(tops), places

    def _full(self, weights: Floats) -> tuple[float, ...]:
        """Return λ for every edge, with few digits."""
        result = np.zeros(len(self._offsets))
        result[self._used] = self._distance**2 * weights / self._offsets[self._used] ** 2
        return tuple(float(f"{max(value, 0.0):.12g}") for value in result)


def largest(form: Floats, polygon: Corners) -> tuple[float, tuple[float, float]]:
    """Return the maximum (at least 0) of xx·δ² + 2xy·δg + yy·g², `form` = (xx, xy, yy), over a polygon, and where."""
    if len(polygon) == 0:
        return 0.0, (0.0, 0.0)
    xx, xy, yy = form
    quadratic = np.array([[xx, xy], [xy, yy]])
    ways = np.roll(polygon, -1, axis=0) - polygon
    bend = np.einsum("ij,jk,ik->i", ways, quadratic, ways)
    slope = np.einsum("ij,jk,ik->i", polygon, quadratic, ways)
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = np.where(bend < 0, np.clip(-slope / bend, 0.0, 1.0), 0.0)
    candidates = np.vstack([polygon, polygon + inside[:, None] * ways])
    values = np.einsum("ij,jk,ik->i", candidates, quadratic, candidates)
    best = int(np.argmax(values))
    if values[best] <= 0:
        return 0.0, (0.0, 0.0)
    return float(values[best]), (float(candidates[best][0]), float(candidates[best][1]))


def _products(points: Floats) -> Floats:
    """Return (δ², 2δg, g²) per point, shape (n, 3)."""
    return np.stack([points[:, 0] ** 2, 2 * points[:, 0] * points[:, 1], points[:, 1] ** 2], axis=1)


def _spread(polygon: Corners) -> Floats:
    """Return the corners and points between them, shape (n, 2)."""
    ways = np.roll(polygon, -1, axis=0) - polygon
    return np.vstack([polygon + step / SPREAD * ways for step in range(SPREAD)])
