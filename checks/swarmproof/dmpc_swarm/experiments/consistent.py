"""Whether the numbers of a flight agree with each other, and with the flight: else, what is stored is not believed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import cache
from itertools import pairwise
from math import isfinite

from swarmproof.campaign.trial import Cell
from swarmproof.dmpc_swarm.claims.flight import FLIGHT_CLAIMS
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS
from swarmproof.dmpc_swarm.experiments.measure import RADII, Leg, Measured

_CLAIMS = {*(claim.id for claim in CLAIMS), *(claim.id for claim in FLIGHT_CLAIMS)}


def fault(measured: Measured, cell: Cell) -> str | None:
    """Return the first thing that cannot be of the flight of a cell, in words; None if all agrees."""
    return next(_faults(measured, cell), None)


def _faults(measured: Measured, cell: Cell) -> Iterator[str]:
    uavs, d_min, period = _flight(cell.scenario, cell.preset, cell.changes)
    rounds = measured.rounds
    if rounds != cell.rounds:
        yield f"it has {rounds} rounds, and the flight {cell.rounds}"
    for name in ("lost", "solved", "rejected", "infeasible", "all_plan", "all_run", "adopted"):
        if getattr(measured, name) < 0:
            yield f"{name} is negative"
    if max(measured.all_plan, measured.all_run) > rounds:
        yield "more rounds were planned than flown"
    if measured.solved + measured.rejected + measured.infeasible > rounds * cell.cus:
        yield "more problems were solved than the CUs have"
    if measured.adopted > rounds * uavs or (measured.adopted > 0) != (measured.last_adopted is not None):
        yield "the trajectories adopted do not agree with the last adoption"
    if not _within(measured.last_adopted, 1, rounds) or not _within(measured.rest_from, 0, rounds - 1):
        yield "the last adoption, or the rest, is in no round of the flight"
    if not all(isfinite(one) and one >= 0 for one in (measured.sampled, measured.lower, measured.closest_time)):
        yield "a distance or a time is no number of at least 0"
        return
    if measured.lower > measured.sampled:
        yield "the distance at all times is larger than that at samples"
    if measured.closest_time > rounds * period:
        yield "the closest approach is after the flight"
    if not 0 <= measured.closest[0] < measured.closest[1] < uavs:
        yield "the closest two are no two UAVs"
    if (measured.collides is False) != (Fraction(measured.lower) >= d_min):
        yield "the collision does not agree with the distance"
    if (measured.collides is True) != ("eq-2" in measured.violated):
        yield "the collision does not agree with the claims violated"
    if not set(measured.violated) <= _CLAIMS or list(measured.violated) != sorted(set(measured.violated)):
        yield "a violated claim is none, or is there twice"
    yield from _faults_of_legs(measured.legs, rounds, uavs, cell.series)


def _faults_of_legs(legs: tuple[Leg, ...], rounds: int, uavs: int, series: bool) -> Iterator[str]:
    if not legs or legs[0].begin < 0 or any(one.begin + one.rounds != other.begin for one, other in pairwise(legs)):
        yield "the legs do not follow each other"
    elif legs[-1].begin + legs[-1].rounds != rounds or any(leg.rounds < 1 for leg in legs):
        yield "the legs do not fill the flight"
    for leg in legs:
        if len(leg.all_within) != len(RADII) or [len(one) for one in leg.reached] != [uavs] * len(RADII):
            yield "the arrivals are not those of the radii and UAVs"
            continue
        together = zip(leg.all_within, leg.reached, strict=True)
        if any(not _within(one, 1, leg.rounds) for one in (*leg.all_within, *(k for of in leg.reached for k in of))):
            yield "an arrival is in no round of its leg"
        elif any(all_within is not None and _latest(each) > all_within for all_within, each in together):
            yield "all have arrived before one has"
        elif any(_later(wide, narrow) for i in range(uavs) for narrow, wide in pairwise(of[i] for of in leg.reached)):
            yield "a wider radius is reached later than a narrower one"
        sizes = {len(leg.largest), len(leg.mean), len(leg.smallest)}
        if sizes != {leg.rounds if series else 0}:
            yield "the series are not those of the leg"
        elif not all(
            isfinite(large) and 0 <= small <= mean * (1 + 1e-12) and mean <= large * (1 + 1e-12)
            for large, mean, small in zip(leg.largest, leg.mean, leg.smallest, strict=True)
        ):
            yield "the series do not agree with each other"


def _within(number: int | None, first: int, last: int) -> bool:
    return number is None or first <= number <= last


def _latest(arrivals: Iterable[int | None]) -> float:
    return max(float("inf") if one is None else one for one in arrivals)


def _later(one: int | None, other: int | None) -> bool:
    """Return whether one arrival is later than another that there is."""
    return other is not None and (one is None or one > other)


@cache
def _flight(scenario: str, preset: str, changes: tuple[str, ...]) -> tuple[int, Fraction, float]:
    """Return the number of UAVs of a cell's flight, d_min in m, and the period in s: they depend on nothing else."""
    given = Cell(scenario, 1, "RR", "none", preset, 0, 1, changes).setting().scenario
    return given.uavs, given.parameters.d_min, float(given.parameters.T_s)
