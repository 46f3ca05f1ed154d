"""Every loss pattern: the same swarms and counts as by brute force, nothing missed, and what is found can be flown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterator
from dataclasses import replace
from functools import cache
from itertools import product
from random import Random

import numpy as np
import pytest
from tests.dmpc_swarm.flight.flights import Buggy, losses_in, planner_of, record, scenario, violated
from tests.dmpc_swarm.flight.settings import hover, setting
from tests.dmpc_swarm.flight.test_judge import forgets_the_older_entry, gives_up
from tests.scenario.points import points

from swarmproof.dmpc_swarm.claims.flight import FLIGHT_CLAIMS, FlightClaim, ObservedRound
from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS
from swarmproof.dmpc_swarm.flight import exhaustive
from swarmproof.dmpc_swarm.flight.cached_planner import Remembering
from swarmproof.dmpc_swarm.flight.exhaustive import (
    Decided,
    Exhaustive,
    PatternVerdict,
    explore_flights,
    outcomes,
    parse_rounds,
)
from swarmproof.dmpc_swarm.flight.fly import Flight, Plans
from swarmproof.dmpc_swarm.flight.observing import View, observe_round
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.flight.state import Computed, FlightState
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.dmpc_swarm.protocol.deliver import deliver
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.errors import BadInput
from swarmproof.explore.search import Limits
from swarmproof.faults.grammar import parse
from swarmproof.faults.losses import Recorded
from swarmproof.faults.pattern import Losses
from swarmproof.motion.lattice import Lattice
from swarmproof.scenario.scenario import Weights


def silent(k: int, done: int, size: int) -> None:
    """Tell nobody."""


@cache
def found(what: Setting, rounds: int) -> Exhaustive:
    """Return what all patterns of a setting lead to, explored once for all tests."""
    return explore_flights(what, rounds, silent)


#: Two UAVs that swap places, with two CUs or one, or with two that ignore losses.
CROSSING, ONE_CU = setting("crossing", 2), setting("crossing", 1)
IGNORING = setting("crossing", 2, semantics="ignore-loss")
#: Two UAVs that get new targets in round 1, which their CU hears of or does not.
_A, _B, _C = points((-0.6, 0.0, 1.0), (0.6, 0.05, 1.0), (0.0, 1.0, 1.0))
TURNING = setting(scenario([_A, _B], {0: [_A, _B], 1: [_C, _A]}), 1)


def metres(distance: float | None) -> float:
    """Return a distance that must be there."""
    assert distance is not None
    return distance


def key(state: FlightState) -> Hashable:
    """Return all that a state is: protocol, the numbers of all trajectories, and what the CUs know."""
    plans = sorted((name, plan.start, plan.state.tobytes(), plan.jerks.tobytes()) for name, plan in state.plans.items())
    return state.swarm, tuple(plans), state.knowledge


# Brute force


def patterns(flight: Flight, computed: Computed) -> Iterator[Losses]:
    """Yield every loss pattern of a round, one by one: of every message on the air, and every receiver, what arrives.

    A receiver that transmits in a slot hears nothing in it that could be lost, but for `slot_conflict=cu-wins`.
    """
    slots, rules = computed.air.slots, flight.semantics
    uavs, cus = len(computed.air.uav_messages), len(slots)
    # what there is to choose: (array, row, column) and which arrays can be marked there, by value
    choices: list[tuple[tuple[int, int, int], int]] = [((0, w, i), 2) for w in range(cus) for i in range(uavs)]
    for slot, (message, reply) in enumerate(slots):
        if message is None and reply is None:
            continue
        conflict = message is not None and reply is not None
        if conflict and rules.slot_conflict == "both-lost":
            continue
        values = 3 if conflict and rules.slot_conflict == "either" else 2
        choices += [((1, w, slot), values) for w in range(cus) if w != slot or message is None]
        choices += [((2, i, slot), values) for i in range(uavs) if reply is None or reply.uav != i]
        if conflict and reply is not None and rules.slot_conflict == "cu-wins":
            choices.append(((2, reply.uav, slot), 2))
    shapes = [(cus, uavs), (cus, cus), (uavs, cus), (cus, cus), (uavs, cus)]
    for chosen in product(*(range(count) for _, count in choices)):
        arrays = [np.zeros(shape, bool) for shape in shapes]
        for ((array, row, column), _), value in zip(choices, chosen, strict=True):
            if value:
                # 0 heard, 1 lost, 2 the reply decoded
                arrays[array if value == 1 else array + 2][row, column] = True
        yield Losses(*arrays)


def by_brute_force(flight: Flight, state: FlightState) -> tuple[Counter[Hashable], dict[Hashable, int]]:
    """Return, for each state of the next round, how many patterns lead to it, and the fewest messages lost."""
    computed = flight.compute(state)
    counts: Counter[Hashable] = Counter()
    fewest: dict[Hashable, int] = {}
    for pattern in patterns(flight, computed):
        at_cus, at_uavs = deliver(computed.air, pattern, flight.semantics)
        after = key(flight.receive(state, computed, at_cus, at_uavs).after)
        counts[after] += 1
        lost = sum(got.lost for got in (*at_cus, *at_uavs))
        fewest[after] = min(lost, fewest.get(after, lost))
    return counts, fewest


def by_outcomes(flight: Flight, state: FlightState) -> tuple[Counter[Hashable], dict[Hashable, int]]:
    """Return the same by the engine."""
    computed = flight.compute(state)
    counts: Counter[Hashable] = Counter()
    fewest: dict[Hashable, int] = {}
    for count, at_cus, at_uavs in outcomes(flight, state, computed):
        after = key(flight.receive(state, computed, at_cus, at_uavs).after)
        counts[after] += count
        lost = sum(got.lost for got in (*at_cus, *at_uavs))
        fewest[after] = min(lost, fewest.get(after, lost))
    return counts, fewest


def reading(*changes: str) -> Setting:
    """Return the crossing under what is printed, with changes."""
    rules = Semantics.parse("printed", ["initial=known", "event_trigger=round-robin", *changes])
    return replace(CROSSING, semantics=rules)


def with_reply(what: Setting, conflict: bool) -> Iterator[tuple[Flight, FlightState]]:
    """Yield states in which a UAV replies, and the CU whose slot that is transmits, too, or does not."""
    flight = what.flight(Remembering(planner_of(what)))
    for seed in range(20):
        for round_ in flight.rounds(flight.initial(), parse("iid:0.3", 2, 2, seed), 12):
            slots = round_.computed.air.slots
            if any(slot.reply is not None and slot.conflict == conflict for slot in slots):
                yield flight, round_.before


def own_reply_matters(flight: Flight, state: FlightState) -> bool:
    """Say whether some CU that gave its slot away knows something else if it loses the reply in that very slot."""
    computed = flight.compute(state)
    all_ = [at_cus for _, at_cus, _ in outcomes(flight, state, computed)]
    asking = [w for w, slot in enumerate(computed.air.slots) if slot.cu_message is None and slot.reply is not None]
    return any({w in at_cus[w].lost_slots for at_cus in all_} == {True, False} for w in asking)


@pytest.mark.parametrize("what", [CROSSING, IGNORING], ids=["guarded", "ignore-loss"])
def test_the_first_round_is_that_of_brute_force(what: Setting) -> None:
    """All 1,024 loss patterns of a round at 2 x 2 lead to the states that the engine finds, as often as it says."""
    flight = what.flight()
    counts, fewest = by_brute_force(flight, flight.initial())
    assert counts.total() == 2**10
    assert (counts, fewest) == by_outcomes(flight, flight.initial())
    assert found(what, 1).swarms == [1, len(counts)]
    assert found(what, 1).patterns == [2**10]


@pytest.mark.parametrize(
    "what",
    # three receivers hear the CU, the reply or nothing; the UAV that replies may hear the CU; nobody hears anything
    [reading(), reading("slot_conflict=cu-wins"), reading("slot_conflict=both-lost")],
    ids=["either", "cu-wins", "both-lost"],
)
def test_rounds_with_conflicts_are_those_of_brute_force(what: Setting) -> None:
    """The same where a CU and a UAV transmit in one slot, whatever can then be heard."""
    flight, state = next(with_reply(what, conflict=True))
    assert by_brute_force(flight, state) == by_outcomes(flight, state)


def test_rounds_with_replies_are_those_of_brute_force() -> None:
    """The same where a UAV replies and the CU can lose that reply in its own slot, which makes a difference."""
    flight, state = next(found for found in with_reply(CROSSING, conflict=False) if own_reply_matters(*found))
    assert by_brute_force(flight, state) == by_outcomes(flight, state)


@pytest.mark.parametrize("what", [ONE_CU, TURNING], ids=["crossing", "turning"])
def test_every_pattern_of_three_rounds_one_by_one(what: Setting) -> None:
    """With one CU, all 4,096 patterns of three rounds, flown one by one: the same swarms, counts and separations."""
    flight = what.flight(Remembering(planner_of(what)))
    level: list[FlightState] = [flight.initial()]
    whole = found(what, 3)
    assert whole.patterns == [16, 16**2, 16**3]
    for swarms in whole.swarms[1:]:
        following = []
        for state in level:
            computed = flight.compute(state)
            for pattern in patterns(flight, computed):
                received = deliver(computed.air, pattern, flight.semantics)
                following.append(flight.receive(state, computed, *received).after)
        assert len(following) == 16 * len(level)
        level = following
        assert len({key(state) for state in level}) == swarms
    # everything arrives, the CU or the UAVs hear nothing, or neither
    extremes = list(patterns(flight, flight.compute(flight.initial())))[::5]
    flown = [record(what, Recorded(ways, 2, 1), 3).flown for ways in product(extremes, repeat=3)]
    assert min(one.sampled for one in flown) == whole.sampled
    assert min(metres(one.tracked) for one in flown) == whole.tracked
    assert min(one.continuous_lower for one in flown) >= whole.continuous_lower


def test_random_patterns_reach_nothing_new() -> None:
    """Random patterns of two rounds at 2 x 2, flown one by one, reach states that are known, and come no closer."""
    random, flight = Random(1), IGNORING.flight(Remembering(planner_of(IGNORING)))
    start = flight.initial()
    level = [start]
    for _ in range(2):
        following: dict[Hashable, FlightState] = {}
        for state in level:
            computed = flight.compute(state)
            for _, at_cus, at_uavs in outcomes(flight, state, computed):
                after = flight.receive(state, computed, at_cus, at_uavs).after
                following.setdefault(key(after), after)
        level = list(following.values())
    known = {key(state) for state in level}
    whole = found(IGNORING, 2)
    assert len(known) == whole.swarms[2]
    one_round = list(patterns(flight, flight.compute(start)))
    reached = set()
    for _ in range(40):
        recording = record(IGNORING, Recorded(random.choices(one_round, k=2), 2, 2), 2)
        reached.add(key(recording.rounds[-1].after))
        assert metres(recording.flown.tracked) >= metres(whole.tracked)
        assert recording.flown.sampled >= metres(whole.sampled)
        assert recording.flown.continuous_lower >= whole.continuous_lower
        assert violated(recording.flown.claims) <= violated(whole.claims)
    assert reached <= known
    assert len(reached) > 10


# What is found


def test_patterns_are_counted() -> None:
    """In two rounds in which all transmit, there are 1,024² patterns, and the swarms after them are far fewer."""
    whole = found(CROSSING, 2)
    assert whole.patterns == [2**10, 2**20]
    assert whole.swarms == [1, 16, 441]
    # how often the next states of the states before are reached
    assert whole.transitions == 16 + sum(
        len(list(outcomes(flight, state, flight.compute(state)))) for flight, state in _second_level()
    )
    assert whole.qps.solved <= whole.asked
    assert whole.stopped is None


def _second_level() -> Iterator[tuple[Flight, FlightState]]:
    flight = CROSSING.flight()
    state = flight.initial()
    computed = flight.compute(state)
    for _, at_cus, at_uavs in outcomes(flight, state, computed):
        yield flight, flight.receive(state, computed, at_cus, at_uavs).after


def test_guarded_swarms_keep_all_claims_for_these_rounds() -> None:
    """Guarded, every claim that can be asked holds for these rounds; more than that is not said."""
    whole = found(CROSSING, 2)
    asked = [claim.id for claim in CLAIMS if claim.is_safety]
    asked += [claim.id for claim in FLIGHT_CLAIMS if claim.id not in ("arrives", "eq-2-actual")]
    assert [one.claim.id for one in whole.claims] == asked
    assert _about_something(whole, "lemma-3") == {PatternVerdict.HOLDS}
    assert all((one.rounds, one.cause) == (None, ()) for one in whole.claims)
    assert all(bool(one.why) == (one.instances == 0) for one in whole.claims)
    assert not whole.violated
    assert not whole.undecided


def _about_something(whole: Exhaustive, *about_nothing: str) -> set[PatternVerdict]:
    """Return the verdicts of all claims but those about nothing, which must be these."""
    none = {one.claim.id for one in whole.claims if one.verdict is PatternVerdict.NOT_APPLICABLE}
    assert none == set(about_nothing)
    return {one.verdict for one in whole.claims if one.claim.id not in none}


def decided(whole: Exhaustive, claim: str) -> Decided:
    """Return what was decided of a claim."""
    (one,) = (one for one in whole.claims if one.claim.id == claim)
    return one


def test_ignoring_losses_violates_separation() -> None:
    """Who ignores losses plans into a stale trajectory: lost message, tracker, plan and place of it are told."""
    whole = found(IGNORING, 2)
    assert violated(whole.claims) >= {"lemma-1", "lemma-2", "plans-from-truth", "tracked-separation", "lemma-3"}
    assert whole.violated
    one = decided(whole, "tracked-separation")
    assert (one.verdict, one.rounds, one.lost) == (PatternVerdict.VIOLATED, 2, 2)
    assert [line.split(":")[0].split(" in ")[0] for line in one.chain] == [
        "Loss",
        "Trackers",
        "Trackers",
        "Stale assumption",
        "CU 0 never heard of it",
        "Stale assumption",
        "Plan",
        "Closest approach",
    ]


@pytest.mark.parametrize("claim", ["lemma-1", "lemma-2", "tracked-separation", "lemma-3"])
def test_a_cause_can_be_flown(claim: str) -> None:
    """The rounds that are said to break a claim follow each other, and flown anew, with the same losses, they do."""
    one = decided(found(IGNORING, 2), claim)
    assert one.rounds == len(one.cause)
    assert one.cause[0].before.k == 0
    for before, after in zip(one.cause, one.cause[1:], strict=False):
        assert before.after is after.before
    assert one.lost == sum(got.lost for round_ in one.cause for got in (*round_.at_cus, *round_.at_uavs)) > 0
    flown = record(IGNORING, losses_in(one.cause), len(one.cause))
    assert key(flown.rounds[-1].after) == key(one.cause[-1].after)
    (judged,) = (judged for judged in flown.flown.claims if judged.claim.id == claim)
    assert (judged.rounds, judged.lost, judged.why) == (one.rounds, one.lost, one.why)
    assert judged.chain == one.chain


def test_causes_lose_as_little_as_possible() -> None:
    """No pattern of two rounds with one lost message violates what takes two, and some with one what takes one."""
    flight = IGNORING.flight()
    one_round = list(patterns(flight, flight.compute(flight.initial())))
    nothing = one_round[0]
    single = [pattern for pattern in one_round if pattern.count == 1]
    assert (nothing.count, len(single)) == (0, 10)
    seen = set()
    for ways in [*((one, nothing) for one in single), *((nothing, one) for one in single)]:
        seen |= violated(record(IGNORING, Recorded(ways, 2, 2), 2).flown.claims)
    whole = found(IGNORING, 2)
    assert seen == {one.claim.id for one in whole.claims if one.lost == 1}
    assert violated(whole.claims) - seen == {"tracked-separation"}


def _signature(seen: ObservedRound) -> tuple[object, ...]:
    """Return what tells one observation from others."""
    approaches = (seen.known, seen.learned, seen.one_new, seen.none_new_after, seen.flown)
    return seen.k, *(None if one is None else one.square for one in approaches)


def _fewest_losses(what: Setting, rounds: int) -> dict[tuple[object, ...], int]:
    """Return with how few losses each different observation of the last of these rounds can be made."""
    flight = what.flight(Remembering(planner_of(what)))
    start = flight.initial()
    level = {key(start): (0, start)}
    fewest: dict[tuple[object, ...], int] = {}
    for k in range(rounds):
        following: dict[Hashable, tuple[int, FlightState]] = {}
        for before, state in level.values():
            computed = flight.compute(state)
            for _, at_cus, at_uavs in outcomes(flight, state, computed):
                round_ = flight.receive(state, computed, at_cus, at_uavs)
                lost = before + sum(got.lost for got in (*at_cus, *at_uavs))
                after = key(round_.after)
                if after not in following or lost < following[after][0]:
                    following[after] = lost, round_.after
                if k == rounds - 1:
                    observed, _ = observe_round(flight.lattice, View.of(flight.lattice, state), round_)
                    signature = _signature(observed)
                    fewest[signature] = min(lost, fewest.get(signature, lost))
        level = following
    return fewest


def _never(name: str, signature: tuple[object, ...]) -> FlightClaim:
    """Return the claim that this is not observed."""

    def broken(seen: ObservedRound) -> list[Broken]:
        return [Broken((), None, "seen")] if _signature(seen) == signature else []

    return FlightClaim(name, "This is not observed.", "Section 0", "None.", in_round=broken)


def test_no_cause_has_more_losses_than_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is observed in the sixth round, the cause that is given shows it, with the fewest possible losses."""
    # before the fifth round, swarms are found on the best way first
    fewest = _fewest_losses(ONE_CU, 6)
    assert len(fewest) > 10
    assert len(set(fewest.values())) > 3
    planted = [_never(f"planted-{n}", signature) for n, signature in enumerate(fewest)]
    monkeypatch.setattr(exhaustive, "FLIGHT_CLAIMS", tuple(planted))
    whole = explore_flights(ONE_CU, 6, silent)
    for claim, (signature, lost) in zip(planted, fewest.items(), strict=True):
        one = decided(whole, claim.id)
        assert (one.rounds, one.lost) == (6, lost)
        assert lost == sum(got.lost for round_ in one.cause for got in (*round_.at_cus, *round_.at_uavs))
        last = one.cause[-1]
        units = last.before.followed(0).lattice
        assert _signature(observe_round(units, View.of(units, last.before), last)[0]) == signature


