"""Cells of positions at which the energy of a point mass on springs may be least, compiled.

Arrays: ``context`` is ``(cables, load, smallest, low, ceiling)``: ``cables`` is an ``arrays.Cables`` of m
elastic ones; ``load`` (3, 2); ``smallest`` the smallest width; ``low`` (3,) is a point at which their elastic
energy is at most ``ceiling``. ``exits`` (m, 3, 2); ``box`` (3, 2) of positions; ``cell`` (WIDTH,),
``children`` (>= 2, WIDTH), see `solvers.point_mass.cell_rows`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.engine.depth_first import depth_first
from cdpr_interval.kernels.interval import add, mid, mig, mul, sqr, sub
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.kernels.rounding import down, up
from solvers.point_mass.balance import form
from solvers.point_mass.cell_rows import box_of, halve, keep, widest
from solvers.point_mass.fields import distance
from solvers.point_mass.gradient import gradient_bounds, multiplier


@entry()
def shave(exits: Any, c: int, shortest: float, longest: float, box: Any) -> bool:
    """Contract a box to the points with shortest <= |p - A_c| <= longest; False where none is left.

    Guarantee: no such point of the box is lost.
    """
    square = np.empty((3, 2))
    for j in range(3):
        lo, hi = sub(box[j, 0], box[j, 1], exits[c, j, 0], exits[c, j, 1])
        square[j, 0], square[j, 1] = sqr(lo, hi)
    for j in range(3):
        a, b = (j + 1) % 3, (j + 2) % 3
        rest_lo = down(square[a, 0] + square[b, 0])
        rest_hi = up(square[a, 1] + square[b, 1])
        room = up(up(longest * longest) - rest_lo)
        if room < 0.0:
            return False
        r = up(math.sqrt(room))
        box[j, 0] = max(box[j, 0], down(exits[c, j, 0] - r))
        box[j, 1] = min(box[j, 1], up(exits[c, j, 1] + r))
        hole = down(down(shortest * shortest) - rest_hi)
        if hole > 0.0:
            r = down(math.sqrt(hole))
            low, high = up(exits[c, j, 1] - r), down(exits[c, j, 0] + r)
            # Points with low < p_j < high are too near.
            if box[j, 0] > low:
                box[j, 0] = max(box[j, 0], high)
            if box[j, 1] < high:
                box[j, 1] = min(box[j, 1], low)
        if not box[j, 0] <= box[j, 1]:
            return False
        lo, hi = sub(box[j, 0], box[j, 1], exits[c, j, 0], exits[c, j, 1])
        square[j, 0], square[j, 1] = sqr(lo, hi)
    return True


@entry()
def pushed(cables: Any, load: Any, box: Any) -> bool:
    """Prove that the gradient of the energy of elastic cables vanishes nowhere in a cell."""
    value = np.empty((3, 2))
    point = np.empty((3, 2))
    gradient_bounds(cables, load, box, value)
    for j in range(3):
        if mig(value[j, 0], value[j, 1]) > 0.0:
            return True
        point[j, 0] = mid(box[j, 0], box[j, 1])
        point[j, 1] = point[j, 0]
    gradient_bounds(cables, load, point, value)
    y = np.empty(3)
    for j in range(3):
        y[j] = mid(value[j, 0], value[j, 1])
    slo, shi = form(y, load[:, 0], load[:, 1])
    slo, shi = -shi, -slo
    exits = cables[1]
    lo3, hi3 = np.empty(3), np.empty(3)
    for c in range(exits.shape[0]):
        tlo, thi, _, _ = multiplier(cables, c, box)
        for j in range(3):
            lo3[j], hi3[j] = sub(box[j, 0], box[j, 1], exits[c, j, 0], exits[c, j, 1])
        lo, hi = form(y, lo3, hi3)
        lo, hi = mul(tlo, thi, lo, hi)
        slo, shi = add(slo, shi, lo, hi)
    return mig(slo, shi) > 0.0


@entry()
def affordable(cables: Any, load: Any, exact: bool, low: Any, ceiling: float, box: Any) -> bool:
    """Contract a cell to the points whose energy is not above that of ``low``; False where none is left.

    At the minimum p the elastic energy is at most ceiling + f . (p - low) =: room. So room is not negative,
    the sum of k_i / 2 (|p - A_i| - l_i)^2 over the taut cables is at most room, and so is each term.
    """
    _, exits, lengths, k, _ = cables
    room = ceiling
    for j in range(3):
        lo, hi = sub(box[j, 0], box[j, 1], low[j], low[j])
        room = up(room + mul(load[j, 0], load[j, 1], lo, hi)[1])
    if room < 0.0:
        return False
    spent = 0.0
    for c in range(lengths.shape[0]):
        excess = down(distance(exits, c, box)[0] - lengths[c, 1])
        if excess > 0.0:
            spent = down(spent + down(down(0.5 * k[c, 0] * excess) * excess))
    if spent > room:
        return False
    for c in range(lengths.shape[0]):
        if not k[c, 0] > 0.0:
            continue
        longest = up(lengths[c, 1] + up(math.sqrt(up(up(2.0 * room) / k[c, 0]))))
        if not shave(exits, c, lengths[c, 0] if exact else 0.0, longest, box):
            return False
    return True


@entry()
def process(context: Any, cell: Any, children: Any) -> int:
    """Decide one cell, see `cdpr_interval.engine.depth_first`."""
    cables, load, smallest, low, ceiling = context
    box = np.empty((3, 2))
    box_of(cell, box)
    if not affordable(cables, load, False, low, ceiling, box) or pushed(cables, load, box):
        return 0
    keep(box, cell, children[0])
    return halve(box, widest(box), smallest, children)


@entry()
def run_cells(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Explore cells depth first, see `cdpr_interval.engine.depth_first.depth_first`."""
    return depth_first(process, context, stack, count, leaves, kinds, children, cell_limit)
