"""The balance of one to three cables and the load over a box of positions.

Arrays, for m <= 3 cables: ``cables`` is an ``arrays.Cables`` of them, ``exits`` (m, 3, 2) are theirs;
``load`` (3, 2); ``box`` (3, 2) of positions, a cell; ``e`` (> m, 3) unit vectors; ``y`` (3,) a direction;
``x`` (3 + m,) a position p, then multipliers; ``C`` (>= m, 3); ``cover`` (3 + m, 2) bounds x.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.interval import add, mag, mid, mul, scale, sub
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.rounding import down, up


@entry()
def form(y: Any, lo: Any, hi: Any) -> tuple[float, float]:
    """Enclose y . v for v between the vectors lo (3,) and hi (3,)."""
    slo, shi = 0.0, 0.0
    for j in range(3):
        a, b = mul(y[j], y[j], lo[j], hi[j])
        slo, shi = add(slo, shi, a, b)
    return slo, shi


@entry()
def unit_vectors(cables: Any, load: Any, box: Any, e: Any) -> bool:
    """Write the unit vectors from the cell's centre to the exit points, then that of the load, rows of e."""
    exits = cables[1]
    m = exits.shape[0]
    for i in range(m + 1):
        total = 0.0
        for j in range(3):
            if i < m:
                e[i, j] = mid(exits[i, j, 0], exits[i, j, 1]) - mid(box[j, 0], box[j, 1])
            else:
                e[i, j] = mid(load[j, 0], load[j, 1])
            total += e[i, j] * e[i, j]
        total = math.sqrt(total)
        if not total > 0.0:
            return False
        for j in range(3):
            e[i, j] /= total
    return True


@entry()
def least_norm(e: Any, n: int, r: Any, y: Any) -> bool:
    """Write the shortest y with y . e_i = r_i, r (>= n,), for n <= 3 rows of e; False where singular."""
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


@entry()
def separates(cables: Any, load: Any, box: Any, y: Any) -> bool:
    """Prove y . (A_i - p) > 0 for every cable and y . f > 0 over the whole box."""
    exits = cables[1]
    if not form(y, load[:, 0], load[:, 1])[0] > 0.0:
        return False
    lo, hi = np.empty(3), np.empty(3)
    for i in range(exits.shape[0]):
        for j in range(3):
            lo[j], hi[j] = sub(exits[i, j, 0], exits[i, j, 1], box[j, 0], box[j, 1])
        if not form(y, lo, hi)[0] > 0.0:
            return False
    return True


@entry()
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
    # The load is row m: with fewer than three cables the forms of all m + 1 rows can be made equal.
    if m < 3 and least_norm(e, m + 1, r, y) and separates(cables, load, box, y):
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


@kernel()
def left_inverse(exits: Any, load: Any, m: int, x: Any, C: Any) -> bool:
    """Write an approximate left inverse of the spokes at p, and the multipliers that balance best there.

    ``exits`` (m, 3, 2), ``load`` (3, 2), C (>= m, 3); x (3 + m,) is p, then these multipliers. False where
    the spokes seem dependent.
    """
    gram = np.empty((3, 7))
    e = np.empty((3, 3))
    for j in range(3):
        for i in range(m):
            e[i, j] = x[j] - mid(exits[i, j, 0], exits[i, j, 1])
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
            C[i, j] = gram[i, m + j]
            x[3 + i] += C[i, j] * mid(load[j, 0], load[j, 1])
    return True


@kernel()
def least_squares_error(exits: Any, load: Any, m: int, box: Any, x: Any, C: Any) -> tuple[float, float]:
    """Bound |I - C E| and |C (f - E s)| (largest norms) over a cell (3, 2); arrays as in `left_inverse`."""
    spoke = np.empty((3, 3, 2))
    rest = np.empty((3, 2))
    for j in range(3):
        rest[j, 0], rest[j, 1] = load[j, 0], load[j, 1]
        for i in range(m):
            spoke[i, j, 0], spoke[i, j, 1] = sub(box[j, 0], box[j, 1], exits[i, j, 0], exits[i, j, 1])
            lo, hi = scale(x[3 + i], spoke[i, j, 0], spoke[i, j, 1])
            rest[j, 0], rest[j, 1] = sub(rest[j, 0], rest[j, 1], lo, hi)
    beta, error = 0.0, 0.0
    for i in range(m):
        total = 0.0
        for k in range(m):
            slo, shi = (1.0, 1.0) if i == k else (0.0, 0.0)
            for j in range(3):
                lo, hi = scale(C[i, j], spoke[k, j, 0], spoke[k, j, 1])
                slo, shi = sub(slo, shi, lo, hi)
            total = up(total + mag(slo, shi))
        beta = max(beta, total)
        slo, shi = 0.0, 0.0
        for j in range(3):
            lo, hi = scale(C[i, j], rest[j, 0], rest[j, 1])
            slo, shi = add(slo, shi, lo, hi)
        error = max(error, mag(slo, shi))
    return beta, error


@entry()
def tension_cover(cables: Any, load: Any, box: Any, x: Any, cover: Any) -> bool:
    """Enclose every vector of multipliers that can balance the load over the cell.

    Verified least squares: with E the (3, m) matrix of the spokes, C an approximate left inverse at the
    centre and s the multipliers there, every solution is s + d with |d| <= |C (f - E s)| / (1 - |I - C E|)
    (largest norms), provided |I - C E| < 1, which also proves full column rank over the cell.

    Parameters
    ----------
    cables, load, box
        See `solvers.point_mass.system.evaluate`; m <= 3 cables, all of them taut, and a cell (3, 2).
    x : (3 + m,)
        Written: centre and multipliers there.
    cover : (3 + m, 2)
        Written: the cell and the enclosure of the multipliers.

    Returns
    -------
    bool
        False when full column rank is not proved.
    """
    exits = cables[1]
    m = exits.shape[0]
    C = np.empty((3, 3))
    for j in range(3):
        x[j] = mid(box[j, 0], box[j, 1])
        cover[j, 0], cover[j, 1] = box[j, 0], box[j, 1]
    if not left_inverse(exits, load, m, x, C):
        return False
    beta, error = least_squares_error(exits, load, m, box, x, C)
    if not beta < 0.9:
        return False
    radius = up(error / down(1.0 - beta))
    if not radius < 1e100:
        return False
    for i in range(m):
        cover[3 + i, 0], cover[3 + i, 1] = down(x[3 + i] - radius), up(x[3 + i] + radius)
    return True


@entry()
def all_cables(m: int) -> Any:
    """Return 0 .. m - 1."""
    index = np.empty(m, dtype=np.int64)
    for i in range(m):
        index[i] = i
    return index
