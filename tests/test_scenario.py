"""Scenarios: those that ship are as documented, and random ones are repeatable."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import swarmproof.scenario.scenario as documented
from swarmproof.scenario.formations import FORMATIONS, antipodes, circle, cube, line, plane, pyramid, sphere
from swarmproof.scenario.points import PER_METRE, ROOM, closest_pair, draw
from swarmproof.scenario.scenario import SHIPPED, Point, Scenario, TargetChange, Weights, load
from swarmproof.semantics.switches import BadInput
from swarmproof.theorem3.parameters import PUBLISHED_SCALING, Box, Parameters, diagonal

SETTINGS = settings(max_examples=60, deadline=None, derandomize=True, database=None)

COORDINATES = st.floats(-5, 5)

SPACE: Box = (
    (Fraction(-17, 10), Fraction(17, 10)),
    (Fraction(-17, 10), Fraction(17, 10)),
    (Fraction(2, 5), Fraction(3)),
)


def _scaled(a: Point, b: Point) -> float:
    """Return the scaled distance, computed as one would by hand."""
    return math.hypot(b[0] - a[0], b[1] - a[1], (b[2] - a[2]) / 6)


def _smallest(points: tuple[Point, ...]) -> float:
    return min(_scaled(a, b) for a, b in combinations(points, 2))


def _all_points(scenario: Scenario) -> list[tuple[Point, ...]]:
    return [scenario.starts, *(change.points for change in scenario.targets)]


def _room(points: tuple[Point, ...]) -> float:
    """Return the smallest distance from a wall of the shipped flying space."""
    return min(
        min(value - float(low), float(high) - value)
        for point in points
        for value, (low, high) in zip(point, SPACE, strict=True)
    )


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenarios_have_published_parameters(name: str) -> None:
    """What ships has the published parameters, weights (but for the band's) and horizon, and the documented space."""
    scenario = load(name)
    assert scenario.name == name
    assert scenario.parameters == Parameters(workspace=SPACE)
    assert scenario.weights == Weights(1.0, 1e-4, 5e-3, 1e-3, 5.0, 0.3)
    assert scenario.horizon == 15


@pytest.mark.parametrize(
    ("name", "uavs", "rounds", "distance"),
    [("circle", 16, 300, 0.565), ("formations", 16, 440, 0.45), ("crossing", 2, 60, 1.2), ("random", 8, 300, 0.5)],
)
def test_shipped_scenarios_keep_their_distances(name: str, uavs: int, rounds: int, distance: float) -> None:
    """Starts and targets have the documented number, scaled distances and 0.1 m of room."""
    scenario = load(name)
    assert (scenario.uavs, scenario.rounds) == (uavs, rounds)
    for points in _all_points(scenario):
        assert len(points) == uavs
        assert _smallest(points) >= distance
        assert _room(points) >= 0.1


def test_columns_and_walls_are_noticed() -> None:
    """What the test above measures is small for UAVs above each other, and near a wall."""
    assert _smallest(((0.0, 0.0, 0.5), (0.0, 0.0, 2.9))) < 0.45
    assert _room(((0.0, 1.65, 1.0),)) < 0.1


def test_circle_is_a_circle_and_targets_are_antipodes() -> None:
    """UAV i of `circle` starts at i/16 of the circle and wants to where UAV i + 8 starts."""
    scenario = load("circle")
    for i, (x, y, z) in enumerate(scenario.starts):
        assert (x, y, z) == pytest.approx((1.45 * math.cos(math.pi * i / 8), 1.45 * math.sin(math.pi * i / 8), 0.8))
        assert scenario.targets_at(0)[i] == pytest.approx((-x, -y, z), abs=0)
        assert scenario.targets_at(0)[i] == pytest.approx(scenario.starts[(i + 8) % 16], abs=2e-9)
    assert scenario.targets_at(299) == scenario.targets_at(0)
    assert [scenario.target_change_before(k) for k in (0, 1, 299)] == [0, 0, 0]


def test_formations_change_every_110_rounds() -> None:
    """`formations` begins as a plane; its targets are a pyramid, a cube, a sphere and the plane, in this order."""
    scenario = load("formations")
    assert scenario.starts == plane(16, (0.0, 0.0), spacing=0.8, height=1.2)
    assert [change.round for change in scenario.targets] == [0, 110, 220, 330]
    assert scenario.targets_at(109) == pyramid(16, (0.0, 0.0), side=3.1, height=0.6, rise=2.2)
    assert scenario.targets_at(110) == scenario.targets_at(219) == cube(16, (0.0, 0.0), side=2.2, height=0.6)
    assert scenario.targets_at(220) == sphere(16, (0.0, 0.0), radius=1.2, height=0.5, turn=127.5)
    assert scenario.targets_at(330) == scenario.targets_at(5000) == scenario.starts
    rounds = (0, 109, 110, 111, 329, 330, 5000)
    assert [scenario.target_change_before(k) for k in rounds] == [0, 0, 110, 110, 220, 330, 330]


def test_crossing_swaps_places() -> None:
    """The two UAVs of `crossing` want to where the other starts, almost along one line."""
    scenario = load("crossing")
    assert scenario.targets_at(0) == scenario.starts[::-1]
    (x0, y0, z0), (x1, y1, z1) = scenario.starts
    assert x0 < 0 < x1
    assert z0 == z1
    assert 0 < abs(y1 - y0) < scenario.parameters.d_hat_min


def test_random_is_repeatable() -> None:
    """The same seed gives the same starts and targets, in whatever order they are asked for; another seed, others."""
    forwards, backwards = load("random", seed=7), load("random", seed=7)
    rounds = [0, 1, 74, 75, 149, 150, 9_999, 99_999]
    later = {k: backwards.targets_at(k) for k in reversed(rounds)}
    assert [forwards.targets_at(k) for k in rounds] == [later[k] for k in rounds]
    assert forwards == backwards
    assert forwards.starts != load("random", seed=8).starts
    assert forwards.targets_at(75) != load("random", seed=8).targets_at(75)


def test_random_is_pinned() -> None:
    """The points of seed 0 are these: a flight recorded with a seed can be flown again on another machine."""
    scenario = load("random")
    drawn = [scenario.starts[0], scenario.targets_at(75)[0]]
    assert [[value * PER_METRE for value in point] for point in drawn] == [
        [120997, -811600, 800454],
        [-520576, 78729, 2082624],
    ]


def test_random_targets_change_for_ever() -> None:
    """Every 75 rounds there are new targets, as far apart and as far from the walls as the first ones."""
    scenario = load("random")
    assert [scenario.target_change_before(k) for k in (0, 74, 75, 76, 150, 99_999)] == [0, 0, 75, 75, 150, 99_975]
    sets = [scenario.targets_at(k) for k in range(0, 7500, 75)]
    assert all(scenario.targets_at(k + 74) == points for k, points in zip(range(0, 7500, 75), sets, strict=True))
    assert len({scenario.starts, *sets}) == 101
    for points in sets:
        assert len(points) == 8
        assert _smallest(points) >= 0.5
        assert _room(points) >= 0.1


def test_random_targets_count_from_their_own_round() -> None:
    """Where random targets begin later, `every` counts from their round on."""
    first = load("random")
    fixed = TargetChange(0, first.starts)
    scenario = replace(first, targets=(fixed, TargetChange(10, first.targets[0].points)))
    assert [scenario.target_change_before(k) for k in (9, 10, 84, 85, 159, 160)] == [0, 10, 10, 85, 85, 160]
    assert scenario.targets_at(9) == first.starts
    assert scenario.targets_at(84) == first.targets_at(0)
    assert scenario.targets_at(85) == scenario.targets_at(159) != scenario.targets_at(160)


@SETTINGS
@given(st.integers(0, 10**6), st.integers(2, 16), st.sampled_from([Fraction(1, 4), Fraction(1, 2)]))
def test_draws_are_exactly_apart(seed: int, uavs: int, separation: Fraction) -> None:
    """Random points are exactly `separation` or more apart, whatever the scaling, and keep away from the walls."""
    third = diagonal((Fraction(1), Fraction(2, 3), Fraction(1, 7)))
    coupled = ((Fraction(1), Fraction(1, 3), Fraction(0)), (Fraction(1, 3), Fraction(1), Fraction(0)), third[2])
    for theta_inverse in (PUBLISHED_SCALING, third, coupled):
        points = draw(SPACE, theta_inverse, uavs, separation, seed, "start")
        assert closest_pair(points, theta_inverse)[0] >= separation**2
        assert all(
            low + ROOM <= value <= high - ROOM
            for point in points
            for value, (low, high) in zip(point, SPACE, strict=True)
        )


def test_draws_without_a_distance_come_closer() -> None:
    """The test above would fail for points that are drawn without looking at each other."""
    points = draw(SPACE, PUBLISHED_SCALING, 16, Fraction(1, 100), 0, "start")
    assert closest_pair(points, PUBLISHED_SCALING)[0] < Fraction(1, 4) ** 2


@SETTINGS
@given(st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES), min_size=2, max_size=5))
def test_closest_pair_is_exact(points: list[Point]) -> None:
    """closest_pair is the smallest squared scaled distance in fractions, with the pair that has it."""

    def square(a: Point, b: Point) -> Fraction:
        d = [Fraction(q) - Fraction(p) for p, q in zip(a, b, strict=True)]
        return d[0] ** 2 + d[1] ** 2 + (d[2] / 6) ** 2

    found, i, j = closest_pair(points, PUBLISHED_SCALING)
    assert i < j
    assert found == square(points[i], points[j]) == min(square(a, b) for a, b in combinations(points, 2))


