"""The pictures of a flight with what to look for. Every picture is an SVG, the same bytes every time."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.claims.flight import FlightClaim
from swarmproof.dmpc_swarm.flight.judge import Flown
from swarmproof.dmpc_swarm.flight.log import Log
from swarmproof.dmpc_swarm.pages.flight.paths import Scene, draw_paths
from swarmproof.dmpc_swarm.pages.flight.separation import down_text, draw_separation, shows_dip
from swarmproof.dmpc_swarm.pages.flight.series import Band, Bins, jumps, one_scale
from swarmproof.dmpc_swarm.pages.flight.timeline import draw_timeline, height
from swarmproof.errors import BadInput
from swarmproof.pages.plot_style import SETTINGS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Without any of these, a file does not change with the day or with the version of the program.
_METADATA: dict[str, Any] = dict.fromkeys(("Date", "Creator", "Format", "Type"))


@dataclass(frozen=True)
class Picture:
    """A picture on the page.

    Attributes:
        name: of its file, without the suffix.
        svg: the picture.
        alt: what it shows, for those who do not see it.
        caption: what to look for.
    """

    name: str
    title: str
    svg: str
    alt: str
    caption: str


def check_available() -> None:
    """Make sure, before anything is computed, that flights can be drawn.

    Raises:
        BadInput: there is no matplotlib.
    """
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise BadInput("a flight report needs matplotlib: install it by pip install 'swarmproof[plots]'") from None


def pictures(flown: Flown, log: Log) -> list[Picture]:
    """Return all pictures of a flight of at least one round."""
    return [_paths(flown, log), _separation(flown, log), _timeline(flown, log)]


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
    return _shorter(content.getvalue())


def _shorter(svg: str) -> str:
    """Return the same picture with coordinates in hundredths of a point: half the size."""

    def rounded(attribute: re.Match[str]) -> str:
        return re.sub(r"\d+\.\d{3,}", lambda number: f"{float(number[0]):.2f}", attribute[0])

    return re.sub(r' (?:d|x|y|x1|x2|y1|y2)="[^"]*"', rounded, svg)


def _paths(flown: Flown, log: Log) -> Picture:
    scene = Scene.of(flown, log)
    (i, j), time = flown.closest_pair
    return Picture(
        "paths",
        "Where they flew",
        _draw(lambda figure: draw_paths(figure, scene), 12, 6.2),
        f"The paths of {len(scene.targets)} UAVs in space and from above, with starts, targets and the closest "
        "approach.",
        "Look for paths that give way to each other, and for UAVs that end away from their targets. Each UAV has a "
        "colour, and its number stands where it starts. Scales are equal in all directions; the box is the flying "
        f"space. The red rings: UAVs {i} and {j} at the closest approach of all, at {time:.2f} s. From above, UAVs "
        "that fly over each other seem to meet."
        + (
            f" The flight is long: coloured are the rounds {scene.rounds.start} to {scene.rounds.stop - 1}, with the "
            "places and the targets of their begin and end; grey are all others."
            if scene.others is not None
            else ""
        )
        + (
            f" In {jumping} rounds, some reference jumps: it was planned from where its UAV was not."
            if (jumping := jumps(log))
            else ""
        ),
    )


def _separation(flown: Flown, log: Log) -> Picture:
    given = log.flight.scenario.parameters
    kept, steps = float(given.d_hat_min), Band.of(flown, float(given.T_c)).steps
    broken = {judged.claim.id for judged in flown.claims if judged.verdict is Verdict.VIOLATED}
    at_samples = (
        "Here references are closer than d̂_min at samples, too."
        if "theorem-2" in broken
        else "At samples, all references keep it here; where the curve is below, they dip between two samples."
    )
    surely, perhaps = (int((bound < kept).sum()) for bound in (flown.band[:, 1], flown.band[:, 0]))
    below = f"{surely}" if surely == perhaps else f"{surely} to {perhaps}"
    (i, j), time = flown.closest_pair
    both = [
        "Look for the curve below d̂_min, which planners keep at samples only, and below d_min, a collision.",
        f"{at_samples} That is so in {below} of {len(flown.band)} steps T_c.",
    ]
    only = "Look for the curve below d_min, a collision. It is scaled for these, not as what planners keep at samples."
    caption = [
        *(both if one_scale(log) else [only]),
        "It is a certified band, mostly thinner than the line: the true value lies in it, at all times, for all pairs.",
        "Distances are scaled, ‖Θ⁻¹(p_j − p_i)‖. On the right, the two UAVs that come closest; dots are samples.",
    ]
    if steps > 1:
        caption.append(f"The flight is long: the curve shows the smallest value of {steps} steps T_c at a time.")
    if given.tracking_error:
        caption.append(f"The UAVs may be up to {float(given.tracking_error):g} m away from these references.")
    return Picture(
        "separation",
        "How close they came",
        _draw(lambda figure: draw_separation(figure, flown, log), 12, 6 if shows_dip(flown, log) else 4.6),
        f"The certified smallest scaled distance of any two references over time, with d̂_min and d_min; closest are "
        f"UAVs {i} and {j} at {time:.2f} s, never closer than {down_text(flown.continuous_lower)} m.",
        " ".join(caption),
    )


def first_violations(flown: Flown, period: float) -> list[float]:
    """Return when (s) claims about rounds were broken for the first time: at the end of a round."""
    rounds = {
        judged.rounds
        for judged in flown.claims
        if judged.verdict is Verdict.VIOLATED
        and judged.rounds is not None
        and not (isinstance(judged.claim, FlightClaim) and judged.claim.in_round is None)
    }
    return [period * k for k in sorted(rounds)]


def _timeline(flown: Flown, log: Log) -> Picture:
    scenario, cus = log.flight.scenario, log.flight.cus
    violations = first_violations(flown, float(scenario.parameters.T_s))
    width = Bins.of(len(log.rounds)).width
    caption = [
        "Look for what a loss does: CUs leave RUN_DMPC, and while they do, nobody is planned and the distances stay.",
        "At the top, a mark is a plan, in the colour of its CU; hollow (grey in long flights), if its UAV did not get "
        "it. A row without marks is a UAV that nobody plans.",
    ]
    if violations:
        caption.append("Red lines are first violations of claims about a round.")
    if width > 1:
        caption.append(
            f"The flight is long: a column is {width} rounds, with the mean of their losses, the share of each state, "
            "and the largest and the smallest distance."
        )
    return Picture(
        "timeline",
        "What happened when",
        _draw(lambda figure: draw_timeline(figure, log, violations), 12, height(scenario.uavs, cus)),
        "Over time: which UAV each CU planned, lost messages, the states of the CUs, and the distances to the targets.",
        " ".join(caption),
    )
