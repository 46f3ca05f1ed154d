"""Every message about bad input shows what is right: an example, a choice or a range; and names the right help."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

import pytest

from swarmproof.cli import main
from swarmproof.exit_codes import ExitCode
from swarmproof.options.parser import EXAMPLES, parser

#: How a message shows what would be right.
SHOWS = re.compile(
    r"such as|choose|did you mean|\bfrom \S+ to \S+|\bbetween \S+ and \S+|\bat least \S*\d|\bat most \S*\d|it takes "
    r"|\d (?:are|is) (?:enough|the most)|give |write |looks? like |must (?:be|not be|equal)|as in "
    r"|that `|that --|or \d|goes with |has UAVs x CUs|is not in \S+…|m is needed"
)

SCENARIO = """
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

#: Command lines that cannot be; in the folder there are the files of `_files`.
BAD = """
verify --uavs 0
verify --uavs two
verify --uavs 99
verify --cus 0
verify --cus 17
verify --cus
verify --semantics odd
verify --set rejoin
verify --set rejoin=maybe
verify --set rejon=any-state
verify --set loss_handling=ignore
verify --claim lemma-9
verify --claim lemma-3
verify --max-states 0
verify --max-seconds 0
verify --max-seconds soon
verify --max-seconds
verify --junit out.xml
verify --json none/dir.json/x
verify --matrix --uavs 7
verify --matrix --claim lemma-1
fly
fly nowhere
fly circel
fly nowhere.toml
fly given.json
fly given.yaml
fly crossing --cus 0
fly crossing --cus 17
fly crossing --cus two
fly crossing --cus
fly crossing --rounds 0
fly crossing --rounds 1.5
fly crossing --seed -3
fly crossing --trigger XX
fly crossing --semantics odd
fly crossing --set rejoin=maybe
fly crossing --set rejoin
fly crossing --set v_mux=3
fly crossing --set v_max=fast
fly crossing --set v_max=1,2
fly crossing --set v_max=-1
fly crossing --set T_c=0
fly crossing --set T_c=0.07
fly crossing --set T_c=1e-12
fly crossing --set T_b=0.1
fly crossing --set order=2
fly crossing --set order=4
fly crossing --set workspace=none
fly crossing --set workspace=1,2
fly crossing --set workspace=2,1,0,1,0,1
fly crossing --set theta_inverse=1,2
fly crossing --set theta_inverse=0
fly crossing --set theta_inverse=1,2,3,4,5,6,7,8,9
fly crossing --set theta_inverse=-1
fly crossing --set tracking_error=-1
fly crossing --set jitter=-1
fly crossing --set jitter=much
fly crossing --set jitter
fly crossing --set offer=best
fly crossing --set retry=-1
fly crossing --set retry=x
fly crossing --set horizon=1
fly crossing --set horizon=61
fly crossing --set horizon=long
fly crossing --set tolerance=-1
fly crossing --set tolerance=1
fly crossing --set band=-1
fly crossing --set jerk=0
fly crossing --set hold=0
fly crossing --set assignment=some
fly random --set assignment=shuffled
fly crossing --set uavs=3
fly circle --set uavs=1
fly circle --set uavs=65
fly circle --set uavs=60
fly crossing --set event_trigger=any
fly crossing --set initial=unknown --semantics ignore-loss
fly crossing --loss some
fly crossing --loss iid
fly crossing --loss iid:2
fly crossing --loss iid:10%
fly crossing --loss iid:1/0
fly crossing --loss burst:0.1
fly crossing --loss jam:-1,2
fly crossing --loss jam:3
fly crossing --loss script:nowhere.json
fly crossing --loss script:given.json
fly crossing --loss script:given.yaml
fly crossing --loss exhaustive
fly crossing --loss exhaustive:0
fly crossing --loss exhaustive:2 --rounds 2
fly crossing --loss exhaustive:2 --positions p.csv
fly crossing --loss adversary:0
fly crossing --loss adversary
fly circle --loss exhaustive:2
fly crossing --positions flight.txt
fly crossing --height 3
fly crossing --json none/dir.json/x
margin nowhere.toml
margin given.json
margin given.yaml
margin --set T_c
margin --set T_c=
margin --set T_c=0
margin --set T_c=0.07
margin --set T_c=nan
margin --set T_c=1e99
margin --set T_c=1/0
margin --set v_max=1,2
margin --set vmax=1
margin --set order=5
margin --set order=2.5
margin --set workspace=1
margin --set workspace=2,1,0,1,0,1
margin --set theta_inverse=1,2
margin --set theta_inverse=1,1,0
margin --d-min
margin --d-min 0
margin --tracking-error -1
margin --tracking-error=-1
margin --reading some
margin --solve-for T_x
margin --sweep T_c
margin --sweep T_x=1:2
margin --sweep T_c=0.1..0.2
margin --sweep T_c=0.1..0.2/0
margin --sweep T_c=1:x
margin --changes 2
margin --results out
margin --sweep T_c=0.1:0.2 --changes x
margin --sweep T_c=0.1 --sweep T_c=0.2
margin --sweep T_c=0.1 --solve-for T_c
margin --certificate -
margin --check nowhere.json
margin --check given.json
margin --check given.yaml
margin --check given.json --set T_c=1
margin --plot worst.txt
margin --fast
audit --claim lemma-9
audit --report
audit --quick
reproduce
reproduce fig9
reproduce fig4 --processes 0
reproduce fig4 --processes x
reproduce fig4 --cell 0
reproduce fig4 --cell 0 --json out.json
reproduce fig4 --fast
claims --fast
replay
replay nowhere.json
replay given.json
replay given.yaml
replay given.json --json -
"""
#: What is wrong in scenarios: what is replaced, and by what.
BAD_SCENARIOS = [
    ("rounds = 10", "rounds = 0"),
    ("rounds = 10", "rounds = 1.5"),
    ("rounds = 10", 'rounds = "many"'),
    ("rounds = 10", ""),
    ('name = "own"', "name = 3"),
    ('name = "own"', ""),
    ('name = "own"', 'name = "own"\nspeed = 3'),
    ("[parameters]", "[parameters]\nv_mux = 3"),
    ("[parameters]", "[parameters]\nv_max = true"),
    ("[parameters]", "[weights]\nband = -1\n[parameters]"),
    ("[parameters]", "[weights]\nbend = 1\n[parameters]"),
    ("[parameters]", "[choices]\noffer = 3\n[parameters]"),
    ("[parameters]", "parameters = 3\n[other]"),
    ("workspace = [[-1.7, 1.7], [-1.7, 1.7], [0.4, 3.0]]", ""),
    ("workspace = [[-1.7, 1.7], [-1.7, 1.7], [0.4, 3.0]]", "workspace = [1, 2]"),
    ("positions = [[-0.6, 0, 1], [0.6, 0, 1]]", ""),
    ("positions = [[-0.6, 0, 1], [0.6, 0, 1]]", 'formation = "ring"'),
    ("positions = [[-0.6, 0, 1], [0.6, 0, 1]]", 'formation = "circle"'),
    ("positions = [[-0.6, 0, 1], [0.6, 0, 1]]", 'formation = "circle"\nuavs = 4\nradius = "r"\nheight = 1'),
    ("positions = [[-0.6, 0, 1], [0.6, 0, 1]]", 'formation = "random"\nuavs = 4\nseparation = 0.1'),
    ("positions = [[-0.6, 0, 1], [0.6, 0, 1]]", "positions = [[-0.6, 0, 1]]"),
    ("positions = [[-0.6, 0, 1], [0.6, 0, 1]]", "positions = [[-0.6, 0], [0.6, 0]]"),
    ("positions = [[-0.6, 0, 1], [0.6, 0, 1]]", "positions = 3"),
    ("positions = [[-0.6, 0, 1], [0.6, 0, 1]]", 'positions = [["a", 0, 1], [0.6, 0, 1]]'),
    ("[[-0.6, 0, 1], [0.6, 0, 1]]", "[[-0.6, 0, 1], [-0.5, 0, 1]]"),
    ("[[0.6, 0, 1], [-0.6, 0, 1]]", "[[0.6, 0, 1], [-1.8, 0, 1]]"),
    ("[[0.6, 0, 1], [-0.6, 0, 1]]", "[[0.6, 0, 1]]"),
    ("[[targets]]", "[targets]"),
    ("round = 0\n", "round = 3\n"),
    ("round = 0\n", ""),
    ("round = 0\n", "round = 0\nevery = 5\n"),
    ("[start]", "[start"),
]


