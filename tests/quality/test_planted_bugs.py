"""The claims can fail: bugs planted into the model are found, and each by the claims and runs that are listed."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from tests.dmpc_swarm.bruteforce import plain_search
from tests.quality.bugs import BASE_STATES, BASE_STATES_ROUND_ROBIN, CAUGHT, HARMLESS, NAMED, Bug, Caught, NamedBug
from tests.quality.planting import Edit, plant

from swarmproof.claims.claim import Recovers
from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.claims.observed import ObservedSwarm
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, ProtocolClaim
from swarmproof.dmpc_swarm.protocol import algorithm1, algorithm2
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.symmetry import Abstraction
from swarmproof.dmpc_swarm.system import swarm as scope
from swarmproof.explore.decide import Decided, Result, verify
from swarmproof.explore.search import Limits
from swarmproof.trace.replay import replay
from swarmproof.trace.trace import record

ROUND_ROBIN = ("event_trigger=round-robin",)


def _marked(bugs: tuple[Bug, ...]) -> list[object]:
    return [pytest.param(bug, id=bug.name, marks=[pytest.mark.deep] if bug.slow else []) for bug in bugs]


def _verify(bug: Bug) -> Result:
    what = scope(2, 2, Semantics.parse("guarded", bug.overrides), bug.abstraction)
    return verify(what, limits=Limits(max_states=bug.max_states))


def _caught_by(result: Result) -> dict[str, Caught]:
    def length(decided: Decided) -> Caught:
        if decided.rounds is None or decided.lost_messages is None:
            return None
        return decided.rounds, decided.lost_messages

    return {d.claim.id: length(d) for d in result.claims if d.verdict is Verdict.VIOLATED}


def _worst_rounds(result: Result) -> int | None:
    return next(d.worst_rounds for d in result.claims if isinstance(d.claim.question, Recovers))


def _check(bug: Bug, result: Result) -> None:
    assert _caught_by(result) == bug.caught
    assert _worst_rounds(result) == bug.worst_rounds
    assert tuple(d.claim.id for d in result.claims if d.verdict is Verdict.UNDECIDED) == bug.undecided
    assert (result.states if result.fixpoint else None) == bug.states


@pytest.mark.parametrize(
    ("overrides", "abstraction", "states"),
    [((), Abstraction.COUNTED, BASE_STATES), (ROUND_ROBIN, Abstraction.ESSENTIAL, BASE_STATES_ROUND_ROBIN)],
    ids=["any trigger", "round-robin"],
)
def test_without_a_bug_every_claim_holds(overrides: tuple[str, ...], abstraction: Abstraction, states: int) -> None:
    """The base of all bugs violates no claim, reaches its fixpoint, and needs 9 rounds to recover at worst."""
    result = verify(scope(2, 2, Semantics.parse("guarded", overrides), abstraction))
    assert _caught_by(result) == {}
    assert result.fixpoint
    assert result.states == states
    assert _worst_rounds(result) == 9
    assert not [d for d in result.claims if d.verdict is Verdict.UNDECIDED]


@pytest.mark.parametrize("bug", _marked(CAUGHT))
def test_a_planted_bug_is_caught(bug: Bug, monkeypatch: pytest.MonkeyPatch) -> None:
    """Exactly the listed claims are violated, by shortest runs as listed, which replay on the changed model."""
    plant(bug.edit, monkeypatch)
    result = _verify(bug)
    assert bug.caught
    _check(bug, result)
    shown_traces = [decided.trace for decided in result.claims] + [seen.trace for seen in result.witnesses]
    traces = [trace for trace in shown_traces if trace is not None]
    assert len(traces) >= sum(1 for length in bug.caught.values() if length is not None)
    for trace in traces:
        replayed = replay(trace)
        length = bug.caught.get(trace.shows)
        if length is not None:
            shown = replayed.events if trace.loop_start is None else replayed.events[: trace.loop_start]
            assert (len(shown), sum(events.lost for events in shown)) == length


@pytest.mark.parametrize("bug", _marked(HARMLESS))
def test_a_harmless_change_breaks_no_claim(bug: Bug, monkeypatch: pytest.MonkeyPatch) -> None:
    """The changed line is noticed by no claim in any of the listed number of reachable states."""
    plant(bug.edit, monkeypatch)
    assert not bug.caught
    _check(bug, _verify(bug))


@pytest.mark.parametrize("bug", [pytest.param(bug, id=bug.name) for bug in NAMED])
def test_a_bug_about_names_is_caught(bug: NamedBug, monkeypatch: pytest.MonkeyPatch) -> None:
    """A search without renaming finds the shortest runs as listed, and they replay on the changed model."""
    semantics = Semantics.parse("guarded", ["initial=known"])

    def broken(claim: ProtocolClaim) -> Callable[[ObservedSwarm], bool]:
        return lambda swarm: bool(claim.broken_in(swarm))

    claims = {c.id: broken(c) for c in CLAIMS if c.is_safety and c.applies_to(semantics)}
    assert plain_search(2, 1, semantics, claims, depth=4) == {}
    plant(bug.edit, monkeypatch)
    runs = plain_search(2, 1, semantics, claims, depth=4)
    assert {claim: (len(run.events), run.lost) for claim, run in runs.items()} == bug.caught
    for claim, run in runs.items():
        assert replay(record(scope(2, 1, semantics), claim, run.events)).lost_messages == run.lost


def test_names_of_bugs_are_unique() -> None:
    """No two planted bugs have the same name or the same edit."""
    listed = (*CAUGHT, *HARMLESS)
    edits = [bug.edit for bug in listed] + [bug.edit for bug in NAMED]
    assert len({bug.name for bug in listed} | {bug.name for bug in NAMED}) == len(edits)
    assert len({(edit.module.__name__, edit.old, edit.new) for edit in edits}) == len(edits)


def test_planting_reaches_every_importer(monkeypatch: pytest.MonkeyPatch) -> None:
    """A planted line is run by modules that imported the function by name, and is gone after the test."""
    edit = Edit(algorithm2, "return _replace_contents(cu_messages, trackers)", "return _replace_contents({}, ())")
    semantics = Semantics.parse("ignore-loss")
    cu = algorithm1.initial(0, 2, 1, semantics)
    inbox = algorithm1.Inbox({}, {})
    assert algorithm1.update(cu, inbox, 1, semantics).trackers == cu.trackers
    with monkeypatch.context() as planted:
        plant(edit, planted)
        assert algorithm1.update(cu, inbox, 1, semantics).trackers == ()
    assert algorithm1.update(cu, inbox, 1, semantics).trackers == cu.trackers


@pytest.mark.parametrize("old", ["no such line", "deprecated"], ids=["missing", "several"])
def test_a_line_that_is_not_there_once_cannot_be_planted(old: str) -> None:
    """An edit of a text that the module does not have exactly once is refused, not ignored."""
    with pytest.raises(AssertionError, match="times"):
        Edit(algorithm2, old, "").mutated_source()


def test_an_edit_without_effect_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """An edit that leaves every function as it was is refused."""
    with pytest.raises(AssertionError, match="changes no function"):
        plant(Edit(algorithm2, '"""Algorithm 2 of DMPC-Swarm:', '"""Algorithm 2:'), monkeypatch)
