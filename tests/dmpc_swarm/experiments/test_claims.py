"""The claims about experiments: made-up flights with which each agrees, disagrees, is undecided; real labels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, isnan

import pytest

from swarmproof.campaign.decide import Agreement, decide, decide_variant
from swarmproof.campaign.store import Stored
from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import ExperimentClaim, Missing, Observation, Ordering, Value, read
from swarmproof.dmpc_swarm.claims.experiments import (
    EXPERIMENT_CLAIMS,
    FOR_EVER,
    FORMATIONS,
    IGNORING,
    MLR,
    PERIOD_S,
    PRINTED,
    TWO_SECONDS,
    apart,
    claims_of,
    gain,
    maximum,
    similar,
)
from swarmproof.dmpc_swarm.experiments import experiment
from swarmproof.dmpc_swarm.experiments.experiments import EXPERIMENTS
from swarmproof.dmpc_swarm.experiments.measure import RADII, Leg, Measured

AGREES, DISAGREES, UNDECIDED = Agreement.AGREES, Agreement.DISAGREES, Agreement.UNDECIDED
BY_ID = {claim.id: claim for claim in EXPERIMENT_CLAIMS}
SEEDS = 12
ODD = range(1, SEEDS, 2)
#: s from 1, 2, 3 CUs, and from RR, DT, HT.
CUS = {1: 40.0, 2: 20.0, 3: 14.0}
TRIGGERS = {"RR": 30.0, "DT": 15.0, "HT": 14.0}
FIRST = {"RR": 12.0, "DT": 13.0, "HT": 8.0}

Flights = list[Observation]
Change = Callable[[Observation], dict[str, Value]]


def nothing_changed(seen: Observation) -> dict[str, Value]:
    """Change nothing."""
    return {}


def fig3b(
    times: dict[int, float] = CUS, change: Change = nothing_changed, seeds: Sequence[int] = range(SEEDS)
) -> Flights:
    """Return flights of Fig. 3b; a formation takes the time of its CUs, more in later seeds and formations."""
    return _changed(
        [
            Observation(
                seed,
                {"cus": cus, "trigger": "HT", "formation": formation},
                {"time_to_target_s": time + seed + number, "separation_m": 0.25, "collides": False},
            )
            for seed in seeds
            for cus, time in times.items()
            for number, formation in enumerate(FORMATIONS)
        ],
        change,
    )


def fig3c(
    times: dict[str, float] = TRIGGERS,
    first: dict[str, float] = FIRST,
    change: Change = nothing_changed,
    seeds: Sequence[int] = range(SEEDS),
) -> Flights:
    """Return flights of Fig. 3c, with one and with three CUs; those with one come out the other way round."""
    return _changed(
        [
            Observation(
                seed,
                {"cus": cus, "trigger": trigger, "formation": formation},
                {
                    "time_to_target_s": seed + (time if cus == 3 else 99 - time),
                    "first_quarter_s": seed + (first[trigger] if cus == 3 else 99 - first[trigger]),
                    "spread_s": time - first[trigger] if cus == 3 else 99 - time + first[trigger],
                    "separation_m": 0.25,
                    "collides": False,
                },
            )
            for seed in seeds
            for cus in (1, 3)
            for trigger, time in times.items()
            for formation in FORMATIONS
        ],
        change,
    )


def fig4(change: Change = nothing_changed, seeds: Sequence[int] = range(SEEDS)) -> Flights:
    """Return flights of Fig. 4 as the paper has them; ignoring loss, two starts of a two-second jam collide."""
    return _changed(
        [
            Observation(
                seed,
                {"method": method, "trigger": "HT", "jam_start": start, "jam_rounds": length},
                {
                    "separation_m": 0.25 - seed / 1000,
                    "collides": method == IGNORING and length == TWO_SECONDS and start in (0, 3),
                    "too_close_at_samples": method == IGNORING,
                    "arrival_s": None if method == IGNORING or length == FOR_EVER else 30.0,
                    "stuck": method == IGNORING or length == FOR_EVER,
                    "halted_s": 3.0 if length == FOR_EVER else None,
                },
            )
            for seed in seeds
            for method in (MLR, PRINTED, IGNORING)
            for start in (0, 3, 5)
            for length in (9, TWO_SECONDS, FOR_EVER)
        ],
        change,
    )


def loss(change: Change = nothing_changed, seeds: Sequence[int] = range(SEEDS)) -> Flights:
    """Return flights with loss that come out as the paper says; ignoring loss, those with 10 % collide."""
    return _changed(
        [
            Observation(
                seed,
                {"method": method, "uavs": 16, "loss_percent": percent},
                {
                    "separation_m": 0.25,
                    "collides": method == IGNORING and percent == 10,
                    "too_close_at_samples": method == IGNORING,
                },
            )
            for seed in seeds
            for method in (MLR, PRINTED, IGNORING)
            for percent in (0, 10)
        ],
        change,
    )


def _changed(flights: Flights, change: Change) -> Flights:
    return [replace(seen, values={**seen.values, **change(seen)}) for seen in flights]


def change(name: str, new: Value, seeds: Sequence[int] = range(SEEDS), **labels: str | int) -> Change:
    """Return the change of one value in the flights of these seeds with these labels."""
    return lambda seen: {name: new} if seen.seed in seeds and seen.labels.items() >= labels.items() else {}


@dataclass(frozen=True)
class Case:
    """Flights with which a claim agrees, disagrees, and is undecided."""

    agrees: Flights
    disagrees: Flights
    undecided: Flights


#: For every claim; what disagrees with "never" does so in one flight only.
CASES = {
    "fig3b-two-beat-one": Case(
        fig3b(change=change("time_to_target_s", 50.0, cus=2, formation="cube")),
        fig3b({1: 20.0, 2: 40.0, 3: 14.0}),
        fig3b(change=change("time_to_target_s", 199.0, ODD, cus=2, formation="cube")),
    ),
    "fig3b-two-beat-one-each": Case(
        fig3b(),
        fig3b(change=change("time_to_target_s", 99.0, cus=2, formation="cube")),
        fig3b(change=change("time_to_target_s", 99.0, ODD, cus=2, formation="cube")),
    ),
    "fig3b-three-beat-two": Case(
        fig3b(change=change("time_to_target_s", 25.0, cus=3, formation="plane")),
        fig3b({1: 40.0, 2: 14.0, 3: 20.0}),
        fig3b(change=change("time_to_target_s", None, ODD, cus=3, formation="plane")),
    ),
    "fig3b-three-beat-two-each": Case(
        fig3b(),
        fig3b(change=change("time_to_target_s", None, cus=3, formation="plane")),
        fig3b(change=change("time_to_target_s", None, ODD, cus=3, formation="plane")),
    ),
    "fig3b-diminishing": Case(
        fig3b(), fig3b({1: 40.0, 2: 34.0, 3: 14.0}), fig3b(change=change("time_to_target_s", None, ODD, cus=1))
    ),
    "fig3b-safe": Case(
        fig3b(), fig3b(change=change("collides", True, [4], cus=2)), fig3b(change=change("collides", None, [4], cus=2))
    ),
    "fig3c-rr-slowest": Case(
        fig3c(change=change("time_to_target_s", 1.0, cus=3, trigger="RR", formation="cube")),
        fig3c({"RR": 14.5, "DT": 15.0, "HT": 14.0}),
        fig3c(change=change("time_to_target_s", 1.0, ODD, cus=3, trigger="RR")),
    ),
    "fig3c-similar": Case(
        fig3c(change=change("time_to_target_s", 20.0, cus=3, trigger="DT", formation="cube")),
        fig3c({"RR": 30.0, "DT": 60.0, "HT": 14.0}),
        fig3c(change=change("time_to_target_s", 99.0, ODD, cus=3, trigger="DT")),
    ),
    "fig3c-ht-earlier": Case(
        fig3c(),
        fig3c(first={"RR": 12.0, "DT": 8.0, "HT": 13.0}),
        fig3c(change=change("first_quarter_s", 99.0, ODD, cus=3, trigger="HT", formation="sphere")),
    ),
    "fig3c-dt-together": Case(
        fig3c(),
        fig3c(first={"RR": 12.0, "DT": 8.0, "HT": 13.0}),
        fig3c(change=change("spread_s", 99.0, ODD, cus=3, trigger="DT", formation="sphere")),
    ),
    "fig3c-safe": Case(
        fig3c(),
        fig3c(change=change("collides", True, [4], trigger="RR", cus=1)),
        fig3c(change=change("collides", None, [4], trigger="RR", cus=1)),
    ),
    "fig4-ignoring-collides": Case(
        fig4(change("collides", False, range(1, SEEDS), method=IGNORING)),
        fig4(change("collides", False, method=IGNORING, jam_rounds=TWO_SECONDS, jam_start=0)),
        fig4(change("collides", None, method=IGNORING)),
    ),
    "fig4-ignoring-collides-later": Case(
        fig4(change("collides", False, range(1, SEEDS), method=IGNORING)),
        fig4(change("collides", False, method=IGNORING, jam_rounds=TWO_SECONDS, jam_start=3)),
        fig4(change("collides", None, method=IGNORING)),
    ),
    "fig4-recovering-safe": Case(
        fig4(),
        fig4(change("collides", True, [4], method=MLR, jam_start=5, jam_rounds=9)),
        fig4(change("collides", None, [4], method=PRINTED, jam_start=5, jam_rounds=FOR_EVER)),
    ),
    "fig4-recovering-separated": Case(
        fig4(),
        fig4(change("too_close_at_samples", True, [4], method=PRINTED, jam_start=3, jam_rounds=FOR_EVER)),
        fig4(change("too_close_at_samples", None, [4], method=MLR, jam_start=3)),
    ),
    "fig4-recovering-arrives": Case(
        fig4(),
        _changed(fig4(change("arrival_s", None, [4], method=MLR, jam_start=5)), change("stuck", True, method=MLR)),
        fig4(change("arrival_s", None, [4], method=MLR, jam_start=5)),
    ),
    "fig4-halts": Case(
        fig4(change("halted_s", 16 * PERIOD_S, method=MLR)),
        fig4(change("halted_s", 17 * PERIOD_S, [4], method=MLR, jam_start=5)),
        fig4(change("collides", None, [4], method=MLR)),
    ),
    "loss-ignoring-collides": Case(
        loss(change("collides", False, range(1, SEEDS), method=IGNORING)),
        _changed(loss(change("collides", False, loss_percent=10)), change("collides", True, loss_percent=0)),
        loss(change("collides", None, method=IGNORING)),
    ),
    "loss-recovering-safe": Case(
        loss(change("collides", True, method=PRINTED)),
        loss(change("collides", True, [4], method=MLR, loss_percent=10)),
        loss(change("collides", None, [4], method=MLR, loss_percent=10)),
    ),
    "loss-recovering-separated": Case(
        loss(change("too_close_at_samples", True, method=PRINTED)),
        loss(change("too_close_at_samples", True, [4], method=MLR, loss_percent=10)),
        loss(change("too_close_at_samples", None, [4], method=MLR, loss_percent=10)),
    ),
    "loss-printed-safe": Case(
        loss(change("collides", True, method=MLR)),
        loss(change("collides", True, [4], method=PRINTED, loss_percent=10)),
        loss(change("collides", None, [4], method=PRINTED, loss_percent=10)),
    ),
    "loss-printed-separated": Case(
        loss(change("too_close_at_samples", True, method=MLR)),
        loss(change("too_close_at_samples", True, [4], method=PRINTED, loss_percent=10)),
        loss(change("too_close_at_samples", None, [4], method=PRINTED, loss_percent=10)),
    ),
}


def test_every_claim_has_made_up_flights() -> None:
    """No claim is without its three sets of flights, and ids are unique."""
    assert list(CASES) == [claim.id for claim in EXPERIMENT_CLAIMS]
    assert all(claim.id.startswith(f"{claim.experiment}-") for claim in EXPERIMENT_CLAIMS)


@pytest.mark.parametrize("name", CASES)
def test_a_claim_comes_out_each_way(name: str) -> None:
    """Each claim agrees with what it says, disagrees with the planted opposite, and is undecided between them."""
    case = CASES[name]
    found = [decide(BY_ID[name], flights).verdict for flights in (case.agrees, case.disagrees, case.undecided)]
    assert found == [AGREES, DISAGREES, UNDECIDED]


@pytest.mark.parametrize("claim", EXPERIMENT_CLAIMS, ids=lambda claim: claim.id)
def test_flights_as_in_the_paper_agree_with_every_claim(claim: ExperimentClaim) -> None:
    """What agrees with one claim about an experiment is not made up against another."""
    world: dict[str, Callable[[], Flights]] = {"fig3b": fig3b, "fig3c": fig3c, "fig4": fig4, "loss": loss}
    assert decide(claim, world[claim.experiment]()).verdict is AGREES


def test_the_words_and_numbers_of_the_claims_are_those_of_the_experiments() -> None:
    """What the claims speak of is flown: their jams, their methods, and the period that turns rounds into seconds."""
    assert {TWO_SECONDS, FOR_EVER} <= {int(cell.loss.split(",")[1]) for cell in EXPERIMENTS["fig4"](False).cells}
    assert {MLR, PRINTED, IGNORING} == set(experiment.METHODS.values())
    assert TWO_SECONDS * PERIOD_S == 2
    for name in EXPERIMENTS:
        assert float(EXPERIMENTS[name](True).cells[0].setting().scenario.parameters.T_s) == PERIOD_S


def flown(cell: Cell) -> Measured:
    """Return numbers that a flight of the cell could have."""
    legs = [Leg(0, cell.rounds, (50,) * len(RADII), ((20,) * 12 + (40,) * 4,) * len(RADII)) for _ in FORMATIONS]
    return Measured(
        rounds=cell.rounds,
        sampled=0.25,
        lower=0.24,
        collides=False,
        closest=(0, 1),
        closest_time=1.0,
        lost=0,
        solved=1,
        rejected=0,
        infeasible=0,
        all_plan=1,
        all_run=1,
        adopted=1,
        last_adopted=1,
        rest_from=1,
        violated=(),
        legs=tuple(legs if cell.scenario == "formations" else legs[:1]),
    )


@pytest.mark.parametrize("quick", [True, False])
@pytest.mark.parametrize("name", EXPERIMENTS)
def test_every_claim_reads_what_is_observed(name: str, quick: bool) -> None:
    """With all cells flown no seed is left out, and no claim is without flights; nothing is read that is not there."""
    planned = EXPERIMENTS[name](quick)
    assert claims_of(name)
    for variant in planned.variants:
        found = {cell: Stored(flown(cell), 1.0) for cell in variant.cells}
        decided = decide_variant(planned, variant, found)
        assert [each.claim for each in decided] == list(claims_of(name))
        assert not any(one.missing for each in decided for one in each.compared)
        if variant is planned.variants[0]:
            assert all(each.observed for each in decided)


def test_collisions_are_counted_once_for_each_flight() -> None:
    """A flight through four formations is one flight."""
    assert decide(BY_ID["fig3b-safe"], fig3b()).observed == SEEDS * len(CUS)


def test_a_gain_is_not_known_where_a_formation_is_not_reached() -> None:
    """Nothing is concluded from a time of which only a bound is known, on either side."""
    for cus, unknown in ((1, (True, False)), (2, (True, True)), (3, (False, True))):
        run = [seen for seen in fig3b(change=change("time_to_target_s", None, cus=cus)) if seen.seed == 0]
        assert (isnan(gain(1, 2)(run)), isnan(gain(2, 3)(run))) == unknown


def test_equal_gains_are_a_tie() -> None:
    """Times are whole periods; what rounding adds to their sums makes no order."""
    times = {1: 0.2 * 71, 2: 0.2 * 70, 3: 0.2 * 69}
    (compared,) = decide(BY_ID["fig3b-diminishing"], fig3b(times)).compared
    assert (compared.seeds, compared.as_said, compared.reversed) == (SEEDS, 0, 0)
    run: Flights = []
    ten, twelve = (lambda run: 0.2 * 15 + 7.0), (lambda run: 12.0)
    assert apart(ten, twelve)(run) == similar(ten, twelve)(run) == 2


def test_similar_times_differ_by_less_than_a_fifth_of_the_shorter() -> None:
    """What is not reached at all is like nothing that is reached; two such are not known to be alike."""
    run: Flights = []
    for one, other, alike in ((10.0, 11.9, True), (11.9, 10.0, True), (10.0, 12.1, False), (10.0, inf, False)):
        first, second = (lambda run, time=one: time), (lambda run, time=other: time)
        assert (apart(first, second)(run) < similar(first, second)(run)) is alike
    never = lambda run: inf  # noqa: E731
    assert isnan(apart(never, never)(run))
    assert maximum(never, never)(run) == inf


def test_what_is_read() -> None:
    """One observation, by its labels; None is infinitely late; nothing there is missing; the rest are mistakes."""
    run = [seen for seen in fig4() if seen.seed == 0]
    one: dict[str, str | int] = {"method": MLR, "jam_start": 3, "jam_rounds": TWO_SECONDS}
    assert read("arrival_s", **one)(run) == 30
    assert read("halted_s", **one)(run) == inf
    with pytest.raises(Missing):
        read("arrival_s", method="none")(run)
    with pytest.raises(KeyError, match="observations"):
        read("arrival_s", method=MLR)(run)
    with pytest.raises(KeyError, match="arrivals"):
        read("arrivals", **one)(run)


def test_orderings_can_be_needed_at_most_as_often_as_there_are_comparisons() -> None:
    """A claim that needs none, or more than there are, could not come out both ways."""
    for claim in EXPERIMENT_CLAIMS:
        if isinstance(claim.statement, Ordering):
            assert 1 <= claim.statement.needed <= len(claim.statement.comparisons)
