"""The square system of a taut subset along a polynomial of its data, in second-order forms.

The unknowns z = (u, p, t) of ``system`` are forms in the symbols of the data: symbol i is cable i's square
of length, lambda_i = l_i^2 + r_i delta_i. Times s = 1 + |u|^2 everything is polynomial (``geometry``), and
with q_i = A_i - p, b_i the arm

    s (|q_i|^2 + |b_i|^2 - lambda_i) - 2 q_i . s R b_i = 0             (lengths)
    sum t_i (s q_i - s R b_i) + s f = 0,  sum t_i s R b_i x q_i = 0    (statics)

Exit points and arms may be off by the model's spreads besides. Then lambda_i stands for the squared distance
of the middle points that belong to cable i (``arrays.Model``): the equations of lengths are those of the
middle points, those of statics and all derivatives are for every choice of the points (see ``tube``).

Arrays: ``F`` (rows, columns of a form, LANES) forms with the rows below and ``ALONG_DATA`` as symbols, of
which only the first lane is looked at; ``model`` is an ``arrays.Model``.
"""

from __future__ import annotations

from typing import Any

from numba import types

from cdpr_interval.engine.rows import Table
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import Lanes, lanes, load, splat, store
from cdpr_interval.kernels.rounding import inflate_lanes
from cdpr_interval.kernels.second_order import (
    Forms,
    Symbols,
    add_datum,
    add_product,
    add_scaled,
    bounds,
    close_data,
    combine2,
    combine3,
    constant,
    copy,
    cross3,
    dot3,
    largest,
    magnitude,
    multiply,
    put_datum,
    put_slope,
    scale,
    signatures,
    widen,
)
from cdpr_interval.mechanics.six_dof.rows import (
    ARM_SYMBOLS,
    CENTRE_SYMBOLS,
    DIMENSIONS,
    EXIT_SYMBOLS,
    LOAD_SYMBOLS,
    MOST_TAUT,
    POINT_SYMBOLS,
)

MOST_UNKNOWNS = 6 + MOST_TAUT
EXIT_DATA = MOST_UNKNOWNS + EXIT_SYMBOLS
"""The first of the symbols of exit points among all of data; before them are the unknowns' offsets."""
ARM_DATA = MOST_UNKNOWNS + ARM_SYMBOLS
CENTRE_DATA = MOST_UNKNOWNS + CENTRE_SYMBOLS
LOAD_DATA = MOST_UNKNOWNS + LOAD_SYMBOLS
ALL_DATA = MOST_UNKNOWNS + POINT_SYMBOLS

TABLE = Table()
Z = TABLE.take("Z", MOST_UNKNOWNS)
"""The unknowns u, p, t."""
SQUARES = TABLE.take("SQUARES", 3)
"""u_k^2."""
MIXED = TABLE.take("MIXED", 3)
"""u_i u_j, at the place of the third."""
SCALE = TABLE.take("SCALE")
"""s."""
ROTATION = TABLE.take("ROTATION", 9)
"""s R."""
STEP = TABLE.take("STEP", 3)
"""q of a cable."""
ARM = TABLE.take("ARM", 3)
"""s R b of a cable."""
TURNING = TABLE.take("TURNING", 9)
"""Its derivatives by u, one vector behind the other."""
SPOKE = TABLE.take("SPOKE", 3)
"""s q - s R b of a cable."""
MOMENT = TABLE.take("MOMENT", 3)
"""s R b x q of a cable."""
TERM = TABLE.take("TERM", 3)
SUM = TABLE.take("SUM")
"""|q|^2 + |b|^2 - lambda of a cable."""
EQUATIONS = TABLE.take("EQUATIONS", MOST_UNKNOWNS)
"""Lengths, forces, moments."""
JACOBIAN = TABLE.take("JACOBIAN", MOST_UNKNOWNS * MOST_UNKNOWNS)
"""Their derivatives, an equation's behind each other."""


@kernel(signatures(types.void, types.int64, types.float64, types.float64))
def shift(F: Forms, row: int, value: float, error: float, S: Symbols) -> None:
    """Add a number known up to ``error`` to a row."""
    new = load(F, row, 0) + value
    store(F, row, 0, new)
    widen(F, row, inflate_lanes(splat(error), abs(new), 4.0), S)


@kernel()
def derivative(i: int, k: int) -> int:
    """Return the row of equation i's derivative by unknown k."""
    return JACOBIAN + MOST_UNKNOWNS * i + k