def _files(folder: Path) -> None:
    (folder / "given.json").write_text('{"v_max": 2.0, "rounds": 60}', encoding="utf-8")
    (folder / "given.yaml").write_text("v_max: 2.0\nrounds: 60\n", encoding="utf-8")


def sentence(capsys: pytest.CaptureFixture[str], arguments: list[str]) -> str:
    """Run what cannot be, and return its one sentence."""
    code = main(arguments)
    captured = capsys.readouterr()
    assert code == ExitCode.BAD_INPUT, captured
    assert captured.out == ""
    (line,) = captured.err.strip().splitlines()
    return line.removeprefix("swarmproof: ")


def assert_helpful(said: str) -> None:
    """Assert that it shows what would be right, besides where help is."""
    without_help = re.sub(r"\(`[^`]*--help` [^)]*\)", "", said)
    assert SHOWS.search(without_help) or "unrecognized arguments" in said, said


@pytest.mark.parametrize("line", BAD.strip().splitlines())
def test_bad_options_show_what_is_right(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence, which shows an example, the choices or the range; help that is named is the command's."""
    monkeypatch.chdir(tmp_path)
    _files(tmp_path)
    (tmp_path / "none").write_text("", encoding="utf-8")
    said = sentence(capsys, line.split())
    assert_helpful(said)
    for named in re.findall(r"`(swarmproof[^`]*) --help`", said):
        assert named == f"swarmproof {line.split()[0]}"


@pytest.mark.parametrize(("old", "new"), BAD_SCENARIOS)
def test_bad_scenarios_show_what_is_right(
    old: str, new: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A mistake in a scenario is one sentence that names the file and shows what would be right."""
    path = tmp_path / "own.toml"
    assert old in SCENARIO
    path.write_text(SCENARIO.replace(old, new, 1), encoding="utf-8")
    said = sentence(capsys, ["fly", str(path)])
    assert "own.toml" in said
    assert_helpful(said.replace(str(path), ""))


def test_every_option_has_an_example() -> None:
    """Each option with a value, and each argument that is needed, has an example, which its own parser takes."""
    (commands,) = (action for action in parser()._actions if isinstance(action, argparse._SubParsersAction))
    used = {"COMMAND"}
    for command in commands.choices.values():
        for action in command._actions:
            if action.nargs == 0 or (not action.option_strings and action.nargs == "?"):
                continue
            name = next((one for one in action.option_strings if one.startswith("--")), action.metavar)
            assert isinstance(name, str)
            used.add(name)
            assert command._get_value(action, EXAMPLES[name]) is not None
            assert action.choices is None or EXAMPLES[name] in action.choices
    assert used == set(EXAMPLES)


def test_the_program_names_its_own_help(capsys: pytest.CaptureFixture[str]) -> None:
    """Without a command, or with one that there is not, the program's help is the right one."""
    for arguments in ([], ["nope"]):
        assert "`swarmproof --help`" in sentence(capsys, arguments)


def test_a_good_script_is_no_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The scenario that the mistakes are made in can be flown, and is written down as JSON."""
    path = tmp_path / "own.toml"
    path.write_text(SCENARIO, encoding="utf-8")
    assert main(["fly", str(path), "--rounds", "1", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["rounds"] == 1


@pytest.mark.parametrize("blank", ["", " "], ids=["nothing", "blank"])
@pytest.mark.parametrize("form", ["equals", "apart"])
def test_every_empty_value_is_refused(
    form: str, blank: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An empty value of any option, and an empty argument, is one sentence, and nothing is computed or written."""
    monkeypatch.chdir(tmp_path)
    needed = {"fly": ["crossing"], "reproduce": ["fig4"]}
    (commands,) = (action for action in parser()._actions if isinstance(action, argparse._SubParsersAction))
    tried = 0
    for command, its in commands.choices.items():
        for action in its._actions:
            if action.nargs == 0:
                continue
            given = [blank]
            if action.option_strings:
                option = action.option_strings[-1]
                words = [f"{option}={blank}"] if form == "equals" else [option, blank]
                given = [*needed.get(command, []), *words]
            said = sentence(capsys, [command, *given])
            assert "empty value" in said or "is no " in said or "invalid choice" in said, said
            tried += 1
    assert tried > 40
    assert not list(tmp_path.iterdir())
