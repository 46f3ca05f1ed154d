"""Why a claim is false at the end of a run: what is false there, and the way back to where it came from."""

from __future__ import annotations

from collections.abc import Iterable

from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.explain import explain_in, slot_at
from swarmproof.dmpc_swarm.pages.story import Sentence, origin, selection
from swarmproof.dmpc_swarm.pages.swarm_run import SwarmRun
from swarmproof.dmpc_swarm.protocol.algorithm1 import may_plan
from swarmproof.dmpc_swarm.protocol.messages import HOVERING, Trajectory
from swarmproof.pages import phrases


def what_is_false(replayed: SwarmRun, broken: Broken, k: int) -> str:
    """Say in one sentence, with the actual contents, what is false in the computation phase of round k."""
    swarm = replayed.swarms[k]
    when = f"In the computation phase of round {k}, "
    if broken.uav is None:
        selections = [f"{names.cu(w)} computes {selection(swarm.cus[w].a_et or ())}" for w in broken.cus]
        return f"{when}{phrases.listing(selections)}: these are different sets A_ET({k})."
    i = broken.uav
    follows = f"{names.uav(i)} follows {names.trajectory(swarm.uavs[i].followed)}"
    held = [names.entries(swarm.cus[w].trackers[i].trajectories) for w in broken.cus]
    shows = replayed.shows
    if shows == "one-planner-per-uav":
        return f"{when}{names.cus(broken.cus)} both plan {names.uav(i)}."
    if shows == "lemma-1":
        return f"{when}{names.tracker(broken.cus[0], i)} is not deprecated and holds {held[0]}, but {follows}."
    if shows == "lemma-2":
        contents = [f"{names.cu(w)} holds {content}" for w, content in zip(broken.cus, held, strict=True)]
        trackers = f"the trackers of {names.uav(i)} on {names.cus(broken.cus)}"
        return f"{when}{trackers} are not deprecated and differ: {phrases.listing(contents)}. {follows}."
    if shows == "plans-from-truth":
        return (
            f"{when}{names.cu(broken.cus[0])} is in RUN_DMPC and may plan {names.uav(i)} from {held[0]}, but {follows}."
        )
    return f"{when}about {names.cus(broken.cus)} and {names.uav(i)}: {broken.why}."


def causes(replayed: SwarmRun, broken: Iterable[Broken], k: int) -> list[Sentence]:
    """Tell how it came to what is false in the computation phase of round k, without saying anything twice."""
    sentences = [sentence for one in broken for sentence in _causes(replayed, one, k)]
    return list(dict.fromkeys(sentences))


def _causes(replayed: SwarmRun, broken: Broken, k: int) -> list[Sentence]:
    if broken.uav is None or replayed.shows == "one-planner-per-uav":
        return [sentence for w in broken.cus for sentence in _selection(replayed, w, k)]
    i, swarm = broken.uav, replayed.swarms[k]
    followed = swarm.uavs[i].followed
    sentences = [origin(replayed, i, k)]
    held = {w: swarm.cus[w].trackers[i].trajectories for w in broken.cus}
    wanted = {followed}.union(*held.values()) if len(broken.cus) > 1 else {followed}
    for w in broken.cus:
        for trajectory in sorted(wanted - set(held[w])):
            sentences += missing(replayed, w, i, trajectory, k)
        sentences.append(_valid(replayed, w, i, k))
    for trajectory in sorted({t for entries in held.values() for t in entries} - {followed}):
        sentences += _not_followed(replayed, i, trajectory, followed)
    return sentences


def missing(replayed: SwarmRun, w: int, i: int, wanted: Trajectory, k: int) -> list[Sentence]:
    """Tell why CU w's tracker of UAV i does not hold `wanted` in round k."""
    me, tracker, name = names.cu(w), names.tracker(w, i), names.trajectory(wanted)
    held = [r for r in range(k) if wanted in replayed.swarms[r].cus[w].trackers[i].trajectories]
    if held:
        r = held[-1] + 1
        now = names.entries(replayed.swarms[r].cus[w].trackers[i].trajectories)
        if replayed.semantics.loss_handling == "ignore":
            text = f"{tracker} held {name} until round {r}, when a received trajectory replaced its content: {now}."
            return [Sentence(text, "loss_handling=ignore")]
        text = (
            f"{tracker} held {name} until round {r}, when {names.uav(i)}'s metadata of round {r - 1} reduced it: {now}."
        )
        return [Sentence(text, "Alg. 2 line 6")]
    if wanted == HOVERING:
        return [Sentence(f"{tracker} never held {name}: {me} never received it in a reply.")]
    calculated, slot = wanted.metadata
    got = replayed.events[calculated].at_cus[w]
    text = f"{me} never received {name}: of slot {slot} in round {calculated}, it "
    sentences = [Sentence(f"{text}{slot_at(replayed, calculated, slot, got)}.", amiss=True)]
    sentences += _conflict(replayed, slot, calculated)
    update, cus = explain_in(replayed, w, calculated + 1), replayed.cus
    if replayed.semantics.loss_handling == "ignore":
        sentences.append(Sentence(f"{me} does not ask whether it missed anything.", "loss_handling=ignore", amiss=True))
    elif not update.all_marked:
        text = f"{me} cannot notice: it counts {update.received} of {cus} CU messages in round {calculated}"
        if slot in got.inbox.cu_messages:
            text += f", since what it decoded in slot {slot} counts as the message of that slot"
        sentences.append(Sentence(text + ".", "Alg. 2 line 17", amiss=True))
    else:
        text = f"{me} noticed that something was missing: with {update.received} of {cus} CU messages in round "
        text += f"{calculated}, all its trackers were marked deprecated in round {calculated + 1}."
        sentences.append(Sentence(text, "Alg. 2 line 18"))
    return sentences


