"""The event triggers of Appendix A: by which priority a CU chooses the UAV that it plans."""

from __future__ import annotations

from enum import StrEnum


class Trigger(StrEnum):
    """The priorities that the CUs announce: by age (RR), by distance to the target (DT), or by both (HT)."""

    RR = "RR"
    DT = "DT"
    HT = "HT"
