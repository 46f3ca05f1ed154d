"""Flights of a planner with tolerance: distance stays above d̂_min − 2ε, feasibility needs twice the tolerance."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import combinations
from math import isqrt

import numpy as np
import pytest
from tests.dmpc_swarm.flight.flights import Recording, record, violated
from tests.dmpc_swarm.flight.settings import lattice, setting

from swarmproof.cli import main
from swarmproof.dmpc_swarm.flight.separation_at_samples import tracked
from swarmproof.dmpc_swarm.flight.state import FlightState
from swarmproof.dmpc_swarm.pages.flight import words as flight_words
from swarmproof.dmpc_swarm.planner.accept import broken_constraint, old_satisfies, right_side, wrong_sides
from swarmproof.errors import BadInput
from swarmproof.scenario.scenario import EXACT, Tolerance, load

UNITS = lattice()
D_HAT = Fraction(1, 4)
EPSILON = Fraction(1, 100)
SAME, DOUBLE = ("tolerance=0.01",), ("tolerance=0.02", "tolerance_halfway=0.01")


@cache
def flown(changes: tuple[str, ...], loss: str = "none", rounds: int = 40) -> Recording:
    """Return a flight of the circle with 3 CUs, flown once."""
    return record(setting("circle", 3, 0, changes), loss, rounds)


def nearest_square(state: FlightState, recording: Recording) -> Fraction:
    """Return the smallest squared distance (m²) at samples of two UAVs' trajectories, tracked or flown, exactly.

    Floats only choose which samples are computed in integers: all that may be the nearest.
    """
    names = sorted(tracked(state) | {(uav.i, uav.followed.metadata) for uav in state.swarm.uavs})
    squares = []
    for one, other in combinations(names, 2):
        if one[0] != other[0]:
            apart = state.plans[one].scaled_from(state.k) - state.plans[other].scaled_from(state.k)
            rough = (apart**2).sum(axis=1)
            near = apart[rough <= rough.min() * (1 + 1e-9)]
            squares.append(min(sum(int(x) ** 2 for x in row) for row in near))
    return min(squares) * recording.flight.lattice.pairs.unit**2


@pytest.mark.parametrize(("loss", "near"), [("none", Fraction(1, 1000)), ("iid:0.1", Fraction(15, 1000))])
@pytest.mark.parametrize("changes", [SAME, DOUBLE])
def test_distance_stays_above_the_bound_and_is_used_up(changes: tuple[str, ...], loss: str, near: Fraction) -> None:
    """In every round, all trajectories are d̂_min − 2ε apart at all samples, exactly; some come near to that."""
    recording = flown(changes, loss)
    squares = [nearest_square(round_.after, recording) for round_ in recording.rounds]
    kept = D_HAT - 2 * EPSILON
    assert kept**2 <= min(squares) < (kept + near) ** 2


def test_feasibility_is_lost_with_equal_tolerances_and_kept_with_double() -> None:
    """With ε for all rows, candidates are refused and problems remain without a plan; with 2ε and ε, none of them."""
    lost, kept = flown(SAME).flown.qps, flown(DOUBLE).flown.qps
    assert 0 < lost.rejected + lost.infeasible <= lost.unsatisfied
    assert lost.solved + lost.rejected + lost.infeasible == 120
    assert (kept.solved, kept.unsatisfied) == (120, 0)


def test_the_candidate_is_refused_by_full_rows_only() -> None:
    """Where the candidate is refused, it breaks a row with d̂_min alone, at a distance from d̂_min − 2ε to d̂_min − ε."""
    refused = 0
    for round_ in flown(SAME).rounds:
        for attempt in round_.computed.attempts:
            if attempt is None or attempt.planned.feasible:
                continue
            refused += 1
            task = attempt.task
            old = task.own.shifted(task.start)
            broken = wrong_sides(old, task.planes)
            assert len(broken)
            unit = task.own.lattice.pairs.unit
            for trajectory, h in broken:
                assert not task.planes.halfway[trajectory]
                square = sum(int(x) ** 2 for x in task.planes.normals[trajectory, h]) * unit**2
                assert (D_HAT - 2 * EPSILON) ** 2 <= square < (D_HAT - EPSILON) ** 2
    assert refused == flown(SAME).flown.qps.unsatisfied > 0


def test_plans_use_the_tolerance_and_no_more() -> None:
    """All accepted plans satisfy (13) with tolerance; many of them break (13f) without, and nothing else."""
    used = 0
    for round_ in flown(SAME).rounds:
        for attempt in round_.computed.attempts:
            if attempt is not None and attempt.planned.plan is not None:
                task, plan = attempt.task, attempt.planned.plan
                assert broken_constraint(plan, task.own, task.planes) is None
                without = broken_constraint(plan, task.own, replace(task, tolerance=EXACT).planes)
                assert without is None or "(13f)" in without
                used += without is not None
    assert used > 20


def satisfied(normal: tuple[int, ...], apart: tuple[int, ...], halfway: bool, tolerance: Fraction) -> bool | None:
    """Decide nᵀΔ/‖n‖ ≥ ½(d̂ + ‖n‖) − ε or d̂ − ε as it stands, with ‖n‖ to 40 digits; None if that is too close."""
    scale = 10**40
    length = Fraction(isqrt(sum(x * x for x in normal) * scale**2), scale)
    d_hat, epsilon = D_HAT / UNITS.pairs.unit, tolerance / UNITS.pairs.unit
    needed = (d_hat + length) / 2 - epsilon if halfway else d_hat - epsilon
    left = sum(a * b for a, b in zip(normal, apart, strict=True)) / length - needed
    return None if abs(left) < Fraction(1, 10**15) else left > 0


@pytest.mark.parametrize("halfway", [False, True])
def test_a_row_is_decided_exactly(halfway: bool) -> None:
    """A position a few lattice units before or behind a relaxed plane is told apart, whatever the plane's tolerance."""
    random = np.random.default_rng(3)
    right = 0
    for n in range(300):
        full, half = (Fraction(int(x), 10**6) for x in random.integers(0, 100_000, 2))
        tolerance = Tolerance(full, half)
        direction = random.normal(size=3)
        direction /= np.linalg.norm(direction)
        size = random.uniform(0.05, 0.6) / float(UNITS.pairs.unit)
        normal = tuple(int(x) for x in direction * size)
        needed = 0.25 - float(full) if not halfway else (0.25 + size * float(UNITS.pairs.unit)) / 2 - float(half)
        over = int(random.integers(-4, 5)) if n % 2 else 0
        apart = tuple(int(x) for x in direction * (needed / float(UNITS.pairs.unit) + over))
        expected = satisfied(normal, apart, halfway, half if halfway else full)
        assert expected is not None
        found = right_side([float(x) for x in normal], [float(x) for x in apart], halfway, UNITS, tolerance)
        assert found == expected
        right += found
    assert 50 < right < 250


