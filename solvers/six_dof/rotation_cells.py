"""Cells in u alone: three search variables, the position being one of two branches over the cell.

``branch`` encloses the position of a branch by second-order forms. Where the branches meet (a fold),
where the centres come close to one line, or where the position turns too fast, the cell is handed on to
the search in (u, x) of ``pose_cells``, which needs no branch.

A cell is a row ``u (3 x lo, hi), chart, branch, share``; branch 0 stands for both. Kernels look at LANES
cells at once: ``C`` (1, width, LANES).
"""

from __future__ import annotations

from typing import Any

from numba import njit

from cdpr_interval.engine.batch_cells import (
    NO_LENGTH,
    NO_POSITION,
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
    twins,
)
from cdpr_interval.engine.batches import batches
from cdpr_interval.engine.contraction import EMPTY, SMALLER, blank, solve_for_pivots
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, load, splat, store, where_less
from cdpr_interval.kernels.second_order import Forms, Symbols, bounds, cross3
from cdpr_interval.mechanics.six_dof.balance import balance_free, covers, limit_tensions, statics_equations
from cdpr_interval.mechanics.six_dof.directions import centre_columns
from cdpr_interval.mechanics.six_dof.geometry import (
    BLOCK,
    CABLE,
    CENTRE,
    EQUATION,
    MOST_TAUT,
    NORMAL,
    U_SYMBOLS,
    length_row,
    rotation_rows,
    third_block,
    triple_rows,
    wrench_rows,
)
from cdpr_interval.mechanics.six_dof.unloaded import unloaded
from solvers.six_dof.bounds import position_bounds, read_bounds, settled, slack_excluded, solution_bounds
from solvers.six_dof.branch import SECOND, no_position, on_branch

CHART, BRANCH, SHARE = 6, 7, 8
WIDTH = 9
FOLDED = 2
"""Leaf kind: the position is not two smooth functions of u over the cell; to be searched in (u, x)."""
FOLD_WIDTH = 0.13
"""Width of u at which a cell without smooth branches is handed on; measured against 0.07 and 0.26."""
NEWTON_WIDTH = 0.3
"""Width of u below which a cell that is not excluded is contracted before it is bisected."""
UNSMOOTH = 3
"""State of a lane whose position is not a smooth function over the cell."""
BOTH = 4
"""State of a lane that stands for two branches."""


@kernel()
def prepare(F: Forms, model: Any, C: LaneArray, S: Symbols) -> None:
    """Write everything of the cells that depends on u alone and the triple's normal."""
    rotation_rows(F, C, CHART, S)
    triple_rows(F, model, S)
    cross3(F, NORMAL, SECOND + CENTRE, third_block(model) + CENTRE, S)


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
    prepare(F, model, C, S)
    proved = on_branch(F, W, model, load(C, 0, BRANCH), S)
    wrench_rows(F, model, S)
    if lo.shape[0] == 6:
        position_bounds(F, W, model, S)
    else:
        proved = proved * solution_bounds(F, W, model, S)
    read_bounds(W, C, 0, model, lo, hi)
    return bool(covers(W, proved, splat(1.0)))


@kernel()
def both_branches(C: LaneArray, lane: int, children: Any) -> int:
    """Split a cell into its two branches."""
    twins(C, lane, children)
    children[2 * lane, BRANCH] = 1.0
    children[2 * lane + 1, BRANCH] = -1.0
    return 2


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
        statics_equations(F, W, n, equations, rank, S)
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
        below, above = bounds(F, EQUATION + lengths, S)
        outside = where_less(0.0, below, 1.0, where_less(above, 0.0, splat(1.0), 0.0))
        if not mark(W, outside, states, NO_LENGTH):
            return 0, 0
        lengths += 1
    if model.slack:
        too_far = slack_excluded(F, W, model, open_lanes(W, states), S)
        if not mark(W, too_far, states, NOT_SLACK):
            return 0, 0
    rank = solve_for_pivots(F, W, 0, lengths, U_SYMBOLS, S)
    wrench_rows(F, model, S)
    if model.hanging and not mark(W, unloaded(F, W, model, rank, S), states, UNLOADED):
        return 0, 0
    if model.statics:
        centre_columns(F, W, n)
        if not mark(W, balance_free(F, W, n, rank, open_lanes(W, states), S), states, UNBALANCED):
            return 0, 0
    return lengths, rank


@kernel(inline="always")
def classify(F: Forms, W: LaneArray, model: Any, roots: Any, C: LaneArray, states: Any, S: Symbols) -> None:
    """Exclude, settle or contract the open lanes."""
    lengths, rank = exclude(F, W, model, C, states, S)
    if covers(W, splat(-1.0), open_lanes(W, states)):
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
    if is_empty(state):
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
