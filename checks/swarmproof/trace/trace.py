"""Traces: runs of any system, written down and read back. One schema; its rounds are the system's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec

from swarmproof.errors import BadInput
from swarmproof.files.reading import read_bytes
from swarmproof.system import Scope, System
from swarmproof.systems import PACKAGES, load

SCHEMA = "swarmproof.trace/1"
#: How long a trace may be, which is far longer than any that is written.
MOST_BYTES = 1 << 26

_Index = Annotated[int, msgspec.Meta(ge=0)]


class _Head(msgspec.Struct):
    """What says how the rest is read."""

    schema: str
    system: str


@dataclass(frozen=True)
class Trace:
    """A run from the first computation phase, and what it shows.

    Attributes:
        sizes: by name, how large the system is.
        semantics: by switch, its value.
        shows: the id of the claim that is false at its end (of a Reachable: true), or of a witness.
        loop_start: of a run that goes round for ever: the round in which its loop starts.
        rounds: as the system's model writes them.
    """

    system: str
    sizes: Mapping[str, int]
    semantics: Mapping[str, str]
    shows: str
    loop_start: int | None
    rounds: Sequence[Any]


def record(scope: Scope, shows: str, events: Sequence[Any], loop_start: int | None = None) -> Trace:
    """Write down a run from the first computation phase."""
    model = scope.model()
    rounds = [model.write(event) for event in events]
    return Trace(scope.system.name, dict(scope.sizes), scope.reading.as_dict(), shows, loop_start, rounds)


def as_builtins(trace: Trace) -> dict[str, Any]:
    """Return a trace as plain values, in the order in which they are written."""
    return {
        "schema": SCHEMA,
        "system": trace.system,
        **trace.sizes,
        "semantics": dict(trace.semantics),
        "shows": trace.shows,
        "loop_start": trace.loop_start,
        "rounds": msgspec.to_builtins(trace.rounds),
    }


def encode(trace: Trace) -> bytes:
    """Return a trace as JSON, one line per round."""
    head = as_builtins(trace)
    rounds = head.pop("rounds")
    lines = [f"  {_json(name)}: {_json(value)}," for name, value in head.items()]
    body = ",\n".join(f"    {_json(one)}" for one in rounds)
    return ("{\n" + "\n".join(lines) + '\n  "rounds": [\n' + body + "\n  ]\n}\n").encode()


def _json(value: object) -> str:
    return msgspec.json.encode(value).decode()


def read(path: Path) -> Trace:
    """Return the trace in a file.

    Raises:
        BadInput: there is no such file, or it is not a trace.
    """
    return decode(read_bytes(path, "trace", MOST_BYTES, "give a trace that `verify --report` wrote"), str(path))


def decode(data: bytes, source: str) -> Trace:
    """Return the trace in `data`, which is from `source`.

    Raises:
        BadInput: it is not a trace.
    """
    try:
        head = msgspec.json.decode(data, type=_Head)
        if head.schema == SCHEMA and head.system in PACKAGES:
            return _decode(data, load(head.system))
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        reason = "".join(c if c.isprintable() else "?" for c in str(error))  # it may quote what the file says
        raise BadInput(
            f"{source} is no trace of swarmproof ({reason}); give one that `verify --report` wrote, such as "
            "out/lemma-1.trace.json"
        ) from None
    known = " or ".join(PACKAGES)
    raise BadInput(f"{source} is a {head.schema!r} of {head.system!r}; this version reads {SCHEMA} of {known}")


def _decode(data: bytes, system: System) -> Trace:
    """Return the trace of a system; DecodeError if it is none."""
    sizes = [(size.name, Annotated[int, msgspec.Meta(ge=size.least, le=size.longest)]) for size in system.sizes]
    fields: list[Any] = [
        ("schema", str),
        ("system", str),
        *sizes,
        ("semantics", dict[str, str]),
        ("shows", str),
        ("loop_start", _Index | None),
        ("rounds", list[system.recorded]),  # type: ignore[name-defined]
    ]
    form = msgspec.defstruct("Trace", fields, forbid_unknown_fields=True)
    found: Any = msgspec.json.decode(data, type=form)
    return Trace(
        system.name,
        {name: getattr(found, name) for name, _ in sizes},
        found.semantics,
        found.shows,
        found.loop_start,
        found.rounds,
    )
