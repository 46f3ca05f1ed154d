"""Safety claims on arbitrary runs of the readable model: far beyond what is explored, and against what is explored."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.claims.predicates import all_plan, all_running
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, ProtocolClaim
from swarmproof.dmpc_swarm.claims.witnesses import RECOVERY_LEFT, WITNESSES
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker, Update, update_information_trackers
from swarmproof.dmpc_swarm.protocol.messages import CuMessage, UavMessage
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.dmpc_swarm.runs import Run, check_run, readings, run_property, runs, runs_of_any_size
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.system import swarm as scope
from swarmproof.errors import BadInput
from swarmproof.explore.decide import verify
from swarmproof.explore.search import Exploration, explore
from swarmproof.falsify.walks import Breach
from swarmproof.trace.replay import replay
from swarmproof.trace.trace import Trace, decode

SAFETY = tuple(claim for claim in CLAIMS if claim.is_safety)

#: The same examples every time, no clock, and none of the slow phase that explains failures.
SETTINGS = settings(
    max_examples=80,
    deadline=None,
    derandomize=True,
    database=None,
    print_blob=True,
    phases=[Phase.explicit, Phase.generate, Phase.shrink],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
UNTIL_FOUND = settings(SETTINGS, max_examples=3_000)

#: What differs from `guarded`; every other value of every switch under which the claims hold at 2 x 2.
GUARDED_VARIANTS: dict[str, list[str]] = {
    "guarded": [],
    "deprecation": ["deprecation=all"],
    "both-lost": ["slot_conflict=both-lost"],
    "cu-wins": ["slot_conflict=cu-wins"],
    "requests in turn": ["request_order=round-robin"],
    "any request": ["request_order=any"],
    "round-robin": ["event_trigger=round-robin"],
    "no guard, both-lost": ["rejoin=any-state", "slot_conflict=both-lost"],
    "no guard, cu-wins": ["rejoin=any-state", "slot_conflict=cu-wins"],
}


def _guarded(overrides: Sequence[str], initial: str) -> Semantics:
    return Semantics.parse("guarded", [*overrides, f"initial={initial}"])


@cache
def _shortest(semantics: Semantics) -> Mapping[str, tuple[Verdict, int | None, int | None]]:
    """Return what exhaustive exploration says of the safety claims at 2 x 2: verdict, rounds, lost messages."""
    decided = verify(scope(2, 2, semantics), SAFETY).claims
    return {one.claim.id: (one.verdict, one.rounds, one.lost_messages) for one in decided}


@cache
def _explored(semantics: Semantics, uavs: int = 2, cus: int = 2) -> Exploration:
    return explore(Rounds(uavs, cus, semantics))


def _assert_explored(run: Run, exploration: Exploration) -> None:
    lost = 0
    for k, swarm in enumerate(run.swarms):
        index = exploration.index.get(exploration.rounds.pack(swarm))
        assert index is not None, f"the swarm in the computation phase of round {k} is not among those explored"
        assert exploration.depth_of(index) <= k
        assert exploration.depth_of(index) < k or exploration.losses[index] <= lost
        lost += run.events[k].lost if k < len(run.events) else 0


def _message_of_failure(drawn: st.SearchStrategy[Run], claims: Sequence[ProtocolClaim] = SAFETY) -> str:
    """Return the message with which the property fails, of the run that Hypothesis shrinks to."""

    @UNTIL_FOUND
    @given(drawn)
    def holds(run: Run) -> None:
        run_property(run, claims)

    with pytest.raises(AssertionError) as raised:
        holds()
    return str(raised.value)


def _trace_in(message: str) -> Trace:
    return decode(message[message.index("{\n") :].encode(), "the message")


def _seen_in(run: Run) -> set[str]:
    """Return what a run goes through: the witnesses' ids, and whether all CUs run, plan, and run again."""
    observed = [observe(swarm) for swarm in run.swarms]
    seen = {witness.id for witness in WITNESSES if any(map(witness.seen_in, observed))}
    running = [all_running(swarm) for swarm in observed]
    waiting = [any(cu.state == "WAIT" for cu in swarm.cus) for swarm in observed]
    if any(running):
        seen.add("all-running")
    if any(map(all_plan, observed)):
        seen.add("all-plan")
    if any(waiting) and any(running[waiting.index(True) :]):
        seen.add(RECOVERY_LEFT.id)
    return seen


@cache
def _sample(uavs: int, cus: int, semantics: Semantics) -> Counter[str]:
    """Return how many of a fixed sample of runs go through what."""
    counted: Counter[str] = Counter()

    @settings(SETTINGS, max_examples=100)
    @given(runs(uavs, cus, semantics))
    def count(run: Run) -> None:
        counted.update(_seen_in(run))

    count()
    return counted


