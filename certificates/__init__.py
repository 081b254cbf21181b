"""Certificates of completeness and their independent checker.

This package imports the standard library, numpy, python-flint and itself, nothing else: it shares no
code with the programs whose results it checks.
"""

from __future__ import annotations

from typing import Any

__all__ = ["check"]


def __getattr__(name: str) -> Any:
    """Import `check` on first use: numpy and python-flint take a while to load."""
    if name != "check":
        raise AttributeError(name)
    from certificates.checker import check

    return check
