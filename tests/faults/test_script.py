"""Scripts of losses: what is written is read, what is no script is refused in one sentence."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from tests.faults.test_losses import arrays, same

from swarmproof.errors import BadInput, Failed
from swarmproof.faults import script
from swarmproof.faults.grammar import parse
from swarmproof.faults.losses import Losses, nothing_lost
from swarmproof.faults.script import read_script, write_script

GOOD: dict[str, Any] = {
    "schema": "swarmproof.losses/1",
    "uavs": 4,
    "cus": 2,
    "rounds": {"3": [["cu 0", "uav 1"], ["cu 1", "slot 0"], ["uav 2", "slot 1"]], "5": [["cu 0", "slot 0"]]},
    "decoded_replies": {"3": [["cu 1", "slot 0"]], "1": [["uav 3", "slot 1"]]},
}


def written(tmp_path: Path, content: object) -> Path:
    """Return a file with this content: bytes as they are, a text as UTF-8, anything else as JSON."""
    path = tmp_path / "losses.json"
    if not isinstance(content, bytes):
        content = (content if isinstance(content, str) else json.dumps(content)).encode()
    path.write_bytes(content)
    return path


def test_a_script_means_what_it_says(tmp_path: Path) -> None:
    """Exactly the pairs listed are lost or decoded, in exactly the rounds in which they are listed."""
    flown = parse(f"script:{written(tmp_path, GOOD)}", 4, 2, 0)
    found = {
        (k, number, int(i), int(j))
        for k in range(20)
        for number, array in enumerate(arrays(flown.losses(k)))
        for i, j in np.argwhere(array)
    }
    assert found == {(3, 0, 0, 1), (3, 1, 1, 0), (3, 2, 2, 1), (5, 1, 0, 0), (3, 3, 1, 0), (1, 4, 3, 1)}


def test_decoded_replies_may_be_left_out(tmp_path: Path) -> None:
    """A script needs no decoded_replies, and may list no rounds at all."""
    content = {key: value for key, value in GOOD.items() if key != "decoded_replies"}
    assert len(read_script(written(tmp_path, content), 4, 2)) == 6
    assert read_script(written(tmp_path, content | {"rounds": {}}), 4, 2) == []


#: Names of receivers and messages, with the wildcards.
RECEIVERS = ["*", "cu *", "uav *", "cu 0", "cu 1", "uav 0", "uav 3"]
MESSAGES = ["*", "slot *", "uav *", "slot 0", "slot 1", "uav 2"]
Marks = set[tuple[int, str, str, str]]


def expanded(content: dict[str, Any], last: int) -> Marks:
    """Return (round, table, receiver, message) for all that a script lists, up to a round, one by one."""
    receivers = [f"cu {w}" for w in range(2)] + [f"uav {i}" for i in range(4)]
    messages = [f"slot {s}" for s in range(2)] + [f"uav {i}" for i in range(4)]

    def stands_for(word: str, name: str) -> bool:
        return word in ("*", name, f"{name.split()[0]} *")

    found = set()
    for table in ("rounds", "decoded_replies"):
        for key, pairs in content[table].items():
            first, dash, end = key.partition("-")
            for k in range(int(first), 1 + (int(end) if end else last if dash else int(first))):
                found |= {
                    (k, table, receiver, message)
                    for r, m in pairs
                    for receiver in receivers
                    for message in messages
                    if stands_for(r, receiver)
                    and stands_for(m, message)
                    # UAVs have no use for metadata, and it is in no slot
                    and not (message[0] == "u" and (receiver[0] == "u" or table == "decoded_replies"))
                }
    return found


def marked(read: list[Losses], last: int) -> Marks:
    """Return the same of what was read."""
    names = [("rounds", "cu", "uav"), ("rounds", "cu", "slot"), ("rounds", "uav", "slot")]
    names += [("decoded_replies", "cu", "slot"), ("decoded_replies", "uav", "slot")]
    return {
        (k, table, f"{receiver} {i}", f"{message} {j}")
        for k, losses in enumerate(read[: last + 1])
        for (table, receiver, message), array in zip(names, arrays(losses), strict=True)
        for i, j in np.argwhere(array)
    }


def random_scripts(count: int) -> Iterator[dict[str, Any]]:
    """Yield scripts with single rounds, ranges that overlap, and ranges without an end."""
    random = Random(3)
    for _ in range(count):
        tables: dict[str, dict[str, list[list[str]]]] = {"rounds": {}, "decoded_replies": {}}
        for table, listed in tables.items():
            for _ in range(random.randrange(5)):
                first = random.randrange(12)
                key = random.choice([f"{first}", f"{first}-", f"{first}-{first + random.randrange(6)}"])
                words = [(r, m) for r in RECEIVERS for m in MESSAGES]
                cannot = {"uav"} if table == "rounds" else {"uav", "*", "cu"}
                fitting = [(r, m) for r, m in words if not (m.startswith("uav") and r.split()[0] in cannot)]
                listed[key] = [list(pair) for pair in random.sample(fitting, random.randrange(4))]
        yield GOOD | tables


def ranges_are_read(tmp_path: Path) -> bool:
    """Return whether scripts with ranges and wildcards mean what they stand for, one by one."""
    return all(
        marked(read_script(written(tmp_path, content), 4, 2), 30) == expanded(content, 30)
        for content in random_scripts(40)
    )


def test_ranges_and_wildcards_stand_for_what_they_list(tmp_path: Path) -> None:
    """Forty scripts with ranges and wildcards are what one gets by writing everything out."""
    assert ranges_are_read(tmp_path)
    content = changed(rounds={"5-": [["*", "slot 1"]]}, decoded_replies=None)
    read = read_script(written(tmp_path, content), 4, 2)
    assert len(read) == script.MOST_ROUNDS
    assert read[4].count == 0
    assert read[5] is read[-1]
    assert read[5].count == 2 + 4


def test_ranges_read_in_another_way_are_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The comparison fails if a range leaves out its end, if * is CUs only, and if later ranges replace others."""
    monkeypatch.setattr(script, "MOST_ROUNDS", 40)
    whole, kinds, by_round = script._range, script._kinds, script._by_round

    def one_of(table: str, receiver: str | None, message: str | None) -> list[int]:
        return kinds(table, receiver, message)[:1]

    def replaced(ranges: list[tuple[range, Any]], empty: Losses) -> list[Losses]:
        at = {k: n for n, (within, _) in enumerate(ranges) for k in within}
        return by_round([(range(k, k + 1), ranges[n][1]) for k, n in at.items()], empty)

    plants: dict[str, Any] = {
        "_range": lambda place, key: range(whole(place, key).start, max(whole(place, key).stop - 1, 1)),
        "_kinds": one_of,
        "_by_round": replaced,
    }
    for name, planted in plants.items():
        with monkeypatch.context() as patch:
            patch.setattr(script, name, planted)
            assert not ranges_are_read(tmp_path)


