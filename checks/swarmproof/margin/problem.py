"""Problem (24) as it is solved: one relative motion with doubled bounds, in one of three readings (docs/margin.md)."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
import numpy.typing as npt

from swarmproof.theorem3.parameters import Parameters, Reading

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class AxisBounds:
    """Bounds of the relative motion on one axis: `derivatives[m]` bounds the m-th derivative of w, `input` the input.

    SI units; twice the bounds of one UAV. A workspace bounds positions, too: witnesses keep to it, proofs do without.
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
        """Return the bounds per axis."""
        given = self.parameters
        result = []
        for k in range(3):
            bounds = {1: 2 * given.v_max[k]}
            if given.order == 3:
                bounds[2] = 2 * given.a_max[k]
            top = given.j_max[k] if given.order == 3 else given.a_max[k]
            result.append(AxisBounds(tuple(sorted(bounds.items())), 2 * top))
        return tuple(result)

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

    def bending(self, axis: int) -> float:
        """Return a bound of |w''| on `axis` over the whole motion, m/s² (docs/margin.md, "Times between")."""
        bounds = self.axes[axis]
        if self.order == 2:
            return float(bounds.input)
        if self.reading is Reading.INITIAL_STATE:
            return bounds.bound(2) + self.window_length * float(bounds.input)
        return bounds.bound(2)
