"""How an approach came about: every sentence of the chain is true of the recorded rounds, and says what matters."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from math import sqrt

import pytest
from tests.dmpc_swarm.flight.flights import Buggy, Recording, losses_in, planner_of, record, recorded
from tests.dmpc_swarm.flight.flights import losses as losses_of
from tests.dmpc_swarm.flight.settings import broken, flown, limits, setting
from tests.dmpc_swarm.flight.test_judge import forgets_the_older_entry
from tests.dmpc_swarm.flight.test_separation_at_samples import observed
from tests.dmpc_swarm.planner import oracle

from swarmproof.dmpc_swarm.claims.flight import Approach, PlannedBy
from swarmproof.dmpc_swarm.flight.chain import explain
from swarmproof.dmpc_swarm.flight.state import Attempt, Name, Round
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.protocol.messages import Metadata, TrajectoryMessage
from swarmproof.faults.losses import Recorded
from swarmproof.faults.pattern import nothing_lost
from swarmproof.motion.lattice import Lattice

F = Fraction
#: Scenario, CUs, loss, rounds, seed, semantics, UAVs.
What = tuple[str, int, str, int, int, str, int | None]


@dataclass(frozen=True)
class Told:
    """A chain, the rounds that it is about, and the trajectories that came close."""

    units: Lattice
    rounds: Sequence[Round]
    approach: Approach
    chain: Sequence[str]

    @property
    def by_round(self) -> dict[int, Round]:
        """The rounds by number."""
        return {round_.before.k: round_ for round_ in self.rounds}

    @property
    def names(self) -> tuple[Name, Name]:
        """The trajectory that was planned last, and the other one."""
        one, other = ((i, Metadata(*by)) for i, by in zip(self.approach.uavs, self.approach.planned, strict=True))
        return (one, other) if (one[1].round, one[0]) > (other[1].round, other[0]) else (other, one)

    def plan(self, name: Name) -> Plan:
        """Return what a name stands for."""
        for round_ in self.rounds:
            for plans in (round_.before.plans, round_.after.plans):
                if name in plans:
                    return plans[name]
            if name[1].round == round_.before.k:
                attempt = round_.computed.attempts[name[1].cu]
                if attempt is not None and attempt.planned.plan is not None and attempt.task.i == name[0]:
                    return attempt.planned.plan
        raise AssertionError(f"nobody has heard of {name}")


def read_name(uav: str, words: str) -> Name:
    """Return the trajectory that is called `words`."""
    if words == "hovering":
        return int(uav), Metadata(-1, -1)
    match = re.fullmatch(r"planned in round (\d+) by CU (\d+)", words)
    assert match is not None, words
    return int(uav), Metadata(int(match[1]), int(match[2]))


@cache
def as_flown(plan: Plan) -> oracle.Flown:
    """Return the plan as the oracle takes it."""
    return flown(plan)


@cache
def broken_by(attempt: Attempt) -> list[str]:
    """Return what the new plan breaks of (13), by the oracle."""
    assert attempt.planned.plan is not None
    return broken(attempt.planned.plan, attempt.task)


def nearest(units: Lattice, plan: Plan, others: Sequence[Plan]) -> float:
    """Return how close `plan` comes to the others at its samples (m), by the oracle."""
    times = [plan.start * units.parameters.T_s + h * units.parameters.T_c for h in range(limits(units).h_c + 1)]
    return sqrt(
        min(
            oracle.squared_distance(as_flown(plan), as_flown(other), time, limits(units))
            for other in others
            for time in times
        )
    )


# What each sentence says; each function asserts that it is true


def losses(told: Told, text: str) -> None:
    """Each loss is one; none is left out that kept the planning CU from knowing, or a UAV from its plan."""
    one, other = told.names
    w, k = one[1].cu, one[1].round
    needed = set()
    for r in range(max(other[1].round, min(told.by_round)), k):
        got = told.by_round[r].at_cus[w]
        needed |= {(r, f"CU {w}", f"the message in CU {slot}'s slot") for slot in got.lost_slots}
        needed |= {(r, f"CU {w}", f"the metadata of UAV {i}") for i in got.lost_uavs if i in (one[0], other[0])}
    for i, (r, cu) in (one, other):
        if r in told.by_round and cu in told.by_round[r].at_uavs[i].lost_slots:
            needed.add((r, f"UAV {i}", f"CU {cu}'s message"))
    real = {
        (r, f"UAV {i}", f"CU {slot}'s message")
        for r, round_ in told.by_round.items()
        for i, got in enumerate(round_.at_uavs)
        for slot in got.lost_slots
    }
    needed |= behind(told)
    said = set()
    for part in text.split("; ") if text != "none that concerns these trajectories" else []:
        match = re.fullmatch(r"in round (\d+), ((?:CU|UAV) \d+) does not get (.+)", part)
        assert match is not None, part
        said |= {(int(match[1]), match[2], what) for what in match[3].split(" and ")}
    assert needed <= said <= needed | real


def unheard(told: Told) -> list[tuple[int, Name]]:
    """Return the planning CU, and the trajectories that it should know and does not hold, by the recorded states."""
    one, other = told.names
    before = told.by_round[one[1].round].before
    follows = [(i, before.swarm.uavs[i].followed.metadata) for i in (one[0], other[0])]
    older = [other] if other[1].round < one[1].round else []
    held = before.swarm.cus[one[1].cu].trackers
    return [
        (one[1].cu, (i, metadata))
        for i, metadata in [*follows, *older]
        if metadata not in [entry.metadata for entry in held[i].trajectories]
    ]


def behind(told: Told) -> set[tuple[int, str, str]]:
    """Return the losses that made an assumption stale, however long ago: of a plan, or of the priorities."""
    one, other = told.names
    found = set()
    for w, (_, (r, cu)) in unheard(told):
        if r in told.by_round and cu in told.by_round[r].at_cus[w].lost_slots:
            found.add((r, f"CU {w}", f"the message in CU {cu}'s slot"))
    before = told.by_round.get(one[1].round - 1)
    _, held = one, told.by_round[one[1].round].before.swarm.cus[one[1].cu].trackers[other[0]].trajectories
    if before is not None and other[1].round == one[1].round and other[1] not in [entry.metadata for entry in held]:
        for w in (one[1].cu, other[1].cu):
            slots = before.at_cus[w].lost_slots
            found |= {(before.before.k, f"CU {w}", f"the message in CU {slot}'s slot") for slot in slots}
    return found


def never_heard(told: Told, w: str, slot: str, r: str) -> None:
    """The CU lost the very message that had a trajectory that it should know."""
    assert int(slot) in told.by_round[int(r)].at_cus[int(w)].lost_slots
    assert (int(r), int(slot)) in [name[1] for cu, name in unheard(told) if cu == int(w)]


def conflict(told: Told, w: str, r: str, i: str, slot: str) -> None:
    """In the slot with that trajectory, two transmitted, and the CU decoded the reply of this UAV, which is no loss."""
    round_ = told.by_round[int(r)]
    got = round_.at_cus[int(w)]
    assert round_.computed.air.slots[int(slot)].conflict
    assert int(slot) in got.decoded_replies
    assert int(slot) not in got.lost_slots
    assert isinstance(heard := got.inbox.cu_messages[int(slot)], TrajectoryMessage)
    assert heard.uav == int(i)
    assert (int(r), int(slot)) in [name[1] for cu, name in unheard(told) if cu == int(w)]


def dropped(told: Told, w: str, r: str, q: str, instead: str) -> None:
    """The CU heard of the trajectory, held it until then, and holds these instead."""
    (name,) = {name for cu, name in unheard(told) if cu == int(w) and name[1].round == int(r)}
    assert name[1].cu in told.by_round[int(r)].at_cus[int(w)].inbox.cu_messages
    for n in range(int(r) + 1, int(q) + 1):
        held = [e.metadata for e in told.by_round[n].before.swarm.cus[int(w)].trackers[name[0]].trajectories]
        assert (name[1] in held) == (n < int(q))
    assert instead == ", ".join(PlannedBy(*metadata).in_words() for metadata in held)


def beyond_memory(told: Told, w: str, r: str) -> None:
    """The round in which it could have been heard of is forgotten."""
    assert int(r) not in told.by_round
    assert int(r) in [name[1].round for cu, name in unheard(told) if cu == int(w)]


def trackers(told: Told, r: str, w: str, i: str, held: str, flag: str, follows: str) -> None:
    """The CU held these entries, with this flag, and the UAV followed that trajectory."""
    one, other = told.names
    assert (int(r), int(w)) == (one[1].round, one[1].cu)
    assert int(i) in (one[0], other[0])
    before = told.by_round[int(r)].before
    tracker = before.swarm.cus[int(w)].trackers[int(i)]
    assert [read_name(i, words) for words in held.split(", ")] == [
        (int(i), entry.metadata) for entry in tracker.trajectories
    ]
    assert tracker.deprecated == (flag == "deprecated")
    assert read_name(i, follows) == (int(i), before.swarm.uavs[int(i)].followed.metadata)


def unknown(told: Told, w: str, i: str) -> None:
    """What the UAV follows is not among the CU's entries."""
    one, _ = told.names
    before = told.by_round[one[1].round].before
    entries = before.swarm.cus[int(w)].trackers[int(i)].trajectories
    assert int(w) == one[1].cu
    assert before.swarm.uavs[int(i)].followed not in entries


