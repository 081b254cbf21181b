"""numba's cache on disk: one folder for each digest of the sources, and one process at a time.

numba compiles a cached kernel again when *its own* file has changed. It does not see a change in a file
whose kernels the kernel calls or whose constants it reads, and would go on to serve the old code. So the
kernels lie in a folder under the digest of all their sources (`kernels/sources.py`), within the folder that
numba chooses: `__pycache__` beside the source, `NUMBA_CACHE_DIR`, or the user's own where the package cannot
be written. Kernels of others that are declared after ours lie there too, for they may call ours.

numba replaces each file of its cache at once, but a kernel that is saved takes two: the index, which names a
data file for each signature, and that data file. Two processes that compile different signatures of one
kernel (the workers of a batch on a new machine) can both choose the same data file, and later runs load the
machine code of one signature for the other. A lock on the folder keeps index and data together.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any

from numba.core import caching

from cdpr_interval.kernels import sources

try:
    import fcntl
except ImportError:  # not on Windows: as numba has it
    fcntl = None  # type: ignore[assignment]

PREFIX = "cdpr-"
"""What the names of the folders start with; the digest follows."""
KEPT = 3
"""Folders kept, the last used ones, each of some 25 MB in all packages: these sources, and two states of them
that somebody may go back to (another branch, a change taken back) without two minutes of compilation."""


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


@cache
def use(folder: str, own: str) -> None:
    """Make the folder of a digest the last used one, and remove those that were not used for longest.

    A process that still works with a removed folder finds nothing in it, compiles, and makes it again.
    """
    with suppress(OSError):
        os.utime(os.path.join(folder, own))
    with locked(folder), suppress(OSError):
        found = [place for place in os.scandir(folder) if place.name.startswith(PREFIX) and place.name != own]
        found.sort(key=lambda place: place.stat().st_mtime_ns, reverse=True)
        for place in found[KEPT - 1 :]:
            shutil.rmtree(place.path, ignore_errors=True)


class KeyedCacheFile(caching.IndexDataCacheFile):  # type: ignore[misc]
    """Index and data files of one kernel, of these sources only, read and written while nobody else does."""

    def __init__(self, cache_path: str, filename_base: str, source_stamp: Any) -> None:
        own = PREFIX + sources.digest()
        super().__init__(os.path.join(cache_path, own), filename_base, source_stamp)
        self._shared_path = cache_path
        use(cache_path, own)

    def flush(self) -> None:
        """Forget the code of every signature."""
        with self._alone():
            super().flush()

    def save(self, key: Any, data: Any) -> None:
        """Save the code of one signature, unless a source was edited since: it may be made of either text."""
        if sources.are_as_digested():
            with self._alone():
                super().save(key, data)

    def load(self, key: Any) -> Any:
        """Return the code of one signature, None when there is none."""
        with locked(self._shared_path):
            return super().load(key)

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Hold the lock while the folder is there; without locks another process may remove it meanwhile."""
        with locked(self._shared_path), suppress(FileNotFoundError):
            os.makedirs(self._cache_path, exist_ok=True)
            yield


def install() -> None:
    """Let numba use it for every kernel that is declared from now on."""
    caching.IndexDataCacheFile = KeyedCacheFile
