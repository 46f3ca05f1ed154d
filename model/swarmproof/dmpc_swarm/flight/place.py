"""Where a flight is computed: near the origin, in a region that holds all that it can reach.

Nothing in (13) changes when everything is moved. So a scenario in map coordinates is moved, by whole metres and
exactly, to where numbers are small; what people see is moved back. Nor does anything change if a bound that cannot
bind is replaced by one that cannot bind either: the far walls of a large space, a speed that no plan can reach.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import ceil
from typing import NamedTuple

from swarmproof.errors import BadInput
from swarmproof.motion.lattice import LARGEST, Bounds, Lattice
from swarmproof.scenario.definition import Scenario, flying_space
from swarmproof.theorem3.numbers import exact_text
from swarmproof.theorem3.parameters import Parameters
from swarmproof.theorem3.values import ClosedBox, Vector

#: The origin is a multiple, per axis, of a power of two of metres, at least so many times as long as the space is wide.
SPACIOUS = 4
#: What an effective bound converges to in fewer steps.
MOST_STEPS = 10


class Place(NamedTuple):
    """A scenario where it is computed.

    Attributes:
        scenario: moved.
        origin: m; what is to be added to its coordinates.
        lattice: its units and bounds.
        clipped: whether the space is larger than what the lattice has room for; then the flight must not be longer than
            the scenario's rounds.
    """

    scenario: Scenario
    origin: Vector
    lattice: Lattice
    clipped: bool


def place(scenario: Scenario) -> Place:
    """Return where `scenario` is computed.

    Raises:
        BadInput: its numbers are too large, or have too many digits, for exact trajectories.
    """
    space = flying_space(scenario.parameters)
    bounds = Bounds.of(scenario.parameters)
    region = _reachable(scenario, space, bounds)
    x, y, z = (_origin(sides) for sides in region)
    origin = (x, y, z)
    moved = scenario.moved((-x, -y, -z))
    parameters, horizon = moved.parameters, moved.horizon
    near = _shifted(region, origin)
    fleet = moved.fleet if moved.kinds else None
    members = (parameters,) if fleet is None else fleet.parameters
    plain = Lattice.finest(parameters, horizon, _around([Bounds.of(one) for one in members]), fleet)
    if plain is not None:
        return Place(moved, origin, _for_starts(plain, moved), clipped=False)
    tight = _around([implied(one, horizon) for one in members])
    lattice = Lattice.of(parameters, horizon, tight._replace(space=near), fleet)
    return Place(moved, origin, _for_starts(lattice, moved), clipped=region != space)


def _for_starts(lattice: Lattice, moved: Scenario) -> Lattice:
    """Return a lattice like `lattice` for the starts, on which distances are exact with the tracking errors, too."""
    lattice = lattice.holding(moved.starts)
    most = max(given.tracking_error for given in moved.fleet.parameters)
    # half of `largest` bounds references: it counts positions twice, and speeds over the whole horizon
    room = (LARGEST - lattice.largest() // 2) // lattice.crash.rows * lattice.position_unit
    if most > room:
        raise BadInput(
            f"tracking_error={exact_text(most)} is too large for exact distances in this flight: at most "
            f"{float(room):.3g} m, such as tracking_error=0.02"
        )
    return lattice


def implied(parameters: Parameters, horizon: int) -> Bounds:
    """Return what (13c) to (13e) imply for speeds, accelerations and jerks: no plan exceeds these, in SI units.

    A plan ends at rest after `horizon` periods T. With |j| ≤ J the acceleration is at most J·HT, with |a| ≤ A the speed
    at most A·HT. In a period the acceleration changes by at most 2A, the speed by at most 2V, which is T times the mean
    of the accelerations at its ends: the jerk is at most 2A/T, and the acceleration 4V/T more than at the end of the
    period, hence at most 4HV/T.
    """
    period, duration = parameters.T_s, parameters.T_s * horizon

    def axis(v: Fraction, a: Fraction, j: Fraction) -> Vector:
        for _ in range(MOST_STEPS):
            j = min(j, 2 * a / period)
            a = min(a, j * duration, 4 * horizon * v / period)
            v = min(v, a * duration)
        return (v, a, j)

    # what bounds a norm bounds every axis
    boxes = [
        [box if norm is None else min(box, norm) for box in getattr(parameters, name)]
        for name, norm in (("v_max", parameters.v_norm), ("a_max", parameters.a_norm), ("j_max", parameters.j_norm))
    ]
    by_axis = [axis(*bounds) for bounds in zip(*boxes, strict=True)]
    (vx, ax, jx), (vy, ay, jy), (vz, az, jz) = by_axis
    return Bounds(flying_space(parameters), (vx, vy, vz), (ax, ay, az), (jx, jy, jz))


def _reachable(scenario: Scenario, space: ClosedBox, bounds: Bounds) -> ClosedBox:
    """Return the part of the `space` that a UAV, or its plan, can be in during the scenario's rounds."""
    parameters, horizon = scenario.parameters, scenario.horizon
    tight = _around([implied(one, horizon) for one in scenario.fleet.parameters])
    # between the ends of a period, the speed exceeds its bound by less than the acceleration gives in the period
    time = parameters.T_s * (scenario.rounds + horizon + 1)
    sides = []
    for axis, (low, high) in enumerate(space):
        reach = time * (tight.v_max[axis] + tight.a_max[axis] * parameters.T_s)
        positions = [point[axis] for point in scenario.starts]
        sides.append((max(low, min(positions) - reach), min(high, max(positions) + reach)))
    x, y, z = sides
    return (x, y, z)


def _around(bounds: Sequence[Bounds]) -> Bounds:
    """Return bounds that contain all of these, with the space of the first."""
    v, a, j = (
        [max(axis) for axis in zip(*by_kind, strict=True)]
        for by_kind in zip(*((one.v_max, one.a_max, one.j_max) for one in bounds), strict=True)
    )
    return Bounds(bounds[0].space, (v[0], v[1], v[2]), (a[0], a[1], a[2]), (j[0], j[1], j[2]))


def _origin(sides: tuple[Fraction, Fraction]) -> Fraction:
    """Return the multiple of a power of two nearest to the middle of `sides`: 0 for spaces that are not far from it."""
    low, high = sides
    step = Fraction(2 ** max(ceil(SPACIOUS * (high - low)) - 1, 1).bit_length())
    return step * round((low + high) / 2 / step)


def _shifted(box: ClosedBox, origin: Vector) -> ClosedBox:
    x, y, z = ((low - by, high - by) for (low, high), by in zip(box, origin, strict=True))
    return (x, y, z)
