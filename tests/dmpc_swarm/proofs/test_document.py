"""docs/proofs.md says what the audit decides: its tables are compared with the claims."""

from __future__ import annotations

import re
import subprocess
import sys
import textwrap
from pathlib import Path

from tests.dmpc_swarm.proofs.test_samples import TRUE_FOR

from swarmproof.claims.proof import ProofVerdict
from swarmproof.dmpc_swarm.pair_table import UNDER_20, audit_cells
from swarmproof.dmpc_swarm.proofs.registry import PROOF_CLAIMS, select_proof_claims

TEXT = (Path(__file__).parents[3] / "docs" / "proofs.md").read_text(encoding="utf-8")


def _rows(heading: str) -> list[list[str]]:
    """Return the cells of the table whose first line begins with `heading`."""
    table = TEXT[TEXT.index(heading) :].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in table]


def test_every_claim_is_told() -> None:
    """The document names every claim about the proofs, and no other."""
    named = set(re.findall(r"`([a-z0-9]+(?:-[a-z0-9]+)*)`", TEXT)) - {"guarded"}
    assert named == {claim.id for claim in PROOF_CLAIMS}


def test_the_table_of_pairs_is_the_one_decided() -> None:
    """Each of the 21 pairs is in the document's table, with its lemma and its verdict."""
    told = {}
    for pairs, lemma, assumes, enough, _ in _rows("| pair | lemma"):
        names = pairs.split(", ") if "-S," not in pairs else [f"{a}-{b}" for a, b in _old_pairs()]
        for name in names:
            told[name] = (lemma.strip("*"), assumes.replace("–", "none"), enough.split(",")[0].strip("*"))
    words = {str(ProofVerdict.PROVED): "proved", UNDER_20: "false"}
    decided = {
        each.cell.id: (each.cell.lemma or "none", each.hypotheses, words[each.verdict]) for each in audit_cells()
    }
    assert told == decided


def _old_pairs() -> list[tuple[str, str]]:
    roles = ("S1", "S2", "U1", "U2")
    return [(one, other) for n, one in enumerate(roles) for other in roles[n:]]


def test_the_table_of_steps_is_the_one_decided() -> None:
    """Each step of the proofs is false or proved for T/T_c = 1 and for 2, 3, 4 as the document says."""
    told = {row[4].strip("`"): row[1:3] for row in _rows("| step of the proofs")}
    decided = {name: [_word(1 in ratios), _word({2, 3, 4} <= set(ratios))] for name, ratios in TRUE_FOR.items()}
    (horizon,) = select_proof_claims(["horizon/printed"])
    assert horizon.verdict is ProofVerdict.FALSE
    assert told == {**decided, "horizon": ["false", "false"]}


def test_the_code_of_the_document_runs() -> None:
    """The blocks of Python in the document run, and what they assert is true; there are two of them."""
    blocks = re.findall(r"\n\n((?:    .*\n)+)", TEXT)
    programs = [textwrap.dedent(block) for block in blocks if "for " in block]
    assert len(programs) == 2
    for program in programs:
        subprocess.run([sys.executable, "-I", "-c", program], check=True, capture_output=True)


def _word(true: bool) -> str:
    return "proved" if true else "false"
