"""The page about an experiment, as HTML and, for code hosts, as Markdown: statements, pictures, tables, choices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from swarmproof.campaign.decide import Agreement, DecidedClaim, decide_variant
from swarmproof.campaign.store import Stored
from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import Observation
from swarmproof.dmpc_swarm.experiments.experiment import Experiment, Variant
from swarmproof.dmpc_swarm.pages.experiments import words as reproduce_words
from swarmproof.dmpc_swarm.pages.experiments.numbers import Data
from swarmproof.dmpc_swarm.pages.experiments.plots import pictures
from swarmproof.dmpc_swarm.pages.experiments.tables import cells_csv, tables
from swarmproof.dmpc_swarm.semantics import PAPER
from swarmproof.output import ReportFolder
from swarmproof.pages.page import template

#: The sign before a verdict, and its style.
SIGNS: dict[Agreement, tuple[str, str]] = {
    Agreement.AGREES: ("✓", "good"),
    Agreement.DISAGREES: ("✗", "bad"),
    Agreement.UNDECIDED: ("?", "dim"),
}


def shown(decided: DecidedClaim) -> str:
    """Return the verdict with its sign."""
    return f"{SIGNS[decided.verdict][0]} {reproduce_words.verdict(decided)}"


def style(decided: DecidedClaim) -> str:
    """Return the verdict's style."""
    return SIGNS[decided.verdict][1]


@dataclass(frozen=True)
class Verdict:
    """What a variant says of a claim.

    Attributes:
        text: the verdict with its sign.
        counts: of an ordering, in how many seeds each comparison is as said.
        changed: whether it contradicts what is said as chosen; what fewer seeds leave undecided does not.
    """

    text: str
    style: str
    counts: str
    changed: bool


@dataclass(frozen=True)
class Choice:
    """A variant on the page.

    Attributes:
        verdicts: by claim.
    """

    variant: Variant
    flights: int
    seeds: int
    verdicts: Sequence[Verdict]


@dataclass(frozen=True)
class Shown:
    """A claim on the page, with the flight that shows its verdict, if it is one flight."""

    decided: DecidedClaim
    cell: Cell | None


def put_reproduction(folder: ReportFolder, experiment: Experiment, found: Mapping[Cell, Stored], quick: bool) -> None:
    """Put the page into `folder`: `index.html`, `README.md`, pictures, and `cells.csv`.

    Args:
        folder: where they go.
        experiment: what was flown.
        found: what is known of its cells; whatever is missing is said to be missing.
        quick: whether it is the small version.
    """
    every = [Data.of(experiment, variant, found) for variant in experiment.variants]
    drawn = pictures(every[0])
    about = _about(experiment, every, found, quick)
    for picture in drawn:
        folder.put(picture.name, picture.png)
    for name, source in (("index.html", "reproduce.html.j2"), ("README.md", "reproduce.md.j2")):
        folder.put(name, template(source, "swarmproof.dmpc_swarm.pages").render(**about, pictures=drawn))
    folder.put("cells.csv", cells_csv(every))


def _about(
    experiment: Experiment, every: Sequence[Data], found: Mapping[Cell, Stored], quick: bool
) -> dict[str, object]:
    """Return what both templates show."""
    decided = [decide_variant(experiment, data.variant, found) for data in every]
    cells = experiment.cells
    there = [found[cell] for cell in cells if cell in found]
    return {
        "paper": PAPER,
        "experiment": experiment,
        "quick": quick,
        "flights": len(cells),
        "there": len(there),
        "seeds": len(every[0].seeds),
        "time": reproduce_words.duration(sum(stored.seconds for stored in there)),
        "claims": [Shown(each, _cell(each.example, every[0])) for each in decided[0]],
        "tables": [table for table in tables(every[0]) if table.rows],
        "choices": [_choice(data, claims, decided[0]) for data, claims in zip(every, decided, strict=True)],
        "shown": shown,
        "style": style,
    }


def _choice(data: Data, decided: Sequence[DecidedClaim], chosen: Sequence[DecidedClaim]) -> Choice:
    if not data.cells:
        return Choice(data.variant, 0, 0, [Verdict("– not flown", "dim", "", changed=False)] * len(decided))
    verdicts = [
        Verdict(shown(each), style(each), _counts(each), each.verdict not in (base.verdict, Agreement.UNDECIDED))
        for each, base in zip(decided, chosen, strict=True)
    ]
    return Choice(data.variant, len(data.cells), len(data.seeds), verdicts)


def _counts(decided: DecidedClaim) -> str:
    """Return in how many seeds the comparisons are as said, such as ``20, 18 of 20``; nothing if there are none."""
    if not decided.observed or not decided.compared:
        return ""
    return f"{', '.join(str(one.as_said) for one in decided.compared)} of {max(one.seeds for one in decided.compared)}"


def _cell(example: Observation | None, data: Data) -> Cell | None:
    """Return the cell in which this was observed."""
    if example is not None:
        for cell, stored in data.cells.items():
            if cell.seed == example.seed and example in data.experiment.observe(
                cell, stored.measured, data.variant.radius
            ):
                return cell
    return None
