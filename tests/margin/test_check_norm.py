"""The checker of margin certificates with bounds of the norm: hand-made ones, altered ones, random motions."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.margin.hand_made import CASES, CELL, LOWER, Json, altered, cell_of, edges_of, made, places

from swarmproof.margin.check import Rejected, Verified, check
from swarmproof.margin.check_numbers import root_above
from swarmproof.margin.check_planes import Polygon, clip, largest

#: The same examples every time, and no clock.
SETTINGS = settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
EXTENDED = "swarmproof.margin-certificate/2"
CLOSER = "closer than upper"

# The cases of `hand_made`, with balls of the same size in place of the motion along x. So ‖δ‖ ≤ c is 1.2 or 1.6 and
# ‖g‖ ≤ e, by the same proofs, and what is left is again √(1 − c²/4) − e. With λ = 1/4 and 1/θ for the two ball edges
# the forms vanish, and (**) is c²/4 + e²/θ ≤ 1 − ρ²/(1 − θ). For θ = e/(e + ρ) this is (e + ρ)² ≤ 1 − c²/4: nothing
# is lost. By reading and order: θ; the root is 0.6, except for the fifth.
SHARES = {
    ("initial-state", 2): "1/6",
    ("initial-state", 3): "1/3",
    ("whole-motion", 2): "1/3",
    ("whole-motion", 3): "1/6",
    ("as-sampled", 2): "1/8",
    ("as-sampled", 3): "1/6",
}
IDENTITY = [["1", "0", "0"], ["0", "1", "0"], ["0", "0", "1"]]
COUPLED = [["1", "0.1", "0"], ["0.1", "1", "0"], ["0", "0", "1"]]


def _more(number: str, by: str) -> str:
    return str(Fraction(number) + Fraction(by))


def _normed(reading: str, order: int) -> Json:
    """Return such a certificate: the box around each ball is its own, so that it bounds nothing more."""
    a_max, j_max, multipliers, _ = CASES[reading, order]
    share = SHARES[reading, order]
    leaf = {"t": "0", "share": share, "weights": ["1/4", str(1 / Fraction(share))]}
    certificate = made(reading, order)
    certificate["parameters"] |= {"v_norm": "0.6", "a_norm": a_max, "j_norm": j_max}
    boxes = {f"parameters/{key}": [size] * 3 for key, size in (("v_max", "0.6"), ("a_max", a_max), ("j_max", j_max))}
    cell = {**cell_of(multipliers), "ball": edges_of(multipliers), "tree": leaf}
    separate = json.loads(json.dumps([cell]))  # no list is there twice, so that one can be altered alone
    return altered(certificate, {"schema": EXTENDED, **boxes, "windows/0/cells": separate})


every_case = pytest.mark.parametrize(("reading", "order"), CASES)


@every_case
def test_hand_made_certificates_are_accepted_and_sharp(reading: str, order: int) -> None:
    """In each reading and order, what was worked out by hand is verified, and a millionth less is not."""
    certificate, upper = _normed(reading, order), CASES[reading, order][3]
    assert check(certificate) == Verified(Fraction(LOWER), Fraction(upper), leaves=1, cells=1, windows=1)
    with pytest.raises(Rejected, match=CLOSER):
        check(altered(certificate, {"dip/upper": _more(upper, "-0.000001")}))
    with pytest.raises(Rejected, match="not as close at tau"):
        check(altered(certificate, {"dip/lower": _more(LOWER, "0.000001")}))


@every_case
def test_the_box_around_the_ball_proves_less(reading: str, order: int) -> None:
    """A leaf without a share counts all corners of the box, which are √3 times as far away: it proves no such bound."""
    certificate = _normed(reading, order)
    with pytest.raises(Rejected, match=CLOSER):
        check(altered(certificate, {f"{CELL}/tree": {"t": "0"}}))
    # δ = 1.2 or 1.6 along three axes: 3·1.44/4 > 1, so nothing is left
    with pytest.raises(Rejected, match=CLOSER):
        check(altered(certificate, {f"{CELL}/tree": {"t": "0"}, "dip/upper": "0.999"}))


@every_case
def test_ball_edges_prove_nothing_without_bounds_of_the_norm(reading: str, order: int) -> None:
    """If one of the norms is dropped, balls are as large as the boxes' diagonals, and the bound is not proved."""
    certificate, size = (
        _normed(reading, order),
        {"a_norm": CASES[reading, order][0], "j_norm": CASES[reading, order][1]},
    )
    for key in ("v_norm", "a_norm", "j_norm"):
        if size.get(key) == "0":  # a box of size 0 is a ball
            continue
        with pytest.raises(Rejected, match=CLOSER):
            check(altered(certificate, {f"parameters/{key}": None}))
        larger = _more(certificate["parameters"][key], "0.00001")
        with pytest.raises(Rejected, match=CLOSER):  # a larger ball has a larger box, too
            check(altered(certificate, {f"parameters/{key}": larger, f"parameters/{key[0]}_max": ["9"] * 3}))


@every_case
def test_the_polygons_count_without_ball_edges(reading: str, order: int) -> None:
    """With motion along x only, the box's corner is where (**) is largest: the same bound, without any ball edge."""
    certificate, upper = made(reading, order), CASES[reading, order][3]
    leaf = {"t": "0", "share": SHARES[reading, order], "weights": []}
    certificate["windows"][0]["cells"][0] |= {"ball": [], "tree": leaf}
    certificate = altered(certificate, {"schema": EXTENDED, "parameters/v_norm": "9"})
    assert check(certificate).upper == Fraction(upper)
    with pytest.raises(Rejected, match=CLOSER):
        check(altered(certificate, {"dip/upper": _more(upper, "-0.000001")}))


