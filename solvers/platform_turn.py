"""Cells in u alone: three search variables, the position being one of two branches over the cell.

The three spheres of a triple leave two positions for a rotation, mirrored at the plane of their centres: the
sign of sigma = x . (d_2 x d_3) tells them apart. Over a small enough cell each branch x(u) is a smooth
function; ``position_rows`` encloses it by a second-order form. Where the branches meet (a fold), where the
centres come close to one line, or where the position turns too fast, the cell is handed on to the
search in (u, x) of ``platform_pose``, which needs no branch.

A cell is a row ``u (3 x lo, hi), chart, branch, share``; branch 0 stands for both. Kernels look at LANES
cells at once: ``C`` (1, width, LANES).
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit, types

from cdpr_interval.engine.batches import batches
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import (
    LANES,
    LaneArray,
    Lanes,
    array3,
    lanes,
    load,
    root,
    splat,
    store,
    where_less,
)
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
    cross3,
    dot3,
    largest,
    multiply,
    scale,
    signatures,
    widen,
)
from solvers.platform_elimination import EMPTY, SMALLER, STUCK, VERDICTS, blank, contract, solve_for_pivots
from solvers.platform_polynomials import (
    BLOCK,
    CABLE,
    CENTRE,
    EQUATION,
    MOST_TAUT,
    NORMAL,
    OFFSET,
    POSITION,
    ROOT_ARM,
    SCALE,
    SCRATCH,
    SIGMA,
    SLACK_CABLE,
    U_SYMBOLS,
    WRENCH,
    cable_rows,
    length_row,
    rotation_rows,
    third_block,
    triple_rows,
    wrench_rows,
)
from solvers.platform_statics import (
    balance_free,
    centre_columns,
    covers,
    limit_tensions,
    maximum,
    statics_equations,
    tension_bounds,
)

CHART, BRANCH, SHARE = 6, 7, 8
WIDTH = 9
SMALL = 1
"""Leaf kind: the cell is smaller than the leaf size."""
FOLDED = 2
"""Leaf kind: the position is not two smooth functions of u over the cell; to be searched in (u, x)."""
FOLD_WIDTH = 0.13
"""Width of u at which a cell without smooth branches is handed on; measured against 0.07 and 0.26."""
NEWTON_WIDTH = 0.3
"""Width of u below which a cell that is not excluded is contracted before it is bisected."""
SECOND = CABLE + BLOCK
"""Block of the second cable of the triple."""
SPOT = 6
"""Row of W with x at the centre (0..2), the unit normal of the centres' plane (3..5)."""
ERROR_SYMBOL = 3
"""The symbol that carries the error of x along the normal."""
BOUNDS = 49
"""Two rows of W with bounds: of p (places 0..2), then of t in the cell's order (from 0)."""
TENSIONS = 51
"""Two rows of W with bounds of t."""
FLAGS = 53
"""Row of W whose last places pass what was proved lane by lane."""

OPEN = STUCK
"""State of a lane about which nothing is known yet; others are EMPTY and SMALLER (its own child)."""
UNSMOOTH = 3
"""State of a lane whose position is not a smooth function over the cell."""
BOTH = 4
"""State of a lane that stands for two branches."""
WIDE = 5
"""State of a lane too wide to be contracted."""

INT = types.int64


