"""The tables of a batch: a row for every solution, as CSV or Parquet, and a line of JSON for every job."""

from __future__ import annotations

import csv
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import IO, Any, Protocol

from cdpr_interval.errors import InputError
from cdpr_interval.robots.formats.reader import parse_robot
from cdpr_interval.text.literal import printable
from solvers.batch.ledger import Ledger, Recorded
from solvers.batch.ledger_file import LedgerError

Row = dict[str, Any]
CSV_FILE, JSONL_FILE, PARQUET_FILE = "solutions.csv", "results.jsonl", "solutions.parquet"
JOB_COLUMNS = {
    "job": int, "robot": str, "problem": int, "item": int, "status": str, "outcome": str, "solutions": int,
    "undecided": int,
}  # fmt: skip
SOLUTION_COLUMNS = {
    "solution": int, "branch": int, "taut": str, "stability": str, "proof": str,
    "x_m": float, "y_m": float, "z_m": float, "roll_deg": float, "pitch_deg": float, "yaw_deg": float,
    "height_m": float, "width_m": float,
}  # fmt: skip
NO_TURN = (0.0, 0.0, 0.0)
MOST_ROWS = 50_000
"""Written to Parquet at a time."""


def length_column(cable: str) -> str:
    """Return the title of a cable's length."""
    return f"length_{cable}_m"


def tension_column(cable: str) -> str:
    """Return the title of a cable's tension."""
    return f"tension_{cable}_N"


def cable_names(ledger: Ledger) -> dict[str, tuple[str, ...]]:
    """Return the cables of every robot, by digest."""
    return {digest: parse_robot(data).cable_names for digest, (_, _, data) in ledger.robots().items()}


def columns(ledger: Ledger) -> dict[str, type]:
    """Return the columns of the table of solutions with their types."""
    names = dict.fromkeys(name for cables in cable_names(ledger).values() for name in cables)
    own = dict.fromkeys([*map(length_column, names), *map(tension_column, names)], float)
    return {**JOB_COLUMNS, **SOLUTION_COLUMNS, **own, "message": str}


def job_rows(job: Recorded, robot: str, cables: Sequence[str]) -> Iterator[Row]:
    """Yield the rows of one job: one for each solution, or one when it has none; a summary adds the branch.

    Solutions are numbered from 1, as ``batch show`` prints them.
    Numbers are in the middle of their certified bounds; ``width_m`` is the largest width of the position.
    """
    head: dict[str, Any] = {
        "job": job.number, "robot": robot, "problem": job.problem, "item": job.item,
        "status": job.status.value, "message": job.message,
    }  # fmt: skip
    if job.answer is None:
        yield head
        return
    answer = json.loads(job.answer)
    head |= {
        "outcome": answer["outcome"],
        "solutions": len(answer["solutions"]),
        "undecided": len(answer["undecided"]),
        "message": answer["message"],
    }
    head |= {length_column(name): _middle(b) for name, b in zip(cables, answer["lengths_m"], strict=True)}
    for number, solution in enumerate(answer["solutions"], 1):
        yield {**head, **_solution_row(number, solution, cables)}
    if not answer["solutions"]:
        yield head


def _solution_row(number: int, solution: dict[str, Any], cables: Sequence[str]) -> dict[str, Any]:
    nominal = solution["nominal"]
    turn = (math.degrees(angle) for angle in nominal.get("rpy_rad", NO_TURN))
    tensions = zip(cables, solution["tensions_N"], strict=True)
    return {
        "solution": number,
        "taut": " ".join(solution["taut"]),
        "stability": solution["stability"],
        "proof": solution["proof"],
        **dict(zip(("x_m", "y_m", "z_m"), nominal["position_m"], strict=True)),
        **dict(zip(("roll_deg", "pitch_deg", "yaw_deg"), turn, strict=True)),
        "height_m": _middle(solution["height_m"]),
        "width_m": _width(solution["position_m"]),
        **{tension_column(name): _middle(bounds) for name, bounds in tensions},
    }


def _width(box: Sequence[Sequence[float | None]]) -> float | None:
    """Return the largest width of a box; None where nothing bounds it."""
    widths = [None if lo is None or hi is None else hi - lo for lo, hi in box]
    known = [width for width in widths if width is not None]
    return max(known) if len(known) == len(widths) else None