@kernel(signatures(types.void))
def rotation_forms(F: Forms, S: Symbols) -> None:
    """Write s and s R from u."""
    one, two = splat(1.0), splat(2.0)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        multiply(F, SQUARES + k, Z + k, Z + k, 1.0, S)
        multiply(F, MIXED + k, Z + i, Z + j, 1.0, S)
    combine3(F, SCALE, SQUARES, one, one, one, splat(0.0), S)
    shift(F, SCALE, 1.0, 0.0, S)
    for i in range(3):
        for j in range(3):
            row = ROTATION + 3 * i + j
            if i == j:
                a, b = -1.0 if i != 0 else 1.0, -1.0 if i != 1 else 1.0
                c = -1.0 if i != 2 else 1.0
                combine3(F, row, SQUARES, splat(a), splat(b), splat(c), splat(0.0), S)
                shift(F, row, 1.0, 0.0, S)
            else:
                k = 3 - i - j
                sign = -2.0 if (j - i) % 3 == 1 else 2.0
                combine2(F, row, MIXED + k, two, Z + k, splat(sign), S)


@kernel()
def turning_forms(F: Forms, model: Any, chart: int, i: int, S: Symbols) -> None:
    """Write the derivatives of s R b by u: by u_m they are -2 u_m b + 2 e_m x b + 2 e_m (u . b) + 2 u b_m."""
    u = splat(1.0)
    for k in range(3):
        u += largest(F, Z + k, S)
    off = model.arms_err[i, 0] + model.arms_err[i, 1] + model.arms_err[i, 2]
    error = inflate_lanes(6.0 * u * off, splat(0.0), 20.0)
    for m in range(3):
        for k in range(3):
            row = TURNING + 3 * m + k
            c0, c1, c2 = 0.0, 0.0, 0.0
            for q in range(3):
                c = 0.0
                if q == m:
                    c -= 2.0 * model.arms[chart, i, k]
                if q == k:
                    c += 2.0 * model.arms[chart, i, m]
                if k == m:
                    c += 2.0 * model.arms[chart, i, q]
                c0, c1, c2 = (c if q == 0 else c0), (c if q == 1 else c1), (c if q == 2 else c2)
            # 0 where k = m, else the sum of three terms of which two cancel exactly.
            combine3(F, row, Z, splat(c0), splat(c1), splat(c2), error, S)
            if k != m:
                other = 3 - k - m
                sign = -2.0 if (k - m) % 3 == 1 else 2.0
                # (e_m x b)_k
                shift(F, row, sign * model.arms[chart, i, other], 0.0, S)


@kernel()
def cable_parts(F: Forms, model: Any, chart: int, i: int, S: Symbols) -> None:
    """Write q, s R b and |q|^2 + |b|^2 - lambda of a cable, lambda the middle of its square of length."""
    one = splat(1.0)
    off = model.arms_err[i, 0] + model.arms_err[i, 1] + model.arms_err[i, 2]
    most = largest(F, SCALE, S)
    error = inflate_lanes(most * off, splat(0.0), 20.0)
    square, square_err = 0.0, 0.0
    for k in range(3):
        b, e = model.arms[chart, i, k], model.arms_err[i, k]
        square += b * b
        square_err += 2.0 * abs(b) * e + e * e + 1e-15 * b * b
        scale(F, STEP + k, Z + 3 + k, -one, S)
        shift(F, STEP + k, model.exits[i, k], model.exits_err[i, k], S)
    b0, b1 = splat(model.arms[chart, i, 0]), splat(model.arms[chart, i, 1])
    b2 = splat(model.arms[chart, i, 2])
    for k in range(3):
        combine3(F, ARM + k, ROTATION + 3 * k, b0, b1, b2, error, S)
    dot3(F, SUM, STEP, STEP, S)
    # The difference of the two numbers is rounded besides.
    off = 2.0 * square_err + 1e-15 * (square + model.lengths_sq[i])
    shift(F, SUM, square - model.lengths_sq[i], off, S)


