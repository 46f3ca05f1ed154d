"""Where a command's results go: files and folders that are reserved before anything is computed, and then whole or old.

A report is a folder. It is collected, staged in a hidden folder within, and then put in place at once: its index is
removed first and comes back last, so that there is never an index beside files of another run.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path, PurePosixPath
from types import TracebackType

import msgspec

from swarmproof import streams
from swarmproof.campaign.deferred import deferred
from swarmproof.errors import BadInput, Failed
from swarmproof.files.reading import read_bytes
from swarmproof.files.writing import as_bytes, is_replaced, write

try:
    from fcntl import LOCK_EX, LOCK_NB, flock
except ImportError:  # a system without such locks: two runs into one folder are then not noticed
    flock = None  # type: ignore[assignment]

#: In a report's folder: which files are of swarmproof, so that the next report removes what it does not write itself.
LISTED = ".swarmproof.json"
MOST_BYTES = 10**7
_STAGE = ".swarmproof-stage"
_LISTS = (".first", ".last")
#: What names other files of its folder: it is the first to go, and the last to come.
_INDICES = ("verdicts.json", "matrix.json", "index.html")


def reserve_file(target: str | Path | None) -> None:
    """Make sure that a file can be written, before anything is computed, and leave it as it is; "-" is no file.

    Raises:
        BadInput: it cannot be written.
    """
    if target is None or target == "-":
        return
    path = Path(target)
    try:
        if not is_replaced(path):
            if path.is_dir():
                raise IsADirectoryError(None, "it is a folder")
            if not os.access(path, os.W_OK):
                raise PermissionError(None, "no permission")
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        path = Path(os.path.realpath(path))  # what a link points to is what is written
        if os.path.lexists(path):
            with path.open("ab"):
                pass
        else:  # which leaves nothing, whenever it is killed
            with tempfile.TemporaryFile(dir=path.parent):
                pass
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise BadInput(f"cannot write {target}: {why}; give a file that can be written, such as out.json") from None


def write_json(target: str | None, document: str | bytes) -> None:
    """Write a JSON document to the file `target`, or to standard output if that is ``-``; nowhere if it is None.

    Raises:
        Failed: it cannot be written.
    """
    if target == "-":
        streams.write_bytes(as_bytes(document))
    elif target is not None:
        write(Path(target), document)


def deliver(*ways: Callable[[], None]) -> None:
    """Tell what was found in every way that was asked for: where one fails, the others are tried all the same.

    Args:
        ways: what takes longest, such as drawing a page, should come last.

    Raises:
        Failed: some of them failed; the sentence has them all.
        Exception: of a defect of ours, which comes before failures.
    """
    failures: list[str] = []
    defect: Exception | None = None
    for way in ways:
        try:
            way()
        except Failed as failed:
            failures.append(str(failed))
        except Exception as error:
            defect = defect or error
    if defect is not None:
        raise defect
    if failures:
        raise Failed("; ".join(dict.fromkeys(failures)))


def reserve_folder(path: Path) -> Path:
    """Make a folder if need be, make sure that files can be written in it, and return it. Several runs may share it.

    Raises:
        BadInput: files cannot be written in it.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise BadInput(f"cannot write to {path}: {why}; give a folder that can be written to, such as out") from None
    return path


def reserve_report(path: str | None) -> AbstractContextManager[ReportFolder | None]:
    """Return the reserved folder of a report, for a `with`; None in it if no report was asked for.

    Raises:
        BadInput: it cannot be used.
    """
    return nullcontext() if path is None else ReportFolder(Path(path))


def publish(folder: ReportFolder | None, put: Callable[[ReportFolder], None]) -> None:
    """Let `put` collect a report, and put it in place; nothing if no report was asked for.

    Raises:
        Failed: it cannot be written.
    """
    if folder is not None:
        put(folder)
        folder.publish()


