"""Trajectories that are not planned again, round 0, and where a plan begins: verdicts and planted errors."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from swarmproof.algebra.polynomial import Number, Polynomial, as_polynomial, constant, variable
from swarmproof.algebra.statement import Solvable, Statement
from swarmproof.claims.proof import ProofClaim, ProofVerdict
from swarmproof.dmpc_swarm.evidence.rest import EVIDENCE, FROM_ONE_PLACE, ends_apart
from swarmproof.dmpc_swarm.proofs.rest import CLAIMS, JUMP, PUBLISHED, starts
from swarmproof.dmpc_swarm.proofs.terms.motion import entry, in_rounds
from swarmproof.dmpc_swarm.proofs.terms.problem import old_apart, special, times_18, times_21
from swarmproof.motion.integrator import AxisMotion
from swarmproof.prove.decide import decide
from swarmproof.prove.evidence import Certificate, Vectors

BY_KEY = {claim.key: claim for claim in CLAIMS}
F = Fraction


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.key)
def test_every_claim_has_the_verdict_on_record(claim: ProofClaim) -> None:
    """The evidence on file decides each claim, and as recorded; no question is left."""
    audited = decide(claim, EVIDENCE[claim.key])
    assert [(each.question, each.why) for each in audited.answers if each.why] == []
    assert audited.verdict is claim.verdict
    assert EVIDENCE[claim.key].keys() == claim.questions.keys()


MOVED = [
    ("lemma-4-use/printed", "(21), no rest"),
    ("lemma-4-use/printed", "(21), h_c·T_c = H·T − T_c"),
    ("unique-entry/printed", "position"),
]


@pytest.mark.parametrize(("key", "name"), MOVED)
def test_counterexamples_with_an_error_refute_nothing(key: str, name: str) -> None:
    """With UAV j elsewhere, or another last jerk, the numbers decide nothing."""
    claim = replace(BY_KEY[key], questions={name: BY_KEY[key].questions[name]})
    shown = EVIDENCE[key][name]
    assert isinstance(shown, Vectors)
    changed = {"p_j": F(100)} if "p_j" in shown.values else {"u_b_2": F(0)}
    assert decide(claim, {name: shown}).verdict is ProofVerdict.FALSE
    assert decide(claim, {name: Vectors({**shown.values, **changed})}).verdict is ProofVerdict.UNDECIDED


def test_lemma_4_needs_rest_and_the_horizon() -> None:
    """The proof of the repaired Lemma 4 is none of the printed one."""
    whole, short = in_rounds(2, 2), in_rounds(2, 2, h_c=3)
    for timing, rests in ((whole, True), (whole, False), (short, True)):
        asked = old_apart(timing, times_18(timing), times_21(timing), rest=rests)
        proof = ends_apart(timing, times_18(timing))
        assert (proof.fault(asked) is None) == (timing is whole and rests)


@pytest.mark.parametrize(
    ("key", "question", "dropped"),
    [
        ("theorem-2-base/repaired", "T/T_c = 2, hovering", "v_i = 0"),
        ("theorem-2-base/repaired", "T/T_c = 2, hovering", "a_j = 0"),
        ("theorem-2-base/repaired", "T/T_c = 2, hovering", "u_j_0 = 0"),
        ("theorem-2-base/repaired", "T/T_c = 2, hovering", "d apart at 1"),
        ("theorem-2-base/repaired", "T/T_c = 2, apart in round 0", "d apart at 1/2"),
        ("lemma-4-use/repaired", "from (20), H = 2, T_c = T", "(13e) j: a"),
        ("entry-jump/repaired", "velocity", "(13c) b: u 0 ≥"),
    ],
)
def test_a_dropped_hypothesis_leaves_a_claim_undecided(key: str, question: str, dropped: str) -> None:
    """Each of these hypotheses is needed: without it, the proof on file is none."""
    claim, asked = BY_KEY[key], BY_KEY[key].questions[question]
    assert isinstance(asked, Statement | Solvable)
    assert dropped in {each.name for each in asked.hypotheses}
    less = replace(asked, hypotheses=tuple(each for each in asked.hypotheses if each.name != dropped))
    for one, verdict in ((asked, ProofVerdict.PROVED), (less, ProofVerdict.UNDECIDED)):
        assert decide(replace(claim, questions={question: one}), EVIDENCE[key]).verdict is verdict


@pytest.mark.parametrize("name", ["position", "velocity", "acceleration"])
def test_one_entry_is_what_makes_a_plan_continue(name: str) -> None:
    """The proof for one entry is none for two, and the numbers for two entries refute nothing where there is one."""
    printed, repaired = (BY_KEY[f"unique-entry/{reading}"].questions[name] for reading in ("printed", "repaired"))
    assert isinstance(printed, Statement)
    assert isinstance(repaired, Statement)
    proof, numbers = EVIDENCE["unique-entry/repaired"][name], EVIDENCE["unique-entry/printed"][name]
    assert isinstance(proof, Certificate)
    assert isinstance(numbers, Vectors)
    assert proof.fault(printed) is not None
    assert numbers.fault(special(printed, JUMP)) is None
    assert numbers.fault(special(repaired, JUMP)) == "the hypothesis '|D_i(k)| = 1: u_b_0 = u_a_0' does not hold"


@pytest.mark.parametrize("name", ["position", "velocity", "acceleration"])
def test_the_jump_is_reached(name: str) -> None:
    """The bound on the jump is the least: entries that begin at rest with jerks 5 and −5 reach it, and come to rest."""
    asked = BY_KEY["entry-jump/repaired"].questions[name]
    assert isinstance(asked, Statement)
    values = {f"{symbol}_i": F(0) for symbol in "pva"}
    values |= {f"u_a_{n}": F(jerk) for n, jerk in enumerate((5, -5, -5, 5))}
    values |= {f"u_b_{n}": F(-jerk) for n, jerk in enumerate((5, -5, -5, 5))}
    values |= {each: F(number.at({})) for each, number in map(_number, PUBLISHED.items())}
    assert all(each.holds(values) for each in asked.hypotheses)
    assert asked.conclusion.value.at(values) == 0
    less = replace(asked.conclusion, value=asked.conclusion.value - F(1, 1000))
    assert Vectors(values).fault(replace(asked, conclusion=less)) is None


def _number(item: tuple[str, Polynomial | Number]) -> tuple[str, Polynomial]:
    return item[0], as_polynomial(item[1])


def test_the_start_of_theorem_2_in_ten_lines() -> None:
    """Two UAVs within the published bounds are at one place at 0, 0.15 m apart at 0.1 s, and from 0.2 s on 0.25 m."""
    motion = AxisMotion((F(0), F(9, 10), F(-3)), ((F(3, 5), F(5)), (F(12, 5), F(0))))
    distance = [2 * abs(motion.position(F(h, 10))) for h in range(33)]
    assert distance[:2] == [0, F(91, 600)]
    assert min(distance[2:]) == F(19, 75) > F(1, 4)
    states = [motion.at(F(n, 5)) for n in range(16)]
    assert all(abs(v) <= 2 and abs(a) <= 5 and abs(p) <= F(7, 5) for p, v, a in states)
    assert states[15][1:] == (F(0), F(0))


def test_the_start_of_theorem_2_at_the_published_horizon() -> None:
    """The same numbers refute Theorem 2's base for H = 15, and nothing if a sample of round 0 is assumed."""
    asked = starts(in_rounds(15, 2, period=F(1, 5)))
    assert FROM_ONE_PLACE.fault(asked) is None
    assumed = replace(asked, hypotheses=(*asked.hypotheses, replace(asked.conclusion, name="at h = 0")))
    assert FROM_ONE_PLACE.fault(assumed) == "the hypothesis 'at h = 0' does not hold"


