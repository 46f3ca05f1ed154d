"""The experiments: which flights they have, what each variant changes, and what is observed of a flight."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import product

import pytest

from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import Observation
from swarmproof.dmpc_swarm.claims.experiments import (
    EXPERIMENT_CLAIMS,
    FOR_EVER,
    FORMATIONS,
    IGNORING,
    MLR,
    PERIOD_S,
    PRINTED,
)
from swarmproof.dmpc_swarm.experiments.experiment import AS_CHOSEN, JITTER, METHODS, Experiment, Variant, seconds
from swarmproof.dmpc_swarm.experiments.experiments import EXPERIMENTS
from swarmproof.dmpc_swarm.experiments.measure import RADII, REACHED, Leg, Measured
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.semantics import PRESETS, Semantics
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.faults.losses import Iid, Jam
from swarmproof.motion.lattice import Lattice

NAMES = list(EXPERIMENTS)
both = pytest.mark.parametrize("quick", [False, True], ids=["full", "quick"])
each = pytest.mark.parametrize("name", NAMES)
#: The variants of the full experiments, but those as chosen.
CHANGED = [(name, variant.name) for name in NAMES for variant in EXPERIMENTS[name](False).variants[1:]]
changed = pytest.mark.parametrize(("name", "change"), CHANGED, ids=[f"{one}, {other}" for one, other in CHANGED])


@cache
def planned(name: str, quick: bool = False) -> Experiment:
    """Return the experiment of this name."""
    return EXPERIMENTS[name](quick)


def variant_of(name: str, change: str) -> Variant:
    """Return the variant of this name of a full experiment."""
    (found,) = (variant for variant in planned(name).variants if variant.name == change)
    return found


def chosen(name: str, quick: bool = False) -> tuple[Cell, ...]:
    """Return the flights as chosen."""
    return planned(name, quick).variants[0].cells


def seeds_of(cells: Iterable[Cell]) -> set[int]:
    """Return the seeds of these flights."""
    return {cell.seed for cell in cells}


@cache
def _setting(cell: Cell) -> Setting:
    return cell.setting()


def setting_of(cell: Cell) -> Setting:
    """Return what determines a flight but what is lost."""
    return _setting(replace(cell, loss="none", rounds=1, series=False))


def jam(cell: Cell) -> tuple[int, int]:
    """Return when a jam begins, and how long it lasts, in rounds."""
    start, length = cell.loss.removeprefix("jam:").split(",")
    return int(start), int(length)


# What is flown


def test_the_experiments_are_those_of_the_claims() -> None:
    """Each experiment has claims, each claim an experiment, and each goes by its name."""
    assert set(NAMES) == {claim.experiment for claim in EXPERIMENT_CLAIMS} == {"fig3b", "fig3c", "fig4", "loss"}
    for name, quick in product(NAMES, (True, False)):
        assert planned(name, quick).name == name
        assert planned(name, quick).title
        assert planned(name, quick).about


def test_fig3b_has_one_to_three_cus() -> None:
    """HT with 1, 2 and 3 CUs, each with the same seeds, at least twenty, through all formations without loss."""
    cells = chosen("fig3b")
    seeds = seeds_of(cells)
    assert len(seeds) >= 20
    assert sorted((cell.cus, cell.trigger, cell.seed) for cell in cells) == sorted(product((1, 2, 3), ("HT",), seeds))
    assert {(cell.scenario, cell.loss, cell.preset) for cell in cells} == {("formations", "none", "guarded")}


def test_fig3c_has_the_three_triggers() -> None:
    """RR, DT and HT with three CUs, of which the claims speak, and with two, each with the same seeds."""
    cells = chosen("fig3c")
    seeds = seeds_of(cells)
    assert len(seeds) >= 20
    assert sorted((cell.cus, cell.trigger, cell.seed) for cell in cells) == sorted(
        product((2, 3), ("RR", "DT", "HT"), seeds)
    )
    assert {(cell.scenario, cell.loss, cell.preset) for cell in cells} == {("formations", "none", "guarded")}


def test_fig3_flies_through_all_formations() -> None:
    """16 UAVs; the targets change at the beginning and three times more, and all formations have the same time."""
    for name, quick in product(("fig3b", "fig3c"), (True, False)):
        (cell, *_) = chosen(name, quick)
        scenario = setting_of(cell).scenario
        assert scenario.uavs == 16
        changes = [k for k in range(cell.rounds) if k == 0 or scenario.targets_at(k) != scenario.targets_at(k - 1)]
        hold = cell.rounds // len(FORMATIONS)
        assert changes == [hold * number for number in range(len(FORMATIONS))]
        assert cell.rounds == hold * len(FORMATIONS)
        assert all(one.rounds == cell.rounds for one in chosen(name, quick))


def test_fig3b_and_fig3c_share_flights() -> None:
    """Two and three CUs with HT are flown once for both."""
    assert len(set(chosen("fig3b")) & set(chosen("fig3c"))) == 2 * len(seeds_of(chosen("fig3b")))


def test_fig4_has_every_start_length_method_and_seed() -> None:
    """Jams from each round 0 to 25 on, of 9, 10, 11 and 14 rounds, with both methods; for ever, with recovery."""
    cells = chosen("fig4")
    seeds = seeds_of(cells)
    assert len(seeds) >= 10
    wanted = [
        *product(range(26), (9, 10, 11, 14), ("guarded", "ignore-loss"), seeds),
        *product(range(26), (FOR_EVER,), ("guarded",), seeds),
    ]
    assert sorted((*jam(cell), cell.preset, cell.seed) for cell in cells) == sorted(wanted)
    assert {(cell.scenario, cell.cus, cell.trigger, cell.changes) for cell in cells} == {("circle", 3, "HT", (JITTER,))}
    assert {setting_of(cell).scenario.uavs for cell in cells} == {16}


@both
def test_fig4_flies_long_enough(quick: bool) -> None:
    """A jam that ends, ends long before the flight; one for ever lasts beyond it, and the horizon after its start."""
    for cell in chosen("fig4", quick):
        start, length = jam(cell)
        horizon = setting_of(cell).scenario.horizon
        if length == FOR_EVER:
            assert start + horizon + 1 < cell.rounds < start + length
            assert cell.rounds - (start + horizon + 1) >= 15
        else:
            assert start + length + 100 <= cell.rounds
        assert isinstance(cell.losses(16).model, Jam)


@both
def test_two_seconds_are_ten_rounds(quick: bool) -> None:
    """The period of the swarm that is flown makes ten rounds of the two seconds of the paper."""
    assert {setting_of(cell).scenario.parameters.T_s for cell in chosen("fig4", quick)} == {Fraction(1, 5)}
    assert any(jam(cell)[1] * Fraction(1, 5) == 2 for cell in chosen("fig4", quick))


def test_loss_has_every_rate_number_method_and_seed() -> None:
    """0 to 10 % with 10 and 16 UAVs, both methods and Algorithms 1 and 2 as printed, twenty seeds each."""
    cells = chosen("loss")
    seeds = seeds_of(cells)
    assert len(seeds) >= 20
    found = [
        (setting_of(cell).scenario.uavs, 100 * Fraction(cell.loss.removeprefix("iid:")), cell.preset, cell.seed)
        for cell in cells
    ]
    wanted = product((10, 16), map(Fraction, range(11)), ("guarded", "printed", "ignore-loss"), seeds)
    assert sorted(found) == sorted(wanted)
    assert {(cell.scenario, cell.cus, cell.trigger) for cell in cells} == {("random", 2, "HT")}
    assert all(isinstance(cell.losses(16).model, Iid) for cell in cells[:66])


def test_loss_has_whole_legs_in_the_published_space() -> None:
    """Targets are drawn anew a whole number of times, in the flying space of the published simulations."""
    for quick in (True, False):
        for cell in chosen("loss", quick):
            scenario = setting_of(cell).scenario
            assert scenario.hold is not None
            assert cell.rounds % scenario.hold == 0
            assert [[float(end or 0) for end in axis] for axis in scenario.parameters.workspace or ()] == [
                [-1.4, 1.4],
                [-3.7, 3.7],
                [0.4, 1.8],
            ]


def test_methods_are_presets() -> None:
    """MLR-DMPC is the guarded reading, and each method is flown by a preset of the semantics that is its own."""
    assert METHODS == {"guarded": MLR, "printed": PRINTED, "ignore-loss": IGNORING}
    assert set(METHODS) <= set(PRESETS)
    assert len({Semantics.parse(preset) for preset in METHODS}) == len(METHODS)


@both
@each
def test_starts_differ_by_seed(name: str, quick: bool) -> None:
    """Without, all seeds of a flight without loss would be the same flight; with one seed, starts are the same."""
    for variant in planned(name, quick).variants:
        if "jitter=0" in variant.name:
            continue
        places: dict[tuple[str, int, int], set[object]] = {}
        for cell in variant.cells:
            scenario = setting_of(cell).scenario
            places.setdefault((cell.scenario, scenario.uavs, cell.seed), set()).add(scenario.starts)
        assert all(len(starts) == 1 for starts in places.values())
        assert len({starts for one in places.values() for starts in one}) == len(places)
        assert len(seeds_of(variant.cells)) > 1


# All flights


@both
@each
def test_every_cell_is_there_once(name: str, quick: bool) -> None:
    """No variant has a cell twice; the experiment has each once, those as chosen first, by seed."""
    experiment = planned(name, quick)
    for variant in experiment.variants:
        assert len(set(variant.cells)) == len(variant.cells)
    first = set(experiment.variants[0].cells)
    assert set(experiment.cells) == {cell for variant in experiment.variants for cell in variant.cells}
    assert len(set(experiment.cells)) == len(experiment.cells)
    order = [(cell not in first, cell.seed) for cell in experiment.cells]
    assert order == sorted(order)
    assert set(experiment.cells[: len(first)]) == first


def test_ids_are_unique() -> None:
    """Among all cells of all experiments, quick and full, different ones have different ids."""
    cells = {cell for name, quick in product(NAMES, (True, False)) for cell in planned(name, quick).cells}
    assert len({cell.id for cell in cells}) == len(cells) > 4000


@both
@each
def test_every_cell_can_be_flown(name: str, quick: bool) -> None:
    """No cell is bad input: its scenario is read, its starts can hover, its losses are drawn, its targets are there."""
    hovered = set()
    for cell in planned(name, quick).cells:
        setting = setting_of(cell)
        cell.losses(setting.scenario.uavs)
        if setting.scenario.starts not in hovered:
            hovered.add(setting.scenario.starts)
            setting.flight().initial()
            assert setting.scenario.targets_at(cell.rounds - 1)
        assert Lattice.of(setting.scenario.parameters, setting.scenario.horizon).steps > 1


@each
def test_a_quick_run_is_small_and_has_no_variants(name: str) -> None:
    """It is as chosen, with fewer flights, of less than two minutes on one core if a round takes 10 ms."""
    quick = planned(name, True)
    assert [variant.name for variant in quick.variants] == [AS_CHOSEN]
    assert sum(cell.rounds for cell in quick.cells) * 0.010 < 120
    assert len(seeds_of(quick.cells)) > 1


def test_without_variants_it_is_as_chosen() -> None:
    """`--as-chosen` leaves nothing but the first variant."""
    for name in NAMES:
        assert planned(name).as_chosen().variants == planned(name).variants[:1]
        assert set(planned(name).as_chosen().cells) == set(chosen(name))
        assert len(planned(name).variants) > 1
        assert len({variant.name for variant in planned(name).variants}) == len(planned(name).variants)


# Variants


def condition(cell: Cell, but: str = "") -> tuple[object, ...]:
    """Return what a cell of a variant has in common with the one as chosen that it is compared with."""
    method = cell.preset if cell.preset == "ignore-loss" else "recovers"
    parts: dict[str, object] = {
        "cus": cell.cus,
        "trigger": cell.trigger,
        "loss": cell.loss,
        "method": method,
        "uavs": setting_of(cell).scenario.uavs,
    }
    return tuple(value for name, value in parts.items() if name != but)


def meant(base: Cell, change: str) -> Cell:
    """Return the flight as chosen with the change that a variant's name says."""
    name, _, value = change.partition("=")
    if name in ("loss", "trigger"):
        return replace(base, **{name: value})  # type: ignore[arg-type]
    if name == "semantics":
        return replace(base, preset=base.preset if base.preset == "ignore-loss" else value)
    if name == "scenario":
        # places are no longer drawn: starts are disturbed instead
        return replace(base, scenario=value, changes=(f"uavs={setting_of(base).scenario.uavs}", JITTER))
    return replace(base, changes=(*(one for one in base.changes if not one.startswith(f"{name}=")), change))


