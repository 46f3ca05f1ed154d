"""Non-vacuity: situations that an exploration must have seen before its "holds" means anything.

A claim about trackers that hold two entries says nothing if no tracker ever holds two. Each witness is looked for in
every exploration; where it cannot exist, the report says that none was found.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from swarmproof.dmpc_swarm.claims.observed import WAIT, ObservedSwarm


def _two_entries(swarm: ObservedSwarm) -> bool:
    return any(len(t.entries) > 1 and not t.deprecated for cu in swarm.cus for t in cu.trackers)


def _request_answered(swarm: ObservedSwarm) -> bool:
    return any(uav is not None for uav in swarm.answering)


def _recovery_entered(swarm: ObservedSwarm) -> bool:
    return any(cu.state == WAIT for cu in swarm.cus)


def _slot_conflict(swarm: ObservedSwarm) -> bool:
    return any(cu.transmits and answering is not None for cu, answering in zip(swarm.cus, swarm.answering, strict=True))


@dataclass(frozen=True)
class Witness:
    """A situation worth having seen; `looks_at_trackers` says whether it depends on anything but states and slots."""

    id: str
    wording: str
    seen_in: Callable[[ObservedSwarm], bool]
    looks_at_trackers: bool = False


#: Found by its path, not by a state: a CU in RUN_DMPC that was in WAIT before.
RECOVERY_LEFT = "recovery-left"

WITNESSES: tuple[Witness, ...] = (
    Witness(
        "two-entries",
        "a tracker that is not deprecated held two entries",
        _two_entries,
        looks_at_trackers=True,
    ),
    Witness("request-answered", "a UAV answered a request", _request_answered),
    Witness("recovery-entered", "a CU left RUN_DMPC for WAIT", _recovery_entered),
    Witness("slot-conflict", "a CU and a UAV transmitted in one slot", _slot_conflict),
)