def _other_is_held(told: Told) -> bool:
    one, other = told.names
    entries = told.by_round[one[1].round].before.swarm.cus[one[1].cu].trackers[other[0]].trajectories
    return other[1] in [entry.metadata for entry in entries]


def stale(told: Told, j: str, words: str, w: str, i: str) -> None:
    """The CU did not hold the other trajectory."""
    one, other = told.names
    assert (read_name(j, words), int(w), int(i)) == (other, one[1].cu, one[0])
    assert not _other_is_held(told)


def kept_away(told: Told, w: str, i: str, j: str, words: str) -> None:
    """The CU held the other trajectory, and its plan is on its side of all planes to that UAV."""
    one, other = told.names
    assert (read_name(j, words), int(w), int(i)) == (other, one[1].cu, one[0])
    assert _other_is_held(told)
    attempt = told.by_round[one[1].round].computed.attempts[one[1].cu]
    assert attempt is not None
    assert not [text for text in broken_by(attempt) if text.startswith(f"(15) j={j} ")]


def same_round(told: Told, j: str, v: str, k: str, *selections: str) -> None:
    """Both were planned in this round, and this is whom the two CUs took to be planned."""
    one, other = told.names
    assert (int(j), int(v), int(k)) == (other[0], other[1].cu, one[1].round)
    assert other[1].round == one[1].round
    for w, selection in zip(selections[::2], selections[1::2], strict=True):
        chosen = told.by_round[int(k)].before.swarm.cus[int(w)].a_et
        assert chosen is not None
        assert selection == str(sorted(chosen))
    assert selections[::2] == (str(one[1].cu), str(other[1].cu))


