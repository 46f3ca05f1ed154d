"""`swarmproof margin`: what it prints and writes, its exit codes, and one sentence for bad input."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from swarmproof.cli import main
from swarmproof.commands import margin as command
from swarmproof.margin.bounds import Margin, margin
from swarmproof.margin.certificate import digest
from swarmproof.margin.problem import Problem
from swarmproof.pages import rounding
from swarmproof.pages.margin import words as margin_words
from swarmproof.theorem3.inequality import Truth, corrected, printed
from swarmproof.theorem3.parameters import EXTENSIONS, NAMES, Parameters, Reading

Json = dict[str, Any]

#: With collision samples every 0.05 s, the corrected inequality holds for the published parameters otherwise.
HOLDS = ["margin", "--set", "T_c=0.05"]
ALL_NAMES = """
T_c = 0.05
T_s = 0.1
T_b = 0.05
d_hat_min = 0.3
v_max = [1, 1.5, 0.5]
a_max = 4
j_max = 100.0
theta_inverse = [1, 1, 0.5]
order = 2
workspace = [[-2, 2], [-2, 2], [0, 2]]
d_min = 0.1
tracking_error = 1e-2
"""


#: The command's computation, but each margin is computed once for all tests.
once = cache(margin)


def computed(*changes: str) -> Margin:
    """Return the margin that the command finds with these changes."""
    return once(Problem(Parameters().with_changes(changes), Reading.AS_SAMPLED))


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the command compute each margin once for all tests; nobody is told how it goes."""
    monkeypatch.setattr(command, "margin", lambda problem, say: once(problem))


@pytest.fixture
def instead(monkeypatch: pytest.MonkeyPatch) -> Callable[[Margin], None]:
    """Return what makes the command find a given margin instead of computing one."""

    def use(found: Margin) -> None:
        monkeypatch.setattr(command, "margin", lambda problem, say: replace(found, problem=problem))

    return use


def documents(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, Json, str]:
    """Run `margin ... --json -` and return the exit code, the document and the words."""
    code = main([*arguments, "--json", "-"])
    captured = capsys.readouterr()
    document: Json = json.loads(captured.out)
    return code, document, " ".join(captured.err.split())


def words(capsys: pytest.CaptureFixture[str]) -> str:
    """Return what was printed, as one line."""
    return " ".join(capsys.readouterr().out.split())


def test_published_parameters_fail(capsys: pytest.CaptureFixture[str]) -> None:
    """For the published parameters two UAVs can meet between two samples: both inequalities fail, and no collision."""
    code, document, said = documents(capsys, "margin")
    assert code == 1
    assert document["dip"] == {"lower": 0.25, "upper": 0.25}
    assert document["reading"] == "as-sampled"
    assert document["parameters"] == Parameters().as_json()
    assert document["theorem_3"] == {
        "printed": "fails",
        "corrected": "fails",
        "d_min": 0.12,
        "tracking_error": 0.0,
        "guaranteed_separation": 0.0,
        "counterexample": None,
    }
    assert document["solve_for"] is None
    assert "all of d̂_min: two UAVs can be in one place between two samples" in said
    assert "An inequality that fails is no collision" in said
    assert "vacuous for everybody" in said


def test_shorter_windows_hold(capsys: pytest.CaptureFixture[str]) -> None:
    """With T_c = 0.05 s the corrected inequality holds, exit code 0, and nobody is told about failing."""
    assert main(HOLDS) == 0
    said = words(capsys)
    assert "reading as-sampled, T_c=0.05, triple integrator" in said
    assert "(26) as printed holds" in said
    assert "(26) corrected holds" in said
    assert "collision" not in said
    assert "counterexample" not in said


