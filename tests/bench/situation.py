"""What (13) asks of one plan, set up once more: independently of the planner, and in no solver's form."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmproof.dmpc_swarm.planner.problem import Task, rightness
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.scenario.scenario import Weights

Booleans = NDArray[np.bool_]
Indices = NDArray[np.intp]


class Axis:
    """One axis of (13) in SI units, the same for all tasks.

    Attributes:
        samples: how the H jerks move the positions at samples 1 … h_c, shape (h_c, H).
        states: how they move positions, velocities, accelerations at the ends of periods 1 … H, shape (3H, H).
        weights: of these in the cost, shape (3H,).
        hessian: of the cost in the jerks, shape (H, H).
        ends: how the jerks move velocity and acceleration at the end, shape (2, H).
        high: upper bounds of states and jerks, axis by axis, shape (3, 4H); `low`: lower bounds.
    """

    def __init__(self, lattice: Lattice, weights: Weights) -> None:
        self.lattice, self.band, self.width = lattice, weights.band, weights.band_width
        self.horizon, self.m = lattice.horizon, lattice.steps
        self.jerk_unit = float(lattice.jerk_unit)
        self.units = np.array(
            [float(lattice.position_unit), float(lattice.velocity_unit), float(lattice.acceleration_unit)]
        )
        self.samples = lattice.from_jerks[1:] * (self.units[0] / self.jerk_unit)
        velocities = lattice.velocity_from_jerks[1:] * (self.units[1] / self.jerk_unit)
        accelerations = lattice.acceleration_from_jerks[1:] * (self.units[2] / self.jerk_unit)
        self.states = np.concatenate([self.samples[self.m - 1 :: self.m], velocities, accelerations])
        self.weights = np.repeat([weights.position, weights.speed, weights.acceleration], self.horizon)
        self.jerk_weight = weights.jerk
        weighted = self.states.T @ (self.weights[:, None] * self.states)
        self.hessian: Floats = 2 * (weighted + weights.jerk * np.eye(self.horizon))
        self.ends = np.stack([velocities[-1], accelerations[-1]])
        units = np.append(self.units, self.jerk_unit)
        highs = (lattice.high, lattice.v_max, lattice.a_max, lattice.j_max)
        lows = (lattice.low, -lattice.v_max, -lattice.a_max, -lattice.j_max)
        self.high = np.repeat(np.stack(highs, axis=1) * units, self.horizon, axis=1)
        self.low = np.repeat(np.stack(lows, axis=1) * units, self.horizon, axis=1)


class Situation:
    """What the rows of one task are. They are numbered: planes (by trajectory, then sample), then upper, lower bounds.

    Attributes:
        free: states under zero jerk, shape (3H, 3).
        normals: unit normals of the planes, times Θ⁻¹, shape (n, h_c, 3).
        beyond: a position p is on the right side of a plane if normal · p ≤ beyond; shape (n, h_c).
        owner: by trajectory, the place of its UAV among the neighbours.
        band_weights: by neighbour.
    """

    def __init__(self, axis: Axis, task: Task) -> None:
        self.axis, self.target = axis, task.target
        lattice, planes = axis.lattice, task.planes
        self.state = task.own.state_at(task.start) * axis.units[:, None]
        steps = np.arange(1, axis.horizon * axis.m + 1)[:, None] * float(lattice.parameters.T_c)
        p, v, a = self.state
        self.free_samples = p + steps * v + 0.5 * steps**2 * a
        ends = steps[axis.m - 1 :: axis.m]
        self.free = np.concatenate(
            [self.free_samples[axis.m - 1 :: axis.m], v + ends * a, np.broadcast_to(a, (axis.horizon, 3))]
        )
        unit, d_hat = float(lattice.pairs.unit), float(lattice.pairs.distance)
        normals = planes.normals[:, 1:] * unit
        size = np.sqrt((normals**2).sum(axis=2))
        normals /= np.maximum(size, unit)[:, :, None]
        needed = np.where(planes.halfway[:, None], 0.5 * (d_hat + size), d_hat)
        self.beyond = (normals * planes.others[:, 1:]).sum(axis=2) * unit - needed
        self.normals = normals @ (lattice.pairs.first * float(lattice.pairs.unit / lattice.position_unit))
        places = {j: place for place, j in enumerate(task.others)}
        self.owner = np.array([places[j] for j in planes.owners], np.intp)
        self.band_weights = axis.band * np.exp(rightness(task, lattice))

    @property
    def free_end(self) -> Floats:
        """Velocity and acceleration at the end under zero jerk, shape (2, 3)."""
        return self.free[[2 * self.axis.horizon - 1, 3 * self.axis.horizon - 1]]

    def gradient(self, jerks: Floats) -> Floats:
        """Return the gradient of the cost (without bands) at `jerks`, shape (H, 3)."""
        offsets = self.free.copy()
        offsets[: self.axis.horizon] -= self.target
        gradient: Floats = 2 * (self.axis.states.T * self.axis.weights) @ offsets + self.axis.hessian @ jerks
        return gradient

    def slacks(self, jerks: Floats) -> Floats:
        """Return by how much `jerks` (m/s³, shape (H, 3)) satisfy each row."""
        samples = self.free_samples + self.axis.samples @ jerks
        bounded = np.concatenate([self.free + self.axis.states @ jerks, jerks]).T
        of_planes = self.beyond - (self.normals * samples).sum(axis=2)
        return np.concatenate(
            [of_planes.ravel(), (self.axis.high - bounded).ravel(), (bounded - self.axis.low).ravel()]
        )

    def split(self, rows: Indices) -> tuple[Indices, Indices]:
        """Return which of the rows are planes, and the numbers of the others among the bounds."""
        planes = rows[: np.searchsorted(rows, self.beyond.size)]
        return planes, rows[len(planes) :] - self.beyond.size

    def near_bands(self, slacks: Floats, distance: float) -> Booleans:
        """Return for which neighbours a plane at the last sample is nearer than `distance` (m)."""
        last = slacks[: self.beyond.size].reshape(self.beyond.shape)[:, -1]
        near = np.zeros(len(self.band_weights), np.bool_)
        near[self.owner[last < distance]] = True
        return near

    def cost(self, jerks: Floats) -> float:
        """Return (13a) with Appendix B's soft constraint for `jerks` (m/s³, shape (H, 3)), each ε_j at its best."""
        states = self.free + self.axis.states @ jerks
        states[: self.axis.horizon] -= self.target
        smooth = (self.axis.weights @ states**2).sum() + self.axis.jerk_weight * (jerks**2).sum()
        last = self.slacks(jerks)[: self.beyond.size].reshape(self.beyond.shape)[:, -1]
        room = np.full(len(self.band_weights), self.axis.width)
        np.minimum.at(room, self.owner, np.maximum(last, 0))
        return float(smooth + 0.5 * self.band_weights @ (room - self.axis.width) ** 2)


class Shown(NamedTuple):
    """The part of a problem that a solver gets to see: rows (ascending), neighbours with an ε, and where these go.

    Of the rows, `soft` (places among them) have the ε of band `of_band`.
    """

    rows: Indices
    bands: Indices
    soft: Indices
    of_band: Indices

    @classmethod
    def of(cls, situation: Situation, rows: Booleans, banded: Booleans) -> Shown:
        """Return what is shown of `rows`; the last planes of banded neighbours are added."""
        trajectories = np.flatnonzero(banded[situation.owner])
        soft = (trajectories + 1) * situation.beyond.shape[1] - 1
        rows = rows.copy()
        rows[soft] = True
        shown, bands = np.flatnonzero(rows), np.flatnonzero(banded)
        of_band = np.searchsorted(bands, situation.owner[trajectories])
        return cls(shown, bands, np.searchsorted(shown, soft), of_band)
