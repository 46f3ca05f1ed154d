"""Records what the CUs plan in a flight, so that the same tasks can be planned again."""

from __future__ import annotations

from swarmproof.dmpc_swarm.flight.observing import distances_to_targets
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.planner.outlook import ARRIVED
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.faults.losses import LossModel


class Recorder:
    """Plans as `planner` does, and keeps the tasks.

    Attributes:
        tasks: so far, in the order in which they were planned.
    """

    def __init__(self, planner: Planner) -> None:
        self._planner = planner
        self.tasks: list[Task] = []

    def plan(self, task: Task) -> Planned:
        """Return what comes out of `task`."""
        self.tasks.append(task)
        return self._planner.plan(task)


def record(setting: Setting, losses: LossModel, rounds: int) -> list[Task]:
    """Return the tasks of a flight, up to the round after which all UAVs are at their targets, or of all `rounds`.

    What comes after the arrival is left out: to stay where one is takes a fraction of the time.
    """
    recorder = Recorder(Planner(setting.flight().lattice, setting.scenario.weights))
    flight = setting.flight(recorder)
    for flown in flight.rounds(flight.initial(), losses, rounds):
        if (distances_to_targets(flight.scenario, flight.lattice, flown) <= ARRIVED).all():
            break
    return recorder.tasks
