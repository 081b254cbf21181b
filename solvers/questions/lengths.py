"""Cable lengths as a user writes them, turned into exact ranges in file order.

A length is a number (``2.69``), a number with a tolerance (``2.69+-0.01``, ``2.69+/-0.01``, ``2.69±0.01``), a
range (``2.68..2.70`` or ``[2.68,2.70]``), each the exact decimal that is written, in m or with its unit
(``2690mm``, ``269cm``; then both numbers have one); from Python also a float (that exact double),
an int, a `Decimal` or `Fraction` (exact), or a pair (lo, hi) of these. Where there are several cables the
whole list may stand in brackets.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence, Set
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.exact.range import LengthRange
from cdpr_interval.files.document import suggestion
from cdpr_interval.text.count import counted
from cdpr_interval.text.literal import quote
from solvers.questions.ranges import read_range, show
from solvers.questions.units import COMMA_OUTSIDE_BRACKETS, METRES, Units, without_brackets

_NAMED = re.compile(r"([A-Za-z_][A-Za-z0-9_.-]*)\s*=(.*)", re.DOTALL)


def read_lengths(
    given: Any, names: Sequence[str], label: str = "lengths", units: Units = METRES
) -> tuple[LengthRange, ...]:
    """Return one exact range per cable, in file order.

    Parameters
    ----------
    given : str, sequence or mapping
        Text as after ``--lengths`` (``2.69,3.90`` or ``c1=2.69,c2=3.90``), a sequence in file order, or
        a mapping from cable name to length, m.
    names : sequence of str
        The robot's cables, file order.
    label : str
        What messages call the argument.
    units : mapping from str to Fraction
        Units that texts may have, of other quantities than lengths; the first is that of the result.

    Returns
    -------
    tuple of (Fraction, Fraction)
        (lo, hi) in m with 0 < lo <= hi.

    Raises
    ------
    InputError
        One message per entry that is wrong, ``--lengths[2]: 'abc' is not a number``.
    """
    errors: list[str] = []
    entries = split_entries(given, names, label, errors)
    ranges = []
    for place, value in entries:
        try:
            ranges.append(read_length(value, units))
        except ValueError as error:
            errors.append(f"{place}: {error}")
    if errors:
        raise InputError(*errors)
    return tuple(ranges)


def split_entries(given: Any, names: Sequence[str], label: str, errors: list[str]) -> list[tuple[str, Any]]:
    """Return (place for messages, value) for each cable in file order, noting in ``errors`` what is amiss.

    Where the entries do not match the cables, those that were found are returned, so that their own
    errors can be reported too.
    """
    if isinstance(given, str):
        # Of one cable, brackets are those of a range.
        text = without_brackets(given) if len(names) > 1 else given
        parts = [part.strip() for part in COMMA_OUTSIDE_BRACKETS.split(text)]
        pairs = [_NAMED.fullmatch(part) for part in parts]
        if not any(pairs):
            return _listed(parts, names, label, errors)
        named = []
        for index, (part, pair) in enumerate(zip(parts, pairs, strict=True)):
            if pair is None:
                errors.append(f"{label}[{index}]: {quote(part)} has no name although others have")
            else:
                named.append((pair[1], pair[2].strip()))
        return match_names(named, names, label, errors)
    if isinstance(given, Mapping):
        return match_names(given.items(), names, label, errors)
    if isinstance(given, Set):
        errors.append(f"{label}: must be a list with one length per cable, a set has no order")
        return []
    try:
        listed = list(given)
    except TypeError:
        errors.append(f"{label}: must be a list with one length per cable, got {given!r}")
        return []
    return _listed(listed, names, label, errors)


def _listed(
    values: Sequence[Any], names: Sequence[str], label: str, errors: list[str]
) -> list[tuple[str, Any]]:
    if len(values) != len(names):
        given = counted(len(values), "length")
        errors.append(f"{label}: {given} for {counted(len(names), 'cable')} ({', '.join(names)})")
    return [(f"{label}[{index}]", value) for index, value in enumerate(values)]


def match_names(
    named: Iterable[tuple[Any, Any]], names: Sequence[str], label: str, errors: list[str]
) -> list[tuple[str, Any]]:
    """Return (place, value) in file order, noting unknown, repeated and missing names in ``errors``."""
    found: dict[str, Any] = {}
    for name, value in named:
        if name not in names:
            hint = suggestion(str(name), names)
            errors.append(f"{label}: unknown cable {quote(str(name))}{hint}")
        elif name in found:
            errors.append(f"{label}: cable {quote(name)} is given twice")
        else:
            found[name] = value
    missing = [name for name in names if name not in found]
    if missing:
        errors.append(f"{label}: no length for {', '.join(missing)}")
    return [(f"{label}[{name}]", found[name]) for name in names if name in found]


def read_length(value: Any, units: Units = METRES) -> LengthRange:
    """Return the exact range of one length.

    Raises
    ------
    ValueError
        With the rule and the actual value.
    """
    lo, hi = read_range(value, units)
    if lo <= 0:
        part = "" if lo == hi else " over its whole range"
        raise ValueError(f"must be positive{part}, got {show(lo)}")
    return lo, hi
