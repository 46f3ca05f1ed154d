"""docs/your-protocol.md is true: its code is in the source, and its commands find what it says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from swarmproof.cli import main

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "your-protocol.md").read_text(encoding="utf-8")
SOURCES = [
    path for folder in ("spec", "model", "checks") for path in (ROOT / folder / "swarmproof/heartbeat").glob("*.py")
]
#: The most lines of the protocol itself, and of the whole system.
MOST_LINES, MOST_OF_ALL = 150, 250


def test_all_its_code_is_in_the_source() -> None:
    """Each piece of code stands in a module of the system as it is shown."""
    shown = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    sources = [path.read_text(encoding="utf-8") for path in SOURCES]
    assert len(shown) > 5
    for code in shown:
        assert any(code in source for source in sources), code


def test_its_commands_find_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Typed from top to bottom, they find two leaders, a lease that holds, and one that never finds a leader again."""
    monkeypatch.chdir(tmp_path)
    commands = [shlex.split(line)[1:] for line in re.findall(r"^    \$ (swarmproof .*)$", TEXT, re.MULTILINE)]
    said = []
    for words in commands:
        code = main(words)
        said.append((code, " ".join(capsys.readouterr().out.split())))
    assert [code for code, _ in said] == [1, 0, 1, 1]
    assert "one-leader violated 2 rounds, 2 lost" in said[0][1]
    assert "one-leader holds" in said[1][1]
    assert "one-leads violated loop after 3 rounds, 5 lost, inevitable" in said[2][1]
    assert "one-leads is violated" in said[3][1]


def test_it_is_small() -> None:
    """The protocol has at most 150 lines; with its claims, its switches and its system, 250."""
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in SOURCES}
    assert max(lines.values()) <= MOST_LINES
    assert sum(lines.values()) <= MOST_OF_ALL
