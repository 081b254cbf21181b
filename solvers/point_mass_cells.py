"""Branch and prune over the positions of a point mass, compiled: what decides one cell.

A cell is a row ``x lo, x hi, y lo, y hi, z lo, z hi, share``. One search belongs to one set of taut
cables; the context is ``(cables, others, load, limits, exact)`` with ``cables`` the taut ones and ``others``
the cables that must be slack (both as in `solvers.point_mass_newton.evaluate`), ``limits`` = (width
below which existence is tried, smallest width), ``exact`` true where all given cables must be taut.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from cdpr_interval.engine.depth_first import depth_first
from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.interval import add, mag, mid, mig, mul, sqr, sub
from cdpr_interval.kernels.rounding import down, up
from solvers.point_mass_fields import distance
from solvers.point_mass_gradient import gradient_bounds, gradient_krawczyk, multiplier
from solvers.point_mass_newton import krawczyk

WIDTH = 7
SHARE = 6
PROVED = 1
"""Leaf: every equilibrium of the taut set in the cell is the one of a proved box around it."""
SMALL = 2
"""Leaf: smaller than the smallest width, neither proved nor excluded."""


@njit(cache=True, nogil=True)
def shave(anchors: Any, c: int, shortest: float, longest: float, box: Any) -> bool:
    """Contract a box to the points with shortest <= |p - A_c| <= longest; False where none is left.

    Guarantee: no such point of the box is lost.
    """
    square = np.empty((3, 2))
    for j in range(3):
        lo, hi = sub(box[j, 0], box[j, 1], anchors[c, j, 0], anchors[c, j, 1])
        square[j, 0], square[j, 1] = sqr(lo, hi)
    for j in range(3):
        a, b = (j + 1) % 3, (j + 2) % 3
        rest_lo = down(square[a, 0] + square[b, 0])
        rest_hi = up(square[a, 1] + square[b, 1])
        room = up(up(longest * longest) - rest_lo)
        if room < 0.0:
            return False
        r = up(math.sqrt(room))
        box[j, 0] = max(box[j, 0], down(anchors[c, j, 0] - r))
        box[j, 1] = min(box[j, 1], up(anchors[c, j, 1] + r))
        hole = down(down(shortest * shortest) - rest_hi)
        if hole > 0.0:
            r = down(math.sqrt(hole))
            low, high = up(anchors[c, j, 1] - r), down(anchors[c, j, 0] + r)
            # Points with low < p_j < high are too near.
            if box[j, 0] > low:
                box[j, 0] = max(box[j, 0], high)
            if box[j, 1] < high:
                box[j, 1] = min(box[j, 1], low)
        if not box[j, 0] <= box[j, 1]:
            return False
        lo, hi = sub(box[j, 0], box[j, 1], anchors[c, j, 0], anchors[c, j, 1])
        square[j, 0], square[j, 1] = sqr(lo, hi)
    return True


@njit(cache=True, nogil=True)
def other_taut(others: Any, box: Any) -> bool:
    """Return True when a cable that must be slack is too short on the whole box."""
    for c in range(others[2].shape[0]):
        if distance(others[1], c, box)[0] > others[2][c, 1]:
            return True
    return False


@njit(cache=True, nogil=True)
def form(y: Any, lo: Any, hi: Any) -> tuple[float, float]:
    """Enclose y . v for v between the vectors lo and hi (3,)."""
    slo, shi = 0.0, 0.0
    for j in range(3):
        a, b = mul(y[j], y[j], lo[j], hi[j])
        slo, shi = add(slo, shi, a, b)
    return slo, shi


@njit(cache=True, nogil=True)
def unit_vectors(cables: Any, load: Any, box: Any, e: Any) -> bool:
    """Write the unit vectors from the cell's centre to the exit points, then that of the load, rows of e."""
    anchors = cables[1]
    m = anchors.shape[0]
    for i in range(m + 1):
        total = 0.0
        for j in range(3):
            if i < m:
                e[i, j] = mid(anchors[i, j, 0], anchors[i, j, 1]) - mid(box[j, 0], box[j, 1])
            else:
                e[i, j] = mid(load[j, 0], load[j, 1])
            total += e[i, j] * e[i, j]
        total = math.sqrt(total)
        if not total > 0.0:
            return False
        for j in range(3):
            e[i, j] /= total
    return True


@njit(cache=True, nogil=True)
def least_norm(e: Any, n: int, r: Any, y: Any) -> bool:
    """Write the shortest y with y . e_i = r_i for the first n <= 3 rows of e; False where singular."""
    work = np.empty((3, 4))
    for i in range(n):
        for k in range(n):
            work[i, k] = e[i, 0] * e[k, 0] + e[i, 1] * e[k, 1] + e[i, 2] * e[k, 2]
        work[i, n] = r[i]
    if not solve_in_place(work, n, 1):
        return False
    for j in range(3):
        y[j] = 0.0
        for i in range(n):
            y[j] += work[i, n] * e[i, j]
    return abs(y[0]) + abs(y[1]) + abs(y[2]) < 1e100


