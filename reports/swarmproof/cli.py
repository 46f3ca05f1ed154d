"""The command line. Exit codes: 2 bad input, else 1 something violated (or changed), else 3 undecided, else 0."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib.metadata import version
from typing import NoReturn

from swarmproof.commands import audit, claims, fly, margin, replay, reproduce, verify
from swarmproof.semantics.switches import BadInput

BAD_INPUT = 2
INTERRUPTED = 130


class _Parser(argparse.ArgumentParser):
    """A parser whose complaints are one sentence."""

    def error(self, message: str) -> NoReturn:
        raise BadInput(f"{message} (`{self.prog} --help` lists what can be given)")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="swarmproof",
        description="Checks whether a distributed swarm controller is as safe as its paper says.",
        epilog="Exit codes: 0 well, 1 some claim violated (--matrix, audit: some verdict changed; margin: (26) fails), "
        "2 bad input, 3 undecided.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"swarmproof {version('swarmproof')}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in (verify, fly, margin, audit, reproduce, claims, replay):
        command.add_parser(commands)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code."""
    try:
        options = _parser().parse_args(arguments)
        code: int = options.run(options)
        sys.stdout.flush()
        return code
    except BadInput as bad_input:
        print(f"swarmproof: {bad_input}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("swarmproof: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # whoever read our output went away; nothing is left to say, and the interpreter must not try at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


if __name__ == "__main__":
    sys.exit(main())