@kernel(lanes(array3, array3, INT, lanes))
def centre_position(F: Forms, W: LaneArray, third: int, length_sq: Lanes) -> Lanes:
    """Write the foot of x at the cells' centres and the unit normal to W[SPOT]; return the height's square.

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
    store(W, SPOT, 0, x0)
    store(W, SPOT, 1, x1)
    store(W, SPOT, 2, x2)
    store(W, SPOT, 3, m0 / norm)
    store(W, SPOT, 4, m1 / norm)
    store(W, SPOT, 5, m2 / norm)
    return length_sq - (x0 * x0 + x1 * x1 + x2 * x2)


@kernel(types.void(array3, array3, INT))
def invert_triple(F: Forms, W: LaneArray, third: int) -> None:
    """Write the inverse of the matrix with rows d_2, d_3, x (of the centre) to W[0..2], places 3..5."""
    for k in range(3):
        store(W, 0, k, load(F, SECOND + CENTRE + k, 0))
        store(W, 1, k, load(F, third + CENTRE + k, 0))
        store(W, 2, k, load(W, SPOT, k))
    determinant = splat(0.0)
    for column in range(3):
        # The inverse's columns are the cross products of the other two rows over the determinant.
        a, b = (column + 1) % 3, (column + 2) % 3
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            entry = load(W, a, i) * load(W, b, j) - load(W, a, j) * load(W, b, i)
            store(W, k, 3 + column, entry)
            if column == 0:
                determinant += load(W, 0, k) * entry
    inverse = 1.0 / determinant
    for k in range(3):
        for column in range(3):
            store(W, k, 3 + column, inverse * load(W, k, 3 + column))


@kernel(types.void(array3, array3, INT, INT, INT, INT))
def taylor_term(F: Forms, W: LaneArray, third: int, column: int, a: int, b: int) -> None:
    """Solve for x~ in ``column``; a, b are the columns of its two symbols, -1 for a linear term."""
    r0 = load(F, SECOND + OFFSET, column)
    r1 = load(F, third + OFFSET, column)
    r2 = splat(0.0)
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
        store(F, POSITION + k, column, load(W, k, 3) * r0 + load(W, k, 4) * r1 + load(W, k, 5) * r2)


@kernel(signatures(types.void, array3, INT))
def approximate_position(F: Forms, W: LaneArray, third: int, S: Symbols) -> None:
    """Write x~ to POSITION: the second-order Taylor polynomial of the branch through W[SPOT]; no error.

    Its coefficients are not finite where the branch has none.
    """
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    invert_triple(F, W, third)
    for k in range(3):
        constant(F, POSITION + k, load(W, SPOT, k), splat(0.0), S)
    q = 1 + 2 * K
    for a in range(U_SYMBOLS):
        taylor_term(F, W, third, 1 + a, -1, -1)
    for a in range(U_SYMBOLS):
        taylor_term(F, W, third, 1 + K + a, 1 + a, 1 + a)
    for a in range(K):
        for b in range(a + 1, K):
            if b < U_SYMBOLS:
                taylor_term(F, W, third, q, 1 + a, 1 + b)
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


@kernel(signatures(lanes, array3, INT, types.float64, types.float64, lanes))
def position_rows(
    F: Forms, W: LaneArray, third: int, square: float, square_err: float, branch: Lanes, S: Symbols
) -> Lanes:
    """Enclose x over the cells on one branch (the sign of sigma) in the rows POSITION; 1 where that succeeds.

    ``square``, ``square_err`` : l_1^2.

    Guarantee: where 1 is returned, every x with branch * sigma >= 0 that satisfies the three equations of
    the triple at some u of the cell is enclosed at that u. Proof: x - x~ = delta + tau n with n the unit
    normal of d_2, d_3 and delta across it. The two plane equations give
    |delta| <= (rho_2 |d_3| + rho_3 |d_2|) / |d_2 x d_3| with rho their residuals at x~. The sphere gives
    tau^2 + 2 tau h + c = 0 with h = n . x~ and |c| <= rho_1 + 2 |x~| |delta| + |delta|^2. Where h has the
    branch's sign, the root on the branch has |tau| = |c| / (|h| + sqrt(h^2 - c)), which is at most |c| / |h|
    and at most sqrt|c| (it is real only where c <= h^2). tau rides on ERROR_SYMBOL along the centre's normal.
    """
    zero = splat(0.0)
    approximate_position(F, W, third, S)
    rho2, rho3 = residual(F, SECOND, S), residual(F, third, S)
    dot3(F, SCRATCH, POSITION, POSITION, S)
    store(F, SCRATCH, 0, load(F, SCRATCH, 0) - square)
    widen(F, SCRATCH, inflate_lanes(splat(square_err), abs(load(F, SCRATCH, 0)) + square, 4.0), S)
    rho1 = largest(F, SCRATCH, S)
    normal = load(W, SPOT, 3), load(W, SPOT, 4), load(W, SPOT, 5)
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
def slack_excluded(F: Forms, W: LaneArray, model: Any, needed: Lanes, S: Symbols) -> Lanes:
    """Return 1 where a cable outside the subset would be too long over the whole cell, else 0."""
    block = SLACK_CABLE
    excluded = splat(0.0)
    for i in range(model.n_taut, model.lengths.shape[0]):
        cable_rows(F, block, model, i, model.orders[0, 0], S)
        length_row(F, SCRATCH, block, S)
        below, _ = bounds(F, SCRATCH, S)
        excluded = where_less(0.0, below, 1.0, excluded)
        if covers(W, excluded, needed):
            break
    return excluded


@kernel()
def position_bounds(F: Forms, W: LaneArray, model: Any, S: Symbols) -> None:
    """Enclose p = A_1 + x - r_1 over the cells in W[BOUNDS], W[BOUNDS + 1]. Needs ``wrench_rows``.

    s (p - p~) is a form around zero for a float p~, and s >= 1.
    """
    pivot = model.orders[0, 0]
    least, most = bounds(F, SCALE, S)
    least = maximum(least, splat(1.0))
    one = splat(1.0)
    for k in range(3):
        a, e = model.anchors[pivot, k], model.anchors_err[pivot, k]
        middle = a - (load(F, WRENCH + k, 0) + load(F, ROOT_ARM + k, 0)) / load(F, SCALE, 0)
        offset = a - middle
        # s (x + (a - p~) - r_1); WRENCH holds -s x.
        combine2(F, SCRATCH, SCALE, offset, WRENCH + k, -one, S)
        combine2(F, SCRATCH, SCRATCH, one, ROOT_ARM + k, -one, S)
        below, above = bounds(F, SCRATCH, S)
        below = down_lanes(below / where_less(below, 0.0, least, most))
        above = up_lanes(above / where_less(0.0, above, least, most))
        # The rounding of a - p~ is an error of p.
        error = inflate_lanes(splat(e), abs(offset), 4.0)
        store(W, BOUNDS, k, down_lanes(down_lanes(middle + below) - error))
        store(W, BOUNDS + 1, k, up_lanes(up_lanes(middle + above) + error))
    if model.planar:
        # The equilibrium lies in the plane exactly (and the root's box has no width across it).
        store(W, BOUNDS, 1, 0.0)
        store(W, BOUNDS + 1, 1, 0.0)


@kernel()
def solution_bounds(F: Forms, W: LaneArray, model: Any, S: Symbols) -> Lanes:
    """Enclose p and t of every equilibrium of the taut cables in W[BOUNDS], W[TENSIONS].

    Returns 1 where t is bounded. Six lengths alone fix the pose: t is not an unknown then and stands as 0 in
    the roots. Needs ``wrench_rows``.
    """
    position_bounds(F, W, model, S)
    if model.n_taut < MOST_TAUT:
        return tension_bounds(F, W, model.n_taut, TENSIONS, S)
    for i in range(MOST_TAUT):
        store(W, TENSIONS, i, 0.0)
        store(W, TENSIONS + 1, i, 0.0)
    return splat(1.0)


@kernel()
def read_bounds(W: LaneArray, C: LaneArray, lane: int, model: Any, lo: Any, hi: Any) -> None:
    """Write one lane's bounds of (u, p, t), t in the subset's order."""
    for k in range(3):
        lo[k], hi[k] = C[0, 2 * k, lane], C[0, 2 * k + 1, lane]
        lo[3 + k], hi[3 + k] = W[BOUNDS, k, lane], W[BOUNDS + 1, k, lane]
    for j in range(lo.shape[0] - 6):
        i = model.orders[0, j]
        lo[6 + i], hi[6 + i] = W[TENSIONS, j, lane], W[TENSIONS + 1, j, lane]


@kernel()
def prepare(F: Forms, model: Any, C: LaneArray, S: Symbols) -> None:
    """Write everything of the cells that depends on u alone and the triple's normal."""
    rotation_rows(F, C, CHART, S)
    triple_rows(F, model, S)
    cross3(F, NORMAL, SECOND + CENTRE, third_block(model) + CENTRE, S)


