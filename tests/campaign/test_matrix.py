"""The recorded matrix: it is complete, reproducible, and a changed verdict is an error."""

from __future__ import annotations

import dataclasses
import json
import tomllib
from pathlib import Path

import pytest

from swarmproof.campaign.matrix import Row, as_toml, load_matrix, run_matrix, select_rows
from swarmproof.cli import main
from swarmproof.commands import verify as verify_command
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS
from swarmproof.dmpc_swarm.record import configurations
from swarmproof.dmpc_swarm.semantics import PRESETS, SWITCHES, Semantics
from swarmproof.dmpc_swarm.system import SYSTEM
from swarmproof.explore.search import Limits


def unheard(told: object) -> None:
    """Listen to nothing."""


def small_rows() -> list[Row]:
    """Return rows that take no time."""
    return select_rows(load_matrix(SYSTEM), {"uavs": 2, "cus": 1}, None)


def test_matrix_has_every_preset_and_switch_value() -> None:
    """At 2 x 2 every preset is recorded, and for each every value of every switch that can be set."""
    recorded = {(row.size, row.scope.reading) for row in load_matrix(SYSTEM)}
    for preset in PRESETS:
        assert ("2x2", Semantics.parse(preset)) in recorded
        for switch, values in SWITCHES.items():
            if switch != "loss_handling" and (switch, preset) != ("initial", "ignore-loss"):
                for value in values:
                    assert ("2x2", Semantics.parse(preset, [f"{switch}={value}"])) in recorded


def test_matrix_records_what_the_recorder_lists() -> None:
    """The file has exactly the configurations of the recorder, in its order, each with all claims."""
    rows = load_matrix(SYSTEM)
    assert [(row.size, row.preset, row.overrides) for row in rows] == [
        (row.size, row.preset, row.overrides) for row in configurations()
    ]
    assert len({row.name for row in rows}) == len(rows)
    for row in rows:
        assert list(row.expected) == [claim.id for claim in CLAIMS]


def test_recording_is_read_back() -> None:
    """What is recorded of a run is what a run is compared with: no change."""
    results = run_matrix(small_rows(), Limits(), 2, unheard, unheard)
    assert [one.changes for one in results] == [[]] * len(results)
    again = tomllib.loads("\n".join(as_toml(results)))["configuration"]
    assert [entry["expect"] for entry in again] == [one.row.expected for one in results]


@pytest.mark.parametrize("expected", ["violated in 3, 1 lost", "holds", "holds within 8, avoidable"])
def test_changed_verdict_is_an_error(
    expected: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A recorded verdict, or length, that is not found again ends with exit code 1 and is named."""
    rows = small_rows()
    rows[0] = dataclasses.replace(rows[0], expected={**rows[0].expected, "recovery": expected})
    monkeypatch.setattr(verify_command, "load_matrix", lambda _: rows)
    assert main(["verify", "--matrix"]) == 1
    text = " ".join(capsys.readouterr().out.split())
    assert f"changed {rows[0].name}: recovery: holds within 8, recorded is: {expected}" in text


def test_known_flaw_is_no_error(capsys: pytest.CaptureFixture[str]) -> None:
    """A configuration whose recorded verdict is *violated* leaves the exit code at 0."""
    assert any("violated" in verdict for row in small_rows() for verdict in row.expected.values())
    assert main(["verify", "--matrix", "--uavs", "2", "--cus", "1"]) == 0
    assert "0 with a changed verdict, 0 undecided" in " ".join(capsys.readouterr().out.split())


def test_undecided_matrix_has_its_exit_code() -> None:
    """A matrix that is cut short ends with exit code 3: undecided is no changed verdict."""
    assert main(["verify", "--matrix", "--uavs", "2", "--cus", "1", "--semantics", "printed", "--max-states", "9"]) == 3
    rows = select_rows(load_matrix(SYSTEM), {"uavs": 2, "cus": 1}, "printed")
    (result,) = run_matrix(rows, Limits(max_states=9), 2, unheard, unheard)
    assert result.undecided
    assert result.changes == []


def test_matrix_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The matrix report links a folder per configuration, and its last line is the path of the report."""
    arguments = ["verify", "--matrix", "--uavs", "2", "--cus", "1", "--report", str(tmp_path)]
    assert main(arguments) == 0
    assert capsys.readouterr().out.rstrip("\n").endswith(f"Report: {tmp_path / 'index.html'}")
    page = (tmp_path / "index.html").read_text()
    for row in small_rows():
        assert f'href="{row.name}/index.html"' in page
        assert (tmp_path / row.name / "index.html").exists()
    assert (tmp_path / "2x1-ignore-loss" / "lemma-1.html").exists()
    document = json.loads((tmp_path / "matrix.json").read_text())
    assert document["schema"] == "swarmproof.matrix/1"
    assert len(document["configurations"]) == len(small_rows())
    assert document["changed"] == {}
