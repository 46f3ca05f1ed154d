"""What is claimed about the heartbeat protocol, and what claims may look at."""

from __future__ import annotations

from typing import NamedTuple

from swarmproof.claims.claim import Always, Claim, Flaw, Reachable, Recovers, Witness


class Observed(NamedTuple):
    """The UAVs that take themselves for the leader, in order: they fly through the gap."""

    leading: tuple[int, ...]


def two_leaders(seen: Observed) -> list[Flaw]:
    """At most one UAV leads."""
    who = " and ".join(f"UAV {i}" for i in seen.leading)
    return [Flaw(who, "both fly through the gap")] if len(seen.leading) > 1 else []


def one_leads(seen: Observed) -> bool:
    """Say whether exactly one UAV leads."""
    return len(seen.leading) == 1


def taken_over(seen: Observed) -> bool:
    """Say whether another than UAV 0 leads, alone."""
    return len(seen.leading) == 1 and seen.leading != (0,)


def nobody_leads(seen: Observed) -> bool:
    """Say whether no UAV leads."""
    return not seen.leading


_PLACE = "the gap protocol of docs/your-protocol.md"
_ANY_LOSS = "Any (message, receiver) pair may be lost, independently, in every round, for ever."

CLAIMS: tuple[Claim[Observed], ...] = (
    Claim("one-leader", "No two UAVs fly through the gap in one round.", _PLACE, _ANY_LOSS, Always(two_leaders)),
    Claim(
        "one-leads",
        "From every reachable state, once nothing is lost any more, exactly one UAV comes to lead, for good.",
        _PLACE,
        "Any losses up to some round, none after it.",
        Recovers(one_leads, "exactly one UAV leading", "not exactly one UAV leads"),
    ),
    Claim(
        "can-take-over",
        "A state is reachable in which another than UAV 0 leads, alone.",
        _PLACE,
        "None.",
        Reachable(taken_over),
    ),
)

WITNESSES: tuple[Witness[Observed], ...] = (Witness("nobody-leads", "no UAV led", nobody_leads),)
