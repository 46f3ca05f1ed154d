"""Steps on the sample grid against brute force over H and all samples: proofs are true, counterexamples are real."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from swarmproof.algebra.grid import Range, Step, Time
from swarmproof.dmpc_swarm.proofs.registry import PROOF_CLAIMS
from swarmproof.prove.steps import TRIED, Covered, Line, decide_step

#: Horizons that brute force tries; all ends of ranges that are drawn have crossed each other by then.
MOST = 30


def spread(each: Range, horizon: int) -> set[int]:
    """Return the samples of a range, from its definition."""
    return {
        s for s in range(-20, 200) if each.first.a + each.first.b * horizon <= s <= each.last.a + each.last.b * horizon
    }


def follows(step: Step, horizon: int) -> bool:
    """Decide a step for one H: a sample is apart if it is given, or if it is at rest like one that is given."""
    apart = set[int]().union(*(spread(each, horizon) for each in step.given))
    resting = 10**9 if step.rest is None else step.rest.a + step.rest.b * horizon
    if any(sample >= resting for sample in apart):
        apart |= set(range(resting, 200))
    return spread(step.needed, horizon) <= apart


times = st.builds(Time, st.integers(-2, 6), st.integers(0, 2))
ranges = st.builds(Range, st.sampled_from("abc"), times, times)
steps = st.builds(
    Step,
    st.lists(ranges, max_size=3, unique_by=lambda each: each.name).map(tuple),
    st.builds(Range, st.just("needed"), times, times),
    st.none() | times,
    st.integers(1, 3),
)
#: For H = 1 the given range is empty: that its last sample would be at rest says nothing.
EMPTY_FOR_ONE = Step((Range("a", Time(3), Time(0, 1)),), Range("needed", Time(3), Time(3)), Time(1))
NOTHING_GIVEN = Step((), Range("needed", Time(5), Time(5)), Time(0))


@settings(max_examples=400, deadline=None)
@given(steps)
@example(EMPTY_FOR_ONE)
@example(NOTHING_GIVEN)
def test_decisions_agree_with_brute_force(step: Step) -> None:
    """A step that is proved is true for every H up to 30; one that is refuted is false for the H of its line."""
    decided = decide_step(step)
    if isinstance(decided, Covered):
        assert all(follows(step, horizon) for horizon in range(step.least_horizon, MOST + 1))
    elif isinstance(decided, Line):
        assert not follows(step, decided.horizon)
        # and there is none of a smaller H
        assert all(follows(step, horizon) for horizon in range(step.least_horizon, decided.horizon))
    else:
        # nothing is refuted that was not tried
        assert all(follows(step, horizon) for horizon in range(step.least_horizon, step.least_horizon + TRIED))


@settings(max_examples=600, deadline=None)
@given(steps, st.lists(st.sampled_from("abc"), max_size=3).map(tuple), st.booleans())
@example(EMPTY_FOR_ONE, ("a",), True)
@example(NOTHING_GIVEN, (), True)
def test_a_cover_without_fault_proves_its_step(step: Step, names: tuple[str, ...], at_rest: bool) -> None:
    """Whatever cover is offered: if it has no fault, the step is true for every H up to 30."""
    if Covered(names, at_rest).fault(step) is None:
        assert all(follows(step, horizon) for horizon in range(step.least_horizon, MOST + 1))


@settings(max_examples=600, deadline=None)
@given(steps, st.integers(1, 4), st.dictionaries(st.integers(-2, 14), st.integers(-1, 1), max_size=17))
def test_a_line_without_fault_refutes_its_step(step: Step, horizon: int, places: dict[int, int]) -> None:
    """Whatever places are offered: if they have no fault, the step is false for that H, and they show it."""
    if Line(horizon, places).fault(step) is not None:
        return
    assert horizon >= step.least_horizon
    assert not follows(step, horizon)
    given_samples = set[int]().union(*(spread(each, horizon) for each in step.given))
    assert all(abs(places[sample]) >= 1 for sample in given_samples)
    assert any(places[sample] == 0 for sample in spread(step.needed, horizon))
    if step.rest is not None:
        assert len({place for sample, place in places.items() if sample >= step.rest.at(horizon)}) <= 1


@pytest.mark.parametrize(
    ("name", "step"),
    [
        (f"{claim.key}: {name}", asked)
        for claim in PROOF_CLAIMS
        for name, asked in claim.questions.items()
        if isinstance(asked, Step)
    ],
)
def test_steps_on_file_agree_with_brute_force(name: str, step: Step) -> None:
    """Every step of the claims is decided, and as brute force decides it."""
    decided = decide_step(step)
    assert decided is not None, name
    horizons = range(step.least_horizon, MOST + 1)
    assert isinstance(decided, Covered) == all(follows(step, horizon) for horizon in horizons)


REST = Step((Range("a", Time(1), Time(0, 2)),), Range("needed", Time(2), Time(2, 2)), Time(0, 2))


@pytest.mark.parametrize(
    "changed",
    [
        replace(REST, rest=None),
        replace(REST, rest=Time(1, 2)),
        replace(REST, given=(Range("a", Time(3), Time(0, 2)),)),
        replace(REST, given=(Range("a", Time(1), Time(-1, 2)),)),
        replace(REST, needed=Range("needed", Time(0), Time(2, 2))),
    ],
)
def test_a_planted_error_in_a_step_is_refuted(changed: Step) -> None:
    """No rest, rest a sample later, and ranges that are a sample too short or too long: each has a counterexample."""
    assert decide_step(REST) == Covered(("a",), at_rest=True)
    assert isinstance(decide_step(changed), Line)
    assert Covered(("a",), at_rest=True).fault(changed) is not None


def test_covers_and_lines_say_what_is_wrong() -> None:
    """A fault names what is missing."""
    assert Covered(("b",), False).fault(REST) == "'b' is not given"
    assert Covered(("a",), False).fault(REST) == "samples after Time(a=1, b=2) may be left"
    assert Covered(("a",), True).fault(replace(REST, rest=None)) == "rest is not assumed"
    assert "may begin after" in (Covered(("a",), True).fault(replace(REST, needed=Range("n", Time(0), Time(1)))) or "")
    assert Covered((), True).fault(NOTHING_GIVEN) == "nothing is given at rest"
    assert Covered(("a",), True).fault(EMPTY_FOR_ONE) == "a may be empty"
    places = dict.fromkeys(range(0, 9), 1)
    assert Line(1, {}).fault(REST) == "no place at sample 1"
    assert Line(1, places).fault(REST) == "apart at all samples that are needed"
    assert Line(1, places | {4: 0}).fault(REST) == "UAV j moves after sample 2, when it is at rest"
    assert Line(1, places | {2: -1}).fault(REST) == "UAV j moves after sample 2, when it is at rest"
    assert Line(1, dict.fromkeys(range(0, 9), 0)).fault(REST) == "too close at sample 1, which a forbids"
    assert Line(1, places).fault(replace(REST, least_horizon=2)) == "H is at least 2"
