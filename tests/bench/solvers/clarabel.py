"""Clarabel, an interior-point method for conic programs (https://clarabel.org), with the accuracy asked of PIQP."""

from __future__ import annotations

from importlib import import_module

import numpy as np
from scipy.sparse import csc_array, eye_array, vstack

from swarmproof.qp.solvers import GAP, TOLERANCE, Answer, QuadraticProgram, Status

_clarabel = import_module("clarabel")
_STATUSES = {"Solved": Status.SOLVED, "PrimalInfeasible": Status.INFEASIBLE}


def solve(program: QuadraticProgram) -> Answer:
    """Solve `program`; bounds become rows."""
    above, below = np.isfinite(program.high), np.isfinite(program.low)
    eye = eye_array(len(program.c), format="csr")
    rows = vstack([csc_array(program.A), csc_array(program.G), eye[above], -eye[below]], format="csc")
    limits = np.concatenate([program.b, program.h, program.high[above], -program.low[below]])
    cones = [_clarabel.ZeroConeT(len(program.b)), _clarabel.NonnegativeConeT(len(limits) - len(program.b))]
    settings = _clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_feas = TOLERANCE
    settings.tol_gap_abs = settings.tol_gap_rel = GAP
    P = csc_array(np.triu(program.P))
    solution = _clarabel.DefaultSolver(P, program.c, rows, limits, cones, settings).solve()
    return Answer(_STATUSES.get(str(solution.status), Status.GAVE_UP), np.array(solution.x))
