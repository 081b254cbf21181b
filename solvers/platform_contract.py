"""Interval Newton on a cell: all equations as affine forms, solved for the cell's own variables.

For (u, sigma) cells the equations are the sphere of the triple, each further length, and
y . (sum t_i w_i + w_0) = 0 for every y across the wrenches at the centre; together as many as
variables. With g the forms' centres, A their linear parts and C a float left inverse of A,
eps + C g + (C A - I) eps + C (errors) = 0 bounds every symbol eps_k: the cell shrinks around its root
quadratically, or is empty.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from cdpr_interval.kernels import affine
from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.rounding import down, inflate, up
from solvers.platform_forms import BLOCK, CABLE, EQUATION, SCRATCH

EMPTY, STUCK, SMALLER = 0, 1, 2
"""What a contraction did to a cell; SMALLER means it is worth another look before bisecting."""
WORTH = 0.6
"""A contraction counts as SMALLER when one variable keeps at most this share of its width."""
NORMAL = 24
"""First of the rows of W that hold the y across the wrenches."""
SYSTEM = 8
"""First of the rows of W that hold C, one for each symbol."""


@njit(cache=True, nogil=True)
def across_wrenches(F: Any, W: Any, model: Any) -> int:
    """Write an orthonormal basis of the complement of the centre's wrenches to W[NORMAL...]; return its size.

    Gram-Schmidt on the wrenches, then on the unit vectors, largest remainder first. Any vectors
    would do for the proof; these make the equations free of the tensions to first order.
    """
    n = model.n_taut
    size = model.size
    count = 0  # wrenches and normals so far, in rows 8 .. 8 + count - 1
    base = SYSTEM
    for i in range(n):
        r = CABLE + BLOCK * i + 3
        for k in range(6):
            W[base + count, k] = F[r + k, 0] if k < 3 else F[r + k, 0] / size
        if orthogonalise(W, base, count):
            count += 1
    rank = count
    if rank < n:
        return 0
    while count < 6:
        best = -1.0
        chosen = 0
        for k in range(6):
            left = 1.0
            for j in range(count):
                left -= W[base + j, k] ** 2
            if left > best:
                best = left
                chosen = k
        for k in range(6):
            W[base + count, k] = 1.0 if k == chosen else 0.0
        if not orthogonalise(W, base, count):
            return 0
        count += 1
    for j in range(6 - rank):
        for k in range(6):
            W[NORMAL + j, k] = W[base + rank + j, k] if k < 3 else W[base + rank + j, k] / size
    return 6 - rank


@njit(cache=True, nogil=True)
def orthogonalise(W: Any, base: int, count: int) -> bool:
    """Make row base + count orthonormal to the rows before it; False when nothing is left."""
    row = base + count
    before = 0.0
    for k in range(6):
        before += W[row, k] ** 2
    for _ in range(2):
        for j in range(count):
            s = 0.0
            for k in range(6):
                s += W[row, k] * W[base + j, k]
            for k in range(6):
                W[row, k] -= s * W[base + j, k]
    after = 0.0
    for k in range(6):
        after += W[row, k] ** 2
    if not after > 1e-20 * before:
        return False
    norm = after**0.5
    for k in range(6):
        W[row, k] /= norm
    return True


@njit(cache=True, nogil=True)
def statics_equations(F: Any, W: Any, model: Any, first: int, lo: Any, hi: Any) -> int:
    """Write y . (sum t_i w_i + w_0) for every y in W[NORMAL...] to the rows from ``first``; return how many.

    ``lo, hi`` (n,) bound t over the cell. y . w_i = e_i . (y_f + y_m x r_i) has a centre near 0, so a
    form times t_i is its middle times the form, plus the form's magnitude times t_i's radius.
    """
    n = model.n_taut
    last = F.shape[1] - 1
    count = across_wrenches(F, W, model)
    g = SCRATCH
    for j in range(count):
        y = NORMAL + j
        out = first + j
        centre = 0.0
        mag = 0.0
        error = 0.0
        for k in range(3):
            x = W[y, k] * model.load[k]
            centre += x
            mag += abs(x)
            error += abs(W[y, k]) * model.load_err[k]
        affine.constant(F, out, centre, 0.0)
        for i in range(n):
            r = CABLE + BLOCK * i
            m0, m1, m2 = W[y, 3], W[y, 4], W[y, 5]
            affine.combine3(F, g, r, 0.0, -m2, m1, W[y, 0], 0.0)
            affine.combine3(F, g + 1, r, m2, 0.0, -m0, W[y, 1], 0.0)
            affine.combine3(F, g + 2, r, -m1, m0, 0.0, W[y, 2], 0.0)
            affine.dot(F, g + 3, r + 3, g, 3)
            middle = 0.5 * (lo[i] + hi[i])
            spread = max(up(hi[i] - middle), up(middle - lo[i]))
            a, b = affine.bounds(F, g + 3)
            error += abs(middle) * F[g + 3, last] + spread * max(-a, b)
            for k in range(last):
                x = middle * F[g + 3, k]
                F[out, k] += x
                mag += abs(x)
        # A term passes one product and at most n + 3 sums.
        F[out, last] = inflate(error, 5.0 * mag, 60.0)
    return count


@njit(cache=True, nogil=True)
def contract(F: Any, W: Any, cell: Any, equations: int) -> int:
    """Shrink the cell by the forms in rows EQUATION..., all of which vanish at every solution.

    Symbol k stands for the variable with bounds cell[2 k - 2], cell[2 k - 1] (middle and half width
    as ``affine.variable`` takes them; the forms may come from a larger cell only if its symbols
    were the same). Returns EMPTY, STUCK or SMALLER.
    """
    symbols = F.shape[1] - 2
    last = symbols + 1
    # Normal equations of the rows scaled to largest entry 1; fixed variables (half width 0) drop out.
    for k in range(symbols):
        for m in range(symbols):
            W[k, m] = 0.0
    for e in range(equations):
        scale = 0.0
        for k in range(symbols):
            scale = max(scale, abs(F[EQUATION + e, k + 1]))
        # An equation whose error drowns its slopes (0 = 0 on a symmetry) would only add noise.
        useful = 1e-100 < scale < 1e100 and F[EQUATION + e, last] < scale
        W[NORMAL + 6, e] = 1.0 / (scale * scale) if useful else 0.0
        for k in range(symbols):
            for m in range(symbols):
                W[k, m] += F[EQUATION + e, k + 1] * F[EQUATION + e, m + 1] * W[NORMAL + 6, e]
    for k in range(symbols):
        if not cell[2 * k] < cell[2 * k + 1]:
            W[k, k] += 1.0
        for e in range(equations):
            W[k, symbols + e] = F[EQUATION + e, k + 1] * W[NORMAL + 6, e]
    if not solve_in_place(W, symbols, equations):
        return STUCK
    verdict = STUCK
    for k in range(symbols):
        if not cell[2 * k] < cell[2 * k + 1]:
            continue
        centre = 0.0
        mag = 0.0
        error = 0.0
        for e in range(equations):
            c = W[k, symbols + e]
            x = c * F[EQUATION + e, 0]
            centre -= x
            mag += abs(x)
            error += abs(c) * F[EQUATION + e, last]
        for m in range(symbols):
            v = -1.0 if m == k else 0.0
            for e in range(equations):
                x = W[k, symbols + e] * F[EQUATION + e, m + 1]
                v += x
                mag += abs(x)
            error += abs(v)
            mag += 1.0
        error = inflate(error, (0.5 * equations + 2.0) * mag, 80.0)
        low, high = down(centre - error), up(centre + error)
        if not low <= high:
            continue
        if low > 1.0 or high < -1.0:
            return EMPTY
        if (low > -1.0 or high < 1.0) and cut(cell, 2 * k, max(low, -1.0), min(high, 1.0)):
            verdict = SMALLER
    return verdict


@njit(cache=True, nogil=True)
def cut(cell: Any, j: int, low: float, high: float) -> bool:
    """Cut the variable with bounds cell[j], cell[j + 1] to symbols in [low, high]; True if much is gone."""
    lo, hi = cell[j], cell[j + 1]
    m = 0.5 * (lo + hi)
    half = max(up(hi - m), up(m - lo))
    cell[j] = max(lo, down(m + down(half * low)))
    cell[j + 1] = min(hi, up(m + up(half * high)))
    if cell[j] > cell[j + 1]:
        # Only by rounding at a corner, where no solution is: one point keeps the cell well formed.
        cell[j + 1] = cell[j]
    return cell[j + 1] - cell[j] <= WORTH * (hi - lo)
