"""The command line: what it prints and writes, its exit codes, and one sentence for bad input."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from swarmproof.cli import main
from swarmproof.commands import verify as verify_command
from swarmproof.dmpc_swarm.claims.experiments import EXPERIMENT_CLAIMS
from swarmproof.explore import decide, search

HOLDS = ["verify", "--semantics", "guarded", "--uavs", "2", "--cus", "1"]
VIOLATED = ["verify", "--semantics", "ignore-loss"]


def verdicts(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, object]]:
    """Run `verify ... --json -` and return the exit code and the document."""
    code = main([*arguments, "--json", "-"])
    document: dict[str, object] = json.loads(capsys.readouterr().out)
    return code, document


def by_id(document: dict[str, object]) -> dict[str, dict[str, object]]:
    """Return the claims of a verdicts document by id."""
    claims = document["claims"]
    assert isinstance(claims, list)
    return {claim["id"]: claim for claim in claims}


def test_json_on_standard_output_is_only_json(capsys: pytest.CaptureFixture[str]) -> None:
    """With `--json -`, standard output is one document of the published schema, with every switch."""
    code, document = verdicts(capsys, *HOLDS)
    assert code == 0
    assert list(document) == ["schema", "system", "uavs", "cus", "semantics", "exploration", "claims"]
    assert (document["schema"], document["system"]) == ("swarmproof.verdicts/1", "mlr-dmpc")
    assert (document["uavs"], document["cus"]) == (2, 1)
    assert document["semantics"] == {
        "deprecation": "one",
        "rejoin": "after-reply",
        "slot_conflict": "either",
        "request_order": "lowest-index",
        "event_trigger": "any",
        "initial": "unknown",
        "loss_handling": "recover",
    }
    exploration = document["exploration"]
    assert isinstance(exploration, dict)
    assert list(exploration) == ["fixpoint", "states", "transitions", "depth", "seconds"]
    assert exploration["fixpoint"] is True


def test_json_has_the_lengths_of_the_verdicts(capsys: pytest.CaptureFixture[str]) -> None:
    """Lengths are given where a trace exists, the worst number of rounds where recovery holds, and null elsewhere."""
    _, document = verdicts(capsys, *HOLDS)
    claims = by_id(document)
    none = {"rounds": None, "lost_messages": None, "worst_rounds": None, "avoidable": None, "trace": None}
    assert claims["lemma-1"] == {"id": "lemma-1", "verdict": "holds"} | none
    assert claims["same-selection"] == {"id": "same-selection", "verdict": "not-applicable"} | none
    assert claims["recovery"] == {"id": "recovery", "verdict": "holds"} | none | {"worst_rounds": 9}
    code, document = verdicts(capsys, *VIOLATED)
    claims = by_id(document)
    assert code == 1
    assert claims["lemma-2"] == {"id": "lemma-2", "verdict": "violated"} | none | {"rounds": 1, "lost_messages": 1}


def test_violated_recovery_tells_whether_it_is_avoidable(capsys: pytest.CaptureFixture[str]) -> None:
    """A recovery that does not hold has the length of its lasso's stem, and says whether choices avoid it."""
    code, document = verdicts(capsys, "verify", "--claim", "recovery")
    assert code == 1
    recovery = by_id(document)["recovery"]
    assert (recovery["verdict"], recovery["rounds"], recovery["lost_messages"]) == ("violated", 10, 2)
    assert (recovery["worst_rounds"], recovery["avoidable"]) == (None, True)


def test_only_the_claims_asked_for_are_decided(capsys: pytest.CaptureFixture[str]) -> None:
    """`--claim` limits the verdicts, and the exit code, to the claims named."""
    code, document = verdicts(capsys, "verify", "--claim", "can-plan", "--claim", "lemma-1")
    assert list(by_id(document)) == ["lemma-1", "can-plan"]
    assert code == 1
    code, document = verdicts(capsys, "verify", "--claim", "can-plan")
    assert (code, by_id(document)["can-plan"]["rounds"]) == (0, 7)


