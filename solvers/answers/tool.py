"""The name and version that this program writes into its files."""

from __future__ import annotations

from functools import cache

from cdpr_interval.version import PACKAGE, version
from solvers.answers.data import Tool


@cache
def this_tool() -> Tool:
    """Return the name and the version of this package, made once a process."""
    return Tool(PACKAGE, version())
