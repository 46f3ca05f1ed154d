"""A run of MLR-DMPC on the terminal, round by round: trackers, decisions, losses, and how it came to the end."""

from __future__ import annotations

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from swarmproof.dmpc_swarm.pages.causes import causes, what_is_false
from swarmproof.dmpc_swarm.pages.story import Sentence, tell
from swarmproof.dmpc_swarm.pages.swarm_run import SwarmRun
from swarmproof.dmpc_swarm.pages.tables import Cell, round_table
from swarmproof.pages import phrases
from swarmproof.trace.replay import Replay


def print_run(console: Console, replayed: Replay) -> None:
    """Print the rounds of a run, and what it shows."""
    run = SwarmRun.of(replayed)
    for k in range(len(run.swarms)):
        _print_round(console, run, k)
    _print_end(console, run, replayed.claim is None)


def _print_round(console: Console, run: SwarmRun, k: int) -> None:
    loop = " (the loop starts here)" if k == run.loop_start else ""
    console.rule(f"round {k}{loop}", align="left")
    story = tell(run, k)
    for sentence in story.update:
        _print_sentence(console, sentence)
    table = round_table(run, k)
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


def _print_end(console: Console, run: SwarmRun, is_witness: bool) -> None:
    end = len(run.events)
    console.rule("what this shows", align="left")
    broken = run.broken[end]
    for one in broken:
        console.print(f"[red]{escape(what_is_false(run, one, end))}[/red]")
    for sentence in causes(run, broken, end):
        _print_sentence(console, sentence)
    if run.loop_start is not None:
        console.print(
            f"Round {end} is like round {run.loop_start}: without any loss, the rounds between can repeat for ever, "
            "and not all CUs run."
        )
    lost = phrases.losses(run.lost_messages)
    outcome = "is violated" if run.is_violation else "was seen" if is_witness else "is reached"
    way = (
        phrases.count(end, "round")
        if run.loop_start is None
        else f"a loop after {phrases.count(run.loop_start, 'round')}"
    )
    console.print(f"[bold]{run.shows} {outcome}[/bold]: {way}, {lost}.")
