"""``cdpr-solve fk``: every static pose for given cable lengths."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import click

from cdpr_interval.text.count import counted
from solvers.commands.external_force import LABEL, external_force_option, read_external_force
from solvers.commands.numbers import read_count, read_float, warn_of_lengths
from solvers.commands.target import JsonTarget, json_option
from solvers.commands.threads import read_threads, threads_option
from solvers.commands.time_limit import read_time_limit, time_limit_option
from solvers.questions.errors import InputErrors
from solvers.shell.completion import files, robot_argument
from solvers.shell.examples import examples
from solvers.shell.interrupt import interruptible

if TYPE_CHECKING:
    from cdpr_interval.robots.cable_robot import Robot
    from solvers.answers.result import Result
    from solvers.cli import Ending
    from solvers.questions.problem import Options, Problem

WITHOUT_TENSIONS = ("lengths", "problem", "certificate", "ignore_slack", "ignore_tension_sign", "tension")
"""Options that make no sense where tensions are given."""
MOST_CABLES = 64
"""Of a robot in a certificate."""


@click.command(
    "fk",
    short_help="Every static pose for given cable lengths.",
    epilog=examples(
        "fk uc2 --lengths 7.5,8 --certificate uc2.cert",
        "fk merlet_4_1 --lengths c1=2692.6mm,c2=3.905,c3=3.354,c4=4.4 --json -",
        "fk merlet_4_1 --lengths 2.69+-0.01,3.9+-0.01,3.35+-0.01,4.5",
    ),
)
@robot_argument
@click.option("--lengths", metavar="L1,L2,...", help="Cable lengths in m, file order, or c1=L1,c2=L2,...")
@click.option("--angles", metavar="A1,A2,A3", help="Angles of the arms of a Delta: 30deg,30deg,30deg.")
@click.option("--positions", metavar="S1,S2,S3", help="Positions in m of the carriages of a Delta.")
@click.option("--tensions", metavar="T1,T2,...", help="Tensions in N instead of lengths, of a point mass.")
@click.option(
    "--problem",
    metavar="FILE",
    shell_complete=files,
    help="Lengths and external force from a cdpr-problem/1 file.",
)
@external_force_option
@click.option("--taut", metavar="C1,C2,...", help="One subset of taut cables instead of all subsets.")
@click.option("--ignore-slack", is_flag=True, help="Keep poses whose other cables are not slack.")
@click.option("--ignore-tension-sign", is_flag=True, help="Six taut cables as rigid legs.")
@click.option(
    "--tension", metavar="LO..HI", help="Only poses whose taut cables have tensions in these limits, N."
)
@click.option(
    "--method", default="auto", show_default=True, metavar="auto|search|convex", help="For a point mass."
)
@click.option(
    "--precision",
    default="1e-9",
    show_default=True,
    metavar="X",
    help="Target width of the position in m and the rotation entries of a solution, exact input. Kept in the"
    " result; boxes are always as narrow as doubles make them, so it changes nothing yet.",
)
@time_limit_option("Stop after so many seconds.")
@click.option("--cell-limit", metavar="N", help="Stop after so many cells.")
@threads_option
@json_option
@click.option(
    "--certificate", metavar="FILE", shell_complete=files, help="Write the proof to a file and check it."
)
@click.option("--no-check", is_flag=True, help="Write it only, for `check`.")
@click.option("-q", "--quiet", is_flag=True, help="No table, no progress.")
@click.option("-v", "--verbose", is_flag=True, help="More about what is done, and about errors.")
def command(robot: str, **given: Any) -> int:
    """Find and prove every static pose of ROBOT for the given cable lengths.

    A length may be a number in m, 2.69+-0.01, 2.68..2.70 or [2.68,2.70], or have its unit, 2690mm;
    lengths of elastic cables are unstretched. Exit code 0: all poses found; 3: something is left
    undecided, or the certificate leaves something open or was not checked in time; 4: proved that there
    is none; 5: the checker refuses the certificate.
    """
    target = None if given["json_file"] is None else JsonTarget(given["json_file"])
    if _is_of_drives(robot, given):
        from solvers.commands.delta import of_drives

        return of_drives(robot, given, target)
    if given["tensions"] is not None:
        return _of_tensions(robot, given, target)
    certificate = None if given["certificate"] is None else JsonTarget(given["certificate"], "--certificate")
    problem, options = _read(robot, given, target, certificate)
    warn_of_lengths(problem.robot, problem.lengths, "--lengths" if given["problem"] is None else "--problem")
    with interruptible() as signals:
        result = _solve(problem, options, quiet=given["quiet"])
        signals.hold()
        try:
            if target is not None:
                target.write(result.to_json())
        finally:
            # Even when the disk is full, what was computed is shown.
            _show(result, table=not given["quiet"] and (target is None or not target.is_stdout))
        ending = _ending(result)
        if certificate is not None:
            from solvers.commands.certified import certify, ended

            quiet, checks = given["quiet"], not given["no_check"]
            found = certify(problem, options, result, certificate, signals, quiet=quiet, checks=checks)
            ending = ended(ending, found, given["certificate"], quiet)
    if given["verbose"]:
        _log(result)
    return ending


def _is_of_drives(source: str, given: dict[str, Any]) -> bool:
    """Return True where drives of a Delta are given, or nothing at all for a Delta."""
    if given["angles"] is not None or given["positions"] is not None:
        return True
    if any(given[name] is not None for name in ("lengths", "problem", "tensions")):
        return False
    from solvers.commands.delta import is_delta

    return is_delta(source)


def _of_tensions(source: str, given: dict[str, Any], target: JsonTarget | None) -> int:
    """Find the pose for given tensions: a convex problem, without search, budgets and certificate."""
    from cdpr_interval.robots.formats.reader import load_robot
    from solvers.tensions import solve_tensions, tension_problem

    errors = InputErrors()
    robot = errors.read(load_robot, source)
    for name in WITHOUT_TENSIONS:
        if given[name] not in (None, False):
            errors.add(f"{_option_name(name)}: not together with --tensions")
    if target is not None:
        errors.read(target.require_writable)
    force = read_external_force(given, errors, ranges=True)
    question = None
    if robot is not None:
        question = errors.read(tension_problem, robot, given["tensions"], given["taut"], force)
    errors.require_none()
    assert question is not None
    result = solve_tensions(question)
    if target is not None:
        target.write(result.to_json())
    _show(result, table=not given["quiet"] and (target is None or not target.is_stdout))
    return _ending(result)


def _read(
    source: str, given: dict[str, Any], target: JsonTarget | None, certificate: JsonTarget | None
) -> tuple[Problem, Options]:
    """Return the checked question, or raise with every error of the command line and the files."""
    from cdpr_interval.robots.formats.reader import load_robot
    from solvers.questions.checked import require_certifiable
    from solvers.questions.problem import asked_of

    errors = InputErrors()
    robot = errors.read(load_robot, source)
    options = errors.read(_options, given)
    problem = None
    if given["lengths"] is None and given["problem"] is None:
        errors.add("--lengths: missing (or --problem FILE)")
    elif given["lengths"] is not None and given["problem"] is not None:
        errors.add("--lengths: not together with --problem, which holds the lengths")
    elif robot is not None:
        problem = errors.read(_problem, robot, given, options)
    if target is not None:
        errors.read(target.require_writable)
    if given["no_check"] and certificate is None:
        errors.add("--no-check: only with --certificate")
    if certificate is not None:
        if certificate.is_stdout:
            errors.add("--certificate: must be a file")
        errors.read(certificate.require_writable)
        if target is not None and target.is_same(certificate):
            errors.add("--certificate: not the file of --json")
        if given["tension"] is not None:
            errors.add("--tension: not together with --certificate, which is about poses with any tensions")
        if robot is not None and len(robot.cables) > MOST_CABLES:
            errors.add(f"--certificate: for at most {MOST_CABLES} cables")
    errors.require_none()
    assert problem is not None and options is not None
    options = asked_of(problem.robot, options)
    if certificate is not None:
        require_certifiable(problem)
    return problem, options


def _options(given: dict[str, Any]) -> Options:
    from solvers.questions.checked import read_method
    from solvers.questions.problem import Method, Options
    from solvers.six_dof.record import Record

    errors = InputErrors()
    method = errors.read(read_method, given["method"], "--method")
    precision = errors.read(read_float, given["precision"], "--precision")
    cells = given["cell_limit"]
    options = Options(
        ignore_slack=given["ignore_slack"],
        ignore_tension_sign=given["ignore_tension_sign"],
        method=method or Method.AUTO,
        precision=1e-9 if precision is None else precision,
        time_limit=read_time_limit(given, errors),
        cell_limit=None if cells is None else errors.read(read_count, cells, "--cell-limit"),
        threads=read_threads(given, errors),
        record=None if given["certificate"] is None else Record(),
    )
    errors.require_none()
    return options


def _problem(robot: Robot, given: dict[str, Any], options: Options | None) -> Problem:
    from solvers.forward import pose_problem
    from solvers.questions.problem import Options
    from solvers.questions.problem_file import read_problem_file

    errors = InputErrors()
    lengths, force = given["lengths"], read_external_force(given, errors, ranges=True)
    if given["problem"] is not None:
        lengths, of_file = errors.read(read_problem_file, given["problem"], robot.cable_names) or (None, None)
        if of_file is not None and given["external_force"] is not None:
            errors.add(f"{LABEL}: not together with external_force_N of --problem")
        force = of_file if force is None else force
    errors.require_none()
    return pose_problem(
        robot, lengths, given["taut"], force, options or Options(), _option_name, given["tension"]
    )


def _option_name(parameter: str) -> str:
    return "--" + parameter.replace("_", "-")


def _solve(problem: Problem, options: Options, quiet: bool) -> Result:
    from dataclasses import replace

    from solvers.commands.progress import shown
    from solvers.forward import answer_question

    with shown("search", quiet) as display:
        return answer_question(problem, replace(options, progress=display))


def _show(result: Result, table: bool) -> None:
    from solvers.answers.table import print_result

    if table:
        print_result(result, sys.stdout)


def _log(result: Result) -> None:
    for subset in result.subsets:
        names = ",".join(result.cables[i] for i in subset.taut)
        found, cells = counted(subset.solutions, "solution"), counted(subset.cells, "cell")
        click.echo(f"{names}: {subset.outcome}, {found}, {cells}, {subset.time:.3f} s", err=True)
    cost = result.statistics
    cells, threads = counted(cost.cells, "cell"), counted(cost.threads, "thread")
    click.echo(f"{cells}, {cost.time:.3f} s, {threads}", err=True)
    click.echo(str(result.provenance), err=True)


def _ending(result: Result) -> Ending:
    """Return the exit code of an answer, and the line about it."""
    from solvers.answers.data import Outcome, StopReason
    from solvers.cli import Ending, ExitCode

    if result.stop_reason is StopReason.INTERRUPTED:
        return Ending(ExitCode.INTERRUPTED, result.message)
    if result.outcome is Outcome.INCOMPLETE:
        return Ending(ExitCode.INCOMPLETE, result.message)
    return Ending(ExitCode.COMPLETE if result.solutions else ExitCode.NO_POSE, result.message)
