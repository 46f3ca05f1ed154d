"""A polyhedron inside a ball: what a quadratic program can be asked where the norm of a vector is bounded.

Of the directions u in :func:`directions`, u·x ≤ c·r for all of them lets through only vectors x with ‖x‖ ≤ r, and all
those with ‖x‖ ≤ c·r. The share c, :func:`share`, is as large as it can be, up to the rounding of a float.

The directions are the vertices of a surface of triangles around 0, so x is a sum αu + βu' + γu'' with weights ≥ 0 of
the corners of one triangle. Let w be the vector with u·w = u'·w = u''·w = 1. Then ‖x‖² ≤ c·r·(α + β + γ) = c·r·(w·x) ≤
c·r·‖w‖·‖x‖. So c = 1/‖w‖ is small enough, for the largest ‖w‖ of all triangles; this is decided in integers.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from itertools import combinations
from math import acos, nextafter, sin, sqrt

import numpy as np

from swarmproof.motion.lattice import Floats

#: Into how many parts every edge of an icosahedron is divided: 162 directions.
PARTS = 4
#: Directions are whole multiples of 1/2²⁰ along each axis, and a little shorter than 1.
PER_UNIT = 2**20

Direction = tuple[int, int, int]
Corners = tuple[Direction, Direction, Direction]


@cache
def directions() -> Floats:
    """Return the directions, shape (162, 3), nearly uniform; none is longer than 1."""
    found = np.array(sorted({corner for corners in triangles() for corner in corners}), float) / PER_UNIT
    found.setflags(write=False)
    return found


@cache
def share() -> float:
    """Return c, rounded down."""
    largest = max(_height_square(corners) for corners in triangles())
    rough = 1 / sqrt(largest)
    while Fraction(rough) ** 2 * largest > 1:
        rough = nextafter(rough, 0)
    return rough


@cache
def triangles() -> tuple[Corners, ...]:
    """Return the triangles, whose corners are directions in units of 1/:data:`PER_UNIT`."""
    golden = (1 + sqrt(5)) / 2
    signs = (1, -1)
    vertices = [
        np.roll(np.array([0.0, s, t * golden]) / sqrt(1 + golden**2), turn)
        for turn in range(3)
        for s in signs
        for t in signs
    ]
    edge = max(one @ other for one, other in combinations(vertices, 2))
    angle = acos(edge)
    made: dict[tuple[tuple[int, int], ...], Direction] = {}

    def at(face: tuple[int, ...], parts: tuple[int, ...]) -> Direction:
        """Return a direction within a face; what lies on an edge is made once, for both of its faces."""
        key = tuple((vertex, part) for vertex, part in zip(face, parts, strict=True) if part)
        if key not in made:
            sums = sum(sin(part * angle / PARTS) * vertices[vertex] for vertex, part in key)
            # towards 0, so that none is longer than 1
            x, y, z = (int(value) for value in np.trunc(sums / np.linalg.norm(sums) * (1 - 1e-12) * PER_UNIT))
            made[key] = (x, y, z)
        return made[key]

    faces = [
        face
        for face in combinations(range(12), 3)
        if all(vertices[a] @ vertices[b] > edge - 1e-9 for a, b in combinations(face, 2))
    ]
    return tuple((at(face, a), at(face, b), at(face, c)) for face in faces for a, b, c in _parts_of_face())


def _parts_of_face() -> Iterator[tuple[tuple[int, int, int], ...]]:
    """Yield the small triangles of a face: for each corner, by how many parts it is from which edge of the face."""
    for i in range(PARTS):
        for j in range(PARTS - i):
            k = PARTS - i - j
            yield (i, j, k), (i + 1, j, k - 1), (i, j + 1, k - 1)
            if k > 1:
                yield (i + 1, j + 1, k - 2), (i + 1, j, k - 1), (i, j + 1, k - 1)


def _height_square(corners: Corners) -> Fraction:
    """Return ‖w‖² for the w with u·w = 1 for the three corners u: w = (b×c + c×a + a×b) / (a·(b×c))."""
    a, b, c = corners
    crosses = (_cross(b, c), _cross(c, a), _cross(a, b))
    volume = sum(x * y for x, y in zip(a, crosses[0], strict=True))
    total = [sum(cross[axis] for cross in crosses) for axis in range(3)]
    return Fraction(PER_UNIT**2 * sum(x * x for x in total), volume**2)


def _cross(a: Direction, b: Direction) -> Direction:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
