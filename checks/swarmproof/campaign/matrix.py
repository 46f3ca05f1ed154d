"""The recorded matrix: configurations with the verdict expected of each.

A known flaw of a paper is an expected *violated*; what must not pass unnoticed is a verdict, or a length, that changed.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from math import prod

from swarmproof.campaign.pool import run_jobs
from swarmproof.claims.claim import Recovers
from swarmproof.claims.verdict import Verdict
from swarmproof.errors import BadInput
from swarmproof.explore.decide import Decided, Result, verify
from swarmproof.explore.search import Limits
from swarmproof.system import Scope, System
from swarmproof.systems import PACKAGES


@dataclass(frozen=True)
class Row:
    """One configuration, and what is expected of each claim in the words of :func:`in_short`."""

    system: System
    sizes: Mapping[str, int]
    preset: str
    overrides: tuple[str, ...]
    expected: Mapping[str, str]

    @property
    def scope(self) -> Scope:
        """What the row is about."""
        return Scope(self.system, self.sizes, self.system.reading.parse(self.preset, self.overrides))

    @property
    def size(self) -> str:
        """Its sizes, such as ``2x2``."""
        return "x".join(str(self.sizes[size.name]) for size in self.system.sizes)

    @property
    def name(self) -> str:
        """A name that is unique in the matrix and can be a folder's."""
        return "-".join([self.size, self.preset, *(one.replace("=", "-") for one in self.overrides)])


def in_short(decided: Decided) -> str:
    """Return a verdict with its lengths, such as ``violated in 8 rounds, 0 lost``: what the matrix records."""
    if isinstance(decided.claim.question, Recovers) and decided.verdict is Verdict.HOLDS:
        return f"holds within {decided.worst_rounds}"
    if decided.rounds is None:
        return str(decided.verdict)
    short = f"{decided.verdict} in {decided.rounds}, {decided.lost_messages} lost"
    if decided.avoidable is None:
        return short
    return f"{short}, {'avoidable' if decided.avoidable else 'inevitable'}"


@dataclass(frozen=True)
class RowResult:
    """A row with what was found."""

    row: Row
    result: Result

    @property
    def changes(self) -> list[str]:
        """Every claim that was decided otherwise than recorded, in words."""
        return [
            f"{decided.claim.id}: {found}, recorded is: {self.row.expected.get(decided.claim.id, 'nothing')}"
            for decided in self.result.claims
            if decided.verdict is not Verdict.UNDECIDED
            and (found := in_short(decided)) != self.row.expected.get(decided.claim.id)
        ]

    @property
    def undecided(self) -> bool:
        """Whether some claim was not decided."""
        return any(decided.verdict is Verdict.UNDECIDED for decided in self.result.claims)


def load_matrix(system: System) -> list[Row]:
    """Return the recorded matrix of a system, which ships with its package.

    Raises:
        BadInput: none is recorded.
    """
    path = files(f"swarmproof.{PACKAGES[system.name]}").joinpath("matrix.toml")
    if not path.is_file():
        raise BadInput(f"no matrix is recorded for {system.name}: verify it without --matrix")
    return [
        Row(system, _sizes(system, entry), entry["semantics"], tuple(entry["set"]), entry["expect"])
        for entry in tomllib.loads(path.read_text(encoding="utf-8"))["configuration"]
    ]


def _sizes(system: System, entry: Mapping[str, int]) -> dict[str, int]:
    return {size.name: entry[size.name] for size in system.sizes}


def select_rows(rows: Sequence[Row], sizes: Mapping[str, int | None], preset: str | None) -> list[Row]:
    """Return the rows of these sizes and this preset; None selects all.

    Raises:
        BadInput: there are none.
    """
    selected = [
        row
        for row in rows
        if all(number in (None, row.sizes.get(name)) for name, number in sizes.items()) and preset in (None, row.preset)
    ]
    if not selected:
        nouns = " x ".join(size.noun for size in rows[0].system.sizes)
        there = ", ".join(sorted({row.size.replace("x", " x ") for row in rows}))
        raise BadInput(f"the matrix has no such configuration: it has {nouns} {there}")
    return selected


def _run(job: tuple[Row, Limits]) -> Result:
    row, limits = job
    return verify(row.scope, limits=limits)


def run_matrix(
    rows: Sequence[Row],
    limits: Limits,
    processes: int,
    on_row: Callable[[RowResult], None],
    say: Callable[[str], None],
) -> list[RowResult]:
    """Verify every row, several at a time, and return what was found, in the order of `rows`.

    An interrupt ends it early; what is finished is returned. `say` is told in a sentence of a process that was killed.

    Raises:
        Failed: processes are killed again and again.
    """
    found: dict[str, RowResult] = {}

    def keep(job: tuple[Row, Limits], result: Result) -> None:
        row_result = RowResult(job[0], result)
        found[row_result.row.name] = row_result
        on_row(row_result)

    # the longest first, so that no core is idle at the end
    longest_first = sorted(rows, key=lambda row: (-prod(row.sizes.values()), -len(row.overrides)))
    run_jobs(_run, [(row, limits) for row in longest_first], processes, keep, say)
    return [found[row.name] for row in rows if row.name in found]


def as_toml(results: Sequence[RowResult]) -> Iterator[str]:
    """Yield the lines of a matrix file that records `results` as expected."""
    yield "# Recorded by `make record`. Each verdict is what this version finds; docs/semantics.md explains them."
    for row_result in results:
        row = row_result.row
        yield ""
        yield "[[configuration]]"
        for name, number in row.sizes.items():
            yield f"{name} = {number}"
        yield f'semantics = "{row.preset}"'
        yield _set_line(row)
        yield "[configuration.expect]"
        for decided in row_result.result.claims:
            yield f'{decided.claim.id} = "{in_short(decided)}"'


def _set_line(row: Row) -> str:
    quoted = ", ".join(f'"{one}"' for one in row.overrides)
    return f"set = [{quoted}]"
