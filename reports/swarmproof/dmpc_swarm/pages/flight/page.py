"""The page about one flight, with its pictures in it: one file without resources, and the pictures beside it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from markupsafe import Markup

from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.flight.judge import Flown
from swarmproof.dmpc_swarm.flight.log import Log, Outcome
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.flight import facts as flight_facts
from swarmproof.dmpc_swarm.pages.flight import words as flight_words
from swarmproof.dmpc_swarm.pages.flight.plots import Picture, check_available, pictures
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.dmpc_swarm.semantics import PAPER
from swarmproof.output import ReportFolder
from swarmproof.pages.page import template

__all__ = ["check_available", "put_flight"]

#: Attempts without a plan that are listed; of the others, it is said how many there are.
MOST_LISTED = 12
_VERDICT_WORDS = {
    Verdict.VIOLATED: ("✗ violated", "bad"),
    Verdict.NOT_VIOLATED: ("✓ not violated", "good"),
    Verdict.UNDECIDED: ("? undecided", "dim"),
    Verdict.NOT_APPLICABLE: ("– not applicable", "dim"),
}


@dataclass(frozen=True)
class CuView:
    """What one CU did: in how many rounds it was in each state, and what became of its attempts to plan."""

    name: str
    states: tuple[int, ...]
    outcomes: tuple[int, ...]


@dataclass(frozen=True)
class Told:
    """How the first violation of some claims came about: topic (may be empty) and text of each line."""

    claims: tuple[str, ...]
    lines: tuple[tuple[str, str], ...]


def put_flight(
    folder: ReportFolder, setting: Setting, loss: str, flown: Flown, log: Log, search: Sequence[str] = ()
) -> None:
    """Put the report of a flight into `folder`: its page and pictures.

    Args:
        folder: where `index.html` and the pictures go.
        setting: what was flown.
        loss: the loss model, as the user wrote it.
        flown: what became of the claims.
        log: all rounds of the flight, at least one.
        search: how the losses were found, and whether that was stopped, if they were searched for.

    Raises:
        BadInput: there is no matplotlib.
    """
    check_available()
    drawn = pictures(flown, log)
    for picture in drawn:
        folder.put(f"{picture.name}.svg", picture.svg)
    folder.put("index.html", flight_page(setting, loss, flown, log, drawn, search))


def flight_page(
    setting: Setting, loss: str, flown: Flown, log: Log, drawn: list[Picture], search: Sequence[str] = ()
) -> str:
    """Return the page, with the pictures `drawn` in it."""
    chains = _chains(flown)
    failed = [attempt for logged in log.rounds for attempt in logged.replanned if attempt.why]
    return template("flight.html.j2", "swarmproof.dmpc_swarm.pages").render(
        paper=PAPER,
        headline=flight_words.headline(setting, flown),
        figures=flight_words.summary(setting, flown),
        scope=flight_words.scope(setting, loss, flown),
        facts=flight_facts.rows(setting, loss, flown),
        violations=flight_facts.violations(flown),
        claims=flown.claims,
        violated=[judged for judged in flown.claims if judged.verdict is Verdict.VIOLATED],
        undecided=[judged for judged in flown.claims if judged.verdict is Verdict.UNDECIDED],
        idle=flown.last_adoption is None,
        stopped=flown.stopped,
        collision=flight_words.collision(setting, flown),
        search=search,
        verdict_words=_VERDICT_WORDS,
        chains=chains,
        chain_of={claim: told.claims[0] for told in chains for claim in told.claims},
        pictures=[(picture, inlined(picture)) for picture in drawn],
        states=[state.name for state in CuState],
        outcomes=list(Outcome),
        cus=_cus(setting.cus, log),
        failed=failed[:MOST_LISTED],
        more_failed=len(failed) - len(failed[:MOST_LISTED]),
    )


def inlined(picture: Picture) -> Markup:
    """Return a picture as an element of a page: with identifiers of its own, and with what it shows in words."""
    root, begin, rest = picture.svg[picture.svg.index("<svg") :].partition(">")
    # on a small screen the picture is scrolled: it would be illegible if it fitted
    root = re.sub(r' (?:width|height)="[^"]*"', "", root)
    root += f' role="img" aria-label="{escape(picture.alt)}" style="width: 100%; min-width: 820px; height: auto"'
    rest = re.sub(r'( id="|href="#|url\(#)', rf"\1{picture.name}-", rest)
    return Markup(root + begin + rest)


def _chains(flown: Flown) -> list[Told]:
    """Return the chains of violated claims; claims with the same first violation share one."""
    claims: dict[tuple[str, ...], list[str]] = {}
    for judged in flown.claims:
        if judged.chain:
            claims.setdefault(judged.chain, []).append(judged.claim.id)
    return [Told(tuple(some), tuple(_line(sentence) for sentence in chain)) for chain, some in claims.items()]


def _line(sentence: str) -> tuple[str, str]:
    """Return the topic with which a sentence begins, up to the first colon, and the rest."""
    topic, colon, text = sentence.partition(": ")
    return (topic, text) if colon and topic.count(" ") <= 1 else ("", sentence)


def _cus(cus: int, log: Log) -> list[CuView]:
    views = []
    for w in range(cus):
        states = Counter(logged.states[w] for logged in log.rounds)
        outcomes = Counter(attempt.outcome for logged in log.rounds for attempt in logged.replanned if attempt.cu == w)
        views.append(
            CuView(names.cu(w), tuple(states[state] for state in CuState), tuple(outcomes[one] for one in Outcome))
        )
    return views
