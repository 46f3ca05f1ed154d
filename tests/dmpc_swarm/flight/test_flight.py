"""The flight: who knows what when, how rounds and trajectories go together, that it repeats, and that it stays safe."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from fractions import Fraction

import numpy as np
import pytest
from tests.dmpc_swarm.flight.flights import (
    Buggy,
    Recording,
    losses,
    planner_of,
    record,
    recorded,
    scenario,
    violated,
)
from tests.dmpc_swarm.flight.settings import flown, setting
from tests.scenario.points import at, points

from swarmproof.dmpc_swarm.flight.fly import Plans
from swarmproof.dmpc_swarm.flight.judge import Flown
from swarmproof.dmpc_swarm.flight.run import Setting, fly
from swarmproof.dmpc_swarm.flight.state import Attempt, FlightState, Name, Round
from swarmproof.dmpc_swarm.planner.detour import Detour
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.planner import Planned
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.dmpc_swarm.protocol.event_trigger import NO_OPINION
from swarmproof.dmpc_swarm.protocol.messages import HOVERING, EmptyMessage, Metadata
from swarmproof.dmpc_swarm.semantics import PRESETS, SWITCHES, Semantics
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.errors import BadInput
from swarmproof.faults.grammar import parse
from swarmproof.faults.losses import Recorded
from swarmproof.faults.pattern import Losses, nothing_lost
from swarmproof.monitor import separation
from swarmproof.monitor.bernstein import Closest, closest
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.motion.pairs import Scales
from swarmproof.qp.solvers import Status
from swarmproof.scenario.points import Point
from swarmproof.scenario.scenario import load

#: Three UAVs, of which two swap places in round 5.
A, B, C = points((-0.8, 0.0, 1.0), (0.8, 0.3, 1.2), (0.0, 1.2, 1.0))
CHANGE = 5
SWAP = scenario([A, B, C], {0: [A, B, C], CHANGE: [B, A, C]})


def known_targets(state: FlightState, w: int) -> list[Point | None]:
    """Return the targets that CU w knows."""
    return [None if target.point is None else at(*target.point) for target in state.knowledge[w].targets]


# Targets


def test_targets_are_learned_a_round_later() -> None:
    """UAVs say their new targets in the round in which these change; CUs plan for them from the next round on."""
    for round_ in record(setting(SWAP, 2), "none", 10).rounds:
        k = round_.before.k
        expected = [A, B, C] if k <= CHANGE else [B, A, C]
        assert [known_targets(round_.before, w) for w in range(2)] == [expected, expected]
        for attempt in round_.computed.attempts:
            assert attempt is None or at(*attempt.task.target) == expected[attempt.task.i]


def test_a_jammed_cu_keeps_the_old_targets() -> None:
    """While the CUs hear nothing, they know the old targets, and learn the new ones with the first message after."""
    rounds = record(setting(SWAP, 2), f"jam:{CHANGE},4", 14).rounds
    for round_ in rounds:
        k = round_.before.k
        expected = [A, B, C] if k <= CHANGE + 4 else [B, A, C]
        assert known_targets(round_.before, 0) == known_targets(round_.before, 1) == expected


def test_each_target_is_learned_from_its_uav() -> None:
    """A CU that misses the messages of one UAV keeps that UAV's old target, and only that one's."""
    deaf = losses(3, 2, at_cus=[(0, "uav", 0)])
    model = Recorded([nothing_lost(3, 2)] * CHANGE + [deaf] * 2, 3, 2)
    rounds = record(setting(SWAP, 2), model, 10).rounds
    for k, at_0, at_1 in ((5, A, A), (6, A, B), (7, A, B), (8, B, B)):
        assert known_targets(rounds[k].before, 0) == [at_0, A if k > CHANGE else B, C]
        assert known_targets(rounds[k].before, 1) == [at_1, A if k > CHANGE else B, C]


def test_nobody_knows_the_targets_of_an_unknown_start() -> None:
    """With `initial=unknown`, CUs know no target until they hear the UAV, and plan none that they never heard."""
    rules = Semantics.parse("guarded", ["initial=unknown", "event_trigger=round-robin"])
    what = Setting(SWAP, 2, Trigger.HT, rules, 0)
    deaf = losses(3, 2, at_cus=[(0, "uav", 2), (1, "uav", 2)])
    rounds = record(what, Recorded([deaf] * 3, 3, 2), 12).rounds
    assert known_targets(rounds[0].before, 0) == [None, None, None]
    for k in (1, 2, 3):
        assert known_targets(rounds[k].before, 0) == [A, B, None]
    assert known_targets(rounds[4].before, 1) == [A, B, C]


def test_a_plan_for_the_old_target_is_none_for_the_new_one() -> None:
    """A UAV planned in the round in which its target changes, still for the old one, is not taken for deadlocked."""
    # each UAV alone in its corner, where nothing moves near it, and at its target
    there = at(0.8, -0.8, 1.0)
    corners = scenario([A, there], {0: [A, there], 4: points((-0.8, 0.5, 1.0), (0.8, -0.4, 1.0))})
    rounds = record(setting(corners, 1), "none", 9).rounds
    assert [attempt.task.i for _, _, attempt, _ in new_plans(rounds[4:])] == [0, 1, 0, 1, 0]
    for round_ in rounds[5:]:
        (slot,) = round_.computed.air.slots
        assert slot.cu_message is not None
        assert slot.cu_message.priorities is not None
        assert NO_OPINION not in slot.cu_message.priorities


# Rounds


#: Flights with losses of all kinds, most of which end well.
LOSSY = [
    ("crossing", 2, "iid:0.3", 30, 1, "guarded", None),
    ("circle", 3, "iid:0.1", 20, 0, "guarded", 6),
    ("random", 2, "burst:0.1,0.4", 20, 3, "prose", 5),
    ("crossing", 2, "iid:0.3", 30, 0, "ignore-loss", None),
]
What = tuple[str, int, str, int, int, str, int | None]
lossy = pytest.mark.parametrize("what", LOSSY, ids=lambda what: f"{what[0]}-{what[5]}")


def new_plans(rounds: Iterable[Round]) -> Iterator[tuple[Round, int, Attempt, Plan]]:
    """Yield every plan that was made, with its round, CU and attempt."""
    for round_ in rounds:
        for w, attempt in enumerate(round_.computed.attempts):
            if attempt is not None and attempt.planned.plan is not None:
                yield round_, w, attempt, attempt.planned.plan


@lossy
def test_a_plan_begins_where_the_old_trajectory_will_be(what: What) -> None:
    """A plan of round k begins at the start of round k + 1, in the state that the CU's one entry has there."""
    seen = 0
    for round_, w, attempt, plan in new_plans(recorded(*what).rounds):
        k = round_.before.k
        (entry,) = round_.before.swarm.cus[w].trackers[attempt.task.i].trajectories
        assert attempt.task.own is round_.before.plans[attempt.task.i, entry.metadata]
        assert plan.start == k + 1
        begin = (k + 1) * Fraction(1, 5)
        assert flown(attempt.task.own).at(begin) == flown(plan).at(begin)
        assert plan.at_rest
        seen += 1
    assert seen >= 10


