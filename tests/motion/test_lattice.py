"""The lattice's units, bounds and matrices are exact, whatever T_c, H and Θ⁻¹ are, and no number is too large."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dmpc_swarm.flight.settings import lattice, samples
from tests.margin.settings import TILTED, examples

from swarmproof.errors import BadInput
from swarmproof.motion.integrator import AxisMotion
from swarmproof.motion.lattice import COARSEST, FINEST, LARGEST, Lattice
from swarmproof.theorem3.parameters import Parameters
from swarmproof.theorem3.values import closed

F = Fraction
PERIODS = pytest.mark.parametrize("m", [1, 2, 3, 4])
#: (horizon, changes): short and long ones, many samples, a Θ⁻¹ that mixes the axes, a small and a large
#: space, bounds that are no lattice numbers.
UNITS = [
    (15, ()),
    (2, (samples(1),)),
    (40, (samples(3),)),
    (15, (samples(4), TILTED)),
    (15, (samples(10),)),
    (15, ("theta_inverse=1,1,1/997",)),
    (15, ("workspace=-300,300,-300,300,0,50", "v_max=20,20,5")),
    (10, ("T_s=1", "T_c=0.5", "j_max=0.3,0.7,0")),
    (15, ("v_max=1/3,2/3,0.7", "a_max=1/3,2/3,0.7", "j_max=1/3,2/3,0.7", "workspace=-1/3,2/3,-2/3,1/3,1/7,6/7")),
]
EVERY = pytest.mark.parametrize(("horizon", "changes"), UNITS)


@given(st.data())
@PERIODS
@examples(40)
def test_one_step_is_exact_in_integers(m: int, data: st.DataObject) -> None:
    """In lattice units, a step of T_c under any jerk is p + 3v + 3a + u, v + 2a + u, a + u, without a remainder."""
    units = lattice(samples(m), TILTED)
    p, v, a, u = (data.draw(st.integers(-(2**40), 2**40)) for _ in range(4))
    motion = AxisMotion(
        (p * units.position_unit, v * units.velocity_unit, a * units.acceleration_unit),
        ((units.parameters.T_s, u * units.jerk_unit),),
    )
    assert motion.at(units.parameters.T_c) == (
        (p + 3 * v + 3 * a + u) * units.position_unit,
        (v + 2 * a + u) * units.velocity_unit,
        (a + u) * units.acceleration_unit,
    )


@PERIODS
@pytest.mark.parametrize("horizon", [2, 5, 15])
def test_the_matrices_are_so_many_steps(m: int, horizon: int) -> None:
    """Each column is what the steps make of one unit of position, velocity, acceleration, or of one jerk, alone."""
    units = lattice(samples(m), horizon=horizon)
    states = [(p, v, a, -1) for p, v, a in np.eye(3).tolist()]
    for column, (p, v, a, period) in enumerate([*states, *((0, 0, 0, n) for n in range(horizon))]):
        rows = [(p, v, a)]
        for step in range(horizon * m):
            u = 1 if step // m == period else 0
            p, v, a = p + 3 * v + 3 * a + u, v + 2 * a + u, a + u
            rows.append((p, v, a))
        positions, velocities, accelerations = zip(*rows, strict=True)
        if period < 0:
            assert units.from_state[:, column].tolist() == list(positions)
        else:
            assert units.from_jerks[:, period].tolist() == list(positions)
            assert units.velocity_from_jerks[:, period].tolist() == list(velocities[::m])
            assert units.acceleration_from_jerks[:, period].tolist() == list(accelerations[::m])


@EVERY
def test_bounds_are_the_last_numbers_within(horizon: int, changes: tuple[str, ...]) -> None:
    """A bound in lattice units is within the bound of the parameters; one unit more is not."""
    units = lattice(*changes, horizon=horizon)
    given_ = units.parameters
    assert given_.workspace is not None
    for axis in range(3):
        low, high = closed(given_.workspace)[axis]
        for count, unit, bound in (
            (units.high[axis], units.position_unit, high),
            (-units.low[axis], units.position_unit, -low),
            (units.v_max[axis], units.velocity_unit, given_.v_max[axis]),
            (units.a_max[axis], units.acceleration_unit, given_.a_max[axis]),
            (units.j_max[axis], units.jerk_unit, given_.j_max[axis]),
        ):
            assert int(count) * unit <= bound < (int(count) + 1) * unit


@EVERY
def test_scaled_positions_are_integers(horizon: int, changes: tuple[str, ...]) -> None:
    """S = L·Θ⁻¹ is a matrix of integers, and q in its unit is Θ⁻¹p in m, exactly; so are squared distances."""
    units = lattice(*changes, horizon=horizon)
    theta = units.parameters.theta_inverse
    for row, col in product(range(3), repeat=2):
        entry = units.pairs.first[row, col]
        assert entry == int(entry)
        assert int(entry) * units.pairs.unit == theta[row][col] * units.position_unit
    distance = F(1, 3)
    assert units.pairs.square(distance) * units.pairs.unit**2 == distance**2


@EVERY
def test_the_lattice_is_the_finest_that_is_small_enough(horizon: int, changes: tuple[str, ...]) -> None:
    """Each number of a trajectory within the bounds, and of its scaled positions, is below 2⁵⁰; half the unit is not
    (but for the finest unit that is ever taken).

    The largest is that of a UAV which starts in a corner and always has the largest jerk outwards, speed and
    acceleration; every sum that leads to it has terms of one sign.
    """
    units = lattice(*changes, horizon=horizon)

    def largest(of: Lattice) -> int:
        steps = of.horizon * of.steps
        corner = []
        for axis in range(3):
            p, v, a, u = (int(x[axis]) for x in (np.maximum(-of.low, of.high), of.v_max, of.a_max, of.j_max))
            for _ in range(steps):
                p, v, a = p + 3 * v + 3 * a + u, v + 2 * a + u, a + u
            corner.append(p + abs(int(of.low[axis])))
        return max(sum(abs(int(s)) * p for s, p in zip(row, corner, strict=True)) for row in of.pairs.first)

    assert largest(units) < LARGEST
    assert units.jerk_unit.numerator == 1
    assert COARSEST <= units.jerk_unit.denominator.bit_length() - 1 <= FINEST
    if units.jerk_unit > F(1, 2**FINEST):
        finer = replace(units, jerk_unit=units.jerk_unit / 2)
        # the bound that is used may be somewhat larger than what can be reached
        assert 8 * largest(finer) > LARGEST


@EVERY
def test_the_largest_numbers_are_exact(horizon: int, changes: tuple[str, ...]) -> None:
    """In the corner of everything that is allowed, float64 has the same positions as Python's integers."""
    units = lattice(*changes, horizon=horizon)
    state = np.stack([units.high, units.v_max, units.a_max])
    jerks = np.tile(units.j_max, (horizon, 1))
    positions = units.from_state @ state + units.from_jerks @ jerks
    scaled = positions @ units.pairs.first.T
    p, v, a = ([int(x) for x in row] for row in state)
    for step in range(horizon * units.steps + 1):
        assert positions[step].tolist() == p
        assert [int(q) for q in scaled[step]] == [
            sum(int(s) * x for s, x in zip(row, p, strict=True)) for row in units.pairs.first
        ]
        u = [int(x) for x in units.j_max]
        p = [p + 3 * v + 3 * a + u for p, v, a, u in zip(p, v, a, u, strict=True)]
        v = [v + 2 * a + u for v, a, u in zip(v, a, u, strict=True)]
        a = [a + u for a, u in zip(a, u, strict=True)]


