"""The reader of ``cdpr-batch/1``: robots, problems and settings of a batch, every error at its place."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.files.document import Document, Node, parse_document, read_bytes
from cdpr_interval.text.literal import quote
from solvers.batch import job_schema
from solvers.batch.expansion import Expansion, expansion_of
from solvers.batch.job import Job, Question, Settings
from solvers.batch.robot_files import RobotFile, read_robots

MOST_JOBS = 10_000_000
"""Of one batch: a ledger of 25 GB."""


@dataclass(frozen=True)
class Outputs:
    """Which tables are written at the end."""

    csv: bool = True
    jsonl: bool = True
    parquet: bool = False


@dataclass(frozen=True)
class Batch:
    """A job file, read and checked."""

    name: str
    text: bytes
    """Of the file."""
    robots: tuple[RobotFile, ...]
    expansions: tuple[Expansion, ...]
    """One for each problem and robot."""
    settings: Settings
    outputs: Outputs

    @property
    def count(self) -> int:
        """Number of jobs."""
        return sum(expansion.count for expansion in self.expansions)

    def jobs(self) -> Iterator[Job]:
        """Yield every job, always in the same order."""
        for expansion in self.expansions:
            yield from expansion.jobs(self.settings)

    def questions(self) -> Iterator[Question]:
        """Yield what tells every job from the others, as the ledger has it."""
        for expansion in self.expansions:
            for job in expansion.jobs(replace(self.settings, split=None)):
                yield job.robot, job.problem, job.item, job.input


def read_job_file(path: str | os.PathLike[str]) -> Batch:
    """Read a ``cdpr-batch/1`` file and the robots and tables it names.

    Raises
    ------
    InputError
        With one line per error, ``FILE:LINE:COLUMN: path: rule``.
    NotSupportedError
        For a robot that no solver of this version can treat.
    """
    data = read_bytes(path)
    return _read(parse_document(data, os.fspath(path)), data, Path(path))


def _read(document: Document, data: bytes, path: Path) -> Batch:
    stated = document.root.mapping.get("format")
    if stated is not None and stated.value != job_schema.BATCH_FORMAT:
        # Another format: complaints about its keys would only mislead.
        document.report(stated, "format", f"must be {quote(job_schema.BATCH_FORMAT)}, got {stated.kind}")
        document.require_valid()
    block = job_schema.MODELS.validated(document)
    root = document.root.mapping
    robots = read_robots(document, block.robots, root["robots"].items, path.parent)
    document.require_valid()
    settings = _settings(block.options)
    expansions: list[Expansion] = []
    for index, (problem, node) in enumerate(zip(block.problems, root["problems"].items, strict=True)):
        note = _noting(document, node, f"problems[{index}]")
        for robot in _asked(problem, robots, note):
            found = note(expansion_of, index, problem, robot.robot, settings, path.parent)
            if found is not None:
                expansions.append(found)
    count = sum(expansion.count for expansion in expansions)
    if count > MOST_JOBS:
        document.report(root["problems"], "problems", f"{count} jobs, at most {MOST_JOBS}")
    document.require_valid()
    name = path.stem if block.name is None else block.name
    return Batch(name, data, tuple(robots), tuple(expansions), settings, outputs_of(block.outputs))


def _noting(document: Document, node: Node, place: str) -> Callable[..., Any]:
    """Return a call that notes the messages of an `InputError` at a place and returns None."""

    def call(function: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return function(*arguments)
        except InputError as error:
            for message in error.messages:
                document.report(node, place, message)
            return None

    return call


def _asked(
    problem: job_schema.ProblemBlock, robots: Sequence[RobotFile], note: Callable[..., Any]
) -> list[RobotFile]:
    if problem.robots is None:
        return list(robots)
    return [found for name in problem.robots if (found := note(_named, name, robots)) is not None]


def _named(name: str, robots: Sequence[RobotFile]) -> RobotFile:
    """Return the robot that is called so, by its own name or as the job file names its file."""
    for robot in robots:
        if name in (robot.robot.name, robot.source):
            return robot
    known = ", ".join(robot.robot.name for robot in robots)
    raise InputError(f"robots: no robot {quote(name)} (there are {known})")


def _settings(block: job_schema.OptionsBlock | None) -> Settings:
    if block is None:
        return Settings()
    given = {key: value for key, value in block.model_dump(warnings=False).items() if value is not None}
    for key in ("precision", "time_limit_s"):
        if key in given:
            given[key] = float(given[key])
    return Settings(**given)


def block_of(text: str) -> job_schema.BatchBlock:
    """Return what a job file says that was read before, as a ledger keeps it."""
    return job_schema.MODELS.validated(parse_document(text, "jobs.yaml"))


def outputs_of(block: job_schema.OutputsBlock | None) -> Outputs:
    """Return which tables a job file asks for."""
    given = {} if block is None else block.model_dump(exclude_none=True)
    return Outputs(**given)
