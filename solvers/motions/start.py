"""From which poses a motion starts: those for the lengths of its first row."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr_interval.errors import CdprError
from cdpr_interval.exact.enclosure import Bounds
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import Solution, StopReason, Undecided
from solvers.answers.result import Result
from solvers.classes import class_of
from solvers.motions.course import Course
from solvers.motions.one_pose import OnePoseMover
from solvers.motions.platform import PlatformMover
from solvers.motions.real_platform import RealPlatformMover
from solvers.motions.stretch import Mover
from solvers.six_dof.scope import needs_real_cells


@dataclass(frozen=True)
class Starts:
    """The stable poses at the start."""

    poses: tuple[Solution, ...]
    """Proved; lowest first, or just the nearest to a place that was asked for."""
    among: tuple[Solution | Undecided, ...]
    """All that was found there: poses, and regions that may hold some."""
    is_complete: bool
    """Proved that there are no others, or none as near to the place that was asked for."""
    message: str
    """One sentence: what was found."""


def question_at_start(robot: Robot, course: Course) -> tuple[Robot, Sequence[Any]]:
    """Return robot and lengths for which poses are looked for: those given, of platforms their middles."""
    if class_of(robot).solves_ranges:
        return robot, course.rows[0].lengths
    return robot.middle(), course.middles(course.begin)


def is_of_middles(robot: Robot, course: Course) -> bool:
    """Return True where robot or first row have ranges, and poses are looked for at their middles."""
    has_ranges = not robot.is_exact or any(lo < hi for lo, hi in course.rows[0].lengths)
    return not class_of(robot).solves_ranges and has_ranges


def chosen(result: Result, near: Sequence[float] | None) -> Starts:
    """Return the stable poses of a result, or the one nearest to a place (x, y, z) in m."""
    stable = [s for s in result.solutions if s.is_proved and s.stability is Stability.STABLE]
    # A pose with an open cable is one that is known, too.
    doubtful: list[Solution | Undecided] = [*result.undecided]
    doubtful += [s for s in result.solutions if not s.is_proved or s.stability is Stability.UNDECIDED]
    ended = result.stop_reason is StopReason.EXHAUSTED and not result.pending
    among: tuple[Solution | Undecided, ...] = (*result.solutions, *result.undecided)
    if near is not None and stable:
        nearest = min(stable, key=lambda s: math.dist(s.nominal.position, near))
        farthest = _distances(nearest.position, near)[1]
        is_nearest = all(_distances(one.position, near)[0] > farthest for one in doubtful)
        return Starts((nearest,), among, ended and is_nearest, result.message)
    return Starts(tuple(stable), among, ended and not doubtful, result.message)


def _distances(box: Bounds, place: Sequence[float]) -> tuple[float, float]:
    """Return the least and the largest distance of points in a box (3, 2) from a place, in m, in floats."""
    low, high = box[:, 0] - place, box[:, 1] - place
    least = np.where((low <= 0.0) & (high >= 0.0), 0.0, np.minimum(np.abs(low), np.abs(high)))
    return float(np.linalg.norm(least)), float(np.linalg.norm(np.maximum(np.abs(low), np.abs(high))))


def mover_of(robot: Robot, start: Solution, among: Sequence[Solution | Undecided], lengths: Bounds) -> Mover:
    """Return what leads a pose from the lengths at its start.

    Parameters
    ----------
    robot : Robot
    start : Solution
    among : sequence of Solution and Undecided
        The poses for these lengths that are known, this one too, and the regions that may hold others: it is
        proved which of them is led.
    lengths : (N, 2)
        m: around the lengths of the start; of a robot with one pose for each choice they may be ranges.

    Raises
    ------
    CdprError
        The pose cannot be led from there; the message says why.
    """
    kind = class_of(robot)
    if kind.solves_ranges:
        return OnePoseMover(kind.follower(robot, start), lengths)
    if needs_real_cells(robot):
        return RealPlatformMover(robot, start, lengths)
    mover = PlatformMover(robot, start, lengths)
    if [one for one in among if _may_be(one, mover)] != [start]:
        raise CdprError("it cannot be told from another one")
    return mover


def _may_be(one: Solution | Undecided, mover: Mover) -> bool:
    """Return True when the box of a solution or region and a mover's have a pose in common, or may."""
    here = mover.here
    pairs = ((one.position, here.position), (one.rotation, here.rotation))
    return all(bool(np.all((a[..., 0] <= b[..., 1]) & (b[..., 0] <= a[..., 1]))) for a, b in pairs)


def mover_at(robot: Robot, start: Solution, among: Sequence[Solution | Undecided], course: Course) -> Mover:
    """Return what leads a pose from the first row of a course, for all lengths in their ranges.

    Raises
    ------
    CdprError
        The pose cannot be led from there; the message says why.
    """
    begin = course.begin
    if class_of(robot).solves_ranges:
        return mover_of(robot, start, among, course.bounds(begin))
    mover = mover_of(robot, start, among, course.of_middles().bounds(begin))
    if reason := mover.go(course.bounds(begin)).reason:
        raise CdprError(f"for all choices in the first row: {reason}")
    return mover
