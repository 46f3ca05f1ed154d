"""The claims about flights: each is true of a good observation, false of a minimal bad one, and says what is wrong."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import Any

import pytest

from swarmproof.claims.closest import ClosestApproach
from swarmproof.dmpc_swarm.claims.flight import (
    FLIGHT_CLAIMS,
    Approach,
    FlightClaim,
    ObservedAttempt,
    ObservedFlight,
    ObservedRound,
    PlannedBy,
)
from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS

F = Fraction
D_HAT = F(1, 4)
#: m²; far less than a lattice unit makes of a squared distance.
TINY = F(1, 10**30)
#: All that a round says of distances.
APPROACHES = ("known", "learned", "both_new", "one_new", "none_new_before", "none_new_after", "flown")

BY_ID = {claim.id: claim for claim in FLIGHT_CLAIMS}


def approach(square: Fraction) -> Approach:
    """Return an approach of UAV 2, hovering, and UAV 5, planned in round 7, at 1.9 s."""
    return Approach(square, (2, 5), (PlannedBy(-1, -1), PlannedBy(7, 1)), F(19, 10))


NEAR, AT, FAR = approach(D_HAT**2 - TINY), approach(D_HAT**2), approach(F(1))
#: A round in which all trajectories are just far enough from each other.
ROUND = ObservedRound(8, D_HAT, AT, AT, AT, AT, AT, AT, AT, (), underway=2)
DIP = ClosestApproach(0.12, True, (2, 5), 1.85)
FLIGHT = ObservedFlight(F(3, 25), DIP, DIP, adopted=50.0, patience=50.0, late=(), underway=8)


def in_round(claim: str, seen: ObservedRound) -> list[Broken]:
    """Return where a claim is broken in a round."""
    predicate = BY_ID[claim].in_round
    assert predicate is not None
    return predicate(seen)


def in_flight(claim: str, seen: ObservedFlight) -> list[Broken]:
    """Return where a claim is broken in a flight."""
    predicate = BY_ID[claim].in_flight
    assert predicate is not None
    return predicate(seen)


def with_approaches(approaches: dict[str, Any]) -> ObservedRound:
    """Return the good round with other approaches, by name."""
    return replace(ROUND, **approaches)


def attempt(candidate: bool, solved: bool) -> ObservedAttempt:
    """Return CU 1's attempt to plan UAV 3."""
    return ObservedAttempt(1, 3, candidate, solved, "" if solved else "the solver gave up")


@dataclass(frozen=True)
class Bad:
    """A round in which a claim is broken, and what the claim has to say: whom it is about, and why."""

    seen: ObservedRound
    uav: int | None
    cus: tuple[int, ...]
    says: tuple[str, ...]


_PAIR = ("UAV 2 (hovering)", "UAV 5 (planned in round 7 by CU 1)", "0.25 m apart", "at 1.900 s")


def _nearer(name: str) -> Bad:
    return Bad(with_approaches({name: NEAR}), 2, (), _PAIR)


BAD_ROUNDS = {
    "tracked-separation": _nearer("learned"),
    "theorem-1": Bad(replace(ROUND, attempts=[attempt(False, True)]), 3, (1,), ("eq. (20) is true", "breaks (13)")),
    "corollary-1": _nearer("both_new"),
    "lemma-3": _nearer("one_new"),
    "lemma-4": _nearer("none_new_after"),
    "theorem-2": _nearer("flown"),
}
BAD_FLIGHTS = {
    "eq-2": replace(FLIGHT, references=replace(DIP, lower=0.11, at_least=False)),
    "eq-2-actual": replace(FLIGHT, actual=replace(DIP, lower=0.11, at_least=False)),
    "arrives": replace(FLIGHT, late=(2, 5)),
}


# The registry


