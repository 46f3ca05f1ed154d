"""Assumption 1: deviations from the references stay within their bound at all times, exactly, and follow the seed."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from tests.dmpc_swarm.flight.flights import scenario, violated
from tests.dmpc_swarm.flight.settings import lattice, setting
from tests.scenario.points import points

from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.flight.judge import Flown
from swarmproof.dmpc_swarm.flight.run import fly
from swarmproof.dmpc_swarm.flight.tracking import TrackingError
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import Floats, Lattice

F = Fraction
#: Θ⁻¹ that mixes the axes; symmetric positive definite.
TILTED = "theta_inverse=1,0.3,0,0.3,0.8,-0.2,0,-0.2,0.5"
LATTICES = {"published": (), "tilted": (TILTED,), "one sample": ("T_c=0.2",), "ten samples": ("T_c=0.02",)}
BOUND = F(1, 50)

Vector = tuple[Fraction, Fraction, Fraction]


def inverse(units: Lattice) -> list[list[Fraction]]:
    """Return S⁻¹, exactly, by Cramer's rule."""
    s = [[F(int(entry)) for entry in row] for row in units.pairs.first]
    cofactors = [
        [
            s[(i + 1) % 3][(j + 1) % 3] * s[(i + 2) % 3][(j + 2) % 3]
            - s[(i + 1) % 3][(j + 2) % 3] * s[(i + 2) % 3][(j + 1) % 3]
            for j in range(3)
        ]
        for i in range(3)
    ]
    determinant = sum(s[0][j] * cofactors[0][j] for j in range(3))
    return [[cofactors[j][i] / determinant for j in range(3)] for i in range(3)]


def deviations(units: Lattice, pieces: Floats) -> list[list[list[Vector]]]:
    """Return by step and UAV the four coefficients of the deviation (m), exactly, from the scaled ones."""
    back = inverse(units)
    found = []
    for step in pieces:
        of_uavs = []
        for uav in step:
            scaled = [[F(value) for value in axis] for axis in uav.tolist()]
            columns = [[axis[n] for axis in scaled] for n in range(4)]
            coefficients = []
            for column in columns:
                x, y, z = (sum(a * b for a, b in zip(row, column, strict=True)) * units.position_unit for row in back)
                coefficients.append((F(x), F(y), F(z)))
            of_uavs.append(coefficients)
        found.append(of_uavs)
    return found


