"""Quadratic programs, and PIQP to solve them. What a solver returns is a proposal: `accept` decides."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import NamedTuple

import numpy as np
import piqp  # type: ignore[import-untyped]

from swarmproof.motion.lattice import Floats


class QuadraticProgram(NamedTuple):
    """Minimise ½xᵀPx + cᵀx subject to Ax = b, Gx ≤ h, low ≤ x ≤ high; bounds may be infinite, A and G without rows.

    Matrices are in column-major order, which solvers ask for.
    """

    P: Floats
    c: Floats
    A: Floats
    b: Floats
    G: Floats
    h: Floats
    low: Floats
    high: Floats


class Status(Enum):
    """What a solver says of a quadratic program."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    #: It proves neither that its answer is optimal nor that there is none.
    GAVE_UP = "gave up"


class Answer(NamedTuple):
    """What a solver returns; `x` is of no use if `status` is INFEASIBLE."""

    status: Status
    x: Floats


Solver = Callable[[QuadraticProgram], Answer]

#: Absolute and relative tolerance of residuals (m, m/s, …): a tenth of what constraints are tightened by.
TOLERANCE = 1e-7
#: The duality gap matters to optimality only, which nothing rests on. Where planes leave hardly any room, multipliers
#: grow without bound, and a smaller one is not reached.
GAP = 1e-4
#: Some ten iterations are usual.
MOST_ITERATIONS = 60
#: Iterations of the preconditioner: the programs are well scaled as they are.
PRECONDITIONING = 1
_STATUSES = {piqp.PIQP_SOLVED: Status.SOLVED, piqp.PIQP_PRIMAL_INFEASIBLE: Status.INFEASIBLE}


def solve_with_piqp(program: QuadraticProgram) -> Answer:
    """Solve by PIQP's dense interior-point method: the programs have some 50 variables and few rows."""
    solver = piqp.DenseSolver()
    settings = solver.settings
    settings.eps_abs = settings.eps_rel = TOLERANCE
    settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = GAP
    settings.max_iter = MOST_ITERATIONS
    settings.preconditioner_iter = PRECONDITIONING
    equalities = (program.A, program.b) if len(program.b) else (None, None)
    rows = (program.G, None, program.h) if len(program.h) else (None, None, None)
    solver.setup(program.P, program.c, *equalities, *rows, program.low, program.high)
    status = _STATUSES.get(solver.solve(), Status.GAVE_UP)
    return Answer(status, np.array(solver.result.x))
