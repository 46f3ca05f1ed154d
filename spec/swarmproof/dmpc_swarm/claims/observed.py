"""What can be seen of a swarm in a computation phase: the only thing that claims may look at.

The executable model is observed this way (`swarmproof.dmpc_swarm.observe`), and any other implementation can be: it has
to show its trackers with their flags, its CUs' states, the trajectories that its UAVs follow, and what is about to be
sent.
Trajectories are any hashable values that are equal when the trajectories are the same.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

RUN_DMPC = "RUN_DMPC"
WAIT = "WAIT"


@dataclass(frozen=True, slots=True)
class ObservedTracker:
    """D_iw(k): its entries and its flag."""

    entries: frozenset[Hashable]
    deprecated: bool


@dataclass(frozen=True, slots=True)
class ObservedCu:
    """CU w in the computation phase of round k, after Algorithm 2 and Alg. 1 lines 8-11.

    Attributes:
        state: the name of its state in Algorithm 1.
        trackers: D_iw(k) for i = 0 ... N-1.
        may_plan: the UAVs for which its message of this round may carry a new trajectory (of an implementation that
            decides at once: the UAV of the TrajectoryMessage that it sends).
        selection: A_ET(k), where the event trigger computes one.
        transmits: whether it sends a message in its slot of this round.
    """

    state: str
    trackers: tuple[ObservedTracker, ...]
    may_plan: frozenset[int]
    selection: frozenset[int] | None
    transmits: bool


@dataclass(frozen=True, slots=True)
class ObservedUav:
    """Everything about one UAV: what it follows, and by CU: its state, its tracker of it, whether it may plan it."""

    followed: Hashable
    at_cus: tuple[tuple[str, ObservedTracker, bool], ...]


@dataclass(frozen=True, slots=True)
class ObservedSwarm:
    """The swarm in the computation phase of round k.

    Attributes:
        followed: the trajectory that each UAV follows in round k.
        answering: for each CU's slot, the UAV that sends a reply in it in round k, if any.
    """

    round: int
    followed: tuple[Hashable, ...]
    answering: tuple[int | None, ...]
    cus: tuple[ObservedCu, ...]

    def of_uav(self, i: int) -> ObservedUav:
        """Return what concerns UAV i."""
        return ObservedUav(self.followed[i], tuple((cu.state, cu.trackers[i], i in cu.may_plan) for cu in self.cus))
