"""Draws what `swarmproof margin` found: the worst pair of one problem, or the intervals of many."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from swarmproof.errors import BadInput
from swarmproof.files.writing import write
from swarmproof.margin.bounds import Margin
from swarmproof.margin.witness import Motion
from swarmproof.output import reserve_file
from swarmproof.pages.margin.sweep import draw_sweep
from swarmproof.pages.margin.words import scaled_distance
from swarmproof.pages.plot_style import (
    ASKED,
    BLUE,
    DIP,
    GREEN,
    GREY,
    INK,
    KEPT,
    ORANGE,
    SETTINGS,
    decimal_text,
    interval_text,
    length_text,
    limit,
    verdict,
)
from swarmproof.theorem3.inequality import Truth, guaranteed_separation
from swarmproof.theorem3.nothing import about_nothing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = npt.NDArray[np.float64]

#: By suffix, the metadata that keep the time and the drawing program's version out of the file.
METADATA: dict[str, dict[str, Any]] = {
    ".svg": {"Date": None, "Creator": None},
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
#: Steps of the window at which the exact witness is evaluated.
STEPS = 200
#: A dip of less than this share of d̂_min is drawn enlarged, too.
SMALL_DIP = 0.08
#: A region of less than this share of the height has no room for its name.
LEGIBLE = 0.06


def check_path(path: Path) -> None:
    """Make sure, before anything is computed, that a plot can be drawn and written to `path`.

    Raises:
        BadInput: another suffix than .svg, .png or .pdf, no matplotlib, or a file that cannot be written.
    """
    if path.suffix.lower() not in METADATA:
        raise BadInput(f"cannot draw {path}: give a file whose name ends in .svg, .png or .pdf")
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise BadInput("plots need matplotlib: install it by pip install 'swarmproof[plots]'") from None
    reserve_file(path)


def plot_margin(margin: Margin, path: Path) -> None:
    """Draw the worst pair: its distance over the window with what is certified, and both UAVs' paths.

    Raises:
        BadInput: the plot cannot be drawn or written (see :func:`check_path`).
    """

    def draw(figure: Figure) -> None:
        figure.set_size_inches(12, 5.6)
        left, right = figure.subplots(1, 2, width_ratios=[1.25, 1])
        _draw_distance(left, margin)
        _draw_paths(right, margin)
        figure.suptitle(_headline(margin), x=0.01, ha="left", fontsize=11, linespacing=1.5)
        if margin.witness is not None:
            figure.legend(loc="outside lower right", ncols=6)

    _write(draw, path)


def plot_sweep(results: Sequence[Margin], names: Sequence[str], path: Path) -> None:
    """Draw the intervals of many parameter sets, at least one, of which the parameters `names` were swept.

    They are curves over the first of `names` that is a number with more than one value; where there is none, or most
    curves would be single points, there is a row per set.

    Raises:
        BadInput: the plot cannot be drawn or written (see :func:`check_path`).
    """
    _write(lambda figure: draw_sweep(figure, results, names), path)


def distance_curve(margin: Margin) -> tuple[Floats, Floats]:
    """Return times in s since the window's start, and the worst pair's scaled distance in m at them.

    The witness is evaluated exactly and only the results are rounded; its closest approach is among the times. If
    there is no witness, the distance is d̂_min throughout.
    """
    given, witness, times = margin.problem.parameters, margin.witness, _times(margin)
    distances = [float(given.d_hat_min)] * len(times)
    if witness is not None:
        distances = [scaled_distance(margin, time) for time in times]
    return np.array([float(time) for time in times]), np.array(distances)


def scaled_paths(margin: Margin) -> tuple[Floats, Floats, float]:
    """Return both UAVs' paths (m) in a plane of scaled space, at the times of :func:`distance_curve`.

    The plane is spanned by the relative motion's displacement over the window (first coordinate) and the relative
    position at the closest approach, the middle of which is the origin. The last value returned is the largest
    distance (m) of the relative motion from that plane.

    Raises:
        ValueError: there is no witness.
    """
    if margin.witness is None:
        raise ValueError("a margin without a witness has no paths")
    witness, times, scaling = margin.witness, _times(margin), margin.problem.scaling
    closest = times.index(witness.tau)
    uav_i, uav_j = (_positions(uav, witness.start, times) @ scaling.T for uav in (witness.uav_i, witness.uav_j))
    relative = uav_i - uav_j
    plane = _plane([relative[-1] - relative[0], relative[closest], relative[0], *np.eye(3)])
    off = float(np.linalg.norm(relative - relative @ plane.T @ plane, axis=1).max())
    middle = (uav_i[closest] + uav_j[closest]) / 2
    return (uav_i - middle) @ plane.T, (uav_j - middle) @ plane.T, off


def _write(draw: Callable[[Figure], None], path: Path) -> None:
    """Write what `draw` draws; the same drawing gives the same bytes, whatever the user's settings of matplotlib."""
    check_path(path)
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    content, suffix = io.BytesIO(), path.suffix.lower()
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(SETTINGS)
        figure = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
        figure.savefig(content, format=suffix[1:], metadata=METADATA[suffix])
    write(path, content.getvalue())


