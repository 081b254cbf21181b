"""The names of the robots that ship with the package, found without reading any of them."""

from __future__ import annotations

from importlib import resources

ROBOTS = "cdpr_interval.robots"
"""The package whose ``library`` holds the robots that ship."""
SUFFIXES = (".yaml", ".yml", ".json")
"""Of robot files."""


def shipped_robots() -> tuple[str, ...]:
    """Return the names of the robots that ship with the package, in alphabetical order."""
    files = resources.files(ROBOTS).joinpath("library").iterdir()
    return tuple(sorted(file.name.removesuffix(".yaml") for file in files if file.name.endswith(".yaml")))
