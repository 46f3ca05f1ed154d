"""What cannot be flown is refused in one sentence, with its place and what would be right."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from swarmproof.errors import BadInput
from swarmproof.scenario.points import MOST_TRIES
from swarmproof.scenario.scenario import Choices, Redraw, Scenario, TargetChange, Weights, load

ONE_BY_ONE = (
    "uavs cannot be changed, since the positions are given one by one: give a formation to have a number, "
    'such as formation = "circle"'
)

GOOD = """\
name = "swap"
rounds = 60
horizon = 15
[parameters]
workspace = [[-1.7, 1.7], [-1.7, 1.7], [0.4, 3.0]]
[weights]
jerk = 1e-3
[start]
positions = [[-0.6, 0, 1], [0.6, 0.05, 1]]
[[targets]]
round = 0
positions = [[0.6, 0.05, 1], [-0.6, 0, 1]]
"""
STARTS = "[start]\npositions = [[-0.6, 0, 1], [0.6, 0.05, 1]]"
TARGETS = "[[targets]]\nround = 0\npositions = [[0.6, 0.05, 1], [-0.6, 0, 1]]"
CIRCLE = "[start]\nformation = 'circle'\nuavs = 2\nradius = 1\nheight = 1"
RANDOM = "[[targets]]\nround = 0\nformation = 'random'\nseparation = 0.5\nevery = 10"
ONE_BY_ONE = (
    "uavs cannot be changed, since the positions are given one by one: give a formation to have a number, such as "
    'formation = "circle"'
)
NO_NUMBER = "is not a number: write a decimal such as 0.1 or a fraction such as 1/6"
AGAIN = TARGETS.replace("round = 0", "round = 20")


def _mistake(folder: Path, text: str, *changes: str) -> str:
    """Return what is said of a file with this text, without the file's name."""
    path = folder / "bad.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput) as refusal:
        load(str(path), changes=changes)
    said = str(refusal.value)
    assert str(path) in said
    assert "\n" not in said
    return said.replace(f"{path}: ", "")


