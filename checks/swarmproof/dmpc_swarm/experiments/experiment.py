"""What an experiment is: variants, which are lists of cells, and what is observed of each cell.

The first variant is flown *as chosen*. Each other one changes a choice that the paper leaves open, with fewer seeds, to
see whether what agrees with the paper depends on it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import Observation
from swarmproof.dmpc_swarm.claims.experiments import IGNORING, MLR, PERIOD_S, PRINTED
from swarmproof.dmpc_swarm.experiments.measure import REACHED, Measured

#: Starts are disturbed by so much in each direction, in m, as real ones are: without, flights would not differ.
JITTER = "jitter=0.02"
AS_CHOSEN = "as chosen"
#: By preset of the semantics, what the protocol is called in the label ``method``.
METHODS = {"guarded": MLR, "printed": PRINTED, "ignore-loss": IGNORING}


@dataclass(frozen=True, slots=True)
class Variant:
    """An experiment with one choice changed.

    Attributes:
        name: the change, such as ``band=0.5``; the first variant's is :data:`AS_CHOSEN`.
        meaning: what it changes, in words.
        cells: the flights.
        radius: how close to its target a UAV must be to have reached it, in m; one of `measure.RADII`.
    """

    name: str
    meaning: str
    cells: tuple[Cell, ...]
    radius: float = REACHED


@dataclass(frozen=True, slots=True)
class Experiment:
    """One of the paper's experiments.

    Attributes:
        name: what the command line calls it.
        title: what a reader calls it.
        about: what is flown, in a few sentences.
        variants: as chosen, then others.
        observe: what came out of a cell, with a variant's radius (m).
    """

    name: str
    title: str
    about: str
    variants: tuple[Variant, ...]
    observe: Callable[[Cell, Measured, float], list[Observation]]

    @property
    def cells(self) -> tuple[Cell, ...]:
        """All cells, each once: those as chosen first, by seed, so that what is interrupted has whole seeds."""
        every = dict.fromkeys(cell for variant in self.variants for cell in variant.cells)
        chosen = set(self.variants[0].cells)
        return tuple(sorted(every, key=lambda cell: (cell not in chosen, cell.seed)))

    def as_chosen(self) -> Experiment:
        """Return the experiment without the variants that change a choice."""
        return replace(self, variants=self.variants[:1])


def seconds(rounds: float | None) -> float | None:
    """Return so many rounds in s; None stays None."""
    return None if rounds is None else rounds * PERIOD_S
