"""The interval of the largest dip: closed forms, properties, random pairs, altered certificates and planted bugs."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.margin.brute import best_dip, chord_dip, constant_velocity_dip, one_axis_dip, random_dips
from tests.margin.settings import (
    AS_SAMPLED,
    INITIAL_STATE,
    TILTED,
    WHOLE_MOTION,
    bounds,
    examples,
    overlap,
    problem,
    relative_width,
    setting,
    solved,
)

from swarmproof.margin import ascent, corners, extremes, polygon, prove, witness
from swarmproof.margin.bounds import Margin, from_certificate, margin
from swarmproof.margin.certificate import digest
from swarmproof.margin.check import Rejected, check
from swarmproof.margin.problem import AxisBounds, Problem
from swarmproof.theorem3.parameters import Parameters, Reading
from swarmproof.theorem3.values import closed

READINGS = list(Reading)
ORDERS = (2, 3)
#: `as-sampled`, which is solved fastest; the others are for deep tests.
ONE_SUFFICES = [
    AS_SAMPLED,
    *(pytest.param(reading, marks=pytest.mark.deep) for reading in (INITIAL_STATE, WHOLE_MOTION)),
]
every_reading = pytest.mark.parametrize("reading", READINGS)
both_orders = pytest.mark.parametrize("order", ORDERS)


def _contains(found: Margin, value: float) -> bool:
    """Say whether a closed form in floating point is in the interval."""
    return float(found.lower) - 1e-12 <= value <= float(found.upper) + 1e-12


# ---- closed forms


@every_reading
@both_orders
@pytest.mark.parametrize("theta_inverse", ["theta_inverse=1,1,1/6", TILTED])
def test_at_constant_velocity_the_dip_is_that_of_the_longest_chord(
    reading: Reading, order: int, theta_inverse: str
) -> None:
    """Without accelerations, the interval contains the dip of the longest chord and is narrow."""
    found = bounds(reading, "v_max=1,0.6,1.5", "a_max=0", "j_max=0", f"order={order}", theta_inverse, "T_c=0.05")
    assert _contains(found, constant_velocity_dip(setting(found.problem)))
    assert relative_width(found) <= 1e-4


@every_reading
@both_orders
def test_uavs_that_can_pass_through_each_other_dip_by_all(reading: Reading, order: int) -> None:
    """With relative speeds that cross 2·d̂_min within T_c, both bounds are exactly d̂_min."""
    found = bounds(reading, "v_max=4", "a_max=0", "j_max=0", f"order={order}")
    assert found.lower == found.upper == found.problem.parameters.d_hat_min


@every_reading
@both_orders
def test_hovering_uavs_do_not_dip(reading: Reading, order: int) -> None:
    """If all bounds are zero, so is the dip."""
    found = bounds(reading, "v_max=0", "a_max=0", "j_max=0", f"order={order}", "T_c=0.05")
    assert found.lower == 0
    assert relative_width(found) <= 1e-4


@pytest.mark.parametrize("reading", ONE_SUFFICES)
@pytest.mark.parametrize(
    ("axis", "speed", "acceleration"),
    [
        (0, 2, 5),  # passing is best
        pytest.param(1, 0.05, 20, marks=pytest.mark.deep),  # turning back is best, and speed limits it
        pytest.param(2, 0.6, 5, marks=pytest.mark.deep),  # turning back is best
    ],
)
def test_motion_along_one_axis_has_a_closed_form(reading: Reading, axis: int, speed: float, acceleration: int) -> None:
    """With order 2 and one axis that is free to move, the interval contains the closed form."""
    v_max, a_max = (",".join(str(bound if k == axis else 0) for k in range(3)) for bound in (speed, acceleration))
    found = bounds(reading, "order=2", f"v_max={v_max}", f"a_max={a_max}", TILTED, "d_hat_min=0.5")
    assert _contains(found, one_axis_dip(setting(found.problem), reading.value, axis))


@pytest.mark.parametrize(
    ("reading", "longest"),
    [
        # V·T + W·T²/2 + J·T³/6
        pytest.param(INITIAL_STATE, 2 * (2 * 0.1 + 2 * 0.1**2 / 2 + 5 * 0.1**3 / 6), marks=pytest.mark.deep),
        # V·T
        pytest.param(WHOLE_MOTION, 2 * (2 * 0.1), marks=pytest.mark.deep),
        # ∫v of a quadratic v with v(0), v(T) ≤ V and v'' = −u ≥ −J is at most V·T + J·T³/12
        (AS_SAMPLED, 2 * (2 * 0.1 + 5 * 0.1**3 / 12)),
    ],
)
def test_passing_along_one_axis_with_bounded_jerk_has_a_closed_form(reading: Reading, longest: float) -> None:
    """With order 3 and speeds at which passing beats turning back, the dip is that of the longest chord."""
    found = bounds(reading, "v_max=2,0,0", "a_max=2,0,0", "j_max=5,0,0", "T_s=0.1", "d_hat_min=0.3")
    # no |w''| is larger than this, hence no sagitta, hence no turning back
    turn = 2 * (2 + 5 * 0.1) * 0.1**2 / 8
    assert chord_dip(longest, 0.3) > turn
    assert _contains(found, chord_dip(longest, 0.3))


@every_reading
@pytest.mark.deep
def test_turning_back_with_bounded_acceleration_has_a_closed_form(reading: Reading) -> None:
    """With order 3 and a jerk of zero, an acceleration W all along turns back by W·T²/8."""
    found = bounds(reading, "v_max=0,0.6,0", "a_max=0,5,0", "j_max=0", "T_s=0.1", "theta_inverse=1")
    passing = chord_dip(2 * (0.6 + (5 * 0.1 / 2 if reading is INITIAL_STATE else 0)) * 0.1, 0.25)
    assert _contains(found, max(passing, 10 * 0.1**2 / 8))


# ---- properties


@st.composite
def problems(draw: st.DrawFn, readings: tuple[Reading, ...] = (INITIAL_STATE, AS_SAMPLED)) -> Problem:
    """Return a problem that is solved within a second or so; `whole-motion` with the double integrator."""
    reading = draw(st.sampled_from(readings))
    speeds = ",".join(draw(st.lists(st.sampled_from(("0.4", "0.7", "1", "1.3")), min_size=3, max_size=3)))
    return problem(
        reading,
        f"v_max={speeds}",
        f"a_max={draw(st.sampled_from((3, 5, 8)))}",
        f"j_max={draw(st.sampled_from((5, 40)))}",
        f"order={2 if reading is WHOLE_MOTION else 3 if reading is INITIAL_STATE else draw(st.sampled_from(ORDERS))}",
        "T_c=0.05",
        f"d_hat_min={draw(st.sampled_from(('0.25', '0.3')))}",
    )


def _changed(asked: Problem, *changes: str) -> Problem:
    return Problem(asked.parameters.with_changes(changes), asked.reading)


def _listed(values: tuple[Fraction, ...], factor: Fraction = Fraction(1)) -> str:
    return ",".join(str(value * factor) for value in values)


def _check_monotone(asked: Problem, name: str, axis: int) -> None:
    """Check that a larger bound on one axis, or a larger T_c, does not lead to a smaller dip."""
    if name == "T_c":
        wider = _changed(asked, f"T_c={asked.parameters.T_c * Fraction(5, 4)}")
    else:
        values = list(getattr(asked.parameters, name))
        values[axis] *= Fraction(3, 2)
        wider = _changed(asked, f"{name}={_listed(tuple(values))}")
    assert solved(asked).lower <= solved(wider).upper


@examples(2)
@given(problems(), st.sampled_from(("v_max", "a_max", "j_max")), st.integers(0, 2))
def test_larger_bounds_allow_larger_dips(asked: Problem, name: str, axis: int) -> None:
    """The dip does not fall if a bound grows, on one axis."""
    _check_monotone(asked, name, axis)


@examples(1)
@given(problems((INITIAL_STATE, WHOLE_MOTION)))
def test_longer_windows_allow_larger_dips(asked: Problem) -> None:
    """The dip does not fall if T_c grows, where it is not tied to T_s."""
    _check_monotone(asked, "T_c", 0)


@examples(2)
@given(problems((WHOLE_MOTION,)))
def test_bounds_at_all_times_allow_less(asked: Problem) -> None:
    """`whole-motion` allows no more than `initial-state`."""
    printed = Problem(asked.parameters, INITIAL_STATE)
    assert solved(asked).lower <= solved(printed).upper


@examples(2)
@given(problems((AS_SAMPLED,)))
def test_bounds_that_hold_more_often_allow_less(asked: Problem) -> None:
    """X at twice as many samples of `as-sampled` does not allow a larger dip."""
    assert solved(_changed(asked, f"T_b={asked.parameters.T_s / 2}")).lower <= solved(asked).upper


def _check_lengths(asked: Problem, scale: Fraction) -> None:
    """Check that the dip is a length: in another unit it is another number for the same thing."""
    given_ = asked.parameters
    lengths = [f"{name}={_listed(getattr(given_, name), scale)}" for name in ("v_max", "a_max", "j_max")]
    assert overlap(solved(asked), solved(_changed(asked, *lengths, f"d_hat_min={given_.d_hat_min * scale}")), scale)


def _check_times(asked: Problem, scale: Fraction) -> None:
    """Check that the dip does not depend on the unit of time."""
    given_ = asked.parameters
    times = [f"{name}={getattr(given_, name) * scale}" for name in ("T_s", "T_c", "T_b")]
    rates = [
        f"{name}={_listed(getattr(given_, name), scale**-power)}"
        for power, name in enumerate(("v_max", "a_max", "j_max"), start=1)
    ]
    assert overlap(solved(asked), solved(_changed(asked, *times, *rates)))


SCALES = st.sampled_from((Fraction(1, 3), Fraction(2), Fraction(7)))


@examples(2)
@given(problems((INITIAL_STATE, AS_SAMPLED, WHOLE_MOTION)), SCALES)
def test_the_dip_is_a_length(asked: Problem, scale: Fraction) -> None:
    """With all lengths multiplied by a factor, so is the dip."""
    _check_lengths(asked, scale)


@examples(2)
@given(problems((INITIAL_STATE, AS_SAMPLED, WHOLE_MOTION)), SCALES)
def test_the_dip_depends_on_no_unit_of_time(asked: Problem, scale: Fraction) -> None:
    """With all times multiplied by a factor, and rates divided by its powers, the dip stays."""
    _check_times(asked, scale)


def _check_permuted(asked: Problem, order: tuple[int, ...]) -> None:
    """Check that nothing depends on what axes are called."""
    given_ = asked.parameters
    changes = [f"{name}={_listed(tuple(getattr(given_, name)[k] for k in order))}" for name in ("v_max", "a_max")]
    matrix = _listed(tuple(given_.theta_inverse[i][k] for i in order for k in order))
    assert overlap(solved(asked), solved(_changed(asked, *changes, f"theta_inverse={matrix}")))


@examples(2)
@given(problems((INITIAL_STATE, AS_SAMPLED, WHOLE_MOTION)), st.permutations(range(3)))
def test_axes_may_be_permuted(asked: Problem, order: list[int]) -> None:
    """With the axes in another order, everywhere, the dip stays."""
    _check_permuted(asked, tuple(order))


@pytest.mark.parametrize("reading", ONE_SUFFICES)
@pytest.mark.parametrize(
    "theta_inverse",
    [
        "0.8,-0.3,0.2,-0.3,1,0,0.2,0,0.5",  # turned by 90 degrees about z
        pytest.param("1,-0.3,0,-0.3,0.8,0.2,0,0.2,0.5", marks=pytest.mark.deep),  # y mirrored
        pytest.param("1,0.3,0,0.3,0.8,0.2,0,0.2,0.5", marks=pytest.mark.deep),  # z mirrored
    ],
)
def test_theta_may_be_turned_by_a_right_angle_and_mirrored(theta_inverse: str, reading: Reading) -> None:
    """With equal bounds on all axes, turning Θ by 90 degrees or mirroring it leaves the dip as it is."""
    changes = ("order=2", "T_c=0.05", "v_max=1")
    turned = bounds(reading, *changes, f"theta_inverse={theta_inverse}")
    assert overlap(bounds(reading, *changes, TILTED), turned)
    assert relative_width(turned) <= 0.02


@pytest.mark.parametrize("reading", ONE_SUFFICES)
def test_theta_that_is_nearly_diagonal_leads_to_the_dip_of_a_diagonal_one(reading: Reading) -> None:
    """The proof for Θ that is not diagonal, which mirrors x alone, agrees with the one that mirrors all axes."""
    changes = ("order=2", "T_c=0.05", "v_max=1,0.8,0.6")
    straight = bounds(reading, *changes)
    nearly = bounds(reading, *changes, "theta_inverse=1,1e-9,0,1e-9,1,0,0,0,1/6")
    assert not nearly.problem.diagonal
    slack = Fraction(1, 10**8)
    assert straight.lower <= nearly.upper + slack
    assert nearly.lower <= straight.upper + slack


@every_reading
def test_theta_across_the_motion_does_not_matter(reading: Reading) -> None:
    """With motion along z alone, Θ⁻¹ = RᵀDR with a rotation R about z (sides 3, 4, 5) leads to the dip for D."""
    changes = ("v_max=0,0,2", "a_max=0", "j_max=0", "T_c=0.05")
    # D = diag(2, 1, 1/2): 2·(9/25) + 16/25, (2 − 1)·12/25, 2·(16/25) + 9/25
    turned = bounds(reading, *changes, "theta_inverse=34/25,12/25,0,12/25,41/25,0,0,0,1/2")
    assert overlap(turned, bounds(reading, *changes, "theta_inverse=2,1,1/2"))
    assert _contains(turned, chord_dip(0.1, 0.25))


def test_one_value_for_all_axes_is_three_equal_ones() -> None:
    """A scalar, a list of three and a full matrix are ways to write the same parameters."""
    short = Parameters().with_changes(["v_max=1", "theta_inverse=1"])
    assert short == Parameters().with_changes(["v_max=1,1,1", "theta_inverse=1,0,0,0,1,0,0,0,1"])
    assert short == Parameters().with_changes(["v_max=1,1,1", "theta_inverse=1,1,1"])


@st.composite
def hard_problems(draw: st.DrawFn) -> Problem:
    """Return a problem of any reading and order; `whole-motion` with the triple integrator takes ten seconds."""
    asked = draw(problems(tuple(READINGS)))
    return _changed(asked, f"order={draw(st.sampled_from(ORDERS))}")


@pytest.mark.deep
@examples(2)
@given(hard_problems(), SCALES, st.permutations(range(3)), st.sampled_from(("v_max", "a_max", "j_max", "T_c")))
def test_all_properties_hold_for_all_problems(asked: Problem, scale: Fraction, order: list[int], name: str) -> None:
    """Scaling, permuting and growing bounds, for all readings and both orders."""
    _check_lengths(asked, scale)
    _check_times(asked, scale)
    _check_permuted(asked, tuple(order))
    if name != "T_c" or asked.reading is not AS_SAMPLED:
        _check_monotone(asked, name, 1)


# ---- brute force

RANDOM = [
    ("T_c=0.05", "v_max=1,0.8,0.6"),
    pytest.param(("T_c=0.05", "v_max=1", TILTED), marks=pytest.mark.deep),
]


@every_reading
@both_orders
@pytest.mark.parametrize("changes", RANDOM)
def test_random_pairs_never_beat_the_upper_bound(reading: Reading, order: int, changes: tuple[str, ...]) -> None:
    """No random feasible pair dips by more than the upper bound."""
    if reading is WHOLE_MOTION and order == 3:
        changes = ("T_c=0.05", *changes[2:])
    found = bounds(reading, f"order={order}", *changes)
    drawn = random_dips(setting(found.problem), reading.value, 2000, seed=1)
    assert drawn.max() <= float(found.upper) + 1e-9
    # they are not far from it, either: the test could fail
    assert drawn.max() >= 0.5 * float(found.lower)


@every_reading
@both_orders
@pytest.mark.deep
def test_no_random_pair_of_many_settings_beats_the_upper_bound(reading: Reading, order: int) -> None:
    """Random pairs, many of them, in settings where passing, turning back, speed or jerk matters."""
    many: list[tuple[str, ...]] = [
        ("v_max=0.3", "a_max=20", "j_max=500"),
        ("v_max=0.2,1,0.5", "a_max=1,5,10", "j_max=100", TILTED),
        ("T_c=0.04", "T_b=0.1", "v_max=2"),
        ("T_s=0.1", "theta_inverse=1", "v_max=0.5", "j_max=2000"),
    ]
    for changes in many:
        found = bounds(reading, f"order={order}", *changes)
        drawn = random_dips(setting(found.problem), reading.value, 20_000, seed=0)
        assert drawn.max() <= float(found.upper) + 1e-9


def _check_search(found: Margin) -> None:
    """Check the interval against the brute force's own search."""
    best = best_dip(setting(found.problem), found.problem.reading.value)
    assert best <= float(found.upper) + 1e-9
    assert best >= float(found.lower) - 0.03 * float(found.problem.parameters.d_hat_min)


