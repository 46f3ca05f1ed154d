"""What the exit codes mean: one list for all commands (docs/exit-codes.md)."""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum

from swarmproof.claims.verdict import Verdict, worst


class ExitCode(IntEnum):
    """The exit codes. Only WELL, VIOLATED and UNDECIDED are verdicts; no failure of ours or of the world is one."""

    WELL = 0
    #: Some claim is violated; with `--matrix` and `audit`, a verdict is not the one on record.
    VIOLATED = 1
    BAD_INPUT = 2
    #: Something is not decided: a limit, an interrupt, or a verdict about nothing.
    UNDECIDED = 3
    #: The world: a full disk, a closed pipe, too little memory, a worker that was killed again and again.
    FAILED = 4
    #: A defect of ours.
    DEFECT = 5
    #: Ctrl-C before there was anything to tell.
    INTERRUPTED = 130
    #: The signal TERM, likewise.
    TERMINATED = 143


def exit_code(verdicts: Iterable[Verdict]) -> ExitCode:
    """Return the exit code of these verdicts: that of the worst one."""
    return {Verdict.VIOLATED: ExitCode.VIOLATED, Verdict.UNDECIDED: ExitCode.UNDECIDED}.get(
        worst(verdicts), ExitCode.WELL
    )