def _headline(margin: Margin) -> str:
    """Return what was asked, the interval, and what the corrected (26) makes of it."""
    given, changes = margin.problem.parameters, margin.problem.parameters.describe()
    asked = f"{margin.problem.reading.value}, {changes + ', otherwise' if changes else 'with'} the published parameters"
    found = f"{DIP} is between {interval_text(margin).replace('…', 'and')}"
    if margin.lower == given.d_hat_min:
        found = f"{DIP} = {KEPT} = {float(margin.lower):.6g} m: two UAVs can meet between two sampling instants"
    errors = f" with tracking errors of up to {float(given.tracking_error):.4g} m" if given.tracking_error else ""
    asks = f"{ASKED} = {float(given.d_min):.4g} m"
    kept = f"at least {decimal_text(guaranteed_separation(given, margin.loss[1]), 4)} m (scaled)"
    says = {
        Truth.HOLDS: f"The corrected (26) holds: UAVs always stay {kept} apart{errors}; {asks} is asked for",
        Truth.FAILS: f"The corrected (26) fails: Theorem 3 does not promise {asks}{errors}; that alone is no collision",
        Truth.UNDECIDED: f"The corrected (26) is undecided for {asks}{errors}: the interval is too wide",
    }[verdict(margin)]
    nothing = about_nothing(given, margin.problem.reading)
    if nothing:
        says = f"The corrected (26) says nothing: {nothing.partition(':')[0]}"
    return "\n".join((fill(asked, 130), found, says))


def _draw_distance(axes: Axes, margin: Margin) -> None:
    """Draw the worst pair's distance over the window, what is certified below it, and what is asked for."""
    given, curve = margin.problem.parameters, distance_curve(margin)
    kept, asked, floor = (float(value) for value in (given.d_hat_min, given.d_min, given.d_hat_min - margin.upper))
    needed = kept - limit(margin)
    top = 1.1 * max(kept, needed, float(curve[1].max()))
    begins = 1e3 * float(margin.witness.start) if margin.witness else 0.0
    when = f", which begins {begins:.4g} ms into the period" if begins else ""
    axes.set(title="Distance of the worst pair found", xlabel=f"time in the window (ms){when}")
    axes.set(ylabel="scaled distance (m)", ylim=(0, top))
    axes.axhline(asked, color=ORANGE, dashes=(6, 3))
    labels = [(kept, f"{KEPT} = {kept:.4g} m", GREY), (asked, f"{ASKED} = {asked:.4g} m", ORANGE)]
    if needed > asked:
        axes.axhline(needed, color=ORANGE, dashes=(1, 2))
        beyond = given.delay or given.crash_theta_inverse is not None
        paid = "what (26) needs:" if beyond else f"{ASKED} and tracking\nerrors:"
        labels.append((needed, f"{paid} {needed:.4g} m", ORANGE))
    if floor > 0:
        bound, width = decimal_text(given.d_hat_min - margin.upper, 6), length_text(margin.upper - margin.lower)
        labels.append((floor, f"never below {bound} m,\ncertified to {width}", GREEN))
    height = math.inf
    for value, text, colour in sorted(labels, reverse=True):
        height = min(value, height - 0.1 * top)
        axes.annotate(text, (1.02, height), xycoords=("axes fraction", "data"), va="center", color=colour)
    # the largest part of the certified region that has no line in it
    low, high = max((0.0, min(asked, floor)), (needed, floor), key=lambda part: part[1] - part[0])
    enlarged = 0 < margin.lower < SMALL_DIP * given.d_hat_min and high - low > 0.35 * top
    _draw_scene(axes, margin, curve, in_words=not enlarged)
    if enlarged:
        _draw_enlarged(axes, margin, curve, low / top, high / top)
    if floor > LEGIBLE * top:
        y = (needed + floor) / 2 if enlarged and not low else 0.02 * top
        _name_region(axes, y, "no pair gets here (certified)", GREEN)
    if float(margin.upper - margin.lower) > LEGIBLE * top:
        _name_region(axes, floor + 0.02 * top, "undecided", INK)


def _name_region(axes: Axes, y: float, name: str, colour: str) -> None:
    axes.text(0.02, y, name, transform=axes.get_yaxis_transform(), color=colour)


def _draw_enlarged(axes: Axes, margin: Margin, curve: tuple[Floats, Floats], low: float, high: float) -> None:
    """Draw the same between `low` and `high` (shares of the height), enlarged so that a small dip can be seen."""
    inset = axes.inset_axes((0.14, low + 0.25 * (high - low), 0.82, 0.6 * (high - low)))
    kept, dip = float(margin.problem.parameters.d_hat_min), float(margin.upper)
    inset.set_title("the same, enlarged", fontsize=9, pad=3)
    inset.set_ylim(kept - 1.5 * dip, max(kept, float(curve[1].max())) + 0.2 * dip)
    inset.tick_params(labelsize=8)
    inset.spines[:].set_visible(True)
    _draw_scene(inset, margin, curve, in_words=True)


