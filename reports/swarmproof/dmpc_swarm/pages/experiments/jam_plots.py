"""The pictures of Fig. 4: the smallest separation by jam and seed, collisions by the jam's start, and endless jams."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from swarmproof.campaign.statistics import proportion_interval
from swarmproof.claims.samples import Observation
from swarmproof.dmpc_swarm.claims.experiments import FOR_EVER, HORIZON_S, IGNORING, MLR, PERIOD_S
from swarmproof.dmpc_swarm.pages.experiments.drawing import (
    COLLISION,
    METHOD_COLOURS,
    Picture,
    edge,
    not_reached,
    render,
    say_missing,
    spread,
)
from swarmproof.dmpc_swarm.pages.experiments.numbers import D_HAT_MIN, D_MIN, Data, collisions, down, numbers
from swarmproof.pages import phrases
from swarmproof.pages.plot_style import ASKED as D_MIN_NAME
from swarmproof.pages.plot_style import INK
from swarmproof.pages.plot_style import KEPT as D_HAT_MIN_NAME

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

_METHODS = (MLR, IGNORING)
#: Scaled m: where colours change. Warm ones are collisions, cold ones keep d_min; the darkest blue keeps d̂_min.
_LEVELS = (0.0, 0.04, 0.08, D_MIN, 0.16, 0.2, D_HAT_MIN, 0.3)
_COLOURS = ("#7F0000", "#C7261F", "#F4A03A", "#DCEBF7", "#A6CDE8", "#6BAED6", "#08519C")


def fig4_pictures(data: Data) -> list[Picture]:
    """Return the pictures of the experiment with the jam."""
    lengths = _lengths(data)
    columns = max(1, len(lengths))
    words = "; ".join(f"{method} {_count(_finite(data, method))}" for method in _METHODS)
    ending = data.among(jam_rounds=FOR_EVER)
    halted = [one for one in numbers(ending, "halted_s") if math.isfinite(one)]
    return [
        Picture(
            "separation.png",
            "Smallest separation, by start of the jam and seed",
            render(lambda figure: _draw_maps(figure, data, lengths), 12 if columns > 1 else 9, 5.6),
            "Each square is a flight; the colour is the smallest scaled distance of any two UAVs at any time "
            f"(certified lower bound). Warm colours with a cross are collisions (below d_min = {D_MIN:g} m), "
            f"blue ones are not. Collisions: {words}. Hatched: not flown.",
        ),
        Picture(
            "collisions.png",
            "Which starts of the jam lead to a collision",
            render(lambda figure: _draw_shares(figure, data, lengths), 12, 1.2 + 2 * columns),
            "The share of seeds with which two UAVs collide. Orange bars: message loss is ignored, with the exact 95 % "
            "interval; blue dots: MLR-DMPC. A high bar is a start that is dangerous whatever the seed. The paper jams "
            "the first two seconds: start 0, ten rounds.",
        ),
        Picture(
            "for-ever.png",
            "Jams that do not end, with MLR-DMPC",
            render(lambda figure: _draw_for_ever(figure, data), 12, 6.4),
            "Above: how long after the jam's beginning the last UAV comes to rest, with the horizon and one period "
            "more (planned in the jam's first round, a trajectory is followed from the next on). Below: the smallest "
            f"separation in these flights. Each dot is a seed. {_halts(ending, halted)}",
        ),
    ]


def _halts(ending: Sequence[Observation], halted: Sequence[float]) -> str:
    if not ending:
        return "None was flown."
    longest = f"the longest takes {max(halted):.1f} s" if halted else "none comes to rest"
    least = down(min(numbers(ending, "separation_m")))
    return f"{phrases.count(len(ending), 'flight')}: {longest}, the smallest separation is {least} m."


def _lengths(data: Data) -> list[int]:
    """Return the lengths of jams that end, in rounds; those that should be flown, whether they were or not."""
    every = {int(cell.loss.rpartition(",")[2]) for cell in data.variant.cells}
    return sorted(every - {FOR_EVER})


def _starts(data: Data) -> list[int]:
    return sorted({int(cell.loss.removeprefix("jam:").partition(",")[0]) for cell in data.variant.cells})


def _finite(data: Data, method: str) -> list[Observation]:
    return [seen for seen in data.among(method=method) if seen.labels["jam_rounds"] != FOR_EVER]


def _count(seen: Sequence[Observation]) -> str:
    return f"{collisions(seen):,} of {phrases.count(len(seen), 'flight')}"


def _draw_maps(figure: Figure, data: Data, lengths: Sequence[int]) -> None:
    starts, seeds = _starts(data), sorted({cell.seed for cell in data.variant.cells})
    grid = figure.subplots(len(_METHODS), len(lengths), sharex=True, sharey=True, squeeze=False)
    for row, method in zip(grid, _METHODS, strict=True):
        for axes, length in zip(row, lengths, strict=True):
            seen = data.among(method=method, jam_rounds=length)
            drawn = _draw_map(axes, seen, starts, seeds)
            jam = f"{length} rounds ({length * PERIOD_S:.1f} s)\n" if method == _METHODS[0] else ""
            axes.set_title(f"{jam}{collisions(seen):,} of {len(seen):,} collide", loc="center")
        row[0].set_ylabel(f"{method}\nseed", color=METHOD_COLOURS[method], weight="bold")
    for axes in grid[-1]:
        axes.set_xticks(*_some(starts))
    grid[0, 0].set_yticks(*_some(seeds))
    bar = figure.colorbar(drawn, ax=grid, ticks=_LEVELS, shrink=0.95, aspect=30, pad=0.02)
    ticks = {D_MIN: f"{D_MIN:g}  {D_MIN_NAME}", D_HAT_MIN: f"{D_HAT_MIN:g}  {D_HAT_MIN_NAME}"}
    bar.ax.set_yticklabels([ticks.get(level, f"{level:g}") for level in _LEVELS])
    bar.ax.axhline(D_MIN, color=INK, lw=2.5)
    bar.set_label("smallest separation (m, scaled)")
    bar.ax.text(-0.35, D_MIN / 2, "collision", rotation=90, ha="right", va="center", color=COLLISION, weight="bold")
    figure.supxlabel("start of the jam (rounds of 0.2 s after the targets changed)", fontsize=11)


def _draw_map(axes: Axes, seen: Sequence[Observation], starts: Sequence[int], seeds: Sequence[int]) -> ScalarMappable:
    from matplotlib.colors import BoundaryNorm, ListedColormap

    values = np.full((len(seeds), len(starts)), np.nan)
    for each in seen:
        start, distance = each.labels["jam_start"], each.values["separation_m"]
        assert isinstance(start, int)
        assert distance is not None
        # what keeps more than the scale shows has its last colour
        at = seeds.index(each.seed), starts.index(start)
        values[at] = min(float(distance), _LEVELS[-1] - 1e-9)
        if each.values["collides"] is not False:
            mark, colour = ("×", "white") if each.values["collides"] else ("?", INK)
            axes.text(at[1], at[0], mark, ha="center", va="center_baseline", fontsize=9, color=colour, weight="bold")
    axes.set_facecolor("#E9ECEF")
    axes.patch.set_hatch("////")
    axes.patch.set_edgecolor("#ADB5BD")
    return axes.imshow(
        np.ma.masked_invalid(values),
        cmap=ListedColormap(_COLOURS),
        norm=BoundaryNorm(_LEVELS, len(_COLOURS)),
        aspect="auto",
        origin="lower",
        interpolation="nearest",
    )


def _some(places: Sequence[int]) -> tuple[list[int], list[str]]:
    """Return which of the columns or rows are labelled, and how."""
    step = max(1, round(len(places) / 6))
    return list(range(0, len(places), step)), [str(one) for one in places[::step]]


def _draw_shares(figure: Figure, data: Data, lengths: Sequence[int]) -> None:
    starts = _starts(data)
    panels = figure.subplots(len(lengths), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for axes, length in zip(panels, lengths, strict=True):
        for start in starts:
            for method in _METHODS:
                seen = data.among(method=method, jam_rounds=length, jam_start=start)
                if seen:
                    _draw_share(axes, start, collisions(seen), len(seen), method)
        if not data.among(jam_rounds=length):
            say_missing(axes)
        axes.set_title(f"jam of {length} rounds ({length * PERIOD_S:.1f} s)")
        axes.grid(axis="y", color="#E3E6E9", lw=0.8)
        axes.set_axisbelow(True)
    panels[0].set(ylim=(-0.02, 1.02), xlim=(starts[0] - 0.6, starts[-1] + 0.6))
    panels[0].set_yticks([0, 0.5, 1], ["0 %", "50 %", "100 %"])
    panels[-1].set_xticks(starts if len(starts) < 12 else starts[::2])
    ignored = panels[0].bar([-9], [0], color=METHOD_COLOURS[IGNORING], label=IGNORING)
    handled = panels[0].plot([], [], "o", color=METHOD_COLOURS[MLR], label=MLR)[0]
    panels[0].legend(handles=[ignored, handled], loc="lower right", bbox_to_anchor=(1, 1), ncols=2)
    figure.supylabel("seeds with a collision", fontsize=11)
    figure.supxlabel("start of the jam (rounds of 0.2 s after the targets changed)", fontsize=11)


def _draw_share(axes: Axes, x: float, count: int, of: int, method: str) -> None:
    colour = METHOD_COLOURS[method]
    if method == IGNORING:
        axes.bar([x], [count / of], width=0.6, color=colour, alpha=0.8, zorder=2)
        axes.plot([x, x], proportion_interval(count, of), color=INK, lw=1.1, zorder=3)
    else:
        axes.plot([x], [count / of], "o", color=colour, ms=5, zorder=4, clip_on=False)


def _draw_for_ever(figure: Figure, data: Data) -> None:
    above, below = figure.subplots(2, 1, sharex=True)
    ending, starts = data.among(jam_rounds=FOR_EVER), _starts(data)
    later = HORIZON_S + PERIOD_S
    top = edge([later, *numbers(ending, "halted_s")], later)
    if not ending:
        say_missing(above)
        say_missing(below)
    for start in starts:
        seen = data.among(jam_rounds=FOR_EVER, jam_start=start)
        at = [start + beside for beside in spread(max(1, len(seen)), 0.6)]
        halted, apart = numbers(seen, "halted_s"), numbers(seen, "separation_m")
        for axes, values in ((above, halted), (below, apart)):
            shown = [(x, value) for x, value in zip(at, values, strict=False) if math.isfinite(value)]
            axes.plot([x for x, _ in shown], [y for _, y in shown], "o", color=METHOD_COLOURS[MLR], ms=3.5, alpha=0.7)
        not_reached(above, start, top, halted, METHOD_COLOURS[MLR])
    for axes, level, text, at_height in (
        (above, HORIZON_S, f"horizon: {HORIZON_S:g} s", "top"),
        (above, later, f"and one period: {later:g} s", "bottom"),
        (below, D_HAT_MIN, f"{D_HAT_MIN_NAME} = {D_HAT_MIN:g} m", "center"),
        (below, D_MIN, f"{D_MIN_NAME} = {D_MIN:g} m: collision below", "center"),
    ):
        colour = COLLISION if level == D_MIN else INK
        axes.axhline(level, color=colour, lw=1, ls="--" if level in (HORIZON_S, D_HAT_MIN) else "-")
        axes.annotate(
            text, (1, level), (5, 0), xycoords=("axes fraction", "data"), textcoords="offset points", va=at_height,
            color=colour, annotation_clip=False,
        )  # fmt: skip
    above.set(ylim=(0, top), ylabel="time from the jam's beginning\nuntil all UAVs rest (s)")
    below.set(ylim=(0, None), ylabel="smallest separation\n(m, scaled)", xlim=(starts[0] - 0.6, starts[-1] + 0.6))
    below.set_xticks(starts if len(starts) < 12 else starts[::2])
    figure.supxlabel("start of the jam (rounds of 0.2 s after the targets changed)", fontsize=11)