@kernel()
def sum_along(F: Forms, model: Any, chart: int, i: int, S: Symbols) -> None:
    """Write |q|^2 + |b|^2 - lambda of a cable once more where its points vary with symbols of their own."""
    square, error = 0.0, 0.0
    dot3(F, SUM, STEP, STEP, S)
    for k in range(3):
        b, e = model.arms[chart, i, k], model.arms_err[i, k]
        own, shared = model.anchor_sides[i, k], model.centre_sides[k]
        side = own + shared
        square += b * b
        error += 2.0 * (abs(b) + side) * e + e * e + 1e-15 * b * b + side * side
        put_slope(F, SUM, ARM_DATA + 3 * i + k, splat(2.0 * b * own), splat(0.0), S)
        put_slope(F, SUM, CENTRE_DATA + k, splat(2.0 * b * shared), splat(0.0), S)
    close_data(F, SUM, S)
    off = 2.0 * error + 1e-15 * (square + model.lengths_sq[i])
    shift(F, SUM, square - model.lengths_sq[i], off, S)


@kernel()
def length_equation(F: Forms, out: int, S: Symbols) -> None:
    """Write s (|q|^2 + |b|^2 - lambda) - 2 q . s R b of a cable: s times what its distance exceeds."""
    multiply(F, out, SCALE, SUM, 1.0, S)
    dot3(F, TERM, STEP, ARM, S)
    add_scaled(F, out, TERM, splat(-2.0), S)


@kernel()
def vary_length(F: Forms, model: Any, i: int, S: Symbols) -> None:
    """Let lambda of a taut cable vary with its symbol, and write its length's equation."""
    slope = load(F, SUM, 1 + i) - model.lengths_sq_err[i]
    store(F, SUM, 1 + i, slope)
    add_to_sum(F, SUM, abs(slope) + model.lengths_sq_err[i], S)
    length_equation(F, EQUATIONS + i, S)


@kernel()
def excess(F: Forms, model: Any, chart: int, i: int, S: Symbols) -> Lanes:
    """Bound s (distance^2 - length^2) of a slack cable's middle points from above, for all its lengths.

    Where lengths are those between each choice's points, negative says that these are nearer than the length.
    Needs ``rotation_forms``; overwrites ``EQUATIONS``.
    """
    cable_parts(F, model, chart, i, S)
    # d < l - gap where d^2 < l^2 - 2 l gap.
    gap = 2.0 * model.lengths[i, 1] * model.gaps[i] if model.own_points else 0.0
    widen(F, SUM, inflate_lanes(splat(model.lengths_sq_err[i] + gap), splat(0.0), 4.0), S)
    length_equation(F, EQUATIONS, S)
    _, hi = bounds(F, EQUATIONS, S)
    return hi


@kernel(signatures(types.void, types.int64, lanes))
def add_to_sum(F: Forms, row: int, size: Lanes, S: Symbols) -> None:
    """Account for a slope that was changed by hand: ``size`` bounds the old and the new one."""
    K = len(S.noise)
    Q = 1 + K + K * (K + 1) // 2
    total = splat(0.0)
    for k in range(1, 1 + K):
        total += abs(load(F, row, k))
    store(F, row, Q + 1, total)
    widen(F, row, inflate_lanes(splat(0.0), size, 4.0), S)


@kernel()
def spread_forms(F: Forms, model: Any, i: int, S: Symbols) -> None:
    """Let a cable's exit point and arm be off by the model's spreads, in all that derivatives are made of."""
    arm = model.arm_spread[i]
    step, u = splat(0.0), splat(1.0)
    for k in range(3):
        step += largest(F, STEP + k, S)
        u += largest(F, Z + k, S)
    shifted = model.exit_spread[i, 0] + model.exit_spread[i, 1] + model.exit_spread[i, 2]
    length = 0.0
    for k in range(3):
        length += abs(model.arms[0, i, k])
    # 2 q . R b, which |q|^2 + |b|^2 is more than |e|^2.
    twice = 2.0 * (step * arm + shifted * (length + arm))
    widen(F, SUM, inflate_lanes(twice, splat(0.0), 20.0), S)
    most = largest(F, SCALE, S)
    for k in range(3):
        widen(F, STEP + k, splat(model.exit_spread[i, k]), S)
        widen(F, ARM + k, inflate_lanes(most * arm, splat(0.0), 4.0), S)
    for k in range(9):
        widen(F, TURNING + k, inflate_lanes(6.0 * u * arm, splat(0.0), 4.0), S)


