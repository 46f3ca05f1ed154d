"""`swarmproof verify`: explore every message-loss pattern and decide each claim, for one scope or the matrix."""

from __future__ import annotations

import argparse
import os

from rich.console import Console
from rich.table import Table

from swarmproof import streams, terminal
from swarmproof.campaign.matrix import RowResult, load_matrix, run_matrix, select_rows
from swarmproof.claims.verdict import Verdict
from swarmproof.errors import BadInput
from swarmproof.exit_codes import ExitCode, exit_code
from swarmproof.explore.decide import Decided, Result, verify
from swarmproof.explore.search import Limits
from swarmproof.explore.search import Progress as SearchProgress
from swarmproof.formats.verdicts import as_json
from swarmproof.output import deliver, publish, reserve_file, reserve_report, write_json
from swarmproof.pages.matrix import matrix_json, put_matrix
from swarmproof.pages.verification import put_result, traces_of
from swarmproof.system import scope_of
from swarmproof.systems import load

_COLOURS = {
    Verdict.HOLDS: "green",
    Verdict.VIOLATED: "red",
    Verdict.UNDECIDED: "yellow",
    Verdict.NOT_APPLICABLE: "bright_black",
}


def run(options: argparse.Namespace) -> ExitCode:
    """Verify as the options say, print and write what was found, and return the exit code.

    Raises:
        BadInput: an option cannot be; a sentence says which and what would be right.
    """
    console = terminal.text(options.json)
    limits = Limits(options.max_states, options.max_seconds)
    if options.matrix:
        return _run_matrix(options, console, limits)
    system = load(options.system)
    reading = system.reading.parse(options.semantics, options.set)
    scope = scope_of(system, _sizes(options), reading)
    claims = system.select_claims(options.claim)
    reserve_file(options.json)
    with reserve_report(options.report) as folder:
        with terminal.status("exploring") as status:

            def tell(progress: SearchProgress) -> None:
                status.update(_progress_line(progress))

            result = verify(scope, claims, limits, tell, status.update)
        traces = {} if folder is None else {claim: str(folder.path / name) for claim, name in traces_of(result).items()}
        deliver(
            lambda: write_json(options.json, as_json(result, traces)),
            lambda: _print_result(console, result),
            lambda: publish(folder, lambda report: put_result(report, result)),
        )
    terminal.print_place(console, "Report", None if folder is None else folder.index)
    shown = any(decided.trace is not None and decided.verdict is Verdict.VIOLATED for decided in result.claims)
    if shown and folder is None:
        console.print("`--report DIR` writes a page and a replayable trace for each counterexample.")
    return exit_code(decided.verdict for decided in result.claims)


def _progress_line(progress: SearchProgress) -> str:
    return (
        f"round {progress.depth}: {progress.states:,} states, frontier {progress.frontier:,}, "
        f"{progress.seconds:.0f} s (Ctrl-C stops and keeps what was found)"
    )


def _sizes(options: argparse.Namespace) -> dict[str, int | None]:
    """Return the sizes that were given, by name."""
    return {"uavs": options.uavs, "cus": options.cus}


def _print_result(console: Console, result: Result) -> None:
    scope = result.scope
    console.print(f"[bold]{scope.system.name}, {scope.swarm()}, semantics {scope.reading.name()}[/bold]")
    switches = " ".join(f"{name}={value}" for name, value in scope.reading.as_dict().items())
    console.print(f"  {switches}", style="bright_black")
    table = Table(show_header=True, box=None, padding=(0, 2))
    table.add_column("claim", min_width=max(len(decided.claim.id) for decided in result.claims))
    table.add_column("verdict", min_width=len(Verdict.NOT_APPLICABLE))
    table.add_column("shown by", overflow="fold")
    for decided in result.claims:
        table.add_row(decided.claim.id, f"[{_COLOURS[decided.verdict]}]{decided.verdict}[/]", _shown_by(decided))
    console.print(table)
    if result.fixpoint:
        extent = f"Fixpoint: all {result.states:,} reachable states seen, the farthest after {result.depth} rounds"
    else:
        extent = (
            f"No fixpoint: stopped early ({result.stopped}) after {result.states:,} states, in round {result.depth}"
        )
    console.print(f"{extent} ({result.seconds:.1f} s). {scope.system.in_short}")
    seen = [witness.wording for witness in result.witnesses if witness.trace is not None]
    never = [witness.wording for witness in result.witnesses if witness.trace is None]
    if seen:
        console.print(f"Seen: {'; '.join(seen)}.")
    if never:
        console.print(f"{'Never' if result.fixpoint else 'Not yet'} seen: {'; '.join(never)}.")


