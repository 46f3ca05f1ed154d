"""The benchmark measures what it says: the same tasks, solved and accepted in every way; times are not looked at."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from tests.bench import planner as benchmark
from tests.bench.contest import OURS, SOLVERS, Calls, Parts, contenders, parts, race
from tests.bench.flights import Timed
from tests.bench.planner import SCHEMA, Figures, Size, circle, document, main, measure, show
from tests.bench.recording import record
from tests.bench.situation import Axis, Situation

from swarmproof.dmpc_swarm.flight.fly import Plans
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import Lattice
from swarmproof.qp.solvers import GAP, Answer, QuadraticProgram, Status, solve_with_piqp

SETTING = circle(["uavs=7"], cus=2)
LATTICE = Lattice.of(SETTING.scenario.parameters, SETTING.scenario.horizon)
WEIGHTS = SETTING.scenario.weights
AXIS = Axis(LATTICE, WEIGHTS)
INSTALLED = tuple(name for name in SOLVERS if find_spec("piqp" if name == "piqp_sparse" else name))


@pytest.fixture(scope="module")
def tasks() -> list[Task]:
    """Return some tasks of a flight with losses, early and late ones."""
    return record(SETTING, parse("iid:0.05", 7, 2, 0), 60)[::9]


class Idle:
    """Returns the old trajectory, shifted, as if it were the best plan."""

    def plan(self, task: Task) -> Planned:
        """Return it."""
        return Planned(task.own.shifted(task.start), Status.SOLVED, "", True)


def costs(planned: Sequence[Planned], tasks: Sequence[Task]) -> list[float]:
    """Return the cost (13a) of each plan."""
    return [
        Situation(AXIS, task).cost(one.plan.jerks * AXIS.jerk_unit)
        for one, task in zip(planned, tasks, strict=True)
        if one.plan is not None
    ]


def too_dear(planned: Sequence[Planned], best: Sequence[Planned], tasks: Sequence[Task]) -> list[int]:
    """Return the tasks in which plans cost more, or less, than the `best` ones by more than solvers may be off.

    A solver's answer is off the optimum by its duality gap, GAP of the objective or of 1, and where the solver's own
    measure of it differs, by a few times that. The objective is the cost but for a constant, the cost of a motion
    without jerks or one that ends at rest, which the cost of the old trajectory is not far from.
    """
    pairs = zip(
        costs(planned, tasks), costs(best, tasks), costs([Idle().plan(task) for task in tasks], tasks), strict=True
    )
    return [
        place
        for place, (one, other, idle) in enumerate(pairs)
        if abs(one - other) > 5 * GAP * max(1.0, idle) + 1e-5 * max(one, other)
    ]


def test_the_recorded_tasks_are_those_of_the_flight() -> None:
    """Planning them again gives what was planned in the flight; they end with the arrival of all."""
    again = record(SETTING, parse("none", 7, 2, 0), 60)
    assert [task.k for task in again] == sorted(task.k for task in again)
    assert 0 < len(again) < 2 * 60
    planner = Planner(LATTICE, WEIGHTS)
    flown = {plan.digest for task in again for plans in task.others.values() for plan in plans}
    planned = [planner.plan(task).plan for task in again[:20]]
    assert all(plan is not None and plan.digest in flown for plan in planned)


def test_losses_leave_two_trajectories_of_a_uav(tasks: list[Task]) -> None:
    """The recorded tasks contain some with more than one trajectory of another UAV, which means more planes."""
    assert any(len(held) > 1 for task in tasks for held in task.others.values())


def test_every_way_gives_accepted_plans_of_nearly_equal_cost(tasks: list[Task]) -> None:
    """All solvers that are installed, and all forms of the problem, plan every task, about equally well."""
    names = [name for name in INSTALLED if name != "osqp"]
    ways, skipped = contenders(LATTICE, WEIGHTS, names)
    assert not skipped
    assert len(ways) == 1 + len(names) + 6
    calls = race(ways, tasks)
    for name, found in calls.items():
        assert found.accepted == len(tasks), name
        assert len(found.seconds) == len(tasks)
        assert min(found.seconds) > 0
        assert too_dear(found.planned, calls[OURS].planned, tasks) == [], name


@pytest.mark.skipif("osqp" not in INSTALLED, reason="osqp is not installed")
def test_osqp_plans_some(tasks: list[Task]) -> None:
    """An operator-splitting method does not always get there; where it does, the plan is as good as others."""
    ways, _ = contenders(LATTICE, WEIGHTS, ["osqp"])
    calls = race({name: way for name, way in ways.items() if name.startswith("ours")}, tasks[:6])
    theirs = calls["ours with osqp"]
    some = [n for n, planned in enumerate(theirs.planned) if planned.plan is not None]
    assert some
    ours = [calls[OURS].planned[n] for n in some]
    assert too_dear([theirs.planned[n] for n in some], ours, [tasks[n] for n in some]) == []


def test_a_way_that_does_not_optimise_is_noticed(tasks: list[Task]) -> None:
    """What keeps the old trajectory is accepted, but costs more: the comparison of costs sees it."""
    calls = race({OURS: Planner(LATTICE, WEIGHTS), "idle": Idle()}, tasks)
    assert calls["idle"].accepted == len(tasks)
    assert len(too_dear(calls["idle"].planned, calls[OURS].planned, tasks)) > len(tasks) / 2


def test_garbage_counts_as_rejected(tasks: list[Task]) -> None:
    """A solver whose answers are wrong gets no plan accepted, and the figures say so."""

    def wrong(program: QuadraticProgram) -> Answer:
        return Answer(Status.SOLVED, solve_with_piqp(program).x + 1.0)

    ways: dict[str, Plans] = {OURS: Planner(LATTICE, WEIGHTS), "wrong": Planner(LATTICE, WEIGHTS, wrong)}
    calls = race(ways, tasks[:4])
    figures = Figures(7, 4, 0, calls, {}, parts(LATTICE, WEIGHTS, tasks[:4]), (Timed("none", 3, 0.2, (1.0,)),))
    assert [(row["name"], row["accepted"], row["rejected"]) for row in document(figures)["calls"]] == [
        (OURS, 4, 0),
        ("wrong", 0, 4),
    ]


def test_all_take_turns() -> None:
    """Every way plans every task once, one after the other, and another one begins each time."""
    order: list[str] = []

    class Noting:
        def __init__(self, name: str) -> None:
            self.name = name

        def plan(self, task: Task) -> Planned:
            assert "planes" not in vars(task)
            order.append(self.name)
            return Idle().plan(task)

    some = record(SETTING, parse("none", 7, 2, 0), 3)[:4]
    assert len(some[0].planes.owners) == 6
    race({name: Noting(name) for name in "abc"}, some)
    assert "".join(order) == "abcbcacababc"


def test_the_parts_are_those_of_our_calls(tasks: list[Task]) -> None:
    """Building, solving and accepting take time, and the solver is asked at least once a call."""
    found = parts(LATTICE, WEIGHTS, tasks[:5])
    assert all(len(part) == 5 for part in (found.build, found.solver, found.accept, found.solves, found.whole))
    assert (found.solver > 0).all()
    assert (found.accept > 0).all()
    assert (found.solves >= 1).all()


def test_a_solver_that_is_not_installed_is_left_out_and_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The others are measured all the same, and the figures and the terminal say what is missing."""
    monkeypatch.setitem(sys.modules, "quadprog", None)
    monkeypatch.delitem(sys.modules, "tests.bench.solvers.quadprog", raising=False)
    figures = measure(SETTING, Size(40, 2, 1), ("quadprog", "piqp_sparse"))
    assert figures.skipped == {"quadprog": "quadprog is not installed"}
    found = document(figures)
    assert not any("quadprog" in row["name"] for row in found["calls"])
    assert [row["rejected"] for row in found["calls"]] == [0] * 8
    terminal = StringIO()
    show(Console(width=80, file=terminal), figures)
    text = terminal.getvalue()
    assert "Left out: quadprog, since quadprog is not installed." in text
    assert "ours with piqp sparse" in text


