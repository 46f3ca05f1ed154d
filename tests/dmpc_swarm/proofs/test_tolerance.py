"""Claims about numerical tolerance: verdicts, that nothing else would pass, and the same told by a swarm on a line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import NamedTuple

import pytest

from swarmproof.algebra.statement import Condition, Sign, Solvable, Statement
from swarmproof.claims.proof import ProofVerdict, Question
from swarmproof.dmpc_swarm.evidence.tolerance import EVIDENCE
from swarmproof.dmpc_swarm.proofs.terms.cells import cells
from swarmproof.dmpc_swarm.proofs.terms.tolerance import DRIFT
from swarmproof.dmpc_swarm.proofs.tolerance import CLAIMS
from swarmproof.prove.decide import answer, decide
from swarmproof.prove.evidence import Candidate, Certificate, Evidence, Unsolvable, Vectors

BY_KEY = {claim.key: claim for claim in CLAIMS}
BOTH_READINGS = sorted(
    claim.id for claim in CLAIMS if f"{claim.id}/printed" in BY_KEY and f"{claim.id}/repaired" in BY_KEY
)
D, EPSILON = Fraction(1), Fraction(1, 10)


@pytest.mark.parametrize("key", BY_KEY)
def test_every_claim_comes_to_the_verdict_on_record(key: str) -> None:
    """Each claim is decided as recorded, each of its questions by its own evidence, and none is left over."""
    found = decide(BY_KEY[key], EVIDENCE[key])
    assert found.as_recorded, [one.why for one in found.answers]
    assert all(one.verdict is not ProofVerdict.UNDECIDED for one in found.answers)


def test_evidence_is_about_claims_that_exist() -> None:
    """There is no evidence for another claim, and every repaired claim is proved, every printed one false."""
    assert set(EVIDENCE) == set(BY_KEY)
    for claim in CLAIMS:
        expected = ProofVerdict.FALSE if claim.reading.value == "printed" else ProofVerdict.PROVED
        assert claim.verdict is expected, claim.key


@pytest.mark.parametrize("name", BOTH_READINGS)
@pytest.mark.parametrize(("of", "to"), [("printed", "repaired"), ("repaired", "printed")])
def test_evidence_does_not_serve_the_other_reading(name: str, of: str, to: str) -> None:
    """No evidence for one reading decides the other one, so that neither can be put in the place of the other."""
    wrong = [*EVIDENCE[f"{name}/{of}"].values()]
    right = EVIDENCE[f"{name}/{to}"]
    for question, asked in BY_KEY[f"{name}/{to}"].questions.items():
        if to == "printed" and isinstance(right[question], Certificate):
            continue  # two old trajectories: (20) is the conclusion
        verdicts = {answer(question, asked, evidence).verdict for evidence in wrong}
        assert right_verdict(asked, right[question]) not in verdicts, question
        assert not verdicts - {ProofVerdict.UNDECIDED}, question


def right_verdict(asked: Question, evidence: Evidence) -> ProofVerdict:
    """Return the verdict of a question by evidence that checks."""
    verdict = answer("", asked, evidence).verdict
    assert verdict is not ProofVerdict.UNDECIDED
    return verdict


def test_the_table_is_complete() -> None:
    """All 21 pairs are in the statements about distance; those without a plan are the ones with a UAV that flies on."""
    ids = {cell.id for cell in cells()}
    assert len(ids) == 21
    assert ids == set(BY_KEY["tolerance-distance/printed"].questions)
    assert ids == set(BY_KEY["tolerance-distance/repaired"].questions)
    assert ids < set(BY_KEY["tolerance-feasible/repaired"].questions)
    assert set(BY_KEY["tolerance-no-plan/repaired"].questions) == {
        i for i in ids if set(i.split("-")) & {"Po", "S1", "S2"}
    }


def planted() -> Iterator[tuple[str, str, str, Question]]:
    """Yield claim, question, what is wrong, and the question with a mistake that its evidence must not survive."""
    for key, claim in BY_KEY.items():
        for name, asked in claim.questions.items():
            for error, wrong in _mistakes(asked, EVIDENCE[key][name]):
                yield key, name, error, wrong


def _mistakes(asked: Question, evidence: Evidence) -> Iterator[tuple[str, Question]]:
    match asked, evidence:
        case Statement(), Certificate():
            used = {*evidence.equations, *(n for t in (*evidence.terms, *evidence.multiplier) for n in t.hypotheses)}
            for hypothesis in asked.hypotheses:
                if hypothesis.name in used:
                    yield f"without {hypothesis.name}", asked.without(hypothesis.name)
                    yield f"{hypothesis.name}, other sign", _with(asked, replace(hypothesis, value=-hypothesis.value))
            conclusion = asked.conclusion
            yield "more is concluded", replace(asked, conclusion=replace(conclusion, value=conclusion.value - 1))
            yield "the opposite is concluded", replace(asked, conclusion=replace(conclusion, value=-conclusion.value))
        case Statement(), Vectors():
            conclusion = asked.conclusion
            yield "the opposite is concluded", replace(asked, conclusion=replace(conclusion, value=-conclusion.value))
            for hypothesis in asked.hypotheses:
                if hypothesis.sign is not Sign.EQUAL:
                    yield f"{hypothesis.name}, too strong", _with(asked, _stronger(hypothesis, evidence))
        case Solvable(), Candidate():
            for place, constraint in enumerate(asked.constraints):
                wrong = [*asked.constraints]
                wrong[place] = replace(constraint, value=constraint.value - 1)
                yield f"{constraint.name}, too strong", replace(asked, constraints=tuple(wrong))
        case Solvable(), Unsolvable():
            for constraint in asked.constraints:
                others = tuple(one for one in asked.constraints if one is not constraint)
                yield f"without {constraint.name}", replace(asked, constraints=others)
                weaker = replace(constraint, value=constraint.value + 1)
                yield f"{constraint.name}, too weak", replace(asked, constraints=(*others, weaker))
        case _:
            raise AssertionError("evidence of another kind")


def _with(statement: Statement, changed: Condition) -> Statement:
    others = tuple(one for one in statement.hypotheses if one.name != changed.name)
    return replace(statement, hypotheses=(*others, changed))


def _stronger(hypothesis: Condition, vectors: Vectors) -> Condition:
    """Return the hypothesis by so much stronger that the vectors do not satisfy it."""
    return replace(hypothesis, value=hypothesis.value - hypothesis.value.at(vectors.values) - 1)


def test_planted_errors_leave_questions_undecided() -> None:
    """A dropped hypothesis, a sign, a stronger conclusion: evidence on file decides none of them."""
    tried = 0
    for key, name, error, wrong in planted():
        tried += 1
        assert answer(name, wrong, EVIDENCE[key][name]).verdict is ProofVerdict.UNDECIDED, (key, name, error)
    assert tried > 500


class Uav(NamedTuple):
    """A UAV on a line: the entries of its tracker, and which of them it follows.

    A trajectory is the places at the samples from now on, one a round (T = T_c), the last for ever.
    """

    entries: tuple[tuple[Fraction, ...], ...]
    follows: int

    @property
    def followed(self) -> tuple[Fraction, ...]:
        """The trajectory that it follows."""
        return self.entries[self.follows]


class Tolerances(NamedTuple):
    """By how much rows of (15) may be violated."""

    halfway: Fraction
    full: Fraction


class Step(NamedTuple):
    """What becomes of two UAVs in a round; `refused`: how many problems had no solution."""

    left: Uav
    right: Uav
    refused: int


SAMPLES = 4
#: Long enough for each UAV to be planned three times.
ROUNDS = 5
HEARD = ((True, True), (True, False), (False, True), (False, False))


def hover(place: Fraction | int) -> Uav:
    """Return a UAV that hovers."""
    return Uav(((Fraction(place),) * SAMPLES,), 0)


def shifted(places: tuple[Fraction, ...]) -> tuple[Fraction, ...]:
    """Return a trajectory a round later."""
    return (*places[1:], places[-1])


def greedy(own: Uav, other: Uav, halfway: bool, tolerances: Tolerances) -> tuple[Fraction, ...] | None:
    """Return the plan nearest to the other UAV that (13f) with tolerance accepts; None if it accepts none.

    Everything is one round later than now. `own` has one entry, and the other UAV is on the side of larger places.
    """
    old = shifted(own.followed)
    others = [shifted(entry) for entry in other.entries]
    places = []
    for h in range(SAMPLES):
        highest = []
        for entry in others:
            normal = entry[h] - old[h]
            # places grow towards the other UAV: n_0 = 1
            assert normal > 0
            room = (D + normal) / 2 - tolerances.halfway if halfway else D - tolerances.full
            highest.append(entry[h] - room)
        if h == 0 and old[0] > min(highest):
            return None  # (13b): it begins where it is
        places.append(old[0] if h == 0 else min(highest))
    return tuple(places)


def mirrored(uav: Uav) -> Uav:
    """Return the UAV on the line seen from the other side."""
    return Uav(tuple(tuple(-x for x in entry) for entry in uav.entries), uav.follows)


def fly(left: Uav, right: Uav, selected: str, heard: tuple[bool, bool], tolerances: Tolerances) -> Step:
    """Return the UAVs after a round in which those in `selected` (l, r) are in A_ET(k), and who hears of a new plan."""
    plans: list[tuple[Fraction, ...] | None] = [None, None]
    refused = 0
    for place, (own, other, who) in enumerate(((left, right, "l"), (mirrored(right), mirrored(left), "r"))):
        if who in selected and len(own.entries) == 1:
            other_one = "r" if who == "l" else "l"
            plans[place] = greedy(own, other, other_one in selected, tolerances)
            refused += plans[place] is None
    after = []
    for uav, plan, hears, seen_as in ((left, plans[0], heard[0], 1), (right, plans[1], heard[1], -1)):
        # its own message of this round says which trajectory it follows
        known = shifted(uav.followed)
        entries = (known,) if plan is None else (known, tuple(seen_as * x for x in plan))
        after.append(Uav(entries, int(plan is not None and hears)))
    return Step(after[0], after[1], refused)


def smallest(left: Uav, right: Uav) -> Fraction:
    """Return the smallest distance of what the trackers hold, over all samples."""
    return min(b - a for one, other in product(left.entries, right.entries) for a, b in zip(one, other, strict=True))


class Seen(NamedTuple):
    """What all flights have come to: the smallest distance, and how many problems had no solution."""

    nearest: Fraction
    refused: int


def all_flights(rounds: int, tolerances: Tolerances) -> Seen:
    """Return what was seen in all flights, whatever was selected and lost."""
    swarms = {(hover(0), hover(D)), (hover(0), hover(2))}
    nearest = D
    refused = 0
    for _ in range(rounds):
        after = set()
        for (left, right), selected, heard in product(swarms, ("l", "r", "lr"), HEARD):
            step = fly(left, right, selected, heard, tolerances)
            refused += step.refused
            nearest = min(nearest, smallest(step.left, step.right))
            after.add((step.left, step.right))
        swarms = after
    return Seen(nearest, refused)


def test_distance_reaches_the_bound_and_never_falls_below() -> None:
    """Whatever is selected and lost, UAVs that use all of ε come as near as d̂_min − 2ε, and no nearer in any round."""
    seen = all_flights(ROUNDS, Tolerances(EPSILON, EPSILON))
    assert seen.nearest == D - 2 * EPSILON
    assert seen.refused


@pytest.mark.parametrize("ratio", [Fraction(1), Fraction(3, 2), Fraction(2), Fraction(5, 2), Fraction(3)])
def test_feasibility_is_kept_by_one_ratio_only(ratio: Fraction) -> None:
    """No problem is without a solution if full rows have twice the tolerance of halfway rows; else some are."""
    seen = all_flights(ROUNDS, Tolerances(EPSILON, ratio * EPSILON))
    assert (seen.refused == 0) == (ratio == 2)
    assert seen.nearest == D - max(Fraction(2), ratio) * EPSILON


def test_without_tolerance_nothing_is_lost() -> None:
    """With ε = 0 distance stays d̂_min, and every problem has a solution."""
    assert all_flights(ROUNDS, Tolerances(Fraction(0), Fraction(0))) == Seen(D, 0)


def test_the_flight_of_the_documentation() -> None:
    """Both planned, then one alone, for ever: distances 2, 4/5, 4/5, …, and every problem of a UAV alone is refused."""
    left, right = hover(0), hover(2)
    told = []
    for selected in ("lr", "", "l", "lr", "", "r", "lr"):
        step = fly(left, right, selected, (True, True), Tolerances(EPSILON, EPSILON))
        left, right = step.left, step.right
        told.append(
            (selected, right.followed[0] - left.followed[0], right.followed[-1] - left.followed[-1], step.refused)
        )
    near = Fraction(4, 5)
    assert told == [
        ("lr", 2, near, 0),
        ("", near, near, 0),
        ("l", near, near, 1),
        ("lr", near, near, 0),
        ("", near, near, 0),
        ("r", near, near, 1),
        ("lr", near, near, 0),
    ]


@pytest.mark.parametrize(
    ("speed", "acceleration"), [(Fraction(1, 10), Fraction(0)), (Fraction(1, 20), Fraction(1, 100))]
)
def test_drift_is_as_large_as_the_bound(speed: Fraction, acceleration: Fraction) -> None:
    """Two UAVs with jerk 0 that end with speed ε_v and acceleration ε_a towards each other lose just the drift."""
    states = [[Fraction(0), speed, acceleration], [D, -speed, -acceleration]]
    for n in range(1, 6):
        for state in states:
            state[0] += state[1] + state[2] / 2
            state[1] += state[2]
        drift = DRIFT.at({"t": Fraction(n), "epsilon_v": speed, "epsilon_a": acceleration})
        assert states[1][0] - states[0][0] == D - drift
