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
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from swarmproof.channel.pattern import Losses, Pairs, nothing_lost
from swarmproof.semantics.switches import BadInput

SCHEMA = "swarmproof.losses/1"
#: How long a script may be, and how many rounds it may be about: both far beyond any flight.
MOST_BYTES = 1 << 26
MOST_ROUNDS = 100_000

_KEYS = ("schema", "uavs", "cus", "rounds")
_NAME = re.compile(r"(cu|uav|slot) (0|[1-9][0-9]{0,5})")
_ROUND = re.compile(r"0|[1-9][0-9]{0,5}")
#: By table, which of the arrays of :class:`Losses` a (receiver, message) pair is marked in.
_ARRAYS = {
    "rounds": {("cu", "uav"): 0, ("cu", "slot"): 1, ("uav", "slot"): 2},
    "decoded_replies": {("cu", "slot"): 3, ("uav", "slot"): 4},
}
_FORM = {
    "rounds": 'a CU can lose "uav I" or "slot S", a UAV "slot S", so write ["cu 0", "uav 1"] or ["uav 2", "slot 0"]',
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
    rounds: dict[int, tuple[Pairs, ...]] = {}
    for table in _ARRAYS:
        for k, pairs in _rounds(path, table, script.get(table, {})).items():
            arrays = rounds.setdefault(k, tuple(array.copy() for array in _arrays(empty)))
            for number, i, j in _entries(f"{path}, {table}, round {k}", table, pairs, {"uav": uavs, "cu": cus}):
                arrays[number][i, j] = True
    losses = {k: Losses(*arrays) for k, arrays in rounds.items()}
    return [losses.get(k, empty) for k in range(max(losses, default=-1) + 1)]


def write_script(path: Path, losses_by_round: Sequence[Losses], uavs: int, cus: int) -> None:
    """Write the losses of rounds 0, 1, ... to a file that :func:`read_script` reads.

    Raises:
        BadInput: the file cannot be written, or would be too long to be read.
        ValueError: some losses are those of another swarm.
    """
    lines: dict[str, list[str]] = {table: [] for table in _ARRAYS}
    for k, losses in enumerate(losses_by_round):
        if losses.cu_uav.shape != (cus, uavs):
            raise ValueError(f"the losses of round {k} are not those of {uavs} UAVs and {cus} CUs")
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
        raise BadInput(f"the script {path} would be too long: {MOST_ROUNDS} rounds and {MOST_BYTES} bytes are the most")
    try:
        path.write_text(text, encoding="ascii")
    except (OSError, ValueError) as error:
        raise BadInput(f"the script {path} cannot be written: {_reason(error)}") from None


def shown(raw: object) -> str:
    """Return `raw` for a message, on one line and not too long."""
    text = repr(raw)
    return text if len(text) <= 60 else f"{text[:50]}…{text[-1]}"


def _content(path: Path) -> dict[str, Any]:
    """Return the top level of a script, with the keys that it must have."""
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        raise BadInput(f"the script {path} cannot be read: {_reason(error)}") from None
    if len(data) > MOST_BYTES:
        raise BadInput(f"the script {path} is too long: {MOST_BYTES} bytes are the most")
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


def _rounds(path: Path, table: str, listed: object) -> dict[int, list[object]]:
    """Return the pairs of each round that a table lists."""
    if not isinstance(listed, dict):
        raise BadInput(f'{path}: {table} must be an object of rounds such as {{"3": [["cu 0", "slot 1"]]}}')
    for key, pairs in listed.items():
        if not _ROUND.fullmatch(key) or int(key) >= MOST_ROUNDS:
            raise BadInput(f"{path}: {table} has a round {shown(key)}: rounds are 0 to {MOST_ROUNDS - 1}")
        if not isinstance(pairs, list):
            raise BadInput(f'{path}: round {key} of {table} must be a list of pairs such as ["cu 0", "slot 1"]')
    return {int(key): pairs for key, pairs in listed.items()}


def _entries(place: str, table: str, pairs: list[object], sizes: dict[str, int]) -> set[tuple[int, int, int]]:
    """Return (number of the array, row, column) for each pair of a round."""
    found: set[tuple[int, int, int]] = set()
    for pair in pairs:
        if not isinstance(pair, list) or len(pair) != 2 or not all(isinstance(name, str) for name in pair):
            raise BadInput(f"{place}: not every entry is a pair of names: {_FORM[table]}")
        receiver, message = (_NAME.fullmatch(name) for name in pair)
        if receiver is None or message is None or (receiver[1], message[1]) not in _ARRAYS[table]:
            raise BadInput(f"{place}: {shown(pair)} cannot be: {_FORM[table]}")
        for name in (receiver, message):
            size = sizes["uav" if name[1] == "uav" else "cu"]
            if int(name[2]) >= size:
                raise BadInput(f"{place}: there is no {name[0]}, the last one is {name[1]} {size - 1}")
        entry = (_ARRAYS[table][receiver[1], message[1]], int(receiver[2]), int(message[2]))
        if entry in found:
            raise BadInput(f"{place}: {shown(pair)} stands twice: once is enough")
        found.add(entry)
    return found


def _arrays(losses: Losses) -> tuple[Pairs, ...]:
    return losses.cu_uav, losses.cu_slot, losses.uav_slot, losses.replies_at_cus, losses.replies_at_uavs


def _block(lines: list[str]) -> str:
    return "{\n" + ",\n".join(lines) + "\n  }" if lines else "{}"


def _example() -> str:
    return f'{{"schema": "{SCHEMA}", "uavs": 2, "cus": 2, "rounds": {{"3": [["cu 0", "slot 1"]]}}}}'


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
