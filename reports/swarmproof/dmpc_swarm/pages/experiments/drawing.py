"""What the pictures of experiments have in common: size, colours, medians with intervals, and what never happened."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from swarmproof.campaign.statistics import median_interval
from swarmproof.dmpc_swarm.claims.experiments import IGNORING, MLR, PRINTED
from swarmproof.pages.plot_style import BLUE, GREEN, GREY, INK, ORANGE, SETTINGS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: One colour for one condition in all pictures: HT with 3 CUs is blue, and so is the method of the paper.
CUS_COLOURS = {1: ORANGE, 2: "#CC79A7", 3: BLUE}
TRIGGER_COLOURS = {"RR": "#E69F00", "DT": GREEN, "HT": BLUE}
METHOD_COLOURS = {MLR: BLUE, PRINTED: GREEN, IGNORING: ORANGE}
COLLISION = "#B00020"
#: Pixels per inch: pictures are 12 inches wide, or less.
DPI = 120


@dataclass(frozen=True)
class Picture:
    """A picture on a page.

    Attributes:
        name: of its file, with the suffix.
        png: the picture.
        caption: what to see.
    """

    name: str
    title: str
    png: bytes
    caption: str


def render(draw: Callable[[Figure], None], width: float, height: float) -> bytes:
    """Return what `draw` draws as PNG (sizes in inches), whatever the user's settings of matplotlib."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    content = io.BytesIO()
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update({**SETTINGS, "font.size": 11, "axes.titlesize": 12, "hatch.linewidth": 0.6})
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
        figure.savefig(content, format="png", dpi=DPI, metadata={"Software": None})
    return content.getvalue()


def say_missing(axes: Axes) -> None:
    """Write that there is nothing to draw."""
    axes.text(0.5, 0.5, "no flights", transform=axes.transAxes, ha="center", va="center", color=GREY)


def with_interval(axes: Axes, x: float, values: Sequence[float], colour: str, top: float, **style: Any) -> None:
    """Draw the median at `x`, and its interval over seeds if there are enough; what is infinite is at `top`."""
    lower, median, upper = (min(one, top) for one in median_interval(values))
    if lower > -math.inf:
        axes.plot([x, x], [lower, upper], color=colour, lw=style.pop("lw", 2), solid_capstyle="butt", zorder=3)
    axes.plot([x], [median], color=colour, ls="none", zorder=4, **{"marker": "_", "ms": 13, "mew": 2.5, **style})


def not_reached(axes: Axes, x: float, top: float, values: Sequence[float], colour: str, size: float = 9) -> None:
    """Mark at the top edge how many of `values` are infinite, if any."""
    never = sum(map(math.isinf, values))
    if never:
        axes.plot([x], [top], "^", color=colour, ms=6, clip_on=False, zorder=5)
        axes.annotate(
            str(never), (x, top), (0, 5), textcoords="offset points", ha="center", color=INK, fontsize=size, zorder=6
        )


def edge(values: Sequence[float], least: float) -> float:
    """Return where the top edge of axes from 0 is, so that all finite `values` are below it."""
    return 1.12 * max((one for one in values if math.isfinite(one)), default=least)


def spread(number: int, width: float) -> list[float]:
    """Return places around 0 for so many dots, `width` wide altogether."""
    return [width * ((n + 0.5) / number - 0.5) for n in range(number)]
