"""Writing a file: whole or as it was, whatever stands there and whatever goes wrong."""

from __future__ import annotations

import errno
import os
import stat
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from swarmproof.errors import Failed
from swarmproof.files import writing
from swarmproof.files.writing import write


def no_nameless(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the file system have no files without a name."""
    real = os.open

    def refuse(path: str, flags: int, mode: int = 0o777, **more: int) -> int:
        if flags & os.O_TMPFILE == os.O_TMPFILE:
            raise OSError(errno.EOPNOTSUPP, "not supported")
        return real(path, flags, mode, **more)

    monkeypatch.setattr(os, "open", refuse)


@pytest.mark.parametrize("nameless", [True, False], ids=["nameless", "named"])
@pytest.mark.parametrize("before", [None, "older, and longer than the new one"], ids=["new", "old"])
def test_a_file_is_written(tmp_path: Path, before: str | None, nameless: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """The content is there, as UTF-8, and nothing else is in the folder."""
    path = tmp_path / "file"
    if before is not None:
        path.write_text(before)
    if not nameless:
        no_nameless(monkeypatch)
    write(path, "Δ\n")
    assert path.read_bytes() == "Δ\n".encode()
    assert [one.name for one in tmp_path.iterdir()] == ["file"]


def test_a_new_file_has_the_usual_mode_and_an_old_one_keeps_its_own(tmp_path: Path) -> None:
    """Who may read a file does not depend on how it is written."""
    usual = tmp_path / "usual"
    usual.touch()
    new, old = tmp_path / "new", tmp_path / "old"
    old.touch()
    old.chmod(0o640)
    write(new, b"x")
    write(old, b"x")
    assert stat.S_IMODE(new.stat().st_mode) == stat.S_IMODE(usual.stat().st_mode)
    assert stat.S_IMODE(old.stat().st_mode) == 0o640


def test_what_a_link_points_to_is_written(tmp_path: Path) -> None:
    """A symbolic link stays one."""
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    write(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


@pytest.mark.parametrize("nameless", [True, False], ids=["nameless", "named"])
@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()], ids=repr)
def test_a_failure_leaves_the_old_file(
    tmp_path: Path, error: BaseException, nameless: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a full disk, or on Ctrl-C before the end, the old file is as it was and nothing lies beside it."""
    path = tmp_path / "file"
    path.write_text("old")

    def fail(*arguments: object) -> None:
        raise error

    if not nameless:
        no_nameless(monkeypatch)
    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(Failed if isinstance(error, OSError) else KeyboardInterrupt):
        write(path, "new")
    assert path.read_text() == "old"
    assert [one.name for one in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (lambda path: path.mkdir(), "Is a directory"),
        (lambda path: os.mkfifo(path), "No such device or address"),
    ],
    ids=["folder", "pipe-unread"],
)
def test_what_cannot_be_written_is_one_sentence(tmp_path: Path, make: Callable[[Path], None], why: str) -> None:
    """It names the file and the reason, and never waits."""
    path = tmp_path / "there"
    make(path)
    with pytest.raises(Failed, match=f"^{path} cannot be written: {why}$"):
        write(path, "x")


def test_a_missing_folder_and_a_full_device_are_one_sentence(tmp_path: Path) -> None:
    """Neither is a traceback."""
    with pytest.raises(Failed, match="No such file or directory"):
        write(tmp_path / "none" / "file", "x")
    with pytest.raises(Failed, match="No space left on device"):
        write(Path("/dev/full"), "x")


def test_a_pipe_that_is_read_is_written_and_stays(tmp_path: Path) -> None:
    """A pipe is not replaced by a file."""
    path = tmp_path / "pipe"
    os.mkfifo(path)
    read: list[bytes] = []
    reader = threading.Thread(target=lambda: read.append(path.read_bytes()))
    reader.start()
    while True:  # until the reader has opened it
        try:
            write(path, "x" * 100_000)
        except Failed:
            continue
        break
    reader.join()
    assert read == [b"x" * 100_000]
    assert stat.S_ISFIFO(path.stat().st_mode)


def test_an_open_file_by_its_number_is_not_replaced(tmp_path: Path) -> None:
    """`--json /dev/stdout` writes to what standard output is, and does not put another file in its place."""
    path = tmp_path / "out"
    with path.open("wb") as file:
        before = path.stat().st_ino
        write(Path(f"/dev/fd/{file.fileno()}"), "x")
    assert (path.read_bytes(), path.stat().st_ino) == (b"x", before)


def test_a_file_in_a_folder_that_takes_no_new_files_is_written_in_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is then not whole at every moment, but it is written; a folder that takes files is no reason to do so."""
    path = tmp_path / "file"
    path.write_text("old")

    def refuse(*arguments: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(writing, "_give_name", refuse)
    monkeypatch.setattr(writing, "_write_aside", refuse)
    with pytest.raises(Failed, match="Permission denied"):
        write(path, "new")
    monkeypatch.setattr(os, "access", lambda folder, mode: folder != tmp_path)
    write(path, "new")
    assert path.read_text() == "new"


def test_a_name_that_is_no_text_becomes_an_escape(tmp_path: Path) -> None:
    """A file's name may have bytes that are no UTF-8; in JSON, their escape is the same name."""
    write(tmp_path / "file", '"\udc80"')
    assert (tmp_path / "file").read_bytes() == b'"\\udc80"'


def test_long_names_are_written(tmp_path: Path) -> None:
    """A name as long as the file system takes can be written, and the names in between are different."""
    names = ["鳥" * 84 + end for end in ("a", "b")]
    for name in names:
        write(tmp_path / name, name)
        write(tmp_path / name, name)
    assert [(tmp_path / name).read_text() for name in names] == names
    assert len({writing._aside(tmp_path / name) for name in names}) == 2


def test_what_a_kill_left_is_cleaned_up_and_a_race_ends_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The one name that a kill can leave is taken over; whoever loses a race for it tries again."""
    path = tmp_path / "file"
    writing._aside(path).write_text("of a run that was killed")
    write(path, "new")
    assert [one.name for one in tmp_path.iterdir()] == ["file"]
    real, lost = os.replace, 3

    def race(aside: Path, to: Path) -> None:
        nonlocal lost
        if lost:
            lost -= 1
            aside.unlink()
        real(aside, to)

    monkeypatch.setattr(os, "replace", race)
    write(path, "newer")
    assert path.read_text() == "newer"
    lost = 10**6
    with pytest.raises(Failed, match="other processes write it all the time"):
        write(path, "newest")
    assert path.read_text() == "newer"
