"""Claims about Theorem 1: is problem (13) feasible, and do the entries of the next round keep what it assumes?

All of them are about real trajectories of the triple integrator. T is the unit of time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from swarmproof.algebra.later import Later
from swarmproof.algebra.polynomial import Number, Polynomial, variable
from swarmproof.algebra.statement import Solvable, Statement, at_least, equal
from swarmproof.claims.proof import ProofClaim, ProofVerdict, Question, Reading
from swarmproof.dmpc_swarm.proofs.terms.motion import Timing, entry, in_rounds, inputs_allowed, planned, rests, symbols
from swarmproof.dmpc_swarm.proofs.terms.problem import (
    SPACE,
    ends_at_rest,
    feasible,
    hovering,
    limits,
    special,
    stays,
    times_18,
    times_20,
)

_HALF = Fraction(1, 2)

#: Horizons and steps for which proofs are on file, all with T_s and T_b that divide T and h_b·T_b = H·T.
ALIGNED: Mapping[str, Timing] = {
    "H = 1, T_c = T": in_rounds(1),
    "H = 2, T_c = T": in_rounds(2),
    "H = 3, T_c = T": in_rounds(3),
    "H = 3, T_c = T/2": in_rounds(3, 2),
    "H = 3, T_c = T/3": in_rounds(3, 3),
    "H = 3, T_c = T/4": in_rounds(3, 4),
    "H = 1, T_c = T/2, T_s = T/3": in_rounds(1, 2, 3),
    "H = 2, T_c = T, T_s = T/2, T_b = T/3": in_rounds(2, 1, 2, 3),
}
#: What a single step of Theorem 1 also allows: T_c need not divide T, and (13f) may end up to T − T_c before H·T.
ONE_STEP: Mapping[str, Timing] = {
    "H = 2, T_c = 2T/3": in_rounds(2, Fraction(3, 2)),
    "H = 2, T_c = T/2, h_c = 3": in_rounds(2, 2, h_c=3),
    "H = 3, T_c = T/4, h_c = 9": in_rounds(3, 4, h_c=9),
}
#: (13d) and (13f) may also go on after H·T.
BEYOND: Mapping[str, Timing] = {"H = 2, T_c = T/2, h_c = 5, h_b = 3": in_rounds(2, 2, h_c=5, h_b=3)}
#: In all three axes, once; on a line, each horizon. By name, whether UAV j is selected.
IN_SPACE = in_rounds(2, 2)
SPACE_QUESTIONS = {
    f"three axes, H = 2, T_c = T/2, j {'in' if halfway else 'not in'} A_ET(k)": halfway for halfway in (False, True)
}
_Times = Callable[[Timing], list[Fraction]]

#: What the printed theorem leaves open.
NO_ZERO = "0 is not in Û"
H_C_WHOLE, H_C_HALF = "h_c·T_c = H·T − T, T_c = T", "h_c·T_c = H·T − T, T_c = T/2"
H_B_SHORT, T_S_LONG, T_B_LONG = "h_b·T_b = H·T − T", "T is no multiple of T_s", "T is no multiple of T_b"
#: What breaks the recursion, beside what breaks a single step.
T_C_LONG, ONE_SHORT = "T is no multiple of T_c", "h_c·T_c = H·T − T_c, T_c = T/2"


class Case(NamedTuple):
    """A case of a printed statement: times that it allows, and numbers for Û and X; `still`: UAV j hovers."""

    timing: Timing
    limits: Mapping[str, tuple[int, int]]
    still: bool = True

    @property
    def values(self) -> dict[str, Polynomial | Number]:
        """What is put into the statement."""
        return limits(**self.limits) | (hovering("j", self.timing) if self.still else {})


_WITHIN: Mapping[str, tuple[int, int]] = {"u": (-18, 6), "p": (0, 8), "v": (0, 3), "a": (-6, 12)}
_WITHIN_8: Mapping[str, tuple[int, int]] = {"u": (-144, 48), "p": (0, 33), "v": (0, 24), "a": (-48, 96)}
OPEN: Mapping[str, Case] = {
    NO_ZERO: Case(in_rounds(1), {"u": (1, 6), "p": (0, 4), "v": (0, 3), "a": (-6, 0)}, still=False),
    H_C_WHOLE: Case(in_rounds(2, h_c=1), _WITHIN),
    H_C_HALF: Case(in_rounds(2, 2, h_c=2), _WITHIN_8),
    H_B_SHORT: Case(in_rounds(2, h_b=1), {**_WITHIN, "p": (-5, 3)}),
    T_S_LONG: Case(in_rounds(2, inputs=_HALF), {"u": (0, 6), "p": (0, 10), "v": (0, 12), "a": (-12, 0)}),
    T_B_LONG: Case(in_rounds(2, bounds=_HALF), {**_WITHIN, "v": (0, 2)}),
}
OPEN_NEXT: Mapping[str, Case] = {
    T_C_LONG: Case(in_rounds(2, _HALF), _WITHIN),
    ONE_SHORT: Case(in_rounds(2, 2, h_c=3), _WITHIN_8),
}
#: A case of the next use of Theorem 1, if (13e) is not concluded.
NO_REST = Case(in_rounds(2), {"u": (-6, 6), "p": (-5, 3), "v": (-1, 2), "a": (-6, 0)})
END_V, END_A, NEXT_FEASIBLE = "(13e): velocity", "(13e): acceleration", "the next problem is feasible"

#: Horizons for which it is asked whether 0 must be in Û.
RESTING = (1, 2, 3)


def _feasible(times: _Times, timings: Mapping[str, Timing]) -> dict[str, Callable[[], Question]]:
    """Return Theorem 1 for all these times, UAVs on a line; `times`: when old entries are apart."""
    return {name: partial(feasible, timing, times(timing)) for name, timing in timings.items()}


def _feasible_in_space(times: _Times) -> dict[str, Callable[[], Question]]:
    """Return Theorem 1 in all three axes, where UAV j is selected and where it is not."""
    return {
        name: partial(feasible, IN_SPACE, times(IN_SPACE), axes=SPACE, halfway=halfway)
        for name, halfway in SPACE_QUESTIONS.items()
    }


def _special(name: str, case: Case, times: _Times) -> Solvable:
    """Return the case of Theorem 1 that is called `name`."""
    return special(feasible(case.timing, times(case.timing), zero=name != NO_ZERO), case.values)


def _ends_at_rest() -> Mapping[str, Question]:
    """Return the case of the next use of Theorem 1, and whether what is concluded of it gives (13e)."""
    times = times_20(NO_REST.timing)
    ends = zip((END_V, END_A), ends_at_rest(NO_REST.timing), strict=True)
    return {
        **{name: special(each, NO_REST.values) for name, each in ends},
        NEXT_FEASIBLE: special(feasible(NO_REST.timing, times, rest=False), NO_REST.values),
    }


def _needs_zero(horizon: int) -> Statement:
    """Return that 0 is not below Û if a UAV that is at rest in round k has a plan."""
    timing = in_rounds(horizon)
    old = entry("i", timing)
    new = planned("new", timing, old)
    moves = zip(symbols("i")[1:], ("v_i = 0", "a_i = 0"), strict=True)
    still = [equal(name, value) for value, name in moves]
    first = equal("u_i_0 = 0", old.pieces[0][1])
    known = (*still, first, *inputs_allowed("new", new), *rests("new", new, timing))
    return Statement(known, at_least("u_min ≤ 0", -variable("u_min")))


_PRINTED, _REPAIRED = Reading.PRINTED, Reading.REPAIRED
_PROVED, _FALSE = ProofVerdict.PROVED, ProofVerdict.FALSE
_SYSTEM = "Triple integrator; Û an interval and X a box per axis, one entry each of UAVs i and j."
_ALIGNED = "T is a multiple of T_s and T_b, h_b·T_b = H·T, 0 ∈ Û"

CLAIMS: tuple[ProofClaim, ...] = (
    ProofClaim(
        "theorem-1-feasible",
        _PRINTED,
        "If (20) is true and all entries of D(k) satisfy (13b)–(13e), problem (13) is feasible.",
        "Theorem 1",
        f"{_SYSTEM} Each question leaves open one thing that the repaired statement assumes, for given Û and X.",
        Later({name: partial(_special, name, case, times_20) for name, case in OPEN.items()}),
        _FALSE,
        "True for the published parameters if h_b = H, but not as stated: each of 0 ∈ Û, h_c, h_b, T_s and T_b can be "
        "chosen such that a UAV with an admissible trajectory has no plan at all. That T_s and T_b divide T stands in "
        "the proof, 0 ∈ Û is in the domain of f̂_i (4) and in (13e).",
    ),
    ProofClaim(
        "theorem-1-feasible",
        _REPAIRED,
        "If (20) is true and all entries of D(k) satisfy (13b)–(13e), problem (13) is feasible, provided that 0 ∈ Û, T "
        "is a multiple of T_s and T_b, h_b·T_b ≥ H·T and h_c·T_c ≥ H·T − (T − T_c).",
        "Theorem 1, eq. (22)",
        f"{_SYSTEM} The horizons and steps listed. T need not be a multiple of T_c here.",
        Later({**_feasible(times_20, {**ALIGNED, **ONE_STEP, **BEYOND}), **_feasible_in_space(times_20)}),
        _PROVED,
        "The candidate is the old trajectory. (20) does not reach the last sample h_c of (13f): terminal rest does.",
    ),
    ProofClaim(
        "zero-input",
        _REPAIRED,
        "0 ∈ Û is necessary: if all of Û is above 0 (or, by symmetry, below), a UAV at rest has no plan.",
        "Theorem 1; eq. (13c), (13e)",
        "One axis, T_s = T, H = 1, 2, 3.",
        {f"H = {horizon}": _needs_zero(horizon) for horizon in RESTING},
        _PROVED,
        "All trajectories come to rest if they are not planned again; then, (13e) asks for jerks of mean 0.",
    ),
    ProofClaim(
        "theorem-1-keeps-rest",
        _PRINTED,
        "Theorem 1's conclusion that D(k+1) satisfies (13b)–(13d) is what its next use assumes, (13b)–(13e).",
        "Theorem 1, last line; proof of Theorem 2: “we apply induction to Theorem 1”",
        f"{_SYSTEM} {_ALIGNED}, h_c·T_c = H·T, (20); for given Û and X.",
        _ends_at_rest(),
        _FALSE,
        "(13e) is lost in print. A trajectory within all bounds that does not end at rest can leave no room to brake.",
    ),
    ProofClaim(
        "theorem-1-keeps-rest",
        _REPAIRED,
        "All entries of D(k+1) satisfy (13b)–(13e), if those of D(k) do.",
        "Theorem 1, and its proof, which shows (13e) without stating it",
        f"One axis. {_ALIGNED}. New entries satisfy (13b)–(13e) as solutions of (13); asked is about those that stay.",
        Later({name: partial(stays, timing) for name, timing in ALIGNED.items()}),
        _PROVED,
        "With (13e) in its conclusion, Theorem 1 can be applied again.",
    ),
    ProofClaim(
        "recursion",
        _PRINTED,
        "(21), and D(k+1) satisfying (13b)–(13e), make the problems (13) of round k+1 feasible.",
        "Proof of Theorem 2; that T is a multiple of T_c stands there, not in a theorem",
        f"{_SYSTEM} {_ALIGNED}. Each question leaves open one thing that the repaired statement assumes, for given Û "
        "and X.",
        Later({name: partial(_special, name, case, times_18) for name, case in OPEN_NEXT.items()}),
        _FALSE,
        "(21) does not give (20) of the next round: samples fall between those of (21), or after its last.",
    ),
    ProofClaim(
        "recursion",
        _REPAIRED,
        "(21), and D(k+1) satisfying (13b)–(13e), make the problems (13) of round k+1 feasible, provided that T is a "
        "multiple of T_c, T_s and T_b, h_c·T_c ≥ H·T, h_b·T_b ≥ H·T and 0 ∈ Û.",
        "Theorem 1 and proof of Theorem 2",
        f"{_SYSTEM} The horizons and steps listed.",
        Later({**_feasible(times_18, {**ALIGNED, **BEYOND}), **_feasible_in_space(times_18)}),
        _PROVED,
        "Feasibility is recursive: the conclusion of one round is all that the next one needs.",
    ),
)
