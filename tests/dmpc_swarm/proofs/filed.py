"""All questions of the audit with the evidence on file, by name; nothing is checked when it is imported."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from swarmproof.algebra.grid import Step
from swarmproof.claims.proof import Question
from swarmproof.dmpc_swarm.evidence.book import EVIDENCE, audit
from swarmproof.dmpc_swarm.proofs.registry import PROOF_CLAIMS
from swarmproof.prove.decide import Answer, Audited, Shown
from swarmproof.prove.evidence import Unsolvable, Vectors
from swarmproof.prove.steps import Line, decide_step


class Filed(NamedTuple):
    """A question and the evidence about it; None if there is none."""

    asked: Question
    evidence: Shown | None

    @property
    def refutes(self) -> bool:
        """Whether the evidence is of a kind that refutes."""
        return isinstance(self.evidence, Vectors | Unsolvable | Line)


FILED: dict[str, Filed] = {
    f"{claim.key}: {name}": Filed(
        asked, decide_step(asked) if isinstance(asked, Step) else EVIDENCE.get(claim.key, {}).get(name)
    )
    for claim in PROOF_CLAIMS
    for name, asked in claim.questions.items()
}


@cache
def audited() -> tuple[Audited, ...]:
    """Return the audit of all claims: decided once in a process, and only if a test asks."""
    return tuple(audit(PROOF_CLAIMS))


@cache
def answers() -> dict[str, Answer]:
    """Return every answer of the audit, by the same names."""
    return {f"{each.claim.key}: {one.question}": one for each in audited() for one in each.answers}
