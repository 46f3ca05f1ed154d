"""Draws the intervals of many parameter sets: curves over a swept parameter, or a row for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from textwrap import fill
from typing import TYPE_CHECKING, Any

from swarmproof.margin.bounds import Margin
from swarmproof.pages.plot_style import (
    BLUE,
    DIP,
    GREY,
    INK,
    ORANGE,
    PALETTE,
    interval_text,
    length_text,
    limit,
    verdict,
)
from swarmproof.theorem3.inequality import Truth
from swarmproof.theorem3.parameters import NAMES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

UNITS = {
    **dict.fromkeys(("T_c", "T_s", "T_b", "delay"), "s"),
    **dict.fromkeys(("v_max", "v_norm"), "m/s"),
    **dict.fromkeys(("a_max", "a_norm"), "m/s²"),
    **dict.fromkeys(("j_max", "j_norm"), "m/s³"),
}
#: How the verdict on the corrected (26) fills a marker.
FILLING: dict[Truth, dict[str, Any]] = {
    Truth.HOLDS: {"fillstyle": "full"},
    Truth.UNDECIDED: {"fillstyle": "bottom", "mfcalt": "white"},
    Truth.FAILS: {"mfc": "white"},
}
ROW_COLOURS = {Truth.HOLDS: BLUE, Truth.UNDECIDED: GREY, Truth.FAILS: ORANGE}
#: By reading.
LINES, MARKERS = ("-", "-.", ":"), ("o", "s", "^")
#: Curves and limits that a legend lists.
MOST_CURVES, MOST_LIMITS = 16, 4
#: Points of a curve from which on its markers are small.
CROWDED = 40
#: A limit this many times above the highest dip is left outside of the plot.
FAR = 3


@dataclass(frozen=True)
class Curve:
    """The results, by increasing x, that agree in their reading and in what else was swept (`settings`)."""

    reading: str
    settings: str
    xs: tuple[float, ...]
    results: tuple[Margin, ...]


def sweep_x(results: Sequence[Margin], names: Sequence[str]) -> str | None:
    """Return the first of the swept `names` that is a number with more than one value, None if none is."""
    for name in _varied(results, names):
        if all(_number(result, name) is not None for result in results):
            return name
    return None


def sweep_curves(results: Sequence[Margin], names: Sequence[str], x: str) -> list[Curve]:
    """Return a curve over `x` per reading and combination of the other swept `names`, in the order of `results`."""
    others = [name for name in _varied(results, names) if name != x]
    groups: dict[tuple[str, str], list[tuple[float, Margin]]] = {}
    for result in results:
        at = _number(result, x)
        if at is not None:
            settings = ", ".join(_setting(result, name, results) for name in others)
            groups.setdefault((result.problem.reading.value, settings), []).append((at, result))
    curves = []
    for (reading, settings), points in groups.items():
        points.sort(key=lambda point: point[0])
        curves.append(Curve(reading, settings, tuple(at for at, _ in points), tuple(result for _, result in points)))
    return curves


def draw_sweep(figure: Figure, results: Sequence[Margin], names: Sequence[str]) -> None:
    """Draw curves over the first of `names` that suits; a row per set if none does or few sets would be joined."""
    x = sweep_x(results, names)
    curves = sweep_curves(results, names, x) if x else []
    joined = 2 * sum(len(curve.xs) > 1 for curve in curves) >= len(curves) > 0
    differences = [result.problem.parameters.differences() for result in results]
    shared = [text for text in differences[0] if len(results) > 1 and all(text in other for other in differences)]
    readings = list(dict.fromkeys(result.problem.reading.value for result in results))
    if x and joined:
        figure.set_size_inches(10, 5.6)
        title, axes = f"{DIP} over {x}", figure.subplots()
        handles = [*_draw_curves(axes, curves, x), *_explained_markers(axes, results)]
        figure.legend(handles=handles, loc="outside right upper")
    else:
        figure.set_size_inches(10, 2.2 + 0.26 * len(results))
        title, axes = f"{DIP} for {len(results)} parameter set{'s' if len(results) > 1 else ''}", figure.subplots()
        handles = [*_draw_rows(axes, results, shared, len(readings) > 1), *_explained_markers(axes, results)]
        figure.legend(handles=handles, loc="outside lower left", ncols=len(handles))
    facts = ", ".join([*(readings if len(readings) == 1 else []), *shared])
    widest = max(result.upper - result.lower for result in results)
    note = f"Certified intervals are drawn as bands, the widest {length_text(widest)}; (26) is the corrected one"
    lines = [title, *([fill(facts, 110)] if facts else []), note]
    figure.suptitle("\n".join(lines), x=0.01, ha="left", fontsize=11, linespacing=1.5)


def _draw_curves(axes: Axes, curves: Sequence[Curve], x: str) -> list[Any]:
    """Draw the dips over `x`, and the limits below which the corrected (26) holds; return what a legend explains."""
    readings = list(dict.fromkeys(curve.reading for curve in curves))
    colours = _colours(curves)
    handles: list[Any] = []
    for curve, colour in zip(curves, colours, strict=True):
        kind = readings.index(curve.reading)
        parts = [*([curve.reading] if len(readings) > 1 or not curve.settings else []), curve.settings]
        label = fill(", ".join(filter(None, parts)), 42, max_lines=2, placeholder=" …")
        low, high = ([float(getattr(result, end)) for result in curve.results] for end in ("lower", "upper"))
        axes.fill_between(curve.xs, low, high, color=colour, alpha=0.3, lw=0)
        axes.vlines(curve.xs, low, high, color=colour, lw=4, alpha=0.4)
        style: dict[str, Any] = {"marker": MARKERS[kind], "color": colour, "ms": 6 if len(curve.xs) < CROWDED else 3}
        handles += axes.plot(curve.xs, high, ls=LINES[kind], label=label, **style)
        for at, y, result in zip(curve.xs, high, curve.results, strict=True):
            axes.plot(at, y, clip_on=False, zorder=3, **style, **FILLING[verdict(result)])
    if len(handles) > MOST_CURVES:
        omitted = axes.plot([], [], " ", label=f"… and {len(handles) - MOST_CURVES} more")
        handles = [*handles[:MOST_CURVES], *omitted]
    axes.set(xlabel=f"{x} ({UNITS.get(x, 'm')})", ylabel=f"{DIP} (m)")
    axes.grid(axis="y", color="#E5E5E5", lw=0.8)
    return handles + _draw_limits(axes, curves, colours)[:MOST_LIMITS]


def _draw_limits(axes: Axes, curves: Sequence[Curve], colours: Sequence[Any]) -> list[Any]:
    """Draw each distinct limit once, in the colour of the curve if it is that of one only; scale the plot to them."""
    owners: dict[tuple[tuple[float, ...], tuple[float, ...]], list[Any]] = {}
    for curve, colour in zip(curves, colours, strict=True):
        limits = tuple(limit(result) for result in curve.results)
        owners.setdefault(((), limits[:1]) if len(set(limits)) == 1 else (curve.xs, limits), []).append(colour)
    highest = max(float(result.upper) for curve in curves for result in curve.results)
    near = [max(limits) for _, limits in owners if max(limits) < FAR * highest]
    top = 1.08 * max([highest, *near]) or 1.0
    axes.set_ylim(0, top)
    handles: list[Any] = []
    for (xs, limits), owning in owners.items():
        where = "this line" if xs else f"{limits[0]:.4g} m"
        beyond = "\n(above the plot)" if min(limits) > top else ""
        label = f"(26) holds below {where}{beyond}" if max(limits) >= 0 else "(26) holds for no dip"
        style: dict[str, Any] = {"color": owning[0] if len(owning) == 1 < len(curves) else INK, "label": label}
        style |= {"lw": 1.2, "dashes": (6, 3)}
        handles += axes.plot(xs, limits, **style) if xs else [axes.axhline(limits[0], **style)]
    return handles


def _colours(curves: Sequence[Curve]) -> list[Any]:
    """Return the curves' colours: by settings, or where these are the same, by reading."""
    from matplotlib import colormaps

    by_settings = len({curve.settings for curve in curves}) > 1
    kinds = [curve.settings if by_settings else curve.reading for curve in curves]
    distinct = list(dict.fromkeys(kinds))
    if len(distinct) <= len(PALETTE):
        return [PALETTE[distinct.index(kind)] for kind in kinds]
    return [colormaps["viridis"](0.92 * distinct.index(kind) / (len(distinct) - 1)) for kind in kinds]


