"""Positions and cables as forms over cells: lengths, wrenches.

The position v = p - p_c has three symbols of its own, bounded by the cell's box of positions and by what the
lengths leave of it. How it goes with u is left to the equations of the lengths, which are solved for symbols
and added to other forms. With y_i = T0_i - p_c,

    2 s G_i = s |v|^2 - 2 y_i . s v + s (|y_i|^2 + |b_i|^2 - s_i^2) + 2 v . s R b_i - 2 y_i . s R b_i

vanishes where |X_i - T0_i| = s_i, s_i = l_i - (L0 - sigma0). The path length is that of this sphere but for
the error LOOSE of ``path.around``, which widens s_i. The wrench about the centre of mass is (e_i, R b_i x
e_i), e_i = y_i - v - R b_i but for the error DRIFT.

Arrays: ``F``, ``W``, ``C`` as in ``cells.tests``, ``F`` with the rows of ``rows``; ``desk`` is a
``survey.Desk``, ``real`` is a ``RealModel``; ``held`` (LANES, HELD) and ``spots`` (n, SPOT, LANES) are the
desk's.
"""

from __future__ import annotations

import math
from typing import Any

from cdpr_interval.engine.rows import SCRATCH
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray, load, splat, store
from cdpr_interval.kernels.rounding import inflate_lanes, up
from cdpr_interval.kernels.second_order import (
    Forms,
    Symbols,
    add_product,
    add_scaled,
    close,
    combine2,
    combine3,
    constant,
    dot3,
    largest,
    multiply,
    scale,
    widen,
)
from cdpr_interval.mechanics.six_dof.geometry import middle_and_radius
from cdpr_interval.mechanics.six_dof.rows import (
    DIMENSIONS,
    LOAD,
    MOST_TAUT,
    POSITION,
    ROTATION,
    SCALE,
    U_SYMBOLS,
    WRENCH,
)
from solvers.six_dof.real.columns import (
    BOX,
    CENTRE,
    DRIFT,
    FOOT,
    FORMED,
    FREE,
    HIGHEST,
    LEAST_FREE,
    LENGTH_ERROR,
    LEVEL,
    LEVEL_ERROR,
    LOOSE,
    LOWEST,
    PATH,
    POINT_ERROR,
    REST,
    SIZE,
    SQUARE,
    SQUARE_ERROR,
    TO_FOOT,
    TURNED_SHARE,
)
from solvers.six_dof.real.path import ROUNDING
from solvers.six_dof.real.rows import INNER, OUTER, SCALED, SQUARED, TURNED


@kernel()
def spot(real: Any, lane: int, desk: Any) -> None:
    """Write what the forms of a lane need of each cable; of cables that are not smooth bounds of nothing."""
    held, seen, spots = desk.held, desk.seen, desk.spots
    for i in range(real.exits.shape[0]):
        spots[i, POINT_ERROR, lane] = math.inf
        spots[i, LEVEL_ERROR, lane] = math.inf
        spots[i, LEVEL, lane] = 0.0
        spots[i, SQUARE_ERROR, lane] = math.inf
        spots[i, LENGTH_ERROR, lane] = math.inf
        total = 0.0
        for k in range(3):
            y = seen[i, FOOT + k] - held[lane, CENTRE + k]
            spots[i, TO_FOOT + k, lane] = y if desk.smooth[i] else 0.0
            total += y * y
        if not desk.smooth[i]:
            continue
        size = seen[i, SIZE]
        # T0 is now p_c + y.
        moved = ROUNDING * size
        start = seen[i, PATH] - seen[i, FREE]
        low, high = seen[i, LOWEST] - start, seen[i, HIGHEST] - start
        if i >= real.n_taut:
            low = high
        radius = 0.5 * (low + high)
        loose = (0.5 * (high - low) + seen[i, LOOSE] + moved) * (1.0 + 1e-12)
        b = real.arm_lengths[i]
        level = 0.5 * (total + b * b - radius * radius)
        error = loose * (abs(radius) + 0.5 * loose) + ROUNDING * (total + b * b + radius * radius)
        spots[i, LEVEL, lane] = level
        spots[i, LEVEL_ERROR, lane] = error * (1.0 + 1e-12)
        spots[i, POINT_ERROR, lane] = (seen[i, DRIFT] + moved + real.shift[i, 0]) * (1.0 + 1e-12)
        spots[i, SQUARE, lane] = 0.5 * (total + b * b)
        spots[i, SQUARE_ERROR, lane] = 4.0 * ROUNDING * (total + b * b)
        least, most = real.lengths[i, 0] - start, real.lengths[i, 1] - start
        spots[i, REST, lane] = 0.5 * (least + most)
        off = 0.5 * (most - least) + seen[i, LOOSE] + 2.0 * moved
        spots[i, LENGTH_ERROR, lane] = off / seen[i, LEAST_FREE] * (1.0 + 1e-12)
        spots[i, TURNED_SHARE, lane] = spots[i, POINT_ERROR, lane] / seen[i, LEAST_FREE] * (1.0 + 1e-12)


