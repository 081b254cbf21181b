"""Cells and tubes: how far a cell's equilibria are from a tube, and the cells that one tube settles.

For data delta an equilibrium z of a cell differs from a tube's polynomial z~(delta) by an offset. As one
form in the cell's symbols and those of the data it is bounded much better than by the cell's and the tube's
bounds.

Arrays: ``F`` (rows, columns of a form, LANES) forms, ``W`` (rows, columns, LANES) scratch, both with the
rows of ``engine.rows`` and ``mechanics.six_dof.rows``; ``C`` (1, width of a cell, LANES) cells, ``states``
(LANES,) of them; ``S`` the forms' symbols; ``model`` is an ``arrays.Model``, ``tubes`` are ``Tubes``.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr_interval.engine.batch_cells import maximum
from cdpr_interval.engine.rows import BOUNDED, FLAGS, OPEN, SCRATCH, SETTLED
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, load, splat, store, where_less
from cdpr_interval.kernels.rounding import down_lanes, inflate_lanes, up_lanes
from cdpr_interval.kernels.second_order import (
    Forms,
    Symbols,
    add_product,
    bounds,
    close,
    combine2,
    combine6,
    constant,
    largest,
    multiply,
    slope_column,
    widen,
)
from cdpr_interval.mechanics.six_dof.directions import centre_columns, dual_columns
from cdpr_interval.mechanics.six_dof.geometry import middle_and_radius
from cdpr_interval.mechanics.six_dof.rows import (
    COLUMNS,
    DIMENSIONS,
    DUAL,
    LEFT_INVERSE,
    LOAD,
    MOST_TAUT,
    NORM,
    OFFSETS,
    POSITION,
    ROOT_ARM,
    SCALE,
    SHARES,
    WRENCH,
)

Floats = NDArray[np.float64]


class Tubes(NamedTuple):
    """Proved tubes as the cells' kernels see them, one row of each array for a tube; n taut cables.

    For every choice delta of the data at most one zero lies within ``reach`` of the polynomial.
    """

    charts: NDArray[np.int64]
    """(m,)."""
    near: Floats
    """(m, 3, 2) bounds of all u within reach of the polynomial."""
    centres: Floats
    """(m, 6 + n) its values at the middle of the data."""
    slopes: Floats
    """(m, 6 + n, 6) its slopes in the symbols of the data."""
    sways: Floats
    """(m, 6 + n, k) its slopes in the symbols of points and load, k = 0 where these are exact."""
    rests: Floats
    """(m, 6 + n) a bound of its terms of second order."""
    reach: Floats
    """(m, 6 + n)."""


@kernel()
def tube_row(F: Forms, out: int, tubes: Any, k: int, c: int, S: Symbols) -> None:
    """Write component c of tube k's polynomial."""
    constant(F, out, splat(tubes.centres[k, c]), splat(tubes.rests[k, c]), S)
    for datum in range(len(S.data)):
        length = datum < MOST_TAUT
        slope = tubes.slopes[k, c, datum] if length else tubes.sways[k, c, datum - MOST_TAUT]
        store(F, out, slope_column(len(S.noise) + datum, S), splat(slope))
    close(F, out, S)


@kernel()
def rotation_offsets(F: Forms, W: LaneArray, tubes: Any, k: int, C: LaneArray, S: Symbols) -> None:
    """Bound u - u~."""
    one = splat(1.0)
    for c in range(3):
        tube_row(F, SCRATCH + 1, tubes, k, c, S)
        m, r = middle_and_radius(load(C, 0, 2 * c), load(C, 0, 2 * c + 1))
        constant(F, SCRATCH, m, splat(0.0), S)
        store(F, SCRATCH, 1 + c, r)
        close(F, SCRATCH, S)
        combine2(F, SCRATCH, SCRATCH, one, SCRATCH + 1, -one, S)
        lo, hi = bounds(F, SCRATCH, S)
        store(W, OFFSETS, c, lo)
        store(W, OFFSETS + 1, c, hi)


