"""CSV files: their cells, and what is said of heads that cannot be read."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from cdpr_interval.errors import InputError
from cdpr_interval.files.document import suggestion
from cdpr_interval.text.literal import quote

OTHER_SEPARATORS = {";": "';'", "\t": "tabs", "|": "'|'"}


def cells_of(path: Path, name: str, wanted: str) -> list[list[str]]:
    """Return the cells of a file of at least two lines; messages call it ``name`` and say what is wanted.

    Raises
    ------
    InputError
        It cannot be read, or has fewer lines.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            table = list(csv.reader(stream))
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"file {quote(name)}: {reason}") from None
    if len(table) < 2:
        raise InputError(f"file {quote(name)}: needs {wanted}")
    return table


def require_commas(head: Sequence[str], place: str) -> None:
    """Raise `InputError` where something else than commas seems to part the columns."""
    for sign, called in OTHER_SEPARATORS.items():
        if any(sign in title for title in head):
            rule = f"columns are separated by {called}: write commas, and decimals with a point"
            raise InputError(f"{place}: {rule}")


def unknown_title(column: int, title: str, known: Sequence[str]) -> str:
    """Return what is said of a column with a title that is not among those known."""
    if not title:
        return f"column {column + 1} has no title: a column of your own begins with x_"
    same = {one.lower(): one for one in known}.get(title.lower())
    hint = (
        suggestion(same or title, known) or f": a column of your own begins with x_ ({quote('x_' + title)})"
    )
    return f"unknown column {quote(title)}{hint}"
