"""Non-vacuity: situations that an exploration must have seen before its "holds" means anything.

A claim about trackers that hold two entries says nothing if no tracker ever holds two. Each witness is looked for in
every exploration; where it cannot exist, the report says that none was found.
"""

from __future__ import annotations

from swarmproof.claims.claim import Return, Witness
from swarmproof.dmpc_swarm.claims.observed import RUN_DMPC, WAIT, ObservedSwarm


def _two_entries(swarm: ObservedSwarm) -> bool:
    return any(len(t.entries) > 1 and not t.deprecated for cu in swarm.cus for t in cu.trackers)


def _request_answered(swarm: ObservedSwarm) -> bool:
    return any(uav is not None for uav in swarm.answering)


def _recovery_entered(swarm: ObservedSwarm) -> bool:
    return any(cu.state == WAIT for cu in swarm.cus)


def _slot_conflict(swarm: ObservedSwarm) -> bool:
    return any(cu.transmits and answering is not None for cu, answering in zip(swarm.cus, swarm.answering, strict=True))


def _waiting(swarm: ObservedSwarm) -> frozenset[int]:
    return frozenset(w for w, cu in enumerate(swarm.cus) if cu.state == WAIT)


def _running(swarm: ObservedSwarm) -> frozenset[int]:
    return frozenset(w for w, cu in enumerate(swarm.cus) if cu.state == RUN_DMPC)


#: Found by its path, not by a state: a CU in RUN_DMPC that was in WAIT before.
RECOVERY_LEFT = Return(
    "recovery-left", "a CU that had left RUN_DMPC came back to it", "recovery-entered", _waiting, _running
)

WITNESSES: tuple[Witness[ObservedSwarm], ...] = (
    Witness(
        "two-entries",
        "a tracker that is not deprecated held two entries",
        _two_entries,
        outline=False,
    ),
    Witness("request-answered", "a UAV answered a request", _request_answered),
    Witness("recovery-entered", "a CU left RUN_DMPC for WAIT", _recovery_entered),
    Witness("slot-conflict", "a CU and a UAV transmitted in one slot", _slot_conflict),
)
