"""The page about a run of MLR-DMPC that violates, or reaches, a claim. One file without resources."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from swarmproof.dmpc_swarm.claims.predicates import all_running
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.causes import causes, what_is_false
from swarmproof.dmpc_swarm.pages.diagram import sequence_diagram
from swarmproof.dmpc_swarm.pages.loops import loop_causes
from swarmproof.dmpc_swarm.pages.story import RoundStory, tell
from swarmproof.dmpc_swarm.pages.swarm_run import SwarmRun
from swarmproof.dmpc_swarm.pages.tables import RoundTable, round_table
from swarmproof.dmpc_swarm.protocol.algorithm1 import may_plan
from swarmproof.explore.decide import Decided, Result
from swarmproof.pages import phrases
from swarmproof.pages.page import about_scope, length, minimal, template
from swarmproof.trace.replay import Replay


@dataclass(frozen=True)
class RoundView:
    """A round on the page."""

    k: int
    table: RoundTable
    story: RoundStory
    in_loop: bool
    is_last: bool
    broken: tuple[str, ...]


def counterexample_page(decided: Decided, replayed: Replay, result: Result) -> str:
    """Return the page about the run that violates (or, of a Reachable, reaches) a claim."""
    run = SwarmRun.of(replayed)
    last, loop = len(run.events), run.loop_start
    rounds = [
        RoundView(
            k,
            round_table(run, k),
            tell(run, k),
            loop is not None and loop <= k < last,
            k == last,
            tuple(what_is_false(run, one, k) for one in run.broken[k]),
        )
        for k in range(last + 1)
    ]
    return template("counterexample.html.j2", "swarmproof.dmpc_swarm.pages").render(
        decided=decided,
        claim=decided.claim,
        outcome="violated" if run.is_violation else "reached",
        is_violation=run.is_violation,
        length=length(replayed),
        shows=_shows(run),
        causes=loop_causes(run, decided) if loop is not None else causes(run, run.broken[last], last),
        minimal=minimal(decided, result),
        loop_start=loop,
        last=last,
        diagram=Markup(sequence_diagram(run)),  # it escapes what it writes
        rounds=rounds,
        **about_scope(result),
    )


def _shows(replayed: SwarmRun) -> list[str]:
    """Say in plain words what the run shows at its end."""
    last, loop = len(replayed.events), replayed.loop_start
    if loop is not None:
        running = [k for k in range(loop, last) if all_running(observe(replayed.swarms[k]))]
        never = "the CUs do not stay in RUN_DMPC together" if running else "the CUs are never all in RUN_DMPC"
        return [
            f"Nothing is lost from round {loop} on, but {phrases.rounds(loop, last - 1)} can repeat for ever: in round "
            f"{last} the swarm behaves as in round {loop}. In this loop {never}."
        ]
    if replayed.is_violation:
        return [what_is_false(replayed, one, last) for one in replayed.broken[last]]
    swarm = replayed.swarms[last]
    parts = []
    for cu in swarm.cus:
        plannable = may_plan(cu, last, len(swarm.cus))
        can = f"can plan {' or '.join(names.uav(i) for i in plannable)}" if plannable else "plans nobody"
        parts.append(f"{names.cu(cu.w)} is in {cu.state.name} and {can}")
    return [f"In the computation phase of round {last}, {phrases.listing(parts)}."]
