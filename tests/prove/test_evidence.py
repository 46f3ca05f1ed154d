"""Evidence that does not check is refused: every way in which a certificate or a counterexample can be wrong."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any, cast

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from swarmproof.algebra.polynomial import Polynomial, constant, variable, variables
from swarmproof.algebra.statement import Condition, Solvable, Statement, above, at_least, equal
from swarmproof.dmpc_swarm.evidence.book import EVIDENCE
from swarmproof.dmpc_swarm.proofs.registry import PROOF_CLAIMS
from swarmproof.prove.evidence import (
    Candidate,
    Certificate,
    Evidence,
    Term,
    Unsolvable,
    Vectors,
    chosen_statements,
    contradiction_statement,
    term,
)

X, Y, U = variables("x y u")
F = Fraction

#: x ≥ 1 and y = x imply x·y ≥ 1.
TRUE = Statement((at_least("x >= 1", X, 1), equal("y is x", Y, X)), at_least("xy >= 1", X * Y, 1))
#: xy − 1 = (x − 1)² + 2(x − 1) + x(y − x).
PROOF = Certificate((term(squared=X - 1), term("x >= 1", factor=2)), {"y is x": X})


def test_a_certificate_proves() -> None:
    """A correct certificate has no fault."""
    assert PROOF.fault(TRUE) is None


#: What is wrong with a certificate, the certificate, and the statement that it is for.
WRONG: dict[str, tuple[Certificate, Statement, str]] = {
    "a wrong coefficient": (
        replace(PROOF, terms=(term(squared=X - 1), term("x >= 1", factor=3))),
        TRUE,
        "the two sides differ by -x + 1",
    ),
    "a wrong sign of an equation": (replace(PROOF, equations={"y is x": -X}), TRUE, "the two sides differ by"),
    "a missing square": (replace(PROOF, terms=PROOF.terms[1:]), TRUE, "the two sides differ by"),
    "a negative factor": (
        Certificate((term("x >= 1", factor=-1),)),
        Statement((at_least("x >= 1", X, 1),), at_least("x <= 1", 1, X)),
        "a term has a negative factor",
    ),
    "a negative factor of the multiplier": (
        Certificate((term("x >= 1"),), multiplier=(term(), term(factor=-2))),
        Statement((at_least("x >= 1", X, 1),), at_least("x <= 1", 1, X)),
        "a term has a negative factor",
    ),
    "an equation in a term": (
        Certificate((term("y is x"),)),
        Statement(TRUE.hypotheses, at_least("y >= x", Y, X)),
        "a term uses the equation 'y is x'",
    ),
    "an equation in the multiplier": (
        Certificate((), {"y is x": constant(-1)}, (term("y is x"),)),
        Statement(TRUE.hypotheses, at_least("-1 >= 0", -1)),
        "a term uses the equation 'y is x'",
    ),
    "an inequality as an equation": (
        Certificate((), {"x >= 1": constant(-1)}),
        Statement((at_least("x >= 1", X, 1),), at_least("x <= 1", 1, X)),
        "it uses 'x >= 1' as an equation, which it is not",
    ),
    "a hypothesis that there is not": (
        Certificate((term("x >= 2"),)),
        Statement((at_least("x >= 1", X, 1),), at_least("x >= 2", X, 2)),
        "it uses 'x >= 2', which is no hypothesis",
    ),
    "an equation that there is not": (
        Certificate((), {"x = 2": constant(1)}),
        Statement((at_least("x >= 1", X, 1),), at_least("x >= 2", X, 2)),
        "it uses 'x = 2', which is no hypothesis",
    ),
    "the conclusion among the hypotheses": (
        Certificate((term("x >= 2"),), multiplier=(term("x >= 2"),)),
        Statement((at_least("x >= 1", X, 1),), at_least("x >= 2", X, 2)),
        "it uses 'x >= 2', which is no hypothesis",
    ),
    "two hypotheses of one name": (
        Certificate((term("a"),)),
        Statement((at_least("a", X, 1), at_least("a", X, 2)), at_least("x >= 2", X, 2)),
        "two hypotheses have the same name",
    ),
    "a multiplier that is zero": (
        Certificate(multiplier=()),
        Statement((), at_least("x >= 0", X)),
        "its multiplier may be zero",
    ),
    "a multiplier whose factor is zero": (
        Certificate(multiplier=(term(factor=0),)),
        Statement((), at_least("x >= 0", X)),
        "its multiplier may be zero",
    ),
    "a multiplier that may be zero": (
        Certificate(multiplier=(term("x >= 0"),)),
        Statement((at_least("x >= 0", X), equal("xy = 0", X * Y, 0)), equal("y = 0", Y)),
        "its multiplier may be zero",
    ),
    "a square for a multiplier": (
        Certificate((), {"x²y = 0": constant(1)}, (term(squared=X),)),
        Statement((equal("x²y = 0", X**2 * Y),), equal("y = 0", Y)),
        "its multiplier may be zero",
    ),
    "the square of zero for a multiplier": (
        Certificate(multiplier=(term(squared=0),)),
        Statement((), at_least("x >= 0", X)),
        "its multiplier may be zero",
    ),
    "a strict conclusion from what may be zero": (
        Certificate((term("x >= 0"),)),
        Statement((at_least("x >= 0", X),), above("x > 0", X)),
        "no term is positive, but the conclusion is strict",
    ),
    "a strict conclusion from a square": (
        Certificate((term(squared=X),)),
        Statement((), above("x² > 0", X**2)),
        "no term is positive, but the conclusion is strict",
    ),
    "a strict conclusion from a factor of zero": (
        Certificate((term("x >= 0"), term(factor=0))),
        Statement((at_least("x >= 0", X),), above("x > 0", X)),
        "no term is positive, but the conclusion is strict",
    ),
    "a strict conclusion from an equation": (
        Certificate((), {"x = 0": constant(1)}),
        Statement((equal("x = 0", X),), above("x > 0", X)),
        "no term is positive, but the conclusion is strict",
    ),
    "one strict factor of two": (
        Certificate((term("x > 0", "y >= 0"),)),
        Statement((above("x > 0", X), at_least("y >= 0", Y)), above("xy > 0", X * Y)),
        "no term is positive, but the conclusion is strict",
    ),
    "an equation from an inequality": (
        Certificate((term("x >= 0"),)),
        Statement((at_least("x >= 0", X),), equal("x = 0", X)),
        "an equation follows from equations only",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_certificate_is_refused(name: str) -> None:
    """Each planted error is a fault, and the fault is named; most would prove what is false."""
    certificate, statement, fault = WRONG[name]
    assert fault in (certificate.fault(statement) or "")


#: Right certificates for strict conclusions, equations and multipliers.
RIGHT: dict[str, tuple[Certificate, Statement]] = {
    "strict": (
        Certificate((term("x > 0", "x > 0", factor=F(1, 2)), term(squared=Y))),
        Statement((above("x > 0", X),), above("x²/2 + y² > 0", X**2 / 2 + Y**2)),
    ),
    "strict for a constant": (Certificate((term(), term(squared=X))), Statement((), above("x² + 1 > 0", X**2 + 1))),
    "equation": (
        Certificate((), {"x = 0": Y}),
        Statement((equal("x = 0", X),), equal("xy = 0", X * Y)),
    ),
    "equation with a multiplier": (
        Certificate((), {"xy = 0": constant(1)}, (term("x > 0"),)),
        Statement((above("x > 0", X), equal("xy = 0", X * Y)), equal("y = 0", Y)),
    ),
    "multiplier": (
        Certificate((term("xy >= 0"),), multiplier=(term("x > 0"),)),
        Statement((above("x > 0", X), at_least("xy >= 0", X * Y)), at_least("y >= 0", Y)),
    ),
    "multiplier, one of its terms positive": (
        Certificate((term("x(1 + y²) >= 0"),), multiplier=(term(), term(squared=Y))),
        Statement((at_least("x(1 + y²) >= 0", X * (1 + Y**2)),), at_least("x >= 0", X)),
    ),
    "contradictory hypotheses": (
        Certificate((term("x >= 1"), term("x <= 0"))),
        Statement((at_least("x >= 1", X, 1), at_least("x <= 0", 0, X)), at_least("-1 >= 0", -1)),
    ),
}


@pytest.mark.parametrize("name", RIGHT)
def test_a_right_certificate_is_accepted(name: str) -> None:
    """Strictness, equations and multipliers are used where they may be."""
    certificate, statement = RIGHT[name]
    assert certificate.fault(statement) is None


numbers = st.fractions(-3, 3, max_denominator=3)
signs = st.sampled_from((at_least, above, equal))
polynomials = st.builds(
    lambda a, b, c, d, e: a * X * Y + b * X + c * Y + d + e * X**2, *(st.sampled_from((-1, 0, 1)) for _ in range(5))
)


@st.composite
def certified(draw: st.DrawFn) -> tuple[Certificate, Statement]:
    """Draw a statement whose conclusion is what a random certificate makes of its hypotheses."""
    hypotheses = tuple(draw(signs)(name, draw(polynomials)) for name in "abc")
    names = st.lists(st.sampled_from("abc"), max_size=2).map(tuple)
    terms = st.lists(st.builds(Term, names, polynomials, st.sampled_from((F(-1), F(0), F(1), F(2)))), max_size=2)
    chosen = tuple(draw(terms))
    equations = draw(st.dictionaries(st.sampled_from("abc"), polynomials, max_size=1))
    known = {each.name: each.value for each in hypotheses}
    total = sum((known[name] * factor for name, factor in equations.items()), constant(0))
    for each in chosen:
        product = each.factor * each.squared**2
        for name in each.hypotheses:
            product = product * known[name]
        total = total + product
    # the conclusion is right, or a little off, or times the multiplier
    conclusion: Condition = draw(signs)("conclusion", total + draw(st.sampled_from((0, 0, 0, -1))))
    multiplier = draw(st.sampled_from(((term(),), (term(factor=0),), (term(squared=X),), ())))
    return Certificate(chosen, equations, multiplier), Statement(hypotheses, conclusion)


grid_values = st.fixed_dictionaries(
    {"x": st.sampled_from([F(n, 2) for n in range(-4, 5)]), "y": st.sampled_from([F(n, 2) for n in range(-4, 5)])}
)


@settings(max_examples=500, deadline=None)
@given(certified(), grid_values)
def test_what_a_certificate_proves_is_never_refuted(
    made: tuple[Certificate, Statement], values: dict[str, Fraction]
) -> None:
    """Whatever certificate has no fault, its statement is true at random numbers: no vectors refute it."""
    certificate, statement = made
    if certificate.fault(statement) is None:
        assert Vectors(values).fault(statement) is not None


VALUES = {"x": F(1), "y": F(1)}
FALSE = Statement((at_least("x >= 1", X, 1), equal("y is x", Y, X)), above("xy > 1", X * Y, 1))


def test_vectors_refute() -> None:
    """Numbers for which all hypotheses hold and the conclusion does not have no fault, the boundary included."""
    assert Vectors(VALUES).fault(FALSE) is None


@pytest.mark.parametrize(
    ("values", "statement", "fault"),
    [
        ({"x": F(1)}, FALSE, "no value for y"),
        ({"x": F(0), "y": F(0)}, FALSE, "the hypothesis 'x >= 1' does not hold"),
        ({"x": F(1), "y": F(2)}, FALSE, "the hypothesis 'y is x' does not hold"),
        (VALUES, replace(FALSE, hypotheses=(above("x > 1", X, 1), *FALSE.hypotheses)), "'x > 1' does not hold"),
        ({"x": F(2), "y": F(2)}, FALSE, "the conclusion holds"),
        (VALUES, TRUE, "the conclusion holds"),
        (cast("dict[str, Fraction]", {"x": 1.0, "y": F(1)}), FALSE, "x is no fraction"),
        (cast("dict[str, Fraction]", {"x": F(1), "y": float("nan")}), FALSE, "y is no fraction"),
    ],
)
def test_wrong_vectors_are_refused(values: dict[str, Fraction], statement: Statement, fault: str) -> None:
    """Numbers are missing, rounded, break a hypothesis, or do not break the conclusion."""
    assert fault in (Vectors(values).fault(statement) or "")


def test_vectors_may_have_more_numbers_than_are_needed() -> None:
    """A variable that does not occur may have a value."""
    assert Vectors({**VALUES, "unheard_of": F(1)}).fault(FALSE) is None


#: For x > 0 some u is at least 1 and at most 1 + x.
PROBLEM = Solvable((above("x > 0", X),), ("u",), (at_least("u >= 1", U, 1), at_least("u <= 1 + x", 1 + X, U)))
CHOICE = Candidate({"u": 1 + X / 2}, (Certificate((term("x > 0", factor=F(1, 2)),)),) * 2)


def test_a_candidate_proves() -> None:
    """A choice with a certificate for each constraint has no fault."""
    assert CHOICE.fault(PROBLEM) is None


#: What is wrong with a candidate.
WRONG_CHOICES: dict[str, tuple[Candidate, Solvable, str]] = {
    "no unknown is chosen": (replace(CHOICE, choice={}), PROBLEM, "the choice is not one of the unknowns"),
    "an unknown is left": (CHOICE, replace(PROBLEM, unknowns=("u", "v")), "the choice is not one of the unknowns"),
    "a parameter is chosen": (
        replace(CHOICE, choice={**CHOICE.choice, "x": constant(1)}),
        PROBLEM,
        "the choice is not one of the unknowns",
    ),
    "the choice depends on the unknown": (
        Candidate({"u": U}, CHOICE.certificates),
        PROBLEM,
        "the choice depends on the unknowns",
    ),
    "a certificate is missing": (
        replace(CHOICE, certificates=CHOICE.certificates[:1]),
        PROBLEM,
        "there must be a certificate for each constraint",
    ),
    "a certificate too many": (
        replace(CHOICE, certificates=(*CHOICE.certificates, Certificate())),
        PROBLEM,
        "there must be a certificate for each constraint",
    ),
    "another choice": (replace(CHOICE, choice={"u": 1 + X}), PROBLEM, "u >= 1: the two sides differ by"),
    "a choice that is too large": (
        Candidate(
            {"u": 1 + 2 * X}, (Certificate((term("x > 0", factor=2),)), Certificate((term("x > 0", factor=-1),)))
        ),
        PROBLEM,
        "u <= 1 + x: a term has a negative factor",
    ),
    "the unknown is bounded by a hypothesis": (
        Candidate({"u": constant(0)}, (Certificate((term("u >= 1"), term("u <= 0"))),)),
        Solvable((at_least("u >= 1", U, 1), at_least("u <= 0", -U)), ("u",), (at_least("u >= 1", U, 1),)),
        "a hypothesis speaks of the unknowns",
    ),
}


@pytest.mark.parametrize("name", WRONG_CHOICES)
def test_a_wrong_candidate_is_refused(name: str) -> None:
    """Unknowns are missing or too many, the choice uses them, or a constraint is not proved."""
    candidate, problem, fault = WRONG_CHOICES[name]
    assert fault in (candidate.fault(problem) or "")


#: u ≥ 1 and u ≤ x contradict each other for x = 0.
UNSOLVABLE = Solvable((at_least("x >= 0", X),), ("u",), (at_least("u >= 1", U, 1), at_least("u <= x", X, U)))
AT_ZERO = Unsolvable({"x": F(0)}, Certificate((term("u >= 1"), term("u <= x"))))


def test_a_contradiction_refutes() -> None:
    """Numbers for which the hypotheses hold and the constraints combine to −1 ≥ 0 have no fault."""
    assert AT_ZERO.fault(UNSOLVABLE) is None


@pytest.mark.parametrize(
    ("evidence", "problem", "fault"),
    [
        (replace(AT_ZERO, values={}), UNSOLVABLE, "no value for x"),
        (replace(AT_ZERO, values={"x": F(-1)}), UNSOLVABLE, "the hypothesis 'x >= 0' does not hold"),
        (replace(AT_ZERO, values={"x": F(1)}), UNSOLVABLE, "the two sides differ by -1"),
        (replace(AT_ZERO, values={"x": F(0), "u": F(0)}), UNSOLVABLE, "the unknowns must not have values"),
        (replace(AT_ZERO, values=cast("dict[str, Fraction]", {"x": 0.0})), UNSOLVABLE, "x is no fraction"),
        (
            replace(AT_ZERO, contradiction=Certificate((term("u >= 1", factor=2), term("u <= x")))),
            UNSOLVABLE,
            "the two sides differ by",
        ),
        (
            replace(AT_ZERO, contradiction=Certificate((term("x >= 0"),))),
            UNSOLVABLE,
            "it uses 'x >= 0', which is no hypothesis",
        ),
        (
            AT_ZERO,
            replace(UNSOLVABLE, constraints=(*UNSOLVABLE.constraints, at_least("u <= x", 2, U))),
            "two hypotheses have the same name",
        ),
        (
            Unsolvable({"x": F(0), "u": F(0)}, Certificate((term("u >= 1"),))),
            Solvable(UNSOLVABLE.hypotheses, ("u",), (at_least("u >= 1", U, 1),)),
            "the unknowns must not have values",
        ),
    ],
)
def test_a_wrong_contradiction_is_refused(evidence: Unsolvable, problem: Solvable, fault: str) -> None:
    """Numbers are missing, break a hypothesis, fix an unknown; or the constraints do not contradict each other."""
    assert fault in (evidence.fault(problem) or "")


bounds = st.integers(-3, 3)


@settings(max_examples=400, deadline=None)
@given(bounds, bounds, bounds, bounds, st.integers(0, 2), st.integers(0, 2), st.fractions(-4, 4, max_denominator=2))
@example(1, 0, 0, 1, 1, 1, F(0))
def test_no_unknown_meets_what_is_unsolvable(
    low: int, high: int, slope: int, x: int, first: int, second: int, u: Fraction
) -> None:
    """Whatever contradiction has no fault, no value of the unknown meets all constraints."""
    problem = Solvable((), ("u",), (at_least("low", U, low), at_least("high", high + slope * X, U)))
    evidence = Unsolvable({"x": F(x)}, Certificate((term("low", factor=first), term("high", factor=second))))
    if evidence.fault(problem) is None:
        assert not all(constraint.holds({"x": F(x), "u": u}) for constraint in problem.constraints)


def test_what_must_be_proved_of_a_choice() -> None:
    """The choice is put into every constraint, and the numbers into every constraint of a contradiction."""
    assert [each.conclusion.value for each in chosen_statements(PROBLEM, CHOICE.choice)] == [X / 2, X / 2]
    stated = contradiction_statement(UNSOLVABLE, {"x": F(3)})
    assert [each.value for each in stated.hypotheses] == [U - 1, 3 - U]
    assert stated.conclusion.value == constant(-1)


ON_FILE: list[tuple[str, Statement | Solvable, Evidence]] = [
    (f"{claim.key}: {name}", asked, EVIDENCE[claim.key][name])
    for claim in PROOF_CLAIMS
    for name, asked in claim.questions.items()
    if isinstance(asked, Statement | Solvable) and name in EVIDENCE.get(claim.key, {})
]
CERTIFICATES = [
    (name, asked, evidence)
    for name, asked, evidence in ON_FILE
    if isinstance(asked, Statement) and isinstance(evidence, Certificate)
]


@pytest.mark.parametrize(("name", "statement", "certificate"), CERTIFICATES, ids=[name for name, *_ in CERTIFICATES])
def test_a_certificate_on_file_with_an_error_is_refused(
    name: str, statement: Statement, certificate: Certificate
) -> None:
    """Each term of each certificate matters: with another factor, or without it, the identity is none."""
    assert certificate.fault(statement) is None
    for n, each in enumerate(certificate.terms):
        if _product(each, statement) == constant(0):
            continue
        others = certificate.terms[:n], certificate.terms[n + 1 :]
        assert replace(certificate, terms=(*others[0], *others[1])).fault(statement) is not None
        doubled = replace(each, factor=2 * each.factor)
        assert replace(certificate, terms=(*others[0], doubled, *others[1])).fault(statement) is not None
    for equation, factor in certificate.equations.items():
        wrong = {**certificate.equations, equation: factor + variable("d")}
        assert replace(certificate, equations=wrong).fault(statement) is not None


def _product(each: Term, statement: Statement) -> Polynomial:
    known = {hypothesis.name: hypothesis.value for hypothesis in statement.hypotheses}
    product = each.factor * each.squared**2
    for name in each.hypotheses:
        product = product * known[name]
    return product


def _forged(monomial: tuple[tuple[str, object], ...], coefficient: object) -> Polynomial:
    forged: Any = {monomial: coefficient}
    return Polynomial(forged)


@pytest.mark.parametrize(
    "forged",
    [
        _forged((("x", Fraction(1, 2)),), Fraction(1)),
        _forged((("x", -1),), Fraction(1)),
        _forged((), 1j),
        _forged((), 1.0),
        _forged((("x", 1), ("x", 1)), Fraction(1)),
        _forged((("y", 1), ("x", 1)), Fraction(1)),
    ],
    ids=["root", "inverse", "imaginary", "float", "a name twice", "unsorted"],
)
def test_what_is_no_polynomial_proves_nothing(forged: Polynomial) -> None:
    """The square of a root, or of an imaginary number, is not taken for a square of a polynomial."""
    nothing = Statement((equal("x = 0", variable("x")),), Condition("c", forged * forged))
    assert "no polynomial" in str(Certificate((term(squared=forged),)).fault(nothing))
    by_equation = Certificate((), {"x = 0": forged})
    assert "no polynomial" in str(by_equation.fault(nothing))
    problem = Solvable((), ("u",), (Condition("c", variable("u")),))
    chosen = Candidate({"u": forged}, (Certificate((term(squared=forged),)),))
    assert "no polynomial" in str(chosen.fault(problem))


def test_a_factor_is_a_fraction() -> None:
    """A float, whatever its value, is no factor of a term."""
    factor: Any = 1.0
    certificate = Certificate((Term((), constant(1), factor),))
    assert "no fraction" in str(certificate.fault(Statement((), Condition("c", constant(1)))))
