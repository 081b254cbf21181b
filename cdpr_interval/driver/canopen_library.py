"""The library canopen, an extra: loaded when a bus is used."""

from __future__ import annotations

from typing import Any

from cdpr_interval.errors import InputError


def canopen_library() -> Any:
    """Import canopen.

    Raises
    ------
    InputError
        It is not installed; the message says what to install.
    """
    try:
        import canopen
    except ImportError as error:
        raise InputError(f"{error.name} is not installed: pip install '.[driver]'") from None
    return canopen
