"""`swarmproof reproduce`: fly the paper's experiments as sweeps, and say which of its statements about them agree."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import TextColumn, TimeRemainingColumn
from rich.table import Table

from swarmproof import streams, terminal
from swarmproof.campaign.decide import Agreement, DecidedClaim, decide_variant
from swarmproof.campaign.store import Store, Stored
from swarmproof.campaign.sweep import sweep
from swarmproof.campaign.trial import Cell
from swarmproof.dmpc_swarm.experiments.experiment import Experiment
from swarmproof.dmpc_swarm.experiments.experiments import EXPERIMENTS
from swarmproof.dmpc_swarm.pages.experiments import words as reproduce_words
from swarmproof.dmpc_swarm.pages.experiments.page import put_reproduction
from swarmproof.dmpc_swarm.pages.flight import page as flight_page
from swarmproof.errors import BadInput
from swarmproof.exit_codes import ExitCode
from swarmproof.output import ReportFolder, deliver, publish, reserve_file, reserve_report, write_json

MOST_PROCESSES = 256
_COLOURS: dict[Agreement, str] = {
    Agreement.AGREES: "green",
    Agreement.DISAGREES: "red",
    Agreement.UNDECIDED: "yellow",
}


def run(options: argparse.Namespace) -> ExitCode:
    """Run the command and return the exit code.

    Raises:
        BadInput: an option, a file or a folder that cannot be.
    """
    if options.experiment not in EXPERIMENTS:
        raise BadInput(f"there is no experiment {options.experiment!r}: choose {', '.join(EXPERIMENTS)}")
    if not 1 <= options.processes <= MOST_PROCESSES:
        raise BadInput(f"--processes {options.processes} cannot be: choose 1 to {MOST_PROCESSES}")
    experiment = EXPERIMENTS[options.experiment](options.quick)
    if options.as_chosen:
        experiment = experiment.as_chosen()
    console = terminal.text(options.json)
    if options.cell:
        if options.report is not None or options.json is not None:
            raise BadInput("--cell flies single cells again: it goes with neither --report nor --json")
        return _again(_find(experiment, options.cell), Store(Path(options.results)), console)
    if options.report is not None:
        flight_page.check_available()
    reserve_file(options.json)
    with reserve_report(options.report) as folder:
        return _sweep(experiment, options, folder, console)


def _sweep(
    experiment: Experiment, options: argparse.Namespace, folder: ReportFolder | None, console: Console
) -> ExitCode:
    """Fly what is missing, deliver what all flights show, and return the exit code."""
    store = Store(Path(options.results))
    complete = _fly_missing(experiment, store, options.processes, console)
    found = store.find(experiment.cells)
    decided = {variant.name: decide_variant(experiment, variant, found) for variant in experiment.variants}
    chosen = decided[experiment.variants[0].name]

    def tell() -> None:
        _print_claims(console, chosen)
        for line in reproduce_words.summary(experiment, options.quick, found, decided):
            console.print(escape(line), soft_wrap=True)

    deliver(
        lambda: write_json(options.json, reproduce_words.document(experiment, options.quick, found, decided)),
        tell,
        lambda: publish(folder, lambda report: put_reproduction(report, experiment, found, options.quick)),
    )
    terminal.print_place(console, "Report", None if folder is None else folder.index)
    return _code(chosen, complete)


def _code(decided: Sequence[DecidedClaim], complete: bool) -> ExitCode:
    if any(each.verdict is Agreement.DISAGREES for each in decided):
        return ExitCode.VIOLATED
    undecided = not complete or any(each.verdict is Agreement.UNDECIDED for each in decided)
    return ExitCode.UNDECIDED if undecided else ExitCode.WELL


def _fly_missing(experiment: Experiment, store: Store, processes: int, console: Console) -> bool:
    """Fly what is missing, and say whether nothing is missing any more."""
    there = store.find(experiment.cells)
    missing = [cell for cell in experiment.cells if cell not in there]
    for line in reproduce_words.before(experiment, there, missing, store, processes):
        console.print(escape(line), soft_wrap=True)
    if not missing:
        return True
    with terminal.bar("flights", TextColumn("to go:"), TimeRemainingColumn()) as bar:
        task = bar.add_task("", total=len(experiment.cells), completed=len(there))

        def keep(cell: Cell, stored: Stored) -> None:
            store.put(cell, stored)
            bar.advance(task)

        complete = sweep(missing, processes, keep, streams.say)
    if not complete:
        console.print("interrupted; the same command goes on from here. What follows is about what is there")
    return complete


def _find(experiment: Experiment, ids: Sequence[str]) -> list[Cell]:
    by_id = {cell.id: cell for cell in experiment.cells}
    for each in ids:
        if each not in by_id:
            raise BadInput(
                f"{experiment.name} has no cell {each!r}: the file cells.csv that --report writes lists them "
                "(those of a quick run need --quick)"
            )
    return [by_id[each] for each in ids]


def _again(cells: Sequence[Cell], store: Store, console: Console) -> ExitCode:
    """Fly the cells once more, and say whether what is stored is the same to the bit."""
    codes: set[ExitCode] = set()
    for cell in cells:
        fresh: dict[Cell, Stored] = {}
        if not sweep([cell], 1, fresh.__setitem__, streams.say):
            raise KeyboardInterrupt
        measured, stored = fresh[cell].measured, store.get(cell)
        console.print(escape(f"{cell.id}: {cell.command}"), soft_wrap=True)
        for line in reproduce_words.numbers(measured):
            console.print(escape(f"  {line}"), soft_wrap=True)
        if stored is None:
            console.print(escape(f"  {store.folder} has no result of this code to compare."), soft_wrap=True)
            codes.add(ExitCode.UNDECIDED)
        elif stored.measured == measured:
            console.print("  The stored result is the same, to the bit.", style="green")
        else:
            for line in reproduce_words.differences(stored.measured, measured):
                console.print(escape(f"  {line}"), style="red", soft_wrap=True)
            codes.add(ExitCode.VIOLATED)
    if ExitCode.VIOLATED in codes:
        return ExitCode.VIOLATED
    return ExitCode.UNDECIDED if codes else ExitCode.WELL


def _print_claims(console: Console, decided: Sequence[DecidedClaim]) -> None:
    table = Table(box=None, padding=(0, 2))
    for heading in ("the paper's statement", "verdict", "why"):
        table.add_column(heading, overflow="fold", no_wrap=heading != "why")
    for each in decided:
        table.add_row(each.claim.id, f"[{_COLOURS[each.verdict]}]{reproduce_words.verdict(each)}[/]", escape(each.why))
    console.print(table)
