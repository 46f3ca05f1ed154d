"""Evidence about X between samples: how far a motion stays off its chord, and motions that reach it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import product

from swarmproof.algebra.later import Later
from swarmproof.algebra.polynomial import Number, constant
from swarmproof.dmpc_swarm.evidence import motions
from swarmproof.dmpc_swarm.proofs.bounds import CLAIMS, FLOWN, FLOWN_AT_LEAST, PUBLISHED
from swarmproof.dmpc_swarm.proofs.terms.between import T_S, TAU, lower, upper
from swarmproof.prove.evidence import Candidate, Certificate, Evidence, Term, term

_QUESTIONS = {claim.key: claim.questions for claim in CLAIMS}
_HALF = Fraction(1, 2)

#: Factors of which certificates are made; a sum is a tuple of terms.
Sum = tuple[Term, ...]
_STEP: Sum = (term("T_s > 0"),)
_PAST: Sum = (term("tau >= 0"),)
_LEFT: Sum = (term("tau <= T_s"),)
_J: Sum = (term("J > 0"),)
_A: Sum = (term("A > 0"),)


def _up(what: str) -> Sum:
    return (term(upper(what)),)


def _low(what: str) -> Sum:
    return (term(lower(what)),)


def times(*sums: Sum | Number) -> tuple[Term, ...]:
    """Return the product of sums of terms and numbers, multiplied out."""
    factors = [(term(factor=each),) if isinstance(each, int | Fraction) else each for each in sums]
    terms = []
    for parts in product(*factors):
        squared, factor = constant(1), Fraction(1)
        for part in parts:
            squared, factor = squared * part.squared, factor * part.factor
        terms.append(Term(tuple(name for part in parts for name in part.hypotheses), squared, factor))
    return tuple(terms)


def _steps(number: int) -> Sum:
    """Return number·T_s."""
    return times(number, _STEP) if number else ()


def _chord(order: str, ratio: int, period: int) -> Sum:
    """Return T_b × what the chord between both ends is below the bound."""
    return (
        *times((*_steps(ratio - period), *_LEFT), _up(f"{order}(0)")),
        *times((*_steps(period - 1), *_PAST), _up(f"{order}(T_b)")),
    )


def _middle(ratio: int, period: int) -> Term:
    """Return (T_b − 2t)², t being the time since the sample."""
    return term(squared=(ratio - 2 * (period - 1)) * T_S - 2 * TAU)


def _velocity_by_jerk(ratio: int = 1, period: int = 1) -> Certificate:
    """Return T_b(V + J·T_b²/8 − v) = chord + Σ weights·(j_n + J) + J·T_b·(T_b − 2t)²/8.

    The weight of a period is the integral over it of s(T_b − t) before t, and of t(T_b − s) after.
    """
    past: Sum = (*_steps(period - 1), *_PAST)
    left: Sum = (*_steps(ratio - period), *_LEFT)
    terms = [*_chord("v", ratio, period), *times(Fraction(ratio, 8), _J, _STEP, (_middle(ratio, period),))]
    for n in range(1, ratio + 1):
        low = _low(f"j_{n}")
        if n < period:
            terms += times(Fraction(2 * n - 1, 2), _STEP, _STEP, left, low)
        elif n > period:
            terms += times(Fraction(2 * (ratio - n) + 1, 2), _STEP, _STEP, past, low)
        else:
            terms += times(_HALF, left, _PAST, (*_steps(2 * (period - 1)), *_PAST), low)
            terms += times(_HALF, past, _LEFT, (*_steps(2 * (ratio - period)), *_LEFT), low)
    return Certificate(tuple(terms), multiplier=times(ratio, _STEP))


#: T·(V + A·T/4 − v): the jerk is what leads from a(0) to a(T_b).
_VELOCITY_BY_ACCELERATION = Certificate(
    (
        *_chord("v", 1, 1),
        *times(_HALF, _PAST, _LEFT, (*_up("a(0)"), *_low("a(T_b)"))),
        *times(Fraction(1, 4), _A, (_middle(1, 1),)),
    ),
    multiplier=_STEP,
)


def _velocity_by_acceleration_for_two(period: int) -> Certificate:
    """Return the certificate of v ≤ V + A·T_b/4 for T_b = 2T_s; the second period is the first one, backwards."""
    near, far = ("0", "T_b") if period == 1 else ("T_b", "0")
    past, left = (_PAST, _LEFT) if period == 1 else (_LEFT, _PAST)
    near_a, far_a = (_up("a(0)"), _low("a(T_b)")) if period == 1 else (_low("a(T_b)"), _up("a(0)"))
    terms = (
        # (2T² − s²), for the time s to the nearer end, is T² + (T − s)(T + s)
        *times(_HALF, (*times(_STEP, _STEP), *times(left, _STEP), *times(left, past)), _up(f"v({near})")),
        *times(_HALF, past, past, _up(f"v({far})")),
        # s(4T − 3s)/4 = s(3(T − s) + T)/4
        *times(Fraction(1, 4), past, (*times(3, left), *_STEP), _STEP, near_a),
        *times(Fraction(1, 4), past, past, _STEP, far_a),
        *times(_HALF, _A, _STEP, left, left),
    )
    return Certificate(terms, multiplier=times(_STEP, _STEP))


def _velocity_by_acceleration_for_three(period: int) -> Certificate:
    """Return the certificate of v ≤ V + A·T_b/6 + J·T_b²/24 for T_b = 3T_s: only the middle jerk counts."""
    if period == 2:
        terms = (
            *times(_STEP, (*times(2, _STEP), *times(4, _LEFT)), _up("v(0)")),
            *times(_STEP, (*times(2, _STEP), *times(4, _PAST)), _up("v(T_b)")),
            *times(_STEP, _STEP, (*_STEP, *times(2, _LEFT)), _up("a(0)")),
            *times(_STEP, _STEP, (*_STEP, *times(2, _PAST)), _low("a(T_b)")),
            *times(_STEP, _STEP, (*times(2, _STEP, _STEP), *times(4, _PAST, _LEFT)), _low("j_2")),
            *times(_STEP, _STEP, _J, (_middle(1, 1),)),
        )
        return Certificate(terms, multiplier=times(8, _STEP, _STEP))
    past, left = (_PAST, _LEFT) if period == 1 else (_LEFT, _PAST)
    near, far = ("0", "T_b") if period == 1 else ("T_b", "0")
    near_a, far_a = (_up("a(0)"), _low("a(T_b)")) if period == 1 else (_low("a(T_b)"), _up("a(0)"))
    # T² − s², for the time s to the nearer end
    between = (*times(left, _STEP), *times(left, past))
    terms = (
        *times((*times(6, _STEP, _STEP), *times(2, between)), _up(f"v({near})")),
        *times(2, past, past, _up(f"v({far})")),
        *times(_STEP, past, (*times(3, _STEP), *times(5, left)), near_a),
        *times(_STEP, past, past, far_a),
        *times(2, _STEP, _STEP, past, past, _low("j_2")),
        *times(4, _STEP, _A, left, left),
        *times(_STEP, _STEP, _J, (*times(_STEP, _STEP), *times(2, between))),
    )
    return Certificate(terms, multiplier=times(8, _STEP, _STEP))


#: 3T·(P + A·T²/8 − p): the mean acceleration, weighted as the chord weights it, is at least −A.
_POSITION = Certificate(
    (
        *times(3, _chord("p", 1, 1)),
        *times(_HALF, _PAST, _LEFT, (*_STEP, *_LEFT), _low("a(0)")),
        *times(_HALF, _PAST, _LEFT, (*_STEP, *_PAST), _low("a(T_b)")),
        *times(Fraction(3, 8), _A, _STEP, (_middle(1, 1),)),
    ),
    multiplier=times(3, _STEP),
)


def _position_for_two(period: int) -> Certificate:
    """Return the certificate of p ≤ P + A·T_b²/8 + J·T_b³/24 for T_b = 2T_s.

    −a is at most A + J·(time to the nearer end); what that makes of the position is the rest of the terms.
    """
    past, left = (_PAST, _LEFT) if period == 1 else (_LEFT, _PAST)
    jerks = (_low("j_1"), _up("j_2"))
    ends = (_low("a(0)"), _low("a(T_b)"))
    (near_j, far_j), (near_a, far_a) = (jerks, ends) if period == 1 else (jerks[::-1], ends[::-1])
    return Certificate(
        (
            *_chord("p", 2, period),
            *times(past, _STEP, (*left, *times(_HALF, _STEP)), near_a),
            *times(_HALF, past, _STEP, _STEP, far_a),
            # s·T(2T² − s²)/3
            *times(
                Fraction(1, 3),
                past,
                _STEP,
                (*times(_STEP, _STEP), *times(left, _STEP), *times(left, past)),
                near_j,
            ),
            *times(Fraction(1, 3), past, _STEP, _STEP, _STEP, far_j),
            *times(_STEP, _A, left, left),
            *times(Fraction(1, 3), _STEP, _J, left, left, (*times(2, _STEP), *past)),
        ),
        multiplier=times(2, _STEP),
    )


def _acceleration(ratio: int, period: int) -> Certificate:
    """Return that the acceleration is at most J·T_s a period from the nearer end."""
    half = ratio // 2
    if ratio % 2 and period == half + 1:
        # the middle period of an odd number: between the values at its ends
        before = (*_up("a(0)"), *(t for n in range(1, period) for t in times(_STEP, _up(f"j_{n}"))))
        after = (*_up("a(T_b)"), *(t for n in range(period + 1, ratio + 1) for t in times(_STEP, _low(f"j_{n}"))))
        return Certificate((*times(_LEFT, before), *times(_PAST, after)), multiplier=_STEP)
    if period <= half:
        rising = [t for n in range(1, period) for t in times(_STEP, _up(f"j_{n}"))]
        spare = times(_J, (*_LEFT, *_steps(half - period)))
        return Certificate((*_up("a(0)"), *rising, *times(_PAST, _up(f"j_{period}")), *spare))
    falling = [t for n in range(period + 1, ratio + 1) for t in times(_STEP, _low(f"j_{n}"))]
    spare = times(_J, (*_PAST, *_steps(half - (ratio - period) - 1)))
    return Certificate((*_up("a(T_b)"), *falling, *times(_LEFT, _low(f"j_{period}")), *spare))


_FAST: Sum = (term("A*T_b > 2V"),)
#: With D = A·T_b − 2V: 3T·(P + A·T²/8 − p) is more than D·T²/4.
_NEVER = Certificate(
    (
        *times(3, _chord("p", 1, 1)),
        *times(_HALF, _PAST, _LEFT, _LEFT, _low("a(0)")),
        *times(_HALF, _PAST, _LEFT, _PAST, _low("a(T_b)")),
        *times(_PAST, _LEFT, (*_up("v(0)"), *_low("v(T_b)"))),
        *times(Fraction(1, 4), _FAST, _STEP, _STEP),
        *times(Fraction(1, 8), _FAST, (_middle(1, 1),)),
        *times(Fraction(3, 4), (term("V > 0"),), (_middle(1, 1),)),
    ),
    multiplier=times(3, _STEP),
)


def _flown(early: bool) -> Certificate:
    """Return why the position exceeds P by little more than 0.02 m in one half of a period.

    The velocities four periods before and after are in X, so the mean acceleration is at least −4 m/s²; with g, by how
    much the half is not over, or g ago, what is left is (g − 1/240)²/2 + 5g³/48 and a number.
    """
    before = (t for n in (1, 2, 3, 4) for t in times(Fraction(2 * n - 1, 50), _low(f"j_{n}")))
    after = (t for n in (6, 7, 8, 9) for t in times(Fraction(19 - 2 * n, 50), _up(f"j_{n}")))
    mean = (*_up("v(0)"), *_low("v(9T_b)"), *before, *after)
    half: Sum = (term("the half of T_b"),)
    g = (Fraction(1, 5) - 2 * TAU) * (1 if early else -1)
    return Certificate(
        (
            *times(5, _LEFT, _up("p(4T_b)")),
            *times(5, _PAST, _up("p(5T_b)")),
            *times(Fraction(5, 18), _PAST, _LEFT, mean),
            *times(Fraction(1, 12), _PAST, _LEFT, half, _up("j_5") if early else _low("j_5")),
            term(squared=g - Fraction(1, 240), factor=_HALF),
            *times(Fraction(5, 48), half, half, half),
            term(factor=FLOWN - FLOWN_AT_LEAST - Fraction(1, 115_200)),
        )
    )


def _with_published(certificate: Certificate) -> Certificate:
    """Return a certificate without equations for the published parameters."""
    terms = tuple(replace(each, squared=each.squared.put({**PUBLISHED})) for each in certificate.terms)
    return replace(certificate, terms=terms)


def _at_middle(order: str) -> tuple[Term, ...]:
    return times(_HALF, (*_up(f"{order}(0)"), *_up(f"{order}(T_b)")))


_MIDDLE_POSITION = Certificate(
    (*_at_middle("p"), *times(Fraction(1, 16), _STEP, _STEP, (*_low("a(0)"), *_low("a(T_b)"))))
)
_MIDDLE_BY_JERK = Certificate((*_at_middle("v"), *times(Fraction(1, 8), _STEP, _STEP, _low("j_1"))))
_MIDDLE_BY_ACCELERATION = Certificate(
    (*_at_middle("v"), *times(Fraction(1, 8), _STEP, (*_up("a(0)"), *_low("a(T_b)"))))
)

_POSITION_KEY, _VELOCITY_KEY = "x-between-samples-position/repaired", "x-between-samples-velocity/repaired"
_ACCELERATION_KEY, _RATIO = "x-between-samples-acceleration/repaired", "x-between-samples-ratio/repaired"
_COLLISION, _LESS = "x-at-collision-samples/repaired", "x-shrunk-condition/repaired"
_FLOWN = "x-between-samples-flown/repaired"
_PERIODS = tuple((ratio, period) for ratio in (1, 2, 3, 4) for period in range(1, ratio + 1))


def _moved(key: str, make: Callable[..., Candidate], question: str, *ratio: int) -> Mapping[str, Candidate]:
    """Return a motion as evidence for the question of this name."""
    return {question: make(_QUESTIONS[key][question], *ratio)}


def _flown_reached() -> Candidate:
    """Return the motion of 23 periods."""
    return motions.flown(_QUESTIONS[_FLOWN]["0.02 m is reached from rest to rest"])


EVIDENCE: Mapping[str, Mapping[str, Evidence]] = {
    "x-between-samples-position/printed": {"period 3": motions.TURN},
    _POSITION_KEY: {
        "at most A*T_b**2/8": _POSITION,
        **_moved(_POSITION_KEY, motions.position, "reached at T_b/2"),
    },
    "x-between-samples-position-condition/repaired": {"A*T_b > 2V": _NEVER},
    "x-between-samples-velocity/printed": {"period 2": motions.TURN},
    _VELOCITY_KEY: {
        "at most J*T_b**2/8": _velocity_by_jerk(),
        "at most A*T_b/4": _VELOCITY_BY_ACCELERATION,
        **_moved(_VELOCITY_KEY, motions.velocity_by_jerk, "J*T_b**2/8 reached at T_b/2"),
        **_moved(_VELOCITY_KEY, motions.velocity_by_acceleration, "A*T_b/4 reached at T_b/2"),
    },
    "x-between-samples-acceleration/printed": {
        "r = 1": _acceleration(1, 1),
        **{f"r = {ratio}": motions.broken_acceleration(ratio) for ratio in (2, 3, 4)},
    },
    _ACCELERATION_KEY: {
        **{f"r = {ratio}, period {period}": _acceleration(ratio, period) for ratio, period in _PERIODS},
        **_moved(_ACCELERATION_KEY, motions.acceleration, "r = 2, reached", 2),
        **_moved(_ACCELERATION_KEY, motions.acceleration, "r = 3, reached", 3),
        **_moved(_ACCELERATION_KEY, motions.acceleration, "r = 4, reached", 4),
    },
    _RATIO: {
        **{f"velocity, r = {ratio}, period {n}": _velocity_by_jerk(ratio, n) for ratio, n in _PERIODS if ratio > 1},
        **_moved(_RATIO, motions.velocity_by_jerk, "velocity, r = 2, reached", 2),
        **_moved(_RATIO, motions.velocity_by_jerk, "velocity, r = 3, reached", 3),
        **_moved(_RATIO, motions.velocity_by_jerk, "velocity, r = 4, reached", 4),
        **{f"velocity by A, r = 2, period {n}": _velocity_by_acceleration_for_two(n) for n in (1, 2)},
        **_moved(_RATIO, motions.velocity_by_acceleration, "velocity by A, r = 2, reached", 2),
        **{f"velocity by A, r = 3, period {n}": _velocity_by_acceleration_for_three(n) for n in (1, 2, 3)},
        **_moved(_RATIO, motions.velocity_for_three, "velocity by A, r = 3, reached"),
        **{f"position, r = 2, period {n}": _position_for_two(n) for n in (1, 2)},
        **_moved(_RATIO, motions.position_for_two, "position, r = 2, reached"),
    },
    "x-between-samples-published/printed": {"velocity, period 8": motions.PUBLISHED_PLAN},
    "x-between-samples-published/repaired": {
        "velocity": _with_published(_velocity_by_jerk()),
        "position": _with_published(_POSITION),
        "acceleration": _acceleration(1, 1),
    },
    _FLOWN: Later(
        {
            "first half of T_b": partial(_flown, early=True),
            "second half of T_b": partial(_flown, early=False),
            "0.02 m is reached from rest to rest": _flown_reached,
        }
    ),
    "x-at-collision-samples/printed": {
        "position": motions.TURN,
        "velocity": motions.TURN,
        "acceleration": Certificate(times(_HALF, (*_up("a(T_b)"), *_up("a(2T_b)")))),
    },
    _COLLISION: {
        "position": _MIDDLE_POSITION,
        "velocity, by J": _MIDDLE_BY_JERK,
        "velocity, by A": _MIDDLE_BY_ACCELERATION,
        "acceleration": Certificate(_at_middle("a")),
        **_moved(_COLLISION, motions.position, "position, reached"),
        **_moved(_COLLISION, motions.velocity_by_jerk, "velocity, by J, reached"),
        **_moved(_COLLISION, motions.velocity_by_acceleration, "velocity, by A, reached"),
    },
    "x-shrunk/repaired": {
        "position": _POSITION,
        "velocity": _velocity_by_jerk(),
        "acceleration": _acceleration(1, 1),
    },
    _LESS: {
        **_moved(_LESS, motions.position_shrunk, "position"),
        **_moved(_LESS, motions.velocity_shrunk, "velocity"),
    },
}
