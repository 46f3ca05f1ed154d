"""Inequality (26): the corrected one implies eq. (2) and is not too strict, the printed one does not imply it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from swarmproof.theorem3.inequality import (
    Pair,
    Truth,
    corrected,
    counterexample,
    crossing_pair,
    guaranteed_separation,
    hovering_pair,
    printed,
    spectral_norm_bounds,
    square_root_bounds,
)
from swarmproof.theorem3.parameters import PUBLISHED_SCALING, Parameters
from swarmproof.theorem3.values import Matrix, Vector, diagonal

#: The same examples every time, and no clock.
SETTINGS = settings(max_examples=80, deadline=None, derandomize=True, database=None)
ZERO = Fraction(0)
ORIGIN: Vector = (ZERO, ZERO, ZERO)


def _changed(*changes: str) -> Parameters:
    return Parameters().with_changes(changes)


def _minus(one: Vector, other: Vector) -> Vector:
    return (one[0] - other[0], one[1] - other[1], one[2] - other[2])


def _times(vector: Vector, factor: Fraction) -> Vector:
    return (vector[0] * factor, vector[1] * factor, vector[2] * factor)


def _square(vector: Vector) -> Fraction:
    return sum((part**2 for part in vector), ZERO)


def _scaled_square(matrix: Matrix, vector: Vector) -> Fraction:
    """Return ‖matrix·vector‖²."""
    return sum((sum((a * b for a, b in zip(row, vector, strict=True)), ZERO) ** 2 for row in matrix), ZERO)


def _of_length(direction: Vector, shortest: Fraction, scaling: Matrix) -> Vector:
    """Return `direction` with a scaled length of `shortest` or more, by a relative 1e-30 at most."""
    length, _ = square_root_bounds(_scaled_square(scaling, direction), digits=30)
    return _times(direction, shortest / length)


UNSCALED = diagonal((Fraction(1), Fraction(1), Fraction(1)))
lengths = st.decimals(min_value="0.001", max_value=2, places=3).map(Fraction)
errors = st.one_of(st.just(ZERO), st.decimals(min_value=0, max_value="0.2", places=3).map(Fraction))
stretches = st.decimals(min_value="0.1", max_value=5, places=2).map(Fraction)
diagonals: st.SearchStrategy[Matrix] = st.tuples(stretches, stretches, stretches).map(diagonal)
parts = st.integers(-20, 20).map(Fraction)
directions = st.tuples(parts, parts, parts).filter(any)


@st.composite
def coupled(draw: st.DrawFn) -> Matrix:
    """Draw a symmetric positive definite matrix BᵀB + I/10 that is usually not diagonal."""
    columns = [draw(st.tuples(*[st.integers(-9, 9)] * 3)) for _ in range(3)]
    a, b, c, d, e, f = (
        Fraction(sum(x * y for x, y in zip(columns[i], columns[j], strict=True)), 20)
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    )
    tenth = Fraction(1, 10)
    return ((a + tenth, b, c), (b, d + tenth, e), (c, e, f + tenth))


def _parameters(scalings: st.SearchStrategy[Matrix]) -> st.SearchStrategy[Parameters]:
    return st.builds(Parameters, theta_inverse=scalings, d_hat_min=lengths, d_min=lengths, tracking_error=errors)


# ------------------------------------------------------------------------------------------------ norms


@SETTINGS
@given(diagonals)
def test_the_norm_of_a_diagonal_matrix_is_exact(matrix: Matrix) -> None:
    """The norm of a diagonal matrix is its largest entry, without any rounding."""
    largest = max(matrix[axis][axis] for axis in range(3))
    assert spectral_norm_bounds(matrix) == (largest, largest)


@SETTINGS
@given(coupled(), st.sampled_from([3, 12, 20]))
def test_the_norm_bounds_enclose_what_numpy_says(matrix: Matrix, digits: int) -> None:
    """For any positive definite matrix the bounds are as close as promised and on either side of numpy's norm."""
    low, high = spectral_norm_bounds(matrix, digits)
    norm = float(np.linalg.norm(np.array(matrix, dtype=float), 2))
    assert float(low) <= norm * (1 + 1e-12)
    assert float(high) >= norm * (1 - 1e-12)
    assert 0 <= high - low <= high / 10**digits


