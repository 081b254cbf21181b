"""``cdpr-solve polynomial``: the eliminant of some taut cables, its roots, a cross-check with `fk`."""

from __future__ import annotations

from typing import Any

import click

from solvers.commands.external_force import external_force_option, read_external_force
from solvers.commands.target import JsonTarget
from solvers.commands.threads import read_threads, threads_option
from solvers.commands.time_limit import read_time_limit, time_limit_option
from solvers.shell.completion import files, robot_argument
from solvers.shell.examples import examples


@click.command(
    "polynomial",
    short_help="The exact polynomials of a subset of taut cables, compared with fk.",
    epilog=examples("polynomial merlet_4_1 --lengths 2.7,3.9,3.4,4.4 --taut c1,c2"),
)
@robot_argument
@click.option("--lengths", metavar="L1,L2,...", help="Cable lengths in m, file order, or c1=L1,c2=L2,...")
@click.option("--tensions", metavar="T1,T2,...", help="Tensions in N of the taut cables, file order.")
@external_force_option
@click.option("--taut", metavar="C1,C2,...", help="The taut cables.  [default: all]")
@click.option(
    "--given",
    type=click.Choice(["lengths", "tensions"]),
    help="What is known.  [default: what is given]",
)
@click.option(
    "--latex",
    "latex_file",
    metavar="FILE",
    shell_complete=files,
    help="Write the derivation as a LaTeX document.",
)
@click.option(
    "--json",
    "json_file",
    metavar="FILE",
    shell_complete=files,
    help="Write the report as JSON; - is standard output.",
)
@threads_option
@time_limit_option("Stop after so many seconds.")
@click.option("-q", "--quiet", is_flag=True, help="No report; the exit code says whether fk agrees.")
def command(robot: str, **given: Any) -> int:
    """Derive the polynomial system of ROBOT's taut cables and its eliminant, exactly.

    Prints degrees, factors (true or extraneous, and how that was decided), real solutions and
    whether `fk` finds the same static poses. Point masses: elastic cables 1 to 4, inextensible ones 1 to 3,
    given tensions 1 to 4; platforms: two cables. Exit code 0: fk agrees; 3: not decided; 5: it does not.
    """
    from cdpr_interval.errors import InputError
    from cdpr_interval.robots.formats.reader import load_robot
    from solvers.answers.json_text import dumps
    from solvers.cli import Ending, ExitCode
    from solvers.commands.progress import shown
    from solvers.polynomial import polynomial_report
    from solvers.questions.errors import InputErrors
    from solvers.shell.interrupt import OutOfTime, limited

    errors = InputErrors()
    targets = [None if given[name] is None else JsonTarget(given[name], option) for name, option in OUTPUTS]
    model = errors.read(load_robot, robot)
    if given["given"] is not None and given[given["given"]] is None:
        errors.add(f"--{given['given']}: missing, --given {given['given']} needs it")
    force = read_external_force(given, errors)
    threads, limit = read_threads(given, errors), read_time_limit(given, errors)
    for target in targets:
        if target is not None:
            errors.read(target.require_writable)
    errors.require_none()
    assert model is not None
    if given["lengths"] is None and given["tensions"] is None:
        raise InputError("--lengths: missing (or --tensions)")
    if given["lengths"] is not None and given["tensions"] is not None:
        raise InputError("--lengths: not together with --tensions")
    try:
        with shown("polynomial", given["quiet"]), limited(limit):
            report = polynomial_report(
                model,
                given["lengths"],
                tensions=given["tensions"],
                taut=given["taut"],
                external_force=force,
                threads=threads,
            )
    except OutOfTime:
        return Ending(ExitCode.INCOMPLETE, "stopped at the time limit: there is no eliminant yet")
    as_json, as_latex = targets
    if as_latex is not None:
        as_latex.write(report.latex())
    if as_json is not None:
        as_json.write(dumps(report.to_dict()))
    if not given["quiet"] and not (as_json is not None and as_json.is_stdout):
        click.echo("\n".join(report.lines()))
    agrees = report.comparison.agrees
    code = ExitCode.INCOMPLETE if agrees is None else ExitCode.COMPLETE if agrees else ExitCode.NOT_PROVED
    return Ending(code, f"agreement with fk: {report.comparison.text}")


OUTPUTS = (("json_file", "--json"), ("latex_file", "--latex"))
