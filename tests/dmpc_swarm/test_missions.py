"""Missions as people have them: targets that move or repeat, starts in violation, long files, the documented one."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmproof.cli import main
from swarmproof.errors import BadInput
from swarmproof.scenario.scenario import Scenario, load

ROOT = Path(__file__).parents[2]
MISSION = """
name = "mission"
rounds = 90
repeat = 40
[parameters]
workspace = [[-2, 2], [-2, 2], [0, 3]]
[start]
positions = [[0, 0, 1], [0.5, 0, 1]]
[[targets]]
round = 0
positions = [[0, 0, 1], [0.5, 0, 1]]
velocity = [0.1, 0, "1/100"]
[[targets]]
round = 25
positions = [[1, 1, 1], [1, 0, 1]]
"""


def mission(folder: Path, *replacements: tuple[str, str], changes: tuple[str, ...] = ()) -> Scenario:
    """Return the mission with some of its text replaced."""
    text = MISSION
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new)
    path = folder / "mission.toml"
    path.write_text(text, encoding="utf-8")
    return load(str(path), 0, changes)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(k=st.integers(0, 500))
def test_targets_move_and_repeat(tmp_path_factory: pytest.TempPathFactory, k: int) -> None:
    """The targets of a round are those listed, moved on by velocity times time, exactly; then all begins anew."""
    flown = mission(tmp_path_factory.mktemp("mission"))
    within = k % 40
    if within < 25:
        moved = Fraction(within, 5)
        expected = (
            (moved / 10, Fraction(0), 1 + moved / 100),
            (Fraction(1, 2) + moved / 10, Fraction(0), 1 + moved / 100),
        )
        change = k
    else:
        expected = ((Fraction(1),) * 3, (Fraction(1), Fraction(0), Fraction(1)))
        change = k - within + 25
    assert flown.targets_at(k) == expected
    assert flown.target_change_before(k) == change


def test_without_repeat_the_last_targets_stay(tmp_path: Path) -> None:
    """Without `repeat`, the second targets hold for ever."""
    flown = mission(tmp_path, ("repeat = 40\n", ""))
    assert flown.targets_at(80) == flown.targets_at(25)
    assert flown.target_change_before(80) == 25
    assert "repeat=40" in mission(tmp_path).differences()


MISTAKES = [
    (("velocity = [0.1, 0,", "velocity = [0.1, 1,"), "the target of UAV 0 in round 24 is outside the flying space"),
    (("repeat = 40", "repeat = 25"), "repeat=25 must be more than the round 25 of the last targets"),
    (("repeat = 40", "repeat = 0"), "repeat must be a whole number from 1 to 100000, not 0"),
    (('velocity = [0.1, 0, "1/100"]', "velocity = 0.1"), "is not a list of 3 numbers [x, y, z] in m/s, such as"),
    (("rounds = 90", 'rounds = 90\nbegin = "now"'), "begin must be apart or anyhow, not 'now'"),
]


@pytest.mark.parametrize(("change", "sentence"), MISTAKES, ids=[sentence[:40] for _, sentence in MISTAKES])
def test_a_mistake_is_one_sentence(tmp_path: Path, change: tuple[str, str], sentence: str) -> None:
    """Targets that leave the space, or that begin anew before they end, are refused."""
    with pytest.raises(BadInput) as refused:
        mission(tmp_path, change)
    assert sentence in str(refused.value)
    assert "\n" not in str(refused.value)


def test_the_last_targets_move_for_the_whole_flight(tmp_path: Path) -> None:
    """Targets that leave the space before the flight's last round are refused; a shorter flight is not."""
    moving = ("[1, 0, 1]]\n", "[1, 0, 1]]\nvelocity = [0.1, 0, 0]\n"), ("repeat = 40\n", "")
    with pytest.raises(BadInput, match="the target of UAV 0 in round 89 is outside the flying space"):
        mission(tmp_path, *moving)
    assert mission(tmp_path, *moving, ("rounds = 90", "rounds = 76")).targets_at(75)[0][0] == 2


def test_a_swarm_may_begin_in_violation(tmp_path: Path) -> None:
    """Starts 0.24 m apart are refused with the way to see what becomes of them, and accepted with it."""
    close = ("[[0, 0, 1], [0.5, 0, 1]]", "[[0, 0, 1], [0.24, 0, 1]]")
    with pytest.raises(BadInput, match=r'their scaled distance is 0.24 m, .* or begin = "anyhow" to see'):
        mission(tmp_path, close)
    anyhow = mission(tmp_path, close, changes=("begin=anyhow",))
    assert anyhow.starts[1][0] == Fraction(6, 25)
    with pytest.raises(BadInput, match="outside the flying space"):
        mission(tmp_path, close, ("workspace = [[-2, 2]", "workspace = [[0.1, 2]"), changes=("begin=anyhow",))


def test_random_points_need_limits(tmp_path: Path) -> None:
    """In a space without limits there is no uniform distribution, and nothing is drawn."""
    start = (
        "positions = [[0, 0, 1], [0.5, 0, 1]]\n[[targets]]",
        'formation = "random"\nuavs = 2\nseparation = 1\n[[targets]]',
    )
    assert mission(tmp_path, start).uavs == 2
    with pytest.raises(BadInput, match=r"random points need a flying space with limits, such as \[\[-2, 2\]"):
        mission(tmp_path, start, ("[-2, 2], [0, 3]", "[-2, inf], [0, 3]"))


def test_a_long_file_is_read(tmp_path: Path) -> None:
    """A recorded mission lists the targets of every round; a parameter file of that length is none."""
    rounds = "".join(
        f"[[targets]]\nround = {k}\npositions = [[{k / 10000}, 0, 1], [0.5, 0.{k:04d}, 1]]\n" for k in range(1, 2500)
    )
    path = tmp_path / "long.toml"
    head = MISSION.split("[[targets]]\nround = 25", 1)[0].replace("repeat = 40\n", "")
    path.write_text(head + rounds, encoding="utf-8")
    assert path.stat().st_size > 100_000
    assert load(str(path)).targets_at(2000)[1] == (Fraction(1, 2), Fraction(1, 5), Fraction(1))
    assert main(["margin", str(path)]) == 2


def test_the_documented_mission_flies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The mission of docs/your-swarm.md flies as its commands say, at the place where it is written."""
    text = (ROOT / "docs/your-swarm.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    found = re.search(r"```toml\n(.*?)```", text, re.DOTALL)
    assert found is not None
    Path("patrol.toml").write_text(found[1], encoding="utf-8")
    commands = re.findall(r"^    (swarmproof fly patrol.*)$", text, re.MULTILINE)
    assert len(commands) == 2
    for command in commands:
        assert main([*command.split()[1:], "--rounds", "40"]) in (0, 3)
