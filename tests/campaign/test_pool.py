"""The pool, by sweeps of cells: results do not depend on processes or order; what goes wrong is one sentence, no hang.

A process takes a second to begin, so several things are asked of each sweep.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from swarmproof.campaign import pool as module
from swarmproof.campaign.store import Stored
from swarmproof.campaign.sweep import fly_cell, sweep
from swarmproof.campaign.trial import Cell
from swarmproof.dmpc_swarm.experiments.measure import measure
from swarmproof.errors import BadInput, Failed

#: Flights that take no time, and one that takes ten minutes and more.
CELLS = [Cell("crossing", 2, "HT", "iid:0.1", "guarded", seed, 12 + seed) for seed in range(6)]
LONG = Cell("circle", 3, "HT", "none", "guarded", 0, 90_000)
#: s; less than that flight takes on any machine, and more than the others take on the slowest.
LONG_S = 600
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
#: Begins long flights in two processes, and says which these are.
BEGIN = f"""
import multiprocessing, threading, time
from swarmproof.campaign.trial import Cell
from swarmproof.campaign.sweep import sweep
def say():
    while len(multiprocessing.active_children()) < 2:
        time.sleep(0.01)
    print(*(child.pid for child in multiprocessing.active_children()), flush=True)
threading.Thread(target=say, daemon=True).start()
sweep([{CELLS[0]!r}, {LONG!r}, {LONG!r}], 2, lambda cell, stored: print("flown", flush=True), print)
"""


@pytest.fixture(autouse=True)
def _nothing_left(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let no test have processes after it, nor a change of the environment."""
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    before = dict(os.environ)
    yield
    # pytest itself notes in the environment where it is
    ours = {name: value for name, value in os.environ.items() if name != "PYTEST_CURRENT_TEST"}
    assert ours == {name: value for name, value in before.items() if name != "PYTEST_CURRENT_TEST"}
    deadline = time.monotonic() + 100
    while multiprocessing.active_children() and time.monotonic() < deadline:
        time.sleep(0.01)
    assert not multiprocessing.active_children()


def unheard(sentence: str) -> None:
    """Fail if a process was killed."""
    raise AssertionError(sentence)


def no_result(cell: Cell, stored: Stored) -> None:
    """Fail if a cell was flown."""
    raise AssertionError(cell)


def test_neither_processes_nor_order_matter() -> None:
    """Each cell is told once, with the numbers that this process measures, to the bit; workers have one thread."""
    found: list[dict[Cell, Stored]] = []
    for cells, processes in ((CELLS, 2), (CELLS[::-1], 1)):
        told: dict[Cell, Stored] = {}

        def on_cell(cell: Cell, stored: Stored, told: dict[Cell, Stored] = told, wanted: int = processes) -> None:
            assert cell not in told
            told[cell] = stored
            workers = multiprocessing.active_children()
            assert len(workers) == wanted
            assert [os.environ[name] for name in THREADS] == ["1"] * len(THREADS)
            for worker in workers:
                environment = Path(f"/proc/{worker.pid}/environ")
                if environment.exists():
                    given = environment.read_text(encoding="utf-8").split("\0")
                    assert {f"{name}=1" for name in THREADS} <= set(given)

        assert sweep(cells, processes, on_cell, unheard) is True
        assert set(told) == set(cells)
        assert all(stored.seconds > 0 for stored in told.values())
        found.append(told)
    two_processes, one_process = found
    for cell in CELLS:
        assert repr(one_process[cell].measured) == repr(two_processes[cell].measured) == repr(measure(cell))
    assert list(one_process) != list(two_processes)


def no_result_at_all(job: int, result: object) -> None:
    """Fail if a job was done."""
    raise AssertionError(job)


def test_nothing_to_fly_is_flown_at_once() -> None:
    """Without cells no process begins, and all were flown."""
    assert sweep([], 2, no_result, unheard) is True
    assert multiprocessing.active_children() == []


