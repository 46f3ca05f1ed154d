"""The checker of margin certificates accepts hand-made ones, and rejects what claims more or makes no sense."""

from __future__ import annotations

import ast
import json
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.margin.hand_made import CASES, CELL, LOWER, Json, altered, cell_of, edges_of, made, places, signed

from swarmproof.margin.check import Rejected, Verified, check, read

#: The same examples every time, and no clock.
SETTINGS = settings(
    max_examples=300,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)


PARTS = sorted((Path(__file__).parents[2] / "checks/swarmproof/margin").glob("check*.py"))


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.stem)
def test_the_checker_stands_alone(part: Path) -> None:
    """The modules of the checker import only each other and the standard library, so that no error of ours gets in."""
    allowed = {f"swarmproof.margin.{one.stem}" for one in PARTS}
    assert "swarmproof.margin.check" in allowed
    for node in ast.walk(ast.parse(part.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert {alias.name.split(".")[0] for alias in node.names} <= sys.stdlib_module_names
        elif isinstance(node, ast.ImportFrom):
            assert node.module is not None
            assert node.level == 0
            assert node.module in allowed or node.module.split(".")[0] in sys.stdlib_module_names


@pytest.mark.parametrize(("reading", "order"), CASES)
def test_hand_made_certificates_are_accepted(reading: str, order: int) -> None:
    """In each reading and order, what was worked out by hand is verified, also after a way through JSON."""
    expected = Verified(Fraction(LOWER), Fraction(CASES[reading, order][3]), leaves=1, cells=1, windows=1)
    certificate = made(reading, order)
    assert check(certificate) == expected
    assert check(read(json.dumps(certificate, indent=1))) == expected
    assert check(read(json.dumps(certificate).encode())) == expected


@pytest.mark.parametrize(("reading", "order"), CASES)
@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"dip/upper": "-0.000001"}, "closer than upper"),
        ({"dip/lower": "0.000001"}, "not as close at tau"),
    ],
    ids=["upper", "lower"],
)
def test_the_hand_made_bounds_are_sharp(reading: str, order: int, changes: dict[str, str], reason: str) -> None:
    """A millionth less as upper bound, or more as lower bound, is rejected: both tests are exact, not about right."""
    certificate = made(reading, order)
    place, by = next(iter(changes.items()))
    claimed = str(Fraction(certificate["dip"][place.split("/")[1]]) + Fraction(by))
    with pytest.raises(Rejected, match=reason):
        check(altered(certificate, {place: claimed}))


@pytest.mark.parametrize("order", [2, 3])
def test_null_stands_for_trivial_bounds(order: int) -> None:
    """Without windows upper is d_hat_min, without a witness lower is 0; nothing else can be claimed then."""
    certificate = made("initial-state", order)
    only_witness = altered(certificate, {"windows": None, "dip/upper": "1"})
    assert check(only_witness) == Verified(Fraction(1, 5), Fraction(1), 0, 0, 0)
    only_windows = altered(certificate, {"witness": None, "dip/lower": "0"})
    assert check(only_windows).lower == 0
    with pytest.raises(Rejected, match="windows: there are none"):
        check(altered(only_witness, {"dip/upper": "0.999"}))
    with pytest.raises(Rejected, match="witness, there is none"):
        check(altered(only_windows, {"dip/lower": "0.001"}))


def test_progress_is_told_of_every_cell() -> None:
    """`progress` hears the number of cells done and the number of all, once per cell."""
    cells = [cell_of([], "0", "1/3"), cell_of([], "1/3", "1")]
    told: list[tuple[int, int]] = []
    # at 1/3, g has the kernel of a tent: e = 2a/9, to which comes 2a·(2/3)²/8 between; 0.9 is on the safe side
    certificate = altered(made("initial-state", 2), {"windows/0/cells": cells, "dip/upper": "0.9"})
    assert check(certificate, lambda done, total: told.append((done, total))).cells == 2
    assert told == [(1, 2), (2, 2)]


def test_multipliers_and_cells_of_order_3() -> None:
    """In whole-motion with two cells, a multiplier for the acceleration at 1/2 proves the g worked out by hand."""
    # g(1/2) − w''(1/2)/8 has the kernel −s²/4, later (1 − s)²/4, so g ≤ 2a/8 + 2j/48; to this comes e = 2a/32
    delta, proof = [["1/2", 1, "1"]], [["1/2", 2, "1/8"]]
    cells = [cell_of(delta, "0", "1/2"), cell_of(delta, "1/2", "1")]
    cells[0]["edges"][0][1]["proofs"] = [[], proof]
    cells[1]["edges"][0][1]["proofs"] = [proof, []]
    # a = 0.4, j = 4.8: 0.1 + 0.2 + 0.025 off a chord whose middle is 0.6 long
    certificate = altered(made("whole-motion", 3), {"windows/0/cells": cells, "dip/upper": "0.725"})
    assert check(certificate) == Verified(Fraction(1, 5), Fraction(29, 40), 2, 2, 1)
    with pytest.raises(Rejected, match="closer than upper"):
        check(altered(certificate, {"dip/upper": "0.7249"}))
    with pytest.raises(Rejected, match="closer than upper"):  # without it there is more: 2a/8 + 2j/16
        check(altered(certificate, {f"{CELL}/edges/0/1/proofs/1": []}))