@pytest.mark.parametrize(
    ("reading", "changes"),
    [
        (INITIAL_STATE, ("T_c=0.05",)),
        (AS_SAMPLED, ("v_max=1",)),
        (WHOLE_MOTION, ("T_c=0.05", "order=2", "v_max=1,0.8,0.6")),
    ],
)
def test_an_independent_search_agrees(reading: Reading, changes: tuple[str, ...]) -> None:
    """What the brute force finds is not above the interval, and hardly below it."""
    _check_search(bounds(reading, *changes))


@every_reading
@both_orders
@pytest.mark.deep
@pytest.mark.parametrize(
    "changes",
    [
        ("T_c=0.05", TILTED),
        ("v_max=0.5",),
    ],
)
def test_an_independent_search_agrees_in_many_settings(reading: Reading, order: int, changes: tuple[str, ...]) -> None:
    """What the brute force finds is not above the interval, and hardly below it, in more settings."""
    _check_search(bounds(reading, f"order={order}", *changes))


# ---- goals

SINGLE_CHANGES = [
    (),
    *((f"T_c={value}",) for value in ("0.01", "0.02", "0.05")),
    *((f"v_max={value}",) for value in ("0.5", "1")),
    ("theta_inverse=1",),
    ("d_hat_min=0.35",),
    ("j_max=100",),
    ("order=2",),
]


