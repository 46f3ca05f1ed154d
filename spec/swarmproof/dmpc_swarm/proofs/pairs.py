"""Claims about all pairs of trajectories that can be flown in round k + 1, and about slips of indices."""

from __future__ import annotations

from swarmproof.algebra.statement import Condition, Sign, Solvable, Statement, above
from swarmproof.claims.proof import ProofClaim, ProofVerdict, Reading
from swarmproof.dmpc_swarm.proofs.terms.cells import Lemma, cells
from swarmproof.dmpc_swarm.proofs.terms.separation import ASSUME_20, D_POSITIVE, I_OLD, J_OLD, D, apart, both_old

#: The claim that the table of pairs is read from, in both readings.
PAIRS = "pairs"

_PLACE = "Proof of Theorem 1: “Corollary 1, Lemma 3 and 4 then lead to equation (21)”"
_SAMES = "At one sample. The CUs have the same trackers and the same A_ET(k), and n_ij ≠ 0."
_POSITIVE = above(D_POSITIVE, D)
_NAMES = tuple(name for entry in I_OLD for name in entry.variables)


def _strict() -> Statement:
    conclusion = Condition("(23)", (J_OLD - I_OLD).square - D**2, Sign.ABOVE)
    return Statement((_POSITIVE, ASSUME_20), conclusion)


CLAIMS: tuple[ProofClaim, ...] = (
    ProofClaim(
        PAIRS,
        Reading.PRINTED,
        "Any two trajectories of different UAVs that can be flown in round k+1 are d̂_min apart, by what Corollary 1, "
        "Lemma 3 and Lemma 4 assume.",
        _PLACE,
        f"{_SAMES} (13f) for new trajectories; (18) for two UAVs that were not planned.",
        {cell.id: cell.statement(assume_20=cell.lemma is Lemma.LEMMA_4) for cell in cells()},
        ProofVerdict.FALSE,
        "No lemma covers a planned UAV that missed its new trajectory, beside any other; and Lemma 3 is false for a "
        "UAV j that is selected and not planned. In all of these, (20) is needed.",
    ),
    ProofClaim(
        PAIRS,
        Reading.REPAIRED,
        "Any two trajectories of different UAVs that can be flown in round k+1 are d̂_min apart, if (13f) is satisfied "
        "by new trajectories and (20) by old ones.",
        _PLACE,
        f"{_SAMES} (13f) for new trajectories, (20) for the entries of D(k).",
        {cell.id: cell.statement(assume_20=True) for cell in cells()},
        ProofVerdict.PROVED,
        "With (20) at the sample, the three statements are one: every pair is separated.",
    ),
    ProofClaim(
        "index-slips",
        Reading.PRINTED,
        "Lemma 4 and eqs. (21), (23) as their indices stand.",
        "Lemma 4: p̃_i ∈ D_j(k); eq. (21): p̃_j ∈ D_i(k+1); eq. (23): p̂_i − p̂_i",
        "Literal reading.",
        {
            "(18) can be met": Solvable((_POSITIVE,), _NAMES, (apart("(18)", I_OLD, I_OLD),)),
            "(21)": Statement((_POSITIVE, ASSUME_20), apart("(21)", I_OLD, I_OLD)),
        },
        ProofVerdict.FALSE,
        "A trajectory would have to be d̂_min apart from itself: (18) is never true, (21) and (23) always false.",
    ),
    ProofClaim(
        "index-slips",
        Reading.REPAIRED,
        "Lemma 4 and eq. (21) with p̃_i ∈ D_i and p̃_j ∈ D_j, at a sample at which (18) is assumed.",
        "Lemma 4; eq. (21)",
        "UAVs i and j are different.",
        {"(21)": both_old(assume_20=True)},
        ProofVerdict.PROVED,
        "So they are read everywhere else.",
    ),
    ProofClaim(
        "theorem-2-strict",
        Reading.PRINTED,
        "References are more than d̂_min apart, as eq. (23) has it (>).",
        "eq. (23)",
        "(20): at least d̂_min.",
        {"(23)": _strict()},
        ProofVerdict.FALSE,
        "UAVs that hover exactly d̂_min apart satisfy all that is assumed.",
    ),
    ProofClaim(
        "theorem-2-strict",
        Reading.REPAIRED,
        "References are at least d̂_min apart (≥ in eq. 23).",
        "eq. (23)",
        "(20).",
        {"(23)": both_old(assume_20=True)},
        ProofVerdict.PROVED,
        "As (21) says.",
    ),
)
