"""The search: when it stops, what it then says, and that its depths, ways and losses are those of shortest runs."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from tests.dmpc_swarm.bruteforce import plain_search, sample, successors

from swarmproof.claims.claim import Reachable
from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.claims.observed import ObservedSwarm
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, ProtocolClaim
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.protocol.swarm import Swarm, initial_swarm
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.system import swarm as scope
from swarmproof.explore.concretise import follow
from swarmproof.explore.decide import Result, verify
from swarmproof.explore.search import Exploration, Limits, Progress, explore
from swarmproof.trace.replay import replay

GUARDED = Semantics.parse("guarded")
SCOPE = scope(2, 2, GUARDED)


def interrupt_at(states: int) -> Callable[[Progress], None]:
    """Return an `on_progress` callback that interrupts as Ctrl-C does, once so many states are found."""

    def on_progress(progress: Progress) -> None:
        if progress.states >= states:
            raise KeyboardInterrupt

    return on_progress


def says_nothing_unproved(result: Result) -> bool:
    """Say whether a search that stopped early calls no claim about all states held, and no reachable goal missing."""
    for decided in result.claims:
        about_all = not isinstance(decided.claim.question, Reachable)
        if decided.verdict is (Verdict.HOLDS if about_all else Verdict.VIOLATED):
            return False
    return True


def test_a_search_ends_at_its_fixpoint() -> None:
    """Without limits nothing stops the search, and no round leads out of what it found."""
    rounds = Rounds(2, 2, GUARDED)
    exploration = explore(rounds)
    assert exploration.stopped is None
    assert set(rounds.run(dict.fromkeys(exploration.keys, 0))) <= set(exploration.keys)


@pytest.mark.parametrize("most", [1, 10, 500])
def test_a_limit_of_states_stops_and_says_so(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The search stops after the chunk with which it has so many states, and says which limit it was."""
    monkeypatch.setattr(Rounds, "chunk", 10)
    exploration = explore(Rounds(2, 2, GUARDED), limits=Limits(max_states=most))
    assert exploration.stopped == f"the limit of {most} states"
    assert most <= len(exploration.keys) < 1394


def test_a_limit_of_time_stops_and_says_so() -> None:
    """With no time at all, the search stops in its first round, and says which limit it was."""
    exploration = explore(Rounds(2, 2, GUARDED), limits=Limits(max_seconds=0))
    assert exploration.stopped == "the limit of 0 s"


def test_a_limit_that_is_not_reached_changes_nothing() -> None:
    """Limits above what is needed leave the search complete."""
    exploration = explore(Rounds(2, 2, GUARDED), limits=Limits(max_states=10**6, max_seconds=10**6))
    assert exploration.stopped is None
    assert exploration.keys == explore(Rounds(2, 2, GUARDED)).keys


@pytest.mark.parametrize("limits", [Limits(max_states=100), Limits(max_states=1300), Limits(max_seconds=0)])
def test_an_incomplete_search_never_says_holds(limits: Limits) -> None:
    """After a limit, claims that hold are undecided, with the reason; goals already reached stay reached."""
    result = verify(SCOPE, limits=limits)
    assert not result.fixpoint
    assert says_nothing_unproved(result)
    undecided = [d for d in result.claims if d.verdict is Verdict.UNDECIDED]
    assert {"lemma-1", "recovery"} <= {d.claim.id for d in undecided}
    assert all(result.stopped is not None and result.stopped in d.why for d in undecided)


def test_a_violation_found_before_the_limit_stays_a_violation() -> None:
    """A counterexample counts however the search ends."""
    result = verify(scope(2, 2, Semantics.parse("prose")), limits=Limits(max_states=3000))
    assert not result.fixpoint
    assert says_nothing_unproved(result)
    lemma_1 = next(d for d in result.claims if d.claim.id == "lemma-1")
    assert (lemma_1.verdict, lemma_1.rounds, lemma_1.lost_messages) == (Verdict.VIOLATED, 8, 0)


def test_an_interrupt_keeps_what_was_found() -> None:
    """After Ctrl-C the states found so far are there, a violation among them is shown, nothing is called held."""
    for states, violated in ((50, False), (3000, True)):
        result = verify(
            scope(2, 2, Semantics.parse("prose")),
            on_progress=interrupt_at(states),
        )
        assert result.stopped == "interrupted"
        assert result.states >= states
        assert says_nothing_unproved(result)
        shown = [d for d in result.claims if d.verdict is Verdict.VIOLATED]
        assert bool(shown) is violated
        for decided in shown:
            assert decided.trace is not None
            replay(decided.trace)


def test_an_interrupt_within_a_level_keeps_the_states_of_its_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """What earlier chunks of an interrupted level found is kept."""
    monkeypatch.setattr(Rounds, "chunk", 10)
    seen: list[Progress] = []

    def on_progress(progress: Progress) -> None:
        seen.append(progress)
        if progress.states >= 300:
            raise KeyboardInterrupt

    exploration = explore(Rounds(2, 2, GUARDED), on_progress=on_progress)
    assert exploration.stopped == "interrupted"
    assert len(exploration.keys) == seen[-1].states
    assert exploration.depth == seen[-1].depth
    assert all(exploration.path_to(n)[0] == exploration.keys[0] for n in range(len(exploration.keys)))


def test_chunks_do_not_change_what_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Taking few states through a round together finds the same states, depths, parents' depths and losses."""
    whole = explore(Rounds(2, 2, GUARDED))
    monkeypatch.setattr(Rounds, "chunk", 7)
    parts = explore(Rounds(2, 2, GUARDED))

    def described(exploration: Exploration) -> set[object]:
        return {
            (exploration.rounds.unpack(key), exploration.depth_of(n), exploration.losses[n])
            for n, key in enumerate(exploration.keys)
        }

    assert described(whole) == described(parts)


