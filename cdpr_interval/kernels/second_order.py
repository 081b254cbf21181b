"""Second-order forms: centre + linear part + quadratic part in K noise symbols + error, in rows of one array.

With ``Q = 1 + K + K (K + 1) / 2`` coefficients, row ``i`` of an array ``F`` of shape (rows, Q + 3) holds

    c, l_1 .. l_K, q_11 .. q_KK, q_12, q_13, .. q_(K-1)K, error, sum |l|, sum |q|

and encloses a function of the symbols eps_k in [-1, 1] when for every value of them the function differs
from c + sum l_k eps_k + sum q_kk eps_k^2 + sum q_km eps_k eps_m by at most ``error``. The two sums
are kept because every product needs them; ``close`` writes them after a row was filled by hand.

Polynomials of degree two are represented exactly up to rounding; a product drops its terms of third
and fourth order into the error. Rounding goes through ``rounding.inflate``: the magnitude of a row,
|c| + sum |l| + sum |q|, bounds the sum over all its coefficients, so one number accounts for a whole
row. Infinite or NaN entries can only arise from overflow and make ``bounds`` return (-inf, inf).

``S`` is a tuple of K zeros: its length is known to the compiler, which makes every loop one of fixed
length. Signatures are explicit because numba would otherwise compile a copy of every kernel for each
row number that a caller writes as a constant.

Reference: M. Berz, K. Makino, Reliable Computing 4 (1998), for arithmetic with a remainder.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from cdpr_interval.kernels.rounding import down, inflate, up

Forms = Any
"""float64 array (rows, Q + 3)."""
Symbols = tuple[int, ...]

ROTATION_ONLY: Symbols = (0, 0, 0, 0)
"""Four symbols: three of the rotation, one for the error of the position along one direction."""
WHOLE_POSE: Symbols = (0, 0, 0, 0, 0, 0)
"""Six symbols: rotation and position."""


def width(symbols: Symbols) -> int:
    """Return the number of columns of a form array."""
    k = len(symbols)
    return 1 + k + k * (k + 1) // 2 + 3


def signatures(pattern: str) -> list[str]:
    """Return the signatures for both numbers of symbols; ``S`` stands for the tuple's type."""
    return [pattern.replace("S", f"UniTuple(i8, {len(s)})") for s in (ROTATION_ONLY, WHOLE_POSE)]


@njit(signatures("f8(f8[:, ::1], i8, S)"), cache=True, nogil=True)
def magnitude(F: Forms, i: int, S: Symbols) -> float:
    """Return |c| + sum |l| + sum |q|, without the error (rounded to nearest)."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    return abs(F[i, 0]) + F[i, Q + 1] + F[i, Q + 2]


@njit(signatures("f8(f8[:, ::1], i8, S)"), cache=True, nogil=True)
def largest(F: Forms, i: int, S: Symbols) -> float:
    """Return an upper bound of |form i|; infinite or NaN after an overflow."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    return inflate(abs(F[i, 0]) + F[i, Q + 1] + F[i, Q + 2] + F[i, Q], 0.0, 60.0)


@njit(signatures("void(f8[:, ::1], i8, S)"), cache=True, nogil=True)
def close(F: Forms, i: int, S: Symbols) -> None:
    """Write the sums |l| and |q| of row ``i``."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    # Two and three partial sums: a single one would wait for each addition.
    a, b = 0.0, 0.0
    for k in range(1, K, 2):
        a += abs(F[i, k])
        b += abs(F[i, k + 1])
    F[i, Q + 1] = a + b
    a, b, c = 0.0, 0.0, 0.0
    for k in range(1 + K, Q - 2, 3):
        a += abs(F[i, k])
        b += abs(F[i, k + 1])
        c += abs(F[i, k + 2])
    if (Q - 1 - K) % 3 == 1:
        a += abs(F[i, Q - 1])
    F[i, Q + 2] = a + b + c


@njit(signatures("void(f8[:, ::1], i8, f8, f8, S)"), cache=True, nogil=True)
def constant(F: Forms, out: int, value: float, error: float, S: Symbols) -> None:
    """Set ``out`` to all numbers within ``error`` of ``value``."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    for k in range(Q + 3):
        F[out, k] = 0.0
    F[out, 0] = value
    F[out, Q] = error


