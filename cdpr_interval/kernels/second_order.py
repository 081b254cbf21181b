"""Second-order forms: centre + linear part + quadratic part in K noise symbols + error, four cells at once.

With ``Q = 1 + K + K (K + 1) / 2`` coefficients, row ``i`` of an array ``F`` (rows, width, LANES) holds

    c, l_1 .. l_K, q_11 .. q_KK, q_12, q_13, .. q_(K-1)K, error, sum |l|, sum |q|, d_1 .. d_P, sum |d|

in every lane and encloses a function of the symbols eps_k, delta_j in [-1, 1] when for every value of them it
differs from c + sum l_k eps_k + sum q_kk eps_k^2 + sum q_km eps_k eps_m + sum d_j delta_j by at most
``error``. The P symbols delta_j are those of data that have ranges: their parts are small and enter to
first order only, every product with one goes into the error. The last P + 1 columns are there for P > 0
only. The sums are kept because every product needs them; ``close`` writes them after a row was filled by
hand. Each lane belongs to another cell and is computed as if it were alone.

Polynomials of degree two in eps are represented exactly up to rounding; a product drops its terms of third
and fourth order into the error. Rounding goes through ``rounding.inflate_lanes``: the magnitude of a row,
|c| + sum |l| + sum |q| + sum |d|, bounds the sum over all its coefficients, so one number accounts for a
whole row. Infinite or NaN entries can only arise from overflow and make ``bounds`` return (-inf, inf).

Arrays: ``F`` (rows, width, LANES) forms; ``W`` (rows, >= 6, LANES) weights of six forms a row.

``S`` holds two tuples of K and P zeros: their lengths are known to the compiler, which makes every loop one
of fixed length. Signatures are explicit because numba would otherwise compile a copy of every kernel for
each row number that a caller writes as a constant.

Reference: M. Berz, K. Makino, Reliable Computing 4 (1998), for arithmetic with a remainder.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from numba import types

from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray, Lanes, array3, lanes, load, splat, store, where_less
from cdpr_interval.kernels.rounding import down_lanes, inflate_lanes, up_lanes

Forms = LaneArray
"""float64 array (rows, Q + 3, LANES)."""


class Symbols(NamedTuple):
    """The symbols of forms, an entry (of no meaning) for each."""

    noise: tuple[int, ...]
    """Those of a cell, whose squares and products are kept."""
    data: tuple[int, ...] = ()
    """Those of data with ranges, kept to first order."""


ROTATION_ONLY = Symbols((0,) * 4)
"""Four symbols: three of the rotation, one for the error of the position along one direction."""
WHOLE_POSE = Symbols((0,) * 6)
"""Six symbols: rotation and position."""
ROTATION_AND_DATA = Symbols((0,) * 4, (0,) * 6)
"""As ``ROTATION_ONLY``, and the lengths of up to six taut cables."""
POSE_AND_DATA = Symbols((0,) * 6, (0,) * 6)
"""As ``WHOLE_POSE``, and the lengths of up to six taut cables."""
ROTATION_AND_ALL_DATA = Symbols((0,) * 4, (0,) * 48)
"""As ``ROTATION_AND_DATA``; behind the lengths six symbols of each cable's points, three of the centre of
mass and three of the load."""
POSE_AND_ALL_DATA = Symbols((0,) * 6, (0,) * 48)
"""As ``WHOLE_POSE``, and all those of data."""
ALONG_DATA = Symbols((0,) * 6, (0,) * 12)
"""The lengths of up to six taut cables as what forms vary with most; offsets of the unknowns besides."""
ALONG_ALL_DATA = Symbols((0,) * 6, (0,) * 54)
"""As ``ALONG_DATA``, and behind the offsets the symbols of points, centre of mass and load."""
ALL_SYMBOLS = (
    *(ROTATION_ONLY, WHOLE_POSE),
    *(ROTATION_AND_DATA, POSE_AND_DATA, ALONG_DATA),
    *(ROTATION_AND_ALL_DATA, POSE_AND_ALL_DATA, ALONG_ALL_DATA),
)


def width(symbols: Symbols) -> int:
    """Return the number of columns of a form array."""
    k, p = len(symbols.noise), len(symbols.data)
    return 1 + k + k * (k + 1) // 2 + 3 + (p + 1 if p else 0)


def type_of(symbols: Symbols) -> Any:
    """Return the numba type of the symbols of forms."""
    return types.BaseTuple.from_types([zeros(len(symbols.noise)), zeros(len(symbols.data))], Symbols)


def zeros(count: int) -> Any:
    """Return the numba type of a tuple of so many integers."""
    return types.UniTuple(types.int64, count) if count else types.Tuple(())


def signatures(result: Any, *arguments: Any) -> list[Any]:
    """Return a kernel's signatures for all symbols there are, which come last."""
    return [result(array3, *arguments, type_of(symbols)) for symbols in ALL_SYMBOLS]


