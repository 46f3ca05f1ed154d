"""Decides every constraint of (13) for a plan, exactly: whatever a solver returned, nothing else lets a plan out.

On the lattice, initial state, (13c), (13d) and (13e) are comparisons of integers. For (13f) with (15), multiplied by
‖n‖, float64 decides where its rounding error cannot matter, and integers decide the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.planning.plan import Plan

Booleans = NDArray[np.bool_]

#: Unit roundoff of float64.
ROUNDOFF = 2.0**-53


@dataclass(frozen=True)
class Planes:
    """The separating planes of one planning task: one for each trajectory of another UAV and each sample.

    Attributes:
        others: q of the other UAVs' trajectories at samples h = 0 … h_c of the plan, shape (n, h_c + 1, 3).
        normals: q of the other minus q of the UAV's own old trajectory, n_ij of eq. (14), the same shape.
        halfway: for which of the n trajectories the plane is midway between the UAVs (j ∈ A_ET(k) in eq. 15).
        owners: whose trajectory each of the n is.
    """

    others: Floats
    normals: Floats
    halfway: Booleans
    owners: tuple[int, ...]


def broken_constraint(plan: Plan, old: Plan, planes: Planes) -> str | None:
    """Return the first constraint of (13) that `plan` breaks, in words; None if it satisfies every one exactly."""
    lattice = plan.lattice
    # nan compares false with everything: each condition is said in the way in which nan breaks it
    if not (np.isfinite(plan.jerks).all() and (plan.jerks == np.rint(plan.jerks)).all()):
        return "(12): the jerks are not numbers of the lattice"
    if not (np.abs(plan.jerks) <= lattice.j_max).all():
        return "(13c): a jerk is out of bounds"
    if not np.array_equal(plan.state, old.state_at(plan.start)):
        return "(13b): it does not begin in the state of the old trajectory"
    if not (np.abs(plan.velocities) <= lattice.v_max).all():
        return "(13d): a velocity is out of bounds"
    if not (np.abs(plan.accelerations) <= lattice.a_max).all():
        return "(13d): an acceleration is out of bounds"
    at_periods = plan.positions[:: lattice.steps]
    if not ((at_periods >= lattice.low).all() and (at_periods <= lattice.high).all()):
        return "(13d): a position is outside the flying space"
    if not plan.at_rest:
        return "(13e): it does not end at rest"
    broken = wrong_sides(plan, planes)
    if len(broken):
        trajectory, h = broken[0]
        return f"(13f): it is on the wrong side of UAV {planes.owners[trajectory]}'s plane at sample {h}"
    return None


def wrong_sides(plan: Plan, planes: Planes) -> NDArray[np.intp]:
    """Return the (trajectory, sample h) of the planes on whose wrong side `plan` is, exactly. Shape (broken, 2)."""
    if not len(planes.others):
        return np.empty((0, 2), np.intp)
    lattice = plan.lattice
    apart = planes.others - plan.scaled_from(plan.start)  # integers below 2⁵¹: exact
    products = planes.normals * apart
    dot = products.sum(axis=2)
    square = (planes.normals * planes.normals).sum(axis=2)
    reach = np.sqrt(square) * float(_square_root(lattice))
    right = np.where(planes.halfway[:, None], 0.5 * (reach + square), reach)
    # With u the unit roundoff: a sum of three rounded products is off by at most 3u(1+u)²·Σ|product|; `square` has
    # relative error at most 3u(1+u)², its root at most 3u, d̂ as a float less than 2u, so `right` less than 9u in all.
    # Twice these bounds covers terms of second order and the rounding of the bounds themselves.
    slack = 8 * ROUNDOFF * np.abs(products).sum(axis=2) + 20 * ROUNDOFF * right
    doubtful = np.argwhere(~(dot - slack > right))
    broken = [
        (trajectory, h)
        for trajectory, h in doubtful
        if not right_side(planes.normals[trajectory, h], apart[trajectory, h], planes.halfway[trajectory], lattice)
    ]
    return np.array(broken, np.intp).reshape(-1, 2)


def right_side(
    normal: Sequence[float] | Floats, apart: Sequence[float] | Floats, halfway: bool, lattice: Lattice
) -> bool:
    """Decide one plane of eq. (15) exactly: nᵀΔ ≥ ½(d̂‖n‖ + ‖n‖²) if `halfway`, else nᵀΔ ≥ d̂‖n‖."""
    n, delta = [int(x) for x in normal], [int(x) for x in apart]
    dot, square = sum(a * b for a, b in zip(n, delta, strict=True)), sum(a * a for a in n)
    # both sides multiplied so that what is left is x ≥ d̂‖n‖ with an integer x
    left = 2 * dot - square if halfway else dot
    return square > 0 and left >= 0 and left * left >= lattice.square(lattice.parameters.d_hat_min) * square


def _square_root(lattice: Lattice) -> Fraction:
    """Return d̂_min in scaled units."""
    return lattice.parameters.d_hat_min / lattice.scaled_unit
