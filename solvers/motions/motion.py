"""Motions: a question checked, its start found, every pose of the start led along, and reported."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from decimal import ROUND_FLOOR
from fractions import Fraction
from pathlib import Path
from typing import Any

from cdpr_interval.engine.budget import Budget, Stop
from cdpr_interval.errors import CdprError, InputError
from cdpr_interval.mechanics.loaded import NO_FORCE, loaded
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.given import require_robot
from cdpr_interval.text.count import counted
from cdpr_interval.text.number import exact_number
from solvers.answers.data import Outcome, RobotIdentity, StopReason
from solvers.answers.provenance import provenance
from solvers.answers.tool import this_tool
from solvers.classes import class_of
from solvers.forward import forward_kinematics
from solvers.motions.course import Course, given_course, read_course
from solvers.motions.data import (
    Event,
    EventData,
    EventKind,
    MotionQuestion,
    Track,
    pose_data,
    segment_of,
)
from solvers.motions.ending import ending
from solvers.motions.result import Motion
from solvers.motions.start import Starts, chosen, is_of_middles, mover_at, question_at_start
from solvers.motions.times import between, shown_time
from solvers.motions.trail import Span, Trail, lead
from solvers.questions.checked import check_budgets, on_legs, require_treated
from solvers.questions.errors import InputErrors
from solvers.questions.force import no_load
from solvers.questions.problem import Options, Progress

STOPPED = {Stop.TIME_LIMIT: "stopped at the time limit", Stop.INTERRUPTED: "interrupted"}


@dataclass(frozen=True)
class MotionProblem:
    """A checked question about a motion."""

    robot: Robot
    course: Course
    """Widened by the tolerance."""
    file: str | None = None
    tolerance: Fraction = Fraction(0)
    """m."""
    step: Fraction | None = None
    """s: longest segment."""
    near: tuple[float, float, float] | None = None
    """m: where the start is."""


@dataclass
class MotionOptions:
    """What a motion may cost, and who is told how far it is."""

    time_limit: float | None = None
    threads: int = 1
    progress: Callable[[Progress], None] | None = None
    budget: Budget = field(init=False)

    def __post_init__(self) -> None:
        self.budget = Budget(self.time_limit)


def motion(
    robot: Robot | str | os.PathLike[str],
    lengths: str | os.PathLike[str] | Sequence[tuple[Any, Any]],
    *,
    tolerance: Any = 0,
    start: Sequence[float] | None = None,
    step: Any = None,
    time_limit: float | None = None,
    threads: int = 1,
    progress: Callable[[Progress], None] | None = None,
) -> Motion:
    """Follow the static pose of a robot along lengths over time, and prove it all along.

    Parameters
    ----------
    robot : Robot, str or PathLike
        Exact data. As `cdpr_interval.load_robot` returns it, or what that takes.
    lengths : str, PathLike or sequence of pairs
        A CSV file with the columns ``t_s`` and one for every cable; or pairs of a time in s and lengths as
        `forward_kinematics` takes them, m. Between rows lengths, and the ends of ranges, change in
        proportion to time.
    tolerance : number, optional
        m: exact lengths count as known to this.
    start : sequence of 3 numbers, optional
        m: start from the stable pose nearest to here. Default: follow every stable pose of the first row.
    step : number, optional
        s: longest segment. Default: from row to row.
    time_limit : float, optional
        Seconds of wall time.
    threads : int
        For the searches at the start and where a pose ends.
    progress : callable, optional
        Called with a `Progress` as the motion goes on.

    Returns
    -------
    Motion
        Also when time ran out or the run was interrupted (Ctrl-C): with what was proved until then.

    Raises
    ------
    InputError
        With one message per error; of a file with its line.
    NotSupportedError
        A robot that no solver of this version treats.

    Guarantee
    ---------
    That of `Motion`.

    Examples
    --------
    >>> from solvers import motion
    >>> result = motion("uc4", [(0, [7.5, 8, 7, 9]), (10, [7.5, 8, 7, 9.3])], step=5)
    >>> result
    <Motion uc4: proved from 0 to 10 s; c4 slack at 7.21679..7.21894 s>
    >>> [segment.taut for segment in result.segments]
    [(0, 1, 2, 3), (0, 1, 2, 3), (0, 1, 2), (0, 1, 2)]
    >>> result.events[0].cable, str(result.events[0].kind)
    ('c4', 'slack')
    """
    errors = InputErrors()
    check_budgets(Options(time_limit=time_limit, threads=threads, progress=progress), errors, str)
    errors.require_none()
    problem = motion_problem(require_robot(robot), lengths, tolerance, start, step)
    return solve_motion(problem, MotionOptions(time_limit, threads, progress))


def motion_problem(
    robot: Robot,
    lengths: Any,
    tolerance: Any = 0,
    near: Any = None,
    step: Any = None,
    label: Callable[[str], str] = str,
) -> MotionProblem:
    """Return the checked question; ``label`` names a parameter in messages.

    Raises
    ------
    InputError
        With one message per rule that is broken.
    NotSupportedError
        No solver of this version can treat the robot.
    """
    require_treated(robot, on_legs(robot, "motion"))
    require_treated(robot, class_of(robot).refuses(robot))
    errors, names, file = InputErrors(), robot.cable_names, None
    if isinstance(lengths, str | os.PathLike):
        file = os.fspath(lengths)
        course = errors.read(read_course, Path(file), file, names)
    else:
        course = errors.read(given_course, lengths, names)
    width = errors.read(_quantity, tolerance, label("tolerance"))
    longest = None if step is None else errors.read(_quantity, step, label("step"))
    place = None if near is None else errors.read(_place, near, label("start"))
    if width is not None and width < 0:
        errors.add(f"{label('tolerance')}: must not be negative, got {float(width):g}")
    if longest is not None and longest <= 0:
        errors.add(f"{label('step')}: must be positive, got {float(longest):g}")
    if (complaint := no_load(loaded(robot))) is not None:
        errors.add(complaint)
    errors.require_none()
    assert course is not None and width is not None
    return MotionProblem(robot, course.widened(width, label("tolerance")), file, width, longest, place)


def solve_motion(problem: MotionProblem, options: MotionOptions) -> Motion:
    """Answer a checked question."""
    begun = time.perf_counter()
    with options.budget.listening():
        starts, stop = _starts(problem, options)
        tracks = [_track(problem, starts, k, options) for k in range(len(starts.poses))]
    stop = stop or options.budget.stop()
    outcome, message = _verdict(problem, starts, tracks, stop)
    first = tracks[0] if tracks else None
    robot, course = problem.robot, problem.course
    return Motion(
        tool=this_tool(),
        robot=RobotIdentity(robot.name, robot.sha256),
        model=robot.model,
        cables=robot.cable_names,
        question=MotionQuestion(
            command="motion",
            file=problem.file,
            rows=len(course.rows),
            t=(float(course.begin), float(course.end)),
            tolerance=float(problem.tolerance),
            step=None if problem.step is None else float(problem.step),
            near=problem.near,
        ),
        outcome=outcome,
        stop_reason=StopReason.EXHAUSTED if stop is None else StopReason(stop.value),
        message=message,
        start=None if first is None else first.start,
        segments=() if first is None else first.segments,
        events=() if first is None else first.events,
        others=tuple(tracks[1:]),
        time=time.perf_counter() - begun,
        provenance=provenance(robot, course.rows[0].lengths, NO_FORCE),
    )


def _starts(problem: MotionProblem, options: MotionOptions) -> tuple[Starts, Stop | None]:
    """Return the poses at the start, and what stopped the search for them."""
    robot, lengths = question_at_start(problem.robot, problem.course)
    found = forward_kinematics(
        robot,
        lengths,
        time_limit=options.time_limit,
        threads=options.threads,
        progress=options.progress,
    )
    stop = None if found.stop_reason is StopReason.EXHAUSTED else Stop(found.stop_reason.value)
    if stop is Stop.INTERRUPTED:
        options.budget.interrupt()
    return chosen(found, problem.near), stop


def _track(problem: MotionProblem, starts: Starts, number: int, options: MotionOptions) -> Track:
    """Lead one pose along the course."""
    course, start, count = problem.course, starts.poses[number], len(starts.poses)

    def tell(trail: Trail) -> None:
        if options.progress is not None:
            share = (number + float((trail.reached - course.begin) / (course.end - course.begin))) / count
            options.progress(Progress(trail.proofs, 0, 1.0 - share, 0, 0, 1, done=share))

    try:
        mover = mover_at(problem.robot, start, starts.among, course)
    except CdprError as error:
        lost = EventData(course.begin, course.begin, EventKind.LOST, reason=str(error))
        return Track(pose_data(start), (), (lost.rounded(),))
    trail = lead(mover, course, course.knots(problem.step), options.budget, tell)
    events = _switches(trail.spans, problem.robot.cable_names)
    if trail.stop is not None:
        events.append(EventData(trail.reached, course.end, EventKind.LOST, reason=STOPPED[trail.stop]))
    elif trail.reason:
        middle = problem.robot.middle()
        events.append(ending(middle, course, trail, mover.here, options.budget, options.threads))
    is_lost = trail.stop is not None or bool(trail.reason)
    last = len(trail.spans) - 1
    segments = tuple(segment_of(span, is_lost and k == last) for k, span in enumerate(trail.spans))
    return Track(pose_data(start), segments, tuple(event.rounded() for event in events))


def _switches(spans: Sequence[Span], names: Sequence[str]) -> list[EventData]:
    """Return when cables become slack or taut: between spans on which every cable is one or the other."""
    events: list[EventData] = []
    last: Span | None = None
    for span in spans:
        if span.tube.switching:
            continue
        if last is not None:
            before, after = set(last.tube.taut), set(span.tube.taut)
            for kind, cables in ((EventKind.SLACK, before - after), (EventKind.TAUT, after - before)):
                events += [EventData(last.end, span.begin, kind, names[i]) for i in sorted(cables)]
        last = span
    return events


def _verdict(
    problem: MotionProblem, starts: Starts, tracks: Sequence[Track], stop: Stop | None
) -> tuple[Outcome, str]:
    """Return whether all is proved, and the sentence of the result."""
    if not starts.poses:
        if stop is not None:
            return Outcome.INCOMPLETE, f"{STOPPED[stop]}, in the search for the start"
        if is_of_middles(problem.robot, problem.course):
            found = "no stable pose for the middles of the first lengths"
            found += "; for others of them there may be one" if problem.robot.is_exact else OF_CHOICES
            return Outcome.INCOMPLETE, f"{found}: {starts.message}"
        if starts.is_complete:
            return Outcome.COMPLETE, f"no stable pose at the start: {starts.message}"
        return Outcome.INCOMPLETE, f"no stable pose is proved at the start: {starts.message}"
    several = f"{counted(len(tracks), 'stable pose')} at the start; " if len(tracks) > 1 else ""
    parts = [_sentence(problem.course, track.events) for track in tracks]
    if several:
        parts = [f"({k}) {_sentence(problem.course, track.events)}" for k, track in enumerate(tracks, 1)]
    message = several + "; ".join(parts)
    if not starts.is_complete:
        message += f"; the search at the start is not complete: {starts.message}"
    proved = starts.is_complete and not any(_loss(track.events) for track in tracks)
    return Outcome.COMPLETE if proved else Outcome.INCOMPLETE, message


def _sentence(course: Course, events: Sequence[Event]) -> str:
    """Return how far one pose is proved, and which cables switch on the way."""
    begin, end = float(course.begin), float(course.end)
    span = end - begin
    switches = [e for e in events if e.cable is not None]
    shown = [f"{e.cable} {e.kind} at {between(*e.t, span)} s" for e in switches[:MOST_NAMED]]
    if len(switches) > MOST_NAMED:
        shown.append(f"{counted(len(switches) - MOST_NAMED, 'more switch', 'more switches')}")
    text = ", ".join(shown)
    loss = _loss(events)
    if loss is None:
        found = f"proved from {shown_time(begin, span)} to {shown_time(end, span)} s"
        return f"{found}; {text}" if text else found
    far = shown_time(loss.t[0], span, ROUND_FLOOR)
    found = f"proved from {shown_time(begin, span)} to {far} of {shown_time(end, span)} s"
    return "; ".join(filter(None, [found, text, f"{loss.kind}: {loss.reason}"]))


OF_CHOICES = " and of the data; for other choices there may be one"
MOST_NAMED = 4
"""Switches that the sentence of a result names."""


def _loss(events: Sequence[Event]) -> Event | None:
    """Return the event with which a pose ends or is lost."""
    return next((e for e in events if e.kind in (EventKind.FOLD, EventKind.LOST)), None)


def _quantity(given: Any, label: str) -> Fraction:
    try:
        return exact_number(given)
    except (ValueError, TypeError) as error:
        raise InputError(f"{label}: {error}") from None


def _place(given: Any, label: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(exact_number(value)) for value in given)
    except (ValueError, TypeError):
        raise InputError(f"{label}: must hold x, y and z in m, got {given!r}") from None
    return x, y, z
