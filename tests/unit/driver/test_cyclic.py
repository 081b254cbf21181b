"""The thread that runs the cycle."""

from __future__ import annotations

import threading
import time

from cdpr_interval.driver.cyclic import OVERRUN_SHARE, RealTime

PERIOD = 0.01


def test_a_cycle_that_starts_late_is_reported_with_its_delay():
    late, ended = [], []
    slept = []

    def cycle() -> None:
        if not slept:
            slept.append(True)
            time.sleep(3 * PERIOD)

    works = RealTime(cycle, PERIOD, ended.append, late.append)
    works.start()
    assert works.wait(lambda: bool(late), 10)
    works.close()
    # It is late by what it slept less one period, at least; a loaded machine adds to that.
    assert late[0] > PERIOD > OVERRUN_SHARE * PERIOD
    assert ended == ["the driver was closed"]


def test_what_ends_the_thread_is_told(monkeypatch):
    monkeypatch.setattr(threading, "excepthook", lambda told: None)
    ended = []

    def cycle() -> None:
        raise ValueError("3 drives")

    works = RealTime(cycle, PERIOD, ended.append, lambda late: None)
    works.start()
    assert works.wait(lambda: bool(ended), 10)
    works.close()
    assert ended == ["the cyclic thread died: ValueError: 3 drives"]
