"""The Delta a caller gives: itself, its file, or the name of one that ships."""

from __future__ import annotations

import os
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.robots.delta import DeltaRobot


def require_delta(given: Any) -> DeltaRobot:
    """Return a Delta as it is, and that of a file or of a name.

    Raises
    ------
    InputError
        It is none of these, or the file has errors: one line each.
    NotSupportedError
        It is a robot with cables.
    """
    if isinstance(given, DeltaRobot):
        return given
    if not isinstance(given, str | os.PathLike):
        raise InputError(
            f"robot: must be a Delta, a file or the name of one that ships, got {type(given).__name__}"
        )
    from cdpr_interval.robots.formats.reader import load_delta

    return load_delta(given)
