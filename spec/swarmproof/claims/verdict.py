"""The verdicts: one list for every engine, from the best to the worst."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum


class Verdict(StrEnum):
    """What can be said of a claim, in the order of :func:`worst`."""

    #: After a fixpoint, a proof, or a certified bound only.
    HOLDS = "holds"
    #: One run or one flight does not break it, which proves nothing.
    NOT_VIOLATED = "not-violated"
    #: Its assumption failed, or there was nothing that it speaks of.
    NOT_APPLICABLE = "not-applicable"
    #: A limit of ours left it open: it says nothing about the paper.
    UNDECIDED = "undecided"
    VIOLATED = "violated"


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the worst of these verdicts; NOT_APPLICABLE if there are none."""
    order = list(Verdict)
    return max(verdicts, key=order.index, default=Verdict.NOT_APPLICABLE)
