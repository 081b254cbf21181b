"""The constant external force at the centre of mass, as a user gives it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.exact.range import Range
from cdpr_interval.exact.vector import Vector
from cdpr_interval.mechanics.loaded import LoadedRobot
from cdpr_interval.robots.numbers import Point, Scalar, exact_point
from solvers.questions.ranges import read_range
from solvers.questions.units import NEWTONS, entries_of

ZERO: Vector = (Fraction(0), Fraction(0), Fraction(0))
NO_LOAD = "the weight and the external force cancel; without a load there are no statics"
MAY_CANCEL = "the weight and the external force may cancel within their ranges; there are no statics then"


def read_force(given: Sequence[Any], label: str = "external_force") -> Vector:
    """Return an exact force in N; `InputError` names every entry that is no force, or a range."""
    force = read_force_ranges(given, label)
    ranges = [f"{label}[{k}]" for k, x in enumerate(force) if isinstance(x, Range)]
    if ranges:
        raise InputError(*(f"{place}: must be one number here, got a range" for place in ranges))
    return exact_point(force)


def read_force_ranges(given: Sequence[Any], label: str = "external_force") -> Point:
    """Return a force in N, each entry an exact number or a range, written as lengths are (``-10N``).

    Raises
    ------
    InputError
        Names every entry that is neither, or no force.
    """
    if not isinstance(given, Iterable):
        raise InputError(f"{label}: must hold 3 numbers, got {given!r}")
    values = entries_of(given, label) if isinstance(given, str) else list(given)
    if len(values) != 3:
        raise InputError(f"{label}: must hold 3 numbers, got {len(values)}")
    errors: list[str] = []
    entries: list[Scalar] = []
    for index, value in enumerate(values):
        try:
            lo, hi = read_range(value, NEWTONS)
            entries.append(lo if lo == hi else Range(lo, hi))
        except ValueError as error:
            errors.append(f"{label}[{index}]: {error}")
    if errors:
        raise InputError(*errors)
    x, y, z = entries
    return x, y, z


def no_load(under_load: LoadedRobot) -> str | None:
    """Return why a load is none, or may be none within the ranges; None where it is one for every choice."""
    if under_load.is_exact:
        return None if any(under_load.load) else NO_LOAD
    ranges = under_load.load_ranges
    if not all(lo <= 0 <= hi for lo, hi in ranges):
        return None
    return NO_LOAD if not any(map(any, ranges)) else MAY_CANCEL
