"""Inequality (*) of docs/margin.md at the corners of a product of three polygons."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from swarmproof.margin.polygon import Corners
from swarmproof.margin.problem import Floats

#: Values of t tried before the best one is narrowed down, and steps of narrowing.
GRID, STEPS = 11, 24
#: How often corners are added to those for which t is chosen.
MOST_ROUNDS = 40
_GOLDEN = (5**0.5 - 1) / 2

Triple = tuple[int, int, int]


@dataclass(frozen=True)
class Worst:
    """What one t says about all corners.

    `closeness` is the largest −(*) over the corners (so −closeness bounds ‖x‖ from below, m; inf: no bound), `t` the
    weight's shift, `here` the index triple of the worst corner, `rival` that of a corner that wants t on the other side
    (None if there is none), `at_best` the worst corner's own value under the t that suits it best.
    """

    closeness: float
    t: float
    here: Triple
    rival: Triple | None
    at_best: float


class CornerValues:
    """−(*) at every triple of corners, as a function of t; `early` and `late` are τ/T at the two ends of the cell."""

    def __init__(self, polygons: list[Corners], scaling: Floats, distance: float, early: float, late: float) -> None:
        self._polygons = polygons
        #: Per axis the corners' shares of Aδ and of Ag, shape (corners, 3).
        self._delta = [polygon[:, 0, None] * scaling[None, :, k] for k, polygon in enumerate(polygons)]
        self._sagitta = [polygon[:, 1, None] * scaling[None, :, k] for k, polygon in enumerate(polygons)]
        self._diagonal = bool(np.count_nonzero(scaling - np.diag(np.diagonal(scaling))) == 0)
        self._distance, self._early, self._late = distance, early, late

    def worst(self, goal: float) -> Worst:
        """Return the t whose worst corner is best, and what hinders a better one if that is above `goal` (m).

        It is chosen for a few corners; whichever is worse than these is added until none is.
        """
        some = [
            sorted({int(np.argmax(p[:, 0])), int(np.argmax(p[:, 1])), int(np.argmin(p[:, 1]))}) for p in self._polygons
        ]
        for _ in range(MOST_ROUNDS):
            t = self._minimise(self._largest(some))
            values, chosen = self._values(t, self._foremost(t))
            here = self._triple(int(np.argmax(values)), chosen)
            added = [sorted({*known, corner}) for known, corner in zip(some, here, strict=True)]
            if added == some:
                break
            some = added
        top = float(values.max())
        if top <= goal or not np.isfinite(top):
            return Worst(top, t, here, None, top)
        alone = [[corner] for corner in here]
        own = self._minimise(self._largest(alone))
        return Worst(top, t, here, self._rival(t, here, some), float(self._values(own, alone)[0].max()))

    def _values(self, t: float, chosen: Sequence[Sequence[int]]) -> tuple[Floats, Sequence[Sequence[int]]]:
        """Return −(*) at all triples of the chosen corners, flattened; inf where the root does not exist."""
        return closeness(*self._squares(chosen), self._distance, self._product(t), t), chosen

    def _squares(self, chosen: Sequence[Sequence[int]]) -> tuple[Floats, Floats, Floats]:
        """Return ‖Aδ‖², δᵀA²g and ‖Ag‖² at all triples of the chosen corners."""
        delta, sagitta = (
            sums([part[list(indices)] for part, indices in zip(parts, chosen, strict=True)])
            for parts in (self._delta, self._sagitta)
        )
        return squares(delta, sagitta)

    def _product(self, t: float) -> float:
        return largest_product(self._early + t, self._late + t)

    def _largest(self, chosen: Sequence[Sequence[int]]) -> Callable[[float], float]:
        """Return the largest −(*) at the chosen corners as a function of t."""
        known = self._squares(chosen)
        return lambda t: float(closeness(*known, self._distance, self._product(t), t).max())

    def _foremost(self, t: float) -> list[list[int]]:
        """Return per axis the corners that can be worst at t: if A is diagonal, (*) falls in |δ| and in |g + tδ|."""
        if not self._diagonal:
            return [list(range(len(polygon))) for polygon in self._polygons]
        result = []
        for polygon in self._polygons:
            far, off = np.abs(polygon[:, 0]), np.abs(polygon[:, 1] + t * polygon[:, 0])
            kept: list[int] = []
            highest = -1.0
            for index in np.lexsort((-off, -far)):
                if off[index] > highest:
                    kept.append(int(index))
                    highest = float(off[index])
            result.append(kept)
        return result

    def _rival(self, t: float, here: Triple, some: list[list[int]]) -> Triple | None:
        """Return the worst corner, of those that t was chosen for, that gets better where the worst one gets worse."""
        step = 1e-6 if t < 1 - self._late - 2e-6 else -1e-6
        values, _ = self._values(t, some)
        slopes = (self._values(t + step, some)[0] - values) / step
        mine = slopes[np.ravel_multi_index([known.index(i) for known, i in zip(some, here, strict=True)], _shape(some))]
        opposed = np.where(slopes * mine < 0, values, -np.inf)
        rival = int(np.argmax(opposed))
        return self._triple(rival, some) if np.isfinite(opposed[rival]) else None

    @staticmethod
    def _triple(flat: int, chosen: Sequence[Sequence[int]]) -> Triple:
        i, j, k = np.unravel_index(flat, _shape(chosen))
        return chosen[0][int(i)], chosen[1][int(j)], chosen[2][int(k)]

    def _minimise(self, function: Callable[[float], float]) -> float:
        """Return the (rounded) t in its range where `function` is about smallest: a grid, then golden sections."""
        low, high = -self._early, 1 - self._late
        grid = np.linspace(low, high, GRID)
        best = int(np.argmin([function(float(t)) for t in grid]))
        left, right = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, GRID - 1)])
        first, second = right - _GOLDEN * (right - left), left + _GOLDEN * (right - left)
        at_first, at_second = function(first), function(second)
        for _ in range(STEPS):
            if at_first < at_second:
                right, second, at_second = second, first, at_first
                first = right - _GOLDEN * (right - left)
                at_first = function(first)
            else:
                left, first, at_first = first, second, at_second
                second = left + _GOLDEN * (right - left)
                at_second = function(second)
        return min(max(round((left + right) / 2, 9), low), high)


def squares(delta: Floats, sagitta: Floats) -> tuple[Floats, Floats, Floats]:
    """Return ‖Aδ‖², δᵀA²g and ‖Ag‖² of scaled rows Aδ and Ag, each of shape (n, 3)."""
    dd, gd, gg = (np.einsum("ij,ij->i", a, b) for a, b in ((delta, delta), (sagitta, delta), (sagitta, sagitta)))
    return dd, gd, gg


def closeness(
    dd: Floats, gd: Floats, gg: Floats, distance: float, product: float | Floats, t: float | Floats
) -> Floats:
    """Return −(*) for pairs with these :func:`squares`, κ = `product` and t; inf where the root does not exist."""
    left = distance**2 - product * dd
    off = np.sqrt(np.maximum(gg + 2 * t * gd + t * t * dd, 0.0))
    return np.where(left >= 0, off - np.sqrt(np.maximum(left, 0.0)), np.inf)


def largest_product(low: float, high: float) -> float:
    """Return the largest μ₀μ₁ for μ₁ between `low` and `high`."""
    return 0.25 if low <= 0.5 <= high else max(low * (1 - low), high * (1 - high))


def _shape(chosen: Sequence[Sequence[int]]) -> tuple[int, int, int]:
    return len(chosen[0]), len(chosen[1]), len(chosen[2])


def sums(parts: list[Floats]) -> Floats:
    """Return all sums of one row of each part, shape (product of the rows, 3)."""
    x, y, z = parts
    return np.asarray((x[:, None, None] + y[None, :, None] + z[None, None, :]).reshape(-1, 3))
