"""Where a pose goes no further: whether it is proved to end there, and which poses exist afterwards."""

from __future__ import annotations

from fractions import Fraction

from cdpr_interval.engine.budget import Budget
from cdpr_interval.errors import CdprError
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.data import Outcome, Solution, StopReason
from solvers.answers.result import Result
from solvers.forward import forward_kinematics
from solvers.motions.course import Course
from solvers.motions.data import EventData, EventKind, pose_data
from solvers.motions.start import mover_of
from solvers.motions.stretch import Stretch
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
    doubts = [] if result.outcome is Outcome.COMPLETE else ["the poses afterwards are not proved to be all"]
    for pose in () if doubts else result.solutions:
        doubts.append(_doubt(robot, course, later, trail.reached, pose, result, last, budget))
    doubt = next(filter(None, doubts), "")
    if not (doubt or result.solutions):
        kind, reason = EventKind.FOLD, f"the pose ends: afterwards there is none; {result.message}"
    elif doubt:
        kind, reason = EventKind.LOST, f"{trail.reason}; not proved to end: {doubt}"
    else:
        kind, reason = EventKind.FOLD, "the pose ends: none of those afterwards, which are all, comes from it"
    return EventData(trail.reached, later, kind, reason=reason, poses=tuple(map(pose_data, result.solutions)))


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


def _doubt(
    robot: Robot,
    course: Course,
    later: Fraction,
    time: Fraction,
    pose: Solution,
    result: Result,
    last: Stretch,
    budget: Budget,
) -> str:
    """Return why the pose that was lost may go on to one of a later time; empty where it does not, proved.

    That is proved where the one of a later time, led back, is elsewhere.
    """
    middle, name = course.of_middles(), ",".join(robot.cable_names[i] for i in pose.taut)
    place = f"the pose with taut {name} afterwards"
    try:
        mover = mover_of(robot, pose, result.solutions, middle.bounds(later))
    except CdprError as error:
        return f"{place} cannot be led back: {error}"
    between = [row.time for row in course.rows if time < row.time < later]
    trail = lead(mover, middle, [later, *reversed(between), time], budget)
    if trail.reached != time:
        return f"{place} cannot be led back"
    return "" if mover.here.is_apart(last) else f"{place} may come from it"
