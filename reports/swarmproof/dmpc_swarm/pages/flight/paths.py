"""Draws where the UAVs of a flight flew: their references in space and from above."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from swarmproof.dmpc_swarm.flight.judge import Flown
from swarmproof.dmpc_swarm.flight.log import Log
from swarmproof.dmpc_swarm.pages.flight.series import target_changes
from swarmproof.dmpc_swarm.pages.flight.timeline import RED
from swarmproof.motion.lattice import Floats
from swarmproof.pages.plot_style import GREY
from swarmproof.scenario.definition import flying_space

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Of a flight of more rounds than :data:`WHOLE`, only :data:`PART` rounds around the closest approach have colours.
WHOLE, PART = 600, 200
#: If the targets change more often than this, only the last ones are drawn.
MOST_TARGETS = 6
#: A flying space so many times as long, along some axis, as what is drawn is shown in part only.
LARGE = 20
_SHADOW = "#C8C8C8"
#: Paths without colours are one line, drawn as pixels: as corners they would take too much room.
_OTHERS: dict[str, Any] = {"color": "#DDDDDD", "lw": 0.4, "rasterized": True, "zorder": 0}


@dataclass(frozen=True)
class Scene:
    """What is drawn of the paths; lengths in m.

    Attributes:
        rounds: those whose paths have colours.
        positions: in these rounds, shape (samples, N, 3).
        others: in all rounds, if these are more; else None.
        targets: at the end of `rounds`, shape (N, 3).
        earlier: those before, each of the same shape, unless they are too many.
        closest: the places of the two UAVs at their closest approach, shape (2, 3).
        space: low and high of the flying space, shape (2, 3); of a much larger one, the part around the UAVs.
        is_whole: whether it is the whole flying space.
    """

    rounds: range
    positions: Floats
    others: Floats | None
    targets: Floats
    earlier: Sequence[Floats]
    closest: Floats
    space: Floats
    is_whole: bool = True

    @classmethod
    def of(cls, flown: Flown, log: Log) -> Scene:
        """Return what is drawn of a flight of at least one round."""
        scenario, steps = log.flight.original, log.flight.lattice.steps
        pair, time = flown.closest_pair
        rounds = shown_rounds(len(log.rounds), int(time / float(scenario.parameters.T_s)))
        changes = [k for k in target_changes(scenario, len(log.rounds)) if k < rounds.stop]
        # the targets that the coloured paths begin with, and later ones
        changes = changes[max(0, sum(k <= rounds.start for k in changes) - 1) :]
        targets = [np.array(scenario.targets_at(k), float) for k in changes]
        positions = log.positions(steps, rounds.start, rounds.stop)
        others = log.positions(steps) if len(rounds) < len(log.rounds) else None
        earlier = targets[:-1] if len(targets) <= MOST_TARGETS else []
        whole = np.array(flying_space(scenario.parameters), float).T
        everywhere = [positions if others is None else others, targets[-1], *earlier]
        space = in_view(whole, np.concatenate([points.reshape(-1, 3) for points in everywhere]))
        is_whole = bool((space == whole).all())
        return cls(rounds, positions, others, targets[-1], earlier, log.at(time)[list(pair)], space, is_whole)

    @property
    def colours(self) -> list[Any]:
        """A colour for each UAV; they repeat after twenty."""
        from matplotlib import colormaps

        twenty = colormaps["tab20"].resampled(20)
        return [twenty((2 * i) % 20 + (i // 10) % 2) for i in range(len(self.targets))]


def in_view(space: Floats, points: Floats) -> Floats:
    """Return the part of a flying space, low and high (2, 3), that shows `points` (m), shape (n, 3).

    That is all of it unless it is so large, or open, that nothing could be made out.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    extent = max(float((high - low).max()), 1.0)
    part = np.stack([np.maximum(space[0], low - extent / 10), np.minimum(space[1], high + extent / 10)])
    return part if (space[1] - space[0] > LARGE * extent).any() else space


