"""Look for a pair that comes close where bounds of the norm couple the axes: all axes at once, in floating point.

A motion is a vector z: per axis the state at time 0 and one input a piece. (δ, g) is linear in z, boxes are linear and
norms are quadratic constraints; a local search (SLSQP) climbs from a few pairs that pass, turn or cross.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass
from math import factorial
from typing import Any

import numpy as np

from swarmproof.margin.ascent import Candidate, slope
from swarmproof.margin.problem import Floats, Problem
from swarmproof.motion.integrator import AxisMotion
from swarmproof.theorem3.parameters import Reading

#: Pieces of constant input where it may be any function; all change their length with τ.
PIECES = 6
#: What a start keeps free of every bound, and how far inside the bounds the search stays, relatively.
START, INSIDE = 0.9, 1e-9
#: Steps of τ/T_c by which the best pair is shifted.
STEPS = (0.1, 0.03, 0.01)


@dataclass(frozen=True)
class _Form:
    """Rows that give one derivative at one time from the unknowns of one axis, and its bounds."""

    row: Floats
    boxes: tuple[float, float, float]
    norm: float


class Climb:
    """The search in one window."""

    def __init__(self, problem: Problem, window: int) -> None:
        self._problem, self._window = problem, window
        self._sampled = problem.reading is Reading.AS_SAMPLED
        self._pieces = 1 if self._sampled else PIECES
        self._order, self._size = problem.order, problem.order - 1 + self._pieces

    def candidates(self) -> Iterator[Candidate]:
        """Yield what the search reaches from each start, and from the best of them at other times τ."""
        best: tuple[Candidate, Floats] | None = None
        for speed, turn, bend in self._starts():
            durations = self._durations(0.5)
            start = self._start(self._bounded(durations), durations, speed, turn, bend)
            best = yield from self._better(best, 0.5, start)
        for step in STEPS:
            for way in (-step, step):
                if best is not None and best[0].dip < self._problem.distance:
                    best = yield from self._better(best, min(max(best[0].fraction + way, 0.05), 0.95), best[1])

    def _better(
        self, best: tuple[Candidate, Floats] | None, fraction: float, start: Floats
    ) -> Generator[Candidate, None, tuple[Candidate, Floats] | None]:
        """Yield what is reached from a start, shape (3, size), and return it if it is better than the best."""
        found = self._climb(fraction, start)
        if found is None:
            return best
        yield found[0]
        return found if best is None or found[0].dip > best[0].dip else best

    def _starts(self) -> Iterator[tuple[Floats, Floats, float]]:
        """Yield directions of the speed and of the acceleration, and how much of the bounds the latter may take.

        They lie in the axes in which UAVs are fastest, scaled, and between them.
        """
        fast = np.array([bounds.bound(1) for bounds in self._problem.axes])
        ways = np.linalg.eigh(self._problem.scaling)[1].T
        x, y, z = sorted(ways, key=lambda way: -float(np.linalg.norm(self._problem.scaling @ (way * fast))))
        for speed, turn, bend in (
            (x, y, 0.1),
            (x + y, x - y, 0.5),
            (x - y, x + y + z, 0.1),
            (x + y, z, 0.5),
            (x, x, 0.9),
        ):
            yield speed / np.linalg.norm(speed), turn / np.linalg.norm(turn), bend

    def _durations(self, fraction: float) -> Floats:
        """Return the length of each piece, s: half of them before τ."""
        if self._sampled:
            return np.array([self._problem.period])
        half, length = self._pieces // 2, self._problem.window_length
        return length * np.concatenate([np.full(half, fraction / half), np.full(half, (1 - fraction) / half)])

    def _row(self, durations: Floats, time: float, derivative: int) -> Floats:
        """Return the coefficients of a derivative at `time` in (w'(0), …, inputs); that of w(0) is left out."""
        row = np.zeros(self._size)
        for m in range(max(derivative, 1), self._order):
            row[m - 1] = time ** (m - derivative) / factorial(m - derivative)
        power, begin = self._order - derivative, 0.0
        for piece, duration in enumerate(durations):
            if time > begin:
                gone, rest = time - begin, max(time - begin - duration, 0.0)
                row[self._order - 1 + piece] = (gone**power - rest**power) / factorial(power)
            begin += duration
        return row

    def _moved(self, durations: Floats, fraction: float) -> Floats:
        """Return the rows of δ and g, shape (2, size)."""
        start, length = self._problem.start_of(self._window), self._problem.window_length
        first, here, last = (
            self._row(durations, time, 0) for time in (start, start + fraction * length, start + length)
        )
        return np.stack([last - first, (1 - fraction) * first + fraction * last - here])

    def _bounded(self, durations: Floats) -> list[_Form]:
        """Return what is bounded; speeds between nodes by control points, so that they keep the bound all the time."""
        problem = self._problem
        if self._sampled:
            count = round(problem.period / float(problem.parameters.T_b))
            times = [k * problem.period / count for k in range(count + 1)]
        elif problem.reading is Reading.WHOLE_MOTION:
            times = [0.0, *np.cumsum(durations)]
        else:
            times = [0.0]
        forms = [self._form(self._row(durations, time, m), m) for time in times for m in range(1, self._order)]
        if problem.reading is Reading.WHOLE_MOTION and self._order == 3:
            for begin, duration in zip(times, durations, strict=False):
                control = self._row(durations, begin, 1) + duration / 2 * self._row(durations, begin, 2)
                forms.append(self._form(control, 1))
        inputs = np.eye(self._size)[self._order - 1 :]
        return [*forms, *(self._form(row, self._order) for row in inputs)]

    def _form(self, row: Floats, derivative: int) -> _Form:
        axes, norm = self._problem.axes, self._problem.norms[derivative - 1]
        x, y, z = (float(a.input if derivative == self._order else dict(a.derivatives)[derivative]) for a in axes)
        return _Form(row, (x, y, z), float("inf") if norm is None else float(norm))

    def _start(self, forms: list[_Form], durations: Floats, speed: Floats, turn: Floats, bend: float) -> Floats:
        """Return a motion along `speed` that accelerates along `turn`, inside all bounds, shape (3, size).

        The acceleration comes first and takes up to `bend` of every bound, the speed what is left.
        """
        steady, turning = np.zeros((3, self._size)), np.zeros((3, self._size))
        moving = np.array([bounds.bound(1) > 0 for bounds in self._problem.axes])
        turn = np.where(moving & np.array([bounds.input > 0 for bounds in self._problem.axes]), turn, 0.0)
        middle = float(durations.sum()) / 2
        steady[:, 0] = np.where(moving, speed, 0.0)
        # an acceleration of 1 all the time, with no speed in the middle
        turning[:, 0] = -middle * turn
        turning[:, 1 if self._order == 3 else slice(1, None)] = turn[:, None] if self._order == 2 else turn
        total = np.zeros((3, self._size))
        for motion, share in ((turning, bend), (steady, 1.0)):
            low, high = 0.0, 1e12
            for _ in range(120):
                size = (low + high) / 2 if low else high / 2
                low, high = (size, high) if _inside(forms, total + size * motion, START * share) else (low, size)
                if high < 1e-12:
                    break
            total = total + low * motion
        return total

    def _climb(self, fraction: float, start: Floats) -> tuple[Candidate, Floats] | None:
        """Return what the local search reaches from a start, with its unknowns; None if it gets lost."""
        from scipy.optimize import minimize  # a second to import

        solver: Any = minimize
        problem = self._problem
        durations = self._durations(fraction)
        forms = self._bounded(durations)
        unit = np.array([max(self._scale(forms, i), 1e-300) for i in range(self._size)])
        norms = [form for form in forms if 0 < form.norm < 1e300]
        rows = np.array([form.row * unit / form.norm for form in norms]).reshape(len(norms), self._size)
        boxed = [(form.row * unit / form.boxes[k], k) for form in forms for k in range(3) if form.boxes[k] > 0]
        flat = np.zeros((len(boxed), 3 * self._size))
        for i, (row, k) in enumerate(boxed):
            flat[i, k * self._size : (k + 1) * self._size] = row
        still = [k * self._size + i for k in range(3) for i in range(self._size) if self._held(k, i)]
        moved = self._moved(durations, fraction) * unit

        def objective(z: Floats) -> tuple[float, Floats]:
            shape = z.reshape(3, self._size)
            delta, sagitta = (shape @ moved.T).T
            at = slope(problem, delta, sagitta, fraction)
            gradient = np.outer(at.delta, moved[0]) + np.outer(at.sagitta, moved[1])
            return -at.closeness / problem.distance, -gradient.ravel() / problem.distance

        def inside(z: Floats) -> Floats:
            lengths = ((rows @ z.reshape(3, self._size).T) ** 2).sum(axis=1)
            return np.concatenate([1 - INSIDE - lengths, 1 - INSIDE - flat @ z, 1 - INSIDE + flat @ z])

        def slopes(z: Floats) -> Floats:
            values = rows @ z.reshape(3, self._size).T
            squared = -2 * np.einsum("ij,ik->ijk", values, rows).reshape(len(rows), values.shape[1] * self._size)
            return np.vstack([squared, -flat, flat])

        limits = [(0.0, 0.0) if i in still else (None, None) for i in range(3 * self._size)]
        result = solver(
            objective,
            (start / unit).ravel(),
            jac=True,
            method="SLSQP",
            bounds=limits,
            constraints=[{"type": "ineq", "fun": inside, "jac": slopes}],
            options={"maxiter": 200, "ftol": 1e-13},
        )
        motion = np.asarray(result.x).reshape(3, self._size) * unit
        if not np.isfinite(motion).all():
            return None
        motions = tuple(self._axis(row, durations) for row in motion)
        delta, sagitta = (motion @ self._moved(durations, fraction).T).T
        reached = slope(problem, delta, sagitta, fraction).closeness
        return Candidate(self._window, fraction, motions, problem.distance + min(reached, 0.0)), motion

    def _scale(self, forms: list[_Form], unknown: int) -> float:
        """Return about how large an unknown can be."""
        derivative = min(unknown + 1, self._order)
        own = [form for form in forms if np.count_nonzero(form.row) == 1 and form.row[unknown]]
        sizes = [min(max(form.boxes), form.norm) / abs(form.row[unknown]) for form in own]
        return max(sizes, default=0.0) or float(derivative)

    def _held(self, axis: int, unknown: int) -> bool:
        """Say whether an unknown must be 0."""
        bounds = self._problem.axes[axis]
        derivative = unknown + 1
        return (bounds.input if derivative >= self._order else dict(bounds.derivatives)[derivative]) == 0

    def _axis(self, row: Floats, durations: Floats) -> AxisMotion[float]:
        state = (0.0, *(float(value) for value in row[: self._order - 1]))
        inputs = zip(durations, row[self._order - 1 :], strict=True)
        return AxisMotion(state, tuple((float(duration), float(value)) for duration, value in inputs))


def _inside(forms: list[_Form], motion: Floats, share: float) -> bool:
    """Say whether a motion, shape (3, size), keeps `share` of every bound."""
    for form in forms:
        values = motion @ form.row
        if np.any(np.abs(values) > share * np.array(form.boxes)) or float(values @ values) > (share * form.norm) ** 2:
            return False
    return True
