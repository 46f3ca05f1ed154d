"""Event triggers (Appendix A): 8-bit priorities by age (RR), distance to the target (DT) or both (HT).

The paper does not say how real numbers become 8 bits. Ages count rounds, up to 255. Distances, and their products with
ages, are put on a logarithmic scale, which keeps their order over three decades (HT: five) with a resolution of some
4 %; or, if a scenario chooses so, on a linear one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmproof.dmpc_swarm.planner.outlook import Outlook
from swarmproof.dmpc_swarm.protocol.event_trigger import JUST_RECALCULATED
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.scenario.scenario import USUAL, Choices

#: Announced for a UAV in a deadlock (Appendix A.4), and the least that is announced for any other.
DEADLOCKED = 1
LARGEST = 255
#: The logarithmic scale's ends: m for DT, m times rounds for HT. What is smaller or larger gets the end's priority. The
#: linear one begins at 0 and has the same upper end.
SHORTEST, LONGEST = 0.01, 10.0
OLDEST = 100


def priorities(
    trigger: Trigger, outlook: Outlook, ages: NDArray[np.int64], planned: int | None, choices: Choices = USUAL
) -> tuple[int, ...]:
    """Return J_iw(k) as an integer between 0 and 255 for every UAV i.

    A deadlocked UAV has priority 1 for `choices.retry` rounds, if these are not 0, and is then planned once more all
    the same: UAVs that have arrived have priority 1, too, and those of lower index would come first for ever.

    Args:
        trigger: (A1), (A2) or (A3).
        outlook: what the CU expects at the start of the round: p_i(T | (k−1)T) in the paper's terms.
        ages: k − k_calc of the first entry of each tracker, shape (N,).
        planned: the UAV whose new trajectory goes out with these priorities; it gets zero.
        choices: the scale, and when a deadlocked UAV is tried again.
    """
    ages = np.clip(ages, 1, None)
    if trigger is Trigger.RR:
        values = np.minimum(ages, LARGEST)
    elif trigger is Trigger.DT:
        values = _eight_bits(outlook.distances, LONGEST, choices)
    else:
        values = _eight_bits(outlook.distances * ages, LONGEST * OLDEST, choices)
    given_up = outlook.deadlocked if choices.retry == 0 else outlook.deadlocked & (ages <= choices.retry)
    values = np.where(given_up, DEADLOCKED, values)
    announced = [int(value) for value in values]
    if planned is not None:
        announced[planned] = JUST_RECALCULATED
    return tuple(announced)


def _eight_bits(values: NDArray[np.float64], largest: float, choices: Choices) -> NDArray[np.int64]:
    """Return `values` on the chosen scale, from 1 for :data:`SHORTEST` (linear: 0) to 255 for `largest`."""
    if choices.priority_scale == "linear":
        share = np.clip(values, 0, largest) / largest
    else:
        clipped = np.clip(values, SHORTEST, largest)
        share = np.log(clipped / SHORTEST) / np.log(largest / SHORTEST)
    return np.asarray(DEADLOCKED + np.rint((LARGEST - DEADLOCKED) * share), dtype=np.int64)
