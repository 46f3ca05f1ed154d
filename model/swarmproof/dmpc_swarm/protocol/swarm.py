"""The swarm, and one round of it in order: computation, communication, adoption (Section 3.1, eq. 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit, Decision
from swarmproof.dmpc_swarm.protocol.messages import Trajectory
from swarmproof.dmpc_swarm.protocol.network import Air, Reception, on_air
from swarmproof.dmpc_swarm.protocol.uav import Uav, adopt
from swarmproof.dmpc_swarm.semantics import Semantics


@dataclass(frozen=True, slots=True)
class Swarm:
    """All UAVs and CUs in the computation phase of round k, after Algorithm 2 and Alg. 1 lines 8-11 on every CU."""

    k: int
    uavs: tuple[Uav, ...]
    cus: tuple[ComputeUnit, ...]


def initial_swarm(uavs: int, cus: int, semantics: Semantics) -> Swarm:
    """Return the swarm in the computation phase of round 0: every UAV hovers."""
    return Swarm(
        0,
        tuple(Uav(i) for i in range(uavs)),
        tuple(algorithm1.initial(w, uavs, cus, semantics) for w in range(cus)),
    )


def all_decisions(swarm: Swarm, semantics: Semantics) -> list[tuple[Decision, ...]]:
    """Return every combination of decisions that the CUs can take in this round."""
    options = [
        tuple(
            (decision, algorithm1.is_exclusive(cu, decision, semantics))
            for decision in algorithm1.decisions(cu, swarm.k, len(swarm.cus), semantics)
        )
        for cu in swarm.cus
    ]
    return algorithm1.joint_decisions(options)


def forbidden(swarm: Swarm, decided: Sequence[Decision], semantics: Semantics) -> str | None:
    """Return why the CUs cannot decide so in this round; None if they can."""
    taken = set()
    for cu, decision in zip(swarm.cus, decided, strict=True):
        options = algorithm1.decisions(cu, swarm.k, len(swarm.cus), semantics)
        if decision not in options:
            return f"CU {cu.w} in {cu.state.name} decides {decision}, but can only decide one of {list(options)}"
        if algorithm1.is_exclusive(cu, decision, semantics):
            if decision in taken:
                return f"two CUs plan UAV {decision}"
            taken.add(decision)
    return None


def compute(swarm: Swarm, decided: Sequence[Decision], semantics: Semantics) -> tuple[tuple[ComputeUnit, ...], Air]:
    """Finish the computation phase (Alg. 1 lines 12-34): the CUs after it, and everything that is transmitted."""
    results = [
        algorithm1.transmit(cu, swarm.k, decision, semantics) for cu, decision in zip(swarm.cus, decided, strict=True)
    ]
    return tuple(cu for cu, _ in results), on_air(swarm.uavs, [message for _, message in results])


@dataclass(frozen=True, slots=True)
class Events:
    """Everything about one round that the algorithms do not determine.

    Attributes:
        decided: by CU, whom it plans or asks (:func:`all_decisions`).
        at_cus: by CU, what it receives.
        at_uavs: by UAV, what it receives.
        adopted: by UAV, which of the new trajectories that it received it follows; None if it received none.
    """

    decided: tuple[Decision, ...]
    at_cus: tuple[Reception, ...]
    at_uavs: tuple[Reception, ...]
    adopted: tuple[Trajectory | None, ...]

    @property
    def lost(self) -> int:
        """The number of (message, receiver) pairs lost in this round."""
        return sum(reception.lost for reception in (*self.at_cus, *self.at_uavs))


def step(swarm: Swarm, events: Events, semantics: Semantics) -> Swarm:
    """Return the swarm in the computation phase of the next round."""
    computed, _air = compute(swarm, events.decided, semantics)
    cus = len(swarm.cus)
    return Swarm(
        swarm.k + 1,
        tuple(
            adopt(uav, got.inbox, new) for uav, got, new in zip(swarm.uavs, events.at_uavs, events.adopted, strict=True)
        ),
        tuple(
            algorithm1.update(cu, got.inbox, cus, semantics) for cu, got in zip(computed, events.at_cus, strict=True)
        ),
    )
