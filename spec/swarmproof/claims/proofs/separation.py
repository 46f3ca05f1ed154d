"""Claims about one sample: Corollary 1, Lemma 3, the pairs that no lemma covers, and the hypotheses that they need."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from swarmproof.statements.cells import Cell, cells
from swarmproof.statements.claim import ProofClaim, ProofVerdict, Question, Reading
from swarmproof.statements.polynomial import Polynomial, position, variable
from swarmproof.statements.separation import (
    ASSUME_20,
    D,
    D_POSITIVE,
    EQ_20,
    GROUND,
    I_NEW,
    I_OLD,
    J_NEW,
    J_OLD,
    L,
    NOT_ZERO,
    OF_I,
    OF_J,
    apart,
    both_new,
    length,
    one_new,
    plane,
)
from swarmproof.statements.statement import Condition, Sign, Solvable, Statement, above, at_least, equal

_PRINTED, _REPAIRED = Reading.PRINTED, Reading.REPAIRED
_PROVED, _FALSE = ProofVerdict.PROVED, ProofVerdict.FALSE

_UNKNOWNS = tuple(
    name for vector in (I_OLD, J_OLD, I_NEW) for entry in vector for name in sorted(entry.variables)
) + ("l",)
#: Where UAV j's planner believes UAVs i and j to be, if its trackers differ from those of UAV i's planner.
_I_SEEN, _J_SEEN = position("i_seen"), position("j_seen")
_L_SEEN = variable("l_seen")


def _uncovered() -> Iterator[tuple[Cell, Statement]]:
    for cell in cells():
        if cell.lemma is None:
            yield cell, cell.statement(assume_20=True)


def _different_trackers() -> Statement:
    """Return Corollary 1 where UAV j's planner takes its plane from other trajectories than UAV i's."""
    mine = plane(OF_I, I_OLD, J_OLD, I_NEW, halfway=True)
    other = plane(OF_J, _J_SEEN, _I_SEEN, J_NEW, halfway=True)
    # the same formula with the length that UAV j's planner sees
    theirs = Condition(other.name, other.value.put({"l": _L_SEEN}))
    seen = (equal("l_seen is the length of n_ji", _L_SEEN**2, (_J_SEEN - _I_SEEN).square), above("l_seen > 0", _L_SEEN))
    far = (ASSUME_20, apart("(20), as j's planner sees it", _I_SEEN, _J_SEEN))
    return Statement((*GROUND, mine, *seen, theirs, *far), apart("(16)", I_NEW, J_NEW))


def _zero_normal(assume_20: bool) -> Mapping[str, Question]:
    known = (ASSUME_20,) if assume_20 else ()
    ground = (above(D_POSITIVE, D), length(), at_least("l is not negative", L))
    own = plane(OF_I, I_OLD, J_OLD, I_NEW, halfway=False)
    return {"n_ij may be zero": Statement((*ground, own, *known), apart("(17)", I_NEW, J_OLD))}


def _closer_than_20() -> Solvable:
    """Return that, whatever distance v < d̂_min two UAVs have, a plan that satisfies (15) brings them closer than d̂_min."""
    v = variable("v")
    broken = Condition("(17) is broken", D**2 - (I_NEW - J_OLD).square, Sign.ABOVE)
    distance = equal("they are v apart", L, v)
    return Solvable(
        (above("v > 0", v), above("v < d", D, v)),
        _UNKNOWNS,
        (GROUND[1], GROUND[2], distance, plane(OF_I, I_OLD, J_OLD, I_NEW, halfway=True), broken),
    )


_C1 = "Corollary 1, eq. (16)"
_L3 = "Lemma 3, eq. (17)"
_ONE_SAMPLE = "One sample of the horizon."

CLAIMS: tuple[ProofClaim, ...] = (
    ProofClaim(
        "corollary-1",
        _PRINTED,
        "The new trajectories of two UAVs, both in A_ET(k), that satisfy (13f) are d̂_min apart.",
        _C1,
        _ONE_SAMPLE + " Both planners have the same trackers and the same A_ET(k), and n_ij ≠ 0.",
        {"both new": both_new()},
        _PROVED,
        "It holds without (20). Its proof's |D_j| = 1 is not true of all UAVs in A_ET(k), but is of the planned ones.",
    ),
    ProofClaim(
        "lemma-3",
        _PRINTED,
        "A new trajectory that satisfies (13f) is d̂_min apart from all of D_j(k+1) of a UAV j that was not planned.",
        _L3,
        _ONE_SAMPLE + " n_ij ≠ 0.",
        {"j is not in A_ET(k)": one_new(False, False), "j is in A_ET(k)": one_new(True, False)},
        _FALSE,
        "False where j is in A_ET(k), but not planned: (15) then gives ½(d̂_min + ‖n‖), and (20) is needed.",
    ),
    ProofClaim(
        "lemma-3",
        _REPAIRED,
        "A new trajectory that satisfies (13f) is d̂_min apart from all of D_j(k+1) of a UAV j that was not planned, "
        "if (20) is true at the sample.",
        _L3,
        _ONE_SAMPLE + " n_ij ≠ 0; eq. (20) where j is in A_ET(k).",
        {"j is not in A_ET(k)": one_new(False, False), "j is in A_ET(k)": one_new(True, True)},
        _PROVED,
        "(20) repairs it; Theorem 1 has (20) at hand.",
    ),
)
