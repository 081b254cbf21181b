"""Cells in u alone: three search variables, the position being one of two branches over the cell.

The three spheres of a triple leave two positions for a rotation, mirrored at the plane of their centres: the
sign of sigma = x . (d_2 x d_3) tells them apart. Over a small enough cell each branch x(u) is a smooth
function; ``position_rows`` encloses it by a second-order form. Where the branches meet (a fold), where the
centres come close to one line, or where the position turns too fast, the cell is handed on to the
search in (u, x) of ``platform_pose``, which needs no branch.

A cell is a row ``u (3 x lo, hi), chart, branch, order, share``; branch 0 stands for both.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from cdpr_interval.engine.depth_first import depth_first
from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.rounding import down, inflate, up
from cdpr_interval.kernels.second_order import (
    Symbols,
    add_product,
    add_scaled,
    bounds,
    close,
    combine3,
    constant,
    cross3,
    dot3,
    largest,
    scale,
    widen,
)
from solvers.platform_elimination import EMPTY, SMALLER, contract, solve_for_pivots
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
    limit_tensions,
    no_tensions,
    statics_equations,
    tension_bounds,
)

CHART, BRANCH, ORDER, SHARE = 6, 7, 8, 9
WIDTH = 10
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


@njit(cache=True, nogil=True)
def centre_position(F: Any, W: Any, model: Any, order: int) -> float:
    """Write the foot of x at the cell's centre and the unit normal to W[SPOT]; return the height's square.

    NaN or infinite where the centres lie on one line.
    """
    third = third_block(model)
    a0, a1, a2 = F[SECOND + CENTRE, 0], F[SECOND + CENTRE + 1, 0], F[SECOND + CENTRE + 2, 0]
    b0, b1, b2 = F[third + CENTRE, 0], F[third + CENTRE + 1, 0], F[third + CENTRE + 2, 0]
    m0, m1, m2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    mm = m0 * m0 + m1 * m1 + m2 * m2
    if not mm > 0.0:
        return math.nan
    k2, k3 = F[SECOND + OFFSET, 0] / mm, F[third + OFFSET, 0] / mm
    # x = (K_2 (d_3 x m) + K_3 (m x d_2)) / |m|^2
    W[SPOT, 0] = k2 * (b1 * m2 - b2 * m1) + k3 * (m1 * a2 - m2 * a1)
    W[SPOT, 1] = k2 * (b2 * m0 - b0 * m2) + k3 * (m2 * a0 - m0 * a2)
    W[SPOT, 2] = k2 * (b0 * m1 - b1 * m0) + k3 * (m0 * a1 - m1 * a0)
    norm = math.sqrt(mm)
    W[SPOT, 3], W[SPOT, 4], W[SPOT, 5] = m0 / norm, m1 / norm, m2 / norm
    foot = W[SPOT, 0] ** 2 + W[SPOT, 1] ** 2 + W[SPOT, 2] ** 2
    return float(model.lengths_sq[model.orders[order, 0]] - foot)


@njit(cache=True, nogil=True)
def approximate_position(F: Any, W: Any, third: int, S: Symbols) -> bool:
    """Write x~ to POSITION: the second-order Taylor polynomial of the branch through W[SPOT]; no error."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    for k in range(3):
        W[0, k] = F[SECOND + CENTRE + k, 0]
        W[1, k] = F[third + CENTRE + k, 0]
        W[2, k] = W[SPOT, k]
        for i in range(3):
            W[i, 3 + k] = 1.0 if i == k else 0.0
        constant(F, POSITION + k, W[SPOT, k], 0.0, S)
    if not solve_in_place(W, 3, 3):
        return False
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
        F[POSITION + k, Q] = 0.0
        close(F, POSITION + k, S)
    return True


@njit(cache=True, nogil=True)
def taylor_term(F: Any, W: Any, third: int, column: int, a: int, b: int) -> None:
    """Solve for x~ in ``column``; a, b are the columns of its two symbols, -1 for a linear term."""
    r0 = F[SECOND + OFFSET, column]
    r1 = F[third + OFFSET, column]
    r2 = 0.0
    for k in range(3):
        x = POSITION + k
        d, e = SECOND + CENTRE + k, third + CENTRE + k
        r0 -= F[d, column] * F[x, 0]
        r1 -= F[e, column] * F[x, 0]
        if a >= 0:
            r0 -= F[d, a] * F[x, b]
            r1 -= F[e, a] * F[x, b]
            if a != b:
                r0 -= F[d, b] * F[x, a]
                r1 -= F[e, b] * F[x, a]
                r2 -= F[x, a] * F[x, b]
            else:
                r2 -= 0.5 * F[x, a] * F[x, a]
    for k in range(3):
        F[POSITION + k, column] = W[k, 3] * r0 + W[k, 4] * r1 + W[k, 5] * r2


