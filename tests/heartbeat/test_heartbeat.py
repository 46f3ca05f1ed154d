"""The heartbeat protocol: what each rule is for. Without it, a claim that held is violated, by the shortest run."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from tests.quality.planting import Edit, plant

from swarmproof.claims.verdict import Verdict
from swarmproof.explore.decide import verify
from swarmproof.heartbeat import claims, protocol
from swarmproof.heartbeat.claims import CLAIMS, Observed
from swarmproof.heartbeat.protocol import PATIENCE, Heartbeat
from swarmproof.heartbeat.semantics import Semantics
from swarmproof.heartbeat.system import SYSTEM
from swarmproof.system import Scope


def broken(preset: str, uavs: int = 3) -> dict[str, tuple[int | None, int | None]]:
    """Return the claims that are violated, each with the rounds and the losses of its shortest run."""
    result = verify(Scope(SYSTEM, {"uavs": uavs}, Semantics.parse(preset)))
    assert result.fixpoint
    return {one.claim.id: (one.rounds, one.lost_messages) for one in result.claims if one.verdict is Verdict.VIOLATED}


#: By what is gone, the edit, the reading, and what is then violated in how few rounds with how few losses.
BUGS: dict[str, tuple[Edit, str, dict[str, tuple[int | None, int | None]]]] = {
    "a vote for another while the last one counts": (
        Edit(protocol, "        if node.bound > 1:  # line 6: it waits", "        if node.bound > PATIENCE:"),
        "lease",
        {"one-leader": (2, 2)},
    ),
    "a wait that is a round too short": (
        Edit(protocol, "        if node.bound > 1:  # line 6: it waits", "        if node.bound > 2:"),
        "lease",
        {"one-leader": (2, 2)},
    ),
    "votes that count for ever": (
        Edit(protocol, "max(old - 1, 0) for j, old in enumerate(node.held)", "old for j, old in enumerate(node.held)"),
        "lease",
        {"one-leader": (3, 4), "one-leads": (4, 4)},
    ),
    "half of the votes are enough": (
        Edit(protocol, "> self.count / 2", ">= self.count // 2"),
        "lease",
        {"one-leader": (3, 2), "can-take-over": (None, None)},
    ),
    "a vote is sent while it waits": (
        Edit(
            protocol,
            'self.semantics.leads == "majority" and node.bound == PATIENCE',
            'self.semantics.leads == "majority"',
        ),
        "lease",
        {"one-leader": (3, 4)},
    ),
    "two leaders are no violation": (
        Edit(claims, "if len(seen.leading) > 1 else []", "if len(seen.leading) > 2 else []"),
        "timeout",
        {"one-leader": (2, 6), "can-take-over": (None, None)},
    ),
}


@pytest.mark.parametrize("name", BUGS)
def test_without_a_rule_a_claim_is_violated(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A planted bug is found with the fewest rounds and losses; a claim that is weakened no longer finds its flaw."""
    edit, preset, expected = BUGS[name]
    assert broken(preset) != expected
    plant(edit, monkeypatch)
    assert broken(preset) == expected


@pytest.mark.parametrize("uavs", [2, 3])
def test_the_timeout_elects_two_leaders(uavs: int) -> None:
    """UAV 1 does not hear UAV 0 for PATIENCE rounds: so many rounds and losses, whatever the size of the swarm."""
    assert broken("timeout", uavs)["one-leader"] == (PATIENCE, PATIENCE)


def test_everybody_votes_for_the_lowest_uav_at_first() -> None:
    """Without any loss, UAV 0 leads after one round, and stays the leader."""
    model = Heartbeat({"uavs": 3}, Semantics.parse("lease"))
    state = model.initial()
    leading = []
    for _ in range(4):
        leading.append(model.observe(state).leading)
        sent = model.compute(state, None)
        state = model.receive(sent, next(model.events(sent, lossless=True)))
    assert leading == [(), (0,), (0,), (0,)]


@pytest.mark.parametrize(
    ("predicate", "seen"),
    [
        (claims.two_leaders, {(): False, (0,): False, (1,): False, (0, 1): True, (0, 1, 2): True}),
        (claims.one_leads, {(): False, (0,): True, (2,): True, (0, 1): False}),
        (claims.taken_over, {(): False, (0,): False, (2,): True, (1, 2): False}),
        (claims.nobody_leads, {(): True, (0,): False, (0, 1): False}),
    ],
    ids=["two leaders", "one leads", "taken over", "nobody leads"],
)
def test_predicates(predicate: Callable[[Observed], object], seen: dict[tuple[int, ...], bool]) -> None:
    """Each predicate is true of the observations that it speaks of, and of no other."""
    assert {leading: bool(predicate(Observed(leading))) for leading in seen} == seen


def test_ids_are_unique() -> None:
    """No two claims have the same id."""
    assert len({claim.id for claim in CLAIMS}) == len(CLAIMS)
