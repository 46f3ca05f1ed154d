"""Sweeps of `swarmproof margin`: which sets, in which order, and a folder that an interrupted run goes on from."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import pytest

from swarmproof.cli import main
from swarmproof.commands import margin as command
from swarmproof.errors import BadInput
from swarmproof.margin import sweep as module
from swarmproof.margin.bounds import Margin, margin
from swarmproof.margin.problem import Problem
from swarmproof.margin.sweep import MOST_SETS, Axis, certificate_text, file_name, problems, sweep
from swarmproof.theorem3.parameters import Parameters, Reading

#: A base whose margins are found in a moment: double integrator, one window per period.
QUICK = ["margin", "--set", "order=2", "--set", "T_s=0.05", "--set", "T_c=0.05"]
#: Four sets of it.
GRID = ["--sweep", "v_max=1:2", "--sweep", "T_c=0.025:0.05"]


#: The command's computation, but each margin is computed once for all tests.
once = cache(margin)


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the command compute each margin once for all tests; nobody is told how it goes."""
    for place in (module, command):
        monkeypatch.setattr(place, "margin", lambda problem, say=None: once(problem))


def described(found: list[Problem]) -> list[str]:
    """Return what differs from the published parameters, set by set."""
    return [problem.parameters.describe() for problem in found]


def axes(*texts: str) -> list[Axis]:
    """Return the axes of these texts."""
    return [Axis.parse(text) for text in texts]


def swept(*texts: str, changes: int | None = None, base: Parameters | None = None) -> list[Problem]:
    """Return the sets of a sweep from the published parameters, or from `base`."""
    return problems(base or Parameters(), Reading.AS_SAMPLED, axes(*texts), changes)


def run(folder: Path, *arguments: str, json_to: Path | None = None) -> int:
    """Run the sweep over the grid, with its certificates in `folder`."""
    more = [] if json_to is None else ["--json", str(json_to)]
    return main([*QUICK, *GRID, "--results", str(folder), *more, *arguments])


@pytest.fixture
def count(monkeypatch: pytest.MonkeyPatch) -> list[Problem]:
    """Return a list that receives every problem that the sweep computes, rather than reads."""
    computed: list[Problem] = []

    def counting(problem: Problem) -> Margin:
        computed.append(problem)
        return once(problem)

    monkeypatch.setattr(module, "margin", counting)
    return computed


def test_the_last_axis_varies_fastest() -> None:
    """A grid has all combinations, in the order of the axes and of their values."""
    assert described(swept("v_max=1:2", "T_c=0.05:0.1:0.025")) == [
        "T_c=0.05, v_max=1",
        "v_max=1",
        "T_c=0.025, v_max=1",
        "T_c=0.05",
        "",
        "T_c=0.025",
    ]
    assert len(swept("v_max=0.5:1:2", "T_c=0.01:0.1", "d_hat_min=0.25:0.35", "order=2:3")) == 24


def test_a_set_is_there_once() -> None:
    """Values that say the same make one set, in its first place."""
    assert described(swept("T_c=0.1:1/10:0.05:0.10")) == ["", "T_c=0.05"]


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (0, [""]),
        (1, ["", "d_hat_min=0.35", "v_max=1", "T_c=0.05", "T_c=0.02"]),
        (
            2,
            [
                "",
                "d_hat_min=0.35",
                "v_max=1",
                "d_hat_min=0.35, v_max=1",
                "T_c=0.05",
                "T_c=0.05, d_hat_min=0.35",
                "T_c=0.05, v_max=1",
                "T_c=0.02",
                "T_c=0.02, d_hat_min=0.35",
                "T_c=0.02, v_max=1",
            ],
        ),
    ],
)
def test_at_most_so_many_changes(changes: int, expected: list[str]) -> None:
    """With `--changes K` the base and all sets that differ from it in at most K of the axes are taken."""
    assert described(swept("T_c=0.05:0.02", "v_max=1", "d_hat_min=0.35", changes=changes)) == expected


def test_all_changes_are_the_grid_with_the_base() -> None:
    """As many changes as axes give the grid of the values and the base's, and more make no difference."""
    with_base = set(swept("T_c=0.1:0.05", "v_max=2:1"))
    assert set(swept("T_c=0.05", "v_max=1", changes=2)) == with_base
    assert set(swept("T_c=0.05", "v_max=1", changes=5)) == with_base