def _middle(bounds: Sequence[float | None]) -> float | None:
    """Return the middle of bounds; None where nothing bounds them."""
    lo, hi = bounds
    return None if lo is None or hi is None else 0.5 * (lo + hi)


class Table(Protocol):
    """A file that is written job by job."""

    def add(self, job: Recorded, rows: Sequence[Row]) -> None:
        """Take a job and its rows."""


class CsvTable:
    """``solutions.csv``: the rows."""

    def __init__(self, stream: IO[str], titles: Sequence[str]) -> None:
        self._titles = titles
        self._writer = csv.writer(stream)
        self._writer.writerow(titles)

    def add(self, job: Recorded, rows: Sequence[Row]) -> None:
        """Write the rows of a job."""
        self._writer.writerows([row.get(title, "") for title in self._titles] for row in rows)


class JsonLines:
    """``results.jsonl``: what was asked and what came out, a line for every job."""

    def __init__(self, stream: IO[str], robots: Mapping[str, str]) -> None:
        self._stream, self._robots = stream, robots

    def add(self, job: Recorded, rows: Sequence[Row]) -> None:
        """Write the line of a job."""
        head = {
            "job": job.number, "key": job.key, "robot": self._robots[job.robot], "robot_sha256": job.robot,
            "problem": job.problem, "item": job.item, "status": job.status.value, "message": job.message,
        }  # fmt: skip
        # Input and answer are JSON already.
        text = json.dumps(head)[:-1]
        self._stream.write(f'{text}, "input": {job.input}, "answer": {job.answer or "null"}}}\n')


class ParquetTable:
    """``solutions.parquet``: the rows, typed."""

    def __init__(self, path: Path, types: Mapping[str, type]) -> None:
        import pyarrow
        import pyarrow.parquet

        kinds = {int: pyarrow.int64(), float: pyarrow.float64(), str: pyarrow.string()}
        self._arrow = pyarrow
        self._schema = pyarrow.schema([(title, kinds[kind]) for title, kind in types.items()])
        self._writer = pyarrow.parquet.ParquetWriter(path, self._schema)
        self._rows: list[Row] = []

    def add(self, job: Recorded, rows: Sequence[Row]) -> None:
        """Keep the rows of a job until there are enough."""
        self._rows += rows
        if len(self._rows) >= MOST_ROWS:
            self._flush()

    def close(self) -> None:
        """Write what is left."""
        self._flush()
        self._writer.close()

    def _flush(self) -> None:
        if self._rows:
            self._writer.write_table(self._arrow.Table.from_pylist(self._rows, self._schema))
            self._rows = []


@contextmanager
def written(ledger: Ledger, kind: str) -> Iterator[Table]:
    """Open the table of a kind (``csv``, ``jsonl`` or ``parquet``) in the ledger's folder.

    It replaces an older one at the end of the context, and only when nothing went wrong.

    Raises
    ------
    LedgerError
        The file cannot be written.
    """
    with ExitStack() as stack:
        if kind == "parquet":
            part = stack.enter_context(replacing(ledger.folder / PARQUET_FILE))
            yield stack.enter_context(closing(ParquetTable(part, columns(ledger))))
            return
        part = stack.enter_context(replacing(ledger.folder / (CSV_FILE if kind == "csv" else JSONL_FILE)))
        stream = stack.enter_context(part.open("w", newline="", encoding="utf-8"))
        if kind == "csv":
            yield CsvTable(stream, list(columns(ledger)))
        else:
            yield JsonLines(stream, {digest: name for digest, (name, _, _) in ledger.robots().items()})


def require_parquet() -> None:
    """Raise `InputError` when Parquet cannot be written here."""
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        rule = "pyarrow is not installed: pip install '.[cluster]'"
        raise InputError(f"outputs.parquet: {rule}") from None


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield where to write a file that takes its place at the end: readers see the old one or the new.

    Raises
    ------
    LedgerError
        It cannot be written.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield part
        part.replace(path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise LedgerError(
            f"{printable(str(path))}: cannot be written: {reason}; the ledger is kept"
        ) from None
    finally:
        part.unlink(missing_ok=True)
