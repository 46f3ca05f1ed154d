"""What `swarmproof reproduce` says, in words and as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from math import isfinite

from swarmproof.campaign.decide import Agreement, DecidedClaim
from swarmproof.campaign.provenance import made_by
from swarmproof.campaign.store import Store, Stored
from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import Never
from swarmproof.dmpc_swarm.experiments.experiment import Experiment
from swarmproof.dmpc_swarm.experiments.measure import RADII, REACHED, Measured

FORMAT = "swarmproof.reproduction/1"
#: s of processor time for a round, where nothing was measured yet.
ROUND_S = 0.005


def before(
    experiment: Experiment, there: Mapping[Cell, Stored], missing: Sequence[Cell], store: Store, processes: int
) -> Iterator[str]:
    """Yield what is to be flown, and how long it will take."""
    everything = f"{experiment.title}: {len(experiment.cells):,} flights"
    if not missing:
        yield f"{everything}, all of which are there."
        return
    flown = sum(stored.measured.rounds for stored in there.values())
    per_round = sum(stored.seconds for stored in there.values()) / flown if flown else ROUND_S
    left = per_round * sum(cell.rounds for cell in missing) / min(processes, len(missing))
    known = f"{len(there):,} are there, {len(missing):,} missing" if there else "none of which is there"
    each = "1 process" if processes == 1 else f"{processes} processes"
    yield f"{everything}, {known}: about {duration(left)} with {each}."
    outdated, wrong = store.uncounted(missing)
    if outdated:
        yield f"{outdated:,} of them were flown by other code or versions of libraries: they are flown again."
    if wrong:
        yield f"{len(wrong):,} stored results are not believed and flown again; the first is {wrong[0]}."


def verdict(decided: DecidedClaim) -> str:
    """Return the verdict as a reader should take it: what has not happened so far is not violated, no more."""
    if not decided.observed and decided.example is None:
        return "not flown"
    never = isinstance(decided.claim.statement, Never)
    return "not violated" if never and decided.verdict is Agreement.AGREES else str(decided.verdict)


def duration(seconds: float) -> str:
    """Return a time span in words, such as ``40 s``, ``12 min`` or ``1.5 h``."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


def summary(
    experiment: Experiment, quick: bool, found: Mapping[Cell, Stored], decided: Mapping[str, Sequence[DecidedClaim]]
) -> Iterator[str]:
    """Yield what changes with our choices, and what all of it is about."""
    chosen, *others = (variant.name for variant in experiment.variants)
    base = {each.claim.id: each.verdict for each in decided[chosen]}
    for name in others:
        changed = [
            f"{each.claim.id} {each.verdict}"
            for each in decided[name]
            if each.verdict not in (base[each.claim.id], Agreement.UNDECIDED)
        ]
        if changed:
            yield f"With {name}: {', '.join(changed)}."
    seeds = len({cell.seed for cell in experiment.variants[0].cells})
    there = sum(cell in found for cell in experiment.cells)
    yield (
        f"{'A quick run, ' if quick else ''}{there:,} of {len(experiment.cells):,} flights, {seeds} seeds as chosen, "
        f"{duration(sum(stored.seconds for stored in found.values()))} of processor time. Exact tracking, our planner, "
        "our sizes of formations: what is said is about these flights."
    )


def document(
    experiment: Experiment, quick: bool, found: Mapping[Cell, Stored], decided: Mapping[str, Sequence[DecidedClaim]]
) -> str:
    """Return all verdicts as a JSON document.

    A difference has lower end, median and upper end, in the unit of what is compared, positive where it is as said;
    null stands for what is infinite or not known.
    """
    table = {
        "format": FORMAT,
        "experiment": experiment.name,
        "quick": quick,
        "flights": {"wanted": len(experiment.cells), "there": sum(cell in found for cell in experiment.cells)},
        "made_by": made_by(),
        "variants": [{"name": name, "claims": [_claim(each) for each in claims]} for name, claims in decided.items()],
    }
    return json.dumps(table, indent=1, ensure_ascii=False) + "\n"


def _claim(decided: DecidedClaim) -> dict[str, object]:
    return {
        "id": decided.claim.id,
        "verdict": str(decided.verdict),
        "why": decided.why,
        "comparisons": [
            {
                "name": one.comparison.name,
                "verdict": str(one.verdict),
                "seeds": one.seeds,
                "as_said": one.as_said,
                "reversed": one.reversed,
                "difference": [end if isfinite(end) else None for end in one.difference],
            }
            for one in decided.compared
        ],
    }


def numbers(measured: Measured) -> Iterator[str]:
    """Yield the numbers of a flight with all their digits."""
    for field in fields(Measured):
        if field.name != "legs":
            yield f"{field.name} = {getattr(measured, field.name)!r}"
    for leg in measured.legs:
        one_by_one = leg.reached[RADII.index(REACHED)]
        at_once = f"all within {RADII} m after {leg.all_within} rounds"
        yield f"targets from round {leg.begin} on: {at_once}, one by one within {REACHED} m after {one_by_one}"


def differences(old: Measured, new: Measured) -> Iterator[str]:
    """Yield which numbers of a flight have become others."""
    for field in fields(Measured):
        before_, now = getattr(old, field.name), getattr(new, field.name)
        if before_ != now:
            shown = f"{before_!r} is stored, {now!r} was measured now" if field.name != "legs" else "others are stored"
            yield f"{field.name}: {shown}"
