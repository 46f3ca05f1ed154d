"""Draws a flight: paths, separation, and what happened when. Every picture is an SVG, the same bytes every time."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from swarmproof.assess.judge import FlightVerdict, Flown
from swarmproof.assess.log import Log, Outcome
from swarmproof.assess.run import Setting
from swarmproof.mlr.algorithm1 import CuState
from swarmproof.motion.lattice import Floats
from swarmproof.planning.outlook import ARRIVED
from swarmproof.report.flight_series import (
    Band,
    Bins,
    distances_to_targets,
    lost_messages,
    pair_distance,
    sampled_separation,
    states_of_cus,
    target_changes,
)
from swarmproof.report.plot_style import ASKED, BLUE, GREY, INK, KEPT, ORANGE, PALETTE, SETTINGS, decimal_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RED = "#B00020"
#: A picture with more marks or corners than this shows them as pixels: a vector each would take too much room.
MOST_VECTORS = 20_000
_METADATA: dict[str, Any] = dict.fromkeys(("Date", "Creator", "Format", "Type"))
_STATES = {
    CuState.RUN_DMPC: "#BFE8CB",
    CuState.WAIT: "#F5C842",
    CuState.REQUEST_TRAJECTORY: "#3B82D6",
    CuState.WAIT_FOR_UPDATE: "#9A6DD7",
}
_LOST = (("UAVs' metadata to CUs", "#56B4E9"), ("slots to CUs", "#0072B2"), ("slots to UAVs", "#E69F00"))
#: Marks of CUs that share a colour.
_SHAPES = "osD"
#: How close to d̂_min the separation is drawn enlarged, in times of the largest dip; a larger share of it needs none.
SMALL_DIP = 0.2
#: Rounds on each side of the closest approach, and points in a round, of the picture of it.
AROUND, POINTS = 4, 60


class Picture(NamedTuple):
    """A picture on the page.

    Attributes:
        name: of its file, without suffix.
        alt: what it shows, for who does not see it.
        caption: what to look for.
    """

    name: str
    title: str
    svg: str
    alt: str
    caption: str


def pictures(setting: Setting, flown: Flown, log: Log) -> list[Picture]:
    """Return all pictures of a flight of at least one round; matplotlib must be there."""
    return [_paths(setting, flown, log), _separation(setting, flown, log), _timeline(setting, flown, log)]


def _draw(draw: Callable[[Figure], None], width: float, height: float) -> str:
    """Return what `draw` draws as SVG (sizes in inches), whatever the user's settings of matplotlib."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    content = io.StringIO()
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(SETTINGS)
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
        figure.savefig(content, format="svg", metadata=_METADATA)
    return content.getvalue()


