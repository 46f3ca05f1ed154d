"""The documents say what the program does: tables, commands and links are compared with it."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from tests.dmpc_swarm.verdict_table import render

from swarmproof.cli import main
from swarmproof.dmpc_swarm.semantics import PRESETS, SWITCHES
from swarmproof.exit_codes import ExitCode
from swarmproof.options.parser import COMMANDS, parser

ROOT = Path(__file__).parent.parent
DOCUMENTS = [ROOT / name for name in ("README.md", "ARCHITECTURE.md", "CHANGELOG.md")] + sorted(ROOT.glob("docs/*.md"))


def test_verdict_table_is_the_recorded_one() -> None:
    """The verdicts in docs/semantics.md are those of the matrix (`tests/dmpc_swarm/verdict_table.py` prints them)."""
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


def test_readme_transcript_is_real(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What README.md shows of `swarmproof verify` is what it prints, but for the seconds."""
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.chdir(tmp_path)
    main(["verify", "--report", "report"])
    printed = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    text = (ROOT / "README.md").read_text()
    shown = text.split("    $ swarmproof verify --report report\n", 1)[1].split("\n\n", 1)[0]

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


def commands_shown(text: str) -> list[list[str]]:
    """Return the command lines that a reader can type, in their order: in tables and in transcripts."""
    found = re.findall(r"^(?:    \$ |\|[^|]*\| `)(swarmproof [^`\n]+)", text, re.MULTILINE)
    return [shlex.split(command, comments=True)[1:] for command in found]


@pytest.mark.deep
def test_every_command_of_the_readme_works_in_the_order_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A newcomer who types what README.md shows, from top to bottom, is never told that something is missing."""
    monkeypatch.chdir(tmp_path)
    commands = commands_shown((ROOT / "README.md").read_text())
    assert len(commands) >= 10
    assert {words[0] for words in commands} == set(COMMANDS)
    for words in commands:
        assert main(words) in (ExitCode.WELL, ExitCode.VIOLATED, ExitCode.UNDECIDED), words


@pytest.mark.parametrize(
    "command", [pytest.param(name, marks=[pytest.mark.deep] if name == "reproduce" else []) for name in COMMANDS]
)
def test_the_example_of_every_help_works(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`--help` shows an example, which is said as it can be typed, and gives a verdict."""
    assert main([command, "--help"]) == ExitCode.WELL
    _, example = capsys.readouterr().out.split("\nExample:\n")
    monkeypatch.chdir(tmp_path)
    for part in example.split(" && "):
        assert main(shlex.split(part)[1:]) in (ExitCode.WELL, ExitCode.VIOLATED, ExitCode.UNDECIDED)
