"""Forward kinematics: the question is checked, put to the solver of the robot's class, and reported."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from cdpr_interval.engine.budget import Budget
from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.robots.cable_robot import Robot
from solvers.answers.message import message_of
from solvers.answers.order import sort_solutions, sort_subsets, sort_undecided
from solvers.answers.result import Answer, Bounds, Question, Result, RobotIdentity, Statistics, StopReason
from solvers.answers.tool import this_tool
from solvers.answers.verification import model_name
from solvers.questions.errors import InputErrors
from solvers.questions.force import NO_LOAD, ZERO, read_force
from solvers.questions.lengths import read_lengths
from solvers.questions.problem import LengthRange, Method, Options, Problem, Progress
from solvers.questions.subset import check_subset_size, read_subset


def forward_kinematics(
    robot: Robot,
    lengths: str | Sequence[Any] | Mapping[str, Any],
    *,
    taut: str | Iterable[str | int] | None = None,
    ignore_slack: bool = False,
    ignore_tension_sign: bool = False,
    method: str = "auto",
    precision: float = 1e-9,
    external_force: Sequence[Any] | None = None,
    time_limit: float | None = None,
    cell_limit: int | None = None,
    threads: int = 1,
    progress: Callable[[Progress], None] | None = None,
) -> Result:
    """Find and prove every static pose of a robot for given cable lengths.

    Parameters
    ----------
    robot : Robot
        As `cdpr_interval.load_robot` returns it.
    lengths : sequence, mapping or str
        One length per cable in m, in file order or by name; unstretched for elastic cables. A float is
        that exact double; a str, Decimal or Fraction is exact; a pair (lo, hi) is a range.
    taut : iterable of str or int, optional
        One subset of taut cables (names or indices from 0) instead of all subsets.
    ignore_slack : bool
        Keep poses at which a cable outside the taut subset is too short to be slack, marked so.
    ignore_tension_sign : bool
        Six taut cables of a platform as rigid legs, tensions of any sign.
    method : {"auto", "search", "convex"}
        How a point-mass robot is solved.
    precision : float
        Target width of the position (m) and rotation entries of a solution when the input is exact.
    external_force : sequence of 3 numbers, optional
        Constant force at the centre of mass in N, base axes, added to the weight.
    time_limit : float, optional
        Seconds of wall time.
    cell_limit : int, optional
        Number of cells of the search.
    threads : int
        The solutions do not depend on it.
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
    """
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
    return answer_question(pose_problem(robot, lengths, taut, external_force, options), options)


def refuse_unsupported(robot: Robot) -> None:
    """Raise `NotSupportedError` for a robot that no solver of this version can treat."""
    if robot.uncertain:
        places = ", ".join(scalar.path for scalar in robot.uncertain)
        raise NotSupportedError(f"robot '{robot.name}': uncertain scalars are not supported yet: {places}")
    if robot.is_mixed:
        raise NotSupportedError(
            f"robot '{robot.name}': elastic and inextensible cables in one robot are not supported yet"
        )
    if robot.is_elastic and not robot.is_point_mass:
        raise NotSupportedError(f"robot '{robot.name}': elastic cables of a platform are not supported yet")


def pose_problem(
    robot: Robot,
    lengths: Any,
    taut: Any,
    external_force: Any,
    options: Options,
    label: Callable[[str], str] = str,
) -> Problem:
    """Return the checked problem.

    Parameters
    ----------
    robot, lengths, taut, external_force, options
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
    errors = InputErrors()
    names = robot.cable_names
    ranges = errors.read(read_lengths, lengths, names, label("lengths")) or ()
    force = ZERO if external_force is None else errors.read(read_force, external_force) or ZERO
    subset = None if taut is None else errors.read(read_subset, taut, names, label("taut"))
    if subset is not None:
        errors.read(check_subset_size, robot, subset, label("taut"))
    if taut is None and options.ignore_tension_sign and len(names) == 6:
        subset = tuple(range(6))
    if options.ignore_tension_sign and (taut is None or subset is not None):
        count = len(names) if subset is None else len(subset)
        if robot.is_point_mass or count != 6:
            kind = "a point mass" if robot.is_point_mass else f"{count} cables"
            rule = f"needs exactly six taut cables of a platform, got {kind}"
            errors.add(f"{label('ignore_tension_sign')}: {rule}")
    if options.method is Method.CONVEX and not robot.is_point_mass:
        errors.add(f"{label('method')}: 'convex' is for point-mass robots, this is a platform")
    _check_budgets(options, errors, label)
    problem = Problem(robot, ranges, force, subset)
    if not any(problem.load):
        errors.add(NO_LOAD)
    errors.require_none()
    refuse_unsupported(robot)
    return problem