@njit(signatures("void(f8[:, ::1], i8, f8, S)"), cache=True, nogil=True)
def widen(F: Forms, i: int, error: float, S: Symbols) -> None:
    """Add ``error`` to the error of row ``i``."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    F[i, Q] = up(F[i, Q] + error)


@njit(signatures("UniTuple(f8, 2)(f8[:, ::1], i8, S)"), cache=True, nogil=True)
def bounds(F: Forms, i: int, S: Symbols) -> tuple[float, float]:
    """Enclose the range of form ``i``; (-inf, inf) after an overflow.

    In each symbol alone, l eps + q eps^2 is bounded by its exact range on [-1, 1].
    """
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    below = F[i, Q]
    other = 0.0
    for k in range(1 + 2 * K, Q - 2, 3):
        below += abs(F[i, k])
        other += abs(F[i, k + 1]) + abs(F[i, k + 2])
    below += other
    above = below
    for k in range(K):
        linear = abs(F[i, 1 + k])
        square = F[i, 1 + K + k]
        size = abs(square)
        # The parabola reaches l + |q| on one side, on the other l^2 / (4 |q|) if its vertex is inside.
        near = linear * (0.25 * (linear / size)) if linear < 2.0 * size else linear - size
        if square > 0.0:
            above += linear + size
            below += near
        else:
            below += linear + size
            above += near
    # 60 operations; the differences l - |q| are covered by the magnitude.
    total = abs(F[i, 0]) + F[i, Q + 1] + F[i, Q + 2]
    lo = down(F[i, 0] - inflate(below, total, 60.0))
    hi = up(F[i, 0] + inflate(above, total, 60.0))
    if not lo <= hi:
        return -math.inf, math.inf
    return lo, hi


@njit(signatures("void(f8[:, ::1], i8, i8, f8, S)"), cache=True, nogil=True)
def scale(F: Forms, out: int, a: int, c: float, S: Symbols) -> None:
    """Set ``out`` to c F[a]; ``out`` may be ``a``."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    for k in range(Q):
        F[out, k] = c * F[a, k]
    F[out, Q + 1] = abs(c) * F[a, Q + 1]
    F[out, Q + 2] = abs(c) * F[a, Q + 2]
    F[out, Q] = inflate(abs(c) * F[a, Q], magnitude(F, out, S), 10.0)


@njit(signatures("void(f8[:, ::1], i8, i8, f8, S)"), cache=True, nogil=True)
def add_scaled(F: Forms, out: int, a: int, c: float, S: Symbols) -> None:
    """Add c F[a] to ``out``."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    # A term passes one product and one sum; 3 u of both magnitudes is enough.
    total = magnitude(F, out, S) + abs(c) * magnitude(F, a, S)
    for k in range(Q):
        F[out, k] += c * F[a, k]
    F[out, Q] = inflate(F[out, Q] + abs(c) * F[a, Q], 1.5 * total, 40.0)
    close(F, out, S)


@njit(signatures("void(f8[:, ::1], i8, i8, f8, f8, f8, f8, S)"), cache=True, nogil=True)
def combine3(F: Forms, out: int, a: int, c0: float, c1: float, c2: float, error: float, S: Symbols) -> None:
    """Set ``out`` to c0 F[a] + c1 F[a + 1] + c2 F[a + 2], up to ``error``."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    for k in range(Q):
        F[out, k] = c0 * F[a, k] + c1 * F[a + 1, k] + c2 * F[a + 2, k]
    e = abs(c0) * F[a, Q] + abs(c1) * F[a + 1, Q] + abs(c2) * F[a + 2, Q]
    total = abs(c0) * magnitude(F, a, S) + abs(c1) * magnitude(F, a + 1, S)
    total += abs(c2) * magnitude(F, a + 2, S)
    # A term passes one product and two sums.
    F[out, Q] = inflate(error + e, 2.0 * total, 60.0)
    close(F, out, S)