def test_a_weight_may_differ_from_the_time() -> None:
    """With t = 0.1 the point of the chord moves by up to 0.16, as in the test of this for boxes."""
    # ‖g‖ ≤ 0.125 in the first half of the window, so ρ = 0.6 − 0.285 and θ = 0.285/0.6. With s = 0.16/0.125,
    # (g + tδ)² ≤ (1 + s)g² + (1 + 1/s)t²δ², which is sharp for parallel vectors of full length: these are the weights.
    leaf = {"t": "0.1", "share": "19/40", "weights": ["0.2875", "4.8"]}
    cells = [{**cell_of([], *ends), "ball": edges_of([])} for ends in (("0", "1/2"), ("1/2", "1"))]
    cells[0]["tree"], cells[1]["tree"] = leaf, {"t": "0", "share": "1/6", "weights": ["1/4", "6"]}
    certificate = altered(_normed("initial-state", 2), {"windows/0/cells": cells, "dip/upper": "0.685"})
    assert check(certificate).leaves == 2
    for change in (
        {"dip/upper": "0.684999"},
        {f"{CELL}/tree/t": "0.1001"},
        {f"{CELL}/tree/weights/0": "0.287"},
        {f"{CELL}/tree/weights/1": "4.79"},
    ):
        with pytest.raises(Rejected, match=CLOSER):
            check(altered(certificate, change))
    for t in ("-0.01", "0.51"):
        with pytest.raises(Rejected, match="a weight is not in"):
            check(altered(certificate, {f"{CELL}/tree/t": t}))


def test_a_diagonal_theta_scales_each_axis() -> None:
    """The axis that Θ⁻¹ stretches most decides; of the others less is left than the ball edges take away."""
    stretched = {"parameters/theta_inverse": [["2", "0", "0"], ["0", "1", "0"], ["0", "0", "1/2"]]}
    certificate = altered(_normed("initial-state", 2), {**stretched, "parameters/d_hat_min": "2"})
    certificate = altered(certificate, {f"{CELL}/tree/weights": ["1", "24"], "witness": None, "dip/lower": "0"})
    assert check(altered(certificate, {"dip/upper": "1"})).upper == 1
    with pytest.raises(Rejected, match=CLOSER):
        check(altered(certificate, {"dip/upper": "0.999999"}))
    for axis in ("1/1", "2/2"):
        with pytest.raises(Rejected, match=CLOSER):
            check(altered(certificate, {"dip/upper": "1", f"parameters/theta_inverse/{axis}": "2.01"}))


def test_a_part_has_its_own_share_and_weights() -> None:
    """A cut that keeps the origin out makes the largest value of a form negative, and this counts."""
    # above δ_x = 1 with λ = 5/16: along x at most −1/16; 0.8 − 1/16 + 0.06 = 0.7975 ≤ 1 − ρ²·6/5 up to ρ = 0.41079…
    below, above = ({"t": "0", "share": "1/6", "weights": [weight, "6"]} for weight in ("1/4", "5/16"))
    cut = {"axis": 0, "normal": ["1", "0"], "at": "1", "below": below, "above": above}
    certificate = altered(_normed("initial-state", 2), {f"{CELL}/tree": cut, "dip/upper": "0.5893"})
    assert check(certificate).leaves == 2
    with pytest.raises(Rejected, match="tree, above, a pair of motions may come closer"):
        check(altered(certificate, {"dip/upper": "0.5892"}))
    with pytest.raises(Rejected, match="tree, above, a pair of motions may come closer"):
        check(altered(certificate, {f"{CELL}/tree/at": "0.99"}))
    mixed = altered(certificate, {f"{CELL}/tree/below": {"t": "0"}})  # the box around the ball may serve elsewhere
    with pytest.raises(Rejected, match="tree, below, a pair of motions may come closer"):
        check(mixed)
    assert check(altered(mixed, {"dip/upper": "1", "parameters/v_norm": "0.1", "witness": None, "dip/lower": "0"}))


def test_a_share_of_one_is_for_a_distance_of_zero() -> None:
    """With upper = d_hat_min, θ = 1 asks for c²/4 + e² ≤ d² only, which θ < 1 misses."""
    leaf = {"t": "0", "share": "1", "weights": ["1/4", "1"]}
    certificate = altered(_normed("initial-state", 2), {f"{CELL}/tree": leaf, "dip/upper": "1"})
    assert check(certificate).upper == 1
    small = altered(certificate, {"witness": None, "dip": {"lower": "0", "upper": "0.81"}})
    small = altered(small, {"parameters/d_hat_min": "0.81"})  # 0.64 + 0.01 ≤ 0.6561, but 0.64 + 0.01/0.6 is more
    assert check(small).upper == Fraction("0.81")
    with pytest.raises(Rejected, match=CLOSER):
        check(altered(small, {f"{CELL}/tree/share": "0.6"}))
    with pytest.raises(Rejected, match="the share is not in"):
        check(altered(certificate, {"dip/upper": "0.999"}))


def test_ball_edges_may_be_there_for_nothing() -> None:
    """If Θ⁻¹ couples axes, leaves without a share are still right, beside ball edges, which are checked anyway."""
    certificate = made("initial-state", 2)
    certificate["windows"][0]["cells"][0]["ball"] = edges_of([])
    changes = {"schema": EXTENDED, "parameters/v_norm": "0.6", "parameters/theta_inverse": COUPLED}
    certificate = altered(certificate, {**changes, "witness": None, "dip": {"lower": "0", "upper": "0.506"}})
    assert check(certificate).leaves == 1
    with pytest.raises(Rejected, match="ball, edge 0, a multiplier is at a time when nothing is bounded"):
        check(altered(certificate, {f"{CELL}/ball/0/proofs/0": [["1", 1, "1"]]}))


