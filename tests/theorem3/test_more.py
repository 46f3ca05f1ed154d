"""What Theorem 3 has to pay beyond the paper: a delay, another ellipsoid for a crash, and kinds of UAVs."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmproof.margin.bounds import margin
from swarmproof.margin.mixed import of_a_pair
from swarmproof.margin.problem import Problem
from swarmproof.theorem3 import inequality
from swarmproof.theorem3.delay import displacement, largest_dip, lost
from swarmproof.theorem3.fleet import pairs, read_kinds
from swarmproof.theorem3.inequality import (
    Truth,
    corrected,
    counterexample,
    crossing_pair,
    guaranteed_separation,
    largest_loss,
    scaled_square,
    shrinking_bounds,
)
from swarmproof.theorem3.parameters import Parameters, Reading

TILTED = "1,0.3,0,0.3,0.8,-0.2,0,-0.2,0.5"
examples = settings(max_examples=100, deadline=None, derandomize=True, database=None)


def _given(*changes: str) -> Parameters:
    return Parameters().with_changes(changes)


# ---- delay


@pytest.mark.parametrize("scaling", ["1,1,1/3", TILTED])
@pytest.mark.parametrize("norm", ["none", "1.2", "5"])
def test_a_steady_uav_attains_the_lower_bound_and_whole_motion_is_narrow(scaling: str, norm: str) -> None:
    """At all times bounded, no UAV beats constant velocity: both bounds agree where Θ⁻¹ is diagonal."""
    some = _given(f"theta_inverse={scaling}", "v_max=1,1.5,0.5", f"v_norm={norm}", "delay=0.3")
    low, high = displacement(some, Reading.WHOLE_MOTION)
    assert 0 < low <= high
    matrix = np.array([[float(entry) for entry in row] for row in some.theta_inverse])
    random = np.random.default_rng(0)
    speeds = random.uniform(-1, 1, size=(20000, 3)) * [1, 1.5, 0.5]
    corners = np.array(list(product((-1, 1), repeat=3))) * [1, 1.5, 0.5]
    speeds = np.vstack([speeds, corners])
    if some.v_norm is not None:
        speeds /= np.maximum(1, np.linalg.norm(speeds, axis=1) / float(some.v_norm))[:, None]
    ways = 0.3 * np.linalg.norm(speeds @ matrix.T, axis=1)
    assert ways.max() <= float(high) * (1 + 1e-12)
    assert ways.max() >= 0.97 * float(low)
    if scaling != TILTED:
        assert high - low <= Fraction(1, 10**9)


@examples
@given(
    st.sampled_from(list(Reading)),
    st.sampled_from([2, 3]),
    st.floats(0.01, 0.6),
    st.integers(0, 2**32 - 1),
)
def test_no_motion_of_the_reading_flies_further_in_the_delay(
    reading: Reading, order: int, delay: float, seed: int
) -> None:
    """Random motions over several periods, with every state and input bound met, stay within the upper bound."""
    some = _given(
        "T_s=0.2", "T_c=0.1", "T_b=0.1", "v_max=1,1,0.4", "v_norm=1.2", f"order={order}", f"delay={delay:.6f}"
    )
    high = float(displacement(some, reading)[1])
    random = np.random.default_rng(seed)
    step, count = 0.01, 100
    every = {Reading.WHOLE_MOTION: 1, Reading.AS_SAMPLED: 10, Reading.INITIAL_STATE: 10}[reading]
    piece = 20 if reading is Reading.AS_SAMPLED else 5
    inputs = np.repeat(random.uniform(-1, 1, size=(count // piece, 3)), piece, axis=0)
    motion = np.zeros((count + 1, order, 3))
    motion[0, 1:] = random.uniform(-1, 1, size=(order - 1, 3))
    for k in range(count):
        p, v, *a = motion[k]
        if order == 2:
            motion[k + 1] = [p + v * step + inputs[k] * step**2 / 2, v + inputs[k] * step]
        else:
            u = inputs[k]
            motion[k + 1] = [
                p + v * step + a[0] * step**2 / 2 + u * step**3 / 6,
                v + a[0] * step + u * step**2 / 2,
                a[0] + u * step,
            ]
    # everything is linear: scaled until the tightest bound is met
    bounded = motion[::every]
    tight = [np.abs(bounded[:, 1] / [1, 1, 0.4]).max(), np.linalg.norm(bounded[:, 1], axis=1).max() / 1.2]
    tight += [np.abs(inputs).max() / 5] + ([np.abs(bounded[:, 2]).max() / 5] if order == 3 else [])
    if reading is Reading.WHOLE_MOTION:
        tight = [value * 1.02 for value in tight]  # what happens between the grid's points
    path = motion[:, 0] / max(tight)
    matrix = np.diag([1, 1, 1 / 6])
    lag = int(delay / step)
    ways = np.linalg.norm((path[lag:] - path[: len(path) - lag]) @ matrix, axis=1)
    assert ways.max(initial=0.0) <= high


def test_speed_overshoots_between_state_samples_and_the_bound_knows() -> None:
    """With a jerk that turns the speed within T_b a UAV flies further than v_max·delay: a bound must not forget it."""
    some = _given("T_s=0.2", "T_c=0.1", "T_b=0.2", "v_max=1", "a_max=5", "j_max=40", "theta_inverse=1", "delay=0.02")
    # w'' = 4 − 40t: the speed is 1 at 0 and at 0.2, and 1.2 in the middle, where it hardly changes in 0.02 s
    flown = 1.2 * 0.02 - 40 * 0.01**3 / 3
    low, high = displacement(some, Reading.AS_SAMPLED)
    assert flown * 3**0.5 > float(low)
    assert flown * 3**0.5 <= float(high)
    assert float(high) == pytest.approx(1.2 * 0.02 * 3**0.5)


def test_what_is_flown_from_a_state_in_x_counts_for_initial_state() -> None:
    """v·d + a·d²/2 + j·d³/6 along one axis, which is more than the speed between two samples yields."""
    some = _given("v_max=2,0,0", "a_max=5,0,0", "j_max=6,0,0", "theta_inverse=1", "delay=0.5")
    assert displacement(some, Reading.INITIAL_STATE)[1] == Fraction(2 * 5, 10) + Fraction(5, 8) + Fraction(1, 8)


def test_the_corrected_inequality_pays_the_delay() -> None:
    """What one UAV flies is taken from the guaranteed separation, and the verdict turns where it must."""
    some = _given("order=2", "a_max=0", "v_max=1,0,0", "T_c=0.01", "T_s=0.01", "d_min=0.15", "theta_inverse=1")
    found = [margin(Problem(replace(some, delay=Fraction(d)), Reading.AS_SAMPLED)) for d in ("0", "0.09", "0.11")]
    assert [one.truths[1] for one in found] == [Truth.HOLDS, Truth.HOLDS, Truth.FAILS]
    assert [one.flown for one in found[1:]] == [(Fraction(9, 100),) * 2, (Fraction(11, 100),) * 2]
    assert found[1].loss == (found[1].lower + Fraction(9, 100), found[1].upper + Fraction(9, 100))


def _way(time: Fraction) -> Fraction:
    """Return how far a UAV has flown in a period of 0.2 s: 0.5 m/s at both ends, jerk -50 m/s³ in between, m."""
    return time / 2 + Fraction(5, 2) * time**2 - Fraction(25, 3) * time**3


def test_a_delay_lets_a_window_see_more_of_an_overshoot_than_a_period_has() -> None:
    """As-sampled, a UAV a moment ago is on no common clock: two that meet are d̂_min apart by the planner's word."""
    delay, early, late = Fraction(1, 1000), Fraction(1, 10), Fraction(1, 5)
    some = _given(
        "v_max=0.5,0,0",
        "a_max=5,0,0",
        "j_max=50,0,0",
        "theta_inverse=1",
        "d_hat_min=0.06679",
        "delay=0.001",
        "d_min=0.002",
    )
    # towards each other along x: at both samples the planner sees them d̂_min apart, and they swap sides in between
    known = (_way(late) - _way(early) + _way(late - delay) - _way(early - delay)) / 2
    assert known >= some.d_hat_min
    apart = [_way(t) - _way(early) + _way(t) - _way(early - delay) - known for t in (early, late)]
    assert apart[0] < 0 < apart[1]
    (low, high), flown = (Fraction("0.062732949"), Fraction("0.06340085")), displacement(some, Reading.AS_SAMPLED)
    # what the certificate of this pair says; the sum of both is less than d̂_min − d_min
    assert high + flown[1] < some.d_hat_min - some.d_min
    assert lost(some, Reading.AS_SAMPLED, high, flown[1])[1] >= some.d_hat_min
    loss = lost(some, Reading.AS_SAMPLED, low, flown[0])[0], lost(some, Reading.AS_SAMPLED, high, flown[1])[1]
    assert corrected(some, *loss) is not Truth.HOLDS
    # where motions can be shifted, nothing but the sum is paid
    assert lost(some, Reading.WHOLE_MOTION, high, flown[1]) == (high + flown[1], high + flown[1])
    whole = replace(some, delay=some.T_s)
    assert lost(whole, Reading.AS_SAMPLED, high, flown[1]) == (high + flown[1], high + flown[1])


