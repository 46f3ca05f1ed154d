"""The run told in sentences, round by round, each with the place in the paper that says so."""

from __future__ import annotations

from dataclasses import dataclass

from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.explain import Explained, explain_in, slot_at
from swarmproof.dmpc_swarm.pages.swarm_run import SwarmRun
from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit, CuState
from swarmproof.dmpc_swarm.protocol.event_trigger import select_uav
from swarmproof.dmpc_swarm.protocol.messages import HOVERING, Trajectory, TrajectoryMessage, TrajectoryRequestMessage
from swarmproof.dmpc_swarm.protocol.swarm import compute
from swarmproof.dmpc_swarm.protocol.uav import offers
from swarmproof.pages import phrases


@dataclass(frozen=True)
class Sentence:
    """A sentence, the place in the paper (or the switch) that it rests on, whether something is amiss, and details."""

    text: str
    place: str = ""
    amiss: bool = False
    details: tuple[str, ...] = ()


@dataclass(frozen=True)
class RoundStory:
    """One round in order.

    Attributes:
        update: Algorithm 2 and Alg. 1 lines 8-11, by CU.
        decide: Alg. 1 lines 12-32, by CU; empty at the end of the run.
        air: the communication phase, and what the UAVs do with it; empty at the end of the run.
    """

    update: tuple[Sentence, ...]
    decide: tuple[Sentence, ...] = ()
    air: tuple[Sentence, ...] = ()


def tell(replayed: SwarmRun, k: int) -> RoundStory:
    """Tell round k; of the last one there is only the computation phase up to where claims are read."""
    update = tuple(s for w in range(replayed.cus) for s in _update(replayed, w, k))
    if k == len(replayed.events):
        return RoundStory(update)
    decide = tuple(_decision(replayed, cu, k) for cu in replayed.swarms[k].cus)
    air = (*_slots(replayed, k), *_metadata(replayed, k), *_uavs(replayed, k))
    return RoundStory(update, decide, air)


def _update(replayed: SwarmRun, w: int, k: int) -> list[Sentence]:
    me = names.cu(w)
    if k == 0:
        if replayed.semantics.initial == "known":
            text = f"{me} knows that every UAV hovers; it starts in RUN_DMPC."
            return [Sentence(text, "initial=known, Remark 2")]
        text = f"{me} knows nothing: its trackers are empty and deprecated; it starts in REQUEST_TRAJECTORY."
        return [Sentence(text, "Alg. 1 lines 2-4")]
    before, after = replayed.swarms[k - 1].cus[w], replayed.swarms[k].cus[w]
    update = explain_in(replayed, w, k)
    sentences = []
    if replayed.semantics.loss_handling == "ignore":
        for i, tracker in enumerate(after.trackers):
            if tracker != before.trackers[i]:
                text = f"{me} puts what it received into its tracker of {names.uav(i)}: {names.entries(tracker[0])}."
                sentences.append(Sentence(text, "loss_handling=ignore"))
        sentences += [
            Sentence(f"{me} does not notice that it missed something: of slot {slot}, it {outcome}.", amiss=True)
            for slot, outcome in _missing(replayed, w, k - 1)
        ]
        return sentences or [Sentence(f"{me}: nothing new.")]
    sentences += _matching(w, before, update)
    sentences += _marking(replayed, w, k, update, before)
    sentences += _additions(replayed, w, k, update, before)
    sentences += _state(replayed, w, k)
    return sentences or [Sentence(f"{me}: its trackers and its state stay as they are ({after.state.name}).")]


def _missing(replayed: SwarmRun, w: int, k: int) -> list[tuple[int, str]]:
    got = replayed.events[k].at_cus[w]
    return [
        (slot, slot_at(replayed, k, slot, got)) for slot in range(replayed.cus) if slot not in got.inbox.cu_messages
    ]


