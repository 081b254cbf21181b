"""How much a search may spend, and why it stopped."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from types import FrameType


class Stop(StrEnum):
    """Why a search ended."""

    EXHAUSTED = "exhausted"
    """Every cell was decided or ended as a leaf."""
    TIME_LIMIT = "time_limit"
    CELL_LIMIT = "cell_limit"
    INTERRUPTED = "interrupted"


class Budget:
    """Wall time and cells shared by all searches of one run; safe to use from several threads."""

    def __init__(self, time_limit: float | None = None, cell_limit: int | None = None) -> None:
        self._deadline = None if time_limit is None else time.monotonic() + time_limit
        self._cell_limit = cell_limit
        self._lock = threading.Lock()
        self._reserved = 0
        self._interrupted = threading.Event()
        self._raises = False
        self.cells = 0
        """Cells looked at so far."""

    def interrupt(self) -> None:
        """Ask every search to stop after its current chunk."""
        self._interrupted.set()

    def reserve(self, wanted: int) -> int:
        """Return how many cells (at most ``wanted``) may be looked at now; 0 when spent."""
        if self.stop() is not None:
            return 0
        with self._lock:
            left = wanted if self._cell_limit is None else min(wanted, self._cell_limit - self._reserved)
            self._reserved += max(left, 0)
            return max(left, 0)

    def settle(self, reserved: int, used: int) -> None:
        """Book the cells really looked at out of a reservation."""
        with self._lock:
            self._reserved -= reserved - used
            self.cells += used

    def stop(self) -> Stop | None:
        """Return why the run must stop now, or None."""
        if self._interrupted.is_set():
            return Stop.INTERRUPTED
        if self._deadline is not None and time.monotonic() >= self._deadline:
            return Stop.TIME_LIMIT
        if self._cell_limit is not None and self.cells >= self._cell_limit:
            return Stop.CELL_LIMIT
        return None

    def seconds_left(self) -> float | None:
        """Return how much of the wall time is left, negative when it is over; None: there is no limit."""
        return None if self._deadline is None else self._deadline - time.monotonic()

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Turn SIGINT and SIGTERM into ``interrupt`` while the block runs; a second SIGINT raises.

        No exception is thrown into running code, so nothing already computed is lost. Outside
        the main thread, where Python allows no signal handlers, this does nothing.
        """
        if threading.current_thread() is not threading.main_thread():
            yield
            return

        def handle(number: int, frame: FrameType | None) -> None:
            is_second = self._interrupted.is_set() and number == signal.SIGINT
            self.interrupt()
            if is_second or self._raises:
                raise KeyboardInterrupt

        raises, self._raises = self._raises, False
        before = {s: signal.signal(s, handle) for s in (signal.SIGINT, signal.SIGTERM)}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
            self._raises = raises

    @contextmanager
    def raising(self) -> Iterator[None]:
        """Let a signal raise `KeyboardInterrupt` in a part of a `listening` block that asks for no budget."""
        self._raises = True
        try:
            yield
        finally:
            self._raises = False
