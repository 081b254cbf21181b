"""A platform's geometry over a cell as polynomials: second-order forms without any division.

With the Cayley parameters u and s = 1 + |u|^2, s R(u) = (1 - |u|^2) I + 2 [u]_x + 2 u u^T is a polynomial of
degree two, which a second-order form holds exactly. Everything is therefore scaled by s, which changes
no sign and no zero. The position is x = p + r_1 - A_1, the way from the exit point A_1 to the platform
point of the first cable of the order (the pivot): with a_i = A_i - A_1, q_i = R (b_i - b_1) and
d_i = a_i - q_i (the centre of sphere i seen from that of the pivot)

    |x|^2 = l_1^2,    d_i . x = K_i,    K_i = (|d_i|^2 + l_1^2 - l_i^2) / 2        (lengths)
    w_1 = (-x, 0),    w_i = (d_i - x, q_i x (a_i - x)),    w_0 = (f, -r_1 x f)    (wrenches about that point)

where |d_i|^2 is linear in R, so that everything is linear in R and, but for the pivot's sphere, in x.

The rows of the form array ``F`` have fixed places, named below; ``W`` is float scratch.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from cdpr_interval.kernels.rounding import inflate, up
from cdpr_interval.kernels.second_order import (
    Symbols,
    add_product,
    add_scaled,
    close,
    combine3,
    constant,
    cross3,
    largest,
    magnitude,
    multiply,
    scale,
    widen,
)

ROTATION = 0
"""Nine rows: s R(u), row by row."""
SCALE = 9
"""s = 1 + |u|^2."""
SCRATCH = 10
"""Twenty rows used inside one function."""
POSITION = 30
"""Three rows: x."""
NORMAL = 33
"""Three rows: s d_2 x s d_3."""
SIGMA = 36
"""x . (s d_2 x s d_3)."""
CABLE = 37
"""First row of the blocks of the taut cables, in their order; the pivot's is not used."""
BLOCK = 7
ARM, CENTRE, OFFSET = 0, 3, 6
"""Places in a block: s q_i (3 rows), s d_i (3 rows), s K_i."""
MOST_TAUT = 6
SLACK_CABLE = CABLE + BLOCK * MOST_TAUT
"""Block of a cable outside the subset."""
PLANE = SLACK_CABLE + BLOCK
"""Block that takes the third cable's place in a plane: its normal."""
ROOT_ARM = PLANE + BLOCK
"""Three rows: s r_1."""
WRENCH = ROOT_ARM + 3
"""Six rows a cable: s w_i, moments divided by the platform's size."""
LOAD = WRENCH + 6 * MOST_TAUT
"""Six rows: s w_0."""
EQUATION = LOAD + 6
"""First of the rows of forms that vanish at every solution."""
MOST_EQUATIONS = 12
PIVOT = EQUATION + MOST_EQUATIONS
"""First of the rows of such forms, solved for one symbol each."""
FORM_ROWS = PIVOT + 6
WORK_SHAPE = (48, 24)
U_SYMBOLS = 3
"""Symbols 0..2 are u."""


@njit(cache=True, nogil=True)
def middle_and_radius(lo: float, hi: float) -> tuple[float, float]:
    """Return m and r with [lo, hi] in m + r [-1, 1]."""
    m = 0.5 * (lo + hi) if lo < hi else lo
    return m, max(up(hi - m), up(m - lo)) if lo < hi else 0.0


@njit(cache=True, nogil=True)
def vector3(a: Any, i: int, j: int) -> tuple[float, float, float]:
    """Return a[i, j] entry by entry (a slice would be counted as a reference)."""
    return a[i, j, 0], a[i, j, 1], a[i, j, 2]


@njit(cache=True, nogil=True)
def vector(a: Any, h: int, i: int, j: int) -> tuple[float, float, float]:
    """Return a[h, i, j] entry by entry."""
    return a[h, i, j, 0], a[h, i, j, 1], a[h, i, j, 2]


@njit(cache=True, nogil=True)
def settle(F: Any, i: int, mag: float, S: Symbols) -> None:
    """Finish a row whose coefficients were written by hand with a few roundings of terms of size ``mag``."""
    K = len(S)
    Q = 1 + K + K * (K + 1) // 2
    F[i, Q] = inflate(0.0, 4.0 * mag, 20.0)
    close(F, i, S)


