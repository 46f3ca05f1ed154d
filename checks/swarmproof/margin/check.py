"""An exact checker of margin certificates. It follows docs/margin.md, which has the argument, section by section.

It imports nothing of this project, so that no error in what computes a margin can make a wrong certificate pass.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise, product
from math import factorial, gcd, lcm, perm
from typing import Any, TypeVar

SCHEMA = "swarmproof.margin-certificate/1"
READINGS = ("initial-state", "whole-motion", "as-sampled")
PARAMETERS = "T_c T_s T_b d_hat_min v_max a_max j_max theta_inverse order workspace d_min tracking_error"
NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+|/0*[1-9][0-9]*)?")
#: Beyond these a certificate is absurd: characters of a number, depth of a tree, sampling instants or windows in T_s.
LONGEST_NUMBER, DEEPEST_TREE, MOST_IN_PERIOD = 1000, 200, 10_000
MOST_HALVINGS = 10  #: of a piece with cubic positions, to show that it stays in the workspace

Vector = tuple[Fraction, ...]
#: A corner (δ, g) as the integers (Wδ, Wg, W), W > 0: as exact as fractions, and faster.
Corner = tuple[int, int, int]
Polygon = list[Corner]
Number = TypeVar("Number", int, Fraction)


class Rejected(Exception):
    """A certificate does not prove what it claims; the message says where, and what is wrong."""


@dataclass(frozen=True)
class Verified:
    """What a certificate proves, in units of ‖Θ⁻¹(p̂_i − p̂_j)‖, and how many leaves, cells and windows that took."""

    lower: Fraction
    upper: Fraction
    leaves: int
    cells: int
    windows: int


@contextmanager
def _in(where: str) -> Iterator[None]:
    """Let what is rejected within say where."""
    try:
        yield
    except Rejected as error:
        raise Rejected(f"{where}, {error}") from None


def _need(condition: bool, what: str) -> None:
    if not condition:
        raise Rejected(what)


def _object(value: object, keys: str) -> dict[str, Any]:
    if not isinstance(value, dict) or value.keys() != set(keys.split()):
        raise Rejected(f"expected an object with these keys and no others: {keys}")
    return value


def _list(inside: Any, key: str | int, length: int | None = None) -> list[Any]:
    value = inside[key]
    if not isinstance(value, list) or length not in (None, len(value)):
        raise Rejected(f"{key}: expected a list{'' if length is None else f' of length {length}'}")
    return value


def _integer(inside: Any, key: str | int, low: int, high: int) -> int:
    value = inside[key]
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise Rejected(f"{key}: expected an integer from {low} to {high}")
    return value


@lru_cache(maxsize=1 << 16)
def _parse(text: str) -> Fraction | None:
    return Fraction(text) if len(text) <= LONGEST_NUMBER and NUMBER.fullmatch(text) else None


def _number(inside: Any, key: str | int) -> Fraction:
    value = inside[key]
    number = _parse(value) if isinstance(value, str) else None
    if number is None:
        raise Rejected(f"{key}: expected a number as a string, an exact decimal or a fraction")
    return number


def _numbers(inside: Any, key: str | int, length: int) -> Vector:
    value = _list(inside, key, length)
    with _in(str(key)):
        return tuple(_number(value, i) for i in range(length))


def read(text: str | bytes) -> object:
    """Decode the JSON text of a certificate; raise `Rejected` if it is none."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:  # not JSON, not Unicode, an integer of thousands of digits, too deep
        raise Rejected(f"the certificate is not JSON that can be read ({error})") from None


def _digest(certificate: dict[str, Any]) -> str:
    rest = {key: value for key, value in certificate.items() if key != "digest"}
    try:
        return hashlib.sha256(json.dumps(rest, sort_keys=True, separators=(",", ":")).encode("ascii")).hexdigest()
    except (TypeError, ValueError, RecursionError) as error:  # too deep, or never was JSON
        raise Rejected(f"the certificate cannot be written as JSON ({error})") from None


def _dot(left: Iterable[Fraction], right: Iterable[Fraction]) -> Fraction:
    return sum((a * b for a, b in zip(left, right, strict=True)), Fraction(0))


