"""``cdpr-solve check``: the independent checker of certificates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from solvers.commands.external_force import external_force_option
from solvers.commands.threads import read_threads, threads_option
from solvers.shell.completion import files, robots
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from cdpr_interval.robots.cable_robot import Robot
    from solvers.proofs.check import Asked

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
@click.option(
    "--time-limit",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="S",
    help="Stop after so many seconds.",
)
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
    from certificates.__main__ import MIB, Options, run
    from certificates.container import load
    from certificates.verdicts import Malformed

    question = _question(robot, given)
    limit = given["size_limit"] * MIB
    options = Options(
        given["sample"], given["seed"], read_threads(given), given["time_limit"], limit, given["quiet"]
    )
    if question is None:
        return run(file, options)
    from solvers.cli import ExitCode
    from solvers.proofs.check import other_question

    try:
        content = load(file, limit)
        other = other_question(content, limit, *question)
    except Malformed:
        return run(file, options)
    if other:
        click.echo(f"NOT PROVED: the certificate is of another question: {other}")
        return ExitCode.NOT_PROVED
    return run(content, options)


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
    return robot, Asked(lengths, force, taut, given["ignore_slack"], given["ignore_tension_sign"])
