"""What is measured of a flight: compared with `swarmproof fly`, and with all of it counted again from the rounds."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields, replace
from fractions import Fraction
from functools import cache
from itertools import combinations
from math import dist, sqrt
from typing import Any

import numpy as np
import pytest

from swarmproof.campaign.trial import Cell
from swarmproof.claims.verdict import Verdict
from swarmproof.cli import main
from swarmproof.dmpc_swarm.experiments import measure as module
from swarmproof.dmpc_swarm.experiments.measure import RADII, REACHED, Leg, Measured, measure
from swarmproof.dmpc_swarm.flight import run
from swarmproof.dmpc_swarm.flight.judge import Flown
from swarmproof.dmpc_swarm.flight.state import Round
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.dmpc_swarm.protocol.messages import TrajectoryMessage

#: Loss, and targets that are not reached.
SHORT = Cell("crossing", 2, "HT", "iid:0.1", "guarded", 0, 15)
#: Targets that are reached, while claims are violated.
IGNORING = Cell("crossing", 2, "HT", "iid:0.3", "ignore-loss", 0, 60)
#: All come to rest, and stay there.
HALTS = Cell("circle", 3, "HT", "jam:3,1000", "guarded", 1, 40, ("jitter=0.02", "uavs=5"))
#: All come to rest, and move again.
GOES_ON = Cell("crossing", 2, "HT", "jam:3,25", "guarded", 0, 60)
#: Two targets, both reached.
TWO_LEGS = Cell("random", 2, "HT", "iid:0.05", "guarded", 3, 80, ("uavs=4", "hold=40"), series=True)
#: Four targets, the last for a shorter time; 16 UAVs.
FOUR_LEGS = Cell("formations", 3, "DT", "none", "guarded", 3, 75, ("jitter=0.02", "hold=20"), series=True)
#: Two UAVs collide.
COLLIDES = Cell("circle", 3, "HT", "jam:3,10", "ignore-loss", 1, 40, ("jitter=0.02",))
CELLS = {
    "short": SHORT,
    "ignoring": IGNORING,
    "halts": HALTS,
    "goes on": GOES_ON,
    "two legs": TWO_LEGS,
    "four legs": FOUR_LEGS,
    "collides": COLLIDES,
}
every = pytest.mark.parametrize("cell", CELLS.values(), ids=list(CELLS))

#: Each cell is measured once for all tests.
measured = cache(measure)


@cache
def rounds_of(cell: Cell) -> list[Round]:
    """Return the rounds of the cell's flight, flown without anybody watching."""
    setting = cell.setting()
    flight = setting.flight()
    return list(flight.rounds(flight.initial(), cell.losses(setting.scenario.uavs), cell.rounds))


def moves(flown: Round) -> bool:
    """Say whether a UAV is not at the same place, exactly, at all samples of a round and at its end."""
    for i in range(len(flown.before.swarm.uavs)):
        plan, k = flown.before.followed(i), flown.before.k
        steps = plan.lattice.steps
        places = {tuple(plan.position((k - plan.start) * steps + h)) for h in range(steps + 1)}
        if len(places) > 1:
            return True
    return False


def distances(cell: Cell, flown: Round) -> list[float]:
    """Return how far each UAV is at the end of a round from the target that it had in it, in m."""
    scenario, after = cell.setting().scenario, flown.after
    found = []
    for i, target in enumerate(scenario.targets_at(flown.before.k)):
        plan = after.followed(i)
        unit = plan.lattice.position_unit
        place = plan.position((after.k - plan.start) * plan.lattice.steps)
        found.append(dist([float(Fraction(x) * unit) for x in place], target))
    return found


def first(rows: list[bool]) -> int | None:
    """Return in how many rounds something was so for the first time."""
    return rows.index(True) + 1 if True in rows else None


