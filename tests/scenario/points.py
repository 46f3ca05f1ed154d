"""Points of scenarios, as tests write them."""

from __future__ import annotations

from fractions import Fraction

from swarmproof.scenario.points import Point

Coordinate = Fraction | float


def decimal(x: Coordinate) -> Fraction:
    """Return a float as the decimal that it prints as, 0.1 as 1/10; a fraction as it is."""
    return Fraction(str(x))


def at(x: Coordinate, y: Coordinate, z: Coordinate) -> Point:
    """Return the point with these coordinates (m), read by :func:`decimal`."""
    return (decimal(x), decimal(y), decimal(z))


def points(*coordinates: tuple[Coordinate, Coordinate, Coordinate]) -> tuple[Point, ...]:
    """Return these points (m)."""
    return tuple(at(*one) for one in coordinates)
