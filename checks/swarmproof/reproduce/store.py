"""A folder with what was measured: one file for each cell, so that a later run flies only what is missing."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import msgspec

from swarmproof.errors import BadInput
from swarmproof.files.writing import write
from swarmproof.reproduce.cell import Cell
from swarmproof.reproduce.made_by import made_by
from swarmproof.reproduce.measure import Measured

FORMAT = "swarmproof.cell/1"


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
        if folder.exists() and not folder.is_dir():
            raise BadInput(f"the results cannot be kept in {folder}, which is no folder; choose another --results")
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BadInput(
                f"the results cannot be kept in {folder}: {error.strerror}; choose another --results"
            ) from None

    def get(self, cell: Cell) -> Stored | None:
        """Return what is known of `cell`; None if nothing is, or if other code or other libraries measured it."""
        try:
            table = json.loads(self._path(cell).read_bytes())
            if (table["format"], table["cell"], table["made_by"]) != (FORMAT, cell.id, made_by()):
                return None
            msgspec.convert(table["measured"], Measured)  # every number is one
            stored = Stored(Measured.from_json(table["measured"]), float(table["seconds"]))
        except (OSError, ValueError, KeyError, TypeError, AttributeError, msgspec.ValidationError):
            return None  # whatever the file is, it says nothing about this cell
        return stored if stored.measured.rounds == cell.rounds and stored.measured.legs else None

    def find(self, cells: Iterable[Cell]) -> dict[Cell, Stored]:
        """Return what is known of these cells."""
        return {cell: stored for cell in cells if (stored := self.get(cell)) is not None}

    def outdated(self, cells: Iterable[Cell]) -> int:
        """Return how many of these cells have a file that does not count."""
        return sum(os.path.exists(self._path(cell)) and self.get(cell) is None for cell in cells)

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
        write(self._path(cell), json.dumps(table) + "\n")

    def _path(self, cell: Cell) -> Path:
        return self.folder / f"{cell.id}.json"