@pytest.mark.parametrize(
    ("reading", "changes"),
    [
        (INITIAL_STATE, ("T_c=0.05",)),
        (AS_SAMPLED, ("d_hat_min=0.35",)),
        (WHOLE_MOTION, ("T_c=0.05",)),
        (AS_SAMPLED, ("v_max=0.5",)),
    ],
)
def test_the_interval_is_narrow(reading: Reading, changes: tuple[str, ...]) -> None:
    """The interval is at most 1e-4·d̂_min wide."""
    assert relative_width(bounds(reading, *changes)) <= 1e-4


@pytest.mark.deep
@every_reading
@pytest.mark.parametrize("changes", SINGLE_CHANGES, ids=" ".join)
def test_the_interval_is_narrow_for_every_single_change(reading: Reading, changes: tuple[str, ...]) -> None:
    """The interval is at most 1e-4·d̂_min wide for every single change that the paper's readers will try."""
    assert relative_width(bounds(reading, *changes)) <= 1e-4


def test_the_brute_force_sees_the_same_numbers() -> None:
    """The published parameters are those of the paper, as floats."""
    published = setting(problem(AS_SAMPLED))
    assert (published.T_c, published.T_s, published.T_b, published.d_hat_min) == (0.1, 0.2, 0.2, 0.25)
    assert published.v_max == (2.0, 2.0, 2.0)
    assert np.array_equal(published.theta_inverse, np.diag([1, 1, 1 / 6]))


