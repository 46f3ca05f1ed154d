"""Builds the quadratic program of (13) and lets a solver solve it, few rows at a time: most planes are never active.

Variables are the 3H jerks, axis by axis, and one ε_j for each neighbour whose plane at the last sample matters.
Rows that the answer breaks are added until it breaks none. That the answer is good is not decided here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmproof.motion.lattice import Floats
from swarmproof.planning.problem import Model, Task, rightness
from swarmproof.planning.solvers import QuadraticProgram, Solver, Status

#: No problem has needed half as many; beyond, the solver counts as having given up.
MOST_SOLVES = 40
#: m. Planes to which the old trajectory comes so close are shown to the solver from the beginning; so are bands that
#: it comes so close to. Only the time to the answer depends on these, not the answer.
NEAR, NEAR_BAND = 0.05, 0.1
#: m/s³. What is larger is no answer: jerks are bounded by a few m/s³, each ε_j by its band's width in m.
BEYOND = 1e6
#: Of each trajectory's planes, one is added for each so many samples.
STRETCH = 6

Booleans = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Rows:
    """All rows of one task: planes first (by trajectory, then sample 1 … h_c), then the bounds of the states.

    A row reads matrix @ jerks + ε ≤ limit, in m, m/s or m/s²; ε only in the planes of the last sample.

    Attributes:
        planes: the number of trajectories of other UAVs, n; the first n·h_c rows are theirs.
        owner: by trajectory, the place of its UAV among the neighbours.
    """

    matrix: Floats
    limits: Floats
    planes: int
    owner: NDArray[np.intp]

    def slacks(self, jerks: Floats) -> Floats:
        """Return by how much `jerks`, shape (3H,) axis by axis, satisfies each row."""
        slacks: Floats = self.limits - self.matrix @ jerks
        return slacks


class LazyProgram:
    """The quadratic program of one task.

    Attributes:
        size: the number 3H of jerks.
    """

    def __init__(self, model: Model, task: Task) -> None:
        self.model = model
        self.size = 3 * model.lattice.horizon
        free_samples, free_states = model.free(task.own, task.start)
        self.rows = _rows(model, task, free_samples, free_states)
        horizon = model.lattice.horizon
        offsets = free_states.copy()
        offsets[:horizon] -= task.target
        self._gradient = (model.gradients @ offsets).T.ravel()
        self._rest = -free_states[[2 * horizon - 1, 3 * horizon - 1]].T.ravel()
        self._band_weights = model.weights.band * np.exp(rightness(task, model.lattice))
        self._samples = model.lattice.horizon * model.lattice.steps

    def solve(self, solver: Solver, start: Floats, demands: Floats, jerk_demand: float) -> tuple[Status, Floats]:
        """Return the solver's last verdict and the jerks in m/s³, shape (3H,), axis by axis.

        An answer that the solver itself is not content with is an answer all the same: where there is hardly any room
        between the planes, interior-point methods come near to the optimum without being able to prove it.

        Args:
            solver: called with growing programs.
            start: jerks near which the answer may be: the rows that matter there are shown at once.
            demands: by how much each row is to be satisfied.
            jerk_demand: by how much the jerks are to be within their bounds, in m/s³.
        """
        width = self.model.weights.band_width
        slacks = self.rows.slacks(start)
        banded = self._near_bands(slacks, width + NEAR_BAND)
        shown = self._worst(slacks, slacks < NEAR)
        jerks = start
        for _ in range(MOST_SOLVES):
            program = self._program(demands, jerk_demand, shown, banded)
            answer = solver(program)
            if answer.status is Status.INFEASIBLE:
                return Status.INFEASIBLE, jerks
            # said so that nan is refused, too
            if answer.x.shape != program.c.shape or not (np.abs(answer.x) <= BEYOND).all():
                return Status.GAVE_UP, np.full(self.size, np.nan)
            jerks = answer.x[: self.size]
            slacks = self.rows.slacks(jerks)
            missing = (slacks < 0.5 * demands) & ~shown
            soft = self._near_bands(slacks, width) & ~banded
            if not (missing.any() or soft.any()):
                return answer.status, jerks
            banded |= soft
            shown |= self._worst(slacks, missing)
        return Status.GAVE_UP, jerks

    def _near_bands(self, slacks: Floats, distance: float) -> Booleans:
        """Return for which neighbours the plane at the last sample is nearer than `distance`."""
        planes = self.rows.planes
        near = np.zeros(len(self._band_weights), np.bool_)
        last = slacks[: planes * self._samples].reshape(planes, self._samples)[:, -1]
        near[self.rows.owner[last < distance]] = True
        return near

    def _worst(self, slacks: Floats, missing: Booleans) -> Booleans:
        """Return of the missing rows all bounds, and of each stretch of a trajectory's planes the most broken one."""
        planes, samples = self.rows.planes, self._samples
        if samples % STRETCH:
            return missing
        of_planes = planes * samples
        chosen = missing.copy()
        stretches = missing[:of_planes].reshape(-1, STRETCH)
        worst = np.where(stretches, slacks[:of_planes].reshape(-1, STRETCH), np.inf).argmin(axis=1)
        kept = np.zeros_like(stretches)
        kept[np.arange(len(kept)), worst] = True
        chosen[:of_planes] = (kept & stretches).ravel()
        return chosen

    def _program(self, demands: Floats, jerk_demand: float, shown: Booleans, banded: Booleans) -> QuadraticProgram:
        model, width, jerks = self.model, self.model.weights.band_width, self.size
        bands = np.flatnonzero(banded)
        size = jerks + len(bands)
        P = np.zeros((size, size), order="F")
        P[:jerks, :jerks] = model.hessians
        weights = self._band_weights[bands]
        P[range(jerks, size), range(jerks, size)] = weights
        c = np.concatenate([self._gradient, -width * weights])
        A = np.zeros((6, size), order="F")
        A[:, :jerks] = model.terminals
        soft, band = self._soft_rows(bands)
        chosen = shown.copy()
        chosen[soft] = False
        chosen = np.concatenate([np.flatnonzero(chosen), soft])
        G = np.zeros((len(chosen), size), order="F")
        G[:, :jerks] = self.rows.matrix[chosen]
        G[range(len(chosen) - len(soft), len(chosen)), jerks + band] = 1
        h = self.rows.limits[chosen] - demands[chosen]
        low, high = np.zeros(size), np.full(size, width)
        high[:jerks] = model.jerk_bounds - jerk_demand
        low[:jerks] = -high[:jerks]
        return QuadraticProgram(P, c, A, self._rest, G, h, low, high)

    def _soft_rows(self, bands: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the rows at the last sample of these neighbours' trajectories, and which band each belongs to."""
        place = np.full(len(self._band_weights), -1)
        place[bands] = np.arange(len(bands))
        band = place[self.rows.owner]
        trajectories = np.flatnonzero(band >= 0)
        return (trajectories + 1) * self._samples - 1, band[trajectories]


def _rows(model: Model, task: Task, free_samples: Floats, free_states: Floats) -> Rows:
    """Return all rows; a plane with a normal of length zero gives a row that nothing satisfies."""
    lattice, planes = model.lattice, task.planes
    unit = float(lattice.scaled_unit)
    n = planes.normals[:, 1:] * unit
    size = np.sqrt((n * n).sum(axis=2))
    n /= np.maximum(size, unit)[:, :, None]
    d_hat = float(lattice.parameters.d_hat_min)
    needed = np.where(planes.halfway[:, None], 0.5 * (d_hat + size), d_hat)
    normals = n @ model.theta_inverse
    limits = (n * planes.others[:, 1:]).sum(axis=2) * unit - (normals * free_samples).sum(axis=2) - needed
    of_planes = limits.size
    states = free_states.T.ravel()
    matrix = np.empty((of_planes + 2 * len(states), 3 * lattice.horizon))
    matrix[:of_planes] = (normals[:, :, :, None] * model.to_samples[:, None, :]).reshape(of_planes, -1)
    matrix[of_planes:] = model.state_rows
    neighbours = {j: place for place, j in enumerate(task.others)}
    return Rows(
        matrix,
        np.concatenate([limits.ravel(), model.state_highs - states, states - model.state_lows]),
        len(limits),
        np.array([neighbours[j] for j in planes.owners], np.intp),
    )
