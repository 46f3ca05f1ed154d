"""What the pages about experiments read from flights: numbers by condition, and how they are written with intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from swarmproof.campaign.statistics import median_interval, proportion_interval
from swarmproof.campaign.store import Stored
from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import Label, Observation
from swarmproof.dmpc_swarm.claims.experiments import FORMATIONS, IGNORING, MLR, PRINTED
from swarmproof.dmpc_swarm.experiments.experiment import Experiment, Variant
from swarmproof.dmpc_swarm.experiments.measure import Leg
from swarmproof.pages import phrases
from swarmproof.pages.plot_style import decimal_text

#: m, scaled: the published d_min and d̂_min, which every experiment flies with.
D_MIN, D_HAT_MIN = 0.12, 0.25
#: In the order of the pages.
METHODS = (MLR, PRINTED, IGNORING)
TRIGGERS = ("RR", "DT", "HT")
NONE = "–"


@dataclass(frozen=True)
class Data:
    """What was found of one variant of an experiment.

    Attributes:
        cells: those that were flown, in the variant's order.
        seen: what was observed in them.
    """

    experiment: Experiment
    variant: Variant
    cells: Mapping[Cell, Stored]
    seen: tuple[Observation, ...]

    @classmethod
    def of(cls, experiment: Experiment, variant: Variant, found: Mapping[Cell, Stored]) -> Data:
        """Return what `found` has of `variant`."""
        cells = {cell: found[cell] for cell in variant.cells if cell in found}
        seen = (
            each for cell, stored in cells.items() for each in experiment.observe(cell, stored.measured, variant.radius)
        )
        return cls(experiment, variant, cells, tuple(seen))

    @property
    def seeds(self) -> list[int]:
        """The seeds of the flights."""
        return sorted({cell.seed for cell in self.cells})

    def among(self, **labels: Label) -> list[Observation]:
        """Return the observations with these labels."""
        return [each for each in self.seen if all(each.labels.get(name) == label for name, label in labels.items())]

    def values(self, value: str, **labels: Label) -> list[float]:
        """Return `value` in each observation with these labels; infinite for what did not happen."""
        return numbers(self.among(**labels), value)

    def labels(self, label: str) -> list[Label]:
        """Return what a label can be, in order: what is there, not what should be."""
        return sorted({each.labels[label] for each in self.seen}, key=lambda one: (isinstance(one, str), one))

    def legs(self, cus: int, trigger: str, formation: str) -> list[Leg]:
        """Return that leg of every flight through the formations with so many CUs and a trigger."""
        which = FORMATIONS.index(formation)
        return [
            stored.measured.legs[which]
            for cell, stored in self.cells.items()
            if (cell.cus, cell.trigger) == (cus, trigger)
        ]


def numbers(seen: Sequence[Observation], value: str) -> list[float]:
    """Return `value` of each observation; infinite for what did not happen."""
    given = (each.values[value] for each in seen)
    return [math.inf if one is None else float(one) for one in given]


def collisions(seen: Sequence[Observation]) -> int:
    """Return in how many observations references surely collide."""
    return sum(each.values["collides"] is True for each in seen)


def has_interval(lower: float, upper: float) -> bool:
    """Say whether there were enough seeds for an interval of a median."""
    return lower > -math.inf or upper < math.inf


def times(values: Sequence[float], late: str = "not reached") -> str:
    """Return the median of times in s with its interval, and how many are infinite."""
    if not values:
        return NONE
    lower, median, upper = median_interval(values)
    text = f"{median:.1f} s" if math.isfinite(median) else late
    if has_interval(lower, upper):
        ends = "∞" if upper == math.inf else f"{upper:.1f}"
        text += f" ({'∞' if lower == math.inf else f'{lower:.1f}'} … {ends})"
    never = sum(map(math.isinf, values))
    return f"{text}; {never} of {len(values)} {late}" if never else text


def distances(values: Sequence[float], smallest: bool = True) -> str:
    """Return the median of separations in m with its interval, and the smallest; all rounded down."""
    if not values:
        return NONE
    lower, median, upper = median_interval(values)
    text = f"{down(median)} m"
    if has_interval(lower, upper):
        text += f" ({down(lower)} … {down(upper)})"
    return f"{text}; least {down(min(values))}" if smallest else text


def shares(values: Sequence[float]) -> str:
    """Return the median of shares in percent with its interval."""
    if not values:
        return NONE
    lower, median, upper = median_interval(values)
    text = f"{100 * median:.1f} %"
    return f"{text} ({100 * lower:.1f} … {100 * upper:.1f})" if has_interval(lower, upper) else text


def counted(count: int, of: int) -> str:
    """Return ``2 of 10 (3 … 56 %)``: a count, and the exact interval of the probability."""
    if not of:
        return NONE
    low, high = proportion_interval(count, of)
    return f"{count:,} of {of:,} ({100 * low:.0f} … {100 * high:.0f} %)"


def down(distance: float, places: int = 3) -> str:
    """Return a distance in m, rounded down."""
    return decimal_text(Fraction(distance), places)


def cus(number: int) -> str:
    """Return ``1 CU`` or ``2 CUs``."""
    return phrases.count(number, "CU")