def _spots(count: int) -> str:
    return str([[round(-1.6 + 0.4 * (i % 9), 1), round(-1.6 + 0.4 * (i // 9), 1), 1] for i in range(count)])


def test_the_good_file_is_good(tmp_path: Path) -> None:
    """The file that the mistakes below are made in can be flown, and so can it with every other part used below."""
    path = tmp_path / "good.toml"
    for old, new in [("", ""), (STARTS, CIRCLE), (TARGETS, RANDOM), (TARGETS, f"{TARGETS}\n{AGAIN}")]:
        assert old in GOOD
        path.write_text(GOOD.replace(old, new) if old else GOOD, encoding="utf-8")
        assert load(str(path)).uavs == 2


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        # starts and targets
        (
            "[0.6, 0.05, 1]]\n[[",
            "[-0.5, 0.1, 1.6]]\n[[",
            "the starts of UAV 0 and UAV 1 are too close: their scaled distance is 0.173205 m, "
            "but d_hat_min=0.25 m is needed",
        ),
        (
            "[-0.6, 0, 1]]",
            "[0.6, 0.05, 2.4]]",
            "the targets of UAV 0 and UAV 1 from round 0 on are too close: their scaled distance is 0.233333 m, "
            "but d_hat_min=0.25 m is needed",
        ),
        (
            "[0.6, 0.05, 1]]\n[[",
            "[0.6, 0.05, 0.3]]\n[[",
            "the start of UAV 1 is outside the flying space: z=0.3 is not in 0.4…3",
        ),
        (
            "[[0.6, 0.05, 1],",
            "[[0.6, 1.8, 1],",
            "the target of UAV 0 from round 0 on is outside the flying space: y=1.8 is not in -1.7…1.7",
        ),
        (
            TARGETS,
            f"{TARGETS[:-1]}, [0, 0, 1]]",
            "there are 2 starts, but 3 targets from round 0 on",
        ),
        (
            STARTS,
            "[start]\npositions = [[0, 0, 1]]",
            "the number of UAVs must be from 2 to 64, not 1",
        ),
        (
            STARTS,
            "[start]\npositions = []",
            "the number of UAVs must be from 2 to 64, not 0",
        ),
        (
            STARTS,
            f"[start]\npositions = {_spots(65)}",
            "the number of UAVs must be from 2 to 64, not 65",
        ),
        (
            "[0.6, 0.05, 1]]\n[[",
            "[0.6, nan, 1]]\n[[",
            f"[start]: the position of UAV 1: y: 'nan' {NO_NUMBER}",
        ),
        (
            "[0.6, 0.05, 1]]\n[[",
            "[0.6, inf, 1]]\n[[",
            f"[start]: the position of UAV 1: y: 'inf' {NO_NUMBER}",
        ),
        (
            "[0.6, 0.05, 1]]\n[[",
            "[0.6, 0.05]]\n[[",
            "[start]: the position of UAV 1: a list is not a list of 3 numbers [x, y, z] in m",
        ),
        (
            STARTS,
            "[start]\npositions = 3",
            "[start]: positions takes a list of points [x, y, z] in m, such as [[-0.5, 0, 1], [0.5, 0, 1]]",
        ),
        # rounds, horizon, name
        ("rounds = 60", "rounds = 0", "rounds must be a whole number from 1 to 100000, not 0"),
        ("rounds = 60", "rounds = 100001", "rounds must be a whole number from 1 to 100000, not 100001"),
        ("rounds = 60", "rounds = 1.5", "rounds must be a whole number from 1 to 100000, not 1.5"),
        ("rounds = 60\n", "", "rounds is missing: write a line such as rounds = 1"),
        ("horizon = 15", "horizon = 1", "horizon must be a whole number from 2 to 60, not 1"),
        ("horizon = 15", "horizon = 61", "horizon must be a whole number from 2 to 60, not 61"),
        (
            "horizon = 15",
            "horizon = []",
            "horizon: a list is not a number: write a decimal such as 0.1, or a text such as 1/6",
        ),
        ('"swap"', "7", 'name must be a text of 1 to 60 characters on one line, such as name = "swap"'),
        ('"swap"', '"a\\nb"', 'name must be a text of 1 to 60 characters on one line, such as name = "swap"'),
        # tables and keys
        ("[parameters]\nworkspace = [[-1.7, 1.7], [-1.7, 1.7], [0.4, 3.0]]", "", "the table [parameters] is missing"),
        (STARTS, "", "the table [start] is missing"),
        (
            TARGETS,
            "",
            "the targets are missing: write a line [[targets]], and lines such as round = 0 below it",
        ),
        (
            "[[targets]]",
            "[targets]",
            "the targets are missing: write a line [[targets]], and lines such as round = 0 below it",
        ),
        (
            "horizon = 15",
            "horizont = 15",
            "there is no key 'horizont' here: did you mean horizon?",
        ),
        ("jerk =", "jerks =", "[weights]: there is no key 'jerks' here: did you mean jerk?"),
        ("workspace =", "work_space =", "[parameters]: there is no parameter 'work_space': did you mean workspace?"),
        (
            STARTS,
            f"{STARTS}\nuavs = 2",
            "[start]: there is no key 'uavs' here: choose one of positions",
        ),
        # weights
        ("jerk = 1e-3", "jerk = 0", "[weights]: the weight jerk must be positive, not 0"),
        ("jerk = 1e-3", "position = 0", "[weights]: the weight position must be positive, not 0"),
        ("jerk = 1e-3", "band = -1", "[weights]: the weight band must be 0 or a positive number, not -1.0"),
        # parameters
        (
            "workspace = [[-1.7, 1.7], [-1.7, 1.7], [0.4, 3.0]]",
            "T_c = 0.1",
            "the flying space is missing: give workspace, low and high of x, y and z in m",
        ),
        ("workspace =", "order = 2\nworkspace =", "order must be 3: a flight plans jerks"),
        ("workspace =", "T_b = 0.1\nworkspace =", "T_b=0.1 must equal T_s=0.2, one period"),
        (
            "workspace =",
            "T_c = 0.15\nworkspace =",
            "T_s must be 1 to 10 times T_c, a whole number: T_s=0.2 is 4/3 times T_c=0.15",
        ),
        (
            "workspace =",
            "T_c = 0.4\nworkspace =",
            "T_s must be 1 to 10 times T_c, a whole number: T_s=0.2 is 0.5 times T_c=0.4",
        ),
        (
            "workspace =",
            "T_c = '1/55'\nworkspace =",
            "T_s must be 1 to 10 times T_c, a whole number: T_s=0.2 is 11 times T_c=1/55",
        ),
        (
            "workspace =",
            "theta_inverse = [1, '1/7', '1/144']\nworkspace =",
            "theta_inverse has the least common denominator 1008: simpler fractions are needed, with at most 1000",
        ),
        # changes of the targets
        (
            "round = 0",
            "round = 1",
            "there are no targets from round 0 on: the first of the targets must have round = 0",
        ),
        (
            TARGETS,
            f"{TARGETS}\n{TARGETS}",
            "the targets of round 0 come after those of round 0: sort them",
        ),
        ("round = 0\n", "", "the table 1 of [[targets]]: round is missing: write a line such as round = 1"),
        (
            TARGETS,
            f"{TARGETS}\n{AGAIN.replace('round = 20', 'round = -1')}",
            "the table 2 of [[targets]]: round must be a whole number from 0 to 100000, not -1",
        ),
        (
            TARGETS,
            f"{RANDOM}\n{AGAIN}",
            "the table 2 of [[targets]]: it comes after random targets with every, which must be the last",
        ),
        # formations
        (
            STARTS,
            "[start]",
            '[start]: neither positions nor a formation is given: write a line such as formation = "circle"',
        ),
        (
            STARTS,
            CIRCLE.replace("circle", "sircle"),
            "[start]: there is no formation 'sircle' here: did you mean circle?",
        ),
        (
            STARTS,
            "[start]\nformation = 3",
            "[start]: there is no formation 3 here: choose one of circle, line, plane, pyramid, cube, sphere, random",
        ),
        (
            STARTS,
            "[start]\nformation = 'antipodes'\nuavs = 2",
            "[start]: there is no formation 'antipodes' here: "
            "choose one of circle, line, plane, pyramid, cube, sphere, random",
        ),
        (STARTS, CIRCLE.replace("radius", "radios"), "[start]: there is no key 'radios' here: did you mean radius?"),
        (STARTS, CIRCLE.replace("radius = 1\n", ""), "[start]: radius is missing: write a line such as radius = 1"),
        (STARTS, CIRCLE.replace("uavs = 2\n", ""), "[start]: uavs is missing: write a line such as uavs = 1"),
        (STARTS, CIRCLE.replace("uavs = 2", "uavs = 65"), "[start]: uavs must be a whole number from 2 to 64, not 65"),
        (STARTS, f"{CIRCLE}\ncentre = 1", "[start]: centre: 1 is not a list of 2 numbers [x, y] in m"),
        (
            TARGETS,
            "[[targets]]\nround = 0\nformation = 'antipodes'\nradius = 1",
            "the table 1 of [[targets]]: there is no key 'radius' here: choose one of round, velocity, formation, "
            "centre",
        ),
        # random points
        (
            TARGETS,
            RANDOM.replace("0.5", "0.2"),
            "the table 1 of [[targets]]: separation=0.2 must be at least d_hat_min=0.25",
        ),
        (
            TARGETS,
            RANDOM.replace("every = 10", "every = 0"),
            "the table 1 of [[targets]]: every must be a whole number from 1 to 100000, not 0",
        ),
        (
            STARTS,
            "[start]\nformation = 'random'\nuavs = 2\nseparation = 0.5\nevery = 3",
            "[start]: there is no key 'every' here: choose one of formation, uavs, separation",
        ),
        (
            STARTS,
            "[start]\nformation = 'random'\nuavs = 64\nseparation = 1",
            "[start]: 64 random points with separation=1 do not fit into the flying space: "
            f"{MOST_TRIES} tries found room for",
        ),
        (
            f"[0.4, 3.0]]\n[weights]\njerk = 1e-3\n{STARTS}",
            "[0.9, 1]]\n[start]\nformation = 'random'\nuavs = 2\nseparation = 1",
            "[start]: the flying space z=0.9…1 is too thin for random points, which keep 0.1 m from its walls",
        ),
    ],
)
def test_a_mistake_is_one_sentence(tmp_path: Path, old: str, new: str, said: str) -> None:
    """Each of these files is refused with this sentence."""
    assert GOOD.count(old) >= 1
    assert _mistake(tmp_path, GOOD.replace(old, new, 1)).startswith(said)


def test_what_is_no_table_is_said(tmp_path: Path) -> None:
    """A value where a table belongs is refused, and the sentence shows how a table is written."""
    for name in ("parameters", "weights", "start"):
        tables = {"parameters": "[parameters]\nworkspace = [-1, 1, -1, 1, 0, 2]", "start": STARTS, "targets": TARGETS}
        tables.pop(name, None)
        text = "\n".join([f'{name} = 3\nname = "a"\nrounds = 1', *tables.values()])
        said = f"3 is not a table: write a line [{name}], and lines such as radius = 1.5 below it"
        assert _mistake(tmp_path, text) == said
    text = GOOD.replace(TARGETS, "").replace("horizon = 15", "targets = [3]")
    said = "3 is not a table: write a line [[targets]], and lines such as radius = 1.5 below it"
    assert _mistake(tmp_path, text) == said


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            ["uavs=3"],
            ONE_BY_ONE,
        ),
        (["horizon=1"], "horizon must be a whole number from 2 to 60, not 1"),
        (["horizon=x"], f"horizon: 'x' {NO_NUMBER}"),
        (["workspace=none"], "the flying space is missing: give workspace, low and high of x, y and z in m"),
        (["v_maxx=1"], "--set: there is no parameter 'v_maxx': did you mean v_max?"),
        (["uavs"], "--set 'uavs' is not of the form NAME=VALUE, such as T_c=0.05"),
        (["T_b=0.2", "T_s=0.4"], "T_b=0.2 must equal T_s=0.4, one period"),
        (["d_hat_min=1.5"], "the starts of UAV 0 and UAV 1 are too close: their scaled distance is 1.20104 m, but"),
        (["workspace=-1,1,-1,1,1.1,2"], "the start of UAV 0 is outside the flying space: z=1 is not in 1.1…2"),
        (["jitter=-0.1"], "jitter must not be negative, but it is -0.1"),
        (["jitter=much"], "jitter: 'much' is not a number: write a decimal such as 0.1 or a fraction such as 1/6"),
        (["jitter=0.1", "workspace=-0.5,1,-1,1,0.4,2"], "the start of UAV 0 is outside the flying space: x=-0.6"),
        (["assignment=random"], "assignment must be listed or shuffled, not 'random'"),
        (["assignment="], "assignment must be listed or shuffled, not ''"),
        (["hold=0"], "hold must be a whole number from 1 to 100000, not 0"),
        (["hold=-5"], "hold must be a whole number from 1 to 100000, not -5"),
        (["hold=1.5"], "hold must be a whole number from 1 to 100000, not 1.5"),
        (["hold=long"], f"hold: 'long' {NO_NUMBER}"),
        (["band=-1"], "[weights]: the weight band must be 0 or a positive number, not -1"),
        (["position=0"], "[weights]: the weight position must be positive, not 0"),
        (["band_width=wide"], f"[weights]: band_width: 'wide' {NO_NUMBER}"),
        (["band_with=1"], "--set: there is no parameter 'band_with': did you mean band_width?"),
        (["jiter=1"], "--set: there is no parameter 'jiter': did you mean jitter?"),
        (["detour_steps=1"], "--set: there is no parameter 'detour_steps': did you mean detour_step?"),
        (["assignement=listed"], "--set: there is no parameter 'assignement': did you mean assignment?"),
        (["=1"], "--set: there is no parameter '': choose one of T_c, "),
        (["jitter"], "--set 'jitter' is not of the form NAME=VALUE, such as T_c=0.05"),
        (["priority_scale=log"], "[choices]: priority_scale must be logarithmic or linear, not 'log'"),
        (["detours=0"], "[choices]: detours must be on or off, not '0'"),
        (["offer=last"], "[choices]: offer must be lowest or highest, not 'last'"),
        (["retry=-1"], "[choices]: retry must be a whole number from 0 to 100000, not -1"),
        (["retry=2.5"], "[choices]: retry must be a whole number from 0 to 100000, not 2.5"),
        (["retry=never"], f"[choices]: retry: 'never' {NO_NUMBER}"),
        (["detour_rounds=0"], "[choices]: detour_rounds must be a whole number from 1 to 100000, not 0"),
        (["detour_step=-0.6"], "[choices]: detour_step must not be negative, but it is -0.6"),
        (["detour_noise=-1"], "[choices]: detour_noise must not be negative, but it is -1"),
        (["detour_noise=loud"], f"[choices]: detour_noise: 'loud' {NO_NUMBER}"),
    ],
)
def test_a_mistaken_change_is_one_sentence(tmp_path: Path, changes: list[str], said: str) -> None:
    """A change that cannot be applied is refused with this sentence."""
    assert _mistake(tmp_path, GOOD, *changes).startswith(said)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("jitter = [1]", "jitter: a list is not a number"),
        ("jitter = true", "jitter: true is not a number"),
        ("assignment = 1", "assignment must be listed or shuffled, not 1"),
        ("assignment = ['shuffled']", "assignment must be listed or shuffled, not a list"),
        ("hold = true", "hold: true is not a number"),
        ("hold = 100001", "hold must be a whole number from 1 to 100000, not 100001"),
        ("holds = 3", "there is no key 'holds' here: did you mean hold?"),
        ("choices = 1", "1 is not a table: write a line [choices]"),
        ("choices.retry = '1/2'", "[choices]: retry must be a whole number from 0 to 100000, not 0.5"),
        ("choices.detours = true", "[choices]: detours must be on or off, not true"),
        ("choices.offer = 1", "[choices]: offer must be lowest or highest, not 1"),
        ("choices.priority_scale = []", "[choices]: priority_scale must be logarithmic or linear, not a list"),
        ("choices.detour_step = 'far'", f"[choices]: detour_step: 'far' {NO_NUMBER}"),
        ("choices.detour_noise = [1]", "[choices]: detour_noise: a list is not a number"),
        ("choices.detour_rounds = false", "[choices]: detour_rounds: false is not a number"),
        ("choices.jitter = 0.1", "[choices]: there is no key 'jitter' here: choose one of priority_scale, retry"),
    ],
)
def test_a_mistaken_key_is_one_sentence(tmp_path: Path, line: str, said: str) -> None:
    """What can be changed is checked in a file as well, whatever type it has there."""
    assert _mistake(tmp_path, f"{line}\n{GOOD}").startswith(said)


