"""The parameters of Theorem 3 (DMPC-Swarm, eqs. 24-26), exactly as they were written: 0.1 is 1/10.

SI units throughout. Values come from Python, from a TOML file, from ``NAME=VALUE`` texts (``--set``) or from a
certificate; whatever the way, a value that makes no sense is a :class:`BadInput` of one sentence.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import StrEnum
from fractions import Fraction
from typing import Any, TypeVar

from swarmproof.semantics.switches import BadInput
from swarmproof.theorem3.numbers import (
    BOUND,
    ENTRY,
    MOST_TEXT,
    NO_LIMIT,
    QUANTITY,
    Magnitude,
    exact_text,
    near_match,
    read_number,
    read_side,
    read_toml,
    shown,
)

Vector = tuple[Fraction, Fraction, Fraction]
Matrix = tuple[Vector, Vector, Vector]
#: Low and high of one axis in m; None where there is no limit.
Sides = tuple[Fraction | None, Fraction | None]
Box = tuple[Sides, Sides, Sides]
#: The same with limits everywhere.
Limits = tuple[Fraction, Fraction]
ClosedBox = tuple[Limits, Limits, Limits]

Part = TypeVar("Part")

#: m; further than any UAV gets in one window.
REACH = Fraction(10**6)
#: How many collision windows, and how many state-bound samples, one period T_s may have.
MOST_WINDOWS = 1000


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


#: What the values of the parameters can be, where they are no plain quantities.
_MAGNITUDES: dict[str, Magnitude] = {
    **dict.fromkeys(("v_max", "a_max", "j_max", "v_norm", "a_norm", "j_norm"), BOUND),
    **dict.fromkeys(("theta_inverse", "crash_theta_inverse"), ENTRY),
}
_PERIODS_AND_DISTANCES = ("T_c", "T_s", "T_b", "d_hat_min", "d_min")
_BOUNDS = ("v_max", "a_max", "j_max")
#: What can differ from UAV to UAV.
OF_A_KIND = (
    "v_max",
    "a_max",
    "j_max",
    "v_norm",
    "a_norm",
    "j_norm",
    "d_hat_min",
    "theta_inverse",
    "d_min",
    "crash_theta_inverse",
    "tracking_error",
)
_MATRICES = ("theta_inverse", "crash_theta_inverse")
#: Where ``none`` is a value.
_OPTIONAL = ("v_norm", "a_norm", "j_norm", "crash_theta_inverse", "workspace")


def _axes(value: Fraction) -> Vector:
    return (value, value, value)


def closed(box: Box, reach: Fraction = REACH) -> ClosedBox:
    """Return `box` with limits everywhere: where it has none, `reach` (m) from the other side, or from 0."""

    def sides(low: Fraction | None, high: Fraction | None) -> Limits:
        if low is None:
            return (-reach, reach) if high is None else (high - reach, high)
        return (low, low + reach) if high is None else (low, high)

    x, y, z = (sides(*one) for one in box)
    return (x, y, z)


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
    #: m; (low, high) per axis for the positions in X, a side None for no limit there; None for no restriction at all.
    workspace: Box | None = None
    #: m; the scaled distance that the real UAVs are to keep, eq. (2).
    d_min: Fraction = Fraction(3, 25)
    #: m; the bound on each UAV's distance from its reference, in no scaled norm: Δd_min of Assumption 1, eq. (6).
    tracking_error: Fraction = Fraction(0)
    #: m/s, m/s², m/s³; bounds of the Euclidean norm, beside the box per axis; None for no such bound.
    v_norm: Fraction | None = None
    a_norm: Fraction | None = None
    j_norm: Fraction | None = None
    #: the scaling of the ellipsoid that counts as a crash, for `d_min`; None where it is `theta_inverse`.
    crash_theta_inverse: Matrix | None = None
    #: s; how old what a planner knows of the other UAVs may be, beyond what the algorithm takes into account.
    delay: Fraction = Fraction(0)
    #: the names that were given, or follow from what was given; the others are the published ones, by default.
    given: frozenset[str] = field(default=frozenset(), compare=False, repr=False)

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

    def with_table(self, place: str, table: Mapping[str, object]) -> Parameters:
        """Return these parameters with the values in `table` applied, as :meth:`with_changes` does.

        Raises:
            BadInput: a name or value that cannot be; `place` says where the table is.
        """
        return self._changed((place, name, raw) for name, raw in table.items())

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
        needed = [name for name in NAMES if name not in EXTENSIONS]
        missing = [name for name in needed if name not in values]
        if missing:
            raise BadInput(f"the parameters lack {', '.join(missing)}: all of {', '.join(needed)} must be there")
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
        return replace(self, **{**self._followed(changed), **changed}, given=self.given.union(changed))

    def _followed(self, norms: Mapping[str, Any]) -> dict[str, Vector]:
        """Return the boxes that follow the `norms` where these are changed: those that nobody gave.

        Who bounds the norm only means no other box than the one around that ball, however often it is changed.
        """
        boxes = {}
        for norm, box in NORMS.items():
            before = getattr(self, norm)
            own = getattr(PUBLISHED, box) if before is None else _axes(before)
            if norm in norms and box not in self.given and getattr(self, box) == own:
                boxes[box] = getattr(PUBLISHED, box) if norms[norm] is None else _axes(norms[norm])
        return boxes

    def defaults(self) -> list[str]:
        """Return the names of the published values that stand where none was given and that have a meaning here.

        Nobody gives what the paper does not have (:data:`EXTENSIONS`) by leaving it out.
        """
        followed = [box for norm, box in NORMS.items() if getattr(self, norm) is not None]
        without_meaning = (*EXTENSIONS, *followed, *(("j_max",) if self.order == 2 else ()))
        return [name for name in NAMES if name not in self.given and name not in without_meaning]

    def text(self, name: str) -> str:
        """Return the value of the parameter `name` as ``--set`` takes it."""
        return _compact(name, getattr(self, name))

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
        return {name: _nested(getattr(self, name), float) for name in self._written()}

    def as_exact(self) -> dict[str, Any]:
        """Return the values by name as nested lists of exact texts such as ``"0.05"`` and ``"1/6"`` (order: an int)."""
        return {name: _nested(getattr(self, name), exact_text) for name in self._written()}

    def _written(self) -> list[str]:
        """Return the names of what is written down: an extension only where it is used."""
        return [name for name in NAMES if name not in EXTENSIONS or getattr(self, name) != getattr(PUBLISHED, name)]

    def differences(self, base: Parameters | None = None) -> list[str]:
        """Return the shortest ``NAME=VALUE`` texts with which :meth:`with_changes` makes self of `base` (published)."""
        base = Parameters() if base is None else base
        followed = replace(base, T_s=self.T_s, T_b=self.T_s) if base.T_b == base.T_s else base
        norms = {norm: getattr(self, norm) for norm in NORMS if getattr(self, norm) != getattr(base, norm)}
        boxes = base._followed(norms)
        return [
            f"{name}={_compact(name, getattr(self, name))}"
            for name in NAMES
            if getattr(self, name) != getattr(followed if name == "T_b" else base, name)
            # a box as before is no difference, unless a norm would change it
            or getattr(self, name) != boxes.get(name, getattr(self, name))
        ]

    def describe(self, base: Parameters | None = None) -> str:
        """Return what differs from `base` (the published parameters), such as ``T_c=0.05, v_max=1``; may be empty."""
        return ", ".join(self.differences(base))


#: The names of the parameters, in the order in which they are shown.
NAMES: tuple[str, ...] = tuple(one.name for one in fields(Parameters) if one.name != "given")
#: What the paper does not have: written down only where it is used.
EXTENSIONS = ("v_norm", "a_norm", "j_norm", "crash_theta_inverse", "delay")
#: By bound of a norm, the bound per axis beside it.
NORMS = {"v_norm": "v_max", "a_norm": "a_max", "j_norm": "j_max"}


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


def _read(name: str, raw: object) -> object:
    """Return `raw` in the shape of parameter `name`; raise :class:`BadInput` if it has no such shape."""
    word = raw.strip() if isinstance(raw, str) else ""
    if name in _OPTIONAL and (raw is None or word == "none" or (name in NORMS and word in ("inf", "+inf"))):
        return None
    if name == "workspace":
        return _read_box(raw)
    try:
        numbers, pattern = _flat(raw, lambda one: read_number(one, _MAGNITUDES.get(name, QUANTITY)))
    except BadInput as mistake:
        raise BadInput(f"{name}: {mistake}") from None
    if name in _MATRICES:
        if pattern == "1":
            return diagonal(_axes(numbers[0]))
        if pattern == "3":
            return diagonal((numbers[0], numbers[1], numbers[2]))
        if pattern not in ("9", "rows of 3 3 3"):
            raise BadInput(f"{name} takes 1 number, the 3 of its diagonal or all 9, row by row, such as 1,1,1/6")
        return tuple(tuple(numbers[row : row + 3]) for row in (0, 3, 6))
    if name in _BOUNDS:
        if pattern not in ("1", "3"):
            raise BadInput(
                f"{name} takes one number, or three for x, y and z, such as 1,1,0.5{_per_uav(name, pattern)}"
            )
        return _axes(numbers[0]) if pattern == "1" else tuple(numbers)
    if pattern != "1":
        example = _compact(name, getattr(PUBLISHED, name) or Fraction(1))
        raise BadInput(f"{name} takes one number, such as {example}{_per_uav(name, pattern)}")
    if name in NORMS and numbers[0] >= NO_LIMIT:
        return None
    return int(numbers[0]) if name == "order" and numbers[0].denominator == 1 else numbers[0]


def _per_uav(name: str, pattern: str) -> str:
    """Return how to give a value per UAV, which is what a list of another length is likely to be meant as."""
    if name not in OF_A_KIND or pattern.startswith("rows") or pattern == "0":
        return ""
    return f"; UAVs that differ are of [[kinds]]: a line [[kinds]], and lines uavs = [0, 3] and {name} = 0.5 below it"


def _read_box(raw: object) -> Box:
    """Return the flying space in `raw`; a side that is ``inf`` or ``none`` is no limit."""
    parts, pattern = _flat(raw, lambda one: one)
    if pattern not in ("6", "rows of 2 2 2"):
        raise BadInput("workspace takes low and high for x, y and z, such as [[-2, 2], [-2, 2], [0, inf]], or none")
    try:
        x, y, z = ((read_side(low, -1), read_side(high, 1)) for low, high in zip(parts[::2], parts[1::2], strict=True))
    except BadInput as mistake:
        raise BadInput(f"workspace: {mistake}") from None
    return (x, y, z)


def _flat(raw: object, read: Callable[[object], Part]) -> tuple[list[Part], str]:
    """Return the parts of `raw` and their grouping: ``"3"`` for three, ``"rows of 3 3 3"`` for lists of lists."""
    parts: object = raw.split(",") if isinstance(raw, str) else raw
    if not isinstance(parts, Sequence) or isinstance(parts, str):
        return [read(parts)], "1"
    if len(parts) > 9:
        return [], "too many"
    if not any(isinstance(part, list) for part in parts):
        return [read(part) for part in parts], str(len(parts))
    rows = [part if isinstance(part, list) else [part] for part in parts]
    if any(len(row) > 3 for row in rows):
        return [], "too many"
    lengths = " ".join(str(len(row)) for row in rows)
    return [read(entry) for row in rows for entry in row], f"rows of {lengths}"


def _check(name: str, value: Any) -> None:
    """Raise :class:`BadInput` if parameter `name` cannot be `value`."""
    if name in _PERIODS_AND_DISTANCES and value <= 0:
        raise BadInput(f"{name} must be positive, not {exact_text(value)}")
    if (name in ("tracking_error", "delay") or name in NORMS) and value is not None and value < 0:
        raise BadInput(f"{name} must not be negative, as {exact_text(value)} is")
    if name in _BOUNDS and min(value) < 0:
        raise BadInput(f"{name} must not be negative on any axis, as {exact_text(min(value))} is")
    if name == "order" and value not in (2, 3):
        raise BadInput(f"order is 2 (input acceleration) or 3 (input jerk), not {exact_text(Fraction(value))}")
    if name in _MATRICES and value is not None:
        _check_definite(name, value)
    if name == "workspace" and value is not None:
        for axis, (low, high) in zip("xyz", value, strict=True):
            if low is not None and high is not None and low > high:
                raise BadInput(
                    f"workspace has a low {axis}={exact_text(low)} above its high {axis}={exact_text(high)}: "
                    "write the lower one first, such as [-2, 2]"
                )


def _check_definite(name: str, matrix: Matrix) -> None:
    (a, b, c), (d, e, f), (g, h, i) = matrix
    if (b, c, f) != (d, g, h):
        raise BadInput(f"{name} is not symmetric: entry (row, column) must equal entry (column, row)")
    # Sylvester: a symmetric matrix is positive definite iff its leading minors are positive
    minor = a * e - b * d
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    if determinant == 0:
        raise BadInput(f"{name} is singular: it must be invertible, as Θ⁻¹ scales every direction")
    if not (a > 0 and minor > 0 and determinant > 0):
        raise BadInput(f"{name} is not positive definite: all its eigenvalues must be positive")


def _nested(value: Any, leaf: Any) -> Any:
    if isinstance(value, tuple):
        return [_nested(part, leaf) for part in value]
    return leaf(value) if isinstance(value, Fraction) else value


def _compact(name: str, value: Any) -> str:
    """Return the shortest text that :func:`_read` reads as `value`."""
    if value is None:
        return "none"
    if name in _MATRICES and value == diagonal((value[0][0], value[1][1], value[2][2])):
        value = tuple(value[axis][axis] for axis in range(3))
    if not isinstance(value, tuple):
        return exact_text(Fraction(value))
    parts = [part for row in value for part in (row if isinstance(row, tuple) else (row,))]
    texts = ["none" if part is None else exact_text(part) for part in parts]
    return texts[0] if len(parts) == 3 and len(set(parts)) == 1 else ",".join(texts)


#: The published parameters (Section 5).
PUBLISHED = Parameters()
