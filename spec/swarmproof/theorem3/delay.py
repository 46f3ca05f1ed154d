"""How far one UAV flies in the time `delay`, in the scaled norm: how much closer two can be than a planner knows.

A planner that knows where a UAV was `delay` ago, p̂(t − delay), keeps d̂_min from there. With A = Θ⁻¹,

    ‖A(p̂_i(t) − p̂_j(t))‖ ≥ ‖A(p̂_i(t) − p̂_j(t − delay))‖ − ‖A(p̂_j(t) − p̂_j(t − delay))‖,

so the corrected (26) has to pay D, the largest last term. docs/theorem-3.md derives what bounds it in each reading, and
how much D and the dip take together (:func:`lost`).
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product

from swarmproof.theorem3.inequality import (
    is_diagonal,
    scaled_square,
    spectral_norm_bounds,
    square_root_bounds,
    stretched_most,
)
from swarmproof.theorem3.parameters import Parameters, Reading
from swarmproof.theorem3.values import Vector

Interval = tuple[Fraction, Fraction]


def displacement(given: Parameters, reading: Reading) -> Interval:
    """Return bounds of the largest ‖Θ⁻¹(p̂(t) − p̂(t − delay))‖ (m, exact); constant velocity attains the lower one."""
    if given.delay == 0:
        return Fraction(0), Fraction(0)
    x, y, z = (_way(given, reading, *bounds) for bounds in zip(given.v_max, given.a_max, given.j_max, strict=True))
    reach = _norm(given, reading)
    return _steady(given), _longest(given, (x, y, z), reach)


def shifts(given: Parameters, reading: Reading) -> bool:
    """Say whether any motion, `delay` later, is one of the reading: only then does a pair of such two dip no deeper."""
    if reading is Reading.WHOLE_MOTION:
        return True
    period = given.T_s if reading is Reading.AS_SAMPLED else given.T_c
    return (given.delay / period).denominator == 1


def lost(given: Parameters, reading: Reading, dip: Fraction, flown: Fraction) -> Interval:
    """Return bounds of how much of d̂_min the dip Δ and the way D `flown` in the delay take together (m, scaled).

    Where motions can be shifted by the delay, that is Δ + D. Otherwise references are d̂_min − D apart at samples, and
    two that start nearer dip deeper: √((d̂_min − Δ)² − D(2d̂_min − D)) is left, or nothing.
    """
    if flown == 0 or shifts(given, reading):
        return dip + flown, dip + flown
    distance = given.d_hat_min
    square = (distance - dip) ** 2 - flown * (2 * distance - flown)
    if flown >= distance or square <= 0:
        return max(distance, dip + flown), max(distance, dip + flown)
    low, high = square_root_bounds(square)
    return distance - high, distance - low


def largest_dip(given: Parameters, reading: Reading, loss: Fraction, flown: Fraction) -> Fraction:
    """Return a dip (m) with which no more than `loss` is lost, the largest but for rounding; negative if none is."""
    if flown == 0 or shifts(given, reading) or loss < flown:
        return loss - flown
    distance = given.d_hat_min
    return distance - square_root_bounds((distance - loss) ** 2 + flown * (2 * distance - flown))[1]


def _way(given: Parameters, reading: Reading, speed: Fraction, acceleration: Fraction, jerk: Fraction) -> Fraction:
    """Return a bound of how far a UAV with these bounds flies in one direction within `delay`, m."""
    order, delay = given.order, given.delay
    if reading is Reading.WHOLE_MOTION:
        return speed * delay
    if reading is Reading.AS_SAMPLED:
        over = acceleration * given.T_b / 4
        if order == 3:
            over = min(over, jerk * given.T_b**2 / 8)
        return (speed + (over if order == 3 else 0)) * delay
    over = jerk * given.T_c**2 / 8 if order == 3 else acceleration * given.T_c / 2
    on = speed * delay + acceleration * delay**2 / 2 + (jerk * delay**3 / 6 if order == 3 else 0)
    return max((speed + over) * delay, on)


def _norm(given: Parameters, reading: Reading) -> Fraction | None:
    """Return a bound of the way in any direction, m; None if the speed has no bound of its norm."""
    if given.v_norm is None:
        return None
    bounds = []
    for norm, box in ((given.a_norm, given.a_max), (given.j_norm, given.j_max)):
        corner = square_root_bounds(sum((bound**2 for bound in box), Fraction(0)))[1]
        bounds.append(corner if norm is None else min(corner, norm))
    return _way(given, reading, given.v_norm, *bounds)


def _longest(given: Parameters, ways: Vector, reach: Fraction | None) -> Fraction:
    """Return the largest ‖Θ⁻¹d‖ with |d_k| ≤ `ways` and ‖d‖ ≤ `reach`, rounded up."""
    matrix = given.theta_inverse
    if is_diagonal(matrix):
        return square_root_bounds(sum((matrix[k][k] ** 2 * s for k, s in _shares(given, ways, reach)), Fraction(0)))[1]
    box = square_root_bounds(max(scaled_square(matrix, corner) for corner in _corners(ways)))[1]
    return box if reach is None else min(box, spectral_norm_bounds(matrix)[1] * reach)


def _shares(given: Parameters, ways: Vector, reach: Fraction | None) -> list[tuple[int, Fraction]]:
    """Return d_k² per axis for the largest ‖Θ⁻¹d‖, Θ⁻¹ diagonal: as much as there is where it counts most."""
    left, shares = None if reach is None else reach**2, []
    for k in sorted(range(3), key=lambda axis: -given.theta_inverse[axis][axis]):
        share = ways[k] ** 2 if left is None else min(ways[k] ** 2, left)
        left = None if left is None else left - share
        shares.append((k, share))
    return shares


def _steady(given: Parameters) -> Fraction:
    """Return the largest ‖Θ⁻¹v‖·delay of some velocities that keep box and norm, rounded down."""
    velocities = list(_corners(given.v_max))
    if is_diagonal(given.theta_inverse):
        best = [Fraction(0)] * 3
        for k, share in _shares(given, given.v_max, given.v_norm):
            best[k] = square_root_bounds(share)[0]
        velocities.append((best[0], best[1], best[2]))
    velocities.append(stretched_most(given.theta_inverse))
    found = max(scaled_square(given.theta_inverse, _kept(given, one)) for one in velocities)
    return square_root_bounds(found)[0] * given.delay


def _kept(given: Parameters, velocity: Vector) -> Vector:
    """Return the velocity, as long as box and norm let it be."""
    factors = [bound / abs(part) for bound, part in zip(given.v_max, velocity, strict=True) if part]
    if given.v_norm is not None:
        length = square_root_bounds(sum((part**2 for part in velocity), Fraction(0)))[1]
        factors += [given.v_norm / length] if length else []
    factor = min(factors, default=Fraction(0))
    x, y, z = (factor * part for part in velocity)
    return (x, y, z)


def _corners(box: Vector) -> list[Vector]:
    """Return the corners of a box, one of each opposite pair."""
    x, y, z = box
    return [(x, y * one, z * other) for one, other in product((1, -1), repeat=2)]
