"""Watches a flight round by round, and says at its end what became of each claim."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import sqrt
from typing import NamedTuple

import numpy as np

from swarmproof.claims.closest import ClosestApproach
from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.claims.flight import (
    FLIGHT_CLAIMS,
    Approach,
    FlightClaim,
    ObservedFlight,
    PlannedBy,
)
from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, ProtocolClaim
from swarmproof.dmpc_swarm.flight.chain import explain
from swarmproof.dmpc_swarm.flight.fly import Flight
from swarmproof.dmpc_swarm.flight.instances import Instances
from swarmproof.dmpc_swarm.flight.observing import View, distances_to_targets, observe_round, reference_pieces
from swarmproof.dmpc_swarm.flight.places import Place, round_of
from swarmproof.dmpc_swarm.flight.state import FlightState, Round
from swarmproof.dmpc_swarm.flight.tracking import TrackingError
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.planner.outlook import ARRIVED
from swarmproof.dmpc_swarm.planner.planner import Planned
from swarmproof.monitor.separation import Separation
from swarmproof.motion.lattice import Floats
from swarmproof.qp.solvers import Status

#: New trajectories per UAV after which a swarm whose targets no longer change should have arrived.
PATIENCE = 50.0
#: Rounds that are kept for telling how a violation came about.
REMEMBERED = 1000


class Adoption(NamedTuple):
    """In round `round`, UAV `uav` adopted a new trajectory, which CU `cu` had planned in it."""

    round: int
    uav: int
    cu: int


@dataclass(frozen=True)
class Judged:
    """A claim after a flight.

    Attributes:
        why: the first place where it is broken, or why it does not apply or is not decided; else empty.
        rounds: complete rounds before the first violation.
        lost: messages lost before it.
        times: in how many rounds it was broken.
        chain: how the first violation came about, a sentence each, where it is about two trajectories.
        instances: how often the flight had something that it speaks of (see `docs/flying.md`).
        place: where it is broken first; None if it is not.
    """

    claim: ProtocolClaim | FlightClaim
    verdict: Verdict
    why: str
    rounds: int | None = None
    lost: int | None = None
    times: int = 0
    chain: tuple[str, ...] = ()
    instances: int = 0
    place: Place | None = None


@dataclass
class _Tally:
    rounds: int
    lost: int
    first: Broken
    chain: tuple[str, ...]
    place: Place
    times: int = 0


@dataclass
class Counts:
    """What became of the quadratic programs; `unsatisfied`: how many of them Theorem 1's candidate does not satisfy."""

    solved: int = 0
    rejected: int = 0
    infeasible: int = 0
    unsatisfied: int = 0

    def count(self, planned: Planned) -> None:
        """Count one more."""
        self.unsatisfied += not planned.feasible
        if planned.plan is not None:
            self.solved += 1
        elif planned.status is Status.INFEASIBLE:
            self.infeasible += 1
        else:
            self.rejected += 1


@dataclass(frozen=True)
class Flown:
    """The result of watching a flight.

    Attributes:
        rounds: how many were flown.
        sampled: the smallest scaled distance of references at multiples of T_c, in m.
        tracked: the smallest of trajectories in trackers that are not deprecated, at samples, in m; None if no pair.
        continuous_lower: a certified lower bound of the references' distance at all times, in m.
        closest_pair: the two UAVs of that closest approach, and when (s).
        band: certified bounds (lower, upper) of the smallest distance in every step T_c, in m, shape (steps, 2).
        arrived: whether all were within 5 cm of their targets at once, since the targets changed last. (UAVs that have
            arrived still make room for others: Appendix B's soft constraint may move them by some centimetres.)
        rounds_to_arrival: rounds from that change until then; None if not.
        lost: messages lost.
        last_adoption: the last new trajectory that a UAV adopted (of several in one round, the lowest UAV); None if
            none did.
        stopped: why the flight ended before the round that was asked for; None if it did not.
        beginning: what became of a beginning in violation of Remark 2, as a sentence; empty if it was none.
    """

    rounds: int
    sampled: float
    tracked: float | None
    continuous_lower: float
    closest_pair: tuple[tuple[int, int], float]
    band: Floats
    qps: Counts
    arrived: bool
    rounds_to_arrival: int | None
    lost: int
    claims: tuple[Judged, ...]
    last_adoption: Adoption | None = None
    stopped: str | None = None
    beginning: str = ""

    @property
    def violated(self) -> bool:
        """Whether some claim is violated."""
        return any(judged.verdict is Verdict.VIOLATED for judged in self.claims)

    @property
    def undecided(self) -> bool:
        """Whether some claim is undecided, or a part of the flight was not flown."""
        return self.stopped is not None or any(judged.verdict is Verdict.UNDECIDED for judged in self.claims)


