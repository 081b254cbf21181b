"""The time a check may take: whatever may take long asks now and then whether it is over."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

END: ContextVar[float] = ContextVar("END", default=math.inf)
"""When the time is over, as `time.monotonic` counts."""


class OutOfTime(Exception):
    """The time limit has passed: nothing is proved, and nothing refused."""


@contextmanager
def seconds(limit: float | None) -> Iterator[None]:
    """Give what is done inside so many seconds; None: all the time it takes."""
    token = END.set(math.inf if limit is None else time.monotonic() + limit)
    try:
        yield
    finally:
        END.reset(token)


def in_time() -> None:
    """Raise OutOfTime after the end of the time."""
    if time.monotonic() > END.get():
        raise OutOfTime


def left() -> float | None:
    """Return how many seconds are left; None: all the time it takes."""
    end = END.get()
    return None if end == math.inf else end - time.monotonic()