def test_json_has_the_keys_of_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    """The document has the published keys in their order, floats as numbers, and both UAVs' states."""
    code, document, _ = documents(capsys, *HOLDS)
    assert code == 0
    keys = ["schema", "parameters", "defaults", "reading", "dip", "witness", "theorem_3", "about_nothing", "solve_for"]
    assert list(document) == keys
    assert document["schema"] == "swarmproof.margin/1"
    assert tuple(document["parameters"]) == tuple(name for name in NAMES if name not in EXTENSIONS)
    assert document["parameters"]["T_c"] == 0.05
    assert document["parameters"]["workspace"] is None
    assert list(document["dip"]) == ["lower", "upper"]
    assert all(isinstance(value, float) for value in document["dip"].values())
    keys = ["printed", "corrected", "d_min", "tracking_error", "guaranteed_separation", "counterexample"]
    assert list(document["theorem_3"]) == keys
    assert all(isinstance(document["theorem_3"][key], float) for key in keys[2:5])
    witness = document["witness"]
    assert list(witness) == ["window", "tau", "distance", "uav_i", "uav_j", "inputs_i", "inputs_j"]
    assert witness["window"] == [0.05, 0.1]
    assert 0 < witness["tau"] < 0.05
    assert min(witness["distance"]["start"], witness["distance"]["end"]) == pytest.approx(0.25, abs=1e-6)
    assert witness["distance"]["closest"] == pytest.approx(0.25 - document["dip"]["lower"], abs=1e-11)
    for uav in ("uav_i", "uav_j"):
        assert list(witness[uav]) == ["start", "closest", "end"]
        for state in witness[uav].values():
            assert {name: len(values) for name, values in state.items()} == {
                "position": 3,
                "velocity": 3,
                "acceleration": 3,
            }
    for inputs in ("inputs_i", "inputs_j"):
        assert [[duration for duration, _ in axis] for axis in witness[inputs]] == [[0.2]] * 3
        assert all(abs(jerk) <= 5 for axis in witness[inputs] for _, jerk in axis)


def test_floats_are_on_the_safe_side(capsys: pytest.CaptureFixture[str]) -> None:
    """The floats of the interval enclose it, by one unit at most, and so do the decimals in words."""
    found = computed("T_c=0.05")
    _, document, said = documents(capsys, *HOLDS)
    lower, upper = Fraction(document["dip"]["lower"]), Fraction(document["dip"]["upper"])
    assert lower <= found.lower <= found.upper <= upper
    assert max(found.lower - lower, upper - found.upper) < Fraction(1, 10**16)
    assert Fraction(document["theorem_3"]["guaranteed_separation"]) <= Fraction(1, 4) - found.upper
    low, high = said.split("between ", 1)[1].split(" m (width")[0].split(" m and ")
    assert Fraction(low) <= found.lower <= found.upper <= Fraction(high)
    separation = said.split("guaranteed separation ", 1)[1].split(" m ")[0]
    assert Fraction(separation) <= Fraction(1, 4) - found.upper


@pytest.mark.parametrize("value", [Fraction(1, 3), Fraction(2, 3), Fraction(1, 10), Fraction(1, 4), Fraction(0)])
def test_rounding_has_a_direction(value: Fraction) -> None:
    """Floats and decimals below are the nearest that are not above, and the other way round."""
    low, high = Fraction(rounding.below(value)), Fraction(rounding.above(value))
    assert low <= value <= high
    assert high - low < Fraction(2, 10**16)
    low, high = Fraction(rounding.decimal_below(value, 6)), Fraction(rounding.decimal_above(value, 6))
    assert low <= value <= high
    assert high - low == (0 if value.denominator in (1, 4, 10) else Fraction(1, 10**6))


def test_json_goes_to_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`--json FILE` writes what `--json -` prints, makes the folder, and leaves the words on standard output."""
    path = tmp_path / "new" / "result.json"
    assert main([*HOLDS, "--json", str(path)]) == 0
    assert "Δd_min,cont" in words(capsys)
    assert json.loads(path.read_text(encoding="utf-8")) == documents(capsys, *HOLDS)[1]


@pytest.mark.parametrize(
    ("lower", "upper", "verdict", "code"),
    [
        ("0.10", "0.13", "holds", 0),  # d̂_min − d_min is 0.13
        ("0.10", "0.1300001", "undecided", 3),
        ("0.13", "0.14", "undecided", 3),
        ("0.1300001", "0.14", "fails", 1),
    ],
)
def test_verdicts_need_the_right_end(
    lower: str,
    upper: str,
    verdict: str,
    code: int,
    instead: Callable[[Margin], None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    """*holds* needs the upper end of the interval, *fails* the lower one; anything else is undecided, exit code 3."""
    instead(replace(computed("T_c=0.05"), lower=Fraction(lower), upper=Fraction(upper)))
    found, document, said = documents(capsys, *HOLDS)
    assert found == code
    assert document["theorem_3"]["corrected"] == document["theorem_3"]["printed"] == verdict
    assert f"(26) corrected {verdict}" in said
    assert ("no collision" in said) == (verdict != "holds")
    assert document["theorem_3"]["guaranteed_separation"] == pytest.approx(0.25 - float(upper), abs=1e-12)


def test_between_the_ends_it_is_undecided(capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing invented: if d_min is chosen such that the limit is within the interval, it is undecided."""
    found = computed("T_c=0.05")
    middle = round((found.lower + found.upper) / 2, 10)
    assert found.lower < middle < found.upper
    code, document, _ = documents(capsys, *HOLDS, "--d-min", str(Fraction(1, 4) - middle))
    assert (code, document["theorem_3"]["corrected"]) == (3, "undecided")


