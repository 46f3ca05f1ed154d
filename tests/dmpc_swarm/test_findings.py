"""The commands in docs/findings.md show what the findings say."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from swarmproof.claims.proof import ProofVerdict
from swarmproof.cli import main
from swarmproof.dmpc_swarm.proofs.registry import PROOF_CLAIMS, select_proof_claims

#: The command of each finding, with what it prints of the claim that the finding is about, and its exit code.
SHOWN = {
    "swarmproof verify --uavs 3 --cus 2 --claim lemma-1": (1, "lemma-1 violated 12 rounds, 0 lost"),
    "swarmproof verify --uavs 3 --cus 2 --semantics guarded": (0, "recovery holds at most 13 loss-free rounds"),
    "swarmproof verify --uavs 3 --cus 2 --claim recovery": (
        1,
        "recovery violated loop after 14 rounds, 4 lost, inevitable",
    ),
    "swarmproof verify --uavs 3 --cus 2 --semantics prose --claim recovery": (
        0,
        "recovery holds at most 19 loss-free rounds",
    ),
    "swarmproof verify --uavs 3 --cus 2 --set event_trigger=round-robin --claim same-selection --max-states 250000": (
        1,
        "same-selection violated 12 rounds, 0 lost",
    ),
    "swarmproof verify --set event_trigger=round-robin --claim one-planner-per-uav": (
        1,
        "one-planner-per-uav violated 11 rounds, 3 lost",
    ),
    "swarmproof verify --uavs 6 --cus 1 --semantics guarded": (0, "recovery holds at most 25 loss-free rounds"),
    "swarmproof verify --claim lemma-2 --report out/lemma-2": (1, "lemma-2 violated 8 rounds, 0 lost"),
    "swarmproof verify --semantics ignore-loss": (1, "lemma-1 violated 1 rounds, 1 lost"),
    "swarmproof verify --uavs 1 --cus 2": (1, "lemma-2 violated 4 rounds, 0 lost"),
    "swarmproof margin": (
        1,
        "Δd_min,cont 0.25 m, which is all of d̂_min: two UAVs can be in one place between two samples",
    ),
    "swarmproof margin --set T_c=0.05 --tracking-error 0.06": (
        1,
        "(26) as printed holds: d̂_min ≥ d_min + Δd_min + Δd_min,cont",
    ),
    "swarmproof margin --set T_c=0.05 --set j_max=100": (0, "Δd_min,cont between 0.0570397"),
    "swarmproof margin --set T_c=0.05 --set j_max=100 --reading initial-state": (
        0,
        "Δd_min,cont between 0.0544765",
    ),
    "swarmproof margin --solve-for T_c --d-min 0.12 --tracking-error 0.02": (
        0,
        "largest T_c with the corrected (26) certified: 0.05 s; refuted by a witness at 1/15 (≈ 0.0666667) s",
    ),
    "swarmproof fly circle --cus 3 --semantics printed --loss iid:0.05 --seed 26 --rounds 150": (1, "eq-2 violated"),
    "swarmproof fly circle --cus 3 --loss jam:3,10 --semantics ignore-loss": (1, "eq-2 violated"),
    "swarmproof fly circle --cus 3 --loss jam:3,10": (0, "circle, 16 UAVs, 3 CUs, 300 rounds: no claim violated"),
    "swarmproof fly crossing --loss exhaustive:4": (0, "tracked-separation holds-for-these-rounds"),
    "swarmproof fly crossing --semantics ignore-loss --loss exhaustive:2": (1, "lemma-3 violated"),
    "swarmproof fly circle --cus 3": (0, "circle, 16 UAVs, 3 CUs, 300 rounds: no claim violated"),
    "swarmproof fly circle --cus 3 --loss iid:0.1": (0, "circle, 16 UAVs, 3 CUs, 300 rounds: no claim violated"),
    "swarmproof fly circle --cus 3 --set tolerance=0.01": (1, "409 optimization problems solved"),
    "swarmproof fly circle --cus 3 --set tolerance=0.02 --set tolerance_halfway=0.01": (
        1,
        "900 optimization problems solved",
    ),
    "swarmproof fly circle --cus 3 --loss jam:0,10 --semantics ignore-loss --seed 1 --rounds 220 --set jitter=0.02": (
        1,
        "eq-2 violated",
    ),
    "swarmproof fly circle --cus 3 --loss jam:0,10 --seed 1 --rounds 220 --set jitter=0.02": (
        0,
        "circle, 16 UAVs, 3 CUs, 220 rounds: no claim violated",
    ),
    "swarmproof fly circle --cus 3 --loss jam:3,1000 --rounds 60": (
        0,
        "circle, 16 UAVs, 3 CUs, 60 rounds: no claim violated",
    ),
    "swarmproof fly crossing --set d_hat_min=1.3 --set begin=anyhow --rounds 40": (
        0,
        "0 optimization problems solved, 0 answers rejected, 80 infeasible",
    ),
    "swarmproof fly random --cus 2 --loss iid:0.07 --semantics printed --seed 8 --rounds 300 --set uavs=16 "
    "--set workspace=-1.4,1.4,-3.7,3.7,0.4,1.8 --set hold=150": (1, "eq-2 violated"),
}
TEXT = (Path(__file__).parents[2] / "docs" / "findings.md").read_text()
COMMANDS = set(re.findall(r"`(swarmproof [^`]+)`", TEXT))
AUDITS = sorted(command for command in COMMANDS if command.startswith("swarmproof audit "))
#: What takes an hour: tests/dmpc_swarm/experiments/test_documents.py compares the pages with their flights.
EXPERIMENTS = {"swarmproof reproduce fig3b", "swarmproof reproduce fig3c", "swarmproof reproduce loss"}
LONG = ("--uavs 3", "exhaustive:4", "fly circle --cus 3", "fly random --cus 2")
QUICK = [command for command in SHOWN if "guarded" in command or not any(part in command for part in LONG)]


def check(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Give the command in an empty folder, and compare its exit code and its line on the claim."""
    code, line = SHOWN[command]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    assert main(shlex.split(command)[1:]) == code
    printed = [" ".join(one.split()) for one in capsys.readouterr().out.splitlines()]
    assert any(one.startswith(line) for one in printed)


def test_every_command_of_the_findings_is_checked() -> None:
    """The table above has exactly the commands in docs/findings.md, but for those of proofs and experiments."""
    assert COMMANDS - set(AUDITS) - EXPERIMENTS == set(SHOWN)


def test_every_false_statement_is_a_finding() -> None:
    """Each claim about the proofs that is false as printed has a row with its command."""
    named = {name for command in AUDITS for name in shlex.split(command)[3::2]}
    assert {claim.id for claim in PROOF_CLAIMS if claim.verdict is ProofVerdict.FALSE} <= named


@pytest.mark.parametrize("command", AUDITS)
def test_command_shows_the_verdicts_of_the_proofs(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The finding's command prints every claim that it names with the verdict on record, and exits with 0."""
    assert main(shlex.split(command)[1:]) == 0
    printed = capsys.readouterr().out
    for claim in select_proof_claims(shlex.split(command)[3::2]):
        assert f"{claim.key}: {claim.verdict}\n" in printed


@pytest.mark.parametrize("command", QUICK)
def test_command_shows_the_finding(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The finding's command prints the verdict and the length that the finding speaks of."""
    check(command, tmp_path, monkeypatch, capsys)


@pytest.mark.deep
@pytest.mark.parametrize("command", [command for command in SHOWN if command not in QUICK])
def test_long_command_shows_the_finding(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same for the commands that take longer."""
    check(command, tmp_path, monkeypatch, capsys)
