"""Lists of lengths from a CSV file: one a row, under a head that names the cables."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cdpr_interval.exact.range import LengthRange
from cdpr_interval.files.fields import is_free
from cdpr_interval.text.count import counted
from cdpr_interval.text.literal import quote
from solvers.batch.tables import JOB_COLUMNS, SOLUTION_COLUMNS, length_column, tension_column
from solvers.questions.csv_table import cells_of, require_commas, unknown_title
from solvers.questions.errors import InputErrors
from solvers.questions.lengths import read_lengths

Rows = tuple[tuple[LengthRange, ...], ...]


def read_table(path: Path, name: str, cables: Sequence[str]) -> Rows:
    """Return the lengths of every row, exact ranges in file order of the robot.

    Parameters
    ----------
    path : Path
    name : str
        The file as messages call it.
    cables : sequence of str
        The robot's. The head has each of them, as itself or as the ``length_c1_m`` of ``solutions.csv``.
        Columns ``notes`` and ``x_...`` are the user's own. The other columns of ``solutions.csv`` may be
        there; of the rows of one job, which differ in their poses only, the first is taken.

    Raises
    ------
    InputError
        With one message per error: those of the head once, in line 1.
    """
    table = cells_of(path, name, "a head with the cables' names and at least one row")
    head = [title.strip() for title in table[0]]
    columns = _columns(head, f"file {quote(name)} line 1", cables)
    rows, errors, seen = [], InputErrors(), set()
    job = head.index("job") if "job" in head and not set(head) & set(cables) else None
    for line, row in enumerate(table[1:], 2):
        place = f"file {quote(name)} line {line}"
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(head):
            errors.add(f"{place}: {counted(len(row), 'cell')} under {counted(len(head), 'title')}")
            continue
        if job is not None:
            if row[job] in seen:
                continue
            seen.add(row[job])
        given = {cable: row[column].strip() for cable, column in columns.items()}
        rows.append(errors.read(read_lengths, given, cables, place) or ())
    errors.require_none()
    return tuple(rows)


def _columns(head: Sequence[str], place: str, cables: Sequence[str]) -> dict[str, int]:
    """Return the column of every cable; `InputError` with all that is wrong with the head."""
    require_commas(head, place)
    errors = InputErrors()
    written = {length_column(cable): cable for cable in cables}
    beside = {*JOB_COLUMNS, *SOLUTION_COLUMNS, "message", *map(tension_column, cables)}
    own = {*cables}.isdisjoint(head) and not written.keys().isdisjoint(head)
    found: dict[str, int] = {}
    for column, title in enumerate(head):
        cable = title if title in cables else written.get(title)
        if cable is None:
            if not (is_free(title) or (own and title in beside)):
                errors.add(f"{place}: {unknown_title(column, title, cables)}")
        elif cable in found:
            errors.add(f"{place}: column {quote(title)} is the second one of cable {quote(cable)}")
        else:
            found[cable] = column
    if missing := [cable for cable in cables if cable not in found]:
        errors.add(f"{place}: no column for {', '.join(missing)}")
    errors.require_none()
    return found
