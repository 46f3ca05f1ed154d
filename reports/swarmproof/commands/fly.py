"""`swarmproof fly`: fly a scenario with real trajectories under message loss, and check every claim on the way."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from swarmproof.assess.judge import FlightVerdict, Flown
from swarmproof.assess.log import Log
from swarmproof.assess.run import Setting, fly
from swarmproof.channel.losses import FORMS, parse
from swarmproof.flight.state import Round
from swarmproof.planning.trigger import Trigger
from swarmproof.report import flight_words
from swarmproof.report.folder import claim_file, claim_folder
from swarmproof.scenario.scenario import SHIPPED, load
from swarmproof.semantics.switches import PRESETS, SWITCHES, BadInput, Semantics

MOST_CUS = 16
_COLOURS = {
    FlightVerdict.VIOLATED: "red",
    FlightVerdict.NOT_VIOLATED: "green",
    FlightVerdict.NOT_APPLICABLE: "bright_black",
}


def add_parser(commands: Any) -> None:
    """Add the command to the subparsers `commands`."""
    parser = commands.add_parser(
        "fly",
        help="fly a scenario with planned trajectories under message loss, and check every claim on the way",
        description="Fly a scenario: the protocol with real trajectories, planned by (13) and checked exactly.",
        epilog="Exit codes: 0 nothing violated, 1 something violated, 2 bad input.",
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    parser.add_argument("scenario", metavar="SCENARIO", help=f"a TOML file, or one of {', '.join(SHIPPED)}")
    parser.add_argument("--cus", type=_number, default=2, metavar="M", help="number of compute units (default 2)")
    parser.add_argument("--trigger", default="HT", metavar="T", help=f"{', '.join(Trigger)} (default HT)")
    parser.add_argument("--loss", default="none", metavar="SPEC", help=f"{', '.join(FORMS)} (default none)")
    parser.add_argument(
        "--semantics", default="guarded", metavar="PRESET", help=f"as in verify: {', '.join(PRESETS)} (default guarded)"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="change a switch, or a parameter of the scenario",
    )
    parser.add_argument("--seed", type=_number, default=0, metavar="S", help="of everything random (default 0)")
    parser.add_argument("--rounds", type=_number, metavar="K", help="length of the flight (default: the scenario's)")
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for standard output")
    parser.add_argument("--report", metavar="DIR", help="write a page with pictures into this folder")


def _number(text: str) -> int:
    if not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number of at least 0")
    return int(text)


def run(options: argparse.Namespace) -> int:
    """Run the command and return the exit code.

    Raises:
        BadInput: a scenario, option or file that cannot be.
    """
    console = Console(stderr=options.json == "-", highlight=False)
    setting = _setting(options)
    rounds = setting.scenario.rounds if options.rounds is None else options.rounds
    if not 1 <= rounds <= 100_000:
        raise BadInput(f"--rounds {rounds} cannot be flown: choose 1 to 100000")
    losses = parse(options.loss, setting.scenario.uavs, setting.cus, setting.seed)
    folder = None if options.report is None else claim_folder(Path(options.report))
    if options.json not in (None, "-"):
        claim_file(Path(options.json))
    flight = setting.flight()
    log = Log(flight)
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("rounds"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=rounds)

        def watch(flown: Round) -> None:
            if folder is not None:
                log.see(flown)
            if flown.after.k % 5 == 0:
                bar.update(task, completed=flown.after.k)

        flown, seconds = fly(setting, losses, rounds, watch, flight)
    _write_json(options.json, flight_words.document(setting, flown, seconds))
    _print(console, setting, options.loss, flown)
    return 1 if flown.violated else 0


def _setting(options: argparse.Namespace) -> Setting:
    if not 1 <= options.cus <= MOST_CUS:
        raise BadInput(f"--cus {options.cus} cannot be flown: choose 1 to {MOST_CUS}")
    if options.trigger not in list(Trigger):
        raise BadInput(f"there is no trigger {options.trigger!r}: choose {', '.join(Trigger)}")
    switches, changes = _split(options.set)
    semantics = Semantics.parse(options.semantics, ["initial=known", *switches, "event_trigger=round-robin"])
    scenario = load(options.scenario, options.seed, changes)
    return Setting(scenario, options.cus, Trigger(options.trigger), semantics, options.seed)


def _split(texts: Iterable[str]) -> tuple[list[str], list[str]]:
    """Return the changes of switches and those of the scenario."""
    switches: list[str] = []
    changes: list[str] = []
    for text in texts:
        name = text.partition("=")[0]
        if name == "event_trigger":
            raise BadInput("--set event_trigger does not go with flights, in which --trigger says whom the CUs plan")
        (switches if name in SWITCHES else changes).append(text)
    return switches, changes


def _write_json(target: str | None, text: str) -> None:
    if target is None:
        return
    if target == "-":
        sys.stdout.write(text)
        return
    try:
        Path(target).write_text(text, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"cannot write {target}: {error.strerror}; give a file that can be written, or -") from None


def _print(console: Console, setting: Setting, loss: str, flown: Flown) -> None:
    console.print(f"[bold]{escape(flight_words.headline(setting, loss, flown))}[/bold]", soft_wrap=True)
    table = Table(box=None, padding=(0, 2))
    for heading in ("claim", "verdict", "why"):
        table.add_column(heading, overflow="fold", no_wrap=heading == "claim")
    for judged in flown.claims:
        colour = _COLOURS[judged.verdict]
        table.add_row(judged.claim.id, f"[{colour}]{judged.verdict}[/]", escape(judged.why))
    console.print(table)
    for line in flight_words.summary(flown):
        console.print(escape(line), soft_wrap=True)
    console.print(flight_words.scope(setting, loss, flown), style="bright_black", soft_wrap=True)
