"""The parameters of a margin certificate, its relative motion and its witness, checked exactly. See `margin.check`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, product
from math import comb, factorial
from typing import Any

from swarmproof.margin.check_numbers import (
    Vector,
    dot,
    integer,
    list_of,
    located,
    need,
    number_of,
    numbers_of,
    object_of,
    root_above,
    square,
)

PARAMETERS = "T_c T_s T_b d_hat_min v_max a_max j_max theta_inverse order workspace d_min tracking_error"
NORMS = ("v_norm", "a_norm", "j_norm")
#: Parameters that a certificate has only if they are used, and only with the schema /2.
EXTENSIONS = (*NORMS, "crash_theta_inverse", "delay")
MOST_IN_PERIOD = 10_000  #: sampling instants or windows in T_s; more are absurd
MOST_HALVINGS = 10  #: of a piece with cubic positions or quartic squares of speeds, to show that it keeps a bound

#: The motion of a UAV along an axis by pieces (start, end, state with the constant input last).
Motion = list[tuple[Fraction, Fraction, Vector]]
Side = Fraction | None  #: of a workspace, None if it is open


# ---- From two UAVs to one relative motion ----
@dataclass(frozen=True)
class Problem:
    """What a certificate is about: its reading and parameters, and the bounds of the relative motion."""

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
    workspace: list[tuple[Side, Side]] | None
    bounds: list[Vector]  #: of the relative motion, twice a UAV's: by axis and derivative, the last is the input
    norms: tuple[Fraction | None, ...]  #: of a UAV's velocity, acceleration and jerk, by derivative from 1 to the order
    ball: Vector  #: bounds of the scalar motions e·w, |e| = 1: by derivative, the last is the input

    def bend(self, bounds: Vector) -> Fraction:
        """Return what bounds a second derivative (for order 2 the input) in a window."""
        grows = self.reading == "initial-state" and self.order == 3
        return bounds[2] + self.span * bounds[3] if grows else bounds[2]


def parameters_of(value: object, extended: bool) -> dict[str, Any]:
    """Return what must be an object with the parameters of the schema /1 or, if `extended`, of /2."""
    if not extended or not isinstance(value, dict):
        return object_of(value, PARAMETERS)
    present = [key for key in EXTENSIONS if key in value]
    raw = object_of(value, " ".join([PARAMETERS, *present]))
    sides = [] if raw["workspace"] is None else [side for k in range(3) for side in _sides(raw, k)]
    used = None in sides or any(raw[key] is not None for key in present)
    need(used, "neither a bound of the norm nor an open side is used, nor anything else that the schema /2 is for")
    return raw


def _sides(raw: Any, k: int) -> list[Any]:
    return list_of(list_of(raw, "workspace", 3), k, 2)


def _scaling(raw: Any, key: str) -> list[Vector]:
    (a, b, c), (b_, d, e), (c_, e_, f) = rows = [numbers_of(list_of(raw, key, 3), i, 3) for i in range(3)]
    minors = (a, a * d - b * b, a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d))
    need((b, c, e) == (b_, c_, e_) and min(minors) > 0, f"{key} is not symmetric positive definite")
    return rows


def _check_unused(raw: dict[str, Any]) -> None:
    """Check the form of the extensions that no dip depends on."""
    if raw.get("crash_theta_inverse") is not None:
        _scaling(raw, "crash_theta_inverse")
    if "delay" in raw:
        need(number_of(raw, "delay") >= 0, "delay is negative")


def _norms(raw: dict[str, Any]) -> tuple[Fraction | None, ...]:
    norms = [None if raw.get(key) is None else number_of(raw, key) for key in NORMS]
    need(min([norm for norm in norms if norm is not None], default=0) >= 0, "a bound of the norm is negative")
    return tuple(norms)


def _workspace(raw: dict[str, Any], extended: bool) -> list[tuple[Side, Side]]:
    """Return the low and the high side by axis; only if `extended`, one may be open."""
    workspace: list[tuple[Side, Side]] = []
    for k in range(3):
        sides = _sides(raw, k)
        with located(str(k)):
            low, high = (None if extended and sides[i] is None else number_of(sides, i) for i in (0, 1))
        workspace.append((low, high))
    return workspace


def _width(sides: tuple[Side, Side]) -> Fraction:
    """Return how far two positions can be apart; 0 if that is not bounded, as such a position is in no proof."""
    low, high = sides
    return Fraction(0) if low is None or high is None else high - low


def problem_of(raw: dict[str, Any], reading: str, extended: bool) -> Problem:
    """Return what parameters of the schema /1 or, if `extended`, of /2 describe in this reading."""
    order = integer(raw, "order", 2, 3)
    span, period, step, distance = (number_of(raw, key) for key in ("T_c", "T_s", "T_b", "d_hat_min"))
    need(min(span, period, step, distance) > 0, "T_c, T_s, T_b and d_hat_min must be positive")
    limits = [numbers_of(raw, key, 3) for key in ("v_max", "a_max", "j_max")]
    limits_and_unused = [*limits, *((number_of(raw, key),) for key in ("d_min", "tracking_error"))]
    need(min(map(min, limits_and_unused)) >= 0, "a bound, d_min or tracking_error is negative")
    rows = _scaling(raw, "theta_inverse")
    gram = tuple(dot(rows[i], rows[k]) for i in range(3) for k in range(i, 3))
    norms = _norms(raw)
    _check_unused(raw)

    workspace = None if raw["workspace"] is None else _workspace(raw, extended)
    widths = [Fraction(0)] * 3 if workspace is None else [_width(sides) for sides in workspace]
    need(min(widths) >= 0, "workspace: a low is above its high")
    tight = [[x if norm is None else min(x, norm) for x in box] for box, norm in zip(limits, norms, strict=True)]
    bounds = [(widths[k], *(2 * limit[k] for limit in tight[:order])) for k in range(3)]
    roots = [root_above(4 * dot(box, box)) for box in limits]
    radii = [root if norm is None else min(root, 2 * norm) for root, norm in zip(roots, norms, strict=True)]

    until = {"initial-state": Fraction(0), "whole-motion": span, "as-sampled": period}[reading]
    if reading == "as-sampled":
        need((period / span).denominator == 1, "T_s is not a multiple of T_c")
        need((period / step).denominator == 1, "T_s is not a multiple of T_b")
        need(period <= MOST_IN_PERIOD * min(span, step), "T_s is absurdly long")
    else:
        period, step = span, Fraction(0)
    return Problem(
        reading=reading,
        order=order,
        span=span,
        period=period,
        windows=int(period / span),
        until=until,
        step=step,
        distance=distance,
        gram=gram,
        decoupled=rows[0][1] == rows[0][2] == rows[1][2] == 0,
        workspace=workspace,
        bounds=bounds,
        norms=norms[:order],
        ball=(Fraction(0), *radii[:order]),
    )


# ---- The witness: two motions that come that close ----
def after(state: Vector, s: Fraction) -> Vector:
    """Return all derivatives, the last is the constant input, after time s: Taylor's formula, exact here."""
    powers = [s**j / factorial(j) for j in range(len(state))]
    return tuple(dot(state[k:], powers[: len(state) - k]) for k in range(len(state)))


