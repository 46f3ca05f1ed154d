"""A replayed run of MLR-DMPC, in the paper's terms: swarms, what is on the air, receptions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.protocol.network import Air
from swarmproof.dmpc_swarm.protocol.swarm import Events, Swarm
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.trace.replay import Replay


@dataclass(frozen=True)
class SwarmRun:
    """A run: `swarms[k]` is the swarm in the computation phase of round k, `events[k]` what happens then.

    Attributes:
        shows: the id of the claim or witness that it is about.
        loop_start: of a run that goes round for ever: the round in which its loop starts.
        airs: by round, everything that is transmitted.
        broken: by round, where the claim is false.
    """

    uavs: int
    cus: int
    semantics: Semantics
    shows: str
    loop_start: int | None
    swarms: tuple[Swarm, ...]
    airs: tuple[Air, ...]
    events: tuple[Events, ...]
    broken: tuple[Sequence[Broken], ...]
    lost_messages: int
    is_violation: bool

    @classmethod
    def of(cls, replayed: Replay) -> SwarmRun:
        """Return a replay of MLR-DMPC in these terms."""
        assert isinstance(replayed.reading, Semantics)
        trace = replayed.trace
        return cls(
            trace.sizes["uavs"],
            trace.sizes["cus"],
            replayed.reading,
            trace.shows,
            trace.loop_start,
            replayed.states,
            tuple(sent.air for sent in replayed.sent),
            replayed.events,
            tuple(replayed.broken_at(k) for k in range(len(replayed.states))),
            replayed.lost_messages,
            replayed.is_violation,
        )
