"""A platform's geometry over a cell as polynomials: second-order forms without any division.

With the Cayley parameters u and s = 1 + |u|^2, s R(u) = (1 - |u|^2) I + 2 [u]_x + 2 u u^T is a polynomial of
degree two, which a second-order form holds exactly; the half turn D_c of a cell's chart only changes signs.
Everything is therefore scaled by s, which changes no sign and no zero. The position is x = p + r_1 - A_1, the
way from the exit point A_1 to the platform point of the first cable of the order (the pivot): with
a_i = A_i - A_1, q_i = R (b_i - b_1) and d_i = a_i - q_i (the centre of sphere i seen from that of the pivot)

    |x|^2 = l_1^2,    d_i . x = K_i,    K_i = (|d_i|^2 + l_1^2 - l_i^2) / 2        (lengths)
    w_1 = (-x, 0),    w_i = (d_i - x, q_i x (a_i - x)),    w_0 = (f, -r_1 x f)    (wrenches about that point)

where |d_i|^2 is linear in R, so that everything is linear in R and, but for the pivot's sphere, in x.

Arrays: ``F`` (rows, columns of a form, LANES) forms, ``W`` (rows, columns, LANES) float scratch, both with
the rows of ``rows``; ``C`` (1, width of a cell, LANES) cells, one column of a cell a row of lanes; ``S``
the forms' symbols; ``model`` is an ``arrays.Model``. Each lane belongs to another cell of a batch.
"""

from __future__ import annotations

from typing import Any

from numba import types

from cdpr_interval.engine.rows import SCRATCH
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray, Lanes, array3, lanes, load, splat, store, where_less
from cdpr_interval.kernels.rounding import inflate_lanes, up_lanes
from cdpr_interval.kernels.second_order import (
    Forms,
    Symbols,
    add_datum,
    add_product,
    add_scaled,
    close,
    close_data,
    combine2,
    combine3,
    constant,
    copy,
    cross3,
    data_sum,
    largest,
    magnitude,
    multiply,
    put_datum,
    put_slope,
    rest,
    scale,
    signatures,
    slope_column,
    widen,
)
from cdpr_interval.mechanics.six_dof.rows import (
    ARM,
    ARM_SYMBOLS,
    BLOCK,
    CABLE,
    CENTRE,
    CENTRE_SYMBOLS,
    DIMENSIONS,
    EXIT_SYMBOLS,
    LOAD,
    LOAD_SYMBOLS,
    MOST_TAUT,
    OFFSET,
    PLANE,
    POSITION,
    ROOT_ARM,
    ROTATION,
    SCALE,
    WRENCH,
)

POINTS = MOST_TAUT
"""The first of the symbols of points and load among those of data: the lengths come before them."""


@kernel(types.UniTuple(lanes, 2)(lanes, lanes))
def middle_and_radius(lo: Lanes, hi: Lanes) -> tuple[Lanes, Lanes]:
    """Return m and r with [lo, hi] in m + r [-1, 1]; m = lo and r = 0 for a point."""
    m = where_less(lo, hi, 0.5 * (lo + hi), lo)
    above, below = up_lanes(hi - m), up_lanes(m - lo)
    r = where_less(above, below, below, above)
    return m, where_less(lo, hi, r, 0.0)


@kernel()
def vector3(a: Any, i: int, j: int) -> tuple[Lanes, Lanes, Lanes]:
    """Return a[i, j] of an array a (m, N, 3) in every lane (a slice would be counted as a reference)."""
    return splat(a[i, j, 0]), splat(a[i, j, 1]), splat(a[i, j, 2])


@kernel()
def first_vector(a: Any, i: int, j: int) -> tuple[Lanes, Lanes, Lanes]:
    """Return a[0, i, j] of an array a (4, N, N, 3) in every lane."""
    return splat(a[0, i, j, 0]), splat(a[0, i, j, 1]), splat(a[0, i, j, 2])


@kernel(signatures(types.void, types.int64, lanes))
def settle(F: Forms, i: int, mag: Lanes, S: Symbols) -> None:
    """Finish a row whose coefficients were written by hand with a few roundings of terms of size ``mag``."""
    K = len(S.noise)
    Q = 1 + K + K * (K + 1) // 2
    store(F, i, Q, inflate_lanes(splat(0.0), 4.0 * mag, 20.0))
    close(F, i, S)


@kernel(types.UniTuple(lanes, 3)(lanes))
def half_turn(chart: Lanes) -> tuple[Lanes, Lanes, Lanes]:
    """Return the diagonal of D_c: the identity or the half turn about x, y or z for c = 0..3."""
    about_x = where_less(chart, 1.5, 1.0, -1.0)
    about_y = where_less(abs(chart * (chart - 2.0)), 0.5, 1.0, -1.0)
    return about_x, about_y, about_x * about_y


