"""Statics of a cell: proofs that no non-negative tensions balance the load, equations, tension bounds.

All tests use the rows WRENCH.. and LOAD (scaled by s > 0, which cancels) and the rows PIVOT.., which
vanish at every solution and may be added to any form. Directions y in R^6 are found in floats at the cell's
centre; whatever they are, the forms y . w decide.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.rounding import down, inflate, up
from cdpr_interval.kernels.second_order import (
    Symbols,
    add_scaled,
    bounds,
    combine6,
    largest,
    moving6,
    widen,
)
from solvers.platform_elimination import reduce_row
from solvers.platform_polynomials import EQUATION, LOAD, MOST_TAUT, SCRATCH, WRENCH

COLUMNS = 8
"""First of seven rows of W: wrenches at the centre, normalised (0..5), their norms (6), right sides (7)."""
NORM, RIGHT = 6, 7
Y = 15
"""Row of W with y; the six rows behind it hold its slopes."""
MOST_TENSION = 22
"""Row of W with upper bounds of t_i = tension_i / l_i."""
SOME_TENSION = 23
"""Row of W with approximate t_i."""
BASIS = 24
"""First of six rows of W: an orthonormal basis that starts with the wrenches' span."""
INVERSE = 38
"""First of seven rows of W: the inverse of the columns' Gram matrix."""
RIDGE = 1e-12
"""Added to the Gram matrix's diagonal: a useless y only costs a bisection."""
FLOOR = 1e-3
"""Least right side of a form relative to the largest: the load's form hardly varies, yet must be positive."""


@njit(cache=True, nogil=True)
def wrench_of(i: int, n: int) -> int:
    """Return the first row of wrench i; i = n is the load."""
    return LOAD if i == n else WRENCH + 6 * i


@njit(cache=True, nogil=True)
def centre_columns(F: Any, W: Any, n: int) -> bool:
    """Write the normalised wrenches of the centre and right sides 1; False when one vanishes."""
    for i in range(n + 1):
        row = wrench_of(i, n)
        total = 0.0
        for k in range(6):
            W[COLUMNS + i, k] = F[row + k, 0]
            total += F[row + k, 0] ** 2
        norm = math.sqrt(total)
        if not 0.0 < norm < math.inf:
            return False
        W[COLUMNS + i, NORM] = norm
        W[COLUMNS + i, RIGHT] = 1.0
        for k in range(6):
            W[COLUMNS + i, k] /= norm
    return True


@njit(cache=True, nogil=True)
def invert_gram(W: Any, m: int, ridge: float) -> bool:
    """Write the inverse of the Gram matrix of the first m columns to W[INVERSE..]."""
    for i in range(m):
        for j in range(m):
            s = 0.0
            for k in range(6):
                s += W[COLUMNS + i, k] * W[COLUMNS + j, k]
            W[i, j] = s
            W[i, m + j] = 1.0 if i == j else 0.0
        W[i, i] += ridge
    if not solve_in_place(W, m, m):
        return False
    for i in range(m):
        for j in range(m):
            W[INVERSE + i, j] = W[i, m + j]
    return True


@njit(cache=True, nogil=True)
def choose_y(W: Any, m: int) -> None:
    """Write the least-norm y with y . column_i = right side i, i < m."""
    for k in range(6):
        W[Y, k] = 0.0
    for i in range(m):
        s = 0.0
        for j in range(m):
            s += W[INVERSE + i, j] * W[COLUMNS + j, RIGHT]
        for k in range(6):
            W[Y, k] += s * W[COLUMNS + i, k]


@njit(cache=True, nogil=True)
def choose_slopes(F: Any, W: Any, n: int, m: int, S: Symbols) -> None:
    """Write slopes of y that cancel the slopes of y . w_i, i < m (i = n is the load)."""
    K = len(S)
    for symbol in range(K):
        for k in range(6):
            W[Y + 1 + symbol, k] = 0.0
        for i in range(m):
            row = wrench_of(i, n)
            s = 0.0
            for k in range(6):
                s -= W[Y, k] * F[row + k, 1 + symbol]
            W[0, i] = s / W[COLUMNS + i, NORM]
        for i in range(m):
            s = 0.0
            for j in range(m):
                s += W[INVERSE + i, j] * W[0, j]
            for k in range(6):
                W[Y + 1 + symbol, k] += s * W[COLUMNS + i, k]


@njit(cache=True, nogil=True)
def weigh(F: Any, W: Any, row: int, moving: bool, rank: int, S: Symbols) -> tuple[float, float]:
    """Bound y . w at all solutions in the cell; leaves the form in SCRATCH."""
    if moving:
        moving6(F, SCRATCH, row, W, Y, S)
    else:
        combine6(F, SCRATCH, row, W, Y, S)
    reduce_row(F, SCRATCH, W, rank, S)
    return bounds(F, SCRATCH, S)


