"""What Algorithm 2 did to one CU's trackers in one update, and what became of a slot at one receiver."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from swarmproof.mlr.algorithm2 import InformationTracker
from swarmproof.mlr.messages import CuMessage, Trajectory, TrajectoryMessage, UavMessage
from swarmproof.mlr.network import Reception
from swarmproof.report import names
from swarmproof.semantics.switches import Semantics
from swarmproof.traces.trace import Replay


@dataclass(frozen=True)
class Update:
    """One run of Algorithm 2, taken apart.

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


def explain(
    trackers: Sequence[InformationTracker],
    uav_messages: Mapping[int, UavMessage],
    cu_messages: Mapping[int, CuMessage],
    cus: int,
    semantics: Semantics,
) -> Update:
    """Take apart how Algorithm 2 gets from D_w(k-1) and the messages of round k-1 to D_w(k)."""
    added = {slot: m for slot, m in sorted(cu_messages.items()) if isinstance(m, TrajectoryMessage)}
    if semantics.loss_handling == "ignore":
        return Update({}, (), (), (), frozenset(), len(cu_messages), False, added)
    matched = {
        i: entry
        for i, message in uav_messages.items()
        for entry in trackers[i].trajectories
        if entry.metadata == message.metadata
    }
    every = range(len(trackers))
    several = tuple(i for i in every if i not in matched and len(trackers[i].trajectories) > 1)
    marked = frozenset(several if semantics.deprecation == "one" else every) if several else frozenset[int]()
    return Update(
        matched,
        tuple(i for i in uav_messages if i not in matched),
        tuple(i for i in every if i not in uav_messages),
        several,
        marked,
        len(cu_messages),
        len(cu_messages) != cus,
        added,
    )


def explain_in(replayed: Replay, w: int, k: int) -> Update:
    """Take apart the update of CU w at the start of round k (k > 0)."""
    inbox = replayed.events[k - 1].at_cus[w].inbox
    trackers = replayed.swarms[k - 1].cus[w].trackers
    return explain(trackers, inbox.uav_messages, inbox.cu_messages, replayed.trace.cus, replayed.semantics)


def slot_at(replayed: Replay, k: int, slot: int, got: Reception, uav: int | None = None) -> str:
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
