"""What bounds imply together: no plan exceeds it, and it is not far from what plans can do."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog
from tests.margin.settings import examples

from swarmproof.dmpc_swarm.flight.place import implied
from swarmproof.motion.lattice import Bounds
from swarmproof.theorem3.parameters import Parameters

F = Fraction
#: The linear program's answers are relative to the bounds it is asked about, and this good.
CLOSE = 1e-6


class Limits(NamedTuple):
    """Bounds of one axis: m/s, m/s², m/s³."""

    v: Fraction
    a: Fraction
    j: Fraction


class Problem(NamedTuple):
    """The bounds that are given, the period T (s) and the horizon H."""

    given: Limits
    period: Fraction
    horizon: int

    @property
    def implied(self) -> Limits:
        """What they imply."""
        parameters = Parameters(
            T_s=self.period,
            T_b=self.period,
            T_c=self.period,
            v_max=(self.given.v,) * 3,
            a_max=(self.given.a,) * 3,
            j_max=(self.given.j,) * 3,
            workspace=((F(-1), F(1)),) * 3,
        )
        found = implied(parameters, self.horizon)
        assert found.space == Bounds.of(parameters).space
        return Limits(found.v_max[0], found.a_max[0], found.j_max[0])


def largest(problem: Problem) -> Limits:
    """Return the largest speed, acceleration (at ends of periods) and jerk of plans within what is given, in floats.

    By a linear program for each period. Its variables are jerks, and the speeds and accelerations at all ends of
    periods, by what the implied bounds say; positions are free.
    """
    horizon, period = problem.horizon, float(problem.period)
    scale = np.array([float(bound) for bound in problem.implied])
    v, a, j = scale
    size = horizon + 1
    rows = []
    for k in range(horizon):
        row = np.zeros((2, 2 * size + horizon))
        # in units of the implied bounds
        row[0, [k, k + 1, size + k, 2 * size + k]] = 1, -1, period * a / v, period**2 / 2 * j / v
        row[1, [size + k, size + k + 1, 2 * size + k]] = 1, -1, period * j / a
        rows.append(row)
    most = [float(given / bound) for given, bound in zip(problem.given, problem.implied, strict=True)]
    box = [(-x, x) for x, count in zip(most, (size, size, horizon), strict=True) for _ in range(count)]
    box[horizon] = box[size + horizon] = (0, 0)
    equations = np.concatenate(rows)

    def most_of(first: int, count: int) -> float:
        found = 0.0
        for place in range(first, first + count):
            cost = np.zeros(len(box))
            cost[place] = -1
            answer = linprog(cost, A_eq=equations, b_eq=np.zeros(len(equations)), bounds=box)
            assert answer.fun is not None
            found = max(found, -answer.fun)
        return found

    at = (most_of(0, size), most_of(size, size), most_of(2 * size, horizon))
    return Limits(*(F(share * bound) for share, bound in zip(at, scale.tolist(), strict=True)))


def shares(problem: Problem, of: Limits) -> list[float]:
    """Return which share of the bounds `of` plans can reach."""
    return [float(reached / bound) for reached, bound in zip(largest(problem), of, strict=True)]


def problem_of(size: Fraction, tight: Fraction, loose: Fraction, kind: int, period: Fraction, horizon: int) -> Problem:
    """Return a problem in which one kind of bounds, v, a or j, is tighter than others of the same size."""
    bounds = [size * period**2, size * period, size]
    bounds = [bound * (tight if n == kind else loose) for n, bound in enumerate(bounds)]
    return Problem(Limits(*bounds), period, horizon)


PROBLEMS = st.builds(
    problem_of,
    st.integers(-2, 2).map(lambda power: F(10) ** power),
    st.integers(1, 40).map(lambda n: F(n, 10)),
    st.integers(0, 9).map(lambda power: F(3) * F(10) ** power),
    st.integers(0, 2),
    st.sampled_from([F(1, 5), F(1), F(1, 30)]),
    st.integers(2, 12),
)
#: The bounds of which one binds, by what it is: the others follow from it, or are as large.
BINDING = {
    "v": Problem(Limits(F(2), F(10**9), F(10**9)), F(1, 5), 6),
    "a": Problem(Limits(F(10**9), F(3), F(10**9)), F(1, 5), 6),
    "j": Problem(Limits(F(10**9), F(10**9), F(5)), F(1, 5), 6),
    "all": Problem(Limits(F(2), F(2), F(5)), F(1, 5), 15),
}


@given(PROBLEMS, st.data())
@examples(150)
def test_no_plan_exceeds_what_is_implied(problem: Problem, data: st.DataObject) -> None:
    """A plan at random, as fast as it may be, keeps within what is implied; in fractions."""
    jerks = data.draw(
        st.one_of(
            st.lists(st.integers(-100, 100), min_size=problem.horizon, max_size=problem.horizon),
            # with the sharpest turns: speeds are v, −v, v, … and then 0
            st.just([(-1) ** k * max(4 * k, 1) for k in reversed(range(problem.horizon))]),
        )
    )
    v = a = F(0)
    speeds, accelerations = [v], [a]
    # back from rest
    for u in reversed(jerks):
        a -= problem.period * u
        v -= problem.period * a + problem.period**2 / 2 * u
        speeds.append(v)
        accelerations.append(a)
    largest_ = [max(map(abs, values)) for values in (speeds, accelerations, [F(u) for u in jerks])]
    if not any(jerks):
        return
    factor = min(bound / value for bound, value in zip(problem.given, largest_, strict=True) if value)
    assert all(factor * value <= bound for value, bound in zip(largest_, problem.implied, strict=True))


@given(PROBLEMS)
@examples(25)
def test_a_linear_program_finds_none_either(problem: Problem) -> None:
    """Nor does the plan exceed it that a linear program finds for each speed, acceleration and jerk."""
    assert max(shares(problem, problem.implied)) <= 1 + CLOSE
    assert all(bound <= given_ for bound, given_ in zip(problem.implied, problem.given, strict=True))


@pytest.mark.parametrize("problem", BINDING.values(), ids=BINDING)
def test_what_is_implied_is_nearly_reached(problem: Problem) -> None:
    """Where a single bound binds, all that follows from it is reached but for a factor of 2 or so."""
    reached = shares(problem, problem.implied)
    assert 0.99 < max(reached) <= 1 + CLOSE
    assert min(reached) > 0.4


def test_bounds_that_are_no_good_are_noticed() -> None:
    """Of bounds as they are given, a tiny share is reached; of half of what is implied, more than all."""
    for kind, problem in BINDING.items():
        half = Limits(*(bound / 2 for bound in problem.implied))
        assert max(shares(problem, half)) > 1.9
        assert (min(shares(problem, problem.given)) < 1e-3) == (kind != "all")
