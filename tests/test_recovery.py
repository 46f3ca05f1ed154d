"""The recovery claim: on graphs made by hand, and against networkx on the loss-free rounds of real explorations."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import networkx as nx  # type: ignore[import-untyped]
import numpy as np
import pytest
from tests.bruteforce import packed, sample, successors

from swarmproof.explore import recovery as recovery_module
from swarmproof.explore.recovery import LossFree, Recovery, all_running, decide_recovery, loss_free_graph
from swarmproof.explore.rounds import Rounds
from swarmproof.explore.search import Exploration, Limits, explore
from swarmproof.semantics.switches import Semantics

Graph = dict[int, list[int]]


def arrays(graph: Graph) -> LossFree:
    """Return a graph, given by the successors of 0 ... n-1, in the form of the engine."""
    starts = np.cumsum([0] + [len(graph[n]) for n in sorted(graph)]).astype(np.int64)
    return LossFree(starts, np.array([m for n in sorted(graph) for m in graph[n]], dtype=np.int64))


def decide(graph: Graph, running: set[int], monkeypatch: pytest.MonkeyPatch) -> Recovery:
    """Decide recovery on a graph made by hand, in which node n has depth n and was reached through 0 ... n-1."""
    nodes = sorted(graph)
    exploration: Any = SimpleNamespace(
        stopped=None,
        rounds=None,
        keys=nodes,
        index={n: n for n in nodes},
        losses=[0] * len(nodes),
        depth_of=lambda n: n,
        path_to=lambda n: list(range(n + 1)),
    )
    monkeypatch.setattr(recovery_module, "loss_free_graph", lambda _: arrays(graph))
    monkeypatch.setattr(recovery_module, "all_running", lambda *_: np.array([n in running for n in nodes]))
    return decide_recovery(exploration)


def is_lasso(graph: Graph, found: Recovery) -> bool:
    """Say whether the loop of a lasso follows the graph and returns to where it began."""
    loop = found.lasso[found.loop_start :]
    return len(loop) > 1 and loop[0] == loop[-1] and all(m in graph[n] for n, m in pairwise(loop))


def test_running_for_good_takes_no_round(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where all CUs always run, recovery holds within 0 rounds."""
    assert decide({0: [0]}, {0}, monkeypatch) == Recovery(0)


def test_the_longest_way_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """The worst number of rounds is that of the longest way to running for good, whatever shorter ways there are."""
    graph = {0: [1, 4], 1: [2], 2: [3, 4], 3: [4], 4: [4]}
    assert decide(graph, {4}, monkeypatch) == Recovery(4)


def test_running_for_a_while_is_not_running_for_good(monkeypatch: pytest.MonkeyPatch) -> None:
    """A swarm in which all run, but from which some round leads out of running, has not recovered yet."""
    graph = {0: [1], 1: [2, 3], 2: [3], 3: [3]}
    assert decide(graph, {1, 3}, monkeypatch) == Recovery(3)


def test_a_loop_without_running_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    """A loop in which not all run violates the claim; it is avoidable if every swarm can leave it."""
    graph = {0: [1], 1: [2], 2: [1, 3], 3: [3]}
    found = decide(graph, {3}, monkeypatch)
    assert not found.holds
    assert (found.inevitable, found.loop_start) == (0, 1)
    assert found.lasso == (0, 1, 2, 1)
    assert is_lasso(graph, found)


def test_a_loop_that_runs_at_times_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    """A loop that goes through a swarm in which all run, and leaves it again, violates the claim."""
    graph = {0: [1], 1: [2], 2: [1]}
    found = decide(graph, {1}, monkeypatch)
    assert not found.holds
    assert found.inevitable == 3
    assert is_lasso(graph, found)
    assert 2 in found.lasso[found.loop_start :]


def test_a_swarm_that_waits_for_ever_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    """A single swarm that leads to itself, with a CU that does not run, violates the claim."""
    found = decide({0: [1, 2], 1: [1], 2: [2]}, {2}, monkeypatch)
    assert (found.lasso, found.loop_start, found.inevitable) == ((0, 1, 1), 1, 1)


def test_an_inevitable_failure_is_shown_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """If some failures cannot be avoided, a shortest of these is shown, and they are counted."""
    graph = {0: [0, 1, 4], 1: [2], 2: [3], 3: [2], 4: [4]}
    found = decide(graph, {4}, monkeypatch)
    assert found.inevitable == 3
    assert (found.lasso, found.loop_start) == ((0, 1, 2, 3, 2), 2)


def test_of_several_loops_the_nearest_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """The lasso starts its loop at the bad swarm of least depth."""
    graph = {0: [1], 1: [2], 2: [2, 3], 3: [3, 4], 4: [4]}
    found = decide(graph, {4}, monkeypatch)
    assert (found.lasso, found.loop_start) == ((0, 1, 2, 2), 2)


