"""What every command told before the house was rebuilt for several papers: the same, byte for byte.

The files were recorded then, and none may change but for a reason that the changelog gives.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import pytest

from swarmproof.cli import main

RECORDED = Path(__file__).with_name("recorded")
#: By recorded file, the command whose JSON it is, and its exit code. `BESIDE` has what it writes beside.
COMMANDS = {
    "verify-printed.json": ("verify --uavs 2 --cus 2 --semantics printed --report rep-printed", 1),
    "matrix.json": ("verify --matrix --uavs 2 --cus 1", 0),
    "fly-iid.json": ("fly crossing --loss iid:0.1", 0),
    "fly-exhaustive.json": ("fly crossing --loss exhaustive:2", 0),
    "margin.json": ("margin --certificate margin.certificate.json", 1),
}
BESIDE = {
    "verify-printed.json": ("rep-printed/lemma-1.trace.json", "rep-printed/recovery.trace.json"),
    "margin.json": ("margin.certificate.json",),
}
#: SHA-256 of the JSON of the whole audit, which is long.
AUDIT = "74eb29b05f931f56d6e385775aef15f2476b4daa97b21ade7056c180e5735c20"


def comparable(text: bytes) -> str:
    """Return a document without what no two runs, or no two versions, have in common: times, digests of the code."""
    document = re.sub(r'"made_by": \{[^}]*\}', '"made_by": {}', text.decode())
    return re.sub(r'"seconds": [0-9.]+', '"seconds": 0', document)


def told(command: str, code: int, folder: Path) -> str:
    """Return the JSON of a command."""
    assert main([*command.split(), "--json", str(folder / "out.json")]) == code
    return comparable((folder / "out.json").read_bytes())


@pytest.mark.parametrize("name", COMMANDS)
def test_documents_are_what_they_were(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The JSON of a command is the recorded one, and so are the traces and the certificate that it writes beside."""
    monkeypatch.chdir(tmp_path)
    assert told(*COMMANDS[name], tmp_path) == comparable((RECORDED / name).read_bytes())
    for path in BESIDE.get(name, ()):
        assert (tmp_path / path).read_bytes() == (RECORDED / Path(path).name).read_bytes()


def test_the_audit_is_what_it_was(tmp_path: Path) -> None:
    """The JSON of the whole audit is the recorded one."""
    document = told("audit", 0, tmp_path)
    assert hashlib.sha256(document.encode()).hexdigest() == AUDIT


@pytest.mark.deep
def test_an_experiment_is_what_it_was(tmp_path: Path) -> None:
    """The JSON of a small experiment is the recorded one: flights are the same to the bit."""
    document = told(f"reproduce fig3b --quick --results {tmp_path / 'results'}", 3, tmp_path)
    assert document == comparable((RECORDED / "fig3b.json").read_bytes())


@pytest.mark.parametrize("name", ["lemma-1", "recovery"])
def test_old_traces_are_still_replayed(name: str) -> None:
    """A trace that was written before is read and shows the same violation."""
    assert main(["replay", str(RECORDED / f"{name}.trace.json")]) == 1
