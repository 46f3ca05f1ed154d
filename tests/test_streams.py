"""Standard streams: every encoding shows what was found, and no two verdicts look alike in any."""

from __future__ import annotations

import ast
import io
import sys
import unicodedata
from pathlib import Path

import pytest

from swarmproof import streams, terminal
from swarmproof.cli import main
from swarmproof.errors import Failed
from swarmproof.exit_codes import ExitCode
from swarmproof.options import parser

SOURCES = [path for root in ("spec", "model", "checks", "reports") for path in Path(root).rglob("*.py")]


def our_letters() -> set[str]:
    """Return all letters in texts of the sources that are not ASCII, but in docstrings."""
    letters: set[str] = set()
    for path in SOURCES:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        docstrings = {
            id(node.body[0].value)
            for node in ast.walk(tree)
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))
            and node.body
            and isinstance(node.body[0], ast.Expr)
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
                letters.update(letter for letter in node.value if not letter.isascii())
    return letters


def test_every_letter_of_ours_has_a_substitute() -> None:
    """In ASCII, none of our letters becomes an escape or a question mark, which would be a verdict."""
    assert len(SOURCES) > 100
    letters = our_letters()
    assert {"Δ", "✓", "✗", "d̂"[1]} <= letters
    for letter in sorted(letters):
        plain, _ = streams.substitute(UnicodeEncodeError("ascii", letter, 0, 1, "no"))
        assert plain.isascii()
        assert "\\" not in plain, (letter, unicodedata.name(letter))
        assert "?" not in plain


def test_signs_of_verdicts_stay_different() -> None:
    """The matrix's four signs are four signs in every encoding."""
    signs = [sign.encode("ascii", streams.HANDLER).decode() for sign in "✓✗?-"]
    assert len(set(signs)) == 4


def test_what_is_none_of_ours_is_an_escape() -> None:
    """A letter that a user gave, or a byte of a name that is no text, is shown as an escape."""
    assert "鳥\udc80".encode("ascii", streams.HANDLER) == b"\\u9ce5\\udc80"
    assert "\udc80".encode("utf-8", streams.HANDLER) == b"\\udc80"


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "latin-1", "utf-8"])
def test_a_verdict_can_be_told_in_every_encoding(encoding: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Text fits the encoding; JSON is UTF-8 in all of them."""
    for arguments, is_json in (
        (["verify", "--cus", "1"], False),
        (["audit", "--claim", "lemma-3", "--json", "-"], True),
    ):
        raw = io.BytesIO()
        monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding=encoding))
        monkeypatch.setattr(sys, "stderr", io.TextIOWrapper(io.BytesIO(), encoding=encoding))
        assert main(arguments) in (ExitCode.WELL, ExitCode.VIOLATED)
        said = raw.getvalue().decode("utf-8" if is_json else encoding)
        assert said.startswith("{") == is_json


class Broken(io.TextIOWrapper):
    """A stream whose reader went away, or whose disk is full."""

    def __init__(self, error: OSError) -> None:
        super().__init__(io.BytesIO(), encoding="utf-8")
        self.error = error

    def write(self, text: str) -> int:
        """Fail."""
        raise self.error

    def flush(self) -> None:
        """Fail, but when the stream is closed."""
        if not self.closed:
            raise self.error

    def close(self) -> None:
        """Forget what could not be written."""


@pytest.mark.parametrize(
    "arguments", [["--version"], ["--help"], ["fly", "--help"], ["claims"], ["verify", "--cus", "1"]], ids=" ".join
)
@pytest.mark.parametrize(
    "error", [BrokenPipeError(32, "Broken pipe"), OSError(28, "No space left on device")], ids=repr
)
def test_an_output_that_cannot_be_written_is_no_verdict(
    arguments: list[str], error: OSError, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It has its own exit code and one sentence, whichever command it is."""
    with monkeypatch.context() as patched:
        patched.setattr(sys, "stdout", Broken(error))
        assert main(arguments) == ExitCode.FAILED
    said = capsys.readouterr().err
    assert said.startswith("swarmproof: ")
    assert said.count("\n") == 1


def test_a_closed_output_is_told_before_anything_is_computed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nobody waits an hour for a verdict that cannot be said."""
    with monkeypatch.context() as patched:
        patched.setattr(sys, "stdout", None)
        patched.setattr(parser, "parse", None)  # which is not reached
        assert main(["verify"]) == ExitCode.FAILED
    assert "standard output is closed" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "code", "sentence"),
    [
        (ZeroDivisionError("0"), ExitCode.DEFECT, "a defect of swarmproof, no verdict"),
        (SystemExit("odd"), ExitCode.DEFECT, "a defect of swarmproof"),
        (RecursionError("deep"), ExitCode.DEFECT, "a defect of swarmproof"),
        (MemoryError(), ExitCode.FAILED, "the memory is not enough"),
        (PermissionError(13, "Permission denied", "/a/b"), ExitCode.FAILED, "Permission denied: /a/b"),
        (Failed("the disk is full"), ExitCode.FAILED, "the disk is full"),
        (KeyboardInterrupt(), ExitCode.INTERRUPTED, "interrupted"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else "",
)
def test_every_end_is_one_sentence_and_its_own_code(
    error: BaseException,
    code: ExitCode,
    sentence: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A crash is never 1, and a traceback is shown only to whoever asks for one."""

    def crash(options: object) -> None:
        raise error

    monkeypatch.setattr(parser, "command_of", lambda options: crash)
    assert main(["claims"]) is code
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
    monkeypatch.setenv("SWARMPROOF_TRACEBACK", "1")
    assert main(["claims"]) is code
    assert ("Traceback" in capsys.readouterr().err) == (code is ExitCode.DEFECT)


def test_a_bar_that_cannot_be_shown_stops_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A terminal that is gone takes no progress; what runs behind it goes on. A verdict is no progress."""

    class Gone(Broken):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(sys, "stderr", Gone(OSError(5, "Input/output error")))
    monkeypatch.setenv("TERM", "xterm")
    done = 0
    with terminal.status("going"):
        done += 1
    with terminal.bar("steps", transient=False) as bar:
        task = bar.add_task("", total=3)
        for _ in range(3):
            bar.update(task, advance=1)
            done += 1
    assert not bar.console.quiet
    assert done == 4
    with pytest.raises(Failed, match="standard error cannot be written"):
        terminal.text("-").print("a verdict")
