"""The table of pairs: its verdicts, that planned errors change them, and that flights know the same pairs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations, pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dmpc_swarm.flight.flights import record
from tests.dmpc_swarm.flight.settings import lattice, setting

from swarmproof.algebra.statement import Condition, Statement
from swarmproof.claims.proof import ProofVerdict
from swarmproof.dmpc_swarm.evidence.separation import BOTH_NEW, ONE_NEW, ONE_NEW_HALFWAY
from swarmproof.dmpc_swarm.flight.state import Round
from swarmproof.dmpc_swarm.pair_table import UNDER_20, audit_cells
from swarmproof.dmpc_swarm.planner.accept import right_side
from swarmproof.dmpc_swarm.proofs.terms import separation
from swarmproof.dmpc_swarm.proofs.terms.cells import Cell, Lemma, Role, cells
from swarmproof.dmpc_swarm.proofs.terms.separation import I_NEW, I_OLD, J_OLD, D, both_new, one_new, plane
from swarmproof.dmpc_swarm.protocol.messages import Metadata
from swarmproof.prove.decide import answer
from swarmproof.prove.evidence import Certificate

PROVED = str(ProofVerdict.PROVED)
C1, L3, L4 = Lemma.COROLLARY_1, Lemma.LEMMA_3, Lemma.LEMMA_4

#: Which lemma covers each pair, and what follows from what it states.
EXPECTED: dict[str, tuple[Lemma | None, str]] = {
    "Pn-Pn": (C1, PROVED),
    "Pn-Po": (None, UNDER_20),
    "Pn-S1": (L3, UNDER_20),
    "Pn-S2": (L3, UNDER_20),
    "Pn-U1": (L3, PROVED),
    "Pn-U2": (L3, PROVED),
    "Po-Po": (None, UNDER_20),
    "Po-S1": (None, UNDER_20),
    "Po-S2": (None, UNDER_20),
    "Po-U1": (None, UNDER_20),
    "Po-U2": (None, UNDER_20),
}
EXPECTED |= {
    f"{i}-{j}": (L4, PROVED) for n, i in enumerate(("S1", "S2", "U1", "U2")) for j in ("S1", "S2", "U1", "U2")[n:]
}


def test_the_table_is_as_recorded() -> None:
    """All 21 cells have their lemma and their verdict."""
    assert {each.cell.id: (each.cell.lemma, each.verdict) for each in audit_cells()} == EXPECTED


def test_a_cell_of_which_nothing_is_known_is_not_decided() -> None:
    """A cell's verdict is no better than the answers behind it."""
    cell = next(each for each in audit_cells() if each.verdict == UNDER_20)
    undecided = replace(cell.stated, verdict=ProofVerdict.UNDECIDED)
    assert replace(cell, stated=undecided).verdict == ProofVerdict.UNDECIDED
    assert replace(cell, with_20=undecided).verdict == ProofVerdict.UNDECIDED
    assert replace(cell, with_20=cell.stated).verdict == ProofVerdict.FALSE


PROOFS: dict[str, tuple[Statement, Certificate]] = {
    "both new": (both_new(), BOTH_NEW),
    "one new": (one_new(False, False), ONE_NEW),
    "one new, halfway": (one_new(True, True), ONE_NEW_HALFWAY),
}


def _further(statement: Statement) -> Statement:
    value = statement.conclusion.value - D * D / 1000
    return replace(statement, conclusion=replace(statement.conclusion, value=value))


def _reversed_plane(statement: Statement) -> Statement:
    def turned(each: Condition) -> Condition:
        return replace(each, value=-each.value) if each.name == separation.OF_I else each

    return replace(statement, hypotheses=tuple(map(turned, statement.hypotheses)))


def _nearer_plane(statement: Statement) -> Statement:
    def nearer(each: Condition) -> Condition:
        return replace(each, value=each.value + D / 100) if each.name == separation.OF_I else each

    return replace(statement, hypotheses=tuple(map(nearer, statement.hypotheses)))


@pytest.mark.parametrize("change", [_further, _reversed_plane, _nearer_plane], ids=lambda change: change.__name__)
@pytest.mark.parametrize("name", PROOFS)
def test_a_planted_error_in_a_statement_is_not_proved(name: str, change: Callable[[Statement], Statement]) -> None:
    """A longer distance, a plane the wrong way round, or one that is nearer, and the certificate no longer checks."""
    statement, certificate = PROOFS[name]
    assert answer("", statement, certificate).verdict is ProofVerdict.PROVED
    assert answer("", change(statement), certificate).verdict is ProofVerdict.UNDECIDED


