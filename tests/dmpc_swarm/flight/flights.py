"""What the tests of flights share: recorded flights, altered planners, and tracked trajectories by the oracle."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from tests.dmpc_swarm.flight.settings import setting

from swarmproof.dmpc_swarm.flight.exhaustive import Decided
from swarmproof.dmpc_swarm.flight.fly import Flight, Plans
from swarmproof.dmpc_swarm.flight.judge import Flown, Judge, Judged
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.flight.state import Round
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.faults.grammar import parse
from swarmproof.faults.losses import Losses, LossModel, Recorded
from swarmproof.scenario.definition import Scenario, TargetChange
from swarmproof.scenario.points import Point
from swarmproof.scenario.scenario import load

#: What changes a round before anybody looks at it.
Tamper = Callable[[Round], Round]
#: What a CU makes of a task, given the planner.
Bug = Callable[[Plans, Task], Planned]


@dataclass(frozen=True)
class Recording:
    """A flight, its rounds, and what the judge says."""

    flight: Flight
    rounds: tuple[Round, ...]
    flown: Flown


@dataclass(frozen=True)
class Buggy:
    """Plans as `bug` does."""

    plans: Plans
    bug: Bug

    def plan(self, task: Task) -> Planned:
        """Return what the bug makes of the task."""
        return self.bug(self.plans, task)


def record(
    what: Setting,
    loss: str | LossModel = "none",
    rounds: int = 30,
    plans: Plans | None = None,
    tamper: Tamper | None = None,
) -> Recording:
    """Fly `rounds` rounds under the judge's eyes and keep them all."""
    flight = what.flight(plans)
    losses = parse(loss, what.scenario.uavs, what.cus, what.seed) if isinstance(loss, str) else loss
    state = flight.initial()
    judge = Judge(flight, state)
    kept = []
    for _ in range(rounds):
        (round_,) = flight.rounds(state, losses, 1)
        if tamper is not None:
            round_ = tamper(round_)
        judge.see(round_)
        kept.append(round_)
        state = round_.after
    return Recording(flight, tuple(kept), judge.finish())


@cache
def recorded(
    scenario: str, cus: int, loss: str, rounds: int, seed: int = 0, semantics: str = "guarded", uavs: int | None = None
) -> Recording:
    """Return a flight of a shipped scenario, flown once for all tests."""
    changes = [] if uavs is None else [f"uavs={uavs}"]
    return record(setting(scenario, cus, seed, changes, semantics=semantics), loss, rounds)


def planner_of(what: Setting) -> Planner:
    """Return a planner such as the flight's own."""
    return Planner(what.flight().lattice, what.scenario.weights)


def violated(claims: Iterable[Judged | Decided]) -> set[str]:
    """Return the ids of the violated claims."""
    return {judged.claim.id for judged in claims if judged.verdict == "violated"}


def undecided(claims: Iterable[Judged | Decided]) -> set[str]:
    """Return the ids of the undecided claims."""
    return {judged.claim.id for judged in claims if judged.verdict == "undecided"}


def scenario(starts: Sequence[Point], targets: Mapping[int, Sequence[Point]], *changes: str) -> Scenario:
    """Return a scenario with these starts, targets by round, and changes of parameters; all else is the crossing's."""
    moves = tuple(TargetChange(k, tuple(points)) for k, points in sorted(targets.items()))
    return replace(load("crossing", 0, changes), name="by hand", starts=tuple(starts), targets=moves)


# Losses by hand


def losses(
    uavs: int, cus: int, *, at_cus: Sequence[tuple[int, str, int]] = (), at_uavs: Sequence[tuple[int, int]] = ()
) -> Losses:
    """Return the losses of one round: (CU, "uav" or "slot", which) and (UAV, slot)."""
    cu_uav, cu_slot = np.zeros((cus, uavs), bool), np.zeros((cus, cus), bool)
    uav_slot = np.zeros((uavs, cus), bool)
    for w, kind, which in at_cus:
        (cu_uav if kind == "uav" else cu_slot)[w, which] = True
    for i, slot in at_uavs:
        uav_slot[i, slot] = True
    return Losses(cu_uav, cu_slot, uav_slot, np.zeros((cus, cus), bool), np.zeros((uavs, cus), bool))


def losses_in(rounds: Iterable[Round]) -> Recorded:
    """Return the losses with which these rounds, from round 0 on, were flown."""
    found = []
    uavs = cus = 0
    for round_ in rounds:
        cus, uavs = len(round_.at_cus), len(round_.at_uavs)
        arrays = [np.zeros(shape, bool) for shape in ((cus, uavs), (cus, cus), (uavs, cus), (cus, cus), (uavs, cus))]
        for w, got in enumerate(round_.at_cus):
            arrays[0][w, list(got.lost_uavs)] = True
            arrays[1][w, list(got.lost_slots)] = True
            arrays[3][w, list(got.decoded_replies)] = True
        for i, got in enumerate(round_.at_uavs):
            arrays[2][i, list(got.lost_slots)] = True
            arrays[4][i, list(got.decoded_replies)] = True
        found.append(Losses(*arrays))
    return Recorded(found, uavs, cus)
