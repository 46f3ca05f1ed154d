"""Polynomials against arithmetic: the laws of a ring, and expanding, putting and printing mean the same numbers."""

from __future__ import annotations

import re
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarmproof.algebra.polynomial import (
    Polynomial,
    Vector,
    as_polynomial,
    constant,
    position,
    variable,
    variables,
)

NAMES = ("x", "y", "z_x")
X, Y, Z = variables("x y z_x")

fractions = st.fractions(-5, 5, max_denominator=6)
values = st.fixed_dictionaries(dict.fromkeys(NAMES, fractions))
monomials = st.dictionaries(st.sampled_from(NAMES), st.integers(1, 3), max_size=3)
polynomials = st.lists(st.tuples(fractions, monomials), max_size=4).map(
    lambda terms: sum((coefficient * product(powers) for coefficient, powers in terms), constant(0))
)


def product(powers: dict[str, int]) -> Polynomial:
    """Return a product of powers, by multiplication only."""
    result = constant(1)
    for name, exponent in powers.items():
        for _ in range(exponent):
            result = result * variable(name)
    return result


@given(polynomials, polynomials, polynomials)
def test_polynomials_are_a_ring(a: Polynomial, b: Polynomial, c: Polynomial) -> None:
    """Sum and product commute, associate and distribute; 0 and 1 are neutral; a − a is 0."""
    assert a + b == b + a
    assert a * b == b * a
    assert (a + b) + c == a + (b + c)
    assert (a * b) * c == a * (b * c)
    assert a * (b + c) == a * b + a * c
    assert a + 0 == a == a * 1 == 1 * a == 0 + a
    assert a - a == constant(0) == a * 0
    assert a - b == -(b - a)
    assert 3 - a == -(a - 3)
    assert a / 3 * 3 == a
    assert a**3 == a * a * a
    assert a**0 == constant(1)


@given(polynomials, polynomials, values)
def test_values_are_those_of_numbers(a: Polynomial, b: Polynomial, at: dict[str, Fraction]) -> None:
    """The value of a sum, a product, a power is that of the values."""
    assert (a + b).at(at) == a.at(at) + b.at(at)
    assert (a - b).at(at) == a.at(at) - b.at(at)
    assert (a * b).at(at) == a.at(at) * b.at(at)
    assert (a**2).at(at) == a.at(at) ** 2
    assert (a / 7).at(at) == a.at(at) / 7


@given(polynomials, values)
def test_the_printed_polynomial_is_an_expression(a: Polynomial, at: dict[str, Fraction]) -> None:
    """What str() returns is Python: with fractions for all numbers, it has the polynomial's value."""
    exact = re.sub(r"(?<![\w.])(\d+)", r"F(\1)", str(a))
    assert eval(exact, {"F": Fraction, **at}) == a.at(at)


@given(polynomials)
def test_equal_polynomials_have_equal_hashes(a: Polynomial) -> None:
    """A polynomial that is built in another way is the same key."""
    again = (a + X) * 2 - a - 2 * X
    assert again == a
    assert hash(again) == hash(a)


@given(polynomials, polynomials, polynomials, values)
def test_putting_is_the_value_at_the_values(
    a: Polynomial, for_x: Polynomial, for_y: Polynomial, at: dict[str, Fraction]
) -> None:
    """Variables are replaced all at once: the result has the value that `a` has where x and y are their values."""
    put = a.put({"x": for_x, "y": for_y})
    assert put.at(at) == a.at({**at, "x": for_x.at(at), "y": for_y.at(at)})
    assert a.put({}) == a
    assert a.put({"unheard_of": 1}) == a


@given(polynomials, values)
def test_putting_numbers_leaves_a_number(a: Polynomial, at: dict[str, Fraction]) -> None:
    """With numbers for all variables, a constant is left, and it is the value."""
    assert a.put(dict(at)) == constant(a.at(at))


def test_swapping_is_at_once() -> None:
    """Two variables can be exchanged."""
    assert (X - Y**2).put({"x": Y, "y": X}) == Y - X**2


@given(polynomials, values)
def test_variables_are_those_that_matter(a: Polynomial, at: dict[str, Fraction]) -> None:
    """A value is needed for the variables that occur, and for no others; what cancels does not occur."""
    assert a.at({name: at[name] for name in a.variables}) == a.at(at)
    for name in a.variables:
        with pytest.raises(KeyError):
            a.at({other: value for other, value in at.items() if other != name})
    assert (a - a + Y).variables == {"y"}


@given(polynomials)
def test_terms_have_no_zeros(a: Polynomial) -> None:
    """No coefficient is zero and no exponent less than 1, and names are in order: equality is that of terms."""
    for monomial, coefficient in a.terms.items():
        assert coefficient
        assert list(monomial) == sorted(monomial)
        assert len({name for name, _ in monomial}) == len(monomial)
        assert all(exponent >= 1 for _, exponent in monomial)


def test_how_polynomials_are_printed() -> None:
    """Terms of high degree come first, and ones are not written."""
    assert str(X**2 * Y - 2 * X + Fraction(1, 3) - Y) == "x**2*y - 2*x - y + 1/3"
    assert str(-X) == "-x"
    assert str(constant(0)) == "0"
    assert repr(constant(-1)) == "Polynomial(-1)"


def test_polynomials_are_no_numbers() -> None:
    """A polynomial equals no number; numbers are made polynomials where they are combined."""
    assert constant(1) != 1
    assert as_polynomial(1) == constant(1)
    assert as_polynomial(X) is X


def test_vectors() -> None:
    """Difference, scalar product and length are those of vectors; dimensions must agree."""
    a, b = position("a"), position("b")
    assert [str(entry) for entry in a - b] == ["a_x - b_x", "a_y - b_y", "a_z - b_z"]
    assert (a - b).square == a.square - 2 * a.dot(b) + b.square
    with pytest.raises(ValueError, match="argument 2 is shorter"):
        a.dot(Vector(b[:2]))


def test_a_negative_power_is_refused() -> None:
    """A polynomial has no negative powers, and says so."""
    with pytest.raises(ValueError, match="-1 is no exponent"):
        variable("x") ** -1
