"""``cdpr-solve validate``: reads a robot file and prints what it says, or every error in it."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import click

from solvers.shell.completion import robot_argument
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from cdpr_interval.robots.cable_robot import Cable, Point, Robot, Scalar


@click.command(
    "validate",
    short_help="Read a robot file and print a summary, or every error.",
    epilog=examples("validate merlet_4_1"),
)
@robot_argument
def command(robot: str) -> int:
    """Read ROBOT and print a summary, or every error with line and column."""
    from cdpr_interval.robots.formats.reader import load_robot

    for line in _summary(load_robot(robot)):
        click.echo(line)
    return 0


def _summary(robot: Robot) -> list[str]:
    from solvers.classes import class_of

    kind = class_of(robot).title
    cables = "mixed cables" if robot.is_mixed else "elastic" if robot.is_elastic else "inextensible"
    lines = [
        f"{robot.name}: valid, {kind} on {len(robot.cables)} cables, {cables}",
        f"  mass {_scalar(robot.platform.mass)} kg",
        f"  centre of mass {_point(robot.platform.centre_of_mass)} m",
        f"  gravity {_point(robot.gravity)} m/s2",
    ]
    if robot.source is not None:
        lines.append(f"  source: {robot.source}")
    lines += [f"  {_cable(cable)}" for cable in robot.cables]
    lines += [
        f"  uncertain: {scalar.path} in [{_number(scalar.lo)}, {_number(scalar.hi)}]"
        for scalar in robot.uncertain
    ]
    return lines


def _cable(cable: Cable) -> str:
    text = f"{cable.name}: from {_point(cable.frame_anchor)} m to {_point(cable.platform_anchor)} m"
    if cable.elasticity is not None and cable.elasticity.stiffness is not None:
        text += f", {_scalar(cable.elasticity.stiffness)} N/m"
    elif cable.elasticity is not None and cable.elasticity.axial_stiffness is not None:
        text += f", EA = {_scalar(cable.elasticity.axial_stiffness)} N"
    if cable.tension_limits is not None:
        text += f", tension {_number(cable.tension_limits[0])} to {_number(cable.tension_limits[1])} N"
    return text


def _point(values: Point) -> str:
    return "(" + ", ".join(_scalar(value) for value in values) + ")"


def _scalar(value: Scalar) -> str:
    if isinstance(value, Fraction):
        return _number(value)
    return f"[{_number(value.lo)}, {_number(value.hi)}]"


def _number(value: Fraction) -> str:
    return str(value.numerator) if value.denominator == 1 else repr(float(value))
