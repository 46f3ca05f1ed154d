"""The parameters of Theorem 3 (DMPC-Swarm, eqs. 24-26), exactly as they were written: 0.1 is 1/10.

SI units throughout. Values come from Python, from a TOML file, from ``NAME=VALUE`` texts (``--set``) or from a
certificate; whatever the way, a value that makes no sense is a :class:`BadInput` of one sentence.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from enum import StrEnum
from fractions import Fraction
from typing import Any

from swarmproof.errors import BadInput
from swarmproof.theorem3.numbers import (
    MOST_TEXT,
    exact_text,
    near_match,
    read_toml,
    shown,
)
from swarmproof.theorem3.values import (
    NORMS,
    Box,
    Matrix,
    Vector,
    axes,
    check_value,
    compact,
    diagonal,
    nested,
    read_value,
)

#: How many collision windows, and how many state-bound samples, one period T_s may have.
MOST_WINDOWS = 1000
#: The parameters whose extreme safe value can be searched for (checks: margin.solve).
EXTREMES = ("T_c", "v_max", "v_norm", "d_hat_min")


class Reading(StrEnum):
    """What the set X and the inputs U of eq. (24) restrict: the paper leaves three possibilities."""

    #: X binds the states at time 0 only, as printed; the input is any measurable function with values in U.
    INITIAL_STATE = "initial-state"
    #: X binds at all times in [0, T_c]; inputs as above.
    WHOLE_MOTION = "whole-motion"
    #: What the algorithm enforces: one input per period T_s, X at multiples of T_b, any window of length T_c.
    AS_SAMPLED = "as-sampled"

    @classmethod
    def parse(cls, text: str) -> Reading:
        """Return the reading called `text`; raise :class:`BadInput` if there is none."""
        if text not in list(cls):
            raise BadInput(f"there is no reading {shown(text)}: choose {', '.join(list(cls)[:-1])} or {list(cls)[-1]}")
        return cls(text)


#: Θ⁻¹ of the published experiments: a UAV's downwash makes it six times as high as wide.
PUBLISHED_SCALING = diagonal((Fraction(1), Fraction(1), Fraction(1, 6)))


@dataclass(frozen=True, slots=True)
class Parameters:
    """Everything that Theorem 3 depends on; the defaults are the published ones (Section 5), in SI units.

    Raises:
        BadInput: a value that no reading of Theorem 3 has a meaning for.
    """

    #: s; spacing of the collision samples, the end of the interval in eq. (24).
    T_c: Fraction = Fraction(1, 10)
    #: s; period of one constant input (Section 5: the round time T).
    T_s: Fraction = Fraction(1, 5)
    #: s; spacing of the samples at which the state is bounded (T_s where nothing else is given).
    T_b: Fraction = Fraction(1, 5)
    #: m; the scaled distance kept at the collision samples, eqs. (15) and (24).
    d_hat_min: Fraction = Fraction(1, 4)
    #: m/s, per axis; the set X of eq. (24).
    v_max: Vector = (Fraction(2), Fraction(2), Fraction(2))
    #: m/s², per axis; the set X of eq. (24), or U if `order` is 2.
    a_max: Vector = (Fraction(5), Fraction(5), Fraction(5))
    #: m/s³, per axis; the set U of eq. (24), without meaning if `order` is 2.
    j_max: Vector = (Fraction(5), Fraction(5), Fraction(5))
    #: the inverse of the scaling matrix for downwash, eq. (2); symmetric positive definite.
    theta_inverse: Matrix = PUBLISHED_SCALING
    #: how often the nominal system of eq. (4) integrates its input: 3 (input jerk) or 2 (input acceleration).
    order: int = 3
    #: m; (low, high) per axis for the positions in X, a side None for no limit there; None for no restriction at all.
    workspace: Box | None = None
    #: m; the scaled distance that the real UAVs are to keep, eq. (2).
    d_min: Fraction = Fraction(3, 25)
    #: m; the bound on each UAV's distance from its reference, in no scaled norm: Δd_min of Assumption 1, eq. (6).
    tracking_error: Fraction = Fraction(0)
    #: m/s, m/s², m/s³; bounds of the Euclidean norm, beside the box per axis; None for no such bound.
    v_norm: Fraction | None = None
    a_norm: Fraction | None = None
    j_norm: Fraction | None = None
    #: the scaling of the ellipsoid that counts as a crash, for `d_min`; None where it is `theta_inverse`.
    crash_theta_inverse: Matrix | None = None
    #: s; how old what a planner knows of the other UAVs may be, beyond what the algorithm takes into account.
    delay: Fraction = Fraction(0)
    #: the names that were given, or follow from what was given; the others are the published ones, by default.
    given: frozenset[str] = field(default=frozenset(), compare=False, repr=False)

    def __post_init__(self) -> None:
        """Raise :class:`BadInput` on a value outside of what its parameter can be."""
        for name in NAMES:
            check_value(name, getattr(self, name))

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str], changes: Iterable[str] = ()) -> Parameters:
        """Return the parameters in the TOML file `path`, then each ``NAME=VALUE`` of `changes`; others are published.

        T_b is T_s unless the file or a change gives it.

        Raises:
            BadInput: the file cannot be read or is no TOML, or a name or value that cannot be.
        """
        return cls.from_table(os.fspath(path), read_toml(path, "parameter file", "T_c = 0.1"), changes)

    @classmethod
    def from_table(cls, place: str, table: Mapping[str, object], changes: Iterable[str] = ()) -> Parameters:
        """Return the same of a `table` that :func:`read_toml` has read.

        Raises:
            BadInput: a name or value that cannot be; `place` says where the table is.
        """
        return cls()._changed([*((place, name, raw) for name, raw in table.items()), *_set_entries(changes)])

    def with_table(self, place: str, table: Mapping[str, object]) -> Parameters:
        """Return these parameters with the values in `table` applied, as :meth:`with_changes` does.

        Raises:
            BadInput: a name or value that cannot be; `place` says where the table is.
        """
        return self._changed((place, name, raw) for name, raw in table.items())

    def with_changes(self, changes: Iterable[str]) -> Parameters:
        """Return these parameters with each ``NAME=VALUE`` of `changes` applied.

        A T_b that equals T_s follows a changed T_s, unless it is changed itself.

        Raises:
            BadInput: a name or value that cannot be.
        """
        return self._changed(_set_entries(changes))

    @classmethod
    def from_exact(cls, values: Mapping[str, object]) -> Parameters:
        """Return the parameters that :meth:`as_exact` gives as `values`.

        Raises:
            BadInput: a name is missing or unknown, or a value cannot be.
        """
        needed = [name for name in NAMES if name not in EXTENSIONS]
        missing = [name for name in needed if name not in values]
        if missing:
            raise BadInput(f"the parameters lack {', '.join(missing)}: all of {', '.join(needed)} must be there")
        return cls()._changed([("the parameters", str(name), value) for name, value in values.items()])

    def _changed(self, entries: Iterable[tuple[str, str, object]]) -> Parameters:
        """Return these parameters with every (place, name, raw value) of `entries` read and applied."""
        changed: dict[str, Any] = {}
        for place, name, raw in entries:
            try:
                if isinstance(raw, Mapping):
                    raise BadInput(f"{shown(name)} is a table, which is not a value: write lines such as T_c = 0.1")
                if name not in NAMES:
                    raise BadInput(f"there is no parameter {shown(name)}: {near_match(name, NAMES)}")
                value = read_value(name, raw, _example(name))
                check_value(name, value)
            except BadInput as mistake:
                raise BadInput(f"{place}: {mistake}") from None
            changed[name] = value
        if "T_s" in changed and self.T_b == self.T_s:
            changed.setdefault("T_b", changed["T_s"])
        return replace(self, **{**self._followed(changed), **changed}, given=self.given.union(changed))

    def _followed(self, norms: Mapping[str, Any]) -> dict[str, Vector]:
        """Return the boxes that follow the `norms` where these are changed: those that nobody gave.

        Who bounds the norm only means no other box than the one around that ball, however often it is changed.
        """
        boxes = {}
        for norm, box in NORMS.items():
            before = getattr(self, norm)
            own = getattr(PUBLISHED, box) if before is None else axes(before)
            if norm in norms and box not in self.given and getattr(self, box) == own:
                boxes[box] = getattr(PUBLISHED, box) if norms[norm] is None else axes(norms[norm])
        return boxes

    def defaults(self) -> list[str]:
        """Return the names of the published values that stand where none was given and that have a meaning here.

        Nobody gives what the paper does not have (:data:`EXTENSIONS`) by leaving it out.
        """
        followed = [box for norm, box in NORMS.items() if getattr(self, norm) is not None]
        without_meaning = (*EXTENSIONS, *followed, *(("j_max",) if self.order == 2 else ()))
        return [name for name in NAMES if name not in self.given and name not in without_meaning]

    def text(self, name: str) -> str:
        """Return the value of the parameter `name` as ``--set`` takes it."""
        return compact(name, getattr(self, name))

    def check_reading(self, reading: Reading) -> None:
        """Raise :class:`BadInput` unless `reading` has a meaning: as-sampled needs T_c and T_b to divide T_s."""
        if reading is not Reading.AS_SAMPLED:
            return
        for name, part in (("T_c", self.T_c), ("T_b", self.T_b)):
            count = self.T_s / part
            if count.denominator != 1 or count > MOST_WINDOWS:
                raise BadInput(
                    f"reading as-sampled needs T_s to be a whole multiple of {name}, at most {MOST_WINDOWS} times it: "
                    f"T_s={exact_text(self.T_s)} is {exact_text(count)} times {name}={exact_text(part)}"
                )

    def as_json(self) -> dict[str, Any]:
        """Return the values by name as floats and nested lists, for people; :meth:`as_exact` loses nothing."""
        return {name: nested(getattr(self, name), float) for name in self._written()}

    def as_exact(self) -> dict[str, Any]:
        """Return the values by name as nested lists of exact texts such as ``"0.05"`` and ``"1/6"`` (order: an int)."""
        return {name: nested(getattr(self, name), exact_text) for name in self._written()}

    def _written(self) -> list[str]:
        """Return the names of what is written down: an extension only where it is used."""
        return [name for name in NAMES if name not in EXTENSIONS or getattr(self, name) != getattr(PUBLISHED, name)]

    def differences(self, base: Parameters | None = None) -> list[str]:
        """Return the shortest ``NAME=VALUE`` texts with which :meth:`with_changes` makes self of `base` (published)."""
        base = Parameters() if base is None else base
        followed = replace(base, T_s=self.T_s, T_b=self.T_s) if base.T_b == base.T_s else base
        norms = {norm: getattr(self, norm) for norm in NORMS if getattr(self, norm) != getattr(base, norm)}
        boxes = base._followed(norms)
        return [
            f"{name}={compact(name, getattr(self, name))}"
            for name in NAMES
            if getattr(self, name) != getattr(followed if name == "T_b" else base, name)
            # a box as before is no difference, unless a norm would change it
            or getattr(self, name) != boxes.get(name, getattr(self, name))
        ]

    def describe(self, base: Parameters | None = None) -> str:
        """Return what differs from `base` (the published parameters), such as ``T_c=0.05, v_max=1``; may be empty."""
        return ", ".join(self.differences(base))


#: The names of the parameters, in the order in which they are shown.
NAMES: tuple[str, ...] = tuple(one.name for one in fields(Parameters) if one.name != "given")
#: What the paper does not have: written down only where it is used.
EXTENSIONS = ("v_norm", "a_norm", "j_norm", "crash_theta_inverse", "delay")


def _example(name: str) -> str:
    """Return the published value of parameter `name`, or 1 if there is none."""
    value = getattr(PUBLISHED, name)
    return "1" if value is None else compact(name, value)


def _set_entries(changes: Iterable[str]) -> list[tuple[str, str, object]]:
    entries: list[tuple[str, str, object]] = []
    for change in changes:
        name, equals, value = change.partition("=")
        if not equals:
            raise BadInput(f"--set {shown(change)} is not of the form NAME=VALUE, such as T_c=0.05")
        if len(value) > MOST_TEXT:
            raise BadInput(f"--set {shown(name)} has a value of {len(value)} characters: {MOST_TEXT} are enough")
        entries.append(("--set", name.strip(), value))
    return entries


#: The published parameters (Section 5).
PUBLISHED = Parameters()
