"""Whether numba compiles: its cache was empty or out of date, and a user waits longer than usual."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def listening(tell: Callable[[], None]) -> Iterator[None]:
    """Call ``tell`` whenever a kernel starts to be compiled; loading one from the cache does not count.

    Parameters
    ----------
    tell : callable
        Called from the thread that compiles, also for kernels that are compiled for another one.
    """
    from numba.core import event

    class Compilation(event.Listener):  # type: ignore[misc]
        def on_start(self, event: object) -> None:
            tell()

        def on_end(self, event: object) -> None:
            pass

    with event.install_listener("numba:compile", Compilation()):
        yield
