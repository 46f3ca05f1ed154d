"""The plain enumeration has limits, and says when one ends it."""

from __future__ import annotations

import pytest

from swarmproof.claims.verdict import Verdict
from swarmproof.explore import enumerated
from swarmproof.explore.decide import verify
from swarmproof.explore.search import Limits
from swarmproof.heartbeat.semantics import Semantics
from swarmproof.heartbeat.system import SYSTEM
from swarmproof.system import Scope


def of(preset: str, uavs: int) -> Scope:
    """Return a scope of the heartbeat protocol, which is searched in this way."""
    return Scope(SYSTEM, {"uavs": uavs}, Semantics.parse(preset))


def test_too_many_states_end_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there is no room for more states, what holds is undecided, and why is said."""
    monkeypatch.setattr(enumerated, "MOST_STATES", 100)
    result = verify(of("lease", 3))
    assert result.stopped == "too large for this engine: more than 100 states"
    assert next(one.verdict for one in result.claims if one.claim.id == "one-leader") is Verdict.UNDECIDED


def test_a_limit_of_states_is_noticed_in_time() -> None:
    """Of half a million states, each with thousands of events, few are taken through a round after the limit."""
    result = verify(of("timeout", 4), limits=Limits(max_states=50))
    assert result.stopped == "the limit of 50 states"
    assert result.states == 50
