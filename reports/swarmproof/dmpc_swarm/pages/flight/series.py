"""What the pictures of a flight show, as numbers over time; long flights are thinned out without losing extremes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from swarmproof.dmpc_swarm.flight.judge import Flown
from swarmproof.dmpc_swarm.flight.log import Log, moved
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.motion.pairs import Floats, turned
from swarmproof.scenario.scenario import Scenario

#: How many numbers a curve has at most: more could not be told apart on a page.
MOST = 1200


@dataclass(frozen=True)
class Bins:
    """Consecutive entries that are drawn as one: the bins begin at `starts` and hold `width` entries, the last rest."""

    starts: NDArray[np.int64]
    width: int
    count: int

    @classmethod
    def of(cls, count: int, most: int = MOST) -> Bins:
        """Return as few entries to a bin as make `most` bins, or less, of `count` entries, at least one."""
        width = -(-count // most)
        return cls(np.arange(0, count, width), width, count)

    def edges(self, duration: float) -> Floats:
        """Return where the bins begin, and where the last one ends, if an entry takes `duration`."""
        return np.append(self.starts, self.count) * duration

    def least(self, values: Floats) -> Floats:
        """Return the smallest of `values` (first axis) in each bin."""
        smallest: Floats = np.minimum.reduceat(values, self.starts, axis=0)
        return smallest

    def largest(self, values: Floats) -> Floats:
        """Return the largest of `values` in each bin."""
        largest: Floats = np.maximum.reduceat(values, self.starts, axis=0)
        return largest

    def mean(self, values: Floats) -> Floats:
        """Return the mean of `values` in each bin."""
        sizes = np.diff(np.append(self.starts, self.count))
        sums = np.add.reduceat(values, self.starts, axis=0)
        means: Floats = sums / sizes.reshape(-1, *[1] * (values.ndim - 1))
        return means


@dataclass(frozen=True)
class Band:
    """The certified enclosure of the smallest distance of any two references.

    Attributes:
        edges: where the bins begin and end, in s.
        lower: a lower bound of the smallest distance (m) at any time in the bin, for any pair.
        upper: an upper bound of it.
        highest: an upper bound of the smallest distance of any pair in every single step T_c of the bin.
        steps: how many steps T_c a bin has.
    """

    edges: Floats
    lower: Floats
    upper: Floats
    highest: Floats
    steps: int

    @classmethod
    def of(cls, flown: Flown, T_c: float, most: int = MOST) -> Band:
        """Return the band of a flight in at most so many bins."""
        bins = Bins.of(len(flown.band), most)
        lower, upper = flown.band.T
        # the bound of the whole flight holds in every step, too, and may be the better one
        lower = np.maximum(lower, flown.continuous_lower)
        return cls(bins.edges(T_c), bins.least(lower), bins.least(upper), bins.largest(upper), bins.width)


def sampled_separation(log: Log) -> Floats:
    """Return the smallest scaled distance (m) of any two references at each sample, shape (R·m + 1,), but for rounding.

    For drawing only: the claims are decided exactly, elsewhere.
    """
    lattice = log.flight.lattice
    pairs = lattice.pairs
    per_metre = 1 / float(lattice.position_unit)
    scaled = log.positions(lattice.steps) @ (pairs.first * (float(pairs.unit) * per_metre if pairs.alike else 1)).T
    first, second = np.triu_indices(scaled.shape[1], 1)
    in_metres = pairs.in_metres(first, second)
    matrices = None if in_metres is None else in_metres * per_metre
    at_once = max(1, 2**18 // len(first))
    smallest = [
        np.sqrt((turned(some[:, second] - some[:, first], matrices) ** 2).sum(axis=2).min(axis=1))
        for some in (scaled[begin : begin + at_once] for begin in range(0, len(scaled), at_once))
    ]
    return np.concatenate(smallest)


def one_scale(log: Log) -> bool:
    """Return whether what plans keep and what a crash is are scaled alike, so that one axis can have both."""
    kept, crash = log.flight.lattice.pairs, log.flight.lattice.crash
    return kept.units == crash.units and bool((kept.matrices == crash.matrices).all())


def pair_distance(log: Log, pair: tuple[int, int], per_round: int, first: int, last: int) -> Floats:
    """Return the distance (m) of one pair in the rounds `first` … `last` − 1, `per_round` times to a round.

    It is scaled as that of a crash, like the certified band.
    """
    i, j = pair
    positions = log.positions(per_round, first, last)
    lattice, crash = log.flight.lattice, log.flight.lattice.crash
    matrix = crash.first if crash.alike else crash.matrices[crash.members[i], crash.members[j]]
    apart = (positions[:, j] - positions[:, i]) @ (matrix * float(crash.unit_of(i, j) / lattice.position_unit)).T
    distance: Floats = np.sqrt((apart**2).sum(axis=1))
    return distance


def jumps(log: Log) -> int:
    """Return in how many rounds some reference begins elsewhere than it was at the end of the round before, exactly."""
    steps = log.flight.lattice.steps
    rounds = [logged.motion for logged in log.rounds]
    return sum(not np.array_equal(moved(old, steps), new[:, 0]) for old, new in pairwise(rounds))


def distances_to_targets(log: Log, scenario: Scenario) -> Floats:
    """Return how far every UAV's reference is from its target (m) at the end of each round, shape (R, N)."""
    positions = log.positions(1)[1:]
    targets = np.array([scenario.targets_at(k) for k in range(len(positions))], float)
    distance: Floats = np.sqrt(((positions - targets) ** 2).sum(axis=2))
    return distance


def target_changes(scenario: Scenario, rounds: int) -> list[int]:
    """Return the rounds of a flight in which the targets change, round 0 first."""
    last = scenario.targets[-1].round
    again = range(last + scenario.redraw.every, rounds, scenario.redraw.every) if scenario.redraw else ()
    return [*(change.round for change in scenario.targets if change.round < rounds), *again]


def lost_messages(log: Log) -> Floats:
    """Return the messages lost in each round, by kind, shape (R, 3)."""
    return np.array([logged.lost for logged in log.rounds], float)


def states_of_cus(log: Log) -> Floats:
    """Return 1 for the state that each CU is in, 0 for the others: shape (R, M, 4)."""
    states = np.array([logged.states for logged in log.rounds])
    is_in: Floats = (states[:, :, None] == np.array(list(CuState))).astype(float)
    return is_in
