"""The brute force for the largest dip agrees with closed forms, simulation in small steps, and a dumb grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.margin.brute import (
    READINGS,
    Array,
    Pairs,
    Setting,
    best_dip,
    best_pair,
    chord_dip,
    collinear_distance,
    constant_velocity_dip,
    dips,
    displacements,
    distance,
    excess,
    one_axis_dip,
    place,
    place_along,
    random_dips,
    random_pairs,
    state_at,
    windows,
)

PUBLISHED = Setting(
    T_c=0.05,
    T_s=0.2,
    d_hat_min=0.25,
    v_max=(2.0, 2.0, 2.0),
    a_max=(5.0, 5.0, 5.0),
    j_max=(5.0, 5.0, 5.0),
    theta_inverse=np.diag([1.0, 1.0, 1 / 6]),
)
TILTED = np.array([[1.0, 0.3, 0.0], [0.3, 0.8, -0.2], [0.0, -0.2, 0.5]])
NOTHING = (0.0, 0.0, 0.0)


def _along(axis: int, bound: float) -> tuple[float, float, float]:
    x, y, z = (bound if k == axis else 0.0 for k in range(3))
    return x, y, z


def _one_pair(setting: Setting, velocity: float, acceleration: float, inputs: list[float]) -> Pairs:
    """Return a pair that is 10 m apart along y; its first UAV moves along x, its second one hovers."""
    k = len(inputs)
    state, u = np.zeros((3, 1, 2, 3)), np.zeros((1, 2, 3, k))
    state[0, 0, 0, 1], state[1, 0, 0, 0], state[2, 0, 0, 0], u[0, 0, 0] = 10.0, velocity, acceleration, inputs
    durations = np.full((1, 2, 3, k), max(setting.T_c, setting.T_s) / k)
    return Pairs(state[0], state[1], state[2], u, durations, start=np.zeros(1), instant=np.zeros(1))


def _gaps(y: Array, a: Array, b: Array) -> Array:
    return np.asarray(np.minimum(np.linalg.norm(y - a, axis=-1), np.linalg.norm(y - b, axis=-1)))


@pytest.mark.parametrize("scale", [0.1, 0.6, 1.5])
def test_no_point_of_a_grid_beats_the_placement(scale: float) -> None:
    """The placement keeps both ends apart; the nearest such point of a fine grid is not nearer, nor much farther."""
    rng = np.random.default_rng(1)
    a, b = rng.normal(scale=scale, size=(2, 30, 3))
    a[0], b[1], b[2] = 0.0, 0.0, a[2]
    b[3], b[4], b[5] = -a[3], 3 * a[4], a[5] * (1 + 1e-9)
    y = place(a, b, 1.0)
    assert _gaps(y, a, b).min() >= 1 - 1e-9
    ticks = np.linspace(-1.25, 1.25, 61)
    grid = np.stack(np.meshgrid(ticks, ticks, ticks), axis=-1).reshape(-1, 3)
    norms = np.linalg.norm(grid, axis=1)
    for y_k, a_k, b_k in zip(y, a, b, strict=True):
        least = norms[_gaps(grid, a_k, b_k) >= 1].min()
        assert np.linalg.norm(y_k) - 1e-9 <= least <= np.linalg.norm(y_k) + 3 * (ticks[1] - ticks[0])


def test_the_placement_along_a_direction_is_the_first() -> None:
    """The placement along a direction keeps both ends apart, and nothing nearer on the same ray does."""
    rng = np.random.default_rng(2)
    a, b, direction = rng.normal(scale=0.6, size=(3, 200, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    y = place_along(a, b, 1.0, direction)
    assert _gaps(y, a, b).min() >= 1 - 1e-9
    assert np.allclose(np.linalg.norm(y, axis=1)[:, None] * direction, y)
    for fraction in np.linspace(0.0, 0.999, 50):
        assert np.all((np.linalg.norm(y, axis=1) == 0) | (_gaps(fraction * y, a, b) < 1))
    assert np.all(np.linalg.norm(place(a, b, 1.0), axis=1) <= np.linalg.norm(y, axis=1) + 1e-9)


def test_the_placement_on_a_line_has_a_closed_form() -> None:
    """For motions along one line, the placement is as near as the formulas for passing and turning back say."""
    forth, on = np.random.default_rng(3).normal(size=(2, 500))
    line = np.array([0.6, 0.0, 0.8])
    y = place(forth[:, None] * line, -on[:, None] * line, 1.0)
    assert np.allclose(np.linalg.norm(y, axis=1), collinear_distance(forth, on, 1.0), atol=1e-9)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("reading", READINGS)
def test_the_formulas_follow_the_dynamics(reading: str, order: int) -> None:
    """States by formula are those that many small steps of the differential equation lead to."""
    setting = replace(PUBLISHED, order=order)
    pairs = random_pairs(setting, reading, 20, seed=4)
    end, n = setting.T_s if reading == "as-sampled" else setting.T_c, 4000
    h = end / n
    p, v, a = pairs.position.copy(), pairs.velocity.copy(), pairs.acceleration.copy()
    ends = np.cumsum(pairs.durations, axis=-1)
    for step in range(n):
        piece = np.minimum((ends <= (step + 0.5) * h).sum(axis=-1), ends.shape[-1] - 1)
        u = np.take_along_axis(pairs.inputs, piece[..., None], axis=-1)[..., 0]
        slope = u if order == 2 else a + u * h / 2
        p, v, a = p + h * (v + slope * h / 2), v + h * slope, a if order == 2 else a + h * u
    for simulated, formula in zip((p, v, a), state_at(setting, pairs, np.full(20, end)), strict=True):
        assert np.allclose(simulated, formula, atol=2e-4)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("reading", READINGS)
def test_random_pairs_are_feasible(reading: str, order: int) -> None:
    """Random pairs respect every bound of their reading at many times, and one end at least is tight."""
    setting = replace(PUBLISHED, order=order, theta_inverse=TILTED, v_max=(0.3, 1.0, 2.0), a_max=(5.0, 4.0, 3.0))
    pairs = random_pairs(setting, reading, 500, seed=5)
    assert excess(setting, reading, pairs).max() <= 1e-9
    ends = np.array([distance(setting, pairs, time) for time in (pairs.start, pairs.start + setting.T_c)])
    assert ends.min() >= setting.d_hat_min - 1e-9
    # those that fly through each other need not be tight
    through = distance(setting, pairs, pairs.instant) < 1e-12
    assert np.all(through | (ends.min(axis=0) <= setting.d_hat_min + 1e-9))
    assert np.all((pairs.start <= pairs.instant) & (pairs.instant <= pairs.start + setting.T_c))
    times = {"initial-state": [0.0], "as-sampled": [0.0, setting.T_s]}
    for time in times.get(reading, np.linspace(0.0, setting.T_c, 101)):
        _, v, a = state_at(setting, pairs, np.full(500, time))
        assert np.all(np.abs(v) <= np.array(setting.v_max) + 1e-9)
        assert np.all(np.abs(a) <= np.array(setting.a_max) + 1e-9)
    assert np.all(np.abs(pairs.inputs) <= setting.input_max[:, None] + 1e-9)
    extreme = np.abs(pairs.velocity) >= np.array(setting.v_max) * (1 - 1e-12)
    assert extreme.mean() > 0.1


def test_each_reading_binds_where_it_says() -> None:
    """A velocity that is too high inside a period only is noticed by `whole-motion` only, one at its end by two."""
    setting = replace(PUBLISHED, T_c=0.2, j_max=(200.0,) * 3, a_max=(10.0,) * 3)
    inside = _one_pair(setting, 1.6, 10.0, [-100.0])
    assert [excess(setting, reading, inside)[0] > 0.09 for reading in READINGS] == [False, True, False]
    at_the_end = _one_pair(setting, 1.6, 5.0, [0.0])
    assert [excess(setting, reading, at_the_end)[0] > 0.59 for reading in READINGS] == [False, True, True]
    at_once = _one_pair(setting, 2.1, -5.0, [0.0])
    assert [excess(setting, reading, at_once)[0] > 0.09 for reading in READINGS] == [True, True, True]
    harsh = _one_pair(setting, 0.0, 0.0, [201.0, -201.0])
    assert all(excess(setting, reading, harsh)[0] > 0.9 for reading in READINGS)
    sampled_twice = replace(setting, T_b=0.1)
    assert excess(sampled_twice, "as-sampled", inside)[0] > 0.09


def test_only_an_acceleration_that_is_a_state_is_bounded_at_instants() -> None:
    """With order 2, a_max bounds the input, and j_max nothing."""
    setting = replace(PUBLISHED, order=2, j_max=NOTHING)
    assert excess(setting, "whole-motion", _one_pair(setting, 0.0, 0.0, [5.0]))[0] <= 0
    assert excess(setting, "whole-motion", _one_pair(setting, 0.0, 0.0, [5.1]))[0] == pytest.approx(0.1)


def test_a_pair_that_is_too_close_is_noticed() -> None:
    """The distance at the ends is a constraint, at those of the pair's own window."""
    pair = _one_pair(PUBLISHED, 0.0, 0.0, [0.0])
    pair.position[0, 0, 1] = 0.2
    assert excess(PUBLISHED, "as-sampled", pair)[0] == pytest.approx(0.05)
    pair = _one_pair(PUBLISHED, 1.0, 0.0, [0.0])
    pair.position[0, 0] = -0.3, 0.0, 0.0
    assert excess(PUBLISHED, "as-sampled", pair)[0] == pytest.approx(0.0)
    assert excess(PUBLISHED, "as-sampled", replace(pair, start=np.array([0.05])))[0] == pytest.approx(0.05)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("reading", READINGS)
