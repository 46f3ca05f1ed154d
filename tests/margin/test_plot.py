"""The plots of margins: what they show is what was computed, the same file every time, and clear refusals."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from swarmproof.errors import BadInput
from swarmproof.margin.bounds import Margin, margin
from swarmproof.margin.problem import Problem
from swarmproof.margin.witness import Witness
from swarmproof.motion.integrator import AxisMotion
from swarmproof.pages.margin.plot import check_path, distance_curve, plot_margin, plot_sweep, scaled_paths
from swarmproof.pages.margin.sweep import sweep_curves, sweep_x
from swarmproof.pages.plot_style import decimal_text, interval_text, length_text, limit, verdict
from swarmproof.theorem3.inequality import Truth
from swarmproof.theorem3.parameters import Parameters, Reading

SUFFIXES = [".svg", ".png", ".pdf"]


@cache
def found() -> Margin:
    """Compute a margin once for all tests."""
    return margin(Problem(Parameters().with_changes(["T_c=0.05"]), Reading.AS_SAMPLED))


def made(*changes: str, reading: Reading = Reading.AS_SAMPLED, lower: str = "0", upper: str = "0.02") -> Margin:
    """Return a margin of these parameters that nobody computed."""
    problem = Problem(Parameters().with_changes(changes), reading)
    return Margin(problem, Fraction(lower), Fraction(upper), None, {})


def meeting() -> Margin:
    """Return a margin whose pair passes through each other along x, at 4 m/s."""
    length, none = Fraction(1, 5), Fraction(0)
    rest = AxisMotion((none, none, none), ((length, none),))
    uav_i, uav_j = (
        (AxisMotion((-sign * length, sign * Fraction(2), none), rest.inputs), rest, rest) for sign in (1, -1)
    )
    witness = Witness(0, none, length / 2, uav_i, uav_j, Fraction(1, 4))
    return replace(made("T_c=0.2", lower="0.25", upper="0.25"), witness=witness)


def test_the_curve_is_the_witness() -> None:
    """The curve covers the window, is d̂_min or more at both ends, and its minimum is d̂_min minus the dip, at τ."""
    one = found()
    assert one.witness is not None
    times, distances = distance_curve(one)
    assert (times[0], times[-1]) == (0.0, 0.05)
    assert np.all(np.diff(times) > 0)
    assert min(distances[0], distances[-1]) >= 0.25 - 1e-12
    assert distances.min() == pytest.approx(0.25 - float(one.witness.dip), abs=1e-6)
    assert times[distances.argmin()] == pytest.approx(float(one.witness.tau), abs=1e-4)
    assert float(one.lower) <= 0.25 - distances.min() + 1e-9 <= float(one.upper) + 2e-9


def test_without_a_witness_the_curve_is_flat() -> None:
    """If no pair dips below d̂_min, the curve is d̂_min."""
    assert set(distance_curve(made(lower="0"))[1]) == {0.25}


def test_paths_keep_the_distance() -> None:
    """In the plane of the drawing, the pair is as far apart as it is, up to what the motion leaves the plane."""
    uav_i, uav_j, off = scaled_paths(found())
    _, distances = distance_curve(found())
    drawn = np.linalg.norm(uav_i - uav_j, axis=1)
    assert np.all(drawn <= distances + 1e-9)
    assert np.all(drawn**2 >= distances**2 - off**2 - 1e-9)
    closest = distances.argmin()
    assert drawn[closest] == pytest.approx(distances[closest], abs=1e-9)
    assert uav_i[closest] == pytest.approx(-uav_j[closest])


def test_paths_through_each_other_span_a_plane() -> None:
    """A pair that meets has a relative motion along a line only, and is drawn along the first axis."""
    uav_i, uav_j, off = scaled_paths(meeting())
    assert off == pytest.approx(0.0, abs=1e-12)
    assert np.abs(np.concatenate([uav_i, uav_j])[:, 1]).max() == pytest.approx(0.0, abs=1e-12)
    assert uav_i[-1, 0] - uav_i[0, 0] == pytest.approx(0.4)


def test_paths_need_a_witness() -> None:
    """Without a witness there are no paths."""
    with pytest.raises(ValueError, match="witness"):
        scaled_paths(made(lower="0"))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_same_plot_is_the_same_file(suffix: str, tmp_path: Path) -> None:
    """Every format is written, with its own first bytes, and a second time the bytes are the same."""
    first, second = tmp_path / f"first{suffix}", tmp_path / "new" / f"second{suffix.upper()}"
    for path in (first, second):
        plot_margin(found(), path)
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes().startswith({".svg": b"<?xml", ".png": b"\x89PNG", ".pdf": b"%PDF"}[suffix])


def test_settings_of_matplotlib_change_nothing(tmp_path: Path) -> None:
    """The user's settings of matplotlib have no influence on the plot, and are as before after it."""
    import matplotlib

    first, second = tmp_path / "first.svg", tmp_path / "second.svg"
    plot_margin(found(), first)
    with matplotlib.rc_context({"font.size": 30, "svg.hashsalt": "other"}):
        plot_margin(found(), second)
        assert matplotlib.rcParams["font.size"] == 30
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize(
    "drawn",
    [
        pytest.param(lambda: made(lower="0", upper="0.25"), id="nothing known"),
        pytest.param(lambda: made(lower="0", upper="0"), id="no dip at all"),
        pytest.param(lambda: replace(found(), upper=Fraction(1, 10)), id="wide"),
        pytest.param(lambda: replace(found(), upper=Fraction(1, 4)), id="no upper bound"),
        pytest.param(meeting, id="pairs can meet"),
    ],
)
def test_extreme_margins_can_be_drawn(drawn: Callable[[], Margin], tmp_path: Path) -> None:
    """Without a witness, without a bound, wide, or vacuous: there is a plot."""
    plot_margin(drawn(), tmp_path / "margin.svg")
    assert (tmp_path / "margin.svg").stat().st_size > 10_000


