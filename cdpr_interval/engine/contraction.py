"""Forms that vanish at every solution of a cell: solved for symbols, added to others, used to shrink it.

The rows EQUATION.. hold such forms. Solved by Gauss-Jordan for as many symbols as they fix (the rows
PIVOT..), they can be added to any other form in any multiple without changing its value at a solution: that
takes the fixed symbols out of it, as if they had been eliminated, and needs no proof but the sum itself.

Arrays: ``F`` (rows, columns of a form, LANES) forms, ``W`` (rows, columns, LANES) scratch, both with the
rows of ``engine.rows``; ``C`` (1, width of a cell, LANES) cells, one column of a cell a row of lanes; ``S``
the symbols.
"""

from __future__ import annotations

from typing import Any

from numba import types

from cdpr_interval.engine.rows import (
    CUT,
    EMPTY,
    EQUATION,
    FLAGS,
    HIGH,
    LOW,
    MARKED,
    MOST_PIVOTS,
    PIVOT,
    PIVOTS,
    SCRATCH,
    SMALLER,
    SYSTEM,
    TABLEAU,
    VERDICTS,
    WEIGHTS,
)
from cdpr_interval.kernels.dense import solve_definite
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, array3, lanes, load, splat, store, where_less
from cdpr_interval.kernels.rounding import down, inflate_lanes, up, up_lanes
from cdpr_interval.kernels.second_order import (
    POSE_AND_ALL_DATA,
    POSE_AND_DATA,
    ROTATION_AND_ALL_DATA,
    ROTATION_AND_DATA,
    ROTATION_ONLY,
    WHOLE_POSE,
    Forms,
    Symbols,
    add_scaled,
    bounds,
    columns,
    constant,
    scale,
    signatures,
    type_of,
    widen,
    zeros,
)

VARIABLES_OF_ROTATION = (0, 0, 0)
VARIABLES_OF_POSE = (0, 0, 0, 0, 0, 0)
"""Variables of the searches in u and in (u, x), an entry each."""
WORTH = 0.6
"""A contraction counts as SMALLER when one variable keeps at most this share of its width."""
LEAST_PIVOT = 1e-3
"""Least pivot, relative to its row, that is taken: a smaller one would only spread noise."""


def contraction_signatures(*arguments: Any) -> list[Any]:
    """Return signatures on forms, ``arguments``, V and S, for the variables of each number of symbols.

    Loops over the variables must have a length known to the compiler, as those over symbols have: of one that
    it had unrolled by 8, LLVM has been seen to drop the guard for fewer (numba 0.68, llvmlite 0.50).
    """
    pairs = (
        (VARIABLES_OF_ROTATION, ROTATION_ONLY),
        (VARIABLES_OF_ROTATION, ROTATION_AND_DATA),
        (VARIABLES_OF_ROTATION, ROTATION_AND_ALL_DATA),
        (VARIABLES_OF_POSE, WHOLE_POSE),
        (VARIABLES_OF_POSE, POSE_AND_DATA),
        (VARIABLES_OF_POSE, POSE_AND_ALL_DATA),
    )
    return [types.void(array3, *arguments, zeros(len(v)), type_of(symbols)) for v, symbols in pairs]


@kernel(signatures(lanes, types.int64))
def noise(F: Forms, i: int, S: Symbols) -> Lanes:
    """Return quadratic part + error of a row (rounded to nearest)."""
    K = len(S.noise)
    Q = 1 + K + K * (K + 1) // 2
    return load(F, i, Q) + load(F, i, Q + 2)


@kernel(signatures(lanes, types.int64))
def usefulness(F: Forms, i: int, S: Symbols) -> Lanes:
    """Return 1 over the largest slope of a row, or 0 where its noise drowns it.

    An equation like 0 = 0 on a symmetry would only add noise.
    """
    most = splat(0.0)
    for k in range(len(S.noise)):
        slope = abs(load(F, i, 1 + k))
        most = where_less(most, slope, slope, most)
    useful = where_less(noise(F, i, S), most, 1.0 / most, 0.0)
    return where_less(1e-100, most, where_less(most, 1e100, useful, 0.0), 0.0)


