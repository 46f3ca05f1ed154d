"""The optimization problem (13) of one CU in one round, and what of it does not depend on the round."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.planning.accept import Planes
from swarmproof.planning.plan import Plan
from swarmproof.scenario.scenario import Weights


@dataclass(frozen=True, eq=False)
class Task:
    """What a CU knows when it plans UAV i in round k (Algorithm 1 line 18).

    Attributes:
        own: the one trajectory in D_iw(k).
        others: D_jw(k) for the other UAVs j.
        selected: A_ET(k).
        target: where UAV i is to go, in m, shape (3,).
    """

    k: int
    i: int
    own: Plan
    others: Mapping[int, tuple[Plan, ...]]
    selected: frozenset[int]
    target: Floats

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
        return Planes(others, others - mine, halfway, tuple(j for j, _ in plans))


class Model:
    """The matrices of (13) in SI units: the same for every UAV and round. Jerks are ordered axis by axis, 3H of them.

    Attributes:
        to_samples: how the jerks of one axis move its positions at samples 1 … h_c, shape (h_c, H).
        hessians: of the objective (13a), shape (3H, 3H).
        gradients: from the states of one axis under zero jerk (targets subtracted) to the linear term, shape (H, 3H).
        terminals: velocity and acceleration at the end, axis by axis, shape (6, 3H) (13e).
        state_rows: upper, then lower bounds of position, velocity, acceleration at the ends of periods 1 … H, axis by
            axis, shape (18H, 3H) (13d); `state_highs` and `state_lows`, shape (9H,), are the bounds.
        jerk_bounds: shape (3H,) (13c).
    """

    def __init__(self, lattice: Lattice, weights: Weights) -> None:
        self.lattice = lattice
        self.weights = weights
        self.theta_inverse = lattice.scaling * float(lattice.scaled_unit / lattice.position_unit)
        self.units = np.array(
            [float(lattice.position_unit), float(lattice.velocity_unit), float(lattice.acceleration_unit)]
        )
        m, horizon = lattice.steps, lattice.horizon
        per_unit = self.units / float(lattice.jerk_unit)
        self.to_samples = lattice.from_jerks[1:] * per_unit[0]
        positions = self.to_samples[m - 1 :: m]
        velocities = lattice.velocity_from_jerks[1:] * per_unit[1]
        accelerations = lattice.acceleration_from_jerks[1:] * per_unit[2]
        weighted = (
            (weights.position, positions),
            (weights.speed, velocities),
            (weights.acceleration, accelerations),
        )
        one_axis = weights.jerk * np.eye(horizon) + sum(weight * rows.T @ rows for weight, rows in weighted)
        self.hessians = np.kron(np.eye(3), 2 * one_axis)
        self.gradients = 2 * np.concatenate([weight * rows for weight, rows in weighted]).T
        self.terminals = np.kron(np.eye(3), np.stack([velocities[-1], accelerations[-1]]))
        states = np.kron(np.eye(3), np.concatenate([positions, velocities, accelerations]))
        self.state_rows = np.concatenate([states, -states])
        self.state_highs = self._bounds(lattice.high, lattice.v_max, lattice.a_max)
        self.state_lows = self._bounds(lattice.low, -lattice.v_max, -lattice.a_max)
        self.jerk_bounds = np.repeat(lattice.j_max * float(lattice.jerk_unit), horizon)

    def _bounds(self, position: Floats, velocity: Floats, acceleration: Floats) -> Floats:
        by_axis = np.stack([position, velocity, acceleration], axis=1) * self.units
        return np.repeat(by_axis.ravel(), self.lattice.horizon)

    def free(self, plan: Plan, start: int) -> tuple[Floats, Floats]:
        """Return what happens under zero jerk: sampled positions (H·m, 3) and bounded states (3H, 3), in SI units."""
        lattice, m = self.lattice, self.lattice.steps
        state = plan.state_at(start)
        samples = (lattice.from_state[1:] @ state) * self.units[0]
        periods = m * np.arange(1, lattice.horizon + 1, dtype=float)[:, None]
        velocities = (state[1] + 2 * periods * state[2]) * self.units[1]
        accelerations = np.broadcast_to(state[2] * self.units[2], velocities.shape)
        return samples, np.concatenate([samples[m - 1 :: m], velocities, accelerations])


def rightness(task: Task, lattice: Lattice) -> Floats:
    """Return for each other UAV how far to the right it is, between 1 (right) and −1 (left). Shape (neighbours,).

    It is the sine of the clockwise angle, seen from above, from UAV i's way to its target to its way to UAV j, from
    where they are at the start of the plan. UAVs above each other are neither left nor right.
    """
    here, *there = (plan.state_at(task.start)[0] for plan in (task.own, *(held[0] for held in task.others.values())))
    if not there:
        return np.empty(0)
    x, y = ((np.array(there) - here)[:, :2]).T
    way = task.target[:2] / float(lattice.position_unit) - here[:2]
    size = np.hypot(x, y) * np.hypot(*way)
    sine: Floats = (x * way[1] - y * way[0]) / np.where(size > 0, size, 1.0)
    return sine
