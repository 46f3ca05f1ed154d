"""The formations that a scenario file can name: where N UAVs stand, in metres.

`height` is that of the lowest UAVs (sphere: of its lowest point), `centre` the (x, y) of the middle. Coordinates,
counted from the centre, are rounded to nanometres: they read well, do not depend on the last bit of a sine, and a
spacing of 0.3 m is exactly that.

Downwash counts heights less than widths (eq. 2): UAVs on different heights must not stand above each other either, so
pyramid, cube and sphere place no UAV above another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from math import ceil, cos, pi, radians, sin, sqrt

from swarmproof.scenario.points import Point

#: (x, y) in m.
Centre = tuple[Fraction, Fraction]


def circle(uavs: int, centre: Centre, radius: float, height: float) -> tuple[Point, ...]:
    """Return UAVs with equal angles between them; UAV 0 is in direction x, the others follow counter-clockwise."""
    return _points(centre, ((*_polar(radius, 2 * pi * i / uavs), height) for i in range(uavs)))


def line(uavs: int, centre: Centre, spacing: float, height: float) -> tuple[Point, ...]:
    """Return UAVs side by side in direction x."""
    return _points(centre, ((spacing * (i - (uavs - 1) / 2), 0.0, height) for i in range(uavs)))


def plane(uavs: int, centre: Centre, spacing: float, height: float) -> tuple[Point, ...]:
    """Return UAVs row by row on a horizontal grid of about as many rows as columns."""
    columns = ceil(sqrt(uavs))
    middle_x, middle_y = (columns - 1) / 2, (ceil(uavs / columns) - 1) / 2
    cells = (divmod(i, columns) for i in range(uavs))
    return _points(centre, ((spacing * (x - middle_x), spacing * (y - middle_y), height) for y, x in cells))


def pyramid(uavs: int, centre: Centre, side: float, height: float, rise: float) -> tuple[Point, ...]:
    """Return UAVs on the four slanted edges: layers of four from the base upwards, the last at `height` + `rise`.

    `side` is that of the base; the tip, one layer further, stays empty.
    """
    layers = ceil(uavs / 4)
    lift = rise / max(layers - 1, 1)
    places = (divmod(i, 4) for i in range(uavs))
    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    halves = [side / 2 * (layers - layer) / layers for layer in range(layers)]
    return _points(
        centre,
        (
            (corners[edge][0] * halves[layer], corners[edge][1] * halves[layer], height + lift * layer)
            for layer, edge in places
        ),
    )


def cube(uavs: int, centre: Centre, side: float, height: float) -> tuple[Point, ...]:
    """Return UAVs along the edges of a cube's bottom and top, those of the top midway between those of the bottom.

    With an odd number, the bottom has one more, and not all are midway.
    """
    upper = uavs // 2
    lower = uavs - upper
    bottom = [(*_on_square(side, i / lower), height) for i in range(lower)]
    top = [(*_on_square(side, (i + 0.5) / upper), height + side) for i in range(upper)]
    return _points(centre, [*bottom, *top])


def sphere(uavs: int, centre: Centre, radius: float, height: float, turn: float) -> tuple[Point, ...]:
    """Return UAVs on a spiral around a sphere from its bottom to its top, in layers of equal thickness.

    `turn` is the angle in degrees from one UAV to the next: choose it such that none comes to stand above another.
    """
    levels = [(2 * i + 1) / uavs for i in range(uavs)]
    return _points(
        centre,
        (
            (*_polar(radius * sqrt(level * (2 - level)), radians(turn) * i), height + radius * level)
            for i, level in enumerate(levels)
        ),
    )


def antipodes(starts: Sequence[Point], centre: Centre) -> tuple[Point, ...]:
    """Return, for each of `starts`, the point of the same height on the opposite side of `centre`."""
    return tuple((2 * centre[0] - x, 2 * centre[1] - y, z) for x, y, z in starts)


#: By name, the formations that depend on nothing but numbers (m; turn: degrees), and the names of these.
FORMATIONS: dict[str, tuple[Callable[..., tuple[Point, ...]], tuple[str, ...]]] = {
    "circle": (circle, ("radius", "height")),
    "line": (line, ("spacing", "height")),
    "plane": (plane, ("spacing", "height")),
    "pyramid": (pyramid, ("side", "height", "rise")),
    "cube": (cube, ("side", "height")),
    "sphere": (sphere, ("radius", "height", "turn")),
}


def _polar(radius: float, angle: float) -> tuple[float, float]:
    return (radius * cos(angle), radius * sin(angle))


def _on_square(side: float, part: float) -> tuple[float, float]:
    """Return the point after `part` (0 … 1) of the way around a square, from one corner."""
    edge, along = divmod(4 * part, 1)
    x, y = -side / 2 + side * along, -side / 2
    for _ in range(int(edge)):
        x, y = -y, x
    return (x, y)


def _points(centre: Centre, offsets: Iterable[tuple[float, float, float]]) -> tuple[Point, ...]:
    return tuple((centre[0] + _nano(x), centre[1] + _nano(y), _nano(z)) for x, y, z in offsets)


def _nano(value: float) -> Fraction:
    """Return `value` (m) rounded to a decimal of nine places, exactly."""
    return Fraction(f"{value:.9f}")
