"""A folder with what was measured: one file for each cell, so that a later run flies only what is missing.

What is there is checked before it is believed: its digest, the code that made it, and whether its numbers agree.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import msgspec

from swarmproof.campaign.provenance import counts, made_by
from swarmproof.campaign.trial import Cell
from swarmproof.dmpc_swarm.experiments.consistent import fault
from swarmproof.dmpc_swarm.experiments.measure import Measured
from swarmproof.errors import BadInput
from swarmproof.files.reading import read_bytes
from swarmproof.files.writing import write

FORMAT = "swarmproof.cell/1"


#: How long a file may be.
MOST_BYTES = 1 << 26


class _Outdated(Exception):
    """A file of other code: true, for all that is known, but not about this code."""


class _Wrong(Exception):
    """A file that is not to be believed, and why."""


def _digest(table: Mapping[str, Any]) -> str:
    """Return the SHA-256, in hex, of everything in a file but its digest."""
    rest = {key: value for key, value in table.items() if key != "digest"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def _no_number(text: str) -> float:
    raise ValueError(f"{text} is no number")


@dataclass(frozen=True, slots=True)
class Stored:
    """What is known of a cell: its numbers, and the processor time that they took, in s."""

    measured: Measured
    seconds: float


class Store:
    """The results in one folder, which is made if need be.

    Raises:
        BadInput: the folder cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except (OSError, ValueError) as error:  # a name can have a byte that no name can have
            why = error.strerror if isinstance(error, OSError) else error
            raise BadInput(f"the results cannot be kept in {folder}: {why}; choose another --results") from None

    def get(self, cell: Cell) -> Stored | None:
        """Return what is known of `cell`; None if nothing is, or what is there does not count."""
        try:
            return self._read(cell)
        except (_Outdated, _Wrong):
            return None

    def find(self, cells: Iterable[Cell]) -> dict[Cell, Stored]:
        """Return what is known of these cells."""
        return {cell: stored for cell in cells if (stored := self.get(cell)) is not None}

    def uncounted(self, cells: Iterable[Cell]) -> tuple[int, list[str]]:
        """Return what there is of these cells and does not count.

        Returns:
            how many files are of other code, or of other versions of libraries; and of each file that is not to be
            believed, which it is and why.
        """
        outdated, wrong = 0, []
        for cell in cells:
            try:
                self._read(cell)
            except _Outdated:
                outdated += 1
            except _Wrong as why:
                wrong.append(f"{self._path(cell)}: {why}")
        return outdated, wrong

    def _read(self, cell: Cell) -> Stored | None:
        path = self._path(cell)
        if not os.path.lexists(path):
            return None
        try:
            table = json.loads(read_bytes(path, "result", MOST_BYTES, "remove it"), parse_constant=_no_number)
            if (table["format"], table["cell"]) != (FORMAT, cell.id):
                raise _Wrong("it is about something else")
            if not counts(table["made_by"]):
                raise _Outdated
            if table["digest"] != _digest(table):
                raise _Wrong("its digest is not that of its numbers")
            msgspec.convert(table["measured"], Measured)  # every number is one
            stored = Stored(Measured.from_json(table["measured"]), float(table["seconds"]))
        except BadInput as error:
            raise _Wrong(str(error)) from None
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError, msgspec.ValidationError):
            raise _Wrong("it is no result of a flight") from None
        why = fault(stored.measured, cell) if 0 <= stored.seconds < inf else "its time is none"
        if why is not None:
            raise _Wrong(why)
        return stored

    def put(self, cell: Cell, stored: Stored) -> None:
        """Write down what was measured, whole or not at all.

        Raises:
            Failed: the file cannot be written.
        """
        table = {
            "format": FORMAT,
            "cell": cell.id,
            "fly": list(cell.words),
            "made_by": made_by(),
            "seconds": round(stored.seconds, 3),
            "measured": stored.measured.as_json(),
        }
        table["digest"] = _digest(table)
        write(self._path(cell), json.dumps(table) + "\n")

    def _path(self, cell: Cell) -> Path:
        return self.folder / f"{cell.id}.json"
