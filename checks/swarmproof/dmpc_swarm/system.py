"""MLR-DMPC of DMPC-Swarm as a system under test."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, elsewhere
from swarmproof.dmpc_swarm.claims.witnesses import RECOVERY_LEFT, WITNESSES
from swarmproof.dmpc_swarm.model import RecordedRound, SwarmModel
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.dmpc_swarm.semantics import PAPER, Semantics
from swarmproof.dmpc_swarm.symmetry import MOST_CUS, Abstraction
from swarmproof.system import Scope, Size, System

#: Beyond these the search space is out of reach, and the packed keys are not made for it.
MOST_UAVS = 8

_OPAQUE = (
    "Trajectories are opaque: what is computed in them (the QP, positions, time within a round) is left out, and only "
    "their metadata, calculation round and CU, can be compared. Messages arrive in their round or never."
)
_ABSTRACTED = {
    Abstraction.ESSENTIAL: "Swarms that differ only in the names of trajectories are one state, and of a deprecated "
    "tracker only what can still matter is distinguished.",
    Abstraction.COUNTED: "Swarms that differ only in the names of trajectories are one state, and of three or more "
    "interchangeable trajectories in trackers two are kept.",
    Abstraction.NOTHING: "Swarms that differ only in the names of trajectories are one state; nothing else is merged.",
}


@dataclass(frozen=True)
class PackedRounds:
    """What makes the packed rounds of a swarm, which distinguish as much as `abstraction` says."""

    abstraction: Abstraction

    def __call__(self, sizes: Mapping[str, int], semantics: Semantics) -> Rounds:
        """Return the packed rounds."""
        return Rounds(sizes["uavs"], sizes["cus"], semantics, self.abstraction)


SYSTEM = System(
    name="mlr-dmpc",
    paper=PAPER,
    sizes=(
        Size("uavs", "UAVs", "N", usual=2, most=MOST_UAVS, longest=64),
        Size("cus", "CUs", "M", usual=2, most=MOST_CUS, longest=16),
    ),
    reading=Semantics,
    claims=CLAIMS,
    witnesses=(*WITNESSES, RECOVERY_LEFT),
    model=SwarmModel,
    recorded=RecordedRound,
    abstracted=f"{_OPAQUE} {_ABSTRACTED[Abstraction.ESSENTIAL]}",
    in_short="Every loss of (message, receiver) pairs is taken; trajectories are identities; of a deprecated tracker "
    "only what can still matter is distinguished, which is exact.",
    steps=PackedRounds(Abstraction.ESSENTIAL),
    elsewhere=elsewhere,
)


def swarm(uavs: int, cus: int, semantics: Semantics, abstraction: Abstraction = Abstraction.ESSENTIAL) -> Scope:
    """Return the scope of N UAVs and M CUs; another abstraction than the usual one is for checks of ours."""
    system = SYSTEM
    if abstraction is not Abstraction.ESSENTIAL:
        system = replace(SYSTEM, abstracted=f"{_OPAQUE} {_ABSTRACTED[abstraction]}", steps=PackedRounds(abstraction))
    return Scope(system, {"uavs": uavs, "cus": cus}, semantics)
