"""Cells in u, searched by the rules of a certificate alone, with notes of what becomes of them.

A cell is excluded for a reason that a certificate can name, settled by a root's box in (u, x), handed on, cut
by its lengths, or halved. Nothing here needs to be rigorous, as what is noted is checked.

Arrays: as in ``cells.tests``; ``boxes`` (m, 13) of roots: chart, then lo and hi of (u, x); ``context`` is a
``noted.Certified``.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.engine.batch_cells import any_open, copy_cell, halve, is_empty, leaf, open_first
from cdpr_interval.engine.batches import batches
from cdpr_interval.engine.contraction import solve_for_pivots
from cdpr_interval.engine.notes import CUT, IN_BOX, UNDECIDED, begin_notes
from cdpr_interval.engine.rows import BOTH, EQUATION, FOLDED, OPEN, PIVOT, SETTLED, SMALL, SMALLER, UNSMOOTH
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, store
from cdpr_interval.kernels.second_order import Forms, Symbols, bounds, dot3
from cdpr_interval.mechanics.six_dof.certified_cuts import cut, exclude_by_lengths, solve_as_checked
from cdpr_interval.mechanics.six_dof.geometry import subtract_square
from cdpr_interval.mechanics.six_dof.rows import PLACES, POSITION, U_SYMBOLS
from solvers.six_dof.cells import rotation_cells as turn
from solvers.six_dof.cells.noted_rotation_cells import COLUMNS, note_fates

BRANCH_SHARE = 1.1
"""By how much more the rests of equations count in a cut: the checker has its own way to the position."""


@kernel()
def settle_by_boxes(
    F: Forms, W: LaneArray, model: Any, boxes: Any, C: LaneArray, states: Any, S: Symbols
) -> None:
    """Mark as SETTLED the open lanes that lie in a root's box, the position too."""
    for k in range(3):
        lo, hi = bounds(F, POSITION + k, S)
        store(W, PLACES, k, lo)
        store(W, PLACES + 1, k, hi)
    for lane in range(LANES):
        if model.planar:
            W[PLACES, 1, lane], W[PLACES + 1, 1, lane] = 0.0, 0.0
        for i in range(boxes.shape[0]):
            inside = states[lane] == OPEN and boxes[i, 0] == C[0, turn.CHART, lane]
            for k in range(3):
                inside = inside and boxes[i, 1 + 2 * k] <= C[0, 2 * k, lane]
                inside = inside and C[0, 2 * k + 1, lane] <= boxes[i, 2 + 2 * k]
                inside = inside and boxes[i, 7 + 2 * k] <= W[PLACES, k, lane]
                inside = inside and W[PLACES + 1, k, lane] <= boxes[i, 8 + 2 * k]
            if inside:
                states[lane] = SETTLED


@kernel()
def cut_by_lengths(
    F: Forms,
    W: LaneArray,
    model: Any,
    C: LaneArray,
    lengths: int,
    states: Any,
    notes: Any,
    first: int,
    count: int,
    S: Symbols,
) -> None:
    """Exclude or cut the open lanes by the further lengths, in EQUATION.., and by the first one."""
    pivot = model.orders[0, 0]
    row = EQUATION + lengths
    dot3(F, row, POSITION, POSITION, S)
    subtract_square(F, row, pivot, model.lengths_sq[pivot], model.lengths_sq_err[pivot], S)
    rank = solve_as_checked(F, W, lengths + 1, S)
    exclude_by_lengths(F, W, PIVOT, rank, states, S)
    cut(F, W, C, 3, rank, BRANCH_SHARE, states, notes, first, count, S)
    # As the directions of the lanes that are UNBALANCED were found.
    solve_for_pivots(F, W, 0, lengths, U_SYMBOLS, S)


@kernel()
def verdict(C: LaneArray, lane: int, state: int, children: Any, smallest: float) -> int:
    """Write a lane's children or leaf; see ``engine.batches``."""
    width = turn.width_of(C, lane)
    if is_empty(state):
        return 0
    if state == BOTH:
        return int(turn.both_branches(C, lane, children))
    if state == SMALLER:
        return int(copy_cell(C, lane, children))
    if state == UNSMOOTH and width <= turn.FOLD_WIDTH:
        return int(leaf(C, lane, children, FOLDED))
    if width < smallest:
        return int(leaf(C, lane, children, SMALL))
    return int(halve(C, lane, children, 2 * turn.widest(C, lane)))


@kernel(inline="always")
def process(context: Any, count: int, children: Any) -> None:
    """Exclude, settle or split a batch of cells, and take notes; see ``engine.batches``."""
    model, notes, noted = context.model, context.notes, context.noted
    S, F, W, C, states, verdicts = context.scratch
    begin_notes(C, count, notes, noted, COLUMNS)
    first = noted[0]
    open_first(states, count)
    lengths, _ = turn.exclude(F, W, model, C, states, S)
    settle_by_boxes(F, W, model, context.boxes, C, states, S)
    if any_open(states):
        cut_by_lengths(F, W, model, C, lengths, states, notes, first, count, S)
    for lane in range(count):
        verdicts[lane] = verdict(C, lane, states[lane], children, context.smallest)
    note_fates(context, count, children)
    for lane in range(count):
        if states[lane] == SETTLED:
            notes[first + lane, COLUMNS] = IN_BOX
        elif verdicts[lane] == -SMALL:
            notes[first + lane, COLUMNS] = UNDECIDED
        elif states[lane] == SMALLER:
            notes[first + lane, COLUMNS] = CUT
            for k in range(6):
                children[2 * lane, k] = notes[first + lane, COLUMNS + 1 + k]


@entry()
def run(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Search cells in u depth first; see ``engine.batches`` and ``engine.notes``."""
    return batches(process, context, stack, count, leaves, kinds, children, cell_limit)
