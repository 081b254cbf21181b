"""Forms that vanish at every solution of a cell: solved for symbols, added to others, used to shrink it.

The rows EQUATION.. hold such forms (lengths of taut cables, statics). Solved by Gauss-Jordan for as many
symbols as they fix (the rows PIVOT..), they can be added to any other form in any multiple without
changing its value at a solution: that takes the fixed symbols out of it, as if the position had been
eliminated, and needs no proof but the sum itself.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.rounding import down, inflate, up
from cdpr_interval.kernels.second_order import Symbols, add_scaled, bounds, constant, scale, widen
from solvers.platform_polynomials import EQUATION, PIVOT, SCRATCH, middle_and_radius

EMPTY, STUCK, SMALLER = 0, 1, 2
"""What a contraction did to a cell; SMALLER means it is worth another look before bisecting."""
WORTH = 0.6
"""A contraction counts as SMALLER when one variable keeps at most this share of its width."""
LEAST_PIVOT = 1e-3
"""Least pivot, relative to its row, that is taken: a smaller one would only spread noise."""
PIVOTS = 30
"""Row of W that holds the symbol of each pivot."""
TABLEAU = 31
"""First of six rows of W for the Gauss-Jordan elimination: symbols, then multipliers of the equations."""
WEIGHTS = 37
"""Row of W that holds the weights of the equations in a contraction."""


@njit(cache=True, nogil=True)
def noise(F: Any, i: int, S: Symbols) -> float:
    """Return quadratic part + error of a row (rounded to nearest)."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    return float(F[i, Q] + F[i, Q + 2])


@njit(cache=True, nogil=True)
def steepest(F: Any, i: int, S: Symbols) -> float:
    """Return the largest slope of a row."""
    most = 0.0
    for k in range(len(S)):
        most = max(most, abs(F[i, 1 + k]))
    return most


@njit(cache=True, nogil=True)
def solve_for_pivots(F: Any, W: Any, first: int, count: int, variables: int, S: Symbols) -> int:
    """Solve up to six rows EQUATION + first.. for symbols below ``variables``; return how many were solved.

    Writes the solved rows to PIVOT.. (slope 1 in their own pivot, about 0 in the others') and the
    pivots to W[PIVOTS]. Rows whose noise drowns their slopes are left out.
    """
    K = len(S)
    for e in range(count):
        row = EQUATION + first + e
        most = steepest(F, row, S)
        usable = 1e-100 < most < 1e100 and noise(F, row, S) < most
        for k in range(K):
            W[TABLEAU + e, k] = F[row, 1 + k] / most if usable else 0.0
        for j in range(count):
            W[TABLEAU + e, K + j] = 1.0 / most if usable and j == e else 0.0
    rank = 0
    while rank < count:
        best, line, column = LEAST_PIVOT, -1, -1
        for e in range(rank, count):
            for k in range(variables):
                if abs(W[TABLEAU + e, k]) > best and not is_pivot(W, k, rank):
                    best, line, column = abs(W[TABLEAU + e, k]), e, k
        if line < 0:
            break
        eliminate(W, rank, line, column, count, K + count)
        W[PIVOTS, rank] = column
        rank += 1
    for s in range(rank):
        constant(F, PIVOT + s, 0.0, 0.0, S)
        for j in range(count):
            if W[TABLEAU + s, K + j] != 0.0:
                add_scaled(F, PIVOT + s, EQUATION + first + j, W[TABLEAU + s, K + j], S)
    return rank


@njit(cache=True, nogil=True)
def is_pivot(W: Any, symbol: int, rank: int) -> bool:
    """Return True when a symbol is one of the first ``rank`` pivots."""
    found = False
    for s in range(rank):
        found = found or int(W[PIVOTS, s]) == symbol
    return found


@njit(cache=True, nogil=True)
def eliminate(W: Any, target: int, line: int, column: int, lines: int, columns: int) -> None:
    """Bring line ``line`` of the tableau to place ``target`` and clear ``column`` in all others."""
    for k in range(columns):
        a, b = W[TABLEAU + target, k], W[TABLEAU + line, k]
        W[TABLEAU + target, k], W[TABLEAU + line, k] = b, a
    pivot = W[TABLEAU + target, column]
    for k in range(columns):
        W[TABLEAU + target, k] /= pivot
    for e in range(lines):
        factor = W[TABLEAU + e, column]
        if e != target and factor != 0.0:
            for k in range(columns):
                W[TABLEAU + e, k] -= factor * W[TABLEAU + target, k]