def legs_of(cell: Cell) -> list[tuple[int, list[list[float]]]]:
    """Return for each change of the targets its round, and the distances to them in m until the next one."""
    scenario = cell.setting().scenario
    begins = [k for k in range(cell.rounds) if k == 0 or scenario.targets_at(k) != scenario.targets_at(k - 1)]
    rows = [distances(cell, flown) for flown in rounds_of(cell)]
    return [(begin, rows[begin:end]) for begin, end in zip(begins, [*begins[1:], cell.rounds], strict=True)]


# The same numbers, found in other ways


@every
def test_numbers_are_those_of_fly(cell: Cell, capsys: pytest.CaptureFixture[str]) -> None:
    """`swarmproof fly` with the cell's words writes the numbers that are measured, to the bit, and says the rest."""
    ours = measured(cell)
    code = main(["fly", *cell.words, "--json", "-"])
    captured = capsys.readouterr()
    document, said = json.loads(captured.out), " ".join(captured.err.split())
    assert code == bool(ours.violated)
    assert document["rounds"] == ours.rounds == cell.rounds
    assert document["min_separation"] == {"sampled": ours.sampled, "continuous_lower": ours.lower}
    assert document["qps"] == {"solved": ours.solved, "rejected": ours.rejected, "infeasible": ours.infeasible}
    violated = {claim["id"] for claim in document["claims"] if claim["verdict"] == "violated"}
    assert set(ours.violated) == violated
    assert len(ours.violated) == len(violated)
    assert document["rounds_to_arrival"] == ours.legs[-1].all_within[RADII.index(REACHED)]
    (first_uav, second), time = ours.closest, ours.closest_time
    assert f"(UAVs {first_uav} and {second}, {time:.2f} s)" in said
    assert f"{ours.lost} messages lost." in said


@every
def test_counts_are_those_of_the_rounds(cell: Cell) -> None:
    """Messages, plans and adoptions, counted from the rounds by what is lost, sent, held, and followed."""
    ours, rounds = measured(cell), rounds_of(cell)
    lost = all_plan = all_run = adopted = sent = 0
    last_adopted = None
    for flown in rounds:
        for got in (*flown.at_cus, *flown.at_uavs):
            lost += len(got.lost_uavs) + len(got.lost_slots)
        running = [cu.state is CuState.RUN_DMPC for cu in flown.before.swarm.cus]
        # a CU that has planned transmits a trajectory with the round's number
        plans = [
            isinstance(slot.cu_message, TrajectoryMessage)
            and slot.cu_message.trajectory.metadata.round == flown.before.k
            for slot in flown.computed.air.slots
        ]
        sent += sum(plans)
        all_plan += sum(plans) == cell.cus
        all_run += sum(running) == cell.cus
        for old, new in zip(flown.before.swarm.uavs, flown.after.swarm.uavs, strict=True):
            if old.followed.metadata != new.followed.metadata:
                adopted, last_adopted = adopted + 1, flown.before.k + 1
    assert (ours.lost, ours.solved) == (lost, sent)
    assert (ours.all_plan, ours.all_run) == (all_plan, all_run)
    assert (ours.adopted, ours.last_adopted) == (adopted, last_adopted)


@every
def test_the_sampled_separation_is_that_of_the_rounds(cell: Cell) -> None:
    """The smallest scaled distance at multiples of T_c, exactly; with certainty it is never closer than `lower`."""
    ours, smallest, inner = measured(cell), None, None
    for flown in rounds_of(cell):
        plans = [flown.before.followed(i) for i in range(len(flown.before.swarm.uavs))]
        lattice, k = plans[0].lattice, flown.before.k
        for h in range(lattice.steps):
            # halves of a step as well: they are between samples
            for step in (h, h + 0.5):
                places = [
                    [int(x) for x in lattice.pairs.first @ plan.position((k - plan.start) * lattice.steps + step)]
                    for plan in plans
                ]
                square = min(sum((x - y) ** 2 for x, y in zip(*pair, strict=True)) for pair in combinations(places, 2))
                inner = square if inner is None else min(inner, square)
                if step == h:
                    smallest = square if smallest is None else min(smallest, square)
    assert smallest is not None
    assert inner is not None
    unit = Fraction(lattice.pairs.unit)
    assert ours.sampled == sqrt(smallest * unit**2)
    # rounding to whole units of half steps, some 1e-12 m, is far below what a micrometre is
    assert ours.lower <= sqrt(inner * unit**2) + 1e-6
    assert ours.lower <= ours.sampled