@given(st.integers(0, 99), st.integers(0, 120), st.integers(1, 99))
@examples
def test_references_that_start_nearer_dip_deeper_and_both_directions_agree(dip: int, flown: int, asked: int) -> None:
    """What is left is the dip of a pair that starts D nearer, at constant velocity; the inverse never promises more."""
    some, reading = _given("d_hat_min=1", "delay=0.01"), Reading.AS_SAMPLED
    low, high = lost(some, reading, Fraction(dip, 100), Fraction(flown, 100))
    assert Fraction(dip + flown, 100) <= high
    assert low <= high
    half = 1 - (1 - dip / 100) ** 2
    left = (1 - flown / 100) ** 2 - half if flown < 100 else 0.0
    assert float(high) >= 1 - max(left, 0.0) ** 0.5 - 1e-9
    most = largest_dip(some, reading, Fraction(asked, 100), Fraction(flown, 100))
    if most >= 0:
        assert lost(some, reading, most, Fraction(flown, 100))[1] <= Fraction(asked, 100) + Fraction(1, 10**9)


# ---- a crash's own ellipsoid


@examples
@given(st.lists(st.integers(1, 8), min_size=6, max_size=6), st.integers(0, 2**32 - 1))
def test_no_direction_shrinks_more_than_the_exact_bound(entries: list[int], seed: int) -> None:
    """‖Cx‖ ≥ σ‖Ax‖ for random x and tilted C and A, and singular values agree."""
    random = np.random.default_rng(seed)
    turn = random.integers(-2, 3, size=(3, 3))
    first = np.diag(entries[:3]) + (turn @ turn.T)
    second = np.diag(entries[3:]) + (turn.T @ turn)
    texts = [",".join(str(int(value)) for value in matrix.ravel()) for matrix in (first, second)]
    some = _given(f"theta_inverse={texts[0]}", f"crash_theta_inverse={texts[1]}")
    low, high = shrinking_bounds(some)
    least = float(np.linalg.svd(second @ np.linalg.inv(first), compute_uv=False).min())
    assert float(low) * (1 - 1e-9) <= least <= float(high) * (1 + 1e-9)
    assert high - low <= high / 10**12
    for x in random.integers(-5, 6, size=(20, 3)):
        vector = (Fraction(int(x[0])), Fraction(int(x[1])), Fraction(int(x[2])))
        assert some.crash_theta_inverse is not None
        assert scaled_square(some.crash_theta_inverse, vector) >= low**2 * scaled_square(some.theta_inverse, vector)


