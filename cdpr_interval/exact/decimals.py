"""Rationals as decimals, exactly: as text, and as the Python number that says the same."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

from cdpr_interval.exact.range import Range

LONGEST_DECIMAL = 40
"""Digits of a decimal that people may still read."""
USUAL_DIGITS = 18
"""Behind the point, for nearly every number people type: tried first, a batch writes millions."""
USUAL_POWER = 10**USUAL_DIGITS
Plain = int | Decimal | Fraction
"""A `Fraction` only where no finite decimal says the same."""


def decimal_text(value: Fraction) -> str:
    """Return the exact decimal of a fraction whose denominator has factors 2 and 5 only.

    Raises
    ------
    ValueError
        The denominator has another factor: no finite decimal is the number.
    """
    if value.denominator == 1:
        return str(value.numerator)
    digits = USUAL_DIGITS
    if USUAL_POWER % value.denominator:
        # A denominator of b bits that divides a power of ten divides 10**b.
        digits = value.denominator.bit_length()
    share, rest = divmod(10**digits, value.denominator)
    if rest:
        raise ValueError(f"{value} is no finite decimal")
    text = str(abs(value.numerator) * share).rjust(digits + 1, "0")
    return f"{'-' if value < 0 else ''}{text[:-digits]}.{text[-digits:].rstrip('0')}"


def plain(value: Fraction) -> Plain:
    """Return a rational as an int, else as the decimal that is the same number, else as it is."""
    if value.denominator == 1:
        return value.numerator
    try:
        return Decimal(decimal_text(value))
    except ValueError:
        return value


def plain_scalar(value: Fraction | Range) -> Plain | list[Plain]:
    """Return a number as `plain` does, or a range as the list of its two ends where they differ."""
    if not isinstance(value, Range):
        return plain(value)
    return plain(value.lo) if value.lo == value.hi else [plain(value.lo), plain(value.hi)]


def rounded_down(value: Fraction, digits: int = 3) -> Decimal:
    """Return the largest decimal of some significant digits that is not above a positive number."""
    exponent = math.floor(math.log10(value)) - digits + 1
    unit = Fraction(10) ** exponent
    return Decimal(math.floor(value / unit)).scaleb(exponent)


def exact_text(value: Fraction, longest: int = LONGEST_DECIMAL) -> str:
    """Return a rational as a finite decimal where that has at most ``longest`` digits, else as p/q."""
    try:
        text = decimal_text(value)
    except ValueError:
        return str(value)
    return text if sum(map(str.isdigit, text)) <= longest else str(value)
