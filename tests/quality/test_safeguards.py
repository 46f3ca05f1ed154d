"""Safeguards that soundness rests on: without each of them, a test fails in which the answer is really wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import pytest
from tests.dmpc_swarm.planner import test_accept_rounding
from tests.explore import test_recovery
from tests.margin import test_check_planes
from tests.monitor import test_separation, test_watch
from tests.quality.planting import Edit, plant

from swarmproof.dmpc_swarm import rounds
from swarmproof.dmpc_swarm.planner import accept
from swarmproof.explore import recovery
from swarmproof.margin import check_planes
from swarmproof.monitor import separation


@dataclass(frozen=True)
class Safeguard:
    """A line without its safeguard, and the test that fails then; `patches` says whether that takes a monkeypatch."""

    name: str
    edit: Edit
    test: Callable[..., None]
    patches: bool = False


SAFEGUARDS = (
    Safeguard(
        "acceptance without the slack for the rounding of the products",
        Edit(
            accept,
            'slack = 8 * ROUNDOFF * np.einsum("nhx->nh", np.abs(products)) + 20 * ROUNDOFF * right',
            "slack = 20 * ROUNDOFF * right",
        ),
        partial(test_accept_rounding.test_products_that_cancel_do_not_let_a_plan_out, selected=False),
    ),
    Safeguard(
        "the certified separation rounded up",
        Edit(separation, "return value * (1 - 2.0**-50)", "return value * (1 + 2.0**-50)"),
        test_separation.test_the_separation_is_rounded_down,
        patches=True,
    ),
    Safeguard(
        "the certified separation rounded to nearest",
        Edit(separation, "return value * (1 - 2.0**-50)", "return value"),
        test_separation.test_the_separation_is_rounded_down,
        patches=True,
    ),
    Safeguard(
        "the certificates' densities with the average of their signed rates",
        Edit(check_planes, "(abs(first) + abs(last)) / 2", "abs(first + last) / 2"),
        partial(test_check_planes.test_a_density_costs_the_sizes_of_its_rates, sign=1),
    ),
    Safeguard(
        "the worst recovery by the first way that is found",
        Edit(recovery, "longest[m] = max(longest[m], longest[n] + 1)", "longest[m] = longest[m] or longest[n] + 1"),
        test_recovery.test_of_two_ways_the_longer_one_counts,
        patches=True,
    ),
    Safeguard(
        "the memo of claims per UAV without the CUs' states",
        Edit(rounds, "rest = self.outline(key)", "rest = 0"),
        partial(test_watch.test_the_first_states_are_those_of_reading_everything, real=False),
    ),
)


@pytest.mark.parametrize("safeguard", SAFEGUARDS, ids=lambda safeguard: safeguard.name)
def test_without_a_safeguard_a_test_fails(safeguard: Safeguard, monkeypatch: pytest.MonkeyPatch) -> None:
    """The test fails with the safeguard gone, by an answer that is wrong: not by an error."""
    plant(safeguard.edit, monkeypatch)
    with pytest.raises(AssertionError):
        safeguard.test(**({"monkeypatch": monkeypatch} if safeguard.patches else {}))
