"""The position on one of its two branches, enclosed over cells in u.

The three spheres of a triple leave two positions for a rotation, mirrored at the plane of their centres: the
sign of sigma = x . (d_2 x d_3) tells them apart. Over a small enough cell each branch is smooth in u.

Arrays: ``F`` (rows, columns of a form, LANES) forms, ``W`` (rows, columns, LANES) scratch, both with the
rows of ``engine.rows`` and ``mechanics.six_dof.rows``; ``S`` the forms' symbols; ``model`` is an
``arrays.Model``. ``third`` is the first row of the block of the triple's third equation.
"""

from __future__ import annotations

import math
from typing import Any

from numba import types

from cdpr_interval.engine.batch_cells import maximum
from cdpr_interval.engine.rows import SCRATCH
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray, Lanes, array3, lanes, load, root, splat, store, where_less
from cdpr_interval.kernels.rounding import down_lanes, inflate_lanes, up_lanes
from cdpr_interval.kernels.second_order import (
    Forms,
    Symbols,
    add_product,
    bounds,
    close,
    combine2,
    combine3,
    constant,
    dot3,
    largest,
    multiply,
    scale,
    signatures,
    widen,
)
from cdpr_interval.mechanics.six_dof.geometry import length_row, subtract_square, third_block
from cdpr_interval.mechanics.six_dof.rows import (
    CENTRE,
    ERROR_SYMBOL,
    FOOT,
    MOST_TAUT,
    NORMAL,
    OFFSET,
    POSITION,
    SECOND,
    SIGMA,
    TRIPLE,
    TRIPLE_INVERSE,
    U_SYMBOLS,
    UNIT_NORMAL,
)

INT = types.int64


@kernel(lanes(array3, array3, INT, lanes))
def centre_position(F: Forms, W: LaneArray, third: int, length_sq: Lanes) -> Lanes:
    """Write the foot of x at the cells' centres and the unit normal to W; return the height's square.

    NaN or infinite where the centres lie on one line.
    """
    a0, a1, a2 = load(F, SECOND + CENTRE, 0), load(F, SECOND + CENTRE + 1, 0), load(F, SECOND + CENTRE + 2, 0)
    b0, b1, b2 = load(F, third + CENTRE, 0), load(F, third + CENTRE + 1, 0), load(F, third + CENTRE + 2, 0)
    m0, m1, m2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    mm = m0 * m0 + m1 * m1 + m2 * m2
    k2, k3 = load(F, SECOND + OFFSET, 0) / mm, load(F, third + OFFSET, 0) / mm
    # x = (K_2 (d_3 x m) + K_3 (m x d_2)) / |m|^2
    x0 = k2 * (b1 * m2 - b2 * m1) + k3 * (m1 * a2 - m2 * a1)
    x1 = k2 * (b2 * m0 - b0 * m2) + k3 * (m2 * a0 - m0 * a2)
    x2 = k2 * (b0 * m1 - b1 * m0) + k3 * (m0 * a1 - m1 * a0)
    norm = root(mm)
    store(W, FOOT, 0, x0)
    store(W, FOOT, 1, x1)
    store(W, FOOT, 2, x2)
    store(W, UNIT_NORMAL, 0, m0 / norm)
    store(W, UNIT_NORMAL, 1, m1 / norm)
    store(W, UNIT_NORMAL, 2, m2 / norm)
    return length_sq - (x0 * x0 + x1 * x1 + x2 * x2)


@kernel(types.void(array3, array3, INT))
def invert_triple(F: Forms, W: LaneArray, third: int) -> None:
    """Write the inverse of the matrix with rows d_2, d_3, x (of the centre) to TRIPLE_INVERSE.."""
    for k in range(3):
        store(W, TRIPLE, k, load(F, SECOND + CENTRE + k, 0))
        store(W, TRIPLE + 1, k, load(F, third + CENTRE + k, 0))
        store(W, TRIPLE + 2, k, load(W, FOOT, k))
    determinant = splat(0.0)
    for column in range(3):
        # The inverse's columns are the cross products of the other two rows over the determinant.
        a, b = TRIPLE + (column + 1) % 3, TRIPLE + (column + 2) % 3
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            entry = load(W, a, i) * load(W, b, j) - load(W, a, j) * load(W, b, i)
            store(W, TRIPLE_INVERSE + k, column, entry)
            if column == 0:
                determinant += load(W, TRIPLE, k) * entry
    inverse = 1.0 / determinant
    for k in range(3):
        for column in range(3):
            store(W, TRIPLE_INVERSE + k, column, inverse * load(W, TRIPLE_INVERSE + k, column))


