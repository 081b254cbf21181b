"""The ledger of a batch: an SQLite file with every job, what became of it, and its answer.

One process writes. What was recorded survives a kill of every process: jobs whose outcome was not recorded
are pending again, the others are never done twice.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from types import TracebackType
from typing import Any

from filelock import FileLock

from cdpr_interval.text.literal import printable
from solvers.batch.job import Job, Question, Settings
from solvers.batch.ledger_file import (
    FILE,
    FORMAT,
    LOCK,
    LedgerError,
    UnusableLedger,
    connected,
    explained,
    locked,
    write,
)
from solvers.batch.robot_files import RobotFile
from solvers.batch.work import JobOutcome, Status, Task

INCOMPLETE = '"outcome":"incomplete"'
"""In the text of an answer."""


@dataclass(frozen=True)
class Pending:
    """A job that is not done."""

    robot: str
    """SHA-256 of its file."""
    task: Task


@dataclass(frozen=True)
class Recorded:
    """A job as the ledger has it."""

    number: int
    key: str
    robot: str
    problem: int
    item: int
    input: str
    status: Status
    attempts: int
    host: str | None
    started: float | None
    seconds: float | None
    message: str
    whole: int | None
    """The job of which it is a part."""
    answer: str | None


@dataclass(frozen=True)
class CheckRow:
    """What the independent checker said of a job's certificate."""

    number: int
    verdict: str
    """As `certificates.verdicts.Conclusion`."""
    message: str