# ---- altered certificates

CERTIFIED = [(INITIAL_STATE, 3), (AS_SAMPLED, 3), (WHOLE_MOTION, 2)]
each_certificate = pytest.mark.parametrize(("reading", "order"), CERTIFIED)
Path = tuple[str | int, ...]


def _certified(reading: Reading, order: int) -> Margin:
    return bounds(reading, "T_c=0.05", f"order={order}", *(("v_max=1,0.8,0.6",) if order == 2 else ()))


def _leaves(content: Any, path: Path = ()) -> Iterator[Path]:
    """Yield the path of every value in a certificate that is no list or object."""
    if isinstance(content, dict | list):
        for key, value in content.items() if isinstance(content, dict) else enumerate(content):
            yield from _leaves(value, (*path, key))
    else:
        yield path


def _at(content: Any, path: Path) -> Any:
    for key in path:
        content = content[key]
    return content


def _altered(content: dict[str, Any], path: Path, value: object, sign: bool) -> dict[str, Any]:
    """Return a copy with another value at `path`, and, if it is to be signed, with the digest of that."""
    changed = copy.deepcopy(content)
    _at(changed, path[:-1])[path[-1]] = value
    if sign:
        rest = {key: part for key, part in changed.items() if key != "digest"}
        changed["digest"] = digest(rest)
    return changed