@changed
def test_a_variant_changes_what_it_says(name: str, change: str) -> None:
    """Its flights are those as chosen with what its name says changed, and nothing else; so each is another flight."""
    variant, as_chosen = variant_of(name, change), chosen(name)
    assert variant.meaning
    if change.startswith("radius "):
        assert variant.cells == as_chosen
        assert change == f"radius {variant.radius:g} m"
        return
    assert variant.radius == REACHED
    option = change.partition("=")[0]
    by_condition: dict[object, list[Cell]] = {}
    for one in as_chosen:
        by_condition.setdefault(condition(one, option), []).append(one)
    for cell in variant.cells:
        # where flights as printed are among those as chosen, the guarded ones are meant; seeds may be others
        (least, *_) = sorted(by_condition[condition(cell, option)], key=lambda one: one.preset)
        base = replace(least, seed=cell.seed)
        expected = meant(base, change)
        assert setting_of(cell) == setting_of(expected)
        assert (cell.loss, cell.rounds) == (expected.loss, expected.rounds)
        if option != "semantics" or cell.preset != "ignore-loss":
            assert (setting_of(cell), cell.loss) != (setting_of(base), base.loss)


@changed
def test_a_variant_has_the_flights_that_claims_compare(name: str, change: str) -> None:
    """With each of its seeds it has the same conditions: all CUs, triggers, or methods, and enough of them."""
    cells = variant_of(name, change).cells
    by_seed = [{condition(cell) for cell in cells if cell.seed == seed} for seed in seeds_of(cells)]
    assert all(one == by_seed[0] for one in by_seed)
    wanted = {
        "fig3b": {(cus, "HT", "recovers") for cus in (1, 2, 3)},
        "fig3c": {(3, trigger, "recovers") for trigger in ("RR", "DT", "HT")},
        "fig4": {(3, change[-2:] if "trigger" in change else "HT", method) for method in ("recovers", "ignore-loss")},
        "loss": {(2, "HT", method) for method in ("recovers", "ignore-loss")},
    }
    assert {(cus, trigger, method) for cus, trigger, _, method, _ in by_seed[0]} >= wanted[name]
    if name == "fig4":
        assert {jam(cell) for cell in cells} == {(start, 10) for start in range(26)}


