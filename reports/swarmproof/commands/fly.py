"""`swarmproof fly`: fly a scenario with real trajectories under message loss, and check every claim on the way."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from swarmproof.assess.adversary import Worst, parse_budget, search
from swarmproof.assess.exhaustive import Decided, explore_flights, parse_rounds
from swarmproof.assess.judge import Judged
from swarmproof.assess.log import Log
from swarmproof.assess.positions import Positions
from swarmproof.assess.run import Setting, fly
from swarmproof.channel.grammar import COMBINED, FORMS, Loss, parse
from swarmproof.channel.losses import LossModel, Recorded
from swarmproof.channel.script import write_script
from swarmproof.commands.options import add_limits, limits_of, whole_number, write_json
from swarmproof.errors import BadInput
from swarmproof.explore.search import Limits
from swarmproof.flight.state import Round
from swarmproof.planning.trigger import Trigger
from swarmproof.report import flight_page, flight_words
from swarmproof.report.flight_patterns import write_patterns
from swarmproof.report.flight_positions import check_format, write_positions
from swarmproof.report.folder import claim_file, claim_folder
from swarmproof.scenario.scenario import SHIPPED
from swarmproof.semantics.switches import PRESETS

#: Forms of --loss that are no loss models but searches for losses.
SEARCHES = ("adversary:BUDGET", "exhaustive:ROUNDS")
MOST_ROUNDS = 100_000
UNDECIDED = 3
_COLOURS: dict[str, str] = {
    "violated": "red",
    "not-violated": "green",
    "holds-for-these-rounds": "green",
    "undecided": "yellow",
    "not-applicable": "bright_black",
}


def add_parser(commands: Any) -> None:
    """Add the command to the subparsers `commands`."""
    parser = commands.add_parser(
        "fly",
        help="fly a scenario with planned trajectories under message loss, and check every claim on the way",
        description="Fly a scenario: the protocol with real trajectories, planned by (13) and checked exactly.",
        epilog=_loss_help()
        + "\n\nExit codes: 0 nothing violated, 1 something violated, 2 bad input, 3 something undecided, or stopped.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    parser.add_argument("scenario", metavar="SCENARIO", help=f"a TOML file, or one of {', '.join(SHIPPED)}")
    parser.add_argument("--cus", type=whole_number, default=2, metavar="M", help="number of compute units (default 2)")
    parser.add_argument("--trigger", default="HT", metavar="T", help=f"{', '.join(Trigger)} (default HT)")
    parser.add_argument(
        "--loss", default="none", metavar="SPEC", help=f"{', '.join([*FORMS, *SEARCHES])}; see below (default none)"
    )
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
    parser.add_argument("--seed", type=whole_number, default=0, metavar="S", help="of everything random (default 0)")
    parser.add_argument(
        "--rounds", type=whole_number, metavar="K", help="length of the flight (default: the scenario's)"
    )
    add_limits(parser, states="swarms (--loss exhaustive)")
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for standard output")
    parser.add_argument(
        "--positions", metavar="FILE", help="write all positions at multiples of T_c (.csv), with all plans (.json)"
    )
    parser.add_argument("--report", metavar="DIR", help="write a page with pictures into this folder")


def _loss_help() -> str:
    """Return how losses are written, with examples."""
    width = max(len(example) for example, _ in COMBINED.values()) + 4
    lines = [f"  {example!r:{width}}{meaning}" for example, meaning in COMBINED.values()]
    return "\n".join(["--loss takes a search, a model, or what is made of models (in quotes, for the shell):", *lines])


def run(options: argparse.Namespace) -> int:
    """Run the command and return the exit code.

    Raises:
        BadInput: a scenario, option or file that cannot be.
    """
    console = Console(stderr=options.json == "-", highlight=False)
    if options.rounds is not None and not 1 <= options.rounds <= MOST_ROUNDS:
        raise BadInput(f"--rounds {options.rounds} cannot be flown: choose 1 to {MOST_ROUNDS}, such as --rounds 100")
    setting = Setting.parse(
        options.scenario, options.cus, options.trigger, options.semantics, options.set, options.seed, options.rounds
    )
    rounds = setting.scenario.rounds
    kind, _, argument = options.loss.partition(":")
    limits = _limits(options, kind)
    if kind == "exhaustive":
        if options.rounds is not None:
            raise BadInput(
                "--rounds does not go with --loss exhaustive:ROUNDS, which says how many rounds are flown, "
                "such as exhaustive:4"
            )
        if options.positions is not None:
            raise BadInput(
                "--positions goes with one flight, not with --loss exhaustive:ROUNDS: fly the losses that --report "
                "writes, such as --loss script:DIR/theorem-2.losses.json"
            )
        of_all = parse_rounds(argument)
        folder = _claim(options)
        return _every_pattern(setting, of_all, limits, options, folder, console)
    budget = parse_budget(argument) if kind == "adversary" else None
    losses: LossModel | None = None
    if budget is None:
        losses = parse(options.loss, setting.scenario.uavs, setting.cus, setting.seed)
    folder = _claim(options)
    undecided = False
    if losses is None or budget is not None:
        worst = _search(setting, rounds, budget or 1, limits)
        undecided = worst.stopped is not None
        losses = Recorded(worst.losses, setting.scenario.uavs, setting.cus)
        if folder is not None:
            write_script(folder / "losses.json", worst.losses, setting.scenario.uavs, setting.cus)
        for line in worst.description:
            console.print(escape(line), soft_wrap=True)
    code = _one_flight(setting, losses, rounds, options, folder, console)
    return UNDECIDED if undecided and not code else code


def _limits(options: argparse.Namespace, kind: str) -> Limits:
    """Return when a search stops early.

    Raises:
        BadInput: the limits do not go with this kind of loss.
    """
    limits = limits_of(options)
    given = [name for name in ("max_states", "max_seconds") if getattr(limits, name) is not None]
    if kind == "adversary" and "max_states" in given:
        raise BadInput("--max-states does not go with --loss adversary:BUDGET, whose BUDGET is the number of flights")
    if given and kind not in ("adversary", "exhaustive"):
        option = given[0].replace("_", "-")
        searches = "exhaustive:ROUNDS" if option == "max-states" else " or ".join(reversed(SEARCHES))
        raise BadInput(
            f"--{option} does not go with --loss {options.loss}, which is one flight: it ends a search, --loss "
            f"{searches}; for a shorter flight, give --rounds K"
        )
    return limits


def _claim(options: argparse.Namespace) -> Path | None:
    """Make sure that what is to be written can be, before anything is computed; return the report's folder."""
    if options.json not in (None, "-"):
        claim_file(Path(options.json))
    if options.positions is not None:
        check_format(Path(options.positions))
        if options.json is not None and Path(options.json).absolute() == Path(options.positions).absolute():
            raise BadInput(
                f"--json and --positions both name {options.json}, so that one would overwrite the other: give two "
                "files, such as --json flight.json --positions positions.csv"
            )
        claim_file(Path(options.positions))
    if options.report is None:
        return None
    flight_page.check_available()
    return claim_folder(Path(options.report))


