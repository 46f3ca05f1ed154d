"""`swarmproof margin --solve-for`: the certified value holds, the refuted one fails, and they are close together."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from swarmproof.cli import main
from swarmproof.commands import margin as command
from swarmproof.errors import BadInput
from swarmproof.margin import solve as module
from swarmproof.margin.bounds import Margin, from_certificate, margin
from swarmproof.margin.check import check
from swarmproof.margin.problem import Problem
from swarmproof.margin.solve import MOST_TRIALS, PRECISION, Extreme, changed, decide, solve_for
from swarmproof.pages.margin import words as margin_words
from swarmproof.theorem3.inequality import Truth, corrected
from swarmproof.theorem3.parameters import EXTREMES, Parameters, Reading

Decision = tuple[Truth, Margin | None]

#: What is asked for in the published setting, and the same for double integrators with one window per period.
ASKED = ["margin", "--d-min", "0.12", "--tracking-error", "0.02"]
GIVEN = Parameters().with_changes(["d_min=0.12", "tracking_error=0.02"])
QUICK = GIVEN.with_changes(["order=2", "T_s=0.1"])


@cache
def solved(name: str, given: Parameters = GIVEN, reading: Reading = Reading.AS_SAMPLED) -> Extreme:
    """Solve once for all tests."""
    return solve_for(name, given, reading)


@cache
def truth_at(given: Parameters, name: str, value: Fraction, reading: Reading = Reading.AS_SAMPLED) -> Truth:
    """Return what the margin, computed anew as closely as it can be, makes of the corrected inequality."""
    found = margin(Problem(changed(given, name, value), reading))
    return corrected(found.problem.parameters, found.lower, found.upper)


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the command solve, and compute the margin, once for all tests; nobody is told how it goes."""
    once = cache(margin)
    monkeypatch.setattr(command, "margin", lambda problem, say: once(problem))
    monkeypatch.setattr(command, "solve_for", lambda name, given, reading, say: solved(name, given, reading))


def verify(name: str, given: Parameters, reading: Reading = Reading.AS_SAMPLED) -> Extreme:
    """Check all that must be true of an extreme that was found, and return it."""
    found = solved(name, given, reading)
    assert found.name == name
    assert found.certified is not None
    assert found.refuted is not None
    assert found.margin is not None
    assert found.undecided == ()
    assert (found.certified < found.refuted) == (name != "d_hat_min")
    # the certificate is of the certified value, and enough for the inequality
    problem = Problem(changed(given, name, found.certified), reading)
    assert found.margin.problem == problem
    verified = check(found.margin.certificate)
    assert (verified.lower, verified.upper) == (found.margin.lower, found.margin.upper)
    assert corrected(problem.parameters, verified.lower, verified.upper) is Truth.HOLDS
    # recomputed by itself
    assert truth_at(given, name, found.certified, reading) is Truth.HOLDS
    assert truth_at(given, name, found.refuted, reading) is Truth.FAILS
    return found


@pytest.mark.parametrize("name", ["v_max", "d_hat_min"])
@pytest.mark.parametrize("given", [QUICK, pytest.param(GIVEN, marks=pytest.mark.deep)], ids=["quick", "published"])
def test_the_extreme_is_bracketed(name: str, given: Parameters) -> None:
    """What is certified holds, what is refuted fails, and they are as close as the stated precision."""
    found = verify(name, given)
    assert found.certified is not None
    assert found.refuted is not None
    assert abs(found.certified - found.refuted) <= PRECISION * max(found.certified, found.refuted)


def test_t_c_divides_the_period() -> None:
    """For `as-sampled`, T_c is T_s/m: the first m for which it holds, and the one before, for which it fails."""
    found = verify("T_c", GIVEN)
    assert (found.certified, found.refuted) == (GIVEN.T_s / 4, GIVEN.T_s / 3)


@pytest.mark.parametrize("reading", [Reading.INITIAL_STATE, pytest.param(Reading.WHOLE_MOTION, marks=pytest.mark.deep)])
def test_t_c_of_the_other_readings_is_any_number(reading: Reading) -> None:
    """For the readings without periods, T_c is bisected, too."""
    found = verify("T_c", GIVEN, reading)
    assert found.certified is not None
    assert found.refuted is not None
    assert found.refuted - found.certified <= PRECISION * found.refuted
    assert (GIVEN.T_s / found.certified).denominator > 1


