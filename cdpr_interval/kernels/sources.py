"""The sources that compiled kernels are made of, and one digest of them.

A compiled kernel holds more than its own file: the kernels it calls, also those of other files, and the
constants of every module it reads them from. Those files are found by their imports, from every file that
declares kernels on; a change in one of them changes the digest, a change elsewhere (a command, a reader, a
report) does not. Whatever was compiled and is kept from one run to the next (numba's cache, see
`kernels/cache.py`) is kept under this digest.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from functools import cache
from hashlib import sha256
from pathlib import Path

ROOT = Path(__file__).parents[2]
"""The folder the packages lie in."""

PACKAGES = (
    "cdpr_interval.kernels",
    "cdpr_interval.exact",
    "cdpr_interval.engine",
    "cdpr_interval.mechanics",
    "solvers.point_mass",
    "solvers.six_dof",
)
"""Packages with kernels, and those that kernels have constants from."""

_DECLARES = re.compile(rb"\n *(?:from|import) (?:numba|cdpr_interval\.kernels\.kernel)\b")
_IMPORT = re.compile(rb"\n *(?:from|import) ((?:cdpr_interval|solvers)[\w.]*)(?: import (\([^)]*\)|[^\n]*))?")
_NAME = re.compile(rb"\w+")


def compiled_sources() -> list[Path]:
    """Return every file of the packages that defines a kernel or that one of those imports, however far.

    Imports of types and those inside functions count too: rather a file too many than one too few.
    """
    files = dict(_modules())
    texts = {name: b"\n" + path.read_bytes() for name, path in files.items()}
    found: set[str] = set()
    left = [name for name, text in texts.items() if _DECLARES.search(text)]
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left += [other for other in _imported(texts[name]) if other in files]
    return sorted(files[name] for name in found)


@cache
def digest() -> str:
    """Return 16 hexadecimal digits that name the sources as they were when this was first asked.

    Guarantee
    ---------
    Two processes with the same digest compile each kernel from the same text, on whatever path it lies: the
    digest is of names and contents, not of times. It says nothing of numba, Python and the processor.
    """
    seen = sha256()
    for path in _stamps():
        text = path.read_bytes()
        seen.update(f"{path.relative_to(ROOT).as_posix()} {len(text)}\n".encode())
        seen.update(text)
    return seen.hexdigest()[:16]


def are_as_digested() -> bool:
    """Return whether the files are still those of the digest: somebody may edit them while a process runs."""
    digest()
    return all(_stamp(path) == stamp for path, stamp in _stamps().items())


@cache
def _stamps() -> dict[Path, tuple[int, int] | None]:
    """Return the files of the digest with what tells cheaply that one has changed."""
    return {path: _stamp(path) for path in compiled_sources()}


def _stamp(path: Path) -> tuple[int, int] | None:
    """Return time and size of a file, None when it is gone."""
    try:
        status = os.stat(path)
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


def _modules() -> Iterator[tuple[str, Path]]:
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