# ---- aircraft, head on

#: By hand: a chord of at most 2·150·50 = 15000 m between points 9260 m from the origin has its middle at
#: √(9260² − 7500²) = 5431.16930… m; a dip of 3828.8306… m.
HEIGHT = Fraction("5431.169304")


def _straight(velocity: list[str], sign: int) -> list[Json]:
    """Return an aircraft that flies straight on for 50 s, at half of HEIGHT, and is above the origin in the middle."""
    speeds = [sign * Fraction(v) for v in velocity]
    places = [-25 * speeds[0], -25 * speeds[1], -25 * speeds[2] + sign * HEIGHT / 2]
    return [{"state": [str(x), str(v)], "inputs": [["50", "0"]]} for x, v in zip(places, speeds, strict=True)]


def _aircraft(velocity: list[str], lower: str, upper: str) -> Json:
    """Return a certificate for aircraft with |v| ≤ 150 m/s, beside a box of the same size, that do not accelerate."""
    ball = edges_of([])  # without multipliers, δ ≤ 50·300 and g ≤ 0
    leaf = {"t": "0", "share": "1/1000000000000", "weights": ["1/4", "0"]}
    changes = {
        "schema": EXTENDED,
        "parameters/T_c": "50",
        "parameters/T_s": "50",
        "parameters/T_b": "50",
        "parameters/d_hat_min": "9260",
        "parameters/v_max": ["150", "150", "150"],
        "parameters/v_norm": "150",
        "parameters/a_max": ["0", "0", "0"],
        "dip": {"lower": lower, "upper": upper},
        "witness": {"window": 0, "tau": "25", "uav_i": _straight(velocity, 1), "uav_j": _straight(velocity, -1)},
        "windows/0/cells": [{**cell_of([], "0", "50"), "ball": ball, "tree": leaf}],
    }
    return altered(made("whole-motion", 2), changes)


def test_the_dip_of_aircraft_is_known_by_hand() -> None:
    """With |v| ≤ 150 m/s the dip is 3828.8306… m; the box alone is no bound at all of it."""
    ahead = ["150", "0", "0"]
    certificate = _aircraft(ahead, "3828.830695", "3828.830698")
    assert check(certificate) == Verified(Fraction("3828.830695"), Fraction("3828.830698"), 1, 1, 1)
    with pytest.raises(Rejected, match=CLOSER):
        check(_aircraft(ahead, "0", "3828.830696"))
    with pytest.raises(Rejected, match="not as close at tau"):
        check(_aircraft(ahead, "3828.830697", "3828.830698"))
    box = altered(certificate, {f"{CELL}/tree": {"t": "0"}})
    with pytest.raises(Rejected, match=CLOSER):
        check(box)
    with pytest.raises(Rejected, match=CLOSER):
        check(altered(box, {"dip/upper": "9259.9"}))


@pytest.mark.parametrize(
    ("velocity", "kept"),
    [
        (["106.066", "106.066", "0"], True),  # 149.99997…
        (["90", "120", "0"], True),  # 150
        (["-50", "100", "100"], True),  # 150
        (["106.0661", "106.0661", "0"], False),  # 150.0001…
        (["150", "0.001", "0"], False),
        (["150", "150", "0"], False),  # the box's diagonal
    ],
)
def test_the_witness_keeps_the_norm(velocity: list[str], kept: bool) -> None:
    """A witness faster than |v| ≤ 150 m/s in its direction is rejected, though each axis keeps its bound."""
    certificate = altered(
        _aircraft(velocity, "0", "9260"), {"parameters/d_hat_min": str(HEIGHT), "dip/upper": str(HEIGHT)}
    )
    certificate = altered(certificate, {"windows": None})
    if kept:
        assert check(certificate).lower == 0
    else:
        with pytest.raises(Rejected, match="witness, uav_i, it is not shown to keep v_norm from 0 to 50"):
            check(certificate)
        del certificate["parameters"]["v_norm"]
        certificate["parameters"]["delay"] = "0.5"
        assert check(altered(certificate, {})).lower == 0
        uav_j = altered(_aircraft(["150", "0", "0"], "0", "9260"), {"witness/uav_j": _straight(velocity, -1)})
        with pytest.raises(Rejected, match="witness, uav_j, it is not shown to keep v_norm"):
            check(uav_j)


# ---- when a witness keeps a norm


def _turning(reading: str, order: int, axes: list[tuple[list[str], list[list[str]]]], **norms: str) -> Json:
    """Return a certificate whose uav_i flies so, under these norms and boxes too large to matter; uav_j hovers."""
    certificate = made(reading, order)
    certificate["parameters"] |= norms
    boxes = {f"parameters/{key}": ["99"] * 3 for key in ("v_max", "a_max", "j_max")}
    uav_i = [{"state": state, "inputs": inputs} for state, inputs in axes]
    still = [[certificate["parameters"]["T_s" if reading == "as-sampled" else "T_c"], "0"]]
    uav_j = [{"state": [place, *["0"] * (order - 1)], "inputs": still} for place in ("90", "0", "0")]
    witness = {"window": 0, "tau": "0", "uav_i": uav_i, "uav_j": uav_j}
    trivial = {"schema": EXTENDED, "windows": None, "dip": {"lower": "0", "upper": "80"}}
    return altered(certificate, {**boxes, **trivial, "witness": witness, "parameters/d_hat_min": "80"})


