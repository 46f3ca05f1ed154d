"""The checker's limits: what is just within one is accepted, what is just beyond it is rejected."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from itertools import pairwise
from math import isqrt
from random import Random
from typing import Any

import pytest
from tests.margin.hand_made import CELL, Json, altered, made

from swarmproof.margin.check import DEEPEST_TREE, check
from swarmproof.margin.check_motions import (
    MOST_HALVINGS,
    MOST_IN_PERIOD,
    _length_squared,
    _merged,
    _stays,
    after,
    parameters_of,
    problem_of,
)
from swarmproof.margin.check_numbers import (
    LONGEST_NUMBER,
    Rejected,
    Vector,
    integer,
    list_of,
    number_of,
    numbers_of,
    root_above,
)

F = Fraction


def nested(depth: int) -> Json:
    """Return a tree whose leaf is so many cuts deep: each has the whole polygon below it, and nothing above."""
    tree: Json = {"t": "0"}
    for _ in range(depth):
        tree = {"axis": 0, "normal": ["1", "0"], "at": "2", "below": tree, "above": None}
    return tree


def test_a_tree_may_be_as_deep_as_the_limit() -> None:
    """200 cuts one below the other are checked, 201 are rejected."""
    assert DEEPEST_TREE == 200
    certificate = made("initial-state", 2)
    assert check(altered(certificate, {f"{CELL}/tree": nested(200)})).leaves == 1
    with pytest.raises(Rejected, match="the tree is too deep"):
        check(altered(certificate, {f"{CELL}/tree": nested(201)}))


def test_a_number_may_be_as_long_as_the_limit() -> None:
    """1000 characters are read, 1001 are not."""
    assert LONGEST_NUMBER == 1000
    assert number_of(["0." + "0" * 997 + "1"], 0) == F(1, 10**998)
    with pytest.raises(Rejected, match="0: expected a number"):
        number_of(["0." + "0" * 998 + "1"], 0)


@pytest.mark.parametrize(
    ("text", "value"),
    [("-1/3", F(-1, 3)), ("1/010", F(1, 10)), ("1/20", F(1, 20)), ("-0.50", F(-1, 2)), ("007", F(7)), ("-12", F(-12))],
)
def test_numbers_are_read(text: str, value: Fraction) -> None:
    """Exact decimals and fractions are what they say."""
    assert number_of({"a": text}, "a") == value
    assert numbers_of([[text, "1"]], 0, 2) == (value, F(1))


def test_integers_and_lists_have_their_limits() -> None:
    """Both limits of an integer are allowed, nothing beyond; a list has its length, if it has one."""
    assert [integer([n], 0, 2, 4) for n in (2, 3, 4)] == [2, 3, 4]
    for wrong in (1, 5, True, "3", 3.0, None):
        with pytest.raises(Rejected, match="0: expected an integer from 2 to 4"):
            integer([wrong], 0, 2, 4)
    assert integer([0], 0, 0, 0) == 0
    with pytest.raises(Rejected, match="integer"):
        integer([False], 0, 0, 1)
    assert list_of([[1, 2]], 0) == list_of([[1, 2]], 0, 2) == [1, 2]
    for length in (1, 3, 0):
        with pytest.raises(Rejected, match=f"0: expected a list of length {length}"):
            list_of([[1, 2]], 0, length)
    with pytest.raises(Rejected, match=r"0: expected a list$"):
        list_of([(1, 2)], 0)


def as_sampled(**changes: str) -> Any:
    """Return the problem of a hand-made certificate with other parameters."""
    return problem_of(parameters_of(made("as-sampled", 2)["parameters"] | changes, False), "as-sampled", False)


def test_a_period_may_be_as_long_as_the_limit() -> None:
    """10 000 windows, or sampling instants, are allowed in T_s, one more is not."""
    assert MOST_IN_PERIOD == 10_000
    assert as_sampled(T_s="10000", T_c="1", T_b="2").windows == 10_000
    assert as_sampled(T_s="10000", T_c="2", T_b="1").windows == 5_000
    for changes in ({"T_c": "1", "T_b": "10001"}, {"T_c": "10001", "T_b": "1"}):
        with pytest.raises(Rejected, match="T_s is absurdly long"):
            as_sampled(T_s="10001", **changes)


def test_no_parameter_may_be_zero_that_is_divided_by() -> None:
    """T_c, T_s, T_b and d_hat_min are above 0; bounds, d_min and tracking_error may be 0, and nothing below."""
    for key in ("T_c", "T_s", "T_b", "d_hat_min"):
        for value in ("0", "-1"):
            with pytest.raises(Rejected, match="must be positive"):
                as_sampled(**{key: value})
    least = "1/1000000000"
    assert as_sampled(d_hat_min=least).distance == F(least)
    for key in ("d_min", "tracking_error"):
        as_sampled(**{key: "0"})
        with pytest.raises(Rejected, match="is negative"):
            as_sampled(**{key: f"-{least}"})
    for key in ("v_max", "a_max", "j_max"):
        for axis in range(3):
            bound: Any = [f"-{least}" if k == axis else "1" for k in range(3)]
            with pytest.raises(Rejected, match="is negative"):
                as_sampled(**{key: bound})


def test_a_workspace_may_be_as_wide_as_nothing() -> None:
    """A side of width 0 is allowed; widths are counted by axis."""
    flat: Any = [["1", "1"], ["-1", "2"], ["0", "1/2"]]
    assert [bound[0] for bound in as_sampled(workspace=flat).bounds] == [0, 3, F(1, 2)]


def test_a_dip_may_be_known_exactly() -> None:
    """Two UAVs that meet in the middle of a window dip by all of d_hat_min: lower and upper are the same."""
    meet = {f"witness/uav_{uav}/1/state/0": "0" for uav in "ij"}
    claim = {"windows": None, "dip": {"lower": "0.6", "upper": "0.6"}, "parameters/d_hat_min": "0.6"}
    verified = check(altered(made("whole-motion", 2), {**claim, **meet}))
    assert verified.lower == verified.upper == F("0.6")


def test_roots_just_beside_whole_numbers_are_rounded_up() -> None:
    """The root of n² is n, of a bit less n, too, of a bit more n + 1; in units of 10⁻⁹."""
    for n in (1, 2, 3, 10**9, 10**12 + 7):
        assert root_above(F(n * n, 10**18)) == F(n, 10**9)
        assert root_above(F(n * n + 1, 10**18)) == F(n + 1, 10**9)
        assert root_above(F(2 * n * n + 1, 2 * 10**18)) == F(n + 1, 10**9)
        assert root_above(F(2 * n * n - 1, 2 * 10**18)) == F(n, 10**9)
    assert root_above(F(0)) == 0


# ---- halvings


#: 0.4 + 0.4 s − s² + 0.4 s³: it turns within the piece.
BUMP: Vector = (F("0.4"), F("0.4"), F(-2), F("2.4"))


@cache
def needing(halvings: int) -> Fraction:
    """Return a bound that so many halvings show that BUMP keeps, and one less do not."""
    turn = (2 - F(isqrt(208 * 10**38), 10**20)) / F("2.4")  # where 0.4 − 2s + 1.2s² is 0
    top = after(BUMP, turn)[0]
    for k in range(1, 200):
        bound = top + F(1, 1) / F(3, 2) ** k
        if _stays(BUMP, F(1), None, bound, halvings) and not _stays(BUMP, F(1), None, bound, halvings - 1):
            return bound
    raise AssertionError("no such bound")


def test_as_many_halvings_as_the_limit_show_that_a_motion_stays() -> None:
    """What ten halvings of a cubic show is accepted; what takes eleven is not shown."""
    assert MOST_HALVINGS == 10
    certificate = altered(made("whole-motion", 3), {"windows": None, "dip": {"lower": "0", "upper": "1"}})
    bump = {"state": ["0.4", "0.4", "-2"], "inputs": [["1", "2.4"]]}
    loose = {"parameters/v_max/1": "2", "parameters/a_max/1": "2", "parameters/j_max/1": "3", "witness/uav_i/1": bump}
    for halvings, reason in ((10, "closer than d_hat_min at an end"), (11, "not shown to stay in the workspace")):
        room = [["-1", "1"], ["-1", str(needing(halvings))], ["0", "0"]]
        with pytest.raises(Rejected, match=reason):
            check(altered(certificate, {**loose, "parameters/workspace": room}))
    flipped = {"state": ["-0.4", "-0.4", "2"], "inputs": [["1", "-2.4"]]}
    for halvings, reason in ((10, "closer than d_hat_min at an end"), (11, "not shown to stay in the workspace")):
        room = [["-1", "1"], [str(-needing(halvings)), "1"], ["0", "0"]]
        with pytest.raises(Rejected, match=reason):
            check(altered(certificate, {**loose, "witness/uav_i/1": flipped, "parameters/workspace": room}))


def test_a_polynomial_that_leaves_is_never_shown_to_stay() -> None:
    """Whatever the number of halvings: a value beyond a side, by however little, at whatever time."""
    random = Random(3)
    shown = 0
    for _ in range(50):
        degree = random.randint(1, 4)
        state = tuple(F(random.randint(-6, 6), random.randint(1, 3)) for _ in range(degree + 1))
        duration = F(random.randint(1, 6), 3)
        values = [after(state, duration * n / 24)[0] for n in range(25)]
        low, high = min(values), max(values)
        for halvings in (0, 3, 6):
            assert not _stays(state, duration, None, high - F(1, 10**6), halvings)
            assert not _stays(state, duration, low + F(1, 10**6), None, halvings)
            assert _stays(state, duration, None, None, halvings)
        assert _stays(state, duration, low - F(1, 4), high + F(1, 4), 10)
        shown += _stays(state, duration, low, high, 0)
    assert shown > 5


# ---- pieces and lengths


def a_motion(random: Random, order: int) -> list[tuple[Fraction, Fraction, Vector]]:
    """Return a motion on [0, 1] by pieces, as the checker keeps it."""
    cuts = [F(0), *sorted({F(random.randint(1, 5), 6) for _ in range(random.randrange(3))}), F(1)]
    state = tuple(F(random.randint(-3, 3)) for _ in range(order))
    motion = []
    for begin, end in pairwise(cuts):
        piece = (*state, F(random.randint(-3, 3)))
        motion.append((begin, end, piece))
        state = after(piece, end - begin)[:-1]
    return motion


def values(motion: list[tuple[Fraction, Fraction, Vector]], time: Fraction) -> Iterator[Vector]:
    """Yield the derivatives of a motion at a time, of each piece that has it."""
    for begin, end, state in motion:
        if begin <= time <= end:
            yield after(state, time - begin)


def test_pieces_of_several_axes_are_those_of_each() -> None:
    """Merged pieces cover [0, 1] without a gap, change with any axis, and have each axis's derivatives in them."""
    random = Random(5)
    for _ in range(20):
        motions = [a_motion(random, 3) for _ in range(3)]
        merged = list(_merged(motions))
        ends = sorted({end for motion in motions for _, end, _ in motion})
        assert [(begin, end) for begin, end, _ in merged] == list(pairwise([F(0), *ends]))
        for begin, end, states in merged:
            middle = (begin + end) / 2
            for state, motion in zip(states, motions, strict=True):
                assert list(values(motion, middle)) == [after(state, middle - begin)]


def test_squares_of_lengths_have_all_their_derivatives() -> None:
    """The derivatives of Σ (d-th derivative)² give its value at any time, by Taylor's formula."""
    random = Random(6)
    for _ in range(20):
        states = [tuple(F(random.randint(-4, 4)) for _ in range(4)) for _ in range(random.randint(1, 3))]
        d, time = random.randint(0, 3), F(random.randint(0, 8), 4)
        squared = _length_squared(states, d)
        assert len(squared) == 2 * (4 - d) - 1
        assert after(squared, time)[0] == sum(after(state, time)[d] ** 2 for state in states)
