"""Which motion of one axis maximises αδ + βg, in each reading, and why none does better.

One small class a reading; all answer the same question, :meth:`Extremes.at`.
"""

from __future__ import annotations

from itertools import combinations
from typing import Protocol

import numpy as np

from swarmproof.errors import BadInput
from swarmproof.margin.functional import Density, Extreme, Moment, Term, initial_coefficients, kernel, sign_changes
from swarmproof.margin.problem import AxisBounds, Floats, Problem
from swarmproof.margin.whole import WholeMotion
from swarmproof.motion.integrator import AxisMotion
from swarmproof.theorem3.parameters import Reading


class Extremes(Protocol):
    """What a reading must answer."""

    def at(self, moment: Moment, alpha: float, beta: float) -> Extreme:
        """Return a motion with a large αδ + βg, and multipliers for a bound close to the largest."""
        ...

    def motion(self, moment: Moment, alpha: float, beta: float) -> AxisMotion[float]:
        """Return the motion with the largest αδ + βg, as well as is known."""
        ...


class InitialState:
    """`initial-state`: nothing is bounded after time 0 but the input, so the kernel's sign says everything."""

    def __init__(self, bounds: AxisBounds, order: int) -> None:
        self._bounds = bounds
        self._order = order

    def motion(self, moment: Moment, alpha: float, beta: float) -> AxisMotion[float]:
        """Return the bang-bang motion."""
        return self.at(moment, alpha, beta).motion

    def at(self, moment: Moment, alpha: float, beta: float) -> Extreme:
        """Return the bang-bang motion; the multipliers are only breakpoints at the sign changes of the kernel."""
        terms = moment.terms(alpha, beta)
        breaks = np.unique([0.0, moment.tau, moment.length])
        turns = sorted(sign_changes(terms, self._order, breaks))
        breaks = np.unique([*breaks, *turns])
        middles = (breaks[:-1] + breaks[1:]) / 2
        signs = np.sign(kernel(terms, self._order, middles))
        coefficients = initial_coefficients(terms, self._order)
        state = [0.0] + [float(np.sign(coefficients[m])) * self._bounds.bound(m) for m in range(1, self._order)]
        inputs = tuple(
            (float(width), float(sign) * float(self._bounds.input))
            for width, sign in zip(np.diff(breaks), signs, strict=True)
        )
        return Extreme(AxisMotion(tuple(state), inputs), tuple(Term(turn, 1, 0.0) for turn in turns))


class BoundedSpeed:
    """`whole-motion`, order 2: speed and acceleration are bounded all the time, which has a closed form."""

    def __init__(self, bounds: AxisBounds) -> None:
        self._speed, self._acceleration = bounds.bound(1), float(bounds.input)

    def motion(self, moment: Moment, alpha: float, beta: float) -> AxisMotion[float]:
        """Return full speed one way, full acceleration around τ, full speed the other way."""
        return self.at(moment, alpha, beta).motion

    def at(self, moment: Moment, alpha: float, beta: float) -> Extreme:
        """Return that motion, and densities for the times of full speed.

        αδ + βg = ∫ φ w' with φ = `first` before τ and `last` after it. If these differ in sign, acceleration is used as
        long as the integral of φ from its start stays below `height`, where a longer time no longer pays.
        """
        first, last = moment.rates(alpha, beta)
        tau, end = moment.tau, moment.length
        sign = 1.0 if last > 0 or (last == 0 and first >= 0) else -1.0
        if first * last >= 0:
            pieces = [(0.0, tau, first), (tau, end, last)]
            motion = AxisMotion((0.0, sign * self._speed), ((end, 0.0),))
            return Extreme(motion, tuple(Density(a, b, 1, rate, rate) for a, b, rate in pieces if b > a))
        height = min(abs(first) * tau, abs(last) * (end - tau))
        if self._acceleration > 0:
            height = min(height, 2 * self._speed / (self._acceleration * (1 / abs(first) + 1 / abs(last))))
        start, stop = tau - height / abs(first), tau + height / abs(last)
        shortest = 1e-9 * end  # a shorter time at full speed is none
        start, stop = start if start > shortest else 0.0, stop if stop < end - shortest else end
        gain = self._acceleration * (stop - start)
        before = -self._speed if start > 0 or stop >= end else self._speed - gain
        parts = ((start, 0.0), (stop - start, sign * self._acceleration), (end - stop, 0.0))
        motion = AxisMotion((0.0, sign * before), tuple(part for part in parts if part[0] > 0))
        pieces = [(0.0, start, first), (stop, end, last)]
        return Extreme(motion, tuple(Density(a, b, 1, rate, rate) for a, b, rate in pieces if b > a))


