"""Breadth-first search over all reachable states, to a fixpoint or until a limit, an interrupt or a goal stops it."""

from __future__ import annotations

import time
from array import array
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass

from swarmproof.explore.steps import PARENT_BITS, PARENT_MASK, Frontier, Steps, TooLarge

#: The most states that a search holds: indices share an int with losses.
MOST_STATES = 1 << PARENT_BITS


@dataclass(frozen=True)
class Limits:
    """When a search stops early: after so many states, or so many seconds; None is no limit."""

    max_states: int | None = None
    max_seconds: float | None = None

    def too_many(self, states: int) -> str | None:
        """Return which limit is reached with so many states; None if none is."""
        return None if self.max_states is None or states < self.max_states else f"the limit of {self.max_states} states"

    def too_long(self, seconds: float) -> str | None:
        """Return which limit is reached after so many seconds; None if none is."""
        return (
            None if self.max_seconds is None or seconds < self.max_seconds else f"the limit of {self.max_seconds:g} s"
        )


#: Until it is done, or interrupted.
NO_LIMITS = Limits()


@dataclass(frozen=True)
class Progress:
    """How far a search is."""

    states: int
    frontier: int
    depth: int
    seconds: float


class Exploration:
    """The states found so far, level by level: a state's depth is the least number of rounds before it.

    For each state, `parents` and `losses` describe a way to it that is shortest in rounds and, among these, has the
    fewest lost messages.

    Attributes:
        stopped: why the search ended before its fixpoint; None at a fixpoint.
    """

    def __init__(self, rounds: Steps, start: int) -> None:
        self.rounds = rounds
        self.keys = [start]
        self.index = {start: 0}
        self.parents = array("q", [-1])
        self.losses = array("q", [0])
        self.level_starts = [0]
        self.stopped: str | None = "not begun"
        self.seconds = 0.0

    @property
    def depth(self) -> int:
        """The depth of the deepest state found."""
        return len(self.level_starts) - 1

    def depth_of(self, index: int) -> int:
        """Return the depth of state `index`."""
        return bisect_right(self.level_starts, index) - 1

    def path_to(self, index: int) -> list[int]:
        """Return the keys along a cheapest shortest way from the start to state `index`, both included."""
        path = []
        while index >= 0:
            path.append(self.keys[index])
            index = self.parents[index]
        return path[::-1]

    def add_level(self, found: Frontier) -> None:
        """Append the states of the next level, in the order of their keys."""
        self.level_starts.append(len(self.keys))
        for key in sorted(found):
            value = found[key]
            self.index[key] = len(self.keys)
            self.keys.append(key)
            self.parents.append(value & PARENT_MASK)
            self.losses.append(value >> PARENT_BITS)


def explore(
    rounds: Steps,
    *,
    start: int | None = None,
    limits: Limits | None = None,
    on_level: Callable[[Exploration, int], bool] | None = None,
    on_progress: Callable[[Progress], None] | None = None,
) -> Exploration:
    """Return the states reachable from `start` (default: the first computation phase).

    Args:
        rounds: the successor relation.
        start: the key to start from.
        limits: when to stop early.
        on_level: called with the exploration and the index of the first state of each new level; True stops the search.
        on_progress: called after each chunk of a level.

    A search that is interrupted (KeyboardInterrupt) returns what it has found, and says so in `stopped`.
    """
    limits = limits or NO_LIMITS
    began = time.monotonic()
    exploration = Exploration(rounds, rounds.initial_key() if start is None else start)
    try:
        while exploration.stopped is not None:
            first = exploration.level_starts[-1]
            if on_level is not None and on_level(exploration, first):
                exploration.stopped = "goal reached"
                break
            found, reason = _next_level(exploration, first, limits, began, on_progress)
            if found:
                exploration.add_level(found)
            if reason is not None:
                exploration.stopped = reason
                if found and on_level is not None:
                    on_level(exploration, exploration.level_starts[-1])
                break
            if not found:
                exploration.stopped = None
    except KeyboardInterrupt:
        exploration.stopped = "interrupted"
    except TooLarge as too_large:
        exploration.stopped = f"too large for this engine: {too_large}"
    exploration.seconds = time.monotonic() - began
    return exploration


def _next_level(
    exploration: Exploration,
    first: int,
    limits: Limits,
    began: float,
    on_progress: Callable[[Progress], None] | None,
) -> tuple[Frontier, str | None]:
    """Return the new states one round after those from index `first` on, and why it stopped early, if it did."""
    rounds, keys, known = exploration.rounds, exploration.keys, exploration.index
    found: Frontier = {}
    last = len(keys)
    try:
        for begin in range(first, last, rounds.chunk):
            chunk = range(begin, min(begin + rounds.chunk, last))
            frontier = {keys[n]: exploration.losses[n] << PARENT_BITS | n for n in chunk}
            for key, value in rounds.run(frontier).items():
                if key not in known and value < found.get(key, value + 1):
                    found[key] = value
            states, seconds = last + len(found), time.monotonic() - began
            if on_progress is not None:
                on_progress(Progress(states, last - chunk.stop + len(found), exploration.depth + 1, seconds))
            if found and limits.max_states is not None and (reason := limits.too_many(states)):
                kept = sorted(found)[: max(limits.max_states - last, 0)]
                return {key: found[key] for key in kept}, reason
            if states >= MOST_STATES:
                return found, f"the engine's limit of {MOST_STATES} states"
            if reason := limits.too_long(seconds):
                return found, reason
    except KeyboardInterrupt:
        return found, "interrupted"
    return found, None