@SETTINGS
@given(coupled(), directions)
def test_nothing_is_stretched_more_than_the_norm(matrix: Matrix, direction: Vector) -> None:
    """‖Av‖ ≤ high·‖v‖ for every v, in exact arithmetic."""
    _, high = spectral_norm_bounds(matrix, digits=6)
    assert _scaled_square(matrix, direction) <= high**2 * _square(direction)


@SETTINGS
@given(coupled(), st.sampled_from([Fraction(1, 1000), Fraction(10), Fraction(3, 7)]))
def test_the_norm_scales_with_the_matrix(matrix: Matrix, factor: Fraction) -> None:
    """The bounds for cA overlap with c times those for A."""
    x, y, z = (_times(row, factor) for row in matrix)
    low, high = spectral_norm_bounds(matrix)
    scaled_low, scaled_high = spectral_norm_bounds((x, y, z))
    assert scaled_low <= factor * high
    assert factor * low <= scaled_high


@pytest.mark.parametrize(
    ("matrix", "norm"),
    [
        ("2,1,0,1,2,0,0,0,1", "3"),
        ("2,-1,0,-1,2,0,0,0,1", "3"),
        ("2,0,0,0,1.9,1,0,1,1.9", "2.9"),
        ("3,0,0,0,1,0.5,0,0.5,1", "3"),
        ("1,0.5,0.5,0.5,1,0.5,0.5,0.5,1", "2"),
        ("0.7,-0.3,-0.3,-0.3,0.7,-0.3,-0.3,-0.3,0.7", "1"),
    ],
)
def test_a_norm_of_few_digits_is_found_exactly(matrix: str, norm: str) -> None:
    """If the norm of a matrix that is not diagonal has few digits, both bounds are the norm."""
    assert spectral_norm_bounds(_changed(f"theta_inverse={matrix}").theta_inverse) == (Fraction(norm), Fraction(norm))


def test_the_norm_of_any_matrix_is_enclosed() -> None:
    """The matrix need not be symmetric: a shear's norm is the golden ratio."""
    one = Fraction(1)
    low, high = spectral_norm_bounds(((one, one, ZERO), (ZERO, one, ZERO), (ZERO, ZERO, one)))
    assert low**2 < low + 1
    assert high**2 > high + 1


@SETTINGS
@given(st.fractions(min_value=0, max_value=10**6), st.integers(0, 10**12), st.sampled_from([1, 12]))
def test_square_roots_are_enclosed(value: Fraction, step: int, digits: int) -> None:
    """The bounds of a root are on either side of it and close; those of a square are its root."""
    for radicand in (value, value / (step + 1), Fraction(1, step + 1)):
        low, high = square_root_bounds(radicand, digits)
        assert low**2 <= radicand <= high**2
        assert (high - low) ** 2 <= radicand / 10 ** (2 * digits)
    assert square_root_bounds(value**2, digits) == (value, value)


def test_a_negative_number_has_no_square_root() -> None:
    """A negative radicand is a mistake of the caller."""
    with pytest.raises(ValueError, match="nonnegative"):
        square_root_bounds(Fraction(-1))


# ------------------------------------------------------------------------------- the two inequalities

#: d̂_min = 0.25, d_min = 0.12, Δd_min = 0.02: room for a dip of 0.11 as printed, and of 0.09 corrected.
ROOM = _changed("tracking_error=0.02")