def no_room(told: Told) -> None:
    """Of two CUs that plan in one round, one does not have the other one's UAV in its A_ET(k)."""
    one, other = told.names
    assert one[1].round == other[1].round
    cus = told.by_round[one[1].round].before.swarm.cus
    assert other[0] not in (cus[one[1].cu].a_et or ()) or one[0] not in (cus[other[1].cu].a_et or ())


def priorities(told: Told, r: str, w: str, text: str) -> None:
    """In the round before, one of the two CUs missed these priorities."""
    one, other = told.names
    assert int(r) == one[1].round - 1 == other[1].round - 1
    assert int(w) in (one[1].cu, other[1].cu)
    got = told.by_round[int(r)].at_cus[int(w)]
    expected = {f"does not get the message in CU {slot}'s slot" for slot in got.lost_slots}
    expected |= {f"decodes a UAV's reply in CU {slot}'s slot, without priorities" for slot in got.decoded_replies}
    assert set(text.split(" and ")) == expected


def plan(told: Told, r: str, w: str, i: str, distance: str) -> None:
    """The plan is so far from what the CU knew of, and keeps all that (13) demands."""
    one, _ = told.names
    assert (int(r), int(w), int(i)) == (one[1].round, one[1].cu, one[0])
    attempt = told.by_round[int(r)].computed.attempts[int(w)]
    assert attempt is not None
    known = [held for plans in attempt.task.others.values() for held in plans]
    assert distance == f"{nearest(told.units, told.plan(one), known):.4f}"
    assert broken_by(attempt) == []


def too_old(told: Told, i: str, words: str) -> None:
    """The last plan is the hover at the start, or older than the rounds that are known."""
    one, _ = told.names
    assert read_name(i, words) == one
    assert one[1].round not in told.by_round


