"""What the tests of the margin share: parameters by changes, margins that are computed once, and settings."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import numpy as np
from hypothesis import HealthCheck, settings
from tests.margin.brute import Setting, Vector3

from swarmproof.margin.bounds import Margin, margin
from swarmproof.margin.problem import Problem
from swarmproof.theorem3.parameters import Parameters, Reading
from swarmproof.theorem3.values import Vector

INITIAL_STATE, WHOLE_MOTION, AS_SAMPLED = Reading.INITIAL_STATE, Reading.WHOLE_MOTION, Reading.AS_SAMPLED
#: Θ⁻¹ that mixes all axes.
TILTED = "theta_inverse=1,0.3,0,0.3,0.8,-0.2,0,-0.2,0.5"


def examples(count: int) -> settings:
    """Return Hypothesis settings for so many examples: the same ones every time, and no clock."""
    return settings(
        max_examples=count,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    )


def problem(reading: Reading, *changes: str) -> Problem:
    """Return the problem of the published parameters with changes such as ``v_max=1``."""
    return Problem(Parameters().with_changes(changes), reading)


@cache
def _margin(parameters: Parameters, reading: Reading) -> Margin:
    return margin(Problem(parameters, reading))


def solved(asked: Problem) -> Margin:
    """Return the margin of a problem, computed once."""
    return _margin(asked.parameters, asked.reading)


def bounds(reading: Reading, *changes: str) -> Margin:
    """Return the margin of the published parameters with changes."""
    return solved(problem(reading, *changes))


def relative_width(found: Margin) -> float:
    """Return the width of an interval, relative to d̂_min."""
    return float((found.upper - found.lower) / found.problem.parameters.d_hat_min)


def overlap(one: Margin, other: Margin, scale: Fraction = Fraction(1)) -> bool:
    """Say whether `scale` times a number in the one interval can be a number in the other."""
    return scale * one.lower <= other.upper and other.lower <= scale * one.upper


def setting(asked: Problem) -> Setting:
    """Return the problem as the brute force takes it."""
    given = asked.parameters

    def floats(vector: Vector) -> Vector3:
        x, y, z = (float(value) for value in vector)
        return x, y, z

    return Setting(
        T_c=float(given.T_c),
        T_s=float(given.T_s),
        T_b=float(given.T_b),
        d_hat_min=float(given.d_hat_min),
        v_max=floats(given.v_max),
        a_max=floats(given.a_max),
        j_max=floats(given.j_max),
        theta_inverse=np.array(given.theta_inverse, dtype=float),
        order=given.order,
    )
