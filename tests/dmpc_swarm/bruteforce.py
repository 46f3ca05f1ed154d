"""Rounds without any merging, on the readable model: what the engine's shortcuts are checked against."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from swarmproof.dmpc_swarm.claims.observed import ObservedSwarm
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.messages import Trajectory
from swarmproof.dmpc_swarm.protocol.network import Reception, cu_receptions, uav_receptions
from swarmproof.dmpc_swarm.protocol.swarm import Events, Swarm, all_decisions, compute, initial_swarm, step
from swarmproof.dmpc_swarm.protocol.uav import adopt, offers
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.dmpc_swarm.semantics import PRESETS, SWITCHES, Semantics
from swarmproof.errors import BadInput
from swarmproof.explore.steps import PARENT_BITS


def single_switch_semantics() -> list[Semantics]:
    """Return every preset, and every preset with every value of every switch; no two are equal."""
    chosen: dict[Semantics, None] = {}
    for preset in PRESETS:
        chosen[Semantics.parse(preset)] = None
        for switch, values in SWITCHES.items():
            for value in values:
                try:
                    chosen[Semantics.parse(preset, [f"{switch}={value}"])] = None
                except BadInput:
                    continue
    return list(chosen)


def all_events(swarm: Swarm, semantics: Semantics) -> Iterator[Events]:
    """Yield everything that can happen in the next round: all decisions, loss patterns, conflicts and adoptions."""
    for decided in all_decisions(swarm, semantics):
        _, air = compute(swarm, decided, semantics)
        at_cus = [list(cu_receptions(cu.w, air, semantics)) for cu in swarm.cus]
        at_uavs: list[list[tuple[Reception, Trajectory | None]]] = [
            [
                (reception, new)
                for reception in uav_receptions(uav.i, air, semantics)
                for new in offers(uav, reception.inbox) or (None,)
            ]
            for uav in swarm.uavs
        ]
        for cus in product(*at_cus):
            for uavs in product(*at_uavs):
                yield Events(decided, cus, tuple(got for got, _ in uavs), tuple(new for _, new in uavs))


def raw_successors(swarm: Swarm, semantics: Semantics) -> dict[Swarm, int]:
    """Return every swarm one round later with the fewest messages lost on the way, one step per loss pattern."""
    fewest: dict[Swarm, int] = {}
    for events in all_events(swarm, semantics):
        after = step(swarm, events, semantics)
        fewest[after] = min(events.lost, fewest.get(after, events.lost))
    return fewest


def successors(swarm: Swarm, semantics: Semantics) -> dict[Swarm, int]:
    """Return the same as :func:`raw_successors`, with equal results of a single receiver taken once.

    What a receiver comes to depends on nothing but its own reception.
    """
    fewest: dict[Swarm, int] = {}
    for decided in all_decisions(swarm, semantics):
        computed, air = compute(swarm, decided, semantics)
        results: list[list[tuple[object, int]]] = []
        for uav in swarm.uavs:
            results.append(
                _fewest(
                    (adopt(uav, got.inbox, new), got.lost)
                    for got in uav_receptions(uav.i, air, semantics)
                    for new in offers(uav, got.inbox) or (None,)
                )
            )
        for cu in computed:
            results.append(
                _fewest(
                    (algorithm1.update(cu, got.inbox, len(computed), semantics), got.lost)
                    for got in cu_receptions(cu.w, air, semantics)
                )
            )
        uavs = len(swarm.uavs)
        for combination in product(*results):
            parts: list[object] = [part for part, _ in combination]
            lost = sum(lost for _, lost in combination)
            after = Swarm(swarm.k + 1, tuple(parts[:uavs]), tuple(parts[uavs:]))  # type: ignore[arg-type]
            fewest[after] = min(lost, fewest.get(after, lost))
    return fewest


def _fewest(results: Iterable[tuple[object, int]]) -> list[tuple[object, int]]:
    fewest: dict[object, int] = {}
    for result, lost in results:
        fewest[result] = min(lost, fewest.get(result, lost))
    return list(fewest.items())


def packed(rounds: Rounds, swarms: dict[Swarm, int]) -> dict[int, int]:
    """Return the key of every swarm, with the fewest losses among the swarms that share it."""
    keys: dict[int, int] = {}
    for swarm, lost in swarms.items():
        key = rounds.pack(swarm)
        keys[key] = min(lost, keys.get(key, lost))
    return keys


def merged(rounds: Rounds, swarm: Swarm, lossless: bool = False) -> dict[int, int]:
    """Return what the engine says of the next round: every key with the fewest lost messages."""
    return {k: value >> PARENT_BITS for k, value in rounds.run({rounds.pack(swarm): 0}, lossless=lossless).items()}


def random_event(swarm: Swarm, semantics: Semantics, rng: random.Random, loss: float) -> Events:
    """Return one round at random: a message is received with probability 1 - `loss` or so."""
    decided = rng.choice(all_decisions(swarm, semantics))
    _, air = compute(swarm, decided, semantics)

    def one(receptions: Iterable[Reception]) -> Reception:
        options = list(receptions)
        return rng.choices(options, [loss**option.lost for option in options])[0]

    at_uavs = [one(uav_receptions(uav.i, air, semantics)) for uav in swarm.uavs]
    return Events(
        decided,
        tuple(one(cu_receptions(cu.w, air, semantics)) for cu in swarm.cus),
        tuple(at_uavs),
        tuple(rng.choice(offers(uav, got.inbox) or (None,)) for uav, got in zip(swarm.uavs, at_uavs, strict=True)),
    )


def random_walk(uavs: int, cus: int, semantics: Semantics, rounds: int, seed: int) -> list[Swarm]:
    """Return the swarms of one random run of the readable model, none of them renamed or abstracted."""
    rng = random.Random(seed)
    swarm = initial_swarm(uavs, cus, semantics)
    swarms = [swarm]
    for _ in range(rounds):
        swarm = step(swarm, random_event(swarm, semantics, rng, rng.choice((0.05, 0.3, 1.0))), semantics)
        swarms.append(swarm)
    return swarms


@dataclass(frozen=True)
class Run:
    """A run of the readable model: the swarm that it ends in, and what happened."""

    swarm: Swarm
    events: tuple[Events, ...]

    @property
    def lost(self) -> int:
        """The number of messages lost in it."""
        return sum(events.lost for events in self.events)


def plain_search(
    uavs: int,
    cus: int,
    semantics: Semantics,
    wanted: dict[str, Callable[[ObservedSwarm], bool]],
    depth: int,
) -> dict[str, Run]:
    """Return, for each wanted observation, a run to it that is shortest and then loses the fewest messages.

    Breadth first over the swarms themselves: nothing is renamed, merged or forgotten, so it also explores models that
    treat trajectories differently because of their names.
    """
    found: dict[str, Run] = {}
    begin = initial_swarm(uavs, cus, semantics)
    level = {begin: Run(begin, ())}
    for _ in range(depth + 1):
        for name, holds in wanted.items():
            runs = [run for swarm, run in level.items() if name not in found and holds(observe(swarm))]
            if runs:
                found[name] = min(runs, key=lambda run: run.lost)
        if len(found) == len(wanted):
            break
        following: dict[Swarm, Run] = {}
        for swarm, run in level.items():
            for events, after in _cheapest(swarm, semantics):
                if after not in following or run.lost + events.lost < following[after].lost:
                    following[after] = Run(after, (*run.events, events))
        level = following
    return found


def _cheapest(swarm: Swarm, semantics: Semantics) -> list[tuple[Events, Swarm]]:
    cheapest: dict[Swarm, Events] = {}
    for events in all_events(swarm, semantics):
        after = step(swarm, events, semantics)
        if after not in cheapest or events.lost < cheapest[after].lost:
            cheapest[after] = events
    return [(events, after) for after, events in cheapest.items()]


def sample(population: Sequence[int], size: int, seed: int) -> list[int]:
    """Return `size` of `population` at random, all of it if there are no more; always the same ones."""
    return list(population) if len(population) <= size else random.Random(seed).sample(list(population), size)