@njit(cache=True, nogil=True)
def rotation_rows(F: Any, cell: Any, S: Symbols) -> None:
    """Write s and s R(u) for u in cell[0:6]; symbols 0..2 are the entries of u."""
    K = len(S)
    m0, r0 = middle_and_radius(cell[0], cell[1])
    m1, r1 = middle_and_radius(cell[2], cell[3])
    m2, r2 = middle_and_radius(cell[4], cell[5])
    m = (m0, m1, m2)
    r = (r0, r1, r2)
    square = m0 * m0 + m1 * m1 + m2 * m2
    mag = 1.0 + (abs(m0) + r0) ** 2 + (abs(m1) + r1) ** 2 + (abs(m2) + r2) ** 2
    constant(F, SCALE, 1.0 + square, 0.0, S)
    for k in range(3):
        F[SCALE, 1 + k] = 2.0 * m[k] * r[k]
        F[SCALE, 1 + K + k] = r[k] * r[k]
    settle(F, SCALE, mag, S)
    for i in range(3):
        for j in range(3):
            row = ROTATION + 3 * i + j
            constant(F, row, 0.0, 0.0, S)
            if i == j:
                F[row, 0] = 1.0 - square + 2.0 * m[i] * m[i]
                for k in range(3):
                    sign = 1.0 if k == i else -1.0
                    F[row, 1 + k] = sign * (2.0 * m[k] * r[k])
                    F[row, 1 + K + k] = sign * (r[k] * r[k])
                settle(F, row, 2.0 * mag, S)
                continue
            # 2 u_i u_j -+ 2 u_k: [u]_x has -u_k at (i, j) when (i, j, k) is an even permutation.
            k = 3 - i - j
            sign = -2.0 if (j - i) % 3 == 1 else 2.0
            F[row, 0] = 2.0 * m[i] * m[j] + sign * m[k]
            F[row, 1 + i] = 2.0 * m[j] * r[i]
            F[row, 1 + j] = 2.0 * m[i] * r[j]
            F[row, 1 + k] = sign * r[k]
            # Places of q_01, q_02, q_12 behind the squares.
            place = 0 if i + j == 1 else (1 if i + j == 2 else K - 1)
            F[row, 1 + 2 * K + place] = 2.0 * r[i] * r[j]
            settle(F, row, 2.0 * mag, S)


@njit(cache=True, nogil=True)
def cable_rows(F: Any, block: int, model: Any, chart: int, i: int, pivot: int, S: Symbols) -> None:
    """Write s q_i, s d_i and s K_i to the rows from ``block``. Needs ``rotation_rows``."""
    b0, b1, b2 = vector(model.point_steps, chart, i, pivot)
    a0, a1, a2 = vector3(model.anchor_steps, i, pivot)
    most = largest(F, SCALE, S)
    # |R v| <= |v| entry by entry, so errors of b enter as their sum, times s.
    e0, e1, e2 = vector3(model.point_steps_err, i, pivot)
    spread = inflate(most * (e0 + e1 + e2), 0.0, 10.0)
    for k in range(3):
        combine3(F, block + ARM + k, ROTATION + 3 * k, b0, b1, b2, spread, S)
    # K = (|a|^2 + |b|^2 + l_1^2 - l_i^2) / 2 - a . R b
    l1, li = model.lengths_sq[pivot], model.lengths_sq[i]
    half = 0.5 * (model.square[i, pivot] + (l1 - li))
    error = model.square_err[i, pivot] + model.lengths_sq_err[pivot] + model.lengths_sq_err[i]
    error = 0.5 * inflate(error, abs(model.square[i, pivot]) + abs(l1) + abs(li), 10.0) * most
    for k in range(3):
        error += model.anchor_steps_err[i, pivot, k] * largest(F, block + ARM + k, S)
    combine3(F, block + OFFSET, block + ARM, -a0, -a1, -a2, inflate(error, 0.0, 20.0), S)
    add_scaled(F, block + OFFSET, SCALE, half, S)
    for k in range(3):
        scale(F, block + CENTRE + k, SCALE, model.anchor_steps[i, pivot, k], S)
        add_scaled(F, block + CENTRE + k, block + ARM + k, -1.0, S)
        widen(F, block + CENTRE + k, inflate(model.anchor_steps_err[i, pivot, k] * most, 0.0, 4.0), S)