def place(told: Told, *said: str) -> None:
    """At this time both trajectories are where it is said, and so far apart."""
    time, *places, distance = said
    for (i, words, *xyz), name in zip((places[:5], places[5:]), told.names, strict=True):
        assert read_name(i, words) == name
        exact = as_flown(told.plan(name)).position(told.approach.time)
        assert xyz == [f"{float(part):.3f}" for part in exact]
    assert time == f"{float(told.approach.time):.3f}"
    one, other = (as_flown(told.plan(name)) for name in told.names)
    square = oracle.squared_distance(one, other, told.approach.time, limits(told.units))
    assert distance == f"{sqrt(square):.4f}"


_NAME = r"(hovering|planned in round \d+ by CU \d+)"
_AT = r"\((-?[\d.]+), (-?[\d.]+), (-?[\d.]+)\) m"
FORMS: list[tuple[str, Callable[..., None]]] = [
    (r"Loss: (.+)\.", losses),
    (
        r"Trackers: in round (\d+), CU (\d+) holds for UAV (\d+): (.+) \((deprecated|not deprecated)\); "
        rf"the UAV follows the one {_NAME}\.",
        trackers,
    ),
    (r"Stale assumption: CU (\d+) does not know what UAV (\d+) follows\.", unknown),
    (
        rf"Stale assumption: UAV (\d+)'s trajectory {_NAME} is not among those that CU (\d+) keeps UAV (\d+) "
        r"away from\.",
        stale,
    ),
    (rf"CU (\d+) did keep UAV (\d+) away from UAV (\d+)'s trajectory {_NAME}\.", kept_away),
    (
        r"UAV (\d+) is planned in the same round, by CU (\d+)\. (?=CU \d+ takes A_ET\((\d+)\))"
        r"CU (\d+) takes A_ET\(\d+\) to be (\[.*\]), CU (\d+) takes it to be (\[.*\])\.",
        same_round,
    ),
    (r"CU (\d+) never heard of it: it lost the message in CU (\d+)'s slot in round (\d+)\.", never_heard),
    (
        r"CU (\d+) never heard of it: in round (\d+), UAV (\d+) transmitted in CU (\d+)'s slot as well, and CU \d+ "
        r"did not decode CU \d+'s message\.",
        conflict,
    ),
    (r"CU (\d+) heard of it in round (\d+); from round (\d+) on it holds (.+) instead\.", dropped),
    (
        r"CU (\d+) could have heard of it in round (-?\d+), which is older than what is remembered of the flight\.",
        beyond_memory,
    ),
    (
        r"Stale assumption: one of them counts on the other UAV's old trajectory, and leaves no room\.",
        no_room,
    ),
    (r"Priorities: in round (\d+), CU (\d+) (.+)\.", priorities),
    (
        r"Plan: in round (\d+), CU (\d+) plans UAV (\d+); to all trajectories that it knows of, the new one keeps "
        r"([\d.]+) m at all samples, as \(13f\) demands\.",
        plan,
    ),
    (rf"UAV (\d+)'s trajectory, {_NAME}, is older than what is remembered of the flight\.", too_old),
    (
        rf"Closest approach: at ([\d.]+) s, UAV (\d+) \({_NAME}\) is at {_AT} and UAV (\d+) \({_NAME}\) is at {_AT}, "
        r"([\d.]+) m apart \(scaled\)\.",
        place,
    ),
]


WHERE = {judge.__name__: n for n, (_, judge) in enumerate(FORMS)}
#: Why a CU does not hold what it should.
WHY = [judge.__name__ for judge in (never_heard, conflict, dropped, beyond_memory)]


def check(told: Told) -> list[str]:
    """Assert that every sentence has one form and is true; return the names of the forms, in order."""
    forms = []
    for line in told.chain:
        matches = [(match, judge) for form, judge in FORMS if (match := re.fullmatch(form, line))]
        assert len(matches) == 1, line
        match, judge = matches[0]
        judge(told, *match.groups())
        forms.append(judge.__name__)
    return forms


