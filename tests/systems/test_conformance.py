"""What every system under test must do: verdicts, traces, pages, documents and random runs, from one description."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.systems.small import Small

from swarmproof.claims.claim import Always, Recovers, Witness
from swarmproof.claims.verdict import Verdict
from swarmproof.cli import main
from swarmproof.errors import BadInput
from swarmproof.explore.decide import Decided, Result, verify
from swarmproof.explore.enumerated import Enumerated
from swarmproof.explore.search import Exploration, explore
from swarmproof.falsify.walks import Walk, first_breach, perform, walk_property, walks
from swarmproof.output import ReportFolder
from swarmproof.pages.run import rounds_of
from swarmproof.pages.verification import put_result
from swarmproof.systems import PACKAGES, load
from swarmproof.trace.replay import replay
from swarmproof.trace.trace import as_builtins, decode, encode

#: By name, the small scopes of all systems.
SMALL: dict[str, Small] = {
    small.name: small for package in PACKAGES.values() for small in import_module(f"tests.{package}.known").SMALL
}
SMALLS = pytest.mark.parametrize("small", SMALL.values(), ids=SMALL)
#: A round of a system that no test looks beyond: there may be many ways for messages to get lost.
EVENTS = 300


@cache
def found(name: str) -> Result:
    """Return what is found in a small scope: explored once for all tests."""
    return verify(SMALL[name].scope())


def shown(small: Small) -> list[Decided]:
    """Return the claims of which a run was written down."""
    return [decided for decided in found(small.name).claims if decided.trace is not None]


def some_states(small: Small) -> Iterator[Any]:
    """Yield some reachable states."""
    steps = small.scope().steps()
    keys = explore(steps).keys
    yield from (steps.unpack(key) for key in keys[:: max(1, len(keys) // 12)])


def test_every_system_is_known() -> None:
    """Each system has a small scope in which something is found, and each of its claims is decided in one."""
    for name in PACKAGES:
        smalls = [small for small in SMALL.values() if small.system == name]
        assert any(small.violated for small in smalls)
        assert any(small.holds for small in smalls)
        assert load(name).name == name


@SMALLS
def test_verdicts_lengths_losses_and_states_are_the_known_ones(small: Small) -> None:
    """Each claim is violated in the fewest rounds with the fewest losses that are known, holds, or does not apply."""
    result = found(small.name)
    assert result.fixpoint
    assert result.states == small.states
    violated = [one for one in result.claims if one.verdict is Verdict.VIOLATED]
    lengths = {one.claim.id: None if one.rounds is None else (one.rounds, one.lost_messages) for one in violated}
    assert lengths == small.violated
    assert tuple(one.claim.id for one in result.claims if one.verdict is Verdict.HOLDS) == small.holds
    assert {one.verdict for one in result.claims} <= {Verdict.HOLDS, Verdict.VIOLATED, Verdict.NOT_APPLICABLE}


def ways(exploration: Exploration) -> dict[Any, tuple[int, int]]:
    """Return, by state, its depth and the fewest losses before it."""
    unpack = exploration.rounds.unpack
    return {unpack(key): (exploration.depth_of(n), exploration.losses[n]) for n, key in enumerate(exploration.keys)}


@SMALLS
def test_the_search_is_that_of_the_plain_enumeration(small: Small) -> None:
    """However a system is searched, states, depths and losses are those of taking every choice and every event."""
    scope = small.scope()
    assert ways(explore(scope.steps())) == ways(explore(Enumerated(scope.model())))


@SMALLS
def test_the_enumeration_is_that_of_a_search_without_the_engine(small: Small) -> None:
    """Depths and losses are those of a search of a few lines, level by level, that knows the port only."""
    model = small.scope().model()
    level, known, depth = {model.representative(model.initial()): 0}, dict[Any, tuple[int, int]](), 0
    while level:
        known |= {state: (depth, lost) for state, lost in level.items()}
        depth += 1
        after: dict[Any, int] = {}
        for state, lost in level.items():
            for choice in model.choices(state):
                sent = model.compute(state, choice)
                for event in model.events(sent):
                    new = model.representative(model.receive(sent, event))
                    if new not in known:
                        after[new] = min(lost + event.lost, after.get(new, lost + event.lost))
        level = after
    assert known == ways(explore(small.scope().steps()))


@SMALLS
def test_the_port_is_kept(small: Small) -> None:
    """States can be hashed; the first event loses nothing; a representative stands for itself; rounds are read back."""
    model = small.scope().model()
    for k, state in enumerate(some_states(small)):
        assert model.representative(model.representative(state)) == model.representative(state)
        assert hash(state) == hash(state)
        for choice in model.choices(state):
            sent = model.compute(state, choice)
            events = list(islice(model.events(sent), EVENTS))
            assert next(event.lost for event in events) == min(event.lost for event in events) == 0
            assert all(event.lost == 0 for event in model.events(sent, lossless=True))
            assert {model.receive(sent, event) for event in model.events(sent, lossless=True)} == {
                model.receive(sent, event) for event in model.events(sent) if event.lost == 0
            }
            for event in events[:20]:
                assert model.receive(*model.read(state, model.write(event), getattr(state, "k", k))) == model.receive(
                    sent, event
                )


@SMALLS
def test_what_is_remembered_of_states_is_enough(small: Small) -> None:
    """States with one outline agree in goals of recovery and witnesses of outlines; equal parts, in what is broken."""
    scope = small.scope()
    steps, observe, system = scope.steps(), scope.model().observe, scope.system
    goals = [one.question.goal for one in system.claims if isinstance(one.question, Recovers)]
    goals += [one.seen_in for one in system.witnesses if isinstance(one, Witness) and one.outline]
    parts = [one.question.part for one in system.claims if isinstance(one.question, Always) and one.question.part]
    of_outline, of_part = dict[Any, Any](), dict[Any, Any]()
    for key in explore(steps).keys:
        observed = observe(steps.unpack(key))
        seen = [goal(observed) for goal in goals]
        assert of_outline.setdefault(steps.outline(key), seen) == seen
        for i, part in enumerate(steps.parts(key)):
            broken = [bool(about(observed, i)) for about in parts]
            assert of_part.setdefault(part, broken) == broken
    whole = [one for one in system.claims if isinstance(one.question, Always) and one.question.part]
    for state in some_states(small):
        observed = observe(state)
        for claim in whole:
            assert isinstance(claim.question, Always)
            assert claim.question.part is not None
            numbers = range(len(steps.parts(steps.pack(state))))
            found_in_parts = [one for i in numbers for one in claim.question.part(observed, i)]
            assert not numbers or list(claim.question.broken(observed)) == found_in_parts


@SMALLS
def test_traces_are_written_read_and_replayed(small: Small) -> None:
    """Each run is read back as it was written, and replays with its rounds, its losses and what it shows."""
    assert shown(small)
    for decided in shown(small):
        assert decided.trace is not None
        again = decode(encode(decided.trace), "a test")
        assert again == decided.trace
        replayed = replay(again)
        loop = again.loop_start
        assert (len(replayed.events) if loop is None else loop) == decided.rounds
        assert replayed.lost_messages == decided.lost_messages
        assert replayed.is_violation == (decided.verdict is Verdict.VIOLATED)


@SMALLS
def test_the_plain_pages_tell_every_round(small: Small) -> None:
    """Of each run, the pages of any system have each round with what the nodes hold, and where a message is lost."""
    for decided in shown(small):
        assert decided.trace is not None
        replayed = replay(decided.trace)
        told = rounds_of(replayed)
        assert [one.k for one in told] == list(range(len(replayed.states)))
        assert all(row.who and row.holds for one in told for row in one.rows)
        assert all(one.rows for one in told)
        assert [bool(one.events) for one in told[:-1]] == [event.lost > 0 for event in replayed.events]
        assert bool(told[-1].broken) == (decided.claim.is_safety and replayed.is_violation)


@SMALLS
def test_spoiled_traces_are_refused(small: Small) -> None:
    """A trace of another size, reading or claim, or with a round less, is refused in one sentence."""
    for decided in shown(small):
        assert decided.trace is not None
        whole = as_builtins(decided.trace)
        size = next(iter(small.sizes))
        for change in (
            {"rounds": whole["rounds"][:-1]} if whole["rounds"] else {"shows": "nothing"},
            {"shows": "nothing"},
            {size: 0},
            {size: 10**6},
            {"weather": "fine"},
            {"semantics": {"weather": "fine"}},
            {"loop_start": 10**6},
            {"system": "nothing"},
        ):
            with pytest.raises(BadInput) as refused:
                replay(decode(json.dumps(whole | change).encode(), "a test"))
            assert "\n" not in str(refused.value)


@SMALLS
def test_pages_documents_and_replay(small: Small, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A report has a page and a trace for each run; `replay` opens the trace, with the exit code of a verdict."""
    with ReportFolder(tmp_path) as report:
        put_result(report, found(small.name))
        report.publish()
    overview = (tmp_path / "index.html").read_text(encoding="utf-8")
    for decided in found(small.name).claims:
        assert decided.claim.wording in overview
    assert small.scope().system.paper in overview
    for decided in shown(small):
        page = (tmp_path / f"{decided.claim.id}.html").read_text(encoding="utf-8")
        assert f"{decided.claim.id} is" in page
        assert "Scope of this verdict" in page
        assert "http" not in page.replace("http://www.w3.org/2000/svg", "")
        code = main(["replay", str(tmp_path / f"{decided.claim.id}.trace.json")])
        assert code == (1 if decided.verdict is Verdict.VIOLATED else 0)
        assert f"{decided.claim.id} is" in capsys.readouterr().out
    document = json.loads((tmp_path / "verdicts.json").read_text(encoding="utf-8"))
    assert (document["schema"], document["system"]) == ("swarmproof.verdicts/1", small.system)
    assert {name: document[name] for name in small.sizes} == small.sizes


