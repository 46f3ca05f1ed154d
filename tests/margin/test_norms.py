"""Bounds of the norm: closed forms, random pairs within the ball, and planted faults that the exact check catches."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from tests.margin.settings import AS_SAMPLED, INITIAL_STATE, TILTED, WHOLE_MOTION, bounds, problem, relative_width

from swarmproof.margin import ball, norms
from swarmproof.margin.ascent import slope
from swarmproof.margin.bounds import margin
from swarmproof.margin.certificate import certificate
from swarmproof.margin.check import Rejected, check
from swarmproof.margin.polygon import Outline, clip
from swarmproof.margin.problem import AxisBounds, Floats, Problem
from swarmproof.theorem3.inequality import Truth
from swarmproof.theorem3.parameters import Parameters, Reading

READINGS = (AS_SAMPLED, WHOLE_MOTION, INITIAL_STATE)
#: Aircraft, straight flight: 5 NM apart at each look, one look every 50 s, 150 m/s in any direction.
AIRCRAFT = ["T_c=50", "T_s=50", "order=2", "a_max=0", "theta_inverse=1", "d_hat_min=9260", "d_min=5000", "v_norm=150"]
#: Quadrotors with 1.5 m/s in any direction.
QUADROTORS = [
    "T_c=0.1",
    "T_s=0.1",
    "v_max=1.5",
    "a_max=2.8",
    "j_max=8",
    "theta_inverse=1,1,0.3125",
    "d_hat_min=0.21",
    "d_min=0.15",
    "v_norm=1.5",
]
#: All bounds of the norm, and a box that never binds.
BALL = [
    "order=2",
    "v_max=100",
    "a_max=100",
    "v_norm=1",
    "a_norm=2",
    "theta_inverse=1,1,0.5",
    "T_c=0.1",
    "T_s=0.1",
    "T_b=0.1",
]


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("v_max", ["150", "150,150,0", "1000"])
def test_straight_flight_head_on_has_a_closed_form(reading: Reading, v_max: str) -> None:
    """At 300 m/s relative for 50 s the dip is 9260 − √(9260² − 7500²) m, in whatever box around the ball."""
    found = bounds(reading, *AIRCRAFT, f"v_max={v_max}")
    assert float(found.lower) <= 9260 - (9260**2 - 7500**2) ** 0.5 + 1e-5
    assert float(found.upper) >= 9260 - (9260**2 - 7500**2) ** 0.5
    assert relative_width(found) <= 1e-4
    assert found.by_norms


def test_speed_in_any_direction_is_neither_the_box_around_nor_the_box_inside() -> None:
    """The box around says that UAVs meet, the box inside that 0.15 m are kept: the truth is in between."""
    found = bounds(AS_SAMPLED, *QUADROTORS)
    around = bounds(AS_SAMPLED, *QUADROTORS, "v_norm=none")
    inside = bounds(AS_SAMPLED, *QUADROTORS, "v_norm=none", "v_max=0.866")
    assert found.lower >= Fraction("0.0630")
    assert found.upper <= Fraction("0.0735")
    assert found.truths[1] is Truth.FAILS
    assert around.lower == Fraction("0.21")
    assert inside.truths[1] is Truth.HOLDS
    assert inside.upper < found.lower


@pytest.mark.parametrize("order", [2, 3])
def test_no_random_pair_within_the_norms_dips_deeper(order: int) -> None:
    """Of many motions that fly as fast and turn as hard as they may, the deepest dip is below upper, and not far."""
    changes = [*BALL, f"order={order}", "j_max=100", "j_norm=20"]
    found = bounds(AS_SAMPLED, *changes)
    deepest = _random_dip(found.problem, 4000)
    assert deepest <= float(found.upper)
    assert deepest >= 0.7 * float(found.lower)


def _random_dip(asked: Problem, count: int) -> float:
    """Return the deepest dip in the middle of random relative motions, as-sampled with one window and one sample."""
    random = np.random.default_rng(1)
    length, order = asked.window_length, asked.order
    speed, *others = (float(norm) for norm in asked.norms if norm is not None)
    deepest = 0.0
    for _ in range(count):
        ways = random.normal(size=(3, 3)) * np.array([1, 1, 0.3])
        v, a, j = ways / np.linalg.norm(ways, axis=1)[:, None] * np.array([speed, *others, 0.0][:3])[:, None]
        a = a * random.choice([0.0, 0.5, 1.0])
        j = j * random.choice([0.0, 0.5, 1.0]) if order == 3 else np.zeros(3)
        v0 = v - a * length / 2 - j * length**2 / 8
        states = [(v0 + a * t + j * t**2 / 2, a + j * t) for t in (0.0, length)]
        excess = max(
            max(float(np.linalg.norm(state)) / speed, float(np.linalg.norm(turn)) / others[0]) for state, turn in states
        )
        # the whole motion is scaled until it keeps what it exceeds
        v0, a, j = (part / max(excess, 1.0) for part in (v0, a, j))
        whole, half = (v0 * t + a * t**2 / 2 + j * t**3 / 6 for t in (length, length / 2))
        near = slope(asked, whole, whole / 2 - half, 0.5).closeness
        deepest = max(deepest, asked.distance + min(near, 0.0))
    return deepest


def test_a_norm_that_never_binds_leaves_the_box() -> None:
    """The interval is that of the box, as narrow, and says that the norm does not count."""
    found, without = (bounds(AS_SAMPLED, "T_c=0.05", *more) for more in (("v_max=2", "v_norm=1000"), ()))
    assert found.lower <= without.upper
    assert without.lower <= found.upper
    assert relative_width(found) <= 1e-2


def test_a_scaling_that_is_not_diagonal_takes_the_box_around_the_ball() -> None:
    """Only the polygons are used then: the interval is wide, right, and accepted."""
    found = bounds(AS_SAMPLED, "T_c=0.05", "order=2", "v_norm=2", "a_norm=5", TILTED)
    assert not found.by_norms
    assert 0 < found.lower < found.upper < found.problem.parameters.d_hat_min


def test_axes_have_twice_the_smaller_bound_and_the_ball_twice_the_norm() -> None:
    """1.5 m/s in any direction and 1 m/s along z; where no norm is given, the ball reaches the corner of the box."""
    asked = problem(AS_SAMPLED, "v_norm=1.5", "v_max=2,2,1", "a_max=3,4,0")
    assert [axis.bound(1) for axis in asked.axes] == [3, 3, 2]
    assert asked.ball.derivatives == ((1, Fraction(3)), (2, Fraction(10)))
    assert 2 * 75**0.5 <= asked.ball.input <= 2 * 75**0.5 + 1e-9


# ---- the form of (**)


def test_the_largest_value_on_a_polygon_is_that_of_many_points() -> None:
    """The maximum of a form is found at corners, inside edges, or 0: as large as at any point, and attained."""
    random = np.random.default_rng(3)
    for _ in range(200):
        angles = np.sort(random.uniform(0, 2 * np.pi, 5))
        polygon = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        form = random.normal(size=3)
        top, (x, y) = ball.largest(form, polygon)
        weights = random.dirichlet(np.ones(5), size=400)
        points = weights @ polygon
        values = form[0] * points[:, 0] ** 2 + 2 * form[1] * points[:, 0] * points[:, 1] + form[2] * points[:, 1] ** 2
        assert values.max() <= top + 1e-12
        assert top == pytest.approx(max(form[0] * x * x + 2 * form[1] * x * y + form[2] * y * y, 0.0))


# ---- planted faults: what is proved is checked by what does not know how


def _halved(patch: pytest.MonkeyPatch) -> None:
    """Plant: the norm of the relative motion is that of one UAV."""
    right = vars(Problem)["ball"].func

    def wrong(self: Problem) -> AxisBounds:
        given = right(self)
        return AxisBounds(tuple((m, bound / 2) for m, bound in given.derivatives), given.input / 2)

    patch.setattr(Problem, "ball", property(wrong))


def _box_bound(patch: pytest.MonkeyPatch) -> None:
    """Plant: a ball edge takes the bounds of an axis, although the ball's acceleration reaches the box's corner."""
    patch.setattr(Problem, "ball", property(lambda self: self.axes[0]))


def _no_share(patch: pytest.MonkeyPatch) -> None:
    """Plant: U counts as it is, without 1/θ."""
    right = ball.BallValues._weights

    def wrong(self: ball.BallValues, t: float, share: float) -> ball.Balance:
        found = right(self, t, 1.0)
        return ball.Balance(found.left, share, found.weights, found.points, found.off)

    patch.setattr(ball.BallValues, "_weights", wrong)


def _light(patch: pytest.MonkeyPatch) -> None:
    """Plant: weights are lost in what is written."""
    right = norms.BallProver._kept

    def wrong(t: float, balance: ball.Balance, outline: Outline) -> norms._Tried:
        tried = right(t, balance, outline)
        assert tried.leaf is not None
        lost = tuple(0.9 * weight for weight in tried.leaf.weights)
        return norms._Tried(ball.BallLeaf(tried.leaf.t, tried.leaf.share, lost), tried.ball, 0.0)

    patch.setattr(norms.BallProver, "_kept", staticmethod(wrong))


def _narrow(patch: pytest.MonkeyPatch) -> None:
    """Plant: the polygons of the axes are too small, as if a box inside the ball were the bound."""

    def wrong(corners: Floats, normal: tuple[float, float], level: float) -> Floats:
        return 0.577 * clip(corners, normal, level)

    patch.setattr(norms, "clip", wrong)


@pytest.mark.parametrize("plant", [_halved, _box_bound, _no_share, _light, _narrow], ids=lambda plant: plant.__name__)
def test_a_planted_fault_is_rejected(
    plant: Callable[[pytest.MonkeyPatch], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A wrong proof does not pass: no margin comes out."""
    asked = problem(AS_SAMPLED, *QUADROTORS, "order=2")
    plant(monkeypatch)
    with pytest.raises(Rejected):
        margin(asked)


