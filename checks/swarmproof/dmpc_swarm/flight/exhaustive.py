"""Every loss pattern of the first rounds, on real trajectories; swarms that have become equal are flown on once.

What each receiver can receive comes from the network itself (`mlr.network`); receptions with the same effect on it are
one. Swarms are equal if protocol, trajectories (by their numbers) and knowledge are. Patterns are counted, not listed:
a pattern says of every message on the air, and every receiver, what arrived.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import partial
from itertools import product
from math import inf, prod

import numpy as np

from swarmproof.claims.closest import ClosestApproach
from swarmproof.dmpc_swarm.claims.flight import (
    FLIGHT_CLAIMS,
    Approach,
    FlightClaim,
    ObservedFlight,
    references_apart,
)
from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, ProtocolClaim
from swarmproof.dmpc_swarm.flight.cached_planner import Remembering
from swarmproof.dmpc_swarm.flight.chain import explain
from swarmproof.dmpc_swarm.flight.fly import Flight
from swarmproof.dmpc_swarm.flight.instances import Instances
from swarmproof.dmpc_swarm.flight.judge import Counts, Smallest, where
from swarmproof.dmpc_swarm.flight.observing import View, observe_round, reference_pieces, underway
from swarmproof.dmpc_swarm.flight.places import Place
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.flight.state import Computed, FlightState, Round
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.planner.planner import Planner
from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.network import Reception, cu_receptions, uav_receptions
from swarmproof.errors import BadInput
from swarmproof.explore.search import NO_LIMITS, Limits
from swarmproof.monitor.bernstein import at_least, closest
from swarmproof.monitor.separation import distance_below

#: More receivers and messages have too many receptions to list, more swarms do not fit into memory.
MOST_UAVS, MOST_CUS, MOST_SWARMS = 4, 3, 300_000
MOST_ROUNDS = 20


class PatternVerdict(StrEnum):
    """What all patterns of some rounds say of a claim."""

    HOLDS = "holds-for-these-rounds"
    VIOLATED = "violated"
    UNDECIDED = "undecided"
    #: No pattern of these rounds has anything that it speaks of.
    NOT_APPLICABLE = "not-applicable"


@dataclass(frozen=True)
class Decided:
    """A claim after all patterns.

    Attributes:
        why: the first place where it is broken, or why it is undecided or not applicable; empty if it holds.
        rounds: complete rounds before the first violation.
        lost: messages lost until then.
        cause: these rounds.
        chain: how it came about, a sentence each, where it is about two trajectories.
        instances: how often the rounds flown, and the swarms after them, had something that it speaks of.
        place: where it is broken first; None if it is not.
    """

    claim: ProtocolClaim | FlightClaim
    verdict: PatternVerdict
    why: str
    rounds: int | None = None
    lost: int | None = None
    cause: tuple[Round, ...] = ()
    chain: tuple[str, ...] = ()
    instances: int = 0
    place: Place | None = None


@dataclass(frozen=True)
class Begun:
    """How far a round came that was not finished.

    Attributes:
        k: the round.
        flown: of how many of the `swarms` before it every pattern was flown.
        found: how many different swarms after it are known.
        patterns: the number of loss patterns of rounds 0 to k that were flown.
    """

    k: int
    flown: int
    swarms: int
    found: int
    patterns: int


@dataclass
class Exhaustive:
    """What was found.

    Attributes:
        patterns: the number of loss patterns of the first 1, 2, … rounds.
        swarms: after the first 0, 1, 2, … rounds, the number of different swarms.
        asked: how many plans were asked for; `qps` counts the different ones, which were planned.
        sampled: the smallest scaled distance of references at samples, in m; None if no round was flown.
        tracked: the same of all trajectories in valid trackers; None if there were no two.
        continuous_lower: a certified lower bound of the references' distance at all times, in m.
        stopped: why it ended before the last round; None if it did not.
        begun: how far the round came in which it ended; None if every round was finished.
    """

    patterns: list[int] = field(default_factory=list)
    swarms: list[int] = field(default_factory=lambda: [1])
    transitions: int = 0
    asked: int = 0
    qps: Counts = field(default_factory=Counts)
    sampled: float | None = None
    tracked: float | None = None
    continuous_lower: float = inf
    stopped: str | None = None
    begun: Begun | None = None
    claims: tuple[Decided, ...] = ()
    seconds: float = 0.0

    @property
    def violated(self) -> bool:
        """Whether some claim is violated."""
        return any(decided.verdict is PatternVerdict.VIOLATED for decided in self.claims)

    @property
    def undecided(self) -> bool:
        """Whether some claim is undecided, or a part of the patterns was not flown."""
        return self.stopped is not None or any(decided.verdict is PatternVerdict.UNDECIDED for decided in self.claims)


@dataclass(eq=False)
class _Reached:
    """A swarm: how many patterns lead to it, and the way with the fewest losses."""

    state: FlightState
    view: View
    patterns: int
    lost: int
    way: tuple[_Reached, Round] | None = None

    def rounds(self) -> tuple[Round, ...]:
        """Return the rounds of that way."""
        rounds: list[Round] = []
        reached = self
        while reached.way is not None:
            reached, flown = reached.way
            rounds.append(flown)
        return tuple(reversed(rounds))


class _Search:
    def __init__(self, setting: Setting, rounds: int, limits: Limits) -> None:
        # a large flying space is clipped to what can be reached in the scenario's rounds
        longest = max(rounds, setting.scenario.rounds)
        setting = replace(setting, scenario=replace(setting.scenario, rounds=longest))
        self._limits = limits
        self._begin = time.perf_counter()
        uavs, cus = setting.scenario.uavs, setting.cus
        if uavs > MOST_UAVS or cus > MOST_CUS:
            raise BadInput(
                f"every loss pattern of {uavs} UAVs and {cus} CUs is out of reach: at most {MOST_UAVS} UAVs and "
                f"{MOST_CUS} CUs"
            )
        plain = setting.flight()
        self._planner = Remembering(Planner(plain.lattice, setting.scenario.weights))
        self._flight = setting.flight(self._planner)
        self._lattice = self._flight.lattice
        self._protocol = [c for c in CLAIMS if c.is_safety and c.applies_to(setting.semantics)]
        flights = [claim for claim in FLIGHT_CLAIMS if claim.id not in ("arrives", "eq-2-actual")]
        self._asked: list[ProtocolClaim | FlightClaim] = [*self._protocol, *flights]
        self._broken: dict[str, tuple[_Reached, Broken, Approach | ClosestApproach | None]] = {}
        self._sampled, self._tracked = Smallest(), Smallest()
        self._instances = Instances(self._protocol, setting.scenario.begins_too_close)
        #: the closest approach of references that is too close to d_min to tell, and in how many swarms some moved
        self._close: ClosestApproach | None = None
        self._underway = 0
        #: the claims of which complete rounds had an instance
        self._complete: set[str] = set()
        self.found = Exhaustive()

    def run(self, rounds: int, tell: Callable[[int, int, int], None]) -> Exhaustive:
        start = self._flight.initial()
        level: dict[Hashable, _Reached] = {
            _key(start): _Reached(start, View.of(self._lattice, start), patterns=1, lost=0)
        }
        try:
            self._between(level.values())
            for k in range(rounds):
                level = self._next(level, k, tell)
                self._between(level.values())
                self.found.begun = None
                self.found.patterns.append(sum(reached.patterns for reached in level.values()))
                self.found.swarms.append(len(level))
                whole = self._whole()
                self._complete.update(claim.id for claim in self._asked if self._instances.number(claim, whole))
        except KeyboardInterrupt:
            self.found.stopped = "interrupted"
        except _Stopped as stopped:
            self.found.stopped = str(stopped)
        return self._finish(time.perf_counter() - self._begin)

    def _check_limits(self, following: int) -> None:
        """Stop the search if a limit is reached, with so many swarms known of the round that is being flown."""
        if following > MOST_SWARMS:
            raise _Stopped(f"more than {MOST_SWARMS} swarms")
        seconds = time.perf_counter() - self._begin
        reason = self._limits.too_many(sum(self.found.swarms) + following) or self._limits.too_long(seconds)
        if reason is not None:
            raise _Stopped(reason)

    def _next(
        self, level: dict[Hashable, _Reached], k: int, tell: Callable[[int, int, int], None]
    ) -> dict[Hashable, _Reached]:
        following: dict[Hashable, _Reached] = {}
        done = 0
        try:
            for done, reached in enumerate(level.values()):
                if done % 20 == 0:
                    tell(k, done, len(level))
                self._fly_on(reached, following)
            done = len(level)
        finally:
            # also of a round that is not finished: what was found on the way is kept
            patterns = sum(known.patterns for known in following.values())
            self.found.begun = Begun(k, done, len(level), len(following), patterns)
            self._look_at_protocol(following.values())
        return following

    def _look_at_protocol(self, following: Iterable[_Reached]) -> None:
        for known in following:
            seen = observe(known.state.swarm)
            self._instances.see_swarm(seen)
            for protocol_claim in self._protocol:
                self._note(protocol_claim.id, known, protocol_claim.broken_in(seen))

    def _fly_on(self, reached: _Reached, following: dict[Hashable, _Reached]) -> None:
        """Fly every pattern of a round from a swarm on, and note what that shows and leads to."""
        computed = self._flight.compute(reached.state)
        for patterns, at_cus, at_uavs in outcomes(self._flight, reached.state, computed):
            self.found.transitions += 1
            flown = self._flight.receive(reached.state, computed, at_cus, at_uavs)
            observed, view = observe_round(self._lattice, reached.view, flown)
            key = _key(flown.after)
            lost = reached.lost + sum(got.lost for got in (*at_cus, *at_uavs))
            # what a round shows keeps its way: on a better one to the same swarm, it need not be seen
            this = _Reached(flown.after, view, 0, lost, (reached, flown))
            known = following.setdefault(key, replace(this))
            known.patterns += patterns * reached.patterns
            if lost < known.lost:
                known.lost, known.way = lost, this.way
            self._instances.see(observed)
            self._sampled.take(observed.flown)
            self._tracked.take(observed.learned)
            for claim in FLIGHT_CLAIMS:
                if claim.in_round is not None:
                    self._note(claim.id, this, claim.in_round(observed), claim.approach and claim.approach(observed))
            self._check_limits(len(following))

    def _note(
        self,
        claim: str,
        reached: _Reached,
        broken: Sequence[Broken],
        approach: Approach | ClosestApproach | None = None,
    ) -> None:
        if not broken:
            return
        known = self._broken.get(claim)
        if known is None or (reached.state.k == known[0].state.k and reached.lost < known[0].lost):
            self._broken[claim] = (reached, broken[0], approach)

    def _between(self, level: Iterable[_Reached]) -> None:
        """Bound the references' distances in the round to come, and note where two collide."""
        crash = self._lattice.crash
        distance, second = crash.distance, crash.among(self._flight.scenario.uavs)
        limit = float(crash.square(distance)) * (1 + 1e-6)
        unit, step = float(crash.unit), float(self._lattice.parameters.T_c)
        for n, some in enumerate(_chunks(level, 512)):
            if n:
                self._check_limits(0)
            self._underway += sum(underway(reached.state) > 0 for reached in some)
            pieces = np.concatenate([reference_pieces(self._lattice, reached.state) for reached in some])
            found = closest(pieces, second)
            lower = distance_below(found.lower, unit)
            self.found.continuous_lower = min(self.found.continuous_lower, lower)
            if found.lower >= limit:
                continue
            for reached in some:
                own = reference_pieces(self._lattice, reached.state)
                decided = at_least(own, crash.square(distance), second)
                nearest = closest(own, second)
                where = (reached.state.k * len(own) + nearest.step + nearest.fraction) * step
                dip = ClosestApproach(distance_below(nearest.lower, unit), decided, nearest.pair, where)
                if decided is None:
                    self._close = self._close or dip
                self._note("eq-2", reached, references_apart(self._whole(dip)), dip)

    def _finish(self, seconds: float) -> Exhaustive:
        found = self.found
        found.seconds, found.asked, found.qps = seconds, self._planner.asked, self._planner.counts
        found.sampled = None if self._sampled.square is None else self._sampled.distance()
        found.tracked = None if self._tracked.square is None else self._tracked.distance()
        found.claims = tuple(self._decided(claim) for claim in self._asked)
        return found

    def _decided(self, claim: ProtocolClaim | FlightClaim) -> Decided:
        broken = self._broken.get(claim.id)
        whole = self._whole()
        instances = self._instances.number(claim, whole)
        if why := self._instances.excused(claim):
            return Decided(claim, PatternVerdict.NOT_APPLICABLE, why)
        if broken is not None:
            reached, first, approach = broken
            why = where(first) + first.why
            cause = reached.rounds()
            chain = (
                tuple(explain(self._lattice, cause, approach, self._flight.origin))
                if isinstance(approach, Approach)
                else ()
            )
            place = Place.of(self._lattice, reached.state.k - 1, first, approach)
            return Decided(
                claim,
                PatternVerdict.VIOLATED,
                why,
                reached.state.k,
                reached.lost,
                cause,
                chain,
                max(instances, 1),
                place,
            )
        if why := self._instances.left_open(claim, whole):
            return Decided(claim, PatternVerdict.UNDECIDED, why, instances=instances)
        if self.found.stopped is not None:
            complete = len(self.found.patterns)
            until = "round" if complete == 1 else f"{complete} rounds"
            holds = f"; holds for the first {until}" if claim.id in self._complete else ""
            return Decided(claim, PatternVerdict.UNDECIDED, self.found.stopped + holds, instances=instances)
        if why := self._instances.not_about(claim, whole):
            return Decided(claim, PatternVerdict.NOT_APPLICABLE, why, instances=instances)
        return Decided(claim, PatternVerdict.HOLDS, "", instances=instances)

    def _whole(self, references: ClosestApproach | None = None) -> ObservedFlight:
        """Return what is to be said of all flights as one, of which `references` is the closest approach."""
        far = ClosestApproach(self.found.continuous_lower, True, (0, 0), 0.0)
        nearest = references or self._close or far
        return ObservedFlight(self._lattice.crash.distance, nearest, None, 0.0, 0.0, (), self._underway)


