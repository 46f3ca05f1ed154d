"""The claims about MLR-DMPC: id, wording, place in the paper, assumptions, predicate.

They are read in the computation phase, after Algorithm 2 and Alg. 1 lines 8-11, on every reachable state.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

from swarmproof.dmpc_swarm.claims import predicates
from swarmproof.dmpc_swarm.claims.observed import ObservedSwarm, ObservedUav
from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.errors import BadInput


class Kind(Enum):
    """What a claim says about the reachable states, and so how it is decided."""

    #: The predicate is true in every reachable state.
    SAFETY = "safety"
    #: A state is reachable in which the predicate is true.
    REACHABLE = "reachable"
    #: From every reachable state the predicate becomes and stays true once nothing is lost.
    RECOVERY = "recovery"


@dataclass(frozen=True)
class Claim:
    """One statement about the protocol.

    Exactly one of the predicates is set: `per_uav` and `whole` return the broken places of a safety claim (`per_uav`
    sees one UAV at a time, the claim says it of all), `goal` is what a RECOVERY or REACHABLE claim wants reached.

    Attributes:
        about: of a safety claim, in how many places of a swarm there is something that it speaks of.
        nothing: what there is not, where that is none: then it is true, but says nothing.
        least_cus: with fewer CUs there never is.
    """

    id: str
    kind: Kind
    wording: str
    place: str
    assumptions: str
    per_uav: Callable[[ObservedUav], list[Broken]] | None = None
    whole: Callable[[ObservedSwarm], list[Broken]] | None = None
    goal: Callable[[ObservedSwarm], bool] | None = None
    needs_selection: bool = False
    about: Callable[[ObservedSwarm], int] | None = None
    nothing: str = ""
    least_cus: int = 1

    def applies_to(self, semantics: Semantics) -> bool:
        """Say whether the claim can be asked under these semantics."""
        return not self.needs_selection or semantics.event_trigger == "round-robin"

    def broken_in(self, swarm: ObservedSwarm) -> list[Broken]:
        """Return where this safety claim is false in `swarm`; empty if it is true, or no safety claim."""
        if self.per_uav is not None:
            return [
                broken._replace(uav=i) for i in range(len(swarm.followed)) for broken in self.per_uav(swarm.of_uav(i))
            ]
        return [] if self.whole is None else self.whole(swarm)


_ANY_LOSS = "Any (message, receiver) pair may be lost, independently, in every round, for ever."

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "lemma-1",
        Kind.SAFETY,
        "A tracker that is not deprecated contains the trajectory that its UAV follows.",
        "Lemma 1, Section 4.3.1",
        _ANY_LOSS,
        per_uav=predicates.lemma_1,
        about=predicates.valid_trackers,
        nothing="every tracker was deprecated, after every round",
    ),
    Claim(
        "lemma-2",
        Kind.SAFETY,
        "Two trackers of one UAV, on two CUs, neither deprecated, are equal.",
        "Lemma 2, Section 4.3.1",
        _ANY_LOSS,
        per_uav=predicates.lemma_2,
        about=predicates.valid_pairs,
        nothing="no two CUs had trackers of one UAV that were not deprecated, after any round",
        least_cus=2,
    ),
    Claim(
        "plans-from-truth",
        Kind.SAFETY,
        "Where a CU in RUN_DMPC may plan a UAV, the one entry of its tracker is the trajectory that the UAV follows.",
        "Algorithm 1 line 17; Section 4.2.3: the initial state is the sole entry of the tracker",
        _ANY_LOSS,
        per_uav=predicates.plans_from_truth,
        about=predicates.may_plans,
        nothing="no CU could plan a UAV, after any round",
    ),
    Claim(
        "one-planner-per-uav",
        Kind.SAFETY,
        "No two CUs plan the same UAV in one round.",
        "Section 4.2.2: each CU selects another position of A_ET(k)",
        _ANY_LOSS + " Round-robin trigger of Appendix A.1.",
        whole=predicates.one_planner_per_uav,
        needs_selection=True,
        about=predicates.running_pairs,
        nothing="no two CUs were in RUN_DMPC, after any round",
        least_cus=2,
    ),
    Claim(
        "same-selection",
        Kind.SAFETY,
        "All CUs in RUN_DMPC compute the same set A_ET(k).",
        "Section 4.2.2: since all active CUs receive the same priorities, they compute the same set",
        _ANY_LOSS + " Round-robin trigger of Appendix A.1.",
        whole=predicates.same_selection,
        needs_selection=True,
        about=predicates.running_pairs,
        nothing="no two CUs were in RUN_DMPC, after any round",
        least_cus=2,
    ),
    Claim(
        "recovery",
        Kind.RECOVERY,
        "From every reachable state, once nothing is lost any more, every CU reaches RUN_DMPC and all stay there, "
        "whatever the remaining choices.",
        "Section 3.3 and Algorithm 1 lines 22-32: MLR requests what is missing and returns to DMPC",
        "Any losses up to some round, none after it; trigger, conflict outcomes and request order stay free.",
        goal=predicates.all_running,
    ),
    Claim(
        "can-plan",
        Kind.REACHABLE,
        "A state is reachable in which all CUs are in RUN_DMPC and min(N, M) of them plan.",
        "Section 3.2: in each round, the CUs compute new trajectories for M of the N UAVs",
        "None.",
        goal=predicates.all_plan,
    ),
)


def select_claims(ids: Sequence[str] | None = None) -> tuple[Claim, ...]:
    """Return the claims with these ids, in the registry's order; all of them if `ids` is empty.

    Raises:
        BadInput: there is no claim of that id.
    """
    known = [claim.id for claim in CLAIMS]
    for name in ids or ():
        if name not in known:
            from swarmproof.dmpc_swarm.proofs.registry import is_proof_claim  # which no verdict needs, and takes long

            elsewhere = f"; it is one of the proofs: swarmproof audit --claim {name}" if is_proof_claim(name) else ""
            raise BadInput(f"there is no claim {name!r}: choose among {', '.join(known)}{elsewhere}")
    return tuple(claim for claim in CLAIMS if not ids or claim.id in ids)
