"""What n rounds make of distance and feasibility if constraints may be violated a little: statements.

ε is by how much a row of (13f) may be violated, in metres of scaled distance. A halfway row of (15) that is relaxed by
ε is the exact one for d̂_min − 2ε; the other one, with d̂_min alone, is the exact one for d̂_min − ε.
"""

from __future__ import annotations

from swarmproof.algebra.polynomial import Number, Polynomial, Vector, position, variable
from swarmproof.algebra.statement import Condition, Solvable, Statement, above, at_least, equal
from swarmproof.dmpc_swarm.proofs.terms.cells import Cell
from swarmproof.dmpc_swarm.proofs.terms.separation import (
    EQ_20,
    GROUND,
    I_NEW,
    I_OLD,
    J_NEW,
    J_OLD,
    OF_I,
    OF_J,
    D,
    apart,
    plane,
)

EPSILON = variable("epsilon")
#: What remains of d̂_min: d̂_min − 2ε.
KEPT = D - 2 * EPSILON
#: Names of hypotheses.
NOT_NEGATIVE, ROOM, KEPT_20 = "epsilon >= 0", "d > 2 epsilon", "(20) with d - 2 epsilon"
_TOLERANCE = (at_least(NOT_NEGATIVE, EPSILON), above(ROOM, D, 2 * EPSILON))

#: By how much the rows with d̂_min alone are relaxed, in ε: as much as halfway rows, or twice as much.
EQUAL, TWICE = 1, 2


def _relaxed(name: str, own: Vector, other: Vector, new: Vector, halfway: bool, full: Number) -> Condition:
    """Return a row of (15): a halfway one relaxed by ε, the other one by `full`·ε."""
    return plane(name, own, other, new, halfway, EPSILON if halfway else full * EPSILON)


def pair(cell: Cell, full: Number, before: Condition, after: Polynomial) -> Statement:
    """Return that a pair is `after` apart at a sample if it was accepted with tolerance, and had `before`."""
    rows = []
    if cell.i.new:
        rows.append(_relaxed(OF_I, I_OLD, J_OLD, I_NEW, cell.j.selected, full))
    if cell.j.new:
        rows.append(_relaxed(OF_J, J_OLD, I_OLD, J_NEW, cell.i.selected, full))
    flown = apart("(21)", I_NEW if cell.i.new else I_OLD, J_NEW if cell.j.new else J_OLD, after)
    return Statement((*GROUND, *_TOLERANCE, *rows, before), flown)


def kept(cell: Cell, full: Number) -> Statement:
    """Return the step of the induction for a pair: d̂_min − 2ε gives d̂_min − 2ε.

    Args:
        cell: the pair.
        full: by how much rows with d̂_min alone may be violated, in ε.
    """
    return pair(cell, full, apart(KEPT_20, I_OLD, J_OLD, KEPT), KEPT)


def flies_on(cell: Cell) -> bool:
    """Say whether a UAV of the pair is selected and flies on as before."""
    return any(role.selected and not role.new for role in cell)


def candidate(halfway: bool) -> Solvable:
    """Return that a plan for UAV i satisfies its row, relaxed by ε or 2ε, if (20) is true of d̂_min − 2ε."""
    unknowns = tuple(name for entry in I_NEW for name in entry.variables)
    row = _relaxed(OF_I, I_OLD, J_OLD, I_NEW, halfway, TWICE)
    return Solvable((*GROUND, *_TOLERANCE, apart(KEPT_20, I_OLD, J_OLD, KEPT)), unknowns, (row,))


def _on_line(
    name: str, own: str, other: str, new: str, halfway: bool, right: bool, tolerance: Polynomial = EPSILON
) -> Condition:
    """Return (15) for UAVs on a line, by the names of their places; `right`: the other one is to the right."""
    a, b = variable(own), variable(other)
    row = plane(name, Vector((a,)), Vector((b,)), Vector((variable(new),)), halfway, tolerance)
    return row.put({"l": b - a if right else a - b})


def two_uavs() -> Solvable:
    """Return that UAV i has a plan in round k + 2, at its first sample, if both were planned in round k.

    In round k + 1 it cannot be planned: |D_i| = 2. Old and new trajectories of round k are at i0, j0 and i1, j1 at that
    sample, the next plan of UAV i at i2.
    """
    known = (
        *_TOLERANCE,
        at_least(EQ_20, variable("j0") - variable("i0"), D),
        _on_line("(15) for i, round k", "i0", "j0", "i1", halfway=True, right=True),
        _on_line("(15) for j, round k", "j0", "i0", "j1", halfway=True, right=False),
        above("i is left of j", variable("j1"), variable("i1")),
    )
    asked = (
        equal("(13b)", variable("i2"), variable("i1")),
        _on_line("(15) for i, round k+2", "i1", "j1", "i2", halfway=False, right=True),
    )
    return Solvable(known, ("i2",), asked)


