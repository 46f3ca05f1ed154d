"""Algorithm 2 of DMPC-Swarm: how a CU updates its information trackers. Comments carry the paper's line numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from swarmproof.dmpc_swarm.protocol.messages import CuMessage, Trajectory, TrajectoryMessage, UavMessage
from swarmproof.dmpc_swarm.semantics import Semantics


class InformationTracker(NamedTuple):
    """D_iw: the trajectories that UAV i may be following, as far as CU w knows (Section 4.2).

    `trajectories` is a set; the tuple keeps the order of insertion, since Appendix A.1 speaks of the first entry.
    """

    trajectories: tuple[Trajectory, ...]
    deprecated: bool


class Update(NamedTuple):
    """One run of Algorithm 2: its result, and what led to it, for those who tell the story.

    Attributes:
        trackers: D_iw(k) for i = 0 ... N-1.
        matched: by UAV, the entry that its metadata matched (lines 5-7).
        several: by UAV, whether its intermediate tracker holds several entries (line 12).
        marked: by UAV, whether line 13 marks its tracker deprecated.
        incomplete: whether line 18 marks all of them.
    """

    trackers: tuple[InformationTracker, ...]
    matched: Mapping[int, Trajectory]
    several: Sequence[bool]
    marked: Sequence[bool]
    incomplete: bool


def update_information_trackers(
    uav_messages: Mapping[int, UavMessage],
    cu_messages: Mapping[int, CuMessage],
    trackers: Sequence[InformationTracker],
    cus: int,
    semantics: Semantics,
) -> Update:
    """Return D_w(k), and how it came to that, from D_w(k-1) and the messages received in round k-1 (Algorithm 2).

    Args:
        uav_messages: by UAV, what was received of it.
        cu_messages: by slot, what was received in the slots of the CUs, the CU's own message included.
        trackers: D_iw(k-1) for i = 0 ... N-1.
        cus: M.
        semantics: of which `deprecation` and `loss_handling` matter here.
    """
    if semantics.loss_handling == "ignore":
        return _replace_contents(cu_messages, trackers)
    d = [list(tracker.trajectories) for tracker in trackers]  # line 2
    deprecated = [tracker.deprecated for tracker in trackers]
    matched = {}
    for i, uav_message in uav_messages.items():  # line 3
        for trajectory in trackers[i].trajectories:  # line 4
            if trajectory.metadata == uav_message.metadata:  # line 5
                d[i] = [trajectory]  # line 6
                deprecated[i] = False  # line 7
                matched[i] = trajectory
                break  # line 8
    several = [len(d_i) > 1 for d_i in d]  # line 12
    marked = several
    if semantics.deprecation == "all":
        marked = [any(several)] * len(d)
    deprecated = [old or new for old, new in zip(deprecated, marked, strict=True)]  # line 13
    incomplete = len(cu_messages) != cus  # line 17
    if incomplete:
        deprecated = [True] * len(d)  # line 18
    for _slot, message in sorted(cu_messages.items()):  # line 20
        if isinstance(message, TrajectoryMessage):  # line 21
            d[message.uav] = _union(d[message.uav], message.trajectory)  # line 22
    updated = tuple(InformationTracker(tuple(d_i), flag) for d_i, flag in zip(d, deprecated, strict=True))
    return Update(updated, matched, several, marked, incomplete)  # line 25


def _union(entries: list[Trajectory], new: Trajectory) -> list[Trajectory]:
    return entries if new in entries else [*entries, new]


def _replace_contents(cu_messages: Mapping[int, CuMessage], trackers: Sequence[InformationTracker]) -> Update:
    """The older DMPC (`loss_handling=ignore`): what is received is believed, nothing is ever deprecated."""
    updated = list(trackers)
    for _slot, message in sorted(cu_messages.items()):
        if isinstance(message, TrajectoryMessage):
            updated[message.uav] = InformationTracker((message.trajectory,), deprecated=False)
    nothing = [False] * len(updated)
    return Update(tuple(updated), {}, nothing, nothing, incomplete=False)