@kernel(signatures(lanes, types.int64))
def cannot_vanish(F: Forms, i: int, S: Symbols) -> Lanes:
    """Return 1 where a row is zero nowhere in the cell, else 0."""
    below, above = bounds(F, i, S)
    return where_less(0.0, below, 1.0, where_less(above, 0.0, splat(1.0), 0.0))


@kernel("b1(f8[:, :, ::1], i8, i8)")
def is_pivot(W: LaneArray, lane: int, symbol: int) -> bool:
    """Return True when a symbol is one of a lane's pivots."""
    found = False
    for s in range(MOST_PIVOTS):
        found = found or W[PIVOTS, s, lane] == symbol
    return found


@kernel("void(f8[:, :, ::1], i8, i8, i8, i8, i8, i8)")
def eliminate(W: LaneArray, lane: int, target: int, line: int, column: int, lines: int, columns: int) -> None:
    """Bring line ``line`` of a lane's tableau to place ``target`` and clear ``column`` in all others."""
    for k in range(columns):
        a, b = W[TABLEAU + target, k, lane], W[TABLEAU + line, k, lane]
        W[TABLEAU + target, k, lane], W[TABLEAU + line, k, lane] = b, a
    pivot = W[TABLEAU + target, column, lane]
    for k in range(columns):
        W[TABLEAU + target, k, lane] /= pivot
    for e in range(lines):
        factor = W[TABLEAU + e, column, lane]
        if e != target and factor != 0.0:
            for k in range(columns):
                W[TABLEAU + e, k, lane] -= factor * W[TABLEAU + target, k, lane]


@kernel("i8(f8[:, :, ::1], i8, i8, i8, i8)")
def pivot_lane(W: LaneArray, lane: int, count: int, variables: int, symbols: int) -> int:
    """Run Gauss-Jordan with full pivoting on one lane's tableau; return its rank."""
    for s in range(MOST_PIVOTS):
        W[PIVOTS, s, lane] = -1.0
    rank = 0
    while rank < count:
        best, line, column = LEAST_PIVOT, -1, -1
        for e in range(rank, count):
            for k in range(variables):
                if abs(W[TABLEAU + e, k, lane]) > best and not is_pivot(W, lane, k):
                    best, line, column = abs(W[TABLEAU + e, k, lane]), e, k
        if line < 0:
            break
        eliminate(W, lane, rank, line, column, count, symbols + count)
        W[PIVOTS, rank, lane] = column
        rank += 1
    for s in range(rank, count):
        for j in range(count):
            W[TABLEAU + s, symbols + j, lane] = 0.0
    return rank


@kernel(signatures(types.void, types.int64, lanes))
def blank(F: Forms, row: int, keep: Lanes, S: Symbols) -> None:
    """Set a row to zero, the equation 0 = 0, in the lanes where ``keep`` is not positive."""
    for k in range(columns(S)):
        store(F, row, k, where_less(0.0, keep, load(F, row, k), 0.0))


@kernel(signatures(types.int64, array3, types.int64, types.int64, types.int64))
def solve_for_pivots(F: Forms, W: LaneArray, first: int, count: int, variables: int, S: Symbols) -> int:
    """Solve up to six rows EQUATION + first.. for symbols below ``variables``.

    Returns the most solved in a lane. Writes the solved rows to PIVOT.. (slope 1 in their own pivot, about
    0 in the others', zero where a lane has fewer) and the pivots to W[PIVOTS]. Rows whose noise drowns their
    slopes are left out.
    """
    K = len(S.noise)
    for e in range(count):
        row = EQUATION + first + e
        useful = usefulness(F, row, S)
        for k in range(K):
            store(W, TABLEAU + e, k, load(F, row, 1 + k) * useful)
        for j in range(count):
            store(W, TABLEAU + e, K + j, 0.0)
        store(W, TABLEAU + e, K + e, useful)
    most = 0
    for lane in range(LANES):
        most = max(most, pivot_lane(W, lane, count, variables, K))
    for s in range(most):
        constant(F, PIVOT + s, splat(0.0), splat(0.0), S)
        for j in range(count):
            add_scaled(F, PIVOT + s, EQUATION + first + j, load(W, TABLEAU + s, K + j), S)
        # Where a lane has fewer, the roundings of others' pivots must not stay.
        blank(F, PIVOT + s, load(W, PIVOTS, s) + 1.0, S)
    return most


