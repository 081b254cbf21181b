"""Cells in (u, x), searched by the rules of a certificate alone, with notes of what becomes of them.

The tests are those of the checker, on the solver's forms: a form is bounded by its value and the sizes of
its coefficients, and the equations are solved for the symbols that complete pivoting chooses, or a cut would
not be confirmed. Nothing here needs to be rigorous, as what is noted is checked.

Arrays: as in ``cells.tests``; ``boxes`` (m, 13) of roots: chart, then (lo, hi) of (u, x); ``notes`` (rows,
COLUMNS + 1 + DATA), those of the batch from ``first``; ``note`` (COLUMNS + 1 + DATA,) one of them;
``context`` is a ``noted.Certified``.
"""

from __future__ import annotations

from typing import Any

from numba import types

from cdpr_interval.engine.batch_cells import copy_cell, covers, halve, leaf, mark, open_first, open_lanes
from cdpr_interval.engine.batches import batches
from cdpr_interval.engine.contraction import blank, eliminate, is_pivot, reduce_row
from cdpr_interval.engine.notes import CUT, IN_BOX, UNDECIDED, begin_notes
from cdpr_interval.engine.rows import (
    EQUATION,
    MOST_PIVOTS,
    NO_LENGTH,
    NOT_SLACK,
    OPEN,
    PIVOT,
    PIVOTS,
    SCRATCH,
    SETTLED,
    SMALL,
    SMALLER,
    TABLEAU,
    UNBALANCED,
)
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, array3, lanes, load, splat, store, where_less
from cdpr_interval.kernels.second_order import Forms, Symbols, add_scaled, constant, moving6, signatures
from cdpr_interval.mechanics.six_dof.balance import balance_free
from cdpr_interval.mechanics.six_dof.directions import centre_columns, choose_slopes, wrench_of
from cdpr_interval.mechanics.six_dof.geometry import (
    cable_rows,
    length_row,
    rotation_rows,
    triple_rows,
    wrench_rows,
)
from cdpr_interval.mechanics.six_dof.rows import CENTRE_OF, CHANGE_OF, PASSED, SLACK_CABLE, TIE, Y
from solvers.six_dof.cells import pose_cells as pose
from solvers.six_dof.cells.noted_rotation_cells import alone

COLUMNS = 13
"""Of a cell that are noted: all but its share."""
DATA = 13
"""Columns of data: y, the cable that is too long, or the bounds of (u, x) that are left and whether the
checker may choose other pivots."""
TIED = 1e-9
"""Of pivots that differ by less the checker may choose another one."""
NO_PIVOT = 1e-9
"""Pivots below this share of the first one are taken for rounding: the equations depend on each other."""
USEFUL_CUT = 0.7
"""A cut is made when some entry keeps at most this share of its width."""
WIDER = 1e-9
"""A kept interval is widened by this share of its width, so that the checker confirms it."""
ROUNDING = 2.0**-50
"""And by this share of itself."""
POSITION_SHARE = 0.4
"""Width of x over the format's length that counts as much as a width of u, where a cell is halved."""


@kernel(signatures(lanes, types.int64))
def change(F: Forms, row: int, S: Symbols) -> Lanes:
    """Return the sum of the sizes of a form's coefficients but its value."""
    K = len(S.noise)
    Q = 1 + K + K * (K + 1) // 2
    return load(F, row, Q) + load(F, row, Q + 1) + load(F, row, Q + 2)


@kernel("i8(f8[:, :, ::1], i8, i8, i8)")
def choose_pivots(W: LaneArray, lane: int, count: int, symbols: int) -> int:
    """Run Gauss-Jordan with complete pivoting on a lane's tableau of full rank; return the rank, or 0."""
    for s in range(count):
        W[PIVOTS, s, lane] = -1.0
    W[PASSED, TIE, lane] = 0.0
    largest = 0.0
    for rank in range(count):
        best, second, line, column = 0.0, 0.0, -1, -1
        for e in range(rank, count):
            for k in range(symbols):
                size = abs(W[TABLEAU + e, k, lane])
                if size >= best and not is_pivot(W, lane, k):
                    second, best, line, column = best, size, e, k
                elif not is_pivot(W, lane, k):
                    second = max(second, size)
        largest = max(largest, best)
        if second >= (1.0 - TIED) * best:
            W[PASSED, TIE, lane] = 1.0
        if not best > NO_PIVOT * largest:
            for s in range(count):
                W[PIVOTS, s, lane] = -1.0
            return 0
        eliminate(W, lane, rank, line, column, count, symbols + count)
        W[PIVOTS, rank, lane] = column
    return count


