"""Numbers as people type them, read exactly and shown again: 0.1 is 1/10. Files of them, and near misses of names."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from fractions import Fraction
from typing import Any, NamedTuple

from swarmproof.errors import BadInput
from swarmproof.files.reading import check_toml, read_bytes
from swarmproof.theorem3.formats import format_of


class Magnitude(NamedTuple):
    """How large a number may be, without its sign, and how small if it is not 0; `words` say so."""

    smallest: Fraction
    largest: Fraction
    words: str


#: A time or a distance: beyond these it is a mistake, since both are far beyond any swarm of UAVs.
QUANTITY = Magnitude(
    Fraction(1, 10**9), Fraction(10**6), "a value is 0, or between 1e-9 and 1e6 without its sign (SI units)"
)
#: A bound may be so large that it never binds.
BOUND = Magnitude(Fraction(1, 10**9), Fraction(10**9), "a bound is 0, or between 1e-9 and 1e9 (SI units)")
#: A coordinate may be as near to 0 as it likes: sines and cosines leave 1e-16 where 0 is meant.
COORDINATE = Magnitude(Fraction(0), Fraction(10**7), "a coordinate is between -1e7 and 1e7 m")
#: An entry of a matrix, a weight or a probability.
ENTRY = Magnitude(Fraction(0), Fraction(10**6), "a value is between -1e6 and 1e6")
#: m, or m/s and so on: a side of a flying space that is so far away, or a bound of a norm so large, is no limit.
NO_LIMIT = Fraction(10**9)
#: How long the text of one number, a ``--set`` and a parameter file may be: exact arithmetic pays for every digit.
MOST_DIGITS = 100
MOST_TEXT = 2_000
MOST_BYTES = 100_000
_DECIMAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE]([+-]?[0-9]+))?")
_FRACTION = re.compile(r"[+-]?[0-9]+/[0-9]+")


def exact_text(value: Fraction) -> str:
    """Return `value` as a decimal of at most 12 places if it is one, otherwise as a fraction such as ``1/6``."""
    scaled = value * 10**12
    if value.denominator == 1 or scaled.denominator != 1:
        return str(value)
    whole, places = divmod(abs(scaled.numerator), 10**12)
    return f"{'-' if value < 0 else ''}{whole}.{places:012d}".rstrip("0")


def read_number(raw: object, magnitude: Magnitude = QUANTITY) -> Fraction:
    """Return the number that `raw`, an int or a text such as ``0.1``, ``1e-3`` or ``1/6``, stands for exactly.

    Raises:
        BadInput: not a number, or one so large, small or long that it must be a mistake.
    """
    if isinstance(raw, float):
        raise BadInput(f"{raw!r} is a rounded number: write it as a text, which is read exactly")
    if isinstance(raw, bool) or not isinstance(raw, (int, str)):
        raise BadInput(f"{shown(raw)} is not a number: write a decimal such as 0.1, or a text such as 1/6")
    # an int is compared before it is printed, as printing a huge one is slow or refused
    value = Fraction(raw) if isinstance(raw, int) else _text_number(raw.strip(), magnitude)
    if abs(value) > magnitude.largest or (value and abs(value) < magnitude.smallest):
        raise _out_of_range("an integer of many digits" if isinstance(raw, int) else shown(raw), magnitude)
    return value


def read_side(raw: object, sign: int) -> Fraction | None:
    """Return the low (`sign` −1) or high (1) side of an axis; None if `raw` says that there is no limit.

    Raises:
        BadInput: as :func:`read_number`; an infinity on the wrong side.
    """
    word = raw.strip().lower() if isinstance(raw, str) else ""
    if raw is None or word in ("none", "inf" if sign > 0 else "-inf", "+inf" if sign > 0 else "-inf"):
        return None
    if word in ("inf", "+inf", "-inf"):
        raise BadInput(f"{word} is no {'high' if sign > 0 else 'low'}: for no limit write [-inf, inf]")
    value = read_number(raw, COORDINATE._replace(largest=1000 * NO_LIMIT))
    if sign * value >= NO_LIMIT:
        return None
    if abs(value) > COORDINATE.largest:
        raise BadInput(f"{shown(raw)} is out of range: {COORDINATE.words}; for no limit write inf")
    return value


def _text_number(text: str, magnitude: Magnitude) -> Fraction:
    if len(text) > MOST_DIGITS:
        raise BadInput(f"{shown(text)} is too long for a number: {MOST_DIGITS} characters are enough")
    if decimal := _DECIMAL.fullmatch(text):
        # refused before the power of ten is built
        exponent = int(decimal[1] or 0)
        if exponent < -MOST_DIGITS and not magnitude.smallest:
            raise BadInput(
                f"{shown(text)} has too many digits behind the point: {MOST_DIGITS} are the most, or write 0"
            )
        if abs(exponent) > MOST_DIGITS:
            raise _out_of_range(shown(text), magnitude)
    elif not _FRACTION.fullmatch(text):
        raise BadInput(f"{shown(text)} is not a number: write a decimal such as 0.1 or a fraction such as 1/6")
    elif not int(text.partition("/")[2]):
        raise BadInput(f"{shown(text)} divides by zero: write a fraction such as 1/6")
    return Fraction(text)


def _out_of_range(text: str, magnitude: Magnitude) -> BadInput:
    return BadInput(f"{text} is out of range: {magnitude.words}")


def read_toml(path: str | os.PathLike[str], kind: str, line: str, most_bytes: int = MOST_BYTES) -> dict[str, Any]:
    """Return the table in the TOML file `path`, in which decimals are texts that :func:`read_number` reads exactly.

    Raises:
        BadInput: the file cannot be read, is too long or is no TOML; `kind` and an example `line` say what would be.
    """
    place = os.fspath(path)
    content = read_bytes(path, kind, most_bytes, f"give a TOML file with lines such as {line}")
    try:
        text = content.decode()
    except UnicodeDecodeError:
        raise BadInput(f"{place} is not a text file (UTF-8) with lines such as {line}") from None
    try:
        check_toml(text)
    except ValueError as reason:
        raise BadInput(f"{place} is not a {kind}: {reason}; write lines such as {line}") from None
    try:
        return tomllib.loads(text, parse_float=lambda text: text.replace("_", ""))
    except tomllib.TOMLDecodeError as error:
        other = format_of(text)
        if other not in (None, "an INI file"):
            raise BadInput(
                f"{place} is {other}, which is not read: write the {kind} as TOML, in lines such as {line}"
            ) from None
        raise BadInput(f"{place} is not TOML with lines such as {line}: {error}") from None
    except ValueError:
        # Python refuses to read an integer of thousands of digits
        raise BadInput(f"{place} has a number of far too many digits: {MOST_DIGITS} are enough") from None


def near_match(name: str, known: Iterable[str]) -> str:
    """Return what to say of an unknown `name`: the nearest of the `known` ones, or all of them."""
    by_lower = {one.lower(): one for one in known}
    near = get_close_matches(name[:MOST_DIGITS].lower(), by_lower, n=1)
    return f"did you mean {by_lower[near[0]]}?" if near else f"choose one of {', '.join(by_lower.values())}"


def shown(raw: object) -> str:
    """Return `raw`, a value as TOML has it, for a message: on one line and not too long."""
    if isinstance(raw, bool):
        return str(raw).lower()
    # their repr could be endless, or refused because of a huge integer within
    if isinstance(raw, (list, Mapping)):
        return "a list" if isinstance(raw, list) else "a table"
    text = repr(raw)
    return text if len(text) <= 60 else f"{text[:50]}…{text[-1]}"
