"""All evidence on file, by claim and question. Steps on the sample grid have none: they are decided by themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from swarmproof.claims.proof import ProofClaim
from swarmproof.dmpc_swarm.evidence import bounds, feasibility, rest, separation, tolerance
from swarmproof.prove.decide import Audited, decide
from swarmproof.prove.evidence import Evidence

EVIDENCE: Mapping[str, Mapping[str, Evidence]] = {
    **separation.EVIDENCE,
    **feasibility.EVIDENCE,
    **rest.EVIDENCE,
    **bounds.EVIDENCE,
    **tolerance.EVIDENCE,
}


def audit(claims: Sequence[ProofClaim]) -> list[Audited]:
    """Decide every claim from the evidence on file."""
    return [decide(claim, EVIDENCE.get(claim.key, {})) for claim in claims]
