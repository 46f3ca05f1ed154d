"""Bounds of norms: planned within a polyhedron, accepted exactly, and without effect where they do not bind."""

from __future__ import annotations

import json
from fractions import Fraction
from math import isqrt

import numpy as np
import pytest
from tests.dmpc_swarm.flight.settings import a_task, hover, lattice, setting, wander

from swarmproof.dmpc_swarm.flight.run import fly
from swarmproof.dmpc_swarm.flight.state import Round
from swarmproof.dmpc_swarm.pages.flight import words as flight_words
from swarmproof.dmpc_swarm.planner import qp
from swarmproof.dmpc_swarm.planner.accept import broken_constraint, old_satisfies
from swarmproof.dmpc_swarm.planner.ball import PER_UNIT, directions, share, triangles
from swarmproof.dmpc_swarm.planner.plan import Plan, within_ball
from swarmproof.dmpc_swarm.planner.planner import Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import Floats
from swarmproof.scenario.scenario import Weights

F = Fraction
NORMS = ("v_norm=0.3", "v_max=2", "a_norm=0.4", "a_max=5", "j_norm=1", "j_max=5")


def square(values: Floats, unit: Fraction) -> Fraction:
    """Return the largest squared norm (SI) of rows of integers, exactly."""
    return max(sum(((int(x) * unit) ** 2 for x in row), F(0)) for row in values)


# The polyhedron


def test_every_point_of_the_polyhedron_is_in_the_ball() -> None:
    """Seen from 0, every direction is within the covering angle of one of the polyhedron's; far more than 98 %."""
    random = np.random.default_rng(1).normal(size=(20_000, 3))
    # the corners of the polyhedron are the worst
    corners = np.array([np.linalg.solve(np.array(three, float), np.ones(3)) for three in triangles()])
    points = np.concatenate([random, corners])
    points /= np.linalg.norm(points, axis=1)[:, None]
    reached = (points @ directions().T).max(axis=1)
    assert reached.min() >= share() - 1e-12
    # a share that is one in a thousand too large would let a corner out
    assert reached.min() < share() * 1.001
    assert share() > 0.98


def test_the_ball_of_the_share_is_in_the_polyhedron() -> None:
    """No direction is longer than 1, exactly; there are 162, and every triangle has three of them."""
    whole = {corner for corners in triangles() for corner in corners}
    assert len(whole) == len(directions()) == 162
    assert len(triangles()) == 320
    assert all(sum(x * x for x in corner) <= PER_UNIT**2 for corner in whole)


def test_triangles_close_around_the_origin() -> None:
    """Every edge belongs to two triangles, in opposite senses seen from outside: no direction is left out."""
    edges = set()
    for corners in triangles():
        a, b, c = corners if np.linalg.det(np.array(corners, float)) > 0 else corners[::-1]
        for edge in ((a, b), (b, c), (c, a)):
            assert edge not in edges
            edges.add(edge)
    assert all((b, a) in edges for a, b in edges)


# Acceptance


@pytest.mark.parametrize("n", [1, 2**26 + 1, 2**48 - 1])
def test_the_norm_is_decided_to_the_last_unit(n: int) -> None:
    """A norm of exactly the bound is accepted, one more in the square is not: floats alone could not tell."""
    values = np.array([[0.0, 0.0, 0.0], [2.0 * n, -3.0 * n, 6.0 * n]])
    assert within_ball(values, 49 * n * n)
    assert not within_ball(values, 49 * n * n - 1)


@pytest.mark.parametrize(
    ("norm", "word"), [("v_norm", "a velocity"), ("a_norm", "an acceleration"), ("j_norm", "a jerk")]
)
def test_plans_are_accepted_exactly_up_to_the_bound(norm: str, word: str) -> None:
    """A bound that is the plan's largest norm, rounded up, lets it through; rounded down, it does not."""
    free = lattice(horizon=8)
    plan = wander(np.random.default_rng(2), hover(free, (0, 0, 1)), 0, 0.4)
    values, unit = {
        "v_norm": (plan.velocities, free.velocity_unit),
        "a_norm": (plan.accelerations, free.acceleration_unit),
        "j_norm": (plan.jerks, free.jerk_unit),
    }[norm]
    root = isqrt(int(square(values, unit) * 10**20))
    box = f"{norm[0]}_max=9"
    enough, little = (lattice(f"{norm}={F(n, 10**10)}", box, horizon=8) for n in (root + 1, root))
    assert Plan(enough, plan.start, plan.state, plan.jerks).fault is None
    fault = Plan(little, plan.start, plan.state, plan.jerks).fault
    assert fault is not None
    assert f"the norm of {word} is out of bounds" in fault


# Planning


