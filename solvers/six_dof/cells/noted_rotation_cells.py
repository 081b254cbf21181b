"""The search in u with notes of what becomes of its cells: an observer of ``rotation_cells``.

It notes the fates for which certificates have a rule. What the solver does beyond them (contraction by
statics, roots' boxes in position and tensions) is not noted; see ``certified_rotation_cells``.

Arrays: as in ``cells.tests``; ``notes`` (rows, COLUMNS + 1 + DATA), those of the batch from ``first``;
``context`` is a ``noted.Noted``.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.engine.batches import batches
from cdpr_interval.engine.notes import HAND_ON, SIDES, UNNOTED, begin_notes, halved_in
from cdpr_interval.engine.rows import (
    BOTH,
    FLAGS,
    FOLDED,
    NEEDED,
    NO_LENGTH,
    NO_POSITION,
    NOT_SLACK,
    PIVOTS,
    SCRATCH,
    UNBALANCED,
)
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, load, store
from cdpr_interval.kernels.second_order import Forms, Symbols, bounds
from cdpr_interval.mechanics.six_dof.balance import balance_free
from cdpr_interval.mechanics.six_dof.directions import centre_columns
from cdpr_interval.mechanics.six_dof.geometry import cable_rows, length_row
from cdpr_interval.mechanics.six_dof.rows import MOST_TAUT, PASSED, SLACK_CABLE, U_SYMBOLS, Y
from solvers.six_dof.cells import rotation_cells as turn

COLUMNS = 8
"""Of a cell that are noted: all but its share."""
DATA = 7
"""Columns of data: y, the cable that is too long, or the bounds of u that are left and whether the
checker may choose other pivots."""


@kernel()
def note_cables(
    F: Forms, W: LaneArray, model: Any, count: int, states: Any, notes: Any, first: int, S: Symbols
) -> None:
    """Note for every lane that is NOT_SLACK the cable that is too long by the largest bound."""
    for lane in range(count):
        if states[lane] == NOT_SLACK:
            notes[first + lane, COLUMNS + 2] = 0.0
    for i in range(model.n_taut, model.lengths.shape[0]):
        cable_rows(F, SLACK_CABLE, model, i, model.orders[0, 0], S)
        length_row(F, SCRATCH, SLACK_CABLE, S)
        below, _ = bounds(F, SCRATCH, S)
        store(W, PASSED, 0, below)
        for lane in range(count):
            row = first + lane
            if states[lane] == NOT_SLACK and W[PASSED, 0, lane] > notes[row, COLUMNS + 2]:
                notes[row, COLUMNS + 1], notes[row, COLUMNS + 2] = i, W[PASSED, 0, lane]


@kernel()
def alone(W: LaneArray, lane: int) -> Lanes:
    """Return 1 in one lane, 0 in the others: what is tried for it does not depend on its neighbours."""
    for k in range(LANES):
        W[FLAGS, NEEDED, k] = 1.0 if k == lane else 0.0
    return load(W, FLAGS, NEEDED)


@kernel()
def note_directions(
    F: Forms, W: LaneArray, model: Any, count: int, states: Any, notes: Any, first: int, S: Symbols
) -> None:
    """Note for every lane that is UNBALANCED a direction y: it is found anew, lane by lane."""
    rank = 0
    for lane in range(LANES):
        for s in range(MOST_TAUT):
            if W[PIVOTS, s, lane] >= 0.0:
                rank = max(rank, s + 1)
    for lane in range(count):
        if states[lane] == UNBALANCED:
            centre_columns(F, W, model.n_taut)
            balance_free(F, W, model.n_taut, rank, alone(W, lane), S)
            for k in range(6):
                notes[first + lane, COLUMNS + 1 + k] = W[Y, k, lane]


@kernel()
def note_fates(context: Any, count: int, children: Any) -> None:
    """Add the fates to the notes of a batch; the context is a ``noted.Noted`` or a ``noted.Certified``."""
    model, notes, noted = context.model, context.notes, context.noted
    S, F, W, C, states, verdicts = context.scratch
    first = noted[0]
    too_long, unbalanced = False, False
    for lane in range(count):
        note, state, fate = notes[first + lane], states[lane], UNNOTED
        if state in (NO_POSITION, NO_LENGTH, NOT_SLACK, UNBALANCED):
            fate = state
        elif state == BOTH:
            fate = SIDES
        elif verdicts[lane] == -FOLDED:
            fate = HAND_ON
        elif verdicts[lane] == 2:
            fate = halved_in(C, note, lane, U_SYMBOLS, children)
        note[COLUMNS] = fate
        too_long = too_long or state == NOT_SLACK
        unbalanced = unbalanced or state == UNBALANCED
    if too_long:
        note_cables(F, W, model, count, states, notes, first, S)
    if unbalanced:
        note_directions(F, W, model, count, states, notes, first, S)
    noted[0] = first + count


@kernel(inline="always")
def process(context: Any, count: int, children: Any) -> None:
    """Look at a batch as the search does, and take notes; see ``engine.batches``."""
    begin_notes(context.scratch.cells, count, context.notes, context.noted, COLUMNS)
    turn.process(context.search, count, children)
    note_fates(context, count, children)


@entry()
def run(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Search cells in u depth first and take notes; see ``engine.batches`` and ``engine.notes``."""
    return batches(process, context, stack, count, leaves, kinds, children, cell_limit)
