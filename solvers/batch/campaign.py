"""A batch in its folder, from the job file to the tables: what the command does, for Python callers too."""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.text.literal import printable
from solvers.answers.document import to_json
from solvers.answers.provenance import Provenance
from solvers.answers.tool import this_tool
from solvers.batch import tables
from solvers.batch.executor import Executor
from solvers.batch.job_file import Batch, Outputs, block_of, outputs_of
from solvers.batch.ledger import Ledger, Recorded
from solvers.batch.ledger_file import FILE
from solvers.batch.run import BatchProgress, BatchRun
from solvers.batch.summary import Summary, write_summary
from solvers.batch.work import Chunk, Task, solve_chunk
from solvers.questions.force import ZERO, read_force
from solvers.questions.lengths import read_lengths
from solvers.questions.problem import asked_of

ESTIMATE_SECONDS = 10.0
"""Time that an estimate may take."""
ESTIMATE_SECONDS_A_JOB = 2.0
"""After which one of them is given up."""
ESTIMATE_JOBS = 3
"""Tried of each problem and robot."""
STOPPED = '"stop_reason":"time_limit"'
"""In the text of an answer."""


@dataclass(frozen=True)
class Estimate:
    """What a batch would take."""

    jobs: int
    is_lower_bound: bool
    """True: a job that was tried took longer than the time for it."""
    seconds_per_job: float | None
    """Mean over the jobs that were tried; None: not one ended in time."""
    tried: int


def begin(batch: Batch, folder: Path) -> Ledger:
    """Write the ledger of a new batch, or open the one of this very batch; see `Ledger` for the errors.

    Raises
    ------
    InputError
        The folder cannot be written, or holds another batch.
    """
    if batch.outputs.parquet:
        tables.require_parquet()
    is_new = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--out: {printable(str(folder))}: {error.strerror}") from None
    version = this_tool().version
    if not (folder / FILE).exists():
        try:
            return Ledger.create(folder, batch.text, version, batch.settings, batch.robots, batch.jobs())
        except BaseException:
            if is_new:
                with suppress(OSError):
                    folder.rmdir()
            raise
    ledger = Ledger.open(folder, version)
    try:
        differing = _difference(ledger, batch)
    except BaseException:
        ledger.close()
        raise
    if differing:
        ledger.close()
        raise InputError(f"--out: {printable(str(folder))} holds another batch ({differing} differ)")
    return ledger


def _difference(ledger: Ledger, batch: Batch) -> str:
    """Return in what a batch differs from the one of a ledger; empty when it does not."""
    if ledger.fact("job_file") != batch.text.decode("utf-8", "replace"):
        return "the job files"
    if set(ledger.robots()) != {robot.robot.sha256 for robot in batch.robots}:
        return "the robots"
    # A table of lengths may have been changed meanwhile.
    same = all(one == other for one, other in itertools.zip_longest(ledger.questions(), batch.questions()))
    return "" if same else "the jobs"


def proceed(ledger: Ledger, executor: Executor, report: Callable[[BatchProgress], None]) -> dict[str, Any]:
    """Solve what is pending, write the tables, and return the summary."""
    BatchRun(ledger, executor, report).run()
    return write_tables(ledger)


def write_tables(ledger: Ledger) -> dict[str, Any]:
    """Write the summary and the tables the job file asks for, in one pass, and return the summary."""
    wanted = asdict(_outputs(ledger))
    names, cables, found = _robot_names(ledger), tables.cable_names(ledger), Summary(ledger)
    with ExitStack() as stack:
        files = [stack.enter_context(tables.written(ledger, kind)) for kind in wanted if wanted[kind]]
        for job in ledger.recorded():
            rows = list(tables.job_rows(job, names[job.robot], cables[job.robot]))
            for file in (found, *files):
                file.add(job, rows)
    document = found.to_json()
    write_summary(ledger.folder, document)
    return document


def counted(ledger: Ledger) -> Summary:
    """Return the summary with the numbers it is made of."""
    names, cables, found = _robot_names(ledger), tables.cable_names(ledger), Summary(ledger)
    for job in ledger.recorded():
        found.add(job, list(tables.job_rows(job, names[job.robot], cables[job.robot])))
    return found


