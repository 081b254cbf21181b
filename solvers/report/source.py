"""What a report is about: a result with its robot, or a batch."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cdpr_interval.errors import InputError
from cdpr_interval.robots.literal import printable, quote
from cdpr_interval.robots.model import Robot
from cdpr_interval.robots.reader import load_robot, shipped_robots
from solvers.result import Result

LARGEST_RESULT = 200_000_000
"""Bytes."""
CHECK_SECONDS = 600.0
"""A certificate that takes longer is said to be out of time."""


@dataclass(frozen=True)
class ResultSource:
    """A result and the robot it is about."""

    robot: Robot
    result: Result
    certificate: str
    """What is known of a certificate: one sentence."""


def read_result(path: Path, robot: str | None, certificate: str | None) -> ResultSource:
    """Read a ``cdpr-result/1`` file, find its robot, and check its certificate.

    Parameters
    ----------
    path : Path
    robot : str, optional
        File or shipped name; the default is the shipped robot whose file the result names by digest.
    certificate : str, optional
        A certificate file; it is checked.

    Raises
    ------
    InputError
        The file is no result, or the robot is another one.
    """
    try:
        if path.stat().st_size > LARGEST_RESULT:
            raise InputError(f"{printable(str(path))}: larger than {LARGEST_RESULT} bytes")
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{printable(str(path))}: cannot be read: {reason}") from None
    result = Result.from_json(text)
    found = _robot(result, robot)
    return ResultSource(
        found, result, "no certificate was given" if certificate is None else _checked(certificate)
    )


def _robot(result: Result, source: str | None) -> Robot:
    wanted = result.robot.sha256
    if source is None:
        for name in shipped_robots():
            robot = load_robot(name)
            if robot.sha256 == wanted:
                return robot
        raise InputError(f"--robot: missing (no shipped robot is {quote(result.robot.name)} of the result)")
    robot = load_robot(source)
    if robot.cable_names != result.cables:
        raise InputError(
            f"--robot: has cables {', '.join(robot.cable_names)}, the result {', '.join(result.cables)}"
        )
    if wanted and robot.sha256 != wanted:
        raise InputError("--robot: is not the file of the result (its SHA-256 differs)")
    return robot


def _checked(path: str) -> str:
    """Return what the independent checker says of a certificate."""
    from certificates import check

    return f"{Path(path).name}: {check(path, time_limit=CHECK_SECONDS).lines()[0]}"