@pytest.mark.parametrize("name", ["d_hat_min", pytest.param("v_max", marks=pytest.mark.deep)])
def test_asking_for_more_gives_less(name: str) -> None:
    """With a larger tracking error, the largest v_max is smaller, and the smallest d̂_min larger."""
    more, less = solved(name, replace(QUICK, tracking_error=Fraction(4, 100))), solved(name, QUICK)
    assert more.refuted is not None
    assert less.certified is not None
    assert (more.refuted < less.certified) == (name == "v_max")


@pytest.mark.deep
def test_where_the_search_starts_makes_no_difference() -> None:
    """The answer is the same, up to the precision, from a value for which it holds and from one for which it fails."""
    for name, values in (("v_max", (Fraction(1, 10), Fraction(7))), ("d_hat_min", (Fraction(1, 8), Fraction(3)))):
        found = solved(name, QUICK)
        for value in values:
            other = solved(name, changed(QUICK, name, value))
            assert found.certified is not None
            assert other.certified == pytest.approx(found.certified, rel=2 * float(PRECISION))
            assert other.refuted == pytest.approx(found.refuted, rel=2 * float(PRECISION))


@pytest.mark.parametrize("reading", Reading)
@pytest.mark.parametrize("name", ["T_c", "v_max"])
def test_nothing_is_certified_if_nothing_can_be(name: str, reading: Reading) -> None:
    """If d_min is more than d̂_min, or tracking takes all of the room, all that is tried is refuted, in no time."""
    for change in (["d_min=0.26"], ["d_min=0.12", "tracking_error=0.0651"]):
        found = solved(name, Parameters().with_changes(change), reading)
        assert (found.certified, found.margin, found.undecided) == (None, None, ())
        assert found.refuted is not None
        assert found.refuted < Fraction(1, 100)


def test_a_larger_distance_makes_up_for_d_min() -> None:
    """If d_min is more than d̂_min, a larger d̂_min is found all the same."""
    found = verify("d_hat_min", replace(QUICK, d_min=Fraction(1, 2)))
    assert found.certified is not None
    assert found.certified > Fraction(54, 100)


def test_no_room_at_all_is_refuted_quickly() -> None:
    """If d_min is d̂_min, every dip is too much: two UAVs that pass each other refute every T_c without any search."""
    found = solve_for("T_c", Parameters().with_changes(["d_min=0.25"]), Reading.AS_SAMPLED)
    assert found.certified is None
    assert found.refuted == Fraction(1, 1000)


@pytest.mark.parametrize("reading", [Reading.INITIAL_STATE, Reading.AS_SAMPLED])
def test_passing_each_other_refutes_no_more_than_the_margin(reading: Reading) -> None:
    """The dip that refutes without any search is one of every reading: the margin is at least as large."""
    given = Parameters().with_changes(["T_c=0.02", "T_s=0.02", "v_max=2,1,2"])
    way = [2 * float(v * given.T_c) for v in (given.v_max[0], given.v_max[1])]
    expected = 0.25 - (0.0625 - (way[0] ** 2 + way[1] ** 2) / 4) ** 0.5
    dip = module._crossing_dip(given)
    assert float(dip) == pytest.approx(expected, abs=1e-9)
    assert dip <= margin(Problem(given, reading)).upper


def test_a_decision_has_a_certificate_or_none() -> None:
    """A decision that it holds comes with what certifies it, others with nothing."""
    truth, found = decide(Problem(replace(QUICK, T_c=Fraction(1, 20)), Reading.AS_SAMPLED))
    assert truth is Truth.HOLDS
    assert found is not None
    assert from_certificate(found.certificate) == found
    assert decide(Problem(QUICK, Reading.AS_SAMPLED)) == (Truth.FAILS, None)