class ReportFolder:
    """A folder for a report: reserved for this run from the beginning, written at the end. To be used in a `with`.

    Attributes:
        path: the folder.
    """

    def __init__(self, path: Path) -> None:
        """Make the folder if need be, and make sure that it can be written to, and that no other run does so.

        Raises:
            BadInput: it cannot be used.
        """
        self.path = reserve_folder(path)
        self._files: dict[str, str | bytes] = {}
        self._lock = _locked(path)
        shutil.rmtree(path / _STAGE, ignore_errors=True)  # of a run that was killed

    def __enter__(self) -> ReportFolder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._lock >= 0:
            os.close(self._lock)

    @property
    def index(self) -> Path:
        """The page to open first."""
        return self.path / "index.html"

    def put(self, name: str, content: str | bytes) -> None:
        """Collect a file; `name` is relative to the folder, with `/`."""
        self._files[name] = content

    def publish(self) -> None:
        """Write what was collected, and remove what an earlier report wrote; all or, on failure, nothing.

        Raises:
            Failed: it cannot be written.
        """
        stage = self.path / _STAGE
        try:
            try:
                earlier = _listed(self.path)
                self._stage(stage, earlier)
                with deferred():
                    self._commit(stage, earlier)
            finally:
                shutil.rmtree(stage, ignore_errors=True)
        except OSError as error:
            raise Failed(f"the report in {self.path} cannot be written: {error.strerror or error}") from None

    def _stage(self, stage: Path, earlier: set[str]) -> None:
        stage.mkdir(exist_ok=True)
        for name, content in self._files.items():
            path = stage / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(as_bytes(content))
        # first, so that the next run knows what is there if this one is killed; and in the end
        (stage / _LISTS[0]).write_bytes(_list({*earlier, *self._files}))
        (stage / _LISTS[1]).write_bytes(_list(self._files))

    def _commit(self, stage: Path, earlier: set[str]) -> None:
        os.replace(stage / _LISTS[0], self.path / LISTED)
        for name in sorted({*earlier, *self._files}, key=_order, reverse=True):
            if _order(name)[0] or name not in self._files:
                (self.path / name).unlink(missing_ok=True)
        for name in sorted(self._files, key=_order):
            path = self.path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            os.replace(stage / name, path)
        for folder in {(self.path / name).parent for name in earlier} - {self.path}:
            if folder.is_dir() and not any(folder.iterdir()):
                folder.rmdir()
        os.replace(stage / _LISTS[1], self.path / LISTED)


def _list(names: Iterable[str]) -> bytes:
    document = {"schema": "swarmproof.report/1", "files": sorted(names)}
    return msgspec.json.format(msgspec.json.encode(document), indent=1) + b"\n"


def _order(name: str) -> tuple[int, int, str]:
    """Return where a file stands in the order of writing: indices last, those of the whole report behind all others."""
    path = PurePosixPath(name)
    rank = _INDICES.index(path.name) + 1 if path.name in _INDICES else 0
    return bool(rank), rank - 10 * len(path.parts), name


def _listed(folder: Path) -> set[str]:
    """Return the files that an earlier report wrote here; none if the list is not ours."""
    try:
        content = read_bytes(folder / LISTED, "list of a report's files", MOST_BYTES, "remove it")
        names = msgspec.json.decode(content, type=dict[str, object]).get("files")
    except (ValueError, RecursionError):  # there is none, or one that is not ours
        return set()
    listed = names if isinstance(names, list) else []
    return {name for name in listed if isinstance(name, str) and _is_within(name)}


def _is_within(name: str) -> bool:
    path = PurePosixPath(name)
    return bool(path.parts) and not path.is_absolute() and ".." not in path.parts and "\0" not in name


def _locked(folder: Path) -> int:
    """Return a descriptor that keeps other runs out of the folder until it is closed, also by a kill.

    Raises:
        BadInput: another run has it.
    """
    if flock is None:
        return -1
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        flock(descriptor, LOCK_EX | LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise BadInput(
            f"another run of swarmproof is writing to {folder}: wait until it has ended, or give another folder"
        ) from None
    except OSError:  # a network's file system without such locks
        os.close(descriptor)
        return -1
    return descriptor
