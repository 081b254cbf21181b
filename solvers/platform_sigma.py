"""Cells in (u, sigma): four search variables for three to six taut cables (and two in a plane).

With d_j = c_j - c_1, K_j = (|d_j|^2 + l_1^2 - l_j^2) / 2, m = d_2 x d_3 and x = p - c_1, the three
sphere equations of the triple are d_2 . x = K_2, d_3 . x = K_3, |x|^2 = l_1^2. With sigma = m . x they
become linear in x, and sigma^2 = l_1^2 |m|^2 - |K_2 d_3 - K_3 d_2|^2. The Gram entries d_i . d_j are linear
in R. A further taut cable needs K_i - d_i . x = 0, a slack one K_j - d_j . x <= 0.
Two taut cables in the plane y = 0 take the plane's normal as d_3, with K_3 = 0.

A cell is a row ``u (3 x lo, hi), sigma (lo, hi), chart, order, share``.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from cdpr_interval.engine.depth_first import depth_first
from cdpr_interval.kernels import affine
from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.rounding import UNIT, down, inflate, up
from solvers.platform_contract import EMPTY, SMALLER, contract, statics_equations
from solvers.platform_forms import (
    BLOCK,
    CABLE,
    EQUATION,
    FRAME,
    GRAM,
    OFFSET,
    POSITION,
    SCRATCH,
    moment_forms,
    rotated_point,
    rotated_step,
    rotation_forms,
    squared_distance,
    statics_excluded,
    tension_bounds,
)

SIGMA_LO, SIGMA_HI, CHART, ORDER, SHARE = 6, 7, 8, 9, 10
WIDTH = 11
SMALL = 1
"""Leaf kind: the cell is smaller than the leaf size."""
FLAT = 2
"""Leaf kind: the triple's centres may lie on one line although the cell is small."""
SIGMA_WEIGHT = 0.25
"""Weight of sigma against u when bisecting: measured best in DESIGN 2.2 (u range 2 to 0.25)."""
NEWTON_SIZE = 0.1
"""Width of u below which a cell that is not excluded is contracted before it is bisected."""
FLAT_SIZE = 0.03
"""Width of u below which a cell that cannot fix the position is handed on (another triple or (u, p))."""


@njit(cache=True, nogil=True)
def triple_forms(F: Any, model: Any, chart: int, order: int) -> None:
    """Write GRAM, OFFSET (K_2, K_3) and the rows d_2, d_3, m of FRAME."""
    i = model.orders[order, 0]
    j = model.orders[order, 1]
    last = F.shape[1] - 1
    squared_distance(F, GRAM, model, chart, j, i)
    rotated_step(F, FRAME, model, chart, j, i)
    if model.planar:
        affine.constant(F, GRAM + 1, 1.0, 0.0)
        affine.constant(F, GRAM + 2, 0.0, 0.0)
        affine.constant(F, OFFSET + 1, 0.0, 0.0)
        for k in range(3):
            affine.constant(F, FRAME + 3 + k, 1.0 if k == 1 else 0.0, 0.0)
    else:
        h = model.orders[order, 2]
        squared_distance(F, GRAM + 1, model, chart, h, i)
        squared_distance(F, SCRATCH, model, chart, h, j)
        affine.add(F, SCRATCH + 1, GRAM, GRAM + 1)
        affine.subtract(F, GRAM + 2, SCRATCH + 1, SCRATCH)
        for k in range(last + 1):
            F[GRAM + 2, k] *= 0.5
        offset_form(F, OFFSET + 1, GRAM + 1, model, h, i)
        rotated_step(F, FRAME + 3, model, chart, h, i)
    offset_form(F, OFFSET, GRAM, model, j, i)
    d, e, m = FRAME, FRAME + 3, FRAME + 6
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        affine.minor(F, m + k, d + a, e + b, d + b, e + a)