def test_tasks_are_planned_once() -> None:
    """The search's planner remembers a task by all that matters, and plans what differs in any of it anew."""
    asked: list[Task] = []
    (attempt, _) = record(CROSSING, "none", 1).rounds[0].computed.attempts
    assert attempt is not None

    def plan(plans: Plans, task: Task) -> Planned:
        asked.append(task)
        return plans.plan(task)

    remembering = Remembering(Buggy(planner_of(CROSSING), plan))
    task = attempt.task
    elsewhere = hover(task.own.lattice, (0.0, 1.0, 1.0))
    others = [
        replace(task, k=3),
        replace(task, own=elsewhere),
        replace(task, others={1: (*task.others[1], elsewhere)}),
        replace(task, others={1: (elsewhere,)}),
        replace(task, selected=frozenset({0})),
        replace(task, target=task.target + 0.5),
    ]
    for one in [task, *others]:
        first = remembering.plan(one)
        assert first.plan is not None
        assert remembering.plan(replace(one, target=one.target.copy())) is first
    assert asked == [task, *others]
    assert (remembering.asked, remembering.counts.solved) == (14, 7)


def test_a_bug_of_two_entries_needs_losses(monkeypatch: pytest.MonkeyPatch) -> None:
    """A planner that forgets the older of two entries shows in some pattern of three rounds, and not without losses."""
    bug = Buggy(planner_of(ONE_CU), forgets_the_older_entry)
    assert violated(record(ONE_CU, "none", 60, bug).flown.claims) == set()
    _plant(monkeypatch, forgets_the_older_entry)
    assert violated(explore_flights(ONE_CU, 2, silent).claims) == set()
    whole = explore_flights(ONE_CU, 3, silent)
    assert violated(whole.claims) == {"tracked-separation", "lemma-3"}
    one = decided(whole, "lemma-3")
    assert (one.rounds, one.lost) == (3, 1)
    # UAV 1 did not get its plan; CU 0 then held two entries for it
    assert one.cause[1].at_uavs[1].lost_slots == (0,)
    assert len(one.cause[2].before.swarm.cus[0].trackers[1].trajectories) == 2


