"""The pages of a verification: the overview, and a page for each claim that has a run to show. One file each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import cast

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined, Template

from swarmproof.claims.claim import Recovers
from swarmproof.claims.reading import Reading
from swarmproof.claims.verdict import Verdict
from swarmproof.explore.decide import Decided, Result
from swarmproof.pages import phrases
from swarmproof.system import Scope, System
from swarmproof.systems import PACKAGES
from swarmproof.trace.replay import Replay

#: The page about one claim's run.
CounterexamplePage = Callable[[Decided, Replay, Result], str]

VERDICT_WORDS = {
    Verdict.HOLDS: "✓ holds",
    Verdict.VIOLATED: "✗ violated",
    Verdict.UNDECIDED: "? undecided",
    Verdict.NOT_APPLICABLE: "– not applicable",
}


@dataclass(frozen=True)
class SwitchView:
    """A switch on the page."""

    name: str
    value: str
    others: str
    about: str
    is_default: bool


def of_system(system: System, module: str, usual: str) -> object:
    """Return the module `pages.MODULE` of a system's package, or the module `usual` if it has no such pages."""
    own = f"swarmproof.{PACKAGES[system.name]}.pages.{module}"
    try:
        has_own = find_spec(own) is not None
    except ModuleNotFoundError:  # it has no pages at all
        has_own = False
    return import_module(own if has_own else usual)


def counterexample_page(decided: Decided, replayed: Replay, result: Result) -> str:
    """Return the page about the run that violates (or, of a Reachable, reaches) a claim, as its system draws it."""
    module = of_system(replayed.system, "counterexample", "swarmproof.pages.run")
    page = cast(CounterexamplePage, module.counterexample_page)  # type: ignore[attr-defined]
    return page(decided, replayed, result)


def overview_page(result: Result, pages: Mapping[str, str], above: str = "") -> str:
    """Return the page with all verdicts; `pages` has the relative link to each claim's page, `above` to a matrix."""
    return template("overview.html.j2").render(
        claims=result.claims,
        pages=pages,
        above=above,
        verdict_words=VERDICT_WORDS,
        witness_rounds={seen.id: None if seen.trace is None else len(seen.trace.rounds) for seen in result.witnesses},
        violated=[decided.claim.id for decided in result.claims if decided.verdict is Verdict.VIOLATED],
        **about_scope(result),
    )


def template(name: str, package: str = "swarmproof.pages") -> Template:
    """Return the page template `name` of a package, which may extend ours; what it is given is escaped."""
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(one) for one in dict.fromkeys((package, "swarmproof.pages"))]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["phrases"] = phrases
    return environment.get_template(name)


def about_scope(result: Result) -> dict[str, object]:
    """Return what every page says of the scope of its verdicts."""
    scope = result.scope
    return {
        "result": result,
        "scope": scope,
        "paper": scope.system.paper,
        "semantics_name": scope.reading.name(),
        "switches": switches(scope.reading),
        "abstracted": scope.system.abstracted,
        "explored": _explored(result),
        "swarm": _swarm(scope),
    }


def switches(reading: Reading) -> list[SwitchView]:
    """Return the switches of a reading, with what each is about."""
    known, about = reading.switches(), reading.about()
    return [
        SwitchView(
            name,
            value,
            ", ".join(other for other in known[name] if other != value),
            about[name],
            value == known[name][0],
        )
        for name, value in reading.as_dict().items()
    ]


def _swarm(scope: Scope) -> str:
    parts = [(size.symbol, scope.sizes[size.name], size.noun.removesuffix("s")) for size in scope.system.sizes]
    return ", ".join(f"{symbol} = {phrases.count(number, noun)}" for symbol, number, noun in parts)


def _explored(result: Result) -> str:
    size = f"{phrases.count(result.states, 'state')} within {phrases.count(result.depth, 'round')}, "
    size += phrases.count(result.transitions, "transition")
    if result.stopped is None:
        return f"Fixpoint: every reachable state was seen ({size})."
    return f"No fixpoint: the exploration stopped early ({result.stopped}) after {size}; more states may be reachable."


def length(replayed: Replay) -> str:
    """Return how long a run is and what it loses, in words."""
    lost, loop = phrases.losses(replayed.lost_messages), replayed.trace.loop_start
    rounds = len(replayed.events)
    if loop is not None:
        way = f"after {phrases.count(loop, 'round')}" if loop else "from the very start"
        return f"{way}, a loop of {phrases.count(rounds - loop, 'round')}; {lost} before it, none in it"
    return f"after {phrases.count(rounds, 'round')}, {lost}"


def minimal(decided: Decided, result: Result) -> str:
    """Return in which sense no run is shorter, as a sentence."""
    if isinstance(decided.claim.question, Recovers):
        kind = "a loop that no choices avoid" if decided.avoidable is False else "such a loop"
        return f"No run of fewer rounds leads into {kind}."
    if result.fixpoint:
        return "No shorter run shows it, and no run of this length that loses fewer messages."
    return "No shorter run shows it."
