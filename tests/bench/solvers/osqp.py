"""OSQP, an operator-splitting method (https://osqp.org), with the accuracy asked of PIQP, as far as it gets there."""

from __future__ import annotations

from importlib import import_module

import numpy as np
from scipy.sparse import csc_array, csc_matrix, eye_array, vstack

from swarmproof.qp.solvers import TOLERANCE, Answer, QuadraticProgram, Status

_osqp = import_module("osqp")
#: OSQP's own default; with more, some of the programs take a second.
MOST_ITERATIONS = 4000
_STATUSES = {"solved": Status.SOLVED, "primal infeasible": Status.INFEASIBLE}


def solve(program: QuadraticProgram) -> Answer:
    """Solve `program`; equations and bounds become rows with two limits."""
    eye = eye_array(len(program.c), format="csc")
    rows = csc_matrix(vstack([csc_array(program.A), csc_array(program.G), eye]))
    lows = np.concatenate([program.b, np.full(len(program.h), -np.inf), program.low])
    highs = np.concatenate([program.b, program.h, program.high])
    solver = _osqp.OSQP()
    solver.setup(
        csc_matrix(np.triu(program.P)),
        program.c,
        rows,
        lows,
        highs,
        verbose=False,
        eps_abs=TOLERANCE,
        eps_rel=TOLERANCE,
        max_iter=MOST_ITERATIONS,
    )
    result = solver.solve(raise_error=False)
    return Answer(_STATUSES.get(result.info.status, Status.GAVE_UP), np.array(result.x, float))
