"""Traces can be written, read back and replayed; what is no trace, or shows something else, is refused."""

from __future__ import annotations

import copy
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS
from swarmproof.dmpc_swarm.claims.witnesses import WITNESSES
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.protocol.swarm import step
from swarmproof.dmpc_swarm.runs import Run, readings, runs_of_any_size
from swarmproof.dmpc_swarm.semantics import PRESETS, Semantics
from swarmproof.dmpc_swarm.system import swarm as scope
from swarmproof.errors import BadInput
from swarmproof.explore.decide import Decided, Result, verify
from swarmproof.trace.replay import Replay, replay
from swarmproof.trace.trace import Trace, as_builtins, decode, encode, read, record

#: A trace as plain lists and dicts, to be broken.
Plain = dict[str, Any]

SETTINGS = settings(
    max_examples=250,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)


@cache
def _result(preset: str) -> Result:
    return verify(scope(2, 2, Semantics.parse(preset)))


def _decided(preset: str) -> list[Decided]:
    return [decided for decided in _result(preset).claims if decided.trace is not None]


def _traces(preset: str) -> list[Trace]:
    of_claims = [decided.trace for decided in _result(preset).claims]
    of_witnesses = [seen.trace for seen in _result(preset).witnesses]
    return [trace for trace in of_claims + of_witnesses if trace is not None]


def _trace_of(preset: str, shows: str) -> Plain:
    plain: Plain = as_builtins(next(trace for trace in _traces(preset) if trace.shows == shows))
    return plain


def _read(data: bytes, folder: Path) -> Replay:
    path = folder / "trace.json"
    path.write_bytes(data)
    return replay(read(path))


def _refusal(data: bytes, folder: Path) -> str:
    """Return the sentence with which `data` is refused."""
    with pytest.raises(BadInput) as raised:
        _read(data, folder)
    message = str(raised.value)
    assert message
    assert "\n" not in message
    assert ". " not in message
    return message


@pytest.mark.parametrize("preset", PRESETS)
def test_traces_round_trip(preset: str, tmp_path: Path) -> None:
    """A trace that is written, read, replayed and recorded again is the same trace, byte by byte."""
    assert _traces(preset)
    for trace in _traces(preset):
        written = encode(trace)
        replayed = _read(written, tmp_path)
        assert replayed.trace == trace
        again = record(replayed.scope, trace.shows, replayed.events, loop_start=trace.loop_start)
        assert again == trace
        assert encode(again) == written


@pytest.mark.parametrize("preset", PRESETS)
def test_claims_replay_as_reported(preset: str) -> None:
    """A claim's trace replays with the reported rounds and losses, and is a violation if and only if it is reported."""
    for decided in _decided(preset):
        assert decided.trace is not None
        replayed = replay(decided.trace)
        loop_start = decided.trace.loop_start
        assert (len(replayed.events) if loop_start is None else loop_start) == decided.rounds
        assert replayed.lost_messages == decided.lost_messages
        assert replayed.claim == decided.claim
        assert replayed.is_violation == (decided.verdict is Verdict.VIOLATED)


@pytest.mark.parametrize("preset", PRESETS)
def test_every_safety_violation_has_a_trace_that_breaks_at_its_end_only(preset: str) -> None:
    """The trace of a violated safety claim breaks it in its last computation phase and in none before."""
    for decided in _result(preset).claims:
        if decided.verdict is Verdict.VIOLATED and decided.claim.is_safety:
            assert decided.trace is not None
            replayed = replay(decided.trace)
            end = len(replayed.events)
            assert [k for k in range(end + 1) if replayed.broken_at(k)] == [end]


@pytest.mark.parametrize("preset", PRESETS)
def test_witnesses_replay(preset: str) -> None:
    """The trace of a witness replays, is no violation, and its end is the first state in which the witness is seen."""
    witnesses = {witness.id: witness for witness in WITNESSES}
    for seen in _result(preset).witnesses:
        if seen.trace is None:
            continue
        replayed = replay(seen.trace)
        assert not replayed.is_violation
        if seen.id in witnesses:
            found = [witnesses[seen.id].seen_in(observe(swarm)) for swarm in replayed.states]
            assert found == [False] * len(replayed.events) + [True]


@SETTINGS
@given(runs_of_any_size(readings(), max_uavs=4, max_cus=3, max_rounds=20))
def test_any_run_is_recorded_and_replayed_step_by_step(run: Run) -> None:
    """Any run of any size under any semantics, cut where it shows something, replays through the same swarms."""
    for witness in WITNESSES:
        end = next((k for k, swarm in enumerate(run.swarms) if witness.seen_in(observe(swarm))), None)
        if end is not None:
            trace = decode(encode(run.trace(witness.id, end)), "a test")
            replayed = replay(trace)
            assert replayed.states == run.swarms[: end + 1]
            assert replayed.events == run.events[:end]


