"""`swarmproof reproduce`: what it flies, keeps, says and writes, its exit codes, and one sentence for bad input.

The experiments are replaced by one with a few flights of two UAVs, whose verdicts a test can choose.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from swarmproof.campaign import decide as decide_module
from swarmproof.campaign import provenance as made_by_module
from swarmproof.campaign import store as store_module
from swarmproof.campaign.store import Store, Stored
from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import ExperimentClaim, Never, Observation, Sometimes, Value
from swarmproof.cli import main
from swarmproof.commands import reproduce as command
from swarmproof.dmpc_swarm.claims.experiments import IGNORING, MLR
from swarmproof.dmpc_swarm.experiments.experiment import AS_CHOSEN, Experiment, Variant
from swarmproof.dmpc_swarm.experiments.measure import REACHED, Measured, measure
from swarmproof.dmpc_swarm.pages.experiments import words as reproduce_words
from swarmproof.exit_codes import ExitCode

Json = dict[str, Any]
Observe = Callable[[Cell, Measured, float], list[Observation]]

CHOSEN = tuple(Cell("crossing", 2, "HT", f"jam:{start},10", "guarded", start, 12) for start in (1, 2, 3))
OTHERS = tuple(replace(cell, changes=("band=0.5",)) for cell in CHOSEN)
QUICK = CHOSEN[:1]
#: Flights that take long enough to be interrupted among them.
MANY = tuple(Cell("crossing", 2, "HT", "iid:0.1", "guarded", seed, 80) for seed in range(12))


def collides(seen: Observation) -> bool | None:
    """Say whether UAVs collide; None if that is not decided."""
    return None if seen.values["collides"] is None else bool(seen.values["collides"])


#: One claim of each kind about single flights; the real ones have tests of their own.
CLAIMS = (
    ExperimentClaim("safe", "fig4", "", "", "", Never(lambda seen: seen.labels["method"] == MLR, collides)),
    ExperimentClaim("unsafe", "fig4", "", "", "", Sometimes(lambda seen: seen.labels["method"] == IGNORING, collides)),
    ExperimentClaim("arrives", "fig4", "", "", "", Never(lambda seen: True, lambda seen: not seen.values["arrives"])),
)
IDS = [claim.id for claim in CLAIMS]


def observing(**changes: Value) -> Observe:
    """Return an observer that sees in each flight what the paper says, with some values changed wherever they are."""

    def observe(cell: Cell, measured: Measured, radius: float) -> list[Observation]:
        assert radius == REACHED
        return [
            Observation(
                cell.seed,
                {"method": method},
                {"separation_m": measured.lower, "collides": method == IGNORING, "arrives": True} | changes,
            )
            for method in (MLR, IGNORING)
        ]

    return observe


def small(observe: Observe) -> Callable[[bool], Experiment]:
    """Return a small experiment, with a variant if it is full."""
    chosen, changed = Variant(AS_CHOSEN, "", CHOSEN), Variant("band=0.5", "the published number", OTHERS)
    return lambda quick: Experiment(
        "fig4",
        "A small jam",
        "Two UAVs.",
        (replace(chosen, cells=QUICK),) if quick else (chosen, changed),
        observe,
    )


def many(quick: bool) -> Experiment:
    """Return an experiment with many flights."""
    return Experiment("fig4", "Many jams", "Two UAVs.", (Variant(AS_CHOSEN, "", MANY),), observing())


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace all experiments by a small one that agrees with the paper."""
    monkeypatch.setattr(command, "EXPERIMENTS", {"fig4": small(observing())})
    monkeypatch.setattr(decide_module, "claims_of", lambda name: CLAIMS)


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the results of the small experiment; nobody writes there."""
    store = Store(tmp_path_factory.mktemp("reproduce") / "results")
    for cell in (*CHOSEN, *OTHERS):
        store.put(cell, Stored(measure(cell), 0.25))
    return store.folder


@pytest.fixture
def results(flown: Path, tmp_path: Path) -> Path:
    """Return a folder of one's own with the same results."""
    folder = tmp_path / "results"
    Store(folder)
    for path in flown.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    return folder


def run(results: Path, *arguments: str) -> int:
    """Run the command with results in a folder."""
    return main(["reproduce", "fig4", "--results", str(results), *arguments])


def words(text: str) -> str:
    """Return a text with a single space between its words."""
    return " ".join(text.split())


def ids_in(folder: Path) -> set[str]:
    """Return the ids of the cells whose results are in a folder."""
    return {path.stem for path in folder.glob("*.json")}