def test_a_coupled_scaling_is_used() -> None:
    """closest_pair multiplies with the whole of theta_inverse, not with its diagonal only."""
    zero, one, two = Fraction(0), Fraction(1), Fraction(2)
    coupled = ((two, one, zero), (one, two, zero), (zero, zero, one))
    assert closest_pair([(0.0, 0.0, 0.0), (1.0, -1.0, 0.0)], coupled) == (two, 0, 1)


def test_antipodes_mirror_at_the_centre() -> None:
    """The antipode of a start is at the same height, and the centre is midway."""
    assert antipodes([(1.0, 0.5, 0.7), (0.0, 0.0, 1.0)], (0.25, -0.5)) == ((-0.5, -1.5, 0.7), (0.5, -1.0, 1.0))


def test_lines_and_planes_are_centred() -> None:
    """A line is along x, a plane row by row; neighbours are `spacing` apart, and the centre is in the middle."""
    assert line(3, (1.0, 2.0), spacing=0.5, height=1.5) == ((0.5, 2.0, 1.5), (1.0, 2.0, 1.5), (1.5, 2.0, 1.5))
    assert plane(4, (0.0, 0.0), spacing=1.0, height=1.0) == (
        (-0.5, -0.5, 1.0),
        (0.5, -0.5, 1.0),
        (-0.5, 0.5, 1.0),
        (0.5, 0.5, 1.0),
    )


