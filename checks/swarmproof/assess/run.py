"""Flies one scenario under the judge's eyes."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from swarmproof.assess.judge import Flown, Judge
from swarmproof.channel.losses import LossModel
from swarmproof.flight.fly import Flight, Plans
from swarmproof.flight.state import Round
from swarmproof.flight.tracking import TrackingError
from swarmproof.motion.lattice import Lattice
from swarmproof.planning.planner import Planner
from swarmproof.planning.trigger import Trigger
from swarmproof.scenario.scenario import Scenario
from swarmproof.semantics.switches import Semantics


@dataclass(frozen=True)
class Setting:
    """Everything that determines a flight but what is lost.

    Attributes:
        cus: M.
        seed: of everything that is random: detours, tracking errors (and, where it is read, the scenario).
    """

    scenario: Scenario
    cus: int
    trigger: Trigger
    semantics: Semantics
    seed: int

    def flight(self, plans: Plans | None = None) -> Flight:
        """Return the flight, with its own planner if none is given."""
        lattice = Lattice.of(self.scenario.parameters, self.scenario.horizon)
        planner = Planner(lattice, self.scenario.weights) if plans is None else plans
        return Flight(self.scenario, lattice, self.cus, self.trigger, self.semantics, planner, self.seed)


def fly(
    setting: Setting,
    losses: LossModel,
    rounds: int,
    watch: Callable[[Round], None] | None = None,
    flight: Flight | None = None,
) -> tuple[Flown, float]:
    """Fly `rounds` rounds and return what became of the claims, and the wall time of the loop with all checks, in s.

    Interrupted, it returns what was flown so far if that is at least one round.

    Args:
        setting: the flight.
        losses: what is lost in each round.
        rounds: how many rounds, at least one.
        watch: called with each round.
        flight: `setting.flight()`, if it exists already: its planner may remember.
    """
    flight = setting.flight() if flight is None else flight
    bound = setting.scenario.parameters.tracking_error
    uavs = setting.scenario.uavs
    tracking = TrackingError(flight.lattice, bound, uavs, setting.seed) if bound else None
    state = flight.initial()
    judge = Judge(flight, state, tracking)
    begin = time.perf_counter()
    seen = 0
    try:
        for flown in flight.rounds(state, losses, rounds):
            judge.see(flown)
            seen += 1
            if watch is not None:
                watch(flown)
    except KeyboardInterrupt:
        if not seen:
            raise
    result = judge.finish()
    return result, time.perf_counter() - begin
