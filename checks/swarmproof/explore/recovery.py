"""Decides a claim of recovery on a finished exploration: what happens once nothing is lost any more.

In the graph of loss-free rounds, *settled* is the largest set of states in which the goal is true and that no loss-free
round leaves. Recovery is violated if and only if there is a loss-free cycle along which the goal is false at some
point. If no cycle at all lies outside of *settled*, the longest loss-free way outside is the worst number of rounds.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from swarmproof.explore.search import Exploration

Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]
Goal = Callable[[Any], bool]


@dataclass(frozen=True)
class Recovery:
    """What was found about recovery.

    Attributes:
        worst_rounds: where it holds, the most loss-free rounds until the goal is true for good; None if there is no
            bound, since it may be true as long as the remaining choices like, become false once more, and then settle.
        lasso: where it does not, indices of states: a shortest way from the start to the loop and once around it. If
            some failures are inevitable, it is a shortest one of these.
        loop_start: the position in `lasso` where the loop begins.
        inevitable: how many reachable states cannot recover whatever is chosen.
    """

    worst_rounds: int | None
    lasso: tuple[int, ...] = ()
    loop_start: int = 0
    inevitable: int = 0

    @property
    def holds(self) -> bool:
        """Whether the system always recovers."""
        return not self.lasso


@dataclass(frozen=True)
class LossFree:
    """The graph of loss-free rounds: for each state, its successors are `targets[starts[n]:starts[n + 1]]`."""

    starts: Ints
    targets: Ints

    def of(self, n: int) -> list[int]:
        """Return the successors of state `n`."""
        successors: list[int] = self.targets[self.starts[n] : self.starts[n + 1]].tolist()
        return successors

    def reversed(self) -> LossFree:
        """Return the graph with every edge turned around."""
        size = len(self.starts) - 1
        sources = np.repeat(np.arange(size), np.diff(self.starts))
        return _graph(size, self.targets, sources)


def _graph(size: int, sources: Ints, targets: Ints) -> LossFree:
    order = np.argsort(sources, kind="stable")
    starts = np.zeros(size + 1, dtype=np.int64)
    np.cumsum(np.bincount(sources, minlength=size), out=starts[1:])
    return LossFree(starts, targets[order])


def loss_free_graph(exploration: Exploration) -> LossFree:
    """Return every loss-free round between the states of a finished exploration."""
    keys = exploration.keys
    sources: list[int] = []
    targets: list[int] = []
    chunk = exploration.rounds.chunk
    for begin in range(0, len(keys), chunk):
        for position, key in exploration.rounds.loss_free(keys[begin : begin + chunk]):
            sources.append(begin + position)
            targets.append(exploration.index[key])
    return _graph(len(keys), np.array(sources, dtype=np.int64), np.array(targets, dtype=np.int64))


def reached_in(exploration: Exploration, goal: Goal) -> Bools:
    """Return, for each state of an exploration, whether `goal` is true: asked once for each outline."""
    rounds, known = exploration.rounds, dict[Hashable, bool]()

    def asked(key: int) -> bool:
        outline = rounds.outline(key)
        answer = known.get(outline)
        if answer is None:
            answer = known[outline] = goal(rounds.unpack(key))
        return answer

    return np.array([asked(key) for key in exploration.keys], dtype=np.bool_)


def decide_recovery(exploration: Exploration, goal: Goal) -> Recovery:
    """Decide a claim of recovery.

    Args:
        exploration: one that has reached its fixpoint (ValueError otherwise).
        goal: what must become and stay true of states; it depends on their outlines only.
    """
    if exploration.stopped is not None:
        raise ValueError("recovery is decided on complete explorations only")
    forward = loss_free_graph(exploration)
    backward = forward.reversed()
    running = reached_in(exploration, goal)
    unsettled = _reached(backward, np.flatnonzero(~running))
    longest, cyclic = _longest_ways(forward, backward, unsettled)
    if not cyclic.any():
        return Recovery(int(longest.max(initial=0)))
    can_settle = _reached(backward, np.flatnonzero(~unsettled))
    inevitable = ~can_settle
    component = _components(forward, cyclic)
    on_cycle = _on_bad_cycle(forward, cyclic, component, running)
    if not on_cycle.any():
        return Recovery(None)
    if (on_cycle & inevitable).any():
        on_cycle &= inevitable  # show the failure that no choices avoid
    start, loop = _shortest_lasso(exploration, forward, component, on_cycle, running)
    path = [exploration.index[key] for key in exploration.path_to(start)]
    return Recovery(None, (*path, *loop), len(path) - 1, int(inevitable.sum()))


def _reached(graph: LossFree, begin: Ints) -> Bools:
    """Return which states can be reached in `graph` from those of `begin`, these included."""
    seen = np.zeros(len(graph.starts) - 1, dtype=np.bool_)
    seen[begin] = True
    level = begin
    while len(level):
        counts = graph.starts[level + 1] - graph.starts[level]
        offsets = np.repeat(graph.starts[level] - np.cumsum(counts) + counts, counts) + np.arange(counts.sum())
        following = np.unique(graph.targets[offsets])
        level = following[~seen[following]]
        seen[level] = True
    return seen


def _longest_ways(forward: LossFree, backward: LossFree, inside: Bools) -> tuple[Ints, Bools]:
    """Return the number of states on the longest way within `inside` from each state, and which ways never end."""
    longest = np.zeros(len(inside), dtype=np.int64)
    waiting = {int(n): sum(1 for m in forward.of(int(n)) if inside[m]) for n in np.flatnonzero(inside)}
    ready = deque(n for n, count in waiting.items() if count == 0)
    longest[list(ready)] = 1
    while ready:
        n = ready.popleft()
        del waiting[n]
        for m in backward.of(n):
            if inside[m]:
                longest[m] = max(longest[m], longest[n] + 1)
                waiting[m] -= 1
                if waiting[m] == 0:
                    ready.append(m)
    endless = np.zeros(len(inside), dtype=np.bool_)
    endless[list(waiting)] = True
    return longest, endless


def _components(graph: LossFree, inside: Bools) -> Ints:
    """Return the strongly connected component of each state within `inside` (-1 outside)."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import connected_components

    size = len(inside)
    sources = np.repeat(np.arange(size), np.diff(graph.starts))
    kept = inside[sources] & inside[graph.targets]
    matrix = csr_matrix(
        (np.ones(int(kept.sum()), dtype=np.int8), (sources[kept], graph.targets[kept])), shape=(size, size)
    )
    _, labels = connected_components(matrix, directed=True, connection="strong")
    return np.where(inside, labels, -1).astype(np.int64)


