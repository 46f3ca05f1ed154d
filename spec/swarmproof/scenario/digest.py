"""What a scenario is, as one text, and that text's SHA-256: equal exactly if two scenarios fly alike, however long."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from fractions import Fraction
from hashlib import sha256
from typing import Any

from swarmproof.scenario.definition import Scenario


def digest(scenario: Scenario) -> str:
    """Return the SHA-256 of the canonical text, 64 hexadecimal digits."""
    return sha256(canonical_text(scenario).encode()).hexdigest()


def canonical_text(scenario: Scenario) -> str:
    """Return everything that a flight depends on, JSON with sorted names: numbers are fractions such as ``"1/6"``.

    How long the flight is, which `--rounds` may change, is not in it.
    What was drawn at random is in it as the points that came out. What `==` does not look at (which parameters were
    given, and which are as published by default) is not in it.
    """
    return json.dumps(
        {name: part for name, part in _plain(scenario).items() if name != "rounds"},
        sort_keys=True,
        separators=(",", ":"),
    )


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return {one.name: _plain(getattr(value, one.name)) for one in fields(value) if one.compare}
    if isinstance(value, Fraction):
        return str(value)
    if isinstance(value, float):
        return str(Fraction(value))
    if isinstance(value, Mapping):
        return {str(name): _plain(one) for name, one in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(one) for one in value]
    if value is None or isinstance(value, (bool, int, str)):
        return value
    raise TypeError(f"a {type(value).__name__} in a scenario has no canonical text")
