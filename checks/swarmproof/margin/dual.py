"""The best proof of αδ + βg ≤ c that a grid allows, for `whole-motion`, order 3: a linear program over polynomials.

αδ + βg = ∫ φ w' with φ constant before and after τ. Integrate by parts with ψ (linear on each piece) and χ (quadratic):
it is at most what the bounds allow for φ − ψ', for ψ − χ', for the kernel that remains, and for jumps.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from swarmproof.margin.functional import Density, Multiplier, Term
from swarmproof.margin.problem import Floats
from swarmproof.margin.programs import least_absolute


def best_multipliers(nodes: Floats, rates: Floats, bounds: Mapping[int, float], input_bound: float) -> list[Multiplier]:
    """Return multipliers at and between `nodes` (n + 1 times in s) with the smallest bound; `rates` is φ per piece.

    If the solver gives up they are those of constant velocity, which prove a weaker bound.
    """
    from scipy.sparse import coo_array

    pieces, wide = len(rates), 5  # per piece: ψ at both ends, three control points of χ
    # in units of the motion's length and of φ, so that the solver sees numbers near 1
    length, unit = float(nodes[-1]), float(np.abs(rates).max())
    widths = np.diff(nodes) / length
    speed, acceleration, jerk = bounds[1], bounds[2] * length, input_bound * length**2
    rows: list[tuple[dict[int, float], float, float]] = []  # (coefficients, constant, price): price·|row·x + constant|

    def psi(piece: int, end: int) -> int:
        return wide * piece + end

    def chi(piece: int, control: int) -> int:
        return wide * piece + 2 + control

    for i, width in enumerate(widths):
        rows.append(({psi(i, 0): 1 / width, psi(i, 1): -1 / width}, float(rates[i]) / unit, speed * width))
        for end in range(2):
            slope = {chi(i, end): 2 / width, chi(i, end + 1): -2 / width, psi(i, end): 1.0}
            rows.append((slope, 0.0, acceleration * width / 2))
        rows += [({chi(i, control): 1.0}, 0.0, jerk * width / 3) for control in range(3)]
    for i in range(pieces + 1):
        before, after = i > 0, i < pieces
        jump = ({psi(i - 1, 1): 1.0} if before else {}) | ({psi(i, 0): -1.0} if after else {})
        rows.append((jump, 0.0, speed))
        jump = ({chi(i - 1, 2): -1.0} if before else {}) | ({chi(i, 0): 1.0} if after else {})
        rows.append((jump, 0.0, acceleration))
    places = [(r, c, value) for r, (row, _, _) in enumerate(rows) for c, value in row.items()]
    matrix = coo_array(
        ([value for _, _, value in places], ([r for r, _, _ in places], [c for _, c, _ in places])),
        shape=(len(rows), wide * pieces),
    )
    prices = np.array([price for _, _, price in rows])
    found = least_absolute(prices, matrix, np.array([constant for _, constant, _ in rows]))
    solved = np.zeros(wide * pieces) if found is None else found
    sizes = np.array([length, length, length**2, length**2, length**2]) * unit
    return _multipliers(nodes, rates, solved.reshape(pieces, wide) * sizes)


def _multipliers(nodes: Floats, rates: Floats, values: Floats) -> list[Multiplier]:
    """Write ψ and χ as multipliers: atoms where they jump, densities where they do not follow φ and ψ."""
    atoms, densities = [], []
    padded = np.vstack([values, np.zeros(values.shape[1])])
    for time, before, after in zip(nodes[1:], values, padded[1:], strict=True):
        atoms.append(Term(float(time), 1, float(before[1] - after[0])))
        atoms.append(Term(float(time), 2, float(after[2] - before[4])))
    for start, end, rate, row in zip(nodes, nodes[1:], rates, values, strict=False):
        width = end - start
        off = float(rate - (row[1] - row[0]) / width)
        first, last = 2 * (row[3] - row[2]) / width - row[0], 2 * (row[4] - row[3]) / width - row[1]
        densities.append(Density(float(start), float(end), 1, off, off))
        densities.append(Density(float(start), float(end), 2, float(first), float(last)))
    size = float(np.abs(rates).max())
    return [
        *(atom for atom in atoms if abs(atom.weight) > 1e-14 * size),
        *(density for density in densities if abs(density.first) + abs(density.last) > 1e-12 * size),
    ]