def _draw_rows(axes: Axes, results: Sequence[Margin], shared: Sequence[str], with_reading: bool) -> list[Any]:
    """Draw one interval and limit per row, in the order of `results`; return what a legend explains."""
    names = []
    for row, result in enumerate(results):
        given, low, high = result.problem.parameters, float(result.lower), float(result.upper)
        truth = verdict(result)
        colour = ROW_COLOURS[truth]
        axes.plot((low, high), (row, row), color=colour, lw=6, alpha=0.4, solid_capstyle="butt")
        axes.plot(high, row, "o", color=colour, clip_on=False, **FILLING[truth])
        axes.plot(limit(result), row, "|", color=INK, ms=13, mew=1.5)
        text = "pairs can meet" if result.lower == given.d_hat_min else interval_text(result)
        axes.annotate(text, (1.03, row), xycoords=("axes fraction", "data"), va="center", color=colour)
        own = [text for text in given.differences() if text not in shared]
        own = own or ["no other change" if shared else "published parameters"]
        name = ", ".join([*([result.problem.reading.value] if with_reading else []), *own])
        names.append(fill(name, 60, max_lines=1, placeholder=" …"))
    axes.set_yticks(range(len(results)), names)
    axes.set(xlim=(0, None), ylim=(len(results) - 0.4, -0.6), xlabel=f"{DIP} (m)")
    axes.grid(axis="x", color="#E5E5E5", lw=0.8)
    return axes.plot([], [], "|", color=INK, ms=13, mew=1.5, label="(26) holds left of this")


