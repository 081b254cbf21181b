"""Ctrl-C and SIGTERM while a command runs: both end the search, neither loses what it found."""

from __future__ import annotations

import _thread
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_PAUSE_S = 0.1
"""Between two interrupts of what the first did not end."""


class OutOfTime(Exception):
    """The time limit has passed."""


class Signals:
    """What SIGINT and SIGTERM do at present."""

    def __init__(self) -> None:
        self._is_held = False
        self._came = False

    def hold(self) -> None:
        """Let both signals wait: the result is there, and no second Ctrl-C can stop it from being written."""
        self._is_held = True

    def release(self) -> bool:
        """Let both signals interrupt again; return whether one waits, which is forgotten."""
        came, self._came, self._is_held = self._came, False, False
        return came

    def handle(self, number: int, frame: FrameType | None) -> None:
        """Raise `KeyboardInterrupt`, or let the signal wait."""
        if not self._is_held:
            raise KeyboardInterrupt
        self._came = True


@contextmanager
def interruptible() -> Iterator[Signals]:
    """Raise `KeyboardInterrupt` on SIGINT and SIGTERM; restore the handlers at the end.

    Yields
    ------
    Signals
        To be held once the result is there.
    """
    signals = Signals()
    if threading.current_thread() is not threading.main_thread():
        # Only the main thread may set handlers, and only it receives the signals.
        yield signals
        return
    before = {number: signal.signal(number, signals.handle) for number in _SIGNALS}
    try:
        yield signals
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def limited(seconds: float | None) -> Iterator[None]:
    """Interrupt work that has no budget of its own after so many seconds, until it ends; None: never.

    One interrupt is not enough: one that comes while an object is finalised is lost.

    Raises
    ------
    OutOfTime
        The work was interrupted, and did not return what it had.
    """
    if seconds is None:
        yield
        return
    over, ended = threading.Event(), threading.Event()

    def interrupt() -> None:
        pause = seconds
        while not ended.wait(pause):
            over.set()
            _thread.interrupt_main()
            pause = _PAUSE_S

    thread = threading.Thread(target=interrupt, daemon=True)
    thread.start()
    try:
        try:
            yield
        finally:
            # None may come after this: it would interrupt what knows nothing of the limit.
            ended.set()
            thread.join()
    except KeyboardInterrupt:
        if not over.is_set():
            raise
        raise OutOfTime from None
