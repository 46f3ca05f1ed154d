"""A flight depends neither on the origin, nor on bounds that never bind, nor on numbers that are as good as 0."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from tests.dmpc_swarm.flight.settings import setting
from tests.scenario.points import Coordinate, at

from swarmproof.dmpc_swarm.flight.judge import Counts
from swarmproof.dmpc_swarm.flight.log import Log
from swarmproof.dmpc_swarm.flight.place import place
from swarmproof.dmpc_swarm.flight.run import fly
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import Bounds, Floats
from swarmproof.scenario.points import moved_points
from swarmproof.scenario.scenario import Scenario, load
from swarmproof.theorem3.values import Vector

F = Fraction
#: m, of separations and positions: finer than anything that is printed.
SAME = 1e-6
#: By scenario, rounds and changes: few UAVs that arrive soon, as flights are chaotic in the long run.
FLIGHTS: dict[str, tuple[int, tuple[str, ...]]] = {"crossing": (40, ()), "circle": (60, ("uavs=4",))}
#: m; the origin of the shipped scenarios' spaces is a multiple of this in x, y and z.
STEP = 16
NOWHERE = at(0, 0, 0)


class Sight(NamedTuple):
    """What is seen of a flight.

    Attributes:
        motion: of all rounds: positions (from the flight's own origin), velocities, accelerations and jerks, as bytes.
        positions: in m, shape (rounds · 2 + 1, N, 3).
    """

    motion: bytes
    positions: Floats
    separation: float
    arrival: int | None
    counts: Counts
    violated: bool


def sight(scenario: Scenario, rounds: int) -> Sight:
    """Fly a scenario."""
    what = setting(scenario)
    flight = what.flight()
    log = Log(flight)
    result, _ = fly(what, parse("iid:0.1", scenario.uavs, what.cus, 0), rounds, log.see, flight)
    motion = b"".join(logged.motion.tobytes() for logged in log.rounds)
    return Sight(
        motion,
        log.positions(2),
        result.continuous_lower,
        result.rounds_to_arrival,
        result.qps,
        result.violated,
    )


@cache
def flown(name: str, *changes: str, by: Vector = NOWHERE) -> Sight:
    """Fly one of the :data:`FLIGHTS` with further changes, moved."""
    rounds, usual = FLIGHTS[name]
    return sight(load(name, 0, [*usual, *changes]).moved(by), rounds)


def differences(one: Sight, other: Sight, by: Vector = NOWHERE) -> list[str]:
    """Return in what the flight `other`, moved `by` so much (m), differs from `one` within what is printed."""
    found = []
    if abs(one.separation - other.separation) > SAME:
        found.append("separation")
    if one.arrival != other.arrival:
        found.append("arrival")
    if one.counts != other.counts:
        found.append("programs")
    if one.violated or other.violated or one.counts.rejected or other.counts.rejected:
        found.append("violated or rejected")
    if np.abs(other.positions - np.array(by, float) - one.positions).max() > SAME:
        found.append("positions")
    return found


# The origin


@pytest.mark.parametrize("name", FLIGHTS)
@pytest.mark.parametrize(
    "by",
    [
        (1000, 1000, 1000),
        (10_000.1, -0.3, 0.7),
        (500_000.123456789, 900_000.987654321, 123.4),
        (1e6, F(-(10**6)) - F(1, 10), 1e6),
    ],
)
def test_a_flight_does_not_depend_on_the_origin(name: str, by: tuple[Coordinate, Coordinate, Coordinate]) -> None:
    """A scenario 0 … 1,000 km from the origin flies alike within a micrometre, and positions are where it is."""
    assert differences(flown(name), flown(name, by=at(*by)), at(*by)) == []
    assert flown(name).arrival is not None


@pytest.mark.parametrize("by", [(1, 0, 0), (-2, 3, 1), (31_250, -62_500, 12_345)])
def test_a_move_by_whole_steps_changes_no_bit(by: tuple[int, int, int]) -> None:
    """Moved by a multiple of the origin's step, a flight has the same jerks to the last bit."""
    far = at(*(STEP * n for n in by))
    assert place(load("crossing").moved(far)).origin == far
    assert flown("crossing", by=far).motion == flown("crossing").motion


def test_the_test_above_can_tell_bits() -> None:
    """Moved by less than a step, the last bits are others: the same bits are no matter of course."""
    assert flown("crossing", by=at(0.1, 0, 0)).motion != flown("crossing").motion


def test_coordinates_as_they_are_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """If coordinates were not counted from near the space, the lattice would be coarser far away."""
    far = load("crossing").moved(at(500_000, 900_000, 0))
    near = setting(far).flight().lattice
    monkeypatch.setattr("swarmproof.dmpc_swarm.flight.place._origin", lambda sides: F(0))
    assert setting(far).flight().lattice.jerk_unit > near.jerk_unit == setting("crossing").flight().lattice.jerk_unit


def test_people_see_their_own_coordinates() -> None:
    """Targets, walls and starts of a moved flight are those that the user wrote, exactly."""
    written = load("formations").moved(at(500_000.123456789, 900_000.1, -0.7))
    flight = setting(written).flight()
    assert any(flight.origin)
    assert flight.original == written


def test_random_targets_move_with_the_space() -> None:
    """Targets that are drawn anew are the same ones, moved."""
    by = at(500_000, -900_000, 128)
    here, there = load("random"), load("random").moved(by)
    assert all(there.targets_at(k) == moved_points(here.targets_at(k), by) for k in (0, 75, 750))


# Bounds that never bind

#: Larger and larger bounds, of which none can bind.
LOOSE = {
    "v_max": ("v_max=1e3", "v_max=1e5", "v_max=1e9"),
    "a_max": ("a_max=1e3", "a_max=1e6", "a_max=1e9"),
    "j_max": ("j_max=1e3", "j_max=1e6", "j_max=1e9"),
    "workspace": (
        "workspace=-1e3,1e3,-1e3,1e3,-1e3,1e3",
        "workspace=-1e6,1e6,-1e5,1e5,-1e4,1e7",
        "workspace=-1e7,1e7,-1e7,1e7,-1e7,1e7",
        "workspace=-inf,inf,-inf,inf,-inf,inf",
    ),
}


@pytest.mark.parametrize("loose", LOOSE.values(), ids=LOOSE)
def test_a_bound_that_never_binds_changes_no_bit(loose: tuple[str, ...]) -> None:
    """Of bounds that cannot bind, all give the same flight, to the last bit."""
    first = flown("crossing", loose[0])
    assert differences(first, first) == []
    assert {flown("crossing", change).motion for change in loose} == {first.motion}


def test_a_bound_that_binds_changes_the_flight() -> None:
    """The test above would not pass for bounds that matter."""
    assert flown("crossing", "v_max=0.5").motion != flown("crossing", "v_max=1e3").motion
    assert flown("crossing", "j_max=2").motion != flown("crossing", "j_max=1e3").motion


def test_bounds_as_they_are_given_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """If bounds were not replaced by what they imply together, the lattice would depend on them."""
    units = {setting(load("crossing", 0, [change])).flight().lattice.jerk_unit for change in LOOSE["v_max"]}
    assert len(units) == 1
    monkeypatch.setattr("swarmproof.dmpc_swarm.flight.place.implied", lambda parameters, horizon: Bounds.of(parameters))
    coarse = {setting(load("crossing", 0, [change])).flight().lattice.jerk_unit for change in LOOSE["v_max"][:2]}
    assert max(coarse) > max(units)


# The horizon


@pytest.mark.parametrize("horizon", [5, 15, 30, 60])
def test_a_long_horizon_rejects_nothing(horizon: int) -> None:
    """Whatever the horizon, and with loose bounds, no claim is violated and no answer is rejected."""
    for loose in ((), ("v_max=1e6", "workspace=-1e5,1e5,-1e5,1e5,0,1e5")):
        seen = flown("crossing", f"horizon={horizon}", *loose)
        assert not seen.violated
        assert seen.counts.solved > 20
        assert seen.counts.rejected == 0


# Numbers that are as good as 0


def test_noise_in_coordinates_is_as_good_as_zero(tmp_path: Path) -> None:
    """Coordinates such as 1e-16, which cos and sin leave, are read, and fly like 0."""
    text = (
        "name = 'noise'\nrounds = 40\n[parameters]\nworkspace = [[-1.7, 1.7], [-1.7, 1.7], [0.4, 3]]\n"
        "[start]\npositions = [[-0.6, {0}, 1], [{1}, 0.6, 1], [0.6, {0}, 1.2]]\n"
        "[[targets]]\nround = 0\npositions = [[0.6, {1}, 1], [{1}, -0.6, 1], [-0.6, {0}, 1.2]]\n"
    )
    noisy, clean = tmp_path / "noisy.toml", tmp_path / "clean.toml"
    noisy.write_text(text.format("1.2246467991473532e-16", "-1e-17"))
    clean.write_text(text.format("0", "0"))
    one, other = (load(str(path)) for path in (noisy, clean))
    assert one.starts[0][1] == F("1.2246467991473532e-16")
    assert differences(sight(one, 40), sight(other, 40)) == []
