"""The pages of a report: one per claim that has a run to show, and the overview. Each is one file without resources."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from jinja2 import Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup

from swarmproof.dmpc_swarm.claims.predicates import all_running
from swarmproof.dmpc_swarm.claims.protocol import Kind
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.causes import causes, what_is_false
from swarmproof.dmpc_swarm.pages.diagram import sequence_diagram
from swarmproof.dmpc_swarm.pages.loops import loop_causes
from swarmproof.dmpc_swarm.pages.story import RoundStory, tell
from swarmproof.dmpc_swarm.pages.tables import RoundTable, round_table
from swarmproof.dmpc_swarm.protocol.algorithm1 import may_plan
from swarmproof.dmpc_swarm.semantics import ABOUT, SWITCHES, Semantics
from swarmproof.dmpc_swarm.symmetry import Abstraction
from swarmproof.explore.decide import Decided, Result, Scope, Verdict
from swarmproof.trace.trace import Replay

PAPER = "DMPC-Swarm (Gräfe, Eickhoff, Zimmerling, Trimpe)"

_OPAQUE = (
    "Trajectories are opaque: what is computed in them (the QP, positions, time within a round) is left out, and only "
    "their metadata, calculation round and CU, can be compared. Messages arrive in their round or never."
)
_ABSTRACTED = {
    Abstraction.ESSENTIAL: "Swarms that differ only in the names of trajectories are one state, and of a deprecated "
    "tracker only what can still matter is distinguished.",
    Abstraction.COUNTED: "Swarms that differ only in the names of trajectories are one state, and of three or more "
    "interchangeable trajectories in trackers two are kept.",
    Abstraction.NOTHING: "Swarms that differ only in the names of trajectories are one state; nothing else is merged.",
}


@dataclass(frozen=True)
class SwitchView:
    """A semantics switch on the page."""

    name: str
    value: str
    others: str
    about: str
    is_default: bool


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
    """Return the page about the run that violates (or, of a claim of kind REACHABLE, reaches) a claim."""
    last, loop = len(replayed.events), replayed.trace.loop_start
    broken = {k: replayed.broken_at(k) for k in range(last + 1)}
    rounds = [
        RoundView(
            k,
            round_table(replayed, k),
            tell(replayed, k),
            loop is not None and loop <= k < last,
            k == last,
            tuple(what_is_false(replayed, one, k) for one in broken[k]),
        )
        for k in range(last + 1)
    ]
    return template("counterexample.html.j2").render(
        decided=decided,
        claim=decided.claim,
        paper=PAPER,
        outcome="violated" if replayed.is_violation else "reached",
        is_violation=replayed.is_violation,
        length=_length(replayed),
        shows=_shows(replayed),
        causes=loop_causes(replayed, decided) if loop is not None else causes(replayed, broken[last], last),
        minimal=_minimal(decided, result),
        loop_start=loop,
        last=last,
        diagram=Markup(sequence_diagram(replayed)),  # it escapes what it writes
        rounds=rounds,
        **_about_scope(result),
    )


def overview_page(result: Result, pages: Mapping[str, str], above: str = "") -> str:
    """Return the page with all verdicts; `pages` has the relative link to each claim's page, `above` to a matrix."""
    return template("overview.html.j2").render(
        claims=result.claims,
        pages=pages,
        above=above,
        paper=PAPER,
        verdict_words={verdict: _VERDICT_WORDS[verdict] for verdict in Verdict},
        witness_rounds={seen.id: None if seen.trace is None else len(seen.trace.rounds) for seen in result.witnesses},
        violated=[decided.claim.id for decided in result.claims if decided.verdict is Verdict.VIOLATED],
        **_about_scope(result),
    )


_VERDICT_WORDS = {
    Verdict.HOLDS: "✓ holds",
    Verdict.VIOLATED: "✗ violated",
    Verdict.UNDECIDED: "? undecided",
    Verdict.NOT_APPLICABLE: "– not applicable",
}


def template(name: str) -> Template:
    """Return the page template `name`; what it is given is escaped."""
    environment = Environment(
        loader=PackageLoader("swarmproof.pages"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["names"] = names
    return environment.get_template(name)


def _about_scope(result: Result) -> dict[str, object]:
    scope = result.scope
    return {
        "result": result,
        "scope": scope,
        "semantics_name": scope.semantics.name(),
        "switches": _switches(scope.semantics),
        "abstracted": f"{_OPAQUE} {_ABSTRACTED[scope.abstraction]}",
        "explored": _explored(result),
        "swarm": _swarm(scope),
    }


def _switches(semantics: Semantics) -> list[SwitchView]:
    return [
        SwitchView(
            name,
            value,
            ", ".join(other for other in SWITCHES[name] if other != value),
            ABOUT[name],
            value == SWITCHES[name][0],
        )
        for name, value in semantics.as_dict().items()
    ]


def _swarm(scope: Scope) -> str:
    return f"N = {names.count(scope.uavs, 'UAV')}, M = {names.count(scope.cus, 'CU')}"


def _explored(result: Result) -> str:
    size = f"{names.count(result.states, 'state')} within {names.count(result.depth, 'round')}, "
    size += names.count(result.transitions, "transition")
    if result.stopped is None:
        return f"Fixpoint: every reachable state was seen ({size})."
    return f"No fixpoint: the exploration stopped early ({result.stopped}) after {size}; more states may be reachable."


def _length(replayed: Replay) -> str:
    lost, loop = names.losses(replayed.lost_messages), replayed.trace.loop_start
    rounds = len(replayed.events)
    if loop is not None:
        way = f"after {names.count(loop, 'round')}" if loop else "from the very start"
        return f"{way}, a loop of {names.count(rounds - loop, 'round')}; {lost} before it, none in it"
    return f"after {names.count(rounds, 'round')}, {lost}"


def _minimal(decided: Decided, result: Result) -> str:
    if decided.claim.kind is Kind.RECOVERY:
        kind = "a loop that no choices avoid" if decided.avoidable is False else "such a loop"
        return f"No run of fewer rounds leads into {kind}."
    if result.fixpoint:
        return "No shorter run shows it, and no run of this length that loses fewer messages."
    return "No shorter run shows it."


def _shows(replayed: Replay) -> list[str]:
    """Say in plain words what the run shows at its end."""
    last, loop = len(replayed.events), replayed.trace.loop_start
    if loop is not None:
        running = [k for k in range(loop, last) if all_running(observe(replayed.swarms[k]))]
        never = "the CUs do not stay in RUN_DMPC together" if running else "the CUs are never all in RUN_DMPC"
        return [
            f"Nothing is lost from round {loop} on, but {names.rounds(loop, last - 1)} can repeat for ever: in round "
            f"{last} the swarm behaves as in round {loop}. In this loop {never}."
        ]
    if replayed.is_violation:
        return [what_is_false(replayed, one, last) for one in replayed.broken_at(last)]
    swarm = replayed.swarms[last]
    parts = []
    for cu in swarm.cus:
        plannable = may_plan(cu, last, len(swarm.cus))
        can = f"can plan {' or '.join(names.uav(i) for i in plannable)}" if plannable else "plans nobody"
        parts.append(f"{names.cu(cu.w)} is in {cu.state.name} and {can}")
    return [f"In the computation phase of round {last}, {names.listing(parts)}."]
