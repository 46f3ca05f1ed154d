"""`swarmproof audit`: what the proofs of DMPC-Swarm state, each statement proved or refuted in exact arithmetic."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from swarmproof.audit.decide import Audited, audit
from swarmproof.audit.table import UNDER_20, CellAudit, audit_cells
from swarmproof.claims.proofs.pairs import PAIRS
from swarmproof.claims.proofs.registry import select_proof_claims
from swarmproof.commands.options import write_json
from swarmproof.report import audit_words
from swarmproof.report.audit_page import write_audit
from swarmproof.report.folder import claim_folder
from swarmproof.statements.cells import ROLES
from swarmproof.statements.claim import ProofVerdict, Reading

_COLOURS: dict[str, str] = {
    ProofVerdict.PROVED: "green",
    UNDER_20: "yellow",
    ProofVerdict.FALSE: "red",
    ProofVerdict.UNDECIDED: "magenta",
}


def add_parser(commands: Any) -> None:
    """Add the command to the subparsers `commands`."""
    parser = commands.add_parser(
        "audit",
        help="decide what the proofs state: each statement proved or refuted, as printed and repaired",
        description="The proofs of Section 4.3.2 and Appendix C: what each statement needs, covers, and leaves out.",
        epilog="Exit codes: 0 every verdict is the one on record, 1 one is not, 2 bad input, 3 one is not decided.",
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    parser.add_argument(
        "--claim", action="append", default=[], metavar="ID", help="only this claim, with its evidence; repeatable"
    )
    parser.add_argument("--report", metavar="DIR", help="write a page with every claim, its evidence and pictures")
    parser.add_argument("--json", metavar="FILE", help="write the verdicts as JSON; - for standard output")


def run(options: argparse.Namespace) -> int:
    """Run the command and return the exit code.

    Raises:
        BadInput: there is no such claim, or a file cannot be written.
    """
    chosen = select_proof_claims(options.claim)
    folder = None if options.report is None else claim_folder(Path(options.report))
    audited = audit(chosen)
    pairs = audit_cells() if any(claim.id == PAIRS for claim in chosen) else []
    console = Console(stderr=options.json == "-", highlight=False)
    if pairs:
        _print_pairs(console, pairs)
    _print_claims(console, audited)
    if options.claim:
        for each in audited:
            console.print(escape(audit_words.evidence(each)), soft_wrap=True)
    write_json(options.json, audit_words.document(audited, pairs))
    if folder is not None:
        console.print(f"Report: {write_audit(audited, pairs, folder)}", soft_wrap=True)
    return _code(audited)


def _code(audited: Sequence[Audited]) -> int:
    if any(each.verdict is ProofVerdict.UNDECIDED for each in audited):
        return 3
    return 0 if all(each.as_recorded for each in audited) else 1


def _print_pairs(console: Console, pairs: Sequence[CellAudit]) -> None:
    console.print("What UAVs i and j can fly in round k+1, and which lemma says that they are d̂_min apart:")
    table = Table(box=None, padding=(0, 1))
    for heading in ("i", "j", "lemma", "which assumes", "verdict"):
        table.add_column(heading, overflow="fold")
    for each in pairs:
        table.add_row(
            each.cell.i.id,
            each.cell.j.id,
            each.cell.lemma or "none",
            each.hypotheses,
            f"[{_COLOURS[each.verdict]}]{each.verdict}[/]",
        )
    console.print(table)
    for role in ROLES:
        console.print(f" {role.id}: {escape(role.in_words())}", soft_wrap=True)
    console.print()


def _print_claims(console: Console, audited: Sequence[Audited]) -> None:
    table = Table(box=None, padding=(0, 1))
    for heading in ("claim", *Reading):
        table.add_column(heading, no_wrap=True)
    for name in dict.fromkeys(each.claim.id for each in audited):
        of = {each.claim.reading: each for each in audited if each.claim.id == name}
        table.add_row(name, *(_verdict(of[reading]) if reading in of else "" for reading in Reading))
    console.print(table)
    changed = [each.claim.key for each in audited if not each.as_recorded]
    if changed:
        console.print(f"Not as recorded: {', '.join(changed)}", style="red", soft_wrap=True)
    else:
        text = "Every verdict is the one on record. `--claim ID` shows the evidence, `--report DIR` all of it."
        console.print(text, soft_wrap=True)


def _verdict(audited: Audited) -> str:
    changed = "" if audited.as_recorded else f" (on record: {audited.claim.verdict})"
    return f"[{_COLOURS[audited.verdict]}]{audited.verdict}[/]{changed}"
