"""Records what the CUs plan in a flight, so that the same tasks can be planned again."""

from __future__ import annotations

import numpy as np

from swarmproof.assess.run import Setting
from swarmproof.channel.losses import LossModel
from swarmproof.flight.state import Round
from swarmproof.motion.lattice import Lattice
from swarmproof.planning.outlook import ARRIVED
from swarmproof.planning.planner import Planned, Planner
from swarmproof.planning.problem import Task


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
    scenario = setting.scenario
    recorder = Recorder(Planner(Lattice.of(scenario.parameters, scenario.horizon), scenario.weights))
    flight = setting.flight(recorder)
    for flown in flight.rounds(flight.initial(), losses, rounds):
        if _arrived(setting, flown, flight.lattice):
            break
    return recorder.tasks


def _arrived(setting: Setting, flown: Round, lattice: Lattice) -> bool:
    after = flown.after
    here = np.array([after.followed(i).state_at(after.k)[0] for i in range(setting.scenario.uavs)])
    away = here * float(lattice.position_unit) - np.array(setting.scenario.targets_at(flown.before.k))
    return bool((np.sqrt((away**2).sum(axis=1)) <= ARRIVED).all())