def test_densities_for_velocity_and_acceleration() -> None:
    """In whole-motion, densities are subtracted like multipliers, at the price of ∫|ρ| times the bound."""
    velocity = [["0", "1", 1, "1", "1"]]  # δ is the integral of the velocity: nothing is left, so δ ≤ 2v = 1.2
    for order, upper in ((2, "0.4"), (3, "0.3")):
        certificate = altered(made("whole-motion", order), {f"{CELL}/edges": [edges_of(velocity)], "dip/upper": upper})
        assert check(certificate).upper == Fraction(upper)
        with pytest.raises(Rejected, match="closer than upper"):
            check(altered(certificate, {"dip/upper": str(Fraction(upper) - Fraction(1, 10**6))}))
        for shorter in (["0", "0.9", 1, "1", "1"], ["0.1", "1", 1, "1", "1"], ["0", "1", 1, "0.9", "0.9"]):
            with pytest.raises(Rejected, match="closer than upper"):
                check(altered(certificate, {f"{CELL}/edges": [edges_of([shorter])]}))
    # δ − w'(1/2) is the integral of −s·w'', later (1 − s)·w'': δ ≤ 2v + 2a/4 = 1.6, whatever the jerk; e = 2a/8 = 0.2
    acceleration = [["1/2", 1, "1"], ["0", "1/2", 2, "0", "-1/2"], ["1/2", "1", 2, "0.5", "0"]]
    changes = {"parameters/a_max/0": "0.8", "parameters/j_max/0": "1000", "dip/upper": "0.6"}
    certificate = altered(made("whole-motion", 3), {**changes, f"{CELL}/edges": [edges_of(acceleration)]})
    assert check(certificate).upper == Fraction(3, 5)
    with pytest.raises(Rejected, match="closer than upper"):
        check(altered(certificate, {"dip/upper": "0.599999"}))
    with pytest.raises(Rejected, match="closer than upper"):
        check(altered(certificate, {f"{CELL}/edges/0/0/proofs/0/2/4": "0.01"}))


@pytest.mark.parametrize(
    ("reading", "order", "density", "reason"),
    [
        ("initial-state", 3, ["0", "1", 1, "1", "1"], "a density has no such times"),
        ("as-sampled", 3, ["0", "1", 1, "1", "1"], "a density has no such times"),
        ("whole-motion", 3, ["0", "1.1", 1, "1", "1"], "a density has no such times"),
        ("whole-motion", 3, ["-0.1", "1", 1, "1", "1"], "a density has no such times"),
        ("whole-motion", 3, ["1", "1", 1, "1", "1"], "a density has no such times"),
        ("whole-motion", 3, ["1", "0", 1, "1", "1"], "a density has no such times"),
        ("whole-motion", 3, ["0", "1", 1, "1", "0.9"], "different rates"),
        ("whole-motion", 2, ["0", "1", 2, "1", "1"], "2: expected an integer from 1 to 1"),
        ("whole-motion", 3, ["0", "1", 0, "1", "1"], "2: expected an integer from 1 to 2"),
        ("whole-motion", 3, ["0", "1", 3, "1", "1"], "2: expected an integer from 1 to 2"),
        ("whole-motion", 3, ["0", "1", "1", "1", "1"], "2: expected an integer from 1 to 2"),
        ("whole-motion", 3, ["0", "1", 1, "1", 1], "4: expected a number"),
        ("whole-motion", 3, ["0", "1", 1, "1"], "expected a list of length 3"),
        ("whole-motion", 3, "01111", "expected a list"),
    ],
)
def test_densities_that_cannot_be(reading: str, order: int, density: list[Any], reason: str) -> None:
    """Densities are rejected in other readings, at other times, for other derivatives, and with a wrong shape."""
    with pytest.raises(Rejected, match=reason):
        check(altered(made(reading, order), {f"{CELL}/edges/0/0/proofs/0": [density]}))


@pytest.mark.parametrize("direction", [["1", "-6"], ["-1", "6"]])
def test_breakpoints_sharpen_the_integral(direction: list[str]) -> None:
    """A multiplier 0 where the kernel changes its sign makes ∫|q| exact, for an edge and for the one opposite."""
    # δ − 6g(1/2) has the kernel 1 − 4s, from 1/2 on −2(1 − s): ∫|q| = 1/2; for the times between 6·0.025 is added.
    breakpoints = [["1/4", 1, "0"], ["7", 1, "0"], ["-7", 1, "0"]]
    cells = [cell_of([], "0", "1/2"), cell_of([], "1/2", "1")]
    cells[0]["edges"][0].append({"direction": direction, "proofs": [[], breakpoints]})
    # That δ − 6g ≤ 2v + 2a/2 + 0.15 = 1.75 shows in what is empty above.
    cells[0]["tree"] = {"axis": 0, "normal": ["1", "-6"], "at": "1.7501", "below": {"t": "0"}, "above": None}
    certificate = altered(made("initial-state", 2), {"windows/0/cells": cells, "dip/upper": "0.9"})
    assert check(certificate).cells == 2
    with pytest.raises(Rejected, match="tree, above, expected an object"):  # touched is not empty
        check(altered(certificate, {f"{CELL}/tree/at": "1.75"}))
    with pytest.raises(Rejected, match="tree, above, expected an object"):
        check(altered(certificate, {f"{CELL}/edges/0/2/proofs/1": breakpoints[1:]}))


