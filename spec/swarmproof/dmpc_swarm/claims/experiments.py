"""What DMPC-Swarm says about its experiments (Section 5), as claims over flights with many seeds."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite, nan

from swarmproof.claims.samples import (
    Comparison,
    ExperimentClaim,
    Never,
    Observation,
    Ordering,
    Reading,
    Run,
    Sometimes,
    read,
)
from swarmproof.scenario.scenario import DEFAULT_HORIZON

FORMATIONS = ("pyramid", "cube", "sphere", "plane")
#: As they are called in the label ``method``.
MLR, PRINTED, IGNORING = "MLR-DMPC", "MLR-DMPC as printed", "ignoring loss"
#: Rounds in the label ``jam_rounds``: the two seconds of the paper, and a jam that does not end.
TWO_SECONDS, FOR_EVER = 10, 1000
#: s; the period T, and the length of the prediction horizon.
PERIOD_S = 0.2
HORIZON_S = DEFAULT_HORIZON * PERIOD_S
#: Two times are similar if they differ by less than this share of the shorter one. The paper does not say; ours.
SIMILAR = 0.2


def maximum(one: Reading, other: Reading) -> Reading:
    """Return the reading of the larger of two numbers."""
    return lambda run: max(one(run), other(run))


def in_all(one: Callable[[str], Reading]) -> Reading:
    """Return the reading of the sum over the formations, in s."""
    return lambda run: _clean(sum(one(formation)(run) for formation in FORMATIONS))


def gain(fewer: int, more: int) -> Reading:
    """Return the reading of how much sooner all formations together are reached with `more` than `fewer` CUs, in s.

    It is nan if a formation is not reached with one of the two: how much the gain is, is then not known.
    """

    def reading(run: Run) -> float:
        slow, fast = in_all(with_cus(fewer))(run), in_all(with_cus(more))(run)
        return _clean(slow - fast) if isfinite(slow) and isfinite(fast) else nan

    return reading


def apart(one: Reading, other: Reading) -> Reading:
    """Return the reading of how far two numbers are from each other; nan if both are infinite."""
    return lambda run: _clean(abs(one(run) - other(run)))


def similar(one: Reading, other: Reading) -> Reading:
    """Return the reading of how far two numbers may be from each other, and be similar."""
    return lambda run: _clean(SIMILAR * min(one(run), other(run)))


def _clean(time: float) -> float:
    """Return a time in s without what rounding has added: times are whole periods, and equal ones must stay equal."""
    return round(time, 9)


def in_formations(smaller: Callable[[str], Reading], larger: Callable[[str], Reading]) -> tuple[Comparison, ...]:
    """Return one comparison for each formation."""
    return tuple(Comparison(formation, smaller(formation), larger(formation)) for formation in FORMATIONS)


def with_cus(cus: int) -> Callable[[str], Reading]:
    """Return the reading of a formation's time to target with so many CUs and HT, in s."""
    return lambda formation: read("time_to_target_s", cus=cus, trigger="HT", formation=formation)


def with_trigger(trigger: str, value: str = "time_to_target_s") -> Callable[[str], Reading]:
    """Return the reading of a formation's `value` with a trigger and three CUs."""
    return lambda formation: read(value, cus=3, trigger=trigger, formation=formation)


def slower_of(one: str, other: str) -> Callable[[str], Reading]:
    """Return the reading of a formation's time to target with the slower of two triggers, in s."""
    return lambda formation: maximum(with_trigger(one)(formation), with_trigger(other)(formation))


def collides(seen: Observation) -> bool | None:
    """Say whether two references come closer than d_min at some time; None if that is not decided."""
    return _truth(seen, "collides")


def too_close_at_samples(seen: Observation) -> bool | None:
    """Say whether two references come closer than d̂_min at a multiple of T_c."""
    return _truth(seen, "too_close_at_samples")


def _truth(seen: Observation, value: str) -> bool | None:
    truth = seen.values[value]
    return None if truth is None else bool(truth)


def does_not_arrive(seen: Observation) -> bool | None:
    """Say whether the UAVs were not all at their targets at once, and none moves any more; None if some still move."""
    if seen.values["arrival_s"] is not None:
        return False
    return True if seen.values["stuck"] else None


def halts_not_within(limit: float) -> Callable[[Observation], bool | None]:
    """Return what says that UAVs collide, or that one still moves `limit` (s) after the jam began."""

    def happens(seen: Observation) -> bool | None:
        halted = seen.values["halted_s"]
        # times are whole periods: half of one decides without rounding
        return True if halted is None or halted > limit + PERIOD_S / 2 else collides(seen)

    return happens


def whole_flight(seen: Observation) -> bool:
    """Select one observation of each flight through the formations: collisions in it are of the whole flight."""
    return seen.labels["formation"] == FORMATIONS[0]


def of_method(*methods: str, **labels: int) -> Callable[[Observation], bool]:
    """Return what selects flights by their method and by other labels."""
    return lambda seen: (
        seen.labels["method"] in methods and all(seen.labels[name] == label for name, label in labels.items())
    )


