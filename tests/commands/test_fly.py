"""`swarmproof fly`: what it prints and writes, its exit codes, and one sentence for bad input."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from swarmproof.cli import main
from swarmproof.commands import fly as command
from swarmproof.dmpc_swarm.claims.flight import FLIGHT_CLAIMS
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS
from swarmproof.dmpc_swarm.flight.exhaustive import Exhaustive, explore_flights
from swarmproof.dmpc_swarm.flight.judge import Judge
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.exit_codes import ExitCode
from swarmproof.explore.search import Limits
from swarmproof.faults.forms import COMBINED
from swarmproof.faults.losses import LossModel
from swarmproof.faults.pattern import Losses, nothing_lost
from swarmproof.formats.verdicts import ClaimJson

Json = dict[str, Any]

#: A short flight that violates nothing, and one that violates much.
FINE = ["fly", "crossing", "--rounds", "5"]
BAD = ["fly", "crossing", "--rounds", "12", "--loss", "iid:0.3", "--semantics", "ignore-loss"]
#: What was flown, and how far a single flight came.
FACTS: dict[str, tuple[type, ...]] = {
    "scenario": (dict,),
    "loss": (str,),
    "trigger": (str,),
    "semantics": (dict,),
    "defaults": (dict,),
}
LAST: dict[str, tuple[type, ...]] = {
    "last_adoption": (dict, type(None)),
    "interrupted": (bool,),
    "stopped": (str, type(None)),
}
#: The keys of the schema, in their order, and the types of their values.
KEYS: dict[str, tuple[type, ...]] = {
    "schema": (str,),
    "uavs": (int,),
    "cus": (int,),
    "rounds": (int,),
    "seed": (int,),
    "changed": (list,),
    "min_separation": (dict,),
    "qps": (dict,),
    **FACTS,
    "arrived": (bool,),
    "rounds_to_arrival": (int, type(None)),
    **LAST,
    "claims": (list,),
    "seconds": (float,),
}
CLAIM_KEYS: dict[str, tuple[type, ...]] = {
    "id": (str,),
    "verdict": (str,),
    "rounds": (int, type(None)),
    "lost_messages": (int, type(None)),
    "worst_rounds": (type(None),),
    "avoidable": (type(None),),
    "trace": (type(None),),
    "instances": (int,),
    "why": (str,),
    "round": (int, type(None)),
    "uavs": (list, type(None)),
    "cus": (list, type(None)),
    "time": (float, type(None)),
}
SAFETY = [claim.id for claim in CLAIMS if claim.is_safety]


def no_constants(name: str) -> float:
    """Refuse what JSON does not have: NaN and infinities."""
    raise ValueError(f"{name} is no JSON")


def document(capsys: pytest.CaptureFixture[str], arguments: list[str], expected: int) -> Json:
    """Run the command with `--json -`, and return the document; nothing else is on standard output."""
    code = main([*arguments, "--json", "-"])
    captured = capsys.readouterr()
    assert code == expected, captured.err
    content: Json = json.loads(captured.out, parse_constant=no_constants)
    return content


def sentence(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a command that cannot be, and return the one sentence that it says."""
    code = main(["fly", *arguments])
    captured = capsys.readouterr()
    assert code == ExitCode.BAD_INPUT
    assert captured.out == ""
    (line,) = captured.err.strip().splitlines()
    assert line.startswith("swarmproof: ")
    assert "Traceback" not in line
    return line.removeprefix("swarmproof: ")


def verdicts(content: Json) -> dict[str, str]:
    """Return the verdict of each claim."""
    return {claim["id"]: claim["verdict"] for claim in content["claims"]}


def assert_typed(content: Json, keys: dict[str, tuple[type, ...]]) -> None:
    """Assert that the object has exactly these keys, in this order, with values of exactly these types."""
    assert list(content) == list(keys)
    for key, types in keys.items():
        assert type(content[key]) in types, key


# JSON