@lossy
def test_a_cu_keeps_away_from_all_that_it_holds(what: What) -> None:
    """A task has all entries of all other UAVs' trackers, and the UAVs that the CU's A_ET(k) has."""
    several = 0
    for round_, w, attempt, _ in new_plans(recorded(*what).rounds):
        cu = round_.before.swarm.cus[w]
        held = {
            j: tuple(round_.before.plans[j, entry.metadata] for entry in tracker.trajectories)
            for j, tracker in enumerate(cu.trackers)
        }
        assert cu.state is CuState.RUN_DMPC
        assert {attempt.task.i: held.pop(attempt.task.i)[0]} == {attempt.task.i: attempt.task.own}
        assert attempt.task.others == held
        assert attempt.task.selected == set(cu.a_et or ())
        several += any(len(plans) > 1 for plans in held.values())
    assert several >= 1 or what[5] == "ignore-loss"


@lossy
def test_a_uav_follows_what_it_received(what: What) -> None:
    """From round k + 1 on a UAV follows a plan of round k if it got the message, and otherwise what it followed."""
    adopted = missed = 0
    for round_ in recorded(*what).rounds:
        made = {(attempt.task.i, w): plan for _, w, attempt, plan in new_plans([round_])}
        for i, got in enumerate(round_.at_uavs):
            slots = [
                w for j, w in sorted(made) if i == j and w in got.inbox.cu_messages and w not in got.decoded_replies
            ]
            before, after = round_.before.followed(i), round_.after.followed(i)
            assert after is (made[i, slots[0]] if slots else before)
            metadata = round_.after.swarm.uavs[i].followed.metadata
            assert metadata == (
                Metadata(round_.before.k, slots[0]) if slots else round_.before.swarm.uavs[i].followed.metadata
            )
            adopted += bool(slots)
            missed += not slots and any(i == j for j, _ in made)
    assert adopted >= 10
    assert missed >= 1


