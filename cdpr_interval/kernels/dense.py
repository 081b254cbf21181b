"""Small dense linear algebra in plain floating point: results are approximations, proved elsewhere."""

from __future__ import annotations

from typing import Any

from numba import types

from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import LaneArray, array3, load, store


@entry("b1(f8[:, ::1], i8, i8)")
def solve_in_place(a: Any, n: int, columns: int) -> bool:
    """Solve a small linear system by Gaussian elimination with partial pivoting.

    Parameters
    ----------
    a : (>= n, >= n + columns)
        The matrix, with the right-hand sides in columns ``n .. n + columns - 1``; overwritten,
        the solutions end up in those columns.

    Returns
    -------
    bool
        False when a pivot is zero or not finite (contents are then meaningless).
    """
    width = n + columns
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[p, k]):
                p = i
        pivot = a[p, k]
        if not 0.0 < abs(pivot) < 1e300:
            return False
        if p != k:
            for j in range(k, width):
                a[k, j], a[p, j] = a[p, j], a[k, j]
        for i in range(k + 1, n):
            f = a[i, k] / pivot
            if f != 0.0:
                for j in range(k + 1, width):
                    a[i, j] -= f * a[k, j]
    for k in range(n - 1, -1, -1):
        for c in range(n, width):
            s = a[k, c]
            for j in range(k + 1, n):
                s -= a[k, j] * a[j, c]
            a[k, c] = s / a[k, k]
    return True


@kernel(types.void(array3, types.int64, types.int64, types.int64))
def solve_definite(a: LaneArray, first: int, n: int, columns: int) -> None:
    """Solve a small positive definite system in every lane, by Gauss-Jordan elimination without pivoting.

    Parameters
    ----------
    a : (>= first + n, >= n + columns, LANES)
        The matrix in the n rows from ``first``, with the right-hand sides in columns
        ``n .. n + columns - 1``; overwritten, the solutions end up in those columns: infinite or NaN where
        the matrix is singular.
    """
    width = n + columns
    for k in range(n):
        row = first + k
        inverse = 1.0 / load(a, row, k)
        for j in range(k + 1, width):
            store(a, row, j, inverse * load(a, row, j))
        for i in range(first, first + n):
            if i != row:
                f = load(a, i, k)
                for j in range(k + 1, width):
                    store(a, i, j, load(a, i, j) - f * load(a, row, j))
