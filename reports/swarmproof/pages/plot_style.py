"""What the plots of `swarmproof margin` have in common: colours, and how intervals and lengths are written."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from swarmproof.margin.bounds import Margin
from swarmproof.theorem3.delay import largest_dip
from swarmproof.theorem3.inequality import Truth, largest_loss
from swarmproof.theorem3.nothing import about_nothing

#: Okabe and Ito's colours, which are told apart without seeing red and green.
INK, GREY, BLUE, ORANGE, GREEN = "#222222", "#6B6B6B", "#0072B2", "#D55E00", "#009E73"
PALETTE = (BLUE, ORANGE, GREEN, "#CC79A7", "#E69F00", "#56B4E9", INK)
#: Settings of matplotlib; hashsalt makes the identifiers in an SVG the same every time.
SETTINGS: dict[Any, Any] = {
    "axes.formatter.useoffset": False,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 11,
    "font.size": 10,
    "legend.frameon": False,
    "savefig.dpi": 150,
    "svg.hashsalt": "swarmproof",
}
#: Δd_min,cont, d̂_min and d_min as matplotlib sets formulas.
DIP, KEPT, ASKED = r"$\Delta d_{\mathrm{min,cont}}$", r"$\hat{d}_{\mathrm{min}}$", r"$d_{\mathrm{min}}$"


def verdict(result: Margin) -> Truth:
    """Return whether the corrected (26) holds; of parameters that are about nothing, nothing is decided."""
    if about_nothing(result.problem.parameters, result.problem.reading):
        return Truth.UNDECIDED
    return result.truths[1]


def limit(result: Margin) -> float:
    """Return the largest dip (m) with which the corrected (26) holds; negative if none is small enough."""
    given = result.problem.parameters
    return float(largest_dip(given, result.problem.reading, largest_loss(given), result.flown[1]))


def interval_text(result: Margin) -> str:
    """Return the interval (m) with as many digits as show its width, rounded outwards."""
    width = result.upper - result.lower
    places = max(4, 2 - math.floor(math.log10(width))) if width else 7
    return f"{decimal_text(result.lower, places)} … {decimal_text(result.upper, places, up=True)} m"


def decimal_text(value: Fraction, places: int, up: bool = False) -> str:
    """Return `value` with so many decimals, rounded down, or `up`."""
    scaled = value * 10**places
    return f"{(math.ceil(scaled) if up else math.floor(scaled)) / 10**places:.{places}f}"


def length_text(length: Fraction | float) -> str:
    """Return a length given in m with two digits, in m, mm or µm."""
    metres = float(length)
    unit, per_metre = ("m", 1.0) if metres >= 0.1 else ("mm", 1e3) if metres >= 1e-4 else ("µm", 1e6)
    return f"{metres * per_metre:.2g} {unit}"
