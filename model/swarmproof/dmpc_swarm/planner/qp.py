"""Builds the quadratic program of (13) and lets a solver solve it, few rows at a time: most of them are never active.

Variables are the coordinates y of :class:`~swarmproof.dmpc_swarm.planner.problem.Model`, in which all plans end at rest
and the old trajectory is 0, and one ε_j for each neighbour whose plane at the last sample matters.
Rows that the answer breaks are added until it breaks none. That the answer is good is not decided here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmproof.dmpc_swarm.planner.accept import asked
from swarmproof.dmpc_swarm.planner.ball import directions
from swarmproof.dmpc_swarm.planner.problem import Model, Task, rightness
from swarmproof.motion.lattice import Floats
from swarmproof.motion.pairs import turned
from swarmproof.qp.solvers import QuadraticProgram, Solver, Status

#: No problem has needed half as many; beyond, the solver counts as having given up.
MOST_SOLVES = 40
#: m, m/s, …. Rows to which the old trajectory comes so close are shown to the solver from the beginning; so are bands
#: that it comes so close to (m). Only the time to the answer depends on these, not the answer.
NEAR, NEAR_BAND = 0.05, 0.05
#: The first answer, which knows few rows, goes too far: of those it breaks, the ones are added that it breaks already
#: after this share of the way from the old trajectory to it.
FIRST_SHARE = 0.3
#: What is larger is no answer, whatever the weights are (½|y|² is some cost), and would overflow.
BEYOND = 1e100

Booleans = NDArray[np.bool_]


class Rows:
    """All rows of one task: planes first (by trajectory, then sample 1 … h_c), then the upper and the lower bounds.

    Bounds of norms, if there are any, come last: by norm, then period, then direction.

    A row reads matrix @ y + ε ≤ limit, in m, m/s, m/s² or m/s³; ε only in the planes of the last sample.

    Attributes:
        normals: of the planes, unscaled, shape (n, h_c, 3) for n trajectories of other UAVs.
        owner: by trajectory, the place of its UAV among the neighbours.
        samples: positions of the old trajectory at samples 1 … h_c, shape (h_c, 3); `bounded`: its bounded values.
    """

    def __init__(self, model: Model, task: Task) -> None:
        self.model = model
        self.samples, self.bounded = model.old(task)
        planes = task.planes
        unit = model.scaled_unit if not planes.units else np.array([[float(one)] for one in planes.units])
        size = planes.lengths[:, 1:] * unit
        # a normal of length zero gives a row that nothing satisfies
        n = planes.normals[:, 1:] * (unit / np.maximum(size, unit))[:, :, None]
        halfway, full = asked(model.lattice, planes.tolerance, scaled=False)
        needed = np.where(planes.halfway[:, None], 0.5 * (halfway + size), full)
        # where pairs differ, what is scaled is the difference: its part of the others here, that of the plan in normals
        self.normals = n @ (
            model.theta_inverse
            if planes.second is None
            else planes.second[:, 0] * (np.asarray(unit)[:, :, None] / model.units[0])
        )
        others = turned(planes.others[:, 1:], planes.second)
        self._beyond = np.einsum("nhx,nhx->nh", n, others) * unit - needed
        neighbours = {j: place for place, j in enumerate(task.others)}
        self.owner = np.array([neighbours[j] for j in planes.owners], np.intp)

    def slacks(self, y: Floats) -> Floats:
        """Return by how much y, shape (H − 2, 3), satisfies each row."""
        samples = self.samples + self.model.to_samples @ y
        of_planes = self._beyond - np.einsum("nhx,hx->nh", self.normals, samples)
        bounded = (self.bounded + self.model.to_bounded @ y).T.ravel()
        slacks = [of_planes.ravel(), self.model.highs - bounded, bounded - self.model.lows]
        if self.model.norms:
            values = bounded.reshape(3, 4, -1)
            slacks += [(reach - values[:, kind].T @ directions().T).ravel() for kind, reach in self.model.norms]
        return np.concatenate(slacks)

    @property
    def before_norms(self) -> int:
        """How many rows come before those of norms."""
        return int(self._beyond.size) + len(self.model.bounds)

    def of_planes(self, slacks: Floats) -> Floats:
        """Return the slacks of the planes among those of all rows, shape (n, h_c)."""
        slacks_of_planes: Floats = slacks[: self._beyond.size].reshape(self._beyond.shape)
        return slacks_of_planes

    def last_of(self, trajectories: NDArray[np.intp]) -> NDArray[np.intp]:
        """Return the rows of these trajectories' planes at the last sample."""
        last: NDArray[np.intp] = (trajectories + 1) * self._beyond.shape[1] - 1
        return last

    def chosen(self, rows: NDArray[np.intp]) -> Floats:
        """Return the matrix of these rows (ascending), shape (rows, 3(H − 2))."""
        of_planes, others, of_norms = np.split(rows, np.searchsorted(rows, [self._beyond.size, self.before_norms]))
        trajectory, h = np.divmod(of_planes, self._beyond.shape[1])
        planes = self.normals[trajectory, h][:, :, None] * self.model.to_samples[h][:, None, :]
        bounds = self.model.bounds[others - self._beyond.size]
        matrix = [planes.reshape(len(of_planes), bounds.shape[1]), bounds]
        if len(of_norms):
            matrix.append(self._norms(of_norms - self.before_norms))
        return np.concatenate(matrix)

    def _norms(self, rows: NDArray[np.intp]) -> Floats:
        """Return the matrix of these rows among those of norms, shape (rows, 3(H − 2))."""
        horizon = self.model.lattice.horizon
        value, direction = np.divmod(rows, len(directions()))
        norm, period = np.divmod(value, horizon)
        kinds = np.array([kind for kind, _ in self.model.norms])
        of_axis = self.model.to_bounded[kinds[norm] * horizon + period]
        matrix: Floats = (directions()[direction][:, :, None] * of_axis[:, None, :]).reshape(len(rows), -1)
        return matrix


