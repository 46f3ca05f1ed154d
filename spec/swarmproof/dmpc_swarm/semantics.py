"""The switches: where the paper's pseudo-code, its prose and common sense differ, or the paper is silent.

`docs/semantics.md` says which line of the paper each switch is about and what was found under each value.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from swarmproof.claims.reading import Reading, switch

PAPER = "DMPC-Swarm (Gräfe, Eickhoff, Zimmerling, Trimpe)"


@dataclass(frozen=True, slots=True)
class Semantics(Reading):
    """One reading of DMPC-Swarm; :class:`~swarmproof.claims.reading.Reading` says what it can do."""

    PRESETS: ClassVar[Mapping[str, Mapping[str, str]]] = {
        "printed": {},
        "prose": {"deprecation": "one"},
        "guarded": {"deprecation": "one", "rejoin": "after-reply"},
        "ignore-loss": {"loss_handling": "ignore", "initial": "known"},
    }

    EXAMPLE: ClassVar[str] = "rejoin=after-reply"

    deprecation: str = switch(
        "all",
        "one",
        about="which trackers become deprecated when some tracker holds several trajectories "
        "(Algorithm 2, lines 12-14, against the prose of Section 4.2.1)",
    )
    rejoin: str = switch(
        "any-state",
        "after-reply",
        about="whether a CU that donated its slot may re-enter RUN_DMPC in that very round (Algorithm 1, line 9)",
    )
    slot_conflict: str = switch(
        "either",
        "both-lost",
        "cu-wins",
        about="what is heard when a CU and a replying UAV transmit in one slot (not in the paper)",
    )
    request_order: str = switch(
        "lowest-index",
        "round-robin",
        "any",
        about="which of several deprecated trackers is asked for first (Algorithm 1, line 26)",
    )
    event_trigger: str = switch(
        "any",
        "round-robin",
        about="which UAV a CU plans: any, or Appendix A.1's round-robin with the consensus of eq. 11",
    )
    initial: str = switch(
        "unknown",
        "known",
        about="what the CUs know in the first computation phase (Algorithm 1, lines 1-5, against Remark 2)",
    )
    loss_handling: str = switch("recover", "ignore", about="MLR-DMPC, or the older DMPC that ignores message loss")

    def excluded(self) -> str:
        """Return why these values exclude each other; empty if they do not."""
        if self.loss_handling == "ignore" and self.initial != "known":
            return (
                "loss_handling=ignore needs initial=known: without recovery, a CU that knows nothing learns nothing; "
                "give both, such as --semantics ignore-loss"
            )
        return ""


#: Every switch with its values, named combinations, and what each switch is about.
SWITCHES = Semantics.switches()
PRESETS = Semantics.PRESETS
ABOUT = Semantics.about()
