"""Decides every constraint of (13) for a plan, exactly: whatever a solver returned, nothing else lets a plan out.

On the lattice, initial state, (13c), (13d) and (13e) are comparisons of integers. For (13f) with (15), multiplied by
‖n‖, float64 decides where its rounding error cannot matter, and integers decide the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmproof.dmpc_swarm.planner.plan import ROUNDOFF, Plan
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.motion.pairs import turned
from swarmproof.scenario.scenario import EXACT, Tolerance

Booleans = NDArray[np.bool_]


class Asked(NamedTuple):
    """The d̂_min of planes that are midway between UAVs, and of the others, as floats."""

    halfway: float
    full: float


@lru_cache(maxsize=64)
def asked(lattice: Lattice, tolerance: Tolerance, scaled: bool) -> Asked:
    """Return the d̂_min that planes with this tolerance ask for, in the lattice's scaled unit if `scaled`, else in m."""
    unit = lattice.pairs.unit if scaled else 1
    halfway, full = (tolerance.asked(lattice.pairs.distance, halfway) for halfway in (True, False))
    return Asked(float(halfway / unit), float(full / unit))


@dataclass(frozen=True)
class Planes:
    """The separating planes of one planning task: one for each trajectory of another UAV and each sample.

    Attributes:
        others: q of the other UAVs' trajectories at samples h = 0 … h_c of the plan, shape (n, h_c + 1, 3).
        normals: q of the other minus q of the UAV's own old trajectory, n_ij of eq. (14), the same shape.
        halfway: for which of the n trajectories the plane is midway between the UAVs (j ∈ A_ET(k) in eq. 15).
        owners: whose trajectory each of the n is.
        tolerance: by how much they may be violated. A row with tolerance is one without, for a smaller d̂_min.
        second: what differences are multiplied with, shape (n, 1, 3, 3); None where q is scaled already.
        units: of the n distances, in m; empty where all are that of the lattice.
    """

    others: Floats
    normals: Floats
    halfway: Booleans
    owners: tuple[int, ...]
    tolerance: Tolerance = EXACT
    second: Floats | None = None
    units: tuple[Fraction, ...] = ()

    def apart(self, plan: Plan) -> Floats:
        """Return how far the other trajectories are from `plan`, scaled: integers below 2⁵¹, exact, shape of others."""
        return turned(self.others - plan.scaled_from(plan.start), self.second)

    @cached_property
    def squares(self) -> Floats:
        """‖n‖² as floats, shape (n, h_c + 1)."""
        squares: Floats = np.einsum("nhx,nhx->nh", self.normals, self.normals)
        return squares

    def per_unit(self, lattice: Lattice) -> Floats | float:
        """Return the lattice's unit of distances in that of each trajectory, shape (n, 1), rounded once; or 1."""
        if not self.units:
            return 1.0
        return np.array([[float(lattice.pairs.unit / unit)] for unit in self.units])

    @cached_property
    def lengths(self) -> Floats:
        """‖n‖ as floats, shape (n, h_c + 1)."""
        return np.sqrt(self.squares)


def broken_constraint(plan: Plan, old: Plan, planes: Planes) -> str | None:
    """Return the first constraint of (13) that `plan` breaks, in words; None if it satisfies every one exactly."""
    if not np.array_equal(plan.state, old.state_at(plan.start)):
        return "(13b): it does not begin in the state of the old trajectory"
    if plan.fault is not None:
        return plan.fault
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
    apart = planes.apart(plan)
    products = planes.normals * apart
    dot = np.einsum("nhx->nh", products)
    needed = np.where(planes.halfway[:, None], *asked(lattice, planes.tolerance, scaled=True))
    reach = planes.lengths * (needed * planes.per_unit(lattice))
    right = np.where(planes.halfway[:, None], 0.5 * (reach + planes.squares), reach)
    # With u the unit roundoff: a sum of three rounded products is off by at most 3u(1+u)²·Σ|product|; `squares` has
    # relative error at most 3u(1+u)², its root at most 3u, d̂ as a float less than 4u, so `right` less than 10u in all.
    # Twice these bounds covers terms of second order and the rounding of the bounds themselves.
    slack = 8 * ROUNDOFF * np.einsum("nhx->nh", np.abs(products)) + 20 * ROUNDOFF * right
    sure = dot - slack > right
    if sure.all():
        return np.empty((0, 2), np.intp)
    broken = [
        (trajectory, h)
        for trajectory, h in np.argwhere(~sure)
        if not right_side(
            planes.normals[trajectory, h],
            apart[trajectory, h],
            planes.halfway[trajectory],
            lattice,
            planes.tolerance,
            planes.units[trajectory] if planes.units else None,
        )
    ]
    return np.array(broken, np.intp).reshape(-1, 2)


def old_satisfies(old: Plan, start: int, planes: Planes) -> bool:
    """Decide exactly whether Theorem 1's candidate, `old` shifted to round `start`, satisfies (13) with its planes.

    For the candidate, n of eq. (14) and Δ of (15) are the same: (15) says ‖n‖ ≥ d̂, whether halfway or not. With a
    tolerance, d̂ depends on that; the larger one is enough for both.
    """
    lattice = old.lattice
    enough = _enough(lattice, planes.tolerance)
    # the relative error of `squares` is at most 3u(1+u)², that of `enough` u, that of the square 4u, two products 2u
    if old.fault is None and (planes.squares >= enough * planes.per_unit(lattice) ** 2 * (1 + 12 * ROUNDOFF)).all():
        return True
    return broken_constraint(old.shifted(start), old, planes) is None


@lru_cache(maxsize=64)
def _enough(lattice: Lattice, tolerance: Tolerance) -> float:
    """Return the square of the larger d̂_min that planes ask for, in units of |q|²."""
    d_hat_min = lattice.pairs.distance
    return float(lattice.pairs.square(max(tolerance.asked(d_hat_min, halfway) for halfway in (True, False))))


def right_side(
    normal: Sequence[float] | Floats,
    apart: Sequence[float] | Floats,
    halfway: bool,
    lattice: Lattice,
    tolerance: Tolerance = EXACT,
    unit: Fraction | None = None,
) -> bool:
    """Decide one plane of eq. (15) exactly: nᵀΔ ≥ ½(d̂‖n‖ + ‖n‖²) if `halfway`, else nᵀΔ ≥ d̂‖n‖.

    With ε the `tolerance` of such planes: nᵀΔ/‖n‖ may be smaller by ε. n and Δ count in `unit` (m), or the lattice's.
    """
    n, delta = [int(x) for x in normal], [int(x) for x in apart]
    dot, square = sum(a * b for a, b in zip(n, delta, strict=True)), sum(a * a for a in n)
    # both sides multiplied so that what is left is x ≥ d̂‖n‖ with an integer x
    left = 2 * dot - square if halfway else dot
    distance = tolerance.asked(lattice.pairs.distance, halfway)
    return square > 0 and left >= 0 and left * left >= (distance / (unit or lattice.pairs.unit)) ** 2 * square
