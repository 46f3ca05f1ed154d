"""What the tests of planning share: lattices, trajectories as model and oracle have them, tasks recorded in flights."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache

import numpy as np
from tests.dmpc_swarm.planner.oracle import Flown, Limits, State, broken_constraints, rested, vector

from swarmproof.dmpc_swarm.flight.fly import Plans
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.qp.solvers import Answer, QuadraticProgram, Solver, Status, solve_with_piqp
from swarmproof.scenario.scenario import Scenario, Weights, load
from swarmproof.theorem3.parameters import Parameters
from swarmproof.theorem3.values import closed

SPACE = "workspace=-1.7,1.7,-1.7,1.7,0.4,3"
HORIZON = 15


def samples(m: int) -> str:
    """Return the change of T_c that makes m samples of a period."""
    return f"T_c=1/{5 * m}"


@cache
def lattice(*changes: str, horizon: int = HORIZON) -> Lattice:
    """Return the lattice of the published parameters in the space of the shipped scenarios, with changes."""
    return Lattice.of(Parameters().with_changes([SPACE, *changes]), horizon)


@cache
def limits(units: Lattice) -> Limits:
    """Return the parameters of (13) as the oracle takes them."""
    given = units.parameters
    assert given.workspace is not None
    return Limits(
        T=given.T_s,
        T_c=given.T_c,
        H=units.horizon,
        d_hat_min=given.d_hat_min,
        theta_inverse=given.theta_inverse,
        v_max=given.v_max,
        a_max=given.a_max,
        j_max=given.j_max,
        box=closed(given.workspace),
    )


def flown(plan: Plan) -> Flown:
    """Return a plan of whole numbers as the oracle's trajectory, in SI units: nothing is rounded."""
    units, period = plan.lattice, plan.lattice.parameters.T_s
    si = (units.position_unit, units.velocity_unit, units.acceleration_unit)
    x, y, z = (vector(*(int(n) * unit for n, unit in zip(axis, si, strict=True))) for axis in plan.state.T)
    state: State = (x, y, z)
    jerks = [vector(*(int(n) * units.jerk_unit for n in row)) for row in plan.jerks]
    return Flown(plan.start * period, state, jerks, period)


def on_lattice(units: Lattice, values: Iterable[Fraction], unit: Fraction) -> Floats:
    """Return `values` (SI) in lattice units; they must be whole numbers of them."""
    counts = [value / unit for value in values]
    assert all(count.denominator == 1 for count in counts), "not on the lattice"
    return np.array([int(count) for count in counts], float)


def resting(plan: Plan) -> Plan:
    """Return the plan with its last two jerks changed such that it ends at rest, which must be on the lattice."""
    last = rested(flown(plan)).jerks[-2:]
    unit = plan.lattice.jerk_unit
    end = [on_lattice(plan.lattice, jerk, unit) for jerk in last]
    return Plan(plan.lattice, plan.start, plan.state, np.concatenate([plan.jerks[:-2], end]))


def hover(units: Lattice, point: Sequence[float], moved: Sequence[int] = (0, 0, 0)) -> Plan:
    """Return a hover at the lattice point nearest to `point` (m), `moved` by so many units."""
    (position,) = units.positions([point])
    return Plan.hovering(units, position + np.array(moved, float))


def wander(random: np.random.Generator, old: Plan, start: int, size: float = 0.9) -> Plan:
    """Return a plan that continues `old`, moves about at random and ends at rest.

    Its jerks are those of `old` and others that start and end at rest; the largest of these is `size` times j_max.
    """
    units = old.lattice
    # accelerations and velocities at the end are these sums of the jerks, the latter up to a factor and a part of the
    # former
    ends = np.stack([np.ones(units.horizon), np.arange(units.horizon, dtype=float)])
    # slow and fast ones, not only noise, which would not come far
    wishes = (
        random.normal(size=(units.horizon, 3)).cumsum(axis=0)
        if random.random() < 0.7
        else random.normal(size=(units.horizon, 3))
    )
    move = wishes - np.linalg.lstsq(ends, ends @ wishes, rcond=None)[0]
    move *= size * units.j_max / np.maximum(np.abs(move).max(axis=0), 1e-9)
    return resting(Plan(units, start, old.state_at(start), old.shifted(start).jerks + np.rint(move)))


def broken(plan: Plan, task: Task) -> list[str]:
    """Return which constraints of (13) the oracle says that `plan`, of whole numbers, breaks."""
    neighbours = {j: [flown(held) for held in plans] for j, plans in task.others.items()}
    return broken_constraints(flown(plan), flown(task.own), neighbours, task.selected, limits(plan.lattice), task.k)


def a_task(
    own: Plan,
    others: Mapping[int, Sequence[Plan]],
    target: Sequence[float] = (0.0, 0.0, 1.0),
    selected: Iterable[int] = (),
    k: int = 0,
) -> Task:
    """Return the task of planning UAV 0."""
    held = {j: tuple(plans) for j, plans in others.items()}
    return Task(k, 0, own, held, frozenset(selected), np.array(target, float))