STILL2: tuple[list[str], list[list[str]]] = (["0", "0"], [["1", "0"]])


def _is_kept(certificate: Json, name: str, least: str) -> None:
    """Assert that the witness is accepted with the norm `least`, and with nothing below."""
    path = f"parameters/{name}"
    # no lower bound: the distance at tau = 0 is about 90, which is above d_hat_min
    with pytest.raises(Rejected, match="not as close at tau"):
        check(altered(certificate, {path: least}))
    with pytest.raises(Rejected, match=rf"witness, uav_i, it is not shown to keep {name} from"):
        check(altered(certificate, {path: _more(least, "-0.000001")}))


def test_pieces_of_the_axes_are_merged() -> None:
    """In whole-motion, inputs that change at different times make a speed that is largest at a change of either."""
    # along x: 0 … 3 m/s until 1/3 s, down to 1 m/s at 5/9 s, and on; along y 4 m/s until 1/3 s, then to 0
    x = (["0", "0"], [["1/3", "9"], ["2/9", "-9"], ["4/9", "0"]])
    y = (["0", "4"], [["1/3", "0"], ["2/3", "-6"]])
    _is_kept(_turning("whole-motion", 2, [x, y, STILL2], v_norm="5"), "v_norm", "5")
    # along y the speed is 12·s until 1/2 s; along x 5 until 1/2 s, where it begins to fall
    x = (["0", "5"], [["1/2", "0"], ["1/2", "-1"]])
    y = (["0", "0"], [["1/4", "36"], ["1/4", "12"], ["1/2", "-6"]])
    _is_kept(_turning("whole-motion", 2, [y, x, STILL2], v_norm="13"), "v_norm", "13")


@pytest.mark.parametrize("reading", ["initial-state", "whole-motion"])
def test_inputs_keep_the_norm_always(reading: str) -> None:
    """Inputs of two axes that overlap only for a while count together, in every reading."""
    x, y = (["0", "0"], [["1/2", "0.3"], ["1/2", "0"]]), (["0", "0"], [["1/3", "0"], ["2/3", "-0.4"]])
    _is_kept(_turning(reading, 2, [x, y, STILL2], a_norm="0.5"), "a_norm", "0.5")
    x, y = (["0", "0", "0"], x[1]), (["0", "0", "0"], y[1])
    certificate = _turning(reading, 3, [x, y, (["0", "0", "0"], [["1", "0"]])], j_norm="0.5")
    _is_kept(certificate, "j_norm", "0.5")


def test_inputs_keep_the_norm_when_sampled() -> None:
    """In as-sampled the one input of each axis counts, too."""
    axes = [(["0", "0"], [["2", value]]) for value in ("1", "-2", "2")]
    _is_kept(_turning("as-sampled", 2, axes, a_norm="3"), "a_norm", "3")


def test_a_state_keeps_the_norm_when_its_reading_says() -> None:
    """The same motion keeps one bound at the start, another one at sampling instants, and a third all the time."""
    # along x the velocity is 4 + 3·s − 1.5·s² (highest at 1 s, 5.5), along y 3, so |v| is 5, and 5 again after 2 s
    x, y, z = ["0", "4", "3"], ["0", "3", "0"], ["0", "0", "0"]
    for reading, period, step, norm in (
        ("initial-state", "2", "1/2", "5"),
        ("as-sampled", "2", "2", "5"),
        ("as-sampled", "2", "2/3", str(root_above(9 + Fraction(16, 3) ** 2))),
        ("whole-motion", "2", "1/2", str(root_above(9 + Fraction(11, 2) ** 2))),
    ):
        axes = [(state, [[period, jerk]]) for state, jerk in ((x, "-3"), (y, "0"), (z, "0"))]
        certificate = _turning(reading, 3, axes, v_norm=norm)
        hover = [{"state": [place, "0", "0"], "inputs": [["2", "0"]]} for place in ("90", "0", "0")]
        times = {"parameters/T_c": "2", "parameters/T_s": "2", "parameters/T_b": step, "witness/uav_j": hover}
        _is_kept(altered(certificate, times), "v_norm", norm)


def test_an_initial_state_may_grow_beyond_the_norm() -> None:
    """In initial-state only the speed at time 0 is bounded, also if the input changes later."""
    x, y = (["0", "3"], [["1/2", "8"], ["1/2", "9"]]), (["0", "4"], [["1/3", "7"], ["2/3", "0"]])
    _is_kept(_turning("initial-state", 2, [x, y, STILL2], v_norm="5"), "v_norm", "5")


def test_the_acceleration_of_order_3_keeps_its_norm() -> None:
    """In whole-motion |a| is largest at an end of a piece; initially only the first one counts."""
    axes = [([*["0"] * 2, first], [["1", jerk]]) for first, jerk in (("0", "3"), ("0", "-4"), ("0", "0"))]
    _is_kept(_turning("whole-motion", 3, axes, a_norm="5"), "a_norm", "5")
    with pytest.raises(Rejected, match="not as close at tau"):
        check(_turning("initial-state", 3, axes, a_norm="0"))
    axes[:2] = [(["0", "0", first], inputs) for first, (_, inputs) in zip(("0.3", "-0.4"), axes, strict=False)]
    _is_kept(_turning("initial-state", 3, axes, a_norm="0.5"), "a_norm", "0.5")


