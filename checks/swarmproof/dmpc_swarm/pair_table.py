"""The table of pairs: for any two trajectories that can be flown in round k + 1, the lemma that covers them."""

from __future__ import annotations

from dataclasses import dataclass

from swarmproof.claims.proof import ProofVerdict
from swarmproof.dmpc_swarm.evidence.book import audit
from swarmproof.dmpc_swarm.proofs.pairs import PAIRS
from swarmproof.dmpc_swarm.proofs.registry import select_proof_claims
from swarmproof.dmpc_swarm.proofs.terms.cells import Cell, Lemma, cells
from swarmproof.dmpc_swarm.proofs.terms.separation import EQ_20
from swarmproof.prove.decide import Answer

#: What the verdict of a cell can be, beside those of a claim.
UNDER_20 = f"true under {EQ_20}"
_HYPOTHESES = {Lemma.COROLLARY_1: "(13f) for both", Lemma.LEMMA_3: "(13f) for i", Lemma.LEMMA_4: "(18)", None: "none"}


@dataclass(frozen=True, slots=True)
class CellAudit:
    """One cell of the table, decided.

    Attributes:
        stated: the answer if only what the covering lemma states is assumed.
        with_20: the answer if (20) is assumed at the sample, too.
    """

    cell: Cell
    stated: Answer
    with_20: Answer

    @property
    def hypotheses(self) -> str:
        """What the covering lemma states."""
        return _HYPOTHESES[self.cell.lemma]

    @property
    def verdict(self) -> str:
        """``proved``, ``true under (20)``, ``false`` or ``not decided``."""
        if self.stated.verdict is ProofVerdict.PROVED:
            return ProofVerdict.PROVED
        decided = self.stated.verdict is ProofVerdict.FALSE
        if decided and self.with_20.verdict is ProofVerdict.PROVED:
            return UNDER_20
        return self.with_20.verdict if decided else ProofVerdict.UNDECIDED


def audit_cells() -> list[CellAudit]:
    """Decide every cell of the table."""
    printed, repaired = (
        {answer.question: answer for answer in audited.answers} for audited in audit(select_proof_claims([PAIRS]))
    )
    return [CellAudit(cell, printed[cell.id], repaired[cell.id]) for cell in cells()]
