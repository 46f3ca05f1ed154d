"""Trajectories as polynomials: the same motion as the model's, and the conditions that are written with them."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmproof.algebra.later import Later
from swarmproof.algebra.polynomial import Vector, constant, variable
from swarmproof.dmpc_swarm.proofs.terms.motion import Axis, State, entry, in_rounds, row, symbols
from swarmproof.dmpc_swarm.proofs.terms.problem import (
    SPACE,
    ZERO_ALLOWED,
    ends_at_rest,
    feasible,
    hovering,
    limits,
    special,
    times_13f,
    times_18,
    times_20,
    times_21,
)
from swarmproof.dmpc_swarm.proofs.terms.separation import plane
from swarmproof.motion.integrator import AxisMotion

F = Fraction

numbers = st.fractions(min_value=-5, max_value=5, max_denominator=12)
durations = st.fractions(min_value=F(1, 12), max_value=2, max_denominator=12)


@settings(max_examples=60, deadline=None)
@given(
    state=st.tuples(numbers, numbers, numbers),
    pieces=st.lists(st.tuples(durations, numbers), min_size=1, max_size=4),
    time=st.fractions(min_value=0, max_value=9, max_denominator=24),
)
def test_the_motion_is_the_models(
    state: tuple[Fraction, Fraction, Fraction], pieces: list[tuple[Fraction, Fraction]], time: Fraction
) -> None:
    """The trajectories of the statements are those of the model, at any time, whatever the durations are."""
    ours = Axis(F(0), State(*map(constant, state)), tuple((duration, constant(jerk)) for duration, jerk in pieces))
    theirs = AxisMotion(state, (*pieces, (F(1), F(0))))
    assert tuple(value.at({}) for value in ours.at(time)) == theirs.at(time)
    assert ours.ends == sum(duration for duration, _ in pieces)


def test_a_trajectory_has_no_past() -> None:
    """A time before a trajectory begins is an error."""
    with pytest.raises(ValueError, match="begins at 0, after -1"):
        entry("i", in_rounds(1)).at(-1)


def test_the_published_times() -> None:
    """H = 15, T = T_s = T_b = 0.2 s and T_c = 0.1 s give 15 jerks, h_b = 15 and h_c = 30."""
    timing = in_rounds(15, 2, period=F(1, 5))
    assert (timing.inputs, timing.bounds, timing.samples) == (15, 15, 30)
    assert (timing.length, timing.sample_step, timing.bound_step) == (F(3), F(1, 10), F(1, 5))
    assert (times_20(timing)[0], times_20(timing)[-1]) == (F(1, 5), F(31, 10))
    assert (times_13f(timing)[-1], times_18(timing)[-1], times_21(timing)[0]) == (F(16, 5), F(3), F(3, 10))


@pytest.mark.parametrize("halfway", [False, True])
def test_the_planes_are_those_of_one_sample(halfway: bool) -> None:
    """(13f) is, sample by sample, the constraint of the claims about one sample, with its own length."""
    problem = feasible(in_rounds(2, 2), times_20(in_rounds(2, 2)), halfway=halfway)
    own, other, new = (Vector([variable(name)]) for name in ("own", "other", "new"))
    at_start = {
        "own": entry("i", in_rounds(2, 2)).at(1).p,
        "other": entry("j", in_rounds(2, 2)).at(1).p,
        "l": variable("l_0"),
    }
    expected = plane("", own, other, new, halfway).value.put({**at_start, "new": at_start["own"]})
    assert next(each for each in problem.constraints if each.name == "(13f), h = 0").value == expected


def test_names_of_rows() -> None:
    """A row says which equation, whose, what and on which axis it is."""
    assert row("(13d)", "i", "p 0") == "(13d) i: p 0"
    assert row("(13d)", "i", "p 0", "x") == "(13d) i: p 0 x"
    names = [each.name for each in feasible(in_rounds(1), [F(1)], axes=SPACE).hypotheses]
    assert len(names) == len(set(names))


def test_later_makes_each_value_once() -> None:
    """A value is made when it is first asked for, and then kept."""
    made: list[str] = []

    def make() -> int:
        made.append("a")
        return 1

    later = Later({"a": make, "b": lambda: 2})
    assert (len(later), list(later), "a" in later, "c" in later, made) == (2, ["a", "b"], True, False, [])
    assert (later["a"], later["a"], made) == (1, 1, ["a"])
    with pytest.raises(KeyError):
        later["c"]


def test_a_special_case_says_no_more_than_the_statement() -> None:
    """What is put in is gone; hypotheses that are plain then, or said twice, are left out, and no others."""
    timing = in_rounds(2)
    whole, _ = ends_at_rest(timing)
    values = {**limits(u=(-1, 1), p=(0, 9), v=(0, 2), a=(-3, 3)), **hovering("j", timing)}
    case = special(whole, values)
    left = {name for each in (*case.hypotheses, case.conclusion) for name in each.value.variables}
    assert left.isdisjoint(values)
    expected = {(each.put(values).value, each.sign) for each in whole.hypotheses}
    kept = [(each.value, each.sign) for each in case.hypotheses]
    assert len(kept) == len(set(kept))
    assert expected >= set(kept)
    assert all(not value.variables and value.at({}) >= 0 for value, _ in expected - set(kept))


def test_a_special_case_keeps_what_is_plainly_false() -> None:
    """A hypothesis that is false of all numbers is not left out: it would make a counterexample of nothing."""
    problem = special(feasible(in_rounds(1), [F(1)]), limits(u=(1, 2)))
    assert [each.name for each in problem.hypotheses if not each.value.variables] == [f"{ZERO_ALLOWED} ≥"]


def test_symbols_have_the_axis_at_the_end() -> None:
    """On a line there is no axis to name."""
    assert list(map(str, symbols("i"))) == ["p_i", "v_i", "a_i"]
    assert list(map(str, symbols("i", "z"))) == ["p_i_z", "v_i_z", "a_i_z"]
