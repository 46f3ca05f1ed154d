"""The executable model of Algorithms 1 and 2 behind the port: glue, no rules.

A round is written into a trace as what was decided, lost and adopted, by index; what that means is computed anew when
it is read.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Annotated, NamedTuple

import msgspec

from swarmproof.dmpc_swarm.claims.observed import ObservedSwarm
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit, Decision
from swarmproof.dmpc_swarm.protocol.messages import Metadata, Trajectory
from swarmproof.dmpc_swarm.protocol.network import (
    Air,
    Reception,
    cu_receptions,
    receive_at_cu,
    receive_at_uav,
    uav_receptions,
)
from swarmproof.dmpc_swarm.protocol.swarm import Events, Swarm, all_decisions, compute, forbidden, initial_swarm
from swarmproof.dmpc_swarm.protocol.uav import Uav, adopt, offers
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.symmetry import Abstraction, canonical_swarm
from swarmproof.errors import BadInput

Index = Annotated[int, msgspec.Meta(ge=0)]


class RecordedReception(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """The messages lost on the way to one receiver, and the slots of which it decoded the reply in a conflict."""

    lost_uavs: list[Index] = []
    lost_slots: list[Index] = []
    decoded_replies: list[Index] = []


class RecordedRound(msgspec.Struct, forbid_unknown_fields=True):
    """One round: by CU whom it plans or asks, by receiver what it misses, by UAV whose new trajectory it adopts."""

    decided: list[Index | None]
    at_cus: list[RecordedReception]
    at_uavs: list[RecordedReception]
    adopted: list[Index | None]


class OnAir(NamedTuple):
    """A swarm at the end of a computation phase.

    Attributes:
        before: the swarm in the computation phase.
        decided: by CU, whom it plans or asks.
        computed: by CU, the CU after Alg. 1 line 34.
        air: everything that is transmitted.
    """

    before: Swarm
    decided: tuple[Decision, ...]
    computed: tuple[ComputeUnit, ...]
    air: Air


class SwarmModel:
    """MLR-DMPC with N UAVs (`sizes["uavs"]`) and M CUs (`sizes["cus"]`) under one reading of the paper."""

    def __init__(self, sizes: Mapping[str, int], semantics: Semantics) -> None:
        self.uavs, self.cus, self.semantics = sizes["uavs"], sizes["cus"], semantics

    def initial(self) -> Swarm:
        """Return the swarm in the computation phase of round 0."""
        return initial_swarm(self.uavs, self.cus, self.semantics)

    def choices(self, state: Swarm) -> Sequence[tuple[Decision, ...]]:
        """Return every combination of decisions of the CUs."""
        return all_decisions(state, self.semantics)

    def compute(self, state: Swarm, choice: tuple[Decision, ...]) -> OnAir:
        """Return what is transmitted (Alg. 1 lines 12-34)."""
        return OnAir(state, choice, *compute(state, choice, self.semantics))

    def events(self, sent: OnAir, lossless: bool = False) -> Iterator[Events]:
        """Yield, for every distinct outcome at all receivers, the receptions that lose the fewest messages for it."""
        at_cus = [self._at_cu(cu, sent.air, lossless) for cu in sent.computed]
        at_uavs = [self._at_uav(uav, sent.air, lossless) for uav in sent.before.uavs]
        for cus in product(*at_cus):
            for uavs in product(*at_uavs):
                yield Events(sent.decided, cus, tuple(got for got, _ in uavs), tuple(new for _, new in uavs))

    def receive(self, sent: OnAir, event: Events) -> Swarm:
        """Return the swarm of the next round: adoption (eq. 10), Algorithm 2 and Alg. 1 lines 8-11."""
        uavs = zip(sent.before.uavs, event.at_uavs, event.adopted, strict=True)
        return Swarm(
            sent.before.k + 1,
            tuple(adopt(uav, got.inbox, new) for uav, got, new in uavs),
            tuple(self._after(cu, got) for cu, got in zip(sent.computed, event.at_cus, strict=True)),
        )

    def observe(self, state: Swarm) -> ObservedSwarm:
        """Return what can be seen of a swarm."""
        return observe(state)

    def representative(self, state: Swarm) -> Swarm:
        """Return the representative of all swarms that behave like this one (docs/abstraction.md)."""
        return canonical_swarm(state, self.semantics, Abstraction.ESSENTIAL)

    def write(self, event: Events) -> RecordedRound:
        """Return a round as a trace keeps it."""
        return RecordedRound(
            list(event.decided),
            [RecordedReception(list(r.lost_uavs), list(r.lost_slots), list(r.decoded_replies)) for r in event.at_cus],
            [RecordedReception([], list(r.lost_slots), list(r.decoded_replies)) for r in event.at_uavs],
            [None if new is None else new.metadata.cu for new in event.adopted],
        )

    def read(self, state: Swarm, recorded: RecordedRound, k: int) -> tuple[OnAir, Events]:
        """Return what is on the air in round k, and what happens, of a round that a trace kept.

        Raises:
            BadInput: it cannot happen in `state`.
        """
        sizes = [len(recorded.decided), len(recorded.at_cus), len(recorded.at_uavs), len(recorded.adopted)]
        if sizes != [self.cus, self.cus, self.uavs, self.uavs]:
            raise BadInput(f"round {k} of the trace is not about {self.uavs} UAVs and {self.cus} CUs")
        decided = tuple(recorded.decided)
        reason = forbidden(state, decided, self.semantics)
        if reason is not None:
            raise BadInput(f"round {k} of the trace cannot happen: {reason}")
        sent = self.compute(state, decided)
        at_cus = tuple(
            receive_at_cu(w, sent.air, r.lost_uavs, r.lost_slots, r.decoded_replies, self.semantics)
            for w, r in enumerate(recorded.at_cus)
        )
        at_uavs = tuple(
            receive_at_uav(i, sent.air, r.lost_slots, r.decoded_replies, self.semantics)
            for i, r in enumerate(recorded.at_uavs)
        )
        for w, got in enumerate(at_cus):
            _check_received(k, f"CU {w}", recorded.at_cus[w], got)
        for i, got in enumerate(at_uavs):
            _check_received(k, f"UAV {i}", recorded.at_uavs[i], got)
        adopted = []
        for uav, got, cu in zip(state.uavs, at_uavs, recorded.adopted, strict=True):
            new = None if cu is None else Trajectory(Metadata(k, cu))
            offered = offers(uav, got.inbox)
            if new not in (offered or (None,)):
                raise BadInput(
                    f"round {k} of the trace lets UAV {uav.i} adopt {_name(new)}; it receives {_names(offered)}"
                )
            adopted.append(new)
        return sent, Events(decided, at_cus, at_uavs, tuple(adopted))

    def tell_state(self, state: Swarm) -> Sequence[tuple[str, str]]:
        """Return by CU its state; the pages of DMPC-Swarm tell more."""
        return [(f"CU {cu.w}", cu.state.name) for cu in state.cus]

    def tell_event(self, sent: OnAir, event: Events) -> Sequence[str]:
        """Return how many messages are lost; the pages of DMPC-Swarm tell more."""
        return [f"{event.lost} messages are lost"] if event.lost else []

    def _at_cu(self, cu: ComputeUnit, air: Air, lossless: bool) -> list[Reception]:
        cheapest: dict[ComputeUnit, Reception] = {}
        for reception in cu_receptions(cu.w, air, self.semantics):
            if lossless and reception.lost:
                continue
            after = self._after(cu, reception)
            if after not in cheapest or reception.lost < cheapest[after].lost:
                cheapest[after] = reception
        return list(cheapest.values())

    def _at_uav(self, uav: Uav, air: Air, lossless: bool) -> list[tuple[Reception, Trajectory | None]]:
        cheapest: dict[Uav, tuple[Reception, Trajectory | None]] = {}
        for reception in uav_receptions(uav.i, air, self.semantics):
            if lossless and reception.lost:
                continue
            for adopted in offers(uav, reception.inbox) or (None,):
                after = adopt(uav, reception.inbox, adopted)
                if after not in cheapest or reception.lost < cheapest[after][0].lost:
                    cheapest[after] = reception, adopted
        return list(cheapest.values())

    def _after(self, cu: ComputeUnit, got: Reception) -> ComputeUnit:
        return algorithm1.update(cu, got.inbox, self.cus, self.semantics)


def _check_received(k: int, who: str, recorded: RecordedReception, got: Reception) -> None:
    """Refuse losses that cannot be: of what nobody sent, or of what a receiver sent itself; and the same one twice."""
    for words, given, possible in (
        ("loses the metadata of UAV", recorded.lost_uavs, got.lost_uavs if who.startswith("CU") else ()),
        ("loses the message of slot", recorded.lost_slots, got.lost_slots),
        ("decodes, in a conflict, the reply of slot", recorded.decoded_replies, got.decoded_replies),
    ):
        wrong = next((one for n, one in enumerate(given) if one not in possible or one in given[:n]), None)
        if wrong is not None:
            why = "that is there twice" if wrong in possible else "nothing of the kind is sent to it"
            raise BadInput(f"round {k} of the trace cannot happen: {who} {words} {wrong}, but {why}; leave it out")


def _name(trajectory: Trajectory | None) -> str:
    return "nothing new" if trajectory is None else f"the trajectory of CU {trajectory.metadata.cu}"


def _names(trajectories: Sequence[Trajectory]) -> str:
    return " and ".join(_name(t) for t in trajectories) or _name(None)
