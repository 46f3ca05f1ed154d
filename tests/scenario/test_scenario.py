"""Scenarios: those that ship are as documented, and random ones are repeatable."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.scenario.points import at, points

import swarmproof.scenario.scenario as documented
from swarmproof.dmpc_swarm.semantics import SWITCHES
from swarmproof.errors import BadInput
from swarmproof.scenario.choices import CHOICES
from swarmproof.scenario.definition import WEIGHTS
from swarmproof.scenario.formations import FORMATIONS, antipodes, circle, cube, line, plane, pyramid, sphere
from swarmproof.scenario.points import PER_METRE, ROOM, closest_pair, disturbed, draw, shuffled
from swarmproof.scenario.scenario import SHIPPED, USUAL, Choices, Point, Scenario, TargetChange, Weights, load
from swarmproof.theorem3.parameters import NAMES, PUBLISHED_SCALING, Parameters
from swarmproof.theorem3.values import ClosedBox, diagonal

SETTINGS = settings(max_examples=60, deadline=None, derandomize=True, database=None)

COORDINATES = st.floats(-5, 5).map(Fraction)
#: The centre of a formation.
ORIGIN = (Fraction(0), Fraction(0))

SPACE: ClosedBox = (
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
    for listed in _all_points(scenario):
        assert len(listed) == uavs
        assert _smallest(listed) >= distance
        assert _room(listed) >= 0.1


def test_columns_and_walls_are_noticed() -> None:
    """What the test above measures is small for UAVs above each other, and near a wall."""
    assert _smallest(points((0.0, 0.0, 0.5), (0.0, 0.0, 2.9))) < 0.45
    assert _room(points((0.0, 1.65, 1.0))) < 0.1


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
    assert scenario.starts == plane(16, ORIGIN, spacing=0.8, height=1.2)
    assert [change.round for change in scenario.targets] == [0, 110, 220, 330]
    assert scenario.targets_at(109) == pyramid(16, ORIGIN, side=3.1, height=0.6, rise=2.2)
    assert scenario.targets_at(110) == scenario.targets_at(219) == cube(16, ORIGIN, side=2.2, height=0.6)
    assert scenario.targets_at(220) == sphere(16, ORIGIN, radius=1.2, height=0.5, turn=127.5)
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
    for drawn in sets:
        assert len(drawn) == 8
        assert _smallest(drawn) >= 0.5
        assert _room(drawn) >= 0.1


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


def test_closest_pairs_are_found_among_any_fractions() -> None:
    """Coordinates whose common denominator has hundreds of digits are compared, and so are those that are almost 0."""
    many = [at(i, Fraction(1, 10**6 + 2 * i + 1), Fraction(i, 997 + i)) for i in range(64)]
    near = at(many[7][0] + Fraction(1, 10**5 + 3), *many[7][1:])
    assert math.lcm(*(x.denominator for point in many for x in point)) > 10**310
    assert closest_pair([*many, near], PUBLISHED_SCALING) == (Fraction(1, 10**5 + 3) ** 2, 7, 64)
    tiny = Fraction(1, 10**400)
    row = [at(n * tiny, 0, 0) for n in (0, 4, 7, 9, 12)]
    assert closest_pair(row, PUBLISHED_SCALING) == ((2 * tiny) ** 2, 2, 3)


def test_a_coupled_scaling_is_used() -> None:
    """closest_pair multiplies with the whole of theta_inverse, not with its diagonal only."""
    zero, one, two = Fraction(0), Fraction(1), Fraction(2)
    coupled = ((two, one, zero), (one, two, zero), (zero, zero, one))
    assert closest_pair(points((0.0, 0.0, 0.0), (1.0, -1.0, 0.0)), coupled) == (two, 0, 1)


def test_antipodes_mirror_at_the_centre() -> None:
    """The antipode of a start is at the same height, and the centre is midway."""
    assert antipodes(points((1.0, 0.5, 0.7), (0.0, 0.0, 1.0)), (Fraction(1, 4), Fraction(-1, 2))) == points(
        (-0.5, -1.5, 0.7), (0.5, -1.0, 1.0)
    )


def test_lines_and_planes_are_centred() -> None:
    """A line is along x, a plane row by row; neighbours are `spacing` apart, and the centre is in the middle."""
    assert line(3, (Fraction(1), Fraction(2)), spacing=0.5, height=1.5) == points(
        (0.5, 2.0, 1.5), (1.0, 2.0, 1.5), (1.5, 2.0, 1.5)
    )
    assert plane(4, ORIGIN, spacing=1.0, height=1.0) == points(
        (-0.5, -0.5, 1.0),
        (0.5, -0.5, 1.0),
        (-0.5, 0.5, 1.0),
        (0.5, 0.5, 1.0),
    )


def test_pyramids_and_cubes_have_their_layers() -> None:
    """A pyramid narrows towards its tip; the upper UAVs of a cube stand above the middle between two lower ones."""
    layers = pyramid(8, ORIGIN, side=2.0, height=1.0, rise=0.5)
    assert {(abs(x), abs(y), z) for x, y, z in layers} == set(points((1.0, 1.0, 1.0), (0.5, 0.5, 1.5)))
    corners = cube(8, ORIGIN, side=2.0, height=0.5)
    assert corners[:4] == points((-1.0, -1.0, 0.5), (1.0, -1.0, 0.5), (1.0, 1.0, 0.5), (-1.0, 1.0, 0.5))
    assert set(corners[4:]) == set(points((0.0, -1.0, 2.5), (1.0, 0.0, 2.5), (0.0, 1.0, 2.5), (-1.0, 0.0, 2.5)))


def test_spheres_are_round() -> None:
    """Every UAV of a sphere has the distance `radius` from its middle, which is `height` + `radius` high."""
    for x, y, z in sphere(11, (Fraction(1, 2), Fraction(0)), radius=1.2, height=0.5, turn=137.5):
        assert math.dist((x, y, z), (0.5, 0.0, 1.7)) == pytest.approx(1.2)


@pytest.mark.parametrize("uavs", [2, 3, 7, 16, 64])
@pytest.mark.parametrize("name", FORMATIONS)
def test_formations_have_as_many_points_as_uavs(name: str, uavs: int) -> None:
    """Every formation places any number of UAVs, no two of them at one point, the lowest not below `height`."""
    make, numbers = FORMATIONS[name]
    points = make(uavs, ORIGIN, **dict.fromkeys(numbers, 1.0))
    assert len(points) == len(set(points)) == uavs
    assert min(z for _, _, z in points) >= 1.0


def test_changes_apply() -> None:
    """Changes set parameters, the horizon, and the number of UAVs where no positions are given."""
    scenario = load("circle", changes=["uavs=10", "horizon=20", "T_c=0.05", "v_max=1"])
    assert (scenario.uavs, scenario.horizon, scenario.parameters.T_c) == (10, 20, Fraction(1, 20))
    assert scenario.starts == circle(10, ORIGIN, radius=1.45, height=0.8)
    assert len(scenario.targets_at(0)) == 10
    assert load("random", changes=["uavs=12"]).uavs == len(load("random", changes=["uavs=12"]).targets_at(75)) == 12
    assert load("crossing", changes=["horizon=2"]).horizon == 2


# What can be changed


def _seeds(name: str, count: int, *changes: str) -> list[Scenario]:
    return [load(name, seed, changes) for seed in range(count)]


@pytest.mark.parametrize("name", SHIPPED)
def test_jitter_moves_starts_a_little(name: str) -> None:
    """Every coordinate of a start moves, by no more than `jitter`, and another way with each seed; targets stay."""
    scenarios = _seeds(name, 8, "jitter=0.02")
    moves: list[Fraction] = []
    for seed, moved in enumerate(scenarios):
        as_listed = load(name, seed)
        assert moved == load(name, seed, ["jitter=0.02"])
        assert moved.targets == as_listed.targets
        assert moved.targets_at(10**4) == as_listed.targets_at(10**4)
        pairs = [
            (a, b)
            for one, other in zip(moved.starts, as_listed.starts, strict=True)
            for a, b in zip(one, other, strict=True)
        ]
        moves += [a - b for a, b in pairs]
    assert max(abs(move) for move in moves) <= 0.02 + 1e-15
    assert len(set(moves)) == len(moves)
    # uniform: the mean of n draws is 0 up to some 4 · 0.0116 / sqrt(n), and some come near the ends
    assert abs(float(sum(moves)) / len(moves)) < 4 * 0.0116 / math.sqrt(len(moves))
    assert min(moves) < -0.017
    assert max(moves) > 0.017


def test_jitter_is_independent_for_each_uav() -> None:
    """A UAV is disturbed as much however many others there are, and twice as much with twice the jitter."""
    few, many = load("circle", 3, ["uavs=4", "jitter=0.01"]), load("circle", 3, ["uavs=16", "jitter=0.02"])
    moved = [
        [b - a for a, b in zip(load("circle", 3, [f"uavs={one.uavs}"]).starts[0], one.starts[0], strict=True)]
        for one in (few, many)
    ]
    assert moved[1] == pytest.approx([2 * move for move in moved[0]])


def test_jitter_stays_in_the_space() -> None:
    """What would leave the flying space stops at its wall, also where no float is exactly on it (3.7)."""
    space = "workspace=-1.7,1.7,-3.7,3.7,0.875,1.125"
    starts = [start for one in _seeds("crossing", 20, "jitter=0.5", space) for start in one.starts]
    assert {z for _, _, z in starts} >= {0.875, 1.125}
    wall = Fraction(37, 10)
    assert Fraction(3.7) != wall
    ((_, y, _),) = disturbed(points((0.0, 3.69, 1.0)), ((-wall, wall),) * 3, Fraction(100), _seed_for(1))
    assert y == wall
    ((_, y, _),) = disturbed(points((0.0, 3.69, 1.0)), ((-wall, wall),) * 3, Fraction(100), _seed_for(-1))
    assert y == -wall


def _seed_for(sign: int) -> int:
    """Return a seed with which the jitter of UAV 0 in y has this sign, and is not small."""
    space = ((Fraction(-1000), Fraction(1000)),) * 3
    return next(s for s in range(100) if sign * disturbed(points((0.0, 0.0, 0.0)), space, Fraction(1), s)[0][1] > 0.2)


def test_without_jitter_nothing_moves() -> None:
    """`jitter=0` is what is flown if nothing is said."""
    assert load("circle", 5, ["jitter=0"]) == load("circle")


def test_shuffled_targets_are_a_permutation() -> None:
    """Each change has the listed points, in another order for each change and seed; starts stay."""
    listed = load("formations")
    orders = set()
    for permuted in _seeds("formations", 5, "assignment=shuffled"):
        assert permuted.starts == listed.starts
        for one, other in zip(permuted.targets, listed.targets, strict=True):
            assert one.round == other.round
            assert sorted(one.points) == sorted(other.points)
            orders.add(tuple(other.points.index(point) for point in one.points))
    assert len(orders) == 5 * len(listed.targets)
    assert load("formations", 3, ["assignment=shuffled"]) == load("formations", 3, ["assignment=shuffled"])
    assert load("formations", 3, ["assignment=listed"]) == listed


def test_every_permutation_is_drawn_as_often() -> None:
    """Of 600 seeds, each of the 6 orders of three targets gets about 100."""
    three = points((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0))
    counts = Counter(shuffled(three, seed, "x") for seed in range(600))
    assert len(counts) == 6
    # five standard deviations of a binomial distribution
    assert all(abs(count - 100) < 5 * math.sqrt(600 * 5 / 36) for count in counts.values())


def test_hold_moves_the_changes() -> None:
    """`hold` sets how far changes are apart, and the flight's length; the points stay, whatever order they have."""
    listed, held = (
        load("formations", 2, ["assignment=shuffled"]),
        load("formations", 2, ["assignment=shuffled", "hold=250"]),
    )
    assert [change.round for change in held.targets] == [0, 250, 500, 750]
    assert [change.points for change in held.targets] == [change.points for change in listed.targets]
    assert held.rounds == 1000
    assert held.targets_at(249) == held.targets_at(0) != held.targets_at(250)
    assert load("circle", 0, ["hold=77"]).rounds == 77