@kernel()
def on_branch(F: Forms, W: LaneArray, model: Any, branch: Lanes, S: Symbols) -> Lanes:
    """Write x of one branch; 1 where it is a smooth function over the cell, else 0."""
    pivot = model.orders[0, 0]
    third = third_block(model)
    square, square_err = model.lengths_sq[pivot], model.lengths_sq_err[pivot]
    height_sq = centre_position(F, W, third, splat(square))
    h = root(maximum(height_sq, splat(0.0))) * branch
    for k in range(3):
        store(W, SPOT, k, load(W, SPOT, k) + h * load(W, SPOT, 3 + k))
    proved = position_rows(F, W, third, square, square_err, branch, S)
    return where_less(0.0, height_sq, proved, 0.0)


@kernel()
def enclose_cells(F: Forms, W: LaneArray, model: Any, C: LaneArray, S: Symbols) -> Lanes:
    """Enclose p and t of every equilibrium in the cells, see ``solution_bounds``; 1 where that succeeds.

    The cells have a branch.
    """
    prepare(F, model, C, S)
    proved = on_branch(F, W, model, load(C, 0, BRANCH), S)
    wrench_rows(F, model, S)
    return proved * solution_bounds(F, W, model, S)


@njit(cache=True, nogil=True)
def enclose_cell(
    F: Forms, W: LaneArray, model: Any, cell: Any, S: Symbols, C: LaneArray, lo: Any, hi: Any
) -> bool:
    """Enclose (u, p, t) of every equilibrium of the taut cables in one cell; False where that fails.

    ``lo, hi`` : (6 + n,). With ``lo`` of length 6 only the pose.
    """
    for k in range(cell.shape[0]):
        store(C, 0, k, cell[k])
    if cell[BRANCH] == 0.0:
        return False
    if lo.shape[0] == 6:
        prepare(F, model, C, S)
        proved = on_branch(F, W, model, load(C, 0, BRANCH), S)
        wrench_rows(F, model, S)
        position_bounds(F, W, model, S)
    else:
        proved = enclose_cells(F, W, model, C, S)
    read_bounds(W, C, 0, model, lo, hi)
    return bool(covers(W, proved, splat(1.0)))


