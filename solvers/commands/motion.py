"""``cdpr-solve motion``: the static pose along lengths over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cdpr_interval.text.literal import printable
from solvers.commands.numbers import warn_of_lengths
from solvers.commands.target import JsonTarget
from solvers.commands.threads import read_threads, threads_option
from solvers.commands.time_limit import read_time_limit, time_limit_option
from solvers.questions.errors import InputErrors
from solvers.shell.completion import files, robot_argument
from solvers.shell.examples import examples
from solvers.shell.interrupt import interruptible

if TYPE_CHECKING:
    from fractions import Fraction

    from solvers.cli import Ending
    from solvers.motions.motion import MotionOptions, MotionProblem
    from solvers.motions.result import Motion


@click.command(
    "motion",
    short_help="The static pose along lengths over time: tubes, taut cables, switches, folds.",
    epilog=examples(
        "motion uc4 --lengths lengths.csv",
        "motion merlet_4_1 --lengths lengths.csv --tolerance 1mm --step 0.5 --plot motion.png",
    ),
)
@robot_argument
@click.option(
    "--lengths",
    required=True,
    metavar="FILE.csv",
    shell_complete=files,
    help="Times and lengths: a column t_s and one for each cable, linear between rows.",
)
@click.option(
    "--tolerance", default="0", metavar="D", help="Exact lengths count as known to this, in m or as 1mm."
)
@click.option(
    "--start",
    metavar="X,Y,Z",
    help="Start from the stable pose nearest to here.  [default: follow every stable pose of the first row]",
)
@click.option("--step", metavar="S", help="Longest segment in s.  [default: from row to row]")
@time_limit_option("Stop after so many seconds.")
@threads_option
@click.option(
    "--json",
    "json_file",
    metavar="FILE",
    shell_complete=files,
    help="Write the result as JSON; - is standard output.",
)
@click.option("--csv", "csv_file", metavar="FILE", shell_complete=files, help="Write the tubes as CSV.")
@click.option(
    "--plot",
    metavar="FILE",
    shell_complete=files,
    help="Draw taut cables over time and the path in its tube: .png, .svg or .pdf.",
)
@click.option("-q", "--quiet", is_flag=True, help="No table, no progress.")
def command(robot: str, **given: Any) -> int:
    """Follow the static pose of ROBOT along lengths over time, and prove it all along.

    Prints for every stretch of time which cables are taut, and bounds of the pose and the tensions; then when
    cables become slack or taut, and where a pose ends. Exit code 0: proved throughout; 3: not, the last line
    says until when; 4: proved that there is no stable pose at the start.
    """
    from solvers.commands.progress import shown
    from solvers.motions.motion import solve_motion

    problem, options, targets = _read(robot, given)
    as_json, as_csv = targets
    warn_of_lengths(problem.robot, problem.course.rows[0].lengths, "--lengths")
    with interruptible() as signals:
        with shown("motion", given["quiet"]) as display:
            options.progress = display
            result = solve_motion(problem, options)
        signals.hold()
        if as_json is not None:
            as_json.write(result.to_json())
        if as_csv is not None:
            as_csv.write(result.to_csv())
        if given["plot"] is not None:
            _draw(result, given["plot"], given["quiet"])
        if not given["quiet"] and not any(one is not None and one.is_stdout for one in targets):
            click.echo(str(result))
    return _ending(result)


def _read(
    source: str, given: dict[str, Any]
) -> tuple[MotionProblem, MotionOptions, tuple[JsonTarget | None, JsonTarget | None]]:
    """Return the checked question, or raise with every error of the command line and the files."""
    from cdpr_interval.robots.formats.reader import load_robot
    from solvers.motions.motion import MotionOptions, motion_problem

    errors = InputErrors()
    robot = errors.read(load_robot, source)
    tolerance = errors.read(_quantity, given["tolerance"], "--tolerance", "metres")
    near = None if given["start"] is None else errors.read(_place, given["start"])
    step = None if given["step"] is None else errors.read(_quantity, given["step"], "--step", "seconds")
    options = MotionOptions(read_time_limit(given, errors), read_threads(given, errors))
    as_json, as_csv = (
        None if given[name] is None else JsonTarget(given[name], option)
        for name, option in (("json_file", "--json"), ("csv_file", "--csv"))
    )
    for target in (as_json, as_csv):
        if target is not None:
            errors.read(target.require_writable)
    if as_json is not None and as_csv is not None and as_json.is_stdout and as_csv.is_stdout:
        errors.add("--csv: standard output is taken by --json")
    if given["plot"] is not None:
        errors.read(_require_plot, given["plot"])
    problem = None
    if robot is not None:
        problem = errors.read(motion_problem, robot, given["lengths"], tolerance or 0, near, step, _option)
    errors.require_none()
    assert problem is not None
    return problem, options, (as_json, as_csv)


def _option(parameter: str) -> str:
    return f"--{parameter}"


def _place(text: str) -> list[float]:
    """Return x, y and z in m."""
    from solvers.questions.pose import read_pose

    place: list[float] = read_pose(text, label="--start").position.tolist()
    return place


def _quantity(text: str, label: str, kind: str) -> Fraction:
    """Return an exact length in m or time in s."""
    from cdpr_interval.errors import InputError
    from solvers.questions import units

    read = units.read_metres if kind == "metres" else units.read_seconds
    try:
        return read(text.strip())
    except ValueError as error:
        raise InputError(f"{label}: {error}") from None


def _require_plot(name: str) -> None:
    """Raise `InputError` where a picture cannot be drawn, before anything is computed."""
    from solvers.report.motion_picture import require_picture

    require_picture(name, "--plot")


def _draw(result: Motion, name: str, quiet: bool) -> None:
    from solvers.report.motion_picture import motion_picture

    written: Path = motion_picture(result, name, "--plot")
    if not quiet:
        click.echo(f"picture {printable(str(written))}", err=True)


def _ending(result: Motion) -> Ending:
    """Return the exit code of a motion, and the line about it."""
    from solvers.answers.data import Outcome, StopReason
    from solvers.cli import Ending, ExitCode

    if result.stop_reason is StopReason.INTERRUPTED:
        return Ending(ExitCode.INTERRUPTED, result.message)
    if result.outcome is Outcome.INCOMPLETE:
        return Ending(ExitCode.INCOMPLETE, result.message)
    return Ending(ExitCode.NO_POSE if result.start is None else ExitCode.COMPLETE, result.message)
