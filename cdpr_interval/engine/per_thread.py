"""Scratch arrays that a thread makes once: the pages of fresh ones cost more than a small search."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cache
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


def per_thread(make: Callable[P, T]) -> Callable[P, T]:
    """Return a function that calls ``make`` once for the same arguments in each thread.

    What it returns lives as long as the thread and is shared by all that ask in it: nothing in it may be
    expected to last from one use to the next.
    """

    class Kept(threading.local):
        """Made anew in each thread that looks at it."""

        def __init__(self) -> None:
            self.made: Any = cache(make)

    kept = Kept()

    def own(*args: P.args, **kwargs: P.kwargs) -> T:
        made: T = kept.made(*args, **kwargs)
        return made

    return own
