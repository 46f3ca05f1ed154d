"""Claims about X between the samples at which it is checked (13d): by how much it is exceeded, and what follows.

T_b = r·T_s; where r is not named, T_b = T_s, as published. Amounts are formulas in the bounds P, V, A, J of one axis.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from functools import partial

from swarmproof.algebra.later import Later
from swarmproof.algebra.polynomial import Number, Polynomial, constant, variable
from swarmproof.algebra.statement import Solvable, Statement, above, at_least, equal
from swarmproof.claims.proof import ProofClaim, ProofVerdict, Question, Reading
from swarmproof.dmpc_swarm.proofs.terms.between import (
    BOUNDS,
    POSITIVE,
    SLOW,
    T_S,
    TAU,
    A,
    J,
    K,
    Moment,
    Order,
    P,
    V,
    by_acceleration,
    by_jerk,
    checks,
    for_three,
    inputs,
    middle,
    of_acceleration,
    of_position,
    planned,
    reached,
    rests,
    somewhere,
    stays,
    turns,
    unknowns,
    way,
)

#: By how much X is shrunk, in the unit of the bound.
SHRUNK = variable("e")
#: The published parameters (P: the x axis).
PUBLISHED: Mapping[str, Number] = {"V": 2, "A": 5, "J": 5, "T_s": Fraction(1, 5)}
WIDTH: Mapping[str, Number] = {"P": Fraction(7, 5)}
#: What is exceeded in flight, in m: at most, and surely.
FLOWN, FLOWN_AT_LEAST = Fraction(2001, 100_000), Fraction(1, 50)

_POSITION, _VELOCITY, _ACCELERATION = Order
_PRINTED, _REPAIRED = Reading.PRINTED, Reading.REPAIRED
_PROVED, _FALSE = ProofVerdict.PROVED, ProofVerdict.FALSE


def _velocity_by_jerk(ratio: int = 1) -> Solvable:
    soft = at_least("J*T_b <= 2A", 2 * A, J * (ratio * T_S))
    return reached(_VELOCITY, middle(ratio), V + by_jerk(ratio), (soft, way(ratio, J)), ratio)


def _velocity_by_acceleration(ratio: int = 1) -> Solvable:
    known = (above("K > 0", K), equal("K is 2A/T_b", K * (ratio * T_S), 2 * A), at_least("K <= J", J, K))
    return reached(_VELOCITY, middle(ratio), V + by_acceleration(ratio), (*known, way(ratio, K)), ratio)


def _velocity_for_three() -> Solvable:
    known = (above("K > 0", K), equal("K is A/T_s", K * T_S, A), at_least("2A <= J*T_b", 3 * J, 2 * K))
    width = at_least("X is wide enough", 2 * P, 3 * V * T_S + (7 * K / 6 + J / 2) * T_S**3)
    return reached(_VELOCITY, middle(3), V + for_three(), (*known, width), 3)


def _pieces(order: Order, beyond: Polynomial, ratio: int) -> Mapping[str, Question]:
    """Return the question for each period of T_b."""
    return {
        f"r = {ratio}, period {period}": stays(order, somewhere(period), ratio, beyond)
        for period in range(1, ratio + 1)
    }


def _lower_than_bound() -> Statement:
    general = stays(_POSITION, somewhere(1), beyond=of_position())
    fast = above("A*T_b > 2V", A * T_S, 2 * V)
    strict = above("less than the amount", general.conclusion.value)
    return Statement((*general.hypotheses, fast), strict)


def _shrunk(order: Order) -> Statement:
    bounds = (P - of_position(), V - by_jerk(), A)
    return stays(order, somewhere(1), bounds=bounds)


def _shrunk_less(order: Order) -> Solvable:
    """Return that X shrunk by `SHRUNK`, less than the amount, lets a motion leave X at T_b/2."""
    bound = BOUNDS[order]
    amount, under = (
        (of_position(), (SLOW,))
        if order is _POSITION
        else (by_jerk(), (at_least("J*T_b <= 2A", 2 * A, J * T_S), way(1, J)))
    )
    known = (above("e > 0", SHRUNK), above("e < amount", amount, SHRUNK), above("e < bound", bound, SHRUNK))
    bounds = [each - SHRUNK if each == bound else each for each in BOUNDS]
    outside = above("X is left", middle().state()[order], bound)
    return Solvable((*POSITIVE, *under, *known), unknowns(1), (*checks(1, 1, bounds), *inputs(1), outside))


def with_published(asked: Statement, numbers: Mapping[str, Number] = PUBLISHED) -> Statement:
    """Return a statement with numbers for the bounds and T_s."""
    put = dict(numbers)
    return replace(
        asked,
        hypotheses=tuple(each.put({**put}) for each in asked.hypotheses),
        conclusion=asked.conclusion.put({**put}),
    )


def _flown(early: bool) -> Statement:
    """Return by how much the position exceeds P, X being met at four more samples on both sides."""
    half = at_least("the half of T_b", (T_S - 2 * TAU) * (1 if early else -1))
    general = stays(_POSITION, somewhere(5), beyond=FLOWN, samples=9)
    return with_published(Statement((*general.hypotheses, half), general.conclusion))


def _flown_reached() -> Solvable:
    """Return that a motion of 23 periods, from rest to rest, is at P + 0.02 m amid its 12th."""
    goal = equal("the value is reached", Moment(12, T_S / 2).state().p, P + constant(FLOWN_AT_LEAST))
    constraints = (*checks(23, 1), *inputs(23), *rests(23, 1), goal)
    return Solvable((), unknowns(23), tuple(each.put({**PUBLISHED, **WIDTH}) for each in constraints))


def _published_plan() -> Statement:
    """Return that the velocity of a plan of 15 periods stays in X in its eighth one."""
    return with_published(planned(_VELOCITY, somewhere(8), samples=15), {**PUBLISHED, **WIDTH})


def _at_collision_sample(order: Order, beyond: Polynomial | Number = 0) -> Statement:
    return stays(order, middle(), beyond=beyond)


def _planned_at_collision_sample(order: Order, period: int) -> Statement:
    return planned(order, Moment(period, T_S / 2), samples=5)


_PLACE = "constraint (13d); Section 4.2.3: “thereby restricting the movement area of the UAV”"
_ENDS = "One axis; X at 0 and T_b, U throughout. T_b = T_s."
_PLAN = "One axis; a plan from rest to rest that satisfies (13b)–(13e)"
_STAYS = "of a planned trajectory stays in X at all times."

CLAIMS: tuple[ProofClaim, ...] = (
    ProofClaim(
        "x-between-samples-position",
        _PRINTED,
        f"The position {_STAYS}",
        _PLACE,
        f"{_PLAN}, with five periods T_b = T_s.",
        {"period 3": planned(_POSITION, somewhere(3), samples=5)},
        _FALSE,
        "A UAV that turns round at the border is outside between two samples that are on it.",
    ),
    ProofClaim(
        "x-between-samples-position",
        _REPAIRED,
        "The position exceeds X by at most A·T_b²/8, and by just that if A·T_b ≤ 2V.",
        _PLACE,
        _ENDS,
        {
            "at most A*T_b**2/8": stays(_POSITION, somewhere(1), beyond=of_position()),
            "reached at T_b/2": reached(_POSITION, middle(), P + of_position(), (SLOW,)),
        },
        _PROVED,
        "The jerk has no part in it. It is reached with a = −A throughout.",
    ),
    ProofClaim(
        "x-between-samples-position-condition",
        _REPAIRED,
        "If A·T_b > 2V, the position never reaches P + A·T_b²/8.",
        _PLACE,
        _ENDS,
        {"A*T_b > 2V": _lower_than_bound()},
        _PROVED,
        "So A·T_b ≤ 2V is the least condition of the claim x-between-samples-position.",
    ),
    ProofClaim(
        "x-between-samples-velocity",
        _PRINTED,
        f"The velocity {_STAYS}",
        _PLACE,
        f"{_PLAN}, with five periods T_b = T_s.",
        {"period 2": planned(_VELOCITY, somewhere(2), samples=5)},
        _FALSE,
        "A UAV that still accelerates at one sample and already brakes at the next is too fast between them.",
    ),
    ProofClaim(
        "x-between-samples-velocity",
        _REPAIRED,
        "The velocity exceeds X by at most J·T_b²/8 and A·T_b/4, and by just the smaller one: the first if J·T_b ≤ 2A, "
        "the second if J·T_b ≥ 2A.",
        _PLACE,
        f"{_ENDS} To reach it, the flying space must be as wide as the way flown in T_b.",
        {
            "at most J*T_b**2/8": stays(_VELOCITY, somewhere(1), beyond=by_jerk()),
            "at most A*T_b/4": stays(_VELOCITY, somewhere(1), beyond=by_acceleration()),
            "J*T_b**2/8 reached at T_b/2": _velocity_by_jerk(),
            "A*T_b/4 reached at T_b/2": _velocity_by_acceleration(),
        },
        _PROVED,
        "It is reached with a constant jerk, −J or −2A/T_b, and v = V at both samples.",
    ),
    ProofClaim(
        "x-between-samples-acceleration",
        _PRINTED,
        f"The acceleration {_STAYS}",
        _PLACE + "; T_b and T_s are not related",
        f"{_PLAN}, with two periods T_b = r·T_s.",
        {
            f"r = {ratio}": planned(_ACCELERATION, somewhere(max(ratio // 2, 1)), samples=2, ratio=ratio)
            for ratio in (1, 2, 3, 4)
        },
        _FALSE,
        "True for T_b = T_s, as published. If the jerk may change between two checks, any bound can be broken.",
    ),
    ProofClaim(
        "x-between-samples-acceleration",
        _REPAIRED,
        "The acceleration stays in X if T_b = T_s. If T_b = r·T_s, it exceeds X by at most J·T_s·⌊r/2⌋, and by just "
        "that if V is large enough; so by J·T_b/2 for even r.",
        _PLACE,
        "One axis; X at 0 and T_b, U throughout; r = 1, 2, 3, 4. V is large enough if 2V ≥ A·T_b + J·T_s²·⌊r²/4⌋.",
        {
            **{
                name: asked
                for ratio in (1, 2, 3, 4)
                for name, asked in _pieces(_ACCELERATION, of_acceleration(ratio), ratio).items()
            },
            **{
                f"r = {ratio}, reached": reached(
                    _ACCELERATION, Moment(ratio // 2, T_S), A + of_acceleration(ratio), (turns(ratio),), ratio
                )
                for ratio in (2, 3, 4)
            },
        },
        _PROVED,
        "Whoever changes the jerk more often than X is checked must leave room for it, or check at T_s.",
    ),
    ProofClaim(
        "x-between-samples-ratio",
        _REPAIRED,
        "If T_b = r·T_s, the velocity still exceeds X by at most J·T_b²/8, and by just that if J·T_b ≤ 2A; else by "
        "just A·T_b/4 for r = 2, and by just A·T_b/6 + J·T_b²/24 for r = 3. For r = 2 the position exceeds X by at "
        "most A·T_b²/8 + J·T_b³/24, and by just that if V is large enough.",
        _PLACE,
        "One axis; X at 0 and T_b, U throughout; r = 2, 3, 4 where nothing else is said. The flying space is wide "
        "enough for the way; V is large enough if 2V ≥ A·T_b + J·T_b²/4.",
        {
            **{
                f"velocity, {name}": asked
                for ratio in (2, 3, 4)
                for name, asked in _pieces(_VELOCITY, by_jerk(ratio), ratio).items()
            },
            **{f"velocity by A, {name}": asked for name, asked in _pieces(_VELOCITY, by_acceleration(2), 2).items()},
            **{f"velocity, r = {ratio}, reached": _velocity_by_jerk(ratio) for ratio in (2, 3, 4)},
            "velocity by A, r = 2, reached": _velocity_by_acceleration(2),
            **{f"velocity by A, {name}": asked for name, asked in _pieces(_VELOCITY, for_three(), 3).items()},
            "velocity by A, r = 3, reached": _velocity_for_three(),
            **{f"position, {name}": asked for name, asked in _pieces(_POSITION, of_position(2), 2).items()},
            "position, r = 2, reached": reached(_POSITION, middle(2), P + of_position(2), (turns(2),), 2),
        },
        _PROVED,
        "The bound by J needs no more than |j| ≤ J. The one of the position grows, since −A is exceeded in between.",
    ),
    ProofClaim(
        "x-between-samples-published",
        _PRINTED,
        "With the published parameters, the state of a planned trajectory stays in X at all times.",
        _PLACE,
        "The x axis; a plan of 15 periods T_b = T_s = 0.2 s from rest to rest that satisfies (13b)–(13e).",
        Later({"velocity, period 8": _published_plan}),
        _FALSE,
        "The plan reaches 2.025 m/s.",
    ),
    ProofClaim(
        "x-between-samples-published",
        _REPAIRED,
        "With the published parameters, X is exceeded by at most 0.025 m/s, 0.025 m and 0 m/s².",
        _PLACE,
        "One axis; X at 0 and T_b, U throughout, T_b = T_s = 0.2 s.",
        {
            "velocity": with_published(stays(_VELOCITY, somewhere(1), beyond=Fraction(1, 40))),
            "position": with_published(stays(_POSITION, somewhere(1), beyond=Fraction(1, 40))),
            "acceleration": with_published(stays(_ACCELERATION, somewhere(1))),
        },
        _PROVED,
        "0.025 m/s is flown (the printed reading's plan). 0.025 m is reached by a motion in X at both samples, but by "
        "none that goes on in X (claim x-between-samples-flown).",
    ),
    ProofClaim(
        "x-between-samples-flown",
        _REPAIRED,
        "With the published parameters, the position of a UAV in flight exceeds X by at most 0.02001 m, and 0.02 m is "
        "reached.",
        _PLACE,
        "One axis; T_b = T_s = 0.2 s. X at all multiples of T_b: four samples more before and after are used. UAVs "
        "start and end at rest. P = 1.4 m (the x axis) for the motion that reaches 0.02 m.",
        Later(
            {
                "first half of T_b": partial(_flown, early=True),
                "second half of T_b": partial(_flown, early=False),
                "0.02 m is reached from rest to rest": _flown_reached,
            }
        ),
        _PROVED,
        "0.025 m takes −5 m/s² at −0.5 m/s: whatever it does, the UAV is faster than 2 m/s a second later.",
    ),
    ProofClaim(
        "x-at-collision-samples",
        _PRINTED,
        "The state at every sample hT_c is in X.",
        "Theorem 3, eq. (24): x̂_0 ∈ X at the start of every window of length T_c",
        f"{_PLAN}; T_b = T_s = 2T_c, as published.",
        {
            "position": _planned_at_collision_sample(_POSITION, 3),
            "velocity": _planned_at_collision_sample(_VELOCITY, 2),
            "acceleration": _planned_at_collision_sample(_ACCELERATION, 2),
        },
        _FALSE,
        "Every second window starts at T_b/2, where X is exceeded most: what (24) yields is no bound on it.",
    ),
    ProofClaim(
        "x-at-collision-samples",
        _REPAIRED,
        "The state at every sample hT_c is in X enlarged by A·T_b²/8 in position and J·T_b²/8 (or A·T_b/4) in "
        "velocity.",
        "Theorem 3, eq. (24)",
        f"{_ENDS} T_b = 2T_c. No less is enough: each is reached at T_b/2 (conditions as between samples).",
        {
            "position": _at_collision_sample(_POSITION, of_position()),
            "velocity, by J": _at_collision_sample(_VELOCITY, by_jerk()),
            "velocity, by A": _at_collision_sample(_VELOCITY, by_acceleration()),
            "acceleration": _at_collision_sample(_ACCELERATION),
            "position, reached": reached(_POSITION, middle(), P + of_position(), (SLOW,)),
            "velocity, by J, reached": _velocity_by_jerk(),
            "velocity, by A, reached": _velocity_by_acceleration(),
        },
        _PROVED,
        "With X enlarged by these amounts, (24) bounds what is flown.",
    ),
    ProofClaim(
        "x-shrunk",
        _REPAIRED,
        "If (13d) is checked with X shrunk by A·T_b²/8 in position and J·T_b²/8 in velocity, the state stays in X at "
        "all times.",
        _PLACE,
        "One axis; the shrunk X at 0 and T_b, U throughout. T_b = T_s.",
        {name: _shrunk(order) for name, order in zip(("position", "velocity", "acceleration"), Order, strict=True)},
        _PROVED,
        "Theorem 1 takes any X: the candidate meets the shrunk one at the same samples as the trajectory it is shifted "
        "from.",
    ),
    ProofClaim(
        "x-shrunk-condition",
        _REPAIRED,
        "No less is enough: if X is shrunk by e < A·T_b²/8 in position, or e < J·T_b²/8 in velocity, a motion leaves "
        "X.",
        _PLACE,
        f"{_ENDS} A·T_b ≤ 2V for the position; J·T_b ≤ 2A and a flying space that is wide enough for the velocity. "
        "e is less than the bound.",
        {"position": _shrunk_less(_POSITION), "velocity": _shrunk_less(_VELOCITY)},
        _PROVED,
        "For J·T_b > 2A, A·T_b/4 is enough in velocity.",
    ),
)
