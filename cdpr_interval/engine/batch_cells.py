"""The lanes of a batch: what is known of each cell so far, and the children it leaves.

Arrays: ``F`` (rows, columns of a form, LANES) forms, ``W`` (rows, columns, LANES) scratch, both with the
rows of ``engine.rows``; ``C`` (1, width of a cell, LANES) cells; ``states`` (LANES,); ``children`` (2
LANES, width).
"""

from __future__ import annotations

from typing import Any

from numba import types

from cdpr_interval.engine.contraction import contract, contraction_signatures
from cdpr_interval.engine.rows import (
    COVERED,
    EMPTY,
    FLAGS,
    MARKED,
    NEEDED,
    NO_POSITION,
    OPEN,
    SMALL,
    VERDICTS,
)
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, array3, lanes, load, store, where_less
from cdpr_interval.kernels.second_order import Forms, Symbols

STATES = types.Array(types.int64, 1, "C")


@kernel("b1(i8)")
def is_empty(state: int) -> bool:
    """Return True for the states of lanes that hold no equilibrium but those of known roots."""
    return state == EMPTY or state >= NO_POSITION


@kernel(lanes(lanes, lanes))
def maximum(a: Lanes, b: Lanes) -> Lanes:
    """Return the larger one; ``b`` where one is NaN."""
    return where_less(b, a, a, b)


@kernel(types.boolean(array3, lanes, lanes))
def covers(W: LaneArray, flags: Lanes, needed: Lanes) -> bool:
    """Return True when ``flags`` is positive in every lane where ``needed`` is."""
    store(W, FLAGS, COVERED, where_less(0.0, needed, flags, 1.0))
    result = True
    for lane in range(LANES):
        result = result and W[FLAGS, COVERED, lane] > 0.0
    return result


@kernel(types.boolean(array3, lanes, STATES, types.int64))
def mark(W: LaneArray, flags: Lanes, states: Any, state: int) -> bool:
    """Give open lanes with flags > 0 a state; return True when a lane is still open."""
    store(W, FLAGS, MARKED, flags)
    left = False
    for lane in range(LANES):
        if states[lane] == OPEN and W[FLAGS, MARKED, lane] > 0.0:
            states[lane] = state
        left = left or states[lane] == OPEN
    return left


@kernel(lanes(array3, STATES))
def open_lanes(W: LaneArray, states: Any) -> Lanes:
    """Return 1 in the open lanes, 0 in the others."""
    for lane in range(LANES):
        W[FLAGS, NEEDED, lane] = 1.0 if states[lane] == OPEN else 0.0
    return load(W, FLAGS, NEEDED)


@kernel(types.void(STATES, types.int64))
def open_first(states: Any, count: int) -> None:
    """Open the first ``count`` lanes; the others hold no cell."""
    for lane in range(LANES):
        states[lane] = OPEN if lane < count else EMPTY


@kernel(types.boolean(STATES))
def any_open(states: Any) -> bool:
    """Return True when something is still to be found out of a lane."""
    left = False
    for lane in range(LANES):
        left = left or states[lane] == OPEN
    return left


@kernel()
def fill_lanes(C: LaneArray, cell: Any) -> None:
    """Put one cell (width,) in every lane."""
    for k in range(cell.shape[0]):
        store(C, 0, k, cell[k])


@kernel()
def copy_cell(C: LaneArray, lane: int, children: Any) -> int:
    """Write a cell as its own only child."""
    for k in range(children.shape[1]):
        children[2 * lane, k] = C[0, k, lane]
    return 1


@kernel()
def leaf(C: LaneArray, lane: int, children: Any, kind: int) -> int:
    """Return a cell as a leaf."""
    copy_cell(C, lane, children)
    return -kind


@kernel()
def twins(C: LaneArray, lane: int, children: Any) -> int:
    """Write a cell as two children, each with half its share."""
    width = children.shape[1]
    for i in range(2):
        for k in range(width):
            children[2 * lane + i, k] = C[0, k, lane]
        children[2 * lane + i, width - 1] = 0.5 * C[0, width - 1, lane]
    return 2


@kernel()
def halve(C: LaneArray, lane: int, children: Any, lo: int) -> int:
    """Bisect the variable whose bounds stand at ``lo, lo + 1``; a leaf where no double lies between them."""
    m = 0.5 * (C[0, lo, lane] + C[0, lo + 1, lane])
    if not C[0, lo, lane] < m < C[0, lo + 1, lane]:
        return leaf(C, lane, children, SMALL)
    twins(C, lane, children)
    children[2 * lane, lo + 1] = m
    children[2 * lane + 1, lo] = m
    return 2


@kernel(contraction_signatures(array3, array3, STATES, types.int64))
def contract_open(
    F: Forms, W: LaneArray, C: LaneArray, states: Any, equations: int, V: Symbols, S: Symbols
) -> None:
    """Contract the open lanes; their states become EMPTY or SMALLER, or stay. Others keep their cells."""
    for lane in range(LANES):
        # A lane that counts as empty is left alone.
        W[VERDICTS, 0, lane] = OPEN if states[lane] == OPEN else EMPTY
    contract(F, W, C, equations, V, S)
    for lane in range(LANES):
        if states[lane] == OPEN:
            states[lane] = int(W[VERDICTS, 0, lane])