@njit(cache=True, nogil=True)
def residual(F: Any, block: int, S: Symbols) -> float:
    """Return an upper bound of |s K - s d . x~| over the cell."""
    length_row(F, SCRATCH, block, S)
    return float(largest(F, SCRATCH, S))


@njit(cache=True, nogil=True)
def position_rows(F: Any, W: Any, model: Any, order: int, branch: int, S: Symbols) -> bool:
    """Enclose x over the cell on one branch (the sign of sigma) in the rows POSITION.

    Guarantee: where True is returned, every x with branch * sigma >= 0 that satisfies the three equations of
    the triple at some u of the cell is enclosed at that u. Proof: x - x~ = delta + tau n with n the unit
    normal of d_2, d_3 and delta across it. The two plane equations give
    |delta| <= (rho_2 |d_3| + rho_3 |d_2|) / |d_2 x d_3| with rho their residuals at x~. The sphere gives
    tau^2 + 2 tau h + c = 0 with h = n . x~ and |c| <= rho_1 + 2 |x~| |delta| + |delta|^2. Where h has the
    branch's sign, the root on the branch has |tau| = |c| / (|h| + sqrt(h^2 - c)), which is at most |c| / |h|
    and at most sqrt|c| (it is real only where c <= h^2). tau rides on ERROR_SYMBOL along the centre's normal.
    """
    pivot = model.orders[order, 0]
    third = third_block(model)
    if not approximate_position(F, W, third, S):
        return False
    rho2, rho3 = residual(F, SECOND, S), residual(F, third, S)
    dot3(F, SCRATCH, POSITION, POSITION, S)
    square, square_err = model.lengths_sq[pivot], model.lengths_sq_err[pivot]
    F[SCRATCH, 0] -= square
    widen(F, SCRATCH, inflate(square_err, abs(F[SCRATCH, 0]) + square, 4.0), S)
    rho1 = largest(F, SCRATCH, S)
    n0, n1, n2 = W[SPOT, 3], W[SPOT, 4], W[SPOT, 5]
    # |m| from below: m . n, with |n| <= 1 up to rounding.
    combine3(F, SCRATCH, NORMAL, n0, n1, n2, 0.0, S)
    least, most = bounds(F, SCRATCH, S)
    least = down(least * (1.0 - 1e-14))
    if not least > 0.0:
        return False
    # tan of the angle between m and n.
    tilt = 0.0
    for k in range(3):
        w = n0 if k == 0 else (n1 if k == 1 else n2)
        e0, e1, e2 = (1.0 if k == 0 else 0.0), (1.0 if k == 1 else 0.0), (1.0 if k == 2 else 0.0)
        combine3(F, SCRATCH, NORMAL, e0 - w * n0, e1 - w * n1, e2 - w * n2, 0.0, S)
        tilt += largest(F, SCRATCH, S) ** 2
    # 1e-14: the rounded matrix I - n n^T is off by some units, relative to |m|.
    tilt = up(up(math.sqrt(tilt) * (1.0 + 1e-14)) / least) + 1e-14
    most = up(most * up(math.sqrt(up(1.0 + up(tilt * tilt))))) * (1.0 + 1e-14)
    most = min(most, vector_largest(F, NORMAL, S))
    across = rho2 * vector_largest(F, third + CENTRE, S) + rho3 * vector_largest(F, SECOND + CENTRE, S)
    delta = up(inflate(across, 0.0, 4.0) / least)
    dot3(F, SIGMA, POSITION, NORMAL, S)
    lo, hi = bounds(F, SIGMA, S)
    height = down((lo if branch > 0 else -hi) / most)
    if not height > 0.0:
        return False
    reach = up(math.sqrt(up(up(square + square_err) + rho1)))
    c = inflate(rho1 + delta * (2.0 * reach + delta), 0.0, 6.0)
    tau = min(up(c / height), up(math.sqrt(c)))
    if not tau < math.inf:
        return False
    error = up(delta + up(tau * tilt))
    for k in range(3):
        slope = tau * W[SPOT, 3 + k]
        F[POSITION + k, 1 + ERROR_SYMBOL] = slope
        widen(F, POSITION + k, inflate(error, abs(slope), 4.0), S)
        close(F, POSITION + k, S)
    return True


