"""numba's cache on disk: a folder for each file and state of what it imports, and one process at a time.

numba compiles a cached kernel again when *its own* file has changed. It does not see a change in a file
whose kernels the kernel calls or whose constants it reads, and would go on to serve the old code. So the
kernels of a file lie in a folder `cdpr-FILE-DIGEST`, under the digest of that file and all it imports
(`kernels/sources.py`), within the folder that numba chooses: `__pycache__` beside the source,
`NUMBA_CACHE_DIR`, or the user's own where the package cannot be written. What may be made of any file of ours
lies in `cdpr-all-DIGEST`, under the digest of them all: kernels of others that are declared after ours, for
they may call ours, and those defined inside a function, for they may call what that was given. Where an
argument is of a class that the kernel's file does not import, the digest of that one's file is in the key.

A folder, and not the digest in numba's stamp of the index: numba writes the index before the data file it
names, and a process that dies between the two would leave the data of an older state under the new stamp.

numba replaces each file of its cache at once, but a kernel that is saved takes two: the index, which names a
data file for each signature, and that data file. Two processes that compile different signatures of one
kernel (the workers of a batch on a new machine) can both choose the same data file, and later runs load the
machine code of one signature for the other. A lock on the folder keeps index and data together. The system
frees it when its process dies. It is held for moments; where somebody holds it for long (a stopped process, a
file system whose locks outlive a machine) this process says so and leaves that folder alone: it compiles what
it needs, and saves nothing there.
"""

from __future__ import annotations

import atexit
import logging
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any

from filelock import FileLock, Timeout
from numba.core import caching, config

from cdpr_interval.kernels import sources
from cdpr_interval.kernels.announcement import LOGGER

LOCK = "cdpr.lock"
"""Name of the file in a folder that is locked."""
PREFIX = "cdpr-"
"""What the names of the folders start with; a name and the digest follow."""
ANY = "all"
"""Stands for the name where a kernel may be made of every file."""
PATIENCE = 60.0
"""s that a lock is waited for: it is held while a file is read or written."""
TEMPORARY = "cdpr-kernels-"
"""What the name of a temporary folder starts with."""
KEPT = 3
"""Folders kept of each file, the last used ones, some 25 MB for all files: these sources, and two states of
them that somebody may go back to (another branch, a change taken back) without two minutes of compilation."""

_MODULE = re.compile(rb"(?:cdpr_interval|solvers)[\w.]*")


class Held(Exception):
    """Somebody else holds the lock of a folder, and does not give it back."""


_given_up: set[str] = set()
"""Folders whose lock was waited for in vain."""


@contextmanager
def locked(folder: str) -> Iterator[None]:
    """Hold the lock of a folder that exists; where there is none, or no locks, go on without.

    Raises
    ------
    Held
        Another process has it, for longer than `PATIENCE`; from then on at once.
    """
    if folder in _given_up:
        raise Held(folder)
    lock = FileLock(os.path.join(folder, LOCK))
    try:
        if os.path.isdir(folder):
            lock.acquire(timeout=PATIENCE)
    except Timeout:
        _given_up.add(folder)
        logging.getLogger(LOGGER).warning(
            f"compiled kernels are not used and not kept: another process has held {lock.lock_file} for"
            f" {PATIENCE:g} s"
        )
        raise Held(folder) from None
    except (OSError, NotImplementedError):
        pass
    try:
        yield
    finally:
        lock.release()


@cache
def mark_used(place: str) -> None:
    """Make a folder the last used one, if it is there."""
    with suppress(OSError):
        os.utime(place)


def make_room(folder: str, new: str) -> None:
    """Remove the folders of a file that were not used for longest, so that with a new one `KEPT` stay.

    A process that still works with a removed folder finds nothing in it, compiles, and makes it again.
    """
    kind = new.rpartition("-")[0]
    with suppress(OSError):
        found = [place for place in os.scandir(folder) if place.name.rpartition("-")[0] == kind]
        found.sort(key=lambda place: place.stat().st_mtime_ns, reverse=True)
        for place in found[KEPT - 1 :]:
            shutil.rmtree(place.path, ignore_errors=True)


@cache
def _places() -> dict[tuple[str, str], str]:
    """Return our modules by a folder that numba may choose for their kernels, and the stem of their file."""
    found = {}
    for module, source in sources.modules().items():
        folder = os.path.abspath(source.path.parent)
        elsewhere = caching._CacheLocator.get_suitable_cache_subpath(str(source.path))
        for place in (os.path.join(folder, "__pycache__"), elsewhere):
            found[place, source.path.stem] = module
    return found


def _module_in(path: str) -> str | None:
    """Return the name of our module with this source, None when it is not one of ours."""
    whole = os.path.abspath(path)
    return next((name for name, source in sources.modules().items() if str(source.path) == whole), None)