@kernel()
def columns(S: Symbols) -> int:
    """Return ``width``."""
    K, P = len(S.noise), len(S.data)
    return 1 + K + K * (K + 1) // 2 + 3 + (P + 1 if P > 0 else 0)


@kernel()
def slope_column(symbol: int, S: Symbols) -> int:
    """Return the column of the slope in a symbol: those of the cell come first, then those of the data."""
    K = len(S.noise)
    return 1 + symbol if symbol < K else 1 + K + K * (K + 1) // 2 + 3 + symbol - K


ROW = types.int64
NONE = types.void


@kernel(signatures(lanes, ROW))
def magnitude(F: Forms, i: int, S: Symbols) -> Lanes:
    """Return |c| + sum |l| + sum |q| + sum |d|, without the error (rounded to nearest)."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    total = abs(load(F, i, 0)) + load(F, i, Q + 1) + load(F, i, Q + 2)
    if P > 0:
        total += load(F, i, Q + 3 + P)
    return total


@kernel(signatures(lanes, ROW))
def largest(F: Forms, i: int, S: Symbols) -> Lanes:
    """Return an upper bound of |form i|; infinite or NaN after an overflow."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    total = abs(load(F, i, 0)) + load(F, i, Q + 1) + load(F, i, Q + 2) + load(F, i, Q)
    if P > 0:
        total += load(F, i, Q + 3 + P)
    return inflate_lanes(total, splat(0.0), 60.0)


@kernel(signatures(lanes, ROW))
def data_sum(F: Forms, i: int, S: Symbols) -> Lanes:
    """Return sum |d| of row ``i``, from its slopes."""
    K, P = len(S.noise), len(S.data)
    first = 1 + K + K * (K + 1) // 2 + 3
    total = splat(0.0)
    for d in range(first, first + P):
        total += abs(load(F, i, d))
    return total