def _plant(monkeypatch: pytest.MonkeyPatch, bug: Callable[[Plans, Task], Planned]) -> None:
    """Let the search plan with a bug."""

    def make(units: Lattice, weights: Weights) -> Buggy:
        return Buggy(Planner(units, weights), bug)

    monkeypatch.setattr(exhaustive, "Planner", make)


def test_a_planner_that_gives_up_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A plan that does not come out leaves Theorem 1 undecided, from the first round on, and so the search."""
    _plant(monkeypatch, gives_up)
    whole = explore_flights(ONE_CU, 2, silent)
    one = decided(whole, "theorem-1")
    assert one.verdict is PatternVerdict.UNDECIDED
    assert "feasible problems (first in round 0, CU 0 for UAV " in one.why
    assert "no time" in one.why
    assert whole.undecided
    assert not whole.violated


def test_a_dip_between_the_samples_is_found() -> None:
    """References that come closer than d_min after some rounds violate eq. (2), which says where and when."""
    a, b = points((-0.2, 0.0, 1.0), (0.2, 0.0, 1.0))
    near, wide = scenario([a, b], {0: [b, a]}), scenario([a, b], {0: [b, a]}, "d_min=0.3")
    for what, is_violated in ((near, False), (wide, True)):
        whole = found(setting(what, 1), 4)
        one = decided(whole, "eq-2")
        assert (one.verdict is PatternVerdict.VIOLATED) == is_violated
        assert whole.continuous_lower <= metres(whole.sampled)
        if is_violated:
            assert whole.continuous_lower < 0.3
            assert "less than 0.3 m" in one.why
            assert one.rounds == len(one.cause) > 0


# What ends early


def interrupting(k: int) -> Callable[[int, int, int], None]:
    """Return what presses Ctrl-C as soon as it hears of round k."""

    def tell(at: int, done: int, size: int) -> None:
        if at == k:
            raise KeyboardInterrupt

    return tell


def test_an_interrupted_search_says_what_it_found() -> None:
    """Interrupted, it keeps the violations and the figures that it has; nothing else is said to hold."""
    whole = explore_flights(IGNORING, 3, interrupting(2))
    assert whole.stopped == "interrupted"
    assert whole.patterns == [2**10, 2**20]
    assert violated(whole.claims) == violated(found(IGNORING, 2).claims)
    assert {one.verdict for one in whole.claims} == {PatternVerdict.VIOLATED, PatternVerdict.UNDECIDED}
    undecided = [one for one in whole.claims if one.verdict is PatternVerdict.UNDECIDED]
    assert all(one.why == "interrupted" + "; holds for the first 2 rounds" * bool(one.instances) for one in undecided)
    assert any(one.instances for one in undecided)
    assert whole.tracked == found(IGNORING, 2).tracked


def test_an_interruption_before_anything_is_found() -> None:
    """Interrupted at once, nothing is decided, and that is said."""
    whole = explore_flights(CROSSING, 2, interrupting(0))
    assert (whole.stopped, whole.patterns, whole.swarms) == ("interrupted", [], [1])
    assert {one.verdict for one in whole.claims} == {PatternVerdict.UNDECIDED}


def test_patterns_of_an_unknown_start() -> None:
    """With `initial=unknown` no tracker is valid at first: nothing is violated, and no separation is made up."""
    rules = Semantics.parse("guarded", ["event_trigger=round-robin"])
    whole = explore_flights(replace(CROSSING, semantics=rules), 1, silent)
    all_about_nothing = {one.claim.id for one in whole.claims}
    assert _about_something(whole, *all_about_nothing) == set()


def test_too_many_swarms_end_a_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that would not fit into memory ends, and says so."""
    monkeypatch.setattr(exhaustive, "MOST_SWARMS", 15)
    whole = explore_flights(CROSSING, 2, silent)
    assert whole.stopped == "more than 15 swarms"
    assert whole.patterns == []
    assert {one.verdict for one in whole.claims} == {PatternVerdict.UNDECIDED}