def test_each_choice_of_the_planner_is_flown_changed() -> None:
    """What matters is shown by changing it: each documented choice is a variant of an experiment somewhere."""
    names = {change.partition("=")[0] for _, change in CHANGED}
    assert {"band", "priority_scale", "retry", "detours", "assignment", "offer", "trigger", "semantics"} <= names
    radii = {variant_of(name, change).radius for name, change in CHANGED if change.startswith("radius ")}
    assert radii == set(RADII) - {REACHED}


# What is observed


def leg(begin: int, uavs: int, all_within: tuple[int | None, ...], last: tuple[int | None, ...]) -> Leg:
    """Return a leg of 100 rounds: with each radius UAVs arrive a round after each other, the last in that of `last`."""
    reached = tuple(
        tuple(None if end is None and i == uavs - 1 else (end or 90) - uavs + 1 + i for i in range(uavs))
        for end in last
    )
    return Leg(begin, 100, all_within, reached)


def flown(cell: Cell, *legs: Leg, **changes: object) -> Measured:
    """Return numbers of a flight that tell each other apart."""
    numbers = Measured(
        rounds=cell.rounds,
        sampled=0.26,
        lower=0.24,
        collides=False,
        closest=(0, 1),
        closest_time=1.0,
        lost=1,
        solved=2,
        rejected=3,
        infeasible=4,
        all_plan=cell.rounds // 4,
        all_run=cell.rounds // 2,
        adopted=7,
        last_adopted=8,
        rest_from=None,
        violated=(),
        legs=legs,
    )
    return replace(numbers, **changes)  # type: ignore[arg-type]


