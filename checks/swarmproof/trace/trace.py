"""Traces: runs of the model that are written down, read back and replayed, step by step, on the readable model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import msgspec

from swarmproof.dmpc_swarm.claims.predicates import Broken
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, Claim, Kind
from swarmproof.dmpc_swarm.claims.witnesses import RECOVERY_LEFT, WITNESSES
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.protocol.messages import Metadata, Trajectory
from swarmproof.dmpc_swarm.protocol.network import Air, Reception, receive_at_cu, receive_at_uav
from swarmproof.dmpc_swarm.protocol.swarm import Events, Swarm, compute, forbidden, initial_swarm, step
from swarmproof.dmpc_swarm.protocol.uav import offers
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.symmetry import Abstraction, canonical_swarm
from swarmproof.errors import BadInput
from swarmproof.files.reading import read_bytes

SCHEMA = "swarmproof.trace/1"
#: How long a trace may be, which is far longer than any that is written.
MOST_BYTES = 1 << 26
SYSTEM = "mlr-dmpc"

_Index = Annotated[int, msgspec.Meta(ge=0)]


class RecordedReception(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """The messages lost on the way to one receiver, and the slots of which it decoded the reply in a conflict."""

    lost_uavs: list[_Index] = []
    lost_slots: list[_Index] = []
    decoded_replies: list[_Index] = []


class RecordedRound(msgspec.Struct, forbid_unknown_fields=True):
    """One round: by CU whom it plans or asks, by receiver what it misses, by UAV whose new trajectory it adopts."""

    decided: list[_Index | None]
    at_cus: list[RecordedReception]
    at_uavs: list[RecordedReception]
    adopted: list[_Index | None]


class Trace(msgspec.Struct, forbid_unknown_fields=True):
    """A run from the first computation phase, and what it shows.

    Attributes:
        shows: the id of the claim that is false at its end (a claim of kind REACHABLE: true), or of a witness.
        loop_start: of a run that goes round for ever: the round in which its loop starts.
    """

    schema: str
    system: str
    uavs: Annotated[int, msgspec.Meta(ge=1, le=64)]
    cus: Annotated[int, msgspec.Meta(ge=1, le=16)]
    semantics: dict[str, str]
    shows: str
    loop_start: _Index | None
    rounds: list[RecordedRound]


@dataclass(frozen=True)
class Replay:
    """A trace replayed: `swarms[k]` is the swarm in the computation phase of round k, `events[k]` what happens then."""

    trace: Trace
    semantics: Semantics
    swarms: tuple[Swarm, ...]
    airs: tuple[Air, ...]
    events: tuple[Events, ...]

    @property
    def lost_messages(self) -> int:
        """The number of (message, receiver) pairs lost."""
        return sum(events.lost for events in self.events)

    @property
    def claim(self) -> Claim | None:
        """The claim that the trace is about; None if it is about a witness."""
        return next((claim for claim in CLAIMS if claim.id == self.trace.shows), None)

    def broken_at(self, k: int) -> list[Broken]:
        """Return where the trace's claim is false in the computation phase of round k (safety claims only)."""
        return [] if self.claim is None else self.claim.broken_in(observe(self.swarms[k]))

    @property
    def is_violation(self) -> bool:
        """Whether the trace shows that a claim is false."""
        return self.claim is not None and self.claim.kind is not Kind.REACHABLE


def record(
    uavs: int,
    cus: int,
    semantics: Semantics,
    shows: str,
    events: Sequence[Events],
    loop_start: int | None = None,
) -> Trace:
    """Write down a run from the first computation phase."""
    return Trace(
        SCHEMA,
        SYSTEM,
        uavs,
        cus,
        semantics.as_dict(),
        shows,
        loop_start,
        [
            RecordedRound(
                list(happened.decided),
                [
                    RecordedReception(list(r.lost_uavs), list(r.lost_slots), list(r.decoded_replies))
                    for r in happened.at_cus
                ],
                [RecordedReception([], list(r.lost_slots), list(r.decoded_replies)) for r in happened.at_uavs],
                [None if new is None else new.metadata.cu for new in happened.adopted],
            )
            for happened in events
        ],
    )


def encode(trace: Trace) -> bytes:
    """Return a trace as JSON, one line per round."""
    head = msgspec.to_builtins(trace)
    rounds = head.pop("rounds")
    lines = [f"  {_json(name)}: {_json(value)}," for name, value in head.items()]
    body = ",\n".join(f"    {_json(one)}" for one in rounds)
    return ("{\n" + "\n".join(lines) + '\n  "rounds": [\n' + body + "\n  ]\n}\n").encode()


def _json(value: object) -> str:
    return msgspec.json.encode(value).decode()


def load(path: Path) -> Trace:
    """Read a trace.

    Raises:
        BadInput: there is no such file, or it is not a trace.
    """
    data = read_bytes(path, "trace", MOST_BYTES, "give a trace that `verify --report` wrote")
    try:
        trace = msgspec.json.decode(data, type=Trace)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        reason = "".join(c if c.isprintable() else "?" for c in str(error))  # it may quote what the file says
        raise BadInput(
            f"{path} is no trace of swarmproof ({reason}); give one that `verify --report` wrote, such as "
            "out/lemma-1.trace.json"
        ) from None
    if trace.schema != SCHEMA or trace.system != SYSTEM:
        raise BadInput(f"{path} is a {trace.schema!r} of {trace.system!r}; this version reads {SCHEMA} of {SYSTEM}")
    return trace