def uav_colours(uavs: int) -> list[Any]:
    """Return a colour for each UAV; they repeat after twenty."""
    from matplotlib import colormaps

    twenty = colormaps["tab20"].colors  # type: ignore[attr-defined]
    return [twenty[(2 * i) % 20 + (i // 10) % 2] for i in range(uavs)]


# --- paths


def _paths(setting: Setting, flown: Flown, log: Log) -> Picture:
    scenario = setting.scenario
    period = float(scenario.parameters.T_s)
    positions = log.positions(log.flight.lattice.steps)
    changes = target_changes(scenario, len(log.rounds))
    targets = [np.array(scenario.targets_at(k)) for k in changes]
    scene = _Scene(
        positions,
        targets[-1],
        targets[:-1] if len(targets) <= 5 else [],
        flown.closest_pair[0],
        log.positions(POINTS, *_rounds_around(flown.closest_pair[1], period, len(log.rounds))),
        np.array(scenario.parameters.workspace, float),
    )
    (i, j), time = flown.closest_pair

    def draw(figure: Figure) -> None:
        left = figure.add_subplot(1, 2, 1, projection="3d")
        _draw_in_space(left, scene)
        _draw_from_above(figure.add_subplot(1, 2, 2), scene)
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=5)

    caption = (
        "Look for paths that give way around each other, and for UAVs that do not end at their target. Axes have the "
        f"same scale in x, y and z. The red ring is where UAVs {i} and {j} come closest of all, at {time:.2f} s; "
        "remember that distances count height at a sixth"
        if _is_flattened(scenario.parameters.theta_inverse)
        else ""
    )
    return Picture("paths", "Where they flew", _draw(draw, 12, 6.3), "", caption)


class _Scene(NamedTuple):
    positions: Floats
    targets: Floats
    earlier: Sequence[Floats]
    pair: tuple[int, int]
    around: Floats
    box: Floats


def _is_flattened(theta_inverse: Any) -> bool:
    return True


def _rounds_around(time: float, period: float, rounds: int) -> tuple[int, int]:
    k = int(time / period)
    return max(0, k - AROUND), min(rounds, k + AROUND + 1)


def _draw_in_space(axes: Any, scene: _Scene) -> None:
    axes.set_proj_type("ortho")
    axes.view_init(elev=28, azim=-60)
    low, high = scene.box.T
    axes.set_box_aspect(high - low, zoom=1.0)
    corners = [[(x, y, z) for x in (0, 1) for y in (0, 1)] for z in (0, 1)]
    raster = scene.positions.size > 3 * MOST_VECTORS
    for colour, path in zip(uav_colours(scene.positions.shape[1]), scene.positions.transpose(1, 2, 0), strict=True):
        axes.plot(*path, color=colour, lw=1.1, rasterized=raster)
        axes.plot(path[0], path[1], low[2], color=colour, lw=0.8, alpha=0.25, rasterized=raster)
    axes.scatter(*scene.positions[0].T, s=22, c="white", edgecolors=uav_colours(len(scene.targets)), depthshade=False, label="start")
    axes.scatter(*scene.targets.T, s=40, marker="x", c=uav_colours(len(scene.targets)), depthshade=False, label="target")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")


def _draw_from_above(axes: Axes, scene: _Scene) -> None:
    axes.set_aspect("equal")
    (x0, y0, _), (x1, y1, _) = scene.box.T
    colours = uav_colours(scene.positions.shape[1])
    raster = scene.positions.size > 3 * MOST_VECTORS
    for i, (colour, path) in enumerate(zip(colours, scene.positions.transpose(1, 2, 0), strict=True)):
        axes.plot(path[0], path[1], color=colour, lw=1.2, rasterized=raster)
        axes.plot(path[0, 0], path[1, 0], "o", color=colour, mfc="white", ms=12)
        axes.text(path[0, 0], path[1, 0], str(i), color=INK, ha="center", va="center_baseline", fontsize=7)
        axes.plot(*scene.targets[i, :2], "x", color=colour, ms=8, mew=2)
    axes.plot([x0, x1, x1, x0, x0], [y0, y0, y1, y1, y0], color=GREY, lw=1)
    axes.set(xlabel="x (m)", ylabel="y (m)", title="seen from above")


# --- separation


def _separation(setting: Setting, flown: Flown, log: Log) -> Picture:
    parameters = setting.scenario.parameters
    kept, asked = float(parameters.d_hat_min), float(parameters.d_min)
    T_c, period = float(parameters.T_c), float(parameters.T_s)
    band = Band.of(flown, T_c)
    sampled = sampled_separation(log)

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(2, 2, width_ratios=[2.1, 1])
        whole = figure.add_subplot(grid[0, 0])
        _draw_band(whole, band, kept, asked)
        whole.set_ylim(0, 1.05 * max(band.highest.max(), kept))
        zoom = figure.add_subplot(grid[1, 0], sharex=whole)
        _draw_band(zoom, band, kept, asked)
        bins = Bins.of(len(sampled))
        zoom.plot(bins.edges(T_c)[:-1], bins.least(sampled), ".", color=BLUE, ms=3)
        dip = max(kept - band.lower.min(), 1e-4)
        zoom.set_ylim(kept - 1.5 * dip, kept + 1.5 * dip)
        detail = figure.add_subplot(grid[:, 1])
        first, last = _rounds_around(flown.closest_pair[1], period, len(log.rounds))
        curve = pair_distance(log, flown.closest_pair[0], POINTS, first, last)
        t = period * (first + np.arange(len(curve)) / POINTS)
        detail.plot(t, curve, color=BLUE)
        each = POINTS // log.flight.lattice.steps
        detail.plot(t[::each], curve[::each], "o", color=BLUE)
        detail.axhline(kept, color=GREY, dashes=(6, 3))
        detail.set_ylim(kept - 2 * dip, kept + 8 * dip)

    return Picture("separation", "How close they came", _draw(draw, 12, 5.5), "", "")


def _draw_band(axes: Axes, band: Band, kept: float, asked: float) -> None:
    last = [-1]
    lower, upper, highest = (np.append(v, v[last]) for v in (band.lower, band.upper, band.highest))
    axes.fill_between(band.edges, lower, highest, step="post", color=BLUE, alpha=0.15, lw=0)
    axes.fill_between(band.edges, lower, upper, step="post", color=BLUE, lw=0.8)
    axes.axhline(kept, color=GREY, dashes=(6, 3))
    axes.axhline(asked, color=ORANGE, dashes=(6, 3))
    axes.set_xlim(0, band.edges[-1])


# --- what happened when


def _timeline(setting: Setting, flown: Flown, log: Log) -> Picture:
    uavs, cus, period = setting.scenario.uavs, setting.cus, float(setting.scenario.parameters.T_s)

    def draw(figure: Figure) -> None:
        heights = [0.17 * uavs + 0.5, 1.4, 0.24 * cus + 0.3, 1.8]
        a, b, c, d = figure.subplots(4, 1, sharex=True, height_ratios=heights)
        events = [e for logged in log.rounds for e in logged.replanned]
        for w in range(cus):
            for outcome, fill in ((Outcome.ADOPTED, PALETTE[w]), (Outcome.NOT_ADOPTED, "white")):
                some = [e for e in events if e.cu == w and e.outcome is outcome]
                a.plot([period * (e.k + 0.5) for e in some], [e.uav for e in some], "o", ms=4, color=PALETTE[w], mfc=fill, mew=0.8)
        bad = [e for e in events if e.outcome in (Outcome.REJECTED, Outcome.INFEASIBLE)]
        a.plot([period * (e.k + 0.5) for e in bad], [e.uav for e in bad], "x", color=RED)
        a.set_ylim(uavs - 0.5, -0.5)
        lost = lost_messages(log)
        bins = Bins.of(len(lost))
        m = bins.mean(lost)
        base = np.zeros(len(m) + 1)
        for kind, (name, colour) in enumerate(_LOST):
            top = base + np.append(m[:, kind], m[-1, kind])
            b.fill_between(bins.edges(period), base, top, step="post", color=colour, lw=0, label=name)
            base = top
        states = bins.mean(states_of_cus(log))
        for w in range(cus):
            base = np.full(len(m) + 1, w - 0.4)
            for s, (state, colour) in enumerate(_STATES.items()):
                top = base + 0.8 * np.append(states[:, w, s], states[-1, w, s])
                c.fill_between(bins.edges(period), base, top, step="post", color=colour, lw=0)
                base = top
        c.set_ylim(cus - 0.5, -0.5)
        dist = distances_to_targets(log, setting.scenario)
        t = period * (np.arange(len(dist)) + 1)
        d.plot(t, dist.max(axis=1), color=INK)
        d.plot(t, dist.mean(axis=1), color=BLUE)
        d.plot(t, dist.min(axis=1), color=GREY)
        d.set_yscale("log")
        d.set_ylim(1e-3, None)
        d.axhline(ARRIVED, color=GREY, dashes=(6, 3))
        d.set_xlim(0, period * len(log.rounds))

    return Picture("timeline", "What happened when", _draw(draw, 12, 0.17 * uavs + 0.24 * cus + 6.3), "", "")
