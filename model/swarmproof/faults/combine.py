"""Loss models made of others: within some rounds, on some links, and sums."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarmproof.errors import BadInput
from swarmproof.faults.losses import FOREVER, TermModel
from swarmproof.faults.pattern import BySender, Losses, Pairs, everything_lost, nothing_lost

_END = r"\*|(?:cu|uav)(?:\*|0|[1-9][0-9]{0,8})"
_LINK = re.compile(rf"({_END})(?:\s*(->|<->)\s*({_END}))?")


class Everything:
    """Everything is lost in every round."""

    span = range(FOREVER)

    def __init__(self, uavs: int, cus: int) -> None:
        self._all = everything_lost(uavs, cus)

    def losses(self, k: int) -> Losses:
        """Return that everything is lost."""
        return self._all

    def has_coins(self, k: int) -> bool:
        """Return False: nothing is decoded."""
        return False


class Windowed:
    """What `model` loses in the rounds of `window`, drawn as without it; in all others everything arrives."""

    def __init__(self, model: TermModel, window: range, uavs: int, cus: int) -> None:
        self._model, self._window = model, window
        self._outside = nothing_lost(uavs, cus)
        self.span = range(max(window.start, model.span.start), min(window.stop, model.span.stop))

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k."""
        return self._model.losses(k) if self._is_open(k) else self._outside

    def has_coins(self, k: int) -> bool:
        """Return whether the window is open in round k, and the model has coins then."""
        return self._is_open(k) and self._model.has_coins(k)

    def _is_open(self, k: int) -> bool:
        return self._window.start <= k < self._window.stop


@dataclass(frozen=True)
class Links:
    """Who does not reach whom.

    Attributes:
        from_uavs: (M + N, N), whether UAV i's messages to the receiver are meant; rows are CUs, then UAVs.
        from_cus: (M + N, M), the same of CU s.
    """

    from_uavs: Pairs
    from_cus: Pairs

    @classmethod
    def read(cls, text: str, uavs: int, cus: int) -> Links | None:
        """Return the links that a text names, such as ``cu0->uav*``, ``uav2`` (to all) or ``uav1<->*`` (both ways).

        None if it has no such form.

        Raises:
            BadInput: there is no such CU or UAV.
        """
        found = _LINK.fullmatch(text.strip())
        if found is None:
            return None
        one, arrow, other = found[1], found[2] or "->", found[3] or "*"
        there, back = (_members(end, uavs, cus) for end in (one, other))
        links = np.outer(back, there)
        if arrow == "<->":
            links |= np.outer(there, back)
        return cls(links[:, cus:], links[:, :cus])


def _members(end: str, uavs: int, cus: int) -> Pairs:
    """Return (M + N,): which CUs and UAVs one end of a link names."""
    kind = end.rstrip("*0123456789")
    number = end.removeprefix(kind)
    names = [("cu", n) for n in range(cus)] + [("uav", n) for n in range(uavs)]
    found = np.array([kind in ("", of) and number in ("*", str(n)) for of, n in names])
    if not found.any():
        raise BadInput(f"there is no {end}: the last one is {kind}{(cus if kind == 'cu' else uavs) - 1}")
    return found


class Linked:
    """What `model` loses of the messages on some links; on all others everything arrives."""

    def __init__(self, model: TermModel, links: Links) -> None:
        self._model, self._links = model, links
        self._cus = links.from_cus.shape[1]
        self.span = model.span

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k; in slots, it depends on who sends."""
        lost, links, cus = self._model.losses(k), self._links, self._cus
        in_slots = np.concatenate([lost.cu_slot, lost.uav_slot])
        replies = in_slots[:, :, np.newaxis] & links.from_uavs[:, np.newaxis, :]
        return Losses(
            lost.cu_uav & links.from_uavs[:cus],
            np.zeros_like(lost.cu_slot),
            np.zeros_like(lost.uav_slot),
            lost.replies_at_cus,
            lost.replies_at_uavs,
            by_sender=BySender(in_slots & links.from_cus, replies),
        )

    def has_coins(self, k: int) -> bool:
        """Return whether the model has coins in round k: they are those of all links."""
        return self._model.has_coins(k)


class Sum:
    """What is lost by any of its terms.

    In a conflict, coins are those of the first term that has coins in that round; without any, the CU's message is
    decoded.
    """

    def __init__(self, terms: Sequence[TermModel], uavs: int, cus: int) -> None:
        self._terms = tuple(terms)
        self._quiet = nothing_lost(uavs, cus)

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k."""
        lost = [term.losses(k) for term in self._terms]
        coins = next((one for term, one in zip(self._terms, lost, strict=True) if term.has_coins(k)), self._quiet)
        senders = [one.by_sender for one in lost if one.by_sender is not None]
        by_sender = None
        if senders:
            by_sender = BySender(_any([one.of_cus for one in senders]), _any([one.of_uavs for one in senders]))
        return Losses(
            _any([one.cu_uav for one in lost]),
            _any([one.cu_slot for one in lost]),
            _any([one.uav_slot for one in lost]),
            coins.replies_at_cus,
            coins.replies_at_uavs,
            by_sender=by_sender,
        )


def _any(arrays: Sequence[Pairs]) -> Pairs:
    found: Pairs = np.logical_or.reduce(arrays)
    return found
