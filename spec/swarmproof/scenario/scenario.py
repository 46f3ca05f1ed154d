"""A scenario: the swarm's parameters, the flying space, where every UAV starts, and its targets by round.

:func:`load` reads one that ships with the project, or a TOML file:

    name = "swap"           # what reports call it
    rounds = 60             # length of a flight where no other is asked for, 1 … 100000
    horizon = 15            # H in periods T, 2 … 60; optional
    [parameters]            # names and units as for `margin`; what is not given is published
    workspace = [[-1.7, 1.7], [-1.7, 1.7], [0.4, 3.0]]    # the flying space, m: low and high of x, y, z; needed
    [weights]               # of the cost, optional: position, speed, acceleration, jerk, band, band_width (m)
    band = 5
    [start]                 # where the UAVs hover at first: positions, or a formation (see below)
    positions = [[-0.6, 0, 1], [0.6, 0.05, 1]]            # [x, y, z] in m, one for each UAV
    [[targets]]             # the same, with the round from which on they hold; the first is of round 0
    round = 0
    positions = [[0.6, 0.05, 1], [-0.6, 0, 1]]

UAVs that differ are of kinds, optional; who is in no kind, and what a kind does not give, is as in [parameters]:

    [[kinds]]
    name = "large"          # for people; optional
    uavs = [0, 3]           # who is of this kind
    d_hat_min = 0.6         # m: what two of these keep; also v_max, a_max, j_max, v_norm, a_norm, j_norm, d_min,
    v_max = 1.5             # theta_inverse, crash_theta_inverse and tracking_error

Two UAVs of different kinds keep the mean of their distances, which is the sum of their radii (`theorem3.fleet`).

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

Beside `horizon`, starts and targets can be changed:

    jitter = 0.02             # m: each start is moved by up to this per axis, at random, within the flying space
    assignment = "shuffled"   # the targets of each change are permuted at random; "listed", as they are, if not given
    hold = 250                # rounds between changes of the targets, from round 0 on; `round` is not needed then

    begin = "anyhow"          # starts and targets may be closer than d_hat_min; "apart", if not given
    repeat = 400              # the [[targets]] begin anew every so many rounds, more than the round of the last one

Targets may move: `velocity = [0.1, 0, 0]` (m/s) in [[targets]] moves them on from their round until the next ones.

Mirrored targets are those of the undisturbed starts. `hold` makes the flight as long as all targets hold; if random
targets have `every`, it replaces that, and `rounds` stays. These are not shuffled: every change draws anew.

The table [choices], optional, has what the planner does where the paper is silent: see :class:`Choices`.

Beside `horizon`, a fault can be given: `tolerance` (m, 0 if not given) is by how much plans may violate rows of (13f),
in scaled distance; `tolerance_halfway` changes it for the rows that are midway between UAVs. The claims are checked as
ever.

UAVs are numbered from 0. Numbers are read exactly, and it is decided exactly that starts and targets are in the flying
space and at least d̂_min apart. Coordinates may be those of a map: up to 1e7 m. A side of the flying space that is
`inf` is no limit. A file may be 16 MB long.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from swarmproof.errors import BadInput
from swarmproof.scenario.choices import CHOICES, LEAST_ROUNDS, MOST_ROUNDS, USUAL, WORDS, Choices
from swarmproof.scenario.definition import (
    ASSIGNMENTS,
    BEGINNINGS,
    DEFAULT_HORIZON,
    EXACT,
    FEWEST_UAVS,
    LONGEST_HORIZON,
    MOST_UAVS,
    SHORTEST_HORIZON,
    STILL,
    WEIGHTS,
    Redraw,
    Scenario,
    TargetChange,
    Tolerance,
    Weights,
    check_apart,
    check_separation,
    check_within,
    flying_space,
    label,
)
from swarmproof.scenario.formations import FORMATIONS, antipodes
from swarmproof.scenario.points import Point, disturbed, draw, shuffled
from swarmproof.scenario.tables import (
    Table,
    as_table,
    centre,
    not_negative,
    number,
    only,
    points,
    subtable,
    text,
    velocity,
    whole,
    within,
    word,
)
from swarmproof.theorem3.fleet import Fleet, Kind, read_kinds
from swarmproof.theorem3.numbers import ENTRY, near_match, read_toml, shown
from swarmproof.theorem3.parameters import NAMES, Parameters
from swarmproof.theorem3.values import OF_A_KIND

__all__ = [
    "DEFAULT_HORIZON",
    "EXACT",
    "SHIPPED",
    "USUAL",
    "Choices",
    "Point",
    "Redraw",
    "Scenario",
    "TargetChange",
    "Tolerance",
    "Weights",
    "load",
]

#: The scenarios that ship; each is a TOML file beside this module.
SHIPPED: tuple[str, ...] = ("circle", "formations", "crossing", "random")

_TOLERANCES = _FULL, _HALFWAY = ("tolerance", "tolerance_halfway")
#: The optional keys of a scenario itself that can be changed; ``uavs`` can be, too.
_OWN = ("horizon", *_TOLERANCES, "jitter", "assignment", "hold", "begin", "repeat")
#: By table, the names in it that can be changed, besides the parameters. No two of all these names are equal.
CHANGEABLE: dict[str, tuple[str, ...]] = {"": ("uavs", *_OWN), "weights": WEIGHTS, "choices": CHOICES}
MOST_NAME = 60
#: How long a scenario file may be: recorded missions list the targets of every round.
MOST_BYTES = 16_000_000


def load(name_or_path: str, seed: int = 0, changes: Iterable[str] = ()) -> Scenario:
    """Return the scenario that ships under this name, or that of the TOML file with this path.

    Args:
        name_or_path: one of :data:`SHIPPED`, or a path; ``./circle`` is a path.
        seed: of all random points; the same seed gives the same points.
        changes: ``NAME=VALUE`` for a parameter, a weight, a choice, ``horizon``, ``tolerance``, ``tolerance_halfway``,
            ``jitter``, ``assignment``, ``hold``, or, if no positions are given, ``uavs``.

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
    table = read_toml(path, "scenario", "rounds = 60", MOST_BYTES)
    with within(place):
        return _scenario(table, seed, changes)


