"""What a CU expects of the swarm: where each UAV is and how far it still moves, by its tracker's first entry.

Priorities (Appendix A), the deadlock test and the high-level planner (Appendix B.1) all read this and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.motion.pairs import turned

#: m; a UAV this close to its target has arrived.
ARRIVED = 0.05
#: m; a trajectory that stays within this distance of where it is (scaled) does not move.
STILL = 0.01
#: A UAV's neighbourhood, in d̂_min: trajectories further away than this do not keep it from moving.
NEIGHBOURHOOD = 3.0


@dataclass(frozen=True, eq=False)
class Outlook:
    """All UAVs at the start of one round, as one CU sees them.

    Attributes:
        positions: in m, shape (N, 3).
        velocities: in m/s, shape (N, 3).
        targets: where they are to go, in m, shape (N, 3).
        distances: to the targets, in m, shape (N,).
        deadlocked: shape (N,); see :func:`look`.
    """

    positions: Floats
    velocities: Floats
    targets: Floats
    distances: Floats
    deadlocked: NDArray[np.bool_]


def look(lattice: Lattice, k: int, plans: Sequence[Plan], targets: Floats, planned_for: NDArray[np.bool_]) -> Outlook:
    """Return the outlook at the start of round k.

    A UAV counts as deadlocked if calculating its trajectory once more would not change it: its trajectory was
    calculated for the present target (`planned_for`) and does not move any more, though the target is not reached,
    and no trajectory in its neighbourhood moves, so that the same problem would be solved again. (The paper cites a
    test that it does not print; this one asks the same question of what the CU holds anyway.)

    Args:
        lattice: the units.
        k: the round.
        plans: by UAV, the first entry of its tracker.
        targets: in m, shape (N, 3).
        planned_for: by UAV, whether that entry was calculated for this target.
    """
    states = np.array([plan.state_at(k) for plan in plans])
    pairs, uavs = lattice.pairs, np.arange(len(plans))
    ahead = np.array([plan.scaled_from(k) for plan in plans]) * (float(pairs.unit) if pairs.alike else 1.0)
    positions = states[:, 0] * float(lattice.position_unit)
    distances = np.sqrt(((targets - positions) ** 2).sum(axis=1))
    ways = turned(ahead - ahead[:, :1], pairs.in_metres(uavs[:, None], uavs[:, None]))
    travels = np.sqrt((ways**2).sum(axis=2)).max(axis=1)
    stands = planned_for & (travels < STILL) & (distances > ARRIVED)
    if stands.any():
        here = ahead[:, 0]
        between = turned(here[:, None] - here[None], pairs.in_metres(uavs[:, None], uavs[None]))
        apart = np.sqrt((between**2).sum(axis=2))
        moving_near = (apart < NEIGHBOURHOOD * float(pairs.distance)) & (travels >= STILL)[None]
        stands &= ~moving_near.any(axis=1)
    return Outlook(positions, states[:, 1] * float(lattice.velocity_unit), targets, distances, stands)
