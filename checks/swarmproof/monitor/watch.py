"""Reads the claims, and the witnesses of non-vacuity, on every state that an exploration finds."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Any

from swarmproof.claims.claim import Always, Claim, Reachable, Witness
from swarmproof.explore.search import Exploration
from swarmproof.explore.steps import Steps


class Watch:
    """Remembers, for each claim and witness, the first state in which it is broken, reached or seen.

    Attributes:
        first: by id, the index of that state: of least depth, and among these with the fewest losses before it.
    """

    def __init__(
        self,
        rounds: Steps,
        observe: Callable[[Any], Any],
        claims: Sequence[Claim[Any]],
        witnesses: Sequence[Witness[Any]],
    ) -> None:
        self._rounds = rounds
        self._observe = observe
        self._of_parts: list[tuple[str, Callable[[Any, int], Sequence[Any]]]] = []
        self._whole: list[tuple[str, Callable[[Any], Sequence[Any]]]] = []
        self._goals: list[tuple[str, Callable[[Any], bool]]] = []
        parts = bool(rounds.parts(rounds.initial_key()))
        for claim in claims:
            match claim.question:
                case Always(broken, part):
                    if part is not None and parts:
                        self._of_parts.append((claim.id, part))
                    else:
                        self._whole.append((claim.id, broken))
                case Reachable(goal):
                    self._goals.append((claim.id, goal))
        self._witnesses = list(witnesses)
        self._part_memo: dict[Hashable, tuple[str, ...]] = {}
        self._outline_memo: dict[tuple[str, Hashable], bool] = {}
        self.first: dict[str, int] = {}

    def __call__(self, exploration: Exploration, begin: int) -> bool:
        """Read everything on the states from index `begin` on; never asks to stop."""
        best: dict[str, tuple[int, int]] = {}
        for index in range(begin, len(exploration.keys)):
            for seen in self._seen_in(exploration.keys[index]):
                rank = (exploration.losses[index], index)
                if seen not in best or rank < best[seen]:
                    best[seen] = rank
        self.first |= {name: index for name, (_, index) in best.items()}
        self._of_parts = [one for one in self._of_parts if one[0] not in self.first]
        self._whole = [one for one in self._whole if one[0] not in self.first]
        self._goals = [one for one in self._goals if one[0] not in self.first]
        self._witnesses = [witness for witness in self._witnesses if witness.id not in self.first]
        self._part_memo.clear()
        return False

    def _seen_in(self, key: int) -> list[str]:
        seen: list[str] = []
        if self._of_parts:
            for i, part in enumerate(self._rounds.parts(key)):
                broken = self._part_memo.get(part)
                if broken is None:
                    broken = self._part_memo[part] = self._broken_in_part(key, i)
                seen.extend(broken)
        if self._whole:
            observed = self._observe(self._rounds.unpack(key))
            seen.extend(name for name, broken_in in self._whole if broken_in(observed))
        for name, goal in self._goals:
            if goal(self._observe(self._rounds.unpack(key))):
                seen.append(name)
        seen.extend(witness.id for witness in self._witnesses if self._witnessed(witness, key))
        return seen

    def _broken_in_part(self, key: int, i: int) -> tuple[str, ...]:
        observed = self._observe(self._rounds.unpack(key))
        return tuple(name for name, broken_in in self._of_parts if broken_in(observed, i))

    def _witnessed(self, witness: Witness[Any], key: int) -> bool:
        if not witness.outline:
            return witness.seen_in(self._observe(self._rounds.unpack(key)))
        situation = (witness.id, self._rounds.outline(key))
        seen = self._outline_memo.get(situation)
        if seen is None:
            seen = self._outline_memo[situation] = witness.seen_in(self._observe(self._rounds.unpack(key)))
        return seen