def _scenario(table: Table, seed: int, changes: Iterable[str]) -> Scenario:
    """Return the scenario in the file's `table`, with `changes`."""
    only(table, ("name", "rounds", *_OWN, "parameters", "kinds", "weights", "choices", "start", "targets"))
    of, of_parameters = _split(changes)
    own: Table = {**table, **of[""]}
    parameters = Parameters.from_table("[parameters]", subtable(table, "parameters"), of_parameters)
    flying_space(parameters)
    kinds = read_kinds(table["kinds"], parameters) if "kinds" in table else ()
    start, targets = subtable(table, "start"), table.get("targets")
    if not isinstance(targets, list) or not targets:
        raise BadInput("the targets are missing: write a line [[targets]], and lines such as round = 0 below it")
    changing = [as_table(raw, "[[targets]]") for raw in targets]
    if "uavs" in own:
        if any("positions" in part for part in (start, *changing)):
            raise BadInput(
                "uavs cannot be changed, since the positions are given one by one: give a formation to have a number, "
                'such as formation = "circle"'
            )
        start = {**start, "uavs": own["uavs"]}
    rounds = whole(table, "rounds", 1, MOST_ROUNDS)
    hold = whole(own, "hold", 1, MOST_ROUNDS // len(changing)) if "hold" in own else None
    if hold is not None:
        changing = [_held(part, c, hold) for c, part in enumerate(changing)]
        rounds = rounds if "every" in changing[-1] else hold * len(changing)
    reader = _Reader(parameters, kinds, seed)
    with within("[start]"):
        starts = reader.starts(start)
    fleet = Fleet.of(parameters, kinds, len(starts))
    if kinds and sum(len(kind.uavs) for kind in kinds) == len(starts):
        # what every kind gives is no published value by default
        of_all = {name for name in OF_A_KIND if all(name in kind.parameters.given for kind in kinds)}
        parameters = replace(parameters, given=parameters.given | of_all)
    assignment = word({"assignment": ASSIGNMENTS[0], **own}, "assignment", ASSIGNMENTS)
    listed, redraw = reader.all_targets(changing, starts, assignment)
    jitter = not_negative({"jitter": 0, **own}, "jitter")
    begin = word({"begin": BEGINNINGS[0], **own}, "begin", BEGINNINGS)
    if jitter:
        # what it moves back into the flying space must have been there before
        check_within("start", "", starts, flying_space(parameters))
        if begin == BEGINNINGS[0]:
            check_apart("start", "", starts, fleet)
    return Scenario(
        name=text(table, "name", MOST_NAME),
        parameters=parameters,
        horizon=whole({"horizon": DEFAULT_HORIZON, **own}, "horizon", SHORTEST_HORIZON, LONGEST_HORIZON),
        weights=_weights({**as_table(table.get("weights", {}), "[weights]"), **of["weights"]}),
        starts=disturbed(starts, flying_space(parameters), jitter, seed),
        targets=listed,
        rounds=rounds,
        redraw=redraw,
        tolerance=_tolerance(own),
        choices=_choices({**as_table(table.get("choices", {}), "[choices]"), **of["choices"]}),
        jitter=jitter,
        assignment=assignment,
        hold=hold,
        begin=begin,
        repeat=whole(own, "repeat", 1, MOST_ROUNDS) if "repeat" in own else None,
        kinds=kinds,
    )


def _held(part: Table, c: int, hold: int) -> Table:
    """Return the table `part` of [[targets]], the c-th from 0 on, for changes that are `hold` rounds apart."""
    return {**part, "round": c * hold, **({"every": hold} if "every" in part else {})}


def _tolerance(table: Table) -> Tolerance:
    full = number({_FULL: 0, **table}, _FULL)
    return Tolerance(full, number(table, _HALFWAY) if _HALFWAY in table else full)


def _split(changes: Iterable[str]) -> tuple[dict[str, dict[str, object]], list[str]]:
    """Return what is changed, by the tables of :data:`CHANGEABLE` and by name, and the changes of parameters.

    Raises:
        BadInput: there is nothing of such a name.
    """
    home = {name: table for table, names in CHANGEABLE.items() for name in names}
    changed: dict[str, dict[str, object]] = {table: {} for table in CHANGEABLE}
    of_parameters = []
    for change in changes:
        name, equals, value = change.partition("=")
        name = name.strip()
        if equals and name in home:
            changed[home[name]][name] = value.strip()
        elif equals and name not in NAMES:
            raise BadInput(f"--set: there is no parameter {shown(name)}: {near_match(name, (*NAMES, *home))}")
        else:
            of_parameters.append(change)
    return changed, of_parameters


def _choices(table: Table) -> Choices:
    with within("[choices]"):
        only(table, CHOICES)
        read: dict[str, Any] = {}
        for name in table:
            if name in WORDS:
                read[name] = word(table, name, WORDS[name])
            elif name in LEAST_ROUNDS:
                read[name] = whole(table, name, LEAST_ROUNDS[name], MOST_ROUNDS)
            else:
                read[name] = float(not_negative(table, name))
        return Choices(**read)


def _weights(table: Table) -> Weights:
    with within("[weights]"):
        only(table, WEIGHTS)
        return Weights(**{name: float(number(table, name, ENTRY)) for name in table})


@dataclass(frozen=True, slots=True)
class _Reader:
    """Reads the tables [start] and [[targets]]."""

    parameters: Parameters
    kinds: tuple[Kind, ...]
    seed: int

    def starts(self, table: Table) -> tuple[Point, ...]:
        """Return where the table [start] places the UAVs."""
        if "positions" in table:
            only(table, ("positions",))
            return points(table["positions"])
        formation = _formation(table, (*FORMATIONS, "random"))
        uavs = whole(table, "uavs", FEWEST_UAVS, MOST_UAVS)
        return self._stand(formation, table, ("formation", "uavs"), uavs, "start")

    def all_targets(
        self, tables: Sequence[Table], starts: Sequence[Point], assignment: str
    ) -> tuple[tuple[TargetChange, ...], Redraw | None]:
        """Return the changes that the `tables` [[targets]] describe, assigned so, and how the last one goes on."""
        listed: list[TargetChange] = []
        redraw = None
        for table in tables:
            with within(f"the table {len(listed) + 1} of [[targets]]"):
                if redraw:
                    raise BadInput("it comes after random targets with every, which must be the last")
                change, redraw = self.targets(table, starts)
                if assignment != ASSIGNMENTS[0]:
                    if redraw:
                        raise BadInput("random targets with every are drawn anew each time: assignment must be listed")
                    order = f"assignment {len(listed)}"
                    change = replace(change, points=shuffled(change.points, self.seed, order))
                listed.append(change)
        return tuple(listed), redraw

    def targets(self, table: Table, starts: Sequence[Point]) -> tuple[TargetChange, Redraw | None]:
        """Return the change that a table [[targets]] describes, and how it goes on if it has `every`."""
        begin = whole(table, "round", 0, MOST_ROUNDS)
        moving = velocity(table, "velocity") if "velocity" in table else STILL
        if "positions" in table:
            only(table, ("round", "velocity", "positions"))
            return TargetChange(begin, points(table["positions"]), moving), None
        formation = _formation(table, (*FORMATIONS, "random", "antipodes"))
        if formation == "antipodes":
            only(table, ("round", "velocity", "formation", "centre"))
            return TargetChange(begin, antipodes(starts, centre(table)), moving), None
        again = ("every",) if formation == "random" and "every" in table else ("velocity",)
        there = self._stand(formation, table, ("round", "formation", *again), len(starts), label(begin))
        redraw = None
        if "every" in table:
            redraw = Redraw(whole(table, "every", 1, MOST_ROUNDS), number(table, "separation"), self.seed)
        return TargetChange(begin, there, moving), redraw

    def _stand(self, formation: str, table: Table, known: Sequence[str], uavs: int, what: str) -> tuple[Point, ...]:
        """Return `uavs` points in this formation; `table` has its keys and the `known` ones, `what` labels the draw."""
        if formation == "random":
            only(table, (*known, "separation"))
            if any(side is None for sides in self.parameters.workspace or () for side in sides):
                raise BadInput("random points need a flying space with limits, such as [[-2, 2], [-2, 2], [0, 3]]")
            separation = number(table, "separation")
            widest = Fleet.of(self.parameters, self.kinds, uavs).widest
            check_separation(separation, widest)
            return draw(flying_space(widest), widest.theta_inverse, uavs, separation, self.seed, what)
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
