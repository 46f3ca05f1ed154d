"""The heartbeat protocol as a system under test."""

from __future__ import annotations

from swarmproof.heartbeat.claims import CLAIMS, WITNESSES
from swarmproof.heartbeat.protocol import Heartbeat
from swarmproof.heartbeat.semantics import Semantics
from swarmproof.port.broadcast import LostMessages
from swarmproof.system import Size, System

SYSTEM = System(
    name="heartbeat",
    paper="Heartbeat: who may fly through the gap (an example of swarmproof)",
    sizes=(Size("uavs", "UAVs", "N", usual=3, most=4, longest=16, least=2),),
    reading=Semantics,
    claims=CLAIMS,
    witnesses=WITNESSES,
    model=Heartbeat,
    recorded=LostMessages,
    abstracted="Positions are left out: who leads is said to fly through the gap. Messages arrive in their round or "
    "never.",
    in_short="Every loss of (message, receiver) pairs is taken; nothing is merged.",
)
