"""The network: replies, losses, and what is heard when two devices transmit in one slot."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from swarmproof.dmpc_swarm.protocol.messages import (
    HOVERING,
    CuMessage,
    EmptyMessage,
    Metadata,
    Trajectory,
    TrajectoryMessage,
    TrajectoryRequestMessage,
    UavMessage,
)
from swarmproof.dmpc_swarm.protocol.network import (
    Air,
    Reception,
    Slot,
    cu_receptions,
    on_air,
    receive_at_cu,
    receive_at_uav,
    uav_receptions,
)
from swarmproof.dmpc_swarm.protocol.swarm import Events, Swarm, compute, initial_swarm, step
from swarmproof.dmpc_swarm.protocol.uav import Uav, adopt, offers
from swarmproof.dmpc_swarm.semantics import Semantics

A, NEW = Trajectory(Metadata(3, 1)), Trajectory(Metadata(7, 0))
EITHER, BOTH_LOST, CU_WINS = (
    Semantics.parse("printed", [f"slot_conflict={value}"]) for value in ("either", "both-lost", "cu-wins")
)
EVERY = pytest.mark.parametrize("semantics", [EITHER, BOTH_LOST, CU_WINS], ids=lambda s: s.slot_conflict)
MESSAGE = EmptyMessage()
REPLY = TrajectoryMessage(0, A)


def air(*slots: Slot, uavs: int = 2) -> Air:
    """Return what is transmitted: these slots, and the metadata of A by every UAV."""
    return Air((UavMessage(A.metadata),) * uavs, slots)


def heard(receptions: Iterable[Reception], slot: int) -> set[tuple[CuMessage | None, bool]]:
    """Return what can be received in a slot: (message or None, whether that is a loss)."""
    return {(got.inbox.cu_messages.get(slot), slot in got.lost_slots) for got in receptions}


def only(message: CuMessage | None) -> set[tuple[CuMessage | None, bool]]:
    """Return that one thing is heard, without a loss."""
    return {(message, False)}


LOST = (None, True)
CONFLICT = air(Slot(MESSAGE, REPLY), Slot(MESSAGE, None))


@EVERY
def test_a_sender_has_its_own_message(semantics: Semantics) -> None:
    """A CU that transmits always has its own message, also in a conflict."""
    for slot in (Slot(MESSAGE, None), Slot(MESSAGE, REPLY)):
        assert heard(cu_receptions(0, air(slot), semantics), 0) == only(MESSAGE)


@EVERY
def test_any_message_may_be_lost(semantics: Semantics) -> None:
    """A message alone in its slot is received or lost, at CUs and UAVs; so is a reply."""
    for slot, content in ((Slot(MESSAGE, None), MESSAGE), (Slot(None, REPLY), REPLY)):
        expected = {(content, False), LOST}
        assert heard(cu_receptions(1, air(slot, Slot(MESSAGE, None)), semantics), 0) == expected
        assert heard(uav_receptions(1, air(slot), semantics), 0) == expected


@EVERY
def test_a_cu_hears_the_reply_in_the_slot_that_it_donated(semantics: Semantics) -> None:
    """The owner of a slot, being silent in it, receives the reply or loses it."""
    assert heard(cu_receptions(0, air(Slot(None, REPLY)), semantics), 0) == {(REPLY, False), LOST}


@EVERY
def test_in_an_empty_slot_nothing_is_lost(semantics: Semantics) -> None:
    """A slot in which nobody transmits gives no message, and no loss."""
    empty = air(Slot(None, None))
    assert heard(cu_receptions(0, empty, semantics), 0) == only(None)
    assert heard(uav_receptions(0, empty, semantics), 0) == only(None)


CONFLICTS = {
    # switch value: (another CU, another UAV, the replying UAV)
    "either": (
        {(MESSAGE, False), (REPLY, False), LOST},
        {(MESSAGE, False), (REPLY, False), LOST},
        only(None),
    ),
    "both-lost": (only(None), only(None), only(None)),
    "cu-wins": ({(MESSAGE, False), LOST}, {(MESSAGE, False), LOST}, {(MESSAGE, False), LOST}),
}


@EVERY
def test_what_is_heard_in_a_conflict(semantics: Semantics) -> None:
    """Every kind of receiver hears in a conflict what slot_conflict says."""
    other_cu, other_uav, replying = CONFLICTS[semantics.slot_conflict]
    assert heard(cu_receptions(1, CONFLICT, semantics), 0) == other_cu
    assert heard(uav_receptions(1, CONFLICT, semantics), 0) == other_uav
    assert heard(uav_receptions(0, CONFLICT, semantics), 0) == replying
    assert heard(cu_receptions(0, CONFLICT, semantics), 0) == only(MESSAGE)


@EVERY
def test_a_uav_does_not_hear_its_own_reply(semantics: Semantics) -> None:
    """In a slot in which only it transmits, a UAV gets nothing and loses nothing."""
    assert heard(uav_receptions(0, air(Slot(None, REPLY)), semantics), 0) == only(None)


def test_a_decoded_reply_is_remembered() -> None:
    """slot_conflict=either: a reception says in which slots the reply was decoded, not the CU's message."""
    decoded = {
        got.inbox.cu_messages.get(0): got.decoded_replies
        for got in cu_receptions(1, CONFLICT, EITHER)
        if not got.lost_slots
    }
    assert decoded == {MESSAGE: (), REPLY: (0,)}


