"""Fleets of several kinds: what a pair is bounded by."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmproof.errors import BadInput
from swarmproof.theorem3.fleet import pair, pairs, read_kinds
from swarmproof.theorem3.inequality import scaled_square
from swarmproof.theorem3.parameters import Parameters

BASE = Parameters().with_changes(["a_max=10"])
LARGE = {"name": "large", "uavs": [0, 3], "v_max": 2, "d_hat_min": "0.6"}
MIDDLE = {"name": "middle", "uavs": [1], "v_max": "1.5", "d_hat_min": "0.4"}


def test_a_pair_has_the_sum_of_the_radii_and_the_mean_of_the_bounds() -> None:
    """Radii 0.3 and 0.2 m, 2 and 1.5 m/s: the pair keeps 0.5 m, and is like two UAVs with 1.75 m/s."""
    large, middle = read_kinds([LARGE, MIDDLE], BASE)
    both = pair(large.parameters, middle.parameters)
    assert both == BASE.with_changes(["d_hat_min=0.5", "v_max=1.75"])


def test_a_single_uav_has_no_pair_with_its_own_kind() -> None:
    """There are two large UAVs and one of middle size: two pairs of kinds, not three."""
    assert [one.names for one in pairs(read_kinds([LARGE, MIDDLE], BASE))] == [("large", "large"), ("large", "middle")]


diagonals = st.lists(st.fractions(Fraction(1, 8), 2, max_denominator=8), min_size=3, max_size=3)
points = st.lists(st.fractions(-3, 3, max_denominator=20), min_size=3, max_size=3)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(diagonals, diagonals, points, points)
def test_the_ellipsoid_of_a_pair_contains_both(
    one: list[Fraction], other: list[Fraction], x: list[Fraction], y: list[Fraction]
) -> None:
    """Two ellipsoids laid against each other are in that of the pair: ‖A(x + y)‖ ≤ ‖A_i x‖ + ‖A_j y‖."""
    tables = [{"theta_inverse": [str(entry) for entry in entries]} for entries in (one, other)]
    first, second = (kind.parameters for kind in read_kinds(tables, BASE))
    both = pair(first, second).theta_inverse
    total = tuple(a + b for a, b in zip(x, y, strict=True))
    lengths = [
        float(scaled_square(matrix, (vector[0], vector[1], vector[2]))) ** 0.5
        for matrix, vector in ((both, total), (first.theta_inverse, tuple(x)), (second.theta_inverse, tuple(y)))
    ]
    assert lengths[0] <= (lengths[1] + lengths[2]) * (1 + 1e-12)


MISTAKES: list[tuple[object, str]] = [
    ({"v_max": 2}, "kinds are tables: write a line [[kinds]]"),
    ([{"vmax": 2}], "there is no key 'vmax' here: did you mean v_max?"),
    ([{"uavs": "all"}], "uavs must be a list of UAVs, numbered from 0, such as uavs = [0, 3]"),
    ([LARGE, {"uavs": [3]}], "UAV 3 is of two kinds, large and kind 1: list it once"),
    ([{"name": "a"}, {"name": "a"}], "two kinds have one name"),
    ([{"name": ""}], "name must be a text of 1 to 40 characters"),
    ([{"v_max": -1}], "v_max must not be negative"),
    ([{}] * 65, "64 are the most"),
]


@pytest.mark.parametrize(("raw", "sentence"), MISTAKES, ids=[sentence[:30] for _, sentence in MISTAKES])
def test_a_mistake_is_refused_in_one_sentence(raw: object, sentence: str) -> None:
    """What a table of kinds cannot say is refused, with what would be right."""
    with pytest.raises(BadInput) as refused:
        read_kinds(raw, BASE)
    assert sentence in str(refused.value)
    assert "\n" not in str(refused.value)


def test_different_scalings_that_are_not_diagonal_are_refused() -> None:
    """Of two coupled scalings, no entry says which is the smaller."""
    coupled = [[1, "0.1", 0], ["0.1", 1, 0], [0, 0, 1]]
    one, other = read_kinds([{"theta_inverse": coupled}, {"theta_inverse": 1}], BASE)
    with pytest.raises(BadInput, match="must have diagonal ones"):
        pair(one.parameters, other.parameters)
