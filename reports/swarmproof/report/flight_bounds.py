"""What bounds a flight beside the box of each axis: norms. In words, and for the JSON document."""

from __future__ import annotations

from math import floor

from swarmproof.motion.lattice import binding_norms
from swarmproof.planning.ball import share
from swarmproof.scenario.scenario import Scenario
from swarmproof.theorem3.numbers import exact_text

_UNITS = {"v_norm": "m/s", "a_norm": "m/s²", "j_norm": "m/s³"}


def bounds_in_words(scenario: Scenario) -> str:
    """Return how bounds of norms are kept, as a sentence after another one; empty if none restricts the flight."""
    norms = binding_norms(scenario.parameters)
    if not norms:
        return ""
    texts = [f"{name}={exact_text(norm)} {_UNITS[name]}" for name, norm in norms.items()]
    return (
        f" Bounds of norms ({', '.join(texts)}) are accepted exactly; plans are looked for within a polyhedron that "
        f"reaches at least {floor(1000 * share()) / 10:g} % of them in every direction."
    )


def bounds_document(scenario: Scenario) -> dict[str, object]:
    """Return the same for the JSON document."""
    norms = binding_norms(scenario.parameters)
    if not norms:
        return {}
    bounds = {name: float(norm) for name, norm in norms.items()}
    return {"norms": {**bounds, "planned_share": floor(1000 * share()) / 1000}}
