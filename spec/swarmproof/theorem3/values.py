"""The values of parameters: their shapes, how they are read and checked, and how they are written again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, TypeVar

from swarmproof.errors import BadInput
from swarmproof.theorem3.numbers import (
    BOUND,
    ENTRY,
    NO_LIMIT,
    QUANTITY,
    Magnitude,
    exact_text,
    read_number,
    read_side,
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
#: By bound of a norm, the bound per axis beside it.
NORMS = {"v_norm": "v_max", "a_norm": "a_max", "j_norm": "j_max"}
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


def axes(value: Fraction) -> Vector:
    """Return `value` on all axes."""
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


def read_value(name: str, raw: object, example: str) -> object:
    """Return `raw` in the shape of parameter `name`; `example` is a value that would be right.

    Raises:
        BadInput: it has no such shape.
    """
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
            return diagonal(axes(numbers[0]))
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
        return axes(numbers[0]) if pattern == "1" else tuple(numbers)
    if pattern != "1":
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


def check_value(name: str, value: Any) -> None:
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


def nested(value: Any, leaf: Any) -> Any:
    """Return `value` with lists for tuples and `leaf` of each fraction in it."""
    if isinstance(value, tuple):
        return [nested(part, leaf) for part in value]
    return leaf(value) if isinstance(value, Fraction) else value


def compact(name: str, value: Any) -> str:
    """Return the shortest text that :func:`read_value` reads as `value`."""
    if value is None:
        return "none"
    if name in _MATRICES and value == diagonal((value[0][0], value[1][1], value[2][2])):
        value = tuple(value[axis][axis] for axis in range(3))
    if not isinstance(value, tuple):
        return exact_text(Fraction(value))
    parts = [part for row in value for part in (row if isinstance(row, tuple) else (row,))]
    texts = ["none" if part is None else exact_text(part) for part in parts]
    return texts[0] if len(parts) == 3 and len(set(parts)) == 1 else ",".join(texts)