def test_a_motion_at_the_bound_is_accepted() -> None:
    """A speed that touches its bound at ends of pieces, or stays there, is shown to keep it, without a rest."""
    # along x: 3 − 3s²/2·… rises and falls between 0 and 3 with zero acceleration at both ends; along y 4
    axes = [
        (["0", "3", "0"], [["1/4", "-48"], ["1/2", "48"], ["1/4", "-48"]]),
        (["0", "4", "0"], [["1", "0"]]),
        (["0", "0", "0"], [["1", "0"]]),
    ]
    _is_kept(_turning("whole-motion", 3, axes, v_norm="5"), "v_norm", "5")


# ---- open sides, and what the schema is for


ROOM: list[Any] = [["-0.3", "0.3"], ["-1", "1"], ["-1", "1"]]


def test_positions_along_an_axis_with_an_open_side_are_not_bounded() -> None:
    """Multipliers of derivative 0 need both sides of an axis; a list that has some is of no use for another axis."""
    positions = [["0", 0, "-1"], ["1", 0, "1"]]
    lists = {f"{CELL}/edges": [edges_of(positions), edges_of([])], f"{CELL}/axes": [0, 1, 1], f"{CELL}/ball": []}
    changes = {"schema": EXTENDED, **lists, "parameters/workspace": [ROOM[0], [None, "1"], ["-1", None]]}
    certificate = altered(made("whole-motion", 2), {**changes, "dip/upper": "0.4"})
    # |w| ≤ 0.6, so δ ≤ 1.2; with e = 0.2 the distance left is 0.8 − 0.2
    assert check(certificate) == Verified(Fraction(1, 5), Fraction(2, 5), 1, 1, 1)
    with pytest.raises(Rejected, match=CLOSER):
        check(altered(certificate, {"parameters/workspace/0/1": "0.3001"}))
    unbounded = "list 0 of edges uses positions, which are not bounded along axis"
    for sides in ([None, "0.3"], ["-0.3", None], [None, None]):
        with pytest.raises(Rejected, match=f"{unbounded} 0"):
            check(altered(certificate, {"parameters/workspace/0": sides}))
    with pytest.raises(Rejected, match=f"{unbounded} 2"):
        check(altered(certificate, {f"{CELL}/axes": [0, 1, 0]}))
    for end in (0, 1):  # also if only one of a cell's ends needs positions
        half = altered(certificate, {f"{CELL}/edges/0/0/proofs": [[], []], "parameters/workspace/0": [None, "0.3"]})
        with pytest.raises(Rejected, match=f"{unbounded} 0"):
            check(altered(half, {f"{CELL}/edges/0/0/proofs/{end}": positions}))
    # an axis of width 0 is no excuse: it has the same numbers as an open one, and is looked at first
    flat = {"parameters/workspace": [["0", "0"], ["0", None], ["0", None]], f"{CELL}/axes": [0, 0, 1]}
    with pytest.raises(Rejected, match=f"{unbounded} 1"):
        check(altered(certificate, {**flat, "witness": None, "dip/lower": "0"}))
    nothing = [["0", 0, "0"]]
    with pytest.raises(Rejected, match=CLOSER):  # ν = 0 is allowed, and proves nothing
        check(altered(certificate, {f"{CELL}/edges/0": edges_of(nothing), "parameters/workspace/0": [None, None]}))
    with pytest.raises(Rejected, match="ball, edge 0, 1: expected an integer from 1 to 1"):
        check(altered(certificate, {f"{CELL}/ball": edges_of(positions)}))


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("reading", ["initial-state", "whole-motion", "as-sampled"])
def test_a_witness_keeps_the_sides_that_there_are(reading: str, order: int) -> None:
    """Through an open side a witness may leave, through the other one it may not."""
    trivial = {"schema": EXTENDED, "windows": None, "dip/upper": "1"}
    certificate = altered(made(reading, order), {**trivial, "parameters/workspace": [*ROOM[:2], [None, "0"]]})
    for sides in ([None, None], [None, "0.9"], ["-0.9", None]):
        assert check(altered(certificate, {"parameters/workspace/0": sides})).lower == Fraction(1, 5)
    for sides in ([None, "0.29"], ["-0.29", None]):
        with pytest.raises(Rejected, match=r"uav_., axis 0, it leaves the workspace"):
            check(altered(certificate, {"parameters/workspace/0": sides}))


def test_a_cubic_position_keeps_the_side_that_there_is() -> None:
    """In whole-motion a bump between the ends is seen on the closed side, and free on the open one."""
    # along y: 0.4 + 0.4·s − s² + 0.4 s³ turns at 0.232 s, at 0.4440…: both ends are below
    bump = {"state": ["0.4", "0.4", "-2"], "inputs": [["1", "2.4"]]}
    certificate = altered(made("whole-motion", 3), {"schema": EXTENDED, "windows": None, "dip/upper": "1"})
    loose = {"parameters/v_max/1": "2", "parameters/a_max/1": "2", "parameters/j_max/1": "3", "witness/uav_i/1": bump}
    certificate = altered(certificate, {**loose, "parameters/workspace": [ROOM[0], ["-1", None], [None, "0"]]})
    for sides in (["-1", None], [None, "0.45"]):
        with pytest.raises(Rejected, match="closer than d_hat_min at an end"):  # so its motion was accepted
            check(altered(certificate, {"parameters/workspace/1": sides}))
    with pytest.raises(Rejected, match="not shown to stay in the workspace"):
        check(altered(certificate, {"parameters/workspace/1": [None, "0.443"]}))
    dent = {"state": ["-0.4", "-0.4", "2"], "inputs": [["1", "-2.4"]]}
    with pytest.raises(Rejected, match="closer than d_hat_min at an end"):
        check(altered(certificate, {"witness/uav_i/1": dent, "parameters/workspace/1": ["-0.45", None]}))
    with pytest.raises(Rejected, match="not shown to stay in the workspace"):
        check(altered(certificate, {"witness/uav_i/1": dent, "parameters/workspace/1": ["-0.443", None]}))