def _explained_markers(axes: Axes, results: Sequence[Margin]) -> list[Any]:
    """Return what a legend explains of how markers are filled."""
    found, handles = {verdict(result) for result in results}, list[Any]()
    for truth in (truth for truth in FILLING if truth in found):
        label = f"(26) {'is ' if truth is Truth.UNDECIDED else ''}{truth.value}"
        handles += axes.plot([], [], "o", color=GREY, label=label, **FILLING[truth])
    return handles


def _varied(results: Sequence[Margin], names: Sequence[str]) -> list[str]:
    """Return those of `names` that are parameters (a reading is none) with more than one value."""
    return [name for name in names if name in NAMES and len({_value(result, name) for result in results}) > 1]


def _value(result: Margin, name: str) -> Any:
    return getattr(result.problem.parameters, name)


def _number(result: Margin, name: str) -> float | None:
    """Return the parameter as one number, None if it is not one; bounds that are equal on all axes are."""
    value = _value(result, name)
    if isinstance(value, tuple) and len(set(value)) == 1 and not isinstance(value[0], tuple):
        value = value[0]
    return None if name == "order" or value is None or isinstance(value, tuple) else float(value)


def _setting(result: Margin, name: str, results: Sequence[Margin]) -> str:
    """Return ``NAME=VALUE`` for a parameter that is not the same in all `results`."""
    given = result.problem.parameters
    other = next(value for value in (_value(one, name) for one in results) if value != getattr(given, name))
    return next(text for text in given.differences(replace(given, **{name: other})) if text.startswith(f"{name}="))
