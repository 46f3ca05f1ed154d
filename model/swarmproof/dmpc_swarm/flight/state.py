"""What there is of a flown swarm at the start of a round, and what happens in one: values only, no rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from swarmproof.dmpc_swarm.planner.detour import Detour
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.planner import Planned
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.dmpc_swarm.protocol.algorithm1 import Decision
from swarmproof.dmpc_swarm.protocol.messages import Metadata
from swarmproof.dmpc_swarm.protocol.network import Air, Reception
from swarmproof.dmpc_swarm.protocol.swarm import Swarm

#: A trajectory's name: its UAV and its metadata (Section 4.2.1), which the protocol passes around.
Name = tuple[int, Metadata]


class KnownTarget(NamedTuple):
    """Where a UAV wants to go (m), and from which round on a CU knows so; None if it never heard the UAV say it."""

    point: tuple[float, float, float] | None
    since: int


class Knowledge(NamedTuple):
    """What a CU knows beyond its information trackers: targets (from UAVs' messages) and detours (from CUs')."""

    targets: tuple[KnownTarget, ...]
    detours: tuple[Detour, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class FlightState:
    """The swarm in the computation phase of round k.

    Attributes:
        swarm: the protocol's state; its trajectories are names.
        plans: what the names stand for: all that some tracker holds or some UAV follows.
        knowledge: by CU.
    """

    swarm: Swarm
    plans: Mapping[Name, Plan]
    knowledge: tuple[Knowledge, ...]

    @property
    def k(self) -> int:
        """The round."""
        return self.swarm.k

    def followed(self, i: int) -> Plan:
        """Return the trajectory that UAV i follows in this round."""
        return self.plans[i, self.swarm.uavs[i].followed.metadata]


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """A CU tried to plan a UAV (Algorithm 1 line 18)."""

    task: Task
    planned: Planned


@dataclass(frozen=True, slots=True, eq=False)
class Computed:
    """The end of the computation phase of a round.

    Attributes:
        decided: by CU, whom it plans or asks, as the protocol sees it.
        attempts: by CU, what it tried to plan.
        announced: by CU, the detours that its message carries; None if it carries none.
        after: by CU, the CU after line 34.
        air: all that is transmitted.
    """

    decided: tuple[Decision, ...]
    attempts: tuple[Attempt | None, ...]
    announced: tuple[tuple[Detour, ...] | None, ...]
    after: Swarm
    air: Air


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """One round that was flown: state, computation, receptions at CUs and UAVs, and the state of the next round."""

    before: FlightState
    computed: Computed
    at_cus: tuple[Reception, ...]
    at_uavs: tuple[Reception, ...]
    after: FlightState