def test_pyramids_and_cubes_have_their_layers() -> None:
    """A pyramid narrows towards its tip; the upper UAVs of a cube stand above the middle between two lower ones."""
    points = pyramid(8, (0.0, 0.0), side=2.0, height=1.0, rise=0.5)
    assert {(abs(x), abs(y), z) for x, y, z in points} == {(1.0, 1.0, 1.0), (0.5, 0.5, 1.5)}
    points = cube(8, (0.0, 0.0), side=2.0, height=0.5)
    assert points[:4] == ((-1.0, -1.0, 0.5), (1.0, -1.0, 0.5), (1.0, 1.0, 0.5), (-1.0, 1.0, 0.5))
    assert {(x, y) for x, y, z in points if z == 2.5} == {(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)}


def test_spheres_are_round() -> None:
    """Every UAV of a sphere has the distance `radius` from its middle, which is `height` + `radius` high."""
    for x, y, z in sphere(11, (0.5, 0.0), radius=1.2, height=0.5, turn=137.5):
        assert math.dist((x, y, z), (0.5, 0.0, 1.7)) == pytest.approx(1.2)


@pytest.mark.parametrize("uavs", [2, 3, 7, 16, 64])
@pytest.mark.parametrize("name", FORMATIONS)
def test_formations_have_as_many_points_as_uavs(name: str, uavs: int) -> None:
    """Every formation places any number of UAVs, no two of them at one point, the lowest not below `height`."""
    make, numbers = FORMATIONS[name]
    points = make(uavs, (0.0, 0.0), **dict.fromkeys(numbers, 1.0))
    assert len(points) == len(set(points)) == uavs
    assert min(z for _, _, z in points) >= 1.0