@kernel(signatures(lanes, types.int64, array3, types.int64))
def pivot_slope(F: Forms, row: int, W: LaneArray, s: int, S: Symbols) -> Lanes:
    """Return every lane's slope of a row in its pivot ``s``; 0 where it has none."""
    K = len(S.noise)
    pivot = load(W, PIVOTS, s)
    slope = splat(0.0)
    for k in range(K):
        slope = where_less(abs(pivot - float(k)), 0.5, load(F, row, 1 + k), slope)
    return slope


@kernel(signatures(types.void, types.int64, array3, types.int64))
def reduce_row(F: Forms, out: int, W: LaneArray, rank: int, S: Symbols) -> None:
    """Add multiples of the solved rows to ``out`` so that the pivots' slopes vanish.

    A lane with fewer pivots keeps its row bit by bit, or its error would depend on its neighbours.
    """
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    for s in range(rank):
        error, linear, quadratic = load(F, out, Q), load(F, out, Q + 1), load(F, out, Q + 2)
        slopes = load(F, out, Q + 3 + P) if P > 0 else error
        pivot = load(W, PIVOTS, s)
        add_scaled(F, out, PIVOT + s, -pivot_slope(F, out, W, s, S), S)
        store(F, out, Q, where_less(pivot, 0.0, error, load(F, out, Q)))
        store(F, out, Q + 1, where_less(pivot, 0.0, linear, load(F, out, Q + 1)))
        store(F, out, Q + 2, where_less(pivot, 0.0, quadratic, load(F, out, Q + 2)))
        if P > 0:
            store(F, out, Q + 3 + P, where_less(pivot, 0.0, slopes, load(F, out, Q + 3 + P)))


@kernel(signatures(types.UniTuple(lanes, 2), lanes))
def rest_bounds(F: Forms, symbol: Lanes, S: Symbols) -> tuple[Lanes, Lanes]:
    """Return bounds of eps_symbol, lane by lane, from SCRATCH: a form that vanishes, with slope near 1.

    eps = -(row - eps). A negative ``symbol`` gives (-1, 1) and more.
    """
    K = len(S.noise)
    Q = 1 + K + K * (K + 1) // 2
    change = splat(0.0)
    for k in range(K):
        slope = load(F, SCRATCH, 1 + k)
        mine = where_less(abs(symbol - float(k)), 0.5, 1.0, 0.0)
        store(F, SCRATCH, 1 + k, slope - mine)
        change = where_less(0.5, mine, abs(slope) + 1.0, change)
    # The rounding of slope - 1, and the kept sum of slopes, which must stay above the true one.
    widen(F, SCRATCH, inflate_lanes(splat(0.0), change, 4.0), S)
    store(F, SCRATCH, Q + 1, up_lanes(load(F, SCRATCH, Q + 1) + 1.0))
    lo, hi = bounds(F, SCRATCH, S)
    return -hi, -lo


@kernel("b1(f8, f8)")
def shrunk(now: float, before: float) -> bool:
    """Return True when a width is worth another look: really smaller, also among denormals."""
    return bool(now < before and now <= WORTH * before)


@kernel("b1(f8[:, :, ::1], i8, i8, f8, f8)")
def cut(C: LaneArray, lane: int, j: int, low: float, high: float) -> bool:
    """Cut the variable with bounds in columns j, j + 1 to symbols in [low, high]; True if much is gone."""
    lo, hi = C[0, j, lane], C[0, j + 1, lane]
    m = 0.5 * (lo + hi)
    half = max(up(hi - m), up(m - lo))
    C[0, j, lane] = max(lo, down(m + down(half * low)))
    C[0, j + 1, lane] = min(hi, up(m + up(half * high)))
    if C[0, j, lane] > C[0, j + 1, lane]:
        # Only by rounding at a corner, where no solution is: one point keeps the cell well formed.
        C[0, j + 1, lane] = C[0, j, lane]
    return shrunk(C[0, j + 1, lane] - C[0, j, lane], hi - lo)