def test_hold_of_random_targets() -> None:
    """Where random targets are drawn for ever, `hold` is how often; how long the flight is, is not changed."""
    held = load("random", 0, ["hold=40"])
    assert held.rounds == load("random").rounds
    assert [held.target_change_before(k) for k in (39, 40, 79, 80)] == [0, 40, 40, 80]
    assert held.targets_at(0) == load("random").targets_at(0)
    assert len({held.targets_at(k) for k in range(0, 400, 40)}) == 10


def test_weights_and_choices_are_changed_by_name() -> None:
    """Every weight and every choice can be set; what is not set stays as the scenario has it."""
    texts = [f"{name}={i}" for i, name in enumerate(WEIGHTS, 2)]
    assert load("circle", 0, texts).weights == Weights(2, 3, 4, 5, 6, 7)
    assert load("circle", 0, ["band=0.5"]).weights == Weights(band=0.5)
    assert load("circle", 0, ["jerk=1e-2"]).weights == Weights(jerk=0.01, band=5)
    for name in CHOICES:
        (text,) = (text for text in OTHER if text.startswith(f"{name}="))
        chosen = load("circle", 0, [text]).choices
        assert chosen.differences() == [text]
        assert chosen != USUAL
    assert load("circle", 0, OTHER).choices == Choices("linear", 0, "off", 0.25, 0, 7, "highest")
    assert load("circle", 0, [f"{name}={getattr(USUAL, name)}" for name in CHOICES]) == load("circle")


