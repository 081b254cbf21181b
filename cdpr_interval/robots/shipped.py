"""The names of the robots that ship with the package, found without reading any of them."""

from __future__ import annotations

from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable

ROBOTS = "cdpr_interval.robots"
"""The package whose ``library`` holds the robots that ship, and in ``library/delta`` the Deltas."""
SUFFIXES = (".yaml", ".yml", ".json")
"""Of robot files."""


def shipped_robots() -> tuple[str, ...]:
    """Return the names of the robots that ship with the package, in alphabetical order."""
    return tuple(sorted(_files()))


def file_of(name: str) -> Traversable:
    """Return the file of a robot that ships."""
    return _files()[name]


@cache
def _files() -> dict[str, Traversable]:
    library = resources.files(ROBOTS).joinpath("library")
    files = [*library.iterdir(), *library.joinpath("delta").iterdir()]
    return {file.name.removesuffix(".yaml"): file for file in files if file.name.endswith(".yaml")}
