"""The form of claims about flights that are repeated with many seeds.

A flight is seen as observations: labels say under which condition, values what came out. All observations of one seed
are a run: what is compared within one has the same starts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf

Label = str | int
#: None: it did not happen (a time), or could not be decided (a collision).
Value = float | bool | None


@dataclass(frozen=True, slots=True)
class Observation:
    """What came out of one flight, or of one formation in it.

    Attributes:
        seed: of the flight.
        labels: the condition, such as ``{"cus": 3, "trigger": "HT", "formation": "cube"}``.
        values: numbers in s, m or 1 (shares).
    """

    seed: int
    labels: Mapping[str, Label]
    values: Mapping[str, Value]


Run = Sequence[Observation]
#: A number of one run; infinite where what it speaks of did not happen, nan where it is not known.
Reading = Callable[[Run], float]


def runs(observations: Sequence[Observation]) -> list[Run]:
    """Return the observations of each seed."""
    return [[seen for seen in observations if seen.seed == seed] for seed in sorted({one.seed for one in observations})]


class Missing(Exception):
    """A run has no observation under the condition that is read."""


def read(value: str, **labels: Label) -> Reading:
    """Return the reading of `value` in the one observation with these labels.

    The reading raises Missing if there is none, and KeyError if there is more than one or if it has no such value.
    """

    def reading(run: Run) -> float:
        found = [seen for seen in run if all(seen.labels.get(name) == label for name, label in labels.items())]
        if not found:
            raise Missing(labels)
        if len(found) > 1:
            raise KeyError(f"{len(found)} observations with {labels}")
        number = found[0].values[value]
        return inf if number is None else float(number)

    return reading


@dataclass(frozen=True, slots=True)
class Comparison:
    """`smaller` is said to be smaller than `larger`, in a run."""

    name: str
    smaller: Reading
    larger: Reading


@dataclass(frozen=True, slots=True)
class Ordering:
    """At least `needed` of the comparisons come out as said, in most runs."""

    comparisons: tuple[Comparison, ...]
    needed: int


@dataclass(frozen=True, slots=True)
class Never:
    """In no observation that is `among` those meant, `happens` is true; None where that is not decided."""

    among: Callable[[Observation], bool]
    happens: Callable[[Observation], bool | None]


@dataclass(frozen=True, slots=True)
class Sometimes:
    """In some observation that is `among` those meant, `happens` is true; None where that is not decided."""

    among: Callable[[Observation], bool]
    happens: Callable[[Observation], bool | None]


@dataclass(frozen=True, slots=True)
class ExperimentClaim:
    """One statement of the paper about an experiment.

    Attributes:
        experiment: fig3b, fig3c, fig4 or loss.
        wording: what is said.
        place: where the paper says it.
        reading: how words that leave something open are read here.
    """

    id: str
    experiment: str
    wording: str
    place: str
    reading: str
    statement: Ordering | Never | Sometimes