@njit(cache=True, nogil=True)
def vector_largest(F: Any, row: int, S: Symbols) -> float:
    """Return an upper bound of the length of a vector in three rows."""
    total = 0.0
    for k in range(3):
        total += largest(F, row + k, S) ** 2
    return up(math.sqrt(inflate(total, 0.0, 10.0)))


@njit(cache=True, nogil=True)
def no_position(F: Any, model: Any, order: int, S: Symbols) -> bool:
    """Return True when the three spheres of the triple have no common point over the cell.

    sigma^2 = l_1^2 |m|^2 - |K_2 d_3 - K_3 d_2|^2 < 0 (with factors s^4).
    """
    pivot = model.orders[order, 0]
    third = third_block(model)
    v = SCRATCH + 4
    for k in range(3):
        constant(F, v + k, 0.0, 0.0, S)
        add_product(F, v + k, SECOND + OFFSET, third + CENTRE + k, 1.0, S)
        add_product(F, v + k, third + OFFSET, SECOND + CENTRE + k, -1.0, S)
    dot3(F, SCRATCH, NORMAL, NORMAL, S)
    most = largest(F, SCRATCH, S)
    scale(F, SCRATCH, SCRATCH, model.lengths_sq[pivot], S)
    widen(F, SCRATCH, inflate(most * model.lengths_sq_err[pivot], 0.0, 4.0), S)
    dot3(F, SCRATCH + 1, v, v, S)
    add_scaled(F, SCRATCH, SCRATCH + 1, -1.0, S)
    return bool(bounds(F, SCRATCH, S)[1] < 0.0)


@njit(cache=True, nogil=True)
def slack_excluded(F: Any, model: Any, chart: int, order: int, S: Symbols) -> bool:
    """Return True when a cable outside the subset would be too long over the whole cell."""
    block = SLACK_CABLE
    for i in range(model.n_taut, model.lengths.shape[0]):
        cable_rows(F, block, model, chart, i, model.orders[order, 0], S)
        length_row(F, SCRATCH, block, S)
        if bounds(F, SCRATCH, S)[0] > 0.0:
            return True
    return False


@njit(cache=True, nogil=True)
def position_bounds(F: Any, model: Any, order: int, S: Symbols, lo: Any, hi: Any) -> None:
    """Enclose p = A_1 + x - r_1 over the cell. Needs ``wrench_rows``.

    s (p - p~) is a form around zero for a float p~, and s >= 1.
    """
    pivot = model.orders[order, 0]
    least, most = bounds(F, SCALE, S)
    least = max(least, 1.0)
    for k in range(3):
        a, e = model.anchors[pivot, k], model.anchors_err[pivot, k]
        middle = a - (F[WRENCH + k, 0] + F[ROOT_ARM + k, 0]) / F[SCALE, 0]
        offset = a - middle
        # s (x + (a - p~) - r_1); WRENCH holds -s x.
        scale(F, SCRATCH, SCALE, offset, S)
        add_scaled(F, SCRATCH, WRENCH + k, -1.0, S)
        add_scaled(F, SCRATCH, ROOT_ARM + k, -1.0, S)
        below, above = bounds(F, SCRATCH, S)
        below = down(below / (least if below < 0.0 else most))
        above = up(above / (least if above > 0.0 else most))
        # The rounding of a - p~ is an error of p.
        error = inflate(e, abs(offset), 4.0)
        lo[k] = down(down(middle + below) - error)
        hi[k] = up(up(middle + above) + error)
    if model.planar:
        # The equilibrium lies in the plane exactly (and the root's box has no width across it).
        lo[1] = 0.0
        hi[1] = 0.0