def test_the_worst_corner_need_not_have_the_longest_delta() -> None:
    """A corner with a shorter δ and a longer g is looked at, too: here it is the one where (*) is smallest."""
    # As u is constant, δ + 4g(1/2) = w'(1) and δ − 4g(1/2) = w'(0), so both are at most 1.2 (1.4 in between, as
    # e = 0.05): the corners are (1.2, 0.05), where (*) is 0.75, and (0.4, 0.25), where it is √0.96 − 0.25 = 0.7297…
    cells = [cell_of([], "0", "1/2"), cell_of([], "1/2", "1")]
    middle = [["1/2", 1, "1"]]
    for cell, order in ((cells[0], 1), (cells[1], -1)):
        edges = edges_of(middle)
        for beta, time in (("4", "1"), ("-4", "0")):
            edges.append({"direction": ["1", beta], "proofs": [middle, [[time, 1, "1"]]][::order]})
        cell["edges"] = [edges]
    claim = {"windows/0/cells": cells, "parameters/a_max/0": "0.8", "dip/upper": "0.2703"}
    certificate = altered(made("as-sampled", 2), claim)
    assert check(certificate).leaves == 2
    with pytest.raises(Rejected, match="closer than upper"):
        check(altered(certificate, {"dip/upper": "0.2702"}))


def test_a_tree_cuts_a_polygon() -> None:
    """Both sides of a cut are checked, with their own weights; a part without corners needs no tree."""
    certificate = made("initial-state", 2)
    leaf = {"t": "0"}
    outside = {"axis": 0, "normal": ["1", "0"], "at": "2", "below": leaf, "above": None}
    inside = {"axis": 0, "normal": ["1", "-1"], "at": "0.7", "below": leaf, "above": outside}
    assert check(altered(certificate, {f"{CELL}/tree": inside})).leaves == 2
    with pytest.raises(Rejected, match="tree, above, expected an object"):
        check(altered(certificate, {f"{CELL}/tree": {**inside, "above": None}}))
    with pytest.raises(Rejected, match="tree, below, expected an object"):
        check(altered(certificate, {f"{CELL}/tree": {**outside, "below": None}}))
    with pytest.raises(Rejected, match="normal is"):
        check(altered(certificate, {f"{CELL}/tree": {**inside, "normal": ["0", "0"]}}))


def test_a_weight_may_differ_from_the_time() -> None:
    """A t > 0 is right while both weights stay in [0, 1], and then counts: it moves the point of the chord."""
    cells = [cell_of([], "0", "1/2"), cell_of([], "1/2", "1")]
    certificate = altered(made("initial-state", 2), {"windows/0/cells": cells, "dip/upper": "0.9"})
    assert check(certificate).cells == 2
    # with t = 0.1 the chord's point is 0.16 further off, and κ stays 1/4: 0.6 − (0.1 + 0.025 + 0.16) = 0.315
    shifted = altered(certificate, {f"{CELL}/tree": {"t": "0.1"}, "dip/upper": "0.685"})
    assert check(shifted).upper == Fraction(137, 200)
    with pytest.raises(Rejected, match="closer than upper"):
        check(altered(shifted, {"dip/upper": "0.684"}))
    for cell, t in (("0", "-0.01"), ("0", "0.51"), ("1", "0.01"), ("1", "-0.51")):
        with pytest.raises(Rejected, match="a weight is not in"):
            check(altered(certificate, {f"windows/0/cells/{cell}/tree": {"t": t}}))


def test_theta_scales_and_couples() -> None:
    """Θ⁻¹ enters both bounds; if it couples x and y, what was proved for the identity is not proved any more."""
    certificate = made("initial-state", 2)
    # everything twice as long, d_hat_min, too: the dip is twice as deep
    double = [["2", "0", "0"], ["0", "2", "0"], ["0", "0", "2"]]
    twice = altered(certificate, {"parameters/theta_inverse": double, "parameters/d_hat_min": "2", "dip/upper": "1"})
    twice = altered(twice, {"dip/lower": "0.4"})
    assert check(twice) == Verified(Fraction(2, 5), Fraction(1), 1, 1, 1)
    coupled = [["1", "0.1", "0"], ["0.1", "1", "0"], ["0", "0", "1"]]
    with pytest.raises(Rejected, match="witness"):
        check(altered(certificate, {"parameters/theta_inverse": coupled}))
    # ‖A(1.6, 0, 0)‖²/4 = 0.6464 and ‖A(0.1, 0, 0)‖² = 0.0101: √0.3536 − √0.0101 is 0.4941…
    alone = altered(certificate, {"parameters/theta_inverse": coupled, "witness": None, "dip/lower": "0"})
    assert check(altered(alone, {"dip/upper": "0.506"})).upper == Fraction("0.506")
    with pytest.raises(Rejected, match="closer than upper"):
        check(altered(alone, {"dip/upper": "0.505"}))


def test_all_axes_count_together() -> None:
    """With motion along three axes, coupled ones and others, the corners of all three polygons are combined."""
    moves = {f"parameters/{key}": [value] * 3 for key, value in (("v_max", "0.3"), ("a_max", "0.2"))}
    certificate = altered(made("initial-state", 2), {**moves, "witness": None, "dip/lower": "0"})
    # δ = 0.8 and g = 0.05 along each axis: √(1 − 3·0.16) − 0.05·√3 = 0.6345…
    assert check(altered(certificate, {"dip/upper": "0.3656"})).leaves == 1
    with pytest.raises(Rejected, match="closer than upper"):
        check(altered(certificate, {"dip/upper": "0.3654"}))
    # coupled: the longest A·(0.8, ±0.8, ±0.8) has ‖·‖² = 2·1.21·0.64 + 0.64, with signs alike or not; and so for g
    for coupling in ("0.1", "-0.1"):
        coupled = [["1", coupling, "0"], [coupling, "1", "0"], ["0", "0", "1"]]
        certificate = altered(certificate, {"parameters/theta_inverse": coupled})
        # √(1 − 0.5472) − 0.05·√3.42 = 0.5804…
        assert check(altered(certificate, {"dip/upper": "0.4197"})).leaves == 1
        with pytest.raises(Rejected, match="closer than upper"):
            check(altered(certificate, {"dip/upper": "0.4195"}))


