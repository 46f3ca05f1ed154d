"""Deciding claims over seeds: paired, by seeds and not by flights, whatever the order, and in honest words."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dmpc_swarm.experiments.test_claims import BY_ID, CASES, flown
from tests.margin.settings import examples

from swarmproof.campaign.decide import Agreement, decide, decide_variant
from swarmproof.campaign.statistics import proportion_interval
from swarmproof.campaign.store import Stored
from swarmproof.claims.samples import Comparison, ExperimentClaim, Never, Observation, Ordering, Sometimes, Value, read
from swarmproof.dmpc_swarm.experiments.experiments import EXPERIMENTS

AGREES, DISAGREES, UNDECIDED = Agreement.AGREES, Agreement.DISAGREES, Agreement.UNDECIDED


def claim(statement: Ordering | Never | Sometimes) -> ExperimentClaim:
    """Return a claim with this statement."""
    return ExperimentClaim("made-up", "none", "It is so.", "nowhere", "As it stands.", statement)


def ordering(number: int = 1, needed: int = 1) -> ExperimentClaim:
    """Return a claim that in so many places ``fast`` takes less time than ``slow``."""
    comparisons = (
        Comparison(f"place {i}", read("time_s", how="fast", place=i), read("time_s", how="slow", place=i))
        for i in range(number)
    )
    return claim(Ordering(tuple(comparisons), needed))


def pair(seed: int, fast: Value, slow: Value, place: int = 0) -> list[Observation]:
    """Return one run, or one place in it."""
    return [
        Observation(seed, {"how": how, "place": place}, {"time_s": time})
        for how, time in (("fast", fast), ("slow", slow))
    ]


def places(*as_said: int, seeds: int = 20) -> list[Observation]:
    """Return so many seeds; at each place the first ones are as said, the others reversed."""
    return [
        seen
        for seed in range(seeds)
        for place, count in enumerate(as_said)
        for seen in (pair(seed, 1.0, 2.0, place) if seed < count else pair(seed, 2.0, 1.0, place))
    ]


def event(seed: int, happens: bool | None, separation: float = 0.25, start: int = 0) -> Observation:
    """Return a flight in which something happens, or not, or perhaps."""
    return Observation(seed, {"start": start}, {"happens": happens, "separation_m": separation})


def happens(seen: Observation) -> bool | None:
    """Return what was observed."""
    truth = seen.values["happens"]
    return None if truth is None else bool(truth)


NEVER, SOMETIMES = claim(Never(lambda seen: True, happens)), claim(Sometimes(lambda seen: True, happens))


def test_what_is_compared_has_the_same_seed() -> None:
    """Seeds may differ far more than conditions do: within each seed the order is plain, across seeds it is not."""
    noise = random.Random(3)
    levels = [noise.uniform(0, 1000) for _ in range(20)]
    paired = [seen for seed, level in enumerate(levels) for seen in pair(seed, level, level + 0.2)]
    decided = decide(ordering(), paired)
    assert decided.verdict is AGREES
    assert decided.compared[0].as_said == 20
    assert decided.compared[0].difference == pytest.approx((0.2, 0.2, 0.2))
    noise.shuffle(levels)
    across = [
        seen
        for seed, (fast, slow) in enumerate(zip(levels, levels[1:] + levels[:1], strict=True))
        for seen in pair(seed, fast, slow + 0.2)
    ]
    assert decide(ordering(), across).verdict is UNDECIDED


@pytest.mark.parametrize("name", CASES)
@examples(10)
@given(chance=st.randoms(use_true_random=False))
def test_the_order_of_observations_does_not_matter(name: str, chance: random.Random) -> None:
    """Shuffled, the same is decided for the same reason, by the same example."""
    for flights in (CASES[name].agrees, CASES[name].undecided):
        shuffled = list(flights)
        chance.shuffle(shuffled)
        assert decide(BY_ID[name], shuffled) == decide(BY_ID[name], flights)


def test_enough_comparisons_agree_or_too_many_are_reversed() -> None:
    """Three of four are needed: three as said agree, two reversed disagree, what is between them is undecided."""
    four = ordering(4, 3)
    assert decide(four, places(20, 20, 20, 0)).verdict is AGREES
    assert decide(four, places(20, 20, 0, 0)).verdict is DISAGREES
    assert decide(four, places(20, 20, 10, 0)).verdict is UNDECIDED
    assert decide(four, places(20, 20, 10, 10)).verdict is UNDECIDED


def test_comparisons_of_one_claim_share_the_doubt() -> None:
    """15 of 20 (4.1 % by chance, in either direction) are enough for one comparison, and for each if all are needed.

    Where three of four are needed two must be wrong for the claim to be: these share the doubt, and 16 are enough.
    Against all four, one reversed is enough, and has to be so in spite of four chances; against three, three chances.
    """
    assert decide(ordering(), places(15)).verdict is AGREES
    assert decide(ordering(), places(5)).verdict is DISAGREES
    assert decide(ordering(), places(14)).verdict is UNDECIDED
    assert decide(ordering(4, 4), places(14, 20, 20, 20)).verdict is UNDECIDED
    assert decide(ordering(4, 4), places(15, 20, 20, 20)).verdict is AGREES
    assert decide(ordering(4, 3), places(15, 20, 20, 10)).verdict is UNDECIDED
    assert decide(ordering(4, 3), places(16, 20, 20, 10)).verdict is AGREES
    assert decide(ordering(4, 4), places(5, 20, 20, 20)).verdict is UNDECIDED
    assert decide(ordering(4, 4), places(4, 20, 20, 20)).verdict is DISAGREES
    assert decide(ordering(4, 3), places(5, 4, 20, 20)).verdict is UNDECIDED
    assert decide(ordering(4, 3), places(4, 4, 20, 20)).verdict is DISAGREES


def test_two_seeds_decide_no_order() -> None:
    """However clear it looks; the reason says how many it takes."""
    decided = decide(ordering(4, 4), places(2, 2, 2, 2, seeds=2))
    assert decided.verdict is UNDECIDED
    assert "Fewer than 6 seeds" in decided.why


def test_a_seed_without_all_its_flights_is_left_out_and_counted() -> None:
    """A comparison uses the runs that have both numbers; so does each for itself."""
    flights = [seen for seen in places(12, 12, seeds=12) if seen.seed or seen.labels != {"how": "slow", "place": 1}]
    decided = decide(ordering(2, 2), flights)
    assert [(one.seeds, one.as_said, one.missing) for one in decided.compared] == [(12, 12, 0), (11, 11, 1)]
    assert decided.verdict is AGREES
    assert decided.observed == 12
    assert "1 seed is left out" in decided.why


def test_what_is_not_known_counts_for_neither_side() -> None:
    """A time that is not there on both sides is a tie, nan is not known; both stay among the seeds."""
    unknown = [seen for seed in range(8) for seen in pair(seed, float("nan"), 1.0)]
    known = [seen for seed in range(8, 16) for seen in pair(seed, 1.0, None)]
    decided = decide(ordering(), unknown + known)
    assert decided.verdict is UNDECIDED
    (one,) = decided.compared
    assert (one.seeds, one.as_said, one.reversed, one.undefined) == (16, 8, 0, 8)
    assert "8 of 16 (8 not known)" in decided.why


@pytest.mark.parametrize("statement", [ordering(), NEVER, SOMETIMES])
def test_without_flights_nothing_is_decided(statement: ExperimentClaim) -> None:
    """No claim agrees, or disagrees, with nothing."""
    decided = decide(statement, [])
    assert (decided.verdict, decided.observed, decided.example) == (UNDECIDED, 0, None)
    assert "There is no" in decided.why


@examples(100)
@given(st.lists(st.sampled_from((True, False, None)), min_size=1, max_size=9))
def test_one_case_is_certain_and_no_doubt_is_passed_over(found: list[bool | None]) -> None:
    """One case decides; none does if nothing is left open; "never" and "sometimes" are each other's opposite."""
    flights = [event(seed, truth) for seed, truth in enumerate(found)]
    never, sometimes = decide(NEVER, flights).verdict, decide(SOMETIMES, flights).verdict
    if True in found:
        assert (never, sometimes) == (DISAGREES, AGREES)
    elif None in found:
        assert (never, sometimes) == (UNDECIDED, UNDECIDED)
    else:
        assert (never, sometimes) == (AGREES, DISAGREES)


