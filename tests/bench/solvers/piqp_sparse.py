"""PIQP's sparse interior-point method, with the accuracy that the planner asks of the dense one."""

from __future__ import annotations

from typing import Any

import numpy as np
import piqp  # type: ignore[import-untyped]
from scipy.sparse import csc_array

from swarmproof.motion.lattice import Floats
from swarmproof.qp.solvers import GAP, TOLERANCE, Answer, QuadraticProgram, Status

_STATUSES = {piqp.PIQP_SOLVED: Status.SOLVED, piqp.PIQP_PRIMAL_INFEASIBLE: Status.INFEASIBLE}


def solve(program: QuadraticProgram) -> Answer:
    """Solve `program`, whose matrices become sparse on the way."""
    P, A, G = (csc_array(matrix) for matrix in (program.P, program.A, program.G))
    return solve_sparse(P, program.c, A, program.b, G, program.h, program.low, program.high)


def solve_sparse(P: Any, c: Floats, A: Any, b: Floats, G: Any, h: Floats, low: Floats, high: Floats) -> Answer:
    """Solve a program whose matrices P, A and G are :class:`scipy.sparse.csc_array`."""
    solver = piqp.SparseSolver()
    settings = solver.settings
    settings.eps_abs = settings.eps_rel = TOLERANCE
    settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = GAP
    solver.setup(P, c, A if len(b) else None, b if len(b) else None, *_rows(G, h), low, high)
    status = _STATUSES.get(solver.solve(), Status.GAVE_UP)
    return Answer(status, np.array(solver.result.x))


def _rows(G: Any, h: Floats) -> tuple[Any, None, Floats | None]:
    return (G, None, h) if len(h) else (None, None, None)
