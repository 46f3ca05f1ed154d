"""The verdicts as JSON, `swarmproof.verdicts/1`: for CI and for other tools."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from swarmproof.explore.decide import Decided, Result

SCHEMA = "swarmproof.verdicts/1"


class ExplorationJson(msgspec.Struct):
    """How the states were explored; `transitions` counts the (intermediate swarm, effect) pairs taken."""

    fixpoint: bool
    states: int
    transitions: int
    depth: int
    seconds: float


class ClaimJson(msgspec.Struct):
    """One claim's verdict; `rounds` and `lost_messages` where a trace exists, `trace` where it was written."""

    id: str
    verdict: str
    rounds: int | None
    lost_messages: int | None
    worst_rounds: int | None
    avoidable: bool | None
    trace: str | None


def as_json(result: Result, traces: Mapping[str, str]) -> bytes:
    """Return `result` as an indented JSON document; `traces` has the path of the trace written for a claim id."""
    scope = result.scope
    document = {
        "schema": SCHEMA,
        "system": scope.system.name,
        **scope.sizes,
        "semantics": scope.reading.as_dict(),
        "exploration": ExplorationJson(
            result.fixpoint, result.states, result.transitions, result.depth, round(result.seconds, 3)
        ),
        "claims": [_claim(decided, traces.get(decided.claim.id)) for decided in result.claims],
    }
    return msgspec.json.format(msgspec.json.encode(document), indent=2) + b"\n"


def _claim(decided: Decided, trace: str | None) -> ClaimJson:
    return ClaimJson(
        decided.claim.id,
        str(decided.verdict),
        decided.rounds,
        decided.lost_messages,
        decided.worst_rounds,
        decided.avoidable,
        trace,
    )
