"""Ways to put (13) to PIQP: which variables it gets, and whether it gets all rows at once or only those that matter.

What differs is the form, not the problem.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import block_diag, coo_array, csc_array, csr_array, diags_array, eye_array, hstack, kron, vstack
from tests.bench.situation import Axis, Indices, Shown, Situation
from tests.bench.solvers.piqp_sparse import solve_sparse

from swarmproof.dmpc_swarm.planner.accept import broken_constraint
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import SPARE, Task
from swarmproof.dmpc_swarm.planner.qp import FIRST_SHARE, MOST_SOLVES, NEAR, NEAR_BAND
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.qp.solvers import QuadraticProgram, Status, solve_with_piqp
from swarmproof.scenario.scenario import Weights


class Form(Protocol):
    """Variables in which (13) can be put."""

    def solve(self, situation: Situation, shown: Shown) -> tuple[Status, Floats]:
        """Return PIQP's verdict and the jerks in m/s³, shape (H, 3)."""
        ...


class Jerks:
    """Variables are the jerks; that the plan ends at rest (13e) are equations. Dense."""

    def __init__(self, axis: Axis) -> None:
        self._axis = axis
        self._A = np.kron(np.eye(3), axis.ends)
        self._P = np.kron(np.eye(3), axis.hessian).astype(float)
        # bounds of jerks are those of variables: their rows are empty
        self._bounded = np.kron(np.eye(3), np.concatenate([axis.states, 0 * np.eye(axis.horizon)]))
        jerks = slice(3 * axis.horizon, None)
        self._low, self._high = axis.low[:, jerks].ravel() + SPARE, axis.high[:, jerks].ravel() - SPARE

    def solve(self, situation: Situation, shown: Shown) -> tuple[Status, Floats]:
        """Return PIQP's verdict and the jerks in m/s³, shape (H, 3)."""
        size, none = len(self._P), np.zeros((self._axis.horizon, 3))
        G, h = _rows(situation, shown, self._axis.samples, self._bounded, none)
        c = situation.gradient(none).T.ravel()
        rest = -situation.free_end.T.ravel()
        answer = solve_with_piqp(_with_bands(situation, shown, self._P, c, self._A, rest, G, h, self._low, self._high))
        return answer.status, answer.x[:size].reshape(3, -1).T


class NullSpace:
    """Variables are coordinates in a basis of the jerks that change nothing at the end: every plan ends at rest. Dense.

    The basis makes the quadratic term of the cost ½|y|². Bounds of jerks are rows like all others.
    """

    def __init__(self, axis: Axis) -> None:
        free = null_space(axis.ends)
        self._basis = free @ np.linalg.inv(np.linalg.cholesky(free.T @ axis.hessian @ free)).T
        self._rest = -np.linalg.pinv(axis.ends)
        self._samples = axis.samples @ self._basis
        self._bounded = np.kron(np.eye(3), np.concatenate([axis.states @ self._basis, self._basis]))
        self._P = np.eye(self._bounded.shape[1])

    def solve(self, situation: Situation, shown: Shown) -> tuple[Status, Floats]:
        """Return PIQP's verdict and the jerks in m/s³, shape (H, 3)."""
        size = len(self._P)
        resting = self._rest @ situation.free_end
        G, h = _rows(situation, shown, self._samples, self._bounded, resting)
        c = (self._basis.T @ situation.gradient(resting)).T.ravel()
        unbounded, none = np.full(size, np.inf), (np.empty((0, size)), np.empty(0))
        answer = solve_with_piqp(_with_bands(situation, shown, self._P, c, *none, G, h, -unbounded, unbounded))
        return answer.status, resting + self._basis @ answer.x[:size].reshape(3, -1).T


def _rows(
    situation: Situation, shown: Shown, samples: Floats, bounded: Floats, origin: Floats
) -> tuple[Floats, Floats]:
    """Return the rows shown, for variables that move one axis's `samples` and what is `bounded`, from `origin` on."""
    planes, bounds = situation.split(shown.rows)
    trajectory, h = np.divmod(planes, situation.beyond.shape[1])
    of_planes = situation.normals[trajectory, h][:, :, None] * samples[h][:, None, :]
    of_bounds = np.where(bounds < len(bounded), 1.0, -1.0)[:, None] * bounded[bounds % len(bounded)]
    rows = np.concatenate([of_planes.reshape(-1, bounded.shape[1]), of_bounds])
    return rows, situation.slacks(origin)[shown.rows] - SPARE


