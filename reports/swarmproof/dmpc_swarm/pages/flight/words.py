"""A flight in words and as JSON, `swarmproof.flight/1`."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from swarmproof.dmpc_swarm.flight.exhaustive import Decided, Exhaustive
from swarmproof.dmpc_swarm.flight.judge import Counts, Flown, Judged
from swarmproof.dmpc_swarm.flight.places import Place
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.pages.flight import facts as flight_facts
from swarmproof.dmpc_swarm.pages.flight.bounds import bounds_document, bounds_in_words
from swarmproof.pages import defaults
from swarmproof.scenario.scenario import EXACT
from swarmproof.theorem3.numbers import exact_text

SCHEMA = "swarmproof.flight/1"


def headline(setting: Setting, flown: Flown) -> str:
    """Return what became of the flight, in one line."""
    what = _outcome(flown.claims)
    if flown.last_adoption is None:
        what += "; nobody adopted a new trajectory"
    swarm = f"{setting.scenario.name}, {setting.scenario.uavs} UAVs, {setting.cus} CUs"
    return f"{swarm}, {flown.rounds} rounds{_with_fault(setting)}: {what}"


def _outcome(claims: Iterable[Judged | Decided]) -> str:
    """Return which claims are violated, or that none is, and which are undecided."""
    by_verdict = {
        verdict: [judged.claim.id for judged in claims if judged.verdict == verdict]
        for verdict in ("violated", "undecided")
    }
    told = [f"{verdict}: {', '.join(ids)}" for verdict, ids in by_verdict.items() if ids]
    return "; ".join(told if by_verdict["violated"] else ["no claim violated", *told])


def summary(setting: Setting, flown: Flown) -> list[str]:
    """Return the figures of a flight, a line each."""
    (i, j), time = flown.closest_pair
    if flown.rounds_to_arrival is not None:
        arrival = f"All arrived {flown.rounds_to_arrival} rounds after the targets changed last."
    else:
        arrival = "Not all had arrived at the end."
    last = flown.last_adoption
    if last is None:
        progress = "Nobody adopted a new trajectory."
    else:
        progress = f"Last new trajectory adopted: in round {last.round}, by UAV {last.uav}, planned by CU {last.cu}."
    tracked = "" if flown.tracked is None else f"; of all trajectories in valid trackers {flown.tracked:.6f} m"
    qps = flown.qps
    given = setting.scenario
    crash = ", scaled as for d_min" if given.kinds or given.parameters.crash_theta_inverse is not None else ""
    return [
        *([flown.beginning] if flown.beginning else []),
        f"Smallest scaled distance of references: {flown.sampled:.6f} m at samples{tracked}; at any time at least "
        f"{flown.continuous_lower:.6f} m (UAVs {i} and {j}, {time:.2f} s{crash}).",
        f"{qps.solved} optimization problems solved, {qps.rejected} answers rejected, {qps.infeasible} infeasible; "
        f"{flown.lost} messages lost. {arrival} {progress}",
    ]


class Collision(NamedTuple):
    """Whether UAVs collided, in one sentence: the first question about a flight. `good`: they certainly did not."""

    good: bool
    sentence: str


#: The claims that speak of collisions: of the UAVs themselves, and of their references.
_COLLISIONS = ("eq-2-actual", "eq-2")


def collision(setting: Setting, found: Flown | Exhaustive) -> Collision:
    """Return whether UAVs came closer than d_min."""
    judged = [one for one in found.claims if one.claim.id in _COLLISIONS]
    by_verdict = {str(one.verdict): one for one in judged}
    # kinds of UAVs have a d_min each
    d_min = "" if setting.scenario.kinds else f"; d_min is {exact_text(setting.scenario.parameters.d_min)} m"
    if "violated" in by_verdict:
        return Collision(False, f"✗ UAVs collided: {by_verdict['violated'].why}.")
    if "undecided" in by_verdict:
        return Collision(False, f"? Whether UAVs collided is not decided: {by_verdict['undecided'].why}.")
    if set(by_verdict) == {"not-applicable"}:
        return Collision(False, f"– Whether UAVs collided cannot be asked: {judged[0].why}.")
    apart = f"their references stayed at least {found.continuous_lower:.6f} m apart at all times (scaled)"
    return Collision(True, f"✓ No two UAVs collided: {apart}{d_min}.")


def scope(setting: Setting, loss: str, flown: Flown) -> str:
    """Return what the verdicts are about."""
    parameters = ", ".join(setting.scenario.differences()) or "published"
    return (
        f"This flight only: {flown.rounds} rounds, trigger {setting.trigger}, loss {loss}, seed {setting.seed}; "
        f"{setting.semantics.name()}; parameters {parameters}. Samples and constraints were decided exactly, distances "
        "between samples are certified bounds; no other flight is covered."
        + _defaults(setting)
        + bounds_in_words(setting.scenario)
        + _fault(setting, flown.qps)
    )


def _defaults(setting: Setting) -> str:
    """Return which values nobody gave, as a sentence that follows others; empty if everything was given."""
    told = defaults.sentence(setting.scenario.parameters, "what is planned, and every verdict,")
    return f" Not given: {told}." if told else ""


def document(setting: Setting, loss: str, flown: Flown, seconds: float, search: Sequence[str] = ()) -> str:
    """Return the flight as an indented JSON document; `loss` is the loss model as the user wrote it.

    `search` says how its losses were found, and whether that was stopped, if they were searched for.
    """
    qps = flown.qps
    separation = {"sampled": flown.sampled, "continuous_lower": flown.continuous_lower}
    content = {
        **_header(setting, loss, flown.rounds, separation, qps),
        **({"beginning": flown.beginning} if flown.beginning else {}),
        "arrived": flown.arrived,
        "rounds_to_arrival": flown.rounds_to_arrival,
        "last_adoption": None if flown.last_adoption is None else flown.last_adoption._asdict(),
        "interrupted": flown.stopped is not None,
        "stopped": flown.stopped,
        **({"search": list(search)} if search else {}),
        "claims": [_claim(judged) for judged in flown.claims],
        "seconds": round(seconds, 3),
    }
    return _text(content)


def patterns_headline(setting: Setting, rounds: int, found: Exhaustive) -> str:
    """Return what became of the flights under all loss patterns, in one line."""
    scenario = setting.scenario
    swarm = f"{scenario.name}, {scenario.uavs} UAVs, {setting.cus} CUs"
    return f"{swarm}, all losses of {rounds} rounds{_with_fault(setting)}: {_outcome(found.claims)}"


def patterns_summary(found: Exhaustive) -> list[str]:
    """Return the figures of an exhaustive flight, a line each."""
    covered = found.patterns[-1] if found.patterns else 0
    swarms = ", ".join(str(count) for count in found.swarms)
    return [
        f"{covered} loss patterns of {len(found.patterns)} rounds covered; different swarms after 0, 1, … rounds: "
        f"{swarms}; {found.transitions} rounds flown, {found.asked} plans asked for, {_total(found.qps)} different "
        f"ones planned ({found.qps.rejected} rejected, {found.qps.infeasible} infeasible).",
        f"Smallest scaled distance of references: {_metres(found.sampled)} at samples, of all trajectories in valid "
        f"trackers (over their whole horizon) {_metres(found.tracked)}; at any time of these rounds at least "
        f"{found.continuous_lower:.6f} m.",
        *_begun(found),
    ]


def _begun(found: Exhaustive) -> list[str]:
    """Return how far the round came that was not finished, if there is one."""
    begun = found.begun
    if begun is None:
        return []
    return [
        f"Not finished: round {begun.k}. Of the {begun.swarms} swarms before it, {begun.flown} were flown on under "
        f"every pattern; {begun.patterns} loss patterns of rounds 0 to {begun.k} were flown, which lead to "
        f"{begun.found} different swarms.",
    ]


def patterns_scope(setting: Setting, rounds: int, found: Exhaustive) -> str:
    """Return what the verdicts of an exhaustive flight are about."""
    parameters = ", ".join(setting.scenario.differences()) or "published"
    stopped = "" if found.stopped is None else f" Not finished: {found.stopped}."
    return (
        f"Every loss of (message, receiver) pairs in the first {rounds} rounds of this scenario, trigger "
        f"{setting.trigger}; {setting.semantics.name()}; parameters {parameters}. Swarms with equal protocol state, "
        f"trajectories and knowledge were merged. Nothing is said of later rounds.{stopped}"
        + _defaults(setting)
        + bounds_in_words(setting.scenario)
        + _fault(setting, found.qps)
    )


def patterns_document(setting: Setting, rounds: int, found: Exhaustive) -> str:
    """Return an exhaustive flight as a JSON document like that of a flight; `patterns` says what was covered."""
    separation = {"sampled": found.sampled, "continuous_lower": found.continuous_lower}
    content = {
        **_header(setting, f"exhaustive:{rounds}", rounds, separation, found.qps),
        "arrived": False,
        "rounds_to_arrival": None,
        "patterns": {
            "covered": found.patterns[-1] if found.patterns else 0,
            "swarms": found.swarms,
            "tracked_separation": found.tracked,
            "stopped": found.stopped,
        },
        "claims": [_claim(decided) for decided in found.claims],
        "seconds": round(found.seconds, 3),
    }
    return _text(content)


def _metres(distance: float | None) -> str:
    return "none seen" if distance is None else f"{distance:.6f} m"


def _total(counts: Counts) -> int:
    return counts.solved + counts.rejected + counts.infeasible


def _header(
    setting: Setting, loss: str, rounds: int, separation: Mapping[str, float | None], counts: Counts
) -> dict[str, object]:
    return {
        "schema": SCHEMA,
        "uavs": setting.scenario.uavs,
        "cus": setting.cus,
        "rounds": rounds,
        "seed": setting.seed,
        "changed": setting.scenario.differences(),
        "min_separation": separation,
        "qps": {"solved": counts.solved, "rejected": counts.rejected, "infeasible": counts.infeasible},
        **bounds_document(setting.scenario),
        **_fault_document(setting, counts),
        **flight_facts.as_json(setting, loss),
    }


def _with_fault(setting: Setting) -> str:
    """Return what follows the swarm's name where the planner is made faulty; usually nothing."""
    return "" if setting.scenario.tolerance == EXACT else " with a faulty planner (tolerance)"


