"""The program in an unfriendly world: closed and full streams, encodings, folders that are gone, little memory.

`make hostile` runs them all; a few are part of `make test`.
"""

from __future__ import annotations

import json
import re
import resource
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.hostile.processes import PROGRAM, Ended, environment, in_shell, started

from swarmproof.exit_codes import ExitCode

#: Commands that say something, with their usual exit codes.
COMMANDS: dict[str, tuple[list[str], ExitCode]] = {
    "version": (["--version"], ExitCode.WELL),
    "help": (["--help"], ExitCode.WELL),
    "fly-help": (["fly", "--help"], ExitCode.WELL),
    "claims": (["claims"], ExitCode.WELL),
    "verify": (["verify", "--semantics", "ignore-loss"], ExitCode.VIOLATED),
    "matrix": (["verify", "--matrix", "--uavs", "2", "--cus", "1", "--semantics", "guarded"], ExitCode.WELL),
    "fly": (["fly", "crossing", "--rounds", "3"], ExitCode.WELL),
    "margin": (["margin", "--set", "T_c=0.05"], ExitCode.WELL),
    "audit": (["audit", "--claim", "lemma-3"], ExitCode.WELL),
    "replay": (["replay", "trace.json"], ExitCode.VIOLATED),
}
#: What each line of a shell is to end with; None: as usual.
SHELLS: dict[str, tuple[str, dict[str, str | None], ExitCode | None]] = {
    "closed-output": ("RUN >&-", {}, ExitCode.FAILED),
    "full-output": ("RUN > /dev/full", {}, ExitCode.FAILED),
    "full-output-unbuffered": ("RUN > /dev/full", {"PYTHONUNBUFFERED": "1"}, ExitCode.FAILED),
    "nobody-reads": ("RUN | true", {}, ExitCode.FAILED),
    "closed-error": ("RUN 2>&-", {}, None),
    "full-error": ("RUN 2> /dev/full", {}, None),
    "closed-input": ("RUN <&-", {}, None),
    "all-closed": ("RUN <&- >&- 2>&-", {}, ExitCode.FAILED),
    "ascii": ("RUN", {"PYTHONIOENCODING": "ascii"}, None),
    "cp1252": ("RUN", {"PYTHONIOENCODING": "cp1252"}, None),
    "latin-1": ("RUN", {"PYTHONIOENCODING": "latin-1"}, None),
    "locale-c": ("RUN", {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}, None),
    "no-colour": ("RUN", {"NO_COLOR": "1"}, None),
    "dumb": ("RUN", {"TERM": "dumb", "COLUMNS": "40"}, None),
    "one-column": ("RUN", {"COLUMNS": "1"}, None),
    "no-home": ("RUN", {"HOME": None, "TMPDIR": "/nowhere"}, None),
    "optimised": ("RUN", {"PYTHONOPTIMIZE": "2"}, None),
    "gone": ("mkdir gone; cd gone; rmdir ../gone; RUN", {}, ExitCode.FAILED),
}
#: What `make test` runs of these.
FEW = {("verify", "nobody-reads"), ("help", "full-output"), ("margin", "ascii"), ("fly", "closed-output")}


HOSTILE = pytest.mark.hostile