@kernel()
def near_root(roots: Any, k: int, C: LaneArray, lane: int, chart: int, size: int) -> bool:
    """Return True when a lane's u lies in the uniqueness box of root ``k``, in its chart."""
    near = roots[k, 0] == C[0, chart, lane]
    for c in range(3):
        near = near and roots[k, 1 + c] <= C[0, 2 * c, lane]
        near = near and C[0, 2 * c + 1, lane] <= roots[k, 1 + size + c]
    return bool(near)


@kernel()
def settled(
    F: Forms, W: LaneArray, model: Any, roots: Any, C: LaneArray, chart: int, states: Any, S: Symbols
) -> None:
    """Mark as EMPTY the open lanes all of whose equilibria lie in one root's uniqueness box.

    ``roots`` : (m, 1 + 2 (6 + n)) chart, then lo and hi of the boxes. ``chart`` : the cells'
    column with theirs. Needs ``wrench_rows``.
    """
    size = 6 + model.n_taut
    bounded = False
    for k in range(roots.shape[0]):
        for lane in range(LANES):
            if states[lane] != OPEN or not near_root(roots, k, C, lane, chart, size):
                continue
            if not bounded:
                store(W, FLAGS, 20, solution_bounds(F, W, model, S))
                bounded = True
            inside = W[FLAGS, 20, lane] > 0.0
            for c in range(3):
                inside = inside and roots[k, 4 + c] <= W[BOUNDS, c, lane]
                inside = inside and W[BOUNDS + 1, c, lane] <= roots[k, 4 + size + c]
            for j in range(model.n_taut):
                i = model.orders[0, j]
                inside = inside and roots[k, 7 + i] <= W[TENSIONS, j, lane]
                inside = inside and W[TENSIONS + 1, j, lane] <= roots[k, 7 + size + i]
            if inside:
                states[lane] = EMPTY