def test_the_sweep_is_around_its_base() -> None:
    """What is set for all holds in all sets, and a T_b that is T_s follows it."""
    base = Parameters().with_changes(["j_max=100", "v_max=1"])
    found = swept("T_s=0.1:0.3", "v_max=0.5", changes=1, base=base)
    assert described(found) == [
        "v_max=1, j_max=100",
        "v_max=0.5, j_max=100",
        "T_s=0.1, v_max=1, j_max=100",
        "T_s=0.3, v_max=1, j_max=100",
    ]
    assert [problem.parameters.T_b for problem in found] == [Fraction(number, 10) for number in (2, 2, 1, 3)]


def test_a_reading_is_swept_and_is_no_change() -> None:
    """`reading` is a name like the others, which decides what the set may be, and does not count as a change."""
    found = swept("reading=initial-state:as-sampled", "v_max=1", changes=1)
    assert [(problem.reading.value, problem.parameters.describe()) for problem in found] == [
        ("initial-state", ""),
        ("initial-state", "v_max=1"),
        ("as-sampled", ""),
        ("as-sampled", "v_max=1"),
    ]
    assert len(swept("reading=initial-state:whole-motion", "T_c=0.03:0.07")) == 4
    with pytest.raises(BadInput, match=r"set reading=as-sampled, T_c=0\.03: reading as-sampled needs T_s"):
        swept("reading=initial-state:as-sampled", "T_c=0.03")


def test_lists_are_values() -> None:
    """Values with commas are lists, as for `--set`."""
    found = swept("v_max=1,1,0.5:2", "theta_inverse=1:1,1,0.5")
    assert described(found)[:2] == [
        "v_max=1,1,0.5, theta_inverse=1",
        "v_max=1,1,0.5, theta_inverse=1,1,0.5",
    ]
    assert len(found) == 4


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("T_c=0.01..0.1/10", [f"0.{k:02d}".rstrip("0") for k in range(1, 11)]),
        ("v_max=2..0.5/4", ["2", "1.5", "1", "0.5"]),
        ("d_hat_min=1..2/4", ["1", "1.333333333", "1.666666667", "2"]),
        ("order=2..3/2", ["2", "3"]),
    ],
)
def test_ranges_have_both_ends(text: str, values: list[str]) -> None:
    """FROM..TO/STEPS has that many values, evenly spread, ends included, in decimals, upwards or downwards."""
    assert Axis.parse(text) == Axis(text.partition("=")[0], tuple(values))


def test_as_many_sets_as_are_allowed() -> None:
    """A sweep may have so many sets, and not one more."""
    assert len(swept("v_max=1..2/20", "j_max=1..2/50")) == MOST_SETS
    with pytest.raises(BadInput, match="more than 1000 parameter sets: take fewer values"):
        swept("v_max=1..2/20", "j_max=1..2/51")


def test_few_changes_of_many_axes_are_found_in_no_time() -> None:
    """Combinations with too many changes are not gone through: here they are 200 to the power of 5."""
    many = [f"{name}=1..2/200" for name in ("v_max", "a_max", "j_max", "d_hat_min")]
    assert len(swept(*many, "theta_inverse=1..2/200", changes=1)) == MOST_SETS


def test_every_set_has_a_name_of_its_own() -> None:
    """Certificates of different sets have different names, which any file system takes."""
    long = "theta_inverse=1.111111111,0.000000001,0,0.000000001,1.2,0.000000003,0,0.000000003,1.333333333"
    base = Parameters().with_changes([long, "workspace=-9.123456,9.123456,-9.123456,9.123456,-9.123456,9.123456"])
    found = [
        *swept("v_max=1,1,0.5:1,0.5,1", "tracking_error=0.01:0.02", "T_c=0.05:0.1"),
        *swept("tracking_error=0.01:0.02:0.03", base=base),
        *swept("v_max=1/3,2,5:1,3/2,5"),
        *swept("reading=initial-state:whole-motion:as-sampled"),
    ]
    names = [file_name(problem) for problem in found]
    assert len(set(names)) == len(found) == 16
    for name in names:
        assert name.isascii()
        assert not set(name) & set('/\\:*?"<>| ')
        assert len(name) <= 155
    assert names[0] == "as-sampled_T_c=0.05__v_max=1_1_0.5__tracking_error=0.01.json"


