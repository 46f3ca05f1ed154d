"""What was not given and so is as published: it decides verdicts like everything else, and is told."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from swarmproof.theorem3.parameters import Parameters

_UNITS = {
    **dict.fromkeys(("T_c", "T_s", "T_b"), "s"),
    **dict.fromkeys(("d_hat_min", "d_min", "tracking_error", "workspace"), "m"),
    "v_max": "m/s",
    "a_max": "m/s²",
    "j_max": "m/s³",
}


def as_json(parameters: Parameters, without: Collection[str] = ()) -> dict[str, Any]:
    """Return the published values that stand where none was given, by name: floats and nested lists, SI units.

    Those in `without` have no meaning where they stand.
    """
    values = parameters.as_json()
    return {name: values[name] for name in parameters.defaults() if name not in without}


def sentence(parameters: Parameters, what: str, without: Collection[str] = ()) -> str:
    """Return that `what` (the verdict …) rests on values that nobody gave; empty if everything was given."""
    names = [name for name in parameters.defaults() if name not in without]
    if not names:
        return ""
    if not parameters.given:
        return f"nothing was given: all parameters are published values, and {what} rests on them"
    listed = ", ".join(_in_words(parameters, name) for name in names)
    if len(names) == 1:
        return f"{listed} is the published value, not yours: {what} rests on it"
    return f"{listed} are published values, not yours: {what} rests on them"


def _in_words(parameters: Parameters, name: str) -> str:
    unit = _UNITS.get(name, "")
    text = parameters.text(name)
    if name == "order":
        text += " (triple integrator)" if parameters.order == 3 else " (double integrator)"
    if unit == "m" and text == "none":
        unit = ""
    return f"{name} = {text}{' ' if unit else ''}{unit}"
