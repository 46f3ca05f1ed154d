"""The watch of a search: of every claim and witness the first state, as found by reading each state anew."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

import pytest

from swarmproof.claims.claim import Always, Claim, Reachable, Recovers
from swarmproof.dmpc_swarm.claims.observed import ObservedSwarm, ObservedUav
from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, ProtocolClaim, per_uav
from swarmproof.dmpc_swarm.claims.witnesses import WITNESSES
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.explore.search import Exploration, explore
from swarmproof.monitor.watch import Watch

Looks = Callable[[ObservedUav], object]
LOOKS: dict[str, Looks] = {
    "states": lambda uav: tuple(state for state, _, _ in uav.at_cus),
    "plans": lambda uav: tuple(may_plan for _, _, may_plan in uav.at_cus),
    "entries": lambda uav: tuple((len(tracker.entries), tracker.deprecated) for _, tracker, _ in uav.at_cus),
    "both": lambda uav: tuple((state, len(tracker.entries), tracker.deprecated) for state, tracker, _ in uav.at_cus),
}


def a_claim(name: str, question: Always[Any] | Reachable[Any] | Recovers[Any]) -> ProtocolClaim:
    """Return a claim made up for a test."""
    return Claim(name, name, "nowhere", "none", question)


def shows(look: Looks, value: object) -> Callable[[ObservedUav], list[Broken]]:
    """Return a predicate that is broken for a UAV of which `look` shows this."""
    return lambda uav: [Broken((), None, "")] if look(uav) == value else []


@cache
def explored() -> tuple[Exploration, list[ObservedSwarm]]:
    """Return an exploration to its fixpoint, and what can be seen of each of its states."""
    exploration = explore(Rounds(2, 2, Semantics.parse("guarded")))
    return exploration, [observe(exploration.rounds.unpack(key)) for key in exploration.keys]


def made_up(swarms: Iterable[ObservedSwarm]) -> list[ProtocolClaim]:
    """Return claims of every kind, each about one thing that some state shows: many are broken late, in few states."""
    found: dict[tuple[str, object], None] = {}
    wholes: dict[object, None] = {}
    for swarm in swarms:
        for name, look in LOOKS.items():
            found |= {(name, look(swarm.of_uav(i))): None for i in range(len(swarm.followed))}
        wholes[tuple(cu.state for cu in swarm.cus), swarm.answering] = None
    claims = [a_claim(f"uav {name} {value}", per_uav(shows(LOOKS[name], value))) for name, value in found]
    for value in wholes:

        def seen(swarm: ObservedSwarm, value: object = value) -> bool:
            return (tuple(cu.state for cu in swarm.cus), swarm.answering) == value

        def broken(swarm: ObservedSwarm, seen: Callable[[ObservedSwarm], bool] = seen) -> list[Broken]:
            return [Broken((), None, "")] if seen(swarm) else []

        claims.append(a_claim(f"whole {value}", Always(broken)))
        claims.append(a_claim(f"goal {value}", Reachable(seen)))
    # a recovery claim has a goal, too, which is no state to be found; and there are claims that nothing breaks
    claims.append(a_claim("recovery", Recovers(lambda _: True, "", "")))
    claims.append(a_claim("kept per UAV", per_uav(lambda _: [])))
    claims.append(a_claim("kept", Always(lambda _: [])))
    claims.append(a_claim("never", Reachable(lambda _: False)))
    return claims


def firsts(
    exploration: Exploration, swarms: list[ObservedSwarm], claims: Iterable[ProtocolClaim], end: int
) -> dict[str, int]:
    """Return, by id, the first state in which a claim is broken or reached, or a witness seen, among the first `end`.

    It is of least depth, then of fewest losses, then of least index; every state is read, nothing is remembered.
    """
    told: dict[str, Callable[[ObservedSwarm], object]] = {witness.id: witness.seen_in for witness in WITNESSES}
    for claim in claims:
        if claim.is_safety:
            told[claim.id] = claim.broken_in
        elif isinstance(claim.question, Reachable):
            told[claim.id] = claim.question.goal
    ranks = sorted(range(end), key=lambda n: (exploration.depth_of(n), exploration.losses[n], n))
    return {
        name: index
        for name, seen in told.items()
        if (index := next((n for n in ranks if seen(swarms[n])), None)) is not None
    }


@pytest.mark.parametrize("real", [False, True], ids=["made-up claims", "the claims"])
def test_the_first_states_are_those_of_reading_everything(real: bool) -> None:
    """After each level, claims and witnesses have the states that they have without any memory of situations.

    The made-up claims ask for what only the CUs' states, only the trackers, or both together show.
    """
    exploration, swarms = explored()
    claims = list(CLAIMS) if real else made_up(swarms[::20])
    watch = Watch(exploration.rounds, observe, claims, WITNESSES)
    ends = [*exploration.level_starts[1:], len(exploration.keys)]
    for begin, end in zip(exploration.level_starts, ends, strict=True):
        part = Exploration(exploration.rounds, exploration.keys[0])
        part.keys, part.losses = exploration.keys[:end], exploration.losses[:end]
        assert watch(part, begin) is False
    found = firsts(exploration, swarms, claims, len(swarms))
    assert watch.first == found
    if not real:
        late = [exploration.depth_of(index) for index in found.values()]
        assert len(found) > 50
        assert max(late) > 6
        assert not {"recovery", "kept per UAV", "kept", "never"} & found.keys()


def test_of_one_level_the_state_with_fewest_losses_counts() -> None:
    """Within a level a later state with fewer losses comes first; a state of an earlier level stays, at any cost."""
    exploration, _ = explored()
    begin, end = next(
        (a, b) for a, b in zip(exploration.level_starts, exploration.level_starts[1:], strict=False) if b - a > 5
    )
    part = Exploration(exploration.rounds, exploration.keys[0])
    part.keys, part.losses = exploration.keys[:end], exploration.losses[:end]
    for n in range(begin, end):
        part.losses[n] = 9
    part.losses[begin + 2] = part.losses[begin + 3] = 4
    always = a_claim("always", per_uav(lambda _: [Broken((), None, "")]))
    goal = a_claim("goal", Reachable(lambda _: True))
    watch = Watch(exploration.rounds, observe, [always, goal], WITNESSES)
    watch(part, begin)
    assert {watch.first["always"], watch.first["goal"]} == {begin + 2}
    part.losses[begin + 4] = 0
    watch(part, begin + 4)
    assert {watch.first["always"], watch.first["goal"]} == {begin + 2}


def test_what_was_found_is_not_read_again() -> None:
    """A claim that is broken, a goal that is reached: none is asked again on later levels."""
    exploration, swarms = explored()
    asked: list[str] = []

    def noted(name: str, answer: Any) -> Callable[[object], Any]:
        def predicate(_: object) -> Any:
            asked.append(name)
            return answer

        return predicate

    broken = [Broken((), None, "")]
    claims = [
        a_claim("uav", per_uav(noted("uav", broken))),
        a_claim("whole", Always(noted("whole", broken))),
        a_claim("goal", Reachable(noted("goal", True))),
        a_claim("open", Always(noted("open", []))),
    ]
    watch = Watch(exploration.rounds, observe, claims, WITNESSES)
    part = Exploration(exploration.rounds, exploration.keys[0])
    watch(part, 0)
    assert set(asked) == {"uav", "whole", "goal", "open"}
    asked.clear()
    part.keys, part.losses = exploration.keys[:50], exploration.losses[:50]
    watch(part, 1)
    assert asked == ["open"] * 49
    assert watch.first.keys() - {witness.id for witness in WITNESSES} == {"uav", "whole", "goal"}
    assert len(swarms) > 50
