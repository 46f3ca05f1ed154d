"""Fig. 3b and 3c: 16 UAVs change formations, with more or fewer CUs and with each event trigger (Section 5.3)."""

from __future__ import annotations

from collections.abc import Sequence

from swarmproof.campaign.trial import Cell
from swarmproof.claims.samples import Label, Observation, Value
from swarmproof.dmpc_swarm.claims.experiments import FORMATIONS
from swarmproof.dmpc_swarm.experiments.experiment import AS_CHOSEN, JITTER, Experiment, Variant, seconds
from swarmproof.dmpc_swarm.experiments.measure import RADII, REACHED, Measured

#: Rounds that each formation has. With one CU and RR some would need 190; with HT 90 are enough.
HOLD, QUICK_HOLD = 150, 110
#: Seeds 0 to 19 were a pilot, which showed how many are needed: as chosen, they do not count.
SEEDS, FEWER_SEEDS, QUICK_SEEDS = range(20, 80), range(10), range(2)
#: What is changed, and what that means. `loss` is the option of that name.
CHANGES = {
    "band=0.5": "the soft constraint of Appendix B with the published number",
    "priority_scale=linear": "8-bit priorities on a linear scale, not a logarithmic one",
    "retry=0": "a deadlocked UAV has priority one for as long as it is deadlocked",
    "detours=off": "no high-level planner (Appendix B.1)",
    "assignment=shuffled": "a random place in each formation for each UAV",
    "loss=iid:0.01": "1 % of all messages are lost",
}
#: M and trigger.
Condition = tuple[int, str]


def fig3b(quick: bool) -> Experiment:
    """Return the experiment on the number of CUs."""
    hold = QUICK_HOLD if quick else HOLD
    conditions = [(cus, "HT") for cus in (1, 2, 3)]
    return Experiment(
        "fig3b",
        "Fig. 3b: how many compute units",
        "16 UAVs fly from a plane to a pyramid, a cube, a sphere and back to the plane, with 1, 2 and 3 CUs and the "
        f"trigger HT, without message loss. Each formation has {hold} rounds (of 0.2 s); it is reached when all UAVs "
        "are at their targets at once.",
        _variants(conditions, conditions, hold, quick),
        _observe,
    )


def fig3c(quick: bool) -> Experiment:
    """Return the experiment on the event trigger."""
    hold = QUICK_HOLD if quick else HOLD
    triggers = ("RR", "DT", "HT")
    of_claims = [(3, trigger) for trigger in triggers]
    fewer = [] if quick else [(2, trigger) for trigger in triggers]
    return Experiment(
        "fig3c",
        "Fig. 3c: which event trigger",
        "16 UAVs fly from a plane to a pyramid, a cube, a sphere and back to the plane, with the triggers RR, DT and "
        "HT, without message loss. The paper does not say how many CUs plan: the claims are about three, and "
        f"what two do is beside them. Each formation has {hold} rounds (of 0.2 s).",
        _variants([*of_claims, *fewer], of_claims, hold, quick),
        _observe,
    )


def _variants(
    conditions: Sequence[Condition], of_claims: Sequence[Condition], hold: int, quick: bool
) -> tuple[Variant, ...]:
    """Return the experiment as chosen under all `conditions`, and, unless it is quick, with choices changed."""
    seeds = QUICK_SEEDS if quick else SEEDS
    cells = tuple(_cell(condition, seed, hold, series=True) for seed in seeds for condition in conditions)
    chosen = Variant(AS_CHOSEN, "", cells)
    if quick:
        return (chosen,)
    changed = (
        Variant(
            change,
            meaning,
            tuple(_cell(condition, seed, hold, change) for seed in FEWER_SEEDS for condition in of_claims),
        )
        for change, meaning in CHANGES.items()
    )
    radii = (
        Variant(f"radius {radius:g} m", f"a target is reached within {radius:g} m, not {REACHED:g} m", cells, radius)
        for radius in RADII
        if radius != REACHED
    )
    return (chosen, *changed, *radii)


def _cell(condition: Condition, seed: int, hold: int, change: str = "", series: bool = False) -> Cell:
    cus, trigger = condition
    loss, changes = "none", [JITTER, f"hold={hold}"]
    if change.startswith("loss="):
        loss = change.removeprefix("loss=")
    elif change:
        changes.append(change)
    rounds = hold * len(FORMATIONS)
    return Cell("formations", cus, trigger, loss, "guarded", seed, rounds, tuple(changes), series)


def _observe(cell: Cell, measured: Measured, radius: float) -> list[Observation]:
    """Return an observation for each formation: when all UAVs had reached it, and how they arrived one by one.

    `first_quarter_s` is when a quarter of them had arrived, `spread_s` how much later the last did.
    """
    seen = []
    for formation, leg in zip(FORMATIONS, measured.legs, strict=True):
        reached = leg.reached[RADII.index(radius)]
        arrived = sorted(rounds for rounds in reached if rounds is not None)
        quarter = len(reached) // 4
        first = arrived[quarter - 1] if len(arrived) >= quarter else None
        last = arrived[-1] if len(arrived) == len(reached) else None
        labels: dict[str, Label] = {"cus": cell.cus, "trigger": cell.trigger, "formation": formation}
        values: dict[str, Value] = {
            "time_to_target_s": seconds(leg.all_within[RADII.index(radius)]),
            "first_quarter_s": seconds(first),
            "last_s": seconds(last),
            "spread_s": None if first is None or last is None else seconds(last - first),
            "separation_m": measured.lower,
            "collides": measured.collides,
        }
        seen.append(Observation(cell.seed, labels, values))
    return seen
