"""What `swarmproof margin` says: the JSON document, and the same in words."""

from __future__ import annotations

from fractions import Fraction
from math import sqrt
from typing import Any

from swarmproof.margin.bounds import Margin
from swarmproof.margin.solve import Extreme
from swarmproof.margin.witness import Motion, Witness
from swarmproof.pages import defaults
from swarmproof.pages.margin import more as margin_more
from swarmproof.pages.rounding import above, below, decimal_above, decimal_below
from swarmproof.theorem3.inequality import (
    Counterexample,
    Truth,
    counterexample,
    crossing_pair,
    guaranteed_separation,
    scaled_square,
    square_root_bounds,
)
from swarmproof.theorem3.nothing import about_nothing
from swarmproof.theorem3.numbers import exact_text
from swarmproof.theorem3.parameters import Reading

SCHEMA = "swarmproof.margin/1"
#: What is said of (26) where eq. (24) is about nothing.
NOT_APPLICABLE = "not-applicable"

_SOUND_FOR = {
    Reading.INITIAL_STATE: "states are bounded at the window's start, inputs all the time",
    Reading.WHOLE_MOTION: "states and inputs are bounded all the time",
    Reading.AS_SAMPLED: "inputs are constant over each T_s, states are bounded at multiples of T_b",
}


def document(margin: Margin, extreme: Extreme | None = None) -> dict[str, Any]:
    """Return the JSON document of a margin (schema `swarmproof.margin/1`); floats are rounded to the safe side."""
    given = margin.problem.parameters
    found = refutation(margin)
    return {
        "schema": SCHEMA,
        "parameters": given.as_json(),
        "defaults": defaults.as_json(given, _without_meaning(margin)),
        "reading": margin.problem.reading.value,
        "dip": {"lower": below(margin.lower), "upper": above(margin.upper)},
        "witness": None if margin.witness is None else _witness(margin, margin.witness),
        "theorem_3": {
            **dict(zip(("printed", "corrected"), verdicts(margin), strict=True)),
            "d_min": float(given.d_min),
            "tracking_error": float(given.tracking_error),
            "guaranteed_separation": below(guaranteed_separation(given, margin.loss[1])),
            "counterexample": None if found is None else _counterexample(found),
        },
        **margin_more.document(margin),
        "about_nothing": about_nothing(given, margin.problem.reading) or None,
        "solve_for": None
        if extreme is None
        else {
            "name": extreme.name,
            "certified": None if extreme.certified is None else float(extreme.certified),
            "refuted": None if extreme.refuted is None else float(extreme.refuted),
        },
    }


def verdicts(margin: Margin) -> tuple[str, str]:
    """Return what is said of (26), as printed and corrected; of motions that cannot be, not-applicable."""
    given = margin.problem.parameters
    if about_nothing(given, margin.problem.reading):
        return NOT_APPLICABLE, NOT_APPLICABLE
    as_printed, as_corrected = margin.truths
    return as_printed.value, as_corrected.value


def refutation(margin: Margin) -> Counterexample | None:
    """Return a pair that meets every premise of the printed (26) and comes closer than d_min, if one is known."""
    given = margin.problem.parameters
    # the paper knows one ellipsoid only: with another one for crashes, its inequality is not refuted
    if margin.truths[0] is not Truth.HOLDS or given.crash_theta_inverse is not None:
        return None
    crossing = counterexample(given, crossing_pair(given))
    return crossing if crossing is not None or margin.closest is None else counterexample(given, margin.closest)