OTHER = (
    "priority_scale=linear",
    "retry=0",
    "detours=off",
    "detour_step=0.25",
    "detour_noise=0",
    "detour_rounds=7",
    "offer=highest",
)


def test_a_file_has_all_of_it(tmp_path: Path) -> None:
    """What --set can change, a file can have: the same scenario comes out; --set wins over the file."""
    path = tmp_path / "mine.toml"
    text = Path(documented.__file__).with_name("formations.toml").read_text()
    own = "jitter = 0.02\nassignment = 'shuffled'\nhold = 250\n[choices]\nretry = 0\noffer = 'highest'\n[parameters]"
    path.write_text(text.replace("[parameters]", own).replace("round = 110\n", ""))
    changes = ["jitter=0.02", "assignment=shuffled", "hold=250", "retry=0", "offer=highest"]
    assert load(str(path), 4) == load("formations", 4, changes)
    assert load(str(path), 4, ["jitter=0", "hold=9", "retry=5"]) == load(
        "formations", 4, ["jitter=0", "hold=9", *changes[1:2], "retry=5", "offer=highest"]
    )


def test_all_names_differ() -> None:
    """What a name means does not depend on who reads it: parameters, switches, weights, choices, the scenario's own."""
    names = [*NAMES, *SWITCHES, *(name for table in documented.CHANGEABLE.values() for name in table)]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("name", SHIPPED)
