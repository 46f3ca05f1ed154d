"""The parameters of Theorem 3 (DMPC-Swarm, eqs. 24-26), exactly as they were written: 0.1 is 1/10.

SI units throughout. Values come from Python, from a TOML file, from ``NAME=VALUE`` texts (``--set``) or from a
certificate; whatever the way, a value that makes no sense is a :class:`BadInput` of one sentence.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from difflib import get_close_matches
from enum import StrEnum
from fractions import Fraction
from typing import Any

from swarmproof.semantics.switches import BadInput

Vector = tuple[Fraction, Fraction, Fraction]
Matrix = tuple[Vector, Vector, Vector]
Box = tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction], tuple[Fraction, Fraction]]

#: No value may be larger than this, and none but zero smaller than that; both are far beyond any swarm of UAVs.
LARGEST = Fraction(10**6)
SMALLEST = Fraction(1, 10**9)
#: How long the text of one number, a ``--set`` and a parameter file may be: exact arithmetic pays for every digit.
MOST_DIGITS = 100
MOST_TEXT = 2_000
MOST_BYTES = 100_000
#: How many collision windows, and how many state-bound samples, one period T_s may have.
MOST_WINDOWS = 1000

_DECIMAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE]([+-]?[0-9]+))?")
_FRACTION = re.compile(r"[+-]?[0-9]+/[0-9]+")


class Reading(StrEnum):
    """What the set X and the inputs U of eq. (24) restrict: the paper leaves three possibilities."""

    #: X binds the states at time 0 only, as printed; the input is any measurable function with values in U.
    INITIAL_STATE = "initial-state"
    #: X binds at all times in [0, T_c]; inputs as above.
    WHOLE_MOTION = "whole-motion"
    #: What the algorithm enforces: one input per period T_s, X at multiples of T_b, any window of length T_c.
    AS_SAMPLED = "as-sampled"

    @classmethod
    def parse(cls, text: str) -> Reading:
        """Return the reading called `text`; raise :class:`BadInput` if there is none."""
        if text not in list(cls):
            raise BadInput(f"there is no reading {shown(text)}: choose {', '.join(list(cls)[:-1])} or {list(cls)[-1]}")
        return cls(text)


def _axes(value: Fraction) -> Vector:
    return (value, value, value)


def diagonal(entries: Vector) -> Matrix:
    """Return the diagonal 3 x 3 matrix with these entries."""
    x, y, z = entries
    zero = Fraction(0)
    return ((x, zero, zero), (zero, y, zero), (zero, zero, z))


#: Θ⁻¹ of the published experiments: a UAV's downwash makes it six times as high as wide.
PUBLISHED_SCALING = diagonal((Fraction(1), Fraction(1), Fraction(1, 6)))


@dataclass(frozen=True, slots=True)
class Parameters:
    """Everything that Theorem 3 depends on; the defaults are the published ones (Section 5), in SI units.

    Raises:
        BadInput: a value that no reading of Theorem 3 has a meaning for.
    """

    #: s; spacing of the collision samples, the end of the interval in eq. (24).
    T_c: Fraction = Fraction(1, 10)
    #: s; period of one constant input (Section 5: the round time T).
    T_s: Fraction = Fraction(1, 5)
    #: s; spacing of the samples at which the state is bounded (T_s where nothing else is given).
    T_b: Fraction = Fraction(1, 5)
    #: m; the scaled distance kept at the collision samples, eqs. (15) and (24).
    d_hat_min: Fraction = Fraction(1, 4)
    #: m/s, per axis; the set X of eq. (24).
    v_max: Vector = (Fraction(2), Fraction(2), Fraction(2))
    #: m/s², per axis; the set X of eq. (24), or U if `order` is 2.
    a_max: Vector = (Fraction(5), Fraction(5), Fraction(5))
    #: m/s³, per axis; the set U of eq. (24), without meaning if `order` is 2.
    j_max: Vector = (Fraction(5), Fraction(5), Fraction(5))
    #: the inverse of the scaling matrix for downwash, eq. (2); symmetric positive definite.
    theta_inverse: Matrix = PUBLISHED_SCALING
    #: how often the nominal system of eq. (4) integrates its input: 3 (input jerk) or 2 (input acceleration).
    order: int = 3
    #: m; (low, high) per axis for the positions in X, None for no restriction.
    workspace: Box | None = None
    #: m; the scaled distance that the real UAVs are to keep, eq. (2).
    d_min: Fraction = Fraction(3, 25)
    #: m; the bound on each UAV's distance from its reference, in no scaled norm: Δd_min of Assumption 1, eq. (6).
    tracking_error: Fraction = Fraction(0)

    def __post_init__(self) -> None:
        """Raise :class:`BadInput` on a value outside of what its parameter can be."""
        for name in NAMES:
            _check(name, getattr(self, name))

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str], changes: Iterable[str] = ()) -> Parameters:
        """Return the parameters in the TOML file `path`, then each ``NAME=VALUE`` of `changes`; others are published.

        T_b is T_s unless the file or a change gives it.

        Raises:
            BadInput: the file cannot be read or is no TOML, or a name or value that cannot be.
        """
        return cls.from_table(os.fspath(path), read_toml(path, "parameter file", "T_c = 0.1"), changes)

    @classmethod
    def from_table(cls, place: str, table: Mapping[str, object], changes: Iterable[str] = ()) -> Parameters:
        """Return the same of a `table` that :func:`read_toml` has read.

        Raises:
            BadInput: a name or value that cannot be; `place` says where the table is.
        """
        return cls()._changed([*((place, name, raw) for name, raw in table.items()), *_set_entries(changes)])

    def with_changes(self, changes: Iterable[str]) -> Parameters:
        """Return these parameters with each ``NAME=VALUE`` of `changes` applied.

        A T_b that equals T_s follows a changed T_s, unless it is changed itself.

        Raises:
            BadInput: a name or value that cannot be.
        """
        return self._changed(_set_entries(changes))

    @classmethod
    def from_exact(cls, values: Mapping[str, object]) -> Parameters:
        """Return the parameters that :meth:`as_exact` gives as `values`.

        Raises:
            BadInput: a name is missing or unknown, or a value cannot be.
        """
        missing = [name for name in NAMES if name not in values]
        if missing:
            raise BadInput(f"the parameters lack {', '.join(missing)}: all of {', '.join(NAMES)} must be there")
        return cls()._changed([("the parameters", str(name), value) for name, value in values.items()])

    def _changed(self, entries: Iterable[tuple[str, str, object]]) -> Parameters:
        """Return these parameters with every (place, name, raw value) of `entries` read and applied."""
        changed: dict[str, Any] = {}
        for place, name, raw in entries:
            try:
                if isinstance(raw, Mapping):
                    raise BadInput(f"{shown(name)} is a table, which is not a value: write lines such as T_c = 0.1")
                if name not in NAMES:
                    raise BadInput(f"there is no parameter {shown(name)}: {near_match(name, NAMES)}")
                value = _read(name, raw)
                _check(name, value)
            except BadInput as mistake:
                raise BadInput(f"{place}: {mistake}") from None
            changed[name] = value
        if "T_s" in changed and self.T_b == self.T_s:
            changed.setdefault("T_b", changed["T_s"])
        return replace(self, **changed)

    def check_reading(self, reading: Reading) -> None:
        """Raise :class:`BadInput` unless `reading` has a meaning: as-sampled needs T_c and T_b to divide T_s."""
        if reading is not Reading.AS_SAMPLED:
            return
        for name, part in (("T_c", self.T_c), ("T_b", self.T_b)):
            count = self.T_s / part
            if count.denominator != 1 or count > MOST_WINDOWS:
                raise BadInput(
                    f"reading as-sampled needs T_s to be a whole multiple of {name}, at most {MOST_WINDOWS} times it: "
                    f"T_s={exact_text(self.T_s)} is {exact_text(count)} times {name}={exact_text(part)}"
                )

    def as_json(self) -> dict[str, Any]:
        """Return the values by name as floats and nested lists, for people; :meth:`as_exact` loses nothing."""
        return {name: _nested(getattr(self, name), float) for name in NAMES}

    def as_exact(self) -> dict[str, Any]:
        """Return the values by name as nested lists of exact texts such as ``"0.05"`` and ``"1/6"`` (order: an int)."""
        return {name: _nested(getattr(self, name), exact_text) for name in NAMES}

    def differences(self, base: Parameters | None = None) -> list[str]:
        """Return the shortest ``NAME=VALUE`` texts with which :meth:`with_changes` makes self of `base` (published)."""
        base = Parameters() if base is None else base
        followed = replace(base, T_s=self.T_s, T_b=self.T_s) if base.T_b == base.T_s else base
        return [
            f"{name}={_compact(name, getattr(self, name))}"
            for name in NAMES
            if getattr(self, name) != getattr(followed if name == "T_b" else base, name)
        ]

    def describe(self, base: Parameters | None = None) -> str:
        """Return what differs from `base` (the published parameters), such as ``T_c=0.05, v_max=1``; may be empty."""
        return ", ".join(self.differences(base))


#: The names of the parameters, in the order in which they are shown.
NAMES: tuple[str, ...] = tuple(field.name for field in fields(Parameters))
_PERIODS_AND_DISTANCES = ("T_c", "T_s", "T_b", "d_hat_min", "d_min")
_BOUNDS = ("v_max", "a_max", "j_max")


def exact_text(value: Fraction) -> str:
    """Return `value` as a decimal of at most 12 places if it is one, otherwise as a fraction such as ``1/6``."""
    scaled = value * 10**12
    if value.denominator == 1 or scaled.denominator != 1:
        return str(value)
    whole, places = divmod(abs(scaled.numerator), 10**12)
    return f"{'-' if value < 0 else ''}{whole}.{places:012d}".rstrip("0")


def read_number(raw: object) -> Fraction:
    """Return the number that `raw`, an int or a text such as ``0.1``, ``1e-3`` or ``1/6``, stands for exactly.

    Raises:
        BadInput: not a number, or one so large, small or long that it must be a mistake.
    """
    if isinstance(raw, float):
        raise BadInput(f"{raw!r} is a rounded number: write it as a text, which is read exactly")
    if isinstance(raw, bool) or not isinstance(raw, (int, str)):
        raise BadInput(f"{shown(raw)} is not a number: write a decimal such as 0.1, or a text such as 1/6")
    # an int is compared before it is printed, as printing a huge one is slow or refused
    value = Fraction(raw) if isinstance(raw, int) else _text_number(raw.strip())
    if abs(value) > LARGEST or (value and abs(value) < SMALLEST):
        raise _out_of_range("an integer of many digits" if isinstance(raw, int) else shown(raw))
    return value


def _text_number(text: str) -> Fraction:
    if len(text) > MOST_DIGITS:
        raise BadInput(f"{shown(text)} is too long for a number: {MOST_DIGITS} characters are enough")
    if decimal := _DECIMAL.fullmatch(text):
        # refused before the power of ten is built
        if abs(int(decimal[1] or 0)) > MOST_DIGITS:
            raise _out_of_range(shown(text))
    elif not _FRACTION.fullmatch(text):
        raise BadInput(f"{shown(text)} is not a number: write a decimal such as 0.1 or a fraction such as 1/6")
    elif not int(text.partition("/")[2]):
        raise BadInput(f"{shown(text)} divides by zero: write a fraction such as 1/6")
    return Fraction(text)


def _out_of_range(text: str) -> BadInput:
    return BadInput(f"{text} is out of range: a value is 0, or between 1e-9 and 1e6 without its sign (SI units)")


def read_toml(path: str | os.PathLike[str], kind: str, line: str) -> dict[str, Any]:
    """Return the table in the TOML file `path`, in which decimals are texts that :func:`read_number` reads exactly.

    Raises:
        BadInput: the file cannot be read, is too long or is no TOML; `kind` and an example `line` say what would be.
    """
    place = os.fspath(path)
    try:
        with open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise BadInput(f"cannot read the {kind} {place}: {reason}") from None
    if len(content) > MOST_BYTES:
        raise BadInput(f"{place} is too long for a {kind}: {MOST_BYTES} bytes are enough")
    try:
        return tomllib.loads(content.decode(), parse_float=lambda text: text.replace("_", ""))
    except RecursionError:
        raise BadInput(f"{place} is not a {kind}: its lists are nested too deeply") from None
    except UnicodeDecodeError:
        raise BadInput(f"{place} is not a text file (UTF-8) with lines such as {line}") from None
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"{place} is not TOML with lines such as {line}: {error}") from None
    except ValueError:
        # Python refuses to read an integer of thousands of digits
        raise BadInput(f"{place} has a number of far too many digits: {MOST_DIGITS} are enough") from None


def _set_entries(changes: Iterable[str]) -> list[tuple[str, str, object]]:
    entries: list[tuple[str, str, object]] = []
    for change in changes:
        name, equals, value = change.partition("=")
        if not equals:
            raise BadInput(f"--set {shown(change)} is not of the form NAME=VALUE, such as T_c=0.05")
        if len(value) > MOST_TEXT:
            raise BadInput(f"--set {shown(name)} has a value of {len(value)} characters: {MOST_TEXT} are enough")
        entries.append(("--set", name.strip(), value))
    return entries


def near_match(name: str, known: Iterable[str]) -> str:
    """Return what to say of an unknown `name`: the nearest of the `known` ones, or all of them."""
    by_lower = {one.lower(): one for one in known}
    near = get_close_matches(name[:MOST_DIGITS].lower(), by_lower, n=1)
    return f"did you mean {by_lower[near[0]]}?" if near else f"choose one of {', '.join(by_lower.values())}"


def _read(name: str, raw: object) -> object:
    """Return `raw` in the shape of parameter `name`; raise :class:`BadInput` if it has no such shape."""
    if name == "workspace" and (raw is None or (isinstance(raw, str) and raw.strip() == "none")):
        return None
    try:
        numbers, pattern = _flat(raw)
    except BadInput as mistake:
        raise BadInput(f"{name}: {mistake}") from None
    if name == "workspace":
        if pattern not in ("6", "rows of 2 2 2"):
            raise BadInput("workspace takes low and high for x, y and z, six numbers in all, or none")
        return tuple(zip(numbers[::2], numbers[1::2], strict=True))
    if name == "theta_inverse":
        if pattern == "1":
            return diagonal(_axes(numbers[0]))
        if pattern == "3":
            return diagonal((numbers[0], numbers[1], numbers[2]))
        if pattern not in ("9", "rows of 3 3 3"):
            raise BadInput("theta_inverse takes 1 number, the 3 of its diagonal or all 9, row by row")
        return tuple(tuple(numbers[row : row + 3]) for row in (0, 3, 6))
    if name in _BOUNDS:
        if pattern not in ("1", "3"):
            raise BadInput(f"{name} takes one number, or three for x, y and z")
        return _axes(numbers[0]) if pattern == "1" else tuple(numbers)
    if pattern != "1":
        raise BadInput(f"{name} takes one number")
    return int(numbers[0]) if name == "order" and numbers[0].denominator == 1 else numbers[0]


def _flat(raw: object) -> tuple[list[Fraction], str]:
    """Return the numbers in `raw` and their grouping: ``"3"`` for three, ``"rows of 3 3 3"`` for lists of lists."""
    parts: object = raw.split(",") if isinstance(raw, str) else raw
    if not isinstance(parts, Sequence) or isinstance(parts, str):
        return [read_number(parts)], "1"
    if len(parts) > 9:
        return [], "too many"
    if not any(isinstance(part, list) for part in parts):
        return [read_number(part) for part in parts], str(len(parts))
    rows = [part if isinstance(part, list) else [part] for part in parts]
    if any(len(row) > 3 for row in rows):
        return [], "too many"
    lengths = " ".join(str(len(row)) for row in rows)
    return [read_number(entry) for row in rows for entry in row], f"rows of {lengths}"


def _check(name: str, value: Any) -> None:
    """Raise :class:`BadInput` if parameter `name` cannot be `value`."""
    if name in _PERIODS_AND_DISTANCES and value <= 0:
        raise BadInput(f"{name} must be positive, not {exact_text(value)}")
    if name == "tracking_error" and value < 0:
        raise BadInput(f"tracking_error must not be negative, as {exact_text(value)} is")
    if name in _BOUNDS and min(value) < 0:
        raise BadInput(f"{name} must not be negative on any axis, as {exact_text(min(value))} is")
    if name == "order" and value not in (2, 3):
        raise BadInput(f"order is 2 (input acceleration) or 3 (input jerk), not {exact_text(Fraction(value))}")
    if name == "theta_inverse":
        _check_definite(value)
    if name == "workspace" and value is not None:
        for axis, (low, high) in zip("xyz", value, strict=True):
            if low > high:
                raise BadInput(f"workspace has a low {axis}={exact_text(low)} above its high {axis}={exact_text(high)}")


def _check_definite(matrix: Matrix) -> None:
    (a, b, c), (d, e, f), (g, h, i) = matrix
    if (b, c, f) != (d, g, h):
        raise BadInput("theta_inverse is not symmetric: entry (row, column) must equal entry (column, row)")
    # Sylvester: a symmetric matrix is positive definite iff its leading minors are positive
    minor = a * e - b * d
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    if determinant == 0:
        raise BadInput("theta_inverse is singular: it must be invertible, as Θ⁻¹ scales every direction")
    if not (a > 0 and minor > 0 and determinant > 0):
        raise BadInput("theta_inverse is not positive definite: all its eigenvalues must be positive")


def _nested(value: Any, leaf: Any) -> Any:
    if isinstance(value, tuple):
        return [_nested(part, leaf) for part in value]
    return leaf(value) if isinstance(value, Fraction) else value


def _compact(name: str, value: Any) -> str:
    """Return the shortest text that :func:`_read` reads as `value`."""
    if value is None:
        return "none"
    if name == "theta_inverse" and value == diagonal((value[0][0], value[1][1], value[2][2])):
        value = tuple(value[axis][axis] for axis in range(3))
    if not isinstance(value, tuple):
        return exact_text(Fraction(value))
    parts = [part for row in value for part in (row if isinstance(row, tuple) else (row,))]
    return exact_text(parts[0]) if len(parts) == 3 and len(set(parts)) == 1 else ",".join(map(exact_text, parts))


def shown(raw: object) -> str:
    """Return `raw`, a value as TOML has it, for a message: on one line and not too long."""
    if isinstance(raw, bool):
        return str(raw).lower()
    # their repr could be endless, or refused because of a huge integer within
    if isinstance(raw, (list, Mapping)):
        return "a list" if isinstance(raw, list) else "a table"
    text = repr(raw)
    return text if len(text) <= 60 else f"{text[:50]}…{text[-1]}"