@pytest.mark.parametrize(("arguments", "code"), [(FINE, 0), (BAD, 1)], ids=["fine", "bad"])
def test_json_has_the_keys_of_the_schema(arguments: list[str], code: int, capsys: pytest.CaptureFixture[str]) -> None:
    """The document has the published keys in their order, with their types; claims are those of `verify`, and more."""
    content = document(capsys, arguments, code)
    assert_typed(content, KEYS)
    assert content["schema"] == "swarmproof.flight/1"
    assert (content["uavs"], content["cus"], content["seed"]) == (2, 2, 0)
    assert content["rounds"] == int(arguments[3])
    assert_typed(content["min_separation"], {"sampled": (float,), "continuous_lower": (float,)})
    assert 0 < content["min_separation"]["continuous_lower"] <= content["min_separation"]["sampled"]
    assert_typed(content["qps"], {"solved": (int,), "rejected": (int,), "infeasible": (int,)})
    assert content["qps"]["solved"] > 0
    for claim in content["claims"]:
        assert_typed(claim, CLAIM_KEYS)
        assert (claim["rounds"] is None) == (claim["lost_messages"] is None) == (claim["verdict"] != "violated")
    assert [claim["id"] for claim in content["claims"]] == SAFETY + [claim.id for claim in FLIGHT_CLAIMS]
    assert set(verdicts(content).values()) == {"not-violated", "not-applicable"} | ({"violated"} if code else set())
    assert content["seconds"] > 0


def test_claims_have_the_keys_that_they_have_in_verify() -> None:
    """Claims of flights are written like claims of `verify`, and say more."""
    known = ClaimJson.__struct_fields__
    assert tuple(CLAIM_KEYS)[: len(known)] == known


def test_arrival_in_json(capsys: pytest.CaptureFixture[str]) -> None:
    """`arrived` comes with the rounds that it took; before, there are none."""
    early, late = document(capsys, FINE, 0), document(capsys, ["fly", "crossing", "--rounds", "40"], 0)
    assert (early["arrived"], early["rounds_to_arrival"]) == (False, None)
    assert late["arrived"] is True
    assert 5 < late["rounds_to_arrival"] < 40
    assert document(capsys, ["fly", "crossing", "--rounds", str(late["rounds_to_arrival"])], 0)["arrived"] is True
    assert document(capsys, ["fly", "crossing", "--rounds", str(late["rounds_to_arrival"] - 1)], 0)["arrived"] is False


def test_options_are_what_is_flown(capsys: pytest.CaptureFixture[str]) -> None:
    """Scenario, CUs, seed, rounds and parameters of the command line show in the result."""
    arguments = ["fly", "random", "--cus", "3", "--seed", "7", "--rounds", "6", "--set", "uavs=4"]
    content = document(capsys, arguments, 0)
    assert [content[key] for key in ("uavs", "cus", "seed", "rounds")] == [4, 3, 7, 6]
    # one plan a round and CU at most
    assert 0 < content["qps"]["solved"] <= 18
    by_default = document(capsys, [*arguments[:-2], "--set", "uavs=4", "--trigger", "HT", "--semantics", "guarded"], 0)
    other = document(capsys, [*arguments, "--trigger", "RR", "--seed", "8"], 0)
    assert _timeless(content) == _timeless(by_default)
    assert content["min_separation"] != other["min_separation"]


def _timeless(content: Json) -> Json:
    return {key: value for key, value in content.items() if key != "seconds"}


def test_the_baseline_is_known_to_fail(capsys: pytest.CaptureFixture[str]) -> None:
    """Ignoring losses violates what recovery keeps; a switch and the preset of that name are the same."""
    found = verdicts(document(capsys, BAD, 1))
    assert {name for name, verdict in found.items() if verdict == "violated"} >= {"lemma-1", "tracked-separation"}
    switched = [*BAD[:-2], "--set", "loss_handling=ignore", "--semantics", "printed"]
    assert verdicts(document(capsys, switched, 1)) == found
    assert "violated" not in verdicts(document(capsys, BAD[:-2], 0)).values()


def test_tracking_errors_are_a_parameter(capsys: pytest.CaptureFixture[str]) -> None:
    """With a tracking error, the claim about actual positions is asked."""
    found = verdicts(document(capsys, [*FINE, "--set", "tracking_error=0.02"], 0))
    assert found["eq-2-actual"] == "not-violated"


