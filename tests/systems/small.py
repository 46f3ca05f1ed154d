"""Small scopes of the systems under test, with what is known of them: `tests.PACKAGE.known.SMALL` of each system."""

from __future__ import annotations

from dataclasses import dataclass, field

from swarmproof.system import Scope
from swarmproof.systems import load


@dataclass(frozen=True)
class Small:
    """A scope that is explored in a second, and what must be found in it.

    Attributes:
        states: all that are reachable.
        violated: by claim, the rounds and the losses of the shortest run that violates it; None where no run can.
        holds: the claims that hold; all others are not applicable.
    """

    system: str
    sizes: dict[str, int]
    preset: str
    states: int
    violated: dict[str, tuple[int, int] | None] = field(default_factory=dict)
    holds: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """A name for tests."""
        return "-".join([self.system, self.preset, *(str(number) for number in self.sizes.values())])

    def scope(self) -> Scope:
        """Return the scope."""
        system = load(self.system)
        return Scope(system, self.sizes, system.reading.parse(self.preset))
