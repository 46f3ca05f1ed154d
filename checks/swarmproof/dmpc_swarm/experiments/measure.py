"""Flies one cell and measures it. The same cell gives the same numbers, to the bit, on the same machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from swarmproof.campaign.trial import Cell
from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.flight.observing import distances_to_targets
from swarmproof.dmpc_swarm.flight.run import fly
from swarmproof.dmpc_swarm.flight.state import FlightState, Round
from swarmproof.dmpc_swarm.planner.outlook import ARRIVED
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.motion.lattice import Floats

#: m; how close to its target a UAV must be to have reached it. The paper does not say: ours, and others for comparison.
REACHED = ARRIVED
RADII = (0.02, REACHED, 0.1, 0.2)


@dataclass(frozen=True, slots=True)
class Leg:
    """What happened from one change of the targets to the next, or to the end.

    Attributes:
        begin: the round of the change.
        rounds: how many rounds it lasts.
        all_within: by radius of :data:`RADII` (m), rounds until all UAVs were that close to their targets at once, for
            the first time; None if they never were.
        reached: by radius and UAV, rounds until that UAV was so close to its target for the first time; None if never.
        largest: by round, the largest distance of a UAV to its target at its end, in m; empty unless series are kept.
        mean: the same for the mean over UAVs.
        smallest: the same for the smallest.
    """

    begin: int
    rounds: int
    all_within: tuple[int | None, ...]
    reached: tuple[tuple[int | None, ...], ...]
    largest: tuple[float, ...] = ()
    mean: tuple[float, ...] = ()
    smallest: tuple[float, ...] = ()

    @classmethod
    def from_json(cls, table: Mapping[str, Any]) -> Leg:
        """Return the leg that a JSON object describes."""
        tuples: dict[str, Any] = {name: tuple(one) if isinstance(one, list) else one for name, one in table.items()}
        return cls(**{**tuples, "reached": tuple(tuple(of_radius) for of_radius in table["reached"])})


@dataclass(frozen=True, slots=True)
class Measured:
    """The numbers of one flight.

    Attributes:
        rounds: how many were flown.
        sampled: smallest scaled distance of two references at multiples of T_c, in m.
        lower: certified lower bound of their distance at all times, in m.
        collides: whether references come closer than d_min at some time, with certainty; None if that is not decided.
        closest: the two UAVs of the closest approach.
        closest_time: when, in s.
        lost: messages lost.
        solved: problems (13) that gave a plan.
        rejected: problems whose answer was not accepted.
        infeasible: problems without a solution, says the solver.
        all_plan: rounds in which every CU sent a new trajectory.
        all_run: rounds that every CU began its computation in RUN_DMPC.
        adopted: trajectories that UAVs adopted.
        last_adopted: the last round from which on a UAV followed a new trajectory; None if none did.
        rest_from: the first round from whose beginning on no UAV moved until the end; None if one moved in the last.
        violated: ids of the claims about flights that are violated.
        legs: by change of the targets.
    """

    rounds: int
    sampled: float
    lower: float
    collides: bool | None
    closest: tuple[int, int]
    closest_time: float
    lost: int
    solved: int
    rejected: int
    infeasible: int
    all_plan: int
    all_run: int
    adopted: int
    last_adopted: int | None
    rest_from: int | None
    violated: tuple[str, ...]
    legs: tuple[Leg, ...]

    def as_json(self) -> dict[str, Any]:
        """Return it as a JSON object; floats keep all their bits in JSON."""
        return asdict(self)

    @classmethod
    def from_json(cls, table: Mapping[str, Any]) -> Measured:
        """Return what :meth:`as_json` made of it.

        Raises:
            KeyError, TypeError: `table` is none of these objects.
        """
        legs = tuple(Leg.from_json(leg) for leg in table["legs"])
        first, second = table["closest"]
        return cls(**{**table, "legs": legs, "closest": (first, second), "violated": tuple(table["violated"])})


def measure(cell: Cell) -> Measured:
    """Fly a cell with all claims checked, and return its numbers.

    Raises:
        BadInput: the cell cannot be flown.
        KeyboardInterrupt: it was interrupted.
    """
    setting = cell.setting()
    flight = setting.flight()
    scenario, lattice = setting.scenario, flight.lattice
    distances: list[Floats] = []
    all_plan = all_run = adopted = 0
    last_adopted: int | None = None
    rest_from: int | None = 0

    def watch(flown: Round) -> None:
        nonlocal all_plan, all_run, adopted, last_adopted, rest_from
        before, after = flown.before, flown.after
        distances.append(distances_to_targets(scenario, lattice, flown))
        attempts = flown.computed.attempts
        all_plan += all(attempt is not None and attempt.planned.plan is not None for attempt in attempts)
        all_run += all(cu.state is CuState.RUN_DMPC for cu in before.swarm.cus)
        new = sum(old.followed != now.followed for old, now in zip(before.swarm.uavs, after.swarm.uavs, strict=True))
        if new:
            adopted, last_adopted = adopted + new, after.k
        if not _rests(before, scenario.uavs):
            rest_from = None
        elif rest_from is None:
            rest_from = before.k

    flown, _ = fly(setting, cell.losses(scenario.uavs), cell.rounds, watch, flight)
    if flown.rounds < cell.rounds:  # a part of a flight is no result
        raise KeyboardInterrupt
    changes = sorted({scenario.target_change_before(k) for k in range(cell.rounds)})
    ends = [*changes[1:], cell.rounds]
    violated = {judged.claim.id for judged in flown.claims if judged.verdict is Verdict.VIOLATED}
    apart = Fraction(flown.continuous_lower) >= scenario.parameters.d_min
    return Measured(
        rounds=flown.rounds,
        sampled=flown.sampled,
        lower=flown.continuous_lower,
        collides=True if "eq-2" in violated else False if apart else None,
        closest=flown.closest_pair[0],
        closest_time=flown.closest_pair[1],
        lost=flown.lost,
        solved=flown.qps.solved,
        rejected=flown.qps.rejected,
        infeasible=flown.qps.infeasible,
        all_plan=all_plan,
        all_run=all_run,
        adopted=adopted,
        last_adopted=last_adopted,
        rest_from=rest_from,
        violated=tuple(sorted(violated)),
        legs=tuple(
            _leg(np.array(distances[begin:end]), begin, cell.series) for begin, end in zip(changes, ends, strict=True)
        ),
    )


def _rests(state: FlightState, uavs: int) -> bool:
    """Say whether no UAV moves during the round of `state`; that is exact, since states are integers."""
    plans = [state.followed(i) for i in range(uavs)]
    return not any(plan.state_at(state.k)[1:].any() or plan.jerk_in(state.k).any() for plan in plans)


def _leg(distances: Floats, begin: int, series: bool) -> Leg:
    """Return what happened while the targets stayed; `distances` in m, shape (rounds, N)."""
    largest = distances.max(axis=1)
    kept = (largest, distances.mean(axis=1), distances.min(axis=1)) if series else ((), (), ())
    return Leg(
        begin,
        len(distances),
        tuple(_first(largest <= radius) for radius in RADII),
        tuple(tuple(_first(distances[:, i] <= radius) for i in range(distances.shape[1])) for radius in RADII),
        *(tuple(float(value) for value in one) for one in kept),
    )


def _first(reached: np.ndarray[Any, np.dtype[np.bool_]]) -> int | None:
    """Return in how many rounds it was reached first; None if it was not."""
    return int(np.argmax(reached)) + 1 if reached.any() else None
