"""Numbers that depend on a pose, enclosed over many cells at once: quadratic in symbols from [-1, 1].

In each cell, for any values of the symbols e and d,

    value + sum slopes_i e_i + sum_(i <= j) curves_ij e_i e_j + sum drifts_k d_k +- rest

holds the number. The d stand for lengths in their ranges, the same in all forms. A product's terms of higher
degree, those of a d with another symbol, and what rounding drops, are added to the rest. Two
arithmetics have this meaning: `Floats`, doubles of all cells in one operation, and `Integers`, exact but for
shifts. Their numbers and bounds count in units of 1 / UNIT, which is 1 for doubles.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property, reduce
from typing import Any, Self

import numpy as np
from flint import arb

TURN, PLACE, ALONG, TENSION = 0, 3, 3, 6
"""First symbols of: u (3), the position (3) or its distance along a normal, the tensions (6)."""
Array = Any
"""Of doubles, or of Python's integers: one entry a cell, or one for all."""


class Form(ABC):
    """One number. ``curves`` are ordered 00, 01, 11, 02, ...; coefficients that are missing are 0.

    value, rest : (N,) or (1,); slopes : (K, N or 1); curves : (K (K + 1) / 2, N or 1), or none; drifts : (D,
    N or 1).
    """

    UNIT: int
    INFINITE: Any
    """Stands for a bound that there is none."""

    def __init__(
        self, value: Array, slopes: Array, curves: Array, rest: Array, drifts: Array | None = None
    ) -> None:
        self.value, self.slopes, self.curves, self.rest = value, slopes, curves, rest
        self.drifts = none_of(value) if drifts is None else drifts

    # What an arithmetic says for itself.

    @staticmethod
    @abstractmethod
    def bound(terms: Sequence[tuple[Array, Array]], more: Array = 0) -> Array:
        """Return an upper bound of ``more`` + sum a b of bounds that are not negative."""

    @staticmethod
    @abstractmethod
    def quotient(a: Array, b: Array) -> Array:
        """Return an upper bound of a / b, of an upper bound a >= 0 and a lower bound b > 0."""

    @staticmethod
    @abstractmethod
    def square_quotient(a: Array, b: Array) -> Array:
        """Return a lower bound of a^2 / b, of a lower bound a >= 0 and an upper bound b > 0."""

    @staticmethod
    @abstractmethod
    def root(a: Array) -> Array:
        """Return an upper bound of the square root of a bound a >= 0."""

    @staticmethod
    @abstractmethod
    def exceeds(a: Array, b: Array, c: Array, d: Array) -> Array:
        """Return where a b >= c d surely, a and c not negative, b and d rounded once."""

    @classmethod
    @abstractmethod
    def numbers(cls, x: Array) -> Array:
        """Return doubles as this arithmetic's numbers, rounded down."""

    @classmethod
    @abstractmethod
    def numbers_up(cls, x: Array) -> Array:
        """Return doubles as this arithmetic's numbers, rounded up."""

    @staticmethod
    @abstractmethod
    def doubles_near(x: Array) -> Array:
        """Return doubles near this arithmetic's numbers, infinite where there are none."""

    @classmethod
    @abstractmethod
    def between(cls, lo: Array, hi: Array, symbol: int) -> Self:
        """Return the numbers in [lo, hi] (doubles, one a cell) that a symbol stands for."""

    @classmethod
    @abstractmethod
    def enclosing(cls, x: arb) -> Self:
        """Return a constant that encloses a ball."""

    @abstractmethod
    def after_sum(self) -> Self:
        """Return this form, of sums of coefficients, with what was dropped on the way."""

    @abstractmethod
    def after_products(self, sizes: Sequence[tuple[Array, Array]]) -> Self:
        """Return this form, of sums of products, in units and with what was dropped on the way.

        ``sizes`` : bounds of the sums of the sizes of all factors of these products, two and two.
        """

    @abstractmethod
    def total(self, coefficients: Array) -> Array:
        """Return an upper bound of the sum of the sizes of coefficients (K, N or 1)."""

    @abstractmethod
    def lowest(self) -> Array:
        """Return a lower bound."""

    @abstractmethod
    def within(self, lo: Array, hi: Array) -> Array:
        """Return where the number surely lies within doubles."""

    # What follows from it.

    @classmethod
    def constant(cls, x: float) -> Self:
        """Return a number near x, the same in all cells."""
        return cls.near(np.array([x]))

    @classmethod
    def near(cls, x: Array, slopes: Array = ()) -> Self:
        """Return a form near chosen doubles and slopes, (K, N)."""
        value = cls.numbers(x)
        found = cls.numbers(np.asarray(slopes)) if len(slopes) else none_of(value)
        return cls(value, found, none_of(value), 0 * value)

    @classmethod
    def unknown(cls, size: Array, symbol: int = -1) -> Self:
        """Return any number up to a bound: a rest, or ``size`` times a symbol."""
        none = 0 * size
        slopes = np.stack([none] * symbol + [size]) if symbol >= 0 else none_of(size)
        return cls(none, slopes, none_of(size), none if symbol >= 0 else size)

    @classmethod
    def datum(cls, size: Array, k: int) -> Self:
        """Return ``size`` times the symbol of a length."""
        none = 0 * size
        return cls(none, none_of(size), none_of(size), none, np.stack([none] * k + [size]))

    @cached_property
    def steep(self) -> Array:
        """An upper bound of the sum of the sizes of the slopes."""
        return self.total(self.slopes)

    @cached_property
    def bent(self) -> Array:
        """The same of the curves."""
        return self.total(self.curves)

    @cached_property
    def drift(self) -> Array:
        """The same of the drifts."""
        return self.total(self.drifts) if len(self.drifts) else 0

    @cached_property
    def bulk(self) -> Array:
        """An upper bound of the sum of the sizes of all coefficients."""
        return self.bound([], abs(self.value) + self.steep + self.bent + self.drift)

    def size(self) -> Array:
        """Return an upper bound of the number's size."""
        return self.bound([], self.bulk + self.rest)

    def change(self) -> Array:
        """Return an upper bound of its distance from the value."""
        return self.bound([], self.steep + self.bent + self.drift + self.rest)

    def highest(self) -> Array:
        """Return an upper bound."""
        return -(-self).lowest()

    def has_no_zero(self) -> Array:
        """Return where the number is proved to have one sign."""
        return abs(self.value) > self.change()

    def __neg__(self) -> Self:
        return type(self)(-self.value, -self.slopes, -self.curves, self.rest, -self.drifts)

    def __add__(self, other: Any) -> Self:
        if isinstance(other, int):
            other = self.constant(other)
        if not isinstance(other, Form):
            return NotImplemented
        return type(self)(
            self.value + other.value,
            together(self.slopes, other.slopes),
            together(self.curves, other.curves),
            self.rest + other.rest,
            together(self.drifts, other.drifts),
        ).after_sum()

    def __sub__(self, other: Any) -> Self:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Self:
        found: Self = self.__neg__().__add__(other)
        return found

    def __mul__(self, other: Any) -> Self:
        if isinstance(other, np.ndarray):
            # Signs, 1 or -1 in each cell: nothing is rounded.
            value, slopes, curves = self.value * other, self.slopes * other, self.curves * other
            return type(self)(value, slopes, curves, self.rest, self.drifts * other)
        if isinstance(other, int):
            other = self.constant(other)
            if not other.value[0]:
                return self.constant(0)
        if not isinstance(other, Form):
            return NotImplemented
        a, b = self.value, other.value
        rest = [(self.steep, other.bent), (self.bent, other.steep + other.bent), (self.bulk, other.rest)]
        if len(self.drifts):
            rest.append((self.drift, other.steep + other.bent + other.drift))
        if len(other.drifts):
            rest.append((self.steep + self.bent, other.drift))
        return type(self)(
            a * b,
            together(a * other.slopes, b * self.slopes),
            together(together(a * other.curves, b * self.curves), mixed(self.slopes, other.slopes)),
            sum(x * y for x, y in [*rest, (self.rest, other.bulk + other.rest)]),
            together(a * other.drifts, b * self.drifts),
        ).after_products([(self.bulk, other.bulk)])

    __radd__, __rmul__ = __add__, __mul__

    @classmethod
    def combine(cls, weights: Sequence[Array], forms: Sequence[Form]) -> Self:
        """Return a sum of forms weighted by doubles."""
        w = [cls.numbers(x) for x in weights]
        pairs = list(zip(w, forms, strict=True))
        slopes = reduce(together, (x * form.slopes for x, form in pairs))
        curves = reduce(together, (x * form.curves for x, form in pairs))
        drifts = reduce(together, (x * form.drifts for x, form in pairs))
        value = sum(x * form.value for x, form in pairs)
        rest = sum(abs(x) * form.rest for x, form in pairs)
        sizes = [(abs(x), form.bulk) for x, form in pairs]
        return cls(value, slopes, curves, rest, drifts).after_products(sizes)

    def upto(self, degree: int) -> Self:
        """Return a number near this one without terms of a higher degree."""
        curves = self.curves if degree > 1 else self.curves[:0]
        slopes, drifts = (v if degree else v[:0] for v in (self.slopes, self.drifts))
        return type(self)(self.value, slopes, curves, 0 * self.rest, drifts)

    def at(self, cells: Array) -> Self:
        """Return the form in some of the cells."""
        parts = (self.value, self.slopes, self.curves, self.rest, self.drifts)
        return type(self)(*(v if v.shape[-1] == 1 else v[..., cells] for v in parts))

    def doubles(self) -> Array:
        """Return doubles near the value."""
        return self.doubles_near(self.value)

    def slope_doubles(self, count: int) -> Array:
        """Return doubles near the slopes by ``count`` symbols, (count, N or 1)."""
        found = self.doubles_near(self.slopes)
        return together(np.zeros((count, 1)), found) if len(found) < count else found