def test_bounds_count_seeds_and_not_flights() -> None:
    """A hundred starts with each of ten seeds are ten repetitions."""
    flights = [event(seed, False, start=start) for seed in range(10) for start in range(100)]
    decided = decide(NEVER, flights)
    assert decided.observed == 1000
    high = proportion_interval(0, 10)[1]
    assert high > 0.3
    assert "1,000 flights with 10 seeds" in decided.why
    assert f"up to {100 * high:.1f} % of all seeds" in decided.why
    assert "Nothing is proved" in decided.why


def test_a_seed_counts_once_however_often_it_happens() -> None:
    """Three of 20 flights, but one of two seeds."""
    flights = [event(seed, seed == 1 and start < 3, start=start) for seed in range(2) for start in range(10)]
    low, high = proportion_interval(1, 2)
    for statement in (NEVER, SOMETIMES):
        why = decide(statement, flights).why
        assert "3 of 20 flights with 2 seeds" in why
        assert (
            f"with 1 of these seeds in at least one flight, so with {100 * low:.1f} % to {100 * high:.1f} % of all"
            in why
        )


def test_what_is_not_decided_is_said() -> None:
    """The flights that leave it open are counted, beside cases as well."""
    open_ = [event(0, None), event(0, None, start=1), event(1, False)]
    decided = decide(NEVER, open_)
    assert decided.why == "Not decided in 2 of 3 flights with 2 seeds (1 seed); in the others it does not happen."
    assert decided.observed == 1
    assert "not decided in 2" in decide(NEVER, [*open_, event(2, True)]).why