def _matching(w: int, before: ComputeUnit, update: Explained) -> list[Sentence]:
    """Tell lines 3-11: which trackers are reduced, and which flags cleared for the moment."""
    me, sentences = names.cu(w), []
    for i, entry in update.matched.items():
        tracker, effects = before.trackers[i], []
        if len(tracker.trajectories) > 1:
            effects.append(f"reduced to {names.entries([entry])}")
        if tracker.deprecated:
            effects.append("marked up to date")
        if effects:
            text = f"{me}: {names.uav(i)}'s metadata, {names.trajectory(entry)}, matches an entry of its tracker, "
            sentences.append(Sentence(f"{text}which is {phrases.listing(effects)}.", "Alg. 2 lines 5-7"))
    if update.unmatched:
        several = len(update.unmatched) > 1
        of = phrases.listing([f"{names.uav(i)}'s" for i in update.unmatched])
        text = f"{me}: {of} metadata {'match' if several else 'matches'} no entry of its "
        text += "trackers; these are left as they are." if several else "tracker, which is left as it is."
        sentences.append(Sentence(text, "Alg. 2 line 5"))
    for i in update.unheard:
        text = f"{me}: without {names.uav(i)}'s metadata, its tracker {names.entries(before.trackers[i].trajectories)} "
        sentences.append(Sentence(text + "is neither reduced nor marked up to date.", "Alg. 2 line 3", amiss=True))
    return sentences


def _marking(replayed: SwarmRun, w: int, k: int, update: Explained, before: ComputeUnit) -> list[Sentence]:
    """Tell lines 12-14 and 17-19: which trackers become deprecated."""
    me, sentences = names.cu(w), []
    if update.several:
        which = "that tracker" if replayed.semantics.deprecation == "one" else "all its trackers"
        if replayed.semantics.deprecation == "one" and len(update.several) > 1:
            which = "these trackers"
        held = phrases.listing(
            [f"of {names.uav(i)} still {names.entries(before.trackers[i].trajectories)}" for i in update.several]
        )
        text = f"{me} holds {held}, more than one: {which} deprecated."
        sentences.append(Sentence(text, f"Alg. 2 line 13, deprecation={replayed.semantics.deprecation}", amiss=True))
    if update.all_marked:
        reasons = "; ".join(f"of slot {slot}, it {outcome}" for slot, outcome in _missing(replayed, w, k - 1))
        text = f"{me} has only {update.received} of {replayed.cus} CU messages: all its trackers deprecated"
        sentences.append(Sentence(f"{text} ({reasons}).", "Alg. 2 line 18", amiss=True))
    return sentences


def _additions(replayed: SwarmRun, w: int, k: int, update: Explained, before: ComputeUnit) -> list[Sentence]:
    """Tell lines 20-24: which trajectories are new in which tracker, and where they came from."""
    sources: dict[tuple[int, Trajectory], list[str]] = {}
    for slot, message in update.added.items():
        matched = update.matched.get(message.uav)
        held = before.trackers[message.uav].trajectories if matched is None else (matched,)
        if message.trajectory not in held:
            what = "the plan" if replayed.airs[k - 1].slots[slot].cu_message == message else "the reply"
            sources.setdefault((message.uav, message.trajectory), []).append(f"{what} in slot {slot}")
    return [
        Sentence(
            f"{names.cu(w)} adds {names.trajectory(new)}, {phrases.listing(source)}, to its tracker of {names.uav(i)}.",
            "Alg. 2 line 22",
        )
        for (i, new), source in sources.items()
    ]


