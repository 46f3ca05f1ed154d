"""What a person sees while a command runs: text on standard output, progress on standard error."""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO, cast

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn, TimeElapsedColumn
from rich.status import Status

from swarmproof.errors import Failed
from swarmproof.streams import told


class _Checked:
    """A stream of text whose failures are sentences."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        with told(self._stream):
            return self._stream.write(text)

    def flush(self) -> None:
        with told(self._stream):
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


class _Courtesy(_Checked):
    """A stream of text that may fail: a progress bar that cannot be shown stops nothing."""

    def write(self, text: str) -> int:
        try:
            return super().write(text)
        except Failed:
            return len(text)

    def flush(self) -> None:
        with suppress(Failed):
            super().flush()


def text(json_target: str | None = None) -> Console:
    """Return where the text of a command goes: standard output, or standard error if JSON goes to standard output.

    Its `print` raises :class:`~swarmproof.errors.Failed` where it cannot be written.
    """
    return Console(file=_as_text(_Checked(sys.stderr if json_target == "-" else sys.stdout)), highlight=False)


def print_place(console: Console, what: str, path: Path | str | None) -> None:
    """Print where something was written, on one line that can be copied; nothing if it was not asked for."""
    if path is not None:
        console.print(f"{what}: {escape(str(path))}", soft_wrap=True)


def progress_console() -> Console:
    """Return where progress goes: standard error, if that is a terminal. What cannot be shown is not shown."""
    console = Console(file=_as_text(_Courtesy(sys.stderr)))
    console.quiet = not console.is_terminal  # a log has no use for bars, nor for the empty lines that they leave
    return console


def status(what: str) -> Status:
    """Return a line that says what is going on, until its end."""
    return Status(what, console=progress_console())


def bar(unit: str = "", *more: ProgressColumn, transient: bool = True) -> Progress:
    """Return a progress bar that counts `unit`; tasks' descriptions stand behind it."""
    columns: list[ProgressColumn] = [BarColumn(), MofNCompleteColumn(), TextColumn(unit), TimeElapsedColumn(), *more]
    return Progress(*columns, TextColumn("{task.description}"), console=progress_console(), transient=transient)


def _as_text(stream: _Checked) -> TextIO:
    return cast(TextIO, stream)
