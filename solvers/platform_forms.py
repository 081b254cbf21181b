"""Affine forms of a platform over a cell: rotation, centres, wrenches, and the tests made of them.

Rows of the form array ``F`` (see ``kernels.affine``) have fixed places, named below. Symbols
1..3 are u; the others are the cell's position variables. ``W`` is float scratch.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from cdpr_interval.kernels import affine
from cdpr_interval.kernels.dense import solve_in_place
from cdpr_interval.kernels.rounding import UNIT, down, inflate, up

ROTATION = 0
"""Nine rows: R, row by row."""
U = 9
"""Three rows: u."""
SCRATCH = 12
"""Fourteen rows used inside one function."""
POSITION = 26
"""Three rows: p - c_1 in the (u, sigma) search, p in the (u, p) search."""
CENTRE = 29
"""Three rows: c_1 in the (u, sigma) search."""
GRAM = 32
"""Rows |d_2|^2, |d_3|^2, d_2 . d_3."""
OFFSET = 35
"""Rows K_2, K_3, sigma: right-hand sides of the linear system of the position."""
FRAME = 38
"""Nine rows: d_2, d_3, m."""
CABLE = 47
"""First row of the taut cables' blocks."""
BLOCK = 9
"""Rows of a cable's block: r_i (3), e_i (3), r_i x e_i (3)."""
MOST_TAUT = 6
EQUATION = CABLE + BLOCK * MOST_TAUT
"""First of the rows that hold equations of the cell."""
MOST_EQUATIONS = 8
FORM_ROWS = EQUATION + MOST_EQUATIONS
SPARE = 8
"""Rows of W below this index serve small linear systems, the others as named by their users."""
WORK_SHAPE = (32, 24)


@njit(cache=True, nogil=True)
def rotation_forms(F: Any, cell: Any) -> bool:
    """Write u and R(u) = I + g N with g = 2 / (1 + |u|^2), N = [u]_x + u u^T - |u|^2 I."""
    for k in range(3):
        affine.variable(F, U + k, k + 1, cell[2 * k], cell[2 * k + 1])
    s = SCRATCH
    for k in range(3):
        affine.multiply(F, s + k, U + k, U + k)
    affine.multiply(F, s + 3, U + 1, U + 2)
    affine.multiply(F, s + 4, U, U + 2)
    affine.multiply(F, s + 5, U, U + 1)
    affine.combine3(F, s + 6, s, 0.5, 0.5, 0.5, 0.5, 0.0)
    if not affine.reciprocal(F, s + 7, s + 6):
        return False
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        # Diagonal: -(u_i^2 + u_j^2); off the diagonal: u_i u_j -+ u_k.
        affine.combine3(
            F, s + 8, s, 0.0 if k == 0 else -1.0, 0.0 if k == 1 else -1.0, 0.0 if k == 2 else -1.0, 0.0, 0.0
        )
        affine.multiply(F, ROTATION + 4 * k, s + 7, s + 8)
        F[ROTATION + 4 * k, 0] += 1.0
        last = F.shape[1] - 1
        F[ROTATION + 4 * k, last] = inflate(F[ROTATION + 4 * k, last], abs(F[ROTATION + 4 * k, 0]), 4.0)
        affine.subtract(F, s + 9, s + 3 + k, U + k)
        affine.multiply(F, ROTATION + 3 * i + j, s + 7, s + 9)
        affine.add(F, s + 9, s + 3 + k, U + k)
        affine.multiply(F, ROTATION + 3 * j + i, s + 7, s + 9)
    return True


@njit(cache=True, nogil=True)
def squared_distance(F: Any, out: int, model: Any, chart: int, i: int, j: int) -> None:
    """Write |c_i - c_j|^2, which is linear in R."""
    last = F.shape[1] - 1
    mag = abs(model.square[i, j])
    for k in range(last):
        F[out, k] = 0.0
    error = 0.0
    spread = 0.0
    for row in range(3):
        a = -2.0 * model.anchor_steps[i, j, row]
        a_err = 2.0 * model.anchor_steps_err[i, j, row]
        for col in range(3):
            b = model.point_steps[chart, i, j, col]
            b_err = model.point_steps_err[i, j, col]
            c = a * b
            # |R entry| <= 1 for the true rotation, so errors of the coefficient enter as they are.
            spread += abs(a) * b_err + (abs(b) + b_err) * a_err + UNIT * abs(c)
            r = ROTATION + 3 * row + col
            for k in range(last):
                x = c * F[r, k]
                F[out, k] += x
                mag += abs(x)
            error += abs(c) * F[r, last]
    F[out, 0] += model.square[i, j]
    # A term passes one product and at most 10 sums.
    F[out, last] = inflate(error + spread + model.square_err[i, j], 6.0 * mag, 160.0)


