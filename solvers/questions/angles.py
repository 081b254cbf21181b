"""Angles of drives as a user writes them, exactly: 30deg, 0.5rad, 30deg+-0.1deg, 29deg..31deg."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.exact.angle import Angle
from cdpr_interval.exact.range import Range
from cdpr_interval.text.literal import quote
from solvers.questions.ranges import read_range, show
from solvers.questions.units import DEGREES, Units, entries_of

DEGREE: Units = dict.fromkeys(DEGREES, Fraction(1))
RADIAN: Units = {"rad": Fraction(1)}


def read_angle(value: Any) -> Angle:
    """Return an exact angle or range of angles; a number, or a pair of numbers, is in rad.

    Raises
    ------
    ValueError
        It is no angle, or a text without a unit that is not zero.
    """
    if not isinstance(value, str):
        return Angle(Range(*read_range(value, RADIAN)), in_degrees=False)
    in_degrees = any(unit in value for unit in DEGREES)
    found = Range(*read_range(value, DEGREE if in_degrees else RADIAN))
    if not in_degrees and "rad" not in value and found != Range.exact(0):
        shown = show(found.lo) if found.lo == found.hi else "each number"
        raise ValueError(f"{quote(value)} has no unit: write {shown}deg or {shown}rad")
    return Angle(found, in_degrees)


def read_triple(given: Any, label: str, reader: Any, what: str) -> tuple[Any, Any, Any]:
    """Return three values of a text or a sequence, each read by ``reader``.

    Raises
    ------
    InputError
        One message per entry that is wrong, or that there are not three.
    """
    if not isinstance(given, str) and not hasattr(given, "__len__"):
        raise InputError(f"{label}: must hold three {what}, got {given!r}")
    entries: Sequence[Any] = entries_of(given, label) if isinstance(given, str) else list(given)
    errors, found = [], []
    if len(entries) != 3:
        errors.append(f"{label}: must hold three {what}, got {len(entries)}")
    for index, entry in enumerate(entries):
        try:
            found.append(reader(entry.strip() if isinstance(entry, str) else entry))
        except ValueError as error:
            errors.append(f"{label}[{index}]: {error}")
    if errors:
        raise InputError(*errors)
    return found[0], found[1], found[2]
