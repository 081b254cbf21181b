"""The names of the robots that ship with the package, found without reading any of them."""

from __future__ import annotations

from importlib import resources
from importlib.resources.abc import Traversable

ROBOTS = "cdpr_interval.robots"
"""The package whose ``library`` holds the robots that ship, and in ``library/delta`` the Deltas."""
SUFFIXES = (".yaml", ".yml", ".json")
"""Of robot files."""


def shipped_robots() -> tuple[str, ...]:
    """Return the names of the robots with cables that ship, in alphabetical order."""
    return tuple(sorted(_names(_library())))


def shipped_machines() -> tuple[str, ...]:
    """Return the names of all robots that ship, with cables and without, in alphabetical order."""
    return tuple(sorted([*_names(_library()), *_names(_library().joinpath("delta"))]))


def file_of(name: str) -> Traversable:
    """Return the file of a robot that ships."""
    folder = _library() if name in shipped_robots() else _library().joinpath("delta")
    return folder.joinpath(f"{name}.yaml")


def _library() -> Traversable:
    return resources.files(ROBOTS).joinpath("library")


def _names(folder: Traversable) -> list[str]:
    return [file.name.removesuffix(".yaml") for file in folder.iterdir() if file.name.endswith(".yaml")]