def times_of(folder: Path) -> dict[str, int]:
    """Return by file when it was written, in ns."""
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("*.json")}


def ids(cells: Sequence[Cell]) -> set[str]:
    """Return the ids of cells."""
    return {cell.id for cell in cells}


def file_of(folder: Path, cell: Cell) -> Path:
    """Return the file of a cell."""
    return folder / f"{cell.id}.json"


def tamper(folder: Path, cell: Cell, change: Callable[[Json], Any]) -> None:
    """Change the numbers of a cell that are stored, and sign them anew."""
    table = json.loads(file_of(folder, cell).read_text(encoding="ascii"))
    change(table["measured"])
    table["digest"] = store_module._digest(table)
    file_of(folder, cell).write_text(json.dumps(table), encoding="ascii")


# What is flown, and what is said


def test_what_is_missing_is_flown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The first run flies everything and keeps it; the second flies nothing; both say the same of the claims."""
    assert run(tmp_path / "new", "--processes", "2") == 0
    first = words(capsys.readouterr().out)
    assert "A small jam: 6 flights, none of which is there: about 0 s with 2 processes." in first
    assert ids_in(tmp_path / "new") == ids((*CHOSEN, *OTHERS))
    for cell in (*CHOSEN, *OTHERS):
        stored = Store(tmp_path / "new").get(cell)
        assert stored is not None
        assert stored.measured == measure(cell)
    before = times_of(tmp_path / "new")
    assert run(tmp_path / "new") == 0
    second = words(capsys.readouterr().out)
    assert "A small jam: 6 flights, all of which are there." in second
    assert times_of(tmp_path / "new") == before
    assert second.partition("the paper's statement")[2] == first.partition("the paper's statement")[2]
    for verdict in ("safe not violated", "unsafe agrees", "arrives not violated"):
        assert f" {verdict} " in second
    assert "6 of 6 flights, 3 seeds as chosen" in second


def test_only_what_is_missing_is_flown(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file that is not there is made again; those that are there are not touched; the estimate is from them."""
    file_of(results, OTHERS[1]).unlink()
    before = times_of(results)
    assert run(results, "--processes", "2") == 0
    said = words(capsys.readouterr().out)
    # five flights of the same length took 0.25 s each
    assert "A small jam: 6 flights, 5 are there, 1 missing: about 0 s with 2 processes." in said
    after = times_of(results)
    assert {name: after[name] for name in before} == before
    assert ids_in(results) == ids((*CHOSEN, *OTHERS))