def test_a_workspace_has_its_low_below_its_high() -> None:
    """A workspace the wrong way round is named."""
    certificate = altered(made("initial-state", 2), {"witness": None, "dip/lower": "0"})
    flat = [["0", "0"], ["-1", "1"], ["2", "3"]]
    assert check(altered(certificate, {"parameters/workspace": flat})).lower == 0
    with pytest.raises(Rejected, match="parameters, workspace: a low is above its high"):
        check(altered(certificate, {"parameters/workspace": [*flat[:2], ["3", "2"]]}))


def test_only_one_sign_of_delta_is_looked_at() -> None:
    """By symmetry δ < 0 is an empty part: for x always, for other axes if Θ⁻¹ is diagonal."""
    certificate = altered(made("initial-state", 2), {"witness": None, "dip/lower": "0", "dip/upper": "0.9"})
    coupled = [["1", "0.1", "0"], ["0.1", "1", "0"], ["0", "0", "1"]]
    for axis in (0, 1):
        tree = {"axis": axis, "normal": ["1", "0"], "at": "-0.01", "below": None, "above": {"t": "0"}}
        moving = {f"parameters/{key}": ["0.3", "0.3", "0.3"] for key in ("v_max", "a_max")}
        cut = altered(certificate, {**moving, f"{CELL}/tree": tree})
        assert check(cut).leaves == 1
        if axis == 0:
            assert check(altered(cut, {"parameters/theta_inverse": coupled})).leaves == 1
        else:
            with pytest.raises(Rejected, match="tree, below, expected an object"):
                check(altered(cut, {"parameters/theta_inverse": coupled}))


@pytest.mark.parametrize(
    "theta_inverse",
    [
        [["1", "0.1", "0"], ["0", "1", "0"], ["0", "0", "1"]],
        [["1", "0", "0"], ["0", "1", "0"], ["0.1", "0", "1"]],
        [["1", "0", "0"], ["0", "1", "0.1"], ["0", "-0.1", "1"]],
        [["-1", "0", "0"], ["0", "-1", "0"], ["0", "0", "1"]],
        [["1", "2", "0"], ["2", "1", "0"], ["0", "0", "-1"]],
        [["1", "0", "1"], ["0", "1", "0"], ["1", "0", "1"]],
        [["1", "0.9", "-0.9"], ["0.9", "1", "0.9"], ["-0.9", "0.9", "1"]],
    ],
)
def test_theta_is_symmetric_positive_definite(theta_inverse: list[list[str]]) -> None:
    """Anything else is no scaling, and is rejected whether or not a bound would follow."""
    certificate = altered(made("initial-state", 2), {"witness": None, "dip/lower": "0"})
    with pytest.raises(Rejected, match="parameters, theta_inverse is not symmetric positive definite"):
        check(altered(certificate, {"parameters/theta_inverse": theta_inverse}))


ROOM = [["-0.3", "0.3"], ["-1", "1"], ["-1", "1"]]


def test_a_workspace_bounds_positions() -> None:
    """With a workspace, multipliers of derivative 0 are allowed, each at the price of the workspace's width."""
    positions = [["0", 0, "-1"], ["1", 0, "1"]]
    lists = {f"{CELL}/edges": [edges_of(positions), edges_of([])], f"{CELL}/axes": [0, 1, 1]}
    certificate = altered(made("whole-motion", 2), lists)
    with pytest.raises(Rejected, match="1: expected an integer from 1 to 1"):
        check(certificate)
    # |w| ≤ 0.6, so δ ≤ 1.2 instead of 1.6; with e = 0.2 the distance left is 0.8 − 0.2
    certificate = altered(certificate, {"parameters/workspace": ROOM, "dip/upper": "0.4"})
    assert check(certificate) == Verified(Fraction(1, 5), Fraction(2, 5), 1, 1, 1)
    with pytest.raises(Rejected, match="closer than upper"):
        check(altered(certificate, {"parameters/workspace/0/1": "0.3001"}))
    with pytest.raises(Rejected, match="closer than upper"):  # the other axes' room is wider
        check(altered(certificate, {f"{CELL}/axes": [0, 0, 1]}))


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("reading", ["initial-state", "whole-motion", "as-sampled"])
def test_a_witness_stays_in_the_workspace(reading: str, order: int) -> None:
    """The witness's positions are looked at when the reading binds them: only at first, or later, too."""
    certificate = altered(made(reading, order), {"windows": None, "dip/upper": "1"})
    long_enough = [["-0.9", "0.9"], ["-0.4", "0.4"], ["0", "0"]]
    assert check(altered(certificate, {"parameters/workspace": long_enough})).lower == Fraction(1, 5)
    short = altered(certificate, {"parameters/workspace": [["-0.3", "0.29"], ["-0.4", "0.4"], ["0", "0"]]})
    with pytest.raises(Rejected, match="uav_"):
        check(short)
    later = altered(certificate, {"parameters/workspace": ROOM})
    moved = altered(later, {"witness/uav_i/0/state/0": "-0.25", "witness/uav_j/0/state/0": "0.35"})
    with pytest.raises(Rejected, match="leaves the workspace"):
        check(moved)


