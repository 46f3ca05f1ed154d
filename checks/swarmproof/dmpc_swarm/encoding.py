"""Swarms packed into ints, their *keys*: exact, canonical, and small enough to hold millions.

Lowest field first: a column per UAV, a control per CU, by UAV the CUs that it will answer, k mod M; during a round,
what is on the air; above it, a tag of the caller's.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Generic, NamedTuple, TypeVar

from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit, CuState
from swarmproof.dmpc_swarm.protocol.swarm import Swarm, initial_swarm
from swarmproof.dmpc_swarm.protocol.uav import Uav
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.symmetry import CANONICAL_ROUND, Abstraction, Column, canonical_swarm
from swarmproof.explore.steps import TooLarge

T = TypeVar("T", bound=Hashable)

COLUMN_BITS = 20
CONTROL_BITS = 10
PHASE_BITS = 4
AIR_BITS = 24


class Numbering(Generic[T]):
    """Numbers distinct values in order of appearance."""

    def __init__(self, bits: int) -> None:
        self.values: list[T] = []
        self._numbers: dict[T, int] = {}
        self._limit = 1 << bits

    def __call__(self, value: T) -> int:
        """Return the number of `value`, a new one if it is new."""
        number = self._numbers.get(value)
        if number is None:
            number = len(self.values)
            if number >= self._limit:
                raise TooLarge(f"more than {self._limit} distinct {type(value).__name__} values")
            self._numbers[value] = number
            self.values.append(value)
        return number


class Table(dict[int, int]):
    """A dict that computes what is missing."""

    def __init__(self, compute: Callable[[int], int]) -> None:
        super().__init__()
        self._compute = compute

    def __missing__(self, key: int) -> int:
        value = self[key] = self._compute(key)
        return value


class Control(NamedTuple):
    """What a CU knows besides its trackers."""

    state: CuState
    next_request: int
    a_et: tuple[int, ...] | None


class PackedSwarms:
    """The keys of all swarms with one number of UAVs and CUs under one semantics.

    Attributes:
        columns, controls: what the numbers in a key stand for.
        columns_mask: the bits of all columns.
        key_bits: the size of the key of a swarm in the computation phase.
        tag_at: the lowest bit that no key ever uses.
    """

    def __init__(self, uavs: int, cus: int, semantics: Semantics, abstraction: Abstraction) -> None:
        self.uavs, self.cus, self.semantics, self.abstraction = uavs, cus, semantics, abstraction
        self.columns: Numbering[Column] = Numbering(COLUMN_BITS)
        self.controls: Numbering[Control] = Numbering(CONTROL_BITS)
        self.columns_mask = (1 << COLUMN_BITS * uavs) - 1
        self._column_at = [COLUMN_BITS * i for i in range(uavs)]
        at = COLUMN_BITS * uavs
        self._control_at = [at + CONTROL_BITS * w for w in range(cus)]
        at += CONTROL_BITS * cus
        self._asked_from = at
        self._asked_at = [at + cus * i for i in range(uavs)]
        at += cus * uavs
        self._phase_at = at
        at += PHASE_BITS
        self.key_bits = self._air_at = at
        self.tag_at = at + AIR_BITS

    def pack(self, swarm: Swarm) -> int:
        """Return the key of the canonical representative of `swarm`."""
        swarm = canonical_swarm(swarm, self.semantics, self.abstraction)
        key = (swarm.k - CANONICAL_ROUND) << self._phase_at
        for i, uav in enumerate(swarm.uavs):
            column = Column(uav.followed, uav.followed, tuple(cu.trackers[i] for cu in swarm.cus))
            key |= self.columns(column) << self._column_at[i]
            key |= sum(1 << w for w in uav.asked_by) << self._asked_at[i]
        for w, cu in enumerate(swarm.cus):
            key |= self.controls(Control(cu.state, cu.next_request, cu.a_et)) << self._control_at[w]
        return key

    def unpack(self, key: int) -> Swarm:
        """Return the canonical swarm with this key."""
        columns = [self.columns.values[number] for number in self.column_numbers(key)]
        controls = [self.controls.values[number] for number in self.control_numbers(key)]
        return Swarm(
            CANONICAL_ROUND + self._phase(key),
            tuple(Uav(i, column.after, self._asked_by(key, i)) for i, column in enumerate(columns)),
            tuple(
                ComputeUnit(w, c.state, tuple(col.trackers[w] for col in columns), c.next_request, c.a_et)
                for w, c in enumerate(controls)
            ),
        )

    def initial_key(self) -> int:
        """Return the key of the swarm in the first computation phase."""
        return self.pack(initial_swarm(self.uavs, self.cus, self.semantics))

    def column_numbers(self, key: int) -> tuple[int, ...]:
        """Return the number of each UAV's column."""
        return tuple(key >> at & (1 << COLUMN_BITS) - 1 for at in self._column_at)

    def control_numbers(self, key: int) -> tuple[int, ...]:
        """Return the number of each CU's control."""
        return tuple(key >> at & (1 << CONTROL_BITS) - 1 for at in self._control_at)

    def _phase(self, key: int) -> int:
        return key >> self._phase_at & (1 << PHASE_BITS) - 1

    def _asked_by(self, key: int, i: int) -> frozenset[int]:
        return frozenset(w for w in range(self.cus) if key >> self._asked_at[i] + w & 1)
