"""Numbers with a unit, as people type them: lengths in m, forces in N, times in s, angles in deg or rad.

A length without unit is in m, a force in N, a time in s. An angle without unit is refused unless it is zero:
tables print degrees, formulas use radians, and neither can be told from the number.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from fractions import Fraction

from cdpr_interval.errors import InputError
from cdpr_interval.text.literal import quote, read_number
from cdpr_interval.text.number import exact_number

Units = Mapping[str, Fraction]
METRES: Units = {"m": Fraction(1), "cm": Fraction(1, 100), "mm": Fraction(1, 1000)}
"""Units of lengths, in m."""
NEWTONS: Units = {"N": Fraction(1), "kN": Fraction(1000)}
"""Units of forces, in N."""
SECONDS: Units = {"s": Fraction(1), "min": Fraction(60), "h": Fraction(3600), "ms": Fraction(1, 1000)}
"""Units of times, in s."""
DEGREES = ("deg", "°")
ANGLES = (*DEGREES, "rad")
KINDS = {
    **dict.fromkeys(METRES, "a length"),
    **dict.fromkeys(NEWTONS, "a force"),
    **dict.fromkeys(SECONDS, "a time"),
    **dict.fromkeys(ANGLES, "an angle"),
}
"""Of what a unit is."""

_COMMA_ALONE = re.compile(r"[0-9],[0-9]")
_SPACE_ALONE = re.compile(r"[0-9.A-Za-z\u00b0]\s+[-+]?[0-9.]")
COMMA_OUTSIDE_BRACKETS = re.compile(r",(?![^\[\]]*\])")
_IN_BRACKETS = re.compile(r"\[[^\]]*\]")
_AROUND_RANGES = re.compile(r"\s*(\+/-|\+-|±|\.\.)\s*")
_WITH_UNIT = re.compile(rf"(.*?[0-9.])\s*({'|'.join(KINDS)})", re.DOTALL)
_BEFORE_UNIT = re.compile(rf"(?<=[0-9.])\s+(?=({'|'.join(KINDS)})(?![A-Za-z]))")


def entries_of(text: str, label: str) -> list[str]:
    """Return the entries of a list typed with commas, with spaces, or with both.

    A unit may stand apart from its number (``5 deg``): it belongs to the entry before it. So may the ends of
    a range (``1 .. 2``, ``1 +- 0.1``), which is one entry. The list may stand in brackets.

    Raises
    ------
    InputError
        Some entries are parted by spaces alone, others by commas alone: ``0,5 0,2 1`` means decimals.
    """
    text = _BEFORE_UNIT.sub("", without_brackets(text))
    text = _AROUND_RANGES.sub(r"\1", _IN_BRACKETS.sub(lambda found: "".join(found[0].split()), text))
    outside = _IN_BRACKETS.sub("", text)
    if _COMMA_ALONE.search(outside) and _SPACE_ALONE.search(outside):
        raise InputError(
            f"{label}: decimals have a point, entries stand between commas or spaces, not {quote(text)}"
        )
    return [word for part in COMMA_OUTSIDE_BRACKETS.split(text) for word in part.split() or [""]]


def without_brackets(text: str) -> str:
    """Return what stands in the brackets around a whole list, ``[1,2]`` or ``(1,2)``."""
    text = text.strip()
    inner = text[1:-1]
    if text[:1] + text[-1:] not in ("[]", "()") or _closes_early(inner):
        return text
    return inner


def _closes_early(text: str) -> bool:
    """Return whether brackets are closed that are not opened: ``1],[2``."""
    depth = 0
    for character in text:
        depth += (character in "[(") - (character in "])")
        if depth < 0:
            return True
    return False


def read_metres(text: str) -> Fraction:
    """Return an exact length in m of a number with or without a unit; `ValueError` for anything else."""
    return read_quantity(text, METRES)


def read_seconds(text: str) -> Fraction:
    """Return an exact time in s of a number with or without a unit; `ValueError` for anything else."""
    return read_quantity(text, SECONDS)


def read_quantity(text: str, units: Units) -> Fraction:
    """Return the exact value of a number with or without one of some units, in the first of these.

    Raises
    ------
    ValueError
        It is no number, or has the unit of something else.
    """
    value, unit = split_unit(text)
    if unit is None:
        return _number(text, units)
    if unit not in units:
        kind = KINDS[next(iter(units))] if units else "a number without a unit"
        raise ValueError(f"{quote(text)} is {KINDS[unit]}, not {kind}")
    return exact_number(_number(value, units) * units[unit])


def read_radians(text: str) -> float:
    """Return an angle in rad; `ValueError` for what is none, or has no unit and is not zero."""
    value, unit = split_unit(text)
    if unit is not None and unit not in ANGLES:
        raise ValueError(f"{quote(text)} is {KINDS[unit]}, not an angle")
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
        if text.lstrip("+-.")[:1].isdigit() and text[-1:].isalpha():
            known = f"units are {', '.join(units)}" if units else "it has no unit here"
            raise ValueError(f"{error} ({known})") from None
        raise
