"""Every verdict about real numbers is z3's as well; z3 reads the statements and decides them by its own means."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from tests.dmpc_swarm.proofs.filed import FILED, answers

from swarmproof.algebra.polynomial import constant, position, variable
from swarmproof.algebra.statement import Sign, Solvable, Statement, above, at_least, equal
from swarmproof.claims.proof import ProofVerdict
from swarmproof.dmpc_swarm.proofs.terms.separation import I_NEW, OF_I, D, both_new, one_new
from swarmproof.prove.decide import answer
from swarmproof.prove.evidence import Candidate, Unsolvable, Vectors

pytest.importorskip("z3")

from tests.dmpc_swarm.proofs import z3_oracle

PROVED, FALSE = ProofVerdict.PROVED, ProofVerdict.FALSE

#: Where z3 gives up.
GIVEN_UP = {
    # the triangle inequality for five vectors in space
    "tolerance-rest/repaired: d - 2(nT epsilon_v + (nT)^2 epsilon_a/2)",
}
#: Claims about problems for which it gives up, or does not come to an end, at "for all numbers there is a choice" of
#: some questions, most having a dozen unknowns or more. It confirms the choice on file.
NOT_WITHOUT_CHOICE = {
    "theorem-1-feasible/repaired",
    "recursion/repaired",
    "lemma-4-use/repaired",
    "x-between-samples-acceleration/repaired",
    "x-between-samples-ratio/repaired",
    "x-between-samples-flown/repaired",
    "x-shrunk-condition/repaired",
    "tolerance-rest-least/repaired",
    "tolerance-start-least/repaired",
}
#: Times as far as z3 usually goes.
FURTHER = 10
NOTHING = at_least("nothing", 0)

STATEMENTS = {name: each for name, each in FILED.items() if isinstance(each.asked, Statement)}
PROBLEMS = {name: each for name, each in FILED.items() if isinstance(each.asked, Solvable)}

# many claims ask the same question
refuted = cache(z3_oracle.refuted)
contradictory = cache(z3_oracle.contradictory)


@pytest.mark.parametrize("name", STATEMENTS)
def test_z3_decides_statements_alike(name: str) -> None:
    """What is proved has no counterexample, and of what is false z3 finds one without being told."""
    asked, verdict = STATEMENTS[name].asked, answers()[name].verdict
    assert isinstance(asked, Statement)
    found = refuted(asked)
    if found == "unknown":
        found = refuted(asked, FURTHER * z3_oracle.EFFORT)
    if found == "unknown":
        assert name in GIVEN_UP, "z3 gives up"
    else:
        assert found == {PROVED: "unsat", FALSE: "sat"}[verdict]


@pytest.mark.parametrize("name", STATEMENTS)
def test_hypotheses_can_be_met(name: str) -> None:
    """No statement is true for the reason alone that its hypotheses contradict each other."""
    asked = STATEMENTS[name].asked
    assert isinstance(asked, Statement)
    assert contradictory(asked) == "sat"


@pytest.mark.parametrize("name", [name for name, each in PROBLEMS.items() if not each.refutes])
def test_what_problems_assume_can_be_met(name: str) -> None:
    """No problem always has a solution for the reason alone that it is never posed."""
    asked = PROBLEMS[name].asked
    assert isinstance(asked, Solvable)
    assert contradictory(Statement(asked.hypotheses, NOTHING)) == "sat"


@pytest.mark.parametrize("name", [name for name, each in PROBLEMS.items() if each.refutes])
def test_z3_finds_problems_without_a_solution(name: str) -> None:
    """Of a problem that has not always a solution, z3 finds numbers without being told."""
    asked = PROBLEMS[name].asked
    assert isinstance(asked, Solvable)
    assert z3_oracle.insoluble(asked) == "sat"


@pytest.mark.parametrize("name", [name for name, each in PROBLEMS.items() if not each.refutes])
def test_z3_confirms_choices(name: str) -> None:
    """With the choice on file, z3 finds each constraint of a problem true.

    It is told the choice, and which hypotheses a certificate uses, for with fewer of them it decides faster; not how
    they are combined.
    """
    asked, evidence = PROBLEMS[name].asked, PROBLEMS[name].evidence
    assert isinstance(asked, Solvable)
    assert isinstance(evidence, Candidate)
    for constraint, certificate in zip(asked.constraints, evidence.certificates, strict=True):
        named = {of for each in (*certificate.terms, *certificate.multiplier) for of in each.hypotheses}
        named |= certificate.equations.keys()
        hypotheses = tuple(each for each in asked.hypotheses if each.name in named)
        assert refuted(Statement(hypotheses, constraint.put(dict(evidence.choice)))) == "unsat", constraint.name


@pytest.mark.deep
@pytest.mark.parametrize(
    "name",
    [name for name, each in PROBLEMS.items() if not each.refutes and name.partition(": ")[0] not in NOT_WITHOUT_CHOICE],
)
def test_z3_decides_problems_alike(name: str) -> None:
    """What always has a solution has one for z3, which is told nothing."""
    asked = PROBLEMS[name].asked
    assert isinstance(asked, Solvable)
    assert z3_oracle.insoluble(asked, FURTHER * z3_oracle.EFFORT) == "unsat"


@pytest.mark.parametrize("name", [name for name, each in FILED.items() if isinstance(each.evidence, Vectors)])
def test_z3_agrees_with_the_numbers(name: str) -> None:
    """By z3's arithmetic, each counterexample satisfies all hypotheses and not the conclusion."""
    asked, evidence = FILED[name].asked, FILED[name].evidence
    assert isinstance(asked, Statement)
    assert isinstance(evidence, Vectors)
    assert all(z3_oracle.true_at(hypothesis, evidence.values) for hypothesis in asked.hypotheses)
    assert not z3_oracle.true_at(asked.conclusion, evidence.values)


