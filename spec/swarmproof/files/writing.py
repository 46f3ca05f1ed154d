"""Files that are whole or as they were: written aside, then renamed. One home for all that is written."""

from __future__ import annotations

import errno
import hashlib
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from swarmproof.errors import Failed

#: Where the names of devices and of open files are: what stands there is never replaced.
_NOT_REPLACED = ("/dev/", "/proc/")
#: What a file system says that has no files without a name.
_NO_NAMELESS = (errno.EOPNOTSUPP, errno.EISDIR, errno.ENOENT, errno.EINVAL, errno.EPERM)
#: How often another process may take the name that a file has for a moment.
_MOST_RACES = 100


def write(path: Path, content: str | bytes) -> None:
    """Write a file, whole or not at all: whoever reads it meanwhile, or after a kill, has the old one or the new one.

    A device or a pipe is written to as it is. So is a file whose folder takes no new files.

    Args:
        path: the file; its folder must be there.
        content: text is written as UTF-8.

    Raises:
        Failed: it cannot be written, such as on a full disk; the old file is left as it was.
    """
    data = as_bytes(content)
    try:
        if is_replaced(path):
            _replace(Path(os.path.realpath(path)), data)
        else:
            _write_into(path, data)
    except OSError as error:
        raise Failed(f"{path} cannot be written: {error.strerror or error}") from None


def as_bytes(content: str | bytes) -> bytes:
    """Return text as UTF-8; a name in it that is no UTF-8 becomes an escape, which JSON reads as the same name."""
    return content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content


def is_replaced(path: Path) -> bool:
    """Return whether writing replaces this file: not if it is a device, a pipe, or an open file by its number."""
    if os.fspath(path).startswith(_NOT_REPLACED):
        return False
    return not path.exists() or path.is_file()


def _write_into(path: Path, data: bytes) -> None:
    # without O_NONBLOCK, a pipe that nobody reads from would be waited for, without end
    descriptor = os.open(path, os.O_WRONLY | os.O_TRUNC | os.O_NONBLOCK)
    os.set_blocking(descriptor, True)
    with os.fdopen(descriptor, "wb") as file:
        file.write(data)


def _replace(path: Path, data: bytes) -> None:
    mode = stat.S_IMODE(path.stat().st_mode) if path.exists() else None
    try:
        for _ in range(_MOST_RACES):
            with _nameless(path.parent, data, mode) as descriptor:
                if descriptor is None:
                    _write_aside(path, data, mode)
                elif not _give_name(descriptor, path):
                    continue
            return
        raise OSError(errno.EAGAIN, "other processes write it all the time")
    except PermissionError:
        if mode is None or os.access(path.parent, os.W_OK):
            raise
        _write_into(path, data)


@contextmanager
def _nameless(folder: Path, data: bytes, mode: int | None) -> Iterator[int | None]:
    """Write a file that has no name, so that a kill leaves nothing; None where there can be no such file."""
    try:
        os.stat("/proc/self/fd")
        descriptor = os.open(folder, os.O_WRONLY | os.O_TMPFILE, 0o666)
    except (AttributeError, OSError) as error:  # no such system, or no such file system
        if isinstance(error, OSError) and error.errno not in _NO_NAMELESS:
            raise
        yield None
        return
    with os.fdopen(descriptor, "wb") as file:
        _fill(file, data, mode)
        yield descriptor


def _fill(file: BinaryIO, data: bytes, mode: int | None) -> None:
    file.write(data)
    file.flush()
    if mode is not None:
        os.fchmod(file.fileno(), mode)


def _give_name(descriptor: int, path: Path) -> bool:
    """Give a file its name, in the place of another; False if another process was just here, or was killed here."""
    aside = _aside(path)
    try:
        # src_dir_fd, whatever it is, makes Python follow the link in /proc
        os.link(f"/proc/self/fd/{descriptor}", aside, src_dir_fd=descriptor, follow_symlinks=True)
        os.replace(aside, path)
    except FileExistsError:
        aside.unlink(missing_ok=True)
        return False
    except FileNotFoundError:  # the other one has removed it
        return False
    except BaseException:
        aside.unlink(missing_ok=True)
        raise
    return True


def _write_aside(path: Path, data: bytes, mode: int | None) -> None:
    aside = _aside(path, f".{os.getpid()}")
    try:
        with open(aside, "wb") as file:
            _fill(file, data, mode)
        os.replace(aside, path)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise


def _aside(path: Path, whose: str = "") -> Path:
    # as short for a long name, and never that of another file
    digest = hashlib.sha256(os.fsencode(path.name)).hexdigest()[:16]
    return path.with_name(f".swarmproof-{digest}{whose}.part")