@njit(cache=True, nogil=True)
def enclose_cell(F: Any, W: Any, model: Any, cell: Any, S: Symbols, lo: Any, hi: Any) -> bool:
    """Enclose (u, p, t) of every equilibrium of the taut cables in the cell; False where that fails.

    ``lo, hi`` : (6 + n,). With ``lo`` of length 6 only the pose.
    """
    branch = int(cell[BRANCH])
    chart, order = int(cell[CHART]), int(cell[ORDER])
    prepare(F, model, cell, chart, order, S)
    if branch == 0 or not on_branch(F, W, model, order, branch, S):
        return False
    wrench_rows(F, model, chart, order, S)
    return finish_enclosure(F, W, model, cell, order, S, lo, hi)


@njit(cache=True, nogil=True)
def finish_enclosure(F: Any, W: Any, model: Any, cell: Any, order: int, S: Symbols, lo: Any, hi: Any) -> bool:
    """Write (u, p, t) bounds, given the wrenches."""
    for k in range(3):
        lo[k] = cell[2 * k]
        hi[k] = cell[2 * k + 1]
    position_bounds(F, model, order, S, lo[3:6], hi[3:6])
    if lo.shape[0] == 6:
        return True
    if model.n_taut == MOST_TAUT:
        no_tensions(lo[6:], hi[6:])
        return True
    return bool(in_file_order(F, W, model, order, S, lo, hi))


@njit(cache=True, nogil=True)
def in_file_order(F: Any, W: Any, model: Any, order: int, S: Symbols, lo: Any, hi: Any) -> bool:
    """Write the bounds of t, which the forms hold in the cell's order, in the subset's order."""
    n = model.n_taut
    low, high = W[46], W[47]
    if not tension_bounds(F, W, n, S, low, high):
        return False
    for j in range(n):
        lo[6 + model.orders[order, j]] = low[j]
        hi[6 + model.orders[order, j]] = high[j]
    return True


@njit(cache=True, nogil=True)
def settled(
    F: Any, W: Any, model: Any, roots: Any, cell: Any, order: int, S: Symbols, lo: Any, hi: Any
) -> bool:
    """Return True when every equilibrium in the cell lies in one root's uniqueness box.

    ``roots`` : (m, 1 + 2 (6 + n)) chart, then lo and hi of the boxes. Needs ``wrench_rows``.
    """
    size = 6 + model.n_taut
    bounded = False
    for k in range(roots.shape[0]):
        if int(roots[k, 0]) != int(cell[CHART]):
            continue
        near = True
        for c in range(3):
            near = near and roots[k, 1 + c] <= cell[2 * c] and cell[2 * c + 1] <= roots[k, 1 + size + c]
        if not near:
            continue
        if not bounded:
            if not finish_enclosure(F, W, model, cell, order, S, lo, hi):
                return False
            bounded = True
        inside = True
        for c in range(size):
            inside = inside and roots[k, 1 + c] <= lo[c] and hi[c] <= roots[k, 1 + size + c]
        if inside:
            return True
    return False


@njit(cache=True, nogil=True)
def leaf(cell: Any, children: Any, kind: int) -> int:
    """Return the cell as a leaf."""
    copy_cell(cell, children)
    return -kind


@njit(cache=True, nogil=True)
def copy_cell(cell: Any, children: Any) -> None:
    """Write the cell as its own only child."""
    for k in range(cell.shape[0]):
        children[0, k] = cell[k]


@njit(cache=True, nogil=True)
def halve(cell: Any, children: Any, lo: int) -> int:
    """Bisect the variable whose bounds stand at ``lo, lo + 1``; a leaf where no double lies between them."""
    m = 0.5 * (cell[lo] + cell[lo + 1])
    if not cell[lo] < m < cell[lo + 1]:
        return leaf(cell, children, SMALL)
    for k in range(cell.shape[0]):
        children[0, k] = cell[k]
        children[1, k] = cell[k]
    children[0, lo + 1] = m
    children[1, lo] = m
    share = 0.5 * cell[cell.shape[0] - 1]
    children[0, cell.shape[0] - 1] = share
    children[1, cell.shape[0] - 1] = share
    return 2


@njit(cache=True, nogil=True)
def both_branches(cell: Any, children: Any) -> int:
    """Split a cell into its two branches."""
    for k in range(cell.shape[0]):
        children[0, k] = cell[k]
        children[1, k] = cell[k]
    children[0, BRANCH] = 1.0
    children[1, BRANCH] = -1.0
    share = 0.5 * cell[SHARE]
    children[0, SHARE] = share
    children[1, SHARE] = share
    return 2


