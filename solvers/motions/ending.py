"""Where a pose goes no further: whether it is proved to end there, and which poses exist afterwards."""

from __future__ import annotations

from fractions import Fraction

from cdpr_interval.engine.budget import Budget
from cdpr_interval.errors import CdprError
from cdpr_interval.exact.enclosure import length_bounds
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import Outcome, Solution, StopReason
from solvers.answers.result import Result
from solvers.forward import forward_kinematics
from solvers.motions.course import Course
from solvers.motions.data import EventData, EventKind, pose_data
from solvers.motions.start import holds, mover_of
from solvers.motions.stretch import Mover, Stretch
from solvers.motions.trail import Trail, lead

TRAVELS = (Fraction(1, 10**5), Fraction(1, 10**4), Fraction(1, 1000), Fraction(1, 100))
"""How far the fastest cable goes, in longest cables, from where a pose is lost to where all poses are looked
for: where two poses meet, these are hard to prove."""


def ending(
    robot: Robot, course: Course, trail: Trail, last: Stretch, budget: Budget, threads: int
) -> EventData:
    """Return the event with which a trail ends before its course does.

    It is a ``fold`` where it is proved that the pose ends, for the middles of the lengths: all poses at a
    time shortly afterwards are proved to be the listed ones, and each of them, led back, is at the time
    reached in another place than ``last``, the pose there. Were there poses that led continuously from that
    one to the later time, they would end in one of these, and what is led back from it is unique.
    """
    result, later = _afterwards(robot, course, trail.reached, budget, threads)
    if result is None:
        return EventData(trail.reached, course.end, EventKind.LOST, reason=trail.reason)
    is_end = result.outcome is Outcome.COMPLETE and all(
        _comes_from_elsewhere(robot, course, later, trail.reached, one, result, last, budget)
        for one in result.solutions
    )
    poses = tuple(map(pose_data, result.solutions))
    if is_end:
        reason = f"proved that the pose ends; before that: {trail.reason}"
        return EventData(trail.reached, later, EventKind.FOLD, reason=reason, poses=poses)
    if result.outcome is not Outcome.COMPLETE:
        reason = f"{trail.reason}; the poses after it are not proved to be all"
    else:
        reason = f"{trail.reason}; it is not proved to end"
    return EventData(trail.reached, later, EventKind.LOST, reason=reason, poses=poses)


def _afterwards(
    robot: Robot, course: Course, time: Fraction, budget: Budget, threads: int
) -> tuple[Result | None, Fraction]:
    """Return the poses at a time shortly after, and that time; None where the budget is spent before."""
    pace = course.pace(time)
    longest = max(hi for _, hi in course.at(time))
    found, later = None, course.end
    for travel in TRAVELS:
        if budget.stop() is not None or not pace:
            break
        later = min(time + travel * longest / pace, course.end)
        left = budget.seconds_left()
        limit = None if left is None else max(left, 1e-3)
        found = forward_kinematics(robot, course.middles(later), time_limit=limit, threads=threads)
        if found.stop_reason is StopReason.INTERRUPTED:
            budget.interrupt()
        if found.outcome is Outcome.COMPLETE or later == course.end:
            break
    return found, later


def _comes_from_elsewhere(
    robot: Robot,
    course: Course,
    later: Fraction,
    time: Fraction,
    pose: Solution,
    result: Result,
    last: Stretch,
    budget: Budget,
) -> bool:
    """Prove that a pose of a later time, led back, is not where the pose was lost."""
    middle = course.of_middles()
    try:
        mover: Mover = mover_of(robot, pose, length_bounds(middle.at(later)))
    except CdprError:
        return False
    if sum(holds(one, mover) for one in result.solutions) != 1 or not holds(pose, mover):
        return False
    between = [row.time for row in course.rows if time < row.time < later]
    trail = lead(mover, middle, [later, *reversed(between), time], budget)
    return trail.reached == time and mover.here.is_apart(last)