def _other(value: object, change: Fraction) -> object:
    """Return another value of the same kind; a number moves by `change` of itself (0: by `change`)."""
    if isinstance(value, int):
        return value + 1
    if value is None:
        return "0"
    assert isinstance(value, str)
    try:
        number = Fraction(value)
    except ValueError:
        return value + "0"
    return str(number * (1 + change) if number else change)


@each_certificate
@examples(60)
@given(st.data())
def test_a_certificate_with_any_value_changed_is_rejected(reading: Reading, order: int, data: st.DataObject) -> None:
    """Whichever value changes, even by little, the digest tells."""
    content = _certified(reading, order).certificate
    path = data.draw(st.sampled_from(list(_leaves(content))))
    value = _other(_at(content, path), data.draw(st.sampled_from((Fraction(1, 10**9), Fraction(-1, 3)))))
    with pytest.raises(Rejected):
        check(_altered(content, path, value, sign=False))


STRONGER: list[tuple[Path, str]] = [
    (("dip", "lower"), "1.00001"),
    (("dip", "upper"), "0.9999"),
    (("parameters", "d_hat_min"), "0.99"),
    (("parameters", "d_hat_min"), "1.01"),
    (("parameters", "T_c"), "1.01"),
    (("parameters", "T_c"), "2"),
    (("parameters", "v_max", 0), "1.01"),
    (("parameters", "theta_inverse", 0, 0), "1.01"),
    (("witness", "tau"), "0.99"),
    (("witness", "tau"), "1.01"),
]