def all_equal(rounds: list[Losses], read: list[Losses]) -> bool:
    """Return whether the rounds read are those given, with nothing lost after the end of either."""
    quiet = nothing_lost(*rounds[0].uav_slot.shape)
    length = max(len(rounds), len(read))
    padded = [found + [quiet] * (length - len(found)) for found in (rounds, read)]
    return all(same(a, b) for a, b in zip(*padded, strict=True))


@pytest.mark.parametrize("spec", ["none", "iid:0.1", "iid:1", "burst:0.3,0.4", "jam:3,5"])
@pytest.mark.parametrize(("uavs", "cus"), [(16, 3), (3, 5), (1, 1)])
def test_losses_survive_writing_and_reading(tmp_path: Path, spec: str, uavs: int, cus: int) -> None:
    """Whatever a model loses can be written, and flown again to the bit."""
    drawn = parse(spec, uavs, cus, 5)
    rounds = [drawn.losses(k) for k in range(30)]
    path = tmp_path / "again.json"
    write_script(path, rounds, uavs, cus)
    assert all_equal(rounds, read_script(path, uavs, cus))
    again = parse(f"script:{path}", uavs, cus, 99)
    assert all(same(again.losses(k), rounds[k]) for k in range(30))
    assert again.losses(30).count == 0


def test_one_changed_mark_is_noticed() -> None:
    """The comparison above fails if a single pair of a single round differs, in any of the arrays."""
    rounds = [parse("iid:0.1", 4, 2, 5).losses(k) for k in range(6)]
    for number in range(5):
        changed = [array.copy() for array in arrays(rounds[4])]
        changed[number][1, 1] ^= True
        assert not all_equal(rounds, [*rounds[:4], Losses(*changed), rounds[5]])


def test_a_written_script_is_read_by_people(tmp_path: Path) -> None:
    """A script has one line per round that loses something, with the names that people use."""
    path = tmp_path / "out.json"
    write_script(path, read_script(written(tmp_path, GOOD), 4, 2), 4, 2)
    assert path.read_text() == (
        '{\n  "schema": "swarmproof.losses/1",\n  "uavs": 4,\n  "cus": 2,\n  "rounds": {\n'
        '    "3": [["cu 0", "uav 1"], ["cu 1", "slot 0"], ["uav 2", "slot 1"]],\n'
        '    "5": [["cu 0", "slot 0"]]\n  },\n  "decoded_replies": {\n'
        '    "1": [["uav 3", "slot 1"]],\n    "3": [["cu 1", "slot 0"]]\n  }\n}\n'
    )


