"""What the page shows of each round's trackers: contents, flags, what changed, and where the claim is false."""

from __future__ import annotations

from dataclasses import dataclass

from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.story import selection
from swarmproof.dmpc_swarm.pages.swarm_run import SwarmRun
from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker
from swarmproof.dmpc_swarm.protocol.event_trigger import prio_consensus, select_uav


@dataclass(frozen=True)
class Header:
    """A UAV in a round: what it follows, whether that is new, and the CUs that it answers in this round."""

    name: str
    follows: str
    changed: bool
    answers: str


@dataclass(frozen=True)
class Cell:
    """D_iw(k): content, flag, what changed since the round before, and why the claim is false here, if it is."""

    entries: str
    deprecated: bool
    changes: tuple[str, ...]
    broken: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """CU w in a round."""

    name: str
    state: str
    before: str | None
    selection: str | None
    priorities: str
    broken: tuple[str, ...]
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class RoundTable:
    """The swarm in the computation phase of round k."""

    headers: tuple[Header, ...]
    rows: tuple[Row, ...]
    with_selection: bool


def round_table(replayed: SwarmRun, k: int) -> RoundTable:
    """Return the tracker table of round k."""
    swarm = replayed.swarms[k]
    before = replayed.swarms[k - 1] if k else None
    headers = tuple(
        Header(
            names.uav(uav.i),
            names.trajectory(uav.followed),
            before is not None and before.uavs[uav.i].followed != uav.followed,
            names.cus(sorted(uav.asked_by)),
        )
        for uav in swarm.uavs
    )
    return RoundTable(
        headers,
        tuple(_row(replayed, k, w) for w in range(len(swarm.cus))),
        replayed.semantics.event_trigger == "round-robin",
    )


def _row(replayed: SwarmRun, k: int, w: int) -> Row:
    swarm, cu = replayed.swarms[k], replayed.swarms[k].cus[w]
    before = replayed.swarms[k - 1].cus[w] if k else None
    broken = [one for one in replayed.broken[k] if w in one.cus]
    selected, heard = None, ""
    if cu.a_et is not None:
        i = select_uav(cu.a_et, k, w, len(swarm.cus))
        selected = f"A_ET({k}) = {selection(cu.a_et)}; selects {'nobody' if i is None else names.uav(i)}"
        if k:
            agreed = prio_consensus(replayed.events[k - 1].at_cus[w].inbox.cu_messages.values())
            heard = (
                "no priorities received" if agreed is None else ", ".join(f"J_{i} = {j}" for i, j in enumerate(agreed))
            )
    return Row(
        names.cu(w),
        cu.state.name,
        f"in round {k - 1}: {before.state.name}" if before is not None and before.state != cu.state else None,
        selected,
        heard,
        tuple(one.why for one in broken if one.uav is None),
        tuple(
            Cell(
                names.entries(tracker.trajectories),
                tracker.deprecated,
                () if before is None else _changes(before.trackers[i], tracker),
                tuple(one.why for one in broken if one.uav == i),
            )
            for i, tracker in enumerate(cu.trackers)
        ),
    )


def _changes(before: InformationTracker, after: InformationTracker) -> tuple[str, ...]:
    """Return what changed in a tracker from one round to the next."""
    came = [f"+ {names.trajectory(t)}" for t in after.trajectories if t not in before.trajectories]
    went = [f"− {names.trajectory(t)}" for t in before.trajectories if t not in after.trajectories]
    if before.deprecated == after.deprecated:
        return (*went, *came)
    return (*went, *came, "now deprecated" if after.deprecated else "now up to date")
