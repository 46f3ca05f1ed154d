"""Writes what a verification found into a folder: an overview, a page and a trace per counterexample, the verdicts."""

from __future__ import annotations

import tempfile
from pathlib import Path

from swarmproof.claims.registry import CLAIMS
from swarmproof.errors import BadInput
from swarmproof.report.page import counterexample_page, overview_page
from swarmproof.report.verdicts import as_json
from swarmproof.traces.trace import encode, replay
from swarmproof.verify.decide import Result


def claim_folder(folder: Path) -> Path:
    """Make `folder` if need be, and make sure that it can be written to, before anything is computed.

    Raises:
        BadInput: it cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BadInput(f"cannot write to {folder}: {error.strerror}; give a folder that can be written to") from None
    return folder


def claim_file(path: Path) -> Path:
    """Make sure that the file `path` can be written, before anything is computed, and leave it as it is.

    Raises:
        BadInput: it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        new = not path.exists()
        with path.open("ab"):
            pass
        if new:
            path.unlink()
    except OSError as error:
        raise BadInput(f"cannot write {path}: {error.strerror}; give a file that can be written") from None
    return path


def _forget_earlier(folder: Path) -> None:
    """Remove the pages and traces of an earlier verification, which may have had other counterexamples."""
    for claim in CLAIMS:
        for suffix in (".html", ".trace.json"):
            (folder / f"{claim.id}{suffix}").unlink(missing_ok=True)
    for trace in folder.glob("witness-*.trace.json"):
        trace.unlink()


def write_result(folder: Path, result: Result) -> dict[str, str]:
    """Write pages, traces and verdicts of `result`, and return the path of the trace of each claim that has one.

    Every trace is replayed on the readable model before its page is drawn.
    """
    _forget_earlier(folder)
    traces: dict[str, str] = {}
    pages: dict[str, str] = {}
    for decided in result.claims:
        if decided.trace is None:
            continue
        path = folder / f"{decided.claim.id}.trace.json"
        path.write_bytes(encode(decided.trace))
        traces[decided.claim.id] = str(path)
        page = counterexample_page(decided, replay(decided.trace), result)
        pages[decided.claim.id] = f"{decided.claim.id}.html"
        (folder / pages[decided.claim.id]).write_text(page, encoding="utf-8")
    for seen in result.witnesses:
        if seen.trace is not None:
            (folder / f"witness-{seen.id}.trace.json").write_bytes(encode(seen.trace))
    (folder / "verdicts.json").write_bytes(as_json(result, traces))
    (folder / "index.html").write_text(overview_page(result, pages), encoding="utf-8")
    return traces