def test_json_goes_to_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file gets the document, and the words stay on standard output."""
    path = tmp_path / "new" / "flight.json"
    assert main([*FINE, "--json", str(path)]) == 0
    said = capsys.readouterr().out
    assert "crossing, 2 UAVs, 2 CUs, 5 rounds: no claim violated" in said
    content = json.loads(path.read_text(encoding="utf-8"), parse_constant=no_constants)
    assert _timeless(content) == _timeless(document(capsys, FINE, 0))


def test_another_process_flies_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    """In another process, with another order of sets, the flight is the same; and only JSON is on standard output."""
    arguments = ["fly", "circle", "--set", "uavs=5", "--loss", "iid:0.1", "--rounds", "8", "--json", "-"]
    environment = {**os.environ, "PYTHONHASHSEED": "12345"}
    done = subprocess.run(
        [sys.executable, "-m", "swarmproof", *arguments], capture_output=True, text=True, env=environment, check=True
    )
    assert _timeless(json.loads(done.stdout)) == _timeless(document(capsys, arguments[:-2], 0))


# Words


def test_what_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    """A flight is told in a headline, a line for each claim, its figures, and what the verdicts are about."""
    assert main(FINE) == 0
    said = " ".join(capsys.readouterr().out.split())
    for claim in FLIGHT_CLAIMS:
        # five rounds without losses are too few for some: nobody was planned beside another UAV, nor arrived
        none_of_it = claim.id in ("eq-2-actual", "lemma-3", "arrives")
        assert f"{claim.id} {'not-applicable 0' if none_of_it else 'not-violated'}" in said
    assert "Smallest scaled distance of references: 0." in said
    assert "optimization problems solved, 0 answers rejected, 0 infeasible; 0 messages lost." in said
    assert "This flight only: 5 rounds, trigger HT, loss none, seed 0; guarded, event_trigger=round-robin" in said
    assert "holds" not in said
    assert "How " not in said


#: One of each kind of what can be changed.
CHANGES = ["jitter=0.02", "assignment=shuffled", "hold=7", "jerk=0.002", "horizon=12", "retry=0", "offer=highest"]


def test_what_is_changed_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    """All that is not as published, listed or usual is in the words and in the document, so that none is unseen."""
    arguments = ["fly", "crossing", *(word for change in CHANGES for word in ("--set", change))]
    content = document(capsys, arguments, 0)
    shipped = ["workspace=-1.7,1.7,-1.7,1.7,0.4,3"]
    assert content["rounds"] == 7
    assert sorted(content["changed"]) == sorted([*shipped, "band=5", *CHANGES])
    assert document(capsys, FINE, 0)["changed"] == [*shipped, "band=5"]
    assert document(capsys, [*FINE, "--set", "band=0.5"], 0)["changed"] == shipped
    assert main(arguments) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert f"; parameters {', '.join(content['changed'])}. Samples" in said
    assert main([*arguments, "--loss", "exhaustive:1"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert f"; parameters {', '.join(content['changed'])}. Swarms" in said


def test_what_is_said_to_be_changed_flies_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    """The texts in the document are those with which `--set` flies it again."""
    first = document(capsys, [*FINE, "--set", "jitter=1e-3", "--set", "detour_noise=0.1", "--set", "T_c=0.05"], 0)
    again = document(capsys, [*FINE, *(word for change in first["changed"] for word in ("--set", change))], 0)
    assert _timeless(first) == _timeless(again)


def test_a_violation_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    """Where trajectories come too close, the chain of events is printed."""
    assert main(BAD) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "crossing, 2 UAVs, 2 CUs, 12 rounds: violated: lemma-1, lemma-2" in said
    chain = said.partition("came to be violated first:")[2]
    steps = ("Loss: in round", "Trackers: in round", "Plan: in round", "Closest approach: at")
    places = [chain.find(step) for step in steps]
    assert places == sorted(places)
    assert places[0] >= 0


# Every pattern


def test_every_pattern_in_json(capsys: pytest.CaptureFixture[str]) -> None:
    """Exhaustive flights have the same document, with what was covered, and verdicts about these rounds."""
    arguments = ["fly", "crossing", "--cus", "1", "--loss", "exhaustive:2"]
    content = document(capsys, arguments, 0)
    *most, claims, seconds = ((key, types) for key, types in KEYS.items() if key not in LAST)
    keys = dict([*most, ("patterns", (dict,)), claims, seconds])
    assert_typed(content, keys)
    assert content["schema"] == "swarmproof.flight/1"
    assert content["rounds"] == 2
    assert (content["arrived"], content["rounds_to_arrival"]) == (False, None)
    assert content["patterns"]["covered"] == 256
    assert content["patterns"]["swarms"] == [1, 2, 8]
    assert content["patterns"]["stopped"] is None
    asked = SAFETY + [claim.id for claim in FLIGHT_CLAIMS if claim.id not in ("arrives", "eq-2-actual")]
    about_two_cus = ("lemma-2", "one-planner-per-uav", "same-selection", "corollary-1", "lemma-4")
    assert verdicts(content) == {
        name: "not-applicable" if name in about_two_cus else "holds-for-these-rounds" for name in asked
    }
    for claim in content["claims"]:
        assert_typed(claim, CLAIM_KEYS)


def test_every_pattern_of_the_baseline(capsys: pytest.CaptureFixture[str]) -> None:
    """Ignoring losses, some pattern of two rounds violates separation; the rounds and losses of it are given."""
    arguments = ["fly", "crossing", "--loss", "exhaustive:2", "--semantics", "ignore-loss"]
    content = document(capsys, arguments, 1)
    (claim,) = (claim for claim in content["claims"] if claim["id"] == "tracked-separation")
    assert (claim["verdict"], claim["rounds"], claim["lost_messages"]) == ("violated", 2, 2)
    assert verdicts(content)["theorem-2"] == "holds-for-these-rounds"
    assert main(arguments) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "1048576 loss patterns of 2 rounds covered" in said
    assert "Nothing is said of later rounds." in said


# Bad input


OWN = """
name = "own"
rounds = 10
[parameters]
workspace = [[-1.7, 1.7], [-1.7, 1.7], [0.4, 3.0]]
[start]
positions = [[-0.6, 0, 1], [0.6, 0, 1]]
[[targets]]
round = 0
positions = [[0.6, 0, 1], [-0.6, 0, 1]]
"""


def own(tmp_path: Path, old: str = "", new: str = "") -> str:
    """Write a scenario of one's own, with a change, and return its path."""
    path = tmp_path / "own.toml"
    assert old in OWN
    path.write_text(OWN.replace(old, new, 1), encoding="utf-8")
    return str(path)