@kernel()
def mark(W: LaneArray, flags: Lanes, states: Any, state: int) -> bool:
    """Give open lanes with flags > 0 a state; return True when a lane is still open."""
    store(W, FLAGS, 21, flags)
    left = False
    for lane in range(LANES):
        if states[lane] == OPEN and W[FLAGS, 21, lane] > 0.0:
            states[lane] = state
        left = left or states[lane] == OPEN
    return left


@kernel()
def open_lanes(W: LaneArray, states: Any) -> Lanes:
    """Return 1 in the open lanes, 0 in the others."""
    for lane in range(LANES):
        W[FLAGS, 22, lane] = 1.0 if states[lane] == OPEN else 0.0
    return load(W, FLAGS, 22)


@kernel()
def copy_cell(C: LaneArray, lane: int, children: Any) -> int:
    """Write a cell as its own only child."""
    for k in range(children.shape[1]):
        children[2 * lane, k] = C[0, k, lane]
    return 1


@kernel()
def leaf(C: LaneArray, lane: int, children: Any, kind: int) -> int:
    """Return a cell as a leaf."""
    copy_cell(C, lane, children)
    return -kind


@kernel()
def twins(C: LaneArray, lane: int, children: Any) -> int:
    """Write a cell as two children, each with half its share."""
    width = children.shape[1]
    for i in range(2):
        for k in range(width):
            children[2 * lane + i, k] = C[0, k, lane]
        children[2 * lane + i, width - 1] = 0.5 * C[0, width - 1, lane]
    return 2


@kernel()
def halve(C: LaneArray, lane: int, children: Any, lo: int) -> int:
    """Bisect the variable whose bounds stand at ``lo, lo + 1``; a leaf where no double lies between them."""
    m = 0.5 * (C[0, lo, lane] + C[0, lo + 1, lane])
    if not C[0, lo, lane] < m < C[0, lo + 1, lane]:
        return leaf(C, lane, children, SMALL)
    twins(C, lane, children)
    children[2 * lane, lo + 1] = m
    children[2 * lane + 1, lo] = m
    return 2


@kernel()
def both_branches(C: LaneArray, lane: int, children: Any) -> int:
    """Split a cell into its two branches."""
    twins(C, lane, children)
    children[2 * lane, BRANCH] = 1.0
    children[2 * lane + 1, BRANCH] = -1.0
    return 2


@kernel()
def contract_open(
    F: Forms, W: LaneArray, C: LaneArray, equations: int, variables: int, states: Any, S: Symbols
) -> None:
    """Contract the open lanes; their states become EMPTY or SMALLER, or stay. Others keep their cells."""
    for lane in range(LANES):
        # A lane that counts as empty is left alone.
        W[VERDICTS, 0, lane] = STUCK if states[lane] == OPEN else EMPTY
    contract(F, W, C, equations, variables, S)
    for lane in range(LANES):
        if states[lane] == OPEN:
            states[lane] = int(W[VERDICTS, 0, lane])


@kernel()
def newton(
    F: Forms, W: LaneArray, model: Any, C: LaneArray, lengths: int, rank: int, states: Any, S: Symbols
) -> None:
    """Contract the narrow open lanes by the further lengths (already in EQUATION..) and the statics.

    Where tension signs are to be ignored all six lengths are given and no statics enters.
    """
    equations = lengths
    n = model.n_taut
    if n < MOST_TAUT:
        centre_columns(F, W, n)
        limited = limit_tensions(F, W, n, rank, S)
        limited = limited * statics_equations(F, W, n, equations, rank, S)
        for e in range(6 - n):
            blank(F, EQUATION + lengths + e, limited, S)
        equations += 6 - n
    contract_open(F, W, C, equations, U_SYMBOLS, states, S)


@kernel()
def widest(C: LaneArray, lane: int) -> int:
    """Return which entry of u is widest in a lane."""
    best = 0
    for k in range(1, 3):
        if C[0, 2 * k + 1, lane] - C[0, 2 * k, lane] > C[0, 2 * best + 1, lane] - C[0, 2 * best, lane]:
            best = k
    return best


