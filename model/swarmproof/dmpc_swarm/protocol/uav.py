"""A UAV as the protocol sees it: the trajectory that it follows (eq. 10) and the requests that it will answer."""

from __future__ import annotations

from dataclasses import dataclass

from swarmproof.dmpc_swarm.protocol.algorithm1 import Inbox
from swarmproof.dmpc_swarm.protocol.messages import HOVERING, Trajectory, TrajectoryMessage, TrajectoryRequestMessage


@dataclass(frozen=True, slots=True)
class Uav:
    """UAV i: what it follows in this round, and the CUs whose requests of the last round it answers in this one."""

    i: int
    followed: Trajectory = HOVERING
    asked_by: frozenset[int] = frozenset()


def offers(uav: Uav, inbox: Inbox) -> tuple[Trajectory, ...]:
    """Return the new trajectories that UAV i received, by slot."""
    return tuple(
        message.trajectory
        for _slot, message in sorted(inbox.cu_messages.items())
        if isinstance(message, TrajectoryMessage) and message.uav == uav.i
    )


def adopt(uav: Uav, inbox: Inbox, adopted: Trajectory | None) -> Uav:
    """Return UAV i at the start of the next round: it follows a new trajectory if it received one (eq. 10).

    `adopted` is one of :func:`offers`, or None if there are none; the paper does not say which of several.
    """
    asked_by = frozenset(
        slot
        for slot, message in inbox.cu_messages.items()
        if isinstance(message, TrajectoryRequestMessage) and message.uav == uav.i
    )
    return Uav(uav.i, uav.followed if adopted is None else adopted, asked_by)
