"""``cdpr-solve batch``: many problems, a ledger, workers here or on a cluster, tables at the end."""

from __future__ import annotations

import json
import os
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from solvers.commands.interrupt import interruptible
from solvers.commands.threads import read_threads, threads_option
from solvers.shell.completion import files, folders
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from solvers.batch.executor import Executor
    from solvers.batch.ledger import CheckRow, Ledger
    from solvers.batch.run import BatchProgress

SHOWN = 10
"""Failed jobs that are listed."""
PROVED = "PROVED"
"""The verdict that leaves nothing open."""
RUN = "run"
"""The command that is meant when none is named."""


class Batches(click.Group):
    """``batch JOBS.yaml`` is ``batch run JOBS.yaml``; what cannot be used is one line, code 3."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the name of the usual command where none is."""
        if not args:
            args = ["--help"]
        own = (*self.commands, "-h", "--help")
        if args[0] not in own and not self._is_misspelt(args[0]):
            args = [RUN, *args]
        return super().parse_args(ctx, args)

    def _is_misspelt(self, word: str) -> bool:
        """Return whether a word is no file and looks like a command: click then says which."""
        import difflib

        from cdpr_interval.robots.shipped import SUFFIXES

        if word.endswith(SUFFIXES) or os.path.lexists(word):
            return False
        return bool(difflib.get_close_matches(word, self.commands))

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command."""
        from cdpr_interval.errors import CdprError, InputError, NotSupportedError
        from solvers.cli import ExitCode

        try:
            return super().invoke(ctx)
        except (InputError, NotSupportedError):
            raise
        except CdprError as error:
            click.echo(str(error), err=True)
            return ExitCode.INCOMPLETE


@click.group(
    "batch",
    cls=Batches,
    short_help="Many problems at once, with a ledger.",
    epilog=examples("batch jobs.yaml --dry-run", "batch jobs.yaml --out run", "batch status run"),
)
def command() -> None:
    """Solve many problems: `cdpr-solve batch JOBS.yaml --out DIR`.

    A batch that was killed goes on with `batch resume DIR`. Exit code 0: every job is done and complete;
    3: something is left undecided or pending; 5: some jobs failed or crashed.
    """


_OPTIONS = (
    threads_option,
    click.option("--scheduler", metavar="ADDRESS", help="Instead: a Dask scheduler, e.g. tcp://host:8786."),
    click.option("--scheduler-file", metavar="FILE", help="Instead: the file a Dask scheduler has written."),
    click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON."),
    click.option("-q", "--quiet", is_flag=True, help="No table, no progress."),
)


def _working(function: Any) -> Any:
    """Give a command the options of those that solve."""
    for option in reversed(_OPTIONS):
        function = option(function)
    return function


@command.command(RUN, epilog=examples("batch run jobs.yaml --out run"))
@click.argument("jobs", shell_complete=files)
@click.option("--out", "folder", metavar="DIR", shell_complete=folders, help="Folder of ledger and tables.")
@click.option("--dry-run", is_flag=True, help="Count the jobs and estimate their time; write nothing.")
@_working
def run(jobs: str, folder: str | None, dry_run: bool, **given: Any) -> int:
    """Solve the problems of a job file; a folder that holds this batch already is gone on with."""
    from cdpr_interval.errors import InputError
    from solvers.batch.campaign import begin
    from solvers.batch.job_file import read_job_file

    batch = read_job_file(jobs)
    if dry_run:
        return _estimate(batch, read_threads(given))
    if folder is None:
        raise InputError("--out: missing, the folder of ledger and tables")
    with begin(batch, Path(folder)) as ledger:
        return _proceed(ledger, given)


@command.command("resume", epilog=examples("batch resume run --retry-failed"))
@click.argument("folder", metavar="DIR", shell_complete=folders)
@click.option("--retry-failed", is_flag=True, help="Try failed and crashed jobs again.")
@_working
def resume(folder: str, retry_failed: bool, **given: Any) -> int:
    """Go on with a batch that was stopped or killed; what is recorded is not done again."""
    from solvers.answers.tool import this_tool
    from solvers.batch.ledger import Ledger

    with Ledger.open(Path(folder), this_tool().version) as ledger:
        if retry_failed:
            ledger.reopen()
        return _proceed(ledger, given)


@command.command("status", epilog=examples("batch status run --json"))
@click.argument("folder", metavar="DIR", shell_complete=folders)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def status(folder: str, as_json: bool) -> int:
    """Show how far a batch is, also while it runs."""
    from solvers.batch.job_file import block_of
    from solvers.batch.ledger import Ledger
    from solvers.batch.progress_line import duration
    from solvers.batch.work import Status

    with Ledger.peek(Path(folder)) as ledger:
        counts, everything = ledger.counts(), ledger.counts(with_parts=True)
        ended, seconds = ledger.seconds()
        facts = {key: ledger.fact(key) for key in ("version", "created")}
        name = block_of(ledger.fact("job_file")).name
        bad = list(ledger.recorded((Status.FAILED, Status.CRASHED)))
        undecided = ledger.incomplete()
    total = sum(counts.values())
    if as_json:
        jobs = {name.value: count for name, count in counts.items()}
        document = {
            "name": name,
            **facts,
            "jobs": jobs,
            "jobs_with_undecided": len(undecided),
            "seconds": seconds,
        }
        click.echo(json.dumps(document))
        return 0
    named = f"{name}: " if name else ""
    click.echo(f"{named}{total - counts[Status.PENDING]} of {total} jobs ended, begun {facts['created']}")
    click.echo(", ".join(f"{count} {name.value}" for name, count in counts.items() if count))
    parts = sum(everything.values()) - total
    if parts:
        left = everything[Status.PENDING] - counts[Status.PENDING]
        click.echo(f"{parts - left} of {parts} parts of split jobs ended")
    if ended:
        click.echo(f"{duration(seconds)} of work, {1e3 * seconds / ended:.3g} ms a job")
    if undecided:
        more = f" and {len(undecided) - SHOWN} more" if len(undecided) > SHOWN else ""
        click.echo(f"left something undecided: jobs {', '.join(map(str, undecided[:SHOWN]))}{more}")
    for job in bad[:SHOWN]:
        click.echo(f"job {job.number} {job.status.value} after {job.attempts} attempts: {job.message}")
    if len(bad) > SHOWN:
        click.echo(f"and {len(bad) - SHOWN} more, see results.jsonl")
    return 0


@command.command("show", epilog=examples("batch show run 1", "batch show run 1 --json"))
@click.argument("folder", metavar="DIR", shell_complete=folders)
@click.argument("job", type=click.IntRange(min=1))
@click.option("--json", "as_json", is_flag=True, help="Print the cdpr-result/1 document.")
@click.option("--certificate", metavar="FILE", help="Write the proof, for `check`.")
def show(folder: str, job: int, as_json: bool, certificate: str | None) -> int:
    """Show the result of one job."""
    from cdpr_interval.errors import InputError
    from solvers.answers.json_text import dumps
    from solvers.answers.result import Result
    from solvers.answers.table import print_result
    from solvers.batch.campaign import result_of
    from solvers.batch.ledger import Ledger
    from solvers.commands.target import JsonTarget

    with Ledger.peek(Path(folder)) as ledger:
        document = result_of(ledger, job)
        proof = ledger.certificate(job)
    if certificate is not None:
        if proof is None:
            raise InputError(f"job {job}: has no certificate (options.certificates of the job file)")
        JsonTarget(certificate, "--certificate").write_bytes(proof)
    if as_json:
        click.echo(dumps(document), nl=False)
    else:
        print_result(Result.from_json(document), sys.stdout)
    return 0


@command.command("check", epilog=examples("batch check run"))
@click.argument("folder", metavar="DIR", shell_complete=folders)
@threads_option
@click.option(
    "--time-limit", type=click.FloatRange(min=0.0, min_open=True), metavar="S", help="For each certificate."
)
@click.option("-q", "--quiet", is_flag=True, help="No table, no progress.")
def check(folder: str, time_limit: float | None, quiet: bool, **given: Any) -> int:
    """Give every certificate of a batch to the independent checker.

    Exit code 0: all are proved; 5: some are not; 3: something is left open, or a job has no certificate.
    """
    from solvers.batch.checking import check_batch
    from solvers.batch.ledger import Ledger

    threads = read_threads(given)
    with Ledger.open(Path(folder), None) as ledger:
        counts = ledger.counts()
        with _progress(quiet) as report, interruptible():
            verdicts = check_batch(ledger, threads, time_limit, report)
        without = sum(counts.values()) - verdicts.total()
        if not quiet:
            _print_checks(verdicts, without, [row for row in ledger.checks() if row.verdict != PROVED])
    return _checks_code(verdicts, without)


def _estimate(batch: Any, threads: int) -> int:
    from solvers.batch.campaign import estimate
    from solvers.batch.progress_line import duration

    for expansion in batch.expansions:
        click.echo(f"problems[{expansion.problem}]  {expansion.robot.name}  {expansion.count} jobs")
    found = estimate(batch)
    if found.seconds_per_job is None:
        click.echo(f"{found.jobs} jobs; no estimate: the first one took too long")
    else:
        seconds = found.jobs * found.seconds_per_job
        each = f"{1e3 * found.seconds_per_job:.3g} ms a job ({found.tried} tried)"
        about = "more than" if found.is_lower_bound else "about"
        click.echo(
            f"{found.jobs} jobs, {each}: {about} {duration(seconds / threads)} with --threads {threads}"
        )
    return 0


def _proceed(ledger: Ledger, given: dict[str, Any]) -> int:
    from solvers.batch.campaign import proceed
    from solvers.cli import ExitCode

    executor = _executor(given)
    try:
        with _progress(given["quiet"]) as report, interruptible():
            try:
                document = proceed(ledger, executor, report)
            finally:
                executor.close()
    except KeyboardInterrupt:
        click.echo(f"interrupted; go on with: cdpr-solve batch resume {ledger.folder}", err=True)
        return ExitCode.INTERRUPTED
    if given["as_json"]:
        click.echo(json.dumps(document))
    elif not given["quiet"]:
        from solvers.batch.summary_text import print_summary

        print_summary(document, sys.stdout)
    return _exit_code(document)


@contextmanager
def _progress(quiet: bool) -> Iterator[Callable[[BatchProgress], None]]:
    """Give what shows reports, and take the line off the terminal at the end."""
    from solvers.batch.progress_line import ProgressLine

    line = None if quiet else ProgressLine(sys.stderr)
    try:
        yield line or (lambda progress: None)
    finally:
        if line is not None:
            line.end()


def _executor(given: dict[str, Any]) -> Executor:
    from cdpr_interval.errors import InputError

    if given["scheduler"] is not None or given["scheduler_file"] is not None:
        if given["threads"] is not None:
            raise InputError("--threads: not together with --scheduler, which has workers of its own")
        from solvers.batch.dask_cluster import DaskCluster

        return DaskCluster.connected(given["scheduler"], given["scheduler_file"])
    from solvers.batch.pool import ProcessPool

    return ProcessPool(read_threads(given))


def _exit_code(document: dict[str, Any]) -> int:
    from solvers.cli import ExitCode

    jobs = document["jobs"]
    if jobs["failed"] or jobs["crashed"]:
        return ExitCode.NOT_PROVED
    return ExitCode.INCOMPLETE if document["jobs_with_undecided"] or jobs["pending"] else ExitCode.COMPLETE


def _print_checks(verdicts: Counter[str], without: int, others: list[CheckRow]) -> None:
    said = ", ".join(f"{count} {verdict}" for verdict, count in sorted(verdicts.items()))
    click.echo(f"{verdicts.total()} certificates{': ' if said else ''}{said}")
    if without:
        click.echo(f"{without} jobs have none")
    for row in others[:SHOWN]:
        click.echo(f"job {row.number} {row.verdict}: {row.message}")
    if len(others) > SHOWN:
        click.echo(f"and {len(others) - SHOWN} more")


def _checks_code(verdicts: Counter[str], without: int) -> int:
    from solvers.cli import ExitCode
    from solvers.proofs.check import REFUSED

    if any(verdicts[verdict] for verdict in REFUSED):
        return ExitCode.NOT_PROVED
    return ExitCode.INCOMPLETE if without or set(verdicts) - {PROVED} else ExitCode.COMPLETE
