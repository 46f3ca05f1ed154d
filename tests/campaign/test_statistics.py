"""Intervals and tests over seeds: against sums of binomials, exact coverage, and what must be true of any numbers."""

from __future__ import annotations

from math import comb, inf, isnan, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarmproof.campaign.statistics import compare, fewest, median_interval, proportion_interval, shared

#: Small numbers with ties, and what did not happen.
TIMES = st.one_of(st.integers(0, 5).map(float), st.just(inf))
CONFIDENCES = st.sampled_from((0.8, 0.95, 0.9875, 0.999))


def mass(count: int, of: int, probability: float) -> float:
    """Return the probability of exactly so many successes."""
    return comb(of, count) * probability**count * (1 - probability) ** (of - count)


def below_half(ranks: int, number: int) -> float:
    """Return the probability that fewer than `ranks` of `number` fair coins show heads."""
    return float(sum(comb(number, i) for i in range(ranks)) / 2**number)


@given(of=st.integers(1, 60), share=st.floats(0, 1), confidence=CONFIDENCES)
def test_each_end_of_a_proportion_leaves_half_the_doubt(of: int, share: float, confidence: float) -> None:
    """At the lower end so many or more are as improbable as allowed, at the upper end so many or fewer."""
    count = round(share * of)
    low, high = proportion_interval(count, of, confidence)
    tail = (1 - confidence) / 2
    assert low <= count / of <= high
    if count == 0:
        assert low == 0
    else:
        assert sum(mass(i, of, low) for i in range(count, of + 1)) == pytest.approx(tail, rel=1e-6)
    if count == of:
        assert high == 1
    else:
        assert sum(mass(i, of, high) for i in range(count + 1)) == pytest.approx(tail, rel=1e-6)


@pytest.mark.parametrize("of", [1, 4, 10, 20])
def test_a_proportion_is_covered(of: int) -> None:
    """Whatever the probability, the interval holds it with at least the confidence, by summing over all outcomes."""
    intervals = [proportion_interval(count, of) for count in range(of + 1)]
    for probability in np.linspace(0, 1, 101):
        covered = sum(
            mass(count, of, float(probability))
            for count, (low, high) in enumerate(intervals)
            if low <= probability <= high
        )
        assert covered >= 0.95 - 1e-9


def test_a_proportion_of_nothing_is_unknown() -> None:
    """Without any trial a probability may be anything; what is no count is refused."""
    assert proportion_interval(0, 0) == (0, 1)
    for count, of in ((-1, 3), (4, 3)):
        with pytest.raises(ValueError, match="no interval"):
            proportion_interval(count, of)
    with pytest.raises(ValueError, match="no interval"):
        proportion_interval(1, 3, 1.0)


@given(number=st.integers(1, 80), confidence=CONFIDENCES)
def test_the_ends_for_a_median_are_the_innermost_that_suffice(number: int, confidence: float) -> None:
    """Of 1, 2, … the ends are k and n + 1 − k, k is as large as binomial sums allow, and infinite if there is none."""
    low, middle, high = median_interval([float(value) for value in range(1, number + 1)], confidence)
    assert middle == (number + 1) / 2
    tail = (1 - confidence) / 2
    if low == -inf:
        assert high == inf
        assert below_half(1, number) > tail
        return
    assert high == number + 1 - low
    assert below_half(int(low), number) <= tail
    assert int(low) == number // 2 or below_half(int(low) + 1, number) > tail


def test_too_few_values_say_nothing_of_the_median() -> None:
    """Five values have no interval of 95 %, six have all of their range."""
    assert median_interval([1.0, 2.0, 3.0, 4.0, 5.0]) == (-inf, 3, inf)
    assert median_interval([6.0, 5.0, 4.0, 3.0, 2.0, 1.0]) == (1, 3.5, 6)


def test_a_median_is_covered() -> None:
    """Of skewed samples, and of samples with ties, at least 95 % have the true median in their interval."""
    generator = np.random.default_rng(7)
    for number in (9, 20):
        skewed = generator.exponential(size=(600, number))
        tied = generator.integers(0, 3, size=(600, number))  # 0, 1, 2: the median is 1
        for samples, median in ((skewed, np.log(2)), (tied, 1)):
            intervals = [median_interval([float(value) for value in sample]) for sample in samples]
            covered = sum(low <= median <= high for low, _, high in intervals)
            assert covered >= 0.94 * len(samples)