def _robot_names(ledger: Ledger) -> dict[str, str]:
    return {digest: name for digest, (name, _, _) in ledger.robots().items()}


def _outputs(ledger: Ledger) -> Outputs:
    """Return the outputs of the job file that the ledger keeps."""
    return outputs_of(block_of(ledger.fact("job_file")).outputs)


def robot_of(ledger: Ledger, number: int) -> Robot:
    """Return the robot of a job, perturbed where the job says so."""
    from cdpr_interval.robots.formats.reader import parse_robot
    from solvers.batch.job import perturbed

    job = ledger.job(number)
    if job is None:
        raise InputError(f"job {number}: there is none")
    return perturbed(parse_robot(ledger.robots()[job.robot][2]), json.loads(job.input))


def result_of(ledger: Ledger, number: int) -> dict[str, Any]:
    """Return the ``cdpr-result/1`` document of a job; `InputError` when it has none."""
    from solvers.batch.answer import result_document

    job = ledger.job(number)
    if job is None:
        raise InputError(f"job {number}: there is none")
    if job.whole is not None:
        raise InputError(f"job {number}: is a part of job {job.whole}, which has the result")
    if job.answer is None:
        raise InputError(f"job {number}: {job.status.value}{': ' + job.message if job.message else ''}")
    asked, answer, robot = json.loads(job.input), json.loads(job.answer), robot_of(ledger, number)
    settings = asked_of(robot, ledger.settings().options())
    question = {
        "command": "fk",
        "taut": asked.get("taut", list(robot.cable_names) if settings.ignore_tension_sign else None),
        "ignore_slack": settings.ignore_slack,
        "ignore_tension_sign": settings.ignore_tension_sign,
        "method": settings.method.value,
        "precision": settings.precision,
        "external_force_N": [float(x) for x in asked.get("external_force_N", (0, 0, 0))],
        "tension_N": [float(x) for x in asked["tension_N"]] if "tension_N" in asked else None,
    }
    tool = {"name": this_tool().name, "version": ledger.fact("version")}
    origin = to_json(_provenance(ledger, job, robot, asked, answer))
    return result_document(answer, robot, question, tool, origin)


def _provenance(
    ledger: Ledger, job: Recorded, robot: Robot, asked: dict[str, Any], answer: dict[str, Any]
) -> Provenance:
    """Return where the answer of a job comes from: the lengths of a pose are the doubles of the answer."""
    assert job.started is not None and job.seconds is not None and job.host is not None
    ended = datetime.fromtimestamp(job.started + job.seconds, UTC).replace(microsecond=0)
    lengths = read_lengths(asked.get("lengths_m", answer["lengths_m"]), robot.cable_names)
    force = read_force(asked.get("external_force_N", ZERO))
    return Provenance(ended, job.host, ledger.versions(), lengths, force, robot)


def estimate(batch: Batch) -> Estimate:
    """Try the first jobs of every problem and robot in this process, and say what all would take.

    Every problem counts by its number of jobs. Nothing is written.
    """
    limit = min(ESTIMATE_SECONDS_A_JOB, batch.settings.time_limit_s or ESTIMATE_SECONDS_A_JOB)
    settings = replace(batch.settings, split=None, certificates=False, time_limit_s=limit)
    files = {robot.robot.sha256: robot.data for robot in batch.robots}
    begun, total, tried, counted, cut = time.monotonic(), 0.0, 0, 0, False
    for expansion in batch.expansions:
        seconds = []
        for job in itertools.islice(expansion.jobs(settings), ESTIMATE_JOBS + 1):
            if time.monotonic() - begun > ESTIMATE_SECONDS:
                break
            (outcome,) = solve_chunk(Chunk(files[job.robot], settings.to_json(), (Task(0, job.input),)))
            seconds.append(outcome.seconds)
            stopped = outcome.answer is not None and STOPPED in outcome.answer
            cut |= stopped and limit != batch.settings.time_limit_s
        # The first one may have waited for kernels to be compiled.
        useful = seconds[1:] or seconds
        tried += len(seconds)
        if useful:
            total += expansion.count * sum(useful) / len(useful)
            counted += expansion.count
    return Estimate(batch.count, cut, total / counted if counted else None, tried)