def _state(replayed: SwarmRun, w: int, k: int) -> list[Sentence]:
    """Tell Alg. 1 lines 8-11: what becomes of the CU's state."""
    me, swarm = names.cu(w), replayed.swarms[k]
    computed, _ = compute(replayed.swarms[k - 1], replayed.events[k - 1].decided, replayed.semantics)
    was, now = computed[w].state, swarm.cus[w].state
    deprecated = [i for i, tracker in enumerate(swarm.cus[w].trackers) if tracker.deprecated]
    answering = [uav.i for uav in swarm.uavs if w in uav.asked_by]
    if was == now:
        if not deprecated and now is not CuState.RUN_DMPC:
            text = f"{me} has no deprecated tracker, but stays in {now.name} while its slot is donated."
            return [Sentence(text, "rejoin=after-reply")]
        return []
    if now is CuState.WAIT:
        text = f"{me} leaves RUN_DMPC for WAIT: its trackers of {names.uavs(deprecated)} are deprecated."
        return [Sentence(text, "Alg. 1 line 10")]
    text = f"{me} has no deprecated tracker: it goes from {was.name} to RUN_DMPC."
    sentences = [Sentence(text, "Alg. 1 line 9")]
    if answering:
        text = (
            f"{me} does so although it donated its slot of this round: {names.uavs(answering)} will answer its "
            f"request of round {k - 1} in slot {w}, and {me} will transmit there too."
        )
        sentences.append(Sentence(text, "Alg. 1 line 9, rejoin=any-state", amiss=True))
    return sentences


def _decision(replayed: SwarmRun, cu: ComputeUnit, k: int) -> Sentence:
    """Tell Alg. 1 lines 12-32 of one CU."""
    me, decided = names.cu(cu.w), replayed.events[k].decided[cu.w]
    if cu.state is CuState.WAIT:
        return Sentence(f"{me} waits: it sends an empty message, and will ask in the next round.", "Alg. 1 lines 22-24")
    if cu.state is CuState.REQUEST_TRAJECTORY:
        assert decided is not None
        text = f"{me} asks {names.uav(decided)} for its trajectory, and donates slot {cu.w} of round {k + 1} to it."
        return Sentence(text, f"Alg. 1 lines 25-28, request_order={replayed.semantics.request_order}")
    if cu.state is CuState.WAIT_FOR_UPDATE:
        return Sentence(f"{me} keeps silent: slot {cu.w} is donated.", "Alg. 1 lines 29-31")
    choice = ""
    if cu.a_et is not None:
        cus = replayed.cus
        selected = select_uav(cu.a_et, k, cu.w, cus)
        position = f"position ({k} + {cu.w}) mod {cus} = {(k + cu.w) % cus} of A_ET({k}) = {selection(cu.a_et)}"
        choice = f" ({position}{' is empty' if selected is None else ': ' + names.uav(selected)})"
        if selected is not None and decided is None:
            held = names.entries(cu.trackers[selected].trajectories)
            text = f"{me} plans nobody: it selects {names.uav(selected)} ({position}), but holds {held} for it, "
            return Sentence(f"{text}not one entry; it sends an empty message.", "Alg. 1 lines 15-17")
    if decided is None:
        return Sentence(f"{me} plans nobody{choice}: it sends an empty message.", "Alg. 1 lines 13-16")
    start = names.entries(cu.trackers[decided].trajectories)
    new = f"τ({k}, {me})"
    text = f"{me} plans {names.uav(decided)}{choice}: {new}, starting from {start}, the one entry of its tracker."
    follows = replayed.swarms[k].uavs[decided].followed
    amiss = cu.trackers[decided].trajectories != (follows,)
    if amiss:
        text += f" {names.uav(decided)} follows {names.trajectory(follows)} instead."
    return Sentence(text, "Alg. 1 lines 13-19", amiss)


def selection(a_et: tuple[int, ...]) -> str:
    """Return A_ET(k), highest priority first."""
    return "⟨" + ", ".join(names.uav(i) for i in a_et) + "⟩"