def test_the_options_for_numbers_win(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`--d-min` and `--tracking-error` are short for `--set`, and `--set` overrides the file, the last one last."""
    file = tmp_path / "swarm.toml"
    file.write_text(ALL_NAMES, encoding="utf-8")
    changes = ["--set", "T_c=0.1", "--set", "v_max=2,1,0.5", "--set", "T_c=0.05", "--set", "tracking_error=0.5"]
    code, document, _ = documents(
        capsys, "margin", str(file), *changes, "--d-min", "1/8", "--tracking-error", "0.02", "--set", "order=3"
    )
    assert code in (0, 1)
    assert document["parameters"] == {
        "T_c": 0.05,
        "T_s": 0.1,
        "T_b": 0.05,
        "d_hat_min": 0.3,
        "v_max": [2.0, 1.0, 0.5],
        "a_max": [4.0, 4.0, 4.0],
        "j_max": [100.0, 100.0, 100.0],
        "theta_inverse": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.5]],
        "order": 3,
        "workspace": [[-2.0, 2.0], [-2.0, 2.0], [0.0, 2.0]],
        "d_min": 0.125,
        "tracking_error": 0.02,
    }
    assert (document["theorem_3"]["d_min"], document["theorem_3"]["tracking_error"]) == (0.125, 0.02)


def test_all_names_in_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file with every name is the same as the published parameters with every name set."""
    file = tmp_path / "swarm.toml"
    file.write_text(ALL_NAMES, encoding="utf-8")
    code, document, said = documents(capsys, "margin", str(file))
    lists = {"v_max": "1,1.5,0.5", "theta_inverse": "1,1,0.5", "workspace": "-2,2,-2,2,0,2"}
    changes = []
    for line in ALL_NAMES.strip().splitlines():
        name, value = line.split(" = ")
        changes += ["--set", f"{name}={lists.get(name, value)}"]
    assert (code, document) == documents(capsys, "margin", *changes)[:2]
    assert "double integrator (acceleration input)" in said
    assert "within the workspace" in said


@pytest.mark.parametrize("reading", [Reading.INITIAL_STATE, pytest.param(Reading.WHOLE_MOTION, marks=pytest.mark.deep)])
def test_every_reading_can_be_asked_for(reading: Reading, capsys: pytest.CaptureFixture[str]) -> None:
    """The document and the words name the reading, and its window begins at 0."""
    code, document, said = documents(capsys, *HOLDS, "--reading", reading.value)
    assert (code, document["reading"]) == (0, reading.value)
    assert document["witness"]["window"] == [0.0, 0.05]
    assert f"reading {reading.value}" in said


def test_a_counterexample_to_the_printed_inequality(capsys: pytest.CaptureFixture[str]) -> None:
    """Where the printed inequality holds and the corrected one fails, exact positions show that it promises nothing.

    With fractions: the tracking errors are allowed, and the UAVs come closer than d_min. The references are a pair at
    its closest, so at most d̂_min, and as far apart as the certified interval allows.
    """
    error = Fraction(6, 100)
    code, document, said = documents(capsys, *HOLDS, "--tracking-error", "0.06")
    theorem = document["theorem_3"]
    assert (code, theorem["printed"], theorem["corrected"]) == (1, "holds", "fails")
    found = theorem["counterexample"]
    assert list(found) == ["references", "positions", "scaled_distance"]
    references = [[Fraction(value) for value in point] for point in found["references"]]
    positions = [[Fraction(value) for value in point] for point in found["positions"]]
    scaling = (Fraction(1), Fraction(1), Fraction(1, 6))

    def squared(pair: Sequence[list[Fraction]], scales: tuple[Fraction, ...]) -> Fraction:
        return sum(((s * (a - b)) ** 2 for s, a, b in zip(scales, *pair, strict=True)), Fraction(0))

    for reference, position in zip(references, positions, strict=True):
        assert squared((reference, position), (Fraction(1),) * 3) <= error**2
    assert squared(positions, scaling) < Fraction(12, 100) ** 2
    assert found["scaled_distance"] == pytest.approx(float(squared(positions, scaling)) ** 0.5, rel=1e-9)
    closest = Fraction(1, 4) - computed("T_c=0.05").upper
    assert closest**2 <= squared(references, scaling) <= Fraction(1, 4) ** 2
    assert "counterexample the printed (26) holds, yet references at" in said
    assert "An inequality that fails is no collision" in said


def test_no_counterexample_where_both_agree(capsys: pytest.CaptureFixture[str]) -> None:
    """There is none where the printed inequality fails, too, or where the corrected one holds."""
    for error, verdicts in (("0.02", ("holds", "holds")), ("0.2", ("fails", "fails"))):
        _, document, _ = documents(capsys, *HOLDS, "--tracking-error", error)
        theorem = document["theorem_3"]
        assert (theorem["printed"], theorem["corrected"], theorem["counterexample"]) == (*verdicts, None)


def test_a_certificate_is_accepted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What `--certificate` writes, `--check` accepts, and says the same of it; exit code 0 whatever it says of (26)."""
    path = tmp_path / "new" / "certificate.json"
    code, document, _ = documents(capsys, *HOLDS, "--tracking-error", "0.06", "--certificate", str(path))
    assert code == 1
    assert sorted(file.name for file in path.parent.iterdir()) == ["certificate.json"]
    assert main(["margin", "--check", str(path)]) == 0
    said = words(capsys)
    assert said.startswith("accepted")
    assert "(26) corrected fails" in said
    code, checked, said = documents(capsys, "margin", "--check", str(path))
    # a certificate has all values, and does not say which of them were given
    assert (code, checked) == (0, {**document, "defaults": {}})
    document = checked
    assert said.startswith("accepted")
    target = tmp_path / "checked" / "result.json"
    assert main(["margin", "--check", str(path), "--json", str(target)]) == 0
    assert json.loads(target.read_text(encoding="utf-8")) == document


def test_an_altered_certificate_is_rejected(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A certificate with one number changed is rejected with exit code 1, and the sentence says where."""
    path = tmp_path / "certificate.json"
    assert main([*HOLDS, "--certificate", str(path)]) == 0
    capsys.readouterr()
    content = json.loads(path.read_text(encoding="ascii"))
    content["dip"]["upper"] = "0.045"
    path.write_text(json.dumps(content), encoding="ascii")
    assert main(["margin", "--check", str(path)]) == 1
    captured = capsys.readouterr()
    assert captured.out.startswith("rejected: digest")
    assert captured.out.count("\n") == 1
    path.write_text(json.dumps({"schema": content["schema"]}), encoding="ascii")
    assert main(["margin", "--check", str(path), "--json", "-"]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("rejected: expected an object with these keys")


@pytest.mark.parametrize("text", ["[1, 2]", '{"pieces": [1, 2]}', "3"])
def test_other_json_is_no_rejected_certificate(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What never was a certificate is bad input: nothing is said of a proof."""
    path = tmp_path / "pair.json"
    path.write_text(text, encoding="ascii")
    assert main(["margin", "--check", str(path)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "pair.json is JSON, but no certificate of swarmproof: give a file that --certificate has written" in said.err


def test_a_certificate_does_not_replace_a_device() -> None:
    """A certificate goes into what is no regular file, such as a pipe or the null device, and does not replace it."""
    before = os.stat(os.devnull)
    assert main([*HOLDS, "--certificate", os.devnull]) == 0
    after = os.stat(os.devnull)
    assert (after.st_mode, after.st_rdev) == (before.st_mode, before.st_rdev)


def test_a_plot_is_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`--plot` draws the worst pair."""
    path = tmp_path / "new" / "pair.svg"
    assert main([*HOLDS, "--plot", str(path)]) == 0
    assert "<svg" in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("--set theta_inverse=1,1,0", "theta_inverse is singular: it must be invertible"),
        ("--set theta_inverse=1,2,0,2,4,0,0,0,1", "theta_inverse is singular"),
        ("--set theta_inverse=1,0,1,0,1,0,0,0,1", "theta_inverse is not symmetric"),
        ("--set theta_inverse=1,1,-1", "theta_inverse is not positive definite"),
        ("--set v_max=-1", "v_max must not be negative on any axis, as -1 is"),
        ("--set a_max=1,-0.5,1", "a_max must not be negative on any axis, as -0.5 is"),
        ("--set j_max=-2", "j_max must not be negative"),
        ("--set T_c=0.03", "T_s=0.2 is 20/3 times T_c=0.03"),
        ("--set T_c=0.4", "reading as-sampled needs T_s to be a whole multiple of T_c"),
        ("--set T_b=0.15", "reading as-sampled needs T_s to be a whole multiple of T_b"),
        ("--set T_c=0", "T_c must be positive, not 0"),
        ("--set d_hat_min=-1", "d_hat_min must be positive"),
        ("--set order=4", "order is 2 (input acceleration) or 3 (input jerk), not 4"),
        ("--set workspace=1,0,0,1,0,1", "workspace has a low x=1 above its high x=0"),
        ("--set workspace=1,2,3", "workspace takes low and high"),
        ("--set vmax=1", "there is no parameter 'vmax': did you mean v_max?"),
        ("--set v_max", "--set 'v_max' is not of the form NAME=VALUE"),
        ("--set v_max=fast", "'fast' is not a number"),
        ("--set v_max=nan", "'nan' is not a number"),
        ("--set v_max=1e99", "out of range"),
        ("--set v_max=1,2", "v_max takes one number, or three"),
        ("--d-min 0", "d_min must be positive, not 0"),
        ("--d-min none", "'none' is not a number"),
        ("--tracking-error -0.1", "tracking_error must not be negative, as -0.1 is"),
        ("--reading sampled", "there is no reading 'sampled': choose initial-state, whole-motion or as-sampled"),
        ("DIR/nothing.toml", "cannot read the parameter file"),
        ("DIR", "cannot read the parameter file"),
        ("FILE", "is not TOML"),
        ("DIR/unknown.toml", "there is no parameter 'speed'"),
        ("DIR/table.toml", "'swarm' is a table"),
        ("--solve-for j_max", "invalid choice: 'j_max'"),
        ("--solve-for T_c --sweep v_max=1:2", "--sweep goes neither with --certificate nor with --solve-for"),
        ("--certificate DIR/c.json --sweep v_max=1:2", "--sweep goes neither with --certificate nor with --solve-for"),
        ("--certificate -", "--certificate - is not a file"),
        ("--sweep T_c", "--sweep 'T_c' is not of the form NAME=V1:V2"),
        ("--sweep =1:2", "--sweep '=1:2' is not of the form"),
        ("--sweep T_c=", "--sweep 'T_c=' is not of the form"),
        ("--sweep speed=1:2", "--sweep, set speed=1: there is no parameter 'speed'"),
        ("--sweep T_c=0.05::0.1", "--sweep, set T_c=: T_c: '' is not a number"),
        ("--sweep T_c=0.05:0.03", "--sweep, set T_c=0.03: reading as-sampled needs T_s"),
        ("--sweep reading=all", "there is no reading 'all'"),
        ("--sweep T_c=0.1 --sweep T_c=0.05", "--sweep varies T_c twice: give all its values at once"),
        ("--sweep v_max=1..2", "a range is FROM..TO/STEPS with 2 to 200 steps"),
        ("--sweep v_max=1..2/1", "a range is FROM..TO/STEPS with 2 to 200 steps"),
        ("--sweep v_max=1..2/201", "a range is FROM..TO/STEPS with 2 to 200 steps"),
        ("--sweep v_max=1..2/²", "a range is FROM..TO/STEPS with 2 to 200 steps"),
        ("--sweep v_max=a..2/3", "--sweep 'v_max=a..2/3': 'a' is not a number"),
        ("--sweep v_max=1..2/200 --sweep j_max=1..2/200", "the sweep has more than 1000 parameter sets"),
        ("--changes 1", "--changes goes with --sweep, which is not given"),
        ("--results DIR/results", "--results goes with --sweep, which is not given"),
        ("--sweep v_max=1:2 --changes one", "'one' is no whole number of at least 0"),
        ("--sweep v_max=1:2 --changes ²", "'²' is no whole number of at least 0"),
        ("--sweep v_max=1:2 --results FILE", "cannot write to"),
        ("--json FILE/x.json", "cannot write"),
        ("--json DIR", "cannot write"),
        ("--certificate FILE/x.json", "cannot write"),
        ("--certificate DIR", "cannot write"),
        ("--plot FILE/x.svg", "cannot write"),
        ("--plot DIR/x.gif", "give a file whose name ends in .svg, .png or .pdf"),
        ("--sweep v_max=1:2 --plot DIR/x.gif", "give a file whose name ends in .svg, .png or .pdf"),
        ("--check DIR/nothing.json", "nothing.json: No such file"),
        ("--check DIR", "cannot read the certificate"),
        ("--check FILE", "is no JSON: give a file that --certificate has written"),
        ("--check DIR/deep.json", "is no JSON"),
        ("--check FILE --set T_c=0.05", "--check goes with --json only"),
        ("--check FILE --solve-for T_c", "--check goes with --json only"),
        ("--check FILE --plot DIR/x.svg", "--check goes with --json only"),
        ("--check FILE DIR/unknown.toml", "--check goes with --json only"),
        ("--check", "expected one argument"),
        ("--bogus", "--bogus"),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: str,
    sentence: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Bad input ends with exit code 2 and one line that says what is wrong, before anything is computed or written."""

    def fail(*_: object) -> None:
        raise AssertionError("something was computed")

    for place in ("margin", "solve_for", "sweep"):
        monkeypatch.setattr(command, place, fail)
    folder = tmp_path / "folder"
    folder.mkdir()
    (tmp_path / "file").write_text("neither TOML nor JSON", encoding="utf-8")
    (folder / "unknown.toml").write_text("speed = 1\n", encoding="utf-8")
    (folder / "table.toml").write_text("[swarm]\nT_c = 0.1\n", encoding="utf-8")
    (folder / "deep.json").write_text("[" * 100_000, encoding="utf-8")
    before = sorted(folder.iterdir())
    filled = (word.replace("FILE", str(tmp_path / "file")).replace("DIR", str(folder)) for word in arguments.split())
    assert main(["margin", *filled]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("swarmproof: ")
    assert captured.err.count("\n") == 1
    assert sentence in captured.err
    assert sorted(folder.iterdir()) == before
    assert (tmp_path / "file").read_text(encoding="utf-8") == "neither TOML nor JSON"


def test_what_cannot_be_written_in_the_end_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder that is gone when the result is written is a failure of the world; the verdict is told all the same."""
    monkeypatch.setattr(command, "_reserve", lambda options: None)
    for option in ("--json", "--certificate"):
        assert main([*HOLDS, option, str(tmp_path / "gone" / "file.json")]) == 4
        captured = capsys.readouterr()
        assert captured.err.startswith("swarmproof: ")
        assert captured.err.count("\n") == 1
        assert "(26) corrected" in captured.out


def test_a_certificate_of_other_parameters_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A certificate signed anew after its parameters were changed proves nothing about them."""
    content = json.loads(json.dumps(computed("T_c=0.05").certificate))
    del content["digest"]
    content["parameters"]["v_max"] = ["4", "4", "4"]
    path = tmp_path / "certificate.json"
    path.write_text(json.dumps({**content, "digest": digest(content)}), encoding="ascii")
    assert main(["margin", "--check", str(path)]) == 1
    said = words(capsys)
    assert said.startswith("rejected: window ")
    assert "a pair of motions may come closer than upper claims" in said


def test_interrupting_is_no_traceback(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Ctrl-C ends the command with exit code 130 and one line."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "margin", interrupt)
    assert main(HOLDS) == 130
    assert capsys.readouterr().err.startswith("swarmproof: interrupted")


def test_verdicts_are_exact() -> None:
    """Verdicts in the document are those of exact arithmetic with the interval, on both sides of each limit."""
    found = computed("T_c=0.05")
    for error in (Fraction(0), Fraction(42, 1000), Fraction(43, 1000), Fraction(84, 1000), Fraction(85, 1000)):
        given = replace(found.problem.parameters, tracking_error=error)
        one = replace(found, problem=Problem(given, Reading.AS_SAMPLED))
        theorem = margin_words.document(one)["theorem_3"]
        room = Fraction(13, 100) - found.upper
        assert (theorem["corrected"] == "holds") == (2 * error <= room)
        assert (theorem["printed"] == "holds") == (error <= room)
        assert corrected(given, found.lower, found.upper) is Truth(theorem["corrected"])
        assert printed(given, found.lower, found.upper) is Truth(theorem["printed"])
        assert theorem["counterexample"] is None or 2 * error > room >= error