def test_a_turn_between_the_ends_is_seen() -> None:
    """In whole-motion, a velocity or a cubic position that is beyond its bound only inside a piece is rejected."""
    certificate = altered(made("whole-motion", 3), {"windows": None, "dip": {"lower": "0", "upper": "1"}})
    # along y: acceleration 0.4 falls by 0.8/s, so velocity rises by 0.1 until 1/2 s, and falls back
    turn = {"state": ["0.4", "0", "0.4"], "inputs": [["1", "-0.8"]]}
    allowed = {"parameters/v_max/1": "0.1", "parameters/a_max/1": "0.4", "parameters/j_max/1": "0.8"}
    certificate = altered(certificate, {**allowed, "witness/uav_i/1": turn})
    assert check(certificate).lower == 0
    with pytest.raises(Rejected, match="velocity or acceleration is beyond its bound during input 0"):
        check(altered(certificate, {"parameters/v_max/1": "0.0999"}))
    with pytest.raises(Rejected, match="velocity or acceleration"):
        check(altered(certificate, {"parameters/a_max/1": "0.3999"}))
    with pytest.raises(Rejected, match="input 0 lasts no time or is beyond its bound"):
        check(altered(certificate, {"parameters/j_max/1": "0.7999"}))
    # the position is the cubic 0.4 + 0.2 s² − 0.4/3 s³: it is highest at the end, 0.4667
    high = {"parameters/workspace": [["-0.3", "0.3"], ["-1", "0.46667"], ["0", "0"]]}
    assert check(altered(certificate, high)).lower == 0
    # 0.4 + 0.4·s − s² + 0.4 s³ turns at 0.232 s, at 0.4440…: both ends are below
    bump = {"state": ["0.4", "0.4", "-2"], "inputs": [["1", "2.4"]]}
    loose = {"parameters/v_max/1": "2", "parameters/a_max/1": "2", "parameters/j_max/1": "3", "witness/uav_i/1": bump}
    bumped = altered(certificate, {**loose, "parameters/workspace": [["-1", "1"], ["-1", "0.45"], ["0", "0"]]})
    with pytest.raises(Rejected, match="closer than d_hat_min at an end"):  # so its motion was accepted
        check(bumped)
    with pytest.raises(Rejected, match="not shown to stay in the workspace"):
        check(altered(bumped, {"parameters/workspace/1/1": "0.443"}))


def test_a_witness_in_a_later_window() -> None:
    """In as-sampled a witness names its window; its motion starts with the period T_s, not with the window."""
    certificate = made("as-sampled", 3)
    later = {"witness/window": 1, "witness/uav_i/0/state/0": "-0.9", "witness/uav_j/0/state/0": "0.9"}
    assert check(altered(certificate, later)).lower == Fraction(1, 5)
    with pytest.raises(Rejected, match="closer than d_hat_min"):
        check(altered(certificate, {**later, "witness/window": 0, "dip/lower": "0", "parameters/d_hat_min": "1.99"}))
    with pytest.raises(Rejected, match="window: expected an integer from 0 to 1"):
        check(altered(certificate, {"witness/window": 2}))


def test_each_window_or_its_mirror_image_is_there() -> None:
    """In as-sampled one of two mirrored windows is enough, the middle one is needed, and no window is there twice."""
    certificate = made("as-sampled", 2)
    assert check(altered(certificate, {"windows/0": {"window": 1, "cells": [cell_of([["3/2", 1, "1"]])]}})).windows == 1
    with pytest.raises(Rejected, match="closer than upper"):  # the velocity in the middle of window 0 is not that of 1
        check(altered(certificate, {"windows/0/window": 1}))
    three = {"parameters/T_s": "3", "witness": None, "dip/lower": "0"}
    with pytest.raises(Rejected, match="windows: 1 or its mirror image is missing"):
        check(altered(certificate, three))
    windows = [{"window": m, "cells": [cell_of([[f"{2 * m + 1}/2", 1, "1"]])]} for m in (1, 2)]
    assert check(altered(certificate, {**three, "windows": windows})).windows == 2
    with pytest.raises(Rejected, match="windows: 0 or its mirror image is missing"):
        check(altered(certificate, {**three, "windows": windows[:1]}))
    with pytest.raises(Rejected, match="windows: one of them is there twice"):
        check(altered(certificate, {**three, "windows": [*windows, windows[0]]}))