def rounds_of(changes: tuple[str, ...], rounds: int = 30) -> list[Round]:
    """Return a flight of `crossing` with changes, in which no claim is violated."""
    seen: list[Round] = []
    what = setting("crossing", changes=changes)
    flown, _ = fly(what, parse("none", 2, 2, 0), rounds, seen.append)
    assert not flown.violated
    assert flown.qps.solved >= rounds
    assert not flown.qps.rejected + flown.qps.infeasible
    return seen


def test_flights_keep_norms_and_come_close_to_them() -> None:
    """The plans of a flight keep all three norms exactly, and use more than 97 % of the bounds: these do bind."""
    plans = [plan for flown in rounds_of(NORMS) for plan in flown.before.plans.values()]
    units = plans[0].lattice
    largest = {
        "v": max(square(plan.velocities, units.velocity_unit) for plan in plans) / F("0.3") ** 2,
        "a": max(square(plan.accelerations, units.acceleration_unit) for plan in plans) / F("0.4") ** 2,
        "j": max(square(plan.jerks, units.jerk_unit) for plan in plans),
    }
    assert all(F("0.97") ** 2 < part <= 1 for part in largest.values()), {k: float(v) for k, v in largest.items()}


def test_norms_that_never_bind_change_nothing() -> None:
    """A bound that no plan comes near, though the box alone would allow more, leaves every number as it was."""
    free = rounds_of((), 20)
    bounded = rounds_of(("v_norm=2.5", "v_max=2", "a_norm=8", "a_max=5", "j_norm=8.6", "j_max=5"), 20)
    assert bounded[0].before.plans[next(iter(bounded[0].before.plans))].lattice.norms.keys() == {
        "v_norm",
        "a_norm",
        "j_norm",
    }
    for one, other in zip(free, bounded, strict=True):
        assert {n: p.digest for n, p in one.after.plans.items()} == {n: p.digest for n, p in other.after.plans.items()}


def at_the_bound() -> Task:
    """Return a task at whose start the UAV is as fast as it may be, in a direction in which the polyhedron is thin.

    Before and after, it speeds up and brakes as gently as it can, so that it cannot be slow enough a period later.
    """
    direction = max(directions(), key=min)
    jerk = [F(round(part), 2**16) for part in direction * 2**10]
    # m/s: ten periods of 0.2 s under that jerk, then ten under the opposite one
    fastest = sum((4 * part) ** 2 for part in jerk)
    root = isqrt(int(fastest * 10**20)) + 1
    units = lattice(f"v_norm={F(root, 10**10)}", "v_max=2", f"j_max={','.join(map(str, jerk))}", horizon=40)
    ramp = np.repeat([1.0, -1.0, 1.0], [10, 20, 10])
    start = hover(units, (-1, -1, 1))
    own = Plan(units, 0, start.state, ramp[:, None] * np.array([int(part / units.jerk_unit) for part in jerk]))
    assert square(own.velocities, units.velocity_unit) == fastest
    return a_task(own, {}, (1.0, 0.0, 1.0), k=19)


def test_theorem_1_needs_no_room_in_the_polyhedron() -> None:
    """A plan comes out where the old trajectory itself is outside the polyhedron: rows ask no more than it has."""
    task = at_the_bound()
    planner = Planner(task.own.lattice, Weights())
    program = qp.LazyProgram(planner.models[0], task)
    assert program.room.min() < -5e-4, "the old trajectory must be outside the polyhedron"
    assert old_satisfies(task.own, task.start, task.planes)
    planned = planner.plan(task)
    assert planned.plan is not None
    assert planned.feasible
    assert broken_constraint(planned.plan, task.own, task.planes) is None


def test_theorem_1_would_fail_if_rows_asked_for_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """The planted fault: with demands of 0 where the old trajectory has less, no plan comes out of the same task."""
    task = at_the_bound()
    monkeypatch.setattr(qp.LazyProgram, "kept", property(lambda self: np.clip(self.room, 0.0, self.spare)))
    planned = Planner(task.own.lattice, Weights()).plan(task)
    assert planned.feasible
    assert planned.plan is None


# Words


def test_words_and_json_say_how_norms_are_kept() -> None:
    """Scope and JSON have the bounds that restrict the flight, and the share; without them, not a word."""
    what = setting("crossing", changes=("v_norm=0.5", "v_max=2", "a_norm=100", "a_max=5"))
    flown, seconds = fly(what, parse("none", 2, 2, 0), 2)
    said = flight_words.scope(what, "none", flown)
    assert "Bounds of norms (v_norm=0.5 m/s) are accepted exactly" in said
    assert "at least 98.3 % of them in every direction" in said
    assert json.loads(flight_words.document(what, "none", flown, seconds))["norms"] == {
        "v_norm": 0.5,
        "planned_share": 0.983,
    }
    plain = setting("crossing")
    assert "norm" not in flight_words.scope(plain, "none", flown)
    assert "norms" not in json.loads(flight_words.document(plain, "none", flown, seconds))