@EVERY
def test_receptions_are_all_subsets(semantics: Semantics) -> None:
    """A CU loses any subset of two UAVs' metadata and of the other CUs' messages, each subset once."""
    quiet = air(*[Slot(MESSAGE, None)] * 3)
    receptions = list(cu_receptions(1, quiet, semantics))
    losses = {(got.lost_uavs, got.lost_slots) for got in receptions}
    assert len(receptions) == len(losses) == 2**4
    assert max(got.lost for got in receptions) == 4
    for got in receptions:
        assert set(got.inbox.uav_messages) == {0, 1} - set(got.lost_uavs)
        assert set(got.inbox.cu_messages) == {0, 1, 2} - set(got.lost_slots)


@EVERY
def test_a_uav_loses_any_subset_of_the_slots(semantics: Semantics) -> None:
    """A UAV loses any subset of the CUs' messages; the metadata of other UAVs are not counted for it."""
    receptions = list(uav_receptions(0, air(*[Slot(MESSAGE, None)] * 3), semantics))
    assert sorted(got.lost_slots for got in receptions) == [(), (0,), (0, 1), (0, 1, 2), (0, 2), (1,), (1, 2), (2,)]
    assert all(not got.lost_uavs for got in receptions)


@EVERY
def test_a_reception_can_be_told_by_its_losses(semantics: Semantics) -> None:
    """What is lost and decoded determines what is received, for every receiver."""
    busy = air(Slot(MESSAGE, REPLY), Slot(TrajectoryMessage(1, NEW), None), Slot(None, TrajectoryMessage(1, A)))
    for w in range(3):
        for got in cu_receptions(w, busy, semantics):
            assert receive_at_cu(w, busy, got.lost_uavs, got.lost_slots, got.decoded_replies, semantics) == got
    for i in range(2):
        for got in uav_receptions(i, busy, semantics):
            assert receive_at_uav(i, busy, got.lost_slots, got.decoded_replies, semantics) == got


def test_what_was_not_sent_cannot_be_lost() -> None:
    """A loss in an empty slot, or of a CU's own message, is ignored."""
    got = receive_at_cu(0, air(Slot(MESSAGE, None), Slot(None, None)), (), (0, 1), (), EITHER)
    assert got.lost == 0
    assert got.inbox.cu_messages == {0: MESSAGE}


# --- replies -------------------------------------------------------------------------------------------------------


def test_every_uav_transmits_the_metadata_of_what_it_follows() -> None:
    """Every round, every UAV transmits the metadata of the trajectory that it follows in that round."""
    sent = on_air([Uav(0, A), Uav(1)], [MESSAGE, MESSAGE])
    assert sent.uav_messages == (UavMessage(A.metadata), UavMessage(HOVERING.metadata))
    assert sent.slots == (Slot(MESSAGE, None), Slot(MESSAGE, None))


def test_a_uav_replies_in_the_slot_of_the_cu_that_asked() -> None:
    """A reply carries the full trajectory that the UAV follows, no priorities, in the donated slot."""
    sent = on_air([Uav(0), Uav(1, A, frozenset({0}))], [None, MESSAGE])
    assert sent.slots == (Slot(None, TrajectoryMessage(1, A, None)), Slot(MESSAGE, None))


def test_a_uav_asked_by_two_cus_answers_in_both_slots() -> None:
    """Two requests are answered twice."""
    sent = on_air([Uav(0, A, frozenset({0, 1}))], [None, None])
    assert sent.slots == (Slot(None, TrajectoryMessage(0, A)),) * 2


def test_a_cu_that_transmits_in_its_donated_slot_makes_a_conflict() -> None:
    """A slot with a message and a reply is a conflict; one of them alone, or none, is not."""
    sent = on_air([Uav(0, A, frozenset({0}))], [MESSAGE, MESSAGE])
    assert [slot.conflict for slot in sent.slots] == [True, False]
    assert not Slot(None, REPLY).conflict
    assert not Slot(None, None).conflict


