"""``cdpr-solve batch``: many problems, a ledger, workers here or on a cluster, tables at the end."""

from __future__ import annotations

import json
import os
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cdpr_interval.text.count import counted
from solvers.commands.threads import read_threads, threads_option
from solvers.commands.time_limit import read_time_limit, time_limit_option
from solvers.shell.completion import files, folders
from solvers.shell.examples import examples

if TYPE_CHECKING:
    from solvers.batch.executor import Executor
    from solvers.batch.ledger import CheckRow, Ledger
    from solvers.batch.run import BatchProgress
    from solvers.cli import Ending
    from solvers.commands.progress import ProgressDisplay

SHOWN = 10
"""Failed jobs that are listed."""
RUN = "run"
"""The command that is meant when none is named."""


class Batches(click.Group):
    """``batch JOBS.yaml`` is ``batch run JOBS.yaml``; a batch that cannot go on is one line, code 3."""

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
        from solvers.cli import Ending, ExitCode

        try:
            return super().invoke(ctx)
        except (InputError, NotSupportedError):
            raise
        except CdprError as error:
            return Ending(ExitCode.INCOMPLETE, str(error))


@click.group(
    "batch",
    cls=Batches,
    short_help="Many problems at once, with a ledger.",
    epilog=examples("batch jobs.yaml --dry-run", "batch jobs.yaml --out run", "batch status run"),
)
def command() -> None:
    """Solve many problems: `cdpr-solve batch JOBS.yaml --out DIR`.

    A batch that was killed goes on with `batch resume DIR`. Exit code 0: every job is answered and complete;
    3: something is left undecided or pending; 5: some jobs failed or crashed; 6: nothing of these, but
    inverse kinematics found no lengths for some poses.
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
    from solvers.batch.duration import duration
    from solvers.batch.job_file import block_of
    from solvers.batch.ledger import Ledger
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
    ended_jobs = total - counts[Status.PENDING]
    click.echo(f"{named}{ended_jobs} of {counted(total, 'job')} ended, begun {facts['created']}")
    click.echo(", ".join(f"{count} {name.value}" for name, count in counts.items() if count))
    parts = sum(everything.values()) - total
    if parts:
        left = everything[Status.PENDING] - counts[Status.PENDING]
        click.echo(f"{parts - left} of {counted(parts, 'part')} of split jobs ended")
    if ended:
        click.echo(f"{duration(seconds)} of work, {1e3 * seconds / ended:.3g} ms a job")
    if undecided:
        more = f" and {len(undecided) - SHOWN} more" if len(undecided) > SHOWN else ""
        jobs_named = "job" if len(undecided) == 1 else "jobs"
        click.echo(f"left something undecided: {jobs_named} {', '.join(map(str, undecided[:SHOWN]))}{more}")
    for job in bad[:SHOWN]:
        after = counted(job.attempts, "attempt")
        click.echo(f"job {job.number} {job.status.value} after {after}: {job.message}")
    if len(bad) > SHOWN:
        click.echo(f"and {len(bad) - SHOWN} more, see results.jsonl")
    return 0


@command.command("show", epilog=examples("batch show run 1", "batch show run 1 --json"))
@click.argument("folder", metavar="DIR", shell_complete=folders)
@click.argument("job", type=click.IntRange(min=1))
@click.option("--json", "as_json", is_flag=True, help="Print the cdpr-result/1 document.")
@click.option("--certificate", metavar="FILE", help="Write the proof, for `check`.")
@click.option("--robot", metavar="FILE", help="Write the robot, perturbed as in the job, as a robot file.")
def show(folder: str, job: int, as_json: bool, certificate: str | None, robot: str | None) -> int:
    """Show the result of one job."""
    from cdpr_interval.errors import InputError
    from solvers.answers.json_text import dumps
    from solvers.answers.result import Result
    from solvers.answers.table import print_result
    from solvers.batch.campaign import result_of, robot_of
    from solvers.batch.ledger import Ledger
    from solvers.commands.target import JsonTarget

    with Ledger.peek(Path(folder)) as ledger:
        if robot is not None:
            # Also of a job without a result: that is the one to look into.
            written = JsonTarget(robot, "--robot")
            written.require_writable()
            written.write_bytes(robot_of(ledger, job).to_yaml().encode())
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
@time_limit_option("Most seconds for each certificate.")
@click.option("-q", "--quiet", is_flag=True, help="No table, no progress.")
def check(folder: str, quiet: bool, **given: Any) -> int:
    """Give every certificate of a batch to the independent checker.

    Exit code 0: all are proved; 5: some are not; 3: something is left open, or a job has no certificate.
    """
    from certificates.verdicts import Conclusion
    from solvers.batch.checking import check_batch
    from solvers.batch.ledger import Ledger
    from solvers.commands.progress import shown

    threads, time_limit = read_threads(given), read_time_limit(given)
    with Ledger.open(Path(folder), None) as ledger:
        counts = ledger.counts()
        with shown("check", quiet) as display:
            verdicts = check_batch(ledger, threads, time_limit, _telling(display))
        without = sum(counts.values()) - verdicts.total()
        others = [row for row in ledger.checks() if row.verdict != Conclusion.PROVED]
    said = _verdicts(verdicts, without)
    if not quiet:
        _print_checks(said, others)
    return _checks_ending(verdicts, without, said)


def _estimate(batch: Any, threads: int) -> int:
    from solvers.batch.campaign import estimate
    from solvers.batch.duration import duration

    for expansion in batch.expansions:
        count = counted(expansion.count, "job")
        click.echo(f"problems[{expansion.problem}]  {expansion.robot.name}  {count}")
    found = estimate(batch)
    if found.seconds_per_job is None:
        click.echo(f"{counted(found.jobs, 'job')}; no estimate: the first one took too long")
    else:
        seconds = found.jobs * found.seconds_per_job
        each = f"{1e3 * found.seconds_per_job:.3g} ms a job ({found.tried} tried)"
        about = "more than" if found.is_lower_bound else "about"
        click.echo(
            f"{counted(found.jobs, 'job')}, {each}: {about} {duration(seconds / threads)}"
            f" with --threads {threads}"
        )
    return 0


def _proceed(ledger: Ledger, given: dict[str, Any]) -> int:
    from solvers.batch.campaign import proceed
    from solvers.cli import Ending, ExitCode
    from solvers.commands.progress import shown

    executor = _executor(given)
    try:
        with shown("batch", given["quiet"]) as display:
            try:
                document = proceed(ledger, executor, _telling(display))
            finally:
                executor.close()
    except KeyboardInterrupt:
        line = f"interrupted; go on with: cdpr-solve batch resume {ledger.folder}"
        return Ending(ExitCode.INTERRUPTED, line)
    if given["as_json"]:
        click.echo(json.dumps(document))
    elif not given["quiet"]:
        from solvers.batch.summary_text import print_summary

        print_summary(document, sys.stdout)
    return _ending(document)


def _telling(display: ProgressDisplay | None) -> Callable[[BatchProgress], None]:
    return (lambda progress: None) if display is None else display.jobs


def _executor(given: dict[str, Any]) -> Executor:
    from cdpr_interval.errors import InputError

    if given["scheduler"] is not None or given["scheduler_file"] is not None:
        if given["threads"] is not None:
            raise InputError("--threads: not together with --scheduler, which has workers of its own")
        from solvers.batch.dask_cluster import DaskCluster

        return DaskCluster.connected(given["scheduler"], given["scheduler_file"])
    from solvers.batch.pool import ProcessPool

    return ProcessPool(read_threads(given))


def _ending(document: dict[str, Any]) -> Ending:
    """Return the exit code of the worst that happened to a job, and everything that did."""
    from solvers.batch.headline import NONE_FOUND, headline, unsettled
    from solvers.cli import Ending, ExitCode

    found, jobs = unsettled(document), document["jobs"]
    code = ExitCode.COMPLETE
    if jobs["failed"] or jobs["crashed"]:
        code = ExitCode.NOT_PROVED
    elif found:
        code = ExitCode.NONE_FOUND if list(found) == [NONE_FOUND] else ExitCode.INCOMPLETE
    return Ending(code, f"{counted(sum(jobs.values()), 'job')}: {headline(document)}")


def _verdicts(verdicts: Counter[str], without: int) -> str:
    """Return the verdicts of the checker, counted."""
    said = ", ".join(f"{count} {verdict}" for verdict, count in sorted(verdicts.items()))
    text = f"{counted(verdicts.total(), 'certificate')}{': ' if said else ''}{said}"
    if not without:
        return text
    return f"{text}; {counted(without, 'job has', 'jobs have')} none"


def _print_checks(said: str, others: list[CheckRow]) -> None:
    click.echo(said)
    for row in others[:SHOWN]:
        click.echo(f"job {row.number} {row.verdict}: {row.message}")
    if len(others) > SHOWN:
        click.echo(f"and {len(others) - SHOWN} more")


def _checks_ending(verdicts: Counter[str], without: int, said: str) -> Ending:
    """Return how a check of many certificates ends: as the worst of them does alone."""
    from certificates.verdicts import Conclusion
    from solvers.cli import Ending, ExitCode
    from solvers.proofs.check import REFUSED

    if any(verdicts[conclusion] for conclusion in REFUSED):
        return Ending(ExitCode.NOT_PROVED, said)
    is_open = without or set(verdicts) - {Conclusion.PROVED}
    return Ending(ExitCode.INCOMPLETE if is_open else ExitCode.COMPLETE, said)