def test_floats_never_overrule_integers() -> None:
    """On all tasks of a flight, planes and candidates are decided as by integers alone, row by row."""
    for changes in (SAME, DOUBLE):
        for round_ in flown(changes).rounds[10:30:4]:
            for attempt in round_.computed.attempts:
                if attempt is None:
                    continue
                task, planes = attempt.task, attempt.task.planes
                old = task.own.shifted(task.start)
                apart = planes.others - old.scaled_from(old.start)
                expected = [
                    [j, h]
                    for j, h in np.ndindex(apart.shape[:2])
                    if not right_side(
                        planes.normals[j, h], apart[j, h], bool(planes.halfway[j]), old.lattice, planes.tolerance
                    )
                ]
                assert wrong_sides(old, planes).tolist() == expected
                assert old_satisfies(task.own, task.start, planes) == (not expected)


def test_no_tolerance_is_the_default() -> None:
    """Without the fault, no task has a tolerance, and no row is relaxed."""
    assert load("circle").tolerance == EXACT == Tolerance()
    assert load("circle", 0, ["tolerance=0"]) == load("circle")
    for halfway in (True, False):
        assert EXACT.asked(D_HAT, halfway) == EXACT.kept(D_HAT) == D_HAT


def test_the_scenario_reads_both_tolerances() -> None:
    """One tolerance is for all rows; the other one is for halfway rows alone."""
    assert load("circle", 0, SAME).tolerance == Tolerance(EPSILON, EPSILON)
    assert load("circle", 0, DOUBLE).tolerance == Tolerance(2 * EPSILON, EPSILON)
    assert load("circle", 0, ["tolerance_halfway=0.01"]).tolerance == Tolerance(Fraction(0), EPSILON)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (["tolerance=-0.001"], "tolerance must not be negative, but it is -0.001"),
        (["tolerance_halfway=-1"], "tolerance_halfway must not be negative"),
        (["tolerance=0.125"], "leave nothing of d_hat_min=0.25"),
        (["tolerance=0.25", "tolerance_halfway=0"], "leave nothing of d_hat_min=0.25"),
        (["tolerance=much"], "tolerance"),
    ],
)
def test_tolerances_that_cannot_be_are_refused(changes: list[str], sentence: str) -> None:
    """A negative tolerance, one that leaves no distance, and no number are refused in one sentence."""
    with pytest.raises(BadInput, match=sentence) as caught:
        load("circle", 0, changes)
    assert "\n" not in str(caught.value)


def test_what_is_said_names_the_fault() -> None:
    """Headline, scope and JSON say that a tolerance was on and what it led to; without one, they say nothing of it."""
    result = flown(SAME).flown
    what = setting("circle", 3, 0, SAME)
    assert violated(result.claims) >= {"corollary-1", "tracked-separation"}
    assert "faulty planner (tolerance)" in flight_words.headline(what, result)
    scope = flight_words.scope(what, "none", result)
    assert "by 0.01 m" in scope
    assert "keep 0.23 m at samples" in scope
    assert f"did not satisfy {result.qps.unsatisfied} of 120 optimization problems" in scope
    content = json.loads(flight_words.document(what, "none", result, 1.0))
    assert content["tolerance"] == {
        "full": 0.01,
        "halfway": 0.01,
        "kept": 0.23,
        "candidate_unsatisfied": result.qps.unsatisfied,
    }
    chain = next(one.chain for one in result.claims if one.claim.id == "corollary-1")
    assert any("as (13f) demands, but for the tolerance" in line for line in chain)
    plain = setting("circle", 3)
    assert "tolerance" not in flight_words.headline(plain, result) + flight_words.scope(plain, "none", result)
    assert "tolerance" not in json.loads(flight_words.document(plain, "none", result, 1.0))


def test_the_command_flies_it(capsys: pytest.CaptureFixture[str]) -> None:
    """``fly crossing --set tolerance=0.01`` says that the planner is faulty, and exits with 1: claims are violated."""
    assert main(["fly", "crossing", "--rounds", "12", "--set", "tolerance=0.01"]) == 1
    told = " ".join(capsys.readouterr().out.split())
    assert "with a faulty planner (tolerance): violated: " in told
    assert "A fault was flown: plans may violate rows of (13f) by 0.01 m" in told
