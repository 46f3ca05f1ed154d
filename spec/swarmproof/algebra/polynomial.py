"""Polynomials with rational coefficients: the language in which the statements of the proofs are written.

One polynomial serves every use: with numbers for its variables it is a number, exactly; expanded, it can be compared
with another; printed, it is an expression of Python.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

#: A product of powers of variables, sorted by name; exponents are at least 1.
Monomial = tuple[tuple[str, int], ...]
Number = int | Fraction
Values = Mapping[str, Fraction]


class Polynomial:
    """A polynomial; immutable, equal to another if their difference expands to zero."""

    __slots__ = ("terms",)

    def __init__(self, terms: Mapping[Monomial, Fraction]) -> None:
        self.terms: Mapping[Monomial, Fraction] = {m: c for m, c in terms.items() if c}

    def __add__(self, other: Polynomial | Number) -> Polynomial:
        terms = dict(self.terms)
        for monomial, coefficient in as_polynomial(other).terms.items():
            terms[monomial] = terms.get(monomial, Fraction(0)) + coefficient
        return Polynomial(terms)

    def __neg__(self) -> Polynomial:
        return Polynomial({monomial: -coefficient for monomial, coefficient in self.terms.items()})

    def __sub__(self, other: Polynomial | Number) -> Polynomial:
        return self + -as_polynomial(other)

    def __mul__(self, other: Polynomial | Number) -> Polynomial:
        terms: dict[Monomial, Fraction] = {}
        for left, a in self.terms.items():
            for right, b in as_polynomial(other).terms.items():
                monomial = _product(left, right)
                terms[monomial] = terms.get(monomial, Fraction(0)) + a * b
        return Polynomial(terms)

    def __radd__(self, other: Number) -> Polynomial:
        return self + other

    def __rsub__(self, other: Number) -> Polynomial:
        return -self + other

    def __rmul__(self, other: Number) -> Polynomial:
        return self * other

    def __truediv__(self, other: Number) -> Polynomial:
        return self * (1 / Fraction(other))

    def __pow__(self, exponent: int) -> Polynomial:
        if exponent < 0:
            raise ValueError(f"{exponent} is no exponent of a polynomial: it must be at least 0")
        result = constant(1)
        for _ in range(exponent):
            result = result * self
        return result

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Polynomial) and self.terms == other.terms

    def __hash__(self) -> int:
        return hash(frozenset(self.terms.items()))

    def __repr__(self) -> str:
        return f"Polynomial({self})"

    def __str__(self) -> str:
        """Return an expression of Python; its variables are to be fractions (or integers, if no number has a '/')."""
        text = ""
        for monomial, coefficient in sorted(self.terms.items(), key=lambda term: (-_degree(term[0]), term[0])):
            factors = [name if exponent == 1 else f"{name}**{exponent}" for name, exponent in monomial]
            size = abs(coefficient)
            if size != 1 or not factors:
                factors.insert(0, str(size))
            sign = " - " if coefficient < 0 else " + "
            text += sign + "*".join(factors)
        return (text[3:] if text.startswith(" + ") else "-" + text[3:]) if text else "0"

    @property
    def variables(self) -> frozenset[str]:
        """The variables that occur."""
        return frozenset(name for monomial in self.terms for name, _ in monomial)

    def at(self, values: Values) -> Fraction:
        """Return the value where the variables have these values.

        Raises:
            KeyError: a variable has no value.
        """
        total = Fraction(0)
        for monomial, coefficient in self.terms.items():
            for name, exponent in monomial:
                coefficient *= values[name] ** exponent
            total += coefficient
        return total

    def put(self, replaced: Mapping[str, Polynomial | Number]) -> Polynomial:
        """Return the polynomial with these variables replaced."""
        total = constant(0)
        for monomial, coefficient in self.terms.items():
            product = constant(coefficient)
            for name, exponent in monomial:
                product = product * as_polynomial(replaced.get(name, variable(name))) ** exponent
            total = total + product
        return total


class Vector(tuple[Polynomial, ...]):
    """A vector of polynomials, of any dimension."""

    __slots__ = ()

    def __sub__(self, other: Vector) -> Vector:
        return Vector(a - b for a, b in zip(self, other, strict=True))

    def dot(self, other: Vector) -> Polynomial:
        """Return the scalar product."""
        return sum((a * b for a, b in zip(self, other, strict=True)), constant(0))

    @property
    def square(self) -> Polynomial:
        """The squared length."""
        return self.dot(self)


def constant(value: Number) -> Polynomial:
    """Return a number as a polynomial."""
    return Polynomial({(): Fraction(value)})


def variable(name: str) -> Polynomial:
    """Return the polynomial that is this variable."""
    return Polynomial({((name, 1),): Fraction(1)})


def variables(names: str) -> Iterator[Polynomial]:
    """Return variables; `names` are separated by spaces."""
    return map(variable, names.split())


def position(name: str) -> Vector:
    """Return a position in space, with variables ``name_x``, ``name_y``, ``name_z``."""
    return Vector(variable(f"{name}_{axis}") for axis in "xyz")


def as_polynomial(value: Polynomial | Number) -> Polynomial:
    """Return `value` as a polynomial."""
    return value if isinstance(value, Polynomial) else constant(value)


def _product(left: Monomial, right: Monomial) -> Monomial:
    if not left or not right:
        return left or right
    exponents = dict(left)
    for name, exponent in right:
        exponents[name] = exponents.get(name, 0) + exponent
    return tuple(sorted(exponents.items()))


def _degree(monomial: Monomial) -> int:
    return sum(exponent for _, exponent in monomial)
