"""What the poses of a tube report, as forms along the tube: bounds near the true reach of the data.

Arrays, for n taut of N cables: ``F`` (rows, columns of a form, LANES) forms with the rows of ``TABLE``, of
which only the first lane is looked at; ``polynomial`` (6 + n, terms), ``sways`` (6 + n, symbols of points and
load), ``radii`` (6 + n,) a tube's; ``frame``
is a ``fields.FrameBounds``, ``model`` is an ``arrays.Model``; bounds ``b`` (2,), ``M`` (3, 3, 2).
"""

from __future__ import annotations

from typing import Any

from numba import types

from cdpr_interval.engine.rows import Table
from cdpr_interval.kernels import interval
from cdpr_interval.kernels.kernel import entry, kernel
from cdpr_interval.kernels.lanes import Lanes, load, splat, store, where_less
from cdpr_interval.kernels.rounding import down_lanes, inflate_lanes, up_lanes
from cdpr_interval.kernels.second_order import (
    Forms,
    Symbols,
    add_datum,
    add_scaled,
    bounds,
    close,
    combine2,
    combine3,
    constant,
    copy,
    dot3,
    largest,
    multiply,
    scale,
    signatures,
    widen,
)
from cdpr_interval.mechanics.rotation import HALF_TURNS
from cdpr_interval.mechanics.six_dof import form_system as base
from cdpr_interval.mechanics.six_dof.form_system import (
    ALL_DATA,
    CENTRE_DATA,
    MOST_UNKNOWNS,
    ROTATION,
    SCALE,
    TERM,
    Z,
    rotation_forms,
    shift,
)

TABLE = Table(base.TABLE.ranges)
INVERSE = TABLE.take("INVERSE")
"""1 / s."""
TURN = TABLE.take("TURN", 9)
"""R(u) D_c, row by row."""
MOVED = TABLE.take("MOVED", 9)
"""That times the rotation of the platform's frame, column by column."""
OWN = TABLE.take("OWN", 9)
"""The rotation in the robot's frames, row by row."""
CENTRE = TABLE.take("CENTRE", 3)
"""The centre of mass in the robot's frame."""
PLACE = TABLE.take("PLACE", 3)
SPOKE = TABLE.take("SPOKE", 3)
OUT = TABLE.take("OUT")
LANE = 0
"""The lane that is looked at."""


@kernel(signatures(types.void, types.int64, types.int64))
def invert(F: Forms, out: int, a: int, S: Symbols) -> None:
    """Set ``out`` to 1 / F[a] for a form that is positive, another row; infinite where that is not proved.

    With a = c (1 + x) and y = (1 - x + x^2) / c the product a y is 1 - x^3 up to errors: 1 / a = y / (1 - r)
    for r = 1 - a y, so that |1 / a - y| <= |y| |r| / (1 - |r|).
    """
    inverse = 1.0 / load(F, a, 0)
    scale(F, TERM, a, inverse, S)
    shift(F, TERM, -1.0, 0.0, S)
    multiply(F, out, TERM, TERM, 1.0, S)
    add_scaled(F, out, TERM, splat(-1.0), S)
    shift(F, out, 1.0, 0.0, S)
    scale(F, out, out, inverse, S)
    multiply(F, TERM, a, out, -1.0, S)
    shift(F, TERM, 1.0, 0.0, S)
    rest = largest(F, TERM, S)
    error = up_lanes(up_lanes(largest(F, out, S) * rest) / down_lanes(1.0 - rest))
    widen(F, out, where_less(rest, 0.5, error, 1e300), S)


@kernel()
def place_tube(F: Forms, polynomial: Any, sways: Any, radii: Any, S: Symbols) -> None:
    """Write a tube to the unknowns Z, its box as errors."""
    K = len(S.noise)
    Q = 1 + K + K * (K + 1) // 2
    for c in range(radii.shape[0]):
        constant(F, Z + c, splat(polynomial[c, 0]), splat(radii[c]), S)
        for q in range(Q):
            store(F, Z + c, q, splat(polynomial[c, q]))
        for q in range(sways.shape[1]):
            store(F, Z + c, Q + 3 + MOST_UNKNOWNS + q, splat(sways[c, q]))
        close(F, Z + c, S)


