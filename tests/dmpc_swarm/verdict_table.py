"""Renders the recorded matrix as the table of docs/semantics.md: `python -m tests.dmpc_swarm.verdict_table`."""

from __future__ import annotations

from swarmproof.campaign.matrix import load_matrix
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS
from swarmproof.dmpc_swarm.system import SYSTEM

_SHORT = {"not-applicable": "–", "holds": "✓", "undecided": "?"}


def _cell(expected: str) -> str:
    if expected in _SHORT:
        return _SHORT[expected]
    return expected.replace("holds within", "✓ ≤").replace("holds in", "✓ in").replace("violated in", "✗")


def render() -> str:
    """Return the table: one row per configuration, with lengths in rounds and least losses."""
    lines = [
        "| N × M | semantics | " + " | ".join(f"`{claim.id}`" for claim in CLAIMS) + " |",
        "| --- " * (len(CLAIMS) + 2) + "|",
    ]
    for row in load_matrix(SYSTEM):
        name = " ".join([f"`{row.preset}`", *(f"`{one}`" for one in row.overrides)])
        cells = " | ".join(_cell(row.expected[claim.id]) for claim in CLAIMS)
        lines.append(f"| {row.size.replace('x', ' × ')} | {name} | {cells} |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(render())