@pytest.mark.parametrize("most", [2, 16, 17, 18, 100, 457])
def test_a_limit_of_states_ends_a_search(most: int) -> None:
    """With a limit, rounds that were finished before it are decided, and how far the next one came is told."""
    whole = explore_flights(CROSSING, 2, silent, Limits(max_states=most))
    full = found(CROSSING, 2)
    assert whole.stopped == f"the limit of {most} states"
    complete = len(whole.patterns)
    assert complete == (0 if most <= 17 else 1)
    assert whole.patterns == full.patterns[:complete]
    assert whole.swarms == full.swarms[: complete + 1]
    assert {one.verdict for one in whole.claims} == {PatternVerdict.UNDECIDED}
    # of a claim of which the complete rounds had nothing, it is not said that it holds
    stopped = f"the limit of {most} states"
    held = (
        {one.claim.id for one in found(CROSSING, 1).claims if one.verdict is PatternVerdict.HOLDS}
        if complete
        else set()
    )
    for one in whole.claims:
        assert one.why == stopped + ("; holds for the first round" if one.claim.id in held else "")
    assert any(one.why != stopped for one in whole.claims) == bool(complete)
    begun = whole.begun
    assert begun is not None
    assert (begun.k, begun.swarms) == (complete, whole.swarms[-1])
    assert sum(whole.swarms) + begun.found == most
    assert begun.flown < begun.swarms
    assert 0 < begun.patterns <= full.patterns[complete]