def _times(x: Fraction, scale: int) -> int:
    """Return x·scale, where the scale is a multiple of x's denominator: much faster than a product of fractions."""
    return x.numerator * (scale // x.denominator)


def _square(gram: Iterable[Number], x: Number, y: Number, z: Number) -> Number:
    """Return ‖A(x, y, z)‖², where `gram` is the upper triangle of AᵀA, by rows."""
    xx, xy, xz, yy, yz, zz = gram
    return xx * x * x + yy * y * y + zz * z * z + 2 * (xy * x * y + xz * x * z + yz * y * z)


# ---- From two UAVs to one relative motion ----
@dataclass(frozen=True)
class _Problem:
    reading: str
    order: int
    span: Fraction  #: T_c
    period: Fraction  #: how long a motion lasts: T_s for `as-sampled`, otherwise T_c
    windows: int  #: how many windows it has
    until: Fraction  #: the states in [0, until] are bounded,
    step: Fraction  #: all of them if this is 0, otherwise those at its multiples
    distance: Fraction  #: d̂_min
    gram: Vector  #: the upper triangle of AᵀA = A², as A = Θ⁻¹ is symmetric
    decoupled: bool  #: whether Θ⁻¹ is diagonal
    workspace: list[Vector] | None
    bounds: list[Vector]  #: of the relative motion, twice a UAV's: by axis and derivative, the last is the input


def _problem(raw: dict[str, Any], reading: str) -> _Problem:
    order = _integer(raw, "order", 2, 3)
    span, period, step, distance = (_number(raw, key) for key in ("T_c", "T_s", "T_b", "d_hat_min"))
    _need(min(span, period, step, distance) > 0, "T_c, T_s, T_b and d_hat_min must be positive")
    limits = [_numbers(raw, key, 3) for key in ("v_max", "a_max", "j_max")]
    limits_and_unused = [*limits, *((_number(raw, key),) for key in ("d_min", "tracking_error"))]
    _need(min(map(min, limits_and_unused)) >= 0, "a bound, d_min or tracking_error is negative")
    (a, b, c), (b_, d, e), (c_, e_, f) = rows = [_numbers(_list(raw, "theta_inverse", 3), i, 3) for i in range(3)]
    minors = (a, a * d - b * b, a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d))
    _need((b, c, e) == (b_, c_, e_) and min(minors) > 0, "theta_inverse is not symmetric positive definite")
    gram = tuple(_dot(rows[i], rows[k]) for i in range(3) for k in range(i, 3))

    # Without a workspace no position is bounded. None needs to be: in a proof the coefficient of w(0) is then 0.
    workspace, widths = None, [Fraction(0)] * 3
    if raw["workspace"] is not None:
        workspace = [_numbers(_list(raw, "workspace", 3), k, 2) for k in range(3)]
        widths = [high - low for low, high in workspace]
        _need(min(widths) >= 0, "workspace: a low is above its high")
    bounds = [(widths[k], *(2 * limit[k] for limit in limits[:order])) for k in range(3)]

    until = {"initial-state": Fraction(0), "whole-motion": span, "as-sampled": period}[reading]
    if reading == "as-sampled":
        _need((period / span).denominator == 1, "T_s is not a multiple of T_c")
        _need((period / step).denominator == 1, "T_s is not a multiple of T_b")
        _need(period <= MOST_IN_PERIOD * min(span, step), "T_s is absurdly long")
    else:
        period, step = span, Fraction(0)
    windows, decoupled = int(period / span), b == c == e == 0
    return _Problem(reading, order, span, period, windows, until, step, distance, gram, decoupled, workspace, bounds)


# ---- The witness: two motions that come that close ----
def _after(state: Vector, s: Fraction) -> Vector:
    """Return all derivatives, the last is the constant input, after time s: Taylor's formula, exact here."""
    powers = [s**j / factorial(j) for j in range(len(state))]
    return tuple(_dot(state[k:], powers[: len(state) - k]) for k in range(len(state)))


def _stays(state: Vector, duration: Fraction, low: Fraction, high: Fraction, halvings: int) -> bool:
    """Return whether Bernstein coefficients, here or of halves, show that a cubic position stays in [low, high]."""
    c = [duration**j / factorial(j) * x for j, x in enumerate(state)]
    bernstein = (c[0], c[0] + c[1] / 3, c[0] + (2 * c[1] + c[2]) / 3, sum(c, Fraction(0)))
    if halvings == 0 or low <= min(bernstein) <= max(bernstein) <= high:
        return low <= min(bernstein) <= max(bernstein) <= high
    halves = (state, _after(state, duration / 2))
    return low <= bernstein[3] <= high and all(_stays(x, duration / 2, low, high, halvings - 1) for x in halves)