def _one_flight(
    setting: Setting, losses: LossModel, rounds: int, options: argparse.Namespace, folder: Path | None, console: Console
) -> int:
    flight = setting.flight()
    log = Log(flight)
    positions = None if options.positions is None else Positions(setting, flight)
    with _bar("rounds") as bar:
        task = bar.add_task("", total=rounds)

        def watch(flown: Round) -> None:
            if folder is not None:
                log.see(flown)
            if positions is not None:
                positions.see(flown)
            if flown.after.k % 5 == 0:
                bar.update(task, completed=flown.after.k)

        flown, seconds = fly(setting, losses, rounds, watch, flight)
    if flown.stopped is not None:
        console.print(f"{flown.stopped}; what follows is about these")
    if folder is not None:
        flight_page.write_flight(folder, setting, options.loss, flown, log)
    if positions is not None:
        write_positions(Path(options.positions), setting, positions)
    write_json(options.json, flight_words.document(setting, options.loss, flown, seconds))
    idle = losses.without_effect(flown.rounds, flown.lost) if isinstance(losses, Loss) else []
    _print(console, flight_words.headline(setting, flown), flown.claims)
    for line in [*flight_words.summary(setting, flown), *idle]:
        console.print(escape(line), soft_wrap=True)
    console.print(escape(flight_words.scope(setting, options.loss, flown)), style="bright_black", soft_wrap=True)
    return 1 if flown.violated else UNDECIDED if flown.undecided else 0


def _every_pattern(
    setting: Setting,
    rounds: int,
    limits: Limits,
    options: argparse.Namespace,
    folder: Path | None,
    console: Console,
) -> int:
    with _bar("swarms") as bar:
        task = bar.add_task("", total=None)
        found = explore_flights(
            setting,
            rounds,
            lambda k, done, size: bar.update(task, description=f"round {k}", completed=done, total=size),
            limits,
        )
    if folder is not None:
        write_patterns(folder, setting, rounds, found)
    write_json(options.json, flight_words.patterns_document(setting, rounds, found))
    _print(console, flight_words.patterns_headline(setting, rounds, found), found.claims)
    for line in flight_words.patterns_summary(found):
        console.print(escape(line), soft_wrap=True)
    console.print(escape(flight_words.patterns_scope(setting, rounds, found)), style="bright_black", soft_wrap=True)
    return 1 if found.violated else UNDECIDED if found.undecided else 0


def _search(setting: Setting, rounds: int, budget: int, limits: Limits) -> Worst:
    with _bar("flights") as bar:
        task = bar.add_task("", total=budget)
        return search(
            setting,
            rounds,
            budget,
            lambda done, nearest: bar.update(task, completed=done, description=f"closest so far {nearest:.4f} m"),
            limits,
        )


def _bar(unit: str) -> Progress:
    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn(unit),
        TimeElapsedColumn(),
        TextColumn("{task.description}"),
    )
    return Progress(*columns, console=Console(stderr=True), transient=True)


def _print(console: Console, headline: str, claims: Iterable[Judged | Decided]) -> None:
    console.print(f"[bold]{escape(headline)}[/bold]", soft_wrap=True)
    table = Table(box=None, padding=(0, 2))
    for heading in ("claim", "verdict", "seen", "why"):
        justify: Literal["left", "right"] = "right" if heading == "seen" else "left"
        table.add_column(heading, overflow="fold", no_wrap=heading != "why", justify=justify)
    for judged in claims:
        verdict = f"[{_COLOURS[judged.verdict]}]{judged.verdict}[/]"
        table.add_row(judged.claim.id, verdict, str(judged.instances), escape(judged.why))
    console.print(table)
    first = next((judged for judged in claims if judged.chain), None)
    if first is not None:
        console.print(f"How {first.claim.id} came to be violated first:")
        for line in first.chain:
            console.print(f"  {escape(line)}", soft_wrap=True)
