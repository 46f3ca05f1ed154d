"""Scaled distances of any two UAVs, in integers: the one place that knows whether all pairs are scaled alike.

Two UAVs i and j keep ‖Θ_ij⁻¹(p_j − p_i)‖ ≥ d_ij. With one distance d for the whole swarm, this is
‖Θ_ij⁻¹(p_j − p_i)‖·d/d_ij ≥ d: in units in which every pair keeps d. On the lattice, S_ij = L_ij·Θ_ij⁻¹ is a matrix of
integers, so q = S_ij(p_j − p_i) is exact, and the unit of |q| is e/L_ij·d/d_ij (e: that of positions).

If all pairs have one S and one unit, positions are scaled first and subtracted then, which saves work; else differences
are scaled. So the vector of a distance is always `turned(first(p_j) − first(p_i), second)`, whatever the swarm. Where
squares of different pairs are compared, they count in those of the smallest unit (:class:`Scales`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import lcm
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmproof.errors import BadInput
from swarmproof.theorem3.fleet import Fleet
from swarmproof.theorem3.parameters import Parameters
from swarmproof.theorem3.values import Matrix

Floats = NDArray[np.float64]


class Scales(NamedTuple):
    """How the differences between UAVs are scaled, for a list of pairs.

    Attributes:
        matrices: S of each, integers, shape (pairs, 3, 3).
        weights: what a square of each is worth in squares of :attr:`Pairs.unit`, at least 1.
    """

    matrices: Floats
    weights: tuple[Fraction, ...]

    def only(self, pair: int) -> Scales:
        """Return the same for one pair."""
        return Scales(self.matrices[pair : pair + 1], self.weights[pair : pair + 1])


@dataclass(frozen=True, eq=False)
class Pairs:
    """What two UAVs keep, or what counts as a crash of theirs.

    Attributes:
        distance: d in m.
        units: of the scaled distance of two kinds, in m, K rows.
        matrices: S of two kinds, integers, shape (K, K, 3, 3).
        members: by UAV, its kind; empty if there is but one.
    """

    distance: Fraction
    units: tuple[tuple[Fraction, ...], ...]
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
        units = [[Fraction(0) for _ in kinds] for _ in kinds]
        matrices = np.empty((len(kinds), len(kinds), 3, 3))
        for a, b in product(kinds, kinds):
            matrix, kept = of_pair(fleet.pair(a, b))
            factor = lcm(*(entry.denominator for row in matrix for entry in row))
            whole = [[int(entry * factor) for entry in row] for row in matrix]
            if max(abs(entry) for row in whole for entry in row) >= 2**53:
                raise BadInput(
                    "the entries of theta_inverse, or of crash_theta_inverse, have too many digits for exact "
                    "distances: simpler fractions would do, such as 1/6"
                )
            matrices[a, b] = whole
            units[a][b] = position_unit / factor * distance / kept
        return cls(distance, tuple(map(tuple, units)), matrices, fleet.members)

    @cached_property
    def alike(self) -> bool:
        """Whether all pairs have the same S and unit."""
        return len({unit for row in self.units for unit in row}) == 1 and bool(
            (self.matrices == self.matrices[0, 0]).all()
        )

    @cached_property
    def unit(self) -> Fraction:
        """The smallest unit, in m: that of all pairs if they are alike."""
        return min(unit for row in self.units for unit in row)

    def unit_of(self, i: int, j: int) -> Fraction:
        """Return the unit of the scaled distance of UAVs i and j, in m."""
        return self.units[self.members[i]][self.members[j]] if self.members else self.unit

    @cached_property
    def first(self) -> Floats:
        """What positions are multiplied with, shape (3, 3): S if all pairs are alike, else nothing changes."""
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

    def weights(self, one: Any, other: Any) -> Floats | None:
        """Return what squares of these are worth in squares of :attr:`unit`, rounded; None if they are those."""
        if self.alike:
            return None
        members = np.array(self.members)
        table = np.array([[float((unit / self.unit) ** 2) for unit in row] for row in self.units])
        weights: Floats = table[members[one], members[other]]
        return weights

    def in_metres(self, one: Any, other: Any) -> Floats | None:
        """Return :meth:`second` times the units of distances, rounded; None where positions are scaled already."""
        matrices = self.second(one, other)
        if matrices is None:
            return None
        members, table = np.array(self.members), np.array([[float(unit) for unit in row] for row in self.units])
        scaled: Floats = matrices * table[members[one], members[other]][..., None, None]
        return scaled

    def among(self, uavs: int) -> Scales | None:
        """Return how all pairs i < j of `uavs` UAVs are scaled, in the order of their indices; None if alike."""
        one, other = np.triu_indices(uavs, 1)
        matrices = self.second(one, other)
        if matrices is None:
            return None
        weights = tuple((self.unit_of(int(i), int(j)) / self.unit) ** 2 for i, j in zip(one, other, strict=True))
        return Scales(matrices, weights)

    @cached_property
    def stretch(self) -> float:
        """By how much a length (in units of positions) can grow in the scaled distance, times :attr:`unit`: rounded."""
        lengths = np.linalg.norm(self.matrices, 2, axis=(-2, -1))
        units = np.array([[float(unit) for unit in row] for row in self.units])
        return float((lengths * units).max())

    @cached_property
    def rows(self) -> int:
        """The largest sum of absolute values in a row of any S: scaled numbers are at most so many times larger."""
        return int(np.abs(self.matrices).sum(axis=-1).max())

    def square(self, distance: Fraction) -> Fraction:
        """Return the square of a scaled distance (m) in squares of :attr:`unit`."""
        return (distance / self.unit) ** 2


def turned(apart: Floats, second: Floats | None) -> Floats:
    """Return differences, shape (…, 3), multiplied with `second`, shape (…, 3, 3), if it is given: integers exactly."""
    if second is None:
        return apart
    result: Floats = np.matmul(second, apart[..., None])[..., 0]
    return result
