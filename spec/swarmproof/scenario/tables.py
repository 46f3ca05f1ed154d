"""Reads the values of a TOML table exactly; what cannot be is refused in one sentence."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction

from swarmproof.errors import BadInput
from swarmproof.scenario.points import Point
from swarmproof.theorem3.numbers import COORDINATE, QUANTITY, Magnitude, exact_text, near_match, read_number, shown

Table = Mapping[str, object]


@contextmanager
def within(place: str) -> Iterator[None]:
    """Let the sentence of a :class:`BadInput` raised inside begin with `place`."""
    try:
        yield
    except BadInput as mistake:
        raise BadInput(f"{place}: {mistake}") from None


def only(table: Table, known: Iterable[str]) -> None:
    """Raise :class:`BadInput` if `table` has a key that is not one of `known`."""
    known = list(known)
    for key in table:
        if key not in known:
            raise BadInput(f"there is no key {shown(key)} here: {near_match(key, known)}")


def subtable(table: Table, key: str) -> Table:
    """Return the table [`key`] in `table`."""
    if key not in table:
        raise BadInput(f"the table [{key}] is missing")
    return as_table(table[key], f"[{key}]")


def as_table(raw: object, name: str) -> Table:
    """Return `raw`, which is a table."""
    if not isinstance(raw, Mapping):
        raise BadInput(f"{shown(raw)} is not a table: write a line {name}, and lines such as radius = 1.5 below it")
    return raw


def number(table: Table, key: str, magnitude: Magnitude = QUANTITY) -> Fraction:
    """Return the number `key` of `table`, exactly."""
    if key not in table:
        raise BadInput(f"{key} is missing: write a line such as {key} = 1")
    with within(key):
        return read_number(table[key], magnitude)


def positive(table: Table, key: str) -> Fraction:
    """Return the number `key` of `table`, exactly; it is positive."""
    value = number(table, key)
    if value <= 0:
        raise BadInput(f"{key} must be positive, not {exact_text(value)}")
    return value


def not_negative(table: Table, key: str) -> Fraction:
    """Return the number `key` of `table`, exactly; it is not negative."""
    value = number(table, key)
    if value < 0:
        raise BadInput(f"{key} must not be negative, but it is {exact_text(value)}")
    return value


def word(table: Table, key: str, words: Sequence[str]) -> str:
    """Return the value `key` of `table`, one of the `words`."""
    value = table.get(key)
    if not isinstance(value, str) or value not in words:
        raise BadInput(f"{key} must be {' or '.join(words)}, not {shown(value)}")
    return value


def whole(table: Table, key: str, low: int, high: int) -> int:
    """Return the whole number `key` of `table`, `low` to `high`."""
    value = number(table, key)
    if value.denominator != 1 or not low <= value <= high:
        raise BadInput(f"{key} must be a whole number from {low} to {high}, not {exact_text(value)}")
    return int(value)


def text(table: Table, key: str, most: int) -> str:
    """Return the text `key` of `table`: printable, on one line, of at most `most` characters."""
    value = table.get(key)
    if not isinstance(value, str) or not value.strip() or not value.isprintable() or len(value) > most:
        raise BadInput(f'{key} must be a text of 1 to {most} characters on one line, such as {key} = "swap"')
    return value


def points(raw: object) -> tuple[Point, ...]:
    """Return the points (m) in the list of lists `raw`."""
    if not isinstance(raw, list):
        raise BadInput("positions takes a list of points [x, y, z] in m, such as [[-0.5, 0, 1], [0.5, 0, 1]]")
    found = []
    for i, point in enumerate(raw):
        with within(f"the position of UAV {i}"):
            x, y, z = _numbers(point, "xyz")
            found.append((x, y, z))
    return tuple(found)


def centre(table: Table) -> tuple[Fraction, Fraction]:
    """Return the centre (x, y) in `table`, in m; without one, it is (0, 0)."""
    with within("centre"):
        x, y = _numbers(table.get("centre", [0, 0]), "xy")
    return (x, y)


def velocity(table: Table, key: str) -> tuple[Fraction, Fraction, Fraction]:
    """Return the velocity `key` of `table` (m/s)."""
    with within(key):
        x, y, z = _numbers(table[key], "xyz", "m/s")
    return (x, y, z)


def _numbers(raw: object, axes: str, unit: str = "m") -> list[Fraction]:
    example = [0.5, 0, 1][: len(axes)]
    if not isinstance(raw, list) or len(raw) != len(axes):
        raise BadInput(
            f"{shown(raw)} is not a list of {len(axes)} numbers [{', '.join(axes)}] in {unit}, such as {example}"
        )
    table = dict(zip(axes, raw, strict=True))
    return [number(table, axis, COORDINATE) for axis in axes]
