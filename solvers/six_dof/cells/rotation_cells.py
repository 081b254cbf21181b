"""Cells in u alone: three search variables, the position being one of two branches over the cell.

``branch`` encloses the position of a branch by second-order forms. Where the branches meet (a fold),
where the centres come close to one line, or where the position turns too fast, the cell is handed on to
the search in (u, x) of ``pose_cells``, which needs no branch.

Arrays: as in ``cells.tests``; a cell has the columns ``ROTATION_COLUMNS``; ``context`` is a
``kinds.Context``.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.engine.batch_cells import (
    copy_cell,
    covers,
    fill_lanes,
    halve,
    is_empty,
    leaf,
    mark,
    open_lanes,
    twins,
)
from cdpr_interval.engine.batches import batches
from cdpr_interval.engine.contraction import solve_for_pivots
from cdpr_interval.engine.rows import (
    BOTH,
    EQUATION,
    FOLDED,
    NO_POSITION,
    OPEN,
    SMALL,
    SMALLER,
    UNSMOOTH,
    WIDE,
)
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, load, splat, where_less
from cdpr_interval.kernels.second_order import Forms, Symbols, cross3
from cdpr_interval.mechanics.six_dof.geometry import length_row, rotation_rows, third_block, triple_rows
from cdpr_interval.mechanics.six_dof.rows import BLOCK, CABLE, CENTRE, NORMAL, SECOND, U_SYMBOLS
from solvers.six_dof.cells.bounds import bound_cell, settled
from solvers.six_dof.cells.branch import no_position, on_branch
from solvers.six_dof.cells.columns import ROTATION_COLUMNS
from solvers.six_dof.cells.tests import exclude_by_balance, exclude_by_length, exclude_by_slack, process_cells

CHART, BRANCH = ROTATION_COLUMNS.chart, ROTATION_COLUMNS.branch
FOLD_WIDTH = 0.13
"""Width of u at which a cell without smooth branches is handed on; measured against 0.07 and 0.26."""
NEWTON_WIDTH = 0.3
"""Width of u below which a cell that is not excluded is contracted before it is bisected."""


@kernel()
def prepare(F: Forms, model: Any, C: LaneArray, S: Symbols) -> None:
    """Write everything of the cells that depends on u alone and the triple's normal."""
    rotation_rows(F, C, CHART, S)
    triple_rows(F, model, S)
    cross3(F, NORMAL, SECOND + CENTRE, third_block(model) + CENTRE, S)


@kernel(inline="always")
def fill(scratch: Any, model: Any, cell: Any) -> Lanes:
    """Write one cell (width,) on one branch to all lanes, and its rows; 1 where its position is enclosed.

    ``scratch`` is a ``Scratch``.
    """
    S, F, W, C = scratch.symbols, scratch.forms, scratch.work, scratch.cells
    fill_lanes(C, cell)
    prepare(F, model, C, S)
    return on_branch(F, W, model, load(C, 0, BRANCH), S)


@entry()
def enclose_cell(scratch: Any, model: Any, cell: Any, lo: Any, hi: Any) -> bool:
    """Enclose (u, p, t) of every equilibrium of the taut cables in one cell (width,); False where that fails.

    ``scratch`` is a ``Scratch``; ``lo, hi`` : (6 + n,). With ``lo`` of length 6 only the pose.
    """
    if cell[BRANCH] == 0.0:
        return False
    proved = fill(scratch, model, cell)
    S, F, W, C = scratch.symbols, scratch.forms, scratch.work, scratch.cells
    proved = proved * bound_cell(F, W, model, C, lo, hi, S)
    return bool(covers(W, proved, splat(1.0)))


@kernel()
def both_branches(C: LaneArray, lane: int, children: Any) -> int:
    """Split a cell into its two branches."""
    twins(C, lane, children)
    children[2 * lane, BRANCH] = 1.0
    children[2 * lane + 1, BRANCH] = -1.0
    return 2


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
def exclude(F: Forms, W: LaneArray, model: Any, C: LaneArray, states: Any, S: Symbols) -> tuple[int, int]:
    """Give the open lanes that hold no equilibrium, or no smooth position, their states.

    Returns the number of further lengths, in EQUATION.., and the most pivots of a lane; lanes still OPEN
    afterwards have all rows written.
    """
    n = model.n_taut
    needed = open_lanes(W, states)
    prepare(F, model, C, S)
    branch = load(C, 0, BRANCH)
    smooth = on_branch(F, W, model, where_less(abs(branch), 0.5, 1.0, branch), S)
    if not covers(W, smooth, needed):
        pivot = model.orders[0, 0]
        square, square_err = model.lengths_sq[pivot], model.lengths_sq_err[pivot]
        empty = no_position(F, third_block(model), square, square_err, S)
        mark(W, where_less(0.0, smooth, 0.0, empty), states, NO_POSITION)
        if not mark(W, 1.0 - smooth, states, UNSMOOTH):
            return 0, 0
    if not mark(W, where_less(abs(branch), 0.5, splat(1.0), 0.0), states, BOTH):
        return 0, 0
    lengths = 0
    for j in range(2 if model.planar else 3, n):
        length_row(F, EQUATION + lengths, CABLE + BLOCK * j, S)
        if not exclude_by_length(F, W, EQUATION + lengths, states, S):
            return 0, 0
        lengths += 1
    if not exclude_by_slack(F, W, model, states, S):
        return 0, 0
    rank = solve_for_pivots(F, W, 0, lengths, U_SYMBOLS, S)
    if not exclude_by_balance(F, W, model, rank, states, S):
        return 0, 0
    return lengths, rank


@kernel(inline="always")
def narrow_lanes(model: Any, C: LaneArray, states: Any) -> bool:
    """Leave only those lanes open that are narrow enough to be contracted; True when there are any."""
    narrow = False
    for lane in range(LANES):
        if states[lane] == OPEN:
            if width_of(C, lane) <= NEWTON_WIDTH:
                narrow = True
            else:
                states[lane] = WIDE
    return narrow


@kernel(inline="always")
def verdict(context: Any, lane: int, children: Any) -> int:
    """Write a lane's children or leaf; see ``engine.batches``."""
    C, state = context.scratch.cells, context.scratch.states[lane]
    width = width_of(C, lane)
    if is_empty(state):
        return 0
    if state == SMALLER:
        return int(copy_cell(C, lane, children))
    if state == BOTH:
        return int(both_branches(C, lane, children))
    if state == UNSMOOTH and width <= FOLD_WIDTH:
        return int(leaf(C, lane, children, FOLDED))
    if state != UNSMOOTH and width <= context.leaf_size:
        return int(leaf(C, lane, children, SMALL))
    return int(halve(C, lane, children, 2 * widest(C, lane)))


@kernel(inline="always")
def process(context: Any, count: int, children: Any) -> None:
    """Exclude, contract, settle or split a batch of cells; see ``tests.process_cells``."""
    process_cells(exclude, settled, narrow_lanes, verdict, context, count, children)


# As ``pose_cells.run``: numba caches no function made by a function, nor one that is passed another one.
@entry()
def run(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Search cells in u depth first; see ``engine.batches``."""
    return batches(process, context, stack, count, leaves, kinds, children, cell_limit)
