"""Claims about numerical tolerance: what becomes of distance and feasibility if constraints may be violated a little.

Which violation is meant, and by how much, is said in :mod:`swarmproof.dmpc_swarm.proofs.terms.tolerance`.
"""

from __future__ import annotations

from swarmproof.algebra.statement import at_least
from swarmproof.claims.proof import ProofClaim, ProofVerdict, Reading
from swarmproof.dmpc_swarm.proofs.terms.cells import cells
from swarmproof.dmpc_swarm.proofs.terms.separation import EQ_20, I_OLD, J_OLD, D, apart
from swarmproof.dmpc_swarm.proofs.terms.tolerance import (
    ACCELERATION,
    AT_BOUND,
    AT_REST,
    BOUND,
    DRIFT,
    EPSILON,
    EQUAL,
    ERROR,
    SLOW,
    SPEED,
    START,
    TIME,
    TWICE,
    X,
    after_the_end,
    candidate,
    drift_attained,
    flies_on,
    in_bounds,
    jumps_add_up,
    kept,
    least,
    other_ratio,
    pair,
    three_uavs,
    tracking,
    two_uavs,
)

_PRINTED, _REPAIRED = Reading.PRINTED, Reading.REPAIRED
_PROVED, _FALSE = ProofVerdict.PROVED, ProofVerdict.FALSE

_SAMPLE = "At one sample. The CUs have the same trackers and the same A_ET(k), and n_ij ≠ 0."
_ROWS = f"{_SAMPLE} Each accepted row of (13f) is violated by ε at most, 0 ≤ 2ε < d̂_min"
_END = "Trajectories that are not recomputed for the time t = nT after their end; distances, ε_v and ε_a are scaled"
_NEVER = "the paper solves (13) numerically and does not mention tolerance"

