"""Fleets of several kinds: each pair keeps its own distance, each UAV its bounds; crashes have their ellipsoid."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import combinations
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from tests.dmpc_swarm.flight.settings import setting

from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.flight.exhaustive import PatternVerdict, explore_flights
from swarmproof.dmpc_swarm.flight.incremental import Flights
from swarmproof.dmpc_swarm.flight.log import Log
from swarmproof.dmpc_swarm.flight.run import Setting, fly
from swarmproof.dmpc_swarm.flight.state import Round
from swarmproof.dmpc_swarm.pages.flight import words as flight_words
from swarmproof.dmpc_swarm.pages.flight.plots import pictures
from swarmproof.dmpc_swarm.pages.flight.series import one_scale, pair_distance, sampled_separation
from swarmproof.dmpc_swarm.planner.accept import old_satisfies
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.errors import BadInput
from swarmproof.faults.grammar import parse
from swarmproof.monitor import bernstein as between
from swarmproof.motion.lattice import Lattice
from swarmproof.motion.pairs import Scales
from swarmproof.scenario.scenario import Scenario, Weights, load
from swarmproof.theorem3.fleet import Fleet

F = Fraction
#: m, m/s: of the kinds large, middle and small.
RADII = {"large": F("0.3"), "middle": F("0.2"), "small": F("0.1")}
SPEEDS = {"large": F(2), "middle": F("1.5"), "small": F(1)}
UAVS = {"large": (0, 3, 6), "middle": (1, 4, 7), "small": (2, 5)}
OF_UAV = {uav: kind for kind, uavs in UAVS.items() for uav in uavs}
HEIGHT = F(1, 6)


def text(radii: dict[str, Fraction] = RADII, extra: str = "") -> str:
    """Return eight UAVs of three sizes and speeds, on a square of 4 m, each flying to the opposite point."""
    square = [[2, 0, 1], [2, 2, 1], [0, 2, 1], [-2, 2, 1], [-2, 0, 1], [-2, -2, 1], [0, -2, 1], [2, -2, 1]]
    kinds = "".join(
        f'[[kinds]]\nname = "{kind}"\nuavs = {list(uavs)}\nv_max = "{SPEEDS[kind]}"\n'
        f'd_hat_min = "{2 * radii[kind]}"\nd_min = "{radii[kind]}"\n'
        for kind, uavs in UAVS.items()
    )
    return (
        f'name = "hetero"\nrounds = 40\n[parameters]\na_max = 10\nworkspace = [[-3, 3], [-3, 3], [0, 3]]\n{extra}'
        f"[weights]\nband = 5\n{kinds}[start]\npositions = {square}\n"
        f"[[targets]]\nround = 0\npositions = {square[4:] + square[:4]}\n"
    )


@pytest.fixture(scope="module")
def hetero(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    """Return that scenario."""
    path = tmp_path_factory.mktemp("kinds") / "hetero.toml"
    path.write_text(text())
    return load(str(path))


class Watched:
    """A flight, with its rounds."""

    def __init__(self, what: Setting, rounds: int = 25) -> None:
        self.setting = what
        self.rounds: list[Round] = []
        self.flown, _ = fly(what, parse("none", what.scenario.uavs, what.cus, 0), rounds, self.rounds.append)

    def plans(self, i: int) -> list[Plan]:
        """Return everything that UAV i followed, by round."""
        return [flown.before.followed(i) for flown in self.rounds]


@pytest.fixture(scope="module")
def watched(hetero: Scenario) -> Watched:
    """Return a flight of it."""
    return Watched(setting(hetero, cus=3))


def positions(watched: Watched, i: int) -> list[list[Fraction]]:
    """Return where UAV i is at the samples of the flight (m), integrated anew from states and jerks: exactly."""
    found = []
    for flown, plan in zip(watched.rounds, watched.plans(i), strict=True):
        units, k = plan.lattice, flown.before.k
        state, jerk = plan.state_at(k), plan.jerk_in(k)
        T_c = units.parameters.T_c
        for h in range(units.steps):
            t = h * T_c
            found.append(
                [
                    int(p) * units.position_unit
                    + int(v) * units.velocity_unit * t
                    + int(a) * units.acceleration_unit * t**2 / 2
                    + int(j) * units.jerk_unit * t**3 / 6
                    for p, v, a, j in zip(*state, jerk, strict=True)
                ]
            )
    return found


def least_share(watched: Watched, radii: dict[str, Fraction] = RADII) -> Fraction:
    """Return the smallest squared scaled distance at samples over that of the pair's radii, of all pairs and times."""
    where = [positions(watched, i) for i in range(8)]
    return min(
        ((x1 - x0) ** 2 + (y1 - y0) ** 2 + ((z1 - z0) * HEIGHT) ** 2) / (radii[OF_UAV[i]] + radii[OF_UAV[j]]) ** 2
        for i, j in combinations(range(8), 2)
        for (x0, y0, z0), (x1, y1, z1) in zip(where[i], where[j], strict=True)
    )