def _fault(setting: Setting, counts: Counts) -> str:
    """Return what tolerance the planner had, and what it led to; usually nothing."""
    tolerance, d_hat_min = setting.scenario.tolerance, setting.scenario.parameters.d_hat_min
    if tolerance == EXACT:
        return ""
    return (
        f" A fault was flown: plans may violate rows of (13f) by {exact_text(tolerance.full)} m, those midway between "
        f"UAVs by {exact_text(tolerance.halfway)} m. The claims go on asking for {exact_text(d_hat_min)} m; with this "
        f"tolerance, trajectories keep {exact_text(tolerance.kept(d_hat_min))} m at samples. Theorem 1's candidate did "
        f"not satisfy {counts.unsatisfied} of {_total(counts)} optimization problems; "
        f"{counts.rejected + counts.infeasible} led to no plan."
    )


def _fault_document(setting: Setting, counts: Counts) -> dict[str, object]:
    """Return the same for the JSON document."""
    tolerance = setting.scenario.tolerance
    if tolerance == EXACT:
        return {}
    return {
        "tolerance": {
            "full": float(tolerance.full),
            "halfway": float(tolerance.halfway),
            "kept": float(tolerance.kept(setting.scenario.parameters.d_hat_min)),
            "candidate_unsatisfied": counts.unsatisfied,
        }
    }


def _claim(judged: Judged | Decided) -> dict[str, object]:
    return {
        "id": judged.claim.id,
        "verdict": str(judged.verdict),
        "rounds": judged.rounds,
        "lost_messages": judged.lost,
        "worst_rounds": None,
        "avoidable": None,
        "trace": None,
        "instances": judged.instances,
        "why": judged.why,
        **_place(judged.place),
    }


def _place(place: Place | None) -> dict[str, object]:
    """Return where a claim is broken first, for machines; nulls if it is not."""
    if place is None:
        return {"round": None, "uavs": None, "cus": None, "time": None}
    return {"round": place.round, "uavs": list(place.uavs), "cus": list(place.cus), "time": place.time}


def _text(content: dict[str, object]) -> str:
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"