@each_certificate
@pytest.mark.parametrize(("path", "factor"), STRONGER)
def test_a_signed_certificate_that_claims_more_is_rejected(
    reading: Reading, order: int, path: Path, factor: str
) -> None:
    """With the right digest, too, a claim that is stronger than what is proved is rejected."""
    content = _certified(reading, order).certificate
    check(content)
    value = str(Fraction(_at(content, path)) * Fraction(factor))
    with pytest.raises(Rejected):
        check(_altered(content, path, value, sign=True))


@each_certificate
def test_a_signed_certificate_with_another_witness_proves_no_less(reading: Reading, order: int) -> None:
    """Changing any number of the witness is rejected, unless the pair still comes as close as is claimed."""
    found = _certified(reading, order)
    rejected = 0
    paths = [path for path in _leaves(found.certificate) if path[0] == "witness"]
    for path in paths:
        for change in (Fraction(1, 100), Fraction(-1, 100)):
            value = _other(_at(found.certificate, path), change)
            try:
                still = from_certificate(_altered(found.certificate, path, value, sign=True))
            except Rejected:
                rejected += 1
            else:
                assert still.witness is not None
                assert still.witness.dip >= found.lower
    assert rejected >= len(paths)


@each_certificate
def test_a_signed_certificate_that_lacks_a_part_is_rejected(reading: Reading, order: int) -> None:
    """Every cell, every window and the witness are needed."""
    content = _certified(reading, order).certificate
    lacking = [_altered(content, ("witness",), None, sign=True), _altered(content, ("windows",), None, sign=True)]
    for number, window in enumerate(content["windows"]):
        rest = [*content["windows"][:number], *content["windows"][number + 1 :]]
        lacking.append(_altered(content, ("windows",), rest, sign=True))
        for gone in range(len(window["cells"])):
            cells = [*window["cells"][:gone], *window["cells"][gone + 1 :]]
            lacking.append(_altered(content, ("windows", number, "cells"), cells, sign=True))
    for changed in lacking:
        with pytest.raises(Rejected):
            check(changed)