@kernel(signatures(types.void, array3, types.int64))
def rotation_rows(F: Forms, C: LaneArray, chart: int, S: Symbols) -> None:
    """Write s and s R(u) D_c for u in columns 0..5 and c in column ``chart`` of the cells.

    Symbols 0..2 are the entries of u.
    """
    K = len(S.noise)
    m0, r0 = middle_and_radius(load(C, 0, 0), load(C, 0, 1))
    m1, r1 = middle_and_radius(load(C, 0, 2), load(C, 0, 3))
    m2, r2 = middle_and_radius(load(C, 0, 4), load(C, 0, 5))
    m = (m0, m1, m2)
    r = (r0, r1, r2)
    turn = half_turn(load(C, 0, chart))
    square = m0 * m0 + m1 * m1 + m2 * m2
    a0, a1, a2 = abs(m0) + r0, abs(m1) + r1, abs(m2) + r2
    mag = 1.0 + a0 * a0 + a1 * a1 + a2 * a2
    zero = splat(0.0)
    constant(F, SCALE, 1.0 + square, zero, S)
    for k in range(3):
        store(F, SCALE, 1 + k, 2.0 * m[k] * r[k])
        store(F, SCALE, 1 + K + k, r[k] * r[k])
    settle(F, SCALE, mag, S)
    for i in range(3):
        for j in range(3):
            row = ROTATION + 3 * i + j
            d = turn[j]
            constant(F, row, zero, zero, S)
            if i == j:
                store(F, row, 0, d * (1.0 - square + 2.0 * m[i] * m[i]))
                for k in range(3):
                    sign = 1.0 if k == i else -1.0
                    store(F, row, 1 + k, sign * d * (2.0 * m[k] * r[k]))
                    store(F, row, 1 + K + k, sign * d * (r[k] * r[k]))
                settle(F, row, 2.0 * mag, S)
                continue
            # 2 u_i u_j -+ 2 u_k: [u]_x has -u_k at (i, j) when (i, j, k) is an even permutation.
            k = 3 - i - j
            sign = -2.0 if (j - i) % 3 == 1 else 2.0
            store(F, row, 0, d * (2.0 * m[i] * m[j] + sign * m[k]))
            store(F, row, 1 + i, d * (2.0 * m[j] * r[i]))
            store(F, row, 1 + j, d * (2.0 * m[i] * r[j]))
            store(F, row, 1 + k, d * (sign * r[k]))
            # Places of q_01, q_02, q_12 behind the squares.
            place = 0 if i + j == 1 else (1 if i + j == 2 else K - 1)
            store(F, row, 1 + 2 * K + place, d * (2.0 * r[i] * r[j]))
            settle(F, row, 2.0 * mag, S)


@kernel()
def cable_rows(F: Forms, block: int, model: Any, i: int, pivot: int, S: Symbols) -> None:
    """Write s q_i, s d_i and s K_i to the rows from ``block``. Needs ``rotation_rows``."""
    b0, b1, b2 = first_vector(model.arm_steps, i, pivot)
    a0, a1, a2 = vector3(model.exit_steps, i, pivot)
    most = largest(F, SCALE, S)
    # |R v| <= |v| entry by entry, so errors of b enter as their sum, times s.
    e0, e1, e2 = vector3(model.arm_steps_err, i, pivot)
    spread = inflate_lanes(most * (e0 + e1 + e2), splat(0.0), 10.0)
    for k in range(3):
        combine3(F, block + ARM + k, ROTATION + 3 * k, b0, b1, b2, spread, S)
    # K = (|a|^2 + |b|^2 + l_1^2 - l_i^2) / 2 - a . R b
    l1, li = model.lengths_sq[pivot], model.lengths_sq[i]
    half = 0.5 * (model.square[i, pivot] + (l1 - li))
    squares = model.square_err[i, pivot]
    # Lengths of taut cables stay symbols where there are such.
    ranged = len(S.data) > 0
    if not ranged:
        squares += model.lengths_sq_err[pivot]
    if not ranged or i >= model.n_taut:
        squares += model.lengths_sq_err[i]
    squares = splat(squares)
    size = splat(abs(model.square[i, pivot]) + abs(l1) + abs(li))
    error = 0.5 * inflate_lanes(squares, size, 10.0) * most
    for k in range(3):
        error += model.exit_steps_err[i, pivot, k] * largest(F, block + ARM + k, S)
    combine3(F, block + OFFSET, block + ARM, -a0, -a1, -a2, inflate_lanes(error, splat(0.0), 20.0), S)
    add_scaled(F, block + OFFSET, SCALE, splat(half), S)
    if ranged:
        add_datum(F, block + OFFSET, SCALE, pivot, 0.5 * model.lengths_sq_err[pivot], S)
        if i < model.n_taut:
            add_datum(F, block + OFFSET, SCALE, i, -0.5 * model.lengths_sq_err[i], S)
    one = splat(1.0)
    for k in range(3):
        a = splat(model.exit_steps[i, pivot, k])
        combine2(F, block + CENTRE + k, SCALE, a, block + ARM + k, -one, S)
        error = model.exit_steps_err[i, pivot, k] * most
        widen(F, block + CENTRE + k, inflate_lanes(error, splat(0.0), 4.0), S)


