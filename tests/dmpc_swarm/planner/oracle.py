"""Plans and separation decided from the paper alone (DMPC-Swarm, Sections 4.2.3 and 4.3.2, Appendix B), for tests.

It shares nothing with the planner and the claims that it is compared with: it imports nothing of swarmproof. Verdicts
are exact (fractions; norms are compared by their squares). Only :func:`reference_qp` and :func:`plan_cost` compute in
floating point, where nothing but tests with stated error bounds rests on them. Times count from the start of round 0.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Array = NDArray[np.float64]
Vector = tuple[Fraction, Fraction, Fraction]
Matrix = tuple[Vector, Vector, Vector]
#: x, y and z, each as (position in m, velocity in m/s, acceleration in m/s²).
State = tuple[Vector, Vector, Vector]
Box = tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction], tuple[Fraction, Fraction]]

AXES = "xyz"
NO_JERK: Vector = (Fraction(0), Fraction(0), Fraction(0))


def vector(x: Fraction | int | str, y: Fraction | int | str, z: Fraction | int | str) -> Vector:
    """Return the three numbers, read exactly (``"0.1"`` is 1/10)."""
    return Fraction(x), Fraction(y), Fraction(z)


TWO, FIVE = vector(2, 2, 2), vector(5, 5, 5)
DOWNWASH: Matrix = (vector(1, 0, 0), vector(0, 1, 0), vector(0, 0, "1/6"))


@dataclass(frozen=True)
class Limits:
    """The parameters of problem (13) in SI units, by default the published ones; T_s = T_b = T, and h_s = h_b = H."""

    T: Fraction = Fraction(1, 5)
    T_c: Fraction = Fraction(1, 10)
    H: int = 15
    d_hat_min: Fraction = Fraction(1, 4)
    theta_inverse: Matrix = DOWNWASH
    v_max: Vector = TWO
    a_max: Vector = FIVE
    j_max: Vector = FIVE
    #: (low, high) of the position, per axis.
    box: Box = (
        (Fraction("-1.4"), Fraction("1.4")),
        (Fraction("-3.7"), Fraction("3.7")),
        (Fraction("0.4"), Fraction("1.8")),
    )

    @property
    def h_c(self) -> int:
        """Return the index of the last collision sample: h_c T_c = H T."""
        count = self.H * self.T / self.T_c
        if count.denominator != 1:
            raise ValueError("the horizon is no multiple of T_c")
        return int(count)


@dataclass(frozen=True)
class Flown:
    """A trajectory of the triple integrator under one jerk per `period`, and without jerk after the last one.

    `start` is in s, `jerks` in m/s³ by period and axis. It stays at rest at its end only if it is at rest there.
    """

    start: Fraction
    state: State
    jerks: Sequence[Vector]
    period: Fraction = Fraction(1, 5)

    @cached_property
    def _knots(self) -> list[State]:
        states = [self.state]
        for jerk in self.jerks:
            states.append(_moved(states[-1], jerk, self.period))
        return states

    def at(self, t: Fraction) -> State:
        """Return the exact state at time `t`; raise ValueError if `t` is before the start."""
        if t < self.start:
            raise ValueError(f"the trajectory starts at {self.start} s, which is after {t} s")
        piece = min(int((t - self.start) // self.period), len(self.jerks))
        jerk = self.jerks[piece] if piece < len(self.jerks) else NO_JERK
        return _moved(self._knots[piece], jerk, t - self.start - piece * self.period)

    def position(self, t: Fraction) -> Vector:
        """Return the exact position (m) at time `t`."""
        (x, _, _), (y, _, _), (z, _, _) = self.at(t)
        return x, y, z


def _moved(state: State, jerk: Vector, s: Fraction) -> State:
    """Return the state a time `s` later: the Taylor polynomial, which ends with the constant jerk."""
    x, y, z = (
        (p + v * s + a * s**2 / 2 + u * s**3 / 6, v + a * s + u * s**2 / 2, a + u * s)
        for (p, v, a), u in zip(state, jerk, strict=True)
    )
    return x, y, z


def planned(old: Flown, jerks: Array, limits: Limits, k: int) -> Flown:
    """Return the plan of round `k` that continues `old` with these jerks, float (H, 3), taken as they are."""
    begin = (k + 1) * limits.T
    rows = [vector(*(Fraction(float(u)) for u in row)) for row in jerks]
    return Flown(begin, old.at(begin), rows, limits.T)


def rested(plan: Flown) -> Flown:
    """Return the plan with its last two jerks replaced by those that end exactly at rest (13e)."""
    T, last = plan.period, []
    before = plan.at(plan.start + (len(plan.jerks) - 2) * T)
    for _, v, a in before:
        # a + T (u + w) = 0 and v + 2 T a + T²/2 (3 u + w) = 0
        total, weighted = -a / T, -2 * (v + 2 * T * a) / T**2
        u = (weighted - total) / 2
        last.append((u, total - u))
    end = [vector(*(pair[n] for pair in last)) for n in (0, 1)]
    return replace(plan, jerks=[*plan.jerks[:-2], *end])


def _dot(a: Vector, b: Vector) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _scaled(limits: Limits, a: Vector, b: Vector) -> Vector:
    """Return Θ⁻¹(a - b)."""
    difference = vector(a[0] - b[0], a[1] - b[1], a[2] - b[2])
    x, y, z = (_dot(row, difference) for row in limits.theta_inverse)
    return x, y, z


def squared_distance(a: Flown, b: Flown, t: Fraction, limits: Limits) -> Fraction:
    """Return the exact square (m²) of the scaled distance at time `t`."""
    between = _scaled(limits, a.position(t), b.position(t))
    return _dot(between, between)


def _outside(state: State, limits: Limits) -> Iterator[str]:
    """Yield what of the box and the bounds on speed and acceleration (13d) the state breaks."""
    for c, (p, v, a) in enumerate(state):
        low, high = limits.box[c]
        if not low <= p <= high:
            yield f"{AXES[c]} box"
        if abs(v) > limits.v_max[c]:
            yield f"{AXES[c]} speed"
        if abs(a) > limits.a_max[c]:
            yield f"{AXES[c]} acceleration"


def _keeps_side(new: Vector, old: Vector, other: Vector, selected: bool, limits: Limits) -> bool:
    """Return whether position `new` satisfies (15) for UAV i at `old` and UAV j at `other`, all of one instant.

    With n = Θ⁻¹(other - old) and e = Θ⁻¹(other - new), (15) times ‖n‖ is n·e ≥ d̂‖n‖, or n·e ≥ ½(d̂‖n‖ + n·n) for a j
    that is planned, too. Both are s ≥ d̂‖n‖ for an s without roots, hence s ≥ 0 and s² ≥ d̂² n·n. With n = 0 there
    is no plane, and nothing keeps the UAVs apart.
    """
    n = _scaled(limits, other, old)
    length = _dot(n, n)
    side = _dot(n, _scaled(limits, other, new))
    side = 2 * side - length if selected else side
    return length > 0 and side >= 0 and side**2 >= limits.d_hat_min**2 * length


def broken_constraints(
    new: Flown,
    old: Flown,
    neighbours: Mapping[int, Sequence[Flown]],
    selected: Collection[int],
    limits: Limits,
    k: int,
) -> list[str]:
    """Return which constraints of (13) the plan `new` of round `k` breaks, one text each; none if it is feasible.

    `old` is the trajectory that the UAV follows, `neighbours` has the trajectories in D_j(k) by j, and `selected` the
    UAVs of A_ET(k). A plan that is none of (12), with H inputs of a period T from (k+1)T on, breaks just ``(12)``.

    The texts: ``(13b) x``, ``(13c) κ=3 x``, ``(13d) κ=3 x speed`` (or ``box``, ``acceleration``), ``(13e) x``,
    ``(15) j=1 h=7``, the last with `` c=0`` after it if D_1(k) has several trajectories.
    """
    begin = (k + 1) * limits.T
    if (new.start, new.period, len(new.jerks)) != (begin, limits.T, limits.H):
        return ["(12)"]
    broken = [
        f"(13b) {axis}" for axis, is_, should in zip(AXES, new.state, old.at(begin), strict=True) if is_ != should
    ]
    for kappa, jerk in enumerate(new.jerks):
        broken += [f"(13c) κ={kappa} {AXES[c]}" for c in range(3) if abs(jerk[c]) > limits.j_max[c]]
    for kappa in range(limits.H + 1):
        broken += [f"(13d) κ={kappa} {what}" for what in _outside(new.at(begin + kappa * limits.T), limits)]
    end = new.at(begin + limits.H * limits.T)
    broken += [f"(13e) {axis}" for axis, (_, v, a) in zip(AXES, end, strict=True) if v or a]
    times = [begin + h * limits.T_c for h in range(limits.h_c + 1)]
    mine = [(t, new.position(t), old.position(t)) for t in times]
    for j, trajectories in sorted(neighbours.items()):
        for candidate, other in enumerate(trajectories):
            for h, (t, planned_to, expected_at) in enumerate(mine):
                if not _keeps_side(planned_to, expected_at, other.position(t), j in selected, limits):
                    broken.append(f"(15) j={j} h={h}" + (f" c={candidate}" if len(trajectories) > 1 else ""))
    return broken


class TooClose(NamedTuple):
    """Candidate `a` of UAV `i` and candidate `b` of UAV `j` > `i` at `time` (s), with their squared distance (m²)."""

    i: int
    a: int
    j: int
    b: int
    time: Fraction
    squared: Fraction


def separation_violations(
    candidates: Mapping[int, Sequence[Flown]], times: Sequence[Fraction], limits: Limits
) -> list[TooClose]:
    """Return where two candidates of different UAVs are closer than d̂_min (eqs. 20 and 21), in the scaled norm.

    Candidates of one UAV are not compared: it follows one of them.
    """
    found = []
    for i, j in combinations(sorted(candidates), 2):
        for a, mine in enumerate(candidates[i]):
            for b, other in enumerate(candidates[j]):
                for t in times:
                    squared = squared_distance(mine, other, t, limits)
                    if squared < limits.d_hat_min**2:
                        found.append(TooClose(i, a, j, b, t, squared))
    return found


def closest(a: Flown, b: Flown, t0: Fraction, t1: Fraction, limits: Limits, steps: int = 1000) -> Fraction:
    """Return the least squared scaled distance (m²) at t0, t1 and `steps` - 1 instants evenly between them.

    This is an upper bound of the minimum over [t0, t1]: between the instants the UAVs may be closer.
    """
    return min(squared_distance(a, b, t0 + (t1 - t0) * n / steps, limits) for n in range(steps + 1))


@dataclass(frozen=True)
class Weights:
    """The weights of the objective (13a), by default the published ones, and the width (m) of Appendix B's band."""

    position: float = 1.0
    speed: float = 1e-4
    acceleration: float = 5e-3
    jerk: float = 1e-3
    width: float = 0.3


