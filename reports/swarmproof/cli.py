"""The command line: how it starts, and the one sentence and the exit code of every way in which it can end.

Almost nothing is imported here, so that Ctrl-C is a sentence as soon as possible, and so that each command imports what
it needs (docs/exit-codes.md).
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from swarmproof import interrupts, streams
from swarmproof.errors import BadInput, Failed
from swarmproof.exit_codes import ExitCode

#: Set to anything, it shows where a defect of ours is.
TRACEBACK = "SWARMPROOF_TRACEBACK"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code."""
    with interrupts.handled():
        try:
            streams.prepare()
            code = _run(sys.argv[1:] if arguments is None else arguments)
            streams.finish()
            return code
        except BaseException as error:
            sentence, code = _ending(error)
            streams.say(sentence)
            return code


def _run(arguments: Sequence[str]) -> int:
    from swarmproof.options.parser import command_of, parse

    try:
        options = parse(arguments)
    except SystemExit as done:  # --help and --version have said what they say
        return int(done.code or 0)
    try:
        os.getcwd()
    except OSError:
        raise Failed("the working directory is not there any more: go to one that is, such as by cd ~") from None
    run = command_of(options)
    interrupts.from_now_on()
    return run(options)


def _ending(error: BaseException) -> tuple[str, ExitCode]:
    """Return the sentence and the exit code of an end that is no verdict."""
    if isinstance(error, BadInput):
        return str(error), ExitCode.BAD_INPUT
    if isinstance(error, interrupts.Terminated):
        return "interrupted by the signal TERM", ExitCode.TERMINATED
    if isinstance(error, KeyboardInterrupt):
        return "interrupted", ExitCode.INTERRUPTED
    if isinstance(error, Failed):
        return str(error), ExitCode.FAILED
    if isinstance(error, MemoryError):
        return "the memory is not enough for this: nothing is decided", ExitCode.FAILED
    if isinstance(error, OSError):
        where = "" if error.filename is None else f": {error.filename}"
        return f"the system refused: {error.strerror or error}{where}", ExitCode.FAILED
    if os.environ.get(TRACEBACK):
        import traceback

        traceback.print_exception(error)
    return f"{_defect(error)}; with {TRACEBACK}=1 it shows where, which helps whoever mends it", ExitCode.DEFECT


def _defect(error: BaseException) -> str:
    what = " ".join(f"{type(error).__name__}: {error}".split())
    return f"this is a defect of swarmproof, no verdict, and nothing that you did wrong: {what[:300]}"
