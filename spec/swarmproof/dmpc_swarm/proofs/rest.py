"""Claims about real trajectories that are not planned again, about round 0, and about where a new trajectory begins."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import partial

from swarmproof.algebra.later import Later
from swarmproof.algebra.polynomial import Number, Polynomial, variable
from swarmproof.algebra.statement import Condition, Solvable, Statement, at_least, equal
from swarmproof.claims.proof import ProofClaim, ProofVerdict, Question, Reading
from swarmproof.dmpc_swarm.proofs.feasibility import ALIGNED, BEYOND
from swarmproof.dmpc_swarm.proofs.terms.motion import Axis, State, Timing, in_rounds, jerk_names, symbols
from swarmproof.dmpc_swarm.proofs.terms.problem import (
    LINE,
    entries,
    entries_apart,
    hovering,
    hypotheses,
    limits,
    motion_allowed,
    old_apart,
    special,
    times_18,
    times_20,
    times_21,
)

#: Lemma 4: the three questions about its printed form, and the times of each.
LITERAL, NO_REST, TOO_SHORT = "(19)", "(21), no rest", "(21), h_c·T_c = H·T − T_c"
#: Û and X of the case of two entries.
JUMP = limits(u=(-12, 6), p=(0, 6), v=(0, 3), a=(-6, 6))
_SHORT = in_rounds(2, h_c=1)
#: Û and X of the cases that refute Lemma 4.
_STEADY = limits(u=(0, 0), p=(0, 4), v=(-1, 1), a=(0, 0))
_BRAKING = limits(u=(-18, 6), p=(0, 5), v=(0, 3), a=(-6, 12))
#: With the published T and T_c, the least H for which two references can begin at one place.
START: Mapping[str, Timing] = {"H = 3, T_c = T/2": in_rounds(3, 2, period=Fraction(1, 5))}
#: The published bounds, on the axis x, in m, m/s, m/s² and m/s³.
PUBLISHED = limits(u=(-5, 5), p=(-Fraction(7, 5), Fraction(7, 5)), v=(-2, 2), a=(-5, 5))
#: Horizons for which the start at a hover is proved.
HOVERS: Mapping[str, Timing] = {f"T/T_c = {m}": in_rounds(2, m) for m in (1, 2, 3, 4)}


def one_entry_is(n: int) -> str:
    """Return the name of the hypothesis that two entries have the same jerk n, being one."""
    return f"|D_i(k)| = 1: u_b_{n} = u_a_{n}"


def _apart_late(timing: Timing, given: list[Fraction], needed: Fraction, rest: bool) -> Statement:
    """Return Lemma 4 at one sample."""
    i, j = (entries(name, timing, LINE) for name in "ij")
    (conclusion,) = entries_apart(i, j, [needed])
    return Statement(hypotheses(timing, given, rest=rest), conclusion)


def round_0(timing: Timing) -> list[Fraction]:
    """Return the samples of round 0 (23)."""
    return [h * timing.sample_step for h in range(int(timing.period / timing.sample_step))]


def starts(timing: Timing) -> Statement:
    """Return that what Theorem 2 assumes separates the references at the first sample of round 0.

    The case is that of the published bounds and d̂_min, of one jerk in the first three rounds and none afterwards, and
    of UAV j flying the mirror image of UAV i's trajectory.
    """
    values: dict[str, Polynomial | Number] = {**PUBLISHED, "d": Fraction(1, 4)}
    values |= {f"{symbol}_j": -variable(f"{symbol}_i") for symbol in "pva"}
    for name, sign in (("i", 1), ("j", -1)):
        jerks = jerk_names(name, timing)
        values |= dict.fromkeys(jerks[:3], sign * variable("u_i_0")) | dict.fromkeys(jerks[3:], 0)
    return special(_apart_late(timing, times_20(timing), Fraction(0), rest=True), values)


def _starts_hovering(timing: Timing) -> Solvable:
    """Return the same at all samples of round 0, for UAVs that hover in it (Remark 2)."""
    i, j = (entries(name, timing, LINE) for name in "ij")
    still = [
        equal(f"{name} = 0", variable(name))
        for each in "ij"
        for name in (f"v_{each}", f"a_{each}", *jerk_names(each, timing)[: int(timing.period / timing.input_step)])
    ]
    known = (*hypotheses(timing, times_20(timing)), *still)
    return Solvable(known, (), tuple(entries_apart(i, j, round_0(timing))))


def _starts_apart(timing: Timing) -> Solvable:
    """Return the same, the samples of round 0 being added to (20)."""
    i, j = (entries(name, timing, LINE) for name in "ij")
    known = hypotheses(timing, [*round_0(timing), *times_20(timing)])
    return Solvable(known, (), tuple(entries_apart(i, j, round_0(timing))))


def _two_entries(timing: Timing) -> tuple[tuple[Condition, ...], State, State]:
    """Return two entries a and b of D_i(k), of which b was planned from a, and their states at time T.

    Both begin in one state, since a trajectory planned in round k − 1 begins at kT, where the old one is.
    """
    both = {name: _branch(name, timing) for name in "ab"}
    known = [each for name, axis in both.items() for each in motion_allowed(name, {"": axis}, timing)]
    return tuple(known), both["a"].at(timing.period), both["b"].at(timing.period)


def _branch(name: str, timing: Timing) -> Axis:
    """Return an entry of UAV i with jerks of its own."""
    jerks = map(variable, jerk_names(name, timing))
    return Axis(Fraction(0), symbols("i"), tuple((timing.input_step, jerk) for jerk in jerks))


def _continues(timing: Timing, one_entry: bool) -> Mapping[str, Question]:
    """Return that a plan that begins on a begins where the UAV is, which flies b; `one_entry`: a and b are the same."""
    known, a, b = _two_entries(timing)
    same = [equal(one_entry_is(n), variable(f"u_b_{n}") - variable(f"u_a_{n}")) for n in range(timing.inputs)]
    names = ("position", "velocity", "acceleration")
    statements = {
        name: Statement((*known, *(same if one_entry else ())), equal(f"the {name} is the UAV's", left, right))
        for name, left, right in zip(names, a, b, strict=True)
    }
    return statements if one_entry else {name: special(each, JUMP) for name, each in statements.items()}


def _jump(timing: Timing) -> Mapping[str, Question]:
    """Return how far b can be from a at T, where all jerks of the first round are between u_min and u_max."""
    known, a, b = _two_entries(timing)
    spread = variable("u_max") - variable("u_min")
    t = timing.period
    most: tuple[Polynomial, ...] = (spread * (t**3 / 6), spread * (t**2 / 2), spread * t)
    names = ("position", "velocity", "acceleration")
    return {
        name: Statement(known, at_least(f"the {name} jumps by at most the bound", bound, left - right))
        for name, bound, left, right in zip(names, most, a, b, strict=True)
    }


def _lemma_4(times: Callable[[Timing], list[Fraction]], known: str) -> dict[str, Callable[[], Question]]:
    return {
        f"from {known}, {name}": partial(old_apart, timing, times(timing), times_21(timing), rest=True)
        for name, timing in {**ALIGNED, **BEYOND}.items()
    }


_PRINTED, _REPAIRED = Reading.PRINTED, Reading.REPAIRED
_PROVED, _FALSE = ProofVerdict.PROVED, ProofVerdict.FALSE
_SYSTEM = "Triple integrator on a line; Û an interval and X a box; one entry each of UAVs i and j."

CLAIMS: tuple[ProofClaim, ...] = (
    ProofClaim(
        "lemma-4",
        _PRINTED,
        "Two entries of UAVs that were not planned satisfy (19) if they satisfy (18).",
        "Lemma 4",
        f"{_SYSTEM} H = 1, T_c = T.",
        {LITERAL: _apart_late(in_rounds(1), [Fraction(1)], Fraction(1), rest=False)},
        _PROVED,
        "True, and it says nothing new: (19) is (18) once more, at the same times.",
    ),
    ProofClaim(
        "lemma-4-use",
        _PRINTED,
        "Two entries of UAVs that were not planned satisfy (21) if they satisfy (18), as the proof of Theorem 1 uses "
        "Lemma 4.",
        "Proof of Theorem 1: “Corollary 1, Lemma 3 and 4 then lead to equation (21)”",
        f"{_SYSTEM} First, (13b)–(13d) without rest, as Lemma 4 has no other hypothesis; second, with (13e), which "
        "Theorem 1 assumes, and h_c·T_c < H·T.",
        {
            NO_REST: special(_apart_late(in_rounds(1), times_18(in_rounds(1)), Fraction(2), rest=False), _STEADY),
            TOO_SHORT: special(
                _apart_late(_SHORT, times_18(_SHORT), Fraction(2), rest=True), _BRAKING | hovering("j", _SHORT)
            ),
        },
        _FALSE,
        "(21) is T later than (18), when two UAVs can have flown into each other.",
    ),
    ProofClaim(
        "lemma-4-use",
        _REPAIRED,
        "Two entries that satisfy (13b)–(13e) and (18), or (20), satisfy (21), if h_c·T_c ≥ H·T.",
        "Lemma 4; proof of Theorem 1",
        f"{_SYSTEM} Neither UAV was planned. T is a multiple of T_c. The horizons and steps listed.",
        Later({**_lemma_4(times_18, "(18)"), **_lemma_4(times_20, "(20)")}),
        _PROVED,
        "What (18), or (20), does not reach is after H·T, when both UAVs are at rest.",
    ),
    ProofClaim(
        "theorem-2-base",
        _PRINTED,
        "If the references satisfy (13b)–(13e) and (20) at k = 0, they are d̂_min apart at the samples of round 0.",
        "Theorem 2, eq. (23) for k = 0",
        f"{_SYSTEM} The published bounds and d̂_min, T = T_s = T_b = 0.2 s, T_c = T/2, h_c·T_c = H·T; at h = 0.",
        Later({name: partial(starts, timing) for name, timing in START.items()}),
        _FALSE,
        "Within the published bounds, two references can begin round 0 at the same place and be d̂_min apart from round "
        "1 on: (20) at k = 0 begins there. For the published H = 15, rest follows.",
    ),
    ProofClaim(
        "theorem-2-base",
        _REPAIRED,
        "If the references satisfy (13b)–(13e) and (20) at k = 0, and are d̂_min apart at the samples of round 0, too, "
        "or hover in round 0, they are d̂_min apart at the samples of round 0.",
        "Theorem 2, eq. (23) for k = 0; Remark 2",
        f"{_SYSTEM} T is a multiple of T_c.",
        Later(
            {f"{name}, hovering": partial(_starts_hovering, timing) for name, timing in HOVERS.items()}
            | {f"{name}, apart in round 0": partial(_starts_apart, timing) for name, timing in HOVERS.items()}
        ),
        _PROVED,
        "The hover of Remark 2 is more than a convenience: it is what makes Theorem 2 true in round 0.",
    ),
    ProofClaim(
        "unique-entry",
        _PRINTED,
        "A plan that begins on an entry of D_i(k) (13b) begins in the state of the reference that UAV i flies.",
        "Lemma 1; eq. (13b), without Section 4.2.3's “sole entry”",
        "One axis, T_s = T, H = 3. UAV i flies an entry of D_i(k) (Lemma 1), b; the plan begins on a, from which b was "
        "planned. Both satisfy (13b)–(13e).",
        _continues(in_rounds(3), one_entry=False),
        _FALSE,
        "With two entries the reference may jump: Lemma 1 is not enough.",
    ),
    ProofClaim(
        "unique-entry",
        _REPAIRED,
        "A plan that begins on an entry of D_i(k) (13b) begins in the state of the reference that UAV i flies, if "
        "|D_i(k)| = 1.",
        "Lemma 1; Algorithm 1, line 17",
        "As in the printed reading.",
        _continues(in_rounds(3), one_entry=True),
        _PROVED,
        "Line 17 is needed for this; Section 4.2.3 says so, the statements of Section 4.3 do not name it.",
    ),
    ProofClaim(
        "entry-jump",
        _REPAIRED,
        "Without line 17, the jump would be at most (u_max − u_min)T³/6 in position, (u_max − u_min)T²/2 in velocity "
        "and (u_max − u_min)T in acceleration.",
        "Algorithm 1, line 17",
        "One axis, T = T_s = 0.2 s, H = 4; two entries of D_i(k), which begin in one state.",
        _jump(in_rounds(4, period=Fraction(1, 5))),
        _PROVED,
        "With the published |jerk| ≤ 5: 13.3 mm, 0.2 m/s and 2 m/s² on an axis. For H ≥ 4 this can happen (a test).",
    ),
)
