"""Which robots and questions are those of a point mass."""

from __future__ import annotations

from collections.abc import Iterator

from cdpr_interval.mechanics.loaded import NO_FORCE
from cdpr_interval.robots.cable_robot import POINT_MASS, Robot
from cdpr_interval.robots.numbers import Point, is_exact_point
from solvers.questions.arguments import Label
from solvers.questions.checked import not_on_six_legs
from solvers.questions.problem import Options


def accepts(robot: Robot) -> bool:
    """Return True for a robot all of whose cables end at the centre of mass."""
    return robot.model == POINT_MASS


def is_routed(robot: Robot) -> bool:
    """Return True where a cable runs over a pulley, or some cables stretch and others do not."""
    return robot.has_pulleys or robot.is_mixed


def refuses(robot: Robot, force: Point = NO_FORCE) -> str | None:
    """Return why this version cannot treat a point mass under a force (N); None where it can."""
    if (reason := not_on_six_legs(robot)) is not None:
        return reason
    if is_routed(robot) and not is_exact_point(robot.gravity):
        return "ranges of gravity are not supported with pulleys or with cables of two kinds yet"
    return None


def most_taut(robot: Robot) -> int:
    """Return how many cables can be taut together without redundant tensions.

    By Caratheodory no pose is missed with three inextensible cables; elastic ones share the load whatever
    their number.
    """
    count = len(robot.cables)
    return count if robot.is_elastic else min(3, count)


def complaints(robot: Robot, taut: tuple[int, ...] | None, options: Options, label: Label) -> Iterator[str]:
    """Yield the rules that a question breaks."""
    most = most_taut(robot)
    if taut is not None and len(taut) > most:
        cables = f"{len(taut)} cables, but a taut subset of an inextensible point mass has at most {most}"
        yield f"{label('taut')}: {cables}"
    if options.ignore_tension_sign:
        rule = "needs exactly six taut cables of a platform, got a point mass"
        yield f"{label('ignore_tension_sign')}: {rule}"
