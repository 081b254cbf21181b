"""What a report is about: a result with its robot, or a batch."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cdpr_interval.errors import InputError
from cdpr_interval.files.literal import printable, quote
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.reader import load_robot
from cdpr_interval.robots.shipped import shipped_robots
from solvers.answers.result import Result
from solvers.batch.campaign import result_of, robot_of
from solvers.batch.ledger import Ledger
from solvers.proofs.check import Proof, proof_of

LARGEST_RESULT = 200_000_000
"""Bytes."""
CHECK_SECONDS = 600.0
"""A certificate that takes longer is said to be out of time."""


@dataclass(frozen=True)
class ResultSource:
    """A result and the robot it is about."""

    robot: Robot
    result: Result
    proof: Proof | None
    """What is known by its certificate; None: it has none."""


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
    if certificate is None:
        return ResultSource(found, result, None)
    try:
        content = Path(certificate).read_bytes()
    except OSError as error:
        raise InputError(f"--certificate: {printable(certificate)}: {error.strerror}") from None
    return ResultSource(found, result, proof_of(found, result, content, CHECK_SECONDS))


def result_in_batch(folder: Path, number: int) -> ResultSource:
    """Read one job of a batch; its certificate is checked, when the ledger has it.

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
    proof = None if content is None else proof_of(robot, result, content, CHECK_SECONDS)
    return ResultSource(robot, result, proof)


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
