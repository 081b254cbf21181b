"""``cdpr-solve report``: a result or a batch as one HTML file, and figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from solvers.commands.threads import read_threads, threads_option
from solvers.commands.time_limit import read_time_limit, time_limit_option
from solvers.shell.completion import files, robots
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from solvers.cli import Ending
    from solvers.commands.progress import ProgressDisplay
    from solvers.commands.target import JsonTarget
    from solvers.report.judgement import Judgement
    from solvers.report.source import ResultSource


OF_CABLES = ("robot", "certificate")
"""Options that have no meaning for the result of a Delta."""


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
    help="The robot of RESULT.  [default: the one in it]",
)
@click.option(
    "--certificate",
    metavar="FILE",
    shell_complete=files,
    help="Check this certificate of RESULT and say what came out.",
)
@click.option("--job", type=click.IntRange(min=1), metavar="N", help="Only this job of the batch in DIR.")
@threads_option
@time_limit_option("Most seconds for checking the certificate.", default="600")
@click.option("-q", "--quiet", is_flag=True, help="No progress.")
def command(source: str, out: str, figures: str | None, **given: Any) -> int:
    """Draw RESULT, a file of `fk --json FILE`, or DIR, the folder of a batch.

    The report shows the robot with every pose in 3-D, the table of poses, tensions, and always what was left
    undecided; of a batch the counts, statistics and distributions. Exit codes are those of
    its judgement: 3: something is left open, or the certificate proves a part; 5: not proved, or jobs failed;
    2: the certificate is none. The report is written then, too.
    """
    from cdpr_interval.errors import InputError
    from solvers.cli import Ending
    from solvers.commands.progress import shown
    from solvers.commands.target import JsonTarget
    from solvers.report.delta_page import is_delta_result
    from solvers.report.judgement import judge

    robot, certificate, job = given["robot"], given["certificate"], given["job"]
    limit, threads = read_time_limit(given), read_threads(given)
    target = JsonTarget(out, "--out")
    target.require_writable()
    folder = None if figures is None else Path(figures)
    path, is_batch = Path(source), Path(source).is_dir()
    if is_batch and (robot is not None or certificate is not None):
        raise InputError("--robot, --certificate: only for a result, a batch has its own with it")
    if not is_batch and job is not None:
        raise InputError("--job: only for the folder of a batch")
    if not is_batch and is_delta_result(path):
        return _delta(path, target, [name for name in OF_CABLES if given.get(name) is not None], figures)
    with shown("report", given["quiet"]) as display:
        if is_batch and job is None:
            page, judged = _batch(path, folder)
            target.write(page)
            return Ending(judged.exit_code, judged.headline)
        drawn = _source(path, given, limit, threads, display)
        if display is not None:
            display.stage("report")
        target.write(_result(drawn, folder))
    if drawn.proof is not None and drawn.proof.conclusion.exit_code:
        return Ending(drawn.proof.conclusion.exit_code, f"certificate: {drawn.proof}")
    judged = judge(drawn.result, drawn.proof)
    return Ending(judged.exit_code, judged.headline)


def _delta(path: Path, target: JsonTarget, given: list[str], figures: str | None) -> Ending:
    """Write the page of a Delta's result, which has neither certificate nor figures of its own."""
    from cdpr_interval.errors import InputError
    from solvers.cli import Ending
    from solvers.report.delta_page import delta_page
    from solvers.report.page import require_libraries

    if given or figures is not None:
        names = [*given, *(["figures"] if figures is not None else [])]
        raise InputError(*(f"--{name}: not for the result of a Delta" for name in names))
    require_libraries()
    page, judged = delta_page(path)
    target.write(page)
    return Ending(judged.exit_code, judged.headline)


def _source(
    path: Path, given: dict[str, Any], limit: float | None, threads: int, display: ProgressDisplay | None
) -> ResultSource:
    """Return the result that is drawn, its certificate checked."""
    from cdpr_interval.errors import InputError
    from solvers.batch.ledger_file import LedgerError
    from solvers.report.page import require_libraries
    from solvers.report.source import read_result, result_in_batch

    require_libraries()
    told = None if display is None else display.cells
    if given["job"] is None:
        return read_result(path, given["robot"], given["certificate"], limit, told, threads)
    try:
        return result_in_batch(path, given["job"], limit, told, threads)
    except LedgerError as error:
        raise InputError(str(error)) from None


def _result(source: ResultSource, folder: Path | None) -> str:
    from solvers.report.page import result_page

    if folder is not None:
        from solvers.report.figures import result_figures

        result_figures(source.robot, source.result, folder)
    return result_page(source)


def _batch(path: Path, folder: Path | None) -> tuple[str, Judgement]:
    from cdpr_interval.errors import InputError
    from solvers.batch.campaign import counted
    from solvers.batch.ledger import Ledger
    from solvers.batch.ledger_file import LedgerError
    from solvers.report.batch_page import batch_page, judgement_of
    from solvers.report.page import require_libraries

    require_libraries()
    try:
        with Ledger.peek(path) as ledger:
            summary = counted(ledger)
            if folder is not None:
                from solvers.report.figures import batch_figures

                batch_figures(ledger, summary, folder)
            return batch_page(ledger, summary), judgement_of(ledger, summary)
    except LedgerError as error:
        raise InputError(str(error)) from None
