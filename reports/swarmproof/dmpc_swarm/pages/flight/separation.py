"""Draws how close the references of a flight came: the certified band over time, and the closest approach."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from swarmproof.dmpc_swarm.flight.judge import Flown
from swarmproof.dmpc_swarm.flight.log import Log
from swarmproof.dmpc_swarm.pages.flight.series import Band, Bins, one_scale, pair_distance, sampled_separation
from swarmproof.dmpc_swarm.pages.flight.timeline import RED
from swarmproof.motion.lattice import Floats
from swarmproof.pages.plot_style import ASKED, BLUE, GREY, INK, KEPT, ORANGE, decimal_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: A dip below d̂_min by less than this share of it is drawn enlarged; a larger one is seen without.
SMALL_DIP = 0.2
#: UAVs that never come closer than this multiple of d̂_min are far apart: there is nothing to enlarge.
NEAR = 1.05
#: Rounds before and after the closest approach, and points in a round at least, of the picture of it.
AROUND, POINTS = 4, 60


def is_enlarged(flown: Flown, kept: float) -> bool:
    """Return whether the separation is also drawn enlarged around d̂_min, `kept` (m)."""
    return (1 - SMALL_DIP) * kept <= float(flown.band[:, 0].min()) <= NEAR * kept


def shows_dip(flown: Flown, log: Log) -> bool:
    """Return the same for a flight: not where crashes are scaled in another way than what is kept."""
    return one_scale(log) and is_enlarged(flown, float(log.flight.scenario.parameters.d_hat_min))


def down_text(distance: float) -> str:
    """Return a distance in m with six decimals, rounded down."""
    return decimal_text(Fraction(distance), 6)


def draw_separation(figure: Figure, flown: Flown, log: Log) -> None:
    """Draw the band over the flight, enlarged around d̂_min if that shows more, and the closest approach."""
    given = log.flight.scenario.parameters
    kept, T_c = float(given.d_hat_min), float(given.T_c)
    band = Band.of(flown, T_c)
    grid = figure.add_gridspec(2, 2, width_ratios=[1.9, 1])
    last = whole = figure.add_subplot(grid[0, 0] if shows_dip(flown, log) else grid[:, 0])
    _draw_band(whole, band, log)
    whole.set(title="The smallest distance of any two references", ylim=(0, None))
    if shows_dip(flown, log):
        last = figure.add_subplot(grid[1, 0], sharex=whole)
        _draw_band(last, band, log)
        _draw_samples(last, sampled_separation(log), T_c)
        dip = max(kept - float(band.lower.min()), 0.001 * kept)
        last.set(title=f"The same, enlarged around {KEPT}", ylim=(kept - 1.4 * dip, kept + 1.4 * dip))
    last.set_xlabel("time (s)")
    _draw_closest(figure.add_subplot(grid[:, 1]), flown, log)
    figure.legend(*last.get_legend_handles_labels(), loc="outside lower center", ncols=5)


def _draw_band(axes: Axes, band: Band, log: Log) -> None:
    """Draw the band, what planners keep, and what is asked for."""
    given = log.flight.scenario.parameters
    asked = float(given.d_min)
    kept = float(given.d_hat_min) if one_scale(log) else asked
    corners = np.repeat(band.edges, 2)[1:-1]
    lower, upper, highest = (np.repeat(values, 2) for values in (band.lower, band.upper, band.highest))
    if band.steps > 1:
        axes.fill_between(corners, upper, highest, color=BLUE, alpha=0.3, lw=0, label="range of the steps in a bin")
    axes.fill_between(corners, lower, kept, where=(lower < kept).tolist(), color=ORANGE, alpha=0.3, lw=0)
    axes.fill_between(corners, lower, upper, color=BLUE, lw=0.9, label="certified smallest distance")
    if one_scale(log):
        axes.axhline(kept, color=GREY, lw=1.1, dashes=(6, 3), label=f"{KEPT} = {kept:g} m")
    axes.axhline(asked, color=RED, lw=1.1, dashes=(6, 3), label=f"{ASKED} = {asked:g} m")
    axes.set_xlim(0, band.edges[-1])
    axes.set_ylabel("scaled distance (m)")


def _draw_samples(axes: Axes, sampled: Floats, T_c: float) -> None:
    bins = Bins.of(len(sampled))
    axes.plot(bins.edges(T_c)[:-1], bins.least(sampled), ".", color=INK, ms=2.5, label="at samples")


def _draw_closest(axes: Axes, flown: Flown, log: Log) -> None:
    """Draw the distance of the closest pair around its closest approach."""
    given, steps = log.flight.scenario.parameters, log.flight.lattice.steps
    kept = float(given.d_hat_min if one_scale(log) else given.d_min)
    period = float(given.T_s)
    (i, j), time = flown.closest_pair
    k = min(int(time / period), len(log.rounds) - 1)
    rounds = range(max(0, k - AROUND), min(len(log.rounds), k + AROUND + 1))
    # so many points from one sample to the next that a round has POINTS, or a few more
    points = -(-POINTS // steps)
    # round by round: a reference that was planned from a wrong state jumps between two rounds
    curves = np.array([pair_distance(log, flown.closest_pair[0], points * steps, k, k + 1) for k in rounds])
    times = period * (np.array(rounds)[:, None] + np.linspace(0, 1, curves.shape[1]))
    lowest, highest = float(curves.min()), float(curves.max())
    span = max(abs(kept - lowest), 0.002 * kept)
    low, high = min(kept, lowest) - span, min(max(kept, lowest) + 6 * span, 1.05 * max(kept, highest))
    for t, curve in zip(times, curves, strict=True):
        axes.fill_between(t, curve, kept, where=(curve < kept).tolist(), color=ORANGE, alpha=0.3, lw=0)
        axes.plot(t, curve, color=BLUE, lw=1.6)
        axes.plot(t[:-1:points], curve[:-1:points], "o", color=INK, ms=4.5)
    axes.axhline(kept, color=GREY, lw=1.1, dashes=(6, 3))
    axes.axhline(float(given.d_min), color=RED, lw=1.1, dashes=(6, 3))
    axes.plot(time, flown.continuous_lower, "o", color=RED, mfc="none", ms=10, mew=1.6)
    begin, end = _shown(times.ravel(), curves.ravel(), high, float(given.T_c))
    axes.set(title=f"UAVs {i} and {j} around {time:.2f} s", xlabel="time (s)", ylabel="scaled distance (m)")
    axes.set(xlim=(begin, end), ylim=(max(low, 0.0), high))
    to_the_right = time < (begin + end) / 2
    axes.annotate(
        f"never below\n{down_text(flown.continuous_lower)} m",
        (time, flown.continuous_lower),
        (12 if to_the_right else -12, -6),
        textcoords="offset points",
        color=RED,
        fontsize=9,
        ha="left" if to_the_right else "right",
        va="top",
    )


def _shown(times: Floats, curve: Floats, high: float, margin: float) -> tuple[float, float]:
    """Return from when to when (s) the curve stays below `high` around its minimum, and `margin` more."""
    lowest, above = int(curve.argmin()), np.flatnonzero(curve > high)
    begin, end = above[above < lowest].max(initial=0), above[above > lowest].min(initial=len(curve) - 1)
    return max(float(times[0]), times[begin] - margin), min(float(times[-1]), times[end] + margin)
