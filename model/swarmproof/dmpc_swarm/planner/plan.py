"""A trajectory as the UAVs fly it: an initial state and one jerk per period, integers on the lattice (eq. 12)."""

from __future__ import annotations

from functools import cached_property
from hashlib import blake2b

import numpy as np

from swarmproof.motion.lattice import Floats, Lattice

#: Unit roundoff of float64.
ROUNDOFF = 2.0**-53


class Plan:
    """A trajectory from the start of round `start` on, over the horizon, then at rest (eqs. 12 and 13e).

    All arrays hold integers (lattice units) as float64, exactly. They are read-only.

    Attributes:
        start: the round at whose start, time start·T, the trajectory begins.
        state: shape (3, 3), rows position, velocity, acceleration, one column an axis.
        jerks: shape (H, 3).
        positions: at steps 0 … H·m from `start`, shape (H·m + 1, 3).
        velocities: at the ends of periods 0 … H, shape (H + 1, 3).
        accelerations: likewise.
    """

    def __init__(self, lattice: Lattice, start: int, state: Floats, jerks: Floats) -> None:
        self.lattice = lattice
        self.start = start
        self.state = state + 0.0
        self.jerks = jerks + 0.0
        periods = lattice.steps * np.arange(lattice.horizon + 1, dtype=float)[:, None]
        self.positions = lattice.from_state @ state + lattice.from_jerks @ jerks
        self.velocities = state[1] + 2 * periods * state[2] + lattice.velocity_from_jerks @ jerks
        self.accelerations = state[2] + lattice.acceleration_from_jerks @ jerks
        for array in (self.state, self.jerks, self.positions, self.velocities, self.accelerations):
            array.setflags(write=False)

    @classmethod
    def hovering(cls, lattice: Lattice, position: Floats) -> Plan:
        """Return a hover at the lattice `position`, shape (3,), from round 0 on (Remark 2)."""
        state = np.zeros((3, 3))
        state[0] = position
        return cls(lattice, 0, state, np.zeros((lattice.horizon, 3)))

    @cached_property
    def _resting(self) -> Floats:
        """Positions at steps 0 … 2·H·m; at rest in the second half."""
        return np.concatenate([self.positions, np.broadcast_to(self.positions[-1], (len(self.positions) - 1, 3))])

    @cached_property
    def _scaled(self) -> Floats:
        return self._resting @ self.lattice.pairs.first.T

    def sampled_from(self, k: int) -> Floats:
        """Return the positions at the samples k·T + h·T_c, h = 0 … H·m, k at `start` or later. Shape (H·m + 1, 3)."""
        return self._resting[self._samples(k)]

    def scaled_from(self, k: int) -> Floats:
        """Return the scaled positions q = S·p at the same samples; p where pairs differ. Shape (H·m + 1, 3)."""
        return self._scaled[self._samples(k)]

    def _samples(self, k: int) -> slice:
        samples = len(self.positions)
        offset = min((k - self.start) * self.lattice.steps, samples - 1)
        return slice(offset, offset + samples)

    def state_at(self, k: int) -> Floats:
        """Return the state at the start of round k, at `start` or later. Shape (3, 3)."""
        period = min(k - self.start, self.lattice.horizon)
        return np.array(
            (self.positions[period * self.lattice.steps], self.velocities[period], self.accelerations[period])
        )

    def position(self, step: float) -> Floats:
        """Return the position `step` steps T_c (whole or not, at least 0) after the start, rounded. Shape (3,)."""
        m, horizon = self.lattice.steps, self.lattice.horizon
        period = min(int(step / m), horizon)
        since = min(step, m * horizon) - period * m
        position, velocity, acceleration = self.state_at(self.start + period)
        moved: Floats = (
            3 * velocity * since + 3 * acceleration * since**2 + self.jerk_in(self.start + period) * since**3
        )
        moved += position
        return moved

    def jerk_in(self, k: int) -> Floats:
        """Return the jerk in round k. Shape (3,)."""
        period = k - self.start
        return self.jerks[period] if period < self.lattice.horizon else np.zeros(3)

    def shifted(self, k: int) -> Plan:
        """Return the same trajectory, begun at the start of round k: Theorem 1's candidate for a new one."""
        passed = min(k - self.start, self.lattice.horizon)
        jerks = np.concatenate([self.jerks[passed:], np.zeros((passed, 3))])
        return Plan(self.lattice, k, self.state_at(k), jerks)

    @cached_property
    def at_rest(self) -> bool:
        """Whether the trajectory ends at rest, exactly (13e)."""
        return not self.velocities[-1].any() and not self.accelerations[-1].any()

    @cached_property
    def fault(self) -> str | None:
        """The first of (12), (13c), (13d), (13e) that the trajectory breaks, in words; None if it satisfies all."""
        lattice = self.lattice
        # nan compares false with everything: each condition is said in the way in which nan breaks it
        if not (np.isfinite(self.jerks).all() and (self.jerks == np.rint(self.jerks)).all()):
            return "(12): the jerks are not numbers of the lattice"
        if not (np.abs(self.jerks) <= lattice.j_max).all():
            return "(13c): a jerk is out of bounds"
        if not (np.abs(self.velocities) <= lattice.v_max).all():
            return "(13d): a velocity is out of bounds"
        if not (np.abs(self.accelerations) <= lattice.a_max).all():
            return "(13d): an acceleration is out of bounds"
        for name, (rule, values, what) in self._bounded_by_norm.items():
            if name in lattice.norms and not within_ball(values, lattice.norms[name].square):
                return f"{rule}: the norm of {what} is out of bounds"
        at_periods = self.positions[:: lattice.steps]
        if not ((at_periods >= lattice.low).all() and (at_periods <= lattice.high).all()):
            return "(13d): a position is outside the flying space"
        return None if self.at_rest else "(13e): it does not end at rest"

    @property
    def _bounded_by_norm(self) -> dict[str, tuple[str, Floats, str]]:
        return {
            "j_norm": ("(13c)", self.jerks, "a jerk"),
            "v_norm": ("(13d)", self.velocities, "a velocity"),
            "a_norm": ("(13d)", self.accelerations, "an acceleration"),
        }

    @cached_property
    def moves(self) -> bool:
        """Whether the trajectory is anything but a hover."""
        return bool(self.state[1:].any() or self.jerks.any())

    @cached_property
    def digest(self) -> bytes:
        """Identifies the trajectory by its numbers: equal for equal start, state and jerks."""
        content = b"".join((self.start.to_bytes(8, "big"), self.state.tobytes(), self.jerks.tobytes()))
        return blake2b(content, digest_size=16).digest()


def within_ball(values: Floats, square: int) -> bool:
    """Return whether no row of `values`, integers, shape (n, 3), has a squared norm above `square`: exactly."""
    # a sum of three rounded squares is off by at most 3u(1 + u)² of itself, the limit by u, the product by another u
    doubtful = (values * values).sum(axis=1) >= float(square) * (1 - 8 * ROUNDOFF)
    return all(sum(int(x) ** 2 for x in row) <= square for row in values[doubtful])
