"""The point of a cell's wrenches' convex hull that is nearest to the origin: a direction y for Gordan's test.

Where the normalised wrenches and the load are independent, a linear solve gives y. Where they are not
(cables in a plane, parallel cables, a symmetric pose), no y has prescribed products with all of them; one
with positive products still exists unless some non-negative tensions balance the load, and the nearest
point is the best of them: its least product with a normalised wrench is the largest.
"""

from __future__ import annotations

from numba import types

from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray

INT = types.int64
WEIGHT, TRIAL, CHOSEN, TABLEAU = 7, 8, 9, 10
"""Columns of the first rows of W: weights of the wrenches, a step's weights, 1 where chosen, its system."""
TOLERANCE = 1e-9
"""A wrench that would shorten y by less (relative) is not taken in."""
LEAST = 1e-13
"""Least pivot of the normalised system; below it the wrenches chosen are dependent."""


@kernel(types.void(types.Array(types.float64, 3, "C"), INT, INT, INT))
def fill_products(W: LaneArray, columns: int, lane: int, m: int) -> None:
    """Write 1 + c_i . c_j of the columns c_i = W[columns + i, 0..5] to W[i, j], and weights of zero."""
    for i in range(m):
        for j in range(m):
            s = 1.0
            for k in range(6):
                s += W[columns + i, k, lane] * W[columns + j, k, lane]
            W[i, j, lane] = s
        W[i, WEIGHT, lane] = 0.0
        W[i, CHOSEN, lane] = 0.0


@kernel(types.boolean(types.Array(types.float64, 3, "C"), INT, INT))
def solve_chosen(W: LaneArray, lane: int, m: int) -> bool:
    """Write to W[i, TRIAL] the weights that solve the system of the chosen wrenches; False where singular."""
    for i in range(m):
        for j in range(m):
            both = W[i, CHOSEN, lane] > 0.0 and W[j, CHOSEN, lane] > 0.0
            W[i, TABLEAU + j, lane] = W[i, j, lane] if both else (1.0 if i == j else 0.0)
        W[i, TRIAL, lane] = 1.0 if W[i, CHOSEN, lane] > 0.0 else 0.0
    for k in range(m):
        pivot = W[k, TABLEAU + k, lane]
        if not pivot > LEAST:
            return False
        for i in range(m):
            if i != k:
                f = W[i, TABLEAU + k, lane] / pivot
                if f != 0.0:
                    for j in range(k + 1, m):
                        W[i, TABLEAU + j, lane] -= f * W[k, TABLEAU + j, lane]
                    W[i, TRIAL, lane] -= f * W[k, TRIAL, lane]
    for i in range(m):
        W[i, TRIAL, lane] /= W[i, TABLEAU + i, lane]
    return True


@kernel(types.int64(types.Array(types.float64, 3, "C"), INT, INT))
def most_useful(W: LaneArray, lane: int, m: int) -> int:
    """Return the wrench whose product with y is smallest beyond those chosen; -1 when none is below them."""
    best, chosen = TOLERANCE, -1
    for i in range(m):
        if W[i, CHOSEN, lane] > 0.0:
            continue
        gain = 1.0
        for j in range(m):
            gain -= W[i, j, lane] * W[j, WEIGHT, lane]
        if gain > best:
            best, chosen = gain, i
    return chosen


@kernel(types.void(types.Array(types.float64, 3, "C"), INT, INT))
def step(W: LaneArray, lane: int, m: int) -> None:
    """Move the weights towards the step's, as far as none becomes negative; one that vanishes is given up."""
    share, leaving = 1.0, -1
    for i in range(m):
        if W[i, CHOSEN, lane] > 0.0 and not W[i, TRIAL, lane] > 0.0:
            a = W[i, WEIGHT, lane] / (W[i, WEIGHT, lane] - W[i, TRIAL, lane])
            if leaving < 0 or a < share:
                share, leaving = a, i
    for i in range(m):
        if W[i, CHOSEN, lane] > 0.0:
            W[i, WEIGHT, lane] += share * (W[i, TRIAL, lane] - W[i, WEIGHT, lane])
    if leaving >= 0:
        W[leaving, WEIGHT, lane] = 0.0
        W[leaving, CHOSEN, lane] = 0.0


@kernel(types.void(types.Array(types.float64, 3, "C"), INT, INT, INT, INT))
def nearest_point(W: LaneArray, columns: int, y: int, lane: int, m: int) -> None:
    """Write to row ``y`` of W a positive multiple of the point nearest to the origin, for one lane.

    Lawson and Hanson's active set for min |sum x_i c_i|^2 + (1 - sum x_i)^2, x >= 0. A guess: what it
    proves is decided by the forms y . w.
    """
    fill_products(W, columns, lane, m)
    for _ in range(3 * m):
        taken = most_useful(W, lane, m)
        if taken < 0:
            break
        W[taken, CHOSEN, lane] = 1.0
        done = False
        for _ in range(m):
            if not solve_chosen(W, lane, m):
                W[taken, CHOSEN, lane] = 0.0
                W[taken, WEIGHT, lane] = 0.0
                done = True
                break
            inside = True
            for i in range(m):
                inside = inside and (W[i, CHOSEN, lane] == 0.0 or W[i, TRIAL, lane] > 0.0)
            step(W, lane, m)
            if inside:
                break
        if done:
            break
    for k in range(6):
        s = 0.0
        for i in range(m):
            s += W[i, WEIGHT, lane] * W[columns + i, k, lane]
        W[y, k, lane] = s
