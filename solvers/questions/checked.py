"""Rules that every question must keep, whatever the robot's class."""

from __future__ import annotations

from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.exact.range import Range
from cdpr_interval.mechanics.loaded import NO_FORCE
from cdpr_interval.robots.cable_robot import SIX_DOF, Robot
from cdpr_interval.robots.numbers import Point, is_exact_point
from solvers.questions.arguments import (
    Label,
    check_called,
    check_counts,
    check_positive,
)
from solvers.questions.errors import InputErrors
from solvers.questions.problem import Method, Options, Problem

SIX_LEGS = 6
"""Legs of a Gough platform: fewer leave it free, more hold it in no pose for nearly all lengths."""


def check_budgets(options: Options, errors: InputErrors, label: Label) -> None:
    """Note a precision, budgets or a number of threads that are not positive, and what is of a wrong kind."""
    if options.precision is None:
        errors.add(f"{label('precision')}: must be a positive number, got None")
    if options.threads is None:
        errors.add(f"{label('threads')}: must be a whole number, got None")
    check_positive(errors, label, precision=options.precision, time_limit=options.time_limit)
    check_counts(errors, label, cell_limit=options.cell_limit, threads=options.threads)
    check_called(errors, label, progress=options.progress)


def read_method(name: str, label: str = "method") -> Method:
    """Return the method of that name; `InputError` when there is none."""
    try:
        return Method(name)
    except (ValueError, TypeError):
        raise InputError(f"{label}: must be one of {', '.join(Method)}, got {name!r}") from None


def uncertain_data(robot: Robot, force: Point = NO_FORCE, asker: str = "") -> str | None:
    """Return why ranges in the data of a robot or of the force on it are refused; None where there are none.

    Parameters
    ----------
    robot : Robot
    force : Point
        External force, N.
    asker : str
        What takes exact numbers only, as users know it (``ik``).
    """
    if robot.is_exact and is_exact_point(force):
        return None
    places = [scalar.path for scalar in robot.uncertain]
    places += [f"external_force_N[{k}]" for k, x in enumerate(force) if isinstance(x, Range)]
    by = f" by {asker}" if asker else ""
    return f"uncertain scalars are not supported{by} yet: {', '.join(places)}"


def require_certifiable(problem: Problem) -> None:
    """Raise `NotSupportedError` for a question whose certificate no checker of today could read.

    It takes ranges of lengths, and of nothing else, and cables that all stretch or all do not; of platforms
    none that stretch, and over pulleys exact lengths and ropes that never lift off.
    """
    robot = problem.robot
    require_treated(
        robot, _by("tension limits are not supported", "certificates", problem.tension is not None)
    )
    require_treated(robot, mixed_cables(robot, "certificates"))
    if robot.model == SIX_DOF:
        require_treated(robot, uncertified_pulleys(robot))
        stretching = "elastic cables of a platform are not supported"
        require_treated(robot, _by(stretching, "certificates", robot.is_elastic))
        ranged = robot.has_pulleys and any(lo < hi for lo, hi in problem.lengths)
        text = "ranges of lengths over pulleys are not supported"
        require_treated(robot, _by(text, "certificates of a platform", ranged))
    else:
        require_treated(robot, over_pulleys(robot, "certificates"))
    require_treated(robot, uncertain_data(robot, problem.external_force, asker="certificates"))


def uncertified_pulleys(robot: Robot) -> str | None:
    """Return why a certificate cannot be about the pulleys of a platform, or None where it can."""
    for cable in robot.cables:
        pulley = cable.pulley
        if pulley is None:
            continue
        if pulley.is_plain and pulley.lead_in != 0:
            return _by(f"{cable.name}: a lead-in without a pulley is not supported", "certificates", True)
        if pulley.joints != 1:
            return _by(f"{cable.name}: pulleys on two joints are not supported", "certificates", True)
        if pulley.arm_length != pulley.radius:
            text = "ropes that may lift off, over an arm longer than the radius, are not supported"
            return _by(f"{cable.name}: {text}", "certificates", True)
    return None


def mixed_cables(robot: Robot, asker: str = "") -> str | None:
    """Return why a robot of elastic and inextensible cables is refused by ``asker``, or None."""
    return _by("elastic and inextensible cables in one robot are not supported", asker, robot.is_mixed)


def over_pulleys(robot: Robot, asker: str = "") -> str | None:
    """Return why a robot with pulleys is refused by ``asker``, or None for one without."""
    return _by("pulleys are not supported", asker, robot.has_pulleys)


def on_legs(robot: Robot, asker: str) -> str | None:
    """Return why a Gough platform is refused by ``asker``, which is about cables; None for a cable robot."""
    return f"legs are not supported by {asker}: for cables only" if robot.has_legs else None


def not_on_six_legs(robot: Robot) -> str | None:
    """Return why legs are refused: they are treated where exactly six carry a platform; None for cables."""
    if not robot.has_legs:
        return None
    if robot.model != SIX_DOF:
        return "legs carry a platform, this is a point mass"
    count = len(robot.cables)
    return None if count == SIX_LEGS else f"a platform on legs needs exactly six, got {count}"


def _by(text: str, asker: str, applies: bool) -> str | None:
    return f"{text}{' by ' + asker if asker else ''} yet" if applies else None


def require_treated(robot: Robot, reason: str | None) -> None:
    """Raise `NotSupportedError` where there is a reason to refuse a robot."""
    if reason is not None:
        raise NotSupportedError(f"robot '{robot.name}': {reason}")