@njit(cache=True, nogil=True)
def offset_form(F: Any, out: int, square: int, model: Any, j: int, i: int) -> None:
    """Write K_j = (|c_j - c_i|^2 + l_i^2 - l_j^2) / 2, given the row of |c_j - c_i|^2."""
    last = F.shape[1] - 1
    for k in range(1, last):
        F[out, k] = 0.5 * F[square, k]
    a = model.lengths_sq[i]
    b = model.lengths_sq[j]
    c = F[square, 0]
    F[out, 0] = 0.5 * (c + (a - b))
    error = F[square, last] + model.lengths_sq_err[i] + model.lengths_sq_err[j]
    F[out, last] = 0.5 * inflate(error, abs(a) + abs(b) + abs(c), 8.0)


@njit(cache=True, nogil=True)
def sphere_bounds(F: Any, model: Any, order: int) -> tuple[float, float, float, float]:
    """Return bounds of l_1^2 |m|^2 - |K_2 d_3 - K_3 d_2|^2 (= sigma^2, left in EQUATION) and of |m|^2."""
    i = model.orders[order, 0]
    s = SCRATCH
    affine.minor(F, s, GRAM, GRAM + 1, GRAM + 2, GRAM + 2)
    affine.minor(F, s + 1, OFFSET, GRAM + 1, OFFSET + 1, GRAM + 2)
    affine.minor(F, s + 2, OFFSET + 1, GRAM, OFFSET, GRAM + 2)
    affine.dot(F, s + 3, OFFSET, s + 1, 2)
    affine.constant(F, s + 4, model.lengths_sq[i], model.lengths_sq_err[i])
    affine.multiply(F, s + 6, s + 4, s)
    affine.subtract(F, EQUATION, s + 6, s + 3)
    mlo, mhi = affine.bounds(F, s)
    lo, hi = affine.bounds(F, EQUATION)
    return lo, hi, mlo, mhi


@njit(cache=True, nogil=True)
def position_forms(F: Any, W: Any) -> bool:
    """Enclose x = p - c_1 in the rows POSITION: verified linear solve of (d_2; d_3; m) x = (K_2, K_3, sigma).

    Guarantee: where True is returned, for every point of the cell the system has exactly one
    solution and the three forms enclose it. With C the approximate inverse at the centre,
    x~ the affine approximation and s the residual, x - x~ = C s + (I - C M)(x - x~).
    """
    last = F.shape[1] - 1
    for i in range(3):
        for j in range(3):
            W[i, j] = F[FRAME + 3 * i + j, 0]
            W[i, 3 + j] = 1.0 if i == j else 0.0
    if not solve_in_place(W, 3, 3):
        return False
    worst = 0.0
    for i in range(3):
        total = 0.0
        for j in range(3):
            centre = 1.0 if i == j else 0.0
            mag = centre
            spread = 0.0
            for k in range(3):
                x = W[i, 3 + k] * F[FRAME + 3 * k + j, 0]
                centre -= x
                mag += abs(x)
            for c in range(1, last):
                v = 0.0
                for k in range(3):
                    x = W[i, 3 + k] * F[FRAME + 3 * k + j, c]
                    v += x
                    mag += abs(x)
                spread += abs(v)
            for k in range(3):
                spread += abs(W[i, 3 + k]) * F[FRAME + 3 * k + j, last]
            total += inflate(abs(centre) + spread, 4.0 * mag, 40.0)
        W[5, i] = up(total * (1.0 + 8.0 * UNIT))
        # Row by row, so that NaN (an overflow) cannot hide behind max.
        if not W[5, i] < 0.9:
            return False
        worst = max(worst, W[5, i])
    # x~: centre and slopes in floats, without error.
    for c in range(last):
        for i in range(3):
            v = F[OFFSET + i, c]
            if c > 0:
                for k in range(3):
                    v -= F[FRAME + 3 * i + k, c] * F[POSITION + k, 0]
            W[6, i] = v
        for i in range(3):
            F[POSITION + i, c] = W[i, 3] * W[6, 0] + W[i, 4] * W[6, 1] + W[i, 5] * W[6, 2]
    for i in range(3):
        F[POSITION + i, last] = 0.0
    for i in range(3):
        affine.dot(F, SCRATCH + 3, FRAME + 3 * i, POSITION, 3)
        affine.subtract(F, SCRATCH + i, OFFSET + i, SCRATCH + 3)
    largest = 0.0
    for i in range(3):
        affine.combine3(F, SCRATCH + 3, SCRATCH, W[i, 3], W[i, 4], W[i, 5], 0.0, 0.0)
        lo, hi = affine.bounds(F, SCRATCH + 3)
        W[6, i] = max(-lo, hi)
        largest = max(largest, W[6, i])
    gain = up(largest / down(1.0 - worst))
    for i in range(3):
        F[POSITION + i, last] = up(W[6, i] + up(W[5, i] * gain))
    return math.isfinite(gain)


