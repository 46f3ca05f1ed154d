"""A claim about a protocol: a question about its reachable states, with its wording, its place and its assumptions.

Claims look at observations only. What an observation is, each system says for itself; engines pass it on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from swarmproof.claims.reading import Reading
from swarmproof.errors import BadInput

O = TypeVar("O")  # noqa: E741 - an observation


class Violation(Protocol):
    """One place where a claim is false."""

    @property
    def where(self) -> str:
        """Who is concerned, such as ``CU 0, UAV 1``; empty if nobody in particular."""
        ...

    @property
    def why(self) -> str:
        """What is false there, in words."""
        ...


class Flaw(NamedTuple):
    """The plain violation: who is concerned, and why, in words."""

    where: str
    why: str


@dataclass(frozen=True)
class Always(Generic[O]):
    """The question whether nothing is broken in any reachable state.

    Attributes:
        broken: where the claim is false in an observation; empty if it is true.
        part: of a claim that is said of each part of a state alone, where it is false in part i; the engine then looks
            at each distinct part once. `broken` must find what `part` finds in all parts.
    """

    broken: Callable[[O], Sequence[Any]]
    part: Callable[[O, int], Sequence[Any]] | None = None


@dataclass(frozen=True)
class Reachable(Generic[O]):
    """The question whether a state can be reached in which `goal` is true."""

    goal: Callable[[O], bool]


@dataclass(frozen=True)
class Recovers(Generic[O]):
    """The question whether, from every reachable state, `goal` becomes and stays true once nothing is lost.

    Attributes:
        goal: what must become true; it may depend on the outline of a state only (see `Steps.outline`).
        settled: of the states in which it is true, in words, to end "all ... for good".
        unsettled: of the others, to end "no loss-free cycle has a state in which ...".
    """

    goal: Callable[[O], bool]
    settled: str
    unsettled: str


Question = Always[O] | Reachable[O] | Recovers[O]


@dataclass(frozen=True)
class Claim(Generic[O]):
    """One statement about a protocol.

    Attributes:
        asked_under: the values of switches under which it can be asked; otherwise it is not applicable, since
            `speaks_of` says what there is not.
        least: by size, the smallest of which it says anything.
        about: of an Always, in how many places of a state there is something that it speaks of.
        nothing: what there is not, where that is none: then it is true, but says nothing.
    """

    id: str
    wording: str
    place: str
    assumptions: str
    question: Question[O]
    asked_under: Mapping[str, str] = field(default_factory=dict)
    speaks_of: str = ""
    least: Mapping[str, int] = field(default_factory=dict)
    about: Callable[[O], int] | None = None
    nothing: str = ""

    def applies_to(self, reading: Reading) -> bool:
        """Say whether the claim can be asked under this reading."""
        return all(getattr(reading, name) == value for name, value in self.asked_under.items())

    def broken_in(self, observation: O) -> Sequence[Any]:
        """Return where this claim is false in `observation`; empty if it is true, or not about every state."""
        return self.question.broken(observation) if isinstance(self.question, Always) else []

    @property
    def is_safety(self) -> bool:
        """Whether one state can break it."""
        return isinstance(self.question, Always)


def select(claims: Sequence[Claim[O]], ids: Sequence[str], elsewhere: Callable[[str], str]) -> tuple[Claim[O], ...]:
    """Return the claims with these ids, in their own order; all of them if `ids` is empty.

    Args:
        claims: those of a system.
        ids: what a user wants.
        elsewhere: of an id that none has, where it is decided, to end the sentence with; empty if nowhere.

    Raises:
        BadInput: there is no claim of that id.
    """
    known = [claim.id for claim in claims]
    for name in ids:
        if name not in known:
            raise BadInput(f"there is no claim {name!r}: choose among {', '.join(known)}{elsewhere(name)}")
    return tuple(claim for claim in claims if not ids or claim.id in ids)


@dataclass(frozen=True)
class Witness(Generic[O]):
    """A situation worth having seen: a claim can hold because nothing happened.

    Attributes:
        outline: whether it depends on the outline of a state only (see `Steps.outline`), so that it is looked for once
            for each.
    """

    id: str
    wording: str
    seen_in: Callable[[O], bool]
    outline: bool = True


@dataclass(frozen=True)
class Return(Generic[O]):
    """A situation that a way shows, and no state: somebody who was away is back.

    Attributes:
        after: the witness whose first state has somebody away.
        away: who is away in a state.
        back: who is back in a state.
    """

    id: str
    wording: str
    after: str
    away: Callable[[O], frozenset[int]]
    back: Callable[[O], frozenset[int]]
