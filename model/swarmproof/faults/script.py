"""Losses written down: a JSON file that says, round by round, which receiver does not get which message.

::

    {
      "schema": "swarmproof.losses/1",
      "uavs": 4,
      "cus": 2,
      "rounds": {
        "3": [["cu 0", "uav 1"], ["cu 1", "slot 0"], ["uav 2", "slot 1"]]
      },
      "decoded_replies": {
        "3": [["cu 1", "slot 0"]]
      }
    }

In round 3, CU 0 misses the metadata of UAV 1, CU 1 what is sent in slot 0, and UAV 2 what is sent in slot 1. In a slot
with two transmitters under `slot_conflict=either`, receivers named in `decoded_replies` (which may be left out) hear
the UAV's reply, all others the CU's message. In rounds that are not listed everything arrives.
``["cu 0", "slot 0"]`` loses a UAV's reply only: a CU always has its own message.

A key may be a range of rounds, both ends included (``"5-59"``), or without an end (``"5-"``). ``*`` stands for every
number (``"uav *"``) or every name: ``["*", "slot 1"]`` is every CU and UAV that misses slot 1, ``["cu 0", "*"]`` CU 0
that hears nothing. What is listed in several ranges adds up. Files without these words mean what they always meant, and
programs that do not know the words refuse them, so the schema's name stays.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from swarmproof.errors import BadInput
from swarmproof.faults.pattern import Losses, Pairs, nothing_lost
from swarmproof.files.reading import read_bytes
from swarmproof.files.writing import write

SCHEMA = "swarmproof.losses/1"
#: How long a script may be, and how many rounds it may be about: both far beyond any flight.
MOST_BYTES = 1 << 26
MOST_ROUNDS = 100_000

_KEYS = ("schema", "uavs", "cus", "rounds")
#: What is said to somebody who asks for faults that are no losses.
LATER = (
    "delayed or repeated messages and UAVs that join are faults, for which there is no word yet; what is lost has one, "
    "such as uav1<->*@0-9 for a UAV that is off for ten rounds"
)

_NAME = re.compile(r"(cu|uav|slot) (\*|0|[1-9][0-9]{0,5})|\*")
_ROUNDS = re.compile(r"(0|[1-9][0-9]{0,5})(?:(-)(0|[1-9][0-9]{0,5})?)?")
#: Keys that somebody may write for faults that are no losses.
_FAULTS = re.compile(r"(?i)delay|late|duplicat|repeat|reorder|join")
#: By table, which of the arrays of :class:`Losses` a (receiver, message) pair is marked in.
_ARRAYS = {
    "rounds": {("cu", "uav"): 0, ("cu", "slot"): 1, ("uav", "slot"): 2},
    "decoded_replies": {("cu", "slot"): 3, ("uav", "slot"): 4},
}
_FORM = {
    "rounds": 'a CU can lose "uav I" or "slot S", a UAV "slot S", so write ["cu 0", "uav 1"] or ["*", "slot 0"]',
    "decoded_replies": 'a CU or a UAV can decode the reply in "slot S", so write ["cu 1", "slot 0"]',
}


def read_script(path: Path, uavs: int, cus: int) -> list[Losses]:
    """Return the losses of rounds 0, 1, ... to the last one that the script lists.

    Raises:
        BadInput: the file cannot be read, is no script, or is about another swarm.
    """
    script = _content(path)
    for name, size in (("uavs", uavs), ("cus", cus)):
        if type(script[name]) is not int or script[name] != size:
            raise BadInput(f"{path} is not for this swarm: its {name} must be {size}, as in the flight")
    empty = nothing_lost(uavs, cus)
    marked: list[tuple[range, Pairs]] = []
    for table in _ARRAYS:
        for key, within, pairs in _rounds(path, table, script.get(table, {})):
            marks = [np.zeros_like(array) for array in _arrays(empty)]
            for number, rows, columns in _entries(f"{path}, {table}, round {key}", table, pairs, uavs, cus):
                marks[number][rows, columns] = True
            marked.append((within, np.concatenate([array.ravel() for array in marks])))
    return _by_round(marked, empty)


def _by_round(marked: list[tuple[range, Pairs]], empty: Losses) -> list[Losses]:
    """Return the losses of rounds 0, 1, … if in all rounds of each range these are marked: five arrays in one row.

    Rounds between which nothing begins or ends share theirs.
    """
    changes: dict[int, list[tuple[int, Pairs]]] = {0: []}
    for within, marks in marked:
        changes.setdefault(within.start, []).append((1, marks))
        changes.setdefault(within.stop, []).append((-1, marks))
    shapes = [array.shape for array in _arrays(empty)]
    ends = np.cumsum([rows * columns for rows, columns in shapes])
    counts = np.zeros(ends[-1], np.int64)
    losses: list[Losses] = []
    for begin, end in pairwise(sorted(changes)):
        for by, marks in changes[begin]:
            counts += by * marks
        arrays = [part.reshape(shape) for part, shape in zip(np.split(counts > 0, ends[:-1]), shapes, strict=True)]
        losses += [Losses(*arrays) if counts.any() else empty] * (end - begin)
    return losses


def write_script(path: Path, losses_by_round: Sequence[Losses], uavs: int, cus: int) -> None:
    """Write the losses of rounds 0, 1, ... to a file that :func:`read_script` reads.

    Raises:
        BadInput: the file would be too long to be read.
        Failed: it cannot be written.
        ValueError: some losses are those of another swarm.
    """
    write(path, script_text(losses_by_round, uavs, cus))


def script_text(losses_by_round: Sequence[Losses], uavs: int, cus: int) -> str:
    """Return what :func:`write_script` writes; for errors see there."""
    lines: dict[str, list[str]] = {table: [] for table in _ARRAYS}
    for k, losses in enumerate(losses_by_round):
        if losses.cu_uav.shape != (cus, uavs):
            raise ValueError(f"the losses of round {k} are not those of {uavs} UAVs and {cus} CUs")
        if losses.by_sender is not None:
            raise ValueError(f"the losses of round {k} depend on who sends, which a script has no word for")
        arrays = _arrays(losses)
        for table, kinds in _ARRAYS.items():
            pairs = [
                (f"{receiver} {i}", f"{message} {j}")
                for (receiver, message), number in kinds.items()
                for i, j in np.argwhere(arrays[number])
            ]
            if pairs:
                lines[table].append(f'    "{k}": {json.dumps(pairs)}')
    text = f'{{\n  "schema": "{SCHEMA}",\n  "uavs": {uavs},\n  "cus": {cus},\n  "rounds": {_block(lines["rounds"])}'
    if lines["decoded_replies"]:
        text += f',\n  "decoded_replies": {_block(lines["decoded_replies"])}'
    text += "\n}\n"
    if len(text) > MOST_BYTES or len(losses_by_round) > MOST_ROUNDS:
        raise BadInput(f"the script would be too long: {MOST_ROUNDS} rounds and {MOST_BYTES} bytes are the most")
    return text


def shown(raw: object) -> str:
    """Return `raw` for a message, on one line and not too long."""
    text = repr(raw)
    return text if len(text) <= 60 else f"{text[:50]}…{text[-1]}"


def _content(path: Path) -> dict[str, Any]:
    """Return the top level of a script, with the keys that it must have."""
    right = "give a file such as DIR/losses.json, which `swarmproof fly --loss adversary:20 --report DIR` writes"
    data = read_bytes(path, "script", MOST_BYTES, right)
    try:
        script = json.loads(data, object_pairs_hook=_object)
    except BadInput as mistake:
        raise BadInput(f"{path}: {mistake}") from None
    except (ValueError, RecursionError):  # not JSON, not Unicode, an integer of thousands of digits, too deep
        raise BadInput(f"{path} is not JSON that can be read: a script looks like {_example()}") from None
    if not isinstance(script, dict) or script.get("schema") != SCHEMA:
        raise BadInput(f"{path} is not a script of losses: it must look like {_example()}")
    for key in _KEYS:
        if key not in script:
            raise BadInput(f"{path} has no {key}: a script looks like {_example()}")
    for key in script:
        if _FAULTS.search(key):
            raise BadInput(f"{path} has a key {shown(key)}: {LATER}")
        if key not in (*_KEYS, "decoded_replies"):
            raise BadInput(f"{path} has an unknown key {shown(key)}: there is {', '.join(_KEYS)} and decoded_replies")
    return script


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a JSON object; of a key that stands twice, JSON readers keep one value and hide the other."""
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise BadInput(f"the key {shown(key)} stands twice in one object: put everything under one")
        found[key] = value
    return found