@njit(cache=True, nogil=True)
def all_positive(F: Any, W: Any, n: int, m: int, moving: bool, rank: int, S: Symbols) -> bool:
    """Return True when y . w_i > 0 is proved for i < m (i = n is the load).

    Leaves lower bounds in W[MOST_TENSION] and the forms' radii, normalised, as the next right sides.
    """
    positive = True
    most = 0.0
    for i in range(m):
        lo, _ = weigh(F, W, wrench_of(i, n), moving, rank, S)
        positive = positive and lo > 0.0
        W[MOST_TENSION, i] = lo
        radius = max(F[SCRATCH, 0] - lo, 0.0) / W[COLUMNS + i, NORM]
        W[COLUMNS + i, RIGHT] = radius
        most = max(most, radius)
    for i in range(m):
        W[COLUMNS + i, RIGHT] += FLOOR * most + 1e-300
    return positive


@njit(cache=True, nogil=True)
def balance_free(F: Any, W: Any, n: int, rank: int, S: Symbols) -> bool:
    """Return True when y proves that the cell holds no equilibrium. Needs ``centre_columns``.

    Guarantee (Gordan): y . w_i > 0 for every taut cable and y . w_0 > 0 at every point of the cell that
    satisfies the equations, so sum t_i w_i + w_0 = 0 has no solution with t >= 0 there. y may vary over the
    cell. It is tried constant first, then with slopes that make the forms' slopes vanish; right sides are
    proportional to the forms' radii of the try before.
    """
    if n == MOST_TAUT:
        return balance_free_of_six(F, W, rank, S)
    if not invert_gram(W, n + 1, RIDGE):
        return False
    choose_y(W, n + 1)
    if all_positive(F, W, n, n + 1, False, rank, S):
        return True
    for _ in range(2):
        choose_y(W, n + 1)
        choose_slopes(F, W, n, n + 1, S)
        if all_positive(F, W, n, n + 1, True, rank, S):
            return True
    return False


@njit(cache=True, nogil=True)
def balance_free_of_six(F: Any, W: Any, rank: int, S: Symbols) -> bool:
    """Six cables: seven forms in six unknowns; right sides r > 0 must satisfy lambda . r = 0.

    lambda is the kernel of the seven wrenches. Where its entries have one sign the centre has an
    equilibrium with positive tensions and no y exists.
    """
    n = MOST_TAUT
    for k in range(6):
        for i in range(n):
            W[k, i] = W[COLUMNS + i, k]
        W[k, n] = -W[COLUMNS + n, k]
    if not solve_in_place(W, 6, 1):
        return False
    for i in range(n):
        W[SOME_TENSION, i] = W[i, n]
    if not invert_gram(W, 6, 0.0):
        return False
    for _ in range(2):
        positive = W[COLUMNS + n, RIGHT]
        negative = 0.0
        for i in range(n):
            x = W[SOME_TENSION, i] * W[COLUMNS + i, RIGHT]
            if x > 0.0:
                positive += x
            else:
                negative -= x
        if not negative > 0.0:
            return False
        for i in range(n):
            if W[SOME_TENSION, i] > 0.0:
                W[COLUMNS + i, RIGHT] *= negative / positive
        choose_y(W, 6)
        if all_positive(F, W, n, n + 1, False, rank, S):
            return True
    return False


@njit(cache=True, nogil=True)
def limit_tensions(F: Any, W: Any, n: int, rank: int, S: Symbols) -> bool:
    """Bound the tensions of every equilibrium in the cell from above. Needs ``centre_columns``.

    Guarantee: where True is returned, every t >= 0 with sum t_i w_i + w_0 = 0 at a solution in the cell has
    t_i <= W[MOST_TENSION, i]: from y . w_i >= b_i > 0 and y . w_0 >= -c follows t_i b_i <= c.
    W[SOME_TENSION] gets approximate tensions at the centre.
    """
    for i in range(n):
        W[COLUMNS + i, RIGHT] = 1.0
    if not invert_gram(W, n, 0.0):
        return False
    for _ in range(2):
        choose_y(W, n)
        if all_positive(F, W, n, n, False, rank, S):
            break
    else:
        return False
    lo, _ = weigh(F, W, LOAD, False, rank, S)
    for i in range(n):
        W[MOST_TENSION, i] = up(max(-lo, 0.0) / W[MOST_TENSION, i])
        if not W[MOST_TENSION, i] < math.inf:
            return False
        s = 0.0
        for j in range(n):
            d = 0.0
            for k in range(6):
                d += W[COLUMNS + j, k] * F[LOAD + k, 0]
            s -= W[INVERSE + i, j] * d
        W[SOME_TENSION, i] = min(max(s / W[COLUMNS + i, NORM], 0.0), W[MOST_TENSION, i])
    return True


