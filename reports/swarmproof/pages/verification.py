"""The report of a verification: an overview, a page and a trace for each counterexample, the verdicts."""

from __future__ import annotations

from swarmproof.explore.decide import Result
from swarmproof.formats.verdicts import as_json
from swarmproof.output import ReportFolder
from swarmproof.pages.page import counterexample_page, overview_page
from swarmproof.trace.replay import replay
from swarmproof.trace.trace import encode


def traces_of(result: Result) -> dict[str, str]:
    """Return the name of the trace's file of each claim with one, relative to the folder, so that it can be moved."""
    return {
        decided.claim.id: f"{decided.claim.id}.trace.json" for decided in result.claims if decided.trace is not None
    }


def put_result(folder: ReportFolder, result: Result, within: str = "") -> None:
    """Put pages, traces and verdicts of `result` into `folder`.

    Every trace is replayed on the readable model before its page is drawn.

    Args:
        folder: where they go.
        result: what was found.
        within: a folder in `folder`, with a `/` at its end; empty for `folder` itself.
    """
    traces = traces_of(result)
    pages: dict[str, str] = {}
    for decided in result.claims:
        if decided.trace is None:
            continue
        folder.put(within + traces[decided.claim.id], encode(decided.trace))
        pages[decided.claim.id] = f"{decided.claim.id}.html"
        folder.put(within + pages[decided.claim.id], counterexample_page(decided, replay(decided.trace), result))
    for seen in result.witnesses:
        if seen.trace is not None:
            folder.put(f"{within}witness-{seen.id}.trace.json", encode(seen.trace))
    folder.put(within + "verdicts.json", as_json(result, traces))
    folder.put(within + "index.html", overview_page(result, pages, above="../index.html" if within else ""))
