"""Flies many cells in several processes, each of which computes with one thread: nothing depends on their number."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import islice

from swarmproof.errors import BadInput
from swarmproof.reproduce.cell import Cell
from swarmproof.reproduce.measure import measure
from swarmproof.reproduce.store import Stored

#: What libraries of linear algebra read when they are loaded.
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


def sweep(cells: Sequence[Cell], processes: int, on_cell: Callable[[Cell, Stored], None]) -> bool:
    """Fly the cells, each in one of some processes; say whether all were flown, which they are unless interrupted.

    Args:
        cells: in the order in which they are begun.
        processes: how many fly at the same time.
        on_cell: called with each cell as soon as it is measured.

    Raises:
        BadInput: a cell that cannot be flown, or a process that was ended from outside.
    """
    waiting = iter(cells)
    with _one_thread(), _pool(min(processes, len(cells)) or 1) as pool:
        # few are waiting in the pool at any time, so that an interrupt has little to forget
        running: dict[Future[Stored], Cell] = {
            pool.submit(fly_cell, cell): cell for cell in islice(waiting, 2 * processes)
        }
        try:
            while running:
                done, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    cell = running.pop(future)
                    stored = future.result()
                    on_cell(cell, stored)
                    for following in islice(waiting, 1):
                        running[pool.submit(fly_cell, following)] = following
        except KeyboardInterrupt:
            _stop(pool)
            return False
        except BrokenProcessPool:
            _stop(pool)
            raise BadInput(
                "a process that flew a cell was ended from outside, perhaps for want of memory: run the command again, "
                "which goes on from here, or with fewer --processes"
            ) from None
        except BaseException:
            _stop(pool)
            raise
    return True


def fly_cell(cell: Cell) -> Stored:
    """Measure one cell: what a process does."""
    begin = time.process_time()
    measured = measure(cell)
    return Stored(measured, time.process_time() - begin)


def _pool(processes: int) -> ProcessPoolExecutor:
    # new interpreters, which load their libraries under _one_thread
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(processes, context, initializer=_obey)


def _obey() -> None:
    """Leave interrupts to the process that began this one, and end when it does, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _stop(pool: ProcessPoolExecutor) -> None:
    pool.shutdown(wait=False, cancel_futures=True)
    for worker in multiprocessing.active_children():  # what a worker has begun, nobody waits for any more
        worker.terminate()


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let processes that begin now compute with one thread each."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