@pytest.mark.parametrize(
    ("decide", "room"), [(printed, Fraction(11, 100)), (corrected, Fraction(9, 100))], ids=["printed", "corrected"]
)
def test_what_is_known_of_an_inequality(decide: Callable[..., Truth], room: Fraction) -> None:
    """It holds if the upper bound leaves room, fails if the lower one does not, and is undecided in between."""
    little = Fraction(1, 10**9)
    assert decide(ROOM, ZERO, room) is Truth.HOLDS
    assert decide(ROOM, room, room) is Truth.HOLDS
    assert decide(ROOM, room, room + little) is Truth.UNDECIDED
    assert decide(ROOM, room + little, room + 2 * little) is Truth.FAILS


def test_the_norm_counts_with_both_bounds() -> None:
    """Where the norm is known to 12 digits only, what depends on the next digit is undecided."""
    rough = _changed("theta_inverse=2,0.3,0,0.3,1,0.1,0,0.1,0.5", "tracking_error=0.02")
    low, high = spectral_norm_bounds(rough.theta_inverse)
    assert low < high
    for norm, expected in (
        (low, Truth.UNDECIDED),
        (high, Truth.HOLDS),
        (low - Fraction(1, 10**12), Truth.FAILS),
    ):
        just = replace(rough, d_hat_min=rough.d_min + 2 * norm * rough.tracking_error)
        assert corrected(just, ZERO, ZERO) is expected


def test_the_published_parameters_leave_room_without_tracking_errors() -> None:
    """With Δd_min = 0 the two inequalities are one, and the separation is what the dip leaves of d̂_min."""
    for decide in (printed, corrected):
        assert decide(Parameters(), ZERO, Fraction(13, 100)) is Truth.HOLDS
        assert decide(Parameters(), Fraction(14, 100), Fraction(1, 4)) is Truth.FAILS
    assert guaranteed_separation(Parameters(), Fraction(13, 100)) == Fraction(12, 100)


def test_the_guaranteed_separation_is_never_negative() -> None:
    """Once dip and errors use up d̂_min, nothing is guaranteed, which is a separation of 0."""
    assert guaranteed_separation(ROOM, Fraction(1, 20)) == Fraction(16, 100)
    assert guaranteed_separation(ROOM, Fraction(1, 4)) == 0
    assert guaranteed_separation(_changed("tracking_error=0.2", "theta_inverse=3"), ZERO) == 0


@SETTINGS
@given(_parameters(coupled()), lengths)
def test_the_corrected_inequality_is_about_the_guaranteed_separation(some: Parameters, dip: Fraction) -> None:
    """The corrected inequality holds if and only if the guaranteed separation is at least d_min."""
    assert (corrected(some, dip, dip) is Truth.HOLDS) == (guaranteed_separation(some, dip) >= some.d_min)


@SETTINGS
@given(_parameters(st.one_of(diagonals, coupled())), lengths, st.sampled_from([Fraction(1, 8), Fraction(100)]))
def test_lengths_have_no_unit(some: Parameters, dip: Fraction, factor: Fraction) -> None:
    """Measured in other units, every length multiplied by the same factor, both inequalities say the same."""
    other = replace(
        some,
        d_hat_min=factor * some.d_hat_min,
        d_min=factor * some.d_min,
        tracking_error=factor * some.tracking_error,
    )
    for decide in (printed, corrected):
        assert decide(other, factor * dip, factor * dip) is decide(some, dip, dip)
    assert guaranteed_separation(other, factor * dip) == factor * guaranteed_separation(some, dip)