@njit(cache=True, nogil=True)
def rotated_step(F: Any, out: int, model: Any, chart: int, i: int, j: int) -> None:
    """Write the three rows of c_i - c_j = (A_i - A_j) - R (b_i - b_j)."""
    b0 = model.point_steps[chart, i, j, 0]
    b1 = model.point_steps[chart, i, j, 1]
    b2 = model.point_steps[chart, i, j, 2]
    spread = model.point_steps_err[i, j, 0] + model.point_steps_err[i, j, 1] + model.point_steps_err[i, j, 2]
    for k in range(3):
        error = inflate(spread + model.anchor_steps_err[i, j, k], 0.0, 4.0)
        affine.combine3(F, out + k, ROTATION + 3 * k, -b0, -b1, -b2, model.anchor_steps[i, j, k], error)


@njit(cache=True, nogil=True)
def rotated_point(F: Any, out: int, model: Any, chart: int, i: int) -> None:
    """Write the three rows of r_i = R b_i."""
    spread = inflate(model.points_err[i, 0] + model.points_err[i, 1] + model.points_err[i, 2], 0.0, 4.0)
    b = model.points
    for k in range(3):
        affine.combine3(
            F, out + k, ROTATION + 3 * k, b[chart, i, 0], b[chart, i, 1], b[chart, i, 2], 0.0, spread
        )


@njit(cache=True, nogil=True)
def centre_forms(F: Any, out: int, model: Any, i: int, r: int) -> None:
    """Write the three rows of c_i = A_i - r_i, with r_i in the rows from ``r``."""
    last = F.shape[1] - 1
    for k in range(3):
        a = model.anchors[i, k]
        for c in range(last):
            F[out + k, c] = -F[r + k, c]
        F[out + k, 0] += a
        F[out + k, last] = inflate(F[r + k, last] + model.anchors_err[i, k], abs(F[out + k, 0]), 4.0)


@njit(cache=True, nogil=True)
def statics_excluded(F: Any, W: Any, model: Any) -> bool:
    """Return True when one y in R^6 proves that the cell holds no equilibrium.

    Guarantee (Gordan): y . w_i > 0 for every taut cable and y . w_0 > 0 over the whole cell, so
    sum t_i w_i + w_0 = 0 has no solution with t >= 0 there. y is found in floats at the cell's
    centre: first the least-norm y with y . w_i = 1 (wrenches normalised), then once more with
    right sides proportional to the radius of each form over the cell.
    """
    n = model.n_taut
    size = model.size
    # Columns: normalised wrenches at the centre, moments divided by the platform's size.
    for i in range(n):
        r = CABLE + BLOCK * i
        ex, ey, ez = F[r + 3, 0], F[r + 4, 0], F[r + 5, 0]
        rx, ry, rz = F[r, 0] / size, F[r + 1, 0] / size, F[r + 2, 0] / size
        W[SPARE + i, 0] = ex
        W[SPARE + i, 1] = ey
        W[SPARE + i, 2] = ez
        W[SPARE + i, 3] = ry * ez - rz * ey
        W[SPARE + i, 4] = rz * ex - rx * ez
        W[SPARE + i, 5] = rx * ey - ry * ex
    for k in range(3):
        W[SPARE + n, k] = model.load[k]
        W[SPARE + n, 3 + k] = 0.0
    for i in range(n + 1):
        s = 0.0
        for k in range(6):
            s += W[SPARE + i, k] ** 2
        s = s**0.5
        if not s > 0.0:
            return False
        W[SPARE + i, 6] = s
        W[SPARE + i, 7] = 1.0
        for k in range(6):
            W[SPARE + i, k] /= s
    for _ in range(2):
        if not _choose_y(W, n):
            return False
        if _forms_positive(F, W, model):
            return True
        # W[SPARE + i, 7] now holds the radius of form i over the cell, normalised.
    return False


Y = 20
"""Row of W that holds y."""


