"""The index ranges of eqs. (13f) and (16)-(23), as intervals of the sample grid, for every horizon at once.

Time is counted in samples T_c from the start of round k. With m = T/T_c fixed, every end of a range is a + b·H for the
prediction horizon H (in rounds), so that a question about all H is one about a and b.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Time(NamedTuple):
    """The time (a + b·H)·T_c after the start of round k, for the horizon H ≥ 1."""

    a: int
    b: int = 0

    def plus(self, samples: int) -> Time:
        """Return the time that many samples later."""
        return Time(self.a + samples, self.b)

    def at(self, horizon: int) -> int:
        """Return the sample for one H."""
        return self.a + self.b * horizon

    def never_after(self, other: Time, least: int = 1) -> bool:
        """Decide whether this time is at or before `other` for every H ≥ `least`."""
        late = Time(self.a - other.a, self.b - other.b)
        return late.b <= 0 and late.at(least) <= 0


class Range(NamedTuple):
    """Samples `first` … `last` at which two trajectories are known, or needed, to be d̂_min apart."""

    name: str
    first: Time
    last: Time


@dataclass(frozen=True, slots=True)
class Step:
    """A step of a proof: where the trajectories are apart at the samples `given`, they are at the samples `needed`.

    Attributes:
        given: ranges of the same two trajectories.
        needed: the range to be covered.
        rest: from this sample on neither trajectory moves (13e); None if that is not assumed.
        least_horizon: the least H that is meant.
    """

    given: tuple[Range, ...]
    needed: Range
    rest: Time | None
    least_horizon: int = 1
