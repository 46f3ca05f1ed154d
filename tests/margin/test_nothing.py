"""Margins about motions that cannot be: said in words, and no success; and which values nobody gave."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from swarmproof.cli import main
from swarmproof.margin.problem import Problem
from swarmproof.margin.solve import decide, solve_for
from swarmproof.theorem3.inequality import Truth
from swarmproof.theorem3.nothing import about_nothing
from swarmproof.theorem3.parameters import NAMES, Parameters, Reading


def parameters(*changes: str) -> Parameters:
    """Return the published parameters with changes."""
    return Parameters().with_changes(changes)


def margin(capsys: pytest.CaptureFixture[str], code: int, *arguments: str) -> tuple[dict[str, Any], str]:
    """Run `margin`, and return its document and its words."""
    assert main(["margin", *arguments, "--json", "-"]) == code
    captured = capsys.readouterr()
    return json.loads(captured.out), " ".join(captured.err.split())


def reachable(v: int, a: int, j: int, order: int, reading: Reading, samples: list[float]) -> bool:
    """Say whether some input moves a UAV, by trying some, with all states bounded at the `samples` of T_s = 1 s.

    (Bounds are 0 or 1, so that an allowed motion need only be small.)
    """
    small = 1e-3
    top = j if order == 3 else a
    inputs = (0.0, small, -small) if top else (0.0,)
    speeds = (0.0, small) if v else (0.0,)
    accelerations = (
        ((0.0, small, -small / 2) if a or reading is Reading.AS_SAMPLED else (0.0,)) if order == 3 else (0.0,)
    )
    for speed, acceleration, u in product(speeds, accelerations, inputs):
        if not (speed or acceleration or u):
            continue

        def at(t: float, s: float = speed, c: float = acceleration, u: float = u) -> tuple[float, float]:
            """Return speed and acceleration at time t."""
            return (s + c * t + u * t * t / 2, c + u * t) if order == 3 else (s + u * t, u)

        times = {Reading.INITIAL_STATE: [0.0], Reading.AS_SAMPLED: samples}.get(reading, [0.0, 0.3, 0.5, 0.9, 1.0])
        states = [at(t) for t in times]
        fits_v = v or all(abs(state[0]) < 1e-12 for state in states)
        fits_a = order == 2 or a or all(abs(state[1]) < 1e-12 for state in states)
        if fits_v and fits_a:
            return True
    return False


@pytest.mark.parametrize("reading", list(Reading))
@pytest.mark.parametrize("order", [2, 3])
def test_who_can_move(order: int, reading: Reading) -> None:
    """With every choice of bounds that are 0, it is said that nobody can move exactly if no small input moves a UAV."""
    for v, a, j, T_b in product((0, 1), (0, 1), (0, 1), (0.5, 1)):
        bounds = (f"v_max={v}", f"a_max={a}", f"j_max={j}", f"order={order}", "T_s=1", f"T_b={T_b}", "T_c=0.5")
        moves = reachable(v, a, j, order, reading, [0.0, 1.0] if T_b == 1 else [0.0, 0.5, 1.0])
        assert ("no UAV can move" in about_nothing(parameters(*bounds), reading)) == (not moves), bounds


def test_one_axis_is_enough() -> None:
    """A UAV that can move on one axis moves; a bound of 0 on the norm stops it like bounds of 0 on all axes."""
    whole = Reading.WHOLE_MOTION
    assert about_nothing(parameters("v_max=0,0,0.001"), whole) == ""
    assert "v_max = 0" in about_nothing(parameters("v_max=0"), whole)
    assert about_nothing(parameters("v_norm=0"), whole)


@pytest.mark.parametrize(
    ("workspace", "room"),
    [
        ("0,0.25,0,0,0,0", True),
        ("0,0.2499999999,0,0,0,0", False),
        ("0,0.15,0,0.2,0,0", True),
        ("0,0,0,0,0,1.5", True),
        ("0,0,0,0,0,1.4999", False),
        ("0,0,0,0,0,inf", True),
        ("none", True),
    ],
)
def test_room_for_two(workspace: str, room: bool) -> None:
    """There is room exactly if the longest way through the workspace, scaled, is d̂_min."""
    found = about_nothing(parameters(f"workspace={workspace}"), Reading.AS_SAMPLED)
    assert found == "" if room else found.startswith("no two UAVs can be d_hat_min = 0.25 m apart")


def test_nothing_is_no_success(capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 3, not-applicable for both forms of (26), and the reason, in words and in JSON; else none."""
    content, said = margin(capsys, 3, "--set", "v_max=0", *QUICK)
    assert content["theorem_3"]["printed"] == content["theorem_3"]["corrected"] == "not-applicable"
    assert content["about_nothing"].startswith("no UAV can move (v_max = 0)")
    assert "about nothing no UAV can move" in said
    assert "holds" not in said
    content, said = margin(capsys, 0, "--set", "v_max=0.1", *QUICK)
    assert content["about_nothing"] is None
    assert content["theorem_3"]["corrected"] == "holds"
    assert "about nothing" not in said


