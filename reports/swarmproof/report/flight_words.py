"""A flight in words and as JSON, `swarmproof.flight/1`."""

from __future__ import annotations

import json

from swarmproof.assess.judge import FlightVerdict, Flown
from swarmproof.assess.run import Setting

SCHEMA = "swarmproof.flight/1"


def headline(setting: Setting, loss: str, flown: Flown) -> str:
    """Return what became of the flight, in one line."""
    violated = [judged.claim.id for judged in flown.claims if judged.verdict is FlightVerdict.VIOLATED]
    what = f"violated: {', '.join(violated)}" if violated else "no claim violated"
    return f"{setting.scenario.name}, {setting.scenario.uavs} UAVs, {setting.cus} CUs, {flown.rounds} rounds: {what}"


def summary(flown: Flown) -> list[str]:
    """Return the figures of a flight, a line each."""
    (i, j), time = flown.closest_pair
    if flown.rounds_to_arrival is not None:
        arrival = f"All arrived {flown.rounds_to_arrival} rounds after the targets changed last."
    else:
        arrival = "Not all had arrived at the end."
    tracked = "" if flown.tracked is None else f"; of all trajectories in valid trackers {flown.tracked:.6f} m"
    qps = flown.qps
    return [
        f"Smallest scaled distance of references: {flown.sampled:.6f} m at samples{tracked}; at any time at least "
        f"{flown.continuous_lower:.6f} m (UAVs {i} and {j}, {time:.2f} s).",
        f"{qps.solved} optimization problems solved, {qps.rejected} answers rejected, {qps.infeasible} infeasible; "
        f"{flown.lost} messages lost. {arrival}",
    ]


def scope(setting: Setting, loss: str, flown: Flown) -> str:
    """Return what the verdicts are about."""
    parameters = setting.scenario.parameters.describe() or "published"
    return (
        f"This flight only: {flown.rounds} rounds, trigger {setting.trigger}, loss {loss}, seed {setting.seed}; "
        f"{setting.semantics.name()}; parameters {parameters}. Samples and constraints were decided exactly, distances "
        "between samples are certified bounds; no other flight is covered."
    )


def document(setting: Setting, flown: Flown, seconds: float) -> str:
    """Return the flight as an indented JSON document."""
    content = {
        "schema": SCHEMA,
        "uavs": setting.scenario.uavs,
        "cus": setting.cus,
        "rounds": flown.rounds,
        "seed": setting.seed,
        "min_separation": {"sampled": flown.sampled, "continuous_lower": flown.continuous_lower},
        "qps": {"solved": flown.qps.solved, "rejected": flown.qps.rejected, "infeasible": flown.qps.infeasible},
        "arrived": flown.arrived,
        "rounds_to_arrival": flown.rounds_to_arrival,
        "claims": [
            {
                "id": judged.claim.id,
                "verdict": str(judged.verdict),
                "rounds": judged.rounds,
                "lost_messages": judged.lost,
                "worst_rounds": None,
                "avoidable": None,
                "trace": None,
            }
            for judged in flown.claims
        ],
        "seconds": round(seconds, 3),
    }
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"
