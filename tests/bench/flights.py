"""Flies whole swarms, with all checks, and says how fast."""

from __future__ import annotations

from dataclasses import dataclass

from swarmproof.dmpc_swarm.flight.run import Setting, fly
from swarmproof.faults.grammar import parse


@dataclass(frozen=True)
class Timed:
    """One flight, flown some times.

    Attributes:
        loss: the loss model, as `fly --loss` reads it.
        rounds: its length.
        period: T in s.
        seconds: wall time of the loop with all checks, by flight.
    """

    loss: str
    rounds: int
    period: float
    seconds: tuple[float, ...]

    @property
    def rounds_per_second(self) -> float:
        """Of the flight in the middle."""
        return self.rounds / sorted(self.seconds)[len(self.seconds) // 2]

    @property
    def times_real_time(self) -> float:
        """How many seconds are flown in one second."""
        return self.rounds_per_second * self.period


def time_flights(setting: Setting, loss: str, rounds: int, repeats: int) -> Timed:
    """Fly the same flight `repeats` times.

    Raises:
        BadInput: there is no such loss model.
    """
    seconds = []
    for _ in range(repeats):
        losses = parse(loss, setting.scenario.uavs, setting.cus, setting.seed)
        seconds.append(fly(setting, losses, rounds)[1])
    return Timed(loss, rounds, float(setting.scenario.parameters.T_s), tuple(seconds))