def test_the_schema_is_that_of_what_is_used() -> None:
    """The keys of /2 are rejected in /1, also null ones, and /2 is for certificates that use one of them."""
    extended = _normed("whole-motion", 2)
    with pytest.raises(Rejected, match="parameters, expected an object with these keys and no others"):
        check(altered(extended, {"schema": EXTENDED.replace("/2", "/1")}))
    plain = made("whole-motion", 2)
    for key, value in (("v_norm", "9"), ("v_norm", None), ("delay", "0.1"), ("crash_theta_inverse", IDENTITY)):
        with pytest.raises(Rejected, match="parameters, expected an object with these keys and no others"):
            check(altered(plain, {f"parameters/{key}": value}))
    with pytest.raises(Rejected, match="0: expected a number"):
        check(altered(plain, {"parameters/workspace": [[None, "1"], ["-1", "1"], ["-1", "1"]]}))
    with pytest.raises(Rejected, match="from 0, expected an object with these keys"):
        check(altered(plain, {f"{CELL}/ball": []}))
    unused = altered(plain, {"schema": EXTENDED, f"{CELL}/ball": []})
    for changes in ({}, {"parameters/v_norm": None}, {"parameters/crash_theta_inverse": None}):
        with pytest.raises(Rejected, match="parameters, neither a bound of the norm nor an open side is used"):
            check(altered(unused, changes))
    for key, value in (("j_norm", "9"), ("delay", "0.1"), ("crash_theta_inverse", IDENTITY)):
        assert check(altered(unused, {f"parameters/{key}": value})).upper == Fraction(CASES["whole-motion", 2][3])
    with pytest.raises(Rejected, match="from 0, expected an object with these keys"):
        check(altered(plain, {"schema": EXTENDED, "parameters/v_norm": "9"}))
    with pytest.raises(Rejected, match="tree, expected an object with these keys and no others: t"):
        check(altered(plain, {f"{CELL}/tree": {"t": "0", "share": "1/2", "weights": []}}))


# ---- what is wrong


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        # (**)
        ({f"{CELL}/tree/weights/0": "0.24"}, CLOSER),
        ({f"{CELL}/tree/weights/0": "0.26"}, CLOSER),
        ({f"{CELL}/tree/weights/1": "2.9"}, CLOSER),
        ({f"{CELL}/tree/weights/1": "3.1"}, CLOSER),
        ({f"{CELL}/tree/weights": ["0", "0"]}, CLOSER),
        ({f"{CELL}/tree/weights/0": "-0.25"}, "tree, a weight of a ball edge is negative"),
        ({f"{CELL}/tree/weights/1": "-0.000001"}, "tree, a weight of a ball edge is negative"),
        ({f"{CELL}/tree/weights": ["1/4"]}, "weights: expected a list of length 2"),
        ({f"{CELL}/tree/weights": ["1/4", "3", "0"]}, "weights: expected a list of length 2"),
        ({f"{CELL}/tree/weights": []}, "weights: expected a list of length 2"),
        ({f"{CELL}/tree/share": "0.3"}, CLOSER),
        ({f"{CELL}/tree/share": "0.4"}, CLOSER),
        ({f"{CELL}/tree/share": "0"}, "the share is not in"),
        ({f"{CELL}/tree/share": "-1/3"}, "the share is not in"),
        ({f"{CELL}/tree/share": "1"}, "the share is not in"),
        ({f"{CELL}/tree/share": "1.1"}, "the share is not in"),
        ({f"{CELL}/tree/share": "1.1", "dip/upper": "1"}, "the share is not in"),
        ({f"{CELL}/tree/t": "0.1"}, "a weight is not in"),
        ({f"{CELL}/tree/t": "-0.1"}, "a weight is not in"),
        ({f"{CELL}/tree": {"t": "0", "share": "1/3"}}, "expected an object with these keys"),
        ({f"{CELL}/tree": {"t": "0", "weights": ["1/4", "3"]}}, "expected an object with these keys"),
        ({f"{CELL}/tree": {"share": "1/3", "weights": ["1/4", "3"]}}, "expected an object with these keys"),
        ({"parameters/theta_inverse": COUPLED, "witness": None, "dip/lower": "0"}, "a share needs a diagonal"),
        # the ball edges
        ({f"{CELL}/ball": []}, "weights: expected a list of length 0"),
        ({f"{CELL}/ball": None}, "ball, ball: expected a list"),
        ({f"{CELL}/ball/0/proofs/0": []}, CLOSER),
        ({f"{CELL}/ball/0/proofs/1/0/2": "1.01"}, CLOSER),
        ({f"{CELL}/ball/0/proofs/1/0/0": "0.51"}, CLOSER),
        ({f"{CELL}/ball/0/proofs/1/0/0": "1.01"}, "ball, edge 0, a multiplier is at a time when nothing"),
        ({f"{CELL}/ball/0/proofs/1/0/1": 0}, "ball, edge 0, 1: expected an integer from 1 to 1"),
        ({f"{CELL}/ball/0/proofs": [[]]}, "proofs: expected a list of length 2"),
        ({f"{CELL}/ball/0/direction": ["1.1", "0"]}, CLOSER),
        ({f"{CELL}/ball/0/direction": ["0.9", "0"]}, CLOSER),
        ({f"{CELL}/ball/1/direction": ["0", "0.9"]}, CLOSER),
        ({f"{CELL}/ball/1/direction": ["0", "0"]}, "ball, edge 1, the direction is"),
        ({f"{CELL}/ball/1/proofs/0": [["1/2", 1, "0.01"]]}, CLOSER),
        # the parameters
        ({"parameters/v_norm": "0.601"}, "closer than upper"),
        ({"parameters/v_norm": "0.599"}, "velocity or acceleration"),
        ({"parameters/v_norm": "-0.6"}, "a bound of the norm is negative"),
        ({"parameters/v_norm": ["0.6"] * 3}, "v_norm: expected a number"),
        ({"parameters/v_norm": 0.6}, "v_norm: expected a number"),
        ({"parameters/delay": "-1"}, "delay is negative"),
        ({"parameters/delay": None}, "delay: expected a number"),
        ({"parameters/delay": ["1"]}, "delay: expected a number"),
        ({"parameters/crash_theta_inverse": "1"}, "crash_theta_inverse: expected a list"),
        ({"parameters/crash_theta_inverse": IDENTITY[:2]}, "crash_theta_inverse: expected a list"),
        ({"parameters/crash_theta_inverse": [*IDENTITY[:2], ["0", "0", "0"]]}, "not symmetric positive definite"),
        ({"parameters/crash_theta_inverse": [*IDENTITY[:2], ["0", "1", "1"]]}, "not symmetric positive definite"),
        ({"parameters/workspace": [["1", None], ["-1", "1"]]}, "workspace: expected a list of length 3"),
        ({"parameters/workspace": [[None], ["-1", "1"], ["-1", "1"]]}, "0: expected a list of length 2"),
        ({"parameters/workspace": [[None, "x"], ["-1", "1"], ["-1", "1"]]}, "0, 1: expected a number"),
        ({"parameters/workspace": [[None, "1"], ["1", "-1"], ["-1", "1"]]}, "a low is above its high"),
        # another problem with the same proof
        ({"reading": "initial-state"}, "a multiplier is at a time when nothing is bounded"),
        ({"parameters/T_c": "1.01", "witness": None, "dip/lower": "0", f"{CELL}/to": "1.01"}, CLOSER),
        ({"parameters/d_hat_min": "0.99", "witness": None, "dip/lower": "0"}, CLOSER),
        ({f"{CELL}/to": "0.9"}, CLOSER),
        ({"windows/0/cells": []}, "do not reach the window's end"),
    ],
)
def test_wrong_claims_are_rejected(changes: dict[str, Any], reason: str) -> None:
    """With the digest made right again, each change that makes the claim false or its proof wrong is rejected."""
    boxes = {f"parameters/{key}": ["9"] * 3 for key in ("v_max", "a_max")} if "parameters/v_norm" in changes else {}
    with pytest.raises(Rejected, match=reason):
        check(altered(_normed("whole-motion", 2), {**boxes, **changes}))