@njit(cache=True, nogil=True)
def length_gap(F: Any, out: int, model: Any, chart: int, i: int, pivot: int) -> tuple[float, float]:
    """Write K_i - d_i . x = (|c_i - p|^2 - l_i^2) / 2 for a cable outside the triple, and bound it."""
    squared_distance(F, SCRATCH, model, chart, i, pivot)
    offset_form(F, SCRATCH + 1, SCRATCH, model, i, pivot)
    rotated_step(F, SCRATCH + 2, model, chart, i, pivot)
    affine.dot(F, SCRATCH + 5, SCRATCH + 2, POSITION, 3)
    affine.subtract(F, out, SCRATCH + 1, SCRATCH + 5)
    return affine.bounds(F, out)


@njit(cache=True, nogil=True)
def cable_forms(F: Any, model: Any, chart: int, pivot: int) -> None:
    """Write r_i and e_i = d_i - x of the taut cables."""
    for i in range(model.n_taut):
        r = CABLE + BLOCK * i
        rotated_point(F, r, model, chart, i)
        rotated_step(F, SCRATCH, model, chart, i, pivot)
        for k in range(3):
            affine.subtract(F, r + 3 + k, SCRATCH + k, POSITION + k)


@njit(cache=True, nogil=True)
def position_bounds(F: Any, W: Any, model: Any, pivot: int, lo: Any, hi: Any) -> None:
    """Enclose p = A_1 - r_1 + x over the cell; needs ``cable_forms``."""
    r = CABLE + BLOCK * pivot
    for k in range(3):
        affine.subtract(F, SCRATCH, POSITION + k, r + k)
        a, b = affine.bounds(F, SCRATCH)
        lo[k] = down(down(a + model.anchors[pivot, k]) - model.anchors_err[pivot, k])
        hi[k] = up(up(b + model.anchors[pivot, k]) + model.anchors_err[pivot, k])
    if model.planar:
        # The equilibrium lies in the plane exactly (and the root's box has no width across it).
        lo[1] = 0.0
        hi[1] = 0.0


@njit(cache=True, nogil=True)
def enclose_position(F: Any, W: Any, model: Any, cell: Any, lo: Any, hi: Any) -> bool:
    """Enclose (u, p) over the cell in the first six entries; False when p cannot be bounded."""
    chart = int(cell[CHART])
    order = int(cell[ORDER])
    pivot = model.orders[order, 0]
    if not rotation_forms(F, cell):
        return False
    triple_forms(F, model, chart, order)
    affine.variable(F, OFFSET + 2, 4, cell[SIGMA_LO], cell[SIGMA_HI])
    if not position_forms(F, W):
        return False
    cable_forms(F, model, chart, pivot)
    pose_bounds(F, W, model, cell, pivot, lo, hi)
    return True


@njit(cache=True, nogil=True)
def enclose_cell(F: Any, W: Any, model: Any, cell: Any, lo: Any, hi: Any) -> bool:
    """Enclose (u, p, t) of every equilibrium of the taut cables in the cell.

    ``lo, hi`` : (6 + n,). False when the position or the tensions cannot be bounded.
    """
    if not enclose_position(F, W, model, cell, lo, hi):
        return False
    return finish_enclosure(F, W, model, lo, hi)


