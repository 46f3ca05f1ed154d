"""The pictures of the audit, as SVG that needs nothing around it: planes and positions, and samples of the horizon."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from html import escape
from math import hypot, isqrt
from typing import NamedTuple

from swarmproof.algebra.grid import Range, Step, Time
from swarmproof.algebra.polynomial import Values
from swarmproof.prove.steps import Covered, Line, samples

#: Of every picture; colours are never the only sign.
STYLE = """
.ap text { fill: #1b1f24;
  font: 12px system-ui, -apple-system, "Segoe UI", "Liberation Sans", "DejaVu Sans", sans-serif; }
.ap .ap-b { font-weight: 700; } .ap .ap-small { font-size: 11px; fill: #444c56; }
.ap .ap-i { fill: #0a57c2; } .ap .ap-j { fill: #953800; } .ap .ap-bad { fill: #b00020; font-weight: 700; }
.ap-dot { stroke-width: 2.4; fill: #fff; } .ap-dot-i { stroke: #0a57c2; } .ap-dot-j { stroke: #953800; }
.ap-new.ap-dot-i { fill: #0a57c2; } .ap-new.ap-dot-j { fill: #953800; }
.ap-plane { stroke-width: 2; } .ap-plane-i { stroke: #0a57c2; } .ap-plane-j { stroke: #953800; }
.ap-out { opacity: 0.13; } .ap-out-i { fill: #0a57c2; } .ap-out-j { fill: #953800; }
.ap-move { stroke-width: 1.6; fill: none; stroke-dasharray: 2 3; }
.ap-move-i { stroke: #0a57c2; } .ap-move-j { stroke: #953800; }
.ap-near { fill: none; stroke: #b00020; stroke-width: 1.4; stroke-dasharray: 6 4; }
.ap-frame { fill: none; stroke: #8c959f; } .ap-foot { fill: #fff; }
.ap-cell { stroke: #8c959f; stroke-width: 1; } .ap-none { fill: #fff; stroke: #d8dee4; } .ap-given { fill: #bcd7ff; }
.ap-rest { fill: #eaf2ff; } .ap-covered { fill: #bfe8c9; } .ap-gap { fill: #ffd3d8; stroke: #b00020; stroke-width: 2; }
.ap-round { stroke: #57606a; stroke-width: 1.6; }
"""
#: Pixels: of d̂_min in a picture of positions, of a sample and of a row of samples, and of their names.
UNIT, CELL, ROW, NAMES = 105.0, 34, 30, 244


class Plane(NamedTuple):
    """A plane (15): whose; the normal goes from `seen_from` to `entry`; whether it is halfway between them."""

    of: str
    entry: str
    seen_from: str
    halfway: bool


class Scene(NamedTuple):
    """What to draw of a counterexample at one sample: planes, and which two trajectories are flown.

    Attributes:
        planes: of the new trajectories.
        flown: the two positions that are too close.
        title: what the picture shows.
    """

    planes: tuple[Plane, ...]
    flown: tuple[str, str]
    title: str


#: By claim and question: the counterexamples that are drawn.
SCENES: Mapping[tuple[str, str], Scene] = {
    ("lemma-3/printed", "j is in A_ET(k)"): Scene(
        (Plane("i", "j_old", "i_old", True),),
        ("i_new", "j_old"),
        "Lemma 3, j selected and not planned: the plane is halfway, j does not move",
    ),
    ("equal-selection/printed", "neither knows"): Scene(
        (Plane("i", "j_old", "i_old", False), Plane("j", "i_old", "j_old", False)),
        ("i_new", "j_new"),
        "Corollary 1, neither planner knows that the other UAV is selected: both planes are one",
    ),
    ("equal-selection/printed", "one does not know"): Scene(
        (Plane("i", "j_old", "i_old", True), Plane("j", "i_old", "j_old", False)),
        ("i_new", "j_new"),
        "Corollary 1, j's planner does not know that i is selected",
    ),
    ("equal-trackers/printed", "j's planner sees another trajectory of i"): Scene(
        (Plane("i", "j_old", "i_old", True), Plane("j", "i_seen", "j_old", True)),
        ("i_new", "j_new"),
        "Corollary 1, j's planner has another trajectory of i in its tracker: the planes are not parallel",
    ),
}


def draw_scene(scene: Scene, values: Values) -> str:
    """Return the picture of a counterexample in the plane z = 0, `values` being its numbers."""
    unit = values["d"]
    places = {
        name[:-2]: (float(values[name] / unit), float(values[f"{name[:-2]}_y"] / unit))
        for name in values
        if name.endswith("_x")
    }
    xs, ys = ([place[axis] for place in places.values()] for axis in (0, 1))
    left, right, low, high = min(xs) - 1.15, max(xs) + 1.15, min(ys) - 1.1, max(ys) + 1.35
    width, height = (right - left) * UNIT, (high - low) * UNIT

    def at(place: tuple[float, float]) -> tuple[float, float]:
        return (place[0] - left) * UNIT, (high - place[1]) * UNIT

    first, second = scene.flown
    parts = []
    parts += [part for n, plane in enumerate(scene.planes) for part in _plane(plane, places, at, (width, height), n)]
    x, y = at(places[second])
    parts.append(f'<circle class="ap-near" cx="{x:g}" cy="{y:g}" r="{UNIT:g}"/>')
    for uav in "ij":
        old, new = f"{uav}_old", f"{uav}_new"
        if new in places and places[old] != places[new]:
            (x1, y1), (x2, y2) = at(places[old]), at(places[new])
            parts.append(f'<line class="ap-move ap-move-{uav}" x1="{x1:g}" y1="{y1:g}" x2="{x2:g}" y2="{y2:g}"/>')
    together: dict[tuple[float, float], list[str]] = {}
    for name, place in places.items():
        together.setdefault(place, []).append(name)
    for place, names in together.items():
        x, y = at(place)
        for n, name in reversed(list(enumerate(sorted(names)))):
            new = " ap-new" if name.endswith("_new") else ""
            parts.append(f'<circle class="ap-dot ap-dot-{name[0]}{new}" cx="{x:g}" cy="{y:g}" r="{6 + 5 * n}"/>')
        below = not any(name.endswith("_new") for name in names)
        parts.append(_text(x, y + 24 if below else y - 17, " = ".join(map(_name, names)), "ap-b"))
    gap = _distance(values, first, second)
    words = f"{_name(first)} and {_name(second)} are {gap} apart"
    foot = f'<rect class="ap-foot" x="0" y="{height:g}" width="{width:g}" height="26"/>'
    frame = f'<rect class="ap-frame" x="0.5" y="0.5" width="{width - 1:g}" height="{height + 25:g}"/>'
    parts += [foot, _text(width / 2, height + 18, words, "ap-bad"), frame]
    return _svg(width, height + 26, f"{scene.title}. {words}.", parts)


def _plane(
    plane: Plane,
    places: Mapping[str, tuple[float, float]],
    at: Callable[[tuple[float, float]], tuple[float, float]],
    size: tuple[float, float],
    number: int,
) -> list[str]:
    """Return a plane, and the side of it on which its UAV must not be."""
    entry, own = places[plane.entry], places[plane.seen_from]
    normal = (entry[0] - own[0], entry[1] - own[1])
    length = hypot(*normal)
    keep = (1 + length) / 2 if plane.halfway else 1.0
    n = (normal[0] / length, normal[1] / length)
    foot = (entry[0] - keep * n[0], entry[1] - keep * n[1])
    along, reach = (-n[1], n[0]), 20.0
    ends = [(foot[0] + s * reach * along[0], foot[1] + s * reach * along[1]) for s in (1, -1)]
    beyond = [(end[0] + reach * n[0], end[1] + reach * n[1]) for end in reversed(ends)]
    corners = " ".join("{:g},{:g}".format(*at(place)) for place in (*ends, *beyond))
    (x1, y1), (x2, y2) = map(at, ends)
    x, y = at(foot)
    upright = abs(n[0]) > abs(n[1])
    words = f"(15) for {plane.of}"
    text = (
        _text(x - 6, 18 + 17 * number, words, f"ap-{plane.of}", "end")
        if upright
        else _text(size[0] - 8, y + 16, words, f"ap-{plane.of}", "end")
    )
    return [
        f'<polygon class="ap-out ap-out-{plane.of}" points="{corners}"/>',
        f'<line class="ap-plane ap-plane-{plane.of}" x1="{x1:g}" y1="{y1:g}" x2="{x2:g}" y2="{y2:g}"/>',
        text,
    ]


def _name(place: str) -> str:
    uav, what = place.split("_")
    return f"{uav} {what}"


def _distance(values: Values, one: str, other: str) -> str:
    """Return the distance in d̂_min, exactly, if it is rational."""
    square = sum(((values[f"{one}_{a}"] - values[f"{other}_{a}"]) / values["d"]) ** 2 for a in "xyz")
    root = Fraction(isqrt(Fraction(square).numerator), isqrt(Fraction(square).denominator))
    return f"{root if root**2 == square else f'√({square})'} d̂_min"


def draw_step(step: Step, decided: Covered | Line, ratio: int, horizon: int = 3) -> str:
    """Return the samples that a step is given and needs, as rows; what is needed and not covered is a gap.

    Args:
        step: of the proof.
        decided: what became of it; if it has a gap for a certain H only, that is drawn.
        ratio: T/T_c.
        horizon: H, if it has a gap there, too, or none.
    """
    if isinstance(decided, Line) and not _gaps(step, horizon):
        horizon = decided.horizon
    gaps, known = _gaps(step, horizon), _known(step, horizon)
    rows = [(each.name, dict.fromkeys(samples(each, horizon), "given")) for each in step.given]
    given = {s for _, row in rows for s in row}
    if known - given:
        rows.append(("at rest there, and so apart", dict.fromkeys(sorted(known - given), "rest")))
    needed = {s: "gap" if s in gaps else "covered" for s in samples(step.needed, horizon)}
    rows.append((f"needed: {step.needed.name}", needed))
    last = max((s for _, row in rows for s in row), default=0)
    verdict = f"not covered: {', '.join(map(str, sorted(gaps)))}" if gaps else "covered"
    words = (
        f"Given {', '.join(each.name for each in step.given)}; needed {step.needed.name}: {verdict} (H = {horizon})."
    )
    return _strip(rows, last, ratio, words)


def draw_ranges(rows: Sequence[tuple[Range, Range | None]], rest: Time | None, ratio: int, horizon: int = 3) -> str:
    """Return which samples each of some equations speaks of.

    Args:
        rows: an equation, and the one that it is to follow from; samples that this lacks are gaps.
        rest: from there on nothing moves, if that is assumed: then these samples are none.
        ratio: T/T_c.
        horizon: H.
    """
    drawn = []
    for each, source in rows:
        row = dict.fromkeys(samples(each, horizon), "given")
        if source is not None:
            step = Step((source,), each, rest)
            at_rest = set(row) - set(samples(source, horizon))
            row |= {**dict.fromkeys(at_rest, "rest"), **dict.fromkeys(_gaps(step, horizon), "gap")}
        drawn.append((each.name if source is None else f"{each.name}, from {source.name}", dict(sorted(row.items()))))
    words = "; ".join(_in_words(name, row) for name, row in drawn)
    last = max(s for _, row in drawn for s in row)
    return _strip(drawn, last, ratio, f"Samples of each equation for T/T_c = {ratio}, H = {horizon}: {words}.")


def _in_words(name: str, row: Mapping[int, str]) -> str:
    gaps = [str(sample) for sample, kind in row.items() if kind == "gap"]
    return f"{name}: {min(row)} to {max(row)}" + (f", not covered: {', '.join(gaps)}" if gaps else "")


def _known(step: Step, horizon: int) -> set[int]:
    """Return the samples that are given, and those at rest if one of them is given."""
    given = {s for each in step.given for s in samples(each, horizon)}
    if step.rest is None or max(given, default=-1) < step.rest.at(horizon):
        return given
    return given | set(range(step.rest.at(horizon), samples(step.needed, horizon).stop))


def _gaps(step: Step, horizon: int) -> set[int]:
    return set(samples(step.needed, horizon)) - _known(step, horizon)


_SIGNS = {"given": "", "rest": "=", "covered": "✓", "gap": "✗"}


def _strip(rows: Sequence[tuple[str, Mapping[int, str]]], last: int, ratio: int, words: str) -> str:
    """Return rows of samples from 0 to `last` with their rounds above."""
    top = 38
    width, height = NAMES + CELL * (last + 1) + 8, top + ROW * len(rows) + 8
    parts = [_text(NAMES - 8, 14, "round", "ap-small", "end"), _text(NAMES - 8, top - 6, "sample", "ap-small", "end")]
    for sample in range(last + 1):
        x = NAMES + CELL * sample
        parts.append(_text(x + CELL / 2, top - 6, str(sample), "ap-small"))
        if sample % ratio == 0:
            parts.append(_text(x + 5, 14, f"k+{sample // ratio}" if sample else "k", "ap-b", "start"))
    for n, (name, row) in enumerate(rows):
        y = top + ROW * n
        parts.append(_text(NAMES - 8, y + 19, name, "ap-b" if name.startswith("needed") else "", "end"))
        for sample in range(last + 1):
            kind = row.get(sample, "none")
            x = NAMES + CELL * sample
            place = f'x="{x + 1:g}" y="{y + 1:g}" width="{CELL - 2}" height="{ROW - 4}"'
            parts.append(f'<rect class="ap-cell ap-{kind}" {place}/>')
            if sign := _SIGNS.get(kind, ""):
                parts.append(_text(x + CELL / 2, y + 19, sign, "ap-bad" if kind == "gap" else ""))
    for begin in range(0, last + 2, ratio):
        x = NAMES + CELL * begin
        parts.append(f'<line class="ap-round" x1="{x}" y1="4" x2="{x}" y2="{height - 6}"/>')
    return _svg(width, height, words, parts)


def _text(x: float, y: float, words: str, style: str = "", anchor: str = "middle") -> str:
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" class="{style}">{escape(words, quote=False)}</text>'


def _svg(width: float, height: float, label: str, parts: Sequence[str]) -> str:
    size = f'viewBox="0 0 {width:g} {height:g}" width="{width:g}" height="{height:g}"'
    size += f' style="max-width: 100%; min-width: {min(width, 420):g}px; height: auto"'
    return f'<svg class="ap" role="img" aria-label="{escape(label)}" {size}>\n' + "\n".join(parts) + "\n</svg>"