@cache
def stories(what: What, remembered: int = 1000) -> list[Told]:
    """Return the chain of the closest approach in trackers after each round, and of that of the references."""
    recording = recorded(*what)
    units, told = recording.flight.lattice, []
    for n, seen in enumerate(observed(recording)):
        rounds = recording.rounds[max(0, n + 1 - remembered) : n + 1]
        for approach in (seen.learned, seen.flown):
            if approach is not None:
                told.append(Told(units, rounds, approach, explain(units, rounds, approach)))
    return told


FLIGHTS: list[What] = [
    ("crossing", 2, "iid:0.3", 12, 0, "ignore-loss", None),
    ("crossing", 1, "iid:0.3", 12, 1, "guarded", None),
    ("circle", 3, "iid:0.15", 7, 2, "guarded", 4),
    ("circle", 2, "iid:0.3", 8, 0, "ignore-loss", 4),
    ("circle", 3, "iid:0.2", 8, 1, "printed", 4),
]


@cache
def checked(what: What) -> list[list[str]]:
    """Return the forms of all chains of a flight, after asserting that they are true."""
    return [check(told) for told in stories(what)]


@pytest.mark.parametrize("what", FLIGHTS, ids=lambda what: f"{what[0]}-{what[1]}-{what[5]}")
def test_every_sentence_is_true(what: What) -> None:
    """Whatever came close in a flight, each sentence of its chain is true of the rounds, and the place comes last."""
    assert len(checked(what)) > 10
    for forms in checked(what):
        if forms[0] == "too_old":
            assert forms == ["too_old", "place"]
        else:
            assert [form for form in forms if form not in ("unknown", *WHY)][:3] == ["losses", "trackers", "trackers"]
            for n, form in enumerate(forms):
                # of one trajectory, the reason is given once
                assert (
                    form not in ("unknown", "stale")
                    or forms[n + 1] in WHY
                    or (form, forms[n - 1] in WHY) == ("stale", True)
                )
            assert forms[-2:] == ["plan", "place"]


def test_all_sentences_are_needed() -> None:
    """In these flights, every kind of sentence occurs."""
    said = {form for what in FLIGHTS for forms in checked(what) for form in forms}
    assert said | {"beyond_memory"} == {judge.__name__ for _, judge in FORMS}


def test_hovering_trajectories_have_no_story() -> None:
    """Of UAVs that both hover since the start there is nothing to tell but where they are."""
    jammed = ("crossing", 2, "jam:0,5", 3, 0, "guarded", None)
    recording = recorded(*jammed)
    for told in stories(jammed):
        if {planned.round for planned in told.approach.planned} == {-1}:
            assert check(told) == ["too_old", "place"]
            assert "hovering" in told.chain[0]
    units = recording.flight.lattice
    at_start = Approach(F(36, 25), (0, 1), (PlannedBy(-1, -1), PlannedBy(-1, -1)), F(0))
    told = Told(units, recording.rounds, at_start, explain(units, recording.rounds, at_start))
    assert check(told) == ["too_old", "place"]
    assert "(-0.600, 0.000, 1.000) m" in told.chain[1]


def test_forgotten_rounds_are_no_reason() -> None:
    """If the round of the last plan is forgotten, that is said; what is remembered is still told truly."""
    forgotten = 0
    baseline = ("crossing", 2, "jam:3,10", 30, 0, "ignore-loss", None)
    assert any("beyond_memory" in check(told) for told in stories(baseline, remembered=2))
    for told in stories(("crossing", 2, "iid:0.3", 30, 1, "guarded", None), remembered=2):
        forms = check(told)
        forgotten += forms == ["too_old", "place"]
        assert told.names[0][1].round in told.by_round or forms == ["too_old", "place"]
    assert forgotten > 3