@njit(cache=True, nogil=True)
def pose_bounds(F: Any, W: Any, model: Any, cell: Any, pivot: int, lo: Any, hi: Any) -> None:
    """Write (u, p) bounds, given the cables' forms."""
    for k in range(3):
        lo[k] = cell[2 * k]
        hi[k] = cell[2 * k + 1]
    position_bounds(F, W, model, pivot, lo[3:6], hi[3:6])


@njit(cache=True, nogil=True)
def finish_enclosure(F: Any, W: Any, model: Any, lo: Any, hi: Any) -> bool:
    """Write the bounds of t behind those of (u, p), given the cables' forms."""
    if model.n_taut == 6:
        # Six lengths alone fix the pose; t is not an unknown then and stands as 0 in the roots.
        lo[6:] = 0.0
        hi[6:] = 0.0
        return True
    moment_forms(F, model)
    return tension_bounds(F, W, model, lo[6:], hi[6:])


@njit(cache=True, nogil=True)
def settled(F: Any, W: Any, model: Any, roots: Any, cell: Any, pivot: int, lo: Any, hi: Any) -> bool:
    """Return True when every equilibrium in the cell lies in one root's uniqueness box.

    ``roots`` : (m, 1 + 2 (6 + n)) chart, then lo and hi of the boxes. Needs ``cable_forms``.
    """
    size = 6 + model.n_taut
    bounded = False
    for k in range(roots.shape[0]):
        if int(roots[k, 0]) != int(cell[CHART]):
            continue
        near = True
        for c in range(3):
            near = near and roots[k, 1 + c] <= cell[2 * c] and cell[2 * c + 1] <= roots[k, 1 + size + c]
        if not near:
            continue
        if not bounded:
            pose_bounds(F, W, model, cell, pivot, lo, hi)
            if not finish_enclosure(F, W, model, lo, hi):
                return False
            bounded = True
        inside = True
        for c in range(size):
            inside = inside and roots[k, 1 + c] <= lo[c] and hi[c] <= roots[k, 1 + size + c]
        if inside:
            return True
    return False


@njit(cache=True, nogil=True)
def leaf(cell: Any, children: Any, kind: int) -> int:
    """Return the cell as a leaf."""
    for k in range(cell.shape[0]):
        children[0, k] = cell[k]
    return -kind


@njit(cache=True, nogil=True)
def halve(cell: Any, children: Any, lo: int) -> int:
    """Bisect the variable whose bounds stand at ``lo, lo + 1``; a leaf where no double lies between them."""
    m = 0.5 * (cell[lo] + cell[lo + 1])
    if not cell[lo] < m < cell[lo + 1]:
        return leaf(cell, children, SMALL)
    for k in range(cell.shape[0]):
        children[0, k] = cell[k]
        children[1, k] = cell[k]
    children[0, lo + 1] = m
    children[1, lo] = m
    share = 0.5 * cell[cell.shape[0] - 1]
    children[0, cell.shape[0] - 1] = share
    children[1, cell.shape[0] - 1] = share
    return 2


@njit(cache=True, nogil=True)
def copy_cell(cell: Any, children: Any) -> None:
    """Write the cell as its own only child."""
    for k in range(cell.shape[0]):
        children[0, k] = cell[k]


@njit(cache=True, nogil=True)
def newton_contract(F: Any, W: Any, model: Any, cell: Any, equations: int, lo: Any, hi: Any) -> int:
    """Contract the cell by the sphere, the further lengths (already in EQUATION...) and the statics."""
    affine.multiply(F, SCRATCH, OFFSET + 2, OFFSET + 2)
    affine.subtract(F, SCRATCH + 1, EQUATION, SCRATCH)
    for k in range(F.shape[1]):
        F[EQUATION, k] = F[SCRATCH + 1, k]
    if model.n_taut < 6:
        moment_forms(F, model)
        if tension_bounds(F, W, model, lo[6:], hi[6:]):
            equations += statics_equations(F, W, model, EQUATION + equations, lo[6:], hi[6:])
    return contract(F, W, cell, equations)


