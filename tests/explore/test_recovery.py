"""The recovery claim: on graphs made by hand, and against networkx on the loss-free rounds of real explorations."""

from __future__ import annotations

from itertools import pairwise, permutations
from random import Random
from types import SimpleNamespace
from typing import Any

import networkx as nx  # type: ignore[import-untyped]
import numpy as np
import pytest
from tests.dmpc_swarm.bruteforce import packed, sample, successors

from swarmproof.dmpc_swarm.claims.predicates import all_running
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.protocol.swarm import Swarm
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.explore import recovery as recovery_module
from swarmproof.explore.recovery import LossFree, Recovery, decide_recovery, loss_free_graph, reached_in
from swarmproof.explore.search import Exploration, Limits, explore

Graph = dict[int, list[int]]


def runs(swarm: Swarm) -> bool:
    """Say whether all CUs run: the goal of the claim."""
    return all_running(observe(swarm))


def arrays(graph: Graph) -> LossFree:
    """Return a graph, given by the successors of 0 ... n-1, in the form of the engine."""
    starts = np.cumsum([0] + [len(graph[n]) for n in sorted(graph)]).astype(np.int64)
    return LossFree(starts, np.array([m for n in sorted(graph) for m in graph[n]], dtype=np.int64))


def decide(
    graph: Graph,
    running: set[int],
    monkeypatch: pytest.MonkeyPatch,
    ranks: dict[int, tuple[int, int]] | None = None,
) -> Recovery:
    """Decide recovery on a graph made by hand, in which node n was reached through 0 ... n-1.

    `ranks` has the depth and the losses of each node; without it, node n has depth n and lost nothing.
    """
    nodes = sorted(graph)
    rank = ranks or {n: (n, 0) for n in nodes}
    exploration: Any = SimpleNamespace(
        stopped=None,
        rounds=None,
        keys=nodes,
        index={n: n for n in nodes},
        losses=[rank[n][1] for n in nodes],
        depth_of=lambda n: rank[n][0],
        path_to=lambda n: list(range(n + 1)),
    )
    monkeypatch.setattr(recovery_module, "loss_free_graph", lambda _: arrays(graph))
    monkeypatch.setattr(recovery_module, "reached_in", lambda *_: np.array([n in running for n in nodes]))
    return decide_recovery(exploration, runs)


def is_lasso(graph: Graph, found: Recovery) -> bool:
    """Say whether the loop of a lasso follows the graph and returns to where it began."""
    loop = found.lasso[found.loop_start :]
    return len(loop) > 1 and loop[0] == loop[-1] and all(m in graph[n] for n, m in pairwise(loop))