def _conflict(replayed: SwarmRun, slot: int, r: int) -> list[Sentence]:
    """Tell why a slot of round r has two transmitters, if it has."""
    reply = replayed.airs[r].slots[slot].reply
    if reply is None or not replayed.airs[r].slots[slot].conflict:
        return []
    me, asked = names.cu(slot), names.uav(reply.uav)
    text = f"That slot had two transmitters: {me} had asked {asked} in round {r - 1} and so donated slot {slot} of "
    text += (
        f"round {r} to it. But at the start of round {r}, before the reply, {me} had no deprecated tracker left and "
    )
    text += "went back to "
    return [Sentence(f"{text}RUN_DMPC, where it transmits.", "Alg. 1 line 9, rejoin=any-state", amiss=True)]


def _valid(replayed: SwarmRun, w: int, i: int, k: int) -> Sentence:
    """Tell since when CU w's tracker of UAV i is not deprecated."""
    flags = [swarm.cus[w].trackers[i].deprecated for swarm in replayed.swarms[: k + 1]]
    if not any(flags):
        return Sentence(f"{names.tracker(w, i)} has never been deprecated in this run.")
    r = max(r for r in range(1, k + 1) if flags[r - 1] and not flags[r])
    matched = explain_in(replayed, w, r).matched[i]
    text = (
        f"{names.tracker(w, i)} counts as up to date since round {r}: {names.uav(i)}'s metadata of round {r - 1} was "
    )
    text += f"{names.trajectory(matched)}, which the tracker held."
    if r == k and matched != replayed.swarms[k].uavs[i].followed:
        text += f" That was before {names.uav(i)} changed to what it follows now."
    return Sentence(text, "Alg. 2 lines 5-7")


def _not_followed(replayed: SwarmRun, i: int, entry: Trajectory, followed: Trajectory) -> list[Sentence]:
    """Tell why UAV i does not follow an entry that is newer than what it follows."""
    if entry == HOVERING or entry.metadata.round < followed.metadata.round:
        return []
    calculated, slot = entry.metadata
    got = replayed.events[calculated].at_uavs[i]
    text = f"{names.uav(i)} does not follow {names.trajectory(entry)}: of slot {slot} in round {calculated}, it "
    return [Sentence(f"{text}{slot_at(replayed, calculated, slot, got, i)}.", "eq. 10", amiss=True)]


def _selection(replayed: SwarmRun, w: int, k: int) -> list[Sentence]:
    """Tell how CU w comes to its selection in round k (round-robin)."""
    cu, cus, me = replayed.swarms[k].cus[w], replayed.cus, names.cu(w)
    sentences = []
    if k:
        inbox = replayed.events[k - 1].at_cus[w].inbox
        heard = []
        for slot in range(cus):
            message = inbox.cu_messages.get(slot)
            if message is None:
                heard.append(f"slot {slot}: nothing received")
            elif message.priorities is None:
                heard.append(f"slot {slot}: a reply, which carries no priorities")
            else:
                heard.append(f"slot {slot}: {priorities(message.priorities)}")
        text = f"{me} hears these priorities in round {k - 1}: {'; '.join(heard)}. "
        text += f"So it computes A_ET({k}) = {selection(cu.a_et or ())}."
        sentences.append(Sentence(text, "eq. 11, Appendix A.1"))
        for slot, sent in enumerate(replayed.airs[k - 1].slots):
            got = replayed.events[k - 1].at_cus[w]
            if (sent.conflict and slot != w) or slot not in inbox.cu_messages:
                text = f"{me}: of slot {slot} in round {k - 1}, it {slot_at(replayed, k - 1, slot, got)}."
                sentences.append(Sentence(text, f"slot_conflict={replayed.semantics.slot_conflict}", amiss=True))
                sentences += _conflict(replayed, slot, k - 1)
    for i in may_plan(cu, k, cus):
        text = f"{me} takes position ({k} + {w}) mod {cus} = {(k + w) % cus} of it, {names.uav(i)}."
        sentences.append(Sentence(text, "Section 4.2.2, Alg. 1 line 15"))
    return sentences


def priorities(announced: tuple[int, ...]) -> str:
    """Return announced priorities, UAV by UAV."""
    return ", ".join(f"J_{i} = {value}" for i, value in enumerate(announced))
