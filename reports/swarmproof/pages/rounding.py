"""Exact numbers as floats and decimals that are rounded to the safe side."""

from __future__ import annotations

from fractions import Fraction
from math import ceil, floor, inf, nextafter


def below(value: Fraction) -> float:
    """Return the largest float that is not above an exact number."""
    number = float(value)
    return number if Fraction(number) <= value else nextafter(number, -inf)


def above(value: Fraction) -> float:
    """Return the smallest float that is not below an exact number."""
    return -below(-value)


def decimal_below(value: Fraction, places: int) -> str:
    """Return the largest decimal with so many places that is not above an exact number."""
    return f"{floor(value * 10**places) / 10**places:.{places}f}"


def decimal_above(value: Fraction, places: int) -> str:
    """Return the smallest decimal with so many places that is not below an exact number."""
    return f"{ceil(value * 10**places) / 10**places:.{places}f}"


def rounded_down(value: Fraction, digits: int) -> str:
    """Return the largest decimal with `digits` digits after the point that is not above a nonnegative number."""
    whole, rest = divmod(floor(value * 10**digits), 10**digits)
    return f"{whole}.{rest:0{digits}d}"


def rounded_up(value: Fraction, digits: int) -> str:
    """Return the smallest decimal with `digits` digits after the point that is not below a nonnegative number."""
    whole, rest = divmod(ceil(value * 10**digits), 10**digits)
    return f"{whole}.{rest:0{digits}d}"