def test_a_limit_that_is_not_reached_changes_nothing() -> None:
    """With room for one swarm more than there are, and much time, all is as without limits."""
    full = found(CROSSING, 2)
    whole = explore_flights(CROSSING, 2, silent, Limits(sum(full.swarms) + 1, 1e6))
    assert (whole.stopped, whole.begun) == (None, None)
    assert (whole.patterns, whole.swarms, whole.transitions) == (full.patterns, full.swarms, full.transitions)
    assert [one.verdict for one in whole.claims] == [one.verdict for one in full.claims]


@pytest.mark.parametrize("reached", [1, 5, 16, 17, 40])
def test_a_limit_of_seconds_ends_a_search(reached: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Once the clock is over the limit, the search ends at the next pattern flown, whatever round that is in."""
    asked = []

    def too_long(self: Limits, seconds: float) -> str | None:
        asked.append(seconds)
        return "the limit of 3 s" if len(asked) >= reached else None

    monkeypatch.setattr(Limits, "too_long", too_long)
    whole = explore_flights(CROSSING, 2, silent, Limits(max_seconds=3.0))
    assert whole.stopped == "the limit of 3 s"
    assert len(asked) == reached
    assert asked == sorted(asked)
    assert whole.transitions == reached
    assert whole.patterns == ([2**10] if reached > 16 else [])


def test_the_clock_is_compared_with_the_limit() -> None:
    """A limit is reached from its number on, in the words of `verify`."""
    limits = Limits(7, 2.5)
    assert [limits.too_many(6), limits.too_many(7)] == [None, "the limit of 7 states"]
    assert [limits.too_long(2.4), limits.too_long(2.5)] == [None, "the limit of 2.5 s"]
    assert (Limits().too_many(10**9), Limits().too_long(1e9)) == (None, None)


def test_violations_on_the_way_are_kept() -> None:
    """What is violated in a round that is not finished stays violated, with a cause that can be flown."""
    full = found(IGNORING, 2)
    kept = set()
    for most in (17, 19, 60, 110):
        whole = explore_flights(IGNORING, 2, silent, Limits(max_states=most))
        assert whole.stopped is not None
        assert len(whole.patterns) < 2
        assert violated(whole.claims) <= violated(full.claims)
        kept |= {(one.claim.id, one.rounds) for one in whole.claims if one.verdict is PatternVerdict.VIOLATED}
        for one in whole.claims:
            if one.verdict is PatternVerdict.VIOLATED:
                flown = record(IGNORING, losses_in(one.cause), len(one.cause))
                assert one.claim.id in violated(flown.flown.claims)
    assert {("lemma-1", 1), ("lemma-2", 1)} <= kept
    assert ("tracked-separation", 2) in kept


@pytest.mark.parametrize(("uavs", "cus"), [(5, 2), (2, 4)])
def test_large_swarms_are_refused(uavs: int, cus: int) -> None:
    """Swarms with too many patterns to list are refused in one sentence."""
    large = setting("circle", cus, 0, [f"uavs={uavs}"])
    with pytest.raises(BadInput, match=f"every loss pattern of {uavs} UAVs and {cus} CUs is out of reach: at most 4"):
        explore_flights(large, 1, silent)


@pytest.mark.parametrize("text", ["", "0", "-1", "21", "2.0", "two", "1e3", "9" * 5000, "²"])
def test_numbers_of_rounds_are_checked(text: str) -> None:
    """Only whole numbers from 1 to 20 are numbers of rounds."""
    with pytest.raises(BadInput, match="needs a number of rounds from 1 to 20"):
        parse_rounds(text)
    assert (parse_rounds("1"), parse_rounds("20")) == (1, 20)


def assert_all_hold(whole: Exhaustive) -> None:
    """Assert that every claim holds of which there was an instance, that of separation among them."""
    verdicts = {one.claim.id: one.verdict for one in whole.claims}
    expected = {
        one.claim.id: PatternVerdict.HOLDS if one.instances else PatternVerdict.NOT_APPLICABLE for one in whole.claims
    }
    assert verdicts == expected
    assert verdicts["tracked-separation"] is verdicts["theorem-2"] is PatternVerdict.HOLDS


# Larger ones


@pytest.mark.deep
def test_four_rounds_at_2_x_2() -> None:
    """Every pattern of four rounds of the crossing keeps all claims."""
    whole = explore_flights(CROSSING, 4, silent)
    assert whole.patterns[:3] == [2**10, 2**20, 2**30]
    # from the fourth round on, some CU may be silent
    assert 2**39 < whole.patterns[3] < 2**40
    assert_all_hold(whole)
    assert metres(whole.tracked) >= 0.25


@pytest.mark.deep
def test_four_rounds_at_2_x_2_find_the_forgotten_entry(monkeypatch: pytest.MonkeyPatch) -> None:
    """With two CUs that plan in the same rounds, the forgotten entry takes four rounds of losses to show."""
    _plant(monkeypatch, forgets_the_older_entry)
    assert violated(explore_flights(CROSSING, 3, silent).claims) == set()
    assert violated(explore_flights(CROSSING, 4, silent).claims) >= {"tracked-separation", "lemma-3"}


@pytest.mark.deep
@pytest.mark.parametrize(("uavs", "cus", "rounds"), [(3, 2, 2), (3, 1, 4), (2, 3, 2)])
def test_other_swarms(uavs: int, cus: int, rounds: int) -> None:
    """Every pattern of the first rounds of small circles keeps all claims."""
    whole = explore_flights(setting("circle", cus, 0, [f"uavs={uavs}"]), rounds, silent)
    pairs = cus * uavs + cus * (cus - 1) + uavs * cus
    assert whole.patterns[:2] == [2**pairs, 2 ** (2 * pairs)]
    assert_all_hold(whole)


@pytest.mark.deep
@pytest.mark.parametrize("trigger", [Trigger.RR, Trigger.DT])
def test_brute_force_in_the_second_round(trigger: Trigger) -> None:
    """In the second round, too, the 1,024 patterns from each state are those of the engine."""
    flight = setting("crossing", 2, trigger=trigger).flight()
    start = flight.initial()
    computed = flight.compute(start)
    for _, at_cus, at_uavs in outcomes(flight, start, computed):
        state = flight.receive(start, computed, at_cus, at_uavs).after
        assert by_brute_force(flight, state) == by_outcomes(flight, state)


def both_planned(what: Setting) -> Iterator[tuple[Flight, FlightState]]:
    """Yield states in which both CUs plan the same UAV."""
    flight = what.flight(Remembering(planner_of(what)))
    for seed in range(20):
        for round_ in flight.rounds(flight.initial(), parse("iid:0.3", 2, 2, seed), 12):
            made = [one.task.i for one in round_.computed.attempts if one is not None and one.planned.plan is not None]
            if len(made) == 2 and len(set(made)) == 1:
                yield flight, round_.before


@pytest.mark.parametrize("offer", ["lowest", "highest"])
def test_rounds_with_two_offers_are_those_of_brute_force(offer: str) -> None:
    """The same where a UAV is offered two new trajectories, whichever of them it is chosen to follow."""
    flight, state = next(both_planned(setting("crossing", 2, 0, [f"offer={offer}"], semantics="ignore-loss")))
    assert by_brute_force(flight, state) == by_outcomes(flight, state)