@pytest.mark.parametrize(
    ("name", "hypothesis"),
    [(name, each.name) for name, (statement, _) in PROOFS.items() for each in statement.hypotheses],
)
def test_every_hypothesis_is_used(name: str, hypothesis: str) -> None:
    """Without any one of its hypotheses, no statement about a new trajectory is proved by its certificate."""
    statement, certificate = PROOFS[name]
    assert answer("", statement.without(hypothesis), certificate).verdict is ProofVerdict.UNDECIDED


coordinates = st.integers(-6, 6)
points = st.tuples(coordinates, coordinates, coordinates)


@given(points, points, points, st.booleans(), st.integers(1, 6))
def test_the_plane_is_the_planners(
    own: tuple[int, ...], other: tuple[int, ...], new: tuple[int, ...], halfway: bool, distance: int
) -> None:
    """Constraint (15) as stated here is the one that the planner's acceptance decides, wherever ‖n‖ is rational."""
    normal = [b - a for a, b in zip(own, other, strict=True)]
    square = sum(x * x for x in normal)
    root = int(square**0.5 + 0.5)
    if root * root != square or not root:
        return
    units = lattice()
    # places in whole units of the lattice, where d̂_min is `distance` grid steps
    d = units.parameters.d_hat_min / units.pairs.unit
    step = d / distance
    assert step.denominator == 1
    values = {
        f"{name}_{axis}": x * step
        for name, place in {"i_old": own, "j_old": other, "i_new": new}.items()
        for axis, x in zip("xyz", place, strict=True)
    }
    stated = plane("", I_OLD, J_OLD, I_NEW, halfway).holds({**values, "l": root * step, "d": d})
    apart = [float((b - a) * step) for a, b in zip(new, other, strict=True)]
    assert right_side([float(x * step) for x in normal], apart, halfway, units) == stated


def _pairs(flown: Round) -> Iterator[Cell]:
    """Yield the cells of all pairs of UAVs in a round in which some CU planned."""
    tasks = [attempt.task for attempt in flown.computed.attempts if attempt is not None]
    if not tasks:
        return
    selected = frozenset[int]().union(*(task.selected for task in tasks))
    planned = {
        attempt.task.i
        for attempt in flown.computed.attempts
        if attempt is not None and attempt.planned.plan is not None
    }
    (entries, *_) = ({**{j: len(held) for j, held in task.others.items()}, task.i: 1} for task in tasks)
    before, after = flown.before.swarm.uavs, flown.after.swarm.uavs
    roles = [
        Role(i in selected, i in planned, entries[i], after[i].followed != before[i].followed)
        for i in range(len(before))
    ]
    for i, j in combinations(roles, 2):
        yield Cell(i, j) if Cell(i, j) in set(cells()) else Cell(j, i)


def test_flights_know_the_pairs_of_the_table() -> None:
    """Every pair of trajectories that UAVs fly is a cell of the table, and every cell but one is flown.

    The one needs a trigger that selects a UAV which was just planned before one that was not; Appendix A's give the
    former priority zero, but the proofs do not depend on the trigger.
    """
    seen: set[Cell] = set()
    # few UAVs for many CUs: then UAVs that have just been planned are selected again
    for uavs, cus in ((6, 4), (5, 3)):
        what = setting("circle", cus=cus, seed=2, changes=[f"uavs={uavs}"])
        for flown in record(what, "iid:0.1", rounds=150).rounds:
            seen.update(_pairs(flown))
    assert {cell.id for cell in cells()} - {cell.id for cell in seen} == {"S2-U1"}
    assert seen <= set(cells())


def _wrong_trackers(flown: Round, before: Round) -> int:
    """Return how many trackers of CUs that plan are not the virtual CU's: what was flown, and what was planned."""
    k = before.before.k
    attempts = enumerate(before.computed.attempts)
    new = {(each.task.i, w) for w, each in attempts if each is not None and each.planned.plan is not None}
    wrong = 0
    for w, attempt in enumerate(flown.computed.attempts):
        if attempt is None:
            continue
        for i, tracker in enumerate(flown.before.swarm.cus[w].trackers):
            held = {trajectory.metadata for trajectory in tracker.trajectories}
            virtual = {before.before.swarm.uavs[i].followed.metadata}
            virtual |= {Metadata(k, v) for j, v in new if j == i}
            wrong += held != virtual
    return wrong


@pytest.mark.parametrize(("semantics", "sound"), [("guarded", True), ("ignore-loss", False)])
def test_cus_that_plan_have_the_virtual_trackers(semantics: str, sound: bool) -> None:
    """Under `guarded`, what a CU plans with is what UAVs flew in the round before and what was planned in it: (R3).

    A CU that ignores loss plans with something else.
    """
    rounds = record(setting("circle", cus=3, seed=1, semantics=semantics), "iid:0.1", rounds=120).rounds
    wrong = sum(_wrong_trackers(flown, before) for before, flown in pairwise(rounds))
    assert (wrong == 0) is sound
    assert sum(attempt is not None for flown in rounds for attempt in flown.computed.attempts) > 50
