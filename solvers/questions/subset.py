"""The subset of cables a user asks for: names or indices, turned into ascending indices."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Sequence
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.files.document import suggestion
from cdpr_interval.text.literal import quote


def read_subset(given: Any, names: Sequence[str], label: str = "taut") -> tuple[int, ...]:
    """Return the ascending indices of the cables given.

    Parameters
    ----------
    given : str or iterable of str or int
        ``c1,c3`` as after ``--taut``, or names and indices (from 0).
    names : sequence of str
        The robot's cables, file order.
    label : str
        What messages call the argument.

    Raises
    ------
    InputError
        One message per unknown or repeated cable; also when nothing is given.
    """
    entries: Iterable[Any] = [part.strip() for part in given.split(",")] if isinstance(given, str) else given
    if not isinstance(entries, Iterable):
        raise InputError(f"{label}: must hold names or indices of cables, got {given!r}")
    errors: list[str] = []
    indices: set[int] = set()
    for place, entry in enumerate(entries):
        try:
            index = _index(entry, names)
        except ValueError as error:
            errors.append(f"{label}[{place}]: {error}")
            continue
        if index in indices:
            errors.append(f"{label}[{place}]: cable {quote(names[index])} is given twice")
        indices.add(index)
    if not indices and not errors:
        errors.append(f"{label}: names no cable")
    if errors:
        raise InputError(*errors)
    return tuple(sorted(indices))


def _index(entry: Any, names: Sequence[str]) -> int:
    if isinstance(entry, str):
        if entry not in names:
            raise ValueError(f"unknown cable {quote(entry)}{suggestion(entry, names)}")
        return names.index(entry)
    try:
        index = operator.index(entry)
    except TypeError:
        raise ValueError(f"{entry!r} is neither a cable name nor an index") from None
    if isinstance(entry, bool) or not 0 <= index < len(names):
        raise ValueError(f"{entry!r} is not an index from 0 to {len(names) - 1}")
    return index