@lossy
def test_references_go_on_smoothly(what: What) -> None:
    """With recovery, the state of every reference is the same at the end of a round and at the start of the next."""
    jumps = 0
    for round_ in recorded(*what).rounds:
        k = round_.after.k
        for i in range(len(round_.after.swarm.uavs)):
            jumps += not np.array_equal(round_.before.followed(i).state_at(k), round_.after.followed(i).state_at(k))
    # a CU that ignores losses plans from what the UAV does not follow
    assert (jumps > 0) == (what[5] == "ignore-loss")


@lossy
def test_what_is_named_is_there(what: What) -> None:
    """A state has exactly the trajectories that some tracker holds or some UAV follows, and they never change."""
    known: dict[Name, Plan] = {}
    for round_ in recorded(*what).rounds:
        state = round_.after
        followed = {(uav.i, uav.followed.metadata) for uav in state.swarm.uavs}
        entries = {
            (i, entry.metadata)
            for cu in state.swarm.cus
            for i, tracker in enumerate(cu.trackers)
            for entry in tracker.trajectories
        }
        assert set(state.plans) == followed | entries
        for name, plan in state.plans.items():
            assert known.setdefault(name, plan) is plan


@lossy
def test_who_does_not_run_has_no_opinion(what: What) -> None:
    """CUs in RUN_DMPC announce 0 for the UAV that they planned and more for others; all other CUs announce 1."""
    states = set()
    for round_ in recorded(*what).rounds:
        for w, (cu, slot) in enumerate(zip(round_.before.swarm.cus, round_.computed.air.slots, strict=True)):
            states.add(cu.state)
            if cu.state is CuState.WAIT_FOR_UPDATE:
                assert slot.cu_message is None
                continue
            assert slot.cu_message is not None
            announced = slot.cu_message.priorities
            assert announced is not None
            attempt = round_.computed.attempts[w]
            if cu.state is not CuState.RUN_DMPC:
                assert attempt is None
                assert announced == (NO_OPINION,) * len(cu.trackers)
                continue
            planned = attempt.task.i if attempt is not None and attempt.planned.plan is not None else None
            assert [i for i, priority in enumerate(announced) if priority == 0] == (
                [] if planned is None else [planned]
            )
            assert all(0 <= priority <= 255 for priority in announced)
    assert states == ({CuState.RUN_DMPC} if what[5] == "ignore-loss" else set(CuState))


def test_a_cu_without_a_plan_sends_an_empty_message() -> None:
    """If no plan comes out, the CU's message carries none, and no UAV has priority 0: nothing was recalculated."""
    what = setting("crossing", 2)

    def gives_up(plans: Plans, task: Task) -> Planned:
        return Planned(None, Status.GAVE_UP, "no time", True)

    for round_ in record(what, "none", 4, Buggy(planner_of(what), gives_up)).rounds:
        assert all(attempt is not None for attempt in round_.computed.attempts)
        assert round_.computed.decided == (None, None)
        for slot in round_.computed.air.slots:
            assert isinstance(slot.cu_message, EmptyMessage)
            assert slot.cu_message.priorities is not None
            assert 0 not in slot.cu_message.priorities
        assert set(round_.after.plans) == {(0, HOVERING.metadata), (1, HOVERING.metadata)}


# Readings of the paper


def readings() -> list[Semantics]:
    """Return every preset with every value of every switch, as far as a flight can have it."""
    found: dict[Semantics, None] = {}
    for preset in PRESETS:
        for switch, values in SWITCHES.items():
            for value in values:
                try:
                    found[Semantics.parse(preset, [f"{switch}={value}", "event_trigger=round-robin"])] = None
                except BadInput:
                    continue
    return list(found)


#: With these, all claims of the protocol were found to hold for two UAVs and two CUs.
SAFE = {"rejoin": "after-reply", "loss_handling": "recover"}


@pytest.mark.parametrize("semantics", readings(), ids=lambda semantics: semantics.name())
def test_every_reading_flies(semantics: Semantics) -> None:
    """Under every reading of the paper a lossy flight goes on, and those that are safe violate nothing."""
    what = Setting(load("circle", 0, ["uavs=3"]), 2, Trigger.HT, semantics, 0)
    recording = record(what, "iid:0.2", 40)
    assert recording.flown.rounds == 40
    assert recording.flown.qps.solved > 0
    if SAFE.items() <= semantics.as_dict().items():
        assert violated(recording.flown.claims) == set()


def conflicts(recording: Recording) -> list[tuple[Round, int]]:
    """Return all rounds and slots in which a CU and a UAV transmit."""
    return [
        (round_, slot)
        for round_ in recording.rounds
        for slot, on_slot in enumerate(round_.computed.air.slots)
        if on_slot.conflict
    ]


