"""What the modules of the exact checker read numbers with, and how they reject. See `margin.check`."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import lru_cache
from math import isqrt
from typing import Any, TypeVar

NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+|/0*[1-9][0-9]*)?")
LONGEST_NUMBER = 1000  #: characters; a certificate with a longer one is absurd

Vector = tuple[Fraction, ...]
Number = TypeVar("Number", int, Fraction)


class Rejected(Exception):
    """A certificate does not prove what it claims; the message says where, and what is wrong."""


@contextmanager
def located(where: str) -> Iterator[None]:
    """Let what is rejected within say where."""
    try:
        yield
    except Rejected as error:
        raise Rejected(f"{where}, {error}") from None


def need(condition: bool, what: str) -> None:
    """Reject if the condition does not hold."""
    if not condition:
        raise Rejected(what)


def object_of(value: object, keys: str) -> dict[str, Any]:
    """Return what must be a JSON object with exactly these keys."""
    if not isinstance(value, dict) or value.keys() != set(keys.split()):
        raise Rejected(f"expected an object with these keys and no others: {keys}")
    return value


def list_of(inside: Any, key: str | int, length: int | None = None) -> list[Any]:
    """Return what must be a list there, of this length if one is given."""
    value = inside[key]
    if not isinstance(value, list) or length not in (None, len(value)):
        raise Rejected(f"{key}: expected a list{'' if length is None else f' of length {length}'}")
    return value


def integer(inside: Any, key: str | int, low: int, high: int) -> int:
    """Return what must be an integer there, and in these limits."""
    value = inside[key]
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise Rejected(f"{key}: expected an integer from {low} to {high}")
    return value


@lru_cache(maxsize=1 << 16)
def _parse(text: str) -> Fraction | None:
    return Fraction(text) if len(text) <= LONGEST_NUMBER and NUMBER.fullmatch(text) else None


def number_of(inside: Any, key: str | int) -> Fraction:
    """Return what must be a number there, written as a string."""
    value = inside[key]
    number = _parse(value) if isinstance(value, str) else None
    if number is None:
        raise Rejected(f"{key}: expected a number as a string, an exact decimal or a fraction")
    return number


def numbers_of(inside: Any, key: str | int, length: int) -> Vector:
    """Return what must be a list of so many numbers there."""
    value = list_of(inside, key, length)
    with located(str(key)):
        return tuple(number_of(value, i) for i in range(length))


def read(text: str | bytes) -> object:
    """Decode the JSON text of a certificate; raise `Rejected` if it is none."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:  # not JSON, not Unicode, an integer of thousands of digits, too deep
        raise Rejected(f"the certificate is not JSON that can be read ({error})") from None


def digest(certificate: dict[str, Any]) -> str:
    """Return the SHA-256, in hex, of everything in a certificate but its digest."""
    rest = {key: value for key, value in certificate.items() if key != "digest"}
    try:
        return hashlib.sha256(json.dumps(rest, sort_keys=True, separators=(",", ":")).encode("ascii")).hexdigest()
    except (TypeError, ValueError, RecursionError) as error:  # too deep, or never was JSON
        raise Rejected(f"the certificate cannot be written as JSON ({error})") from None


def dot(left: Iterable[Fraction], right: Iterable[Fraction]) -> Fraction:
    """Return the sum of the products of two rows of equal length."""
    return sum((a * b for a, b in zip(left, right, strict=True)), Fraction(0))


def scaled(x: Fraction, scale: int) -> int:
    """Return x·scale, where the scale is a multiple of x's denominator: much faster than a product of fractions."""
    return x.numerator * (scale // x.denominator)


def square(gram: Iterable[Number], x: Number, y: Number, z: Number) -> Number:
    """Return ‖A(x, y, z)‖², where `gram` is the upper triangle of AᵀA, by rows."""
    xx, xy, xz, yy, yz, zz = gram
    return xx * x * x + yy * y * y + zz * z * z + 2 * (xy * x * y + xz * x * z + yz * y * z)


def root_above(square: Fraction) -> Fraction:
    """Return the least multiple of 10⁻⁹ whose square is at least this number (≥ 0)."""
    units = -(-square.numerator * 10**18 // square.denominator)
    return Fraction(isqrt(units - 1) + 1 if units else 0, 10**9)
