"""One round for many swarms at once: every loss pattern, merged by effect.

A round is cut into the steps *decide, UAV 0 ... UAV N-1, CU 0 ... CU M-1, finish*. Receivers lose messages
independently, so each step can be taken for each intermediate swarm on its own, and intermediate swarms that have
become equal are merged before the next step. What a receiver can come to is computed by the readable model
(:mod:`swarmproof.dmpc_swarm.protocol`), once per distinct local situation, by running through all its loss patterns;
the tables here only remember it.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from typing import NamedTuple

from swarmproof.dmpc_swarm.encoding import (
    AIR_BITS,
    COLUMN_BITS,
    CONTROL_BITS,
    PHASE_BITS,
    Control,
    Numbering,
    PackedSwarms,
    Table,
)
from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit
from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker
from swarmproof.dmpc_swarm.protocol.messages import CuMessage, Metadata, Trajectory, TrajectoryMessage, UavMessage
from swarmproof.dmpc_swarm.protocol.network import Air, Slot, cu_receptions, uav_receptions
from swarmproof.dmpc_swarm.protocol.uav import Uav, adopt, offers
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.symmetry import (
    CANONICAL_ROUND,
    Abstraction,
    Column,
    canonical_column,
    canonical_columns_with_ages,
    forget,
)
from swarmproof.explore.steps import PARENT_BITS, Frontier


class _AirPlan(NamedTuple):
    """Everything transmitted, with the replies' contents left to the columns."""

    messages: tuple[CuMessage | None, ...]
    replying: tuple[int | None, ...]
    phase: int


class _View(NamedTuple):
    """What one CU can see of a column, in names of its own where ages do not matter."""

    tracker: InformationTracker
    followed: Trajectory


def _own_names(tracker: InformationTracker, followed: Trajectory) -> dict[Trajectory, Trajectory]:
    """Return names for a tracker's entries that do not depend on what other trackers hold.

    Entries other than the followed trajectory are numbered; so a CU that sees the same is asked only once.
    """
    others = [t for t in tracker.trajectories if t != followed and t.metadata.round < CANONICAL_ROUND]
    return {t: Trajectory(Metadata(number, 0)) for number, t in enumerate(others, start=1)}


def _renamed(tracker: InformationTracker, names: dict[Trajectory, Trajectory]) -> InformationTracker:
    return tracker._replace(trajectories=tuple(names.get(t, t) for t in tracker.trajectories))


#: (number of the tracker for each UAV, number of the control, fewest losses)
_CuOutcome = tuple[tuple[int, ...], int, int]
_PLACEHOLDER = Trajectory(Metadata(-9, -9))


