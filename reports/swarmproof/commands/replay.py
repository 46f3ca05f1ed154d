"""`swarmproof replay`: run a trace, step by step, on the readable model, and tell what happens."""

from __future__ import annotations

import argparse

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from swarmproof import terminal
from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.causes import causes, what_is_false
from swarmproof.dmpc_swarm.pages.story import Sentence, tell
from swarmproof.dmpc_swarm.pages.tables import Cell, round_table
from swarmproof.exit_codes import ExitCode
from swarmproof.trace.trace import Replay, load, replay


def run(options: argparse.Namespace) -> ExitCode:
    """Replay the trace, print each round, and return 1 if a claim is violated at its end, else 0.

    Raises:
        BadInput: the trace cannot be read, cannot happen, or does not show what it says.
    """
    console = terminal.text()
    replayed = replay(load(options.trace))
    trace = replayed.trace
    console.print(f"[bold]{trace.uavs} UAVs, {trace.cus} CUs, semantics {replayed.semantics.name()}[/bold]")
    for k in range(len(replayed.swarms)):
        _print_round(console, replayed, k)
    _print_end(console, replayed)
    return ExitCode.VIOLATED if replayed.is_violation else ExitCode.WELL


def _print_round(console: Console, replayed: Replay, k: int) -> None:
    loop = " (the loop starts here)" if k == replayed.trace.loop_start else ""
    console.rule(f"round {k}{loop}", align="left")
    story = tell(replayed, k)
    for sentence in story.update:
        _print_sentence(console, sentence)
    table = round_table(replayed, k)
    grid = Table(box=None, padding=(0, 2))
    grid.add_column("")
    grid.add_column("state")
    for header in table.headers:
        grid.add_column(f"{header.name} follows {header.follows}")
    for row in table.rows:
        grid.add_row(row.name, row.state, *(_cell(cell) for cell in row.cells))
    console.print(grid)
    for sentence in (*story.decide, *story.air):
        _print_sentence(console, sentence)


def _cell(cell: Cell) -> str:
    text = escape(cell.entries) + (" deprecated" if cell.deprecated else "")
    return f"[bold red]{text} <- broken[/bold red]" if cell.broken else text


def _print_sentence(console: Console, sentence: Sentence) -> None:
    place = f" [bright_black]({escape(sentence.place)})[/bright_black]" if sentence.place else ""
    mark = "[red]![/red] " if sentence.amiss else "  "
    console.print(f"{mark}{escape(sentence.text)}{place}")


def _print_end(console: Console, replayed: Replay) -> None:
    trace, end = replayed.trace, len(replayed.events)
    console.rule("what this shows", align="left")
    broken = replayed.broken_at(end)
    for one in broken:
        console.print(f"[red]{escape(what_is_false(replayed, one, end))}[/red]")
    for sentence in causes(replayed, broken, end):
        _print_sentence(console, sentence)
    if trace.loop_start is not None:
        console.print(
            f"Round {end} is like round {trace.loop_start}: without any loss, the rounds between can repeat for ever, "
            "and not all CUs run."
        )
    lost = names.losses(replayed.lost_messages)
    outcome = "is violated" if replayed.is_violation else "is reached" if replayed.claim is not None else "was seen"
    way = (
        names.count(end, "round")
        if trace.loop_start is None
        else f"a loop after {names.count(trace.loop_start, 'round')}"
    )
    console.print(f"[bold]{trace.shows} {outcome}[/bold]: {way}, {lost}.")
