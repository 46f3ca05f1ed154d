"""The claims' predicates on observed swarms made by hand: each one true, and each one false."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from swarmproof.claims.claim import Always, Witness
from swarmproof.dmpc_swarm.claims import predicates
from swarmproof.dmpc_swarm.claims.observed import ObservedCu, ObservedSwarm, ObservedTracker, ObservedUav
from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, ProtocolClaim
from swarmproof.dmpc_swarm.claims.witnesses import WITNESSES
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.protocol.swarm import initial_swarm
from swarmproof.dmpc_swarm.semantics import PRESETS, Semantics
from swarmproof.dmpc_swarm.system import SYSTEM
from swarmproof.errors import BadInput

OLD, NEW = "old", "new"


def valid(*entries: str) -> ObservedTracker:
    """Return a tracker that is up to date."""
    return ObservedTracker(frozenset(entries), deprecated=False)


def stale(*entries: str) -> ObservedTracker:
    """Return a deprecated tracker."""
    return ObservedTracker(frozenset(entries), deprecated=True)


def cu(
    *trackers: ObservedTracker,
    state: str = "RUN_DMPC",
    may_plan: tuple[int, ...] = (),
    selection: tuple[int, ...] | None = None,
    transmits: bool = True,
) -> ObservedCu:
    """Return a CU."""
    chosen = None if selection is None else frozenset(selection)
    return ObservedCu(state, trackers, frozenset(may_plan), chosen, transmits)


def swarm(*cus: ObservedCu, followed: tuple[str, ...] = (NEW, NEW)) -> ObservedSwarm:
    """Return a swarm whose UAVs follow these trajectories."""
    return ObservedSwarm(5, followed, (None,) * len(cus), cus)


def uav(*at_cus: tuple[ObservedTracker, bool], followed: str = NEW) -> ObservedUav:
    """Return a UAV with, by CU, its tracker and whether the CU may plan it."""
    return ObservedUav(followed, tuple(("RUN_DMPC", tracker, may_plan) for tracker, may_plan in at_cus))


def broken_cus(found: list[Broken]) -> list[tuple[int, ...]]:
    """Return the CUs concerned."""
    return [broken.cus for broken in found]


def test_lemma_1() -> None:
    """lemma-1 is broken where a tracker that is not deprecated does not contain what the UAV follows."""
    assert not predicates.lemma_1(uav((valid(NEW), False), (valid(OLD, NEW), False)))
    assert not predicates.lemma_1(uav((stale(OLD), False), (stale(), False)))
    assert broken_cus(predicates.lemma_1(uav((valid(OLD), False), (valid(NEW), False), (valid(), False)))) == [
        (0,),
        (2,),
    ]


def test_lemma_2() -> None:
    """lemma-2 is broken by each pair of different trackers that are not deprecated, true or not."""
    assert not predicates.lemma_2(uav((valid(OLD), False), (valid(OLD), False)))
    assert not predicates.lemma_2(uav((valid(NEW), False), (stale(OLD), False), (stale(), False)))
    found = predicates.lemma_2(uav((valid(NEW), False), (valid(OLD, NEW), False), (valid(NEW), False)))
    assert broken_cus(found) == [(0, 1), (1, 2)]


def test_plans_from_truth() -> None:
    """plans-from-truth is broken where a UAV may be planned from anything but exactly what it follows."""
    assert not predicates.plans_from_truth(uav((valid(NEW), True), (valid(OLD), False)))
    found = predicates.plans_from_truth(
        uav((valid(OLD), True), (valid(NEW), True), (valid(OLD, NEW), True), (stale(NEW), True), (valid(), True))
    )
    assert broken_cus(found) == [(0,), (2,), (4,)]


def test_one_planner_per_uav() -> None:
    """one-planner-per-uav is broken by two CUs that plan one UAV, and says which."""
    trackers = (valid(NEW), valid(NEW))
    assert not predicates.one_planner_per_uav(swarm(cu(*trackers, may_plan=(0,)), cu(*trackers, may_plan=(1,))))
    assert not predicates.one_planner_per_uav(swarm(cu(*trackers), cu(*trackers)))
    found = predicates.one_planner_per_uav(
        swarm(cu(*trackers, may_plan=(1,)), cu(*trackers), cu(*trackers, may_plan=(1,)))
    )
    assert [(broken.cus, broken.uav) for broken in found] == [((0, 2), 1)]


def test_same_selection() -> None:
    """same-selection is broken by two running CUs with different A_ET(k); others do not count."""
    trackers = (valid(NEW), valid(NEW))
    running = cu(*trackers, selection=(0, 1))
    assert not predicates.same_selection(swarm(running, cu(*trackers, selection=(1, 0))))
    assert not predicates.same_selection(swarm(running, cu(*trackers, state="WAIT")))
    found = predicates.same_selection(swarm(running, cu(*trackers, state="WAIT"), cu(*trackers, selection=(0, 2))))
    assert broken_cus(found) == [(0, 2)]
    assert "UAV 2" in found[0].why


def test_all_running() -> None:
    """The goal of recovery is that every CU is in RUN_DMPC."""
    trackers = (valid(NEW), valid(NEW))
    assert predicates.all_running(swarm(cu(*trackers), cu(*trackers)))
    for state in ("WAIT", "REQUEST_TRAJECTORY", "WAIT_FOR_UPDATE"):
        assert not predicates.all_running(swarm(cu(*trackers), cu(*trackers, state=state)))


@pytest.mark.parametrize(
    ("plans", "uavs", "expected"),
    [
        (((0, 1), (0, 1)), 2, True),
        (((0,), (1,)), 2, True),
        (((0, 1), (0,)), 2, True),
        (((0,), (0,)), 2, False),
        (((0, 1), ()), 2, False),
        (((), ()), 2, False),
        (((0,), ()), 1, True),
        (((0, 1), (1, 2), (2, 0)), 3, True),
        (((0, 1), (0, 1), (0, 1)), 3, False),
        (((0, 1), (0, 1), ()), 2, True),
    ],
)
def test_can_plan_with_a_free_trigger(plans: tuple[tuple[int, ...], ...], uavs: int, expected: bool) -> None:
    """can-plan asks that min(N, M) CUs can choose pairwise different UAVs."""
    trackers = (valid(NEW),) * uavs
    cus = [cu(*trackers, may_plan=may_plan) for may_plan in plans]
    assert predicates.all_plan(swarm(*cus, followed=(NEW,) * uavs)) is expected


def test_can_plan_with_a_selection() -> None:
    """With a trigger that selects, can-plan counts the CUs that plan; all CUs must run."""
    trackers = (valid(NEW), valid(NEW))
    one, two = (cu(*trackers, may_plan=(i,), selection=(0, 1)) for i in range(2))
    assert predicates.all_plan(swarm(one, two))
    assert not predicates.all_plan(swarm(one, replace(two, may_plan=frozenset())))
    assert not predicates.all_plan(swarm(one, replace(two, state="WAIT")))


OF_UAVS = [one for one in CLAIMS if isinstance(one.question, Always) and one.question.part is not None]


@pytest.mark.parametrize("claim", OF_UAVS, ids=lambda c: c.id)
def test_a_claim_about_uavs_looks_at_one_uav_at_a_time(claim: ProtocolClaim) -> None:
    """Whether such a claim is broken for UAV 0 depends on nothing of UAV 1, and it names the UAV that it is about."""
    good, bad = valid(NEW), valid(OLD)

    def broken(first: ObservedTracker, second: ObservedTracker) -> set[int | None]:
        plans = (0, 1)
        one = cu(first, second, may_plan=plans)
        other = cu(good, good, may_plan=plans)
        return {b.uav for b in claim.broken_in(swarm(one, other))}

    assert broken(good, good) == set()
    assert broken(bad, good) == {0}
    assert broken(good, bad) == {1}
    assert broken(bad, bad) == {0, 1}


def test_only_safety_claims_are_broken_in_a_swarm() -> None:
    """A claim about runs is false in no single swarm."""
    hopeless = swarm(cu(valid(OLD), valid(OLD), state="WAIT"))
    for claim in CLAIMS:
        if not claim.is_safety:
            assert claim.broken_in(hopeless) == []


def test_the_claims_are_the_documented_ones() -> None:
    """The registry has the seven claims, in the order of the documentation."""
    assert [claim.id for claim in CLAIMS] == [
        "lemma-1",
        "lemma-2",
        "plans-from-truth",
        "one-planner-per-uav",
        "same-selection",
        "recovery",
        "can-plan",
    ]
    assert SYSTEM.select_claims() == CLAIMS
    assert [claim.id for claim in SYSTEM.select_claims(["recovery", "lemma-1"])] == ["lemma-1", "recovery"]


def test_an_unknown_claim_is_bad_input() -> None:
    """A claim that does not exist is refused, with the names of those that do."""
    with pytest.raises(BadInput, match=r"no claim 'lemma-3': choose among lemma-1, .*can-plan"):
        SYSTEM.select_claims(["lemma-1", "lemma-3"])


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda c: c.id)
def test_claims_about_selections_need_the_round_robin_trigger(claim: ProtocolClaim) -> None:
    """Only one-planner-per-uav and same-selection depend on the trigger: they need event_trigger=round-robin."""
    needs = claim.id in ("one-planner-per-uav", "same-selection")
    for preset in PRESETS:
        assert claim.applies_to(Semantics.parse(preset)) is not needs
        assert claim.applies_to(Semantics.parse(preset, ["event_trigger=round-robin"]))


def test_the_model_is_shown_as_it_is() -> None:
    """The adapter shows states, trackers, plans and selections of the model's first computation phase."""
    semantics = Semantics.parse("prose", ["initial=known", "event_trigger=round-robin"])
    shown = observe(initial_swarm(3, 2, semantics))
    assert (shown.round, shown.answering) == (0, (None, None))
    assert [c.may_plan for c in shown.cus] == [{0}, {1}]
    assert [c.selection for c in shown.cus] == [frozenset({0, 1})] * 2
    assert all(c.state == "RUN_DMPC" and c.transmits for c in shown.cus)
    assert all(t == ObservedTracker(frozenset({shown.followed[0]}), False) for c in shown.cus for t in c.trackers)
    unknown = observe(initial_swarm(3, 2, Semantics.parse("printed")))
    assert all(t == stale() for c in unknown.cus for t in c.trackers)
    assert all(c.selection is None and not c.may_plan for c in unknown.cus)


WITNESSED: dict[str, Callable[[ObservedSwarm], ObservedSwarm]] = {
    "two-entries": lambda s: replace(s, cus=(cu(valid(OLD, NEW), valid(NEW)), s.cus[1])),
    "request-answered": lambda s: replace(s, answering=(1, None), cus=(replace(s.cus[0], transmits=False), s.cus[1])),
    "recovery-entered": lambda s: replace(s, cus=(s.cus[0], replace(s.cus[1], state="WAIT"))),
    "slot-conflict": lambda s: replace(s, answering=(None, 0)),
}


@pytest.mark.parametrize("witness", WITNESSES, ids=lambda w: w.id)
def test_witnesses_see_their_situation(witness: Witness[ObservedSwarm]) -> None:
    """Each witness is seen in its situation, and in no swarm in which nothing special happens."""
    quiet = swarm(cu(valid(NEW), stale(OLD, NEW), state="REQUEST_TRAJECTORY"), cu(valid(NEW), valid(NEW)))
    assert not witness.seen_in(quiet)
    assert witness.seen_in(WITNESSED[witness.id](quiet))