Vector = list[Any]


def none_of(like: Array) -> Array:
    """Return no coefficients of the kind of others."""
    return np.zeros((0, 1), like.dtype)


def together(a: Array, b: Array) -> Array:
    """Return the sum of two arrays of coefficients, of which the shorter one ends in zeros."""
    if len(a) < len(b):
        a, b = b, a
    if not len(b):
        return a
    if len(a) == len(b):
        return a + b
    found = np.empty((len(a), max(a.shape[1], b.shape[1])), a.dtype)
    found[: len(b)], found[len(b) :] = a[: len(b)] + b, a[len(b) :]
    return found


def mixed(s: Array, t: Array) -> Array:
    """Return the coefficients of the product of two sums of symbols."""
    if len(s) < len(t):
        s, t = t, s
    n, m = len(s), len(t)
    if not m:
        return t
    found = np.empty((n * (n + 1) // 2, max(s.shape[1], t.shape[1])), s.dtype)
    for j in range(n):
        block = found[j * (j + 1) // 2 :]
        if j < m:
            block[:j] = s[:j] * t[j] + s[j] * t[:j]
            block[j] = s[j] * t[j]
        else:
            block[:m], block[m : j + 1] = s[j] * t, 0
    return found


def stacked(arrays: Sequence[Array]) -> Array:
    """Return arrays as one, each with an entry for every cell."""
    return np.stack(np.broadcast_arrays(*arrays))