def test_every_pair_keeps_the_sum_of_its_radii(watched: Watched) -> None:
    """No claim is violated, and an independent integration finds every pair at least r_i + r_j apart at samples.

    The smallest share is what the judge says, in units of d̂_min; and some pair comes close: this is no empty sky.
    """
    assert not watched.flown.violated
    assert watched.flown.qps.rejected + watched.flown.qps.infeasible == 0
    share = least_share(watched)
    assert 1 <= share < F("1.1")
    assert watched.flown.sampled == pytest.approx(0.25 * sqrt(share), rel=1e-12)


def test_every_uav_keeps_its_own_bounds(watched: Watched) -> None:
    """The speed of each UAV stays within its kind's bound, exactly, and comes near to it."""
    fastest = dict.fromkeys(UAVS, F(0))
    for i, kind in OF_UAV.items():
        for plan in watched.plans(i):
            assert plan.lattice.parameters.v_max == (SPEEDS[kind],) * 3
            speed = int(np.abs(plan.velocities).max()) * plan.lattice.velocity_unit
            fastest[kind] = max(fastest[kind], speed)
    assert all(F("0.9") * SPEEDS[kind] < fastest[kind] <= SPEEDS[kind] for kind in UAVS), fastest


def test_words_and_json_name_the_kinds(watched: Watched) -> None:
    """The scope lists who is of which kind and what differs; JSON has the parameters; published v_max is not blamed."""
    said = flight_words.scope(watched.setting, "none", watched.flown)
    assert (
        "Kinds: large (UAVs 0, 3, 6: d_hat_min=0.6, d_min=0.3); middle (UAVs 1, 4, 7: d_hat_min=0.4, v_max=1.5" in said
    )
    assert "v_max = " not in said
    kinds = json.loads(flight_words.document(watched.setting, "none", watched.flown, 0.0))["kinds"]
    assert [kind["uavs"] for kind in kinds] == [list(uavs) for uavs in UAVS.values()]
    assert kinds[2]["parameters"]["d_hat_min"] == pytest.approx(0.2)


# Planted faults


class WrongFleet:
    """A planner that takes the UAVs for another fleet; what it says of the old trajectory is right."""

    def __init__(self, units: Lattice, fleet: Fleet, weights: Weights) -> None:
        self.units = replace(units, fleet=fleet)
        self.planner = Planner(self.units, weights)

    def plan(self, task: Task) -> Planned:
        """Return the plan for the same task in that fleet."""

        def elsewhere(i: int, plan: Plan, units: Lattice) -> Plan:
            return Plan(units.of_uav(i), plan.start, plan.state, plan.jerks)

        others = {j: tuple(elsewhere(j, plan, self.units) for plan in held) for j, held in task.others.items()}
        planned = self.planner.plan(replace(task, own=elsewhere(task.i, task.own, self.units), others=others))
        planned = replace(planned, feasible=old_satisfies(task.own, task.start, task.planes))
        if planned.plan is None:
            return planned
        return replace(planned, plan=Plan(task.own.lattice, planned.plan.start, planned.plan.state, planned.plan.jerks))


def violated(what: Setting, fleet: Fleet) -> tuple[set[str], Fraction]:
    """Return the claims that are violated if the planner takes the UAVs for this fleet, and the smallest share."""
    flight = what.flight()
    flight = what.flight(WrongFleet(flight.lattice, fleet, what.scenario.weights))
    seen = Watched.__new__(Watched)
    seen.rounds = []
    flown, _ = fly(what, parse("none", 8, what.cus, 0), 25, seen.rounds.append, flight)
    return {one.claim.id for one in flown.claims if one.verdict is Verdict.VIOLATED}, least_share(seen)


