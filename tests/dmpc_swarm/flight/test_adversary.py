"""The adversary: patterns mean what they say, flights of them are exact, and the search finds what there is to find."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from random import Random
from types import SimpleNamespace

import numpy as np
import pytest
from tests.dmpc_swarm.flight.settings import setting

from swarmproof.dmpc_swarm.flight import adversary
from swarmproof.dmpc_swarm.flight import incremental as refly
from swarmproof.dmpc_swarm.flight.adversary import LENGTHS, MOST_DRAWN, Worst, parse_budget, search
from swarmproof.dmpc_swarm.flight.incremental import DEAF, Flights, Flown, Loss, Pattern, before, places
from swarmproof.dmpc_swarm.flight.observing import reference_pieces
from swarmproof.dmpc_swarm.flight.run import Setting, fly
from swarmproof.dmpc_swarm.flight.state import FlightState
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.errors import BadInput
from swarmproof.explore.search import Limits
from swarmproof.faults.losses import Recorded
from swarmproof.monitor.bernstein import closest
from swarmproof.motion.lattice import Floats, Lattice

#: What counts as a crash, and the distance that plans keep at samples (m).
CRASH, KEPT = 0.12, 0.25
#: Long enough to cross.
ROUNDS = 30

IGNORING = setting("crossing", semantics="ignore-loss")
GUARDED = setting("crossing")


def there_and_back(semantics: str) -> Setting:
    """Return a flight to other targets from round 4 on, and back to the starts from round 12 on."""
    scenario = setting("crossing").scenario
    (away,) = scenario.targets
    targets = (
        replace(away, points=scenario.starts),
        replace(away, round=4),
        replace(away, round=12, points=scenario.starts),
    )
    return setting(replace(scenario, targets=targets), semantics=semantics)


def quiet(done: int, nearest: float) -> None:
    """Tell nobody."""


def told(what: Setting, rounds: int, budget: int) -> tuple[list[float], Worst]:
    """Return the smallest distance (m) so far after each flight of a search, and what it finds."""
    distances: list[float] = []
    worst = search(what, rounds, budget, lambda done, nearest: distances.append(nearest))
    return distances, worst


def drawn(flights: Flights, random: Random, rounds: int = ROUNDS, most: int = MOST_DRAWN) -> Pattern:
    """Return a random pattern in which no loss follows another one at the same place."""
    at = random.sample(range(len(flights.places)), random.randint(1, min(most, len(flights.places))))
    losses = [Loss(place, random.randrange(rounds), random.choice(LENGTHS)) for place in sorted(at)]
    return tuple(loss._replace(rounds=min(loss.rounds, rounds - loss.first)) for loss in losses)


def again(what: Setting, flights: Flights, pattern: Pattern, rounds: int) -> list[float]:
    """Return the distance in each round of a pattern's flight, flown by nothing but :class:`Flight`."""
    losses = [flights.losses(n for n, first, length in pattern if first <= k < first + length) for k in range(rounds)]
    flight = what.flight()
    recorded = Recorded(losses, what.scenario.uavs, what.cus)
    states = [flown.before for flown in flight.rounds(flight.initial(), recorded, rounds)]
    unit = float(flight.lattice.pairs.unit)
    return [closest(reference_pieces(flight.lattice, state)).lower ** 0.5 * unit for state in states]


def judged(what: Setting, worst: Worst, rounds: int) -> tuple[float, float, set[str]]:
    """Return what the judge says of a pattern: distance at samples and at any time (m), and the violated claims."""
    flown, _ = fly(what, Recorded(worst.losses, what.scenario.uavs, what.cus), rounds)
    return flown.sampled, flown.continuous_lower, {one.claim.id for one in flown.claims if one.verdict == "violated"}


# -- patterns


@pytest.mark.parametrize(("uavs", "cus", "conflicts"), [(2, 2, False), (3, 1, True), (5, 3, True)])
def test_places_cover_every_loss_once(uavs: int, cus: int, conflicts: bool) -> None:
    """Each entry of the arrays of losses has one place of its own; a deaf receiver has all of its losses."""
    found = places(uavs, cus, conflicts)
    single = Counter(place.marks for place in found if place.misses != DEAF)
    shapes = [(cus, uavs), (cus, cus), (uavs, cus)] + [(cus, cus), (uavs, cus)] * conflicts
    entries = [(n, row, column) for n, shape in enumerate(shapes) for row, column in np.ndindex(*shape)]
    assert single == Counter((entry,) for entry in entries)
    for kind, count, arrays in (("CU", cus, (0, 1)), ("UAV", uavs, (2,))):
        for n in range(count):
            (deaf,) = (place for place in found if place.receiver == f"{kind} {n}" and place.misses == DEAF)
            assert sorted(deaf.marks) == [entry for entry in entries if entry[0] in arrays and entry[1] == n]
    assert len({(place.receiver, place.misses) for place in found}) == len(found)


