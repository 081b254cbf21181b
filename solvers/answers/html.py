"""A result as a piece of HTML for notebooks: the table, without anything to install."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from solvers.answers import ik_table
from solvers.answers.data import ResultData
from solvers.answers.inverse import IkData
from solvers.answers.pose_row import POINT_MASS, PoseRow, pose_rows
from solvers.answers.region_row import region_rows
from solvers.answers.table import title_of

MOST_ROWS = 100
"""Of one table: a notebook is to be scrolled through; the report has them all."""


def html_of(result: ResultData) -> str:
    """Return the sentence, the poses and the undecided regions of a result."""
    turns = result.model != POINT_MASS
    head = ["", "taut", "stability", "x m", "y m", "z m"]
    head += ["roll", "pitch", "yaw"] if turns else []
    poses = pose_rows(result)
    parts = [f"<p><b>{escape(title_of(result))}</b></p>"]
    if poses:
        has_remarks = any(row.remarks for row in poses)
        head += ["tensions N", "remarks"] if has_remarks else ["tensions N"]
        parts.append(_table(head, (_pose(row)[: len(head)] for row in poses), len(poses)))
    regions = region_rows(result)
    if regions:
        found = ([row.name, row.taut, row.size, *row.position, *row.angles, row.reason] for row in regions)
        columns = ["", "taut", "size", "x m", "y m", "z m", *(["roll", "pitch", "yaw"] if turns else [])]
        parts.append("<p>Undecided regions</p>")
        parts.append(_table([*columns, "reason"], found, len(regions)))
    return f"<div>{''.join(parts)}</div>"


def ik_html_of(result: IkData) -> str:
    """Return the sentence, the poses, the cables and what can be pasted of a result of inverse kinematics."""
    parts = [f"<p><b>{escape(ik_table.title_of(result))}</b></p>"]
    parts += [f"<p>{name} {escape(place)}</p>" for name, place in ik_table.poses_of(result)]
    columns = 5 if ik_table.outside_of(result) else 4
    rows = ik_table.rows_of(result)
    parts.append(_table((*ik_table.HEAD, "remarks")[:columns], (row[:columns] for row in rows), len(rows)))
    parts += [f"<p><code>{escape(option)}</code></p>" for option in ik_table.options_of(result)]
    return f"<div>{''.join(parts)}</div>"


def _pose(row: PoseRow) -> list[str]:
    return [
        str(row.number), row.taut, row.mark, *row.position, *row.angles, row.tensions_text, row.remarks,
    ]  # fmt: skip


def _table(head: Sequence[str], rows: Iterable[Sequence[str]], count: int) -> str:
    lines = ["".join(f"<th>{escape(cell)}</th>" for cell in head)]
    shown = [row for row, _ in zip(rows, range(MOST_ROWS), strict=False)]
    lines += ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in shown]
    more = f"<p>and {count - MOST_ROWS} more</p>" if count > MOST_ROWS else ""
    return "<table>" + "".join(f"<tr>{line}</tr>" for line in lines) + f"</table>{more}"
