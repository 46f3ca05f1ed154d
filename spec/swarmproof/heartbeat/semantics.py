"""The open places of the heartbeat protocol."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from swarmproof.claims.reading import Reading, switch


@dataclass(frozen=True, slots=True)
class Semantics(Reading):
    """How the leader is found."""

    PRESETS: ClassVar[Mapping[str, Mapping[str, str]]] = {
        "timeout": {},
        "sticky-lease": {"leads": "majority", "renewal": "any"},
        "lease": {"leads": "majority"},
    }
    EXAMPLE: ClassVar[str] = "leads=majority"

    leads: str = switch(
        "timeout",
        "majority",
        about="who leads: the lowest UAV that did not time out, as each sees it, or who holds the votes of a majority",
    )
    renewal: str = switch(
        "lowest",
        "any",
        about="which vote is renewed: that for the lowest UAV that is heard, or that for any UAV that is heard",
    )