@kernel()
def width_of(C: LaneArray, lane: int) -> float:
    """Return the width of u in a lane."""
    k = widest(C, lane)
    return float(C[0, 2 * k + 1, lane] - C[0, 2 * k, lane])


@kernel(inline="always")
def classify(F: Forms, W: LaneArray, model: Any, roots: Any, C: LaneArray, states: Any, S: Symbols) -> None:
    """Exclude, settle or contract the open lanes."""
    n = model.n_taut
    needed = open_lanes(W, states)
    prepare(F, model, C, S)
    branch = load(C, 0, BRANCH)
    smooth = on_branch(F, W, model, where_less(abs(branch), 0.5, 1.0, branch), S)
    if not covers(W, smooth, needed):
        pivot = model.orders[0, 0]
        square, square_err = model.lengths_sq[pivot], model.lengths_sq_err[pivot]
        empty = no_position(F, third_block(model), square, square_err, S)
        mark(W, where_less(0.0, smooth, 0.0, empty), states, EMPTY)
        if not mark(W, 1.0 - smooth, states, UNSMOOTH):
            return
    if not mark(W, where_less(abs(branch), 0.5, splat(1.0), 0.0), states, BOTH):
        return
    lengths = 0
    for j in range(2 if model.planar else 3, n):
        length_row(F, EQUATION + lengths, CABLE + BLOCK * j, S)
        below, above = bounds(F, EQUATION + lengths, S)
        outside = where_less(0.0, below, 1.0, where_less(above, 0.0, splat(1.0), 0.0))
        if not mark(W, outside, states, EMPTY):
            return
        lengths += 1
    if model.slack and not mark(W, slack_excluded(F, W, model, open_lanes(W, states), S), states, EMPTY):
        return
    rank = solve_for_pivots(F, W, 0, lengths, U_SYMBOLS, S)
    wrench_rows(F, model, S)
    if model.statics:
        centre_columns(F, W, n)
        if not mark(W, balance_free(F, W, n, rank, open_lanes(W, states), S), states, EMPTY):
            return
    settled(F, W, model, roots, C, CHART, states, S)
    narrow = False
    for lane in range(LANES):
        if states[lane] == OPEN:
            if width_of(C, lane) <= NEWTON_WIDTH:
                narrow = True
            else:
                states[lane] = WIDE
    if narrow:
        newton(F, W, model, C, lengths, rank, states, S)


@kernel()
def verdict(C: LaneArray, lane: int, state: int, children: Any, leaf_size: float) -> int:
    """Write a lane's children or leaf; see ``engine.batches``."""
    width = width_of(C, lane)
    if state == EMPTY:
        return 0
    if state == SMALLER:
        return int(copy_cell(C, lane, children))
    if state == BOTH:
        return int(both_branches(C, lane, children))
    if state == UNSMOOTH and width <= FOLD_WIDTH:
        return int(leaf(C, lane, children, FOLDED))
    if state != UNSMOOTH and width <= leaf_size:
        return int(leaf(C, lane, children, SMALL))
    return int(halve(C, lane, children, 2 * widest(C, lane)))


@kernel(inline="always")
def process(context: Any, C: LaneArray, count: int, verdicts: Any, children: Any) -> None:
    """Exclude, contract, settle or split a batch of cells; see ``engine.batches``."""
    model, roots, leaf_size, S, F, W, states = context
    for lane in range(LANES):
        states[lane] = OPEN if lane < count else EMPTY
    classify(F, W, model, roots, C, states, S)
    for lane in range(count):
        verdicts[lane] = verdict(C, lane, states[lane], children, leaf_size)


@njit(cache=True, nogil=True)
def run(
    model: Any,
    roots: Any,
    leaf_size: float,
    S: Symbols,
    F: Forms,
    W: LaneArray,
    C: LaneArray,
    states: Any,
    verdicts: Any,
    stack: Any,
    count: int,
    leaves: Any,
    kinds: Any,
    children: Any,
    cell_limit: int,
) -> tuple[int, int, int]:
    """Search cells in u depth first; see ``engine.batches``."""
    context = (model, roots, leaf_size, S, F, W, states)
    return batches(process, context, C, verdicts, stack, count, leaves, kinds, children, cell_limit)
