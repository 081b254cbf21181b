"""``cdpr-solve check``: the independent checker of certificates."""

from __future__ import annotations

import click


@click.command("check", short_help="Check a certificate, without the solvers.")
@click.argument("file")
@click.option(
    "--sample", type=click.IntRange(min=1), metavar="N", help="Check so many cells, chosen at random."
)
@click.option("--jobs", type=click.IntRange(min=1), default=1, metavar="N", help="Number of processes.")
@click.option(
    "--time-limit",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="S",
    help="Stop after so many seconds.",
)
@click.option("-q", "--quiet", is_flag=True, help="The verdict only.")
def command(file: str, sample: int | None, jobs: int, time_limit: float | None, quiet: bool) -> int:
    """Check a certificate that `fk --certificate FILE` has written.

    The checker shares no code with the solvers; `python -m certificates FILE` does the same. Exit
    code 0: proved; 5: not proved; 2: no certificate; 3: not all was checked.
    """
    from certificates.__main__ import run

    return run(file, sample, jobs, time_limit, quiet)
