"""What Algorithm 2 did to one CU's trackers in one update, and what became of a slot at one receiver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.swarm_run import SwarmRun
from swarmproof.dmpc_swarm.protocol.algorithm2 import update_information_trackers
from swarmproof.dmpc_swarm.protocol.messages import Trajectory, TrajectoryMessage
from swarmproof.dmpc_swarm.protocol.network import Reception


@dataclass(frozen=True)
class Explained:
    """One update of one CU, as the model ran it, with what it received.

    Attributes:
        matched: by UAV, the entry that its metadata message matched (lines 3-7).
        unmatched: UAVs whose metadata message matched no entry.
        unheard: UAVs of which no metadata message was received.
        several: UAVs whose tracker held several entries after the matching (line 12).
        marked: UAVs whose trackers line 13 marked deprecated.
        received: the number of CU messages received (line 17).
        all_marked: whether line 18 marked every tracker deprecated.
        added: by slot, the trajectories that line 22 added (`loss_handling=ignore`: that replaced the content).
    """

    matched: Mapping[int, Trajectory]
    unmatched: tuple[int, ...]
    unheard: tuple[int, ...]
    several: tuple[int, ...]
    marked: frozenset[int]
    received: int
    all_marked: bool
    added: Mapping[int, TrajectoryMessage]

    def flag(self, i: int, before: bool) -> bool:
        """Return the flag of the tracker of UAV i that follows from this explanation."""
        return self.all_marked or i in self.marked or (before and i not in self.matched)


def explain_in(replayed: SwarmRun, w: int, k: int) -> Explained:
    """Explain the update of CU w at the start of round k (k > 0), from what Algorithm 2 itself recorded."""
    inbox = replayed.events[k - 1].at_cus[w].inbox
    trackers = replayed.swarms[k - 1].cus[w].trackers
    update = update_information_trackers(
        inbox.uav_messages, inbox.cu_messages, trackers, replayed.cus, replayed.semantics
    )
    metadata_matters = replayed.semantics.loss_handling == "recover"
    every = range(len(trackers)) if metadata_matters else ()
    return Explained(
        update.matched,
        tuple(i for i in every if i in inbox.uav_messages and i not in update.matched),
        tuple(i for i in every if i not in inbox.uav_messages),
        tuple(i for i in every if update.several[i]),
        frozenset(i for i in every if update.marked[i]),
        len(inbox.cu_messages),
        update.incomplete,
        {slot: m for slot, m in sorted(inbox.cu_messages.items()) if isinstance(m, TrajectoryMessage)},
    )


def slot_at(replayed: SwarmRun, k: int, slot: int, got: Reception, uav: int | None = None) -> str:
    """Say what a receiver got in a slot of round k, with what was not received first and why.

    The text continues a sentence that names the receiver: "of slot 1, it ...". `uav` is its index if it is a UAV.
    """
    sent = replayed.airs[k].slots[slot]
    heard = got.inbox.cu_messages.get(slot)
    if sent.cu_message is None and sent.reply is None:
        asked = replayed.events[k - 1].decided[slot] if k else None
        reason = "" if asked is None else f", and the request to {names.uav(asked)} of round {k - 1} did not reach it"
        return f"got nothing, since nobody transmitted: {names.cu(slot)} donated the slot{reason}"
    if heard is not None:
        if sent.cu_message is None or sent.reply is None:
            return f"received {names.on_slot(slot, sent)}"
        first, second = names.of_cu(slot, sent.cu_message), names.of_uav(sent.reply)
        chosen, other = (second, first) if slot in got.decoded_replies else (first, second)
        return f"decoded {chosen}, and not {other}"
    if slot in got.lost_slots:
        if sent.cu_message is not None and sent.reply is not None and replayed.semantics.slot_conflict == "either":
            return f"decoded neither {names.of_cu(slot, sent.cu_message)} nor {names.of_uav(sent.reply)} (lost to it)"
        lost = names.of_cu(slot, sent.cu_message) if sent.cu_message is not None else names.on_slot(slot, sent)
        return f"did not receive {lost} (lost on the way)"
    if uav is not None and sent.reply is not None and sent.reply.uav == uav:
        return "heard nothing, since it transmitted its reply in the slot itself"
    return f"could decode nothing, since {names.on_slot(slot, sent)} collided"
