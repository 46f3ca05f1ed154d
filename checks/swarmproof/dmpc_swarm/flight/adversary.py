"""Searches for the losses that bring the swarm closest: Hypothesis looks around, then local search refines.

A pattern is a few losses: what one receiver misses, from which round on and for how long. It is the better, the smaller
the distance of two references gets in its flight, at any time. Promises (see
:mod:`swarmproof.dmpc_swarm.flight.incremental`) give the search a slope where CUs still repair what losses have broken:
what promises most is flown at once.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from random import Random

import hypothesis
from hypothesis import HealthCheck, Phase, Verbosity
from hypothesis import strategies as st

from swarmproof.dmpc_swarm.flight.incremental import Flights, Flown, Loss, Pattern, before
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.errors import BadInput
from swarmproof.explore.search import NO_LIMITS, Limits
from swarmproof.faults.losses import Losses
from swarmproof.faults.script import shown

#: The largest budget, and the longest flight: all states of some flights are kept.
MOST_FLIGHTS, MOST_ROUNDS = 100_000, 2000
#: Losses of a pattern that Hypothesis draws, and that local search collects.
MOST_DRAWN, MOST_LOSSES = 12, 30
#: How long a new loss is, in rounds: often short, sometimes about as long as a horizon.
LENGTHS = (1, 1, 2, 3, 4, 6, 10, 16)
#: How local search changes a loss, and by how many rounds.
CHANGES = ("add", "remove", "shift", "begin", "end", "split", "elsewhere", "elsewhere")
MOVES = (-5, -3, -2, -1, -1, 1, 1, 2, 3, 5)
#: After so many changes in a row that lead to nothing new, there is nothing left to try.
STUCK = 1000


@dataclass(frozen=True)
class Worst:
    """The pattern that was found.

    Attributes:
        losses: by round; after the last one everything arrives.
        distance: the smallest scaled distance of references at any time of its flight: a certified lower bound, in m.
        evaluated: how many flights it took.
        description: the pattern in words, a line each.
        stopped: why the search ended early; None if it did not.
    """

    losses: tuple[Losses, ...]
    distance: float
    evaluated: int
    description: list[str]
    stopped: str | None = None


class _TimeIsUp(KeyboardInterrupt):
    """Ends a search like an interrupt, which Hypothesis lets through at once."""


class _Search:
    """Finds the best pattern within a budget."""

    def __init__(
        self, setting: Setting, rounds: int, budget: int, tell: Callable[[int, float], None], limits: Limits
    ) -> None:
        self._limits, self._begin = limits, time.perf_counter()
        self.flights = Flights(setting, rounds)
        self._rounds, self._budget, self._tell = rounds, budget, tell
        self._seed = setting.seed
        self._random = Random(setting.seed)
        self.best = self._lossless = self.flights.fly(())
        self._promising = self.best
        self._worth: dict[Pattern, float] = {}
        self.evaluated = 0
        self._count(self.best)

    def _try(self, pattern: Pattern) -> None:
        """Fly a pattern, and then what is promised, if that is better than all so far."""
        self._fly(pattern)
        if self._promising.promise.distance < self.best.distance:
            promised = self.flights.promised(self._promising)
            self._promising = self.best
            self._fly(self._pattern(promised))

    def _fly(self, pattern: Pattern) -> None:
        """Fly a pattern, if it is a new one and the budget allows it."""
        if reason := self._limits.too_long(time.perf_counter() - self._begin):
            raise _TimeIsUp(reason)
        if pattern not in self._worth and self.evaluated < self._budget:
            self._count(self.flights.fly(pattern, [self._lossless, self.best]))

    def _count(self, flown: Flown) -> None:
        self.evaluated += 1
        self._worth[flown.pattern] = min(flown.distance, flown.promise.distance)
        self.best = min(flown, self.best, key=_key)
        self._promising = min(flown, self._promising, key=lambda one: one.promise)
        self._tell(self.evaluated, self.best.distance)

    def look_around(self, flights: int) -> None:
        """Let Hypothesis draw patterns, and climb from the best ones, until so many have been flown."""
        if flights <= self.evaluated:
            return
        # Only booleans are drawn: for integers, Hypothesis reads constants from whatever code is loaded, so that what
        # is drawn would depend on it, and keeps them in a folder of its own.
        losses = st.tuples(
            _below(len(self.flights.places)), _below(len(self._lossless.steps)), _below(len(LENGTHS))
        ).map(lambda drawn: Loss(drawn[0], drawn[1], LENGTHS[drawn[2]]))

        @hypothesis.seed(self._seed)
        @hypothesis.settings(
            max_examples=flights * 3 // 2,  # as some of its examples are old ones, and cost nothing
            phases=(Phase.generate, Phase.target),
            database=None,
            deadline=None,
            suppress_health_check=list(HealthCheck),
            verbosity=Verbosity.quiet,
        )
        @hypothesis.given(st.lists(losses, max_size=MOST_DRAWN))
        def flight(drawn: list[Loss]) -> None:
            pattern = self._pattern(drawn)
            if self.evaluated < flights:
                self._try(pattern)
            if pattern in self._worth:
                hypothesis.target(-self._worth[pattern])

        flight()

    def refine(self) -> None:
        """Change the best pattern again and again; leave as much of the budget as simplifying needs."""
        idle = 0
        while self.evaluated + len(self.best.pattern) + bool(self.best.pattern) < self._budget and idle < STUCK:
            before_it = self.evaluated
            self._try(self._changed())
            idle = idle + 1 if self.evaluated == before_it else 0

    def simplify(self) -> None:
        """Leave out what comes too late, and every loss without which the UAVs come as close."""
        # what is missed in a round changes what is flown in the next one
        self._fly(before(self.best.pattern, self.best.nearest))
        while True:
            pattern = self.best.pattern
            for loss in pattern:
                self._fly(tuple(other for other in self.best.pattern if other != loss))
            if self.best.pattern == pattern:
                return

    def result(self, stopped: str | None) -> Worst:
        """Return what was found."""
        best = self.best if stopped else self.flights.fly(self.best.pattern, [self.best], whole=True)
        last = max(best.missed, default=-1)
        losses = tuple(self.flights.losses(best.missed.get(k, ())) for k in range(last + 1))
        begin = f"Not finished: {stopped}. " if stopped else ""
        budget = f" of {self._budget}" if stopped else ""
        end = "has these losses:"
        if not best.pattern:
            end = "has no losses: no pattern was found that brings UAVs closer, which says nothing of those not tried."
        far = f"{best.distance:.4f} m in round {best.nearest}"
        words = [f"{begin}Flights tried: {self.evaluated}{budget}. The closest approach, {far}, {end}"]
        words += [self.flights.in_words(loss) for loss in best.pattern]
        return Worst(losses, best.distance, self.evaluated, words, stopped)

    def _changed(self) -> Pattern:
        """Return the best pattern with one change, or some."""
        pattern = self.best.pattern
        while True:
            pattern = self._pattern(self._change(list(pattern)))
            if self._random.random() < 0.5:
                return pattern

    def _change(self, losses: list[Loss]) -> list[Loss]:
        change = self._random.choice(CHANGES) if losses else "add"
        if len(losses) >= MOST_LOSSES:
            change = "remove"
        if change == "add":
            # a loss that comes after the closest approach can only help to another one
            soon = self.best.nearest > 0 and self._random.random() < 0.75
            first = self._random.randrange(self.best.nearest if soon else len(self._lossless.steps))
            return [*losses, Loss(self._any_place(), first, self._random.choice(LENGTHS))]
        place, first, rounds = losses.pop(self._random.randrange(len(losses)))
        by = self._random.choice(MOVES)
        if change == "shift":
            losses.append(Loss(place, first + by, rounds))
        elif change == "begin":
            losses.append(Loss(place, first + by, rounds - by))
        elif change == "end":
            losses.append(Loss(place, first, rounds + by))
        elif change == "split":
            heard = self._random.randrange(rounds)
            losses += [Loss(place, first, heard), Loss(place, first + heard + 1, rounds - heard - 1)]
        elif change == "elsewhere":
            losses.append(Loss(self._any_place(place if self._random.random() < 0.5 else None), first, rounds))
        return losses

    def _any_place(self, like: int | None = None) -> int:
        """Return a random place, of the same receiver as `like` if that is given."""
        all_places = self.flights.places
        same = [n for n, place in enumerate(all_places) if like is None or place.receiver == all_places[like].receiver]
        return self._random.choice(same)

    def _pattern(self, losses: Iterable[Loss]) -> Pattern:
        """Return these losses as far as they are within the flight: sorted, those of one place apart."""
        pattern: list[Loss] = []
        for place, first, rounds in sorted(losses):
            begin, end = max(first, 0), min(first + rounds, self._rounds)
            if begin >= end:
                continue
            if pattern and pattern[-1].place == place and pattern[-1].first + pattern[-1].rounds >= begin:
                begin = pattern[-1].first
                end = max(end, begin + pattern.pop().rounds)
            pattern.append(Loss(place, begin, end - begin))
        return tuple(pattern)


def search(
    setting: Setting, rounds: int, budget: int, tell: Callable[[int, float], None], limits: Limits = NO_LIMITS
) -> Worst:
    """Search for the losses that bring the swarm closest: the same for the same arguments, however long it takes.

    Half of the budget is for Hypothesis, which draws patterns and climbs from the best ones, half for local search and
    for leaving out what is not needed. Stopped early, it returns the best pattern so far; interrupted, only if one has
    been flown.

    Args:
        setting: the flight; its seed is that of the search, too.
        rounds: how long it is, at least one.
        budget: how many flights may be flown, at least one.
        tell: called after each flight with their number, and the smallest distance so far, in m.
        limits: when to stop early: seconds only, looked at after each flight.

    Raises:
        BadInput: there are too many rounds, or the flight cannot begin.
        ValueError: a limit of states, which this search has none of.
    """
    if limits.max_states is not None:
        raise ValueError("flights are what this search counts, and they have a budget")
    if rounds > MOST_ROUNDS:
        raise BadInput(f"--loss adversary:{budget} cannot search through {rounds} rounds: at most {MOST_ROUNDS}")
    found = _Search(setting, rounds, budget, tell, limits)
    try:
        found.look_around(budget // 2)
        found.refine()
        found.simplify()
        return found.result(stopped=None)
    except _TimeIsUp as reason:
        return found.result(stopped=str(reason))
    except KeyboardInterrupt:
        return found.result(stopped="interrupted")


def parse_budget(text: str) -> int:
    """Return the number of flights in `text`, of ``adversary:BUDGET``.

    Raises:
        BadInput: it is none.
    """
    if not (text.isdecimal() and len(text) <= 9 and 1 <= int(text) <= MOST_FLIGHTS):
        form = f"a number of flights from 1 to {MOST_FLIGHTS}, such as adversary:200"
        raise BadInput(f"--loss {shown('adversary:' + text)} needs {form}")
    return int(text)


def _key(flown: Flown) -> tuple[float, int, int]:
    """Return what is small for a good pattern: the distance, then the number of losses, then their length."""
    return flown.distance, len(flown.pattern), sum(loss.rounds for loss in flown.pattern)


def _below(size: int) -> st.SearchStrategy[int]:
    """Draw an integer from 0 to `size` - 1, of booleans."""
    bits = (size - 1).bit_length()
    return st.tuples(*[st.booleans()] * bits).map(
        lambda drawn: sum(bit << n for n, bit in enumerate(reversed(drawn))) * size >> bits
    )
