"""The network: one slot per CU and round, and what each receiver can get out of it.

Any (message, receiver) pair may be lost. Two transmitters in one slot are a conflict; `slot_conflict` decides what is
heard.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

from swarmproof.dmpc_swarm.protocol.algorithm1 import Inbox
from swarmproof.dmpc_swarm.protocol.messages import CuMessage, TrajectoryMessage, UavMessage
from swarmproof.dmpc_swarm.protocol.uav import Uav
from swarmproof.dmpc_swarm.semantics import Semantics


class Slot(NamedTuple):
    """What is transmitted in the slot of one CU: by the CU, and by the UAV that it asked in the round before."""

    cu_message: CuMessage | None
    reply: TrajectoryMessage | None

    @property
    def conflict(self) -> bool:
        """Whether two devices transmit."""
        return self.cu_message is not None and self.reply is not None


class Air(NamedTuple):
    """Everything transmitted in one communication phase."""

    uav_messages: tuple[UavMessage, ...]
    slots: tuple[Slot, ...]


@dataclass(frozen=True, slots=True)
class Reception:
    """What one receiver gets in one round, and how.

    Attributes:
        inbox: the messages received.
        lost_uavs: UAVs whose metadata message was lost.
        lost_slots: slots whose message was lost.
        decoded_replies: slots with a conflict in which the reply was decoded, not the CU's message.
    """

    inbox: Inbox
    lost_uavs: tuple[int, ...]
    lost_slots: tuple[int, ...]
    decoded_replies: tuple[int, ...]

    @property
    def lost(self) -> int:
        """The number of messages lost on the way to this receiver."""
        return len(self.lost_uavs) + len(self.lost_slots)


def on_air(uavs: Sequence[Uav], cu_messages: Sequence[CuMessage | None]) -> Air:
    """Return what is transmitted: metadata by every UAV, the CUs' messages, and the replies in donated slots."""
    replies: list[TrajectoryMessage | None] = [None] * len(cu_messages)
    for uav in uavs:
        for slot in uav.asked_by:
            replies[slot] = TrajectoryMessage(uav.i, uav.followed)
    return Air(
        tuple(UavMessage(uav.followed.metadata) for uav in uavs),
        tuple(Slot(message, reply) for message, reply in zip(cu_messages, replies, strict=True)),
    )


class _Heard(NamedTuple):
    message: CuMessage | None
    lost: bool = False
    decoded_reply: bool = False


_NOTHING = _Heard(None)
_LOST = _Heard(None, lost=True)


def _at_cu(w: int, slot: int, on_slot: Slot, semantics: Semantics) -> tuple[_Heard, ...]:
    """What CU w can hear in `slot`."""
    message, reply = on_slot
    if message is not None and w == slot:
        return (_Heard(message),)  # a sender has its own message
    return _at_bystander(message, reply, semantics)


def _at_uav(i: int, on_slot: Slot, semantics: Semantics) -> tuple[_Heard, ...]:
    """What UAV i can hear in a slot."""
    message, reply = on_slot
    if reply is not None and reply.uav == i:  # it transmits itself
        if message is not None and semantics.slot_conflict == "cu-wins":
            return (_Heard(message), _LOST)
        return (_NOTHING,)
    return _at_bystander(message, reply, semantics)


def _at_bystander(
    message: CuMessage | None, reply: TrajectoryMessage | None, semantics: Semantics
) -> tuple[_Heard, ...]:
    """What a receiver that does not transmit in the slot can hear in it."""
    if message is None and reply is None:
        return (_NOTHING,)
    if message is None or reply is None:
        return (_Heard(message if reply is None else reply), _LOST)
    if semantics.slot_conflict == "both-lost":
        return (_NOTHING,)
    if semantics.slot_conflict == "cu-wins":
        return (_Heard(message), _LOST)
    return (_Heard(message), _Heard(reply, decoded_reply=True), _LOST)


def _reception(air: Air, heard_uavs: Sequence[bool], heard: Sequence[_Heard]) -> Reception:
    inbox = Inbox(
        {i: air.uav_messages[i] for i, received in enumerate(heard_uavs) if received},
        {slot: got.message for slot, got in enumerate(heard) if got.message is not None},
    )
    return Reception(
        inbox,
        tuple(i for i, received in enumerate(heard_uavs) if not received),
        tuple(slot for slot, got in enumerate(heard) if got.lost),
        tuple(slot for slot, got in enumerate(heard) if got.decoded_reply),
    )


def cu_receptions(w: int, air: Air, semantics: Semantics) -> Iterator[Reception]:
    """Yield everything that CU w can receive: every subset of messages lost, every outcome of a conflict."""
    per_slot = [_at_cu(w, slot, on_slot, semantics) for slot, on_slot in enumerate(air.slots)]
    for heard_uavs in product((True, False), repeat=len(air.uav_messages)):
        for heard in product(*per_slot):
            yield _reception(air, heard_uavs, heard)


def uav_receptions(i: int, air: Air, semantics: Semantics) -> Iterator[Reception]:
    """Yield everything that UAV i can receive in the CUs' slots (it has no use for other UAVs' metadata)."""
    per_slot = [_at_uav(i, on_slot, semantics) for on_slot in air.slots]
    for heard in product(*per_slot):
        yield _reception(air, (True,) * len(air.uav_messages), heard)


def receive_at_cu(
    w: int,
    air: Air,
    lost_uavs: Collection[int],
    lost_slots: Collection[int],
    decoded_replies: Collection[int],
    semantics: Semantics,
) -> Reception:
    """Return what CU w receives when these messages are lost on the way to it.

    Where nothing is sent, nothing is lost; `decoded_replies` are the slots of which it decodes the reply in a conflict.
    """
    options = [_at_cu(w, slot, on_slot, semantics) for slot, on_slot in enumerate(air.slots)]
    heard_uavs = [i not in lost_uavs for i in range(len(air.uav_messages))]
    return _reception(air, heard_uavs, _choose(options, lost_slots, decoded_replies))


def receive_at_uav(
    i: int, air: Air, lost_slots: Collection[int], decoded_replies: Collection[int], semantics: Semantics
) -> Reception:
    """Return what UAV i receives in the CUs' slots when these are lost on the way to it, as :func:`receive_at_cu`."""
    options = [_at_uav(i, on_slot, semantics) for on_slot in air.slots]
    return _reception(air, (True,) * len(air.uav_messages), _choose(options, lost_slots, decoded_replies))


def _choose(
    options: Sequence[tuple[_Heard, ...]], lost_slots: Collection[int], decoded_replies: Collection[int]
) -> list[_Heard]:
    def choose(slot: int, possible: tuple[_Heard, ...]) -> _Heard:
        if slot in lost_slots and possible[-1].lost:
            return possible[-1]
        if slot in decoded_replies and len(possible) > 1 and possible[1].decoded_reply:
            return possible[1]
        return possible[0]

    return [choose(slot, possible) for slot, possible in enumerate(options)]
