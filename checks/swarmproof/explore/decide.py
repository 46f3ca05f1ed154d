"""From an exploration to verdicts: *holds* only at a fixpoint, *violated* with the shortest way, else *undecided*."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, Claim, Kind
from swarmproof.dmpc_swarm.claims.witnesses import RECOVERY_LEFT, WITNESSES
from swarmproof.dmpc_swarm.concretise import follow
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.dmpc_swarm.protocol.swarm import initial_swarm
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.symmetry import MOST_CUS, Abstraction
from swarmproof.errors import BadInput
from swarmproof.explore.recovery import decide_recovery
from swarmproof.explore.search import Exploration, Limits, Progress, explore
from swarmproof.monitor.watch import Watch
from swarmproof.trace.trace import Trace, record

#: Beyond these the search space is out of reach, and the packed keys are not made for it.
MOST_UAVS = 8


class Verdict(StrEnum):
    """What can be said of a claim."""

    HOLDS = "holds"
    VIOLATED = "violated"
    UNDECIDED = "undecided"
    NOT_APPLICABLE = "not-applicable"


@dataclass(frozen=True)
class Scope:
    """What a verdict is about."""

    uavs: int
    cus: int
    semantics: Semantics
    abstraction: Abstraction = Abstraction.ESSENTIAL

    def __post_init__(self) -> None:
        """Raise BadInput on numbers of UAVs or CUs that cannot be."""
        for name, number, most in (("UAVs", self.uavs, MOST_UAVS), ("CUs", self.cus, MOST_CUS)):
            if not 1 <= number <= most:
                raise BadInput(f"{number} {name} cannot be explored: choose 1 to {most}")


@dataclass(frozen=True)
class Decided:
    """A claim with its verdict.

    Attributes:
        why: what the verdict rests on, in words.
        rounds: the length of the shortest trace that shows it; of a lasso, up to the start of its loop.
        lost_messages: the losses in that trace.
        worst_rounds: of a recovery that holds, the most loss-free rounds that it takes; None if there is no bound.
        avoidable: of a recovery that does not hold, whether some choices recover from every reachable state.
        trace: the trace.
    """

    claim: Claim
    verdict: Verdict
    why: str
    rounds: int | None = None
    lost_messages: int | None = None
    worst_rounds: int | None = None
    avoidable: bool | None = None
    trace: Trace | None = None


@dataclass(frozen=True)
class Seen:
    """A witness of non-vacuity, with the run that shows it; None if no reachable state is one."""

    id: str
    wording: str
    trace: Trace | None


@dataclass(frozen=True)
class Result:
    """What one verification found.

    Attributes:
        stopped: why the exploration ended before its fixpoint; None at a fixpoint.
        transitions: (intermediate swarm, effect) pairs that were taken.
    """

    scope: Scope
    stopped: str | None
    states: int
    transitions: int
    depth: int
    seconds: float
    claims: tuple[Decided, ...]
    witnesses: tuple[Seen, ...] = field(default=())

    @property
    def fixpoint(self) -> bool:
        """Whether every reachable state was seen."""
        return self.stopped is None


def verify(
    scope: Scope,
    claims: Sequence[Claim] = CLAIMS,
    limits: Limits | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    on_phase: Callable[[str], None] = lambda _: None,
) -> Result:
    """Explore every loss pattern and decide `claims`.

    Args:
        scope: what the verdicts are to be about.
        claims: what to decide.
        limits: when to stop exploring.
        on_progress: called as the exploration goes on.
        on_phase: called with what is done after it, in words.

    An interrupt (KeyboardInterrupt) ends what is being done: the exploration, or the decision of one claim, which is
    then undecided. What was found before is returned.
    """
    rounds = Rounds(scope.uavs, scope.cus, scope.semantics, scope.abstraction)
    applicable = [claim for claim in claims if claim.applies_to(scope.semantics)]
    watch = Watch(rounds, applicable)
    exploration = explore(rounds, limits=limits, on_level=watch, on_progress=on_progress)
    transitions = rounds.steps
    decided = []
    for claim in claims:
        on_phase(f"deciding {claim.id}")
        decided.append(_decide_unless_interrupted(claim, scope, exploration, watch))
    on_phase("retelling the witnesses of non-vacuity")
    try:
        witnesses = _witnesses(scope, exploration, watch)
    except KeyboardInterrupt:
        witnesses = ()
    return Result(
        scope,
        exploration.stopped,
        len(exploration.keys),
        transitions,
        exploration.depth,
        exploration.seconds,
        tuple(decided),
        witnesses,
    )


def _decide_unless_interrupted(claim: Claim, scope: Scope, exploration: Exploration, watch: Watch) -> Decided:
    try:
        return _decide(claim, scope, exploration, watch)
    except KeyboardInterrupt:
        index = watch.first.get(claim.id)
        if claim.kind is Kind.SAFETY and index is not None:
            why = "a shortest run breaks it; it was not written down, since that was interrupted"
            depth = exploration.depth_of(index)
            return Decided(claim, Verdict.VIOLATED, why, depth, exploration.losses[index])
        return Decided(claim, Verdict.UNDECIDED, "its decision was interrupted")


def _decide(claim: Claim, scope: Scope, exploration: Exploration, watch: Watch) -> Decided:
    if not claim.applies_to(scope.semantics):
        return Decided(claim, Verdict.NOT_APPLICABLE, "it speaks of the selection of event_trigger=round-robin")
    if scope.cus < claim.least_cus:
        return Decided(claim, Verdict.NOT_APPLICABLE, f"it speaks of {claim.least_cus} CUs, and there is one")
    if claim.kind is Kind.RECOVERY:
        return _decide_recovery(claim, scope, exploration)
    undecided = Decided(claim, Verdict.UNDECIDED, f"the exploration stopped early: {exploration.stopped}")
    index = watch.first.get(claim.id)
    if claim.kind is Kind.SAFETY:
        if index is not None:
            return _with_trace(claim, Verdict.VIOLATED, "a shortest run breaks it", scope, exploration, index)
        if exploration.stopped is not None:
            return undecided
        return Decided(claim, Verdict.HOLDS, "true in every reachable state, for every message-loss pattern")
    if index is not None:
        return _with_trace(claim, Verdict.HOLDS, "a shortest run reaches it", scope, exploration, index)
    if exploration.stopped is not None:
        return undecided
    return Decided(claim, Verdict.VIOLATED, "no reachable state is such")


def _with_trace(
    claim: Claim, verdict: Verdict, why: str, scope: Scope, exploration: Exploration, index: int
) -> Decided:
    trace = _trace(scope, exploration, claim.id, exploration.path_to(index))
    depth = exploration.depth_of(index)
    return Decided(claim, verdict, why, depth, exploration.losses[index], trace=trace)


def _decide_recovery(claim: Claim, scope: Scope, exploration: Exploration) -> Decided:
    if exploration.stopped is not None:
        return Decided(claim, Verdict.UNDECIDED, f"the exploration stopped early: {exploration.stopped}")
    recovery = decide_recovery(exploration)
    if recovery.holds:
        why = "no loss-free cycle has a state in which some CU does not run"
        if recovery.worst_rounds is None:
            why += "; there is no bound, since the choices can put off the last recovery"
        return Decided(claim, Verdict.HOLDS, why, worst_rounds=recovery.worst_rounds)
    start = recovery.loop_start
    path = [exploration.keys[n] for n in recovery.lasso]
    avoidable = recovery.inevitable == 0
    why = (
        "without any loss the swarm can go round for ever; from every reachable state, other choices recover"
        if avoidable
        else f"from {recovery.inevitable} reachable states no choices lead back to all CUs running for good"
    )
    return Decided(
        claim,
        Verdict.VIOLATED,
        why,
        start,
        exploration.losses[recovery.lasso[start]],
        avoidable=avoidable,
        trace=_trace(scope, exploration, claim.id, path, start),
    )


def _trace(
    scope: Scope, exploration: Exploration, shows: str, path: Sequence[int], loop_start: int | None = None
) -> Trace:
    begin = initial_swarm(scope.uavs, scope.cus, scope.semantics)
    events = follow(exploration.rounds, begin, path, lossless_from=loop_start)
    return record(scope.uavs, scope.cus, scope.semantics, shows, events, loop_start)


def _witnesses(scope: Scope, exploration: Exploration, watch: Watch) -> tuple[Seen, ...]:
    seen = []
    for witness in WITNESSES:
        index = watch.first.get(witness.id)
        path = None if index is None else exploration.path_to(index)
        trace = None if path is None else _trace(scope, exploration, witness.id, path)
        seen.append(Seen(witness.id, witness.wording, trace))
    entered = watch.first.get("recovery-entered")
    left = None if entered is None else _until_running_again(exploration, exploration.path_to(entered))
    trace = None if left is None else _trace(scope, exploration, RECOVERY_LEFT, left)
    seen.append(Seen(RECOVERY_LEFT, "a CU that had left RUN_DMPC came back to it", trace))
    return tuple(seen)


def _until_running_again(exploration: Exploration, path: list[int]) -> list[int] | None:
    """Extend a way to a state with a CU in WAIT to the first state in which that CU runs again."""
    rounds = exploration.rounds

    def state(key: int, w: int) -> CuState:
        return rounds.controls.values[rounds.control_numbers(key)[w]].state

    waiting = [w for w in range(rounds.cus) if state(path[-1], w) is CuState.WAIT]
    found: list[int] = []

    def running_again(search: Exploration, begin: int) -> bool:
        found.extend(
            n
            for n in range(begin, len(search.keys))
            if any(state(search.keys[n], w) is CuState.RUN_DMPC for w in waiting)
        )
        return bool(found)

    search = explore(rounds, start=path[-1], on_level=running_again)
    return [*path, *search.path_to(found[0])[1:]] if found else None
