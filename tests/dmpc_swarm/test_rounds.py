"""The merged successor relation against every loss pattern taken one by one on the readable model."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import pytest
from tests.dmpc_swarm.bruteforce import (
    merged,
    packed,
    random_walk,
    raw_successors,
    sample,
    single_switch_semantics,
    successors,
)

from swarmproof.dmpc_swarm import rounds as rounds_module
from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker
from swarmproof.dmpc_swarm.protocol.messages import Trajectory
from swarmproof.dmpc_swarm.protocol.network import Air, Reception, cu_receptions
from swarmproof.dmpc_swarm.protocol.swarm import Swarm, initial_swarm
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.symmetry import Abstraction, canonical_swarm, forget
from swarmproof.explore.search import Limits, explore

#: Semantics of the sampled comparison at two UAVs and two CUs: each value of each switch is among them.
SAMPLED = [
    Semantics.parse("printed"),
    Semantics.parse("prose", ["slot_conflict=both-lost", "request_order=any"]),
    Semantics.parse("prose", ["slot_conflict=cu-wins", "request_order=round-robin"]),
    Semantics.parse("guarded", ["initial=known"]),
    Semantics.parse("guarded", ["event_trigger=round-robin", "initial=known"]),
    Semantics.parse("printed", ["event_trigger=round-robin", "initial=known", "request_order=round-robin"]),
    Semantics.parse("ignore-loss"),
    Semantics.parse("ignore-loss", ["event_trigger=round-robin"]),
]


def some_keys(rounds: Rounds) -> list[int]:
    """Return the keys of a few thousand swarms: all within a few rounds from the start."""
    return explore(rounds, limits=Limits(max_states=3000)).keys


def differing(rounds: Rounds, swarm: Swarm) -> bool:
    """Say whether the engine and the raw brute force disagree about the round after `swarm`."""
    return merged(rounds, swarm) != packed(rounds, raw_successors(swarm, rounds.semantics))


@pytest.mark.parametrize("semantics", single_switch_semantics(), ids=Semantics.name)
def test_all_rounds_of_two_uavs_and_one_cu_equal_brute_force(semantics: Semantics) -> None:
    """From every reachable swarm, merging by effect finds the successors, and their fewest losses, of brute force."""
    rounds = Rounds(2, 1, semantics)
    for key in explore(rounds).keys:
        swarm = rounds.unpack(key)
        assert merged(rounds, swarm) == packed(rounds, raw_successors(swarm, semantics))


@pytest.mark.parametrize("semantics", SAMPLED, ids=Semantics.name)
def test_sampled_rounds_of_two_uavs_and_two_cus_equal_brute_force(semantics: Semantics) -> None:
    """From sampled reachable swarms, the engine finds exactly the successors and fewest losses of brute force."""
    rounds = Rounds(2, 2, semantics)
    for key in sample(some_keys(rounds), 6, seed=1):
        assert not differing(rounds, rounds.unpack(key))


@pytest.mark.parametrize("semantics", SAMPLED, ids=Semantics.name)
def test_rounds_along_random_runs_equal_brute_force(semantics: Semantics) -> None:
    """From swarms of random runs, whose trajectories have their own names, the engine agrees with brute force."""
    rounds = Rounds(2, 2, semantics)
    for swarm in random_walk(2, 2, semantics, rounds=40, seed=2)[4::9]:
        assert merged(rounds, swarm) == packed(rounds, successors(swarm, semantics))


@pytest.mark.parametrize("abstraction", [Abstraction.COUNTED, Abstraction.NOTHING], ids=lambda a: a.value)
def test_rounds_of_finer_abstractions_equal_brute_force(abstraction: Abstraction) -> None:
    """The engine agrees with brute force whatever it keeps of deprecated trackers."""
    for overrides in ([], ["event_trigger=round-robin"]):
        semantics = Semantics.parse("prose", ["initial=known", *overrides])
        rounds = Rounds(2, 2, semantics, abstraction)
        for swarm in random_walk(2, 2, semantics, rounds=40, seed=3)[3::9]:
            assert merged(rounds, swarm) == packed(rounds, successors(swarm, semantics))


@pytest.mark.parametrize("trigger", ["any", "round-robin"])
@pytest.mark.parametrize(("uavs", "cus"), [(1, 1), (1, 2), (1, 3), (3, 1), (3, 2), (3, 3), (1, 4)])
def test_other_numbers_of_uavs_and_cus_equal_brute_force(uavs: int, cus: int, trigger: str) -> None:
    """With other numbers of UAVs and CUs, the engine agrees with brute force along random runs."""
    semantics = Semantics.parse("prose", ["initial=known", f"event_trigger={trigger}"])
    rounds = Rounds(uavs, cus, semantics)
    swarms = random_walk(uavs, cus, semantics, rounds=14, seed=cus)
    # the swarm's successors multiply with its size: three UAVs and three CUs are looked at once
    for swarm in swarms[6::8] if uavs * cus < 9 else swarms[-1:]:
        assert merged(rounds, swarm) == packed(rounds, successors(swarm, semantics))


@pytest.mark.parametrize("semantics", SAMPLED[:5:2], ids=Semantics.name)
def test_both_brute_forces_agree(semantics: Semantics) -> None:
    """Taking equal results of one receiver once gives the swarms and fewest losses of the raw product."""
    for swarm in random_walk(2, 2, semantics, rounds=30, seed=5)[7::11]:
        assert successors(swarm, semantics) == raw_successors(swarm, semantics)


@pytest.mark.parametrize("semantics", SAMPLED, ids=Semantics.name)
def test_lossless_rounds_are_those_that_lose_nothing(semantics: Semantics) -> None:
    """With `lossless`, the engine finds exactly the swarms that brute force reaches without losing a message."""
    rounds = Rounds(2, 2, semantics)
    for key in sample(some_keys(rounds), 40, seed=7):
        swarm = rounds.unpack(key)
        expected = {after: lost for after, lost in packed(rounds, successors(swarm, semantics)).items() if lost == 0}
        assert expected
        assert merged(rounds, swarm, lossless=True) == expected


def test_many_swarms_at_once_are_taken_as_if_alone() -> None:
    """A frontier of tagged swarms leads to the union of what each swarm leads to."""
    rounds = Rounds(2, 2, Semantics.parse("prose"))
    keys = sample(some_keys(rounds), 50, seed=9)
    together = rounds.run({key | number << rounds.tag_at: 0 for number, key in enumerate(keys)})
    alone = {
        after | number << rounds.tag_at: value
        for number, key in enumerate(keys)
        for after, value in rounds.run({key: 0}).items()
    }
    assert together == alone


def test_packing_keeps_a_canonical_swarm() -> None:
    """Unpacking a packed swarm gives its canonical representative back."""
    for semantics in SAMPLED:
        rounds = Rounds(2, 2, semantics)
        for swarm in random_walk(2, 2, semantics, rounds=60, seed=11):
            canonical = canonical_swarm(swarm, semantics, Abstraction.ESSENTIAL)
            assert rounds.unpack(rounds.pack(swarm)) == canonical
            assert rounds.pack(canonical) == rounds.pack(swarm)


def comparison_fails(semantics: Semantics) -> bool:
    """Run the comparison as above on a few reachable swarms; say whether it finds a difference."""
    rounds = Rounds(2, 1, semantics)
    return any(
        merged(rounds, rounds.unpack(key)) != packed(rounds, raw_successors(rounds.unpack(key), semantics))
        for key in explore(rounds).keys
    )


def test_a_forgotten_loss_pattern_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The comparison fails if the engine leaves out the one pattern in which a CU loses everything."""

    def all_but_the_last(w: int, air: Air, semantics: Semantics) -> Iterator[Reception]:
        receptions = list(cu_receptions(w, air, semantics))
        yield from islice(receptions, len(receptions) - 1)

    assert not comparison_fails(Semantics.parse("prose"))
    monkeypatch.setattr(rounds_module, "cu_receptions", all_but_the_last)
    assert comparison_fails(Semantics.parse("prose"))


