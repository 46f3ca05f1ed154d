"""Standard output and standard error, whatever they are: closed, full, or of an encoding that lacks our letters."""

from __future__ import annotations

import codecs
import os
import re
import sys
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from typing import TextIO

from swarmproof.errors import Failed

#: What stands for a letter or sign of ours where the encoding has none. No two verdicts get the same.
SUBSTITUTES = {
    "Δ": "Delta ",
    "✓": "+",
    "✗": "x",
    "×": "x",
    "·": "*",
    "−": "-",
    "–": "-",
    "—": "-",
    "─": "-",
    "━": "-",
    "│": "|",
    "…": "...",
    "≤": "<=",
    "≥": ">=",
    "≠": "!=",
    "≈": "~",
    "∈": " in ",
    "∞": "inf",
    "∀": "for all ",
    "→": "->",
    "⇒": "=>",
    "↔": "<->",
    "‖": "||",
    "√": "sqrt",
    "½": "1/2",
    "µ": "u",
    "±": "+-",
    "²": "^2",
    "³": "^3",
    "⁻": "^-",
    "¹": "^1",
    "₀": "0",
    "₁": "1",
    "₂": "2",
    "’": "'",
    "“": '"',
    "”": '"',
    "\u0302": "_hat",  # d̂
    "\u0303": "_tilde",
    "•": "*",
    "′": "'",
    "↺": "(loop)",
    "⌊": "floor(",
    "⌋": ")",
    "⟨": "<",
    "⟩": ">",
    "◆": "<>",
    "◐": "(half)",
    "\ufeff": "",
}
#: The name of our error handler of codecs.
HANDLER = "swarmproof"


def substitute(error: UnicodeError) -> tuple[str, int]:
    """Return what stands for the letters that cannot be written, and where to go on: a handler of codecs."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_plain(letter) for letter in error.object[error.start : error.end]), error.end


def _plain(letter: str) -> str:
    if letter in SUBSTITUTES:
        return SUBSTITUTES[letter]
    greek = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", unicodedata.name(letter, ""))
    if greek is not None:
        return greek[2].lower() if greek[1] == "SMALL" else greek[2].title()
    base = unicodedata.normalize("NFD", letter)[0]
    return base if base.isascii() else letter.encode("ascii", "backslashreplace").decode()


codecs.register_error(HANDLER, substitute)


def prepare() -> None:
    """Make both streams such that whatever we say can be written there.

    Raises:
        Failed: standard output is closed: nothing that would be found could be said.
    """
    for descriptor in range(3):  # else the next file that is opened would be taken for a standard stream
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors=HANDLER)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115 - as long as the process
    if sys.stdout is None:
        raise Failed("standard output is closed, so that nothing could be said: send it to a file, or to /dev/null")


def say(sentence: str) -> None:
    """Say a sentence on standard error, if that can be written; the exit code says the rest."""
    try:
        print(f"swarmproof: {sentence}", file=sys.stderr, flush=True)
    except OSError:
        abandon(sys.stderr)


def finish() -> None:
    """Write what is left to be written on standard output.

    Raises:
        Failed: it cannot be.
    """
    with told(sys.stdout):
        sys.stdout.flush()


def print_out(text: str) -> None:
    """Write a text to standard output.

    Raises:
        Failed: it cannot be written.
    """
    with told(sys.stdout):
        sys.stdout.write(text)
        sys.stdout.flush()


def write_bytes(data: bytes) -> None:
    """Write a document to standard output as it is, in UTF-8 whatever the terminal's encoding.

    Raises:
        Failed: it cannot be written.
    """
    with told(sys.stdout):
        sys.stdout.flush()
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()


@contextmanager
def told(stream: TextIO) -> Iterator[None]:
    """Raise :class:`~swarmproof.errors.Failed` where a stream cannot be written, and forget what it could not take."""
    try:
        yield
    except OSError as error:
        abandon(stream)
        name = "standard error" if stream is sys.stderr else "standard output"
        if isinstance(error, BrokenPipeError):
            raise Failed(f"whoever read {name} went away before all was said") from None
        raise Failed(f"{name} cannot be written: {error.strerror or error}") from None


def abandon(stream: TextIO) -> None:
    """Send what a stream could not take to nowhere: the interpreter must not try again at its end."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
    except (OSError, ValueError):  # a stream that is no file, such as in a test
        return
