"""Statements as formulas of z3's nonlinear real arithmetic: a second opinion that shares nothing with the certificates.

Only a statement's polynomials are read, never the evidence. z3 is helped in one way: coordinates may be chosen. Where
no formula changes when all vectors are moved and turned together, which is checked, the first point is the origin, the
second is on the x axis, and the third in the plane z = 0; and if the second's length has a name, it is where that says.
Without it, z3 gives up at Cauchy-Schwarz in space.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import cache, reduce

import z3  # type: ignore[import-untyped]

from swarmproof.algebra.polynomial import Number, Polynomial, Values, variable
from swarmproof.algebra.statement import Condition, Sign, Solvable, Statement

#: How far z3 goes before it gives up, in its own units, so that answers do not depend on the machine; up to a second.
EFFORT = 300_000
_SMALL = "a small motion"
_AXES = (("x", "y"), ("y", "z"), ("z", "x"))


def real(polynomial: Polynomial) -> z3.ArithRef:
    """Return a polynomial as a term of z3."""
    summands = []
    for monomial, coefficient in polynomial.terms.items():
        factors = [z3.Real(name) for name, exponent in monomial for _ in range(exponent)]
        summands.append(reduce(lambda a, b: a * b, factors, _number(coefficient)))
    return z3.Sum(summands) if summands else z3.RealVal(0)


def formula(condition: Condition) -> z3.BoolRef:
    """Return a condition as a formula of z3."""
    value = real(condition.value)
    match condition.sign:
        case Sign.AT_LEAST:
            return value >= 0
        case Sign.ABOVE:
            return value > 0
        case Sign.EQUAL:
            return value == 0


def refuted(statement: Statement, effort: int = EFFORT) -> str:
    """Return ``sat`` if the statement is false, ``unsat`` if it is true, or ``unknown``."""
    chosen = _frame(statement)
    conclusion = formula(statement.conclusion.put(chosen))
    return _solve((*_formulas(statement.hypotheses, chosen), z3.Not(conclusion)), effort)


def contradictory(statement: Statement, effort: int = EFFORT) -> str:
    """Return ``sat`` if the hypotheses of a statement can be met, ``unsat`` if they contradict each other."""
    return _solve(_formulas(statement.hypotheses, _frame(statement)), effort)


def insoluble(problem: Solvable, effort: int = EFFORT) -> str:
    """Return ``sat`` if for some values of its parameters a problem has no solution, ``unsat`` if it always has one."""
    unknowns = [z3.Real(name) for name in problem.unknowns]
    none = z3.Not(z3.And(*map(formula, problem.constraints)))
    return _solve((*map(formula, problem.hypotheses), z3.ForAll(unknowns, none) if unknowns else none), effort)


def solved(problem: Solvable, values: Values, effort: int = EFFORT) -> str:
    """Return ``sat`` if the problem has a solution where its parameters have these values, else ``unsat``."""
    given = [z3.Real(name) == _number(value) for name, value in values.items()]
    return _solve((*given, *map(formula, problem.constraints)), effort)


def true_at(condition: Condition, values: Values) -> bool:
    """Decide a condition where the variables have these values, by z3's arithmetic."""
    put = z3.substitute(formula(condition), *((z3.Real(name), _number(value)) for name, value in values.items()))
    return bool(z3.is_true(z3.simplify(put)))


def _number(value: Fraction) -> z3.ArithRef:
    return z3.Q(value.numerator, value.denominator)


def _formulas(conditions: Iterable[Condition], chosen: dict[str, Polynomial | Number]) -> Iterator[z3.BoolRef]:
    return (formula(condition.put(chosen)) for condition in conditions)


def _solve(formulas: Iterable[z3.BoolRef], effort: int) -> str:
    solver = z3.Solver()
    solver.set("rlimit", effort)
    solver.add(*formulas)
    return str(solver.check())


@cache
def _frame(statement: Statement) -> dict[str, Polynomial | Number]:
    """Return coordinates that may be chosen: what is put for them."""
    conditions = (*statement.hypotheses, statement.conclusion)
    names = frozenset().union(*(condition.value.variables for condition in conditions))
    # the normal is along x: old positions come first
    bodies = sorted((name[:-2] for name in names if name.endswith("_x")), key=lambda body: ("old" not in body, body))
    if len(bodies) < 2 or not all(f"{body}_{axis}" in names for body in bodies for axis in "xyz"):
        return {}
    polynomials = [condition.value for condition in conditions]
    if not all(_unmoved(each, _turn(bodies, *axes)) for each in polynomials for axes in _AXES):
        return {}
    chosen: dict[str, Polynomial | Number] = {}
    if all(_unmoved(each, _shift(bodies, axis)) for each in polynomials for axis in "xyz"):
        origin, *bodies = bodies
        chosen |= {f"{origin}_{axis}": 0 for axis in "xyz"}
    for body, fixed in zip(bodies, ("yz", "z"), strict=False):
        chosen |= {f"{body}_{axis}": 0 for axis in fixed}
    return chosen | _length_of(f"{bodies[0]}_x", statement.hypotheses, chosen)


def _length_of(
    name: str, conditions: Iterable[Condition], chosen: dict[str, Polynomial | Number]
) -> dict[str, Polynomial | Number]:
    """Return the variable that a hypothesis says to be plus or minus this coordinate: it may be turned to be plus."""
    for condition in conditions:
        if condition.sign is Sign.EQUAL:
            value = condition.value.put(chosen)
            for other in value.variables - {name}:
                if value in (variable(other) ** 2 - variable(name) ** 2, variable(name) ** 2 - variable(other) ** 2):
                    return {name: variable(other)}
    return {}


def _turn(bodies: list[str], one: str, other: str) -> dict[str, Polynomial | Number]:
    """Return the small turn of all vectors in the plane of two axes."""
    small, motion = variable(_SMALL), dict[str, Polynomial | Number]()
    for a, b in ((f"{body}_{one}", f"{body}_{other}") for body in bodies):
        motion |= {a: variable(a) - small * variable(b), b: variable(b) + small * variable(a)}
    return motion


def _shift(bodies: list[str], axis: str) -> dict[str, Polynomial | Number]:
    """Return the small shift of all points along an axis."""
    return {f"{body}_{axis}": variable(f"{body}_{axis}") + variable(_SMALL) for body in bodies}


def _unmoved(polynomial: Polynomial, motion: dict[str, Polynomial | Number]) -> bool:
    """Say whether a polynomial is the same under a motion: its derivative along the motion is zero everywhere."""
    return all((_SMALL, 1) not in monomial for monomial in polynomial.put(motion).terms)
