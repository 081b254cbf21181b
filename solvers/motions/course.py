"""Lengths over time: rows of a file or of a list, and straight lines between them."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.exact.enclosure import Bounds, length_bounds
from cdpr_interval.exact.range import LengthRange
from cdpr_interval.files.fields import is_free
from cdpr_interval.text.count import counted
from cdpr_interval.text.literal import quote
from cdpr_interval.text.number import exact_number
from solvers.questions.csv_table import cells_of, require_commas, unknown_title
from solvers.questions.errors import InputErrors
from solvers.questions.lengths import read_lengths
from solvers.questions.units import read_seconds

TIME = "t_s"
"""The title of the column of times."""
NOTES = "notes"


@dataclass(frozen=True)
class Row:
    """The lengths at one time, exactly."""

    time: Fraction
    """s."""
    lengths: tuple[LengthRange, ...]
    """m, file order."""


@dataclass(frozen=True)
class Course:
    """Lengths over time: at least two rows, each later than the one before."""

    rows: tuple[Row, ...]

    @property
    def begin(self) -> Fraction:
        """The first time, s."""
        return self.rows[0].time

    @property
    def end(self) -> Fraction:
        """The last time, s."""
        return self.rows[-1].time

    @cached_property
    def _times(self) -> list[Fraction]:
        return [row.time for row in self.rows]

    def knots(self, step: Fraction | None = None) -> list[Fraction]:
        """Return the times of the rows, and between them others that are at most ``step`` s apart."""
        found = [self.begin]
        for one, other in zip(self.rows, self.rows[1:], strict=False):
            span = other.time - one.time
            count = 1 if step is None else -(-span // step)
            found += [one.time + span * k / count for k in range(1, count + 1)]
        return found

    def at(self, time: Fraction) -> tuple[LengthRange, ...]:
        """Return the lengths at a time of the course, exactly."""
        later = bisect_left(self._times, time)
        after = self.rows[later]
        if time == after.time:
            return after.lengths
        before = self.rows[later - 1]
        share = (time - before.time) / (after.time - before.time)
        return tuple(
            (a + share * (c - a), b + share * (d - b))
            for (a, b), (c, d) in zip(before.lengths, after.lengths, strict=True)
        )

    def bounds(self, time: Fraction) -> Bounds:
        """Return doubles (N, 2) around the lengths at a time, m."""
        return length_bounds(self.at(time))

    def middles(self, time: Fraction) -> tuple[Fraction, ...]:
        """Return the middles of the lengths at a time, exactly."""
        return tuple((lo + hi) / 2 for lo, hi in self.at(time))

    def of_middles(self) -> Course:
        """Return the course of the middles of all ranges."""
        rows = [Row(row.time, tuple(((lo + hi) / 2,) * 2 for lo, hi in row.lengths)) for row in self.rows]
        return Course(tuple(rows))

    def widened(self, tolerance: Fraction, label: str) -> Course:
        """Return the course with every exact length within so many m of what it says."""
        if not tolerance:
            return self
        rows = []
        for row in self.rows:
            lengths = [(a - tolerance, b + tolerance) if a == b else (a, b) for a, b in row.lengths]
            if any(lo <= 0 for lo, _ in lengths):
                raise InputError(f"{label}: a length at {float(row.time):g} s is not longer than that")
            rows.append(Row(row.time, tuple(lengths)))
        return Course(tuple(rows))

    def pace(self, time: Fraction) -> Fraction:
        """Return how fast the fastest cable goes after a time of the course, m/s."""
        later = min(bisect_right(self._times, time), len(self.rows) - 1)
        one, other = self.rows[later - 1], self.rows[later]
        ways = [
            abs(a - b)
            for pair, next_pair in zip(one.lengths, other.lengths, strict=True)
            for a, b in zip(pair, next_pair, strict=True)
        ]
        return max(ways) / (other.time - one.time)


def read_course(path: Path, name: str, cables: Sequence[str]) -> Course:
    """Return the course of a CSV file.

    Parameters
    ----------
    path : Path
    name : str
        The file as messages call it.
    cables : sequence of str
        The robot's. The head has each of them and ``t_s``; ``notes`` and ``x_...`` are the user's own.

    Raises
    ------
    InputError
        With one message per error, each with its line; those of the head once, in line 1.
    """
    table = cells_of(path, name, "a head with t_s and the cables' names, and at least two rows")
    head = [title.strip() for title in table[0]]
    columns = _columns(head, f"file {quote(name)} line 1", cables)
    rows, errors, last, count = [], InputErrors(), None, 0
    for line, cells in enumerate(table[1:], 2):
        place = f"file {quote(name)} line {line}"
        if not any(cell.strip() for cell in cells):
            continue
        count += 1
        if len(cells) != len(head):
            errors.add(f"{place}: {counted(len(cells), 'cell')} under {counted(len(head), 'title')}")
            continue
        given = {cable: cells[columns[cable]].strip() for cable in cables}
        lengths = errors.read(read_lengths, given, cables, place)
        time = errors.read(_time, cells[columns[TIME]], place, last)
        last = time if time is not None else last
        rows.append(Row(time or Fraction(0), lengths or ()))
    if count < 2:
        errors.add(f"file {quote(name)}: needs at least two rows, has {count}")
    errors.require_none()
    return Course(tuple(rows))


def given_course(rows: Any, cables: Sequence[str]) -> Course:
    """Return the course of pairs (time in s, lengths as in `forward_kinematics`).

    Raises
    ------
    InputError
        With one message per error.
    """
    errors, found, last = InputErrors(), [], None
    try:
        pairs = [(time, lengths) for time, lengths in rows]
    except (TypeError, ValueError):
        raise InputError("lengths: must be a CSV file or pairs (time in s, lengths)") from None
    for i, (given, lengths) in enumerate(pairs):
        time = errors.read(_time, given, f"lengths[{i}]", last)
        read = errors.read(read_lengths, lengths, cables, f"lengths[{i}]")
        last = time if time is not None else last
        found.append(Row(time or Fraction(0), read or ()))
    if len(found) < 2:
        errors.add(f"lengths: needs at least two rows, has {len(found)}")
    errors.require_none()
    return Course(tuple(found))


def _time(given: Any, place: str, last: Fraction | None) -> Fraction:
    """Return an exact time in s, later than the last one."""
    try:
        time = read_seconds(given.strip()) if isinstance(given, str) else exact_number(given)
    except ValueError as error:
        raise InputError(f"{place}: {TIME}: {error}") from None
    if last is not None and time <= last:
        raise InputError(f"{place}: {TIME}: must be later than {float(last):g} s, got {float(time):g}")
    return time


def _columns(head: Sequence[str], place: str, cables: Sequence[str]) -> dict[str, int]:
    """Return the column of the time and of every cable; `InputError` with all that is wrong with the head."""
    require_commas(head, place)
    errors, wanted = InputErrors(), (TIME, *cables)
    found: dict[str, int] = {}
    for column, title in enumerate(head):
        if title in found:
            errors.add(f"{place}: column {quote(title)} is there twice")
        elif title in wanted:
            found[title] = column
        elif title != NOTES and not is_free(title):
            errors.add(f"{place}: {unknown_title(column, title, wanted)}")
    if missing := [title for title in wanted if title not in found]:
        errors.add(f"{place}: no column for {', '.join(missing)}")
    errors.require_none()
    return found