def test_every_claim_has_a_bad_case_here() -> None:
    """No claim about flights is without an observation that breaks it."""
    assert {claim.id for claim in FLIGHT_CLAIMS if claim.in_round} == set(BAD_ROUNDS)
    assert {claim.id for claim in FLIGHT_CLAIMS if claim.in_flight} == set(BAD_FLIGHTS)


def test_ids_are_unique() -> None:
    """No two claims, of the protocol or of flights, have one id, and ids are words with hyphens."""
    ids = [*(claim.id for claim in CLAIMS), *(claim.id for claim in FLIGHT_CLAIMS)]
    assert len(set(ids)) == len(ids)
    assert all(re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name) for name in ids)


@pytest.mark.parametrize("claim", FLIGHT_CLAIMS, ids=lambda claim: claim.id)
def test_claims_read_well(claim: FlightClaim) -> None:
    """Wording and assumptions are sentences, and the place names an equation, a statement or a section."""
    assert claim.wording[0].isupper()
    assert claim.wording.endswith(".")
    assert claim.assumptions.endswith(".")
    assert re.search(r"([Ee]qs?\. \(\d+\)|(Theorem|Lemma|Corollary) \d|Section \d)", claim.place)


@pytest.mark.parametrize("claim", FLIGHT_CLAIMS, ids=lambda claim: claim.id)
def test_a_claim_has_one_predicate(claim: FlightClaim) -> None:
    """A claim is about a round or about a flight; only a claim about rounds is about an approach."""
    assert (claim.in_round is None) != (claim.in_flight is None)
    assert claim.approach is None or claim.in_round is not None


# Rounds


@pytest.mark.parametrize("claim", BAD_ROUNDS)
def test_a_good_round_breaks_nothing(claim: str) -> None:
    """At exactly d̂_min no claim is broken, nor where there are no pairs at all, nor by plans that came out."""
    alone = with_approaches(dict.fromkeys(APPROACHES))
    for seen in (ROUND, alone, replace(ROUND, attempts=[attempt(True, True)])):
        assert in_round(claim, seen) == []


@pytest.mark.parametrize("claim", BAD_ROUNDS)
def test_a_bad_round_breaks_one_claim(claim: str) -> None:
    """A minimal bad round breaks its claim and no other, which says who, where and when."""
    bad = BAD_ROUNDS[claim]
    (broken,) = in_round(claim, bad.seen)
    assert (broken.uav, broken.cus) == (bad.uav, bad.cus)
    assert all(part in broken.why for part in bad.says), broken.why
    assert [other for other in BAD_ROUNDS if in_round(other, bad.seen)] == [claim]


@pytest.mark.parametrize("name", APPROACHES)
def test_claims_are_about_the_approach_that_they_name(name: str) -> None:
    """A claim that shows an approach is broken by that one alone."""
    seen = with_approaches({name: NEAR})
    for claim in FLIGHT_CLAIMS:
        if claim.in_round is not None and claim.approach is not None:
            assert (claim.approach(seen) is NEAR) == bool(claim.in_round(seen))


def test_who_keeps_away_from_whom() -> None:
    """The claims look at the trackers after the round, the new plans, and what is flown, as their equations do."""
    looked_at = {
        claim.id: [name for name in APPROACHES if claim.approach(with_approaches({name: NEAR})) is NEAR]
        for claim in FLIGHT_CLAIMS
        if claim.approach is not None
    }
    assert looked_at == {
        "tracked-separation": ["learned"],
        "corollary-1": ["both_new"],
        "lemma-3": ["one_new"],
        "lemma-4": ["none_new_after"],
        "theorem-2": ["flown"],
    }


def test_lemma_4_needs_its_hypothesis() -> None:
    """Where (18) fails, (19) may fail; where (18) is true, (19) must be."""
    for before, after in product((None, FAR, AT, NEAR), (None, FAR, AT, NEAR)):
        broken = in_round("lemma-4", replace(ROUND, none_new_before=before, none_new_after=after))
        assert bool(broken) == (after is NEAR and before is not NEAR)


