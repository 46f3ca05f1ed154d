"""The folder of results: what is in it is found again, and what is damaged, foreign or outdated counts as missing."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from swarmproof.errors import BadInput
from swarmproof.reproduce import store as module
from swarmproof.reproduce.cell import Cell
from swarmproof.reproduce.made_by import made_by
from swarmproof.reproduce.measure import RADII, Leg, Measured
from swarmproof.reproduce.store import FORMAT, Store, Stored

Json = dict[str, Any]

CELL = Cell("crossing", 2, "HT", "none", "guarded", 3, 30)
OTHER = replace(CELL, seed=4)
LEG = Leg(0, 30, (None, 20, 18, 15), ((None, 29), (20, 19), (18, 17), (15, 14)), (0.5, 0.1), (0.4, 0.1), (0.3, 1 / 3))
STORED = Stored(
    Measured(
        rounds=30,
        sampled=0.1 + 0.2,
        lower=math.pi / 12,
        collides=None,
        closest=(0, 1),
        closest_time=2.345,
        lost=1,
        solved=2,
        rejected=3,
        infeasible=4,
        all_plan=5,
        all_run=6,
        adopted=7,
        last_adopted=None,
        rest_from=8,
        violated=("lemma-1", "theorem-2"),
        legs=(LEG,),
    ),
    1.25,
)
#: Puts a cell many times; told how many puts failed, and how often it was not there.
PUT = f"""
import sys
from pathlib import Path
from math import *
from swarmproof.reproduce.cell import Cell
from swarmproof.reproduce.measure import Leg, Measured
from swarmproof.reproduce.store import Store, Stored
cell, stored, store = {CELL!r}, {STORED!r}, Store(Path(sys.argv[1]))
failed = missing = 0
for _ in range(100):
    try:
        store.put(cell, stored)
    except Exception:
        failed += 1
    missing += store.get(cell) != stored
print(failed, missing)
"""


@pytest.fixture
def store(tmp_path: Path) -> Store:
    """Return a folder with one result."""
    store = Store(tmp_path / "deep" / "results")
    store.put(CELL, STORED)
    return store


def file_of(store: Store, cell: Cell = CELL) -> Path:
    """Return the file of a cell."""
    return store.folder / f"{cell.id}.json"


def test_what_is_put_is_got(store: Store) -> None:
    """To the bit; for this cell only."""
    assert store.get(CELL) == STORED
    assert repr(store.get(CELL)) == repr(STORED)
    assert store.get(OTHER) is None
    assert store.find([OTHER, CELL]) == {CELL: STORED}
    assert store.outdated([OTHER, CELL]) == 0
    assert Store(store.folder).get(CELL) == STORED


def test_a_file_says_what_it_is(store: Store) -> None:
    """One file for each cell, whole, with the words that fly it, the code that flew it, and nothing besides."""
    assert [path.name for path in store.folder.iterdir()] == [f"{CELL.id}.json"]
    table = json.loads(file_of(store).read_text(encoding="ascii"))
    assert list(table) == ["format", "cell", "fly", "made_by", "seconds", "measured"]
    assert (table["format"], table["cell"], table["fly"]) == (FORMAT, CELL.id, list(CELL.words))
    assert table["made_by"] == made_by()
    assert table["seconds"] == STORED.seconds
    assert table["measured"]["lower"] == STORED.measured.lower


def test_a_cell_with_series_is_another(store: Store) -> None:
    """Its file is another one, and does not count as that of the cell without, nor the other way round."""
    twin = replace(CELL, series=True)
    assert store.get(twin) is None
    file_of(store).rename(file_of(store, twin))
    assert store.get(twin) is None
    assert store.get(CELL) is None
    assert store.outdated([CELL, twin]) == 1


def changed(change: Callable[[Json], Any]) -> Callable[[str], str]:
    """Return what changes the object in a file."""

    def text(before: str) -> str:
        table = json.loads(before)
        change(table)
        return json.dumps(table)

    return text


def measured(**values: object) -> Callable[[str], str]:
    """Return what changes numbers in a file."""
    return changed(lambda table: table["measured"].update(values))


#: From the text of a file that counts to one that does not.
DAMAGED: dict[str, Callable[[str], str]] = {
    "empty": lambda text: "",
    "torn": lambda text: text[: len(text) // 2],
    "torn at its end": lambda text: text.rstrip()[:-1],
    "no JSON": lambda text: "results",
    "a list": lambda text: f"[{text}]",
    "a number": lambda text: "3",
    "null": lambda text: "null",
    "another format": changed(lambda table: table.update(format="swarmproof.cell/2")),
    "another cell": changed(lambda table: table.update(cell=OTHER.id)),
    "other code": changed(lambda table: table["made_by"].update(swarmproof="0123456789abcdef")),
    "another numpy": changed(lambda table: table["made_by"].update(numpy="1.0")),
    "another Python": changed(lambda table: table["made_by"].update(python="3.9.1")),
    "a library more": changed(lambda table: table["made_by"].update(more="1")),
    "without code": changed(lambda table: table.pop("made_by")),
    "without seconds": changed(lambda table: table.pop("seconds")),
    "seconds in words": changed(lambda table: table.update(seconds="long")),
    "seconds null": changed(lambda table: table.update(seconds=None)),
    "without numbers": changed(lambda table: table.update(measured={})),
    "numbers in a list": changed(lambda table: table.update(measured=[1, 2])),
    "a number missing": changed(lambda table: table["measured"].pop("lower")),
    "a number more": measured(upper=3.0),
    "fewer rounds": measured(rounds=29),
    "more rounds": measured(rounds=31),
    "no legs": measured(legs=[]),
    "legs are numbers": measured(legs=[5]),
    "legs are words": measured(legs="ab"),
    "half a leg": measured(legs=[{"begin": 0}]),
    "arrivals are numbers": changed(lambda table: table["measured"]["legs"][0].update(reached=[1, 2, 3, 4])),
    "one closest": measured(closest=[0]),
    "three closest": measured(closest=[0, 1, 2]),
    "no closest": measured(closest=None),
    "violated null": measured(violated=None),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_what_does_not_count_is_missing_and_replaced(name: str, store: Store) -> None:
    """It is no result, it is told as a file that does not count, and the next result replaces it."""
    path = file_of(store)
    path.write_text(DAMAGED[name](path.read_text(encoding="ascii")), encoding="ascii")
    assert store.get(CELL) is None
    assert store.find([CELL]) == {}
    assert store.outdated([CELL, OTHER]) == 1
    store.put(CELL, STORED)
    assert store.get(CELL) == STORED
    assert store.outdated([CELL]) == 0


@pytest.mark.parametrize(
    "damage",
    [measured(lower=None), measured(lower="near"), measured(all_plan="many"), measured(collides=3)],
    ids=["lower null", "lower a word", "plans a word", "collides a number"],
)
def test_a_number_that_is_none_is_missing(damage: Callable[[str], str], store: Store) -> None:
    """What no flight can have measured is no result."""
    path = file_of(store)
    path.write_text(damage(path.read_text(encoding="ascii")), encoding="ascii")
    assert store.get(CELL) is None


def test_bytes_are_missing(store: Store) -> None:
    """A file that is no text is no result."""
    file_of(store).write_bytes(b"\xff\xfe\x00\x80")
    assert store.get(CELL) is None
    assert store.outdated([CELL]) == 1


def test_another_cells_file_is_missing(store: Store) -> None:
    """A file that was copied to another name does not become another cell's result."""
    file_of(store, OTHER).write_bytes(file_of(store).read_bytes())
    assert store.get(OTHER) is None
    assert store.find([CELL, OTHER]) == {CELL: STORED}


