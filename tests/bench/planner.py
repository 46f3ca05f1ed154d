"""The benchmark: `python -m tests.bench.planner [--quick] [--json FILE]`.

The tasks that CUs plan in flights of the scenario `circle`, 16 UAVs and 3 CUs, are recorded and planned again in
several ways, in turns; whole flights with all checks are timed after that. Everything runs in one thread: where numpy
may use more, the process starts itself again with the environment that forbids it.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table
from tests.bench.contest import OURS, SOLVERS, Calls, Parts, contenders, parts, race
from tests.bench.flights import Timed, time_flights
from tests.bench.recording import record

from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.errors import BadInput, Failed
from swarmproof.faults.grammar import parse
from swarmproof.files.writing import write
from swarmproof.motion.lattice import Floats
from swarmproof.scenario.scenario import load

SCHEMA = "swarmproof.bench/1"
#: How many threads numpy and the solvers may use is read from these when they are imported.
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS")
CUS = 3
#: Losses of the flights whose tasks are recorded: with some, trackers hold two trajectories of a UAV more often.
RECORDED = ("none", "iid:0.05")
#: Losses of the flights that are timed, and how often each is flown.
FLOWN, REPEATS = ("none", "iid:0.1"), 3
#: `--quick` does one part in so many.
QUICK = 10
#: Goals: ms of a planner call in the middle; how much faster than real time a flight is.
MOST_MS, LEAST_TIMES = 1.0, 20.0


@dataclass(frozen=True)
class Size:
    """How much is measured: every so manieth task, and flights of so many rounds, so often."""

    every: int
    rounds: int
    repeats: int


@dataclass(frozen=True)
class Figures:
    """Everything that was measured.

    Attributes:
        two: in how many tasks some UAV has two trajectories or more.
        calls: by contender.
        skipped: solvers that did not take part, and why.
    """

    uavs: int
    tasks: int
    two: int
    calls: dict[str, Calls]
    skipped: dict[str, str]
    parts: Parts
    flights: tuple[Timed, ...]

    @property
    def median(self) -> float:
        """Of our calls when they have the machine to themselves, in ms."""
        return _ms(self.parts.whole)[0]

    @property
    def slowest(self) -> float:
        """How much faster than real time the slowest of the flights is."""
        return min(flight.times_real_time for flight in self.flights)


def circle(changes: Sequence[str] = (), cus: int = CUS) -> Setting:
    """Return the setting of all flights here."""
    semantics = Semantics.parse("guarded", ["initial=known", "event_trigger=round-robin"])
    return Setting(load("circle", 0, changes), cus, Trigger.HT, semantics, 0)


def measure(setting: Setting, size: Size, names: Sequence[str] = SOLVERS) -> Figures:
    """Record, race and fly.

    Args:
        setting: of all flights.
        size: how much.
        names: solvers to compare with.
    """
    scenario = setting.scenario
    tasks: list[Task] = []
    for loss in RECORDED:
        losses = parse(loss, scenario.uavs, setting.cus, setting.seed)
        tasks += record(setting, losses, scenario.rounds)[:: size.every]
    lattice = setting.flight().lattice
    ways, skipped = contenders(lattice, scenario.weights, names)
    two = sum(any(len(held) > 1 for held in task.others.values()) for task in tasks)
    calls = race(ways, tasks)
    ours = parts(lattice, scenario.weights, tasks)
    flights = tuple(time_flights(setting, loss, size.rounds, size.repeats) for loss in FLOWN)
    return Figures(scenario.uavs, len(tasks), two, calls, skipped, ours, flights)


def document(figures: Figures) -> dict[str, Any]:
    """Return the figures as JSON has them; times in ms, ratios to our median in the same turns."""
    ours, reference = figures.parts, _ms(figures.calls[OURS].seconds)[0]
    return {
        "schema": SCHEMA,
        "versions": {name: version(name) for name in ("numpy", "piqp")},
        "uavs": figures.uavs,
        "tasks": figures.tasks,
        "tasks_with_two_trajectories": figures.two,
        "calls": [
            {
                "name": name,
                "median_ms": _ms(calls.seconds)[0],
                "p95_ms": _ms(calls.seconds)[1],
                "ratio": _ms(calls.seconds)[0] / reference,
                "accepted": calls.accepted,
                "rejected": len(calls.planned) - calls.accepted,
            }
            for name, calls in figures.calls.items()
        ],
        "skipped": figures.skipped,
        "parts": {
            name: {"median_ms": _ms(seconds)[0], "p95_ms": _ms(seconds)[1]}
            for name, seconds in (
                ("build", ours.build),
                ("solver", ours.solver),
                ("accept", ours.accept),
                ("all", ours.whole),
            )
        },
        "solves_per_call": float(ours.solves.mean()),
        "flights": [
            {
                "loss": flight.loss,
                "rounds": flight.rounds,
                "seconds": list(flight.seconds),
                "rounds_per_second": flight.rounds_per_second,
                "times_real_time": flight.times_real_time,
            }
            for flight in figures.flights
        ],
        "goals": {"median_ms": figures.median <= MOST_MS, "times_real_time": figures.slowest >= LEAST_TIMES},
    }


def show(console: Console, figures: Figures) -> None:
    """Print the figures."""
    found = document(figures)
    console.print(
        f"[bold]Planner calls: {figures.tasks} tasks of circle flights with {figures.uavs} UAVs, until all have "
        f"arrived.[/bold] In {figures.two}, some UAV has two trajectories. Build, solve and accept; all take turns."
    )
    table = _table("how", "median ms", "95 % ms", "ratio", "plans", "none")
    for row in found["calls"]:
        times = (f"{row['median_ms']:.2f}", f"{row['p95_ms']:.2f}", f"{row['ratio']:.2f}")
        table.add_row(escape(row["name"]), *times, str(row["accepted"]), str(row["rejected"]))
    console.print(table)
    for name, why in figures.skipped.items():
        console.print(f"Left out: {escape(name)}, since {escape(why)}.")
    table = _table("our calls without the others", "median ms", "95 % ms")
    for name, times in found["parts"].items():
        table.add_row(name, f"{times['median_ms']:.2f}", f"{times['p95_ms']:.2f}")
    console.print(table)
    console.print(f"The solver is asked {found['solves_per_call']:.2f} times a call.")
    table = _table("flight with all checks", "rounds", "rounds/s", "times real time")
    for flight in figures.flights:
        speed = (f"{flight.rounds_per_second:.0f}", f"{flight.times_real_time:.1f}")
        table.add_row(escape(flight.loss), str(flight.rounds), *speed)
    console.print(table)
    for goal, met, value in (
        (f"median call ≤ {MOST_MS:g} ms", found["goals"]["median_ms"], f"{figures.median:.2f} ms"),
        (f"flights ≥ {LEAST_TIMES:g} × real time", found["goals"]["times_real_time"], f"{figures.slowest:.1f} ×"),
    ):
        console.print(f"Goal {goal}: {value}, {'[green]met[/]' if met else '[yellow]not met[/]'}.")


def _table(*headings: str) -> Table:
    table = Table(box=None, padding=(0, 1))
    for place, heading in enumerate(headings):
        table.add_column(heading, justify="right" if place else "left", no_wrap=bool(place), overflow="fold")
    return table


def _ms(seconds: Sequence[float] | Floats) -> tuple[float, float]:
    """Return the median and the 95 % quantile in ms."""
    median, high = np.percentile(np.asarray(seconds) * 1e3, [50, 95])
    return float(median), float(high)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and return the exit code: 0, however long it takes, or 2 for bad input."""
    parser = argparse.ArgumentParser(prog="tests.bench.planner", description=__doc__, allow_abbrev=False)
    parser.add_argument("--quick", action="store_true", help=f"measure one part in {QUICK}")
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the figures as JSON")
    options = parser.parse_args(arguments)
    setting = circle()
    rounds = setting.scenario.rounds
    size = Size(QUICK, rounds // QUICK, 1) if options.quick else Size(1, rounds, REPEATS)
    try:
        if options.json is not None and not os.access(options.json.parent, os.W_OK):
            raise BadInput(f"cannot write {options.json}: give a file in a folder that is there and can be written to")
        figures = measure(setting, size)
        if options.json is not None:
            write(options.json, json.dumps(document(figures), indent=2) + "\n")
    except (BadInput, Failed) as mistake:
        print(f"tests.bench: {mistake}", file=sys.stderr)
        return 2
    show(Console(highlight=False), figures)
    return 0


if __name__ == "__main__":
    if any(os.environ.get(name) != "1" for name in THREADS):
        os.execve(sys.executable, sys.orig_argv, {**os.environ, **dict.fromkeys(THREADS, "1")})
    sys.exit(main())