def replay(trace: Trace) -> Replay:
    """Run a trace on the readable model, and check that it shows what it says.

    Raises:
        BadInput: a round of the trace cannot happen, or the trace does not show what it says.
    """
    semantics = Semantics.from_values(trace.semantics)
    swarm = initial_swarm(trace.uavs, trace.cus, semantics)
    swarms, airs, happened = [swarm], [], []
    for k, recorded in enumerate(trace.rounds):
        events, air = _events(swarm, recorded, k, semantics)
        swarm = step(swarm, events, semantics)
        swarms.append(swarm)
        airs.append(air)
        happened.append(events)
    replayed = Replay(trace, semantics, tuple(swarms), tuple(airs), tuple(happened))
    _check_shows(replayed)
    return replayed


def _events(swarm: Swarm, recorded: RecordedRound, k: int, semantics: Semantics) -> tuple[Events, Air]:
    uavs, cus = len(swarm.uavs), len(swarm.cus)
    sizes = [len(recorded.decided), len(recorded.at_cus), len(recorded.at_uavs), len(recorded.adopted)]
    if sizes != [cus, cus, uavs, uavs]:
        raise BadInput(f"round {k} of the trace is not about {uavs} UAVs and {cus} CUs")
    decided = tuple(recorded.decided)
    reason = forbidden(swarm, decided, semantics)
    if reason is not None:
        raise BadInput(f"round {k} of the trace cannot happen: {reason}")
    _, air = compute(swarm, decided, semantics)
    at_cus = tuple(
        receive_at_cu(w, air, r.lost_uavs, r.lost_slots, r.decoded_replies, semantics)
        for w, r in enumerate(recorded.at_cus)
    )
    at_uavs = tuple(
        receive_at_uav(i, air, r.lost_slots, r.decoded_replies, semantics) for i, r in enumerate(recorded.at_uavs)
    )
    for w, got in enumerate(at_cus):
        _check_received(k, f"CU {w}", recorded.at_cus[w], got)
    for i, got in enumerate(at_uavs):
        _check_received(k, f"UAV {i}", recorded.at_uavs[i], got)
    adopted = []
    for uav, got, cu in zip(swarm.uavs, at_uavs, recorded.adopted, strict=True):
        new = None if cu is None else Trajectory(Metadata(k, cu))
        offered = offers(uav, got.inbox)
        if new not in (offered or (None,)):
            raise BadInput(f"round {k} of the trace lets UAV {uav.i} adopt {_name(new)}; it receives {_names(offered)}")
        adopted.append(new)
    return Events(decided, at_cus, at_uavs, tuple(adopted)), air


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


def _check_shows(replayed: Replay) -> None:
    """Raise BadInput unless the run shows what its trace says."""
    trace, claim = replayed.trace, replayed.claim
    if claim is not None and not claim.applies_to(replayed.semantics):
        raise BadInput(f"the trace is about {claim.id}, which cannot be asked under {replayed.semantics.name()}")
    if trace.loop_start is not None:
        if claim is None or claim.kind is not Kind.RECOVERY:
            raise BadInput(f"the trace has a loop, but {trace.shows!r} is no claim about loops")
        _check_loop(replayed, trace.loop_start)
    elif claim is None:
        _check_witness(replayed)
    elif claim.kind is Kind.SAFETY and not replayed.broken_at(len(trace.rounds)):
        raise BadInput(f"the trace does not show that {claim.id} is violated: at its end the claim is true")
    elif claim.kind is Kind.REACHABLE:
        assert claim.goal is not None
        if not claim.goal(observe(replayed.swarms[-1])):
            raise BadInput(f"the trace does not show {claim.id}: at its end the goal is not reached")
    elif claim.kind is Kind.RECOVERY:
        raise BadInput(f"the trace does not show that {claim.id} is violated: it has no loop_start")


def _check_loop(replayed: Replay, start: int) -> None:
    assert replayed.claim is not None
    assert replayed.claim.goal is not None
    end = len(replayed.events)
    if start >= end:
        raise BadInput(f"the trace's loop starts in round {start}, but the trace ends after {end} rounds")
    if any(events.lost for events in replayed.events[start:]):
        raise BadInput("the trace's loop loses messages: recovery is claimed only for loss-free rounds")
    if all(replayed.claim.goal(observe(swarm)) for swarm in replayed.swarms[start:]):
        raise BadInput("all CUs run throughout the trace's loop: it shows no failure to recover")
    first, last = (canonical_swarm(replayed.swarms[k], replayed.semantics, Abstraction.ESSENTIAL) for k in (start, end))
    if first != last:
        raise BadInput("the trace's loop does not close: its last swarm behaves unlike its first")


def _check_witness(replayed: Replay) -> None:
    shows = replayed.trace.shows
    observed = [observe(swarm) for swarm in replayed.swarms]
    if shows == RECOVERY_LEFT:
        waited: set[int] = set()
        for swarm in observed:
            waited |= {w for w, cu in enumerate(swarm.cus) if cu.state == "WAIT"}
        seen = any(observed[-1].cus[w].state == "RUN_DMPC" for w in waited)
    else:
        witness = next((w for w in WITNESSES if w.id == shows), None)
        if witness is None:
            known = ", ".join([c.id for c in CLAIMS] + [w.id for w in WITNESSES] + [RECOVERY_LEFT])
            raise BadInput(f"the trace is about {shows!r}; there is {known}")
        seen = witness.seen_in(observed[-1])
    if not seen:
        raise BadInput(f"the trace does not show {shows}")