@kernel()
def spread_along(F: Forms, model: Any, i: int, S: Symbols) -> None:
    """Let a taut cable's exit point and arm vary with their own symbols, in what statics is made of."""
    for k in range(3):
        put_slope(F, STEP + k, EXIT_DATA + 3 * i + k, splat(model.exit_spread[i, k]), splat(0.0), S)
        close_data(F, STEP + k, S)
        own, shared = model.anchor_sides[i, k], model.centre_sides[k]
        for j in range(3):
            put_datum(F, ARM + j, ROTATION + 3 * j + k, ARM_DATA + 3 * i + k, own, S)
            put_datum(F, ARM + j, ROTATION + 3 * j + k, CENTRE_DATA + k, shared, S)
        turn_along(F, k, ARM_DATA + 3 * i + k, own, S)
        turn_along(F, k, CENTRE_DATA + k, shared, S)
    for k in range(3):
        close_data(F, ARM + k, S)
    for k in range(9):
        close_data(F, TURNING + k, S)


@kernel()
def turn_along(F: Forms, q: int, datum: int, side: float, S: Symbols) -> None:
    """Let entry q of an arm vary by ``side`` with a symbol, in the derivatives of s R b by u; not closed."""
    for m in range(3):
        for k in range(3):
            row = TURNING + 3 * m + k
            if k == q:
                put_datum(F, row, Z + m, datum, -2.0 * side, S)
            if k == m:
                put_datum(F, row, Z + q, datum, 2.0 * side, S)
            if m == q:
                put_datum(F, row, Z + k, datum, 2.0 * side, S)
            if k != m and q == 3 - k - m:
                # (e_m x e_q)_k
                twice = -2.0 * side if (k - m) % 3 == 1 else 2.0 * side
                put_slope(F, row, datum, splat(twice), splat(0.0), S)


@kernel()
def spoke_forms(F: Forms, S: Symbols) -> None:
    """Write s q - s R b of a cable."""
    for k in range(3):
        multiply(F, SPOKE + k, SCALE, STEP + k, 1.0, S)
        combine2(F, SPOKE + k, SPOKE + k, splat(1.0), ARM + k, splat(-1.0), S)


@kernel()
def statics_forms(F: Forms, model: Any, i: int, S: Symbols) -> None:
    """Add a cable's force and moment to the equations; needs ``spoke_forms``."""
    n = model.n_taut
    cross3(F, MOMENT, ARM, STEP, S)
    for k in range(3):
        add_product(F, EQUATIONS + n + k, Z + 6 + i, SPOKE + k, 1.0, S)
        add_product(F, EQUATIONS + n + 3 + k, Z + 6 + i, MOMENT + k, 1.0, S)


@kernel()
def length_slopes(F: Forms, i: int, S: Symbols) -> None:
    """Write the derivatives of a cable's length; needs ``spoke_forms``."""
    for m in range(3):
        own = derivative(i, m)
        multiply(F, own, Z + m, SUM, 1.0, S)
        dot3(F, TERM, STEP, TURNING + 3 * m, S)
        combine2(F, own, own, splat(2.0), TERM, splat(-2.0), S)
        scale(F, derivative(i, 3 + m), SPOKE + m, splat(-2.0), S)


@kernel()
def statics_slopes(F: Forms, model: Any, i: int, S: Symbols) -> None:
    """Add a cable's part of the derivatives of statics."""
    n = model.n_taut
    t = Z + 6 + i
    two, minus = splat(2.0), splat(-1.0)
    for m in range(3):
        for k in range(3):
            multiply(F, TERM, Z + m, STEP + k, 1.0, S)
            combine2(F, TERM, TERM, two, TURNING + 3 * m + k, minus, S)
            add_product(F, derivative(n + k, m), t, TERM, 1.0, S)
        cross3(F, TERM, TURNING + 3 * m, STEP, S)
        for k in range(3):
            add_product(F, derivative(n + 3 + k, m), t, TERM + k, 1.0, S)
        a, b = (m + 1) % 3, (m + 2) % 3
        # Moment t r x (A - p) by p_m: t e_m x r.
        add_product(F, derivative(n + 3 + a, 3 + m), t, ARM + b, -1.0, S)
        add_product(F, derivative(n + 3 + b, 3 + m), t, ARM + a, 1.0, S)
        add_product(F, derivative(n + m, 3 + m), t, SCALE, -1.0, S)
        copy(F, derivative(n + m, 6 + i), SPOKE + m, S)
        copy(F, derivative(n + 3 + m, 6 + i), MOMENT + m, S)


@kernel()
def cable_forms(F: Forms, model: Any, chart: int, i: int, slopes: bool, S: Symbols) -> None:
    """Write a taut cable's length and derivatives, and what statics needs; points are off by the spreads."""
    cable_parts(F, model, chart, i, S)
    vary_length(F, model, i, S)
    if model.own_points:
        own_length(F, model, i, S)
    turning_forms(F, model, chart, i, S)
    spread_forms(F, model, i, S)
    spoke_forms(F, S)
    if slopes:
        length_slopes(F, i, S)


