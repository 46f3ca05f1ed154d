"""quadprog, the dual active-set method of Goldfarb and Idnani (https://github.com/quadprog/quadprog): exact, dense."""

from __future__ import annotations

from importlib import import_module

import numpy as np

from swarmproof.qp.solvers import Answer, QuadraticProgram, Status

_quadprog = import_module("quadprog")


def solve(program: QuadraticProgram) -> Answer:
    """Solve `program`; bounds become rows."""
    above, below = np.isfinite(program.high), np.isfinite(program.low)
    eye = np.eye(len(program.c))
    rows = np.concatenate([program.A, -program.G, -eye[above], eye[below]])
    limits = np.concatenate([program.b, -program.h, -program.high[above], program.low[below]])
    constraints = (rows.T, limits, len(program.b)) if len(rows) else ()
    try:
        x = _quadprog.solve_qp(program.P, -program.c, *constraints)[0]
    except ValueError as error:
        infeasible = "inconsistent" in str(error)
        return Answer(Status.INFEASIBLE if infeasible else Status.GAVE_UP, np.full(len(program.c), np.nan))
    return Answer(Status.SOLVED, x)
