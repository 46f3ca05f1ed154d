"""A claim about the proofs of DMPC-Swarm: a statement in one reading, and the verdict that is on record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from swarmproof.algebra.grid import Step
from swarmproof.algebra.statement import Solvable, Statement

Question = Statement | Solvable | Step


class Reading(StrEnum):
    """Whose statement it is."""

    #: With the hypotheses and index ranges of the paper, slips that README's corrections remove aside.
    PRINTED = "printed"
    #: With what the printed one lacks.
    REPAIRED = "repaired"


class ProofVerdict(StrEnum):
    """What is known of a statement about all real numbers."""

    PROVED = "proved"
    FALSE = "false"
    UNDECIDED = "not decided"


@dataclass(frozen=True)
class ProofClaim:
    """One statement of the proofs, or one hypothesis that they use, in one reading.

    Attributes:
        id: the same for both readings.
        wording: the statement, in words; what a repaired one changes is in it.
        place: in the paper.
        assumptions: its hypotheses, in words.
        questions: by name, what must be true: the claim is proved if all are, false if one is false.
        verdict: on record; the audit decides anew and must come to the same.
        finding: what the verdict means for the reader of the paper, in a sentence.
    """

    id: str
    reading: Reading
    wording: str
    place: str
    assumptions: str
    questions: Mapping[str, Question]
    verdict: ProofVerdict
    finding: str

    @property
    def key(self) -> str:
        """What names this claim among all: ``id/reading``."""
        return f"{self.id}/{self.reading}"
