"""The audit of the proofs in words and as JSON, `swarmproof.audit/1`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from textwrap import indent

from swarmproof.algebra.statement import Statement
from swarmproof.dmpc_swarm.pair_table import CellAudit
from swarmproof.prove.decide import Answer, Audited, Shown
from swarmproof.prove.evidence import Candidate, Certificate, Unsolvable, Vectors
from swarmproof.prove.script import identity, script
from swarmproof.prove.steps import Covered, Line

SCHEMA = "swarmproof.audit/1"


def evidence(audited: Audited) -> str:
    """Return a claim with what is known of its questions: a script for each that is false, else the proof."""
    claim = audited.claim
    lines = [f"{claim.key}: {audited.verdict}", f"  {claim.wording}", f"  {claim.place}. {claim.assumptions}", ""]
    for answer in audited.answers:
        lines += [f"  {answer.question}: {answer.verdict}", indent(shown(answer), "    "), ""]
    return "\n".join(lines)


def kind(shown: Shown | None) -> str:
    """Return in words what sort of evidence it is."""
    match shown:
        case Certificate():
            return "certificate"
        case Candidate():
            return "candidate"
        case Vectors():
            return "counterexample"
        case Unsolvable():
            return "infeasible example"
        case Covered():
            return "cover of the samples"
        case Line():
            return "counterexample on a line"
    return "none"


def document(audited: Sequence[Audited], pairs: Sequence[CellAudit]) -> str:
    """Return the verdicts as an indented JSON document."""
    content = {
        "schema": SCHEMA,
        "claims": [
            {
                "id": each.claim.id,
                "reading": str(each.claim.reading),
                "verdict": str(each.verdict),
                "recorded": str(each.claim.verdict),
                "finding": each.claim.finding,
                "questions": [_answer(answer) for answer in each.answers],
            }
            for each in audited
        ],
        "pairs": [
            {
                "cell": each.cell.id,
                "i": each.cell.i.in_words(),
                "j": each.cell.j.in_words(),
                "lemma": each.cell.lemma,
                "assumes": each.hypotheses,
                "verdict": each.verdict,
            }
            for each in pairs
        ],
    }
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _answer(answer: Answer) -> dict[str, object]:
    refuted = isinstance(answer.evidence, Vectors | Unsolvable | Line)
    return {
        "question": answer.question,
        "verdict": str(answer.verdict),
        "evidence": kind(answer.evidence),
        "why": answer.why,
        "script": script(answer.asked, answer.evidence) if refuted and answer.evidence else None,
    }


def shown(answer: Answer) -> str:
    """Return the evidence for one question: what a reader can check."""
    match answer.evidence:
        case None:
            return answer.why
        case Certificate() as certificate if isinstance(answer.asked, Statement):
            return identity(answer.asked, certificate)
        case Candidate(choice):
            return "\n".join(["the choice", *(f"  {name} = {value}" for name, value in choice.items())])
        case Covered(names, at_rest):
            return f"covered by {', '.join(names)}{', then at rest' if at_rest else ''}, for every H"
        case found:
            return script(answer.asked, found) or answer.why