def test_a_crash_that_counts_height_more_is_refuted_by_a_hovering_pair_only() -> None:
    """Planned with 1/3 per metre of height, measured with 0.1: hovering pairs above each other are 0.075 m apart."""
    some = _given("theta_inverse=1,1,1/3", "crash_theta_inverse=1,1,0.1", "d_min=0.08")
    nothing = Fraction(0)
    assert corrected(some, nothing, nothing) is Truth.FAILS
    pair = counterexample(some)
    assert pair is not None
    assert pair.squared_reference_distance >= some.d_hat_min**2
    assert pair.squared_distance < some.d_min**2
    closer = replace(some, d_min=Fraction("0.074"))
    assert corrected(closer, nothing, nothing) is Truth.HOLDS
    assert corrected(closer, nothing, Fraction(1, 100)) is Truth.UNDECIDED
    assert guaranteed_separation(closer, nothing) == Fraction("0.075")


def test_the_same_ellipsoid_for_both_changes_nothing() -> None:
    """C = Θ⁻¹ gives the room of the corrected (26), and a limit that just holds."""
    some = _given("tracking_error=0.01")
    same = replace(some, crash_theta_inverse=some.theta_inverse)
    for one in (some, same):
        assert largest_loss(one) == Fraction("0.25") - Fraction("0.12") - Fraction("0.02")
        assert corrected(one, largest_loss(one), largest_loss(one)) is Truth.HOLDS
        assert guaranteed_separation(one, Fraction("0.05")) == Fraction("0.18")