@kernel()
def position_offsets(F: Forms, W: LaneArray, model: Any, tubes: Any, k: int, S: Symbols) -> None:
    """Bound p - p~: s (A_1 - p~) + s x - s r_1 over s >= 1."""
    pivot = model.orders[0, 0]
    least, most = bounds(F, SCALE, S)
    least = maximum(least, splat(1.0))
    one = splat(1.0)
    for c in range(3):
        a, e = model.exits[pivot, c], model.exits_err[pivot, c]
        tube_row(F, SCRATCH + 1, tubes, k, 3 + c, S)
        combine2(F, SCRATCH + 1, POSITION + c, one, SCRATCH + 1, -one, S)
        centre = load(F, SCRATCH + 1, 0) + a
        store(F, SCRATCH + 1, 0, centre)
        # Exit point and its rounding; those of the sum.
        widen(F, SCRATCH + 1, inflate_lanes(splat(e), abs(centre), 4.0), S)
        multiply(F, SCRATCH, SCALE, SCRATCH + 1, 1.0, S)
        combine2(F, SCRATCH, SCRATCH, one, ROOT_ARM + c, -one, S)
        lo, hi = bounds(F, SCRATCH, S)
        lo = down_lanes(lo / where_less(lo, 0.0, least, most))
        hi = up_lanes(hi / where_less(0.0, hi, least, most))
        if model.planar and c == 1:
            lo, hi = splat(0.0), splat(0.0)
        store(W, OFFSETS, 3 + c, lo)
        store(W, OFFSETS + 1, 3 + c, hi)


@kernel()
def tension_offsets(F: Forms, W: LaneArray, model: Any, tubes: Any, k: int, S: Symbols) -> Lanes:
    """Bound t - t~; 1 where that succeeds.

    With B a float left inverse of the wrenches at the centre, as in ``balance.tension_bounds``,
    t - t~ = -B (w_0 + W t~) + (I - B W)(t - t~).
    """
    n = model.n_taut
    centre_columns(F, W, n)
    dual_columns(W, n)
    for i in range(n):
        for q in range(6):
            store(W, LEFT_INVERSE + i, q, load(W, DUAL + i, q) / load(W, COLUMNS + i, NORM))
    bounded, worst, biggest = splat(1.0), splat(0.0), splat(0.0)
    row = SCRATCH + 2
    for i in range(n):
        combine6(F, row, LOAD, W, LEFT_INVERSE + i, S)
        total = splat(0.0)
        for j in range(n):
            combine6(F, SCRATCH, WRENCH + DIMENSIONS * j, W, LEFT_INVERSE + i, S)
            tube_row(F, SCRATCH + 1, tubes, k, 6 + model.orders[0, j], S)
            add_product(F, row, SCRATCH, SCRATCH + 1, 1.0, S)
            if i == j:
                store(F, SCRATCH, 0, load(F, SCRATCH, 0) - 1.0)
                widen(F, SCRATCH, splat(1e-15), S)
            total += largest(F, SCRATCH, S)
        lo, hi = bounds(F, row, S)
        rest = maximum(-lo, hi)
        share = up_lanes(total * (1.0 + 1e-14))
        store(W, SHARES, i, share)
        store(W, OFFSETS, 6 + i, -hi)
        store(W, OFFSETS + 1, 6 + i, -lo)
        bounded = where_less(share, 0.95, bounded, 0.0)
        bounded = where_less(rest, math.inf, bounded, 0.0)
        worst, biggest = maximum(share, worst), maximum(rest, biggest)
    gain = up_lanes(biggest / down_lanes(1.0 - worst))
    for i in range(n):
        error = up_lanes(load(W, SHARES, i) * gain)
        store(W, OFFSETS, 6 + i, down_lanes(load(W, OFFSETS, 6 + i) - error))
        store(W, OFFSETS + 1, 6 + i, up_lanes(load(W, OFFSETS + 1, 6 + i) + error))
    return bounded