@pytest.mark.parametrize("initial", ["unknown", "known"])
@pytest.mark.parametrize("variant", GUARDED_VARIANTS)
def test_safety_claims_hold_on_any_run_where_they_hold_exhaustively(variant: str, initial: str) -> None:
    """Where every safety claim holds on all 2 x 2 runs, it is true throughout arbitrary runs of up to 6 UAVs, 4 CUs."""
    semantics = _guarded(GUARDED_VARIANTS[variant], initial)
    assert {verdict for verdict, _, _ in _shortest(semantics).values()} <= {Verdict.HOLDS, Verdict.NOT_APPLICABLE}

    @SETTINGS
    @given(runs_of_any_size(st.just(semantics)))
    def holds(run: Run) -> None:
        run_property(run)

    holds()


@pytest.mark.parametrize("event_trigger", ["any", "round-robin"])
def test_safety_claims_hold_at_the_largest_size(event_trigger: str) -> None:
    """Under `guarded`, with either trigger, the safety claims are true throughout runs of 6 UAVs and 4 CUs."""

    @settings(SETTINGS, max_examples=150)
    @given(runs(6, 4, _guarded([f"event_trigger={event_trigger}"], "known")))
    def holds(run: Run) -> None:
        run_property(run)

    holds()


@pytest.mark.parametrize("preset", ["printed", "prose"])
def test_the_slot_conflict_is_found(preset: str) -> None:
    """Under `printed` and `prose`, a run that breaks a claim is found, and its trace replays and breaks that claim."""
    semantics = Semantics.parse(preset)
    message = _message_of_failure(runs(2, 2, semantics))
    trace = _trace_in(message)
    replayed = replay(trace)
    assert f"{trace.shows} is violated" in message
    assert replayed.is_violation
    assert any(slot.conflict for sent in replayed.sent for slot in sent.air.slots)
    for broken in replayed.broken_at(len(replayed.events)):
        assert broken.why in message
    verdict, rounds, _ = _shortest(semantics)[trace.shows]
    assert verdict is Verdict.VIOLATED
    assert rounds is not None
    assert len(replayed.events) >= rounds


def test_the_slot_conflict_is_found_beyond_what_is_explored() -> None:
    """Under `printed`, a run of 6 UAVs and 4 CUs that breaks a claim is found, and its trace replays."""
    trace = _trace_in(_message_of_failure(runs(6, 4, Semantics.parse("printed"))))
    assert dict(trace.sizes) == {"uavs": 6, "cus": 4}
    assert replay(trace).is_violation


def test_shrinking_finds_the_shortest_counterexample() -> None:
    """Under `ignore-loss`, what Hypothesis shrinks to is as short as what exploration finds: one round, one loss."""
    semantics = Semantics.parse("ignore-loss")
    trace = _trace_in(_message_of_failure(runs(2, 2, semantics)))
    replayed = replay(trace)
    assert (len(replayed.events), replayed.lost_messages) == (1, 1)
    assert _shortest(semantics)[trace.shows] == (Verdict.VIOLATED, 1, 1)
    (decided,) = [one.decided for one in replayed.events]
    assert None in decided, "one CU plans, the other need not"


@pytest.mark.parametrize("claim", SAFETY[:3], ids=lambda claim: claim.id)
def test_each_broken_claim_is_found_on_its_own(claim: ProtocolClaim) -> None:
    """Under `ignore-loss`, each violated claim is found when it alone is asked for, and the message names it."""
    message = _message_of_failure(runs(3, 2, Semantics.parse("ignore-loss")), [claim])
    assert message.startswith(f"{claim.id} is violated in the computation phase of round ")
    assert _trace_in(message).shows == claim.id


def _without_lines_17_and_18(
    uav_messages: Mapping[int, UavMessage],
    cu_messages: Mapping[int, CuMessage],
    trackers: Sequence[InformationTracker],
    cus: int,
    semantics: Semantics,
) -> Update:
    del cus  # as many as were received is always enough
    return update_information_trackers(uav_messages, cu_messages, trackers, len(cu_messages), semantics)