def _check_budgets(options: Options, errors: InputErrors, label: Callable[[str], str]) -> None:
    for name, value in (("precision", options.precision), ("time_limit", options.time_limit)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            errors.add(f"{label(name)}: must be a positive number, got {value!r}")
    for name, count in (("cell_limit", options.cell_limit), ("threads", options.threads)):
        if count is not None and count < 1:
            errors.add(f"{label(name)}: must be at least 1, got {count!r}")


def read_method(name: str, label: str = "method") -> Method:
    """Return the method of that name; `InputError` when there is none."""
    try:
        return Method(name)
    except ValueError:
        raise InputError(f"{label}: must be one of {', '.join(Method)}, got {name!r}") from None


def answer_question(problem: Problem, options: Options) -> Result:
    """Put a checked question to the solver of the robot's class and return the result."""
    start = time.perf_counter()
    if options.record is not None:
        options.record.budget = Budget(options.time_limit)
    try:
        answer = _solve(problem, options)
    except KeyboardInterrupt:
        # The solvers return what they have; this is an interrupt before or after their search.
        answer = Answer((), pending=1, stop_reason=StopReason.INTERRUPTED)
    return build_result(problem, options, answer, time.perf_counter() - start)


def _solve(problem: Problem, options: Options) -> Answer:
    if problem.robot.is_point_mass:
        from solvers.point_mass import forward as point_mass

        answer: Answer = point_mass.solve(problem, options)
        return answer
    from solvers.six_dof import forward as six_dof

    answer = six_dof.solve(problem, options)
    return answer


def build_result(problem: Problem, options: Options, answer: Answer, seconds: float) -> Result:
    """Return the result: the answer in canonical order, with the question it answers."""
    robot = problem.robot
    fx, fy, fz = (float(component) for component in problem.external_force)
    return Result(
        tool=this_tool(),
        robot=RobotIdentity(robot.name, robot.sha256),
        model=model_name(robot),
        cables=robot.cable_names,
        lengths=_enclosing(problem.lengths),
        question=Question(
            taut=problem.taut,
            ignore_slack=options.ignore_slack,
            ignore_tension_sign=options.ignore_tension_sign,
            method=options.method.value,
            precision=options.precision,
            external_force=(fx, fy, fz),
        ),
        outcome=answer.outcome,
        stop_reason=answer.stop_reason,
        message=message_of(answer),
        solutions=sort_solutions(answer.solutions),
        undecided=sort_undecided(answer.undecided),
        pending=answer.pending,
        subsets=sort_subsets(answer.subsets),
        statistics=Statistics(answer.cells, seconds, options.threads),
    )


def _enclosing(ranges: Iterable[LengthRange]) -> Bounds:
    """Return the tightest doubles around exact ranges, (N, 2)."""
    rows = []
    for lo, hi in ranges:
        below, above = _around(lo)
        rows.append((below, above if lo is hi else _around(hi)[1]))
    return np.array(rows, dtype=np.float64)


def _around(value: Fraction) -> tuple[float, float]:
    """Return the largest double that is not above the value, and the smallest that is not below."""
    nearest = value.numerator / value.denominator
    a, b = nearest.as_integer_ratio()
    excess = a * value.denominator - value.numerator * b
    if excess == 0:
        return nearest, nearest
    if excess < 0:
        return nearest, math.nextafter(nearest, math.inf)
    return math.nextafter(nearest, -math.inf), nearest
