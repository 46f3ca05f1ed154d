"""Inequality (26) of Theorem 3 (DMPC-Swarm), as printed and corrected, decided in exact arithmetic.

Printed (with Δd_min,cont for the misprint d̂_min,cont): d̂_min ≥ d_min + Δd_min + Δd_min,cont. This counts one UAV's
tracking error where two differ from their references, and counts it in metres where eq. (2) measures the scaled
distance. With A = Θ⁻¹, references p̂ and real positions p = p̂ + e, ‖e‖ ≤ Δd_min (Assumption 1, eq. 6), it takes

    ‖A(p_i − p_j)‖ ≥ ‖A(p̂_i − p̂_j)‖ − ‖A(e_i − e_j)‖ ≥ d̂_min − Δd_min,cont − 2‖A‖Δd_min

for eq. (2), hence the corrected inequality: d̂_min ≥ d_min + 2‖A‖Δd_min + Δd_min,cont.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from itertools import combinations
from math import ceil, floor, isqrt

from swarmproof.theorem3.parameters import Parameters
from swarmproof.theorem3.values import Matrix, Vector, closed, diagonal

#: Digits to which irrational norms are enclosed.
DIGITS = 12
#: Squarings of Θ⁻¹ on the way to the direction that it stretches most; the 256th power leaves hardly any other.
SQUARINGS = 8

Pair = tuple[Vector, Vector]


class Truth(StrEnum):
    """What is known of an inequality between quantities of which only bounds are known."""

    HOLDS = "holds"
    FAILS = "fails"
    UNDECIDED = "undecided"


@dataclass(frozen=True, slots=True)
class Counterexample:
    """Two references that keep eq. (24)'s premises and real positions, allowed by eq. (6), that break eq. (2).

    If the printed inequality (26) holds for the parameters, it does not imply eq. (2). All values are exact.
    """

    #: p̂_i and p̂_j, m.
    references: Pair
    #: p_i and p_j, m; each is at most `tracking_error` from its reference, which is not scaled here.
    positions: Pair
    #: ‖Θ⁻¹(p̂_i − p̂_j)‖², m².
    squared_reference_distance: Fraction
    #: ‖Θ⁻¹(p_i − p_j)‖² or, if a crash has an ellipsoid of its own, measured with that, m²; smaller than d_min².
    squared_distance: Fraction
    #: The distance of eq. (2) that is not kept, m.
    d_min: Fraction
    #: Δd_min of eq. (6), m.
    tracking_error: Fraction


def printed(parameters: Parameters, dip_lower: Fraction, dip_upper: Fraction) -> Truth:
    """Return whether (26) holds as printed, if Δd_min,cont (m) lies in [dip_lower, dip_upper]."""
    room = parameters.d_hat_min - parameters.d_min - parameters.tracking_error
    return _truth(room >= dip_upper, room < dip_lower)


def corrected(
    parameters: Parameters, loss_lower: Fraction, loss_upper: Fraction, references: Pair | None = None
) -> Truth:
    """Return whether the corrected (26) holds, if Δd_min,cont (m) lies in [loss_lower, loss_upper].

    With a delay, what one UAV flies in that time belongs to it, too. Only that it holds says something about the UAVs:
    eq. (2). That it fails is no collision. If a crash has an ellipsoid of its own, it fails only where a pair that
    breaks eq. (2) is known: one that hovers, or `references` (m) at their closest approach.
    """
    norm_low, norm_high = spectral_norm_bounds(crash_scaling(parameters))
    errors = 2 * parameters.tracking_error
    if parameters.crash_theta_inverse is not None:
        shrunk = shrinking_bounds(parameters)[0] * (parameters.d_hat_min - loss_upper)
        holds = shrunk - norm_high * errors >= parameters.d_min
        return _truth(holds, not holds and counterexample(parameters, references) is not None)
    room = parameters.d_hat_min - parameters.d_min
    return _truth(room >= norm_high * errors + loss_upper, room < norm_low * errors + loss_lower)


def guaranteed_separation(parameters: Parameters, loss_upper: Fraction) -> Fraction:
    """Return the distance of eq. (2) (m) that the real UAVs keep at all times if Δd_min,cont is at most `loss_upper`.

    With a delay, what one UAV flies in that time belongs to it, too.
    """
    _, norm_high = spectral_norm_bounds(crash_scaling(parameters))
    kept = shrinking_bounds(parameters)[0] * (parameters.d_hat_min - loss_upper)
    return max(Fraction(0), kept - 2 * norm_high * parameters.tracking_error)


def largest_loss(parameters: Parameters) -> Fraction:
    """Return the largest Δd_min,cont (m), with what is flown in the delay, for which the corrected (26) holds."""
    _, norm_high = spectral_norm_bounds(crash_scaling(parameters))
    needed = parameters.d_min + 2 * norm_high * parameters.tracking_error
    return parameters.d_hat_min - needed / shrinking_bounds(parameters)[0]


def crash_scaling(parameters: Parameters) -> Matrix:
    """Return what eq. (2) measures distances with: that of a crash if there is one, else Θ⁻¹."""
    return parameters.crash_theta_inverse or parameters.theta_inverse


def shrinking_bounds(parameters: Parameters, digits: int = DIGITS) -> tuple[Fraction, Fraction]:
    """Return (low, high) around the least ‖Cx‖/‖Ax‖: a crash's C = :func:`crash_scaling` against A = Θ⁻¹.

    Exact if both are diagonal, or equal; else high − low ≤ 10^−digits · high. Each rests on an exact test: s is no
    larger than that if and only if CᵀC − s²AᵀA is positive semidefinite.
    """
    crash, planned = crash_scaling(parameters), parameters.theta_inverse
    if crash == planned:
        return Fraction(1), Fraction(1)
    if is_diagonal(crash) and is_diagonal(planned):
        least = min(crash[k][k] / planned[k][k] for k in range(3))
        return least, least
    of_crash, of_planned = _gram(crash), _gram(planned)
    largest = min(square_root_bounds(of_crash[k][k] / of_planned[k][k])[1] for k in range(3))
    low, high = Fraction(0), largest
    while high - low > high / 10**digits:
        middle = (low + high) / 2
        low, high = (middle, high) if _semidefinite(_difference(of_crash, middle**2, of_planned)) else (low, middle)
    return low, high


def counterexample(parameters: Parameters, references: Pair | None = None) -> Counterexample | None:
    """Return tracking errors that bring two UAVs closer than d_min, or None if none were found.

    Tried are two references that hover d̂_min apart, then `references`: the positions (m) at their closest approach of
    two references that keep the premises of eq. (24). Whether (26) holds as printed is left to :func:`printed`.
    """
    shrunk = None if parameters.crash_theta_inverse is None else hovering_pair(parameters, _shrunk_most(parameters))
    for pair in (hovering_pair(parameters), shrunk, references):
        found = pair and _pushed_together(parameters, pair)
        if found:
            return found
    return None


def hovering_pair(parameters: Parameters, direction: Vector | None = None) -> Pair | None:
    """Return two positions (m) at the scaled distance d̂_min, along `direction` or that which Θ⁻¹ stretches most.

    Hovering there is a motion of every reading. For a diagonal Θ the distance is exact; otherwise it may be larger by
    a relative 1e-12. None if the workspace has no room for the pair.
    """
    direction = stretched_most(parameters.theta_inverse) if direction is None else direction
    stretched, _ = square_root_bounds(scaled_square(parameters.theta_inverse, direction))
    offset = _scaled(direction, parameters.d_hat_min / stretched / 2)
    centre = (Fraction(0), Fraction(0), Fraction(0))
    if parameters.workspace is not None:
        space = closed(parameters.workspace)
        (x_low, x_high), (y_low, y_high), (z_low, z_high) = space
        centre = ((x_low + x_high) / 2, (y_low + y_high) / 2, (z_low + z_high) / 2)
        if any(high - low < 2 * abs(part) for (low, high), part in zip(space, offset, strict=True)):
            return None
    return _sum(centre, offset), _sum(centre, _scaled(offset, Fraction(-1)))


def crossing_pair(parameters: Parameters) -> Pair | None:
    """Return where two references are closest (m) that pass each other at constant velocity between two samples.

    At both samples they are d̂_min apart (scaled) or a little more; they fly at full speed on the two axes that Θ⁻¹
    stretches most. This is a motion of every reading. None unless Θ is diagonal and there is no workspace, or if they
    would pass through each other.
    """
    matrix = parameters.theta_inverse
    if not is_diagonal(matrix) or parameters.workspace is not None:
        return None
    one, other = sorted(range(3), key=lambda axis: -matrix[axis][axis])[:2]
    scales = matrix[one][one], matrix[other][other]
    speeds = [parameters.v_max[axis] for axis in (one, other)]
    if parameters.v_norm is not None and parameters.v_norm**2 < speeds[0] ** 2 + speeds[1] ** 2:
        share = parameters.v_norm / square_root_bounds(speeds[0] ** 2 + speeds[1] ** 2)[1]
        speeds = [share * speed for speed in speeds]
    way = [2 * speed * parameters.T_c * scale for speed, scale in zip(speeds, scales, strict=True)]
    length = way[0] ** 2 + way[1] ** 2
    rest = parameters.d_hat_min**2 - length / 4
    if rest <= 0 or length == 0:
        return None
    # across the way, at the distance that makes both ends d̂_min long, rounded up
    stretch = square_root_bounds(rest / length)[1]
    offset = [Fraction(0)] * 3
    offset[one], offset[other] = -stretch * way[1] / scales[0] / 2, stretch * way[0] / scales[1] / 2
    x, y, z = offset
    return (x, y, z), (-x, -y, -z)


def scaled_square(theta_inverse: Matrix, vector: Vector) -> Fraction:
    """Return ‖Θ⁻¹ vector‖² exactly: the square of eq. (2)'s distance, for the difference of two positions."""
    return _square(_times(theta_inverse, vector))


