"""``cdpr-solve check``: the independent checker of certificates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from solvers.commands.external_force import external_force_option
from solvers.commands.threads import read_threads, threads_option
from solvers.commands.time_limit import read_time_limit, time_limit_option
from solvers.shell.completion import files, robots
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from cdpr_interval.robots.cable_robot import Robot
    from certificates.verdicts import Report
    from solvers.proofs.check import Asked

MIB = 2**20
QUESTION = ("lengths", "external_force", "taut", "ignore_slack", "ignore_tension_sign")
"""Options that are about a robot."""


@click.command(
    "check",
    short_help="Check a certificate, without the solvers.",
    epilog=examples(
        "fk uc2 --lengths 7.5,8 --certificate uc2.cert",
        "check uc2.cert --robot uc2 --lengths 7.5,8",
    ),
)
@click.argument("file", shell_complete=files)
@click.option(
    "--robot", metavar="ROBOT", shell_complete=robots, help="The certificate must be about this robot."
)
@click.option("--lengths", metavar="L1,L2,...", help="And about these lengths, as `fk` reads them.")
@external_force_option
@click.option("--taut", metavar="C1,C2,...", help="And about this subset.  [default: the verdict names it]")
@click.option("--ignore-slack", is_flag=True, help="And about this question, as of `fk`.")
@click.option("--ignore-tension-sign", is_flag=True, help="And about this question, as of `fk`.")
@click.option(
    "--sample", type=click.IntRange(min=1), metavar="N", help="Check so many cells, chosen at random."
)
@click.option("--seed", type=int, metavar="S", help="Draw the sample that another check has printed.")
@threads_option
@time_limit_option("Stop after so many seconds.")
@click.option(
    "--size-limit",
    type=click.IntRange(min=1),
    default=64,
    show_default=True,
    metavar="MIB",
    help="Largest file and document.",
)
@click.option("-q", "--quiet", is_flag=True, help="The verdict only.")
def command(file: str, robot: str | None, **given: Any) -> int:
    """Check a certificate that `fk --certificate FILE` has written.

    The checker shares no code with the solvers; `python -m certificates FILE` does the same, but that it
    reads no robots to compare with. Exit code 0: proved, nothing left open; 3: in part, or not all was
    checked; 5: not proved, or of another robot or question; 2: no certificate.
    """
    from certificates.verdicts import Conclusion
    from solvers.cli import Ending

    question = _question(robot, given)
    limit = given["size_limit"] * MIB
    content: str | bytes = file
    if question is not None:
        content, other = _compared(file, limit, question)
        if other:
            conclusion = Conclusion.NOT_PROVED
            click.echo(f"{conclusion}: the certificate is of another question: {other}")
            return Ending(conclusion.exit_code, f"{conclusion}: it is the proof of something else")
    report = _check(content, limit, given)
    for line in report.lines()[: 1 if given["quiet"] else None]:
        click.echo(line)
    return Ending(report.conclusion.exit_code, report.conclusion.remark)


def _check(content: str | bytes, limit: int, given: dict[str, Any]) -> Report:
    from certificates.checker import check
    from solvers.commands.progress import shown

    with shown("check", given["quiet"]) as display:
        return check(
            content,
            sample=given["sample"],
            seed=given["seed"],
            threads=read_threads(given),
            time_limit=read_time_limit(given),
            size_limit=limit,
            progress=None if display is None else display.cells,
        )


def _compared(file: str, limit: int, question: tuple[Robot, Asked]) -> tuple[str | bytes, str]:
    """Return the certificate, and in what it differs from a question; what is none, the checker says."""
    from certificates.container import load
    from certificates.verdicts import Malformed
    from solvers.proofs.check import other_question

    try:
        content = load(file, limit)
        return content, other_question(content, limit, *question)
    except Malformed:
        return file, ""


def _question(source: str | None, given: dict[str, Any]) -> tuple[Robot, Asked] | None:
    """Return what the certificate must be about, None: anything; or raise with every error of the options."""
    from solvers.questions.errors import InputErrors

    errors = InputErrors()
    if source is None:
        for name in QUESTION:
            if given[name] not in (None, False):
                errors.add(f"--{name.replace('_', '-')}: only with --robot")
        errors.require_none()
        return None
    from cdpr_interval.robots.formats.reader import load_robot
    from solvers.proofs.check import Asked
    from solvers.questions.force import ZERO, read_force
    from solvers.questions.lengths import read_lengths
    from solvers.questions.subset import read_subset

    robot = errors.read(load_robot, source)
    lengths = taut = None
    if robot is not None and given["lengths"] is not None:
        lengths = errors.read(read_lengths, given["lengths"], robot.cable_names, "--lengths")
    if robot is not None and given["taut"] is not None:
        taut = errors.read(read_subset, given["taut"], robot.cable_names, "--taut")
    force = ZERO
    if given["external_force"] is not None:
        force = errors.read(read_force, given["external_force"], "--external-force") or ZERO
    errors.require_none()
    assert robot is not None
    any_sign = given["ignore_tension_sign"] or robot.has_legs
    return robot, Asked(lengths, force, taut, given["ignore_slack"], any_sign)
