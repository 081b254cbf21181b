"""numba's cache, when several processes write it."""

from __future__ import annotations

import re
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from numba.core import caching

from cdpr_interval.kernels import rounding
from cdpr_interval.kernels.cache import LockedCacheFile, locked

ROOT = Path(__file__).resolve().parents[2]
PLAIN = LockedCacheFile.__bases__[0]


def test_every_file_with_cached_kernels_brings_the_lock():
    """Also when nothing else was imported before it."""
    folders = [ROOT / "solvers", *(ROOT / "cdpr_interval" / name for name in ("engine", "mechanics"))]
    files = [path for folder in folders for path in folder.rglob("*.py")]
    cached = [path for path in files if "cache=True" in path.read_text()]
    brings = re.compile(r"^(from|import) cdpr_interval\.kernels\b", re.MULTILINE)
    assert cached
    assert [path.name for path in cached if not brings.search(path.read_text())] == []


def test_a_kernel_uses_the_lock():
    assert isinstance(rounding.down._cache._cache_file, LockedCacheFile)
    assert caching.IndexDataCacheFile is LockedCacheFile


def overlapping(kind: Any, folder: Path) -> list[Any]:
    """Save two signatures, the second as soon as the first has chosen its place; return what is loaded."""
    started = threading.Event()

    class Slow(kind):
        def _save_index(self, overloads: dict[str, str]) -> None:
            started.set()
            time.sleep(0.2)
            super()._save_index(overloads)

    first, second = Slow(str(folder), "kernel", "stamp"), kind(str(folder), "kernel", "stamp")
    thread = threading.Thread(target=first.save, args=("first", 1))
    thread.start()
    assert started.wait(10)
    second.save("second", 2)
    thread.join()
    return [second.load("first"), second.load("second")]


@pytest.mark.skipif(sys.platform == "win32", reason="no folder locks")
def test_two_signatures_saved_at_once_are_both_kept(tmp_path):
    assert overlapping(LockedCacheFile, tmp_path) == [1, 2]


def test_without_the_lock_numba_mixes_them_up(tmp_path):
    """When this fails, numba has become safe itself and `kernels/cache.py` can go."""
    assert overlapping(PLAIN, tmp_path) != [1, 2]


def test_a_folder_that_is_not_there_is_no_error(tmp_path):
    with locked(str(tmp_path / "none")):
        pass
    assert LockedCacheFile(str(tmp_path / "none"), "kernel", "stamp").load("first") is None
