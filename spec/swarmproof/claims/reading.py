"""A reading of a paper: a value for every place that its text leaves open.

Every verdict is a verdict *under one reading*. A system declares its open places once, as the fields of a frozen
dataclass that derives from :class:`Reading`, each made by :func:`switch`; everything else follows from that.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, field, fields
from typing import Any, ClassVar, Self

from swarmproof.errors import BadInput


def switch(*values: str, about: str) -> Any:
    """Return the field of a switch: the values that it takes, the default first, and what it is about."""
    return field(default=values[0], metadata={"values": values, "about": about})


class Reading:
    """One reading of a paper; a base for frozen dataclasses with a :func:`switch` for every open place.

    Raises:
        BadInput: a value that a switch does not have, or values that exclude each other.
    """

    __slots__ = ()

    #: Named combinations, the usual one first; what a preset does not name keeps its default.
    PRESETS: ClassVar[Mapping[str, Mapping[str, str]]]
    #: A change of one switch that is right, for sentences that say what would be.
    EXAMPLE: ClassVar[str]

    def __post_init__(self) -> None:
        """Refuse values that cannot be."""
        for name, values in self.switches().items():
            value = getattr(self, name)
            if value not in values:
                raise BadInput(f"switch {name} has no value {value!r}: it takes {one_of(values)}")
        if excluded := self.excluded():
            raise BadInput(excluded)

    def excluded(self) -> str:
        """Return why these values exclude each other; empty if they do not."""
        return ""

    @classmethod
    def switches(cls) -> dict[str, tuple[str, ...]]:
        """Return every switch with its values; the first value is the default."""
        return {one.name: one.metadata["values"] for one in fields(cls)}  # type: ignore[arg-type]

    @classmethod
    def about(cls) -> dict[str, str]:
        """Return what each switch is about, and the place in the paper that leaves it open."""
        return {one.name: one.metadata["about"] for one in fields(cls)}  # type: ignore[arg-type]

    @classmethod
    def parse(cls, preset: str | None = None, overrides: Iterable[str] = ()) -> Self:
        """Return preset `preset` (None: the usual one) with each ``SWITCH=VALUE`` of `overrides` applied.

        Raises:
            BadInput: an unknown preset, switch or value, or values that exclude each other.
        """
        preset = next(iter(cls.PRESETS)) if preset is None else preset
        if preset not in cls.PRESETS:
            raise BadInput(f"there are no semantics {preset!r}: choose {one_of(cls.PRESETS)}")
        chosen = dict(cls.PRESETS[preset])
        for override in overrides:
            name, equals, value = override.partition("=")
            if not equals:
                raise BadInput(f"--set {override!r} is not of the form SWITCH=VALUE, such as {cls.EXAMPLE}")
            chosen[cls._known(name)] = value
        return cls(**chosen)

    @classmethod
    def from_values(cls, values: Mapping[str, str]) -> Self:
        """Return the reading with exactly these switch values; a missing one has its default.

        Raises:
            BadInput: an unknown switch or value.
        """
        return cls(**{cls._known(name): value for name, value in values.items()})

    @classmethod
    def _known(cls, name: str) -> str:
        if name not in cls.switches():
            raise BadInput(f"there is no switch {name!r}: choose {one_of(cls.switches())}")
        return name

    def as_dict(self) -> dict[str, str]:
        """Return ``{switch: value}`` for every switch."""
        return asdict(self)  # type: ignore[call-overload, no-any-return]

    def name(self) -> str:
        """Return the nearest preset and what differs from it, such as ``guarded, initial=known``."""
        mine = self.as_dict()
        defaults = {name: values[0] for name, values in self.switches().items()}

        def differences(preset: str) -> list[str]:
            base = {**defaults, **self.PRESETS[preset]}
            return [f"{name}={value}" for name, value in mine.items() if base[name] != value]

        best = min(self.PRESETS, key=lambda preset: len(differences(preset)))
        return ", ".join([best, *differences(best)])


def one_of(names: Iterable[str]) -> str:
    """Return ``a, b or c``."""
    *most, last = names
    return f"{', '.join(most)} or {last}" if most else last