@SETTINGS
@given(runs_of_any_size(readings(), max_uavs=4, max_cus=3, max_rounds=20))
def test_a_trace_is_the_run_that_was_recorded(run: Run) -> None:
    """Any run, shown or not, is decoded from its JSON as it was recorded, and its events lead where they led."""
    trace = run.trace("lemma-1")
    assert decode(encode(trace), "a test") == trace
    assert len(trace.rounds) == len(run.events)
    for k, events in enumerate(run.events):
        assert step(run.swarms[k], events, run.semantics) == run.swarms[k + 1]


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"{",
        b"null",
        b"[]",
        b"7",
        b'"trace"',
        b"\x00\xff\xfe binary junk \x80",
        b"{}",
        b"[" * 10_000,
        b"\xef\xbb\xbf{}",
    ],
    ids=["empty", "cut", "null", "list", "number", "string", "binary", "no fields", "deep", "byte order mark"],
)
def test_what_is_not_a_trace_is_refused(data: bytes, tmp_path: Path) -> None:
    """A file that is no JSON, or JSON of something else, is refused in one sentence that names the file."""
    assert "trace.json is no trace" in _refusal(data, tmp_path)


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    """A file that does not exist, and a directory, are refused in one sentence that names them."""
    for path in (tmp_path / "missing.json", tmp_path, tmp_path / "missing" / "trace.json"):
        with pytest.raises(BadInput, match="cannot read") as raised:
            read(path)
        assert str(path) in str(raised.value)
        assert "\n" not in str(raised.value)


def _put(*where: str | int, value: object) -> Callable[[Plain], None]:
    def change(plain: Plain) -> None:
        at: Any = plain
        for step_ in where[:-1]:
            at = at[step_]
        at[where[-1]] = value

    return change


def _drop(*where: str | int) -> Callable[[Plain], None]:
    def change(plain: Plain) -> None:
        at: Any = plain
        for step_ in where[:-1]:
            at = at[step_]
        del at[where[-1]]

    return change


def _show_too_early(plain: Plain) -> None:
    plain.update(shows="can-plan", rounds=plain["rounds"][:6])  # can-plan takes 7 rounds


