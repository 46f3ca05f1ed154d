"""Problem (24) as it is solved: one relative motion with doubled bounds, in one of three readings (docs/margin.md)."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import floor, isqrt

import numpy as np
import numpy.typing as npt

from swarmproof.theorem3.parameters import Parameters, Reading
from swarmproof.theorem3.values import NORMS, Vector

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class AxisBounds:
    """Bounds of the relative motion on one axis: `derivatives[m]` bounds the m-th derivative of w, `input` the input.

    SI units; twice the bounds of one UAV. A workspace bounds positions, too: witnesses keep to it, proofs do without.
    The axis may also be any unit vector: :attr:`Problem.ball`.
    """

    derivatives: tuple[tuple[int, Fraction], ...]
    input: Fraction

    def bound(self, derivative: int) -> float:
        """Return the bound of that derivative; raise KeyError where there is none."""
        return float(dict(self.derivatives)[derivative])


@dataclass(frozen=True)
class Problem:
    """What (24) asks, for one reading.

    Raises:
        BadInput: where the reading does not fit the parameters (`as-sampled`: T_s no multiple of T_c or T_b).
    """

    parameters: Parameters
    reading: Reading

    def __post_init__(self) -> None:
        self.parameters.check_reading(self.reading)

    @property
    def order(self) -> int:
        """Return 3 for the triple, 2 for the double integrator."""
        return self.parameters.order

    @cached_property
    def axes(self) -> tuple[AxisBounds, ...]:
        """Return the bounds per axis: twice the smaller one of box and norm."""
        boxes, norms = self._limits
        result = []
        for k in range(3):
            *lower, top = (
                2 * (box[k] if norm is None else min(box[k], norm)) for box, norm in zip(boxes, norms, strict=True)
            )
            result.append(AxisBounds(tuple(enumerate(lower, 1)), top))
        return tuple(result)

    @property
    def _limits(self) -> tuple[list[Vector], list[Fraction | None]]:
        """Return the boxes and norm bounds of one UAV by derivative, the input last."""
        given, names = self.parameters, list(NORMS.items())[: self.parameters.order]
        return [getattr(given, box) for _, box in names], [getattr(given, norm) for norm, _ in names]

    @cached_property
    def norms(self) -> tuple[Fraction | None, ...]:
        """Return twice the norm bounds by derivative, from the first one on, the input last; None for no bound."""
        return tuple(None if norm is None else 2 * norm for norm in self._limits[1])

    @property
    def coupled(self) -> bool:
        """Say whether a bound of a norm couples the axes."""
        return any(norm is not None for norm in self.norms)

    @cached_property
    def ball(self) -> AxisBounds:
        """Return the bounds of e·w for every unit vector e (docs/margin.md, "Bounds of the norm")."""
        bounds = []
        for box, norm in zip(self._limits[0], self.norms, strict=True):
            corner = _root_above(sum((4 * bound**2 for bound in box), Fraction(0)))
            bounds.append(corner if norm is None else min(corner, norm))
        *lower, top = bounds
        return AxisBounds(tuple(enumerate(lower, 1)), top)

    @cached_property
    def window_length(self) -> float:
        """Return T_c in s."""
        return float(self.parameters.T_c)

    @cached_property
    def period(self) -> float:
        """Return the time over which a motion is described: T_s for `as-sampled`, else T_c."""
        return float(self.parameters.T_s if self.reading is Reading.AS_SAMPLED else self.parameters.T_c)

    @cached_property
    def windows(self) -> tuple[int, ...]:
        """Return the windows to look at: one of each pair that time reversal maps to each other."""
        if self.reading is not Reading.AS_SAMPLED:
            return (0,)
        count = int(self.parameters.T_s / self.parameters.T_c)
        return tuple(range((count + 1) // 2))

    def start_of(self, window: int) -> float:
        """Return when the window begins, in s after the start of the motion."""
        return float(window * self.parameters.T_c)

    @cached_property
    def scaling(self) -> Floats:
        """Return A = Θ⁻¹, 3 × 3."""
        return np.array([[float(entry) for entry in row] for row in self.parameters.theta_inverse])

    @cached_property
    def diagonal(self) -> bool:
        """Say whether Θ⁻¹ is diagonal, so that each axis may be mirrored by itself."""
        return all(self.parameters.theta_inverse[i][j] == 0 for i in range(3) for j in range(3) if i != j)

    @cached_property
    def distance(self) -> float:
        """Return d̂_min in m (scaled)."""
        return float(self.parameters.d_hat_min)

    def bending(self, bounds: AxisBounds) -> float:
        """Return a bound of |w''| over the whole motion, m/s² (docs/margin.md, "Times between")."""
        if self.order == 2:
            return float(bounds.input)
        if self.reading is Reading.INITIAL_STATE:
            return bounds.bound(2) + self.window_length * float(bounds.input)
        return bounds.bound(2)


def _root_above(square: Fraction) -> Fraction:
    """Return the root of a square, rounded up to a multiple of 10⁻⁹."""
    root = Fraction(isqrt(floor(square * 10**18)), 10**9)
    return root if root**2 == square else root + Fraction(1, 10**9)
