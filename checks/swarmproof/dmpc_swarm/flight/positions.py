"""Where all UAVs are at every multiple of T_c, and all plans: so that somebody else can check a flight without us."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from swarmproof.dmpc_swarm.flight.fly import Flight
from swarmproof.dmpc_swarm.flight.run import Setting, tracking_of
from swarmproof.dmpc_swarm.flight.state import Name, Round
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.protocol.messages import HOVERING, Metadata
from swarmproof.motion.lattice import Floats


class Row(NamedTuple):
    """Where one UAV is at one time: its reference and itself, in m.

    Attributes:
        time: a multiple of T_c, in s.
        round: in which it is; the last one begins where the flight ends.
        reference: x, y, z.
        actual: the same of the UAV, which strays from its reference if there is a tracking error.
    """

    time: Fraction
    round: int
    uav: int
    reference: tuple[float, float, float]
    actual: tuple[float, float, float]


class PlanRow(NamedTuple):
    """A trajectory: from its start on, a state and a constant jerk for each period T; then at rest (eqs. 12, 13e).

    Attributes:
        uav: whose it is.
        round: in which it was planned; −1 for the hover at the start.
        cu: by whom; −1 for the hover.
        start: when it begins, in s.
        state: position (m), velocity (m/s) and acceleration (m/s²) at its start, x, y, z each.
        jerks: by period, x, y, z in m/s³; H of them.
        adopted: in which round the UAV adopted it; None if it never did. It follows it from the end of that round on.
    """

    uav: int
    round: int
    cu: int
    start: Fraction
    state: tuple[tuple[float, ...], ...]
    jerks: tuple[tuple[float, ...], ...]
    adopted: int | None


class Positions:
    """Keeps, round by round, what is written down. Numbers are the exact ones, rounded once to floats."""

    def __init__(self, setting: Setting, flight: Flight) -> None:
        self._flight, self._lattice = flight, flight.lattice
        # the same deviations as the judge sees: they depend on the seed alone
        self._tracking = tracking_of(setting, flight)
        self._samples: list[tuple[Floats, Floats]] = []
        self._plans: dict[Name, Plan] = {}
        self._adopted: dict[Name, int] = {}
        self._ends: tuple[Floats, Floats] | None = None

    def see(self, flown: Round) -> None:
        """Keep one more round."""
        k, m = flown.before.k, self._lattice.steps
        uavs = range(len(flown.before.swarm.uavs))
        there = np.array([flown.before.followed(i).sampled_from(k)[: m + 1] for i in uavs]).transpose(1, 0, 2)
        strays = np.zeros_like(there) if self._tracking is None else self._strays(self._tracking.pieces(m))
        self._samples.append((there[:-1], strays[:-1]))
        self._ends = there[-1], strays[-1]
        if k == 0:
            for i in uavs:
                self._plans[i, HOVERING.metadata] = flown.before.followed(i)
                self._adopted[i, HOVERING.metadata] = HOVERING.metadata.round
        for w, attempt in enumerate(flown.computed.attempts):
            if attempt is not None and attempt.planned.plan is not None:
                self._plans[attempt.task.i, Metadata(k, w)] = attempt.planned.plan
        for old, new in zip(flown.before.swarm.uavs, flown.after.swarm.uavs, strict=True):
            if old.followed != new.followed:
                self._adopted[new.i, new.followed.metadata] = k

    def _strays(self, pieces: Floats) -> Floats:
        """Return the deviations at the samples of a round and at its end, shape (m + 1, N, 3): they are integers."""
        scaled = np.concatenate([pieces[:, :, :, 0], pieces[-1:, :, :, 3]])
        unscaled: Floats = np.rint(np.linalg.solve(self._lattice.crash.first, scaled[..., None])[..., 0])
        return unscaled

    def rows(self) -> Iterator[Row]:
        """Yield where the UAVs are, by time and then by UAV; the last time is the end of the flight."""
        T_s, T_c = self._lattice.parameters.T_s, self._lattice.parameters.T_c
        rounds = self._samples if self._ends is None else [*self._samples, (self._ends[0][None], self._ends[1][None])]
        for k, (there, strays) in enumerate(rounds):
            for h, (at, off) in enumerate(zip(there, strays, strict=True)):
                for i, (reference, stray) in enumerate(zip(at, off, strict=True)):
                    yield Row(k * T_s + h * T_c, k, i, self._metres(reference), self._metres(reference + stray))

    def _metres(self, position: Floats) -> tuple[float, float, float]:
        unit = self._lattice.position_unit
        x, y, z = (float(int(p) * unit + by) for p, by in zip(position, self._flight.origin, strict=True))
        return x, y, z

    def plans(self) -> Iterator[PlanRow]:
        """Yield all plans that came out, and the hovers at the start, by round, CU and UAV."""
        lattice = self._lattice
        for (i, metadata), plan in sorted(self._plans.items(), key=lambda item: (item[0][1], item[0][0])):
            position, velocity, acceleration = plan.state
            yield PlanRow(
                i,
                metadata.round,
                metadata.cu,
                plan.start * lattice.parameters.T_s,
                (
                    self._metres(position),
                    _times(velocity, lattice.velocity_unit),
                    _times(acceleration, lattice.acceleration_unit),
                ),
                tuple(_times(jerk, lattice.jerk_unit) for jerk in plan.jerks),
                self._adopted.get((i, metadata)),
            )


def _times(vector: Floats, unit: Fraction) -> tuple[float, ...]:
    return tuple(float(int(x) * unit) for x in vector)