def test_theorem_1_in_all_cases() -> None:
    """With (20) the candidate must be feasible; if then no plan comes out, that is ours; otherwise all may fail."""
    claim = BY_ID["theorem-1"]
    assert claim.unsolved is not None
    assert claim.about is not None
    for known, candidate, solved in product((None, AT, NEAR), (True, False), (True, False)):
        seen = replace(ROUND, known=known, attempts=[attempt(candidate, solved)])
        broken, unsolved = in_round("theorem-1", seen), claim.unsolved(seen)
        assert claim.about(seen) == (known is not NEAR)
        assert [one.why for one in broken] == (
            ["eq. (20) is true, but the old trajectory breaks (13)"] if known is not NEAR and not candidate else []
        )
        assert [one.why for one in unsolved] == (
            ["the solver gave up"] if known is not NEAR and candidate and not solved else []
        )


def test_theorem_1_looks_at_every_attempt() -> None:
    """Of several attempts in one round, each that fails is told."""
    attempts = [attempt(True, True), attempt(False, False), attempt(False, True)]
    broken = in_round("theorem-1", replace(ROUND, attempts=attempts))
    assert [one.cus for one in broken] == [(1,), (1,)]
    assert "breaks (13)" in broken[0].why


def test_the_distance_itself_decides() -> None:
    """A squared distance that no float tells from d̂_min² is still too small."""
    assert float(NEAR.square) == float(D_HAT**2)
    assert in_round("theorem-2", replace(ROUND, flown=NEAR))
    assert not in_round("theorem-2", replace(ROUND, flown=NEAR, d_hat_min=D_HAT - TINY * 10))


# Flights


@pytest.mark.parametrize("claim", BAD_FLIGHTS)
def test_a_good_flight_breaks_nothing(claim: str) -> None:
    """A flight that keeps its distance and arrives breaks no claim, nor does one that cannot be decided."""
    assert in_flight(claim, FLIGHT) == []
    unsure = replace(DIP, at_least=None)
    assert in_flight(claim, replace(FLIGHT, references=unsure, actual=unsure)) == []
    assert in_flight(claim, replace(FLIGHT, actual=None)) == []


@pytest.mark.parametrize("claim", BAD_FLIGHTS)
def test_a_bad_flight_breaks_one_claim(claim: str) -> None:
    """A minimal bad flight breaks its claim and no other."""
    assert [other for other in BAD_FLIGHTS if in_flight(other, BAD_FLIGHTS[claim])] == [claim]


@pytest.mark.parametrize("claim", ["eq-2", "eq-2-actual"])
def test_a_collision_is_told(claim: str) -> None:
    """It is said who comes how close to whom, and when; the bound alone decides nothing."""
    (broken,) = in_flight(claim, BAD_FLIGHTS[claim])
    assert broken.uav == 2
    for part in ("UAV 2 and UAV 5", "0.11 m apart", "at 1.850 s", "less than 0.12 m"):
        assert part in broken.why
    low = replace(DIP, lower=0.0)
    assert in_flight(claim, replace(FLIGHT, references=low, actual=low)) == []


def test_patience_ends() -> None:
    """Being late breaks the claim after so many trajectories, not before; being in time never does."""
    for adopted, is_late in product((0.0, 49.9, 50.0, 51.0), (False, True)):
        seen = replace(FLIGHT, adopted=adopted, late=(3,) if is_late else ())
        assert bool(in_flight("arrives", seen)) == (adopted >= 50 and is_late)
    (broken,) = in_flight("arrives", BAD_FLIGHTS["arrives"])
    assert "50 new trajectories" in broken.why
    assert "UAV 2, UAV 5 had not arrived" in broken.why


def test_trajectories_have_names() -> None:
    """A trajectory is called after its round and CU; that of the start hovers."""
    assert PlannedBy(-1, -1).in_words() == "hovering"
    assert PlannedBy(0, 2).in_words() == "planned in round 0 by CU 2"
