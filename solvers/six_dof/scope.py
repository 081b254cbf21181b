"""Which robots and questions are those of a six-dof platform."""

from __future__ import annotations

from collections.abc import Iterator

from cdpr_interval.mechanics.loaded import NO_FORCE
from cdpr_interval.robots.cable_robot import SIX_DOF, Robot
from cdpr_interval.robots.numbers import Point
from cdpr_interval.text.count import counted
from solvers.questions.arguments import Label
from solvers.questions.checked import mixed_cables, over_pulleys
from solvers.questions.problem import Method, Options

MOST_TAUT = 6
"""Most taut cables of a subset: more share the load in more than one way."""


def accepts(robot: Robot) -> bool:
    """Return True for a robot with a cable that does not end at the centre of mass."""
    return robot.model == SIX_DOF


def refuses(robot: Robot, force: Point = NO_FORCE) -> str | None:
    """Return why this version cannot treat a platform under a force (N); None where it can."""
    return (
        over_pulleys(robot)
        or mixed_cables(robot)
        or ("elastic cables of a platform are not supported yet" if robot.is_elastic else None)
    )


def complaints(robot: Robot, taut: tuple[int, ...] | None, options: Options, label: Label) -> Iterator[str]:
    """Yield the rules that a question breaks."""
    count = len(robot.cables)
    most = min(MOST_TAUT, count)
    if taut is not None and len(taut) > most:
        yield f"{label('taut')}: {len(taut)} cables, but a taut subset of a platform has at most {most}"
    tight = count if taut is None else len(taut)
    if options.ignore_tension_sign and tight != MOST_TAUT:
        rule = f"needs exactly six taut cables of a platform, got {counted(tight, 'cable')}"
        yield f"{label('ignore_tension_sign')}: {rule}"
    if options.method is Method.CONVEX:
        yield f"{label('method')}: 'convex' is for point-mass robots, this is a platform"
