"""Reading what somebody else wrote: measured before it is read, never waited for without end, or one sentence."""

from __future__ import annotations

import os
import threading
import tracemalloc
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmproof.errors import BadInput
from swarmproof.faults.script import read_script
from swarmproof.files import reading
from swarmproof.files.reading import MOST_DOTS, MOST_NESTED, check_toml, read_bytes
from swarmproof.theorem3.numbers import read_toml
from swarmproof.trace.trace import read

RIGHT = "give a right one"
#: How each kind of file is read: a file that is missing, wrong or too long is refused by each of them.
READERS: dict[str, Callable[[Path], object]] = {
    "toml": lambda path: read_toml(path, "scenario", "rounds = 60"),
    "script": lambda path: read_script(path, 2, 2),
    "trace": read,
}


def test_what_is_there_is_read(tmp_path: Path) -> None:
    """A file as long as the limit is read; its mark of byte order is not part of it."""
    path = tmp_path / "file"
    for content in (b"", b"x" * 100):
        path.write_bytes(content)
        assert read_bytes(path, "file", 100, RIGHT) == content
    path.write_bytes(b"\xef\xbb\xbfx")
    assert read_bytes(path, "file", 100, RIGHT) == b"x"


def test_a_file_is_measured_before_it_is_read(tmp_path: Path) -> None:
    """Three gigabytes of nothing are refused without memory for them."""
    path = tmp_path / "file"
    with path.open("wb") as file:
        file.truncate(3 << 30)
    tracemalloc.start()
    with pytest.raises(BadInput, match="is too long for a file: 100000000 bytes are the most"):
        read_bytes(path, "file", 10**8, RIGHT)
    assert tracemalloc.get_traced_memory()[1] < 10**6
    tracemalloc.stop()


def test_a_device_without_end_is_read_up_to_the_limit() -> None:
    """/dev/zero is too long, and /dev/null is empty."""
    with pytest.raises(BadInput, match="too long"):
        read_bytes("/dev/zero", "file", 3 * 10**6, RIGHT)
    assert read_bytes("/dev/null", "file", 10, RIGHT) == b""


def test_a_pipe_is_read_to_its_end(tmp_path: Path) -> None:
    """As `<(command)` in a shell: also if the writer comes later, and says it in parts."""
    path = tmp_path / "pipe"
    os.mkfifo(path)

    def write() -> None:
        with path.open("wb", buffering=0) as file:
            for _ in range(100):
                file.write(b"x" * 5000)

    writer = threading.Thread(target=write)
    writer.start()
    assert read_bytes(path, "file", 10**6, RIGHT) == b"x" * 500_000
    writer.join()


def test_a_pipe_that_nobody_writes_to_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is one sentence, after some seconds."""
    monkeypatch.setattr(reading, "PATIENCE_S", 0.01)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(BadInput, match="nothing came for 0 s; give a right one"):
        read_bytes(tmp_path / "pipe", "file", 10, RIGHT)


@pytest.mark.parametrize("reader", READERS.values(), ids=READERS)
@pytest.mark.parametrize("name", ["none", "folder", "loop", "file/below", "x" * 300, "nul\0"], ids=repr)
def test_what_cannot_be_read_is_one_sentence(tmp_path: Path, name: str, reader: Callable[[Path], object]) -> None:
    """It says what, where, why, and what would be right, whichever file it is."""
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(BadInput, match=r"^cannot read the (scenario|script|trace) .*: .*; give a") as error:
        reader(Path(f"{tmp_path}/{name}"))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("reader", READERS.values(), ids=READERS)
@pytest.mark.parametrize(
    "content",
    [
        b"\xff\xfeh\0a\0",
        b"\xff" * 100,
        b"[" * 100_000,
        b'{"a":' * 100_000,
        b"\0" * 100,
        b"a = " + b"9" * 10**6,
        b'{"schema": ' + b"9" * 10**6 + b"}",
        b"a" + b".a" * 20_000 + b" = 1",
        b"[a" + b".a" * 20_000 + b"]",
        b"a = " + b"{a = " * 1000,
        b"a = [1" + b",[" * 1000,
    ],
    ids=["utf-16", "bytes", "deep", "deep-json", "zeros", "digits", "json-digits", "dots", "header", "inline", "lists"],
)
def test_content_that_is_wrong_is_one_sentence(
    tmp_path: Path, content: bytes, reader: Callable[[Path], object]
) -> None:
    """Whatever is in a file, one sentence says that it cannot be, and soon."""
    path = tmp_path / "file"
    path.write_bytes(content)
    with pytest.raises(BadInput) as error:
        reader(path)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 1000


@pytest.mark.parametrize("reader", READERS.values(), ids=READERS)
@given(st.binary(max_size=200) | st.text(max_size=100).map(str.encode))
@settings(max_examples=60, deadline=None, derandomize=True, database=None)
def test_any_bytes_are_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, reader: Callable[[Path], object], content: bytes
) -> None:
    """Nothing but a sentence comes out of what is no such file."""
    path = tmp_path_factory.mktemp("any") / "file"
    path.write_bytes(content)
    with suppress(BadInput):
        reader(path)


def test_a_file_with_a_mark_of_byte_order_is_read(tmp_path: Path) -> None:
    """As some editors write it."""
    path = tmp_path / "file"
    path.write_bytes(b"\xef\xbb\xbfa = 0.1\n")
    assert read_toml(path, "scenario", "rounds = 60") == {"a": "0.1"}


@pytest.mark.parametrize(
    "text",
    [
        "a.b.c = 1",
        '"' + "a." * 100 + '" = 1',
        "'" + "a." * 100 + "' = 1",
        "# " + "a." * 100,
        'a = """' + "a.\n[" * 100 + '"""',
        "a = '''" + "a.[" * 100 + "'''",
        'a = "\\"' + "a.[" * 100 + '"',
        "a = [" + "1.5, " * 100 + "]",
        "a = [" + "[1.5, 2.5], " * 100 + "]",
        "\n".join("[a.b.c]" for _ in range(100)),
        "a = " + "[" * MOST_NESTED + "]" * MOST_NESTED,
        "a" + ".a" * MOST_DOTS + " = 1",
    ],
    ids=range(12),
)
def test_what_people_write_is_not_refused(text: str) -> None:
    """Dots in strings, comments and numbers are none of a key; lists side by side are not nested."""
    check_toml(text)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("a" + ".a" * (MOST_DOTS + 1) + " = 1", "dots"),
        ("a" + ' . "a"' * (MOST_DOTS + 1) + " = 1", "dots"),
        ("[[a" + ".a" * (MOST_DOTS + 1) + "]]", "dots"),
        ("x = {a" + ".a" * (MOST_DOTS + 1) + " = 1}", "dots"),
        ("a = " + "[" * (MOST_NESTED + 1), "nested"),
        ("a = " + "{b = " * (MOST_NESTED + 1), "nested"),
        ("a = " + "[\n" * (MOST_NESTED + 1), "nested"),
    ],
    ids=["key", "quoted", "header", "inline", "lists", "tables", "lines"],
)
def test_what_nobody_writes_is_refused(text: str, why: str) -> None:
    """One more than the limit, in each of the places where it can be."""
    with pytest.raises(ValueError, match=why):
        check_toml(text)
