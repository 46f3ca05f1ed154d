"""Signals that wait: a block that must not be left in its middle, such as a round that is being judged."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

#: What interrupts: Ctrl-C, and TERM.
SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def deferred() -> Iterator[None]:
    """Let signals wait until the end of a block that must not be left in its middle."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    waiting: list[tuple[int, FrameType | None]] = []
    before: list[Any] = [signal.getsignal(one) for one in SIGNALS]
    for one, handler in zip(SIGNALS, before, strict=True):
        if callable(handler):
            signal.signal(one, lambda number, frame: waiting.append((number, frame)))
    try:
        yield
    finally:
        for one, handler in zip(SIGNALS, before, strict=True):
            signal.signal(one, handler)
    for number, frame in waiting:
        before[SIGNALS.index(signal.Signals(number))](number, frame)