def _bernstein(state: Vector, duration: Fraction) -> list[Fraction]:
    """Return the Bernstein coefficients, on [0, duration], of the polynomial with these derivatives at 0."""
    n = len(state) - 1
    scaled = [duration**j / factorial(j) * x / comb(n, j) for j, x in enumerate(state)]
    return [sum((comb(i, j) * scaled[j] for j in range(i + 1)), Fraction(0)) for i in range(n + 1)]


def _stays(state: Vector, duration: Fraction, low: Side, high: Side, halvings: int) -> bool:
    """Return whether Bernstein coefficients, here or of halves, show that a polynomial stays in [low, high]."""
    bernstein = _bernstein(state, duration)
    if _within(min(bernstein), low, None) and _within(max(bernstein), None, high):
        return True
    if halvings == 0 or not _within(bernstein[-1], low, high):
        return False
    halves = (state, after(state, duration / 2))
    return all(_stays(x, duration / 2, low, high, halvings - 1) for x in halves)


def _within(x: Fraction, low: Side, high: Side) -> bool:
    return (low is None or low <= x) and (high is None or x <= high)


def _motion(value: object, problem: Problem, k: int) -> Motion:
    """Return the motion of a UAV along axis k, if it keeps the bounds that the reading has for this axis."""
    raw, limits = object_of(value, "state inputs"), [bound / 2 for bound in problem.bounds[k]]
    state, now, inputs, pieces = numbers_of(raw, "state", problem.order), Fraction(0), list_of(raw, "inputs"), []
    for i in range(len(inputs)):
        duration, constant = numbers_of(inputs, i, 2)
        need(duration > 0 and abs(constant) <= limits[-1], f"input {i} lasts no time or is beyond its bound")
        state = (*state, constant)
        if problem.reading == "as-sampled":
            need(i == 0 and duration == problem.period, "it has not one input that lasts T_s")
            times = [j * problem.step for j in range(int(duration / problem.step) + 1)]
        elif problem.reading == "whole-motion":  # all but a cubic position have their extremes at an end, or at a turn
            turn = -state[-2] / constant if constant else Fraction(0)
            times = [Fraction(0), duration, *([turn] if 0 < turn < duration else [])]
        else:
            times = [Fraction(0)] if i == 0 else []
        states = [after(state, time) for time in times]
        kept = all(abs(x[d]) <= limits[d] for x in states for d in range(1, problem.order))
        need(kept, f"velocity or acceleration is beyond its bound during input {i}")
        if problem.workspace is not None:
            low, high = problem.workspace[k]
            need(all(_within(x[0], low, high) for x in states), f"it leaves the workspace during input {i}")
            if problem.reading == "whole-motion" and problem.order == 3:
                stays = _stays(state, duration, low, high, MOST_HALVINGS)
                need(stays, f"it is not shown to stay in the workspace during input {i}")
        pieces.append((now, now + duration, state))
        state, now = after(state, duration)[:-1], now + duration
    need(now == problem.period, "the inputs do not last as long as the motion")
    return pieces


