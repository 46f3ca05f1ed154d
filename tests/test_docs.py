"""The documents say what the program does: tables, commands and links are compared with it."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from tests.verdict_table import render

from swarmproof.cli import main
from swarmproof.options.parser import parser
from swarmproof.semantics.switches import PRESETS, SWITCHES

ROOT = Path(__file__).parent.parent
DOCUMENTS = [ROOT / name for name in ("README.md", "ARCHITECTURE.md", "CHANGELOG.md")] + sorted(ROOT.glob("docs/*.md"))


def test_verdict_table_is_the_recorded_one() -> None:
    """The verdicts in docs/semantics.md are those of the matrix (`python tests/verdict_table.py` prints them)."""
    assert render() in (ROOT / "docs/semantics.md").read_text()


def test_every_switch_is_documented() -> None:
    """docs/semantics.md has a section per switch that names every value, and every preset."""
    text = (ROOT / "docs/semantics.md").read_text()
    for switch, values in SWITCHES.items():
        section = text.split(f"### `{switch}`", 1)[1].split("\n### ", 1)[0]
        for value in values:
            assert f"`{value}`" in section
    for preset in PRESETS:
        assert f"`{preset}`" in text


def test_readme_transcript_is_real(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """What README.md shows of `swarmproof verify` is what it prints, but for the seconds."""
    monkeypatch.setenv("COLUMNS", "100")
    main(["verify"])
    printed = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    shown = (ROOT / "README.md").read_text().split("    $ swarmproof verify\n", 1)[1].split("\n\n", 1)[0]

    def without_seconds(lines: list[str]) -> list[str]:
        return [re.sub(r"\(\d+\.\d s\)", "(s)", line) for line in lines]

    assert without_seconds([line[4:] for line in shown.splitlines()]) == without_seconds(printed)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(document: Path) -> None:
    """Every relative link in the documents leads to a file of the project."""
    for target in re.findall(r"\]\(([^)#]+)\)", document.read_text()):
        if "://" not in target:
            assert (document.parent / target).exists(), target


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_commands_can_be_given(document: Path) -> None:
    """Every `swarmproof ...` command in the documents is one that the command line accepts."""
    text = document.read_text()
    commands = re.findall(r"`(swarmproof [^`]+)`", text) + re.findall(r"^ *\$ (swarmproof .+)$", text, re.MULTILINE)
    for command in commands:
        words = shlex.split(command.replace(" TRACE", " trace.json"))[1:]
        if len(words) == 1:  # a command's name, not a whole command line
            with pytest.raises(SystemExit, match="0"):
                parser().parse_args([*words, "--help"])
        else:
            parser().parse_args(words)
