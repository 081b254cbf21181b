"""Solved equations as the checker of certificates solves them, and cells cut to what they allow.

A form is bounded by its value and the sizes of its coefficients, and the equations are solved for the symbols
that complete pivoting chooses, or a cut would not be confirmed. Nothing here needs to be rigorous.

Arrays: as in ``cells.tests``; ``notes`` (rows, columns + 1 + data), those of the batch from ``first``.
"""

from __future__ import annotations

from typing import Any

from numba import types

from cdpr_interval.engine.batch_cells import mark
from cdpr_interval.engine.contraction import blank, eliminate, is_pivot
from cdpr_interval.engine.rows import EQUATION, MOST_PIVOTS, NO_LENGTH, OPEN, PIVOT, PIVOTS, SMALLER, TABLEAU
from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LANES, LaneArray, Lanes, array3, lanes, load, splat, store, where_less
from cdpr_interval.kernels.second_order import Forms, Symbols, add_scaled, constant, signatures
from cdpr_interval.mechanics.six_dof.rows import CENTRE_OF, CHANGE_OF, PASSED, TIE

TIED = 1e-9
"""Of pivots that differ by less the checker may choose another one."""
NO_PIVOT = 1e-9
"""Pivots below this share of the first one are taken for rounding: the equations depend on each other."""
USEFUL_CUT = 0.7
"""A cut is made when some entry keeps at most this share of its width."""
WIDER = 1e-9
"""A kept interval is widened by this share of its width, so that the checker confirms it."""
ROUNDING = 2.0**-40
"""And by this share of itself, or of 1 where it is less: so much the checker may lose in rounding."""


@kernel(signatures(lanes, types.int64))
def change(F: Forms, row: int, S: Symbols) -> Lanes:
    """Return the sum of the sizes of a form's coefficients but its value."""
    K, P = len(S.noise), len(S.data)
    Q = 1 + K + K * (K + 1) // 2
    total = load(F, row, Q) + load(F, row, Q + 1) + load(F, row, Q + 2)
    if P > 0:
        total += load(F, row, Q + 3 + P)
    return total


@kernel("i8(f8[:, :, ::1], i8, i8, i8)")
def choose_pivots(W: LaneArray, lane: int, count: int, symbols: int) -> int:
    """Run Gauss-Jordan with complete pivoting on a lane's tableau of full rank; return the rank, or 0."""
    for s in range(count):
        W[PIVOTS, s, lane] = -1.0
    W[PASSED, TIE, lane] = 0.0
    largest = 0.0
    for rank in range(count):
        best, second, line, column = 0.0, 0.0, -1, -1
        for e in range(rank, count):
            for k in range(symbols):
                size = abs(W[TABLEAU + e, k, lane])
                if size >= best and not is_pivot(W, lane, k):
                    second, best, line, column = best, size, e, k
                elif not is_pivot(W, lane, k):
                    second = max(second, size)
        largest = max(largest, best)
        if second >= (1.0 - TIED) * best:
            W[PASSED, TIE, lane] = 1.0
        if not best > NO_PIVOT * largest:
            for s in range(count):
                W[PIVOTS, s, lane] = -1.0
            return 0
        eliminate(W, lane, rank, line, column, count, symbols + count)
        W[PIVOTS, rank, lane] = column
    return count


@kernel(signatures(types.int64, array3, types.int64))
def solve_as_checked(F: Forms, W: LaneArray, count: int, S: Symbols) -> int:
    """Solve the rows EQUATION.. for as many symbols, where they are independent; return the most of a lane.

    Writes PIVOT.. and W[PIVOTS] as ``contraction.solve_for_pivots`` does.
    """
    K = len(S.noise)
    for s in range(MOST_PIVOTS):
        store(W, PIVOTS, s, -1.0)
    for e in range(count):
        for k in range(K):
            store(W, TABLEAU + e, k, load(F, EQUATION + e, 1 + k))
        for j in range(count):
            store(W, TABLEAU + e, K + j, 1.0 if e == j else 0.0)
    most = 0
    for lane in range(LANES):
        most = max(most, choose_pivots(W, lane, count, K))
    for s in range(most):
        constant(F, PIVOT + s, splat(0.0), splat(0.0), S)
        for j in range(count):
            add_scaled(F, PIVOT + s, EQUATION + j, load(W, TABLEAU + s, K + j), S)
        blank(F, PIVOT + s, load(W, PIVOTS, s) + 1.0, S)
    return most


@kernel()
def exclude_by_lengths(F: Forms, W: LaneArray, rows: int, count: int, states: Any, S: Symbols) -> None:
    """Mark as NO_LENGTH the open lanes in which a form that vanishes at solutions has no zero."""
    for e in range(count):
        distance = abs(load(F, rows + e, 0)) - change(F, rows + e, S)
        mark(W, where_less(0.0, distance, splat(1.0), 0.0), states, NO_LENGTH)


@kernel()
def cut(
    F: Forms,
    W: LaneArray,
    C: LaneArray,
    variables: int,
    rank: int,
    wider: float,
    states: Any,
    notes: Any,
    first: int,
    count: int,
    S: Symbols,
) -> None:
    """Cut the open lanes to what the solved equations allow, where that is useful: they become SMALLER.

    The bounds that are left are written to the data of the notes, behind the columns of a cell of so many
    ``variables``; whether pivots are tied follows. ``wider`` : the rests of the equations count by so much
    more.
    """
    data = notes.shape[1] - 2 * variables - 1
    for lane in range(count):
        for k in range(2 * variables):
            notes[first + lane, data + k] = C[0, k, lane]
        notes[first + lane, data + 2 * variables] = W[PASSED, TIE, lane]
    for s in range(rank):
        centre, size = load(F, PIVOT + s, 0), change(F, PIVOT + s, S)
        store(W, PASSED, CENTRE_OF, centre)
        store(W, PASSED, CHANGE_OF, size)
        for lane in range(count):
            k = int(W[PIVOTS, s, lane])
            if (states[lane] != OPEN and states[lane] != SMALLER) or k < 0 or k >= variables:
                continue
            lo, hi, slope = C[0, 2 * k, lane], C[0, 2 * k + 1, lane], F[PIVOT + s, 1 + k, lane]
            if not (lo < hi and slope > 0.0):
                continue
            c, rest = W[PASSED, CENTRE_OF, lane], wider * (W[PASSED, CHANGE_OF, lane] - abs(slope))
            middle, radius = 0.5 * (lo + hi), 0.5 * (hi - lo) / slope
            slack = WIDER * (hi - lo) + ROUNDING * max(abs(lo), abs(hi), 1.0)
            low = max(lo, middle - radius * (c + rest) - slack) + 0.0
            high = min(hi, middle - radius * (c - rest) + slack) + 0.0
            if low < high and high - low <= USEFUL_CUT * (hi - lo):
                states[lane] = SMALLER
                notes[first + lane, data + 2 * k] = low
                notes[first + lane, data + 2 * k + 1] = high
