"""Certified statics of cable-driven parallel robots.

Importing this package imports nothing heavy; `load_robot` brings in what it needs.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from cdpr_interval.errors import CdprError, InputError, NotSupportedError

if TYPE_CHECKING:
    from cdpr_interval.robots.cable_robot import Robot

    __version__: str

__all__ = ["CdprError", "InputError", "NotSupportedError", "Robot", "load_robot"]


def load_robot(source: str | os.PathLike[str]) -> Robot:
    """Read a robot from a ``cdpr-robot/1`` file, or one that ships with the package.

    Parameters
    ----------
    source : str or PathLike
        A file (YAML or JSON), or the name of a shipped robot such as ``merlet_4_1``.

    Returns
    -------
    Robot
        Every number the exact rational of its decimal literal, SI units.

    Raises
    ------
    InputError
        With one line per error, ``FILE:LINE:COLUMN: path: rule``.

    Examples
    --------
    >>> robot = load_robot("merlet_4_1")
    >>> robot.cable_names, robot.platform.mass
    (('c1', 'c2', 'c3', 'c4'), Fraction(80, 1))
    """
    if not isinstance(source, str | os.PathLike):
        raise InputError(f"robot: must be a file or the name of a robot, got {type(source).__name__}")
    from cdpr_interval.robots.formats.reader import load_robot as load

    return load(source)


def __getattr__(name: str) -> Any:
    """Return `Robot`, or ``__version__``, looked up on first use."""
    if name == "Robot":
        from cdpr_interval.robots.cable_robot import Robot

        return Robot
    if name != "__version__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from cdpr_interval.version import version

    return version()