def test_other_code_finds_nothing(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """After a change of the code all results are outdated, and after it is taken back they count again."""
    with monkeypatch.context() as patch:
        patch.setattr(module, "made_by", lambda: {"swarmproof": "another"})
        assert store.find([CELL]) == {}
        assert store.outdated([CELL, OTHER]) == 1
    assert store.find([CELL]) == {CELL: STORED}


def test_a_broken_put_leaves_the_old_result(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """Interrupted while it is written, a result is not there in parts: the one before it still is."""
    real = Path.write_text

    def half(self: Path, data: str, *arguments: Any, **options: Any) -> int:
        real(self, data[: len(data) // 2], *arguments, **options)
        raise KeyboardInterrupt

    newer = replace(STORED, seconds=9.5)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", half)
        with pytest.raises(KeyboardInterrupt):
            store.put(CELL, newer)
    assert store.get(CELL) == STORED
    store.put(CELL, newer)
    assert store.get(CELL) == newer
    assert [path.name for path in store.folder.iterdir()] == [f"{CELL.id}.json"]


def test_two_commands_may_put_the_same_cell(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """If another process puts the cell just before this one's file takes its place, both succeed."""
    real, others = os.replace, iter([4_000_001])

    def replace_(source: Path, target: Path) -> None:
        for pid in others:
            with monkeypatch.context() as patch:
                patch.setattr(os, "getpid", lambda pid=pid: pid)
                store.put(CELL, replace(STORED, seconds=2.0))
        real(source, target)

    monkeypatch.setattr(os, "replace", replace_)
    store.put(CELL, replace(STORED, seconds=3.0))
    assert store.get(CELL) == replace(STORED, seconds=3.0)
    assert [path.name for path in store.folder.iterdir()] == [f"{CELL.id}.json"]


def test_two_processes_do_not_disturb_each_other(store: Store) -> None:
    """Two processes that put and get the same cell all the time always succeed."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    both = [
        subprocess.Popen(
            [sys.executable, "-c", PUT, str(store.folder)], stdout=subprocess.PIPE, text=True, env=environment
        )
        for _ in range(2)
    ]
    assert [one.communicate(timeout=60)[0].split() for one in both] == [["0", "0"]] * 2


def test_a_folder_that_cannot_be_made_is_bad_input(tmp_path: Path) -> None:
    """One sentence names the folder and the option."""
    (tmp_path / "file").write_text("", encoding="ascii")
    for folder in (tmp_path / "file", tmp_path / "file" / "results", Path("/dev/null/results")):
        with pytest.raises(BadInput, match=r"choose another --results$") as error:
            Store(folder)
        assert str(folder) in str(error.value)
        assert "\n" not in str(error.value)


def test_a_result_that_cannot_be_written_is_bad_input(store: Store) -> None:
    """So it is where the folder is there and the file cannot be written, or the folder is gone."""
    file_of(store).unlink()
    file_of(store).mkdir()
    gone = Store(store.folder / "gone")
    gone.folder.rmdir()
    for cannot in (store, gone):
        assert cannot.get(CELL) is None
        with pytest.raises(BadInput, match=r"^a result cannot be written to .*; choose another --results$") as error:
            cannot.put(CELL, STORED)
        assert str(file_of(cannot)) in str(error.value)
        assert "\n" not in str(error.value)


def test_the_made_up_leg_is_like_a_real_one() -> None:
    """A leg has as many arrivals as there are radii."""
    assert len(LEG.all_within) == len(LEG.reached) == len(RADII)
