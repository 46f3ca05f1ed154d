"""The high-level planner (Appendix B.1): in a deadlock, UAVs that are in others' ways get intermediate targets.

The paper leaves open: all thresholds, the length of a detour and its noise. The thresholds are constants here, the
others choices of the scenario.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from swarmproof.dmpc_swarm.planner.outlook import ARRIVED, Outlook
from swarmproof.motion.lattice import Floats
from swarmproof.scenario.scenario import USUAL, Choices

#: m/s; a deadlock of the swarm is possible only while no UAV is faster.
SLOW = 0.05
#: m; only UAVs this close to each other make room.
CLOSE = 1.0


class Detour(NamedTuple):
    """UAV `uav` makes room for UAV `other`: its target is `point` (m) from round `since` on."""

    uav: int
    other: int
    point: tuple[float, float, float]
    since: int


def swarm_deadlocked(outlook: Outlook) -> bool:
    """Say whether no UAV moves though some have not arrived, and none of those would move if calculated again."""
    away = outlook.distances > ARRIVED
    slow = np.abs(outlook.velocities).max() < SLOW
    return bool(slow and away.any() and outlook.deadlocked[away].all())


def plan_detours(
    outlook: Outlook, k: int, assigned: Iterable[int], box: Floats, seed: Sequence[int], choices: Choices = USUAL
) -> list[Detour]:
    """Return the detours of those UAVs of `assigned` that are to make room for another UAV.

    Args:
        outlook: the swarm in its deadlock.
        k: the round.
        assigned: the UAVs of this CU.
        box: the flying space in m, shape (2, 3).
        seed: of the noise; together with k and the UAV it determines it.
        choices: the length of the detours, and the size of the noise.
    """
    detours = []
    for i in assigned:
        rivals = [j for j in range(len(outlook.positions)) if j != i and makes_room(outlook, i, j, choices)]
        if not rivals:
            continue
        apart = [float(np.linalg.norm(outlook.positions[j] - outlook.positions[i])) for j in rivals]
        nearest = rivals[int(np.argmin(apart))]
        away = (outlook.positions[i] - outlook.positions[nearest]) / max(min(apart), 1e-9)
        noise = np.random.default_rng([*seed, k, i]).normal(0.0, choices.detour_noise, 3)
        x, y, z = np.clip(outlook.positions[i] + choices.detour_step * away + noise, box[0], box[1])
        detours.append(Detour(i, nearest, (float(x), float(y), float(z)), k))
    return detours


def makes_room(outlook: Outlook, i: int, j: int, choices: Choices = USUAL) -> bool:
    """Say whether UAV i is to make room for UAV j: the three conditions of Appendix B.1."""
    to_other = outlook.positions[j] - outlook.positions[i]
    if float(np.linalg.norm(to_other)) > CLOSE or outlook.distances[j] <= ARRIVED:
        return False
    if outlook.distances[j] < outlook.distances[i]:
        return False
    towards = float((outlook.targets[i] - outlook.positions[i]) @ to_other) > 0 and outlook.distances[i] > ARRIVED
    return towards or _between(outlook, i, j, choices.detour_step)


def _between(outlook: Outlook, i: int, j: int, step: float) -> bool:
    """Say whether UAV i lies between UAV j and its target: beside the way, at most half a `step` (m) off it."""
    way = outlook.targets[j] - outlook.positions[j]
    ahead = outlook.positions[i] - outlook.positions[j]
    share = float(ahead @ way) / float(way @ way)
    return 0 < share < 1 and float(np.linalg.norm(ahead - share * way)) < step / 2


def current(detours: Iterable[Detour], outlook: Outlook, k: int, choices: Choices = USUAL) -> list[Detour]:
    """Return the detours that go on: not too old, and the reason for them still there.

    No new ones are planned before.
    """
    return [
        detour
        for detour in detours
        if k - detour.since < choices.detour_rounds and makes_room(outlook, detour.uav, detour.other, choices)
    ]