@SMALLS
def test_the_command(small: Small, capsys: pytest.CaptureFixture[str]) -> None:
    """`verify --system` finds the same from the command line, with the exit code of its worst verdict."""
    sizes = [word for name, number in small.sizes.items() for word in (f"--{name}", str(number))]
    code = main(["verify", "--system", small.system, *sizes, "--semantics", small.preset, "--json", "-"])
    assert code == (1 if small.violated else 0)
    document = json.loads(capsys.readouterr().out)
    assert document["exploration"]["states"] == small.states
    assert [one["id"] for one in document["claims"] if one["verdict"] == "violated"] == list(small.violated)


@pytest.mark.parametrize("name", PACKAGES)
def test_sizes_that_cannot_be_are_refused(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A size that cannot be explored, or that the system does not have, is bad input in one sentence."""
    known = {size.name: size for size in load(name).sizes}
    for option in ("uavs", "cus"):
        number = known[option].most + 1 if option in known else 2
        assert main(["verify", "--system", name, f"--{option}", str(number)]) == 2
        said = capsys.readouterr().err.strip()
        assert "\n" not in said
        assert option.upper().rstrip("S") in said.upper()


@pytest.mark.parametrize(
    ("words", "mentions"),
    [
        (["verify", "--system", "nothing"], "choose among"),
        (["verify", "--system", "heartbeat", "--matrix"], "no matrix is recorded for heartbeat"),
        (["verify", "--system", "heartbeat", "--claim", "lemma-1"], "choose among one-leader"),
        (["verify", "--system", "heartbeat", "--semantics", "guarded"], "choose timeout"),
        (["verify", "--system", "heartbeat", "--set", "leads"], "leads=majority"),
        (["claims", "--system", "nothing"], "choose among"),
    ],
    ids=["no such system", "no matrix", "another's claim", "another's preset", "no value", "claims of no such system"],
)
def test_what_a_system_does_not_have_is_bad_input(
    words: list[str], mentions: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """What another system has, or none, is refused in one sentence that says what there is."""
    assert main(words) == 2
    said = capsys.readouterr().err.strip()
    assert mentions in said
    assert "\n" not in said


@pytest.mark.parametrize("name", PACKAGES)
def test_claims_are_listed(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """`claims --system` lists every claim of a system."""
    assert main(["claims", "--system", name]) == 0
    said = capsys.readouterr().out
    for claim in load(name).claims:
        assert claim.id in said


@SMALLS
@given(data=st.data())
def test_random_runs_break_no_claim_that_holds(small: Small, data: st.DataObject) -> None:
    """Whatever is drawn, a claim that holds at the fixpoint is true in every state of the run."""
    scope = small.scope()
    walk = data.draw(walks(scope, max_rounds=8))
    walk_property(walk, scope.system.select_claims(small.holds))


def breaking(small: Small, claim: str) -> Walk:
    """Return a run that breaks a claim, from its trace: as the numbers of its choices and events."""
    scope = small.scope()
    model = scope.model()
    decided = next(one for one in found(small.name).claims if one.claim.id == claim)
    assert decided.trace is not None
    replayed, numbers, state = replay(decided.trace), list[tuple[int, int]](), model.initial()
    for after in replayed.states[1:]:
        numbers.append(
            next(
                (c, e)
                for c, choice in enumerate(model.choices(state))
                for sent in [model.compute(state, choice)]
                for e, event in enumerate(model.events(sent))
                if model.receive(sent, event) == after
            )
        )
        state = after
    return perform(scope, numbers)


@SMALLS
def test_a_random_run_that_breaks_a_claim_is_told_with_its_trace(small: Small) -> None:
    """Of a run that breaks a claim, the failure names the claim and has a trace that `replay` reads."""
    claims = [claim for claim in small.scope().system.claims if claim.is_safety and claim.id in small.violated]
    for claim in claims:
        walk = breaking(small, claim.id)
        breach = first_breach(walk.states, walk.scope.model().observe, [claim])
        assert breach is not None
        assert breach.round == (small.violated[claim.id] or (0, 0))[0]
        with pytest.raises(AssertionError) as raised:
            walk_property(walk, [claim])
        message = str(raised.value)
        assert message.startswith(f"{claim.id} is violated in the computation phase of round {breach.round}")
        assert replay(decode(message[message.index("{\n") :].encode(), "a test")).is_violation
