"""Forms of integers in units of 2^-60, exact but for shifts: what the doubles' verdicts are compared with."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Self

import numpy as np
from flint import arb

from certificates.arithmetic.forms import Array, Form

BITS = 60
UNIT = 1 << BITS
FAR = UNIT << 200
"""Stands for infinity."""


def each(function: Callable[..., float]) -> Callable[..., Array]:
    """Return a function of arrays that computes entry by entry."""
    found = np.frompyfunc(function, function.__code__.co_argcount, 1)
    return lambda *x: np.asarray(found(*x), dtype=object)


def units(x: float) -> int:
    """Return a double in units, rounded down."""
    numerator, denominator = float(x).as_integer_ratio()
    return (numerator << BITS) // denominator


def down(x: arb) -> int:
    """Return an exact ball in units, rounded down."""
    mantissa, exponent = x.man_exp()
    shift = int(exponent) + BITS
    return int(mantissa) << shift if shift >= 0 else int(mantissa) >> -shift


def near(x: int) -> float:
    """Return a double near a number in units, infinite where there is none."""
    if abs(x) < FAR * FAR:
        return x / UNIT
    return math.inf if x > 0 else -math.inf


def shifted(x: Array) -> Array:
    """Return numbers that were in units of 1 / UNIT^2, rounded down."""
    return x >> BITS if x.size else x


all_units = each(units)
all_near = each(near)
all_units_up = each(lambda x: -units(-x))
all_quotients = each(lambda a, b: (a << BITS) // b + 1 if b > 0 else FAR)
all_square_quotients = each(lambda a, b: a * a // b if b > 0 else 0)
all_roots = each(lambda a: math.isqrt(a << BITS) + 1)


class Integers(Form):
    """A form of Python's integers, in arrays of objects."""

    UNIT = UNIT
    INFINITE = FAR

    @staticmethod
    def bound(terms: Sequence[tuple[Array, Array]], more: Array = 0) -> Array:
        """Every shift drops less than 1."""
        return sum((shifted(a * b) + 1 for a, b in terms), more)

    @staticmethod
    def quotient(a: Array, b: Array) -> Array:
        """Divide and round up; FAR where b is 0."""
        return all_quotients(a, b)

    @staticmethod
    def square_quotient(a: Array, b: Array) -> Array:
        """Divide and round down; 0 where b is 0."""
        return all_square_quotients(a, b)

    @staticmethod
    def root(a: Array) -> Array:
        """Return the next integer above."""
        return all_roots(a)

    @staticmethod
    def exceeds(a: Array, b: Array, c: Array, d: Array) -> Array:
        """Exact."""
        return np.asarray(a * b >= c * d, dtype=bool)

    @classmethod
    def numbers(cls, x: Array) -> Array:
        """Round down."""
        return all_units(x)

    @classmethod
    def numbers_up(cls, x: Array) -> Array:
        """Round up."""
        return all_units_up(x)

    @staticmethod
    def doubles_near(x: Array) -> Array:
        """Round once."""
        return all_near(x).astype(float)

    @classmethod
    def between(cls, lo: Array, hi: Array, symbol: int) -> Self:
        """Return the middle, which may be half a unit off, and a radius that covers it."""
        low, high = all_units(lo), all_units_up(hi)
        found = cls.unknown((high - low + 1) >> 1, symbol)
        return cls((low + high) >> 1, found.slopes, found.curves, found.rest)

    @classmethod
    def enclosing(cls, x: arb) -> Self:
        """Round middle and radius down, by less than 1 each."""
        found = cls.unknown(np.array([0 if x.is_zero() else down(x.rad()) + 2], dtype=object))
        return cls(np.array([down(x.mid())], dtype=object), found.slopes, found.curves, found.rest)

    def after_sum(self) -> Self:
        """Nothing is dropped."""
        return self

    def after_products(self, sizes: Sequence[tuple[Array, Array]]) -> Self:
        """Every shift drops less than 1: of the value, the rest, each other coefficient."""
        dropped = 2 + len(self.slopes) + len(self.curves) + len(self.drifts)
        self.value, self.slopes = shifted(self.value), shifted(self.slopes)
        self.curves, self.drifts = shifted(self.curves), shifted(self.drifts)
        self.rest = shifted(self.rest) + dropped
        return self

    def total(self, coefficients: Array) -> Array:
        """Exact."""
        return np.sum(abs(coefficients), axis=0, initial=0) + 0 * self.value

    def lowest(self) -> Array:
        """Exact."""
        return self.value - self.change()

    def within(self, lo: Array, hi: Array) -> Array:
        """Exact: bounds are rounded inwards."""
        found = (self.lowest() >= all_units_up(lo)) & (self.highest() <= all_units(hi))
        return np.asarray(found, dtype=bool)
