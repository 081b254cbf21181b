"""Cells in (u, x): six search variables, for any number of taut cables and any degeneracy of their centres.

All equations are polynomials of low degree in (u, x), so a cell needs no branch and no division. The
lengths of the taut cables are solved for as many of the six symbols as they fix; those symbols are cut
to what is left and taken out of every other form (``platform_elimination``). It does not matter which
symbols they are: where centres coincide the rotation is fixed by the position, not the other way round.

A cell is a row ``u (3 x lo, hi), x (3 x lo, hi), chart, share``; x = p + r_1 - A_1 of the
first order's pivot.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from cdpr_interval.engine.depth_first import depth_first
from cdpr_interval.kernels.rounding import inflate
from cdpr_interval.kernels.second_order import Symbols, bounds, constant, dot3, widen
from solvers.platform_elimination import (
    EMPTY,
    SMALLER,
    STUCK,
    contract,
    cut_pivots,
    is_pivot,
    shrunk,
    solve_for_pivots,
)
from solvers.platform_polynomials import (
    BLOCK,
    CABLE,
    EQUATION,
    MOST_TAUT,
    POSITION,
    length_row,
    middle_and_radius,
    rotation_rows,
    triple_rows,
    wrench_rows,
)
from solvers.platform_statics import (
    balance_free,
    centre_columns,
    limit_tensions,
    no_tensions,
    statics_equations,
)
from solvers.platform_turn import (
    SMALL,
    copy_cell,
    halve,
    in_file_order,
    leaf,
    position_bounds,
    slack_excluded,
)

P_CHART, P_SHARE = 12, 13
P_WIDTH = 14
VARIABLES = 6
POSITION_WEIGHT = 0.4
"""Weight of x (over the platform's size) against u when bisecting; measured against 0.2 and 1."""
PIVOT_WEIGHT = 0.5
"""Weight of a variable that the lengths fix: bisecting it only helps where they leave several choices."""
BEFORE = 45
"""Row of W that holds the cell before a cut."""
CUTS = 3
"""Most looks at the lengths alone before the other tests."""


@njit(cache=True, nogil=True)
def position_variables(F: Any, cell: Any, S: Symbols) -> None:
    """Write x on the symbols 3..5."""
    for k in range(3):
        m, r = middle_and_radius(cell[6 + 2 * k], cell[7 + 2 * k])
        constant(F, POSITION + k, m, 0.0, S)
        F[POSITION + k, 4 + k] = r
        F[POSITION + k, F.shape[1] - 2] = r


@njit(cache=True, nogil=True)
def length_equations(F: Any, model: Any, S: Symbols) -> int:
    """Write the equations of the taut cables to EQUATION..; return how many."""
    pivot = model.orders[0, 0]
    dot3(F, EQUATION, POSITION, POSITION, S)
    square = model.lengths_sq[pivot]
    F[EQUATION, 0] -= square
    widen(F, EQUATION, inflate(model.lengths_sq_err[pivot], abs(F[EQUATION, 0]) + square, 4.0), S)
    for j in range(1, model.n_taut):
        length_row(F, EQUATION + j, CABLE + BLOCK * j, S)
    return int(model.n_taut)


@njit(cache=True, nogil=True)
def cut_by_lengths(F: Any, W: Any, model: Any, cell: Any, S: Symbols) -> tuple[int, int]:
    """Cut the cell by the lengths until that gains little; return a verdict and the number of pivots.

    STUCK: the rows in F are those of the cell as it is now. SMALLER: they are not, look again. Small
    gains are given back, because the rows were made for the cell before the cut.
    """
    for _ in range(CUTS):
        position_variables(F, cell, S)
        count = length_equations(F, model, S)
        for e in range(count):
            lo, hi = bounds(F, EQUATION + e, S)
            if lo > 0.0 or hi < 0.0:
                return EMPTY, 0
        rank = solve_for_pivots(F, W, 0, count, VARIABLES, S)
        for k in range(2 * VARIABLES):
            W[BEFORE, k] = cell[k]
        verdict = cut_pivots(F, W, cell, rank, S)
        if verdict == EMPTY:
            return EMPTY, 0
        for k in range(3):
            if shrunk(cell[2 * k + 1] - cell[2 * k], W[BEFORE, 2 * k + 1] - W[BEFORE, 2 * k]):
                return SMALLER, 0
        for k in range(6 if verdict == SMALLER else 2 * VARIABLES):
            cell[k] = W[BEFORE, k]
        if verdict == STUCK:
            return STUCK, rank
    return SMALLER, 0


@njit(cache=True, nogil=True)
def enclose_cell(F: Any, W: Any, model: Any, cell: Any, S: Symbols, lo: Any, hi: Any) -> bool:
    """Enclose (u, p, t) of every equilibrium of the taut cables in the cell; False if t is not bounded.

    ``lo, hi`` : (6 + n,). With ``lo`` of length 6 only the pose.
    """
    chart = int(cell[P_CHART])
    rotation_rows(F, cell, S)
    triple_rows(F, model, chart, 0, S)
    position_variables(F, cell, S)
    wrench_rows(F, model, chart, 0, S)
    return finish_enclosure(F, W, model, cell, S, lo, hi)


@njit(cache=True, nogil=True)
def finish_enclosure(F: Any, W: Any, model: Any, cell: Any, S: Symbols, lo: Any, hi: Any) -> bool:
    """Write (u, p, t) bounds, given the wrenches."""
    for k in range(3):
        lo[k] = cell[2 * k]
        hi[k] = cell[2 * k + 1]
    position_bounds(F, model, 0, S, lo[3:6], hi[3:6])
    if lo.shape[0] == 6:
        return True
    if model.n_taut == MOST_TAUT:
        no_tensions(lo[6:], hi[6:])
        return True
    return bool(in_file_order(F, W, model, 0, S, lo, hi))


@njit(cache=True, nogil=True)
def settled(F: Any, W: Any, model: Any, roots: Any, cell: Any, S: Symbols, lo: Any, hi: Any) -> bool:
    """Return True when every equilibrium in the cell lies in one root's uniqueness box.

    Needs ``wrench_rows``.
    """
    size = 6 + model.n_taut
    bounded = False
    for k in range(roots.shape[0]):
        near = int(roots[k, 0]) == int(cell[P_CHART])
        for c in range(3):
            near = near and roots[k, 1 + c] <= cell[2 * c] and cell[2 * c + 1] <= roots[k, 1 + size + c]
        if not near:
            continue
        if not bounded:
            if not finish_enclosure(F, W, model, cell, S, lo, hi):
                return False
            bounded = True
        for c in range(3, size):
            near = near and roots[k, 1 + c] <= lo[c] and hi[c] <= roots[k, 1 + size + c]
        if near:
            return True
    return False


@njit(cache=True, nogil=True)
def newton(F: Any, W: Any, model: Any, cell: Any, rank: int, S: Symbols) -> int:
    """Contract the cell by the lengths (already in EQUATION..) and the statics."""
    n = model.n_taut
    equations = n
    if n < MOST_TAUT and centre_columns(F, W, n) and limit_tensions(F, W, n, rank, S):
        # The pivots stay in the equations: the contraction solves for all variables at once.
        equations += statics_equations(F, W, n, equations, 0, S)
    return int(contract(F, W, cell, equations, VARIABLES, S))


@njit(cache=True, nogil=True)
def bisect(W: Any, model: Any, cell: Any, children: Any, rank: int, leaf_size: float) -> int:
    """Bisect the widest variable, or return a leaf."""
    widest, width, largest = 0, -1.0, 0.0
    for k in range(VARIABLES):
        w = cell[2 * k + 1] - cell[2 * k]
        if k >= 3:
            w *= POSITION_WEIGHT / model.size
        largest = max(largest, w)
        if is_pivot(W, k, rank):
            w *= PIVOT_WEIGHT
        if w > width:
            widest, width = k, w
    if largest <= leaf_size:
        return int(leaf(cell, children, SMALL))
    return int(halve(cell, children, 2 * widest))


@njit(cache=True, nogil=True)
def process(context: Any, cell: Any, children: Any) -> int:
    """Exclude, contract, settle or split one cell; see ``engine.depth_first``."""
    model, roots, leaf_size, S, F, W, lo, hi = context
    chart = int(cell[P_CHART])
    n = model.n_taut
    rotation_rows(F, cell, S)
    triple_rows(F, model, chart, 0, S)
    verdict, rank = cut_by_lengths(F, W, model, cell, S)
    if verdict == EMPTY:
        return 0
    if verdict == SMALLER:
        copy_cell(cell, children)
        return 1
    if model.slack and slack_excluded(F, model, chart, 0, S):
        return 0
    wrench_rows(F, model, chart, 0, S)
    if model.statics and centre_columns(F, W, n) and balance_free(F, W, n, rank, S):
        return 0
    if settled(F, W, model, roots, cell, S, lo, hi):
        return 0
    verdict = newton(F, W, model, cell, rank, S)
    if verdict == EMPTY:
        return 0
    if verdict == SMALLER:
        copy_cell(cell, children)
        return 1
    return bisect(W, model, cell, children, rank, leaf_size)


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
    """Search cells in (u, x) depth first; see ``engine.depth_first``."""
    context = (model, roots, leaf_size, S, F, W, lo, hi)
    return depth_first(process, context, stack, count, leaves, kinds, children, cell_limit)
