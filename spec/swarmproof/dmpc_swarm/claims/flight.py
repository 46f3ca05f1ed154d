"""The claims about flown swarms: Section 4.3.2 on what the planner really returned, and that the swarm arrives.

A flight is observed round by round (:class:`ObservedRound`), and once as a whole (:class:`ObservedFlight`). Distances
are scaled, ‖Θ⁻¹(p_j − p_i)‖₂, and squared, so that they are exact: no claim is decided by a rounded number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from operator import attrgetter
from typing import NamedTuple

from swarmproof.claims.closest import ClosestApproach
from swarmproof.dmpc_swarm.claims.predicates import Broken


class PlannedBy(NamedTuple):
    """In which round, and by which CU, a trajectory was planned (Section 4.2.1); round −1 is the hover at the start."""

    round: int
    cu: int

    def in_words(self) -> str:
        """Return what the trajectory is called."""
        return "hovering" if self.round < 0 else f"planned in round {self.round} by CU {self.cu}"


class Approach(NamedTuple):
    """The closest approach of some trajectories of different UAVs at the samples.

    Attributes:
        square: the exact squared distance in m².
        uavs: the two UAVs.
        planned: by whom the two trajectories were planned.
        time: of the sample, in s.
    """

    square: Fraction
    uavs: tuple[int, int]
    planned: tuple[PlannedBy, PlannedBy]
    time: Fraction


class ObservedAttempt(NamedTuple):
    """A CU tried to plan a UAV.

    Attributes:
        candidate: whether the old trajectory, shifted, satisfies (13) exactly.
        solved: whether a plan came out.
        why: if not, why.
    """

    cu: int
    uav: int
    candidate: bool
    solved: bool
    why: str


@dataclass(frozen=True, slots=True)
class ObservedRound:
    """Round k of a flight, at its end; approaches are None where there is no pair.

    Attributes:
        d_hat_min: d̂_min in m.
        known: of all trajectories in trackers of round k that are not deprecated (eq. 20).
        learned: the same in round k + 1 (eq. 21).
        both_new: of the trajectories planned in this round by CUs that both have both UAVs in A_ET(k).
        one_new: of one planned in this round, of UAV i, and one of D_j(k + 1), j not planned in this round.
        none_new_before: of D_i(k) and D_j(k), neither UAV planned in this round (eq. 18).
        none_new_after: of D_i(k + 1) and D_j(k + 1), neither UAV planned in this round (eq. 19).
        flown: of the references that the UAVs follow in this round, at its samples (eq. 23).
        underway: how many UAVs follow a trajectory that moves; the others hover.
    """

    k: int
    d_hat_min: Fraction
    known: Approach | None
    learned: Approach | None
    both_new: Approach | None
    one_new: Approach | None
    none_new_before: Approach | None
    none_new_after: Approach | None
    flown: Approach | None
    attempts: Sequence[ObservedAttempt]
    underway: int


@dataclass(frozen=True, slots=True)
class ObservedFlight:
    """A flight as a whole.

    Attributes:
        d_min: the distance that counts as a collision, in m.
        references: how close the references come between the samples, too.
        actual: the same for the UAVs' actual positions; None if they follow the references exactly.
        adopted: trajectories that UAVs adopted since the targets changed last, per UAV.
        patience: after how many of them the UAVs should have arrived.
        late: the UAVs that were not at their targets at the end.
        underway: in how many rounds some UAV followed a trajectory that moves.
    """

    d_min: Fraction
    references: ClosestApproach
    actual: ClosestApproach | None
    adopted: float
    patience: float
    late: Sequence[int]
    underway: int


ApproachOf = Callable[[ObservedRound], Approach | None]


def separated(approach: ApproachOf) -> Callable[[ObservedRound], list[Broken]]:
    """Return the predicate that the trajectories of which `approach` is the closest approach are d̂_min apart."""
    return lambda seen: _apart(approach(seen), seen.d_hat_min)


def lemma_4(seen: ObservedRound) -> list[Broken]:
    """Where no trajectory is new, separation in round k gives separation in round k + 1."""
    if _apart(seen.none_new_before, seen.d_hat_min):
        return []
    return _apart(seen.none_new_after, seen.d_hat_min)


def theorem_1(seen: ObservedRound) -> list[Broken]:
    """Where eq. (20) is true, the old trajectory is feasible."""
    return [
        Broken((attempt.cu,), attempt.uav, "eq. (20) is true, but the old trajectory breaks (13)")
        for attempt in _posed(seen)
        if not attempt.candidate
    ]


def unsolved(seen: ObservedRound) -> list[Broken]:
    """The feasible problems for which our planner found no plan: a limit of ours, which says nothing of Theorem 1."""
    return [
        Broken((attempt.cu,), attempt.uav, attempt.why)
        for attempt in _posed(seen)
        if attempt.candidate and not attempt.solved
    ]


def _posed(seen: ObservedRound) -> Sequence[ObservedAttempt]:
    """Return the problems (13) of a round for which eq. (20) is true."""
    return () if _apart(seen.known, seen.d_hat_min) else seen.attempts


def references_apart(seen: ObservedFlight) -> list[Broken]:
    """The references of any two UAVs are d_min apart at all times."""
    return _collides(seen.references, seen.d_min)


def actual_apart(seen: ObservedFlight) -> list[Broken]:
    """Any two UAVs are d_min apart at all times."""
    return [] if seen.actual is None else _collides(seen.actual, seen.d_min)


def arrives(seen: ObservedFlight) -> list[Broken]:
    """All UAVs reach their targets in time."""
    if not seen.late or seen.adopted < seen.patience:
        return []
    late = ", ".join(f"UAV {i}" for i in seen.late)
    return [
        Broken(
            (),
            None,
            f"{seen.adopted:.0f} new trajectories per UAV after the last target change, {late} had not arrived",
        )
    ]


def follows_references(seen: ObservedFlight) -> str:
    """The UAVs follow their references exactly, so that nothing is to be said of actual positions."""
    return "the UAVs follow their references exactly" if seen.actual is None else ""


def nobody_left(seen: ObservedFlight) -> str:
    """All UAVs hovered where they started, which the start's distance alone explains."""
    return "" if seen.underway else _NOBODY_LEFT