CLAIMS: tuple[ProofClaim, ...] = (
    ProofClaim(
        "tolerance-distance",
        _PRINTED,
        "Any two trajectories that can be flown in round k+1 are d̂_min apart, if rows of (13f) may be violated by ε.",
        f"eq. (21): {_NEVER}",
        f"{_ROWS}; (20).",
        {cell.id: pair(cell, EQUAL, apart(EQ_20, I_OLD, J_OLD), D) for cell in cells()},
        _FALSE,
        "False for every pair with a new trajectory, from the first round on: (26) would have to count the solver's "
        "tolerance.",
    ),
    ProofClaim(
        "tolerance-distance",
        _REPAIRED,
        "If any two trajectories in trackers are d̂_min − 2ε apart in round k, so are those of round k+1.",
        "eqs. (20), (21)",
        f"{_ROWS}; (20) with d̂_min − 2ε. (13b) is not used.",
        {cell.id: kept(cell, EQUAL) for cell in cells()},
        _PROVED,
        "Distance does not erode: by induction it is d̂_min − 2ε after any number of rounds. Planning with d̂_min + 2ε "
        "gives all of d̂_min.",
    ),
    ProofClaim(
        "tolerance-least",
        _REPAIRED,
        "For every ε, two UAVs that are d̂_min apart have accepted plans that are exactly d̂_min − 2ε apart.",
        "eq. (16)",
        f"{_ROWS}; both UAVs are planned.",
        {"both new": least()},
        _PROVED,
        "The bound d̂_min − 2ε cannot be improved; one round is enough to reach it.",
    ),
    ProofClaim(
        "tolerance-feasible",
        _PRINTED,
        "The optimization problems remain feasible, if rows of (13f) may be violated by ε, in the past and now.",
        f"Theorem 1, eq. (22): {_NEVER}",
        "On a line, every row relaxed by the same ε, 0 ≤ 2ε < d̂_min; (20) in the first round. As many CUs as UAVs on "
        "the line, and other UAVs far away, so that A_ET(k) changes.",
        {"two UAVs, first sample": two_uavs(), "three UAVs, any sample, without (13b)": three_uavs()},
        _FALSE,
        "After a round that used the tolerance, UAVs are d̂_min − 2ε apart; a row for a UAV that is not in A_ET(k) "
        "needs d̂_min − ε. Where that is the first sample, (13b) leaves no other plan.",
    ),
    ProofClaim(
        "tolerance-feasible",
        _REPAIRED,
        "If halfway rows may be violated by ε and the others by 2ε, then, of trajectories that are d̂_min − 2ε apart in "
        "round k, the candidate satisfies all rows, and those of round k+1 are again d̂_min − 2ε apart.",
        "Theorem 1, eqs. (21), (22)",
        f"{_SAMPLE} 0 ≤ 2ε < d̂_min; (20) with d̂_min − 2ε.",
        {
            "candidate, j is in A_ET(k)": candidate(halfway=True),
            "candidate, j is not in A_ET(k)": candidate(halfway=False),
            **{cell.id: kept(cell, TWICE) for cell in cells()},
        },
        _PROVED,
        "It is the exact algorithm for d̂_min − 2ε. The same 2ε costs nothing more, and brings feasibility back.",
    ),
    ProofClaim(
        "tolerance-half",
        _REPAIRED,
        "For any two tolerances, of halfway rows and of the others, whose ratio is not ½, there are two UAVs whose "
        "candidate is refused when one of them is planned for the second time.",
        "Theorem 1, eq. (22)",
        "On a line; (20) in the first round; 0 ≤ 2ε_half < d̂_min and 0 ≤ ε_full < d̂_min; two CUs, and a third UAV that "
        "can be in A_ET(k).",
        {"more than half": other_ratio(larger=True), "less than half": other_ratio(larger=False)},
        _PROVED,
        "So the tolerance of halfway rows must be exactly half that of the others. At the first sample, where (13b) "
        "leaves no choice, this is an infeasible problem. With one CU no row is halfway, and nothing is lost.",
    ),
    ProofClaim(
        "tolerance-no-plan",
        _REPAIRED,
        "If a CU whose problem has no solution sends nothing, and the UAV keeps its trajectory, all pairs stay "
        "d̂_min − 2ε apart.",
        "eq. (21); Theorem 1",
        f"{_ROWS}; (20) with d̂_min − 2ε. Nothing is assumed about feasibility.",
        {cell.id: kept(cell, EQUAL) for cell in cells() if flies_on(cell)},
        _PROVED,
        "Separation does not need Theorem 1's feasibility; what is lost without it is progress.",
    ),
    ProofClaim(
        "tolerance-rest",
        _PRINTED,
        "Two UAVs whose trajectories end d̂_min apart remain so, if (13e) may be violated by ε_v and ε_a.",
        f"(13e); proof of Theorem 1, for t ≥ (H−1)T: {_NEVER}",
        f"{_END}.",
        {"d": after_the_end(D, room=False)},
        _FALSE,
        "What is left of the speed acts for as long as no new trajectory arrives: two UAVs can meet.",
    ),
    ProofClaim(
        "tolerance-rest",
        _REPAIRED,
        "n rounds after the end of their trajectories, they are d̂_min − 2(nT·ε_v + ½(nT)²·ε_a) apart.",
        "(13e)",
        f"{_END}. n > 0, ε_v > 0, ε_a > 0, and the bound is positive.",
        {"d - 2(nT epsilon_v + (nT)^2 epsilon_a/2)": after_the_end(D - DRIFT, room=True)},
        _PROVED,
        "Linear in n for the speed, quadratic for the acceleration. If trajectories end d̂_min − 2ε apart, both add up.",
    ),
    ProofClaim(
        "tolerance-rest-least",
        _REPAIRED,
        "For every n, two UAVs exist for which this bound is attained.",
        "(13e)",
        f"{_END}.",
        {"attained": drift_attained()},
        _PROVED,
        "There is no bound for all n: (13e) has to be satisfied exactly, by the way trajectories are represented.",
    ),
    ProofClaim(
        "tolerance-state",
        _PRINTED,
        "A trajectory that satisfies (13d) within ε and (13e) within ε_v and ε_a, once shifted, still satisfies (13d) "
        "within ε.",
        f"Proof of Theorem 1: {_NEVER}",
        "One bound of one axis, at time t after the end.",
        {"(13d) after the end": in_bounds(AT_BOUND, *SLOW)},
        _FALSE,
        "Theorem 1's candidate drifts out of the relaxed bounds.",
    ),
    ProofClaim(
        "tolerance-state",
        _REPAIRED,
        "It does if it ends at rest exactly; or, if it ends within the exact bounds, as long as "
        "nT·ε_v + ½(nT)²·ε_a ≤ ε.",
        "Proof of Theorem 1",
        "One bound of one axis, at time t after the end.",
        {
            "at rest": in_bounds(AT_BOUND, *AT_REST),
            "for some rounds": in_bounds(
                at_least("(13d) at the end", BOUND, X),
                *SLOW,
                at_least("not for too long", EPSILON, TIME * SPEED + TIME**2 / 2 * ACCELERATION),
            ),
        },
        _PROVED,
        "Bounds of (13c) and (13d) that are violated by ε do not add up: shifting leaves all numbers as they are.",
    ),
    ProofClaim(
        "tolerance-start",
        _PRINTED,
        "A UAV that is within Δd_min of its old reference is within Δd_min of its new one, if (13b) may be violated by "
        "ε_0.",
        f"Assumption 1, eq. (6): {_NEVER}",
        "At the moment at which the new reference begins; 0 < ε_0 < Δd_min.",
        {"delta": tracking(ERROR, ERROR)},
        _FALSE,
        "The reference jumps. References stay apart all the same (no pair of tolerance-distance uses (13b)), but "
        "Assumption 1 says nothing of a reference that begins more than Δd_min away.",
    ),
    ProofClaim(
        "tolerance-start",
        _REPAIRED,
        "It is, if it is within Δd_min − ε_0 of its old reference by then.",
        "Assumption 1, eq. (6)",
        "At the moment at which the new reference begins; 0 < ε_0 < Δd_min.",
        {"delta - epsilon_0": tracking(ERROR - START, ERROR)},
        _PROVED,
        "The controller has to take back ε_0 between two new trajectories: Assumption 1 does not say that it does.",
    ),
    ProofClaim(
        "tolerance-start-least",
        _REPAIRED,
        "Whatever error c a UAV has, a new reference within ε_0 of the old one can make it c + ε_0.",
        "Assumption 1, eq. (6)",
        "At the moment at which the new reference begins.",
        {"c + epsilon_0": jumps_add_up()},
        _PROVED,
        "A controller that keeps its error constant meets Assumption 1; n new trajectories then give Δd_min + nε_0. "
        "There is no bound for all n.",
    ),
)