@kernel()
def offsets(F: Forms, W: LaneArray, model: Any, tubes: Any, k: int, C: LaneArray, S: Symbols) -> Lanes:
    """Bound z - z~(delta) in W[OFFSETS], W[OFFSETS + 1] for every equilibrium of the cells, t in their order.

    Returns 1 where that succeeds. Needs ``wrench_rows``. Of six cables t stays out of it.
    """
    rotation_offsets(F, W, tubes, k, C, S)
    position_offsets(F, W, model, tubes, k, S)
    if model.n_taut < MOST_TAUT:
        return tension_offsets(F, W, model, tubes, k, S)
    for j in range(MOST_TAUT):
        store(W, OFFSETS, 6 + j, 0.0)
        store(W, OFFSETS + 1, 6 + j, 0.0)
    return splat(1.0)


@kernel()
def read_offsets(W: LaneArray, lane: int, model: Any, out: Any) -> None:
    """Write the largest offsets of a lane to out (6 + n,), t in the subset's order."""
    for c in range(6):
        out[c] = max(-W[OFFSETS, c, lane], W[OFFSETS + 1, c, lane])
    for j in range(model.n_taut):
        out[6 + model.orders[0, j]] = max(-W[OFFSETS, 6 + j, lane], W[OFFSETS + 1, 6 + j, lane])


@kernel()
def reached(tubes: Any, k: int, c: int, most: float) -> bool:
    """Return True when an offset ``most`` of unknown c is within tube k's reach.

    Unknowns that the reduced problem fixes are the same in all cells and tubes: they have no reach.
    """
    return bool(most <= tubes.reach[k, c] or tubes.reach[k, c] == 0.0)


@kernel()
def within_reach(tubes: Any, k: int, offsets: Any) -> bool:
    """Return True when the offsets (6 + n,) are within tube k's reach."""
    inside = True
    for c in range(offsets.shape[0]):
        inside = inside and reached(tubes, k, c, offsets[c])
    return inside


@kernel()
def lane_within_reach(W: LaneArray, lane: int, model: Any, tubes: Any, k: int) -> bool:
    """Return True when all offsets of a lane are within tube k's reach."""
    inside = True
    for c in range(6 + model.n_taut):
        of = c if c < 6 else 6 + model.orders[0, c - 6]
        inside = inside and reached(tubes, k, of, max(-W[OFFSETS, c, lane], W[OFFSETS + 1, c, lane]))
    return inside


@kernel()
def may_settle(tubes: Any, k: int, cell: Any, chart: int) -> bool:
    """Return True when all u of a cell (width,) in a chart may be within tube k's reach."""
    near = tubes.charts[k] == chart
    for c in range(3):
        near = near and tubes.near[k, c, 0] <= cell[2 * c] and cell[2 * c + 1] <= tubes.near[k, c, 1]
    return bool(near)


@kernel()
def settled_in_tubes(
    F: Forms, W: LaneArray, model: Any, tubes: Any, C: LaneArray, chart: int, states: Any, S: Symbols
) -> None:
    """Mark as SETTLED the open lanes all of whose equilibria are, for each choice, the one of a tube.

    ``chart`` : the cells' column with theirs. Needs ``wrench_rows``.
    """
    for k in range(tubes.charts.shape[0]):
        known = False
        for lane in range(LANES):
            if states[lane] != OPEN or not may_settle(tubes, k, C[0, :, lane], int(C[0, chart, lane])):
                continue
            if not known:
                store(W, FLAGS, BOUNDED, offsets(F, W, model, tubes, k, C, S))
                known = True
            if W[FLAGS, BOUNDED, lane] > 0.0 and lane_within_reach(W, lane, model, tubes, k):
                states[lane] = SETTLED
