"""The sweep of independent message loss: 0 to 10 %, with and without handling it."""

from __future__ import annotations

from collections.abc import Sequence

from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import Label, Observation, Value
from swarmproof.dmpc_swarm.experiments.experiment import AS_CHOSEN, JITTER, METHODS, Experiment, Variant, seconds
from swarmproof.dmpc_swarm.experiments.measure import RADII, Measured

PERCENT, FEWER_PERCENT, QUICK_PERCENT = range(11), (0, 5, 10), (0, 5, 10)
UAVS = (10, 16)
SEEDS, QUICK_SEEDS = 20, 3
#: Rounds of a flight, all of which count for the share in which all CUs plan; and those that each target has.
ROUNDS, QUICK_ROUNDS = 300, 150
HOLD = 150
#: The flying space of the published simulations, in m; starts and targets in it are random.
SPACE = "workspace=-1.4,1.4,-3.7,3.7,0.4,1.8"
#: What is changed, and what that means. `scenario` stands for another one, with disturbed starts.
CHANGES = {
    "scenario=circle": "UAVs change places across a circle: all ways cross",
    "band=0.5": "the soft constraint of Appendix B with the published number",
    "offer=highest": "of several new trajectories, a UAV follows that in the highest slot",
}
#: N, and percent of loss.
Condition = tuple[int, int]


def loss(quick: bool) -> Experiment:
    """Return the sweep."""
    rounds = QUICK_ROUNDS if quick else ROUNDS
    conditions = [(uavs, percent) for uavs in UAVS for percent in (QUICK_PERCENT if quick else PERCENT)]
    chosen = _variant(AS_CHOSEN, "", conditions, tuple(METHODS), QUICK_SEEDS if quick else SEEDS, rounds)
    fewer = [(16, percent) for percent in FEWER_PERCENT]
    changed = (
        _variant(change, meaning, fewer, ("guarded", "ignore-loss"), SEEDS, rounds)
        for change, meaning in CHANGES.items()
    )
    return Experiment(
        "loss",
        "Independent message loss",
        "10 and 16 UAVs fly from random starts to random targets in the flying space of the published simulations, "
        f"with 2 CUs and the trigger HT, for {rounds} rounds (of 0.2 s); every {HOLD} rounds there are new targets. "
        "Each message is lost at each receiver with the same probability, independently.",
        (chosen,) if quick else (chosen, *changed),
        _observe,
    )


def _variant(
    change: str, meaning: str, conditions: Sequence[Condition], presets: Sequence[str], seeds: int, rounds: int
) -> Variant:
    cells = (
        _cell(condition, preset, seed, rounds, change)
        for seed in range(seeds)
        for condition in conditions
        for preset in presets
    )
    return Variant(change, meaning, tuple(cells))


def _cell(condition: Condition, preset: str, seed: int, rounds: int, change: str) -> Cell:
    uavs, percent = condition
    scenario = "random"
    changes = [f"uavs={uavs}", SPACE, f"hold={HOLD}"]
    name, _, value = change.partition("=")
    if name == "scenario":
        scenario, changes = value, [f"uavs={uavs}", JITTER]
    elif change != AS_CHOSEN:
        changes.append(change)
    return Cell(scenario, 2, "HT", f"iid:{percent / 100:g}", preset, seed, rounds, tuple(changes))


def _observe(cell: Cell, measured: Measured, radius: float) -> list[Observation]:
    """Return what came out of a flight: shares of its rounds, and the mean time until all had reached their targets."""
    reached = [leg.all_within[RADII.index(radius)] for leg in measured.legs]
    arrived = [rounds for rounds in reached if rounds is not None]
    labels: dict[str, Label] = {
        "method": METHODS[cell.preset],
        "uavs": len(measured.legs[0].reached[0]),
        "loss_percent": round(100 * float(cell.loss.removeprefix("iid:"))),
    }
    values: dict[str, Value] = {
        "separation_m": measured.lower,
        "sampled_m": measured.sampled,
        "collides": measured.collides,
        "too_close_at_samples": "theorem-2" in measured.violated,
        "arrival_s": seconds(sum(arrived) / len(arrived)) if len(arrived) == len(reached) else None,
        "all_plan": measured.all_plan / measured.rounds,
        "all_run": measured.all_run / measured.rounds,
    }
    return [Observation(cell.seed, labels, values)]