def test_a_witness_that_breaks_a_norm_is_rejected() -> None:
    """A pair of the box around the ball is no pair of the ball."""
    found = bounds(AS_SAMPLED, *AIRCRAFT, "v_max=150,150,0")
    boxed = bounds(AS_SAMPLED, *AIRCRAFT, "v_max=150,150,0", "v_norm=none")
    wrong = certificate(found.problem, boxed.lower, boxed.upper, boxed.witness, None)
    with pytest.raises(Rejected):
        check(wrong)


# ---- open sides of the workspace


def test_an_open_side_is_no_limit_and_the_others_are_kept() -> None:
    """A ceiling on z and nothing else gives the same interval as walls a thousand kilometres away."""
    changes = ["T_c=0.1", "T_s=0.1", "v_max=1", "a_max=1.5", "j_max=2", "d_hat_min=0.8", "theta_inverse=1,1,1.6"]
    walls = bounds(AS_SAMPLED, *changes, "workspace=-1000000,1000000,-1000000,1000000,-0.5,7")
    found = bounds(AS_SAMPLED, *changes, "workspace=-inf,inf,-inf,inf,-0.5,7")
    assert (found.lower, found.upper) == (walls.lower, walls.upper)
    assert found.certificate["schema"].endswith("/2")
    assert Fraction("0.0291") <= found.lower <= found.upper <= Fraction("0.0371")
    assert found.witness is not None
    for uav in (found.witness.uav_i, found.witness.uav_j):
        assert all(Fraction("-0.5") <= uav[2].position(time) <= 7 for time in (Fraction(0), Fraction("0.1")))


def test_a_norm_of_zero_is_a_bound_like_others() -> None:
    """Nobody moves: the search has nothing to climb on, and the proof is that of no dip."""
    for reading in (Reading.WHOLE_MOTION, Reading.AS_SAMPLED):
        still = margin(Problem(Parameters().with_changes(["v_norm=0", "order=2"]), reading))
        assert still.lower == 0
        assert still.upper < still.problem.parameters.d_hat_min / 100
