"""The table of the audit: which two trajectories can be flown in round k + 1, and which lemma speaks of them.

A UAV is selected (in A_ET(k)) or not; it is planned (in Ã_ET(k)) only if it is selected and |D(k)| = 1 (Algorithm 1,
line 17); in round k + 1 it flies an entry of D(k), or its new trajectory if it was planned and heard of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from itertools import combinations_with_replacement
from typing import NamedTuple

from swarmproof.algebra.statement import Statement
from swarmproof.dmpc_swarm.proofs.terms.separation import both_new, both_old, one_new


class Role(NamedTuple):
    """What one UAV of a pair is in round k, and what it flies in round k + 1."""

    selected: bool
    planned: bool
    entries: int
    new: bool

    @property
    def possible(self) -> bool:
        """Whether the algorithm lets this happen."""
        return not (self.planned and (not self.selected or self.entries > 1)) and not (self.new and not self.planned)

    @property
    def id(self) -> str:
        """A short name: U or S (unselected, selected) and |D(k)|, or P (planned), with o or n for old and new."""
        if self.planned:
            return "Pn" if self.new else "Po"
        return f"{'S' if self.selected else 'U'}{self.entries}"

    def in_words(self) -> str:
        """Say what the UAV is and flies."""
        if self.planned:
            flies = "new trajectory" if self.new else "old trajectory (it missed the new one)"
            return f"planned, |D| = 1, {flies}"
        entry = "the entry" if self.entries == 1 else "either entry"
        return f"{'selected, not planned' if self.selected else 'not selected'}, |D| = {self.entries}, {entry}"


class Lemma(StrEnum):
    """The statement of Section 4.3.2 that speaks of a pair."""

    COROLLARY_1 = "Corollary 1"
    LEMMA_3 = "Lemma 3"
    LEMMA_4 = "Lemma 4"


class Cell(NamedTuple):
    """A pair of trajectories that can be flown in round k + 1; where one is new, `i` has it."""

    i: Role
    j: Role

    @property
    def id(self) -> str:
        """The cell's name, e.g. Pn-S2."""
        return f"{self.i.id}-{self.j.id}"

    @property
    def lemma(self) -> Lemma | None:
        """The printed statement whose hypotheses the pair meets; None if there is none."""
        if self.i.new and self.j.new:
            return Lemma.COROLLARY_1
        if self.i.new and not self.j.planned:
            return Lemma.LEMMA_3
        if not self.i.planned and not self.j.planned:
            return Lemma.LEMMA_4
        return None

    def statement(self, assume_20: bool) -> Statement:
        """Return that the pair is d̂_min apart at a sample, from (15) as planned and, if assumed, (20) at the sample.

        What (15) says depends on A_ET(k): UAV i's planner puts its plane halfway if j is selected.
        """
        if self.i.new and self.j.new:
            return both_new(self.j.selected, self.i.selected)
        if self.i.new:
            return one_new(self.j.selected, assume_20)
        return both_old(assume_20)


ROLES = tuple(
    role
    for planned in (True, False)
    for new in (True, False)
    for selected in (True, False)
    for entries in (1, 2)
    if (role := Role(selected, planned, entries, new)).possible
)


def cells() -> Iterator[Cell]:
    """Yield all pairs of trajectories that can be flown in round k + 1, each unordered pair once."""
    for i, j in combinations_with_replacement(ROLES, 2):
        yield Cell(i, j)
