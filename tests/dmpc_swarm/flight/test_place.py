"""Where a scenario stands decides nothing: it is accepted or refused alike anywhere, and placed exactly as it says.

Pairs that are exactly d̂_min apart, in spaces whose walls may be exactly where the UAVs are, are mirrored, turned and
moved; all is recomputed here in fractions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction
from functools import partial
from itertools import permutations, product
from random import Random
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dmpc_swarm.flight.settings import setting
from tests.margin.settings import examples
from tests.scenario.points import Coordinate, at, decimal, points

from swarmproof.dmpc_swarm.flight.place import place
from swarmproof.dmpc_swarm.flight.run import fly
from swarmproof.errors import BadInput
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import COARSEST, FINEST, Lattice
from swarmproof.scenario.definition import Scenario, TargetChange, Weights
from swarmproof.scenario.points import Point
from swarmproof.scenario.scenario import load
from swarmproof.theorem3.parameters import Parameters
from swarmproof.theorem3.values import ClosedBox, Vector, closed, diagonal

F = Fraction
NANO = F(1, 10**9)


class Pair(NamedTuple):
    """Two UAVs; `way` leads from one to the other and is exactly d̂_min long with the scaling Θ⁻¹ = diag(`theta`)."""

    theta: Vector
    d_hat_min: Fraction
    way: Point


def pair(sixth: Coordinate, d_hat_min: Coordinate, *way: Coordinate) -> Pair:
    """Return the pair with the scaling diag(1, 1, `sixth`)."""
    x, y, z = way
    return Pair(at(1, 1, sixth), decimal(d_hat_min), at(x, y, z))


PAIRS = (
    pair(F(1, 6), 0.25, 0.25, 0, 0),
    pair(F(1, 6), 0.25, 0.15, -0.2, 0),
    pair(F(1, 6), 0.25, 0, 0.15, 1.2),
    pair(F(1, 6), 0.25, 0.1344, 0.2108, 0),
    pair(F(1, 2), 0.25, 0.07, 0, 0.48),
    pair(F(1, 2), 0.25, 0, 0.2108, -0.2688),
    pair(F(1, 6), 0.3, 0.3, 0, 0),
    pair(F(1, 6), 0.3, 0, 0.18, 1.44),
    pair(F(1, 2), 0.3, 0.1056, 0, 0.5616),
    pair(1, F(1, 3), F(1, 3), 0, 0),
)
#: What is wrong with a scenario, and how the sentence about it goes on.
FAULTS = {"": "", "closer": " are too close: their scaled distance is ", "outside": " is outside the flying space: "}


class View(NamedTuple):
    """How a scenario is looked at: axis n becomes axis `order[n]`, times `signs[n]`, and then all is moved."""

    order: tuple[int, ...]
    signs: tuple[int, ...]
    by: Vector

    def of(self, point: Point) -> Point:
        """Return the point as it is seen."""
        x, y, z = (sign * point[axis] + by for axis, sign, by in zip(self.order, self.signs, self.by, strict=True))
        return (x, y, z)


class Case(NamedTuple):
    """A pair, in a space whose walls are at the UAVs or not, with one of the :data:`FAULTS`, as it is seen."""

    pair: Pair
    tight: bool
    fault: str
    view: View

    @property
    def starts(self) -> tuple[Point, Point]:
        """Where the UAVs start."""
        way = list(self.pair.way)
        if self.fault == "closer":
            way[self._axis] -= NANO if way[self._axis] > 0 else -NANO
        x, y, z = way
        return self.view.of(at(0, 0, 0)), self.view.of((x, y, z))

    @property
    def box(self) -> ClosedBox:
        """The flying space."""
        low, high = [], []
        for to in self.pair.way:
            room = F(0) if self.tight and to else F(3, 4)
            low.append(min(to, F(0)) - room)
            high.append(max(to, F(0)) + room)
        axis, to = self._axis, self.pair.way[self._axis]
        if self.fault == "outside" and to > 0:
            high[axis] = to - NANO
        elif self.fault == "outside":
            low[axis] = to + NANO
        x, y, z = (sorted(sides) for sides in zip(self._seen(low), self._seen(high), strict=True))
        return ((x[0], x[1]), (y[0], y[1]), (z[0], z[1]))

    @property
    def theta(self) -> Vector:
        """The diagonal of Θ⁻¹."""
        x, y, z = (self.pair.theta[axis] for axis in self.view.order)
        return (x, y, z)

    @property
    def _axis(self) -> int:
        """The axis along which UAV 1 is furthest away, where the fault is."""
        return max(range(3), key=lambda axis: abs(self.pair.way[axis]))

    def _seen(self, corner: Iterable[Fraction]) -> Point:
        x, y, z = corner
        return self.view.of((x, y, z))

    def scenario(self, starts: tuple[Point, ...] | None = None) -> Scenario:
        """Return the scenario made of values; its targets are its starts."""
        theta_inverse = diagonal(self.theta)
        parameters = Parameters(theta_inverse=theta_inverse, d_hat_min=self.pair.d_hat_min, workspace=self.box)
        there = starts or self.starts
        return Scenario("pair", parameters, 15, Weights(), there, (TargetChange(0, there),), 30)

    def text(self) -> str:
        """Return the scenario as a file that somebody writes."""
        starts = [[_written(x) for x in point] for point in self.starts]
        box = [[_written(x) for x in sides] for sides in self.box]
        theta = [_written(x) for x in self.theta]
        return (
            f"name = 'pair'\nrounds = 30\n[parameters]\nworkspace = {_listed(box)}\n"
            f"d_hat_min = {_written(self.pair.d_hat_min)}\ntheta_inverse = [{', '.join(theta)}]\n"
            f"[start]\npositions = {_listed(starts)}\n[[targets]]\nround = 0\npositions = {_listed(starts)}\n"
        )


def _written(x: Fraction) -> str:
    """Return a number with its decimals, or as a fraction where these do not end."""
    if 10**9 % x.denominator:
        return f"'{x}'"
    digits = f"{abs(x.numerator) * (10**9 // x.denominator):010d}"
    return f"{'-' if x < 0 else ''}{digits[:-9]}.{digits[-9:]}"


def _listed(rows: list[list[str]]) -> str:
    return "[" + ", ".join(f"[{', '.join(row)}]" for row in rows) + "]"


def refusal(make: Callable[[], object]) -> str:
    """Return the sentence with which something is refused; empty if it is not."""
    try:
        make()
    except BadInput as refused:
        return str(refused)
    return ""


def is_right(said: str, fault: str) -> bool:
    """Say whether the sentence is about this fault; or about none, if there is none."""
    return FAULTS[fault] in said and bool(said) == bool(fault)


def wrong_places(scenario: Scenario) -> list[str]:
    """Return what is wrong about where the flight of `scenario` begins, by its own starts and walls, in fractions."""
    flight = setting(scenario).flight()
    state, unit = flight.initial(), flight.lattice.position_unit
    here = [
        [int(n) * unit + by for n, by in zip(state.followed(i).positions[0], flight.origin, strict=True)]
        for i in range(scenario.uavs)
    ]
    found = []
    space, parameters = scenario.parameters.workspace, scenario.parameters
    assert space is not None
    for point in here:
        if not all(low <= x <= high for x, (low, high) in zip(point, closed(space), strict=True)):
            found.append("outside")
    theta = [parameters.theta_inverse[axis][axis] for axis in range(3)]
    squared = sum(((a - b) * entry) ** 2 for a, b, entry in zip(*here, theta, strict=True))
    if squared < parameters.d_hat_min**2:
        found.append("closer")
    if any(
        abs(x - y) > unit
        for one, start in zip(here, scenario.starts, strict=True)
        for x, y in zip(one, start, strict=True)
    ):
        found.append("elsewhere")
    return found


SHIFTS = st.one_of(st.just(0), st.integers(-(10**15), 10**15), st.integers(-3000, 3000).map(lambda n: n * 10**8))
VIEWS = st.builds(
    View,
    st.permutations(range(3)).map(tuple),
    st.tuples(*[st.sampled_from([1, -1])] * 3),
    st.tuples(*[SHIFTS.map(lambda n: n * NANO)] * 3),
)
CASES = st.builds(Case, st.sampled_from(PAIRS), st.booleans(), st.sampled_from(list(FAULTS)), VIEWS)
GOOD = st.builds(Case, st.sampled_from(PAIRS[:-1]), st.booleans(), st.just(""), VIEWS)


def many(fault: str, pairs: Iterable[Pair] = PAIRS[:-1]) -> Iterator[Case]:
    """Yield cases for the planted faults: every pair and order, moved at random."""
    random = Random(0)
    for one, order, tight in product(pairs, permutations(range(3)), (True, False)):
        x, y, z = (random.randrange(-(10**15), 10**15) * NANO for _ in range(3))
        yield Case(one, tight, fault, View(order, tuple(random.choice([1, -1]) for _ in range(3)), (x, y, z)))


# Accepted or refused


@given(CASES)
@examples(150)
def test_a_scenario_is_decided_alike_anywhere(case: Case) -> None:
    """UAVs exactly d̂_min apart, and on walls, are accepted; a nanometre closer or beyond a wall, they are refused."""
    assert is_right(refusal(case.scenario), case.fault)


@given(CASES)
@examples(60)
def test_a_file_is_decided_alike_anywhere(tmp_path_factory: pytest.TempPathFactory, case: Case) -> None:
    """So it is where the numbers are read from a file: what is read is exactly what is written."""
    path = tmp_path_factory.getbasetemp() / "pair.toml"
    path.write_text(case.text())
    assert is_right(refusal(lambda: load(str(path))), case.fault)
    if not case.fault:
        assert load(str(path)).starts == case.starts
        assert load(str(path)).parameters == case.scenario().parameters


def test_floats_before_the_decision_are_noticed() -> None:
    """If points were floats before they are compared, good cases would be refused for either reason."""

    def rounded(point: Point) -> Point:
        x, y, z = (F(float(value)) for value in point)
        return (x, y, z)

    said = {refusal(partial(case.scenario, tuple(map(rounded, case.starts)))) for case in many("")}
    assert {refusal(case.scenario) for case in many("")} == {""}
    assert all(any(fault in one for one in said) for fault in FAULTS.values())


# On the lattice


@given(GOOD)
@examples(80)
def test_starts_are_exact_on_the_lattice(case: Case) -> None:
    """Where the flight begins, UAVs are within the walls and d̂_min apart, exactly, and where they were to be."""
    assert wrong_places(case.scenario()) == []


def test_rounding_to_the_nearest_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """If starts were just rounded to the nearest lattice points, UAVs would come closer than d̂_min, or cross a wall."""
    cases = list(many(""))[::4]
    monkeypatch.setattr(Lattice, "holding", lambda self, starts: self)
    assert {wrong for case in cases for wrong in wrong_places(case.scenario())} == {"closer"}
    monkeypatch.setattr(Lattice, "hovers", Lattice.positions)
    assert {wrong for case in cases for wrong in wrong_places(case.scenario())} == {"closer", "outside"}


def test_thirds_cannot_be_placed_or_are_exact() -> None:
    """UAVs a third of a metre apart are placed exactly, too, or refused in a sentence about their digits."""
    placed = 0
    for case in many("", PAIRS[-1:]):
        said = refusal(setting(case.scenario()).flight)
        assert not said or "write the starts with at most 9 decimals" in said
        placed += not said and not wrong_places(case.scenario())
    assert placed > 0


# What cannot be flown


def far_apart(rounds: int, *changes: str, starts: tuple[Point, ...] = points((-10, 0, 1), (10, 0.1, 1))) -> Scenario:
    """Return a pair 20 m apart in a large space, or others; each wants to where another starts."""
    parameters = Parameters().with_changes(changes)
    return Scenario("far", parameters, 15, Weights(), starts, (TargetChange(0, starts[::-1]),), rounds)


def test_a_clipped_flight_is_as_long_as_its_scenario() -> None:
    """In a space that is too large for the lattice, more rounds than the scenario's are refused before the first."""
    what = setting(far_apart(8, "workspace=-1e6,1e6,-1e6,1e6,0,1e6"))
    flight = what.flight()
    assert place(what.scenario).clipped
    assert len(list(flight.rounds(flight.initial(), parse("none", 2, 2, 0), 8))) == 8
    with pytest.raises(ValueError, match=r"^9 rounds are more than the scenario's 8$"):
        fly(what, parse("none", 2, 2, 0), 9)