def test_a_crossing_pair_keeps_the_norm() -> None:
    """Two UAVs that cross at constant velocity fly no faster than v_norm together on both axes."""
    free, bounded = _given("T_c=0.05"), _given("T_c=0.05", "v_norm=2", "v_max=2")
    near, far = crossing_pair(free), crossing_pair(bounded)
    assert near is not None
    assert far is not None
    apart = [
        float(scaled_square(free.theta_inverse, inequality._sum(i, inequality._scaled(j, Fraction(-1))))) ** 0.5
        for i, j in (near, far)
    ]
    assert apart == pytest.approx([(0.0625 - 0.02) ** 0.5, (0.0625 - 0.01) ** 0.5])


# ---- kinds


def test_a_mixed_pair_is_that_of_the_mean_and_is_real_only_in_one_ratio() -> None:
    """2 and 1.5 m/s, 10 m/s² for both: not in one ratio; with 7.5 m/s² and 3.75 m/s³ for the slower one they are."""
    base = _given("T_c=0.05", "a_max=10")
    large = {"name": "large", "v_max": 2, "d_hat_min": "0.6"}
    small = {"name": "small", "v_max": "1.5", "d_hat_min": "0.4"}
    both = pairs(read_kinds([large, small], base))
    assert [(one.names, one.proportional) for one in both] == [
        (("large", "large"), True),
        (("large", "small"), False),
        (("small", "small"), True),
    ]
    found = of_a_pair(margin(Problem(both[1].parameters, Reading.AS_SAMPLED)), both[1])
    assert Fraction("0.018711") <= found.lower <= found.upper <= Fraction("0.018715")
    assert found.known == (Fraction(0), found.upper)
    alike = pairs(read_kinds([large, {**small, "a_max": "7.5", "j_max": "3.75"}], base))[1]
    assert alike.proportional
    sideways = pairs(
        read_kinds([{"v_max": [2, 1, 1]}, {"v_max": [1, 1, 1], "a_max": [5, 10, 10], "j_max": ["2.5", 5, 5]}], base)
    )
    assert sideways[1].proportional  # each axis in a ratio of its own
    norms = pairs(read_kinds([{"v_norm": 2}, {"v_norm": 1}], base))
    assert not norms[1].proportional
    walled = replace(base, workspace=((Fraction(0), None),) * 3)
    assert not pairs(read_kinds([large, {**small, "a_max": "7.5", "j_max": "3.75"}], walled))[1].proportional


def test_no_mixed_pair_fails_because_of_a_pair_that_need_not_be_one_of_theirs() -> None:
    """The mean's pair dips too deep; of the two kinds nothing is known but that it holds or not: undecided."""
    base = _given("T_c=0.1", "order=2", "a_max=1", "theta_inverse=1", "d_min=0.2")
    both = pairs(read_kinds([{"v_max": [1, 1, 0]}, {"v_max": ["1.4", "1.4", 0]}], base))[1]
    found = of_a_pair(margin(Problem(both.parameters, Reading.AS_SAMPLED)), both)
    assert corrected(both.parameters, found.lower, found.upper) is Truth.FAILS
    assert found.truths[1] is Truth.UNDECIDED


def test_of_two_kinds_the_faster_one_flies_on() -> None:
    """In the delay a pair loses what its faster UAV flies, not the mean."""
    base = _given("order=2", "a_max=0", "theta_inverse=1", "delay=0.01", "T_c=0.01", "T_s=0.01")
    both = pairs(read_kinds([{"v_max": [2, 0, 0]}, {"v_max": [1, 0, 0]}], base))[1]
    found = of_a_pair(margin(Problem(both.parameters, Reading.AS_SAMPLED)), both)
    assert found.flown == (Fraction(2, 100), Fraction(2, 100))