#: Each spoils the trace of `lemma-1` under `printed`, 2 UAVs and 2 CUs: 8 rounds, the last one with a slot conflict.
SPOILED: dict[str, tuple[Callable[[Plain], None], str]] = {
    "wrong schema": (_put("schema", value="swarmproof.trace/2"), "this version reads swarmproof.trace/1"),
    "wrong system": (_put("system", value="bvc"), "of mlr-dmpc"),
    "schema of a wrong type": (_put("schema", value=1), "$.schema"),
    "no schema": (_drop("schema"), "schema"),
    "no rounds": (_drop("rounds"), "rounds"),
    "an unknown field": (_put("weather", value="fine"), "weather"),
    "an unknown field on two lines": (_put("weath\ner", value="fine"), "weath?er"),
    "a schema on two lines": (_put("schema", value="swarm\nproof"), "swarm\\nproof"),
    "an unknown field of a round": (_put("rounds", 0, "weather", value="fine"), "weather"),
    "rounds of a wrong type": (_put("rounds", value={}), "$.rounds"),
    "a round of a wrong type": (_put("rounds", 2, value=None), "$.rounds"),
    "a loss of a wrong type": (_put("rounds", 0, "at_cus", 0, value={"lost_uavs": "0"}), "lost_uavs"),
    "a fractional decision": (_put("rounds", 0, "decided", 0, value=0.5), "decided"),
    "a negative decision": (_put("rounds", 0, "decided", 0, value=-1), "decided"),
    "a negative UAV": (_put("rounds", 0, "at_cus", 0, value={"lost_uavs": [-1]}), "lost_uavs"),
    "a negative slot": (_put("rounds", 0, "at_uavs", 0, value={"lost_slots": [-1]}), "lost_slots"),
    "no UAVs": (_put("uavs", value=0), "$.uavs"),
    "too many UAVs": (_put("uavs", value=10**30), "uavs"),
    "too many CUs": (_put("cus", value=17), "$.cus"),
    "other UAVs than told": (_put("uavs", value=3), "is not about 3 UAVs and 2 CUs"),
    "other CUs than told": (_put("cus", value=3), "is not about 2 UAVs and 3 CUs"),
    "a CU's decision missing": (_drop("rounds", 3, "decided", 1), "round 3 of the trace is not about"),
    "a CU's reception missing": (_drop("rounds", 3, "at_cus", 1), "round 3 of the trace is not about"),
    "a UAV's reception missing": (_drop("rounds", 3, "at_uavs", 1), "round 3 of the trace is not about"),
    "a UAV's adoption missing": (_drop("rounds", 3, "adopted", 1), "round 3 of the trace is not about"),
    "a decision not open": (_put("rounds", 0, "decided", 0, value=1), "round 0 of the trace cannot happen"),
    "a decision about no UAV": (_put("rounds", 0, "decided", 0, value=10**30), "round 0 of the trace cannot happen"),
    "no decision where one is due": (_put("rounds", 0, "decided", 0, value=None), "round 0 of the trace cannot happen"),
    "adoption of what is not offered": (_put("rounds", 0, "adopted", 0, value=1), "UAV 0 adopt the trajectory of CU 1"),
    "adoption of what no CU can offer": (_put("rounds", 0, "adopted", 1, value=10**30), "it receives nothing new"),
    "an unknown switch": (_put("semantics", "rejoice", value="after-reply"), "no switch 'rejoice'"),
    "an unknown value": (_put("semantics", "rejoin", value="later"), "no value 'later'"),
    "a value of a wrong type": (_put("semantics", "rejoin", value=True), "semantics"),
    "values that exclude each other": (_put("semantics", "loss_handling", value="ignore"), "needs initial=known"),
    "other semantics": (_put("semantics", "rejoin", value="after-reply"), "round"),
    "an unknown claim": (_put("shows", value="lemma-7"), "lemma-7"),
    "shows of a wrong type": (_put("shows", value=["lemma-1"]), "$.shows"),
    "another claim": (_show_too_early, "does not show can-plan"),
    "a claim that does not apply": (_put("shows", value="one-planner-per-uav"), "one-planner-per-uav"),
    "recovery without a loop": (_put("shows", value="recovery"), "no loop_start"),
    "another witness": (_put("shows", value="recovery-left"), "does not show recovery-left"),
    "no last round": (_drop("rounds", -1), "at its end the claim is true"),
    "no first round": (_drop("rounds", 0), "round"),
    "no rounds at all": (_put("rounds", value=[]), "at its end the claim is true"),
    "a loop in a safety claim's trace": (_put("loop_start", value=0), "no claim about loops"),
    "a negative loop start": (_put("loop_start", value=-1), "$.loop_start"),
}


@pytest.mark.parametrize("how", SPOILED)
def test_a_spoiled_trace_is_refused(how: str, tmp_path: Path) -> None:
    """A trace with one thing wrong is refused in one sentence that says what."""
    plain = _trace_of("printed", "lemma-1")
    _read(msgspec.json.encode(plain), tmp_path)
    spoil, mentions = SPOILED[how]
    spoil(plain)
    assert mentions in _refusal(msgspec.json.encode(plain), tmp_path)


def _lose_in_the_loop(plain: Plain) -> None:
    plain["rounds"][-1]["at_cus"][0]["lost_uavs"] = [0]


#: Each spoils the lasso of `recovery` under `printed`.
SPOILED_LOOPS: dict[str, tuple[Callable[[Plain], None], str]] = {
    "the loop starts at the end": (lambda plain: plain.update(loop_start=len(plain["rounds"])), "the trace ends after"),
    "the loop starts beyond the end": (_put("loop_start", value=10**30), "the trace ends after"),
    "the loop starts too early": (_put("loop_start", value=0), "loop"),
    "the loop loses a message": (_lose_in_the_loop, "loses messages"),
    "the loop does not close": (_drop("rounds", -1), "does not close"),
    "no loop": (_put("loop_start", value=None), "no loop_start"),
    "a safety claim": (_put("shows", value="lemma-1"), "no claim about loops"),
    "a witness": (_put("shows", value="two-entries"), "no claim about loops"),
    "an unknown claim": (_put("shows", value="lemma-7"), "lemma-7"),
}


@pytest.mark.parametrize("how", SPOILED_LOOPS)
def test_a_spoiled_loop_is_refused(how: str, tmp_path: Path) -> None:
    """A lasso that loses messages, does not close or starts nowhere is refused in one sentence that says so."""
    plain = _trace_of("printed", "recovery")
    _read(msgspec.json.encode(plain), tmp_path)
    spoil, mentions = SPOILED_LOOPS[how]
    spoil(plain)
    assert mentions in _refusal(msgspec.json.encode(plain), tmp_path)


