"""The optimization problem (13) of one CU in one round, and what of it does not depend on the round."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from swarmproof.dmpc_swarm.planner.accept import Planes
from swarmproof.dmpc_swarm.planner.ball import directions, share
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.errors import BadInput
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.motion.pairs import turned
from swarmproof.scenario.scenario import EXACT, Tolerance, Weights
from swarmproof.theorem3.numbers import exact_text


@dataclass(frozen=True, eq=False)
class Task:
    """What a CU knows when it plans UAV i in round k (Algorithm 1 line 18).

    Attributes:
        own: the one trajectory in D_iw(k).
        others: D_jw(k) for the other UAVs j.
        selected: A_ET(k).
        target: where UAV i is to go, in m, shape (3,).
        tolerance: by how much a plan may violate its planes.
    """

    k: int
    i: int
    own: Plan
    others: Mapping[int, tuple[Plan, ...]]
    selected: frozenset[int]
    target: Floats
    tolerance: Tolerance = EXACT

    @property
    def start(self) -> int:
        """The round at whose start the new trajectory begins (eq. 10)."""
        return self.k + 1

    @cached_property
    def planes(self) -> Planes:
        """The separating planes of (13f)."""
        plans = [(j, plan) for j, held in self.others.items() for plan in held]
        mine = self.own.scaled_from(self.start)
        others = np.array([plan.scaled_from(self.start) for _, plan in plans]).reshape(-1, *mine.shape)
        halfway = np.array([j in self.selected for j, _ in plans], np.bool_)
        owners = tuple(j for j, _ in plans)
        pairs = self.own.lattice.pairs
        second = pairs.second(self.i, np.array(owners, np.intp)[:, None])
        units = () if second is None else tuple(pairs.unit_of(self.i, j) for j in owners)
        return Planes(others, turned(others - mine, second), halfway, owners, self.tolerance, second, units)


#: m, m/s, m/s², m/s³: far more than the solver's tolerance, far less than anything that matters to a UAV.
SPARE = 1e-6
#: What rounding to the lattice can change is multiplied with this: the solver's tolerance comes on top.
ROOM = 1.25
#: Which share of a bound may be given away to rounding.
MOST_SPARE = 0.01


def _rounded_off(lattice: Lattice) -> Floats:
    """Return what rounding can change of the jerks of one axis, in m/s³, shape (H, H − 2): a column for each period.

    The jerk of a period is off by at most half a unit, and then the last two restore rest (`planner.Planner.rounded`).
    """
    horizon = lattice.horizon
    rounded = np.zeros((horizon, horizon - 2))
    rounded[: horizon - 2] = np.eye(horizon - 2)
    weights = np.arange(horizon - 1, 1, -1, dtype=float)
    rounded[-2] = -weights
    rounded[-1] = weights - 1
    return 0.5 * float(lattice.jerk_unit) * rounded


class Model:
    """The matrices of (13) in SI units: the same for every round, and every UAV of a kind.

    The coordinates y of a plan say how its jerks differ from those of the old trajectory, which ends at rest: in a
    basis of those differences after which it still does (13e), and in which the quadratic term of the objective (13a)
    is ½|y|². There are H − 2 of them for each axis; they are ordered axis by axis.

    What is bounded (13c, 13d) are, axis by axis, positions, velocities, accelerations at the ends of periods 1 … H,
    and jerks: 12H values. Where norms are bounded, too, the polyhedron of `ball` stands for the ball.

    Attributes:
        band: weight of the soft constraint, relative to the largest weight of (13a).
        theta_inverse: Θ⁻¹, where all pairs have the same; `scaled_unit`: the unit of scaled positions, in m.
        basis: how the coordinates of one axis change its jerks, shape (H, H − 2).
        to_samples: its positions at samples 1 … h_c, shape (h_c, H − 2).
        to_bounded: its bounded values, shape (4H, H − 2).
        bounds: all bounded values by all coordinates, and below these negated, shape (24H, 3(H − 2)).
        highs: upper bounds, shape (12H,); `lows`: lower bounds.
        norms: per bounded norm, which of the bounded values it is about (1 velocities, 2 accelerations, 3 jerks), and
            how far these may reach in each direction of the polyhedron.
        gradients: from the bounded values of one axis (targets subtracted) to the linear term, shape (H − 2, 4H).
        spare_of_planes, spare_of_bounds, spare_of_norms: by how much rows are tightened, so that an answer that is off
            by less than the solver's tolerance, and then rounded, satisfies them (m, m/s, …); shape (), (24H,) and that
            of the rows of norms.

    Raises:
        BadInput: the lattice is so coarse that this would take away much of the problem.
    """

    def __init__(self, lattice: Lattice, weights: Weights) -> None:
        self.lattice = lattice
        self.weights = weights
        pairs = lattice.pairs
        self.scaled_unit = float(pairs.unit)
        self.theta_inverse = pairs.first * float(pairs.unit / lattice.position_unit)
        units = (lattice.position_unit, lattice.velocity_unit, lattice.acceleration_unit, lattice.jerk_unit)
        self.units = np.array([float(unit) for unit in units])
        m, horizon = lattice.steps, lattice.horizon
        per_unit = self.units / self.units[3]
        samples = lattice.from_jerks[1:] * per_unit[0]
        velocities = lattice.velocity_from_jerks[1:] * per_unit[1]
        accelerations = lattice.acceleration_from_jerks[1:] * per_unit[2]
        bounded = np.concatenate([samples[m - 1 :: m], velocities, accelerations, np.eye(horizon)])
        smooth = np.array([weights.position, weights.speed, weights.acceleration, weights.jerk])
        # only ratios matter, and the solver's tolerances are meant for weights of about 1
        self.band = weights.band / smooth.max()
        cost = np.repeat(smooth / smooth.max(), horizon)[:, None]
        hessian = 2 * bounded.T @ (cost * bounded)
        free = np.linalg.svd(np.stack([velocities[-1], accelerations[-1]]))[2][2:].T
        self.basis = free @ np.linalg.inv(np.linalg.cholesky(free.T @ hessian @ free)).T
        self.to_samples = samples @ self.basis
        self.to_bounded = bounded @ self.basis
        self.gradients = 2 * (cost * self.to_bounded).T
        by_axis = np.kron(np.eye(3), self.to_bounded)
        self.bounds = np.concatenate([by_axis, -by_axis])
        self.highs = self._bounds(lattice.high, lattice.v_max, lattice.a_max, lattice.j_max)
        self.lows = self._bounds(lattice.low, -lattice.v_max, -lattice.a_max, -lattice.j_max)
        kinds = {"v_norm": 1, "a_norm": 2, "j_norm": 3}
        self.norms = [(kinds[name], share() * float(norm.bound)) for name, norm in lattice.norms.items()]
        self.spare_of_planes, self.spare_of_bounds = self._spare(samples, bounded)
        self.spare_of_norms = np.empty(0)
        if self.norms:
            spares = np.array([self._spare_of_norm(kind) for kind, _ in self.norms])
            self.spare_of_norms = np.repeat(spares, horizon * len(directions()))

    def _spare(self, samples: Floats, bounded: Floats) -> tuple[float, Floats]:
        """Return by how much rows of planes, and those of bounds, are tightened.

        Args:
            samples: how the jerks of one axis (m/s³) change its positions at samples, shape (h_c, H).
            bounded: how they change its bounded values, shape (4H, H).
        """
        lattice = self.lattice
        rounded = _rounded_off(lattice)
        moved = np.abs(samples @ rounded).sum(axis=1).max()
        # along x, y and z at once, in the scaled distance
        stretched = lattice.pairs.stretch / self.units[0]
        of_planes = max(SPARE, ROOM * float(moved) * stretched * 3**0.5)
        of_kinds = np.abs(bounded @ rounded).sum(axis=1).reshape(4, lattice.horizon).max(axis=1)
        by_kind = np.maximum(SPARE, ROOM * of_kinds)
        given = lattice.parameters
        for name, spare, least in (
            ("d_hat_min", of_planes, lattice.pairs.distance),
            ("v_max", by_kind[1], min(given.v_max)),
            ("a_max", by_kind[2], min(given.a_max)),
            ("j_max", by_kind[3], min(given.j_max)),
        ):
            if spare > SPARE and spare > MOST_SPARE * least:
                raise BadInput(
                    f"{name}={exact_text(least)} is too small for the units of this flight, in which plans are rounded "
                    f"by up to {spare:.1e}: a smaller flying space, a shorter horizon or fewer rounds would do"
                )
        return of_planes, np.tile(np.repeat(by_kind, lattice.horizon), 6)

    def _spare_of_norm(self, kind: int) -> float:
        # all three axes may be off at once
        of_axis = float(self.spare_of_bounds[kind * self.lattice.horizon])
        return of_axis if of_axis <= SPARE else 3**0.5 * of_axis

    def _bounds(self, *by_kind: Floats) -> Floats:
        return np.repeat((np.stack(by_kind, axis=1) * self.units).ravel(), self.lattice.horizon)

    def old(self, task: Task) -> tuple[Floats, Floats]:
        """Return the old trajectory's positions at samples, (h_c, 3), and bounded values, (4H, 3), in SI units."""
        m, horizon = self.lattice.steps, self.lattice.horizon
        own, passed = task.own, min(task.start - task.own.start, horizon)
        samples = own.sampled_from(task.start)[1:] * self.units[0]
        bounded = np.zeros((4 * horizon, 3))
        bounded[:horizon] = samples[m - 1 :: m]
        # nothing but the position is left when the trajectory has ended
        for kind, values in enumerate((own.velocities[1:], own.accelerations[1:], own.jerks), 1):
            begin = kind * horizon
            bounded[begin : begin + horizon - passed] = values[passed:] * self.units[kind]
        return samples, bounded


def rightness(task: Task, lattice: Lattice) -> Floats:
    """Return for each other UAV how far to the right it is, between 1 (right) and −1 (left). Shape (neighbours,).

    It is the sine of the clockwise angle, seen from above, from UAV i's way to its target to its way to UAV j, from
    where they are at the start of the plan. UAVs above each other are neither left nor right.
    """
    here = task.own.sampled_from(task.start)[0]
    there = [held[0].sampled_from(task.start)[0] for held in task.others.values()]
    if not there:
        return np.empty(0)
    x, y = ((np.array(there) - here)[:, :2]).T
    way = task.target[:2] / float(lattice.position_unit) - here[:2]
    size = np.hypot(x, y) * np.hypot(*way)
    sine: Floats = (x * way[1] - y * way[0]) / np.where(size > 0, size, 1.0)
    return sine