def test_what_is_found_is_feasible_and_beats_random_pairs(reading: str, order: int) -> None:
    """The pair that the search returns respects its reading, and no random pair dips deeper."""
    setting = replace(PUBLISHED, order=order, theta_inverse=TILTED, T_c=0.04)
    pair = best_pair(setting, reading)
    found = float(dips(setting, pair)[0])
    assert excess(setting, reading, pair)[0] <= 1e-9
    assert pair.start[0] <= pair.instant[0] <= pair.start[0] + setting.T_c
    drawn = random_dips(setting, reading, 3000, seed=6)
    assert drawn.shape == (3000,)
    assert drawn.min() >= -1e-9
    assert 0.8 * found < drawn.max() <= found + 1e-9


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize(("speed", "theta_inverse"), [(0.9, PUBLISHED.theta_inverse), (1.3, TILTED), (4.0, np.eye(3))])
def test_at_constant_velocity_the_dip_is_that_of_the_longest_chord(
    reading: str, order: int, speed: float, theta_inverse: Array
) -> None:
    """Without accelerations the dip is that of a chord, and d̂_min when the UAVs can pass through each other."""
    setting = replace(
        PUBLISHED,
        order=order,
        a_max=NOTHING,
        j_max=NOTHING,
        v_max=(speed, 0.7 * speed, speed),
        theta_inverse=theta_inverse,
    )
    expected = constant_velocity_dip(setting)
    assert (expected == setting.d_hat_min) == (speed == 4.0)
    assert best_dip(setting, reading) == pytest.approx(expected, abs=1e-8)
    assert random_dips(setting, reading, 1000, seed=7).max() <= expected + 1e-9


