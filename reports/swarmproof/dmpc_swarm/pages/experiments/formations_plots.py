"""The pictures of Fig. 3b and 3c: distances to targets over time, times to target, and arrivals one by one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from swarmproof.dmpc_swarm.claims.experiments import FORMATIONS, PERIOD_S
from swarmproof.dmpc_swarm.experiments.measure import RADII, REACHED, Leg
from swarmproof.dmpc_swarm.pages.experiments.drawing import (
    CUS_COLOURS,
    TRIGGER_COLOURS,
    Picture,
    edge,
    not_reached,
    render,
    say_missing,
    spread,
    with_interval,
)
from swarmproof.dmpc_swarm.pages.experiments.numbers import TRIGGERS, Data, cus
from swarmproof.pages.plot_style import GREY, INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: M and trigger, with how it is called and its colour.
Condition = tuple[int, str, str, str]
CUS_CONDITIONS: tuple[Condition, ...] = tuple((m, "HT", cus(m), CUS_COLOURS[m]) for m in (1, 2, 3))
TRIGGER_CONDITIONS: tuple[Condition, ...] = tuple((3, one, one, TRIGGER_COLOURS[one]) for one in TRIGGERS)
#: m; below, a distance is drawn here: the axis is logarithmic.
_LEAST, _MOST = 0.008, 5.0


def fig3b_pictures(data: Data) -> list[Picture]:
    """Return the pictures of the experiment on the number of CUs."""
    totals = ", ".join(f"{total(data, m, 'HT')} with {name}" for m, _, name, _ in CUS_CONDITIONS)
    return [
        _distances(data, CUS_CONDITIONS, "Distance to target, by number of CUs"),
        Picture(
            "times.png",
            "Time to target, by number of CUs",
            render(lambda figure: _draw_times(figure, data, [("", CUS_CONDITIONS)]), 12, 5),
            f"Lower is faster. Medians of the four formations together: {totals}. {_TIMES}",
        ),
    ]


def fig3c_pictures(data: Data) -> list[Picture]:
    """Return the pictures of the experiment on the event trigger."""
    groups = [
        (cus(m), [(m, one, one, TRIGGER_COLOURS[one]) for one in TRIGGERS])
        for m in (3, 2, 1)
        if m == 3 or any(cell.cus == m for cell in data.variant.cells)
    ]
    totals = ", ".join(f"{total(data, 3, one)} with {one}" for one in TRIGGERS)
    return [
        _distances(data, TRIGGER_CONDITIONS, "Distance to target, by trigger, with 3 CUs"),
        Picture(
            "times.png",
            "Time to target, by trigger",
            render(lambda figure: _draw_times(figure, data, groups), 12, 5 if len(groups) == 1 else 8.4),
            f"Lower is faster. With 3 CUs, medians of the four formations together: {totals}. {_TIMES}",
        ),
        Picture(
            "arrivals.png",
            "Arrivals one by one, by trigger, with 3 CUs",
            render(lambda figure: _draw_arrivals(figure, data), 12, 4.2),
            "How many UAVs have been at their targets, by time: the further left a curve begins, the earlier the first "
            "arrive; the steeper it is, the more of them arrive together. Each step is the median over seeds of that "
            "arrival. Dotted: a quarter of the UAVs, and all of them.",
        ),
    ]


_TIMES = (
    "Each dot is a seed; the line is the median with its 95 % interval over seeds. A triangle at the top counts seeds "
    "with which the formation was not reached."
)


def total(data: Data, m: int, trigger: str) -> str:
    """Return the sum over formations of the median times to target, in words."""
    medians = [_median(data.values("time_to_target_s", cus=m, trigger=trigger, formation=one)) for one in FORMATIONS]
    if any(map(math.isnan, medians)):
        return "unknown"
    return "not all reached" if math.isinf(sum(medians)) else f"{sum(medians):.1f} s"


def _median(values: Sequence[float]) -> float:
    return median(values) if values else math.nan


def _distances(data: Data, conditions: Sequence[Condition], title: str) -> Picture:
    return Picture(
        "distance.png",
        title,
        render(lambda figure: _draw_distances(figure, data, conditions), 12, 7.6),
        "Time runs from the change of the targets. Line: mean over the UAVs; band: from the nearest to the farthest; "
        "each is the median over seeds, round by round. The formation is reached where all of the band is within "
        f"{100 * REACHED:g} cm (dotted); the vertical line is the median of when that is so for the first time.",
    )


def _draw_distances(figure: Figure, data: Data, conditions: Sequence[Condition]) -> None:
    grid = figure.subplots(len(conditions), len(FORMATIONS), sharex=True, sharey=True, squeeze=False)
    legs = [data.legs(m, one, formation) for m, one, _, _ in conditions for formation in FORMATIONS]
    longest = PERIOD_S * max((leg.rounds for some in legs for leg in some), default=100)
    times = [
        _median(data.values("time_to_target_s", cus=m, trigger=one, formation=formation))
        for m, one, _, _ in conditions
        for formation in FORMATIONS
    ]
    shown = min(longest, edge(times, longest)) if all(map(math.isfinite, times)) else longest
    for row, (m, trigger, name, colour) in zip(grid, conditions, strict=True):
        for axes, formation in zip(row, FORMATIONS, strict=True):
            flown = [leg for leg in data.legs(m, trigger, formation) if leg.mean]
            axes.axhline(REACHED, color=INK, lw=0.9, ls=":")
            if not flown:
                say_missing(axes)
                continue
            _draw_band(axes, flown, colour)
            time = _median(data.values("time_to_target_s", cus=m, trigger=trigger, formation=formation))
            if math.isfinite(time):
                axes.axvline(time, color=INK, lw=1)
            words = f"{time:.1f} s" if math.isfinite(time) else "not reached"
            box = {"facecolor": "white", "edgecolor": "none", "pad": 2}
            axes.text(0.97, 0.95, words, transform=axes.transAxes, ha="right", va="top", weight="bold", bbox=box)
        row[0].set_ylabel(f"{name}\ndistance to target (m)", color=colour)
    for axes, formation in zip(grid[0], FORMATIONS, strict=True):
        axes.set_title(formation, loc="center", weight="bold")
        axes.set(yscale="log", ylim=(_LEAST, _MOST), xlim=(0, shown))
        axes.set_yticks([0.01, REACHED, 0.1, 1], ["0.01", f"{REACHED:g}", "0.1", "1"])
        axes.minorticks_off()
    figure.supxlabel("time since the targets changed (s)", fontsize=11)


def _draw_band(axes: Axes, legs: Sequence[Leg], colour: str) -> None:
    """Draw mean, largest and smallest distance, each the median over flights."""
    largest, mean, smallest = (
        np.clip(np.median(np.array([read(leg) for leg in legs]), axis=0), _LEAST, None) for read in _SERIES
    )
    time = PERIOD_S * np.arange(1, len(mean) + 1)
    axes.fill_between(time, smallest, largest, color=colour, alpha=0.25, lw=0)
    axes.plot(time, largest, color=colour, lw=0.8)
    axes.plot(time, mean, color=colour, lw=2)


_SERIES: tuple[Callable[[Leg], tuple[float, ...]], ...] = (
    lambda leg: leg.largest,
    lambda leg: leg.mean,
    lambda leg: leg.smallest,
)


def _draw_times(figure: Figure, data: Data, groups: Sequence[tuple[str, Sequence[Condition]]]) -> None:
    if len(groups) == 1:
        panels = [figure.add_subplot()]
    else:
        grid = figure.add_gridspec(2, len(groups) - 1, height_ratios=(1.3, 1))
        panels = [figure.add_subplot(grid[0, :])]
        panels += [figure.add_subplot(grid[1, n]) for n in range(len(groups) - 1)]
    for axes, (title, conditions) in zip(panels, groups, strict=True):
        _draw_panel(axes, data, conditions)
        # above what is written at the top edge
        axes.set_title(title, weight="bold", pad=18)
    handles = [axes.plot([], [], "_", color=colour, ms=13, mew=3, label=name)[0] for _, _, name, colour in groups[0][1]]
    panels[0].legend(handles=handles, loc="lower right", bbox_to_anchor=(1, 1.04), ncols=3)


def _draw_panel(axes: Axes, data: Data, conditions: Sequence[Condition]) -> None:
    shown = [data.values("time_to_target_s", cus=m, trigger=trigger) for m, trigger, _, _ in conditions]
    every = [value for some in shown for value in some]
    top = edge(every, 1)
    axes.set(xlim=(-0.5, len(FORMATIONS) - 0.5), ylim=(0, top), ylabel="time to target (s)")
    axes.set_xticks(range(len(FORMATIONS)), FORMATIONS)
    axes.tick_params(axis="x", length=0)
    axes.grid(axis="y", color="#E3E6E9", lw=0.8)
    axes.set_axisbelow(True)
    if not every:
        say_missing(axes)
    for place, formation in enumerate(FORMATIONS):
        if place:
            axes.axvline(place - 0.5, color="#C5CCD3", lw=0.8)
        for offset, (m, trigger, _, colour) in zip(spread(len(conditions), 0.84), conditions, strict=True):
            values = data.values("time_to_target_s", cus=m, trigger=trigger, formation=formation)
            if not values:
                continue
            at = [place + offset + beside for beside in spread(len(values), 0.15)]
            finite = [(x, value) for x, value in zip(at, values, strict=True) if math.isfinite(value)]
            axes.plot([x for x, _ in finite], [y for _, y in finite], "o", color=colour, ms=4, alpha=0.55, mew=0)
            with_interval(axes, place + offset, values, colour, top, ms=20, mew=3)
            not_reached(axes, place + offset, top, values, colour)


def _draw_arrivals(figure: Figure, data: Data) -> None:
    panels = figure.subplots(1, len(FORMATIONS), sharex=True, sharey=True)
    last, uavs = 0.0, 16
    for axes, formation in zip(panels, FORMATIONS, strict=True):
        axes.set_title(formation, loc="center", weight="bold")
        for trigger in TRIGGERS:
            legs = data.legs(3, trigger, formation)
            if not legs:
                continue
            uavs = len(legs[0].reached[0])
            times = arrivals(legs)
            kept = [time for time in times if math.isfinite(time)]
            axes.step([0, *kept], range(len(kept) + 1), where="post", color=TRIGGER_COLOURS[trigger], lw=2)
            axes.plot(kept[-1:], [len(kept)] * len(kept[-1:]), "o", color=TRIGGER_COLOURS[trigger], ms=6)
            last = max([last, *kept])
        if not any(data.legs(3, trigger, formation) for trigger in TRIGGERS):
            say_missing(axes)
        for level in (uavs // 4, uavs):
            axes.axhline(level, color=GREY, lw=0.9, ls=":")
    panels[0].set(ylabel="UAVs that have arrived", ylim=(0, uavs * 1.06), xlim=(0, edge([last], 1) if last else 1))
    panels[0].set_yticks(range(0, uavs + 1, max(1, uavs // 4)))
    handles = [panels[0].plot([], [], color=TRIGGER_COLOURS[one], lw=2.5, label=one)[0] for one in TRIGGERS]
    figure.legend(handles=handles, loc="outside upper right", ncols=len(handles))
    figure.supxlabel("time since the targets changed (s)", fontsize=11)


def arrivals(legs: Sequence[Leg]) -> list[float]:
    """Return when the first, second … UAV arrived, in s: the median over flights, infinite if they mostly did not."""
    each = [
        sorted(math.inf if one is None else PERIOD_S * one for one in leg.reached[RADII.index(REACHED)]) for leg in legs
    ]
    return [median(kth) for kth in zip(*each, strict=True)]
