"""Many parameter sets in one run: which ones, and a folder of certificates that an interrupted run goes on from."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from swarmproof.errors import BadInput
from swarmproof.files.reading import read_bytes
from swarmproof.files.writing import write
from swarmproof.margin.bounds import Margin, Say, from_certificate, margin
from swarmproof.margin.check import Rejected, read
from swarmproof.margin.problem import Problem
from swarmproof.theorem3.numbers import exact_text, read_number
from swarmproof.theorem3.parameters import Parameters, Reading

#: The most parameter sets of one sweep, and the most steps of one range.
MOST_SETS, MOST_STEPS = 1000, 200
#: How long a certificate may be.
MOST_BYTES = 1 << 26
#: The most characters of a certificate's name, without its suffix.
MOST_CHARACTERS = 150


@dataclass(frozen=True)
class Axis:
    """One thing that is varied: a parameter (or `reading`) and its values as text."""

    name: str
    values: tuple[str, ...]

    @classmethod
    def parse(cls, text: str) -> Axis:
        """Return the axis of ``NAME=V1:V2:…`` or ``NAME=FROM..TO/STEPS``.

        Raises:
            BadInput: another form.
        """
        name, equals, values = text.partition("=")
        if not equals or not name or not values:
            raise BadInput(
                f"--sweep {text!r} is not of the form NAME=V1:V2:… or NAME=FROM..TO/STEPS, such as T_c=0.01:0.1"
            )
        if ".." in values:
            return cls(name, tuple(_range(text, values)))
        return cls(name, tuple(values.split(":")))


def _range(text: str, values: str) -> Iterator[str]:
    ends, slash, steps = values.partition("/")
    first, _, last = ends.partition("..")
    if not slash or not steps.isdecimal() or len(steps) > 9 or not 2 <= int(steps) <= MOST_STEPS:
        raise BadInput(
            f"--sweep {text!r}: a range is FROM..TO/STEPS with 2 to {MOST_STEPS} steps, such as T_c=0.01..0.1/10"
        )
    try:
        low, high, count = read_number(first), read_number(last), int(steps)
    except BadInput as mistake:
        raise BadInput(f"--sweep {text!r}: {mistake}") from None
    for k in range(count):
        yield exact_text(Fraction(round((low + (high - low) * k / (count - 1)) * 10**9), 10**9))


def problems(base: Parameters, reading: Reading, axes: Sequence[Axis], changes: int | None = None) -> list[Problem]:
    """Return the parameter sets of a sweep: all combinations of the axes' values, each set once, in their order.

    With `changes`, the base counts as a further value of every axis, and only sets with at most that many changes are
    taken. A swept reading is no change.

    Raises:
        BadInput: an axis twice, an unknown name or value, a set that its reading does not take, or too many sets.
    """
    names = [axis.name for axis in axes]
    if len(set(names)) < len(names):
        raise BadInput(
            f"--sweep varies {next(name for name in names if names.count(name) > 1)} twice: give all its values at once"
        )
    result: dict[Problem, None] = {}
    for chosen in _combinations(axes, changes):
        here = next((Reading.parse(value) for name, value in chosen if name == "reading"), reading)
        settings = [f"{name}={value}" for name, value in chosen if name != "reading"]
        try:
            result[Problem(base.with_changes(settings), here)] = None
        except BadInput as mistake:
            shown = ", ".join(f"{name}={value}" for name, value in chosen)
            raise BadInput(f"--sweep, set {shown}: {str(mistake).removeprefix('--set: ')}") from None
        if len(result) > MOST_SETS:
            raise BadInput(f"the sweep has more than {MOST_SETS} parameter sets: take fewer values")
    return list(result)


def _combinations(axes: Sequence[Axis], changes: int | None) -> Iterator[list[tuple[str, str]]]:
    """Yield one value (or none) per axis, the last axis varying fastest, and nothing that has too many changes."""
    if not axes:
        yield []
        return
    first, rest = axes[0], axes[1:]
    swept_reading = first.name == "reading"
    if changes is not None and not swept_reading:
        yield from _combinations(rest, changes)
    if changes is None or swept_reading or changes > 0:
        left = changes if changes is None or swept_reading else changes - 1
        for value in first.values:
            yield from ([(first.name, value), *others] for others in _combinations(rest, left))


def file_name(problem: Problem) -> str:
    """Return the name of a parameter set's certificate: its reading and what differs from the published parameters.

    No two sets have the same: where the name cannot have all characters, a digest is part of it.
    """
    text = f"{problem.reading.value} {problem.parameters.describe()}"
    name = "".join(letter if letter.isalnum() or letter in "-_.=" else "_" for letter in text)
    if len(name) > MOST_CHARACTERS or "/" in text:
        digest = hashlib.sha256(text.encode()).hexdigest()[:12]
        name = f"{name[: MOST_CHARACTERS - len(digest) - 1]}_{digest}"
    return name + ".json"


def sweep(
    sets: Sequence[Problem], folder: Path | None, progress: Callable[[int, Problem, Margin | None], None], say: Say
) -> list[Margin]:
    """Compute every set, or take it from `folder` if a right certificate of it is there; write each as it comes.

    `progress` is told the number and the problem before each set, and its margin after it; `say`, in one sentence each,
    of certificates in the folder that do not count.
    """
    results = []
    for number, problem in enumerate(sets):
        progress(number, problem, None)
        found = _stored(problem, folder, say)
        if found is None:
            found = margin(problem)
            if folder is not None:
                write(folder / file_name(problem), certificate_text(found))
        results.append(found)
        progress(number, problem, found)
    return results


def _stored(problem: Problem, folder: Path | None, say: Say) -> Margin | None:
    """Return the margin of a certificate in the folder that is of this very problem and that the checker accepts."""
    if folder is None:
        return None
    path = folder / file_name(problem)
    if not os.path.lexists(path):
        return None
    try:
        found = from_certificate(read(read_bytes(path, "certificate", MOST_BYTES, "remove it")))
    except (BadInput, Rejected) as why:
        say(f"{path} does not count, and is computed again: {why}")
        return None
    if found.problem != problem:
        say(f"{path} does not count, and is computed again: it is about other parameters")
        return None
    return replace(found, problem=problem)  # a certificate does not say which parameters were given


def certificate_text(found: Margin) -> str:
    """Return the certificate as the JSON document that :mod:`swarmproof.margin.check` reads."""
    return json.dumps(found.certificate, indent=1) + "\n"
