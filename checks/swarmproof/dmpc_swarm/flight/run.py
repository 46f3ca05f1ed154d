"""Flies one scenario under the judge's eyes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from swarmproof.campaign.deferred import deferred
from swarmproof.dmpc_swarm.flight.fly import Flight, Plans
from swarmproof.dmpc_swarm.flight.judge import Flown, Judge
from swarmproof.dmpc_swarm.flight.place import place
from swarmproof.dmpc_swarm.flight.state import Round
from swarmproof.dmpc_swarm.flight.tracking import TrackingError
from swarmproof.dmpc_swarm.planner.planner import Planner
from swarmproof.dmpc_swarm.semantics import SWITCHES, Semantics
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.errors import BadInput
from swarmproof.faults.losses import LossModel
from swarmproof.scenario.scenario import Scenario, load

MOST_CUS = 16


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

    @classmethod
    def parse(
        cls,
        scenario: str,
        cus: int,
        trigger: str,
        preset: str,
        changes: Iterable[str],
        seed: int,
        rounds: int | None = None,
    ) -> Setting:
        """Return the setting that the options of `swarmproof fly` describe.

        Args:
            scenario: a TOML file, or the name of one that ships.
            cus: M.
            trigger: RR, DT or HT.
            preset: of the semantics.
            changes: ``NAME=VALUE`` for a switch of the semantics, or for anything in the scenario that can be changed.
            seed: of the scenario, too.
            rounds: the length of the flight, if it is not the scenario's.

        Raises:
            BadInput: one of them cannot be.
        """
        if not 1 <= cus <= MOST_CUS:
            raise BadInput(f"--cus {cus} cannot be flown: choose 1 to {MOST_CUS}")
        if trigger not in list(Trigger):
            raise BadInput(f"there is no trigger {trigger!r}: choose {', '.join(Trigger)}")
        switches, of_scenario = _split(changes)
        semantics = Semantics.parse(preset, ["initial=known", *switches, "event_trigger=round-robin"])
        what = load(scenario, seed, of_scenario)
        what = what if rounds is None else replace(what, rounds=rounds)
        return cls(what, cus, Trigger(trigger), semantics, seed)

    def flight(self, plans: Plans | None = None) -> Flight:
        """Return the flight, with its own planner if none is given."""
        where = place(self.scenario)
        planner = Planner(where.lattice, self.scenario.weights) if plans is None else plans
        return Flight(where, self.cus, self.trigger, self.semantics, planner, self.seed)


def fly(
    setting: Setting,
    losses: LossModel,
    rounds: int,
    watch: Callable[[Round], None] | None = None,
    flight: Flight | None = None,
) -> tuple[Flown, float]:
    """Fly `rounds` rounds and return what became of the claims, and the wall time of the loop with all checks, in s.

    Interrupted, it returns what was flown so far, in whole rounds, if that is at least one.

    Args:
        setting: the flight.
        losses: what is lost in each round.
        rounds: how many rounds, at least one.
        watch: called with each round.
        flight: `setting.flight()`, if it exists already: its planner may remember.
    """
    flight = setting.flight() if flight is None else flight
    state = flight.initial()
    judge = Judge(flight, state, tracking_of(setting, flight))
    begin = time.perf_counter()
    seen = 0
    stopped = None
    try:
        for flown in flight.rounds(state, losses, rounds):
            with deferred():  # a round is judged as a whole, or not at all
                judge.see(flown)
                seen += 1
                if watch is not None:
                    watch(flown)
    except KeyboardInterrupt:
        if not seen:
            raise
        stopped = f"interrupted after {seen} of {rounds} rounds"
    result = replace(judge.finish(), stopped=stopped)
    return result, time.perf_counter() - begin


def tracking_of(setting: Setting, flight: Flight) -> TrackingError | None:
    """Return how the UAVs stray from their references, the same each time; None if they follow them exactly."""
    fleet = setting.scenario.fleet
    bounds = [fleet.of_uav(i).tracking_error for i in range(setting.scenario.uavs)]
    return TrackingError(flight.lattice, bounds, setting.seed) if any(bounds) else None


def _split(texts: Iterable[str]) -> tuple[list[str], list[str]]:
    """Return the changes of switches and those of the scenario."""
    switches: list[str] = []
    changes: list[str] = []
    for text in texts:
        name = text.partition("=")[0]
        if name == "event_trigger":
            raise BadInput(
                "--set event_trigger does not go with flights, in which --trigger says whom the CUs plan, such as "
                "--trigger RR"
            )
        (switches if name in SWITCHES else changes).append(text)
    return switches, changes
