"""The round-robin event trigger (Section 4.2.2, eq. 11, Appendix A.1): priorities, their consensus, the selection."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker
from swarmproof.dmpc_swarm.protocol.messages import CuMessage, Priorities

#: Announced for the UAV whose new trajectory the very message carries (Appendix A).
JUST_RECALCULATED = 0
#: Announced for every UAV by a CU that is not in RUN_DMPC.
NO_OPINION = 1

#: From k, the trackers, whether the CU is in RUN_DMPC and whom it plans to the priorities of all UAVs (Alg. 1 line 34).
CalcPriorities = Callable[[int, Sequence[InformationTracker], bool, int | None], tuple[int, ...]]


def calc_priorities(
    k: int, trackers: Sequence[InformationTracker], running: bool, planned: int | None
) -> tuple[int, ...]:
    """Return J_iw(k) = k - k_calc of the first entry of D_iw(k), for every UAV i (eq. A1 and Appendix A)."""
    if not running:
        return (NO_OPINION,) * len(trackers)
    return tuple(
        JUST_RECALCULATED if i == planned else k - tracker.trajectories[0].metadata.round
        for i, tracker in enumerate(trackers)
    )


def prio_consensus(cu_messages: Iterable[CuMessage]) -> Priorities:
    """Return J_i(k) = max over w of J_iw(k-1) (eq. 11), but zero where any CU says zero (Appendix A).

    None if no message carried priorities: all UAVs tie.
    """
    announced = [message.priorities for message in cu_messages if message.priorities is not None]
    if not announced:
        return None
    return tuple(0 if 0 in of_uav else max(of_uav) for of_uav in zip(*announced, strict=True))


def top_priorities(priorities: Priorities, uavs: int, cus: int) -> tuple[int, ...]:
    """Return A_ET(k): the min(M, N) UAVs of highest priority, highest first, ties to the lowest index."""
    by_priority = range(uavs) if priorities is None else sorted(range(uavs), key=lambda i: (-priorities[i], i))
    return tuple(by_priority)[: min(uavs, cus)]


def select_uav(a_et: Sequence[int], k: int, w: int, cus: int) -> int | None:
    """Return the UAV at position (k + w) mod M of A_ET(k) (Section 4.2.2); None where the position is N or more."""
    position = (k + w) % cus
    return a_et[position] if position < len(a_et) else None
