"""Claims about one sample of the horizon: Corollary 1, Lemma 3, and what they use without saying it."""

from __future__ import annotations

from dataclasses import replace

from swarmproof.algebra.polynomial import Vector, position, variable
from swarmproof.algebra.statement import Condition, Sign, Solvable, Statement, above, at_least, equal
from swarmproof.claims.proof import ProofClaim, ProofVerdict, Reading
from swarmproof.dmpc_swarm.proofs.terms.separation import (
    ASSUME_20,
    D_POSITIVE,
    GROUND,
    I_NEW,
    I_OLD,
    J_NEW,
    J_OLD,
    OF_I,
    OF_J,
    D,
    L,
    apart,
    both_new,
    length,
    one_new,
    plane,
)

_PRINTED, _REPAIRED = Reading.PRINTED, Reading.REPAIRED
_PROVED, _FALSE = ProofVerdict.PROVED, ProofVerdict.FALSE

#: The trajectory of UAV i that UAV j's planner counts on, where its tracker differs; and the length of its normal.
_I_SEEN, _L_SEEN = position("i_seen"), variable("l_seen")
#: The optimization variable ε of Appendix B.
_SOFT = variable("epsilon")


def _names(*vectors: Vector) -> tuple[str, ...]:
    return tuple(name for vector in vectors for entry in vector for name in entry.variables)


def _different_trackers() -> Statement:
    """Return Corollary 1 where UAV j's planner has another trajectory of UAV i in its tracker than the one it flies."""
    seen = (
        equal("l_seen is the length of n_ji", _L_SEEN**2, (_I_SEEN - J_OLD).square),
        above("l_seen > 0", _L_SEEN),
        plane(OF_J, J_OLD, _I_SEEN, J_NEW, halfway=True, size=_L_SEEN),
    )
    far = (ASSUME_20, apart("(20), as j's planner sees it", _I_SEEN, J_OLD))
    planes = (plane(OF_I, I_OLD, J_OLD, I_NEW, halfway=True), *seen)
    return Statement((*GROUND, *planes, *far), apart("(16)", I_NEW, J_NEW))


def _normal_may_vanish(assume_20: bool) -> Statement:
    """Return Lemma 3, (15) being multiplied by ‖n‖, where nothing says that n is not zero."""
    known = (ASSUME_20,) if assume_20 else ()
    ground = (above(D_POSITIVE, D), length(), at_least("l is not negative", L))
    own = plane(OF_I, I_OLD, J_OLD, I_NEW, halfway=False)
    return Statement((*ground, own, *known), apart("(17)", I_NEW, J_OLD))


def _too_close_without_20() -> Solvable:
    """Return that, whatever distance v < d̂_min the old ones have, (15) lets UAV i come closer than d̂_min to j."""
    v = variable("v")
    broken = Condition("(17) is broken", D**2 - (I_NEW - J_OLD).square, Sign.ABOVE)
    constraints = (GROUND[1], GROUND[2], equal("l = v", L, v), plane(OF_I, I_OLD, J_OLD, I_NEW, halfway=True), broken)
    return Solvable((above("v > 0", v), above("v < d", D, v)), (*_names(I_OLD, J_OLD, I_NEW), "l"), constraints)


def _soft(statement: Statement) -> Statement:
    """Return a statement with ε ≥ 0 among its hypotheses."""
    return replace(statement, hypotheses=(*statement.hypotheses, at_least("epsilon >= 0", _SOFT)))


_C1 = "Corollary 1, eq. (16)"
_L3 = "Lemma 3, eq. (17)"
_SAMPLE = "At one sample."