@every
def test_rest_is_exact(cell: Cell) -> None:
    """The swarm rests from the first round on in which, and in all later ones, no UAV changes its place."""
    moving = [moves(flown) for flown in rounds_of(cell)]
    last = max((k for k, moved in enumerate(moving) if moved), default=-1)
    assert measured(cell).rest_from == (last + 1 if last + 1 < cell.rounds else None)


def test_rest_is_seen_and_lost_again() -> None:
    """One of these flights comes to rest for good, and another only until its jam is over."""
    assert measured(HALTS).rest_from is not None
    moving = [moves(flown) for flown in rounds_of(GOES_ON)]
    assert False in moving
    assert moving.index(False) < 28 < len(moving) - 1 - moving[::-1].index(True)
    assert measured(GOES_ON).rest_from is None


def test_a_uav_that_begins_to_move_does_not_rest() -> None:
    """In the round in which it begins, its velocity and acceleration are still zero; the round before, all rested."""
    moving = [moves(flown) for flown in rounds_of(GOES_ON)]
    rests = moving.index(False)
    begins = moving.index(True, rests)
    plans = [rounds_of(GOES_ON)[begins].before.followed(i).state_at(begins) for i in range(2)]
    assert not any(state[1:].any() for state in plans)
    assert measured(replace(GOES_ON, rounds=begins)).rest_from == rests
    assert measured(replace(GOES_ON, rounds=begins + 1)).rest_from is None


@every
def test_arrivals_are_those_of_the_rounds(cell: Cell) -> None:
    """From each change of the targets on: when all were within each radius at once, and when each UAV was at first."""
    ours, expected = measured(cell), legs_of(cell)
    assert [(leg.begin, leg.rounds) for leg in ours.legs] == [(begin, len(rows)) for begin, rows in expected]
    for leg, (_, rows) in zip(ours.legs, expected, strict=True):
        assert leg.all_within == tuple(first([max(row) <= radius for row in rows]) for radius in RADII)
        assert leg.reached == tuple(
            tuple(first([row[i] <= radius for row in rows]) for i in range(len(rows[0]))) for radius in RADII
        )


def test_arrivals_differ_by_radius_and_by_uav() -> None:
    """These flights have what the test before needs: several legs, arrivals and none, one after the other."""
    legs = measured(TWO_LEGS).legs
    assert [leg.begin for leg in legs] == [0, 40]
    assert [len(set(leg.all_within)) for leg in legs] == [4, 3]
    assert all(len(set(leg.reached)) > 1 and len(set(leg.reached[1])) > 1 for leg in legs)
    assert [(leg.begin, leg.rounds) for leg in measured(FOUR_LEGS).legs] == [(0, 20), (20, 20), (40, 20), (60, 15)]
    assert measured(SHORT).legs[0].all_within == (None,) * len(RADII)


def test_the_radii() -> None:
    """They grow, and the one that counts is among them: 5 cm, as for `swarmproof fly`."""
    assert list(RADII) == sorted(set(RADII))
    assert REACHED in RADII
    assert REACHED == 0.05


def test_a_radius_is_reached_at_the_radius() -> None:
    """Exactly so far is reached, a little further is not; the first round counts as one."""
    leg = module._leg(np.array([[0.3, 0.05], [0.06, 0.2], [0.05, 0.02]]), 7, False)
    assert (leg.begin, leg.rounds) == (7, 3)
    assert leg.all_within == (None, 3, 3, 2)
    assert leg.reached == ((None, 3), (3, 1), (2, 1), (2, 1))