@njit(cache=True, nogil=True)
def triple_rows(F: Any, model: Any, chart: int, order: int, S: Symbols) -> None:
    """Write the blocks of the taut cables after the pivot and, in the plane y = 0, of y . x = 0."""
    pivot = model.orders[order, 0]
    for j in range(1, model.n_taut):
        cable_rows(F, CABLE + BLOCK * j, model, chart, model.orders[order, j], pivot, S)
    if model.planar:
        for k in range(BLOCK):
            constant(F, PLANE + k, 0.0, 0.0, S)
        scale(F, PLANE + CENTRE + 1, SCALE, 1.0, S)


@njit(cache=True, nogil=True)
def third_block(model: Any) -> int:
    """Return the block of the third equation of the triple."""
    return PLANE if model.planar else CABLE + 2 * BLOCK


@njit(cache=True, nogil=True)
def root_arm_rows(F: Any, model: Any, chart: int, order: int, S: Symbols) -> None:
    """Write s r_1, the pivot's platform point from the centre of mass."""
    pivot = model.orders[order, 0]
    b0, b1, b2 = vector3(model.points, chart, pivot)
    e = model.points_err[pivot, 0] + model.points_err[pivot, 1] + model.points_err[pivot, 2]
    spread = inflate(largest(F, SCALE, S) * e, 0.0, 10.0)
    for k in range(3):
        combine3(F, ROOT_ARM + k, ROTATION + 3 * k, b0, b1, b2, spread, S)


@njit(cache=True, nogil=True)
def length_row(F: Any, out: int, block: int, S: Symbols) -> None:
    """Write s (K_i - d_i . x) = s (|e_i|^2 - l_i^2) / 2 from a cable's block and x."""
    scale(F, out, block + OFFSET, 1.0, S)
    for k in range(3):
        add_product(F, out, block + CENTRE + k, POSITION + k, -1.0, S)


@njit(cache=True, nogil=True)
def wrench_rows(F: Any, model: Any, chart: int, order: int, S: Symbols) -> None:
    """Write s w_i of the taut cables and s w_0. Needs the blocks and x."""
    pivot = model.orders[order, 0]
    size = 1.0 / model.size  # a power of two
    for k in range(3):
        multiply(F, WRENCH + k, SCALE, POSITION + k, S)
        scale(F, WRENCH + k, WRENCH + k, -1.0, S)
        constant(F, WRENCH + 3 + k, 0.0, 0.0, S)
    for j in range(1, model.n_taut):
        block = CABLE + BLOCK * j
        w = WRENCH + 6 * j
        i = model.orders[order, j]
        for k in range(3):
            scale(F, w + k, block + CENTRE + k, 1.0, S)
            add_scaled(F, w + k, WRENCH + k, 1.0, S)
            # (a - x) / size
            scale(F, SCRATCH + k, POSITION + k, -size, S)
            F[SCRATCH + k, 0] += size * model.anchor_steps[i, pivot, k]
            error = size * model.anchor_steps_err[i, pivot, k]
            widen(F, SCRATCH + k, inflate(error, magnitude(F, SCRATCH + k, S), 10.0), S)
        cross3(F, w + 3, block + ARM, SCRATCH, S)
    load_rows(F, model, chart, order, S)


@njit(cache=True, nogil=True)
def load_rows(F: Any, model: Any, chart: int, order: int, S: Symbols) -> None:
    """Write s w_0 = s (f, -r_1 x f / size)."""
    root_arm_rows(F, model, chart, order, S)
    size = 1.0 / model.size
    most = largest(F, SCALE, S)
    for k in range(3):
        scale(F, LOAD + k, SCALE, model.load[k], S)
        widen(F, LOAD + k, inflate(model.load_err[k] * most, 0.0, 4.0), S)
        a, b = (k + 1) % 3, (k + 2) % 3
        # -(r_a f_b - r_b f_a)
        scale(F, LOAD + 3 + k, ROOT_ARM + a, -size * model.load[b], S)
        add_scaled(F, LOAD + 3 + k, ROOT_ARM + b, size * model.load[a], S)
        error = largest(F, ROOT_ARM + a, S) * model.load_err[b]
        error += largest(F, ROOT_ARM + b, S) * model.load_err[a]
        widen(F, LOAD + 3 + k, inflate(size * error, 0.0, 10.0), S)
