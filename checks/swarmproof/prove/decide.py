"""Decides claims about the proofs: what the evidence on file shows, after it has been checked exactly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from swarmproof.algebra.grid import Step
from swarmproof.algebra.statement import Solvable, Statement
from swarmproof.claims.proof import ProofClaim, ProofVerdict, Question
from swarmproof.prove.evidence import Candidate, Certificate, Unsolvable, Vectors
from swarmproof.prove.steps import Covered, Line, decide_step

Shown = Certificate | Vectors | Candidate | Unsolvable | Covered | Line


@dataclass(frozen=True, slots=True)
class Answer:
    """What is known of one question; `why` says what is missing if it is not decided."""

    question: str
    asked: Question
    verdict: ProofVerdict
    evidence: Shown | None
    why: str = ""


@dataclass(frozen=True, slots=True)
class Audited:
    """A claim and the answers to its questions."""

    claim: ProofClaim
    verdict: ProofVerdict
    answers: tuple[Answer, ...]

    @property
    def as_recorded(self) -> bool:
        """Whether the verdict is the one on record."""
        return self.verdict is self.claim.verdict


def decide(claim: ProofClaim, evidence: Mapping[str, Shown]) -> Audited:
    """Decide one claim: proved if all its questions are, false if one is false."""
    answers = tuple(answer(name, asked, evidence.get(name)) for name, asked in claim.questions.items())
    verdicts = {each.verdict for each in answers}
    if ProofVerdict.FALSE in verdicts:
        verdict = ProofVerdict.FALSE
    else:
        verdict = ProofVerdict.PROVED if verdicts == {ProofVerdict.PROVED} else ProofVerdict.UNDECIDED
    return Audited(claim, verdict, answers)


def answer(name: str, asked: Question, evidence: Shown | None) -> Answer:
    """Decide one question: evidence that does not fit it, or has a fault, decides nothing."""
    if isinstance(asked, Step):
        evidence = decide_step(asked)
    if evidence is None:
        return Answer(name, asked, ProofVerdict.UNDECIDED, None, "there is neither a proof nor a counterexample")
    proves, fault = _check(asked, evidence)
    if fault is not None:
        return Answer(name, asked, ProofVerdict.UNDECIDED, evidence, f"the evidence on file does not check: {fault}")
    return Answer(name, asked, ProofVerdict.PROVED if proves else ProofVerdict.FALSE, evidence)


def _check(asked: Question, evidence: Shown) -> tuple[bool, str | None]:
    """Return whether the evidence is for the statement, and its fault."""
    match asked, evidence:
        case Statement(), Certificate():
            return True, evidence.fault(asked)
        case Statement(), Vectors():
            return False, evidence.fault(asked)
        case Solvable(), Candidate():
            return True, evidence.fault(asked)
        case Solvable(), Unsolvable():
            return False, evidence.fault(asked)
        case Step(), Covered():
            return True, evidence.fault(asked)
        case Step(), Line():
            return False, evidence.fault(asked)
        case _:
            return False, f"{type(evidence).__name__} is no evidence about a {type(asked).__name__}"
