"""The certified separation of a flight: collected by period, rounded downwards only, and decided exactly at d_min."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from swarmproof.monitor import separation
from swarmproof.monitor.bernstein import Closest
from swarmproof.monitor.separation import CHUNK, Separation
from swarmproof.motion.lattice import Floats
from swarmproof.motion.pairs import Pairs

F = Fraction
#: Of squared distances, what is 1 m²: the unit of lengths below is 10⁻⁶ m.
METRE = 10**6
MICRO = F(1, METRE)


def collector(d_min: Fraction, unit: Fraction = MICRO, steps: int = 5) -> Separation:
    """Return a collector for UAVs that are all alike, with `steps` samples a second."""
    crash = Pairs(d_min, ((unit,),), np.eye(3)[None, None], ())
    lattice: Any = SimpleNamespace(crash=crash, parameters=SimpleNamespace(T_c=F(1, steps)))
    return Separation(lattice, d_min)


def still(apart: int, steps: int = 2) -> Floats:
    """Return the pieces of a period in which two UAVs stand so many units apart along x."""
    pieces = np.zeros((steps, 2, 3, 4))
    pieces[:, 1, 0] = apart
    return pieces


def passing(beside: int, at: int = 1, speed: int = 3 * METRE) -> Floats:
    """Return one step in which a UAV passes another one at `at` thirds of the step, so many units beside it."""
    pieces = np.zeros((1, 2, 3, 4))
    pieces[0, 1, 0] = (np.arange(4) - at) * (speed // 3)
    pieces[0, 1, 1] = beside
    return pieces


def lengths(random: np.random.Generator) -> Iterator[tuple[float, Fraction]]:
    """Yield squares of distances, and units whose float is above or below them."""
    for n in range(300):
        yield float(random.integers(1, 2**53)) * 2.0 ** random.integers(0, 40), F(1, 3 + 2 * n)


def test_the_separation_is_rounded_down(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever square is certified, the distance said is not above its root times the unit, exactly; nor far below.

    The square may be the exact minimum, so nothing else makes up for a distance that is rounded up.
    """
    for square, unit in lengths(np.random.default_rng(1)):
        monkeypatch.setattr(separation, "closest", lambda *_, s=square: Closest(s, s, 0, (0, 1), 0.0))
        collected = collector(F(0), unit)
        collected.add(still(1))
        said = F(collected.dip().lower)
        assert said**2 <= F(square) * unit**2 <= said**2 * (1 + F(1, 2**47))


def test_the_band_is_rounded_outwards(monkeypatch: pytest.MonkeyPatch) -> None:
    """In every step the lower bound is not above the exact distance, the upper one not below it, and both near."""
    for square, unit in lengths(np.random.default_rng(2)):
        exact = np.full(2, square)
        monkeypatch.setattr(separation, "lowest_per_step", lambda *_, e=exact: (e, e))
        collected = collector(F(0), unit)
        collected.add(still(1))
        collected.dip()
        (band,) = collected.band
        assert band.shape == (2, 2)
        for lower, upper in band:
            assert F(lower) ** 2 <= F(square) * unit**2 <= F(upper) ** 2 <= F(lower) ** 2 * (1 + F(1, 2**46))


def test_uavs_that_meet_have_no_distance() -> None:
    """Two UAVs in one place are 0 m apart, and are not kept apart; a lower bound of the square below 0 is as good."""
    collected = collector(F(1, 10))
    collected.add(still(0))
    dip = collected.dip()
    assert (dip.lower, dip.at_least) == (0.0, False)
    assert collected.band[0][:, 0].tolist() == [0.0, 0.0]


