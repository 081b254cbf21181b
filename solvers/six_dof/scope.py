"""Which robots and questions are those of a six-dof platform."""

from __future__ import annotations

from collections.abc import Iterator

from cdpr_interval.exact.range import as_range
from cdpr_interval.mechanics.cables.pulley import LEAD_ROOM
from cdpr_interval.mechanics.loaded import NO_FORCE
from cdpr_interval.robots.cable_robot import SIX_DOF, Robot
from cdpr_interval.robots.numbers import Point
from cdpr_interval.robots.pulley import BISECTOR
from cdpr_interval.text.count import counted
from solvers.questions.arguments import Label
from solvers.questions.checked import not_on_six_legs, uncertain_data
from solvers.questions.problem import Method, Options
from solvers.six_dof.real.columns import MOST_CARRYING

MOST_TAUT = 6
"""Most taut cables of a subset: more share the load in more than one way."""


def most_taut(robot: Robot) -> int:
    """Return how many cables a taut subset has at most: of those that stretch more can share the load."""
    return min(MOST_CARRYING if robot.is_elastic else MOST_TAUT, len(robot.cables))


def accepts(robot: Robot) -> bool:
    """Return True for a robot with a cable that does not end at the centre of mass."""
    return robot.model == SIX_DOF


def refuses(robot: Robot, force: Point = NO_FORCE) -> str | None:
    """Return why this version cannot treat a platform under a force (N); None where it can."""
    if (reason := not_on_six_legs(robot)) is not None:
        return reason
    if not needs_real_cells(robot):
        return None
    for cable in robot.cables:
        pulley = cable.pulley
        if pulley is None or pulley.is_plain or pulley.joints == 1:
            continue
        if pulley.balance == BISECTOR:
            return f"{cable.name}: a platform needs balance: exact, with the bisector forces have no energy"
        least = LEAD_ROOM * (as_range(pulley.arm_length).hi + as_range(pulley.radius).hi)
        if not as_range(pulley.lead_in).lo > least:
            rule = "a platform on two joints needs a lead-in above three times arm and radius together"
            return f"{cable.name}: {rule}, {float(least):.6g} m, got {float(as_range(pulley.lead_in).lo):.6g}"
    return uncertain_data(robot, force, asker="platforms on pulleys or elastic cables")


def needs_real_cells(robot: Robot) -> bool:
    """Return True where some cable runs over a pulley or stretches: then no sphere holds its anchor."""
    return robot.has_pulleys or robot.is_elastic


def complaints(robot: Robot, taut: tuple[int, ...] | None, options: Options, label: Label) -> Iterator[str]:
    """Yield the rules that a question breaks."""
    count = len(robot.cables)
    most = most_taut(robot)
    if taut is not None and len(taut) > most:
        yield f"{label('taut')}: {len(taut)} cables, but a taut subset of a platform has at most {most}"
    elif taut is not None and sum(robot.cables[i].elasticity is None for i in taut) > MOST_TAUT:
        yield f"{label('taut')}: more than {MOST_TAUT} cables that do not stretch"
    tight = count if taut is None else len(taut)
    if robot.has_legs:
        yield from _complaints_of_legs(robot, tight, options, label)
    elif options.ignore_tension_sign and tight != MOST_TAUT:
        rule = f"needs exactly six taut cables of a platform, got {counted(tight, 'cable')}"
        yield f"{label('ignore_tension_sign')}: {rule}"
    elif options.ignore_tension_sign and needs_real_cells(robot):
        yield f"{label('ignore_tension_sign')}: is for straight inextensible cables"
    if options.method is Method.CONVEX:
        yield f"{label('method')}: 'convex' is for point-mass robots, this is a platform"


def _complaints_of_legs(robot: Robot, tight: int, options: Options, label: Label) -> Iterator[str]:
    """Yield the rules that a question about a Gough platform breaks."""
    if tight != len(robot.cables):
        yield f"{label('taut')}: all {len(robot.cables)} legs carry, got {tight}"
    if options.ignore_slack:
        yield f"{label('ignore_slack')}: is for cables, legs are never slack"