#: More samples of the state bounds in one period than this make the enumeration of corners slow.
MOST_SAMPLES = 10


class Sampled:
    """`as-sampled`: a motion is (w'(0), …, u), bounded by finitely many half-spaces; all corners are known."""

    def __init__(self, problem: Problem, axis: AxisBounds) -> None:
        given, order = problem.parameters, problem.order
        self._order, self._period = order, problem.period
        bounds = dict(axis.derivatives)
        samples = int(given.T_s / given.T_b)
        if samples > MOST_SAMPLES:
            raise BadInput(
                f"T_s = {float(given.T_s):g} s is {samples} times T_b: as-sampled takes up to {MOST_SAMPLES}"
            )
        terms = [Term(k * float(given.T_b), derivative, 1.0) for k in range(samples + 1) for derivative in bounds]
        unit = np.zeros(order)
        unit[-1] = 1.0
        #: Where a bound holds (None: that of the input), its row over (w'(0), …, u), of length 1, and its level.
        self._terms: list[Term | None] = [*terms, None]
        rows = np.array([*(self._row([term]) for term in terms), unit])
        self._lengths = np.linalg.norm(rows, axis=1)
        self._rows = rows / self._lengths[:, None]
        limits = [*(float(bounds[term.derivative]) for term in terms), float(axis.input)]
        self._levels = np.array(limits) / self._lengths
        self._enumerate()

    def _row(self, terms: list[Term]) -> Floats:
        """Return the coefficients of a sum of terms in w'(0), …, u (that of w(0) is left out)."""
        last = sum(
            term.weight * term.time ** (self._order - term.derivative) / _FACTORIAL[self._order - term.derivative]
            for term in terms
        )
        return np.array([*initial_coefficients(terms, self._order)[1:], last])

    def _enumerate(self) -> None:
        """Find all feasible bases: as many rows as unknowns, each at one of its two bounds."""
        size = self._rows.shape[1]
        signs = np.array(np.meshgrid(*[[1.0, -1.0]] * size)).reshape(size, -1).T
        allowed = self._levels + 1e-10 * (1 + float(self._levels.max()))
        chosen, inverses, corners = [], [], []
        for some in combinations(range(len(self._rows)), size):
            basis = self._rows[list(some)]
            if abs(np.linalg.det(basis)) < 1e-10:
                continue
            inverse = np.linalg.inv(basis)
            for sign in signs:
                corner = inverse @ (sign * self._levels[list(some)])
                if np.all(np.abs(self._rows @ corner) <= allowed):
                    chosen.append((some, sign))
                    inverses.append(inverse)
                    corners.append(corner)
        self._bases = chosen
        self._inverses = np.array(inverses)
        self._signs = np.array([sign for _, sign in chosen])
        self._corners = np.array(corners)

    def motion(self, moment: Moment, alpha: float, beta: float) -> AxisMotion[float]:
        """Return the best corner."""
        return self.at(moment, alpha, beta).motion

    def _motion(self, corner: Floats) -> AxisMotion[float]:
        state = (0.0, *(float(value) for value in corner[:-1]))
        return AxisMotion(state, ((self._period, float(corner[-1])),))

    def at(self, moment: Moment, alpha: float, beta: float) -> Extreme:
        """Return the best corner, and the multipliers of a basis that is optimal for this functional."""
        target = self._row(moment.terms(alpha, beta))
        weights = np.einsum("j,ijk->ik", target, self._inverses) * self._signs
        best = int(np.argmax(weights.min(axis=1)))
        some, sign = self._bases[best]
        multipliers = []
        for index, weight in zip(some, weights[best] * sign, strict=True):
            term = self._terms[index]
            if term is not None and term.time > 0:
                multipliers.append(Term(term.time, term.derivative, float(weight / self._lengths[index])))
        return Extreme(self._motion(self._corners[best]), tuple(multipliers))


_FACTORIAL = (1, 1, 2, 6)


def extremes(problem: Problem, axis: AxisBounds) -> Extremes:
    """Return what answers for an axis with these bounds in the problem's reading.

    Raises:
        BadInput: `as-sampled` with more than :data:`MOST_SAMPLES` bound samples a period.
    """
    if problem.reading is Reading.INITIAL_STATE:
        return InitialState(axis, problem.order)
    if problem.reading is Reading.WHOLE_MOTION:
        return WholeMotion(axis) if problem.order == 3 else BoundedSpeed(axis)
    return Sampled(problem, axis)
