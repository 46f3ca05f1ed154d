"""Fig. 4: a circle of UAVs changes places while the CUs hear nothing for some time (Section 5.4)."""

from __future__ import annotations

from collections.abc import Sequence

from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import Label, Observation, Value
from swarmproof.dmpc_swarm.claims.experiments import FOR_EVER, TWO_SECONDS
from swarmproof.dmpc_swarm.experiments.experiment import AS_CHOSEN, JITTER, METHODS, Experiment, Variant, seconds
from swarmproof.dmpc_swarm.experiments.measure import RADII, Measured
from swarmproof.scenario.scenario import DEFAULT_HORIZON

#: Rounds that a jam lasts; ten are the two seconds of the paper.
JAMS = (9, TWO_SECONDS, 11, 14)
#: Rounds after the change of the targets in which it begins.
STARTS = range(26)
SEEDS, FEWER_SEEDS = 10, 3
QUICK_STARTS, QUICK_SEEDS = range(0, 13, 3), 2
#: Rounds of a flight, in which almost all arrive; and those of rest after which a swarm stays where it is.
ROUNDS, QUICK_ROUNDS, AT_REST = 220, 160, 20
#: What is changed, and what that means. `trigger` and `semantics` are the options of that name.
CHANGES = {
    "jitter=0": "the exact circle, in which all want to pass through one point",
    "band=0.5": "the soft constraint of Appendix B with the published number",
    "offer=highest": "of several new trajectories, a UAV follows that in the highest slot",
    "trigger=DT": "the trigger DT",
    "trigger=RR": "the trigger RR",
    "semantics=printed": "Algorithms 1 and 2 as printed, not guarded",
}
#: Its start and its length, in rounds.
Jam = tuple[int, int]


def fig4(quick: bool) -> Experiment:
    """Return the experiment with the jam."""
    starts, lengths = (QUICK_STARTS, (TWO_SECONDS,)) if quick else (STARTS, JAMS)
    jams = [(start, length) for length in lengths for start in starts]
    for_ever = [(start, FOR_EVER) for start in starts]
    rounds = QUICK_ROUNDS if quick else ROUNDS
    chosen = _variant(AS_CHOSEN, "", [*jams, *for_ever], QUICK_SEEDS if quick else SEEDS, rounds)
    two_seconds = [(start, TWO_SECONDS) for start in starts]
    changed = (
        _variant(change, meaning, two_seconds, 1 if change == "jitter=0" else FEWER_SEEDS, rounds)
        for change, meaning in CHANGES.items()
    )
    return Experiment(
        "fig4",
        "Fig. 4: a jam of two seconds",
        "16 UAVs change places across a circle, with 3 CUs and the trigger HT. From some round on the CUs hear "
        "nothing, for some rounds or for ever; they transmit all the time, and UAVs hear them. Where a choice is "
        "changed, jams last two seconds.",
        (chosen,) if quick else (chosen, *changed),
        _observe,
    )


def _variant(change: str, meaning: str, jams: Sequence[Jam], seeds: int, rounds: int) -> Variant:
    cells = (
        _cell(jam, preset, seed, rounds, change)
        for seed in range(seeds)
        for jam in jams
        for preset in ("guarded", "ignore-loss")
        if preset == "guarded" or jam[1] != FOR_EVER
    )
    return Variant(change, meaning, tuple(cells))


def _cell(jam: Jam, preset: str, seed: int, rounds: int, change: str) -> Cell:
    start, length = jam
    trigger, changes = "HT", [JITTER]
    name, _, value = change.partition("=")
    if name == "trigger":
        trigger = value
    elif name == "semantics":
        preset = value if preset == "guarded" else preset
    elif name == "jitter":
        changes = [change]
    elif change != AS_CHOSEN:
        changes.append(change)
    if length == FOR_EVER:
        rounds = start + DEFAULT_HORIZON + 1 + AT_REST
    return Cell("circle", 3, trigger, f"jam:{start},{length}", preset, seed, rounds, tuple(changes))


def _observe(cell: Cell, measured: Measured, radius: float) -> list[Observation]:
    """Return what came out of a flight; `halted_s` is from the jam's beginning until no UAV moved any more."""
    start, length = (int(number) for number in cell.loss.removeprefix("jam:").split(","))
    halted = None if measured.rest_from is None else max(0, measured.rest_from - start)
    (leg,) = measured.legs
    labels: dict[str, Label] = {
        "method": METHODS[cell.preset],
        "trigger": cell.trigger,
        "jam_start": start,
        "jam_rounds": length,
    }
    values: dict[str, Value] = {
        "separation_m": measured.lower,
        "sampled_m": measured.sampled,
        "collides": measured.collides,
        "too_close_at_samples": "theorem-2" in measured.violated,
        "arrival_s": seconds(leg.all_within[RADII.index(radius)]),
        "stuck": measured.rest_from is not None and measured.rest_from <= measured.rounds - AT_REST,
        "halted_s": seconds(halted) if length == FOR_EVER else None,
    }
    return [Observation(cell.seed, labels, values)]