def shown_rounds(rounds: int, k: int) -> range:
    """Return the rounds whose paths are drawn in colours, if the closest approach is in round `k` of so many."""
    if rounds <= WHOLE:
        return range(rounds)
    begin = min(max(0, k - PART // 2), rounds - PART)
    return range(begin, begin + PART)


def draw_paths(figure: Figure, scene: Scene) -> None:
    """Draw the paths in space (true scale in all directions) and from above."""
    grid = figure.add_gridspec(1, 2, width_ratios=[1.15, 1], wspace=0.12)
    in_space = figure.add_subplot(grid[0], projection="3d")
    _draw_in_space(in_space, scene)
    _draw_from_above(figure.add_subplot(grid[1]), scene)
    handles, labels = in_space.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=6)


def _one_line(positions: Floats) -> Floats:
    """Return the paths of all UAVs as one line with gaps, shape (3, corners)."""
    gap = np.full((1, *positions.shape[1:]), np.nan)
    return np.concatenate([positions, gap]).transpose(2, 1, 0).reshape(3, -1)


def _draw_in_space(axes: Any, scene: Scene) -> None:
    """Draw the paths in space, with their shadows on the floor, and explain all marks."""
    low, high = scene.space
    axes.set_proj_type("ortho")
    axes.view_init(elev=24, azim=-58)
    axes.set_box_aspect(high - low, zoom=1.12)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color("#FAFAFA")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    if scene.others is not None:
        axes.plot(*_one_line(scene.others), **_OTHERS)
    for colour, path in zip(scene.colours, scene.positions.transpose(1, 2, 0), strict=True):
        axes.plot(path[0], path[1], low[2], color=_SHADOW, lw=0.6)
        axes.plot(*path, color=colour, lw=1.1)
    points = {"depthshade": False, "zorder": 5}
    axes.scatter(*scene.positions[0].T, s=30, c="white", edgecolors=scene.colours, linewidths=1.2, **points)
    axes.scatter(*scene.targets.T, s=60, marker="s", facecolors="none", edgecolors=scene.colours, **points)
    axes.scatter(*scene.closest.T, s=110, facecolors="none", edgecolors=RED, linewidths=1.6, **points)
    axes.plot([], [], [], "o", color=GREY, mfc="white", ms=7, label="start")
    axes.plot([], [], [], "s", color=GREY, mfc="none", ms=9, mew=1.3, label="target at the end")
    if scene.earlier:
        axes.plot([], [], [], "s", color=GREY, mfc="none", ms=3.5, mew=0.7, label="earlier target")
    axes.plot([], [], [], "o", color=RED, mfc="none", ms=10, mew=1.6, label="closest approach")
    axes.plot([], [], [], color=_SHADOW, lw=1.2, label="shadow on the floor")
    if scene.others is not None:
        axes.plot([], [], [], color="#DDDDDD", lw=3, label="other rounds")


def _draw_from_above(axes: Axes, scene: Scene) -> None:
    """Draw x and y of the same."""
    (x0, y0, _), (x1, y1, _) = scene.space
    axes.set_aspect("equal")
    if scene.is_whole:
        axes.plot([x0, x1, x1, x0, x0], [y0, y0, y1, y1, y0], color=GREY, lw=1)
    if scene.others is not None:
        axes.plot(*_one_line(scene.others)[:2], **_OTHERS)
    paths = scene.positions.transpose(1, 2, 0)
    for colour, path in zip(scene.colours, paths, strict=True):
        axes.plot(path[0], path[1], color=colour, lw=1.1)
    for points in scene.earlier:
        for colour, point in zip(scene.colours, points, strict=True):
            axes.plot(*point[:2], "s", color=colour, mfc="none", ms=3.5, mew=0.7)
    for i, (colour, path, target) in enumerate(zip(scene.colours, paths, scene.targets, strict=True)):
        axes.plot(path[0, 0], path[1, 0], "o", color=colour, mfc="white", ms=12, mew=1.3)
        axes.text(path[0, 0], path[1, 0], str(i), ha="center", va="center_baseline", fontsize=7.5, zorder=4)
        axes.plot(*target[:2], "s", color=colour, mfc="none", ms=14, mew=1.3)
    for x, y, _ in scene.closest:
        axes.plot(x, y, "o", color=RED, mfc="none", ms=11, mew=1.6)
    axes.set(xlabel="x (m)", ylabel="y (m)", title="From above")
