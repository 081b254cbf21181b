"""Statics of a cell: proofs that no non-negative tensions balance the load, equations, tension bounds.

All tests use the rows WRENCH.. and LOAD (scaled by s > 0, which cancels) and the rows PIVOT.., which
vanish at every solution and may be added to any form. Directions y in R^6 are found in floats at the cell's
centre; whatever they are, the forms y . w decide.

Arrays: ``F`` (rows, columns of a form, LANES) forms, ``W`` (rows, columns, LANES) scratch, both with the
rows of ``engine.rows`` and ``rows``; ``S`` the forms' symbols. Integers: ``n`` taut cables, ``rank`` the
most pivots of a lane, which ``solve_for_pivots`` returned.
"""

from __future__ import annotations

import math

from numba import types

from cdpr_interval.engine.batch_cells import covers, maximum
from cdpr_interval.engine.contraction import reduce_row
from cdpr_interval.engine.rows import EQUATION, SCRATCH
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, array3, lanes, load, splat, store, where_less
from cdpr_interval.kernels.rounding import down_lanes, inflate_lanes, up_lanes
from cdpr_interval.kernels.second_order import (
    Forms,
    Symbols,
    add_scaled,
    bounds,
    combine6,
    largest,
    moving6,
    signatures,
    widen,
)
from cdpr_interval.mechanics.six_dof.directions import (
    centre_columns,
    centre_tensions,
    choose_slopes,
    choose_y,
    complete_basis,
    dual_columns,
    tensions_of_load,
    wrench_of,
)
from cdpr_interval.mechanics.six_dof.nearest import nearest_point
from cdpr_interval.mechanics.six_dof.rows import (
    BASIS,
    COLUMNS,
    DIMENSIONS,
    DUAL,
    INVERSE,
    KEPT_Y,
    LEFT_INVERSE,
    LOAD,
    MOST_TAUT,
    MOST_TENSION,
    NORM,
    RESTS,
    RIGHT,
    SHARES,
    SOME_TENSION,
    TENSIONS,
    TRIED,
    WRENCH,
    Y,
)

INT = types.int64

LOOSE = 100.0
"""Inverse of what is left of a normalised column after those before it, from which on y is tried as the
nearest point: no y of moderate size has prescribed products with all columns."""
FLOOR = 1e-3
"""Least right side of a form relative to the largest: the load's form hardly varies, yet must be positive."""


@kernel(signatures(types.UniTuple(lanes, 2), array3, INT, types.boolean, INT))
def weigh(F: Forms, W: LaneArray, row: int, moving: bool, rank: int, S: Symbols) -> tuple[Lanes, Lanes]:
    """Bound y . w at all solutions in the cells; leaves the form in SCRATCH."""
    if moving:
        moving6(F, SCRATCH, row, W, Y, S)
    else:
        combine6(F, SCRATCH, row, W, Y, S)
    reduce_row(F, SCRATCH, W, rank, S)
    return bounds(F, SCRATCH, S)


@kernel(signatures(lanes, array3, INT, INT, types.boolean, INT))
def all_positive(F: Forms, W: LaneArray, n: int, m: int, moving: bool, rank: int, S: Symbols) -> Lanes:
    """Return 1 where y . w_i > 0 is proved for all i < m (i = n is the load), else 0.

    Leaves lower bounds in W[MOST_TENSION] and the forms' radii, normalised, as the next right sides.
    """
    positive = splat(1.0)
    most = splat(0.0)
    for i in range(m):
        lo, _ = weigh(F, W, wrench_of(i, n), moving, rank, S)
        positive = where_less(0.0, lo, positive, 0.0)
        store(W, MOST_TENSION, i, lo)
        radius = maximum(load(F, SCRATCH, 0) - lo, splat(0.0)) / load(W, COLUMNS + i, NORM)
        store(W, COLUMNS + i, RIGHT, radius)
        most = maximum(radius, most)
    for i in range(m):
        store(W, COLUMNS + i, RIGHT, load(W, COLUMNS + i, RIGHT) + (FLOOR * most + 1e-300))
    return positive


@kernel(types.void(array3, INT))
def balance_right_sides(W: LaneArray, n: int) -> None:
    """Change right sides r > 0 where the load nearly depends on the wrenches, so that a small y attains them.

    With lambda their dependency, that is where lambda . r = 0. The tensions t of the centre are
    lambda over its last entry. Where all entries have one sign (the centre nearly has an equilibrium with
    positive tensions), and where that would leave smaller forms than a large y does, r stays as it is.
    """
    positive = load(W, COLUMNS + n, RIGHT)
    negative = splat(0.0)
    for i in range(n):
        x = load(W, SOME_TENSION, i) * load(W, COLUMNS + i, RIGHT)
        positive += where_less(0.0, x, x, 0.0)
        negative -= where_less(x, 0.0, x, 0.0)
    share = negative / positive
    # A large y is as large as the inverse of the load's remainder, 0 where there is none.
    inverse = load(W, DUAL + n, INVERSE)
    better = where_less(0.0, inverse, share * inverse, 2.0)
    for i in range(n):
        right = load(W, COLUMNS + i, RIGHT)
        balanced = where_less(0.0, load(W, SOME_TENSION, i), right * share, right)
        store(W, COLUMNS + i, RIGHT, where_less(1.0, better, balanced, right))
    right = load(W, COLUMNS + n, RIGHT)
    store(W, COLUMNS + n, RIGHT, where_less(1.0, better, right * share, right))


