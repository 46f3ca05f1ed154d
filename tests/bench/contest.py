"""Plans the same tasks in several ways, in turns, and measures each call: build, solve and accept."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module

import numpy as np
from tests.bench.forms import Jerks, NullSpace, Posed, States

from swarmproof.dmpc_swarm.flight.fly import Plans
from swarmproof.dmpc_swarm.planner.accept import broken_constraint
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.qp.solvers import Answer, QuadraticProgram, solve_with_piqp
from swarmproof.scenario.scenario import Weights

#: What all others are compared with.
OURS = "ours: piqp dense"
#: Solvers that get the same programs, by the names of their modules in `bench.solvers`.
SOLVERS = ("piqp_sparse", "clarabel", "quadprog", "osqp")
_FORMS = (("dense, jerks", Jerks), ("dense, null space", NullSpace), ("sparse, states", States))


@dataclass
class Calls:
    """What came of the calls of one contender, one entry a task.

    Attributes:
        seconds: wall time of each call.
        planned: what it returned.
    """

    seconds: list[float] = field(default_factory=list)
    planned: list[Planned] = field(default_factory=list)

    @property
    def accepted(self) -> int:
        """In how many calls there was a plan."""
        return sum(planned.plan is not None for planned in self.planned)


@dataclass(frozen=True)
class Parts:
    """Where the time of our calls goes when they have the machine to themselves, in s; shape (tasks,) each.

    Attributes:
        build: setting up programs, rounding and everything else.
        solver: all that the solver was asked.
        accept: deciding exactly whether the old trajectory, shifted, and the new one satisfy (13).
        solves: how often the solver was asked.
    """

    build: Floats
    solver: Floats
    accept: Floats
    solves: Floats

    @property
    def whole(self) -> Floats:
        """All of each call, shape (tasks,)."""
        return self.build + self.solver + self.accept


def contenders(lattice: Lattice, weights: Weights, names: Sequence[str]) -> tuple[dict[str, Plans], dict[str, str]]:
    """Return all ways to plan, and of those solvers of `names` that cannot take part, why."""
    ways: dict[str, Plans] = {OURS: Planner(lattice, weights)}
    skipped = {}
    for name in names:
        try:
            module = import_module(f"tests.bench.solvers.{name}")
        except ModuleNotFoundError as missing:
            if str(missing.name).startswith("tests"):
                raise
            skipped[name] = f"{missing.name} is not installed"
            continue
        ways[f"ours with {name.replace('_', ' ')}"] = Planner(lattice, weights, module.solve)
    for rows, lazy in (("few rows", True), ("all rows", False)):
        for name, form in _FORMS:
            ways[f"piqp {name}, {rows}"] = Posed.of(lattice, weights, form, lazy)
    return ways, skipped


def race(ways: Mapping[str, Plans], tasks: Sequence[Task]) -> dict[str, Calls]:
    """Plan every task in every way: all ways take turns at each task, and so does who begins.

    What disturbs the machine disturbs all; and all find it as the others left it, which costs each of them some time.
    """
    calls = {name: Calls() for name in ways}
    names = list(ways)
    for turn, task in enumerate(tasks):
        for name in names[turn % len(names) :] + names[: turn % len(names)]:
            # a new task has not computed its planes yet
            fresh = replace(task)
            begin = time.perf_counter()
            planned = ways[name].plan(fresh)
            calls[name].seconds.append(time.perf_counter() - begin)
            calls[name].planned.append(planned)
    return calls


def parts(lattice: Lattice, weights: Weights, tasks: Sequence[Task]) -> Parts:
    """Return where the time of our calls goes.

    What accepting takes is measured on copies after each call, and subtracted from what is not the solver's.
    """
    spent = _Timed()
    planner = Planner(lattice, weights, spent.solve)
    rows = []
    for task in tasks:
        spent.seconds, spent.calls = 0.0, 0
        fresh = replace(task)
        begin = time.perf_counter()
        planned = planner.plan(fresh)
        whole = time.perf_counter() - begin
        accept = _accepting(task, planned.plan)
        rows.append((max(whole - spent.seconds - accept, 0.0), spent.seconds, accept, spent.calls))
    return Parts(*np.array(rows, float).reshape(-1, 4).T)


@dataclass
class _Timed:
    """PIQP, as the planner uses it, with a clock."""

    seconds: float = 0.0
    calls: int = 0

    def solve(self, program: QuadraticProgram) -> Answer:
        begin = time.perf_counter()
        answer = solve_with_piqp(program)
        self.seconds += time.perf_counter() - begin
        self.calls += 1
        return answer


def _accepting(task: Task, plan: Plan | None) -> float:
    fresh = replace(task)
    planes = fresh.planes
    tried = [fresh.own.shifted(fresh.start)]
    if plan is not None:
        tried.append(Plan(plan.lattice, plan.start, plan.state, plan.jerks))
    begin = time.perf_counter()
    for one in tried:
        broken_constraint(one, fresh.own, planes)
    return time.perf_counter() - begin