def test_a_planner_that_counts_the_smaller_radius_twice_is_caught(hetero: Scenario) -> None:
    """A pair that keeps the distance of its smaller UAV violates the claims, as the integration anew confirms."""
    right = hetero.fleet
    smaller = replace(right, parameters=tuple(replace(one, d_hat_min=F("0.2")) for one in right.parameters))
    claims, share = violated(setting(hetero, cus=3), smaller)
    assert {"theorem-2", "tracked-separation"} <= claims
    assert share < F("0.9")


def test_a_planner_with_the_kind_of_another_uav_is_caught(hetero: Scenario) -> None:
    """With the matrices of wrong kinds, some pairs come too close."""
    right = hetero.fleet
    claims, share = violated(setting(hetero, cus=3), replace(right, members=(*right.members[1:], right.members[0])))
    assert {"theorem-2", "tracked-separation"} <= claims
    assert share < F("0.99")


def test_a_planner_with_the_bounds_of_another_kind_is_caught(hetero: Scenario) -> None:
    """A small UAV planned with the speed of a large one: its trajectory breaks its bounds, as Theorem 1 shows."""
    right = hetero.fleet
    fast = tuple(replace(one, v_max=(F(2), F(2), F(2))) for one in right.parameters)
    claims, _ = violated(setting(hetero, cus=3), replace(right, parameters=fast))
    assert "theorem-1" in claims


# One place for pairs


def test_pairs_have_the_scaling_and_the_distance_of_both(hetero: Scenario) -> None:
    """‖S_ij x‖ in its unit, over d̂_min, is ‖Θ_ij⁻¹ x‖ over r_i + r_j: exactly, for every pair."""
    units = setting(hetero).flight().lattice
    pairs = units.pairs
    assert not pairs.alike
    x = (3, -5, 7)
    for i, j in combinations(range(8), 2):
        matrix = pairs.second(i, j)
        assert matrix is not None
        scaled = sum((int(part) * pairs.unit_of(i, j)) ** 2 for part in matrix @ np.array(x, float))
        unit = setting(hetero).flight().lattice.position_unit
        wide = ((x[0] * unit) ** 2 + (x[1] * unit) ** 2 + (x[2] * unit * HEIGHT) ** 2) / (
            RADII[OF_UAV[i]] + RADII[OF_UAV[j]]
        ) ** 2
        assert scaled / pairs.distance**2 == wide


def test_kinds_with_equal_distances_are_scaled_as_ever(tmp_path: Path) -> None:
    """Kinds that differ in bounds only have one scaling, that of a swarm without kinds."""
    path = tmp_path / "speeds.toml"
    path.write_text(text(dict.fromkeys(RADII, F(1, 8))).replace('d_min = "1/8"', 'd_min = "0.12"'))
    units, plain = setting(load(str(path))).flight().lattice, setting("crossing").flight().lattice
    for mine, theirs in ((units.pairs, plain.pairs), (units.crash, plain.crash)):
        assert mine.alike
        assert np.array_equal(mine.first, theirs.first)
        assert mine.unit / units.position_unit == theirs.unit / plain.position_unit


def test_between_samples_each_pair_has_its_scale() -> None:
    """All pairs with matrices and weights of their own come as close as the closest of them, each scaled for itself."""
    random = np.random.default_rng(7)
    for _ in range(20):
        pieces = np.rint(random.normal(0, 2.0**20, (3, 4, 3, 4)))
        matrices = random.integers(-9, 10, (6, 3, 3)).astype(float)
        weights = tuple(F(int(n), 7) for n in random.integers(7, 30, 6))
        alone = [
            between.closest(np.einsum("xy,snyk->snxk", matrix, pieces[:, [i, j]]))
            for matrix, (i, j) in zip(matrices, combinations(range(4), 2), strict=True)
        ]
        worth = [one.upper * float(weight) for one, weight in zip(alone, weights, strict=True)]
        scales, best = Scales(matrices, weights), min(worth)
        found = between.closest(pieces, scales)
        assert found.lower * (1 - 1e-14) <= best <= found.upper * (1 + 1e-8)
        assert found.pair == list(combinations(range(4), 2))[worth.index(best)]
        lower, upper = between.lowest_per_step(pieces, scales)
        assert lower.min() <= best * (1 + 1e-14)
        assert best <= upper.min() * (1 + 1e-5)
        # decided by floats, and by integers alone where these are close
        for share in (F(999, 1000), 1 - F(1, 10**11)):
            assert between.at_least(pieces, F(found.lower) * share, scales)
            assert between.at_least(pieces, F(found.upper) / share, scales) is False