def where(broken: Broken) -> str:
    """Return the CUs at which a claim is broken, to begin a sentence with; empty if it is about none."""
    if not broken.cus:
        return ""
    return f"{'CU' if len(broken.cus) == 1 else 'CUs'} {' and '.join(str(w) for w in broken.cus)}: "


class Judge:
    """Watches the rounds of one flight, in order."""

    def __init__(self, flight: Flight, start: FlightState, tracking: TrackingError | None = None) -> None:
        self._flight = flight
        self._lattice = flight.lattice
        self._tallies: dict[str, _Tally] = {}
        self._protocol = [c for c in CLAIMS if c.is_safety and c.applies_to(flight.semantics)]
        self._begins_too_close = flight.scenario.begins_too_close
        self._instances = Instances(self._protocol, self._begins_too_close)
        self._last_too_close = -1
        self._recent: deque[Round] = deque(maxlen=REMEMBERED)
        self._view = View.of(flight.lattice, start)
        self._references = Separation(flight.lattice, flight.lattice.crash.distance)
        self._actual = Separation(flight.lattice, flight.lattice.crash.distance)
        self._tracking = tracking
        self._sampled = Smallest()
        self._tracked = Smallest()
        self._qps = Counts()
        self._lost = 0
        self._rounds = 0
        self._underway = 0
        self._change = 0
        self._adopted = 0
        self._arrived_at: int | None = None
        self._late: list[int] = []
        self._last_adoption: Adoption | None = None

    def see(self, flown: Round) -> None:
        """Look at one more round."""
        after = flown.before.k + 1
        self._recent.append(flown)
        self._lost += sum(got.lost for got in (*flown.at_cus, *flown.at_uavs))
        observed, self._view = observe_round(self._lattice, self._view, flown)
        for attempt in flown.computed.attempts:
            if attempt is not None:
                self._qps.count(attempt.planned)
        self._instances.see(observed)
        self._underway += bool(observed.underway)
        for claim in FLIGHT_CLAIMS:
            if claim.in_round is not None:
                self._tally(claim.id, after, claim.in_round(observed), claim.approach and claim.approach(observed))
        seen = observe(flown.after.swarm)
        self._instances.see_swarm(seen)
        for protocol_claim in self._protocol:
            self._tally(protocol_claim.id, after, protocol_claim.broken_in(seen))
        self._sampled.take(observed.flown)
        if observed.flown is not None and observed.flown.square < observed.d_hat_min**2:
            self._last_too_close = observed.k
        self._tracked.take(observed.learned)
        pieces = reference_pieces(self._lattice, flown.before)
        self._references.add(pieces)
        if self._tracking is not None:
            self._actual.add(pieces + self._tracking.pieces(self._lattice.steps))
        self._rounds += 1
        self._look_for_arrival(flown)

    def finish(self) -> Flown:
        """Return what became of the claims; at least one round must have been seen."""
        references = self._references.dip()
        scenario = self._flight.scenario
        whole = ObservedFlight(
            self._lattice.crash.distance,
            references,
            None if self._tracking is None else self._actual.dip(),
            self._adopted / scenario.uavs,
            PATIENCE,
            self._late if self._arrived_at is None else (),
            self._underway,
        )
        for claim in FLIGHT_CLAIMS:
            if claim.in_flight is not None:
                dip = {"eq-2": references, "eq-2-actual": whole.actual}.get(claim.id)
                at = self._references_at(references) if claim.id == "eq-2" else None
                self._tally(claim.id, self._rounds, claim.in_flight(whole), at, dip)
        asked: list[ProtocolClaim | FlightClaim] = [*self._protocol, *FLIGHT_CLAIMS]
        arrived_after = None if self._arrived_at is None else self._arrived_at - self._change
        return Flown(
            self._rounds,
            self._sampled.distance(),
            self._tracked.distance() if self._tracked.square is not None else None,
            references.lower,
            (references.uavs, references.time),
            np.concatenate(self._references.band),
            self._qps,
            self._arrived_at is not None,
            arrived_after,
            self._lost,
            tuple(self._judged(claim, whole) for claim in asked),
            self._last_adoption,
            beginning=self._beginning(),
        )

    def _beginning(self) -> str:
        """Return what became of a beginning in violation of Remark 2, as a sentence; empty if it was none."""
        if not self._begins_too_close:
            return ""
        end = self._last_too_close + 1
        out = "Not all get d_hat_min apart for good in this flight."
        if end < self._rounds:
            out = f"All are d_hat_min apart at samples from round {end} on."
        return f"It begins in violation: {self._begins_too_close}. {out}"

    def _references_at(self, dip: ClosestApproach) -> Approach | None:
        """Return whose references come so close in `dip`; None if that round is forgotten."""
        k = round_of(self._lattice, dip)
        for flown in self._recent:
            if flown.before.k == k:
                uavs = flown.before.swarm.uavs
                i, j = (PlannedBy(*uavs[n].followed.metadata) for n in dip.uavs)
                return Approach(Fraction(dip.lower) ** 2, dip.uavs, (i, j), Fraction(dip.time))
        return None

    def _judged(self, claim: ProtocolClaim | FlightClaim, whole: ObservedFlight) -> Judged:
        instances = self._instances.number(claim, whole)
        if why := self._instances.excused(claim):
            return Judged(claim, Verdict.NOT_APPLICABLE, why)
        tally = self._tallies.get(claim.id)
        if tally is not None:
            why = where(tally.first) + tally.first.why
            judged = Judged(claim, Verdict.VIOLATED, why, tally.rounds, tally.lost, tally.times, tally.chain)
            # what is broken is an instance, whatever was assumed
            return replace(judged, instances=max(instances, 1), place=tally.place)
        verdict, why = Verdict.NOT_VIOLATED, ""
        if why := self._instances.not_about(claim, whole):
            verdict = Verdict.NOT_APPLICABLE
        elif why := self._instances.left_open(claim, whole):
            verdict = Verdict.UNDECIDED
        return Judged(claim, verdict, why, instances=instances)

    def _tally(
        self,
        claim: str,
        rounds: int,
        broken: Sequence[Broken],
        approach: Approach | None = None,
        dip: ClosestApproach | None = None,
    ) -> None:
        if not broken:
            return
        if claim not in self._tallies:
            pairs = self._lattice.pairs if dip is None else self._lattice.crash
            chain = (
                ()
                if approach is None
                else tuple(explain(self._lattice, self._recent, approach, self._flight.origin, pairs))
            )
            place = Place.of(self._lattice, rounds - 1, broken[0], approach if dip is None else dip)
            self._tallies[claim] = _Tally(rounds, self._lost, broken[0], chain, place)
        self._tallies[claim].times += 1

    def _look_for_arrival(self, flown: Round) -> None:
        """Note who is not at its target after the round, and when all were for the first time."""
        after = flown.after
        scenario = self._flight.scenario
        change = scenario.target_change_before(after.k - 1)
        if change != self._change:
            self._change, self._arrived_at, self._adopted = change, None, 0
        adopted = [
            Adoption(flown.before.k, new.i, new.followed.metadata.cu)
            for old, new in zip(flown.before.swarm.uavs, after.swarm.uavs, strict=True)
            if old.followed != new.followed
        ]
        self._adopted += len(adopted)
        self._last_adoption = adopted[0] if adopted else self._last_adoption
        distances = distances_to_targets(scenario, self._lattice, flown)
        self._late = [int(i) for i in np.flatnonzero(distances > ARRIVED)]
        if not self._late and self._arrived_at is None:
            self._arrived_at = after.k


@dataclass
class Smallest:
    """The smallest squared distance so far, exactly, in m²."""

    square: Fraction | None = None

    def take(self, approach: Approach | None) -> None:
        """Take one more approach into account, if it is one."""
        if approach is not None and (self.square is None or approach.square < self.square):
            self.square = approach.square

    def distance(self) -> float:
        """Return it in m; there must have been an approach."""
        assert self.square is not None
        return sqrt(self.square)