def test_chains_of_violated_claims() -> None:
    """Every violated claim about two trajectories has its chain, made of true sentences; that of eq. (2), too."""
    recording = recorded("random", 2, "iid:0.3", 30, 0, "ignore-loss")
    seen = {}
    for judged in recording.flown.claims:
        if not judged.chain:
            continue
        match = re.fullmatch(FORMS[-1][0], judged.chain[-1])
        assert match is not None
        time, i, mine, _, _, _, j, its, *_ = match.groups()
        names = read_name(i, mine), read_name(j, its)
        by = PlannedBy(*names[0][1]), PlannedBy(*names[1][1])
        # the time of eq. (2) is no decimal; its place is checked below
        exact = F(recording.flown.closest_pair[1]) if judged.claim.id == "eq-2" else F(time)
        approach = Approach(F(0), (names[0][0], names[1][0]), by, exact)
        assert judged.rounds is not None
        rounds = recording.rounds if judged.claim.id == "eq-2" else recording.rounds[: judged.rounds]
        forms = check(Told(recording.flight.lattice, rounds, approach, judged.chain))
        seen[judged.claim.id] = forms
    assert set(seen) == {"theorem-2", "eq-2"}
    assert all((forms[0] == "losses" and "stale" in forms) or "unknown" in forms for forms in seen.values())
    pair, time_of_dip = recording.flown.closest_pair
    assert {f"UAV {i}" for i in pair} <= set(re.findall(r"UAV \d+", seen_line(recording, "eq-2")))
    assert f"at {time_of_dip:.3f} s" in seen_line(recording, "eq-2")


def seen_line(recording: Recording, claim: str) -> str:
    """Return the last sentence of the chain of a claim."""
    return next(judged.chain[-1] for judged in recording.flown.claims if judged.claim.id == claim)


def _forgetting() -> Sequence[str]:
    """Return the chain of a plan that does not keep away from UAV 1's hover, to which its CU holds a plan as well."""
    what = setting("crossing", 1)
    missed = losses_of(2, 1, at_uavs=[(1, 0)])
    model = Recorded([nothing_lost(2, 1), missed], 2, 1)
    recording = record(what, model, 3, Buggy(planner_of(what), forgets_the_older_entry))
    (judged,) = (one for one in recording.flown.claims if one.claim.id == "lemma-3")
    assert judged.rounds == 3
    assert "UAV 1 (hovering)" in judged.chain[-1]
    return judged.chain


def test_a_plan_that_does_not_keep_away_is_not_said_to() -> None:
    """Where the planner is wrong, the chain does not claim that its plan is as (13f) demands."""
    assert not any("did keep" in line or "as (13f) demands" in line for line in _forgetting())


def test_a_missed_plan_is_told() -> None:
    """If the other UAV is still on its old trajectory since it missed a new one, that loss is in the chain."""
    assert "in round 1, UAV 1 does not get CU 0's message" in _forgetting()[0]


@pytest.mark.parametrize("what", [what for what in FLIGHTS if what[5] == "ignore-loss"], ids=lambda what: what[0])
def test_without_the_loss_that_is_blamed_the_tracker_is_not_stale(what: What) -> None:
    """Flown again with every loss but that one, the CU holds the trajectory in the next round."""
    scenario, cus, _, _, seed, semantics, uavs = what
    recording = recorded(*what)
    blamed = {
        (int(r), int(w), int(slot), name)
        for told in stories(what)
        for line in told.chain
        if (match := re.fullmatch(FORMS[WHERE["never_heard"]][0], line))
        for w, slot, r in [match.groups()]
        for cu, name in unheard(told)
        if cu == int(w) and name[1] == (int(r), int(slot))
    }
    assert blamed
    for r, w, slot, name in sorted(blamed)[:6]:
        every = [losses_in(recording.rounds).losses(k) for k in range(r + 2)]
        without = every[r].cu_slot.copy()
        without[w, slot] = False
        every[r] = replace(every[r], cu_slot=without)
        all_losses = Recorded(every, len(recording.rounds[0].at_uavs), cus)
        changes = [] if uavs is None else [f"uavs={uavs}"]
        again = record(setting(scenario, cus, seed, changes, semantics=semantics), all_losses, r + 2)
        for rounds, knows in ((again.rounds, True), (recording.rounds, False)):
            held = rounds[r + 1].before.swarm.cus[w].trackers[name[0]].trajectories
            assert (name[1] in [entry.metadata for entry in held]) == knows


def test_the_jam_is_found_in_every_chain() -> None:
    """No chain of the baseline in a jam says that nothing was lost: each looks back to the loss that made it stale."""
    recording = recorded("crossing", 2, "jam:3,10", 20, 0, "ignore-loss")
    chains = [judged.chain for judged in recording.flown.claims if judged.chain]
    assert len(chains) >= 3
    for chain in chains:
        assert chain[0].startswith("Loss: in round ")
        assert any("never heard of it: it lost" in line for line in chain)
