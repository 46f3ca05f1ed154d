"""How two trajectories came to be too close: loss → trackers → stale assumption → plan → place of the closest approach.

The trajectory that was planned last is the one whose CU should have kept away from the other. So the story is about
what that CU held, and why.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

import numpy as np

from swarmproof.dmpc_swarm.claims.flight import Approach, PlannedBy
from swarmproof.dmpc_swarm.flight.state import Attempt, Name, Round
from swarmproof.dmpc_swarm.planner.accept import wrong_sides
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.protocol.messages import HOVERING, Metadata, TrajectoryMessage
from swarmproof.motion.lattice import Lattice
from swarmproof.motion.pairs import Pairs, turned
from swarmproof.scenario.scenario import EXACT
from swarmproof.theorem3.values import Vector

NOT_MOVED: Vector = (Fraction(0), Fraction(0), Fraction(0))


def explain(
    lattice: Lattice,
    rounds: Iterable[Round],
    approach: Approach,
    origin: Vector = NOT_MOVED,
    pairs: Pairs | None = None,
) -> list[str]:
    """Return the chain of events, a sentence each, that led to an approach.

    Args:
        lattice: the units.
        rounds: the rounds up to the approach, without gaps.
        approach: of two trajectories in them.
        origin: m; what is to be added to the flight's coordinates.
        pairs: what the distance in the approach is that of; what plans keep, if not given.
    """
    rounds = list(rounds)
    by_round = {flown.before.k: flown for flown in rounds}
    names = [(i, Metadata(*planned)) for i, planned in zip(approach.uavs, approach.planned, strict=True)]
    one, other = sorted(names, key=lambda name: (name[1].round, name[0]), reverse=True)
    chain: list[str] = []
    if one[1] == HOVERING.metadata or one[1].round not in by_round:
        chain.append(f"UAV {one[0]}'s trajectory, {in_words(one)}, is older than what is remembered of the flight.")
    else:
        planned = by_round[one[1].round]
        attempt = planned.computed.attempts[one[1].cu]
        assert attempt is not None
        losses, assumed = _assumption(by_round, planned, attempt, one, other)
        chain += [_loss_line([*_missed(by_round, one, other), *losses]), *assumed]
        chain += _plan(lattice, attempt, one)
    return [*chain, _place(lattice, pairs or lattice.pairs, rounds, (one, other), approach.time, origin)]


#: A loss: the round, who does not get, and what.
Loss = tuple[int, str, str]


def _loss_line(losses: Iterable[Loss]) -> str:
    """Say which messages were lost, in the order of the rounds, each once."""
    by_receiver: dict[tuple[int, str], list[str]] = {}
    for r, who, what in dict.fromkeys(sorted(losses, key=lambda loss: loss[0])):
        by_receiver.setdefault((r, who), []).append(what)
    said = [f"in round {r}, {who} does not get {' and '.join(what)}" for (r, who), what in by_receiver.items()]
    return f"Loss: {'; '.join(said)}." if said else "Loss: none that concerns these trajectories."


def _missed(by_round: dict[int, Round], one: Name, other: Name) -> list[Loss]:
    """Return what the planning CU missed since it could have heard of the other trajectory, and the UAVs of theirs."""
    w, k = one[1].cu, one[1].round
    first = max(other[1].round, min(by_round))
    missed = []
    for r in range(first, k):
        got = by_round[r].at_cus[w]
        what = [f"the message in CU {s}'s slot" for s in got.lost_slots]
        what += [f"the metadata of UAV {i}" for i in got.lost_uavs if i in (one[0], other[0])]
        missed += [(r, f"CU {w}", one_of) for one_of in what]
    for i, metadata in (one, other):
        for r in range(max(metadata.round, min(by_round)), k + 1):
            for slot in by_round[r].at_uavs[i].lost_slots:
                message, _ = by_round[r].computed.air.slots[slot]
                if isinstance(message, TrajectoryMessage) and message.uav == i:
                    missed.append((r, f"UAV {i}", f"CU {slot}'s message"))
    return missed


def _why_unknown(by_round: dict[int, Round], w: int, name: Name, k: int) -> tuple[list[Loss], str]:
    """Say why CU w does not hold a trajectory in round k, however long ago it could have heard of it.

    Args:
        by_round: the rounds that are remembered.
        w: the CU.
        name: the trajectory, which somebody planned before round k.
        k: the round in which w does not hold it.

    Returns:
        the loss that kept it from w, if it was one, and the sentence.
    """
    i, (r, c) = name
    if r not in by_round:
        return [], f"CU {w} could have heard of it in round {r}, which is older than what is remembered of the flight."
    got, known = by_round[r].at_cus[w], f"the message in CU {c}'s slot"
    if c in got.lost_slots:
        return [(r, f"CU {w}", known)], f"CU {w} never heard of it: it lost {known} in round {r}."
    if c in got.decoded_replies or c not in got.inbox.cu_messages:
        reply = by_round[r].computed.air.slots[c].reply
        assert reply is not None
        return [], (
            f"CU {w} never heard of it: in round {r}, UAV {reply.uav} transmitted in CU {c}'s slot as well, and CU {w} "
            f"did not decode CU {c}'s message."
        )
    for q in range(r + 1, k + 1):
        held = [entry.metadata for entry in by_round[q].before.swarm.cus[w].trackers[i].trajectories]
        if name[1] not in held:
            instead = ", ".join(in_words((i, metadata)) for metadata in held) or "nothing"
            return [], f"CU {w} heard of it in round {r}; from round {q} on it holds {instead} instead."
    raise AssertionError(f"CU {w} holds {name}")


def _assumption(
    by_round: dict[int, Round], planned: Round, attempt: Attempt, one: Name, other: Name
) -> tuple[list[Loss], list[str]]:
    """Say what the planning CU believed of both UAVs, and whether it was true; and what was lost that it was not."""
    w, k = one[1].cu, one[1].round
    cu = planned.before.swarm.cus[w]
    lines: list[str] = []
    losses: list[Loss] = []
    for i in (one[0], other[0]):
        tracker = cu.trackers[i]
        held = ", ".join(in_words((i, trajectory.metadata)) for trajectory in tracker.trajectories)
        flag = "deprecated" if tracker.deprecated else "not deprecated"
        follows = planned.before.swarm.uavs[i].followed.metadata
        lines.append(
            f"Trackers: in round {k}, CU {w} holds for UAV {i}: {held} ({flag}); the UAV follows the one "
            f"{in_words((i, follows))}."
        )
        if follows not in [trajectory.metadata for trajectory in tracker.trajectories]:
            lost, why = _why_unknown(by_round, w, (i, follows), k)
            losses += lost
            lines += [f"Stale assumption: CU {w} does not know what UAV {i} follows.", why]
    known = [trajectory.metadata for trajectory in cu.trackers[other[0]].trajectories]
    if other[1] in known:
        plan, planes = attempt.planned.plan, attempt.task.planes
        assert plan is not None
        keeps = other[0] not in [planes.owners[n] for n, _ in wrong_sides(plan, planes)]
        what = "did keep" if keeps else "held it, but did not keep"
        lines.append(f"CU {w} {what} UAV {one[0]} away from UAV {other[0]}'s trajectory {in_words(other)}.")
    elif other[1].round == k:
        of_round = _same_round(by_round.get(k - 1), planned, attempt, one, other)
        return losses + of_round[0], lines + of_round[1]
    else:
        lost, why = _why_unknown(by_round, w, other, k)
        losses += lost
        lines += [
            f"Stale assumption: UAV {other[0]}'s trajectory {in_words(other)} is not among those that CU {w} keeps UAV "
            f"{one[0]} away from.",
            why,
        ]
    return losses, list(dict.fromkeys(lines))


def _same_round(
    before: Round | None, planned: Round, attempt: Attempt, one: Name, other: Name
) -> tuple[list[Loss], list[str]]:
    """Say whom each of the two CUs took to be planned in this round, and why they disagreed, if they did."""
    k, w, v = one[1].round, one[1].cu, other[1].cu
    theirs = planned.computed.attempts[v]
    assert theirs is not None
    lines = [
        f"UAV {other[0]} is planned in the same round, by CU {v}. CU {w} takes A_ET({k}) to be "
        f"{sorted(attempt.task.selected)}, CU {v} takes it to be {sorted(theirs.task.selected)}."
    ]
    losses: list[Loss] = []
    if other[0] not in attempt.task.selected or one[0] not in theirs.task.selected:
        lines.append("Stale assumption: one of them counts on the other UAV's old trajectory, and leaves no room.")
    if before is not None:
        for cu in (w, v):
            got = before.at_cus[cu]
            losses += [(k - 1, f"CU {cu}", f"the message in CU {s}'s slot") for s in got.lost_slots]
            what = [f"does not get the message in CU {s}'s slot" for s in got.lost_slots]
            what += [f"decodes a UAV's reply in CU {s}'s slot, without priorities" for s in got.decoded_replies]
            if what:
                lines.append(f"Priorities: in round {k - 1}, CU {cu} {' and '.join(what)}.")
    return losses, lines


def _plan(lattice: Lattice, attempt: Attempt, one: Name) -> list[str]:
    plan = attempt.planned.plan
    assert plan is not None
    apart = attempt.task.planes.apart(plan)
    planes, squares = attempt.task.planes, (apart * apart).sum(axis=2)
    units = np.array([[float(unit)] for unit in planes.units]) if planes.units else float(lattice.pairs.unit)
    nearest = float((np.sqrt(squares) * units).min())
    demanded = "as (13f) demands" if attempt.task.tolerance == EXACT else "as (13f) demands, but for the tolerance"
    verdict = "which breaks (13f)" if len(wrong_sides(plan, attempt.task.planes)) else demanded
    return [
        f"Plan: in round {one[1].round}, CU {one[1].cu} plans UAV {one[0]}; to all trajectories that it knows of, the "
        f"new one keeps {nearest:.4f} m at all samples, {verdict}."
    ]


def _place(
    lattice: Lattice, pairs: Pairs, rounds: Sequence[Round], names: tuple[Name, Name], time: Fraction, origin: Vector
) -> str:
    """Say where the two trajectories are at `time`."""
    known: dict[Name, Plan] = {}
    for flown in rounds:
        known.update(flown.before.plans)
        known.update(flown.after.plans)
        for w, attempt in enumerate(flown.computed.attempts):
            if attempt is not None and attempt.planned.plan is not None:
                known[attempt.task.i, Metadata(flown.before.k, w)] = attempt.planned.plan
    step = float(time / lattice.parameters.T_c)
    places = []
    scaled = []
    for name in names:
        plan = known[name]
        here = plan.position(step - plan.start * lattice.steps)
        scaled.append(pairs.first @ here)
        x, y, z = here * float(lattice.position_unit) + np.array(origin, float)
        places.append(f"UAV {name[0]} ({in_words(name)}) is at ({x:.3f}, {y:.3f}, {z:.3f}) m")
    apart = turned(scaled[1] - scaled[0], pairs.second(names[0][0], names[1][0]))
    distance = float(np.linalg.norm(apart)) * float(pairs.unit_of(names[0][0], names[1][0]))
    return f"Closest approach: at {float(time):.3f} s, {places[0]} and {places[1]}, {distance:.4f} m apart (scaled)."


def in_words(name: Name) -> str:
    """Return what a trajectory is called, without its UAV."""
    return PlannedBy(*name[1]).in_words()