@njit(cache=True, nogil=True)
def prepare(F: Any, model: Any, cell: Any, chart: int, order: int, S: Symbols) -> None:
    """Write everything of a cell that depends on u alone and the triple's normal."""
    rotation_rows(F, cell, S)
    triple_rows(F, model, chart, order, S)
    cross3(F, NORMAL, SECOND + CENTRE, third_block(model) + CENTRE, S)


@njit(cache=True, nogil=True)
def on_branch(F: Any, W: Any, model: Any, order: int, branch: int, S: Symbols) -> bool:
    """Write x of one branch; False where it is not a smooth function over the cell."""
    height_sq = centre_position(F, W, model, order)
    if not height_sq > 0.0:
        return False
    h = math.sqrt(height_sq) * branch
    for k in range(3):
        W[SPOT, k] += h * W[SPOT, 3 + k]
    return bool(position_rows(F, W, model, order, branch, S))


@njit(cache=True, nogil=True)
def newton(F: Any, W: Any, model: Any, cell: Any, lengths: int, rank: int, S: Symbols) -> int:
    """Contract the cell by the further lengths (already in EQUATION..) and the statics with tensions >= 0.

    Where tension signs are to be ignored all six lengths are given and no statics enters.
    """
    equations = lengths
    n = model.n_taut
    if n < MOST_TAUT and centre_columns(F, W, n) and limit_tensions(F, W, n, rank, S):
        equations += statics_equations(F, W, n, equations, rank, S)
    return int(contract(F, W, cell, equations, U_SYMBOLS, S))


@njit(cache=True, nogil=True)
def process(context: Any, cell: Any, children: Any) -> int:
    """Exclude, contract, settle or split one cell; see ``engine.depth_first``."""
    model, roots, leaf_size, S, F, W, lo, hi = context
    chart, branch, order = int(cell[CHART]), int(cell[BRANCH]), int(cell[ORDER])
    n = model.n_taut
    widest = 0
    width = -1.0
    for k in range(3):
        if cell[2 * k + 1] - cell[2 * k] > width:
            width = cell[2 * k + 1] - cell[2 * k]
            widest = k
    prepare(F, model, cell, chart, order, S)
    if not on_branch(F, W, model, order, 1 if branch == 0 else branch, S):
        if no_position(F, model, order, S):
            return 0
        if width > FOLD_WIDTH:
            return halve(cell, children, 2 * widest)
        return leaf(cell, children, FOLDED)
    if branch == 0:
        return both_branches(cell, children)
    lengths = 0
    for j in range(2 if model.planar else 3, n):
        length_row(F, EQUATION + lengths, CABLE + BLOCK * j, S)
        below, above = bounds(F, EQUATION + lengths, S)
        if below > 0.0 or above < 0.0:
            return 0
        lengths += 1
    if model.slack and slack_excluded(F, model, chart, order, S):
        return 0
    rank = solve_for_pivots(F, W, 0, lengths, U_SYMBOLS, S)
    wrench_rows(F, model, chart, order, S)
    if model.statics and centre_columns(F, W, n) and balance_free(F, W, n, rank, S):
        return 0
    if settled(F, W, model, roots, cell, order, S, lo, hi):
        return 0
    if width <= NEWTON_WIDTH:
        verdict = newton(F, W, model, cell, lengths, rank, S)
        if verdict == EMPTY:
            return 0
        if verdict == SMALLER:
            copy_cell(cell, children)
            return 1
    if width <= leaf_size:
        return leaf(cell, children, SMALL)
    return halve(cell, children, 2 * widest)


@njit(cache=True, nogil=True)
def run(
    model: Any,
    roots: Any,
    leaf_size: float,
    S: Symbols,
    F: Any,
    W: Any,
    lo: Any,
    hi: Any,
    stack: Any,
    count: int,
    leaves: Any,
    kinds: Any,
    children: Any,
    cell_limit: int,
) -> tuple[int, int, int]:
    """Search cells in u depth first; see ``engine.depth_first``."""
    context = (model, roots, leaf_size, S, F, W, lo, hi)
    return depth_first(process, context, stack, count, leaves, kinds, children, cell_limit)
