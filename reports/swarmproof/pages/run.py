"""The plain page of a run, for any system: round by round what each node holds, what is chosen, what is lost."""

from __future__ import annotations

from dataclasses import dataclass

from swarmproof.claims.claim import Recovers
from swarmproof.explore.decide import Decided, Result
from swarmproof.pages import phrases
from swarmproof.pages.page import about_scope, length, minimal, template
from swarmproof.trace.replay import Replay


@dataclass(frozen=True)
class Row:
    """What one node holds in a round, and whether that changed since the round before."""

    who: str
    holds: str
    changed: bool


@dataclass(frozen=True)
class RoundView:
    """A round: its state, what happens in it (nothing in the last), and where the claim is false."""

    k: int
    rows: tuple[Row, ...]
    events: tuple[str, ...]
    in_loop: bool
    is_last: bool
    broken: tuple[str, ...]


def rounds_of(replayed: Replay) -> list[RoundView]:
    """Return the rounds of a run, in order."""
    last, loop = len(replayed.events), replayed.trace.loop_start
    told = []
    before: dict[str, str] = {}
    for k in range(last + 1):
        now = dict(replayed.model.tell_state(replayed.states[k]))
        told.append(
            RoundView(
                k,
                tuple(Row(who, holds, k > 0 and before.get(who) != holds) for who, holds in now.items()),
                tuple(replayed.model.tell_event(replayed.sent[k], replayed.events[k])) if k < last else (),
                loop is not None and loop <= k < last,
                k == last,
                tuple(f"{one.where}: {one.why}" if one.where else one.why for one in replayed.broken_at(k)),
            )
        )
        before = now
    return told


def shown(replayed: Replay) -> list[str]:
    """Return what a run shows at its end, in sentences."""
    last, loop = len(replayed.events), replayed.trace.loop_start
    if loop is not None:
        return [
            f"Nothing is lost from round {loop} on, but {phrases.rounds(loop, last - 1)} can repeat for ever: in round "
            f"{last} the system behaves as in round {loop}. {_unsettled(replayed, loop, last)}"
        ]
    broken = rounds_of(replayed)[-1].broken
    return [f"In round {last}, {one}." for one in broken] or [f"It is reached in round {last}."]


def _unsettled(replayed: Replay, loop: int, last: int) -> str:
    """Return in which rounds of a loop the goal is false, as a sentence."""
    claim = replayed.claim
    assert claim is not None
    assert isinstance(claim.question, Recovers)
    rounds = [str(k) for k in range(loop, last) if not claim.question.goal(replayed.observed(k))]
    noun = "round" if len(rounds) == 1 else "rounds"
    return f"In {noun} {phrases.listing(rounds)} of this loop, {claim.question.unsettled}."


def counterexample_page(decided: Decided, replayed: Replay, result: Result) -> str:
    """Return the page about the run that violates (or, of a Reachable, reaches) a claim."""
    return template("run.html.j2").render(
        claim=decided.claim,
        decided=decided,
        outcome="violated" if replayed.is_violation else "reached",
        is_violation=replayed.is_violation,
        length=length(replayed),
        shows=shown(replayed),
        minimal=minimal(decided, result),
        rounds=rounds_of(replayed),
        **about_scope(result),
    )
