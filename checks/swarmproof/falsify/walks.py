"""Random runs of any system, at sizes that exploration cannot reach: drawn, checked and shrunk by Hypothesis.

A run is drawn as a list of numbers, two for each round: which choice, and which event, counted from the first and
around. The first event of a model loses nothing; so dropping a round or lowering a number always leaves a run, and
Hypothesis shrinks a failing run to few rounds in which little is lost.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

from hypothesis import strategies as st
from hypothesis.vendor.pretty import RepresentationPrinter

from swarmproof.claims.claim import Claim
from swarmproof.system import Scope
from swarmproof.trace.trace import encode, record

#: The most rounds of a run unless told otherwise.
MOST_ROUNDS = 60
#: The events of a round among which one is drawn.
MOST_EVENTS = 1 << 12


@dataclass(frozen=True)
class Breach:
    """The first state of a run in which a claim is false: the computation phase of this round."""

    claim: Claim[Any]
    round: int
    broken: Sequence[Any]


@dataclass(frozen=True)
class Walk:
    """A run: in round k, `states[k]` is the state in the computation phase, `events[k]` what happens."""

    scope: Scope
    states: tuple[Any, ...]
    events: tuple[Any, ...]

    def __repr__(self) -> str:
        """Say how large the run is; its trace says the rest."""
        lost = sum(event.lost for event in self.events)
        return (
            f"<run of {self.scope.system.name}, {self.scope.swarm()}, {self.scope.reading.name()}: "
            f"{len(self.events)} rounds, {lost} messages lost>"
        )

    def _repr_pretty_(self, printer: RepresentationPrinter, cycle: bool) -> None:
        """Let Hypothesis print the same."""
        printer.text(repr(self))


def perform(scope: Scope, numbers: Sequence[tuple[int, int]]) -> Walk:
    """Return the run that these numbers make: by round, which choice and which event."""
    model = scope.model()
    states, events = [model.initial()], []
    for choice, event in numbers:
        choices = model.choices(states[-1])
        sent = model.compute(states[-1], choices[choice % len(choices)])
        possible = list(islice(model.events(sent), MOST_EVENTS))
        events.append(possible[event % len(possible)])
        states.append(model.receive(sent, events[-1]))
    return Walk(scope, tuple(states), tuple(events))


@st.composite
def walks(draw: st.DrawFn, scope: Scope, max_rounds: int = MOST_ROUNDS) -> Walk:
    """Draw runs of at most `max_rounds` rounds."""
    number = st.just(0) | st.integers(0, MOST_EVENTS - 1)
    return perform(scope, draw(st.lists(st.tuples(number, number), max_size=max_rounds)))


def first_breach(states: Sequence[Any], observe: Callable[[Any], Any], claims: Sequence[Claim[Any]]) -> Breach | None:
    """Return the first of these states in which a claim about every state is false; None if none is."""
    for k, state in enumerate(states):
        observed = observe(state)
        for claim in claims:
            broken = claim.broken_in(observed)
            if broken:
                return Breach(claim, k, tuple(broken))
    return None


def explain(scope: Scope, events: Sequence[Any], breach: Breach) -> str:
    """Return what is broken and where, followed by the replayable trace."""
    places = "\n".join(f"  {broken.where}: {broken.why}" for broken in breach.broken)
    trace = encode(record(scope, breach.claim.id, events[: breach.round])).decode()
    return (
        f"{breach.claim.id} is violated in the computation phase of round {breach.round} "
        f"({scope.swarm()}, {scope.reading.name()}):\n"
        f"{places}\nsave this trace and give it to `swarmproof replay`:\n{trace}"
    )


def walk_property(walk: Walk, claims: Sequence[Claim[Any]] | None = None) -> None:
    """Assert that the claims about every state are true in every state of a run: the body of a Hypothesis test.

    Args:
        walk: drawn by :func:`walks`.
        claims: of which those are checked that apply to the run's reading; None for all of the system.

    Raises:
        AssertionError: a claim is false; the message has its id, the broken places, and the run so far as a trace,
            which `swarmproof replay` reads from a file.
    """
    scope = walk.scope
    asked = [claim for claim in (scope.system.claims if claims is None else claims) if claim.applies_to(scope.reading)]
    breach = first_breach(walk.states, scope.model().observe, asked)
    if breach is not None:
        raise AssertionError(explain(scope, walk.events, breach))
