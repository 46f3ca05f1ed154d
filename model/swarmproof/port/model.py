"""The port: what engines ask of anything that runs. One protocol; exploration, replay and random runs need no more.

A round of a system has three steps: the nodes *compute* what they transmit, the network decides what arrives (an
*event*), the nodes *receive* it. Everything that the algorithm does not determine is a choice, or in an event.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any, Protocol, TypeVar


class Event(Protocol):
    """What happened in a round beside the algorithm: which messages were lost, and whatever else is not determined."""

    @property
    def lost(self) -> int:
        """The number of (message, receiver) pairs that were lost."""
        ...


State = TypeVar("State", bound=Hashable)
Sent = TypeVar("Sent")
E = TypeVar("E", bound=Event)
Observation = TypeVar("Observation", covariant=True)


class Model(Protocol[State, Sent, E, Observation]):
    """A system of one size under one reading, with all rules in it. States are values that can be hashed."""

    def initial(self) -> State:
        """Return the state before the first round."""
        ...

    def choices(self, state: State) -> Sequence[Any]:
        """Return everything that the nodes can choose in this round; at least one."""
        ...

    def compute(self, state: State, choice: Any) -> Sent:
        """Return what is on the air, with whatever `receive` needs of the nodes."""
        ...

    def events(self, sent: Sent, lossless: bool = False) -> Iterator[E]:
        """Yield what the network can do, so that every state of the next round is reached with the fewest losses.

        Args:
            sent: what :meth:`compute` returned.
            lossless: yield only events that lose nothing.
        """
        ...

    def receive(self, sent: Sent, event: E) -> State:
        """Return the state in the computation phase of the next round."""
        ...

    def observe(self, state: State) -> Observation:
        """Return what claims may look at."""
        ...

    def representative(self, state: State) -> State:
        """Return the one state that stands for all that behave like this one; `state` itself if nothing is merged."""
        ...

    def write(self, event: E) -> Any:
        """Return an event as a trace keeps it."""
        ...

    def read(self, state: State, recorded: Any, k: int) -> tuple[Sent, E]:
        """Return what is on the air in round k, and the event, of a round that a trace kept.

        Raises:
            BadInput: it cannot happen in `state`.
        """
        ...

    def tell_state(self, state: State) -> Sequence[tuple[str, str]]:
        """Return what a person sees of a state: who, and what it holds."""
        ...

    def tell_event(self, sent: Sent, event: E) -> Sequence[str]:
        """Return what happens in a round, in sentences: what was chosen, what is lost on the way to whom."""
        ...
