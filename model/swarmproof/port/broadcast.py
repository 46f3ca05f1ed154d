"""Protocols in which, in every round, each node sends one message to all others, of which any may be lost.

Whoever writes such a protocol says how a node starts, what it sends and what it makes of what arrived; this module
makes a :class:`~swarmproof.port.model.Model` of it: losses, what is written into a trace, what a person sees.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Annotated, Any, Generic, TypeVar

import msgspec

from swarmproof.errors import BadInput

Node = TypeVar("Node")
Message = TypeVar("Message")
_Index = Annotated[int, msgspec.Meta(ge=0)]


class LostMessages(msgspec.Struct, forbid_unknown_fields=True):
    """One round in a trace: each message that was lost, as (sender, receiver)."""

    lost: list[tuple[_Index, _Index]]


@dataclass(frozen=True)
class Losses:
    """The event of a round: by receiver, the senders whose message it misses."""

    missed: tuple[frozenset[int], ...]

    @property
    def lost(self) -> int:
        """The number of (message, receiver) pairs lost."""
        return sum(len(senders) for senders in self.missed)


@dataclass(frozen=True)
class Broadcasts(Generic[Node, Message]):
    """All nodes, and by sender its message of this round; who is silent has none."""

    nodes: tuple[Node, ...]
    messages: Mapping[int, Message]


class Broadcast(ABC, Generic[Node, Message]):
    """A protocol of `count` nodes. States are tuples of nodes; nodes are values that can be hashed."""

    def __init__(self, count: int, noun: str) -> None:
        self.count, self.noun = count, noun

    @abstractmethod
    def start(self, i: int) -> Node:
        """Return node i before the first round."""

    @abstractmethod
    def send(self, i: int, node: Node) -> Message | None:
        """Return what node i sends to all others in this round; None if it is silent."""

    @abstractmethod
    def update(self, i: int, node: Node, inbox: Mapping[int, Message]) -> Node:
        """Return node i after it received `inbox`, by sender; it does not hear itself."""

    @abstractmethod
    def observe(self, state: tuple[Node, ...]) -> Any:
        """Return what claims may look at."""

    def tell(self, i: int, node: Node) -> str:
        """Return what a person sees of node i."""
        return str(node)

    def initial(self) -> tuple[Node, ...]:
        """Return the state before the first round."""
        return tuple(self.start(i) for i in range(self.count))

    def choices(self, state: tuple[Node, ...]) -> Sequence[None]:
        """Return the one choice: the nodes do what the protocol says."""
        return (None,)

    def compute(self, state: tuple[Node, ...], choice: None) -> Broadcasts[Node, Message]:
        """Return what every node sends."""
        sent = {i: self.send(i, node) for i, node in enumerate(state)}
        return Broadcasts(state, {i: message for i, message in sent.items() if message is not None})

    def events(self, sent: Broadcasts[Node, Message], lossless: bool = False) -> Iterator[Losses]:
        """Yield, for every distinct outcome at all receivers, the fewest losses that lead to it; first no loss."""
        for missed in product(*(self._missed(i, sent, lossless) for i in range(self.count))):
            yield Losses(missed)

    def _missed(self, i: int, sent: Broadcasts[Node, Message], lossless: bool) -> Sequence[frozenset[int]]:
        """Return what receiver i may miss, one way for every node that it can become, fewest losses first."""
        senders = [j for j in sent.messages if j != i]
        cheapest: dict[Node, frozenset[int]] = {}
        for number in range(1 if lossless else len(senders) + 1):
            for missed in combinations(senders, number):
                cheapest.setdefault(self._after(i, sent, frozenset(missed)), frozenset(missed))
        return list(cheapest.values())

    def _after(self, i: int, sent: Broadcasts[Node, Message], missed: frozenset[int]) -> Node:
        inbox = {j: message for j, message in sent.messages.items() if j != i and j not in missed}
        return self.update(i, sent.nodes[i], inbox)

    def receive(self, sent: Broadcasts[Node, Message], event: Losses) -> tuple[Node, ...]:
        """Return the state of the next round."""
        return tuple(self._after(i, sent, missed) for i, missed in enumerate(event.missed))

    def representative(self, state: tuple[Node, ...]) -> tuple[Node, ...]:
        """Return the state itself: nothing is merged."""
        return state

    def write(self, event: Losses) -> LostMessages:
        """Return a round as a trace keeps it."""
        return LostMessages([(j, i) for i, missed in enumerate(event.missed) for j in sorted(missed)])

    def read(self, state: tuple[Node, ...], recorded: LostMessages, k: int) -> tuple[Broadcasts[Node, Message], Losses]:
        """Return what is on the air in round k, and what is lost, of a round that a trace kept.

        Raises:
            BadInput: what is lost is not sent, or is there twice.
        """
        sent = self.compute(state, None)
        possible = {(j, i) for j in sent.messages for i in range(self.count) if i != j}
        for n, (j, i) in enumerate(recorded.lost):
            if (j, i) not in possible or (j, i) in recorded.lost[:n]:
                why = "that is there twice" if (j, i) in possible else "nothing of the kind is sent"
                raise BadInput(
                    f"round {k} of the trace cannot happen: {self._name(i)} loses the message of {self._name(j)}, but "
                    f"{why}; leave it out"
                )
        missed = tuple(frozenset(j for j, to in recorded.lost if to == i) for i in range(self.count))
        return sent, Losses(missed)

    def tell_state(self, state: tuple[Node, ...]) -> Sequence[tuple[str, str]]:
        """Return by node what it holds."""
        return [(self._name(i), self.tell(i, node)) for i, node in enumerate(state)]

    def tell_event(self, sent: Broadcasts[Node, Message], event: Losses) -> Sequence[str]:
        """Return, for each message that is lost, on the way to whom."""
        lost = [(j, i) for i, missed in enumerate(event.missed) for j in sorted(missed)]
        return [f"The message of {self._name(j)} is lost on the way to {self._name(i)}." for j, i in lost]

    def _name(self, i: int) -> str:
        return f"{self.noun} {i}"
