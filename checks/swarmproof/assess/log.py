"""What a person wants to see of a flight, round by round: kept while it is flown, drawn afterwards."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from swarmproof.flight.fly import Flight
from swarmproof.flight.state import Round
from swarmproof.motion.lattice import Floats


class Replanned(NamedTuple):
    """CU `cu` tried to plan UAV `uav` in round `k`; `why` not, if it failed; `adopted`: whether the UAV got it."""

    k: int
    cu: int
    uav: int
    why: str
    adopted: bool


class Lost(NamedTuple):
    """Messages lost in one round: metadata on the way to CUs, what was in the slots to CUs, and to UAVs."""

    metadata_at_cus: int
    slots_at_cus: int
    slots_at_uavs: int


@dataclass
class Log:
    """The flight so far.

    Attributes:
        positions: by round, of the references at its m samples, in m, each of shape (m, N, 3).
        states: by round, the names of the CUs' states in its computation phase.
    """

    flight: Flight
    positions: list[Floats] = field(default_factory=list)
    states: list[tuple[str, ...]] = field(default_factory=list)
    replanned: list[Replanned] = field(default_factory=list)
    lost: list[Lost] = field(default_factory=list)

    def see(self, flown: Round) -> None:
        """Keep what happened in one more round."""
        before, after = flown.before, flown.after
        k, lattice = before.k, self.flight.lattice
        plans = [before.followed(i) for i in range(len(before.swarm.uavs))]
        at_samples = np.array([plan.sampled_from(k)[: lattice.steps] for plan in plans])
        self.positions.append(at_samples.transpose(1, 0, 2) * float(lattice.position_unit))
        self.states.append(tuple(cu.state.name for cu in before.swarm.cus))
        for w, attempt in enumerate(flown.computed.attempts):
            if attempt is not None:
                i = attempt.task.i
                followed = after.swarm.uavs[i].followed.metadata
                self.replanned.append(Replanned(k, w, i, attempt.planned.why, (followed.round, followed.cu) == (k, w)))
        self.lost.append(
            Lost(
                sum(len(got.lost_uavs) for got in flown.at_cus),
                sum(len(got.lost_slots) for got in flown.at_cus),
                sum(len(got.lost_slots) for got in flown.at_uavs),
            )
        )