def test_a_flight_that_is_not_clipped_may_be_longer() -> None:
    """Where the whole space is on the lattice, a flight goes on as long as one wants."""
    what = setting(far_apart(8, "workspace=-20,20,-20,20,0,20"))
    assert not place(what.scenario).clipped
    assert fly(what, parse("none", 2, 2, 0), 12)[0].rounds == 12


def test_the_region_holds_all_that_can_be_reached() -> None:
    """A clipped space holds whatever speed and time allow, and the longer the flight the more, up to the walls."""
    widths = []
    for rounds in (10, 100, 1000):
        where = place(far_apart(rounds, "workspace=-1e6,1e6,-1e6,1e6,0,1e6"))
        (low, high), _, (floor, _) = where.lattice.bounds.space
        given_ = where.scenario.parameters
        reach = given_.v_max[0] * given_.T_s * (rounds + where.scenario.horizon)
        assert low <= -10 - where.origin[0] - reach
        assert high >= 10 - where.origin[0] + reach
        assert floor >= -where.origin[2]
        widths.append(high - low)
    assert widths[0] < widths[1] < widths[2]
    assert COARSEST <= where.lattice.jerk_unit.denominator.bit_length() - 1 < FINEST


def test_too_large_a_flight_is_refused_before_it_begins() -> None:
    """A space and rounds, or digits, that no lattice holds are refused in one sentence when the flight is made."""
    large = "workspace=-1e7,1e7,-1e7,1e7,0,1e7"
    assert not refusal(setting(far_apart(50, large)).flight)
    said = refusal(setting(far_apart(100_000, large, "v_max=1000", "a_max=1000", "j_max=10000")).flight)
    assert said.startswith("the flying space, the bounds or the digits of theta_inverse are too large for exact")
    assert "fewer rounds" in said
    near = points((NANO, 0, 1), (0.1344000010000001, 0.2108, 1))
    touching = Scenario("near", load("crossing").parameters, 15, Weights(), near, (TargetChange(0, near),), 5)
    fractions = [at(i, F(1, 10**6 + 2 * i + 1), F(i, 997 + i)) for i in range(1, 62)]
    crowd = far_apart(5, "workspace=-100,100,-100,100,-100,100", starts=(*near, *fractions))
    for one in (touching, crowd):
        said = refusal(setting(one).flight)
        assert "write the starts with at most 9 decimals, such as 0.25" in said
        assert "\n" not in said
