"""Motions that reach what the claims about X between samples say, and plans that leave X."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import prod

from swarmproof.algebra.polynomial import Monomial, Number, Polynomial, as_polynomial, constant
from swarmproof.algebra.statement import Solvable
from swarmproof.claims.proof import Question
from swarmproof.dmpc_swarm.proofs.bounds import PUBLISHED, SHRUNK, WIDTH
from swarmproof.dmpc_swarm.proofs.terms.between import SLOW, T_S, A, J, K, P, V, lower, upper
from swarmproof.prove.evidence import Candidate, Certificate, Term, Vectors, chosen_statements, term

_HALF = Fraction(1, 2)
#: What a constraint rests on, by its name.
_Slack = Mapping[str, Term]


def _half(hypothesis: str, *constraints: str) -> _Slack:
    return dict.fromkeys(constraints, term(hypothesis, factor=_HALF))


_WIDE = _half("X is wide enough", lower("p(0)"), upper("p(T_b)"))
_BRAKES = _half("J*T_b <= 2A", upper("a(0)"), lower("a(T_b)"))
_TURNS = _half(SLOW.name, upper("v(0)"), lower("v(T_b)"))


def _positive_rest(value: Polynomial) -> tuple[Term, ...]:
    """Return a polynomial in positive variables, with positive coefficients, as a sum of terms."""

    def names(monomial: Monomial) -> list[str]:
        return [f"{name} > 0" for name, exponent in monomial for _ in range(exponent)]

    return tuple(term(*names(monomial), factor=factor) for monomial, factor in value.terms.items())


def _chosen(
    asked: Question,
    choice: Mapping[str, Polynomial | Number],
    slack: _Slack,
    equations: Mapping[str, Mapping[str, Polynomial]] | None = None,
) -> Candidate:
    """Return a choice of the unknowns; those that are missing are 0.

    `equations` says for a constraint by what equations are multiplied. What slack and equations leave of a constraint
    must be a sum of products of positive numbers, otherwise the candidate will not check.
    """
    assert isinstance(asked, Solvable)
    chosen = {name: as_polynomial(choice.get(name, 0)) for name in asked.unknowns}
    known = {each.name: each.value for each in asked.hypotheses}
    certificates = []
    for statement in chosen_statements(asked, chosen):
        name, value = statement.conclusion.name, statement.conclusion.value
        used = (slack[name],) if name in slack else ()
        for each in used:
            value = value - prod((known[h] for h in each.hypotheses), start=constant(each.factor))
        by = (equations or {}).get(name, {})
        for equation, factor in by.items():
            value = value - factor * known[equation]
        certificates.append(Certificate((*used, *_positive_rest(value)), by))
    return Candidate(chosen, tuple(certificates))


def _jerks(values: Sequence[Polynomial | Number]) -> dict[str, Polynomial | Number]:
    return {f"j_{n}": value for n, value in enumerate(values, start=1)}


def _even(velocity: Polynomial, jerk: Polynomial, ratio: int) -> dict[str, Polynomial | Number]:
    """Return the motion with one jerk, negative, that has this velocity at both ends and 0 in the middle of its way."""
    time = ratio * T_S
    way = velocity * time + jerk * time**3 / 12
    return {"p": -way / 2, "v": velocity, "a": jerk * time / 2, **_jerks([-jerk] * ratio)}


def velocity_by_jerk(asked: Question, ratio: int = 1) -> Candidate:
    """Return that V + J·T_b²/8 is reached with jerk −J, from V to V."""
    return _chosen(asked, _even(V, J, ratio), {**_WIDE, **_BRAKES})


def velocity_by_acceleration(asked: Question, ratio: int = 1) -> Candidate:
    """Return that V + A·T_b/4 is reached with jerk −K, from V to V, the acceleration being A at 0 and −A at T_b."""
    slack = {**_WIDE, **{lower(f"j_{n + 1}"): term("K <= J") for n in range(ratio)}}
    factors: Mapping[str, Polynomial | Number] = {
        upper("a(0)"): -_HALF,
        lower("a(T_b)"): -_HALF,
        "the value is reached": ratio * T_S / 8,
    }
    equations = {name: {"K is 2A/T_b": as_polynomial(factor)} for name, factor in factors.items()}
    return _chosen(asked, _even(V, K, ratio), slack, equations)


def velocity_for_three(asked: Question) -> Candidate:
    """Return that V + A·T_b/6 + J·T_b²/24 is reached for T_b = 3T_s: jerk −J in the middle period; K is A/T_s."""
    outer = J / 2 - K
    way = 3 * V * T_S + (7 * K / 6 + J / 2) * T_S**3
    choice = {"p": -way / 2, "v": V, "a": A, **_jerks([outer, -J, outer])}
    slack = {**_WIDE, **_half("2A <= J*T_b", lower("j_1"), lower("j_3"))}
    factors = {
        upper("p(T_b)"): 9 * T_S**2 / 2,
        lower("p(T_b)"): -9 * T_S**2 / 2,
        upper("v(T_b)"): 3 * T_S,
        lower("v(T_b)"): -3 * T_S,
        lower("a(T_b)"): constant(-2),
        "the value is reached": -T_S,
    }
    return _chosen(asked, choice, slack, {name: {"K is A/T_s": factor} for name, factor in factors.items()})


def acceleration(asked: Question, ratio: int) -> Candidate:
    """Return that the acceleration can grow from A for half of T_b with jerk J, and come back to A."""
    half = ratio // 2
    change = A * (ratio * T_S) + J * T_S**2 * (ratio**2 // 4)
    choice = {"v": -change / 2, "a": A, **_jerks([*[J] * half, *[0] * (ratio % 2), *[-J] * half])}
    return _chosen(asked, choice, _half("V is large enough", lower("v(0)"), upper("v(T_b)")))


def position(asked: Question) -> Candidate:
    """Return that P + A·T_b²/8 is reached with acceleration −A, from P to P."""
    return _chosen(asked, {"p": P, "v": A * T_S / 2, "a": -A}, _TURNS)


def position_for_two(asked: Question) -> Candidate:
    """Return that P + A·T_b²/8 + J·T_b³/24 is reached for T_b = 2T_s, from P to P: jerk −J, then J."""
    choice = {"p": P, "v": A * T_S + J * T_S**2 / 2, "a": -A, **_jerks([-J, J])}
    return _chosen(asked, choice, _half("V is large enough", upper("v(0)"), lower("v(T_b)")))


def position_shrunk(asked: Question) -> Candidate:
    """Return that P is exceeded, from P − e to P − e."""
    room = dict.fromkeys((lower("p(0)"), lower("p(T_b)")), term("e < bound", factor=2))
    choice = {"p": P - SHRUNK, "v": A * T_S / 2, "a": -A}
    return _chosen(asked, choice, {**_TURNS, **room, "X is left": term("e < amount")})


def velocity_shrunk(asked: Question) -> Candidate:
    """Return that V is exceeded, from V − e to V − e."""
    room = dict.fromkeys((lower("v(0)"), lower("v(T_b)")), term("e < bound", factor=2))
    forward = dict.fromkeys((upper("p(0)"), lower("p(T_b)")), term("e < bound", "T_s > 0", factor=_HALF))
    slack = {**_WIDE, **_BRAKES, **room, **forward, "X is left": term("e < amount")}
    return _chosen(asked, _even(V - SHRUNK, J, 1), slack)


def _plan(jerks: Sequence[Number], start: Number, **others: Number) -> Vectors:
    """Return a plan from rest at `start`, with these jerks, and bounds and times."""
    named = {"p": start, "v": 0, "a": 0, **dict(zip(_jerks(jerks), jerks, strict=True)), **others}
    return Vectors({name: Fraction(value) for name, value in named.items()})


#: At 0, T_b, 2T_b, …: p = 0, 1, 5, 5, 1, 0, v = 0, 3, 3, −3, −3, 0, a = 0, 6, −6, −6, 6, 0. At 1.5 s v is 4.5, at 2.5 s
#: p is 5.75.
_TURN: tuple[Number, ...] = (6, -12, 0, 12, -6)
_TURN_BOUNDS: Mapping[str, Number] = {"P": 5, "V": 3, "A": 6, "J": 12, "T_s": 1}
TURN = _plan(_TURN, 0, **_TURN_BOUNDS, tau=_HALF)

#: To 2 m/s and 0.5 m/s² at 1.4 s; 2.025 m/s at 1.5 s.
_TO_2: tuple[Number, ...] = (Fraction(15, 4), 0, 5, Fraction(15, 4), 0, -5, -5)
PUBLISHED_PLAN = _plan((*_TO_2, -5, *_TO_2[::-1]), Fraction(-7, 5), **PUBLISHED, **WIDTH, tau=Fraction(1, 10))

#: To 2 m/s at 1.4 s, to 0.4 m/s and −4 m/s² at 2.2 s; 1.42 m at 2.3 s; back in the same way.
_TO_BORDER = (5, 5, 0, 0, 0, -5, -5, -5, -5, -5, -5)
_TO_BORDER_WAY = Fraction(193, 75)


def flown(asked: Question) -> Candidate:
    """Return a motion of 23 periods from rest to rest that is 0.02 m beyond P = 1.4 m."""
    jerks = (*_TO_BORDER, 0, *(-each for each in reversed(_TO_BORDER)))
    return _chosen(asked, {"p": WIDTH["P"] - _TO_BORDER_WAY, **_jerks(jerks)}, {})


_CHANGES: Mapping[int, tuple[Number, ...]] = {
    2: (1, -1, -1, 1),
    3: (1, 0, -1, -1, 0, 1),
    4: (1, 1, -1, -1, -1, -1, 1, 1),
}


def broken_acceleration(ratio: int) -> Vectors:
    """Return a plan whose acceleration is 0 at 0, T_b and 2T_b and 1 or 2 between, where A is ½; T_b is ratio·T_s."""
    return _plan(_CHANGES[ratio], 0, P=16, V=4, A=_HALF, J=1, T_s=1, tau=1)
