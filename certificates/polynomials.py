"""Exact polynomials over a cell: every symbol stands for a number in [-1, 1].

Coefficients are rationals, so nothing is ever rounded; a number that is only known to lie in a range is its
middle plus its radius times a symbol of its own. A bound is the constant term minus or plus the sizes of
all others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import reduce
from operator import add

from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

Vector = list[fmpq_mpoly]
ZERO = fmpq(0)

TURN, PLACE, ALONG, TENSION, DATA = 0, 3, 6, 6, 12
"""First symbols of: u (3), the position (3), its distance along a normal or the tensions (6), data (10)."""
SYMBOLS = 22
RING = fmpq_mpoly_ctx.get([f"e{k}" for k in range(SYMBOLS)], Ordering.deglex)
SYMBOL = RING.gens()
NONE = (0,) * SYMBOLS
ONE = [tuple(int(i == k) for i in range(SYMBOLS)) for k in range(SYMBOLS)]
"""Exponents of 1 and of each symbol."""


def rational(x: Fraction | float | int) -> fmpq:
    """Return an exact number."""
    return fmpq(*x.as_integer_ratio())


def short(x: float) -> fmpq:
    """Return a number near x with 24 binary digits: it multiplies faster."""
    mantissa, exponent = math.frexp(x)
    return fmpq(round(mantissa * 2**24)) * fmpq(2) ** (exponent - 24)


def constant(x: fmpq | int) -> fmpq_mpoly:
    """Return a number as a polynomial."""
    return RING.constant(x)


def between(lo: fmpq, hi: fmpq, symbol: int) -> fmpq_mpoly:
    """Return the number in [lo, hi] that a symbol stands for."""
    return constant((lo + hi) / 2) + SYMBOL[symbol] * ((hi - lo) / 2)


def total(terms: Sequence[fmpq_mpoly]) -> fmpq_mpoly:
    """Return a sum."""
    return reduce(add, terms)


def dot(a: Sequence[fmpq_mpoly], b: Sequence[fmpq_mpoly]) -> fmpq_mpoly:
    """Return the scalar product."""
    return total([x * y for x, y in zip(a, b, strict=True)])


def cross(a: Sequence[fmpq_mpoly], b: Sequence[fmpq_mpoly]) -> Vector:
    """Return the vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def centre(p: fmpq_mpoly) -> fmpq:
    """Return the value where all symbols are 0."""
    return p[NONE]


def size(p: fmpq_mpoly) -> fmpq:
    """Return a bound of |p|."""
    return sum(map(abs, p.coeffs()), ZERO)


def lowest(p: fmpq_mpoly) -> fmpq:
    """Return a lower bound of p."""
    c = centre(p)
    return c + abs(c) - size(p)


def highest(p: fmpq_mpoly) -> fmpq:
    """Return an upper bound of p."""
    return -lowest(-p)


def has_no_zero(p: fmpq_mpoly) -> bool:
    """Return True when p is proved to have one sign."""
    return bool(2 * abs(centre(p)) > size(p))


def slopes(p: fmpq_mpoly, symbols: Sequence[int]) -> list[fmpq]:
    """Return the coefficients of the linear terms in some symbols."""
    return [p[ONE[k]] for k in symbols]


def number(value: fmpq) -> float:
    """Return a float near an exact number."""
    return int(value.p) / int(value.q)


def upto(p: fmpq_mpoly, degree: int) -> fmpq_mpoly:
    """Return a polynomial near the terms of p up to a degree, its coefficients short numbers."""
    if degree == 1:
        low = [(NONE, centre(p)), *((ONE[k], p[ONE[k]]) for k in range(TENSION))]
        return RING.from_dict({e: rational(number(c)) for e, c in low if c != 0})
    return RING.from_dict({e: rational(number(c)) for e, c in p.to_dict().items() if sum(e) <= degree})