def _shown_by(decided: Decided) -> str:
    if decided.worst_rounds is not None:
        return f"at most {decided.worst_rounds} loss-free rounds"
    if decided.rounds is None:
        return decided.why
    losses = f"{decided.lost_messages} lost"
    if decided.avoidable is None:
        return f"{decided.rounds} rounds, {losses}"
    return f"loop after {decided.rounds} rounds, {losses}, {'avoidable' if decided.avoidable else 'inevitable'}"


# --- the matrix ------------------------------------------------------------------------------------------------------


def _run_matrix(options: argparse.Namespace, console: Console, limits: Limits) -> ExitCode:
    for option in ("set", "claim"):
        if getattr(options, option):
            raise BadInput(
                f"--{option} does not go with --matrix, which verifies all claims as recorded: choose among its rows, "
                "such as --matrix --uavs 2 --semantics guarded"
            )
    rows = select_rows(load_matrix(load(options.system)), _sizes(options), options.semantics)
    reserve_file(options.json)
    with reserve_report(options.report) as folder:
        with terminal.bar("configurations") as bar:
            task = bar.add_task("", total=len(rows))

            def tell(row_result: RowResult) -> None:
                bar.update(task, advance=1, description=row_result.row.name)

            results = run_matrix(rows, limits, os.cpu_count() or 1, tell, streams.say)
        deliver(
            lambda: write_json(options.json, matrix_json(results)),
            lambda: _print_matrix(console, results),
            lambda: publish(folder, lambda report: put_matrix(report, results)),
        )
    changed = [one for one in results if one.changes]
    for one in changed:
        for change in one.changes:
            console.print(f"[red]changed[/red] {one.row.name}: {change}")
    undecided = len(rows) - len(results) + sum(1 for one in results if one.undecided)
    console.print(
        f"{len(results)} of {len(rows)} configurations verified: {len(changed)} with a changed verdict, "
        f"{undecided} undecided."
    )
    terminal.print_place(console, "Report", None if folder is None else folder.index)
    if changed:
        return ExitCode.VIOLATED
    return ExitCode.UNDECIDED if undecided else ExitCode.WELL


def _print_matrix(console: Console, results: list[RowResult]) -> None:
    """Print a line per configuration; columns are headed by the claims' initials to fit a narrow terminal."""
    if not results:
        return
    claims = [decided.claim.id for decided in results[0].result.claims]
    initials = ["".join(part[0] for part in name.split("-")) for name in claims]
    table = Table(box=None, padding=(0, 1))
    nouns = " x ".join(size.noun for size in results[0].row.system.sizes)
    table.add_column(f"{nouns}, semantics", no_wrap=True)
    for heading in initials:
        table.add_column(heading, no_wrap=True)
    table.add_column("states", justify="right", no_wrap=True)
    for one in results:
        row = one.row
        cells = [f"[{_COLOURS[decided.verdict]}]{_cell(decided)}[/]" for decided in one.result.claims]
        name = " ".join([f"{row.size} {row.preset}", *(override.split("_")[-1] for override in row.overrides)])
        table.add_row(name, *cells, f"{one.result.states:,}")
    console.print(table)
    legend = ", ".join(f"{short} {name}" for short, name in zip(initials, claims, strict=True))
    console.print(
        f"{legend}. ✓ holds, ✗ violated, ? undecided, - not applicable. A number is the rounds of the shortest run "
        "that shows it; where recovery holds, the most loss-free rounds that it takes."
    )


_SIGNS = {Verdict.HOLDS: "✓", Verdict.VIOLATED: "✗", Verdict.UNDECIDED: "?", Verdict.NOT_APPLICABLE: "-"}


def _cell(decided: Decided) -> str:
    number = decided.worst_rounds if decided.rounds is None else decided.rounds
    return _SIGNS[decided.verdict] if number is None else f"{_SIGNS[decided.verdict]}{number}"