def test_the_example_is_the_closest_of_those_that_decide() -> None:
    """A case is the example even if others come closer; without one it is the closest of all."""
    near, case, nearer_case = event(0, False, 0.01), event(1, True, 0.2), event(2, True, 0.1)
    for statement in (NEVER, SOMETIMES):
        assert decide(statement, [near, case, nearer_case]).example == nearer_case
        assert decide(statement, [near, event(3, False, 0.3)]).example == near
        assert decide(statement, [near, event(3, None, 0.3)]).example == event(3, None, 0.3)


def test_only_the_flights_meant_count() -> None:
    """What happens in others does not matter."""
    meant = claim(Never(lambda seen: seen.labels["start"] == 0, happens))
    decided = decide(meant, [event(0, False), event(0, True, start=1)])
    assert (decided.verdict, decided.observed) == (AGREES, 1)


def test_flights_that_are_missing_may_show_it() -> None:
    """While some are missing, that nothing has happened decides neither "never" nor "sometimes"; a case does."""
    for statement, verdict in ((NEVER, DISAGREES), (SOMETIMES, AGREES)):
        decided = decide(statement, [event(0, False)], complete=False)
        assert decided.verdict is UNDECIDED
        assert "Other flights are missing" in decided.why
        assert decide(statement, [event(0, False), event(1, True)], complete=False).verdict is verdict


def test_a_variant_is_decided_by_its_own_cells_that_are_found() -> None:
    """Nothing found decides nothing; what is found of another variant does not count."""
    experiment = EXPERIMENTS["fig4"](False)
    chosen, other = experiment.variants[0], experiment.variants[1]
    assert {each.verdict for each in decide_variant(experiment, chosen, {})} == {UNDECIDED}
    bad = {cell: Stored(replace(flown(cell), collides=True), 1.0) for cell in other.cells}
    assert {each.verdict for each in decide_variant(experiment, chosen, bad)} == {UNDECIDED}
    verdicts = {each.claim.id: each.verdict for each in decide_variant(experiment, other, bad)}
    assert verdicts["fig4-recovering-safe"] is DISAGREES
    assert verdicts["fig4-ignoring-collides"] is AGREES