# Crashes


def nearest(watched: Watched, height: Fraction) -> float:
    """Return the smallest distance of two UAVs between samples, too, with heights multiplied so: densely sampled."""
    square = np.inf
    for flown in watched.rounds:
        plans = [flown.before.followed(i) for i in range(2)]
        k, m = flown.before.k, plans[0].lattice.steps
        for step in np.linspace(0, m, 20 * m + 1):
            one, other = (plan.position(m * (k - plan.start) + step) for plan in plans)
            x, y, z = (other - one) * float(plans[0].lattice.position_unit)
            square = min(square, x**2 + y**2 + (z * float(height)) ** 2)
    return sqrt(square)


def test_a_crash_has_its_own_ellipsoid() -> None:
    """Plans keep the tall ellipsoid, eq. (2) is about the other one: its certified distance is the true one there."""
    seen = Watched(setting("crossing", changes=("crash_theta_inverse=1,1,0.9",)), 30)
    plain = Watched(setting("crossing"), 30)
    assert not seen.flown.violated
    assert seen.flown.sampled == plain.flown.sampled
    assert seen.flown.continuous_lower == pytest.approx(nearest(seen, F("0.9")), rel=1e-4)
    assert plain.flown.continuous_lower == pytest.approx(nearest(plain, HEIGHT), rel=1e-4)
    assert "at any time by crash_theta_inverse" in flight_words.scope(seen.setting, "none", seen.flown)


def test_a_large_crash_ellipsoid_is_entered() -> None:
    """With an ellipsoid of crashes that plans know nothing of, eq. (2) alone is violated; the chain says how far."""
    seen = Watched(setting("crossing", changes=("crash_theta_inverse=0.4",)), 30)
    (broken,) = [one for one in seen.flown.claims if one.verdict is Verdict.VIOLATED]
    assert broken.claim.id == "eq-2"
    (said,) = [line for line in broken.chain if "Closest approach" in line]
    assert f"{seen.flown.continuous_lower:.4f} m apart" in said


# Two UAVs: searches


@cache
def two(folder: str) -> Scenario:
    """Return two UAVs of different size and speed that swap places."""
    path = Path(folder) / "two.toml"
    path.write_text(
        'name = "two"\nrounds = 12\n[parameters]\nworkspace = [[-2, 2], [-2, 2], [0, 3]]\n[[kinds]]\nuavs = [1]\n'
        "v_max = 1\nd_hat_min = 0.4\ntracking_error = 0.01\n[start]\npositions = [[-0.6, 0, 1], [0.6, 0.05, 1]]\n"
        "[[targets]]\nround = 0\npositions = [[0.6, 0.05, 1], [-0.6, 0, 1]]\n"
    )
    return load(str(path))


def test_searches_know_the_pairs(tmp_path_factory: pytest.TempPathFactory) -> None:
    """All losses of two rounds are flown; a flight of the adversary has the distance that the judge certifies."""
    what = setting(two(str(tmp_path_factory.mktemp("two"))))
    found = explore_flights(what, 2, lambda *_: None)
    assert not [one for one in found.claims if one.verdict is PatternVerdict.VIOLATED]
    seen = Watched(what, 12)
    assert not seen.flown.violated
    flown = Flights(what, 12).fly((), whole=True)
    assert flown.distance == pytest.approx(seen.flown.continuous_lower, rel=1e-8)
    # of the second UAV only, as the first one follows its reference exactly
    (actual,) = [one for one in seen.flown.claims if one.claim.id == "eq-2-actual"]
    assert actual.verdict is Verdict.NOT_VIOLATED


# Scenarios


