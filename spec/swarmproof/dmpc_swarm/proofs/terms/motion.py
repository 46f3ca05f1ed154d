"""Trajectories of the nominal system as polynomials: on each axis a triple integrator, one jerk per T_s (eq. 12).

Nothing is rounded: states and jerks are polynomials (variables or numbers), times are fractions. Times count from the
start of round k, at kT: an entry of D(k) begins at 0, and what is planned in round k begins at T.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from swarmproof.algebra.polynomial import Number, Polynomial, variable
from swarmproof.algebra.statement import Condition, at_least, equal


class State(NamedTuple):
    """The state of one axis: position, velocity and acceleration, in m, m/s and m/s²."""

    p: Polynomial
    v: Polynomial
    a: Polynomial


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a trajectory.

    Attributes:
        begins: when, in s.
        state: the state there.
        pieces: durations in s, more than 0, and jerks in m/s³; after the last, the jerk is 0, as in (12).
    """

    begins: Fraction
    state: State
    pieces: tuple[tuple[Fraction, Polynomial], ...]

    @property
    def ends(self) -> Fraction:
        """When the last jerk ends, in s."""
        return self.begins + sum((duration for duration, _ in self.pieces), Fraction(0))

    def at(self, time: Number) -> State:
        """Return the state at `time` in s.

        Raises:
            ValueError: the trajectory has not begun.
        """
        left = time - self.begins
        if left < 0:
            raise ValueError(f"the trajectory begins at {self.begins}, after {time}")
        state = self.state
        for duration, jerk in self.pieces:
            passed = min(duration, left)
            state = after(state, jerk, passed)
            left -= passed
        return after(state, 0, left)


def after(state: State, jerk: Polynomial | Number, time: Polynomial | Number) -> State:
    """Return the state `time` (s) later, under a constant jerk (Taylor's formula, which is exact here)."""
    p, v, a = state
    t = time if isinstance(time, Polynomial) else Fraction(time)
    return State(
        p + v * t + a * (t**2 / 2) + jerk * (t**3 / 6),
        v + a * t + jerk * (t**2 / 2),
        a + jerk * t,
    )


@dataclass(frozen=True, slots=True)
class Timing:
    """The times of problem (13), in s, and how many of each there are.

    Attributes:
        horizon: H, in rounds.
        period: T, of a round.
        input_step: T_s; H·T must be a multiple.
        bound_step: T_b.
        sample_step: T_c.
        bounds: h_b; (13d) is for κ = 0 … h_b.
        samples: h_c; (13f) is for h = 0 … h_c.
    """

    horizon: int
    period: Fraction
    input_step: Fraction
    bound_step: Fraction
    sample_step: Fraction
    bounds: int
    samples: int

    @property
    def length(self) -> Fraction:
        """The length H·T of a trajectory."""
        return self.horizon * self.period

    @property
    def inputs(self) -> int:
        """How many jerks there are: h_s = H·T/T_s."""
        return int(self.length / self.input_step)


def in_rounds(
    horizon: int,
    samples: Number = 1,
    inputs: Number = 1,
    bounds: Number = 1,
    *,
    h_c: int | None = None,
    h_b: int | None = None,
    period: Number = 1,
) -> Timing:
    """Return times by what fits into a round.

    Args:
        horizon: H.
        samples: T/T_c.
        inputs: T/T_s.
        bounds: T/T_b.
        h_c: samples of (13f); where they end at H·T if None.
        h_b: samples of (13d); where they end at H·T if None.
        period: T in s.
    """
    return Timing(
        horizon,
        Fraction(period),
        input_step=period / Fraction(inputs),
        bound_step=period / Fraction(bounds),
        sample_step=period / Fraction(samples),
        bounds=int(horizon * bounds) if h_b is None else h_b,
        samples=int(horizon * samples) if h_c is None else h_c,
    )


def symbols(name: str, axis: str = "") -> State:
    """Return the state with variables ``p_name``, ``v_name``, ``a_name``; with ``_x`` at the end for `axis` x."""
    return State(*(variable(f"{symbol}_{name}{axis and '_'}{axis}") for symbol in "pva"))


def jerk_names(name: str, timing: Timing, axis: str = "") -> tuple[str, ...]:
    """Return the variables ``u_name_0`` … of the jerks of a trajectory."""
    return tuple(f"u_{name}_{n}{axis and '_'}{axis}" for n in range(timing.inputs))


def entry(name: str, timing: Timing, axis: str = "") -> Axis:
    """Return a trajectory from time 0 on, all of whose state and jerks are variables."""
    return _steps(Fraction(0), symbols(name, axis), name, timing, axis)


def planned(name: str, timing: Timing, old: Axis, axis: str = "") -> Axis:
    """Return a trajectory planned in round k: from time T on, where `old` is (13b), its jerks being variables."""
    return _steps(timing.period, old.at(timing.period), name, timing, axis)


def _steps(begins: Fraction, state: State, name: str, timing: Timing, axis: str) -> Axis:
    jerks = map(variable, jerk_names(name, timing, axis))
    return Axis(begins, state, tuple((timing.input_step, jerk) for jerk in jerks))


def within(name: str, value: Polynomial, symbol: str, axis: str = "") -> list[Condition]:
    """Return that a value is within ``symbol_min`` … ``symbol_max``, which are variables; names end in ≥ and ≤."""
    low, high = (variable(f"{symbol}_{end}{axis and '_'}{axis}") for end in ("min", "max"))
    return [at_least(f"{name} ≥", value, low), at_least(f"{name} ≤", high, value)]


def inputs_allowed(name: str, trajectory: Axis, axis: str = "") -> list[Condition]:
    """Return (13c): every jerk is in Û, an interval with the ends ``u_min``, ``u_max``."""
    return [
        each
        for n, (_, jerk) in enumerate(trajectory.pieces)
        for each in within(row("(13c)", name, f"u {n}", axis), jerk, "u", axis)
    ]


def states_allowed(name: str, trajectory: Axis, timing: Timing, axis: str = "") -> list[Condition]:
    """Return (13d): at its samples κT_b the trajectory is in X, a box with ends ``p_min``, ``p_max``, ``v_min``, …."""
    return [
        each
        for n in range(timing.bounds + 1)
        for symbol, value in trajectory.at(trajectory.begins + n * timing.bound_step)._asdict().items()
        for each in within(row("(13d)", name, f"{symbol} {n}", axis), value, symbol, axis)
    ]


def rests(name: str, trajectory: Axis, timing: Timing, axis: str = "") -> list[Condition]:
    """Return (13e): velocity and acceleration are zero after H·T, so that without a jerk they remain so."""
    end = trajectory.at(trajectory.begins + timing.length)
    return [equal(row("(13e)", name, "v", axis), end.v), equal(row("(13e)", name, "a", axis), end.a)]


def row(equation: str, name: str, what: str, axis: str = "") -> str:
    """Return the name of a condition on the trajectory `name`, e.g. ``(13d) i: p 0``."""
    return f"{equation} {name}: {what}{axis and ' '}{axis}"


def allowed(name: str, trajectory: Axis, timing: Timing, axis: str = "", rest: bool = True) -> Sequence[Condition]:
    """Return (13c), (13d) and, if `rest`, (13e) for one axis of a trajectory; (13b) is in the trajectory itself."""
    last = rests(name, trajectory, timing, axis) if rest else []
    return [*inputs_allowed(name, trajectory, axis), *states_allowed(name, trajectory, timing, axis), *last]