def random_task(random: np.random.Generator, units: Lattice) -> Task:
    """Return the task of planning a UAV that moves, sometimes near a wall or too fast, among others that move.

    One or two other UAVs have one or two trajectories each, often about as near as they may come.
    """

    def near(distance: float) -> Plan:
        way = random.normal(size=3)
        way *= np.array([1, 1, 4]) * distance / np.linalg.norm(way)
        return wander(random, hover(units, (place + way).tolist()), 0, 0.3)

    place = random.uniform((-1.6, -1.6, 0.5), (1.6, 1.6, 2.9))
    if random.random() < 0.3:
        place[0] = 1.7 - random.exponential(0.01)
    own = wander(random, hover(units, place.tolist()), 0, 0.4)
    others = {
        j: [near(random.choice([0.27, 0.35, 3.0])) for _ in range(random.integers(1, 3))]
        for j in range(1, random.integers(2, 4))
    }
    target = random.uniform((-1.6, -1.6, 0.5), (1.6, 1.6, 2.9)).tolist()
    return a_task(own, others, target, selected={j for j in range(3) if random.random() < 0.5}, k=2)


def beside(plan: Plan, offset: Floats) -> Plan:
    """Return the same trajectory some lattice units aside."""
    return Plan(plan.lattice, plan.start, plan.state + np.outer((1, 0, 0), offset), plan.jerks)


def setting(
    scenario: str | Scenario,
    cus: int = 2,
    seed: int = 0,
    changes: Iterable[str] = (),
    trigger: Trigger = Trigger.HT,
    semantics: str = "guarded",
) -> Setting:
    """Return a flight of a shipped scenario with changes, or of another one."""
    what = load(scenario, seed, changes) if isinstance(scenario, str) else scenario
    rules = Semantics.parse(semantics, ["initial=known", "event_trigger=round-robin"])
    return Setting(what, cus, trigger, rules, seed)


@dataclass
class Recorder:
    """Plans as `plans` does, and keeps every task with what came out of it."""

    plans: Plans
    kept: list[tuple[Task, Planned]] = field(default_factory=list)

    def plan(self, task: Task) -> Planned:
        """Return what `plans` makes of the task."""
        planned = self.plans.plan(task)
        self.kept.append((task, planned))
        return planned


def planner(units: Lattice, weights: Weights | None = None) -> Planner:
    """Return the planner with the published weights, or others."""
    return Planner(units, Weights() if weights is None else weights)


@cache
def recorded(
    scenario: str, cus: int, loss: str, rounds: int, seed: int = 0, changes: tuple[str, ...] = ()
) -> tuple[tuple[Task, Planned], ...]:
    """Return all tasks of one flight, in order, with what came out."""
    what = setting(scenario, cus, seed, changes)
    units = what.flight().lattice
    recorder = Recorder(Planner(units, what.scenario.weights))
    flight = what.flight(recorder)
    losses = parse(loss, what.scenario.uavs, cus, seed)
    for _ in flight.rounds(flight.initial(), losses, rounds):
        pass
    return tuple(recorder.kept)


def _wrong(change: Callable[[Floats], Floats]) -> Solver:
    def solve(program: QuadraticProgram) -> Answer:
        return Answer(Status.SOLVED, change(solve_with_piqp(program).x))

    return solve


def _says(status: Status, value: float) -> Solver:
    return lambda program: Answer(status, np.full(len(program.c), value))


def _random() -> Solver:
    random = np.random.default_rng(0)
    return _wrong(lambda x: random.normal(0, 3, len(x)))


def _off(by: float) -> Solver:
    random = np.random.default_rng(1)
    return _wrong(lambda x: x + random.normal(0, by, len(x)))


def _late() -> Solver:
    last: list[Floats] = []

    def solve(program: QuadraticProgram) -> Answer:
        last.append(solve_with_piqp(program).x)
        return Answer(Status.SOLVED, np.resize(last[max(len(last) - 2, 0)], len(program.c)))

    return solve


def blind(program: QuadraticProgram) -> Answer:
    """Solve without planes and bounds of states: a smooth motion straight to the target that ends at rest."""
    return solve_with_piqp(program._replace(G=program.G[:0], h=program.h[:0]))._replace(status=Status.SOLVED)


#: By name, solvers that return garbage; each call makes a new one, as some have a memory.
GARBAGE: Mapping[str, Callable[[], Solver]] = {
    "random numbers": _random,
    "off by 1e-3": lambda: _off(1e-3),
    "off by 1e-6": lambda: _off(1e-6),
    "too large": lambda: _wrong(lambda x: 1.5 * x),
    "half": lambda: _wrong(lambda x: 0.5 * x),
    "mirrored": lambda: _wrong(lambda x: -x),
    "the answer before": _late,
    "blind": lambda: blind,
    "solved, whatever it is": lambda: _wrong(lambda x: x),
    "zeros": lambda: _says(Status.SOLVED, 0.0),
    "NaN": lambda: _says(Status.SOLVED, np.nan),
    "infinite": lambda: _says(Status.SOLVED, np.inf),
    "huge": lambda: _says(Status.SOLVED, 1e300),
    "gives up": lambda: _says(Status.GAVE_UP, np.nan),
    "gives up with numbers": lambda: _says(Status.GAVE_UP, 4.0),
    "infeasible": lambda: _says(Status.INFEASIBLE, 0.0),
}