@pytest.mark.parametrize("name", [name for name, each in FILED.items() if isinstance(each.evidence, Unsolvable)])
def test_z3_finds_no_solution(name: str) -> None:
    """With the numbers on file, z3 finds no solution either; it reads no multipliers."""
    asked, evidence = FILED[name].asked, FILED[name].evidence
    assert isinstance(asked, Solvable)
    assert isinstance(evidence, Unsolvable)
    assert all(z3_oracle.true_at(hypothesis, evidence.values) for hypothesis in asked.hypotheses)
    assert z3_oracle.solved(asked, evidence.values) == "unsat"


def test_what_is_given_up_is_a_question() -> None:
    """No name is left over among the exceptions."""
    assert FILED.keys() >= GIVEN_UP
    assert {name.partition(": ")[0] for name in PROBLEMS} >= NOT_WITHOUT_CHOICE


@pytest.mark.parametrize("name", [OF_I, "l is the length of n_ij", "d > 0"])
def test_z3_sees_a_dropped_hypothesis(name: str) -> None:
    """The oracle can say no: without a hypothesis, Corollary 1 and Lemma 3 are false for z3, too."""
    assert refuted(both_new()) == refuted(one_new(False, False)) == refuted(one_new(True, True)) == "unsat"
    assert refuted(both_new().without(name)) == "sat"
    assert refuted(one_new(False, False).without(name)) == "sat"


def test_z3_sees_a_planted_sign() -> None:
    """A plane the wrong way round is false for z3."""
    turned = tuple(replace(h, value=-h.value) if h.name == OF_I else h for h in both_new().hypotheses)
    assert refuted(replace(both_new(), hypotheses=turned)) == "sat"
    assert answer("", replace(both_new(), hypotheses=turned), None).verdict is ProofVerdict.UNDECIDED


def test_coordinates_are_chosen_only_where_nothing_changes() -> None:
    """A statement that is about a direction or a place is asked as it is: else z3 would be misled."""
    p, q = position("p"), position("q")
    far = at_least("far", (p - q).square, D**2)
    # true where q is the origin or the x axis is along p − q, and false in general
    for hypothesis in (equal("place", p.square, 1), at_least("direction", (p - q)[1], 1), at_least("plane", q[2])):
        statement = Statement((above("d > 0", D), far, hypothesis), at_least("", (p - q)[0] ** 2, D**2))
        assert refuted(statement) == "sat"
        assert contradictory(statement) == "sat"
    axis = Statement((above("d > 0", D), far), at_least("", (p - q)[0] ** 2, D**2))
    assert refuted(axis) == "sat"


def test_formulas_are_the_polynomials() -> None:
    """The translation to z3 has the values that polynomials have, for each sign of a condition."""
    x, y = variable("x"), variable("y")
    value = (x - y) ** 3 / 7 - x * y + 2
    for n in range(-3, 4):
        values = {"x": constant(n).at({}), "y": constant(1).at({}) / 3}
        for sign in Sign:
            for condition in (
                at_least("", value),
                above("", value),
                equal("", value),
                equal("", value, value.at(values)),
            ):
                signed = replace(condition, sign=sign)
                assert z3_oracle.true_at(signed, values) == signed.holds(values)
    assert not z3_oracle.true_at(at_least("", I_NEW[0]), {})


def test_problems_without_and_with_a_solution() -> None:
    """For z3, u ≥ x and u ≤ 1 has a solution for x = 1, has none for x = 2, and so not for all x."""
    u, x = variable("u"), variable("x")
    problem = Solvable((), ("u",), (at_least("a", u, x), at_least("b", 1, u)))
    one, two = constant(1).at({}), constant(2).at({})
    assert z3_oracle.solved(problem, {"x": one}) == "sat"
    assert z3_oracle.solved(problem, {"x": two}) == "unsat"
    assert z3_oracle.insoluble(problem) == "sat"
    assert z3_oracle.insoluble(replace(problem, hypotheses=(at_least("c", 1, x),))) == "unsat"
