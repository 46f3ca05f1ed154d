"""The judge: what it measures is what the oracle measures, and each planted bug breaks the claims that it should.

| planted bug | claims that are violated |
| --- | --- |
| the planner forgets one UAV | tracked-separation, lemma-3, theorem-2 |
| it forgets the newer of two entries | tracked-separation, lemma-3, theorem-2, eq-2 |
| it forgets the older one: without losses that is harmless | tracked-separation, lemma-3, theorem-2 |
| it keeps half of d̂_min | tracked-separation, theorem-2; corollary-1 (two CUs) or lemma-3 (one) |
| it takes the plane close to j for a j that is planned, too | tracked-separation, corollary-1, theorem-2, eq-2 |
| it takes the plane midway for every j | none: that plane is the stricter one wherever ‖n_ij‖ ≥ d̂_min |
| it gives up; it says that there is no solution | none: theorem-1 is undecided |
| it lets out what breaks a bound of (13) | theorem-1, the next time |
| it never moves a UAV | arrives |
| a UAV follows the trajectory of another one | lemma-1, theorem-2, eq-2 |
| a CU does not notice that a message is missing | lemma-1, lemma-2 |
| all CUs plan the UAV of the highest priority | one-planner-per-uav |
| `loss_handling=ignore` | lemma-1, lemma-2, plans-from-truth, one-planner-per-uav, tracked-separation, theorem-2 |
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from math import sqrt

import pytest
from tests.dmpc_swarm.flight.flights import (
    Buggy,
    Recording,
    Tamper,
    planner_of,
    record,
    recorded,
    scenario,
    undecided,
    violated,
)
from tests.dmpc_swarm.flight.settings import flown, limits, setting
from tests.dmpc_swarm.planner import oracle
from tests.scenario.points import points

from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.claims.flight import FLIGHT_CLAIMS
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS
from swarmproof.dmpc_swarm.flight import judge
from swarmproof.dmpc_swarm.flight.fly import Plans
from swarmproof.dmpc_swarm.flight.judge import PATIENCE
from swarmproof.dmpc_swarm.flight.run import Setting, fly
from swarmproof.dmpc_swarm.flight.state import Round
from swarmproof.dmpc_swarm.planner.accept import broken_constraint
from swarmproof.dmpc_swarm.planner.outlook import ARRIVED
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker, Update, update_information_trackers
from swarmproof.dmpc_swarm.protocol.messages import CuMessage, Metadata, Trajectory, UavMessage
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import Lattice
from swarmproof.qp.solvers import Status
from swarmproof.scenario.definition import Weights

F = Fraction


# Planted bugs of the planner


def forgets_a_uav(plans: Plans, task: Task) -> Planned:
    """Plan without the trajectories of the last of the other UAVs."""
    last = max(task.others)
    return plans.plan(replace(task, others={j: held for j, held in task.others.items() if j != last}))


def forgets_the_newer_entry(plans: Plans, task: Task) -> Planned:
    """Plan with the first entry of every tracker."""
    return plans.plan(replace(task, others={j: held[:1] for j, held in task.others.items()}))


def forgets_the_older_entry(plans: Plans, task: Task) -> Planned:
    """Plan with the last entry of every tracker."""
    return plans.plan(replace(task, others={j: held[-1:] for j, held in task.others.items()}))


def never_midway(plans: Plans, task: Task) -> Planned:
    """Plan as if no other UAV were planned."""
    return plans.plan(replace(task, selected=frozenset()))


def always_midway(plans: Plans, task: Task) -> Planned:
    """Plan as if every other UAV were planned."""
    return plans.plan(replace(task, selected=frozenset(task.others)))


def gives_up(plans: Plans, task: Task) -> Planned:
    """Find no plan."""
    return replace(plans.plan(task), plan=None, status=Status.GAVE_UP, why="no time")


def calls_it_infeasible(plans: Plans, task: Task) -> Planned:
    """Find that there is no plan."""
    return replace(plans.plan(task), plan=None, status=Status.INFEASIBLE, why="the solver says: infeasible")


def never_moves(plans: Plans, task: Task) -> Planned:
    """Return the old trajectory as a new one."""
    return replace(plans.plan(task), plan=task.own.shifted(task.start))


def _plans_with(*changes: str) -> Callable[[Setting], Plans]:
    """Return what makes a planner that believes in other parameters."""

    def make(what: Setting) -> Plans:
        parameters = what.scenario.parameters.with_changes(changes)
        return Planner(Lattice.of(parameters, what.scenario.horizon), what.scenario.weights)

    return make


def _plans_too_fast(what: Setting) -> Plans:
    """Return a planner that lets out jerks of up to 20 m/s³, and is right about the old trajectories."""
    fast, units = _plans_with("j_max=20")(what), what.flight().lattice

    def plan(plans: Plans, task: Task) -> Planned:
        old = task.own.shifted(task.start)
        as_it_is = Plan(units, old.start, old.state, old.jerks)
        feasible = broken_constraint(as_it_is, task.own, task.planes) is None
        return replace(plans.plan(task), feasible=feasible)

    return Buggy(fast, plan)


def _alters(bug: Callable[[Plans, Task], Planned]) -> Callable[[Setting], Plans]:
    """Return what makes a planner with this bug."""
    return lambda what: Buggy(planner_of(what), bug)


# Planted bugs of the flight and of the protocol


def follows_another(round_: Round) -> Round:
    """Let the next UAV follow the trajectory that was planned in round 2."""
    k = round_.before.k
    if k != 2:
        return round_
    w, attempt = next((w, one) for w, one in enumerate(round_.computed.attempts) if one is not None)
    assert attempt.planned.plan is not None
    uavs = list(round_.after.swarm.uavs)
    j = (attempt.task.i + 1) % len(uavs)
    uavs[j] = replace(uavs[j], followed=Trajectory(Metadata(k, w)))
    plans = {**round_.after.plans, (j, Metadata(k, w)): attempt.planned.plan}
    swarm = replace(round_.after.swarm, uavs=tuple(uavs))
    return replace(round_, after=replace(round_.after, swarm=swarm, plans=plans))


def misses_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out lines 17 to 19 of Algorithm 2: a missing message of a CU is not noticed."""

    def update(
        uav_messages: Mapping[int, UavMessage],
        cu_messages: Mapping[int, CuMessage],
        trackers: Sequence[InformationTracker],
        cus: int,
        semantics: Semantics,
    ) -> Update:
        return update_information_trackers(uav_messages, cu_messages, trackers, len(cu_messages), semantics)

    monkeypatch.setattr(algorithm1, "update_information_trackers", update)