def test_nothing_is_computed_if_one_set_cannot_be(count: list[Problem], capsys: pytest.CaptureFixture[str]) -> None:
    """A set that its reading does not take is bad input before the first set is computed, and the set is named."""
    assert main([*QUICK, "--sweep", "v_max=1:2", "--sweep", "T_c=0.05:0.03"]) == 2
    assert count == []
    captured = capsys.readouterr()
    assert captured.err.startswith("swarmproof: --sweep, set v_max=1, T_c=0.03: reading as-sampled needs T_s")
    assert captured.err.count("\n") == 1


def test_json_of_a_sweep(capsys: pytest.CaptureFixture[str]) -> None:
    """A sweep's document has, in order, the documents that the command writes for each set by itself."""
    code = main([*QUICK, *GRID, "--json", "-"])
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert list(document) == ["schema", "sets"]
    assert document["schema"] == "swarmproof.margin-sweep/1"
    parameters = [one["parameters"] for one in document["sets"]]
    assert [(one["v_max"][0], one["T_c"]) for one in parameters] == [(1, 0.025), (1, 0.05), (2, 0.025), (2, 0.05)]
    assert code == 0
    for one, changes in ((0, ["v_max=1", "T_c=0.025"]), (3, ["v_max=2"])):
        settings = [word for change in changes for word in ("--set", change)]
        assert main([*QUICK, *settings, "--json", "-"]) == 0
        assert json.loads(capsys.readouterr().out) == document["sets"][one]
    table = " ".join(captured.err.split())
    assert "reading changed" in table
    assert table.count("holds holds") == 4


