"""Numbers with a tolerance and ranges, as a user writes them: one reader for lengths, tensions and forces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from cdpr_interval.text.literal import quote
from cdpr_interval.text.number import exact_number
from solvers.questions.units import Units, read_quantity, split_unit

TOLERANCES = ("+/-", "+-", "±")
"""Marks between a number and its tolerance."""


def read_range(value: Any, units: Units) -> tuple[Fraction, Fraction]:
    """Return exact bounds lo <= hi; equal for a single number.

    Parameters
    ----------
    value : number, str or pair
        A number; a text: a number, ``2.69+-0.01``, ``2.68..2.70`` or ``[2.68, 2.70]``; a pair (lo, hi).
    units : mapping from str to Fraction
        Units that texts may have; the first is that of the result.

    Raises
    ------
    ValueError
        With the rule and the actual value.
    """
    if isinstance(value, str):
        lo, hi = _read_text(value.strip(), units)
    elif (ends := _pair(value)) is not None:
        lo, hi = exact_number(ends[0]), exact_number(ends[1])
    else:
        lo = hi = exact_number(value)
    if lo > hi:
        raise ValueError(f"the lower bound {show(lo)} is above the upper bound {show(hi)}")
    return lo, hi


def around(middle: Fraction, tolerance: Fraction, text: str = "") -> tuple[Fraction, Fraction]:
    """Return the bounds of a number with a tolerance; `ValueError` for a negative one."""
    if tolerance < 0:
        raise ValueError(f"the tolerance{text and f' of {quote(text)}'} is negative")
    return middle - tolerance, middle + tolerance


def show(value: Fraction) -> str:
    """Return a short decimal for messages."""
    return repr(int(value)) if value.denominator == 1 and abs(value) < 10**15 else repr(float(value))


def _read_text(text: str, units: Units) -> tuple[Fraction, Fraction]:
    if text.startswith("[") and text.endswith("]"):
        ends = text[1:-1].split(",")
        if len(ends) != 2:
            raise ValueError(f"{quote(text)} is not a range [lo,hi]")
        return _both(text, ends[0], ends[1], units)
    for mark in TOLERANCES:
        if mark in text:
            centre, _, tolerance = text.partition(mark)
            return around(*_both(text, centre, tolerance, units), text)
    if ".." in text:
        lower, _, upper = text.partition("..")
        return _both(text, lower, upper, units)
    value = read_quantity(text, units)
    return value, value


def _both(text: str, one: str, other: str, units: Units) -> tuple[Fraction, Fraction]:
    """Return two numbers of one text: a unit that only one of them has could be meant for both."""
    one, other = one.strip(), other.strip()
    values = read_quantity(one, units), read_quantity(other, units)
    if (split_unit(one)[1] is None) != (split_unit(other)[1] is None):
        raise ValueError(f"in {quote(text)} one number has a unit: give both one, or none")
    return values


def _pair(value: Any) -> Sequence[Any] | None:
    """Return the two ends when the value is a list, tuple or array; None for a single number."""
    if isinstance(value, Mapping) or not hasattr(value, "__len__"):
        return None
    if len(value) != 2:
        raise ValueError(f"must be a number or a pair (lo, hi), got {value!r}")
    ends: Sequence[Any] = value
    return ends