def test_a_decoded_reply_is_no_message_of_the_cu() -> None:
    """As printed, a CU may talk over a reply: whoever decodes the reply gets nothing of the CU's message."""
    recording = recorded("circle", 3, "iid:0.2", 40, 1, "printed", 4)
    found = conflicts(recording)
    replies = 0
    for round_, slot in found:
        sent, reply = round_.computed.air.slots[slot]
        assert sent is not None
        assert reply is not None
        assert round_.before.swarm.cus[slot].state is CuState.RUN_DMPC
        for i, got in enumerate(round_.at_uavs):
            heard = got.inbox.cu_messages.get(slot)
            assert heard in ((reply, None) if slot in got.decoded_replies else (sent, None))
            if slot in got.decoded_replies:
                replies += 1
                # no trajectory for this UAV came with the reply
                assert round_.after.swarm.uavs[i].followed.metadata != Metadata(round_.before.k, slot)
    assert len(found) >= 3
    assert replies >= 3


def test_guarded_cus_never_talk_over_a_reply() -> None:
    """A CU that gave its slot away waits for the reply: there are no conflicts."""
    assert conflicts(recorded("circle", 3, "iid:0.2", 40, 1, "guarded", 4)) == []


def test_detours_are_learned_from_the_cus_own_message() -> None:
    """A CU's message replaces the detours of the UAVs that it looks after; a reply in its slot says nothing of them."""
    recording = recorded("circle", 3, "iid:0.2", 40, 1, "printed", 4)
    flight = recording.flight
    listeners = [
        (round_, slot, w)
        for round_, slot in conflicts(recording)
        for w, got in enumerate(round_.at_cus)
        if w != slot and slot in got.inbox.cu_messages
    ]
    outcomes = set()
    for round_, slot, w in listeners:
        detour = Detour(slot, (slot + 1) % 4, (0.0, 0.0, 1.0), round_.before.k)
        announced = tuple((detour,) if cu == slot else None for cu in range(3))
        known = flight.learn(round_.before, replace(round_.computed, announced=announced), w, round_.at_cus[w])
        decoded = slot in round_.at_cus[w].decoded_replies
        assert (detour in known.detours) != decoded
        outcomes.add(decoded)
    assert outcomes == {True, False}


def test_a_flight_needs_priorities() -> None:
    """A flight cannot let the trigger be free."""
    with pytest.raises(BadInput, match="event_trigger must be round-robin"):
        Setting(SWAP, 2, Trigger.HT, Semantics.parse("guarded"), 0).flight()


def test_starts_are_apart_on_the_lattice() -> None:
    """Starts d̂_min apart are so on the flight's lattice, though not on the usual one; with more digits, none holds."""
    usual = setting("crossing").flight().lattice
    # 0.1344² + 0.2108² = 0.25², and a nanometre further
    starts = points((1e-9, 0.0, 1.0), (0.134400001, 0.2108, 1.0))

    def squared(units: Lattice) -> Fraction:
        (ax, ay, _), (bx, by, _) = units.hovers(starts).tolist()
        x, y = (Fraction(a - b) * units.position_unit for a, b in ((ax, bx), (ay, by)))
        return x**2 + y**2

    flight = setting(scenario(starts, {0: [A, B]})).flight()
    assert squared(usual) < squared(flight.lattice) == Fraction(1, 16)
    hovers = [plan.positions[0].tolist() for plan in flight.initial().plans.values()]
    assert hovers == flight.lattice.hovers(starts).tolist()
    with pytest.raises(BadInput, match="write the starts with at most 9 decimals, such as"):
        setting(scenario([starts[0], at(0.1344000010000001, *starts[1][1:])], {0: [A, B]})).flight()


# Repeatability


def assert_same(one: Flown, other: Flown) -> None:
    """Assert that two results are the same in every bit."""
    for field in fields(Flown):
        mine, its = getattr(one, field.name), getattr(other, field.name)
        if field.name == "band":
            assert mine.tobytes() == its.tobytes()
        else:
            assert mine == its, field.name


@pytest.mark.parametrize(
    ("what", "loss"),
    [(setting("circle", 3, 5, ["uavs=6"]), "iid:0.1"), (setting("random", 2, 5), "burst:0.1,0.3")],
    ids=["circle", "random"],
)
def test_flights_repeat_to_the_bit(what: Setting, loss: str) -> None:
    """The same setting gives the same flight, in all results and all trajectories; another seed gives another one."""
    first, second = record(what, loss, 25), record(what, loss, 25)
    assert_same(first.flown, second.flown)
    for one, other in zip(first.rounds, second.rounds, strict=True):
        assert one.after.swarm == other.after.swarm
        assert one.after.knowledge == other.after.knowledge
        assert {name: plan.digest for name, plan in one.after.plans.items()} == {
            name: plan.digest for name, plan in other.after.plans.items()
        }
    again = replace(what, seed=what.seed + 1)
    assert record(again, loss, 25).flown.band.tobytes() != first.flown.band.tobytes()


