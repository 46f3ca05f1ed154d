"""The claims about MLR-DMPC: id, wording, place in the paper, assumptions, predicate.

They are read in the computation phase, after Algorithm 2 and Alg. 1 lines 8-11, on every reachable state.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from swarmproof.claims.claim import Always, Claim, Reachable, Recovers
from swarmproof.dmpc_swarm.claims import predicates
from swarmproof.dmpc_swarm.claims.observed import ObservedSwarm, ObservedUav
from swarmproof.dmpc_swarm.claims.predicates import Broken


@dataclass(frozen=True)
class OfOneUav:
    """A predicate about one UAV, as one about UAV i of a swarm."""

    predicate: Callable[[ObservedUav], list[Broken]]

    def __call__(self, swarm: ObservedSwarm, i: int) -> list[Broken]:
        """Return where it is broken for UAV i."""
        return [broken._replace(uav=i) for broken in self.predicate(swarm.of_uav(i))]


@dataclass(frozen=True)
class OfEachUav:
    """A predicate about one UAV, said of all UAVs of a swarm."""

    of_one: OfOneUav

    def __call__(self, swarm: ObservedSwarm) -> list[Broken]:
        """Return where it is broken, UAV by UAV."""
        return [broken for i in range(len(swarm.followed)) for broken in self.of_one(swarm, i)]


def per_uav(predicate: Callable[[ObservedUav], list[Broken]]) -> Always[ObservedSwarm]:
    """Return the question whether `predicate` is broken for no UAV."""
    of_one = OfOneUav(predicate)
    return Always(OfEachUav(of_one), of_one)


_ANY_LOSS = "Any (message, receiver) pair may be lost, independently, in every round, for ever."

ProtocolClaim = Claim[ObservedSwarm]

CLAIMS: tuple[ProtocolClaim, ...] = (
    Claim(
        "lemma-1",
        "A tracker that is not deprecated contains the trajectory that its UAV follows.",
        "Lemma 1, Section 4.3.1",
        _ANY_LOSS,
        per_uav(predicates.lemma_1),
        about=predicates.valid_trackers,
        nothing="every tracker was deprecated, after every round",
    ),
    Claim(
        "lemma-2",
        "Two trackers of one UAV, on two CUs, neither deprecated, are equal.",
        "Lemma 2, Section 4.3.1",
        _ANY_LOSS,
        per_uav(predicates.lemma_2),
        about=predicates.valid_pairs,
        nothing="no two CUs had trackers of one UAV that were not deprecated, after any round",
        least={"cus": 2},
    ),
    Claim(
        "plans-from-truth",
        "Where a CU in RUN_DMPC may plan a UAV, the one entry of its tracker is the trajectory that the UAV follows.",
        "Algorithm 1 line 17; Section 4.2.3: the initial state is the sole entry of the tracker",
        _ANY_LOSS,
        per_uav(predicates.plans_from_truth),
        about=predicates.may_plans,
        nothing="no CU could plan a UAV, after any round",
    ),
    Claim(
        "one-planner-per-uav",
        "No two CUs plan the same UAV in one round.",
        "Section 4.2.2: each CU selects another position of A_ET(k)",
        _ANY_LOSS + " Round-robin trigger of Appendix A.1.",
        Always(predicates.one_planner_per_uav),
        asked_under={"event_trigger": "round-robin"},
        speaks_of="the selection of event_trigger=round-robin",
        about=predicates.running_pairs,
        nothing="no two CUs were in RUN_DMPC, after any round",
        least={"cus": 2},
    ),
    Claim(
        "same-selection",
        "All CUs in RUN_DMPC compute the same set A_ET(k).",
        "Section 4.2.2: since all active CUs receive the same priorities, they compute the same set",
        _ANY_LOSS + " Round-robin trigger of Appendix A.1.",
        Always(predicates.same_selection),
        asked_under={"event_trigger": "round-robin"},
        speaks_of="the selection of event_trigger=round-robin",
        about=predicates.running_pairs,
        nothing="no two CUs were in RUN_DMPC, after any round",
        least={"cus": 2},
    ),
    Claim(
        "recovery",
        "From every reachable state, once nothing is lost any more, every CU reaches RUN_DMPC and all stay there, "
        "whatever the remaining choices.",
        "Section 3.3 and Algorithm 1 lines 22-32: MLR requests what is missing and returns to DMPC",
        "Any losses up to some round, none after it; trigger, conflict outcomes and request order stay free.",
        Recovers(predicates.all_running, "all CUs running", "some CU does not run"),
    ),
    Claim(
        "can-plan",
        "A state is reachable in which all CUs are in RUN_DMPC and min(N, M) of them plan.",
        "Section 3.2: in each round, the CUs compute new trajectories for M of the N UAVs",
        "None.",
        Reachable(predicates.all_plan),
    ),
)


def elsewhere(name: str) -> str:
    """Return, to end a sentence with, where the claim `name` is decided if it is none of these; empty if nowhere."""
    from swarmproof.dmpc_swarm.proofs.registry import is_proof_claim  # which no verdict needs, and takes long

    return f"; it is one of the proofs: swarmproof audit --claim {name}" if is_proof_claim(name) else ""
