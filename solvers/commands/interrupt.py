"""Ctrl-C and SIGTERM while a command runs: both end the search, neither loses what it found."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def interruptible() -> Iterator[Callable[[], None]]:
    """Raise `KeyboardInterrupt` on SIGINT and SIGTERM; restore the handlers at the end.

    Yields
    ------
    callable
        To be called once the result is there: from then on both signals are ignored, so that a
        second Ctrl-C cannot stop the result from being written.
    """
    if threading.current_thread() is not threading.main_thread():
        # Only the main thread may set handlers, and only it receives the signals.
        yield lambda: None
        return
    before = {number: signal.signal(number, _interrupt) for number in _SIGNALS}

    def ignore() -> None:
        for number in _SIGNALS:
            signal.signal(number, signal.SIG_IGN)

    try:
        yield ignore
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _interrupt(number: int, frame: FrameType | None) -> NoReturn:
    raise KeyboardInterrupt