class _Stopped(Exception):
    """Says which limit ends a search."""


def explore_flights(
    setting: Setting, rounds: int, tell: Callable[[int, int, int], None], limits: Limits = NO_LIMITS
) -> Exhaustive:
    """Fly every loss pattern of the first `rounds` rounds, and decide the claims for them.

    Args:
        setting: the flight.
        rounds: how many rounds have losses; what is known and flown after them is looked at, too.
        tell: called with the round, and how many of how many swarms have been flown on in it.
        limits: when to stop early; states are the different swarms of all rounds. Whatever stops it, the rounds that
            were finished are decided, and what is violated after them is kept.

    Raises:
        BadInput: the swarm is too large.
    """
    return _Search(setting, rounds, limits).run(rounds, tell)


def parse_rounds(text: str) -> int:
    """Return the number of rounds in `text`, of ``exhaustive:ROUNDS``.

    Raises:
        BadInput: it is none.
    """
    if not text.isdecimal() or not 1 <= int(text[:9]) <= MOST_ROUNDS:
        raise BadInput(
            f"--loss exhaustive:{text} needs a number of rounds from 1 to {MOST_ROUNDS}, such as exhaustive:4"
        )
    return int(text)


def outcomes(
    flight: Flight, state: FlightState, computed: Computed
) -> Iterator[tuple[int, tuple[Reception, ...], tuple[Reception, ...]]]:
    """Yield, for each joint effect that the round's losses can have, how many patterns have it, and one of them."""

    def at_cu(w: int, got: Reception) -> Hashable:
        cu = algorithm1.update(computed.after.cus[w], got.inbox, flight.cus, flight.semantics)
        return cu, flight.learn(state, computed, w, got)

    def at_uav(i: int, got: Reception) -> Hashable:
        return flight.follow(computed.after.uavs[i], got.inbox)

    cus, uavs = len(computed.after.cus), len(computed.after.uavs)
    per_receiver = [_distinct(cu_receptions(w, computed.air, flight.semantics), partial(at_cu, w)) for w in range(cus)]
    per_receiver += [
        _distinct(uav_receptions(i, computed.air, flight.semantics), partial(at_uav, i)) for i in range(uavs)
    ]
    for combination in product(*per_receiver):
        receptions = tuple(reception for _, reception in combination)
        yield prod(count for count, _ in combination), receptions[:cus], receptions[cus:]


def _distinct(receptions: Iterable[Reception], effect: Callable[[Reception], Hashable]) -> list[tuple[int, Reception]]:
    """Return, for each effect, how many of the receptions have it, and the one of them that loses least."""
    found: dict[Hashable, tuple[int, Reception]] = {}
    for reception in receptions:
        key = effect(reception)
        count, best = found.get(key, (0, reception))
        found[key] = count + 1, min(best, reception, key=lambda got: got.lost)
    return list(found.values())


def _key(state: FlightState) -> Hashable:
    """Return what makes two swarms of one round equal: protocol, trajectories and knowledge."""
    return state.swarm, frozenset((name, plan.digest) for name, plan in state.plans.items()), state.knowledge


def _chunks(items: Iterable[_Reached], size: int) -> Iterator[list[_Reached]]:
    some: list[_Reached] = []
    for item in items:
        some.append(item)
        if len(some) == size:
            yield some
            some = []
    if some:
        yield some
