"""Problem (13) for one UAV and one neighbour, with real trajectories: is it feasible, and what do old entries keep?

UAVs i and j fly entries of D(k), from time 0 to H·T; problem (13) plans UAV i from T on. Positions are scaled by Θ⁻¹.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TypeVar

from swarmproof.algebra.polynomial import Number, Polynomial, Vector, constant, variable
from swarmproof.algebra.statement import Condition, Sign, Solvable, Statement, above, at_least, equal
from swarmproof.dmpc_swarm.proofs.terms.motion import Axis, Timing, allowed, entry, jerk_names, planned, rests, within
from swarmproof.dmpc_swarm.proofs.terms.separation import D_POSITIVE, D, apart, plane

#: The axes of a trajectory: on a line, none needs a name.
LINE: tuple[str, ...] = ("",)
SPACE: tuple[str, ...] = ("x", "y", "z")
Motion = Mapping[str, Axis]

ZERO_ALLOWED = "0 is in Û"


def place(motion: Motion, time: Fraction) -> Vector:
    """Return the position at `time`."""
    return Vector(axis.at(time).p for axis in motion.values())


def entries(name: str, timing: Timing, axes: Sequence[str]) -> Motion:
    """Return an entry of a tracker, all of whose states and jerks are variables."""
    return {axis: entry(name, timing, axis) for axis in axes}


def motion_allowed(name: str, motion: Motion, timing: Timing, rest: bool = True) -> list[Condition]:
    """Return (13c), (13d) and, if `rest`, (13e) on all axes."""
    return [each for axis, one in motion.items() for each in allowed(name, one, timing, axis, rest)]


def times_20(timing: Timing) -> list[Fraction]:
    """Return the times of (20): h = 0 … h_c − 1 at hT_c + 2T of round k − 1."""
    return [timing.period + h * timing.sample_step for h in range(timing.samples)]


def times_13f(timing: Timing) -> list[Fraction]:
    """Return the times of (13f): h = 0 … h_c at hT_c + T of round k."""
    return [timing.period + h * timing.sample_step for h in range(timing.samples + 1)]


def times_18(timing: Timing) -> list[Fraction]:
    """Return the times of (18), h = 1 … h_c at hT_c + T of round k − 1; (21) of round k − 1 is about them, too."""
    return [h * timing.sample_step for h in range(1, timing.samples + 1)]


def times_21(timing: Timing) -> list[Fraction]:
    """Return the times of (21): h = 1 … h_c at hT_c + T of round k."""
    return times_13f(timing)[1:]


def apart_at(time: Fraction) -> str:
    """Return the name of the condition that the entries of UAVs i and j are d̂_min apart at `time`."""
    return f"d apart at {time}"


def entries_apart(i: Motion, j: Motion, times: Iterable[Fraction]) -> list[Condition]:
    """Return that two entries are d̂_min apart at these times."""
    return [apart(apart_at(time), place(i, time), place(j, time)) for time in times]


def normal(h: int) -> str:
    """Return the name of the variable that is ‖n_ij‖ at sample h of (13f)."""
    return f"l_{h}"


def length_is(h: int) -> str:
    """Return the name of the hypothesis that defines ‖n_ij‖ at sample h."""
    return f"{normal(h)} is the length of n_ij"


def length_sign(h: int) -> str:
    """Return the name of the hypothesis that this length is not negative."""
    return f"{normal(h)} >= 0"


def hypotheses(
    timing: Timing, apart_times: Iterable[Fraction], axes: Sequence[str] = LINE, rest: bool = True
) -> tuple[Condition, ...]:
    """Return what Theorem 1 assumes of one entry of D_i(k) and one of D_j(k).

    Args:
        timing: of both.
        apart_times: when they are d̂_min apart.
        axes: names of the axes.
        rest: whether (13e) is assumed besides (13b)-(13d).
    """
    i, j = (entries(name, timing, axes) for name in "ij")
    own = [*motion_allowed("i", i, timing, rest), *motion_allowed("j", j, timing, rest)]
    return (above(D_POSITIVE, D), *own, *entries_apart(i, j, apart_times))


Asked = TypeVar("Asked", Statement, Solvable)


def special(question: Asked, values: Mapping[str, Polynomial | Number]) -> Asked:
    """Return a case of a statement: with these variables replaced, and without hypotheses that are then plain.

    What refutes the case refutes the statement. A hypothesis is left out if it is true of all numbers, having no
    variables any more, or if it is another one once more.
    """
    kept: dict[tuple[Polynomial, Sign], Condition] = {}
    for each in question.hypotheses:
        put = each.put(dict(values))
        if put.value.variables or not put.holds({}):
            kept.setdefault((put.value, put.sign), put)
    known = tuple(kept.values())
    if isinstance(question, Statement):
        return replace(question, hypotheses=known, conclusion=question.conclusion.put(dict(values)))
    constraints = tuple(each.put(dict(values)) for each in question.constraints)
    return replace(question, hypotheses=known, constraints=constraints)


def limits(**ends: tuple[Number, Number]) -> dict[str, Polynomial | Number]:
    """Return numbers for the ends of Û (`u`) and of X (`p`, `v`, `a`), to be put into a statement."""
    return {
        f"{symbol}_{end}": each for symbol, both in ends.items() for end, each in zip(("min", "max"), both, strict=True)
    }


def hovering(name: str, timing: Timing) -> dict[str, Polynomial | Number]:
    """Return that the entry of this name hovers, to be put into a statement; where, is left to a variable."""
    return dict.fromkeys((f"v_{name}", f"a_{name}", *jerk_names(name, timing)), 0)


def zero_allowed(axes: Sequence[str]) -> list[Condition]:
    """Return that 0 is in Û."""
    return [each for axis in axes for each in within(f"{ZERO_ALLOWED}{axis and ' '}{axis}", constant(0), "u", axis)]


def feasible(
    timing: Timing,
    apart_times: Iterable[Fraction],
    *,
    axes: Sequence[str] = LINE,
    halfway: bool = False,
    rest: bool = True,
    zero: bool = True,
) -> Solvable:
    """Return that problem (13) of UAV i in round k is feasible, beside one entry of UAV j.

    Args:
        timing: of all trajectories.
        apart_times: when the entries of i and j are d̂_min apart.
        axes: names of the axes.
        halfway: whether j is in A_ET(k), see (15).
        rest: whether the entries satisfy (13e).
        zero: whether 0 is in Û.
    """
    i, j = (entries(name, timing, axes) for name in "ij")
    new = {axis: planned("new", timing, i[axis], axis) for axis in axes}
    lengths, planes = [], []
    for h, time in enumerate(times_13f(timing)):
        size = variable(normal(h))
        own, other = place(i, time), place(j, time)
        lengths += [equal(length_is(h), size * size, (other - own).square), at_least(length_sign(h), size)]
        planes.append(plane(f"(13f), h = {h}", own, other, place(new, time), halfway, size=size))
    return Solvable(
        (*hypotheses(timing, apart_times, axes, rest), *(zero_allowed(axes) if zero else ()), *lengths),
        tuple(name for axis in axes for name in jerk_names("new", timing, axis)),
        (*motion_allowed("new", new, timing), *planes),
    )


def shifted_jerks(timing: Timing, axis: str = "") -> tuple[Polynomial, ...]:
    """Return the jerks from T on of an entry of D_i(k), seen from round k: those after the first T, then zeros."""
    names = jerk_names("i", timing, axis)[int(timing.period / timing.input_step) :]
    return (*map(variable, names), *[constant(0)] * (timing.inputs - len(names)))


def stays(timing: Timing, axes: Sequence[str] = LINE) -> Solvable:
    """Return that an entry of D_i(k) that is still one of D_i(k+1) satisfies (13b)-(13e), seen from round k."""
    i = entries("i", timing, axes)
    later = {
        axis: Axis(
            timing.period,
            one.at(timing.period),
            tuple((timing.input_step, jerk) for jerk in shifted_jerks(timing, axis)),
        )
        for axis, one in i.items()
    }
    known = (*motion_allowed("i", i, timing), *zero_allowed(axes))
    return Solvable(known, (), tuple(motion_allowed("later", later, timing)))


def old_apart(
    timing: Timing, given: Iterable[Fraction], needed: Iterable[Fraction], *, axes: Sequence[str] = LINE, rest: bool
) -> Solvable:
    """Return Lemma 4 for two entries of D(k) that were not planned: apart at times `given`, they are at `needed`.

    `rest`: whether they satisfy (13e) besides (13b)-(13d).
    """
    i, j = (entries(name, timing, axes) for name in "ij")
    return Solvable(hypotheses(timing, given, axes, rest), (), tuple(entries_apart(i, j, needed)))


def ends_at_rest(timing: Timing) -> tuple[Statement, Statement]:
    """Return that (20) and (13b)-(13d) imply (13e), for the entry of UAV i: its velocity and its acceleration."""
    known = hypotheses(timing, times_20(timing), rest=False)
    v, a = rests("i", entry("i", timing), timing)
    return Statement(known, v), Statement(known, a)