def changed(**changes: object) -> dict[str, object]:
    """Return the good script with some keys changed; None takes one away."""
    return {key: value for key, value in (GOOD | changes).items() if value is not None}


def in_round(*pairs: object) -> dict[str, object]:
    """Return the good script with only these pairs lost, in round 3."""
    return changed(rounds={"3": list(pairs)})


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "is not JSON that can be read: a script looks like {"),
        ("no json", "is not JSON that can be read"),
        (b"\xff\xfe\xff", "is not JSON that can be read"),
        (b"\x00" * 7, "is not JSON that can be read"),
        ("[" * 100_000, "is not JSON that can be read"),
        ('{"uavs": ' + "9" * 5000 + "}", "is not JSON that can be read"),
        ([], "is not a script of losses: it must look like {"),
        ("NaN", "is not a script of losses"),
        (changed(schema=None), "is not a script of losses"),
        (changed(schema="swarmproof.losses/2"), "is not a script of losses"),
        (changed(schema=["swarmproof.losses/1"]), "is not a script of losses"),
        (changed(uavs=None), "has no uavs: a script looks like"),
        (changed(rounds=None), "has no rounds: a script looks like"),
        (changed(losses={}), "has an unknown key 'losses': there is schema, uavs, cus, rounds and decoded_replies"),
        (changed(uavs=5), "is not for this swarm: its uavs must be 4, as in the flight"),
        (changed(cus=3), "its cus must be 2"),
        (changed(uavs=4.0), "its uavs must be 4"),
        (changed(uavs="4"), "its uavs must be 4"),
        (changed(cus=True), "its cus must be 2"),
        (changed(rounds=[]), "rounds must be an object of rounds"),
        (changed(decoded_replies=3), "decoded_replies must be an object of rounds"),
        (changed(rounds={"-1": []}), "rounds has a round '-1': "),
        (changed(rounds={"03": []}), "rounds has a round '03'"),
        (changed(rounds={"100000": []}), "rounds has a round '100000'"),
        (changed(rounds={"1" * 9000: []}), "rounds has a round '111"),
        (
            changed(rounds={"three": []}),
            "rounds has a round 'three': 'three' is no number; rounds are 0 to 99999, alone",
        ),
        (
            changed(rounds={"5-x": []}),
            "rounds has a round '5-x': 'x' is no number; rounds are 0 to 99999, alone (\"3\")",
        ),
        (changed(rounds={"5-6-7": []}), "'6-7' is no number"),
        (changed(rounds={"5 - 6": []}), "'5 ' is no number"),
        (changed(rounds={"-": []}), "rounds has a round '-': "),
        (changed(rounds={"": []}), "rounds has a round '': "),
        (changed(rounds={"*": []}), "'*' is no number"),
        (changed(rounds={"05-9": []}), "rounds have at most six digits, none a leading 0"),
        (changed(rounds={"9-5": []}), "rounds has a round '9-5': it ends before it begins; write \"5-9\""),
        (changed(rounds={"300-115000": []}), "rounds has a round '300-115000': rounds are 0 to 99999; from one on is"),
        (changed(delayed={"4": []}), "has a key 'delayed': delayed or repeated messages and UAVs that join are faults"),
        (changed(duplicated={"4": []}), "are faults, for which there is no word yet"),
        (changed(rounds={"٣": []}), "rounds has a round '٣'"),
        (changed(rounds={"3": {}}), 'round 3 of rounds must be a list of pairs such as ["cu 0", "slot 1"]'),
        (in_round("cu 0"), "rounds, round 3: not every entry is a pair of names"),
        (in_round(["cu 0"]), "not every entry is a pair of names"),
        (in_round(["cu 0", "uav 1", "uav 2"]), "not every entry is a pair of names"),
        (in_round(["cu 0", 1]), "not every entry is a pair of names"),
        (in_round(["cu 0", "drone 1"]), "['cu 0', 'drone 1'] cannot be: a CU can lose \"uav I\" or \"slot S\", a UAV"),
        (in_round(["CU 0", "uav 1"]), "cannot be"),
        (in_round(["cu 0", "uav 01"]), "cannot be"),
        (in_round(["cu 0", "uav 1\n"]), "cannot be"),
        (in_round(["cu 0", "uav \ud800"]), "cannot be"),
        (in_round(["cu 0", "u" * 9000]), "cannot be"),
        (in_round(["uav 1", "cu 0"]), "cannot be"),
        (in_round(["slot 0", "uav 1"]), "cannot be"),
        (in_round(["cu 0", "cu 1"]), "cannot be"),
        (in_round(["cu 0", "cu *"]), "cannot be"),
        (in_round(["uav *", "uav 1"]), "cannot be"),
        (in_round(["slot *", "*"]), "cannot be"),
        (in_round(["cu", "uav 1"]), "cannot be"),
        (in_round(["**", "uav 1"]), "cannot be"),
        (in_round(["*", "uav 4"]), "there is no uav 4, the last one is uav 3"),
        (in_round(["*", "slot 1"], ["*", "slot 1"]), "stands twice: once is enough"),
        (in_round(["uav 0", "uav 1"]), 'a UAV "slot S"'),
        (in_round(["cu 2", "uav 1"]), "there is no cu 2, the last one is cu 1"),
        (in_round(["cu 0", "uav 4"]), "there is no uav 4, the last one is uav 3"),
        (in_round(["uav 4", "slot 0"]), "there is no uav 4"),
        (in_round(["cu 0", "slot 2"]), "there is no slot 2, the last one is slot 1"),
        (in_round(["cu 0", "uav 1"], ["cu 0", "uav 1"]), "['cu 0', 'uav 1'] stands twice: once is enough"),
        (changed(decoded_replies={"3": [["cu 0", "uav 1"]]}), 'can decode the reply in "slot S"'),
        (
            changed(decoded_replies={"3": [["cu 0", "slot 1"]] * 2}),
            "decoded_replies, round 3: ['cu 0', 'slot 1'] stands",
        ),
        ('{"schema": 1, "schema": 2}', "the key 'schema' stands twice in one object"),
        (json.dumps(GOOD).replace('"5"', '"3"'), "the key '3' stands twice in one object: put everything under one"),
    ],
)
def test_bad_scripts_are_told_in_one_sentence(tmp_path: Path, content: object, says: str) -> None:
    """A file that is no script for this swarm is refused, with a sentence on one line that names the file and place."""
    path = written(tmp_path, content)
    with pytest.raises(BadInput) as refused:
        parse(f"script:{path}", 4, 2, 0)
    text = str(refused.value)
    assert says in text
    assert text.startswith(str(path))
    assert "\n" not in text
    assert len(text.replace(str(path), "")) < 350
    text.encode()  # it can be printed


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    """A missing file, a folder and a name that no file can have are refused in one sentence."""
    for name, says in ((f"{tmp_path}/none.json", "No such file"), (str(tmp_path), "directory"), ("a\0b", "null")):
        with pytest.raises(BadInput, match=rf"cannot read the script .*: .*{says}"):
            parse(f"script:{name}", 4, 2, 0)