@njit(cache=True, nogil=True)
def complete_basis(W: Any, n: int) -> int:
    """Write an orthonormal basis of R^6 that starts with the columns' span; return its first free offset.

    Gram-Schmidt on the columns, then on the unit vectors, largest remainder first; 0 on failure.
    """
    count = 0
    for i in range(n):
        for k in range(6):
            W[BASIS + count, k] = W[COLUMNS + i, k]
        if orthogonalise(W, count):
            count += 1
    if count < n:
        return 0
    while count < 6:
        best, chosen = -1.0, 0
        for k in range(6):
            left = 1.0
            for j in range(count):
                left -= W[BASIS + j, k] ** 2
            if left > best:
                best, chosen = left, k
        for k in range(6):
            W[BASIS + count, k] = 1.0 if k == chosen else 0.0
        if not orthogonalise(W, count):
            return 0
        count += 1
    return n


@njit(cache=True, nogil=True)
def orthogonalise(W: Any, count: int) -> bool:
    """Make row BASIS + count (of norm 1) orthonormal to the rows before it; False when nothing is left."""
    row = BASIS + count
    for _ in range(2):
        for j in range(count):
            s = 0.0
            for k in range(6):
                s += W[row, k] * W[BASIS + j, k]
            for k in range(6):
                W[row, k] -= s * W[BASIS + j, k]
    left = 0.0
    for k in range(6):
        left += W[row, k] ** 2
    if not left > 1e-20:
        return False
    norm = math.sqrt(left)
    for k in range(6):
        W[row, k] /= norm
    return True


@njit(cache=True, nogil=True)
def statics_equations(F: Any, W: Any, n: int, first: int, rank: int, S: Symbols) -> int:
    """Write the 6 - n equations of statics that are free of tensions to first order; return how many.

    For y across the wrenches at the centre, with slopes that keep it so, y . w_0 + sum t_i y . w_i = 0
    at every equilibrium; y . w_i has no linear part, t_i lies in [0, MOST_TENSION]. Needs ``limit_tensions``.
    """
    start = complete_basis(W, n)
    if start == 0:
        return 0
    for j in range(6 - n):
        out = EQUATION + first + j
        for k in range(6):
            W[Y, k] = W[BASIS + start + j, k]
        choose_slopes(F, W, n, n, S)
        moving6(F, out, LOAD, W, Y, S)
        error = 0.0
        for i in range(n):
            lo, hi = weigh(F, W, wrench_of(i, n), True, rank, S)
            t = W[SOME_TENSION, i]
            spread = up(max(t, W[MOST_TENSION, i] - t))
            add_scaled(F, out, SCRATCH, t, S)
            error += spread * max(-lo, hi)
        widen(F, out, inflate(error, 0.0, 20.0), S)
        reduce_row(F, out, W, rank, S)
    return 6 - n


@njit(cache=True, nogil=True)
def tension_bounds(F: Any, W: Any, n: int, S: Symbols, lo: Any, hi: Any) -> bool:
    """Enclose every t with sum t_i w_i + w_0 = 0 at some point of the cell (t_i = tension / l_i).

    Verified least squares: with C an approximate left inverse of the wrench matrix at the centre and t~
    the approximate solution, any such t satisfies t - t~ = -C (w_0 + W t~) + (I - C W)(t - t~), so
    max|t - t~| <= max|C (w_0 + W t~)| / (1 - |I - C W|). False when |I - C W| < 1 cannot be proved: the
    tensions may then be unbounded or not unique.
    """
    if not (centre_columns(F, W, n) and invert_gram(W, n, 0.0)):
        return False
    for i in range(n):
        s = 0.0
        for k in range(6):
            left = 0.0
            for j in range(n):
                left += W[INVERSE + i, j] * W[COLUMNS + j, k]
            W[BASIS + i, k] = left / W[COLUMNS + i, NORM]
            s -= W[BASIS + i, k] * F[LOAD + k, 0]
        W[SOME_TENSION, i] = s
    worst = 0.0
    most = 0.0
    out = SCRATCH + 1
    for i in range(n):
        combine6(F, out, LOAD, W, BASIS + i, S)
        total = 0.0
        for j in range(n):
            combine6(F, SCRATCH, WRENCH + 6 * j, W, BASIS + i, S)
            add_scaled(F, out, SCRATCH, W[SOME_TENSION, j], S)
            if i == j:
                F[SCRATCH, 0] -= 1.0
                widen(F, SCRATCH, 1e-15, S)
            total += largest(F, SCRATCH, S)
        W[Y, i] = up(total * (1.0 + 1e-14))
        W[Y + 1, i] = largest(F, out, S)
        # Row by row, so that NaN (an overflow) cannot hide behind max.
        if not (W[Y, i] < 0.95 and W[Y + 1, i] < math.inf):
            return False
        worst = max(worst, W[Y, i])
        most = max(most, W[Y + 1, i])
    gain = up(most / down(1.0 - worst))
    for i in range(n):
        error = up(W[Y + 1, i] + up(W[Y, i] * gain))
        lo[i] = down(W[SOME_TENSION, i] - error)
        hi[i] = up(W[SOME_TENSION, i] + error)
    return True


@njit(cache=True, nogil=True)
def no_tensions(lo: Any, hi: Any) -> None:
    """Six lengths alone fix the pose: t is not an unknown then and stands as 0 in the roots."""
    for i in range(lo.shape[0]):
        lo[i] = 0.0
        hi[i] = 0.0