def _witness(margin: Margin, witness: Witness) -> dict[str, Any]:
    window = float(margin.problem.parameters.T_c)
    times = {"start": Fraction(0), "closest": witness.tau, "end": margin.problem.parameters.T_c}
    return {
        "window": [float(witness.start), float(witness.start) + window],
        "tau": float(witness.tau),
        "distance": {name: scaled_distance(margin, time) for name, time in times.items()},
        "uav_i": {name: _state(witness.uav_i, witness.start + time) for name, time in times.items()},
        "uav_j": {name: _state(witness.uav_j, witness.start + time) for name, time in times.items()},
        "inputs_i": [[[float(d), float(value)] for d, value in axis.inputs] for axis in witness.uav_i],
        "inputs_j": [[[float(d), float(value)] for d, value in axis.inputs] for axis in witness.uav_j],
    }


def scaled_distance(margin: Margin, time: Fraction) -> float:
    """Return the witness's scaled distance (m) `time` after the window's start; only where there is a witness."""
    if margin.witness is None:
        raise ValueError("a margin with lower = 0 has no witness")
    relative = margin.witness.relative(margin.witness.start + time)
    return sqrt(scaled_square(margin.problem.parameters.theta_inverse, relative))


def _state(motion: Motion, time: Fraction) -> dict[str, list[float]]:
    states = [axis.at(time) for axis in motion]
    names = ("position", "velocity", "acceleration")[: len(states[0])]
    return {name: [float(state[m]) for state in states] for m, name in enumerate(names)}


def _counterexample(found: Counterexample) -> dict[str, Any]:
    return {
        "references": [[str(value) for value in position] for position in found.references],
        "positions": [[str(value) for value in position] for position in found.positions],
        "scaled_distance": float(square_root_bounds(found.squared_distance)[1]),
    }


def headline(margin: Margin) -> str:
    """Return what was computed, for whom."""
    given = margin.problem.parameters
    model = "triple integrator (jerk input)" if given.order == 3 else "double integrator (acceleration input)"
    changes = given.describe() or "the published parameters"
    return f"Δd_min,cont, reading {margin.problem.reading.value}, {changes}, {model}"


def interval(margin: Margin) -> str:
    """Return the interval in words."""
    distance = margin.problem.parameters.d_hat_min
    if margin.lower == distance:
        return f"{below(margin.lower):.9g} m, which is all of d̂_min: two UAVs can be in one place between two samples"
    width = float((margin.upper - margin.lower) / distance)
    ends = decimal_below(margin.lower, 9), decimal_above(margin.upper, 9)
    return f"between {ends[0]} m and {ends[1]} m (width {width:.0e} · d̂_min)"


def worst_pair(margin: Margin) -> str:
    """Return the witness in words."""
    given, witness = margin.problem.parameters, margin.witness
    if witness is None:
        return "no pair dips below d̂_min between two samples, as far as was found"
    speed = _length(
        [
            axis_i.at(witness.start + witness.tau)[1] - axis_j.at(witness.start + witness.tau)[1]
            for axis_i, axis_j in zip(witness.uav_i, witness.uav_j, strict=True)
        ]
    )
    ends = [scaled_distance(margin, time) for time in (Fraction(0), given.T_c)]
    place = ""
    if margin.problem.reading is Reading.AS_SAMPLED:
        low, high = (1000 * float(time) for time in (witness.start, witness.start + given.T_c))
        place = f", {low:g} to {high:g} ms after the start of a period T_s"
    return (
        f"{ends[0]:.4f} m apart at one sample and {ends[1]:.4f} m at the next{place}; "
        f"{scaled_distance(margin, witness.tau):.4f} m after {1000 * float(witness.tau):.1f} ms of "
        f"{1000 * float(given.T_c):g} ms, passing at {speed:.2f} m/s relative to each other (distances scaled by Θ⁻¹)"
    )


def _length(vector: list[Fraction]) -> float:
    return sqrt(sum((value**2 for value in vector), Fraction(0)))


