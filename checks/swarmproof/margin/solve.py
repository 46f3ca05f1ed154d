"""The extreme T_c, v_max or d̂_min for which the corrected inequality is certified (`--solve-for`)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

from swarmproof.errors import BadInput
from swarmproof.margin.bounds import Margin, Proofs, Say, Solver, certified, provers
from swarmproof.margin.problem import Problem
from swarmproof.theorem3.delay import displacement, largest_dip, lost
from swarmproof.theorem3.inequality import (
    Truth,
    corrected,
    crossing_pair,
    largest_loss,
    scaled_square,
    square_root_bounds,
)
from swarmproof.theorem3.nothing import about_nothing
from swarmproof.theorem3.numbers import exact_text
from swarmproof.theorem3.parameters import EXTREMES, Parameters, Reading

#: What can be solved for: the largest T_c or v_max, the smallest d̂_min.
#: How close the two answers are brought to each other, relative to their size, and the largest number of trials.
PRECISION, MOST_TRIALS = Fraction(1, 10**4), 60
#: Digits after the point of the values tried, and the smallest and the largest one.
DIGITS, SMALLEST, LARGEST = 7, Fraction(1, 10**6), Fraction(10**5)
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
    """Decide the corrected inequality without computing the margin more closely than that takes; of nothing, nothing.

    Returns the margin (with its certificate) that certifies it, if it holds.
    """
    given = problem.parameters
    if about_nothing(given, problem.reading):
        return Truth.UNDECIDED, None
    flown = displacement(given, problem.reading)

    def known(lower: Fraction) -> Truth:
        return corrected(given, lost(given, problem.reading, lower, flown[0])[0], given.d_hat_min + flown[1])

    if known(_crossing_dip(given)) is Truth.FAILS:
        return Truth.FAILS, None
    limit = largest_dip(given, problem.reading, largest_loss(given), flown[1])
    solver = Solver(problem, say)
    solver.search()
    if known(solver.lower) is Truth.FAILS:
        return Truth.FAILS, None
    for by in provers(problem) if limit >= 0 else ():
        proofs: Proofs = {}
        if solver.prove(lambda: limit, proofs, by=by):
            found = certified(solver, [proofs], say)
            if found.truths[1] is Truth.HOLDS:
                return Truth.HOLDS, found
    return known(solver.lower), None


def _crossing_dip(given: Parameters) -> Fraction:
    """Return a dip (m) that is there in every reading, in no time: that of two UAVs that pass at constant velocity."""
    pair = crossing_pair(given)
    if pair is None:
        return Fraction(0)
    x, y, z = (one - other for one, other in zip(*pair, strict=True))
    distance = square_root_bounds(scaled_square(given.theta_inverse, (x, y, z)))[1]
    return max(given.d_hat_min - distance, Fraction(0))


def solve_for(name: str, given: Parameters, reading: Reading, say: Say = lambda message: None) -> Extreme:
    """Return the extreme value of `name` for which the corrected inequality is certified.

    The largest dip grows with v_max, and d̂_min minus it with d̂_min. For `initial-state` and `whole-motion` it grows
    with T_c, too (a slower copy of a motion keeps all bounds); for `as-sampled` T_c is T_s/m, with m = 1, 2, … in turn.

    Raises:
        BadInput: a name that cannot be solved for, or parameters that the reading does not take.
    """
    if name not in EXTREMES:
        raise BadInput(f"--solve-for takes one of {', '.join(EXTREMES)}, not {name!r}")
    given.check_reading(reading)
    if name in ("T_c", "d_hat_min") and about_nothing(replace(given, workspace=None), reading):
        return Extreme(name, None, None, None)
    if name == "T_c" and reading is Reading.AS_SAMPLED:
        return _by_division(given, reading, say)
    return _bisect(name, given, reading, say, lower_is_easier=name != "d_hat_min")


def changed(given: Parameters, name: str, value: Fraction) -> Parameters:
    """Return the parameters with `name` set to `value` (v_max: on all axes)."""
    if name == "v_max":
        return replace(given, v_max=(value, value, value))
    if name == "T_c":
        return replace(given, T_c=value)
    if name == "v_norm":  # a box that nobody gave follows
        return given.with_changes([f"v_norm={exact_text(value)}"])
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
    """Bracket by doubling and halving from the given value, then bisect; no value is tried twice."""
    fast = max(given.v_max)
    start = {"T_c": given.T_c, "v_max": fast, "v_norm": given.v_norm or fast, "d_hat_min": given.d_hat_min}[name]
    start = start or Fraction(1)
    easier, harder = (Fraction(1, 2), Fraction(2)) if lower_is_easier else (Fraction(2), Fraction(1, 2))
    known: dict[Fraction, Truth] = {}
    margins: dict[Fraction, Margin] = {}

    def truth_of(value: Fraction) -> Truth:
        if value not in known:
            say(f"trying {name} = {float(value):g}")
            known[value], margin = decide(Problem(changed(given, name, value), reading), say)
            if margin is not None:
                margins[value] = margin
        return known[value]

    def nearest(wanted: Truth) -> Fraction | None:
        """Return the hardest value of those that hold, the easiest of those that fail."""
        values = [value for value, truth in known.items() if truth is wanted]
        largest = lower_is_easier is (wanted is Truth.HOLDS)
        return (max if largest else min)(values, default=None)

    def look_for(wanted: Truth, factor: Fraction) -> None:
        value = start
        while SMALLEST <= value <= LARGEST and truth_of(value) is not wanted and len(known) < MOST_TRIALS:
            value = _rounded(value * factor)

    def narrow(near: Fraction, far: Fraction, wanted: Truth) -> None:
        """Bisect between `near`, of which the `wanted` is true, and `far`, of which it is not."""
        while abs(near - far) > PRECISION * max(near, far) and len(known) < MOST_TRIALS:
            value = _rounded((near + far) / 2)
            if value in (near, far):
                return
            near, far = (value, far) if truth_of(value) is wanted else (near, value)

    look_for(Truth.HOLDS, easier)
    look_for(Truth.FAILS, harder)
    for wanted, other in ((Truth.HOLDS, Truth.FAILS), (Truth.FAILS, Truth.HOLDS)):
        near, far = nearest(wanted), nearest(other)
        if near is not None and far is not None:
            narrow(near, far, wanted)
    holds, fails = nearest(Truth.HOLDS), nearest(Truth.FAILS)
    unknown = sorted(value for value, truth in known.items() if truth is Truth.UNDECIDED)
    if holds is not None and fails is not None:
        unknown = [value for value in unknown if min(holds, fails) < value < max(holds, fails)]
    return Extreme(name, holds, fails, None if holds is None else margins.get(holds), tuple(unknown))


def _rounded(value: Fraction) -> Fraction:
    return Fraction(round(value * 10**DIGITS), 10**DIGITS)