def spectral_norm_bounds(matrix: Matrix, digits: int = DIGITS) -> tuple[Fraction, Fraction]:
    """Return (low, high) with low ≤ ‖matrix‖₂ ≤ high and high − low ≤ 10^−digits · ‖matrix‖₂.

    Both are the norm itself if the matrix is diagonal, or the norm has few enough digits. Each bound rests on an exact
    test: s ≥ ‖A‖₂ if and only if s²I − AᵀA is positive semidefinite.
    """
    largest = max(abs(entry) for row in matrix for entry in row)
    if is_diagonal(matrix):
        return largest, largest
    gram = _gram(matrix)
    # the norm lies between the largest entry and three times it (the Frobenius norm of such entries)
    unit = _power_of_ten_below(largest) / 10**digits
    low, high = floor(largest / unit) - 1, ceil(3 * largest / unit)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if _semidefinite(_gap(middle * unit, gram)) else (middle, high)
    if _determinant(_gap(high * unit, gram)) == 0:
        return high * unit, high * unit
    return low * unit, high * unit


def square_root_bounds(value: Fraction, digits: int = DIGITS) -> tuple[Fraction, Fraction]:
    """Return (low, high) with low ≤ √value ≤ high and high − low ≤ 10^−digits · √value, both exact for a square.

    Raises:
        ValueError: `value` is negative.
    """
    root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
    if root**2 == value:
        return root, root
    at_most_the_root = Fraction(isqrt(value.numerator), isqrt(value.denominator) + 1)
    unit = _power_of_ten_below(at_most_the_root) / 10**digits
    steps = isqrt(floor(value / unit**2))
    return steps * unit, (steps + 1) * unit