@kernel()
def middle(b: Any) -> float:
    """Return the middle of bounds (2,)."""
    return 0.5 * b[0] + 0.5 * b[1]


@kernel()
def error_of(b: Any) -> float:
    """Return a bound of the distance of bounds (2,) from their middle."""
    m = 0.5 * b[0] + 0.5 * b[1]
    return max(b[1] - m, m - b[0]) * (1.0 + 1e-15) + 1e-300


@kernel()
def row_of(M: Any, i: int) -> tuple[Lanes, Lanes, Lanes, float]:
    """Return the middles of row i of bounds (3, 3, 2), and a bound of the sum of their errors."""
    off = error_of(M[i, 0]) + error_of(M[i, 1]) + error_of(M[i, 2])
    return splat(middle(M[i, 0])), splat(middle(M[i, 1])), splat(middle(M[i, 2])), off


@kernel()
def column_of(M: Any, j: int) -> tuple[Lanes, Lanes, Lanes, float]:
    """Return the middles of column j of bounds (3, 3, 2), and a bound of the sum of their errors."""
    off = error_of(M[0, j]) + error_of(M[1, j]) + error_of(M[2, j])
    return splat(middle(M[0, j])), splat(middle(M[1, j])), splat(middle(M[2, j])), off


@kernel()
def robot_rotation(F: Forms, chart: int, frame: Any, S: Symbols) -> None:
    """Write the rotation in the model's and in the robot's frames; its entries are at most 1."""
    invert(F, INVERSE, SCALE, S)
    turn0, turn1 = (1.0 if chart < 2 else -1.0), (1.0 if chart == 0 or chart == 2 else -1.0)
    for i in range(3):
        for j in range(3):
            sign = turn0 if j == 0 else (turn1 if j == 1 else turn0 * turn1)
            multiply(F, TURN + 3 * i + j, ROTATION + 3 * i + j, INVERSE, sign, S)
    if frame.plain:
        for k in range(9):
            copy(F, OWN + k, TURN + k, S)
        return
    for j in range(3):
        p0, p1, p2, off = column_of(frame.platform, j)
        for i in range(3):
            combine3(F, MOVED + 3 * j + i, TURN + 3 * i, p0, p1, p2, splat(1.01 * off), S)
    for i in range(3):
        b0, b1, b2, off = row_of(frame.back, i)
        for j in range(3):
            combine3(F, OWN + 3 * i + j, MOVED + 3 * j, b0, b1, b2, splat(1.01 * off), S)


@kernel()
def robot_centre(F: Forms, frame: Any, S: Symbols) -> None:
    """Write the centre of mass in the robot's frame."""
    most = splat(0.0)
    for k in range(3):
        most += largest(F, Z + 3 + k, S)
    for i in range(3):
        if frame.plain:
            copy(F, CENTRE + i, Z + 3 + i, S)
            continue
        b0, b1, b2, off = row_of(frame.back, i)
        error = inflate_lanes(most * off, splat(0.0), 10.0)
        combine3(F, CENTRE + i, Z + 3, b0, b1, b2, error, S)
        shift(F, CENTRE + i, -middle(frame.minus_origin[i, 0]), error_of(frame.minus_origin[i, 0]), S)


@kernel()
def write_bounds(F: Forms, row: int, out: Any, S: Symbols) -> None:
    """Write the bounds of a row to out (2,)."""
    lo, hi = bounds(F, row, S)
    store(F, OUT, 0, lo)
    store(F, OUT, 1, hi)
    out[0], out[1] = F[OUT, 0, LANE], F[OUT, 1, LANE]


