"""Where a result comes from: the question in exact numbers, when and where it was answered, and with what."""

from __future__ import annotations

import platform
import socket
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from typing import Annotated

from cdpr_interval.exact.range import LengthRange
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.numbers import Point
from cdpr_interval.version import PACKAGE, version
from solvers.answers.fields import Described, ExactRanges, ExactScalars, RobotData

ARITHMETIC = ("numba", "numpy", "python-flint")
"""Packages whose code the numbers of a result come from."""


@dataclass(frozen=True, eq=False)
class Provenance(Described):
    """Where a result comes from; two runs of one question differ in nothing else but their times."""

    date: datetime
    """UTC: when the answer was ready."""
    host: str
    """Name of the machine."""
    versions: dict[str, str]
    """Of this package, of Python, and of the packages whose arithmetic the numbers come from."""
    lengths: Annotated[tuple[LengthRange, ...], ExactRanges()]
    """The lengths that were solved, exactly, as ``--lengths`` takes them: 7.1 or 7.099..7.101 (p/q where no
    decimal is exact). Empty where tensions were given."""
    external_force: Annotated[Point, ExactScalars()]
    """The external force, exactly, as ``--external-force`` takes it: 5 or 4..6."""
    robot: Annotated[Robot, RobotData()]
    """The robot that was solved, exactly: the text of its file; of a robot made or changed in memory an
    object with the keys of cdpr-robot/1, numbers as texts."""

    def __str__(self) -> str:
        """Return when, where and with what, and the digest of the robot, in one line."""
        versions = ", ".join(f"{name} {version}" for name, version in self.versions.items())
        when = f"{self.date.astimezone(UTC):%Y-%m-%d %H:%M:%S} UTC"
        return f"{when} on {self.host}, {versions}, robot sha256 {self.robot.sha256}"


def provenance(robot: Robot, lengths: Sequence[LengthRange], external_force: Point) -> Provenance:
    """Return the provenance of an answer that is ready now."""
    now = datetime.fromtimestamp(int(time.time()), UTC)
    return Provenance(now, host(), dict(versions()), tuple(lengths), external_force, robot)


@cache
def host() -> str:
    """Return the name of the machine, asked once a process."""
    return socket.gethostname()


@cache
def versions() -> dict[str, str]:
    """Return the versions of what the numbers come from, read once a process."""
    from importlib.metadata import version as installed

    found = {PACKAGE: version(), "python": platform.python_version()}
    return found | {name: installed(name) for name in ARITHMETIC}
