"""Runs that are killed at any moment: nothing half written, nobody left behind, and a later run as always.

The moments are shares of how long an undisturbed run takes, so that they do not depend on the machine.
"""

from __future__ import annotations

import json
import os
import random
import re
import signal
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest
from tests.hostile.processes import MARK, PROGRAM, environment, left_of, started
from tests.pages.test_pages import Page

from swarmproof.exit_codes import ExitCode
from swarmproof.output import LISTED

pytestmark = pytest.mark.hostile

#: Flies six small cells in two processes, as `reproduce` does: the real experiments take minutes.
REPRODUCE = """
import sys
import swarmproof.__main__  # which makes signals those of the program
from swarmproof.cli import main
from swarmproof.commands import reproduce as command
from swarmproof.campaign import decide
from tests.commands.test_reproduce import CLAIMS, observing, small
if __name__ == "__main__":
    command.EXPERIMENTS = {"fig4": small(observing())}
    decide.claims_of = lambda name: CLAIMS
    sys.exit(main(["reproduce", "fig4", "--processes", "2", "--results", "results"]))
"""
QUICK = ["--set", "order=2", "--set", "T_s=0.05", "--set", "T_c=0.05"]
RUNS: dict[str, list[str]] = {
    "verify": [*PROGRAM, "verify", "--semantics", "ignore-loss", "--report", "report"],
    "matrix": [*PROGRAM, "verify", "--matrix", "--uavs", "2", "--cus", "1", "--report", "report"],
    "fly": [
        *PROGRAM,
        "fly",
        "crossing",
        "--rounds",
        "30",
        "--loss",
        "iid:0.1",
        "--report",
        "report",
        "--json",
        "f.json",
    ],
    "margin": [*PROGRAM, "margin", *QUICK, "--sweep", "v_max=0.5:1:1.5:2", "--results", "results"],
    "reproduce": [sys.executable, "-c", REPRODUCE],
}
SIGNALS = {"KILL": signal.SIGKILL, "TERM": signal.SIGTERM, "INT": signal.SIGINT}
#: For each run, eight kills: the signal, and a share of the undisturbed time; the last ones come while it is written.
CHANCE = random.Random(14)
KILLS = [
    (run, name, round(share, 3))
    for run in RUNS
    for name, share in zip(
        ["KILL", "TERM", "INT", "KILL", "TERM", "INT", "KILL", "KILL"],
        [*(CHANCE.uniform(0.15, 0.85) for _ in range(5)), *(CHANCE.uniform(0.8, 1.02) for _ in range(3))],
        strict=True,
    )
]


@dataclass(frozen=True)
class Undisturbed:
    """A run that nobody killed: how long it took, its exit code, and the files that it wrote."""

    seconds: float
    code: int
    files: Mapping[str, object]


def files_of(folder: Path) -> dict[str, object]:
    """Return the content of all files, without what says how long something took."""
    found: dict[str, object] = {}
    for path in sorted(folder.rglob("*")):
        if not path.is_file():
            continue
        name = str(path.relative_to(folder))
        found[name] = _timeless(json.loads(path.read_bytes())) if path.suffix == ".json" else path.read_bytes()
        if path.name == "index.html" and isinstance(text := found[name], bytes):
            found[name] = re.sub(rb"<td>\d+\.\d( s)?</td>", b"<td>(time)</td>", text)
    return found


def _timeless(value: object) -> object:
    if isinstance(value, dict):
        # the digest of a stored result is over its time, too
        return {key: _timeless(one) for key, one in value.items() if key not in ("seconds", "digest")}
    return [_timeless(one) for one in value] if isinstance(value, list) else value


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Undisturbed]:
    """Return what each run does when nobody kills it, as far as it was asked for."""
    return {}


def run_whole(name: str, folder: Path) -> Undisturbed:
    """Run it to its end."""
    begin = time.monotonic()
    code = started(RUNS[name], folder).wait()
    return Undisturbed(time.monotonic() - begin, code, files_of(folder))


def assert_whole_or_old(folder: Path) -> None:
    """Assert that no index stands beside files of another run, and that nothing half written has a name of its own."""
    report = folder / "report"
    for path in folder.rglob("*"):
        assert path.suffix != ".part", path
        if path.suffix == ".json" and ".swarmproof-stage" not in path.parts:
            json.loads(path.read_bytes())
    if (report / "index.html").exists():
        listed = json.loads((report / LISTED).read_bytes())["files"]
        assert all((report / name).is_file() for name in listed)
        links = [given["href"] for given in Page((report / "index.html").read_text()).all("a")]
        assert all((report / link).is_file() for link in links if not link.startswith("#"))


@pytest.mark.parametrize(("name", "kill", "share"), KILLS, ids=lambda value: str(value))
def test_a_killed_run_leaves_nothing_behind(
    name: str, kill: str, share: float, tmp_path: Path, undisturbed: dict[str, Undisturbed]
) -> None:
    """No process after five seconds, no traceback, whole or old files; and a later run gives what it always gives."""
    if name not in undisturbed:
        (tmp_path / "whole").mkdir()
        undisturbed[name] = run_whole(name, tmp_path / "whole")
    whole = undisturbed[name]
    assert whole.files
    folder = tmp_path / "killed"
    folder.mkdir()
    program = started(RUNS[name], folder)
    mark = mark_of(program.pid)
    try:
        program.wait(share * whole.seconds)
    except Exception:
        # as a terminal does, and a system that has no memory left
        os.killpg(program.pid, SIGNALS[kill]) if kill == "INT" else program.send_signal(SIGNALS[kill])
    code = program.wait()
    deadline = time.monotonic() + 5
    while left_of(mark) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert left_of(mark) == []
    said = (tmp_path / "killed.err").read_text() + (tmp_path / "killed.out").read_text()
    assert "Traceback" not in said, said
    assert code in (-signal.SIGKILL, whole.code, *(ExitCode(one) for one in (1, 3, 130, 143))), said
    assert kill == "KILL" or code != -signal.SIGKILL
    assert_whole_or_old(folder)
    again = run_whole(name, folder)
    assert again.code == whole.code
    assert again.files == whole.files


def mark_of(pid: int) -> str:
    """Return the mark of a run by its first process, once that has its own environment."""
    while True:
        found = re.search(rf"{MARK}=(\w+)".encode(), Path(f"/proc/{pid}/environ").read_bytes())
        if found is not None:
            return found[1].decode()


def test_a_worker_that_is_killed_costs_one_sentence(tmp_path: Path) -> None:
    """The matrix is complete all the same, and its exit code the usual one."""
    folder = tmp_path / "work"
    folder.mkdir()
    program = started(RUNS["matrix"], folder)
    mark = mark_of(program.pid)
    killed = False
    while not killed and program.poll() is None:
        for pid in left_of(mark):
            try:
                command = Path(f"/proc/{pid}/cmdline").read_bytes()
            except OSError:
                continue
            if b"spawn_main" in command:
                os.kill(pid, signal.SIGKILL)
                killed = True
                break
    assert program.wait() == ExitCode.WELL
    assert killed
    said = (tmp_path / "work.err").read_text()
    assert said.count("ended from outside") == 1
    assert said.count("\n") == 1
    assert "4 of 4 configurations verified" in " ".join((tmp_path / "work.out").read_text().split())
    assert environment({})[MARK] != mark