def _truth(holds: bool, fails: bool) -> Truth:
    if holds:
        return Truth.HOLDS
    return Truth.FAILS if fails else Truth.UNDECIDED


def _pushed_together(parameters: Parameters, references: Pair) -> Counterexample | None:
    """Return the references with tracking errors towards each other, or None if that keeps them d_min apart.

    Errors along the relative position w, or along Θ⁻²w, where the scaled distance falls fastest.
    """
    relative = _sum(references[0], _scaled(references[1], Fraction(-1)))
    steepest = _times(_gram(crash_scaling(parameters)), relative)
    pushed = [_pushed_along(parameters, references, direction) for direction in (relative, steepest)]
    found = min(pushed, key=lambda pair: pair.squared_distance)
    return found if found.squared_distance < found.d_min**2 else None


def _pushed_along(parameters: Parameters, references: Pair, direction: Vector) -> Counterexample:
    """Return the references with errors of the same size, opposite to each other, along `direction`."""
    scaling, error = crash_scaling(parameters), parameters.tracking_error
    relative = _sum(references[0], _scaled(references[1], Fraction(-1)))
    scaled, along = _times(scaling, relative), _times(scaling, direction)
    _, length = square_root_bounds(_square(direction))
    # errors that go on beyond the closest point would part the UAVs again
    share = min(error / length, _dot(scaled, along) / _square(along) / 2) if length else Fraction(0)
    first, second = references
    positions = (_sum(first, _scaled(direction, -share)), _sum(second, _scaled(direction, share)))
    left = _sum(positions[0], _scaled(positions[1], Fraction(-1)))
    return Counterexample(
        references=references,
        positions=positions,
        squared_reference_distance=scaled_square(parameters.theta_inverse, relative),
        squared_distance=scaled_square(scaling, left),
        d_min=parameters.d_min,
        tracking_error=error,
    )


