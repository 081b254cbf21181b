"""Cells in (u, x), searched by the rules of a certificate alone, with notes of what becomes of them.

The tests are those of the checker, on the solver's forms; see ``certified_cuts``. Nothing here needs to be
rigorous, as what is noted is checked.

Arrays: as in ``cells.tests``; ``boxes`` (m, 13) of roots: chart, then (lo, hi) of (u, x); ``notes`` (rows,
COLUMNS + 1 + DATA), those of the batch from ``first``; ``note`` (COLUMNS + 1 + DATA,) one of them;
``context`` is a ``noted.Certified``.
"""

from __future__ import annotations

from typing import Any

from numba import types

from cdpr_interval.engine.batch_cells import copy_cell, covers, halve, leaf, open_first, open_lanes
from cdpr_interval.engine.batches import batches
from cdpr_interval.engine.contraction import reduce_row
from cdpr_interval.engine.notes import CUT, IN_BOX, UNDECIDED, begin_notes
from cdpr_interval.engine.rows import (
    EQUATION,
    NOT_SLACK,
    OPEN,
    PIVOT,
    SCRATCH,
    SETTLED,
    SMALL,
    SMALLER,
    UNBALANCED,
)
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, array3, lanes, load, splat, store, where_less
from cdpr_interval.kernels.second_order import Forms, Symbols, moving6, signatures
from cdpr_interval.mechanics.six_dof.balance import balance_free
from cdpr_interval.mechanics.six_dof.certified_cuts import change, cut, exclude_by_lengths, solve_as_checked
from cdpr_interval.mechanics.six_dof.directions import centre_columns, choose_slopes, wrench_of
from cdpr_interval.mechanics.six_dof.geometry import (
    cable_rows,
    length_row,
    rotation_rows,
    triple_rows,
    wrench_rows,
)
from cdpr_interval.mechanics.six_dof.rows import PASSED, SLACK_CABLE, Y
from solvers.six_dof.cells import pose_cells as pose
from solvers.six_dof.cells.noted_rotation_cells import alone

COLUMNS = 13
"""Of a cell that are noted: all but its share."""
DATA = 13
"""Columns of data: y, the cable that is too long, or the bounds of (u, x) that are left and whether the
checker may choose other pivots."""
POSITION_SHARE = 2.0
"""Weight of x (over the format's length) against u where a cell is halved; measured with six legs against
0.4, which takes three times the cells, 1.1 and 6; fewer cables hardly care."""


@kernel()
def exclude_too_long(
    F: Forms, W: LaneArray, model: Any, rank: int, states: Any, notes: Any, first: int, count: int, S: Symbols
) -> None:
    """Mark as NOT_SLACK the open lanes in which a cable outside the subset is too long, and note which."""
    for i in range(model.n_taut, model.lengths.shape[0]):
        cable_rows(F, SLACK_CABLE, model, i, model.orders[0, 0], S)
        length_row(F, SCRATCH, SLACK_CABLE, S)
        plain = load(F, SCRATCH, 0) - change(F, SCRATCH, S)
        reduce_row(F, SCRATCH, W, rank, S)
        freed = load(F, SCRATCH, 0) - change(F, SCRATCH, S)
        store(W, PASSED, 0, where_less(plain, freed, freed, plain))
        for lane in range(count):
            if states[lane] == OPEN and W[PASSED, 0, lane] > 0.0:
                states[lane] = NOT_SLACK
                notes[first + lane, COLUMNS + 1] = i


@kernel(signatures(lanes, array3, types.int64, types.int64))
def stays_positive(F: Forms, W: LaneArray, n: int, rank: int, S: Symbols) -> Lanes:
    """Return 1 where the direction y, moving as the checker's does, has positive products, else 0."""
    positive = splat(1.0)
    choose_slopes(F, W, n, n + 1, S)
    for i in range(n + 1):
        moving6(F, SCRATCH, wrench_of(i, n), W, Y, S)
        reduce_row(F, SCRATCH, W, rank, S)
        positive = where_less(0.0, load(F, SCRATCH, 0) - change(F, SCRATCH, S), positive, 0.0)
    return positive


