"""Flies patterns of a few losses, each from the round on in which it begins to differ from what was flown before.

Every flight also tells what other patterns lead to. A UAV that hears nothing flies on along what it follows. So the
closest approach of what two UAVs follow in some round, over the horizon, is that of another pattern: the same losses
before that round, and from then on these two hear nothing. The smallest of these distances is what a flight promises.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from swarmproof.dmpc_swarm.flight.cached_planner import Remembering
from swarmproof.dmpc_swarm.flight.observing import reference_pieces
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.flight.state import Computed, FlightState
from swarmproof.dmpc_swarm.planner.outlook import ARRIVED
from swarmproof.dmpc_swarm.planner.planner import Planned, Planner
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.dmpc_swarm.protocol.deliver import deliver
from swarmproof.faults.pattern import Losses, nothing_lost
from swarmproof.monitor.bernstein import closest, cubics
from swarmproof.monitor.separation import distance_below
from swarmproof.motion.lattice import Floats
from swarmproof.motion.pairs import Scales, turned

#: How many different tasks the planner remembers: those of some dozens of flights.
TASKS = 10_000
#: What a receiver does that misses everything.
DEAF = "hears nothing"


class Place(NamedTuple):
    """What one receiver can miss, in words, and the entries in the arrays of :class:`Losses` that say so.

    Attributes:
        marks: array, row and column.
    """

    receiver: str
    misses: str
    marks: tuple[tuple[int, int, int], ...]


class Loss(NamedTuple):
    """`rounds` rounds, from round `first` on, in which a receiver misses something: the index of a :class:`Place`."""

    place: int
    first: int
    rounds: int


#: What is lost in a flight.
Pattern = tuple[Loss, ...]


def places(uavs: int, cus: int, conflicts: bool) -> list[Place]:
    """Return what CUs and UAVs can miss, for each receiver everything at first.

    Args:
        uavs: N.
        cus: M.
        conflicts: whether two may transmit in a slot; then a receiver can hear the reply and miss the CU's message.
    """
    found = []
    for kind, count, slots, replies in (("CU", cus, 1, 3), ("UAV", uavs, 2, 4)):
        for n in range(count):
            single = [(f"misses the message in CU {s}'s slot", (slots, n, s)) for s in range(cus)]
            if kind == "CU":
                single += [(f"misses the metadata of UAV {i}", (0, n, i)) for i in range(uavs)]
            found.append(Place(f"{kind} {n}", DEAF, tuple(mark for _, mark in single)))
            if conflicts:
                single += [(f"hears the reply, if there is one, in CU {s}'s slot", (replies, n, s)) for s in range(cus)]
            found += [Place(f"{kind} {n}", misses, (mark,)) for misses, mark in single]
    return found


class Promise(NamedTuple):
    """Two UAVs come this close (m), in round `nearest`, on what they follow in round `k`."""

    distance: float
    k: int
    nearest: int
    uavs: tuple[int, int]


class Step(NamedTuple):
    """A round of a flight; `distance` is that of the references in it (m)."""

    state: FlightState
    computed: Computed
    distance: float
    promise: Promise


@dataclass(frozen=True, eq=False)
class Flown:
    """A flight: its rounds, and the state after them.

    Attributes:
        missed: by round, the places at which something is missed; other rounds are left out.
    """

    pattern: Pattern
    missed: Mapping[int, frozenset[int]]
    steps: Sequence[Step]
    end: FlightState

    def state(self, k: int) -> FlightState:
        """Return the state in round k, which may be the one after the last."""
        return self.steps[k].state if k < len(self.steps) else self.end

    @cached_property
    def distance(self) -> float:
        """How close any two references come, at any time: a certified lower bound, in m."""
        return min(step.distance for step in self.steps)

    @cached_property
    def nearest(self) -> int:
        """The round of that approach."""
        return [step.distance for step in self.steps].index(self.distance)

    @cached_property
    def promise(self) -> Promise:
        """The smallest promise."""
        return min(step.promise for step in self.steps)


class Flights:
    """Flies patterns in one setting, over a number of rounds.

    Attributes:
        places: what can be lost where.

    Raises:
        BadInput: the flight cannot begin.
    """

    def __init__(self, setting: Setting, rounds: int) -> None:
        scenario, rules = setting.scenario, setting.semantics
        self._flight = setting.flight(_Planning(Planner(setting.flight().lattice, scenario.weights)))
        self._lattice = self._flight.lattice
        self._second = self._lattice.crash.among(scenario.uavs)
        self._rounds = rounds
        self._start = self._flight.initial()
        self._targets = np.array(scenario.targets_at(rounds - 1), float)
        self._last_change = scenario.target_change_before(rounds - 1)
        # only a CU that gave its slot away, and plans again too early, transmits together with a UAV
        conflicts = (rules.loss_handling, rules.rejoin, rules.slot_conflict) == ("recover", "any-state", "either")
        self.places = places(scenario.uavs, setting.cus, conflicts)

    def fly(self, pattern: Pattern, bases: Sequence[Flown] = (), whole: bool = False) -> Flown:
        """Fly a pattern; rounds in which all is as it was in the best suited of `bases` are taken from there.

        Unless the `whole` flight is asked for, it is over once all UAVs have arrived, targets do not change any more
        and nothing is lost any more.
        """
        missed = _by_round(pattern)
        last = max(missed, default=-1)
        differences = [self._differences(missed, base.missed) for base in bases]
        different = max(differences, default=[])
        base = bases[differences.index(different)] if bases else None
        steps: list[Step] = []
        state, k = self._start, 0
        while True:
            step = None
            if base is not None and _equal(state, base.state(k)):
                until = min(different[bisect_left(different, k)], len(base.steps))
                steps += base.steps[k:until]
                k, state = until, base.state(until)
                step = base.steps[k] if k < len(base.steps) else None
            if k == self._rounds or (not whole and k > last and self._is_over(state)):
                return Flown(pattern, missed, steps, state)
            if step is None:
                distance, _ = self._distance(reference_pieces(self._lattice, state), self._second)
                step = Step(state, self._flight.compute(state), distance, self._promise(state))
            steps.append(step)
            heard = deliver(step.computed.air, self.losses(missed.get(k, ())), self._flight.semantics)
            state = self._flight.receive(state, step.computed, *heard).after
            k += 1

    def losses(self, missed: Iterable[int]) -> Losses:
        """Return what is lost in a round in which something is missed at these places."""
        none = nothing_lost(self._flight.scenario.uavs, self._flight.cus)
        fields = (none.cu_uav, none.cu_slot, none.uav_slot, none.replies_at_cus, none.replies_at_uavs)
        arrays = [array.copy() for array in fields]
        for place in missed:
            for array, row, column in self.places[place].marks:
                arrays[array][row, column] = True
        return Losses(*arrays)

    def in_words(self, loss: Loss) -> str:
        """Return a loss as a sentence."""
        receiver, misses, _ = self.places[loss.place]
        until = loss.first + loss.rounds - 1
        when = f"in round {until}" if loss.rounds == 1 else f"in rounds {loss.first} to {until}"
        return f"{receiver} {misses} {when}."

    def promised(self, flown: Flown) -> Pattern:
        """Return the pattern that a flight promises something of."""
        _, k, nearest, uavs = flown.promise
        deaf = [n for n, place in enumerate(self.places) if place[:2] in [(f"UAV {i}", DEAF) for i in uavs]]
        # what is received in a round is followed in the next one
        return (*before(flown.pattern, k), *(Loss(place, k, nearest - k) for place in deaf))

    def _differences(self, one: Mapping[int, frozenset[int]], other: Mapping[int, frozenset[int]]) -> list[int]:
        """Return the rounds in which not the same is missed, and the one after the last."""
        return [*sorted(k for k in one.keys() | other.keys() if one.get(k) != other.get(k)), self._rounds]

    def _is_over(self, state: FlightState) -> bool:
        """Return whether all UAVs are at their last targets and stay there."""
        ahead = np.array([state.followed(i).sampled_from(state.k) for i in range(len(self._targets))])
        away = ahead * float(self._lattice.position_unit) - self._targets[:, None]
        return state.k >= self._last_change and bool(((away**2).sum(axis=2) < ARRIVED**2).all())

    def _distance(self, pieces: Floats, second: Scales | None) -> tuple[float, int]:
        """Return a certified lower bound of the distance of any two UAVs (m), and the step of their approach."""
        found = closest(pieces, second)
        # the last factor makes up for three roundings
        return distance_below(found.lower, float(self._lattice.crash.unit)), found.step

    def _promise(self, state: FlightState) -> Promise:
        """Return how close those two UAVs come, on what they follow, that come closest at the samples."""
        m = self._lattice.steps
        periods = range(state.k, min(state.k + self._lattice.horizon, self._rounds))
        plans = [state.followed(i) for i in range(len(self._targets))]
        q = np.array([plan.scaled_from(state.k)[: len(periods) * m + 1] for plan in plans])
        one, other = np.triu_indices(len(plans), 1)
        apart = turned(q[other] - q[one], self._lattice.pairs.in_metres(one[:, None], other[:, None]))
        pair = int((apart**2).sum(axis=2).min(axis=1).argmin())
        uavs = int(one[pair]), int(other[pair])
        states = np.array([plans[i].state_at(k) for k in periods for i in uavs])
        jerks = np.array([plans[i].jerk_in(k) for k in periods for i in uavs])
        pieces = cubics(states, jerks, self._lattice.crash.first, m).reshape(m, len(periods), 2, 3, 4)
        second = None if self._second is None else self._second.only(pair)
        distance, step = self._distance(pieces.swapaxes(0, 1).reshape(-1, 2, 3, 4), second)
        return Promise(distance, state.k, state.k + step // m, uavs)


class _Planning:
    """A planner that remembers the tasks of the last flights."""

    def __init__(self, planner: Planner) -> None:
        self._planner = planner
        self._memory = Remembering(planner)

    def plan(self, task: Task) -> Planned:
        counts = self._memory.counts
        if counts.solved + counts.rejected + counts.infeasible >= TASKS:
            self._memory = Remembering(self._planner)
        return self._memory.plan(task)


def before(losses: Iterable[Loss], k: int) -> Pattern:
    """Return the part of a pattern before round k."""
    return tuple(loss._replace(rounds=min(loss.rounds, k - loss.first)) for loss in losses if loss.first < k)


def _by_round(pattern: Pattern) -> dict[int, frozenset[int]]:
    missed: dict[int, set[int]] = {}
    for place, first, rounds in pattern:
        for k in range(first, first + rounds):
            missed.setdefault(k, set()).add(place)
    return {k: frozenset(at) for k, at in missed.items()}


def _equal(one: FlightState, other: FlightState) -> bool:
    """Return whether two swarms are the same, in the same round: then they fly on in the same way."""
    if one.swarm != other.swarm or one.knowledge != other.knowledge or one.plans.keys() != other.plans.keys():
        return False
    return all(plan.digest == other.plans[name].digest for name, plan in one.plans.items())
