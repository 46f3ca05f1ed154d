"""Runs the program as a process in an unfriendly world, and says what became of it."""

from __future__ import annotations

import os
import subprocess
import sys
import uuid
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

#: Marks the processes of one run in their environment.
MARK = "SWARMPROOF_HOSTILE_RUN"
PATHS = os.pathsep.join(os.path.abspath(path) for path in sys.path if path)
PROGRAM = [sys.executable, "-m", "swarmproof"]


@dataclass(frozen=True)
class Ended:
    """How a run ended: its exit code (negative: by this signal), and what it said."""

    code: int
    out: bytes
    err: str


def environment(more: Mapping[str, str | None]) -> dict[str, str]:
    """Return the environment of a run; None takes a variable away."""
    base = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    given: dict[str, str | None] = {**base, "PYTHONPATH": PATHS, MARK: uuid.uuid4().hex, **more}
    return {name: value for name, value in given.items() if value is not None}


def in_shell(command: str, arguments: Sequence[str], folder: Path, **more: str | None) -> Ended:
    """Run a line of bash in which RUN is the program with these arguments; a pipe fails as its parts do."""
    line = "set -o pipefail; " + command.replace("RUN", '"$@"')
    ran = subprocess.run(
        ["bash", "-c", line, "bash", *PROGRAM, *arguments],
        cwd=folder,
        env=environment(more),
        capture_output=True,
        check=False,
    )
    return Ended(ran.returncode, ran.stdout, ran.stderr.decode(errors="replace"))


def started(program: Sequence[str], folder: Path, limit: Callable[[], None] | None = None) -> subprocess.Popen[bytes]:
    """Begin a run in a session of its own, with its output in files `out` and `err` beside the folder."""
    with open(f"{folder}.out", "wb") as out, open(f"{folder}.err", "wb") as err:
        return subprocess.Popen(
            program, cwd=folder, env=environment({}), stdout=out, stderr=err, start_new_session=True, preexec_fn=limit
        )


def left_of(mark: str) -> list[int]:
    """Return the processes that still have this mark in their environment, and have not ended."""
    left = []
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdecimal() and f"{MARK}={mark}".encode() in (entry / "environ").read_bytes():
                state = (entry / "stat").read_text().rpartition(")")[2].split()[0]
                left += [int(entry.name)] if state != "Z" else []
        except OSError:
            continue
    return left