class _Plane(NamedTuple):
    """A row (15) at one instant: normal · position + ε_j ≤ bound, where ε_j is in the last sample only."""

    j: int
    h: int
    normal: Array
    bound: float


def _planes(
    old: Flown,
    neighbours: Mapping[int, Sequence[Flown]],
    selected: Collection[int],
    limits: Limits,
    k: int,
    samples: Sequence[int],
) -> list[_Plane]:
    """Return the rows (15) of these samples, rounded; raise ZeroDivisionError where there is no plane."""
    planes = []
    theta_inverse = np.array(limits.theta_inverse, dtype=float)
    for j, trajectories in sorted(neighbours.items()):
        for other in trajectories:
            for h in samples:
                t = (k + 1) * limits.T + h * limits.T_c
                n = _scaled(limits, other.position(t), old.position(t))
                length = math.sqrt(_dot(n, n))
                least = float(limits.d_hat_min)
                least = (least + length) / 2 if j in selected else least
                normal = theta_inverse.T @ np.array([float(part) / length for part in n])
                there = np.array(other.position(t), dtype=float)
                planes.append(_Plane(j, h, normal, float(normal @ there) - least))
    return planes


@cache
def _slopes(s: Fraction, period: Fraction, inputs: int) -> Array:
    """Return p, v and a after a time s from rest at 0, per unit of each of the jerks, (3, inputs)."""
    still: State = (NO_JERK, NO_JERK, NO_JERK)
    units = [[NO_JERK] * n + [vector(1, 0, 0)] for n in range(inputs)]
    return np.array([Flown(Fraction(0), still, unit, period).at(s)[0] for unit in units], dtype=float).T


