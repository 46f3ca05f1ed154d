"""What the planner does where the paper is silent (docs/flying.md): each choice can be changed to see if it matters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from fractions import Fraction
from math import isfinite

from swarmproof.errors import BadInput
from swarmproof.theorem3.numbers import exact_text, shown

#: Of a flight, and of anything in it.
MOST_ROUNDS = 100_000


@dataclass(frozen=True, slots=True)
class Choices:
    """What the planner does where the paper is silent; the defaults are what is flown unless a scenario asks.

    Attributes:
        priority_scale: how distances, and their products with ages, become 8 bits (Appendix A): on a logarithmic scale
            or a linear one. Ages alone (RR) always count rounds.
        retry: rounds for which a deadlocked UAV has priority one (Appendix A.4); 0: for as long as it is deadlocked.
        detours: whether there is the high-level planner of Appendix B.1.
        detour_step: m; how far an intermediate target leads away from the other UAV. A UAV at most half of it beside
            another one's way is in the way.
        detour_noise: m; the standard deviation, per axis, of an intermediate target.
        detour_rounds: rounds after which a detour ends at the latest.
        offer: the slot whose trajectory a UAV follows that is offered several new ones in a round (eq. 10).

    Raises:
        BadInput: a choice that there is not.
    """

    priority_scale: str = "logarithmic"
    retry: int = 20
    detours: str = "on"
    detour_step: float = 0.6
    detour_noise: float = 0.3
    detour_rounds: int = 15
    offer: str = "lowest"

    def __post_init__(self) -> None:
        """Raise :class:`BadInput` on a choice that there is not."""
        for name, words in WORDS.items():
            if getattr(self, name) not in words:
                raise BadInput(f"{name} must be {' or '.join(words)}, not {shown(getattr(self, name))}")
        for name, least in LEAST_ROUNDS.items():
            if not least <= getattr(self, name) <= MOST_ROUNDS:
                raise BadInput(f"{name} must be from {least} to {MOST_ROUNDS} rounds, not {getattr(self, name)}")
        for name in LENGTHS:
            value = getattr(self, name)
            if not isfinite(value) or value < 0:
                raise BadInput(f"{name} must be 0 or a positive number of metres, not {value}")

    def differences(self) -> list[str]:
        """Return ``NAME=VALUE`` for each choice that is not the usual one."""
        return changed(CHOICES, self, USUAL)


#: By choice, its words; the first is the usual one.
WORDS: dict[str, tuple[str, str]] = {
    "priority_scale": ("logarithmic", "linear"),
    "detours": ("on", "off"),
    "offer": ("lowest", "highest"),
}
#: By choice that is a number of rounds, the least that it can be.
LEAST_ROUNDS: dict[str, int] = {"retry": 0, "detour_rounds": 1}
#: The choices that are lengths in m.
LENGTHS: tuple[str, ...] = ("detour_step", "detour_noise")
#: The names of all choices.
CHOICES: tuple[str, ...] = tuple(one.name for one in fields(Choices))
USUAL = Choices()


def changed(names: Iterable[str], values: object, base: object) -> list[str]:
    """Return ``NAME=VALUE`` for each of the attributes `names`, numbers or words, in which `values` is not `base`."""
    return [f"{name}={_text(getattr(values, name))}" for name in names if getattr(values, name) != getattr(base, name)]


def _text(value: Fraction | float | str) -> str:
    """Return a word as it is, and a number as it would be written: 5.0 is 5."""
    if isinstance(value, str):
        return value
    return exact_text(value if isinstance(value, Fraction) else Fraction(repr(value)))