def _rounds(path: Path, table: str, listed: object) -> Iterator[tuple[str, range, list[object]]]:
    """Yield each key of a table, the rounds that it stands for, and the pairs listed."""
    if not isinstance(listed, dict):
        raise BadInput(f'{path}: {table} must be an object of rounds such as {{"3": [["cu 0", "slot 1"]]}}')
    for key, pairs in listed.items():
        within = _range(f"{path}: {table} has a round {shown(key)}", key)
        if not isinstance(pairs, list):
            raise BadInput(f'{path}: round {key} of {table} must be a list of pairs such as ["cu 0", "slot 1"]')
        yield key, within, pairs


def _range(place: str, key: str) -> range:
    """Return the rounds that a key stands for: one, or a range."""
    found = _ROUNDS.fullmatch(key)
    if found is None:
        wrong = next((part for part in key.split("-", 1) if part and not re.fullmatch(r"[0-9]+", part)), None)
        why = (
            f"{shown(wrong)} is no number" if wrong is not None else "rounds have at most six digits, none a leading 0"
        )
        raise BadInput(
            f'{place}: {why}; rounds are 0 to {MOST_ROUNDS - 1}, alone ("3"), from one to another ("5-59") or from '
            'one on ("5-")'
        )
    first = int(found[1])
    last = first if found[2] is None else MOST_ROUNDS - 1 if found[3] is None else int(found[3])
    if max(first, last) >= MOST_ROUNDS:
        raise BadInput(f'{place}: rounds are 0 to {MOST_ROUNDS - 1}; from one on is "{min(first, last)}-"')
    if last < first:
        raise BadInput(f'{place}: it ends before it begins; write "{last}-{first}"')
    return range(first, last + 1)