def test_losses_are_where_the_words_say() -> None:
    """A loss in words names the receiver, the message and the rounds; its marks are in the array of that message."""
    flights = Flights(setting("crossing", cus=3), ROUNDS)
    names = {(place.receiver, place.misses): n for n, place in enumerate(flights.places)}
    metadata = names["CU 2", "misses the metadata of UAV 1"]
    slot = names["UAV 0", "misses the message in CU 2's slot"]
    assert flights.in_words(Loss(metadata, 3, 1)) == "CU 2 misses the metadata of UAV 1 in round 3."
    assert flights.in_words(Loss(slot, 3, 4)) == "UAV 0 misses the message in CU 2's slot in rounds 3 to 6."
    losses = flights.losses([metadata, slot])
    assert losses.cu_uav[2, 1]
    assert losses.uav_slot[0, 2]
    assert losses.count == 2
    deaf = flights.losses([names["CU 1", DEAF]])
    assert deaf.cu_uav[1].all()
    assert deaf.cu_slot[1].all()
    assert deaf.count == 2 + 3


def test_coins_only_where_two_transmit() -> None:
    """Which of two messages is decoded belongs to a pattern only where the semantics let two transmit in a slot."""

    def has_coins(preset: str) -> bool:
        found = Flights(setting("crossing", semantics=preset), 1).places
        return any(mark[0] >= 3 for place in found for mark in place.marks)

    assert has_coins("printed")
    assert not has_coins("guarded")
    assert not has_coins("ignore-loss")


def test_before() -> None:
    """The part of a pattern before a round has what is missed until then, and nothing that begins later."""
    pattern = (Loss(0, 0, 2), Loss(1, 2, 5), Loss(2, 4, 1), Loss(3, 5, 9))
    assert before(pattern, 4) == (Loss(0, 0, 2), Loss(1, 2, 2))
    assert before(pattern, 0) == ()


# -- flights of patterns


@pytest.mark.parametrize("what", [IGNORING, GUARDED], ids=["ignoring", "guarded"])
def test_flights_that_go_on_from_others_are_exact(what: Setting) -> None:
    """A flight has the distances that it has if all is flown anew, to the bit, whatever it is based on."""
    random = Random(1)
    flights = Flights(what, ROUNDS)
    bases: list[Flown] = []
    shared = 0
    for _ in range(5):
        pattern = drawn(flights, random, most=5)
        if bases:  # a relative of a base: one loss is another one
            *some, last = bases[-1].pattern
            pattern = (*some, last._replace(rounds=1))
        flown = flights.fly(pattern, bases[-2:], whole=True)
        shared += sum(step is base for step in flown.steps for known in bases for base in known.steps)
        anew = again(what, flights, pattern, ROUNDS)
        assert [step.distance for step in flown.steps] == pytest.approx(anew, rel=1e-12)
        assert flown.distance == min(step.distance for step in flown.steps)
        assert flown.steps[flown.nearest].distance == flown.distance
        bases.append(flown)
    assert shared > ROUNDS, "nothing was taken from a base: the test shows nothing"


def test_flights_differ_by_what_is_known() -> None:
    """A CU that misses where a UAV wants to go makes another flight, though trajectories are the same at first."""
    what = there_and_back("ignore-loss")
    flights = Flights(what, 24)
    missed = [n for n, place in enumerate(flights.places) if "metadata" in place.misses]
    pattern = tuple(Loss(n, 4, 5) for n in missed)
    base = flights.fly((), whole=True)
    flown = flights.fly(pattern, [base], whole=True)
    anew = again(what, flights, pattern, 24)
    assert [step.distance for step in flown.steps] == pytest.approx(anew, rel=1e-12)
    assert [step.distance for step in base.steps] != pytest.approx(anew, rel=1e-3)