def test_a_sweep_is_over_the_first_number() -> None:
    """The x axis is the first swept parameter that is one number and varies; bounds equal on all axes are one."""
    results = [made("theta_inverse=1", "v_max=1"), made("order=2", "v_max=1,1,2"), made("d_min=0.1", "T_c=0.05")]
    names = ["reading", "theta_inverse", "order", "v_max", "a_max", "T_c", "d_min"]
    assert sweep_x(results, names) == "T_c"
    assert sweep_x(results[::2], names) == "v_max"
    assert sweep_x(results, ["theta_inverse", "workspace", "reading"]) is None
    assert sweep_x(results, []) is None


def test_curves_are_ordered_by_x_and_told_apart_by_the_rest() -> None:
    """There is a curve per reading and combination of the other swept parameters, whatever the order of the sets."""
    results = [
        made(f"T_c={T_c}", f"v_max={v_max}", reading=reading)
        for T_c in ("0.05", "0.01", "0.1", "0.02")
        for v_max in ("2", "1,1,0.5")
        for reading in (Reading.INITIAL_STATE, Reading.AS_SAMPLED)
    ]
    curves = sweep_curves(results, ["T_c", "reading", "v_max"], "T_c")
    assert [(curve.reading, curve.settings) for curve in curves] == [
        ("initial-state", "v_max=2"),
        ("as-sampled", "v_max=2"),
        ("initial-state", "v_max=1,1,0.5"),
        ("as-sampled", "v_max=1,1,0.5"),
    ]
    for curve in curves:
        assert curve.xs == (0.01, 0.02, 0.05, 0.1)
        assert [float(result.problem.parameters.T_c) for result in curve.results] == list(curve.xs)
        assert {result.problem.reading.value for result in curve.results} == {curve.reading}


def over(x: str, values: Sequence[object], *others: str, upper: str = "0.1") -> list[Margin]:
    """Return margins for all of these values of `x`, each together with each of `others`."""
    return [
        made(f"{x}={value}", *([other] if other else []), upper=upper) for value in values for other in others or [""]
    ]


SWEEPS: dict[str, tuple[list[Margin], list[str]]] = {
    "one set": ([made()], []),
    "many curves": (over("T_c", (0.05, 0.1), *(f"v_max={v}" for v in range(1, 19))), ["T_c", "v_max"]),
    "many limits": (over("T_c", (0.05, 0.1), *(f"d_min=0.1{k}" for k in range(6))), ["T_c", "d_min"]),
    "the limit varies": (over("d_hat_min", (0.15, 0.3)), ["d_hat_min"]),
    "dips of 0": (over("T_c", (0.05, 0.1), upper="0"), ["T_c"]),
    "many points": (over("v_max", range(1, 60)), ["v_max"]),
    "no number": ([made(), made("theta_inverse=1", lower="0", upper="0.2")], ["theta_inverse"]),
    "mostly lone sets": ([*over("T_c", (0.05, 0.1)), made("v_max=1"), made("v_max=0.5")], ["T_c", "v_max"]),
}