# ---- properties


RATIONALS = st.fractions(min_value=-2, max_value=2, max_denominator=12)


@given(st.fractions(min_value=0, max_value=10**6, max_denominator=10**6))
@SETTINGS
def test_roots_are_rounded_up(square: Fraction) -> None:
    """The root is the least multiple of 10⁻⁹ that is not below the real one."""
    root, step = root_above(square), Fraction(1, 10**9)
    assert root**2 >= square
    assert (root / step).denominator == 1
    assert root == 0 or (root - step) ** 2 < square


@given(form=st.tuples(RATIONALS, RATIONALS, RATIONALS), lines=st.lists(st.tuples(*[RATIONALS] * 3), max_size=4))
@SETTINGS
def test_the_largest_value_of_a_form_is_the_one_of_samples(
    form: tuple[Fraction, ...], lines: list[tuple[Fraction, ...]]
) -> None:
    """No point of the polygon has a larger value; some point of its boundary comes near it."""
    polygon: Polygon = [(0, -1, 1), (2, -1, 1), (2, 1, 1), (0, 1, 1)]
    for line in lines:
        polygon = clip(polygon, *line)
    assume(polygon)
    p, r, s = form
    found = largest(form, polygon)

    def value(x: Any, y: Any) -> Any:
        return p * x * x + 2 * r * x * y + s * y * y

    corners = [(Fraction(x, w), Fraction(y, w)) for x, y, w in polygon]
    middle = tuple(sum(axis, Fraction(0)) / len(corners) for axis in zip(*corners, strict=True))
    inner = [(x + (middle[0] - x) / n, y + (middle[1] - y) / n) for x, y in corners for n in (1, 2, 3)]
    boundary = [
        (x0 + (x1 - x0) * i / 20, y0 + (y1 - y0) * i / 20)
        for (x0, y0), (x1, y1) in pairwise([*corners, corners[0]])
        for i in range(20)
    ]
    assert all(value(x, y) <= found for x, y in [*inner, *boundary])
    # neighbours are at most 1/10 apart in x and y, so a top between them is at most (|p| + 2|r| + |s|)/20² higher
    assert max(value(x, y) for x, y in boundary) >= found - Fraction(8, 20**2)


NUMBERS = st.fractions(min_value=-3, max_value=3, max_denominator=20).map(str)
JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=5),
    NUMBERS,
    st.recursive(NUMBERS | st.integers(0, 2), lambda inner: st.lists(inner, max_size=3), max_leaves=5),
    st.dictionaries(st.sampled_from(["t", "share", "weights", "ball"]), NUMBERS, max_size=3),
)