@kernel(signatures(NONE, ROW))
def close(F: Forms, i: int, S: Symbols) -> None:
    """Write the sums |l|, |q| and |d| of row ``i``."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    linear = splat(0.0)
    for k in range(1, 1 + K):
        linear += abs(load(F, i, k))
    # Two partial sums: a single one would wait for each addition.
    even, odd = splat(0.0), splat(0.0)
    for k in range(1 + K, Q - 1, 2):
        even += abs(load(F, i, k))
        odd += abs(load(F, i, k + 1))
    if (Q - 1 - K) % 2 == 1:
        even += abs(load(F, i, Q - 1))
    store(F, i, Q + 1, linear)
    store(F, i, Q + 2, even + odd)
    if P > 0:
        store(F, i, Q + 3 + P, data_sum(F, i, S))


@kernel(signatures(NONE, ROW, lanes, lanes))
def constant(F: Forms, out: int, value: Lanes, error: Lanes, S: Symbols) -> None:
    """Set ``out`` to all numbers within ``error`` of ``value``."""
    K = len(S.noise)
    Q = 1 + K + K * (K + 1) // 2
    for k in range(columns(S)):
        store(F, out, k, 0.0)
    store(F, out, 0, value)
    store(F, out, Q, error)


@kernel(signatures(NONE, ROW, lanes))
def widen(F: Forms, i: int, error: Lanes, S: Symbols) -> None:
    """Add ``error`` to the error of row ``i``."""
    K = len(S.noise)
    Q = 1 + K + K * (K + 1) // 2
    store(F, i, Q, up_lanes(load(F, i, Q) + error))


@kernel(signatures(types.UniTuple(lanes, 2), ROW))
def bounds(F: Forms, i: int, S: Symbols) -> tuple[Lanes, Lanes]:
    """Enclose the range of form ``i``; (-inf, inf) after an overflow.

    In each symbol alone, l eps + q eps^2 is bounded by its exact range on [-1, 1].
    """
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    below = load(F, i, Q)
    if P > 0:
        below += load(F, i, Q + 3 + P)
    for k in range(1 + 2 * K, Q):
        below += abs(load(F, i, k))
    above = below
    for k in range(K):
        linear = abs(load(F, i, 1 + k))
        square = load(F, i, 1 + K + k)
        size = abs(square)
        # The parabola reaches l + |q| on one side, on the other l^2 / (4 |q|) if its vertex is inside.
        near = where_less(linear, 2.0 * size, linear * (0.25 * (linear / size)), linear - size)
        far = linear + size
        above += where_less(0.0, square, far, near)
        below += where_less(0.0, square, near, far)
    # 60 operations; the differences l - |q| are covered by the magnitude.
    centre = load(F, i, 0)
    total = magnitude(F, i, S)
    lo = down_lanes(centre - inflate_lanes(below, total, 60.0))
    hi = up_lanes(centre + inflate_lanes(above, total, 60.0))
    # lo < hi always, by the last roundings, unless one is NaN.
    return where_less(lo, hi, lo, -math.inf), where_less(lo, hi, hi, math.inf)


@kernel(signatures(NONE, ROW, ROW, lanes))
def scale(F: Forms, out: int, a: int, c: Lanes, S: Symbols) -> None:
    """Set ``out`` to c F[a]; ``out`` may be ``a``."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    for k in range(Q):
        store(F, out, k, c * load(F, a, k))
    size = abs(c)
    linear, quadratic = size * load(F, a, Q + 1), size * load(F, a, Q + 2)
    error = size * load(F, a, Q)
    total = abs(load(F, out, 0)) + linear + quadratic
    if P > 0:
        for d in range(Q + 3, Q + 3 + P):
            store(F, out, d, c * load(F, a, d))
        slopes = size * load(F, a, Q + 3 + P)
        store(F, out, Q + 3 + P, slopes)
        total += slopes
    store(F, out, Q + 1, linear)
    store(F, out, Q + 2, quadratic)
    store(F, out, Q, inflate_lanes(error, total, 10.0))


@kernel(signatures(NONE, ROW, ROW))
def copy(F: Forms, out: int, a: int, S: Symbols) -> None:
    """Set ``out`` to F[a]."""
    for k in range(columns(S)):
        store(F, out, k, load(F, a, k))