def too_few_trajectories(seen: ObservedFlight) -> str:
    """The network did not let the UAVs get as many new trajectories as the claim assumes, and some are late."""
    if not seen.late or seen.adopted >= seen.patience:
        return ""
    late = ", ".join(f"UAV {i}" for i in seen.late)
    return (
        f"its assumption fails: after the targets changed last, UAVs adopted {seen.adopted:.1f} new trajectories each, "
        f"{seen.patience:.0f} are needed; {late} had not arrived"
    )


def too_close_to_tell(dip_of: Callable[[ObservedFlight], ClosestApproach | None]) -> Callable[[ObservedFlight], str]:
    """Return what says that the closest approach is too close to d_min for our bounds to decide."""

    def why(seen: ObservedFlight) -> str:
        dip = dip_of(seen)
        if dip is None or dip.at_least is not None:
            return ""
        (i, j), d_min = dip.uavs, float(seen.d_min)
        return f"UAV {i} and UAV {j} come too close to {d_min:g} m at {dip.time:.3f} s to tell on which side they stay"

    return why


def _apart(approach: Approach | None, d_hat_min: Fraction) -> list[Broken]:
    if approach is None or approach.square >= d_hat_min**2:
        return []
    (i, j), (mine, other) = approach.uavs, approach.planned
    distance = float(approach.square) ** 0.5
    pair = f"UAV {i} ({mine.in_words()}) and UAV {j} ({other.in_words()})"
    return [Broken((), i, f"{pair} are {distance:.6g} m apart at {float(approach.time):.3f} s")]


def _collides(dip: ClosestApproach, d_min: Fraction) -> list[Broken]:
    if dip.at_least is not False:
        return []
    i, j = dip.uavs
    why = f"UAV {i} and UAV {j} are {dip.lower:.6g} m apart at {dip.time:.3f} s, less than {float(d_min):g} m"
    return [Broken((), i, why)]


@dataclass(frozen=True)
class FlightClaim:
    """One statement about a flight: `in_round` or `in_flight` is set, and returns the broken places.

    A claim that is broken nowhere may still have been about nothing, or our means may not decide it.

    Attributes:
        approach: the closest approach that the claim is about, if it is about one.
        about: of a claim about rounds, how many things in a round it speaks of.
        nothing: what there was not, where that is none in any round.
        unsolved: of a claim about rounds, where a limit of ours leaves it undecided.
        fails: of a claim about flights, why its assumption fails; empty if it does not.
        too_close: the same, why our bounds do not decide it; empty if they do.
        from_start: whether it assumes that the swarm begins as Remark 2 says.
    """

    id: str
    wording: str
    place: str
    assumptions: str
    in_round: Callable[[ObservedRound], list[Broken]] | None = None
    in_flight: Callable[[ObservedFlight], list[Broken]] | None = None
    approach: ApproachOf | None = None
    about: Callable[[ObservedRound], int] | None = None
    nothing: str = ""
    unsolved: Callable[[ObservedRound], list[Broken]] | None = None
    fails: Callable[[ObservedFlight], str] | None = None
    too_close: Callable[[ObservedFlight], str] | None = None
    from_start: bool = False


