"""All evidence on file, by claim and question. Steps on the sample grid have none: they are decided by themselves."""

from __future__ import annotations

from collections.abc import Mapping

from swarmproof.audit.evidence import Evidence
from swarmproof.audit.proofs import bounds, feasibility, rest, separation, tolerance

EVIDENCE: Mapping[str, Mapping[str, Evidence]] = {
    **separation.EVIDENCE,
    **feasibility.EVIDENCE,
    **rest.EVIDENCE,
    **bounds.EVIDENCE,
    **tolerance.EVIDENCE,
}