# Series


@pytest.mark.parametrize("cell", [TWO_LEGS, FOUR_LEGS, replace(SHORT, series=True)], ids=["two", "four", "one"])
def test_series_are_the_distances(cell: Cell) -> None:
    """Kept, the largest, mean and smallest distance of every round are those of the rounds."""
    for leg, (_, rows) in zip(measured(cell).legs, legs_of(cell), strict=True):
        assert leg.largest == pytest.approx([max(row) for row in rows], rel=1e-9)
        assert leg.mean == pytest.approx([sum(row) / len(row) for row in rows], rel=1e-9)
        assert leg.smallest == pytest.approx([min(row) for row in rows], rel=1e-9)


@pytest.mark.parametrize("cell", [TWO_LEGS, SHORT], ids=["random", "crossing"])
def test_series_change_no_other_number(cell: Cell) -> None:
    """Without them, they are empty, and everything else is the same."""
    kept, bare = measured(replace(cell, series=True)), measured(replace(cell, series=False))
    assert all(leg.largest and leg.mean and leg.smallest for leg in kept.legs)
    assert all((leg.largest, leg.mean, leg.smallest) == ((), (), ()) for leg in bare.legs)
    without = tuple(replace(leg, largest=(), mean=(), smallest=()) for leg in kept.legs)
    assert replace(kept, legs=without) == bare


# JSON


@every
def test_json_is_lossless(cell: Cell) -> None:
    """Written and read, it is the same to the bit, with the same types all through."""
    ours = measured(cell)
    back = Measured.from_json(json.loads(json.dumps(ours.as_json(), allow_nan=False)))
    assert back == ours
    assert repr(back) == repr(ours)


@every
def test_numbers_are_pythons(cell: Cell) -> None:
    """Nothing of numpy is left, whose numbers say more than their value."""
    assert "np." not in repr(measured(cell))
    for number in (measured(cell).sampled, measured(cell).lower, measured(cell).closest_time):
        assert type(number) is float


@pytest.mark.parametrize("name", [one.name for one in (*fields(Measured), *fields(Leg))])
def test_json_without_a_number_is_nothing(name: str) -> None:
    """If one is missing it is no result, except that a leg's series may be."""
    table = measured(SHORT).as_json()
    part = table if name in table else table["legs"][0]
    del part[name]
    if name in ("largest", "mean", "smallest"):
        assert Measured.from_json(table) == measured(SHORT)
        return
    with pytest.raises((KeyError, TypeError)):
        Measured.from_json(table)


# The same again


@pytest.mark.parametrize("cell", [SHORT, TWO_LEGS, COLLIDES], ids=["short", "two legs", "collides"])
def test_measured_again_it_is_the_same(cell: Cell) -> None:
    """To the bit, in the same process."""
    assert repr(measure(cell)) == repr(measured(cell))