def three_uavs() -> Solvable:
    """Return that the middle one of three UAVs on a line, a, i and b, has a plan after two rounds in which all had.

    The rounds are k, k + 2 and k + 4, for places 0, 1 and 2; the plan in question is at i3.
    """
    known = [
        *_TOLERANCE,
        at_least("(20) for a and i", variable("i0") - variable("a0"), D),
        at_least("(20) for i and b", variable("b0") - variable("i0"), D),
    ]
    for r, s in ((0, 1), (1, 2)):
        for own, other, right in (("a", "i", True), ("i", "a", False), ("i", "b", True), ("b", "i", False)):
            name = f"(15) for {own} and {other}, round k+{2 * r}"
            known.append(_on_line(name, f"{own}{r}", f"{other}{r}", f"{own}{s}", halfway=True, right=right))
        known.append(above(f"a is left of i, round k+{2 * s}", variable(f"i{s}"), variable(f"a{s}")))
        known.append(above(f"b is right of i, round k+{2 * s}", variable(f"b{s}"), variable(f"i{s}")))
    asked = (
        _on_line("(15) for i and a", "i2", "a2", "i3", halfway=False, right=False),
        _on_line("(15) for i and b", "i2", "b2", "i3", halfway=False, right=True),
    )
    return Solvable(tuple(known), ("i3",), asked)


_HALF, _FULL = variable("epsilon_half"), variable("epsilon_full")


def other_ratio(larger: bool) -> Solvable:
    """Return that for all ε of halfway rows and of full ones with another ratio, round k + 2 refuses a candidate.

    Args:
        larger: the ratio is above ½, else below.
    """
    i0, j0, i1, j1 = (variable(name) for name in ("i0", "j0", "i1", "j1"))
    ratio = above("2 epsilon_half > epsilon_full", 2 * _HALF, _FULL)
    if not larger:
        ratio = above("epsilon_full > 2 epsilon_half", _FULL, 2 * _HALF)
    hypotheses = (
        at_least("epsilon_half >= 0", _HALF),
        at_least("epsilon_full >= 0", _FULL),
        above("d > 2 epsilon_half", D, 2 * _HALF),
        above("d > epsilon_full", D, _FULL),
        ratio,
    )
    tolerance = {True: _HALF, False: _FULL}
    rows = [_on_line("(15) for i, round k", "i0", "j0", "i1", larger, right=True, tolerance=tolerance[larger])]
    if larger:
        rows.append(_on_line("(15) for j, round k", "j0", "i0", "j1", halfway=True, right=False, tolerance=_HALF))
    else:
        rows.append(equal("j is not planned", j1, j0))
    again = _on_line("", "i1", "j1", "i1", not larger, right=True, tolerance=tolerance[not larger])
    constraints = (
        at_least(EQ_20, j0 - i0, D),
        *rows,
        above("i is left of j", j1, i1),
        above("the candidate breaks (15) in round k+2", -again.value),
    )
    return Solvable(hypotheses, ("i0", "j0", "i1", "j1"), constraints)


def least() -> Solvable:
    """Return that, whatever ε is, two UAVs on a line d̂_min apart have plans that are exactly d̂_min − 2ε apart."""
    i0, j0, i1, j1 = (variable(name) for name in ("i0", "j0", "i1", "j1"))
    constraints = (
        at_least(EQ_20, j0 - i0, D),
        _on_line("(15) for i", "i0", "j0", "i1", halfway=True, right=True),
        _on_line("(15) for j", "j0", "i0", "j1", halfway=True, right=False),
        equal("d - 2 epsilon apart", j1 - i1, KEPT),
    )
    return Solvable(_TOLERANCE, ("i0", "j0", "i1", "j1"), constraints)


#: Time since the end of the trajectories, nT; by how much (13e) may be violated: speed and acceleration.
TIME, SPEED, ACCELERATION = variable("t"), variable("epsilon_v"), variable("epsilon_a")
#: By how much two UAVs then approach at most: 2(nT·ε_v + ½(nT)²·ε_a).
DRIFT = 2 * TIME * SPEED + TIME**2 * ACCELERATION
#: Velocities and accelerations at the end (scaled by Θ⁻¹), and how UAV j is placed relative to UAV i there.
V_I, V_J, A_I, A_J, PLACE = (position(name) for name in ("v_i", "v_j", "a_i", "a_j", "place"))


