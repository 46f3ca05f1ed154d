"""`fly --positions`: others can check a flight from the file; and a flight's facts in JSON and on the page."""

from __future__ import annotations

import csv
import json
from dataclasses import fields, replace
from math import dist, sqrt
from pathlib import Path
from typing import Any

import pytest

from swarmproof.cli import main
from swarmproof.exit_codes import ExitCode
from swarmproof.scenario.digest import canonical_text, digest
from swarmproof.scenario.scenario import Scenario, load

Json = dict[str, Any]
#: Losses and other CUs' plans that are not adopted; the planner's samples are at every 0.1 s.
LOSSY = ["fly", "crossing", "--loss", "iid:0.2", "--seed", "3", "--rounds", "25"]


def flown(tmp_path: Path, *arguments: str, code: int = 0) -> tuple[Json, Json]:
    """Fly with `--positions` and `--json`, and return both documents."""
    paths = tmp_path / "positions.json", tmp_path / "flight.json"
    assert main([*arguments, "--positions", str(paths[0]), "--json", str(paths[1])]) == code
    positions, flight = (json.loads(path.read_text(encoding="utf-8")) for path in paths)
    return positions, flight


def position(plan: Json, time: float, period: float) -> list[float]:
    """Return where a plan is at a time: ten lines that know nothing of swarmproof."""
    p, v, a = list(plan["position"]), list(plan["velocity"]), list(plan["acceleration"])
    left = time - plan["start"]
    for jerk in plan["jerks"]:
        h = max(0.0, min(period, left))
        for x in range(3):
            p[x] += v[x] * h + a[x] * h**2 / 2 + jerk[x] * h**3 / 6
            v[x] += a[x] * h + jerk[x] * h**2 / 2
            a[x] += jerk[x] * h
        left -= h
        if left <= 0:
            break
    return p


def followed(document: Json, uav: int, time: float) -> Json:
    """Return the plan that a UAV follows at a time: the one that it adopted last."""
    own = [one for one in document["plans"] if one["uav"] == uav and one["adopted"] is not None]
    plan: Json = max((one for one in own if one["followed_from"] <= time + 1e-9), key=lambda one: one["followed_from"])
    return plan


def scaled(document: Json, a: list[float], b: list[float]) -> float:
    """Return the scaled distance."""
    apart = [x - y for x, y in zip(a, b, strict=True)]
    return sqrt(sum(sum(m * x for m, x in zip(row, apart, strict=True)) ** 2 for row in document["theta_inverse"]))


@pytest.mark.parametrize("origin", [0, 400_000])
def test_plans_give_the_smallest_distance_again(origin: int, tmp_path: Path) -> None:
    """Integrated by others, the plans come as close as the report says, at samples and between them, wherever it is."""
    path = tmp_path / "own.toml"
    x = origin
    path.write_text(
        f"""name = "own"
rounds = 25
[parameters]
workspace = [[{x - 2}, {x + 2}], [-2, 2], [0.4, 3]]
[start]
positions = [[{x - 1}, 0, 1], [{x + 1}, 0.05, 1]]
[[targets]]
round = 0
positions = [[{x + 1}, 0.05, 1], [{x - 1}, 0, 1]]
""",
        encoding="utf-8",
    )
    document, flight = flown(tmp_path, "fly", str(path), "--loss", "iid:0.2", "--seed", "3")
    fine = 20
    times = [n * document["T_c"] / fine for n in range(25 * 2 * fine)]
    distances = [
        scaled(document, *(position(followed(document, i, t), t, document["T_s"]) for i in range(2))) for t in times
    ]
    assert min(distances[::fine]) == pytest.approx(flight["min_separation"]["sampled"], abs=1e-8)
    assert flight["min_separation"]["continuous_lower"] <= min(distances) + 1e-8
    assert min(distances) == pytest.approx(flight["min_separation"]["continuous_lower"], abs=2e-4)