def cases() -> list[object]:
    """Return each command in each environment; a few are quick enough to be run always."""
    return [
        pytest.param(command, shell, id=f"{command}-{shell}", marks=[] if (command, shell) in FEW else [HOSTILE])
        for command in COMMANDS
        for shell in SHELLS
    ]


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a trace."""
    folder = tmp_path_factory.mktemp("hostile")
    in_shell("RUN > /dev/null", ["verify", "--semantics", "ignore-loss", "--report", "report"], folder)
    (folder / "trace.json").write_bytes((folder / "report" / "lemma-1.trace.json").read_bytes())
    return folder


def assert_no_traceback(ended: Ended) -> None:
    """Assert that neither stream shows one, nor what the interpreter says of errors that it ignores."""
    for said in (ended.err, ended.out.decode(errors="replace")):
        assert "Traceback" not in said
        assert "Exception ignored" not in said
        assert "Error:" not in said


@pytest.mark.parametrize(("command", "shell"), cases())
def test_the_code_is_right_and_no_traceback_is_shown(command: str, shell: str, folder: Path, tmp_path: Path) -> None:
    """Where the output cannot be written, the code is 4 and one sentence says so; else it is the usual one."""
    arguments, usual = COMMANDS[command]
    line, variables, wanted = SHELLS[shell]
    if command in ("version", "help", "fly-help") and shell == "gone":
        wanted = None
    (tmp_path / "trace.json").write_bytes((folder / "trace.json").read_bytes())
    ended = in_shell(line, arguments, tmp_path, **variables)
    if command == "claims" and shell == "nobody-reads" and ended.code == 0:
        wanted = None  # it was quicker than the reader's end
    assert ended.code == (usual if wanted is None else wanted), ended
    assert_no_traceback(ended)
    if wanted is ExitCode.FAILED and shell != "all-closed":
        assert ended.err.startswith("swarmproof: ")
        assert ended.err.count("\n") == 1
    if wanted is None and shell not in ("closed-error", "full-error"):
        assert len(ended.out) > 10
        ended.out.decode(variables.get("PYTHONIOENCODING") or "utf-8")
    if shell in ("no-colour", "dumb"):
        assert b"\x1b" not in ended.out


@pytest.mark.hostile
@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "utf-16"])
@pytest.mark.parametrize("command", ["verify", "matrix", "fly", "margin", "audit"])
def test_json_is_utf_8_in_every_encoding(command: str, encoding: str, tmp_path: Path) -> None:
    """A CI reads the same document whatever its terminal is."""
    arguments, usual = COMMANDS[command]
    ended = in_shell("RUN --json -", arguments, tmp_path, PYTHONIOENCODING=encoding)
    assert ended.code == usual
    assert json.loads(ended.out.decode("utf-8"))["schema"].startswith("swarmproof.")


#: What writes something, and what it writes.
WRITING: dict[str, tuple[list[str], str]] = {
    "verify-json": (["verify", "--semantics", "ignore-loss", "--json", "out/file"], "file"),
    "verify-report": (["verify", "--semantics", "ignore-loss", "--report", "out/report"], "report"),
    "matrix-report": (["verify", "--matrix", "--uavs", "2", "--cus", "1", "--report", "out/report"], "report"),
    "fly-json": (["fly", "crossing", "--rounds", "3", "--json", "out/file"], "file"),
    "fly-positions": (["fly", "crossing", "--rounds", "30", "--positions", "out/file.csv"], "file.csv"),
    "fly-report": (["fly", "crossing", "--rounds", "3", "--report", "out/report"], "report"),
    "margin-certificate": (["margin", "--set", "T_c=0.05", "--certificate", "out/file"], "file"),
    "margin-plot": (["margin", "--set", "T_c=0.05", "--plot", "out/file.svg"], "file.svg"),
    "audit-report": (["audit", "--claim", "lemma-3", "--report", "out/report"], "report"),
}


def _limit(what: int, most: int) -> Callable[[], None]:
    return lambda: resource.setrlimit(what, (most, most))


@pytest.mark.hostile
@pytest.mark.parametrize("name", WRITING)
def test_a_full_disk_leaves_what_was_there(name: str, tmp_path: Path) -> None:
    """Files may have some bytes only: code 4, the verdict is told all the same, and nothing half written is left."""
    arguments, written = WRITING[name]
    out = tmp_path / "work" / "out"
    out.mkdir(parents=True)
    if written == "report":
        (out / written).mkdir()
        (out / written / "index.html").write_text("old")
    else:
        (out / written).write_text("old")
    program = started([*environment_program(), *arguments], tmp_path / "work", _limit(resource.RLIMIT_FSIZE, 1500))
    code = program.wait()
    said = (tmp_path / "work.err").read_text()
    assert code == ExitCode.FAILED, said
    assert re.fullmatch(r"swarmproof: .*(File too large|cannot be written).*\n", said), said
    assert [path.name for path in out.iterdir()] == [written]
    if written == "report":
        assert [path.name for path in (out / written).iterdir()] == ["index.html"]
        assert (out / written / "index.html").read_text() == "old"
    else:
        assert (out / written).read_text() == "old"


def environment_program() -> list[str]:
    """Return the program; its text goes where a limit of bytes does not matter."""
    return ["bash", "-c", 'exec "$@" > /dev/null', "bash", *PROGRAM]


@pytest.mark.hostile
@pytest.mark.parametrize(
    "arguments",
    [["fly", "FILE"], ["margin", "FILE"], ["margin", "--check", "FILE"], ["replay", "FILE"]],
    ids=["fly", "margin", "check", "replay"],
)
@pytest.mark.parametrize("file", ["/dev/zero", "sparse"])
def test_little_memory_is_enough_to_refuse(arguments: list[str], file: str, tmp_path: Path) -> None:
    """A file without end, or of three gigabytes, is refused within a limit of memory."""
    (tmp_path / "work").mkdir()
    with (tmp_path / "work" / "sparse").open("wb") as sparse:
        sparse.truncate(3 << 30)
    words = [word.replace("FILE", file) for word in arguments]
    program = started([*environment_program(), *words], tmp_path / "work", _limit(resource.RLIMIT_AS, 3 << 29))
    assert program.wait() == ExitCode.BAD_INPUT
    assert "too long" in (tmp_path / "work.err").read_text()


@pytest.mark.hostile
def test_two_runs_into_one_folder(tmp_path: Path) -> None:
    """The second is refused while the first runs, and the first is whole."""
    work = tmp_path / "work"
    work.mkdir()
    first = started([*environment_program(), "fly", "circle", "--rounds", "5000", "--report", "report"], work)
    while not (work / "report").exists():
        assert first.poll() is None
    second = subprocess.run(
        [*environment_program(), "fly", "crossing", "--rounds", "1", "--report", "report"],
        cwd=work,
        env=environment({}),
        capture_output=True,
        text=True,
        check=False,
    )
    # the first would fly for minutes: however slow the machine is, it goes on until it is told to end
    assert first.poll() is None
    first.send_signal(signal.SIGINT)
    assert second.returncode == ExitCode.BAD_INPUT
    assert "another run of swarmproof is writing to report" in second.stderr
    assert first.wait() == ExitCode.UNDECIDED
    assert "circle, 16 UAVs" in (work / "report" / "index.html").read_text()
