"""Integer units in which the nominal motion (eq. 4, a triple integrator) is exact: states, samples, terminal rest.

With the step h = T_c and the jerk unit J, let accelerations count in J·h, velocities in J·h²/2 and positions in
e = J·h³/6. One step under the integer jerk u then maps integers to integers:

    p' = p + 3v + 3a + u,    v' = v + 2a + u,    a' = a + u

Scaled positions q = S·p, with the integer matrix S = L·Θ⁻¹, are integers as well. J is a power of two, or nearly one
where starts must not be rounded. It is as small as it can be while every number that occurs stays below 2⁵⁰: float64
then holds all of them exactly, and sums and products with the integers below are exact in whatever order. What rounding
a jerk to J changes, the planner leaves room for (`planning.planner`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import ceil, floor, lcm
from typing import NamedTuple

import numpy as np

from swarmproof.errors import BadInput
from swarmproof.motion.pairs import Floats as Floats
from swarmproof.motion.pairs import Pairs, turned
from swarmproof.scenario.definition import flying_space
from swarmproof.scenario.points import Point
from swarmproof.theorem3.fleet import Fleet
from swarmproof.theorem3.numbers import exact_text
from swarmproof.theorem3.parameters import Parameters
from swarmproof.theorem3.values import NORMS, ClosedBox, Vector

#: Every integer that occurs is smaller than this; float64 would be exact up to 2⁵³.
LARGEST = 2**50
#: The jerk unit is 2⁻ⁿ m/s³ with the largest n in this range for which :data:`LARGEST` is respected.
FINEST, COARSEST = 26, 12
#: Distances are many times as long as the unit of positions.
COARSE = 10**4


class Bounds(NamedTuple):
    """The bounds of (13c) and (13d), or others that say the same of plans: m, m/s, m/s², m/s³, per axis."""

    space: ClosedBox
    v_max: Vector
    a_max: Vector
    j_max: Vector

    @classmethod
    def of(cls, parameters: Parameters) -> Bounds:
        """Return the bounds as they are given.

        Raises:
            BadInput: there is no flying space, or one cannot fly with the parameters.
        """
        return cls(flying_space(parameters), parameters.v_max, parameters.a_max, parameters.j_max)

    def within(self, parameters: Parameters) -> Bounds:
        """Return the bounds that say the same as these and those of `parameters` together; the space stays."""
        return Bounds(
            self.space,
            _smaller(self.v_max, parameters.v_max),
            _smaller(self.a_max, parameters.a_max),
            _smaller(self.j_max, parameters.j_max),
        )


class Norm(NamedTuple):
    """A bound of a Euclidean norm in SI units, and the largest integer that its square in lattice units can be."""

    bound: Fraction
    square: int


@dataclass(frozen=True, eq=False)
class Lattice:
    """The units, and the parameters of the swarm as integers of these units.

    Attributes:
        horizon: H, in periods T.
        jerk_unit: J in m/s³.
        bounds: of plans; in a fleet of several kinds, what contains those of each.
        fleet: the swarm; None where all UAVs have these parameters.
    """

    parameters: Parameters
    horizon: int
    jerk_unit: Fraction
    bounds: Bounds
    fleet: Fleet | None = None

    @classmethod
    def of(
        cls, parameters: Parameters, horizon: int, bounds: Bounds | None = None, fleet: Fleet | None = None
    ) -> Lattice:
        """Return the finest lattice on which trajectories over `horizon` periods are exact in float64.

        Raises:
            BadInput: the parameters' numbers are too large, or of too many digits, for any of the units.
        """
        bounds = Bounds.of(parameters) if bounds is None else bounds
        for n in range(FINEST, COARSEST - 1, -1):
            lattice = cls(parameters, horizon, Fraction(1, 2**n), bounds, fleet)
            if lattice.largest() < LARGEST:
                return lattice
        raise BadInput(
            "the flying space, the bounds or the digits of theta_inverse are too large for exact trajectories: "
            "a shorter horizon, fewer rounds, a smaller space or simpler fractions in theta_inverse would do"
        )

    @classmethod
    def finest(cls, parameters: Parameters, horizon: int, bounds: Bounds, fleet: Fleet | None = None) -> Lattice | None:
        """Return the lattice of the finest unit if trajectories within `bounds` are exact on it."""
        lattice = cls(parameters, horizon, Fraction(1, 2**FINEST), bounds, fleet)
        return lattice if lattice.largest() < LARGEST else None

    def holding(self, points: Sequence[Point]) -> Lattice:
        """Return a lattice like this one on which the UAVs can hover at `points` (m) as exactly as they must.

        It is this one if UAVs that are d̂_min apart, or d_min as crashes count, are so on the nearest lattice points,
        too. Else it has a unit, about as long, of which all coordinates are multiples: then nothing is rounded.

        Raises:
            BadInput: the coordinates have too many digits for that.
        """
        if all(self._keeps(kept, points) for kept in (self.pairs, self.crash)):
            return self
        digits = lcm(*(x.denominator for point in points for x in point))
        parts = ceil(1 / (digits * self.position_unit))
        # with as many digits as LARGEST has, not even half a metre has room
        for count in (parts, max(parts - 1, 1)) if digits < LARGEST else ():
            jerk_unit = 6 / (digits * count * self.parameters.T_c**3)
            lattice = replace(self, jerk_unit=jerk_unit)
            if lattice.largest() < LARGEST:
                return lattice
        if COARSE * self.position_unit > min(self.pairs.distance, self.crash.distance):
            raise BadInput(
                f"T_c={exact_text(self.parameters.T_c)} is too long for distances such as d_hat_min="
                f"{exact_text(self.pairs.distance)}: positions would be rounded to {float(self.position_unit):.1e} m"
            )
        raise BadInput(
            "two UAVs start d_hat_min (or d_min) apart, but not once their starts are rounded to units of "
            f"{float(self.position_unit):.1e} m: write the starts with at most 9 decimals, such as 0.25"
        )

    def hovers(self, points: Sequence[Point]) -> Floats:
        """Return the lattice points within the flying space nearest to `points` (m), shape (n, 3)."""
        return np.clip(self.positions(points), self.low, self.high)

    def _keeps(self, kept: Pairs, points: Sequence[Point]) -> bool:
        """Return whether any two of `points` (m) that are far enough apart are so as hovers, too, exactly."""
        hovers = self.hovers(points)
        one, other = np.triu_indices(len(hovers), 1)
        q = hovers @ kept.first.T
        apart = turned(q[other] - q[one], kept.second(one, other))
        return all(
            sum(int(x) ** 2 for x in difference) >= (needed := (kept.distance / kept.unit_of(i, j)) ** 2)
            or self._square(kept, points, i, j) < needed
            for i, j, difference in zip(one.tolist(), other.tolist(), apart, strict=True)
        )

    def _square(self, kept: Pairs, points: Sequence[Point], i: int, j: int) -> Fraction:
        """Return the squared distance of two of `points` (m), scaled, in units of their |q|²; nothing is rounded."""
        apart = [(b - a) / self.position_unit for a, b in zip(points[i], points[j], strict=True)]
        rows = kept.matrices[(kept.members[i], kept.members[j]) if kept.members else (0, 0)].tolist()
        scaled = [sum((int(s) * x for s, x in zip(row, apart, strict=True)), Fraction(0)) for row in rows]
        return sum((x * x for x in scaled), Fraction(0))

    def largest(self) -> int:
        """Return a bound for every coordinate of a scaled position, whatever jerks within U are tried."""
        steps = self.steps * self.horizon
        rows = max(self.pairs.rows, self.crash.rows)
        largest: int = rows * max(
            (2 * int(position) + 3 * int(velocity) * steps + 3 * int(acceleration) * steps**2 + int(jerk) * steps**3)
            for position, velocity, acceleration, jerk in zip(
                np.maximum(np.abs(self.low), np.abs(self.high)).tolist(),
                self.v_max.tolist(),
                self.a_max.tolist(),
                self.j_max.tolist(),
                strict=True,
            )
        )
        return largest

    @cached_property
    def steps(self) -> int:
        """How many collision samples T_c one period T has: m."""
        return int(self.parameters.T_s / self.parameters.T_c)

    @cached_property
    def position_unit(self) -> Fraction:
        """e in m."""
        return self.jerk_unit * self.parameters.T_c**3 / 6

    @cached_property
    def velocity_unit(self) -> Fraction:
        """The velocity unit in m/s."""
        return self.jerk_unit * self.parameters.T_c**2 / 2

    @cached_property
    def acceleration_unit(self) -> Fraction:
        """The acceleration unit in m/s²."""
        return self.jerk_unit * self.parameters.T_c

    @cached_property
    def kinds(self) -> tuple[Lattice, ...]:
        """The same lattice with the parameters and bounds of each kind of the fleet; itself if all are alike."""
        if self.fleet is None:
            return (self,)
        return tuple(
            replace(self, parameters=given, bounds=self.bounds.within(given)) for given in self.fleet.parameters
        )

    def of_uav(self, i: int) -> Lattice:
        """Return the lattice with the bounds of UAV i."""
        return self.kinds[0 if self.fleet is None else self.fleet.place(i)]

    @cached_property
    def _fleet(self) -> Fleet:
        return Fleet.alike(self.parameters) if self.fleet is None else self.fleet

    @cached_property
    def pairs(self) -> Pairs:
        """What the pairs of UAVs keep at samples: q are positions scaled for these, and d̂_min is their distance."""
        return Pairs.kept(self._fleet, self.position_unit)

    @cached_property
    def crash(self) -> Pairs:
        """What counts as a crash of two UAVs, eq. (2)."""
        return Pairs.crash(self._fleet, self.position_unit)

    def positions(self, points: Sequence[Sequence[Fraction | float]]) -> Floats:
        """Return the lattice points nearest to `points` (m), shape (n, 3)."""
        unit = self.position_unit
        return np.array([[round(Fraction(x) / unit) for x in point] for point in points], float)

    @cached_property
    def low(self) -> Floats:
        """The lowest lattice position within the flying space, per axis."""
        return np.array([ceil(low / self.position_unit) for low, _ in self.bounds.space], float)

    @cached_property
    def high(self) -> Floats:
        """The highest lattice position within the flying space, per axis."""
        return np.array([floor(high / self.position_unit) for _, high in self.bounds.space], float)

    @cached_property
    def v_max(self) -> Floats:
        """The largest velocity per axis."""
        return np.array([floor(bound / self.velocity_unit) for bound in self.bounds.v_max], float)

    @cached_property
    def a_max(self) -> Floats:
        """The largest acceleration per axis."""
        return np.array([floor(bound / self.acceleration_unit) for bound in self.bounds.a_max], float)

    @cached_property
    def j_max(self) -> Floats:
        """The largest jerk per axis."""
        return np.array([floor(bound / self.jerk_unit) for bound in self.bounds.j_max], float)

    @cached_property
    def norms(self) -> dict[str, Norm]:
        """The bounds of norms, by parameter, as far as the bounds per axis do not imply them."""
        units = {"v_norm": self.velocity_unit, "a_norm": self.acceleration_unit, "j_norm": self.jerk_unit}
        return {
            name: Norm(norm, floor((norm / units[name]) ** 2)) for name, norm in binding_norms(self.parameters).items()
        }

    @cached_property
    def from_state(self) -> Floats:
        """Positions at steps 0 … H·m under zero jerk, from (p, v, a): shape (H·m + 1, 3)."""
        step = np.arange(self.horizon * self.steps + 1, dtype=float)
        return np.stack([np.ones_like(step), 3 * step, 3 * step**2], axis=1)

    @cached_property
    def from_jerks(self) -> Floats:
        """How far the jerk of each period moves the positions at steps 0 … H·m: shape (H·m + 1, H)."""
        step = np.arange(self.horizon * self.steps + 1, dtype=float)[:, None]
        begin = self.steps * np.arange(self.horizon, dtype=float)[None, :]
        return _cubed(step - begin) - _cubed(step - begin - self.steps)

    @cached_property
    def velocity_from_jerks(self) -> Floats:
        """The same for velocities at the ends of periods 0 … H: shape (H + 1, H)."""
        since = self._since_begin
        gained: Floats = np.maximum(since, 0) ** 2 - np.maximum(since - self.steps, 0) ** 2
        return gained

    @cached_property
    def acceleration_from_jerks(self) -> Floats:
        """The same for accelerations at the ends of periods 0 … H: shape (H + 1, H)."""
        since = self._since_begin
        return np.maximum(since, 0) - np.maximum(since - self.steps, 0)

    @property
    def _since_begin(self) -> Floats:
        period = np.arange(self.horizon + 1, dtype=float)
        return self.steps * (period[:, None] - period[None, : self.horizon])


def _smaller(one: Vector, other: Vector) -> Vector:
    x, y, z = map(min, one, other)
    return (x, y, z)


def binding_norms(parameters: Parameters) -> dict[str, Fraction]:
    """Return the bounds of norms (SI), by parameter, that the bounds per axis do not imply."""
    norms = {name: (getattr(parameters, name), getattr(parameters, box)) for name, box in NORMS.items()}
    return {
        name: norm for name, (norm, box) in norms.items() if norm is not None and norm**2 < sum(side**2 for side in box)
    }


def _cubed(steps: Floats) -> Floats:
    cubes: Floats = np.maximum(steps, 0) ** 3
    return cubes