@pytest.mark.parametrize("name", EXTREMES)
def test_what_a_reading_does_not_take_is_bad_input(name: str) -> None:
    """A T_b that does not divide T_s is bad input before anything is tried, and so is an unknown name."""
    with pytest.raises(BadInput, match="reading as-sampled needs T_s to be a whole multiple of T_b"):
        solve_for(name, Parameters().with_changes(["T_b=0.15"]), Reading.AS_SAMPLED)
    with pytest.raises(BadInput, match="--solve-for takes one of T_c, v_max, v_norm, d_hat_min, not 'j_max'"):
        solve_for("j_max", GIVEN, Reading.AS_SAMPLED)


def pretend(monkeypatch: pytest.MonkeyPatch, name: str, truth: Callable[[Fraction], Truth]) -> list[Fraction]:
    """Make decisions follow `truth`, and return a list that receives the values tried."""
    tried: list[Fraction] = []
    stand_in = Margin(Problem(GIVEN, Reading.AS_SAMPLED), Fraction(0), Fraction(0), None, {})

    def pretended(problem: Problem, say: object) -> Decision:
        value = getattr(problem.parameters, name)
        tried.append(value[0] if isinstance(value, tuple) else value)
        verdict = truth(tried[-1])
        return verdict, stand_in if verdict is Truth.HOLDS else None

    monkeypatch.setattr(module, "decide", pretended)
    return tried


def between(certified: str, refuted: str) -> Callable[[Fraction], Truth]:
    """Return a truth that is undecided between two values, holds on one's side and fails on the other's."""
    holds, fails = Fraction(certified), Fraction(refuted)
    sign = 1 if holds < fails else -1

    def truth(value: Fraction) -> Truth:
        if sign * value <= sign * holds:
            return Truth.HOLDS
        return Truth.FAILS if sign * value >= sign * fails else Truth.UNDECIDED

    return truth