@kernel()
def settle_by_boxes(boxes: Any, C: LaneArray, states: Any) -> None:
    """Mark as SETTLED the open lanes that lie in a root's box."""
    for lane in range(LANES):
        for i in range(boxes.shape[0]):
            inside = states[lane] == OPEN and boxes[i, 0] == C[0, pose.CHART, lane]
            for k in range(6):
                inside = inside and boxes[i, 1 + 2 * k] <= C[0, 2 * k, lane]
                inside = inside and C[0, 2 * k + 1, lane] <= boxes[i, 2 + 2 * k]
            if inside:
                states[lane] = SETTLED


@kernel()
def look(
    F: Forms,
    W: LaneArray,
    model: Any,
    boxes: Any,
    C: LaneArray,
    states: Any,
    notes: Any,
    first: int,
    count: int,
    S: Symbols,
) -> None:
    """Give the lanes their states: settled, excluded, SMALLER or still open; write data of their notes."""
    settle_by_boxes(boxes, C, states)
    rotation_rows(F, C, pose.CHART, S)
    triple_rows(F, model, S)
    pose.position_variables(F, C, S)
    n = pose.length_equations(F, model, S)
    exclude_by_lengths(F, W, EQUATION, n, states, S)
    rank = solve_as_checked(F, W, n, S)
    exclude_by_lengths(F, W, PIVOT, rank, states, S)
    cut(F, W, C, 6, rank, 1.0, states, notes, first, count, S)
    if model.slack:
        exclude_too_long(F, W, model, rank, states, notes, first, count, S)
    needed = open_lanes(W, states)
    if not model.statics or covers(W, splat(-1.0), needed):
        return
    wrench_rows(F, model, S)
    # The checker's direction moves over the cell as the wrenches do at solutions.
    for i in range(model.n_taut + 1):
        for k in range(6):
            reduce_row(F, wrench_of(i, model.n_taut) + k, W, rank, S)
    for lane in range(count):
        if states[lane] != OPEN:
            continue
        centre_columns(F, W, model.n_taut)
        free = balance_free(F, W, model.n_taut, rank, alone(W, lane), S)
        for k in range(6):
            notes[first + lane, COLUMNS + 1 + k] = W[Y, k, lane]
        store(W, PASSED, 0, free * stays_positive(F, W, model.n_taut, rank, S))
        if W[PASSED, 0, lane] > 0.0:
            states[lane] = UNBALANCED


@kernel()
def split(C: LaneArray, lane: int, children: Any, smallest: float, unit: float, note: Any) -> int:
    """Halve a lane in its longest entry, or give it up, and note which."""
    best, width = 0, -1.0
    for k in range(6):
        w = (C[0, 2 * k + 1, lane] - C[0, 2 * k, lane]) * (1.0 if k < 3 else POSITION_SHARE / unit)
        if w > width:
            best, width = k, w
    if C[0, 2 * best + 1, lane] - C[0, 2 * best, lane] < smallest * (1.0 if best < 3 else unit):
        note[COLUMNS] = UNDECIDED
        return int(leaf(C, lane, children, SMALL))
    note[COLUMNS] = best
    return int(halve(C, lane, children, 2 * best))


@kernel(inline="always")
def process(context: Any, count: int, children: Any) -> None:
    """Exclude, cut, settle or split a batch of cells, and take notes; see ``engine.batches``."""
    notes, noted = context.notes, context.noted
    S, F, W, C, states, verdicts = context.scratch
    begin_notes(C, count, notes, noted, COLUMNS)
    first = noted[0]
    open_first(states, count)
    look(F, W, context.model, context.boxes, C, states, notes, first, count, S)
    for lane in range(count):
        note, verdicts[lane] = notes[first + lane], 0
        if states[lane] == OPEN:
            verdicts[lane] = split(C, lane, children, context.smallest, context.unit, note)
        elif states[lane] == SMALLER:
            note[COLUMNS] = CUT
            verdicts[lane] = copy_cell(C, lane, children)
            for k in range(12):
                children[2 * lane, k] = note[COLUMNS + 1 + k]
        else:
            note[COLUMNS] = IN_BOX if states[lane] == SETTLED else states[lane]
    noted[0] = first + count


@entry()
def run(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Search cells in (u, x) depth first; see ``engine.batches`` and ``engine.notes``."""
    return batches(process, context, stack, count, leaves, kinds, children, cell_limit)