def test_running_for_good_takes_no_round(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where all CUs always run, recovery holds within 0 rounds."""
    found = decide({0: [0]}, {0}, monkeypatch)
    assert (found.worst_rounds, found.lasso, found.loop_start, found.inevitable) == (0, (), 0, 0)


def test_the_longest_way_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """The worst number of rounds is that of the longest way to running for good, whatever shorter ways there are."""
    graph = {0: [1, 4], 1: [2], 2: [3, 4], 3: [4], 4: [4]}
    assert decide(graph, {4}, monkeypatch) == Recovery(4)


def test_of_two_ways_the_longer_one_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a short and a long way lead out of one swarm, and neither has settled before they meet, the long counts."""
    graph = {0: [1, 3], 1: [2], 2: [3], 3: [4], 4: [4]}
    assert decide(graph, {4}, monkeypatch) == Recovery(4)
    # the same with the successors the other way round, and with the short way found first from two sides
    assert decide({**graph, 0: [3, 1]}, {4}, monkeypatch) == Recovery(4)
    assert decide({0: [1, 2, 3], 1: [2, 3], 2: [3], 3: [4], 4: [4]}, {4}, monkeypatch) == Recovery(4)


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


def test_a_loop_does_not_leave_its_component(monkeypatch: pytest.MonkeyPatch) -> None:
    """A swarm that does not run, but from which nothing leads back, is no part of a loop, however near: by any numbers.

    The loop is 0, 1, 2, of which 2 does not run; 0 leads to 3, too, which does not run and settles in 4.
    """
    graph: Graph = {0: [1, 3], 1: [2], 2: [0], 3: [4], 4: [4]}
    for names in permutations(range(5)):
        renamed = {names[n]: sorted(names[m] for m in after) for n, after in graph.items()}
        found = decide(renamed, {names[n] for n in (0, 1, 4)}, monkeypatch, {names[n]: (n, 0) for n in range(5)})
        assert found.lasso[found.loop_start :] == tuple(names[n] for n in (0, 1, 2, 0))


def test_running_as_long_as_one_likes_before_leaving(monkeypatch: pytest.MonkeyPatch) -> None:
    """A loop in which all run, with a way out that ends in running for good, is no run that fails to recover.

    No number bounds the rounds, though; so neither a crash nor a made-up lasso may come of it.
    """
    graph = {0: [0, 1], 1: [2], 2: [2]}
    found = decide(graph, {0, 2}, monkeypatch)
    assert found.holds or any(n == 1 for n in found.lasso[found.loop_start :])


def random_graph(random: Random) -> tuple[Graph, set[int], dict[int, tuple[int, int]]]:
    """Return a graph, which nodes run in it, and depths and losses: with ties, and with loops of one node."""
    size = random.randint(1, 9)
    graph = {n: sorted(random.sample(range(size), random.randint(1, min(3, size)))) for n in range(size)}
    if random.random() < 0.5:  # mostly forwards: some recover
        graph = {n: [m if m > n or random.random() < 0.1 else size - 1 for m in graph[n]] for n in graph}
        graph = {n: sorted(set(after)) for n, after in graph.items()}
    running = {n for n in range(size) if random.random() < 0.5}
    for n in running:  # running for as long as one likes
        graph[n] = sorted({*graph[n], n}) if random.random() < 0.3 else graph[n]
    return graph, running, {n: (random.randint(0, 2), random.randint(0, 1)) for n in range(size)}


def naive(graph: Graph, running: set[int], ranks: dict[int, tuple[int, int]]) -> tuple[Any, ...]:
    """Return worst rounds, whether it holds, the inevitable, and start and length of the loop, by definition."""
    net = nx.DiGraph([(n, m) for n in graph for m in graph[n]])
    unsettled_ = {n for n in graph if any(nx.has_path(net, n, bad) for bad in set(graph) - running)}
    outside = net.subgraph(unsettled_)
    if nx.is_directed_acyclic_graph(outside):
        return (nx.dag_longest_path_length(outside) + 1 if unsettled_ else 0), True, 0, None, 0
    stuck = {n for n in graph if not any(nx.has_path(net, n, good) for good in set(graph) - unsettled_)}
    bad = {
        n: min(nx.shortest_path_length(net, m, n) + 1 for m in graph[n] if nx.has_path(net, m, n))
        for n in unsettled_
        if any(nx.has_path(net, m, n) for m in graph[n])
        and any(nx.has_path(net, n, m) and nx.has_path(net, m, n) for m in set(graph) - running)
    }
    if not bad:
        return None, True, 0, None, 0
    shown = {n for n in bad if n in stuck} or set(bad)
    start = min(shown, key=lambda n: (*ranks[n], n))
    if start not in running:
        return None, False, len(stuck), start, bad[start]
    around = [m for m in set(graph) - running if nx.has_path(net, start, m) and nx.has_path(net, m, start)]
    out = min(nx.shortest_path_length(net, start, m) for m in around)
    nearest = [m for m in around if nx.shortest_path_length(net, start, m) == out]
    return None, False, len(stuck), start, {out + nx.shortest_path_length(net, m, start) for m in nearest}


def test_random_graphs_are_decided_as_by_definition(monkeypatch: pytest.MonkeyPatch) -> None:
    """On graphs of every shape: the worst rounds, whether it holds, how many are stuck, and which loop is shown."""
    random, kinds = Random(8), set()
    for _ in range(400):
        graph, running, ranks = random_graph(random)
        found = decide(graph, running, monkeypatch, ranks)
        worst, holds, inevitable, start, length = naive(graph, running, ranks)
        assert (found.worst_rounds, found.holds, found.inevitable) == (worst, holds, inevitable)
        kinds.add((holds, worst is None, inevitable > 0, isinstance(length, set)))
        if holds:
            assert (found.lasso, found.loop_start) == ((), 0)
            continue
        assert found.lasso[: found.loop_start + 1] == tuple(range(found.lasso[found.loop_start] + 1))
        assert found.lasso[found.loop_start] == start
        assert is_lasso(graph, found)
        loop = found.lasso[found.loop_start :]
        assert set(loop) - running
        assert len(loop) - 1 in (length if isinstance(length, set) else {length})
    assert len(kinds) == 6


def test_an_incomplete_exploration_is_refused() -> None:
    """Recovery is not decided on a part of the reachable swarms."""
    exploration = explore(Rounds(2, 2, Semantics.parse("guarded")), limits=Limits(max_states=100))
    with pytest.raises(ValueError, match="complete"):
        decide_recovery(exploration, runs)


# --- against networkx ----------------------------------------------------------------------------------------------


def as_networkx(exploration: Exploration) -> nx.DiGraph:
    """Return the loss-free rounds of an exploration, each node with whether all CUs run."""
    graph = loss_free_graph(exploration)
    running = reached_in(exploration, runs)
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
    found = decide_recovery(exploration, runs)
    graph = as_networkx(exploration)
    outside = graph.subgraph(unsettled(graph))
    assert nx.is_directed_acyclic_graph(outside)
    expected = nx.dag_longest_path_length(outside) + 1 if outside else 0
    assert found == Recovery(expected)


def test_bad_loops_are_those_of_networkx() -> None:
    """Where recovery fails, the loop starts at the least depth of a swarm on a bad cycle, and is such a cycle."""
    exploration = explore(Rounds(2, 2, Semantics.parse("printed")))
    found = decide_recovery(exploration, runs)
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


def test_loss_free_rounds_do_not_depend_on_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Swarms are taken through their rounds some at a time, each of them once, whether or not the chunks are full."""
    exploration = explore(Rounds(2, 2, Semantics.parse("guarded")))
    whole = loss_free_graph(exploration)
    for chunk in (len(exploration.keys) // 3, len(exploration.keys) // 2 + 1, len(exploration.keys)):
        monkeypatch.setattr(Rounds, "chunk", chunk)
        graph = loss_free_graph(exploration)
        assert graph.starts.tolist() == whole.starts.tolist()
        assert all(sorted(graph.of(n)) == sorted(whole.of(n)) for n in range(len(exploration.keys)))


def test_a_graph_is_turned_around() -> None:
    """Reversing turns every edge around, and twice changes nothing."""
    graph: Graph = {0: [1, 2], 1: [2], 2: [0], 3: [3]}
    backward = arrays(graph).reversed()
    assert [backward.of(n) for n in range(4)] == [[2], [0], [0, 1], [3]]
    assert [backward.reversed().of(n) for n in range(4)] == [graph[n] for n in range(4)]
