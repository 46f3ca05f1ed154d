"""The margin of a pair of two kinds of UAVs, from that of two equal ones with the mean bounds."""

from __future__ import annotations

from dataclasses import replace

from swarmproof.margin.bounds import Margin
from swarmproof.theorem3.delay import displacement
from swarmproof.theorem3.fleet import KindPair


def of_a_pair(found: Margin, pair: KindPair) -> Margin:
    """Return what the margin of the equal pair says of this one.

    Its upper bound holds: w = p̂_i − p̂_j keeps the sums of the bounds. Its lower one is attained only if the pair can
    share every w. In the time `delay`, the kind that flies further counts, in the pair's own scaling.
    """
    scaling, reading = pair.parameters.theta_inverse, found.problem.reading
    ways = [displacement(replace(member, theta_inverse=scaling), reading) for member in pair.members]
    flown = max(low for low, _ in ways), max(high for _, high in ways)
    return replace(found, flown=flown, attained=pair.proportional)
