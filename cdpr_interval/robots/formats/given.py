"""The robot a caller gives: itself, its file, or the name of one that ships."""

from __future__ import annotations

import os
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.robots.cable_robot import Robot


def require_robot(given: Any) -> Robot:
    """Return a robot as it is, and that of a file or of a name.

    Raises
    ------
    InputError
        It is none of these, or the file has errors: one line each.
    """
    if isinstance(given, Robot):
        return given
    if not isinstance(given, str | os.PathLike):
        raise InputError(
            f"robot: must be a robot, a file or the name of a robot that ships, got {type(given).__name__}"
        )
    from cdpr_interval.robots.formats.reader import load_robot

    return load_robot(given)