def test_seconds_are_of_processor_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a cell takes is the time of the process that flies it."""
    times = iter([5.0, 7.5])
    monkeypatch.setattr(time, "process_time", lambda: next(times))
    assert fly_cell(CELLS[0]) == Stored(measure(CELLS[0]), 2.5)


def test_bad_input_in_a_process_arrives() -> None:
    """A cell that cannot be flown ends the sweep with the sentence that says so; others that wait are not begun."""
    with pytest.raises(BadInput, match="fog") as error:
        sweep([replace(CELLS[0], loss="fog"), *[LONG] * 9], 2, no_result, unheard)
    assert "\n" not in str(error.value)


def test_a_mistake_while_a_result_is_kept_arrives() -> None:
    """If a result cannot be kept, the sweep ends with that, and does not wait for what is being flown."""
    begin = time.monotonic()

    def full(cell: Cell, stored: Stored) -> None:
        raise BadInput("the disk is full")

    with pytest.raises(BadInput, match="the disk is full"):
        sweep([CELLS[0], *[LONG] * 3], 2, full, unheard)
    assert time.monotonic() - begin < LONG_S / 2


def kill_all() -> None:
    """End all processes of the sweep as a lack of memory would, once there is one."""
    while not multiprocessing.active_children():
        time.sleep(0.01)
    for child in multiprocessing.active_children():
        assert child.pid is not None
        os.kill(child.pid, signal.SIGKILL)


def test_a_process_that_is_killed_costs_one_sentence() -> None:
    """What it had begun is begun again: every cell is told once, and the sweep is complete."""
    told: list[Cell] = []
    heard: list[str] = []

    def on_cell(cell: Cell, stored: Stored) -> None:
        told.append(cell)
        if len(told) == 1:
            kill_all()
            time.sleep(0.5)

    assert sweep(CELLS, 2, on_cell, heard.append) is True
    assert sorted(told, key=CELLS.index) == CELLS
    (sentence,) = heard
    assert "ended from outside" in sentence
    assert "\n" not in sentence


def test_processes_that_are_always_killed_end_the_sweep() -> None:
    """A job that kills whoever begins it is not begun for ever: one sentence says so, and nothing hangs."""
    heard: list[str] = []
    with pytest.raises(Failed, match=r"again and again.* fewer processes, or on a machine with more memory$"):
        module.run_jobs(os._exit, [1, 2], 1, no_result_at_all, heard.append)
    assert len(heard) == module.MOST_KILLS - 1


def test_an_interrupt_ends_the_sweep_at_once() -> None:
    """Not all were flown, what is being flown is given up, and what was told before stays told."""
    told = []
    begin = time.monotonic()

    def on_cell(cell: Cell, stored: Stored) -> None:
        told.append(cell)
        os.kill(os.getpid(), signal.SIGINT)

    try:
        complete = sweep([CELLS[0], *[LONG] * 9], 2, on_cell, unheard)
    except KeyboardInterrupt:
        pytest.fail("the interrupt went on, and would end all tests")
    assert complete is False
    assert told == [CELLS[0]]
    assert time.monotonic() - begin < LONG_S / 2


def test_few_cells_are_given_away_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """At most two for each process, so that what is begun after an interrupt is little."""
    most = 0
    pending: set[Future[object]] = set()
    real = ProcessPoolExecutor.submit

    def submit(self: ProcessPoolExecutor, *arguments: object) -> Future[object]:
        nonlocal most
        future: Future[object] = real(self, *arguments)  # type: ignore[arg-type]
        pending.add(future)
        most = max(most, len(pending))
        return future

    monkeypatch.setattr(ProcessPoolExecutor, "submit", submit)
    told = []

    def on_cell(cell: Cell, stored: Stored) -> None:
        told.append(cell)
        pending.difference_update([one for one in pending if one.done()])

    assert sweep(CELLS, 1, on_cell, unheard) is True
    assert told == CELLS
    assert most == 2


def test_processes_end_with_the_one_that_began_them() -> None:
    """Killed without a chance to tell anybody, a sweep leaves no process behind that computes on."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with subprocess.Popen([sys.executable, "-c", BEGIN], stdout=subprocess.PIPE, text=True, env=environment) as begun:
        assert begun.stdout is not None
        workers = [int(pid) for pid in begun.stdout.readline().split()]
        try:
            assert len(workers) == 2
            assert begun.stdout.readline() == "flown\n"
            begun.send_signal(signal.SIGKILL)
            # they have this output, too: it ends when the last of them has
            rest, _ = begun.communicate(timeout=200)
            assert rest == ""
        finally:
            begun.kill()
            for pid in workers:
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    continue


def test_threads_are_given_back() -> None:
    """Inside, there is one thread for each library; afterwards, what was there before, also after a mistake."""
    before = {name: os.environ.get(name) for name in THREADS}
    assert before["MKL_NUM_THREADS"] is None
    inside: dict[str, str | None] = {}

    def mistaken() -> None:
        with module._one_thread():
            inside.update({name: os.environ.get(name) for name in THREADS})
            raise ValueError("mistake")

    with pytest.raises(ValueError, match="mistake"):
        mistaken()
    assert inside == dict.fromkeys(THREADS, "1")
    assert {name: os.environ.get(name) for name in THREADS} == before


def test_no_signal_cuts_the_beginning_of_a_process_in_two() -> None:
    """A signal that reaches another thread while a process begins is handled after that, and no job is forgotten."""
    begun: list[str] = []

    class Beginning:
        """A pool whose process is told to end while it begins."""

        def submit(self, work: object, job: str) -> Future[str]:
            os.kill(os.getpid(), signal.SIGINT)
            for _ in range(20):  # a signal is handled between two steps of Python
                time.sleep(0.005)
            begun.append(job)
            return Future()

    ended = threading.Event()
    other = threading.Thread(target=ended.wait)  # it does not block the signal
    other.start()
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    running: dict[Future[str], str] = {}
    pool: Any = Beginning()
    try:
        with pytest.raises(KeyboardInterrupt):
            module._submit(pool, str, deque(["one", "other"]), running, 1)
    finally:
        signal.signal(signal.SIGINT, before)
        ended.set()
        other.join()
    assert begun == list(running.values()) == ["one"]
