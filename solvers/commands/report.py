"""``cdpr-solve report``: a result or a batch as one HTML file, and figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from solvers.shell.completion import files, robots
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from solvers.report.source import ResultSource


@click.command(
    "report",
    short_help="A result or a batch as one HTML file people look at.",
    epilog=examples(
        "fk uc2 --lengths 7.5,8 --json uc2.json",
        "report uc2.json --out uc2.html",
    ),
)
@click.argument("source", metavar="RESULT|DIR", shell_complete=files)
@click.option(
    "--out", required=True, metavar="FILE", shell_complete=files, help="The HTML file; it needs nothing else."
)
@click.option(
    "--figures", metavar="DIR|X.pdf", help="Write the figures too: as PNG and SVG, or as pages of a PDF."
)
@click.option(
    "--robot",
    metavar="FILE",
    shell_complete=robots,
    help="The robot of RESULT.  [default: the shipped one it names]",
)
@click.option(
    "--certificate",
    metavar="FILE",
    shell_complete=files,
    help="Check this certificate of RESULT and say what came out.",
)
@click.option("--job", type=click.IntRange(min=1), metavar="N", help="Only this job of the batch in DIR.")
def command(
    source: str, out: str, figures: str | None, robot: str | None, certificate: str | None, job: int | None
) -> int:
    """Draw RESULT, a file of `fk --json FILE`, or DIR, the folder of a batch.

    The report shows the robot with every pose in 3-D, the table of poses, tensions, and always what was left
    undecided; of a batch the counts, statistics and distributions. Exit code 5: the certificate is not
    proved.
    """
    from cdpr_interval.errors import InputError
    from solvers.cli import ExitCode
    from solvers.commands.target import JsonTarget

    target = JsonTarget(out, "--out")
    target.require_writable()
    folder = None if figures is None else Path(figures)
    path, is_batch = Path(source), Path(source).is_dir()
    if is_batch and (robot is not None or certificate is not None):
        raise InputError("--robot, --certificate: only for a result, a batch has its own with it")
    if not is_batch and job is not None:
        raise InputError("--job: only for the folder of a batch")
    if is_batch and job is None:
        target.write(_batch(path, folder))
        return ExitCode.COMPLETE
    drawn = _job(path, job) if job is not None else _read(path, robot, certificate)
    target.write(_result(drawn, folder))
    return ExitCode.NOT_PROVED if drawn.proof is not None and drawn.proof.is_refused else ExitCode.COMPLETE


def _read(path: Path, robot: str | None, certificate: str | None) -> ResultSource:
    from solvers.report.page import require_libraries
    from solvers.report.source import read_result

    require_libraries()
    return read_result(path, robot, certificate)


def _job(path: Path, number: int) -> ResultSource:
    from cdpr_interval.errors import InputError
    from solvers.batch.ledger_file import LedgerError
    from solvers.report.page import require_libraries
    from solvers.report.source import result_in_batch

    require_libraries()
    try:
        return result_in_batch(path, number)
    except LedgerError as error:
        raise InputError(str(error)) from None


def _result(source: ResultSource, folder: Path | None) -> str:
    from solvers.report.page import result_page

    if folder is not None:
        from solvers.report.figures import result_figures

        result_figures(source.robot, source.result, folder)
    return result_page(source)


def _batch(path: Path, folder: Path | None) -> str:
    from cdpr_interval.errors import InputError
    from solvers.batch.campaign import counted
    from solvers.batch.ledger import Ledger
    from solvers.batch.ledger_file import LedgerError
    from solvers.report.batch_page import batch_page
    from solvers.report.page import require_libraries

    require_libraries()
    try:
        with Ledger.peek(path) as ledger:
            summary = counted(ledger)
            if folder is not None:
                from solvers.report.figures import batch_figures

                batch_figures(ledger, summary, folder)
            return batch_page(ledger, summary)
    except LedgerError as error:
        raise InputError(str(error)) from None
