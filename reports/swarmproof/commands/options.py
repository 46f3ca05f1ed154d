"""What several commands do with their options."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from swarmproof.semantics.switches import BadInput


def whole_number(text: str) -> int:
    """Return the whole number, at least 0, in `text`: an argparse type."""
    if not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number of at least 0, such as 3")
    return int(text)


def write_json(target: str | None, text: str) -> None:
    """Write a JSON document to the file `target`, or to standard output if that is ``-``; nowhere if it is None.

    Raises:
        BadInput: the file cannot be written.
    """
    if target is None:
        return
    if target == "-":
        sys.stdout.write(text)
        return
    try:
        Path(target).write_text(text, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"cannot write {target}: {error.strerror}; give a file that can be written, or -") from None