@pytest.mark.parametrize(
    ("reading", "changes", "reason"),
    [
        # the claim
        ("whole-motion", {"dip/upper": "0.59"}, "window 0, cell 0 from 0, tree, a pair of motions may come closer"),
        ("whole-motion", {"dip/upper": "0.19"}, "dip"),
        ("whole-motion", {"dip/lower": "0.3"}, "witness, the UAVs are not as close at tau"),
        ("whole-motion", {"dip/lower": "0.61"}, "dip"),
        ("whole-motion", {"dip/lower": "-0.1"}, "dip"),
        ("whole-motion", {"dip/upper": "1.1"}, "dip"),
        ("whole-motion", {"dip/lower": "1.8", "dip/upper": "1.8"}, "dip"),
        # the parameters: what was right for smaller bounds is wrong for larger ones
        ("whole-motion", {"parameters/v_max/0": "0.61"}, "closer than upper"),
        ("whole-motion", {"parameters/a_max/0": "0.81"}, "closer than upper"),
        ("whole-motion", {"parameters/v_max/1": "0.1"}, "closer than upper"),
        ("initial-state", {"parameters/T_c": "1.1"}, "witness, uav_i, axis 0, the inputs do not last as long"),
        ("initial-state", {"parameters/d_hat_min": "0.99"}, "not as close at tau"),
        ("initial-state", {"parameters/d_hat_min": "1.01"}, "closer than d_hat_min at an end"),
        ("whole-motion", {"reading": "initial-state"}, "a multiplier is at a time when nothing is bounded"),
        ("as-sampled", {"reading": "whole-motion"}, "the inputs do not last as long"),
        ("whole-motion", {"reading": "as-sampled"}, "it has not one input that lasts T_s"),
        ("as-sampled", {"parameters/T_b": "2/3"}, "a multiplier is at a time when nothing is bounded"),
        ("as-sampled", {"parameters/T_b": "3/4"}, "T_s is not a multiple of T_b"),
        ("as-sampled", {"parameters/T_s": "2.5"}, "T_s is not a multiple of T_c"),
        ("as-sampled", {"parameters/T_b": "1/1000000"}, "T_s is absurdly long"),
        # the witness
        ("whole-motion", {"witness/uav_i/1/state/0": "0.39"}, "closer than d_hat_min at an end"),
        ("whole-motion", {"witness/uav_i/0/state/0": "-0.29"}, "closer than d_hat_min at an end"),
        ("whole-motion", {"witness/uav_j/0/state/1": "-0.61"}, "uav_j, axis 0, velocity or acceleration"),
        ("whole-motion", {"witness/uav_i/1/state/1": "0.01"}, "uav_i, axis 1, velocity or acceleration"),
        ("whole-motion", {"witness/uav_i/0/inputs/0/1": "0.81"}, "uav_i, axis 0, input 0"),
        ("whole-motion", {"witness/uav_i/0/inputs/0/1": "0.8"}, "velocity or acceleration"),
        ("initial-state", {"witness/uav_i/0/inputs/0/1": "0.41"}, "uav_i, axis 0, input 0"),
        ("whole-motion", {"witness/uav_i/0/inputs": [["2", "0"], ["-1", "0"]]}, "input 1 lasts no time"),
        ("whole-motion", {"witness/uav_i/0/inputs": [["0.5", "0"]]}, "the inputs do not last as long"),
        ("whole-motion", {"witness/uav_i/0/inputs": []}, "the inputs do not last as long"),
        ("as-sampled", {"witness/uav_i/0/inputs": [["1", "0"], ["1", "0"]]}, "it has not one input"),
        ("as-sampled", {"witness/uav_i/0/inputs/0/1": "0.4"}, "velocity or acceleration"),
        ("whole-motion", {"witness/tau": "0.4"}, "not as close at tau"),
        ("whole-motion", {"witness/tau": "1.5"}, "tau is not in the window"),
        ("whole-motion", {"witness/tau": "-0.5"}, "tau is not in the window"),
        ("whole-motion", {"witness/window": 1}, "window: expected an integer from 0 to 0"),
        ("whole-motion", {"witness": None}, "witness, there is none"),
        # the windows
        ("whole-motion", {"windows": None}, "windows: there are none"),
        ("whole-motion", {"windows": []}, "windows: 0 or its mirror image is missing"),
        ("whole-motion", {"windows/0/window": 1}, "window: expected an integer from 0 to 0"),
        ("whole-motion", {"windows/0/cells": []}, "do not reach the window's end"),
        ("initial-state", {f"{CELL}/from": "0.1"}, "does not start where"),
        ("initial-state", {f"{CELL}/to": "0.9"}, "closer than upper"),
        ("initial-state", {f"{CELL}/to": "1.1"}, "after the window"),
        ("initial-state", {"windows/0/cells": [cell_of([], "0", "0")]}, "ends before it starts"),
        # the proofs
        ("whole-motion", {f"{CELL}/edges/0/0/proofs/0": []}, "closer than upper"),
        ("whole-motion", {f"{CELL}/edges/0/0/proofs/1/0/2": "1.01"}, "closer than upper"),
        ("whole-motion", {f"{CELL}/edges/0/0/proofs/1/0/0": "0.51"}, "closer than upper"),
        ("whole-motion", {f"{CELL}/edges/0/0/proofs/1/0/0": "1.01"}, "list 0 of edges, edge 0, a multiplier is at"),
        ("whole-motion", {f"{CELL}/edges/0/0/proofs/1/0/0": "-0.01"}, "a multiplier is at"),
        ("whole-motion", {f"{CELL}/edges/0/0/proofs/1/0/1": 2}, "1: expected an integer from 1 to 1"),
        ("whole-motion", {f"{CELL}/edges/0/0/proofs/1/0/1": 0}, "1: expected an integer from 1 to 1"),
        ("as-sampled", {f"{CELL}/edges/0/0/proofs/1/0/0": "1/4"}, "a multiplier is at"),
        ("as-sampled", {f"{CELL}/edges/0/0/proofs/1/0/0": "5/2"}, "a multiplier is at"),
        ("initial-state", {f"{CELL}/edges/0/0/proofs/1": [["1", 1, "0.1"]]}, "a multiplier is at"),
        ("whole-motion", {f"{CELL}/edges/0/0/direction": ["2", "0"]}, "is not among the directions"),
        ("whole-motion", {f"{CELL}/edges/0/1/direction": ["0", "-1"]}, "is not among the directions"),
        ("whole-motion", {f"{CELL}/edges/0/1/direction": ["0", "0"]}, "the direction is"),
        ("whole-motion", {f"{CELL}/tree/t": "0.1"}, "a weight is not in"),
        ("whole-motion", {f"{CELL}/tree/t": "-0.1"}, "a weight is not in"),
    ],
)
def test_wrong_claims_are_rejected(reading: str, changes: dict[str, Any], reason: str) -> None:
    """With the digest made right again, each change that makes the claim false or its proof wrong is rejected."""
    with pytest.raises(Rejected, match=reason):
        check(altered(made(reading, 2), changes))


