"""Tension limits of a question, as a user gives them: poses are asked for whose taut cables keep to them."""

from __future__ import annotations

from typing import Any

from cdpr_interval.errors import InputError
from cdpr_interval.exact.range import LengthRange
from solvers.questions.arguments import shown
from solvers.questions.ranges import read_range, show
from solvers.questions.units import NEWTONS


def read_tension_limits(given: Any, label: str = "tension") -> LengthRange:
    """Return exact limits 0 <= lo < hi in N, written as ranges of lengths are (``10N..1kN``).

    Raises
    ------
    InputError
        They are no range, the lower one is not below the upper one, or one is negative.
    """
    try:
        lo, hi = read_range(given, NEWTONS)
    except ValueError as error:
        raise InputError(f"{label}: {error}") from None
    if lo < 0:
        raise InputError(f"{label}: a cable's tension is never negative, got the lower limit {show(lo)}")
    if lo == hi:
        raise InputError(f"{label}: must be a range such as 10..1000, got {shown(given)}")
    return lo, hi