def _with_bands(
    situation: Situation,
    shown: Shown,
    P: Floats,
    c: Floats,
    A: Floats,
    b: Floats,
    G: Floats,
    h: Floats,
    low: Floats,
    high: Floats,
) -> QuadraticProgram:
    """Return the dense program with a variable ε for each band added."""
    width, size = situation.axis.width, len(c)
    more = size + len(shown.bands)
    weights = situation.band_weights[shown.bands]
    wide_P, wide_A, wide_G = (np.zeros((rows, more), order="F") for rows in (more, len(A), len(G)))
    wide_P[:size, :size] = P
    wide_P[range(size, more), range(size, more)] = weights
    wide_A[:, :size] = A
    wide_G[:, :size] = G
    wide_G[shown.soft, size + shown.of_band] = 1
    low, high = (np.concatenate([bound, np.full(more - size, end)]) for bound, end in ((low, 0.0), (high, width)))
    return QuadraticProgram(wide_P, np.concatenate([c, -width * weights]), wide_A, b, wide_G, h, low, high)


class States:
    """Variables are jerks and all states; the motion (12) are equations, and all bounds those of variables. Sparse.

    Of one axis: H jerks, then H positions, velocities, accelerations at the ends of periods.
    """

    def __init__(self, axis: Axis) -> None:
        self._axis = axis
        horizon, T = axis.horizon, float(axis.lattice.parameters.T_s)
        step = np.array([[1, T, T**2 / 2], [0, 1, T], [0, 0, 1]])
        self._step, pushed = step, np.array([[T**3 / 6], [T**2 / 2], [T]])
        # state k + 1 − step · state k − pushed · jerk k = 0, row by row of the state
        later, eye = eye_array(horizon, k=-1), eye_array(horizon)
        motion = hstack([kron(csr_array(-pushed), eye), kron(np.eye(3), eye) - kron(csr_array(step), later)])
        rest = coo_array((np.ones(2), ([0, 1], [3 * horizon - 1, 4 * horizon - 1])), shape=(2, 4 * horizon))
        # rest is not among the rows of the last state: that would be one equation too many
        self._A = block_diag([vstack([motion, rest])] * 3, format="csc")
        one = 2 * np.concatenate([np.full(horizon, axis.jerk_weight), axis.weights])
        self._P = np.tile(one, 3)
        jerks, states = slice(3 * horizon, None), slice(None, 3 * horizon)
        self._high = np.concatenate([axis.high[:, jerks], axis.high[:, states]], axis=1).ravel()
        self._low = np.concatenate([axis.low[:, jerks], axis.low[:, states]], axis=1).ravel()

    def solve(self, situation: Situation, shown: Shown) -> tuple[Status, Floats]:
        """Return PIQP's verdict and the jerks in m/s³, shape (H, 3)."""
        axis, horizon = self._axis, self._axis.horizon
        size, bands = len(self._P), len(shown.bands)
        weights = situation.band_weights[shown.bands]
        P = csc_array(diags_array(np.concatenate([self._P, weights])))
        c = np.zeros((3, 4 * horizon))
        c[:, horizon : 2 * horizon] = -2 * axis.weights[0] * situation.target[:, None]
        b = np.zeros((3, 3 * horizon + 2))
        b[:, : 3 * horizon : horizon] = (self._step @ situation.state).T
        A = csc_array(hstack([self._A, csc_array((self._A.shape[0], bands))]))
        G, h = self._planes(situation, shown)
        low = np.concatenate([self._low + SPARE, np.zeros(bands)])
        high = np.concatenate([self._high - SPARE, np.full(bands, axis.width)])
        gradient = np.concatenate([c.ravel(), -axis.width * weights])
        answer = solve_sparse(P, gradient, A, b.ravel(), G, h, low, high)
        return answer.status, answer.x[:size].reshape(3, -1)[:, :horizon].T

    def _planes(self, situation: Situation, shown: Shown) -> tuple[Any, Floats]:
        """Return the planes among the rows shown: position = p + vτ + aτ²/2 + uτ³/6 at τ after the last period."""
        axis, horizon = self._axis, self._axis.horizon
        planes, _ = situation.split(shown.rows)
        trajectory, h = np.divmod(planes, situation.beyond.shape[1])
        period, sample = np.divmod(h, axis.m)
        tau = (sample + 1) * float(axis.lattice.parameters.T_c)
        terms = np.stack([tau**3 / 6, np.ones_like(tau), tau, tau**2 / 2], axis=1)
        normals = situation.normals[trajectory, h]
        values = normals[:, :, None] * terms[:, None, :]
        # the state before the first period is no variable
        known = period == 0
        h_rows = situation.beyond[trajectory, h] - SPARE
        h_rows[known] -= (values[known][:, :, 1:] * situation.state.T).sum(axis=(1, 2))
        values[known, :, 1:] = 0
        kinds = np.array([0, horizon - 1, 2 * horizon - 1, 3 * horizon - 1])
        columns = 4 * horizon * np.arange(3)[:, None] + kinds + period[:, None, None]
        rows = np.broadcast_to(np.arange(len(planes))[:, None, None], values.shape)
        return self._assembled(values, rows, columns, shown, len(planes)), h_rows

    def _assembled(self, values: Floats, rows: Indices, columns: Indices, shown: Shown, count: int) -> Any:
        some = values.ravel() != 0
        entries = np.concatenate([values.ravel()[some], np.ones(len(shown.soft))])
        at = (
            np.concatenate([rows.ravel()[some], shown.soft]),
            np.concatenate([columns.ravel()[some], len(self._P) + shown.of_band]),
        )
        return csc_array(coo_array((entries, at), shape=(count, len(self._P) + len(shown.bands))))


