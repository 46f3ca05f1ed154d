"""Decides steps on the sample grid, for every horizon H at once, and refutes them by positions at samples.

A nominal system that the paper allows, the single integrator with one velocity per T_c, takes any positions at samples:
so a sample that a step needs and is not given refutes it, two UAVs on a line being its counterexample.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from swarmproof.algebra.grid import Range, Step

#: Horizons that are tried for a counterexample.
TRIED = 8


@dataclass(frozen=True, slots=True)
class Covered:
    """A proof of a step: the given ranges, in the order in which they cover what is needed; at last, maybe, rest."""

    names: tuple[str, ...]
    at_rest: bool

    def fault(self, step: Step) -> str | None:
        """Return why this does not prove `step`; None if it does, for every horizon."""
        given = {each.name: each for each in step.given}
        cursor = step.needed.first
        for name in self.names:
            if name not in given:
                return f"{name!r} is not given"
            each = given[name]
            if not each.first.never_after(cursor, step.least_horizon):
                return f"{name} may begin after sample {cursor}"
            cursor = each.last.plus(1)
        if not self.at_rest:
            covered = step.needed.last.plus(1).never_after(cursor, step.least_horizon)
            return None if covered else f"samples after {cursor} may be left"
        if step.rest is None:
            return "rest is not assumed"
        if not self.names:
            return "nothing is given at rest"
        resting = given[self.names[-1]]
        # the last sample of a range is given only if there is one, for every H
        if not resting.first.never_after(resting.last, step.least_horizon):
            return f"{resting.name} may be empty"
        at_end = step.rest.never_after(resting.last, step.least_horizon)
        return None if at_end else "the last given sample may be before rest"


@dataclass(frozen=True, slots=True)
class Line:
    """A counterexample to a step: UAV i stays at 0 on a line, UAV j is at these places, in units of d̂_min.

    Attributes:
        horizon: H.
        places: by sample, where j is; it is between, or rests, where nothing else is said.
    """

    horizon: int
    places: Mapping[int, int]

    def fault(self, step: Step) -> str | None:
        """Return why this does not refute `step`; None if it does."""
        if self.horizon < step.least_horizon:
            return f"H is at least {step.least_horizon}"
        for each in (*step.given, step.needed):
            for sample in samples(each, self.horizon):
                if sample not in self.places:
                    return f"no place at sample {sample}"
        if step.rest is not None:
            rest = step.rest.at(self.horizon)
            if len({place for sample, place in self.places.items() if sample >= rest}) > 1:
                return f"UAV j moves after sample {rest}, when it is at rest"
        for each in step.given:
            for sample in samples(each, self.horizon):
                if abs(self.places[sample]) < 1:
                    return f"too close at sample {sample}, which {each.name} forbids"
        close = [sample for sample in samples(step.needed, self.horizon) if abs(self.places[sample]) < 1]
        return None if close else "apart at all samples that are needed"


def samples(span: Range, horizon: int) -> range:
    """Return the samples of a range for one H."""
    return range(span.first.at(horizon), span.last.at(horizon) + 1)


def decide_step(step: Step) -> Covered | Line | None:
    """Return a proof of the step, or a counterexample with the least H; None if neither was found."""
    proof = _cover(step)
    if proof.fault(step) is None:
        return proof
    for horizon in range(step.least_horizon, step.least_horizon + TRIED):
        line = _line(step, horizon)
        if line.fault(step) is None:
            return line
    return None


def _cover(step: Step) -> Covered:
    """Return the cover that always takes the given range which begins in time and ends last, and rest if it helps."""
    names: list[str] = []
    cursor = step.needed.first
    while True:
        begun = [
            each for each in step.given if each.name not in names and each.first.never_after(cursor, step.least_horizon)
        ]
        # one sample at rest is enough
        until_rest = [
            each
            for each in begun
            if step.rest
            and step.rest.never_after(each.last, step.least_horizon)
            and each.first.never_after(each.last, step.least_horizon)
        ]
        if until_rest:
            return Covered((*names, until_rest[0].name), at_rest=True)
        reaching = [each for each in begun if cursor.plus(-1).never_after(each.last, step.least_horizon)]
        if not reaching:
            return Covered(tuple(names), at_rest=False)
        best = max(reaching, key=lambda each: (each.last.b, each.last.a))
        names.append(best.name)
        cursor = best.last.plus(1)


def _line(step: Step, horizon: int) -> Line:
    """Return UAV j's places: away where that is given, at UAV i's place elsewhere."""
    spans = [set(samples(each, horizon)) for each in (*step.given, step.needed)]
    given = set().union(*spans[:-1])
    every = set().union(*spans)
    rest = None if step.rest is None else step.rest.at(horizon)
    away = rest is not None and any(sample >= rest for sample in given)
    places = {
        sample: int(sample in given or (rest is not None and sample >= rest and away)) for sample in sorted(every)
    }
    return Line(horizon, places)