@pytest.mark.parametrize("name", SWEEPS)
def test_every_sweep_can_be_drawn(name: str, tmp_path: Path) -> None:
    """One set or many, with a number swept or without, with limits that vary or are far away: there is a plot."""
    plot_sweep(*SWEEPS[name], tmp_path / "sweep.svg")
    assert (tmp_path / "sweep.svg").stat().st_size > 10_000


def test_the_same_sweep_is_the_same_file(tmp_path: Path) -> None:
    """A sweep drawn twice gives the same bytes."""
    for path in (tmp_path / "first.svg", tmp_path / "second.svg"):
        plot_sweep(*SWEEPS["the limit varies"], path)
    assert (tmp_path / "first.svg").read_bytes() == (tmp_path / "second.svg").read_bytes()


def test_the_limit_counts_both_tracking_errors_scaled() -> None:
    """The corrected (26) holds up to d̂_min − d_min − 2‖Θ⁻¹‖Δd_min."""
    assert limit(made("theta_inverse=2,1,1", "tracking_error=0.01")) == pytest.approx(0.25 - 0.12 - 2 * 2 * 0.01)


def test_plots_pay_the_delay_and_say_nothing_of_nothing() -> None:
    """A marker is filled by the same verdict as the table's, and limits are those of the dip alone."""
    late = replace(made("delay=0.02", "d_min=0.2", reading=Reading.WHOLE_MOTION), flown=(Fraction("0.05"),) * 2)
    assert verdict(late) is late.truths[1] is Truth.UNDECIDED
    assert limit(late) == 0
    assert verdict(made("d_min=0.2")) is Truth.HOLDS
    assert verdict(made("v_max=0", "d_min=0.2", reading=Reading.WHOLE_MOTION)) is Truth.UNDECIDED
    shrunk = made("crash_theta_inverse=1,1,0.1", "d_min=0.12")
    assert limit(shrunk) == pytest.approx(0.25 - 0.12 / 0.6)


def test_numbers_are_rounded_to_the_safe_side() -> None:
    """Intervals are written with digits that show their width, rounded outwards; lengths in a unit that suits them."""
    assert interval_text(replace(found(), lower=Fraction(1, 3), upper=Fraction(1, 3) + Fraction(1, 10**6))) == (
        "0.33333333 … 0.33333434 m"
    )
    assert interval_text(made(lower="0.02", upper="0.02")) == "0.0200000 … 0.0200000 m"
    assert (decimal_text(Fraction(2, 3), 2), decimal_text(Fraction(1, 3), 2, up=True)) == ("0.66", "0.34")
    assert [length_text(length) for length in (0.25, 0.02, 2.5e-7, 0)] == ["0.25 m", "20 mm", "0.25 µm", "0 µm"]


@pytest.mark.parametrize("name", ["plot", "plot.jpg", "svg", "-"])
def test_other_files_are_refused(name: str, tmp_path: Path) -> None:
    """A file of another kind is refused with the kinds that there are, and is not made."""
    with pytest.raises(BadInput, match=r"\.svg, \.png or \.pdf$"):
        check_path(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_files_that_cannot_be_written_are_refused(tmp_path: Path) -> None:
    """A folder in the file's place, or a file in the folder's, is refused before anything is computed or drawn."""
    (tmp_path / "folder.svg").mkdir()
    (tmp_path / "file").touch()
    for path in (tmp_path / "folder.svg", tmp_path / "file" / "plot.svg"):
        for refuse in (
            check_path,
            lambda path: plot_margin(found(), path),
            lambda path: plot_sweep([made()], [], path),
        ):
            with pytest.raises(BadInput, match="give a file that can be written"):
                refuse(path)


def test_checking_a_path_leaves_nothing_behind(tmp_path: Path) -> None:
    """The check makes the folder but no file, and does not touch a file that is there."""
    (tmp_path / "old.svg").write_text("kept", encoding="utf-8")
    for path in (tmp_path / "old.svg", tmp_path / "new" / "plot.svg"):
        check_path(path)
    assert (tmp_path / "old.svg").read_text(encoding="utf-8") == "kept"
    assert not list((tmp_path / "new").iterdir())


def test_without_matplotlib_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Where matplotlib is missing, the sentence says how to install it."""
    for module in ("matplotlib", "matplotlib.figure"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(BadInput, match=r"pip install 'swarmproof\[plots\]'"):
        check_path(tmp_path / "plot.svg")


def test_importing_the_module_does_not_import_matplotlib() -> None:
    """Commands that draw nothing neither need matplotlib nor wait for it."""
    code = "import sys, swarmproof.pages.margin.plot; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
