"""All tensions that hold a platform in any pose of a small neighbourhood, where they are not unique.

With more cables tight than their wrenches have rank, tensions form a polytope that moves with the pose. It
is made homogeneous: x = (t, kappa) >= 0 with sum t_i w_i + kappa w_0 = 0 (kappa = 0: cables that only pull
against each other). A few entries theta of x are free, the others follow by a verified linear solve, so
that for each pose x is linear in theta >= 0, sum theta = 1; the simplex of theta is bisected and what has
no x >= 0 is dropped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from cdpr_interval.exact import balls
from cdpr_interval.mechanics.energy import to_matrix

Floats = NDArray[np.float64]

INDEPENDENT = 1e-6
"""Least remainder of a normalised wrench, after those chosen before it, that is solved for."""
SPLITS = 400
"""Most bisections of the simplex of theta."""
NARROW = 1e-3
"""Longest edge of a part of the simplex that is not split for its own sake."""
APART = 1e-9
"""Least distance from the origin of a hull of normalised wrenches that counts."""
DIRECTIONS = 6
"""Supports tried for each bound of a tension."""


@dataclass(frozen=True, eq=False)
class TensionRays:
    """Parts of the simplex of theta that may hold tensions, as the values of x at their corners.

    For each pose of the neighbourhood every admissible x is, up to a positive factor, a convex combination of
    one part's corners, taken at that pose. x is ordered as the cables, the load's factor last.
    """

    parts: tuple[tuple[tuple[arb, ...], ...], ...]

    def always(self, i: int) -> bool:
        """Return True when cable i carries whatever the tensions are."""
        return all(corner[i] > 0 for part in self.parts for corner in part)

    def least(self, i: int) -> arb:
        """Return a lower bound of t_i = x_i / kappa: some m >= 0 with x_i - m kappa >= 0 at all corners."""
        corners = [corner for part in self.parts for corner in part]
        if any(corner[-1].lower() <= 0 and corner[i].lower() < 0 for corner in corners):
            return arb(0)
        ratios = [c[i].lower() / c[-1].upper() for c in corners if c[-1].upper() > 0]
        return reduce(arb.min, ratios).max(arb(0)) if ratios else arb(0)


def wrench_matrix(spokes: Sequence[arb_mat], arms: Sequence[arb_mat], load: arb_mat, size: float) -> arb_mat:
    """Return the columns (e_i, r_i x e_i / size) of the cables, then (f, 0)."""
    columns = []
    per_size = arb(1) / arb(size)
    for e, r in zip(spokes, arms, strict=True):
        columns.append([*balls.entries(e), *balls.entries(balls.cross(r, e) * per_size)])
    columns.append([*balls.entries(load), arb(0), arb(0), arb(0)])
    return arb_mat(columns).transpose()


def independent_columns(middle: Floats) -> list[int]:
    """Return a largest set of clearly independent columns, by Gram-Schmidt with pivoting."""
    left = middle / np.linalg.norm(middle, axis=0)
    chosen: list[int] = []
    while len(chosen) < 6:
        sizes = np.linalg.norm(left, axis=0)
        k = int(np.argmax(sizes))
        if not sizes[k] > INDEPENDENT:
            break
        chosen.append(k)
        axis = left[:, k] / sizes[k]
        left = left - np.outer(axis, axis @ left)
        left[:, chosen] = 0.0
    return sorted(chosen)


def tension_rays(matrix: arb_mat) -> TensionRays | None:
    """Return what balances over a neighbourhood with these wrenches (6, n + 1), the load's last.

    None where the dependent entries cannot be solved for. No parts: nothing balances anywhere in it.
    """
    middle = balls.middle(matrix)
    norms = np.linalg.norm(middle, axis=0)
    if not (np.isfinite(middle).all() and np.all(norms > 0.0)):
        return None
    # Columns of about one size, so that the simplex is cut alike whatever the units.
    scales = [arb(float(2.0 ** -np.round(np.log2(norm)))) for norm in norms]
    matrix = balls.columns(*[column(matrix, k) * scales[k] for k in range(len(scales))])
    middle = balls.middle(matrix)
    solved = independent_columns(middle)
    free = [k for k in range(middle.shape[1]) if k not in solved]
    if not free:
        return TensionRays(())
    left = to_matrix(np.asarray(np.linalg.pinv(middle[:, solved])))
    columns = balls.columns
    own = columns(*[column(matrix, k) for k in solved])
    rest = columns(*[column(matrix, k) for k in free])
    try:
        slopes = (left * own).solve(left * rest * -1)
    except ZeroDivisionError:
        return None

    def at(theta: Floats) -> tuple[arb, ...]:
        x = [arb(0)] * middle.shape[1]
        for j, k in enumerate(free):
            x[k] = arb(float(theta[j]))
        for i, k in enumerate(solved):
            x[k] = sum((slopes[i, j] * arb(float(theta[j])) for j in range(len(free))), arb(0))
        return tuple(v * scale for v, scale in zip(x, scales, strict=True))

    parts = []
    todo = [np.eye(len(free))]
    for _ in range(SPLITS):
        if not todo:
            break
        corners = todo.pop()
        values = tuple(at(theta) for theta in corners)
        if any(all(value[i] < 0 for value in values) for i in range(middle.shape[1])):
            continue
        halves = halved(corners)
        if halves is None or all(x > 0 for value in values for x in value):
            parts.append(values)
        else:
            todo += halves
    parts += [tuple(at(theta) for theta in corners) for corners in todo]
    return TensionRays(tuple(parts))


def are_independent(matrix: arb_mat) -> bool:
    """Return True when all but the last column of (6, n + 1) are proved independent."""
    n = matrix.ncols() - 1
    middle = balls.middle(matrix)[:, :n]
    if n > 6 or not np.isfinite(middle).all():
        return False
    own = balls.columns(*[column(matrix, k) for k in range(n)])
    try:
        (to_matrix(np.asarray(np.linalg.pinv(middle))) * own).solve(balls.identity(n))
    except ZeroDivisionError:
        return False
    return True


def column(matrix: arb_mat, k: int) -> arb_mat:
    """Return a column of a matrix."""
    return arb_mat(matrix.nrows(), 1, [matrix[i, k] for i in range(matrix.nrows())])


def halved(corners: Floats) -> list[Floats] | None:
    """Return a simplex cut in two at the middle of its longest edge; None where that is short."""
    count = len(corners)
    edges = [(float(np.linalg.norm(corners[i] - corners[j])), i, j) for i in range(count) for j in range(i)]
    if not edges:
        return None
    length, i, j = max(edges)
    if length <= NARROW:
        return None
    middle = 0.5 * (corners[i] + corners[j])
    first, second = corners.copy(), corners.copy()
    first[i], second[j] = middle, middle
    return [first, second]


def tension_bounds(matrix: arb_mat, rays: TensionRays) -> list[tuple[arb, arb | None]]:
    """Return bounds of the t_i >= 0 with sum t_i w_i + w_0 = 0 over a neighbourhood; None: no upper bound.

    Linear programming duality: y . w_k >= [k = i] for all k gives t_i <= -y . w_0, and <= gives >=. Where
    that holds only up to rounding, the rest is paid for with the cruder bounds of the rays.
    """
    count = matrix.ncols() - 1
    middle = balls.middle(matrix)
    most = crude_bounds(matrix, middle)
    if most is None:
        return [(rays.least(i), None) for i in range(count)]
    found: list[tuple[arb, arb | None]] = []
    for i in range(count):
        low, high = rays.least(i), most[i]
        for y in dual_directions(middle, i):
            value = -product(y, matrix, count)
            over, under = arb(0), arb(0)
            for k in range(count):
                gap = int(k == i) - product(y, matrix, k)
                over += most[k] * gap.max(arb(0))
                under += most[k] * (-gap).max(arb(0))
            high = min(high, (value + over).upper(), key=float)
            low = max(low, (value - under).lower(), key=float)
        found.append((low, high))
    return found


def crude_bounds(matrix: arb_mat, middle: Floats) -> list[arb] | None:
    """Return upper bounds of all t_i from one y with y . w_i > 0 for every cable; None without one."""
    count = middle.shape[1] - 1
    y = nearest_direction(middle[:, :count] / np.linalg.norm(middle[:, :count], axis=0))
    if y is None:
        return None
    products = [product(y, matrix, k) for k in range(count)]
    if not all(p > 0 for p in products):
        return None
    pull = (-product(y, matrix, count)).max(arb(0))
    return [pull / p for p in products]


def product(y: Floats, matrix: arb_mat, k: int) -> arb:
    """Return y . column k."""
    return sum((arb(float(y[r])) * matrix[r, k] for r in range(6)), arb(0))


def nearest_direction(columns: Floats) -> Floats | None:
    """Return y with positive products with all columns (6, n) if there is one, by the nearest hull point."""
    x = np.full(columns.shape[1], 1.0 / columns.shape[1])
    y = columns @ x
    for _ in range(5000):
        products = columns.T @ y
        low = int(np.argmin(products))
        high = int(np.argmax(np.where(x > 0.0, products, -np.inf)))
        gap = products[high] - products[low]
        if gap <= 1e-12:
            break
        step = columns[:, low] - columns[:, high]
        share = min(x[high], gap / max(float(step @ step), 1e-300))
        x[low] += share
        x[high] -= share
        y = columns @ x
    norm = float(np.linalg.norm(y))
    return y / norm if norm > APART else None


def dual_directions(middle: Floats, i: int) -> list[Floats]:
    """Return directions y that may bound t_i best: those of the supports where t_i is largest or smallest."""
    count = middle.shape[1] - 1
    # Of directions: in other units the load may be any number of times as large as the wrenches.
    unit = middle[:, :count] / np.linalg.norm(middle[:, :count], axis=0)
    rank = int(np.linalg.matrix_rank(unit, tol=INDEPENDENT))
    load = float(np.linalg.norm(middle[:, count]))
    found: list[tuple[float, Floats]] = []
    for support in combinations(range(count), rank):
        columns = middle[:, support]
        t = np.linalg.lstsq(columns, -middle[:, count], rcond=None)[0]
        if t.min() < -1e-9 * np.abs(t).max() or np.linalg.norm(columns @ t + middle[:, count]) > 1e-6 * load:
            continue
        wanted = np.array([float(k == i) for k in support])
        y = np.linalg.lstsq(columns.T, wanted, rcond=None)[0]
        found.append((float(t[support.index(i)]) if i in support else 0.0, y))
    found.sort(key=lambda pair: pair[0])
    return [y for _, y in found[:DIRECTIONS] + found[-DIRECTIONS:]]