def test_a_planted_bug_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without lines 17-18 of Algorithm 2, a run of 4 UAVs and 3 CUs that breaks a claim is found and printed.

    Its trace replays with the bug, and does not show a violation without it.
    """
    with monkeypatch.context() as planted:
        planted.setattr(algorithm1, "update_information_trackers", _without_lines_17_and_18)
        trace = _trace_in(_message_of_failure(runs(4, 3, _guarded([], "known"))))
        assert dict(trace.sizes) == {"uavs": 4, "cus": 3}
        assert replay(trace).is_violation
    with pytest.raises(BadInput):
        replay(trace)


@pytest.mark.parametrize("event_trigger", ["any", "round-robin"])
def test_runs_go_deep(event_trigger: str) -> None:
    """At 6 x 4, known at first, runs hold two entries, wait, are answered, recover, and all CUs run and plan."""
    sample = _sample(6, 4, _guarded([f"event_trigger={event_trigger}"], "known"))
    deep = ["two-entries", "recovery-entered", "request-answered", RECOVERY_LEFT.id, "all-running", "all-plan"]
    assert {name: sample[name] for name in deep if sample[name] < 3} == {}
    assert sample["slot-conflict"] == 0, "the guard excludes it"


def test_runs_go_deep_from_nothing() -> None:
    """At 6 x 4, unknown at first, runs reach RUN_DMPC on all CUs, plan, and lose and recover their knowledge again."""
    sample = _sample(6, 4, _guarded([], "unknown"))
    deep = ["two-entries", "recovery-entered", "request-answered", RECOVERY_LEFT.id, "all-running", "all-plan"]
    assert {name: sample[name] for name in deep if sample[name] < 3} == {}


@pytest.mark.parametrize("initial", ["unknown", "known"])
def test_runs_reach_slot_conflicts_where_there_are_any(initial: str) -> None:
    """At 6 x 4 under `prose`, runs go through slot conflicts."""
    assert _sample(6, 4, Semantics.parse("prose", [f"initial={initial}"]))["slot-conflict"] >= 3


@pytest.mark.parametrize(
    "semantics",
    [
        Semantics.parse("prose"),
        Semantics.parse("guarded"),
        Semantics.parse("ignore-loss"),
        Semantics.parse("guarded", ["initial=known"]),
        Semantics.parse("guarded", ["deprecation=all"]),
        Semantics.parse("guarded", ["request_order=any"]),
        Semantics.parse("guarded", ["request_order=round-robin"]),
        Semantics.parse("guarded", ["event_trigger=round-robin"]),
        Semantics.parse("prose", ["slot_conflict=cu-wins", "initial=known"]),
        Semantics.parse("printed", ["slot_conflict=both-lost"]),
    ],
    ids=Semantics.name,
)
def test_runs_stay_within_what_is_explored(semantics: Semantics) -> None:
    """At 2 x 2, a run visits explored swarms only, none sooner than explored, none as soon with fewer losses."""
    exploration = _explored(semantics)
    assert exploration.stopped is None

    @SETTINGS
    @given(runs(2, 2, semantics))
    def explored(run: Run) -> None:
        _assert_explored(run, exploration)

    explored()


@pytest.mark.parametrize("initial", ["unknown", "known"])
@pytest.mark.parametrize(("uavs", "cus"), [(1, 3), (3, 1), (1, 1)])
def test_runs_of_other_sizes_stay_within_what_is_explored(uavs: int, cus: int, initial: str) -> None:
    """The same holds under `guarded` with the round-robin trigger with 1 or 3 CUs."""
    semantics = _guarded(["event_trigger=round-robin"], initial)
    exploration = _explored(semantics, uavs, cus)
    assert exploration.stopped is None

    @SETTINGS
    @given(runs(uavs, cus, semantics))
    def explored(run: Run) -> None:
        _assert_explored(run, exploration)

    explored()


def test_a_missing_state_would_be_noticed() -> None:
    """The comparison with exploration fails for runs of a semantics that reaches more than what was explored."""
    exploration = _explored(Semantics.parse("guarded"))

    @settings(SETTINGS, max_examples=200)
    @given(runs(2, 2, Semantics.parse("prose")))
    def explored(run: Run) -> None:
        assert all(exploration.rounds.pack(swarm) in exploration.index for swarm in run.swarms)

    with pytest.raises(AssertionError):
        explored()


def test_check_run_reports_the_first_breach() -> None:
    """check_run returns the first broken state, claims in the registry's order, and None where nothing is broken."""
    breaches: list[tuple[Run, Breach | None]] = []

    @SETTINGS
    @given(runs(3, 2, Semantics.parse("ignore-loss")))
    def collect(run: Run) -> None:
        breaches.append((run, check_run(run)))

    collect()
    assert any(breach is None for _, breach in breaches)
    assert any(breach is not None for _, breach in breaches)
    for run, breach in breaches:
        broken = [
            (k, claim)
            for k, swarm in enumerate(run.swarms)
            for claim in SAFETY
            if claim.applies_to(run.semantics) and claim.broken_in(observe(swarm))
        ]
        assert (None if breach is None else (breach.round, breach.claim)) == next(iter(broken), None)


@pytest.mark.parametrize(
    "fixed",
    [{"rejoice": "later"}, {"rejoin": "later"}, {"loss_handling": "ignore", "initial": "unknown"}],
    ids=["switch", "value", "values"],
)
def test_impossible_readings_are_refused(fixed: dict[str, str]) -> None:
    """No semantics are drawn with a switch or value that there is not, or with values that exclude each other."""
    with pytest.raises(BadInput):
        readings(fixed)


@SETTINGS
@given(readings({"loss_handling": "ignore"}))
def test_readings_are_as_they_are_asked_for(semantics: Semantics) -> None:
    """Drawn semantics have the fixed values, and what these need."""
    assert (semantics.loss_handling, semantics.initial) == ("ignore", "known")


@pytest.mark.parametrize("size", [(0, 2, 5), (2, 0, 5), (2, 2, -1)])
def test_impossible_sizes_are_refused(size: tuple[int, int, int]) -> None:
    """No runs are drawn of swarms without UAVs or CUs, or of a negative length."""
    uavs, cus, max_rounds = size
    with pytest.raises(BadInput):
        runs(uavs, cus, Semantics(), max_rounds)