def at(coefficients: list[Vector], t: Fraction) -> Vector:
    """Return the cubic with these Bernstein coefficients at t of the step."""
    weights = ((1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2, t**3)
    x, y, z = (sum((w * c[axis] for w, c in zip(weights, coefficients, strict=True)), F(0)) for axis in range(3))
    return x, y, z


def largest(units: Lattice, error: TrackingError, calls: int = 20) -> Fraction:
    """Return the largest squared deviation (m²) at seven instants of each step."""
    squares = []
    for _ in range(calls):
        for of_uavs in deviations(units, error.pieces(units.steps)):
            for coefficients in of_uavs:
                squares += [sum(part**2 for part in at(coefficients, F(n, 6))) for n in range(7)]
    return F(max(squares))


@pytest.mark.parametrize("name", LATTICES)
def test_no_deviation_is_above_the_bound(name: str) -> None:
    """At all times of all steps, each deviation is within the bound, and some come near it."""
    units = lattice(*LATTICES[name])
    square = largest(units, TrackingError(units, [BOUND] * 4, 3))
    assert (F(9, 10) * BOUND) ** 2 < square <= BOUND**2


def test_a_deviation_above_the_bound_is_noticed() -> None:
    """The test above sees deviations that are bounded by a thousandth more."""
    units = lattice()
    assert largest(units, TrackingError(units, [BOUND * F(1001, 1000)] * 4, 3), 60) > BOUND**2


@pytest.mark.parametrize("name", LATTICES)
def test_deviations_are_linear_and_go_on(name: str) -> None:
    """Over a step a deviation moves along a straight line, and each step begins where the last one ended, from 0."""
    units = lattice(*LATTICES[name])
    error = TrackingError(units, [BOUND] * 3, 1)
    steps = [step for _ in range(4) for step in deviations(units, error.pieces(units.steps))]
    assert len(steps) == 4 * units.steps
    assert [coefficients[0] for coefficients in steps[0]] == [(F(0), F(0), F(0))] * 3
    for before, after in pairwise(steps):
        assert [one[3] for one in before] == [one[0] for one in after]
    for step in steps:
        for first, second, third, last in step:
            for axis in range(3):
                third_of_way = (last[axis] - first[axis]) / 3
                assert second[axis] == first[axis] + third_of_way
                assert third[axis] == second[axis] + third_of_way
    assert any(first != last for step in steps for first, _, _, last in step)


def test_pieces_are_integers() -> None:
    """All coefficients are whole numbers, so that adding them to those of references rounds nothing."""
    for changes in LATTICES.values():
        units = lattice(*changes)
        pieces = TrackingError(units, [BOUND] * 4, 0).pieces(50)
        assert np.array_equal(pieces, np.rint(pieces))
        assert 0 < np.abs(pieces).max() < 2.0**50


def test_deviations_follow_the_seed() -> None:
    """The same seed gives the same deviations to the bit, however they are asked for; another seed does not."""
    units = lattice()

    def pieces(seed: int, *calls: int) -> Floats:
        error = TrackingError(units, [BOUND] * 4, seed)
        return np.concatenate([error.pieces(steps) for steps in calls])

    assert pieces(7, 10).tobytes() == pieces(7, 4, 6).tobytes()
    assert pieces(7, 10).tobytes() != pieces(8, 10).tobytes()


@pytest.mark.parametrize("bound", [F(1, 10**12), F(1, 10**11), F(1, 10**9), F(1, 10**6), F(1)])
def test_bounds_of_any_size(bound: Fraction) -> None:
    """A bound of a few lattice units or of a metre is kept as well."""
    units = lattice()
    assert largest(units, TrackingError(units, [bound] * 3, 0), 5) <= bound**2


# In flights


def flown_with(tracking_error: str, rounds: int = 30) -> Flown:
    """Return a lossy flight of the crossing with this bound, in m."""
    what = setting("crossing", 2, 0, [f"tracking_error={tracking_error}"])
    return fly(what, parse("iid:0.1", 2, 2, 0), rounds)[0]


def verdict(flown: Flown, claim: str) -> Verdict:
    """Return what became of a claim."""
    return next(judged.verdict for judged in flown.claims if judged.claim.id == claim)


def test_a_small_error_is_no_collision() -> None:
    """With errors of 2 cm, the actual positions are asked about, and the references are what they would be without."""
    exact, moved = flown_with("0"), flown_with("0.02")
    assert verdict(exact, "eq-2-actual") is Verdict.NOT_APPLICABLE
    assert verdict(moved, "eq-2-actual") is Verdict.NOT_VIOLATED
    assert exact.band.tobytes() == moved.band.tobytes()
    assert exact.continuous_lower == moved.continuous_lower
    assert violated(moved.claims) == set()


def test_a_large_error_is_a_collision() -> None:
    """With errors of 20 cm, UAVs that hover close to each other collide, though their references do not."""
    row = points(*((Fraction(3 * n, 10), 0.0, 1.0) for n in range(5)))
    what = setting(scenario(row, {0: row}), 2, 0)
    windy = setting(scenario(row, {0: row}, "tracking_error=0.2"), 2, 0)
    result = fly(windy, parse("none", 5, 2, 0), 30)[0]
    assert violated(result.claims) == {"eq-2-actual"}
    assert result.continuous_lower > 0.25
    (why,) = (judged.why for judged in result.claims if judged.claim.id == "eq-2-actual")
    assert "less than 0.12 m" in why
    assert violated(fly(what, parse("none", 5, 2, 0), 30)[0].claims) == set()


def test_errors_repeat_with_the_seed() -> None:
    """A flight with errors repeats, and its errors are not those of another seed."""
    row = points(*((Fraction(3 * n, 10), 0.0, 1.0) for n in range(3)))
    windy = scenario(row, {0: row}, "tracking_error=0.2")

    def why(seed: int) -> str:
        result = fly(setting(windy, 1, seed), parse("none", 3, 1, seed), 30)[0]
        return next(judged.why for judged in result.claims if judged.claim.id == "eq-2-actual")

    assert why(1) == why(1) != why(2)
