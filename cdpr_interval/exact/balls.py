"""Real balls (python-flint ``arb``) for everything outside the compiled search: frames, poses, stability.

Guarantee: every conversion encloses. Work under ``precision()``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction

import numpy as np
from flint import arb, arb_mat, ctx, fmpq
from numpy.typing import NDArray

from cdpr_interval.exact.enclosure import enclose
from cdpr_interval.exact.range import Range

Floats = NDArray[np.float64]

PRECISION_BITS = 128
"""Enough that the balls' own rounding never shows in doubles."""


@contextmanager
def precision() -> Iterator[None]:
    """Compute with ``PRECISION_BITS`` inside the block."""
    with ctx.workprec(PRECISION_BITS):
        yield


def from_fraction(x: Fraction) -> arb:
    """Enclose an exact rational."""
    return arb(fmpq(x.numerator, x.denominator))


def from_bounds(lo: float, hi: float) -> arb:
    """Enclose [lo, hi]."""
    return arb(float(lo)) if lo == hi else arb(float(lo)).union(arb(float(hi)))


def to_range(x: arb) -> Range:
    """Return exact rational bounds of a ball."""
    return Range(_exact(x.lower()), _exact(x.upper()))


def to_bounds(x: arb) -> tuple[float, float]:
    """Return double bounds of a ball; infinite where the ball is not finite."""
    if not x.is_finite():
        return -np.inf, np.inf
    r = to_range(x)
    return enclose(r.lo)[0], enclose(r.hi)[1]


def _exact(x: arb) -> Fraction:
    mantissa, exponent = x.man_exp()
    m, e = int(mantissa), int(exponent)
    return Fraction(m * 2**e) if e >= 0 else Fraction(m, 2**-e)


def vector(entries: Sequence[arb | int]) -> arb_mat:
    """Return a column."""
    return arb_mat(len(entries), 1, list(entries))


def fractions(entries: Sequence[Fraction]) -> arb_mat:
    """Return a column of exact rationals."""
    return vector([from_fraction(x) for x in entries])


def from_range(x: Range) -> arb:
    """Enclose a range."""
    return from_fraction(x.lo) if x.lo == x.hi else from_fraction(x.lo).union(from_fraction(x.hi))


def column(bounds: Floats) -> arb_mat:
    """Return a column that encloses bounds (m, 2)."""
    return vector([from_bounds(lo, hi) for lo, hi in bounds.tolist()])


def matrix(bounds: Floats) -> arb_mat:
    """Return a matrix that encloses bounds (m, n, 2)."""
    return arb_mat([[from_bounds(lo, hi) for lo, hi in row] for row in bounds.tolist()])


def ranges(entries: Sequence[Range]) -> arb_mat:
    """Return a column that encloses ranges."""
    return vector([from_range(x) for x in entries])


def entries(v: arb_mat) -> list[arb]:
    """Return the entries of a matrix, row by row."""
    return list(v.entries())


def bounds_array(m: arb_mat) -> Floats:
    """Return the (rows * columns, 2) bounds of a matrix, row by row."""
    return np.array([to_bounds(x) for x in m.entries()])


def dot(a: arb_mat, b: arb_mat) -> arb:
    """Return the scalar product of two columns."""
    return (a.transpose() * b)[0, 0]


def cross(a: arb_mat, b: arb_mat) -> arb_mat:
    """Return a x b of two columns of three."""
    x, y = entries(a), entries(b)
    return vector([x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]])


def norm(a: arb_mat) -> arb:
    """Return |a|."""
    return dot(a, a).nonnegative_part().sqrt()


def columns(*vectors: arb_mat) -> arb_mat:
    """Return the matrix with these columns."""
    lists = [entries(v) for v in vectors]
    return arb_mat([[column[i] for column in lists] for i in range(len(lists[0]))])


def identity(n: int = 3) -> arb_mat:
    """Return the exact identity."""
    return arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])


def middle(m: arb_mat) -> Floats:
    """Return the middles as floats, (rows, columns)."""
    return np.array([float(x.mid()) for x in m.entries()]).reshape(m.nrows(), m.ncols())


def inside(x: arb, lo: float, hi: float) -> bool:
    """Return True when the ball lies in [lo, hi]."""
    r = to_bounds(x)
    return lo <= r[0] and r[1] <= hi


def turn(axis: arb_mat, angle: arb) -> arb_mat:
    """Return the rotation by ``angle`` (rad) about a unit axis (Rodrigues)."""
    x, y, z = entries(axis)
    k = arb_mat([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return identity() + k * angle.sin() + k * k * (1 - angle.cos())


def right_handed(first: arb_mat) -> arb_mat:
    """Return a rotation whose first column is the unit vector ``first``."""
    v = middle(first)[:, 0]
    helper = vector([int(k == int(np.argmin(np.abs(v)))) for k in range(3)])
    second = cross(first, helper)
    second = second * (1 / norm(second))
    return columns(first, second, cross(first, second))
