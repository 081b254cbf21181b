"""The lanes of a batch: what is known of each cell so far, and the children it leaves."""

from __future__ import annotations

from typing import Any

from cdpr_interval.engine.contraction import EMPTY, STUCK, VERDICTS, contract
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, load, store
from cdpr_interval.kernels.second_order import Forms, Symbols

SMALL = 1
"""Leaf kind: the cell is smaller than the leaf size."""
FLAGS = 53
"""Row of W whose last places pass what was proved lane by lane."""
OPEN = STUCK
"""State of a lane about which nothing is known yet; others are EMPTY and SMALLER (its own child)."""
WIDE = 5
"""State of a lane too wide to be contracted."""
NO_POSITION, NO_LENGTH, NOT_SLACK, UNBALANCED, SETTLED, UNLOADED = range(16, 22)
"""States of lanes proved empty, by reason: the triple's spheres have no common point, a taut cable's length
cannot hold, another cable would be too long, no tensions balance the load, all is in one root's box, only
cables at the centre of mass have tension (these poses are a smaller subset's)."""


@kernel()
def is_empty(state: int) -> bool:
    """Return True for the states of lanes that hold no equilibrium but those of known roots."""
    return state == EMPTY or state >= NO_POSITION


@kernel()
def mark(W: LaneArray, flags: Lanes, states: Any, state: int) -> bool:
    """Give open lanes with flags > 0 a state; return True when a lane is still open."""
    store(W, FLAGS, 21, flags)
    left = False
    for lane in range(LANES):
        if states[lane] == OPEN and W[FLAGS, 21, lane] > 0.0:
            states[lane] = state
        left = left or states[lane] == OPEN
    return left


@kernel()
def open_lanes(W: LaneArray, states: Any) -> Lanes:
    """Return 1 in the open lanes, 0 in the others."""
    for lane in range(LANES):
        W[FLAGS, 22, lane] = 1.0 if states[lane] == OPEN else 0.0
    return load(W, FLAGS, 22)


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


@kernel()
def contract_open(
    F: Forms, W: LaneArray, C: LaneArray, equations: int, variables: int, states: Any, S: Symbols
) -> None:
    """Contract the open lanes; their states become EMPTY or SMALLER, or stay. Others keep their cells."""
    for lane in range(LANES):
        # A lane that counts as empty is left alone.
        W[VERDICTS, 0, lane] = STUCK if states[lane] == OPEN else EMPTY
    contract(F, W, C, equations, variables, S)
    for lane in range(LANES):
        if states[lane] == OPEN:
            states[lane] = int(W[VERDICTS, 0, lane])