def test_large_parameters_coarsen_the_lattice() -> None:
    """The unit is the finest for the published parameters; more samples, digits or space make it coarser."""
    assert lattice().jerk_unit == F(1, 2**FINEST)
    coarse = [lattice(*changes, horizon=horizon).jerk_unit for horizon, changes in UNITS[4:7]]
    assert min(coarse) > F(1, 2**FINEST)


@pytest.mark.parametrize(
    "changes",
    [
        ("workspace=-1e9,1e9,-1e9,1e9,0,1e9",),
        ("v_max=1e9",),
        ("a_max=1e9",),
        ("j_max=1e9", "v_max=1e9"),
        ("theta_inverse=0.999,0.001,1/997",),
        # so short a step that the numbers do not even fit into 64-bit integers
        ("T_s=0.001", "T_c=0.0001"),
        ("T_s=0.0001", "T_c=0.00001"),
        ("T_s=1e-8", "T_c=1e-9"),
    ],
)
def test_parameters_beyond_every_unit_are_refused(changes: tuple[str, ...]) -> None:
    """Where no unit keeps all numbers below 2⁵⁰, the parameters are refused in one sentence."""
    with pytest.raises(BadInput, match=r"are too large for exact trajectories|least common denominator") as refused:
        lattice(*changes)
    assert "\n" not in str(refused.value)


def test_a_flight_needs_a_space() -> None:
    """Without a flying space, there is no lattice, and the sentence says what to give."""
    with pytest.raises(BadInput, match="give workspace, low and high of x, y and z"):
        Lattice.of(Parameters(), 15)


@given(st.lists(st.tuples(*[st.floats(-3, 3)] * 3), min_size=1, max_size=5))
@EVERY
@examples(20)
def test_points_are_rounded_to_the_nearest(
    horizon: int, changes: tuple[str, ...], points: list[tuple[float, float, float]]
) -> None:
    """A lattice position is an integer, and at most half a unit from the point."""
    units = lattice(*changes, horizon=horizon)
    positions = units.positions(points)
    assert positions.shape == (len(points), 3)
    for position, point in zip(positions, points, strict=True):
        for count, x in zip(position, point, strict=True):
            assert count == int(count)
            assert abs(int(count) * units.position_unit - F(x)) <= units.position_unit / 2


def test_steps_are_samples_in_a_period() -> None:
    """`steps` is m = T_s / T_c."""
    for m in range(1, 11):
        assert lattice(samples(m)).steps == m