@njit(cache=True, nogil=True)
def _choose_y(W: Any, n: int) -> bool:
    """Write to W[Y] the least-norm y with y . w_i = W[SPARE + i, 7] for i <= n."""
    m = n + 1
    if n == 6:
        if not _balance_seven(W):
            return False
        m = 6
    for i in range(m):
        for j in range(m):
            s = 0.0
            for k in range(6):
                s += W[SPARE + i, k] * W[SPARE + j, k]
            W[i, j] = s
        # A trace of regularisation: a useless y only costs a bisection.
        W[i, i] += 1e-12
        W[i, m] = W[SPARE + i, 7]
    if not solve_in_place(W, m, 1):
        return False
    for k in range(6):
        s = 0.0
        for i in range(m):
            s += W[i, m] * W[SPARE + i, k]
        W[Y, k] = s
    return True


@njit(cache=True, nogil=True)
def _balance_seven(W: Any) -> bool:
    """Six cables: seven forms in six unknowns; change the right sides r > 0 so that lambda . r = 0.

    lambda is the kernel of the seven wrenches. False when its entries have one sign: then the
    centre has an equilibrium with positive tensions and no y exists.
    """
    for k in range(6):
        for i in range(6):
            W[k, i] = W[SPARE + i, k]
        W[k, 6] = -W[SPARE + 6, k]
    if not solve_in_place(W, 6, 1):
        return False
    positive = W[SPARE + 6, 7]
    negative = 0.0
    for i in range(6):
        x = W[i, 6] * W[SPARE + i, 7]
        if x > 0.0:
            positive += x
        else:
            negative -= x
    if not negative > 0.0:
        return False
    for i in range(6):
        if W[i, 6] > 0.0:
            W[SPARE + i, 7] *= negative / positive
    W[SPARE + 6, 7] *= negative / positive
    return True


@njit(cache=True, nogil=True)
def _forms_positive(F: Any, W: Any, model: Any) -> bool:
    """Return True when y . w > 0 is proved for all taut cables and the load.

    Uses y . w_i = e_i . (y_f + y_m x r_i). Leaves the normalised radii in W[SPARE + i, 7].
    """
    n = model.n_taut
    f0, f1, f2 = W[Y, 0], W[Y, 1], W[Y, 2]
    size = model.size
    m0, m1, m2 = W[Y, 3] / size, W[Y, 4] / size, W[Y, 5] / size
    centre = 0.0
    spread = 0.0
    mag = 0.0
    for k in range(3):
        x = W[Y, k] * model.load[k]
        centre += x
        mag += abs(x)
        spread += abs(W[Y, k]) * model.load_err[k]
    excluded = centre > inflate(spread, 2.0 * mag, 10.0)
    largest = 0.0
    g = SCRATCH
    for i in range(n):
        r = CABLE + BLOCK * i
        affine.combine3(F, g, r, 0.0, -m2, m1, f0, 0.0)
        affine.combine3(F, g + 1, r, m2, 0.0, -m0, f1, 0.0)
        affine.combine3(F, g + 2, r, -m1, m0, 0.0, f2, 0.0)
        affine.dot(F, g + 3, r + 3, g, 3)
        radius = affine.radius(F, g + 3)
        lo = affine.bounds(F, g + 3)[0]
        excluded = excluded and lo > 0.0
        W[SPARE + i, 7] = radius / W[SPARE + i, 6]
        largest = max(largest, W[SPARE + i, 7])
    # The load does not vary; a small right side keeps its form positive.
    W[SPARE + n, 7] = 0.0
    for i in range(n + 1):
        W[SPARE + i, 7] += 1e-3 * largest + 1e-300
    return excluded


@njit(cache=True, nogil=True)
def moment_forms(F: Any, model: Any) -> None:
    """Write r_i x e_i for the taut cables into their blocks."""
    for i in range(model.n_taut):
        r = CABLE + BLOCK * i
        for k in range(3):
            a, b = (k + 1) % 3, (k + 2) % 3
            affine.minor(F, r + 6 + k, r + a, r + 3 + b, r + b, r + 3 + a)


