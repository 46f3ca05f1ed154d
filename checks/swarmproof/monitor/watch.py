"""Reads the claims, and the witnesses of non-vacuity, on every state that an exploration finds."""

from __future__ import annotations

from collections.abc import Sequence

from swarmproof.dmpc_swarm.claims.protocol import Claim, Kind
from swarmproof.dmpc_swarm.claims.witnesses import WITNESSES, Witness
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.explore.search import Exploration


class Watch:
    """Remembers, for each claim and witness, the first state in which it is broken, reached or seen.

    Attributes:
        first: by id, the index of that state: of least depth, and among these with the fewest losses before it.
    """

    def __init__(self, rounds: Rounds, claims: Sequence[Claim]) -> None:
        self._rounds = rounds
        self._per_uav = [claim for claim in claims if claim.per_uav is not None]
        self._whole = [claim for claim in claims if claim.whole is not None]
        self._goals = [claim for claim in claims if claim.kind is Kind.REACHABLE]
        self._witnesses = list(WITNESSES)
        self._uav_memo: dict[tuple[int, ...], tuple[str, ...]] = {}
        self._air_memo: dict[tuple[str, int], bool] = {}
        self._column_bits = rounds.columns_mask.bit_length()
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
        self._per_uav = [claim for claim in self._per_uav if claim.id not in self.first]
        self._whole = [claim for claim in self._whole if claim.id not in self.first]
        self._goals = [claim for claim in self._goals if claim.id not in self.first]
        self._witnesses = [witness for witness in self._witnesses if witness.id not in self.first]
        self._uav_memo.clear()
        return False

    def _seen_in(self, key: int) -> list[str]:
        seen: list[str] = []
        if self._per_uav:
            controls = key >> self._column_bits
            for i, column in enumerate(self._rounds.column_numbers(key)):
                broken = self._uav_memo.get((i, column, controls))
                if broken is None:
                    broken = self._uav_memo[i, column, controls] = self._broken_for_uav(key, i)
                seen.extend(broken)
        if self._whole:
            swarm = observe(self._rounds.unpack(key))
            seen.extend(claim.id for claim in self._whole if claim.whole is not None and claim.whole(swarm))
        for claim in self._goals:
            if claim.goal is not None and claim.goal(observe(self._rounds.unpack(key))):
                seen.append(claim.id)
        seen.extend(witness.id for witness in self._witnesses if self._witnessed(witness, key))
        return seen

    def _broken_for_uav(self, key: int, i: int) -> tuple[str, ...]:
        uav = observe(self._rounds.unpack(key)).of_uav(i)
        return tuple(claim.id for claim in self._per_uav if claim.per_uav is not None and claim.per_uav(uav))

    def _witnessed(self, witness: Witness, key: int) -> bool:
        if witness.looks_at_trackers:
            return witness.seen_in(observe(self._rounds.unpack(key)))
        situation = (witness.id, key >> self._column_bits)
        seen = self._air_memo.get(situation)
        if seen is None:
            seen = self._air_memo[situation] = witness.seen_in(observe(self._rounds.unpack(key)))
        return seen
