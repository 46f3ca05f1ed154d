"""`swarmproof claims`: what is claimed, where, and under which assumptions."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from rich.console import Group
from rich.markup import escape
from rich.table import Table

from swarmproof import terminal
from swarmproof.claims.claim import Claim
from swarmproof.dmpc_swarm.claims.experiments import EXPERIMENT_CLAIMS
from swarmproof.dmpc_swarm.claims.flight import FLIGHT_CLAIMS, FlightClaim
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS
from swarmproof.dmpc_swarm.proofs.registry import PROOF_CLAIMS
from swarmproof.exit_codes import ExitCode
from swarmproof.systems import load

_STYLE: dict[str, Any] = {"show_lines": True, "title_justify": "left"}


def run(options: argparse.Namespace) -> ExitCode:
    """Print the registry of claims and return the exit code WELL.

    Raises:
        BadInput: there is no such system.
    """
    if options.system is not None:
        system = load(options.system)
        terminal.text().print(_table(f"Claims about {system.name} ({system.paper}): verify", system.claims))
        return ExitCode.WELL
    protocol = _table("Claims about mlr-dmpc (DMPC-Swarm, Algorithms 1 and 2): verify, and fly on the way", CLAIMS)
    flights = _table("Claims about flown swarms (DMPC-Swarm, Section 4.3.2): fly", FLIGHT_CLAIMS)
    # at once: a reader who goes away after the first lines is no error
    terminal.text().print(Group(protocol, flights, _proofs(), _experiments()))
    return ExitCode.WELL


def _proofs() -> Table:
    table = Table(title="Claims about the proofs (DMPC-Swarm, Section 4.3.2 and Appendix C): audit", **_STYLE)
    for heading in ("id", "reading", "verdict", "claim", "place in the paper", "assumptions"):
        table.add_column(heading, overflow="fold", no_wrap=heading in ("id", "verdict"))
    for claim in PROOF_CLAIMS:
        words = (escape(text) for text in (claim.wording, claim.place, claim.assumptions))
        table.add_row(claim.id, claim.reading, claim.verdict, *words)
    return table


def _experiments() -> Table:
    table = Table(title="Claims about the experiments (DMPC-Swarm, Section 5): reproduce", **_STYLE)
    for heading in ("id", "claim", "place in the paper", "how it is read"):
        table.add_column(heading, overflow="fold", no_wrap=heading == "id")
    for claim in EXPERIMENT_CLAIMS:
        table.add_row(claim.id, *(escape(text) for text in (claim.wording, claim.place, claim.reading)))
    return table


def _table(title: str, claims: Sequence[Claim[Any] | FlightClaim]) -> Table:
    table = Table(title=title, **_STYLE)
    for heading in ("id", "claim", "place in the paper", "assumptions"):
        table.add_column(heading, overflow="fold", no_wrap=heading == "id")
    for claim in claims:
        table.add_row(claim.id, claim.wording, claim.place, claim.assumptions)
    return table
