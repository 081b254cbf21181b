"""Affine forms: centre + linear part in K noise symbols + error, kept in rows of one array.

Row ``i`` of an array ``F`` of shape (rows, K + 2) is the form

    F[i, 0] + sum_k F[i, k] eps_k + F[i, K + 1] eps,    k = 1..K,

with eps_k, eps in [-1, 1]; the eps_k are shared by all rows, the last eps is each row's own.
A form *encloses* a function on the cell when for every point of the cell (a value of each
eps_k) the function value lies within the error of the linear part.

Every kernel writes one row ``out`` (different from its operands) and claims: if the operand
rows enclose functions, the result encloses the exact combination. Rounding errors are added
through ``rounding.inflate``. Infinite or NaN entries can only arise from overflow and make
every later comparison of ``bounds`` fail safely (bounds are then -inf, inf).

The signatures are explicit because numba would otherwise compile a copy of every kernel for each
row number that a caller writes as a constant.

Reference: J. Stolfi, L. H. de Figueiredo, Self-Validated Numerical Methods and Applications
(1997), chapter 3.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from cdpr_interval.kernels.rounding import down, inflate, up

Forms = Any
"""float64 array (rows, K + 2)."""


@njit("f8(f8[:, ::1], i8)", cache=True, nogil=True)
def radius(F: Forms, i: int) -> float:
    """Return sum |linear part| + error, rounded to nearest (K + 1 additions)."""
    last = F.shape[1] - 1
    total = F[i, last]
    for k in range(1, last):
        total += abs(F[i, k])
    return total


@njit("UniTuple(f8, 2)(f8[:, ::1], i8)", cache=True, nogil=True)
def bounds(F: Forms, i: int) -> tuple[float, float]:
    """Enclose the range of form ``i``; (-inf, inf) after an overflow."""
    width = F.shape[1]
    r = inflate(radius(F, i), 0.0, width)
    lo = down(F[i, 0] - r)
    hi = up(F[i, 0] + r)
    if not lo <= hi:
        return -math.inf, math.inf
    return lo, hi


@njit("void(f8[:, ::1], i8, f8, f8)", cache=True, nogil=True)
def constant(F: Forms, out: int, value: float, error: float) -> None:
    """Set ``out`` to all numbers within ``error`` of ``value``."""
    last = F.shape[1] - 1
    F[out, 0] = value
    for k in range(1, last):
        F[out, k] = 0.0
    F[out, last] = error


@njit("void(f8[:, ::1], i8, i8, f8, f8)", cache=True, nogil=True)
def variable(F: Forms, out: int, symbol: int, lo: float, hi: float) -> None:
    """Set ``out`` to the interval [lo, hi] on noise symbol ``symbol`` (1..K)."""
    # A single number stands exactly, also where lo + hi overflows.
    m = 0.5 * (lo + hi) if lo < hi else lo
    constant(F, out, m, 0.0)
    F[out, symbol] = max(up(hi - m), up(m - lo)) if lo < hi else 0.0


@njit("void(f8[:, ::1], i8, i8, i8)", cache=True, nogil=True)
def subtract(F: Forms, out: int, a: int, b: int) -> None:
    """Set ``out`` to a - b."""
    last = F.shape[1] - 1
    mag = 0.0
    for k in range(last):
        v = F[a, k] - F[b, k]
        F[out, k] = v
        mag += abs(v)
    F[out, last] = inflate(F[a, last] + F[b, last], mag, 8.0)


@njit("void(f8[:, ::1], i8, i8, i8)", cache=True, nogil=True)
def add(F: Forms, out: int, a: int, b: int) -> None:
    """Set ``out`` to a + b."""
    last = F.shape[1] - 1
    mag = 0.0
    for k in range(last):
        v = F[a, k] + F[b, k]
        F[out, k] = v
        mag += abs(v)
    F[out, last] = inflate(F[a, last] + F[b, last], mag, 8.0)


@njit("void(f8[:, ::1], i8, i8, f8, f8, f8, f8, f8)", cache=True, nogil=True)
def combine3(F: Forms, out: int, a: int, c0: float, c1: float, c2: float, value: float, error: float) -> None:
    """Set ``out`` to value + c0 F[a] + c1 F[a + 1] + c2 F[a + 2], up to ``error``."""
    last = F.shape[1] - 1
    x0 = c0 * F[a, 0]
    x1 = c1 * F[a + 1, 0]
    x2 = c2 * F[a + 2, 0]
    F[out, 0] = value + (x0 + x1 + x2)
    mag = abs(value) + (abs(x0) + abs(x1) + abs(x2))
    for k in range(1, last):
        x0 = c0 * F[a, k]
        x1 = c1 * F[a + 1, k]
        x2 = c2 * F[a + 2, k]
        F[out, k] = x0 + x1 + x2
        mag += abs(x0) + abs(x1) + abs(x2)
    e = abs(c0) * F[a, last] + abs(c1) * F[a + 1, last] + abs(c2) * F[a + 2, last]
    # A term passes at most one product and three sums: 4 u |term|; inflate counts 2 u.
    F[out, last] = inflate(error + e, 2.0 * mag, 20.0)


@njit("void(f8[:, ::1], i8, i8, i8, i8)", cache=True, nogil=True)
def dot(F: Forms, out: int, a: int, b: int, n: int) -> None:
    """Set ``out`` to sum_j F[a + j] F[b + j], j < n <= 4.

    The quadratic part is bounded as one form: its diagonal terms eps_k^2 lie in [0, 1], which
    shifts the centre by half of them, and mixed terms are added up over j before the absolute
    value, so that opposite products cancel.
    """
    last = F.shape[1] - 1
    centre = 0.0
    mag = 0.0
    error = 0.0
    for j in range(n):
        a0 = F[a + j, 0]
        b0 = F[b + j, 0]
        centre += a0 * b0
        ra = radius(F, a + j)
        rb = radius(F, b + j)
        ea = F[a + j, last]
        eb = F[b + j, last]
        error += (abs(a0) + (ra - ea)) * eb + (abs(b0) + rb) * ea
        mag += (abs(a0) + ra) * (abs(b0) + rb)
    shift = 0.0
    for k in range(1, last):
        c = 0.0
        q = 0.0
        for j in range(n):
            c += F[a + j, 0] * F[b + j, k] + F[b + j, 0] * F[a + j, k]
            q += F[a + j, k] * F[b + j, k]
        F[out, k] = c
        shift += q
        error += 0.5 * abs(q)
        for m in range(k + 1, last):
            q = 0.0
            for j in range(n):
                q += F[a + j, k] * F[b + j, m] + F[a + j, m] * F[b + j, k]
            error += abs(q)
    F[out, 0] = centre + 0.5 * shift
    # A term passes at most one product and 2 n sums (and K more in the shift); all terms together
    # are at most mag, so (2 n + 2 + K) u mag is enough. (ra - ea) may lose u ra, covered likewise.
    F[out, last] = inflate(error, (n + 2.0 + 0.5 * last) * mag, 100.0)


@njit("void(f8[:, ::1], i8, i8, i8, i8, i8)", cache=True, nogil=True)
def minor(F: Forms, out: int, a: int, b: int, c: int, d: int) -> None:
    """Set ``out`` to F[a] F[b] - F[c] F[d]."""
    last = F.shape[1] - 1
    a0, b0, c0, d0 = F[a, 0], F[b, 0], F[c, 0], F[d, 0]
    ra, rb, rc, rd = radius(F, a), radius(F, b), radius(F, c), radius(F, d)
    ea, eb, ec, ed = F[a, last], F[b, last], F[c, last], F[d, last]
    mag = (abs(a0) + ra) * (abs(b0) + rb) + (abs(c0) + rc) * (abs(d0) + rd)
    error = (abs(a0) + (ra - ea)) * eb + (abs(b0) + rb) * ea
    error += (abs(c0) + (rc - ec)) * ed + (abs(d0) + rd) * ec
    shift = 0.0
    for k in range(1, last):
        F[out, k] = (a0 * F[b, k] + b0 * F[a, k]) - (c0 * F[d, k] + d0 * F[c, k])
        q = F[a, k] * F[b, k] - F[c, k] * F[d, k]
        shift += q
        error += 0.5 * abs(q)
        for m in range(k + 1, last):
            q = F[a, k] * F[b, m] + F[a, m] * F[b, k] - F[c, k] * F[d, m] - F[c, m] * F[d, k]
            error += abs(q)
    F[out, 0] = (a0 * b0 - c0 * d0) + 0.5 * shift
    # As in dot, with two products: at most 1 product and 4 + K sums a term.
    F[out, last] = inflate(error, (4.0 + 0.5 * last) * mag, 100.0)


@njit("void(f8[:, ::1], i8, i8, i8)", cache=True, nogil=True)
def multiply(F: Forms, out: int, a: int, b: int) -> None:
    """Set ``out`` to F[a] F[b]."""
    dot(F, out, a, b, 1)


@njit("b1(f8[:, ::1], i8, i8)", cache=True, nogil=True)
def reciprocal(F: Forms, out: int, a: int) -> bool:
    """Set ``out`` to 1 / F[a] for a positive form; False (out untouched) if it is not proved positive.

    Also False where the product of its bounds underflows.

    On [lo, hi] the line -x / p + q with p = lo hi (the chord's slope) runs above 1/x at no point
    by more than 0 and below by at most the gap at x = sqrt(lo hi):
    chord minus 1/x lies in [0, 1/lo + 1/hi - 2 / sqrt(lo hi)].
    """
    lo, hi = bounds(F, a)
    if not (lo > 0.0 and hi < math.inf):
        return False
    product = lo * hi
    if not product > 0.0:
        return False
    last = F.shape[1] - 1
    slope = -1.0 / product
    # Bounds of 1/x - slope x at the ends and at the (only) stationary point x = 1 / sqrt(-slope),
    # all for the rounded slope that is really used.
    root = math.sqrt(-slope)
    top = max(up(up(1.0 / lo) + up(-slope * lo)), up(up(1.0 / hi) + up(-slope * hi)))
    bottom = down(2.0 * down(root))
    m = 0.5 * (top + bottom)
    gap = max(up(top - m), up(m - bottom))
    mag = abs(m)
    for k in range(last):
        v = slope * F[a, k]
        F[out, k] = v
        mag += abs(v)
    F[out, 0] += m
    F[out, last] = inflate(gap + abs(slope) * F[a, last], 2.0 * mag, 20.0)
    return True
