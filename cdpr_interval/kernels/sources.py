"""The sources that compiled kernels are made of, and digests of them.

A compiled kernel holds more than its own file: the kernels it calls, also those of other files, and the
constants of every module it reads them from. Those files are found by their imports, from the kernel's file
on; a change in one of them changes the digest of that file's kernels, a change elsewhere does not. numba's
cache (see `kernels/cache.py`) keeps the kernels of each file under its digest.

One digest more is of every file that declares kernels and all that those import: for what is made of any of
them. A change of a command, a reader or a report changes none of the digests.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
"""The folder the packages lie in."""

PACKAGES = (
    "cdpr_interval.kernels",
    "cdpr_interval.exact",
    "cdpr_interval.engine",
    "cdpr_interval.mechanics",
    "solvers.point_mass",
    "solvers.routed_mass",
    "solvers.six_dof",
)
"""Packages with kernels, and those that kernels have constants from."""

_DECLARES = re.compile(rb"\n *(?:from|import) (?:numba|cdpr_interval\.kernels\.kernel)\b")
_IMPORT = re.compile(rb"\n *(?:from|import) ((?:cdpr_interval|solvers)[\w.]*)(?: import (\([^)]*\)|[^\n]*))?")
_NAME = re.compile(rb"\w+")


class Source(NamedTuple):
    """The file of a module, as it was when it was read."""

    path: Path
    stamp: tuple[int, int] | None
    """What tells cheaply that the file has changed."""
    seal: bytes
    """SHA-256 of its name and contents."""
    declares: bool
    """Whether it may define a kernel."""
    imports: frozenset[str]
    """Names it may import modules by, ours among them."""


@cache
def modules() -> dict[str, Source]:
    """Return the modules of the packages, as they were when this was first asked."""
    return {name: _read(path) for name, path in _files()}


@cache
def closure(module: str | None = None) -> frozenset[str]:
    """Return the modules that the kernels of one may be made of: itself and all it imports, however far.

    Imports of types and those inside functions count too: rather a module too many than one too few. Without
    a module these are all that any kernel may be made of.
    """
    known = modules()
    found: set[str] = set()
    left = [name for name, source in known.items() if source.declares] if module is None else [module]
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left += known[name].imports & known.keys()
    return frozenset(found)


@cache
def digest(module: str | None = None) -> str:
    """Return 16 hexadecimal digits that name the sources in the closure of a module, or all of any kernel.

    Guarantee
    ---------
    Two processes with the same digest compile each kernel of the module from the same text, on whatever path
    it lies: the digest is of names and contents, not of times. It says nothing of numba, Python and the
    processor, nor of the classes of a kernel's arguments, which its file need not import.
    """
    seen = sha256()
    for name in sorted(closure(module)):
        seen.update(modules()[name].seal)
    return seen.hexdigest()[:16]


def are_as_digested(module: str | None = None) -> bool:
    """Return whether the files are still those of the digest: somebody may edit them while a process runs."""
    sources = [modules()[name] for name in closure(module)]
    return all(_stamp(source.path) == source.stamp for source in sources)


def _read(path: Path) -> Source:
    """Return what is to be known of a file."""
    stamp = _stamp(path)
    text = path.read_bytes()
    lines = b"\n" + text
    return Source(
        path,
        stamp,
        sha256(f"{path.relative_to(ROOT).as_posix()} {len(text)}\n".encode() + text).digest(),
        _DECLARES.search(lines) is not None,
        frozenset(_imported(lines)),
    )


def _stamp(path: Path) -> tuple[int, int] | None:
    """Return time and size of a file, None when it is gone."""
    try:
        status = os.stat(path)
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


def _files() -> Iterator[tuple[str, Path]]:
    """Return the modules of the packages with their files."""
    for package in PACKAGES:
        top = os.path.join(ROOT, *package.split("."))
        for folder, _, names in os.walk(top):
            inner = os.path.relpath(folder, ROOT).replace(os.sep, ".")
            for name in names:
                module, suffix = os.path.splitext(name)
                if suffix == ".py":
                    yield inner if module == "__init__" else f"{inner}.{module}", Path(folder, name)


def _imported(text: bytes) -> Iterator[str]:
    """Return the names that a source may import modules by: what stands after `from` and after `import`."""
    for found in _IMPORT.finditer(text):
        module = found[1].decode()
        yield module
        for name in _NAME.findall(found[2] or b""):
            yield f"{module}.{name.decode()}"