def all_plan_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every CU select the UAV of the highest priority, not each another one."""
    monkeypatch.setattr(algorithm1, "select_uav", lambda a_et, k, w, cus: a_et[0])


def as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Change nothing."""


@dataclass(frozen=True)
class Case:
    """A bug and a flight in which it must show.

    Attributes:
        violated: the claims that it must violate.
        undecided: the claims that it must leave undecided.
        spared: claims that it must not violate: the bug is no matter of theirs.
        plans: makes the planner.
        tamper: changes rounds.
        patch: changes the protocol.
    """

    violated: set[str]
    scenario: str
    cus: int
    loss: str = "none"
    rounds: int = 30
    uavs: int | None = None
    semantics: str = "guarded"
    spared: tuple[str, ...] = ("lemma-1", "lemma-2", "theorem-1", "arrives")
    plans: Callable[[Setting], Plans] = planner_of
    tamper: Tamper | None = None
    patch: Callable[[pytest.MonkeyPatch], None] = as_it_is
    undecided: tuple[str, ...] = ()

    def setting(self) -> Setting:
        """Return what is flown."""
        changes = [] if self.uavs is None else [f"uavs={self.uavs}"]
        return setting(self.scenario, self.cus, 0, changes, semantics=self.semantics)


_APART = {"tracked-separation", "theorem-2"}