# ---- planted bugs: what computes a margin may be wrong, but what it returns may not

Cells = list[prove.Cell]
Bug = Callable[[pytest.MonkeyPatch], None]


def _cells(change: Callable[[Cells], Cells]) -> Bug:
    """Return the bug that changes what is proved."""
    proved = prove.WindowProver.prove

    def wrong(*arguments: Any) -> Cells | prove.Blocked:
        cells = proved(*arguments)
        return cells if isinstance(cells, prove.Blocked) else change(sorted(cells, key=lambda cell: cell.early))

    return lambda patch: patch.setattr(prove.WindowProver, "prove", wrong)


def _moved(tree: prove.Tree) -> prove.Tree:
    """Return a tree with another t in its leaves."""
    if isinstance(tree, prove.Leaf):
        return prove.Leaf(tree.t + 0.05)
    assert isinstance(tree, prove.Cut)
    return replace(tree, below=tree.below and _moved(tree.below), above=tree.above and _moved(tree.above))


def _axes(of_states: Fraction, of_input: Fraction) -> Bug:
    """Return the bug that multiplies the bounds of the relative motion."""
    axes = vars(Problem)["axes"].func

    def wrong(self: Problem) -> tuple[AxisBounds, ...]:
        return tuple(
            AxisBounds(tuple((m, bound * of_states) for m, bound in one.derivatives), one.input * of_input)
            for one in axes(self)
        )

    return lambda patch: patch.setattr(Problem, "axes", property(wrong))


def _result(module: object, name: str, change: Callable[[Any], Any]) -> Bug:
    """Return the bug that changes what a function returns."""
    right = getattr(module, name)
    return lambda patch: patch.setattr(module, name, lambda *arguments: change(right(*arguments)))


BUGS: dict[str, Bug] = {
    # the checker widens the polygons of a cell by its own e
    "no bending between the ends of a cell": _result(Problem, "bending", lambda value: 0.0),
    # the checker computes every offset from the multipliers
    "offsets are too small": _result(polygon, "offset", lambda value: 0.99 * value),
    # the checker computes κ
    "κ is too small": _result(corners, "largest_product", lambda value: 0.98 * value),
    # cells cover the window without gaps
    "the first cell is lost": _cells(lambda cells: cells[1:]),
    "the last cell is lost": _cells(lambda cells: cells[:-1]),
    # the checker evaluates (*) at all corners with the t that is written
    "t is another one": _cells(lambda cells: [replace(cell, tree=_moved(cell.tree)) for cell in cells]),
    "too little is asked of the corners": lambda patch: patch.setattr(prove, "SLACK", -1e-3),
    # the checker doubles the bounds of one UAV itself
    "bounds are not doubled": _axes(Fraction(1, 2), Fraction(1, 2)),
    "bounds of the input are not doubled": _axes(Fraction(1), Fraction(1, 2)),
    # the checker simulates the witness
    "the witness is beyond its bounds": _axes(Fraction(2), Fraction(2)),
    "the witness is too close at the ends": _result(
        witness, "_place", lambda shift: shift and tuple(value + Fraction(1, 100) for value in shift)
    ),
    "the witness's dip is too large": _result(
        witness, "make_witness", lambda found: replace(found, dip=found.dip + Fraction(1, 10**6))
    ),
}
#: Bugs of the windows, which matter to `as-sampled` alone.
WINDOW_BUGS: dict[str, Bug] = {
    # the checker knows when a window starts, and which ones there are
    "every window starts at 0": _result(Problem, "start_of", lambda value: 0.0),
    "one window is enough": lambda patch: patch.setattr(Problem, "windows", property(lambda self: (0,))),
}
#: Bugs that cost exactness or time, but cannot make anything wrong.
HARMLESS: dict[str, Bug] = {
    # half-planes hold for any multipliers whatever, as their offset is computed for these
    "multipliers are not the best ones": _result(
        extremes.Sampled, "at", lambda found: replace(found, multipliers=found.multipliers[:1])
    ),
    # a witness is only a lower bound
    "no candidates are found": _result(ascent.Ascent, "from_scratch", lambda found: []),
}


