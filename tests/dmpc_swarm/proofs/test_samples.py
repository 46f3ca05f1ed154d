"""The claims about index ranges: their verdicts by T/T_c, and that the ranges are those that the planner uses."""

from __future__ import annotations

import pytest
from tests.dmpc_swarm.flight.settings import lattice, samples

from swarmproof.algebra.grid import Range, Step, Time
from swarmproof.dmpc_swarm.evidence.book import EVIDENCE
from swarmproof.dmpc_swarm.proofs import samples as claims
from swarmproof.dmpc_swarm.proofs.registry import select_proof_claims
from swarmproof.prove.decide import decide
from swarmproof.prove.steps import decide_step
from swarmproof.prove.steps import samples as samples_of

#: By claim as printed, for which T/T_c of 1, 2, 3, 4 it is true.
TRUE_FOR: dict[str, list[int]] = {
    "lemma-4-samples": [],
    "lemma-4-hypothesis": [1],
    "candidate-samples": [],
    "next-round": [1],
    "theorem-2-start": [],
    "first-sample": [],
}


@pytest.mark.parametrize("name", TRUE_FOR)
def test_what_is_true_depends_on_the_ratio(name: str) -> None:
    """Each printed step is true exactly for the ratios T/T_c on record."""
    (claim,) = select_proof_claims([f"{name}/printed"])
    answers = decide(claim, EVIDENCE.get(claim.key, {})).answers
    assert [m for m, each in zip(claims.RATIOS, answers, strict=True) if each.verdict == "proved"] == TRUE_FOR[name]


@pytest.mark.parametrize("m", claims.RATIOS)
@pytest.mark.parametrize("horizon", [1, 2, 15])
def test_the_planner_checks_the_samples_of_13f(m: int, horizon: int) -> None:
    """The samples of (13f) are those of the planner: h = 0 … h_c from the start of round k+1, where h_c = mH."""
    units = lattice(samples(m), horizon=horizon)
    span = samples_of(claims.planes(m), horizon)
    assert len(span) == units.horizon * units.steps + 1
    assert span[0] == units.steps


@pytest.mark.parametrize("m", claims.RATIOS)
def test_trajectories_rest_when_the_planners_do(m: int) -> None:
    """A trajectory planned in round k is at rest H rounds after the start of round k+1, as the planner's are."""
    assert claims.rest(m, new=True).at(15) == m + 15 * m
    assert claims.rest(m).at(15) == 15 * m


@pytest.mark.parametrize("m", claims.RATIOS)
def test_a_shifted_index_is_noticed(m: int) -> None:
    """The repaired step from round to round fails if (21) ends one sample earlier, or (20) begins one earlier."""
    given = claims.repaired_21(m)
    needed = claims.next_round(claims.repaired_20(m), m)
    rest = claims.rest(m, new=True)
    assert decide_step(Step((given,), needed, rest)) is not None
    early_end = Range(given.name, given.first, given.last.plus(-1))
    late_begin = Range(given.name, needed.first.plus(1), given.last)
    for broken in (early_end, late_begin):
        found = decide_step(Step((broken,), needed, rest))
        assert found is not None
        assert type(found).__name__ == "Line"


def test_rest_is_needed() -> None:
    """Without rest, the repaired chain breaks between the rounds for every T/T_c, the published one included."""
    for m in claims.RATIOS:
        step = Step((claims.repaired_21(m),), claims.next_round(claims.repaired_20(m), m), None)
        assert type(decide_step(step)).__name__ == "Line"


def test_times_are_compared_for_every_horizon() -> None:
    """A time is never after another only if that is so for each H from the least one on."""
    assert Time(0, 1).never_after(Time(0, 2))
    assert not Time(0, 2).never_after(Time(1, 1))
    assert not Time(2, 0).never_after(Time(0, 1))
    assert Time(2, 0).never_after(Time(0, 1), least=2)