def _entries(place: str, table: str, pairs: list[object], uavs: int, cus: int) -> Iterator[tuple[int, slice, slice]]:
    """Yield (number of the array, rows, columns) for what each pair of a round marks."""
    sizes = {"uav": uavs, "cu": cus, "slot": cus}
    seen: set[tuple[str, str]] = set()
    for pair in pairs:
        if not isinstance(pair, list) or len(pair) != 2 or not all(isinstance(name, str) for name in pair):
            raise BadInput(f"{place}: not every entry is a pair of names: {_FORM[table]}")
        receiver, message = (_NAME.fullmatch(name) for name in pair)
        kinds = [] if receiver is None or message is None else _kinds(table, receiver[1], message[1])
        if not kinds or receiver is None or message is None:
            raise BadInput(f"{place}: {shown(pair)} cannot be: {_FORM[table]}")
        for name in (receiver, message):
            if name[2] not in (None, "*") and int(name[2]) >= sizes[name[1]]:
                last = f"{name[1]} {sizes[name[1]] - 1}"
                raise BadInput(f"{place}: there is no {name[0]}, the last one is {last}")
        if (receiver[0], message[0]) in seen:
            raise BadInput(f"{place}: {shown(pair)} stands twice: once is enough")
        seen.add((receiver[0], message[0]))
        for number in kinds:
            yield number, _numbers(receiver[2]), _numbers(message[2])


def _kinds(table: str, receiver: str | None, message: str | None) -> list[int]:
    """Return the arrays in which a pair of these kinds is marked; None is every kind."""
    return [
        number
        for (receives, sent), number in _ARRAYS[table].items()
        if receiver in (None, receives) and message in (None, sent)
    ]


def _numbers(number: str | None) -> slice:
    """Return the rows or columns that a number, or ``*`` (or nothing, beside a lone ``*``), stands for."""
    return slice(None) if number in (None, "*") else slice(int(str(number)), int(str(number)) + 1)


def _arrays(losses: Losses) -> tuple[Pairs, ...]:
    return losses.cu_uav, losses.cu_slot, losses.uav_slot, losses.replies_at_cus, losses.replies_at_uavs


def _block(lines: list[str]) -> str:
    return "{\n" + ",\n".join(lines) + "\n  }" if lines else "{}"


def _example() -> str:
    return f'{{"schema": "{SCHEMA}", "uavs": 2, "cus": 2, "rounds": {{"3": [["cu 0", "slot 1"]]}}}}'