def _motion(value: object, problem: _Problem, k: int) -> list[tuple[Fraction, Fraction, Vector]]:
    """Return the motion of a UAV along axis k by pieces (start, end, state), if it keeps the bounds of the reading."""
    raw, limits = _object(value, "state inputs"), [bound / 2 for bound in problem.bounds[k]]
    state, now, inputs, pieces = _numbers(raw, "state", problem.order), Fraction(0), _list(raw, "inputs"), []
    for i in range(len(inputs)):
        duration, constant = _numbers(inputs, i, 2)
        _need(duration > 0 and abs(constant) <= limits[-1], f"input {i} lasts no time or is beyond its bound")
        state = (*state, constant)
        if problem.reading == "as-sampled":
            _need(i == 0 and duration == problem.period, "it has not one input that lasts T_s")
            times = [j * problem.step for j in range(int(duration / problem.step) + 1)]
        elif problem.reading == "whole-motion":  # all but a cubic position have their extremes at an end, or at a turn
            turn = -state[-2] / constant if constant else Fraction(0)
            times = [Fraction(0), duration, *([turn] if 0 < turn < duration else [])]
        else:
            times = [Fraction(0)] if i == 0 else []
        states = [_after(state, time) for time in times]
        kept = all(abs(x[d]) <= limits[d] for x in states for d in range(1, problem.order))
        _need(kept, f"velocity or acceleration is beyond its bound during input {i}")
        if problem.workspace is not None:
            low, high = problem.workspace[k]
            _need(all(low <= x[0] <= high for x in states), f"it leaves the workspace during input {i}")
            if problem.reading == "whole-motion" and problem.order == 3:
                stays = _stays(state, duration, low, high, MOST_HALVINGS)
                _need(stays, f"it is not shown to stay in the workspace during input {i}")
        pieces.append((now, now + duration, state))
        state, now = _after(state, duration)[:-1], now + duration
    _need(now == problem.period, "the inputs do not last as long as the motion")
    return pieces


def _check_witness(value: object, problem: _Problem, lower: Fraction) -> None:
    raw = _object(value, "window tau uav_i uav_j")
    start = _integer(raw, "window", 0, problem.windows - 1) * problem.span
    tau, motions = _number(raw, "tau"), []
    _need(0 <= tau <= problem.span, "tau is not in the window")
    for uav, k in product(("uav_i", "uav_j"), range(3)):
        with _in(f"{uav}, axis {k}"):
            motions.append(_motion(_list(raw, uav, 3)[k], problem, k))

    def squared(time: Fraction) -> Fraction:
        pieces = [next(piece for piece in motion if time <= piece[1]) for motion in motions]
        at = [_after(state, time - begin)[0] for begin, _, state in pieces]
        return _square(problem.gram, at[0] - at[3], at[1] - at[4], at[2] - at[5])

    ends = min(squared(start), squared(start + problem.span))
    _need(ends >= problem.distance**2, "the UAVs are closer than d_hat_min at an end of the window")
    _need(squared(start + tau) <= (problem.distance - lower) ** 2, "the UAVs are not as close at tau as lower claims")