@njit(cache=True, nogil=True)
def process(context: Any, cell: Any, children: Any) -> int:
    """Exclude, contract, settle or split one (u, sigma) cell; see ``engine.depth_first``."""
    model, roots, leaf_size, F, W, lo, hi = context
    chart = int(cell[CHART])
    order = int(cell[ORDER])
    pivot = model.orders[order, 0]
    widest = 0
    width = 0.0
    for k in range(3):
        if cell[2 * k + 1] - cell[2 * k] > width:
            width = cell[2 * k + 1] - cell[2 * k]
            widest = k
    if not rotation_forms(F, cell):
        return halve(cell, children, 2 * widest)
    triple_forms(F, model, chart, order)
    slo, shi, mlo, mhi = sphere_bounds(F, model, order)
    if shi < 0.0:
        return 0
    # sigma^2 lies in [slo, shi]: keep the parts of the cell's sigma range that do.
    top = up(math.sqrt(shi))
    bottom = down(math.sqrt(slo)) if slo > 0.0 else 0.0
    cell[SIGMA_LO] = max(cell[SIGMA_LO], -top)
    cell[SIGMA_HI] = min(cell[SIGMA_HI], top)
    if bottom > 0.0:
        negative = cell[SIGMA_LO] <= -bottom
        positive = cell[SIGMA_HI] >= bottom
        if negative and positive:
            halve(cell, children, SIGMA_LO)
            children[0, SIGMA_HI] = -bottom
            children[1, SIGMA_LO] = bottom
            return 2
        if negative:
            cell[SIGMA_HI] = min(cell[SIGMA_HI], -bottom)
        else:
            cell[SIGMA_LO] = max(cell[SIGMA_LO], bottom)
    if cell[SIGMA_LO] > cell[SIGMA_HI]:
        return 0
    affine.variable(F, OFFSET + 2, 4, cell[SIGMA_LO], cell[SIGMA_HI])
    if not (mlo > 0.0 and position_forms(F, W)):
        if width > FLAT_SIZE:
            return halve(cell, children, 2 * widest)
        if mlo <= 0.0 or width <= leaf_size:
            return leaf(cell, children, FLAT)
        return halve(cell, children, 2 * widest)
    equations = 1
    for i in range(model.lengths.shape[0]):
        taut = i < model.n_taut
        if not taut and not model.slack:
            break
        in_triple = (
            i == pivot or i == model.orders[order, 1] or (not model.planar and i == model.orders[order, 2])
        )
        if taut and in_triple:
            continue
        glo, ghi = length_gap(F, EQUATION + equations, model, chart, i, pivot)
        if glo > 0.0 or (taut and ghi < 0.0):
            return 0
        if taut:
            equations += 1
    cable_forms(F, model, chart, pivot)
    if model.statics and statics_excluded(F, W, model):
        return 0
    if settled(F, W, model, roots, cell, pivot, lo, hi):
        return 0
    if width <= NEWTON_SIZE:
        verdict = newton_contract(F, W, model, cell, equations, lo, hi)
        if verdict == EMPTY:
            return 0
        if verdict == SMALLER:
            copy_cell(cell, children)
            return 1
    scale = model.lengths[pivot, 1] * math.sqrt(mhi)
    sigma_width = SIGMA_WEIGHT * (cell[SIGMA_HI] - cell[SIGMA_LO]) / scale
    if max(width, sigma_width) <= leaf_size:
        return leaf(cell, children, SMALL)
    if sigma_width > width:
        return halve(cell, children, SIGMA_LO)
    return halve(cell, children, 2 * widest)


@njit(cache=True, nogil=True)
def run(
    model: Any,
    roots: Any,
    leaf_size: float,
    F: Any,
    W: Any,
    lo: Any,
    hi: Any,
    stack: Any,
    count: int,
    leaves: Any,
    kinds: Any,
    children: Any,
    cell_limit: int,
) -> tuple[int, int, int]:
    """Search (u, sigma) cells depth first; see ``engine.depth_first``."""
    context = (model, roots, leaf_size, F, W, lo, hi)
    return depth_first(process, context, stack, count, leaves, kinds, children, cell_limit)