def test_periods_are_bounded_a_chunk_at_a_time() -> None:
    """A long flight's pieces do not pile up: each full chunk is bounded at once, and what is left when asked.

    Nothing is bounded twice, and the step of the closest approach counts from the start of the flight.
    """
    collected = collector(F(1, 10), steps=2)
    for _n in range(CHUNK):
        assert collected.band == []
        collected.add(still(2 * METRE))
    assert [len(band) for band in collected.band] == [2 * CHUNK]
    assert collected.dip() == collected.dip()
    assert [len(band) for band in collected.band] == [2 * CHUNK]
    collected.add(passing(METRE, at=1))
    dip = collected.dip()
    assert [len(band) for band in collected.band] == [2 * CHUNK, 1]
    assert dip.lower == pytest.approx(1, rel=1e-6)
    assert dip.time == pytest.approx((2 * CHUNK + 1 / 3) / 2, rel=1e-9)
    collected.add(still(3 * METRE))
    assert collected.dip() == dip
    # and a second approach later on that is closer
    collected.add(passing(METRE // 2, at=2))
    assert collected.dip().time == pytest.approx((2 * CHUNK + 3 + 2 / 3) / 2, rel=1e-9)


def test_of_equal_approaches_the_first_is_told() -> None:
    """An approach as close as one before does not take its place."""
    collected = collector(F(1, 10))
    collected.add(still(METRE))
    first = collected.dip()
    collected.add(still(METRE))
    assert collected.dip() == first


@pytest.mark.parametrize("d_min", [F(1), F(1, 4), F(3)])
def test_a_hair_below_d_min_is_a_violation(d_min: Fraction) -> None:
    """A minimum of one unit below d_min is below it, one of d_min exactly, or of a unit more, is not."""
    least = int(d_min * METRE)
    for beside, kept in ((least - 1, False), (least, True), (least + 1, True), (2 * least, True)):
        collected = collector(d_min)
        collected.add(still(beside))
        assert collected.dip().at_least is kept


@pytest.mark.parametrize("less", [F(1, 10**7), F(1, 10**12)])
def test_nearly_d_min_is_decided_exactly(less: Fraction) -> None:
    """A minimum that is relatively so little below d_min, or above it, is told apart."""
    unit = F(1, 2**40)
    for sign, kept in ((1, False), (-1, True)):
        collected = collector(F(still_far := 2**40) * unit * (1 + sign * less), unit)
        collected.add(still(still_far))
        assert collected.dip().at_least is kept


def test_what_is_not_told_is_neither_kept_nor_broken() -> None:
    """A minimum of exactly d_min at a third of a step leaves it open; a clear approach before or after does not."""
    open_, clear, broken = passing(METRE), still(2 * METRE), still(METRE // 2)
    for periods, kept in (
        ([open_], None),
        ([clear, open_], None),
        ([open_, clear], None),
        ([broken, open_], False),
        ([open_, broken], False),
        ([broken, clear], False),
        ([clear, broken], False),
        ([clear, clear], True),
    ):
        collected = collector(F(1))
        for pieces in periods:
            collected.add(pieces)
            assert collected.dip().uavs == (0, 1)
        assert collected.dip().at_least is kept


@pytest.mark.parametrize("uavs", [2, 4])
def test_each_pair_counts_in_its_own_scale(uavs: int) -> None:
    """Where kinds differ, the pair that comes closest is the one that does so in its own unit, however many there are.

    UAVs stand 1 m apart in a row; a distance to the last one counts half, as that has a unit of its own.
    """
    large, small = MICRO, MICRO / 2
    matrices = np.tile(np.eye(3), (2, 2, 1, 1))
    crash = Pairs(F(3, 4), ((large, small), (small, large)), matrices, (*[0] * (uavs - 1), 1))
    lattice: Any = SimpleNamespace(crash=crash, parameters=SimpleNamespace(T_c=F(1, 5)))
    for d_min, kept in ((F(1, 2), True), (F(1, 2) + small, False)):
        collected = Separation(lattice, d_min)
        pieces = np.zeros((2, uavs, 3, 4))
        pieces[:, :, 0] = METRE * np.arange(uavs)[:, None]
        collected.add(pieces)
        dip = collected.dip()
        assert dip.uavs == (uavs - 2, uavs - 1)
        assert dip.lower == pytest.approx(1 / 2)
        assert dip.at_least is kept


def test_an_interruption_loses_no_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the bounds of a chunk are interrupted, they are made anew when asked again."""

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    collected = collector(F(1, 10))
    collected.add(still(METRE))
    with monkeypatch.context() as patched:
        patched.setattr(separation, "closest", interrupted)
        with pytest.raises(KeyboardInterrupt):
            collected.dip()
    assert collected.dip().lower == pytest.approx(1)
    assert [len(band) for band in collected.band] == [2]
