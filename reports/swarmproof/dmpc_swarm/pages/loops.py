"""Why a swarm that loses nothing can go round for ever: what keeps each CU from running in the loop of a lasso."""

from __future__ import annotations

from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.causes import missing
from swarmproof.dmpc_swarm.pages.story import Sentence, origin, tell
from swarmproof.dmpc_swarm.pages.swarm_run import SwarmRun
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.dmpc_swarm.protocol.messages import TrajectoryMessage
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.explore.decide import Decided
from swarmproof.pages import phrases


def loop_causes(replayed: SwarmRun, decided: Decided) -> list[Sentence]:
    """Tell what keeps the swarm in the loop of a lasso, and whether other choices lead out of it."""
    loop, last = replayed.loop_start, len(replayed.events)
    assert loop is not None
    sentences: list[Sentence] = []
    for w in range(replayed.cus):
        sentences += _states(replayed, w, loop, last)
        for i in range(replayed.uavs):
            sentences += _stuck(replayed, w, i, loop, last)
    for k in range(loop + 1, last + 1):
        sentences += [
            Sentence(f"Round {k}: {told.text}", told.place, amiss=True)
            for told in tell(replayed, k).update
            if told.amiss
        ]
    if decided.avoidable:
        free = _free(replayed.semantics)
        text = f"The failure is avoidable: {decided.why}" + (f" ({free})." if free else ".")
        sentences.append(Sentence(text))
    elif decided.avoidable is not None:
        sentences.append(Sentence(f"The failure is inevitable: {decided.why}."))
    return list(dict.fromkeys(sentences))


def _states(replayed: SwarmRun, w: int, loop: int, last: int) -> list[Sentence]:
    """Tell in which states CU w is in the loop, and whom it asks."""
    states = [replayed.swarms[k].cus[w].state for k in range(loop, last)]
    if all(state is CuState.RUN_DMPC for state in states):
        return [Sentence(f"{names.cu(w)} is in RUN_DMPC all the time.")]
    when = [f"{state.name} in round {k}" for k, state in enumerate(states, start=loop)]
    text = f"{names.cu(w)} is in {phrases.listing(when)}"
    asked = _asked(replayed, w, loop, last)
    if not asked:
        return [Sentence(f"{text}; it asks nobody.")]
    text += f"; of the UAVs, it asks only {names.uavs(asked)}."
    return [Sentence(text, f"Alg. 1 line 26, request_order={replayed.semantics.request_order}")]


def _asked(replayed: SwarmRun, w: int, loop: int, last: int) -> list[int]:
    asked = {
        replayed.events[k].decided[w]
        for k in range(loop, last)
        if replayed.swarms[k].cus[w].state is CuState.REQUEST_TRAJECTORY
    }
    return sorted(i for i in asked if i is not None)


def _stuck(replayed: SwarmRun, w: int, i: int, loop: int, last: int) -> list[Sentence]:
    """Tell why CU w's tracker of UAV i stays deprecated, if it lacks what the UAV follows in the whole loop."""
    column = [
        (replayed.swarms[k].uavs[i].followed, replayed.swarms[k].cus[w].trackers[i]) for k in range(loop, last + 1)
    ]
    followed, tracker = column[0]
    if any(now != followed or followed in held.trajectories or not held.deprecated for now, held in column):
        return []
    text = f"{names.tracker(w, i)} holds {names.entries(tracker.trajectories)} and never {names.trajectory(followed)}, "
    text += f"which {names.uav(i)} follows: no metadata can match. Only a reply of {names.uav(i)}, or a new plan for "
    text += "it, could help"
    does_not = [] if i in _asked(replayed, w, loop, last) else [f"{names.cu(w)} never asks it"]
    if not any(isinstance(m, TrajectoryMessage) and m.uav == i for air in replayed.airs[loop:] for m, _ in air.slots):
        does_not.append("no CU plans it")
    text += f"; but in the loop {phrases.listing(does_not)}." if does_not else "."
    return [
        Sentence(text, "Alg. 2 line 5", amiss=True),
        origin(replayed, i, loop),
        *missing(replayed, w, i, followed, loop),
    ]


def _free(semantics: Semantics) -> str:
    """Name the choices that the semantics leave open where nothing is lost."""
    free = []
    if semantics.event_trigger == "any":
        free.append("whom the CUs in RUN_DMPC plan")
    if semantics.slot_conflict == "either":
        free.append("what is decoded in a conflict")
    if semantics.request_order == "any":
        free.append("whom a CU asks")
    return f"choices are left in {phrases.listing(free)}" if free else ""