@kernel("void(f8[:, :, ::1], f8[:, :, ::1], i8, i8, f8, f8)")
def cut_symbol(W: LaneArray, C: LaneArray, lane: int, symbol: int, low: float, high: float) -> None:
    """Cut a lane's variable to eps in [low, high]; its verdict becomes EMPTY, stays, or becomes SMALLER."""
    if not C[0, 2 * symbol, lane] < C[0, 2 * symbol + 1, lane] or W[VERDICTS, 0, lane] == EMPTY:
        return
    if low > 1.0 or high < -1.0:
        W[VERDICTS, 0, lane] = EMPTY
    elif (low > -1.0 or high < 1.0) and cut(C, lane, 2 * symbol, max(low, -1.0), min(high, 1.0)):
        W[VERDICTS, 0, lane] = SMALLER


@kernel(signatures(types.void, array3, array3, types.int64))
def cut_pivots(F: Forms, W: LaneArray, C: LaneArray, rank: int, S: Symbols) -> None:
    """Shrink each pivot's variable to what its solved row allows; see ``cut_symbol``."""
    for s in range(rank):
        scale(F, SCRATCH, PIVOT + s, splat(1.0), S)
        low, high = rest_bounds(F, load(W, PIVOTS, s), S)
        store(W, CUT, LOW, low)
        store(W, CUT, HIGH, high)
        for lane in range(LANES):
            symbol = int(W[PIVOTS, s, lane])
            if symbol >= 0:
                cut_symbol(W, C, lane, symbol, W[CUT, LOW, lane], W[CUT, HIGH, lane])


@kernel(contraction_signatures(array3, array3, types.int64))
def contract(F: Forms, W: LaneArray, C: LaneArray, count: int, V: tuple[int, ...], S: Symbols) -> None:
    """Shrink the cells by all rows EQUATION.. at once (interval Newton); see ``cut_symbol``.

    ``V`` has an entry for each variable; symbol k stands for that with bounds in columns 2 k, 2 k + 1. With
    g the rows' centres, A their slopes, N their remaining terms and C a float left inverse of A,
    eps = -C g - (C A - I) eps - C N bounds every symbol. A row that cannot vanish empties its cell: near a
    fold its slopes are small and it would get no weight.
    """
    variables = len(V)
    for e in range(count):
        store(W, FLAGS, MARKED, cannot_vanish(F, EQUATION + e, S))
        for lane in range(LANES):
            if W[FLAGS, MARKED, lane] > 0.0:
                W[VERDICTS, 0, lane] = EMPTY
    for k in range(variables):
        for m in range(variables):
            store(W, SYSTEM + k, m, 0.0)
    for e in range(count):
        row = EQUATION + e
        useful = usefulness(F, row, S)
        store(W, WEIGHTS, e, useful * useful)
        for k in range(variables):
            for m in range(variables):
                term = load(F, row, 1 + k) * load(F, row, 1 + m) * load(W, WEIGHTS, e)
                store(W, SYSTEM + k, m, load(W, SYSTEM + k, m) + term)
    for k in range(variables):
        # A variable without width stays out of the way.
        lone = where_less(load(C, 0, 2 * k), load(C, 0, 2 * k + 1), 0.0, 1.0)
        store(W, SYSTEM + k, k, load(W, SYSTEM + k, k) + lone)
        for e in range(count):
            right = load(F, EQUATION + e, 1 + k) * load(W, WEIGHTS, e)
            store(W, SYSTEM + k, variables + e, right)
    solve_definite(W, SYSTEM, variables, count)
    for k in range(variables):
        constant(F, SCRATCH, splat(0.0), splat(0.0), S)
        for e in range(count):
            add_scaled(F, SCRATCH, EQUATION + e, load(W, SYSTEM + k, variables + e), S)
        low, high = rest_bounds(F, splat(float(k)), S)
        store(W, CUT, LOW, low)
        store(W, CUT, HIGH, high)
        for lane in range(LANES):
            cut_symbol(W, C, lane, k, W[CUT, LOW, lane], W[CUT, HIGH, lane])
