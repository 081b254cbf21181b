"""One cell at a time, with the reason why it holds no equilibrium: for the search tree of a certificate."""

from __future__ import annotations

from typing import Any

from numba import njit

from cdpr_interval.engine.batch_cells import OPEN
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, store
from cdpr_interval.kernels.second_order import Forms, Symbols, bounds
from cdpr_interval.mechanics.six_dof.directions import Y
from cdpr_interval.mechanics.six_dof.geometry import POSITION
from solvers.six_dof import pose_cells as pose
from solvers.six_dof import rotation_cells as turn

PLACE = 52
"""Row of W that passes the bounds of x."""


@kernel()
def fill(C: LaneArray, cell: Any, states: Any) -> None:
    """Put one cell in every lane."""
    for k in range(cell.shape[0]):
        store(C, 0, k, cell[k])
    for lane in range(LANES):
        states[lane] = OPEN


@kernel()
def report(F: Forms, W: LaneArray, y: Any, place: Any, S: Symbols) -> None:
    """Write the direction y tried last (6,) and the bounds of x (3, 2)."""
    for k in range(6):
        y[k] = W[Y, k, 0]
    for k in range(3):
        lo, hi = bounds(F, POSITION + k, S)
        store(W, PLACE, 0, lo)
        store(W, PLACE, 1, hi)
        place[k, 0], place[k, 1] = W[PLACE, 0, 0], W[PLACE, 1, 0]


@njit(cache=True, nogil=True)
def look_turn(
    model: Any, S: Symbols, F: Forms, W: LaneArray, C: LaneArray, states: Any, cell: Any, y: Any, place: Any
) -> int:
    """Return the state of a cell in u."""
    fill(C, cell, states)
    turn.exclude(F, W, model, C, states, S)
    report(F, W, y, place, S)
    return int(states[0])


@njit(cache=True, nogil=True)
def look_pose(
    model: Any, S: Symbols, F: Forms, W: LaneArray, C: LaneArray, states: Any, cell: Any, y: Any, place: Any
) -> int:
    """Return the state of a cell in (u, x); SMALLER: ``cell`` was cut by the lengths."""
    fill(C, cell, states)
    pose.exclude(F, W, model, C, states, S)
    report(F, W, y, place, S)
    for k in range(2 * pose.VARIABLES):
        cell[k] = C[0, k, 0]
    return int(states[0])
