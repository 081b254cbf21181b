"""Branch and prune over the positions of a point mass, compiled: what decides one cell.

A cell is a row ``x lo, x hi, y lo, y hi, z lo, z hi, share``. One search belongs to one set of taut cables.

Arrays: ``context`` is ``(cables, others, load, limits, exact, low, ceiling)``: ``cables`` is an
``arrays.Cables`` of the m taut ones, ``others`` is an ``arrays.Cables`` of those that must be slack;
``load`` (3, 2); ``limits`` (2,) the width below which existence is tried, and the smallest width; ``exact``
is true where all given cables must be taut; for elastic cables ``low`` (3,) is a point at which their
elastic energy is at most ``ceiling``. ``exits`` (m, 3, 2); ``box`` (3, 2) of positions; ``x`` (3 + m,) a
position, then multipliers, ``cover`` (3 + m, 2) bounds of these; ``cell`` (WIDTH,), ``children`` (>= 2,
WIDTH).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.engine.depth_first import depth_first
from cdpr_interval.kernels.box import contains, disjoint
from cdpr_interval.kernels.interval import add, mid, mig, mul, sqr, sub
from cdpr_interval.kernels.kernel import entry
from cdpr_interval.kernels.rounding import down, up
from solvers.point_mass.balance import all_cables, form, tension_cover, unbalanced
from solvers.point_mass.fields import distance
from solvers.point_mass.gradient import gradient_bounds, multiplier
from solvers.point_mass.system import krawczyk

WIDTH = 7
SHARE = 6
PROVED = 1
"""Leaf: every equilibrium of the taut set in the cell is the one of a proved box around it."""
SMALL = 2
"""Leaf: smaller than the smallest width, neither proved nor excluded."""


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
def other_taut(others: Any, box: Any) -> bool:
    """Return True when a cable that must be slack is too short on the whole box."""
    for c in range(others[2].shape[0]):  # noqa: SIM110 - numba compiles no generator expressions
        if distance(others[1], c, box)[0] > others[2][c, 1]:
            return True
    return False


@entry()
def multiplier_cover(cables: Any, load: Any, box: Any, x: Any, cover: Any) -> bool:
    """Enclose every vector of multipliers of elastic taut cables with a pose in the cell.

    Each multiplier is a function of the distance; for up to three cables the balance bounds them too.
    Same arguments as `tension_cover`; False where the bounds contradict each other (no pose in the cell).
    """
    m = cables[1].shape[0]
    balanced = m <= 3 and tension_cover(cables, load, box, x, cover)
    for j in range(3):
        x[j] = mid(box[j, 0], box[j, 1])
        cover[j, 0], cover[j, 1] = box[j, 0], box[j, 1]
    for i in range(m):
        lo, hi, _, _ = multiplier(cables, i, box)
        if balanced:
            lo, hi = max(lo, cover[3 + i, 0]), min(hi, cover[3 + i, 1])
        if not lo <= hi:
            return False
        cover[3 + i, 0], cover[3 + i, 1] = lo, hi
        if not (balanced and lo <= x[3 + i] <= hi):
            x[3 + i] = mid(lo, hi)
    return True


@entry()
def settle(cables: Any, load: Any, box: Any, x: Any, zero: Any, domain: Any) -> bool:
    """Prove that all equilibria of the taut cables in a cell are one proved zero.

    True: ``domain`` (3 + m, 2) holds exactly one zero of the square system, enclosed by ``zero``, and
    contains the cell together with every vector of multipliers that can balance the load there.
    """
    m = cables[1].shape[0]
    cover = np.empty((3 + m, 2))
    if cables[0][0]:
        if not multiplier_cover(cables, load, box, x, cover):
            return False
    elif not tension_cover(cables, load, box, x, cover):
        return False
    if not krawczyk(cables, load, all_cables(m), m, x, cover, zero, domain):
        return False
    return contains(domain, cover, 3 + m)


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
    cables, others, load, limits, exact, low, ceiling = context
    elastic, exits, lengths, _, _ = cables
    m = lengths.shape[0]
    box = np.empty((3, 2))
    for j in range(3):
        box[j, 0], box[j, 1] = cell[2 * j], cell[2 * j + 1]
    if elastic[0]:
        if not affordable(cables, load, exact, low, ceiling, box):
            return 0
    else:
        for c in range(m):
            if not shave(exits, c, lengths[c, 0], lengths[c, 1], box):
                return 0
    if other_taut(others, box):
        return 0
    if elastic[0] and pushed(cables, load, box):
        return 0
    if exact and m <= 3 and unbalanced(cables, load, box):
        return 0
    widest = 0
    for j in range(3):
        if box[j, 1] - box[j, 0] > box[widest, 1] - box[widest, 0]:
            widest = j
    width = box[widest, 1] - box[widest, 0]
    for j in range(3):
        children[0, 2 * j], children[0, 2 * j + 1] = box[j, 0], box[j, 1]
    children[0, SHARE] = cell[SHARE]
    if width <= limits[0]:
        x = np.empty(3 + m)
        zero = np.empty((3 + m, 2))
        domain = np.empty((3 + m, 2))
        if settle(cables, load, box, x, zero, domain):
            return 0 if disjoint(zero, box, 3) else -PROVED
    middle = mid(box[widest, 0], box[widest, 1])
    if width <= limits[1] or not box[widest, 0] < middle < box[widest, 1]:
        return -SMALL
    for j in range(WIDTH):
        children[1, j] = children[0, j]
    children[0, 2 * widest + 1] = middle
    children[1, 2 * widest] = middle
    children[0, SHARE] = children[1, SHARE] = 0.5 * cell[SHARE]
    return 2


@entry()
def run_cells(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Explore cells depth first, see `cdpr_interval.engine.depth_first.depth_first`."""
    return depth_first(process, context, stack, count, leaves, kinds, children, cell_limit)
