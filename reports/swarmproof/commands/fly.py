"""`swarmproof fly`: fly a scenario with real trajectories under message loss, and check every claim on the way."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Literal

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from swarmproof import terminal
from swarmproof.dmpc_swarm.flight.adversary import Worst, parse_budget, search
from swarmproof.dmpc_swarm.flight.exhaustive import Decided, Exhaustive, explore_flights, parse_rounds
from swarmproof.dmpc_swarm.flight.judge import Flown, Judged
from swarmproof.dmpc_swarm.flight.log import Log
from swarmproof.dmpc_swarm.flight.positions import Positions
from swarmproof.dmpc_swarm.flight.run import Setting, fly
from swarmproof.dmpc_swarm.flight.state import Round
from swarmproof.dmpc_swarm.pages.flight import page as flight_page
from swarmproof.dmpc_swarm.pages.flight import words as flight_words
from swarmproof.dmpc_swarm.pages.flight.patterns import put_patterns
from swarmproof.dmpc_swarm.pages.flight.positions import check_format, write_positions
from swarmproof.errors import BadInput
from swarmproof.exit_codes import ExitCode
from swarmproof.explore.search import Limits
from swarmproof.faults.grammar import Loss, parse
from swarmproof.faults.losses import LossModel, Recorded
from swarmproof.faults.script import script_text
from swarmproof.options.fly import SEARCHES
from swarmproof.output import ReportFolder, deliver, publish, reserve_file, reserve_report, write_json

MOST_ROUNDS = 100_000
_COLOURS: dict[str, str] = {
    "violated": "red",
    "not-violated": "green",
    "holds-for-these-rounds": "green",
    "undecided": "yellow",
    "not-applicable": "bright_black",
}


def run(options: argparse.Namespace) -> ExitCode:
    """Run the command and return the exit code.

    Raises:
        BadInput: a scenario, option or file that cannot be.
    """
    console = terminal.text(options.json)
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
        _reserve_files(options)
        with reserve_report(options.report) as folder:
            return _every_pattern(setting, of_all, limits, options, folder, console)
    budget = parse_budget(argument) if kind == "adversary" else None
    losses: LossModel | None = None
    if budget is None:
        losses = parse(options.loss, setting.scenario.uavs, setting.cus, setting.seed)
    _reserve_files(options)
    with reserve_report(options.report) as folder:
        if losses is not None:
            return _one_flight(setting, losses, rounds, options, folder, console)
        worst = _search(setting, rounds, budget or 1, limits)
        if folder is not None:
            folder.put("losses.json", script_text(worst.losses, setting.scenario.uavs, setting.cus))
        losses = Recorded(worst.losses, setting.scenario.uavs, setting.cus)
        code = _one_flight(setting, losses, rounds, options, folder, console, worst)
    return ExitCode.UNDECIDED if worst.stopped is not None and code is ExitCode.WELL else code


def _limits(options: argparse.Namespace, kind: str) -> Limits:
    """Return when a search stops early.

    Raises:
        BadInput: the limits do not go with this kind of loss.
    """
    limits = Limits(options.max_states, options.max_seconds)
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


def _reserve_files(options: argparse.Namespace) -> None:
    """Make sure that what is to be written can be, before anything is computed."""
    reserve_file(options.json)
    if options.positions is not None:
        check_format(Path(options.positions))
        if options.json is not None and os.path.abspath(options.json) == os.path.abspath(options.positions):
            raise BadInput(
                f"--json and --positions both name {options.json}, so that one would overwrite the other: give two "
                "files, such as --json flight.json --positions positions.csv"
            )
        reserve_file(options.positions)
    if options.report is not None:
        flight_page.check_available()


def _one_flight(
    setting: Setting,
    losses: LossModel,
    rounds: int,
    options: argparse.Namespace,
    folder: ReportFolder | None,
    console: Console,
    worst: Worst | None = None,
) -> ExitCode:
    """Fly, deliver what came of it, and return the exit code; `worst` is the search that found the losses, if any."""
    flight = setting.flight()
    log = Log(flight)
    searched = [] if worst is None else worst.description
    positions = None if options.positions is None else Positions(setting, flight)
    with terminal.bar("rounds") as bar:
        task = bar.add_task("", total=rounds)

        def watch(flown: Round) -> None:
            if folder is not None:
                log.see(flown)
            if positions is not None:
                positions.see(flown)
            if flown.after.k % 5 == 0:
                bar.update(task, completed=flown.after.k)

        flown, seconds = fly(setting, losses, rounds, watch, flight)
    idle = losses.without_effect(flown.rounds, flown.lost) if isinstance(losses, Loss) else []
    deliver(
        lambda: None if positions is None else write_positions(Path(options.positions), setting, positions),
        lambda: write_json(options.json, flight_words.document(setting, options.loss, flown, seconds, searched)),
        lambda: _print_flight(console, setting, options.loss, flown, searched, idle),
        lambda: publish(
            folder, lambda report: flight_page.put_flight(report, setting, options.loss, flown, log, searched)
        ),
    )
    terminal.print_place(console, "Report", None if folder is None else folder.index)
    return _exit_code(flown)


def _exit_code(found: Flown | Exhaustive) -> ExitCode:
    if found.violated:
        return ExitCode.VIOLATED
    return ExitCode.UNDECIDED if found.undecided else ExitCode.WELL


def _print_flight(
    console: Console, setting: Setting, loss: str, flown: Flown, search: Sequence[str], idle: Sequence[str]
) -> None:
    for line in search:
        console.print(escape(line), soft_wrap=True)
    if flown.stopped is not None:
        console.print(f"{flown.stopped}; what follows is about these")
    _print(console, flight_words.headline(setting, flown), flown.claims)
    for line in [*flight_words.summary(setting, flown), *idle]:
        console.print(escape(line), soft_wrap=True)
    console.print(escape(flight_words.scope(setting, loss, flown)), style="bright_black", soft_wrap=True)


def _every_pattern(
    setting: Setting,
    rounds: int,
    limits: Limits,
    options: argparse.Namespace,
    folder: ReportFolder | None,
    console: Console,
) -> ExitCode:
    with terminal.bar("swarms") as bar:
        task = bar.add_task("", total=None)
        found = explore_flights(
            setting,
            rounds,
            lambda k, done, size: bar.update(task, description=f"round {k}", completed=done, total=size),
            limits,
        )
    deliver(
        lambda: write_json(options.json, flight_words.patterns_document(setting, rounds, found)),
        lambda: _print_patterns(console, setting, rounds, found),
        lambda: publish(folder, lambda report: put_patterns(report, setting, rounds, found)),
    )
    terminal.print_place(console, "Report", None if folder is None else folder.index)
    return _exit_code(found)


def _print_patterns(console: Console, setting: Setting, rounds: int, found: Exhaustive) -> None:
    _print(console, flight_words.patterns_headline(setting, rounds, found), found.claims)
    for line in flight_words.patterns_summary(found):
        console.print(escape(line), soft_wrap=True)
    console.print(escape(flight_words.patterns_scope(setting, rounds, found)), style="bright_black", soft_wrap=True)


def _search(setting: Setting, rounds: int, budget: int, limits: Limits) -> Worst:
    with terminal.bar("flights") as bar:
        task = bar.add_task("", total=budget)
        return search(
            setting,
            rounds,
            budget,
            lambda done, nearest: bar.update(task, completed=done, description=f"closest so far {nearest:.4f} m"),
            limits,
        )


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
