"""What a report is about: a result with its robot, or a batch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cdpr_interval.errors import InputError
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.reader import load_robot
from cdpr_interval.robots.shipped import shipped_robots
from cdpr_interval.text.literal import printable, quote
from solvers.answers.result import Result
from solvers.batch.campaign import result_of, robot_of
from solvers.batch.ledger import Ledger
from solvers.proofs.check import Proof, proof_of

LARGEST_RESULT = 200_000_000
"""Bytes."""
CHECK_SECONDS = 600.0
"""A certificate that takes longer is said to be out of time, unless another limit is given."""
Told = Callable[[int, int], None]
"""Takes the numbers of cells of a certificate that are checked and to be checked."""


@dataclass(frozen=True)
class ResultSource:
    """A result and the robot it is about."""

    robot: Robot
    result: Result
    proof: Proof | None
    """What is known by its certificate; None: it has none."""


def read_result(
    path: Path,
    robot: str | None,
    certificate: str | None,
    time_limit: float | None = CHECK_SECONDS,
    progress: Told | None = None,
    threads: int = 1,
) -> ResultSource:
    """Read a ``cdpr-result/1`` file, find its robot, and check its certificate.

    Parameters
    ----------
    path : Path
    robot : str, optional
        File or shipped name; the default is the robot in the result, or for a result without one the shipped
        robot whose file it names by digest.
    certificate : str, optional
        A certificate file; it is checked.
    time_limit : float
        s for the check.
    progress : callable, optional
        Told how far the check is.
    threads : int
        Processes of the check.

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
    if certificate is None:
        return ResultSource(found, result, None)
    try:
        content = Path(certificate).read_bytes()
    except OSError as error:
        raise InputError(f"--certificate: {printable(certificate)}: {error.strerror}") from None
    return ResultSource(found, result, proof_of(found, result, content, time_limit, progress, threads))


def result_in_batch(
    folder: Path,
    number: int,
    time_limit: float | None = CHECK_SECONDS,
    progress: Told | None = None,
    threads: int = 1,
) -> ResultSource:
    """Read one job of a batch; its certificate is checked, when the ledger has it; see `read_result`.

    Raises
    ------
    InputError
        There is no such job, or it has no result.
    LedgerError
        The ledger cannot be read.
    """
    with Ledger.peek(folder) as ledger:
        result = Result.from_json(result_of(ledger, number))
        robot, content = robot_of(ledger, number), ledger.certificate(number)
    proof = None
    if content is not None:
        proof = proof_of(robot, result, content, time_limit, progress, threads)
    return ResultSource(robot, result, proof)


def _robot(result: Result, source: str | None) -> Robot:
    wanted = result.robot.sha256
    if source is None and result.provenance is not None:
        robot = result.source_robot
        if robot.sha256 != wanted:
            raise InputError("the result holds another robot than the one that it names (its digest differs)")
        return robot
    if source is None:
        for name in shipped_robots():
            robot = load_robot(name)
            if robot.sha256 == wanted:
                return robot
        raise InputError(f"--robot: missing (no shipped robot is {quote(result.robot.name)} of the result)")
    robot = load_robot(source)
    require_same(result, robot, "--robot")
    return robot


def require_same(result: Result, robot: Robot, label: str) -> None:
    """Raise `InputError` for another robot than the one of a result."""
    if robot.cable_names != result.cables:
        raise InputError(
            f"{label}: has cables {', '.join(robot.cable_names)}, the result {', '.join(result.cables)}"
        )
    if not result.is_about(robot):
        raise InputError(f"{label}: is not the robot of the result: its data differ")
