"""How things are called on the pages: UAVs, CUs, trajectories, trackers, messages, and lists of them."""

from __future__ import annotations

from collections.abc import Iterable

from swarmproof.dmpc_swarm.protocol.messages import (
    HOVERING,
    CuMessage,
    EmptyMessage,
    Trajectory,
    TrajectoryMessage,
    TrajectoryRequestMessage,
)
from swarmproof.dmpc_swarm.protocol.network import Slot
from swarmproof.pages import phrases


def uav(i: int) -> str:
    """Return the name of UAV i."""
    return f"UAV {i}"


def cu(w: int) -> str:
    """Return the name of CU w."""
    return f"CU {w}"


def uavs(indices: Iterable[int]) -> str:
    """Return the names of several UAVs."""
    return phrases.listing([uav(i) for i in indices])


def cus(indices: Iterable[int]) -> str:
    """Return the names of several CUs."""
    return phrases.listing([cu(w) for w in indices])


def trajectory(named: Trajectory) -> str:
    """Return a trajectory's name: its calculation round and CU, which are its metadata."""
    return "hover" if named == HOVERING else f"τ({named.metadata.round}, {cu(named.metadata.cu)})"


def entries(trajectories: Iterable[Trajectory]) -> str:
    """Return a tracker's entries, in the order in which they came into it."""
    return "{" + ", ".join(trajectory(one) for one in trajectories) + "}"


def tracker(w: int, i: int) -> str:
    """Return the name of D_iw."""
    return f"{cu(w)}'s tracker of {uav(i)}"


def message(sent: CuMessage) -> str:
    """Return what a CU transmits, shortly."""
    if isinstance(sent, EmptyMessage):
        return "empty message"
    if isinstance(sent, TrajectoryRequestMessage):
        return f"request to {uav(sent.uav)}"
    return f"plan for {uav(sent.uav)}: {trajectory(sent.trajectory)}"


def reply(sent: TrajectoryMessage) -> str:
    """Return what a UAV transmits that was asked, shortly."""
    return f"reply of {uav(sent.uav)}: {trajectory(sent.trajectory)}"


def on_slot(slot: int, sent: Slot) -> str:
    """Return what is transmitted in the slot of CU `slot`, with its senders."""
    parts = []
    if sent.cu_message is not None:
        parts.append(of_cu(slot, sent.cu_message))
    if sent.reply is not None:
        parts.append(of_uav(sent.reply))
    return phrases.listing(parts) or "nothing"


def of_cu(w: int, sent: CuMessage) -> str:
    """Return what CU w transmits, within a sentence."""
    if isinstance(sent, TrajectoryMessage):
        return f"{cu(w)}'s plan {trajectory(sent.trajectory)} for {uav(sent.uav)}"
    return f"{cu(w)}'s {message(sent)}"


def of_uav(sent: TrajectoryMessage) -> str:
    """Return what a UAV transmits that was asked, within a sentence."""
    return f"{uav(sent.uav)}'s reply carrying {trajectory(sent.trajectory)}"