@njit(signatures("void(f8[:, ::1], i8, i8, f8[:, ::1], i8, S)"), cache=True, nogil=True)
def combine6(F: Forms, out: int, a: int, W: Any, y: int, S: Symbols) -> None:
    """Set ``out`` to the sum over k < 6 of W[y, k] F[a + k]."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    c0, c1, c2 = W[y, 0], W[y, 1], W[y, 2]
    c3, c4, c5 = W[y, 3], W[y, 4], W[y, 5]
    for k in range(Q):
        F[out, k] = (c0 * F[a, k] + c1 * F[a + 1, k] + c2 * F[a + 2, k]) + (
            c3 * F[a + 3, k] + c4 * F[a + 4, k] + c5 * F[a + 5, k]
        )
    error = 0.0
    total = 0.0
    for j in range(6):
        error += abs(W[y, j]) * F[a + j, Q]
        total += abs(W[y, j]) * magnitude(F, a + j, S)
    # A term passes one product and at most three sums.
    F[out, Q] = inflate(error, 2.5 * total, 80.0)
    close(F, out, S)


@njit("f8(f8[:, ::1], i8, i8, f8[:, ::1], i8)", cache=True, nogil=True)
def times_slopes(F: Forms, a: int, column: int, W: Any, y: int) -> float:
    """Return the sum over k < 6 of W[y, k] F[a + k, column], rounded to nearest."""
    first = W[y, 0] * F[a, column] + W[y, 1] * F[a + 1, column] + W[y, 2] * F[a + 2, column]
    second = W[y, 3] * F[a + 3, column] + W[y, 4] * F[a + 4, column] + W[y, 5] * F[a + 5, column]
    return float(first + second)


@njit(signatures("void(f8[:, ::1], i8, i8, f8[:, ::1], i8, S)"), cache=True, nogil=True)
def moving6(F: Forms, out: int, a: int, W: Any, y: int, S: Symbols) -> None:
    """Set ``out`` to the sum over k < 6 of y_k F[a + k] with y_k = W[y, k] + sum_m W[y + 1 + m, k] eps_m."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    combine6(F, out, a, W, y, S)
    error = F[out, Q]
    total = magnitude(F, out, S)
    for j in range(6):
        slopes = 0.0
        for m in range(K):
            slopes += abs(W[y + 1 + m, j])
        error += slopes * (F[a + j, Q + 2] + F[a + j, Q])
        total += slopes * magnitude(F, a + j, S)
    q = 1 + 2 * K
    for m in range(K):
        F[out, 1 + m] += times_slopes(F, a, 0, W, y + 1 + m)
        F[out, 1 + K + m] += times_slopes(F, a, 1 + m, W, y + 1 + m)
        for n in range(m + 1, K):
            F[out, q] += times_slopes(F, a, 1 + n, W, y + 1 + m) + times_slopes(F, a, 1 + m, W, y + 1 + n)
            q += 1
    # A term passes one product and at most five sums.
    F[out, Q] = inflate(error, 3.5 * total, 200.0)
    close(F, out, S)


@njit(signatures("void(f8[:, ::1], i8, i8, i8, f8, S)"), cache=True, nogil=True)
def add_product(F: Forms, out: int, a: int, b: int, sign: float, S: Symbols) -> None:
    """Add ``sign`` (1 or -1) times F[a] F[b] to ``out``."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    before = magnitude(F, out, S)
    a0 = sign * F[a, 0]
    b0 = F[b, 0]
    F[out, 0] += a0 * b0
    sb = sign * b0
    for k in range(1, Q):
        F[out, k] += a0 * F[b, k] + sb * F[a, k]
    q = 1 + 2 * K
    for k in range(K):
        x = sign * F[a, 1 + k]
        y = sign * F[b, 1 + k]
        F[out, 1 + K + k] += x * F[b, 1 + k]
        for m in range(k + 1, K):
            F[out, q] += x * F[b, 1 + m] + y * F[a, 1 + m]
            q += 1
    la, qa, ea = F[a, Q + 1], F[a, Q + 2], F[a, Q]
    lb, qb, eb = F[b, Q + 1], F[b, Q + 2], F[b, Q]
    ma = abs(a0) + la + qa
    mb = abs(b0) + lb + qb
    error = la * qb + qa * (lb + qb) + ea * (mb + eb) + ma * eb
    # A term of the product passes one product and at most four sums, one of the row at most two.
    F[out, Q] = inflate(F[out, Q] + error, 3.0 * (ma * mb + before), 100.0)
    close(F, out, S)


@njit(signatures("void(f8[:, ::1], i8, i8, i8, S)"), cache=True, nogil=True)
def multiply(F: Forms, out: int, a: int, b: int, S: Symbols) -> None:
    """Set ``out`` to F[a] F[b]."""
    constant(F, out, 0.0, 0.0, S)
    add_product(F, out, a, b, 1.0, S)


@njit(signatures("void(f8[:, ::1], i8, i8, i8, S)"), cache=True, nogil=True)
def dot3(F: Forms, out: int, a: int, b: int, S: Symbols) -> None:
    """Set ``out`` to F[a] F[b] + F[a + 1] F[b + 1] + F[a + 2] F[b + 2]."""
    constant(F, out, 0.0, 0.0, S)
    for k in range(3):
        add_product(F, out, a + k, b + k, 1.0, S)


@njit(signatures("void(f8[:, ::1], i8, i8, i8, S)"), cache=True, nogil=True)
def cross3(F: Forms, out: int, a: int, b: int, S: Symbols) -> None:
    """Set the rows ``out`` .. ``out + 2`` to the cross product of the vectors in rows ``a`` and ``b``."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        constant(F, out + k, 0.0, 0.0, S)
        add_product(F, out + k, a + i, b + j, 1.0, S)
        add_product(F, out + k, a + j, b + i, -1.0, S)
