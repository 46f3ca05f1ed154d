"""How often each claim had something to speak of, and what our own limits left open: no success about nothing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from swarmproof.dmpc_swarm.claims.flight import FLIGHT_CLAIMS, FlightClaim, ObservedFlight, ObservedRound
from swarmproof.dmpc_swarm.claims.observed import ObservedSwarm
from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.claims.protocol import ProtocolClaim


class Instances:
    """Counts, over rounds, what the claims are about.

    Args:
        protocol: the claims about trackers and CUs.
        begins_too_close: which UAVs start closer than Remark 2 says, in words; empty if none do.

    Attributes:
        about: by id of a claim about rounds or swarms, in how many places so far there was something it speaks of.
        unsolved: by id of a claim about rounds, how many of them a limit of ours left undecided, and the first: (round,
            where).
    """

    def __init__(self, protocol: Iterable[ProtocolClaim], begins_too_close: str = "") -> None:
        self._protocol = list(protocol)
        self._begins_too_close = begins_too_close
        self.about: Counter[str] = Counter()
        self.unsolved: dict[str, tuple[int, tuple[int, Broken]]] = {}

    def see(self, observed: ObservedRound) -> None:
        """Count what one more round has."""
        for claim in FLIGHT_CLAIMS:
            if claim.about is not None:
                self.about[claim.id] += claim.about(observed)
            if claim.unsolved is not None and (left := claim.unsolved(observed)):
                number, first = self.unsolved.get(claim.id, (0, (observed.k, left[0])))
                self.unsolved[claim.id] = number + len(left), min(first, (observed.k, left[0]))

    def excused(self, claim: ProtocolClaim | FlightClaim) -> str:
        """Return why the claim says nothing of this flight, whatever is flown; empty if it does."""
        if self._begins_too_close and isinstance(claim, FlightClaim) and claim.from_start:
            return f"its assumption, Remark 2, fails: {self._begins_too_close}"
        return ""

    def see_swarm(self, swarm: ObservedSwarm) -> None:
        """Count what the trackers and CUs of one more swarm have."""
        for claim in self._protocol:
            if claim.about is not None:
                self.about[claim.id] += claim.about(swarm)

    def number(self, claim: ProtocolClaim | FlightClaim, whole: ObservedFlight | None) -> int:
        """Return how often the claim had something to speak of; a flight as a whole (None: not ended) is one thing."""
        if isinstance(claim, FlightClaim) and claim.in_flight is not None:
            return int(whole is not None and not (claim.fails and claim.fails(whole)))
        return self.about[claim.id]

    def not_about(self, claim: ProtocolClaim | FlightClaim, whole: ObservedFlight | None) -> str:
        """Return why the claim, broken nowhere, was about nothing; empty if it was about something."""
        if isinstance(claim, FlightClaim) and claim.fails is not None:
            return "" if whole is None else claim.fails(whole)
        return "" if self.number(claim, whole) else claim.nothing

    def left_open(self, claim: ProtocolClaim | FlightClaim, whole: ObservedFlight | None) -> str:
        """Return why our means do not decide the claim, though it is broken nowhere; empty if they do."""
        if isinstance(claim, FlightClaim) and claim.too_close is not None and whole is not None:
            return claim.too_close(whole)
        if claim.id not in self.unsolved:
            return ""
        number, (k, first) = self.unsolved[claim.id]
        of = self.about[claim.id]
        place = f"in round {k}, CU {first.cus[0]} for UAV {first.uav}"
        return f"our planner found no plan in {number} of {of} feasible problems (first {place}: {first.why})"