def test_a_table_for_the_wrong_control_is_noticed() -> None:
    """The comparison fails if the engine asks the model about too small a local situation."""

    class WithoutControl(Rounds):
        def _cu(self, w: int, control_number: int, views: object) -> algorithm1.ComputeUnit:
            return super()._cu(w, 0, views)  # type: ignore[arg-type]

    semantics = Semantics.parse("guarded")
    honest = Rounds(2, 2, semantics)
    broken = WithoutControl(2, 2, semantics)
    swarms = random_walk(2, 2, semantics, rounds=12, seed=13)
    assert any(merged(broken, s) != packed(broken, successors(s, semantics)) for s in swarms)
    assert not any(merged(honest, s) != packed(honest, successors(s, semantics)) for s in swarms)


def test_losses_counted_wrongly_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The comparison fails if the engine keeps some way to a swarm instead of the one with the fewest losses."""

    def dearest_first(w: int, air: Air, semantics: Semantics) -> Iterator[Reception]:
        for reception in cu_receptions(w, air, semantics):
            yield Reception(reception.inbox, (0,) * 3, reception.lost_slots, reception.decoded_replies)

    monkeypatch.setattr(rounds_module, "cu_receptions", dearest_first)
    assert comparison_fails(Semantics.parse("prose"))


def test_forgetting_too_much_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The comparison fails if, during a round, a deprecated tracker is emptied."""

    def forget_all(
        tracker: InformationTracker, w: int, followed: Trajectory, semantics: Semantics
    ) -> InformationTracker:
        kept = forget(tracker, w, followed, semantics)
        return InformationTracker((), deprecated=True) if kept.deprecated else kept

    monkeypatch.setattr(rounds_module, "forget", forget_all)
    assert comparison_fails(Semantics.parse("prose"))


def test_first_swarm_is_the_models() -> None:
    """The engine starts where the readable model starts."""
    semantics = Semantics.parse("printed", ["initial=known"])
    rounds = Rounds(3, 2, semantics)
    begin = rounds.unpack(rounds.initial_key())
    assert begin == canonical_swarm(initial_swarm(3, 2, semantics), semantics, Abstraction.ESSENTIAL)


@pytest.mark.parametrize("preset", ["guarded", "ignore-loss"])
def test_all_rounds_of_two_uavs_and_two_cus_equal_brute_force(preset: str) -> None:
    """From every reachable swarm at 2 x 2, the engine finds the successors and fewest losses of brute force."""
    check_all_rounds(Semantics.parse(preset))


@pytest.mark.deep
@pytest.mark.parametrize(
    "semantics",
    [*SAMPLED, Semantics.parse("prose"), Semantics.parse("guarded", ["event_trigger=round-robin"])],
    ids=Semantics.name,
)
def test_all_rounds_of_two_uavs_and_two_cus_equal_brute_force_under_more_semantics(semantics: Semantics) -> None:
    """From every reachable swarm at 2 x 2, the engine finds the successors and fewest losses of brute force."""
    check_all_rounds(semantics)


def check_all_rounds(semantics: Semantics) -> None:
    """Compare the engine with brute force on everything that is reachable at 2 x 2."""
    rounds = Rounds(2, 2, semantics)
    for key in explore(rounds).keys:
        swarm = rounds.unpack(key)
        assert merged(rounds, swarm) == packed(rounds, successors(swarm, semantics))