@pytest.mark.parametrize(
    ("name", "certified", "refuted"),
    [
        ("v_max", "1.5", "2.5"),  # undecided where the search starts
        ("v_max", "0.31", "0.32"),
        ("v_max", "30", "70"),
        ("d_hat_min", "0.3", "0.2"),
        ("d_hat_min", "7", "3"),
    ],
)
def test_what_is_undecided_is_narrowed_from_both_sides(
    name: str, certified: str, refuted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If some values are undecided, the ends of where they are are found, and no value is tried twice."""
    tried = pretend(monkeypatch, name, between(certified, refuted))
    found = solve_for(name, GIVEN, Reading.AS_SAMPLED)
    assert found.certified == pytest.approx(Fraction(certified), rel=float(PRECISION))
    assert found.refuted == pytest.approx(Fraction(refuted), rel=float(PRECISION))
    assert len(set(tried)) == len(tried) <= MOST_TRIALS
    assert found.undecided
    assert found.certified is not None
    assert found.refuted is not None
    low, high = sorted([found.certified, found.refuted])
    assert all(low < value < high for value in found.undecided)


def test_v_max_is_set_on_all_axes(monkeypatch: pytest.MonkeyPatch) -> None:
    """One number is solved for, whatever v_max was given per axis; the search starts at the largest."""
    axes = (Fraction(1), Fraction(3), Fraction(1, 2))
    tried = pretend(monkeypatch, "v_max", between("1.4", "1.40001"))
    found = solve_for("v_max", replace(GIVEN, v_max=axes), Reading.AS_SAMPLED)
    assert tried[:2] == [3, Fraction(3, 2)]
    assert found.certified == pytest.approx(1.4, rel=float(PRECISION))
    assert changed(replace(GIVEN, v_max=axes), "v_max", Fraction(7, 5)).v_max == (Fraction(7, 5),) * 3


@pytest.mark.parametrize("truth", Truth)
@pytest.mark.parametrize("name", EXTREMES)
def test_one_answer_everywhere_ends(name: str, truth: Truth, monkeypatch: pytest.MonkeyPatch) -> None:
    """If all values give the same answer, the search ends, and the other answers are none."""
    tried = pretend(monkeypatch, name, lambda value: truth)
    found = solve_for(name, GIVEN, Reading.INITIAL_STATE)
    assert (found.certified is not None) == (truth is Truth.HOLDS)
    assert (found.refuted is not None) == (truth is Truth.FAILS)
    assert bool(found.undecided) == (truth is Truth.UNDECIDED)
    assert len(set(tried)) == len(tried) <= MOST_TRIALS


def test_divisions_that_are_undecided_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """For `as-sampled`, undecided T_s/m between what is refuted and what is certified are told."""
    pretend(monkeypatch, "T_c", between("0.03", "0.06"))
    found = solve_for("T_c", GIVEN, Reading.AS_SAMPLED)
    period = GIVEN.T_s
    assert (found.refuted, found.undecided, found.certified) == (
        period / 3,
        (period / 4, period / 5, period / 6),
        period / 7,
    )


def test_the_command_says_and_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The document has both values beside the given parameters' margin, and the certificate is the extreme's."""
    path = tmp_path / "certificate.json"
    assert main([*ASKED, "--solve-for", "T_c", "--json", "-", "--certificate", str(path)]) == 0
    captured = capsys.readouterr()
    document: dict[str, Any] = json.loads(captured.out)
    assert document["solve_for"] == {"name": "T_c", "certified": 0.05, "refuted": pytest.approx(1 / 15)}
    assert list(document["solve_for"]) == ["name", "certified", "refuted"]
    assert document["parameters"] == GIVEN.as_json()
    assert document["dip"] == {"lower": 0.25, "upper": 0.25}
    assert document["theorem_3"]["corrected"] == "fails"
    said = " ".join(captured.err.split())
    assert "largest T_c with the corrected (26) certified: 0.05 s; refuted by a witness at 1/15 (≈ 0.0666667) s" in said
    content = json.loads(path.read_text(encoding="ascii"))
    assert content["parameters"] == replace(GIVEN, T_c=Fraction(1, 20)).as_exact()
    assert main(["margin", "--check", str(path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert said.startswith("accepted")
    assert "(26) corrected holds" in said


@pytest.mark.parametrize("name", ["T_c", "v_max"])
def test_nothing_certified_is_exit_code_1(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """If all values are refuted, the exit code is 1, and nobody is told of a value."""
    assert main(["margin", "--d-min", "0.3", "--solve-for", name, "--json", "-"]) == 1
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert document["solve_for"] == {"name": name, "certified": None, "refuted": pytest.approx(0, abs=0.01)}
    said = " ".join(captured.err.split())
    assert f"no {name} was found for which the corrected (26) is certified; it is refuted down to" in said


@pytest.mark.parametrize(
    ("certified", "refuted", "undecided", "code"),
    [("1", "2", (), 0), ("1", None, ("2",), 0), (None, "1", (), 1), (None, "2", ("1",), 3), (None, None, ("1",), 3)],
)
def test_exit_codes_of_a_solution(
    certified: str | None,
    refuted: str | None,
    undecided: tuple[str, ...],
    code: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """0 if some value is certified, 1 if all are refuted, otherwise 3; undecided values are told."""

    def number(text: str | None) -> Fraction | None:
        return None if text is None else Fraction(text)

    extreme = Extreme("v_max", number(certified), number(refuted), None, tuple(map(Fraction, undecided)))
    monkeypatch.setattr(command, "solve_for", lambda *_: extreme)
    assert main(["margin", "--solve-for", "v_max"]) == code
    said = " ".join(capsys.readouterr().out.split())
    assert ("no value tried was refuted" in said) == (refuted is None)
    assert ("undecided at" in said) == bool(undecided)


@pytest.mark.parametrize(
    ("name", "start"), [("T_c", "largest T_c"), ("v_max", "largest v_max"), ("d_hat_min", "smallest d_hat_min")]
)
def test_extremes_have_a_direction(name: str, start: str) -> None:
    """T_c and v_max are as large, d̂_min is as small as can be; values are told as `--set` takes them."""
    told = margin_words.solution(Extreme(name, Fraction(1, 15), Fraction(1, 20), None))
    assert told.startswith(f"{start} with the corrected (26) certified: 1/15 (≈ 0.0666667) ")
    assert "refuted by a witness at 0.05 " in told
    assert changed(GIVEN, name, Fraction(1, 15)) == GIVEN.with_changes([f"{name}=1/15"])