def test_differences_make_the_scenario_again(name: str) -> None:
    """What `differences` says, set on the same name, gives the same scenario: nothing that was changed is unsaid."""
    assert load(name).differences() == ["workspace=-1.7,1.7,-1.7,1.7,0.4,3", "band=5"]
    changes = ["T_c=0.05", "v_max=1", "horizon=20", "jerk=0.5", "tolerance=0.01", "jitter=1e-3", "hold=30", *OTHER]
    if name != "random":
        changes.append("assignment=shuffled")
    for some in (changes, *([change] for change in changes)):
        scenario = load(name, 1, some)
        said = scenario.differences()
        assert {change.partition("=")[0] for change in said} >= {change.partition("=")[0] for change in some}
        assert load(name, 1, said) == scenario


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
        starts=points((-0.75, 0.0, 1.0), (0.0, 0.0, 1.0), (0.75, 0.0, 1.0)),
        targets=(
            TargetChange(0, points((0.0, 1.0, 1.1), (1.0, 1.0, Fraction(10, 9)), (-1.0, 1.0, 1.0))),
            TargetChange(5, circle(3, (Fraction(3, 2), Fraction(-1)), radius=1.0, height=2.0)),
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
    text = (documented.__doc__ or "").split("TOML file:\n\n")[1].split("\nUAVs that differ")[0]
    path = tmp_path / "documented.toml"
    path.write_text(text)
    assert load(str(path)).uavs == 2
    assert replace(load(str(path)), name="crossing") == load("crossing")


def test_starts_at_exactly_the_distance_are_accepted() -> None:
    """Starts exactly d̂_min apart are accepted; one bit closer, they are refused, and the sentence says so."""
    scenario = load("crossing")
    touching = replace(scenario, starts=points((0.0, 0.0, 1.0), (0.25, 0.0, 1.0)))
    assert closest_pair(touching.starts, PUBLISHED_SCALING)[0] == Fraction(1, 16)
    with pytest.raises(BadInput, match=r"distance is 0\.25 \(rounded; a little less\) m, but d_hat_min=0\.25 m"):
        replace(scenario, starts=points((0.0, 0.0, 1.0), (math.nextafter(0.25, 0), 0.0, 1.0)))


def test_points_exactly_on_a_wall_are_accepted() -> None:
    """A start on a wall is in the flying space; a float beyond it by rounding is not, and the sentence says so."""
    quarter = load("crossing", changes=["workspace=-0.75,0.75,-1,1,0.4,3"])
    assert replace(quarter, starts=points((-0.75, 0.0, 1.0), (0.75, 0.0, 1.0))).uavs == 2
    with pytest.raises(BadInput, match=r"x=0\.75 \(rounded; a little more\) is not in -0\.75…0\.75"):
        replace(quarter, starts=points((-0.75, 0.0, 1.0), (math.nextafter(0.75, 1), 0.0, 1.0)))