@pytest.mark.parametrize(("name", "value"), [("v_i", F(8, 10)), ("a_i", F(-5)), ("u_i_0", F(6)), ("p_i", F(1, 8))])
def test_other_numbers_do_not_refute_the_base(name: str, value: Fraction) -> None:
    """A number changed in the counterexample breaks a hypothesis, or keeps the references apart."""
    (asked,) = BY_KEY["theorem-2-base/printed"].questions.values()
    assert isinstance(asked, Statement)
    assert Vectors({**FROM_ONE_PLACE.values, name: value}).fault(asked) is not None


def test_no_shorter_horizon_brings_them_together() -> None:
    """With H = 2, jerks ±5 and (13e), a UAV is at most 35/750 m from where it began round 0 at T: less than 0.125 m."""
    timing = in_rounds(2, period=F(1, 5))
    moved = entry("i", timing).at(timing.period).p - variable("p_i")
    # (13e) gives velocity and acceleration at 0 by the jerks
    t = timing.period
    u0, u1 = variable("u_i_0"), variable("u_i_1")
    acceleration = -t * (u0 + u1)
    velocity = t**2 * (u0 + 3 * u1) / 2
    end = entry("i", timing).at(2 * t)
    solved = {"a_i": acceleration, "v_i": velocity}
    assert (end.v.put(solved), end.a.put(solved)) == (constant(0), constant(0))
    assert moved.put(solved) == (u0 + 6 * u1) * t**3 / 6
    assert F(5 * 7, 6) * t**3 == F(35, 750) < F(1, 8)
