"""Bounds of position and tensions over cells, the roots that settle a cell, cables too long to be slack.

Arrays: ``F`` (rows, columns of a form, LANES) forms, ``W`` (rows, columns, LANES) scratch, both with the
rows of ``engine.rows`` and ``mechanics.six_dof.rows``; ``C`` (1, width of a cell, LANES) cells, ``states``
(LANES,) of them; ``S`` the forms' symbols; ``model`` is an ``arrays.Model``; ``roots`` (m, 1 + 2 (6 + n))
holds chart, lo and hi of the uniqueness boxes of roots, ``lo, hi`` (6 + n,) bounds of (u, p, t).
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.engine.batch_cells import covers, maximum
from cdpr_interval.engine.rows import BOUNDED, FLAGS, OPEN, SCRATCH, SETTLED
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, load, splat, store, where_less
from cdpr_interval.kernels.rounding import down_lanes, inflate_lanes, up_lanes
from cdpr_interval.kernels.second_order import Forms, Symbols, bounds, combine2
from cdpr_interval.mechanics.six_dof.balance import tension_bounds
from cdpr_interval.mechanics.six_dof.geometry import cable_rows, length_row, wrench_rows
from cdpr_interval.mechanics.six_dof.rows import (
    BOUNDS,
    MOST_TAUT,
    ROOT_ARM,
    SCALE,
    SLACK_CABLE,
    TENSIONS,
    WRENCH,
)


@kernel()
def slack_excluded(F: Forms, W: LaneArray, model: Any, needed: Lanes, S: Symbols) -> Lanes:
    """Return 1 where a cable outside the subset would be too long over the whole cell, else 0."""
    block = SLACK_CABLE
    excluded = splat(0.0)
    for i in range(model.n_taut, model.lengths.shape[0]):
        cable_rows(F, block, model, i, model.orders[0, 0], S)
        length_row(F, SCRATCH, block, S)
        below, _ = bounds(F, SCRATCH, S)
        excluded = where_less(0.0, below, 1.0, excluded)
        if covers(W, excluded, needed):
            break
    return excluded


@kernel()
def position_bounds(F: Forms, W: LaneArray, model: Any, S: Symbols) -> None:
    """Enclose p = A_1 + x - r_1 over the cells in W[BOUNDS], W[BOUNDS + 1]. Needs ``wrench_rows``.

    s (p - p~) is a form around zero for a float p~, and s >= 1.
    """
    pivot = model.orders[0, 0]
    least, most = bounds(F, SCALE, S)
    least = maximum(least, splat(1.0))
    one = splat(1.0)
    for k in range(3):
        a, e = model.exits[pivot, k], model.exits_err[pivot, k]
        middle = a - (load(F, WRENCH + k, 0) + load(F, ROOT_ARM + k, 0)) / load(F, SCALE, 0)
        offset = a - middle
        # s (x + (a - p~) - r_1); WRENCH holds -s x.
        combine2(F, SCRATCH, SCALE, offset, WRENCH + k, -one, S)
        combine2(F, SCRATCH, SCRATCH, one, ROOT_ARM + k, -one, S)
        below, above = bounds(F, SCRATCH, S)
        below = down_lanes(below / where_less(below, 0.0, least, most))
        above = up_lanes(above / where_less(0.0, above, least, most))
        # The rounding of a - p~ is an error of p.
        error = inflate_lanes(splat(e), abs(offset), 4.0)
        store(W, BOUNDS, k, down_lanes(down_lanes(middle + below) - error))
        store(W, BOUNDS + 1, k, up_lanes(up_lanes(middle + above) + error))
    if model.planar:
        # The equilibrium lies in the plane exactly (and the root's box has no width across it).
        store(W, BOUNDS, 1, 0.0)
        store(W, BOUNDS + 1, 1, 0.0)


@kernel()
def solution_bounds(F: Forms, W: LaneArray, model: Any, S: Symbols) -> Lanes:
    """Enclose p and t of every equilibrium of the taut cables in W[BOUNDS], W[TENSIONS].

    Returns 1 where t is bounded. Six lengths alone fix the pose: t is not an unknown then and stands as 0 in
    the roots. Needs ``wrench_rows``.
    """
    position_bounds(F, W, model, S)
    if model.n_taut < MOST_TAUT:
        return tension_bounds(F, W, model.n_taut, S)
    for i in range(MOST_TAUT):
        store(W, TENSIONS, i, 0.0)
        store(W, TENSIONS + 1, i, 0.0)
    return splat(1.0)


@kernel()
def read_bounds(W: LaneArray, C: LaneArray, lane: int, model: Any, lo: Any, hi: Any) -> None:
    """Write one lane's bounds of (u, p, t), t in the subset's order."""
    for k in range(3):
        lo[k], hi[k] = C[0, 2 * k, lane], C[0, 2 * k + 1, lane]
        lo[3 + k], hi[3 + k] = W[BOUNDS, k, lane], W[BOUNDS + 1, k, lane]
    for j in range(lo.shape[0] - 6):
        i = model.orders[0, j]
        lo[6 + i], hi[6 + i] = W[TENSIONS, j, lane], W[TENSIONS + 1, j, lane]


@kernel()
def bound_cell(F: Forms, W: LaneArray, model: Any, C: LaneArray, lo: Any, hi: Any, S: Symbols) -> Lanes:
    """Write the first lane's bounds of (u, p, t), or of (u, p) where ``lo, hi`` have six entries.

    Returns 1 where all of them are bounded. Needs the blocks and x.
    """
    wrench_rows(F, model, S)
    bounded = splat(1.0)
    if lo.shape[0] == 6:
        position_bounds(F, W, model, S)
    else:
        bounded = solution_bounds(F, W, model, S)
    read_bounds(W, C, 0, model, lo, hi)
    return bounded


@kernel()
def near_root(roots: Any, k: int, C: LaneArray, lane: int, chart: int, size: int) -> bool:
    """Return True when a lane's u lies in the uniqueness box of root ``k``, in its chart."""
    near = roots[k, 0] == C[0, chart, lane]
    for c in range(3):
        near = near and roots[k, 1 + c] <= C[0, 2 * c, lane]
        near = near and C[0, 2 * c + 1, lane] <= roots[k, 1 + size + c]
    return bool(near)


@kernel()
def settled(
    F: Forms, W: LaneArray, model: Any, roots: Any, C: LaneArray, chart: int, states: Any, S: Symbols
) -> None:
    """Mark as SETTLED the open lanes all of whose equilibria lie in one root's uniqueness box.

    ``roots`` : (m, 1 + 2 (6 + n)) chart, then lo and hi of the boxes. ``chart`` : the cells'
    column with theirs. Needs ``wrench_rows``.
    """
    size = 6 + model.n_taut
    bounded = False
    for k in range(roots.shape[0]):
        for lane in range(LANES):
            if states[lane] != OPEN or not near_root(roots, k, C, lane, chart, size):
                continue
            if not bounded:
                store(W, FLAGS, BOUNDED, solution_bounds(F, W, model, S))
                bounded = True
            inside = W[FLAGS, BOUNDED, lane] > 0.0
            for c in range(3):
                inside = inside and roots[k, 4 + c] <= W[BOUNDS, c, lane]
                inside = inside and W[BOUNDS + 1, c, lane] <= roots[k, 4 + size + c]
            for j in range(model.n_taut):
                i = model.orders[0, j]
                inside = inside and roots[k, 7 + i] <= W[TENSIONS, j, lane]
                inside = inside and W[TENSIONS + 1, j, lane] <= roots[k, 7 + size + i]
            if inside:
                states[lane] = SETTLED
