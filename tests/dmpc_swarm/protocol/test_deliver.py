"""Delivery: what everyone receives under given losses is what the network's own rules say, fast or not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

import numpy as np
import pytest
from tests.faults.test_losses import arrays

from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.dmpc_swarm.protocol.deliver import deliver
from swarmproof.dmpc_swarm.protocol.messages import (
    CuMessage,
    EmptyMessage,
    Metadata,
    Trajectory,
    TrajectoryMessage,
    TrajectoryRequestMessage,
    UavMessage,
)
from swarmproof.dmpc_swarm.protocol.network import Air, Reception, Slot, receive_at_cu, receive_at_uav
from swarmproof.dmpc_swarm.protocol.swarm import Events, Swarm, compute, initial_swarm, step
from swarmproof.dmpc_swarm.protocol.uav import offers
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.faults.grammar import parse
from swarmproof.faults.losses import Jam, Losses, LossModel, nothing_lost

Delivered = tuple[tuple[Reception, ...], tuple[Reception, ...]]
SEMANTICS = [Semantics.parse("guarded", [f"slot_conflict={value}"]) for value in ("either", "both-lost", "cu-wins")]
EVERY = pytest.mark.parametrize("semantics", SEMANTICS, ids=lambda s: s.slot_conflict)


def slowly(air: Air, losses: Losses, semantics: Semantics) -> Delivered:
    """Ask the network about each receiver on its own."""
    cus, uavs = losses.cu_uav.shape
    return (
        tuple(
            receive_at_cu(
                w,
                air,
                {i for i in range(uavs) if losses.cu_uav[w, i]},
                {s for s in range(cus) if losses.cu_slot[w, s]},
                {s for s in range(cus) if losses.replies_at_cus[w, s]},
                semantics,
            )
            for w in range(cus)
        ),
        tuple(
            receive_at_uav(
                i,
                air,
                {s for s in range(cus) if losses.uav_slot[i, s]},
                {s for s in range(cus) if losses.replies_at_uavs[i, s]},
                semantics,
            )
            for i in range(uavs)
        ),
    )


def carelessly(air: Air, losses: Losses, semantics: Semantics) -> Delivered:
    """Share receptions between all UAVs of equal losses, also those that reply."""
    at_cus, at_uavs = slowly(air, losses, semantics)
    first: dict[bytes, Reception] = {}
    for i, got in enumerate(at_uavs):
        first.setdefault(losses.uav_slot[i].tobytes() + losses.replies_at_uavs[i].tobytes(), got)
    return at_cus, tuple(
        first[losses.uav_slot[i].tobytes() + losses.replies_at_uavs[i].tobytes()] for i in range(len(at_uavs))
    )


def without_coins(air: Air, losses: Losses, semantics: Semantics) -> Delivered:
    """Never decode a reply."""
    quiet = nothing_lost(*losses.uav_slot.shape)
    deaf_to_replies = Losses(
        losses.cu_uav, losses.cu_slot, losses.uav_slot, quiet.replies_at_cus, quiet.replies_at_uavs
    )
    return slowly(air, deaf_to_replies, semantics)


def reply(uav: int) -> TrajectoryMessage:
    """Return a UAV's reply."""
    return TrajectoryMessage(uav, Trajectory(Metadata(3, uav)))


def small_cases() -> Iterator[tuple[Air, Losses]]:
    """Yield everything that 2 UAVs and 2 CUs can have in their slots, with every pattern of losses at a receiver.

    The receivers' marks go through all patterns at UAVs; those at CUs are derived, as no CU looks at another's.
    """
    plan = TrajectoryMessage(1, Trajectory(Metadata(5, 0)))
    slots = [Slot(message, answer) for message in (None, plan) for answer in (None, reply(0), reply(1))]
    bits = [np.array(pattern).reshape(2, 2) for pattern in product([False, True], repeat=4)]
    for on_slots in product(slots, repeat=2):
        air = Air((UavMessage(Metadata(3, 0)), UavMessage(Metadata(4, 1))), on_slots)
        for (n, lost), (m, decoded) in product(enumerate(bits), repeat=2):
            yield air, Losses(bits[(n + m) % 16], bits[(n + 5 * m) % 16], lost, bits[(3 * n + m) % 16], decoded)


def large_cases(count: int) -> Iterator[tuple[Air, Losses]]:
    """Yield cases of 16 UAVs and 3 CUs with anything in the slots and half of all pairs lost."""
    rng = np.random.default_rng(11)
    drawn = parse("iid:0.5", 16, 3, 1)
    for k in range(count):
        metadata = tuple(UavMessage(Metadata(k - int(age), 0)) for age in rng.integers(1, 9, 16))
        on_slots = []
        for w in range(3):
            asked, planned = (int(i) for i in rng.integers(0, 16, 2))
            messages: list[CuMessage | None] = [
                None,
                EmptyMessage(),
                TrajectoryRequestMessage(asked),
                TrajectoryMessage(planned, Trajectory(Metadata(k, w))),
            ]
            answers = [None, reply(int(rng.integers(16)))]
            on_slots.append(Slot(messages[rng.integers(4)], answers[rng.integers(2)]))
        yield Air(metadata, tuple(on_slots)), drawn.losses(k)


def agree(
    quick: Callable[[Air, Losses, Semantics], Delivered], cases: Iterator[tuple[Air, Losses]], semantics: Semantics
) -> bool:
    """Return whether a way to deliver gives what the network says in all cases."""
    return all(quick(air, losses, semantics) == slowly(air, losses, semantics) for air, losses in cases)


