"""What `swarmproof margin` says of what the paper does not have: norms, a delay, kinds, a crash's own ellipsoid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from swarmproof.margin.bounds import Margin
from swarmproof.pages import rounding
from swarmproof.theorem3.delay import shifts
from swarmproof.theorem3.inequality import shrinking_bounds
from swarmproof.theorem3.numbers import exact_text
from swarmproof.theorem3.values import NORMS

_NAMES = {"v_norm": "speed", "a_norm": "acceleration", "j_norm": "jerk"}


def document(margin: Margin) -> dict[str, Any]:
    """Return what the JSON document has beside that of the paper's parameters; nothing where none of it is used."""
    given = margin.problem.parameters
    more: dict[str, Any] = {}
    if given.delay:
        low, high = margin.flown
        more["delay"] = {"lower": rounding.below(low), "upper": rounding.above(high)}
    if given.crash_theta_inverse is not None:
        low, high = shrinking_bounds(given)
        more["crash"] = {"lower": rounding.below(low), "upper": rounding.above(high)}
    if margin.problem.coupled:
        more["bounds"] = "norm" if margin.by_norms else "box around the norm"
    return more


def inequality(margin: Margin) -> str:
    """Return the corrected (26) in symbols."""
    given = margin.problem.parameters
    own, norm = given.crash_theta_inverse is not None, "Θ⁻¹" if given.crash_theta_inverse is None else "C"
    paid = f"d_min + 2‖{norm}‖₂·Δd_min"
    if given.delay and not shifts(given, margin.problem.reading):
        left = "√((d̂_min − Δd_min,cont)² − delay·(2d̂_min − delay))"
        return f"{'σ·' if own else ''}{left} ≥ {paid}"
    lost = "Δd_min,cont" + (" + delay" if given.delay else "")
    if not own:
        return f"d̂_min ≥ {paid} + {lost}"
    return f"σ·(d̂_min − {lost if not given.delay else f'({lost})'}) ≥ {paid}"


def rows(margin: Margin) -> list[tuple[str, str]]:
    """Return rows of name and text."""
    given, told = margin.problem.parameters, []
    if given.delay:
        low, high = (rounding.decimal_below(margin.flown[0], 9), rounding.decimal_above(margin.flown[1], 9))
        seconds = exact_text(given.delay)
        told.append(("delay", f"one UAV flies on for {seconds} s: {low} to {high} m (scaled), which (26) has to pay"))
    if given.crash_theta_inverse is not None:
        low = rounding.decimal_below(shrinking_bounds(given)[0], 9)
        told.append(
            ("crash", f"d_min is measured with C = crash_theta_inverse: at least σ = {low} times what Θ⁻¹ says")
        )
    if not margin.attained:
        text = "is that of two equal UAVs with the mean bounds, which need not be a pair of these two kinds"
        told.append(("lower bound", f"{text}: no verdict rests on it"))
    return told


def of_fleet(results: Sequence[Margin]) -> list[str]:
    """Return what must be said below a table of pairs of kinds."""
    told = [
        "The lower bound of a pair of two kinds is that of two equal UAVs with the mean bounds. Where the bounds of "
        "the kinds are not in one ratio, that need not be a pair of theirs, and no verdict rests on it."
    ]
    return told if any(not result.attained for result in results) else []


def bounds_used(margin: Margin) -> str:
    """Return which bounds the interval is about."""
    given, problem = margin.problem.parameters, margin.problem
    if not problem.coupled:
        return "per axis"
    names = [name for name in list(NORMS)[: given.order] if getattr(given, name) is not None]
    told = "of the norm of " + " and ".join(_NAMES[name] for name in names) + ", beside those per axis"
    if margin.certificate["windows"] is not None and not margin.by_norms:
        why = "that is no wider here" if problem.diagonal else "Θ⁻¹ is not diagonal"
        told += f" (the upper bound takes the box around the norm: {why})"
    return told
