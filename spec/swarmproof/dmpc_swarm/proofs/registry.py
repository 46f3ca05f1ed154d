"""All claims about the proofs: one sample, all pairs, the sample grid, trajectories, bounds, and tolerance."""

from __future__ import annotations

from collections.abc import Sequence

from swarmproof.claims.proof import ProofClaim
from swarmproof.dmpc_swarm.proofs import bounds, feasibility, pairs, rest, samples, separation, tolerance
from swarmproof.errors import BadInput

PROOF_CLAIMS: tuple[ProofClaim, ...] = (
    *separation.CLAIMS,
    *pairs.CLAIMS,
    *samples.CLAIMS,
    *feasibility.CLAIMS,
    *rest.CLAIMS,
    *bounds.CLAIMS,
    *tolerance.CLAIMS,
)


def is_proof_claim(name: str) -> bool:
    """Say whether `name` is the id or the key of a claim about the proofs."""
    return any(name in (claim.id, claim.key) for claim in PROOF_CLAIMS)


def select_proof_claims(ids: Sequence[str]) -> tuple[ProofClaim, ...]:
    """Return the claims with these ids (``lemma-3``: both readings) or keys (``lemma-3/printed``), in order.

    All claims if `ids` is empty.

    Raises:
        BadInput: there is no such claim.
    """
    for name in ids:
        if not is_proof_claim(name):
            known = ", ".join(dict.fromkeys(claim.id for claim in PROOF_CLAIMS))
            raise BadInput(
                f"the proofs have no claim {name!r}: choose among {known}, or one reading, as in lemma-3/printed"
            )
    return tuple(claim for claim in PROOF_CLAIMS if not ids or claim.id in ids or claim.key in ids)