def test_a_flight_without_its_base_would_be_another(monkeypatch: pytest.MonkeyPatch) -> None:
    """The test above catches a flight that goes on from its base where the swarms differ."""
    monkeypatch.setattr(refly, "_equal", lambda one, other: one.k == other.k)
    flights = Flights(IGNORING, ROUNDS)
    deaf = tuple(Loss(n, 5, 10) for n, place in enumerate(flights.places) if place.misses == DEAF)
    flown = flights.fly(deaf, [flights.fly((), whole=True)], whole=True)
    anew = again(IGNORING, flights, deaf, ROUNDS)
    assert [step.distance for step in flown.steps] != pytest.approx(anew, rel=1e-3)


def test_flights_end_when_all_have_arrived() -> None:
    """A flight is over once the UAVs stay at their targets, not before its last loss, and misses no approach."""
    rounds = 60
    flights = Flights(GUARDED, rounds)
    early, whole = flights.fly(()), flights.fly((), whole=True)
    assert len(early.steps) < len(whole.steps) == rounds
    assert early.distance == whole.distance
    late = flights.fly((Loss(0, 50, 3),))
    assert 53 <= len(late.steps) < rounds
    back = Flights(there_and_back("guarded"), 30)
    assert 12 < len(back.fly(()).steps) < 30


@pytest.mark.parametrize("what", [IGNORING, GUARDED], ids=["ignoring", "guarded"])
def test_promises_are_kept(what: Setting) -> None:
    """The pattern that a flight promises brings the UAVs as close as promised, at least."""
    random = Random(2)
    flights = Flights(what, ROUNDS)
    closer = 0
    for _ in range(6):
        flown = flights.fly(drawn(flights, random))
        kept = flights.fly(flights.promised(flown), [flown])
        assert kept.distance <= flown.promise.distance * (1 + 1e-8)
        assert kept.steps[flown.promise.nearest].distance <= flown.promise.distance * (1 + 1e-8)
        assert flown.promise.distance <= flown.distance * (1 + 1e-8) or len(what.scenario.starts) > 2
        closer += kept.distance < 0.99 * flown.distance
    assert closer or what is GUARDED, "all promises are what the flights reach anyway: the test shows nothing"


# -- the search


def test_finds_a_collision_where_losses_are_ignored() -> None:
    """The older DMPC, which ignores losses, lets two UAVs collide: found within 40 flights, confirmed by the judge."""
    worst = search(IGNORING, ROUNDS, 40, quiet)
    sampled, distance, violated = judged(IGNORING, worst, ROUNDS)
    assert distance < CRASH
    assert distance == pytest.approx(worst.distance, rel=1e-8)
    assert sampled < KEPT
    assert "eq-2" in violated


def test_finds_a_collision_of_several() -> None:
    """So it does for six UAVs on a circle, within 25 flights."""
    what = setting("circle", seed=4, changes=["uavs=6"], semantics="ignore-loss")
    worst = search(what, 50, 25, quiet)
    _, distance, violated = judged(what, worst, 300)
    assert distance < CRASH
    assert distance <= worst.distance * (1 + 1e-8)
    assert "eq-2" in violated


class Watched:
    """Sees all references that are looked at in flights, and the smallest squared distance at their samples (m²)."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.rounds = 0
        self.smallest = Fraction(10**6)
        monkeypatch.setattr(refly, "reference_pieces", self)

    def __call__(self, lattice: Lattice, state: FlightState) -> Floats:
        """Return the pieces of a round: the first coefficient of each is the position at a sample."""
        pieces = reference_pieces(lattice, state)
        self.rounds += 1
        q = [[[int(x) for x in uav] for uav in step] for step in pieces[:, :, :, 0].tolist()]
        for step in q:
            for i, one in enumerate(step):
                for other in step[:i]:
                    square = sum((a - b) ** 2 for a, b in zip(one, other, strict=True))
                    self.smallest = min(self.smallest, square * lattice.pairs.unit**2)
        return pieces


@pytest.mark.parametrize(
    ("scenario", "changes", "rounds", "budget"),
    [
        ("crossing", [], ROUNDS, 30),
        pytest.param("crossing", [], 60, 400, marks=pytest.mark.deep),
        pytest.param("circle", ["uavs=6"], 80, 200, marks=pytest.mark.deep),
        pytest.param("random", ["uavs=6"], 80, 200, marks=pytest.mark.deep),
    ],
)
def test_guarded_is_never_below_at_samples(
    scenario: str, changes: list[str], rounds: int, budget: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Under `guarded` no flight of the search has two references below d̂_min at a sample, exactly."""
    seen = Watched(monkeypatch)
    what = setting(scenario, changes=changes)
    worst = search(what, rounds, budget, quiet)
    assert seen.smallest >= Fraction(1, 4) ** 2
    assert seen.rounds > budget
    assert worst.distance > CRASH
    assert judged(what, worst, rounds)[2] <= {"arrives"}