def observed(name: str, cell: Cell, measured: Measured, radius: float = REACHED) -> list[Observation]:
    """Return what is observed of a flight."""
    return planned(name).observe(cell, measured, radius)


def test_rounds_become_seconds() -> None:
    """Five rounds are one second, and what did not happen takes no time."""
    assert seconds(5) == 1.0
    assert seconds(0) == 0.0
    assert seconds(None) is None
    assert seconds(1) == PERIOD_S == 0.2


@pytest.mark.parametrize("radius", RADII)
def test_formations_are_observed(radius: float) -> None:
    """For each formation: all at once, the first quarter one by one, the last; by the variant's radius, in s."""
    which = RADII.index(radius)
    cell = chosen("fig3c")[0]
    legs = [leg(100 * n, 16, (70, 60, 50, 40), (66 + n, 56 + n, 46 + n, 36 + n)) for n in range(4)]
    seen = observed("fig3c", cell, flown(cell, *legs, collides=None), radius)
    assert [one.labels for one in seen] == [
        {"cus": cell.cus, "trigger": cell.trigger, "formation": formation} for formation in FORMATIONS
    ]
    for n, one in enumerate(seen):
        last = 66 - 10 * which + n
        assert one.seed == cell.seed
        assert one.values == pytest.approx(
            {
                "time_to_target_s": (70 - 10 * which) * PERIOD_S,
                # four of sixteen
                "first_quarter_s": (last - 12) * PERIOD_S,
                "last_s": last * PERIOD_S,
                "spread_s": 12 * PERIOD_S,
                "separation_m": 0.24,
                "collides": None,
            }
        )