@kernel(signatures(NONE, ROW, ROW, lanes, ROW, lanes))
def combine2(F: Forms, out: int, a: int, ca: Lanes, b: int, cb: Lanes, S: Symbols) -> None:
    """Set ``out`` to ca F[a] + cb F[b]; ``out`` may be one of them."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    # A term passes one product and one sum; 3 u of both magnitudes is enough.
    total = abs(ca) * magnitude(F, a, S) + abs(cb) * magnitude(F, b, S)
    error = abs(ca) * load(F, a, Q) + abs(cb) * load(F, b, Q)
    store(F, out, 0, ca * load(F, a, 0) + cb * load(F, b, 0))
    linear, quadratic = splat(0.0), splat(0.0)
    for k in range(1, 1 + K):
        x = ca * load(F, a, k) + cb * load(F, b, k)
        store(F, out, k, x)
        linear += abs(x)
    for k in range(1 + K, Q):
        x = ca * load(F, a, k) + cb * load(F, b, k)
        store(F, out, k, x)
        quadratic += abs(x)
    if P > 0:
        slopes = splat(0.0)
        for d in range(Q + 3, Q + 3 + P):
            x = ca * load(F, a, d) + cb * load(F, b, d)
            store(F, out, d, x)
            slopes += abs(x)
        store(F, out, Q + 3 + P, slopes)
    store(F, out, Q, inflate_lanes(error, 1.5 * total, 40.0))
    store(F, out, Q + 1, linear)
    store(F, out, Q + 2, quadratic)


@kernel(signatures(NONE, ROW, ROW, lanes))
def add_scaled(F: Forms, out: int, a: int, c: Lanes, S: Symbols) -> None:
    """Add c F[a] to ``out``."""
    combine2(F, out, out, splat(1.0), a, c, S)


@kernel(signatures(NONE, ROW, ROW, lanes, lanes, lanes, lanes))
def combine3(F: Forms, out: int, a: int, c0: Lanes, c1: Lanes, c2: Lanes, error: Lanes, S: Symbols) -> None:
    """Set ``out`` to c0 F[a] + c1 F[a + 1] + c2 F[a + 2], up to ``error``; ``out`` is another row."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    store(F, out, 0, c0 * load(F, a, 0) + c1 * load(F, a + 1, 0) + c2 * load(F, a + 2, 0))
    linear, quadratic = splat(0.0), splat(0.0)
    for k in range(1, 1 + K):
        x = c0 * load(F, a, k) + c1 * load(F, a + 1, k) + c2 * load(F, a + 2, k)
        store(F, out, k, x)
        linear += abs(x)
    for k in range(1 + K, Q):
        x = c0 * load(F, a, k) + c1 * load(F, a + 1, k) + c2 * load(F, a + 2, k)
        store(F, out, k, x)
        quadratic += abs(x)
    if P > 0:
        slopes = splat(0.0)
        for d in range(Q + 3, Q + 3 + P):
            x = c0 * load(F, a, d) + c1 * load(F, a + 1, d) + c2 * load(F, a + 2, d)
            store(F, out, d, x)
            slopes += abs(x)
        store(F, out, Q + 3 + P, slopes)
    e = abs(c0) * load(F, a, Q) + abs(c1) * load(F, a + 1, Q) + abs(c2) * load(F, a + 2, Q)
    total = abs(c0) * magnitude(F, a, S) + abs(c1) * magnitude(F, a + 1, S)
    total += abs(c2) * magnitude(F, a + 2, S)
    # A term passes one product and two sums.
    store(F, out, Q, inflate_lanes(error + e, 2.0 * total, 60.0))
    store(F, out, Q + 1, linear)
    store(F, out, Q + 2, quadratic)


@kernel(lanes(array3, ROW, ROW, array3, ROW))
def weighted_column(F: Forms, a: int, column: int, W: LaneArray, y: int) -> Lanes:
    """Return the sum over k < 6 of W[y, k] F[a + k, column], rounded to nearest."""
    first = load(W, y, 0) * load(F, a, column) + load(W, y, 1) * load(F, a + 1, column)
    first += load(W, y, 2) * load(F, a + 2, column)
    second = load(W, y, 3) * load(F, a + 3, column) + load(W, y, 4) * load(F, a + 4, column)
    return first + (second + load(W, y, 5) * load(F, a + 5, column))


