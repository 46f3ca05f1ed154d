"""What is known of small scopes of MLR-DMPC; the matrix has more (checks/swarmproof/dmpc_swarm/matrix.toml)."""

from __future__ import annotations

from tests.systems.small import Small

SMALL = (
    Small(
        "mlr-dmpc",
        {"uavs": 2, "cus": 1},
        "guarded",
        30,
        {},
        ("lemma-1", "plans-from-truth", "recovery", "can-plan"),
    ),
    Small(
        "mlr-dmpc",
        {"uavs": 2, "cus": 1},
        "ignore-loss",
        4,
        {"lemma-1": (1, 1), "plans-from-truth": (1, 1)},
        ("recovery", "can-plan"),
    ),
)