def test_hold_is_bounded_by_the_longest_flight(tmp_path: Path) -> None:
    """With two changes, each can hold for half of the longest flight only."""
    text = GOOD.replace(TARGETS, f"{TARGETS}\n{AGAIN}")
    assert _mistake(tmp_path, text, "hold=50001") == "hold must be a whole number from 1 to 50000, not 50001"


def test_starts_that_jitter_brings_together_are_refused() -> None:
    """The sentence says that it was jitter: as listed, these starts are far enough apart."""
    said = "scenario circle: the starts of UAV 0 and UAV 1 after jitter are too close: their scaled distance is "
    with pytest.raises(BadInput, match=f"^{said}0.110285 m, but d_hat_min=0.25 m is needed, or begin"):
        load("circle", 0, ["jitter=0.5"])


def test_targets_that_are_drawn_anew_are_not_shuffled(tmp_path: Path) -> None:
    """Shuffling new draws would mean nothing, so it is refused."""
    said = _mistake(tmp_path, GOOD.replace(TARGETS, RANDOM), "assignment=shuffled")
    assert said == (
        "the table 1 of [[targets]]: random targets with every are drawn anew each time: assignment must be listed"
    )


def test_the_number_of_uavs_is_bounded() -> None:
    """Generated scenarios take 2 to 64 UAVs, as many as fit."""
    for uavs, said in (
        ("1", "scenario circle: [start]: uavs must be a whole number from 2 to 64, not 1"),
        ("1e5", "scenario circle: [start]: uavs must be a whole number from 2 to 64, not 100000"),
        (
            "64",
            "scenario circle: the starts of UAV 0 and UAV 1 are too close: their scaled distance is 0.142296 m, but",
        ),
    ):
        with pytest.raises(BadInput) as refusal:
            load("circle", changes=[f"uavs={uavs}"])
        assert str(refusal.value).startswith(said)