def test_rows_are_what_the_plans_say(tmp_path: Path) -> None:
    """Each row is where the plan that the UAV follows is at that time; without a tracking error so is the UAV."""
    document, flight = flown(tmp_path, *LOSSY)
    assert document["schema"] == "swarmproof.positions/1"
    assert document["scenario"] == flight["scenario"]
    rows = [dict(zip(document["columns"], row, strict=True)) for row in document["rows"]]
    assert len(rows) == 2 * (25 * 2 + 1)
    assert [row["uav"] for row in rows] == [0, 1] * 51
    for n, row in enumerate(rows):
        assert row["time"] == pytest.approx(n // 2 * 0.1, abs=1e-12)
        assert row["round"] == n // 4
        here = [row[name] for name in ("x", "y", "z")]
        assert here == [row[name] for name in ("actual_x", "actual_y", "actual_z")]
        assert here == pytest.approx(position(followed(document, row["uav"], row["time"]), row["time"], 0.2), abs=1e-9)
    never = [plan for plan in document["plans"] if plan["adopted"] is None]
    assert never, "with losses, some plan is not adopted"
    last = max(plan["adopted"] for plan in document["plans"] if plan["adopted"] is not None)
    assert flight["last_adoption"]["round"] == last
    assert sum(plan["round"] >= 0 for plan in document["plans"]) == flight["qps"]["solved"]


def test_actual_positions_stray(tmp_path: Path) -> None:
    """With a tracking error, UAVs stray from their references by no more than it, and that is asked about."""
    document, flight = flown(tmp_path, *LOSSY, "--set", "tracking_error=0.05")
    strays = [dist(row[3:6], row[6:9]) for row in document["rows"]]
    assert max(strays) <= 0.05
    assert max(strays) > 0.02
    assert strays[0] == 0
    assert {claim["id"]: claim["verdict"] for claim in flight["claims"]}["eq-2-actual"] != "not-applicable"


def test_csv_has_the_rows_of_json(tmp_path: Path) -> None:
    """The CSV has the same rows below their names."""
    document, _ = flown(tmp_path, *LOSSY)
    path = tmp_path / "positions.csv"
    assert main([*LOSSY, "--positions", str(path)]) == 0
    with path.open(encoding="utf-8", newline="") as file:
        names, *rows = csv.reader(file)
    assert names == document["columns"]
    assert [[float(value) for value in row] for row in rows] == document["rows"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--positions", "flight.txt"], "give a file such as flight.csv"),
        (["--positions", "flight.csv", "--loss", "exhaustive:1"], "such as --loss script:"),
        (["--positions", "/proc/none/flight.csv"], "/proc/none"),
        (["--positions", "flight.json", "--json", "./flight.json"], "one would overwrite the other: give two files"),
    ],
)
def test_positions_that_cannot_be_written(
    arguments: list[str], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What cannot be written is refused before anything is flown."""
    monkeypatch.chdir(tmp_path)
    assert main(["fly", "crossing", *arguments]) == ExitCode.BAD_INPUT
    captured = capsys.readouterr()
    assert captured.out == ""
    assert says in captured.err


def test_positions_say_how_each_pair_is_scaled(tmp_path: Path) -> None:
    """Where UAVs differ, or crashes have an ellipsoid of their own, the file says so: Θ⁻¹ alone would not do."""
    mixed = tmp_path / "mixed.toml"
    mixed.write_text(
        'name = "mixed"\nrounds = 2\n[parameters]\nworkspace = [[-2, 2], [-2, 2], [0, 3]]\ncrash_theta_inverse = 1\n'
        "[[kinds]]\nuavs = [1]\nd_hat_min = 0.5\n[start]\npositions = [[-1, 0, 1], [1, 0, 1]]\n"
        "[[targets]]\nround = 0\npositions = [[1, 0, 1], [-1, 0, 1]]\n",
        encoding="utf-8",
    )
    assert main(["fly", str(mixed), "--positions", str(tmp_path / "mixed.json")]) == 0
    document = json.loads((tmp_path / "mixed.json").read_text(encoding="utf-8"))
    assert document["crash_theta_inverse"] == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    assert [(kind["uavs"], kind["parameters"]["d_hat_min"]) for kind in document["kinds"]] == [([1], 0.5)]


# The digest


def test_the_digest_is_of_everything() -> None:
    """Any field of a scenario that differs makes another digest; the same scenario, read again, has the same one."""
    one = load("random", 3, ["jitter=0.01"])
    assert digest(one) == digest(load("random", 3, ["jitter=0.01"]))
    assert len(digest(one)) == 64
    others = [
        replace(one, name="other"),
        replace(one, parameters=one.parameters.with_changes(["v_max=1.9"])),
        replace(one, horizon=16),
        load("random", 4, ["jitter=0.01"]),
        load("random", 3, ["jitter=0.02"]),
        load("random", 3, ["jitter=0.01", "retry=0"]),
        load("random", 3, ["jitter=0.01", "tolerance=0.01"]),
        load("random", 3, ["jitter=0.01", "band=2"]),
    ]
    assert len({digest(other) for other in [one, *others]}) == len(others) + 1
    text = canonical_text(one)
    assert all(f'"{field.name}"' in text for field in fields(Scenario) if field.compare and field.name != "rounds")
    assert digest(replace(one, rounds=one.rounds + 1)) == digest(one)


def test_what_was_given_does_not_change_the_digest() -> None:
    """A published value that is written down is the same scenario as one that is left out."""
    assert digest(load("crossing", 0, ["v_max=2"])) == digest(load("crossing"))


# Facts in JSON and on the page


def test_two_flights_can_be_told_apart(tmp_path: Path) -> None:
    """Scenario, loss, trigger and semantics of a flight are in its document."""
    _, one = flown(tmp_path, *LOSSY)
    _, other = flown(tmp_path, *LOSSY[:2], "--rounds", "3", "--trigger", "RR", "--semantics", "prose")
    assert (one["scenario"]["name"], one["loss"], one["trigger"]) == ("crossing", "iid:0.2", "HT")
    assert (other["loss"], other["trigger"]) == ("none", "RR")
    assert one["semantics"]["rejoin"] == "after-reply"
    assert other["semantics"]["rejoin"] == "any-state"
    assert one["scenario"] == other["scenario"]
    assert one["defaults"]["v_max"] == [2.0, 2.0, 2.0]
    assert "workspace" not in one["defaults"]


def test_violations_have_pair_time_and_reason(tmp_path: Path) -> None:
    """Each violated claim says where: the round, the pair, the time and why, the same as on the page."""
    arguments = ["fly", "random", "--loss", "iid:0.3", "--rounds", "30", "--semantics", "ignore-loss"]
    page = tmp_path / "page"
    _, flight = flown(tmp_path, *arguments, "--report", str(page), code=1)
    broken = {claim["id"]: claim for claim in flight["claims"] if claim["verdict"] == "violated"}
    assert {"theorem-2", "eq-2"} <= set(broken)
    for claim in broken.values():
        assert claim["round"] < flight["rounds"]
        if claim["time"] is None:
            continue
        first, second = claim["uavs"]
        assert f"UAV {first}" in claim["why"]
        assert f"UAV {second}" in claim["why"]
        assert f"at {claim['time']:.3f} s" in claim["why"]
        assert claim["instances"] > 0
    # what is flown is violated in the round of its time
    assert broken["theorem-2"]["round"] == int(broken["theorem-2"]["time"] / 0.2 + 1e-9)
    assert broken["eq-2"]["round"] == int(broken["eq-2"]["time"] / 0.2 + 1e-9)
    text = (page / "index.html").read_text(encoding="utf-8")
    for words in (flight["scenario"]["digest"], "iid:0.3", "Where each claim is violated first", "What was flown"):
        assert words in text
    assert f"{broken['theorem-2']['time']:.3f} s" in text
    for claim in flight["claims"]:
        if claim["verdict"] != "violated":
            assert (claim["round"], claim["uavs"], claim["time"]) == (None, None, None)