@njit(cache=True, nogil=True)
def reduce_row(F: Any, out: int, W: Any, rank: int, S: Symbols) -> None:
    """Add multiples of the solved rows to ``out`` so that the pivots' slopes vanish."""
    for s in range(rank):
        slope = F[out, 1 + int(W[PIVOTS, s])]
        if slope != 0.0:
            add_scaled(F, out, PIVOT + s, -slope, S)


@njit(cache=True, nogil=True)
def cut_pivots(F: Any, W: Any, cell: Any, rank: int, S: Symbols) -> int:
    """Shrink each pivot's variable to what its solved row allows; EMPTY, STUCK or SMALLER."""
    verdict = STUCK
    for s in range(rank):
        k = int(W[PIVOTS, s])
        if not cell[2 * k] < cell[2 * k + 1]:
            continue
        # eps_k = -(row - eps_k); the slope less 1 is tiny, its rounding is covered by one unit of 1.
        scale(F, SCRATCH, PIVOT + s, 1.0, S)
        F[SCRATCH, 1 + k] -= 1.0
        widen(F, SCRATCH, 1e-15, S)
        lo, hi = bounds(F, SCRATCH, S)
        low, high = -hi, -lo
        if low > 1.0 or high < -1.0:
            return EMPTY
        if (low > -1.0 or high < 1.0) and cut(cell, 2 * k, max(low, -1.0), min(high, 1.0)):
            verdict = SMALLER
    return verdict


@njit(cache=True, nogil=True)
def contract(F: Any, W: Any, cell: Any, count: int, variables: int, S: Symbols) -> int:
    """Shrink the cell by all rows EQUATION.. at once (interval Newton); EMPTY, STUCK or SMALLER.

    Symbol k < ``variables`` stands for the variable with bounds cell[2 k], cell[2 k + 1]. With g the rows'
    centres, A their slopes, N their remaining terms and C a float left inverse of A,
    eps = -C g - (C A - I) eps - C N bounds every symbol.
    """
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    for k in range(variables):
        for m in range(variables):
            W[k, m] = 0.0
    for e in range(count):
        row = EQUATION + e
        most = steepest(F, row, S)
        # An equation whose noise drowns its slopes (0 = 0 on a symmetry) would only add noise.
        useful = 1e-100 < most < 1e100 and noise(F, row, S) < most
        W[WEIGHTS, e] = 1.0 / (most * most) if useful else 0.0
        for k in range(variables):
            for m in range(variables):
                W[k, m] += F[row, 1 + k] * F[row, 1 + m] * W[WEIGHTS, e]
    for k in range(variables):
        if not cell[2 * k] < cell[2 * k + 1]:
            W[k, k] += 1.0
        for e in range(count):
            W[k, variables + e] = F[EQUATION + e, 1 + k] * W[WEIGHTS, e]
    if not solve_in_place(W, variables, count):
        return STUCK
    verdict = STUCK
    for k in range(variables):
        if not cell[2 * k] < cell[2 * k + 1]:
            continue
        # The row sum_e C_ke EQUATION_e - eps_k, whose negative is eps_k.
        constant(F, SCRATCH, 0.0, 0.0, S)
        for e in range(count):
            c = W[k, variables + e]
            if c != 0.0:
                add_scaled(F, SCRATCH, EQUATION + e, c, S)
        slope = F[SCRATCH, 1 + k]
        F[SCRATCH, 1 + k] = slope - 1.0
        widen(F, SCRATCH, inflate(0.0, abs(slope) + 1.0, 4.0), S)
        F[SCRATCH, Q + 1] = up(F[SCRATCH, Q + 1] + 1.0)
        lo, hi = bounds(F, SCRATCH, S)
        low, high = -hi, -lo
        if low > 1.0 or high < -1.0:
            return EMPTY
        if (low > -1.0 or high < 1.0) and cut(cell, 2 * k, max(low, -1.0), min(high, 1.0)):
            verdict = SMALLER
    return verdict


@njit(cache=True, nogil=True)
def cut(cell: Any, j: int, low: float, high: float) -> bool:
    """Cut the variable with bounds cell[j], cell[j + 1] to symbols in [low, high]; True if much is gone."""
    lo, hi = cell[j], cell[j + 1]
    m, half = middle_and_radius(lo, hi)
    cell[j] = max(lo, down(m + down(half * low)))
    cell[j + 1] = min(hi, up(m + up(half * high)))
    if cell[j] > cell[j + 1]:
        # Only by rounding at a corner, where no solution is: one point keeps the cell well formed.
        cell[j + 1] = cell[j]
    return shrunk(cell[j + 1] - cell[j], hi - lo)


@njit(cache=True, nogil=True)
def shrunk(now: float, before: float) -> bool:
    """Return True when a width is worth another look: really smaller, also among denormals."""
    return bool(now < before and now <= WORTH * before)
