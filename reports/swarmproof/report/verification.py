"""The report of a verification: an overview, a page and a trace for each counterexample, the verdicts."""

from __future__ import annotations

from swarmproof.output import ReportFolder
from swarmproof.report.page import counterexample_page, overview_page
from swarmproof.report.verdicts import as_json
from swarmproof.traces.trace import encode, replay
from swarmproof.verify.decide import Result


def put_result(folder: ReportFolder, result: Result, within: str = "") -> dict[str, str]:
    """Put pages, traces and verdicts of `result` into `folder`, and return the trace's file of each claim with one.

    Every trace is replayed on the readable model before its page is drawn.

    Args:
        folder: where they go.
        result: what was found.
        within: a folder in `folder`, with a `/` at its end; empty for `folder` itself.

    Returns:
        names that are relative to the folder of the verdicts, so that it can be moved.
    """
    traces: dict[str, str] = {}
    pages: dict[str, str] = {}
    for decided in result.claims:
        if decided.trace is None:
            continue
        traces[decided.claim.id] = f"{decided.claim.id}.trace.json"
        folder.put(within + traces[decided.claim.id], encode(decided.trace))
        pages[decided.claim.id] = f"{decided.claim.id}.html"
        folder.put(within + pages[decided.claim.id], counterexample_page(decided, replay(decided.trace), result))
    for seen in result.witnesses:
        if seen.trace is not None:
            folder.put(f"{within}witness-{seen.id}.trace.json", encode(seen.trace))
    folder.put(within + "verdicts.json", as_json(result, traces))
    folder.put(within + "index.html", overview_page(result, pages))
    return traces