@kernel(types.void(array3, array3, INT, INT, INT, INT, types.float64))
def taylor_term(F: Forms, W: LaneArray, third: int, column: int, a: int, b: int, square: float) -> None:
    """Solve for x~ in ``column``; a, b are the columns of its two symbols, -1 for a linear term.

    ``square``: the slope of l_1^2 in that column.
    """
    r0 = load(F, SECOND + OFFSET, column)
    r1 = load(F, third + OFFSET, column)
    r2 = splat(0.5 * square)
    for k in range(3):
        x = POSITION + k
        d, e = SECOND + CENTRE + k, third + CENTRE + k
        r0 -= load(F, d, column) * load(F, x, 0)
        r1 -= load(F, e, column) * load(F, x, 0)
        if a >= 0:
            r0 -= load(F, d, a) * load(F, x, b)
            r1 -= load(F, e, a) * load(F, x, b)
            if a != b:
                r0 -= load(F, d, b) * load(F, x, a)
                r1 -= load(F, e, b) * load(F, x, a)
                r2 -= load(F, x, a) * load(F, x, b)
            else:
                r2 -= 0.5 * load(F, x, a) * load(F, x, a)
    for k in range(3):
        row = TRIPLE_INVERSE + k
        entry = load(W, row, 0) * r0 + load(W, row, 1) * r1 + load(W, row, 2) * r2
        store(F, POSITION + k, column, entry)


@kernel(signatures(types.void, array3, INT, INT, types.float64))
def approximate_position(F: Forms, W: LaneArray, third: int, pivot: int, spread: float, S: Symbols) -> None:
    """Write x~ to POSITION: the second-order Taylor polynomial of the branch through W[FOOT]; no error.

    ``spread`` : how far l_1^2 goes with the pivot's symbol of data, where there is one. The coefficients
    are not finite where the branch has none.
    """
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    invert_triple(F, W, third)
    for k in range(3):
        constant(F, POSITION + k, load(W, FOOT, k), splat(0.0), S)
    q = 1 + 2 * K
    for a in range(U_SYMBOLS):
        taylor_term(F, W, third, 1 + a, -1, -1, 0.0)
    for a in range(U_SYMBOLS):
        taylor_term(F, W, third, 1 + K + a, 1 + a, 1 + a, 0.0)
    # x depends on no other data than the lengths, which come first.
    for datum in range(min(P, MOST_TAUT)):
        taylor_term(F, W, third, Q + 3 + datum, -1, -1, spread if datum == pivot else 0.0)
    for a in range(K):
        for b in range(a + 1, K):
            if b < U_SYMBOLS:
                taylor_term(F, W, third, q, 1 + a, 1 + b, 0.0)
            q += 1
    for k in range(3):
        store(F, POSITION + k, Q, 0.0)
        close(F, POSITION + k, S)


@kernel(signatures(lanes, INT))
def residual(F: Forms, block: int, S: Symbols) -> Lanes:
    """Return an upper bound of |s K - s d . x~| over the cells."""
    length_row(F, SCRATCH, block, S)
    return largest(F, SCRATCH, S)


@kernel(signatures(lanes, INT))
def vector_largest(F: Forms, row: int, S: Symbols) -> Lanes:
    """Return an upper bound of the length of a vector in three rows."""
    total = splat(0.0)
    for k in range(3):
        most = largest(F, row + k, S)
        total += most * most
    return up_lanes(root(inflate_lanes(total, splat(0.0), 10.0)))


