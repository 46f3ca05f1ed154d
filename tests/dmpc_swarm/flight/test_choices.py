"""What a scenario can change is flown: each choice where the paper is silent, weights, jitter, shuffling and hold."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from tests.dmpc_swarm.flight.flights import Recording, record
from tests.dmpc_swarm.flight.settings import setting

from swarmproof.dmpc_swarm.protocol.algorithm1 import Inbox
from swarmproof.dmpc_swarm.protocol.messages import Metadata, Trajectory, TrajectoryMessage
from swarmproof.dmpc_swarm.protocol.uav import Uav, offers
from swarmproof.scenario.scenario import USUAL, load

#: Two UAVs meet head on, exactly, and block each other until one makes a detour.
HEAD_ON = """
name = "head on"
rounds = 50
[parameters]
workspace = [[-1.7, 1.7], [-1.7, 1.7], [0.4, 3.0]]
[start]
positions = [[-0.6, 0, 1], [0.6, 0, 1]]
[[targets]]
round = 0
positions = [[0.6, 0, 1], [-0.6, 0, 1]]
"""


@cache
def head_on(folder: Path, *changes: str, cus: int = 2) -> Recording:
    """Fly :data:`HEAD_ON`, with changes."""
    path = folder / "head_on.toml"
    path.write_text(HEAD_ON, encoding="utf-8")
    return record(setting(load(str(path), 0, changes), cus), rounds=50)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return one folder for all tests, so that no flight is flown twice."""
    return tmp_path_factory.mktemp("head_on")


def paths(recording: Recording) -> list[bytes]:
    """Return all that is flown, by round, to the bit."""
    uavs = range(recording.flight.scenario.uavs)
    return [
        b"".join(round_.before.followed(i).state_at(round_.before.k).tobytes() for i in uavs)
        for round_ in recording.rounds
    ]


def known(recording: Recording) -> list[int]:
    """Return the rounds in which some CU knows of a detour."""
    return [round_.before.k for round_ in recording.rounds if any(one.detours for one in round_.before.knowledge)]


def test_the_usual_choices_can_be_said(folder: Path) -> None:
    """Saying what is usual changes nothing."""
    usual = [f"{name}={getattr(USUAL, name)}" for name in ("retry", "detours", "detour_step", "detour_noise", "offer")]
    assert paths(head_on(folder, *usual)) == paths(head_on(folder))


@pytest.mark.parametrize("change", ["detours=off", "detour_step=1.1", "detour_noise=0.05", "detour_rounds=3"])
def test_choices_of_detours_are_flown(folder: Path, change: str) -> None:
    """Another choice makes another flight, from the first detour on and not before."""
    usual, other = head_on(folder), head_on(folder, change)
    first = known(usual)[0]
    assert paths(usual)[: first + 1] == paths(other)[: first + 1]
    assert paths(usual) != paths(other)
    assert (known(other) == []) == (change == "detours=off")


def test_detours_end_when_chosen(folder: Path) -> None:
    """Nobody knows a detour that is older than was chosen."""
    for rounds in (3, 15):
        ages = [
            round_.before.k - one.since
            for round_ in head_on(folder, f"detour_rounds={rounds}").rounds
            for knowledge in round_.before.knowledge
            for one in knowledge.detours
        ]
        assert max(ages) <= rounds
        assert rounds == 15 or max(ages) == rounds


def test_a_uav_that_is_given_up_is_planned_no_more(folder: Path) -> None:
    """With `retry=0`, both deadlocked UAVs keep priority 1; with 1, one gets its own again after a round."""

    def announced(retry: int) -> set[int]:
        flown = head_on(folder, "detours=off", f"retry={retry}", cus=1).rounds[30:]
        messages = [slot.cu_message for round_ in flown for slot in round_.computed.air.slots]
        return {value for message in messages if message is not None for value in message.priorities or ()}

    # 0 is the UAV that was planned in this round
    assert announced(0) <= {0, 1}
    assert max(announced(1)) > 1


def test_the_scale_of_priorities_is_flown() -> None:
    """On a linear scale other UAVs are planned first, since all that are near their targets are alike."""

    def planned(*changes: str) -> list[int]:
        flown = record(setting("circle", 2, 0, ["uavs=6", *changes]), rounds=20)
        return [one.task.i for round_ in flown.rounds for one in round_.computed.attempts if one is not None]

    assert planned("priority_scale=logarithmic") == planned() != planned("priority_scale=linear")


A, B = Trajectory(Metadata(3, 0)), Trajectory(Metadata(3, 2))


@pytest.mark.parametrize(("choice", "followed"), [("lowest", A), ("highest", B)])
def test_the_offer_is_chosen(choice: str, followed: Trajectory) -> None:
    """Of two new trajectories a UAV follows that in the chosen slot, of one this, of none what it followed."""
    flight = setting("crossing", 3, 0, [f"offer={choice}"]).flight()
    uav, other = Uav(0), TrajectoryMessage(1, Trajectory(Metadata(3, 1)))
    both = Inbox({}, {2: TrajectoryMessage(0, B), 1: other, 0: TrajectoryMessage(0, A)})
    assert flight.follow(uav, both).followed == followed
    assert flight.follow(uav, Inbox({}, {1: other, 2: TrajectoryMessage(0, B)})).followed == B
    assert flight.follow(uav, Inbox({}, {1: other})) == uav


@pytest.mark.parametrize("choice", ["lowest", "highest"])
def test_the_offer_is_flown(choice: str) -> None:
    """CUs that ignore losses plan one UAV at once; it follows the plan in the chosen slot."""
    flown = record(setting("crossing", 2, 0, [f"offer={choice}"], semantics="ignore-loss"), "iid:0.3", 40)
    seen = 0
    for round_ in flown.rounds:
        for i, got in enumerate(round_.at_uavs):
            offered = offers(round_.before.swarm.uavs[i], got.inbox)
            if len(offered) > 1:
                seen += 1
                assert round_.after.swarm.uavs[i].followed == offered[0 if choice == "lowest" else -1]
    assert seen >= 3


@pytest.mark.parametrize("change", ["band=0.5", "band_width=0.1", "jerk=0.1", "jitter=0.02", "assignment=shuffled"])
def test_what_is_changed_is_flown(change: str) -> None:
    """Another weight, disturbed starts and shuffled targets make other flights; no claim is violated in them."""
    usual, other = (record(setting("circle", 2, 1, ["uavs=4", *more]), rounds=12) for more in ([], [change]))
    assert paths(usual) != paths(other)
    assert (paths(usual)[0] != paths(other)[0]) == change.startswith("jitter")
    assert not other.flown.violated


def test_another_seed_makes_another_flight_by_jitter() -> None:
    """Without loss a flight depends on its seed by jitter; it is repeatable to the bit."""

    def flown(seed: int, *changes: str) -> list[bytes]:
        return paths(record(setting("circle", 2, seed, ["uavs=4", *changes]), rounds=8))

    assert flown(0) == flown(1)
    assert flown(0, "jitter=0.02") == flown(0, "jitter=0.02") != flown(1, "jitter=0.02")


def test_targets_change_when_held() -> None:
    """The UAVs fly to the next targets when `hold` is over."""
    for hold in (3, 6):
        flown = record(setting("formations", 2, 0, ["uavs=4", f"hold={hold}"]), rounds=10)
        moved = [k for k, one in enumerate(flown.rounds) if one.after.knowledge[0].targets[0].since == k + 1]
        assert moved[0] == hold