@kernel()
def triple_rows(F: Forms, model: Any, S: Symbols) -> None:
    """Write the blocks of the taut cables after the pivot and, in the plane y = 0, of y . x = 0."""
    pivot = model.orders[0, 0]
    for j in range(1, model.n_taut):
        cable_rows(F, CABLE + BLOCK * j, model, model.orders[0, j], pivot, S)
    if model.planar:
        zero = splat(0.0)
        for k in range(BLOCK):
            constant(F, PLANE + k, zero, zero, S)
        copy(F, PLANE + CENTRE + 1, SCALE, S)


@kernel()
def third_block(model: Any) -> int:
    """Return the block of the third equation of the triple."""
    return PLANE if model.planar else CABLE + 2 * BLOCK


@kernel()
def root_arm_rows(F: Forms, model: Any, S: Symbols) -> None:
    """Write s r_1, the pivot's platform point from the centre of mass."""
    pivot = model.orders[0, 0]
    b0, b1, b2 = vector3(model.arms, 0, pivot)
    e = model.arms_err[pivot, 0] + model.arms_err[pivot, 1] + model.arms_err[pivot, 2]
    spread = inflate_lanes(largest(F, SCALE, S) * e, splat(0.0), 10.0)
    for k in range(3):
        combine3(F, ROOT_ARM + k, ROTATION + 3 * k, b0, b1, b2, spread, S)


@kernel(signatures(types.void, types.int64, types.int64))
def length_row(F: Forms, out: int, block: int, S: Symbols) -> None:
    """Write s (K_i - d_i . x) = s (|e_i|^2 - l_i^2) / 2 from a cable's block and x."""
    copy(F, out, block + OFFSET, S)
    for k in range(3):
        add_product(F, out, block + CENTRE + k, POSITION + k, -1.0, S)


@kernel(signatures(types.void, types.int64, types.int64, types.float64, types.float64))
def subtract_square(F: Forms, row: int, cable: int, square: float, square_err: float, S: Symbols) -> None:
    """Subtract l_i^2 from a row; its range rides on the cable's symbol of data; without such an error."""
    P = len(S.data)
    error = splat(0.0 if P > 0 else square_err)
    centre = load(F, row, 0) - square
    store(F, row, 0, centre)
    if P > 0:
        column = slope_column(len(S.noise) + cable, S)
        slope = load(F, row, column) - square_err
        store(F, row, column, slope)
        store(F, row, slope_column(len(S.noise) + P, S), data_sum(F, row, S))
        widen(F, row, inflate_lanes(error, abs(centre) + square + abs(slope) + square_err, 4.0), S)
    else:
        widen(F, row, inflate_lanes(error, abs(centre) + square, 4.0), S)


@kernel()
def load_rows(F: Forms, model: Any, S: Symbols) -> None:
    """Write s w_0 = s (f, -r_1 x f / size)."""
    root_arm_rows(F, model, S)
    size = 1.0 / model.size
    most = largest(F, SCALE, S)
    zero = splat(0.0)
    for k in range(3):
        scale(F, LOAD + k, SCALE, splat(model.load[k]), S)
        a, b = (k + 1) % 3, (k + 2) % 3
        # -(r_a f_b - r_b f_a)
        first, second = splat(-size * model.load[b]), splat(size * model.load[a])
        combine2(F, LOAD + 3 + k, ROOT_ARM + a, first, ROOT_ARM + b, second, S)
        if len(S.data) <= MOST_TAUT:
            widen(F, LOAD + k, inflate_lanes(model.load_err[k] * most, zero, 4.0), S)
            error = largest(F, ROOT_ARM + a, S) * model.load_err[b]
            error += largest(F, ROOT_ARM + b, S) * model.load_err[a]
            widen(F, LOAD + 3 + k, inflate_lanes(size * error, zero, 10.0), S)


