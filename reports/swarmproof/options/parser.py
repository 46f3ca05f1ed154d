"""The parser of the command line. It imports the options of the command that was given, and no command."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from importlib import import_module
from typing import Any, NoReturn, Protocol, cast

from swarmproof.errors import BadInput
from swarmproof.streams import print_out

#: The commands, and what each does. `swarmproof.options.NAME` has its options, `swarmproof.commands.NAME` runs it.
COMMANDS: dict[str, str] = {
    "verify": "explore every message-loss pattern to a fixpoint and decide each claim",
    "fly": "fly a scenario with planned trajectories under message loss, and check every claim on the way",
    "margin": "compute Δd_min,cont with a certificate, and what Theorem 3 then guarantees",
    "audit": "decide what the proofs state: each statement proved or refuted, as printed and repaired",
    "reproduce": "fly the paper's experiments as sweeps, and decide what the paper says about them",
    "claims": "list the claims: wording, place in the paper, assumptions",
    "replay": "run a trace step by step on the readable model",
}

#: Of each option with a value, a value that is right; of each command, what can stand behind it.
EXAMPLES: dict[str, str] = {
    "--system": "mlr-dmpc",
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


class _Options(Protocol):
    """What a module of options has: a command line that is right, texts for its help, and the options."""

    EXAMPLE: str
    DESCRIPTION: str
    EPILOG: str

    def add_options(self, parser: argparse.ArgumentParser) -> None: ...


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

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print help so that a failure is seen: argparse would swallow it."""
        print_out(message)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Refuse here what is not known: else the program's parser would, which does not know the command's options."""
        known, rest = super().parse_known_args(args, namespace)
        if rest:
            options = [name for name in self._option_string_actions if name.startswith("--")]
            near = get_close_matches(rest[0].partition("=")[0], options, n=1)
            self.error(f"unrecognized arguments: {' '.join(rest)}{f', did you mean {near[0]}?' if near else ''}")
        return known, rest


class _Version(argparse.Action):
    """`--version`: reads the package's metadata only if it is asked for."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object, **__: object) -> NoReturn:
        from importlib.metadata import version

        print_out(f"swarmproof {version('swarmproof')}\n")
        parser.exit()


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Parse a command line.

    Raises:
        BadInput: it cannot be.
        SystemExit: `--help` or `--version` was given, and is said.
    """
    given = arguments[0] if arguments else ""
    options = parser([given] if given in COMMANDS else []).parse_args(arguments)
    _refuse_empty(arguments)
    return options


def _refuse_empty(arguments: Sequence[str]) -> None:
    """Refuse a value of nothing but blanks: a script with a variable that is not set gives one, and none is right."""
    for before, word in zip(("", *arguments), arguments, strict=False):
        option, equals, value = word.partition("=") if word.startswith("--") else (before, "=", word)
        if equals and not value.strip():
            name = option if option.startswith("--") else "an argument"
            example = f", such as {option} {EXAMPLES[option]}" if option in EXAMPLES else ""
            raise BadInput(f"{name} has an empty value: give one{example}, or leave it out")


def parser(commands: Sequence[str] = tuple(COMMANDS)) -> argparse.ArgumentParser:
    """Return the parser of the command line; only these `commands` have their options."""
    program = _Parser(
        prog="swarmproof",
        description="Checks whether a distributed swarm controller is as safe as its paper says.",
        epilog="Exit codes: 0 well, 1 some claim violated (--matrix, audit: some verdict changed; margin: (26) fails), "
        "2 bad input, 3 undecided, or stopped, 4 the output, the memory or a process failed, 5 a defect of swarmproof. "
        "Begin with: swarmproof verify",
        allow_abbrev=False,
    )
    program.add_argument("--version", action=_Version, nargs=0, help="show the version and exit")
    under = program.add_subparsers(title="commands", metavar="COMMAND", required=True, dest="command")
    for name, about in COMMANDS.items():
        if name not in commands:
            under.add_parser(name, help=about)
            continue
        of = cast(_Options, import_module(f"swarmproof.options.{name}"))
        own = under.add_parser(
            name,
            help=about,
            description=of.DESCRIPTION,
            epilog="\n\n".join(text for text in (of.EPILOG, f"Example:\n  {of.EXAMPLE}") if text),
            formatter_class=_Help,
            allow_abbrev=False,
        )
        of.add_options(own)
    return program


class _Help(argparse.RawDescriptionHelpFormatter):
    """Help whose paragraphs are filled, but for those with lines that are indented."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        paragraphs = text.split("\n\n")
        filled = (
            one if "\n " in one else super(argparse.RawDescriptionHelpFormatter, self)._fill_text(one, width, indent)
            for one in paragraphs
        )
        return "\n\n".join(filled)


def command_of(options: argparse.Namespace) -> Callable[[argparse.Namespace], int]:
    """Return what runs the command of these options, and import what it needs."""
    run: Callable[[argparse.Namespace], int] = import_module(f"swarmproof.commands.{options.command}").run
    return run
