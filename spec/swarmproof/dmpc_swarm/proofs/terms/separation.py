"""What one sample of the horizon says about two UAVs: eqs. (14)-(17) and (20) of DMPC-Swarm as polynomials.

All positions are scaled by Θ⁻¹ and belong to the same time: `i_old`, `j_old` are entries of D_i(k) and D_j(k), `i_new`,
`j_new` are planned in round k. `l` is ‖n_ij‖, which (15) divides by; here, (15) is multiplied by it.
"""

from __future__ import annotations

from swarmproof.algebra.polynomial import Number, Polynomial, Vector, position, variable
from swarmproof.algebra.statement import Condition, Statement, above, at_least, equal

I_OLD, J_OLD, I_NEW, J_NEW = (position(name) for name in ("i_old", "j_old", "i_new", "j_new"))
D, L = variable("d"), variable("l")

#: Names of hypotheses.
D_POSITIVE, LENGTH, NOT_ZERO, EQ_20 = "d > 0", "l is the length of n_ij", "n_ij is not zero", "(20)"
OF_I, OF_J = "(15) for i", "(15) for j"


def plane(
    name: str,
    own: Vector,
    other: Vector,
    new: Vector,
    halfway: bool,
    tolerance: Polynomial | Number = 0,
    size: Polynomial = L,
) -> Condition:
    """Return constraint (15), multiplied by ‖n‖, for a UAV that moves from its trajectory `own` to `new`.

    Args:
        name: of the condition.
        own: its position on its old trajectory, which gives the normal n (eq. 14).
        other: the other UAV's position on the trajectory in its tracker.
        new: its position on its new trajectory.
        halfway: whether the other UAV is in A_ET(k): then Δ is ½(d̂_min + ‖n‖), else d̂_min.
        tolerance: by how much the constraint may be violated, in m.
        size: ‖n‖.
    """
    product = (other - own).dot(other - new)
    if halfway:
        return at_least(name, 2 * product - size * (D + size) + 2 * size * tolerance)
    return at_least(name, product - size * D + size * tolerance)


def apart(name: str, one: Vector, other: Vector, distance: Polynomial = D) -> Condition:
    """Return the condition that two positions are `distance` apart."""
    return at_least(name, (other - one).square, distance * distance)


def length(name: str = LENGTH, one: Vector = I_OLD, other: Vector = J_OLD) -> Condition:
    """Return that `L` is the length of the normal from `one` to `other`; that `L` is not negative is to be added."""
    return equal(name, L * L, (other - one).square)


#: What is true at every sample: d̂_min > 0, `L` is ‖n_ij‖, and (15) makes sense.
GROUND = (above(D_POSITIVE, D), length(), above(NOT_ZERO, L))
ASSUME_20 = apart(EQ_20, I_OLD, J_OLD)


def both_new(i_halfway: bool = True, j_halfway: bool = True, tolerance: Polynomial | Number = 0) -> Statement:
    """Return Corollary 1 at one sample; `i_halfway`: UAV i's planner takes j to be in A_ET(k), and the other way round.

    `tolerance`: as in :func:`plane`, for both planes.
    """
    planes = (
        plane(OF_I, I_OLD, J_OLD, I_NEW, i_halfway, tolerance),
        plane(OF_J, J_OLD, I_OLD, J_NEW, j_halfway, tolerance),
    )
    return Statement((*GROUND, *planes), apart("(16)", I_NEW, J_NEW))


def one_new(halfway: bool, assume_20: bool, tolerance: Polynomial | Number = 0) -> Statement:
    """Return Lemma 3 at one sample, for an entry of D_j(k) that j may still fly; `halfway`: j is in A_ET(k)."""
    known = (ASSUME_20,) if assume_20 else ()
    own = plane(OF_I, I_OLD, J_OLD, I_NEW, halfway, tolerance)
    return Statement((*GROUND, own, *known), apart("(17)", I_NEW, J_OLD))


def both_old(assume_20: bool) -> Statement:
    """Return what is needed where both UAVs fly entries of D(k)."""
    known = (ASSUME_20,) if assume_20 else ()
    return Statement((above(D_POSITIVE, D), *known), apart("(21)", I_OLD, J_OLD))