def test_cells_leave_no_gap() -> None:
    """Of two cells neither may be missing, and they must meet."""
    cells = [cell_of([], "0", "1/2"), cell_of([], "1/2", "1")]
    certificate = altered(made("initial-state", 2), {"windows/0/cells": cells, "dip/upper": "0.9"})
    assert check(certificate).cells == 2
    with pytest.raises(Rejected, match="do not reach the window's end"):
        check(altered(certificate, {"windows/0/cells": cells[:1]}))
    with pytest.raises(Rejected, match="cell 0 from 0, it does not start where"):
        check(altered(certificate, {"windows/0/cells": cells[1:]}))
    with pytest.raises(Rejected, match="cell 1 from 1/2, it does not start where"):
        check(altered(certificate, {"windows/0/cells/1/from": "0.51"}))
    with pytest.raises(Rejected, match="cell 1 from 1/2, it does not start where"):
        check(altered(certificate, {"windows/0/cells/1/from": "0.49"}))


def test_the_digest_is_checked() -> None:
    """Whatever changes after the digest was made is noticed, even if the claim would still be right."""
    certificate = made("whole-motion", 2)
    for change in ({"dip": {"lower": "0.1", "upper": "0.6"}}, {"digest": "0" * 64}, {"digest": None}, {"digest": 1}):
        with pytest.raises(Rejected, match="digest"):
            check({**certificate, **change})


NONSENSE: list[object] = [None, 1, "certificate", [], {}, {1: 2}]
DEEP_TREE: Json = {"t": "0"}
for _ in range(201):
    DEEP_TREE = {"axis": 0, "normal": ["1", "0"], "at": "2", "below": DEEP_TREE, "above": None}


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("schema", "swarmproof.margin-certificate/2"),
        ("schema", None),
        ("extra", 1),
        ("reading", "whole"),
        ("reading", ["whole-motion"]),
        ("parameters", None),
        ("parameters", []),
        ("parameters/extra", "1"),
        ("parameters/T_c", 1),
        ("parameters/T_c", 1.0),
        ("parameters/T_c", "0"),
        ("parameters/T_s", "-1"),
        ("parameters/T_b", "1/0"),
        ("parameters/T_b", "1e-1"),
        ("parameters/T_b", "0x1"),
        ("parameters/T_b", ""),
        ("parameters/T_b", " 1"),
        ("parameters/T_b", "1/2/3"),
        ("parameters/T_b", "0.5/2"),
        ("parameters/T_b", "1_0"),
        ("parameters/T_b", "٣"),
        ("parameters/d_hat_min", "nan"),
        ("parameters/d_hat_min", "inf"),
        ("parameters/d_hat_min", float("nan")),
        ("parameters/d_hat_min", "1" * 5000),
        ("parameters/d_min", "-1"),
        ("parameters/tracking_error", None),
        ("parameters/v_max", ["0.6", "0"]),
        ("parameters/v_max", "0.6"),
        ("parameters/v_max/0", "-0.6"),
        ("parameters/order", 4),
        ("parameters/order", "2"),
        ("parameters/order", 2.0),
        ("parameters/order", True),
        ("parameters/theta_inverse", [["1", "0", "0"], ["0", "1", "0"]]),
        ("parameters/theta_inverse/0", ["1", "0.1", "0"]),
        ("parameters/theta_inverse/0", ["-1", "0", "0"]),
        ("parameters/theta_inverse/1", ["0", "0", "0"]),
        ("parameters/theta_inverse", [["1", "2", "0"], ["2", "1", "0"], ["0", "0", "1"]]),
        ("parameters/workspace", []),
        ("parameters/workspace", [["0", "1"]] * 2),
        ("parameters/workspace", [["1", "0"]] * 3),
        ("parameters/workspace", [["0", "1", "2"]] * 3),
        ("dip", None),
        ("dip/lower", 0.2),
        ("dip/middle", "0.4"),
        ("witness", []),
        ("witness", {}),
        ("witness/window", True),
        ("witness/window", -1),
        ("witness/tau", None),
        ("witness/uav_i", {}),
        ("witness/uav_i/2", None),
        ("witness/uav_i/0/state", ["0", "0", "0"]),
        ("witness/uav_i/0/state", ["0", None]),
        ("witness/uav_i/0/inputs", None),
        ("witness/uav_i/0/inputs/0", ["1"]),
        ("witness/uav_i/0/inputs/0", "10"),
        ("windows", {}),
        ("windows/0", 0),
        ("windows/0/window", None),
        ("windows/0/window", 10**300),
        ("windows/0/cells", None),
        (CELL, None),
        (f"{CELL}/from", None),
        (f"{CELL}/to", []),
        (f"{CELL}/edges", None),
        (f"{CELL}/edges", []),
        (f"{CELL}/edges/0", None),
        (f"{CELL}/edges/0", []),
        (f"{CELL}/edges/0/0", []),
        (f"{CELL}/edges/0/0/direction", ["1"]),
        (f"{CELL}/edges/0/0/direction", [1, 0]),
        (f"{CELL}/edges/0/0/proofs", [[]]),
        (f"{CELL}/edges/0/0/proofs/1", None),
        (f"{CELL}/edges/0/0/proofs/1/0", ["1/2", 1]),
        (f"{CELL}/edges/0/0/proofs/1/0/1", "1"),
        (f"{CELL}/edges/0/0/proofs/1/0/1", True),
        (f"{CELL}/edges/0/0/proofs/1/0/2", 1),
        (f"{CELL}/edges/0/0/proofs/1/0/2", {}),
        (f"{CELL}/axes", [0, 0]),
        (f"{CELL}/axes", [0, 0, 1]),
        (f"{CELL}/axes", [0, 0, -1]),
        (f"{CELL}/axes", ["0", "0", "0"]),
        (f"{CELL}/tree", None),
        (f"{CELL}/tree", {}),
        (f"{CELL}/tree", []),
        (f"{CELL}/tree/t", None),
        (f"{CELL}/tree/u", "0"),
        (f"{CELL}/tree", {"axis": 3, "normal": ["1", "0"], "at": "0", "below": {"t": "0"}, "above": {"t": "0"}}),
        (f"{CELL}/tree", {"axis": 0, "normal": ["0", "0"], "at": "0", "below": {"t": "0"}, "above": {"t": "0"}}),
        (f"{CELL}/tree", {"axis": 0, "normal": ["1", "0"], "at": "x", "below": {"t": "0"}, "above": {"t": "0"}}),
        (f"{CELL}/tree", DEEP_TREE),
    ],
)
def test_malformed_content_is_rejected(path: str, value: object) -> None:
    """Wrong types, shapes and numbers are rejected with a sentence, and raise nothing else."""
    with pytest.raises(Rejected, match=r"\w+"):
        check(altered(made("whole-motion", 2), {path: value}))


