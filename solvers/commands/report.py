"""``cdpr-solve report``: a result or a batch as one HTML file, and figures."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("report", short_help="A result or a batch as one HTML file people look at.")
@click.argument("source", metavar="RESULT|DIR")
@click.option("--out", required=True, metavar="FILE", help="The HTML file; it needs nothing else.")
@click.option("--figures", metavar="DIR", help="Write the figures as PNG and SVG too.")
@click.option("--robot", metavar="FILE", help="The robot of RESULT.  [default: the shipped one it names]")
@click.option("--certificate", metavar="FILE", help="Check this certificate of RESULT and say what came out.")
def command(source: str, out: str, figures: str | None, robot: str | None, certificate: str | None) -> int:
    """Draw RESULT, a file of `fk --json FILE`, or DIR, the folder of a batch.

    The report shows the robot with every pose in 3-D, the table of poses, tensions, and always what was left
    undecided; of a batch the counts, statistics and distributions.
    """
    from cdpr_interval.errors import InputError
    from solvers.json_target import JsonTarget

    target = JsonTarget(out, "--out")
    target.require_writable()
    folder = None if figures is None else Path(figures)
    if Path(source).is_dir():
        if robot is not None or certificate is not None:
            raise InputError("--robot, --certificate: only for a result, a batch has its robots with it")
        text = _batch(Path(source), folder)
    else:
        text = _result(Path(source), robot, certificate, folder)
    target.write(text)
    return 0


def _result(path: Path, robot: str | None, certificate: str | None, folder: Path | None) -> str:
    from solvers.report.page import result_page
    from solvers.report.plots import require_plotly
    from solvers.report.source import read_result

    require_plotly()
    source = read_result(path, robot, certificate)
    if folder is not None:
        from solvers.report.figures import result_figures

        result_figures(source.robot, source.result, folder)
    return result_page(source)


def _batch(path: Path, folder: Path | None) -> str:
    from cdpr_interval.errors import InputError
    from solvers.batch.campaign import summary_of
    from solvers.batch.ledger import Ledger, LedgerError
    from solvers.report.page import batch_page, quantities
    from solvers.report.plots import require_plotly

    require_plotly()
    try:
        with Ledger.peek(path) as ledger:
            if folder is not None:
                from solvers.report.figures import batch_figures

                batch_figures(quantities(ledger)[0], folder)
            return batch_page(ledger, summary_of(ledger))
    except LedgerError as error:
        raise InputError(str(error)) from None
