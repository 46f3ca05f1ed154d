"""Evidence about problem (13): the shifted old trajectory as candidate, and UAVs on a line that have no plan."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial

from swarmproof.algebra.later import Later
from swarmproof.algebra.polynomial import Number, Polynomial, constant, variable
from swarmproof.dmpc_swarm.proofs.feasibility import (
    ALIGNED,
    BEYOND,
    END_A,
    END_V,
    H_B_SHORT,
    H_C_HALF,
    H_C_WHOLE,
    IN_SPACE,
    NEXT_FEASIBLE,
    NO_ZERO,
    ONE_SHORT,
    ONE_STEP,
    RESTING,
    SPACE_QUESTIONS,
    T_B_LONG,
    T_C_LONG,
    T_S_LONG,
)
from swarmproof.dmpc_swarm.proofs.terms.motion import Timing, in_rounds, jerk_names, row
from swarmproof.dmpc_swarm.proofs.terms.problem import (
    LINE,
    SPACE,
    ZERO_ALLOWED,
    Motion,
    apart_at,
    entries,
    length_is,
    length_sign,
    normal,
    place,
    shifted_jerks,
    times_13f,
    times_18,
    times_20,
)
from swarmproof.dmpc_swarm.proofs.terms.separation import D_POSITIVE, D
from swarmproof.prove.evidence import Candidate, Certificate, Evidence, Unsolvable, Vectors, term

#: Of the two ends of an interval: what the name of the condition ends with, and the sign of the value in it.
_ENDS = (("≥", 1), ("≤", -1))


def _at_rest(name: str, axis: str, v: Number, a: Number, factor: Polynomial | Number = 1) -> Mapping[str, Polynomial]:
    """Return equations: `factor` times v times the velocity, plus a times the acceleration, at the end (13e)."""
    numbers = {row("(13e)", name, "v", axis): v, row("(13e)", name, "a", axis): a}
    return {each: constant(number) * factor for each, number in numbers.items() if number}


def drift(end: Fraction, later: Fraction, earlier: Fraction) -> tuple[Fraction, Fraction]:
    """Return by what velocity and acceleration at `end` are multiplied in p(later) − p(earlier), both after `end`."""
    return later - earlier, ((later - end) ** 2 - (earlier - end) ** 2) / 2


def shifted_axis(timing: Timing, axis: str = "") -> Iterator[Certificate]:
    """Yield certificates that an entry of UAV i, seen from round k, satisfies (13c), (13d), (13e) on one axis."""
    passed = int(timing.period / timing.input_step)
    for n in range(timing.inputs):
        kept = n + passed < timing.inputs
        name = row("(13c)", "i", f"u {n + passed}", axis) if kept else f"{ZERO_ALLOWED}{axis and ' '}{axis}"
        yield from (Certificate((term(f"{name} {end}"),)) for end, _ in _ENDS)
    last = timing.bounds * timing.bound_step
    for n in range(timing.bounds + 1):
        time = timing.period + n * timing.bound_step
        beyond = time > last
        sample = timing.bounds if beyond else int(time / timing.bound_step)
        passed_time, square = drift(timing.length, time, last) if beyond else (Fraction(0), Fraction(0))
        for symbol, v, a in (("p", passed_time, square), ("v", Fraction(0), passed_time), ("a", Fraction(0), 0)):
            name = row("(13d)", "i", f"{symbol} {sample}", axis)
            for end, sign in _ENDS:
                yield Certificate((term(f"{name} {end}"),), _at_rest("i", axis, sign * v, sign * a))
    yield Certificate(equations=_at_rest("i", axis, 1, timing.period))
    yield Certificate(equations=_at_rest("i", axis, 0, 1))


def still_apart(
    timing: Timing, time: Fraction, earlier: Fraction, i: Motion, j: Motion, factor: Polynomial | Number = 1
) -> dict[str, Polynomial]:
    """Return `factor` × (‖n(time)‖² − ‖n(earlier)‖²), where both UAVs are at rest, as equations (13e)."""
    equations: dict[str, Polynomial] = {}
    if time == earlier:
        return equations
    v, a = drift(timing.length, time, earlier)
    for axis, after, before in zip(i, _normal(i, j, time), _normal(i, j, earlier), strict=True):
        equations |= _at_rest("j", axis, v, a, (after + before) * factor)
        equations |= _at_rest("i", axis, -v, -a, (after + before) * factor)
    return equations


def _normal(i: Motion, j: Motion, time: Fraction) -> tuple[Polynomial, ...]:
    return place(j, time) - place(i, time)


def known_time(timing: Timing, time: Fraction, given: Iterable[Fraction]) -> Fraction:
    """Return the time among `given` when the distance is the one at `time`: the same, or one at rest as well."""
    times = list(given)
    return time if time in times or not times or times[-1] < timing.length else times[-1]


def candidate(
    timing: Timing, given: Sequence[Fraction], axes: Sequence[str] = LINE, halfway: bool = False
) -> Candidate:
    """Return the candidate of Theorem 1, for entries that are d̂_min apart at the times `given`."""
    i, j = (entries(name, timing, axes) for name in "ij")
    choice = {
        name: jerk
        for axis in axes
        for name, jerk in zip(jerk_names("new", timing, axis), shifted_jerks(timing, axis), strict=True)
    }
    certificates = [each for axis in axes for each in shifted_axis(timing, axis)]
    for h, time in enumerate(times_13f(timing)):
        size = variable(normal(h))
        earlier = known_time(timing, time, given)
        # with n² = l², (15) is l² ≥ ld or 2l² ≥ l(d + l), each the same as l(l − d) ≥ 0; times l + d it is l × (20)
        certificates.append(
            Certificate(
                (term(length_sign(h), apart_at(earlier)),),
                {
                    length_is(h): size - (2 if halfway else 1) * (size + D),
                    **still_apart(timing, time, earlier, i, j, size),
                },
                (term(length_sign(h)), term(D_POSITIVE)),
            )
        )
    return Candidate(choice, certificates)


def line(i: Sequence[Number], j: Sequence[Number], d: Number, lengths: Sequence[Number] = ()) -> dict[str, Fraction]:
    """Return numbers for two entries on a line.

    Args:
        i: position, velocity and acceleration of UAV i at time 0, then its jerks.
        j: the same of UAV j; its position is enough if the case is that it hovers.
        d: d̂_min.
        lengths: ‖n_ij‖ at the samples of (13f).
    """
    values = {"d": Fraction(d)}
    for name, numbers in (("i", i), ("j", j)):
        names = (*(f"{symbol}_{name}" for symbol in "pva"), *(f"u_{name}_{n}" for n in range(len(numbers) - 3)))
        values |= {each: Fraction(number) for each, number in zip(names, numbers, strict=False)}
    return values | {normal(h): Fraction(length) for h, length in enumerate(lengths)}


#: Goes from 0 over 3 (speed 3) to 4, where it rests, in two rounds, T = 1. From 3 on, the two jerks of a plan have two
#: equations (13e) and one solution: 6, then 0. So the only plan is the old trajectory.
_BRAKES = (0, 0, 12, -18, 6)
#: The same, eight times as large: from 0 over 24 to 32; at T + T/2 it is at 31.
_BRAKES_8 = (0, 0, 96, -144, 48)
#: Goes from 0 over 2 (speed 2) to 3, where it is not at rest. From 2 on, only the jerks −2 and 2 stop it, at 4.
_FAST = (0, 2, 0, 0, -6)


def _no_plan(broken: str, v: Number, a: Number) -> Certificate:
    """Return that a row, v times (13e) for the velocity and a times (13e) for the acceleration add up to −1."""
    return Certificate((term(broken),), _at_rest("new", "", v, a))


#: v/6 − a/12 is (u_new_0 − 6)/6, or (u_new_0 − 48)/6: the first jerk is 6, or 48, and no row has the second.
_ONE_PLAN = (Fraction(1, 6), Fraction(-1, 12))

_FEASIBLE: Mapping[str, Evidence] = {
    # at rest from T on; a jerk of mean 0 is asked for, but all are at least 1
    NO_ZERO: Unsolvable(
        line((0, 3, -6, 6), (3, 3, -6, 6), 2, (3, 3)),
        _no_plan(row("(13c)", "new", "u 0 ≥"), 0, -1),
    ),
    # 2 apart at T, but at 2T only 1
    H_C_WHOLE: Unsolvable(line(_BRAKES, (5,), 2, (2, 1)), _no_plan("(13f), h = 1", *_ONE_PLAN)),
    # 9 apart at T, 2 at T + T/2, 1 at 2T
    H_C_HALF: Unsolvable(line(_BRAKES_8, (33,), 2, (9, 2, 1)), _no_plan("(13f), h = 2", *_ONE_PLAN)),
    # X ends at 3; the old trajectory is there at T, and outside from then on
    H_B_SHORT: Unsolvable(
        line(_BRAKES, (-5,), 2, (8, 9, 9)),
        _no_plan(row("(13d)", "new", "p 1 ≤"), *_ONE_PLAN),
    ),
    # one jerk for 2T, old or new: (13e) asks for 9/2 because of the velocity, and for 3 because of the acceleration
    T_S_LONG: Unsolvable(
        line((0, 12, -12, 6), (10,), 2, (3, 2, 2)),
        Certificate((), _at_rest("new", "", Fraction(1, 3), Fraction(-1, 3))),
    ),
    # the velocity is 0, 3 and 0 at 0, T and 2T; T is no sample of the old trajectory, but the first one of the new
    T_B_LONG: Unsolvable(
        line(_BRAKES, (8,), 2, (5, 4, 4)),
        Certificate((term(row("(13d)", "new", "v 0 ≤")),)),
    ),
}
#: X ends at 3, where the old trajectory ends, but not at rest; any plan ends at 4.
_CANNOT_BRAKE = line(_FAST, (-5,), 2, (7, 8, 4))
_NEXT: Mapping[str, Evidence] = {
    # 2 apart at 2T, but at T only 1: UAV i has flown through UAV j
    T_C_LONG: Unsolvable(line(_BRAKES, (2,), 2, (1, 2)), Certificate((term("(13f), h = 0"),))),
    # 2 apart at T + T/2, the last sample of (21), but at 2T only 1
    ONE_SHORT: Unsolvable(line(_BRAKES_8, (33,), 2, (9, 2, 1, 1)), _no_plan("(13f), h = 2", *_ONE_PLAN)),
}


def _needs_zero(horizon: int) -> Certificate:
    """Return why 0 is not below Û: the jerks of a plan from rest to rest add up to 0."""
    timing = in_rounds(horizon)
    jerks = tuple(term(row("(13c)", "new", f"u {n} ≥")) for n in range(timing.inputs))
    equations = {row("(13e)", "new", "a"): constant(-1), "a_i = 0": constant(1), "u_i_0 = 0": constant(1)}
    return Certificate(jerks, equations, (term(factor=horizon),))


def _candidates(times: Callable[[Timing], list[Fraction]], timings: Mapping[str, Timing]) -> Later[Evidence]:
    """Return the candidate for all these times, on a line and in space."""
    makers: dict[str, Callable[[], Evidence]] = {
        name: partial(candidate, timing, times(timing)) for name, timing in timings.items()
    }
    for name, halfway in SPACE_QUESTIONS.items():
        makers[name] = partial(candidate, IN_SPACE, times(IN_SPACE), SPACE, halfway)
    return Later(makers)


EVIDENCE: Mapping[str, Mapping[str, Evidence]] = {
    "theorem-1-feasible/printed": _FEASIBLE,
    "theorem-1-feasible/repaired": _candidates(times_20, {**ALIGNED, **ONE_STEP, **BEYOND}),
    "zero-input/repaired": {f"H = {horizon}": _needs_zero(horizon) for horizon in RESTING},
    "theorem-1-keeps-rest/printed": {
        END_V: Vectors(_CANNOT_BRAKE),
        END_A: Vectors(_CANNOT_BRAKE),
        NEXT_FEASIBLE: Unsolvable(_CANNOT_BRAKE, _no_plan(row("(13d)", "new", "p 2 ≤"), 1, Fraction(-1, 3))),
    },
    "theorem-1-keeps-rest/repaired": {
        name: Candidate({}, tuple(shifted_axis(timing))) for name, timing in ALIGNED.items()
    },
    "recursion/printed": _NEXT,
    "recursion/repaired": _candidates(times_18, {**ALIGNED, **BEYOND}),
}