def plan_cost(
    new: Flown,
    old: Flown,
    neighbours: Mapping[int, Sequence[Flown]],
    selected: Collection[int],
    target: Sequence[float],
    limits: Limits,
    weights: Weights,
    w_j: Mapping[int, float],
    k: int,
) -> float:
    """Return the objective of (13a) with Appendix B's terms, for a plan that satisfies (15).

    It is Σ_κ=0..H position |p - target|² + speed |v|² + acceleration |a|² + jerk |u|² at (k+1)T + κT, without jerk at
    κ = H, plus Σ_j ½ w_j (ε_j - width)² with the best ε_j: the least slack of j's rows (15) at sample h_c, in
    [0, width]. A j without a w_j has no such term.
    """
    begin = (k + 1) * limits.T
    cost = 0.0
    for kappa in range(limits.H + 1):
        for (p, v, a), aim in zip(new.at(begin + kappa * limits.T), target, strict=True):
            cost += weights.position * (float(p) - aim) ** 2
            cost += weights.speed * float(v) ** 2 + weights.acceleration * float(a) ** 2
    cost += weights.jerk * sum(float(u) ** 2 for jerk in new.jerks for u in jerk)
    end = np.array(new.position(begin + limits.H * limits.T), dtype=float)
    epsilon = dict.fromkeys((j for j in neighbours if w_j.get(j, 0.0)), weights.width)
    for plane in _planes(old, {j: neighbours[j] for j in epsilon}, selected, limits, k, [limits.h_c]):
        slack = plane.bound - float(plane.normal @ end)
        epsilon[plane.j] = max(0.0, min(epsilon[plane.j], slack))
    return cost + sum(w_j[j] * (weights.width - e) ** 2 / 2 for j, e in epsilon.items())


