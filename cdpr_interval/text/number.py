"""Python values as the exact numbers they are."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction
from numbers import Rational
from typing import Any

from cdpr_interval.text.literal import LARGEST_EXPONENT, read_number

_SMALLEST = Fraction(1, 10**LARGEST_EXPONENT)
_LARGEST = Fraction(10**LARGEST_EXPONENT)
SMALLEST, LARGEST = float(_SMALLEST), float(_LARGEST)
"""Positive doubles are in range when SMALLEST <= x < LARGEST: both are rounded up."""


def exact_number(value: Any) -> Fraction:
    """Return the exact value of a number.

    Parameters
    ----------
    value : int, float, str, Decimal, Fraction or numpy scalar
        A float means that very double, a str the decimal that is written.

    Raises
    ------
    ValueError
        When it is no number, not finite or out of range (0, or 1e-100 to 1e100 in size).
    """
    if type(value) is float and SMALLEST <= abs(value) < LARGEST:
        # The usual case first: it is asked many times a second.
        return Fraction(value)
    if isinstance(value, str):
        return read_number(value.strip())
    if callable(item := getattr(value, "item", None)):
        # A numpy scalar: Fraction would keep its 64-bit integers, which overflow.
        value = item()
    if isinstance(value, bool) or not isinstance(value, Rational | Decimal | float):
        raise ValueError(f"{value!r} is not a number")
    if not isinstance(value, Rational) and not math.isfinite(value):
        raise ValueError(f"{value} is not a finite number")
    if isinstance(value, Decimal) and value and abs(value.adjusted()) > LARGEST_EXPONENT:
        # Looked at before the exact fraction is built: it may have a billion digits.
        raise ValueError(f"{value} is out of range")
    number = Fraction(value)
    if number and not _SMALLEST <= abs(number) <= _LARGEST:
        raise ValueError(f"{value!r} is out of range")
    return number
