"""Cells in which only cables at the centre of mass can have tension: their poses are a smaller subset's.

Taut cables off the centre of mass have no moment about it together. Where their moments are linearly
independent all their tensions vanish, so that the platform hangs by the others and may turn about its centre
of mass: a continuum no search would end in, and none of this subset's poses.

Arrays: ``F`` (rows, columns of a form, LANES) forms, ``W`` (rows, columns, LANES) scratch, both with the
rows of ``rows``; ``S`` the forms' symbols; ``model`` is an ``arrays.Model``.
"""

from __future__ import annotations

from typing import Any

from cdpr_interval.engine.contraction import reduce_row
from cdpr_interval.engine.rows import SCRATCH
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray, Lanes, load, root, splat, store, where_less
from cdpr_interval.kernels.rounding import up_lanes
from cdpr_interval.kernels.second_order import Forms, Symbols, combine6, largest, widen
from cdpr_interval.mechanics.six_dof.directions import dual_columns
from cdpr_interval.mechanics.six_dof.rows import COLUMNS, DIMENSIONS, DUAL, LEFT_INVERSE, NORM, WRENCH

REGULAR = 0.95
"""Least row sum of |I - C M| that proves nothing."""


@kernel()
def is_outer(model: Any, i: int) -> bool:
    """Return True for a cable off the centre of mass."""
    outer = False
    for k in range(3):
        outer = outer or model.arms[0, i, k] != 0.0 or model.arms_err[i, k] != 0.0
    return bool(outer)


@kernel()
def outer_columns(F: Forms, W: LaneArray, model: Any) -> int:
    """Write the centre's moments of the outer cables, normalised, as columns; return how many."""
    count = 0
    for j in range(model.n_taut):
        if not is_outer(model, model.orders[0, j]):
            continue
        row = WRENCH + DIMENSIONS * j + 3
        total = splat(0.0)
        for k in range(3):
            total += load(F, row + k, 0) * load(F, row + k, 0)
        norm = root(total)
        store(W, COLUMNS + count, NORM, norm)
        for k in range(3):
            store(W, COLUMNS + count, k, 0.0)
            store(W, COLUMNS + count, 3 + k, load(F, row + k, 0) / norm)
        count += 1
    return count


@kernel()
def unloaded(F: Forms, W: LaneArray, model: Any, rank: int, S: Symbols) -> Lanes:
    """Return 1 where no equilibrium in the cell has tension in a cable off the centre of mass, else 0.

    Needs ``wrench_rows`` with a pivot at the centre of mass, so that moments are about it.

    Guarantee: with M the outer cables' moments and C a float left inverse at the centre, |I - C M| < 1 over
    the cell (row sums) shows that M has full column rank at every solution, so M t = 0 leaves t = 0 only.
    The rows PIVOT.. vanish at every solution and may be added.
    """
    count = outer_columns(F, W, model)
    dual_columns(W, count)
    for a in range(count):
        for k in range(6):
            store(W, LEFT_INVERSE + a, k, load(W, DUAL + a, k) / load(W, COLUMNS + a, NORM))
    proved = splat(1.0)
    for a in range(count):
        total, b = splat(0.0), 0
        for j in range(model.n_taut):
            if not is_outer(model, model.orders[0, j]):
                continue
            combine6(F, SCRATCH, WRENCH + DIMENSIONS * j, W, LEFT_INVERSE + a, S)
            if a == b:
                store(F, SCRATCH, 0, load(F, SCRATCH, 0) - 1.0)
                widen(F, SCRATCH, splat(1e-15), S)
            reduce_row(F, SCRATCH, W, rank, S)
            total += largest(F, SCRATCH, S)
            b += 1
        proved = where_less(up_lanes(total * (1.0 + 1e-14)), REGULAR, proved, 0.0)
    return proved
