"""Searches for the losses that bring the swarm closest: Hypothesis looks around, then local search refines.

A pattern is a few losses: what one receiver misses, from which round on, and for how long. Its worth is how close the
references come, at any time, if it is flown.

Every flight also tells what other patterns are worth. UAVs that hear nothing fly on along what they follow; so the
closest approach of what two UAVs follow in round k, over the horizon, is that of another pattern: the same losses
before round k, and from then on these two hear nothing. The smallest of these is what a flight *promises*. Promises
give the search a slope where CUs still repair what losses have broken, and the best one is flown before anything else.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from math import inf, sqrt
from random import Random
from typing import NamedTuple

import hypothesis
import numpy as np
from hypothesis import HealthCheck, Phase, Verbosity
from hypothesis import strategies as st

from swarmproof.assess.between import closest, cubics
from swarmproof.assess.candidates import closest_at_samples
from swarmproof.assess.observing import reference_pieces
from swarmproof.assess.remember import Remembering
from swarmproof.assess.run import Setting
from swarmproof.channel.deliver import deliver
from swarmproof.channel.losses import Losses
from swarmproof.channel.pattern import nothing_lost
from swarmproof.channel.script import shown
from swarmproof.flight.state import Computed, FlightState
from swarmproof.motion.lattice import Floats
from swarmproof.planning.outlook import ARRIVED
from swarmproof.planning.planner import Planner
from swarmproof.semantics.switches import BadInput

#: The largest budget.
MOST_FLIGHTS = 100_000
#: Losses of a pattern: as many as Hypothesis draws, and as many as local search collects.
DRAWN, MOST = 12, 30
#: How long a loss may be when it is drawn, in rounds: often short, sometimes about as long as a horizon.
LENGTHS = (1, 1, 2, 3, 4, 6, 10, 16)
#: Rounds of a flight from which others can go on.
REMEMBERED = 1000
#: Different tasks that the planner remembers.
TASKS = 20_000
#: Patterns in a row that had all been flown before: then there is nothing left to try.
REPEATED = 1000
#: How far a reference moves in a round in which something happens (m).
MOVING = 0.01


@dataclass(frozen=True)
class Worst:
    """The pattern that was found.

    Attributes:
        losses: by round; after the last one everything arrives.
        distance: the smallest scaled distance of references at any time of its flight: a certified lower bound, in m.
        evaluated: how many flights it took.
        description: the pattern in words, a line each.
    """

    losses: tuple[Losses, ...]
    distance: float
    evaluated: int
    description: list[str]


class Place(NamedTuple):
    """What one receiver can miss: its name, what it misses, and where :class:`Losses` mark that.

    Attributes:
        marks: number of the array, row, column; the whole row if the column is None.
    """

    receiver: str
    misses: str
    marks: tuple[tuple[int, int, int | None], ...]


class Loss(NamedTuple):
    """`rounds` rounds of missing something, from round `first` on; `place` is an index."""

    place: int
    first: int
    rounds: int


#: Sorted, without repetitions.
Pattern = tuple[Loss, ...]


def places(uavs: int, cus: int, replies: bool) -> list[Place]:
    """Return all places, for each receiver first the one at which it misses everything.

    Args:
        uavs: N.
        cus: M.
        replies: whether there are conflicts in which receivers decode the one or the other.
    """
    found = []
    for kind, count, slots, coins in (("CU", cus, 1, 3), ("UAV", uavs, 2, 4)):
        for n in range(count):
            at = f"{kind} {n}"
            everything: list[tuple[int, int, int | None]] = [(slots, n, None)]
            if kind == "CU":
                everything.append((0, n, None))
            found.append(Place(at, "hears nothing", tuple(everything)))
            found += [Place(at, f"misses slot {s}", ((slots, n, s),)) for s in range(cus)]
            if kind == "CU":
                found += [Place(at, f"misses the metadata of UAV {i}", ((0, n, i),)) for i in range(uavs)]
            if replies:
                found += [Place(at, f"decodes a reply in slot {s}", ((coins, n, s),)) for s in range(cus)]
    return found


class _Ahead(NamedTuple):
    """How close two UAVs come (m), in round `end` − 1, on what they follow in round k."""

    distance: float
    k: int
    uavs: tuple[int, int]
    end: int


@dataclass(eq=False)
class _Flown:
    """A flight: by round, its state, what was computed in it, and how close the references come (m).

    Attributes:
        marked: by round, the places at which something is missed; rounds without any are left out.
        states: of the rounds 0 … :data:`REMEMBERED` at most, and one more than there are rounds.
        ahead: by round, too.
    """

    pattern: Pattern
    marked: Mapping[int, frozenset[int]]
    states: list[FlightState] = field(default_factory=list)
    computed: list[Computed] = field(default_factory=list)
    distances: list[float] = field(default_factory=list)
    ahead: list[_Ahead] = field(default_factory=list)

    @property
    def distance(self) -> float:
        return min(self.distances)

    @property
    def promise(self) -> _Ahead:
        return min(self.ahead)

    @property
    def key(self) -> tuple[float, int, int]:
        """What is small for a good pattern: closer, then fewer losses, then shorter ones."""
        return self.distance, len(self.pattern), sum(loss.rounds for loss in self.pattern)

    def differs_in(self, marked: Mapping[int, frozenset[int]]) -> list[int]:
        """Return the rounds in which something else is missed."""
        return sorted(k for k in marked.keys() | self.marked.keys() if marked.get(k) != self.marked.get(k))
