"""Linear functionals αδ + βg of a motion, and their upper bounds by multipliers (docs/margin.md, "The polygons").

Floating point: what is found here is proposed to the exact checker, which computes every offset anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import factorial

import numpy as np

from swarmproof.margin.problem import AxisBounds, Floats
from swarmproof.motion.integrator import AxisMotion


@dataclass(frozen=True)
class Term:
    """`weight` times the `derivative`-th derivative of w at `time` (s)."""

    time: float
    derivative: int
    weight: float


@dataclass(frozen=True)
class Density:
    """∫ ρ(t) (the `derivative`-th derivative of w at t) dt, with ρ linear from `first` at `start` to `last` at `end`.

    ρ is constant for derivatives below the highest one, so that kernels stay quadratic.
    """

    start: float
    end: float
    derivative: int
    first: float
    last: float

    def atoms(self, after: float = 0.0) -> list[Term]:
        """Return terms that give the integral over times ≥ `after` for cubic integrands (two-point Gauss rule)."""
        low, high = max(self.start, after), self.end
        if low >= high:
            return []
        middle, half = (low + high) / 2, (high - low) / 2
        return [
            Term(time, self.derivative, half * self.rate(time))
            for time in (middle - half / 3**0.5, middle + half / 3**0.5)
        ]

    def rate(self, time: float) -> float:
        """Return ρ at `time`."""
        return self.first + (self.last - self.first) * (time - self.start) / (self.end - self.start)

    def minus(self) -> Density:
        """Return the density with the opposite sign."""
        return Density(self.start, self.end, self.derivative, -self.first, -self.last)


#: What may be subtracted from a functional at the price of the bound it meets.
Multiplier = Term | Density


@dataclass(frozen=True)
class Moment:
    """Where the three positions of (*) are taken: window start, closest approach and window end, in s."""

    start: float
    tau: float
    length: float

    @property
    def fraction(self) -> float:
        """Return τ/T."""
        return self.tau / self.length

    def terms(self, alpha: float, beta: float) -> list[Term]:
        """Return αδ + βg as a sum of positions; the weights add up to zero."""
        late = self.fraction
        return [
            Term(self.start, 0, -alpha + beta * (1 - late)),
            Term(self.start + self.tau, 0, -beta),
            Term(self.start + self.length, 0, alpha + beta * late),
        ]

    def rates(self, alpha: float, beta: float) -> tuple[float, float]:
        """Return φ before and after τ, where αδ + βg = ∫ φ w'."""
        return alpha - beta * (1 - self.fraction), alpha + beta * self.fraction

    def point(self, motion: AxisMotion[float]) -> tuple[float, float]:
        """Return (δ, g) of a motion."""
        first, here, last = (motion.position(self.start + time) for time in (0.0, self.tau, self.length))
        return last - first, (1 - self.fraction) * first + self.fraction * last - here


@dataclass(frozen=True)
class Extreme:
    """A motion that maximises a functional, and multipliers that prove (nearly) that none does better."""

    motion: AxisMotion[float]
    multipliers: tuple[Multiplier, ...]


def initial_coefficients(terms: Iterable[Multiplier], order: int) -> list[float]:
    """Return the coefficients of w(0), w'(0) (and w''(0)) in a sum of terms (Taylor's formula)."""
    coefficients = [0.0] * order
    for term in (atom for given in terms for atom in (given.atoms() if isinstance(given, Density) else [given])):
        for m in range(term.derivative, order):
            coefficients[m] += term.weight * term.time ** (m - term.derivative) / factorial(m - term.derivative)
    return coefficients


def kernel(terms: Sequence[Multiplier], order: int, times: Floats) -> Floats:
    """Return q at `times`, where the terms' share of the input u is ∫ q(s) u(s) ds; no time may be a term's."""
    points = [term for term in terms if isinstance(term, Term)]
    ends = np.array([term.time for term in points])
    powers = np.array([order - 1 - term.derivative for term in points])
    scale = np.array([term.weight / factorial(order - 1 - term.derivative) for term in points])
    left = ends[None, :] - times[:, None]
    total = np.asarray(np.where(left > 0, np.abs(left) ** powers[None, :], 0.0) @ scale)
    for density in terms:
        if isinstance(density, Density):
            low = np.maximum(times, density.start)
            half = np.maximum(density.end - low, 0.0) / 2
            power = order - 1 - density.derivative
            for root in (-(3**-0.5), 3**-0.5):
                at = low + half * (1 + root)
                slope = (density.last - density.first) / (density.end - density.start)
                rate = density.first + slope * (at - density.start)
                total = total + half * rate * (at - times) ** power / factorial(power)
    return total


