"""Branch and prune over the positions of a point mass, compiled: what decides one cell.

A cell is a row ``x lo, x hi, y lo, y hi, z lo, z hi, share``. One search belongs to one set of taut cables.

Arrays: ``context`` is ``(cables, others, load, limits, exact, low, ceiling)``: ``cables`` is an
``arrays.Cables`` of the m taut ones, ``others`` is an ``arrays.Cables`` of those that must be slack;
``load`` (3, 2); ``limits`` (2,) the width below which existence is tried, and the smallest width; ``exact``
is true where all given cables must be taut; for elastic cables ``low`` (3,) is a point at which their
elastic energy is at most ``ceiling``. ``box`` (3, 2) of positions; ``x`` (3 + m,) a position, then
multipliers, ``cover`` (3 + m, 2) bounds of these; ``cell`` (WIDTH,), ``children`` (>= 2, WIDTH).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr_interval.engine.depth_first import depth_first
from cdpr_interval.kernels.box import contains, disjoint
from cdpr_interval.kernels.interval import mid
from cdpr_interval.kernels.kernel import entry
from solvers.point_mass.balance import all_cables, tension_cover, unbalanced
from solvers.point_mass.cell_rows import box_of, halve, keep, widest
from solvers.point_mass.fields import distance
from solvers.point_mass.gradient import multiplier
from solvers.point_mass.spring_cells import affordable, pushed, shave
from solvers.point_mass.system import krawczyk

PROVED = 1
"""Leaf: every equilibrium of the taut set in the cell is the one of a proved box around it."""


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
def process(context: Any, cell: Any, children: Any) -> int:
    """Decide one cell, see `cdpr_interval.engine.depth_first`."""
    cables, others, load, limits, exact, low, ceiling = context
    elastic, exits, lengths, _, _ = cables
    m = lengths.shape[0]
    box = np.empty((3, 2))
    box_of(cell, box)
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
    keep(box, cell, children[0])
    side = widest(box)
    if box[side, 1] - box[side, 0] <= limits[0]:
        x = np.empty(3 + m)
        zero = np.empty((3 + m, 2))
        domain = np.empty((3 + m, 2))
        if settle(cables, load, box, x, zero, domain):
            return 0 if disjoint(zero, box, 3) else -PROVED
    return halve(box, side, limits[1], children)


@entry()
def run_cells(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Explore cells depth first, see `cdpr_interval.engine.depth_first.depth_first`."""
    return depth_first(process, context, stack, count, leaves, kinds, children, cell_limit)