@njit(cache=True, nogil=True)
def separates(cables: Any, load: Any, box: Any, y: Any) -> bool:
    """Prove y . (A_i - p) > 0 for every cable and y . f > 0 over the whole box."""
    anchors = cables[1]
    if not form(y, load[:, 0], load[:, 1])[0] > 0.0:
        return False
    lo, hi = np.empty(3), np.empty(3)
    for i in range(anchors.shape[0]):
        for j in range(3):
            lo[j], hi[j] = sub(anchors[i, j, 0], anchors[i, j, 1], box[j, 0], box[j, 1])
        if not form(y, lo, hi)[0] > 0.0:
            return False
    return True


@njit(cache=True, nogil=True)
def unbalanced(cables: Any, load: Any, box: Any) -> bool:
    """Prove that no tensions >= 0 of one to three cables balance the load anywhere in the box.

    One vector y with y . (A_i - p) > 0 for every cable and y . f > 0 is a proof (Gordan). Two guesses at the
    centre: all these forms equal (it exists where load and cables are independent), and y . e_i = r_i
    with r larger where the tension is negative, which makes y . f = -sum s_i r_i positive.
    """
    m = cables[1].shape[0]
    e = np.empty((4, 3))
    r = np.ones(3)
    y = np.empty(3)
    if not unit_vectors(cables, load, box, e):
        return False
    if m < 3:
        # The load is row m: the forms of all m + 1 rows are made equal.
        if least_norm(e, m + 1, r, y) and separates(cables, load, box, y):
            return True
    work = np.empty((3, 4))
    for i in range(m):
        for k in range(m):
            work[i, k] = e[i, 0] * e[k, 0] + e[i, 1] * e[k, 1] + e[i, 2] * e[k, 2]
        work[i, m] = -(e[i, 0] * e[m, 0] + e[i, 1] * e[m, 1] + e[i, 2] * e[m, 2])
    if not solve_in_place(work, m, 1):
        return False
    positive, negative = 0.0, 0.0
    for i in range(m):
        positive += max(work[i, m], 0.0)
        negative += max(-work[i, m], 0.0)
    if not negative > 0.0:
        return False
    for i in range(m):
        r[i] = (1.0 + positive) / negative if work[i, m] < 0.0 else 1.0
    return least_norm(e, m, r, y) and separates(cables, load, box, y)


@njit(cache=True, nogil=True)
def tension_cover(cables: Any, load: Any, box: Any, x: Any, cover: Any) -> bool:
    """Enclose every vector of multipliers that can balance the load over the cell.

    Verified least squares: with E the (3, m) matrix of the arms, C an approximate left inverse at the
    centre and s the multipliers there, every solution is s + d with |d| <= |C (f - E s)| / (1 - |I - C E|)
    (largest norms), provided |I - C E| < 1, which also proves full column rank over the cell.

    Parameters
    ----------
    x : (3 + m,)
        Written: centre and multipliers there.
    cover : (3 + m, 2)
        Written: the cell and the enclosure of the multipliers.

    Returns
    -------
    bool
        False when full column rank is not proved.
    """
    anchors = cables[1]
    m = anchors.shape[0]
    gram = np.empty((3, 7))
    e = np.empty((3, 3))
    for j in range(3):
        x[j] = mid(box[j, 0], box[j, 1])
        cover[j, 0], cover[j, 1] = box[j, 0], box[j, 1]
        for i in range(m):
            e[i, j] = x[j] - mid(anchors[i, j, 0], anchors[i, j, 1])
    for i in range(m):
        for k in range(m):
            gram[i, k] = e[i, 0] * e[k, 0] + e[i, 1] * e[k, 1] + e[i, 2] * e[k, 2]
        for j in range(3):
            gram[i, m + j] = e[i, j]
    if not solve_in_place(gram, m, 3):
        return False
    for i in range(m):
        x[3 + i] = 0.0
        for j in range(3):
            x[3 + i] += gram[i, m + j] * mid(load[j, 0], load[j, 1])
    beta = 0.0
    error = 0.0
    arm = np.empty((3, 3, 2))
    rest = np.empty((3, 2))
    for j in range(3):
        rest[j, 0], rest[j, 1] = load[j, 0], load[j, 1]
        for i in range(m):
            arm[i, j, 0], arm[i, j, 1] = sub(box[j, 0], box[j, 1], anchors[i, j, 0], anchors[i, j, 1])
            lo, hi = mul(x[3 + i], x[3 + i], arm[i, j, 0], arm[i, j, 1])
            rest[j, 0], rest[j, 1] = sub(rest[j, 0], rest[j, 1], lo, hi)
    for i in range(m):
        total = 0.0
        for k in range(m):
            slo, shi = (1.0, 1.0) if i == k else (0.0, 0.0)
            for j in range(3):
                c = gram[i, m + j]
                lo, hi = mul(c, c, arm[k, j, 0], arm[k, j, 1])
                slo, shi = sub(slo, shi, lo, hi)
            total = up(total + mag(slo, shi))
        beta = max(beta, total)
        slo, shi = 0.0, 0.0
        for j in range(3):
            c = gram[i, m + j]
            lo, hi = mul(c, c, rest[j, 0], rest[j, 1])
            slo, shi = add(slo, shi, lo, hi)
        error = max(error, mag(slo, shi))
    if not beta < 0.9:
        return False
    radius = up(error / down(1.0 - beta))
    if not radius < 1e100:
        return False
    for i in range(m):
        cover[3 + i, 0], cover[3 + i, 1] = down(x[3 + i] - radius), up(x[3 + i] + radius)
    return True


