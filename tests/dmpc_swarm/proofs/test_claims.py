"""The claims about the proofs: every verdict on record is reached, and only for the reading that it is about."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.dmpc_swarm.proofs.filed import audited

from swarmproof.algebra.grid import Step
from swarmproof.claims.proof import ProofClaim, ProofVerdict, Reading
from swarmproof.dmpc_swarm.evidence.book import EVIDENCE
from swarmproof.dmpc_swarm.proofs.registry import PROOF_CLAIMS, select_proof_claims
from swarmproof.errors import BadInput
from swarmproof.prove.decide import decide

BY_KEY = {claim.key: claim for claim in PROOF_CLAIMS}
BOTH_READINGS = sorted({claim.id for claim in PROOF_CLAIMS if {f"{claim.id}/{r}" for r in Reading} <= BY_KEY.keys()})


@pytest.mark.parametrize("claim", PROOF_CLAIMS, ids=lambda claim: claim.key)
def test_every_claim_has_the_verdict_on_record(claim: ProofClaim) -> None:
    """The evidence on file decides each claim, and as recorded; none is left undecided."""
    audited = decide(claim, EVIDENCE.get(claim.key, {}))
    assert [(answer.question, answer.why) for answer in audited.answers if answer.why] == []
    assert audited.verdict is claim.verdict
    assert audited.as_recorded


def test_keys_are_unique() -> None:
    """No two claims have the same id and reading."""
    assert len(BY_KEY) == len(PROOF_CLAIMS)


def test_no_evidence_is_left_over() -> None:
    """All evidence on file is about a question of a claim."""
    assert [key for key in EVIDENCE if key not in BY_KEY] == []
    assert [(key, name) for key, shown in EVIDENCE.items() for name in shown if name not in BY_KEY[key].questions] == []


@pytest.mark.parametrize("name", BOTH_READINGS)
def test_a_repaired_statement_changed_back_is_not_proved(name: str) -> None:
    """With the printed statement in place of the repaired one, the repaired one's evidence proves nothing."""
    printed, repaired = BY_KEY[f"{name}/printed"], BY_KEY[f"{name}/repaired"]
    if printed.verdict is ProofVerdict.PROVED:
        pytest.skip("the printed statement is true")
    shown = EVIDENCE.get(repaired.key, {})
    refuted = [
        each for each in decide(printed, EVIDENCE.get(printed.key, {})).answers if each.verdict is ProofVerdict.FALSE
    ]
    assert refuted
    for each in refuted:
        changed_back = replace(repaired, questions=dict.fromkeys(repaired.questions, each.asked))
        assert decide(changed_back, shown).verdict is not ProofVerdict.PROVED


@pytest.mark.parametrize("name", BOTH_READINGS)
def test_a_printed_statement_that_is_repaired_is_not_false(name: str) -> None:
    """With the repaired statement in place of the printed one, the printed one's counterexamples refute nothing."""
    printed, repaired = BY_KEY[f"{name}/printed"], BY_KEY[f"{name}/repaired"]
    for asked in repaired.questions.values():
        if isinstance(asked, Step):
            continue
        changed = replace(printed, questions=dict.fromkeys(printed.questions, asked))
        assert decide(changed, EVIDENCE[printed.key]).verdict is not ProofVerdict.FALSE


def test_a_changed_verdict_is_noticed() -> None:
    """A claim whose verdict is not the one on record says so."""
    claim = replace(BY_KEY["lemma-3/printed"], verdict=ProofVerdict.PROVED)
    assert not decide(claim, EVIDENCE[claim.key]).as_recorded


def test_without_evidence_nothing_is_decided() -> None:
    """A claim without evidence is neither proved nor false."""
    assert decide(BY_KEY["corollary-1/printed"], {}).verdict is ProofVerdict.UNDECIDED


def test_evidence_of_the_wrong_sort_decides_nothing() -> None:
    """A certificate is no evidence about a problem, nor a choice of unknowns about a statement."""
    certificate = EVIDENCE["corollary-1/printed"]["both new"]
    candidate = EVIDENCE["lemma-3-condition/repaired"]["any distance below d"]
    assert decide(BY_KEY["lemma-3-condition/repaired"], {"any distance below d": certificate}).answers[0].why
    assert decide(BY_KEY["corollary-1/printed"], {"both new": candidate}).answers[0].why


def test_claims_are_selected_by_id_and_by_key() -> None:
    """An id selects both readings, a key one; the order is the registry's."""
    assert [claim.key for claim in select_proof_claims(["lemma-3"])] == ["lemma-3/printed", "lemma-3/repaired"]
    assert [claim.key for claim in select_proof_claims(["lemma-3/repaired"])] == ["lemma-3/repaired"]
    assert select_proof_claims([]) == PROOF_CLAIMS
    with pytest.raises(BadInput, match="no claim 'lemma-9'"):
        select_proof_claims(["lemma-9"])


def test_all_claims_are_audited() -> None:
    """An audit has one entry for each claim, in order."""
    assert [each.claim for each in audited()] == list(PROOF_CLAIMS)
