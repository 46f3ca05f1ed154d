"""A run of any system on the terminal, round by round: what each node holds, what happens, what it shows."""

from __future__ import annotations

from rich.console import Console
from rich.markup import escape

from swarmproof.pages import phrases
from swarmproof.pages.run import rounds_of, shown
from swarmproof.trace.replay import Replay


def print_run(console: Console, replayed: Replay) -> None:
    """Print the rounds of a run, and what it shows."""
    trace, end = replayed.trace, len(replayed.events)
    for told in rounds_of(replayed):
        loop = " (the loop starts here)" if told.k == trace.loop_start else ""
        console.rule(f"round {told.k}{loop}", align="left")
        for row in told.rows:
            console.print(f"  {escape(row.who)}: {escape(row.holds)}")
        for sentence in told.events:
            console.print(f"[red]![/red] {escape(sentence)}")
        for one in told.broken:
            console.print(f"[bold red]{escape(one)}[/bold red]")
    console.rule("what this shows", align="left")
    if trace.loop_start is not None:
        console.print(" ".join(shown(replayed)))
    outcome = "is violated" if replayed.is_violation else "is reached" if replayed.claim is not None else "was seen"
    rounds = phrases.count(end if trace.loop_start is None else trace.loop_start, "round")
    way = rounds if trace.loop_start is None else f"a loop after {rounds}"
    console.print(f"[bold]{trace.shows} {outcome}[/bold]: {way}, {phrases.losses(replayed.lost_messages)}.")