@kernel(signatures(NONE, ROW, ROW, array3, ROW))
def combine6(F: Forms, out: int, a: int, W: LaneArray, y: int, S: Symbols) -> None:
    """Set ``out`` to the sum over k < 6 of W[y, k] F[a + k]; ``out`` is another row."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    store(F, out, 0, weighted_column(F, a, 0, W, y))
    linear, quadratic = splat(0.0), splat(0.0)
    for k in range(1, 1 + K):
        x = weighted_column(F, a, k, W, y)
        store(F, out, k, x)
        linear += abs(x)
    for k in range(1 + K, Q):
        x = weighted_column(F, a, k, W, y)
        store(F, out, k, x)
        quadratic += abs(x)
    if P > 0:
        slopes = splat(0.0)
        for d in range(Q + 3, Q + 3 + P):
            x = weighted_column(F, a, d, W, y)
            store(F, out, d, x)
            slopes += abs(x)
        store(F, out, Q + 3 + P, slopes)
    error = splat(0.0)
    total = splat(0.0)
    for j in range(6):
        size = abs(load(W, y, j))
        error += size * load(F, a + j, Q)
        total += size * magnitude(F, a + j, S)
    # A term passes one product and at most three sums.
    store(F, out, Q, inflate_lanes(error, 2.5 * total, 80.0))
    store(F, out, Q + 1, linear)
    store(F, out, Q + 2, quadratic)


@kernel(signatures(NONE, ROW, ROW, array3, ROW))
def moving6(F: Forms, out: int, a: int, W: LaneArray, y: int, S: Symbols) -> None:
    """Set ``out`` to the sum over k < 6 of y_k F[a + k] with y_k = W[y, k] + sum_m W[y + 1 + m, k] eps_m.

    The symbols of data follow those of the cell.
    """
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    store(F, out, 0, weighted_column(F, a, 0, W, y))
    linear, quadratic = splat(0.0), splat(0.0)
    q = 1 + 2 * K
    for m in range(K):
        slope = y + 1 + m
        x = weighted_column(F, a, 1 + m, W, y) + weighted_column(F, a, 0, W, slope)
        store(F, out, 1 + m, x)
        linear += abs(x)
        x = weighted_column(F, a, 1 + K + m, W, y) + weighted_column(F, a, 1 + m, W, slope)
        store(F, out, 1 + K + m, x)
        quadratic += abs(x)
        for n in range(m + 1, K):
            mixed = weighted_column(F, a, 1 + n, W, slope) + weighted_column(F, a, 1 + m, W, y + 1 + n)
            x = weighted_column(F, a, q, W, y) + mixed
            store(F, out, q, x)
            quadratic += abs(x)
            q += 1
    error = splat(0.0)
    total = splat(0.0)
    for j in range(6):
        slopes = splat(0.0)
        for m in range(K):
            slopes += abs(load(W, y + 1 + m, j))
        size = abs(load(W, y, j))
        higher = load(F, a + j, Q + 2) + load(F, a + j, Q)
        if P > 0:
            higher += load(F, a + j, Q + 3 + P)
            turning = splat(0.0)
            for p in range(P):
                turning += abs(load(W, y + 1 + K + p, j))
            error += turning * (load(F, a + j, Q + 1) + higher)
            total += turning * magnitude(F, a + j, S)
        error += size * load(F, a + j, Q) + slopes * higher
        total += (size + slopes) * magnitude(F, a + j, S)
    if P > 0:
        sizes = splat(0.0)
        for p in range(P):
            x = weighted_column(F, a, Q + 3 + p, W, y) + weighted_column(F, a, 0, W, y + 1 + K + p)
            store(F, out, Q + 3 + p, x)
            sizes += abs(x)
        store(F, out, Q + 3 + P, sizes)
    # A term passes one product and at most five sums.
    store(F, out, Q, inflate_lanes(error, 3.5 * total, 200.0))
    store(F, out, Q + 1, linear)
    store(F, out, Q + 2, quadratic)


@kernel(signatures(lanes, ROW, ROW))
def product_error(F: Forms, a: int, b: int, S: Symbols) -> Lanes:
    """Return the error of F[a] F[b]: terms of third order and more, of data times symbols, their errors."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    la, qa, ea = load(F, a, Q + 1), load(F, a, Q + 2), load(F, a, Q)
    lb, qb, eb = load(F, b, Q + 1), load(F, b, Q + 2), load(F, b, Q)
    ma = abs(load(F, a, 0)) + la + qa
    mb = abs(load(F, b, 0)) + lb + qb
    error = la * qb + qa * (lb + qb)
    if P > 0:
        da, db = load(F, a, Q + 3 + P), load(F, b, Q + 3 + P)
        error += da * (lb + qb + db) + db * (la + qa)
        ma += da
        mb += db
    return error + ea * (mb + eb) + ma * eb


