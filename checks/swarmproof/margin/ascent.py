"""Look for a pair that comes close: the search for the lower bound, in floating point.

Motions of one axis form a convex set, so a convex combination of a few extreme ones is a motion, too. The search
alternates between the best combination of those known and new extreme motions in the direction of the gradient.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from swarmproof.margin.corners import closeness, squares, sums
from swarmproof.margin.extremes import Extremes
from swarmproof.margin.functional import Moment
from swarmproof.margin.problem import Floats, Problem
from swarmproof.margin.prove import Blocked
from swarmproof.motion.integrator import AxisMotion

#: Rounds of new extreme motions, and by how much (relative to d̂_min) a round must help to go on.
ROUNDS, GAIN = 12, 1e-9
#: Times of closest approach (as τ/T_c) and angles of the directions that a search starts with.
FRACTIONS, ANGLES = (0.3, 0.4, 0.5, 0.6, 0.7), 12
#: How much of the way from what is attained to a blocked corner may be missing for a climb to be worth it.
NEARLY = 0.7
#: How many starts are followed in each window.
STARTS = 2


@dataclass(frozen=True)
class Candidate:
    """A relative motion found in floating point: window, τ/T_c, a motion per axis, and its dip in m (at most d̂_min)."""

    window: int
    fraction: float
    motions: tuple[AxisMotion[float], ...]
    dip: float


@dataclass(frozen=True)
class Slope:
    """How close a pair with given (δ, g) gets, −‖x‖ (m; above 0: it passes through), and its derivatives."""

    closeness: float
    t: float
    delta: Floats
    sagitta: Floats


def slope(problem: Problem, delta: Floats, sagitta: Floats, fraction: float) -> Slope:
    """Return min over t of −(*) for one (δ, g), both of shape (3,), at τ/T_c = `fraction`, and its gradient there."""
    scaling = problem.scaling
    scaled_delta, scaled_sagitta = scaling @ delta, scaling @ sagitta
    known = squares(scaled_delta[None, :], scaled_sagitta[None, :])

    def value(t: Floats) -> Floats:
        return closeness(*known, problem.distance, (fraction + t) * (1 - fraction - t), t)

    low, high = -fraction, 1 - fraction
    for _ in range(7):
        grid = np.linspace(low, high, 17)
        best = int(np.argmin(value(grid)))
        low, high = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, 16)])
    t = (low + high) / 2
    weight = (fraction + t) * (1 - fraction - t)
    off = scaled_sagitta + t * scaled_delta
    size = float(np.linalg.norm(off))
    root = float(np.sqrt(max(problem.distance**2 - weight * float(known[0][0]), 1e-12 * problem.distance**2)))
    by_sagitta = scaling.T @ off / size if size > 1e-12 * problem.distance else np.zeros(3)
    by_delta = t * by_sagitta + weight * (scaling.T @ scaled_delta) / root
    return Slope(float(value(np.array([t]))[0]), t, by_delta, by_sagitta)


@dataclass
class Ascent:
    """The search in one window; `known` are the extreme motions per kind of axis."""

    problem: Problem
    by_kind: list[Extremes]
    kinds: tuple[int, ...]
    window: int
    known: list[list[AxisMotion[float]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.known = [[] for _ in self.by_kind]

    def moment(self, fraction: float) -> Moment:
        """Return the three times for τ/T_c = `fraction`."""
        length = self.problem.window_length
        return Moment(self.problem.start_of(self.window), fraction * length, length)

    def from_scratch(self) -> list[Candidate]:
        """Return candidates climbed to from the best combinations of extreme motions."""
        middle = self.moment(0.5)
        for kind, source in enumerate(self.by_kind):
            longest = abs(middle.point(source.motion(middle, 1.0, 0.0))[0])
            deepest = abs(middle.point(source.motion(middle, 0.0, 1.0))[1])
            if longest == 0 and deepest == 0:
                self.known[kind].append(source.motion(middle, 1.0, 0.0))
                continue
            size = deepest / longest if longest and deepest else 1.0
            for angle in np.arange(ANGLES) * np.pi / ANGLES:
                motion = source.motion(middle, float(np.cos(angle)) * size, float(np.sin(angle)))
                self.known[kind] += [motion, motion.scaled(-1.0)]
        found: list[tuple[float, float, tuple[int, ...]]] = []
        for fraction in FRACTIONS:
            found += self._best_triples(fraction)
        found.sort(key=lambda item: -item[0])
        chosen: list[tuple[float, float, tuple[int, ...]]] = []
        for item in found:
            # mirror images come equally close; one of them is enough
            if all(abs(item[0] - other[0]) > 1e-4 * abs(other[0]) + 1e-15 for other in chosen):
                chosen.append(item)
        return [
            self._climb(fraction, [self.known[kind][index] for kind, index in zip(self.kinds, triple, strict=True)])
            for _, fraction, triple in chosen[:STARTS]
        ]

    def from_corner(self, blocked: Blocked, dip: float, known: float) -> Candidate | None:
        """Return the candidate climbed to from where a proof was blocked, by (δ, g) that need not be attainable.

        None if the motions beside these neither nearly reach `dip` (m) nor come up to the `known` one.
        """
        points, fraction = np.array(blocked.corner), blocked.fraction
        wanted = slope(self.problem, points[:, 0], points[:, 1], fraction)
        moment = self.moment(fraction)
        motions = []
        for axis, kind in enumerate(self.kinds):
            along = float(wanted.delta[axis]), float(wanted.sagitta[axis])
            (a, b), (c, d) = blocked.directions[axis]
            beside = [
                self.by_kind[kind].motion(moment, alpha, beta)
                for alpha, beta in (along, (a, b), (c, d), (a + c, b + d))
                if alpha or beta
            ]
            gaps = [float(np.hypot(*(np.array(moment.point(motion)) - points[axis]))) for motion in beside]
            motions.append(beside[int(np.argmin(gaps))])
        reached = np.array([moment.point(motion) for motion in motions])
        attained = slope(self.problem, reached[:, 0], reached[:, 1], fraction).closeness
        missing = dip - self.problem.distance - attained
        if missing > max(NEARLY * (wanted.closeness - attained), dip - known):
            return None
        return self._climb(fraction, motions)

    def _points(self, kind: int, fraction: float) -> Floats:
        moment = self.moment(fraction)
        return np.array([moment.point(motion) for motion in self.known[kind]])

    def _best_triples(self, fraction: float) -> list[tuple[float, float, tuple[int, ...]]]:
        """Return combinations of known motions that come close, with how close."""
        points = [self._points(kind, fraction) for kind in self.kinds]
        shape = tuple(len(p) for p in points)

        delta, sagitta = (
            sums([p[:, column, None] * self.problem.scaling[None, :, k] for k, p in enumerate(points)])
            for column in (0, 1)
        )
        known = squares(delta, sagitta)
        best = np.full(len(delta), np.inf)
        for t in np.linspace(-fraction, 1 - fraction, 41):
            product = float((fraction + t) * (1 - fraction - t))
            best = np.minimum(best, closeness(*known, self.problem.distance, product, float(t)))
        top = np.argsort(-best, kind="stable")[:200:4]
        return [(float(best[i]), fraction, tuple(int(n) for n in np.unravel_index(i, shape))) for i in top]

    def _climb(self, fraction: float, start: list[AxisMotion[float]]) -> Candidate:
        """Alternate between the best combination and new extreme motions, until a round gains nothing."""
        active = [[motion] for motion in start]
        weights = [np.ones(1) for _ in active]
        best = -np.inf
        for _ in range(ROUNDS):
            delta, sagitta = self._mixed(active, weights, fraction)
            gradient = slope(self.problem, delta, sagitta, fraction)
            moment = self.moment(fraction)
            for axis, kind in enumerate(self.kinds):
                alpha, beta = float(gradient.delta[axis]), float(gradient.sagitta[axis])
                if alpha or beta:
                    active[axis].append(self.by_kind[kind].motion(moment, alpha, beta))
                    weights[axis] = np.append(weights[axis], 0.0)
            fraction, weights, reached = self._combine(active, weights, fraction)
            for axis in range(3):
                used = weights[axis] > 1e-9
                active[axis] = [motion for motion, keep in zip(active[axis], used, strict=True) if keep]
                weights[axis] = weights[axis][used] / weights[axis][used].sum()
            if reached <= best + GAIN * self.problem.distance:
                break
            best = reached
            if best >= 0:
                break
        motions = tuple(mixture(parts, share) for parts, share in zip(active, weights, strict=True))
        delta, sagitta = self._mixed(active, weights, fraction)
        reached = slope(self.problem, delta, sagitta, fraction).closeness
        return Candidate(self.window, fraction, motions, self.problem.distance + min(reached, 0.0))

    def _mixed(
        self, active: list[list[AxisMotion[float]]], weights: list[Floats], fraction: float
    ) -> tuple[Floats, Floats]:
        moment = self.moment(fraction)
        rows = [
            share @ np.array([moment.point(motion) for motion in motions])
            for motions, share in zip(active, weights, strict=True)
        ]
        return np.array([row[0] for row in rows]), np.array([row[1] for row in rows])

    def _combine(
        self, active: list[list[AxisMotion[float]]], weights: list[Floats], fraction: float
    ) -> tuple[float, list[Floats], float]:
        """Return τ/T_c and weights of the motions (sums 1 per axis) at a local optimum, and how close it gets."""
        from scipy.optimize import minimize  # a second to import

        solver: Any = minimize

        sizes = [len(motions) for motions in active]
        ends = np.cumsum(sizes)
        scale = self.problem.distance

        def split(z: Floats) -> list[Floats]:
            return list(np.split(z[:-1], ends[:-1]))

        def objective(z: Floats) -> tuple[float, Floats]:
            share, here = split(z), float(z[-1])
            delta, sagitta = self._mixed(active, share, here)
            at = slope(self.problem, delta, sagitta, here)
            moment = self.moment(here)
            gradient = []
            for axis, motions in enumerate(active):
                points = np.array([moment.point(motion) for motion in motions])
                gradient.append(points @ np.array([at.delta[axis], at.sagitta[axis]]))
            step = 1e-6
            shifted = self._mixed(active, share, here + step)
            later = slope(self.problem, shifted[0], shifted[1], here + step)
            gradient.append(np.array([(later.closeness - at.closeness) / step]))
            return -at.closeness / scale, -np.concatenate(gradient) / scale

        start = np.concatenate([*[0.98 * w + 0.02 / len(w) for w in weights], [fraction]])
        sums = np.zeros((3, len(start)))
        for axis, (end, size) in enumerate(zip(ends, sizes, strict=True)):
            sums[axis, end - size : end] = 1.0
        best = (fraction, weights, slope(self.problem, *self._mixed(active, weights, fraction), fraction).closeness)
        result = solver(
            objective,
            start,
            jac=True,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * (len(start) - 1) + [(1e-3, 1 - 1e-3)],
            constraints=[{"type": "eq", "fun": lambda z: sums @ z - 1, "jac": lambda z: sums}],
            options={"maxiter": 100, "ftol": 1e-14},
        )
        share = [np.maximum(w, 0.0) / np.maximum(w, 0.0).sum() for w in split(np.asarray(result.x))]
        here = min(max(float(result.x[-1]), 0.0), 1.0)
        reached = slope(self.problem, *self._mixed(active, share, here), here).closeness
        return (here, share, reached) if reached > best[2] else best


def mixture(motions: list[AxisMotion[float]], weights: Floats) -> AxisMotion[float]:
    """Return the convex combination of motions, with the union of their breakpoints."""
    if len(motions) == 1:
        return motions[0]
    ends = sorted({round(float(end), 15) for motion in motions for end in np.cumsum([d for d, _ in motion.inputs])})
    state = tuple(
        float(sum(w * motion.state[m] for w, motion in zip(weights, motions, strict=True)))
        for m in range(len(motions[0].state))
    )
    inputs, before = [], 0.0
    for end in ends:
        if end - before > 1e-12:
            value = sum(w * _input_at(motion, (before + end) / 2) for w, motion in zip(weights, motions, strict=True))
            inputs.append((end - before, float(value)))
            before = end
    return AxisMotion(state, tuple(inputs))


def _input_at(motion: AxisMotion[float], time: float) -> float:
    for duration, value in motion.inputs:
        if time <= duration:
            return value
        time -= duration
    return motion.inputs[-1][1]
