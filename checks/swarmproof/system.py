"""What a system under test is to the engines: its sizes, open places, claims, model; and the scope of a verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from swarmproof.claims.claim import Claim, Return, Witness, select
from swarmproof.claims.reading import Reading
from swarmproof.errors import BadInput
from swarmproof.explore.enumerated import Enumerated
from swarmproof.explore.steps import Steps
from swarmproof.port.model import Model


def nowhere(_: str) -> str:
    """Return that a claim which the system does not have is decided nowhere else."""
    return ""


@dataclass(frozen=True)
class Size:
    """One number that says how large a system is.

    Attributes:
        name: as in options, traces and documents, such as ``uavs``.
        noun: as in sentences, in the plural, such as ``UAVs``.
        symbol: the paper's letter.
        usual: if none is given.
        most: the most that can be explored.
        longest: the most in a trace.
    """

    name: str
    noun: str
    symbol: str
    usual: int
    most: int
    longest: int
    least: int = 1


@dataclass(frozen=True)
class System:
    """A system under test.

    Attributes:
        name: as in traces and documents.
        paper: where it is from, to be printed with every verdict.
        sizes: the numbers that say how large it is.
        reading: its open places.
        claims: what is claimed about it.
        witnesses: the situations that give claims something to say.
        model: makes the readable model.
        recorded: the msgspec structure in which a trace keeps one round.
        abstracted: what is left out and merged, in sentences.
        in_short: the same in one sentence, for the terminal.
        steps: makes the successor relation that is searched; None for the plain one of the model.
        elsewhere: of an id of no claim, where it is decided, to end a sentence with.
    """

    name: str
    paper: str
    sizes: tuple[Size, ...]
    reading: type[Reading]
    claims: tuple[Claim[Any], ...]
    witnesses: tuple[Witness[Any] | Return[Any], ...]
    model: Callable[[Mapping[str, int], Any], Model[Any, Any, Any, Any]]
    recorded: type[Any]
    abstracted: str
    in_short: str
    steps: Callable[[Mapping[str, int], Any], Steps] | None = None
    elsewhere: Callable[[str], str] = nowhere

    def select_claims(self, ids: Sequence[str] = ()) -> tuple[Claim[Any], ...]:
        """Return the claims with these ids; all of them if `ids` is empty.

        Raises:
            BadInput: there is no claim of that id.
        """
        return select(self.claims, ids, self.elsewhere)


@dataclass(frozen=True)
class Scope:
    """What a verdict is about: a system of some sizes under one reading."""

    system: System
    sizes: Mapping[str, int]
    reading: Reading

    def explorable(self) -> Scope:
        """Return this scope.

        Raises:
            BadInput: a size with which it cannot be explored.
        """
        for size in self.system.sizes:
            number = self.sizes[size.name]
            if not size.least <= number <= size.most:
                raise BadInput(f"{number} {size.noun} cannot be explored: choose {size.least} to {size.most}")
        return self

    def model(self) -> Model[Any, Any, Any, Any]:
        """Return the readable model."""
        return self.system.model(self.sizes, self.reading)

    def steps(self) -> Steps:
        """Return the successor relation that is searched.

        Raises:
            BadInput: a size with which it cannot be explored.
        """
        make = self.explorable().system.steps
        return Enumerated(self.model()) if make is None else make(self.sizes, self.reading)

    def swarm(self) -> str:
        """Return the sizes, such as ``2 UAVs, 2 CUs``."""
        return ", ".join(f"{self.sizes[size.name]} {size.noun}" for size in self.system.sizes)


def scope_of(system: System, given: Mapping[str, int | None], reading: Reading) -> Scope:
    """Return the scope with the sizes that a user gave, and the usual ones for the others.

    Raises:
        BadInput: a size that the system does not have, or that cannot be explored.
    """
    known = {size.name: size for size in system.sizes}
    for name, number in given.items():
        if number is not None and name not in known:
            raise BadInput(f"{system.name} has no {name}: leave --{name} out, it has {', '.join(known)}")
    sizes = {name: given.get(name) or size.usual for name, size in known.items()}
    return Scope(system, sizes, reading).explorable()
