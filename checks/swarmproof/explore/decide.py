"""From an exploration to verdicts: *holds* only at a fixpoint, *violated* with the shortest way, else *undecided*."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from swarmproof.claims.claim import Always, Claim, Reachable, Recovers, Return, Witness
from swarmproof.claims.verdict import Verdict
from swarmproof.explore.concretise import follow
from swarmproof.explore.recovery import decide_recovery
from swarmproof.explore.search import Exploration, Limits, Progress, explore
from swarmproof.monitor.watch import Watch
from swarmproof.system import Scope
from swarmproof.trace.trace import Trace, record


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

    claim: Claim[Any]
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
    claims: Sequence[Claim[Any]] | None = None,
    limits: Limits | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    on_phase: Callable[[str], None] = lambda _: None,
) -> Result:
    """Explore every loss pattern and decide `claims`.

    Args:
        scope: what the verdicts are to be about.
        claims: what to decide; None for all claims of the system.
        limits: when to stop exploring.
        on_progress: called as the exploration goes on.
        on_phase: called with what is done after it, in words.

    An interrupt (KeyboardInterrupt) ends what is being done: the exploration, or the decision of one claim, which is
    then undecided. What was found before is returned.
    """
    rounds = scope.steps()
    claims = scope.system.claims if claims is None else claims
    applicable = [claim for claim in claims if claim.applies_to(scope.reading)]
    looked_for = [one for one in scope.system.witnesses if isinstance(one, Witness)]
    watch = Watch(rounds, scope.model().observe, applicable, looked_for)
    exploration = explore(rounds, limits=limits, on_level=watch, on_progress=on_progress)
    transitions = rounds.steps
    found = _Found(scope, exploration, watch)
    decided = []
    for claim in claims:
        on_phase(f"deciding {claim.id}")
        decided.append(found.decide_unless_interrupted(claim))
    on_phase("retelling the witnesses of non-vacuity")
    try:
        witnesses = tuple(found.seen(one) for one in scope.system.witnesses)
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


@dataclass(frozen=True)
class _Found:
    """What an exploration found, from which claims are decided."""

    scope: Scope
    exploration: Exploration
    watch: Watch

    def decide_unless_interrupted(self, claim: Claim[Any]) -> Decided:
        """Decide one claim; what an interrupt leaves open is undecided."""
        try:
            return self._decide(claim)
        except KeyboardInterrupt:
            index = self.watch.first.get(claim.id)
            if claim.is_safety and index is not None:
                why = "a shortest run breaks it; it was not written down, since that was interrupted"
                depth = self.exploration.depth_of(index)
                return Decided(claim, Verdict.VIOLATED, why, depth, self.exploration.losses[index])
            return Decided(claim, Verdict.UNDECIDED, "its decision was interrupted")

    def _decide(self, claim: Claim[Any]) -> Decided:
        if not claim.applies_to(self.scope.reading):
            return Decided(claim, Verdict.NOT_APPLICABLE, f"it speaks of {claim.speaks_of}")
        for size in self.scope.system.sizes:
            least = claim.least.get(size.name, 0)
            if self.scope.sizes[size.name] < least:
                there = (
                    "there is one" if self.scope.sizes[size.name] == 1 else f"there are {self.scope.sizes[size.name]}"
                )
                return Decided(claim, Verdict.NOT_APPLICABLE, f"it speaks of {least} {size.noun}, and {there}")
        stopped, index = self.exploration.stopped, self.watch.first.get(claim.id)
        undecided = Decided(claim, Verdict.UNDECIDED, f"the exploration stopped early: {stopped}")
        match claim.question:
            case Recovers():
                return self._decide_recovery(claim, claim.question) if stopped is None else undecided
            case Always():
                if index is not None:
                    return self._with_trace(claim, Verdict.VIOLATED, "a shortest run breaks it", index)
                holds = "true in every reachable state, for every message-loss pattern"
                return undecided if stopped is not None else Decided(claim, Verdict.HOLDS, holds)
            case Reachable():
                if index is not None:
                    return self._with_trace(claim, Verdict.HOLDS, "a shortest run reaches it", index)
                none = Decided(claim, Verdict.VIOLATED, "no reachable state is such")
                return undecided if stopped is not None else none

    def _with_trace(self, claim: Claim[Any], verdict: Verdict, why: str, index: int) -> Decided:
        trace = self._trace(claim.id, self.exploration.path_to(index))
        depth = self.exploration.depth_of(index)
        return Decided(claim, verdict, why, depth, self.exploration.losses[index], trace=trace)

    def _decide_recovery(self, claim: Claim[Any], question: Recovers[Any]) -> Decided:
        observe, exploration = self.scope.model().observe, self.exploration
        recovery = decide_recovery(exploration, lambda state: question.goal(observe(state)))
        if recovery.holds:
            why = f"no loss-free cycle has a state in which {question.unsettled}"
            if recovery.worst_rounds is None:
                why += "; there is no bound, since the choices can put off the last recovery"
            return Decided(claim, Verdict.HOLDS, why, worst_rounds=recovery.worst_rounds)
        start = recovery.loop_start
        path = [exploration.keys[n] for n in recovery.lasso]
        avoidable = recovery.inevitable == 0
        why = (
            "without any loss the swarm can go round for ever; from every reachable state, other choices recover"
            if avoidable
            else f"from {recovery.inevitable} reachable states no choices lead back to {question.settled} for good"
        )
        return Decided(
            claim,
            Verdict.VIOLATED,
            why,
            start,
            exploration.losses[recovery.lasso[start]],
            avoidable=avoidable,
            trace=self._trace(claim.id, path, start),
        )

    def _trace(self, shows: str, path: Sequence[int], loop_start: int | None = None) -> Trace:
        events = follow(self.scope.model(), self.exploration.rounds, path, lossless_from=loop_start)
        return record(self.scope, shows, events, loop_start)

    def seen(self, witness: Witness[Any] | Return[Any]) -> Seen:
        """Return a witness with a shortest run that shows it."""
        first = self.watch.first.get(witness.after if isinstance(witness, Return) else witness.id)
        path = None if first is None else self.exploration.path_to(first)
        if path is not None and isinstance(witness, Return):
            path = self._until_back(witness, path)
        return Seen(witness.id, witness.wording, None if path is None else self._trace(witness.id, path))

    def _until_back(self, witness: Return[Any], path: list[int]) -> list[int] | None:
        """Extend a way to a state with somebody away to the first state in which one of them is back."""
        rounds, observe = self.exploration.rounds, self.scope.model().observe
        away = witness.away(observe(rounds.unpack(path[-1])))
        found: list[int] = []

        def is_back(search: Exploration, begin: int) -> bool:
            keys = search.keys
            back = (n for n in range(begin, len(keys)) if away & witness.back(observe(rounds.unpack(keys[n]))))
            found.extend(back)
            return bool(found)

        search = explore(rounds, start=path[-1], on_level=is_back)
        return [*path, *search.path_to(found[0])[1:]] if found else None
