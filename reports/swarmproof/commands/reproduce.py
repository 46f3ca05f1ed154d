"""`swarmproof reproduce`: fly the paper's experiments as sweeps, and say which of its statements about them agree."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from swarmproof.commands.options import whole_number, write_json
from swarmproof.errors import BadInput
from swarmproof.report import flight_page, reproduce_words
from swarmproof.report.folder import claim_file, claim_folder
from swarmproof.report.reproduce_page import write_reproduction
from swarmproof.reproduce.cell import Cell
from swarmproof.reproduce.decide import Agreement, DecidedClaim, decide_variant
from swarmproof.reproduce.experiment import Experiment
from swarmproof.reproduce.experiments import EXPERIMENTS
from swarmproof.reproduce.store import Store, Stored
from swarmproof.reproduce.sweep import sweep

MOST_PROCESSES = 256
_COLOURS: dict[Agreement, str] = {
    Agreement.AGREES: "green",
    Agreement.DISAGREES: "red",
    Agreement.UNDECIDED: "yellow",
}


def add_parser(commands: Any) -> None:
    """Add the command to the subparsers `commands`."""
    parser = commands.add_parser(
        "reproduce",
        help="fly the paper's experiments as sweeps, and decide what the paper says about them",
        description="The experiments of Section 5 on our swarm, over many seeds: what agrees with the paper, what does "
        "not, and which of our choices matter. Stopped, it goes on where it was.",
        epilog="Exit codes: 0 all statements agree, 1 one does not, 2 bad input, 3 one is not decided, or interrupted.",
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    parser.add_argument("experiment", metavar="EXPERIMENT", help=", ".join(EXPERIMENTS))
    parser.add_argument("--quick", action="store_true", help="a small version, in less than two minutes")
    parser.add_argument(
        "--as-chosen", action="store_true", help="only with our choices, not with each of them changed as well"
    )
    parser.add_argument(
        "--results",
        default="out/results",
        metavar="DIR",
        help="where results are kept: what is there is not flown again (default out/results)",
    )
    parser.add_argument(
        "--processes", type=whole_number, default=os.cpu_count() or 1, metavar="P", help="default: one for each core"
    )
    parser.add_argument(
        "--cell", action="append", default=[], metavar="ID", help="fly this cell again and compare; repeatable"
    )
    parser.add_argument("--report", metavar="DIR", help="write a page with plots, tables and all cells")
    parser.add_argument("--json", metavar="FILE", help="write the verdicts as JSON; - for standard output")


def run(options: argparse.Namespace) -> int:
    """Run the command and return the exit code.

    Raises:
        BadInput: an option, a file or a folder that cannot be.
    """
    if options.experiment not in EXPERIMENTS:
        raise BadInput(f"there is no experiment {options.experiment!r}: choose {', '.join(EXPERIMENTS)}")
    if not 1 <= options.processes <= MOST_PROCESSES:
        raise BadInput(f"--processes {options.processes} cannot be: choose 1 to {MOST_PROCESSES}")
    if not options.results:
        raise BadInput("--results needs the name of a folder")
    experiment = EXPERIMENTS[options.experiment](options.quick)
    if options.as_chosen:
        experiment = experiment.as_chosen()
    console = Console(stderr=options.json == "-", highlight=False)
    if options.cell:
        if options.report is not None or options.json is not None:
            raise BadInput("--cell flies single cells again: it goes with neither --report nor --json")
        return _again(_find(experiment, options.cell), Store(Path(options.results)), console)
    folder = None
    if options.report is not None:
        flight_page.check_available()
        folder = claim_folder(Path(options.report))
    if options.json not in (None, "-"):
        claim_file(Path(options.json))
    store = Store(Path(options.results))
    complete = _fly_missing(experiment, store, options.processes, console)
    found = store.find(experiment.cells)
    decided = {variant.name: decide_variant(experiment, variant, found) for variant in experiment.variants}
    chosen = decided[experiment.variants[0].name]
    write_json(options.json, reproduce_words.document(experiment, options.quick, found, decided))
    _print_claims(console, chosen)
    for line in reproduce_words.summary(experiment, options.quick, found, decided):
        console.print(escape(line), soft_wrap=True)
    if folder is not None:
        write_reproduction(folder, experiment, found, options.quick)
        console.print(escape(f"Report: {folder / 'index.html'}"), soft_wrap=True)
    return _code(chosen, complete)


def _code(decided: Sequence[DecidedClaim], complete: bool) -> int:
    if any(each.verdict is Agreement.DISAGREES for each in decided):
        return 1
    return 3 if not complete or any(each.verdict is Agreement.UNDECIDED for each in decided) else 0


def _fly_missing(experiment: Experiment, store: Store, processes: int, console: Console) -> bool:
    """Fly what is missing, and say whether nothing is missing any more."""
    there = store.find(experiment.cells)
    missing = [cell for cell in experiment.cells if cell not in there]
    for line in reproduce_words.before(experiment, there, missing, store.outdated(missing), processes):
        console.print(escape(line), soft_wrap=True)
    if not missing:
        return True
    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("flights"),
        TimeElapsedColumn(),
        TextColumn("to go:"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=len(experiment.cells), completed=len(there))

        def keep(cell: Cell, stored: Stored) -> None:
            store.put(cell, stored)
            bar.advance(task)

        complete = sweep(missing, processes, keep)
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


def _again(cells: Sequence[Cell], store: Store, console: Console) -> int:
    """Fly the cells once more, and say whether what is stored is the same to the bit."""
    codes = set()
    for cell in cells:
        fresh: dict[Cell, Stored] = {}
        if not sweep([cell], 1, fresh.__setitem__):
            raise KeyboardInterrupt
        measured, stored = fresh[cell].measured, store.get(cell)
        console.print(escape(f"{cell.id}: {cell.command}"), soft_wrap=True)
        for line in reproduce_words.numbers(measured):
            console.print(escape(f"  {line}"), soft_wrap=True)
        if stored is None:
            console.print(escape(f"  {store.folder} has no result of this code to compare."), soft_wrap=True)
            codes.add(3)
        elif stored.measured == measured:
            console.print("  The stored result is the same, to the bit.", style="green")
        else:
            for line in reproduce_words.differences(stored.measured, measured):
                console.print(escape(f"  {line}"), style="red", soft_wrap=True)
            codes.add(1)
    return 1 if 1 in codes else 3 if codes else 0


def _print_claims(console: Console, decided: Sequence[DecidedClaim]) -> None:
    table = Table(box=None, padding=(0, 2))
    for heading in ("the paper's statement", "verdict", "why"):
        table.add_column(heading, overflow="fold", no_wrap=heading != "why")
    for each in decided:
        table.add_row(each.claim.id, f"[{_COLOURS[each.verdict]}]{reproduce_words.verdict(each)}[/]", escape(each.why))
    console.print(table)