def _on_bad_cycle(graph: LossFree, inside: Bools, component: Ints, running: Bools) -> Bools:
    """Return which states lie on a loss-free cycle along which the goal is false at some point."""
    sizes = np.bincount(component[inside], minlength=int(component.max()) + 1)
    stuck = np.zeros(len(sizes), dtype=np.bool_)
    stuck[component[inside & ~running]] = True
    on_cycle = inside & (sizes[component] > 1) & stuck[component]
    for n in np.flatnonzero(inside & ~running & (sizes[component] == 1)):
        on_cycle[n] = int(n) in graph.of(int(n))
    return on_cycle


def _shortest_lasso(
    exploration: Exploration, graph: LossFree, component: Ints, on_cycle: Bools, running: Bools
) -> tuple[int, list[int]]:
    """Return a state of least depth (then fewest losses) on a bad cycle, and the way around it (its end included)."""
    candidates = np.flatnonzero(on_cycle)
    start = min((int(n) for n in candidates), key=lambda n: (exploration.depth_of(n), exploration.losses[n], n))

    def way(begin: int, goal: Bools) -> list[int]:
        """Return a shortest way of one round or more from `begin` to `goal` within the component."""
        came_from: dict[int, int] = {}
        level = deque([begin])
        while level:
            n = level.popleft()
            for m in graph.of(n):
                if component[m] != component[begin] or m in came_from:
                    continue
                came_from[m] = n
                if goal[m]:
                    steps = [m]
                    while came_from[steps[-1]] != begin:
                        steps.append(came_from[steps[-1]])
                    return steps[::-1]
                level.append(m)
        raise AssertionError("a strongly connected component has a way between any two of its members")

    at_start = np.zeros(len(running), dtype=np.bool_)
    at_start[start] = True
    if not running[start]:
        return start, way(start, at_start)
    out = way(start, ~running)
    return start, [*out, *way(out[-1], at_start)]