# ---- The polygons: half-planes with proofs ----
def _weights(problem: _Problem, start: Fraction, tau: Fraction, direction: Vector, proof: list[Any]) -> Vector:
    """Return what each bound, by derivative with the input last, is multiplied with in the bound of αδ + βg at tau.

    αδ + βg minus multipliers is a sum of terms c·w^(d)(t), kept in integers: t in 1/`unit`, c in 1/`whole`.
    """
    (alpha, beta), order, lowest = direction, problem.order, 1 if problem.workspace is None else 0
    end, share = start + problem.span, tau / problem.span
    rest = [(start, 0, beta * (1 - share) - alpha), (end, 0, beta * share + alpha), (start + tau, 0, -beta)]
    points, paid, spread = [], [0] * (order + 1), [Fraction(0)] * (order + 1)
    for i, one in enumerate(proof):
        if len(_list(proof, i)) == 5:
            d, (low, high, first, last) = _integer(one, 2, 1, order - 1), [_number(one, j) for j in (0, 1, 3, 4)]
            _need(problem.reading == "whole-motion" and 0 <= low < high <= problem.span, "a density has no such times")
            _need(d == 2 or first == last, "a density for derivative 1 has different rates")
            spread[d] += (abs(first) + abs(last)) / 2 * (high - low)
            slope = (last - first) / (high - low)  # integrated by parts, a density is such terms, too
            rest += [(high, d - 1, -last), (low, d - 1, first), (high, 0, slope), (low, 0, -slope)]
        else:
            one = _list(proof, i, 3)
            points.append((_number(one, 0), _integer(one, 1, lowest, order - 1), _number(one, 2)))
    unit = lcm(problem.step.denominator, problem.until.denominator, *(t.denominator for t, _, _ in (*rest, *points)))
    whole = lcm(*(c.denominator for _, _, c in (*rest, *points)))
    terms = [(_times(t, unit), d, _times(c, whole)) for t, d, c in rest]
    until, step = _times(problem.until, unit), _times(problem.step, unit) or 1
    for time, d, nu in points:
        t, c = _times(time, unit), _times(nu, whole)
        _need(c == 0 or (0 <= t <= until and t % step == 0), "a multiplier is at a time when nothing is bounded")
        paid[d] += abs(c)
        terms.append((t, d, -c))
    # What is left has at w^(k)(0) the coefficient that it yields for the motion t^k/k!; for k = order this is ∫q.
    powers = [sum(c * unit**d * perm(k, d) * t ** (k - d) for t, d, c in terms if d <= k) for k in range(order + 1)]
    left = [Fraction(abs(power), whole * unit**k * factorial(k)) for k, power in enumerate(powers)]
    if problem.reading != "as-sampled":
        left[order] = Fraction(_integral(order, unit, terms), 6 * whole * unit**order * factorial(order - 1))
    return tuple(Fraction(paid[k], whole) + spread[k] + left[k] for k in range(order + 1))


def _integral(order: int, unit: int, terms: list[tuple[int, int, int]]) -> int:
    """Return a bound of 6∫|q| for q(s), the sum of c·unit^d·(d/dt)^d (t − s)^(order − 1) over the terms with t > s ≥ 0.

    From piece to piece, the last first, q is k0 + k1·s + k2·s² (also for order 2, where k2 = 0). Its Bernstein
    coefficients on [low, high] are its polar form at (low, low), (low, high) and (high, high).
    """
    k0 = k1 = k2 = total = 0
    later = sorted((term for term in terms if term[0] > 0), reverse=True)
    for (high, d, c), (low, _, _) in pairwise([*later, (0, 0, 0)]):
        c *= unit**d * perm(order - 1, d)
        f0, f1, f2 = ((1, 0, 0), (high, -1, 0), (high * high, -2 * high, 1))[order - 1 - d]
        k0, k1, k2 = k0 + c * f0, k1 + c * f1, k2 + c * f2
        polar = [2 * k0 + k1 * (x + y) + 2 * k2 * x * y for x, y in ((low, low), (low, high), (high, high))]
        total += (high - low) * sum(map(abs, polar))
    return total


