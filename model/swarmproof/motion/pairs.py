"""Scaled distances of any two UAVs, in integers: the one place that knows whether all pairs are scaled alike.

Two UAVs i and j keep ‖Θ_ij⁻¹(p_j − p_i)‖ ≥ d_ij. With one distance d for the whole swarm, this is
‖S_ij(p_j − p_i)‖ ≥ d for S_ij = Θ_ij⁻¹·d/d_ij: in units in which every pair keeps d. On the lattice, all S_ij are
multiplied by a common factor L that makes them integers.

If all pairs have one S, positions are scaled first and subtracted then, which saves work; else differences are scaled.
Both are exact. So a distance is always `turned(first(p_j) − first(p_i), second)`, whatever the swarm.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import gcd, lcm
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmproof.theorem3.fleet import Fleet
from swarmproof.theorem3.parameters import Matrix, Parameters

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Pairs:
    """What two UAVs keep, or what counts as a crash of theirs.

    Attributes:
        distance: d in m.
        unit: of scaled positions and distances, in m.
        matrices: S of two kinds, integers, shape (K, K, 3, 3).
        members: by UAV, its kind; empty if there is but one.
    """

    distance: Fraction
    unit: Fraction
    matrices: Floats
    members: tuple[int, ...]

    @classmethod
    def kept(cls, fleet: Fleet, position_unit: Fraction) -> Pairs:
        """Return what plans keep: Θ and d̂_min of eq. (15)."""
        return cls._of(fleet, position_unit, fleet.base.d_hat_min, lambda both: (both.theta_inverse, both.d_hat_min))

    @classmethod
    def crash(cls, fleet: Fleet, position_unit: Fraction) -> Pairs:
        """Return what counts as a crash: Θ, or the one of crashes, and d_min of eq. (2)."""
        return cls._of(
            fleet,
            position_unit,
            fleet.base.d_min,
            lambda both: (both.crash_theta_inverse or both.theta_inverse, both.d_min),
        )

    @classmethod
    def _of(
        cls,
        fleet: Fleet,
        position_unit: Fraction,
        distance: Fraction,
        of_pair: Callable[[Parameters], tuple[Matrix, Fraction]],
    ) -> Pairs:
        kinds = range(len(fleet.parameters))
        given = [[of_pair(fleet.pair(a, b)) for b in kinds] for a in kinds]
        entries = [
            entry * distance / kept for row in given for matrix, kept in row for line in matrix for entry in line
        ]
        factor = Fraction(lcm(*(entry.denominator for entry in entries)))
        if len(kinds) > 1:
            factor /= gcd(*(int(entry * factor) for entry in entries))
        whole = np.array([int(entry * factor) for entry in entries], float)
        return cls(distance, position_unit / factor, whole.reshape(len(kinds), len(kinds), 3, 3), fleet.members)

    @cached_property
    def alike(self) -> bool:
        """Whether all pairs have the same S."""
        return bool((self.matrices == self.matrices[0, 0]).all())

    @cached_property
    def first(self) -> Floats:
        """What positions are multiplied with, shape (3, 3): S if all pairs have the same, else nothing changes."""
        return self.matrices[0, 0] if self.alike else np.eye(3)

    def second(self, one: Any, other: Any) -> Floats | None:
        """Return what differences between UAVs `one` and `other` (indices, arrays of one shape) are multiplied with.

        Its shape is that of the indices and (3, 3); None where positions are scaled already.
        """
        if self.alike:
            return None
        members = np.array(self.members)
        matrices: Floats = self.matrices[members[one], members[other]]
        return matrices

    def among(self, uavs: int) -> Floats | None:
        """Return the same for all pairs i < j of the first `uavs` UAVs, in the order of their indices."""
        return self.second(*np.triu_indices(uavs, 1))

    @cached_property
    def rows(self) -> int:
        """The largest sum of absolute values in a row of any S: scaled numbers are at most so many times larger."""
        return int(np.abs(self.matrices).sum(axis=-1).max())

    def square(self, distance: Fraction) -> Fraction:
        """Return the square of a scaled distance (m) in units of |q|²."""
        return (distance / self.unit) ** 2


def turned(apart: Floats, second: Floats | None) -> Floats:
    """Return differences, shape (…, 3), multiplied with `second`, shape (…, 3, 3), if it is given: exactly."""
    if second is None:
        return apart
    result: Floats = np.matmul(second, apart[..., None])[..., 0]
    return result
