"""What is lost in one communication phase: boolean arrays over (receiver, message) pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from swarmproof.dmpc_swarm.protocol.network import Reception

#: One truth value per (receiver, message): rows are receivers.
Pairs = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class BySender:
    """What is lost in the slots of M CUs where that depends on who sends; the arrays become read-only.

    Rows are receivers: the M CUs, then the N UAVs.

    Attributes:
        of_cus: (M + N, M), the receiver does not get what CU s itself sends in slot s.
        of_uavs: (M + N, M, N), the receiver does not get what UAV i replies in slot s.

    Raises:
        ValueError: the shapes do not fit together.
    """

    of_cus: Pairs
    of_uavs: Pairs

    def __post_init__(self) -> None:
        receivers, cus = self.of_cus.shape
        if self.of_uavs.shape != (receivers, cus, receivers - cus):
            raise ValueError(f"an array of {self.of_uavs.shape} does not fit {receivers - cus} UAVs and {cus} CUs")
        self.of_cus.setflags(write=False)
        self.of_uavs.setflags(write=False)


@dataclass(frozen=True, slots=True, eq=False)
class Losses:
    """What is lost in one communication phase of N UAVs and M CUs; the arrays become read-only.

    True where the message does not arrive. What is not sent cannot be lost: such marks have no effect.
    The diagonal of `cu_slot` is about replies only: a CU that transmits in its slot has its own message, but one that
    has given its slot to a UAV can lose the reply, like everyone else (`mlr.network`).

    Attributes:
        cu_uav: (M, N), CU w does not get UAV i's metadata message.
        cu_slot: (M, M), CU w does not get what is sent in slot s.
        uav_slot: (N, M), UAV i does not get what is sent in slot s.
        replies_at_cus: (M, M), where two transmit in slot s and `slot_conflict=either`: True if CU w decodes the UAV's
            reply, False if it decodes the CU's message.
        replies_at_uavs: (N, M), the same at UAV i.
        by_sender: what is lost in slots besides, depending on the sender; None if nothing is.

    Raises:
        ValueError: the shapes do not fit together.
    """

    cu_uav: Pairs
    cu_slot: Pairs
    uav_slot: Pairs
    replies_at_cus: Pairs
    replies_at_uavs: Pairs
    by_sender: BySender | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        cus, uavs = self.cu_uav.shape
        for array, receivers, messages in (
            (self.cu_uav, cus, uavs),
            (self.cu_slot, cus, cus),
            (self.uav_slot, uavs, cus),
            (self.replies_at_cus, cus, cus),
            (self.replies_at_uavs, uavs, cus),
        ):
            if array.shape != (receivers, messages):
                raise ValueError(f"an array of {array.shape} does not fit {uavs} UAVs and {cus} CUs")
            array.setflags(write=False)
        if self.by_sender is not None and self.by_sender.of_cus.shape != (cus + uavs, cus):
            raise ValueError(f"losses by sender of {self.by_sender.of_cus.shape} do not fit {uavs} UAVs and {cus} CUs")

    @property
    def count(self) -> int:
        """The number of pairs marked as lost, whether anything is sent or not, those of `by_sender` left out.

        What a flight lost is the sum of `Reception.lost`.
        """
        return sum(int(np.count_nonzero(array)) for array in (self.cu_uav, self.cu_slot, self.uav_slot))


@cache
def nothing_lost(uavs: int, cus: int) -> Losses:
    """Return the losses of a round in which everything arrives; in a conflict the CU's message is decoded."""
    return Losses(
        np.zeros((cus, uavs), bool),
        np.zeros((cus, cus), bool),
        np.zeros((uavs, cus), bool),
        np.zeros((cus, cus), bool),
        np.zeros((uavs, cus), bool),
    )


@cache
def everything_lost(uavs: int, cus: int) -> Losses:
    """Return the losses of a round in which nothing arrives but what a sender has of its own."""
    return Losses(
        np.ones((cus, uavs), bool),
        np.ones((cus, cus), bool),
        np.ones((uavs, cus), bool),
        np.zeros((cus, cus), bool),
        np.zeros((uavs, cus), bool),
    )


def lost_in(at_cus: Sequence[Reception], at_uavs: Sequence[Reception]) -> Losses:
    """Return the losses of a round in which CUs and UAVs received this: `deliver` gives these receptions back."""
    cus, uavs = len(at_cus), len(at_uavs)

    def marked(receptions: Sequence[Reception], columns: int, of: str) -> Pairs:
        array = np.zeros((len(receptions), columns), bool)
        for row, reception in enumerate(receptions):
            array[row, list(getattr(reception, of))] = True
        return array

    return Losses(
        marked(at_cus, uavs, "lost_uavs"),
        marked(at_cus, cus, "lost_slots"),
        marked(at_uavs, cus, "lost_slots"),
        marked(at_cus, cus, "decoded_replies"),
        marked(at_uavs, cus, "decoded_replies"),
    )
