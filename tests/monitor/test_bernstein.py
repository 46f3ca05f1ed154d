"""Bounds of the closest approach between samples: closed forms, exact values at rational times, planted mistakes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import combinations, pairwise
from math import inf

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, find, given, settings
from hypothesis import strategies as st

from swarmproof.errors import BadInput
from swarmproof.monitor import bernstein as between
from swarmproof.monitor.bernstein import Closest, Floats, at_least, closest, cubics, lowest_per_step

SETTINGS = settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
#: To find a planted mistake; the example is not shrunk.
UNTIL_FOUND = settings(SETTINGS, max_examples=2_000, phases=[Phase.generate])

Find = Callable[[Floats], Closest]
#: Times in a step at which distances are evaluated exactly.
GRID = [Fraction(n, 12) for n in range(13)] + [Fraction(n, 7) for n in range(1, 7)]
M = 2**40


def square_at(pieces: Floats, step: int, pair: tuple[int, int], time: Fraction) -> Fraction:
    """Return |q_j − q_i|² exactly: de Casteljau on integers, each row multiplied by the denominator of `time`."""
    i, j = pair
    n, m = time.numerator, time.denominator
    total = 0
    for axis in range(3):
        row = [int(b) - int(a) for a, b in zip(pieces[step, i, axis], pieces[step, j, axis], strict=True)]
        while len(row) > 1:
            row = [a * (m - n) + b * n for a, b in pairwise(row)]
        total += row[0] ** 2
    return Fraction(total, m**6)


def of_place(pieces: Floats, found: Closest) -> Fraction:
    """Return the exact value at the place of `found`."""
    return square_at(pieces, found.step, found.pair, Fraction(found.fraction))


def all_pairs(pieces: Floats) -> Iterator[tuple[int, tuple[int, int]]]:
    """Yield every (step, pair)."""
    for step in range(len(pieces)):
        for pair in combinations(range(pieces.shape[1]), 2):
            yield step, pair


def smallest_known(pieces: Floats, times: list[Fraction]) -> Fraction:
    """Return the smallest exact value at these times of all steps and pairs."""
    return min(square_at(pieces, step, pair, time) for step, pair in all_pairs(pieces) for time in times)


def size(pieces: Floats) -> float:
    """Return M, the largest squared length of a difference's coefficient."""
    return max(
        float(np.square(pieces[step, j] - pieces[step, i]).sum(axis=0).max()) for step, (i, j) in all_pairs(pieces)
    )


def faults(pieces: Floats, found: Closest) -> list[str]:
    """Return which promises of `closest` are broken by `found`."""
    times = [*GRID, Fraction(found.fraction), Fraction(closest(pieces).fraction)]
    value = of_place(pieces, found)
    broken = {
        "lower is above an exact value": found.lower > smallest_known(pieces, times),
        "upper is not the value there, rounded up": not value <= found.upper <= value * (1 + Fraction(1, 2**52)),
        "too wide": found.upper - found.lower > 1e-9 * found.upper + 1e-12 * size(pieces),
    }
    return [fault for fault, is_there in broken.items() if is_there]


@st.composite
def some_pieces(draw: st.DrawFn) -> Floats:
    """Draw cubics of all sizes: far apart or near, fast or slow, smooth or wild; at most 3 UAVs over 2 steps."""
    shape = draw(st.integers(1, 2)), draw(st.integers(2, 3)), 3
    count = int(np.prod(shape))

    def numbers(most_bits: int, how_many: int) -> Floats:
        bound = 2 ** draw(st.integers(0, most_bits))
        drawn = draw(st.lists(st.integers(-bound, bound), min_size=how_many, max_size=how_many))
        return np.array(drawn, float)

    place = numbers(49, count).reshape(*shape, 1)
    motion = numbers(48, 4 * count).reshape(*shape, 4)
    return place + motion


def moving(x: list[int], y: list[int] | None = None) -> Floats:
    """Return one step of two UAVs, the first at rest in the origin, the second with these coefficients for x and y."""
    pieces = np.zeros((1, 2, 3, 4))
    pieces[0, 1, 0] = x
    pieces[0, 1, 1] = y or [0, 0, 0, 0]
    return pieces


#: Passes the other UAV at constant speed after a third of the step, 5 · M away.
PASSING = moving([-3 * M, 0, 3 * M, 6 * M], [5 * M] * 4)
#: A mistake: within a coefficient, all products weigh the same.
EQUAL_WEIGHTS = np.sign(between._ROUNDED_WEIGHTS) / np.sign(between._ROUNDED_WEIGHTS).sum(axis=1, keepdims=True)
#: Comes from 5M to 3M in the middle and goes back: no sample shows it.
DIP = moving([-4 * M, -M, M, 4 * M], [3 * M] * 4)


