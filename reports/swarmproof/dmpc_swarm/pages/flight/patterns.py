"""The page of an exhaustive flight, and the losses behind each violation as a script that can be flown again."""

from __future__ import annotations

from swarmproof.dmpc_swarm.flight.exhaustive import Exhaustive, PatternVerdict
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.pages.flight import words as flight_words
from swarmproof.faults.pattern import lost_in
from swarmproof.faults.script import script_text
from swarmproof.output import ReportFolder
from swarmproof.pages.page import template

_TAGS = {
    PatternVerdict.HOLDS: "good",
    PatternVerdict.VIOLATED: "bad",
    PatternVerdict.UNDECIDED: "dim",
    PatternVerdict.NOT_APPLICABLE: "dim",
}


def put_patterns(folder: ReportFolder, setting: Setting, rounds: int, found: Exhaustive) -> None:
    """Put ``index.html`` and, for each violated claim, ``CLAIM.losses.json`` into `folder`."""
    for decided in found.claims:
        if decided.verdict is PatternVerdict.VIOLATED:
            losses = [lost_in(flown.at_cus, flown.at_uavs) for flown in decided.cause]
            folder.put(f"{decided.claim.id}.losses.json", script_text(losses, setting.scenario.uavs, setting.cus))
    page = template("flight_patterns.html.j2", "swarmproof.dmpc_swarm.pages").render(
        headline=flight_words.patterns_headline(setting, rounds, found),
        violated=found.violated,
        stopped=found.stopped,
        collision=flight_words.collision(setting, found),
        summary=flight_words.patterns_summary(found),
        claims=found.claims,
        tags=_TAGS,
        growth=list(zip(found.patterns, found.swarms[1:], strict=True)),
        scope=flight_words.patterns_scope(setting, rounds, found),
    )
    folder.put("index.html", page)
