"""Rows are tightened by as much as rounding can change: a coarse unit makes no plan fail."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dmpc_swarm.flight.settings import HORIZON, SPACE, a_task, hover, setting
from tests.margin.settings import TILTED, examples

from swarmproof.dmpc_swarm.flight.judge import Flown
from swarmproof.dmpc_swarm.flight.run import fly
from swarmproof.dmpc_swarm.planner import problem
from swarmproof.dmpc_swarm.planner.planner import Planner
from swarmproof.dmpc_swarm.planner.problem import SPARE, Model
from swarmproof.errors import BadInput
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import COARSEST, Bounds, Floats, Lattice
from swarmproof.scenario.scenario import Weights, load
from swarmproof.theorem3.parameters import Parameters


def coarse(*changes: str, horizon: int = HORIZON, n: int = COARSEST) -> Lattice:
    """Return the lattice of the published parameters with changes; its unit is 2⁻ⁿ m/s³."""
    parameters = Parameters().with_changes([SPACE, *changes])
    return Lattice(parameters, horizon, Fraction(1, 2**n), Bounds.of(parameters))


#: Short and long horizons, and a scaling that mixes the axes.
LATTICES = {
    "usual": coarse(),
    "short": coarse(horizon=3),
    "long": coarse(horizon=40, n=18),
    "tilted": coarse(TILTED, horizon=10),
}


def excess(units: Lattice, jerks: Floats) -> tuple[float, float]:
    """Return what rounding changes of a plan, in shares of what is spared: the most of all planes, and of all bounds.

    Args:
        units: a lattice.
        jerks: in its units, shape (H, 3); before they are rounded, the last two of them are made such that the plan
            ends at rest.
    """
    planner = Planner(units, Weights())
    model, horizon, m = planner.model_of(0), units.horizon, units.steps
    jerks = jerks.copy()
    weights = np.arange(horizon - 1, 1, -1) @ jerks[:-2]
    jerks[-2], jerks[-1] = -weights, weights - jerks[:-2].sum(axis=0)
    task = a_task(hover(units, (0, 0, 1.7)), {})
    plan = planner.rounded(task, (jerks * float(units.jerk_unit)).T.ravel())
    assert plan.at_rest
    off = plan.jerks - jerks
    positions = units.from_jerks @ off * model.units[0]
    kinds = [positions[m::m], units.velocity_from_jerks[1:] @ off * model.units[1]]
    kinds += [units.acceleration_from_jerks[1:] @ off * model.units[2], off * model.units[3]]
    of_bounds = np.concatenate([kind.ravel(order="F") for kind in kinds])
    spare = model.spare_of_bounds[: 12 * horizon].reshape(3, 4, horizon).transpose(1, 0, 2).ravel()
    apart = np.linalg.norm(positions @ model.theta_inverse.T, axis=1)
    return float(apart.max() / model.spare_of_planes), float((np.abs(of_bounds) / spare).max())


def worst(units: Lattice) -> tuple[float, float]:
    """Return the largest :func:`excess` of jerks that are rounded the wrong way, each for one row."""
    model = Model(units, Weights())
    per_unit = model.units / model.units[3]
    samples, speeds, accelerations = (
        matrix * unit
        for matrix, unit in zip(
            (units.from_jerks[1:], units.velocity_from_jerks[1:], units.acceleration_from_jerks[1:]),
            per_unit,
            strict=False,
        )
    )
    rest = np.eye(units.horizon)[:, :-2]
    weights = np.arange(units.horizon - 1, 1, -1)
    rest[-2:] = -weights, weights - 1
    rows = np.concatenate([samples, speeds, accelerations, np.eye(units.horizon)]) @ rest
    # 0.499 above or below a whole number
    found = []
    for row in rows:
        jerks = np.zeros((units.horizon, 3))
        jerks[:-2] = 0.499 * np.sign(row)[:, None]
        found.append(excess(units, jerks))
    planes, bounds = zip(*found, strict=True)
    return max(planes), max(bounds)


@pytest.mark.parametrize("units", LATTICES.values(), ids=LATTICES)
@given(st.data())
@examples(40)
def test_rounding_changes_no_more_than_is_spared(units: Lattice, data: st.DataObject) -> None:
    """Whatever jerks are rounded, no row changes by more than it is tightened."""
    random = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    jerks = random.uniform(-0.5, 0.5, (units.horizon, 3))
    jerks = np.where(random.random(jerks.shape) < data.draw(st.floats(0, 1)), np.sign(jerks) * 0.499, jerks)
    assert max(excess(units, jerks + random.integers(-1000, 1000, jerks.shape))) <= 1


@pytest.mark.parametrize("units", LATTICES.values(), ids=LATTICES)
def test_what_is_spared_is_needed(units: Lattice) -> None:
    """The worst jerks need most of what is spared, and not more."""
    planes, bounds = worst(units)
    assert 0.4 < planes <= 1
    assert 0.75 < bounds <= 0.81


def test_the_last_two_jerks_are_thought_of(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the last two jerks, which restore rest, were not counted, rows would change by more than is spared."""
    with monkeypatch.context() as patched:

        def forgetful(lattice: Lattice) -> Floats:
            return 0.5 * float(lattice.jerk_unit) * np.eye(lattice.horizon)[:, :-2]

        patched.setattr(problem, "_rounded_off", forgetful)
        for units in LATTICES.values():
            assert max(worst(units)) > 1.2
    assert max(worst(LATTICES["usual"])) <= 1


