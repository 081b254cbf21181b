"""numba's cache on disk, one process at a time.

numba replaces each file of its cache at once, but a kernel that is saved takes two: the index, which names a
data file for each signature, and that data file. Two processes that compile different signatures of one
kernel (the workers of a batch on a new machine) can both choose the same data file, and later runs load the
machine code of one signature for the other. A lock on the folder keeps index and data together.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from numba.core import caching

try:
    import fcntl
except ImportError:  # not on Windows: as numba has it
    fcntl = None  # type: ignore[assignment]


@contextmanager
def locked(folder: str) -> Iterator[None]:
    """Hold the lock of a folder that exists; where there is none, or no locks, go on without."""
    place = None
    with suppress(OSError):
        place = os.open(folder, os.O_RDONLY) if fcntl is not None else None
    try:
        if place is not None:
            with suppress(OSError):
                fcntl.flock(place, fcntl.LOCK_EX)
        yield
    finally:
        if place is not None:
            os.close(place)


class LockedCacheFile(caching.IndexDataCacheFile):  # type: ignore[misc]
    """Index and data files of one kernel, read and written while nobody else does."""

    def save(self, key: Any, data: Any) -> None:
        """Save the code of one signature."""
        with locked(self._cache_path):
            super().save(key, data)

    def load(self, key: Any) -> Any:
        """Return the code of one signature, None when there is none."""
        with locked(self._cache_path):
            return super().load(key)


def install() -> None:
    """Let numba use it for every kernel that is declared from now on."""
    caching.IndexDataCacheFile = LockedCacheFile