def test_a_planner_has_no_memory() -> None:
    """A second flight with the same planner is the same flight."""
    what = setting("crossing", 2)
    planner = planner_of(what)
    assert_same(record(what, "iid:0.2", 20, planner).flown, record(what, "iid:0.2", 20, planner).flown)


def test_flying_is_flying_under_the_judges_eyes() -> None:
    """The loop of the command does what the steps do one by one, and tells each round to whoever watches."""
    what = setting("crossing", 2)
    seen: list[Round] = []
    result, seconds = fly(what, parse("iid:0.2", 2, 2, what.seed), 20, seen.append)
    assert_same(result, record(what, "iid:0.2", 20).flown)
    assert [round_.before.k for round_ in seen] == list(range(20))
    assert seconds > 0


# Interruption


class Interrupting:
    """Everything arrives, until somebody presses Ctrl-C in round `k`."""

    def __init__(self, k: int) -> None:
        self._k = k

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k."""
        if k == self._k:
            raise KeyboardInterrupt
        return nothing_lost(2, 2)


def test_an_interrupted_flight_is_judged_as_far_as_it_went() -> None:
    """Interrupted in round 7, a flight says so, has 7 rounds, and is judged as if no more had been asked for."""
    what = setting("crossing", 2)
    result, _ = fly(what, Interrupting(7), 60)
    assert result.stopped == "interrupted after 7 of 60 rounds"
    assert_same(replace(result, stopped=None), record(what, "none", 7).flown)
    with pytest.raises(KeyboardInterrupt):
        fly(what, Interrupting(0), 60)


def test_an_interruption_loses_no_distance(monkeypatch: pytest.MonkeyPatch) -> None:
    """Interrupted while distances are bounded, the bound is still one of all rounds that were flown."""
    what = setting("crossing", 2)
    whole = record(what, "none", separation.CHUNK).flown
    pressed: list[bool] = []

    def interrupted(pieces: Floats, second: Scales | None) -> Closest:
        if not pressed:
            pressed.append(True)
            raise KeyboardInterrupt
        return closest(pieces, second)

    monkeypatch.setattr(separation, "closest", interrupted)
    result, _ = fly(what, parse("none", 2, 2, 0), 2 * separation.CHUNK)
    assert pressed
    assert len(result.band) >= result.rounds * 2
    assert result.continuous_lower <= whole.continuous_lower


# Long flights


_LOSSES = ("none", "iid:0.02", "iid:0.1", "burst:0.05,0.3", "jam:3,10")


@pytest.mark.parametrize("seed", [*range(5), *(pytest.param(seed, marks=pytest.mark.deep) for seed in range(5, 200))])
def test_random_swarms_stay_apart(seed: int) -> None:
    """Random flights under all kinds of losses and all triggers violate nothing, and every problem is solved."""
    what = setting("random", 1 + seed % 3, seed, trigger=list(Trigger)[seed // 3 % 3])
    rounds = 40 if seed < 5 else 160
    result, _ = fly(what, parse(_LOSSES[seed % 5], what.scenario.uavs, what.cus, seed), rounds)
    assert violated(result.claims) == set()
    assert (result.qps.rejected, result.qps.infeasible) == (0, 0)
    assert result.sampled >= 0.25
    assert result.tracked is not None
    assert result.tracked >= 0.25


@pytest.mark.deep
def test_nothing_erodes_in_ten_thousand_rounds() -> None:
    """In 10,000 lossy rounds nothing is violated, every problem is solved, and every plan ends exactly at rest."""
    what = setting("random", 2, 0)
    plans = 0

    def watch(round_: Round) -> None:
        nonlocal plans
        for _, _, attempt, plan in new_plans([round_]):
            assert attempt.planned.feasible
            assert plan.at_rest
            plans += 1
            if plans % 500 == 0:
                end = flown(plan).at(plan.start * Fraction(1, 5) + 3)
                assert all(v == a == 0 for _, v, a in end)

    result, _ = fly(what, parse("iid:0.02", what.scenario.uavs, what.cus, 0), 10_000, watch)
    assert violated(result.claims) == set()
    assert (result.qps.rejected, result.qps.infeasible) == (0, 0)
    assert result.qps.solved == plans > 10_000
