"""Scratch arrays that a thread makes once: the pages of fresh ones cost more than a small search."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


def per_thread(make: Callable[P, T]) -> Callable[P, T]:
    """Return a function that calls ``make`` once for the same positional arguments in each thread.

    What it returns lives as long as the thread and is shared by all that ask in it: nothing in it may be
    expected to last from one use to the next.
    """
    kept = threading.local()

    def own(*args: P.args, **kwargs: P.kwargs) -> T:
        try:
            made: dict[tuple[object, ...], T] = kept.made
        except AttributeError:
            made = kept.made = {}
        found = made.get(args)
        if found is None:
            found = made[args] = make(*args, **kwargs)
        return found

    return own
