"""The switches: where the paper's pseudo-code, its prose and common sense differ, or the paper is silent.

Every verdict is a verdict *under one reading of the paper*; a :class:`Semantics` is that reading.
`docs/semantics.md` says which line of the paper each switch is about and what was found under each value.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields

from swarmproof.errors import BadInput

#: Every switch with its values; the first value is the default.
SWITCHES: dict[str, tuple[str, ...]] = {
    "deprecation": ("all", "one"),
    "rejoin": ("any-state", "after-reply"),
    "slot_conflict": ("either", "both-lost", "cu-wins"),
    "request_order": ("lowest-index", "round-robin", "any"),
    "event_trigger": ("any", "round-robin"),
    "initial": ("unknown", "known"),
    "loss_handling": ("recover", "ignore"),
}

#: Named combinations; what a preset does not name keeps its default.
PRESETS: dict[str, dict[str, str]] = {
    "printed": {},
    "prose": {"deprecation": "one"},
    "guarded": {"deprecation": "one", "rejoin": "after-reply"},
    "ignore-loss": {"loss_handling": "ignore", "initial": "known"},
}

#: What each switch is about, and the place in the paper (DMPC-Swarm) that leaves it open.
ABOUT: dict[str, str] = {
    "deprecation": "which trackers become deprecated when some tracker holds several trajectories "
    "(Algorithm 2, lines 12-14, against the prose of Section 4.2.1)",
    "rejoin": "whether a CU that donated its slot may re-enter RUN_DMPC in that very round (Algorithm 1, line 9)",
    "slot_conflict": "what is heard when a CU and a replying UAV transmit in one slot (not in the paper)",
    "request_order": "which of several deprecated trackers is asked for first (Algorithm 1, line 26)",
    "event_trigger": "which UAV a CU plans: any, or Appendix A.1's round-robin with the consensus of eq. 11",
    "initial": "what the CUs know in the first computation phase (Algorithm 1, lines 1-5, against Remark 2)",
    "loss_handling": "MLR-DMPC, or the older DMPC that ignores message loss",
}


@dataclass(frozen=True, slots=True)
class Semantics:
    """One reading of the paper: a value for every switch of :data:`SWITCHES`."""

    deprecation: str = "all"
    rejoin: str = "any-state"
    slot_conflict: str = "either"
    request_order: str = "lowest-index"
    event_trigger: str = "any"
    initial: str = "unknown"
    loss_handling: str = "recover"

    def __post_init__(self) -> None:
        """Raise :class:`BadInput` on a value that a switch does not have, or on values that exclude each other."""
        for name, values in SWITCHES.items():
            value = getattr(self, name)
            if value not in values:
                raise BadInput(f"switch {name} has no value {value!r}: it takes {_one_of(values)}")
        if self.loss_handling == "ignore" and self.initial != "known":
            raise BadInput(
                "loss_handling=ignore needs initial=known: without recovery, a CU that knows nothing learns nothing; "
                "give both, such as --semantics ignore-loss"
            )

    @classmethod
    def parse(cls, preset: str = "printed", overrides: Iterable[str] = ()) -> Semantics:
        """Return preset `preset` with each ``SWITCH=VALUE`` of `overrides` applied.

        Raises:
            BadInput: an unknown preset, switch or value, or values that exclude each other.
        """
        if preset not in PRESETS:
            raise BadInput(f"there are no semantics {preset!r}: choose {_one_of(PRESETS)}")
        chosen = dict(PRESETS[preset])
        for override in overrides:
            name, equals, value = override.partition("=")
            if not equals:
                raise BadInput(f"--set {override!r} is not of the form SWITCH=VALUE, such as rejoin=after-reply")
            if name not in SWITCHES:
                raise BadInput(f"there is no switch {name!r}: choose {_one_of(SWITCHES)}")
            chosen[name] = value
        return cls(**chosen)

    @classmethod
    def from_values(cls, values: dict[str, str]) -> Semantics:
        """Return the semantics with exactly these switch values; a missing one has its default.

        Raises:
            BadInput: an unknown switch or value.
        """
        return cls(**_known(values))

    def as_dict(self) -> dict[str, str]:
        """Return ``{switch: value}`` for every switch."""
        return asdict(self)

    def name(self) -> str:
        """Return the nearest preset and what differs from it, such as ``guarded, initial=known``."""
        mine = self.as_dict()
        defaults = {field.name: str(field.default) for field in fields(self)}

        def differences(preset: str) -> list[str]:
            base = defaults | PRESETS[preset]
            return [f"{name}={value}" for name, value in mine.items() if base[name] != value]

        best = min(PRESETS, key=lambda preset: len(differences(preset)))
        return ", ".join([best, *differences(best)])


def _known(values: dict[str, str]) -> dict[str, str]:
    for name in values:
        if name not in SWITCHES:
            raise BadInput(f"there is no switch {name!r}: choose {_one_of(SWITCHES)}")
    return values


def _one_of(names: Iterable[str]) -> str:
    *most, last = names
    return f"{', '.join(most)} or {last}" if most else last
