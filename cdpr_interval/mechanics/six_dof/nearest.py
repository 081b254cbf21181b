"""The point of a cell's wrenches' convex hull that is nearest to the origin: a direction y for Gordan's test.

Where the normalised wrenches and the load are independent, a linear solve gives y. Where they are not
(cables in a plane, parallel cables, a symmetric pose), no y has prescribed products with all of them; one
with positive products still exists unless some non-negative tensions balance the load, and the nearest
point is the best of them: its least product with a normalised wrench is the largest.

Arrays: ``W`` (rows, columns, LANES) scratch with the rows of ``rows``; its rows COLUMNS.. hold the m
columns.
"""

from __future__ import annotations

from numba import types

from cdpr_interval.kernels.kernel import kernel
from cdpr_interval.kernels.lanes import LaneArray, array3
from cdpr_interval.mechanics.six_dof.rows import (
    CHOSEN,
    CHOSEN_SYSTEM,
    COLUMNS,
    DIMENSIONS,
    HULL,
    TRIAL,
    WEIGHT,
    Y,
)

INT = types.int64
TOLERANCE = 1e-9
"""A wrench that would shorten y by less (relative) is not taken in."""
LEAST = 1e-13
"""Least pivot of the normalised system; below it the wrenches chosen are dependent."""


@kernel(types.void(array3, INT, INT))
def fill_products(W: LaneArray, lane: int, m: int) -> None:
    """Write 1 + c_i . c_j of the columns to W[HULL + i, j], and weights of zero."""
    for i in range(m):
        for j in range(m):
            s = 1.0
            for k in range(DIMENSIONS):
                s += W[COLUMNS + i, k, lane] * W[COLUMNS + j, k, lane]
            W[HULL + i, j, lane] = s
        W[HULL + i, WEIGHT, lane] = 0.0
        W[HULL + i, CHOSEN, lane] = 0.0


@kernel(types.boolean(array3, INT, INT))
def solve_chosen(W: LaneArray, lane: int, m: int) -> bool:
    """Write the weights that solve the system of the chosen wrenches to TRIAL; False where it is singular."""
    for i in range(m):
        for j in range(m):
            both = W[HULL + i, CHOSEN, lane] > 0.0 and W[HULL + j, CHOSEN, lane] > 0.0
            entry = W[HULL + i, j, lane] if both else (1.0 if i == j else 0.0)
            W[HULL + i, CHOSEN_SYSTEM + j, lane] = entry
        W[HULL + i, TRIAL, lane] = 1.0 if W[HULL + i, CHOSEN, lane] > 0.0 else 0.0
    for k in range(m):
        pivot = W[HULL + k, CHOSEN_SYSTEM + k, lane]
        if not pivot > LEAST:
            return False
        for i in range(m):
            if i != k:
                f = W[HULL + i, CHOSEN_SYSTEM + k, lane] / pivot
                if f != 0.0:
                    for j in range(k + 1, m):
                        W[HULL + i, CHOSEN_SYSTEM + j, lane] -= f * W[HULL + k, CHOSEN_SYSTEM + j, lane]
                    W[HULL + i, TRIAL, lane] -= f * W[HULL + k, TRIAL, lane]
    for i in range(m):
        W[HULL + i, TRIAL, lane] /= W[HULL + i, CHOSEN_SYSTEM + i, lane]
    return True


@kernel(types.int64(array3, INT, INT))
def most_useful(W: LaneArray, lane: int, m: int) -> int:
    """Return the wrench whose product with y is smallest beyond those chosen; -1 when none is below them."""
    best, chosen = TOLERANCE, -1
    for i in range(m):
        if W[HULL + i, CHOSEN, lane] > 0.0:
            continue
        gain = 1.0
        for j in range(m):
            gain -= W[HULL + i, j, lane] * W[HULL + j, WEIGHT, lane]
        if gain > best:
            best, chosen = gain, i
    return chosen


@kernel(types.void(array3, INT, INT))
def step(W: LaneArray, lane: int, m: int) -> None:
    """Move the weights towards the step's, as far as none becomes negative; one that vanishes is given up."""
    share, leaving = 1.0, -1
    for i in range(m):
        if W[HULL + i, CHOSEN, lane] > 0.0 and not W[HULL + i, TRIAL, lane] > 0.0:
            a = W[HULL + i, WEIGHT, lane] / (W[HULL + i, WEIGHT, lane] - W[HULL + i, TRIAL, lane])
            if leaving < 0 or a < share:
                share, leaving = a, i
    for i in range(m):
        if W[HULL + i, CHOSEN, lane] > 0.0:
            W[HULL + i, WEIGHT, lane] += share * (W[HULL + i, TRIAL, lane] - W[HULL + i, WEIGHT, lane])
    if leaving >= 0:
        W[HULL + leaving, WEIGHT, lane] = 0.0
        W[HULL + leaving, CHOSEN, lane] = 0.0


@kernel(types.void(array3, INT, INT))
def nearest_point(W: LaneArray, lane: int, m: int) -> None:
    """Write to W[Y] a positive multiple of the point nearest to the origin, for one lane.

    Lawson and Hanson's active set for min |sum x_i c_i|^2 + (1 - sum x_i)^2, x >= 0. A guess: what it
    proves is decided by the forms y . w.
    """
    fill_products(W, lane, m)
    for _ in range(3 * m):
        taken = most_useful(W, lane, m)
        if taken < 0:
            break
        W[HULL + taken, CHOSEN, lane] = 1.0
        done = False
        for _ in range(m):
            if not solve_chosen(W, lane, m):
                W[HULL + taken, CHOSEN, lane] = 0.0
                W[HULL + taken, WEIGHT, lane] = 0.0
                done = True
                break
            inside = True
            for i in range(m):
                inside = inside and (W[HULL + i, CHOSEN, lane] == 0.0 or W[HULL + i, TRIAL, lane] > 0.0)
            step(W, lane, m)
            if inside:
                break
        if done:
            break
    for k in range(DIMENSIONS):
        s = 0.0
        for i in range(m):
            s += W[HULL + i, WEIGHT, lane] * W[COLUMNS + i, k, lane]
        W[Y, k, lane] = s