@kernel()
def from_middle(C: LaneArray, lane: int, desk: Any) -> None:
    """Turn the bounds of a lane's positions, which are kept in BOX, into bounds of v."""
    held = desk.held
    for k in range(3):
        low, high = C[0, 6 + 2 * k, lane], C[0, 7 + 2 * k, lane]
        held[lane, BOX + 2 * k], held[lane, BOX + 2 * k + 1] = low, high
        c = held[lane, CENTRE + k]
        C[0, 6 + 2 * k, lane] = -up(c - low)
        C[0, 7 + 2 * k, lane] = up(high - c)
    held[lane, FORMED] = 1.0


@kernel()
def back_to_box(C: LaneArray, lane: int, desk: Any) -> None:
    """Turn the bounds of v of a lane's cell into bounds of its positions."""
    held = desk.held
    if held[lane, FORMED] == 0.0:
        return
    held[lane, FORMED] = 0.0
    for k in range(3):
        c = held[lane, CENTRE + k]
        low, high = -up(-C[0, 6 + 2 * k, lane] - c), up(C[0, 7 + 2 * k, lane] + c)
        C[0, 6 + 2 * k, lane] = max(held[lane, BOX + 2 * k], low)
        C[0, 7 + 2 * k, lane] = min(held[lane, BOX + 2 * k + 1], high)
        if C[0, 6 + 2 * k, lane] > C[0, 7 + 2 * k, lane]:
            # Only by rounding where nothing is left: one point keeps the cell well formed.
            C[0, 7 + 2 * k, lane] = C[0, 6 + 2 * k, lane]


@kernel()
def position_rows(F: Forms, C: LaneArray, S: Symbols) -> None:
    """Write v = p - p_c, with the bounds in columns 6..11 of the cells, to POSITION."""
    for k in range(3):
        lo, hi = load(C, 0, 6 + 2 * k), load(C, 0, 7 + 2 * k)
        # The very radius that cuts are made by.
        middle, radius = middle_and_radius(lo, hi)
        constant(F, POSITION + k, middle, splat(0.0), S)
        store(F, POSITION + k, 1 + U_SYMBOLS + k, radius)
        close(F, POSITION + k, S)


@kernel()
def product_rows(F: Forms, S: Symbols) -> None:
    """Write the products of position and rotation that all cables share."""
    for k in range(3):
        multiply(F, SCALED + k, SCALE, POSITION + k, 1.0, S)
    dot3(F, SQUARED, POSITION, SCALED, S)
    for j in range(3):
        constant(F, INNER + j, splat(0.0), splat(0.0), S)
        for k in range(3):
            add_product(F, INNER + j, ROTATION + 3 * k + j, POSITION + k, 1.0, S)
    for j in range(3):
        for k in range(3):
            a, b = (k + 1) % 3, (k + 2) % 3
            multiply(F, OUTER + 3 * k + j, ROTATION + 3 * a + j, POSITION + b, 1.0, S)
            add_product(F, OUTER + 3 * k + j, ROTATION + 3 * b + j, POSITION + a, -1.0, S)


@kernel()
def turned_arm(F: Forms, real: Any, i: int, S: Symbols) -> None:
    """Write s R b_i to TURNED."""
    b0, b1, b2 = splat(real.arms[i, 0]), splat(real.arms[i, 1]), splat(real.arms[i, 2])
    for k in range(3):
        combine3(F, TURNED + k, ROTATION + 3 * k, b0, b1, b2, splat(0.0), S)


