"""`swarmproof audit`: what the proofs of DMPC-Swarm state, each statement proved or refuted in exact arithmetic."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from swarmproof import terminal
from swarmproof.claims.proof import ProofVerdict, Reading
from swarmproof.dmpc_swarm.evidence.book import audit
from swarmproof.dmpc_swarm.pages.proofs import words as audit_words
from swarmproof.dmpc_swarm.pages.proofs.page import audit_page
from swarmproof.dmpc_swarm.pair_table import UNDER_20, CellAudit, audit_cells
from swarmproof.dmpc_swarm.proofs.pairs import PAIRS
from swarmproof.dmpc_swarm.proofs.registry import select_proof_claims
from swarmproof.dmpc_swarm.proofs.terms.cells import ROLES
from swarmproof.exit_codes import ExitCode
from swarmproof.output import deliver, publish, reserve_file, reserve_report, write_json
from swarmproof.prove.decide import Audited

_COLOURS: dict[str, str] = {
    ProofVerdict.PROVED: "green",
    UNDER_20: "yellow",
    ProofVerdict.FALSE: "red",
    ProofVerdict.UNDECIDED: "magenta",
}


def run(options: argparse.Namespace) -> ExitCode:
    """Run the command and return the exit code.

    Raises:
        BadInput: there is no such claim, or a file that cannot be written.
    """
    chosen = select_proof_claims(options.claim)
    reserve_file(options.json)
    with reserve_report(options.report) as folder:
        audited = audit(chosen)
        pairs = audit_cells() if any(claim.id == PAIRS for claim in chosen) else []
        console = terminal.text(options.json)
        deliver(
            lambda: write_json(options.json, audit_words.document(audited, pairs)),
            lambda: _print(console, audited, pairs, with_evidence=bool(options.claim)),
            lambda: publish(folder, lambda report: report.put("index.html", audit_page(audited, pairs))),
        )
    terminal.print_place(console, "Report", None if folder is None else folder.index)
    return _code(audited)


def _code(audited: Sequence[Audited]) -> ExitCode:
    if any(each.verdict is ProofVerdict.UNDECIDED for each in audited):
        return ExitCode.UNDECIDED
    return ExitCode.WELL if all(each.as_recorded for each in audited) else ExitCode.VIOLATED


def _print(console: Console, audited: Sequence[Audited], pairs: Sequence[CellAudit], with_evidence: bool) -> None:
    if pairs:
        _print_pairs(console, pairs)
    _print_claims(console, audited)
    if with_evidence:
        for each in audited:
            console.print(escape(audit_words.evidence(each)), soft_wrap=True)


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
