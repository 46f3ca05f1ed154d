"""Feasibility and recursion: verdicts, what each hypothesis is for, and that planted errors are noticed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction

import pytest

from swarmproof.algebra.polynomial import as_polynomial, constant, variable
from swarmproof.algebra.statement import Condition, Sign, Solvable, Statement
from swarmproof.claims.proof import ProofClaim, ProofVerdict
from swarmproof.dmpc_swarm.evidence.feasibility import EVIDENCE, candidate, line
from swarmproof.dmpc_swarm.proofs import feasibility
from swarmproof.dmpc_swarm.proofs.feasibility import CLAIMS, NO_REST, NO_ZERO, OPEN, OPEN_NEXT, Case
from swarmproof.dmpc_swarm.proofs.terms.motion import Timing, in_rounds
from swarmproof.dmpc_swarm.proofs.terms.problem import (
    SPACE,
    feasible,
    hovering,
    limits,
    special,
    stays,
    times_13f,
    times_18,
    times_20,
)
from swarmproof.motion.integrator import AxisMotion
from swarmproof.prove.decide import decide
from swarmproof.prove.evidence import Candidate, Certificate, Unsolvable, Vectors, term

BY_KEY = {claim.key: claim for claim in CLAIMS}
F = Fraction


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.key)
def test_every_claim_has_the_verdict_on_record(claim: ProofClaim) -> None:
    """The evidence on file decides each claim, and as recorded; no question is left."""
    audited = decide(claim, EVIDENCE[claim.key])
    assert [(each.question, each.why) for each in audited.answers if each.why] == []
    assert audited.verdict is claim.verdict
    assert EVIDENCE[claim.key].keys() == claim.questions.keys()


def _unsolvable(key: str, name: str) -> Unsolvable:
    found = EVIDENCE[key][name]
    assert isinstance(found, Unsolvable)
    return found


#: For each printed question: the repaired one, and the hypothesis of it that the counterexample breaks.
REPAIRED: Mapping[tuple[str, str], tuple[Solvable, str]] = {
    ("theorem-1-feasible/printed", NO_ZERO): (feasible(in_rounds(1), times_20(in_rounds(1))), "0 is in Û ≥"),
    ("theorem-1-feasible/printed", feasibility.H_C_WHOLE): (
        feasible(in_rounds(2), times_20(in_rounds(2))),
        "d apart at 2",
    ),
    ("theorem-1-feasible/printed", feasibility.H_C_HALF): (
        feasible(in_rounds(2, 2, h_c=3), times_20(in_rounds(2, 2, h_c=3))),
        "d apart at 2",
    ),
    ("theorem-1-feasible/printed", feasibility.H_B_SHORT): (
        feasible(in_rounds(2), times_20(in_rounds(2))),
        "(13d) i: p 2 ≤",
    ),
    ("theorem-1-feasible/printed", feasibility.T_B_LONG): (
        feasible(in_rounds(2), times_20(in_rounds(2))),
        "(13d) i: v 1 ≤",
    ),
    ("theorem-1-keeps-rest/printed", feasibility.NEXT_FEASIBLE): (
        feasible(in_rounds(2), times_20(in_rounds(2))),
        "(13e) i: v",
    ),
    ("recursion/printed", feasibility.T_C_LONG): (feasible(in_rounds(2), times_18(in_rounds(2))), "d apart at 1"),
    ("recursion/printed", feasibility.ONE_SHORT): (
        feasible(in_rounds(2, 2), times_18(in_rounds(2, 2))),
        "d apart at 2",
    ),
}


CASES: Mapping[str, Case] = {**OPEN, **OPEN_NEXT, feasibility.NEXT_FEASIBLE: NO_REST}


@pytest.mark.parametrize(("key", "name"), REPAIRED, ids=str)
def test_counterexamples_break_just_what_was_left_open(key: str, name: str) -> None:
    """The numbers that refute a printed statement break, of the repaired one, the hypothesis that it adds."""
    problem, broken = REPAIRED[key, name]
    shown = _unsolvable(key, name)
    values = {each: as_polynomial(number).at({}) for each, number in CASES[name].values.items()} | dict(shown.values)
    # at how many samples there is a normal, and that it has a length, is no matter of the hypothesis in question
    known = tuple(each for each in problem.hypotheses if not each.name.startswith("l_"))
    assert next(each.name for each in known if not each.holds(values)) == broken
    changed_back = replace(problem, hypotheses=known)
    assert replace(shown, values=values).fault(changed_back) == f"the hypothesis {broken!r} does not hold"


LEFT_OPEN = [("theorem-1-feasible/printed", name, times_20) for name in OPEN]
LEFT_OPEN += [("recursion/printed", name, times_18) for name in OPEN_NEXT]


@pytest.mark.parametrize(("key", "name", "times"), LEFT_OPEN)
def test_the_candidate_is_none_where_a_relation_is_left_open(
    key: str, name: str, times: Callable[[Timing], list[Fraction]]
) -> None:
    """With what the printed statement leaves open in the repaired one, the shifted trajectory proves nothing."""
    timing = CASES[name].timing
    asked = feasible(timing, times(timing), zero=name != NO_ZERO)
    assert candidate(timing, times(timing)).fault(asked) is not None
    printed = BY_KEY[key].questions[name]
    assert isinstance(printed, Solvable)
    assert candidate(timing, times(timing)).fault(printed) is not None


@pytest.mark.parametrize("horizon", [1, 2, 3])
@pytest.mark.parametrize("samples", [1, 2])
def test_the_least_h_c(horizon: int, samples: int) -> None:
    """The candidate checks for h_c·T_c ≥ H·T − (T − T_c) in one step, and for h_c·T_c ≥ H·T in the recursion only."""
    for h_c in range(1, samples * horizon + 2):
        timing = in_rounds(horizon, samples, h_c=h_c)
        for times, least in ((times_20, samples * (horizon - 1) + 1), (times_18, samples * horizon)):
            known = times(timing)
            assert (candidate(timing, known).fault(feasible(timing, known)) is None) == (h_c >= least)


@pytest.mark.parametrize(("samples", "h_c"), [(m, h) for m in (1, 2, 3, 4) for h in range(1, m + 1)])
def test_each_smaller_h_c_has_a_counterexample(samples: int, h_c: int) -> None:
    """For H = 2 the condition on h_c is exact: with any h_c below it there are UAVs without a plan."""
    timing = in_rounds(2, samples, h_c=h_c)
    last, late = times_20(timing)[-1], times_13f(timing)[-1]
    motion = AxisMotion((F(0), F(0), F(12)), ((F(1), F(-18)), (F(1), F(6))))
    d = F(8)
    gaps = [motion.position(last) + d - motion.position(time) for time in times_13f(timing)]
    values = line((0, 0, 12, -18, 6), (motion.position(last) + d,), d, gaps)
    case = limits(u=(-18, 6), p=(0, 12), v=(0, 3), a=(-6, 12)) | hovering("j", timing)
    # the row is gap·(gap − d) − gap·(late − T)³/6·(u_new_0 − 6), and (u_new_0 − 6) is (13e): v − a/2
    gap, slope = gaps[-1], gaps[-1] * (late - 1) ** 3 / 6
    lack = gap * (d - gap)
    contradiction = Certificate(
        (term(f"(13f), h = {h_c}", factor=1 / lack),),
        {"(13e) new: v": constant(slope / lack), "(13e) new: a": constant(-slope / lack / 2)},
    )
    assert Unsolvable(values, contradiction).fault(special(feasible(timing, times_20(timing)), case)) is None


TIMING = in_rounds(2, 2)
GOOD = candidate(TIMING, times_20(TIMING))
PROBLEM = feasible(TIMING, times_20(TIMING))


def _without(problem: Solvable, name: str) -> Solvable:
    assert name in {each.name for each in problem.hypotheses}
    return replace(problem, hypotheses=tuple(each for each in problem.hypotheses if each.name != name))


NEEDED = (
    "0 is in Û ≥",
    "0 is in Û ≤",
    "(13c) i: u 1 ≥",
    "(13c) i: u 1 ≤",
    "(13d) i: p 1 ≤",
    "(13d) i: v 2 ≥",
    "(13e) i: v",
    "(13e) i: a",
    "(13e) j: v",
    "(13e) j: a",
    "d > 0",
    "d apart at 1",
    "d apart at 5/2",
    "l_0 is the length of n_ij",
    "l_0 >= 0",
)


@pytest.mark.parametrize("name", NEEDED)
def test_a_hypothesis_that_is_dropped_is_missed(name: str) -> None:
    """Without any of these hypotheses, the candidate is none; without one that it does not use, it still is."""
    assert GOOD.fault(PROBLEM) is None
    assert GOOD.fault(_without(PROBLEM, name)) is not None
    assert GOOD.fault(_without(PROBLEM, "(13d) i: p 0 ≤")) is None


def _negated(problem: Solvable, name: str) -> Solvable:
    def turned(each: Condition) -> Condition:
        return replace(each, value=-each.value) if each.name == name else each

    return replace(problem, constraints=tuple(map(turned, problem.constraints)))


def _strict(problem: Solvable, name: str) -> Solvable:
    def strict(each: Condition) -> Condition:
        return replace(each, sign=Sign.ABOVE) if each.name == name else each

    return replace(problem, constraints=tuple(map(strict, problem.constraints)))


PLANTED: Mapping[str, Solvable] = {
    "the sign of a plane": _negated(PROBLEM, "(13f), h = 1"),
    "the sign of a bound": _negated(PROBLEM, "(13d) new: v 1 ≤"),
    "a plane that must not be touched": _strict(PROBLEM, "(13f), h = 0"),
    "the other plane": feasible(TIMING, times_20(TIMING), halfway=True),
    "(20) one sample later": feasible(TIMING, [time + TIMING.sample_step for time in times_20(TIMING)]),
    "one sample less in (20)": feasible(TIMING, times_20(TIMING)[:-1]),
    "another T_c": feasible(in_rounds(2, 4, h_c=4), times_20(in_rounds(2, 4, h_c=4))),
    "another T": feasible(replace(TIMING, period=F(2)), times_20(TIMING)),
    "no rest": feasible(TIMING, times_20(TIMING), rest=False),
    "0 need not be in Û": feasible(TIMING, times_20(TIMING), zero=False),
    "three axes": feasible(TIMING, times_20(TIMING), axes=SPACE),
}


@pytest.mark.parametrize("error", PLANTED)
def test_an_error_planted_in_the_problem_is_noticed(error: str) -> None:
    """With an error in the problem, the candidate decides nothing."""
    claim = replace(BY_KEY["theorem-1-feasible/repaired"], questions={"planted": PLANTED[error]})
    assert decide(claim, {"planted": GOOD}).verdict is ProofVerdict.UNDECIDED


def test_an_error_planted_in_the_candidate_is_noticed() -> None:
    """A trajectory shifted by too little, or that goes on with its last jerk, is no candidate."""
    for jerks in (("u_i_0", "u_i_1"), ("u_i_1", "u_i_1")):
        choice = dict(zip(PROBLEM.unknowns, map(variable, jerks), strict=True))
        assert Candidate(choice, GOOD.certificates).fault(PROBLEM) is not None
    assert Candidate(GOOD.choice, GOOD.certificates[:-1]).fault(PROBLEM) is not None


REFUTED = [
    (key, name)
    for key, shown in EVIDENCE.items()
    for name, each in shown.items()
    if isinstance(each, Unsolvable | Vectors)
]


@pytest.mark.parametrize(("key", "name"), REFUTED, ids=str)
def test_counterexamples_with_an_error_refute_nothing(key: str, name: str) -> None:
    """With UAV j far away, the numbers decide nothing."""
    shown = EVIDENCE[key][name]
    assert isinstance(shown, Unsolvable | Vectors)
    claim = BY_KEY[key]
    question = {name: claim.questions[name]}
    planted = replace(shown, values={**shown.values, "p_j": F(100)})
    assert decide(replace(claim, questions=question), {name: shown}).verdict is ProofVerdict.FALSE
    assert decide(replace(claim, questions=question), {name: planted}).verdict is ProofVerdict.UNDECIDED


def test_entries_that_stay_need_rest_and_a_zero_jerk() -> None:
    """Without (13e), or without 0 in Û, an entry does not satisfy (13b)–(13e) in the next round."""
    problem = stays(in_rounds(3))
    shown = EVIDENCE["theorem-1-keeps-rest/repaired"]["H = 3, T_c = T"]
    assert isinstance(shown, Candidate)
    assert shown.fault(problem) is None
    for name in ("(13e) i: v", "(13e) i: a", "0 is in Û ≥", "(13d) i: p 3 ≥"):
        assert shown.fault(_without(problem, name)) is not None


@pytest.mark.parametrize("dropped", ["a_i = 0", "u_i_0 = 0", "(13c) new: u 1 ≥", "(13e) new: a"])
def test_that_0_must_be_in_the_inputs_needs_each_of_these(dropped: str) -> None:
    """Without rest at the start, a bound, or rest at the end, nothing says that 0 is in Û."""
    asked = BY_KEY["zero-input/repaired"].questions["H = 2"]
    assert isinstance(asked, Statement)
    proof = EVIDENCE["zero-input/repaired"]["H = 2"]
    assert isinstance(proof, Certificate)
    assert proof.fault(asked) is None
    assert proof.fault(asked.without(dropped)) is not None


@pytest.mark.deep
@pytest.mark.parametrize("times", [times_20, times_18])
def test_the_published_parameters(times: Callable[[Timing], list[Fraction]]) -> None:
    """With H = 15, T = 0.2 s and T_c = T/2, the problem is feasible, and so is that of the next round."""
    timing = in_rounds(15, 2, period=F(1, 5))
    assert candidate(timing, times(timing)).fault(feasible(timing, times(timing))) is None
