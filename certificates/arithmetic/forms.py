"""Numbers that depend on a pose, enclosed over a cell: quadratic in symbols for numbers in [-1, 1].

    value + sum slopes_i e_i + sum_(i <= j) curves_ij e_i e_j +- rest

All are integers, in units of 1 / UNIT. A product's terms of higher degree, and what rounding drops, are added
to the rest, so that a form encloses its number wherever the symbols are.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from typing import Any

from flint import arb

from certificates.arithmetic.vectors import total

BITS = 60
UNIT = 1 << BITS
TURN, PLACE, ALONG, TENSION = 0, 3, 3, 6
"""First symbols of: u (3), the position (3) or its distance along a normal, the tensions (6)."""


class Form:
    """One number. ``curves`` are ordered 00, 01, 11, 02, ...; slopes and curves that are missing are 0."""

    __slots__ = ("curves", "rest", "slopes", "value")

    def __init__(self, value: int, slopes: Sequence[int] = (), curves: Sequence[int] = (), rest: int = 0):
        self.value, self.slopes, self.curves, self.rest = value, slopes, curves, rest

    def __add__(self, other: Any) -> Form:
        if isinstance(other, int):
            return Form(self.value + other * UNIT, self.slopes, self.curves, self.rest)
        if not isinstance(other, Form):
            return NotImplemented
        return Form(
            self.value + other.value,
            [x + y for x, y in zip_longest(self.slopes, other.slopes, fillvalue=0)],
            [x + y for x, y in zip_longest(self.curves, other.curves, fillvalue=0)],
            self.rest + other.rest,
        )

    def __mul__(self, other: Any) -> Form:
        if isinstance(other, int):
            slopes, curves = [x * other for x in self.slopes], [x * other for x in self.curves]
            return Form(self.value * other, slopes, curves, self.rest * abs(other))
        return rounded(self.times(other)) if isinstance(other, Form) else NotImplemented

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Form:
        return self * -1

    def __sub__(self, other: Any) -> Form:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Form:
        return self.__neg__().__add__(other)

    def times(self, other: Form) -> Form:
        """Return the product in units of 1 / UNIT^2."""
        if not self.slopes:
            self, other = other, self
        a, b, n = self.value, other.value, len(self.slopes)
        if not other.slopes:
            rest = self.rest * abs(b) + self.size() * other.rest
            return Form(a * b, [b * x for x in self.slopes], [b * x for x in self.curves], rest)
        if n < len(other.slopes):
            self, other, a, b, n = other, self, b, a, len(other.slopes)
        s, t = self.slopes, other.slopes
        if n > len(t):
            t = [*t, *[0] * (n - len(t))]
        mixed: list[int] = []
        for j, (x, y) in enumerate(zip(s, t, strict=True)):
            mixed += [v * y + w * x for v, w in zip(s[:j], t[:j], strict=True)]
            mixed.append(x * y)
        steep, bent, more = sum(map(abs, s)), sum(map(abs, self.curves)), sum(map(abs, other.curves))
        rest = steep * more + bent * (sum(map(abs, t)) + more) + self.rest * other.size()
        rest += (abs(a) + steep + bent) * other.rest
        curves = zip_longest(self.curves, other.curves, mixed, fillvalue=0)
        return Form(
            a * b,
            [a * y + b * x for x, y in zip(s, t, strict=True)],
            [a * y + b * x + z for x, y, z in curves],
            rest,
        )

    def size(self) -> int:
        """Return a bound of the number's size."""
        return abs(self.value) + self.change()

    def change(self) -> int:
        """Return a bound of its distance from the value."""
        return sum(map(abs, self.slopes)) + sum(map(abs, self.curves)) + self.rest

    def lowest(self) -> int:
        """Return a lower bound."""
        return self.value - self.change()

    def highest(self) -> int:
        """Return an upper bound."""
        return self.value + self.change()

    def has_no_zero(self) -> bool:
        """Return True when the number is proved to have one sign."""
        return abs(self.value) > self.change()

    def upto(self, degree: int) -> Form:
        """Return a number near this one without terms of a higher degree."""
        return Form(self.value, self.slopes, self.curves if degree > 1 else ())


Vector = list[Form]


def rounded(form: Form) -> Form:
    """Return a form that was in units of 1 / UNIT^2: every shift drops less than 1 unit."""
    slopes, curves = [v >> BITS for v in form.slopes], [v >> BITS for v in form.curves]
    dropped = 2 + len(slopes) + len(curves)
    return Form(form.value >> BITS, slopes, curves, (form.rest >> BITS) + dropped)


def units(x: float) -> int:
    """Return a double in units, rounded down."""
    numerator, denominator = x.as_integer_ratio()
    return (numerator << BITS) // denominator


def between(lo: float, hi: float, symbol: int) -> Form:
    """Return the number in [lo, hi] that a symbol stands for."""
    low, high = units(lo), -units(-hi)
    return Form((low + high) >> 1, [0] * symbol + [(high - low + 1) >> 1] if low < high else [])


def box_forms(bounds: Sequence[tuple[float, float]]) -> Vector:
    """Return numbers within bounds, one symbol each."""
    return [between(lo, hi, k) for k, (lo, hi) in enumerate(bounds)]


def enclosing(x: arb) -> Form:
    """Return a constant that encloses a ball."""
    return Form(down(x.mid()), rest=0 if x.is_zero() else down(x.rad()) + 2)


def down(x: arb) -> int:
    """Return an exact ball in units, rounded down."""
    mantissa, exponent = x.man_exp()
    shift = int(exponent) + BITS
    return int(mantissa) << shift if shift >= 0 else int(mantissa) >> -shift


def near(x: float, slopes: Sequence[float] = ()) -> Form:
    """Return a form near chosen numbers."""
    return Form(units(x), [units(v) for v in slopes])


def value(x: Form) -> float:
    """Return a double near a form's value."""
    return x.value / UNIT


def slopes(x: Form, count: int) -> list[float]:
    """Return doubles near a form's slopes."""
    return [v / UNIT for v in x.slopes] + [0.0] * (count - len(x.slopes))


def combine(weights: Sequence[float], forms: Sequence[Form]) -> Form:
    """Return a weighted sum of forms."""
    return rounded(total([form * units(w) for w, form in zip(weights, forms, strict=True)]))
