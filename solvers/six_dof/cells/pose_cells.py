"""Cells in (u, x): six search variables, for any number of taut cables and any degeneracy of their centres.

All equations are polynomials of low degree in (u, x), so a cell needs no branch and no division. The
lengths of the taut cables are solved for as many of the six symbols as they fix; those symbols are cut
to what is left and taken out of every other form (``contraction``). It does not matter which
symbols they are: where centres coincide the rotation is fixed by the position, not the other way round.

Arrays: as in ``cells.tests``; a cell has the columns ``POSE_COLUMNS``; ``context`` is a ``kinds.Context``.
"""

from __future__ import annotations

from typing import Any

from numba import types

from cdpr_interval.engine.batch_cells import copy_cell, covers, fill_lanes, halve, is_empty, leaf
from cdpr_interval.engine.batches import batches
from cdpr_interval.engine.contraction import cut_pivots, is_pivot, shrunk, solve_for_pivots
from cdpr_interval.engine.rows import EMPTY, EQUATION, NO_LENGTH, OPEN, SMALL, SMALLER, VERDICTS, WIDE
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, array3, load, splat, store
from cdpr_interval.kernels.second_order import Forms, Symbols, constant, dot3, signatures
from cdpr_interval.mechanics.six_dof.geometry import (
    length_row,
    middle_and_radius,
    rotation_rows,
    subtract_square,
    triple_rows,
)
from cdpr_interval.mechanics.six_dof.rows import BEFORE, BLOCK, CABLE, MOVING, POSITION, U_SYMBOLS
from solvers.six_dof.cells.bounds import bound_cell, settled
from solvers.six_dof.cells.columns import POSE_COLUMNS
from solvers.six_dof.cells.tests import exclude_by_balance, exclude_by_length, exclude_by_slack, process_cells

CHART, VARIABLES = POSE_COLUMNS.chart, POSE_COLUMNS.variables
POSITION_WEIGHT = 0.4
"""Weight of x (over the platform's size) against u when bisecting; measured against 0.2 and 1."""
PIVOT_WEIGHT = 0.5
"""Weight of a variable that the lengths fix: bisecting it only helps where they leave several choices."""
CONTRACT_WIDTH = 0.1
"""Weighted width below which a cell that is not excluded is contracted by all equations."""
CUTS = 3
"""Most looks at the lengths alone before the other tests."""


@kernel(signatures(types.void, array3))
def position_variables(F: Forms, C: LaneArray, S: Symbols) -> None:
    """Write x on the symbols 3..5."""
    K = len(S.noise)
    Q = 1 + K + K * (K + 1) // 2
    for k in range(3):
        m, r = middle_and_radius(load(C, 0, 6 + 2 * k), load(C, 0, 7 + 2 * k))
        constant(F, POSITION + k, m, splat(0.0), S)
        store(F, POSITION + k, 1 + U_SYMBOLS + k, r)
        store(F, POSITION + k, Q + 1, r)


@kernel()
def length_equations(F: Forms, model: Any, S: Symbols) -> int:
    """Write the equations of the taut cables to EQUATION..; return how many."""
    pivot = model.orders[0, 0]
    dot3(F, EQUATION, POSITION, POSITION, S)
    subtract_square(F, EQUATION, pivot, model.lengths_sq[pivot], model.lengths_sq_err[pivot], S)
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
            exclude_by_length(F, W, EQUATION + e, states, S)
        rank = solve_for_pivots(F, W, 0, count, VARIABLES, S)
        for lane in range(LANES):
            moving = W[MOVING, 0, lane] > 0.0 and states[lane] == OPEN
            W[MOVING, 0, lane] = 1.0 if moving else 0.0
            W[VERDICTS, 0, lane] = OPEN if moving else EMPTY
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


@kernel(inline="always")
def fill(scratch: Any, model: Any, cell: Any) -> None:
    """Write one cell (width,) to all lanes, and its rows; ``scratch`` is a ``Scratch``."""
    S, F, C = scratch.symbols, scratch.forms, scratch.cells
    fill_lanes(C, cell)
    rotation_rows(F, C, CHART, S)
    triple_rows(F, model, S)
    position_variables(F, C, S)


@entry()
def enclose_cell(scratch: Any, model: Any, cell: Any, lo: Any, hi: Any) -> bool:
    """Enclose (u, p, t) of every equilibrium of the taut cables in one cell (width,); False where that fails.

    ``scratch`` is a ``Scratch``; ``lo, hi`` : (6 + n,). With ``lo`` of length 6 only the pose.
    """
    fill(scratch, model, cell)
    S, F, W, C = scratch.symbols, scratch.forms, scratch.work, scratch.cells
    return bool(covers(W, bound_cell(F, W, model, C, lo, hi, S), splat(1.0)))


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


@kernel(inline="always")
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
def exclude(F: Forms, W: LaneArray, model: Any, C: LaneArray, states: Any, S: Symbols) -> tuple[int, int]:
    """Cut the open lanes by the lengths, and give those that hold no equilibrium their states.

    Returns the number of lengths, in EQUATION.., and the most pivots of a lane; lanes still OPEN afterwards
    have all rows written.
    """
    rotation_rows(F, C, CHART, S)
    triple_rows(F, model, S)
    rank = cut_by_lengths(F, W, model, C, states, S)
    if not exclude_by_slack(F, W, model, states, S):
        return 0, 0
    if not exclude_by_balance(F, W, model, rank, states, S):
        return 0, 0
    return model.n_taut, rank


@kernel(inline="always")
def verdict(context: Any, lane: int, children: Any) -> int:
    """Write a lane's children or leaf; see ``engine.batches``."""
    C, state = context.scratch.cells, context.scratch.states[lane]
    if is_empty(state):
        return 0
    if state == SMALLER:
        return int(copy_cell(C, lane, children))
    return int(bisect(context.scratch.work, context.model, C, lane, children, context.leaf_size))


@kernel(inline="always")
def process(context: Any, count: int, children: Any) -> None:
    """Exclude, contract, settle or split a batch of cells; see ``tests.process_cells``."""
    process_cells(exclude, settled, narrow_lanes, verdict, context, count, children)


@entry()
def run(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Search cells in (u, x) depth first; see ``engine.batches``."""
    return batches(process, context, stack, count, leaves, kinds, children, cell_limit)
