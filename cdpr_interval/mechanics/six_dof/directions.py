"""Directions y in R^6 at the centres of cells: the dual basis of the wrenches, and a basis across them.

All of it is plain floating point; whatever y is, the forms y . w over the cell decide what it proves. The
wrenches are orthogonalised (Gram-Schmidt, twice), not squared into a Gram matrix: between two poses near a
fold, at a distance d, the load comes within d^2 of the wrenches' span, and y is as large as 1 / d^2.

Arrays: ``F`` (rows, columns of a form, LANES) forms, ``W`` (rows, columns, LANES) scratch, both with the
rows of ``rows``; ``S`` the forms' symbols.
"""

from __future__ import annotations

from numba import types

from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray, array3, load, root, splat, store, where_less
from cdpr_interval.kernels.second_order import Forms, Symbols, signatures, slope_column
from cdpr_interval.mechanics.six_dof.rows import (
    BASIS,
    COLUMNS,
    DIMENSIONS,
    DUAL,
    INVERSE,
    LOAD,
    NORM,
    RIGHT,
    SOME_TENSION,
    STEP,
    WRENCH,
    Y,
)

INT = types.int64

DEPENDENT = 1e-13
"""Remainder of a normalised column, after those before it, below which it counts as dependent on them: its
direction is rounding."""


@kernel()
def wrench_of(i: int, n: int) -> int:
    """Return the first row of wrench i; i = n is the load."""
    return LOAD if i == n else WRENCH + DIMENSIONS * i


@kernel(types.void(array3, array3, INT))
def centre_columns(F: Forms, W: LaneArray, n: int) -> None:
    """Write the normalised wrenches of the centre, their norms, and right sides 1.

    Where a wrench vanishes the columns are NaN, and nothing can be proved with them.
    """
    for i in range(n + 1):
        row = wrench_of(i, n)
        total = splat(0.0)
        for k in range(6):
            x = load(F, row + k, 0)
            total += x * x
        norm = root(total)
        store(W, COLUMNS + i, NORM, norm)
        store(W, COLUMNS + i, RIGHT, 1.0)
        for k in range(6):
            store(W, COLUMNS + i, k, load(F, row + k, 0) / norm)


@kernel(types.void(array3, INT, INT))
def strip(W: LaneArray, row: int, count: int) -> None:
    """Take the parts along the first ``count`` basis vectors out of row BASIS + ``row``, noting them."""
    for i in range(count):
        s = splat(0.0)
        for k in range(6):
            s += load(W, BASIS + row, k) * load(W, BASIS + i, k)
        for k in range(6):
            store(W, BASIS + row, k, load(W, BASIS + row, k) - s * load(W, BASIS + i, k))
        store(W, DUAL + row, STEP + i, load(W, DUAL + row, STEP + i) + s)


@kernel(types.void(array3, INT))
def normalise(W: LaneArray, row: int) -> None:
    """Make row BASIS + ``row`` a unit vector, zero where it is a rounding error (and NaN where it is NaN)."""
    left = splat(0.0)
    for k in range(6):
        left += load(W, BASIS + row, k) * load(W, BASIS + row, k)
    norm = root(left)
    inverse = where_less(DEPENDENT, norm, 1.0 / norm, 0.0)
    store(W, DUAL + row, INVERSE, inverse)
    for k in range(6):
        store(W, BASIS + row, k, load(W, BASIS + row, k) * inverse)


@kernel(types.void(array3, INT))
def dual_columns(W: LaneArray, m: int) -> None:
    """Write the dual basis of the first m columns to W[DUAL..]: p_i . column_j = 1 for i = j, else 0.

    It lies in their span, and W[BASIS..] gets an orthonormal basis of that. A column that depends on
    those before it has p = 0: y ignores its right side. NaN where a column is.
    """
    for j in range(m):
        for k in range(6):
            store(W, BASIS + j, k, load(W, COLUMNS + j, k))
        for i in range(j):
            store(W, DUAL + j, STEP + i, 0.0)
        # Twice is enough (Kahan; Parlett, The Symmetric Eigenvalue Problem, 6.9).
        strip(W, j, j)
        strip(W, j, j)
        normalise(W, j)
    for last in range(m):
        i = m - 1 - last
        for k in range(6):
            s = load(W, BASIS + i, k)
            for j in range(i + 1, m):
                s -= load(W, DUAL + j, STEP + i) * load(W, DUAL + j, k)
            store(W, DUAL + i, k, s * load(W, DUAL + i, INVERSE))


@kernel(types.void(array3, INT))
def complete_basis(W: LaneArray, n: int) -> None:
    """Complete the first n rows BASIS.., of ``dual_columns``, to an orthonormal basis of R^6.

    Gram-Schmidt on the unit vectors, largest remainder first.
    """
    for count in range(n, 6):
        best, chosen = splat(-1.0), splat(0.0)
        for k in range(6):
            left = splat(1.0)
            for j in range(count):
                left -= load(W, BASIS + j, k) * load(W, BASIS + j, k)
            chosen = where_less(best, left, float(k), chosen)
            best = where_less(best, left, left, best)
        for k in range(6):
            store(W, BASIS + count, k, where_less(abs(chosen - float(k)), 0.5, 1.0, 0.0))
        strip(W, count, count)
        strip(W, count, count)
        normalise(W, count)


@kernel(types.void(array3, INT))
def choose_y(W: LaneArray, m: int) -> None:
    """Write the least-norm y with y . column_i = right side i, i < m."""
    for k in range(6):
        s = splat(0.0)
        for i in range(m):
            s += load(W, COLUMNS + i, RIGHT) * load(W, DUAL + i, k)
        store(W, Y, k, s)


@kernel(signatures(types.void, array3, INT, INT))
def choose_slopes(F: Forms, W: LaneArray, n: int, m: int, S: Symbols) -> None:
    """Write slopes of y that cancel the slopes of y . w_i, i < m (i = n is the load)."""
    for symbol in range(len(S.noise) + len(S.data)):
        slope, column = Y + 1 + symbol, slope_column(symbol, S)
        for k in range(6):
            store(W, slope, k, 0.0)
        for i in range(m):
            row = wrench_of(i, n)
            s = splat(0.0)
            for k in range(6):
                s -= load(W, Y, k) * load(F, row + k, column)
            s = s / load(W, COLUMNS + i, NORM)
            for k in range(6):
                store(W, slope, k, load(W, slope, k) + s * load(W, DUAL + i, k))


@kernel(types.void(array3, INT))
def tensions_of_load(W: LaneArray, n: int) -> None:
    """Write the tensions of normalised wrenches to W[SOME_TENSION], from the duals of wrenches and load.

    Those duals are across the load, but its coordinates are known.
    """
    for last in range(n):
        i = n - 1 - last
        s = -load(W, DUAL + n, STEP + i)
        for j in range(i + 1, n):
            s -= load(W, DUAL + j, STEP + i) * load(W, SOME_TENSION, j)
        store(W, SOME_TENSION, i, s * load(W, DUAL + i, INVERSE))


@kernel(types.void(array3, INT, types.boolean))
def centre_tensions(W: LaneArray, n: int, true_scale: bool) -> None:
    """Write the centre's tensions t of least error to W[SOME_TENSION], from the duals of the n wrenches.

    Without ``true_scale`` those of the normalised wrenches.
    """
    for i in range(n):
        s = splat(0.0)
        for k in range(6):
            s -= load(W, DUAL + i, k) * load(W, COLUMNS + n, k)
        if true_scale:
            s = s * (load(W, COLUMNS + n, NORM) / load(W, COLUMNS + i, NORM))
        store(W, SOME_TENSION, i, s)