def flight(steps: int, uavs: int) -> Floats:
    """Return a swarm that shrinks, turns and grows again: connected cubics, some tenths of a metre apart."""
    metre = 2.4e12
    angle = np.arange(uavs) * 2 * np.pi / uavs + np.linspace(0, np.pi, 3 * steps + 1)[:, None]
    radius = 1.45 * (0.6 + 0.4 * np.cos(np.linspace(0, 2 * np.pi, 3 * steps + 1)))[:, None]
    wobble = 0.02 * np.sin(7 * angle + np.arange(uavs) ** 2)
    corners = np.stack([radius * np.cos(angle), radius * np.sin(angle), wobble], axis=-1)
    corners = np.rint(corners * metre)
    return np.stack([corners[k : 3 * steps + k : 3] for k in range(4)], axis=-1)


def test_cubics_are_the_motion() -> None:
    """At every time of a period, the pieces are the scaled triple integrator, p + 3vs + 3as² + us³ on the lattice."""
    rng = np.random.default_rng(1)
    states = rng.integers(-(2**30), 2**30, (4, 3, 3)).astype(float)
    jerks = rng.integers(-(2**20), 2**20, (4, 3)).astype(float)
    scaling = np.array([[6.0, 1, 0], [1, 6, 0], [0, 0, 1]])
    pieces = cubics(states, jerks, scaling, 3)
    for step, uav, time in [(0, 0, Fraction(0)), (0, 1, Fraction(1, 3)), (1, 2, Fraction(2, 7)), (2, 3, Fraction(1))]:
        s = step + time
        # jerk u is constant over the period, so the step's formula holds on it with s counted from its start
        p, v, a = ([int(x) for x in row] for row in states[uav])
        moved = [p[x] + 3 * v[x] * s + 3 * a[x] * s**2 + int(jerks[uav, x]) * s**3 for x in range(3)]
        scaled = [sum(int(scaling[row, x]) * moved[x] for x in range(3)) for row in range(3)]
        weights = [(1 - time) ** 3, 3 * time * (1 - time) ** 2, 3 * time**2 * (1 - time), time**3]
        for axis in range(3):
            assert sum(w * int(b) for w, b in zip(weights, pieces[step, uav, axis], strict=True)) == scaled[axis]


def test_two_at_rest() -> None:
    """The distance of two UAVs at rest is enclosed up to rounding, and attained at the start of the first step."""
    found = closest(np.repeat(moving([3 * M] * 4, [4 * M] * 4), 5, axis=0))
    assert found.lower <= 25 * M**2 == found.upper
    assert found.upper - found.lower < 1e-14 * found.upper
    assert (found.step, found.pair, found.fraction) == (0, (0, 1), 0)


def test_passing_by() -> None:
    """Passing at a third of the step, no binary fraction, is found there, and its distance to almost all digits."""
    found = closest(PASSING)
    assert found.lower <= 25 * M**2 <= found.upper
    assert found.upper - found.lower < 1e-13 * found.upper
    assert found.fraction == pytest.approx(1 / 3, abs=1e-6)