def test_parameters_are_checked_before_points_are_drawn() -> None:
    """A missing flying space is said of the scenario, not of the table that would draw points in it."""
    with pytest.raises(BadInput, match=r"^scenario random: the flying space is missing: give workspace"):
        load("random", changes=["workspace=none"])


def test_targets_and_starts_must_both_be_generated(tmp_path: Path) -> None:
    """The number of UAVs cannot be changed where only the starts are generated."""
    said = _mistake(tmp_path, GOOD.replace(STARTS, CIRCLE), "uavs=3")
    assert said == ONE_BY_ONE


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("circel", "there is no scenario 'circel', and no such file: did you mean circle?"),
        ("", "there is no scenario '', and no such file: choose one of circle, formations, crossing, random"),
        ("no/such/file.toml", "cannot read the scenario no/such/file.toml: No such file or directory"),
        ("file.toml", "cannot read the scenario file.toml: No such file or directory"),
        (".", "cannot read the scenario .: Is a directory"),
        ("a\0b.toml", "cannot read the scenario a\0b.toml: embedded null byte"),
        ("x" * 5000, "there is no scenario 'xxxxx"),
    ],
)
def test_a_scenario_that_is_not_there_is_said(
    name: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A name that does not ship, and a file that cannot be read, are refused with this sentence."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput) as refusal:
        load(name)
    assert str(refusal.value).startswith(said)


def test_what_is_no_scenario_file_is_said(tmp_path: Path) -> None:
    """A file that is too long, no text or no TOML is refused in a sentence about scenarios."""
    path = tmp_path / "bad.toml"
    for content, said in (
        (b"#" * 16_000_001, f"{path} is too long for a scenario: 16000000 bytes are the most"),
        (b"\xff", f"{path} is not a text file (UTF-8) with lines such as rounds = 60"),
        (b"rounds = ", f"{path} is not TOML with lines such as rounds = 60: Invalid value"),
        (b"a = " + b"[" * 20_000, f"{path} is not a scenario: its lists are nested too deeply"),
    ):
        path.write_bytes(content)
        with pytest.raises(BadInput) as refusal:
            load(str(path))
        assert str(refusal.value).startswith(said)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda one: replace(one, horizon=1), "horizon must be from 2 to 60, not 1"),
        (lambda one: replace(one, rounds=0), "rounds must be from 1 to 100000, not 0"),
        (lambda one: replace(one, starts=one.starts * 33), "the number of UAVs must be from 2 to 64, not 66"),
        (lambda one: replace(one, targets=()), "there are no targets from round 0 on"),
        (
            lambda one: replace(one, targets=(*one.targets, TargetChange(0, one.starts))),
            "the targets of round 0 come after those of round 0: sort them",
        ),
        (
            lambda one: replace(one, redraw=Redraw(5, Fraction(1, 5), 0)),
            "separation=0.2 must be at least d_hat_min=0.25",
        ),
        (
            lambda one: replace(one, weights=Weights(speed=math.nan)),
            "the weight speed must be 0 or a positive number, not nan",
        ),
        (
            lambda one: replace(one, weights=Weights(jerk=math.inf)),
            "the weight jerk must be 0 or a positive number, not inf",
        ),
        (
            lambda one: replace(one, choices=Choices(detour_noise=math.nan)),
            "detour_noise must be 0 or a positive number of metres, not nan",
        ),
        (
            lambda one: replace(one, choices=Choices(detour_step=-0.1)),
            "detour_step must be 0 or a positive number of metres, not -0.1",
        ),
        (lambda one: replace(one, choices=Choices(retry=-1)), "retry must be from 0 to 100000 rounds, not -1"),
        (
            lambda one: replace(one, choices=Choices(detour_rounds=0)),
            "detour_rounds must be from 1 to 100000 rounds, not 0",
        ),
        (lambda one: replace(one, choices=Choices(offer="both")), "offer must be lowest or highest, not 'both'"),
    ],
)
def test_a_scenario_made_in_python_is_checked_too(change: Callable[[Scenario], Scenario], said: str) -> None:
    """A scenario that is made of values, not read, is refused with the same sentences."""
    with pytest.raises(BadInput) as refusal:
        change(load("crossing"))
    assert str(refusal.value).startswith(said)