def test_own_scenarios_are_flown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A TOML file is a scenario, with its own number of rounds."""
    assert document(capsys, ["fly", own(tmp_path)], 0)["rounds"] == 10


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("[[-0.6, 0, 1], [0.6, 0, 1]]", "[[-0.6, 0, 1], [-0.5, 0, 1]]", "the starts of UAV 0 and UAV 1 are too close"),
        (
            "[[0.6, 0, 1], [-0.6, 0, 1]]",
            "[[0.6, 0, 1], [-1.8, 0, 1]]",
            "the target of UAV 1 from round 0 on is out",
        ),
        ("[[0.6, 0, 1], [-0.6, 0, 1]]", "[[0.6, 0, 1]]", "there are 2 starts, but 1 targets"),
        ('name = "own"', 'name = "own"\nspeed = 3', "'speed'"),
        ("[parameters]", "[parameters]\nv_mux = 3", "did you mean v_max?"),
        ("rounds = 10", "rounds = 0", "rounds"),
        ("[start]", "[start", "is not TOML"),
    ],
)
def test_bad_scenarios(old: str, new: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Overlapping starts, targets outside the box and unknown keys are one sentence each, which names the file."""
    said = sentence(capsys, own(tmp_path, old, new))
    assert "own.toml" in said
    assert says in said


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nowhere"], "there is no scenario 'nowhere'"),
        (["circel"], "did you mean circle?"),
        (["nowhere.toml"], "cannot read the scenario nowhere.toml"),
        (["crossing", "--cus", "0"], "--cus 0 cannot be flown: choose 1 to 16"),
        (["crossing", "--cus", "17"], "--cus 17 cannot be flown"),
        (["crossing", "--cus", "two"], "'two' is no whole number"),
        (["crossing", "--cus", "-1"], "--cus"),
        (["crossing", "--rounds", "0"], "--rounds 0 cannot be flown: choose 1 to 100000"),
        (["crossing", "--rounds", "100001"], "--rounds 100001 cannot be flown"),
        (["crossing", "--rounds", "1.5"], "'1.5' is no whole number"),
        (["crossing", "--seed", "-3"], "--seed"),
        (["crossing", "--seed", "9" * 5000], "is no whole number"),
        (["crossing", "--trigger", "XX"], "there is no trigger 'XX': choose RR, DT, HT"),
        (["crossing", "--semantics", "odd"], "there are no semantics 'odd'"),
        (["crossing", "--set", "rejoin=maybe"], "switch rejoin has no value 'maybe'"),
        (["crossing", "--set", "rejoin"], "--set"),
        (["crossing", "--set", "v_mux=3"], "did you mean v_max?"),
        (["crossing", "--set", "jiter=3"], "did you mean jitter?"),
        (["crossing", "--set", "jitter=-1"], "jitter must not be negative, but it is -1"),
        (["crossing", "--set", "offer=best"], "[choices]: offer must be lowest or highest, not 'best'"),
        (["random", "--set", "assignment=shuffled"], "are drawn anew each time: assignment must be listed"),
        (["crossing", "--set", "v_max=fast"], "'fast' is not a number"),
        (["crossing", "--set", "uavs=3"], "uavs cannot be changed, since the positions are given one by one"),
        (["circle", "--set", "uavs=1"], "uavs"),
        (["circle", "--set", "uavs=60"], "too close"),
        (["crossing", "--set", "event_trigger=any"], "--trigger says whom the CUs plan"),
        (["crossing", "--set", "event_trigger=round-robin"], "--trigger says whom the CUs plan"),
        (["crossing", "--set", "initial=unknown", "--semantics", "ignore-loss"], "loss_handling=ignore needs initial"),
        (["crossing", "--loss", "some"], "there is no loss model 'some'"),
        (["crossing", "--loss", "iid:2"], "is a probability"),
        (["crossing", "--loss", "burst:0.1"], "must have the form burst:P_ENTER,P_LEAVE"),
        (["crossing", "--loss", "jam:-1,2"], "must be a whole number of rounds"),
        (["crossing", "--loss", "script:nowhere.json"], "nowhere.json"),
        (["crossing", "--loss", "iid:0.2,300,115000"], "rounds come after @: iid:0.2@300-115000"),
        (["crossing", "--loss", "delay:1"], "are faults, for which there is no word yet"),
        (["crossing", "--max-seconds", "3"], "--max-seconds does not go with --loss none, which is one flight"),
        (["crossing", "--max-states", "3", "--loss", "iid:0.1"], "--max-states does not go with --loss iid:0.1"),
        (["crossing", "--max-states", "3", "--loss", "adversary:9"], "whose BUDGET is the number of flights"),
        (["crossing", "--max-states", "0", "--loss", "exhaustive:2"], "'0' is no whole number of at least 1"),
        (["crossing", "--max-seconds", "inf", "--loss", "exhaustive:2"], "'inf' is no positive number of seconds"),
        (["crossing", "--loss", "exhaustive"], "needs a number of rounds from 1 to 20"),
        (["crossing", "--loss", "exhaustive:0"], "needs a number of rounds from 1 to 20"),
        (["crossing", "--loss", "exhaustive:2", "--rounds", "2"], "--rounds does not go with --loss exhaustive"),
        (["circle", "--loss", "exhaustive:2"], "every loss pattern of 16 UAVs and 2 CUs is out of reach"),
        (["crossing", "--height", "3"], "--height"),
        ([], "SCENARIO"),
    ],
)
def test_bad_options(arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    """What cannot be is said in one sentence, without a traceback, before anything is flown."""
    assert says in sentence(capsys, *arguments)


@pytest.mark.parametrize("option", ["--json", "--report"])
def test_what_cannot_be_written_is_said_first(
    option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file or folder that cannot be written is one sentence, and nothing is flown before it is said."""
    (tmp_path / "file").write_text("", encoding="utf-8")

    def fly(*arguments: object) -> None:
        raise AssertionError("it was flown")

    monkeypatch.setattr(command, "fly", fly)
    monkeypatch.setattr(command, "explore_flights", fly)
    target = str(tmp_path / "file" / "there")
    for rest in ([], ["--loss", "exhaustive:1"]):
        assert f"cannot write {'to ' if option == '--report' else ''}{target}" in sentence(
            capsys, "crossing", option, target, *rest
        )
    if option == "--json":
        assert "cannot write" in sentence(capsys, "crossing", option, str(tmp_path))


# Interruption


def _interrupted_at(k: int) -> Callable[..., LossModel]:
    """Return what stands for `parse`: everything arrives, until somebody presses Ctrl-C in round k."""

    class Interrupting:
        def losses(self, at: int) -> Losses:
            if at == k:
                raise KeyboardInterrupt
            return nothing_lost(2, 2)

    return lambda *arguments: Interrupting()


def test_an_interrupted_flight_tells_what_was_flown(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Interrupted, a flight is told as far as it went."""
    whole = document(capsys, [*FINE[:3], "4"], 0)
    monkeypatch.setattr(command, "parse", _interrupted_at(4))
    content = document(capsys, ["fly", "crossing", "--rounds", "30"], 3)
    told = {"interrupted": True, "stopped": "interrupted after 4 of 30 rounds"}
    assert _timeless(content) == {**_timeless(whole), **told}
    assert main(["fly", "crossing", "--rounds", "30"]) == 3
    said = " ".join(capsys.readouterr().out.split())
    assert "interrupted after 4 of 30 rounds; what follows is about these" in said
    assert "This flight only: 4 rounds" in said


def test_an_interrupt_waits_until_a_round_is_judged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ctrl-C in the middle of a round's verdicts: what is told is that of a flight of so many whole rounds."""
    whole, cut = tmp_path / "whole.json", tmp_path / "cut.json"
    arguments = ["fly", "crossing", "--loss", "iid:0.1", "--json"]
    assert main([*arguments, str(whole), "--rounds", "5"]) == 0
    real, calls = Judge._tally, 0

    def tally(self: Judge, claim: str, after: int, *more: Any) -> None:
        nonlocal calls
        calls += after == 5
        if (calls, after) == (3, 5):
            os.kill(os.getpid(), signal.SIGINT)
        real(self, claim, after, *more)

    monkeypatch.setattr(Judge, "_tally", tally)
    assert main([*arguments, str(cut), "--rounds", "30"]) == 3
    assert "interrupted after 5 of 30 rounds" in capsys.readouterr().out
    assert json.loads(cut.read_text())["claims"] == json.loads(whole.read_text())["claims"]


def test_a_flight_interrupted_at_once_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without a round, there is nothing to tell but that."""
    monkeypatch.setattr(command, "parse", _interrupted_at(0))
    assert main(FINE) == ExitCode.INTERRUPTED
    captured = capsys.readouterr()
    assert captured.err.strip() == "swarmproof: interrupted"
    assert captured.out == ""


def _explore_interrupted_in(k: int) -> Callable[..., Exhaustive]:
    """Return what stands for `explore_flights`: somebody presses Ctrl-C in round k."""

    def explore(setting: Setting, rounds: int, tell: object, limits: Limits) -> Exhaustive:
        def interrupt(at: int, done: int, size: int) -> None:
            if at == k:
                raise KeyboardInterrupt

        return explore_flights(setting, rounds, interrupt, limits)

    return explore


def test_interrupted_patterns_are_undecided(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Interrupted, the claims are undecided, with their own exit code, unless they are violated already."""
    monkeypatch.setattr(command, "explore_flights", _explore_interrupted_in(2))
    arguments = ["fly", "crossing", "--loss", "exhaustive:4"]
    content = document(capsys, arguments, 3)
    assert set(verdicts(content).values()) == {"undecided"}
    assert content["patterns"]["stopped"] == "interrupted"
    assert content["patterns"]["covered"] == 2**20
    assert main(arguments) == 3
    assert "Not finished: interrupted." in " ".join(capsys.readouterr().out.split())
    violated = document(capsys, [*arguments, "--semantics", "ignore-loss"], 1)
    assert set(verdicts(violated).values()) == {"undecided", "violated"}


def test_patterns_interrupted_at_once(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Interrupted before anything was flown, that is said, and the document is still JSON."""
    monkeypatch.setattr(command, "explore_flights", _explore_interrupted_in(0))
    arguments = ["fly", "crossing", "--loss", "exhaustive:4"]
    content = document(capsys, arguments, 3)
    assert content["patterns"]["covered"] == 0
    assert main(arguments) == 3


def test_patterns_within_limits(capsys: pytest.CaptureFixture[str]) -> None:
    """With a limit, the exit code says undecided, and the words how much was covered, also of the round begun."""
    arguments = ["fly", "crossing", "--loss", "exhaustive:4", "--max-states", "300"]
    content = document(capsys, arguments, 3)
    assert content["patterns"]["stopped"] == "the limit of 300 states"
    assert content["patterns"]["covered"] == 2**10
    assert main(arguments) == 3
    said = " ".join(capsys.readouterr().out.split())
    assert "1024 loss patterns of 1 rounds covered" in said
    assert "Not finished: round 1. Of the 16 swarms before it, 7 were flown on under every pattern" in said
    assert "Not finished: the limit of 300 states." in said
    violated = document(capsys, [*arguments, "--semantics", "ignore-loss"], 1)
    assert set(verdicts(violated).values()) == {"undecided", "violated"}
    assert document(capsys, ["fly", "crossing", "--loss", "exhaustive:1", "--max-seconds", "1e6"], 0)


def test_an_adversary_within_a_limit(capsys: pytest.CaptureFixture[str]) -> None:
    """Stopped by the clock, a search for the worst is undecided; what it found is flown, and may be a violation."""
    arguments = ["fly", "crossing", "--rounds", "30", "--loss", "adversary:100000", "--max-seconds", "1e-9"]
    assert main(arguments) == 3
    said = " ".join(capsys.readouterr().out.split())
    assert "Not finished: the limit of 1e-09 s. Flights tried: 1 of 100000." in said
    assert main(["fly", "crossing", "--rounds", "5", "--loss", "adversary:2", "--max-seconds", "1e6"]) == 0
    assert main([*arguments, "--set", "tolerance=0.02"]) == 1


@pytest.mark.parametrize(
    ("loss", "lost"),
    [
        ("cu1->*@5-59", 55 * 3),
        ("cu1->*@5-", 55 * 3),
        ("*->uav1", 60 * 2),
        ("cu1->cu0", 60),
        ("*->uav1@10-19+cu1->cu0@0-4", 10 * 2 + 5),
    ],
)
def test_lost_messages_are_those_counted_by_hand(loss: str, lost: int, capsys: pytest.CaptureFixture[str]) -> None:
    """A dead CU, a deaf UAV, a link that works one way: in 60 rounds, as many messages are lost as one counts."""
    main(["fly", "crossing", "--rounds", "60", "--loss", loss])
    said = " ".join(capsys.readouterr().out.split())
    assert f"; {lost} messages lost." in said
    assert f"trigger HT, loss {loss}, seed 0" in said
    assert "Nothing was lost" not in said


def test_a_loss_that_loses_nothing_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    """A window after the last round is no success to be silent about; a flight without loss is."""
    assert main([*FINE, "--loss", "iid:0.2@300-115000"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "Nothing was lost in these 5 rounds, although --loss iid:0.2@300-115000 was asked for" in said
    assert main(FINE) == 0
    assert "Nothing was lost" not in capsys.readouterr().out
    assert list(document(capsys, [*FINE, "--loss", "iid:0.2@300-"], 0)) == list(KEYS)


def test_help_shows_how_losses_are_written(capsys: pytest.CaptureFixture[str]) -> None:
    """`fly --help` has an example of each form."""
    assert main(["fly", "--help"]) == ExitCode.WELL
    said = capsys.readouterr().out
    for example, meaning in COMBINED.values():
        assert f"'{example}'" in said
        assert meaning in said


def test_patterns_of_an_unknown_start(capsys: pytest.CaptureFixture[str]) -> None:
    """With `initial=unknown` all trackers are deprecated at first; the document is JSON all the same."""
    arguments = ["fly", "crossing", "--loss", "exhaustive:1", "--set", "initial=unknown"]
    content = document(capsys, arguments, 0)
    assert content["patterns"]["covered"] == 2**10
    assert main(arguments) == 0