def _draw_scene(axes: Axes, margin: Margin, curve: tuple[Floats, Floats], in_words: bool) -> None:
    """Draw the curve, d̂_min and what is certified; `in_words`: say how close the pair comes."""
    given = margin.problem.parameters
    kept, floor, ceiling = (float(given.d_hat_min - dip) for dip in (Fraction(0), margin.upper, margin.lower))
    axes.set_xlim(0, 1e3 * curve[0][-1])
    axes.axhspan(0, floor, color=GREEN, alpha=0.1, lw=0)
    # the band is usually much thinner than the line along it
    axes.axhspan(floor, ceiling, color=GREY, alpha=0.25, lw=0)
    if floor > 0:
        axes.axhline(floor, color=GREEN, lw=1.2)
    axes.axhline(kept, color=GREY, lw=1.2, dashes=(6, 3))
    axes.plot(1e3 * curve[0], curve[1], color=BLUE, lw=2)
    if margin.witness is None:
        return
    at, distance = 1e3 * float(margin.witness.tau), float(given.d_hat_min - margin.witness.dip)
    axes.plot(at, distance, "o", color=BLUE, ms=7, clip_on=False, zorder=4)
    if not in_words:
        return
    if margin.lower == given.d_hat_min:
        axes.text(at, 0.8 * kept, "pairs can meet", ha="center", va="center", color=BLUE)
    else:
        text, below = f"closest: {distance:.6f} m at {at:.4g} ms", min(distance, floor or distance)
        axes.annotate(text, (at, below), (0, -16), textcoords="offset points", ha="center", color=BLUE)


def _draw_paths(axes: Axes, margin: Margin) -> None:
    """Draw the paths of the worst pair, seen in the plane of its relative motion, and name what the legend explains."""
    from matplotlib.patches import Circle

    if margin.witness is None:
        axes.set_axis_off()
        axes.text(0.5, 0.5, f"No pair was found\nthat comes closer than {KEPT}.", ha="center")
        return
    uav_i, uav_j, off = scaled_paths(margin)
    closest, kept = _times(margin).index(margin.witness.tau), float(margin.problem.parameters.d_hat_min)
    # a UAV that covers the other's path is drawn thinner, and its circle's dashes fill the other's gaps
    wide, thin = (4.5, 1.5) if margin.lower == margin.problem.parameters.d_hat_min else (2, 2)
    for name, path, colour, width, phase in (("UAV i", uav_i, BLUE, wide, 0), ("UAV j", uav_j, ORANGE, thin, 5)):
        x, y = path[closest]
        axes.plot(*path.T, color=colour, lw=width, label=name)
        axes.plot(*path[0], "o", color=colour, mfc="white", ms=10)
        axes.plot(*path[-1], "s", color=colour, ms=5)
        axes.plot(x, y, "o", color=colour, ms=4 + width)
        axes.add_patch(Circle((x, y), kept / 2, fill=False, color=colour, lw=1.2, ls=(phase, (5, 5))))
    axes.plot([], [], "o", color=GREY, mfc="white", ms=10, label="start")
    axes.plot([], [], "o", color=GREY, ms=6, label="closest approach")
    axes.plot([], [], "s", color=GREY, ms=5, label="end")
    axes.plot([], [], color=GREY, lw=1.2, ls=(0, (5, 5)), label=f"{KEPT}/2 around it")
    axes.set_title("Its paths, in the plane of its relative motion")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    leaves = f"\n(the motion leaves this plane by up to {length_text(off)})" if off > 0.01 * kept else ""
    axes.set(xlabel=f"along the relative displacement, scaled (m){leaves}", ylabel="across it, scaled (m)")


def _times(margin: Margin) -> list[Fraction]:
    """Return the times (s, since the window's start) at which the worst pair is drawn."""
    closest = {margin.witness.tau} if margin.witness else set()
    return sorted({margin.problem.parameters.T_c * k / STEPS for k in range(STEPS + 1)} | closest)


def _positions(uav: Motion, start: Fraction, times: Sequence[Fraction]) -> Floats:
    return np.array([[float(axis.position(start + time)) for axis in uav] for time in times])


def _plane(vectors: Sequence[Floats]) -> Floats:
    """Return two orthonormal rows, by Gram and Schmidt, from the first of `vectors` that span a plane."""
    basis: list[Floats] = []
    for vector in vectors:
        rest = vector - sum((float(vector @ unit) * unit for unit in basis), np.zeros(3))
        if len(basis) < 2 and float(np.linalg.norm(rest)) > 1e-6 * float(np.linalg.norm(vector)):
            basis.append(rest / float(np.linalg.norm(rest)))
    return np.array(basis)
