"""A scenario: the swarm's parameters, the flying space, where every UAV starts, and its targets by round.

:func:`load` reads one that ships with the project, or a TOML file:

    name = "swap"           # what reports call it
    rounds = 60             # length of a flight where no other is asked for, 1 … 100000
    horizon = 15            # H in periods T, 2 … 40; optional
    [parameters]            # names and units as for `margin`; what is not given is published
    workspace = [[-1.7, 1.7], [-1.7, 1.7], [0.4, 3.0]]    # the flying space, m: low and high of x, y, z; needed
    [weights]               # of the cost, optional: position, speed, acceleration, jerk, band, band_width (m)
    band = 5
    [start]                 # where the UAVs hover at first: positions, or a formation (see below)
    positions = [[-0.6, 0, 1], [0.6, 0.05, 1]]            # [x, y, z] in m, one for each UAV
    [[targets]]             # the same, with the round from which on they hold; the first is of round 0
    round = 0
    positions = [[0.6, 0.05, 1], [-0.6, 0, 1]]

Instead of `positions`, `formation` names one, with its own keys (m; `centre` is [0, 0] if not given; see `formations`):

    circle     radius, height, centre
    line       spacing, height, centre
    plane      spacing, height, centre
    pyramid    side, height, rise, centre
    cube       side, height, centre
    sphere     radius, height, turn (degrees), centre
    random     separation (scaled distance between any two)
    antipodes  centre; only as targets: every start mirrored at the vertical line through the centre

In [start], a formation needs `uavs`, how many there are. Random targets can have `every`: from their round on, there
are new ones every so many rounds, for ever; this must be the last [[targets]].

Beside `horizon`, a fault can be given: `tolerance` (m, 0 if not given) is by how much plans may violate rows of (13f),
in scaled distance; `tolerance_halfway` changes it for the rows that are midway between UAVs. The claims are checked as
ever.

UAVs are numbered from 0. Numbers are read exactly. Coordinates are then rounded to floats, and it is decided exactly
that these are in the flying space and at least d̂_min apart. A flight rounds them once more, to its lattice of about
1e-12 m, and has to check them again.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from swarmproof.scenario.definition import (
    EXACT,
    FEWEST_UAVS,
    LONGEST_HORIZON,
    MOST_ROUNDS,
    MOST_UAVS,
    SHORTEST_HORIZON,
    WEIGHTS,
    Redraw,
    Scenario,
    TargetChange,
    Tolerance,
    Weights,
    check_separation,
    flying_space,
    label,
)
from swarmproof.scenario.formations import FORMATIONS, antipodes
from swarmproof.scenario.points import Point, draw
from swarmproof.scenario.tables import Table, as_table, centre, number, only, points, subtable, text, whole, within
from swarmproof.semantics.switches import BadInput
from swarmproof.theorem3.parameters import Parameters, near_match, read_toml, shown

__all__ = ["EXACT", "SHIPPED", "Point", "Redraw", "Scenario", "TargetChange", "Tolerance", "Weights", "load"]

#: The scenarios that ship; each is a TOML file beside this module.
SHIPPED: tuple[str, ...] = ("circle", "formations", "crossing", "random")

DEFAULT_HORIZON = 15
_TOLERANCES = _FULL, _HALFWAY = ("tolerance", "tolerance_halfway")
MOST_NAME = 60


def load(name_or_path: str, seed: int = 0, changes: Iterable[str] = ()) -> Scenario:
    """Return the scenario that ships under this name, or that of the TOML file with this path.

    Args:
        name_or_path: one of :data:`SHIPPED`, or a path; ``./circle`` is a path.
        seed: of all random points; the same seed gives the same points.
        changes: ``NAME=VALUE`` for a parameter, ``horizon=H``, ``tolerance=M``, ``tolerance_halfway=M``, or, if no
            positions are given, ``uavs=N``.

    Raises:
        BadInput: there is no such scenario, or something in it cannot be.
    """
    if name_or_path in SHIPPED:
        place, path = f"scenario {name_or_path}", Path(__file__).with_name(f"{name_or_path}.toml")
    else:
        place, path = name_or_path, Path(name_or_path)
        if path.name == name_or_path and not path.suffix and not os.path.exists(name_or_path):
            raise BadInput(
                f"there is no scenario {shown(name_or_path)}, and no such file: {near_match(name_or_path, SHIPPED)}"
            )
    table = read_toml(path, "scenario", "rounds = 60")
    with within(place):
        return _scenario(table, seed, changes)


def _scenario(table: Table, seed: int, changes: Iterable[str]) -> Scenario:
    """Return the scenario in the file's `table`, with `changes`."""
    only(table, ("name", "rounds", "horizon", *_TOLERANCES, "parameters", "weights", "start", "targets"))
    own, of_parameters = _split(changes)
    parameters = Parameters.from_table("[parameters]", subtable(table, "parameters"), of_parameters)
    flying_space(parameters)
    start, targets = subtable(table, "start"), table.get("targets")
    if not isinstance(targets, list) or not targets:
        raise BadInput("the targets are missing: write a line [[targets]], and lines such as round = 0 below it")
    changing = [as_table(raw, "[[targets]]") for raw in targets]
    if "uavs" in own:
        if any("positions" in part for part in (start, *changing)):
            raise BadInput("uavs cannot be changed, since the positions are given one by one")
        start = {**start, "uavs": own["uavs"]}
    reader = _Reader(parameters, seed)
    with within("[start]"):
        starts = reader.starts(start)
    listed: list[TargetChange] = []
    redraw = None
    for part in changing:
        with within(f"the table {len(listed) + 1} of [[targets]]"):
            if redraw:
                raise BadInput("it comes after random targets with every, which must be the last")
            change, redraw = reader.targets(part, starts)
            listed.append(change)
    return Scenario(
        name=text(table, "name", MOST_NAME),
        parameters=parameters,
        horizon=whole({"horizon": DEFAULT_HORIZON, **table, **own}, "horizon", SHORTEST_HORIZON, LONGEST_HORIZON),
        weights=_weights(as_table(table.get("weights", {}), "[weights]")),
        starts=starts,
        targets=tuple(listed),
        rounds=whole(table, "rounds", 1, MOST_ROUNDS),
        redraw=redraw,
        tolerance=_tolerance({**table, **own}),
    )


