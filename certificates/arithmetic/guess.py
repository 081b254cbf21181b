"""Small linear algebra in plain doubles, in many cells at once: guesses, untrusted.

Whatever they are, nothing false can be proved: everything here is tried by those who ask for it, and a wrong
guess, or NaN, makes a proof fail. The last axis of every array counts the cells.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Array = Any
RIDGE = 1e-12
"""Added to the diagonal of normal equations, relative to unit rows: they may be dependent."""


def solve(matrix: Array, right: Array) -> Array:
    """Return X with matrix X = right by elimination with pivoting; NaN where that fails."""
    a, n, cells = np.concatenate([matrix, right], axis=1), len(matrix), np.arange(matrix.shape[-1])
    for k in range(n):
        pivot = k + np.argmax(abs(a[k:, k]), axis=0)
        row = a[pivot, :, cells].T
        a[pivot, :, cells] = a[k].T
        size = abs(row[k])
        a[k] = row / np.where((size > 1e-280) & (size < 1e280), row[k], np.nan)
        factors = a[:, k].copy()
        factors[k] = 0.0
        a[:, k:] -= factors[:, None] * a[None, k, k:]
    return a[:, n:]


def inverse(matrix: Array) -> Array:
    """Return an approximate inverse; NaN where that fails."""
    unit = np.broadcast_to(np.eye(len(matrix))[:, :, None], matrix.shape)
    return solve(matrix, unit)


def products(a: Array, b: Array) -> Array:
    """Return the scalar products of the rows of two arrays (n, k, N), (m, k, N): (n, m, N)."""
    return np.einsum("ikc,jkc->ijc", a, b)


def gram(rows: Array, active: Array) -> Array:
    """Return the scalar products of the active rows, slightly raised on the diagonal; others are units."""
    both = active[:, None] & active[None, :]
    raised = (1.0 + RIDGE * np.eye(len(rows)))[:, :, None] * products(rows, rows)
    return np.where(both, raised, np.eye(len(rows))[:, :, None])


def least_norm(rows: Array, rights: Array, active: Array) -> Array:
    """Return for each column of right sides the shortest y with row . y = right for all active rows.

    rows : (n, k, N); rights : (n, m, N); active : (n, N). Returns (k, m, N).
    """
    weights = solve(gram(rows, active), np.where(active[:, None], rights, 0.0))
    return np.einsum("ikc,imc->kmc", rows, weights)


def direction(rows: Array, wanted: Array) -> tuple[Array, Array]:
    """Return a short y (k, N) with row . y at least as wanted, and the rows where it is just that.

    The shortest such y has no negative multipliers: rows with negative ones are dropped, the worst first.
    NaN where none is found.
    """
    active = np.ones(wanted.shape, dtype=bool)
    cells = np.arange(wanted.shape[-1])
    for _ in range(len(rows)):
        weights = solve(gram(rows, active), np.where(active, wanted, 0.0)[:, None])[:, 0]
        weights = np.where(active, weights, np.inf)
        worst = np.argmin(weights, axis=0)
        bad = weights[worst, cells] < 0.0
        if not bad.any():
            break
        active[worst[bad], cells[bad]] = False
    found = np.einsum("ikc,ic->kc", rows, np.where(active, weights, 0.0))
    return np.where(active.any(axis=0), found, np.nan), active


def cross(a: Array, b: Array) -> Array:
    """Return the vector product."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def pivots(rows: Array) -> Array:
    """Return the columns (n, N) that elimination of rows (n, k, N) with complete pivoting chooses.

    -1 where the rows are dependent.
    """
    left, (n, k, count) = rows.copy(), rows.shape
    cells, found = np.arange(count), np.full((n, count), -1)
    for step in range(n):
        sizes = abs(left).reshape(n * k, count)
        best = np.argmax(np.where(np.isnan(sizes), -1.0, sizes), axis=0)
        row, column = best // k, best % k
        pivot = left[row, column, cells]
        found[step] = np.where(abs(pivot) > 0.0, column, -1)
        chosen = left[row, :, cells].T
        left -= (left[:, column, cells] / pivot)[:, None] * chosen[None]
        # A row is chosen once.
        left[row, :, cells] = 0.0
        left = np.where(np.isfinite(left), left, 0.0)
    return found


def usable(guesses: Array) -> Array:
    """Return guesses, 0 where there are none."""
    return np.where(np.isfinite(guesses), guesses, 0.0)
