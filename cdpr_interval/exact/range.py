"""A number known to lie between two exact bounds."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from functools import reduce
from typing import NamedTuple

from cdpr_interval.exact.vector import Vector


class Range(NamedTuple):
    """Exact rational bounds of a real number; arithmetic encloses.

    ``lo, hi = range`` takes it apart, ``x in range`` asks whether a number lies between the bounds.
    """

    lo: Fraction
    hi: Fraction

    @staticmethod
    def exact(x: Fraction | int) -> Range:
        """Return the range of one number."""
        return Range(Fraction(x), Fraction(x))

    @property
    def mid(self) -> Fraction:
        """The middle: the nominal value."""
        return (self.lo + self.hi) / 2

    @property
    def width(self) -> Fraction:
        """Upper minus lower bound."""
        return self.hi - self.lo

    def __add__(self, other: Range) -> Range:  # type: ignore[override]
        return Range(self.lo + other.lo, self.hi + other.hi)

    def __neg__(self) -> Range:
        return Range(-self.hi, -self.lo)

    def __sub__(self, other: Range) -> Range:
        return Range(self.lo - other.hi, self.hi - other.lo)

    def __mul__(self, other: Range) -> Range:  # type: ignore[override]
        products = [a * b for a in self for b in other]
        return Range(min(products), max(products))

    def __truediv__(self, other: Range) -> Range:
        """Divide by a range of positive numbers."""
        return self * Range(1 / other.hi, 1 / other.lo)

    def squared(self) -> Range:
        """Return the range of the squares."""
        lo, hi = self.lo**2, self.hi**2
        return Range(Fraction(0) if self.lo < 0 < self.hi else min(lo, hi), max(lo, hi))

    def __contains__(self, value: object) -> bool:
        return isinstance(value, Fraction | int) and self.lo <= value <= self.hi

    def meets(self, other: Range) -> bool:
        """Return whether the two have a point in common."""
        return self.lo <= other.hi and other.lo <= self.hi

    def hull(self, other: Range) -> Range:
        """Return the smallest range around both."""
        return Range(min(self.lo, other.lo), max(self.hi, other.hi))

    def widened(self, by: Fraction | int) -> Range:
        """Return the range with both bounds moved outwards by a distance."""
        return Range(self.lo - by, self.hi + by)


def as_range(x: Fraction | Range) -> Range:
    """Return a range, of a number the one that holds only it."""
    return x if isinstance(x, Range) else Range(x, x)


def hull_of(ranges: Iterable[Range]) -> Range:
    """Return the smallest range around some ranges, one at least."""
    return reduce(Range.hull, ranges)


RangeVector = tuple[Range, Range, Range]


def difference(a: RangeVector, b: RangeVector) -> RangeVector:
    """Return a - b of vectors that do not depend on each other."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def middle_of(v: RangeVector) -> Vector:
    """Return the middle of each entry."""
    return (v[0].mid, v[1].mid, v[2].mid)


LengthRange = tuple[Fraction, Fraction]
"""(lo, hi) in m of a cable's length, as questions carry it: any pair, a `Range` too."""
