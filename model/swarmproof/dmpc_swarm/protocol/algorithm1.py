"""Algorithm 1 of DMPC-Swarm: MLR-DMPC running on CU w. Comments carry the paper's line numbers.

The computation phase is cut in two where the claims are read: :func:`update` is lines 8-11 (and the selection of
lines 14-15), :func:`transmit` is the rest, given one of the decisions that :func:`decisions` leaves open.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import product

from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker, update_information_trackers
from swarmproof.dmpc_swarm.protocol.event_trigger import (
    CalcPriorities,
    calc_priorities,
    prio_consensus,
    select_uav,
    top_priorities,
)
from swarmproof.dmpc_swarm.protocol.messages import (
    HOVERING,
    CuMessage,
    EmptyMessage,
    Metadata,
    Trajectory,
    TrajectoryMessage,
    TrajectoryRequestMessage,
    UavMessage,
)
from swarmproof.dmpc_swarm.semantics import Semantics


class CuState(IntEnum):
    """The four states of Algorithm 1."""

    RUN_DMPC = 0
    WAIT = 1
    REQUEST_TRAJECTORY = 2
    WAIT_FOR_UPDATE = 3


@dataclass(frozen=True, slots=True)
class ComputeUnit:
    """CU w in the computation phase, after lines 8-11.

    Attributes:
        w: its index, which is also its slot.
        trackers: D_iw(k) for i = 0 ... N-1.
        next_request: where `request_order=round-robin` goes on looking for a deprecated tracker.
        a_et: A_ET(k), highest priority first; None unless in RUN_DMPC under `event_trigger=round-robin`.
    """

    w: int
    state: CuState
    trackers: tuple[InformationTracker, ...]
    next_request: int = 0
    a_et: tuple[int, ...] | None = None


@dataclass(frozen=True, slots=True)
class Inbox:
    """What one receiver got in one communication phase: by UAV, and by slot of the CUs (its own message included)."""

    uav_messages: Mapping[int, UavMessage]
    cu_messages: Mapping[int, CuMessage]


#: What a CU decides in lines 12-32: the UAV that it plans or asks; None where it does neither.
Decision = int | None


def initial(w: int, uavs: int, cus: int, semantics: Semantics) -> ComputeUnit:
    """Return CU w in the first computation phase."""
    if semantics.initial == "known":
        known = (InformationTracker((HOVERING,), deprecated=False),) * uavs
        a_et = top_priorities(None, uavs, cus) if semantics.event_trigger == "round-robin" else None
        return ComputeUnit(w, CuState.RUN_DMPC, known, a_et=a_et)
    empty = (InformationTracker((), deprecated=True),) * uavs  # lines 2-3
    return ComputeUnit(w, CuState.REQUEST_TRAJECTORY, empty)  # line 4


def update(cu: ComputeUnit, inbox: Inbox, cus: int, semantics: Semantics) -> ComputeUnit:
    """Return CU w after lines 8-11 and 14 of the next round, having received `inbox` in this one."""
    uavs = len(cu.trackers)
    updated = update_information_trackers(inbox.uav_messages, inbox.cu_messages, cu.trackers, cus, semantics)  # line 8
    trackers = updated.trackers
    state = cu.state
    may_rejoin = semantics.rejoin == "any-state" or state != CuState.WAIT_FOR_UPDATE
    if not any(tracker.deprecated for tracker in trackers) and may_rejoin:
        state = CuState.RUN_DMPC  # line 9
    elif state == CuState.RUN_DMPC:
        state = CuState.WAIT  # line 10
    a_et = None
    if state == CuState.RUN_DMPC and semantics.event_trigger == "round-robin":
        prios = prio_consensus(inbox.cu_messages.values())  # line 14
        a_et = top_priorities(prios, uavs, cus)
    return replace(cu, state=state, trackers=trackers, a_et=a_et)


def may_plan(cu: ComputeUnit, k: int, cus: int) -> tuple[int, ...]:
    """Return the UAVs that CU w may plan in round k: those with one entry (line 17) that the trigger can select."""
    if cu.state != CuState.RUN_DMPC:
        return ()
    if cu.a_et is None:
        selectable: tuple[int, ...] = tuple(range(len(cu.trackers)))
    else:
        selected = select_uav(cu.a_et, k, cu.w, cus)  # line 15
        selectable = () if selected is None else (selected,)
    return tuple(i for i in selectable if len(cu.trackers[i].trajectories) == 1)  # line 17


def decisions(cu: ComputeUnit, k: int, cus: int, semantics: Semantics) -> tuple[Decision, ...]:
    """Return what lines 12-32 leave open to CU w in round k: whom it plans, or whom it asks."""
    if cu.state == CuState.RUN_DMPC:
        plannable = may_plan(cu, k, cus)
        if semantics.event_trigger == "any":
            return (None, *plannable)
        return plannable or (None,)
    if cu.state == CuState.REQUEST_TRAJECTORY:
        deprecated = [i for i, tracker in enumerate(cu.trackers) if tracker.deprecated]  # line 26
        if semantics.request_order == "any":
            return tuple(deprecated)
        if semantics.request_order == "round-robin":
            return (min(deprecated, key=lambda i: (i - cu.next_request) % len(cu.trackers)),)
        return (deprecated[0],)
    return (None,)


def joint_decisions(options: list[tuple[tuple[Decision, bool], ...]]) -> list[tuple[Decision, ...]]:
    """Return every combination of the CUs' options in which no two CUs plan the same UAV (`event_trigger=any`).

    Each option is (decision, whether it is a plan that must differ from the others').
    """
    combinations = []
    for combination in product(*options):
        planned = [uav for uav, exclusive in combination if exclusive]
        if len(set(planned)) == len(planned):
            combinations.append(tuple(uav for uav, _ in combination))
    return combinations


def is_exclusive(cu: ComputeUnit, decision: Decision, semantics: Semantics) -> bool:
    """Say whether no other CU may take this decision in the same round (plans, under `event_trigger=any`)."""
    return semantics.event_trigger == "any" and cu.state == CuState.RUN_DMPC and decision is not None


def transmit(
    cu: ComputeUnit,
    k: int,
    decision: Decision,
    semantics: Semantics,
    calculate: CalcPriorities = calc_priorities,
) -> tuple[ComputeUnit, CuMessage | None]:
    """Return CU w after lines 12-34 of round k and what it transmits in its slot (None: it stays silent).

    `calculate` gives the priorities of line 34, where CUs announce any.
    """
    running = cu.state == CuState.RUN_DMPC
    planned = decision if running else None
    prios = None
    if semantics.event_trigger == "round-robin":
        prios = calculate(k, cu.trackers, running, planned)  # line 34
    if cu.state == CuState.RUN_DMPC:  # line 13
        if planned is not None:  # lines 15 and 17: `decisions` offers no other UAV
            new = Trajectory(Metadata(k, cu.w))  # line 18
            return cu, TrajectoryMessage(planned, new, prios)  # line 19
        return cu, EmptyMessage(prios)  # line 16
    if cu.state == CuState.WAIT:  # line 22
        return replace(cu, state=CuState.REQUEST_TRAJECTORY), EmptyMessage(prios)  # lines 23-24
    if cu.state == CuState.REQUEST_TRAJECTORY:  # line 25
        assert decision is not None
        asked = replace(cu, state=CuState.WAIT_FOR_UPDATE)  # line 28
        if semantics.request_order == "round-robin":
            asked = replace(asked, next_request=(decision + 1) % len(cu.trackers))
        return asked, TrajectoryRequestMessage(decision, prios)  # line 27
    return replace(cu, state=CuState.REQUEST_TRAJECTORY), None  # lines 29-31: the requested UAV has the slot