def stretched_most(matrix: Matrix) -> Vector:
    """Return a direction, of any length, that a positive definite matrix stretches as much as any, or nearly so."""
    if is_diagonal(matrix):
        largest = max(range(3), key=lambda axis: matrix[axis][axis])
        return diagonal((Fraction(1), Fraction(1), Fraction(1)))[largest]
    # rounding does no harm: whatever direction comes out, all that is built on it is exact
    power = [[float(entry) for entry in row] for row in matrix]
    for _ in range(SQUARINGS):
        trace = sum(power[axis][axis] for axis in range(3))
        power = [[sum(a * b for a, b in zip(row, other, strict=True)) / trace**2 for other in power] for row in power]
    column = max(power, key=lambda row: sum(entry**2 for entry in row))
    longest = max(abs(entry) for entry in column)
    x, y, z = (Fraction(round(entry / longest * 10**DIGITS), 10**DIGITS) for entry in column)
    return (x, y, z)


def _shrunk_most(parameters: Parameters) -> Vector:
    """Return a direction, of any length, in which ‖Cx‖/‖Ax‖ is about least; all built on it is exact."""
    crash, planned = crash_scaling(parameters), parameters.theta_inverse
    if is_diagonal(crash) and is_diagonal(planned):
        least = min(range(3), key=lambda k: crash[k][k] / planned[k][k])
        return diagonal((Fraction(1), Fraction(1), Fraction(1)))[least]
    gap = _difference(_gram(crash), shrinking_bounds(parameters)[0] ** 2, _gram(planned))
    # the gap is singular, nearly: its adjugate has the direction in every row that is not 0
    rows = [_cross(gap[(k + 1) % 3], gap[(k + 2) % 3]) for k in range(3)]
    x, y, z = max(rows, key=_square)
    longest = max(abs(x), abs(y), abs(z)) or Fraction(1)
    x, y, z = (Fraction(round(part / longest * 10**DIGITS), 10**DIGITS) for part in (x, y, z))
    return (x, y, z) if any((x, y, z)) else (Fraction(1), Fraction(0), Fraction(0))


def _cross(one: Vector, other: Vector) -> Vector:
    (a, b, c), (x, y, z) = one, other
    return (b * z - c * y, c * x - a * z, a * y - b * x)


def _difference(one: Matrix, factor: Fraction, other: Matrix) -> Matrix:
    """Return one − factor·other."""
    first, second, third = (_sum(row, _scaled(less, -factor)) for row, less in zip(one, other, strict=True))
    return (first, second, third)


def _power_of_ten_below(value: Fraction) -> Fraction:
    """Return the largest power of ten that is at most `value`, which is positive."""
    power = Fraction(1)
    while power > value:
        power /= 10
    while 10 * power <= value:
        power *= 10
    return power


def _gram(matrix: Matrix) -> Matrix:
    """Return matrixᵀ matrix."""
    first, second, third = zip(*matrix, strict=True)
    one, two, three = ((_dot(row, first), _dot(row, second), _dot(row, third)) for row in (first, second, third))
    return (one, two, three)


def _gap(scale: Fraction, gram: Matrix) -> Matrix:
    """Return scale² I − gram."""
    (a, b, c), (d, e, f), (g, h, i) = gram
    square = scale**2
    return ((square - a, -b, -c), (-d, square - e, -f), (-g, -h, square - i))


def _semidefinite(symmetric: Matrix) -> bool:
    """Return whether all principal minors are nonnegative, which is to say: positive semidefinite."""
    return (
        all(symmetric[axis][axis] >= 0 for axis in range(3))
        and all(symmetric[i][i] * symmetric[j][j] >= symmetric[i][j] ** 2 for i, j in combinations(range(3), 2))
        and _determinant(symmetric) >= 0
    )


def _determinant(matrix: Matrix) -> Fraction:
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def is_diagonal(matrix: Matrix) -> bool:
    """Return whether all entries off the diagonal are 0."""
    return matrix == diagonal((matrix[0][0], matrix[1][1], matrix[2][2]))


def _times(matrix: Matrix, vector: Vector) -> Vector:
    x, y, z = (_dot(row, vector) for row in matrix)
    return (x, y, z)


def _dot(one: Vector, other: Vector) -> Fraction:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _square(vector: Vector) -> Fraction:
    return _dot(vector, vector)


def _sum(one: Vector, other: Vector) -> Vector:
    return (one[0] + other[0], one[1] + other[1], one[2] + other[2])


def _scaled(vector: Vector, factor: Fraction) -> Vector:
    return (vector[0] * factor, vector[1] * factor, vector[2] * factor)