def test_formations_that_are_not_reached_are_observed() -> None:
    """Without the last UAV there is no last time and no spread, but a first quarter; with three UAVs not even that."""
    cell = chosen("fig3b")[0]
    one = leg(0, 16, (None,) * 4, (None,) * 4)
    three = Leg(0, 100, (None,) * 4, ((3, None, 1, 2, *[None] * 12),) * 4)
    first, second, *_ = observed("fig3b", cell, flown(cell, one, three, one, one))
    assert [first.values[name] for name in ("time_to_target_s", "last_s", "spread_s")] == [None] * 3
    assert first.values["first_quarter_s"] == pytest.approx((90 - 15 + 3) * PERIOD_S)
    assert [second.values[name] for name in ("time_to_target_s", "first_quarter_s", "last_s", "spread_s")] == [None] * 4


def test_a_quarter_is_the_fourth_to_arrive() -> None:
    """UAVs are counted in the order of their arrival, not of their numbers."""
    cell = chosen("fig3b")[0]
    mixed = Leg(0, 100, (99,) * 4, ((50, 9, 40, 3, 30, 7, *range(60, 70)),) * 4)
    (one, *_) = observed("fig3b", cell, flown(cell, *[mixed] * 4))
    assert one.values["first_quarter_s"] == pytest.approx(30 * PERIOD_S)
    assert one.values["last_s"] == pytest.approx(69 * PERIOD_S)
    assert one.values["spread_s"] == pytest.approx(39 * PERIOD_S)