@kernel()
def own_length(F: Forms, model: Any, i: int, S: Symbols) -> None:
    """Let a taut cable's length be that between each choice's points, off by the model's gap.

    s |e|^2 is s lambda and the equation that is written, so that e of the middle points is at most r long,
    r^2 being l^2 and that equation's largest value; |e|^2 changes by at most 2 r gap + gap^2. That is off in
    the equation and in its derivatives, which have |q|^2 + |b|^2 - lambda = |e|^2 - lambda + 2 q . R b as a
    factor of those of s; ``spread_forms`` adds what the last term changes by.
    """
    gap, longest = model.gaps[i], model.lengths[i, 1]
    off = largest(F, EQUATIONS + i, S)
    reach = longest + off * (0.5 / longest)
    change = gap * (2.0 * reach + gap)
    widen(F, EQUATIONS + i, inflate_lanes(largest(F, SCALE, S) * change, splat(0.0), 20.0), S)
    widen(F, SUM, inflate_lanes(change, splat(0.0), 20.0), S)


@kernel()
def cable_along(F: Forms, model: Any, chart: int, i: int, slopes: bool, S: Symbols) -> None:
    """Write the same where points vary with symbols, lengths being those between each choice's points."""
    cable_parts(F, model, chart, i, S)
    turning_forms(F, model, chart, i, S)
    spread_along(F, model, i, S)
    sum_along(F, model, chart, i, S)
    vary_length(F, model, i, S)
    spoke_forms(F, S)
    if slopes:
        length_slopes(F, i, S)


@kernel()
def cable_with_middles(F: Forms, model: Any, chart: int, i: int, slopes: bool, S: Symbols) -> None:
    """Write the same where points vary with symbols, lengths being those between the middle points.

    Derivatives of lengths are off by the spreads: those between the middle points and those of every choice.
    """
    cable_parts(F, model, chart, i, S)
    vary_length(F, model, i, S)
    if slopes:
        turning_forms(F, model, chart, i, S)
        spread_forms(F, model, i, S)
        spoke_forms(F, S)
        length_slopes(F, i, S)
        cable_parts(F, model, chart, i, S)
    turning_forms(F, model, chart, i, S)
    spread_along(F, model, i, S)
    spoke_forms(F, S)


@kernel()
def form_system(F: Forms, model: Any, chart: int, slopes: bool, S: Symbols) -> None:
    """Write the n + 6 equations at the unknowns Z, and with ``slopes`` their derivatives.

    Guarantee: for every choice of the data and every z in the forms Z (their errors included) the
    equations of that choice, and the derivatives by z there, are enclosed.
    """
    n = model.n_taut
    zero = splat(0.0)
    for e in range(n + DIMENSIONS):
        constant(F, EQUATIONS + e, zero, zero, S)
        if slopes:
            for k in range(6 + n):
                constant(F, derivative(e, k), zero, zero, S)
    rotation_forms(F, S)
    most = largest(F, SCALE, S)
    for k in range(3):
        scale(F, EQUATIONS + n + k, SCALE, splat(model.load[k]), S)
        if len(S.data) == ALL_DATA:
            add_datum(F, EQUATIONS + n + k, SCALE, LOAD_DATA + k, model.load_err[k], S)
        else:
            widen(F, EQUATIONS + n + k, inflate_lanes(most * model.load_err[k], zero, 4.0), S)
        if slopes:
            for m in range(3):
                row = derivative(n + k, m)
                scale(F, row, Z + m, splat(2.0 * model.load[k]), S)
                if len(S.data) == ALL_DATA:
                    add_datum(F, row, Z + m, LOAD_DATA + k, 2.0 * model.load_err[k], S)
                else:
                    error = 2.0 * model.load_err[k] * largest(F, Z + m, S)
                    widen(F, row, inflate_lanes(error, magnitude(F, row, S), 4.0), S)
    for i in range(n):
        if len(S.data) < ALL_DATA:
            cable_forms(F, model, chart, i, slopes, S)
        elif model.own_points:
            cable_along(F, model, chart, i, slopes, S)
        else:
            cable_with_middles(F, model, chart, i, slopes, S)
        statics_forms(F, model, i, S)
        if slopes:
            statics_slopes(F, model, i, S)