@kernel(signatures(NONE, ROW, ROW, ROW, types.float64))
def add_product(F: Forms, out: int, a: int, b: int, sign: float, S: Symbols) -> None:
    """Add ``sign`` (1 or -1) times F[a] F[b] to ``out``, another row."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    total = magnitude(F, out, S) + magnitude(F, a, S) * magnitude(F, b, S)
    error = load(F, out, Q) + product_error(F, a, b, S)
    a0 = sign * load(F, a, 0)
    b0 = sign * load(F, b, 0)
    store(F, out, 0, load(F, out, 0) + a0 * load(F, b, 0))
    linear, quadratic = splat(0.0), splat(0.0)
    q = 1 + 2 * K
    for k in range(K):
        ak, bk = load(F, a, 1 + k), load(F, b, 1 + k)
        new = load(F, out, 1 + k) + (a0 * bk + b0 * ak)
        store(F, out, 1 + k, new)
        linear += abs(new)
        x, y = sign * ak, sign * bk
        square = 1 + K + k
        new = load(F, out, square) + (a0 * load(F, b, square) + b0 * load(F, a, square)) + x * bk
        store(F, out, square, new)
        quadratic += abs(new)
        for m in range(k + 1, K):
            old = load(F, out, q) + (a0 * load(F, b, q) + b0 * load(F, a, q))
            new = old + (x * load(F, b, 1 + m) + y * load(F, a, 1 + m))
            store(F, out, q, new)
            quadratic += abs(new)
            q += 1
    if P > 0:
        slopes = splat(0.0)
        for d in range(Q + 3, Q + 3 + P):
            new = load(F, out, d) + (a0 * load(F, b, d) + b0 * load(F, a, d))
            store(F, out, d, new)
            slopes += abs(new)
        store(F, out, Q + 3 + P, slopes)
    # A term of the product passes one product and at most four sums, one of the row at most two.
    store(F, out, Q, inflate_lanes(error, 3.0 * total, 100.0))
    store(F, out, Q + 1, linear)
    store(F, out, Q + 2, quadratic)


@kernel(signatures(NONE, ROW, ROW, ROW, types.float64))
def multiply(F: Forms, out: int, a: int, b: int, sign: float, S: Symbols) -> None:
    """Set ``out`` to ``sign`` (1 or -1) times F[a] F[b]; ``out`` is another row."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    a0 = sign * load(F, a, 0)
    b0 = sign * load(F, b, 0)
    store(F, out, 0, a0 * load(F, b, 0))
    linear, quadratic = splat(0.0), splat(0.0)
    q = 1 + 2 * K
    for k in range(K):
        ak, bk = load(F, a, 1 + k), load(F, b, 1 + k)
        new = a0 * bk + b0 * ak
        store(F, out, 1 + k, new)
        linear += abs(new)
        x, y = sign * ak, sign * bk
        square = 1 + K + k
        new = (a0 * load(F, b, square) + b0 * load(F, a, square)) + x * bk
        store(F, out, square, new)
        quadratic += abs(new)
        for m in range(k + 1, K):
            old = a0 * load(F, b, q) + b0 * load(F, a, q)
            new = old + (x * load(F, b, 1 + m) + y * load(F, a, 1 + m))
            store(F, out, q, new)
            quadratic += abs(new)
            q += 1
    if P > 0:
        slopes = splat(0.0)
        for d in range(Q + 3, Q + 3 + P):
            new = a0 * load(F, b, d) + b0 * load(F, a, d)
            store(F, out, d, new)
            slopes += abs(new)
        store(F, out, Q + 3 + P, slopes)
    total = magnitude(F, a, S) * magnitude(F, b, S)
    # A term passes one product and at most three sums.
    store(F, out, Q, inflate_lanes(product_error(F, a, b, S), 3.0 * total, 100.0))
    store(F, out, Q + 1, linear)
    store(F, out, Q + 2, quadratic)