def test_too_coarse_a_lattice_is_refused() -> None:
    """Where rounding would take away much of a bound, there is no planner, and one sentence says so."""
    with pytest.raises(BadInput, match=r"^d_hat_min=0\.25 is too small for the units of this flight, .*fewer rounds"):
        Model(coarse(horizon=40), Weights())


def test_fine_lattices_are_as_they_were() -> None:
    """With the finest unit, all that is spared is for the solver's tolerance, a micrometre."""
    model = Model(setting("crossing").flight().lattice, Weights())
    assert model.spare_of_planes == SPARE
    assert (model.spare_of_bounds == SPARE).all()


# In flights


def large(rounds: int, *changes: str) -> Flown:
    """Fly the beginning of a flight in 20 km of space: only a coarse lattice holds what `rounds` rounds can reach."""
    far = "workspace=-10000,10000,-10000,10000,0,10000"
    what = setting(replace(load("crossing", 0, [far, *changes]), rounds=rounds))
    flight = what.flight()
    assert flight.lattice.jerk_unit >= Fraction(1, 2**22)
    return fly(what, parse("none", 2, 2, 0), 40, flight=flight)[0]


LARGE: tuple[tuple[int, tuple[str, ...]], ...] = (
    (100_000, ()),
    (5000, ("v_max=20", "a_max=20", "j_max=40")),
    (5000, ("horizon=40",)),
    (20_000, ("horizon=30",)),
)


@pytest.mark.parametrize(("rounds", "changes"), LARGE)
def test_a_coarse_lattice_rejects_no_answer(rounds: int, changes: tuple[str, ...]) -> None:
    """Whatever the solver answers in a large space, a plan comes out, and no claim is violated."""
    seen = large(rounds, *changes)
    assert seen.qps.solved == 40
    assert seen.qps.rejected == 0
    assert not seen.violated


def test_too_little_spare_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """If rows were tightened by a micrometre, whatever the unit, answers would be rejected in some of these flights."""

    def little(model: Model, samples: Floats, bounded: Floats) -> tuple[float, Floats]:
        return SPARE, np.full(24 * model.lattice.horizon, SPARE)

    monkeypatch.setattr(Model, "_spare", little)
    seen = [large(rounds, *changes) for rounds, changes in LARGE]
    assert sum(one.qps.rejected for one in seen) > 0
