"""No success about nothing: what every claim says of flights and scopes in which there is nothing to speak of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from tests.dmpc_swarm.flight.flights import Buggy, planner_of, record
from tests.dmpc_swarm.flight.settings import setting

from swarmproof.claims.verdict import Verdict
from swarmproof.cli import main
from swarmproof.dmpc_swarm.claims.flight import FLIGHT_CLAIMS
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS
from swarmproof.dmpc_swarm.flight.exhaustive import explore_flights
from swarmproof.dmpc_swarm.flight.fly import Plans
from swarmproof.dmpc_swarm.flight.judge import Judged
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.planner.planner import Planned
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.system import swarm as scope
from swarmproof.explore.decide import verify
from swarmproof.qp.solvers import Status

PROTOCOL = [claim for claim in CLAIMS if claim.is_safety]
#: A mark for each verdict: of what was seen, of nothing, and of what is open.
MARKS = {Verdict.NOT_VIOLATED: "+", Verdict.NOT_APPLICABLE: "-", Verdict.UNDECIDED: "?"}
NAMES = [*(claim.id for claim in PROTOCOL), *(claim.id for claim in FLIGHT_CLAIMS)]


def never_plans(plans: Plans, task: Task) -> Planned:
    """Find no plan, ever."""
    return replace(plans.plan(task), plan=None, status=Status.GAVE_UP, why="no time")


def flown(what: Setting, loss: str, rounds: int, plans: Plans | None = None) -> tuple[Judged, ...]:
    """Return the claims after a flight."""
    return record(what, loss, rounds, plans).flown.claims


def crossing(cus: int = 2) -> Setting:
    """Return the crossing."""
    return setting("crossing", cus)


#: Flights in which little or nothing happens, and what the claims, in the order of NAMES, say of them. After one round
#: of the first, all trackers are deprecated; in its round 0, both CUs plan.
FLIGHTS: dict[str, tuple[Callable[[], tuple[Judged, ...]], str]] = {
    "everything is lost": (lambda: flown(crossing(), "iid:1", 60), "------++------"),
    "one round": (lambda: flown(crossing(), "none", 1), "++-+++++------"),
    "no plan comes out": (
        lambda: flown(crossing(), "none", 60, Buggy(planner_of(crossing()), never_plans)),
        "++++++?--+----",
    ),
    "one CU": (lambda: flown(crossing(1), "none", 60), "+-+--++-+-++-+"),
    "nothing of the kind": (lambda: flown(crossing(), "iid:0.1", 60), "++++++++++++-+"),
}


@pytest.mark.parametrize("name", FLIGHTS)
def test_no_claim_succeeds_about_nothing(name: str) -> None:
    """Not-violated is said only where there was something that the claim speaks of; else it says what there was not."""
    fly, marks = FLIGHTS[name]
    claims = fly()
    assert [one.claim.id for one in claims] == NAMES
    assert "".join(MARKS[one.verdict] for one in claims) == marks
    for one in claims:
        assert (one.instances > 0) == (one.verdict is not Verdict.NOT_APPLICABLE)
        assert bool(one.why) == (one.verdict is not Verdict.NOT_VIOLATED)


def test_every_claim_knows_what_it_is_about() -> None:
    """No claim about rounds, flights or swarms could be added that succeeds about nothing."""
    for claim in FLIGHT_CLAIMS:
        if claim.in_round is not None:
            assert claim.about is not None, claim.id
            assert claim.nothing, claim.id
        else:
            assert claim.fails is not None, claim.id
    for protocol_claim in PROTOCOL:
        assert protocol_claim.about is not None, protocol_claim.id
        assert protocol_claim.nothing, protocol_claim.id


def test_nothing_is_no_success_of_a_search_either() -> None:
    """All patterns of one round with one CU say nothing about two CUs."""
    whole = explore_flights(crossing(1), 1, lambda k, done, size: None)
    none = {one.claim.id for one in whole.claims if one.verdict == "not-applicable"}
    assert none == {"lemma-2", "one-planner-per-uav", "same-selection", "corollary-1", "lemma-4", "theorem-2"}
    assert all(bool(one.why) == (one.claim.id in none) == (one.instances == 0) for one in whole.claims)


@pytest.mark.parametrize("trigger", ["any", "round-robin"])
def test_one_cu_decides_nothing_about_two(trigger: str) -> None:
    """`verify` with one CU does not say that claims about two CUs hold; with two it decides them."""
    about_two = {"lemma-2", "one-planner-per-uav", "same-selection"}
    for cus in (1, 2):
        semantics = Semantics.parse("guarded", [f"event_trigger={trigger}"])
        decided = {one.claim.id: one for one in verify(scope(2, cus, semantics)).claims}
        selection = about_two - {"lemma-2"} if trigger == "any" else set()
        none = {name for name, one in decided.items() if one.verdict is Verdict.NOT_APPLICABLE}
        assert none == (about_two if cus == 1 else selection)
    assert not any(one.verdict is Verdict.VIOLATED for one in decided.values())


def test_the_last_progress_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    """It is said when a UAV adopted a new trajectory last, whose it was and who planned it, or that none did."""
    assert main(["fly", "crossing", "--loss", "jam:8,100", "--rounds", "30"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    recording = record(crossing(), "jam:8,100", 30)
    (last,) = [
        (round_.before.k, new.i, new.followed.metadata.cu)
        for round_ in recording.rounds
        for old, new in zip(round_.before.swarm.uavs, round_.after.swarm.uavs, strict=True)
        if old.followed != new.followed
    ][-1:]
    assert recording.flown.last_adoption is not None
    assert recording.flown.last_adoption[0] == last[0]
    assert f"Last new trajectory adopted: in round {last[0]}, by UAV " in said
    adopted = sum(
        old.followed != new.followed
        for round_ in recording.rounds
        for old, new in zip(round_.before.swarm.uavs, round_.after.swarm.uavs, strict=True)
    )
    assert f"UAVs adopted {adopted / 2:.1f} new trajectories each, 50 are needed; UAV 0, UAV 1 had not arrived" in said
    assert main(["fly", "crossing", "--loss", "iid:1", "--rounds", "30"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "30 rounds: no claim violated; nobody adopted a new trajectory" in said
    assert "Nobody adopted a new trajectory." in said


def test_a_search_without_a_pattern_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    """An adversary with a budget for one flight finds nothing, which it does not call a success."""
    main(["fly", "crossing", "--loss", "adversary:1", "--rounds", "5"])
    said = " ".join(capsys.readouterr().out.split())
    assert "no pattern was found that brings UAVs closer, which says nothing of those not tried" in said


@pytest.mark.parametrize("change", ["v_max=0", "a_max=0", "j_norm=0", "horizon=2"])
def test_a_swarm_that_cannot_move_is_not_called_safe(change: str) -> None:
    """Where no plan can move, all UAVs hover where they started: separation is about nothing, and nobody arrives."""
    what = Setting.parse("crossing", 2, "HT", "guarded", [change], 0)
    verdicts = {judged.claim.id: judged.verdict for judged in flown(what, "none", 60)}
    assert {verdicts[name] for name in ("theorem-2", "eq-2")} == {Verdict.NOT_APPLICABLE}
    assert verdicts["arrives"] is not Verdict.NOT_VIOLATED


def test_every_pattern_is_flown_in_the_space_that_it_needs() -> None:
    """More rounds of losses than the scenario has do not shrink an open space to what its own rounds would reach."""
    open_space = "workspace=-inf,inf,-inf,inf,-inf,inf"
    short, long = (Setting.parse("crossing", 1, "HT", "guarded", [open_space], 0, rounds=rounds) for rounds in (1, 3))
    found = [explore_flights(what, 3, lambda *_: None) for what in (short, long)]
    assert found[0].continuous_lower == found[1].continuous_lower
    assert [claim.verdict for claim in found[0].claims] == [claim.verdict for claim in found[1].claims]
    assert found[0].qps == found[1].qps
