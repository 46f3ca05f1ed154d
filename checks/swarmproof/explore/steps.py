"""What a search asks of a system: its rounds, for many states at once, on states that are packed into ints (keys)."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from typing import Any, Protocol

#: Values of a frontier: the losses of the cheapest way here, above the index of the state that it comes from.
PARENT_BITS = 32
PARENT_MASK = (1 << PARENT_BITS) - 1
#: By key, its value.
Frontier = dict[int, int]


class TooLarge(RuntimeError):
    """Some number overflowed what keys have room for: the configuration is beyond what this engine explores."""


class Steps(Protocol):
    """The successor relation of one system of one size under one reading.

    Attributes:
        steps: the (intermediate state, effect) pairs taken so far.
        chunk: how many states are taken through a round together; a limit is noticed after each such chunk.
    """

    steps: int
    chunk: int

    def initial_key(self) -> int:
        """Return the key of the state in the first computation phase."""
        ...

    def run(self, frontier: Frontier) -> Frontier:
        """Return the states one round later, each with the cheapest value with which it is reached."""
        ...

    def loss_free(self, keys: Sequence[int]) -> Iterable[tuple[int, int]]:
        """Yield (position in `keys`, key one round later) for every round that loses nothing, each pair once."""
        ...

    def pack(self, state: Any) -> int:
        """Return the key of a state of the readable model."""
        ...

    def unpack(self, key: int) -> Any:
        """Return the state of the readable model that stands for this key."""
        ...

    def parts(self, key: int) -> Sequence[Hashable]:
        """Return, for each part of a state, a value that determines all that a claim about that part can see."""
        ...

    def outline(self, key: int) -> Hashable:
        """Return a value that determines all that goals of recovery, and witnesses of outlines, can see."""
        ...