@kernel()
def distance(F: Forms, model: Any, i: int, out: Any, S: Symbols) -> None:
    """Write the bounds of the distance of the middle points of a cable of the model to out (2,)."""
    off = model.arms_err[i, 0] + model.arms_err[i, 1] + model.arms_err[i, 2]
    # Chart 0: the half turn is in the rotation.
    b0, b1, b2 = splat(model.arms[0, i, 0]), splat(model.arms[0, i, 1]), splat(model.arms[0, i, 2])
    one = splat(1.0)
    for k in range(3):
        combine3(F, SPOKE + k, TURN + 3 * k, b0, b1, b2, splat(1.01 * off), S)
        combine2(F, SPOKE + k, SPOKE + k, one, Z + 3 + k, one, S)
        shift(F, SPOKE + k, -model.exits[i, k], model.exits_err[i, k], S)
    dot3(F, TERM, SPOKE, SPOKE, S)
    write_bounds(F, TERM, out, S)
    out[0], out[1] = interval.sqrt(max(out[0], 0.0), max(out[1], 0.0))


@entry()
def fill_tube_fields(
    F: Any,
    S: Any,
    model: Any,
    cables: Any,
    frame: Any,
    chart: int,
    polynomial: Any,
    sways: Any,
    radii: Any,
    order: Any,
    fields: Any,
    m: int,
) -> None:
    """Fill row ``m`` of ``fields`` for all poses of one tube.

    Parameters
    ----------
    cables
        ``fields.Cables``, of the middles of the data.
    order : (N,)
        Which cable of the robot each cable of the model is; the first n are taut.
    fields
        ``Fields``, written but for tensions and verdict; distances are those of the middle points.
    """
    place_tube(F, polynomial, sways, radii, S)
    rotation_forms(F, S)
    robot_rotation(F, chart, frame, S)
    robot_centre(F, frame, S)
    minus = splat(-1.0)
    for i in range(3):
        for j in range(3):
            write_bounds(F, OWN + 3 * i + j, fields.rotation[m, i, j], S)
            fields.rotation[m, i, j, 0] = max(fields.rotation[m, i, j, 0], -1.0)
            fields.rotation[m, i, j, 1] = min(fields.rotation[m, i, j, 1], 1.0)
        off, c = 0.0, cables.centre
        along = len(S.data) == ALL_DATA and frame.plain
        for k in range(3):
            # Of a range: what moves the arms moves the origin, too.
            off += error_of(c[k, 0]) - (model.centre_sides[k] if along else 0.0)
        off = max(off, 0.0)
        g0, g1, g2 = splat(middle(c[0, 0])), splat(middle(c[1, 0])), splat(middle(c[2, 0]))
        combine3(F, PLACE + i, OWN + 3 * i, g0, g1, g2, splat(1.01 * off), S)
        if along:
            for k in range(3):
                # The arms' entries in the chart grow by the side, times a symbol: the centre's shrink.
                turned = HALF_TURNS[chart, k] * model.centre_sides[k]
                add_datum(F, PLACE + i, OWN + 3 * i + k, CENTRE_DATA + k, -turned, S)
        combine2(F, PLACE + i, CENTRE + i, splat(1.0), PLACE + i, minus, S)
        write_bounds(F, PLACE + i, fields.position[m, i], S)
    up, off = cables.up[0], 0.0
    most = splat(0.0)
    for k in range(3):
        most += largest(F, CENTRE + k, S)
        off += error_of(up[k])
    error = inflate_lanes(most * off, splat(0.0), 10.0)
    u0, u1, u2 = splat(middle(up[0])), splat(middle(up[1])), splat(middle(up[2]))
    combine3(F, TERM, CENTRE, u0, u1, u2, error, S)
    write_bounds(F, TERM, fields.height[m], S)
    for i in range(order.shape[0]):
        distance(F, model, i, fields.distances[m, order[i]], S)
    for j in range(fields.densities.shape[1]):
        write_bounds(F, Z + 6 + j, fields.densities[m, j], S)
