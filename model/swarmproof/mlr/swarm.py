"""The swarm, and one round of it in order: computation, communication, adoption (Section 3.1, eq. 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from swarmproof.mlr import algorithm1
from swarmproof.mlr.algorithm1 import ComputeUnit, Decision
from swarmproof.mlr.messages import Trajectory
from swarmproof.mlr.network import Air, Reception, on_air
from swarmproof.mlr.uav import Uav, adopt
from swarmproof.semantics.switches import Semantics


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


def compute(
    swarm: Swarm, decided: Sequence[Decision], semantics: Semantics
) -> tuple[tuple[ComputeUnit, ...], Air]:
    """Finish the computation phase (Alg. 1 lines 12-34): the CUs after it, and everything that is transmitted."""
    results = [
        algorithm1.transmit(cu, swarm.k, decision, semantics)
        for cu, decision in zip(swarm.cus, decided, strict=True)
    ]
    return tuple(cu for cu, _ in results), on_air(swarm.uavs, [message for _, message in results])


def finish_round(
    swarm: Swarm,
    computed: Sequence[ComputeUnit],
    at_cus: Sequence[Reception],
    at_uavs: Sequence[Reception],
    adopted: Sequence[Trajectory | None],
    semantics: Semantics,
) -> Swarm:
    """Return the swarm in the next computation phase, given what every receiver got and what the UAVs adopted."""
    cus = len(swarm.cus)
    return Swarm(
        swarm.k + 1,
        tuple(
            adopt(uav, got.inbox, new) for uav, got, new in zip(swarm.uavs, at_uavs, adopted, strict=True)
        ),
        tuple(
            algorithm1.update(cu, got.inbox, cus, semantics) for cu, got in zip(computed, at_cus, strict=True)
        ),
    )
