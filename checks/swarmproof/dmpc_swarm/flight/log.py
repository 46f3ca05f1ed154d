"""What a person wants to see of a flight, round by round: kept while it is flown, drawn afterwards."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from swarmproof.dmpc_swarm.flight.fly import Flight
from swarmproof.dmpc_swarm.flight.state import Attempt, Round
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.dmpc_swarm.protocol.messages import Metadata
from swarmproof.motion.lattice import Floats
from swarmproof.qp.solvers import Status


class Outcome(StrEnum):
    """What became of a CU's attempt to plan a UAV."""

    ADOPTED = "adopted"
    #: There was a plan, but the UAV did not get it.
    NOT_ADOPTED = "not adopted"
    #: There was an answer, but no plan: it did not pass the exact test, or the solver gave up.
    REJECTED = "rejected"
    INFEASIBLE = "infeasible"


class Replanned(NamedTuple):
    """CU `cu` tried to plan UAV `uav` in round `k`; `why` says why no plan came out."""

    k: int
    cu: int
    uav: int
    outcome: Outcome
    why: str


class Lost(NamedTuple):
    """Messages lost in one round: metadata on the way to CUs, what was in the slots to CUs, and to UAVs."""

    metadata_at_cus: int
    slots_at_cus: int
    slots_at_uavs: int


class Logged(NamedTuple):
    """One round.

    Attributes:
        motion: of the references, shape (N, 4, 3): position, velocity, acceleration at its start, jerk (lattice units).
        states: of the CUs in its computation phase.
    """

    motion: Floats
    states: tuple[CuState, ...]
    replanned: tuple[Replanned, ...]
    lost: Lost


@dataclass
class Log:
    """The flight so far, from round 0 on."""

    flight: Flight
    rounds: list[Logged] = field(default_factory=list)

    def see(self, flown: Round) -> None:
        """Keep what happened in one more round."""
        before = flown.before
        plans = [before.followed(i) for i in range(len(before.swarm.uavs))]
        attempts = enumerate(flown.computed.attempts)
        self.rounds.append(
            Logged(
                np.array([[*plan.state_at(before.k), plan.jerk_in(before.k)] for plan in plans]),
                tuple(cu.state for cu in before.swarm.cus),
                tuple(_replanned(flown, w, attempt) for w, attempt in attempts if attempt is not None),
                Lost(
                    sum(len(got.lost_uavs) for got in flown.at_cus),
                    sum(len(got.lost_slots) for got in flown.at_cus),
                    sum(len(got.lost_slots) for got in flown.at_uavs),
                ),
            )
        )

    def positions(self, per_round: int, first: int = 0, last: int | None = None) -> Floats:
        """Return where the references are (m) in the rounds `first` … `last` − 1, shape (R · per_round + 1, N, 3).

        Times are equally spaced, `per_round` to a round, from the start of round `first` to the end of the last one.
        """
        motion = np.array([logged.motion for logged in self.rounds[first:last]])
        lattice = self.flight.lattice
        # steps T_c since the start of the round
        s: Floats = np.arange(per_round + 1, dtype=float)[:, None, None] * (lattice.steps / per_round)
        there = moved(motion[:, None], s)
        begins = there[:, :-1].reshape(-1, *there.shape[2:])
        return np.concatenate([begins, there[-1, -1:]]) * float(lattice.position_unit) + self._origin

    def at(self, time: float) -> Floats:
        """Return where the references are (m) at `time` (s) of the flight, shape (N, 3)."""
        lattice = self.flight.lattice
        step = time / float(lattice.parameters.T_c)
        k = min(int(step / lattice.steps), len(self.rounds) - 1)
        return moved(self.rounds[k].motion, step - k * lattice.steps) * float(lattice.position_unit) + self._origin

    @property
    def _origin(self) -> Floats:
        return np.array(self.flight.origin, float)


def moved(motion: Floats, s: Floats | float) -> Floats:
    """Return positions (lattice units) `s` steps T_c later; `motion` has its four rows in the axis before the last."""
    p, v, a, u = (motion[..., row, :] for row in range(4))
    there: Floats = p + 3 * v * s + 3 * a * s**2 + u * s**3
    return there


def _replanned(flown: Round, w: int, attempt: Attempt) -> Replanned:
    """Return what became of an attempt of CU w."""
    k, i, planned = flown.before.k, attempt.task.i, attempt.planned
    if planned.plan is not None:
        got_it = flown.after.swarm.uavs[i].followed.metadata == Metadata(k, w)
        outcome = Outcome.ADOPTED if got_it else Outcome.NOT_ADOPTED
    else:
        outcome = Outcome.INFEASIBLE if planned.status is Status.INFEASIBLE else Outcome.REJECTED
    return Replanned(k, w, i, outcome, planned.why)