@pytest.mark.parametrize("order", [2, 3])
def test_hovering_uavs_do_not_come_closer(order: int) -> None:
    """The dip is 0 if the velocity is 0 all the time."""
    setting = replace(PUBLISHED, order=order, v_max=NOTHING)
    assert best_dip(setting, "whole-motion") == pytest.approx(0.0, abs=1e-9)
    assert np.abs(random_dips(setting, "whole-motion", 500, seed=8)).max() <= 1e-9


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize(
    ("t_c", "v", "a", "axis"),
    [(0.05, 2, 5, 0), (0.1, 0.3, 5, 2), (0.1, 0.05, 20, 0), (0.1, 4, 1, 0)],
)
def test_motion_along_one_axis_has_a_closed_form(reading: str, t_c: float, v: float, a: float, axis: int) -> None:
    """The search finds the dip of passing or of turning back along one axis, and nothing beyond it."""
    setting = replace(
        PUBLISHED, T_c=t_c, order=2, v_max=_along(axis, v), a_max=_along(axis, a), theta_inverse=TILTED, d_hat_min=0.2
    )
    expected = one_axis_dip(setting, reading, axis)
    assert -2e-3 * setting.d_hat_min <= best_dip(setting, reading) - expected <= 1e-9
    assert random_dips(setting, reading, 500, seed=9).max() <= expected + 1e-9