CLAIMS: tuple[ProofClaim, ...] = (
    ProofClaim(
        "corollary-1",
        _PRINTED,
        "The new trajectories of two UAVs, both in A_ET(k), that satisfy (13f) are d̂_min apart.",
        _C1,
        f"{_SAMPLE} Both planners have the same trackers and the same A_ET(k), and n_ij ≠ 0.",
        {"both new": both_new()},
        _PROVED,
        "It does not even need (20). Its proof's |D_j| = 1 is not true of all UAVs in A_ET(k), but of planned ones.",
    ),
    ProofClaim(
        "equal-trackers",
        _PRINTED,
        "Corollary 1, whatever trajectory of UAV i is in the tracker of the CU that plans UAV j.",
        _C1 + ", without Section 4.3.1's D_iw(k) = D_iv(k) (Lemma 2)",
        f"{_SAMPLE} (20) is true as each of the two CUs sees it.",
        {"j's planner sees another trajectory of i": _different_trackers()},
        _FALSE,
        "The two planes are no longer parallel. What is used is Lemma 2: planners have the same trackers.",
    ),
    ProofClaim(
        "equal-trackers",
        _REPAIRED,
        "Corollary 1, if both CUs have the same trajectory of UAV i and the same of UAV j in their trackers.",
        _C1,
        f"{_SAMPLE} Lemma 2 for the pair.",
        {"the same normals": both_new()},
        _PROVED,
        "Then n_ij = −n_ji, and the two planes are parallel.",
    ),
    ProofClaim(
        "equal-selection",
        _PRINTED,
        "Corollary 1, whether or not each planner knows that the other UAV is in A_ET(k).",
        _C1 + ", without Section 4.2.2's “they compute the same set A_ET(k)”",
        f"{_SAMPLE} The trackers are equal; (20) is not needed to refute it.",
        {"neither knows": both_new(False, False), "one does not know": both_new(True, False)},
        _FALSE,
        "A planner that counts on the other's old trajectory leaves it no room: two UAVs can meet. It happens, since "
        "the CUs need not compute the same set (claim same-selection of verify).",
    ),
    ProofClaim(
        "equal-selection",
        _REPAIRED,
        "Corollary 1, if both planners know that the other UAV is in A_ET(k).",
        _C1,
        f"{_SAMPLE} The trackers are equal.",
        {"both know": both_new(True, True)},
        _PROVED,
        "Each gives way by half.",
    ),
    ProofClaim(
        "lemma-3",
        _PRINTED,
        "A new trajectory that satisfies (13f) is d̂_min apart from all of D_j(k+1) of a UAV j that was not planned.",
        _L3,
        f"{_SAMPLE} n_ij ≠ 0.",
        {"j is not in A_ET(k)": one_new(False, False), "j is in A_ET(k)": one_new(True, False)},
        _FALSE,
        "False where j is in A_ET(k), but not planned: there, the plane is halfway, and the last step of the proof "
        "is wrong.",
    ),
    ProofClaim(
        "lemma-3",
        _REPAIRED,
        "A new trajectory that satisfies (13f) is d̂_min apart from all of D_j(k+1) of a UAV j that was not planned, if "
        "j is not in A_ET(k) or (20) is true.",
        _L3,
        f"{_SAMPLE} n_ij ≠ 0; eq. (20) at the sample where j is in A_ET(k).",
        {"j is not in A_ET(k)": one_new(False, False), "j is in A_ET(k)": one_new(True, True)},
        _PROVED,
        "Theorem 1 has (20) at hand, but for the last sample (claim candidate-samples).",
    ),
    ProofClaim(
        "lemma-3-condition",
        _REPAIRED,
        "(20) is the least condition: for each smaller distance of the old trajectories, (15) allows a plan that is "
        "too close.",
        _L3,
        f"{_SAMPLE} j is in A_ET(k); the old trajectories are v apart, 0 < v < d̂_min.",
        {"any distance below d": _too_close_without_20()},
        _PROVED,
        "The plan on the plane is ½(d̂_min + v) from UAV j.",
    ),
    ProofClaim(
        "normal-not-zero",
        _PRINTED,
        "Lemma 3, j not in A_ET(k), where n_ij may be zero.",
        "eq. (15): n_0,ij = n_ij/‖n_ij‖",
        f"{_SAMPLE} (15) is read multiplied by ‖n_ij‖; as printed it divides by zero.",
        {"n_ij may be zero": _normal_may_vanish(False)},
        _FALSE,
        "Where n_ij = 0, (15) says nothing, and the plan may go through UAV j.",
    ),
    ProofClaim(
        "normal-not-zero",
        _REPAIRED,
        "Lemma 3, j not in A_ET(k), where n_ij may be zero, if (20) is true.",
        "eq. (15)",
        f"{_SAMPLE} Eq. (20): with it, n_ij is not zero.",
        {"(20) is true": _normal_may_vanish(True)},
        _PROVED,
        "(20) at all samples of (13f) is enough for (15) to make sense.",
    ),
    ProofClaim(
        "soft-constraint",
        _PRINTED,
        "With the soft constraint, ε ≥ 0 added to the right-hand side of (15), Corollary 1 and Lemma 3 remain true.",
        "Appendix B",
        f"{_SAMPLE} As for Corollary 1 and the repaired Lemma 3.",
        {
            "both new": _soft(both_new(tolerance=-_SOFT)),
            "j is not in A_ET(k)": _soft(one_new(False, False, -_SOFT)),
            "j is in A_ET(k)": _soft(one_new(True, True, -_SOFT)),
        },
        _PROVED,
        "It only moves the planes away. ε = 0 is allowed, so the candidate of Theorem 1 remains one.",
    ),
)
