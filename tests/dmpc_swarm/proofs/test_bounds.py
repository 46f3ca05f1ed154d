"""X between samples: verdicts, planted errors, and the same amounts from linear programs and simulated motions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from math import sqrt
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from swarmproof.algebra.polynomial import Polynomial, variable
from swarmproof.algebra.statement import Sign, Solvable, Statement
from swarmproof.claims.proof import ProofClaim, ProofVerdict, Reading
from swarmproof.dmpc_swarm.evidence.bounds import EVIDENCE
from swarmproof.dmpc_swarm.proofs.bounds import CLAIMS, FLOWN, FLOWN_AT_LEAST
from swarmproof.dmpc_swarm.proofs.terms.between import (
    POSITIVE,
    T_S,
    Moment,
    Order,
    at,
    by_acceleration,
    by_jerk,
    check,
    for_three,
    middle,
    of_acceleration,
    of_position,
    somewhere,
    stays,
    turns,
)
from swarmproof.motion.integrator import AxisMotion
from swarmproof.prove.decide import answer, decide
from swarmproof.prove.evidence import Certificate, Vectors

BY_KEY = {claim.key: claim for claim in CLAIMS}
BOTH_READINGS = sorted({claim.id for claim in CLAIMS if {f"{claim.id}/{r}" for r in Reading} <= BY_KEY.keys()})
POSITION, VELOCITY, ACCELERATION = Order

PROOFS = [
    pytest.param(asked, shown, id=f"{key}: {name}")
    for key, evidence in EVIDENCE.items()
    for name, shown in evidence.items()
    if isinstance(asked := BY_KEY[key].questions[name], Statement) and isinstance(shown, Certificate)
]
CHOICES = [
    pytest.param(asked, shown, id=f"{key}: {name}")
    for key, evidence in EVIDENCE.items()
    for name, shown in evidence.items()
    if isinstance(asked := BY_KEY[key].questions[name], Solvable)
]


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.key)
def test_every_claim_has_the_verdict_on_record(claim: ProofClaim) -> None:
    """Each claim is decided, and as recorded."""
    audited = decide(claim, EVIDENCE[claim.key])
    assert [(each.question, each.why) for each in audited.answers if each.why] == []
    assert audited.as_recorded


def test_evidence_and_questions_match() -> None:
    """Evidence is on file for just the questions of the claims."""
    assert {key: set(shown) for key, shown in EVIDENCE.items()} == {claim.key: set(claim.questions) for claim in CLAIMS}


@pytest.mark.parametrize("name", BOTH_READINGS)
def test_evidence_of_one_reading_is_none_for_the_other(name: str) -> None:
    """What proves the repaired statement does not prove what is false of the printed one, nor the other way round."""
    printed, repaired = BY_KEY[f"{name}/printed"], BY_KEY[f"{name}/repaired"]
    shown = {key: EVIDENCE[key] for key in (printed.key, repaired.key)}
    for refuted in decide(printed, shown[printed.key]).answers:
        if refuted.verdict is ProofVerdict.FALSE:
            for proof in shown[repaired.key].values():
                assert answer("", refuted.asked, proof).verdict is ProofVerdict.UNDECIDED
            for asked in repaired.questions.values():
                assert refuted.evidence is not None
                assert answer("", asked, refuted.evidence).verdict is ProofVerdict.UNDECIDED


def _tighter(asked: Statement) -> Statement:
    """Return the statement with an amount that is a billionth smaller."""
    conclusion = asked.conclusion
    return replace(asked, conclusion=replace(conclusion, value=conclusion.value - Fraction(1, 10**9)))


def _jerk_of_the_wrong_sign(asked: Statement) -> Statement:
    return replace(asked, conclusion=asked.conclusion.put({f"j_{n}": -variable(f"j_{n}") for n in range(1, 10)}))


def _start_of_the_wrong_sign(asked: Statement) -> Statement:
    return replace(asked, conclusion=asked.conclusion.put({name: -variable(name) for name in "va"}))


def _checked_half_as_often(asked: Statement) -> Statement:
    """Return the statement with X checked after 2T_s where it was after T_s."""
    slow = tuple(h.put({"T_s": 2 * T_S}) if h.name.startswith(("upper", "lower")) else h for h in asked.hypotheses)
    return replace(asked, hypotheses=slow)


@pytest.mark.parametrize(
    "change",
    [_tighter, _jerk_of_the_wrong_sign, _start_of_the_wrong_sign, _checked_half_as_often],
    ids=lambda change: change.__name__,
)
@pytest.mark.parametrize(("asked", "shown"), PROOFS)
def test_a_planted_error_is_not_proved(
    asked: Statement, shown: Certificate, change: Callable[[Statement], Statement]
) -> None:
    """A smaller amount, a sign in the motion or a wrong time of a check, and the certificate no longer checks."""
    changed = change(asked)
    named = {name for each in shown.terms for name in each.hypotheses}
    used = [{h.value for h in each.hypotheses if h.name in named} for each in (asked, changed)]
    if used[0] == used[1] and changed.conclusion == asked.conclusion:
        pytest.skip("what is changed is not used")
    assert answer("", changed, shown).verdict is ProofVerdict.UNDECIDED


@pytest.mark.parametrize(("asked", "shown"), PROOFS)
def test_every_hypothesis_that_a_certificate_names_is_needed_for_it(asked: Statement, shown: Certificate) -> None:
    """Without one of them, or with a bound of the wrong sign, it does not check."""
    named = {name for each in shown.terms for name in each.hypotheses}
    for name in named:
        assert answer("", asked.without(name), shown).verdict is ProofVerdict.UNDECIDED
        if name.startswith(("upper", "lower")):
            turned = tuple(replace(h, value=-h.value) if h.name == name else h for h in asked.hypotheses)
            assert answer("", replace(asked, hypotheses=turned), shown).verdict is ProofVerdict.UNDECIDED


@pytest.mark.parametrize(("asked", "shown"), CHOICES)
def test_every_condition_of_a_motion_is_needed_for_it(asked: Solvable, shown: object) -> None:
    """Without a condition on the bounds, or with a goal that is a billionth further, the choice does not check."""
    assert not isinstance(shown, Vectors | Certificate)
    for each in asked.hypotheses:
        if each in POSITIVE or each.name in ("K > 0", "e > 0"):
            continue
        less = replace(asked, hypotheses=tuple(h for h in asked.hypotheses if h != each))
        assert answer("", less, shown).verdict is ProofVerdict.UNDECIDED  # type: ignore[arg-type]
    *others, goal = asked.constraints
    further = replace(asked, constraints=(*others, replace(goal, value=goal.value - Fraction(1, 10**9))))
    assert answer("", further, shown).verdict is ProofVerdict.UNDECIDED  # type: ignore[arg-type]


@pytest.mark.parametrize(("asked", "shown"), PROOFS)
def test_lower_bounds_follow_from_upper_ones(asked: Statement, shown: Certificate) -> None:
    """Hypotheses are the same for the mirrored motion, so what is concluded of p, v, a is true of −p, −v, −a."""
    names = {name for each in asked.hypotheses for name in each.value.variables}
    mirror: dict[str, Polynomial | int | Fraction] = {
        name: -variable(name) for name in names if name in "pva" or name.startswith("j_")
    }
    mirrored = replace(asked, hypotheses=tuple(h.put(mirror) for h in asked.hypotheses))

    def said(by: Statement) -> set[frozenset[Polynomial]]:
        # an equation says the same of a value and of its negative
        return {frozenset([h.value, -h.value] if h.sign is Sign.EQUAL else [h.value]) for h in by.hypotheses}

    assert said(mirrored) == said(asked)


numbers = st.fractions(-9, 9, max_denominator=6)


@settings(max_examples=60, deadline=None)
@given(st.tuples(numbers, numbers, numbers), st.lists(numbers, min_size=4, max_size=4), st.fractions(0, 1), st.data())
def test_the_motion_is_the_nominal_model(
    state: tuple[Fraction, Fraction, Fraction], jerks: list[Fraction], part: Fraction, data: st.DataObject
) -> None:
    """The polynomials have the values of the model that flights use, at any time and at checks."""
    step = Fraction(2, 5)
    motion = AxisMotion(state, tuple((step, each) for each in jerks))
    period = data.draw(st.integers(1, 4))
    values = dict(zip("pva", state, strict=True)) | {f"j_{n}": each for n, each in enumerate(jerks, start=1)}
    values |= {"T_s": step, "tau": part * step}
    assert tuple(each.at(values) for each in somewhere(period).state()) == motion.at((period - 1 + part) * step)
    for ratio in (1, 2, 4):
        for sample in range(4 // ratio + 1):
            reached = tuple(each.at(values) for each in check(sample, ratio).state())
            assert reached == motion.at(sample * ratio * step)


def test_names_of_samples() -> None:
    """Samples are called as in the paper."""
    assert [at(n) for n in range(3)] == ["0", "T_b", "2T_b"]


class Plan(NamedTuple):
    """A counterexample, flown by the model: where it is seen to leave X, and its bounds."""

    key: str
    question: str
    ratio: int
    seen: Fraction
    order: Order
    value: Fraction


PLANS = (
    Plan("x-between-samples-position/printed", "period 3", 1, Fraction(5, 2), POSITION, Fraction(23, 4)),
    Plan("x-between-samples-velocity/printed", "period 2", 1, Fraction(3, 2), VELOCITY, Fraction(9, 2)),
    Plan("x-between-samples-acceleration/printed", "r = 2", 2, Fraction(1), ACCELERATION, Fraction(1)),
    Plan("x-between-samples-acceleration/printed", "r = 3", 3, Fraction(1), ACCELERATION, Fraction(1)),
    Plan("x-between-samples-acceleration/printed", "r = 4", 4, Fraction(2), ACCELERATION, Fraction(2)),
    Plan("x-between-samples-published/printed", "velocity, period 8", 1, Fraction(3, 2), VELOCITY, Fraction(81, 40)),
    Plan("x-at-collision-samples/printed", "position", 1, Fraction(5, 2), POSITION, Fraction(23, 4)),
    Plan("x-at-collision-samples/printed", "velocity", 1, Fraction(3, 2), VELOCITY, Fraction(9, 2)),
)
#: What the published parameters are; their plan's values do not name them.
SYMBOLS: Mapping[str, Fraction] = {"P": Fraction(7, 5), "V": Fraction(2), "A": Fraction(5), "J": Fraction(5)}


@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: f"{plan.key}: {plan.question}")
def test_plans_that_leave_x_are_flown(plan: Plan) -> None:
    """From rest to rest, in X at all checks and in U, and outside between: as the model of flights has it."""
    shown = EVIDENCE[plan.key][plan.question]
    assert isinstance(shown, Vectors)
    values = shown.values
    jerks = [values[f"j_{n}"] for n in range(1, sum(name.startswith("j_") for name in values) + 1)]
    step = values["T_s"]
    motion = AxisMotion((values["p"], values["v"], values["a"]), tuple((step, each) for each in jerks))
    bounds = [values[name] for name in "PVA"]
    for sample in range(len(jerks) // plan.ratio + 1):
        state = motion.at(sample * plan.ratio * step)
        assert all(abs(value) <= bound for value, bound in zip(state, bounds, strict=True))
    assert all(abs(each) <= values["J"] for each in jerks)
    for time in (Fraction(0), len(jerks) * step):
        assert not any(motion.at(time)[1:])
    assert motion.at(plan.seen)[plan.order] == plan.value > bounds[plan.order]


def test_the_published_plan_has_the_published_parameters() -> None:
    """Its bounds are those of the experiments on the x axis."""
    shown = EVIDENCE["x-between-samples-published/printed"]["velocity, period 8"]
    assert isinstance(shown, Vectors)
    assert {name: shown.values[name] for name in SYMBOLS} == SYMBOLS
    assert shown.values["T_s"] == Fraction(1, 5)


def _row(order: int, time: float, step: float, periods: int) -> list[float]:
    """Return what one unit of p, v, a and of each jerk at first contribute to p, v or a at a time: by simulation."""
    row = []
    for unknown in range(3 + periods):
        state = tuple(float(unknown == n) for n in range(3))
        jerks = tuple((step, float(unknown == 3 + n)) for n in range(periods))
        row.append(AxisMotion(state, jerks).at(time)[order])
    return row


def _largest(order: int, bounds: Sequence[float], jerk: float, step: float, ratio: int, checks: Sequence[int]) -> float:
    """Return by how much p, v or a can be above its bound in the middle T_b, X holding at these multiples of T_b.

    The largest of linear programs at 24 times a period, which include T_b/2.
    """
    periods = max(checks) * ratio
    rows, limits = [], []
    for sample in checks:
        for m in range(3):
            row = _row(m, sample * ratio * step, step, periods)
            rows += [row, [-each for each in row]]
            limits += [bounds[m], bounds[m]]
    start = max(checks) // 2 * ratio * step
    best = -np.inf
    for time in np.linspace(start, start + ratio * step, 24 * ratio + 1):
        goal = [-each for each in _row(order, float(time), step, periods)]
        limits_of = [(None, None)] * 3 + [(-jerk, jerk)] * periods
        found = linprog(goal, A_ub=rows, b_ub=limits, bounds=limits_of)
        assert found.status == 0
        best = max(best, -float(found.fun or 0.0) - bounds[order])
    return float(best)


#: P, V, A, J, T_s: the published ones, and others; the flying space is wide enough in all.
SETS = [
    (1.4, 2.0, 5.0, 5.0, 0.2),
    (9.0, 7.0, 2.0, 3.0, 0.7),
    (40.0, 11.0, 1.0, 9.0, 1.0),
    (50.0, 9.0, 3.0, 0.5, 1.0),
]


def _values(parameters: Sequence[float]) -> dict[str, Fraction]:
    return dict(zip(("P", "V", "A", "J", "T_s"), map(Fraction, parameters), strict=True))


def _value(amount: Polynomial, parameters: Sequence[float]) -> float:
    return float(amount.at(_values(parameters)))


@pytest.mark.parametrize("parameters", SETS)
@pytest.mark.parametrize("ratio", [1, 2, 3, 4])
def test_the_amounts_are_the_largest_ones(parameters: tuple[float, ...], ratio: int) -> None:
    """Linear programs over all motions at dense times find these amounts, neither more nor less.

    If V is not large enough, as the claim has it, they find that the acceleration grows less.
    """
    *bounds, jerk, step = parameters
    soft = jerk * ratio * step <= 2 * bounds[2]
    by_ratio = {1: by_acceleration(1), 2: by_acceleration(2), 3: for_three()}
    expected = {}
    if soft:
        expected[VELOCITY] = by_jerk(ratio)
    elif ratio in by_ratio:
        expected[VELOCITY] = by_ratio[ratio]
    if ratio <= 2:
        expected[POSITION] = of_position(ratio)
    if turns(ratio).holds(_values(parameters)):
        expected[ACCELERATION] = of_acceleration(ratio)
    else:
        assert _largest(ACCELERATION, bounds, jerk, step, ratio, (0, 1)) < _value(of_acceleration(ratio), parameters)
    for order, amount in expected.items():
        found = _largest(order, bounds, jerk, step, ratio, (0, 1))
        assert found == pytest.approx(_value(amount, parameters), rel=1e-7, abs=1e-8), order


def test_the_smaller_amount_of_the_velocity_changes_at_one_jerk() -> None:
    """For r = 1, 2, 3, both formulas are the same where J·T_b = 2A; beyond, J·T_b²/8 is the larger one."""
    for ratio, other in ((1, by_acceleration()), (2, by_acceleration(2)), (3, for_three())):
        edge: dict[str, Polynomial | int | Fraction] = {"A": ratio * T_S / 2, "J": 1}
        assert by_jerk(ratio).put(edge) == other.put(edge)
        values = {"A": Fraction(1), "J": Fraction(7), "T_s": Fraction(1)}
        assert by_jerk(ratio).at(values) > other.at(values)


def test_the_position_is_exceeded_less_if_velocity_is_small() -> None:
    """Where A·T_b > 2V, the programs find less than A·T_b²/8, as the claim says."""
    found = _largest(POSITION, (40.0, 1.0, 9.0), 3.0, 1.0, 1, (0, 1))
    assert 0.25 <= found < 1.0


def test_flight_exceeds_less_than_one_period() -> None:
    """With X at four samples more on both sides, the programs find 0.02 m instead of 0.025 m, just under 0.02001 m."""
    found = _largest(POSITION, (1.4, 2.0, 5.0), 5.0, 0.2, 1, range(10))
    assert float(FLOWN_AT_LEAST) <= found + 1e-9
    assert found <= float(FLOWN)
    assert _largest(VELOCITY, (1.4, 2.0, 5.0), 5.0, 0.2, 1, range(10)) == pytest.approx(0.025)


@settings(max_examples=60, deadline=None)
@given(st.floats(0.1, 5), st.floats(0.1, 5), st.floats(0.1, 5), st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_no_random_motion_exceeds_the_amounts(
    speed: float, acceleration: float, jerk: float, ratio: int, seed: int
) -> None:
    """Motions drawn at random, pushed into X at both ends, stay within the amounts at 200 times."""
    rng = np.random.default_rng(seed)
    jerks = rng.uniform(-jerk, jerk, ratio)
    state = rng.uniform(-1, 1, 3) * (0, speed, acceleration)
    motion = AxisMotion(tuple(map(float, state)), tuple((1.0, float(each)) for each in jerks))
    ends = np.abs([motion.at(0.0), motion.at(float(ratio))]).max(axis=0)
    # the bounds that this motion meets at both ends
    values = {name: Fraction(float(each)) for name, each in zip("PVA", ends, strict=True)}
    values |= {"J": Fraction(jerk), "T_s": Fraction(1)}
    largest = np.abs([motion.at(float(time)) for time in np.linspace(0, ratio, 201)]).max(axis=0) - ends
    assert largest[1] <= float(by_jerk(ratio).at(values)) + 1e-9
    assert largest[2] <= float(of_acceleration(ratio).at(values) if ratio > 1 else 0) + 1e-9
    if ratio <= 2:
        assert largest[0] <= float(of_position(ratio).at(values)) + 1e-9
        assert largest[1] <= float(by_acceleration(ratio).at(values)) + 1e-9


def test_the_worst_time_is_the_collision_sample() -> None:
    """With T_c = T_b/2, the amounts at the sample T_c are those at the worst time of T_b."""
    asked = stays(VELOCITY, middle(), beyond=by_jerk())
    assert (
        asked.conclusion.value == stays(VELOCITY, somewhere(1), beyond=by_jerk()).conclusion.put({"tau": T_S / 2}).value
    )
    assert middle() == Moment(1, T_S / 2)
    # and T_c = T_b/4, as for the margin of row 14: a sample is less far outside, but outside
    quarter = [_row(1, each, 0.2, 1) for each in (0.05, 0.1)]
    turning = np.array([0.0, 2.0, 5.0, -50.0])
    assert [float(np.dot(row, turning)) for row in quarter] == pytest.approx([2.1875, 2.25])


def test_the_next_turn_of_a_fast_acceleration() -> None:
    """What the finding about flight says: from −0.5 m/s at −5 m/s², even the largest jerk leads beyond −2 m/s."""
    motion = AxisMotion((1.4, -0.5, -5.0), ((1.0, 5.0),))
    assert motion.at(1.0)[1] == pytest.approx(-3.0)


def test_the_best_mean_acceleration_is_four() -> None:
    """(2V + J·s²)/(T + 2s), s = nT, is least for n = 4, the number of samples that the claim uses."""
    at_most = {n: Fraction(4 + 5 * Fraction(n, 5) ** 2) / (Fraction(1, 5) + Fraction(2 * n, 5)) for n in range(10)}
    assert min(at_most, key=at_most.__getitem__) == 4
    assert at_most[4] == 4
    # and its largest excess, at any time of T_b: a cubic
    sigma = (-4 + sqrt(16 + 25 * 0.04 / 12)) / 5
    assert (0.01 - sigma**2) / 2 * (4 + 5 * sigma / 3) == pytest.approx(0.0200087, abs=1e-7)
