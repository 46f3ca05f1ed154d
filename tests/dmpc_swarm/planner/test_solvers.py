"""Our way of calling PIQP: what it says of small problems whose answers are known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from tests.dmpc_swarm.flight.settings import GARBAGE, recorded

from swarmproof.dmpc_swarm.planner.planner import Planner
from swarmproof.motion.lattice import Floats
from swarmproof.qp.solvers import GAP, TOLERANCE, Answer, QuadraticProgram, Solver, Status, solve_with_piqp
from swarmproof.scenario.scenario import Weights

#: The optimum x is about as near as the square root of the gap, whose curvature is 1 here; twice it for all axes.
NEAR = 2 * GAP**0.5


def program(
    towards: Sequence[float],
    equal: Sequence[tuple[Sequence[float], float]] = (),
    most: Sequence[tuple[Sequence[float], float]] = (),
    bound: float = 10.0,
) -> QuadraticProgram:
    """Return the problem of coming as near to a point as rows a·x = b, rows g·x ≤ h and |x| ≤ bound allow."""
    n = len(towards)

    def rows(of: Sequence[tuple[Sequence[float], float]]) -> tuple[Floats, Floats]:
        matrix = np.array([row for row, _ in of], float).reshape(-1, n)
        return np.asfortranarray(matrix), np.array([value for _, value in of], float)

    A, b = rows(equal)
    G, h = rows(most)
    eye: Floats = np.asfortranarray(np.eye(n))
    return QuadraticProgram(eye, -np.array(towards, float), A, b, G, h, np.full(n, -bound), np.full(n, bound))


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        (program([3, -4]), [3, -4]),
        (program([3, -4], bound=2), [2, -2]),
        (program([3, 5], equal=[([1, 1], 2)]), [0, 2]),
        (program([3, 4], most=[([1, 0], 1)]), [1, 4]),
        (program([3, 4], most=[([3, 4], 5)]), [0.6, 0.8]),
        (program([3, 4], equal=[([1, 0], 1)], most=[([1, 1], 2), ([-1, 0], 100)]), [1, 1]),
        (program([3, 4, 5], most=[([1, 0, 0], 7)]), [3, 4, 5]),
    ],
)
def test_known_problems_are_solved(asked: QuadraticProgram, answer: Sequence[float]) -> None:
    """Without rows, with equalities, inequalities and bounds, active or not, the answer is that found by hand."""
    found = solve_with_piqp(asked)
    assert found.status is Status.SOLVED
    assert np.abs(found.x - answer).max() < NEAR
    if len(asked.h):
        assert (asked.G @ found.x <= asked.h + 10 * TOLERANCE).all()
    if len(asked.b):
        assert np.abs(asked.A @ found.x - asked.b).max() < 10 * TOLERANCE


@pytest.mark.parametrize(
    "asked",
    [
        program([0, 0], most=[([1, 0], -1), ([-1, 0], -1)]),
        program([0, 0], equal=[([1, 0], 11)]),
        program([0, 0], most=[([1, 1], -21)]),
        program([0, 0], most=[([0, 0], -0.25)]),
    ],
)
def test_infeasible_problems_are_called_so(asked: QuadraticProgram) -> None:
    """Rows that contradict each other or the bounds, or that nothing satisfies, are found to."""
    assert solve_with_piqp(asked).status is Status.INFEASIBLE


def test_what_is_neither_solved_nor_infeasible_is_given_up() -> None:
    """A program of NaN is not called solved, and nothing is raised."""
    asked = program([1, 2], most=[([1, 0], 1)])
    asked.c[0] = np.nan
    assert solve_with_piqp(asked).status is not Status.SOLVED


def test_an_answer_is_the_callers() -> None:
    """An answer does not change when other problems are solved, and the same problem has the same answer to the bit."""
    first = solve_with_piqp(program([3, 4], most=[([3, 4], 5)]))
    kept = first.x.copy()
    for x in range(20):
        solve_with_piqp(program([x, -x], most=[([1, 1], 0)]))
    again = solve_with_piqp(program([3, 4], most=[([3, 4], 5)]))
    assert first.x.tobytes() == kept.tobytes() == again.x.tobytes()


def test_programs_have_the_shapes_that_solvers_expect() -> None:
    """What the planner asks is convex, in column-major order, with as many rows as right-hand sides, all finite."""
    seen: list[QuadraticProgram] = []

    def solve(asked: QuadraticProgram) -> Answer:
        seen.append(asked)
        return solve_with_piqp(asked)

    tasks = recorded("circle", 2, "iid:0.1", 40, changes=("uavs=5",))
    plans = Planner(tasks[0][0].own.lattice, Weights(), solve)
    for task, _ in tasks[:20]:
        plans.plan(task)
    assert {len(asked.c) for asked in seen} > {39, 40}
    for asked in seen:
        n = len(asked.c)
        assert asked.P.shape == (n, n)
        assert asked.A.shape == (len(asked.b), n) == (0, n)
        assert asked.G.shape == (len(asked.h), n)
        assert asked.low.shape == asked.high.shape == (n,)
        assert (asked.low < asked.high).all()
        assert np.array_equal(asked.P, asked.P.T)
        assert np.linalg.eigvalsh(asked.P).min() > 0
        assert all(matrix.flags.f_contiguous for matrix in (asked.P, asked.A, asked.G))
        assert all(np.isfinite(array).all() for array in asked[:6])


def right(solve: Solver) -> bool:
    """Return whether a solver is right about two simple problems: one with x = (0.6, 0.8), one without a solution."""
    good = solve(program([3, 4], most=[([3, 4], 5)], equal=[([4, -3], 0)]))
    bad = solve(program([0, 0], most=[([0, 0], -0.25)]))
    found = good.status is Status.SOLVED and bool(np.abs(good.x - (0.6, 0.8)).max() < NEAR)
    return found and bad.status is Status.INFEASIBLE


@pytest.mark.parametrize("name", GARBAGE)
def test_garbage_is_garbage(name: str) -> None:
    """Each of the solvers that the planner is tested with is wrong about one of two simple problems; PIQP is not."""
    assert right(solve_with_piqp)
    assert not right(GARBAGE[name]())
