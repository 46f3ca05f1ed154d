"""Single rounds of single swarms on the readable model: what the packed search found, told in losses and decisions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit
from swarmproof.dmpc_swarm.protocol.messages import Trajectory
from swarmproof.dmpc_swarm.protocol.network import Air, Reception, cu_receptions, uav_receptions
from swarmproof.dmpc_swarm.protocol.swarm import Events, Swarm, all_decisions, compute, step
from swarmproof.dmpc_swarm.protocol.uav import Uav, adopt, offers
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.dmpc_swarm.semantics import Semantics


def cheapest_events(swarm: Swarm, semantics: Semantics, lossless: bool = False) -> Iterator[tuple[Events, Swarm]]:
    """Yield every distinct outcome of the next round, each with events that lose the fewest messages for it.

    With `lossless`, only the outcomes that lose none.
    """
    for decided in all_decisions(swarm, semantics):
        computed, air = compute(swarm, decided, semantics)
        at_cus = [_at_cu(cu, air, len(swarm.cus), semantics, lossless) for cu in computed]
        at_uavs = [_at_uav(uav, air, semantics, lossless) for uav in swarm.uavs]
        for cus in product(*(at.items() for at in at_cus)):
            for uavs in product(*(at.items() for at in at_uavs)):
                events = Events(
                    decided,
                    tuple(reception for _, reception in cus),
                    tuple(reception for _, (reception, _) in uavs),
                    tuple(adopted for _, (_, adopted) in uavs),
                )
                yield events, Swarm(swarm.k + 1, tuple(uav for uav, _ in uavs), tuple(cu for cu, _ in cus))


def _at_cu(cu: ComputeUnit, air: Air, cus: int, semantics: Semantics, lossless: bool) -> dict[ComputeUnit, Reception]:
    cheapest: dict[ComputeUnit, Reception] = {}
    for reception in cu_receptions(cu.w, air, semantics):
        if lossless and reception.lost:
            continue
        after = algorithm1.update(cu, reception.inbox, cus, semantics)
        if after not in cheapest or reception.lost < cheapest[after].lost:
            cheapest[after] = reception
    return cheapest


def _at_uav(uav: Uav, air: Air, semantics: Semantics, lossless: bool) -> dict[Uav, tuple[Reception, Trajectory | None]]:
    cheapest: dict[Uav, tuple[Reception, Trajectory | None]] = {}
    for reception in uav_receptions(uav.i, air, semantics):
        if lossless and reception.lost:
            continue
        for adopted in offers(uav, reception.inbox) or (None,):
            after = adopt(uav, reception.inbox, adopted)
            if after not in cheapest or reception.lost < cheapest[after][0].lost:
                cheapest[after] = reception, adopted
    return cheapest


def follow(rounds: Rounds, begin: Swarm, path: Sequence[int], lossless_from: int | None = None) -> list[Events]:
    """Return events that take the readable model from `begin` along the packed swarms of `path` (its key first).

    From position `lossless_from` of the path on, nothing may be lost. What the search called a round must be one of
    the readable model: AssertionError otherwise.
    """
    swarm, told = begin, []
    assert rounds.pack(begin) == path[0]
    for position, key in enumerate(path[1:]):
        lossless = lossless_from is not None and position >= lossless_from
        fitting = [
            (events.lost, number, events)
            for number, (events, after) in enumerate(cheapest_events(swarm, rounds.semantics, lossless))
            if rounds.pack(after) == key
        ]
        assert fitting, "the search took a round that the readable model cannot take"
        events = min(fitting)[2]
        told.append(events)
        swarm = step(swarm, events, rounds.semantics)
    return told