def _slots(replayed: SwarmRun, k: int) -> list[Sentence]:
    """Tell what happens in the CUs' slots, where it is more than that everybody gets the message."""
    sentences, events = [], replayed.events[k]
    receivers = [
        *((names.cu(w), got, None) for w, got in enumerate(events.at_cus)),
        *((names.uav(i), got, i) for i, got in enumerate(events.at_uavs)),
    ]
    for slot, sent in enumerate(replayed.airs[k].slots):
        if sent.cu_message is None and sent.reply is None:
            text = f"Slot {slot} stays empty: {names.cu(slot)} is silent, and no UAV was reached by a request for it."
            sentences.append(Sentence(text, amiss=True))
            continue
        if sent.conflict:
            text = f"Slot {slot} has two transmitters: {names.on_slot(slot, sent)}."
            outcomes = [
                f"{name} {slot_at(replayed, k, slot, got, i)}."
                if name != names.cu(slot)
                else f"{name} has its own message."
                for name, got, i in receivers
            ]
            place = f"slot_conflict={replayed.semantics.slot_conflict}"
            sentences.append(Sentence(text, place, amiss=True, details=tuple(outcomes)))
            continue
        lost = [name for name, got, _ in receivers if slot in got.lost_slots]
        if sent.reply is not None:
            got_it = [name for name, got, i in receivers if slot in got.inbox.cu_messages and i is None]
            text = f"Slot {slot}: {names.of_uav(sent.reply)}, as {names.cu(slot)} asked in round {k - 1}, is "
            text += f"received by {phrases.listing(got_it)}." if got_it else "received by no CU."
            sentences.append(Sentence(text, "Section 4.2"))
        if lost:
            text = f"Slot {slot}: {names.on_slot(slot, sent)} is lost on the way to {phrases.listing(lost)}."
            sentences.append(Sentence(text, amiss=True))
    return sentences


def _metadata(replayed: SwarmRun, k: int) -> list[Sentence]:
    """Tell which UAVs' metadata messages were lost."""
    return [
        Sentence(f"{names.uav(i)}'s metadata message is lost on the way to {names.cu(w)}.", amiss=True)
        for w, got in enumerate(replayed.events[k].at_cus)
        for i in got.lost_uavs
    ]


def _uavs(replayed: SwarmRun, k: int) -> list[Sentence]:
    """Tell what the UAVs make of what they received: requests, new trajectories."""
    sentences, events = [], replayed.events[k]
    for slot, sent in enumerate(replayed.airs[k].slots):
        message = sent.cu_message
        if not isinstance(message, TrajectoryMessage | TrajectoryRequestMessage):
            continue
        i, got = message.uav, events.at_uavs[message.uav]
        reached = got.inbox.cu_messages.get(slot) == message
        if isinstance(message, TrajectoryRequestMessage):
            if reached:
                text = (
                    f"{names.uav(i)} hears {names.cu(slot)}'s request: it will answer in slot {slot} of round {k + 1}."
                )
                sentences.append(Sentence(text, "Section 4.2"))
            else:
                text = f"{names.cu(slot)}'s request does not reach {names.uav(i)}: it "
                sentences.append(Sentence(f"{text}{slot_at(replayed, k, slot, got, i)}.", amiss=True))
        elif not reached:
            followed = names.trajectory(replayed.swarms[k].uavs[i].followed)
            text = f"{names.uav(i)} misses {names.trajectory(message.trajectory)}: it "
            text += f"{slot_at(replayed, k, slot, got, i)}, and goes on with {followed}."
            sentences.append(Sentence(text, "eq. 10", amiss=True))
    for i, new in enumerate(events.adopted):
        if new is None:
            continue
        offered = offers(replayed.swarms[k].uavs[i], events.at_uavs[i].inbox)
        old = replayed.swarms[k].uavs[i].followed
        text = (
            f"{names.uav(i)} received {phrases.listing([names.trajectory(t) for t in offered])}: from round {k + 1} on "
        )
        text += f"it follows {names.trajectory(new)} instead of {names.trajectory(old)}."
        sentences.append(Sentence(text, "eq. 10"))
    return sentences


def origin(replayed: SwarmRun, i: int, k: int) -> Sentence:
    """Tell how UAV i came to follow what it follows in round k."""
    followed, me = replayed.swarms[k].uavs[i].followed, names.uav(i)
    if followed == HOVERING:
        return Sentence(f"{me} hovers since the start: it has received no trajectory yet.", "Remark 2, eq. 10")
    calculated, w = followed.metadata
    text = f"{names.cu(w)} calculated {names.trajectory(followed)} in round {calculated} and sent it in slot {w}; "
    return Sentence(text + f"{me} received it and follows it since round {calculated + 1}.", "eq. 10")
