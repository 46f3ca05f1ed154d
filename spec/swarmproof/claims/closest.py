"""The closest approach of UAVs, as a monitor of separation certifies it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ClosestApproach:
    """The closest approach of any two UAVs at any time, where it is, and whether it stays above a distance.

    Attributes:
        lower: a certified lower bound in m.
        at_least: whether the distance never falls below that of the claim; None if that could not be decided.
        uavs: the two UAVs that come closest.
        time: when, in s.
    """

    lower: float
    at_least: bool | None
    uavs: tuple[int, int]
    time: float