@pytest.mark.parametrize("key", sorted(made("whole-motion", 2)))
def test_every_key_is_needed(key: str) -> None:
    """A certificate that lacks a key is rejected."""
    certificate = made("whole-motion", 2)
    del certificate[key]
    with pytest.raises(Rejected, match="expected an object with these keys"):
        check(certificate if key == "digest" else signed(certificate))


def test_what_is_no_certificate_is_rejected() -> None:
    """Something else than an object, and objects that no JSON text decodes to, are rejected."""
    certificate = made("whole-motion", 2)
    for nonsense in NONSENSE:
        with pytest.raises(Rejected, match="expected an object"):
            check(nonsense)
    deep: list[Any] = []
    for _ in range(100_000):
        deep = [deep]
    circle: Json = {}
    circle["circle"] = circle
    for unwritable in (deep, circle, {1: 2, "1": 3}, {1, 2}, Fraction(1, 2), 10**5000):
        with pytest.raises(Rejected, match="cannot be written as JSON"):
            check({**certificate, "windows": unwritable})


@pytest.mark.parametrize("text", ["", "{", "nonsense", b"\xff\xfe\xfa", "[" * 100_000, "1" * 5000, '{"a": 1} 2'])
def test_what_is_no_json_is_rejected(text: str | bytes) -> None:
    """Text that is not JSON, or not text, is rejected by `read`."""
    with pytest.raises(Rejected, match="not JSON that can be read"):
        read(text)


NUMBERS = st.fractions(min_value=-3, max_value=3, max_denominator=20).map(str)
JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=5),
    NUMBERS,
    st.recursive(NUMBERS | st.integers(0, 2), lambda inner: st.lists(inner, max_size=3), max_leaves=5),
    st.dictionaries(st.sampled_from(["t", "axis", "state", "window"]), NUMBERS, max_size=2),
)


@SETTINGS
@given(data=st.data(), case=st.sampled_from(sorted(CASES)), junk=JUNK)
def test_a_mutated_certificate_is_rejected_or_right(data: st.DataObject, case: tuple[str, int], junk: object) -> None:
    """With anything in place of any leaf, the check rejects, or verifies what is claimed and is above the dip."""
    certificate = made(*case)
    place = data.draw(st.sampled_from(places(certificate)))
    mutated = altered(certificate, {place: junk})
    try:
        verified = check(mutated)
    except Rejected:
        return
    assert verified.lower == Fraction(mutated["dip"]["lower"])
    assert verified.upper == Fraction(mutated["dip"]["upper"])
    if all(mutated[key] == certificate[key] for key in ("parameters", "reading")):
        assert verified.upper >= Fraction(LOWER)


@SETTINGS
@given(data=st.data(), case=st.sampled_from(sorted(CASES)))
def test_no_multipliers_prove_what_is_false(data: st.DataObject, case: tuple[str, int]) -> None:
    """Whatever the multipliers, the edges and the weights: an upper bound below a dip that exists is never verified."""
    reading, order = case
    times = {"initial-state": ["0"], "whole-motion": ["0", "1/3", "1/2", "1"], "as-sampled": ["0", "1/2", "1", "2"]}
    numbers = st.sampled_from(["-1", "-0.8", "-1/3", "-0.1", "0", "0.05", "1/4", "0.5", "1", "1.5"])
    degree = st.integers(1, order - 1)
    multiplier = st.builds(lambda *one: list(one), st.sampled_from(times[reading]), degree, numbers)
    breakpoint_ = st.builds(lambda time: [time, 1, "0"], numbers)
    density = st.builds(
        lambda d, first, last: ["0", "1/2", d, first, first if d == 1 else last], degree, numbers, numbers
    )
    usable = [multiplier, breakpoint_, *([density] if reading == "whole-motion" else [])]
    proofs = st.lists(st.lists(st.one_of(usable), max_size=3), min_size=2, max_size=2)
    ways = [["1", "0"], ["0", "1"], [data.draw(numbers), "1"]]
    cells = [cell_of([], "0", "1/2"), cell_of([], "1/2", "1")]
    for cell, sign in zip(cells, ("", "-"), strict=True):
        leaves = st.builds(lambda t, sign=sign: {"t": sign + t}, st.sampled_from(["0", "0.1", "1/4", "1/2"]))
        cell["edges"] = [[{"direction": way, "proofs": data.draw(proofs)} for way in ways]]
        cut = {"axis": 0, "normal": data.draw(st.sampled_from(ways)), "at": data.draw(numbers)}
        cell["tree"] = {**cut, "below": data.draw(leaves), "above": data.draw(leaves)}
    claim = {"dip": {"lower": "0", "upper": "0.199"}, "witness": None, "windows/0/cells": cells}
    with pytest.raises(Rejected, match="closer than upper"):
        check(altered(made(*case), claim))