def test_nothing_in_a_sweep(capsys: pytest.CaptureFixture[str]) -> None:
    """In a sweep, a set about nothing is no success either."""
    content, said = margin(capsys, 3, "--sweep", "v_max=0:0.1", *QUICK)
    assert [one["theorem_3"]["corrected"] for one in content["sets"]] == ["not-applicable", "holds"]
    assert "not-applicable" in said


# What nobody gave


def test_what_is_given_is_known() -> None:
    """A name is given by a file or a change, even with the published value; T_b follows T_s, a box follows its norm."""
    assert Parameters().defaults() == [name for name in NAMES if "norm" not in name and name not in OPTIONAL]
    one = Parameters.from_table("here", {"T_c": "0.1"}, ["v_max=2"])
    assert one == Parameters()
    assert not {"T_c", "v_max"} & set(one.defaults())
    assert not {"T_s", "T_b"} & set(one.with_changes(["T_s=0.4"]).defaults())
    assert "a_max" not in one.with_changes(["a_norm=3"]).defaults()
    assert "j_max" not in one.with_changes(["order=2"]).defaults()
    assert Parameters.from_exact(one.as_exact()).defaults() == []


QUICK = ("--reading", "whole-motion", "--set", "order=2")
OPTIONAL = ("crash_theta_inverse", "delay")


def test_what_nobody_gave_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file without a bound of the speed rests on the published one, which is said in words and in JSON."""
    path = tmp_path / "planner.toml"
    path.write_text("T_c = 0.05\na_max = 1\nd_hat_min = 0.3\norder = 2\n", encoding="utf-8")
    content, said = margin(capsys, 0, str(path), "--reading", "whole-motion", "--set", "v_max=0.5")
    assert "v_max" not in content["defaults"]
    assert content["defaults"]["d_min"] == 0.12
    # what the reading does not look at decides nothing
    assert not {"T_s", "T_b", "j_max"} & set(content["defaults"])
    assert "d_min = 0.12 m" in said
    content, said = margin(capsys, 0, str(path), "--reading", "whole-motion")
    assert content["defaults"]["v_max"] == [2.0, 2.0, 2.0]
    assert "not given v_max = 2 m/s, " in said
    assert "are published values, not yours: the verdict rests on them" in said


def test_nothing_given_is_told_shortly(capsys: pytest.CaptureFixture[str]) -> None:
    """With no parameter given, one clause says so."""
    content, said = margin(capsys, 1, "--reading", "whole-motion")
    assert set(content["defaults"]) == set(Parameters().defaults()) - {"T_s", "T_b"}
    assert "nothing was given: all parameters are published values" in said


# Files of other formats

OTHERS = {
    "JSON": '{"v_max": 2.0, "dt": 0.1}',
    "a kind of JSON": '{\n// speed\n"v_max": 2.0,\n}',
    "YAML": "drone_bbox: [0.8, 0.8, 0.5]\nv_max: 1.0  # m/s\nlimits:\n  - 1\n",
    "XML": '<?xml version="1.0"?>\n<launch><param name="v_max" value="2"/></launch>',
    "CSV": "uav,x,y,z\n0,0.1,0.2,1\n1,0.4,0.2,1\n",
}


@pytest.mark.parametrize("form", OTHERS)
@pytest.mark.parametrize(("command", "line"), [("margin", "T_c = 0.1"), ("fly", "rounds = 60")])
def test_other_formats_are_named(
    form: str, command: str, line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file in another format is answered with its name, and with a line that would be right."""
    path = tmp_path / "given.txt"
    path.write_text(OTHERS[form], encoding="utf-8")
    assert main([command, str(path)]) == 2
    said = capsys.readouterr().err
    assert f"given.txt is {form}, which is not read" in said
    assert f"TOML, in lines such as {line}" in said


@pytest.mark.parametrize(
    "text", ["T_c = ", "[parameters\nT_c = 0.1", "T_c = 0.1\nv_max 2\n", "T_c: 0.1, v = 2\nx = 3\ny = 2"]
)
def test_mistyped_toml_is_told_by_its_line(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """TOML with a mistake is not taken for another format: the line is named."""
    path = tmp_path / "given.toml"
    path.write_text(text, encoding="utf-8")
    assert main(["margin", str(path)]) == 2
    said = capsys.readouterr().err
    assert "is not TOML" in said
    assert "line " in said or "end of document" in said


@pytest.mark.parametrize("name", ["T_c", "d_hat_min"])
def test_nothing_is_certified_of_uavs_that_cannot_move(name: str) -> None:
    """The largest T_c of a swarm that stands still is no success."""
    still = Parameters().with_changes(["v_max=0"])
    for reading in Reading:
        if about_nothing(still, reading):
            found = solve_for(name, still, reading)
            assert (found.certified, found.refuted, found.margin) == (None, None, None)
            assert decide(Problem(still, reading)) == (Truth.UNDECIDED, None)