def test_what_did_not_happen_is_infinitely_late() -> None:
    """Infinite values take part; a median between both infinities is not a number; nan and nothing are refused."""
    assert median_interval([1.0, 2.0, 3.0, inf, inf, inf]) == (1, inf, inf)
    assert median_interval([inf] * 7) == (inf, inf, inf)
    assert isnan(median_interval([-inf, inf])[1])
    for values in ([], [1.0, nan]):
        with pytest.raises(ValueError, match="at least one value"):
            median_interval(values)


@given(st.lists(st.tuples(TIMES, TIMES), max_size=30))
def test_every_pair_is_on_one_side_or_a_tie(pairs: list[tuple[float, float]]) -> None:
    """Pairs are counted one by one; exchanging their sides exchanges the counts and negates the differences."""
    outcome = compare(pairs)
    assert outcome.number == len(pairs)
    assert outcome.number - outcome.as_said - outcome.reversed == sum(one == other for one, other in pairs)
    back = compare([(other, one) for one, other in pairs])
    assert (back.as_said, back.reversed) == (outcome.reversed, outcome.as_said)
    if pairs and not isnan(outcome.difference[1]):
        low, middle, high = outcome.difference
        assert back.difference == (-high, -middle, -low)


@given(st.lists(st.tuples(TIMES, TIMES), min_size=1, max_size=30), CONFIDENCES)
def test_the_test_and_both_intervals_say_the_same(pairs: list[tuple[float, float]], confidence: float) -> None:
    """Mostly as said: the share's interval is above 1/2, and that of the median difference above 0; and reversed."""
    outcome = compare(pairs, confidence)
    low, _, high = outcome.difference
    above = proportion_interval(outcome.as_said, outcome.number, confidence)[0] > 0.5
    assert outcome.mostly_as_said(confidence) == above == (low > 0)
    assert outcome.mostly_reversed(confidence) == (high < 0)


@pytest.mark.parametrize("confidence", [0.8, 0.95, 0.9875])
def test_no_order_is_seldom_taken_for_one(confidence: float) -> None:
    """If both orders are equally probable, either verdict has at most the probability left, whatever the number."""
    for number in range(1, 41):
        wrong = 0.0
        for count in range(number + 1):
            outcome = compare([(0.0, 1.0)] * count + [(1.0, 0.0)] * (number - count), confidence)
            if outcome.mostly_as_said(confidence) or outcome.mostly_reversed(confidence):
                wrong += mass(count, number, 0.5)
        assert wrong <= 1 - confidence + 1e-12


def test_ties_count_for_neither_side() -> None:
    """Eight of eight suffice, but not beside eight ties, be they equal, never happened, or unknown."""
    order = [(1.0, 2.0)] * 8
    assert compare(order).mostly_as_said(0.95)
    for tie in ((3.0, 3.0), (inf, inf), (nan, 1.0)):
        outcome = compare([*order, *[tie] * 8])
        assert (outcome.as_said, outcome.reversed, outcome.number) == (8, 0, 16)
        assert not outcome.mostly_as_said(0.95)


def test_differences_of_what_did_not_happen() -> None:
    """Finite minus infinite is −∞, infinite minus infinite a tie, what is unknown has no difference."""
    assert compare([(inf, 1.0)]).difference[1] == -inf
    assert compare([(1.0, inf)]).difference[1] == inf
    assert compare([(inf, inf)]).difference[1] == 0
    outcome = compare([(nan, 1.0), (1.0, 3.0)])
    assert (outcome.undefined, outcome.difference[1]) == (1, 2)
    for nothing in (compare([]), compare([(nan, nan)])):
        assert nothing.difference[0] == -inf
        assert isnan(nothing.difference[1])
        assert not nothing.mostly_as_said(0.95)


@pytest.mark.parametrize("among", [1, 4, 8])
def test_the_fewest_pairs_that_can_decide(among: int) -> None:
    """So many pairs decide if all agree, one fewer does not; the doubt of all statements together is that of one."""
    confidence = shared(0.95, among)
    assert among * (1 - confidence) == pytest.approx(0.05)
    enough = fewest(confidence)
    assert compare([(0.0, 1.0)] * enough).mostly_as_said(confidence)
    assert not compare([(0.0, 1.0)] * (enough - 1)).mostly_as_said(confidence)
