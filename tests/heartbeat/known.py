"""What is known of small scopes of the heartbeat protocol."""

from __future__ import annotations

from tests.systems.small import Small

_TIMEOUT: dict[str, tuple[int, int] | None] = {"one-leader": (2, 2), "can-take-over": None}

SMALL = (
    Small("heartbeat", {"uavs": 2}, "timeout", 9, _TIMEOUT, ("one-leads",)),
    Small("heartbeat", {"uavs": 3}, "timeout", 729, _TIMEOUT, ("one-leads",)),
    Small("heartbeat", {"uavs": 3}, "sticky-lease", 163, {"one-leads": (3, 5)}, ("one-leader", "can-take-over")),
    Small("heartbeat", {"uavs": 3}, "lease", 265, {}, ("one-leader", "one-leads", "can-take-over")),
)
