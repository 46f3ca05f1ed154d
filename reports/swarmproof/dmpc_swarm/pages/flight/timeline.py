"""Draws what happened when in a flight: who was planned by whom, what was lost, the CUs' states, who arrived."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from swarmproof.dmpc_swarm.flight.log import Log, Outcome
from swarmproof.dmpc_swarm.pages.flight.series import (
    Bins,
    distances_to_targets,
    lost_messages,
    states_of_cus,
    target_changes,
)
from swarmproof.dmpc_swarm.planner.outlook import ARRIVED
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.motion.lattice import Floats
from swarmproof.pages.plot_style import BLUE, GREY, INK, PALETTE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RED = "#B00020"
#: More marks than these are drawn as pixels: a shape each would take too much room.
MOST_MARKS = 4000
#: The same for the states of the CUs: rounds times CUs times states.
MOST_CELLS = 15_000
#: If the targets change more often, that is not marked.
MOST_CHANGES = 60
#: Inches that the rows of a UAV and of a CU are high, and the rest of the picture.
ROW_OF_UAV, ROW_OF_CU, REST = 0.17, 0.24, 7.0
#: Distances to targets below this are drawn at it, in m.
SMALLEST = 1e-3
_STATES = {
    CuState.RUN_DMPC: "#BFE8CB",
    CuState.WAIT: "#F5C842",
    CuState.REQUEST_TRAJECTORY: "#3B82D6",
    CuState.WAIT_FOR_UPDATE: "#9A6DD7",
}
_LOST = (("UAVs' metadata, to CUs", "#56B4E9"), ("slots, to CUs", "#0072B2"), ("slots, to UAVs", "#E69F00"))
#: CUs that share a colour have different shapes.
_SHAPES = "osD"


def height(uavs: int, cus: int) -> float:
    """Return how many inches high the picture should be."""
    return ROW_OF_UAV * uavs + ROW_OF_CU * cus + REST


def draw_timeline(figure: Figure, log: Log, violations: Sequence[float]) -> None:
    """Draw all that into `figure`; `violations` are the times (s) at which a claim was broken for the first time."""
    scenario, cus = log.flight.scenario, log.flight.cus
    period = float(scenario.parameters.T_s)
    heights = [ROW_OF_UAV * scenario.uavs + 0.4, 1.3, ROW_OF_CU * cus + 0.2, 1.7]
    planned, lost, states, distances = figure.subplots(4, 1, sharex=True, height_ratios=heights)
    changes = [period * k for k in target_changes(scenario, len(log.rounds))]
    changes = changes if len(changes) <= MOST_CHANGES else []
    for axes in (planned, lost, states, distances):
        for time in changes:
            axes.axvline(time, color=INK, lw=0.7, dashes=(1, 2), zorder=1)
        for time in violations:
            axes.axvline(time, color=RED, lw=1, zorder=3)
    if violations:
        planned.plot([], [], color=RED, lw=1, label="first violation of a claim")
    _draw_planned(planned, log, period)
    _draw_lost(lost, log, period)
    _draw_states(states, log, period)
    _draw_distances(distances, log, period)
    if changes:
        distances.plot([], [], color=INK, lw=0.7, dashes=(1, 2), label="targets change")
    _legend(distances)
    distances.set(xlim=(0, period * len(log.rounds)), xlabel="time (s)")
    rounds = distances.secondary_xaxis(-0.3, functions=(lambda t: t / period, lambda k: k * period))
    rounds.set_xlabel(f"round (of {period:g} s)")


def _legend(axes: Axes) -> None:
    """Put the legend above the axes, on the right; their title is on the left."""
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.01, 1.0),
        ncols=min(len(axes.get_legend_handles_labels()[0]), 9),
        borderaxespad=0.1,
        fontsize=8.5,
        handlelength=1.2,
        handletextpad=0.4,
        columnspacing=1.1,
    )


def _draw_planned(axes: Axes, log: Log, period: float) -> None:
    """Draw a mark for each attempt to plan a UAV: filled if it was adopted, hollow if not, a cross if there is none.

    Many marks become ticks, grey where the plan was not adopted.
    """
    attempts = [attempt for logged in log.rounds for attempt in logged.replanned]
    dense = len(attempts) > MOST_MARKS
    # a third more than the width of a round, in points
    size = float(np.clip(1000 / len(log.rounds), 1.2, 6))
    tick = {"marker": "|", "ms": 8, "mew": 0.6}

    def draw(cu: int | None, outcome: Outcome, **style: Any) -> int:
        some = [one for one in attempts if one.outcome is outcome and cu in (None, one.cu)]
        times, uavs = [period * (one.k + 0.5) for one in some], [one.uav for one in some]
        axes.plot(times, uavs, ls="", rasterized=dense, zorder=2, **style)
        return len(some)

    def explain(label: str, **style: Any) -> None:
        axes.plot([], [], ls="", label=label, **{**style, "ms": 6, "mew": 1.2})

    for w in range(log.flight.cus):
        colour = PALETTE[w % len(PALETTE)]
        round_mark = {"marker": _SHAPES[w // len(PALETTE)], "ms": size, "mew": 0.2 * size}
        style: dict[str, Any] = {"color": colour, **(tick if dense else round_mark)}
        draw(w, Outcome.ADOPTED, **style)
        explain(f"CU {w}", **style)
        if not dense:
            draw(w, Outcome.NOT_ADOPTED, mfc="white", **style)
    if dense:
        draw(None, Outcome.NOT_ADOPTED, color=GREY, **tick)
    explain("not adopted", color=GREY, **(tick if dense else {"marker": "o", "mfc": "white"}))
    for outcome, marker in ((Outcome.REJECTED, "x"), (Outcome.INFEASIBLE, "+")):
        cross: dict[str, Any] = {"color": RED, "marker": marker, "ms": max(4.0, size), "mew": 1.2}
        if draw(None, outcome, **cross):
            explain(str(outcome), **cross)
    axes.set_title("Who is planned, and by whom")
    rows = log.flight.scenario.uavs
    axes.set(ylabel="UAV", ylim=(rows - 0.4, -0.6), yticks=range(0, rows, 1 if rows <= 32 else 4))
    axes.tick_params("y", labelsize=8, length=0)
    axes.set_axisbelow(True)
    axes.grid(axis="y", color="#E6E6E6", lw=0.6)
    _legend(axes)


def _draw_lost(axes: Axes, log: Log, period: float) -> None:
    """Draw the messages lost in each round, by kind, one upon the other; in bins, the mean of a round."""
    lost = lost_messages(log)
    bins = Bins.of(len(lost))
    _stack(axes, bins.edges(period), bins.mean(lost), 0.0, 1.0, _LOST, dense=bins.width > 1)
    total = lost.sum(axis=1)
    if bins.width > 1:
        axes.stairs(bins.largest(total), bins.edges(period), color=INK, lw=0.5, label="most in any one round")
    if not total.any():
        axes.text(0.5, 0.5, "no message was lost", transform=axes.transAxes, ha="center", va="center", color=GREY)
    top = max(float(total.max()), 1.0)
    axes.set(title="Messages lost in each round", ylabel="messages", ylim=(0, 1.06 * top))
    _legend(axes)


def _draw_states(axes: Axes, log: Log, period: float) -> None:
    """Draw a row for each CU, coloured by its state; in bins, each state fills its share of the height."""
    is_in = states_of_cus(log)
    bins = Bins.of(len(is_in))
    shares = bins.mean(is_in)
    cus = is_in.shape[1]
    for w in range(cus):
        kinds = [(state.name if w == 0 else "", colour) for state, colour in _STATES.items()]
        _stack(axes, bins.edges(period), shares[:, w], w + 0.4, -0.8, kinds, dense=is_in.size > MOST_CELLS)
    axes.set(title="States of the CUs", ylabel="CU", ylim=(cus - 0.4, -0.6), yticks=range(cus))
    axes.tick_params("y", labelsize=8, length=0)
    _legend(axes)


def _stack(
    axes: Axes,
    edges: Floats,
    values: Floats,
    base: float,
    factor: float,
    kinds: Sequence[tuple[str, str]],
    *,
    dense: bool,
) -> None:
    """Draw the columns of `values`, shape (bins, kinds), upon each other from `base` on, scaled by `factor`.

    If it is `dense`, it is drawn as pixels.
    """
    corners = np.repeat(edges, 2)[1:-1]
    below = np.full(len(corners), base)
    for column, (name, colour) in zip(values.T, kinds, strict=True):
        above = below + factor * np.repeat(column, 2)
        # corners where nothing changes would only make the file larger
        keep = _corners(below, above)
        axes.fill_between(
            corners[keep], below[keep], above[keep], color=colour, lw=0, label=name, zorder=2, rasterized=dense
        )
        below = above


def _corners(*curves: Floats) -> list[int]:
    """Return the first and the last index, and those at which some curve is not as before or not as after."""
    same = np.all([np.diff(curve) == 0 for curve in curves], axis=0)
    inner = np.flatnonzero(~(same[:-1] & same[1:])) + 1
    return [0, *inner.tolist(), len(curves[0]) - 1]


def _draw_distances(axes: Axes, log: Log, period: float) -> None:
    """Draw how far from their targets UAVs are at the end of each round: the farthest, the nearest, the mean."""
    distances = np.maximum(distances_to_targets(log, log.flight.original), SMALLEST)
    bins = Bins.of(len(distances))
    times = bins.edges(period)[1:]
    axes.plot(times, bins.largest(distances.max(axis=1)), color=INK, lw=1.3, label="farthest UAV")
    axes.plot(times, bins.mean(distances.mean(axis=1)), color=BLUE, lw=1.3, label="mean")
    axes.plot(times, bins.least(distances.min(axis=1)), color=GREY, lw=0.9, label="nearest UAV")
    axes.axhline(ARRIVED, color="#009E73", lw=1.2, dashes=(6, 3), label=f"arrived: {100 * ARRIVED:g} cm")
    axes.set(
        title="Distance to the target", ylabel="distance (m)", yscale="log", ylim=(SMALLEST, 1.3 * distances.max())
    )
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