@kernel()
def wrench_rows(F: Forms, model: Any, S: Symbols) -> None:
    """Write s w_i of the taut cables and s w_0. Needs the blocks and x."""
    pivot = model.orders[0, 0]
    size = 1.0 / model.size  # a power of two
    zero, one = splat(0.0), splat(1.0)
    for k in range(3):
        multiply(F, WRENCH + k, SCALE, POSITION + k, -1.0, S)
        constant(F, WRENCH + 3 + k, zero, zero, S)
    for j in range(1, model.n_taut):
        block = CABLE + BLOCK * j
        w = WRENCH + DIMENSIONS * j
        i = model.orders[0, j]
        for k in range(3):
            combine2(F, w + k, block + CENTRE + k, one, WRENCH + k, one, S)
            # (a - x) / size
            scale(F, SCRATCH + k, POSITION + k, splat(-size), S)
            store(F, SCRATCH + k, 0, load(F, SCRATCH + k, 0) + size * model.exit_steps[i, pivot, k])
            error = splat(size * model.exit_steps_err[i, pivot, k])
            widen(F, SCRATCH + k, inflate_lanes(error, magnitude(F, SCRATCH + k, S), 10.0), S)
        cross3(F, w + 3, block + ARM, SCRATCH, S)
    load_rows(F, model, S)
    if len(S.data) > MOST_TAUT:
        vary_wrenches(F, model, S)
        vary_load(F, model, S)
    elif model.vague:
        spread_wrenches(F, model, S)


@kernel()
def spread_wrenches(F: Forms, model: Any, S: Symbols) -> None:
    """Let exit points and arms be off by the model's spreads in the rows of wrenches and load.

    |R b| = |b|, so that a change of arms enters by its length. Moments are about the pivot's own platform
    point: q_i changes by the arms of both cables.
    """
    pivot = model.orders[0, 0]
    size = 1.0 / model.size
    zero = splat(0.0)
    most = largest(F, SCALE, S)
    own = model.arm_spread[pivot]
    for j in range(model.n_taut):
        i, w = model.orders[0, j], WRENCH + DIMENSIONS * j
        arm = model.arm_spread[i]
        gap, lever = arm, 0.0
        for k in range(3):
            gap += model.exit_spread[i, k]
            lever += abs(model.arm_steps[0, i, pivot, k])
        spoke = model.lengths[i, 1] + gap
        moment = size * ((arm + own) * (spoke + gap) + lever * gap) if j > 0 else 0.0
        for k in range(3):
            force = model.exit_spread[i, k] + arm
            widen(F, w + k, inflate_lanes(most * force, zero, 10.0), S)
            widen(F, w + 3 + k, inflate_lanes(most * moment, zero, 40.0), S)
    load = 0.0
    for k in range(3):
        load += abs(model.load[k]) + model.load_err[k]
    for k in range(3):
        widen(F, LOAD + 3 + k, inflate_lanes(most * (size * own * load), zero, 20.0), S)


@kernel()
def vary_wrenches(F: Forms, model: Any, S: Symbols) -> None:
    """Let exit points and arms vary with their symbols in the rows of wrenches.

    e_i changes by dA_i - R db_i and q_i by R (own_i - own_1), db_i = own_i + the centre's part, so that the
    moment q_i x e_i changes by q_i x (dA_i - R db_i) + R (own_i - own_1) x e_i and a product of two changes.
    """
    pivot = model.orders[0, 0]
    size = 1.0 / model.size
    most = largest(F, SCALE, S)
    for j in range(model.n_taut):
        i, w = model.orders[0, j], WRENCH + DIMENSIONS * j
        if j > 0:
            vary_moment(F, model, j, size, S)
            product = (model.arm_spread[i] + model.arm_spread[pivot]) * model.gaps[i]
            for k in range(3):
                widen(F, w + 3 + k, inflate_lanes(most * (size * product), splat(0.0), 10.0), S)
        for m in range(3):
            own, shared = model.anchor_sides[i, m], model.centre_sides[m]
            put_datum(F, w + m, SCALE, POINTS + EXIT_SYMBOLS + 3 * i + m, model.exit_spread[i, m], S)
            for k in range(3):
                put_datum(F, w + k, ROTATION + 3 * k + m, POINTS + ARM_SYMBOLS + 3 * i + m, -own, S)
                put_datum(F, w + k, ROTATION + 3 * k + m, POINTS + CENTRE_SYMBOLS + m, -shared, S)
        for k in range(DIMENSIONS):
            close_data(F, w + k, S)