def _one_if(approach: ApproachOf) -> Callable[[ObservedRound], int]:
    """Return what counts a round in which there is such a pair."""
    return lambda seen: approach(seen) is not None


_NOBODY_LEFT = "no UAV followed a trajectory that moves: all hovered where they started"
_START = "All UAVs hover at the start, d̂_min apart (Remark 2); any messages may be lost."

FLIGHT_CLAIMS: tuple[FlightClaim, ...] = (
    FlightClaim(
        "tracked-separation",
        "Any two trajectories of different UAVs in trackers that are not deprecated are at least d̂_min apart at all "
        "samples of their horizon.",
        "eqs. (20) and (21), Section 4.3.2",
        _START,
        in_round=separated(attrgetter("learned")),
        approach=attrgetter("learned"),
        about=_one_if(attrgetter("learned")),
        nothing="after no round did valid trackers hold trajectories of two UAVs",
        from_start=True,
    ),
    FlightClaim(
        "theorem-1",
        "Where eq. (20) is true, the optimization problem (13) is feasible.",
        "Theorem 1, Section 4.3.2",
        _START + " The old trajectory, shifted, is the proof's candidate.",
        in_round=theorem_1,
        about=lambda seen: len(_posed(seen)),
        nothing="no CU posed a problem (13) with eq. (20) true",
        unsolved=unsolved,
    ),
    FlightClaim(
        "corollary-1",
        "Two trajectories that CUs plan in one round, both UAVs in A_ET(k), are at least d̂_min apart at all samples.",
        "Corollary 1, eq. (16)",
        "Both satisfy (13f).",
        in_round=separated(attrgetter("both_new")),
        approach=attrgetter("both_new"),
        about=_one_if(attrgetter("both_new")),
        nothing="in no round were two trajectories planned by CUs that both had both UAVs in A_ET(k)",
    ),
    FlightClaim(
        "lemma-3",
        "A trajectory planned in round k is at least d̂_min apart, at all samples, from all entries of D_j(k+1) of a "
        "UAV j that was not planned.",
        "Lemma 3, eq. (17)",
        "It satisfies (13f).",
        in_round=separated(attrgetter("one_new")),
        approach=attrgetter("one_new"),
        about=_one_if(attrgetter("one_new")),
        nothing="in no round was a trajectory planned beside a valid tracker of another UAV",
    ),
    FlightClaim(
        "lemma-4",
        "For two UAVs that were not planned in round k, separation of the entries of D(k) gives separation of those of "
        "D(k+1).",
        "Lemma 4, eqs. (18) and (19)",
        _START + " Eq. (18). The conclusion is read at the samples of eq. (21), one round later than those of (18).",
        in_round=lemma_4,
        approach=attrgetter("none_new_after"),
        about=lambda seen: seen.none_new_after is not None and not _apart(seen.none_new_before, seen.d_hat_min),
        nothing="in no round was eq. (18) true and had two UAVs without new trajectories valid trackers after it",
        # a tracker that becomes valid again brings in what the UAV follows, of which (18) said nothing
        from_start=True,
    ),
    FlightClaim(
        "theorem-2",
        "The references of any two UAVs are at least d̂_min apart at all multiples of T_c.",
        "Theorem 2, eq. (23)",
        _START,
        in_round=separated(attrgetter("flown")),
        approach=attrgetter("flown"),
        about=lambda seen: bool(seen.underway),
        nothing=_NOBODY_LEFT,
        from_start=True,
    ),
    FlightClaim(
        "eq-2",
        "The references of any two UAVs are at least d_min apart at all times, between the samples, too.",
        "Eq. (2), claimed by Theorem 3",
        _START + " The UAVs follow their references exactly.",
        in_flight=references_apart,
        fails=nobody_left,
        too_close=too_close_to_tell(attrgetter("references")),
        from_start=True,
    ),
    FlightClaim(
        "eq-2-actual",
        "Any two UAVs are at least d_min apart at all times.",
        "Eq. (2), claimed by Theorem 3, with Assumption 1",
        _START + " No UAV is further from its reference than the tracking error.",
        in_flight=actual_apart,
        fails=follows_references,
        too_close=too_close_to_tell(attrgetter("actual")),
        from_start=True,
    ),
    FlightClaim(
        "arrives",
        "All UAVs come within 5 cm of their targets.",
        "Eq. (1); no statement of the paper proves it",
        "The targets do not change, and the network lets UAVs get 50 new trajectories each, on average.",
        in_flight=arrives,
        fails=too_few_trajectories,
    ),
)