@SETTINGS
@given(data=st.data(), case=st.sampled_from(sorted(CASES)), junk=JUNK)
def test_a_mutated_certificate_is_rejected_or_right(data: st.DataObject, case: tuple[str, int], junk: object) -> None:
    """With anything in place of any leaf, the check rejects, or verifies what is claimed and is above the dip."""
    certificate = _normed(*case)
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


def _near(certificate: Json, place: str, by: Fraction) -> object:
    """Return the number at a place, a bit larger or smaller; whatever else is there as it is."""
    value: Any = certificate
    for key in place.split("/"):
        value = value[int(key) if key.isdigit() else key]
    return str(Fraction(value) + by) if isinstance(value, str) else value


@SETTINGS
@given(data=st.data(), cut=st.booleans(), extra=st.booleans())
def test_no_proof_is_right_for_what_is_false(data: st.DataObject, cut: bool, extra: bool) -> None:
    """However a proof that was sharp is altered: it does not prove a bound that straight flight refutes."""
    certificate = _aircraft(["150", "0", "0"], "0", "3828.8306")
    cell = certificate["windows"][0]["cells"][0]
    if extra:  # an edge that bounds δ + g, in which a velocity at any time may be used
        time, nu = data.draw(st.sampled_from(["0", "25", "50"])), data.draw(NUMBERS)
        cell["ball"].append({"direction": [data.draw(NUMBERS), "1"], "proofs": [[[time, 1, nu]], []]})
        cell["tree"]["weights"].append(data.draw(NUMBERS))
    if cut:
        at, way = data.draw(st.sampled_from(["-1", "0", "1", "7500", "14999", "15000", "15001"])), data.draw(NUMBERS)
        cell["tree"] = {"axis": 0, "normal": ["1", way], "at": at, "below": cell["tree"], "above": cell["tree"]}
    certificate = altered(certificate, {})
    numbers = [place for place in places(certificate["windows"], ("windows",)) if "/axes/" not in place]
    for place in data.draw(st.lists(st.sampled_from(numbers), max_size=3)):
        by = data.draw(st.sampled_from([Fraction(sign, 10**n) for sign in (-1, 1) for n in (0, 1, 3, 6, 12)]))
        certificate = altered(certificate, {place: _near(certificate, place, by)})
    with pytest.raises(Rejected):
        check(certificate)


# ---- random motions


Array = NDArray[np.float64]


def _dips(reading: str, order: int, rng: np.random.Generator) -> Array:
    """Return dips (600, windows) of random relative motions that keep the norms of a case, all as fast as they may.

    Velocities and so on are linear in the motion, so each is scaled until one of its bounds is reached.
    """
    a_max, j_max, _, _ = CASES[reading, order]
    count, last, steps = 600, 2 if reading == "as-sampled" else 1, 120
    h, limits = 1 / steps, 2 * np.array([0.6, float(a_max), float(j_max)])
    sizes = rng.uniform(0, 1, (order, count, 1)) ** 2
    state = [np.zeros((count, 3)), *(sizes[d] * rng.normal(size=(count, 3)) for d in range(order - 1))]
    bent = rng.normal(size=(count, 3)) * sizes[-1]
    turns = rng.integers(0, steps + 1, count)  # when the input is reversed
    moved, ratio = [state[0]], np.zeros(count)
    for i in range(last * steps + 1):
        u = bent if reading == "as-sampled" else np.where((i < turns)[:, None], bent, -bent)
        bound = {"initial-state": i == 0, "whole-motion": True, "as-sampled": i % (steps // 2) == 0}[reading]
        for d, x in enumerate((*state[1:], u)):
            if bound or d == order - 1:
                ratio = np.maximum(ratio, np.linalg.norm(x, axis=1) / limits[d])
        full = [*state, u]
        fact = [1.0, h, h * h / 2, h**3 / 6]
        state = [sum(full[d + j] * fact[j] for j in range(order + 1 - d)) for d in range(order)]
        moved.append(state[0])
    path = np.stack(moved[:-1], axis=1) / (ratio * (1 + 1e-9))[:, None, None]
    return np.stack([_deepest(path[:, m * steps : (m + 1) * steps + 1]) for m in range(last)], axis=1)


def _deepest(path: Array) -> Array:
    """Return d − (smallest distance), d = 1, of paths (count, times, 3) whose ends are put at the distance 1."""
    delta = path[:, -1] - path[:, 0]
    share = np.linspace(0, 1, path.shape[1])[:, None]
    off = path[:, :1] + share * delta[:, None] - path  # the sagitta
    middle = off[:, path.shape[1] // 2] + 1e-9
    along = delta / np.maximum(np.linalg.norm(delta, axis=1, keepdims=True), 1e-12)
    across = middle - np.sum(middle * along, axis=1, keepdims=True) * along
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    height = np.sqrt(1 - np.sum(delta**2, axis=1) / 4)[:, None, None]
    placed = height * across[:, None] + (share - 0.5) * delta[:, None] - off
    assert np.abs(np.linalg.norm(placed[:, [0, -1]], axis=2) - 1).max() <= 1e-9
    return np.asarray(1 - np.linalg.norm(placed, axis=2).min(axis=1))


@every_case
def test_random_motions_within_the_norms_do_not_dip_deeper(reading: str, order: int) -> None:
    """What a certificate claims is not exceeded by motions in floating point, many of which dip by more than 0.2 m."""
    upper = check(_normed(reading, order)).upper
    dips = _dips(reading, order, np.random.default_rng(13))
    assert dips.max() <= float(upper)
    assert dips.max() > float(LOWER)