def claims_of(experiment: str) -> tuple[ExperimentClaim, ...]:
    """Return the claims about the experiment of this name."""
    return tuple(claim for claim in EXPERIMENT_CLAIMS if claim.experiment == experiment)


_REACHED = (
    "A formation is reached when all UAVs are at their targets at once; one that is not reached takes longer than any "
    "that is. The paper flew once: what it saw should be so in most runs."
)
_SAFE = "References of two UAVs never come closer than d_min = 0.12 m (scaled), at any time; tracking is exact."
_SEPARATED = "References are at least d̂_min = 0.25 m apart (scaled) at all multiples of T_c, decided exactly."
_CUS = "Section 5.3, Number of CUs; Fig. 3b"
_TRIGGERS = "Section 5.3, Event-Trigger; Fig. 3c"
_RECOVERING = of_method(MLR, PRINTED)
_SUMS = in_all(with_trigger("DT")), in_all(with_trigger("HT"))

EXPERIMENT_CLAIMS: tuple[ExperimentClaim, ...] = (
    ExperimentClaim(
        "fig3b-two-beat-one",
        "fig3b",
        "Increasing the number of CUs accelerates the formation changes: two are faster than one.",
        _CUS,
        f"The times to all four formations are summed. {_REACHED}",
        Ordering((Comparison("all formations", in_all(with_cus(2)), in_all(with_cus(1))),), 1),
    ),
    ExperimentClaim(
        "fig3b-two-beat-one-each",
        "fig3b",
        "Increasing the number of CUs accelerates the formation changes: two are faster than one.",
        _CUS,
        f"More strictly: in each of the four formations. {_REACHED}",
        Ordering(in_formations(with_cus(2), with_cus(1)), 4),
    ),
    ExperimentClaim(
        "fig3b-three-beat-two",
        "fig3b",
        "Increasing the number of CUs accelerates the formation changes: three are faster than two.",
        _CUS,
        f"The times to all four formations are summed. {_REACHED}",
        Ordering((Comparison("all formations", in_all(with_cus(3)), in_all(with_cus(2))),), 1),
    ),
    ExperimentClaim(
        "fig3b-three-beat-two-each",
        "fig3b",
        "Increasing the number of CUs accelerates the formation changes: three are faster than two.",
        _CUS,
        f"More strictly: in each of the four formations. {_REACHED}",
        Ordering(in_formations(with_cus(3), with_cus(2)), 4),
    ),
    ExperimentClaim(
        "fig3b-diminishing",
        "fig3b",
        "The most significant improvement occurs from one to two CUs; a third yields diminishing returns.",
        _CUS,
        "The times to all four formations are summed; the sum falls less from two to three CUs than from one to two. "
        "A run in which a formation is not reached counts for neither side, since its gain is not known.",
        Ordering((Comparison("all formations", gain(2, 3), gain(1, 2)),), 1),
    ),
    ExperimentClaim(
        "fig3b-safe",
        "fig3b",
        "No collisions occur during any maneuvers, despite network latency and message loss.",
        "Section 5.2",
        f"Without loss, unless a variant has it. {_SAFE}",
        Never(whole_flight, collides),
    ),
    ExperimentClaim(
        "fig3c-rr-slowest",
        "fig3c",
        "In three of the four formations, the swarm using RR is the slowest to reach targets.",
        _TRIGGERS,
        f"With three CUs, in at least three formations, RR takes longer than both DT and HT. {_REACHED}",
        Ordering(in_formations(slower_of("DT", "HT"), with_trigger("RR")), 3),
    ),
    ExperimentClaim(
        "fig3c-similar",
        "fig3c",
        "DB and HT generally exhibit similar performance across formations.",
        _TRIGGERS,
        "With three CUs, the times to all four formations are summed (“generally”, “across formations”); the sums with "
        f"DT and HT differ by less than {SIMILAR:.0%} of the smaller one. {_REACHED}",
        Ordering((Comparison("all formations", apart(*_SUMS), similar(*_SUMS)),), 1),
    ),
    ExperimentClaim(
        "fig3c-ht-earlier",
        "fig3c",
        "With HT, some quadcopters reach targets earlier than others.",
        _TRIGGERS,
        "The sentence sets HT against DT: with three CUs, a quarter of the UAVs have reached their targets earlier "
        "with HT than with DT, in each formation, since no exception is named, and in most runs.",
        Ordering(in_formations(with_trigger("HT", "first_quarter_s"), with_trigger("DT", "first_quarter_s")), 4),
    ),
    ExperimentClaim(
        "fig3c-dt-together",
        "fig3c",
        "With DB, all quadcopters reach targets at approximately the same time.",
        _TRIGGERS,
        "The sentence sets DT against HT: with three CUs, the time between the first quarter's arrival and the last "
        "UAV's is shorter with DT than with HT, in each formation, since no exception is named, and in most runs.",
        Ordering(in_formations(with_trigger("DT", "spread_s"), with_trigger("HT", "spread_s")), 4),
    ),
    ExperimentClaim(
        "fig3c-safe",
        "fig3c",
        "No collisions occur during any maneuvers, despite network latency and message loss.",
        "Section 5.2",
        f"Without loss, unless a variant has it. {_SAFE}",
        Never(whole_flight, collides),
    ),
    ExperimentClaim(
        "fig4-ignoring-collides",
        "fig4",
        "With standard DMPC, two quadcopters collide, causing the swarm to fail its task.",
        "Section 5.4; Fig. 4",
        "Jammed for the first two seconds, as the caption says, and ignoring loss, the references of two UAVs come "
        "closer than d_min = 0.12 m (scaled) in at least one flight.",
        Sometimes(of_method(IGNORING, jam_rounds=TWO_SECONDS, jam_start=0), collides),
    ),
    ExperimentClaim(
        "fig4-ignoring-collides-later",
        "fig4",
        "With standard DMPC, two quadcopters collide, causing the swarm to fail its task.",
        "Section 5.4; Fig. 4",
        "Not said by the paper, and looked at beside it: the two seconds begin in any later round.",
        Sometimes(
            lambda seen: of_method(IGNORING, jam_rounds=TWO_SECONDS)(seen) and seen.labels["jam_start"] != 0, collides
        ),
    ),
    ExperimentClaim(
        "fig4-recovering-safe",
        "fig4",
        "Under MLR-DMPC control, all quadcopters remain safe.",
        "Section 5.4; Fig. 4",
        f"With jams of every length, whenever they begin. {_SAFE}",
        Never(_RECOVERING, collides),
    ),
    ExperimentClaim(
        "fig4-recovering-separated",
        "fig4",
        "Reference trajectories are d̂_min apart at samples, for arbitrary message loss.",
        "Section 4.3.2, Theorem 2",
        f"With jams of every length, whenever they begin. {_SEPARATED}",
        Never(_RECOVERING, too_close_at_samples),
    ),
    ExperimentClaim(
        "fig4-recovering-arrives",
        "fig4",
        "Under MLR-DMPC control, all quadcopters successfully exchange positions without collision.",
        "Section 5.4; Fig. 4",
        "With jams of two seconds, whenever they begin, all UAVs are at their targets at once. It is not so if none "
        "moves any more and some are not there; if some still move when the flight ends, it is undecided.",
        Never(of_method(MLR, PRINTED, jam_rounds=TWO_SECONDS), does_not_arrive),
    ),
    ExperimentClaim(
        "fig4-halts",
        "fig4",
        "For arbitrarily long message-loss periods, the UAVs would have come safely to a halt after the length of the "
        "prediction horizon.",
        "Section 5.4, last paragraph",
        f"The horizon ({HORIZON_S:g} s) counts from when the last new trajectory is followed: planned in the jam's "
        f"first round, it is followed from the next on. So {HORIZON_S + PERIOD_S:g} s after the jam began no UAV moves "
        "any more, and no two have collided.",
        Never(of_method(MLR, PRINTED, jam_rounds=FOR_EVER), halts_not_within(HORIZON_S + PERIOD_S)),
    ),
    ExperimentClaim(
        "loss-ignoring-collides",
        "loss",
        "Message loss may cause the collision avoidance guarantees provided by DMPC methods to fail.",
        "Section 1, C3",
        "In at least one flight that ignores independent loss, the references of two UAVs come closer than "
        "d_min = 0.12 m (scaled).",
        Sometimes(lambda seen: of_method(IGNORING)(seen) and seen.labels["loss_percent"] != 0, collides),
    ),
    ExperimentClaim(
        "loss-recovering-safe",
        "loss",
        "No collisions occur during any maneuvers, despite network latency and message loss.",
        "Section 5.2",
        f"MLR-DMPC with the guarded reading of Algorithms 1 and 2. {_SAFE}",
        Never(of_method(MLR), collides),
    ),
    ExperimentClaim(
        "loss-recovering-separated",
        "loss",
        "Reference trajectories are d̂_min apart at samples, for arbitrary message loss.",
        "Section 4.3.2, Theorem 2",
        f"MLR-DMPC with the guarded reading of Algorithms 1 and 2. {_SEPARATED}",
        Never(of_method(MLR), too_close_at_samples),
    ),
    ExperimentClaim(
        "loss-printed-safe",
        "loss",
        "The algorithm provably prevents collisions even under message loss.",
        "Section 6; Theorems 2 and 3",
        f"Algorithms 1 and 2 taken as printed, which says nothing of the authors' own flights. {_SAFE}",
        Never(of_method(PRINTED), collides),
    ),
    ExperimentClaim(
        "loss-printed-separated",
        "loss",
        "Reference trajectories are d̂_min apart at samples, for arbitrary message loss.",
        "Section 4.3.2, Theorem 2",
        f"Algorithms 1 and 2 taken as printed. {_SEPARATED}",
        Never(of_method(PRINTED), too_close_at_samples),
    ),
)