def module_of(cache_path: str, filename_base: str) -> str | None:
    """Return the module whose digest a kernel is kept under, by numba's names for its folder and its files.

    Files are named by the stem of the source and the qualified name of the function, first of all. None where
    the kernel may be made of any source: it is not of our files, or defined inside a function.
    """
    stem, _, function = filename_base.partition(".")
    if ".locals." in function:
        return None
    beside = os.path.abspath(cache_path)
    return _places().get((beside, stem)) or _places().get((os.path.basename(beside), stem))


class KeyedCacheFile(caching.IndexDataCacheFile):  # type: ignore[misc]
    """Index and data files of one kernel, of these sources only, read and written while nobody else does."""

    def __init__(self, cache_path: str, filename_base: str, source_stamp: Any) -> None:
        self._module = module_of(cache_path, filename_base)
        name = ANY if self._module is None else filename_base.partition(".")[0]
        own = f"{PREFIX}{name}-{sources.digest(self._module)}"
        super().__init__(os.path.join(cache_path, own), filename_base, source_stamp)
        self._shared_path = cache_path
        mark_used(self._cache_path)

    def flush(self) -> None:
        """Forget the code of every signature."""
        with suppress(Held), self._alone():
            super().flush()

    def save(self, key: Any, data: Any) -> None:
        """Save the code of one signature, unless a source was edited since: it may be made of either text."""
        others = self._strangers(key)
        if all(sources.are_as_digested(module) for module in (self._module, *others)):
            if os.path.basename(folder := os.path.dirname(self._shared_path)).startswith(TEMPORARY):
                tell_temporary(folder)
            # Into a folder that is filled and cannot be written nothing is saved.
            with suppress(PermissionError, Held), self._alone():
                super().save(self._keyed(key, others), data)

    def load(self, key: Any) -> Any:
        """Return the code of one signature, None when there is none."""
        with suppress(Held), locked(self._shared_path):
            return super().load(self._keyed(key, self._strangers(key)))
        return None

    def _strangers(self, key: Any) -> list[str]:
        """Return our modules that the pickle of a signature names and the digest of the folder leaves out.

        They have the classes of arguments, which the kernel's own file need not import.
        """
        named = {name.decode() for name in _MODULE.findall(self._dump(key))}
        return sorted(named & (sources.modules().keys() - sources.closure(self._module)))

    @staticmethod
    def _keyed(key: Any, others: list[str]) -> Any:
        """Return the key of a signature with the digests of the modules that its classes are from."""
        return (key, *map(sources.digest, others)) if others else key

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Hold the lock while the folder is there; without locks another process may remove it meanwhile."""
        with locked(self._shared_path), suppress(FileNotFoundError):
            if not os.path.isdir(self._cache_path):
                make_room(self._shared_path, os.path.basename(self._cache_path))
                os.makedirs(self._cache_path, exist_ok=True)
            yield


@cache
def temporary_folder() -> str:
    """Make a folder for the kernels of this process, which goes with it."""
    folder = tempfile.mkdtemp(prefix=TEMPORARY)
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@cache
def tell_temporary(folder: str) -> None:
    """Say that kernels are compiled that the next process will compile again."""
    logging.getLogger(LOGGER).warning(
        "compiled kernels cannot be kept: NUMBA_CACHE_DIR, the package's folder and the home folder cannot"
        f" be written; they lie in {folder} until this process ends"
    )


class FilledLocator(caching._SourceFileBackedLocatorMixin, caching._CacheLocator):  # type: ignore[misc]
    """A folder with kernels that cannot be written, as in a container: what is there is used."""

    def __init__(self, py_file: str, line: int, folder: str) -> None:
        self._py_file, self._lineno, self._folder = py_file, line, folder

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> FilledLocator | None:
        """Return the first of the folders that numba looks at in which a kernel of the file lies."""
        stem = os.path.splitext(os.path.basename(py_file))[0]
        elsewhere = cls.get_suitable_cache_subpath(py_file)
        given = [os.path.join(config.CACHE_DIR, elsewhere)] if config.CACHE_DIR else []
        for folder in (*given, os.path.join(os.path.dirname(py_file), "__pycache__")):
            if os.path.isdir(os.path.join(folder, f"{PREFIX}{stem}-{sources.digest(_module_in(py_file))}")):
                return cls(py_file, py_func.__code__.co_firstlineno, folder)
        return None

    def get_cache_path(self) -> str:
        """Return the folder."""
        return self._folder


class TemporaryLocator(FilledLocator):
    """Where kernels lie when nothing that outlives the process can be written; numba alone gives up."""

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> TemporaryLocator:
        """Return a folder of this process."""
        folder = os.path.join(temporary_folder(), cls.get_suitable_cache_subpath(py_file))
        os.makedirs(folder, exist_ok=True)
        return cls(py_file, py_func.__code__.co_firstlineno, folder)


def install() -> None:
    """Let numba use it for every kernel that is declared from now on."""
    caching.IndexDataCacheFile = KeyedCacheFile
    # The list of the class that numba has made for every kind of cache.
    caching.CompileResultCacheImpl._locator_classes.extend((FilledLocator, TemporaryLocator))
