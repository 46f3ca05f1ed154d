"""Points of a scenario, as exactly as they were written, and their scaled distances, decided exactly."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import chain, combinations
from math import ceil, dist, floor, lcm
from random import Random

from swarmproof.errors import BadInput
from swarmproof.theorem3.numbers import exact_text
from swarmproof.theorem3.values import Box, ClosedBox, Matrix, Vector

#: x, y, z in m.
Point = tuple[Fraction, Fraction, Fraction]
Integers = tuple[int, int, int]

#: m; random points keep this distance from the walls of the flying space, per axis.
ROOM = Fraction(1, 10)
#: Random coordinates are whole multiples of 1/2²⁰ m, about a micrometre.
PER_METRE = 2**20
#: How many random points are tried for one set of points.
MOST_TRIES = 20_000


def scaling(theta_inverse: Matrix) -> tuple[tuple[Integers, ...], int]:
    """Return S = L·Θ⁻¹, a matrix of integers, and L, the least number that makes it one."""
    factor = lcm(*(entry.denominator for row in theta_inverse for entry in row))
    return tuple((int(a * factor), int(b * factor), int(c * factor)) for a, b, c in theta_inverse), factor


def closest_pair(points: Sequence[Point], theta_inverse: Matrix) -> tuple[Fraction, int, int]:
    """Return the smallest scaled squared distance ‖Θ⁻¹(p_j − p_i)‖² (m², exact; eq. 2) and the i < j that have it.

    `points` are two or more.
    """
    matrix, factor = scaling(theta_inverse)
    unit = lcm(*(x.denominator for point in points for x in point))
    scaled = [_product(matrix, [x.numerator * (unit // x.denominator) for x in point]) for point in points]
    # floats (m) say which pairs may be the closest: of a coordinate they know all but one part in 2⁵³, or almost 0
    rounded = [(x / unit, y / unit, z / unit) for x, y, z in scaled]
    doubt = 2.0**-48 * max(map(abs, chain.from_iterable(rounded))) + 2.0**-1000
    distances = [(dist(rounded[i], rounded[j]), i, j) for i, j in combinations(range(len(points)), 2)]
    nearest = min(distances)[0] * (1 + 2.0**-40) + doubt
    square, i, j = min((_square(scaled[i], scaled[j]), i, j) for apart, i, j in distances if apart <= nearest)
    return Fraction(square, (unit * factor) ** 2), i, j


def draw(
    space: ClosedBox, theta_inverse: Matrix, uavs: int, separation: Fraction, seed: int, label: str
) -> tuple[Point, ...]:
    """Return `uavs` random points in the flying space `space`, pairwise `separation` (m, scaled) or more apart.

    The coordinates are uniform over the space less :data:`ROOM` on every side; a point that is too close to one
    before it is drawn again. The same arguments give the same points on every machine and in every version of Python:
    all comes from ``random.Random(f"{seed} {label}").random()``, whose sequence Python promises to keep.

    Raises:
        BadInput: there is no room for them, or none was found in :data:`MOST_TRIES` tries.
    """
    ranges = _ranges(space)
    matrix, factor = scaling(theta_inverse)
    needed = ceil((separation * factor * PER_METRE) ** 2)
    random = Random(f"{seed} {label}")
    points: list[Integers] = []
    scaled: list[Integers] = []
    for _ in range(MOST_TRIES):
        x, y, z = (low + int(random.random() * count) for low, count in ranges)
        candidate = _product(matrix, (x, y, z))
        if any(_square(candidate, other) < needed for other in scaled):
            continue
        points.append((x, y, z))
        scaled.append(candidate)
        if len(points) == uavs:
            return tuple((Fraction(x, PER_METRE), Fraction(y, PER_METRE), Fraction(z, PER_METRE)) for x, y, z in points)
    raise BadInput(
        f"{uavs} random points with separation={exact_text(separation)} do not fit into the flying space: "
        f"{MOST_TRIES} tries found room for {len(points)}, so fewer UAVs or a smaller separation would do"
    )


def disturbed(points: Sequence[Point], space: ClosedBox, jitter: Fraction, seed: int) -> tuple[Point, ...]:
    """Return `points`, in the flying space `space`, each moved by up to `jitter` >= 0 (m) per axis within the space.

    Uniform, and independent for each axis and point; how many points there are makes no difference for one of them.
    As for :func:`draw`, the same arguments give the same points everywhere: ``random.Random(f"{seed} jitter {i}")``.
    """
    if not jitter:
        return tuple(points)
    most = float(jitter)
    moved = []
    for i, point in enumerate(points):
        random = Random(f"{seed} jitter {i}")
        wished = (Fraction(float(value) + most * (2 * random.random() - 1)) for value in point)
        x, y, z = (min(max(value, low), high) for value, (low, high) in zip(wished, space, strict=True))
        moved.append((x, y, z))
    return tuple(moved)


def moved_points(points: Sequence[Point], by: Vector) -> tuple[Point, ...]:
    """Return `points` moved `by` so much (m)."""
    dx, dy, dz = by
    return tuple((x + dx, y + dy, z + dz) for x, y, z in points)


def moved_box(box: Box, by: Vector) -> Box:
    """Return `box` moved `by` so much (m)."""
    x, y, z = (
        (None if low is None else low + shift, None if high is None else high + shift)
        for (low, high), shift in zip(box, by, strict=True)
    )
    return (x, y, z)


def shuffled(points: Sequence[Point], seed: int, label: str) -> tuple[Point, ...]:
    """Return `points` in a random order that depends on `seed` and `label` only (and on how many there are)."""
    random = Random(f"{seed} {label}")
    # sorted by what random() returns, since Python promises nothing about shuffle()
    return tuple(points[i] for _, i in sorted((random.random(), i) for i in range(len(points))))


def _ranges(space: ClosedBox) -> list[tuple[int, int]]:
    """Return, per axis, the lowest coordinate that may be drawn and how many there are, in 1/PER_METRE m."""
    ranges = []
    for axis, (low, high) in zip("xyz", space, strict=True):
        lowest, highest = ceil((low + ROOM) * PER_METRE), floor((high - ROOM) * PER_METRE)
        if lowest > highest:
            raise BadInput(
                f"the flying space {axis}={exact_text(low)}…{exact_text(high)} is too thin for random points, "
                f"which keep {exact_text(ROOM)} m from its walls"
            )
        ranges.append((lowest, highest - lowest + 1))
    return ranges


def _product(matrix: tuple[Integers, ...], point: Sequence[int]) -> Integers:
    x, y, z = (row[0] * point[0] + row[1] * point[1] + row[2] * point[2] for row in matrix)
    return (x, y, z)


def _square(a: Integers, b: Integers) -> int:
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2