def test_outdated_results_are_told_and_flown_again(
    results: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What other code, or nothing sensible, wrote is flown again, and said to be so."""
    old = json.loads(file_of(results, CHOSEN[0]).read_text(encoding="ascii"))
    old["made_by"]["swarmproof"] = "0" * 16
    file_of(results, CHOSEN[0]).write_text(json.dumps(old), encoding="ascii")
    file_of(results, OTHERS[0]).write_text("torn", encoding="ascii")
    before = times_of(results)
    assert run(results, "--processes", "1") == 0
    said = words(capsys.readouterr().out)
    assert "4 are there, 2 missing: about 0 s with 1 process." in said
    assert re.search(r"1 of them were flown by other code or .*versions of libraries: they are flown again\.", said)
    first = f"{file_of(results, OTHERS[0])}: it is no result of a flight"
    assert f"1 stored results are not believed and flown again; the first is {first}." in said
    after = times_of(results)
    again = {f"{cell.id}.json" for cell in (CHOSEN[0], OTHERS[0])}
    assert {name for name in before if after[name] != before[name]} == again
    # and with other code all of them would be
    other = {**made_by_module.made_by(), "numpy": "0.1"}
    monkeypatch.setattr(made_by_module, "made_by", lambda: other)
    assert Store(results).uncounted((*CHOSEN, *OTHERS))[0] == 6


def test_how_long_it_takes(tmp_path: Path) -> None:
    """The estimate is of processor time per round of what is there, for the rounds that are missing, shared."""
    experiment = small(observing())(False)
    cells = [replace(CHOSEN[0], seed=seed, rounds=100) for seed in range(5)]
    measured = replace(measure(CHOSEN[0]), rounds=50)
    there = {CHOSEN[0]: Stored(measured, 20.0)}

    store = Store(tmp_path)

    def said(missing: Sequence[Cell], processes: int, known: dict[Cell, Stored] = there) -> str:
        return " ".join(reproduce_words.before(experiment, known, missing, store, processes))

    assert "about 80 s with 1 process." in said(cells[:2], 1)
    assert "about 40 s with 2 processes." in said(cells[:2], 2)
    assert "about 80 s with 16 processes." not in said(cells[:2], 16)
    assert "about 40 s with 16 processes." in said(cells[:2], 16)
    assert "about 3 min with 1 process." in said(cells, 1)
    assert f"about {500 * reproduce_words.ROUND_S:.0f} s with 1 process." in said(cells, 1, {})
    assert "flown again" not in said(cells, 1)


def test_time_spans_in_words() -> None:
    """Seconds, then minutes, then hours."""
    spans = [reproduce_words.duration(seconds) for seconds in (0.2, 99, 101, 5900, 6100, 36000)]
    assert spans == ["0 s", "99 s", "2 min", "98 min", "1.7 h", "10.0 h"]


def test_quick_and_as_chosen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A quick run flies its own flights and says that it is one; `--as-chosen` leaves variants out."""
    assert run(tmp_path / "quick", "--quick", "--processes", "1") == 0
    assert ids_in(tmp_path / "quick") == ids(QUICK)
    assert "A quick run, 1 of 1 flights, 1 seeds as chosen" in words(capsys.readouterr().out)
    assert run(tmp_path / "quick", "--as-chosen", "--processes", "1") == 0
    assert ids_in(tmp_path / "quick") == ids(CHOSEN)
    said = words(capsys.readouterr().out)
    assert "A small jam: 3 flights, 1 are there, 2 missing" in said
    assert "A quick run" not in said


# Exit codes


@pytest.mark.parametrize(
    ("changes", "code", "verdict"),
    [
        ({}, 0, " safe not violated "),
        ({"collides": True}, 1, " safe disagrees "),
        ({"collides": False}, 1, " unsafe disagrees "),
        ({"collides": None}, 3, " unsafe "),
        ({"collides": None, "arrives": False}, 1, " arrives disagrees "),
    ],
)
def test_exit_codes_are_verdicts(
    changes: dict[str, Value],
    code: int,
    verdict: str,
    flown: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """0 if all statements agree, 1 if one does not, else 3 if one is not decided; the table says which."""
    monkeypatch.setattr(command, "EXPERIMENTS", {"fig4": small(observing(**changes))})
    assert run(flown) == code
    assert verdict in words(capsys.readouterr().out)


def test_what_was_flown_is_not_said_to_be_not_flown(
    flown: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A claim that is decided in none of its flights is undecided; only one without flights was not flown."""
    monkeypatch.setattr(command, "EXPERIMENTS", {"fig4": small(observing(collides=None))})
    assert run(flown) == 3
    assert "not flown" not in capsys.readouterr().out


def test_variants_do_not_decide(
    flown: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A statement that disagrees with a choice changed is told, and the exit code is that of what is as chosen."""

    def observe(cell: Cell, measured: Measured, radius: float) -> list[Observation]:
        return observing(**({"collides": True} if cell.changes else {}))(cell, measured, radius)

    monkeypatch.setattr(command, "EXPERIMENTS", {"fig4": small(observe)})
    assert run(flown) == 0
    assert "With band=0.5: safe disagrees" in words(capsys.readouterr().out)


# JSON and the page


def test_json_has_all_claims(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The document has every claim for every variant, in order; nothing else is on standard output."""
    assert run(results, "--json", "-") == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert list(document) == ["format", "experiment", "quick", "flights", "made_by", "variants"]
    assert (document["format"], document["experiment"], document["quick"]) == (
        "swarmproof.reproduction/1",
        "fig4",
        False,
    )
    assert document["flights"] == {"wanted": 6, "there": 6}
    assert document["made_by"] == made_by_module.made_by()
    assert [variant["name"] for variant in document["variants"]] == [AS_CHOSEN, "band=0.5"]
    for variant in document["variants"]:
        assert [claim["id"] for claim in variant["claims"]] == IDS
        assert all(claim["verdict"] in ("agrees", "not violated") for claim in variant["claims"])
        assert all(claim["why"] and claim["comparisons"] == [] for claim in variant["claims"])
    assert "unsafe" in captured.err


def test_json_goes_to_a_file(results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The same document, and the words stay on standard output."""
    path = tmp_path / "new" / "verdicts.json"
    assert run(results, "--json", str(path)) == 0
    assert "unsafe" in capsys.readouterr().out
    assert run(results, "--json", "-") == 0
    assert json.loads(path.read_text(encoding="utf-8")) == json.loads(capsys.readouterr().out)


def test_a_report_gets_what_was_found(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page is written into the folder from all results, and the command says where it is."""
    written: list[tuple[Any, ...]] = []
    monkeypatch.setattr(command, "put_reproduction", lambda *arguments: written.append(arguments))
    assert run(results, "--report", str(tmp_path / "page")) == 0
    ((folder, experiment, found, quick),) = written
    assert folder.path == tmp_path / "page"
    assert folder.path.is_dir()
    assert experiment.name == "fig4"
    assert set(found) == {*CHOSEN, *OTHERS}
    assert quick is False
    assert f"Report: {folder.index}" in words(capsys.readouterr().out)


# One cell again


def test_a_cell_flown_again_is_the_same(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is stored is the same to the bit; its command and numbers are told, and no file changes."""
    before = times_of(results)
    assert run(results, "--cell", CHOSEN[1].id) == 0
    said = words(capsys.readouterr().out)
    assert CHOSEN[1].command in said
    assert f"lower = {measure(CHOSEN[1]).lower!r}" in said
    assert "The stored result is the same, to the bit." in said
    assert times_of(results) == before


def test_a_cell_that_differs_is_named(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One bit of one number is enough: both values are told, nothing is overwritten, and one of several decides."""
    lower = measure(CHOSEN[0]).lower
    other = lower + 2**-54
    assert other != lower
    tamper(results, CHOSEN[0], lambda measured: measured.update(lower=other))
    tamper(results, CHOSEN[2], lambda measured: measured["legs"][0]["reached"][3].__setitem__(0, 12))
    before = times_of(results)
    assert run(results, "--cell", CHOSEN[0].id, "--cell", CHOSEN[1].id, "--cell", CHOSEN[2].id) == 1
    said = words(capsys.readouterr().out)
    assert f"lower: {other!r} is stored, {lower!r} was measured now" in said
    assert "legs: others are stored" in said
    assert said.count("is stored") == 1
    assert said.count("The stored result is the same, to the bit.") == 1
    assert times_of(results) == before


def test_a_cell_that_is_not_stored_cannot_be_compared(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is flown and told, nothing is kept, and the exit code is 3; another cell that differs counts more."""
    file_of(results, CHOSEN[0]).unlink()
    file_of(results, OTHERS[0]).write_text("torn", encoding="ascii")
    tamper(results, CHOSEN[1], lambda measured: measured.update(adopted=measured["adopted"] + 1))
    assert run(results, "--cell", CHOSEN[0].id, "--cell", OTHERS[0].id) == 3
    said = words(capsys.readouterr().out)
    assert len(re.findall(r" no .{0,30}\bresult of this code\b", said)) == 2
    assert f"lower = {measure(OTHERS[0]).lower!r}" in said
    assert not file_of(results, CHOSEN[0]).exists()
    assert run(results, "--cell", CHOSEN[0].id, "--cell", CHOSEN[1].id, "--cell", CHOSEN[2].id) == 1


def test_a_folder_may_have_any_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The name of the folder with results is printed as it is, whatever characters it has."""
    folder = tmp_path / "a[" / "b]"
    assert run(folder, "--cell", CHOSEN[0].id) == 3
    assert str(folder) in words(capsys.readouterr().out)


# Bad input


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["fig5"], "there is no experiment 'fig5': choose fig4"),
        ([""], "an argument has an empty value"),
        ([], "EXPERIMENT"),
        (["fig4", "--processes", "0"], "--processes 0 cannot be: choose 1 to 256"),
        (["fig4", "--processes", "257"], "--processes 257 cannot be"),
        (["fig4", "--processes", "-1"], "--processes"),
        (["fig4", "--processes", "two"], "'two' is no whole number"),
        (["fig4", "--cell", "0123456789"], "fig4 has no cell '0123456789'"),
        (["fig4", "--cell", CHOSEN[0].id, "--cell", ""], "--cell has an empty value"),
        (["fig4", "--quick", "--cell", OTHERS[0].id], "fig4 has no cell"),
        (["fig4", "--as-chosen", "--cell", OTHERS[0].id], "fig4 has no cell"),
        (["fig4", "--cell", CHOSEN[0].id, "--json", "-"], "--cell flies single cells again"),
        (["fig4", "--cell", CHOSEN[0].id, "--report", "page"], "--cell flies single cells again"),
        (["fig4", "--results", "/dev/null/results"], "the results cannot be kept in /dev/null/results"),
        (["fig4", "--cell", CHOSEN[0].id, "--results", "/dev/null"], "the results cannot be kept in /dev/null"),
        (["fig4", "--json", "/dev/null/verdicts.json"], "/dev/null/verdicts.json"),
        (["fig4", "--report", "/dev/null/page"], "/dev/null/page"),
        (["fig4", "--seeds", "3"], "--seeds"),
        (["fig4", "--results", ""], "--results has an empty value: give one, such as --results out/results"),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: list[str],
    why: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nothing is flown, nothing is printed but one sentence that says what is wrong, and the exit code is 2."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(command, "sweep", lambda *arguments: pytest.fail("flown"))
    assert main(["reproduce", *arguments]) == ExitCode.BAD_INPUT
    captured = capsys.readouterr()
    assert captured.out == ""
    (line,) = captured.err.strip().splitlines()
    assert line.startswith("swarmproof: ")
    assert why in line


def test_a_cell_that_cannot_be_flown_is_bad_input(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What goes wrong in a process ends the command with its sentence."""
    broken = replace(CHOSEN[0], changes=("wind=3",))
    experiment = replace(small(observing())(True), variants=(Variant(AS_CHOSEN, "", (broken,)),))
    monkeypatch.setattr(command, "EXPERIMENTS", {"fig4": lambda quick: experiment})
    assert run(tmp_path) == ExitCode.BAD_INPUT
    line = capsys.readouterr().err.strip().splitlines()[-1]
    assert line.startswith("swarmproof: ")
    assert "wind" in line


# Interrupts


def test_an_interrupted_run_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C ends it with exit code 3 and a sentence; results stay, and the next run flies only what is missing."""
    code = (
        "import os, signal, sys, threading\n"
        "from swarmproof.cli import main\n"
        "from swarmproof.commands import reproduce as command\n"
        "from swarmproof.campaign.store import Store\n"
        "from swarmproof.campaign import decide\n"
        "from tests.commands.test_reproduce import CLAIMS, many\n"
        "kept, put = [], Store.put\n"
        "def interrupted(self, cell, stored):\n"
        "    put(self, cell, stored)\n"
        "    kept.append(cell)\n"
        "    if len(kept) == 2:\n"
        "        # a terminal interrupts all processes of a command\n"
        "        threading.Timer(0.05, os.killpg, (0, signal.SIGINT)).start()\n"
        "Store.put = interrupted\n"
        "command.EXPERIMENTS = {'fig4': many}\n"
        "decide.claims_of = lambda name: CLAIMS\n"
        "sys.exit(main(['reproduce', 'fig4', '--processes', '2', '--results', sys.argv[1]]))\n"
    )
    folder = tmp_path / "results"
    begun = subprocess.run(
        [sys.executable, "-c", code, str(folder)],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        start_new_session=True,
        timeout=600,
        check=False,
    )
    out, err = begun.stdout, begun.stderr
    assert begun.returncode == 3
    assert "interrupted; the same command goes on from here. What follows is about what is there" in words(out)
    assert "Traceback" not in err
    kept = times_of(folder)
    assert 2 <= len(kept) < len(MANY)
    assert f"{len(kept)} of {len(MANY)} flights" in words(out)
    monkeypatch.setattr(command, "EXPERIMENTS", {"fig4": many})
    assert run(folder, "--processes", "2") == 0
    said = words(capsys.readouterr().out)
    assert re.search(rf"{len(kept)} are there, {len(MANY) - len(kept)} missing", said)
    after = times_of(folder)
    assert {name: after[name] for name in kept} == kept
    assert ids_in(folder) == ids(MANY)


def test_an_interrupt_means_undecided(
    tmp_path: Path, results: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Interrupted, no run says that all agrees, even if what is there does; but that something disagrees, it may."""
    file_of(results, CHOSEN[0]).unlink()
    monkeypatch.setattr(command, "sweep", lambda *arguments: False)
    assert run(results) == 3
    assert "interrupted" in capsys.readouterr().out
    monkeypatch.setattr(command, "EXPERIMENTS", {"fig4": small(observing(collides=True))})
    assert run(results) == 1
    assert run(tmp_path / "empty") == 3


def test_an_interrupted_cell_says_so(
    results: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A single cell that is interrupted says nothing about itself."""
    monkeypatch.setattr(command, "sweep", lambda *arguments: False)
    assert run(results, "--cell", CHOSEN[0].id) == 130
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == "swarmproof: interrupted\n"
