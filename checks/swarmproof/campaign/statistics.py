"""Intervals and tests over seeds: exact or distribution-free, so that nothing is assumed of how numbers scatter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, inf, isnan, log2

# scipy.stats has these by name, and takes a second to load
from scipy.special import bdtr, bdtrc, betaincinv

CONFIDENCE = 0.95


def proportion_interval(count: int, of: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Return the exact interval of a probability (Clopper and Pearson) that came true `count` times `of` so many.

    Each side is wrong with at most half of 1 − `confidence`. Of nothing, the interval is (0, 1).

    Raises:
        ValueError: `count` is not between 0 and `of`, or `confidence` not between 0 and 1.
    """
    if not 0 <= count <= of or not 0 < confidence < 1:
        raise ValueError(f"no interval for {count} of {of} with confidence {confidence}")
    if of == 0:
        return 0.0, 1.0
    half = (1 - confidence) / 2
    low = betaincinv(count, of - count + 1, half) if count else 0.0
    high = betaincinv(count + 1, of - count, 1 - half) if count < of else 1.0
    return float(low), float(high)


def median_interval(values: Sequence[float], confidence: float = CONFIDENCE) -> tuple[float, float, float]:
    """Return lower end, median and upper end, in the unit of `values`, for the median of what they are drawn from.

    The ends are the k-th smallest and the k-th largest value, with the largest k for which the median lies beyond
    either with at most half of 1 − `confidence`, whatever the distribution. Too few values for that (fewer than 6 for
    95 %) have no such k: the ends are then −∞ and ∞. Values may be infinite, but not nan. The median of the values
    themselves is nan if half of them are −∞ and half ∞.

    Raises:
        ValueError: there are no values, one is nan, or `confidence` is not between 0 and 1.
    """
    if not values or any(map(isnan, values)) or not 0 < confidence < 1:
        raise ValueError("a median needs at least one value, none of them nan, and a confidence between 0 and 1")
    ordered = sorted(values)
    number = len(ordered)
    middle = (ordered[(number - 1) // 2] + ordered[number // 2]) / 2
    # the median is below the k-th smallest only if fewer than k of the values are below the median
    ranks = [k for k in range(1, number // 2 + 1) if bdtr(k - 1, number, 0.5) <= (1 - confidence) / 2]
    if not ranks:
        return -inf, middle, inf
    return ordered[ranks[-1] - 1], middle, ordered[number - ranks[-1]]


@dataclass(frozen=True, slots=True)
class Pairs:
    """Pairs of two numbers each, one said to be the smaller.

    Attributes:
        number: of pairs.
        as_said: in which it is smaller.
        reversed: in which it is larger.
        undefined: in which one of them is nan; they count for neither side, as ties do.
        difference: interval and median of the larger minus the smaller: positive where it is as said.
    """

    number: int
    as_said: int
    reversed: int
    undefined: int
    difference: tuple[float, float, float]

    def mostly_as_said(self, confidence: float) -> bool:
        """Say whether it is as said in more than half of all pairs that could be drawn, ties among them."""
        return _mostly(self.as_said, self.number, confidence)

    def mostly_reversed(self, confidence: float) -> bool:
        """Say the same of the opposite."""
        return _mostly(self.reversed, self.number, confidence)


def compare(pairs: Sequence[tuple[float, float]], confidence: float = CONFIDENCE) -> Pairs:
    """Return how pairs of (smaller, larger) come out.

    Two equal numbers are a tie, also two that are infinite: their difference is 0. Finite minus infinite is −∞. A pair
    with nan has no difference; without any difference, their interval is (−∞, nan, ∞).
    """
    defined = [(smaller, larger) for smaller, larger in pairs if not isnan(smaller) and not isnan(larger)]
    differences = [0.0 if smaller == larger else larger - smaller for smaller, larger in defined]
    return Pairs(
        number=len(pairs),
        as_said=sum(smaller < larger for smaller, larger in defined),
        reversed=sum(larger < smaller for smaller, larger in defined),
        undefined=len(pairs) - len(defined),
        difference=median_interval(differences, confidence) if differences else (-inf, float("nan"), inf),
    )


def shared(confidence: float, among: int) -> float:
    """Return the confidence of each of several statements with which all of them hold (Bonferroni)."""
    return 1 - (1 - confidence) / among


def fewest(confidence: float) -> int:
    """Return the fewest pairs that can show that something holds mostly: those that suffice if it holds in all."""
    return ceil(log2(2 / (1 - confidence)))


def _mostly(count: int, of: int, confidence: float) -> bool:
    """Say whether the interval of the probability lies above 1/2; that is the two-sided sign test."""
    return of > 0 and bool(_at_least(count, of) <= (1 - confidence) / 2)


def _at_least(count: int, of: int) -> float:
    """Return the probability of at least `count` heads in `of` tosses."""
    return float(bdtrc(count - 1, of, 0.5)) if count else 1.0
