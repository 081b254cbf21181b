"""Cells in (u, x): six search variables, for any number of taut cables and any degeneracy of their centres.

All equations are polynomials of low degree in (u, x), so a cell needs no branch and no division. The
lengths of the taut cables are solved for as many of the six symbols as they fix; those symbols are cut
to what is left and taken out of every other form (``contraction``). It does not matter which
symbols they are: where centres coincide the rotation is fixed by the position, not the other way round.

A cell is a row ``u (3 x lo, hi), x (3 x lo, hi), chart, share``; x = p + r_1 - A_1 of the pivot.
"""

from __future__ import annotations

from typing import Any

from numba import njit, types

from cdpr_interval.engine.batch_cells import (
    NO_LENGTH,
    NOT_SLACK,
    OPEN,
    SMALL,
    UNBALANCED,
    UNLOADED,
    WIDE,
    contract_open,
    copy_cell,
    halve,
    is_empty,
    leaf,
    mark,
    open_lanes,
)
from cdpr_interval.engine.batches import batches
from cdpr_interval.engine.contraction import (
    EMPTY,
    SMALLER,
    STUCK,
    VERDICTS,
    blank,
    cut_pivots,
    is_pivot,
    shrunk,
    solve_for_pivots,
)
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, array3, load, splat, store, where_less
from cdpr_interval.kernels.rounding import inflate_lanes
from cdpr_interval.kernels.second_order import Forms, Symbols, bounds, constant, dot3, signatures, widen
from cdpr_interval.mechanics.six_dof.balance import balance_free, covers, limit_tensions, statics_equations
from cdpr_interval.mechanics.six_dof.directions import centre_columns
from cdpr_interval.mechanics.six_dof.geometry import (
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
from cdpr_interval.mechanics.six_dof.unloaded import unloaded
from solvers.six_dof.bounds import position_bounds, read_bounds, settled, slack_excluded, solution_bounds

P_CHART, P_SHARE = 12, 13
P_WIDTH = 14
VARIABLES = 6
POSITION_WEIGHT = 0.4
"""Weight of x (over the platform's size) against u when bisecting; measured against 0.2 and 1."""
PIVOT_WEIGHT = 0.5
"""Weight of a variable that the lengths fix: bisecting it only helps where they leave several choices."""
BEFORE = 45
"""Row of W that holds the cell before a cut."""
MOVING = 46
"""Row of W whose first place is 1 in lanes that are still being cut."""
CONTRACT_WIDTH = 0.1
"""Weighted width below which a cell that is not excluded is contracted by all equations."""
CUTS = 3
"""Most looks at the lengths alone before the other tests."""


@kernel(signatures(types.void, array3))
def position_variables(F: Forms, C: LaneArray, S: Symbols) -> None:
    """Write x on the symbols 3..5."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    for k in range(3):
        m, r = middle_and_radius(load(C, 0, 6 + 2 * k), load(C, 0, 7 + 2 * k))
        constant(F, POSITION + k, m, splat(0.0), S)
        store(F, POSITION + k, 4 + k, r)
        store(F, POSITION + k, Q + 1, r)


@kernel()
def length_equations(F: Forms, model: Any, S: Symbols) -> int:
    """Write the equations of the taut cables to EQUATION..; return how many."""
    pivot = model.orders[0, 0]
    dot3(F, EQUATION, POSITION, POSITION, S)
    square = model.lengths_sq[pivot]
    centre = load(F, EQUATION, 0) - square
    store(F, EQUATION, 0, centre)
    error = inflate_lanes(splat(model.lengths_sq_err[pivot]), abs(centre) + square, 4.0)
    widen(F, EQUATION, error, S)
    for j in range(1, model.n_taut):
        length_row(F, EQUATION + j, CABLE + BLOCK * j, S)
    return int(model.n_taut)


@kernel()
def after_cut(W: LaneArray, C: LaneArray, lane: int, states: Any) -> None:
    """Decide what a cut did to a lane: empty, u much smaller (a new cell), x (once more), or little."""
    if W[VERDICTS, 0, lane] == EMPTY:
        states[lane] = NO_LENGTH
        W[MOVING, 0, lane] = 0.0
        return
    for k in range(3):
        now = C[0, 2 * k + 1, lane] - C[0, 2 * k, lane]
        if shrunk(now, W[BEFORE, 2 * k + 1, lane] - W[BEFORE, 2 * k, lane]):
            states[lane] = SMALLER
            W[MOVING, 0, lane] = 0.0
            return
    in_position = W[VERDICTS, 0, lane] == SMALLER
    for k in range(6 if in_position else 2 * VARIABLES):
        C[0, k, lane] = W[BEFORE, k, lane]
    if not in_position:
        W[MOVING, 0, lane] = 0.0


@kernel()
def cut_by_lengths(F: Forms, W: LaneArray, model: Any, C: LaneArray, states: Any, S: Symbols) -> int:
    """Cut the open lanes' cells by the lengths until that gains little; return the most pivots of a lane.

    Lanes still OPEN afterwards: the rows in F are those of the cell as it is now. SMALLER: they are not, look
    again. Small gains are given back, because the rows were made for the cell before the cut.
    """
    rank = 0
    for lane in range(LANES):
        W[MOVING, 0, lane] = 1.0 if states[lane] == OPEN else 0.0
    for _ in range(CUTS):
        position_variables(F, C, S)
        count = length_equations(F, model, S)
        for e in range(count):
            lo, hi = bounds(F, EQUATION + e, S)
            outside = where_less(0.0, lo, 1.0, where_less(hi, 0.0, splat(1.0), 0.0))
            mark(W, outside, states, NO_LENGTH)
        rank = solve_for_pivots(F, W, 0, count, VARIABLES, S)
        for lane in range(LANES):
            moving = W[MOVING, 0, lane] > 0.0 and states[lane] == OPEN
            W[MOVING, 0, lane] = 1.0 if moving else 0.0
            W[VERDICTS, 0, lane] = STUCK if moving else EMPTY
            for k in range(2 * VARIABLES):
                W[BEFORE, k, lane] = C[0, k, lane]
        cut_pivots(F, W, C, rank, S)
        again = False
        for lane in range(LANES):
            if W[MOVING, 0, lane] > 0.0:
                after_cut(W, C, lane, states)
                again = again or W[MOVING, 0, lane] > 0.0
        if not again:
            return rank
    for lane in range(LANES):
        if W[MOVING, 0, lane] > 0.0:
            states[lane] = SMALLER
    return rank


@njit(cache=True, nogil=True)
def enclose_cell(
    F: Forms, W: LaneArray, model: Any, cell: Any, S: Symbols, C: LaneArray, lo: Any, hi: Any
) -> bool:
    """Enclose (u, p, t) of every equilibrium of the taut cables in a cell; False if t is not bounded.

    ``lo, hi`` : (6 + n,). With ``lo`` of length 6 only the pose.
    """
    for k in range(cell.shape[0]):
        store(C, 0, k, cell[k])
    rotation_rows(F, C, P_CHART, S)
    triple_rows(F, model, S)
    position_variables(F, C, S)
    wrench_rows(F, model, S)
    bounded = splat(1.0)
    if lo.shape[0] == 6:
        position_bounds(F, W, model, S)
    else:
        bounded = solution_bounds(F, W, model, S)
    read_bounds(W, C, 0, model, lo, hi)
    return bool(covers(W, bounded, splat(1.0)))


@kernel()
def newton(F: Forms, W: LaneArray, model: Any, C: LaneArray, rank: int, states: Any, S: Symbols) -> None:
    """Contract the open lanes by the lengths (already in EQUATION..) and the statics."""
    n = model.n_taut
    equations = n
    if n < MOST_TAUT:
        centre_columns(F, W, n)
        limited = limit_tensions(F, W, n, rank, S)
        # The pivots stay in the equations: the contraction solves for all variables at once.
        statics_equations(F, W, n, equations, 0, S)
        for e in range(6 - n):
            blank(F, EQUATION + n + e, limited, S)
        equations += 6 - n
    contract_open(F, W, C, equations, VARIABLES, states, S)


@kernel()
def weighted_width(model: Any, C: LaneArray, lane: int, k: int) -> float:
    """Return the width of variable ``k`` of a lane, in which u and x compare."""
    w = C[0, 2 * k + 1, lane] - C[0, 2 * k, lane]
    return float(w if k < 3 else w * POSITION_WEIGHT / model.size)


@kernel()
def bisect(W: LaneArray, model: Any, C: LaneArray, lane: int, children: Any, leaf_size: float) -> int:
    """Bisect the widest variable of a lane, or return a leaf."""
    widest, width, largest = 0, -1.0, 0.0
    for k in range(VARIABLES):
        w = weighted_width(model, C, lane, k)
        largest = max(largest, w)
        if is_pivot(W, lane, k):
            w *= PIVOT_WEIGHT
        if w > width:
            widest, width = k, w
    if largest <= leaf_size:
        return int(leaf(C, lane, children, SMALL))
    return int(halve(C, lane, children, 2 * widest))


@kernel()
def narrow_lanes(model: Any, C: LaneArray, states: Any) -> bool:
    """Leave only those lanes open that are narrow enough to be contracted; True when there are any."""
    narrow = False
    for lane in range(LANES):
        if states[lane] == OPEN:
            for k in range(VARIABLES):
                if weighted_width(model, C, lane, k) > CONTRACT_WIDTH:
                    states[lane] = WIDE
            narrow = narrow or states[lane] == OPEN
    return narrow


@kernel(inline="always")
def exclude(F: Forms, W: LaneArray, model: Any, C: LaneArray, states: Any, S: Symbols) -> int:
    """Cut the open lanes by the lengths, and give those that hold no equilibrium their states.

    Returns the most pivots of a lane; lanes still OPEN afterwards have all rows written.
    """
    n = model.n_taut
    rotation_rows(F, C, P_CHART, S)
    triple_rows(F, model, S)
    rank = cut_by_lengths(F, W, model, C, states, S)
    needed = open_lanes(W, states)
    if not covers(W, splat(-1.0), needed) and model.slack:
        mark(W, slack_excluded(F, W, model, needed, S), states, NOT_SLACK)
    needed = open_lanes(W, states)
    if covers(W, splat(-1.0), needed):
        return 0
    wrench_rows(F, model, S)
    if model.hanging and not mark(W, unloaded(F, W, model, rank, S), states, UNLOADED):
        return 0
    if model.statics:
        centre_columns(F, W, n)
        if not mark(W, balance_free(F, W, n, rank, needed, S), states, UNBALANCED):
            return 0
    return rank


@kernel(inline="always")
def classify(F: Forms, W: LaneArray, model: Any, roots: Any, C: LaneArray, states: Any, S: Symbols) -> None:
    """Exclude, settle or contract the open lanes."""
    rank = exclude(F, W, model, C, states, S)
    if covers(W, splat(-1.0), open_lanes(W, states)):
        return
    settled(F, W, model, roots, C, P_CHART, states, S)
    if narrow_lanes(model, C, states):
        newton(F, W, model, C, rank, states, S)


@kernel(inline="always")
def process(context: Any, C: LaneArray, count: int, verdicts: Any, children: Any) -> None:
    """Exclude, contract, settle or split a batch of cells; see ``engine.batches``."""
    model, roots, leaf_size, S, F, W, states = context
    for lane in range(LANES):
        states[lane] = OPEN if lane < count else EMPTY
    classify(F, W, model, roots, C, states, S)
    for lane in range(count):
        if is_empty(states[lane]):
            verdicts[lane] = 0
        elif states[lane] == SMALLER:
            verdicts[lane] = copy_cell(C, lane, children)
        else:
            verdicts[lane] = bisect(W, model, C, lane, children, leaf_size)


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
    """Search cells in (u, x) depth first; see ``engine.batches``."""
    context = (model, roots, leaf_size, S, F, W, states)
    return batches(process, context, C, verdicts, stack, count, leaves, kinds, children, cell_limit)