def _round(swarm: Swarm, semantics: Semantics, unheard: dict[int, tuple[int, ...]] | None = None) -> Swarm:
    """Take a round with the first decisions, in which UAV i loses the slots `unheard[i]` and nobody else anything."""
    decided: tuple[int | None, ...] = tuple(0 if cu.state.name == "REQUEST_TRAJECTORY" else None for cu in swarm.cus)
    _, sent = compute(swarm, decided, semantics)
    at_cus = tuple(receive_at_cu(w, sent, (), (), (), semantics) for w in range(len(swarm.cus)))
    at_uavs = tuple(receive_at_uav(i, sent, (unheard or {}).get(i, ()), (), semantics) for i in range(len(swarm.uavs)))
    adopted = tuple((*offers(uav, got.inbox), None)[0] for uav, got in zip(swarm.uavs, at_uavs, strict=True))
    return step(swarm, Events(decided, at_cus, at_uavs, adopted), semantics)


def test_a_request_that_does_not_arrive_leaves_the_slot_empty() -> None:
    """If the UAV does not hear the request, nobody transmits in the donated slot of the next round."""
    swarm = _round(initial_swarm(1, 1, EITHER), EITHER, unheard={0: (0,)})
    assert swarm.uavs[0].asked_by == frozenset()
    _, sent = compute(swarm, (None,), EITHER)
    assert sent.slots == (Slot(None, None),)


def test_a_request_is_answered_once_in_the_next_round() -> None:
    """A request of round k is answered in round k+1, and not again in round k+2."""
    swarm = _round(initial_swarm(1, 1, EITHER), EITHER)
    assert swarm.uavs[0].asked_by == {0}
    _, sent = compute(swarm, (None,), EITHER)
    assert sent.slots == (Slot(None, TrajectoryMessage(0, HOVERING)),)
    assert _round(swarm, EITHER).uavs[0].asked_by == frozenset()


def test_both_cus_may_ask_one_uav() -> None:
    """Two CUs that ask the same UAV in one round both get their slots answered."""
    swarm = _round(initial_swarm(2, 2, EITHER), EITHER)
    assert swarm.uavs[0].asked_by == {0, 1}
    assert swarm.uavs[1].asked_by == frozenset()
    _, sent = compute(swarm, (None, None), EITHER)
    assert [slot.reply for slot in sent.slots] == [TrajectoryMessage(0, HOVERING)] * 2


# --- what a UAV makes of it ----------------------------------------------------------------------------------------


def _at_uav(*messages: CuMessage) -> Reception:
    return receive_at_uav(0, air(*(Slot(message, None) for message in messages)), (), (), EITHER)


def test_a_uav_follows_a_new_trajectory_from_the_next_round() -> None:
    """Eq. 10: a trajectory for the UAV that was received is followed; without one it goes on as before."""
    uav = Uav(0, A)
    got = _at_uav(TrajectoryMessage(0, NEW))
    assert offers(uav, got.inbox) == (NEW,)
    assert adopt(uav, got.inbox, NEW) == Uav(0, NEW)
    assert adopt(uav, _at_uav(MESSAGE).inbox, None) == Uav(0, A)


def test_trajectories_for_other_uavs_are_no_offers() -> None:
    """A UAV ignores new trajectories and replies of other UAVs."""
    assert offers(Uav(0, A), _at_uav(TrajectoryMessage(1, NEW), MESSAGE).inbox) == ()


def test_a_uav_with_several_offers_may_follow_any() -> None:
    """Two new trajectories in one round are both offered, in the order of their slots."""
    other = Trajectory(Metadata(7, 1))
    got = _at_uav(TrajectoryMessage(0, NEW), TrajectoryMessage(0, other))
    assert offers(Uav(0, A), got.inbox) == (NEW, other)


def test_a_uav_remembers_the_requests_for_itself_only() -> None:
    """Requests are kept by slot, those for other UAVs are not kept."""
    got = _at_uav(TrajectoryRequestMessage(0), TrajectoryRequestMessage(1), TrajectoryRequestMessage(0))
    assert adopt(Uav(0, A), got.inbox, None).asked_by == {0, 2}


def test_a_reply_carries_what_is_followed_in_its_own_round() -> None:
    """A UAV that receives a request and a new trajectory in one round replies with the new one."""
    got = _at_uav(TrajectoryRequestMessage(0), TrajectoryMessage(0, NEW))
    after = adopt(Uav(0, A), got.inbox, NEW)
    sent = on_air([after], [None, MESSAGE])
    assert sent.slots[0].reply == TrajectoryMessage(0, NEW)
    assert sent.uav_messages == (UavMessage(NEW.metadata),)