@kernel(signatures(lanes, array3, INT, lanes))
def balance_free_of_six(F: Forms, W: LaneArray, rank: int, needed: Lanes, S: Symbols) -> Lanes:
    """Six cables: seven forms in six unknowns, so the load depends on the wrenches."""
    n = MOST_TAUT
    dual_columns(W, n)
    store(W, DUAL + n, INVERSE, 0.0)
    centre_tensions(W, n, False)
    free = splat(0.0)
    for _ in range(2):
        balance_right_sides(W, n)
        choose_y(W, n)
        free = maximum(all_positive(F, W, n, n + 1, False, rank, S), free)
        if covers(W, free, needed):
            break
    return free


@kernel(signatures(lanes, array3, INT, INT, lanes, lanes))
def balance_free_of_dependent(
    F: Forms, W: LaneArray, n: int, rank: int, needed: Lanes, free: Lanes, S: Symbols
) -> Lanes:
    """Test the lanes left once more, with the nearest point as y, where the columns are nearly dependent."""
    store(W, TRIED, 0, where_less(0.0, needed, where_less(0.0, free, splat(0.0), 1.0), 0.0))
    is_any_left = False
    for lane in range(LANES):
        is_loose = False
        for i in range(n + 1):
            inverse = W[DUAL + i, INVERSE, lane]
            is_loose = is_loose or not 0.0 < inverse < LOOSE
        if is_loose and W[TRIED, 0, lane] > 0.0:
            nearest_point(W, lane, n + 1)
            is_any_left = True
        else:
            # Another lane's need must not change what becomes of this one.
            W[TRIED, 0, lane] = 0.0
    if not is_any_left:
        return splat(0.0)
    tried = load(W, TRIED, 0)
    return where_less(0.0, tried, all_positive(F, W, n, n + 1, False, rank, S), 0.0)


@kernel(signatures(lanes, array3, INT, INT, lanes))
def balance_free(F: Forms, W: LaneArray, n: int, rank: int, needed: Lanes, S: Symbols) -> Lanes:
    """Return 1 where y proves that the cell holds no equilibrium, else 0. Needs ``centre_columns``.

    Guarantee (Gordan): y . w_i > 0 for every taut cable and y . w_0 > 0 at every point of the cell that
    satisfies the equations, so sum t_i w_i + w_0 = 0 has no solution with t >= 0 there. y may vary over the
    cell. It is tried constant first, then with slopes that make the forms' slopes vanish; right sides are
    proportional to the forms' radii of the try before. Only lanes with ``needed`` > 0 matter.
    """
    if n == MOST_TAUT:
        return balance_free_of_six(F, W, rank, needed, S)
    dual_columns(W, n + 1)
    tensions_of_load(W, n)
    balance_right_sides(W, n)
    choose_y(W, n + 1)
    free = all_positive(F, W, n, n + 1, False, rank, S)
    for _ in range(2):
        if covers(W, free, needed):
            break
        balance_right_sides(W, n)
        choose_y(W, n + 1)
        choose_slopes(F, W, n, n + 1, S)
        free = maximum(all_positive(F, W, n, n + 1, True, rank, S), free)
    if not covers(W, free, needed):
        free = maximum(balance_free_of_dependent(F, W, n, rank, needed, free, S), free)
    return free