def _clip(polygon: Polygon, a: Fraction, b: Fraction, c: Fraction) -> Polygon:
    """Return the part of a convex polygon in which aδ + bg ≤ c; without corners if it is empty."""
    scale = lcm(a.denominator, b.denominator, c.denominator)
    na, nb, nc = _times(a, scale), _times(b, scale), _times(c, scale)
    values, kept = [na * x + nb * y - nc * w for x, y, w in polygon], []
    for i, (corner, value) in enumerate(zip(polygon, values, strict=True)):
        before, value_before = polygon[i - 1], values[i - 1]
        if value < 0 < value_before or value_before < 0 < value:  # the line crosses this side
            x, y, w = (abs(value_before) * p + abs(value) * q for p, q in zip(corner, before, strict=True))
            common = gcd(x, y, w)
            kept.append((x // common, y // common, w // common))
        if value <= 0:
            kept.append(corner)
    return kept


def _polygon(offsets: dict[Vector, Fraction]) -> Polygon:
    """Return the corners of the polygon with |αδ + βg| ≤ offset for each direction (α, β)."""
    _need({(1, 0), (0, 1)} <= offsets.keys(), "(1, 0) or (0, 1) is not among the directions")
    far, off = offsets[Fraction(1), Fraction(0)], offsets[Fraction(0), Fraction(1)]
    scale = lcm(far.denominator, off.denominator)
    x, y = _times(far, scale), _times(off, scale)
    polygon = [(x, y, scale), (-x, y, scale), (-x, -y, scale), (x, -y, scale)]
    for (alpha, beta), offset in offsets.items():
        polygon = _clip(_clip(polygon, alpha, beta, offset), -alpha, -beta, offset)
    return polygon


# ---- Cells, trees and leaves: ends are (τ₁, τ₂), polygons those of x, y, z ----
def _polygons(problem: _Problem, start: Fraction, ends: Vector, raw: dict[str, Any]) -> list[Polygon]:
    """Return the polygons that hold in all of a cell of the window that begins at `start`."""
    # By list and edge: the direction, and the weights of the bounds at the cell's two ends. They hold for all axes.
    lists: list[list[tuple[Vector, list[Vector]]]] = [[] for _ in _list(raw, "edges")]
    for i, edges in enumerate(lists):
        for number, one in enumerate(_list(raw["edges"], i)):
            with _in(f"list {i} of edges, edge {number}"):
                edge = _object(one, "direction proofs")
                way, proofs = _numbers(edge, "direction", 2), _list(edge, "proofs", 2)
                _need(any(way), "the direction is (0, 0)")
                edges.append((way, [_weights(problem, start, ends[n], way, _list(proofs, n)) for n in (0, 1)]))
    polygons, known = [], dict[tuple[int, Vector], Polygon]()  # axes with equal bounds share polygons
    for k, bounds in enumerate(problem.bounds):
        i = _integer(_list(raw, "axes", 3), k, 0, len(lists) - 1)
        # Times between: bounds[2] is the acceleration's, which is the input if the order is 2.
        grows = problem.span * bounds[3] if (problem.reading, problem.order) == ("initial-state", 3) else 0
        e = (bounds[2] + grows) * (ends[1] - ends[0]) ** 2 / 8
        if (i, bounds) not in known:
            offsets = {way: max(_dot(one, bounds) for one in two) + abs(way[1]) * e for way, two in lists[i]}
            known[i, bounds] = _polygon(offsets)
        half = _clip(known[i, bounds], Fraction(-1), Fraction(0), Fraction(0))
        polygons.append(half if k == 0 or problem.decoupled else known[i, bounds])
    return polygons


def _check_tree(problem: _Problem, rho: Fraction, ends: Vector, tree: Any, polygons: list[Polygon], depth: int) -> int:
    """Check that the distance ρ is kept; return the number of leaves, those in empty parts left out."""
    if not all(polygons):
        return 0
    _need(depth <= DEEPEST_TREE, "the tree is too deep")
    if isinstance(tree, dict) and "t" in tree:
        _check_leaf(problem, rho, ends, _number(_object(tree, "t"), "t"), polygons)
        return 1
    raw, leaves = _object(tree, "axis normal at below above"), 0
    k, (a, b), c = _integer(raw, "axis", 0, 2), _numbers(raw, "normal", 2), _number(raw, "at")
    _need(bool(a or b), "the normal is (0, 0)")
    for side, part in (("below", _clip(polygons[k], a, b, c)), ("above", _clip(polygons[k], -a, -b, -c))):
        with _in(side):
            leaves += _check_tree(problem, rho, ends, raw[side], [*polygons[:k], part, *polygons[k + 1 :]], depth + 1)
    return leaves


def _check_leaf(problem: _Problem, rho: Fraction, ends: Vector, t: Fraction, polygons: list[Polygon]) -> None:
    """Check (*) ≥ ρ at all corners, without roots."""
    low, high, half = ends[0] / problem.span + t, ends[1] / problem.span + t, Fraction(1, 2)
    _need(0 <= low <= high <= 1, "a weight is not in [0, 1]")
    kappa = half * half if low <= half <= high else max(low * (1 - low), high * (1 - high))
    # In integers, for speed: lengths, here of pairs (δ, g + tδ), in 1/`unit`; U, κ‖Aδ‖², d² and ρ² in 1/(unit²·whole).
    p, q = t.numerator, t.denominator
    unit = q * lcm(*(w for polygon in polygons for _, _, w in polygon))
    axes = [[(x * (unit // w), (y * q + x * p) * (unit // (w * q))) for x, y, w in polygon] for polygon in polygons]
    axes = [_foremost(pairs) if problem.decoupled else pairs for pairs in axes]
    common = gcd(unit, *(length for pairs in axes for pair in pairs for length in pair))
    unit //= common
    corners = product(*([(x // common, y // common) for x, y in pairs] for pairs in axes))
    gram, stretched = problem.gram, tuple(kappa * g for g in problem.gram)
    whole = lcm(*(number.denominator for number in (*gram, *stretched, problem.distance**2, rho**2)))
    of_u, of_delta = ([_times(g, whole) for g in numbers] for numbers in (gram, stretched))
    d_squared, rho_squared = (_times(x**2, whole) * unit**2 for x in (problem.distance, rho))
    for (x0, y0), (x1, y1), (x2, y2) in corners:
        u = _square(of_u, y0, y1, y2)
        left = d_squared - _square(of_delta, x0, x1, x2) - u - rho_squared
        _need(left >= 0 and 4 * rho_squared * u <= left**2, "a pair of motions may come closer than upper claims")


def _foremost(pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Drop pairs that another one exceeds in both: if Θ⁻¹ is diagonal, |δ_k| and |g_k + tδ_k| only make (*) smaller."""
    kept: list[tuple[int, int]] = []
    for x, y in sorted(((abs(x), abs(y)) for x, y in pairs), reverse=True):
        if not kept or y > kept[-1][1]:
            kept.append((x, y))
    return kept


def check(certificate: object, progress: Callable[[int, int], None] | None = None) -> Verified:
    """Check a certificate, decoded from JSON; return what it proves, or raise `Rejected` if it claims something else.

    `progress` is called after every cell, with the number of cells checked and that of all cells.
    """
    raw = _object(certificate, "schema parameters reading dip witness windows digest")
    _need(raw["schema"] == SCHEMA, f"schema: expected {SCHEMA}")
    _need(raw["digest"] == _digest(raw), "digest: it is not that of the certificate's content")
    _need(raw["reading"] in READINGS, f"reading: expected one of {', '.join(READINGS)}")
    with _in("parameters"):
        problem = _problem(_object(raw["parameters"], PARAMETERS), raw["reading"])
    with _in("dip"):
        lower, upper = (_number(_object(raw["dip"], "lower upper"), key) for key in ("lower", "upper"))
        _need(0 <= lower <= upper <= problem.distance, "0 <= lower <= upper <= d_hat_min does not hold")
    with _in("witness"):
        if raw["witness"] is not None:
            _check_witness(raw["witness"], problem, lower)
        _need(raw["witness"] is not None or lower == 0, "there is none, but lower is above 0")
    if raw["windows"] is None:
        _need(upper == problem.distance, "windows: there are none, but upper is below d_hat_min")
        return Verified(lower, upper, 0, 0, 0)

    windows = [_object(one, "window cells") for one in _list(raw, "windows")]
    present = {_integer(one, "window", 0, problem.windows - 1) for one in windows}
    _need(len(present) == len(windows), "windows: one of them is there twice")
    for m in range(problem.windows):
        _need(m in present or problem.windows - 1 - m in present, f"windows: {m} or its mirror image is missing")
    leaves, done, total = 0, 0, sum(len(_list(one, "cells")) for one in windows)
    for m, cells in ((one["window"], one["cells"]) for one in windows):
        reached = Fraction(0)
        for number, one in enumerate(cells):
            with _in(f"window {m}, cell {number} from {reached}"):
                cell = _object(one, "from to edges axes tree")
                first, last = _number(cell, "from"), _number(cell, "to")
                _need(first == reached, "it does not start where the cell before it ends")
                _need(first < last <= problem.span, "it ends before it starts, or after the window")
                polygons = _polygons(problem, m * problem.span, (first, last), cell)
                with _in("tree"):
                    leaves += _check_tree(problem, problem.distance - upper, (first, last), cell["tree"], polygons, 0)
            reached, done = last, done + 1
            if progress is not None:
                progress(done, total)
        _need(reached == problem.span, f"window {m}: its cells do not reach the window's end")
    return Verified(lower, upper, leaves, total, len(windows))
