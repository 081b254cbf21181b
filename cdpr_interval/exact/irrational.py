"""Rational bounds of what is not rational: pi and square roots."""

from __future__ import annotations

import math
from fractions import Fraction

from cdpr_interval.exact.range import Range

BITS = 96
"""Fractional bits of a bound: 1e-29 m, far below any encoder, and fractions stay short."""
_PI_DIGITS = 3141592653589793238462643383279502884197
PI = Range(Fraction(_PI_DIGITS, 10**39), Fraction(_PI_DIGITS + 1, 10**39))


def outward(value: Range) -> Range:
    """Return the range with both bounds moved outwards to multiples of ``2**-BITS``."""
    scale = 1 << BITS
    return Range(Fraction(math.floor(value.lo * scale), scale), Fraction(math.ceil(value.hi * scale), scale))


def square_root(value: Range) -> Range:
    """Return bounds of the square root of every number in a range of non-negative ones."""
    scale = 1 << (2 * BITS)
    below = math.isqrt(math.floor(value.lo * scale))
    above = math.isqrt(math.ceil(value.hi * scale)) + 1
    return Range(Fraction(below, 1 << BITS), Fraction(above, 1 << BITS))


def root_bounds(x: Fraction) -> tuple[Fraction, Fraction]:
    """Enclose the square root of a positive rational to about 80 bits."""
    shift = max(0, 160 - x.numerator.bit_length() + x.denominator.bit_length())
    shift += shift % 2
    scaled = (x.numerator << shift) // x.denominator
    low = math.isqrt(scaled)
    unit = Fraction(1, 1 << (shift // 2))
    return low * unit, (low + 1) * unit