@kernel(signatures(types.int64, array3, types.int64))
def solve_as_checked(F: Forms, W: LaneArray, count: int, S: Symbols) -> int:
    """Solve the rows EQUATION.. for as many symbols, where they are independent; return the most of a lane.

    Writes PIVOT.. and W[PIVOTS] as ``contraction.solve_for_pivots`` does.
    """
    K = len(S.noise)
    for s in range(MOST_PIVOTS):
        store(W, PIVOTS, s, -1.0)
    for e in range(count):
        for k in range(K):
            store(W, TABLEAU + e, k, load(F, EQUATION + e, 1 + k))
        for j in range(count):
            store(W, TABLEAU + e, K + j, 1.0 if e == j else 0.0)
    most = 0
    for lane in range(LANES):
        most = max(most, choose_pivots(W, lane, count, K))
    for s in range(most):
        constant(F, PIVOT + s, splat(0.0), splat(0.0), S)
        for j in range(count):
            add_scaled(F, PIVOT + s, EQUATION + j, load(W, TABLEAU + s, K + j), S)
        blank(F, PIVOT + s, load(W, PIVOTS, s) + 1.0, S)
    return most


@kernel()
def exclude_by_lengths(F: Forms, W: LaneArray, rows: int, count: int, states: Any, S: Symbols) -> None:
    """Mark as NO_LENGTH the open lanes in which a form that vanishes at solutions has no zero."""
    for e in range(count):
        distance = abs(load(F, rows + e, 0)) - change(F, rows + e, S)
        mark(W, where_less(0.0, distance, splat(1.0), 0.0), states, NO_LENGTH)


@kernel()
def cut(
    F: Forms,
    W: LaneArray,
    C: LaneArray,
    rank: int,
    states: Any,
    notes: Any,
    first: int,
    count: int,
    S: Symbols,
) -> None:
    """Cut the open lanes to what the solved equations allow, where that is useful: they become SMALLER.

    The bounds that are left are written to the data of the notes.
    """
    for lane in range(count):
        for k in range(12):
            notes[first + lane, COLUMNS + 1 + k] = C[0, k, lane]
        notes[first + lane, COLUMNS + DATA] = W[PASSED, TIE, lane]
    for s in range(rank):
        centre, size = load(F, PIVOT + s, 0), change(F, PIVOT + s, S)
        store(W, PASSED, CENTRE_OF, centre)
        store(W, PASSED, CHANGE_OF, size)
        for lane in range(count):
            k = int(W[PIVOTS, s, lane])
            if (states[lane] != OPEN and states[lane] != SMALLER) or k < 0:
                continue
            lo, hi, slope = C[0, 2 * k, lane], C[0, 2 * k + 1, lane], F[PIVOT + s, 1 + k, lane]
            if not (lo < hi and slope > 0.0):
                continue
            c, rest = W[PASSED, CENTRE_OF, lane], W[PASSED, CHANGE_OF, lane] - abs(slope)
            middle, radius = 0.5 * (lo + hi), 0.5 * (hi - lo) / slope
            slack = WIDER * (hi - lo) + ROUNDING * max(abs(lo), abs(hi))
            low = max(lo, middle - radius * (c + rest) - slack) + 0.0
            high = min(hi, middle - radius * (c - rest) + slack) + 0.0
            if low < high and high - low <= USEFUL_CUT * (hi - lo):
                states[lane] = SMALLER
                notes[first + lane, COLUMNS + 1 + 2 * k] = low
                notes[first + lane, COLUMNS + 2 + 2 * k] = high


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
    cut(F, W, C, rank, states, notes, first, count, S)
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