@kernel(signatures(lanes, array3, INT, INT, types.float64, types.float64, lanes))
def position_rows(
    F: Forms,
    W: LaneArray,
    third: int,
    pivot: int,
    square: float,
    square_err: float,
    branch: Lanes,
    S: Symbols,
) -> Lanes:
    """Enclose x over the cells on one branch (the sign of sigma) in the rows POSITION; 1 where that succeeds.

    ``square``, ``square_err`` : l_1^2; of the pivot's symbol of data, where there is one, its range.

    Guarantee: where 1 is returned, every x with branch * sigma >= 0 that satisfies the three equations of
    the triple at some u of the cell is enclosed at that u. Proof: x - x~ = delta + tau n with n the unit
    normal of d_2, d_3 and delta across it. The two plane equations give
    |delta| <= (rho_2 |d_3| + rho_3 |d_2|) / |d_2 x d_3| with rho their residuals at x~. The sphere gives
    tau^2 + 2 tau h + c = 0 with h = n . x~ and |c| <= rho_1 + 2 |x~| |delta| + |delta|^2. Where h has the
    branch's sign, the root on the branch has |tau| = |c| / (|h| + sqrt(h^2 - c)), which is at most |c| / |h|
    and at most sqrt|c| (it is real only where c <= h^2). tau rides on ERROR_SYMBOL along the centre's normal.
    """
    zero = splat(0.0)
    approximate_position(F, W, third, pivot, square_err, S)
    rho2, rho3 = residual(F, SECOND, S), residual(F, third, S)
    dot3(F, SCRATCH, POSITION, POSITION, S)
    subtract_square(F, SCRATCH, pivot, square, square_err, S)
    rho1 = largest(F, SCRATCH, S)
    normal = load(W, UNIT_NORMAL, 0), load(W, UNIT_NORMAL, 1), load(W, UNIT_NORMAL, 2)
    # |m| from below: m . n, with |n| <= 1 up to rounding.
    combine3(F, SCRATCH, NORMAL, normal[0], normal[1], normal[2], zero, S)
    least, most = bounds(F, SCRATCH, S)
    least = down_lanes(least * (1.0 - 1e-14))
    proved = where_less(0.0, least, splat(1.0), 0.0)
    # tan of the angle between m and n.
    tilt = splat(0.0)
    for k in range(3):
        e0, e1, e2 = (1.0 if k == 0 else 0.0), (1.0 if k == 1 else 0.0), (1.0 if k == 2 else 0.0)
        w = normal[k]
        combine3(F, SCRATCH, NORMAL, e0 - w * normal[0], e1 - w * normal[1], e2 - w * normal[2], zero, S)
        off = largest(F, SCRATCH, S)
        tilt += off * off
    # 1e-14: the rounded matrix I - n n^T is off by some units, relative to |m|.
    tilt = up_lanes(up_lanes(root(tilt) * (1.0 + 1e-14)) / least) + 1e-14
    most = up_lanes(most * up_lanes(root(up_lanes(1.0 + up_lanes(tilt * tilt))))) * (1.0 + 1e-14)
    longest = vector_largest(F, NORMAL, S)
    most = where_less(most, longest, most, longest)
    across = rho2 * vector_largest(F, third + CENTRE, S) + rho3 * vector_largest(F, SECOND + CENTRE, S)
    delta = up_lanes(inflate_lanes(across, zero, 4.0) / least)
    dot3(F, SIGMA, POSITION, NORMAL, S)
    lo, hi = bounds(F, SIGMA, S)
    height = down_lanes(where_less(0.0, branch, lo, -hi) / most)
    proved = where_less(0.0, height, proved, 0.0)
    reach = up_lanes(root(up_lanes(up_lanes(splat(square + square_err)) + rho1)))
    c = inflate_lanes(rho1 + delta * (2.0 * reach + delta), zero, 6.0)
    first, second = up_lanes(c / height), up_lanes(root(c))
    tau = where_less(first, second, first, second)
    proved = where_less(tau, math.inf, proved, 0.0)
    error = up_lanes(delta + up_lanes(tau * tilt))
    proved = where_less(error, math.inf, proved, 0.0)
    for k in range(3):
        slope = tau * normal[k]
        store(F, POSITION + k, 1 + ERROR_SYMBOL, slope)
        widen(F, POSITION + k, inflate_lanes(error, abs(slope), 4.0), S)
        close(F, POSITION + k, S)
    return proved


@kernel(signatures(lanes, INT, types.float64, types.float64))
def no_position(F: Forms, third: int, square: float, square_err: float, S: Symbols) -> Lanes:
    """Return 1 where the three spheres of the triple have no common point over the cell, else 0.

    sigma^2 = l_1^2 |m|^2 - |K_2 d_3 - K_3 d_2|^2 < 0 (with factors s^4).
    """
    v = SCRATCH + 4
    zero = splat(0.0)
    for k in range(3):
        multiply(F, v + k, SECOND + OFFSET, third + CENTRE + k, 1.0, S)
        add_product(F, v + k, third + OFFSET, SECOND + CENTRE + k, -1.0, S)
    dot3(F, SCRATCH, NORMAL, NORMAL, S)
    most = largest(F, SCRATCH, S)
    scale(F, SCRATCH, SCRATCH, splat(square), S)
    widen(F, SCRATCH, inflate_lanes(most * square_err, zero, 4.0), S)
    dot3(F, SCRATCH + 1, v, v, S)
    combine2(F, SCRATCH, SCRATCH, splat(1.0), SCRATCH + 1, splat(-1.0), S)
    _, above = bounds(F, SCRATCH, S)
    return where_less(above, 0.0, splat(1.0), 0.0)


@kernel()
def on_branch(F: Forms, W: LaneArray, model: Any, branch: Lanes, S: Symbols) -> Lanes:
    """Write x of one branch; 1 where it is a smooth function over the cell, else 0."""
    pivot = model.orders[0, 0]
    third = third_block(model)
    square, square_err = model.lengths_sq[pivot], model.lengths_sq_err[pivot]
    height_sq = centre_position(F, W, third, splat(square))
    h = root(maximum(height_sq, splat(0.0))) * branch
    for k in range(3):
        store(W, FOOT, k, load(W, FOOT, k) + h * load(W, UNIT_NORMAL, k))
    proved = position_rows(F, W, third, pivot, square, square_err, branch, S)
    return where_less(0.0, height_sq, proved, 0.0)
