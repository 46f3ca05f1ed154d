"""`swarmproof margin` with norms, a delay, a crash's ellipsoid and kinds: what it prints, writes and refuses."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from swarmproof.cli import main
from swarmproof.margin.check import Verified, check

DOCUMENT = Path(__file__).parents[2] / "docs/theorem-3.md"


def _example(folder: Path, name: str) -> str:
    """Write the example file of the document that begins with its name, and return its path."""
    text = re.search(rf"```toml\n(# {name}\n.*?)```", DOCUMENT.read_text(), re.DOTALL)
    assert text is not None
    path = folder / name
    path.write_text(text[1])
    return str(path)


def _run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str]:
    """Return the exit code of the command, and what it prints, in one line."""
    code = main(["margin", *words])
    captured = capsys.readouterr()
    return code, " ".join((captured.out + captured.err).split())


def test_the_example_with_a_norm_runs_and_its_certificate_is_accepted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The document's file: the interval that it tells, the bounds that were used, and a certificate of schema 2."""
    certificate, document = tmp_path / "certificate.json", tmp_path / "margin.json"
    words = (_example(tmp_path, "norm.toml"), "--certificate", str(certificate), "--json", str(document))
    code, printed = _run(capsys, *words)
    assert code == 1
    assert "these bounds of the norm of speed, beside those per axis" in printed
    found = json.loads(document.read_text())
    assert 0.0716 <= found["dip"]["lower"] <= found["dip"]["upper"] <= 0.0732
    assert found["bounds"] == "norm"
    assert isinstance(check(json.loads(certificate.read_text())), Verified)
    assert _run(capsys, "--check", str(certificate))[0] == 0


def test_the_example_of_a_fleet_runs_and_keeps_a_certificate_for_each_pair(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three pairs of two kinds: by hand 0.018712 … 0.018714 m for the mixed one."""
    document, folder = tmp_path / "fleet.json", tmp_path / "certificates"
    code, printed = _run(capsys, _example(tmp_path, "fleet.toml"), "--json", str(document), "--results", str(folder))
    assert code == 0
    content: dict[str, Any] = json.loads(document.read_text())
    assert content["schema"] == "swarmproof.margin-fleet/1"
    names = [(one["kinds"], one["attained"]) for one in content["pairs"]]
    assert names == [(["large", "large"], True), (["large", "small"], False), (["small", "small"], True)]
    mixed = content["pairs"][1]["dip"]
    assert 0.018711 <= mixed["lower"] <= 0.018712 <= 0.018714 <= mixed["upper"] <= 0.018715
    assert "large and small" in printed
    assert "that need not be a pair of theirs" in printed
    assert len(list(folder.iterdir())) == 3
    for path in folder.iterdir():
        check(json.loads(path.read_text()))


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--certificate", "one.json"), "give --results DIR, a folder for one of each pair"),
        (("--solve-for", "T_c"), "--solve-for is for one pair of UAVs"),
        (("--sweep", "T_c=0.01:0.02"), "--sweep is for one pair of UAVs"),
        (("--plot", "one.svg"), "--plot is for one pair of UAVs"),
        (("--set", "v_max=1"), "v_max is given by [[kinds]], kind by kind"),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_what_is_for_one_pair_is_refused_for_kinds(
    words: tuple[str, ...], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence, exit code 2, and nothing is written."""
    code, printed = _run(capsys, _example(tmp_path, "fleet.toml"), *words)
    assert code == 2
    assert sentence in printed
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fleet.toml"]


def test_a_single_uav_has_nobody_to_keep_away_from(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A fleet of one is no success."""
    path = tmp_path / "one.toml"
    path.write_text("[[kinds]]\nuavs = [0]\n")
    code, printed = _run(capsys, str(path))
    assert code == 2
    assert "which has no other to keep away from" in printed


def test_a_delay_and_a_crash_are_told_and_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Both enter the inequality; the JSON has their bounds, and nothing of them where they are not used."""
    document = tmp_path / "margin.json"
    words = ("--set", "T_c=0.05", "--set", "order=2", "--json", str(document))
    assert _run(capsys, *words)[0] == 0
    assert {"delay", "crash", "bounds"}.isdisjoint(json.loads(document.read_text()))
    code, printed = _run(capsys, *words, "--set", "delay=0.01", "--set", "crash_theta_inverse=1,1,0.1")
    found = json.loads(document.read_text())
    assert code in (0, 3)
    assert "σ·√((d̂_min − Δd_min,cont)² − delay·(2d̂_min − delay)) ≥ d_min + 2‖C‖₂·Δd_min" in printed
    assert found["crash"]["lower"] <= 0.6 <= found["crash"]["upper"]
    # at 2 m/s per axis for 0.01 s, height counting 1/6
    assert found["delay"]["lower"] == pytest.approx(0.02 * (2 + 1 / 36) ** 0.5)
    late = found["delay"]["upper"]
    kept = 0.6 * ((0.25 - found["dip"]["upper"]) ** 2 - late * (0.5 - late)) ** 0.5
    assert found["theorem_3"]["guaranteed_separation"] == pytest.approx(kept)


def test_what_the_box_around_proves_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    """A norm that never binds: the upper bound is that of the box, and the words say so."""
    code, printed = _run(capsys, "--set", "T_c=0.05", "--set", "order=2", "--set", "v_max=2", "--set", "v_norm=500")
    assert code == 0
    assert "the upper bound takes the box around the norm: that is no wider here" in printed


def test_the_largest_norm_of_the_speed_is_found(capsys: pytest.CaptureFixture[str]) -> None:
    """Straight flight, 0.25 m apart at samples, 0.2 m needed: 0.15 m of relative way from the middle in 0.05 s."""
    straight = ("order=2", "a_max=0", "theta_inverse=1", "T_c=0.1", "T_s=0.1", "d_min=0.2", "v_norm=1", "v_max=100")
    words = [word for change in straight for word in ("--set", change)]
    code, printed = _run(capsys, "--solve-for", "v_norm", *words)
    assert code == 0
    value = re.search(r"largest v_norm with the corrected \(26\) certified: ([0-9.]+)", printed)
    assert value is not None
    assert 1.5 * (1 - 2e-4) <= float(value[1]) <= 1.5


@pytest.mark.deep
def test_a_kind_with_a_norm_of_its_own_is_not_kept_in_the_box_of_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A box that nobody gave follows the norm of the kind: the fast ones fly 2 m/s along an axis, not 0.5."""
    path, document = tmp_path / "kinds.toml", tmp_path / "kinds.json"
    lines = ["order = 2", "T_c = 0.05", "v_norm = 0.5", "a_norm = 1", "theta_inverse = 1", "[[kinds]]", 'name = "slow"']
    path.write_text("\n".join([*lines, "[[kinds]]", 'name = "fast"', "v_norm = 2", ""]))
    _run(capsys, str(path), "--reading", "whole-motion", "--json", str(document))
    pairs = {tuple(pair["kinds"]): pair for pair in json.loads(document.read_text())["pairs"]}
    assert pairs["fast", "fast"]["parameters"]["v_max"] == [2.0] * 3
    # head on, in a straight line, by hand: 0.25 - sqrt(0.25² - 0.1²)
    assert pairs["fast", "fast"]["dip"]["upper"] > 0.0208
