"""Evidence about numerical tolerance: known identities with d̂_min − 2ε for d̂_min, and small numbers on a line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from fractions import Fraction

from swarmproof.algebra.polynomial import Polynomial, constant, variable
from swarmproof.dmpc_swarm.evidence.separation import BOTH_NEW, BOTH_OLD, ONE_NEW, ONE_NEW_HALFWAY, vectors
from swarmproof.dmpc_swarm.proofs.terms.cells import Cell, cells
from swarmproof.dmpc_swarm.proofs.terms.separation import D_POSITIVE, EQ_20, I_NEW, I_OLD, LENGTH, NOT_ZERO, D, L
from swarmproof.dmpc_swarm.proofs.terms.tolerance import (
    A_I,
    A_J,
    ACCELERATION,
    DRIFT,
    ERROR,
    JUMP,
    KEPT,
    KEPT_20,
    NOT_NEGATIVE,
    OFF,
    PLACE,
    ROOM,
    SPEED,
    START,
    TIME,
    V_I,
    V_J,
    flies_on,
)
from swarmproof.prove.evidence import Candidate, Certificate, Evidence, Term, Unsolvable, Vectors, term

_TENTH = Fraction(1, 10)
_HALF = Fraction(1, 2)
_ZERO = constant(0)


def _kept(certificate: Certificate) -> Certificate:
    """Return a certificate for d̂_min as one for d̂_min − 2ε."""
    names = {D_POSITIVE: ROOM, EQ_20: KEPT_20}

    def kept(terms: Iterable[Term]) -> tuple[Term, ...]:
        return tuple(
            Term(tuple(names.get(name, name) for name in t.hypotheses), t.squared.put({"d": KEPT}), t.factor)
            for t in terms
        )

    equations = {name: factor.put({"d": KEPT}) for name, factor in certificate.equations.items()}
    return Certificate(kept(certificate.terms), equations, kept(certificate.multiplier))


BOTH_NEW_KEPT, ONE_NEW_KEPT, ONE_NEW_HALFWAY_KEPT, BOTH_OLD_KEPT = map(
    _kept, (BOTH_NEW, ONE_NEW, ONE_NEW_HALFWAY, BOTH_OLD)
)
#: A row with d̂_min alone that is relaxed by ε only says more: s = (15) + lε.
_ONE_NEW_EQUAL = replace(
    ONE_NEW_KEPT, terms=(*ONE_NEW_KEPT.terms, term(ROOM, NOT_ZERO, NOT_ZERO, NOT_NEGATIVE, factor=2))
)
#: The old trajectories are d̂_min apart, 1, and both UAVs use all of ε = 1/10.
_USED = Vectors(
    {
        **vectors(1, 1, i_old=(0, 0, 0), j_old=(1, 0, 0), i_new=(_TENTH, 0, 0), j_new=(1 - _TENTH, 0, 0)).values,
        "epsilon": _TENTH,
    }
)


def _pair(cell: Cell, one_new: Certificate) -> Certificate:
    """Return why a pair stays d̂_min − 2ε apart; `one_new`: for a UAV j that is not in A_ET(k)."""
    if not cell.i.new:
        return BOTH_OLD_KEPT
    if cell.j.new:
        return BOTH_NEW_KEPT
    return ONE_NEW_HALFWAY_KEPT if cell.j.selected else one_new


def _candidate(factor: Polynomial) -> Candidate:
    """Return that the old trajectory satisfies its row: (l + d − 2ε)·(15) is l·(20) and a multiple of l² − ‖n‖²."""
    choice = {name: old for new, old in zip(I_NEW, I_OLD, strict=True) for name in new.variables}
    certificate = Certificate((term(NOT_ZERO, KEPT_20),), {LENGTH: -factor}, (term(NOT_ZERO), term(ROOM)))
    return Candidate(choice, (certificate,))


def _numbers(**values: int | Fraction) -> dict[str, Fraction]:
    return {name: Fraction(value) for name, value in {"d": 1, "epsilon": _TENTH, **values}.items()}


#: 4/5 apart after round k; the row of round k + 2 asks UAV i for 4/5·(−1/10 − (i2 − 1/10)) ≥ 0.
_TWO = Unsolvable(
    _numbers(i0=0, j0=1, i1=_TENTH, j1=1 - _TENTH),
    Certificate((term("(15) for i, round k+2", factor=Fraction(25, 2)),), {"(13b)": constant(10)}),
)
#: 1, then 9/10, then 17/20 on both sides; then i would have to be 1/20 to the left and 1/20 to the right.
_NEAR = Fraction(17, 20)
_THREE = Unsolvable(
    _numbers(a0=-1, i0=0, b0=1, a1=_TENTH - 1, i1=0, b1=1 - _TENTH, a2=-_NEAR, i2=0, b2=_NEAR),
    Certificate(tuple(term(f"(15) for i and {other}", factor=10 / _NEAR) for other in "ab")),
)
_HALF_ROWS, _FULL_ROWS = variable("epsilon_half"), variable("epsilon_full")
_NOTHING, _GIVEN = Certificate(), "d > 2 epsilon_half"
#: Both move by ε_half; then the other row asks for more.
_MORE = Candidate(
    {"i0": _ZERO, "j0": D, "i1": _HALF_ROWS, "j1": D - _HALF_ROWS},
    (
        _NOTHING,
        _NOTHING,
        _NOTHING,
        Certificate((term(_GIVEN),)),
        Certificate((term(_GIVEN, "2 epsilon_half > epsilon_full"),)),
    ),
)
#: UAV i moves by ε_full; then the halfway row asks for more.
_LESS = Candidate(
    {"i0": _ZERO, "j0": D, "i1": _FULL_ROWS, "j1": D},
    (
        _NOTHING,
        _NOTHING,
        _NOTHING,
        Certificate((term("d > epsilon_full"),)),
        Certificate((term("d > epsilon_full", "epsilon_full > 2 epsilon_half"),)),
    ),
)
_EPSILON = variable("epsilon")
_LEAST = Candidate({"i0": _ZERO, "j0": D, "i1": _EPSILON, "j1": D - _EPSILON}, (_NOTHING,) * 4)


def _drift_bound() -> Certificate:
    """Return the certificate of ‖w + Σx‖ ≥ d − ρ from ‖w‖ ≥ d and ‖x_k‖ ≤ r_k, where ρ = Σr_k < d.

    d·ρ·(‖w + Σx‖² − (d − ρ)²) = ρ(d − ρ)(‖w‖² − d²) + d(d − ρ)(ρ² − ‖Σx‖²) + ‖ρw + dΣx‖², and ρ² − ‖Σx‖² is the sum of
    ρ/r_k·(r_k² − ‖x_k‖²) and r_k·r_l·‖x_k/r_k − x_l/r_l‖². All is multiplied by ε_v·ε_a: with t as a factor, x are
    tv_j, −tv_i (r = tε_v) and ½t²a_j, −½t²a_i (r = ½t²ε_a), and ρ = 2tε_v + t²ε_a.
    """
    t, v, a, room, d = "t > 0", "epsilon_v > 0", "epsilon_a > 0", "d > drift", "d > 0"
    # ρ, as terms
    rho = (((t, v), Fraction(2)), ((t, t, a), Fraction(1)))
    terms = [term(v, a, room, "apart at the end", *names, factor=f) for names, f in rho]
    terms += [
        term(v, a, squared=DRIFT * w + D * sum(moved, _ZERO))
        for w, *moved in zip(
            PLACE,
            [TIME * x for x in V_J],
            [-TIME * x for x in V_I],
            [TIME**2 / 2 * x for x in A_J],
            [-(TIME**2) / 2 * x for x in A_I],
            strict=True,
        )
    ]
    for names, f in rho:
        # ε_v·ε_a·ρ/r_k·(r_k² − ‖x_k‖²), once for each vector
        terms += [term(d, room, t, a, f"(13e) for {each}", *names, factor=f) for each in ("v_i", "v_j")]
        terms += [term(d, room, t, t, v, f"(13e) for {each}", *names, factor=f / 2) for each in ("a_i", "a_j")]
    for axis in range(3):
        vi, vj, ai, aj = V_I[axis], V_J[axis], A_I[axis], A_J[axis]
        terms.append(term(d, room, v, a, squared=TIME * (vj + vi)))
        terms.append(term(d, room, v, a, squared=TIME**2 / 2 * (aj + ai)))
        for x in (vj, -vi):
            for y in (aj, -ai):
                # ε_v·ε_a·r·s·(tx/r − ½t²y/s)² with r = tε_v, s = ½t²ε_a is ½t³(ε_a·x − ε_v·y)²
                terms.append(term(d, room, t, t, t, squared=ACCELERATION * x - SPEED * y, factor=_HALF))
    multiplier = tuple(term(d, v, a, *names, factor=f) for names, f in rho)
    return Certificate(tuple(terms), {}, multiplier)


#: Towards each other with 1/10: after 5, nothing is left of 1.
_MEET = Vectors(
    {
        **vectors(1, place=(1, 0, 0), v_i=(_TENTH, 0, 0), v_j=(-_TENTH, 0, 0), a_i=(0, 0, 0), a_j=(0, 0, 0)).values,
        **{"t": Fraction(5), "epsilon_v": _TENTH, "epsilon_a": _TENTH},
    }
)


def _line(**x: Polynomial) -> dict[str, Polynomial]:
    """Return vectors with these first entries."""
    return {f"{name}_{axis}": value if axis == "x" else _ZERO for name, value in x.items() for axis in "xyz"}


_ATTAINED = Candidate(_line(v_i=SPEED, v_j=-SPEED, a_i=ACCELERATION, a_j=-ACCELERATION, place=D), (_NOTHING,) * 6)
_OUT = Vectors(
    {
        **_numbers(x=1 + _TENTH, x_max=1, v=_TENTH, a=0, t=1),
        **{"epsilon_v": _TENTH, "epsilon_a": Fraction(0)},
    }
)
_AT_REST = Certificate((term("(13d) at the end, relaxed"),), {"v = 0": -TIME, "a = 0": -(TIME**2) / 2})
_SOME_ROUNDS = Certificate(
    (
        term("(13d) at the end"),
        term("not for too long"),
        term("t >= 0", "v at most epsilon_v"),
        term("a at most epsilon_a", squared=TIME, factor=_HALF),
    )
)
_ONE_JUMP = Vectors(
    {
        **vectors(1, off=(1, 0, 0), jump=(-_TENTH, 0, 0)).values,
        **{"delta": Fraction(1), "epsilon_0": _TENTH},
    }
)


def _triangle() -> Certificate:
    """Return the certificate of ‖x − y‖ ≤ X + Y from ‖x‖ ≤ X = Δd_min − ε_0 and ‖y‖ ≤ Y = ε_0.

    XY·((X + Y)² − ‖x − y‖²) = (XY + Y²)(X² − ‖x‖²) + (XY + X²)(Y² − ‖y‖²) + ‖Yx + Xy‖².
    """
    x, y = "delta > epsilon_0", "epsilon_0 > 0"
    off, jump = "error on the old reference", "(13b)"
    squares = (term(squared=START * a + (ERROR - START) * b) for a, b in zip(OFF, JUMP, strict=True))
    terms = (term(x, y, off), term(y, y, off), term(x, y, jump), term(x, x, jump), *squares)
    return Certificate(terms, {}, (term(x, y),))


_PLUS = Candidate(_line(off=variable("c"), jump=-START), (_NOTHING,) * 3)

EVIDENCE: Mapping[str, Mapping[str, Evidence]] = {
    "tolerance-distance/printed": {cell.id: _USED if cell.i.new else BOTH_OLD for cell in cells()},
    "tolerance-distance/repaired": {cell.id: _pair(cell, _ONE_NEW_EQUAL) for cell in cells()},
    "tolerance-least/repaired": {"both new": _LEAST},
    "tolerance-feasible/printed": {
        "two UAVs, first sample": _TWO,
        "three UAVs, any sample, without (13b)": _THREE,
    },
    "tolerance-feasible/repaired": {
        "candidate, j is in A_ET(k)": _candidate(L + 2 * KEPT),
        "candidate, j is not in A_ET(k)": _candidate(KEPT),
        **{cell.id: _pair(cell, ONE_NEW_KEPT) for cell in cells()},
    },
    "tolerance-half/repaired": {"more than half": _MORE, "less than half": _LESS},
    "tolerance-no-plan/repaired": {cell.id: _pair(cell, _ONE_NEW_EQUAL) for cell in cells() if flies_on(cell)},
    "tolerance-rest/printed": {"d": _MEET},
    "tolerance-rest/repaired": {"d - 2(nT epsilon_v + (nT)^2 epsilon_a/2)": _drift_bound()},
    "tolerance-rest-least/repaired": {"attained": _ATTAINED},
    "tolerance-state/printed": {"(13d) after the end": _OUT},
    "tolerance-state/repaired": {"at rest": _AT_REST, "for some rounds": _SOME_ROUNDS},
    "tolerance-start/printed": {"delta": _ONE_JUMP},
    "tolerance-start/repaired": {"delta - epsilon_0": _triangle()},
    "tolerance-start-least/repaired": {"c + epsilon_0": _PLUS},
}
