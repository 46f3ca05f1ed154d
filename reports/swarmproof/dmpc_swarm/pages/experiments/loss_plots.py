"""The picture of the sweep of independent message loss: collisions, separation, arrival and planning against loss."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from swarmproof.campaign.statistics import median_interval, proportion_interval
from swarmproof.claims.samples import Label
from swarmproof.dmpc_swarm.pages.experiments.drawing import (
    COLLISION,
    METHOD_COLOURS,
    Picture,
    edge,
    not_reached,
    render,
    say_missing,
    spread,
    with_interval,
)
from swarmproof.dmpc_swarm.pages.experiments.numbers import D_HAT_MIN, D_MIN, METHODS, Data, collisions, numbers
from swarmproof.pages.plot_style import ASKED, GREY, KEPT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: By rank of N: line and marker.
_LINES = ((":", "o", "white"), ("-", "s", None))
#: How much of the way from one loss to the next the markers of all lines take.
_WIDTH = 0.75


def loss_pictures(data: Data) -> list[Picture]:
    """Return the picture of the sweep."""
    words = "; ".join(
        f"{method} {collisions(seen):,} of {len(seen):,}" for method in METHODS if (seen := data.among(method=method))
    )
    return [
        Picture(
            "loss.png",
            "What independent loss does, with and without handling it",
            render(lambda figure: _draw(figure, data), 12, 9),
            "Colour: the method; dotted lines and circles: 10 UAVs, full lines and squares: 16. Collisions: points are "
            "shares of seeds, with their exact 95 % interval. Elsewhere: medians over seeds with their 95 % interval; "
            "small crosses are the smallest separation of all seeds. Triangles count flights that do not arrive. "
            f"Flights with a collision, over all losses: {words or 'none was flown'}.",
        )
    ]


def _draw(figure: Figure, data: Data) -> None:
    (collide, apart), (arrive, plan) = figure.subplots(2, 2)
    percents = [one for one in data.labels("loss_percent") if isinstance(one, int)] or [0, 10]
    sizes = data.labels("uavs")
    lines: list[tuple[str, Label, int]] = [(one, uavs, rank) for one in METHODS for rank, uavs in enumerate(sizes)]
    step = min((b - a for a, b in pairwise(percents)), default=1)
    top = edge(data.values("arrival_s"), 1)
    handles, highest = [], []
    for (method, uavs, rank), offset in zip(lines, spread(len(lines), _WIDTH * step), strict=True):
        dash, marker, face = _LINES[min(rank, 1)]
        colour = METHOD_COLOURS[method]
        style = {"marker": marker, "ms": 5.5, "mew": 1.4, "mfc": face or colour, "lw": 1.4}
        by_loss = [(p, p + offset, data.among(method=method, uavs=uavs, loss_percent=p)) for p in percents]
        there = [(p, x, seen) for p, x, seen in by_loss if seen]
        if not there:
            continue
        for _, x, seen in there:
            low, high = proportion_interval(collisions(seen), len(seen))
            highest.append(high)
            collide.plot([x, x], [low, high], color=colour, lw=1.2, alpha=0.6)
            share = collisions(seen) / len(seen)
            collide.plot([x], [share], color=colour, zorder=4, clip_on=False, **style)
            for axes, value, limit in (
                (apart, "separation_m", math.inf), (arrive, "arrival_s", top), (plan, "all_plan", math.inf)
            ):  # fmt: skip
                with_interval(axes, x, numbers(seen, value), colour, limit, **style)
            apart.plot([x], [min(numbers(seen, "separation_m"))], "x", color=colour, ms=5, mew=1)
            not_reached(arrive, x, top, numbers(seen, "arrival_s"), colour, size=8)
        xs = [x for _, x, _ in there]
        _join(collide, xs, [collisions(seen) / len(seen) for _, _, seen in there], colour, dash)
        for axes, value in ((apart, "separation_m"), (arrive, "arrival_s"), (plan, "all_plan")):
            medians = [min(median_interval(numbers(seen, value))[1], top) for _, _, seen in there]
            _join(axes, xs, medians, colour, dash)
        label = f"{method}, {uavs} UAVs"
        handles.append(collide.plot([], [], dash, color=colour, label=label, **style)[0])
    for axes, title, unit in (
        (collide, "Collisions", "share of seeds with a collision"),
        (apart, "Smallest separation in a flight", "m, scaled"),
        (arrive, "Time until all UAVs are at their targets", "s"),
        (plan, "Rounds in which all CUs plan", "share of all rounds"),
    ):
        axes.set_title(title, weight="bold", pad=16)
        axes.set(xlabel="messages lost at each receiver (%)", ylabel=unit)
        axes.set_xticks(percents)
        axes.set_xlim(percents[0] - 0.5 * step, percents[-1] + 0.5 * step)
        axes.grid(axis="y", color="#E3E6E9", lw=0.8)
        if not data.seen:
            say_missing(axes)
    collide.set(ylim=(0, min(1, 1.05 * max(highest, default=1))))
    collide.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    plan.set(ylim=(0, 1))
    plan.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    apart.set(ylim=(0, edge([*data.values("separation_m"), D_HAT_MIN], D_HAT_MIN)))
    arrive.set(ylim=(0, top))
    for level, name, colour in ((D_MIN, f"{ASKED}:\ncollision\nbelow", COLLISION), (D_HAT_MIN, KEPT, GREY)):
        apart.axhline(level, color=colour, lw=1.2, zorder=1)
        apart.annotate(name, (1, level), (5, 0), xycoords=("axes fraction", "data"), textcoords="offset points",
                       va="center", color=colour, annotation_clip=False)  # fmt: skip
    if handles:
        figure.legend(handles=handles, loc="outside upper center", ncols=-(-len(handles) // len(sizes)))


def _join(axes: Axes, xs: Sequence[float], ys: Sequence[float], colour: str, dash: str) -> None:
    axes.plot(xs, ys, dash, color=colour, lw=1.2, alpha=0.7, zorder=2)
