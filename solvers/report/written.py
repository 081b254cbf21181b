"""Reports and figures of results in memory: what `Result.report` and `Result.plot` do."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.given import require_robot
from cdpr_interval.text.literal import printable
from solvers.answers.result import Result
from solvers.proofs.check import proof_of
from solvers.questions.arguments import read_path
from solvers.report.page import result_page
from solvers.report.plots import require_plotly, robot_figure
from solvers.report.source import CHECK_SECONDS, ResultSource, require_same


def result_figure(result: Result, robot: Robot | None = None) -> Any:
    """Return the robot in 3-D with every solution of a result; see `Result.plot`."""
    require_plotly()
    return robot_figure(_robot(result, robot), result)


def write_report(
    result: Result,
    path: str | os.PathLike[str],
    certificate: str | os.PathLike[str] | None = None,
    robot: Robot | None = None,
) -> Path:
    """Write the report of a result; see `Result.report`."""
    require_plotly()
    target, found = read_path(path, "path"), _robot(result, robot)
    proof = None
    if certificate is not None:
        content = _content(read_path(certificate, "certificate"))
        proof = proof_of(found, result, content, CHECK_SECONDS)
    try:
        target.write_text(result_page(ResultSource(found, result, proof)), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{printable(str(target))}: cannot be written: {error.strerror}") from None
    return target


def _robot(result: Result, robot: Robot | None) -> Robot:
    """Return the robot of a result, or the one given, which must be the same."""
    if robot is None:
        return result.source_robot
    found = require_robot(robot)
    require_same(result, found, "robot")
    return found


def _content(certificate: Path) -> bytes:
    try:
        return certificate.read_bytes()
    except OSError as error:
        raise InputError(f"certificate: {printable(str(certificate))}: {error.strerror}") from None
