"""Cells: their words are options of `swarmproof fly`, and their ids tell them apart."""

from __future__ import annotations

import argparse
import shlex
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from swarmproof.campaign.trial import DIGITS, Cell
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.errors import BadInput
from swarmproof.faults.grammar import parse
from swarmproof.faults.losses import Losses
from swarmproof.options import parser

CELL = Cell("random", 3, "DT", "iid:0.25", "ignore-loss", 7, 40, ("uavs=5", "hold=20"))
#: The same with each field changed in turn.
OTHERS = {
    "scenario": replace(CELL, scenario="circle"),
    "cus": replace(CELL, cus=2),
    "trigger": replace(CELL, trigger="HT"),
    "loss": replace(CELL, loss="iid:0.2"),
    "preset": replace(CELL, preset="guarded"),
    "seed": replace(CELL, seed=8),
    "rounds": replace(CELL, rounds=41),
    "changes": replace(CELL, changes=("uavs=5",)),
    "series": replace(CELL, series=True),
}


def options(cell: Cell) -> argparse.Namespace:
    """Return what `swarmproof fly` makes of the words of a cell."""
    return parser.parse(["fly", *cell.words])


@pytest.mark.parametrize("cell", [CELL, *OTHERS.values()], ids=["itself", *OTHERS])
def test_the_words_are_options_of_fly(cell: Cell) -> None:
    """`swarmproof fly` reads each field of the cell from its words, and flies the cell's setting."""
    read = options(cell)
    assert (read.scenario, read.cus, read.trigger, read.loss) == (cell.scenario, cell.cus, cell.trigger, cell.loss)
    assert (read.semantics, read.set, read.seed, read.rounds) == (
        cell.preset,
        list(cell.changes),
        cell.seed,
        cell.rounds,
    )
    assert (read.json, read.report) == (None, None)
    assert cell.setting() == Setting.parse(read.scenario, read.cus, read.trigger, read.semantics, read.set, read.seed)


def test_the_command_is_what_is_typed() -> None:
    """A shell makes the words out of the command, also where a change has characters that it minds."""
    odd = replace(CELL, changes=("name=a b;c",))
    assert shlex.split(odd.command) == ["swarmproof", "fly", *odd.words]


def test_the_setting_is_the_cells() -> None:
    """Every field shows in what is flown; loss is drawn from the cell's seed for its UAVs and CUs."""
    setting = CELL.setting()
    assert (setting.cus, setting.trigger, setting.seed) == (3, Trigger.DT, 7)
    assert (setting.scenario.name, setting.scenario.uavs, setting.scenario.hold) == ("random", 5, 20)
    assert setting.semantics.name().startswith("ignore-loss")
    lost, expected = CELL.losses(5), parse("iid:0.25", 5, 3, 7)
    other = replace(CELL, seed=8).losses(5)
    differs = False
    for k in range(20):
        for name in Losses.__dataclass_fields__:
            array, right, wrong = (getattr(one.losses(k), name) for one in (lost, expected, other))
            assert np.array_equal(array, right)
            differs |= not np.array_equal(array, wrong)
    assert differs


def test_ids_tell_cells_apart() -> None:
    """A cell that differs in any one field has another id; an equal one has the same."""
    assert len({cell.id for cell in (CELL, *OTHERS.values())}) == 1 + len(OTHERS)
    assert set(OTHERS) == set(Cell.__dataclass_fields__)
    assert replace(CELL, changes=("hold=20", "uavs=5")).id != CELL.id
    assert replace(CELL).id == CELL.id


def test_an_id_is_for_ever() -> None:
    """Published tables and folders of results name cells by their ids: the same in every process and version."""
    assert Cell("crossing", 2, "HT", "none", "guarded", 0, 60).id == "311258ca0c"
    assert replace(CELL, series=True).id == "eaa30ab999"


def test_ids_are_long_enough() -> None:
    """Among all cells that are flown for one experiment, two share an id with less than one in a hundred thousand."""
    assert len(CELL.id) == DIGITS
    assert set(CELL.id) <= set("0123456789abcdef")
    cells = 4000
    assert Fraction(cells * (cells - 1) // 2, 16**DIGITS) < Fraction(1, 10**5)


@pytest.mark.parametrize(
    ("cell", "why"),
    [
        (replace(CELL, scenario="nowhere"), "no scenario"),
        (replace(CELL, cus=0), "--cus 0"),
        (replace(CELL, trigger="XX"), "no trigger"),
        (replace(CELL, preset="brave"), "brave"),
        (replace(CELL, changes=("spread=3",)), "spread"),
    ],
)
def test_what_cannot_be_flown_is_bad_input(cell: Cell, why: str) -> None:
    """A cell that is nonsense is told in one sentence, once it is to be flown."""
    with pytest.raises(BadInput, match=why) as error:
        cell.setting()
    assert "\n" not in str(error.value)


def test_a_loss_that_there_is_not_is_bad_input() -> None:
    """So is a loss model that there is not."""
    with pytest.raises(BadInput, match="fog"):
        replace(CELL, loss="fog").losses(5)