@EVERY
def test_delivery_follows_the_network(semantics: Semantics) -> None:
    """Everyone receives what the network says: all slots and marks at 2 UAVs and 2 CUs, and 200 rounds at 16 and 3."""
    assert agree(deliver, small_cases(), semantics)
    assert agree(deliver, large_cases(200), semantics)


def test_careless_deliveries_are_noticed() -> None:
    """The comparison fails for a delivery that lets a replying UAV hear itself, and for one that decodes no replies."""
    for bad in (carelessly, without_coins):
        assert not agree(bad, small_cases(), SEMANTICS[0])
        assert not agree(bad, large_cases(200), SEMANTICS[0])


def test_losses_of_another_swarm_are_refused() -> None:
    """Losses for another number of UAVs or CUs than are on the air raise ValueError."""
    air = Air((UavMessage(Metadata(-1, -1)),) * 4, (Slot(EmptyMessage(), None),) * 2)
    deliver(air, nothing_lost(4, 2), SEMANTICS[0])
    for uavs, cus in ((3, 2), (5, 2), (4, 1), (4, 3), (2, 4)):
        with pytest.raises(ValueError, match="do not fit"):
            deliver(air, nothing_lost(uavs, cus), SEMANTICS[0])


# --- flights -------------------------------------------------------------------------------------------------------

GUARDED = Semantics.parse("guarded", ["initial=known", "event_trigger=round-robin"])


def fly(
    uavs: int, cus: int, semantics: Semantics, model: LossModel, rounds: int
) -> Iterator[tuple[Swarm, tuple[Reception, ...], tuple[Reception, ...]]]:
    """Yield, round by round, the swarm in the computation phase and what its CUs and UAVs then receive.

    Every CU takes its first decision, every UAV the first trajectory that it is offered.
    """
    swarm = initial_swarm(uavs, cus, semantics)
    for k in range(rounds):
        decided = tuple(algorithm1.decisions(cu, k, cus, semantics)[0] for cu in swarm.cus)
        _, air = compute(swarm, decided, semantics)
        at_cus, at_uavs = deliver(air, model.losses(k), semantics)
        yield swarm, at_cus, at_uavs
        adopted = tuple((*offers(uav, got.inbox), None)[0] for uav, got in zip(swarm.uavs, at_uavs, strict=True))
        swarm = step(swarm, Events(decided, at_cus, at_uavs, adopted), semantics)


@pytest.mark.parametrize("cus", [2, 3])
def test_a_jam_stops_all_cus_and_no_uav(cus: int) -> None:
    """In a jam every CU leaves RUN_DMPC, while UAVs hear all; afterwards all CUs come back, and the swarm goes on."""
    start, rounds, uavs = 6, 10, 4
    flown = list(fly(uavs, cus, GUARDED, parse(f"jam:2,{rounds}", uavs, cus, 0, target_change=4), start + rounds + 30))
    running = [[cu.state is CuState.RUN_DMPC for cu in swarm.cus] for swarm, _, _ in flown]
    # what is lost in round k shows in the computation phase of round k + 1
    for k in range(start + 1):
        assert all(running[k])
    for k in range(start + 1, start + rounds + 1):
        assert not any(running[k])
    assert all(running[-1])
    for k, (_, at_cus, at_uavs) in enumerate(flown):
        assert not any(got.lost for got in at_uavs)
        for w, got in enumerate(at_cus):
            if start <= k < start + rounds:
                assert not got.inbox.uav_messages
                assert set(got.inbox.cu_messages) <= {w}
            else:
                assert got.lost == 0
    adopted = [[uav.followed for uav in swarm.uavs] for swarm, _, _ in flown]
    assert adopted[start] != adopted[start + 1]  # planned before the jam was noticed, and heard in it
    assert adopted[start + 1] == adopted[start + rounds + 1]
    assert adopted[start + rounds + 1] != adopted[-1]


def replies_heard(model: Jam) -> int:
    """Return how many replies CUs that had donated their slots hear in twelve jammed rounds."""
    return sum(
        w in got.inbox.cu_messages and w not in sent
        for swarm, at_cus, _ in fly(3, 2, GUARDED, model, 12)
        for sent in [{cu.w for cu in swarm.cus if cu.state is not CuState.WAIT_FOR_UPDATE}]
        for w, got in enumerate(at_cus)
    )


def test_a_jammed_cu_does_not_hear_the_reply_in_its_own_slot() -> None:
    """A CU that has donated its slot is silent in it, so a jam takes the reply, too; its own messages it always has."""
    jam = Jam(3, 2, 0, 12)
    assert replies_heard(jam) == 0

    class OwnSlotOpen(Jam):
        def losses(self, k: int) -> Losses:
            lost = super().losses(k)
            return Losses(lost.cu_uav, lost.cu_slot & ~np.eye(2, dtype=bool), *arrays(lost)[2:])

    assert replies_heard(OwnSlotOpen(3, 2, 0, 12)) > 0
    for swarm, at_cus, _ in fly(3, 2, GUARDED, jam, 12):
        for cu, got in zip(swarm.cus, at_cus, strict=True):
            assert (cu.w in got.inbox.cu_messages) == (cu.state is not CuState.WAIT_FOR_UPDATE)


def test_flights_with_drawn_losses_repeat() -> None:
    """Two flights with the same losses are equal, round by round; with another seed they are not."""
    one, again, other = (
        [swarm for swarm, _, _ in fly(4, 2, GUARDED, parse("iid:0.1", 4, 2, seed), 60)] for seed in (1, 1, 2)
    )
    assert one == again
    assert one != other
