"""The command line. Exit codes: 2 bad input, else 1 something violated (or changed), else 3 undecided, else 0."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from importlib.metadata import version
from typing import Any, NoReturn

from swarmproof.commands import audit, claims, fly, margin, replay, reproduce, verify
from swarmproof.errors import BadInput

BAD_INPUT = 2
INTERRUPTED = 130


#: Of each option with a value, a value that is right; of each command, what can stand behind it.
EXAMPLES: dict[str, str] = {
    "--uavs": "3",
    "--cus": "2",
    "--semantics": "guarded",
    "--set": "v_max=1",
    "--claim": "lemma-3",
    "--json": "out.json",
    "--report": "out",
    "--max-states": "100000",
    "--max-seconds": "60",
    "--trigger": "HT",
    "--loss": "iid:0.1",
    "--seed": "1",
    "--rounds": "60",
    "--positions": "flight.csv",
    "--d-min": "0.12",
    "--tracking-error": "0.01",
    "--reading": "whole-motion",
    "--certificate": "margin.json",
    "--plot": "worst.svg",
    "--solve-for": "T_c",
    "--check": "margin.json",
    "--sweep": "T_c=0.05:0.1",
    "--changes": "1",
    "--results": "out/results",
    "--processes": "2",
    "--cell": "0123456789abcdef",
    "SCENARIO": "crossing",
    "TRACE": "out/lemma-1.trace.json",
    "EXPERIMENT": "fig4",
    "COMMAND": "verify",
}


class _Parser(argparse.ArgumentParser):
    """A parser whose complaints are one sentence, with an example, and name the help of the command."""

    def error(self, message: str) -> NoReturn:
        missing = re.search(r"(?:argument (--[\w-]+): expected|arguments are required: (\w+))", message)
        if missing is not None:
            option, positional = missing.groups()
            example = EXAMPLES.get(option or positional)
            if example is not None:
                message += f", such as {option} {example}" if option else f", such as {example}"
        raise BadInput(f"{message} (`{self.prog} --help` lists what can be given)")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Refuse here what is not known: else the program's parser would, which does not know the command's options."""
        known, rest = super().parse_known_args(args, namespace)
        if rest:
            options = [name for name in self._option_string_actions if name.startswith("--")]
            near = get_close_matches(rest[0].partition("=")[0], options, n=1)
            self.error(f"unrecognized arguments: {' '.join(rest)}{f', did you mean {near[0]}?' if near else ''}")
        return known, rest


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    program = _Parser(
        prog="swarmproof",
        description="Checks whether a distributed swarm controller is as safe as its paper says.",
        epilog="Exit codes: 0 well, 1 some claim violated (--matrix, audit: some verdict changed; margin: (26) fails), "
        "2 bad input, 3 undecided.",
        allow_abbrev=False,
    )
    program.add_argument("--version", action="version", version=f"swarmproof {version('swarmproof')}")
    commands = program.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in (verify, fly, margin, audit, reproduce, claims, replay):
        command.add_parser(commands)
    return program


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code."""
    try:
        options = parser().parse_args(arguments)
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