def test_a_conversion_that_is_not_there_is_no_missing_solver() -> None:
    """A name for which there is no conversion is a mistake of ours, not something to leave out silently."""
    with pytest.raises(ModuleNotFoundError):
        contenders(LATTICE, WEIGHTS, ["no_such_solver"])


def test_figures_have_positive_ratios_and_goals() -> None:
    """Ratios are to our median in turns; goals are about our median call alone, and about the slowest flight."""

    def calls(*ms: float) -> Calls:
        return Calls([x / 1e3 for x in ms], [Idle().plan(task) for task in some])

    some = record(SETTING, parse("none", 7, 2, 0), 2)[:3]
    tenth = np.full(3, 1e-4)
    ours = Parts(tenth, np.array([5e-4, 2e-3, 7e-4]), tenth, np.array([1.0, 3.0, 2.0]))
    flights = (Timed("none", 100, 0.2, (3.0, 0.5, 1.0)), Timed("iid:0.1", 100, 0.2, (1.25,)))
    figures = Figures(7, 3, 1, {OURS: calls(0.5, 0.9, 4.0), "other": calls(3.0, 1.8, 1.0)}, {}, ours, flights)
    found = document(figures)
    assert [row["ratio"] for row in found["calls"]] == pytest.approx([1.0, 2.0])
    assert found["calls"][0]["median_ms"] == pytest.approx(0.9)
    assert found["parts"]["all"]["median_ms"] == pytest.approx(0.9)
    assert found["solves_per_call"] == 2
    assert [flight["times_real_time"] for flight in found["flights"]] == pytest.approx([20.0, 16.0])
    assert found["goals"] == {"median_ms": True, "times_real_time": False}


def test_the_command_writes_its_figures(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """`--quick --json FILE` measures and writes; the exit code is 0 whatever the times are."""
    monkeypatch.setattr(benchmark, "circle", lambda: SETTING)
    monkeypatch.setattr(benchmark, "QUICK", 50)
    monkeypatch.setattr(benchmark, "SOLVERS", ())
    monkeypatch.setattr(benchmark, "MOST_MS", 0.0)
    path = tmp_path / "figures.json"
    assert main(["--quick", "--json", str(path)]) == 0
    found = json.loads(path.read_text(encoding="utf-8"))
    assert found["schema"] == SCHEMA
    assert all(row["ratio"] > 0 and row["p95_ms"] >= row["median_ms"] for row in found["calls"])
    assert [flight["loss"] for flight in found["flights"]] == ["none", "iid:0.1"]
    assert found["goals"]["median_ms"] is False


def test_a_file_that_cannot_be_written_is_refused_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Bad input ends with one sentence and exit code 2 before anything is measured."""
    assert main(["--json", str(tmp_path / "no" / "such.json")]) == 2
    assert "cannot write" in capsys.readouterr().err


def test_situations_are_those_of_the_planner(tasks: list[Task]) -> None:
    """Where the exact test accepts, no row here is broken; where a UAV would leave its side of a plane, one is."""
    for task in tasks[:10]:
        situation = Situation(AXIS, task)
        old = task.own.shifted(task.start).jerks * AXIS.jerk_unit
        assert situation.slacks(old).min() > -1e-9
        towards = old.copy()
        towards[0] = 1000 * np.sign(situation.normals[0, 0])
        assert situation.slacks(towards).min() < 0