class Rounds(PackedSwarms):
    """The successor relation on packed swarms, for one number of UAVs and CUs under one semantics."""

    #: Many, since equal intermediate swarms are merged; a chunk takes about a second.
    chunk = 20_000

    def __init__(
        self, uavs: int, cus: int, semantics: Semantics, abstraction: Abstraction = Abstraction.ESSENTIAL
    ) -> None:
        super().__init__(uavs, cus, semantics, abstraction)
        self.ages_matter = semantics.event_trigger == "round-robin"
        self.steps = 0
        self._airs: Numbering[_AirPlan] = Numbering(AIR_BITS)
        self._views: Numbering[_View] = Numbering(32)
        self._trackers: Numbering[InformationTracker] = Numbering(32)
        # what the readable model answered, by local situation
        self._options: dict[tuple[int, ...], int] = {}
        self._option_sets: Numbering[tuple[tuple[int | None, bool, CuMessage | None, int], ...]] = Numbering(32)
        self._joint: dict[tuple[int, ...], list[tuple[int, int]]] = {}
        self._uav_outcomes: dict[tuple[int, int], list[tuple[Trajectory | None, int, int]]] = {}
        self._cu_outcomes: list[dict[tuple[int, ...], list[_CuOutcome]]] = [{} for _ in range(cus)]
        self._view_of = [Table(lambda c, w=w: self._view(c, w)) for w in range(cus)]  # type: ignore[misc]
        self._after_cu: list[list[dict[int, Table]]] = [[{} for _ in range(uavs)] for _ in range(cus)]
        self._finished = [Table(lambda c, i=i: self._finish_column(c) << self._column_at[i]) for i in range(uavs)]  # type: ignore[misc]
        self._finished_with_ages: dict[int, int] = {}

    def run(self, frontier: Frontier, lossless: bool = False) -> Frontier:
        """Return the swarms one round later, each with the cheapest value with which it is reached.

        Args:
            frontier: values by key; a key may carry a tag above `tag_at`, which its successors carry, too.
            lossless: take only the effects that lose no message.
        """
        frontier = self._decide(frontier)
        for i in range(self.uavs):
            frontier = self._receive_at_uav(frontier, i, lossless)
        for w in range(self.cus):
            frontier = self._receive_at_cu(frontier, w, lossless)
        return self._finish(frontier)

    def loss_free(self, keys: Sequence[int]) -> Iterator[tuple[int, int]]:
        """Yield (position in `keys`, key one round later) for every round that loses nothing, each pair once."""
        key_mask = (1 << self.key_bits) - 1
        tagged = {key | position << self.tag_at: 0 for position, key in enumerate(keys)}
        for key in self.run(tagged, lossless=True):
            yield key >> self.tag_at, key & key_mask

    def parts(self, key: int) -> Sequence[Hashable]:
        """Return, for each UAV, what determines all that concerns it: its column, and what is no column."""
        rest = self.outline(key)
        return [(i, column, rest) for i, column in enumerate(self.column_numbers(key))]

    def outline(self, key: int) -> Hashable:
        """Return all but the columns: the CUs' states, who is asked, k mod M."""
        return key >> COLUMN_BITS * self.uavs

    def _decide(self, frontier: Frontier) -> Frontier:
        """Algorithm 1, lines 12-34, on every CU."""
        decided: Frontier = {}
        controls = ((1 << CONTROL_BITS * self.cus) - 1) << self._control_at[0]
        asked = ((1 << self.cus * self.uavs) - 1) << self._asked_from
        kept = ~(controls | asked)
        for key, value in frontier.items():
            views = self.column_numbers(key)
            phase = self._phase(key)
            option_sets = tuple(
                self._options_of(w, control, tuple(self._view_of[w][c] for c in views), phase)
                for w, control in enumerate(self.control_numbers(key))
            )
            base = key & kept
            joint = self._joint_decisions(option_sets, (key & asked) >> self._asked_from, phase)
            self.steps += len(joint)
            for air, control_bits in joint:
                new = base | air << self._air_at | control_bits
                old = decided.get(new)
                if old is None or value < old:
                    decided[new] = value
        return decided

    def _options_of(self, w: int, control: int, views: tuple[int, ...], phase: int) -> int:
        """Return the number of the set of what CU w can decide: (decision, exclusive, message, control)."""
        situation = (w, phase, control, *views)
        number = self._options.get(situation)
        if number is None:
            cu = self._cu(w, control, views)
            k = CANONICAL_ROUND + phase
            options = []
            for decision in algorithm1.decisions(cu, k, self.cus, self.semantics):
                after, message = algorithm1.transmit(cu, k, decision, self.semantics)
                new_control = self.controls(Control(after.state, after.next_request, None))
                exclusive = algorithm1.is_exclusive(cu, decision, self.semantics)
                options.append((decision, exclusive, message, new_control))
            number = self._options[situation] = self._option_sets(tuple(options))
        return number

    def _joint_decisions(self, option_sets: tuple[int, ...], asked: int, phase: int) -> list[tuple[int, int]]:
        """Return every (number of what is on the air, control bits) that the CUs' decisions lead to."""
        situation = (*option_sets, asked, phase)
        joint = self._joint.get(situation)
        if joint is None:
            options = [self._option_sets.values[number] for number in option_sets]
            replying: list[int | None] = [None] * self.cus
            for i in range(self.uavs):
                for w in range(self.cus):
                    if asked >> self.cus * i + w & 1:
                        replying[w] = i
            results: dict[tuple[int, int], None] = {}
            for decided in algorithm1.joint_decisions([tuple((d, e) for d, e, _, _ in o) for o in options]):
                chosen = [next(o for o in of_cu if o[0] == d) for of_cu, d in zip(options, decided, strict=True)]
                plan = _AirPlan(_dense_priorities([o[2] for o in chosen]), tuple(replying), phase)
                bits = sum(o[3] << at for o, at in zip(chosen, self._control_at, strict=True))
                results[self._airs(plan), bits] = None
            joint = self._joint[situation] = list(results)
        return joint

    def _receive_at_uav(self, frontier: Frontier, i: int, lossless: bool) -> Frontier:
        """UAV i hears requests and new trajectories, and follows one of these from the next round on (eq. 10)."""
        received: Frontier = {}
        column_at, asked_at = self._column_at[i], self._asked_at[i]
        column_mask = ((1 << COLUMN_BITS) - 1) << column_at
        air_mask = (1 << AIR_BITS) - 1
        adopted: dict[tuple[int, Trajectory], int] = {}
        for key, value in frontier.items():
            air = key >> self._air_at & air_mask
            outcomes = self._uav_outcomes.get((air, i))
            if outcomes is None:
                outcomes = self._uav_outcomes[air, i] = self._uav(air, i)
            for new_trajectory, asked, losses in outcomes:
                if lossless and losses:
                    continue
                self.steps += 1
                new = key | asked << asked_at
                if new_trajectory is not None:
                    column = (key & column_mask) >> column_at
                    after = adopted.get((column, new_trajectory))
                    if after is None:
                        old_column = self.columns.values[column]
                        after = self.columns(old_column._replace(after=new_trajectory))
                        adopted[column, new_trajectory] = after
                    new = new & ~column_mask | after << column_at
                cost = value + (losses << PARENT_BITS)
                old = received.get(new)
                if old is None or cost < old:
                    received[new] = cost
        return received

    def _uav(self, air_number: int, i: int) -> list[tuple[Trajectory | None, int, int]]:
        """Run the model's UAV i over everything that it can receive: (new trajectory, asked-by mask, losses)."""
        plan = self._airs.values[air_number]
        air = self._air(plan, [_PLACEHOLDER] * self.uavs)
        uav = Uav(i, _PLACEHOLDER)
        fewest: dict[tuple[Trajectory | None, int], int] = {}
        for reception in uav_receptions(i, air, self.semantics):
            for new_trajectory in offers(uav, reception.inbox) or (None,):
                after = adopt(uav, reception.inbox, new_trajectory)
                followed = None if after.followed == _PLACEHOLDER else after.followed
                effect = (followed, sum(1 << w for w in after.asked_by))
                fewest[effect] = min(reception.lost, fewest.get(effect, reception.lost))
        return [(followed, asked, losses) for (followed, asked), losses in fewest.items()]

    def _receive_at_cu(self, frontier: Frontier, w: int, lossless: bool) -> Frontier:
        """CU w receives, runs Algorithm 2 and lines 8-11 of Algorithm 1."""
        received: Frontier = {}
        control_at = self._control_at[w]
        control_mask = (1 << CONTROL_BITS) - 1
        air_mask = (1 << AIR_BITS) - 1
        column_mask = (1 << COLUMN_BITS) - 1
        kept = ~(self.columns_mask | control_mask << control_at)
        view_of, tables, memo = self._view_of[w], self._after_cu[w], self._cu_outcomes[w]
        positions = list(enumerate(self._column_at))
        get = received.get
        for key, value in frontier.items():
            numbers = [key >> at & column_mask for _, at in positions]
            control = key >> control_at & control_mask
            situation = (key >> self._air_at & air_mask, control, *[view_of[c] for c in numbers])
            outcomes = memo.get(situation)
            if outcomes is None:
                outcomes = memo[situation] = self._cu_results(w, situation)
            rows = []
            for (i, _), number in zip(positions, numbers, strict=True):
                row = tables[i].get(number)
                if row is None:
                    row = tables[i][number] = self._tracker_row(w, i, number)
                rows.append(row)
            base = key & kept
            for trackers, control_bits, losses in outcomes:
                if lossless and losses:
                    continue
                self.steps += 1
                new = base | control_bits
                for row, tracker in zip(rows, trackers, strict=True):
                    new |= row[tracker]
                cost = value + losses
                old = get(new)
                if old is None or cost < old:
                    received[new] = cost
        return received

    def _cu_results(self, w: int, situation: tuple[int, ...]) -> list[_CuOutcome]:
        """Run the model's CU w over everything that it can receive: (trackers, control bits, losses as a value)."""
        air_number, control, *views = situation
        cu = self._cu(w, control, views)
        followed = [self._views.values[view].followed for view in views]
        air = self._air(self._airs.values[air_number], followed)
        fewest: dict[ComputeUnit, int] = {}
        for reception in cu_receptions(w, air, self.semantics):
            after = algorithm1.update(cu, reception.inbox, self.cus, self.semantics)
            fewest[after] = min(reception.lost, fewest.get(after, reception.lost))
        return [
            (
                tuple(self._trackers(tracker) for tracker in after.trackers),
                self.controls(Control(after.state, after.next_request, after.a_et)) << self._control_at[w],
                losses << PARENT_BITS,
            )
            for after, losses in fewest.items()
        ]

    def _tracker_row(self, w: int, i: int, number: int) -> Table:
        """Return the table from CU w's new tracker of UAV i to the column that it makes of column `number`."""
        column = self.columns.values[number]
        at = self._column_at[i]
        own = {} if self.ages_matter else _own_names(column.trackers[w], column.before)
        column_names = {name: trajectory for trajectory, name in own.items()}

        def replaced(tracker_number: int) -> int:
            tracker = _renamed(self._trackers.values[tracker_number], column_names)
            if self.abstraction is Abstraction.ESSENTIAL:
                tracker = forget(tracker, w, column.after, self.semantics)
            new = column._replace(trackers=(*column.trackers[:w], tracker, *column.trackers[w + 1 :]))
            return self.columns(new if self.ages_matter else self._canonical(new, during_round=True)) << at

        return Table(replaced)

    def _finish(self, frontier: Frontier) -> Frontier:
        """The round is over: names of this round become names like others, what was on the air is forgotten."""
        finished: Frontier = {}
        column_mask = (1 << COLUMN_BITS) - 1
        forgotten = ~(((1 << AIR_BITS) - 1) << self._air_at | self.columns_mask)
        phase_mask = ((1 << PHASE_BITS) - 1) << self._phase_at
        for key, value in frontier.items():
            new = key & forgotten
            if self.ages_matter:
                columns = key & self.columns_mask
                canonical = self._finished_with_ages.get(columns)
                if canonical is None:
                    canonical = self._finished_with_ages[columns] = self._finish_columns(columns)
                phase = (self._phase(key) + 1) % self.cus
                new = new & ~phase_mask | phase << self._phase_at | canonical
            else:
                for at, table in zip(self._column_at, self._finished, strict=True):
                    new |= table[key >> at & column_mask]
            old = finished.get(new)
            if old is None or value < old:
                finished[new] = value
        return finished

    def _canonical(self, column: Column, during_round: bool) -> Column:
        return canonical_column(column, self.abstraction, during_round)

    def _finish_column(self, number: int) -> int:
        column = self.columns.values[number]
        return self.columns(self._canonical(column._replace(before=column.after), during_round=False))

    def _finish_columns(self, packed: int) -> int:
        columns = [self.columns.values[number] for number in self.column_numbers(packed)]
        at_rest = [column._replace(before=column.after) for column in columns]
        named = canonical_columns_with_ages(at_rest, self.abstraction)
        return sum(self.columns(column) << at for column, at in zip(named, self._column_at, strict=True))

    # --- local situations, as the readable model wants them ----------------------------------------------------------

    def _view(self, column_number: int, w: int) -> int:
        column = self.columns.values[column_number]
        tracker = column.trackers[w]
        own = {} if self.ages_matter else _own_names(tracker, column.before)
        return self._views(_View(_renamed(tracker, own), column.before))

    def _cu(self, w: int, control_number: int, views: Iterable[int]) -> ComputeUnit:
        control = self.controls.values[control_number]
        trackers = tuple(self._views.values[view].tracker for view in views)
        return ComputeUnit(w, control.state, trackers, control.next_request, control.a_et)

    def _air(self, plan: _AirPlan, followed: list[Trajectory]) -> Air:
        slots = tuple(
            Slot(message, None if i is None else TrajectoryMessage(i, followed[i]))
            for message, i in zip(plan.messages, plan.replying, strict=True)
        )
        return Air(tuple(UavMessage(trajectory.metadata) for trajectory in followed), slots)


def _dense_priorities(messages: list[CuMessage | None]) -> tuple[CuMessage | None, ...]:
    """Replace the priorities on the air by their ranks: only zero, equality and order matter to eq. 11."""
    announced = {p for m in messages if m is not None and m.priorities is not None for p in m.priorities if p > 0}
    rank = {p: number for number, p in enumerate(sorted(announced), start=1)} | {0: 0}
    return tuple(
        m if m is None or m.priorities is None else m._replace(priorities=tuple(rank[p] for p in m.priorities))
        for m in messages
    )