@njit(cache=True, nogil=True)
def contains(outer: Any, inner: Any, n: int) -> bool:
    """Return True when the first n intervals of ``inner`` lie in those of ``outer``."""
    for i in range(n):
        if not (outer[i, 0] <= inner[i, 0] and inner[i, 1] <= outer[i, 1]):
            return False
    return True


@njit(cache=True, nogil=True)
def disjoint(a: Any, b: Any, n: int) -> bool:
    """Return True when two boxes have no common point."""
    for i in range(n):
        if a[i, 1] < b[i, 0] or b[i, 1] < a[i, 0]:
            return True
    return False


@njit(cache=True, nogil=True)
def all_cables(m: int) -> Any:
    """Return 0 .. m - 1."""
    index = np.empty(m, dtype=np.int64)
    for i in range(m):
        index[i] = i
    return index


@njit(cache=True, nogil=True)
def settle_rigid(cables: Any, load: Any, box: Any, x: Any, zero: Any, domain: Any) -> bool:
    """Prove that all equilibria of inextensible cables in a cell are one proved zero.

    True: ``domain`` (3 + m, 2) holds exactly one zero, enclosed by ``zero``, and contains the cell together
    with every vector of multipliers that can balance the load there.
    """
    m = cables[1].shape[0]
    cover = np.empty((3 + m, 2))
    if not tension_cover(cables, load, box, x, cover):
        return False
    if not krawczyk(cables, load, all_cables(m), m, x, cover, zero, domain):
        return False
    return contains(domain, cover, 3 + m)


@njit(cache=True, nogil=True)
def settle_elastic(cables: Any, load: Any, box: Any, x: Any, zero: Any, domain: Any) -> bool:
    """Prove that all equilibria of elastic cables in a cell are one proved zero (3, 2)."""
    for j in range(3):
        x[j] = mid(box[j, 0], box[j, 1])
    if not gradient_krawczyk(cables, load, x, box, zero, domain):
        return False
    return contains(domain, box, 3)


@njit(cache=True, nogil=True)
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
    anchors = cables[1]
    lo3, hi3 = np.empty(3), np.empty(3)
    for c in range(anchors.shape[0]):
        tlo, thi, _, _ = multiplier(cables, c, box)
        for j in range(3):
            lo3[j], hi3[j] = sub(box[j, 0], box[j, 1], anchors[c, j, 0], anchors[c, j, 1])
        lo, hi = form(y, lo3, hi3)
        lo, hi = mul(tlo, thi, lo, hi)
        slo, shi = add(slo, shi, lo, hi)
    return mig(slo, shi) > 0.0


@njit(cache=True, nogil=True)
def process(context: Any, cell: Any, children: Any) -> int:
    """Decide one cell, see `cdpr_interval.engine.depth_first`."""
    cables, others, load, limits, exact = context
    elastic, anchors, lengths, _, _ = cables
    m = lengths.shape[0]
    box = np.empty((3, 2))
    for j in range(3):
        box[j, 0], box[j, 1] = cell[2 * j], cell[2 * j + 1]
    for c in range(m):
        if not elastic[c]:
            if not shave(anchors, c, lengths[c, 0], lengths[c, 1], box):
                return 0
        elif exact and distance(anchors, c, box)[1] <= lengths[c, 0]:
            return 0
    if other_taut(others, box):
        return 0
    if elastic[0]:
        if pushed(cables, load, box):
            return 0
    elif unbalanced(cables, load, box):
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
        if elastic[0]:
            settled = settle_elastic(cables, load, box, x, zero, domain)
        else:
            settled = settle_rigid(cables, load, box, x, zero, domain)
        if settled:
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


@njit(cache=True, nogil=True)
def run_cells(
    context: Any, stack: Any, count: int, leaves: Any, kinds: Any, children: Any, cell_limit: int
) -> tuple[int, int, int]:
    """Explore cells depth first, see `cdpr_interval.engine.depth_first.depth_first`."""
    return depth_first(process, context, stack, count, leaves, kinds, children, cell_limit)