def _tolerance(table: Table) -> Tolerance:
    full = number({_FULL: 0, **table}, _FULL)
    return Tolerance(full, number(table, _HALFWAY) if _HALFWAY in table else full)


def _split(changes: Iterable[str]) -> tuple[dict[str, object], list[str]]:
    """Return what is changed of the scenario itself, by name, and the changes of parameters."""
    own: dict[str, object] = {}
    of_parameters = []
    for change in changes:
        name, equals, value = change.partition("=")
        if equals and name.strip() in ("uavs", "horizon", *_TOLERANCES):
            own[name.strip()] = value
        else:
            of_parameters.append(change)
    return own, of_parameters


def _weights(table: Table) -> Weights:
    with within("[weights]"):
        only(table, WEIGHTS)
        return Weights(**{name: float(number(table, name)) for name in table})


@dataclass(frozen=True, slots=True)
class _Reader:
    """Reads the tables [start] and [[targets]]."""

    parameters: Parameters
    seed: int

    def starts(self, table: Table) -> tuple[Point, ...]:
        """Return where the table [start] places the UAVs."""
        if "positions" in table:
            only(table, ("positions",))
            return points(table["positions"])
        formation = _formation(table, (*FORMATIONS, "random"))
        uavs = whole(table, "uavs", FEWEST_UAVS, MOST_UAVS)
        return self._stand(formation, table, ("formation", "uavs"), uavs, "start")

    def targets(self, table: Table, starts: Sequence[Point]) -> tuple[TargetChange, Redraw | None]:
        """Return the change that a table [[targets]] describes, and how it goes on if it has `every`."""
        begin = whole(table, "round", 0, MOST_ROUNDS)
        if "positions" in table:
            only(table, ("round", "positions"))
            return TargetChange(begin, points(table["positions"])), None
        formation = _formation(table, (*FORMATIONS, "random", "antipodes"))
        if formation == "antipodes":
            only(table, ("round", "formation", "centre"))
            return TargetChange(begin, antipodes(starts, centre(table))), None
        again = ("every",) if formation == "random" else ()
        there = self._stand(formation, table, ("round", "formation", *again), len(starts), label(begin))
        redraw = None
        if "every" in table:
            redraw = Redraw(whole(table, "every", 1, MOST_ROUNDS), number(table, "separation"), self.seed)
        return TargetChange(begin, there), redraw

    def _stand(self, formation: str, table: Table, known: Sequence[str], uavs: int, what: str) -> tuple[Point, ...]:
        """Return `uavs` points in this formation; `table` has its keys and the `known` ones, `what` labels the draw."""
        if formation == "random":
            only(table, (*known, "separation"))
            separation = number(table, "separation")
            check_separation(separation, self.parameters)
            space = flying_space(self.parameters)
            return draw(space, self.parameters.theta_inverse, uavs, separation, self.seed, what)
        make, numbers = FORMATIONS[formation]
        only(table, (*known, *numbers, "centre"))
        return make(uavs, centre(table), **{name: float(number(table, name)) for name in numbers})


def _formation(table: Table, known: Sequence[str]) -> str:
    name = table.get("formation")
    if name is None:
        raise BadInput('neither positions nor a formation is given: write a line such as formation = "circle"')
    if not isinstance(name, str) or name not in known:
        raise BadInput(
            f"there is no formation {shown(name)} here: {near_match(name if isinstance(name, str) else '', known)}"
        )
    return name