def test_a_table_has_the_interval(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """On the terminal there is a row per set, with the interval rounded outwards."""
    monkeypatch.setenv("COLUMNS", "160")
    assert main([*QUICK, "--sweep", "v_max=1"]) == 0
    (row,) = [line.split() for line in capsys.readouterr().out.splitlines() if "as-sampled" in line]
    base = Parameters().with_changes(["order=2", "T_s=0.05", "T_c=0.05", "v_max=1"])
    found = once(Problem(base, Reading.AS_SAMPLED))
    assert row[:5] == ["as-sampled", "T_c=0.05,", "T_s=0.05,", "v_max=1,", "order=2"]
    low, high = Fraction(row[5]), Fraction(row[7])
    assert low <= found.lower <= found.upper <= high
    assert max(found.lower - low, high - found.upper) < Fraction(1, 10**6)


@pytest.mark.parametrize(
    ("uppers", "code"),
    [(["0.01", "0.02"], 0), (["0.01", "0.2"], 3), (["0.01", "0.25"], 1), (["0.2", "0.25"], 1), (["0.25", "0.2"], 1)],
)
def test_the_exit_code_is_the_worst(uppers: list[str], code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """One set that fails makes the sweep fail, otherwise one that is undecided makes it undecided."""
    left = [Fraction(upper) for upper in uppers]

    def wide(problem: Problem) -> Margin:
        upper = left.pop(0)
        return Margin(problem, Fraction(1, 4) if upper == Fraction(1, 4) else Fraction(0), upper, None, {})

    monkeypatch.setattr(module, "margin", wide)
    assert main(["margin", "--sweep", "v_max=1:2"]) == code


def test_a_second_run_computes_nothing(
    tmp_path: Path, count: list[Problem], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A sweep into a folder that has all its certificates takes them from there, and finds the same."""
    folder, first, second = tmp_path / "new" / "results", tmp_path / "first.json", tmp_path / "second.json"
    assert run(folder, json_to=first) == 0
    assert len(count) == 4
    names = {file_name(problem) for problem in count}
    assert {path.name for path in folder.iterdir()} == names
    assert f"Certificates: {folder}" in capsys.readouterr().out
    assert run(folder, json_to=second) == 0
    assert len(count) == 4
    assert first.read_bytes() == second.read_bytes()
    for path in folder.iterdir():
        assert main(["margin", "--check", str(path)]) == 0


def test_a_larger_sweep_takes_what_is_there(tmp_path: Path, count: list[Problem]) -> None:
    """A sweep with one more value computes that one only."""
    assert main([*QUICK, "--sweep", "v_max=1:2", "--results", str(tmp_path)]) == 0
    assert main([*QUICK, "--sweep", "v_max=0.5:1:2", "--results", str(tmp_path)]) == 0
    assert [problem.parameters.v_max[0] for problem in count] == [1, 2, Fraction(1, 2)]


def test_an_interrupted_run_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ctrl-C in the third set leaves the certificates of two, exit code 130; another run computes the other two."""
    computed: list[Problem] = []

    def interrupted(problem: Problem) -> Margin:
        if len(computed) == 2:
            raise KeyboardInterrupt
        computed.append(problem)
        return once(problem)

    monkeypatch.setattr(module, "margin", interrupted)
    assert run(tmp_path) == 130
    assert capsys.readouterr().err.splitlines()[-1].startswith("swarmproof: interrupted")
    kept = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert kept.keys() == {file_name(problem) for problem in computed}

    def rest(problem: Problem) -> Margin:
        assert problem not in computed
        computed.append(problem)
        return once(problem)

    monkeypatch.setattr(module, "margin", rest)
    assert run(tmp_path) == 0
    assert len(computed) == 4
    assert {name: (tmp_path / name).read_bytes() for name in kept} == kept


def test_an_interrupted_certificate_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A certificate is in the folder whole or not at all, even if Ctrl-C comes while it is written."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupt)
    assert run(tmp_path) == 130
    assert [path for path in tmp_path.iterdir() if path.suffix == ".json"] == []
    monkeypatch.undo()
    assert run(tmp_path) == 0
    assert {path.suffix for path in tmp_path.iterdir()} == {".json"}


def test_damaged_and_foreign_certificates_are_computed_again(
    tmp_path: Path, count: list[Problem], capsys: pytest.CaptureFixture[str]
) -> None:
    """What is not a right certificate of the very set is not believed, whatever is wrong with it, but replaced."""
    assert run(tmp_path) == 0
    right = {file_name(problem): (tmp_path / file_name(problem)).read_bytes() for problem in count}
    names = list(right)
    cut, altered = right[names[0]][:-100], json.loads(right[names[1]])
    altered["dip"]["upper"] = altered["dip"]["lower"]
    wrong: list[bytes] = [b"", cut, b"[" * 100_000, b"\xff\xfe", b"null", json.dumps(altered).encode()]
    (tmp_path / names[3]).write_bytes(right[names[2]])  # foreign: a right one, of another set
    for content in wrong:
        count.clear()
        (tmp_path / names[0]).write_bytes(content)
        assert run(tmp_path) == 0
        assert file_name(count[0]) == names[0]
        said = [line for line in capsys.readouterr().err.splitlines() if "does not count" in line]
        assert f"{names[0]} does not count, and is computed again: " in said[0]
        assert ("is about other parameters" in said[-1]) == (content == wrong[0])
        assert {name: (tmp_path / name).read_bytes() for name in names} == right
    assert len(count) == 1


def test_a_right_certificate_of_another_tracking_error_is_foreign(tmp_path: Path, count: list[Problem]) -> None:
    """Certificates are of all parameters: one with another tracking error is not taken, right as its interval is."""
    found = once(swept("T_c=0.05")[0])
    given = replace(found.problem.parameters, tracking_error=Fraction(1, 100))
    other = Problem(given, Reading.AS_SAMPLED)
    (tmp_path / file_name(other)).write_text(certificate_text(found))
    told: list[tuple[int, bool]] = []
    (again,) = sweep([other], tmp_path, lambda number, _, result: told.append((number, result is not None)), print)
    assert count == [other]
    assert told == [(0, False), (0, True)]
    assert (again.problem, again.lower, again.upper) == (other, found.lower, found.upper)


def test_a_plot_of_a_sweep(tmp_path: Path) -> None:
    """`--plot` draws the sweep's curves."""
    path = tmp_path / "sweep.svg"
    assert main([*QUICK, *GRID, "--plot", str(path)]) == 0
    assert "<svg" in path.read_text(encoding="utf-8")