def reference_qp(
    old: Flown,
    neighbours: Mapping[int, Sequence[Flown]],
    selected: Collection[int],
    target: Sequence[float],
    limits: Limits,
    weights: Weights,
    w_j: Mapping[int, float],
    k: int,
) -> tuple[Array, float] | None:
    """Return the optimal jerks of round `k`, float (H, 3) in m/s³, and their cost, or None if (13) is infeasible.

    The objective is that of :func:`plan_cost`, the constraints are all of :func:`broken_constraints`, with ε_j added to
    the right of (15) at sample h_c, for every trajectory of j; a j without a w_j has no ε_j. One QP with every row, in
    the jerks and the ε, is given to Clarabel, whose tolerances are 1e-9: its answer is no exact plan.

    Raises:
        RuntimeError: Clarabel gives up, which says nothing about the problem.
    """
    begin = (k + 1) * limits.T
    samples = range(1, limits.h_c + 1)
    here = old.position(begin)
    # sample 0 and state bound 0 have no variables, so they are decided exactly
    if any(_outside(old.at(begin), limits)) or not all(
        _keeps_side(here, here, other.position(begin), j in selected, limits)
        for j, trajectories in neighbours.items()
        for other in trajectories
    ):
        return None
    try:
        planes = _planes(old, neighbours, selected, limits, k, samples)
    except ZeroDivisionError:
        return None

    soft = [j for j in sorted(neighbours) if w_j.get(j, 0.0)]
    inputs = 3 * limits.H
    drift = Flown(begin, old.at(begin), [NO_JERK] * limits.H, limits.T)

    def responses(s: Fraction) -> tuple[Array, Array]:
        """Return p, v and a without jerk a time s after the begin, (3, axis), and their slopes in the jerks, (3, H)."""
        return np.array(drift.at(begin + s), dtype=float).T, _slopes(s, limits.T, limits.H)

    quadratic = np.zeros((inputs + len(soft), inputs + len(soft)))
    linear = np.zeros(inputs + len(soft))
    quadratic[:inputs, :inputs] = 2 * weights.jerk * np.eye(inputs)
    rows: list[Array] = []
    bounds: list[float] = []

    def at_most(part: Array, bound: float, first: int = 0) -> None:
        row = np.zeros(inputs + len(soft))
        row[first : first + len(part)] = part
        rows.append(row)
        bounds.append(bound)

    # (13a), (13d) and (13e); the equalities come first
    free, slope = responses(limits.H * limits.T)
    for quantity in (1, 2):
        for c in range(3):
            at_most(np.kron(slope[quantity], np.eye(3)[c]), -free[quantity, c])
    equalities = len(rows)
    low, high = np.array(limits.box, dtype=float).T
    highs = np.array([high, limits.v_max, limits.a_max], dtype=float)
    lows = np.array([low, [-v for v in limits.v_max], [-a for a in limits.a_max]], dtype=float)
    aims = np.array([target, np.zeros(3), np.zeros(3)])
    for kappa in range(1, limits.H + 1):
        free, slope = responses(kappa * limits.T)
        for quantity, weight in enumerate((weights.position, weights.speed, weights.acceleration)):
            for c in range(3):
                part = np.kron(slope[quantity], np.eye(3)[c])
                quadratic[:inputs, :inputs] += 2 * weight * np.outer(part, part)
                linear[:inputs] += 2 * weight * part * (free[quantity, c] - aims[quantity, c])
                at_most(part, highs[quantity, c] - free[quantity, c])
                at_most(-part, free[quantity, c] - lows[quantity, c])
    # (13c)
    for n in range(inputs):
        for sign in (1.0, -1.0):
            at_most(np.array([sign]), float(limits.j_max[n % 3]), first=n)
    # (15)
    at_sample = {h: responses(h * limits.T_c) for h in samples}
    for plane in planes:
        free, slope = at_sample[plane.h]
        at_most(np.kron(slope[0], plane.normal), plane.bound - float(plane.normal @ free[0]))
        if plane.h == limits.h_c and plane.j in soft:
            rows[-1][inputs + soft.index(plane.j)] = 1.0
    # Appendix B; no ε_j is larger than the width, as that would cost more and forbid more
    for n, j in enumerate(soft, start=inputs):
        quadratic[n, n] = w_j[j]
        linear[n] = -w_j[j] * weights.width
        at_most(-np.ones(1), 0.0, first=n)

    answer = _clarabel(quadratic, linear, np.array(rows), np.array(bounds), equalities)
    if answer is None:
        return None
    jerks = answer[:inputs].reshape(limits.H, 3)
    new = planned(old, jerks, limits, k)
    return jerks, plan_cost(new, old, neighbours, selected, target, limits, weights, w_j, k)


def _clarabel(quadratic: Array, linear: Array, rows: Array, bounds: Array, equalities: int) -> Array | None:
    """Return the x with least ½ x·quadratic·x + linear·x and rows·x ≤ bounds, the first ones equal; None if none."""
    # it has no types
    clarabel: Any = importlib.import_module("clarabel")
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-9
    cones = [clarabel.ZeroConeT(equalities), clarabel.NonnegativeConeT(len(rows) - equalities)]
    upper = sparse.csc_matrix(np.triu(quadratic))
    solver = clarabel.DefaultSolver(upper, linear, sparse.csc_matrix(rows), bounds, cones, settings)
    solution = solver.solve()
    if solution.status == clarabel.SolverStatus.PrimalInfeasible:
        return None
    if solution.status != clarabel.SolverStatus.Solved:
        raise RuntimeError(f"Clarabel gives up: {solution.status}")
    return np.array(solution.x)
