"""Files and folders that cannot be: every option of every command that names one, with everything that can stand there.

Whatever it is: one sentence, exit code 2, no traceback, and nothing that is there is changed.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from swarmproof.cli import main
from swarmproof.exit_codes import ExitCode
from swarmproof.files import reading

#: What reads a file, as a command line in which FILE is the file.
READERS = {
    "fly": ["fly", "FILE"],
    "script": ["fly", "crossing", "--loss", "script:FILE"],
    "margin": ["margin", "FILE"],
    "check": ["margin", "--check", "FILE"],
    "replay": ["replay", "FILE"],
}


def _bytes(content: bytes) -> Callable[[Path], object]:
    return lambda path: path.write_bytes(content)


def _sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(3 << 30)


def _link_to(target: str) -> Callable[[Path], object]:
    return lambda path: path.symlink_to(target)


#: What can stand where a file should be read.
UNREADABLE: dict[str, Callable[[Path], object]] = {
    "missing": lambda path: None,
    "folder": lambda path: path.mkdir(),
    "pipe": lambda path: os.mkfifo(path),
    "zeros-without-end": _link_to("/dev/zero"),
    "null": _link_to("/dev/null"),
    "loop": lambda path: path.symlink_to(path),
    "dangling": _link_to("nowhere"),
    "three-gigabytes": _sparse,
    "empty": _bytes(b""),
    "mark-of-byte-order": _bytes(b"\xef\xbb\xbf"),
    "utf-16": _bytes("rounds = 60".encode("utf-16")),
    "binary": _bytes(bytes(range(256))),
    "zeros": _bytes(b"\0" * 1000),
    "deep-lists": _bytes(b"[" * 100_000),
    "deep-objects": _bytes(b'{"a":' * 100_000),
    "dots": _bytes(b"a" + b".a" * 20_000 + b" = 1\n"),
    "digits": _bytes(b"a = " + b"9" * 1_000_000),
    "not-a-number": _bytes(b'{"schema": NaN, "rounds": Infinity}'),
    "a-list": _bytes(b"[]"),
    "null-json": _bytes(b"null"),
    "escape-codes": _bytes(b"\x1b[31m\x1b]0;title\x07 = 1\n"),
    "cut": _bytes(b'{"schema": "swarmproof.trace/1", "uavs": 2'),
    "another-schema": _bytes(b'{"schema": "swarmproof.flight/1"}'),
}

#: What writes a file, as a command line in which FILE is the file.
WRITERS = {
    "verify-json": ["verify", "--cus", "1", "--json", "FILE"],
    "verify-report": ["verify", "--cus", "1", "--report", "FILE"],
    "matrix-json": ["verify", "--matrix", "--uavs", "2", "--cus", "1", "--json", "FILE"],
    "matrix-report": ["verify", "--matrix", "--uavs", "2", "--cus", "1", "--report", "FILE"],
    "fly-json": ["fly", "crossing", "--json", "FILE"],
    "fly-positions": ["fly", "crossing", "--positions", "FILE.csv"],
    "fly-report": ["fly", "crossing", "--report", "FILE"],
    "patterns-report": ["fly", "crossing", "--loss", "exhaustive:1", "--report", "FILE"],
    "margin-json": ["margin", "--json", "FILE"],
    "margin-certificate": ["margin", "--certificate", "FILE"],
    "margin-plot": ["margin", "--plot", "FILE.svg"],
    "margin-results": ["margin", "--sweep", "T_c=0.05:0.1", "--results", "FILE"],
    "audit-json": ["audit", "--json", "FILE"],
    "audit-report": ["audit", "--report", "FILE"],
    "reproduce-json": ["reproduce", "fig4", "--quick", "--json", "FILE"],
    "reproduce-report": ["reproduce", "fig4", "--quick", "--report", "FILE"],
    "reproduce-results": ["reproduce", "fig4", "--quick", "--results", "FILE"],
}
#: Names that cannot be written, whether as a file or as a folder.
UNWRITABLE = {
    "below-a-file": "{folder}/file/below",
    "far-below-a-file": "{folder}/file/below/and/below",
    "below-a-device": "/dev/null/below",
    "long": "{folder}/" + "x" * 300,
    "nul": "{folder}/a\0b",
    "below-a-loop": "{folder}/loop/below",
    "of-the-system": "/proc/below",
}


def refused(capsys: pytest.CaptureFixture[str], command: list[str], name: str) -> str:
    """Run what cannot be, and return its sentence."""
    code = main([word.replace("FILE", name) for word in command])
    captured = capsys.readouterr()
    assert code == ExitCode.BAD_INPUT, captured
    assert captured.out == ""
    assert captured.err.startswith("swarmproof: ")
    assert captured.err.count("\n") == 1
    assert "Traceback" not in captured.err
    assert "\x1b" not in captured.err
    assert len(captured.err) < 2000
    return captured.err


def content(folder: Path) -> dict[str, object]:
    """Return what is in a folder, without following links."""
    return {
        str(path.relative_to(folder)): (path.lstat().st_mode, path.lstat().st_size, path.lstat().st_mtime_ns)
        for path in sorted(folder.rglob("*"))
    }


@pytest.mark.parametrize("what", UNREADABLE)
@pytest.mark.parametrize("reader", READERS)
def test_what_cannot_be_read_is_one_sentence(
    reader: str, what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever stands there in the place of a file, and nothing is changed."""
    if (reader, what) in (("margin", "null"), ("margin", "empty"), ("margin", "mark-of-byte-order")):
        pytest.skip("an empty file of parameters changes none, which is right")
    if (reader, what) in (("check", "not-a-number"), ("check", "another-schema")):
        pytest.skip("a document with a schema is a certificate that is rejected: exit code 1")
    monkeypatch.setattr(reading, "PATIENCE_S", 0.01)
    path = tmp_path / "input.toml"
    UNREADABLE[what](path)
    before = content(tmp_path)
    refused(capsys, READERS[reader], str(path))
    assert content(tmp_path) == before


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("name", ["x" * 300, "a\0b", "/dev/null/below", "/proc/self/mem"], ids=repr)
def test_names_that_cannot_be_read_are_one_sentence(reader: str, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Names that are no file's."""
    refused(capsys, READERS[reader], name)


@pytest.mark.parametrize("reader", READERS)
def test_a_file_without_permission_is_one_sentence(
    reader: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file that this user may not read."""
    path = tmp_path / "input.toml"
    path.write_text("rounds = 60\n")
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("this user may read everything")
    assert "Permission denied" in refused(capsys, READERS[reader], str(path))


@pytest.mark.parametrize("where", UNWRITABLE)
@pytest.mark.parametrize("writer", WRITERS)
def test_what_cannot_be_written_is_refused_before(
    writer: str, where: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before anything is computed, and nothing is made on the way that is not needed."""
    (tmp_path / "file").write_text("mine")
    (tmp_path / "loop").symlink_to("loop")
    before = content(tmp_path)
    refused(capsys, WRITERS[writer], UNWRITABLE[where].format(folder=tmp_path))
    assert content(tmp_path) == before


@pytest.mark.parametrize("writer", WRITERS)
def test_a_file_for_a_folder_and_a_folder_for_a_file_are_refused(
    writer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each in the place of the other, and it stays as it is."""
    is_folder = writer.endswith(("report", "results"))
    for suffix in ("", ".csv", ".svg"):
        path = tmp_path / f"there{suffix}"
        path.write_text("mine") if is_folder else path.mkdir()
    before = content(tmp_path)
    refused(capsys, WRITERS[writer], str(tmp_path / "there"))
    assert content(tmp_path) == before