@SETTINGS
@given(
    _parameters(st.one_of(diagonals, coupled())),
    lengths,
    st.tuples(directions, directions, directions),
    st.booleans(),
)
def test_the_corrected_inequality_implies_the_conclusion(
    some: Parameters, dip: Fraction, ways: tuple[Vector, Vector, Vector], opposed: bool
) -> None:
    """No references d̂_min − dip apart and no errors within Δd_min bring real UAVs closer than is guaranteed."""
    _, norm = spectral_norm_bounds(some.theta_inverse)
    # so that it just holds, which is where it is put to the test
    some = replace(some, d_hat_min=some.d_min + dip + 2 * norm * some.tracking_error)
    assert corrected(some, dip, dip) is Truth.HOLDS
    # towards each other, or anywhere
    away, first, second = (ways[0], _times(ways[0], Fraction(-1)), ways[0]) if opposed else ways
    relative = _of_length(away, some.d_hat_min - dip, some.theta_inverse)
    assert _scaled_square(some.theta_inverse, relative) >= (some.d_hat_min - dip) ** 2
    shorter = some.tracking_error * (1 - Fraction(1, 10**29))
    error_i, error_j = (_of_length(way, shorter, UNSCALED) for way in (first, second))
    assert max(_square(error_i), _square(error_j)) <= some.tracking_error**2
    real = _minus(relative, _minus(error_j, error_i))  # (p̂_i + e_i) − (p̂_j + e_j)
    assert _scaled_square(some.theta_inverse, real) >= some.d_min**2


# -------------------------------------------------------------------------------------- counterexamples


def _apart(some: Parameters, distance: Fraction) -> Pair:
    """Return references at this scaled distance along the axis that a diagonal Θ⁻¹ stretches most."""
    axis = max(range(3), key=lambda axis: some.theta_inverse[axis][axis])
    first = _times(UNSCALED[axis], distance / some.theta_inverse[axis][axis])
    return first, ORIGIN


def _check_counterexample(some: Parameters, references: Pair | None = None) -> bool:
    """Return whether there is a counterexample, having checked that it is one, in exact arithmetic."""
    found = counterexample(some, references)
    if found is None:
        return False
    for real, reference in zip(found.positions, found.references, strict=True):
        assert _square(_minus(real, reference)) <= some.tracking_error**2
    distance = _scaled_square(some.theta_inverse, _minus(*found.positions))
    reference_distance = _scaled_square(some.theta_inverse, _minus(*found.references))
    assert distance == found.squared_distance < some.d_min**2
    assert reference_distance == found.squared_reference_distance
    assert references == found.references or reference_distance >= some.d_hat_min**2
    assert (found.d_min, found.tracking_error) == (some.d_min, some.tracking_error)
    return True


@SETTINGS
@given(_parameters(diagonals))
def test_the_corrected_inequality_is_not_too_strict(some: Parameters) -> None:
    """For a diagonal Θ and no dip, there is a counterexample if and only if the corrected inequality fails."""
    assert _check_counterexample(some) == (corrected(some, ZERO, ZERO) is Truth.FAILS)


@SETTINGS
@given(_parameters(diagonals), st.fractions(0, 1, max_denominator=50))
def test_a_dip_and_the_errors_add_up(some: Parameters, share: Fraction) -> None:
    """References that dip along the axis stretched most are brought together if and only if the corrected one fails."""
    dip = share * some.d_hat_min
    found = _check_counterexample(some, _apart(some, some.d_hat_min - dip))
    assert found == (corrected(some, dip, dip) is Truth.FAILS)


@SETTINGS
@given(_parameters(coupled()))
def test_a_coupled_scaling_is_refuted_too(some: Parameters) -> None:
    """For any Θ: none if the corrected inequality holds, and one if it fails by more than what rounding can hide."""
    found = _check_counterexample(some)
    if corrected(some, ZERO, ZERO) is Truth.HOLDS:
        assert not found
    if corrected(replace(some, d_min=some.d_min - some.d_hat_min / 10**6), ZERO, ZERO) is Truth.FAILS:
        assert found


