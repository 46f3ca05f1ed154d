"""`swarmproof margin`: Δd_min,cont (eq. 24) as an interval with a certificate, and what Theorem 3 then guarantees."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable, Sequence
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from swarmproof import streams, terminal
from swarmproof.errors import BadInput
from swarmproof.exit_codes import ExitCode
from swarmproof.files.reading import read_bytes
from swarmproof.files.writing import write
from swarmproof.margin.bounds import Margin, from_certificate, margin
from swarmproof.margin.check import Rejected
from swarmproof.margin.mixed import of_a_pair
from swarmproof.margin.problem import Problem
from swarmproof.margin.solve import Extreme, solve_for
from swarmproof.margin.sweep import MOST_BYTES, Axis, certificate_text, file_name, problems, sweep
from swarmproof.output import deliver, reserve_file, reserve_folder, write_json
from swarmproof.pages import rounding
from swarmproof.pages.margin import more as margin_more
from swarmproof.pages.margin import plot as margin_plot
from swarmproof.pages.margin import words as margin_words
from swarmproof.theorem3.fleet import Kind, pairs, read_kinds
from swarmproof.theorem3.inequality import Truth
from swarmproof.theorem3.numbers import read_toml
from swarmproof.theorem3.parameters import Parameters, Reading

_CODES = {Truth.HOLDS: ExitCode.WELL, Truth.FAILS: ExitCode.VIOLATED, Truth.UNDECIDED: ExitCode.UNDECIDED}
_COLOURS: dict[str, str] = {
    Truth.HOLDS: "green",
    Truth.FAILS: "red",
    Truth.UNDECIDED: "yellow",
    margin_words.NOT_APPLICABLE: "yellow",
}


def run(options: argparse.Namespace) -> ExitCode:
    """Run the command and return the exit code.

    Raises:
        BadInput: parameters or options that make no sense together, or files that cannot be read or written.
    """
    console = terminal.text(options.json)
    if options.check is not None:
        return _check(options, console)
    _only_with("--sweep", options.sweep, {"--changes": options.changes})
    if options.certificate == "-":
        raise BadInput("--certificate - is not a file: give a name, which --check can be given, too")
    base, kinds = _parameters(options)
    reading = Reading.parse(options.reading)
    if kinds:
        return _fleet(options, kinds, reading, console)
    _only_with("--sweep", options.sweep, {"--results": options.results})
    if options.sweep:
        return _sweep(options, base, reading, console)
    problem = Problem(base, reading)
    _reserve(options)
    extreme: Extreme | None = None
    with terminal.status("searching") as status:
        if options.solve_for is not None:
            extreme = solve_for(options.solve_for, base, reading, status.update)
        found = margin(problem, status.update)
    shown = found if extreme is None or extreme.margin is None else extreme.margin
    certified = extreme is None or extreme.margin is not None

    def tell() -> None:
        if options.certificate is not None and extreme is not None and not certified:
            console.print(f"No certificate is written: no {extreme.name} is certified.")
        _print(console, found, extreme)

    deliver(
        lambda: (
            write(Path(options.certificate), certificate_text(shown)) if options.certificate and certified else None
        ),
        lambda: write_json(options.json, _text(margin_words.document(found, extreme))),
        tell,
        lambda: margin_plot.plot_margin(shown, Path(options.plot)) if options.plot else None,
    )
    terminal.print_place(console, "Plot", options.plot)
    return _code(found) if extreme is None else _solved(extreme)


def _reserve(options: argparse.Namespace) -> None:
    """Make sure that what is to be written can be, before anything is computed."""
    if options.plot is not None:
        margin_plot.check_path(Path(options.plot))
    for path in (options.json, options.certificate):
        reserve_file(path)


def _only_with(needed: str, given: object, options: dict[str, object]) -> None:
    for name, value in options.items():
        if value is not None and not given:
            raise BadInput(f"{name} goes with {needed}, which is not given")


def _parameters(options: argparse.Namespace) -> tuple[Parameters, tuple[Kind, ...]]:
    """Return the parameters, and the kinds of UAVs if the file has some."""
    changes = list(options.set)
    for name, value in (("d_min", options.d_min), ("tracking_error", options.tracking_error)):
        if value is not None:
            changes.append(f"{name}={value}")
    if options.parameters is None:
        return Parameters().with_changes(changes), ()
    table = read_toml(options.parameters, "parameter file", "T_c = 0.1")
    raw = table.pop("kinds", None)
    base = Parameters.from_table(options.parameters, table, changes)
    if raw is None:
        return base, ()
    kinds = read_kinds(raw, base)
    for name in (change.partition("=")[0].strip() for change in changes):
        if any(name in one for one in raw):
            raise BadInput(f"{name} is given by [[kinds]], kind by kind: change it there, or leave it out there")
    return base, kinds


def _fleet(options: argparse.Namespace, kinds: tuple[Kind, ...], reading: Reading, console: Console) -> ExitCode:
    """Compute every pair of kinds; the worst verdict decides."""
    refused = {
        "--certificate": options.certificate,
        "--solve-for": options.solve_for,
        "--sweep": options.sweep or None,
        "--plot": options.plot,
    }
    for name, value in refused.items():
        if value is not None:
            hint = "give --results DIR, a folder for one of each pair" if name == "--certificate" else "leave one out"
            raise BadInput(f"{name} is for one pair of UAVs, and [[kinds]] makes several: {hint}")
    some = pairs(kinds)
    if not some:
        raise BadInput("[[kinds]] lists one UAV, which has no other to keep away from: give two, such as uavs = [0, 1]")
    sets = list(dict.fromkeys(Problem(one.parameters, reading) for one in some))
    found = dict(zip(sets, _swept(options, sets), strict=True))
    results = [of_a_pair(found[Problem(one.parameters, reading)], one) for one in some]
    documents = [
        {"kinds": list(one.names), "attained": result.attained, **margin_words.document(result)}
        for one, result in zip(some, results, strict=True)
    ]

    def tell() -> None:
        _print_sweep(console, results, [" and ".join(one.names) for one in some])
        for text in margin_more.of_fleet(results):
            console.print(text)
        console.print(margin_words.scope(results[0]), style="bright_black")

    deliver(
        lambda: write_json(options.json, _text({"schema": "swarmproof.margin-fleet/1", "pairs": documents})),
        tell,
    )
    return _worst(_code(result) for result in results)


def _truth(found: Margin) -> Truth:
    return found.truths[1]


def _code(found: Margin) -> ExitCode:
    """Return the exit code of one margin: about nothing, nothing is decided."""
    return (
        _CODES[_truth(found)] if margin_words.NOT_APPLICABLE not in margin_words.verdicts(found) else ExitCode.UNDECIDED
    )


def _solved(extreme: Extreme) -> ExitCode:
    if extreme.certified is not None:
        return ExitCode.WELL
    return ExitCode.UNDECIDED if extreme.undecided or extreme.refuted is None else ExitCode.VIOLATED


def _text(content: object) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def _print(console: Console, found: Margin, extreme: Extreme | None) -> None:
    if extreme is not None:
        console.print(f"[bold]{escape(margin_words.solution(extreme))}[/bold]", soft_wrap=True)
        console.print("For the parameters as given:")
    console.print(f"[bold]{escape(margin_words.headline(found))}[/bold]")
    table = Table(show_header=False, box=None, padding=(0, 2))
    table.add_column(min_width=21)
    table.add_column(overflow="fold")
    table.add_row("Δd_min,cont", margin_words.interval(found))
    table.add_row("worst pair", margin_words.worst_pair(found))
    verdicts = dict(zip(("(26) as printed", "(26) corrected"), margin_words.verdicts(found), strict=True))
    for name, text in margin_words.consequences(found):
        table.add_row(name, text, style=_COLOURS.get(verdicts.get(name, ""), ""))
    console.print(table)
    console.print(margin_words.scope(found), style="bright_black")


def _check(options: argparse.Namespace, console: Console) -> ExitCode:
    changing = (options.parameters, options.set, options.d_min, options.tracking_error, options.sweep, options.changes)
    writing = (options.certificate, options.plot, options.solve_for, options.results)
    if any(value not in (None, []) for value in (*changing, *writing)):
        raise BadInput("--check goes with --json only: everything else is in the certificate")
    path = Path(options.check)
    data = read_bytes(path, "certificate", MOST_BYTES, "give a file that --certificate has written")
    try:
        content = json.loads(data)
    except (ValueError, RecursionError):
        raise BadInput(f"{path} is no JSON: give a file that --certificate has written") from None
    if not isinstance(content, dict) or "schema" not in content:
        raise BadInput(
            f"{path} is JSON, but no certificate of swarmproof: give a file that --certificate has written, such as by "
            "`swarmproof margin --certificate margin.json`"
        )
    try:
        found = from_certificate(content)
    except Rejected as rejected:
        console.print(f"[red]rejected[/red]: {escape(str(rejected))}", soft_wrap=True)
        return ExitCode.VIOLATED
    _reserve(options)
    write_json(options.json, _text(margin_words.document(found)))
    console.print("[green]accepted[/green]: every number of the certificate was checked in exact arithmetic")
    _print(console, found, None)
    return ExitCode.WELL


def _sweep(options: argparse.Namespace, base: Parameters, reading: Reading, console: Console) -> ExitCode:
    if options.certificate is not None or options.solve_for is not None:
        raise BadInput(
            "--sweep goes neither with --certificate nor with --solve-for: give --results DIR for its certificates"
        )
    axes = [Axis.parse(text) for text in options.sweep]
    results = _swept(options, problems(base, reading, axes, options.changes))
    documents = [margin_words.document(found) for found in results]
    deliver(
        lambda: write_json(options.json, _text({"schema": "swarmproof.margin-sweep/1", "sets": documents})),
        lambda: _print_sweep(console, results),
        lambda: (
            margin_plot.plot_sweep(results, [axis.name for axis in axes], Path(options.plot)) if options.plot else None
        ),
    )
    terminal.print_place(console, "Plot", options.plot)
    terminal.print_place(console, "Certificates", options.results and Path(options.results))
    return _worst(_code(found) for found in results)


def _swept(options: argparse.Namespace, sets: Sequence[Problem]) -> list[Margin]:
    """Compute all sets with a bar; what is done is kept in --results if a user interrupts."""
    _reserve(options)
    folder = None if options.results is None else reserve_folder(Path(options.results))
    with terminal.bar(transient=False) as bar:
        task = bar.add_task("", total=len(sets))

        def tell(number: int, problem: Problem, found: Margin | None) -> None:
            name = file_name(problem).removesuffix(".json")
            bar.update(task, completed=number + (found is not None), description=name)

        try:
            results = sweep(sets, folder, tell, streams.say)
        except KeyboardInterrupt:
            kept = (
                "the same command goes on from here" if folder is not None else "with --results DIR they would be kept"
            )
            streams.say(f"{int(bar.tasks[0].completed)} of {len(sets)} sets are done; {kept}")
            raise
    return results


def _worst(codes: Iterable[ExitCode]) -> ExitCode:
    seen = set(codes)
    return next((_CODES[truth] for truth in (Truth.FAILS, Truth.UNDECIDED) if _CODES[truth] in seen), ExitCode.WELL)


def _print_sweep(console: Console, results: Sequence[Margin], names: Sequence[str] = ()) -> None:
    """Print a table of margins, with their parameters or with `names`."""
    table = Table(box=None, padding=(0, 1))
    for name in ("reading", "kinds" if names else "changed", "Δd_min,cont (m)", "width", "printed", "corrected"):
        table.add_column(name, no_wrap=name != "changed", overflow="fold")
    for number, found in enumerate(results):
        given = found.problem.parameters
        table.add_row(
            found.problem.reading.value,
            escape(names[number] if names else given.describe()) or "–",
            f"{rounding.rounded_down(found.lower, 7)} … {rounding.rounded_up(found.upper, 7)}",
            f"{float((found.upper - found.lower) / given.d_hat_min):.0e}",
            *(f"[{_COLOURS[verdict]}]{verdict}[/]" for verdict in margin_words.verdicts(found)),
        )
    console.print(table)
    console.print(
        "width: of the interval, relative to d̂_min; printed, corrected: inequality (26)", style="bright_black"
    )