CASES = {
    "forgets a UAV": Case(_APART | {"lemma-3"}, "circle", 3, uavs=8, plans=_alters(forgets_a_uav)),
    "forgets the newer entry": Case(
        _APART | {"lemma-3", "eq-2"}, "crossing", 1, plans=_alters(forgets_the_newer_entry)
    ),
    "forgets the older entry": Case(
        _APART | {"lemma-3"}, "crossing", 2, loss="iid:0.1", plans=_alters(forgets_the_older_entry)
    ),
    "half the distance, one CU": Case(_APART | {"lemma-3"}, "crossing", 1, plans=_plans_with("d_hat_min=0.125")),
    "half the distance": Case(_APART | {"corollary-1"}, "crossing", 2, plans=_plans_with("d_hat_min=0.125")),
    "never midway": Case(_APART | {"corollary-1", "eq-2"}, "crossing", 2, plans=_alters(never_midway)),
    "gives up": Case(set(), "crossing", 2, plans=_alters(gives_up), undecided=("theorem-1",)),
    "calls it infeasible": Case(set(), "crossing", 2, plans=_alters(calls_it_infeasible), undecided=("theorem-1",)),
    "too fast": Case({"theorem-1"}, "crossing", 1, spared=(*_APART, "lemma-3"), plans=_plans_too_fast),
    "never moves": Case({"arrives"}, "crossing", 1, rounds=104, spared=tuple(_APART), plans=_alters(never_moves)),
    "follows another": Case(
        {"lemma-1", "theorem-2", "eq-2"}, "circle", 1, uavs=4, spared=("theorem-1",), tamper=follows_another
    ),
    "misses nothing": Case(
        {"lemma-1", "lemma-2"}, "circle", 2, loss="iid:0.2", uavs=4, spared=("arrives",), patch=misses_nothing
    ),
    "all plan the first": Case(
        {"one-planner-per-uav"}, "circle", 2, uavs=4, spared=("same-selection",), patch=all_plan_the_first
    ),
    "ignores losses": Case(
        _APART | {"lemma-1", "lemma-2", "plans-from-truth", "one-planner-per-uav"},
        "crossing",
        2,
        loss="iid:0.3",
        semantics="ignore-loss",
        spared=("arrives",),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_planted_bugs_are_caught(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each planted bug violates the claims that the table at the top names, and not those that it must not."""
    case = CASES[name]
    case.patch(monkeypatch)
    what = case.setting()
    claims = record(what, case.loss, case.rounds, case.plans(what), case.tamper).flown.claims
    found = violated(claims)
    assert found >= case.violated
    assert not found & set(case.spared)
    assert undecided(claims) == set(case.undecided)


@pytest.mark.parametrize("name", [name for name, case in CASES.items() if case.semantics == "guarded"])
def test_without_the_bug_nothing_is_violated(name: str) -> None:
    """In the same flights, without the bugs, no claim is violated: it is the bug that shows."""
    case = CASES[name]
    recording = recorded(case.scenario, case.cus, case.loss, case.rounds, uavs=case.uavs)
    assert violated(recording.flown.claims) == set()


@pytest.mark.parametrize("what", [("crossing", 1, None), ("crossing", 2, None), ("circle", 3, 5)])
@pytest.mark.parametrize("bug", [always_midway, forgets_the_older_entry])
def test_some_bugs_are_harmless(bug: Callable[[Plans, Task], Planned], what: tuple[str, int, int | None]) -> None:
    """The plane midway is stricter than the other one; and without losses the older entry is never flown again."""
    name, cus, uavs = what
    flying = setting(name, cus, 0, [] if uavs is None else [f"uavs={uavs}"])
    assert violated(record(flying, "none", 30, Buggy(planner_of(flying), bug)).flown.claims) == set()


# What is measured


#: Flights with various things going on: violations, losses, deprecated trackers.
MEASURED = [
    ("crossing", 2, "iid:0.3", 30, 0, "ignore-loss", None),
    ("circle", 3, "iid:0.1", 12, 0, "guarded", 8),
    ("random", 2, "burst:0.05,0.3", 14, 4, "guarded", None),
]
measured = pytest.mark.parametrize("what", MEASURED, ids=lambda what: f"{what[0]}-{what[5]}")
What = tuple[str, int, str, int, int, str, int | None]


@cache
def _as_flown(plan: Plan) -> oracle.Flown:
    return flown(plan)


def followed(recording: Recording, k: int) -> list[oracle.Flown]:
    """Return the references of all UAVs in round k, in SI units."""
    before = recording.rounds[k].before
    return [_as_flown(before.followed(i)) for i in range(len(before.swarm.uavs))]


def squares(recording: Recording, k: int, time: Fraction) -> list[Fraction]:
    """Return the squared distances of all pairs of references in round k at a time of it, by the oracle."""
    bounds = limits(recording.flight.lattice)
    references = followed(recording, k)
    return [
        oracle.squared_distance(one, other, time, bounds)
        for n, one in enumerate(references)
        for other in references[:n]
    ]


@measured
def test_separations_are_the_oracles(what: What) -> None:
    """The sampled separation is the least at samples; the bound at all times is below every distance, and tight."""
    recording = recorded(*what)
    result, units = recording.flown, recording.flight.lattice
    T, T_c, m = units.parameters.T_s, units.parameters.T_c, units.steps
    at_samples = [min(squares(recording, k, k * T + h * T_c)) for k in range(result.rounds) for h in range(m)]
    assert result.sampled == sqrt(min(at_samples))
    assert 0 < result.continuous_lower <= result.sampled
    pair, time = result.closest_pair
    k = int(time / float(T) + 1e-9)
    one, other = (followed(recording, k)[i] for i in pair)
    nearest = sqrt(oracle.squared_distance(one, other, F(time), limits(units)))
    assert result.continuous_lower == pytest.approx(nearest, rel=1e-6)
    # bounds of each step, against the oracle at three instants of it
    assert result.band.shape == (result.rounds * m, 2)
    for step, (lower, upper) in enumerate(result.band):
        exact = [min(squares(recording, step // m, (step + F(n, 2)) * T_c)) for n in range(3)]
        # the band is rounded to nearest: three roundings
        assert lower**2 <= float(min(exact)) * (1 + 2.0**-49)
        assert lower <= upper <= sqrt(min(exact[0], exact[-1])) * (1 + 2.0**-40)
    assert result.band[:, 0].min() <= result.continuous_lower <= result.band[:, 1].min() * (1 + 2.0**-49)


def test_a_late_approach_is_found_where_it_is() -> None:
    """If the UAVs come close after many rounds only, place and time of it are those of that round."""
    a, b = points((-0.6, 0.0, 1.0), (0.6, 0.05, 1.0))
    recording = record(setting(scenario([a, b], {0: [a, b], 70: [b, a]}), 1), "none", 90)
    result, units = recording.flown, recording.flight.lattice
    _, time = result.closest_pair
    k = int(time / float(units.parameters.T_s) + 1e-9)
    assert k >= 70
    assert result.continuous_lower == pytest.approx(sqrt(squares(recording, k, F(time))[0]), rel=1e-6)
    assert len(result.band) == 90 * units.steps
    assert int(result.band[:, 0].argmin()) // units.steps == pytest.approx(k, abs=1)


@measured
def test_messages_and_programs_are_counted(what: What) -> None:
    """Every lost message is counted, and every attempt to plan is one kind of outcome."""
    recording = recorded(*what)
    result = recording.flown
    assert result.rounds == len(recording.rounds) == what[3]
    lost = [got.lost for round_ in recording.rounds for got in (*round_.at_cus, *round_.at_uavs)]
    assert result.lost == sum(lost) > 0
    attempts = [one for round_ in recording.rounds for one in round_.computed.attempts if one is not None]
    assert result.qps.solved == sum(one.planned.plan is not None for one in attempts) > 0
    assert result.qps.rejected + result.qps.infeasible == len(attempts) - result.qps.solved


def test_why_there_is_no_plan_is_counted() -> None:
    """A planner that gives up is no planner that says: infeasible."""
    flying = setting("crossing", 2)
    for bug, rejected, infeasible in ((gives_up, 10, 0), (calls_it_infeasible, 0, 10)):
        counts = record(flying, "none", 5, Buggy(planner_of(flying), bug)).flown.qps
        assert (counts.solved, counts.rejected, counts.infeasible) == (0, rejected, infeasible)


@measured
def test_every_claim_is_judged_once(what: What) -> None:
    """All safety claims of the protocol and all claims about flights are judged, and none of them is said to hold."""
    judged = recorded(*what).flown.claims
    asked = [claim.id for claim in CLAIMS if claim.is_safety] + [claim.id for claim in FLIGHT_CLAIMS]
    assert [one.claim.id for one in judged] == asked
    for one in judged:
        if one.verdict is Verdict.VIOLATED:
            assert one.why
            assert one.rounds is not None
            assert one.lost is not None
            assert 1 <= one.rounds <= what[3]
            assert one.times >= 1
        else:
            assert (one.rounds, one.lost, one.times, one.chain) == (None, None, 0, ())
            assert one.place is None
            assert (one.verdict is Verdict.NOT_APPLICABLE) == bool(one.why) == (one.instances == 0)
            assert one.verdict is Verdict.NOT_APPLICABLE or one.claim.id != "eq-2-actual"


def test_one_flight_proves_nothing() -> None:
    """Whatever is flown, no claim is said to hold: the judge of a flight does not have that verdict."""
    assert "HOLDS" not in inspect.getsource(judge)
    verdicts = {one.verdict for one in fly(setting("crossing", 2), parse("none", 2, 2, 0), 5)[0].claims}
    assert verdicts == {Verdict.NOT_VIOLATED, Verdict.NOT_APPLICABLE}


def test_a_violation_says_when_it_was_first_seen() -> None:
    """Rounds and losses count up to the end of the first round that breaks the claim, `times` all such rounds."""
    flying = setting("crossing", 2)

    def late(plans: Plans, task: Task) -> Planned:
        planned = plans.plan(task)
        return replace(gives_up(plans, task), feasible=False) if task.k >= 3 else planned

    recording = record(flying, "iid:0.2", 20, Buggy(planner_of(flying), late))
    (judged,) = (one for one in recording.flown.claims if one.claim.id == "theorem-1")
    broken = [
        round_.before.k + 1
        for round_ in recording.rounds
        if any(one is not None and one.planned.plan is None for one in round_.computed.attempts)
    ]
    assert judged.rounds == broken[0] > 3
    assert judged.times == len(broken)
    seen = [round_ for round_ in recording.rounds if round_.before.k < broken[0]]
    assert judged.lost == sum(got.lost for round_ in seen for got in (*round_.at_cus, *round_.at_uavs)) > 0
    assert judged.why.startswith("CU ")
    assert "breaks (13)" in judged.why
    assert judged.place is not None
    assert judged.place.round == broken[0] - 1


def test_a_planner_without_plans_is_a_limit_of_ours() -> None:
    """It is said of how many feasible problems no plan came out, of which first, and why; some plans are no excuse."""
    flying = setting("crossing", 2)

    def late(plans: Plans, task: Task) -> Planned:
        return gives_up(plans, task) if task.k >= 10 else plans.plan(task)

    recording = record(flying, "none", 15, Buggy(planner_of(flying), late))
    flown = recording.flown
    tried = [
        (round_.before.k, w, one.task.i, one.planned.plan is None)
        for round_ in recording.rounds
        for w, one in enumerate(round_.computed.attempts)
        if one is not None
    ]
    unsolved = [one for one in tried if one[-1]]
    (k, w, i, _) = unsolved[0]
    assert 0 < len(unsolved) < len(tried)
    (judged,) = (one for one in flown.claims if one.claim.id == "theorem-1")
    assert judged.verdict is Verdict.UNDECIDED
    assert flown.undecided
    assert not flown.violated
    said = (
        f"our planner found no plan in {len(unsolved)} of {len(tried)} feasible problems (first in round {k}, CU {w} "
    )
    assert judged.why == f"{said}for UAV {i}: no time)"


# Arrival


def _away(recording: Recording) -> list[bool]:
    """Return after each round whether some UAV is more than 5 cm from its target, in exact arithmetic."""
    flying, units = recording.flight.scenario, recording.flight.lattice
    away = []
    for round_ in recording.rounds:
        k = round_.before.k
        places = [
            _as_flown(round_.after.followed(i)).position((k + 1) * units.parameters.T_s) for i in range(flying.uavs)
        ]
        squared = [
            sum((a - F(b)) ** 2 for a, b in zip(place, target, strict=True))
            for place, target in zip(places, flying.targets_at(k), strict=True)
        ]
        away.append(max(squared) > F(ARRIVED) ** 2)
    return away


def test_arrival_counts_from_the_last_change_of_targets() -> None:
    """A flight has arrived when all UAVs were within 5 cm at once; what was before the last change does not count."""
    a, b = points((-0.8, 0.0, 1.0), (0.8, 0.3, 1.2))
    swap = scenario([a, b], {0: [a, b], 20: [b, a]})
    recording = record(setting(swap, 2), "none", 60)
    away = _away(recording)
    assert not away[19]
    assert away[20]
    assert recording.flown.arrived
    # there at the end of that round, which is the start of the next one
    assert recording.flown.rounds_to_arrival == away.index(False, 20) + 1 - 20
    short = record(setting(swap, 2), "none", 25)
    assert not short.flown.arrived
    assert short.flown.rounds_to_arrival is None
    assert violated(short.flown.claims) == set()


def test_a_swarm_has_to_arrive_in_time_only_if_it_can() -> None:
    """Late UAVs are no violation before they got 50 new trajectories each; a jammed swarm never gets them."""
    flying = setting("crossing", 1)
    stuck = Buggy(planner_of(flying), never_moves)
    # one CU plans one of two UAVs in each round
    needed = int(2 * PATIENCE)
    for rounds, late in ((needed - 1, False), (needed, True)):
        result = record(flying, "none", rounds, stuck).flown
        assert not result.arrived
        assert ("arrives" in violated(result.claims)) == late
    jammed = record(flying, "jam:0,200", needed, stuck).flown
    assert not jammed.arrived
    assert violated(jammed.claims) == set()


def test_patience_begins_anew_with_new_targets() -> None:
    """Trajectories that were adopted before the targets changed last do not count."""
    a, b, c = points((-0.8, 0.0, 1.0), (0.8, 0.3, 1.2), (0.0, 1.0, 1.0))
    needed = int(2 * PATIENCE)
    moving = setting(scenario([a, b], {0: [b, a], needed - 10: [c, b]}), 1)
    stuck = record(moving, "none", needed + 20, Buggy(planner_of(moving), never_moves)).flown
    assert not stuck.arrived
    assert "arrives" not in violated(stuck.claims)


# Others


def test_weights_do_not_matter_to_safety() -> None:
    """With a cost that is all but speed, nothing is violated: safety rests on constraints, not on the cost."""
    flying = setting("crossing", 2)
    slow = Planner(flying.flight().lattice, Weights(position=1e-6, speed=10.0))
    assert violated(record(flying, "iid:0.1", 30, slow).flown.claims) == set()


def test_the_time_of_a_collision_is_in_its_round() -> None:
    """A violation of eq. (2) names two trajectories that are that close at that time."""
    recording = recorded("random", 2, "iid:0.3", 30, 0, "ignore-loss")
    (judged,) = (one for one in recording.flown.claims if one.claim.id == "eq-2")
    assert judged.verdict is Verdict.VIOLATED
    assert f"{recording.flown.continuous_lower:.6g} m apart" in judged.why
    assert judged.chain[-1].endswith(f"{recording.flown.continuous_lower:.4f} m apart (scaled).")
