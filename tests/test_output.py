"""Reports: whole or old, one run at a time, and nothing of an earlier one; results are told in every way that works."""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from swarmproof import interrupts
from swarmproof.errors import BadInput, Failed
from swarmproof.output import LISTED, ReportFolder, deliver, reserve_file, reserve_folder, write_json


def report(folder: Path, files: dict[str, str]) -> None:
    """Write a report."""
    with ReportFolder(folder) as written:
        for name, content in files.items():
            written.put(name, content)
        written.publish()


def content(folder: Path) -> dict[str, str]:
    """Return all files of a folder but the list of those that are ours."""
    return {
        str(path.relative_to(folder)): path.read_text()
        for path in folder.rglob("*")
        if path.is_file() and path.name != LISTED
    }


OLD = {"index.html": "old", "lemma-1.html": "old", "row/verdicts.json": "old", "row/a.trace.json": "old"}
NEW = {"index.html": "new", "lemma-2.html": "new", "other/index.html": "new"}


def test_a_report_replaces_an_earlier_one_and_nothing_else(tmp_path: Path) -> None:
    """What the earlier one wrote is gone, also its folders; what the user wrote stays."""
    folder = tmp_path / "a" / "b"
    report(folder, OLD)
    (folder / "notes.html").write_text("mine")
    report(folder, NEW)
    assert content(folder) == {**NEW, "notes.html": "mine"}
    assert not (folder / "row").exists()
    assert json.loads((folder / LISTED).read_text())["files"] == sorted(NEW)
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        [LISTED, "index.html", "lemma-2.html", "notes.html", "other"]
    )


def test_until_it_is_published_the_old_report_is_whole(tmp_path: Path) -> None:
    """A run that fails, or is interrupted, before the end changes nothing."""
    report(tmp_path, OLD)
    with ReportFolder(tmp_path) as written:
        written.put("index.html", "new")
    assert content(tmp_path) == OLD


def test_a_full_disk_leaves_the_old_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All is staged before anything is put in place, and a stage that fails is removed."""
    report(tmp_path, OLD)
    real = Path.write_bytes

    def full(self: Path, data: bytes) -> int:
        if self.name == "lemma-2.html":
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(self, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(Failed, match=f"^the report in {tmp_path} cannot be written: No space left on device$"):
        report(tmp_path, NEW)
    assert content(tmp_path) == OLD


class _Killed(BaseException):
    """The end of the process, at once."""


@pytest.mark.parametrize("steps", range(30))
def test_whenever_it_is_killed_no_index_stands_beside_other_files(
    tmp_path: Path, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed after any number of steps: old, or new, or without an index; the next run makes it whole."""
    report(tmp_path, OLD)
    left = steps

    def counted(real: Callable[..., object]) -> Callable[..., object]:
        def step(*arguments: object, **more: object) -> object:
            nonlocal left
            if left <= 0:
                raise _Killed
            left -= 1
            return real(*arguments, **more)

        return step

    with monkeypatch.context() as patched:
        for owner, name in ((os, "replace"), (Path, "unlink"), (Path, "write_bytes"), (os, "link"), (Path, "rmdir")):
            patched.setattr(owner, name, counted(getattr(owner, name)))
        patched.setattr(shutil, "rmtree", lambda *arguments, **more: None)  # a kill cleans nothing up
        try:
            report(tmp_path, NEW)
            done = True
        except _Killed:
            done = False
    found = {name: text for name, text in content(tmp_path).items() if not name.startswith(".swarmproof-stage")}
    if done:
        assert found == NEW
    elif "index.html" in found:
        assert found in (OLD, NEW)
    if "row/verdicts.json" in found:
        assert found["row/a.trace.json"] == "old"
    report(tmp_path, NEW)
    assert content(tmp_path) == NEW


