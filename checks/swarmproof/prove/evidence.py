"""Evidence for and against statements over the reals, and the exact check of it.

A :class:`Certificate` proves a statement by an identity of polynomials that anybody can expand; a :class:`Vectors`
refutes it by rational numbers. Nothing here searches, and nothing is rounded: evidence either checks, or it is none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

from swarmproof.algebra.polynomial import Number, Polynomial, Values, as_polynomial, constant
from swarmproof.algebra.statement import Condition, Sign, Solvable, Statement


@dataclass(frozen=True, slots=True)
class Term:
    """A product that is not negative where the hypotheses hold: `factor` × hypotheses × a square.

    Attributes:
        hypotheses: names, each as often as it is a factor; none of an equation.
        squared: the polynomial whose square is a factor.
        factor: a number, at least 0.
    """

    hypotheses: tuple[str, ...] = ()
    squared: Polynomial = field(default_factory=lambda: constant(1))
    factor: Fraction = Fraction(1)


def term(*hypotheses: str, squared: Polynomial | Number = 1, factor: Number = 1) -> Term:
    """Return a term; see :class:`Term`."""
    return Term(hypotheses, as_polynomial(squared), Fraction(factor))


@dataclass(frozen=True, slots=True)
class Certificate:
    """An identity that proves a statement: multiplier × conclusion = Σ terms + Σ polynomial × equation.

    Attributes:
        terms: what the conclusion is made of.
        equations: by name of an equation among the hypotheses, the polynomial by which it is multiplied.
        multiplier: terms of which at least one is positive wherever the hypotheses hold.
    """

    terms: tuple[Term, ...] = ()
    equations: Mapping[str, Polynomial] = field(default_factory=dict)
    multiplier: tuple[Term, ...] = (Term(),)

    def fault(self, statement: Statement) -> str | None:
        """Return why this does not prove `statement`; None if it does."""
        used = [*self.equations.values(), *(each.squared for each in (*self.terms, *self.multiplier))]
        if not all(map(_proper, used)):
            return "it has something that is no polynomial with rational coefficients"
        known = {hypothesis.name: hypothesis for hypothesis in statement.hypotheses}
        if len(known) < len(statement.hypotheses):
            return "two hypotheses have the same name"
        for name in (*self.equations, *(name for t in (*self.terms, *self.multiplier) for name in t.hypotheses)):
            if name not in known:
                return f"it uses {name!r}, which is no hypothesis"
        try:
            total = _sum(self.terms, known)
            multiplier = _sum(self.multiplier, known)
        except ValueError as error:
            return str(error)
        for name, factor in self.equations.items():
            if known[name].sign is not Sign.EQUAL:
                return f"it uses {name!r} as an equation, which it is not"
            total = total + factor * known[name].value
        if not any(_positive(t, known) for t in self.multiplier):
            return "its multiplier may be zero"
        sign = statement.conclusion.sign
        if sign is Sign.EQUAL and self.terms:
            return "an equation follows from equations only"
        if sign is Sign.ABOVE and not any(_positive(t, known) for t in self.terms):
            return "no term is positive, but the conclusion is strict"
        difference = multiplier * statement.conclusion.value - total
        return None if difference == constant(0) else f"the two sides differ by {difference}"


@dataclass(frozen=True, slots=True)
class Vectors:
    """Numbers for which the hypotheses of a statement hold and its conclusion does not."""

    values: Values

    def fault(self, statement: Statement) -> str | None:
        """Return why these do not refute `statement`; None if they do."""
        conditions = (*statement.hypotheses, statement.conclusion)
        for name in sorted({name for condition in conditions for name in condition.value.variables}):
            if name not in self.values:
                return f"no value for {name}"
        if inexact := _inexact(self.values):
            return inexact
        for hypothesis in statement.hypotheses:
            if not hypothesis.holds(self.values):
                return f"the hypothesis {hypothesis.name!r} does not hold"
        return "the conclusion holds" if statement.conclusion.holds(self.values) else None


@dataclass(frozen=True, slots=True)
class Candidate:
    """A choice of the unknowns that solves a problem wherever the hypotheses hold, one certificate per constraint."""

    choice: Mapping[str, Polynomial]
    certificates: Sequence[Certificate]

    def fault(self, problem: Solvable) -> str | None:
        """Return why this does not prove `problem` solvable; None if it does."""
        if any(hypothesis.value.variables & set(problem.unknowns) for hypothesis in problem.hypotheses):
            return "a hypothesis speaks of the unknowns"
        if set(self.choice) != set(problem.unknowns):
            return "the choice is not one of the unknowns"
        if not all(map(_proper, self.choice.values())):
            return "a choice is no polynomial with rational coefficients"
        if any(chosen.variables & set(problem.unknowns) for chosen in self.choice.values()):
            return "the choice depends on the unknowns"
        if len(self.certificates) != len(problem.constraints):
            return "there must be a certificate for each constraint"
        for certificate, statement in zip(self.certificates, chosen_statements(problem, self.choice), strict=True):
            fault = certificate.fault(statement)
            if fault is not None:
                return f"{statement.conclusion.name}: {fault}"
        return None


@dataclass(frozen=True, slots=True)
class Unsolvable:
    """Numbers for which the hypotheses hold, and a certificate that the constraints then contradict each other."""

    values: Values
    contradiction: Certificate

    def fault(self, problem: Solvable) -> str | None:
        """Return why this does not refute that `problem` is solvable; None if it does."""
        if inexact := _inexact(self.values):
            return inexact
        for hypothesis in problem.hypotheses:
            missing = hypothesis.value.variables - self.values.keys()
            if missing:
                return f"no value for {min(missing)}"
            if not hypothesis.holds(self.values):
                return f"the hypothesis {hypothesis.name!r} does not hold"
        if not self.values.keys().isdisjoint(problem.unknowns):
            return "the unknowns must not have values"
        return self.contradiction.fault(contradiction_statement(problem, self.values))


def chosen_statements(problem: Solvable, choice: Mapping[str, Polynomial]) -> list[Statement]:
    """Return what must be proved for `choice` to solve the problem, one statement per constraint."""
    return [Statement(problem.hypotheses, constraint.put(dict(choice))) for constraint in problem.constraints]


def contradiction_statement(problem: Solvable, values: Values) -> Statement:
    """Return the statement that the constraints, with these values, imply −1 ≥ 0."""
    constraints = tuple(constraint.put(dict(values)) for constraint in problem.constraints)
    return Statement(constraints, Condition("a contradiction", constant(-1)))


Evidence = Certificate | Vectors | Candidate | Unsolvable


def _inexact(values: Values) -> str | None:
    """Say which value is no fraction: whatever else is a number may be rounded."""
    return next((f"{name} is no fraction" for name, value in values.items() if type(value) is not Fraction), None)


def _proper(polynomial: Polynomial) -> bool:
    """Say whether all coefficients are fractions and all monomials products of powers: nothing is taken on trust."""
    return all(
        type(coefficient) is Fraction
        and all(type(exponent) is int and exponent >= 1 for _, exponent in monomial)
        and all(one < other for (one, _), (other, _) in pairwise(monomial))
        for monomial, coefficient in polynomial.terms.items()
    )


def _sum(terms: Sequence[Term], known: Mapping[str, Condition]) -> Polynomial:
    total = constant(0)
    for each in terms:
        if type(each.factor) is not Fraction:
            raise ValueError("a term has a factor that is no fraction")
        if each.factor < 0:
            raise ValueError("a term has a negative factor")
        product = each.squared * each.squared * each.factor
        for name in each.hypotheses:
            if known[name].sign is Sign.EQUAL:
                raise ValueError(f"a term uses the equation {name!r}")
            product = product * known[name].value
        total = total + product
    return total


def _positive(each: Term, known: Mapping[str, Condition]) -> bool:
    """Say whether a term is surely positive where the hypotheses hold."""
    square = each.squared.terms
    return each.factor > 0 and set(square) == {()} and all(known[name].sign is Sign.ABOVE for name in each.hypotheses)
