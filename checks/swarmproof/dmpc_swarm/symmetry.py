"""Canonical names for trajectories, and what of a deprecated tracker is forgotten.

The protocol compares trajectories only for equality (and, under the round-robin trigger, by age), so two swarms that
differ by a renaming behave alike. All names of one UAV form a *column*: what it follows and what every CU's tracker
of it holds. `docs/abstraction.md` argues that each :class:`Abstraction` is exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from math import lcm
from typing import NamedTuple

from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit
from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker
from swarmproof.dmpc_swarm.protocol.messages import Metadata, Trajectory
from swarmproof.dmpc_swarm.protocol.swarm import Swarm
from swarmproof.dmpc_swarm.protocol.uav import Uav
from swarmproof.dmpc_swarm.semantics import Semantics


class Abstraction(Enum):
    """How much of the trackers' content the explored states distinguish."""

    #: Of a deprecated tracker only what can still matter under the semantics.
    ESSENTIAL = "essential"
    #: Everything, but of three or more interchangeable trajectories only two are kept.
    COUNTED = "counted"
    #: Everything; the reachable set may be infinite.
    NOTHING = "nothing"


class Column(NamedTuple):
    """One UAV during a round: what it followed in it, what it follows after it, and every CU's tracker of it."""

    before: Trajectory
    after: Trajectory
    trackers: tuple[InformationTracker, ...]


#: The most CUs that can be explored.
MOST_CUS = 8
#: The round of canonical swarms (plus k mod M): above every canonical name's round, and 0 modulo every possible M.
CANONICAL_ROUND = 1000 * lcm(*range(1, MOST_CUS + 1))
#: The round of fillers, which stand for trajectories that nobody follows and whose age nobody asks for.
_FILLER_ROUND = -2


def _filler(w: int, number: int) -> Trajectory:
    return Trajectory(Metadata(_FILLER_ROUND, 2 * w + number))


def forget(tracker: InformationTracker, w: int, followed: Trajectory, semantics: Semantics) -> InformationTracker:
    """Return what can still matter of CU w's tracker of a UAV that follows `followed` (Abstraction.ESSENTIAL).

    A tracker that is not deprecated is kept. A flag is cleared only by a match (Alg. 2 line 5), which reduces the
    tracker to the matching trajectory, and only the followed trajectory can match from now on. So of a deprecated
    tracker it matters whether it holds the followed trajectory and, if line 13 is read as printed, whether it holds
    none, one or several.
    """
    if not tracker.deprecated:
        return tracker
    kept: tuple[Trajectory, ...] = (followed,) if followed in tracker.trajectories else ()
    if semantics.deprecation == "all":
        size = min(len(tracker.trajectories), 2)
        kept += tuple(_filler(w, number) for number in range(size - len(kept)))
    return InformationTracker(kept, deprecated=True)


def _holders(column: Column) -> dict[Trajectory, int]:
    """Return, for every trajectory of a column, the CUs whose tracker holds it, as a bit mask."""
    masks: dict[Trajectory, int] = {}
    for w, tracker in enumerate(column.trackers):
        for trajectory in tracker.trajectories:
            masks[trajectory] = masks.get(trajectory, 0) | 1 << w
    return masks


def _rename(column: Column, names: dict[Trajectory, Trajectory], keep_first: bool) -> Column:
    """Rename what has a name and drop the rest; entries are sorted, but for the first one if `keep_first`."""

    def renamed(tracker: InformationTracker) -> InformationTracker:
        entries = [names[t] for t in tracker.trajectories if t in names]
        kept = 1 if keep_first else 0
        return InformationTracker((*entries[:kept], *sorted(entries[kept:])), tracker.deprecated)

    return Column(names[column.before], names[column.after], tuple(renamed(t) for t in column.trackers))


def _capped(names: Sequence[Trajectory], masks: dict[Trajectory, int]) -> list[Trajectory]:
    """Keep at most two of the trajectories that are held by exactly the same trackers."""
    seen: dict[int, int] = {}
    kept = []
    for name in names:
        seen[masks[name]] = seen.get(masks[name], 0) + 1
        if seen[masks[name]] <= 2:
            kept.append(name)
    return kept


