"""A result as text: its sentence, a row or a block for every pose, and what is left undecided.

Rows where they fit, otherwise blocks, so that no number is broken: a terminal has its width, a pipe or a file
none, and ``COLUMNS`` overrides both.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterator, Sequence
from typing import TextIO

from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.text.count import counted
from solvers.answers.data import Question, ResultData
from solvers.answers.limits import limits_text
from solvers.answers.pose_row import POINT_MASS, PoseRow, pose_rows
from solvers.answers.region_row import PAGE, RegionRow, advice, reasons, region_rows

Segment = tuple[str, str]
"""A text and its style."""
Line = list[Segment]
UNLIMITED = 1_000_000
"""Columns of a file."""
NARROWEST = 40
"""Columns below which lines are left to the terminal."""
MOST_REGIONS = 20
"""That are listed; the JSON and the report have all."""
MARGIN = "    "
_HARD = "\u00a0"
"""Stands for a space at which no line may end."""
_STYLES = {Stability.STABLE: "green", Stability.UNDECIDED: "yellow", Stability.UNSTABLE: "red"}


def print_result(result: ResultData, stream: TextIO) -> None:
    """Print the result as a table, with colour only on a terminal."""
    width = _columns(stream)
    if stream.isatty():
        from rich.console import Console
        from rich.text import Text

        console = Console(file=stream, no_color=bool(os.environ.get("NO_COLOR")), highlight=False)
        for line in _lines(result, width):
            console.print(Text.assemble(*line), soft_wrap=True)
    else:
        stream.write(text_of(result, width))
    stream.flush()


def text_of(result: ResultData, width: int = UNLIMITED) -> str:
    """Return the table as plain text.

    Parameters
    ----------
    result : ResultData
    width : int
        Columns: poses and regions whose rows are longer become blocks, longer sentences several lines.
    """
    lines = ("".join(text for text, _ in line).rstrip() + "\n" for line in _lines(result, width))
    return "".join(lines)


def title_of(result: ResultData) -> str:
    """Return what was asked, without the lengths, and the sentence of the result."""
    asked = asked_only(result.question, result.cables)
    cables = counted(len(result.cables), "cable")
    return f"{result.robot.name} ({result.model}, {cables}){asked}: {result.message}"


def asked_only(question: Question, cables: Sequence[str]) -> str:
    """Return by what a question was narrowed or widened, after a comma; empty for the usual one."""
    parts = []
    if question.taut is not None:
        parts.append(f"for taut {','.join(cables[i] for i in question.taut)} only")
    if question.ignore_slack:
        parts.append("other cables slack or not")
    if question.ignore_tension_sign:
        parts.append("tensions of any sign")
    if question.tension is not None:
        parts.append(f"tensions within {limits_text(question.tension)} only")
    return "".join(f", {part}" for part in parts)


def _columns(stream: TextIO) -> int:
    """Return how wide lines may be."""
    given = os.environ.get("COLUMNS", "")
    if given.isdecimal() and int(given) > 0:
        columns = int(given)
    else:
        try:
            columns = os.get_terminal_size(stream.fileno()).columns if stream.isatty() else UNLIMITED
        except (OSError, ValueError):
            columns = UNLIMITED
    return columns if columns >= NARROWEST else UNLIMITED


def _lines(result: ResultData, width: int) -> Iterator[Line]:
    for line in _wrapped(title_of(result), width):
        yield [(line, "bold")]
    yield from _poses(pose_rows(result), result.model != POINT_MASS, width)
    regions = region_rows(result)
    if regions:
        yield from _regions(regions, width)
    hints = advice(result)
    for hint in hints:
        yield from _prose(f"what helps: {hint}", width)
    if hints:
        yield from _prose(f"reading what is left open: {PAGE}", width)


def _poses(rows: Sequence[PoseRow], turns: bool, width: int) -> Iterator[Line]:
    if not rows:
        return
    head = ["#", "taut", "stability", "x m", "y m", "z m", *(("roll", "pitch", "yaw") if turns else ())]
    head += ["tensions N", "remarks"]
    body = [
        [str(row.number), row.taut, row.mark, *row.position, *row.angles, row.tensions_text, row.remarks]
        for row in rows
    ]
    table = _aligned([head, *body], left=("taut", "stability", "tensions N", "remarks"))
    if max(map(_length, table)) <= width:
        yield table[0]
        for row, (number, taut, (mark, _), *others) in zip(rows, table[1:], strict=True):
            yield [number, taut, (mark, _STYLES[row.stability]), *others]
        return
    for row in rows:
        yield []
        yield [(f"{row.number}  taut {row.taut}  ", ""), (row.mark.strip(), _STYLES[row.stability])]
        yield from _cells("pose m", [*row.position, *row.angles], width)
        yield from _cells("tensions N", [" ".join(tension) for tension in row.tensions], width)
        if row.remarks:
            yield from _prose(f"{MARGIN}{row.remarks}", width)


def _regions(rows: Sequence[RegionRow], width: int) -> Iterator[Line]:
    yield []
    head = ["undecided", "taut", "cells", "size m", "size deg", "x m", "y m", "z m"]
    head += ["roll", "pitch", "yaw"] if rows[0].angles else []
    shown = rows[:MOST_REGIONS]
    body = [
        [row.name, row.taut, str(row.cells), row.metres, row.degrees, *row.position, *row.angles]
        for row in shown
    ]
    table = _aligned([head, *body], left=("undecided", "taut"))
    if max(map(_length, table)) <= width:
        yield from table
    else:
        for row in shown:
            yield from _prose(f"undecided {row.name}  taut {row.taut}, {counted(row.cells, 'cell')}", width)
            yield from _cells("size", [row.size], width)
            yield from _cells("place m", row.position, width)
            if row.angles:
                yield from _cells("angles", row.angles, width)
    if len(rows) > len(shown):
        more = f"... {len(rows) - len(shown)} more, to {rows[-1].name}: in --json and in a report"
        yield from _prose(more, width)
    for names, reason in reasons(rows).items():
        yield from _prose(f"{names}: {reason}", width)


def _aligned(rows: Sequence[Sequence[str]], left: Sequence[str]) -> list[Line]:
    """Return rows with aligned columns, those named to the left, without those that are empty."""
    columns = [column for column in zip(*rows, strict=True) if any(column[1:])]
    lines: list[Line] = [[] for _ in rows]
    for column in columns:
        widest = max(map(len, column))
        for line, cell in zip(lines, column, strict=True):
            padded = cell.ljust(widest) if column[0] in left else cell.rjust(widest)
            line.append((f"{padded}  ", ""))
    return lines


def _length(line: Line) -> int:
    return len("".join(text for text, _ in line).rstrip())


def _cells(title: str, cells: Sequence[str], width: int) -> Iterator[Line]:
    """Yield cells under a title, none of them broken."""
    text = ", ".join(cell.replace(" ", _HARD) for cell in cells)
    start = f"{MARGIN}{title:<11}"
    for line in _wrapped(start.replace(" ", _HARD) + text, width, _HARD * len(start)):
        yield [(line, "")]


def _prose(text: str, width: int) -> Iterator[Line]:
    for line in _wrapped(text, width, MARGIN):
        yield [(line, "")]


def _wrapped(text: str, width: int, indent: str = "") -> list[str]:
    lines = textwrap.wrap(
        text, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
    return [line.replace(_HARD, " ") for line in lines]
