"""Heartbeat: UAVs find out who of them may fly through a gap that has room for one. The rules are numbered."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from swarmproof.heartbeat.claims import Observed
from swarmproof.heartbeat.semantics import Semantics
from swarmproof.port.broadcast import Broadcast

#: Rounds of silence after which a UAV is taken to be gone, and for which a vote is given.
PATIENCE = 2


class Uav(NamedTuple):
    """What one UAV knows.

    Attributes:
        silence: by UAV, for how many rounds it was not heard, up to PATIENCE.
        vote: for whom it votes.
        bound: rounds in which it must not vote for another, since its last vote may still count; PATIENCE: it votes.
        held: by UAV, for how many rounds its vote for this one still counts.
    """

    silence: tuple[int, ...]
    vote: int
    bound: int
    held: tuple[int, ...]


class Heartbeat(Broadcast[Uav, int]):
    """The protocol of N UAVs; a message is a heartbeat with the UAV that is voted for, or −1."""

    def __init__(self, sizes: Mapping[str, int], semantics: Semantics) -> None:
        super().__init__(sizes["uavs"], "UAV")
        self.semantics = semantics

    def start(self, i: int) -> Uav:
        """Return UAV i: it has heard of all, and votes for UAV 0 (line 1)."""
        return Uav((0,) * self.count, 0, PATIENCE, (0,) * self.count)

    def send(self, i: int, node: Uav) -> int:
        """Return its heartbeat, with its vote unless it waits for that to run out (line 2)."""
        return node.vote if self.semantics.leads == "majority" and node.bound == PATIENCE else -1

    def update(self, i: int, node: Uav, inbox: Mapping[int, int]) -> Uav:
        """Return UAV i after a round (lines 3-8)."""
        silence = tuple(
            0 if j == i or j in inbox else min(old + 1, PATIENCE)
            for j, old in enumerate(node.silence)  # line 3
        )
        if self.semantics.leads == "timeout":
            return node._replace(silence=silence)
        votes = {**inbox, i: self.send(i, node)}
        held = tuple(PATIENCE if votes.get(j) == i else max(old - 1, 0) for j, old in enumerate(node.held))  # line 4
        heard = {i, *inbox}
        goes_on = node.vote in heard if self.semantics.renewal == "any" else node.vote == min(heard)
        if node.bound == PATIENCE and goes_on:  # line 5: the vote is renewed
            return Uav((0,) * self.count, node.vote, PATIENCE, held)
        if node.bound > 1:  # line 6: it waits
            return Uav((0,) * self.count, node.vote, node.bound - 1, held)
        return Uav((0,) * self.count, min(heard), PATIENCE, held)  # line 7: it votes anew

    def leads(self, i: int, node: Uav) -> bool:
        """Say whether UAV i takes itself for the leader (line 8)."""
        if self.semantics.leads == "timeout":
            return all(node.silence[j] == PATIENCE for j in range(i))
        return sum(left > 0 for left in node.held) > self.count / 2

    def observe(self, state: tuple[Uav, ...]) -> Observed:
        """Return who leads."""
        return Observed(tuple(i for i, node in enumerate(state) if self.leads(i, node)))

    def tell(self, i: int, node: Uav) -> str:
        """Return what UAV i knows, in words."""
        leads = "leads" if self.leads(i, node) else "follows"
        if self.semantics.leads == "timeout":
            silent = [f"UAV {j} for {rounds}" for j, rounds in enumerate(node.silence) if rounds]
            return f"{leads}; rounds of silence: {', '.join(silent) or 'none'}"
        waits = "" if node.bound == PATIENCE else f" (rounds until it may change: {node.bound})"
        held = [f"UAV {j} for {left}" for j, left in enumerate(node.held) if left]
        return f"{leads}; its vote: UAV {node.vote}{waits}; rounds of votes held: {', '.join(held) or 'none'}"