@kernel(signatures(lanes, array3, INT, INT))
def limit_tensions(F: Forms, W: LaneArray, n: int, rank: int, S: Symbols) -> Lanes:
    """Bound the tensions of every equilibrium in the cells from above. Needs ``centre_columns``.

    Guarantee: where 1 is returned, every t >= 0 with sum t_i w_i + w_0 = 0 at a solution in the cell has
    t_i <= W[MOST_TENSION, i]: from y . w_i >= b_i > 0 and y . w_0 >= -c follows t_i b_i <= c.
    W[SOME_TENSION] gets approximate tensions at the centre.
    """
    for i in range(n):
        store(W, COLUMNS + i, RIGHT, 1.0)
    dual_columns(W, n)
    choose_y(W, n)
    limited = all_positive(F, W, n, n, False, rank, S)
    if not covers(W, limited, splat(1.0)):
        # Lanes that have their y keep it.
        for k in range(6):
            store(W, KEPT_Y, k, load(W, Y, k))
        choose_y(W, n)
        for k in range(6):
            store(W, Y, k, where_less(0.0, limited, load(W, KEPT_Y, k), load(W, Y, k)))
        limited = all_positive(F, W, n, n, False, rank, S)
    lo, _ = weigh(F, W, LOAD, False, rank, S)
    centre_tensions(W, n, True)
    for i in range(n):
        most = up_lanes(maximum(-lo, splat(0.0)) / load(W, MOST_TENSION, i))
        limited = where_less(most, math.inf, limited, 0.0)
        store(W, MOST_TENSION, i, most)
        some = maximum(load(W, SOME_TENSION, i), splat(0.0))
        store(W, SOME_TENSION, i, where_less(some, most, some, most))
    return limited


@kernel(signatures(types.void, array3, INT, INT, INT))
def statics_equations(F: Forms, W: LaneArray, n: int, first: int, rank: int, S: Symbols) -> None:
    """Write the 6 - n equations of statics that are free of tensions to first order.

    For y across the wrenches at the centre, with slopes that keep it so, y . w_0 + sum t_i y . w_i = 0
    at every equilibrium; y . w_i has no linear part, t_i lies in [0, MOST_TENSION]. Needs ``limit_tensions``.
    """
    complete_basis(W, n)
    for j in range(6 - n):
        out = EQUATION + first + j
        for k in range(6):
            store(W, Y, k, load(W, BASIS + n + j, k))
        choose_slopes(F, W, n, n, S)
        moving6(F, out, LOAD, W, Y, S)
        error = splat(0.0)
        for i in range(n):
            lo, hi = weigh(F, W, wrench_of(i, n), True, rank, S)
            t = load(W, SOME_TENSION, i)
            spread = up_lanes(maximum(t, load(W, MOST_TENSION, i) - t))
            add_scaled(F, out, SCRATCH, t, S)
            error += spread * maximum(-lo, hi)
        widen(F, out, inflate_lanes(error, splat(0.0), 20.0), S)
        reduce_row(F, out, W, rank, S)


@kernel(signatures(lanes, array3, INT))
def tension_bounds(F: Forms, W: LaneArray, n: int, S: Symbols) -> Lanes:
    """Enclose every t with sum t_i w_i + w_0 = 0 at some point of the cells (t_i = tension / l_i).

    Writes lower bounds to W[TENSIONS], upper bounds to W[TENSIONS + 1]; returns 1 where they hold.

    Verified least squares: with C an approximate left inverse of the wrench matrix at the centre and t~
    the approximate solution, any such t satisfies t - t~ = -C (w_0 + W t~) + (I - C W)(t - t~), so
    max|t - t~| <= max|C (w_0 + W t~)| / (1 - |I - C W|). 0 where |I - C W| < 1 cannot be proved: the
    tensions may then be unbounded or not unique.
    """
    centre_columns(F, W, n)
    dual_columns(W, n)
    centre_tensions(W, n, True)
    for i in range(n):
        for k in range(6):
            store(W, LEFT_INVERSE + i, k, load(W, DUAL + i, k) / load(W, COLUMNS + i, NORM))
    bounded = splat(1.0)
    worst = splat(0.0)
    most = splat(0.0)
    row = SCRATCH + 1
    for i in range(n):
        combine6(F, row, LOAD, W, LEFT_INVERSE + i, S)
        total = splat(0.0)
        for j in range(n):
            combine6(F, SCRATCH, WRENCH + DIMENSIONS * j, W, LEFT_INVERSE + i, S)
            add_scaled(F, row, SCRATCH, load(W, SOME_TENSION, j), S)
            if i == j:
                store(F, SCRATCH, 0, load(F, SCRATCH, 0) - 1.0)
                widen(F, SCRATCH, splat(1e-15), S)
            total += largest(F, SCRATCH, S)
        share = up_lanes(total * (1.0 + 1e-14))
        rest = largest(F, row, S)
        store(W, SHARES, i, share)
        store(W, RESTS, i, rest)
        # Row by row, so that NaN (an overflow) cannot hide behind a maximum.
        bounded = where_less(share, 0.95, bounded, 0.0)
        bounded = where_less(rest, math.inf, bounded, 0.0)
        worst = maximum(share, worst)
        most = maximum(rest, most)
    gain = up_lanes(most / down_lanes(1.0 - worst))
    for i in range(n):
        error = up_lanes(load(W, RESTS, i) + up_lanes(load(W, SHARES, i) * gain))
        t = load(W, SOME_TENSION, i)
        store(W, TENSIONS, i, down_lanes(t - error))
        store(W, TENSIONS + 1, i, up_lanes(t + error))
    return bounded
