"""Loss models: which messages do not arrive in round k, drawn, timed or written down.

A loss model is a function of its own numbers, the seed and k: a flight can be flown again to the bit, and asking twice
or in another order changes nothing. What is drawn comes from Philox, a counter-based generator: its key is made of the
seed and the model, and round k begins at the counter k·2¹⁹², so that rounds share no draw and need no history.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction
from math import ceil
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from swarmproof.channel.pattern import Losses, Pairs, nothing_lost
from swarmproof.channel.script import read_script, shown
from swarmproof.semantics.switches import BadInput
from swarmproof.theorem3.numbers import read_number

__all__ = ["FORMS", "Burst", "Iid", "Jam", "LossModel", "Losses", "Recorded", "nothing_lost", "parse"]

#: What :func:`parse` reads, with an example each.
FORMS = {
    "none": "none",
    "iid:P": "iid:0.1",
    "burst:P_ENTER,P_LEAVE": "burst:0.05,0.4",
    "jam:START,ROUNDS": "jam:5,10",
    "script:FILE": "script:losses.json",
}

_WHOLE = re.compile(r"[0-9]{1,9}")


class LossModel(Protocol):
    """What a flight asks for losses."""

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k ≥ 0; equal arrays however often and in whatever order it is asked."""
        ...


class Recorded:
    """The losses of rounds 0, 1, ... as given; after the last one, and with none given, everything arrives."""

    def __init__(self, rounds: Sequence[Losses], uavs: int, cus: int) -> None:
        self._rounds = tuple(rounds)
        self._after = nothing_lost(uavs, cus)

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k."""
        return self._rounds[k] if k < len(self._rounds) else self._after


class Jam:
    """From round `start` on, for `rounds` rounds, CUs receive nothing; what they transmit is heard by all UAVs.

    A CU that has donated its slot does not hear the reply either. In a conflict the CU's message is decoded.
    """

    def __init__(self, uavs: int, cus: int, start: int, rounds: int) -> None:
        self._start, self._end = start, start + rounds
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
        return self._deaf if self._start <= k < self._end else self._quiet


class Iid:
    """Every (message, receiver) pair is lost with probability `p`, independently of all others and of other rounds.

    In a conflict, each receiver decodes the reply or the CU's message with probability 1/2, independently of the
    losses. With the same seed, whatever is lost with some p is lost with every greater p, too.
    """

    def __init__(self, uavs: int, cus: int, p: Fraction, seed: int) -> None:
        self._uavs, self._cus = uavs, cus
        self._below = _below(p)
        self._draws = _Draws(seed, tag=1)

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


class Burst:
    """Gilbert and Elliott's channel, one per receiver: in the good state it gets everything, in the bad one nothing.

    All receivers are in the good state in round 0, so nothing is lost in it. From each round to the next, a good one
    becomes bad with probability `enter` and a bad one good with probability `leave`, independently of each other; the
    share of bad rounds tends to enter / (enter + leave). In a conflict, a receiver in the good state decodes the reply
    or the CU's message with probability 1/2.
    """

    def __init__(self, uavs: int, cus: int, enter: Fraction, leave: Fraction, seed: int) -> None:
        self._uavs, self._cus = uavs, cus
        self._enter, self._leave = _below(enter), _below(leave)
        self._draws = _Draws(seed, tag=2)
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

    def _next(self) -> Pairs:
        before = self._bad[-1]
        drawn = self._drawn(len(self._bad))[: before.size]
        return np.where(before, drawn >= self._leave, drawn < self._enter)

    def _drawn(self, k: int) -> NDArray[np.uint64]:
        """One draw for the step of each receiver into round k, then the coins."""
        return self._draws.of_round(k, self._cus + self._uavs + (self._cus + self._uavs) * self._cus)


class _Draws:
    """Independent draws, uniform on the integers from 0 to 2⁵³ − 1."""

    def __init__(self, seed: int, tag: int) -> None:
        self._key = np.random.SeedSequence(seed, spawn_key=(tag,)).generate_state(2, np.uint64)

    def of_round(self, k: int, count: int) -> NDArray[np.uint64]:
        raw: NDArray[np.uint64] = np.random.Philox(key=self._key, counter=[0, 0, 0, k]).random_raw(count)
        return raw >> np.uint64(11)


def _below(p: Fraction) -> np.uint64:
    """Return how many of the 2⁵³ draws mean yes: none for p = 0, all for p = 1, else p up to 2⁻⁵³ too many."""
    return np.uint64(ceil(p * 2**53))


_HALF = _below(Fraction(1, 2))


def parse(spec: str, uavs: int, cus: int, seed: int, target_change: int = 0) -> LossModel:
    """Return the loss model that a text of one of :data:`FORMS` describes.

    Args:
        spec: probabilities as decimals or fractions, such as ``iid:0.1`` and ``burst:1/20,0.4``; rounds as integers.
        uavs: N.
        cus: M.
        seed: what everything drawn depends on, not negative.
        target_change: the round from which ``jam`` counts its START.

    Raises:
        BadInput: no such model, or numbers or a file that it cannot work with.
    """
    if seed < 0:
        raise BadInput(f"the seed must not be negative, as {seed} is")
    name, colon, rest = spec.partition(":")
    if name == "none" and not colon:
        return Recorded((), uavs, cus)
    if name == "iid" and colon:
        (p,) = _values(spec, "iid:P", rest)
        return Iid(uavs, cus, _probability(spec, "P", p), seed)
    if name == "burst" and colon:
        enter, leave = _values(spec, "burst:P_ENTER,P_LEAVE", rest)
        return Burst(uavs, cus, _probability(spec, "P_ENTER", enter), _probability(spec, "P_LEAVE", leave), seed)
    if name == "jam" and colon:
        start, rounds = _values(spec, "jam:START,ROUNDS", rest)
        return Jam(uavs, cus, target_change + _whole(spec, "START", start), _whole(spec, "ROUNDS", rounds))
    if name == "script" and rest:
        return Recorded(read_script(Path(rest), uavs, cus), uavs, cus)
    *most, last = FORMS
    raise BadInput(f"there is no loss model {shown(spec)}: choose {', '.join(most)} or {last}")


def _values(spec: str, form: str, rest: str) -> list[str]:
    values = [value.strip() for value in rest.split(",")]
    if len(values) != form.count(",") + 1 or "" in values:
        raise BadInput(f"the loss model {shown(spec)} must have the form {form}, such as {FORMS[form]}")
    return values


def _probability(spec: str, name: str, text: str) -> Fraction:
    try:
        value = read_number(text)
    except BadInput as mistake:
        raise BadInput(f"{name} of the loss model {shown(spec)}: {mistake}") from None
    if not 0 <= value <= 1:
        raise BadInput(f"{name} of the loss model {shown(spec)} is a probability: it must be between 0 and 1")
    return value


def _whole(spec: str, name: str, text: str) -> int:
    if not _WHOLE.fullmatch(text):
        raise BadInput(f"{name} of the loss model {shown(spec)} must be a whole number of rounds, 0 to 999999999")
    return int(text)