def bernstein(terms: Sequence[Multiplier], order: int, breaks: Floats) -> Floats:
    """Return q's three Bernstein coefficients on each piece between neighbouring `breaks`, shape (pieces, 3).

    Every term's time must be among the breaks or outside them, so that q is a quadratic polynomial on each piece.
    """
    widths = np.diff(breaks)
    at = breaks[:-1, None] + widths[:, None] * np.array([0.25, 0.5, 0.75])[None, :]
    values = kernel(terms, order, at.ravel()).reshape(at.shape)
    # from the values at 1/4, 1/2, 3/4 to the control points of the same quadratic
    to_control = np.array([[3.0, -3.0, 1.0], [-2.0, 5.0, -2.0], [1.0, -3.0, 3.0]])
    return np.asarray(values @ to_control.T)


def sign_changes(terms: Sequence[Multiplier], order: int, breaks: Floats) -> list[float]:
    """Return where q changes its sign inside the pieces between `breaks`."""
    found = []
    control = bernstein(terms, order, breaks)
    negligible = 1e-10 * float(np.abs(control).max(initial=0.0))
    for low, width, (b0, b1, b2) in zip(breaks, np.diff(breaks), control, strict=False):
        if min(b0, b1, b2) < -negligible and max(b0, b1, b2) > negligible:
            roots = np.roots([b0 - 2 * b1 + b2, 2 * (b1 - b0), b0])
            found += [
                low + width * root.real for root in roots if abs(root.imag) < 1e-12 and 1e-9 < root.real < 1 - 1e-9
            ]
    return found


def offset(
    moment: Moment,
    alpha: float,
    beta: float,
    multipliers: Sequence[Multiplier],
    bounds: AxisBounds,
    order: int,
    whole: float,
) -> float:
    """Return the proved bound of αδ + βg; `whole` is T_s if the input is constant over [0, T_s], else 0."""
    rest = remainder(moment, alpha, beta, multipliers)
    limits = {derivative: float(bound) for derivative, bound in bounds.derivatives}
    total = 0.0
    for used in multipliers:
        if isinstance(used, Density):
            total += (abs(used.first) + abs(used.last)) / 2 * (used.end - used.start) * limits[used.derivative]
        elif used.weight:
            total += abs(used.weight) * limits[used.derivative]
    for derivative, coefficient in enumerate(initial_coefficients(rest, order)):
        total += abs(coefficient) * limits.get(derivative, 0.0)
    if whole:
        terms = [term for term in rest if isinstance(term, Term)]
        powers = [order - term.derivative for term in terms]
        area = abs(sum(t.weight * t.time**p / factorial(p) for t, p in zip(terms, powers, strict=True)))
    else:
        breaks = breakpoints(moment, rest)
        area = float(np.diff(breaks) @ np.abs(bernstein(rest, order, breaks)).mean(axis=1))
    return total + area * float(bounds.input)


def remainder(moment: Moment, alpha: float, beta: float, multipliers: Sequence[Multiplier]) -> list[Multiplier]:
    """Return αδ + βg minus the multipliers."""
    minus = [m.minus() if isinstance(m, Density) else Term(m.time, m.derivative, -m.weight) for m in multipliers]
    return [*moment.terms(alpha, beta), *minus]


def breakpoints(moment: Moment, terms: Sequence[Multiplier]) -> Floats:
    """Return all times at which the kernel of `terms` may change its polynomial, with both ends of the motion."""
    inner = [time for m in terms for time in ((m.start, m.end) if isinstance(m, Density) else (m.time,))]
    return np.unique([0.0, moment.start + moment.length, *inner])