def _merged(motions: Sequence[Motion]) -> Iterator[tuple[Fraction, Fraction, list[Vector]]]:
    """Yield (start, end, states of the axes at the start) of the pieces in which no input of any axis changes."""
    ends, at = sorted({end for motion in motions for _, end, _ in motion}), [0] * len(motions)
    for begin, end in pairwise([Fraction(0), *ends]):
        pieces = [motion[i] for motion, i in zip(motions, at, strict=True)]
        yield begin, end, [after(state, begin - start) for start, _, state in pieces]
        at = [i + (piece[1] == end) for piece, i in zip(pieces, at, strict=True)]


def _length_squared(states: Iterable[Vector], d: int) -> Vector:
    """Return all derivatives of Σ (d-th derivative)² over the axes; Leibniz's rule, exact here."""
    sums = [Fraction(0)] * (2 * max(len(state) - d for state in states) - 1)
    for state in states:
        for (i, x), (j, y) in product(enumerate(state[d:]), repeat=2):
            sums[i + j] += comb(i + j, i) * x * y
    return tuple(sums)


def _check_norms(problem: Problem, motions: Sequence[Motion]) -> None:
    """Check that a UAV keeps the bounds of the norm: its inputs always, its states when the reading bounds them."""
    named = [(d + 1, NORMS[d], norm**2) for d, norm in enumerate(problem.norms) if norm is not None]
    for begin, end, states in _merged(motions) if named else ():
        for d, name, most in named:
            squared = _length_squared(states, d)
            if problem.reading == "whole-motion" or d == problem.order:
                kept = _stays(squared, end - begin, None, most, MOST_HALVINGS)
            elif problem.reading == "as-sampled":  # the only piece
                samples = range(int(problem.period / problem.step) + 1)
                kept = all(after(squared, j * problem.step)[0] <= most for j in samples)
            else:
                kept = begin > 0 or squared[0] <= most
            need(kept, f"it is not shown to keep {name} from {begin} to {end}")


def check_witness(value: object, problem: Problem, lower: Fraction) -> None:
    """Check that a witness is a pair of motions whose distance dips by `lower`."""
    raw = object_of(value, "window tau uav_i uav_j")
    start = integer(raw, "window", 0, problem.windows - 1) * problem.span
    tau, motions = number_of(raw, "tau"), []
    need(0 <= tau <= problem.span, "tau is not in the window")
    for uav, k in product(("uav_i", "uav_j"), range(3)):
        with located(f"{uav}, axis {k}"):
            motions.append(_motion(list_of(raw, uav, 3)[k], problem, k))
    for uav, own in (("uav_i", motions[:3]), ("uav_j", motions[3:])):
        with located(uav):
            _check_norms(problem, own)

    def squared(time: Fraction) -> Fraction:
        pieces = [next(piece for piece in motion if time <= piece[1]) for motion in motions]
        at = [after(state, time - begin)[0] for begin, _, state in pieces]
        return square(problem.gram, at[0] - at[3], at[1] - at[4], at[2] - at[5])

    ends = min(squared(start), squared(start + problem.span))
    need(ends >= problem.distance**2, "the UAVs are closer than d_hat_min at an end of the window")
    need(squared(start + tau) <= (problem.distance - lower) ** 2, "the UAVs are not as close at tau as lower claims")