@SETTINGS
@given(_parameters(diagonals), st.fractions(0, 1, max_denominator=50), st.integers(0, 2))
def test_the_printed_inequality_is_refuted_where_errors_exceed_the_dip(
    some: Parameters, share: Fraction, axis: int
) -> None:
    """Where the printed one just holds and ‖Θ⁻¹‖ ≥ 1, an error larger than the dip gives a counterexample."""
    assume(some.tracking_error > 0 and share < 1)
    dip = share * some.tracking_error
    stretch = [max(Fraction(1), some.theta_inverse[k][k]) if k == axis else some.theta_inverse[k][k] for k in range(3)]
    some = replace(
        some,
        d_hat_min=some.d_min + some.tracking_error + dip,
        theta_inverse=diagonal((stretch[0], stretch[1], stretch[2])),
    )
    assert printed(some, dip, dip) is Truth.HOLDS
    assert corrected(some, dip, dip) is Truth.FAILS
    assert _check_counterexample(some)


def test_the_published_parameters_have_a_counterexample() -> None:
    """With Δd_min = 0.13 and no dip at all, (26) holds as printed, and two hovering UAVs can meet."""
    some = _changed("tracking_error=0.13")
    assert printed(some, ZERO, ZERO) is Truth.HOLDS
    assert corrected(some, ZERO, ZERO) is Truth.FAILS
    found = counterexample(some)
    assert found is not None
    eighth = Fraction(1, 8)
    assert found.references == ((eighth, ZERO, ZERO), (-eighth, ZERO, ZERO))
    assert found.positions == (ORIGIN, ORIGIN)
    assert found.squared_reference_distance == Fraction(1, 16)
    assert found.squared_distance == 0


def test_errors_do_not_overshoot() -> None:
    """However large the errors may be, the UAVs are brought to one place and not past each other."""
    for error in ("0.125", "0.126", "0.25", "3"):
        found = counterexample(_changed(f"tracking_error={error}"))
        assert found is not None
        assert found.squared_distance == 0


def test_references_that_meet_need_no_errors() -> None:
    """Two references at one place are closer than d_min as they are."""
    found = counterexample(Parameters(), (ORIGIN, ORIGIN))
    assert found is not None
    assert (found.references, found.positions) == ((ORIGIN, ORIGIN), (ORIGIN, ORIGIN))


def test_references_in_any_direction_can_be_used() -> None:
    """Where hovering is no counterexample a dip can be one, with errors as long as an irrational length allows."""
    some = _changed("tracking_error=0.03")
    assert counterexample(some) is None
    pair = ((Fraction(1, 10), Fraction(1, 10), ZERO), (ZERO, Fraction(0), ZERO))
    found = counterexample(some, pair)
    assert found is not None
    assert _check_counterexample(some, pair)
    for real, reference in zip(found.positions, found.references, strict=True):
        length = _square(_minus(real, reference))
        assert (some.tracking_error * (1 - Fraction(1, 10**12))) ** 2 <= length < some.tracking_error**2
    assert counterexample(some, (pair[0], _times(pair[0], Fraction(-1)))) is None


def test_hovering_uavs_fit_into_the_workspace() -> None:
    """The hovering pair is around the middle of the workspace, and there is none where it has no room."""
    roomy = _changed("workspace=1,1.25,0,2,5,5", "tracking_error=0.13")
    first, second = (Fraction(5, 4), Fraction(1), Fraction(5)), (Fraction(1), Fraction(1), Fraction(5))
    assert hovering_pair(roomy) == (first, second)
    narrow = _changed("workspace=1,1.2,0,2,5,5", "tracking_error=0.13")
    assert hovering_pair(narrow) is None
    assert counterexample(narrow) is None


@SETTINGS
@given(st.one_of(coupled(), diagonals))
def test_hovering_uavs_are_where_errors_count_most(matrix: Matrix) -> None:
    """The pair is at least d̂_min apart, hardly more, and in metres as close as the norm of Θ⁻¹ allows."""
    some = replace(Parameters(), theta_inverse=matrix)
    pair = hovering_pair(some)
    assert pair is not None
    relative = _minus(*pair)
    distance = _scaled_square(matrix, relative)
    assert some.d_hat_min**2 <= distance <= (some.d_hat_min * (1 + Fraction(1, 10**11))) ** 2
    _, norm = spectral_norm_bounds(matrix)
    assert distance >= (norm * (1 - Fraction(1, 10**6))) ** 2 * _square(relative)


