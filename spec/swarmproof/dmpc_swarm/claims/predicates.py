"""The claims' predicates: each returns where a claim is broken in an observed swarm; an empty list means it is true."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

from swarmproof.dmpc_swarm.claims.observed import RUN_DMPC, ObservedCu, ObservedSwarm, ObservedUav


class Broken(NamedTuple):
    """One place where a claim is false: the CUs (and the UAV) concerned, and why in words."""

    cus: tuple[int, ...]
    uav: int | None
    why: str

    @property
    def where(self) -> str:
        """Who is concerned, such as ``CU 0 and CU 1, UAV 2``."""
        at = " and ".join(f"CU {w}" for w in self.cus)
        return at if self.uav is None else f"{at}, UAV {self.uav}"


def lemma_1(uav: ObservedUav) -> list[Broken]:
    """A tracker that is not deprecated contains the trajectory that its UAV follows."""
    return [
        Broken((w,), None, "its tracker is not deprecated and does not hold the trajectory that the UAV follows")
        for w, (_, tracker, _) in enumerate(uav.at_cus)
        if not tracker.deprecated and uav.followed not in tracker.entries
    ]


def lemma_2(uav: ObservedUav) -> list[Broken]:
    """Two trackers of one UAV, on two CUs, neither deprecated, are equal."""
    valid = [(w, tracker.entries) for w, (_, tracker, _) in enumerate(uav.at_cus) if not tracker.deprecated]
    return [
        Broken((v, w), None, "neither tracker is deprecated, and they differ")
        for (v, at_v), (w, at_w) in combinations(valid, 2)
        if at_v != at_w
    ]


def plans_from_truth(uav: ObservedUav) -> list[Broken]:
    """Where a CU may plan a UAV, the one entry of its tracker is the trajectory that the UAV follows."""
    return [
        Broken((w,), None, "it may plan the UAV, from a trajectory that the UAV does not follow")
        for w, (_, tracker, may_plan) in enumerate(uav.at_cus)
        if may_plan and tracker.entries != {uav.followed}
    ]


def one_planner_per_uav(swarm: ObservedSwarm) -> list[Broken]:
    """No two CUs plan the same UAV in one round."""
    return [
        Broken((v, w), uav, "both plan the UAV in this round")
        for (v, at_v), (w, at_w) in combinations(enumerate(swarm.cus), 2)
        for uav in sorted(at_v.may_plan & at_w.may_plan)
    ]


def same_selection(swarm: ObservedSwarm) -> list[Broken]:
    """All CUs in RUN_DMPC compute the same set A_ET(k)."""
    selections = [(w, cu.selection) for w, cu in enumerate(swarm.cus) if cu.state == RUN_DMPC]
    return [
        Broken((v, w), None, f"they select {_names(at_v)} and {_names(at_w)}")
        for (v, at_v), (w, at_w) in combinations(selections, 2)
        if at_v != at_w
    ]


def valid_trackers(swarm: ObservedSwarm) -> int:
    """Return how many trackers are not deprecated: what Lemma 1 is about."""
    return sum(not tracker.deprecated for cu in swarm.cus for tracker in cu.trackers)


def valid_pairs(swarm: ObservedSwarm) -> int:
    """Return how many pairs of trackers of one UAV, on two CUs, are not deprecated: what Lemma 2 is about."""
    valid = [sum(not cu.trackers[i].deprecated for cu in swarm.cus) for i in range(len(swarm.followed))]
    return sum(number * (number - 1) // 2 for number in valid)


def may_plans(swarm: ObservedSwarm) -> int:
    """Return how many (CU, UAV) there are of which the CU may plan the UAV."""
    return sum(len(cu.may_plan) for cu in swarm.cus)


def running_pairs(swarm: ObservedSwarm) -> int:
    """Return how many pairs of CUs are in RUN_DMPC."""
    running = sum(cu.state == RUN_DMPC for cu in swarm.cus)
    return running * (running - 1) // 2


def _names(selection: frozenset[int] | None) -> str:
    return "{" + ", ".join(f"UAV {i}" for i in sorted(selection or ())) + "}"


def all_running(swarm: ObservedSwarm) -> bool:
    """Say whether every CU is in RUN_DMPC."""
    return all(cu.state == RUN_DMPC for cu in swarm.cus)


def all_plan(swarm: ObservedSwarm) -> bool:
    """Say whether all CUs are in RUN_DMPC and min(N, M) of them plan (under a free trigger: can plan) some UAV.

    A CU whose trigger leaves it a choice counts only if the CUs can choose pairwise different UAVs.
    """
    if not all_running(swarm):
        return False
    if all(cu.selection is not None for cu in swarm.cus):
        planners = sum(1 for cu in swarm.cus if cu.may_plan)
    else:
        planners = _most_pairwise_different(swarm.cus, frozenset())
    return planners >= min(len(swarm.followed), len(swarm.cus))


def _most_pairwise_different(cus: Sequence[ObservedCu], taken: frozenset[int]) -> int:
    if not cus:
        return 0
    first, rest = cus[0], cus[1:]
    best = _most_pairwise_different(rest, taken)
    for uav in first.may_plan - taken:
        best = max(best, 1 + _most_pairwise_different(rest, taken | {uav}))
    return best
