"""All claims about the proofs."""
from swarmproof.claims.proofs import separation
from swarmproof.statements.claim import ProofClaim

PROOF_CLAIMS: tuple[ProofClaim, ...] = (*separation.CLAIMS,)