def test_passing_through() -> None:
    """UAVs that meet have the lower bound 0; the upper one is 0 if a float is the time when they do, else nearly."""
    middle = closest(moving([-M, -M // 2, M // 2, M]))
    assert (middle.lower, middle.upper, middle.fraction) == (0, 0, 0.5)
    third = closest(moving([-3 * M, 0, 3 * M, 6 * M]))
    assert third.lower == 0 < third.upper < 1e-14 * M**2


def test_the_place_is_the_right_one() -> None:
    """Step and pair of the closest approach are told, also where one pass over all pieces does not do."""
    pieces = np.zeros((50, 16, 3, 4))
    pieces[:, :, 0] = 10 * M * np.arange(16)[:, None]
    # after half of step 41, UAV 5 is 3M away from UAV 11, and otherwise further away from anything
    pieces[41, 5, :2] = pieces[41, 11, :2] + moving([-4 * M, -2 * M, 2 * M, 4 * M], [3 * M] * 4)[0, 1, :2]
    found = closest(pieces)
    assert (found.step, found.pair, found.fraction) == (41, (5, 11), 0.5)
    assert found.upper == 9 * M**2


def test_a_flight_is_its_steps() -> None:
    """The enclosure of a long flight is the one of the closest of its steps."""
    pieces = flight(80, 16)
    steps = [closest(pieces[step : step + 1]) for step in range(80)]
    found = closest(pieces)
    best = min(steps, key=lambda step: step.upper)
    assert faults(pieces[found.step : found.step + 1], steps[found.step]) == []
    assert (found.upper, found.pair, found.fraction) == (best.upper, best.pair, best.fraction)
    assert found.lower <= min(step.upper for step in steps)
    assert found.lower == pytest.approx(min(step.lower for step in steps), rel=1e-9)


@SETTINGS
@given(some_pieces())
def test_closest_keeps_its_promises(pieces: Floats) -> None:
    """No exact value is below lower, upper is an exact value rounded up, and both are near to each other."""
    assert faults(pieces, closest(pieces)) == []


def ends_only(pieces: Floats) -> Closest:
    """Look at samples only."""
    return sampled(pieces, [0.0, 1.0])


def densely_sampled(pieces: Floats) -> Closest:
    """Look at many samples, none of which proves anything."""
    return sampled(pieces, [n / 200 for n in range(201)])


def sampled(pieces: Floats, times: list[float]) -> Closest:
    """Return the smallest value at `times` as if it were a bound."""
    values = (
        (square_at(pieces, step, pair, Fraction(time)), step, pair, time)
        for step, pair in all_pairs(pieces)
        for time in times
    )
    value, step, pair, time = min(values)
    upper = between._rounded_up(value)
    return Closest(upper, upper, step, pair, time)


def without_the_last_step(pieces: Floats) -> Closest:
    """Forget a step."""
    return closest(pieces[:-1] if len(pieces) > 1 else pieces)


def without_the_last_uav(pieces: Floats) -> Closest:
    """Forget a UAV."""
    return closest(pieces[:, :-1] if pieces.shape[1] > 2 else pieces)


@pytest.mark.parametrize("wrong", [ends_only, densely_sampled, without_the_last_step, without_the_last_uav])
def test_what_does_not_look_everywhere_is_caught(wrong: Find) -> None:
    """Samples instead of bounds, however many, and a forgotten step or UAV break the promises."""
    found = find(some_pieces(), lambda pieces: bool(faults(pieces, wrong(pieces))), settings=UNTIL_FOUND)
    assert "lower is above an exact value" in faults(found, wrong(found))


@pytest.mark.parametrize(
    ("planted", "fault"),
    [
        ({"ROUNDING": 0, "ROUNDING_OF_SPLIT": 0}, "lower is above an exact value"),
        ({"ROUNDING": -24}, "lower is above an exact value"),
        ({"_ROUNDED_WEIGHTS": EQUAL_WEIGHTS}, "lower is above an exact value"),
        ({"_rounded_up": float}, "upper is not the value there, rounded up"),
        ({"DEPTH": 1}, "too wide"),
        ({"WIDTH": 1e-6}, "too wide"),
    ],
)
def test_a_planted_mistake_is_caught(planted: dict[str, object], fault: str) -> None:
    """Without the slack for rounding, with wrong weights, or with a search that stops too early, promises break."""

    def broken(pieces: Floats) -> bool:
        with pytest.MonkeyPatch.context() as patch:
            for name, value in planted.items():
                patch.setattr(between, name, value)
            found = closest(pieces)
        return fault in faults(pieces, found)

    find(some_pieces(), broken, settings=UNTIL_FOUND)


@pytest.mark.parametrize("t", [2.0**-52, 0.5, 0.875, 1 - 2.0**-52])
@settings(SETTINGS, max_examples=30)
@given(pieces=some_pieces())
def test_where_parts_are_split_does_not_matter(t: float, pieces: Floats) -> None:
    """Promises are kept even if the heuristic choice of where to split is as bad as can be: the halvings suffice."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(between, "_splitting_points", lambda squares: np.full(squares.shape[1], t))
        found = closest(pieces)
    assert faults(pieces, found) == []


@SETTINGS
@given(some_pieces())
def test_bounds_per_step_keep_their_promises(pieces: Floats) -> None:
    """Per step, no exact value is below lower, and upper is not below the minimum."""
    lower, upper = lowest_per_step(pieces)
    for step in range(len(pieces)):
        one = pieces[step : step + 1]
        known = closest(one)
        assert lower[step] <= smallest_known(one, [*GRID, Fraction(known.fraction)])
        assert upper[step] >= known.lower
        assert lower[step] <= upper[step]


@pytest.mark.parametrize("planted", [{"ROUNDING": -24}, {"_ROUNDED_WEIGHTS": EQUAL_WEIGHTS}])
def test_a_planted_mistake_in_bounds_per_step_is_caught(planted: dict[str, object]) -> None:
    """With a slack of the wrong sign, or wrong weights, some value is below the lower bound of its step."""

    def broken(pieces: Floats) -> bool:
        with pytest.MonkeyPatch.context() as patch:
            for name, value in planted.items():
                patch.setattr(between, name, value)
            lower, _ = lowest_per_step(pieces)
        return any(low > smallest_known(one[None], GRID) for low, one in zip(lower, pieces, strict=True))

    find(some_pieces(), broken, settings=UNTIL_FOUND)


def test_the_band_is_narrow_and_shows_dips() -> None:
    """In a flight the bounds per step are within 1 % of each other; a dip between samples is within them."""
    lower, upper = lowest_per_step(flight(100, 16))
    assert np.all(upper - lower <= 0.011 * upper)
    lower, upper = lowest_per_step(DIP)
    assert lower[0] <= 9 * M**2 <= upper[0] < 9.2 * M**2


def test_a_dip_that_no_sample_shows() -> None:
    """Two UAVs 5M apart at both ends of a step, 3M in its middle: at least (3M)² is proved, a bit more is refuted."""
    assert closest(DIP).upper == 9 * M**2
    assert ends_only(DIP).lower == 25 * M**2
    assert at_least(DIP, Fraction(9 * M**2)) is True
    assert at_least(DIP, Fraction(9 * M**2) + Fraction(1, 10**9)) is False
    assert at_least(DIP, Fraction(16 * M**2)) is False


def test_equality_is_decided_exactly_where_it_can_be() -> None:
    """At rest, or at half of a step, a distance counts as kept if it equals the bound, and not if it is any smaller."""
    tiny = Fraction(1, 10**40)
    for pieces, square in [(moving([M + 1] * 4, [M - 1] * 4), 2 * M**2 + 2), (DIP, 9 * M**2)]:
        assert at_least(pieces, Fraction(square)) is True
        assert at_least(pieces, square - tiny) is True
        assert at_least(pieces, square + tiny) is False


def test_equality_at_a_third_of_a_step_stays_open() -> None:
    """If the minimum equals the bound at a time that halving never reaches, the answer is None; if not, it is clear."""
    assert at_least(PASSING, Fraction(25 * M**2)) is None
    assert at_least(PASSING, Fraction(25 * M**2 - 1)) is True
    assert at_least(PASSING, Fraction(25 * M**2 + 1)) is False


def test_what_rounding_hides_is_found_exactly(monkeypatch: pytest.MonkeyPatch) -> None:
    """A dip so small that no float bound shows it, at no float time, is found; without exact arithmetic it is not."""
    square = 25 * M**2 + Fraction(1, 10**8)
    assert of_place(PASSING, closest(PASSING)) > square
    assert at_least(PASSING, square) is False
    monkeypatch.setattr(between, "_exactly_at_least", lambda difference, square: True)
    assert at_least(PASSING, square) is True


def test_no_distance_is_below_nothing() -> None:
    """Even UAVs that meet keep a distance of zero."""
    assert at_least(moving([-3 * M, 0, 3 * M, 6 * M]), Fraction(0)) is True


@SETTINGS
@given(some_pieces(), st.sampled_from([-1, 0, 1]), st.integers(0, 80))
def test_at_least_agrees_with_the_enclosure(pieces: Floats, sign: int, bits: int) -> None:
    """True and False never contradict an exact value or a bound; None is said only within the enclosure."""
    found = closest(pieces)
    value = of_place(pieces, found)
    square = value + sign * max(value, Fraction(1)) / 2**bits
    answer = at_least(pieces, square)
    if answer is True:
        assert smallest_known(pieces, [*GRID, Fraction(found.fraction)]) >= square
    elif answer is False:
        assert square > found.lower
    else:
        assert found.lower <= square <= found.upper
    if square > found.upper:
        assert answer is False


@pytest.mark.parametrize("shape", [(2, 3, 4), (2, 2, 4, 3), (0, 2, 3, 4), (2, 1, 3, 4)])
@pytest.mark.parametrize("function", [closest, lowest_per_step, lambda pieces: at_least(pieces, Fraction(1))])
def test_pieces_without_distances_are_refused(function: Callable[[Floats], object], shape: tuple[int, ...]) -> None:
    """No step, no pair or another shape is a mistake of the caller, told in one sentence."""
    with pytest.raises(BadInput, match="have no distances"):
        function(np.zeros(shape))


@pytest.mark.parametrize("wrong", [0.5, 2.0**50 + 1, np.nan, inf])
@pytest.mark.parametrize("function", [closest, lowest_per_step, lambda pieces: at_least(pieces, Fraction(1))])
def test_numbers_that_are_not_exact_are_refused(function: Callable[[Floats], object], wrong: float) -> None:
    """Anything but integers up to 2⁵⁰ is refused: the rounding bound does not hold for it."""
    pieces = np.zeros((2, 2, 3, 4))
    pieces[1, 1, 2, 3] = wrong
    with pytest.raises(BadInput, match="lattice units"):
        function(pieces)


@pytest.mark.deep
@settings(SETTINGS, max_examples=20_000)
@given(some_pieces())
def test_closest_keeps_its_promises_at_length(pieces: Floats) -> None:
    """The same as the short test, for many more cubics."""
    assert faults(pieces, closest(pieces)) == []
