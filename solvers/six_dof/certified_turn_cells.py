"""Cells in u, searched by the rules of a certificate alone, with notes of what becomes of them.

A cell is excluded for a reason that a certificate can name, settled by a root's box in (u, x), handed on, or
halved: no contraction. Nothing here needs to be rigorous, as what is noted is checked.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from cdpr_interval.engine.batch_cells import OPEN, SETTLED, SMALL, halve, is_empty, leaf
from cdpr_interval.engine.batches import batches
from cdpr_interval.engine.contraction import EMPTY
from cdpr_interval.engine.notes import IN_BOX, UNDECIDED, begin_notes
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, store
from cdpr_interval.kernels.second_order import Forms, Symbols, bounds
from cdpr_interval.mechanics.six_dof.geometry import POSITION
from solvers.six_dof import rotation_cells as turn
from solvers.six_dof.noted_turn_cells import COLUMNS, PLACE, note_fates


@kernel()
def settle_by_boxes(
    F: Forms, W: LaneArray, model: Any, boxes: Any, C: LaneArray, states: Any, S: Symbols
) -> None:
    """Mark as SETTLED the open lanes that lie in a root's box, the position too.

    ``boxes`` : (m, 13), chart, then lo and hi of (u, x). ``states`` : (LANES,).
    """
    for k in range(3):
        lo, hi = bounds(F, POSITION + k, S)
        store(W, PLACE, k, lo)
        store(W, PLACE + 1, k, hi)
    for lane in range(LANES):
        if model.planar:
            W[PLACE, 1, lane], W[PLACE + 1, 1, lane] = 0.0, 0.0
        for i in range(boxes.shape[0]):
            inside = states[lane] == OPEN and boxes[i, 0] == C[0, turn.CHART, lane]
            for k in range(3):
                inside = inside and boxes[i, 1 + 2 * k] <= C[0, 2 * k, lane]
                inside = inside and C[0, 2 * k + 1, lane] <= boxes[i, 2 + 2 * k]
                inside = inside and boxes[i, 7 + 2 * k] <= W[PLACE, k, lane]
                inside = inside and W[PLACE + 1, k, lane] <= boxes[i, 8 + 2 * k]
            if inside:
                states[lane] = SETTLED


@kernel()
def verdict(C: LaneArray, lane: int, state: int, children: Any, smallest: float) -> int:
    """Write a lane's children or leaf; see ``engine.batches``. ``children`` : (2 LANES, width)."""
    width = turn.width_of(C, lane)
    if is_empty(state):
        return 0
    if state == turn.BOTH:
        return int(turn.both_branches(C, lane, children))
    if state == turn.UNSMOOTH and width <= turn.FOLD_WIDTH:
        return int(leaf(C, lane, children, turn.FOLDED))
    if width < smallest:
        return int(leaf(C, lane, children, SMALL))
    return int(halve(C, lane, children, 2 * turn.widest(C, lane)))


@kernel(inline="always")
def process(context: Any, C: LaneArray, count: int, verdicts: Any, children: Any) -> None:
    """Exclude, settle or split a batch of cells, and take notes; see ``engine.batches``."""
    model, boxes, smallest, S, F, W, states, notes, noted = context
    begin_notes(C, count, notes, noted, COLUMNS)
    for lane in range(LANES):
        states[lane] = OPEN if lane < count else EMPTY
    turn.exclude(F, W, model, C, states, S)
    settle_by_boxes(F, W, model, boxes, C, states, S)
    for lane in range(count):
        verdicts[lane] = verdict(C, lane, states[lane], children, smallest)
    note_fates(F, W, model, C, count, states, verdicts, children, notes, noted, S)
    for lane in range(count):
        if states[lane] == SETTLED:
            notes[noted[0] - count + lane, COLUMNS] = IN_BOX
        elif verdicts[lane] == -SMALL:
            notes[noted[0] - count + lane, COLUMNS] = UNDECIDED


@njit(cache=True, nogil=True)
def run(
    model: Any,
    boxes: Any,
    smallest: float,
    S: Symbols,
    F: Forms,
    W: LaneArray,
    C: LaneArray,
    states: Any,
    verdicts: Any,
    notes: Any,
    noted: Any,
    stack: Any,
    count: int,
    leaves: Any,
    kinds: Any,
    children: Any,
    cell_limit: int,
) -> tuple[int, int, int]:
    """Search cells in u depth first; see ``engine.batches`` and ``engine.notes``."""
    context = (model, boxes, smallest, S, F, W, states, notes, noted)
    return batches(process, context, C, verdicts, stack, count, leaves, kinds, children, cell_limit)
