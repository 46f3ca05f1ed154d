"""Which tests concern the modules whose mutants are made: the quick decisive ones, then a wider circle."""

from __future__ import annotations

_CHECKER = (
    ("tests/margin/test_check.py", "-k", "not test_no_multipliers and not test_a_mutated"),
    ("tests/margin/test_check_planes.py", "tests/margin/test_check_parts.py", "tests/margin/test_check_limits.py"),
    ("tests/margin/test_check_norm.py", "-k", "not test_no_proof and not test_a_mutated"),
)

#: By module, stage by stage, arguments of pytest. A mutant that passes a stage meets the next one.
SUITES: dict[str, tuple[tuple[str, ...], ...]] = {
    "swarmproof.dmpc_swarm.planner.accept": (
        ("tests/dmpc_swarm/planner/test_accept_rounding.py",),
        ("tests/dmpc_swarm/planner/test_accept.py",),
    ),
    "swarmproof.monitor.separation": (
        ("tests/monitor/test_separation.py",),
        ("tests/dmpc_swarm/flight/test_judge.py", "-k", "separation or late or collision"),
    ),
    "swarmproof.margin.check": _CHECKER,
    "swarmproof.margin.check_motions": _CHECKER,
    "swarmproof.margin.check_planes": _CHECKER,
    "swarmproof.margin.check_numbers": _CHECKER,
    "swarmproof.explore.recovery": (
        ("tests/explore/test_recovery.py", "-k", "not networkx and not of_the_model and not chunks"),
        ("tests/explore/test_recovery.py",),
    ),
    "swarmproof.monitor.watch": (("tests/monitor/test_watch.py",), ("tests/explore/test_search.py",)),
}

#: Modules whose mutants were not all run yet, so that nobody knows how many survive; `make mutants` does, and says so.
UNFINISHED = frozenset({"swarmproof.margin.check_motions"})