@kernel()
def vary_moment(F: Forms, model: Any, j: int, size: float, S: Symbols) -> None:
    """Let the moment of the cable at place j > 0 vary with all symbols of points, to first order; not closed.

    The rows of its force are still s e.
    """
    pivot, i = model.orders[0, 0], model.orders[0, j]
    w, q = WRENCH + DIMENSIONS * j, CABLE + BLOCK * j + ARM
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        out = w + 3 + k
        put_datum(F, out, q + a, POINTS + EXIT_SYMBOLS + 3 * i + b, size * model.exit_spread[i, b], S)
        put_datum(F, out, q + b, POINTS + EXIT_SYMBOLS + 3 * i + a, -size * model.exit_spread[i, a], S)
        for m in range(3):
            own, shared = size * model.anchor_sides[i, m], size * model.centre_sides[m]
            root = size * model.anchor_sides[pivot, m]
            # s (R e_m x e)_k and s (q x R e_m)_k
            turned, error = crossed(F, ROTATION + 3 * a + m, w + b, ROTATION + 3 * b + m, w + a, S)
            levered, other = crossed(F, q + a, ROTATION + 3 * b + m, q + b, ROTATION + 3 * a + m, S)
            both = inflate_lanes(own * (error + other), own * (abs(turned) + abs(levered)), 4.0)
            put_slope(F, out, POINTS + ARM_SYMBOLS + 3 * i + m, own * (turned - levered), both, S)
            error = inflate_lanes(root * error, splat(0.0), 4.0)
            put_slope(F, out, POINTS + ARM_SYMBOLS + 3 * pivot + m, -root * turned, error, S)
            other = inflate_lanes(shared * other, splat(0.0), 4.0)
            put_slope(F, out, POINTS + CENTRE_SYMBOLS + m, -shared * levered, other, S)


@kernel(signatures(types.UniTuple(lanes, 2), *(types.int64,) * 4))
def crossed(F: Forms, a: int, b: int, c: int, d: int, S: Symbols) -> tuple[Lanes, Lanes]:
    """Return (F[a] F[b] - F[c] F[d]) / s at the cells' centres, and a bound of its change over the cells."""
    a0, b0, c0, d0 = load(F, a, 0), load(F, b, 0), load(F, c, 0), load(F, d, 0)
    ra, rb, rc, rd = rest(F, a, S), rest(F, b, S), rest(F, c, S), rest(F, d, S)
    s0, rs = load(F, SCALE, 0), rest(F, SCALE, S)
    value = (a0 * b0 - c0 * d0) / s0
    change = abs(a0) * rb + ra * (abs(b0) + rb) + abs(c0) * rd + rc * (abs(d0) + rd)
    sizes = abs(a0 * b0) + abs(c0 * d0)
    # s >= 1 throughout, so that |1 / s - 1 / s_0| <= |s - s_0| / s_0.
    error = (change + (sizes + change) * rs) / s0
    return value, inflate_lanes(error, sizes, 20.0)


@kernel()
def vary_load(F: Forms, model: Any, S: Symbols) -> None:
    """Let the load and the pivot's arm vary with their symbols in the rows of the load."""
    pivot = model.orders[0, 0]
    size = 1.0 / model.size
    off = model.load_err[0] + model.load_err[1] + model.load_err[2]
    product = largest(F, SCALE, S) * (size * model.arm_spread[pivot] * off)
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        out, load = LOAD + 3 + k, POINTS + LOAD_SYMBOLS
        put_datum(F, LOAD + k, SCALE, load + k, model.load_err[k], S)
        put_datum(F, out, ROOT_ARM + a, load + b, -size * model.load_err[b], S)
        put_datum(F, out, ROOT_ARM + b, load + a, size * model.load_err[a], S)
        first, second = -size * model.load[b], size * model.load[a]
        for m in range(3):
            own, shared = model.anchor_sides[pivot, m], model.centre_sides[m]
            arm, centre = POINTS + ARM_SYMBOLS + 3 * pivot + m, POINTS + CENTRE_SYMBOLS + m
            put_datum(F, out, ROTATION + 3 * a + m, arm, first * own, S)
            put_datum(F, out, ROTATION + 3 * b + m, arm, second * own, S)
            put_datum(F, out, ROTATION + 3 * a + m, centre, first * shared, S)
            put_datum(F, out, ROTATION + 3 * b + m, centre, second * shared, S)
        widen(F, out, inflate_lanes(product, splat(0.0), 10.0), S)
        close_data(F, LOAD + k, S)
        close_data(F, out, S)
