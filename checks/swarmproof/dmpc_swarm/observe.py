"""Shows the executable model of MLR-DMPC to the claims."""

from __future__ import annotations

from swarmproof.dmpc_swarm.claims.observed import ObservedCu, ObservedSwarm, ObservedTracker
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState, may_plan
from swarmproof.dmpc_swarm.protocol.swarm import Swarm


def observe(swarm: Swarm) -> ObservedSwarm:
    """Return what can be seen of `swarm`."""
    answering: list[int | None] = [None] * len(swarm.cus)
    for uav in swarm.uavs:
        for slot in uav.asked_by:
            answering[slot] = uav.i
    return ObservedSwarm(
        swarm.k,
        tuple(uav.followed for uav in swarm.uavs),
        tuple(answering),
        tuple(
            ObservedCu(
                cu.state.name,
                tuple(ObservedTracker(frozenset(t.trajectories), t.deprecated) for t in cu.trackers),
                frozenset(may_plan(cu, swarm.k, len(swarm.cus))),
                None if cu.a_et is None else frozenset(cu.a_et),
                cu.state != CuState.WAIT_FOR_UPDATE,
            )
            for cu in swarm.cus
        ),
    )
