"""One cell at a time, with the reason why it holds no equilibrium: for the search tree of a certificate.

Arrays: ``F``, ``W`` and ``C`` as in ``cell_tests``; ``scratch`` is a ``Scratch``, ``model`` an
``arrays.Model``, ``cell`` (width,), ``y`` (6,) the direction tried last, ``place`` (3, 2) the bounds of x.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from cdpr_interval.engine.batch_cells import fill_lanes, open_first
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, store
from cdpr_interval.kernels.second_order import Forms, Symbols, bounds
from cdpr_interval.mechanics.six_dof.rows import DIMENSIONS, PLACE, POSITION, Y
from solvers.six_dof import rotation_cells as turn


@kernel()
def report(F: Forms, W: LaneArray, y: Any, place: Any, S: Symbols) -> None:
    """Write the direction y tried last and the bounds of x."""
    for k in range(DIMENSIONS):
        y[k] = W[Y, k, 0]
    for k in range(3):
        lo, hi = bounds(F, POSITION + k, S)
        store(W, PLACE, 0, lo)
        store(W, PLACE, 1, hi)
        place[k, 0], place[k, 1] = W[PLACE, 0, 0], W[PLACE, 1, 0]


@njit(cache=True, nogil=True)
def look_turn(scratch: Any, model: Any, cell: Any, y: Any, place: Any) -> int:
    """Return the state of a cell in u."""
    S, F, W, C, states, _ = scratch
    fill_lanes(C, cell)
    open_first(states, LANES)
    turn.exclude(F, W, model, C, states, S)
    report(F, W, y, place, S)
    return int(states[0])
