"""`swarmproof replay`: run a trace, step by step, on the readable model, and tell what happens."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import cast

from rich.console import Console

from swarmproof import terminal
from swarmproof.exit_codes import ExitCode
from swarmproof.pages.page import of_system
from swarmproof.trace.replay import Replay, replay
from swarmproof.trace.trace import read


def run(options: argparse.Namespace) -> ExitCode:
    """Replay the trace, print each round, and return 1 if a claim is violated at its end, else 0.

    Raises:
        BadInput: the trace cannot be read, cannot happen, or does not show what it says.
    """
    console = terminal.text()
    replayed = replay(read(options.trace))
    console.print(f"[bold]{replayed.scope.swarm()}, semantics {replayed.reading.name()}[/bold]")
    telling = of_system(replayed.system, "telling", "swarmproof.pages.telling")
    cast(Callable[[Console, Replay], None], telling.print_run)(console, replayed)  # type: ignore[attr-defined]
    return ExitCode.VIOLATED if replayed.is_violation else ExitCode.WELL
