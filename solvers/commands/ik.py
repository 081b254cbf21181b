"""``cdpr-solve ik``: distances, lengths and tensions for a pose."""

from __future__ import annotations

from math import degrees, radians
from typing import TYPE_CHECKING, Any

import click

from solvers.commands.external_force import external_force_option, read_external_force
from solvers.commands.numbers import read_distance, read_float, say_middles, warn_of_lengths
from solvers.commands.target import JsonTarget, json_option
from solvers.questions.errors import InputErrors
from solvers.shell.completion import robot_argument
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from solvers.answers.ik_result import IkResult
    from solvers.cli import Ending

LARGE_TURN = radians(30)
"""A settled pose that is turned further is no longer the one a person had in mind."""


@click.command(
    "ik",
    short_help="Distances, lengths and tensions for a pose.",
    epilog=examples(
        "ik merlet_4_1 --pose 1,1.5,-2",
        "ik cogiro --pose '0 0 1 5deg 0 -10deg' --json -",
        "ik uc3 --pose 5,3,-7 --settle",
    ),
)
@robot_argument
@click.option(
    "--pose", metavar="X,Y,Z[,R,P,Y]", help="Platform origin in m; roll, pitch, yaw as 30deg or 0.5rad."
)
@click.option("--quaternion", metavar="W,X,Y,Z", help="Orientation, scalar first, platform to base.")
@click.option("--taut", metavar="C1,C2,...", help="The cables that may carry tension.  [default: all]")
@click.option(
    "--slack-margin", metavar="X", default="0.05", show_default=True, help="How much longer the others are."
)
@external_force_option
@click.option("--settle", is_flag=True, help="First move to the nearest static pose of the taut cables.")
@click.option(
    "--settle-within",
    metavar="D",
    help="How far in m any point of the platform may move.  [default: the platform's size]",
)
@click.option("--static", is_flag=True, help="Exit with 6 when the pose is not an equilibrium.")
@click.option(
    "--wrench-tolerance",
    metavar="X",
    default="1e-6",
    show_default=True,
    help="Residual, as a share of the weight, of a pose that counts as static.",
)
@json_option
@click.option("-q", "--quiet", is_flag=True, help="No table.")
@click.option("-v", "--verbose", is_flag=True, help="More about errors.")
def command(robot: str, **given: Any) -> int:
    """Return distances, cable lengths and tensions of ROBOT at a pose.

    The orientation is R = Rz(yaw) Ry(pitch) Rx(roll), or a quaternion. The lengths are printed with
    every digit, ready for --lengths of fk. Exit code 6: tensions are needed (elastic cables or
    --static) and none were found, or --settle found no static pose near enough; nothing is proved.
    """
    from solvers.commands.delta import is_delta, of_position

    target = None if given["json_file"] is None else JsonTarget(given["json_file"])
    if is_delta(robot):
        return of_position(robot, given, target)
    result = _solve(robot, given, target)
    if target is not None:
        target.write(result.to_json())
    if not given["quiet"] and (target is None or not target.is_stdout):
        click.echo(str(result))
    ending = _ending(result)
    if not ending and result.settling is not None and result.settling.angle > LARGE_TURN:
        turn = f"{degrees(result.settling.angle):.1f} deg"
        click.echo(f"warning: --settle turned the platform by {turn}", err=True)
    return ending


def _solve(source: str, given: dict[str, Any], target: JsonTarget | None) -> IkResult:
    from cdpr_interval.robots.formats.reader import load_robot
    from solvers.kinematics.inverse import answer_pose
    from solvers.questions.pose import read_pose

    errors = InputErrors()
    robot = errors.read(load_robot, source)
    pose = None
    if given["pose"] is None:
        errors.add("--pose: missing")
    else:
        pose = errors.read(read_pose, given["pose"], given["quaternion"])
    margin = errors.read(read_float, given["slack_margin"], "--slack-margin")
    tolerance = errors.read(read_float, given["wrench_tolerance"], "--wrench-tolerance")
    within = None
    if given["settle_within"] is not None:
        within = errors.read(read_distance, given["settle_within"], "--settle-within")
    force = read_external_force(given, errors)
    if target is not None:
        errors.read(target.require_writable)
    if robot is None:
        errors.require_none()
    assert robot is not None
    result = errors.read(
        answer_pose,
        robot,
        pose,
        taut=given["taut"],
        slack_margin=0.0 if margin is None else margin,
        settle=given["settle"],
        settle_within=within,
        static=given["static"],
        wrench_tolerance=1.0 if tolerance is None else tolerance,
        external_force=force,
        label=_option_name,
    )
    errors.require_none()
    assert result is not None
    say_middles(given["pose"], "--pose")
    warn_of_lengths(robot, [(distance, distance) for distance in result.distances], "--pose")
    return result


def _option_name(parameter: str) -> str:
    return "--" + parameter.replace("_", "-")


def _ending(result: IkResult) -> Ending:
    from solvers.cli import Ending, ExitCode

    found = result.lengths is not None and (result.is_static or not result.question.static)
    code = ExitCode.COMPLETE if found else ExitCode.NONE_FOUND
    return Ending(code, f"none found, nothing proved: {result.message}")
