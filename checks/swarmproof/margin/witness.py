"""From a pair found in floating point to two explicit trajectories in fractions, whose dip is exact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate

import numpy as np

from swarmproof.margin.ascent import Candidate, slope
from swarmproof.margin.functional import Moment
from swarmproof.margin.problem import Floats, Problem
from swarmproof.motion.integrator import AxisMotion
from swarmproof.theorem3.inequality import scaled_square, square_root_bounds
from swarmproof.theorem3.parameters import Reading
from swarmproof.theorem3.values import Vector, closed

Motion = tuple[AxisMotion[Fraction], ...]

#: Digits after the point that numbers of a witness keep.
DIGITS = 12


@dataclass(frozen=True)
class Witness:
    """Two reference trajectories, a window, and a time in it at which they have come closest (all exact, SI units).

    `tau` counts from the window's start, the motions from the start of the period (`as-sampled`) or of the window.
    `dip` is d̂_min minus their scaled distance at `tau`, rounded down.
    """

    window: int
    start: Fraction
    tau: Fraction
    uav_i: Motion
    uav_j: Motion
    dip: Fraction

    def relative(self, time: Fraction) -> Vector:
        """Return w = p̂_i − p̂_j (m) at `time`, counted from the start of the motions."""
        x, y, z = (i.position(time) - j.position(time) for i, j in zip(self.uav_i, self.uav_j, strict=True))
        return x, y, z


def rounded(value: float) -> Fraction:
    """Return the nearest decimal with :data:`DIGITS` digits after the point."""
    return Fraction(round(value * 10**DIGITS), 10**DIGITS)


def exact_witness(problem: Problem, candidate: Candidate, confined: bool = True) -> Witness | None:
    """Return the candidate as exact trajectories of both UAVs; None if no nearby pair is feasible.

    A workspace is kept to only if `confined`.
    """
    given = problem.parameters
    motions = []
    for axis, motion in enumerate(candidate.motions):
        exact = _exact(problem, motion)
        factor = _excess(problem, axis, exact)
        if factor is None:
            return None
        motions.append(exact.scaled(1 / factor) if factor > 1 else exact)
    if problem.coupled:
        longest = norm_excess(problem, motions)
        if longest is None:
            return None
        motions = [motion.scaled(1 / longest) for motion in motions] if longest > 1 else motions
    start = candidate.window * given.T_c if problem.reading is Reading.AS_SAMPLED else Fraction(0)
    tau = Fraction(round(candidate.fraction * 10**9), 10**9) * given.T_c
    offset = _place(problem, motions, start, tau)
    if offset is None:
        return None
    whole = [motion.shifted(shift) for motion, shift in zip(motions, offset, strict=True)]
    if confined and not _inside_workspace(problem, whole):
        return None
    centre = [(low + high) / 2 for low, high in closed(given.workspace)] if given.workspace else [Fraction(0)] * 3
    half = [motion.scaled(Fraction(1, 2)) for motion in whole]
    uav_i = tuple(motion.shifted(c) for motion, c in zip(half, centre, strict=True))
    uav_j = tuple(motion.scaled(Fraction(-1)).shifted(c) for motion, c in zip(half, centre, strict=True))
    return make_witness(problem, candidate.window, tau, uav_i, uav_j)


def make_witness(problem: Problem, window: int, tau: Fraction, uav_i: Motion, uav_j: Motion) -> Witness:
    """Return the witness of two motions, with its dip."""
    start = window * problem.parameters.T_c if problem.reading is Reading.AS_SAMPLED else Fraction(0)
    found = Witness(window, start, tau, uav_i, uav_j, Fraction(0))
    closest = scaled_square(problem.parameters.theta_inverse, found.relative(start + tau))
    distance = square_root_bounds(closest, DIGITS)[1]
    return replace(found, dip=max(problem.parameters.d_hat_min - distance, Fraction(0)))


def _exact(problem: Problem, motion: AxisMotion[float]) -> AxisMotion[Fraction]:
    """Return the motion with rounded numbers and durations that add up to the period."""
    given = problem.parameters
    period = given.T_s if problem.reading is Reading.AS_SAMPLED else given.T_c
    inputs: list[tuple[Fraction, Fraction]] = []
    end, before = 0.0, Fraction(0)
    for index, (duration, value) in enumerate(motion.inputs):
        end += duration
        here = period if index == len(motion.inputs) - 1 else min(rounded(end), period)
        if here > before:
            inputs.append((here - before, rounded(value)))
            before = here
    return AxisMotion(tuple(rounded(value) for value in motion.state), tuple(inputs))


def _excess(problem: Problem, axis: int, motion: AxisMotion[Fraction]) -> Fraction | None:
    """Return the largest ratio of a bounded quantity (but position) to its bound; None if one bounded by 0 is not 0."""
    bounds = problem.axes[axis]
    values = [(abs(value), bounds.input) for _, value in motion.inputs]
    times = [Fraction(0)]
    if problem.reading is Reading.AS_SAMPLED:
        step = problem.parameters.T_b
        times = [k * step for k in range(int(problem.parameters.T_s / step) + 1)]
    elif problem.reading is Reading.WHOLE_MOTION:
        for duration, value in motion.inputs:
            _, velocity, *acceleration = motion.at(times[-1])
            if acceleration and value and 0 < -acceleration[0] / value < duration:
                turning = velocity - acceleration[0] ** 2 / (2 * value)
                values.append((abs(turning), dict(bounds.derivatives)[1]))
            times.append(times[-1] + duration)
    for time in times:
        state = motion.at(time)
        values += [(abs(state[m]), bound) for m, bound in bounds.derivatives]
    if any(bound == 0 and value > 0 for value, bound in values):
        return None
    return max((value / bound for value, bound in values if bound > 0), default=Fraction(0))


def norm_excess(problem: Problem, motions: Sequence[AxisMotion[Fraction]]) -> Fraction | None:
    """Return a bound of the largest ratio of a norm to what bounds it; None if one bounded by 0 is not 0.

    All axes have the same pieces. Between their ends the speed is a quadratic curve, within its control points.
    """
    order, values = problem.order, []
    ends = [Fraction(0), *accumulate(duration for duration, _ in motions[0].inputs)]
    times = ends if problem.reading is Reading.WHOLE_MOTION else ends[:1]
    if problem.reading is Reading.AS_SAMPLED:
        times = [k * problem.parameters.T_b for k in range(int(problem.parameters.T_s / problem.parameters.T_b) + 1)]
    for time in times:
        states = [motion.at(time) for motion in motions]
        values += [(m, [state[m] for state in states]) for m in range(1, order)]
        if problem.reading is Reading.WHOLE_MOTION and order == 3 and time < ends[-1]:
            half = (ends[ends.index(time) + 1] - time) / 2
            values.append((1, [state[1] + half * state[2] for state in states]))
    for piece in range(len(motions[0].inputs)):
        values.append((order, [motion.inputs[piece][1] for motion in motions]))
    ratio = Fraction(0)
    for m, vector in values:
        bound, square = problem.norms[m - 1], sum((value**2 for value in vector), Fraction(0))
        if bound == 0 and square > 0:
            return None
        if bound:
            ratio = max(ratio, square / bound**2)
    return square_root_bounds(ratio)[1] if ratio > 1 else ratio


def _place(problem: Problem, motions: list[AxisMotion[Fraction]], start: Fraction, tau: Fraction) -> Vector | None:
    """Return the shift per axis (m) with both ends exactly d̂_min or more apart and the closest approach at `tau`."""
    given, distance = problem.parameters, problem.distance
    times = start, start + tau, start + given.T_c
    first, here, last = ([motion.position(time) for motion in motions] for time in times)
    moment = Moment(float(start), float(tau), float(given.T_c))
    fraction = moment.fraction
    w0, w, wt = (np.array([float(value) for value in values]) for values in (first, here, last))
    delta, sagitta = wt - w0, (1 - fraction) * w0 + fraction * wt - w
    here_scaled, outward_scaled = _closest(problem, delta, sagitta, fraction)
    position = np.linalg.solve(problem.scaling, here_scaled)
    outward = np.linalg.solve(problem.scaling, outward_scaled)
    through = not here_scaled.any()
    push = 0.0
    while push < 1e-3 * distance:
        x, y, z = (-here[k] if through else rounded(float(position[k] + push * outward[k])) - here[k] for k in range(3))
        shift: Vector = (x, y, z)
        ends = ((at[0] + x, at[1] + y, at[2] + z) for at in (first, last))
        if all(scaled_square(given.theta_inverse, end) >= given.d_hat_min**2 for end in ends):
            return shift
        if through:
            through, outward = False, np.linalg.solve(problem.scaling, np.ones(3))
        push = max(2 * push, 1e-12)
    return None


def _closest(problem: Problem, delta: Floats, sagitta: Floats, fraction: float) -> tuple[Floats, Floats]:
    """Return x = A w(τ) for the best place of a pair with this (δ, g), and where to push it so that both ends part."""
    best = slope(problem, delta, sagitta, fraction)
    if best.closeness >= 0:
        return np.zeros(3), np.zeros(3)
    weight = fraction + best.t
    chord, off = problem.scaling @ delta, problem.scaling @ (sagitta + best.t * delta)
    if not 1e-6 < weight < 1 - 1e-6:
        along = off / max(float(np.linalg.norm(off)), 1e-300)
        return -best.closeness * along, along
    # both ends are d̂_min away from the origin: the chord's middle is across the chord, on the side of the sagitta
    middle = problem.scaling @ (sagitta + (0.5 - fraction) * delta)
    length = float(np.linalg.norm(chord))
    unit = chord / length if length > 1e-12 * problem.distance else np.zeros(3)
    across = middle - float(middle @ unit) * unit
    if float(np.linalg.norm(across)) < 1e-9 * problem.distance:
        # any direction across the motion will do: take the axis with most room, among those that the motion leaves free
        space = problem.parameters.workspace
        room = [1.0] * 3 if space is None else [float(high - low) for low, high in closed(space)]
        free = np.abs(unit) < 0.9
        across = np.eye(3)[int(np.argmax(np.where(free, np.array(room) * np.diagonal(problem.scaling), -1.0)))]
        across = across - float(across @ unit) * unit
    across = across / float(np.linalg.norm(across))
    return across * np.sqrt(max(problem.distance**2 - length**2 / 4, 0.0)) - middle, across


def _inside_workspace(problem: Problem, motions: list[AxisMotion[Fraction]]) -> bool:
    """Say whether the pair fits into the workspace where the reading asks for it (the checker decides exactly)."""
    given = problem.parameters
    if given.workspace is None:
        return True
    times = [Fraction(0)]
    if problem.reading is Reading.AS_SAMPLED:
        times = [k * given.T_b for k in range(int(given.T_s / given.T_b) + 1)]
    elif problem.reading is Reading.WHOLE_MOTION:
        times = [given.T_c * k / 64 for k in range(65)]
    return all(
        abs(motion.position(time)) <= high - low
        for motion, (low, high) in zip(motions, closed(given.workspace), strict=True)
        for time in times
    )
