"""Exact numbers as text that reads back as the same number."""

from __future__ import annotations

from fractions import Fraction

LONGEST_DECIMAL = 40
"""Digits."""


def exact_text(x: Fraction, longest: int = LONGEST_DECIMAL) -> str:
    """Return a finite decimal where it has at most ``longest`` digits, else p/q."""
    twos, rest = 0, x.denominator
    while rest % 2 == 0:
        twos, rest = twos + 1, rest // 2
    fives = 0
    while rest % 5 == 0:
        fives, rest = fives + 1, rest // 5
    places = max(twos, fives)
    digits = str(abs(x.numerator) * 10**places // x.denominator).rjust(places + 1, "0") if rest == 1 else ""
    if rest != 1 or len(digits) > longest:
        return str(x)
    sign = "-" if x < 0 else ""
    return sign + (f"{digits[:-places]}.{digits[-places:]}" if places else digits)
