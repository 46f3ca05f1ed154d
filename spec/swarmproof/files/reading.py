"""Files of a user's, read with a limit: the one home of opening what somebody else wrote."""

from __future__ import annotations

import errno
import os
import re
import select
import stat

from swarmproof.errors import BadInput

#: How long a pipe may say nothing before it is given up, in s.
PATIENCE_S = 10.0
#: How many dots a key of TOML may have, and how deeply lists and tables may be nested: more than anybody writes.
MOST_DOTS = 20
MOST_NESTED = 50

_PART = 1 << 20
_BOM = b"\xef\xbb\xbf"
#: What has no structure in TOML: comments and strings; then what counts, and what ends a key.
_TOML = re.compile(
    r"""\#[^\n]* | \"{3}(?:\\.|[^\\])*?\"{3} | '{3}.*?'{3} | "(?:\\.|[^"\\\n])*" | '[^'\n]*' """
    r"""| (?P<opens>[\[{]) | (?P<closes>[\]}]) | (?P<dot>\.) | (?P<ends>[=,\n])""",
    re.VERBOSE | re.DOTALL,
)


def read_bytes(path: str | os.PathLike[str], what: str, most_bytes: int, right: str) -> bytes:
    """Return what is in a file, without the mark of byte order that some editors write first.

    A file is measured before it is read. A pipe or a device is read up to the limit, and waited for at most
    :data:`PATIENCE_S`.

    Args:
        path: the file.
        what: what it should be, such as "scenario".
        most_bytes: how long it may be.
        right: what to give instead, such as "give a TOML file".

    Raises:
        BadInput: there is no such file, it cannot be read, or it is too long.
    """
    place = os.fspath(path)
    try:
        content = _read(place, most_bytes)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise BadInput(f"cannot read the {what} {place}: {reason}; {right}") from None
    if content is None:
        raise BadInput(f"{place} is too long for a {what}: {most_bytes} bytes are the most")
    return content.removeprefix(_BOM)


def _read(place: str, most_bytes: int) -> bytes | None:
    """Return the content; None if there is more."""
    # without O_NONBLOCK, opening a pipe that nobody writes to would wait without end
    descriptor = os.open(place, os.O_RDONLY | os.O_NONBLOCK)
    try:
        found = os.fstat(descriptor)
        if stat.S_ISDIR(found.st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        is_file = stat.S_ISREG(found.st_mode)
        if is_file and found.st_size > most_bytes:
            return None
        parts: list[bytes] = []
        left = most_bytes + 1
        while left and (part := _part(descriptor, min(left, _PART), is_file)):
            parts.append(part)
            left -= len(part)
        return b"".join(parts) if left else None
    finally:
        os.close(descriptor)


def _part(descriptor: int, most: int, is_file: bool) -> bytes:
    while True:
        if not is_file and not select.select([descriptor], [], [], PATIENCE_S)[0]:
            raise TimeoutError(errno.ETIMEDOUT, f"nothing came for {PATIENCE_S:.0f} s")
        try:
            return os.read(descriptor, most)
        except BlockingIOError:
            continue


def check_toml(text: str) -> None:
    """Refuse TOML that the parser would take minutes and gigabytes for: keys of many dots, or deep nesting.

    Raises:
        ValueError: it has a key with more than :data:`MOST_DOTS` dots, or more than :data:`MOST_NESTED` open brackets.
    """
    depth = dots = 0
    for token in _TOML.finditer(text):
        kind = token.lastgroup
        if kind == "dot":
            dots += 1
            if dots > MOST_DOTS:
                raise ValueError(f"a key has more than {MOST_DOTS} dots")
        elif kind is not None:
            dots = 0
            depth += (kind == "opens") - (kind == "closes")
            if depth > MOST_NESTED:
                raise ValueError("its lists are nested too deeply")
