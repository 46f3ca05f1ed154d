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

from swarmproof.campaign import provenance
from swarmproof.campaign import store as module
from swarmproof.campaign.provenance import made_by
from swarmproof.campaign.store import FORMAT, Store, Stored
from swarmproof.campaign.trial import Cell
from swarmproof.dmpc_swarm.experiments.consistent import fault
from swarmproof.dmpc_swarm.experiments.measure import RADII, Leg, Measured, measure
from swarmproof.errors import BadInput, Failed

Json = dict[str, Any]

CELL = Cell("crossing", 2, "HT", "none", "guarded", 3, 30)
OTHER = replace(CELL, seed=4)
LEG = Leg(0, 30, (None, 20, 18, 15), ((None, 29), (20, 19), (18, 17), (15, 14)))
STORED = Stored(
    Measured(
        rounds=30,
        sampled=0.1 + 0.2,
        lower=math.pi / 12,
        collides=False,
        closest=(0, 1),
        closest_time=2.345,
        lost=1,
        solved=2,
        rejected=3,
        infeasible=4,
        all_plan=5,
        all_run=6,
        adopted=7,
        last_adopted=9,
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
from swarmproof.campaign.trial import Cell
from swarmproof.dmpc_swarm.experiments.measure import Leg, Measured
from swarmproof.campaign.store import Store, Stored
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
    assert store.uncounted([OTHER, CELL])[0] == 0
    assert Store(store.folder).get(CELL) == STORED


def test_a_file_says_what_it_is(store: Store) -> None:
    """One file for each cell, whole, with the words that fly it, the code that flew it, and nothing besides."""
    assert [path.name for path in store.folder.iterdir()] == [f"{CELL.id}.json"]
    table = json.loads(file_of(store).read_text(encoding="ascii"))
    assert list(table) == ["format", "cell", "fly", "made_by", "seconds", "measured", "digest"]
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
    assert store.uncounted([CELL, twin])[0] == 0
    assert store.uncounted([CELL, twin])[1] == [f"{file_of(store, twin)}: it is about something else"]


def changed(change: Callable[[Json], Any], sign: bool = True) -> Callable[[str], str]:
    """Return what changes the object in a file, and signs it anew."""

    def text(before: str) -> str:
        table = json.loads(before)
        change(table)
        if sign:
            table["digest"] = module._digest(table)
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
    "without digest": changed(lambda table: table.pop("digest"), sign=False),
    "not signed anew": changed(lambda table: table.update(seconds=2.0), sign=False),
    "another digest": changed(lambda table: table.update(digest="0" * 64), sign=False),
    "not a number": measured(lower=math.nan),
    "endless": measured(sampled=math.inf),
    "endless seconds": changed(lambda table: table.update(seconds=math.inf)),
    "negative seconds": changed(lambda table: table.update(seconds=-1.0)),
    "deep": lambda text: "[" * 100_000,
    "a bit less": lambda text: text.replace('"lost": 1', '"lost": 0'),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_what_does_not_count_is_missing_and_replaced(name: str, store: Store) -> None:
    """It is no result, it is told as a file that does not count, and the next result replaces it."""
    path = file_of(store)
    path.write_text(DAMAGED[name](path.read_text(encoding="ascii")), encoding="ascii")
    assert store.get(CELL) is None
    assert store.find([CELL]) == {}
    outdated = name in ("other code", "another numpy", "another Python", "a library more")
    assert store.uncounted([CELL, OTHER])[0] == outdated
    assert len(store.uncounted([CELL, OTHER])[1]) == 1 - outdated
    assert all(one.startswith(f"{path}: ") and "\n" not in one for one in store.uncounted([CELL])[1])
    store.put(CELL, STORED)
    assert store.get(CELL) == STORED
    assert store.uncounted([CELL])[0] == len(store.uncounted([CELL])[1]) == 0


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
    assert len(store.uncounted([CELL])[1]) == 1


def test_another_cells_file_is_missing(store: Store) -> None:
    """A file that was copied to another name does not become another cell's result."""
    file_of(store, OTHER).write_bytes(file_of(store).read_bytes())
    assert store.get(OTHER) is None
    assert store.find([CELL, OTHER]) == {CELL: STORED}


def test_other_code_finds_nothing(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """After a change of the code all results are outdated, and after it is taken back they count again."""
    with monkeypatch.context() as patch:
        patch.setattr(provenance, "made_by", lambda: {"swarmproof": "another"})
        assert store.find([CELL]) == {}
        assert store.uncounted([CELL, OTHER])[0] == 1
    assert store.find([CELL]) == {CELL: STORED}


def test_a_broken_put_leaves_the_old_result(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """Interrupted while it is written, a result is not there in parts: the one before it still is."""

    def interrupt(*arguments: object) -> None:
        raise KeyboardInterrupt

    newer = replace(STORED, seconds=9.5)
    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", interrupt)
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
    assert [one.communicate(timeout=600)[0].split() for one in both] == [["0", "0"]] * 2


def test_a_folder_that_cannot_be_made_is_bad_input(tmp_path: Path) -> None:
    """One sentence names the folder and the option."""
    (tmp_path / "file").write_text("", encoding="ascii")
    for folder in (tmp_path / "file", tmp_path / "file" / "results", Path("/dev/null/results")):
        with pytest.raises(BadInput, match=r"choose another --results$") as error:
            Store(folder)
        assert str(folder) in str(error.value)
        assert "\n" not in str(error.value)


def test_a_result_that_cannot_be_written_is_one_sentence(store: Store) -> None:
    """So it is where the folder is there and the file cannot be written, or the folder is gone."""
    file_of(store).unlink()
    file_of(store).mkdir()
    gone = Store(store.folder / "gone")
    gone.folder.rmdir()
    for cannot in (store, gone):
        assert cannot.get(CELL) is None
        with pytest.raises(Failed, match=r" cannot be written: ") as error:
            cannot.put(CELL, STORED)
        assert str(file_of(cannot)) in str(error.value)
        assert "\n" not in str(error.value)


#: Numbers that cannot be of a flight, signed as if they were.
INCONSISTENT: dict[str, tuple[Json, str]] = {
    "a collision far apart": ({"collides": True}, "the collision does not agree with the distance"),
    "a collision nobody violated": ({"collides": True, "lower": 0.1}, "does not agree with the claims violated"),
    "a violation without collision": ({"violated": ["eq-2"]}, "does not agree with the claims violated"),
    "apart and near": ({"lower": 0.1}, "the collision does not agree with the distance"),
    "undecided and apart": ({"collides": None}, "the collision does not agree with the distance"),
    "nearer at samples": ({"sampled": 0.2}, "larger than that at samples"),
    "negative": ({"lost": -1}, "lost is negative"),
    "too many plans": ({"all_plan": 31}, "more rounds were planned"),
    "too many problems": ({"solved": 60}, "more problems were solved"),
    "adopted never": ({"last_adopted": None}, "do not agree with the last adoption"),
    "adopted nothing": ({"adopted": 0}, "do not agree with the last adoption"),
    "too many adopted": ({"adopted": 61}, "do not agree with the last adoption"),
    "adopted later": ({"last_adopted": 31}, "is in no round"),
    "rests later": ({"rest_from": 30}, "is in no round"),
    "near later": ({"closest_time": 6.1}, "after the flight"),
    "near itself": ({"closest": [1, 1]}, "no two UAVs"),
    "near nobody": ({"closest": [0, 2]}, "no two UAVs"),
    "an unknown claim": ({"violated": ["lemma-9"]}, "a violated claim is none"),
    "violated twice": ({"violated": ["lemma-1", "lemma-1"]}, "a violated claim is none"),
}
BAD_LEGS: dict[str, tuple[Json, str]] = {
    "begins before": ({"begin": -1, "rounds": 31}, "do not follow"),
    "ends early": ({"rounds": 29}, "do not fill"),
    "a radius less": ({"all_within": [None, 20, 18]}, "not those of the radii"),
    "a UAV more": ({"reached": [[None, 29, 1], [20, 19], [18, 17], [15, 14]]}, "not those of the radii"),
    "arrives later": ({"all_within": [None, 20, 18, 31]}, "in no round of its leg"),
    "arrives before": ({"all_within": [None, 20, 18, 14]}, "before one has"),
    "all arrive without one": ({"all_within": [29, 20, 18, 15]}, "before one has"),
    "wider is later": ({"reached": [[None, 16], [20, 19], [18, 17], [15, 14]]}, "a wider radius"),
    "series nobody asked for": ({"largest": [0.1] * 30}, "the series are not those"),
}


@pytest.mark.parametrize(("change", "why"), INCONSISTENT.values(), ids=INCONSISTENT)
def test_numbers_that_do_not_agree_are_not_believed(change: Json, why: str, store: Store) -> None:
    """A right digest over numbers that no flight can have is not enough."""
    path = file_of(store)
    path.write_text(measured(**change)(path.read_text(encoding="ascii")), encoding="ascii")
    (said,) = store.uncounted([CELL])[1]
    assert why in said
    assert store.get(CELL) is None


@pytest.mark.parametrize(("change", "why"), BAD_LEGS.values(), ids=BAD_LEGS)
def test_legs_that_do_not_agree_are_not_believed(change: Json, why: str, store: Store) -> None:
    """Neither are arrivals that contradict each other."""
    path = file_of(store)
    text = changed(lambda table: table["measured"]["legs"][0].update(change))(path.read_text(encoding="ascii"))
    path.write_text(text, encoding="ascii")
    (said,) = store.uncounted([CELL])[1]
    assert why in said


@pytest.mark.parametrize("series", [False, True], ids=["plain", "series"])
@pytest.mark.parametrize("loss", ["none", "jam:3,10"])
def test_what_was_really_flown_is_believed(loss: str, series: bool) -> None:
    """The checks refuse no flight, also none that collides or has several legs."""
    cells = [
        Cell("crossing", 2, "HT", loss, "ignore-loss", 3, 20, series=series),
        Cell("formations", 2, "RR", loss, "guarded", 1, 12, ("uavs=4",), series=series),
    ]
    for cell in cells:
        assert fault(measure(cell), cell) is None


def test_series_that_do_not_agree_are_not_believed() -> None:
    """The smallest distance is not larger than the mean, nor the mean than the largest, and all are numbers."""
    cell = replace(CELL, series=True)
    right = replace(LEG, largest=(0.3,) * 30, mean=(0.2,) * 30, smallest=(0.1,) * 30)
    assert fault(replace(STORED.measured, legs=(right,)), cell) is None
    for wrong in (
        replace(right, mean=(0.05,) * 30),
        replace(right, largest=(0.15,) * 30),
        replace(right, smallest=(-0.1,) * 30),
        replace(right, largest=(math.inf,) * 30),
    ):
        assert fault(replace(STORED.measured, legs=(wrong,)), cell) == "the series do not agree with each other"
    assert fault(replace(STORED.measured, legs=(LEG,)), cell) == "the series are not those of the leg"


def test_the_made_up_leg_is_like_a_real_one() -> None:
    """A leg has as many arrivals as there are radii."""
    assert len(LEG.all_within) == len(LEG.reached) == len(RADII)