@dataclass(frozen=True)
class Posed:
    """Plans as the planner does, but in another form, and with all rows at once if not `lazy`.

    It makes the first of the planner's attempts only.
    """

    planner: Planner
    axis: Axis
    form: Form
    lazy: bool

    @classmethod
    def of(cls, lattice: Lattice, weights: Weights, form: Callable[[Axis], Form], lazy: bool) -> Posed:
        """Return it for a swarm's `lattice` and `weights`."""
        axis = Axis(lattice, weights)
        return cls(Planner(lattice, weights), axis, form(axis), lazy)

    def plan(self, task: Task) -> Planned:
        """Return what comes out of `task`."""
        candidate = task.own.shifted(task.start)
        feasible = broken_constraint(candidate, task.own, task.planes) is None
        status, jerks = self._solve(Situation(self.axis, task), candidate.jerks * self.axis.jerk_unit)
        if status is Status.INFEASIBLE:
            return Planned(None, status, "the solver says: infeasible", feasible)
        plan = self.planner.rounded(task, jerks.T.ravel())
        broken = broken_constraint(plan, task.own, task.planes)
        return Planned(plan if broken is None else None, status, broken or "", feasible)

    def _solve(self, situation: Situation, start: Floats) -> tuple[Status, Floats]:
        room = situation.slacks(start)
        rows = room < (NEAR if self.lazy else np.inf)
        banded = situation.near_bands(room, self.axis.width + NEAR_BAND if self.lazy else np.inf)
        for n in range(MOST_SOLVES):
            status, jerks = self.form.solve(situation, Shown.of(situation, rows, banded))
            if status is Status.INFEASIBLE:
                break
            slacks = situation.slacks(jerks)
            missing = (slacks < 0.5 * SPARE) & ~rows
            soft = situation.near_bands(slacks, self.axis.width) & ~banded
            if not (missing.any() or soft.any()):
                break
            soon = missing & (room + FIRST_SHARE * (slacks - room) < 0)
            rows |= soon if n == 0 and soon.any() else missing
            banded |= soft
        return status, jerks