@pytest.mark.parametrize("preset", METHODS)
def test_jams_are_observed(preset: str) -> None:
    """When it began, how long it lasted, who flew; when all had arrived; violated samples are those of Theorem 2."""
    cell = replace(chosen("fig4")[0], loss="jam:7,11", preset=preset, seed=5)
    (one,) = observed("fig4", cell, flown(cell, leg(0, 16, (70, 60, 50, 40), (60,) * 4), rest_from=30))
    assert (one.seed, one.labels) == (
        5,
        {"method": METHODS[preset], "trigger": "HT", "jam_start": 7, "jam_rounds": 11},
    )
    assert one.values == {
        "separation_m": 0.24,
        "sampled_m": 0.26,
        "collides": False,
        "too_close_at_samples": False,
        "arrival_s": 12.0,
        "stuck": cell.rounds >= 30 + 20,
        "halted_s": None,
    }
    violated = flown(cell, leg(0, 16, (None,) * 4, (60,) * 4), violated=("lemma-1", "theorem-2"), collides=True)
    (one,) = observed("fig4", cell, violated, 0.1)
    assert (one.values["too_close_at_samples"], one.values["collides"], one.values["arrival_s"]) == (True, True, None)
    (one,) = observed("fig4", cell, replace(violated, violated=("eq-2", "lemma-1")))
    assert one.values["too_close_at_samples"] is False


@pytest.mark.parametrize(("rest_from", "halted"), [(None, None), (22, 3.0), (7, 0.0), (2, 0.0)])
def test_halts_are_observed(rest_from: int | None, halted: float | None) -> None:
    """From the beginning of a jam for ever until no UAV moves: not before it begins, and None if one always does."""
    cell = replace(chosen("fig4")[0], loss=f"jam:7,{FOR_EVER}")
    measured = flown(cell, leg(0, 16, (None,) * 4, (60,) * 4), rest_from=rest_from)
    (one,) = observed("fig4", cell, measured)
    assert one.values["halted_s"] == halted


@pytest.mark.parametrize(("rest_from", "stuck"), [(None, False), (0, True), (200, True), (201, False), (219, False)])
def test_what_rests_for_long_is_stuck(rest_from: int | None, stuck: bool) -> None:
    """A swarm that rests during the last 20 rounds, longer than any trajectory, moves no more; else it still may."""
    cell = replace(chosen("fig4")[0], loss="jam:7,10", rounds=220)
    assert setting_of(cell).scenario.horizon < 20
    (one,) = observed("fig4", cell, flown(cell, leg(0, 16, (None,) * 4, (60,) * 4), rest_from=rest_from))
    assert one.values["stuck"] is stuck


def test_losses_are_observed() -> None:
    """Percent of loss, UAVs and method; shares of rounds; the mean over legs of when all had arrived, if they did."""
    cell = replace(chosen("loss")[0], loss="iid:0.07", preset="printed")
    legs = (leg(0, 10, (70, 60, 50, 40), (60,) * 4), leg(150, 10, (80, 65, 50, 40), (60,) * 4))
    (one,) = observed("loss", cell, flown(cell, *legs))
    assert one.labels == {"method": PRINTED, "uavs": 10, "loss_percent": 7}
    assert one.values == {
        "separation_m": 0.24,
        "sampled_m": 0.26,
        "collides": False,
        "too_close_at_samples": False,
        "arrival_s": 12.5,
        "all_plan": 0.25,
        "all_run": 0.5,
    }
    never = replace(legs[1], all_within=(None, None, 50, 40))
    (one,) = observed("loss", cell, flown(cell, legs[0], never, violated=("theorem-2",)))
    assert (one.values["arrival_s"], one.values["too_close_at_samples"]) == (None, True)
    (one,) = observed("loss", cell, flown(cell, legs[0], never), 0.1)
    assert one.values["arrival_s"] == 10.0


def test_every_percent_is_read_as_it_is_written() -> None:
    """Labels are whole percent, from 0 to 10, whatever floats make of them."""
    for cell in chosen("loss"):
        (one,) = observed("loss", cell, flown(cell, leg(0, 10, (70, 60, 50, 40), (60,) * 4)))
        assert Fraction(f"{one.labels['loss_percent']}") / 100 == Fraction(cell.loss.removeprefix("iid:"))


def test_triggers_are_those_of_the_paper() -> None:
    """Each trigger is flown in some experiment as chosen."""
    assert {cell.trigger for name in NAMES for cell in chosen(name)} == set(map(str, Trigger))