def test_points_keep_the_distance_of_their_pair(tmp_path: Path) -> None:
    """Two large UAVs need 0.6 m, two small ones 0.2 m: what is too close depends on who it is."""
    path = tmp_path / "close.toml"
    path.write_text(text().replace("[-2, 2, 1]", "[1.45, 0, 1]", 1))
    with pytest.raises(BadInput, match=r"UAV 0 and UAV 3 are too close: .* 0.55 m, but d_hat_min=0.6 m"):
        load(str(path))
    path.write_text(text().replace("[-2, -2, 1]", "[0.25, 2, 1]", 1))
    assert load(str(path)).uavs == 8


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("uavs = [2, 5]", "uavs = [2, 8]", r"small lists UAV 8, but there are 8 UAVs, numbered 0 to 7"),
        ("uavs = [2, 5]", "uavs = []", r"no UAV is of kind small: write a line such as uavs = \[0, 3\]"),
        ("uavs = [2, 5]", "uavs = [2, 0]", r"UAV 0 is of two kinds, large and small: list it once"),
        (
            "a_max = 10",
            "v_max = [1, 2, 3, 4, 5, 6, 7, 8]",
            r"UAVs that differ are of \[\[kinds\]\]: .* v_max = 0.5 below",
        ),
        (
            "a_max = 10",
            "d_hat_min = [1, 2, 3, 4, 5, 6, 7, 8]",
            r"d_hat_min takes one number, such as 0.25; UAVs that differ",
        ),
    ],
)
def test_mistakes_are_answered(tmp_path: Path, old: str, new: str, said: str) -> None:
    """Indices that do not fit, and lists per UAV where none can be, get one sentence that says what would be right."""
    path = tmp_path / "wrong.toml"
    path.write_text(text().replace(old, new))
    with pytest.raises(BadInput, match=said):
        load(str(path))


def test_random_points_keep_the_distance_of_any_pair(tmp_path: Path) -> None:
    """Random starts of a fleet need the separation of the largest kind, and then suit every pair."""
    path = tmp_path / "random.toml"
    begin, end = text().split("[start]")
    drawn = (
        '[start]\nformation = "random"\nuavs = 8\nseparation = {}\n[[targets]]\nround = 0\nformation = "antipodes"\n'
    )
    assert "positions" in end
    path.write_text(begin + drawn.format("0.5"))
    with pytest.raises(BadInput, match=r"separation=0.5 must be at least d_hat_min=0.6"):
        load(str(path))
    path.write_text(begin + drawn.format("0.7"))
    assert len({load(str(path), seed).starts for seed in range(3)}) == 3
    with pytest.raises(BadInput, match="lists UAV"):
        load(str(path), changes=["uavs=4"])


def test_three_numbers_for_three_uavs_are_axes() -> None:
    """Where three bounds could be meant for three UAVs, the scope says that they are x, y and z; else it does not."""
    three = Watched(setting("formations", changes=("uavs=3", "v_max=2,1.5,1")), 1)
    assert "the axes x, y, z of every UAV (v_max=2,1.5,1 per axis)" in flight_words.scope(
        three.setting, "none", three.flown
    )
    four = replace(three.setting, scenario=load("formations", 0, ["uavs=4", "v_max=2,1.5,1"]))
    assert "axes" not in flight_words.scope(four, "none", three.flown)


def test_the_example_of_the_docs_flies(tmp_path: Path) -> None:
    """The mixed swarm in docs/your-swarm.md is read as it stands, has the distances that it says, and flies."""
    page = (Path(__file__).parents[3] / "docs/your-swarm.md").read_text()
    (block,) = [part for part in page.split("```toml\n")[1:] if part.startswith('name = "mixed"')]
    path = tmp_path / "mixed.toml"
    path.write_text(block.split("```")[0])
    scenario = load(str(path))
    fleet = scenario.fleet
    assert [fleet.pair(*map(fleet.place, pair)).d_hat_min for pair in ((0, 1), (0, 2))] == [F("0.6"), F("0.425")]
    seen = Watched(setting(scenario, cus=3), 30)
    assert not seen.flown.violated
    assert seen.flown.arrived


def test_pages_have_one_scale_on_an_axis() -> None:
    """Where crashes have an ellipsoid, the curve of a pair is scaled for them, and d̂_min is not drawn beside it."""
    pytest.importorskip("matplotlib")
    for changes, alike in ((("crash_theta_inverse=1",), False), ((), True)):
        what = setting("crossing", changes=changes)
        flight = what.flight()
        log = Log(flight)
        flown, _ = fly(what, parse("none", 2, 2, 0), 30, log.see, flight)
        assert one_scale(log) is alike
        curve = min(float(pair_distance(log, (0, 1), 40, k, k + 1).min()) for k in range(30))
        assert curve == pytest.approx(flown.continuous_lower, rel=1e-3)
        assert float(sampled_separation(log)[:-1].min()) == pytest.approx(flown.sampled, rel=1e-9)
        separation = next(picture for picture in pictures(flown, log) if picture.name == "separation")
        assert ("d̂_min" in separation.caption) is alike
