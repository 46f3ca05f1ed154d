"""How close the UAVs of one flight come at any time: pieces are collected, and bounded a chunk of rounds at a time."""

from __future__ import annotations

from fractions import Fraction
from math import sqrt

import numpy as np

from swarmproof.claims.closest import ClosestApproach
from swarmproof.monitor.bernstein import Closest, at_least, closest, lowest_per_step
from swarmproof.motion.lattice import Floats, Lattice

#: Periods that are bounded together.
CHUNK = 64


class Separation:
    """Collects pieces, period by period, and keeps the closest approach so far.

    Attributes:
        band: certified bounds (lower, upper) of the smallest distance in every step, in m; a list of (steps, 2).
    """

    def __init__(self, lattice: Lattice, distance: Fraction) -> None:
        self._lattice = lattice
        self._unit = float(lattice.crash.unit)
        self._square = lattice.crash.square(distance)
        self._waiting: list[Floats] = []
        self._steps = 0
        self._closest: Closest | None = None
        self._closest_step = 0
        self._at_least: bool | None = True
        self.band: list[Floats] = []

    def add(self, pieces: Floats) -> None:
        """Take the pieces of one more period, shape (m, U, 3, 4)."""
        self._waiting.append(pieces)
        if len(self._waiting) == CHUNK:
            self._bound()

    def dip(self) -> ClosestApproach:
        """Return the closest approach so far; there must have been a period."""
        self._bound()
        assert self._closest is not None
        time = (self._closest_step + self._closest.fraction) * float(self._lattice.parameters.T_c)
        lower = distance_below(self._closest.lower, self._unit)
        return ClosestApproach(lower, self._at_least, self._closest.pair, time)

    def _bound(self) -> None:
        if not self._waiting:
            return
        pieces = np.concatenate(self._waiting)
        second = self._lattice.crash.among(pieces.shape[1])
        lower, upper = lowest_per_step(pieces, second)
        found = closest(pieces, second)
        answer: bool | None = True
        if self._at_least is not False and found.lower < float(self._square) * (1 + 1e-6):
            answer = at_least(pieces, self._square, second)
        # only now, when nothing takes long any more: an interruption must not lose pieces that are not bounded yet
        self._waiting.clear()
        # three roundings: of the root, of the unit, of the product; made up for in the bounds' directions
        outward = np.array([1 - 2.0**-50, 1 + 2.0**-50])
        self.band.append(np.sqrt(np.maximum(np.stack([lower, upper], axis=1), 0.0)) * self._unit * outward)
        if self._closest is None or found.lower < self._closest.lower:
            self._closest, self._closest_step = found, self._steps + found.step
        self._at_least = answer if answer is not True else self._at_least
        self._steps += len(pieces)


def _down(value: float) -> float:
    """Return a float below the exact value of which `value` is the rounded square root, scaled: three roundings."""
    return value * (1 - 2.0**-50)


def distance_below(square: float, unit: float) -> float:
    """Return a certified lower bound of a distance, in m, whose square is at least `square` lattice units².

    Args:
        square: certified; below 0 it says nothing.
        unit: m; of the lattice.
    """
    return _down(sqrt(max(square, 0.0)) * unit)
