"""Signals INT (Ctrl-C) and TERM: both end what is being done, and what was found is kept and told."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from swarmproof.campaign.deferred import SIGNALS
from swarmproof.exit_codes import ExitCode

#: After this time, in s, a signal is sent again.
_SOON_S = 0.02


class Terminated(KeyboardInterrupt):
    """The signal TERM: an interrupt that somebody else sent."""


@contextmanager
def handled() -> Iterator[None]:
    """Handle the signals as :func:`leave_at_once` until :func:`from_now_on`; at the end as before, or not any more."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = [signal.getsignal(one) for one in SIGNALS]
    hook, sys.unraisablehook = sys.unraisablehook, _again
    try:
        for one, handler in zip(SIGNALS, before, strict=True):
            if handler is not signal.SIG_IGN:  # a shell lets what runs in the background ignore Ctrl-C
                signal.signal(one, leave_at_once)
        yield
    finally:
        sys.unraisablehook = hook
        is_program = before[0] is signal.SIG_DFL  # see __main__: all is said, and only the exit code is left to give
        for one, handler in zip(SIGNALS, before, strict=True):
            signal.signal(one, signal.SIG_IGN if is_program else handler)
        # `python -m` would end by the signal, whatever the exit code, if an interrupt came while Python ran a text, as
        # it does for a named tuple of a module that loads. Running another text makes it forget that.
        exec("")


def leave_at_once(number: int, frame: FrameType | None) -> None:
    """Handle a signal while modules load, when there is nothing to keep."""
    os.write(2, b"swarmproof: interrupted\n")
    os._exit(ExitCode.INTERRUPTED if number == signal.SIGINT else ExitCode.TERMINATED)


def from_now_on() -> None:
    """Let signals raise KeyboardInterrupt, which what runs long catches to keep what it has."""
    for one in SIGNALS:
        if threading.current_thread() is threading.main_thread() and signal.getsignal(one) is leave_at_once:
            signal.signal(one, _raise)


def _again(unraisable: sys.UnraisableHookArgs) -> None:
    """Send a signal again that came where Python can raise nothing, such as in a weak reference's callback."""
    if not isinstance(unraisable.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)
        return
    number = signal.SIGTERM if isinstance(unraisable.exc_value, Terminated) else signal.SIGINT
    timer = threading.Timer(_SOON_S, os.kill, (os.getpid(), number))
    timer.daemon = True
    timer.start()


def _raise(number: int, frame: FrameType | None) -> None:
    raise Terminated if number == signal.SIGTERM else KeyboardInterrupt