def test_enough_kills_were_tried(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The test before goes to the end: the last of its kills comes after the last step."""
    report(tmp_path, OLD)
    steps = 0

    def counted(real: Callable[..., object]) -> Callable[..., object]:
        def step(*arguments: object, **more: object) -> object:
            nonlocal steps
            steps += 1
            return real(*arguments, **more)

        return step

    for owner, name in ((os, "replace"), (Path, "unlink"), (Path, "write_bytes"), (os, "link"), (Path, "rmdir")):
        monkeypatch.setattr(owner, name, counted(getattr(owner, name)))
    report(tmp_path, NEW)
    assert 10 < steps < 30


def test_two_runs_into_one_folder(tmp_path: Path) -> None:
    """The second refuses in one sentence while the first runs, and not afterwards."""
    with ReportFolder(tmp_path), pytest.raises(BadInput, match="another run of swarmproof is writing to"):
        ReportFolder(tmp_path)
    report(tmp_path, NEW)
    assert content(tmp_path) == NEW


@pytest.mark.parametrize(
    "listed",
    ['{"files": ["../mine"]}', '{"files": ["/etc/mine", 3, ""]}', '{"files": "mine"}', "[" * 100_000, "", "\0"],
    ids=["outside", "absolute", "text", "deep", "empty", "binary"],
)
def test_a_list_that_is_not_ours_removes_nothing(tmp_path: Path, listed: str) -> None:
    """Whoever alters the list of our files cannot make us remove others."""
    folder = tmp_path / "report"
    report(folder, OLD)
    (tmp_path / "mine").write_text("mine")
    (folder / "mine").write_text("mine")
    (folder / LISTED).write_text(listed)
    report(folder, NEW)
    assert (tmp_path / "mine").read_text() == (folder / "mine").read_text() == "mine"
    assert content(folder).items() >= NEW.items()


def test_an_interrupt_waits_until_the_report_is_in_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C in the middle of putting files in place comes after it."""
    report(tmp_path, OLD)
    real = os.replace

    def interrupted(*arguments: str) -> None:
        if Path(arguments[1]) == tmp_path / "lemma-2.html":
            os.kill(os.getpid(), signal.SIGINT)
        real(*arguments)

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        report(tmp_path, NEW)
    assert content(tmp_path) == NEW


def test_term_is_an_interrupt() -> None:
    """The signal TERM ends what is being done as Ctrl-C does; afterwards, signals are as they were."""
    before = signal.getsignal(signal.SIGTERM)
    with interrupts.handled():
        interrupts.from_now_on()
        with pytest.raises(interrupts.Terminated):
            os.kill(os.getpid(), signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) is before


def test_where_one_way_fails_the_others_are_tried() -> None:
    """Nothing that was found is lost because one file cannot be written; all failures are told."""
    told: list[str] = []

    def fail() -> None:
        raise Failed("no")

    def fail_too() -> None:
        raise Failed("not either")

    with pytest.raises(Failed, match=r"^no; not either$"):
        deliver(fail, lambda: told.append("first"), fail_too, lambda: told.append("last"))
    assert told == ["first", "last"]

    def crash() -> None:
        raise ZeroDivisionError("0")

    with pytest.raises(ZeroDivisionError):
        deliver(fail, crash, lambda: told.append("after the crash"))
    assert told[-1] == "after the crash"


@pytest.mark.parametrize("name", ["file/below", "folder", "loop", "\0", "x" * 300])
def test_what_cannot_be_written_is_refused_before(tmp_path: Path, name: str) -> None:
    """Before anything is computed, in one sentence that says what would be right, and nothing is left behind."""
    (tmp_path / "file").write_text("mine")
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    before = sorted(tmp_path.iterdir())
    with pytest.raises(BadInput, match=r"^cannot write .*such as out\.json$"):
        reserve_file(f"{tmp_path}/{name}")
    if name != "folder":
        with pytest.raises(BadInput, match=r"^cannot write to .*such as out$"):
            reserve_folder(Path(f"{tmp_path}/{name}"))
    assert sorted(tmp_path.iterdir()) == before


def test_reserving_changes_nothing(tmp_path: Path) -> None:
    """An old file keeps its content, a new one is not made yet, and a pipe is not opened."""
    (tmp_path / "old").write_text("mine")
    os.mkfifo(tmp_path / "pipe")
    for name in ("old", "new", "pipe"):
        reserve_file(tmp_path / name)
    reserve_file("-")
    reserve_file(None)
    assert (tmp_path / "old").read_text() == "mine"
    assert not (tmp_path / "new").exists()


def test_json_is_written_where_it_is_wanted(tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    """Nowhere, to a file, or to standard output as UTF-8."""
    write_json(None, "{}")
    write_json(str(tmp_path / "file"), '"Δ"')
    write_json("-", '"Δ"')
    assert (tmp_path / "file").read_bytes() == capfdbinary.readouterr().out == '"Δ"'.encode()


class _Interrupting:
    """Something that is interrupted where Python can raise nothing: as it is forgotten."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)


def _forget_and_wait() -> None:
    forgotten = [_Interrupting()]
    forgotten.clear()
    while True:
        time.sleep(0.01)


def test_an_interrupt_while_python_runs_a_text_does_not_take_the_exit_code(tmp_path: Path) -> None:
    """With `python -m`, the exit code is the one that is given, also if Ctrl-C came while a named tuple was made."""
    (tmp_path / "program.py").write_text(
        "import sys\n"
        "from swarmproof import interrupts\n"
        "with interrupts.handled():\n"
        "    try:\n"
        "        exec('raise KeyboardInterrupt')\n"
        "    except KeyboardInterrupt:\n"
        "        pass\n"
        "sys.exit(3)\n"
    )
    ended = subprocess.run([sys.executable, "-m", "program"], cwd=tmp_path, check=False)
    assert ended.returncode == 3


def test_an_interrupt_that_python_ignores_comes_again(capsys: pytest.CaptureFixture[str]) -> None:
    """Ctrl-C in a destructor is neither lost nor a traceback."""
    with interrupts.handled():
        interrupts.from_now_on()
        with pytest.raises(KeyboardInterrupt):
            _forget_and_wait()
    assert capsys.readouterr().err == ""
