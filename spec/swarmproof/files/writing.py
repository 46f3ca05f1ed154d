"""Files that are whole or as they were: written aside, then renamed. One home for all that is written."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from swarmproof.errors import Failed

#: Where the names of devices and of open files are: what stands there is never replaced.
_NOT_REPLACED = ("/dev/", "/proc/")
#: What a file system says that has no files without a name.
_NO_NAMELESS = (errno.EOPNOTSUPP, errno.EISDIR, errno.ENOENT, errno.EINVAL, errno.EPERM)


def write(path: Path, content: str | bytes) -> None:
    """Write a file, whole or not at all: whoever reads it meanwhile, or after a kill, has the old one or the new one.

    A device or a pipe is written to as it is. So is a file whose folder takes no new files.

    Args:
        path: the file; its folder must be there.
        content: text is written as UTF-8.

    Raises:
        Failed: it cannot be written, such as on a full disk; the old file is left as it was.
    """
    # a name that is no UTF-8 becomes an escape, which JSON reads as the same name
    data = content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
    try:
        if is_replaced(path):
            _replace(Path(os.path.realpath(path)), data)
        else:
            _write_into(path, data)
    except OSError as error:
        raise Failed(f"{path} cannot be written: {error.strerror or error}") from None


def is_replaced(path: Path) -> bool:
    """Return whether writing replaces this file: not if it is a device, a pipe, or an open file by its number."""
    if str(path.absolute() if path.is_absolute() else path).startswith(_NOT_REPLACED):
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
    aside = path.with_name(f".{path.name[:100]}.{os.getpid()}.part")
    try:
        _write_aside(aside, path, data, mode)
    except PermissionError:
        if mode is None or os.access(path.parent, os.W_OK):
            raise
        _write_into(path, data)


def _write_aside(aside: Path, path: Path, data: bytes, mode: int | None) -> None:
    """Write a file without a name, if there can be one, so that a kill leaves nothing; then give it the name."""
    try:
        descriptor = os.open(path.parent, os.O_WRONLY | os.O_TMPFILE, 0o666)
    except (AttributeError, OSError) as error:  # no such system, or no such file system
        if isinstance(error, OSError) and error.errno not in _NO_NAMELESS:
            raise
        descriptor = -1
    try:
        nameless = descriptor >= 0
        if not nameless:
            descriptor = os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
            file.flush()
            if mode is not None:
                os.fchmod(file.fileno(), mode)
            if nameless:
                number = file.fileno()  # given as src_dir_fd, it makes Python follow the link in /proc
                os.link(f"/proc/self/fd/{number}", aside, src_dir_fd=number, follow_symlinks=True)
        os.replace(aside, path)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise
