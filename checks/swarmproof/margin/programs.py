"""Linear programs, with what to do when a solver gives up. Nothing here is trusted: results are only proposals."""

from __future__ import annotations

from typing import Any

import numpy as np

from swarmproof.margin.problem import Floats

#: HiGHS methods with their tolerances, in the order in which they are tried.
_ATTEMPTS = (("highs-ds", 1e-9), ("highs-ds", 1e-7), ("highs-ipm", 1e-8))


def maximise(target: Floats, matrix: Any, limits: Floats) -> Floats | None:
    """Return z that maximises target·z with matrix·z = 0 and |z| ≤ limits (`matrix` sparse); None if unsolved."""
    bounds = np.stack([-limits, limits], axis=1)
    return _solve(-target, A_eq=matrix.tocsc(), b_eq=np.zeros(matrix.shape[0]), bounds=bounds)


def least_absolute(prices: Floats, matrix: Any, constants: Floats) -> Floats | None:
    """Return z that minimises Σ prices·|matrix·z + constants| (`matrix` is a SciPy sparse array); None if unsolved."""
    from scipy.sparse import eye_array, hstack

    count, unknowns = matrix.shape
    identity: Any = eye_array(count)
    wide: Any = hstack([matrix, -identity, identity])
    cost = np.concatenate([np.zeros(unknowns), prices, prices]) / max(float(prices.max()), 1e-300)
    bounds = [(None, None)] * unknowns + [(0, None)] * (2 * count)
    solution = _solve(cost, A_eq=wide.tocsc(), b_eq=-constants, bounds=bounds)
    return None if solution is None else solution[:unknowns]


def _solve(cost: Floats, **given: Any) -> Floats | None:
    from scipy.optimize import linprog  # half a second to import, and not every reading needs it

    solver: Any = linprog
    for method, tolerance in _ATTEMPTS:
        options = {"primal_feasibility_tolerance": tolerance, "dual_feasibility_tolerance": tolerance}
        result = solver(cost, method=method, options=options, **given)
        if result.x is not None:
            return np.asarray(result.x)
    return None