def test_a_loop_in_which_all_run_is_refused(tmp_path: Path) -> None:
    """A loop throughout which all CUs run is refused, since it is no failure to recover."""
    plain = _trace_of("guarded", "can-plan") | {"shows": "recovery"}
    quiet = {
        "decided": [None, None],
        "at_cus": [{}, {}],
        "at_uavs": [{}, {}],
        "adopted": [None, None],
    }
    plain["loop_start"] = len(plain["rounds"])
    plain["rounds"].append(quiet)
    assert "all CUs running throughout" in _refusal(msgspec.json.encode(plain), tmp_path)


def test_two_plans_for_one_uav_are_refused(tmp_path: Path) -> None:
    """Under event_trigger=any, a round in which two CUs plan the same UAV is refused."""
    plain = _trace_of("ignore-loss", "lemma-1")
    plain["rounds"][0]["decided"] = [1, 1]
    assert "two CUs plan UAV 1" in _refusal(msgspec.json.encode(plain), tmp_path)


@pytest.mark.parametrize("number", [2, 10**30, 0], ids=["another", "huge", "sent-itself"])
@pytest.mark.parametrize("at", ["at_cus", "at_uavs"])
@pytest.mark.parametrize("what", ["lost_slots", "lost_uavs", "decoded_replies"])
def test_losing_what_is_not_sent_is_refused(what: str, at: str, number: int, tmp_path: Path) -> None:
    """Losses of messages that nobody sends, or from devices that there are not, are refused as they are in scripts."""
    plain = _trace_of("printed", "lemma-1")
    assert "at_cus" in plain["rounds"][0]
    if number == 0 and (what, at) not in {("lost_slots", "at_cus"), ("decoded_replies", "at_cus")}:
        number = 3
    reception = plain["rounds"][0][at][0]
    reception[what] = [*reception.get(what, []), number]
    said = _refusal(msgspec.json.encode(plain), tmp_path)
    assert f"round 0 of the trace cannot happen: {at[3:-1].upper()} 0 " in said
    assert f"{number}, but nothing of the kind is sent to it" in said


def test_losing_something_twice_is_refused(tmp_path: Path) -> None:
    """A message can be lost once on its way to a receiver."""
    plain = _trace_of("printed", "recovery")
    reception = next(r for one in plain["rounds"] for r in one["at_cus"] if r.get("lost_uavs"))
    reception["lost_uavs"] = reception["lost_uavs"] * 2
    assert "but that is there twice" in _refusal(msgspec.json.encode(plain), tmp_path)


JUNK = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-2, 4)
    | st.integers()
    | st.sampled_from([-(10**30), 2**63, 2**64, 10**300])
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=5)
    | st.sampled_from([claim.id for claim in CLAIMS] + [witness.id for witness in WITNESSES]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


def _places(value: Any, way: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [*([way] if way else []), *(place for key, child in inner for place in _places(child, (*way, key)))]


def _replayed_or_refused(data: bytes, folder: Path) -> str:
    """Return the sentence with which `data` is refused, or that it is replayed; any other exception is an error."""
    try:
        _read(data, folder)
    except BadInput as refused:
        return str(refused)
    return "replayed"


@SETTINGS
@given(data=st.data())
def test_a_mutated_trace_replays_or_is_refused(tmp_path: Path, data: st.DataObject) -> None:
    """Whatever parts of a trace are deleted, replaced or swapped, it replays or is refused in one sentence."""
    preset, shows = data.draw(
        st.sampled_from([("printed", "lemma-1"), ("printed", "recovery"), ("guarded", "recovery-left")])
    )
    plain = copy.deepcopy(_trace_of(preset, shows))
    for _ in range(data.draw(st.integers(1, 3))):
        way = data.draw(st.sampled_from(_places(plain)))
        change = data.draw(st.sampled_from(["delete", "junk", "copy"]))
        if change == "delete":
            _drop(*way)(plain)
        else:
            other: Any = plain
            for step_ in data.draw(st.sampled_from(_places(plain))):
                other = other[step_]
            _put(*way, value=data.draw(JUNK) if change == "junk" else copy.deepcopy(other))(plain)
    outcome = _replayed_or_refused(msgspec.json.encode(plain), tmp_path)
    assert outcome
    assert "\n" not in outcome


@SETTINGS
@given(junk=st.binary(max_size=64), at=st.integers(0, 3_000), cut=st.integers(0, 40))
def test_mutated_bytes_replay_or_are_refused(tmp_path: Path, junk: bytes, at: int, cut: int) -> None:
    """A trace in which some bytes are overwritten replays or is refused in one sentence."""
    written = encode(next(trace for trace in _traces("printed") if trace.shows == "lemma-1"))
    at = min(at, len(written))
    outcome = _replayed_or_refused(written[:at] + junk + written[at + cut :], tmp_path)
    assert outcome