class LazyProgram:
    """The quadratic program of one task.

    Attributes:
        room: by how much the old trajectory satisfies each row.
        spare: by how much each row is tightened for the solver's tolerance and rounding (m, m/s, …).
    """

    def __init__(self, model: Model, task: Task) -> None:
        self.model = model
        self._rows = Rows(model, task)
        horizon = model.lattice.horizon
        self.room = self._rows.slacks(np.zeros((horizon - 2, 3)))
        planes = np.full(task.planes.normals[:, 1:, 0].size, model.spare_of_planes)
        self.spare = np.concatenate([planes, model.spare_of_bounds, model.spare_of_norms])
        offsets = self._rows.bounded.copy()
        offsets[:horizon] -= task.target
        self._gradient = (model.gradients @ offsets).T.ravel()
        self._old_jerks = self._rows.bounded[3 * horizon :]
        self._band_weights = model.band * np.exp(rightness(task, model.lattice))

    @property
    def kept(self) -> Floats:
        """Demands that the old trajectory meets: `spare`, or the room that it has.

        It may be outside a polyhedron, though never outside the ball: there, no less room is demanded than it has.
        """
        demands = np.clip(self.room, 0.0, self.spare)
        of_norms = slice(self._rows.before_norms, None)
        demands[of_norms] = np.minimum(self.room[of_norms], self.spare[of_norms])
        return demands

    def solve(self, solver: Solver, demands: Floats) -> tuple[Status, Floats]:
        """Return the solver's last verdict and the jerks in m/s³, shape (3H,), axis by axis; nan if there are none.

        An answer that the solver itself is not content with is an answer all the same: where there is hardly any room
        between the planes, interior-point methods come near to the optimum without being able to prove it.

        Args:
            solver: called with growing programs.
            demands: by how much each row is to be satisfied.
        """
        width = self.model.weights.band_width
        banded = self._near_bands(self.room, width + NEAR_BAND)
        shown = self.room < NEAR
        jerks = nothing = np.full(self._old_jerks.size, np.nan)
        for n in range(MOST_SOLVES):
            program = self._program(demands, shown, banded)
            answer = solver(program)
            if answer.status is Status.INFEASIBLE:
                return Status.INFEASIBLE, nothing
            # said so that nan is refused, too
            if answer.x.shape != program.c.shape or not (np.abs(answer.x) <= BEYOND).all():
                return Status.GAVE_UP, nothing
            y = answer.x[: len(self._gradient)].reshape(3, -1).T
            jerks = (self._old_jerks + self.model.basis @ y).T.ravel()
            slacks = self._rows.slacks(y)
            missing = self._in_turn((slacks < 0.5 * demands) & ~shown)
            soft = self._near_bands(slacks, width) & ~banded
            if not (missing.any() or soft.any()):
                return answer.status, jerks
            banded |= soft
            soon = missing & (self.room + FIRST_SHARE * (slacks - self.room) < 0)
            shown |= soon if n == 0 and soon.any() else missing
        return Status.GAVE_UP, jerks

    def _in_turn(self, missing: Booleans) -> Booleans:
        """Return the rows to show next: those of norms only where no other is missing, so that none is for nothing."""
        if missing[: self._rows.before_norms].any():
            missing[self._rows.before_norms :] = False
        return missing

    def _near_bands(self, slacks: Floats, distance: float) -> Booleans:
        """Return for which neighbours the plane at the last sample is nearer than `distance`."""
        near = np.zeros(len(self._band_weights), np.bool_)
        last = self._rows.of_planes(slacks)[:, -1]
        near[self._rows.owner[last < distance]] = True
        return near

    def _program(self, demands: Floats, shown: Booleans, banded: Booleans) -> QuadraticProgram:
        width, coordinates = self.model.weights.band_width, len(self._gradient)
        bands = np.flatnonzero(banded)
        size = coordinates + len(bands)
        weights = self._band_weights[bands]
        P = np.diag(np.concatenate([np.ones(coordinates), weights])).T
        c = np.concatenate([self._gradient, -width * weights])
        # of a banded neighbour's planes at the last sample, all are rows, and ε relaxes them
        trajectories = np.flatnonzero(banded[self._rows.owner])
        soft = self._rows.last_of(trajectories)
        chosen = shown.copy()
        chosen[soft] = True
        rows = np.flatnonzero(chosen)
        G = np.zeros((len(rows), size), order="F")
        G[:, :coordinates] = self._rows.chosen(rows)
        G[np.searchsorted(rows, soft), coordinates + np.searchsorted(bands, self._rows.owner[trajectories])] = 1
        unbounded = np.full(coordinates, np.inf)
        low = np.concatenate([-unbounded, np.zeros(len(bands))])
        high = np.concatenate([unbounded, np.full(len(bands), width)])
        A, b = np.empty((0, size), order="F"), np.empty(0)
        return QuadraticProgram(P, c, A, b, G, self.room[rows] - demands[rows], low, high)
