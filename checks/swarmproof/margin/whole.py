"""`whole-motion`, order 3: bounds at all times. Linear programs on a grid propose motions and proofs."""

from __future__ import annotations

import numpy as np

from swarmproof.margin.dual import best_multipliers
from swarmproof.margin.functional import (
    Density,
    Extreme,
    Moment,
    Multiplier,
)
from swarmproof.margin.problem import AxisBounds, Floats
from swarmproof.margin.programs import maximise
from swarmproof.motion.integrator import AxisMotion

#: Equal pieces of [0, T_c] in the first linear program.
PIECES = 16
#: How often the grid of a motion is refined where it changes its mode.
REFINEMENTS = 2
#: The shortest piece that is added, relative to T_c.
SHORTEST = 1e-4


class WholeMotion:
    """Extremes under bounds that hold at all times, to the accuracy of a grid that is refined where it matters."""

    def __init__(self, bounds: AxisBounds) -> None:
        self._bounds = {derivative: float(bound) for derivative, bound in bounds.derivatives}
        self._input = float(bounds.input)
        self._proved: dict[tuple[Moment, float, float], Extreme] = {}

    def at(self, moment: Moment, alpha: float, beta: float) -> Extreme:
        """Return a motion on a coarse grid, and the multipliers of the best proof on a grid refined for it."""
        key = (moment, alpha, beta)
        if key not in self._proved:
            motion, nodes = self._solve(moment, alpha, beta, 1)
            first, last = moment.rates(alpha, beta)
            if nodes is None:
                ends = (0.0, moment.tau, moment.length)
                whole = [
                    Density(a, b, 1, rate, rate) for a, b, rate in zip(ends, ends[1:], (first, last), strict=False)
                ]
                multipliers: list[Multiplier] = [density for density in whole if density.end > density.start]
            else:
                rates = np.where(nodes[1:] <= moment.tau, first, last)
                multipliers = best_multipliers(nodes, rates, self._bounds, self._input)
            self._proved[key] = Extreme(motion, tuple(multipliers))
        return self._proved[key]

    def motion(self, moment: Moment, alpha: float, beta: float) -> AxisMotion[float]:
        """Return a motion that keeps all bounds, with αδ + βg as large as on a finer grid."""
        return self._solve(moment, alpha, beta, 1 + REFINEMENTS)[0]

    def _solve(
        self, moment: Moment, alpha: float, beta: float, programs: int
    ) -> tuple[AxisMotion[float], Floats | None]:
        """Return a motion and the grid that suits it; no grid if constant velocity is best."""
        first, last = moment.rates(alpha, beta)
        # αδ + βg = ∫ φ w' with φ = first before τ and last after it: of one sign, nothing beats constant velocity
        speed = self._bounds[1] * (1.0 if first + last >= 0 else -1.0)
        best = AxisMotion((0.0, speed, 0.0), ((moment.length, 0.0),))
        if first * last >= 0:
            return best, None
        nodes = np.linspace(0, moment.length, PIECES + 1)
        inner = np.abs(nodes[1:-1] - moment.tau) > 0.2 * moment.length / PIECES
        nodes = np.union1d(nodes[[True, *inner, True]], [moment.tau])
        for _ in range(programs):
            solution = self._program(nodes, np.where(nodes[1:] <= moment.tau, first, last))
            if solution is None:
                break
            best = solution
            nodes = _refined(nodes, self._held(best, nodes), best)
        return self._kept(best), nodes

    def _held(self, motion: AxisMotion[float], nodes: Floats) -> list[int]:
        """Return per piece the lowest derivative that is at its bound at both ends; 3 where none is."""
        states = np.array([motion.at(float(time)) for time in nodes])
        held = [3] * (len(nodes) - 1)
        for derivative in (2, 1):
            tight = np.abs(states[:, derivative]) >= self._bounds[derivative] * (1 - 1e-7)
            held = [derivative if tight[i] and tight[i + 1] else known for i, known in enumerate(held)]
        return held

    def _program(self, nodes: Floats, rates: Floats) -> AxisMotion[float] | None:
        """Maximise ∫ φ w' with one jerk a piece and bounds at the nodes; `rates` is φ per piece.

        None where the solver gives up, which only makes the bound that is proved a little weaker.
        """
        from scipy.sparse import coo_array

        # unknowns, with T_c as the unit of time: velocity and acceleration per node, jerk per piece
        length = float(nodes[-1])
        widths, pieces = np.diff(nodes) / length, len(rates)
        speed, acceleration, jerk = self._bounds[1], self._bounds[2] * length, self._input * length**2
        v, a, j = np.arange(pieces), pieces + 1 + np.arange(pieces), 2 * pieces + 2 + np.arange(pieces)
        ones, rows = np.ones(pieces), np.arange(pieces)
        entries = [
            (rows, v + 1, ones),
            (rows, v, -ones),
            (rows, a, -widths),
            (rows, j, -(widths**2) / 2),
            (pieces + rows, a + 1, ones),
            (pieces + rows, a, -ones),
            (pieces + rows, j, -widths),
        ]
        row, column, value = (np.concatenate(part) for part in zip(*entries, strict=True))
        matrix = coo_array((value, (row, column)), shape=(2 * pieces, 3 * pieces + 2))
        target = np.zeros(3 * pieces + 2)
        target[v], target[a], target[j] = rates * widths, rates * widths**2 / 2, rates * widths**3 / 6
        limits = np.concatenate([np.full(pieces + 1, speed), np.full(pieces + 1, acceleration), np.full(pieces, jerk)])
        found = maximise(target / max(float(np.abs(rates).max()), 1e-300), matrix, limits)
        if found is None:
            return None
        found = np.clip(found, -limits, limits)
        inputs = tuple((float(w) * length, float(u) / length**2) for w, u in zip(widths, found[j], strict=True))
        return AxisMotion((0.0, float(found[0]), float(found[pieces + 1]) / length), inputs)

    def _kept(self, motion: AxisMotion[float]) -> AxisMotion[float]:
        """Return the motion, scaled down until its velocity keeps the bound between the nodes, too."""
        worst, time = 1.0, 0.0
        for duration, value in motion.inputs:
            if value:
                _, velocity, acceleration = motion.at(time)
                turn = -acceleration / value
                if 0 < turn < duration and self._bounds[1] > 0:
                    worst = max(worst, abs(velocity + acceleration * turn / 2) / self._bounds[1])
            time += duration
        return motion.scaled(1 / worst)


def _refined(nodes: Floats, held: list[int], motion: AxisMotion[float]) -> Floats:
    """Add nodes in and beside the pieces where the motion changes its mode, and in those at the ends."""
    inputs = np.array([value for _, value in motion.inputs])
    step = 0.02 * float(np.abs(inputs).max(initial=0.0))
    changed = [i for i in range(1, len(held)) if held[i] != held[i - 1] or abs(inputs[i] - inputs[i - 1]) > step]
    pieces = sorted({piece for i in changed for piece in (i - 1, i)} | {0, len(held) - 1})
    extra = [nodes[i] + (nodes[i + 1] - nodes[i]) * share for i in pieces for share in (0.25, 0.5, 0.75)]
    merged = np.union1d(nodes, extra)
    # a piece that is too short makes the program ill-conditioned; given nodes stay
    keep = np.isin(merged, nodes) | (np.diff(merged, prepend=-1.0) > SHORTEST * nodes[-1])
    return np.asarray(merged[keep])
