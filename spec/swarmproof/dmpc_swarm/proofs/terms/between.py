"""One axis of a nominal trajectory between the samples at which X is checked: eqs. (12), (13c), (13d) as polynomials.

The model is the triple integrator of the experiments (eq. 4): position p, velocity v, acceleration a, and a jerk that
is constant for T_s. X is |p| ≤ P, |v| ≤ V, |a| ≤ A, positions being counted from the middle of the flying space; U is
|j| ≤ J. X is checked every T_b = r·T_s only. (Where T_b is a part of T_s, the jerk is constant between two checks: that
is r = 1, with T_b for T_s.)

Of X, statements conclude the upper bounds. The lower ones follow: all hypotheses are the same for −p, −v, −a, −j.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import IntEnum
from typing import NamedTuple

from swarmproof.algebra.polynomial import Number, Polynomial, as_polynomial, constant, variable, variables
from swarmproof.algebra.statement import Condition, Solvable, Statement, above, at_least, equal
from swarmproof.dmpc_swarm.proofs.terms.motion import State, after

P, V, A, J, T_S, TAU = variables("P V A J T_s tau")
#: 2A/T_b (or A/T_s, for r = 3): the jerk with which the bounds of the acceleration are met at both ends.
K = variable("K")
#: The bounds of position (m), velocity (m/s) and acceleration (m/s²).
BOUNDS = (P, V, A)


class Order(IntEnum):
    """Which derivative of the position is asked for."""

    POSITION = 0
    VELOCITY = 1
    ACCELERATION = 2


class Moment(NamedTuple):
    """The time `time` (s) after the start of a period T_s; periods are counted from 1."""

    period: int
    time: Polynomial

    def state(self) -> State:
        """Return the state of the motion that starts at (p, v, a) and has jerks j_1, j_2, …"""
        state = State(*variables("p v a"))
        for period in range(1, self.period):
            state = after(state, jerk(period), T_S)
        return after(state, jerk(self.period), self.time)


def jerk(period: int) -> Polynomial:
    """Return the jerk (m/s³) of a period, counted from 1."""
    return variable(f"j_{period}")


def check(sample: int, ratio: int) -> Moment:
    """Return the time of a check of X, at sample·T_b with T_b = ratio·T_s."""
    return Moment(sample * ratio, T_S) if sample else Moment(1, constant(0))


def somewhere(period: int) -> Moment:
    """Return any time of a period; `INSIDE` says that it is one."""
    return Moment(period, TAU)


def upper(what: str) -> str:
    """Return the name of the condition that `what`, e.g. ``p(T_b)`` or ``j_1``, is at most its bound."""
    return f"upper bound of {what}"


def lower(what: str) -> str:
    """Return the name of the condition that `what` is at least its bound."""
    return f"lower bound of {what}"


def _both(what: str, value: Polynomial, bound: Polynomial) -> Iterator[Condition]:
    yield at_least(upper(what), bound, value)
    yield at_least(lower(what), value, -bound)


def checks(samples: int, ratio: int, bounds: Sequence[Polynomial] = BOUNDS) -> tuple[Condition, ...]:
    """Return X at the samples 0, T_b, …, samples·T_b (13d); `bounds` are those of p, v, a."""
    return tuple(
        condition
        for sample in range(samples + 1)
        for name, value, bound in zip("pva", check(sample, ratio).state(), bounds, strict=True)
        for condition in _both(f"{name}({at(sample)})", value, bound)
    )


def at(sample: int) -> str:
    """Return the time of a check as it is called in names: ``0``, ``T_b``, ``2T_b``, …"""
    return "0" if sample == 0 else "T_b" if sample == 1 else f"{sample}T_b"


def inputs(periods: int) -> tuple[Condition, ...]:
    """Return U for all periods (13c)."""
    return tuple(each for n in range(1, periods + 1) for each in _both(f"j_{n}", jerk(n), J))


#: The bounds and T_s are positive numbers.
POSITIVE = tuple(above(f"{name} > 0", variable(name)) for name in ("P", "V", "A", "J", "T_s"))
INSIDE = (at_least("tau >= 0", TAU), at_least("tau <= T_s", T_S, TAU))


def stays(
    order: Order,
    moment: Moment,
    ratio: int = 1,
    beyond: Polynomial | Number = 0,
    samples: int = 1,
    bounds: Sequence[Polynomial] = BOUNDS,
) -> Statement:
    """Return that p, v or a is at most `beyond` above its bound at `moment`, where X holds at the samples.

    Args:
        order: which of p, v, a.
        moment: at which time.
        ratio: T_b/T_s.
        beyond: in m, m/s or m/s².
        samples: X holds at 0, T_b, …, samples·T_b.
        bounds: of p, v, a at the samples.
    """
    hypotheses = (*POSITIVE, *checks(samples, ratio, bounds), *inputs(samples * ratio))
    inside = INSIDE if TAU.variables <= moment.time.variables else ()
    conclusion = at_least(f"{'pva'[order]} in X", BOUNDS[order] + beyond, moment.state()[order])
    return Statement((*hypotheses, *inside), conclusion)


def planned(order: Order, moment: Moment, samples: int, ratio: int = 1) -> Statement:
    """Return that p, v or a is in X at `moment` of a plan from rest to rest that satisfies (13b)-(13e)."""
    general = stays(order, moment, ratio, samples=samples)
    return Statement((*general.hypotheses, *rests(samples, ratio)), general.conclusion)


def rests(samples: int, ratio: int) -> tuple[Condition, ...]:
    """Return that a plan begins at rest and ends at rest (13e) at samples·T_b."""
    return tuple(
        equal(f"{name}({at(sample)}) = 0", value)
        for sample in (0, samples)
        for name, value in zip("va", check(sample, ratio).state()[1:], strict=True)
    )


def reached(
    order: Order,
    moment: Moment,
    value: Polynomial | Number,
    under: Sequence[Condition],
    ratio: int = 1,
) -> Solvable:
    """Return that some motion that meets X at 0 and T_b has just this p, v or a at `moment`.

    Args:
        order: which of p, v, a.
        moment: at which time.
        value: in m, m/s or m/s².
        under: what is assumed of the bounds.
        ratio: T_b/T_s.
    """
    goal = equal("the value is reached", moment.state()[order], as_polynomial(value))
    return Solvable((*POSITIVE, *under), unknowns(ratio), (*checks(1, ratio), *inputs(ratio), goal))


def unknowns(periods: int) -> tuple[str, ...]:
    """Return the names of what makes a motion: its first state and its jerks."""
    return ("p", "v", "a", *(f"j_{n}" for n in range(1, periods + 1)))


def by_jerk(ratio: int = 1) -> Polynomial:
    """Return J·T_b²/8, in m/s."""
    return J * (ratio * T_S) ** 2 / 8


def by_acceleration(ratio: int = 1) -> Polynomial:
    """Return A·T_b/4, in m/s."""
    return A * (ratio * T_S) / 4


def for_three() -> Polynomial:
    """Return A·T_b/6 + J·T_b²/24 for T_b = 3T_s, in m/s."""
    return A * T_S / 2 + 3 * J * T_S**2 / 8


def of_position(ratio: int = 1) -> Polynomial:
    """Return the excess of the position, in m: A·T_b²/8, and J·T_b³/24 more for r = 2."""
    time = ratio * T_S
    return A * time**2 / 8 + (J * time**3 / 24 if ratio > 1 else 0)


def of_acceleration(ratio: int) -> Polynomial:
    """Return the excess of the acceleration, in m/s²: J·T_s for each whole period in half of T_b."""
    return J * T_S * (ratio // 2)


def middle(ratio: int = 1) -> Moment:
    """Return the time T_b/2."""
    return Moment(ratio // 2, T_S) if ratio % 2 == 0 else Moment(ratio // 2 + 1, T_S / 2)


def way(ratio: int, turn: Polynomial) -> Condition:
    """Return that the flying space is as wide as the way from −p to p at velocity V, with jerk −`turn` for T_b."""
    time = ratio * T_S
    return at_least("X is wide enough", 2 * P, V * time + turn * time**3 / 12)


def turns(ratio: int) -> Condition:
    """Return that 2V is the change of velocity in T_b with the largest acceleration that is A at both ends."""
    return at_least("V is large enough", 2 * V, A * (ratio * T_S) + J * T_S**2 * (ratio**2 // 4))


SLOW = at_least("A*T_b <= 2V", 2 * V, A * T_S)