def test_a_script_may_be_too_long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A script of more bytes than allowed is neither read nor written; one of exactly as many is."""
    path = tmp_path / "losses.json"
    rounds = [parse("iid:0.5", 4, 2, 0).losses(0)]
    write_script(path, rounds, 4, 2)
    monkeypatch.setattr(script, "MOST_BYTES", path.stat().st_size)
    assert len(read_script(path, 4, 2)) == 1
    write_script(path, rounds, 4, 2)
    monkeypatch.setattr(script, "MOST_BYTES", path.stat().st_size - 1)
    with pytest.raises(BadInput, match="is too long"):
        read_script(path, 4, 2)
    with pytest.raises(BadInput, match="would be too long"):
        write_script(path, rounds, 4, 2)


def test_a_script_may_have_too_many_rounds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Losses of more rounds than a script can list are not written; of exactly as many they are, and can be read."""
    monkeypatch.setattr(script, "MOST_ROUNDS", 3)
    path = tmp_path / "losses.json"
    rounds = [parse("iid:1", 4, 2, 0).losses(k) for k in range(4)]
    write_script(path, rounds[:3], 4, 2)
    assert len(read_script(path, 4, 2)) == 3
    with pytest.raises(BadInput, match="3 rounds"):
        write_script(path, rounds, 4, 2)


def test_files_that_cannot_be_written(tmp_path: Path) -> None:
    """A script that cannot be written is one sentence; losses of another swarm are a mistake of the caller."""
    with pytest.raises(Failed, match=r"losses\.json cannot be written: No such file"):
        write_script(tmp_path / "none" / "losses.json", [], 4, 2)
    with pytest.raises(ValueError, match="the losses of round 0 depend on who sends"):
        write_script(tmp_path / "losses.json", [parse("uav1", 4, 2, 0).losses(0)], 4, 2)
    with pytest.raises(ValueError, match="the losses of round 1 are not those of 4 UAVs and 2 CUs"):
        write_script(tmp_path / "losses.json", [nothing_lost(4, 2), nothing_lost(2, 4)], 4, 2)