class Ledger:
    """A ledger file, opened; a context manager.

    Use `create`, `open` or `peek`.
    """

    def __init__(self, folder: Path, connection: sqlite3.Connection, lock: FileLock | None) -> None:
        self.folder, self._connection, self._lock = folder, connection, lock

    @classmethod
    def create(
        cls, folder: Path, text: bytes, version: str, settings: Settings,
        robots: Iterable[RobotFile], jobs: Iterable[Job],
    ) -> Ledger:  # fmt: skip
        """Write a new ledger with all jobs pending, all of it or nothing, and open it.

        Raises
        ------
        InputError
            Two jobs are the same, or the folder cannot be written.
        LedgerError
            The file cannot be written.
        """
        lock = locked(folder)
        try:
            write(folder, text, version, settings, robots, jobs)
            with explained(folder / FILE):
                return cls(folder, connected(folder / FILE), lock)
        except BaseException:
            if not (folder / FILE).exists():
                (folder / LOCK).unlink(missing_ok=True)
            lock.release()
            raise

    @classmethod
    def open(cls, folder: Path, version: str | None) -> Ledger:
        """Open a ledger for writing; ``version`` None: of any version, no answers will be added.

        Raises
        ------
        UnusableLedger
            No ledger, another format, another version of the solver, or another process writes it.
        LedgerError
            It cannot be read.
        """
        return cls._opened(folder, version, lock=True)

    @classmethod
    def peek(cls, folder: Path) -> Ledger:
        """Open a ledger for reading, also while another process writes; `LedgerError`: as `open`."""
        return cls._opened(folder, None, lock=False)

    @classmethod
    def _opened(cls, folder: Path, version: str | None, lock: bool) -> Ledger:
        path = folder / FILE
        if not path.is_file():
            raise UnusableLedger(f"{printable(str(folder))}: no batch there ({FILE} is missing)")
        held = locked(folder) if lock else None
        try:
            with explained(path):
                connection = connected(path)
            ledger = cls(folder, connection, held)
            ledger._require_known(version)
        except BaseException:
            if held is not None:
                held.release()
            raise
        return ledger

    def _require_known(self, version: str | None) -> None:
        path = self.folder / FILE
        try:
            found, written = self.fact("format"), self.fact("version")
        except (sqlite3.Error, LedgerError, TypeError):
            self._connection.close()
            raise UnusableLedger(f"{printable(str(path))}: is no ledger of a batch") from None
        if found != FORMAT:
            self._connection.close()
            raise UnusableLedger(f"{printable(str(path))}: format {found}, this version reads {FORMAT}")
        if version is not None and written != version:
            self._connection.close()
            raise UnusableLedger(
                f"{printable(str(path))}: written by version {written}, this is {version}: their answers"
                " must not be mixed; use a new folder"
            )

    def close(self) -> None:
        """Close the file."""
        self._connection.close()
        if self._lock is not None:
            self._lock.release()

    def __enter__(self) -> Ledger:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def fact(self, key: str) -> str:
        """Return what is said about the whole batch, see `ledger_file.write`: version, settings, ..."""
        (value,) = self._connection.execute("SELECT value FROM meta WHERE key = ?", (key,)).fetchone()
        return str(value)

    def versions(self) -> dict[str, str]:
        """Return the versions of what the answers come from, as a result's provenance has them."""
        found: dict[str, str] = json.loads(self.fact("versions"))
        return found

    def settings(self) -> Settings:
        """Return how the problems are solved."""
        return Settings.from_json(self.fact("settings"))

    def robots(self) -> dict[str, tuple[str, str, bytes]]:
        """Return name, source and file of every robot, by digest."""
        rows = self._rows("SELECT sha256, name, source, file FROM robots ORDER BY rowid")
        return {digest: (name, source, data) for digest, name, source, data in rows}

    def questions(self) -> Iterator[Question]:
        """Yield what tells every job from the others, in order."""
        for row in self._rows(
            "SELECT robot, problem, item, input FROM jobs WHERE whole IS NULL ORDER BY number"
        ):
            robot, problem, item, text = row
            yield robot, problem, item, text

    def counts(self, with_parts: bool = False) -> dict[Status, int]:
        """Return the number of jobs of every status."""
        which = "" if with_parts else "WHERE whole IS NULL"
        found = dict(self._rows(f"SELECT status, COUNT(*) FROM jobs {which} GROUP BY status"))
        return {status: found.get(status.value, 0) for status in Status}

    def seconds(self) -> tuple[int, float]:
        """Return the number of attempts that ended, and their wall time in s."""
        ((count, total),) = self._rows("SELECT COUNT(seconds), COALESCE(SUM(seconds), 0) FROM jobs")
        return count, total

    def pending(self) -> Iterator[Pending]:
        """Yield the jobs that can be done now, in order: not those with parts that are pending."""
        for number, robot, text in self._rows(
            "SELECT number, robot, input FROM jobs WHERE status = 'pending' AND NOT EXISTS"
            " (SELECT 1 FROM jobs AS part WHERE part.whole = jobs.number AND part.status = 'pending')"
            " ORDER BY robot, number"
        ):
            yield Pending(robot, Task(number, text))

    def parts(self, number: int) -> list[Recorded]:
        """Return the parts of a job, in order."""
        return list(self._recorded("whole = ?", [number]))

    def incomplete(self) -> list[int]:
        """Return the jobs whose search left something undecided or pending."""
        query = "SELECT number FROM answers JOIN jobs USING (number) WHERE whole IS NULL AND instr(answer, ?)"
        return [number for (number,) in self._rows(f"{query} ORDER BY number", [INCOMPLETE])]

    def certified(self) -> list[int]:
        """Return the jobs that have certificates."""
        return [number for (number,) in self._rows("SELECT number FROM certificates ORDER BY number")]

    def claims(self) -> dict[str, int]:
        """Return of how many certificates the checker said what when they were written, as `Conclusion`."""
        return dict(self._rows("SELECT claim, COUNT(*) FROM certificates GROUP BY claim ORDER BY claim"))

    def checks(self) -> list[CheckRow]:
        """Return what the last checks of certificates said, by job."""
        rows = self._rows("SELECT number, verdict, message FROM checks ORDER BY number")
        return [CheckRow(*row) for row in rows]

    def certificate(self, number: int) -> bytes | None:
        """Return the proof of a job; None when there is none."""
        rows = list(self._rows("SELECT file FROM certificates WHERE number = ?", [number]))
        return bytes(rows[0][0]) if rows else None

    def recorded(self, statuses: Sequence[Status] = tuple(Status)) -> Iterator[Recorded]:
        """Yield all jobs of some statuses with their answers, in order."""
        marks = ", ".join("?" * len(statuses))
        condition = f"whole IS NULL AND status IN ({marks})"
        yield from self._recorded(condition, [status.value for status in statuses])

    def _recorded(self, condition: str, values: Sequence[str | int]) -> Iterator[Recorded]:
        names = [field.name for field in fields(Recorded)]
        query = f"SELECT {', '.join(names)} FROM jobs LEFT JOIN answers USING (number)"
        place = names.index("status")
        for row in self._rows(f"{query} WHERE {condition} ORDER BY number", values):
            yield Recorded(*row[:place], Status(row[place]), *row[place + 1 :])  # type: ignore[call-arg]

    def job(self, number: int) -> Recorded | None:
        """Return one job; None when there is no such number."""
        return next(self._recorded("number = ?", [number]), None)

    def _rows(self, query: str, values: Sequence[str | int] = ()) -> Iterator[tuple[Any, ...]]:
        with explained(self.folder / FILE):
            yield from self._connection.execute(query, values)

    def record(self, outcomes: Iterable[JobOutcome]) -> None:
        """Record outcomes, all of them or none; a job that has one keeps it."""
        rows = list(outcomes)
        with explained(self.folder / FILE), self._transaction():
            self._connection.executemany(
                "UPDATE jobs SET status = ?, attempts = attempts + 1, host = ?, started = ?, seconds = ?,"
                " message = ? WHERE number = ? AND status = 'pending'",
                [(o.status.value, o.host, o.started, o.seconds, o.message, o.number) for o in rows],
            )
            self._connection.executemany(
                "INSERT OR IGNORE INTO answers VALUES (?, ?)",
                [(o.number, o.answer) for o in rows if o.answer is not None],
            )
            self._connection.executemany(
                "INSERT OR IGNORE INTO certificates VALUES (?, ?, ?)",
                [(o.number, o.certificate, o.claim) for o in rows if o.certificate is not None],
            )
            self._connection.executemany(
                "INSERT OR IGNORE INTO checks VALUES (?, ?, ?)",
                [(o.number, o.claim, o.checked) for o in rows if o.certificate is not None],
            )

    def count_attempts(self, numbers: Iterable[int]) -> None:
        """Record an attempt that ended without an outcome."""
        with explained(self.folder / FILE), self._transaction():
            self._connection.executemany(
                "UPDATE jobs SET attempts = attempts + 1 WHERE number = ?", [(n,) for n in numbers]
            )

    def record_checks(self, rows: Iterable[CheckRow]) -> None:
        """Record what the checker said, instead of what it said before."""
        with explained(self.folder / FILE), self._transaction():
            self._connection.executemany(
                "INSERT OR REPLACE INTO checks VALUES (?, ?, ?)",
                [(row.number, row.verdict, row.message) for row in rows],
            )

    def reopen(self) -> int:
        """Make failed and crashed jobs pending again, and return how many; their attempts are kept."""
        with explained(self.folder / FILE), self._transaction():
            changed = self._connection.execute(
                "UPDATE jobs SET status = 'pending', message = '' WHERE status IN (?, ?)",
                (Status.FAILED.value, Status.CRASHED.value),
            )
        return changed.rowcount

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._connection.execute("BEGIN IMMEDIATE")
        try:
            yield
            self._connection.execute("COMMIT")
        except BaseException:
            if self._connection.in_transaction:
                self._connection.execute("ROLLBACK")
            raise