@kernel(signatures(NONE, ROW, ROW, ROW))
def dot3(F: Forms, out: int, a: int, b: int, S: Symbols) -> None:
    """Set ``out`` to F[a] F[b] + F[a + 1] F[b + 1] + F[a + 2] F[b + 2]."""
    multiply(F, out, a, b, 1.0, S)
    add_product(F, out, a + 1, b + 1, 1.0, S)
    add_product(F, out, a + 2, b + 2, 1.0, S)


@kernel(signatures(NONE, ROW, ROW, ROW))
def cross3(F: Forms, out: int, a: int, b: int, S: Symbols) -> None:
    """Set the rows ``out`` .. ``out + 2`` to the cross product of the vectors in rows ``a`` and ``b``."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        multiply(F, out + k, a + i, b + j, 1.0, S)
        add_product(F, out + k, a + j, b + i, -1.0, S)


@kernel(signatures(NONE, ROW, ROW, lanes, lanes))
def put_slope(F: Forms, out: int, datum: int, c: Lanes, error: Lanes, S: Symbols) -> None:
    """Add c delta to ``out`` for one of the symbols of data, c known up to ``error``; ``close_data`` follows.

    Without such symbols the size of c is an error.
    """
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    if P > 0:
        before = load(F, out, Q + 3 + datum)
        new = before + c
        store(F, out, Q + 3 + datum, new)
        store(F, out, Q, inflate_lanes(load(F, out, Q) + error, abs(before) + abs(c) + abs(new), 20.0))
    else:
        store(F, out, Q, inflate_lanes(load(F, out, Q) + error + abs(c), splat(0.0), 20.0))


@kernel(signatures(NONE, ROW))
def close_data(F: Forms, i: int, S: Symbols) -> None:
    """Write the sum |d| of row ``i``."""
    K, P = len(S.noise), len(S.data)
    if P > 0:
        store(F, i, 1 + K + K * (K + 1) // 2 + 3 + P, data_sum(F, i, S))


@kernel(signatures(lanes, ROW))
def rest(F: Forms, i: int, S: Symbols) -> Lanes:
    """Return an upper bound of the distance of form ``i`` from its centre."""
    most = largest(F, i, S)
    return inflate_lanes(most - abs(load(F, i, 0)), most, 4.0)


@kernel(signatures(NONE, ROW, ROW, ROW, types.float64))
def put_datum(F: Forms, out: int, a: int, datum: int, c: float, S: Symbols) -> None:
    """Add c delta F[a] to ``out``, any row, for one of the symbols of data; ``close_data`` follows."""
    centre = c * load(F, a, 0)
    error = inflate_lanes(abs(splat(c)) * rest(F, a, S), abs(centre), 10.0)
    put_slope(F, out, datum, centre, error, S)


@kernel(signatures(NONE, ROW, ROW, ROW, types.float64))
def add_datum(F: Forms, out: int, a: int, datum: int, c: float, S: Symbols) -> None:
    """Add c delta F[a] to ``out``, another row, for one of the symbols of data.

    Without symbols of data c bounds an error.
    """
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    size = abs(c)
    error = load(F, out, Q) + size * (load(F, a, Q) + load(F, a, Q + 1) + load(F, a, Q + 2))
    centre = c * load(F, a, 0)
    if P > 0:
        d = Q + 3 + datum
        before = load(F, out, d)
        new = before + centre
        error += size * load(F, a, Q + 3 + P)
        store(F, out, d, new)
        store(F, out, Q + 3 + P, data_sum(F, out, S))
        store(F, out, Q, inflate_lanes(error, abs(before) + abs(centre) + abs(new), 60.0))
    else:
        store(F, out, Q, inflate_lanes(error + abs(centre), splat(0.0), 60.0))
