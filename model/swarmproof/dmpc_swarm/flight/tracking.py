"""Assumption 1: a UAV is never further from its reference than Δd_min. How it strays within that is up to the wind."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from swarmproof.motion.lattice import Floats, Lattice

#: Of its last deviation, this share remains after a step T_c; the rest is new. Deviations last for about a second.
MEMORY = 0.9


class TrackingError:
    """Deviations of all UAVs from their references at the samples, linear in between: seeded, smooth and bounded.

    A straight line between two points of a ball stays in the ball, so the bound holds at all times.
    """

    def __init__(self, lattice: Lattice, bounds: Sequence[Fraction], seed: int) -> None:
        self._first = lattice.crash.first
        self._radius = np.array([[float(bound / lattice.position_unit)] for bound in bounds])
        self._rng = np.random.default_rng([seed, 5])
        self._now = np.zeros((len(bounds), 3))

    def pieces(self, steps: int) -> Floats:
        """Return the deviations over the next `steps` steps, as `observing.reference_pieces`: (steps, U, 3, 4)."""
        pieces = np.empty((steps, len(self._now), 3, 4))
        for step in pieces:
            after = self._next()
            third = (after - self._now) / 3
            for k in range(4):
                step[:, :, k] = (self._now + k * third) @ self._first.T
            self._now = after
        return pieces

    def _next(self) -> Floats:
        """Return the deviations at the next sample: integers divisible by three, so that thirds are exact."""
        wish = MEMORY * self._now + (1 - MEMORY**2) ** 0.5 * self._rng.normal(0.0, 0.6 * self._radius, self._now.shape)
        # what rounding may add to a length is less than three units per axis
        length = np.sqrt((wish * wish).sum(axis=1, keepdims=True))
        room = np.maximum(self._radius * (1 - 1e-9) - 6, 0.0)
        deviations: Floats = 3 * np.rint(wish * np.minimum(1.0, room / np.maximum(length, 1.0)) / 3)
        return deviations
