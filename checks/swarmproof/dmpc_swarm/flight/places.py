"""Where a claim is broken: round, UAVs, CUs and time, for machines to read; the same in words is the claim's."""

from __future__ import annotations

from typing import NamedTuple

from swarmproof.claims.closest import ClosestApproach
from swarmproof.dmpc_swarm.claims.flight import Approach
from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.motion.lattice import Lattice


class Place(NamedTuple):
    """Where a claim is broken: the round, the UAVs and CUs that it is about there, and the time in s if it has one."""

    round: int
    uavs: tuple[int, ...]
    cus: tuple[int, ...]
    time: float | None

    @classmethod
    def of(cls, lattice: Lattice, k: int, first: Broken, approach: Approach | ClosestApproach | None) -> Place:
        """Return the place of `first`, seen in round k; what comes close between samples is in the round of its time.

        (Trajectories in trackers are planned ahead: their approach is later than the round in which it is seen.)
        """
        if approach is None:
            return cls(k, () if first.uav is None else (first.uav,), first.cus, None)
        if isinstance(approach, ClosestApproach):
            k = round_of(lattice, approach)
        return cls(k, approach.uavs, first.cus, float(approach.time))


def round_of(lattice: Lattice, dip: ClosestApproach) -> int:
    """Return the round in which a closest approach is."""
    return int(dip.time / float(lattice.parameters.T_s))
