"""A planner with a memory, for searches that meet the same task on many ways."""

from __future__ import annotations

from swarmproof.dmpc_swarm.flight.fly import Plans
from swarmproof.dmpc_swarm.flight.judge import Counts
from swarmproof.dmpc_swarm.planner.planner import Planned
from swarmproof.dmpc_swarm.planner.problem import Task


class Remembering:
    """Plans each task once: what a planner returns depends on the task only.

    Attributes:
        counts: what became of the different tasks.
        asked: how often a plan was asked for.
    """

    def __init__(self, planner: Plans) -> None:
        self._planner = planner
        self._known: dict[object, Planned] = {}
        self.counts = Counts()
        self.asked = 0

    def plan(self, task: Task) -> Planned:
        """Return what the planner returns for the task."""
        others = tuple((j, tuple(plan.digest for plan in held)) for j, held in task.others.items())
        key = (task.k, task.i, task.own.digest, others, task.selected, task.target.tobytes())
        self.asked += 1
        if key not in self._known:
            self._known[key] = self._planner.plan(task)
            self.counts.count(self._known[key])
        return self._known[key]
