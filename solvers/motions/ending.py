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
for. Where two poses meet, these are hard to prove; with ranges the middles meet later than the first ones."""


def ending(
    robot: Robot, course: Course, trail: Trail, last: Stretch, budget: Budget, threads: int
) -> EventData:
    """Return the event with which a trail ends before its course does.

    It is a ``fold`` where it is proved that the pose ends, for the middles of the lengths: all poses at a
    time shortly afterwards are proved to be the listed ones, and each of them, led back, is at the time
    reached in another place than ``last``, the pose there. Were there poses that led continuously from that
    one to the later time, they would end in one of these, and what is led back from it is unique.
    """
    found, is_listed = None, False
    for later in _afterwards(course, trail.reached):
        if budget.stop() is not None:
            break
        result = _poses(robot, course, later, budget, threads)
        doubt = _doubts(robot, course, later, trail.reached, result, last, budget)
        kind = EventKind.LOST if doubt else EventKind.FOLD
        poses = tuple(map(pose_data, result.solutions))
        event = EventData(trail.reached, later, kind, reason=_reason(trail, result, doubt), poses=poses)
        if kind is EventKind.FOLD:
            return event
        # Of losses the first one whose poses are all that there are.
        if found is None or not is_listed:
            found, is_listed = event, result.outcome is Outcome.COMPLETE
    return found or EventData(trail.reached, course.end, EventKind.LOST, reason=trail.reason)


def _afterwards(course: Course, time: Fraction) -> list[Fraction]:
    """Return times shortly after, up to the end of the course."""
    pace = course.pace(time)
    longest = max(hi for _, hi in course.at(time))
    later = [min(time + travel * longest / pace, course.end) for travel in TRAVELS] if pace else []
    return list(dict.fromkeys(later))


def _poses(robot: Robot, course: Course, time: Fraction, budget: Budget, threads: int) -> Result:
    """Return the poses at a time, for the middles of the lengths, within what is left of the budget."""
    left = budget.seconds_left()
    limit = None if left is None else max(left, 1e-3)
    found = forward_kinematics(robot, course.middles(time), time_limit=limit, threads=threads)
    if found.stop_reason is StopReason.INTERRUPTED:
        budget.interrupt()
    return found


def _reason(trail: Trail, result: Result, doubt: str) -> str:
    """Return the sentence about a fold or a loss."""
    if doubt:
        return f"{trail.reason}; not proved to end: {doubt}"
    if result.solutions:
        return "the pose ends: none of those afterwards, which are all, comes from it"
    return f"the pose ends, there is none afterwards: {result.message.removeprefix('no pose: ')}"


def _doubts(
    robot: Robot,
    course: Course,
    later: Fraction,
    time: Fraction,
    result: Result,
    last: Stretch,
    budget: Budget,
) -> str:
    """Return why the pose may go on to the later time; empty where it is proved that it does not."""
    if result.outcome is not Outcome.COMPLETE:
        return "the poses afterwards are not proved to be all"
    each = (_doubt(robot, course, later, time, pose, result, last, budget) for pose in result.solutions)
    return next(filter(None, each), "")


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