@kernel()
def length_row(F: Forms, out: int, real: Any, i: int, spots: LaneArray, S: Symbols) -> None:
    """Write s G_i to ``out``. Needs ``product_rows``; uses TURNED and SCRATCH + 1."""
    sphere_row(F, out, real, i, spots, LEVEL, S)


@kernel()
def square_row(F: Forms, out: int, real: Any, i: int, spots: LaneArray, S: Symbols) -> None:
    """Write s |X_i - T0_i|^2 / 2 to ``out``. Needs ``product_rows``; uses TURNED and SCRATCH + 1."""
    sphere_row(F, out, real, i, spots, SQUARE, S)


@kernel()
def sphere_row(F: Forms, out: int, real: Any, i: int, spots: LaneArray, level: int, S: Symbols) -> None:
    """Write s |X_i - T0_i|^2 / 2 with (|y_i|^2 + |b_i|^2) / 2 replaced by what stands in ``level``.

    Its error stands in the place after ``level``.
    """
    y0, y1, y2 = load(spots, i, TO_FOOT), load(spots, i, TO_FOOT + 1), load(spots, i, TO_FOOT + 2)
    b0, b1, b2 = splat(real.arms[i, 0]), splat(real.arms[i, 1]), splat(real.arms[i, 2])
    turned_arm(F, real, i, S)
    error = load(spots, i, level + 1) * largest(F, SCALE, S)
    combine3(F, out, TURNED, -y0, -y1, -y2, inflate_lanes(error, splat(0.0), 4.0), S)
    combine3(F, SCRATCH + 1, SCALED, -y0, -y1, -y2, splat(0.0), S)
    add_scaled(F, out, SCRATCH + 1, splat(1.0), S)
    combine3(F, SCRATCH + 1, INNER, b0, b1, b2, splat(0.0), S)
    add_scaled(F, out, SCRATCH + 1, splat(1.0), S)
    add_scaled(F, out, SQUARED, splat(0.5), S)
    add_scaled(F, out, SCALE, load(spots, i, level), S)


@kernel()
def wrench_rows(F: Forms, real: Any, spots: LaneArray, S: Symbols) -> None:
    """Write s w_i of the taut cables, the first six of more, and s w_0. Needs ``product_rows``."""
    for i in range(min(real.n_taut, MOST_TAUT)):
        wrench_row(F, WRENCH + DIMENSIONS * i, real, i, spots, S)
    load_rows(F, real, S)


@kernel()
def load_rows(F: Forms, real: Any, S: Symbols) -> None:
    """Write s w_0, the load's own wrench."""
    zero, most = splat(0.0), largest(F, SCALE, S)
    for k in range(3):
        scale(F, LOAD + k, SCALE, splat(real.load[k]), S)
        widen(F, LOAD + k, inflate_lanes(most * real.load_err[k], zero, 4.0), S)
        constant(F, LOAD + 3 + k, zero, zero, S)


@kernel()
def wrench_row(F: Forms, w: int, real: Any, i: int, spots: LaneArray, S: Symbols) -> None:
    """Write s w_i to six rows from ``w`` on. Needs ``product_rows``."""
    size = 1.0 / real.size
    zero, one = splat(0.0), splat(1.0)
    turned_arm(F, real, i, S)
    off = largest(F, SCALE, S) * load(spots, i, POINT_ERROR)
    b0, b1, b2 = splat(real.arms[i, 0]), splat(real.arms[i, 1]), splat(real.arms[i, 2])
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        y, y_a, y_b = (
            load(spots, i, TO_FOOT + k),
            load(spots, i, TO_FOOT + a),
            load(spots, i, TO_FOOT + b),
        )
        combine2(F, w + k, SCALE, y, SCALED + k, -one, S)
        add_scaled(F, w + k, TURNED + k, -one, S)
        widen(F, w + k, inflate_lanes(off, zero, 4.0), S)
        # R b x (y - v)
        combine3(F, w + 3 + k, OUTER + 3 * k, -b0, -b1, -b2, zero, S)
        add_scaled(F, w + 3 + k, TURNED + a, y_b, S)
        add_scaled(F, w + 3 + k, TURNED + b, -y_a, S)
        widen(F, w + 3 + k, inflate_lanes(off * real.arm_lengths[i], zero, 4.0), S)
        scale(F, w + 3 + k, w + 3 + k, splat(size), S)
