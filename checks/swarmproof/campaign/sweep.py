"""Flies many cells in several processes: nothing that is measured depends on their number."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from swarmproof.campaign.pool import run_jobs
from swarmproof.campaign.store import Stored
from swarmproof.campaign.trial import Cell
from swarmproof.dmpc_swarm.experiments.measure import measure


def sweep(
    cells: Sequence[Cell], processes: int, on_cell: Callable[[Cell, Stored], None], say: Callable[[str], None]
) -> bool:
    """Fly the cells, each in one of some processes; say whether all were flown, which they are unless interrupted.

    Args:
        cells: in the order in which they are begun.
        processes: how many fly at the same time.
        on_cell: called with each cell as soon as it is measured.
        say: told in one sentence of a process that was killed.

    Raises:
        BadInput: a cell that cannot be flown.
        Failed: processes are killed again and again.
    """
    return run_jobs(fly_cell, cells, processes, on_cell, say)


def fly_cell(cell: Cell) -> Stored:
    """Measure one cell: what a process does."""
    begin = time.process_time()
    measured = measure(cell)
    return Stored(measured, time.process_time() - begin)