def blind(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let planner and acceptance see only the newest trajectory of each other UAV, which it may not have received."""
    plan = Planner.plan

    def newest(self: Planner, task: Task) -> Planned:
        return plan(self, replace(task, others={j: held[-1:] for j, held in task.others.items()}))

    monkeypatch.setattr(Planner, "plan", newest)


CIRCLE = setting("circle", changes=["uavs=6"])


def test_finds_a_planted_bug(monkeypatch: pytest.MonkeyPatch) -> None:
    """A planner that relies on the newest trajectories fails, not without losses, but in what the adversary finds."""
    blind(monkeypatch)
    lossless, _ = fly(CIRCLE, Recorded((), 6, 2), 40)
    assert lossless.sampled >= KEPT
    seen = Watched(monkeypatch)
    worst = search(CIRCLE, 40, 12, quiet)
    assert seen.smallest < Fraction(1, 4) ** 2
    sampled, _, violated = judged(CIRCLE, worst, 40)
    assert sampled < KEPT
    assert violated - {"arrives"}


def by_chance(what: Setting, rounds: int, budget: int, tell: Callable[[float], None]) -> None:
    """Tell the distance (m) of the flight without losses, and of random patterns, drawn alike."""
    flights = Flights(what, rounds)
    random = Random(what.seed)
    lossless = flights.fly(())
    tell(lossless.distance)
    for _ in range(budget - 1):
        tell(flights.fly(drawn(flights, random, len(lossless.steps)), [lossless]).distance)


@pytest.mark.deep
@pytest.mark.parametrize(("scenario", "changes"), [("crossing", []), ("circle", ["uavs=6"])])
def test_closer_than_chance(scenario: str, changes: list[str]) -> None:
    """Over eight seeds, the search comes at least twice as close as as many random patterns, in the geometric mean."""
    ratios = []
    for seed in range(8):
        what = setting(scenario, seed=seed, changes=changes, semantics="ignore-loss")
        found = search(what, 60, 60, quiet).distance
        chance: list[float] = []
        by_chance(what, 60, 60, chance.append)
        # what is closer than 1 mm counts as 1 mm
        ratios.append(max(found, 1e-3) / max(min(chance), 1e-3))
    assert np.log(ratios).mean() < -np.log(2)


@pytest.mark.deep
def test_finds_a_planted_bug_sooner_than_chance(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search comes below d̂_min by far in less than half as many flights as it takes random patterns."""
    blind(monkeypatch)
    budget, below = 40, 0.2
    found, chance = 0, 0
    for seed in range(5):
        what = setting("circle", seed=seed, changes=["uavs=6"])
        found += sum(distance >= below for distance in told(what, 60, budget)[0])
        random: list[float] = []
        by_chance(what, 60, budget, random.append)
        chance += next((n for n, distance in enumerate(random) if distance < below), budget)
    assert 2 * found < chance


@pytest.mark.parametrize("budget", [1, 2, 3, 9])
def test_budgets_are_kept(budget: int) -> None:
    """Not more flights are flown than the budget allows, all of it is used, and what is told gets ever smaller."""
    heard: list[tuple[int, float]] = []
    worst = search(GUARDED, 10, budget, lambda done, nearest: heard.append((done, nearest)))
    assert [done for done, _ in heard] == list(range(1, worst.evaluated + 1))
    assert all(later <= sooner for (_, sooner), (_, later) in pairwise(heard))
    assert worst.evaluated <= budget
    # the last flights are for leaving out losses, and are left over if the same has been flown before
    assert worst.evaluated >= budget - 3
    if budget == 1:
        assert worst.losses == ()
        assert worst.description[0].endswith("which says nothing of those not tried.")


def test_the_same_seed_finds_the_same(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A search depends on its arguments alone, to the bit, and writes nothing; another seed goes another way."""
    monkeypatch.chdir(tmp_path)

    here, there = (setting("crossing", seed=seed, semantics="ignore-loss") for seed in (3, 4))
    first, worst = told(here, 12, 12)
    second, again = told(here, 12, 12)
    assert first == second
    assert worst.description == again.description
    assert [losses.count for losses in worst.losses] == [losses.count for losses in again.losses]
    assert told(there, 12, 12)[0][:6] != first[:6]
    assert not list(tmp_path.iterdir())


def test_no_loss_is_left_that_does_not_matter() -> None:
    """Without any one of its losses, the pattern found brings the UAVs less close; its words are its losses."""
    worst = search(IGNORING, ROUNDS, 30, quiet)
    assert worst.losses
    flights = Flights(IGNORING, ROUNDS)
    by_words = {
        flights.in_words(loss): loss
        for n in range(len(flights.places))
        for k in range(ROUNDS)
        for loss in (Loss(n, k, length) for length in range(1, ROUNDS - k + 1))
    }
    headline, *lines = worst.description
    pattern = tuple(by_words[line] for line in lines)
    assert f"{worst.distance:.4f} m" in headline
    whole = flights.fly(pattern)
    assert whole.distance == worst.distance
    assert all(loss.first + loss.rounds <= whole.nearest for loss in pattern), "that comes too late"
    for loss in pattern:
        rest = flights.fly(tuple(other for other in pattern if other != loss), [whole])
        assert rest.distance > worst.distance
    for k, losses in enumerate(worst.losses):
        now = [loss for loss in pattern if loss.first <= k < loss.first + loss.rounds]
        assert losses.count == len({mark for loss in now for mark in flights.places[loss.place].marks})


@pytest.mark.parametrize("after", [1, 3, 11])
def test_interrupted(after: int) -> None:
    """Interrupted in either phase, the search returns the best pattern so far, and says so."""

    def interrupt(done: int, nearest: float) -> None:
        if done == after:
            raise KeyboardInterrupt

    if after == 1:  # not even the first flight is known to anybody
        with pytest.raises(KeyboardInterrupt):
            search(IGNORING, 12, 12, interrupt)
        return
    uninterrupted, _ = told(IGNORING, 12, 12)
    worst = search(IGNORING, 12, 12, interrupt)
    assert worst.evaluated == after
    assert worst.distance == uninterrupted[after - 1]
    assert worst.stopped == "interrupted"
    assert worst.description[0].startswith(f"Not finished: interrupted. Flights tried: {after} of 12.")


@pytest.mark.parametrize("after", [1, 3, 11])
def test_a_limit_of_seconds(after: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Out of time, in either phase, the search keeps the best pattern so far; it has flown at least once."""
    uninterrupted, _ = told(IGNORING, 12, 12)
    clock = [0.0]
    monkeypatch.setattr(adversary, "time", SimpleNamespace(perf_counter=lambda: clock[0]))

    def tell(done: int, nearest: float) -> None:
        clock[0] = float(done)

    worst = search(IGNORING, 12, 12, tell, Limits(max_seconds=after))
    assert worst.stopped == f"the limit of {after} s"
    assert worst.evaluated == after
    assert worst.distance == uninterrupted[after - 1]
    assert worst.description[0].startswith(f"Not finished: the limit of {after} s. Flights tried: {after} of 12.")
    clock[0] = 0.0
    assert search(IGNORING, 12, 12, tell, Limits(max_seconds=13)).stopped is None


# -- bad input


def test_states_are_no_limit_of_this_search() -> None:
    """It counts flights, and has a budget of these."""
    with pytest.raises(ValueError, match="have a budget"):
        search(GUARDED, 12, 5, quiet, Limits(max_states=3))


def test_budget() -> None:
    """A budget is a whole number of flights, from 1 to the most."""
    assert [parse_budget(text) for text in ("1", "200", "100000")] == [1, 200, 100_000]


@pytest.mark.parametrize("text", ["", "0", "100001", "-1", "1.5", "1e3", "many", " 5", "5,5", "9" * 5000])
def test_bad_budget(text: str) -> None:
    """Anything else is refused in one sentence that shows what would be right."""
    with pytest.raises(BadInput, match=r"needs a number of flights from 1 to 100000, such as adversary:200$") as caught:
        parse_budget(text)
    assert len(str(caught.value)) < 200


def test_too_many_rounds() -> None:
    """Flights that are too long to be kept are refused before anything is flown."""
    with pytest.raises(BadInput, match="through 2001 rounds: at most 2000"):
        search(GUARDED, 2001, 5, quiet)
