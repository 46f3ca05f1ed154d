"""Flies a swarm: the protocol of `mlr`, with real trajectories behind its names.

A round is :meth:`Flight.compute`, then :meth:`Flight.receive` for whatever the network delivers. Both are functions of
their arguments: a search can take any state up again and let other messages be lost.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from swarmproof.dmpc_swarm.flight.place import Place
from swarmproof.dmpc_swarm.flight.state import Attempt, Computed, FlightState, Knowledge, KnownTarget, Name, Round
from swarmproof.dmpc_swarm.planner.detour import Detour, current, plan_detours, swarm_deadlocked
from swarmproof.dmpc_swarm.planner.outlook import Outlook, look
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.dmpc_swarm.planner.planner import Planned, hovering
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.dmpc_swarm.planner.trigger import priorities
from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit, CuState, Inbox
from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker
from swarmproof.dmpc_swarm.protocol.deliver import deliver
from swarmproof.dmpc_swarm.protocol.event_trigger import NO_OPINION
from swarmproof.dmpc_swarm.protocol.messages import HOVERING, Metadata, TrajectoryMessage
from swarmproof.dmpc_swarm.protocol.network import Reception, on_air
from swarmproof.dmpc_swarm.protocol.swarm import Swarm, initial_swarm
from swarmproof.dmpc_swarm.protocol.uav import Uav, adopt, offers
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.errors import BadInput
from swarmproof.faults.losses import LossModel
from swarmproof.scenario.scenario import Scenario


class Plans(Protocol):
    """Whatever plans a UAV: a :class:`~swarmproof.dmpc_swarm.planner.planner.Planner`, or one with a memory."""

    def plan(self, task: Task) -> Planned:
        """Return what comes out of `task`."""
        ...


class Flight:
    """One scenario under one reading of the paper.

    Raises:
        BadInput: `semantics` leaves the trigger free, which a flight cannot.
    """

    def __init__(
        self,
        where: Place,
        cus: int,
        trigger: Trigger,
        semantics: Semantics,
        plans: Plans,
        seed: int,
    ) -> None:
        if semantics.event_trigger != "round-robin":
            raise BadInput("a flight needs priorities on the air: event_trigger must be round-robin")
        #: where it is computed; see :attr:`original`
        self.scenario = where.scenario
        self.lattice = where.lattice
        self.origin = where.origin
        self._longest = where.scenario.rounds if where.clipped else None
        self.cus = cus
        self.trigger = trigger
        self.semantics = semantics
        self._planner = plans
        self._seed = seed
        self._box = np.array([self.lattice.low, self.lattice.high]) * float(self.lattice.position_unit)
        self._targets: dict[int, tuple[tuple[float, float, float], ...]] = {}

    @property
    def original(self) -> Scenario:
        """The scenario as the user wrote it."""
        return self.scenario.moved(self.origin)

    def initial(self) -> FlightState:
        """Return the swarm in the computation phase of round 0: all hover (Remark 2)."""
        uavs = self.scenario.uavs
        hovers = hovering(self.lattice, self.scenario.starts)
        plans = {(i, HOVERING.metadata): plan for i, plan in enumerate(hovers)}
        known = self.semantics.initial == "known"
        points = self._targets_at(0)
        targets = tuple(KnownTarget(point if known else None, 0) for point in points)
        return FlightState(initial_swarm(uavs, self.cus, self.semantics), plans, (Knowledge(targets),) * self.cus)

    def _targets_at(self, k: int) -> tuple[tuple[float, float, float], ...]:
        """Return the targets in round k as floats: planners need them no more exactly."""
        change = self.scenario.target_change_before(k)
        if change not in self._targets:
            self._targets[change] = tuple((float(x), float(y), float(z)) for x, y, z in self.scenario.targets_at(k))
        return self._targets[change]

    def compute(self, state: FlightState) -> Computed:
        """Return what the CUs compute and transmit, and what the UAVs transmit, in the round of `state`."""
        attempts: list[Attempt | None] = []
        decided, announced, computed, messages = [], [], [], []
        for cu, known in zip(state.swarm.cus, state.knowledge, strict=True):
            outlook, detours = None, None
            if cu.state is CuState.RUN_DMPC:
                # whether to make room depends on the real targets, everything else on the present ones
                outlook = self._outlook(state, cu, known._replace(detours=()))
                detours = self._detours(state.k, cu, known, outlook)
                known = replace_detours(known, cu.w, self.cus, detours)
                if known.detours:
                    outlook = self._outlook(state, cu, known)
            attempt = None
            decision = algorithm1.decisions(cu, state.k, self.cus, self.semantics)[0]
            if outlook is not None and decision is not None:
                attempt = self._plan(state, cu, decision, outlook)
                decision = None if attempt.planned.plan is None else decision

            def calculate(
                k: int,
                trackers: Sequence[InformationTracker],
                running: bool,
                planned: int | None,
                seen: Outlook | None = outlook,
            ) -> tuple[int, ...]:
                if seen is None:
                    return (NO_OPINION,) * len(trackers)
                ages = np.array([k - tracker.trajectories[0].metadata.round for tracker in trackers])
                return priorities(self.trigger, seen, ages, planned, self.scenario.choices)

            after, message = algorithm1.transmit(cu, state.k, decision, self.semantics, calculate)
            attempts.append(attempt)
            decided.append(decision)
            announced.append(detours)
            computed.append(after)
            messages.append(message)
        swarm = Swarm(state.k, state.swarm.uavs, tuple(computed))
        air = on_air(state.swarm.uavs, messages)
        return Computed(tuple(decided), tuple(attempts), tuple(announced), swarm, air)

    def receive(
        self, state: FlightState, computed: Computed, at_cus: Sequence[Reception], at_uavs: Sequence[Reception]
    ) -> Round:
        """Return the round in which CUs and UAVs received this: Algorithm 2 on all CUs, adoption by all UAVs."""
        uavs = tuple(self.follow(uav, got.inbox) for uav, got in zip(computed.after.uavs, at_uavs, strict=True))
        cus = tuple(
            algorithm1.update(cu, got.inbox, self.cus, self.semantics)
            for cu, got in zip(computed.after.cus, at_cus, strict=True)
        )
        knowledge = tuple(self.learn(state, computed, w, got) for w, got in enumerate(at_cus))
        swarm = Swarm(state.k + 1, uavs, cus)
        return Round(
            state,
            computed,
            tuple(at_cus),
            tuple(at_uavs),
            FlightState(swarm, self._named(swarm, state, computed), knowledge),
        )

    def follow(self, uav: Uav, inbox: Inbox) -> Uav:
        """Return the UAV after it received `inbox`: offered several new trajectories, it follows the chosen one."""
        offered = offers(uav, inbox)
        best = 0 if self.scenario.choices.offer == "lowest" else -1
        return adopt(uav, inbox, offered[best] if offered else None)

    def rounds(self, state: FlightState, losses: LossModel, count: int) -> Iterator[Round]:
        """Yield `count` rounds from `state` on, in which the messages are lost that `losses` says.

        Raises:
            ValueError: the flight would leave the part of a large flying space that its lattice has room for.
        """
        if self._longest is not None and state.k + count > self._longest:
            raise ValueError(f"{state.k + count} rounds are more than the scenario's {self._longest}")
        for _ in range(count):
            computed = self.compute(state)
            at_cus, at_uavs = deliver(computed.air, losses.losses(state.k), self.semantics)
            flown = self.receive(state, computed, at_cus, at_uavs)
            yield flown
            state = flown.after

    def _outlook(self, state: FlightState, cu: ComputeUnit, known: Knowledge) -> Outlook:
        firsts = [tracker.trajectories[0].metadata for tracker in cu.trackers]
        plans = [state.plans[i, metadata] for i, metadata in enumerate(firsts)]
        ends = [None if target.point is not None else plan for target, plan in zip(known.targets, plans, strict=True)]
        unit = float(self.lattice.position_unit)
        targets = np.array(
            [
                target.point if end is None else end.positions[-1] * unit
                for target, end in zip(known.targets, ends, strict=True)
            ]
        )
        since = np.array([target.since for target in known.targets])
        for detour in known.detours:
            targets[detour.uav] = detour.point
            since[detour.uav] = max(since[detour.uav], detour.since)
        planned_for = np.array([metadata.round for metadata in firsts]) >= since
        return look(self.lattice, state.k, plans, targets, planned_for)

    def _detours(self, k: int, cu: ComputeUnit, known: Knowledge, outlook: Outlook) -> tuple[Detour, ...]:
        """Return the detours of the UAVs that this CU looks after: those with i mod M = w."""
        choices = self.scenario.choices
        if choices.detours == "off":
            return ()
        mine = [i for i in range(self.scenario.uavs) if i % self.cus == cu.w]
        going_on = current([detour for detour in known.detours if detour.uav in mine], outlook, k, choices)
        if not going_on and not known.detours and swarm_deadlocked(outlook):
            going_on = plan_detours(outlook, k, mine, self._box, (self._seed,), choices)
        return tuple(going_on)

    def _plan(self, state: FlightState, cu: ComputeUnit, i: int, outlook: Outlook) -> Attempt:
        held = [
            tuple(state.plans[j, trajectory.metadata] for trajectory in tracker.trajectories)
            for j, tracker in enumerate(cu.trackers)
        ]
        others = {j: plans for j, plans in enumerate(held) if j != i}
        selected, target = frozenset(cu.a_et or ()), outlook.targets[i]
        task = Task(state.k, i, held[i][0], others, selected, target, self.scenario.tolerance)
        return Attempt(task, self._planner.plan(task))

    def learn(self, state: FlightState, computed: Computed, w: int, got: Reception) -> Knowledge:
        """Return what CU w knows after the round: UAVs say their targets, CUs their detours."""
        known = state.knowledge[w]
        points = self._targets_at(state.k)
        targets = tuple(
            KnownTarget(points[i], state.k + 1) if i in got.inbox.uav_messages and old.point != points[i] else old
            for i, old in enumerate(known.targets)
        )
        known = known._replace(targets=targets)
        for slot, message in got.inbox.cu_messages.items():
            is_reply = isinstance(message, TrajectoryMessage) and message.priorities is None
            detours = computed.announced[slot]
            if detours is not None and not is_reply:
                known = replace_detours(known, slot, self.cus, detours)
        return known

    def _named(self, swarm: Swarm, state: FlightState, computed: Computed) -> dict[Name, Plan]:
        """Return the trajectories that trackers hold or UAVs follow in `swarm`."""
        new = {
            (attempt.task.i, Metadata(state.k, w)): attempt.planned.plan
            for w, attempt in enumerate(computed.attempts)
            if attempt is not None and attempt.planned.plan is not None
        }
        known = {**state.plans, **new}
        used = {(uav.i, uav.followed.metadata) for uav in swarm.uavs}
        for cu in swarm.cus:
            for i, tracker in enumerate(cu.trackers):
                used.update((i, trajectory.metadata) for trajectory in tracker.trajectories)
        return {name: known[name] for name in used}


def replace_detours(known: Knowledge, w: int, cus: int, detours: Sequence[Detour]) -> Knowledge:
    """Return `known` with CU w's detours, those of the UAVs with i mod M = w, replaced."""
    kept = tuple(detour for detour in known.detours if detour.uav % cus != w)
    return known._replace(detours=tuple(sorted((*kept, *detours))))