def consequences(margin: Margin) -> list[tuple[str, str]]:
    """Return what (26) gives: rows of name and text."""
    given = margin.problem.parameters
    as_printed, as_corrected = verdicts(margin)
    guaranteed = guaranteed_separation(given, margin.loss[1])
    separation = decimal_below(guaranteed, 6)
    rows = [
        *margin_more.rows(margin),
        ("(26) as printed", f"{as_printed}: d̂_min ≥ d_min + Δd_min + Δd_min,cont"),
        ("(26) corrected", f"{as_corrected}: {margin_more.inequality(margin)}"),
        ("guaranteed separation", f"{separation} m (scaled, at all times, for motions of this reading)"),
    ]
    if guaranteed == 0:
        text = "for everybody: whatever d_min > 0 is asked for, Theorem 3 does not apply to these parameters"
    else:
        text = f"for whoever needs more than {separation} m between the UAVs, or tracks worse"
    rows.append(("vacuous", text))
    nothing = about_nothing(given, margin.problem.reading)
    if nothing:
        return [("about nothing", nothing), *(row for row in rows if row[0].startswith("(26)"))]
    if as_corrected != Truth.HOLDS:
        rows.append(("", "An inequality that fails is no collision: the theorem is silent, UAVs may still be safe."))
    found = refutation(margin)
    if found is not None:
        rows.append(("counterexample", _in_words(found)))
    missing = defaults.sentence(given, "the verdict", _without_meaning(margin))
    if missing:
        rows.append(("not given", missing))
    return rows


def _without_meaning(margin: Margin) -> tuple[str, ...]:
    """Return the parameters that the reading does not look at."""
    return () if margin.problem.reading is Reading.AS_SAMPLED else ("T_s", "T_b")


def _in_words(found: Counterexample) -> str:
    def point(position: tuple[Fraction, ...]) -> str:
        return "(" + ", ".join(f"{float(value):.6g}" for value in position) + ")"

    return (
        f"the printed (26) holds, yet references at {point(found.references[0])} and {point(found.references[1])} may "
        f"be tracked at {point(found.positions[0])} and {point(found.positions[1])}, neither more than "
        f"{float(found.tracking_error):g} m off: {float(square_root_bounds(found.squared_distance)[1]):.6g} m apart "
        f"(scaled), d_min is {float(found.d_min):g} m"
    )


def scope(margin: Margin) -> str:
    """Return for which motions the interval holds."""
    given, sound = margin.problem.parameters, _SOUND_FOR[margin.problem.reading]
    box = "positions anywhere"
    if given.workspace is not None:
        box = "the pair within the workspace where states are bounded (the upper bound does without)"
    return (
        f"Scope: any two UAVs with these bounds {margin_more.bounds_used(margin)}; {sound}; {box}. "
        "Lower bound: two explicit trajectories in fractions. Upper bound: certificate, checked exactly."
    )


def solution(extreme: Extreme) -> str:
    """Return the answer of `--solve-for` in words."""
    unit = {"T_c": "s", "v_max": "m/s", "v_norm": "m/s", "d_hat_min": "m"}[extreme.name]
    kind = "smallest" if extreme.name == "d_hat_min" else "largest"
    if extreme.certified is None:
        told = f"no {extreme.name} was found for which the corrected (26) is certified"
    else:
        told = f"{kind} {extreme.name} with the corrected (26) certified: {_value(extreme.certified)} {unit}"
    if extreme.refuted is not None and extreme.certified is None:
        told += f"; it is refuted {'up' if kind == 'smallest' else 'down'} to {_value(extreme.refuted)} {unit}"
    elif extreme.refuted is not None:
        told += f"; refuted by a witness at {_value(extreme.refuted)} {unit}"
    else:
        told += "; no value tried was refuted"
    if extreme.undecided:
        told += f"; undecided at {', '.join(map(_value, extreme.undecided))} {unit}"
    return told


def _value(value: Fraction) -> str:
    """Return a value as `--set` takes it, exactly, and if that is a fraction as a decimal, too."""
    exact = exact_text(value)
    return f"{exact} (≈ {float(value):.6g})" if "/" in exact else exact