def test_a_goal_stops_the_search() -> None:
    """An `on_level` callback that returns True ends the search at that level."""
    exploration = explore(Rounds(2, 2, GUARDED), on_level=lambda found, _: found.depth == 3)
    assert exploration.stopped == "goal reached"
    assert exploration.depth == 3


def test_a_search_can_start_anywhere() -> None:
    """From a given key, depths count from there, and only what is reachable from there is found."""
    rounds = Rounds(2, 2, GUARDED)
    whole = explore(rounds)
    start = whole.keys[700]
    part = explore(rounds, start=start)
    assert part.keys[0] == start
    assert part.stopped is None
    assert set(part.keys) <= set(whole.keys)


@pytest.mark.parametrize("name", ["guarded", "printed", "ignore-loss"])
def test_ways_depths_and_losses_agree(name: str) -> None:
    """The way to a state has as many rounds as its depth, each can be taken, and it loses the losses that it says."""
    semantics = Semantics.parse(name)
    rounds = Rounds(2, 2, semantics)
    exploration = explore(rounds)
    for key in sample(exploration.keys, 12, seed=17):
        index = exploration.index[key]
        path = exploration.path_to(index)
        assert (path[0], path[-1]) == (rounds.initial_key(), key)
        assert len(path) - 1 == exploration.depth_of(index)
        events = follow(scope(2, 2, semantics).model(), rounds, path)
        assert sum(happened.lost for happened in events) == exploration.losses[index]


def plain_levels(rounds: Rounds, depth: int) -> list[dict[int, tuple[int, Swarm]]]:
    """Search without packing and merging: by level, the keys first reached there, with fewest losses and a swarm.

    Only one swarm of each key is followed: test_abstraction.py shows that the others behave alike.
    """
    levels: list[dict[int, tuple[int, Swarm]]] = []
    begin = initial_swarm(rounds.uavs, rounds.cus, rounds.semantics)
    level, known = {begin: 0}, set[int]()
    for _ in range(depth + 1):
        new: dict[int, tuple[int, Swarm]] = {}
        for swarm, lost in level.items():
            key = rounds.pack(swarm)
            if key not in known and (key not in new or lost < new[key][0]):
                new[key] = lost, swarm
        known |= new.keys()
        levels.append(new)
        level = {}
        for lost, swarm in new.values():
            for after, more in successors(swarm, rounds.semantics).items():
                level[after] = min(lost + more, level.get(after, lost + more))
    return levels


@pytest.mark.parametrize(
    ("uavs", "cus", "preset", "overrides", "depth"),
    [
        (2, 1, "prose", (), 8),
        (2, 1, "printed", ("event_trigger=round-robin",), 8),
        (1, 2, "prose", ("initial=known",), 4),
        (1, 2, "prose", ("initial=known", "event_trigger=round-robin"), 4),
        (2, 2, "ignore-loss", (), 2),
    ],
)
def test_depths_and_losses_are_those_of_a_plain_search(
    uavs: int, cus: int, preset: str, overrides: tuple[str, ...], depth: int
) -> None:
    """Every state has the least depth, and then the fewest losses, of a search without packing and merging."""
    rounds = Rounds(uavs, cus, Semantics.parse(preset, overrides))
    exploration = explore(rounds)
    expected = [{key: lost for key, (lost, _) in level.items()} for level in plain_levels(rounds, depth)]
    found: list[dict[int, int]] = [{} for _ in range(depth + 1)]
    for index, key in enumerate(exploration.keys):
        if exploration.depth_of(index) <= depth:
            found[exploration.depth_of(index)][key] = exploration.losses[index]
    assert expected == found


@pytest.mark.deep
def test_a_shortest_violation_is_that_of_a_plain_search() -> None:
    """At two UAVs and two CUs, claims are first broken where a search without packing and merging first sees it."""
    semantics = Semantics.parse("printed", ["initial=known", "request_order=any"])
    result = verify(scope(2, 2, semantics))
    levels = plain_levels(Rounds(2, 2, semantics), depth=4)
    for claim in CLAIMS:
        if not claim.is_safety or not claim.applies_to(semantics):
            continue
        losses = [[lost for lost, swarm in level.values() if claim.broken_in(observe(swarm))] for level in levels]
        decided = next(d for d in result.claims if d.claim is claim)
        assert [bool(of_level) for of_level in losses] == [False, False, False, False, True]
        assert (decided.rounds, decided.lost_messages) == (4, min(losses[4])) == (4, 2)


@pytest.mark.parametrize(("uavs", "cus"), [(1, 1), (2, 1), (1, 2)])
def test_shortest_counterexamples_are_those_of_a_search_without_names(uavs: int, cus: int) -> None:
    """No claim is broken by a run that is shorter, or as short with fewer losses, than the one that is shown."""
    semantics = Semantics.parse("ignore-loss")
    safety = [c for c in CLAIMS if c.is_safety and c.applies_to(semantics)]

    def broken(claim: ProtocolClaim) -> Callable[[ObservedSwarm], bool]:
        return lambda swarm: bool(claim.broken_in(swarm))

    plain = plain_search(uavs, cus, semantics, {c.id: broken(c) for c in safety}, depth=2)
    result = verify(scope(uavs, cus, semantics), safety)
    shown = {d.claim.id: (d.rounds, d.lost_messages) for d in result.claims if d.verdict is Verdict.VIOLATED}
    assert shown
    assert shown == {claim: (len(run.events), run.lost) for claim, run in plain.items()}
