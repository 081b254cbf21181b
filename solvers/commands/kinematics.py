"""``cdpr-solve kinematics``: Jacobian, speeds and singularities of a Delta, at a pose and over a box."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from solvers.commands.target import JsonTarget, json_option
from solvers.commands.time_limit import read_time_limit, time_limit_option
from solvers.questions.errors import InputErrors
from solvers.shell.completion import robot_argument
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from cdpr_interval.robots.delta import DeltaRobot
    from solvers.cli import Ending


@click.command(
    "kinematics",
    short_help="Jacobian, speeds and singularities of a Delta.",
    epilog=examples(
        "kinematics delta_580 --pose 0,0,-0.4 --rates 1,0,0",
        "kinematics delta_580 --pose 0,0,-0.4 --box 20mm,20mm,20mm",
    ),
)
@robot_argument
@click.option("--pose", metavar="X,Y,Z", help="Tool point in m; the arms are on their useful branch.")
@click.option("--velocity", metavar="VX,VY,VZ", help="Of the platform, m/s: prints the drives' speeds.")
@click.option("--rates", metavar="Q1,Q2,Q3", help="Of the drives, rad/s or m/s: prints the velocity.")
@click.option(
    "--box",
    metavar="DX,DY,DZ",
    help="Half widths in m of a box to be proved free of singularities.",
)
@time_limit_option("Stop looking at the box after so many seconds.")
@json_option
@click.option("-q", "--quiet", is_flag=True, help="No table.")
@click.option("-v", "--verbose", is_flag=True, help="More about errors.")
def command(robot: str, **given: Any) -> Ending:
    """Print Jacobian, conditioning, speeds and singularities of ROBOT at a pose, all of it enclosed.

    ROBOT is a Delta; robots with cables are not treated here yet. Exit code 0: all of it is proved; 3:
    something is not, or the box may hold a singular pose.
    """
    from solvers.answers.data import Outcome
    from solvers.cli import Ending, ExitCode
    from solvers.delta.kinematics import answer_kinematics

    target = None if given["json_file"] is None else JsonTarget(given["json_file"])
    errors = InputErrors()
    found: DeltaRobot | None = errors.read(_load, robot)
    limit = read_time_limit(given, errors)
    if target is not None:
        errors.read(target.require_writable)
    if given["pose"] is None:
        errors.add("--pose: missing")
    errors.require_none()
    assert found is not None
    asked = {name: given[name] for name in ("velocity", "rates", "box")}
    result = answer_kinematics(found, given["pose"], **asked, time_limit=limit, label=_option_name)
    if target is not None:
        target.write(result.to_json())
    if not given["quiet"] and (target is None or not target.is_stdout):
        click.echo(str(result))
    if result.outcome is Outcome.INCOMPLETE:
        return Ending(ExitCode.INCOMPLETE, f"not proved: {'; '.join(result.undecided)}")
    return Ending(ExitCode.COMPLETE, result.message)


def _load(source: str) -> DeltaRobot:
    from cdpr_interval.robots.formats.reader import load_delta

    return load_delta(source)


def _option_name(parameter: str) -> str:
    return "--pose" if parameter == "position" else "--" + parameter.replace("_", "-")