def test_running_as_long_as_one_likes_before_leaving(monkeypatch: pytest.MonkeyPatch) -> None:
    """A loop in which all run, with a way out that ends in running for good, is no run that fails to recover.

    No number bounds the rounds, though; so neither a crash nor a made-up lasso may come of it.
    """
    graph = {0: [0, 1], 1: [2], 2: [2]}
    found = decide(graph, {0, 2}, monkeypatch)
    assert found.holds or any(n == 1 for n in found.lasso[found.loop_start :])


def test_an_incomplete_exploration_is_refused() -> None:
    """Recovery is not decided on a part of the reachable swarms."""
    exploration = explore(Rounds(2, 2, Semantics.parse("guarded")), limits=Limits(max_states=100))
    with pytest.raises(ValueError, match="complete"):
        decide_recovery(exploration)


# --- against networkx ----------------------------------------------------------------------------------------------


def as_networkx(exploration: Exploration) -> nx.DiGraph:
    """Return the loss-free rounds of an exploration, each node with whether all CUs run."""
    graph = loss_free_graph(exploration)
    running = all_running(exploration.rounds, exploration.keys)
    result = nx.DiGraph()
    for n in range(len(exploration.keys)):
        result.add_node(n, running=bool(running[n]))
        result.add_edges_from((n, m) for m in graph.of(n))
    return result


def unsettled(graph: nx.DiGraph) -> set[int]:
    """Return the nodes from which some way leads to a node in which not all run."""
    bad = [n for n, runs in graph.nodes(data="running") if not runs]
    reached = set(bad)
    for level in nx.bfs_layers(graph.reverse(copy=False), bad):
        reached |= set(level)
    return reached


@pytest.mark.parametrize("name", ["prose", "guarded", "ignore-loss"])
def test_worst_rounds_are_the_longest_path_of_networkx(name: str) -> None:
    """Where recovery holds, what is outside of running for good is acyclic, and its longest path is the bound."""
    exploration = explore(Rounds(2, 2, Semantics.parse(name)))
    found = decide_recovery(exploration)
    graph = as_networkx(exploration)
    outside = graph.subgraph(unsettled(graph))
    assert nx.is_directed_acyclic_graph(outside)
    expected = nx.dag_longest_path_length(outside) + 1 if outside else 0
    assert found == Recovery(expected)


def test_bad_loops_are_those_of_networkx() -> None:
    """Where recovery fails, the loop starts at the least depth of a swarm on a bad cycle, and is such a cycle."""
    exploration = explore(Rounds(2, 2, Semantics.parse("printed")))
    found = decide_recovery(exploration)
    graph = as_networkx(exploration)
    bad: set[int] = set()
    for component in nx.strongly_connected_components(graph):
        loops = len(component) > 1 or graph.has_edge(*list(component) * 2)
        if loops and not all(graph.nodes[n]["running"] for n in component):
            bad |= component
    settled = set(graph) - unsettled(graph)
    can_settle = set(settled)
    for level in nx.bfs_layers(graph.reverse(copy=False), list(settled)):
        can_settle |= set(level)
    assert not found.holds
    assert found.inevitable == len(set(graph) - can_settle) == 0
    start = found.lasso[found.loop_start]
    assert start in bad
    ranks = {n: (exploration.depth_of(n), exploration.losses[n]) for n in bad}
    assert ranks[start] == min(ranks.values())
    loop = found.lasso[found.loop_start :]
    assert loop[0] == loop[-1]
    assert all(graph.has_edge(n, m) for n, m in pairwise(loop))
    assert not all(graph.nodes[n]["running"] for n in loop)
    assert [exploration.keys[n] for n in found.lasso[: found.loop_start + 1]] == exploration.path_to(start)


def test_loss_free_rounds_are_those_of_the_model() -> None:
    """The graph has exactly the rounds that the readable model takes without losing a message."""
    semantics = Semantics.parse("prose")
    rounds = Rounds(2, 2, semantics)
    exploration = explore(rounds)
    graph = loss_free_graph(exploration)
    for key in sample(exploration.keys, 30, seed=19):
        after = packed(rounds, successors(rounds.unpack(key), semantics))
        expected = {exploration.index[k] for k, lost in after.items() if lost == 0}
        assert set(graph.of(exploration.index[key])) == expected


def test_a_graph_is_turned_around() -> None:
    """Reversing turns every edge around, and twice changes nothing."""
    graph: Graph = {0: [1, 2], 1: [2], 2: [0], 3: [3]}
    backward = arrays(graph).reversed()
    assert [backward.of(n) for n in range(4)] == [[2], [0], [0, 1], [3]]
    assert [backward.reversed().of(n) for n in range(4)] == [graph[n] for n in range(4)]
