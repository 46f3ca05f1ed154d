"""Turns one flown round into what the claims look at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from swarmproof.dmpc_swarm.claims.flight import Approach, ObservedAttempt, ObservedRound
from swarmproof.dmpc_swarm.flight.separation_at_samples import Candidates, Mask, closest_at_samples, tracked
from swarmproof.dmpc_swarm.flight.state import FlightState, Name, Round
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.protocol.messages import Metadata
from swarmproof.monitor.bernstein import cubics
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.scenario.scenario import Scenario


@dataclass(frozen=True, eq=False)
class View:
    """What the valid trackers say at the start of a round.

    Attributes:
        known: the trajectories in trackers that are not deprecated.
        candidates: those, and the ones that were planned in the round before; None if there are none at all.
    """

    known: frozenset[Name]
    candidates: Candidates | None

    @classmethod
    def of(cls, lattice: Lattice, state: FlightState, new: Mapping[Name, Plan] | None = None) -> View:
        """Return the view of `state`, together with the trajectories `new`."""
        known = tracked(state)
        plans = {**{name: state.plans[name] for name in known}, **(new or {})}
        return cls(frozenset(known), Candidates(lattice, state.k, plans.items()) if plans else None)

    def closest(self, some: frozenset[Name], others: frozenset[Name], first: int = 1) -> Approach | None:
        """Return the closest approach of one of `some` and one of `others` at samples `first` … h_c."""
        return None if self.candidates is None else self.candidates.among(some, others, first)

    def unplanned(self, planned: set[int]) -> Approach | None:
        """Return the closest approach of known trajectories of UAVs that are not among `planned`."""
        names = frozenset(name for name in self.known if name[0] not in planned)
        return self.closest(names, names)


def observe_round(lattice: Lattice, before: View, flown: Round) -> tuple[ObservedRound, View]:
    """Return what the claims see of a round, and the view of the state after it, given that of the state before."""
    k = flown.before.k
    new: dict[Name, Plan] = {}
    attempts = []
    for w, attempt in enumerate(flown.computed.attempts):
        if attempt is None:
            continue
        planned = attempt.planned
        attempts.append(ObservedAttempt(w, attempt.task.i, planned.feasible, planned.plan is not None, planned.why))
        if planned.plan is not None:
            new[attempt.task.i, Metadata(k, w)] = planned.plan
    planned_uavs = {i for i, _ in new}
    after = View.of(lattice, flown.after, new)
    others = frozenset(name for name in after.known if name[0] not in planned_uavs)
    observed = ObservedRound(
        k,
        lattice.pairs.distance,
        known=before.closest(before.known, before.known, first=0),
        learned=after.closest(after.known, after.known, first=0),
        both_new=_both_new(after.candidates, flown, new),
        one_new=after.closest(frozenset(new), others),
        none_new_before=before.unplanned(planned_uavs),
        none_new_after=after.unplanned(planned_uavs),
        flown=closest_references(lattice, flown.before),
        attempts=attempts,
        underway=underway(flown.before),
    )
    return observed, after


def underway(state: FlightState) -> int:
    """Return how many UAVs follow a trajectory that moves; the others hover."""
    return sum(state.followed(i).moves for i in range(len(state.swarm.uavs)))


def _both_new(candidates: Candidates | None, flown: Round, new: Mapping[Name, Plan]) -> Approach | None:
    """Return the closest approach of new trajectories where each CU had both UAVs in its A_ET(k)."""
    if candidates is None or len(new) < 2:
        return None
    attempts = {Metadata(flown.before.k, w): attempt for w, attempt in enumerate(flown.computed.attempts)}
    selected = {name: attempt.task.selected for name in new if (attempt := attempts[name[1]]) is not None}
    pairs: Mask = candidates.pairs(candidates.have(new), candidates.have(new))
    for a, b in np.argwhere(pairs):
        one, other = candidates.names[a], candidates.names[b]
        pairs[a, b] = {one[0], other[0]} <= selected[one] & selected[other]
    return candidates.closest(pairs)


def reference_pieces(lattice: Lattice, state: FlightState) -> Floats:
    """Return the references in the round of `state` as cubics, scaled for crashes: coefficients, shape (m, N, 3, 4)."""
    k = state.k
    plans = [state.followed(i) for i in range(len(state.swarm.uavs))]
    states = np.array([plan.state_at(k) for plan in plans])
    return cubics(states, np.array([plan.jerk_in(k) for plan in plans]), lattice.crash.first, lattice.steps)


def closest_references(lattice: Lattice, state: FlightState) -> Approach | None:
    """Return the closest approach of the references at the samples of the round of `state`."""
    k = state.k
    names = [(i, uav.followed.metadata) for i, uav in enumerate(state.swarm.uavs)]
    positions = np.array([state.plans[name].scaled_from(k)[: lattice.steps] for name in names])
    return closest_at_samples(lattice, k, names, positions.transpose(1, 0, 2))


def distances_to_targets(scenario: Scenario, lattice: Lattice, flown: Round) -> Floats:
    """Return how far the UAVs are, at the end of a round, from the targets that they had in it, in m, shape (N,)."""
    after = flown.after
    here = np.array([after.followed(i).state_at(after.k)[0] for i in range(scenario.uavs)])
    there = np.array(scenario.targets_at(flown.before.k), float)
    return np.asarray(np.sqrt(((here * float(lattice.position_unit) - there) ** 2).sum(axis=1)))