def _drifted() -> Vector:
    """Return how UAV j is placed relative to UAV i at time t after the end, with jerk 0."""
    return Vector(
        p + TIME * (vj - vi) + TIME**2 / 2 * (aj - ai)
        for p, vi, vj, ai, aj in zip(PLACE, V_I, V_J, A_I, A_J, strict=True)
    )


def _drift_hypotheses() -> tuple[Condition, ...]:
    """Return that (13e) is violated by ε_v and ε_a at most by trajectories that end d̂_min apart."""
    violated = (("v_i", V_I, SPEED), ("v_j", V_J, SPEED), ("a_i", A_I, ACCELERATION), ("a_j", A_J, ACCELERATION))
    bounds = (at_least(f"(13e) for {name}", bound**2, vector.square) for name, vector, bound in violated)
    return (*bounds, at_least("apart at the end", PLACE.square, D**2))


def after_the_end(distance: Polynomial, room: bool) -> Statement:
    """Return that two UAVs that are d̂_min apart at the end are `distance` apart at time t later.

    Args:
        distance: in scaled metres.
        room: whether it is assumed that the drift is less than d̂_min.
    """
    positive = tuple(
        above(f"{name} > 0", value)
        for name, value in (("d", D), ("t", TIME), ("epsilon_v", SPEED), ("epsilon_a", ACCELERATION))
    )
    enough = (above("d > drift", D, DRIFT),) if room else ()
    drifted = _drifted()
    return Statement(
        (*_drift_hypotheses(), *positive, *enough), at_least("apart at time t later", drifted.square, distance**2)
    )


def drift_attained() -> Solvable:
    """Return that the bound is attained, for every time after the end at which something is left of d̂_min."""
    positive = (
        at_least("t >= 0", TIME),
        at_least("epsilon_v >= 0", SPEED),
        at_least("epsilon_a >= 0", ACCELERATION),
        at_least("d >= drift", D, DRIFT),
    )
    names = tuple(name for vector in (V_I, V_J, A_I, A_J, PLACE) for entry in vector for name in entry.variables)
    exact = equal("d - drift apart at time t later", _drifted().square, (D - DRIFT) ** 2)
    return Solvable(positive, names, (*_drift_hypotheses(), exact))


X, BOUND, _V, _A = (variable(name) for name in ("x", "x_max", "v", "a"))


def in_bounds(*known: Condition) -> Statement:
    """Return that at time t after the end, a UAV is within a bound of (13d) relaxed by ε, on one axis."""
    ground = (at_least("t >= 0", TIME), at_least(NOT_NEGATIVE, EPSILON))
    later = X + TIME * _V + TIME**2 / 2 * _A
    return Statement((*ground, *known), at_least("(13d) at time t later", BOUND + EPSILON, later))


SLOW = (at_least("v at most epsilon_v", SPEED, _V), at_least("a at most epsilon_a", ACCELERATION, _A))
AT_REST = (equal("v = 0", _V), equal("a = 0", _A))
AT_BOUND = at_least("(13d) at the end, relaxed", BOUND + EPSILON, X)

#: By how much (13b) may be violated; Δd_min of Assumption 1; how far a UAV is from its reference, and how that jumps.
START, ERROR = variable("epsilon_0"), variable("delta")
OFF, JUMP = position("off"), position("jump")


def tracking(before: Polynomial, after: Polynomial) -> Statement:
    """Return that a UAV that is within `before` of its old reference is within `after` of its new one."""
    hypotheses = (
        above("epsilon_0 > 0", START),
        above("delta > epsilon_0", ERROR, START),
        at_least("error on the old reference", before**2, OFF.square),
        at_least("(13b)", START**2, JUMP.square),
    )
    return Statement(hypotheses, at_least("error on the new reference", after**2, (OFF - JUMP).square))


def jumps_add_up() -> Solvable:
    """Return that any tracking error c can become c + ε_0 when a new reference begins."""
    c = variable("c")
    names = tuple(name for vector in (OFF, JUMP) for entry in vector for name in entry.variables)
    constraints = (
        equal("error c on the old reference", OFF.square, c**2),
        at_least("(13b)", START**2, JUMP.square),
        equal("error c + epsilon_0 on the new one", (OFF - JUMP).square, (c + START) ** 2),
    )
    return Solvable((at_least("c >= 0", c), at_least("epsilon_0 >= 0", START)), names, constraints)