def test_set_overrides_the_preset(capsys: pytest.CaptureFixture[str]) -> None:
    """`--set` changes single switches of a preset, the last one last."""
    _, document = verdicts(capsys, *HOLDS, "--set", "deprecation=all", "--set", "initial=known")
    semantics = document["semantics"]
    assert isinstance(semantics, dict)
    assert (semantics["deprecation"], semantics["rejoin"], semantics["initial"]) == ("all", "after-reply", "known")


def test_report_and_replay(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Every trace that a report names replays; with a violated claim the exit code is 1, with a witness 0."""
    folder = tmp_path / "a" / "report"
    code, document = verdicts(capsys, "verify", "--report", str(folder))
    assert code == 1
    written = json.loads((folder / "verdicts.json").read_text())
    for inside, outside in zip(written["claims"], by_id(document).values(), strict=True):
        name = inside.pop("trace")  # relative to the folder, which may be moved
        assert outside | inside == outside
        assert outside["trace"] == (None if name is None else str(folder / name))
    assert (folder / "index.html").exists()
    for claim in by_id(document).values():
        if claim["trace"] is None:
            assert claim["rounds"] is None
            continue
        assert (folder / f"{claim['id']}.html").exists()
        assert main(["replay", str(claim["trace"])]) == (1 if claim["verdict"] == "violated" else 0)
        assert str(claim["id"]) in capsys.readouterr().out
    witnesses = sorted(folder.glob("witness-*.trace.json"))
    assert [path.name for path in witnesses] == [
        f"witness-{name}.trace.json"
        for name in ("recovery-entered", "recovery-left", "request-answered", "slot-conflict", "two-entries")
    ]
    for path in witnesses:
        assert main(["replay", str(path)]) == 0


def test_report_has_nothing_of_an_earlier_one(tmp_path: Path) -> None:
    """A report written over another one has only its own pages and traces; a file of the user's stays."""
    mine = tmp_path / "notes.html"
    mine.write_text("mine")
    main([*VIOLATED, "--report", str(tmp_path)])
    assert (tmp_path / "lemma-1.html").exists()
    main([*HOLDS, "--report", str(tmp_path)])
    assert not (tmp_path / "lemma-1.html").exists()
    assert not (tmp_path / "lemma-1.trace.json").exists()
    assert mine.read_text() == "mine"


def test_replay_says_what_is_broken(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The replay of a counterexample names the claim, the tracker that breaks it and the trajectories."""
    main([*VIOLATED, "--report", str(tmp_path)])
    capsys.readouterr()
    assert main(["replay", str(tmp_path / "lemma-1.trace.json")]) == 1
    text = " ".join(capsys.readouterr().out.split())
    assert "lemma-1 is violated: 1 round, 1 message lost." in text
    assert "<- broken" in text


def test_a_limit_makes_it_undecided(capsys: pytest.CaptureFixture[str]) -> None:
    """What is not decided within the limits is undecided, with exit code 3, and never holds."""
    code, document = verdicts(capsys, *HOLDS, "--max-states", "5")
    assert code == 3
    found = {claim["verdict"] for claim in by_id(document).values()}
    assert found == {"undecided", "not-applicable"}
    exploration = document["exploration"]
    assert isinstance(exploration, dict)
    assert (exploration["fixpoint"], exploration["states"]) == (False, 5)


def test_a_violation_outranks_undecided(capsys: pytest.CaptureFixture[str]) -> None:
    """A violation found before the limit stays one, and decides the exit code."""
    code, document = verdicts(capsys, *VIOLATED, "--max-states", "8")
    assert code == 1
    claims = by_id(document)
    assert (claims["lemma-1"]["verdict"], claims["recovery"]["verdict"]) == ("violated", "undecided")


def test_interrupt_keeps_what_was_found(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C ends the exploration, not the program: what was found is reported, and the rest is undecided."""

    def interrupt_late(progress: search.Progress) -> str:
        if progress.depth > 9:
            raise KeyboardInterrupt
        return ""

    monkeypatch.setattr(verify_command, "_progress_line", interrupt_late)
    code, document = verdicts(capsys, "verify")
    claims = by_id(document)
    assert code == 1
    assert (claims["lemma-1"]["verdict"], claims["lemma-1"]["rounds"]) == ("violated", 8)
    assert claims["recovery"]["verdict"] == "undecided"


def test_interrupt_while_deciding_keeps_the_other_verdicts(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C while a claim is decided leaves that claim undecided (or violated without a trace), and no other."""

    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(decide, "decide_recovery", interrupt)
    code, document = verdicts(capsys, *HOLDS)
    verdict_of = {name: claim["verdict"] for name, claim in by_id(document).items()}
    assert code == 3
    assert (verdict_of["lemma-1"], verdict_of["recovery"], verdict_of["can-plan"]) == ("holds", "undecided", "holds")
    monkeypatch.setattr(decide, "follow", interrupt)
    code, document = verdicts(capsys, *VIOLATED)
    assert code == 1
    lemma_1 = by_id(document)["lemma-1"]
    assert (lemma_1["verdict"], lemma_1["rounds"], lemma_1["lost_messages"]) == ("violated", 1, 1)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("", "COMMAND"),
        ("frobnicate", "'frobnicate'"),
        ("verify --bogus", "--bogus"),
        ("verify --uavs 0", "'0' is no whole number of at least 1"),
        ("verify --cus -3", "'-3'"),
        ("verify --uavs two", "'two'"),
        ("verify --uavs 99", "99 UAVs cannot be explored: choose 1 to 8"),
        ("verify --semantics gaurded", "choose printed, prose, guarded or ignore-loss"),
        ("verify --set rejoin", "SWITCH=VALUE"),
        ("verify --set rejion=any-state", "there is no switch 'rejion': choose deprecation"),
        ("verify --set rejoin=never", "it takes any-state or after-reply"),
        ("verify --set loss_handling=ignore", "needs initial=known"),
        ("verify --claim lemma-3", "there is no claim 'lemma-3': choose among lemma-1"),
        ("verify --max-states none", "'none'"),
        ("verify --max-seconds nan", "'nan'"),
        ("verify --json FILE/x.json", "cannot write"),
        ("verify --report FILE", "cannot write to"),
        ("verify --matrix --uavs 7", "the matrix has no such configuration"),
        ("verify --matrix --set rejoin=any-state", "--set does not go with --matrix"),
        ("replay", "TRACE"),
        ("replay FILE/nothing.json", "cannot read"),
        ("replay FILE", "is no trace"),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Bad input ends with exit code 2 and one line that says what is wrong and what would be right."""
    file = tmp_path / "file"
    file.write_text("not a folder, not a trace")
    assert main([word.replace("FILE", str(file)) for word in arguments.split()]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("swarmproof: ")
    assert captured.err.count("\n") == 1
    assert sentence in captured.err


def test_claims_lists_the_registry(capsys: pytest.CaptureFixture[str]) -> None:
    """`claims` lists every claim with its place in the paper."""
    assert main(["claims"]) == 0
    text = capsys.readouterr().out
    for name in ("lemma-1", "lemma-2", "plans-from-truth", "one-planner-per-uav", "same-selection", "recovery"):
        assert name in text
    for claim in EXPERIMENT_CLAIMS:
        assert claim.id in text


def test_module_runs_as_a_program() -> None:
    """`python -m swarmproof` is the command line, and a reader that goes away early is no error."""
    done = subprocess.run([sys.executable, "-m", "swarmproof", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("swarmproof ")
    piped = f"{sys.executable} -m swarmproof claims | head -n 1 > /dev/null; exit ${{PIPESTATUS[0]}}"
    assert subprocess.run(["bash", "-c", piped], capture_output=True, check=False).returncode == 0