def test_another_process_measures_the_same() -> None:
    """To the bit, in a process with another order of sets, and after other flights."""
    code = (
        "import sys, json\n"
        "from swarmproof.campaign.trial import Cell\n"
        "from swarmproof.dmpc_swarm.experiments.measure import measure\n"
        "for cell in (Cell('crossing', 1, 'RR', 'none', 'printed', 5, 4), *eval(sys.argv[1])):\n"
        "    print(json.dumps(measure(cell).as_json()))\n"
    )
    cells = [SHORT, TWO_LEGS, FOUR_LEGS, COLLIDES]
    done = subprocess.run(
        [sys.executable, "-c", code, repr(cells)],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "4321", "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
    _, *lines = done.stdout.splitlines()
    for cell, line in zip(cells, lines, strict=True):
        assert repr(Measured.from_json(json.loads(line))) == repr(measured(cell))


def test_seeds_and_options_matter() -> None:
    """Another seed, trigger or preset is another flight."""
    flights = [
        TWO_LEGS,
        replace(TWO_LEGS, seed=4),
        replace(TWO_LEGS, trigger="RR"),
        replace(TWO_LEGS, cus=3),
        replace(TWO_LEGS, loss="iid:0.3"),
    ]
    assert len({measured(cell).sampled for cell in flights} | {measured(cell).lower for cell in flights}) >= 5
    assert len({repr(measured(cell)) for cell in flights}) == len(flights)


# Collisions


def test_a_collision_is_one_with_certainty() -> None:
    """Samples alone decide some flights: closer than d_min collides; a certified bound decides that others do not."""
    assert measured(COLLIDES).collides is True
    assert measured(COLLIDES).sampled < 0.12
    for cell in CELLS.values():
        if cell is not COLLIDES:
            assert measured(cell).collides is False
            assert measured(cell).lower > 0.12


def told(flown: Flown, lower: float, violated: bool) -> Flown:
    """Return a flight with this bound, in which the claim that UAVs keep d_min is violated or not."""
    verdict = Verdict.VIOLATED if violated else Verdict.NOT_VIOLATED
    claims = tuple(replace(one, verdict=verdict) if one.claim.id == "eq-2" else one for one in flown.claims)
    assert any(one.claim.id == "eq-2" for one in claims)
    return replace(flown, continuous_lower=lower, claims=claims)


@pytest.mark.parametrize(
    ("lower", "violated", "collides"),
    [
        (0.25, False, False),
        # the float 0.12 is a little less than 12 cm, the next one more
        (0.12, False, None),
        (0.12 + 2**-56, False, False),
        (0.05, False, None),
        (0.0, False, None),
        (0.119, True, True),
    ],
)
def test_what_is_not_certain_is_not_decided(
    lower: float, violated: bool, collides: bool | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bound below d_min is no collision yet, and one at least d_min is none: that is compared exactly."""
    assert Fraction(0.12) < Fraction(12, 100) < Fraction(0.12 + 2**-56)
    real = run.fly

    def fly(*arguments: Any) -> tuple[Flown, float]:
        flown, seconds = real(*arguments)
        return told(flown, lower, violated), seconds

    monkeypatch.setattr(module, "fly", fly)
    ours = measure(SHORT)
    assert ours.collides is collides
    assert ours.lower == lower
    assert ("eq-2" in ours.violated) is violated


# Interrupts


def interrupting(at: int, before: bool) -> Callable[..., tuple[Flown, float]]:
    """Return a `fly` that is interrupted in the round before round `at`, before that round is looked at, or after."""
    real = run.fly

    def fly(setting: Any, losses: Any, rounds: int, watch: Callable[[Round], None], flight: Any) -> Any:
        def look(flown: Round) -> None:
            if before and flown.after.k == at:
                raise KeyboardInterrupt
            watch(flown)
            if flown.after.k == at:
                raise KeyboardInterrupt

        return real(setting, losses, rounds, look, flight)

    return fly


@pytest.mark.parametrize("before", [True, False])
@pytest.mark.parametrize("at", [1, 7, 14])
def test_a_part_of_a_flight_is_no_result(at: int, before: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Interrupted after one round, or before the last one, nothing is measured."""
    monkeypatch.setattr(module, "fly", interrupting(at, before))
    with pytest.raises(KeyboardInterrupt):
        measure(SHORT)


def test_an_interrupt_after_everything_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """If all rounds were looked at, the result is whole."""
    monkeypatch.setattr(module, "fly", interrupting(15, False))
    assert measure(SHORT) == measured(SHORT)


def test_no_claim_is_forgotten() -> None:
    """What is violated is named by the ids of claims, in order, so that equal results are equal."""
    violated = measured(IGNORING).violated
    assert "theorem-2" in violated
    assert list(violated) == sorted(violated)
    assert all(re.fullmatch(r"[a-z0-9-]+", name) for name in violated)