def canonical_column(column: Column, abstraction: Abstraction, during_round: bool = False) -> Column:
    """Rename a column's trajectories where ages do not matter (`event_trigger=any`).

    The trajectory followed before the round comes first, the others are ordered by the set of trackers that hold them:
    those that share it are interchangeable. During a round, what was planned in it keeps its name.
    """
    masks = _holders(column)
    fixed = {t for t in (*masks, column.after) if during_round and t.metadata.round >= CANONICAL_ROUND}
    others = sorted((t for t in masks if t not in fixed and t != column.before), key=lambda t: (-masks[t], t))
    if abstraction is Abstraction.COUNTED:
        others = _capped(others, masks)
    names = {t: t for t in fixed} | {column.before: Trajectory(Metadata(0, 0))}
    names |= {t: Trajectory(Metadata(number, 0)) for number, t in enumerate(others, start=1)}
    return _rename(column, names, keep_first=False)


def canonical_columns_with_ages(columns: Sequence[Column], abstraction: Abstraction) -> tuple[Column, ...]:
    """Rename all columns' trajectories together, keeping the order of their calculation rounds (round-robin).

    Of a tracker's order only the first entry is kept: no other's age is asked for (Appendix A.1), and what is left of a
    tracker after a match is one entry.
    """
    by_age = [_by_age(column, abstraction) for column in columns]
    rounds = sorted({t.metadata.round for names in by_age for t in names if t.metadata.round > _FILLER_ROUND})
    rank = {round_: number for number, round_ in enumerate(rounds)}
    renamed = []
    for column, trajectories in zip(columns, by_age, strict=True):
        names: dict[Trajectory, Trajectory] = {}
        of_rank: dict[int, int] = {}
        for t in trajectories:
            if t.metadata.round <= _FILLER_ROUND:
                names[t] = t
                continue
            age = rank[t.metadata.round]
            names[t] = Trajectory(Metadata(age, of_rank.get(age, 0)))
            of_rank[age] = of_rank.get(age, 0) + 1
        renamed.append(_rename(column, names, keep_first=True))
    return tuple(renamed)


def _by_age(column: Column, abstraction: Abstraction) -> list[Trajectory]:
    """Return a column's trajectories, oldest first; those of one round in an order that no renaming changes.

    Under COUNTED, interchangeable ones are capped, but what is first in some tracker, or followed, must stay.
    """
    masks = _holders(column)
    masks.setdefault(column.after, 0)
    first_in: dict[Trajectory, int] = {}
    for w, tracker in enumerate(column.trackers):
        for t in tracker.trajectories[:1]:
            first_in[t] = first_in.get(t, 0) | 1 << w
    ordered = sorted(masks, key=lambda t: (t.metadata.round, t != column.after, masks[t], first_in.get(t, 0)))
    if abstraction is not Abstraction.COUNTED:
        return ordered
    free = [t for t in ordered if t not in first_in and t != column.after]
    dropped = set(free) - set(_capped(free, masks))
    return [t for t in ordered if t not in dropped]


def canonical_swarm(swarm: Swarm, semantics: Semantics, abstraction: Abstraction) -> Swarm:
    """Return the representative of all swarms that behave like this one (its CUs' decisions still open)."""
    cus = len(swarm.cus)
    columns = []
    for uav in swarm.uavs:
        trackers = tuple(cu.trackers[uav.i] for cu in swarm.cus)
        if abstraction is Abstraction.ESSENTIAL:
            trackers = tuple(forget(t, w, uav.followed, semantics) for w, t in enumerate(trackers))
        columns.append(Column(uav.followed, uav.followed, trackers))
    if semantics.event_trigger == "round-robin":
        named = canonical_columns_with_ages(columns, abstraction)
        k = CANONICAL_ROUND + swarm.k % cus
    else:
        named = tuple(canonical_column(column, abstraction) for column in columns)
        k = CANONICAL_ROUND
    return Swarm(
        k,
        tuple(Uav(uav.i, column.after, uav.asked_by) for uav, column in zip(swarm.uavs, named, strict=True)),
        tuple(
            ComputeUnit(cu.w, cu.state, tuple(c.trackers[cu.w] for c in named), cu.next_request, cu.a_et)
            for cu in swarm.cus
        ),
    )
