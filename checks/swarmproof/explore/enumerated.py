"""The plain successor relation of any model: every choice, every event, one at a time. Slow, and easy to believe."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any

from swarmproof.explore.steps import PARENT_BITS, Frontier, TooLarge
from swarmproof.port.model import Model

#: The most states that are kept at once.
MOST_STATES = 1 << 24


class Enumerated:
    """A model as a :class:`~swarmproof.explore.steps.Steps`; keys number the states in order of appearance."""

    #: Few: a state alone may have thousands of events.
    chunk = 32

    def __init__(self, model: Model[Any, Any, Any, Any]) -> None:
        self.model = model
        self.steps = 0
        self._states: list[Any] = []
        self._keys: dict[Any, int] = {}

    def initial_key(self) -> int:
        """Return the key of the state in the first computation phase."""
        return self.pack(self.model.initial())

    def pack(self, state: Any) -> int:
        """Return the key of a state: that of its representative.

        Raises:
            TooLarge: there are too many states.
        """
        state = self.model.representative(state)
        key = self._keys.get(state)
        if key is None:
            key = len(self._states)
            if key >= MOST_STATES:
                raise TooLarge(f"more than {MOST_STATES} states")
            self._keys[state] = key
            self._states.append(state)
        return key

    def unpack(self, key: int) -> Any:
        """Return the state with this key."""
        return self._states[key]

    def run(self, frontier: Frontier) -> Frontier:
        """Return the states one round later, each with the cheapest value with which it is reached."""
        found: Frontier = {}
        for key, value in frontier.items():
            for after, lost in self._rounds(key):
                cost = value + (lost << PARENT_BITS)
                if cost < found.get(after, cost + 1):
                    found[after] = cost
        return found

    def loss_free(self, keys: Sequence[int]) -> Iterator[tuple[int, int]]:
        """Yield (position in `keys`, key one round later) for every round that loses nothing, each pair once."""
        for position, key in enumerate(keys):
            yield from dict.fromkeys((position, after) for after, _ in self._rounds(key, lossless=True))

    def parts(self, key: int) -> Sequence[Hashable]:
        """Return nothing: the parts of a state are not told apart."""
        return ()

    def outline(self, key: int) -> Hashable:
        """Return the key: the outline is the whole state."""
        return key

    def _rounds(self, key: int, lossless: bool = False) -> Iterator[tuple[int, int]]:
        """Yield (key after a round, losses in it) for everything that can happen."""
        state = self._states[key]
        for choice in self.model.choices(state):
            sent = self.model.compute(state, choice)
            for event in self.model.events(sent, lossless):
                self.steps += 1
                yield self.pack(self.model.receive(sent, event)), event.lost