@njit(cache=True, nogil=True)
def tension_bounds(F: Any, W: Any, model: Any, lo: Any, hi: Any) -> bool:
    """Enclose every t with sum t_i w_i + w_0 = 0 at some point of the cell (t_i = tension / |e_i|).

    Needs ``moment_forms``. Verified least squares: with C an approximate left inverse of the
    wrench matrix at the centre and t~ = -C w_0, any such t satisfies t - t~ = C s + (I - C W)(t - t~),
    s = -w_0 - W t~, so max|t - t~| <= max|C s| / (1 - |I - C W|). False when |I - C W| < 1 cannot be
    proved: the tensions may then be unbounded or not unique.
    """
    n = model.n_taut
    last = F.shape[1] - 1
    if not _left_inverse(F, W, model):
        return False
    left = SPARE  # rows SPARE .. SPARE + n - 1 hold C (n x 6) for unscaled wrenches
    for i in range(n):
        s = 0.0
        for k in range(3):
            s -= W[left + i, k] * model.load[k]
        W[Y, i] = s
    # |I - C W| row by row, and |C s|.
    worst = 0.0
    largest = 0.0
    for i in range(n):
        total = 0.0
        for j in range(n):
            r = CABLE + BLOCK * j + 3
            centre = 1.0 if i == j else 0.0
            mag = centre
            spread = 0.0
            for k in range(6):
                x = W[left + i, k] * F[r + k, 0]
                centre -= x
                mag += abs(x)
            for c in range(1, last):
                v = 0.0
                for k in range(6):
                    x = W[left + i, k] * F[r + k, c]
                    v += x
                    mag += abs(x)
                spread += abs(v)
            for k in range(6):
                spread += abs(W[left + i, k]) * F[r + k, last]
            total += inflate(abs(centre) + spread, 5.0 * mag, 60.0)
        W[Y + 1, i] = total
        # Row by row, so that NaN (an overflow) cannot hide behind max.
        if not up(total * (1.0 + 16.0 * UNIT)) < 0.95:
            return False
        worst = max(worst, up(total * (1.0 + 16.0 * UNIT)))
        centre = 0.0
        mag = 0.0
        spread = 0.0
        for k in range(3):
            x = W[left + i, k] * model.load[k]
            centre += x
            mag += abs(x)
            spread += abs(W[left + i, k]) * model.load_err[k]
        for c in range(last):
            v = 0.0
            for j in range(n):
                r = CABLE + BLOCK * j + 3
                for k in range(6):
                    x = W[left + i, k] * F[r + k, c] * W[Y, j]
                    v += x
                    mag += abs(x)
            if c == 0:
                centre += v
            else:
                spread += abs(v)
        for j in range(n):
            r = CABLE + BLOCK * j + 3
            for k in range(6):
                # 1e-300: products that underflowed before they met W[Y, j].
                spread += (abs(W[left + i, k]) * F[r + k, last] + 1e-300) * abs(W[Y, j])
        # Sums of up to 36 + 3 terms of two products each.
        W[Y + 2, i] = inflate(abs(centre) + spread, 22.0 * mag, 120.0)
        if not W[Y + 2, i] < math.inf:
            return False
        largest = max(largest, W[Y + 2, i])
    gain = up(largest / down(1.0 - worst))
    for i in range(n):
        error = up(W[Y + 2, i] + up(W[Y + 1, i] * (1.0 + 16.0 * UNIT) * gain))
        lo[i] = down(W[Y, i] - error)
        hi[i] = up(W[Y, i] + error)
    return True


@njit(cache=True, nogil=True)
def _left_inverse(F: Any, W: Any, model: Any) -> bool:
    """Write an approximate left inverse C of the centre's wrench matrix to W[SPARE + i, 0..5]."""
    n = model.n_taut
    size = model.size
    # Scaled wrenches in rows 14 .. 14 + n - 1, then C = (W^T W)^-1 W^T, unscaled at the end.
    base = 14
    for i in range(n):
        r = CABLE + BLOCK * i + 3
        for k in range(6):
            W[base + i, k] = F[r + k, 0] if k < 3 else F[r + k, 0] / size
    for i in range(n):
        for j in range(n):
            s = 0.0
            for k in range(6):
                s += W[base + i, k] * W[base + j, k]
            W[i, j] = s
        for k in range(6):
            W[i, n + k] = W[base + i, k]
    if not solve_in_place(W, n, 6):
        return False
    for i in range(n):
        for k in range(6):
            W[SPARE + i, k] = W[i, n + k] if k < 3 else W[i, n + k] / size
    return True