def test_both_ways_along_one_axis_are_tested() -> None:
    """Among the settings above, passing is best in some and turning back in others."""
    slow = replace(PUBLISHED, T_c=0.1, order=2, v_max=_along(0, 0.05), a_max=_along(0, 20.0))
    fast = replace(slow, v_max=_along(0, 2.0))
    for reading in READINGS:
        assert one_axis_dip(slow, reading, 0) > 1.5 * chord_dip(2 * 0.05 * 0.1, 0.25)
        assert one_axis_dip(fast, reading, 0) >= chord_dip(2 * 2.0 * 0.1, 0.25)


def test_uavs_that_hover_at_sampling_instants_may_move_between_them() -> None:
    """With v = 0 at multiples of T_s and a constant jerk j, v = j/2·t·(t − T_s): the UAV covers j·T_s³/12."""
    setting = replace(PUBLISHED, T_c=0.2, v_max=NOTHING, a_max=_along(0, 20.0), j_max=_along(0, 180.0))
    expected = chord_dip(2 * 180.0 * 0.2**3 / 12, 0.25)
    assert expected > 0.02
    assert best_dip(setting, "as-sampled") == pytest.approx(expected, abs=1e-7)


def test_bounds_that_hold_less_often_allow_more() -> None:
    """X at multiples of 2·T_s, with an input per T_s, allows what X at multiples of T_s does, and more."""
    setting = replace(PUBLISHED, order=2, v_max=(0.5, 0.5, 0.5))
    rarely = replace(setting, T_b=0.4)
    assert (windows(setting, "as-sampled"), windows(rarely, "as-sampled")) == (4, 8)
    assert best_dip(rarely, "as-sampled") > 1.1 * best_dip(setting, "as-sampled")


def test_the_search_repeats_itself() -> None:
    """The same seed leads to the same pair."""
    first, second = (best_pair(PUBLISHED, "as-sampled", seed=3) for _ in range(2))
    assert np.array_equal(first.inputs, second.inputs)
    assert np.array_equal(displacements(PUBLISHED, first)[0], displacements(PUBLISHED, second)[0])


@pytest.mark.parametrize(
    ("changed", "reading"),
    [
        (replace(PUBLISHED, T_s=0.12), "as-sampled"),
        (replace(PUBLISHED, T_b=0.15), "as-sampled"),
        (replace(PUBLISHED, T_b=0.3), "as-sampled"),
        (replace(PUBLISHED, order=4), "whole-motion"),
        (PUBLISHED, "as-printed"),
    ],
)
def test_bad_settings_are_refused(changed: Setting, reading: str) -> None:
    """Periods that do not fit into each other, and readings and orders that do not exist, are errors."""
    with pytest.raises(ValueError, match=r"multiple|no such"):
        best_dip(changed, reading)
