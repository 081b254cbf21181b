"""The file of a ledger: its tables, its lock, and a new one written whole."""

from __future__ import annotations

import itertools
import json
import sqlite3
import time
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from cdpr_interval.errors import CdprError, InputError
from cdpr_interval.text.literal import printable
from solvers.answers.provenance import versions
from solvers.batch.job import Job, Settings, key_of, key_prefix
from solvers.batch.robot_files import RobotFile

FORMAT = "cdpr-ledger/2"
FILE = "ledger.sqlite"
LOCK = "ledger.lock"
_TABLES = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE robots (sha256 TEXT PRIMARY KEY, name TEXT NOT NULL, source TEXT NOT NULL, file BLOB NOT NULL);
CREATE TABLE jobs (
  number INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE, robot TEXT NOT NULL REFERENCES robots,
  problem INTEGER NOT NULL, item INTEGER NOT NULL, input TEXT NOT NULL,
  status TEXT NOT NULL DEFAULT 'pending', attempts INTEGER NOT NULL DEFAULT 0,
  host TEXT, started REAL, seconds REAL, message TEXT NOT NULL DEFAULT '', whole INTEGER REFERENCES jobs);
CREATE INDEX parts ON jobs (whole) WHERE whole IS NOT NULL;
CREATE TABLE answers (number INTEGER PRIMARY KEY REFERENCES jobs, answer TEXT NOT NULL);
CREATE TABLE certificates (
  number INTEGER PRIMARY KEY REFERENCES jobs, file BLOB NOT NULL, claim TEXT NOT NULL);
CREATE TABLE checks (
  number INTEGER PRIMARY KEY REFERENCES certificates, verdict TEXT NOT NULL, message TEXT NOT NULL);
"""


class LedgerError(CdprError):
    """The ledger cannot be read or written; what is in it is kept."""


class UnusableLedger(LedgerError, InputError):
    """There is no ledger that this program may use now: nothing was done."""


@contextmanager
def explained(path: Path) -> Iterator[None]:
    """Turn what SQLite raises into one line."""
    try:
        yield
    except sqlite3.Error as error:
        advice = ""
        if "full" in str(error) or "I/O" in str(error):
            advice = "; what was recorded is kept: make room, then cdpr-solve batch resume"
        raise LedgerError(f"{printable(str(path))}: {error}{advice}") from None


def connected(path: Path) -> sqlite3.Connection:
    """Return a connection to a ledger that exists."""
    connection = sqlite3.connect(path, isolation_level=None, timeout=10.0)
    connection.execute("PRAGMA journal_mode = WAL")
    # A power cut may take the last moments, a kill takes nothing that was committed.
    connection.execute("PRAGMA synchronous = NORMAL")
    return connection


def locked(folder: Path) -> FileLock:
    """Return the lock of the only process that writes; the system frees it when that process dies."""
    lock = FileLock(folder / LOCK, blocking=False)
    try:
        lock.acquire()
    except Timeout:
        raise UnusableLedger(f"{printable(str(folder))}: another process is running this batch") from None
    except OSError as error:
        raise InputError(f"{printable(str(folder))}: cannot be written: {error.strerror}") from None
    return lock


def write(
    folder: Path, text: bytes, version: str, settings: Settings,
    robots: Iterable[RobotFile], jobs: Iterable[Job],
) -> None:  # fmt: skip
    """Write a new ledger with all jobs pending, all of it or nothing; `InputError` when two are the same."""
    # Written beside its place: a kill leaves no half of a ledger.
    path = folder / FILE
    part = path.with_name(f".{FILE}.part")
    try:
        part.unlink(missing_ok=True)
        with explained(path), closing(sqlite3.connect(part, isolation_level=None)) as connection:
            connection.execute("BEGIN IMMEDIATE")
            for statement in filter(str.strip, _TABLES.split(";")):
                connection.execute(statement)
            facts = {"format": FORMAT, "version": version, "settings": settings.to_json()}
            facts["created"] = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
            facts["versions"] = json.dumps(versions())
            facts["job_file"] = text.decode("utf-8", "replace")
            connection.executemany("INSERT INTO meta VALUES (?, ?)", facts.items())
            connection.executemany(
                "INSERT INTO robots VALUES (?, ?, ?, ?)",
                [(r.robot.sha256, r.robot.name, r.source, r.data) for r in robots],
            )
            _insert(connection, jobs, key_prefix(version, settings))
            connection.execute("COMMIT")
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _insert(connection: sqlite3.Connection, jobs: Iterable[Job], prefix: bytes) -> None:
    """Insert all jobs; `InputError` names two that are the same."""
    last: list[Job] = []
    numbers = itertools.count(1)

    def rows() -> Iterator[tuple[int, str, str, int, int, str, int | None]]:
        for job in jobs:
            last[:] = [job]
            whole = next(numbers)
            yield whole, key_of(job, prefix), job.robot, job.problem, job.item, job.input, None
            for part in job.of_parts():
                key = key_of(part, prefix)
                yield next(numbers), key, part.robot, part.problem, part.item, part.input, whole

    try:
        connection.executemany(
            "INSERT INTO jobs (number, key, robot, problem, item, input, whole) VALUES (?, ?, ?, ?, ?, ?, ?)",
            rows(),
        )
    except sqlite3.IntegrityError:
        (job,) = last
        first = connection.execute(
            "SELECT problem, item FROM jobs WHERE key = ?", (key_of(job, prefix),)
        ).fetchone()
        if first is None:
            raise
        places = [f"problems[{problem}] job {item}" for problem, item in (first, (job.problem, job.item))]
        raise InputError(f"{places[1]} is the same as {places[0]}: {job.input}") from None
