"""The extreme T_c, v_max or d̂_min for which the corrected inequality is certified (`--solve-for`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

from swarmproof.margin.bounds import Margin, Proofs, Say, Solver, certified
from swarmproof.margin.problem import Problem
from swarmproof.semantics.switches import BadInput
from swarmproof.theorem3.inequality import Truth, corrected, spectral_norm_bounds
from swarmproof.theorem3.parameters import Parameters, Reading

#: What can be solved for: the largest T_c or v_max, the smallest d̂_min.
NAMES = ("T_c", "v_max", "d_hat_min")
#: How close the two answers are brought to each other, relative to their size, and the largest number of trials.
PRECISION, MOST_TRIALS = Fraction(1, 10**4), 60
#: Digits after the point of the values tried.
DIGITS = 7
#: The largest T_s/T_c that is tried.
MOST_WINDOWS = 200


@dataclass(frozen=True)
class Extreme:
    """The extreme value for which the corrected inequality is `certified`, and the nearest one that is `refuted`.

    `margin` certifies the former; None where there is no such value. SI units. `undecided` are values in between.
    """

    name: str
    certified: Fraction | None
    refuted: Fraction | None
    margin: Margin | None
    undecided: tuple[Fraction, ...] = ()


def decide(problem: Problem, say: Say = lambda message: None) -> tuple[Truth, Margin | None]:
    """Decide the corrected inequality without computing the margin more closely than that takes.

    Returns the margin (with its certificate) that certifies it, if it holds.
    """
    given = problem.parameters
    if corrected(given, Fraction(0), Fraction(0)) is Truth.FAILS:
        return Truth.FAILS, None
    high = spectral_norm_bounds(given.theta_inverse)[1]
    limit = given.d_hat_min - given.d_min - 2 * high * given.tracking_error
    solver = Solver(problem, say)
    solver.search()
    if corrected(given, solver.lower, given.d_hat_min) is Truth.FAILS:
        return Truth.FAILS, None
    proofs: Proofs = {}
    if solver.prove(lambda: limit, proofs):
        return Truth.HOLDS, certified(solver, [proofs], say)
    return corrected(given, solver.lower, given.d_hat_min), None


def solve_for(name: str, given: Parameters, reading: Reading, say: Say = lambda message: None) -> Extreme:
    """Return the extreme value of `name` for which the corrected inequality is certified.

    The largest dip grows with v_max, and d̂_min minus it with d̂_min. For `initial-state` and `whole-motion` it grows
    with T_c, too (a slower copy of a motion keeps all bounds); for `as-sampled` T_c is T_s/m, with m = 1, 2, … in turn.

    Raises:
        BadInput: a name that cannot be solved for, or parameters that the reading does not take.
    """
    if name not in NAMES:
        raise BadInput(f"--solve-for takes one of {', '.join(NAMES)}, not {name!r}")
    given.check_reading(reading)
    if name == "T_c" and reading is Reading.AS_SAMPLED:
        return _by_division(given, reading, say)
    return _bisect(name, given, reading, say, lower_is_easier=name != "d_hat_min")


def changed(given: Parameters, name: str, value: Fraction) -> Parameters:
    """Return the parameters with `name` set to `value` (v_max: on all axes)."""
    if name == "v_max":
        return replace(given, v_max=(value, value, value))
    if name == "T_c":
        return replace(given, T_c=value)
    return replace(given, d_hat_min=value)


def _by_division(given: Parameters, reading: Reading, say: Say) -> Extreme:
    refuted: Fraction | None = None
    undecided: list[Fraction] = []
    for m in range(1, MOST_WINDOWS + 1):
        value = given.T_s / m
        say(f"trying T_c = T_s/{m}")
        truth, margin = decide(Problem(changed(given, "T_c", value), reading), say)
        if truth is Truth.HOLDS:
            return Extreme("T_c", value, refuted, margin, tuple(undecided))
        if truth is Truth.FAILS:
            refuted, undecided = value, []
        else:
            undecided.append(value)
    return Extreme("T_c", None, refuted, None, tuple(undecided))


def _bisect(name: str, given: Parameters, reading: Reading, say: Say, lower_is_easier: bool) -> Extreme:
    """Bracket by doubling or halving from the given value, then bisect."""
    start = {"T_c": given.T_c, "v_max": max(given.v_max), "d_hat_min": given.d_hat_min}[name] or Fraction(1)
    undecided: set[Fraction] = set()
    margins: dict[Fraction, Margin] = {}

    def truth_of(value: Fraction) -> Truth:
        say(f"trying {name} = {float(value):g}")
        truth, margin = decide(Problem(changed(given, name, value), reading), say)
        if margin is not None:
            margins[value] = margin
        if truth is Truth.UNDECIDED:
            undecided.add(value)
        return truth

    easier: Callable[[Fraction], Fraction] = (lambda v: v / 2) if lower_is_easier else (lambda v: v * 2)
    harder: Callable[[Fraction], Fraction] = (lambda v: v * 2) if lower_is_easier else (lambda v: v / 2)
    holds: Fraction | None = None
    fails: Fraction | None = None
    value, trials = start, 0
    while (holds is None or fails is None) and trials < MOST_TRIALS:
        trials += 1
        truth = truth_of(value)
        if truth is Truth.HOLDS:
            holds = value
        elif truth is Truth.FAILS:
            fails = value
        value = _rounded(harder(value) if truth is Truth.HOLDS else easier(value))
        if not Fraction(1, 10**6) <= value <= 10**5:
            break
    while holds is not None and fails is not None and abs(holds - fails) > PRECISION * max(holds, fails):
        trials += 1
        value = _rounded((holds + fails) / 2)
        if value in (holds, fails) or trials > MOST_TRIALS:
            break
        truth = truth_of(value)
        if truth is Truth.HOLDS:
            holds = value
        elif truth is Truth.FAILS:
            fails = value
        else:
            break
    return Extreme(name, holds, fails, margins.get(holds) if holds else None, tuple(sorted(undecided)))


def _rounded(value: Fraction) -> Fraction:
    return Fraction(round(value * 10**DIGITS), 10**DIGITS)
