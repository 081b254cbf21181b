"""``cdpr-solve ik``: distances, lengths and tensions for a pose."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import click

from solvers.commands.external_force import external_force_option, read_external_force
from solvers.commands.numbers import read_float
from solvers.commands.target import JsonTarget
from solvers.questions.errors import InputErrors

if TYPE_CHECKING:
    from solvers.answers.inverse import IkResult
    from solvers.cli import Ending


@click.command("ik", short_help="Distances, lengths and tensions for a pose.")
@click.argument("robot")
@click.option(
    "--pose", metavar="X,Y,Z[,R,P,Y]", help="Platform origin in m; roll, pitch, yaw in rad or as 30deg."
)
@click.option("--quaternion", metavar="W,X,Y,Z", help="Orientation, scalar first, platform to base.")
@click.option("--taut", metavar="C1,C2,...", help="The cables that may carry tension.  [default: all]")
@click.option(
    "--slack-margin", metavar="X", default="0.05", show_default=True, help="How much longer the others are."
)
@external_force_option
@click.option("--settle", is_flag=True, help="First move to the nearest static pose of the taut cables.")
@click.option("--static", is_flag=True, help="Exit with 6 when the pose is not an equilibrium.")
@click.option(
    "--wrench-tolerance",
    metavar="X",
    default="1e-6",
    show_default=True,
    help="Residual, as a share of the weight, of a pose that counts as static.",
)
@click.option("--json", "json_file", metavar="FILE", help="Write the result as JSON; - is standard output.")
@click.option("-q", "--quiet", is_flag=True, help="No table.")
@click.option("-v", "--verbose", is_flag=True, help="More about errors.")
def command(robot: str, **given: Any) -> int:
    """Return distances, cable lengths and tensions of ROBOT at a pose.

    The orientation is R = Rz(yaw) Ry(pitch) Rx(roll), or a quaternion. The lengths are printed with
    every digit, ready for --lengths of fk. Exit code 6: tensions are needed (elastic cables or
    --static) and the pose is not an equilibrium; 3: --settle found no static pose.
    """
    target = None if given["json_file"] is None else JsonTarget(given["json_file"])
    result = _solve(robot, given, target)
    if target is not None:
        target.write(result.to_json())
    if not given["quiet"] and (target is None or not target.is_stdout):
        _print(result)
    return _ending(result)


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
        static=given["static"],
        wrench_tolerance=1.0 if tolerance is None else tolerance,
        external_force=force,
        label=_option_name,
    )
    errors.require_none()
    assert result is not None
    return result


def _option_name(parameter: str) -> str:
    return "--" + parameter.replace("_", "-")


def _ending(result: IkResult) -> Ending:
    from solvers.cli import Ending, ExitCode

    found = result.lengths is not None and (result.is_static or not result.question.static)
    settled = result.settling is None or result.settling.succeeded
    code = ExitCode.NONE_FOUND if not found else ExitCode.COMPLETE if settled else ExitCode.INCOMPLETE
    return Ending(code, result.message)


def _print(result: IkResult) -> None:
    """Print the table: short numbers to read, then the lengths with every digit to paste."""
    from math import degrees

    write = sys.stdout.write
    place = ", ".join(f"{x:z.6f}" for x in result.position)
    angles = ", ".join(f"{degrees(angle):z.4f}" for angle in result.rpy)
    write(f"{result.robot[0]} ({result.model}): {result.message}\n")
    write(
        f"position ({place}) m"
        + ("\n" if result.model == "point-mass" else f", roll pitch yaw ({angles}) deg\n")
    )
    width = max(len("cable"), *(len(name) for name in result.cables))
    write(f"{'cable':{width}}  {'distance m':>12}  {'length m':>12}  {'tension N':>12}\n")
    for i, name in enumerate(result.cables):
        length = "-" if result.lengths is None else f"{result.lengths[i]:.6f}"
        limits = "  outside its limits" if name in result.outside_tension_limits else ""
        write(
            f"{name:{width}}  {result.distances[i]:12.6f}  {length:>12}  {result.tensions[i]:12.4f}{limits}\n"
        )
    if result.lengths_option is not None:
        write(f"--lengths {result.lengths_option}\n")
    sys.stdout.flush()
