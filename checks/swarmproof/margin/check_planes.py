"""The half-planes of a margin certificate, their proofs and polygons, checked exactly. See `margin.check`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import factorial, gcd, lcm, perm
from typing import Any

from swarmproof.margin.check_motions import Problem
from swarmproof.margin.check_numbers import (
    Vector,
    dot,
    integer,
    list_of,
    located,
    need,
    number_of,
    numbers_of,
    object_of,
    scaled,
)

#: A corner (δ, g) as the integers (Wδ, Wg, W), W > 0: as exact as fractions, and faster.
Corner = tuple[int, int, int]
Polygon = list[Corner]


# ---- The polygons: half-planes with proofs ----
def _weights(
    problem: Problem, lowest: int, start: Fraction, tau: Fraction, direction: Vector, proof: list[Any]
) -> Vector:
    """Return what each bound, by derivative with the input last, is multiplied with in the bound of αδ + βg at tau.

    Multipliers may be for derivatives from `lowest` on. αδ + βg minus them is a sum of terms c·w^(d)(t), kept in
    integers: t in 1/`unit`, c in 1/`whole`.
    """
    (alpha, beta), order = direction, problem.order
    end, share = start + problem.span, tau / problem.span
    rest = [(start, 0, beta * (1 - share) - alpha), (end, 0, beta * share + alpha), (start + tau, 0, -beta)]
    points, paid, spread = [], [0] * (order + 1), [Fraction(0)] * (order + 1)
    for i, one in enumerate(proof):
        if len(list_of(proof, i)) == 5:
            d, (low, high, first, last) = integer(one, 2, 1, order - 1), [number_of(one, j) for j in (0, 1, 3, 4)]
            need(problem.reading == "whole-motion" and 0 <= low < high <= problem.span, "a density has no such times")
            need(d == 2 or first == last, "a density for derivative 1 has different rates")
            spread[d] += (abs(first) + abs(last)) / 2 * (high - low)
            slope = (last - first) / (high - low)  # integrated by parts, a density is such terms, too
            rest += [(high, d - 1, -last), (low, d - 1, first), (high, 0, slope), (low, 0, -slope)]
        else:
            one = list_of(proof, i, 3)
            points.append((number_of(one, 0), integer(one, 1, lowest, order - 1), number_of(one, 2)))
    unit = lcm(problem.step.denominator, problem.until.denominator, *(t.denominator for t, _, _ in (*rest, *points)))
    whole = lcm(*(c.denominator for _, _, c in (*rest, *points)))
    terms = [(scaled(t, unit), d, scaled(c, whole)) for t, d, c in rest]
    until, step = scaled(problem.until, unit), scaled(problem.step, unit) or 1
    for time, d, nu in points:
        t, c = scaled(time, unit), scaled(nu, whole)
        need(c == 0 or (0 <= t <= until and t % step == 0), "a multiplier is at a time when nothing is bounded")
        paid[d] += abs(c)
        terms.append((t, d, -c))
    # What is left has at w^(k)(0) the coefficient that it yields for the motion t^k/k!; for k = order this is ∫q.
    powers = [sum(c * unit**d * perm(k, d) * t ** (k - d) for t, d, c in terms if d <= k) for k in range(order + 1)]
    left = [Fraction(abs(power), whole * unit**k * factorial(k)) for k, power in enumerate(powers)]
    if problem.reading != "as-sampled":
        left[order] = Fraction(_integral(order, unit, terms), 6 * whole * unit**order * factorial(order - 1))
    return tuple(Fraction(paid[k], whole) + spread[k] + left[k] for k in range(order + 1))


def _integral(order: int, unit: int, terms: list[tuple[int, int, int]]) -> int:
    """Return a bound of 6∫|q| for q(s), the sum of c·unit^d·(d/dt)^d (t − s)^(order − 1) over the terms with t > s ≥ 0.

    From piece to piece, the last first, q is k0 + k1·s + k2·s² (also for order 2, where k2 = 0). Its Bernstein
    coefficients on [low, high] are its polar form at (low, low), (low, high) and (high, high).
    """
    k0 = k1 = k2 = total = 0
    later = sorted((term for term in terms if term[0] > 0), reverse=True)
    for (high, d, c), (low, _, _) in pairwise([*later, (0, 0, 0)]):
        c *= unit**d * perm(order - 1, d)
        f0, f1, f2 = ((1, 0, 0), (high, -1, 0), (high * high, -2 * high, 1))[order - 1 - d]
        k0, k1, k2 = k0 + c * f0, k1 + c * f1, k2 + c * f2
        polar = [2 * k0 + k1 * (x + y) + 2 * k2 * x * y for x, y in ((low, low), (low, high), (high, high))]
        total += (high - low) * sum(map(abs, polar))
    return total


@dataclass(frozen=True)
class Edge:
    """A half-plane αδ + βg ≤ c and its opposite, whatever the bounds of the motion are."""

    way: Vector  #: α and β
    weights: tuple[Vector, Vector]  #: what the bounds are multiplied with in c at a cell's two ends, by derivative

    def offset(self, problem: Problem, length: Fraction, bounds: Vector) -> Fraction:
        """Return c in all of a cell of this length, for a scalar motion with these bounds."""
        e = problem.bend(bounds) * length**2 / 8
        return max(dot(one, bounds) for one in self.weights) + abs(self.way[1]) * e

    @property
    def uses_positions(self) -> bool:
        """Say whether c depends on a bound of positions."""
        return any(one[0] for one in self.weights)


def edges_of(problem: Problem, lowest: int, start: Fraction, ends: Vector, edges: list[Any]) -> list[Edge]:
    """Return the edges that hold in a cell from ends[0] to ends[1] of the window that begins at `start`."""
    found = []
    for number, one in enumerate(edges):
        with located(f"edge {number}"):
            edge = object_of(one, "direction proofs")
            way, proofs = numbers_of(edge, "direction", 2), list_of(edge, "proofs", 2)
            need(any(way), "the direction is (0, 0)")
            first, last = (_weights(problem, lowest, start, ends[n], way, list_of(proofs, n)) for n in (0, 1))
            found.append(Edge(way, (first, last)))
    return found


def clip(polygon: Polygon, a: Fraction, b: Fraction, c: Fraction) -> Polygon:
    """Return the part of a convex polygon in which aδ + bg ≤ c; without corners if it is empty."""
    scale = lcm(a.denominator, b.denominator, c.denominator)
    na, nb, nc = scaled(a, scale), scaled(b, scale), scaled(c, scale)
    values, kept = [na * x + nb * y - nc * w for x, y, w in polygon], []
    for i, (corner, value) in enumerate(zip(polygon, values, strict=True)):
        before, value_before = polygon[i - 1], values[i - 1]
        if value < 0 < value_before or value_before < 0 < value:  # the line crosses this side
            x, y, w = (abs(value_before) * p + abs(value) * q for p, q in zip(corner, before, strict=True))
            common = gcd(x, y, w)
            kept.append((x // common, y // common, w // common))
        if value <= 0:
            kept.append(corner)
    return kept


def polygon_of(offsets: dict[Vector, Fraction]) -> Polygon:
    """Return the corners of the polygon with |αδ + βg| ≤ offset for each direction (α, β)."""
    need({(1, 0), (0, 1)} <= offsets.keys(), "(1, 0) or (0, 1) is not among the directions")
    far, off = offsets[Fraction(1), Fraction(0)], offsets[Fraction(0), Fraction(1)]
    scale = lcm(far.denominator, off.denominator)
    x, y = scaled(far, scale), scaled(off, scale)
    polygon = [(x, y, scale), (-x, y, scale), (-x, -y, scale), (x, -y, scale)]
    for (alpha, beta), offset in offsets.items():
        polygon = clip(clip(polygon, alpha, beta, offset), -alpha, -beta, offset)
    return polygon


# ---- Bounds of the norm: quadratic forms over polygons ----
def largest(form: Vector, polygon: Polygon) -> Fraction:
    """Return the maximum of pδ² + 2rδg + sg², where form = (p, r, s), over a convex polygon with at least one corner.

    The polygon must not have the origin in its interior. A maximum in the interior is where the gradient vanishes, so
    it is 0 and the form is nowhere positive; then the form vanishes on a line through that place and the origin,
    and this line crosses the boundary. So the boundary is enough.
    """
    whole = lcm(*(x.denominator for x in form))
    p, r, s = (scaled(x, whole) for x in form)
    best, below = None, 1  # the largest value so far is best/below/whole
    for (x0, y0, w0), (x1, y1, w1) in zip([polygon[-1], *polygon], polygon, strict=False):
        top, under = p * x1 * x1 + 2 * r * x1 * y1 + s * y1 * y1, w1 * w1
        if best is None or top * below > best * under:
            best, below = top, under
        # From one corner to the next, both times w0·w1, the form is `first` + 2·`slope`·σ + `bent`·σ² for 0 ≤ σ ≤ 1.
        x, y, dx, dy = x0 * w1, y0 * w1, x1 * w0 - x0 * w1, y1 * w0 - y0 * w1
        slope = p * x * dx + r * (x * dy + y * dx) + s * y * dy
        bent = p * dx * dx + 2 * r * dx * dy + s * dy * dy
        if 0 < slope < -bent:
            first = p * x * x + 2 * r * x * y + s * y * y
            top, under = slope * slope - first * bent, -bent * (w0 * w1) ** 2
            if top * below > best * under:
                best, below = top, under
    assert best is not None
    return Fraction(best, below * whole)


def form_of(factor: Fraction, kappa: Fraction, t: Fraction, share: Fraction, spent: Iterable[Fraction]) -> Vector:
    """Return factor·(κδ² + (g + tδ)²/θ) minus the form `spent`, as what (δ², 2δg, g²) are multiplied with."""
    left = (kappa + t * t / share, t / share, 1 / share)
    return tuple(factor * x - y for x, y in zip(left, spent, strict=True))