# ------------------------------------------------------------------------- would a mistake be noticed?

GRID = [
    Parameters(d_hat_min=room, d_min=Fraction(1, 10), tracking_error=error, theta_inverse=scaling)
    for room, error, scaling in product(
        [Fraction(step, 100) for step in range(10, 40, 2)],
        [Fraction(step, 100) for step in range(0, 10, 2)],
        [PUBLISHED_SCALING, UNSCALED, diagonal((Fraction(2), Fraction(1), Fraction(1, 2)))],
    )
]


def _refuted(claim: Callable[[Parameters], bool]) -> bool:
    """Return whether `claim` promises separation to parameters of the grid that have a counterexample."""
    return any(claim(some) and _check_counterexample(some) for some in GRID)


def _needlessly_strict(claim: Callable[[Parameters], bool]) -> bool:
    """Return whether `claim` denies separation to parameters of the grid that have no counterexample."""
    return any(not claim(some) and not _check_counterexample(some) for some in GRID)


def _norm(some: Parameters) -> Fraction:
    return max(some.theta_inverse[axis][axis] for axis in range(3))


MISTAKES: dict[str, Callable[[Parameters], bool]] = {
    "as printed": lambda some: printed(some, ZERO, ZERO) is Truth.HOLDS,
    "one UAV's error": lambda some: some.d_hat_min >= some.d_min + _norm(some) * some.tracking_error,
    "errors not scaled": lambda some: some.d_hat_min >= some.d_min + 2 * some.tracking_error,
    "no errors": lambda some: some.d_hat_min >= some.d_min,
}


def test_the_corrected_inequality_is_neither_refuted_nor_too_strict() -> None:
    """On the grid, the corrected inequality holds exactly where there is no counterexample."""

    def claim(some: Parameters) -> bool:
        return corrected(some, ZERO, ZERO) is Truth.HOLDS

    assert not _refuted(claim)
    assert not _needlessly_strict(claim)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_weaker_inequality_is_refuted(mistake: str) -> None:
    """Without the factor 2, without the norm, or as printed, the inequality has a counterexample on the grid."""
    assert _refuted(MISTAKES[mistake])


def test_a_stricter_inequality_is_noticed() -> None:
    """An inequality that counts the errors four times denies what nothing refutes."""
    assert _needlessly_strict(lambda some: some.d_hat_min >= some.d_min + 4 * _norm(some) * some.tracking_error)


def test_a_crossing_pair_is_d_hat_min_apart_at_both_samples() -> None:
    """It dips as the chord of a circle does: 0.25² − 0.02 for the published speeds and Θ at T_c = 0.05 s."""
    some = Parameters().with_changes(["T_c=0.05"])
    pair = crossing_pair(some)
    assert pair is not None
    relative = _minus(*pair)
    way = (Fraction(1, 5), Fraction(1, 5), ZERO)  # 2 · 2 m/s · T_c on x and on y
    for sign in (1, -1):
        end = _minus(relative, (sign * way[0] / 2, sign * way[1] / 2, ZERO))
        assert some.d_hat_min**2 <= _scaled_square(some.theta_inverse, end) <= some.d_hat_min**2 + Fraction(1, 10**9)
    middle = _scaled_square(some.theta_inverse, relative)
    assert abs(middle - (some.d_hat_min**2 - Fraction(2, 100))) <= Fraction(1, 10**9)


def test_there_is_no_crossing_pair_where_uavs_pass_through_each_other() -> None:
    """With the published T_c the way between two samples is longer than twice d̂_min."""
    assert crossing_pair(Parameters()) is None
