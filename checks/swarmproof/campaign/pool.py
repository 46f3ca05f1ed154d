"""The pool: many jobs in several processes. None outlives the process that began it, and none is lost by a kill.

Each process computes with one thread, so that nothing depends on their number.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import TypeVar

from swarmproof.campaign.deferred import SIGNALS, deferred
from swarmproof.errors import Failed

Job = TypeVar("Job")
Result = TypeVar("Result")

#: What libraries of linear algebra read when they are loaded.
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
#: How often processes may be killed, one time after another, while no job is finished.
MOST_KILLS = 3


def run_jobs(
    work: Callable[[Job], Result],
    jobs: Sequence[Job],
    processes: int,
    on_done: Callable[[Job, Result], None],
    say: Callable[[str], None],
) -> bool:
    """Do all jobs, and say whether all are done, which they are unless interrupted.

    Args:
        work: does one job in a process of the pool; a function that can be imported there.
        jobs: in the order in which they are begun.
        processes: how many work at the same time.
        on_done: called with each job and its result, as soon as there is one.
        say: told, in one sentence, that a process was killed; what it had begun is begun again.

    Raises:
        Failed: processes are killed again and again.
        Exception: what `work` or `on_done` raised.
    """
    waiting = deque(jobs)
    kills = 0
    while waiting:
        left = len(waiting)
        try:
            _until_a_kill(work, waiting, min(processes, len(waiting)), on_done)
        except KeyboardInterrupt:
            return False
        except BrokenProcessPool:
            kills = 1 if len(waiting) < left else kills + 1
            if kills >= MOST_KILLS:
                raise Failed(
                    "processes were ended from outside again and again, perhaps for want of memory: run the command "
                    "again with fewer processes, or on a machine with more memory"
                ) from None
            say("a process was ended from outside, perhaps for want of memory: what it had begun is begun again")
    return True


def _until_a_kill(
    work: Callable[[Job], Result], waiting: deque[Job], processes: int, on_done: Callable[[Job, Result], None]
) -> None:
    """Do jobs until none is waiting; whatever ends it earlier, the jobs that are not done are waiting then."""
    running: dict[Future[Result], Job] = {}
    pool = ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), initializer=_obey)
    try:
        with _one_thread():
            _submit(pool, work, waiting, running, 2 * processes)
            while running:
                done, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    result = future.result()
                    job = running.pop(future)
                    on_done(job, result)
                    _submit(pool, work, waiting, running, 1)
    except BaseException:
        waiting.extendleft(reversed(running.values()))
        _stop(pool)
        raise
    pool.shutdown()


def _submit(
    pool: ProcessPoolExecutor,
    work: Callable[[Job], Result],
    waiting: deque[Job],
    running: dict[Future[Result], Job],
    most: int,
) -> None:
    """Give the pool some jobs: few at any time, so that an interrupt has little to forget."""
    with deferred(), _signals_wait():  # a process may begin
        for _ in range(min(most, len(waiting))):
            future = pool.submit(work, waiting[0])
            running[future] = waiting.popleft()


def _obey() -> None:
    """Leave interrupts to the process that began this one, and end when it does, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
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
def _signals_wait() -> Iterator[None]:
    """Let signals wait in the processes that begin meanwhile until they can obey.

    In this process, :func:`deferred` does that: a signal that this thread blocks reaches another, such as one of linear
    algebra, and Python handles it in this thread all the same.
    """
    resource_tracker.ensure_running()  # which, when it begins, lets signals through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


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
