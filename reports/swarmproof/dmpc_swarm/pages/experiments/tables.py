"""The numbers behind the pictures of an experiment, as tables of text, and every cell as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median

from swarmproof.claims.samples import Observation, runs
from swarmproof.dmpc_swarm.claims.experiments import FOR_EVER, FORMATIONS, IGNORING, MLR, PERIOD_S
from swarmproof.dmpc_swarm.pages.experiments.numbers import (
    METHODS,
    TRIGGERS,
    Data,
    collisions,
    counted,
    cus,
    distances,
    numbers,
    shares,
    times,
)


@dataclass(frozen=True)
class NumberTable:
    """A table of text; the first column names the row."""

    title: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]


def tables(data: Data) -> list[NumberTable]:
    """Return the tables of an experiment: medians over seeds with 95 % intervals, shares with exact ones."""
    return _TABLES[data.experiment.name](data)


def _formations(data: Data) -> list[NumberTable]:
    conditions = sorted({(cell.cus, cell.trigger) for cell in data.cells}, key=_rank)
    readings = (
        ("Time to target: all UAVs there at once", "time_to_target_s"),
        ("Arrival of the first quarter of the UAVs", "first_quarter_s"),
        ("From the first quarter to the last UAV", "spread_s"),
    )
    return [
        NumberTable(
            title,
            ["", *FORMATIONS],
            [
                [
                    f"{cus(m)}, {trigger}",
                    *(times(data.values(value, cus=m, trigger=trigger, formation=one)) for one in FORMATIONS),
                ]
                for m, trigger in conditions
            ],
        )
        for title, value in readings
    ]


def _rank(condition: tuple[int, str]) -> tuple[int, int]:
    m, trigger = condition
    return -m, TRIGGERS.index(trigger)


def _jams(data: Data) -> list[NumberTable]:
    ending = [int(length) for length in data.labels("jam_rounds") if length != FOR_EVER]
    rows = []
    for length in ending:
        for method in (MLR, IGNORING):
            name = f"{length} rounds ({PERIOD_S * length:.1f} s), {method}"
            seen = data.among(method=method, jam_rounds=length)
            rows.append(_jam(name, seen))
            rows.append(_jam(f"{name}, from round 0 on", [one for one in seen if one.labels["jam_start"] == 0]))
    endless = runs(data.among(jam_rounds=FOR_EVER))
    for_ever = [
        f"{sum(map(len, endless)):,}",
        times([max(numbers(seen, "halted_s")) for seen in endless], "not at rest"),
        distances([min(numbers(seen, "separation_m")) for seen in endless]),
    ]
    return [
        NumberTable(
            "Jams that end, from any of the rounds 0 to 25 on, or from round 0 on as in the paper",
            [
                "",
                "flights that collide",
                "seeds with a collision",
                "smallest separation of a seed",
                "arrival, median of a seed",
            ],
            rows,
        ),
        NumberTable(
            "Jams that do not end, MLR-DMPC",
            ["flights", "until all rest, longest of a seed", "smallest separation of a seed"],
            [for_ever] if endless else [],
        ),
    ]


def _jam(name: str, seen: Sequence[Observation]) -> list[str]:
    seeds = runs(seen)  # flights of one seed are one repetition, not many
    return [
        name,
        f"{collisions(seen):,} of {len(seen):,}",
        counted(sum(collisions(one) > 0 for one in seeds), len(seeds)),
        distances([min(numbers(one, "separation_m")) for one in seeds]),
        times([median(numbers(one, "arrival_s")) for one in seeds], "not within the flight"),
    ]


def _loss(data: Data) -> list[NumberTable]:
    result = []
    for method in METHODS:
        rows = []
        for uavs in data.labels("uavs"):
            for percent in data.labels("loss_percent"):
                seen = data.among(method=method, uavs=uavs, loss_percent=percent)
                rows.append(
                    [
                        f"{uavs} UAVs, {percent} %",
                        counted(collisions(seen), len(seen)),
                        distances(numbers(seen, "separation_m")),
                        times(numbers(seen, "arrival_s"), "not in time"),
                        shares(numbers(seen, "all_plan")),
                    ]
                )
        headings = ["", "flights that collide", "smallest separation", "arrival", "rounds in which all CUs plan"]
        result.append(NumberTable(method, headings, rows))
    return result


_TABLES: Mapping[str, Callable[[Data], list[NumberTable]]] = {
    "fig3b": _formations,
    "fig3c": _formations,
    "fig4": _jams,
    "loss": _loss,
}


def cells_csv(every: Sequence[Data]) -> str:
    """Return a row for each observation of each cell and variant: labels, values with all their digits, the command."""
    labels = list(dict.fromkeys(name for data in every for seen in data.seen for name in seen.labels))
    values = list(dict.fromkeys(name for data in every for seen in data.seen for name in seen.values))
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["variant", "cell", "seed", *labels, *values, "command"])
    for data in every:
        for cell, stored in data.cells.items():
            for seen in data.experiment.observe(cell, stored.measured, data.variant.radius):
                rows.writerow(
                    [
                        data.variant.name,
                        cell.id,
                        seen.seed,
                        *(seen.labels[name] for name in labels),
                        *("" if seen.values[name] is None else repr(seen.values[name]) for name in values),
                        cell.command,
                    ]
                )
    return text.getvalue()