def test_changes_apply() -> None:
    """Changes set parameters, the horizon, and the number of UAVs where no positions are given."""
    scenario = load("circle", changes=["uavs=10", "horizon=20", "T_c=0.05", "v_max=1"])
    assert (scenario.uavs, scenario.horizon, scenario.parameters.T_c) == (10, 20, Fraction(1, 20))
    assert scenario.starts == circle(10, (0.0, 0.0), radius=1.45, height=0.8)
    assert len(scenario.targets_at(0)) == 10
    assert load("random", changes=["uavs=12"]).uavs == len(load("random", changes=["uavs=12"]).targets_at(75)) == 12
    assert load("crossing", changes=["horizon=2"]).horizon == 2


def test_files_are_read(tmp_path: Path) -> None:
    """A file is read like what ships: fractions are exact, what is not given is published, centres move formations."""
    path = tmp_path / "mine.toml"
    path.write_text(
        "name = 'mine'\nrounds = 7\nhorizon = 12\n"
        "[parameters]\nworkspace = [[-3, 3], [-3, 3], [0.4, 3]]\nd_hat_min = '1/3'\n"
        "[weights]\njerk = 1e-2\n"
        "[start]\nformation = 'line'\nuavs = 3\nspacing = 0.75\nheight = 1\n"
        "[[targets]]\nround = 0\npositions = [[0, 1, 1.1], [1, 1, '10/9'], [-1, 1, 1]]\n"
        "[[targets]]\nround = 5\nformation = 'circle'\nradius = 1\nheight = 2\ncentre = [1.5, -1]\n"
    )
    scenario = load(str(path))
    assert scenario == Scenario(
        name="mine",
        parameters=Parameters(
            workspace=((Fraction(-3), Fraction(3)), (Fraction(-3), Fraction(3)), (Fraction(2, 5), Fraction(3))),
            d_hat_min=Fraction(1, 3),
        ),
        horizon=12,
        weights=Weights(jerk=0.01),
        starts=((-0.75, 0.0, 1.0), (0.0, 0.0, 1.0), (0.75, 0.0, 1.0)),
        targets=(
            TargetChange(0, ((0.0, 1.0, 1.1), (1.0, 1.0, 10 / 9), (-1.0, 1.0, 1.0))),
            TargetChange(5, circle(3, (1.5, -1.0), radius=1.0, height=2.0)),
        ),
        rounds=7,
    )


def test_a_path_is_no_shipped_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`circle` is what ships even if there is a file of that name; ``./circle`` is the file."""
    monkeypatch.chdir(tmp_path)
    Path("circle").write_text("rounds = 1")
    assert load("circle").uavs == 16
    with pytest.raises(BadInput, match=r"^\./circle: the table \[parameters\] is missing"):
        load("./circle")


def test_the_documented_file_can_be_read(tmp_path: Path) -> None:
    """The file in the module's docstring is a scenario."""
    text = (documented.__doc__ or "").split("TOML file:\n\n")[1].split("\nInstead of")[0]
    path = tmp_path / "documented.toml"
    path.write_text(text)
    assert load(str(path)).uavs == 2
    assert replace(load(str(path)), name="crossing") == load("crossing")


def test_starts_at_exactly_the_distance_are_accepted() -> None:
    """Starts exactly d̂_min apart are accepted; one bit closer, they are refused, and the sentence says so."""
    scenario = load("crossing")
    touching = replace(scenario, starts=((0.0, 0.0, 1.0), (0.25, 0.0, 1.0)))
    assert closest_pair(touching.starts, PUBLISHED_SCALING)[0] == Fraction(1, 16)
    with pytest.raises(BadInput, match=r"distance is 0\.25 \(rounded; a little less\) m, but d_hat_min=0\.25 m"):
        replace(scenario, starts=((0.0, 0.0, 1.0), (math.nextafter(0.25, 0), 0.0, 1.0)))


def test_points_exactly_on_a_wall_are_accepted() -> None:
    """A start on a wall is in the flying space; a float beyond it by rounding is not, and the sentence says so."""
    quarter = load("crossing", changes=["workspace=-0.75,0.75,-1,1,0.4,3"])
    assert replace(quarter, starts=((-0.75, 0.0, 1.0), (0.75, 0.0, 1.0))).uavs == 2
    with pytest.raises(BadInput, match=r"x=0\.75 \(rounded; a little more\) is not in -0\.75…0\.75"):
        replace(quarter, starts=((-0.75, 0.0, 1.0), (math.nextafter(0.75, 1), 0.0, 1.0)))
