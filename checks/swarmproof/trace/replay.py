"""Replays traces, step by step, on the readable model, and checks that they show what they say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from swarmproof.claims.claim import Always, Claim, Reachable, Recovers, Return, Witness
from swarmproof.claims.reading import Reading
from swarmproof.errors import BadInput
from swarmproof.port.model import Model
from swarmproof.system import Scope, System
from swarmproof.systems import load
from swarmproof.trace.trace import Trace


@dataclass(frozen=True)
class Replay:
    """A trace replayed: `states[k]` is that in the computation phase of round k, `events[k]` what happens then.

    Attributes:
        sent: by round, what is on the air, as the model computed it.
    """

    trace: Trace
    scope: Scope
    model: Model[Any, Any, Any, Any]
    states: tuple[Any, ...]
    sent: tuple[Any, ...]
    events: tuple[Any, ...]

    @property
    def lost_messages(self) -> int:
        """The number of (message, receiver) pairs lost."""
        return sum(event.lost for event in self.events)

    @property
    def system(self) -> System:
        """The system that ran."""
        return self.scope.system

    @property
    def reading(self) -> Reading:
        """The reading under which it ran."""
        return self.scope.reading

    @property
    def claim(self) -> Claim[Any] | None:
        """The claim that the trace is about; None if it is about a witness."""
        return next((claim for claim in self.system.claims if claim.id == self.trace.shows), None)

    def observed(self, k: int) -> Any:
        """Return what claims see in the computation phase of round k."""
        return self.model.observe(self.states[k])

    def broken_at(self, k: int) -> Sequence[Any]:
        """Return where the trace's claim is false in the computation phase of round k (an Always only)."""
        return [] if self.claim is None else self.claim.broken_in(self.observed(k))

    @property
    def is_violation(self) -> bool:
        """Whether the trace shows that a claim is false."""
        return self.claim is not None and not isinstance(self.claim.question, Reachable)


def replay(trace: Trace) -> Replay:
    """Run a trace on the readable model, and check that it shows what it says.

    Raises:
        BadInput: a round of the trace cannot happen, or the trace does not show what it says.
    """
    system = load(trace.system)
    scope = Scope(system, trace.sizes, system.reading.from_values(trace.semantics))
    model = scope.model()
    states, sent, events = [model.initial()], [], []
    for k, recorded in enumerate(trace.rounds):
        on_air, event = model.read(states[-1], recorded, k)
        states.append(model.receive(on_air, event))
        sent.append(on_air)
        events.append(event)
    replayed = Replay(trace, scope, model, tuple(states), tuple(sent), tuple(events))
    _check_shows(replayed)
    return replayed


def _check_shows(replayed: Replay) -> None:
    """Raise BadInput unless the run shows what its trace says."""
    trace, claim = replayed.trace, replayed.claim
    if claim is not None and not claim.applies_to(replayed.reading):
        raise BadInput(f"the trace is about {claim.id}, which cannot be asked under {replayed.reading.name()}")
    question = None if claim is None else claim.question
    if trace.loop_start is not None:
        if not isinstance(question, Recovers):
            raise BadInput(f"the trace has a loop, but {trace.shows!r} is no claim about loops")
        _check_loop(replayed, question, trace.loop_start)
        return
    match question:
        case None:
            _check_witness(replayed)
        case Always():
            if not replayed.broken_at(len(trace.rounds)):
                raise BadInput(f"the trace does not show that {trace.shows} is violated: at its end the claim is true")
        case Reachable(goal):
            if not goal(replayed.observed(-1)):
                raise BadInput(f"the trace does not show {trace.shows}: at its end the goal is not reached")
        case Recovers():
            raise BadInput(f"the trace does not show that {trace.shows} is violated: it has no loop_start")


def _check_loop(replayed: Replay, question: Recovers[Any], start: int) -> None:
    end = len(replayed.events)
    if start >= end:
        raise BadInput(f"the trace's loop starts in round {start}, but the trace ends after {end} rounds")
    if any(event.lost for event in replayed.events[start:]):
        raise BadInput("the trace's loop loses messages: recovery is claimed only for loss-free rounds")
    if all(question.goal(replayed.observed(k)) for k in range(start, end + 1)):
        raise BadInput(f"{question.settled} throughout the trace's loop: it shows no failure to recover")
    first, last = (replayed.model.representative(replayed.states[k]) for k in (start, end))
    if first != last:
        raise BadInput("the trace's loop does not close: its last state behaves unlike its first")


def _check_witness(replayed: Replay) -> None:
    shows, witnesses = replayed.trace.shows, replayed.system.witnesses
    witness = next((one for one in witnesses if one.id == shows), None)
    last = replayed.observed(-1)
    match witness:
        case None:
            known = ", ".join([*(c.id for c in replayed.system.claims), *(w.id for w in witnesses)])
            raise BadInput(f"the trace is about {shows!r}; there is {known}")
        case Witness():
            seen = witness.seen_in(last)
        case Return():
            away = frozenset[int]().union(*(witness.away(replayed.observed(k)) for k in range(len(replayed.states))))
            seen = bool(away & witness.back(last))
    if not seen:
        raise BadInput(f"the trace does not show {shows}")
