"""Loss models: which messages do not arrive in round k, drawn, timed or written down.

A loss model is a function of its own numbers, the seed and k: a flight can be flown again to the bit, and asking twice
or in another order changes nothing. What is drawn comes from Philox, a counter-based generator: its key is made of the
seed and the model, and round k begins at the counter k·2¹⁹², so that rounds share no draw and need no history.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import ceil
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from swarmproof.faults.pattern import Losses, Pairs, nothing_lost

__all__ = ["FOREVER", "Burst", "Iid", "Jam", "LossModel", "Losses", "Recorded", "TermModel", "nothing_lost"]

#: The end of what has no end: a round that no flight reaches.
FOREVER = 1 << 62


class LossModel(Protocol):
    """What a flight asks for losses."""

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k ≥ 0; equal arrays however often and in whatever order it is asked."""
        ...


class TermModel(LossModel, Protocol):
    """A loss model that can be a term of a sum."""

    @property
    def span(self) -> range:
        """The rounds outside of which it loses nothing, whatever is drawn."""
        ...

    def has_coins(self, k: int) -> bool:
        """Return whether it says, in round k, which of two messages in a slot is decoded."""
        ...


class Recorded:
    """The losses of rounds 0, 1, ... as given; after the last one, and with none given, everything arrives."""

    def __init__(self, rounds: Sequence[Losses], uavs: int, cus: int) -> None:
        self._rounds = tuple(rounds)
        self._after = nothing_lost(uavs, cus)
        different = set(self._rounds)  # ranges of rounds share theirs
        self._coins = any(lost.replies_at_cus.any() or lost.replies_at_uavs.any() for lost in different)
        something = {lost for lost in different if lost.count}
        losing = [k for k, lost in enumerate(self._rounds) if lost in something]
        self.span = range(losing[0], losing[-1] + 1) if losing else range(0)

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k."""
        return self._rounds[k] if k < len(self._rounds) else self._after

    def has_coins(self, k: int) -> bool:
        """Return whether in some round a reply is decoded."""
        return self._coins


class Jam:
    """From round `start` on, for `rounds` rounds, CUs receive nothing; what they transmit is heard by all UAVs.

    A CU that has donated its slot does not hear the reply either. In a conflict the CU's message is decoded.
    """

    def __init__(self, uavs: int, cus: int, start: int, rounds: int) -> None:
        self.span = range(start, start + rounds)
        self._quiet = nothing_lost(uavs, cus)
        self._deaf = Losses(
            np.ones((cus, uavs), bool),
            np.ones((cus, cus), bool),
            self._quiet.uav_slot,
            self._quiet.replies_at_cus,
            self._quiet.replies_at_uavs,
        )

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k."""
        return self._deaf if self.span.start <= k < self.span.stop else self._quiet

    def has_coins(self, k: int) -> bool:
        """Return False: it has none."""
        return False


class Iid:
    """Every (message, receiver) pair is lost with probability `p`, independently of all others and of other rounds.

    In a conflict, each receiver decodes the reply or the CU's message with probability 1/2, independently of the
    losses. With the same seed, whatever is lost with some p is lost with every greater p, too. Models with another
    `nth` draw independently of it.
    """

    def __init__(self, uavs: int, cus: int, p: Fraction, seed: int, nth: int = 0) -> None:
        self._uavs, self._cus = uavs, cus
        self._below = _below(p)
        self._draws = _Draws(seed, 1, nth)
        self.span = range(FOREVER if p else 0)

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k."""
        n, m = self._uavs, self._cus
        # three arrays of losses, then two of coins, each by rows
        at_cus, at_uavs = m * n + m * m, n * m
        drawn = self._draws.of_round(k, at_cus + at_uavs + m * m + n * m)
        lost = drawn[: at_cus + at_uavs] < self._below
        coins = drawn[at_cus + at_uavs :] < _HALF
        return Losses(
            lost[: m * n].reshape(m, n),
            lost[m * n : at_cus].reshape(m, m),
            lost[at_cus:].reshape(n, m),
            coins[: m * m].reshape(m, m),
            coins[m * m :].reshape(n, m),
        )

    def has_coins(self, k: int) -> bool:
        """Return True: it always has."""
        return True


class Burst:
    """Gilbert and Elliott's channel, one per receiver: in the good state it gets everything, in the bad one nothing.

    All receivers are in the good state in round 0, so nothing is lost in it. From each round to the next, a good one
    becomes bad with probability `enter` and a bad one good with probability `leave`, independently of each other; the
    share of bad rounds tends to enter / (enter + leave). In a conflict, a receiver in the good state decodes the reply
    or the CU's message with probability 1/2. Models with another `nth` draw independently of it.
    """

    def __init__(self, uavs: int, cus: int, enter: Fraction, leave: Fraction, seed: int, nth: int = 0) -> None:
        self._uavs, self._cus = uavs, cus
        self._enter, self._leave = _below(enter), _below(leave)
        self._draws = _Draws(seed, 2, nth)
        self.span = range(1, FOREVER if enter else 1)
        #: By round, whether each receiver (CUs first) is in the bad state, as far as was asked for.
        self._bad: list[Pairs] = [np.zeros(cus + uavs, bool)]

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k; the first time in time proportional to k."""
        n, m = self._uavs, self._cus
        while len(self._bad) <= k:
            self._bad.append(self._next())
        bad = self._bad[k][:, np.newaxis]
        coins = self._drawn(k)[m + n :] < _HALF
        return Losses(
            np.repeat(bad[:m], n, axis=1),
            np.repeat(bad[:m], m, axis=1),
            np.repeat(bad[m:], m, axis=1),
            coins[: m * m].reshape(m, m),
            coins[m * m :].reshape(n, m),
        )

    def has_coins(self, k: int) -> bool:
        """Return True: it always has."""
        return True

    def _next(self) -> Pairs:
        before = self._bad[-1]
        drawn = self._drawn(len(self._bad))[: before.size]
        return np.where(before, drawn >= self._leave, drawn < self._enter)

    def _drawn(self, k: int) -> NDArray[np.uint64]:
        """One draw for the step of each receiver into round k, then the coins."""
        return self._draws.of_round(k, self._cus + self._uavs + (self._cus + self._uavs) * self._cus)


class _Draws:
    """Independent draws, uniform on the integers from 0 to 2⁵³ − 1."""

    def __init__(self, seed: int, tag: int, nth: int) -> None:
        spawn_key = (tag, nth) if nth else (tag,)
        self._key = np.random.SeedSequence(seed, spawn_key=spawn_key).generate_state(2, np.uint64)

    def of_round(self, k: int, count: int) -> NDArray[np.uint64]:
        raw: NDArray[np.uint64] = np.random.Philox(key=self._key, counter=[0, 0, 0, k]).random_raw(count)
        return raw >> np.uint64(11)


def _below(p: Fraction) -> np.uint64:
    """Return how many of the 2⁵³ draws mean yes: none for p = 0, all for p = 1, else p up to 2⁻⁵³ too many."""
    return np.uint64(ceil(p * 2**53))


_HALF = _below(Fraction(1, 2))
