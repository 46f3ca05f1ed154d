"""Decides the claims about experiments over seeds.

Seeds are the independent repetitions. Rounds of a flight are not, nor are flights with one seed whose jams begin at
different times: they have the same starts. So every interval and every test here counts seeds; a thing happens with a
seed if it happens in one of the seed's flights.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf

from swarmproof.campaign.statistics import CONFIDENCE, compare, fewest, proportion_interval, shared
from swarmproof.campaign.store import Stored
from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import (
    Comparison,
    ExperimentClaim,
    Missing,
    Never,
    Observation,
    Ordering,
    Run,
    Sometimes,
    runs,
)
from swarmproof.dmpc_swarm.claims.experiments import claims_of
from swarmproof.dmpc_swarm.experiments.experiment import Experiment, Variant


class Agreement(StrEnum):
    """Whether our flights agree with a statement of the paper."""

    AGREES = "agrees"
    DISAGREES = "disagrees"
    UNDECIDED = "undecided"


@dataclass(frozen=True, slots=True)
class Compared:
    """How a comparison came out.

    Attributes:
        verdict: AGREES if it is as said in more than half of all seeds, ties among them, DISAGREES if the opposite is,
            by sign tests with which the verdict on the claim holds with 95 %.
        seeds: in how many it was made.
        as_said: in how many of them it is as said.
        reversed: in how many of them the opposite is so; the others are ties, or undefined.
        difference: lower end, median and upper end of larger − smaller, in the reading's unit: positive where it is as
            said; the interval is for its median, with the confidence of the test.
        missing: seeds left out, since not all of their flights are there.
        undefined: seeds among `seeds` for which one of the two numbers is not known.
    """

    comparison: Comparison
    verdict: Agreement
    seeds: int
    as_said: int
    reversed: int
    difference: tuple[float, float, float]
    missing: int = 0
    undefined: int = 0


@dataclass(frozen=True, slots=True)
class DecidedClaim:
    """A claim and what flights say of it.

    Attributes:
        why: one or two sentences with the counts.
        compared: of an ordering.
        observed: of an ordering, how many seeds were compared at all; of another claim, in how many flights it was
            decided whether it happens.
        example: unless it is an ordering, of the observations that decide, the one in which UAVs come closest.
    """

    claim: ExperimentClaim
    verdict: Agreement
    why: str
    compared: tuple[Compared, ...]
    observed: int
    example: Observation | None


def decide_variant(experiment: Experiment, variant: Variant, found: Mapping[Cell, Stored]) -> list[DecidedClaim]:
    """Decide all claims about an experiment by those cells of one variant that are found.

    While some are missing, that something has not happened decides nothing.
    """
    observations = [
        seen
        for cell in variant.cells
        if cell in found
        for seen in experiment.observe(cell, found[cell].measured, variant.radius)
    ]
    complete = all(cell in found for cell in variant.cells)
    return [decide(claim, observations, complete) for claim in claims_of(experiment.name)]


def decide(claim: ExperimentClaim, observations: Sequence[Observation], complete: bool = True) -> DecidedClaim:
    """Decide a claim; their order does not matter, and without observations that it speaks of it is undecided.

    An ordering agrees if at least as many comparisons as it needs are as said, and disagrees if so many are reversed
    that this cannot be. What never happens agrees if it happened nowhere (nothing is proved by that), and disagrees if
    it happened once; what sometimes happens agrees if it happened once, and disagrees if it happened nowhere. Where it
    is not decided whether it happened, it may have.
    """
    if isinstance(claim.statement, Ordering):
        return _decide_ordering(claim, claim.statement, observations)
    return _decide_event(claim, claim.statement, observations, complete)


def _decide_ordering(claim: ExperimentClaim, ordering: Ordering, observations: Sequence[Observation]) -> DecidedClaim:
    by_seed = runs(observations)
    number = len(ordering.comparisons)
    # that at least u of n are true is shown by u tests that share the doubt among n - u + 1 (partial conjunction);
    # that it cannot be is shown by n - u + 1 of the opposite, which share it among u
    confidence, opposed = shared(CONFIDENCE, number - ordering.needed + 1), shared(CONFIDENCE, ordering.needed)
    compared = tuple(_compare(comparison, by_seed, confidence, opposed) for comparison in ordering.comparisons)
    as_said = sum(one.verdict is Agreement.AGREES for one in compared)
    opposite = sum(one.verdict is Agreement.DISAGREES for one in compared)
    if as_said >= ordering.needed:
        verdict = Agreement.AGREES
    elif opposite > len(compared) - ordering.needed:
        verdict = Agreement.DISAGREES
    else:
        verdict = Agreement.UNDECIDED
    why = " ".join(_why_ordering(ordering, compared, confidence))
    return DecidedClaim(claim, verdict, why, compared, max(one.seeds for one in compared), None)


def _compare(comparison: Comparison, by_seed: Sequence[Run], confidence: float, opposed: float) -> Compared:
    pairs = []
    for run in by_seed:
        try:
            pairs.append((comparison.smaller(run), comparison.larger(run)))
        except Missing:
            continue
    outcome = compare(pairs, confidence)
    if outcome.mostly_as_said(confidence):
        verdict = Agreement.AGREES
    else:
        verdict = Agreement.DISAGREES if outcome.mostly_reversed(opposed) else Agreement.UNDECIDED
    return Compared(
        comparison,
        verdict,
        seeds=outcome.number,
        as_said=outcome.as_said,
        reversed=outcome.reversed,
        difference=outcome.difference,
        missing=len(by_seed) - outcome.number,
        undefined=outcome.undefined,
    )


def _why_ordering(ordering: Ordering, compared: Sequence[Compared], confidence: float) -> Iterator[str]:
    number = len(compared)
    seeds = max(one.seeds for one in compared)
    if not seeds:
        yield "There is no seed of which all flights that it speaks of are there."
        return
    counts = "; ".join(f"{one.comparison.name} {one.as_said} of {one.seeds}{_opposite(one)}" for one in compared)
    yield f"Seeds as said: {counts}."
    as_said = sum(one.verdict is Agreement.AGREES for one in compared)
    opposite = sum(one.verdict is Agreement.DISAGREES for one in compared)
    if seeds < fewest(confidence):
        yield f"Fewer than {fewest(confidence)} seeds decide no comparison."
    elif number > 1:
        yield (
            f"So it is shown for {as_said} of {number}{f', the opposite for {opposite}' if opposite else ''}; "
            f"{ordering.needed} are needed (sign tests, 95 % for the statement)."
        )
    missing = max(one.missing for one in compared)
    if missing:
        yield f"{_plural(missing, 'seed is', 'seeds are')} left out, not all of their flights are there."


def _opposite(one: Compared) -> str:
    """Return what is to be said of the seeds that are not as said."""
    parts = []
    if one.reversed:
        parts.append(f"{one.reversed} reversed")
    if one.undefined:
        parts.append(f"{one.undefined} not known")
    return f" ({', '.join(parts)})" if parts else ""


def _decide_event(
    claim: ExperimentClaim, statement: Never | Sometimes, observations: Sequence[Observation], complete: bool
) -> DecidedClaim:
    meant = [seen for seen in observations if statement.among(seen)]
    happened: list[Observation] = []
    open_: list[Observation] = []
    for seen in meant:
        happens = statement.happens(seen)
        if happens is None:
            open_.append(seen)
        elif happens:
            happened.append(seen)
    never = isinstance(statement, Never)
    if happened:
        verdict = Agreement.DISAGREES if never else Agreement.AGREES
    elif open_ or not meant or not complete:
        verdict = Agreement.UNDECIDED
    else:
        verdict = Agreement.AGREES if never else Agreement.DISAGREES
    example = min(happened or open_ or meant, key=_closeness, default=None)
    why = _why_event(never, meant, happened, open_)
    if meant and not happened and not complete:
        why += " Other flights are missing."
    return DecidedClaim(claim, verdict, why, (), len(meant) - len(open_), example)


def _why_event(never: bool, meant: Run, happened: Run, open_: Run) -> str:
    if not meant:
        return "There is no such flight."
    seeds = len(_seeds(meant))
    every = f"{_plural(len(meant), 'flight', 'flights')} with {_plural(seeds, 'seed', 'seeds')}"
    not_decided = f"; not decided in {len(open_):,}" if open_ else ""
    if happened:
        found = len(_seeds(happened))
        low, high = proportion_interval(found, seeds)
        return (
            f"{'Violated' if never else 'It happens'} in {len(happened):,} of {every}{not_decided}: with {found} of "
            f"these seeds in at least one flight, so with {_percent(low)} to {_percent(high)} of all (95 %)."
        )
    if open_:
        which = _plural(len(_seeds(open_)), "seed", "seeds")
        return f"Not decided in {len(open_):,} of {every} ({which}); in the others it does not happen."
    high = proportion_interval(0, seeds)[1]
    return (
        f"{'Not violated' if never else 'It does not happen'} in {every}. Nothing is proved by that: "
        f"{'a violation' if never else 'it'} may occur with up to {_percent(high)} of all seeds (95 %)."
    )


def _seeds(observations: Run) -> set[int]:
    return {seen.seed for seen in observations}


def _closeness(seen: Observation) -> tuple[float, int, str]:
    """Return what orders observations by their smallest separation, those with the same by seed and condition."""
    separation = seen.values["separation_m"]
    return inf if separation is None else separation, seen.seed, str(sorted(seen.labels.items()))


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def _plural(number: int, one: str, more: str) -> str:
    return f"{number:,} {one if number == 1 else more}"