def _with(bug: Bug, asked: Problem) -> Margin:
    # a new problem: what was computed for an old one is kept
    with pytest.MonkeyPatch.context() as patch:
        bug(patch)
        return margin(Problem(asked.parameters, asked.reading))


@pytest.mark.parametrize("reading", [INITIAL_STATE, AS_SAMPLED])
@pytest.mark.parametrize("bug", BUGS)
def test_a_planted_bug_is_noticed(bug: str, reading: Reading) -> None:
    """The exact checker rejects what a wrong search or a wrong proof leads to."""
    with pytest.raises(Rejected):
        _with(BUGS[bug], problem(reading, "T_c=0.05"))


@pytest.mark.deep
@pytest.mark.parametrize("bug", BUGS)
def test_a_planted_bug_in_whole_motion_is_noticed(bug: str) -> None:
    """The exact checker rejects wrong proofs of the double integrator's `whole-motion`, too."""
    with pytest.raises(Rejected):
        _with(BUGS[bug], problem(WHOLE_MOTION, "T_c=0.05", "order=2"))


@pytest.mark.parametrize("bug", WINDOW_BUGS)
def test_a_planted_bug_of_the_windows_is_noticed(bug: str) -> None:
    """The exact checker rejects proofs for wrong windows, or too few of them."""
    with pytest.raises(Rejected):
        _with(WINDOW_BUGS[bug], problem(AS_SAMPLED, "T_c=0.05"))


@pytest.mark.parametrize("bug", HARMLESS)
def test_a_harmless_bug_only_widens_the_interval(bug: str) -> None:
    """Worse multipliers and a search that finds nothing leave the interval valid."""
    asked = problem(AS_SAMPLED, "T_c=0.05")
    assert overlap(_with(HARMLESS[bug], asked), solved(asked))


# ---- Θ that is not diagonal, and a workspace


@pytest.mark.parametrize(
    "reading",
    [INITIAL_STATE, *(pytest.param(reading, marks=pytest.mark.deep) for reading in (AS_SAMPLED, WHOLE_MOTION))],
)
def test_the_witness_stays_in_the_workspace(reading: Reading) -> None:
    """With Θ that is not diagonal and a small workspace the interval is certified, and both UAVs stay inside."""
    box = "workspace=-0.2,0.3,1,1.5,0,1.2"
    found = bounds(reading, "T_c=0.05", "v_max=1", TILTED, box)
    check(found.certificate)
    assert overlap(found, from_certificate(found.certificate))
    # a workspace only takes motions away
    assert found.lower <= bounds(reading, "T_c=0.05", "v_max=1", TILTED).upper
    assert found.lower > 0
    assert found.witness is not None
    given_ = found.problem.parameters
    assert given_.workspace is not None
    times = {
        INITIAL_STATE: [Fraction(0)],
        WHOLE_MOTION: [given_.T_c * k / 100 for k in range(101)],
        AS_SAMPLED: [Fraction(0), given_.T_s],
    }[reading]
    for motion in (found.witness.uav_i, found.witness.uav_j):
        for one, (low, high) in zip(motion, closed(given_.workspace), strict=True):
            assert all(low <= one.position(time) <= high for time in times)
