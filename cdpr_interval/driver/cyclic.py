"""Who calls the cycle: a thread in real time, or whoever waits on a simulated clock."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import Protocol

OVERRUN_SHARE = 0.5
"""Of a cycle; a cycle that starts later than that is reported."""


class Clockwork(Protocol):
    """Runs a cycle again and again."""

    def start(self) -> None:
        """Begin."""

    def wait(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Let cycles pass until a condition holds; return whether it does within so many seconds."""

    def close(self) -> None:
        """End: no cycle runs afterwards."""


class Stepped:
    """Cycles run while somebody waits: for a bus with a simulated clock."""

    def __init__(self, cycle: Callable[[], None], period: float) -> None:
        self._cycle, self._period = cycle, period

    def start(self) -> None:
        """Nothing to begin."""

    def wait(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Run cycles until the condition holds, as many as take so long."""
        for _ in range(math.ceil(timeout / self._period)):
            if condition():
                return True
            self._cycle()
        return condition()

    def close(self) -> None:
        """Nothing to end."""


class RealTime:
    """A thread that runs the cycle at its period.

    Whatever ends it, ``abandon`` is called with the reason. ``overran`` is called in the thread, with the
    delay in s, when a cycle starts late: the machine or the cycle before was too slow.
    """

    def __init__(
        self,
        cycle: Callable[[], None],
        period: float,
        abandon: Callable[[str], None],
        overran: Callable[[float], None],
    ) -> None:
        self._cycle, self._period, self._abandon, self._overran = cycle, period, abandon, overran
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="winch cycle", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def _run(self) -> None:
        reason = "the cyclic thread ended"
        try:
            due = time.monotonic()
            while not self._over.is_set():
                self._cycle()
                due += self._period
                late = time.monotonic() - due
                if late > OVERRUN_SHARE * self._period:
                    self._overran(late)
                    # Do not hurry to catch up: set-points have times of their own.
                    due = time.monotonic()
                self._over.wait(max(due - time.monotonic(), 0.0))
            reason = "the driver was closed"
        except BaseException as error:
            reason = f"the cyclic thread died: {type(error).__name__}: {error}"
            raise
        finally:
            self._abandon(reason)

    def wait(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Look once a cycle whether the condition holds."""
        end = time.monotonic() + timeout
        while not condition():
            if time.monotonic() >= end or not self._thread.is_alive():
                return condition()
            time.sleep(self._period / 2)
        return True

    def close(self) -> None:
        """End the thread."""
        self._over.set()
        if self._thread.is_alive():
            self._thread.join(timeout=5.0)
