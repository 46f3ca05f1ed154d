"""Plans one UAV: solves (13), rounds the answer to the lattice, and lets it out only if every constraint holds exactly.

Each accepted trajectory satisfies (13) without any tolerance, and shifting it by a round is exact. So the candidate of
Theorem 1's proof satisfies the next problem exactly, however many rounds pass: nothing erodes. What the solver's
tolerance and the lattice cost is a little room: rows are tightened (`problem.Model`), so that an answer that is off by
less is still accepted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarmproof.dmpc_swarm.planner.accept import broken_constraint, old_satisfies
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.problem import Model, Task
from swarmproof.dmpc_swarm.planner.qp import LazyProgram
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.qp.solvers import Solver, Status, solve_with_piqp
from swarmproof.scenario.scenario import Point, Weights


@dataclass(frozen=True)
class Planned:
    """What came out of one task.

    Attributes:
        plan: the new trajectory; None where the CU keeps the old one.
        status: the solver's last word.
        why: in words, why there is no plan; empty if there is one.
        feasible: whether Theorem 1's candidate, the old trajectory shifted, satisfies (13) exactly.
    """

    plan: Plan | None
    status: Status
    why: str
    feasible: bool


class Planner:
    """Solves tasks of one swarm. The same task gives the same plan, whatever was planned before."""

    def __init__(self, lattice: Lattice, weights: Weights, solver: Solver = solve_with_piqp) -> None:
        self.lattice = lattice
        self.models = [Model(kind, weights) for kind in lattice.kinds]
        self.solver = solver

    def model_of(self, i: int) -> Model:
        """Return the model of UAV i."""
        fleet = self.lattice.fleet
        return self.models[0 if fleet is None else fleet.place(i)]

    def plan(self, task: Task) -> Planned:
        """Return a trajectory for the task's UAV that satisfies (13) exactly, or why there is none."""
        feasible = old_satisfies(task.own, task.start, task.planes)
        program = LazyProgram(self.model_of(task.i), task)
        attempts = [program.spare]
        if feasible:
            attempts.append(program.kept)
        why, status = "", Status.GAVE_UP
        for demands in attempts:
            status, jerks = program.solve(self.solver, demands)
            if status is Status.INFEASIBLE:
                why = "the solver says: infeasible"
                continue
            plan = self.rounded(task, jerks)
            broken = broken_constraint(plan, task.own, task.planes)
            if broken is None:
                return Planned(plan, status, "", feasible)
            gave_up = " that it gave up on" if status is Status.GAVE_UP else ""
            why = f"the solver's answer{gave_up} breaks {broken}"
        return Planned(None, status, why, feasible)

    def rounded(self, task: Task, jerks: Floats) -> Plan:
        """Return the trajectory on the lattice near `jerks` (m/s³, shape (3H,), axis by axis) that ends at rest.

        Rest is restored by the last two jerks. Those before determine by how much: in units of a period, Σu and
        Σ(H−1−κ)u_κ must take given values, which the last two do with weights (1, 1) and (1, 0). The values are
        integers, since v/m² + a/m is even on every trajectory that starts in a hover.
        """
        lattice = self.model_of(task.i).lattice
        m, horizon = lattice.steps, lattice.horizon
        state = task.own.state_at(task.start)
        rounded = np.rint(jerks.reshape(3, -1).T / float(lattice.jerk_unit))
        rounded[-2:] = 0
        weights = np.arange(horizon - 1, -1, -1, dtype=float)
        velocity, acceleration = state[1] / m**2, state[2] / m
        total = -acceleration - rounded.sum(axis=0)
        weighted = -(velocity + (2 * horizon - 1) * acceleration) / 2 - weights @ rounded
        rounded[-2] = weighted
        rounded[-1] = total - weighted
        return Plan(lattice, task.start, state, rounded)


def hovering(lattice: Lattice, starts: Sequence[Point]) -> list[Plan]:
    """Return the hovering trajectories from `starts` (m), rounded to the lattice within the space (Remark 2)."""
    return [Plan.hovering(lattice.of_uav(i), position) for i, position in enumerate(lattice.hovers(starts))]
