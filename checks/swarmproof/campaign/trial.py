"""A cell of an experiment: one flight, described by the options with which `swarmproof fly` flies it."""

from __future__ import annotations

import hashlib
import shlex
from dataclasses import dataclass

from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.faults.grammar import Loss, parse

#: Hexadecimal digits of a cell's id: among 10,000 cells, two have the same id with a probability of 5e-5.
DIGITS = 10


@dataclass(frozen=True, slots=True)
class Cell:
    """One flight.

    Attributes:
        scenario: the name of one that ships.
        cus: M.
        trigger: RR, DT or HT.
        loss: as for `swarmproof fly --loss`; no script, and no search.
        preset: of the semantics.
        seed: of everything random.
        rounds: length of the flight.
        changes: ``NAME=VALUE`` as for `swarmproof fly --set`.
        series: whether the distances to the targets are kept round by round; they make no other number different.
    """

    scenario: str
    cus: int
    trigger: str
    loss: str
    preset: str
    seed: int
    rounds: int
    changes: tuple[str, ...] = ()
    series: bool = False

    @property
    def words(self) -> tuple[str, ...]:
        """The options of `swarmproof fly` that fly it."""
        sets = (word for change in self.changes for word in ("--set", change))
        return (
            self.scenario,
            *("--cus", str(self.cus), "--trigger", self.trigger, "--loss", self.loss, "--semantics", self.preset),
            *("--seed", str(self.seed), "--rounds", str(self.rounds), *sets),
        )

    @property
    def command(self) -> str:
        """The command that flies it."""
        return shlex.join(["swarmproof", "fly", *self.words])

    @property
    def id(self) -> str:
        """What it is called: a digest of everything that determines it."""
        text = "\n".join([*self.words, *(["series"] if self.series else [])])
        return hashlib.sha256(text.encode()).hexdigest()[:DIGITS]

    def setting(self) -> Setting:
        """Return everything that determines the flight but what is lost.

        Raises:
            BadInput: it cannot be flown.
        """
        return Setting.parse(self.scenario, self.cus, self.trigger, self.preset, self.changes, self.seed)

    def losses(self, uavs: int) -> Loss:
        """Return what is lost, with so many UAVs.

        Raises:
            BadInput: there is no such loss model.
        """
        return parse(self.loss, uavs, self.cus, self.seed)
