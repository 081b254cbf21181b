"""Numbers with a unit, as people type them: lengths in m, cm or mm, angles in deg or rad.

A length without unit is in m. An angle without unit is refused unless it is zero: tables print degrees,
formulas use radians, and neither can be told from the number.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from fractions import Fraction

from cdpr_interval.errors import InputError
from cdpr_interval.text.literal import quote, read_number
from cdpr_interval.text.number import exact_number

METRES = {"m": Fraction(1), "cm": Fraction(1, 100), "mm": Fraction(1, 1000)}
"""Units of lengths, in m."""
DEGREES = ("deg", "°")
ANGLES = (*DEGREES, "rad")
UNITS = (*METRES, *ANGLES)

_COMMA_ALONE = re.compile(r"[0-9],[0-9]")
_SPACE_ALONE = re.compile(r"[0-9.a-z\u00b0]\s+[-+]?[0-9.]")
_WITH_UNIT = re.compile(r"(.*?[0-9.])\s*(mm|cm|m|deg|°|rad)", re.DOTALL)


def entries_of(text: str, label: str) -> list[str]:
    """Return the entries of a list typed with commas, with spaces, or with both.

    A unit may stand apart from its number (``5 deg``): it belongs to the entry before it.

    Raises
    ------
    InputError
        Some entries are parted by spaces alone, others by commas alone: ``0,5 0,2 1`` means decimals.
    """
    entries: list[str] = []
    if _COMMA_ALONE.search(text) and _SPACE_ALONE.search(text):
        raise InputError(
            f"{label}: decimals have a point, entries stand between commas or spaces, not {quote(text)}"
        )
    for part in text.split(","):
        words = part.split() or [""]
        first = len(entries)
        for word in words:
            if word in UNITS and len(entries) > first:
                entries[-1] += word
            else:
                entries.append(word)
    return entries


def read_metres(text: str) -> Fraction:
    """Return an exact length in m of a number with or without a unit; `ValueError` for anything else."""
    value, unit = split_unit(text)
    if unit is None:
        return _number(text, METRES)
    if unit not in METRES:
        raise ValueError(f"{quote(text)} is an angle, not a length")
    return exact_number(_number(value, METRES) * METRES[unit])


def read_radians(text: str) -> float:
    """Return an angle in rad; `ValueError` for what is none, or has no unit and is not zero."""
    value, unit = split_unit(text)
    if unit in METRES:
        raise ValueError(f"{quote(text)} is a length, not an angle")
    number = float(_number(value, ANGLES))
    if unit is None and number:
        shown = value if len(value) <= 20 else f"{number:g}"
        raise ValueError(f"{quote(text)} has no unit: write {shown}deg or {shown}rad")
    return math.radians(number) if unit in DEGREES else number


def split_unit(text: str) -> tuple[str, str | None]:
    """Return a number's text and its unit, None where there is none."""
    # The usual case first: a batch reads millions.
    found = None if text[-1:].isdigit() else _WITH_UNIT.fullmatch(text)
    return (text, None) if found is None else (found[1], found[2])


def _number(text: str, units: Iterable[str]) -> Fraction:
    try:
        return read_number(text)
    except ValueError as error:
        if text[:1].isdigit() and text[-1:].isalpha():
            raise ValueError(f"{error} (units are {', '.join(units)})") from None
        raise
