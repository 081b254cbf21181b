"""All poses of a Delta for given drives, in closed form and enclosed."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
from flint import arb

from cdpr_interval.errors import InputError
from cdpr_interval.exact import balls
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.delta import Delta, Vector, delta_of, elbow, lean, meeting, narrowed, radians
from cdpr_interval.robots.delta import LIMITS, DeltaRobot
from solvers.answers.data import Outcome, RobotIdentity
from solvers.answers.tool import this_tool
from solvers.delta.data import DeltaPose, DeltaQuestion, origin_of
from solvers.delta.given import require_delta
from solvers.delta.result import DeltaResult
from solvers.questions.angles import read_angle, read_triple
from solvers.questions.ranges import read_range
from solvers.questions.units import METRES


def delta_poses(
    robot: DeltaRobot | str | os.PathLike[str], angles: Any = None, positions: Any = None
) -> DeltaResult:
    """Return all poses of a Delta for given drives: two, or none.

    Parameters
    ----------
    robot : DeltaRobot, str or PathLike
        Itself, its file, or the name of a shipped one.
    angles : str or sequence of 3, optional
        Of the arms: ``"30deg,30deg,30deg"``, each also a range (``30deg+-0.1deg``); numbers are in rad.
    positions : str or sequence of 3, optional
        Of carriages, instead of angles: m, also ranges.

    Returns
    -------
    DeltaResult
        The lower pose first. Where the answer is not proved, its outcome is incomplete and says why.

    Raises
    ------
    InputError
        With one message per error.

    Guarantee
    ---------
    With outcome COMPLETE these are all poses, for every choice of angles and data in their ranges.

    Source: EPFL, *Les robots paralleles*, 1.3 (direct model), without its division by H_2.

    Examples
    --------
    >>> result = delta_poses("delta_580", "10deg, 20deg, 30deg")
    >>> result
    <DeltaResult delta-580: two poses, and no other one>
    >>> [round(float(x.mean()), 6) for x in result.solutions[0].position]
    [0.033955, 0.020772, -0.281754]
    """
    return answer_drives(require_delta(robot), angles, positions)


def answer_drives(
    robot: DeltaRobot, angles: Any, positions: Any, label: Callable[[str], str] = str
) -> DeltaResult:
    """Return the answer; ``label`` gives what messages call a parameter."""
    given, name = (positions, "positions") if robot.is_linear else (angles, "angles")
    other = angles if robot.is_linear else positions
    if other is not None:
        kind = "carriages on rails" if robot.is_linear else "arms"
        raise InputError(f"{label('angles' if robot.is_linear else 'positions')}: this Delta has {kind}")
    if given is None:
        raise InputError(f"{label(name)}: missing")
    if robot.is_linear:
        read = read_triple(given, label(name), lambda v: Range(*read_range(v, METRES)), "positions")
        texts = tuple(range_text(v) for v in read)
    else:
        read = read_triple(given, label(name), read_angle, "angles")
        texts = tuple(map(str, read))
    with balls.precision():
        delta = delta_of(robot)
        drives = [balls.from_range(v) if robot.is_linear else radians(v) for v in read]
        return _result(robot, delta, drives, (texts[0], texts[1], texts[2]))


def range_text(given: Range) -> str:
    """Return a number or a range as it is typed."""
    from cdpr_interval.exact.decimals import exact_text

    lo, hi = (exact_text(end, 1000) for end in given)
    return lo if lo == hi else f"{lo}..{hi}"


def _result(robot: DeltaRobot, delta: Delta, drives: list[arb], asked: tuple[str, str, str]) -> DeltaResult:
    centres = [delta.knee(i, drive) for i, drive in enumerate(drives)]
    found = meeting(centres, delta.bar)
    poses = [narrowed(centres, delta.bar, pose) for pose in found.poses]
    rows = bounds(drives)
    solutions = tuple(
        _pose(robot, delta, drives, pose, None if not found.is_ordered else k == 0)
        for k, pose in enumerate(poses)
    )
    reasons: tuple[str, ...] = (
        (found.reason,) if found.reason and not (found.is_decided and found.is_ordered) else ()
    )
    open_limits = [k for k, pose in enumerate(solutions) if pose.limits_respected is None]
    reasons += tuple(f"pose {k + 1}: whether it keeps the limits is not known" for k in open_limits)
    message = (
        f"not proved: {found.reason}"
        if not found.is_decided
        else f"no pose: {found.reason}"
        if not solutions
        else "two poses, and no other one"
    )
    return DeltaResult(
        tool=this_tool(),
        robot=RobotIdentity(robot.name, robot.sha256),
        model=robot.model,
        question=DeltaQuestion(
            "fk", angles=None if robot.is_linear else rows, positions=rows if robot.is_linear else None
        ),
        outcome=Outcome.INCOMPLETE if reasons else Outcome.COMPLETE,
        message=message,
        solutions=solutions,
        undecided=reasons,
        provenance=origin_of(robot, asked),
    )


def _pose(
    robot: DeltaRobot, delta: Delta, drives: list[arb], centre: Vector, is_lower: bool | None
) -> DeltaPose:
    leans, elbows, kept = beside_limits(robot, delta, centre, drives)
    place = [x + t for x, t in zip(centre, delta.tool, strict=True)]
    return DeltaPose(bounds(place), is_lower, leans, elbows, kept)


def beside_limits(
    robot: DeltaRobot, delta: Delta, centre: Vector, drives: list[arb]
) -> tuple[np.ndarray, np.ndarray | None, bool | None]:
    """Return bounds (3, 2) of how far bars lean and of elbows, rad, and whether the limits are kept."""
    leans = [lean(delta, i, centre, drive) for i, drive in enumerate(drives)]
    elbows = [] if robot.is_linear else [elbow(delta, i, centre, drive) for i, drive in enumerate(drives)]
    limits = {name: radians(angle) for name, angle in robot.limits.items()}
    kept: list[bool | None] = []
    for name, values, sign in zip(LIMITS, (leans, elbows, elbows), (1, -1, 1), strict=True):
        if name in limits:
            kept += [_at_most(sign * v, sign * limits[name]) for v in values]
    respected = False if False in kept else None if None in kept else True
    return bounds(leans), None if robot.is_linear else bounds(elbows), respected


def _at_most(value: arb, limit: arb) -> bool | None:
    """Return whether a number is at most a limit; None where that is not known."""
    return True if value <= limit else False if value > limit else None


def bounds(values: list[arb]) -> np.ndarray:
    """Return double bounds (n, 2)."""
    return np.array([balls.to_bounds(v) for v in values])
