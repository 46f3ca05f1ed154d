"""`swarmproof audit`: exit codes, what is printed, JSON, and advice for those who look elsewhere."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from swarmproof.claims.proof import ProofVerdict
from swarmproof.cli import main
from swarmproof.commands import audit as command
from swarmproof.dmpc_swarm.evidence.book import audit
from swarmproof.dmpc_swarm.proofs.registry import PROOF_CLAIMS, select_proof_claims
from swarmproof.dmpc_swarm.proofs.terms.cells import cells
from swarmproof.prove.decide import Audited


def test_everything_is_decided_as_recorded(capsys: pytest.CaptureFixture[str]) -> None:
    """Without options every claim and every cell is printed, and the exit code is 0."""
    assert main(["audit"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert all(f" {claim.id} " in printed for claim in PROOF_CLAIMS)
    assert all(f" {cell.i.id} {cell.j.id} {cell.lemma or 'none'} " in printed for cell in cells())
    assert "Every verdict is the one on record." in printed


def test_a_claim_is_shown_with_its_evidence(capsys: pytest.CaptureFixture[str]) -> None:
    """A claim that is asked for comes with the script of its counterexample and the identity of its proof."""
    assert main(["audit", "--claim", "lemma-3/printed"]) == 0
    printed = capsys.readouterr().out
    assert "lemma-3/printed: false" in printed
    assert "j_old_x = F(1, 2); i_new_x = F(-1, 4)" in printed
    assert "[n_ij is not zero]*[n_ij is not zero]*[(17)]" in printed
    assert "lemma-3/repaired" not in printed
    assert "Corollary 1" not in printed


@pytest.mark.parametrize(
    ("verdict", "code"), [(ProofVerdict.PROVED, 1), (ProofVerdict.FALSE, 1), (ProofVerdict.UNDECIDED, 3)]
)
def test_a_changed_verdict_is_an_error(
    verdict: ProofVerdict, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The exit code is 1 if a verdict is not the one on record, 3 if one is not decided; the claim is named."""
    claims = select_proof_claims(["lemma-3"])
    wrong = {each.claim.key: each for each in audit(claims) if each.verdict is not verdict}

    def altered(_: object) -> list[Audited]:
        return [replace(wrong[each.claim.key], verdict=verdict) for each in audit(claims) if each.claim.key in wrong]

    monkeypatch.setattr(command, "audit", altered)
    assert main(["audit", "--claim", "lemma-3"]) == code
    printed = capsys.readouterr().out
    assert "Not as recorded: lemma-3/" in printed
    assert "(on record: " in printed


def test_json_goes_to_standard_output_alone(capsys: pytest.CaptureFixture[str]) -> None:
    """With `--json -` standard output has the document only: each claim with its questions, and the table."""
    assert main(["audit", "--claim", "pairs", "--claim", "next-round", "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "swarmproof.audit/1"
    assert [(each["id"], each["reading"], each["verdict"]) for each in document["claims"]] == [
        ("pairs", "printed", "false"),
        ("pairs", "repaired", "proved"),
        ("next-round", "printed", "false"),
        ("next-round", "repaired", "proved"),
    ]
    assert len(document["pairs"]) == 21
    for claim in document["claims"]:
        for question in claim["questions"]:
            assert (question["script"] is not None) == (question["verdict"] == "false")


def test_the_report_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`--report` writes one page and says where."""
    assert main(["audit", "--claim", "lemma-3", "--report", str(tmp_path / "audit")]) == 0
    assert "lemma-3" in (tmp_path / "audit" / "index.html").read_text(encoding="utf-8")
    assert "index.html" in capsys.readouterr().out


def test_bad_input_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A claim that does not exist, or a folder that cannot be, is told in one line with exit code 2."""
    (tmp_path / "file").write_text("")
    for options in (
        ["--claim", "lemma-9"],
        ["--report", str(tmp_path / "file")],
        ["--json", str(tmp_path / "file" / "b")],
    ):
        assert main(["audit", "--claim", "lemma-3", *options]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_verify_says_where_the_proofs_are(capsys: pytest.CaptureFixture[str]) -> None:
    """Whoever asks `verify` for a claim about the proofs is told the right command."""
    assert main(["verify", "--claim", "next-round"]) == 2
    assert "swarmproof audit --claim next-round" in capsys.readouterr().err


def test_claims_lists_the_proofs(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """`swarmproof claims` shows each claim about the proofs beside the protocol's, with reading and verdict."""
    monkeypatch.setenv("COLUMNS", "240")
    assert main(["claims"]) == 0
    printed = capsys.readouterr().out
    assert "lemma-1" in printed
    assert all(claim.id in printed for claim in PROOF_CLAIMS)
