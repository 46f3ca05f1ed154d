"""From what is transmitted and what is lost to what everyone receives."""

from __future__ import annotations

import numpy as np

from swarmproof.dmpc_swarm.protocol.network import Air, Reception, receive_at_cu, receive_at_uav
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.faults.pattern import Losses, Pairs

_Indices = tuple[int, ...]


def deliver(air: Air, losses: Losses, semantics: Semantics) -> tuple[tuple[Reception, ...], tuple[Reception, ...]]:
    """Return what each CU and what each UAV receives of one communication phase; UAVs may share a reception.

    The rules are those of `mlr.network`. UAVs with the same losses get the same, since they differ in one thing only:
    a UAV that replies does not hear its own slot. So the network is asked once for all of them.

    Raises:
        ValueError: the losses are those of another swarm.
    """
    if losses.cu_uav.shape != (len(air.slots), len(air.uav_messages)):
        raise ValueError(f"losses of {losses.cu_uav.shape} CUs and UAVs do not fit what is transmitted")
    losses = _in_slots(air, losses, semantics)
    at_cus = tuple(
        receive_at_cu(w, air, lost_uavs, lost_slots, decoded, semantics)
        for w, (lost_uavs, lost_slots, decoded) in enumerate(
            zip(_marked(losses.cu_uav), _marked(losses.cu_slot), _marked(losses.replies_at_cus), strict=True)
        )
    )
    replying = {on_slot.reply.uav for on_slot in air.slots if on_slot.reply is not None}
    # without a conflict, nobody looks at the coins: let them not keep apart what is equal
    conflict = any(on_slot.conflict for on_slot in air.slots)
    decoded_at_uavs = _marked(losses.replies_at_uavs) if conflict else [()] * len(air.uav_messages)
    shared: dict[tuple[_Indices, _Indices], Reception] = {}
    at_uavs = []
    for i, missed in enumerate(zip(_marked(losses.uav_slot), decoded_at_uavs, strict=True)):
        if i in replying:
            at_uavs.append(receive_at_uav(i, air, *missed, semantics))
            continue
        if missed not in shared:
            shared[missed] = receive_at_uav(i, air, *missed, semantics)
        at_uavs.append(shared[missed])
    return at_cus, tuple(at_uavs)


def _in_slots(air: Air, losses: Losses, semantics: Semantics) -> Losses:
    """Return the same losses slot by slot, now that it is known who sends in each.

    In a conflict, who gets only one of the two messages hears that one; who gets neither has lost the slot. With
    `slot_conflict=cu-wins` only the CU's message can be heard, so that it is the one that counts.
    """
    by = losses.by_sender
    if by is None:
        return losses
    cus = len(air.slots)
    lost = np.concatenate([losses.cu_slot, losses.uav_slot])
    decoded = np.concatenate([losses.replies_at_cus, losses.replies_at_uavs])
    for s, (message, reply) in enumerate(air.slots):
        of_cu = by.of_cus[:, s]
        if reply is None or (message is not None and semantics.slot_conflict == "cu-wins"):
            lost[:, s] |= of_cu
            continue
        of_uav = by.of_uavs[:, s, reply.uav]
        if message is None:
            lost[:, s] |= of_uav
            continue
        lost[:, s] |= of_cu & of_uav
        decoded[:, s] = np.where(of_cu ^ of_uav, of_cu, decoded[:, s])
    return Losses(losses.cu_uav, lost[:cus], lost[cus:], decoded[:cus], decoded[cus:])


def _marked(array: Pairs) -> list[_Indices]:
    """Return the marked columns of each row."""
    if not array.any():
        return [()] * len(array)
    return [tuple(j for j, marked in enumerate(row) if marked) for row in array.tolist()]
