"""Forward kinematics: the question is checked, put to the solver of the robot's class, and reported."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from cdpr_interval.engine.budget import Budget
from cdpr_interval.exact.enclosure import length_bounds
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.given import require_robot
from solvers.answers.data import Answer, Question, RobotIdentity, Statistics, StopReason
from solvers.answers.fields import floats_of
from solvers.answers.limits import within_limits
from solvers.answers.message import message_of
from solvers.answers.order import sort_solutions, sort_subsets, sort_undecided
from solvers.answers.provenance import provenance
from solvers.answers.result import Result
from solvers.answers.tool import this_tool
from solvers.classes import class_of
from solvers.questions.arguments import require_flags
from solvers.questions.checked import check_budgets, not_on_six_legs, read_method, require_treated
from solvers.questions.errors import InputErrors
from solvers.questions.force import ZERO, no_load, read_force_ranges
from solvers.questions.lengths import read_lengths
from solvers.questions.problem import Options, Problem, Progress, asked_of
from solvers.questions.strokes import beyond_limits
from solvers.questions.subset import read_subset
from solvers.questions.tension import read_tension_limits


def forward_kinematics(
    robot: Robot | str | os.PathLike[str],
    lengths: str | Sequence[Any] | Mapping[str, Any],
    *,
    taut: str | Iterable[str | int] | None = None,
    ignore_slack: bool = False,
    ignore_tension_sign: bool = False,
    method: str = "auto",
    precision: float = 1e-9,
    external_force: Sequence[Any] | None = None,
    tension: str | Sequence[Any] | None = None,
    time_limit: float | None = None,
    cell_limit: int | None = None,
    threads: int = 1,
    progress: Callable[[Progress], None] | None = None,
) -> Result:
    """Find and prove every static pose of a robot for given cable lengths.

    Parameters
    ----------
    robot : Robot, str or PathLike
        As `cdpr_interval.load_robot` returns it, or what that takes: a file or the name of a shipped robot.
    lengths : sequence, mapping or str
        One length per cable in m, in file order or by name; unstretched for elastic cables. A float is
        that exact double; a str, Decimal or Fraction is exact; a pair (lo, hi) is a range.
    taut : iterable of str or int, optional
        One subset of taut cables (names or indices from 0) instead of all subsets.
    ignore_slack : bool
        Keep poses at which a cable outside the taut subset is too short to be slack, marked so.
    ignore_tension_sign : bool
        Six taut cables of a platform as rigid legs, tensions of any sign; always of a Gough platform.
    method : {"auto", "search", "convex"}
        How a point-mass robot is solved.
    precision : float
        Target width of the position in m and the rotation entries of a solution, exact input. Boxes are
        always as narrow as a few Newton steps in doubles make them, so it changes nothing yet.
    external_force : sequence of 3 numbers, optional
        Constant force at the centre of mass in N, base axes, added to the weight; numbers or ranges.
    tension : pair or str, optional
        Limits (lo, hi) in N: only poses whose taut cables all have a tension within them. Slack cables are
        not judged. A pose whose bounds hold a limit is listed, with ``tension_respected`` None, and the
        outcome is INCOMPLETE.
    time_limit : float, optional
        Seconds of wall time.
    cell_limit : int, optional
        Number of cells of the search.
    threads : int
        How many threads work at a time; the solutions do not depend on it. The command line uses all cores.
    progress : callable, optional
        Called with a `Progress` a few times a second.

    Returns
    -------
    Result
        Also when a budget ran out or the run was interrupted (Ctrl-C): with what was proved until
        then, and what is left counted as pending.

    Raises
    ------
    InputError
        With one message per error.
    NotSupportedError
        The question is valid, but this version cannot answer it.

    Guarantee
    ---------
    When the outcome is COMPLETE, no static pose of what was asked is missing from the solutions.

    Examples
    --------
    >>> result = forward_kinematics("uc2", ["7.5", "8"])
    >>> result
    <Result uc2: 8 static poses, proved to be all>
    >>> hanging = [pose for pose in result.solutions if pose.stability == "stable"]
    >>> [round(x, 3) for x in hanging[0].nominal.position]
    [5.296, 0.0, -7.87]
    >>> lo, hi = hanging[0].position[2].tolist()  # certain bounds of z in m
    >>> lo < -7.8 and hi - lo < 1e-9
    True
    """
    require_flags(ignore_slack=ignore_slack, ignore_tension_sign=ignore_tension_sign)
    options = Options(
        ignore_slack=ignore_slack,
        ignore_tension_sign=ignore_tension_sign,
        method=read_method(method),
        precision=precision,
        time_limit=time_limit,
        cell_limit=cell_limit,
        threads=threads,
        progress=progress,
    )
    problem = pose_problem(require_robot(robot), lengths, taut, external_force, options, tension=tension)
    return answer_question(problem, options)


def pose_problem(
    robot: Robot,
    lengths: Any,
    taut: Any,
    external_force: Any,
    options: Options,
    label: Callable[[str], str] = str,
    tension: Any = None,
) -> Problem:
    """Return the checked problem.

    Parameters
    ----------
    robot, lengths, taut, external_force, options, tension
        As `forward_kinematics`.
    label : callable
        From a parameter's name to what messages call it.

    Raises
    ------
    InputError
        With one message per rule that is broken.
    NotSupportedError
        When all rules are kept, but no solver of this version can treat the robot.
    """
    require_treated(robot, not_on_six_legs(robot))
    errors, options = InputErrors(), asked_of(robot, options)
    names = robot.cable_names
    ranges = errors.read(read_lengths, lengths, names, label("lengths")) or ()
    force = ZERO if external_force is None else errors.read(read_force_ranges, external_force) or ZERO
    subset = None if taut is None else errors.read(read_subset, taut, names, label("taut"))
    if taut is None and options.ignore_tension_sign and len(names) == 6:
        subset = tuple(range(6))
    limits = None if tension is None else errors.read(read_tension_limits, tension, label("tension"))
    if tension is not None and options.ignore_tension_sign:
        rule = f"not together with {label('ignore_tension_sign')}: such legs push, too"
        errors.add(f"{label('tension')}: {'not of legs, which push, too' if robot.has_legs else rule}")
    kind = class_of(robot)
    if taut is None or subset is not None:
        for text in kind.complaints(robot, subset, options, label):
            errors.add(text)
    check_budgets(options, errors, label)
    problem = Problem(robot, ranges, force, subset, limits)
    if (complaint := no_load(problem.loaded)) is not None:
        errors.add(complaint)
    errors.require_none()
    require_treated(robot, kind.refuses(robot, force))
    return problem


def answer_question(problem: Problem, options: Options) -> Result:
    """Put a checked question to the solver of the robot's class and return the result."""
    start, options = time.perf_counter(), asked_of(problem.robot, options)
    if options.record is not None:
        options.record.budget = Budget(options.time_limit)
    try:
        answer = class_of(problem.robot).forward(problem, options)
    except KeyboardInterrupt:
        # The solvers return what they have; this is an interrupt before or after their search.
        answer = Answer((), pending=1, stop_reason=StopReason.INTERRUPTED)
    if problem.tension is not None:
        answer = within_limits(answer, problem.tension)
    return build_result(problem, options, answer, time.perf_counter() - start)


def build_result(problem: Problem, options: Options, answer: Answer, seconds: float) -> Result:
    """Return the result: the answer in canonical order, with the question it answers."""
    robot = problem.robot
    return Result(
        tool=this_tool(),
        robot=RobotIdentity(robot.name, robot.sha256),
        model=robot.model,
        cables=robot.cable_names,
        lengths=length_bounds(problem.lengths),
        question=Question(
            command="fk",
            taut=problem.taut,
            ignore_slack=options.ignore_slack,
            ignore_tension_sign=options.ignore_tension_sign,
            method=options.method.value,
            precision=options.precision,
            external_force=floats_of(problem.external_force),
            tension=None
            if problem.tension is None
            else (float(problem.tension[0]), float(problem.tension[1])),
        ),
        outcome=answer.outcome,
        stop_reason=answer.stop_reason,
        message="; ".join([message_of(answer), *beyond_limits(robot, problem.lengths)]),
        solutions=sort_solutions(answer.solutions),
        undecided=sort_undecided(answer.undecided),
        pending=answer.pending,
        subsets=sort_subsets(answer.subsets),
        statistics=Statistics(answer.cells, seconds, options.threads),
        provenance=provenance(robot, problem.lengths, problem.external_force),
    )
