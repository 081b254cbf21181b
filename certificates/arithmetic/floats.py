"""Forms of doubles, all cells in one operation of numpy, and why they enclose what they say.

Sums, products, quotients and roots of arrays are, entry by entry, those of IEEE 754 doubles, rounded to
nearest: |x o y - fl(x o y)| <= u |x o y| + 2^-1074 with u = 2^-53. `machine_rounds` tries that. Below u is
taken twice as large, which covers entries that are computed with more digits and rounded again.

1. A coefficient of a product is a sum of at most four products of coefficients, four roundings deep: it is
   off by at most 4.1 u times the sum of their sizes, and over all coefficients these sums add up to at most
   bulk a bulk b. One of a weighted sum of n forms is off by at most (n + 1) u times such a sum.
   ``after_products`` adds (4 + 4 n) u of it to the rest. A coefficient of a sum is off by u times its size:
   over all of them u bulk, which ``after_sum`` adds.
2. Bounds are sums and products of numbers that are not negative, at most 100 roundings deep: each of them
   loses at most 101 u of the whole. ``up`` adds 512 u, at every step: bounds of bounds are bounds.
3. ``np.sum`` over coefficients adds numbers that are not negative in an order of its own: whatever that is, n
   terms lose at most n u, n being at most 78. No other reduction, product of matrices or ``einsum`` is used
   here: signs would cancel, and their order, or a library's, would have to be bounded.
4. Results below 2^-1022 are off by up to 2^-1074 each; ``TINY`` is far more than all of those of a step.
5. What overflows becomes infinite or NaN, so does the upper bound that is made of it, and comparisons with
   NaN are false: every test asks for what it needs, never for the opposite.
6. Lower bounds are differences of a value and an upper bound; the one quotient, ``square_quotient``, is 0
   where any of its numbers is so large or so small that a step of it might not be normal.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np
from flint import arb

from certificates.arithmetic.forms import Array, Form

U = 2.0**-52
"""Twice the unit of rounding."""
FAR = 2.0**400
"""Beyond it, or below its inverse, no quotient is a lower bound."""
LARGEST = 2.0**100
"""Of a robot's numbers: what is made of them, of degree six at most, stays far from overflow."""
UP = 1.0 + 512.0 * U
TINY = 2.0**-1000


def up(x: Array) -> Array:
    """Return an upper bound of what was computed of numbers that are not negative."""
    return x * UP + TINY


def machine_rounds() -> bool:
    """Return True where doubles are rounded to nearest, and small ones kept."""
    one, least, u = np.array([1.0, -1.0]), np.array([2.0**-1074]), 2.0**-53
    nearest = np.all(one + one * u == one) and np.all(one + one * (u * 1.5) == one * (1.0 + 2.0 * u))
    return bool(nearest and np.all(least * one[:1] == least) and np.all(least + least == 2.0**-1073))


class Floats(Form):
    """A form of doubles."""

    UNIT = 1
    INFINITE = np.inf

    @staticmethod
    def bound(terms: Sequence[tuple[Array, Array]], more: Array = 0) -> Array:
        """Add and multiply what is not negative: rule 2."""
        return up(sum((a * b for a, b in terms), more))

    @staticmethod
    def quotient(a: Array, b: Array) -> Array:
        """Two roundings: rule 2. Infinite or NaN where b is 0."""
        return up(a / b)

    @staticmethod
    def square_quotient(a: Array, b: Array) -> Array:
        """Take off three roundings; see rule 6."""
        found = a * a / b * (2.0 - UP)
        usual = (a > 1.0 / FAR) & (a < FAR) & (b > 1.0 / FAR) & (b < FAR)
        return np.where(usual & (found > 1.0 / FAR) & (found < FAR), found, 0.0)

    @staticmethod
    def root(a: Array) -> Array:
        """One rounding: rule 2."""
        return up(np.sqrt(a))

    @staticmethod
    def exceeds(a: Array, b: Array, c: Array, d: Array) -> Array:
        """Two roundings in each product, one in the difference: 3 u of both sizes, of 8."""
        one, other = a * b, c * d
        return one - other > 8.0 * U * (abs(one) + abs(other)) + TINY

    @classmethod
    def numbers(cls, x: Array) -> Array:
        """They are doubles."""
        return x

    numbers_up = numbers

    @staticmethod
    def doubles_near(x: Array) -> Array:
        """They are doubles."""
        return x

    @classmethod
    def between(cls, lo: Array, hi: Array, symbol: int) -> Self:
        """Return the middle, and a radius off by one rounding."""
        middle = 0.5 * lo + 0.5 * hi
        radius = up(np.maximum(hi - middle, middle - lo))
        found = cls.unknown(radius, symbol)
        return cls(middle, found.slopes, found.curves, found.rest)

    @classmethod
    def enclosing(cls, x: arb) -> Self:
        """Return the middle, and a radius that is compared with the gap in balls."""
        middle = float(x.mid())
        gap = abs(x - arb(middle)).upper()
        radius = 0.0 if gap == 0 else up(float(gap))
        if not (gap <= radius and abs(middle) + radius < LARGEST):
            raise ArithmeticError("a number is too large for doubles")
        found = cls.unknown(np.array([radius]))
        return cls(np.array([middle]), found.slopes, found.curves, found.rest)

    def after_sum(self) -> Self:
        """Rule 1."""
        self.rest = up(self.rest + U * self.bulk)
        return self

    def after_products(self, sizes: Sequence[tuple[Array, Array]]) -> Self:
        """Rule 1."""
        self.rest = up(self.rest + (4.0 + 4.0 * len(sizes)) * U * sum(a * b for a, b in sizes))
        return self

    def total(self, coefficients: Array) -> Array:
        """Rules 2 and 3."""
        return up(np.sum(abs(coefficients), axis=0))

    def lowest(self) -> Array:
        """Subtract; that is off by u of both sizes at most, of 4."""
        change = self.change()
        return self.value - up(change + 4.0 * U * (abs(self.value) + change))

    def within(self, lo: Array, hi: Array) -> Array:
        """Comparisons are exact."""
        return (self.lowest() >= lo) & (self.highest() <= hi)
