"""The nominal model (eq. 4 as used in the experiments): per axis a chain of integrators with piecewise constant input.

DMPC-Swarm takes a triple integrator (input jerk); the double integrator (input acceleration) is the older DMPC's.
The arithmetic is that of the numbers put in: floats while searching, fractions where the answer must be exact.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import factorial
from typing import Generic, TypeVar

Number = TypeVar("Number", float, Fraction)


@dataclass(frozen=True)
class AxisMotion(Generic[Number]):
    """One axis of a motion from time 0.

    `state` is (position, velocity) or (position, velocity, acceleration) in m, m/s, m/s²; `inputs` are pairs
    (duration in s, value) of the derivative after the last one of the state.
    """

    state: tuple[Number, ...]
    inputs: tuple[tuple[Number, Number], ...]

    @cached_property
    def _starts(self) -> tuple[list[Number], list[tuple[Number, ...]]]:
        times, states = [0 * self.state[0]], [self.state]
        for duration, value in self.inputs[:-1]:
            states.append(_after(states[-1], value, duration))
            times.append(times[-1] + duration)
        return times, states

    def at(self, time: Number) -> tuple[Number, ...]:
        """Return the state at `time` (s, at least 0); the last input goes on after the last duration."""
        times, states = self._starts
        piece = max(bisect_right(times, time) - 1, 0)
        return _after(states[piece], self.inputs[piece][1], time - times[piece])

    def position(self, time: Number) -> Number:
        """Return the position in m at `time` in s."""
        return self.at(time)[0]

    def scaled(self, factor: Number) -> AxisMotion[Number]:
        """Return the motion with state and inputs multiplied by `factor`."""
        return AxisMotion(
            tuple(factor * value for value in self.state),
            tuple((duration, factor * value) for duration, value in self.inputs),
        )

    def shifted(self, offset: Number) -> AxisMotion[Number]:
        """Return the motion that starts `offset` (m) further on."""
        state: list[Number] = list(self.state)
        state[0] = state[0] + offset
        return AxisMotion(tuple(state), self.inputs)


def _after(state: tuple[Number, ...], value: Number, time: Number) -> tuple[Number, ...]:
    """Return the state `time` later under constant input `value` (Taylor's formula, which is exact here)."""
    derivatives: list[Number] = list(state)
    derivatives.append(value)
    result = []
    for m in range(len(state)):
        total = derivatives[m]
        for k in range(m + 1, len(derivatives)):
            total = total + derivatives[k] * time ** (k - m) / factorial(k - m)
        result.append(total)
    return tuple(result)
